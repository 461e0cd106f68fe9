"""Causal control: a Riccati equation, theorems of order and limits, losses in conversion, every weight's meaning."""

from dataclasses import replace

import numpy as np
import pytest
from motion.test_force_bound import MASS, admittance
from scipy.linalg import block_diag, solve_continuous_are, solve_continuous_lyapunov
from scipy.optimize import minimize

from vsb.engine.motion.causal import (
    NOISE,
    RmsLimits,
    StationaryPort,
    StationaryPorts,
    Weights,
    numerical_error,
    optimum,
)
from vsb.engine.motion.port import Port, Ports
from vsb.engine.motion.tuning import best_matrix, damper_within_force, priced_matrix
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.errors import StabilityError


def buoy(tp=4.0, spacing=0.01, top=24.0, resonance=1.6):
    """A mass on a spring with radiation, in a sea that pushes it less the shorter its waves."""
    omega = (np.arange(int(top / spacing)) + 0.5) * spacing
    y = admittance(omega, resonance)
    force = 3e4 * np.exp(-((omega / 2) ** 2))
    return StationaryPort(spacing, y, np.abs(y * force) ** 2 * jonswap_spectrum(omega, 1.0, tp, 3.3))


def damper(port, limit, efficiency=1.0):
    """The best damper whose force has at most a given rms, in the same sea."""
    moved = port.spectrum > 0
    seen = Port(
        port.omega[moved], port.admittance[moved], np.sqrt(2 * port.spacing * port.spectrum[moved]).astype(complex), 1.0
    )
    return damper_within_force(seen, np.ones((1, moved.sum())), limit, 0.0, efficiency)


def companion(*poles):
    """The state matrix of a filter 1/((s - p1)(s - p2)...), whose first state is its output."""
    matrix = np.diag(np.ones(len(poles) - 1), 1)
    matrix[-1] = -np.poly(poles).real[:0:-1]
    return matrix


def lqg(mass, resistance, stiffness, shaping, noise, price):
    """Mean power and mean square of the forces of the optimal regulator behind a Kalman filter of the wave forces.

    Matrices are of the ports. State: displacements, velocities, and those of a filter of white noise of intensity 1
    whose outputs are the forces of the waves.
    """
    a_w, b_w, c_w = shaping
    p = len(mass)
    n = 2 * p + len(a_w)
    a, b, drive, measured = np.zeros((n, n)), np.zeros((n, p)), np.zeros((n, b_w.shape[1])), np.zeros((p, n))
    a[:p, p : 2 * p], a[2 * p :, 2 * p :] = np.eye(p), a_w
    a[p : 2 * p] = np.linalg.solve(mass, np.hstack([-stiffness, -resistance, c_w]))
    b[p : 2 * p], drive[2 * p :], measured[:, 2 * p :] = -np.linalg.inv(mass), b_w, c_w
    velocity = np.eye(n)[p : 2 * p]
    riccati = solve_continuous_are(a, b, np.zeros((n, n)), price * np.eye(p), s=-velocity.T / 2)
    gain = (b.T @ riccati - velocity / 2) / price
    spread = solve_continuous_are(a.T, measured.T, drive @ drive.T, noise * np.eye(p))
    kalman = spread @ measured.T / noise
    loop = np.block([[a, -b @ gain], [kalman @ measured, a - b @ gain - kalman @ measured]])
    forcing = block_diag(drive, kalman * np.sqrt(noise))
    covariance = solve_continuous_lyapunov(loop, -forcing @ forcing.T)
    force, moved = np.hstack([np.zeros((p, n)), -gain]), np.hstack([velocity, np.zeros((p, n))])
    return float(np.trace(force @ covariance @ moved.T)), float(np.trace(force @ covariance @ force.T))


