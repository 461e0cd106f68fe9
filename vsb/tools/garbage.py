"""How often Python looks for garbage that counting references does not find."""

import gc

NEW = 100_000
"""Objects made since the last search that call for one. Python's own 700 let it look through all that was imported
again and again: a tenth of the time of imports, a quarter of the time of figures."""


def collected_seldom() -> None:
    """Search for reference cycles a hundred times less often than Python does: a process that ends soon has few."""
    gc.set_threshold(NEW)
