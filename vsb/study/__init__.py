"""The files a user writes: a study of a buoy or a body, a campaign; what they ask for, and the plan of its jobs.

Pure Python, read at every parse of the Snakefile: no numpy, nothing that solves.
May import `vsb.errors` and `vsb.tools`.
"""
