"""The bound of every force within limits: its integral, its limits, any multipliers, any forces, all laws in time."""

import numpy as np
import pytest
from motion.test_harmonics import buoy
from scipy.optimize import minimize

from vsb.hydro.statespace import RadiationModel
from vsb.integrators.switching import Switching
from vsb.motion import force_bound as module
from vsb.motion.constrained import constrained_optimum
from vsb.motion.force_bound import Limits, force_bound, mean_magnitude
from vsb.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import TakeOff

SEA, WAVES = Harmonics(0.13, 0.5, 40), Harmonics(0.8, 1.0, 9)


# the mean of a magnitude ---------------------------------------------------------------------------------------------


def test_the_mean_magnitude_of_a_sine_is_two_over_pi():
    for first in (1.0, 0.5, 7.0):
        found = mean_magnitude(Harmonics(0.7, first, 1), np.array([3.0 - 4.0j]))
        assert found == pytest.approx(10 / np.pi, rel=1e-6)
        assert found >= 10 / np.pi * (1 - 1e-13)


@pytest.mark.parametrize("cells", [1, 2, 8, 32])
@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_the_mean_magnitude_is_never_below_the_true_one(harmonics, cells):
    """Against the mean over roots of the polynomial itself, however few cells there are."""
    rng = np.random.default_rng(cells)
    for power in (0.0, 1.0, 3.0):
        c = rng.normal(size=(2, harmonics.count)).T @ [1, 1j] / (1 + np.arange(harmonics.count)) ** power
        exact = by_roots(harmonics, c)
        found = mean_magnitude(harmonics, c, cells)
        assert exact * (1 - 1e-10) <= found
        if cells == 32:
            assert found <= exact * (1 + 1e-5)


def by_roots(harmonics, c):
    """Mean of |Re sum c_k z^order|, between the roots on the unit circle of a polynomial in z (or its square root)."""
    orders = np.rint(2 * (harmonics.first + np.arange(harmonics.count))).astype(int)
    double = np.zeros(2 * orders[-1] + 1, dtype=complex)  # in exp(-i spacing t/2), orders from -last to last
    double[orders[-1] + orders] += c / 2
    double[orders[-1] - orders] += c.conj() / 2
    roots = np.roots(double[::-1])
    angle = np.sort(-np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-6]) % (2 * np.pi))
    time = 2 * np.append(angle, angle[0] + 2 * np.pi) / harmonics.spacing
    integral = (c / (-1j * harmonics.omega) * np.exp(-1j * np.outer(time, harmonics.omega))).sum(axis=1).real
    return float(np.abs(np.diff(integral)).sum() * harmonics.spacing / (4 * np.pi))


def test_a_signal_that_only_touches_zero_is_not_underestimated():
    """4 cos^3 t, shifted between the nodes of the coarsest cells: a triple zero."""
    harmonics = Harmonics(1.0, 1.0, 9)
    for shift in np.linspace(0, 0.2, 21):
        c = np.zeros(9, dtype=complex)
        c[[0, 2]] = np.array([3.0, 1.0]) * np.exp(1j * shift * np.array([1, 3]))
        exact = 4 * 4 / (3 * np.pi)
        assert exact * (1 - 1e-12) <= mean_magnitude(harmonics, c, 1) <= exact * 1.05


# limits of limits ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_a_small_force_takes_its_limit_times_the_mean_speed_and_an_unlimited_one_the_matched_power(harmonics):
    velocity, admittance = buoy(harmonics)
    small = force_bound(harmonics, velocity, admittance, Limits(1e-2)).power
    assert small == pytest.approx(1e-2 * by_roots(harmonics, velocity), rel=1e-4)
    matched = np.sum(np.abs(velocity) ** 2 / (8 * admittance.real))
    for limits in (Limits(1e9), Limits(1e9, 1e9), Limits(stroke=1e9)):
        assert force_bound(harmonics, velocity, admittance, limits).power == pytest.approx(matched, rel=1e-9)
    assert force_bound(harmonics, velocity, admittance, Limits(1e9, 1.0)).power == pytest.approx(
        force_bound(harmonics, velocity, admittance, Limits(stroke=1.0)).power, rel=1e-3
    )


