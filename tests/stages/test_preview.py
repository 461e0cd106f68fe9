"""What is known of a study before anything is solved."""

import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import SMALL_PLAN, varied

from vsb.errors import ConfigError, DatabaseError
from vsb.shell.modes import mode_basis
from vsb.shell.sphere import Shell, natural_frequencies
from vsb.stages import preview
from vsb.study.plan import StudyPlan
from vsb.study.study import Study


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
    assert said([regular, still, sea], law="latching") == [words.format(20 + 36, 8 * 56)]


def test_the_shell_in_words_is_the_shell_in_numbers(seed):
    table = preview.shell_table(seed)
    text = preview.shell_text(table).splitlines()
    assert len(text) == len(table["membrane"]) + 2
    assert [int(line.split()[0]) for line in text[1:-1]] == [row["degree"] for row in table["membrane"]]
    assert text[1].split()[2] == "-"  # no bending of degree 0
    assert float(text[3].split()[2]) == pytest.approx(table["bending"][0]["omega"], rel=1e-9)
    assert text[-1] == f"classical buckling pressure {table['buckling_pressure']:.6g} Pa"
    assert text[0].split() == ["n", "membrane", "bending", "paper", "Ritz", "[rad/s]"]
    natural = {"natural": [{"mode": "Shell1", "omega": 12.25}, {"mode": "Shell2", "omega": 30.5}]}
    head, *rows = (line.split() for line in preview.shell_text(natural).splitlines())
    assert head == ["mode", "natural", "[rad/s]"]
    assert [(mode, float(omega)) for mode, omega in rows] == [("Shell1", 12.25), ("Shell2", 30.5)]


CHECKS = {
    "check_stable": preview,
    "check_spring": preview,
    "check_rests": preview,
    "check_waves": StudyPlan,
    "check_record": Study,
    "check_dampers": Study,
}
"""What is asked before anything runs, and where it is asked of."""


def asked_before(study, monkeypatch):
    """Names of the checks that are made of a study, with what each is given beside itself."""
    asked = []
    for name, place in CHECKS.items():
        monkeypatch.setattr(place, name, lambda *given, name=name: asked.append((name, given)))
    monkeypatch.setattr(preview, "reference_shell", lambda study: "at rest")
    monkeypatch.setattr(preview, "seen_by_take_off", lambda study, at: (f"{at}, seen", 2.0))
    preview.check_before_run(study, StudyPlan(study))
    return asked