@pytest.mark.parametrize(("price", "share"), [(2e-4, 1e-3), (2e-5, 1e-3), (2e-5, 1e-1)])
def test_rational_model_agrees_with_the_riccati_equation(price, share):
    """White noise of intensity 1 has the one-sided density 1/pi."""
    mass, resistance, stiffness = 3e4, 4e3, 8e4
    poles = [-0.2 + 1.3j, -0.2 - 1.3j, -0.5 + 1.5j, -0.5 - 1.5j]
    shaping = companion(*poles), np.eye(4)[:, 3:], 1e3 * np.array([[0.0, 1.0, 0.0, 0.0]])
    spacing, top = 0.004, 160.0
    s = -1j * (np.arange(int(top / spacing)) + 0.5) * spacing
    y = s / (mass * s**2 + resistance * s + stiffness)
    excitation = np.abs(1e3 * s / np.polyval(np.poly(poles), s)) ** 2 / np.pi
    noise = share * excitation.max() * np.pi
    matrices = (np.array([[value]]) for value in (mass, resistance, stiffness))
    power, force = lqg(*matrices, shaping, noise, price)
    found = StationaryPort(spacing, y, np.abs(y) ** 2 * excitation).controlled(Weights(price), share)
    assert found.power == pytest.approx(power, rel=2e-4)
    assert found.force == pytest.approx(force, rel=2e-4)


@pytest.mark.parametrize(("tp", "share"), [(3.0, 0.1), (6.0, 0.5), (3.0, 1.0)])
def test_power_grows_with_knowledge_at_equal_force(tp, share):
    port = buoy(tp)
    limit = share * float(np.sqrt(optimum(port, RmsLimits(), 0.0, np.inf).force)) / 3
    rising = [float(damper(port, limit).power[0])]
    rising += [optimum(port, RmsLimits(limit), 1e-10, forecast).power for forecast in (0.0, 0.5, 2.0, 8.0)]
    rising.append(optimum(port, RmsLimits(limit), 0.0, np.inf).power)
    assert np.all(np.diff(rising) >= -1e-6 * rising[-1]), rising
    noisy = [optimum(port, RmsLimits(limit), noise).power for noise in (1e-3, 1e-5, 1e-8)]
    assert np.all(np.diff([*noisy, rising[1]]) > 0)
    assert optimum(port, RmsLimits(limit), 1e-5, 40.0).power == pytest.approx(
        optimum(port, RmsLimits(limit), 1e-5, np.inf).power, rel=1e-4
    )


def test_limits_of_force():
    """A scarce force follows the free velocity, P = F sigma(V0); one without a limit nears the matched power."""
    port = buoy()
    free, matched = np.sqrt(port.integral(port.spectrum)), port.integral(port.spectrum / (4 * port.admittance.real))
    weak, strong = optimum(port, RmsLimits(1.0), 1e-9), optimum(port, RmsLimits(), 1e-9)
    assert weak.power == pytest.approx(1.0 * free, rel=2e-3)
    assert weak.force_rms == pytest.approx(1.0, rel=1e-6)
    assert float(damper(port, 1.0).power[0]) == pytest.approx(1.0 * free, rel=2e-3)
    assert optimum(port, RmsLimits(), 0.0, np.inf).power == pytest.approx(matched, rel=1e-5)
    assert strong.power == pytest.approx(matched, rel=1e-3)
    assert port.matched_power == pytest.approx(matched)


@pytest.mark.parametrize("forecast", [0.0, 1.3])
def test_mean_squares_are_the_slopes_of_the_optimum(forecast):
    port, weights, step = buoy(), Weights(3e-5, 2e3, 5e2), 1e-4
    found = port.controlled(weights, 1e-5, forecast)
    for i, square in enumerate((found.force, found.stroke, found.speed)):
        ends = [
            port.controlled(weights._replace(**{weights._fields[i]: weights[i] * (1 + s)}), 1e-5, forecast).objective
            for s in (step, -step)
        ]
        assert (ends[1] - ends[0]) / (2 * step * weights[i]) == pytest.approx(square, rel=1e-6)


