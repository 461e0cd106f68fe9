"""Optimal take-offs: no damper or spring in fine tables is better, closed forms of regular waves, losses."""

from bisect import bisect
from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st
from motion.test_port import solved
from scipy.optimize import minimize_scalar

from vsb.engine.hydro.database import Coefficients
from vsb.engine.motion import tuning
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.port import LinearPto, Port, Ports, port_direction
from vsb.engine.motion.take_off import DistributedPort, SeveralPorts
from vsb.engine.motion.tuning import (
    _Full,
    best_damper_of_each,
    best_dampers,
    best_matrix,
    best_of_table,
    best_pairs,
    damper_within_force,
    dampers,
    electrical_power,
    mean_power,
    powers_of_all,
    priced_matrix,
)
from vsb.models.rest import design_motions, reference_shell, study_basis


def random_port(rng, count=40, motions=3, drifting=False):
    """A passive buoy of a few coupled motions that radiate through one channel; one of them held by nothing."""
    omega = np.linspace(0.4, 4.0, count)
    mass = 10 ** rng.uniform(-1, 1, motions)
    stiffness = mass * rng.uniform(0.3, 6, motions) ** 2
    stiffness[0] *= not drifting
    push = rng.normal(size=motions) * np.exp(-(omega[:, None] ** 2) * rng.uniform(0, 0.3))
    radiated = push[:, :, None] * push[:, None, :] * omega[:, None, None] ** 3 * 10 ** rng.uniform(-3, 0)
    lost = radiated + 10 ** rng.uniform(-3, -1) * np.eye(motions)
    w = omega[:, None, None]
    dynamic = -(w**2) * np.diag(mass) - 1j * w * lost + np.diag(stiffness)
    b, rate = rng.normal(size=motions), -1j * omega
    free, forced = (np.linalg.solve(dynamic, x[..., None])[..., 0] @ b for x in (push, np.broadcast_to(b, push.shape)))
    return Port(omega, rate * forced, rate * free, np.inf if drifting else float(b @ (b / stiffness)))


def random_seas(rng, omega, count=6):
    """Regular waves, seas of one peak and of two."""
    seas = np.zeros((count, len(omega)))
    for i, sea in enumerate(seas):
        if i % 3 == 0:
            sea[rng.integers(len(omega))] = 1.0
            continue
        for share in (1.0, rng.uniform(0, 2))[: i % 3]:
            sea += share * np.exp(-0.5 * ((omega - rng.uniform(0.6, 3.5)) / rng.uniform(0.05, 0.8)) ** 2)
        sea[sea < 1e-9 * sea.max()] = 0.0
    return seas


def table(port, sea, efficiency, springs):
    """Power of a fine table of dampers beside some springs [W]."""
    dampers = np.geomspace(0.3 * port.impedance.real.min(), 30 * np.abs(port.impedance).max(), 120)
    c, k = (values.ravel() for values in np.meshgrid(dampers, springs))
    return powers_of_all(port, sea[None], c, k, efficiency).max()


@pytest.mark.parametrize("efficiency", [1.0, 0.8])
@pytest.mark.parametrize("seed", range(2))
def test_no_take_off_in_a_fine_table_beats_the_optimum(seed, efficiency):
    rng = np.random.default_rng(seed)
    port = random_port(rng)
    seas, given_spring = random_seas(rng, port.omega), (0.0, 0.3 / port.compliance)[seed % 2]
    dampers = best_dampers(port, seas, given_spring, efficiency)
    pairs = best_pairs(port, seas, dampers, efficiency)
    tuned, softest = -port.omega * port.impedance.imag, port.softest_spring * (1 - 1e-6)
    for i, sea in enumerate(seas):
        assert table(port, sea, efficiency, np.array([given_spring])) <= dampers.power[i] * (1 + 1e-9)
        low, high = max(min(tuned[sea > 0].min(), 0.0), softest), max(tuned[sea > 0].max(), 0.0)
        springs = np.concatenate([np.linspace(low, high, 100), np.clip(tuned[sea > 0], low, high)])
        assert table(port, sea, efficiency, springs) <= pairs.power[i] * (1 + 1e-9)
    assert mean_power(port, seas, *pairs[:2], efficiency) == pytest.approx(pairs.power, rel=1e-12)
    assert np.all(pairs.stiffness > port.softest_spring)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("efficiency", [1.0, 0.8])
