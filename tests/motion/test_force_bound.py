"""The bound of every limited force: harmonics, its integral, its limits, arbitrary forces and laws in time."""

import numpy as np
import pytest
from conftest import varied
from scipy.linalg import hankel, toeplitz

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.switching import Switching
from vsb.engine.motion.constrained import constrained_optimum, optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits, force_bound, mean_magnitude
from vsb.engine.motion.forces import Damper, Excitation, RadiationMemory, Spring, TakeOff
from vsb.engine.motion.port import Port
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.errors import ConfigError

SEA = Harmonics(0.13, 0.5, 40)
WAVES = Harmonics(0.8, 1.0, 9)
MASS = 3e4


def admittance(omega, resonance=1.6, loss=500.0):
    """Admittance of a mass on a spring with radiation [m/(N s)]."""
    resistance = loss + 8e3 * omega**2 * np.exp(-omega)
    return 1 / (resistance - 1j * MASS * (omega - resonance**2 / omega))


def buoy(harmonics, resonance=1.6, seed=0, loss=500.0):
    """Its free velocity in a sea of random phases, and its admittance, at the harmonics of the band."""
    w = harmonics.omega
    y = admittance(w, resonance, loss)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(w))
    return y * 2e4 * np.exp(-(((w - 1.3) / 0.6) ** 2) + 1j * phase), y


def buoy_port(harmonics, resonance=1.6, seed=0, loss=500.0):
    """Its port in and outside the band, whose velocity is that of `buoy` in waves of amplitude 1 at all harmonics."""
    velocity, _ = buoy(harmonics, resonance, seed, loss)
    y = admittance(harmonics.port_omega, resonance, loss)
    outside = np.zeros(len(harmonics.outside))
    return Port(harmonics.port_omega, y, np.append(velocity, outside), 1 / (MASS * resonance**2))


def instants(harmonics, count):
    return np.arange(count) * 2 * np.pi / harmonics.spacing / count


@pytest.mark.parametrize("harmonics", [SEA, Harmonics(0.3, 4.0, 1)])
def test_transforms_match_plain_sums(harmonics):
    rng = np.random.default_rng(3)
    time = instants(harmonics, harmonics.instants)
    waves = np.exp(1j * np.outer(harmonics.omega, time))  # e_k(t_j)
    c = rng.normal(size=harmonics.count) + 1j * rng.normal(size=harmonics.count)
    w = rng.uniform(size=len(time))
    np.testing.assert_allclose(harmonics.signal(c), (c @ waves.conj()).real, atol=1e-12)
    np.testing.assert_allclose(harmonics.phasors(w), waves @ w, atol=1e-12)
    apart, together = harmonics.products(w)
    n = harmonics.count
    np.testing.assert_allclose(toeplitz(apart), (waves * w) @ waves.conj().T, atol=1e-11)
    np.testing.assert_allclose(hankel(together[:n], together[n - 1 :]), (waves * w) @ waves.T, atol=1e-11)
    finer = (c @ np.exp(-1j * np.outer(harmonics.omega, instants(harmonics, 3 * harmonics.instants)))).real
    np.testing.assert_allclose(harmonics.signal(c, 3), finer, atol=1e-12)


@pytest.mark.parametrize("harmonics", [SEA, Harmonics(0.3, 4.0, 3)])
def test_harmonics_outside_the_band_match_plain_sums(harmonics):
    """All frequencies of the period up to four times the highest one of the band."""
    spacing, rng = harmonics.spacing, np.random.default_rng(4)
    together = np.sort(harmonics.port_omega) / spacing
    first = harmonics.first % 1 or 1.0
    np.testing.assert_allclose(together, first + np.arange(len(together)), rtol=1e-12)
    assert 4 * harmonics.omega[-1] <= together[-1] * spacing < 4 * (harmonics.omega[-1] + spacing)
    time, weights = instants(harmonics, 8 * harmonics.instants), rng.normal(size=8 * harmonics.instants)
    outside = np.exp(1j * np.outer(harmonics.outside, time))
    np.testing.assert_allclose(harmonics.phasors_outside(weights), outside @ weights, atol=1e-10)
    c, d = (rng.normal(size=(2, n)).T @ [1, 1j] for n in (harmonics.count, len(harmonics.outside)))
    expected = harmonics.signal(c, 8) + (d @ outside.conj()).real
    np.testing.assert_allclose(harmonics.signal(c, 8, d), expected, atol=1e-10)


