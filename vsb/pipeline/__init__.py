"""The graph of any file: its tasks, in `graph` and `plans`; their jobs, rules and costs.

Everything else follows from `plan.tasks`: what a run makes, in which order, and what it has left to do.
"""
