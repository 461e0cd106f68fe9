"""What stages of a whole study read: only what the study asks for, and nothing where it has none."""

import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.errors import DatabaseError
from vsb.stages.inputs import Inputs
from vsb.study.study import load

NAMES = ("database", "radiation", "response", "witness")


@pytest.mark.parametrize("name", NAMES)
def test_a_study_without_bem_has_none_of_its_files(name):
    found = getattr(Inputs(load(SEED.with_name("paper.yaml")), "runs"), name)
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