@pytest.mark.parametrize("limits", [Limits(3e3), Limits(1e4), Limits(stroke=0.3), Limits(4e4, 2.0), Limits(4e3, 6.0)])
def test_the_multipliers_are_the_best_ones_by_a_general_minimiser(limits):
    """BFGS on all real and imaginary parts of both multipliers, from where those found are not known."""
    harmonics = Harmonics(0.8, 1.0, 3)
    velocity, admittance = buoy(harmonics)
    time = np.arange(4096) * 2 * np.pi / harmonics.spacing / 4096
    turning = np.exp(-1j * np.outer(time, harmonics.omega))
    force, stroke = (limit if np.isfinite(limit) else 0.0 for limit in limits)
    scale = np.abs(velocity).max()

    def bound(x):
        """As it is written in the literature of the bound: means of magnitudes and a sum of squares."""
        m, n = np.split(x[:6] + 1j * x[6:], 2)
        m, n = (scale * m if force else 0 * m), (scale * 1e3 * n if stroke else 0 * n)
        rest = velocity - m + n * admittance.conj() / (1j * harmonics.omega)
        sizes = force * np.abs((turning @ m).real).mean() + stroke * np.abs((turning @ n).real).mean()
        still = 0.5 * np.sum((n.conj() * velocity / (-1j * harmonics.omega)).real)
        return float(sizes - still + np.sum(np.abs(rest) ** 2 / (8 * admittance.real)))

    best = min(
        minimize(bound, np.random.default_rng(seed).normal(size=12), options={"maxiter": 4000}).fun for seed in (0, 1)
    )
    assert force_bound(harmonics, velocity, admittance, limits, tolerance=1e-6).power == pytest.approx(best, rel=3e-3)


def test_the_bound_falls_with_the_limits_and_is_concave_in_the_force():
    velocity, admittance = buoy(SEA)
    limits = np.linspace(1e3, 1.2e4, 8)
    bounds = np.array([force_bound(SEA, velocity, admittance, Limits(f), tolerance=1e-7).power for f in limits])
    assert np.all(np.diff(bounds) > 0)
    assert np.all(np.diff(bounds, 2) < 1e-5 * bounds[-1])
    strokes = [force_bound(SEA, velocity, admittance, Limits(2e4, s)).power for s in (4.0, 3.0, 2.0)]
    assert np.all(np.diff(strokes) < 0)


def test_steps_that_run_out_leave_a_bound(monkeypatch):
    """Whatever the multipliers are."""
    velocity, admittance = buoy(SEA)
    best = force_bound(SEA, velocity, admittance, Limits(3e3)).power
    for steps in (1, 2, 4):
        monkeypatch.setattr(module, "MOST_STEPS", steps)
        assert force_bound(SEA, velocity, admittance, Limits(3e3)).power >= best * (1 - 2e-4)


# forces of any kind --------------------------------------------------------------------------------------------------


class Oscillator:
    """A mass on a spring with a damper and a passive memory of two states, its admittance known at any frequency."""

    def __init__(self, rng):
        self.mass, self.stiffness, self.drag = 2.0, 2.0 * rng.uniform(1.0, 6.0) ** 2, 10 ** rng.uniform(-0.5, 0.8)
        channel, self.push = rng.normal(size=2), rng.normal(size=(2, 1)) * 2
        turning = np.array([[0.0, 1.0], [-1.0, 0.0]]) * rng.uniform(2.0, 6.0)
        self.memory = RadiationModel(turning - np.outer(channel, channel) / 2, self.push, channel)

    def admittance(self, omega):
        memory = [
            self.push.T @ np.linalg.solve(-1j * w * np.eye(2) - self.memory.state_matrix, self.push) for w in omega
        ]
        z = -1j * omega * self.mass + self.drag + 1j * self.stiffness / omega + np.array(memory)[:, 0, 0]
        return 1 / z

    def port(self, harmonics):
        y = self.admittance(harmonics.port_omega)
        return Port(harmonics.port_omega, y, y, 1 / self.stiffness)  # velocity per unit of exciting force

    def system(self, law, omega, phasors):
        forces = {
            "hydrostatic": Spring(np.array([[self.stiffness]])),
            "pto": law,
            "structural_damping": Damper(np.array([[self.drag]])),
            "excitation": Excitation(omega, phasors[:, None]),
            "radiation": RadiationMemory(self.memory),
        }
        return System.of(Scene(("Heave",), np.array([[self.mass]]), forces, np.eye(1)))


