"""Signals of equally spaced frequencies: transforms against plain sums, periodic seas."""

import numpy as np
import pytest
from conftest import varied
from scipy.linalg import hankel, toeplitz

from vsb.engine.motion.constrained import optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port
from vsb.engine.waves.seas import sea
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
    waves = sea(chosen, 12.0, 60.0)
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
