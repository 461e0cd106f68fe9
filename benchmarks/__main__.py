"""Command line of the benchmarks: `python -m benchmarks COMMAND`, from the checkout."""

import argparse
import importlib
import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from vsb.cli import answer
from vsb.study.study import load


class Command(NamedTuple):
    """A command: runs `benchmark` of the module of its name."""

    text: str
    arguments: tuple[str, ...]  # the last is what is written
    reads: Callable[[str], Any] = str  # the first argument
    fails: Callable[[Any], bool] = lambda found: False  # of what it returns: exit code 1


COMMANDS = {
    "coefficients": Command(
        "Error against seconds and memory of coefficients by six methods: a table.", ("out",),
        fails=lambda rows: any(row["status"].startswith("failed") for row in rows),
    ),
    "time-domain": Command(
        "Error against seconds of every integrator and radiation model: a table.", ("config", "out"), load,
    ),
    "growth": Command(
        "How processor time grows with duration, frequencies, modes, designs and points: a table.", ("out",),
    ),
    "shares": Command("Which parts of whole commands take their processor time: a table.", ("out",)),
    "machine": Command("The machine and the versions that the others measure: a table.", ("out",)),
    "hard-cases": Command(
        "Run every hard case and write a table; 1 if any ends in garbage or otherwise than expected.",
        ("config", "out"), fails=lambda rows: any(row.verdict == "wrong" for row in rows),
    ),
    "torture": Command(
        "So many studies at random: each is refused in one line or runs to finite results; 1 if any does not.",
        ("count", "out"), int, fails=bool,
    ),
    "cluster": Command(
        "A campaign on a Slurm of one node, killed and resumed: seconds, and whether the bytes are the same; 1 if not.",
        ("folder",), fails=lambda rows: any(row.verdict.startswith("other") for row in rows),
    ),
    "damage": Command(
        "So many flipped bits, and half as many edits of JSON, in finished results: none is silent; 1 if one is.",
        ("count", "out"), int, fails=bool,
    ),
}  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Run a benchmark and print what was written; 1 if something is not as it should be."""
    one: Command = args.benchmark
    first, *others = (getattr(args, name) for name in one.arguments)
    found = importlib.import_module(f"benchmarks.{args.module}").benchmark(one.reads(first), *others)
    return int(one.fails(found))


def parser() -> argparse.ArgumentParser:
    """Return the argument parser."""
    top = argparse.ArgumentParser(prog="python -m benchmarks", description="Work and precision, and hard cases.")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, one in COMMANDS.items():
        words = one.text.partition(":")[0].rstrip(".")
        command = commands.add_parser(name, help=words, description=one.text)
        for argument in one.arguments:
            command.add_argument(argument, metavar="OUT.csv" if argument == "out" else argument.upper())
        module = name.replace("-", "_")
        writes = {"{folder}/": ""} if one.arguments[-1] == "folder" else {}
        command.set_defaults(handler=run, benchmark=one, module=module, writes=writes)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one benchmark; a user's mistake is one line and exit code 2."""
    return answer(parser(), argv)


if __name__ == "__main__":
    sys.exit(main())
