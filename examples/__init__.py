"""Examples, each with a command line of its own."""

import argparse
from collections.abc import Callable, Sequence
from functools import partial

from vsb.cli import Handler, answer


def command(
    name: str, words: str | None, handler: Handler, writes: str = "", **places: str
) -> Callable[[Sequence[str] | None], int]:
    """Return the command line of an example: its arguments and how help calls them, those with ... of any number.

    `writes` is the folder of its results, "{out}/", with the argument that names it; tables check their place.
    """
    line = argparse.ArgumentParser(prog=f"python -m examples.{name}", description=words)
    for place, metavar in places.items():
        line.add_argument(place, metavar=metavar.removesuffix("..."), nargs="*" if metavar.endswith("...") else None)
    line.set_defaults(handler=handler, writes={writes: ""} if writes else {})
    return partial(answer, line)
