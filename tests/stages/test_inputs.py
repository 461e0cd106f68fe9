"""What stages of a whole study read: only what the study asks for, and nothing where it has none."""

import pytest
import xarray as xr
from conftest import EXAMPLE, varied

from vsb.errors import DatabaseError
from vsb.stages import inputs
from vsb.stages.inputs import Inputs
from vsb.study.body import BodyStudy
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id, load

NAMES = ("database", "radiation", "response", "witness")


@pytest.mark.parametrize("name", NAMES)
def test_a_study_without_bem_has_none_of_its_files(name):
    found = getattr(Inputs(load(EXAMPLE.with_name("paper.yaml")), "runs"), name)
    assert isinstance(found, xr.Dataset)
    assert not found.data_vars


@pytest.mark.parametrize("name", NAMES)
def test_a_file_the_study_needs_is_missed(seed, name):
    with pytest.raises(DatabaseError, match=r": file not found; run the rule that makes it"):
        getattr(Inputs(seed, "runs"), name)
    with pytest.raises(DatabaseError, match=r"no.nc: file not found"):
        getattr(Inputs(seed, "runs", {name: "no.nc"}), name)


def test_a_study_that_asks_for_no_second_solver_has_none(seed):
    assert not Inputs(varied(seed, hydro={"witness": "none"}), "runs").witness.data_vars


def test_every_file_is_read_from_its_own_path_and_is_what_the_study_asks_for(seed, monkeypatch):
    """Shared files by the id they are named by, the study's own by that of their specification."""
    monkeypatch.setattr(inputs, "load", lambda path, expected: ("load", path, expected))
    monkeypatch.setattr(inputs, "load_database", lambda path, identity: ("database", path, identity))
    found = Inputs(seed, "runs", {name: f"r/{name}-id.nc" for name in ("modes", *NAMES)})
    assert found.modes == ("load", "r/modes-id.nc", content_id(StudyPlan(seed).modes))
    assert found.database == ("database", "r/database-id.nc", "database-id")
    assert found.radiation == ("load", "r/radiation-id.nc", "radiation-id")
    assert found.response == ("load", "r/response-id.nc", StudyPlan(seed).response_id)
    assert found.witness == ("load", "r/witness-id.nc", "witness-id")
    assert (found.runs.study, found.runs.folder) == (seed, "runs")


def test_shapes_of_modes_are_of_every_buoy_and_of_no_body(monkeypatch):
    """Of one without coefficients, too: what is assumed of the water is no matter."""
    monkeypatch.setattr(inputs, "load", lambda path, expected: (path, expected))
    paper = load(EXAMPLE.with_name("paper.yaml"))
    assert Inputs(paper, "runs", {"modes": "m.nc"}).modes == ("m.nc", content_id(StudyPlan(paper).modes))
    barge = BodyStudy.model_validate({"study": "a", "body": {"bemio": "a.h5"}, "waves": [{"kind": "still"}],
                                      "designs": {"A": {}}, "pto": {"damping": 1.0}})  # fmt: skip
    found = Inputs(barge, "runs", {"modes": "m.nc", "witness": "w-id.nc"})
    assert not found.modes.data_vars
    assert not found.witness.data_vars
    assert (found.path("modes"), found.path("rungs")) == ("m.nc", "")
