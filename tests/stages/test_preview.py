"""What is known of a study before anything is solved."""

import re
import shutil
from pathlib import Path

import pytest
from conftest import SMALL_PLAN, varied

from vsb.errors import ConfigError, DatabaseError
from vsb.stages import preview
from vsb.study.plan import StudyPlan


def test_finished_work_is_counted_as_there(small, tmp_path, monkeypatch):
    there = preview.summary(small.study, small)
    monkeypatch.chdir(tmp_path)
    before = preview.summary(small.study, small)
    blocks = len(small.bem_blocks)
    assert any(f"BEM jobs     {blocks} of {blocks} to do" in line for line in before)
    assert any(f"BEM jobs     0 of {blocks} to do" in line for line in there)
    assert any(line.endswith("(there)") for line in there)
    assert not any(line.endswith("(there)") for line in before)
    assert any("witness      none: hydro.witness: none" in line for line in there)
    assert there[0].startswith("study        small: FSB, VSWEC in ")


def test_files_that_cannot_be_read_are_found_before_any_job(small, finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(finished / "results", "results")
    preview.check_before_run(small.study, small)
    for path in (small.radiation_path, small.block_path(small.sweep_blocks[0]), small.database_path):
        Path(path).write_bytes(b"none")
        with pytest.raises(DatabaseError, match=f"{path}: cannot be read as netCDF"):
            preview.check_before_run(small.study, small)


def test_designs_that_leave_nothing_free_are_found_before_any_job():
    study = varied(SMALL_PLAN.study, designs={"A": {"clamp": list(range(0, 181, 30))}})
    with pytest.raises(ConfigError, match="clamp"):
        preview.check_before_run(study, StudyPlan(study))


def test_panels_are_counted_by_rows(seed):
    study = varied(seed, hydro={"rows": 20, "omega_max": 6.0})
    lines = preview.summary(study, StudyPlan(study))
    assert any("20 rows of 40 panels" in line for line in lines)
    assert any("shapes at 3 frequencies by 32 rows" in line for line in lines)


def test_a_job_of_panels_costs_its_frequencies_and_the_square_of_its_rows(seed):
    one, *_ = StudyPlan(varied(seed, hydro={"rows": 20, "omega_max": 6.0})).sweep_blocks
    rows = one.mesh.rows + one.mesh.lid_rows
    finer = one.model_copy(update={"mesh": one.mesh.model_copy(update={"rows": one.mesh.rows + 2 * rows})})
    longer = one.model_copy(update={"omega": 3 * one.omega})
    seconds = preview._block_seconds(one)
    assert seconds == pytest.approx(preview.SECONDS_PER_PANEL_ROW2 * len(one.omega) * rows**2)
    assert [preview._block_seconds(other) / seconds for other in (finer, longer)] == pytest.approx([9.0, 3.0])


SAID = {
    "seed": (
        {},
        """study        seed: FSB, VSWEC, VSWEC0, VSWEC90 in regular_A0.179_T2.5
modes        7 shell modes (membrane, degree 6)
hydro        128 frequencies up to 12 rad/s, spectral, to 0.001
BEM jobs     1 of 1 to do, at most about 2 s on one core
database     results/hydro/db/{id}.nc
witness      15 shapes at 3 frequencies by 32 rows and the spectral solver, about 12 s on one core
steepness = 0.0367 (limit 0.05)""",
    ),
    "panels": (
        {"hydro": {"rows": 20, "omega_max": 6.0, "witness": "none"}, "waves": [{"kind": "still"}]},
        """study        seed: FSB, VSWEC, VSWEC0, VSWEC90 in still
modes        7 shell modes (membrane, degree 6)
hydro        65 frequencies up to 6 rad/s, 20 rows of 40 panels
BEM jobs     3 of 3 to do, at most about 3 s on one core
database     results/hydro/db/{id}.nc
witness      none: hydro.witness: none""",
    ),
    "dry": (
        {"hydro": {"model": "assumed_pressure", "pressure": 1800.0}},
        """study        seed: FSB, VSWEC, VSWEC0, VSWEC90 in regular_A0.179_T2.5
modes        7 shell modes (membrane, degree 6)
hydro        assumed pressure: no BEM""",
    ),
    "irregular": (
        {"waves": [{"kind": "jonswap", "hs": 1, "tp": 6}], "pto": {"law": "latching"}},
        """study        seed: FSB, VSWEC, VSWEC0, VSWEC90 in jonswap_Hs1_Tp6_g3.3_s1
modes        7 shell modes (membrane, degree 6)
hydro        128 frequencies up to 12 rad/s, spectral, to 0.001
BEM jobs     1 of 1 to do, at most about 2 s on one core
database     results/hydro/db/{id}.nc
witness      15 shapes at 3 frequencies by 32 rows and the spectral solver, about 12 s on one core
pauses       of latching, found in each run: together about 36 s on one core, up to 288 s where motions from rest take less than the trials promise
steepness = 0.0178 (limit 0.05)
spectrum_cut = 4.75e-05 (limit 0.01)""",
    ),
}  # fmt: skip
"""Changes of the seed's study, and what is said of it beforehand; checks without verdict and words."""


@pytest.mark.parametrize("name", SAID)
def test_what_is_said_of_a_study_before_it_runs(seed, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vsb.results.ledger.shell_checks", lambda *_: [])
    study = varied(seed, **SAID[name][0])
    plan = StudyPlan(study)
    told = [re.sub(r"^(?:ok|doubt|fail) +|: (?:wave|share) .*", "", line) for line in preview.summary(study, plan)]
    expected = SAID[name][1].replace("{id}", Path(plan.database_path).stem)
    assert "\n".join(told) == expected


def test_what_pauses_cost_is_said_of_laws_that_pause(seed):
    """Of four designs: five seconds each in a regular wave, twice that with its damper, more on the wet shell (twenty)
    and in long seas (of sixty seconds: 0.15 and 0.5 each)."""

    def said(waves, hydro=None, **pto):
        study = varied(seed, pto=pto, waves=waves, hydro=hydro or {})
        return [line for line in preview.summary(study, StudyPlan(study)) if line.startswith("pauses")]

    regular, still = {"kind": "regular", "amplitude": 0.1, "period": 5.0}, {"kind": "still"}
    assert said([regular]) == []
    assert "together about 0 s" in said([still], law="latching")[0]
    words = (
        "pauses       of latching, found in each run: together about {} s on one core, up to {} s where motions from "
        "rest take less than the trials promise"
    )
    assert said([regular, still], law="latching") == [words.format(20, 160)]
    assert said([regular], law="latching", damping=None, tuning="each") == [words.format(40, 320)]
    sea = {"kind": "jonswap", "hs": 0.3, "tp": 5.0}
    assert said([sea], law="latching") == [words.format(36, 288)]
    assert said([regular], {"model": "body_exact"}, law="latching") == [words.format(100, 800)]
    assert said([sea], {"model": "body_exact"}, law="latching") == [words.format(156, 1248)]


def test_the_shell_in_words_is_the_shell_in_numbers(seed):
    table = preview.shell_table(seed)
    text = preview.shell_text(table).splitlines()
    assert len(text) == len(table["membrane"]) + 2
    assert [int(line.split()[0]) for line in text[1:-1]] == [row["degree"] for row in table["membrane"]]
    assert text[1].split()[2] == "-"  # no bending of degree 0
    assert float(text[3].split()[2]) == pytest.approx(table["bending"][0]["omega"], rel=1e-9)
    assert text[-1] == f"classical buckling pressure {table['buckling_pressure']:.6g} Pa"