def test_limits_of_rms_force_and_stroke_hold():
    port = buoy()
    free = optimum(port, RmsLimits())
    for limits in (RmsLimits(0.2 * free.force_rms), RmsLimits(stroke=0.3 * free.stroke_rms)):
        found = optimum(port, limits)
        assert found.power < free.power
        assert (found.force_rms / limits.force, found.stroke_rms / limits.stroke) == pytest.approx(
            (1.0, 0.0) if np.isinf(limits.stroke) else (0.0, 1.0), rel=1e-6
        )
    both = optimum(port, RmsLimits(0.9 * found.force_rms, 0.3 * free.stroke_rms))
    assert both.power < found.power
    assert both.force_rms <= 0.9 * found.force_rms * (1 + 1e-6)
    assert both.stroke_rms == pytest.approx(0.3 * free.stroke_rms, rel=1e-6)
    with pytest.raises(StabilityError, match=r"pto: no control within force_limit keeps an rms displacement of"):
        optimum(port, RmsLimits(1.0, 0.3 * free.stroke_rms))


def test_losses_in_conversion_are_part_of_the_optimum():
    """No weights of force and velocity give more electrical power within the limit, and no damper."""
    port, scale = buoy(), 1 / MASS
    limit, efficiency = 2e3, 0.6
    found = optimum(port, RmsLimits(limit), efficiency=efficiency)

    def loss(x):
        tried = port.controlled(Weights(scale * np.exp(x[0]), 0.0, np.exp(x[1]) / scale))
        return -tried.converted(efficiency) + 1e3 * max(tried.force_rms / limit - 1, 0.0)

    starts = np.log([found.weights.force / scale, found.weights.speed * scale]) + 0.3
    best = minimize(loss, starts, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-8})
    assert found.force_rms <= limit * (1 + 1e-6)
    assert found.converted(efficiency) >= -best.fun * (1 - 1e-6)
    assert found.converted(efficiency) >= float(damper(port, limit, efficiency).power[0])
    assert found.converted(efficiency) < optimum(port, RmsLimits(limit)).power


@pytest.mark.parametrize(("tp", "force", "spacing"), [(4.0, 3e3, 0.015), (6.0, 1e3, 0.02)])
def test_numerical_error_is_small_and_covers_a_finer_grid(tp, force, spacing):
    """In waves of 6 s three times the spacing changes the power by chance by a third of what is left."""
    coarse, fine = buoy(tp, spacing), buoy(tp, spacing / 4, top=96.0)
    coarse, fine = (replace(one, spectrum=np.where(one.omega < 6, one.spectrum, 0.0)) for one in (coarse, fine))
    one, other = optimum(coarse, RmsLimits(force)), optimum(fine, RmsLimits(force))
    shift = one.power / coarse.matched_power / (other.power / fine.matched_power) - 1
    assert abs(shift) <= numerical_error(coarse, one, 1e-5, 0.0).size < 5e-3
    assert numerical_error(fine, other, 1e-5, 0.0).size < 2e-4


def test_ports_that_are_not_passive_are_refused():
    with pytest.raises(ValueError, match="port: not passive"):
        StationaryPort(0.1, np.array([-1e-6 + 1j]), np.ones(1))
    with pytest.raises(ValueError, match="spectrum: received a negative density"):
        StationaryPort(0.1, np.array([1e-6 + 1j]), -np.ones(1))
    still = StationaryPort(0.1, np.full(8, 1e-6 + 1j), np.zeros(8))
    assert optimum(still, RmsLimits()).power == 0.0


# causal control of several ports: what one port gives, turned ports, order of dampers, causal control -----------------


def diagonal(*ports):
    """Uncoupled ports in waves that have nothing to do with each other."""
    admittance, spectrum = (
        np.stack([getattr(port, name) for port in ports], axis=-1)[:, :, None] * np.eye(len(ports))
        for name in ("admittance", "spectrum")
    )
    return StationaryPorts(ports[0].spacing, admittance, spectrum + 0j)


def coupled(spacing=0.01):
    """Two masses on springs, coupled, with losses and one channel of radiation, in a sea; and what its waves see."""
    omega = (np.arange(round(12.0 / spacing)) + 0.5) * spacing
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
        optimum(port, RmsLimits(2e3), noise, forecast),
        optimum(diagonal(port), RmsLimits(2e3), noise, forecast),
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