def random_waves(rng):
    """Regular or of several components, all of one period, and the harmonics they are bounded with."""
    orders = np.array([1]) if rng.uniform() < 0.5 else np.sort(rng.choice(np.arange(2, 7), 3, replace=False))
    spacing = rng.uniform(1.5, 5.0) / orders.mean()
    phasors = 30 * rng.rayleigh(size=len(orders)) * np.exp(2j * np.pi * rng.uniform(size=len(orders)))
    harmonics = Harmonics(spacing, 1.0, 4 * int(orders[-1]))
    amplitude = np.zeros(harmonics.count, dtype=complex)
    amplitude[orders - 1] = phasors
    return harmonics, amplitude, orders * spacing, phasors


def laws(rng, damper, limit, period):
    pause = period * rng.uniform(0.05, 0.3)
    return {
        "saturated": TakeOff(B, damper, limit=limit),
        "with a spring": TakeOff(B, damper, -rng.uniform(0.0, 1.0), limit),
        "coulomb": TakeOff(B, np.inf, limit=limit),
        "latching": TakeOff(B, damper, limit=limit, pause=pause),
        "declutching": TakeOff(B, damper, limit=limit, pause=pause, paused_damping=0.0),
        "hydraulic, declutched": TakeOff(B, np.inf, limit=limit, pause=pause, paused_damping=0.0),
    }


B = np.array([1.0])


