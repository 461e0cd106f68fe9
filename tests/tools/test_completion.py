"""Completion of the command line."""

import argparse
import subprocess
from pathlib import Path

from vsb.cli import main
from vsb.tools.completion import commands, options, script, words


def test_completion_offers_commands_options_choices_and_files(workplace, capsys):
    assert main(["completion", "bash"]) == 0
    Path("completion.sh").write_text(capsys.readouterr().out)

    def offered(*words):
        line = f"COMP_WORDS=({' '.join(['vsb', *words])}); COMP_CWORD={len(words)}"
        ask = f'source completion.sh; {line}; _vsb; echo "${{COMPREPLY[@]}}"'
        return subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True).stdout.split()

    assert offered("che") == ["check"]
    assert offered("sim") == []  # rules are for the workflow
    assert offered("run", "--p") == ["--profile"]
    assert set(offered("schema", "bo")) == {"body", "body-study"}
    assert offered("check", "fi") == ["file"]


def parsed():
    """A parser of two commands its help lists and one it does not."""
    parser = argparse.ArgumentParser(prog="buoy")
    group = parser.add_subparsers()
    sail = group.add_parser("sail", help="go")
    sail.add_argument("where", choices=["out", "home"])
    sail.add_argument("-f", "--fast", "--quick", action="store_true")
    sail.add_argument("--how", choices=["near", "far"])
    group.add_parser("sink", help="go down").add_argument("depth")
    group.add_parser("hidden")
    return parser


def test_a_command_offers_its_long_options_and_the_words_of_its_arguments():
    """Not one letter, nor the words of an option, which stand behind it."""
    found = commands(parsed())
    assert list(found) == ["sail", "sink"]
    assert options(found["sail"]) == ["--help", "--fast", "--quick", "--how"]
    assert words(found["sail"]) == ["out", "home", "--help", "--fast", "--quick", "--how"]
    assert words(found["sink"]) == ["--help"]


def test_the_first_word_is_a_command_or_an_option_of_none_in_either_shell():
    for shell, first in (("bash", False), ("zsh", True)):
        text = script(parsed(), shell)
        assert 'words="sail sink --help --version"\n' in text
        assert (
            '            sail) words="out home --help --fast --quick --how" ;;\n            sink) words="--help" ;;'
            in text
        )
        assert text.endswith("complete -o filenames -F _buoy buoy\n")
        assert ("autoload -Uz bashcompinit && bashcompinit" in text) is first
