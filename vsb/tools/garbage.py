"""How often Python looks for garbage that counting references does not find."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

NEW = 100_000
"""Objects made since the last search that call for one. Python's own 700 let it look through all that was imported
again and again: a tenth of the time of imports, a quarter of the time of figures."""


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Search for reference cycles a hundred times less often than Python does, and not at all in what is left at last.

    A process that ends has few; at its end Python would look through all that was imported once more, 0.2 s.
    """
    gc.set_threshold(NEW)
    try:
        yield
    finally:
        gc.freeze()
