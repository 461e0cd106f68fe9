"""The degree of the shell modes: found from the tolerance, stored, and part of the ids."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import EXAMPLE, varied

from vsb.results.left_out import modes_left_out
from vsb.scenes.floating_system import study_sea
from vsb.scenes.mode_convergence import from_lists, one_of_each_family
from vsb.stages.planning import degree_lines, plan_of, stored_search, with_degree
from vsb.study.plan import StudyPlan, degree_path
from vsb.study.quantities import content_id
from vsb.study.sections import DEGREES
from vsb.study.study import load
from vsb.waves.seas import expected

TOLERANT = {"basis": "full", "degree": None, "tolerance": 0.005}


@pytest.fixture(scope="module")
def asked():
    """The example in one wave, with modes by tolerance."""
    return varied(load(EXAMPLE), modes=TOLERANT, designs={"FSB": {"flexible": False}, "VSWEC": {}})


@pytest.fixture(scope="module")
def planned(asked, tmp_path_factory):
    return with_degree(StudyPlan(asked, root=str(tmp_path_factory.mktemp("results"))))


def kept(plan):
    (path,) = Path(plan.root, "hydro", "degrees").iterdir()
    return path


def test_degree_is_found_from_the_tolerance_and_stored(asked, planned):
    assert planned.study.modes.degree in DEGREES
    assert planned.study.modes.tolerance == 0.005
    assert json.loads(kept(planned).read_text())["degree"] == planned.study.modes.degree


def test_degree_stands_in_the_ids(asked, planned):
    other = varied(asked, waves=[{"kind": "regular", "amplitude": 0.1, "period": 6.0}])
    there = with_degree(StudyPlan(other, root=planned.root))
    assert there.study.modes.degree == planned.study.modes.degree
    assert content_id(there.database) == content_id(planned.database)
    given = StudyPlan(varied(asked, modes={"basis": "full", "degree": 20}), root=planned.root)
    assert with_degree(given) is given
    assert content_id(given.database) != content_id(planned.database)


def test_campaign_has_the_degree_of_its_thinnest_shell(asked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "buoy.yaml").write_text(yaml.safe_dump(asked.model_dump(exclude_none=True)))
    (tmp_path / "site.csv").write_text("Hs/Te, 5, 6\n0.75, 5, 8\n1.25, 4, 10\n")
    given = {"campaign": "site", "study": "buoy.yaml", "climate": {"scatter": "site.csv"}, "tuning": ["one"]}

    def degree(vary):
        (tmp_path / "site.yaml").write_text(yaml.safe_dump({**given, "vary": vary}))
        return plan_of("site.yaml").loaded.base.modes.degree

    thick, thin = degree({"device.thickness": [0.03]}), degree({"device.thickness": [0.008]})
    assert thin >= thick
    assert degree({"device.thickness": [0.03, 0.008]}) == max(thick, thin)
    assert degree({"device.internal_pressure": [0.0]}) == DEGREES[0]  # vented, without equilibrium


def test_check_compares_a_given_degree_with_the_tolerance(asked, planned):
    needed = planned.study.modes.degree

    def line(**modes):
        (only,) = degree_lines(StudyPlan(varied(asked, modes=modes), root=planned.root))
        return only

    assert line(basis="full", degree=needed).startswith("ok ")
    assert f"needs the full basis to degree {needed}" in line(basis="full", degree=needed - 1)
    assert line(basis="membrane", degree=90).startswith("doubt")


def test_check_says_where_the_highest_degree_may_not_meet_the_tolerance(seed, tmp_path):
    clamped = {"FSB": {"flexible": False}, "VSWEC90": {"clamp": 90}}
    modes = {"basis": "full", "degree": 90, "tolerance": 1e-4}
    study = varied(seed, modes=modes, designs=clamped, device={"thickness": 0.004})
    (line,) = degree_lines(StudyPlan(study, root=str(tmp_path)))
    assert line.startswith("doubt")
    assert "degree 90 may not meet modes.tolerance" in line


def test_control_levels_need_no_search_of_their_own(asked, tmp_path):
    """What the plan found is what the ladder would find: seas, families of realisations and designs are the same.

    A record holds a wave of 100 s, below the first frequency solved: it would be most of the matched power.
    """
    time = np.arange(0.0, 100.0, 0.5)
    elevation = 0.1 * np.cos(0.4 * np.pi * time) + 0.008 * np.cos(0.02 * np.pi * time)
    gusts = [{"kind": "jonswap", "hs": 0.5, "tp": 4.0, "seed": seed} for seed in (1, 2)]
    record = {"kind": "record", "file": {"step": 0.5, "elevation": tuple(elevation)}}
    study = varied(asked, waves=[*gusts, record], simulation={"duration": 10.0, "window": [0.0, 10.0]})
    plan = with_degree(StudyPlan(study, root=str(tmp_path)))
    spec, search = plan.ladder, stored_search(degree_path(plan.root, plan.degree))
    powers = from_lists(search.powers, spec.designs)
    solved = xr.Dataset(coords={"omega": [plan.first_omega, plan.highest_omega]})
    seas = [(wave, study_sea(spec, expected(wave), solved)) for wave in spec.waves]
    families = one_of_each_family(spec.waves)
    assert families == [0, 2]
    stored, searched = (modes_left_out(spec.buoy, seas, families, known) for known in (powers, None))
    assert stored.identical(searched)
