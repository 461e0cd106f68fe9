"""The optimum within limits: identities, a second method, proofs, and limits of limits."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motion.test_harmonics import SEA, WAVES, buoy, instants
from scipy.optimize import linprog, minimize

from vsb.errors import ConvergenceError, StabilityError
from vsb.motion import constrained
from vsb.motion.constrained import constrained_optimum
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.waves.seas import Sea


def power(velocity, admittance, force):
    return float(np.sum((force.conj() * velocity).real - admittance.real * np.abs(force) ** 2) / 2)


@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_without_limits_that_bind_it_is_the_matched_limit(harmonics):
    velocity, admittance = buoy(harmonics)
    matched = np.sum(np.abs(velocity) ** 2 / (8 * admittance.real))
    free = constrained_optimum(harmonics, velocity, admittance)
    loose = constrained_optimum(harmonics, velocity, admittance, 1.01 * free.force_peak, 1.01 * free.stroke_peak)
    tight = constrained_optimum(harmonics, velocity, admittance, 0.8 * free.force_peak, 1.01 * free.stroke_peak)
    assert free.power == loose.power == pytest.approx(matched, rel=1e-14)
    assert free.gap == loose.gap == 0
    assert tight.power < 0.99995 * matched


@pytest.mark.parametrize("share", [0.9997, 0.99, 1.0003])
@pytest.mark.parametrize("way", ["force", "stroke"])
def test_a_limit_a_little_below_what_is_best_without_it_binds_and_one_above_does_not(way, share):
    velocity, admittance = buoy(SEA)
    free = constrained_optimum(SEA, velocity, admittance)
    limits = (share * free.force_peak, np.inf) if way == "force" else (np.inf, share * free.stroke_peak)
    found = constrained_optimum(SEA, velocity, admittance, *limits)
    assert (found.steps > 0) == (share < 1)
    assert found.power <= free.power
    peak = found.force_peak if way == "force" else found.stroke_peak
    assert peak <= min(share, 1.0) * getattr(free, f"{way}_peak") * (1 + 1e-9)


@pytest.mark.parametrize("limits", [(3e3, np.inf), (np.inf, 0.3), (4e4, 2.0), (4e3, 6.0)])
@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_limits_are_kept_and_the_gap_is_closed(harmonics, limits):
    velocity, admittance = buoy(harmonics)
    found = constrained_optimum(harmonics, velocity, admittance, *limits)
    assert found.force_peak <= limits[0] * (1 + 1e-9)
    assert found.stroke_peak <= limits[1] * (1 + 1e-9)
    assert 0 <= found.gap <= 1e-6
    assert found.power == pytest.approx(power(velocity, admittance, found.force), rel=1e-13)
    stroke = (velocity - admittance * found.force) / (-1j * harmonics.omega)
    np.testing.assert_allclose(found.stroke, stroke, rtol=1e-12, atol=1e-15)
    assert found.force_rms == pytest.approx(np.sqrt(np.mean(harmonics.signal(found.force) ** 2)), rel=1e-12)
    peaks = [np.abs(harmonics.signal(x, 8)).max() for x in (found.force, found.stroke)]
    assert found.excess == pytest.approx(max(0.0, *(p / m - 1 for p, m in zip(peaks, limits, strict=True))), abs=1e-12)


@pytest.mark.parametrize(("force_limit", "stroke_limit"), [(4e3, np.inf), (2e4, 0.5), (np.inf, 0.35)])
def test_a_general_solver_finds_the_same_optimum(force_limit, stroke_limit):
    """SLSQP on the real and imaginary parts, constraints written out with sines and cosines."""
    harmonics = Harmonics(0.8, 0.5, 4)
    velocity, admittance = buoy(harmonics)
    found = constrained_optimum(harmonics, velocity, admittance, force_limit, stroke_limit)
    time, w = instants(harmonics, harmonics.instants), harmonics.omega
    scale = found.force_peak

    def complexes(x):
        return scale * (x[:4] + 1j * x[4:])

    def room(x):
        force = complexes(x)
        stroke = (velocity - admittance * force) / (-1j * w)
        out = []
        for phasors, limit in ((force, force_limit), (stroke, stroke_limit)):
            signal = np.cos(np.outer(time, w)) @ phasors.real + np.sin(np.outer(time, w)) @ phasors.imag
            if np.isfinite(limit):
                out += [1 - signal / limit, 1 + signal / limit]
        return np.concatenate(out)

    def loss(x):
        return -power(velocity, admittance, complexes(x)) / found.power

    best = minimize(
        loss, np.zeros(8), constraints={"type": "ineq", "fun": room}, options={"ftol": 1e-12, "maxiter": 500}
    )
    assert best.success
    assert -best.fun == pytest.approx(1.0, rel=2e-6)


def least_share(harmonics, velocity, admittance, force_limit, stroke_limit):
    """Least factor by which both limits can be multiplied and still be kept together: a linear programme."""
    time, w = instants(harmonics, harmonics.instants), harmonics.omega
    cosine, sine = np.cos(np.outer(time, w)), np.sin(np.outer(time, w))
    gain, n = admittance / (-1j * w), len(w)
    still = velocity / (-1j * w)
    free = cosine @ still.real + sine @ still.imag
    force = np.hstack([cosine, sine])
    stroke = -np.hstack([cosine * gain.real + sine * gain.imag, sine * gain.real - cosine * gain.imag])
    rows = np.vstack([force / force_limit, -force / force_limit, stroke / stroke_limit, -stroke / stroke_limit])
    ones = np.ones((len(rows), 1))
    right = np.concatenate([np.zeros(2 * len(time)), -free / stroke_limit, free / stroke_limit])
    cost = np.append(np.zeros(2 * n), 1.0)
    return linprog(cost, np.hstack([rows, -ones]), right, bounds=[(None, None)] * (2 * n) + [(0, None)]).fun


@pytest.mark.parametrize("seed", range(4))
def test_limits_that_cannot_be_met_are_proved_so_and_others_met(seed):
    """Judged by a linear programme: just on one side a force is found, just on the other a certificate."""
    harmonics = Harmonics(0.26, 0.5, 16)
    velocity, admittance = buoy(harmonics, resonance=1.2, seed=seed, loss=50.0)
    free = np.abs(harmonics.signal(velocity / (-1j * harmonics.omega))).max()
    limits = np.array([5e3, 0.2 * free])
    limits *= least_share(harmonics, velocity, admittance, *limits)
    assert np.abs(limits[1]) < free
    found = constrained_optimum(harmonics, velocity, admittance, *(1.03 * limits))
    assert found.force_peak <= 1.03 * limits[0] * (1 + 1e-9)
    assert found.stroke_peak <= 1.03 * limits[1] * (1 + 1e-9)
    with pytest.raises(
        StabilityError, match=r"no force within force_limit keeps stroke_limit in this sea \(proof: it would"
    ) as told:
        constrained_optimum(harmonics, velocity, admittance, *(0.97 * limits))
    most, least = (float(number) for number in re.findall(r"(-?[\d.e+]+) W", str(told.value)))
    size = np.sqrt(2) * 0.97 * limits[0]
    least_there_is = -size / 2 * (np.linalg.norm(velocity) + size * admittance.real.max())
    assert most < least == pytest.approx(least_there_is, rel=1e-5)


@settings(max_examples=25)
@given(
    damping=st.floats(3, 6),
    stiffness=st.floats(-4e4, 4e4),
    seed=st.integers(0, 99),
    share=st.floats(0.05, 1.0),
)
def test_no_spring_and_damper_within_the_limits_takes_more(damping, stiffness, seed, share):
    velocity, admittance = buoy(SEA, seed=seed)
    load = 10**damping + 1j * stiffness / SEA.omega
    force = velocity * load / (1 + admittance * load)
    taken = power(velocity, admittance, force)
    stroke = (velocity - admittance * force) / (-1j * SEA.omega)
    peaks = [np.abs(SEA.signal(x)).max() for x in (force, stroke)]
    assert constrained_optimum(SEA, velocity, admittance, *peaks).power >= taken * (1 - 2e-6)
    if share * peaks[1] > 1.01 * np.abs(SEA.signal(velocity / (-1j * SEA.omega))).max():
        assert constrained_optimum(SEA, velocity, admittance, share * peaks[0]).power <= taken / share * 50


def test_power_is_concave_and_rises_with_the_limit():
    velocity, admittance = buoy(SEA)
    limits = np.linspace(1e3, 1.2e4, 8)
    powers = np.array([constrained_optimum(SEA, velocity, admittance, limit, tolerance=1e-9).power for limit in limits])
    assert np.all(np.diff(powers) > 0)
    assert np.all(np.diff(powers, 2) < 1e-6 * powers[-1])


def test_a_small_force_takes_its_limit_times_mean_speed_with_order_two_in_the_harmonics():
    """F = F_max sign V0 is best where force is scarce; N harmonics turn it over within 1/N of each zero of V0."""
    omega, velocity = 1.3, 0.7
    missing = []
    for count in (8, 16, 32, 64, 128):
        harmonics = Harmonics(omega, 1.0, count)
        free = np.zeros(count, dtype=complex)
        free[0] = velocity
        found = constrained_optimum(harmonics, free, np.full(count, 1e-9 + 0j), 1.0, tolerance=1e-10)
        missing.append(1 - found.power / (2 / np.pi * velocity))
    orders = -np.diff(np.log2(np.abs(missing)))
    assert np.all(np.abs(orders - 2.0) < 0.25), (missing, orders)


def test_the_bound_holds_for_any_multipliers():
    """Weak duality: also far from the optimum no force within the limits passes it."""
    velocity, admittance = buoy(SEA)
    limit = constrained.Limit(np.zeros(SEA.instants), np.ones(SEA.count, dtype=complex), 4e3)
    programme = constrained._Programme(SEA, velocity, admittance.real, [limit])
    best = constrained_optimum(SEA, velocity, admittance, 4e3).power
    rng = np.random.default_rng(5)
    for size in (1e-4, 1e-2, 1.0):
        upper, lower = rng.uniform(size=(2, SEA.instants)) * size / SEA.instants
        assert programme.bound([upper], [lower]) >= best


@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_no_force_within_its_limit_takes_less_than_the_least(harmonics):
    """Else a certificate would be none: of a limited force at a still port all is lost where the port loses most."""
    velocity, admittance = buoy(harmonics)
    limits = [constrained.Limit(np.zeros(harmonics.instants), np.ones(harmonics.count, dtype=complex), 4e3)]
    stroke = constrained.Limit(np.zeros(harmonics.instants), 2 * np.ones(harmonics.count, dtype=complex), 1.0)
    rng = np.random.default_rng(8)
    for share in (0.0, 0.01, 1.0):
        free, loss = share * velocity, admittance.real
        programme = constrained._Programme(harmonics, free, loss, [*limits, stroke])
        against = np.where(loss == loss.max(), 1.0, 1e-9) * np.exp(1j * np.angle(-velocity))
        for force in (against, -free, rng.normal(size=(2, harmonics.count)).T @ [1, 1j]):
            scaled = 4e3 * force / max(np.abs(harmonics.signal(force)).max(), 1e-300)
            assert programme.power(scaled) >= programme.least
        size = np.sqrt(2) * 4e3  # |f| of a force that is all the time at its limit
        assert programme.least == pytest.approx(-size / 2 * (np.linalg.norm(free) + size * loss.max()), rel=1e-12)
        assert constrained._Programme(harmonics, free, loss, [stroke]).least == -np.inf


def test_the_bound_of_a_stroke_holds_for_any_multipliers():
    """There what is limited is not none without force: each side is pushed as far as the sea alone moves the port."""
    velocity, admittance = buoy(SEA)
    integral = 1 / (-1j * SEA.omega)
    free = SEA.signal(velocity * integral)
    limits = [
        constrained.Limit(np.zeros(SEA.instants), np.ones(SEA.count, dtype=complex), 4e4),
        constrained.Limit(free, -admittance * integral, 2.0),
    ]
    assert [limit.plain for limit in limits] == [True, False]
    assert not constrained.Limit(free, np.ones(SEA.count, dtype=complex), 1.0).plain
    programme = constrained._Programme(SEA, velocity, admittance.real, limits)
    best = constrained_optimum(SEA, velocity, admittance, 4e4, 2.0).power
    rng = np.random.default_rng(5)
    for size in (1e-2, 1.0, 1e2):
        upper, lower = rng.uniform(size=(2, 2, SEA.instants)) * size / SEA.instants
        assert programme.bound(list(upper), list(lower)) >= best
        net = upper - lower
        pulled = sum(limit.gain.conj() * SEA.phasors(mu) for limit, mu in zip(limits, net, strict=True))
        held = 4e4 * (upper + lower)[0].sum() + 2.0 * (upper + lower)[1].sum() - free @ net[1]
        expected = held + np.sum(np.abs(velocity / 2 - pulled) ** 2 / (2 * admittance.real))
        assert programme.bound(list(upper), list(lower)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("limits", [(3e3, np.inf), (np.inf, 0.3), (4e3, 6.0), (np.inf, np.inf)])
def test_the_optimum_in_a_sea_is_that_of_the_velocity_its_components_give_the_port(limits):
    """Between them nothing moves it; force and stroke are limited as given."""
    velocity, admittance = buoy(WAVES)
    components = np.array([1, 2, 5])
    waves = Sea(WAVES.omega[components], np.array([0.5, -0.3j, 0.2 + 0.1j]))
    amplitude = np.zeros(WAVES.count, dtype=complex)
    amplitude[components] = waves.amplitude
    found = constrained.optimum_in_sea(Port(WAVES.omega, admittance, velocity, 0.0), waves, WAVES, *limits)
    expected = constrained_optimum(WAVES, velocity * amplitude, admittance, *limits)
    assert (found.power, found.bound, found.steps) == (expected.power, expected.bound, expected.steps)
    np.testing.assert_array_equal(found.force, expected.force)


def test_a_port_that_gives_out_energy_is_told_where_it_does_most():
    velocity, admittance = buoy(WAVES)
    wrong = admittance.copy()
    wrong[[2, 4, 6]] = -1e-6, -3e-5, -1e-5
    words = rf"^port: received Re Y = -3e-05 m/\(N s\) at {WAVES.omega[4]:.4g} rad/s, needs more than 0"
    with pytest.raises(ValueError, match=words):
        constrained_optimum(WAVES, velocity, wrong, 1e3)
    wrong[[2, 4, 6]] = 0.0
    with pytest.raises(ValueError, match=rf"^port: received Re Y = 0 m/\(N s\) at {WAVES.omega[2]:.4g} rad/s"):
        constrained_optimum(WAVES, velocity, wrong, 1e3)


def test_a_port_that_gives_out_energy_is_refused():
    velocity, admittance = buoy(WAVES)
    with pytest.raises(ValueError, match=r"port: received Re Y = -1e-05 .* at 4 rad/s, needs more than 0"):
        constrained_optimum(WAVES, velocity, np.where(WAVES.omega == 4.0, -1e-5, admittance), 1e3)


def test_an_optimum_not_found_in_time_is_an_error(monkeypatch):
    monkeypatch.setattr(constrained, "MOST_STEPS", 2)
    velocity, admittance = buoy(SEA)
    with pytest.raises(
        ConvergenceError,
        match=r"^pto: the optimum under limits is not found to 1e-06 in 2 steps \(gap [\d.e+-]+\); needs limits that leave",
    ):
        constrained_optimum(SEA, velocity, admittance, 1e3)


@pytest.mark.parametrize(("seed", "share"), [(0, 0.9), (1, 0.5)])
def test_where_keeping_the_stroke_costs_power_the_least_cost_is_found(seed, share):
    """Limits that leave hardly any room: all a force can do there is to give power, and the bound is below zero too."""
    harmonics = Harmonics(0.26, 0.5, 16)
    velocity, admittance = buoy(harmonics, resonance=0.5, seed=seed, loss=50.0)
    limits = np.array([5e3, share * np.abs(harmonics.signal(velocity / (-1j * harmonics.omega))).max()])
    limits *= 1.002 * least_share(harmonics, velocity, admittance, *limits)
    found = constrained_optimum(harmonics, velocity, admittance, *limits)
    assert found.power < 0
    assert found.bound < 0
    assert found.power == pytest.approx(power(velocity, admittance, found.force), rel=1e-12)
    assert abs(found.gap) <= 1e-6
    assert found.bound - found.power == pytest.approx(found.gap * abs(found.bound), rel=1e-9)
    assert found.force_peak <= limits[0] * (1 + 1e-9)
    assert found.stroke_peak <= limits[1] * (1 + 1e-9)


def test_peaks_are_sizes_at_the_instants_whichever_way_they_go():
    """Of velocities and their opposite, whose optimum is the opposite."""
    velocity, admittance = buoy(SEA)
    for limits in ((3e3, np.inf), (np.inf, 0.3)):
        found, other = (constrained_optimum(SEA, sign * velocity, admittance, *limits) for sign in (1, -1))
        for signal, peak, opposite in (
            (SEA.signal(found.force), found.force_peak, other.force_peak),
            (SEA.signal(found.stroke), found.stroke_peak, other.stroke_peak),
        ):
            assert peak == np.abs(signal).max()
            assert opposite == pytest.approx(peak, rel=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("limits", [(), (1e3, np.inf), (np.inf, 0.3), (1e3, 0.3)])
def test_in_still_water_there_is_nothing_to_take_and_no_gap(limits):
    velocity, admittance = buoy(SEA)
    found = constrained_optimum(SEA, 0 * velocity, admittance, *limits)
    assert (found.power, found.bound, found.gap, found.steps) == (0.0, 0.0, 0.0, 0)
    assert (found.force_rms, found.force_peak, found.stroke_peak, found.excess) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("over", [(1.1, 1.3), (1.3, 1.1), (0.9, 1.2), (1.2, 0.9), (0.9, 0.8)])
def test_what_exceeds_limits_between_the_instants_is_that_of_the_worst_and_none_where_both_are_kept(over):
    rng = np.random.default_rng(4)
    force, stroke = rng.normal(size=(2, SEA.count)) + 1j * rng.normal(size=(2, SEA.count))
    peaks = [np.abs(SEA.signal(x, constrained.BETWEEN)).max() for x in (force, stroke)]
    gains = np.ones(SEA.count, dtype=complex), 2j * np.ones(SEA.count)
    limits = [
        constrained.Limit(np.zeros(SEA.instants), gain, peak / part)
        for gain, peak, part in zip(gains, peaks, over, strict=True)
    ]
    programme = constrained._Programme(SEA, force, np.ones(SEA.count), limits)
    found = constrained._reported(programme, force, stroke, 7.0, 3)
    assert found.excess == pytest.approx(max(0.0, max(over) - 1), abs=1e-12)
    assert found.force_peak == np.abs(SEA.signal(force)).max()
    assert found.stroke_peak == np.abs(SEA.signal(stroke)).max()
    assert (found.bound, found.steps, found.power) == (7.0, 3, programme.power(force))
