"""The tuning `constrained` of a member of a campaign."""

import numpy as np
import pytest
from conftest import varied
from results.test_year import climate
from scenes.test_ports import water

from vsb.motion.force_bound import Limits
from vsb.results.constrained_member import Optima
from vsb.results.constrained_year import constrained_year, harmonics_of_year
from vsb.results.ladder import GAP
from vsb.results.member import member
from vsb.results.validity import LIMITS as WAVE_LIMITS
from vsb.scenes.ports import designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.study.campaign import CONSTRAINED

LIMIT, SECONDS = 2e4, 0.2


def optima_of(study, **changes):
    return Optima(**{"water": lambda basis, omega: water(study, omega=omega), "seconds": SECONDS, "seed": 1} | changes)


@pytest.fixture(scope="module")
def limited(seed):
    return varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "force_limit": LIMIT}, hydro={"omega_max": 8.0})


@pytest.fixture(scope="module")
def shared(limited):
    """Coefficients of the shape over all frequencies of the year."""
    return water(limited, omega=np.arange(0.1, 3.0, 0.01))


@pytest.fixture(scope="module")
def seas():
    return climate(seas=6)


@pytest.fixture(scope="module")
def found(limited, shared, seas):
    return member(limited, lambda basis: shared, seas, ("one", CONSTRAINED), optima_of(limited))


def test_member_equals_the_constrained_years_of_its_ports(limited, shared, seas, found):
    harmonics = harmonics_of_year(seas, float(shared.omega[0]), 8.0, SECONDS)
    waves = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.port_omega))
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
            assert float(here.gain_percent) == pytest.approx(mean, rel=1e-9)
            assert float(here.gain_low) < low < high < float(here.gain_high)


def test_every_optimum_has_an_upper_bound(found):
    assert found.power_bound.dims == ("design",)
    at = found.sel(tuning=CONSTRAINED)
    assert bool((found.power_bound >= at.annual_mean_power).all())
    np.testing.assert_allclose(1 - at.annual_mean_power / found.power_bound, found.optimum_gap, atol=1e-12)
    assert float(found.optimum_gap.max()) < GAP
    assert found.optimum_share.values == pytest.approx(1.0)
    assert found.impossible_share.values.tolist() == [0.0] * 4


def test_soft_shell_is_marked_beyond_validity(limited, shared, seas, found):
    soft = varied(limited, device={"young_modulus": 5e5}, pto={"stiffness": 1e5})
    ds = optima_of(soft)(soft, reference_shell(soft), seas, float(shared.omega[0])).sel(tuning=CONSTRAINED)
    ds = ds.assign_coords(limit=list(WAVE_LIMITS))
    assert 0 < float(ds.energy_beyond.sel(design="VSWEC", limit="deformation")) <= 1
    assert float(ds.energy_beyond.sel(design="FSB", limit="deformation")) == 0
    assert bool((ds.energy_beyond_validity >= ds.energy_beyond.sel(limit="deformation") - 1e-12).all())


def test_known_years_are_not_reused_for_other_limits(limited, seas):
    """Of one rigid design in one sea."""
    rigid, kept = varied(limited, designs={"FSB": {"flexible": False}}), None
    powers = []
    for pto in ({"force_limit": 1e4}, {"force_limit": 2e4}):
        one = varied(rigid, pto=pto)
        kept = kept or optima_of(one)
        found, alone = (of(one, reference_shell(one), seas, 0.1) for of in (kept, optima_of(one)))
        assert found.identical(alone)
        powers.append(float(found.annual_mean_power.squeeze()))
    assert len(kept.known) == len(set(powers)) == 2
