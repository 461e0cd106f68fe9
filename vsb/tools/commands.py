"""What a command line needs: its commands and their options, and what the package brings along."""

import argparse
from collections.abc import Mapping
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
HOME = next((home for home in (_PACKAGE, _PACKAGE.parent) if (home / "workflow" / "Snakefile").is_file()), _PACKAGE)
"""Folder of `workflow`, `profiles` and `config`: a wheel holds them inside the package, a checkout beside it."""


def commands(parser: argparse.ArgumentParser) -> Mapping[str, argparse.ArgumentParser]:
    """Return the commands of a parser by name, those its help lists."""
    groups = [one for one in parser._actions if isinstance(one, argparse._SubParsersAction)]
    return {listed.dest: group.choices[listed.dest] for group in groups for listed in group._choices_actions}


def long_options(parser: argparse.ArgumentParser) -> list[str]:
    """Return the long options of a command."""
    return [name for one in parser._actions for name in one.option_strings if name.startswith("--")]
