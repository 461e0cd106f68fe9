"""Causal control of several ports: what one port gives, turned ports, order of dampers, causal control and all waves."""

import numpy as np
import pytest
from motion.test_causal import buoy, companion, lqg
from scipy.linalg import block_diag

from vsb.engine.motion import causal
from vsb.engine.motion.causal import NOISE, RmsLimits, Weights, numerical_error
from vsb.engine.motion.causal_ports import StationaryPorts, optimum
from vsb.engine.motion.damper_matrix import Ports, best_matrix
from vsb.engine.waves.kinds import jonswap_spectrum


def diagonal(*ports):
    """Uncoupled ports in waves that have nothing to do with each other."""
    admittance, spectrum = (
        np.stack([getattr(port, name) for port in ports], axis=-1)[:, :, None] * np.eye(len(ports))
        for name in ("admittance", "spectrum")
    )
    return StationaryPorts(ports[0].spacing, admittance, spectrum + 0j)


def coupled():
    """Two masses on springs, coupled, with losses and one channel of radiation, in a sea; and what its waves see."""
    spacing = 0.01
    omega = (np.arange(1200) + 0.5) * spacing
    excitation = np.stack([3e4 * np.exp(-((omega / 2) ** 2)), 1e4 * np.exp(-((omega / 2.2) ** 2))], axis=1)
    lost = excitation[:, :, None] * excitation[:, None] * (omega**3 / 2e7)[:, None, None] + np.diag([6e3, 3e3])
    mass, stiffness = np.array([[3e4, 4e3], [4e3, 1e4]]), np.array([[1e5, 1e4], [1e4, 9e4]])
    at = omega[:, None, None]
    admittance = np.linalg.inv(lost - 1j * at * mass + 1j * stiffness / at)
    free = np.einsum("wij,wj->wi", admittance, excitation)
    density = jonswap_spectrum(omega, 1.0, 4.0, 3.3)
    spectrum = free[:, :, None] * free[:, None].conj() * density[:, None, None]
    return StationaryPorts(spacing, admittance, spectrum), Ports(omega, admittance, free), 2 * density * spacing


@pytest.mark.parametrize("forecast", [0.0, 1.0, np.inf])
def test_one_port_is_a_matrix_of_one_entry(forecast):
    port, noise = buoy(spacing=0.02, top=12.0), 0.0 if np.isinf(forecast) else NOISE
    one, many = (
        causal.optimum(port, RmsLimits(2e3), noise, forecast),
        optimum(diagonal(port), 2e3, noise, forecast),
    )
    assert (many.power, many.force) == pytest.approx((one.power, one.force), rel=1e-9)


def test_uncoupled_ports_are_controlled_each_by_itself():
    """At one weight, and with the same density of the noise at both."""
    first, second = buoy(spacing=0.02, top=12.0), buoy(6.0, 0.02, 12.0, 1.2)
    both, peaks = diagonal(first, second), [port.excitation.max() for port in (first, second)]
    level = 1e-5 * min(peaks)
    alone = [port.controlled(Weights(1e-4), level / peak) for port, peak in zip((first, second), peaks, strict=True)]
    found = both.controlled(Weights(1e-4), level / float(np.einsum("wii->w", both.excitation).real.max()))
    assert found.power == pytest.approx(sum(one.power for one in alone), rel=1e-9)
    assert found.force == pytest.approx(sum(one.force for one in alone), rel=1e-9)


