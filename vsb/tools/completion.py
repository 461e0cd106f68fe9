"""Shell completion of a command line, written from its parser."""

import argparse
from collections.abc import Mapping

_SCRIPT = """\
# Completion of {prog}: source this, or put it where bash looks for completions.{zsh}
_{prog}() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" words=""
    if [ "$COMP_CWORD" -eq 1 ]; then
        words="{commands}"
    else
        case "${{COMP_WORDS[1]}}" in
{cases}
        esac
        case "$word" in
            -*) ;;
            *) COMPREPLY=($(compgen -W "$words" -- "$word") $(compgen -f -- "$word")); return ;;
        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o filenames -F _{prog} {prog}
"""
SHELLS = {"bash": "", "zsh": "\nautoload -Uz bashcompinit && bashcompinit"}
"""Shells, and what each needs first."""


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the completion of a parser's commands, their options and choices, and of file names."""
    found = commands(parser)
    cases = "\n".join(f'            {name}) words="{" ".join(words(one))}" ;;' for name, one in found.items())
    return _SCRIPT.format(
        prog=parser.prog, commands=" ".join([*found, "--help", "--version"]), cases=cases, zsh=SHELLS[shell]
    )


def commands(parser: argparse.ArgumentParser) -> Mapping[str, argparse.ArgumentParser]:
    """Return the commands of a parser by name, those its help lists."""
    groups = [one for one in parser._actions if isinstance(one, argparse._SubParsersAction)]
    return {listed.dest: group.choices[listed.dest] for group in groups for listed in group._choices_actions}


def words(parser: argparse.ArgumentParser) -> list[str]:
    """Return the options of a command, and the words its arguments may be."""
    choices = [str(choice) for one in parser._actions if not one.option_strings for choice in one.choices or ()]
    return [*choices, *options(parser)]


def options(parser: argparse.ArgumentParser) -> list[str]:
    """Return the long options of a command."""
    return [name for one in parser._actions for name in one.option_strings if name.startswith("--")]
