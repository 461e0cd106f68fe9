"""Loops that numba compiles when they are first called: most commands call none, and do not import it.

What one loop alone calls has `inline="always"`: else it is compiled by itself and once more within the loop.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, TypeVar

from vsb.tools.arrays import FloatArray

Loop = TypeVar("Loop", bound=Callable[..., Any])


class _Compiled:
    """A loop, with all attributes of numba's: loops that call it find its type and its options there."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        """Name it as the function."""
        self.options = options
        update_wrapper(self, function)

    @cached_property
    def loop(self) -> Any:
        """Numba's."""
        from vsb.tools.compiler import compiled

        return compiled(self.__wrapped__, **self.options)

    def __call__(self, *values: Any) -> Any:
        """Compile the loop for values of these types, if it is not yet, and run it."""
        return self.loop(*values)

    def __getattr__(self, name: str) -> Any:
        """Look up what is not here."""
        return getattr(self.loop, name)


def njit(**options: Any) -> Callable[[Loop], Loop]:
    """Return a decorator like numba's with these options, for loops that are kept between runs."""
    return lambda function: _Compiled(function, options)  # type: ignore[return-value]


@njit(cache=True)
def assign(out: FloatArray, source: FloatArray) -> None:
    """Copy an array of one dimension: `out[:] = source`, which takes numba a second more to compile."""
    for i in range(len(out)):
        out[i] = source[i]
