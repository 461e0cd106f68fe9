"""Commands of a command line and their options, from its parser."""

import argparse
from collections.abc import Mapping


def commands(parser: argparse.ArgumentParser) -> Mapping[str, argparse.ArgumentParser]:
    """Return the commands of a parser by name, those its help lists."""
    groups = [one for one in parser._actions if isinstance(one, argparse._SubParsersAction)]
    return {listed.dest: group.choices[listed.dest] for group in groups for listed in group._choices_actions}


def long_options(parser: argparse.ArgumentParser) -> list[str]:
    """Return the long options of a command."""
    return [name for one in parser._actions for name in one.option_strings if name.startswith("--")]
