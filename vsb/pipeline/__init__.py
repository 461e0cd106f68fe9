"""The graph of any file: its tasks, told once in `graph`, `campaign_plan` and `design_plan`; their jobs, rules, costs.

Everything else follows from `plan.tasks`: what a run makes, in which order, and what it has left to do.
"""
