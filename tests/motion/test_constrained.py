"""Optimal force under limits: matched optimum, least squares, SLSQP, linear programmes, feasibility."""

import re
from dataclasses import replace

import numpy as np
import pytest
from motion.test_force_bound import SEA, WAVES, admittance, buoy, buoy_port, instants
from scipy.optimize import linprog, lsq_linear, minimize

from vsb.engine.motion import constrained
from vsb.engine.motion.constrained import NoForceFoundError, constrained_optimum
from vsb.engine.motion.force_bound import NODES, Harmonics, Limits, force_bound
from vsb.errors import StabilityError
from vsb.results.ladder import GAP as PROVEN

GAP = 1e-6
"""Tolerance of the best force of the harmonics of the band."""


def optimum(harmonics, limits=(), **buoy_of):
    return constrained_optimum(harmonics, buoy_port(harmonics, **buoy_of), np.ones(harmonics.count), Limits(*limits))


def power(velocity, admittance, force):
    return float(np.sum((force.conj() * velocity).real - admittance.real * np.abs(force) ** 2) / 2)


def free_stroke(harmonics, velocity):
    return float(np.abs(harmonics.signal(velocity / (-1j * harmonics.omega), 16)).max())


@pytest.mark.parametrize("harmonics", [SEA, WAVES])
def test_inactive_limits_give_the_matched_power(harmonics):
    velocity, y = buoy(harmonics)
    matched = np.sum(np.abs(velocity) ** 2 / (8 * y.real))
    free = optimum(harmonics)
    loose = optimum(harmonics, (1.01 * free.force_peak, 1.01 * free.stroke_peak))
    tight = optimum(harmonics, (0.8 * free.force_peak, 1.01 * free.stroke_peak))
    assert free.power == loose.power == pytest.approx(matched, rel=1e-14)
    assert free.gap == loose.gap == 0
    assert free.force_rms == pytest.approx(np.sqrt(np.mean(harmonics.signal(free.force) ** 2)), rel=1e-12)
    assert tight.power < matched
    assert tight.power <= tight.bound <= matched
    assert tight.gap < PROVEN


def test_port_that_is_not_passive_has_no_optimum():
    """Where waves move a port, `Port` itself sees it."""
    port = buoy_port(SEA)
    lossless = replace(port, velocity=0 * port.velocity, admittance=1j * port.admittance.imag)
    with pytest.raises(ValueError, match=r"port: not passive at .* rad/s, received Re Y = -?0 m/\(N s\), needs more"):
        constrained_optimum(SEA, lossless, np.ones(SEA.count), Limits(1.0))


def node_values(harmonics, limit):
    """Node values of the force found within a limit, and the optimum."""
    return force_bound(harmonics, *buoy(harmonics), Limits(limit)).force, optimum(harmonics, (limit,))