def test_all_checks_are_made_before_a_run_those_of_waves_where_waves_are_solved(seed, tmp_path, monkeypatch):
    """Of an assumed pressure no frequency is; its shell must rest, its record be long enough, its dampers be known."""
    monkeypatch.chdir(tmp_path)
    dry = varied(seed, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    for study in (seed, dry):
        asked = asked_before(study, monkeypatch)
        assert [name for name, _ in asked] == [name for name in CHECKS if study is seed or name != "check_waves"]
        given = dict(asked)
        assert given["check_stable"] == (study, "at rest, seen")
        assert given["check_spring"] == given["check_rests"] == (study, "at rest")
        assert given["check_record"] == given["check_dampers"] == (study,)


def test_every_block_that_is_there_is_read_before_any_job(seed, tmp_path, monkeypatch):
    """Those of the sweep, the last as well as the first, those tabulated, and the radiation memory."""
    monkeypatch.chdir(tmp_path)
    plan = StudyPlan(varied(seed, hydro={"rows": 16, "omega_max": 5.0, "omega": (1.0, 2.0)}))
    assert plan.tabulated_blocks
    assert len(plan.sweep_blocks) > 1
    blocks = [plan.block_path(block) for block in (*plan.sweep_blocks, *plan.tabulated_blocks)]
    for name in CHECKS:
        monkeypatch.setattr(CHECKS[name], name, lambda *_: None)
    monkeypatch.setattr(preview, "load", lambda path: read.append(path))
    for there in (*blocks, plan.radiation_path):
        read = []
        Path(there).parent.mkdir(parents=True, exist_ok=True)
        Path(there).touch()
        preview.check_before_run(plan.study, plan)
        assert read == [there]
        Path(there).unlink()


def test_the_finest_mesh_is_told_and_only_what_is_left_costs(seed, tmp_path, monkeypatch):
    """Meshes grow finer with frequency; a block that is there takes no more seconds."""
    monkeypatch.chdir(tmp_path)
    plan = StudyPlan(varied(seed, hydro={"rows": 20, "omega_max": 6.0, "witness": "none"}))
    coarse, *_ = blocks = plan.sweep_blocks
    fine = coarse.mesh.model_copy(update={"rows": 33, "azimuth": 70})
    assert preview._panel_words([coarse, coarse.model_copy(update={"mesh": fine})]) == "33 rows of 70 panels"
    lidded = coarse.mesh.model_copy(update={"rows": 30, "lid_rows": 10})
    one = coarse.model_copy(update={"mesh": lidded, "omega": (1.0, 2.0, 3.0)})
    assert preview._block_seconds(one) == pytest.approx(3 * preview.SECONDS_PER_PANEL_ROW2 * 40**2)
    monkeypatch.setattr(preview, "_block_seconds", lambda block: 100.0 + blocks.index(block))
    Path(plan.block_path(blocks[0])).parent.mkdir(parents=True)
    Path(plan.block_path(blocks[0])).touch()
    told = f"BEM jobs     {len(blocks) - 1} of {len(blocks)} to do, at most about "
    seconds = sum(100 + i for i in range(1, len(blocks)))
    assert preview._bem_lines(plan.study, plan)[1] == f"{told}{seconds} s on one core"


def test_a_second_solver_is_there_when_all_its_files_are(seed, monkeypatch):
    plan = StudyPlan(seed)
    rows, shapes = plan.witness.meshes.rows, len(plan.deformed_paths)
    seconds = f"about {shapes * preview.SECONDS_PER_WITNESS_ROW2 * rows**2:.0f} s on one core"
    for there, words in (((), seconds), (("a",), seconds), (("b",), seconds), (("a", "b"), "there")):
        monkeypatch.setattr(
            StudyPlan, "witness_files", dict.fromkeys(("witness", "more")) | {"witness": "a", "more": "b"}
        )
        monkeypatch.setattr(Path, "exists", lambda path, there=there: str(path) in there)
        assert preview._witness_words(plan) == (
            f"{shapes} shapes at {len(plan.witness.omega)} frequencies by {rows} rows and the spectral solver, {words}"
        )


@pytest.mark.parametrize(("model", "asked"), [("linear", True), ("body_exact", True), ("assumed_pressure", False)])
def test_every_sea_is_judged_beforehand_where_a_study_has_waves(seed, monkeypatch, tmp_path, model, asked):
    monkeypatch.chdir(tmp_path)
    seas = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (5.0, 3.0)]
    pressure = {"pressure": 1800.0} if model == "assumed_pressure" else {}
    study, given = varied(seed, waves=seas, hydro={"model": model, **pressure}), []
    monkeypatch.setattr(preview, "check_before_run", lambda *_: None)
    monkeypatch.setattr("vsb.results.ledger.shell_checks", lambda *_: [SimpleNamespace(line="of the shell")])
    monkeypatch.setattr(
        "vsb.results.ledger.wave_checks", lambda *one: given.append(one) or [SimpleNamespace(line=one[0].label)]
    )
    labels = [wave.label for wave in study.waves]
    lines = preview.summary(study, StudyPlan(study))
    assert lines[0].endswith(f" in {', '.join(labels)}")
    assert given == ([(wave, study.water, study.hydro.omega_max) for wave in study.waves] if asked else [])
    assert lines[-1 - 2 * asked :] == ["of the shell", *(labels if asked else [])]


def test_frequencies_of_both_branches_are_those_of_the_closed_form(seed):
    """Membrane of every degree, bending from the second on; the greater is of the membrane."""
    study = varied(seed, modes={"degree": 4})
    shell, table = Shell.of(study.device), preview.shell_table(study)
    lower, upper = np.transpose([natural_frequencies(shell, n) for n in range(5)])
    assert [row["degree"] for row in table["membrane"]] == [0, 1, 2, 3, 4]
    assert [row["omega"] for row in table["membrane"]] == upper.tolist()
    assert [(row["degree"], row["omega"]) for row in table["bending"]] == [(n, lower[n]) for n in (2, 3, 4)]
    assert all(lower[n] < upper[n] for n in (2, 3, 4))
    assert [row["omega"] for row in table["paper_ritz"]] == mode_basis(
        study.device, "paper", 4
    ).dry_frequencies.tolist()
    rows = [line.split() for line in preview.shell_text(table).splitlines()[1:-1]]
    for n, row in enumerate(rows):
        told = (upper[n], lower[n] if n >= 2 else None, table["paper_ritz"][n]["omega"])
        assert row == [str(n), *("-" if one is None else f"{one:.9f}" for one in told)]


def test_a_stiff_shell_under_a_take_off_that_switches_is_told_to_take_long(seed):
    def said(**device):
        study = varied(seed, device=device, pto={"law": "saturated", "force_limit": 500.0})
        return [line for line in preview.summary(study, StudyPlan(study)) if line.startswith("switches")]

    assert said() == []
    assert "for each run on one core" in said(young_modulus=2.1e11)[0]
