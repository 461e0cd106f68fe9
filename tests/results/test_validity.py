"""Seas beyond linear waves and small motions."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from results.test_year import climate, port, rms, stroke_rms
from scenes.test_ports import water

from vsb.results.validity import (
    LIMITS,
    _beyond,
    _nodes,
    _undominated,
    beyond_validity,
    motion_limits,
    motion_rms,
    wave_limits,
)
from vsb.results.year import band_weights, frequencies, year
from vsb.scenes.ports import POINTS, designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.study.study import Water
from vsb.waves.dispersion import wavenumber
from vsb.waves.scatter import climate_of_cells

SEAS = climate_of_cells(np.array([1.0, 4.0, 6.0]), np.array([9.0, 7.0, 6.5]), np.array([0.5, 0.3, 0.2]), 3.3, "three")


def test_steep_and_breaking_seas_in_deep_water():
    """Hs over g Te^2/(2 pi): 0.0079, 0.0523, 0.0910; the highest wave of the last is 0.169 of its length."""
    steep, breaking = wave_limits(SEAS, Water())
    assert steep.seas.tolist() == [False, True, True]
    assert breaking.seas.tolist() == [False, False, True]
    assert steep.largest == pytest.approx(6.0 * 2 * np.pi / (9.81 * 6.5**2), rel=1e-9)
    assert breaking.largest == pytest.approx(1.86 * steep.largest / 0.142, rel=1e-9)
    assert steep.energy(np.array([1.0, 10.0, 20.0]), SEAS.hours) == pytest.approx(7.0 / 7.5)
    assert steep.energy(np.zeros(3), SEAS.hours) == 0.0


def test_shallow_water_breaks_waves():
    """Miche's limit goes over into 0.89 of the depth."""
    breaking = wave_limits(SEAS, Water(depth=0.2))[1]
    assert breaking.seas.tolist() == [True, True, True]
    assert breaking.largest == pytest.approx(1.86 * 6.0 / (0.142 * 2 * np.pi * 0.2), rel=0.01)


def test_root_mean_square_of_a_flat_response_is_that_of_the_waves():
    seas = climate()
    grid = np.linspace(0.2, 2.4, 500)
    assert rms(seas, grid, np.full(500, 4.0)) == pytest.approx(2 * np.sqrt(seas.variance), rel=1e-12)


def test_a_body_much_stiffer_than_its_mass_rides_little():
    """Below resonance the stroke is excitation over stiffness."""
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    stiff = port(grid, mass=1.0, loss=1.0, stiffness=1e8)
    excitation = 5e4 / (1 + grid**2)
    assert stroke_rms(stiff, seas, 1.0) == pytest.approx(rms(seas, grid, (excitation / 1e8) ** 2), rel=1e-6)


def test_motions_beyond_their_limits():
    heave, deformation = motion_limits({"heave": np.array([0.1, 0.2]), "deformation": np.array([0.05, 0.06])}, 2.0)
    assert heave.seas.tolist() == [False, True]
    assert deformation.seas.tolist() == [False, True]
    assert heave.largest == pytest.approx(0.372)


@pytest.fixture(scope="module")
def shells(seed):
    """The seed's designs over a year of twelve seas, and how they move in them."""
    study = varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "stiffness": 2e4})
    waves = designs_in_waves(study, reference_shell(study), water(study, omega=np.arange(0.1, 3.0, 0.01)))
    return study, waves, climate(seas=12)


def by_the_sea(one, seas, damping, stiffness):
    """Heave and largest displacement of the shell, sea by sea, each under its own damper."""
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


def test_motions_under_a_damper_of_each_sea_s_own(shells):
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


@given(hnp.arrays(float, st.integers(2, 6), elements=st.floats(1.0, 1e6)))
def test_what_is_smooth_in_the_logarithm_of_a_damper_is_known_from_few_within_their_range(damping):
    nodes, shares = _nodes(damping)
    assert damping.min() * (1 - 1e-12) <= nodes.min()
    assert nodes.max() <= damping.max() * (1 + 1e-12)
    if len(nodes) > 1:
        assert np.log(nodes).mean() == pytest.approx(np.log(damping.min() * damping.max()) / 2, abs=1e-9)
        assert shares.T @ np.log(nodes) ** 2 == pytest.approx(np.log(damping) ** 2, rel=1e-6, abs=1e-6)


def test_what_moves_with_a_port_is_its_own_motion(shells):
    """Of heave: its rate is the port's velocity, and its yielding the port's admittance."""
    _, waves, _ = shells
    for one in waves.values():
        rate = -1j * one.port.omega
        np.testing.assert_allclose(rate * one.motion.heave[0], one.port.velocity, rtol=1e-12)
        np.testing.assert_allclose(rate * one.motion.heave[1], one.port.admittance, rtol=1e-12)