@pytest.mark.parametrize("seed", range(2))
def test_unrestrained_port_is_held_by_its_spring(seed, efficiency):
    """A port without stiffness is stable with any positive spring; the tables begin at zero."""
    rng = np.random.default_rng(seed)
    port = random_port(rng, drifting=True)
    assert port.softest_spring == 0.0
    seas = random_seas(rng, port.omega)
    pairs = best_pairs(port, seas, best_dampers(port, seas, 0.0, efficiency), efficiency)
    tuned = -port.omega * port.impedance.imag
    for i, sea in enumerate(seas):
        high = max(tuned[sea > 0].max(), 1e-3 * np.abs(tuned).max())
        springs = np.linspace(1e-5 * high, high, 100)
        assert table(port, sea, efficiency, springs) <= pairs.power[i] * (1 + 1e-9)
    assert np.isfinite(pairs.stiffness).all()
    assert np.all(pairs.stiffness >= 0.0)


def test_optimum_in_a_regular_wave_matches_closed_forms():
    rng = np.random.default_rng(5)
    port, waves = random_port(rng), np.diag(np.linspace(0.5, 2.0, 40))
    dampers = best_dampers(port, waves)
    assert dampers.damping == pytest.approx(port.best_damping, rel=1e-5)  # flat optimum: power is exact
    assert dampers.power == pytest.approx(np.diag(waves) * port.best_power, rel=1e-9)
    pairs, stable = best_pairs(port, waves, dampers), -port.omega * port.impedance.imag > port.softest_spring
    assert stable.any()
    assert pairs.power[stable] == pytest.approx((np.diag(waves) * port.matched_power)[stable], rel=1e-9)
    assert pairs.damping[stable] == pytest.approx(port.impedance.real[stable], rel=1e-12)
    assert pairs.stiffness[stable] == pytest.approx((-port.omega * port.impedance.imag)[stable], rel=1e-12)


def test_optimal_spring_keeps_the_buoy_stable():
    """The matched spring would make the buoy statically unstable."""
    z = np.array([500.0 + 2500.0j])  # wants -omega X = -5000 N/m
    port = Port(np.array([2.0]), 1 / z, np.array([1.0 + 0.0j]), 1e-3)  # rests with more than -1000 N/m
    squares = np.array([[1.0]])
    dampers = best_dampers(port, squares)
    best = best_pairs(port, squares, dampers)
    assert -1000.0 + 0.999e-3 < best.stiffness[0] < -990.0  # by the millionth that it must leave the buoy
    assert dampers.power[0] < best.power[0] < 0.9 * squares[0] @ port.matched_power
    rests = best_pairs(Port(port.omega, port.admittance, port.velocity, 1e-4), squares, dampers)
    assert rests.stiffness == pytest.approx(-5000.0)
    assert rests.power == pytest.approx(squares @ port.matched_power)


def test_higher_of_two_maxima_is_found():
    """One sea of two waves whose optimal dampers are decades apart."""
    omega = np.array([1.0, 2.0])
    port = Port(omega, 1 / np.array([1.0 + 0j, 1e4]), np.array([1.0 + 0j, 1e-2]), 1.0)
    for share, best in ((2.0, 1.0), (0.5, 1e4)):
        found = best_dampers(port, np.array([[share, 1.0]]) * np.array([1.0, 1.0]))
        assert found.damping[0] == pytest.approx(best, rel=1e-3)


