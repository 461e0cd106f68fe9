"""Stages radiation and response: a passive memory, and powers of the given, optimal and matched take-off."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import run_at, varied

from vsb.engine.hydro.database import load_database
from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel, fit_radiation
from vsb.engine.motion.frequency import frequency_grid, with_others
from vsb.engine.motion.port import LinearPto
from vsb.models.floating_system import floating_system
from vsb.pipeline.graph import StudyPlan
from vsb.report.answer import gain_band
from vsb.stages import frequency
from vsb.tools.files import load


def test_radiation_model_is_passive_and_within_its_stated_error(small):
    ds = load(small.radiation.out, expected=small.radiation.id)
    model = RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)
    assert ds.attrs["order"] == model.order
    assert np.linalg.eigvals(model.state_matrix).real.max() < 0
    assert ds.attrs["fit_error"] <= small.radiation.spec["tolerance"]
    damping = model.damping(ds.omega.values)
    np.testing.assert_allclose(ds.damping_state_space.values, np.einsum("wii->wi", damping))
    assert np.linalg.eigvalsh(damping).min() > -1e-9 * damping.max()
    np.testing.assert_allclose(ds.kernel_state_space, np.einsum("tii->ti", model.kernel(ds.time.values)), atol=1e-9)
    off = np.abs(ds.kernel - ds.kernel_state_space).max(dim="time") / np.abs(ds.kernel).max(dim="time")
    assert float(off.sel(radiating_dof="Heave")) < 0.01


def test_damping_of_the_model_is_that_of_the_database(small):
    ds, database = load(small.radiation.out), load_database(small.database.out, small.database.id)
    heave = {"influenced_dof": "Heave", "radiating_dof": "Heave"}
    truth = database.radiation_damping.sel(heave)
    assert float(np.abs(ds.damping_state_space.sel(radiating_dof="Heave") - truth).max()) < 0.01 * float(truth.max())


def test_every_azimuthal_order_has_its_own_memory():
    """A smooth and a peaked damping; sway has the memory of surge, a dry motion has none."""
    omega = np.linspace(0.1, 12.0, 120)
    smooth = omega**3 * np.exp(-2 * omega)
    peaked = smooth * (1 + 2 * np.exp(-(((omega - 2.0) / 0.3) ** 2)))
    heave, surge = peaked, smooth
    damping = np.zeros((len(omega), 4, 4))
    for place, values in enumerate((heave, surge, 0 * surge, surge)):
        damping[:, place, place] = values
    labels, pair = ["Heave", "Surge", "Pitch", "Sway"], ("influenced_dof", "radiating_dof")
    ds = xr.Dataset(
        {"radiation_damping": (("omega", *pair), damping), "azimuthal_order": ("influenced_dof", [0, 1, 1, -1])},
        coords={"omega": omega, **dict.fromkeys(pair, labels)},
    )
    found = frequency.fit_orders(ds, 1e-3)
    fits = [fit_radiation(DampingSpectrum(omega, one[:, None, None]), 1e-3) for one in (heave, surge)]
    assert len({error for _, error in fits}) == 2
    assert found.error == max(error for _, error in fits)
    own = [model.damping(omega)[:, 0, 0] for model, _ in fits]
    model = found.model.damping(omega)
    for place, values in enumerate((own[0], own[1], 0 * own[1], own[1])):
        np.testing.assert_allclose(model[:, place, place], values, rtol=1e-9, atol=1e-12)


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
    run_at(plan.response, database=small.database.out, out=str(tmp_path / "sprung.nc"))
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
    floating = floating_system(small.response.spec["study"], small.database.out)
    for motions in floating.motions.values():
        natural, _ = replace(floating.linear, pto=LinearPto(0.0, 0.0, floating.port)).natural_modes(motions)
        shown = natural[natural < float(ds.omega[-1])]
        assert np.abs(ds.omega.values[:, None] - shown).min(axis=0).max() < 1e-9
    fine = np.linspace(*ds.omega.values[[0, -1]], 30 * ds.sizes["omega"])
    powers = frequency.best_powers(small.response.spec["study"], frequency.in_few_motions(floating), 0.0, fine)
    found, exact = ((100 * (p / p.sel(design="FSB") - 1)).where(gain_band(p, "FSB")) for p in (ds.best_power, powers))
    assert float(found.max()) == pytest.approx(float(exact.max()), abs=0.05)
    assert float(found.min()) == pytest.approx(float(exact.min()), abs=0.05)
