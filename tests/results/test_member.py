"""A member of a campaign: the year of its ports, power over damping, designs that are not stable."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied
from models.test_buoy_of_shape import water
from results.test_year import climate

from vsb.engine.waves.climate import Climate
from vsb.models.floating_system import BuoyOfShape, buoy_at
from vsb.models.rest import reference_shell
from vsb.models.viability import viability, with_designs
from vsb.results.campaign import CURVES, MATRICES, OF_DESIGNS, TRIED, DampedYears, member
from vsb.results.year import band_weights, frequencies, year
from vsb.study.study import Study

TUNINGS = ("fixed", "one", "each")
BETWEEN = -0.95
"""Of the waterplane's stiffness: a spring that makes the free shells unstable, not the rigid and the clamped one."""


@pytest.fixture(scope="module")
def study(seed) -> Study:
    return varied(seed, modes={"degree": 2, "tolerance": 0.1}, pto={"damping": 8e3})


BAND = (0.1, 3.0)


def year_of(study, seas, tunings=TUNINGS, **known):
    """The member of a study in water that acts on one ring."""
    swept, rest = (
        SimpleNamespace(band=BAND, clamps=None, at=lambda omega: water(study, omega=omega)),
        viability(study),
    )

    def floating():
        return BuoyOfShape(with_designs(study, rest.designs), reference_shell(study), swept)

    return member(rest, floating, seas, tunings, **known)


@pytest.fixture(scope="module")
def seas() -> Climate:
    return climate(seas=12)


@pytest.fixture(scope="module")
def found(study, seas):
    return year_of(study, seas)


def unstable(study) -> Study:
    """The study with a spring that makes its second and third design unstable."""
    waterplane = study.water.density * study.water.gravity * np.pi * study.device.radius**2
    return varied(study, pto={"stiffness": BETWEEN * waterplane})


def test_member_equals_the_year_of_its_ports(study, seas, found):
    omega = frequencies(seas, *BAND)
    ports = buoy_at(study, reference_shell(study), water(study, omega=omega)).ports()
    apart = year(ports, seas, study.water, TUNINGS, dict.fromkeys(ports, 8e3), "FSB").dataset()
    for name in ("annual_mean_power", "force_rms", "gain_percent", "power_matrix", "damping"):
        np.testing.assert_array_equal(found[name].values, apart[name].values, err_msg=name)
    assert found.viable.values.all()
    assert [text.partition(":")[0] for text in found.reason.values] == ["", *["doubtful"] * 3]  # 8 % strain at rest
    assert found["count"].sum() == 12


def test_interval_of_a_gain_contains_the_errors_of_both_designs(study, found):
    """At least those of the quadrature; the gain of the reference is exactly zero."""
    error = found.quadrature_error / found.annual_mean_power
    for design in study.designs:
        one, reference = found.sel(design=design), found.sel(design="FSB")
        least = (error.sel(design=design) + error.sel(design="FSB")) * (100 + one.gain_percent)
        width = one.gain_high - one.gain_percent
        assert bool((width == 0.0).all() if design == "FSB" else (width > least).all())
        assert bool((one.gain_percent - one.gain_low >= least).all() or design == "FSB")
        ratio = one.annual_mean_power / reference.annual_mean_power
        np.testing.assert_allclose(one.gain_percent, 100 * (ratio - 1), atol=1e-10)


def test_year_of_shells_clamped_at_rings_has_an_interval(seed, seas):
    """Their motions include the answer of all higher degrees, and so do the errors of the coefficients."""
    found = year_of(varied(seed, modes={"basis": "full", "degree": 3}, pto={"damping": 8e3}), seas, ("one",))
    assert (found.gain_low <= found.gain_percent).all()
    assert (found.gain_percent <= found.gain_high).all()


def test_relative_errors_of_two_powers_add_up_in_the_interval_of_their_ratio(study, seas):
    """Of the quadrature alone; the gain is 100 (P/P_0 - 1)."""
    omega = frequencies(seas, *BAND)
    waves = buoy_at(study, reference_shell(study), water(study, omega=omega)).in_waves()
    values = DampedYears(seas, TUNINGS)(study, waves)
    power, error, low, high = (
        np.asarray(values[name][1]) for name in ("annual_mean_power", "quadrature_error", "gain_low", "gain_high")
    )
    relative, ratio = error / power, power / power[0]
    assert np.abs(ratio[1] - 1).max() > 0.1
    np.testing.assert_allclose((high - low)[1:], 200 * ((relative + relative[0]) * ratio)[1:], rtol=1e-4, atol=1e-12)