@pytest.mark.parametrize(
    "wave", [{"kind": "regular", "amplitude": 0.1, "period": 2.5}, {"kind": "jonswap", "hs": 0.5, "tp": 3.0}]
)
def test_harmonics_of_a_sea_contain_its_components(seed, wave):
    (chosen,) = varied(seed, waves=[wave]).waves
    waves = chosen.realisation(12.0, 60.0)
    harmonics = Harmonics.of_sea(waves.omega, 0.1, 12.0)
    at = np.searchsorted(harmonics.omega, waves.omega - 1e-9)
    np.testing.assert_allclose(harmonics.omega[at], waves.omega, rtol=1e-9)
    assert 0.1 - 1e-9 <= harmonics.omega[0] < 0.1 + harmonics.spacing
    assert 12.0 - harmonics.spacing < harmonics.omega[-1] <= 12.0 + 1e-9
    velocity, y = buoy(harmonics)
    power = np.sum(np.abs(velocity[at] * waves.amplitude) ** 2 / (8 * y.real[at]))
    assert optimum_in_sea(buoy_port(harmonics), waves, harmonics, Limits()).power == pytest.approx(power, rel=1e-12)


@pytest.mark.parametrize(
    "omega",
    [
        np.array([1.03, 1.13, 1.23]),
        np.array([1.0, 1.1, 1.25]),  # whole orders and a half one
    ],
)
def test_aperiodic_sea_is_refused(omega):
    received = (
        f"^waves: received components 0.1 rad/s apart from {omega[0]:.4g} rad/s on, which never repeat; an optimum"
    )
    with pytest.raises(ConfigError, match=f"{received} under limits needs multiples of half that: change the band or"):
        Harmonics.of_sea(omega, 0.1, 12.0)


SEA, WAVES = Harmonics(0.13, 0.5, 40), Harmonics(0.8, 1.0, 9)


@pytest.mark.parametrize("cells", [1, 32])
@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_mean_magnitude_is_an_upper_bound(harmonics, cells):
    """Compared with the mean between the roots of the polynomial, for any number of cells."""
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


@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_limits_of_small_and_unlimited_force(harmonics):
    """A small force absorbs its limit times the mean speed, an unlimited one the matched power."""
    velocity, admittance = buoy(harmonics)
    small = force_bound(harmonics, velocity, admittance, Limits(1e-2)).power
    assert small == pytest.approx(1e-2 * by_roots(harmonics, velocity), rel=1e-4)
    matched = np.sum(np.abs(velocity) ** 2 / (8 * admittance.real))
    for limits in (Limits(1e9), Limits(1e9, 1e9), Limits(stroke=1e9)):
        assert force_bound(harmonics, velocity, admittance, limits).power == pytest.approx(matched, rel=1e-9)
    assert force_bound(harmonics, velocity, admittance, Limits(1e9, 1.0)).power == pytest.approx(
        force_bound(harmonics, velocity, admittance, Limits(stroke=1.0)).power, rel=1e-3
    )


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
    latching_time = period * rng.uniform(0.05, 0.3)
    return {
        "saturated": TakeOff(B, damper, limit=limit),
        "with a spring": TakeOff(B, damper, -rng.uniform(0.0, 1.0), limit),
        "coulomb": TakeOff(B, np.inf, limit=limit),
        "latching": TakeOff(B, damper, limit=limit, latching_time=latching_time),
        "declutching": TakeOff(B, damper, limit=limit, latching_time=latching_time, latching_damping=0.0),
        "hydraulic, declutched": TakeOff(B, np.inf, limit=limit, latching_time=latching_time, latching_damping=0.0),
    }


B = np.array([1.0])


def mean_power(system, period, count=24, last=6):
    """Mean power of a take-off in late periods, and by how much it differs between two halves of them."""
    start = system.scene.start(0.0, 0.0)
    motion, _ = Switching(system).follow(np.linspace(0.0, count * period, count * 64 + 1), start)
    power = np.diff(motion.works["pto"][::64])[-last:] / period
    return power.mean(), abs(power[: last // 2].mean() - power[last // 2 :].mean())


@pytest.mark.slow
def test_no_law_in_time_exceeds_the_bound_in_random_cases():
    """A hundred, followed exactly between switches until they repeat, each under one of six laws."""
    ratios = []
    for number in range(100):
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


@pytest.mark.parametrize("number", range(2))
def test_no_arbitrary_force_exceeds_the_bound(number):
    """Steps, sines, noise and the sign of speeds, over three periods of the sea."""
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


def test_coulomb_force_stays_below_the_bound():
    """2.5 s, 0.1 m, 300 N: 42.82 W by a run in time. By hand: the fundamental of a square wave is 4/pi."""
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