@pytest.mark.parametrize("share", [0.1, pytest.param(1.0, marks=pytest.mark.slow)])
def test_power_grows_with_knowledge_whatever_the_ports_are_turned_by(share):
    ports, seen, squares = coupled(0.015)
    matrix = best_matrix(seen, squares, "full").damping
    if share < 1:
        matrix = 0.05 * matrix
    force = float(np.sqrt(0.5 * squares @ (np.abs(seen.velocity_under(matrix) @ matrix) ** 2).sum(axis=1)))
    found = [optimum(ports, RmsLimits(force), 1e-7, time) for time in (0.0, 1.0, 4.0)]
    rising = [float(squares @ seen.power(matrix)), *(one.power for one in found)]
    rising += [optimum(ports, RmsLimits(force), 0.0, np.inf).power, ports.matched_power]
    assert np.all(np.diff(rising) > 0), rising
    assert found[0].force_rms == pytest.approx(force, rel=1e-6)
    assert numerical_error(ports, optimum(ports, RmsLimits(force)), NOISE, 0.0).size < 0.02
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    assert optimum(ports.over(turn), RmsLimits(force), 1e-7).power == pytest.approx(found[0].power, rel=1e-6)
    idle = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])  # a third port moves as the first: two share a force better
    assert optimum(ports.over(idle), RmsLimits(force), 1e-7).power > found[0].power


def vibrating(seed, count, spacing):
    """Ports of a body of some more lightly damped modes, all in one direction of waves, which modes meet in turn."""
    rng, omega = np.random.default_rng(seed), (np.arange(round(12.0 / spacing)) + 0.5) * spacing
    own, loss = np.append(rng.uniform(1.0, 2.5), rng.uniform(2.5, 8.0, count + 1)), rng.uniform(0.005, 0.3, count + 2)
    mass, shapes = 10 ** rng.uniform(3.5, 4.5, count + 2), rng.standard_normal((count + 2, count))
    modal = 1 / (mass * (2 * loss * own - 1j * (omega[:, None] - own**2 / omega[:, None])))
    late = np.exp(1j * omega[:, None] * rng.uniform(-1.0, 1.0, count + 2) - (omega[:, None] / 3) ** 2)
    free = (modal * 1e4 * rng.standard_normal(count + 2) * late) @ shapes
    admittance, density = (
        shapes.T @ (modal[..., None] * shapes),
        jonswap_spectrum(omega, 1.0, rng.uniform(3.0, 7.0), 3.3),
    )
    spectrum = free[:, :, None] * free[:, None].conj() * density[:, None, None]
    return StationaryPorts(spacing, admittance, spectrum), Ports(omega, admittance, free), 2 * density * spacing


@pytest.mark.parametrize(("seed", "count", "share"), [(6, 2, 0.1), (2, 3, 1.0)])
def test_power_of_ports_grows_with_knowledge_on_coarse_grids_too(seed, count, share):
    """What products of long signals leave at negative times is faded out: it would take more than a tenth of them."""
    ports, seen, squares = vibrating(seed, count, 0.06)
    best = best_matrix(seen, squares, "diagonal")
    limits = RmsLimits(share * float(np.linalg.norm(seen.force_rms(best.damping, squares))))
    damped = priced_matrix(seen, squares, limits.force, "diagonal")[0].power
    powers = [optimum(ports, limits, NOISE, time).power for time in (0.0, 1.0, 3.0)]
    known = optimum(ports, limits, 0.0, np.inf).power
    assert np.all(np.diff([damped, *powers, known]) > -1e-6 * known), (damped, powers, known)
    finer = vibrating(seed, count, 0.02)[0]
    for time, power in zip((0.0, 1.0, 3.0), powers, strict=True):
        expected = optimum(finer, limits, NOISE, time).power / finer.matched_power
        assert power / ports.matched_power == pytest.approx(expected, rel=1e-3)


def test_the_mean_square_of_the_forces_is_the_slope_of_the_optimum():
    ports, weight, step = coupled(0.02)[0], 3e-5, 1e-4
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


def test_rational_ports_agree_with_the_riccati_equation():
    """Two coupled masses in two seas; the grid errs with the square of its time step, which extrapolation takes away."""
    price, share = 2e-4, 1e-1
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