@pytest.mark.parametrize("share", [0.1, 1.0])
def test_power_grows_with_knowledge_whatever_the_ports_are_turned_by(share):
    ports, seen, squares = coupled()
    matrix = best_matrix(seen, squares, "full").damping
    if share < 1:
        matrix = 0.05 * matrix
    force = float(np.sqrt(0.5 * squares @ (np.abs(seen.velocity_under(matrix) @ matrix) ** 2).sum(axis=1)))
    found = [optimum(ports, force, 1e-7, time) for time in (0.0, 1.0, 4.0)]
    rising = [float(squares @ seen.power(matrix)), *(one.power for one in found)]
    rising += [optimum(ports, force, 0.0, np.inf).power, ports.matched_power]
    assert np.all(np.diff(rising) > 0), rising
    assert found[0].force_rms == pytest.approx(force, rel=1e-6)
    assert numerical_error(ports, optimum(ports, force), NOISE, 0.0) < 0.02
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    assert optimum(ports.over(turn), force, 1e-7).power == pytest.approx(found[0].power, rel=1e-6)
    idle = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])  # a third port moves as the first: two share a force better
    assert optimum(ports.over(idle), force, 1e-7).power > found[0].power


def test_the_mean_square_of_the_forces_is_the_slope_of_the_optimum():
    ports, weight, step = coupled()[0], 3e-5, 1e-4
    found = ports.controlled(Weights(weight))
    ends = [ports.controlled(Weights(weight * (1 + s))).objective for s in (step, -step)]
    assert (ends[1] - ends[0]) / (2 * step * weight) == pytest.approx(found.force, rel=1e-6)


@pytest.mark.parametrize("forecast", [0.0, 1.5])
def test_the_controller_absorbs_the_power_of_the_optimum(forecast):
    ports, weights = coupled()[0], Weights(3e-5)
    gain, found = ports.controller(weights, NOISE, forecast), ports.controlled(weights, NOISE, forecast)
    y, waves = ports.admittance, ports.excitation
    peak = np.einsum("wii->w", waves).real.max()
    back = gain.conj().swapaxes(1, 2)
    force = gain @ (waves + NOISE * peak * np.eye(2)) @ back
    power = ports.spacing * np.einsum("wii->", y @ waves @ back - y @ force).real
    assert power == pytest.approx(found.power, rel=1e-3)
    beyond = found.force - ports.spacing * np.einsum("wii->", force).real  # what follows noise beyond the band
    assert 0 <= beyond < 5e-3 * found.force


@pytest.mark.parametrize(("price", "share"), [(2e-5, 1e-3), (2e-4, 1e-1)])
def test_rational_ports_agree_with_the_riccati_equation(price, share):
    """Two coupled masses in two seas; the grid errs with the square of its time step, which extrapolation takes away."""
    mass, resistance = np.array([[3e4, 4e3], [4e3, 1e4]]), np.array([[4e3, 1e3], [1e3, 3e3]])
    stiffness = np.array([[8e4, 1e4], [1e4, 9e4]])
    a_w = block_diag(
        companion(-0.2 + 1.3j, -0.2 - 1.3j, -0.5 + 1.5j, -0.5 - 1.5j),
        companion(-0.3 + 1.6j, -0.3 - 1.6j, -0.5 + 1.2j, -0.5 - 1.2j),
    )
    b_w, c_w = np.eye(8)[:, [3, 7]], 1e3 * np.kron([[1.0, 0.0], [0.5, 0.7]], [[0.0, 1.0, 0.0, 0.0]])
    found = []
    for top in (80.0, 160.0):
        s = (-1j * (np.arange(int(top / 0.02)) + 0.5) * 0.02)[:, None, None]
        y = s * np.linalg.inv(mass * s**2 + resistance * s + stiffness)
        shaped = c_w @ np.linalg.solve(s * np.eye(8) - a_w, b_w + 0j)
        waves = shaped @ shaped.conj().swapaxes(1, 2) / np.pi
        ports = StationaryPorts(0.02, y, y @ waves @ y.conj().swapaxes(1, 2))
        one = ports.controlled(Weights(price), share)
        found.append([one.power, one.force])
        peak = np.einsum("wii->w", waves).real.max()
    expected = lqg(mass, resistance, stiffness, (a_w, b_w, c_w), share * peak * np.pi, price)
    np.testing.assert_allclose((4 * np.array(found[1]) - found[0]) / 3, expected, rtol=1e-6)
    np.testing.assert_allclose(found[1], expected, rtol=1e-5)