@given(st.floats(0.1, 10), st.floats(-10, 10), st.floats(0.3, 1.0), st.floats(0.3, 3.0))
def test_conversion_losses_match_the_time_signal(damping, stiffness, efficiency, omega):
    """Mean of e p+ + p-/e over a period of v = cos(omega t)."""
    phase = 2 * np.pi * (np.arange(20000) + 0.5) / 20000
    power = (damping * np.cos(phase) + stiffness / omega * np.sin(phase)) * np.cos(phase)
    expected = np.mean(np.where(power > 0, efficiency * power, power / efficiency))
    args = (np.array(v) for v in (damping, stiffness, 0.5, 0.5 / omega**2))
    assert electrical_power(*args, efficiency) == pytest.approx(expected, rel=1e-6, abs=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("efficiency", [0.9, 0.5])
def test_optimal_damper_beside_a_lossy_spring(efficiency):
    """A small buoy tuned to long waves, where it loses little: softer dampers bring less than the spring costs."""
    omega = 2 * np.pi / np.array([12.0, 10.0, 4.0])
    z = 165.0 * omega**3 * 10 - 2.5e4j * omega + 1.26e5j / omega
    port, spring = Port(omega, 1 / z, 1.1e5 / z, 1 / 1.26e5), 2.5e4 * omega[0] ** 2 - 1.26e5
    waves = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.3], [0.0, 0.0, 0.0], [0.4, 1.0, 0.0]])
    tried = np.geomspace(1.0, 1e8, 4001)
    powers = powers_of_all(port, waves, tried, np.full(4001, spring), efficiency)
    for seas in ([0, 1, 2, 3], [3, 0]):
        found = best_dampers(port, waves[seas], spring, efficiency)
        best = powers[:, seas]
        assert np.all(found.power >= best.max(axis=0) * (1 - 1e-12))
        assert found.power == pytest.approx(best.max(axis=0), rel=1e-4)
        moved = waves[seas].any(axis=1)
        assert found.damping[moved] == pytest.approx(tried[best.argmax(axis=0)][moved], rel=0.02)
        assert not found.power[~moved].any()
    assert np.median(powers[:, 0]) < 0 < powers[:, 0].max()


GRID = np.linspace(0.3, 6.0, 40)


def two_resonances(seed):
    """Two resonances at random, passive."""
    random = np.random.default_rng(seed)
    admittance = np.zeros(len(GRID), dtype=complex)
    for _ in range(2):
        mass, damping, resonance = random.uniform([1e4, 2e3, 0.5], [1e5, 5e4, 5.0])
        admittance += 1 / (-1j * GRID * mass + damping + mass * resonance**2 / (-1j * GRID))
    return Port(GRID, admittance, random.uniform(0.1, 2.0, len(GRID)) + 0j, 1e-5)


@pytest.mark.parametrize("seed", range(2))
def test_table_finds_the_optimum_of_each_sea(seed):
    port, squares = two_resonances(seed), np.random.default_rng(100 + seed).exponential(size=(200, len(GRID))) ** 4
    tried = dampers(port)
    found = best_of_table(tried, port.power(tried) @ squares.T)
    climbed = best_dampers(port, squares)
    assert found.power == pytest.approx(climbed.power, rel=1e-9)
    assert np.all(found.power > climbed.power * (1 - 1e-11))
    assert found.damping == pytest.approx(climbed.damping, rel=1e-3)
    exact = np.sum(np.array([port.power(float(c)) for c in found.damping]) * squares, axis=1)
    assert found.power == pytest.approx(exact, rel=1e-11)


def test_optimal_dampers_of_several_ports_are_those_of_each():
    rng = np.random.default_rng(1)
    ports = [random_port(rng) for _ in range(3)]
    still = np.zeros_like(ports[0].velocity)
    ports.insert(1, Port(ports[0].omega, still, still, 0.0))
    sea = random_seas(rng, ports[0].omega)[1]
    found = best_damper_of_each(ports, sea)
    assert found[1] == 0.0
    for port, damping in zip(ports, found, strict=True):
        if port.moves:
            assert damping == pytest.approx(best_dampers(port, sea[None]).damping[0], rel=1e-5)  # flat optimum
            assert port.power(damping) @ sea == pytest.approx(best_dampers(port, sea[None]).power[0], rel=1e-13)


@pytest.mark.parametrize(("spring", "efficiency"), [(0.0, 1.0), (0.4, 1.0), (-0.1, 0.8)])
def test_damper_within_a_limit_of_force_is_the_best_that_keeps_it(spring, efficiency):
    """Against all dampers of a fine table; without the spring where it alone needs more."""
    rng = np.random.default_rng(5)
    port = random_port(rng)
    for sea in random_seas(rng, port.omega, 3):
        free = best_dampers(port, sea[None], spring, efficiency)
        tried = np.geomspace(1e-4, 1e2, 4000)

        def force(damping, stiffness=spring, sea=sea):
            load = port.load(damping, stiffness)
            return np.sqrt(0.5 * np.abs(load * port.velocity_under(load)) ** 2 @ sea)

        for share in (1.1, 0.8, 0.5, 0.1):
            limit = share * float(force(free.damping)[0])
            found = damper_within_force(port, sea[None], limit, spring, efficiency)
            kept = force(tried) <= limit
            own = spring if kept.any() else 0.0
            kept = kept if kept.any() else force(tried, 0.0) <= limit
            powers = powers_of_all(port, sea[None], tried[kept], np.full(kept.sum(), own), efficiency)
            assert found.stiffness[0] == own
            assert force(found.damping, found.stiffness)[0] <= limit * (1 + 1e-9)
            assert powers.max() <= found.power[0] * (1 + 1e-9) + 1e-15
            assert found.power[0] <= free.power[0] * (1 + 1e-9)


