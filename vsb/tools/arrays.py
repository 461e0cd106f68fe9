"""Types of arrays by what they hold, and large ones in parts."""

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.floating[Any]]
ComplexArray = npt.NDArray[np.complexfloating[Any, Any]]
IntArray = npt.NDArray[np.integer[Any]]
BoolArray = npt.NDArray[np.bool_]
AnyArray = npt.NDArray[Any]

AT_ONCE = 1_000_000
"""Values that are worked on at once: 16 megabytes of complex ones."""


def in_parts(count: int, size: int) -> list[slice]:
    """Return slices of items of so many values each: parts of at most `AT_ONCE` values, or of one item."""
    some = max(1, AT_ONCE // max(1, size))
    return [slice(first, first + some) for first in range(0, count, some)]