def test_a_clamped_point_does_not_move(shells):
    """Of the points told the equator is the middle one."""
    _, waves, _ = shells
    shell = waves["VSWEC90"].motion.shell[0]
    assert np.abs(shell[:, POINTS // 2]).max() < 1e-9 * np.abs(shell).max()


def test_seas_beyond_are_marked_in_their_bins(shells):
    """Sea by sea: a bin's share of its seas, and their energy; a radius small enough that some deform too much."""
    study, waves, seas = shells
    found = year({d: w.port.beside(2e4) for d, w in waves.items()}, seas, study.water, ("one",))
    radius = float(np.median(by_the_sea(waves["VSWEC"], seas, found.damping[1, 0], 2e4)[1])) * 3.72 / 0.1
    ds = xr.Dataset(beyond_validity(found, waves, 2e4, radius))
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


@given(
    hnp.arrays(float, (5, 3), elements=st.sampled_from([0.0, 1.0, 2.0, 3.0])),
    hnp.arrays(float, 3, elements=st.floats(0, 9)),
)
def test_what_another_exceeds_in_every_band_is_never_the_largest(rows, density):
    """In any sea the largest of those left is the largest of all; of equals one is left."""
    left = _undominated(rows)
    assert (left @ density).max() == pytest.approx((rows @ density).max(), rel=1e-14)
    assert len(np.unique(left, axis=0)) == len(left)
    above = (left[:, None] <= left).all(axis=2) & ~np.eye(len(left), dtype=bool)
    assert not above.any()


def test_every_tuning_has_its_own_marks(shells):
    """Those it has alone; a damper of each sea's own, and one twenty times as large."""
    study, waves, seas = shells
    ports = {d: w.port.beside(2e4) for d, w in waves.items()}
    given = dict.fromkeys(waves, 1e5)
    both = year(ports, seas, study.water, ("fixed", "one"), given)
    radius = float(np.median(by_the_sea(waves["VSWEC"], seas, both.damping[1, 1], 2e4)[1])) * 3.72 / 0.1
    found = beyond_validity(both, waves, 2e4, radius)
    for j, name in enumerate(("fixed", "one")):
        alone = beyond_validity(year(ports, seas, study.water, (name,), given), waves, 2e4, radius)
        for key, (dims, values) in found.items():
            expected = alone[key][1]
            np.testing.assert_allclose(np.take(values, j, dims.index("tuning")), expected.squeeze(dims.index("tuning")))
    marked = found["energy_beyond_validity"][1]
    assert (marked[1] > 0).all()
    assert marked[1, 0] != marked[1, 1]


def test_limits_of_waves_are_of_the_gravity_and_the_depth_they_run_in():
    for sea_water in (Water(gravity=3.7), Water(gravity=3.7, depth=8.0), Water(density=900.0)):
        numbers = np.array([wavenumber(2 * np.pi / te, sea_water.depth, sea_water.gravity) for te in SEAS.te])
        steep, breaking = wave_limits(SEAS, sea_water)
        assert steep.largest == pytest.approx((SEAS.hs * numbers).max() / (2 * np.pi), rel=1e-12)
        broken = 1.86 * SEAS.hs * numbers / (2 * np.pi * 0.142 * np.tanh(numbers * min(sea_water.depth, 1e3)))
        assert breaking.largest == pytest.approx(broken.max(), rel=1e-9)
        assert breaking.seas.tolist() == (broken > 1.0).tolist()


def test_beside_seas_without_a_damper_all_are_told_of_the_largest():
    """No logarithm of nothing."""
    nodes, shares = _nodes(np.array([0.0, 5.0, 2.0]))
    assert nodes.tolist() == [5.0]
    assert shares.tolist() == [[1.0, 1.0, 1.0]]


def test_a_motion_at_its_limit_is_within_it():
    """Highest of a thousand maxima of 0.25 m at a radius of 3.1 m; a billionth more is beyond."""
    for name, limit in (("heave", 0.3), ("deformation", 0.1)):
        at = limit * 3.1 / 3.72
        (found,) = motion_limits({name: np.array([at * (1 - 1e-9), at * (1 + 1e-9), 0.0])}, 3.1)
        assert (found.name, found.limit, found.seas.tolist()) == (name, limit, [False, True, False])
        assert found.largest == pytest.approx(limit)
    assert _beyond("steepness", np.array([0.05, 0.04]), 0.05) == ("steepness", 0.05, 0.05, pytest.approx([0, 0]))