def mean_power(system, period, count=24, last=6):
    """Mean power of a take-off in late periods, and by how much it differs between two halves of them."""
    start = system.scene.start(0.0, 0.0)
    motion, _ = Switching(system).follow(np.linspace(0.0, count * period, count * 64 + 1), start)
    power = np.diff(motion.works["pto"][::64])[-last:] / period
    return power.mean(), abs(power[: last // 2].mean() - power[last // 2 :].mean())


@pytest.mark.parametrize("start", range(0, 100, 20))
def test_no_law_in_time_absorbs_more_in_a_hundred_random_cases(start):
    """Followed exactly between switches till they repeat, each case under a law of its own."""
    ratios = []
    for number in range(start, start + 20):
        rng = np.random.default_rng(number)
        device, (harmonics, amplitude, omega, phasors) = Oscillator(rng), random_waves(rng)
        port, period = device.port(harmonics), 2 * np.pi / harmonics.spacing
        matched = np.abs(port.matched_force[: harmonics.count] * amplitude).sum()
        limit, damper = matched * 10 ** rng.uniform(-1.5, 0.1), device.drag * 10 ** rng.uniform(-0.5, 1.0)
        best = constrained_optimum(harmonics, port, amplitude, Limits(limit))
        assert best.power <= best.bound
        name, law = list(laws(rng, damper, limit, 2 * np.pi / omega.mean()).items())[number % 6]
        power, unsettled = mean_power(device.system(law, omega, phasors), period)
        assert power - unsettled <= best.bound * (1 + 1e-9), (number, name)
        ratios.append(power / best.bound)
    assert max(ratios) > 0.95
    assert min(ratios) > -0.01


@pytest.mark.parametrize("number", range(20))
def test_a_force_of_enough_harmonics_comes_near_the_bound(number):
    """Which falls with the harmonics its multipliers have; the force found is one of those it bounds."""
    rng = np.random.default_rng(number)
    device, (narrow, amplitude, _, _) = Oscillator(rng), random_waves(rng)
    wide = Harmonics(narrow.spacing, narrow.first, 5 * narrow.count)
    amplitude = np.append(amplitude, np.zeros(4 * narrow.count))
    limit = np.abs(device.port(wide).matched_force[: wide.count] * amplitude).sum() * 10 ** rng.uniform(-1.5, 0.1)
    near = constrained_optimum(wide, device.port(wide), amplitude, Limits(limit))
    far = constrained_optimum(narrow, device.port(narrow), amplitude[: narrow.count], Limits(limit))
    assert 0 <= near.gap < 0.005
    assert near.power <= far.bound
    assert near.bound <= far.bound * (1 + 1e-4)


@pytest.mark.parametrize("number", range(8))
def test_no_arbitrary_force_within_its_limits_absorbs_more(number):
    """Steps, sines, noise and the sign of speeds, over three periods of the sea; every harmonic up to a high one counts."""
    rng = np.random.default_rng(number)
    device, (harmonics, amplitude, _, _) = Oscillator(rng), random_waves(rng)
    port, times, n = device.port(harmonics), 3, 3 * 4096
    time = np.arange(n) * times * 2 * np.pi / harmonics.spacing / n
    omega = np.arange(1, n // 2) * harmonics.spacing / times
    admittance, free = device.admittance(omega), np.zeros(len(omega), dtype=complex)
    free[times * np.arange(1, harmonics.count + 1) - 1] = port.velocity[: harmonics.count] * amplitude
    back = np.exp(1j * np.outer(omega[: 3 * times * harmonics.count], time))
    v0 = (back.conj().T @ free[: len(back)]).real
    for shape in ("sign", "late", "steps", "noise"):
        force = {
            "sign": np.sign(v0),
            "late": np.sign(np.roll(v0, rng.integers(0, 400))),
            "steps": np.repeat(rng.choice([-1.0, 1.0], n // 64), 64) * (rng.uniform(size=n) < 0.9),
            "noise": np.clip(v0 / np.abs(v0).max() * 3 + rng.normal(size=n), -1, 1),
        }[shape] * 10 ** rng.uniform(-0.5, 1.5)
        f = 2 * np.fft.ifft(force)[1 : n // 2]
        power = float(np.sum((f.conj() * free).real - admittance.real * np.abs(f) ** 2) / 2)
        moved = np.zeros(n, dtype=complex)
        moved[1 : n // 2] = (free - admittance * f) / (-1j * omega)
        stroke = np.abs(np.fft.fft(moved).real - force.mean() / device.stiffness).max()
        velocity = port.velocity[: harmonics.count] * amplitude
        for limits in (Limits(np.abs(force).max()), Limits(np.abs(force).max(), stroke), Limits(stroke=stroke)):
            bound = force_bound(harmonics, velocity, port.admittance[: harmonics.count], limits).power
            assert power <= bound * (1 + 1e-9) + 1e-12, (shape, limits)


# the buoy of the seed ------------------------------------------------------------------------------------------------

ORDERS = 2 * np.pi / 2.5 * np.arange(1, 5)
SEED_PORT = np.array(
    [
        4.886164753e-05 + 5.869271430e-05j,
        9.194015399e-08 + 1.000763943e-05j,
        2.886481549e-09 + 5.715854500e-06j,
        2.199675356e-10 + 4.087607855e-06j,
    ]
)
"""Y of the rigid half-immersed sphere of 2 m and 17170 kg at 2 pi/2.5 s and its multiples below 12 rad/s [m/(N s)]."""
SEED_VELOCITY = 0.24406194601  # in a wave of 0.1 m [m/s]


def test_coulombs_force_on_the_seed_beats_the_harmonics_up_to_omega_max_and_stays_below_the_bound():
    """2.5 s, 0.1 m, 300 N: 42.82 W by a run in time, and 39.4 W by the best force of four harmonics at instants.

    By hand: of a square wave the fundamental is 4/pi; it loses at odd multiples what the port loses there.
    """
    harmonics, velocity = Harmonics(ORDERS[0], 1.0, 4), np.array([SEED_VELOCITY, 0, 0, 0], dtype=complex)
    bound = force_bound(harmonics, velocity, SEED_PORT, Limits(300.0)).power
    square = 300.0 * 4 / np.pi / np.array([1.0, 3.0])
    in_phase = square[0] * SEED_VELOCITY / 2 - SEED_PORT.real[[0, 2]] @ square**2 / 2
    assert in_phase == pytest.approx(43.04, abs=0.02)  # its best phase; Coulomb's own is not quite
    assert 42.8224 < in_phase < bound < in_phase * 1.001
    admittance = np.append(SEED_PORT, np.full(len(harmonics.outside), 1e-10))
    port = Port(harmonics.port_omega, admittance, np.ones(len(admittance)), 1e-5)
    best = constrained_optimum(harmonics, port, velocity, Limits(300.0))
    assert best.power == pytest.approx(in_phase, rel=1e-3)
    assert best.power <= best.bound == pytest.approx(bound, rel=1e-12)
    assert best.force_peak <= 300.0
