"""Seas beyond the validity of linear waves and small motions."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from models.test_ports import water
from results.test_year import climate

from vsb.engine.waves.scatter import climate_of_cells
from vsb.engine.waves.water import Water, wavenumber
from vsb.models.ports import buoy_at
from vsb.models.rest import reference_shell
from vsb.results.year import band_weights, year
from vsb.results.year_validity import LIMITS, beyond_validity, motion_rms, wave_limits

SEAS = climate_of_cells(np.array([1.0, 4.0, 6.0]), np.array([9.0, 7.0, 6.5]), np.array([0.5, 0.3, 0.2]), 3.3, "three")


def test_steep_and_breaking_seas_in_deep_water():
    """Steepness Hs over g Te^2/(2 pi): 0.0079, 0.0523, 0.0910."""
    steep, breaking = wave_limits(SEAS, Water())
    assert steep.seas.tolist() == [False, True, True]
    assert breaking.seas.tolist() == [False, False, True]
    assert steep.largest == pytest.approx(6.0 * 2 * np.pi / (9.81 * 6.5**2), rel=1e-9)
    assert breaking.largest == pytest.approx(1.86 * steep.largest / 0.142, rel=1e-9)
    assert steep.energy(np.array([1.0, 10.0, 20.0]), SEAS.hours) == pytest.approx(7.0 / 7.5)
    assert steep.energy(np.zeros(3), SEAS.hours) == 0.0


@pytest.fixture(scope="module")
def shells(seed):
    """The seed's designs and their motions in a year of twelve seas."""
    study = varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "stiffness": 2e4})
    waves = buoy_at(study, reference_shell(study), water(study, omega=np.arange(0.1, 3.0, 0.01))).in_waves()
    return study, waves, climate(seas=12)


def by_the_sea(one, seas, damping, stiffness):
    """Rms heave and largest rms displacement of the shell in each sea at its own damping."""
    omega, found = one.port.omega, []
    for density, c in zip(seas.density, damping, strict=True):
        load = c + 1j * stiffness / omega
        force = load * one.port.velocity / (1 + one.port.admittance * load)
        weights = band_weights(omega, seas).T @ density / 2
        heave = one.motion.heave[0] - force * one.motion.heave[1]
        shell = one.motion.shell[0] - force * one.motion.shell[1]
        squares = (np.abs(shell) ** 2).sum(axis=0) @ weights
        found.append([float(weights @ np.abs(heave) ** 2), float(squares.max())])
    return np.sqrt(np.array(found).T)


def test_motions_under_individual_dampers_equal_a_loop_over_seas(shells):
    study, waves, seas = shells
    each = year({d: w.port.beside(2e4) for d, w in waves.items()}, seas, study.water, ("each",))
    for i, (design, one) in enumerate(waves.items()):
        heave, deformation = by_the_sea(one, seas, each.damping[i, 0], 2e4)
        found = motion_rms(one, seas, each.damping[i, 0], 2e4)
        np.testing.assert_allclose(found["heave"], heave, rtol=2e-3, err_msg=design)
        np.testing.assert_allclose(found["deformation"], deformation, rtol=2e-3, err_msg=design)
        assert (deformation.max() > 0) == study.designs[design].flexible
        same = motion_rms(one, seas, np.full(12, 3e3), 2e4)
        for name, expected in zip(same, by_the_sea(one, seas, np.full(12, 3e3), 2e4), strict=True):
            np.testing.assert_allclose(same[name], expected, rtol=1e-12, err_msg=f"{design} {name}")


def test_seas_beyond_validity_are_marked_in_their_bins(shells):
    """For a radius small enough that some seas deform the shell too much."""
    study, waves, seas = shells
    found = year({d: w.port.beside(2e4) for d, w in waves.items()}, seas, study.water, ("one",))
    radius = float(np.median(by_the_sea(waves["VSWEC"], seas, found.damping[1, 0], 2e4)[1])) * 3.72 / 0.1
    rms = {name: motion_rms(one, seas, found.damping[i, 0], 2e4) for i, (name, one) in enumerate(waves.items())}
    ds = xr.Dataset(beyond_validity(found, lambda design, _: rms[design], radius))
    steep, breaking = wave_limits(seas, study.water)
    for i, design in enumerate(waves):
        heave, deformation = by_the_sea(waves[design], seas, found.damping[i, 0], 2e4) * 3.72 / radius
        each = {"steepness": steep.seas, "breaking": breaking.seas, "deformation": deformation > 0.1}
        marked = np.any(list(each.values()), axis=0)
        taken = found.power[i, 0] * seas.hours
        for name, which in {**each, "heave": heave > 0.3}.items():
            share = float(taken[which].sum() / taken.sum())
            assert float(ds.energy_beyond[i, 0].isel(limit=LIMITS.index(name))) == pytest.approx(share), (design, name)
        assert float(ds.energy_beyond_validity[i, 0]) == pytest.approx(float(taken[marked].sum() / taken.sum()))
        for bin_ in found.bins.occupied:
            inside = found.bins.index == bin_
            share = float(seas.hours[inside & marked].sum() / seas.hours[inside].sum())
            assert ds.beyond_validity[i, 0].values.ravel()[bin_] == pytest.approx(share)
    assert 0 < float(ds.energy_beyond_validity[1, 0]) < 1
    assert not ds.beyond_validity.values[..., found.bins.count == 0].any()


def test_wave_limits_depend_on_gravity_and_depth():
    for sea_water in (Water(gravity=3.7), Water(gravity=3.7, depth=8.0), Water(density=900.0)):
        numbers = np.array([wavenumber(2 * np.pi / te, sea_water.depth, sea_water.gravity) for te in SEAS.te])
        steep, breaking = wave_limits(SEAS, sea_water)
        assert steep.largest == pytest.approx((SEAS.hs * numbers).max() / (2 * np.pi), rel=1e-12)
        broken = 1.86 * SEAS.hs * numbers / (2 * np.pi * 0.142 * np.tanh(numbers * min(sea_water.depth, 1e3)))
        assert breaking.largest == pytest.approx(broken.max(), rel=1e-9)
        assert breaking.seas.tolist() == (broken > 1.0).tolist()
