"""How often Python looks for garbage in a command, which imports this before all else."""

import gc

YOUNG = 100_000
"""New objects after which it looks; by its default, 700, that takes a twelfth of a command's time."""

gc.set_threshold(YOUNG)
