"""The tuning `constrained` of a member: its places in the results, what proves it, what is shared."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from results.test_year import climate
from scenes.test_ports import water

from vsb.motion.harmonics import Harmonics
from vsb.results.constrained_member import Optima, _motion_rms
from vsb.results.constrained_year import Limits, constrained_year, harmonics_of_year
from vsb.results.member import OF_LIMITS, member
from vsb.scenes.ports import designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.study.year_options import CONSTRAINED
from vsb.tools.units import check_finite

LIMIT, SECONDS = 2e4, 0.5


def optima_of(study, **changes):
    return Optima(**{"water": lambda basis, omega: water(study, omega=omega), "seconds": SECONDS, "seed": 1} | changes)


@pytest.fixture(scope="module")
def limited(seed):
    return varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "force_limit": LIMIT}, hydro={"omega_max": 4.0})


@pytest.fixture(scope="module")
def shared(limited):
    """Coefficients of the shape over all frequencies of the year."""
    return water(limited, omega=np.arange(0.1, 3.0, 0.01))


@pytest.fixture(scope="module")
def seas():
    return climate(seas=12)


@pytest.fixture(scope="module")
def found(limited, shared, seas):
    return member(limited, lambda basis: shared, seas, ("one", CONSTRAINED), optima_of(limited))


def test_optima_are_those_of_the_ports_at_harmonics(limited, shared, seas, found):
    """Power, force, matrix and gain of every design, from its port and the programme alone."""
    harmonics = harmonics_of_year(seas, float(shared.omega[0]), 4.0, SECONDS)
    waves = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.omega))
    years = {
        design: constrained_year(one.port, seas, limited.water, harmonics, Limits(LIMIT), SECONDS, 1)
        for design, one in waves.items()
    }
    at = found.sel(tuning=CONSTRAINED)
    for design, one in years.items():
        here = at.sel(design=design)
        assert float(here.annual_mean_power) == pytest.approx(one.annual_mean_power.mean, rel=1e-12)
        assert float(here.annual_energy) == pytest.approx(one.annual_mean_power.mean * 8.766e-3, rel=1e-12)
        flux = float(seas.flux(limited.water) @ seas.hours)
        assert float(here.capture_width) * flux == pytest.approx(one.annual_mean_power.mean, rel=1e-12)
        assert 2 * float(here.quadrature_error) == pytest.approx(np.ptp(one.annual_mean_power[1:]), rel=1e-12)
        assert float(here.force_rms) == pytest.approx(one.force_rms)
        assert one.force_rms < LIMIT
        np.testing.assert_allclose(here.power_matrix, one.power_matrix, rtol=1e-12)
        assert float((here.power_matrix * one.bins.share).sum()) == pytest.approx(one.taken, rel=1e-12)
        if design != "FSB":
            mean, low, high = one.gain(years["FSB"])
            width = 2 * limited.hydro.tolerance * (100 + mean)
            told = [float(here[f"gain_{part}"]) for part in ("percent", "low", "high")]
            assert told == pytest.approx([mean, low - width, high + width], rel=1e-9)


def test_a_damper_within_the_limit_takes_no_more(limited, shared, seas):
    """Where the limit is twenty times the damper's rms force, every optimum lies between damper and matched force."""
    wide = varied(limited, pto={"force_limit": 1e7})
    ds = member(wide, lambda basis: shared, seas, ("each", CONSTRAINED), optima_of(wide))
    assert bool((ds.annual_mean_power.sel(tuning=CONSTRAINED) > ds.annual_mean_power.sel(tuning="each")).all())


def test_every_optimum_has_its_proof(found):
    assert found.power_bound.dims == ("design",)
    at = found.sel(tuning=CONSTRAINED)
    assert bool((found.power_bound >= at.annual_mean_power).all())
    np.testing.assert_allclose(1 - at.annual_mean_power / found.power_bound, found.optimum_gap, atol=1e-12)
    assert float(found.optimum_gap.max()) < 2e-6
    assert found.optimum_share.values.tolist() == [1.0] * 4
    assert found.impossible_share.values.tolist() == [0.0] * 4


def test_dampers_beside_optima_are_what_they_are_alone(limited, shared, seas, found):
    alone = member(limited, lambda basis: shared, seas, ("one",))
    assert not set(OF_LIMITS) & set(alone)
    for name in alone.data_vars:
        here = found[name].sel(tuning=["one"]) if "tuning" in found[name].dims else found[name]
        np.testing.assert_array_equal(here.values, alone[name].values, err_msg=name)


def test_nothing_is_missing_but_what_usual_practice_says(found):
    check_finite(found, "a member")
    assert np.isnan(found.practice_power.sel(tuning=CONSTRAINED)).all()
    assert not np.isnan(found.practice_power.sel(tuning="one")).any()
    assert not found.damping.sel(tuning=CONSTRAINED).any()


