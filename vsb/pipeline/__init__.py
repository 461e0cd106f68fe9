"""The graph of a plan: its tasks, the jobs they are done in, what these cost, and the rules Snakemake reads.

Everything else follows from `tasks.tasks(plan)`: what a run makes, in which order, and what it has left to do.
"""