# several ports at once: the optimal damper matrix, its slope, and what no matrix exceeds ------------------------------


ALL = np.ones(1)


def one_channel(rng, count, definite):
    """Ports of one radiation channel at one frequency, Z = x x^T - i X, with a reactance definite or not."""
    x, reactance = rng.normal(size=count), rng.normal(size=(count, count))
    reactance = (
        reactance @ reactance.T
        if definite
        else np.diag(np.linspace(-1.0, 1.5, count)) + 0.1 * (reactance + reactance.T)
    )
    admittance = np.linalg.inv(np.outer(x, x) - 1j * reactance)
    return Ports(ALL, admittance[None], (admittance @ x * (1 + 0.3j))[None]), reactance


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("definite", [True, False])
def test_matrix_reaches_the_matched_power_where_the_reactance_is_indefinite(count, definite):
    ports, reactance = one_channel(np.random.default_rng(7 * count), count, definite)
    assert (np.linalg.eigvalsh(reactance).min() > 0) == definite
    uniform, diagonal, full = (best_matrix(ports, ALL, kind).power for kind in ("uniform", "diagonal", "full"))
    matched, tried = ports.matched_power[0], np.geomspace(1e-2, 1e2, 2001)[:, None, None] * np.eye(count)
    assert uniform == pytest.approx(max(ports.power(damper)[0] for damper in tried), rel=1e-4)
    assert uniform <= diagonal * (1 + 1e-9)
    assert diagonal <= full * (1 + 1e-9)
    if definite:
        assert full < 0.99 * matched
    else:
        assert full == pytest.approx(matched, rel=1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_one_damper_for_all_ports_is_the_best_of_any_size_over_several_frequencies(seed):
    rng = np.random.default_rng(seed)
    count, omega = int(rng.integers(2, 7)), np.sort(rng.uniform(0.3, 3.0, 8))
    mass, spring = (one @ one.T for one in rng.normal(size=(2, count, count)))
    loss, forced = rng.normal(size=(count, 2)) * 10 ** rng.uniform(-2, 0.5), rng.normal(size=(len(omega), count))
    w = omega[:, None, None]
    admittance = np.linalg.inv(1j * w * mass + 10 ** rng.uniform(-1, 2) * spring / (1j * w) + loss @ loss.T)
    ports, weights = Ports(omega, admittance, np.einsum("wij,wj->wi", admittance, forced)), rng.uniform(size=len(omega))

    def power(logarithm):
        return float(weights @ ports.power(np.exp(logarithm) * np.eye(count)))

    tried = np.linspace(-15.0, 15.0, 1501)
    best = tried[np.argmax(list(map(power, tried)))]
    found = minimize_scalar(lambda one: -power(one), bounds=(best - 0.05, best + 0.05), method="bounded")
    assert best_matrix(ports, weights, "uniform").power == pytest.approx(-found.fun, rel=1e-8)


def test_matrices_that_nearly_lock_the_ports_keep_a_power_that_can_be_computed(monkeypatch):
    """A line search may leap to factors of 1e9, whose 1 + Y C is singular and gives any power."""
    rng, form = np.random.default_rng(5), _Full(3)
    ports, _ = one_channel(rng, 3, definite=False)
    unit, direction = 1 / np.sqrt(ports.size), np.array([1.0, -0.7, 1e-9, 1.3, 1e-9, 1e-9])  # one column of L

    def power_along(x):
        damping, pull = form.matrix(x, unit)
        power, slope = ports.power_and_slope(damping, ALL)
        return power / ports.matched_power[0], pull(slope) / ports.matched_power[0]

    for size in np.geomspace(1.0, 1e12, 200):
        assert -1e-6 <= power_along(size * direction)[0] <= 1 + 1e-6
    monkeypatch.setattr(tuning, "LOCKED", 2.0)
    at, step = rng.normal(size=(2, 6)) * [[3.0], [1e-5]]
    differences = power_along(at + step)[0] - power_along(at - step)[0]
    assert 2 * power_along(at)[1] @ step == pytest.approx(differences, rel=1e-6)


def test_a_port_that_cannot_move_has_no_damper():
    """As a port of strain in a rigid design; the other has the damper of one port, |Z| in a regular wave."""
    ports = Ports(np.ones(1), np.zeros((1, 2, 2), dtype=complex), np.zeros((1, 2), dtype=complex))
    ports.admittance[0, 0, 0], ports.velocity[0, 0] = 1 / (3 + 4j), 2.0
    for kind in ("full", "diagonal"):
        found = best_matrix(ports, np.ones(1), kind)
        np.testing.assert_allclose(found.damping, [[5.0, 0.0], [0.0, 0.0]], rtol=1e-5)
        assert found.power == pytest.approx(3.125, rel=1e-9)


def test_slope_of_the_power_is_that_of_differences():
    rng = np.random.default_rng(3)
    x, reactance = rng.normal(size=(5, 3)), rng.normal(size=(5, 3, 3))
    z = x[:, :, None] * x[:, None, :] + 0.02 * np.eye(3) - 1j * (reactance + reactance.swapaxes(1, 2))
    ports, squares = Ports(np.linspace(1, 2, 5), np.linalg.inv(z), rng.normal(size=(5, 3)) + 0j), rng.random(5)
    root, change = rng.normal(size=(2, 3, 3))
    damping, change = root @ root.T, change + change.T
    power, slope = ports.power_and_slope(damping, squares)
    assert power == pytest.approx(squares @ ports.power(damping), rel=1e-12)
    differences = squares @ (ports.power(damping + 1e-5 * change) - ports.power(damping - 1e-5 * change)) / 2e-5
    assert np.sum(slope * change) == pytest.approx(differences, rel=1e-7)


def long_waves(stiffness, omega=1.0):
    """A body whose inertia and radiation have vanished: raising the water is lowering the body, X = K e_heave."""
    count = len(stiffness)
    none = np.zeros((1, count, count))
    water = Coefficients(none, none, stiffness[None, 0].astype(complex))
    return LinearEquation(np.array([omega]), water, none[0], none[0], stiffness)


@pytest.mark.parametrize("seed", range(4))
def test_no_damper_matrix_exceeds_the_waterplane_in_long_waves(seed):
    """P <= omega a^2 K_hh/4 for any C >= 0 anywhere, reached by C = K/omega; of heave alone K_eff = 1/(K^-1)_hh."""
    rng, omega, count = np.random.default_rng(seed), 0.7, 5
    root = rng.normal(size=(count, count))
    stiffness = root @ root.T + 0.1 * np.eye(count)
    equation, free = long_waves(stiffness, omega), np.eye(count)
    everywhere, bound = equation.ports(free, free), omega * stiffness[0, 0] / 4
    for _ in range(50):
        part = rng.normal(size=(count, rng.integers(1, count + 1))) * np.exp(2 * rng.normal())
        assert everywhere.power(part @ part.T)[0] <= bound * (1 + 1e-12)
    assert everywhere.power(stiffness / omega)[0] == pytest.approx(bound, rel=1e-12)
    softened = 1 / np.linalg.inv(stiffness)[0, 0]
    heave = equation.ports(free, free[:, :1])
    dampers = softened / omega * np.geomspace(0.1, 10.0, 21)[:, None, None]
    powers = [heave.power(damper)[0] for damper in dampers]
    assert max(powers) == powers[10] == pytest.approx(omega * softened / 4, rel=1e-12)
    # the shell alone: with heave held at most the shell's share of the stiffness, with the frame free nothing
    held = equation.ports(free[:, 1:], free)
    for _ in range(50):
        part = rng.normal(size=(count, rng.integers(1, count + 1))) * np.exp(2 * rng.normal())
        assert held.power(part @ part.T)[0] <= omega * (stiffness[0, 0] - softened) / 4 * (1 + 1e-12)
    shell = stiffness.copy()
    shell[0] = shell[:, 0] = 0.0
    assert held.power(shell / omega)[0] == pytest.approx(omega * (stiffness[0, 0] - softened) / 4, rel=1e-12)
    assert everywhere.power(shell)[0] == pytest.approx(0.0, abs=1e-20)


def test_seed_with_heave_and_area_reaches_the_limit_of_one_channel(seed):
    """Below 3.1 s, where the two ports' reactance is indefinite; two separate dampers absorb far less."""
    changes = {"modes": {"basis": "full", "degree": 6}, "device": {"damping": {"alpha": 0.0, "beta": 0.0}}}
    study = varied(seed, designs={"VSWEC": {}}, **changes)
    buoy, basis = solved(study), study_basis(study)
    choice = SeveralPorts(ports={"heave": "heave", "shell": {"strain": "area"}})
    directions = port_direction(choice, reference_shell(study).shape)
    omega = 2 * np.pi / np.array([3.0, 2.5, 2.0])
    ports = buoy.equation(omega).ports(design_motions(study, basis, "VSWEC"), directions)
    for i in range(len(omega)):
        one = ports.at(np.array([i]))
        values = np.linalg.eigvalsh(one.impedance[0].imag * np.outer(one.size, one.size) ** 0.5)
        assert values[0] < 0 < values[1]
        full, apart = (best_matrix(one, ALL, kind).power / one.matched_power[0] for kind in ("full", "diagonal"))
        assert full == pytest.approx(1.0, abs=1e-4)
        assert apart == pytest.approx((1.0, 0.476, 0.157)[i], abs=1e-2)
    alone, beside = (
        LinearPto(5e3),
        LinearPto(np.diag([5e3, 0.0]), port=directions),
    )  # a damper of heave, and none of area
    moved = np.random.default_rng(2).normal(size=(3, len(directions))) + 0j
    powers = [replace(buoy, pto=pto).absorbed_power(omega, moved) for pto in (alone, beside)]
    assert powers[1] == pytest.approx(powers[0], rel=1e-12)


def test_damper_spread_over_the_membrane_has_its_stiffness(seed):
    """L L^T is the elastic stiffness of the membrane basis about the sphere, but for the little its shapes bend."""
    study = varied(seed, designs={"VSWEC": {}})
    spread = port_direction(DistributedPort(distributed="membrane"), reference_shell(study).shape)
    stiffness = study_basis(study).stiffness
    np.testing.assert_allclose(spread @ spread.T, stiffness, rtol=2e-5, atol=1e-9 * stiffness.max())


def test_matrix_within_a_force_is_the_best_of_those_that_keep_it():
    """Of one port it is the damper within the force; a price's slope is that of power less price times mean square."""
    rng = np.random.default_rng(8)
    omega = np.linspace(0.5, 3.0, 120)
    at = omega[:, None, None]
    loss, mass, stiffness = (
        np.array(rows) for rows in ([[5.0, 1.0], [1.0, 3.0]], [[4.0, 0.5], [0.5, 2.0]], [[9.0, 1.0], [1.0, 8.0]])
    )
    y = np.linalg.inv(loss - 1j * at * mass + 1j * stiffness / at)
    ports, squares = Ports(omega, y, y @ np.array([3.0, 1.0])), 0.02 * np.exp(-(((omega - 1.5) / 0.4) ** 2))
    best = best_matrix(ports, squares)
    limit = 0.3 * float(np.linalg.norm(ports.force_rms(best.damping, squares)))
    found = priced_matrix(ports, squares, limit)[0]
    assert np.linalg.norm(ports.force_rms(found.damping, squares)) == pytest.approx(limit, rel=1e-5)
    for _ in range(20):
        factor, sizes = rng.standard_normal((2, 2)), np.geomspace(1e-2, 1e2, 2000)
        tried = sizes[:, None, None] * (found.damping + rng.uniform(0.0, 2.0) * (factor @ factor.T))
        beyond = bisect(tried, limit, key=lambda one: np.linalg.norm(ports.force_rms(one, squares)))
        assert 0 < beyond < len(tried)
        assert float(squares @ ports.power(tried[beyond - 1])) <= found.power * (1 + 1e-6)
    assert priced_matrix(ports, squares, 10 * limit)[0].power == pytest.approx(best.power)
    alone, single = (
        Port(omega, y[:, 0, 0], ports.velocity[:, 0], 1.0),
        Ports(omega, y[:, :1, :1], ports.velocity[:, :1]),
    )
    damper = damper_within_force(alone, squares[None], limit)
    assert priced_matrix(single, squares, limit)[0].power == pytest.approx(float(damper.power[0]), rel=1e-5)
    step, matrix, price = 1e-6, np.array([[2.0, 0.3], [0.3, 1.0]]), 0.07
    change = np.array([[1.0, 0.5], [0.5, -0.4]])
    ends = [ports.power_and_slope(matrix + s * step * change, squares, price)[0] for s in (1, -1)]
    slope = ports.power_and_slope(matrix, squares, price)[1]
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(float((slope * change).sum()), rel=1e-6)