def test_a_rigid_design_of_other_shells_is_solved_once(limited, shared, seas, monkeypatch):
    solved = []
    monkeypatch.setattr("vsb.results.constrained_member.constrained_year", _counted(solved))
    optima = optima_of(limited)
    for modulus in (1e7, 1e8):
        other = varied(limited, device={"young_modulus": modulus})
        member(other, lambda basis: shared, seas, (CONSTRAINED,), optima)
    assert solved.count(LIMIT) == 7  # four designs, then three
    rigid = varied(limited, designs={"FSB": {"flexible": False}})
    alone = water(rigid, omega=shared.omega)
    optima = optima_of(rigid, known=optima.known)
    monkeypatch.setattr("vsb.results.constrained_member.KEPT", 2)
    for limit in (1e6, 2e6):
        member(varied(rigid, pto={"force_limit": limit}), lambda basis: alone, seas, (CONSTRAINED,), optima)
    assert len(optima.known) == 2


def _counted(solved):
    def counted(*given):
        solved.append(given[4].force)
        return constrained_year(*given)

    return counted


def test_stroke_that_no_force_keeps_takes_nothing(limited, shared, seas):
    tight = varied(limited, pto={"force_limit": 100.0, "stroke_limit": 0.02})
    ds = member(tight, lambda basis: shared, seas, (CONSTRAINED,), optima_of(tight)).sel(tuning=CONSTRAINED)
    assert ds.impossible_share.sel(design="FSB") == 1
    assert ds.annual_mean_power.sel(design="FSB") == 0
    assert "gain_percent" not in ds or np.isnan(ds.gain_percent).all()


def test_shells_moved_by_the_best_force_are_judged_bin_by_bin(limited, shared, seas, found):
    """A bin whose shell deforms too much is marked whole; stiff shells and rigid buoys mark none."""
    soft = varied(limited, device={"young_modulus": 5e5}, pto={"stiffness": 1e5})
    ds = member(soft, lambda basis: shared, seas, (CONSTRAINED,), optima_of(soft)).sel(tuning=CONSTRAINED)
    assert 0 < float(ds.energy_beyond.sel(design="VSWEC", limit="deformation")) <= 1
    assert float(ds.energy_beyond.sel(design="FSB", limit="deformation")) == 0
    assert bool((ds.energy_beyond_validity >= ds.energy_beyond.sel(limit="deformation") - 1e-12).all())
    marked = ds.beyond_validity.sel(design="VSWEC")
    assert set(np.unique(marked.where(ds["count"] > 0, 0))) <= {0.0, 1.0} | set(
        np.unique(ds.beyond_validity.sel(design="FSB"))
    )


def test_motion_under_the_best_force_is_the_stroke_it_keeps(limited, seas):
    """Of a port at heave: what marks are told from is what the programme limits."""
    harmonics = Harmonics(0.1, 2.0, 30)
    one = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.omega))["VSWEC"]
    found = constrained_year(one.port, seas, limited.water, harmonics, Limits(LIMIT, 2.0), SECONDS, 1)
    strokes = [[np.linalg.norm(optimum.stroke) ** 2 / 2 for optimum in pair] for pair in found.optima]
    np.testing.assert_allclose(_motion_rms(found, one.motion)["heave"], np.sqrt(np.mean(strokes, axis=1)), rtol=1e-9)


def test_deformation_is_the_length_of_what_a_point_moves_and_the_largest_of_all(limited, seas):
    """A shell that moves as the buoy does in both directions, half as far elsewhere: the root of two times heave."""
    harmonics = Harmonics(0.1, 2.0, 30)
    one = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.omega))["VSWEC"]
    found = constrained_year(one.port, seas, limited.water, harmonics, Limits(LIMIT), SECONDS, 1)
    shell = tuple(np.stack([[0.5 * part, part, 0.2 * part]] * 2) for part in one.motion.heave)
    moved = _motion_rms(found, replace(one.motion, shell=shell))
    np.testing.assert_allclose(moved["deformation"], np.sqrt(2) * moved["heave"], rtol=1e-12)
    assert (moved["heave"] > 0).all()


def test_years_within_other_limits_are_not_taken_for_known(limited, seas):
    """Of one rigid design, and so one port: what is found after other limits is what is found alone, to the bit."""
    rigid, kept = varied(limited, designs={"FSB": {"flexible": False}}), None
    powers = []
    for pto in ({"force_limit": 1e4}, {"force_limit": 2e4}, {"force_limit": 2e4, "stroke_limit": 0.5}):
        one = varied(rigid, pto=pto)
        kept = kept or optima_of(one)
        found, alone = (of(one, reference_shell(one), seas, 0.1) for of in (kept, optima_of(one)))
        assert found.identical(alone)
        powers.append(float(found.annual_mean_power.squeeze()))
    assert len(kept.known) == len(set(powers)) == 3
