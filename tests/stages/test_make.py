"""What is said of a run by Snakemake, from its output."""

import re

import pytest
from conftest import SEED, varied

from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.jobs import jobs, rules
from vsb.stages.make import Progress, followed
from vsb.study.study import load

OUTPUT = """Execute 2 jobs...

[Sun Nov 29 03:29:08 2026]
localrule spectral:
    output: results/hydro/blocks/1d74f99cdcc297d0.nc (update)
    log: results/logs/spectral/seed.log
    jobid: 3
    reason: Missing output files: results/hydro/blocks/1d74f99cdcc297d0.nc
    resources: tmpdir=/tmp, runtime=30, mem_mb=812, mem=812 MB, mem_mib=775
[Sun Nov 29 03:29:18 2026]
Finished jobid: 3 (Rule: spectral)
1 of 9 steps (11%) done
[Sun Nov 29 03:29:18 2026]
rule simulate:
    jobid: 4
    wildcards: job=FSB-still
    resources: tmpdir=/tmp, runtime=30
[Sun Nov 29 03:30:36 2026]
localrule all:
    jobid: 0
    resources: tmpdir=/tmp
Finished jobid: 0 (Rule: all)
9 of 9 steps (100%) done
"""


def test_lines_say_what_begins_what_is_done_and_the_time_left(capsys):
    """Tests the form of Snakemake 9's lines, which may change."""
    plan, kept = StudyPlan(varied(load(SEED), modes={"degree": 4})), []
    progress = Progress("seed", [job.seconds for job in jobs(plan)])
    followed(OUTPUT.splitlines(keepends=True), progress, rules(plan), kept, lambda: "best so far: 3 kW")
    assert "".join(kept) == OUTPUT
    first, *others = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"seed: 0 of 8 done, about \d+ s left; all frequencies by the spectral solver", first)
    assert others[0] == others[2] == "seed: best so far: 3 kW"
    assert re.fullmatch(r"seed: 1 of 8 done, about \d+ s left; designs in seas, simulated in time FSB-still", others[1])
    assert len(others) == 3


@pytest.mark.parametrize(("done", "elapsed", "words"), [(0, 0.0, "40 s"), (2, 20.0, "20 s"), (2, 50.0, "40 s")])
def test_time_left_follows_the_pace_of_the_run(capsys, monkeypatch, done, elapsed, words):
    """Of 40 s of work: none is done; half of it, on time; half of it, late."""
    monkeypatch.setattr("time.monotonic", lambda: elapsed)
    Progress("seed", [10.0, 10.0, 20.0], begun=0.0).begin("results", range(done))
    assert f"about {words} left; results" in capsys.readouterr().err