@pytest.mark.parametrize(("limit", "harmonics"), [(4e3, SEA), (1e3, WAVES), (2e4, Harmonics(0.8, 0.5, 9))])
def test_power_and_stroke_match_quadrature_of_the_piecewise_linear_force(harmonics, limit):
    port = buoy_port(harmonics)
    values, found = node_values(harmonics, limit)
    period = 2 * np.pi / harmonics.spacing
    turn = -1.0 if harmonics.first % 1 else 1.0
    nodes = np.linspace(0.0, period, len(values) + 1)
    time = (np.arange(len(values) * 64) + 0.5) * period / (len(values) * 64)
    line = np.interp(time, nodes, np.append(values, turn * values[0]))
    line -= 0.0 if turn < 0 or np.isfinite(port.compliance) else line.mean()
    order = np.argsort(port.omega)
    w, y, v = port.omega[order], port.admittance[order], port.velocity[order]
    f = np.array([2 * np.mean(line * np.exp(1j * each * time)) for each in w])
    assert found.power == pytest.approx(power(v, y, f), rel=1e-6)
    assert found.force_rms == pytest.approx(np.sqrt(np.mean(line**2)), rel=1e-4)
    assert found.force_peak == np.abs(values).max() <= limit
    at = time[:: len(time) // 512]
    stroke = (np.exp(-1j * np.outer(at, w)) @ ((v - y * f) / (-1j * w))).real
    stroke -= port.compliance * line.mean() if turn > 0 else 0.0
    assert np.abs(stroke).max() <= found.stroke_peak * (1 + 5e-3)
    assert found.stroke_peak <= np.abs(stroke).max() * (1 + 5e-3)
    inside = np.isin(w, harmonics.omega)
    np.testing.assert_allclose(found.force, f[inside], atol=1e-5 * np.abs(f).max())
    np.testing.assert_allclose(found.stroke, ((v - y * f) / (-1j * w))[inside], atol=1e-5 * np.abs(found.stroke).max())
    assert 0 <= found.gap < PROVEN
    assert found.excess == 0.0


@pytest.mark.parametrize(("limit", "resonance"), [(1e3, 1.6), (6e3, 9.0)])
def test_bounded_least_squares_finds_no_better_force(limit, resonance):
    """Dense problem with losses outside the band, where the port may resonate: P = const - |A u - b|^2."""
    harmonics = Harmonics(0.8, 1.0, 9)
    port, found = buoy_port(harmonics, resonance), optimum(harmonics, (limit,), resonance=resonance)
    count, w, loss = NODES * harmonics.instants, port.omega, port.admittance.real
    hat = 2 / count * np.sinc(w / harmonics.spacing / count) ** 2
    turning = limit * hat[:, None] * np.exp(1j * np.outer(w, instants(harmonics, count)))
    a, b = np.sqrt(loss / 2)[:, None] * turning, port.velocity / np.sqrt(8 * loss)
    solved = lsq_linear(np.vstack([a.real, a.imag]), np.concatenate([b.real, b.imag]), (-1, 1), tol=1e-12)
    best = power(port.velocity, port.admittance, turning @ solved.x)
    assert found.power <= best * (1 + 1e-6)
    assert best <= found.bound
    assert found.power >= best * (1 - constrained.REFINED)


@pytest.mark.parametrize("limits", [(2e4, 0.5), (np.inf, 0.35)])
def test_slsqp_finds_the_same_force(limits):
    """Real and imaginary parts as variables, constraints written out with sines and cosines."""
    harmonics = Harmonics(0.8, 0.5, 4)
    velocity, y = buoy(harmonics)
    found = optimum(harmonics, limits)
    time, w = instants(harmonics, harmonics.instants), harmonics.omega
    scale = found.force_peak

    def complexes(x):
        return scale * (x[:4] + 1j * x[4:])

    def room(x):
        force = complexes(x)
        stroke = (velocity - y * force) / (-1j * w)
        out = []
        for phasors, limit in zip((force, stroke), limits, strict=True):
            signal = np.cos(np.outer(time, w)) @ phasors.real + np.sin(np.outer(time, w)) @ phasors.imag
            if np.isfinite(limit):
                out += [1 - signal / limit, 1 + signal / limit]
        return np.concatenate(out)

    def loss(x):
        return -power(velocity, y, complexes(x)) / found.power

    best = minimize(
        loss, np.zeros(8), constraints={"type": "ineq", "fun": room}, options={"ftol": 1e-12, "maxiter": 500}
    )
    assert best.success
    assert -best.fun == pytest.approx(1.0, rel=2 * GAP)


def least_share(harmonics, velocity, y, limits, finer=1):
    """Least factor by which both limits can be multiplied and still be kept together, and the force: a linear programme."""
    time, w = instants(harmonics, finer * harmonics.instants), harmonics.omega
    cosine, sine = np.cos(np.outer(time, w)), np.sin(np.outer(time, w))
    gain, n = y / (-1j * w), len(w)
    still = velocity / (-1j * w)
    free = cosine @ still.real + sine @ still.imag
    force = np.hstack([cosine, sine])
    stroke = -np.hstack([cosine * gain.real + sine * gain.imag, sine * gain.real - cosine * gain.imag])
    rows = np.vstack([force, -force, stroke / limits[1] * limits[0], -stroke / limits[1] * limits[0]])
    ones = np.ones((len(rows), 1))
    right = np.concatenate([np.zeros(2 * len(time)), -free / limits[1], free / limits[1]])
    cost = np.append(np.zeros(2 * n), 1.0)
    found = linprog(cost, np.hstack([rows, -ones]), right, bounds=[(None, None)] * (2 * n) + [(0, None)])
    return found.fun, limits[0] * (found.x[:n] + 1j * found.x[n:-1])


def test_infeasible_limits_are_proved_by_a_linear_programme():
    """One of the harmonics of the band and one of twice as many."""
    narrow, wide, of = Harmonics(0.26, 0.5, 16), Harmonics(0.26, 0.5, 32), {"resonance": 1.2, "loss": 50.0}
    velocity, y = buoy(narrow, **of)
    limits = np.array([5e3, 0.2 * free_stroke(narrow, velocity)])
    share, _ = least_share(narrow, velocity, y, limits)
    found = optimum(narrow, 1.03 * share * limits, **of)
    assert found.force_peak <= 1.03 * share * limits[0] * (1 + 1e-9)
    assert found.stroke_peak <= 1.03 * share * limits[1] * (1 + 1e-9)
    assert found.power <= found.bound

    velocity, y = np.append(velocity, np.zeros(16)), admittance(wide.omega, **of)
    less, force = least_share(wide, velocity, y, limits, finer=3)
    held = [np.abs(wide.signal(x, 32)).max() for x in (force, (velocity - y * force) / (-1j * wide.omega))]
    kept = max(held / limits)  # by another force, at every instant
    assert kept < 0.995 * share
    words = "no force of the 16 harmonics up to 4.03 rad/s within force_limit keeps stroke_limit in this sea; whether another"
    with pytest.raises(NoForceFoundError, match=words) as raised:
        optimum(narrow, kept * limits, **of)
    assert raised.value.bound >= power(velocity, y, force)

    with pytest.raises(StabilityError, match=r"no force within force_limit keeps stroke_limit in this sea") as raised:
        optimum(narrow, 0.75 * less * limits, **of)
    assert not isinstance(raised.value, NoForceFoundError)
    most, least = (float(number) for number in re.findall(r"(-?[\d.e+]+) W", str(raised.value)))
    size = np.sqrt(2) * 0.75 * less * limits[0]
    least_there_is = -size / 2 * (np.linalg.norm(velocity) + size * y[:16].real.max())
    assert most < least == pytest.approx(least_there_is, rel=1e-5)
