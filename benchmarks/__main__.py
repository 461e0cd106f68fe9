"""Command line of the benchmarks: `python -m benchmarks COMMAND`, from the checkout."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from vsb.cli import answer
from vsb.study.study import load


def integrators(args: argparse.Namespace) -> int:
    """Error against seconds of wet forces and integrators, on the designs of a study under assumed pressure."""
    from benchmarks import integrators

    integrators.benchmark(load(args.config), args.folder)
    return _written(args.folder, "workprecision*")


def coefficients(args: argparse.Namespace) -> int:
    """Error against seconds and memory of coefficients by six methods: tables and a figure; takes minutes."""
    from benchmarks import coefficients

    rows = coefficients.benchmark(args.folder)
    _written(args.folder, "hydro_precision*")
    return int(any(row["status"].startswith("failed") for row in rows))


def memories(args: argparse.Namespace) -> int:
    """Passivity, error and order against seconds of radiation memories of many motions by three fits: a table."""
    from benchmarks import memories

    memories.benchmark(args.folder)
    return _written(args.folder, "memories*")


def bodies(args: argparse.Namespace) -> int:
    """Panels against the spectral solver, memories against convolutions: error, seconds and ratio; takes minutes."""
    from benchmarks import bodies

    bodies.benchmark(args.folder)
    return _written(args.folder, "bodies*")


def take_offs(args: argparse.Namespace) -> int:
    """Best take-offs of four designs in 200 seas against plain searches: seconds, ratio and error, a table."""
    from benchmarks import take_offs

    take_offs.benchmark(args.folder)
    return _written(args.folder, "take_offs*")


def time_domain(args: argparse.Namespace) -> int:
    """Error against seconds of every integrator and radiation model, cost against size: a table and two figures."""
    from benchmarks import time_domain

    time_domain.benchmark(load(args.config), args.folder)
    return _written(args.folder, "time_*")


def hard_cases(args: argparse.Namespace) -> int:
    """Run every hard case and write a table; 1 if any ends in garbage or otherwise than expected."""
    from benchmarks import hard_cases

    rows = hard_cases.hard_cases(args.config, args.out)
    print(hard_cases.as_text(rows))
    return int(any(row.verdict == "wrong" for row in rows))


def torture(args: argparse.Namespace) -> int:
    """So many studies at random: each is refused in one line or runs to finite results; 1 if any does not."""
    from benchmarks import torture

    found = torture.torture(int(args.count), args.out)
    print(", ".join(f"{number} {verdict}" for verdict, number in found.most_common()))
    return int(any(found[verdict] for verdict in torture.BAD))


def campaigns(args: argparse.Namespace) -> int:
    """Year, dampers and sweep of a campaign against plain loops: a table with seconds of both and their difference."""
    from benchmarks import campaigns

    campaigns.benchmark(args.config, args.folder)
    return _written(args.folder, "campaigns*")


def cluster(args: argparse.Namespace) -> int:
    """A campaign on a Slurm of one node, killed and resumed: seconds, and whether bytes are the same; 1 if not."""
    from benchmarks import cluster

    rows = cluster.benchmark(args.folder)
    return int(any(row.verdict.startswith("other") for row in rows))


def kills(args: argparse.Namespace) -> int:
    """So many runs of a campaign killed at random instants and resumed: the same bytes as undisturbed; 1 if not."""
    from benchmarks import kills

    rows = kills.benchmark(args.folder, int(args.count))
    return int(any(row.verdict != "the same bytes" for row in rows))


def damage(args: argparse.Namespace) -> int:
    """So many flipped bits, and half as many edits of JSON, in finished results: none is silent; 1 if one is."""
    from benchmarks import damage

    found = damage.damage(int(args.count), int(args.count) // 2, args.out)
    print(", ".join(f"{number} {verdict}" for verdict, number in found.most_common()))
    return int(any(found[verdict] for verdict in damage.BAD))


def _written(folder: str, names: str) -> int:
    """Print what was written; return 0."""
    print(*sorted(Path(folder).glob(names)), sep="\n")
    return 0


COMMANDS = {
    "integrators": (integrators, ("config", "folder")),
    "coefficients": (coefficients, ("folder",)),
    "memories": (memories, ("folder",)),
    "bodies": (bodies, ("folder",)),
    "take-offs": (take_offs, ("folder",)),
    "time-domain": (time_domain, ("config", "folder")),
    "hard-cases": (hard_cases, ("config", "out")),
    "torture": (torture, ("count", "out")),
    "campaigns": (campaigns, ("config", "folder")),
    "cluster": (cluster, ("folder",)),
    "kills": (kills, ("count", "folder")),
    "damage": (damage, ("count", "out")),
}
"""Handler and arguments of every benchmark."""
WRITES = {"folder": "{folder}/", "out": "{out}"}


def parser() -> argparse.ArgumentParser:
    """Return the argument parser."""
    top = argparse.ArgumentParser(prog="python -m benchmarks", description="Work and precision, and hard cases.")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, (handler, arguments) in COMMANDS.items():
        words = (handler.__doc__ or "").partition(":")[0].rstrip(".")
        one = commands.add_parser(name, help=words, description=handler.__doc__)
        for argument in arguments:
            one.add_argument(argument, metavar="OUT.csv" if argument == "out" else argument.upper())
        one.set_defaults(handler=handler, writes=(WRITES[arguments[-1]],))
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one benchmark; a user's mistake is one line and exit code 2."""
    return answer(parser(), argv)


if __name__ == "__main__":
    sys.exit(main())
