"""A campaign as a user runs it: dry run, run, second run, and Snakemake's own report."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from stages.test_members import BASE, with_seas

from vsb.tools.shipped import HOME


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = with_seas(tmp_path_factory.mktemp("year"), (1.0, 6.0), (2.2, 9.0), (3.1, 12.0))
    (place / "seed.yaml").write_text(yaml.safe_dump(BASE))
    given = {"campaign": "soft", "study": "seed.yaml", "climate": {"spectra": "sea.txt"}, "tuning": ["one"]}
    given["vary"] = {"device.young_modulus": [1e6, 1e7]}
    (place / "soft.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    return place


def output_of(place, *command):
    """Output of a command, which must succeed."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout + done.stderr


def vsb(place, *options):
    return output_of(place, sys.executable, "-m", "vsb.cli", "run", "soft.yaml", *options)


def jobs(text):
    """Number of jobs of each rule in a dry run."""
    rows = re.findall(r"^(members|campaign|all|total) +(\d+)$", text, re.MULTILINE)
    return {rule: int(count) for rule, count in rows}


def test_campaign_from_plan_to_report(folder):
    out = vsb(folder, "--cores", "2", "--verbose")
    assert jobs(out) == {"members": 1, "campaign": 1, "all": 1, "total": 3}
    assert len(re.findall(r"Finished jobid", out)) == 3
    assert "\x1b" not in out  # progress is for terminals
    assert "results/soft/report.html" in out
    assert "Nothing to be done" in vsb(folder, "-n")


@pytest.mark.slow
def test_snakemakes_report_has_captions_and_categories(folder):
    """Of all outputs of a campaign."""
    vsb(folder, "--cores", "2")
    options = ("--snakefile", str(HOME / "workflow" / "Snakefile"), "--configfile", "soft.yaml", "--cores", "1")
    output_of(folder, sys.executable, "-m", "snakemake", *options, "--workflow-profile", "none", "--report", "all.html")
    text = (folder / "all.html").read_text()
    for part in ("The answer of campaign soft", "A figure of campaign soft", "every point, design and tuning"):
        assert part in text
    assert all(f'"{category}"' in text for category in ("The answer", "Numbers", "Figures"))
