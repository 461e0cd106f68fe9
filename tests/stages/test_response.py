"""Stage response: absorbed power of the given, the optimal and the matched take-off over frequency."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied

from vsb.engine.motion.frequency import frequency_grid, with_others
from vsb.engine.motion.port import LinearPto
from vsb.models.floating_system import floating_system
from vsb.pipeline.graph import StudyPlan
from vsb.report.band import gain_band
from vsb.stages import frequency
from vsb.tools.files import load


@pytest.fixture
def ds(small):
    return load(small.response.out, expected=small.response.id)


def test_absorbed_power_is_half_damping_times_velocity_squared(small, ds):
    heave = np.abs(ds.rao.sel(dof="Heave").values)
    power = 0.5 * small.study.pto.damping * (ds.omega.values * heave) ** 2
    np.testing.assert_allclose(ds.absorbed_power.values, power, rtol=1e-9, atol=1e-12)


def test_power_is_bounded_by_optimal_damping_then_matched_then_power_limit(ds):
    slack = 1 + 1e-9
    assert (ds.absorbed_power <= slack * ds.best_power).all()
    assert (ds.best_power <= slack * ds.matched_power).all()
    assert (ds.matched_power.sel(design="FSB") <= 1.005 * ds.power_limit).all()  # within the error of the solver


def test_optimal_damping_is_the_impedance_modulus(ds):
    """And the matched power is that of the excitation force V Z, |V Z|^2/(8 Re Z)."""
    np.testing.assert_allclose(ds.best_damping.values, np.abs(ds.port_impedance.values), rtol=1e-9)
    matched = np.abs(ds.port_velocity * ds.port_impedance) ** 2 / (8 * ds.port_impedance.real)
    np.testing.assert_allclose(ds.matched_power.values, matched.values, rtol=1e-9)


def test_optimal_damping_beside_a_spring(small, ds, tmp_path):
    """The damper sees Z + i k/omega: optimal is its modulus, power |V Z|^2 c/(2 |Z + i k/omega + c|^2)."""
    plan = StudyPlan(varied(small.study, pto={"stiffness": 4.0e4}))
    frequency.run_response(plan.response.spec, small.database.out, str(tmp_path / "sprung.nc"))
    sprung = load(tmp_path / "sprung.nc")
    shared = np.intersect1d(sprung.omega, ds.omega)  # each has frequencies of its own at resonances and extremes
    assert len(shared) > 0.8 * ds.sizes["omega"]
    sprung, ds = sprung.sel(omega=shared), ds.sel(omega=shared)
    np.testing.assert_allclose(sprung.port_impedance.values, ds.port_impedance.values, rtol=1e-12)
    z, force2 = sprung.port_impedance, np.abs(sprung.port_velocity * sprung.port_impedance) ** 2
    seen = z + 4.0e4j / z.omega
    np.testing.assert_allclose(sprung.best_damping.values, np.abs(seen).values, rtol=1e-9)
    assert np.abs(sprung.best_damping / ds.best_damping - 1).max() > 0.1
    for name, damping in (("best_power", np.abs(seen)), ("absorbed_power", small.study.pto.damping)):
        power = (0.5 * damping * force2 / np.abs(seen + damping) ** 2).transpose("design", "omega")
        np.testing.assert_allclose(sprung[name].values, power.values, rtol=1e-8, atol=1e-9)


def test_frequencies_equal_but_for_round_off_are_one():
    """The spline through two of them would have slopes of round-off over round-off."""
    wave = 2 * np.pi / 2.5
    grid = frequency_grid(0.5, 1.0, 3.0, [wave, 2.0 * (1 + 1e-15)])
    assert wave in grid
    omega = with_others(grid, grid[3:6] * (1 + 1e-14))
    assert len(omega) == len(grid) == 22


def test_frequency_grid_resolves_resonances_and_extreme_gains(small, ds):
    """A grid thirty times as fine shows no larger and no smaller gain than the one that is written."""
    (wave,) = small.study.waves
    assert wave.omega in ds.omega.values
    floating = floating_system(small.response.spec, small.database.out)
    for motions in floating.motions.values():
        natural, _ = replace(floating.linear, pto=LinearPto(0.0, 0.0, floating.port)).natural_modes(motions)
        shown = natural[natural < float(ds.omega[-1])]
        assert np.abs(ds.omega.values[:, None] - shown).min(axis=0).max() < 1e-9
    fine = np.linspace(*ds.omega.values[[0, -1]], 30 * ds.sizes["omega"])
    powers = frequency.best_powers(small.response.spec, frequency.in_few_motions(floating), 0.0, fine)
    found, exact = ((100 * (p / p.sel(design="FSB") - 1)).where(gain_band(p, "FSB")) for p in (ds.best_power, powers))
    assert float(found.max()) == pytest.approx(float(exact.max()), abs=0.05)
    assert float(found.min()) == pytest.approx(float(exact.min()), abs=0.05)
