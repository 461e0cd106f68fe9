"""Years under dampers: a rigid design that points have in common is computed once."""

import numpy as np
import pytest
from conftest import varied
from results.test_member import TUNINGS
from results.test_year import climate
from scenes.test_ports import water

from vsb.results.damped_years import DampedYears
from vsb.results.member import member


@pytest.fixture(scope="module")
def study(seed):
    return varied(seed, modes={"degree": 2}, pto={"damping": 8e3})


@pytest.fixture(scope="module")
def shared(study):
    """Coefficients of the shape over all frequencies of the year."""
    return water(study, omega=np.arange(0.1, 3.0, 0.01))


@pytest.fixture(scope="module")
def seas():
    return climate(seas=12)


def counted(monkeypatch):
    """How many designs each call computed, from now on."""
    counts, own = [], DampedYears._computed
    monkeypatch.setattr(
        DampedYears, "_computed", lambda self, study, waves: counts.append([*waves]) or own(self, study, waves)
    )
    return counts


def test_a_rigid_design_is_computed_once_for_all_shells(study, shared, seas, monkeypatch):
    """What is known of it is what would be found again, to the bit; of another damper or radius nothing is known."""
    stiffer, counts, known = varied(study, device={"young_modulus": 3e7}), counted(monkeypatch), {}
    for one in (study, stiffer):
        kept = member(one, lambda basis: shared, seas, TUNINGS, known=known)
        assert kept.identical(member(one, lambda basis: shared, seas, TUNINGS))
    rigid, *others = study.designs
    assert counts == [[rigid, *others], [rigid, *others], others, [rigid, *others]]
    member(varied(study, pto={"damping": 9e3}), lambda basis: shared, seas, TUNINGS, known=known)
    assert counts[-1] == [rigid, *others]
    assert len(known) == 2


def test_no_more_rigid_designs_are_kept_than_a_sweep_may_want(study, shared, seas, monkeypatch):
    monkeypatch.setattr("vsb.results.damped_years.KEPT", 1)
    known = {}
    for damping in (6e3, 7e3, 8e3, 9e3):
        member(varied(study, pto={"damping": damping}), lambda basis: shared, seas, TUNINGS, known=known)
        assert 1 <= len(known) <= 2


def test_what_the_port_does_not_tell_of_the_water_is_not_taken_for_known(study, shared, seas):
    """The same coefficients in another water: energy flux, and so capture width, are that water's."""
    lighter, known = varied(study, water={"density": 1000.0}), {}
    member(study, lambda basis: shared, seas, TUNINGS, known=known)
    found = member(lighter, lambda basis: shared, seas, TUNINGS, known=known)
    assert found.identical(member(lighter, lambda basis: shared, seas, TUNINGS))
    for depth in (1e4, np.inf):
        member(varied(study, water={"depth": depth}), lambda basis: shared, seas, TUNINGS, known=known)
    assert len(known) == 3  # the last is the first