def test_unstable_designs_have_no_values(study, seas, found):
    assert found.viable.all()
    lost = unstable(study)
    ds = year_of(lost, seas)
    assert ds.viable.values.tolist() == [True, False, False, True]
    assert [text.startswith("unstable: least stiffness -") for text in ds.reason.values] == [False, True, True, False]
    stable = ["FSB", "VSWEC90"]
    alone = year_of(with_designs(lost, stable), seas)
    for name in (*OF_DESIGNS, *CURVES, *MATRICES):
        assert np.isnan(ds[name].sel(design=["VSWEC", "VSWEC0"])).all(), name
        np.testing.assert_array_equal(ds[name].sel(design=stable), alone[name], err_msg=name)


def test_member_without_a_stable_design_needs_no_hydrodynamics(study, seas):
    """Shells without an equilibrium, or with an unstable one; the seas are counted all the same."""
    asked = []
    soft = varied(study, reference_shape="equilibrium")
    shells = with_designs(unstable(study), ["VSWEC", "VSWEC0"])
    for lost in (soft, shells):
        ds = member(viability(lost), asked.append, seas, TUNINGS)
        assert not ds.viable.values.any()
        assert np.isnan(ds.annual_mean_power).all()
        assert ds["count"].sum() == 12
        assert ds.margin < 0
    assert asked == []


@pytest.mark.slow
def test_known_years_are_not_reused_in_other_water(study, seas):
    """The same coefficients, but another energy flux and capture width."""
    lighter, known = varied(study, water={"density": 1000.0}), {}
    year_of(study, seas, known=known)
    found = year_of(lighter, seas, known=known)
    assert found.identical(year_of(lighter, seas))


def test_power_over_damping_equals_years_with_that_damper(study, seas, found):
    """The curve has its maximum, in the middle, at the optimal damping of all seas."""
    tried, power, force = (found[f"{name}_damping"].values for name in ("tried", "power_of", "force_of"))
    best = np.nanmax(found.damping.sel(tuning="one").values, axis=(1, 2))
    assert tried == pytest.approx(np.outer(best, TRIED), rel=1e-12)
    assert (power.argmax(axis=1) == 30).all()
    for i in (45,):
        given = varied(study, pto={"damping": float(tried[0, i])})
        year = year_of(given, seas, ("fixed",)).isel(design=0, tuning=0)
        assert power[0, i] == pytest.approx(float(year.annual_mean_power), rel=1e-9)
        assert force[0, i] == pytest.approx(float(year.force_rms), rel=1e-9)


def test_year_includes_the_spring_of_the_take_off(study, seas):
    """P = c |v|^2/2 of every wave with the impedance c + i k/omega at the port."""
    spring = varied(study, pto={"damping": 8e3, "stiffness": 2e4})
    waves = buoy_at(spring, reference_shell(spring), water(spring, omega=frequencies(seas, *BAND))).in_waves()
    found = year_of(spring, seas, ("fixed",))
    for i, one in enumerate(waves.values()):
        omega = one.port.omega
        weights = band_weights(omega, seas).T @ (seas.hours @ seas.density) / seas.hours.sum()

        def taken(damping, one=one, omega=omega, weights=weights):
            load = damping + 1j * 2e4 / omega
            return float(weights @ np.abs(one.port.velocity / (1 + one.port.admittance * load)) ** 2) * damping / 2

        assert float(found.annual_mean_power[i, 0]) == pytest.approx(taken(8e3), rel=2e-3)
        for k in (0, 30, 60):
            tried, power = (float(found[name][i, k]) for name in ("tried_damping", "power_of_damping"))
            assert power == pytest.approx(taken(tried), rel=2e-3)


@pytest.mark.slow
def test_causal_control_of_several_ports_needs_no_other_tuning(study):
    both = varied(
        study, pto={"damping": None, "ports": {"heave": "heave", "top": {"colatitude": 0.0, "against": "frame"}}}
    )
    ds = year_of(both, climate(seas=2), ("damper_same_force", "causal"))
    assert (ds.annual_mean_power.sel(tuning="causal") >= ds.annual_mean_power.sel(tuning="damper_same_force")).all()
    assert ds.damper_matrix.sel(tuning="damper_same_force").notnull().all()
