"""Completion of the command line."""

import subprocess
from pathlib import Path

from vsb.cli import main


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
