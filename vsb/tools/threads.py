"""One thread a process in a run, which has a process for every core: threads of small matrices only wait.

OpenBLAS reads their number once, when NumPy is loaded: the command line imports this before anything that needs NumPy.
"""

import os
import sys

RUNS = ("run", "design")
"""Commands that have a process for every core; `vsb body` has one, whose large matrices gain from threads."""


def one_thread() -> None:
    """Have libraries that are loaded from now on, here and in processes to come, use one thread, or the number set."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")


if sys.argv[1:2] and sys.argv[1] in RUNS:
    one_thread()
