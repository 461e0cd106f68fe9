"""Powers between nodes: a rule of order six, and derivatives of products."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial, polynomial
from scipy.integrate import solve_ivp

from vsb.integrators.phases import Phase
from vsb.integrators.works import Load, Piece, account, driven_at, integrated, product
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System


def jet(polynomial, time):
    """Value and first two derivatives, shape (3, node)."""
    return np.array([polynomial.deriv(k)(time) if k else polynomial(time) for k in range(3)])


@pytest.mark.parametrize("degree", range(6))
def test_powers_of_degree_five_are_integrated_exactly(degree):
    power, time = Polynomial.basis(degree) * 3.0, np.array([0.2, 0.5, 1.3])
    exact = power.integ()(time[1:]) - power.integ()(time[:-1])
    values = jet(power, time)
    np.testing.assert_allclose(integrated(values[:, :-1], values[:, 1:], np.diff(time)), exact, rtol=1e-13)


def test_other_powers_are_integrated_with_order_six():
    def rest(count):
        time = np.linspace(0.0, 2.0, count + 1)
        values = np.array([np.sin(3 * time), 3 * np.cos(3 * time), -9 * np.sin(3 * time)])
        return integrated(values[:, :-1], values[:, 1:], np.diff(time)).sum() - (1 - np.cos(6.0)) / 3

    errors = np.abs([rest(n) for n in (8, 16, 32)])
    slopes = np.diff(np.log2(errors))
    assert np.all(np.abs(slopes + 6) < 0.2), slopes


def test_a_product_and_its_derivatives():
    time = np.linspace(0.0, 1.0, 5)
    a, b = (np.stack([jet(p, time) for p in parts], axis=-1) for parts in (
        (Polynomial([1, 2, 3]), Polynomial([0, 1])), (Polynomial([2, -1]), Polynomial([1, 0, 0, 4]))))  # fmt: skip
    whole = Polynomial([1, 2, 3]) * Polynomial([2, -1]) + Polynomial([0, 1]) * Polynomial([1, 0, 0, 4])
    np.testing.assert_allclose(product(a, b), jet(whole, time), atol=1e-12)


@pytest.mark.parametrize("at_once", [512, 2, 1])
def test_waves_and_their_derivatives_at_nodes_whether_or_not_these_are_equally_spaced(monkeypatch, at_once):
    """However many of the others are found at a time."""
    monkeypatch.setattr("vsb.integrators.works.AT_ONCE", at_once)

    class Driven:
        omega, waves = np.array([1.0, 2.5]), np.array([[1.0 + 2.0j, 0.5], [0.3j, -1.0 + 0j]])

    time = np.array([0.0, 0.1, 0.13, 0.16, 0.2, 0.21, 0.22, 0.27, 0.3])
    regular, time = np.isin(time, [0.0, 0.1, 0.2, 0.3]), time + 0.37 * at_once
    found = driven_at(Driven, time, regular)
    for k in range(3):
        phasors = Driven.waves * (-1j * Driven.omega[:, None]) ** k
        exact = np.real(np.exp(-1j * np.outer(time, Driven.omega)) @ phasors)
        np.testing.assert_allclose(found[k], exact, atol=1e-12)


class Carrying(Phase):
    """A regime whose states carry a force on both modes and its two derivatives."""

    def added(self, states):
        """Return these, as they stand."""
        return states[:, 5:].reshape(len(states), 3, 2).transpose(1, 0, 2)


def two_masses():
    forces = {
        "hydrostatic": Spring(np.array([[50.0, -10.0], [-10.0, 30.0]])),
        "structural_damping": Damper(np.array([[0.4, 0.1], [0.1, 0.2]])),
        "friction": Damper(np.diag([0.0, 0.5])),
        "excitation": Excitation(np.array([1.5, 2.5]), np.array([[3.0 - 1.0j, 0.5j], [1.0, -2.0 + 1j]])),
    }
    return System.of(Scene(("Heave", "Membrane0"), np.diag([2.0, 1.0]), forces, np.eye(2)))


def test_works_are_integrals_of_powers_on_pieces_of_a_law_and_of_a_force_that_jumps_at_every_node(monkeypatch):
    """Beside an explicit method of order 8: a force leaves a node otherwise than it came there, and loads change."""
    system, rng, port = two_masses(), np.random.default_rng(3), np.array([1.0, -0.7])
    time = np.array([2.0, 2.02, 2.04, 2.05, 2.06, 2.08, 2.1, 2.12, 2.13])
    regular, last = ~np.isin(time, [2.05, 2.13]), len(time) - 1
    loads = [(Load(3.0, 7.0, 1.5), Load(1.0, 20.0, 0.5)), (Load(0.5, -2.0, -4.0), Load(0.0, 0.0, 0.0))]
    beta = system.shapes.T @ port
    pieces = [
        Piece(Carrying(system, beta, a.damping + b.damping, a.stiffness + b.stiffness, False, 0.02), a, b)
        for a, b in loads
    ]
    owner = np.array([0, 0, 0, 1, 1, 0, 1, 0, 1])
    courses = rng.normal(size=(last + 1, 4, 2)) * 5.0
    damper = np.sum(system.dampers(), axis=0)

    def carried(k, t):
        """The force of the k-th span and its derivatives."""
        found = [polynomial.polyval(t - time[k], polynomial.polyder(courses[k], i)) for i in range(3)]
        return np.concatenate(found)

    def rates(t, y, k):
        taken, stopped = loads[owner[k]]
        z, v = y[:4], y[2:4]
        stroke, speed = beta / system.scale @ z[:2], beta @ v
        own, stop = (-(c * speed + s * stroke) + f for c, s, f in (taken, stopped))
        push = (np.exp(-1j * system.omega * t) @ system.waves).real + carried(k, t)[:2]
        moved = system.matrix @ z + system.input @ (push + beta * (own + stop))
        return [*moved, v @ push, -speed * own, v @ damper @ v + stopped.damping * speed**2]

    y = np.array([0.6, -0.8, 0.5, 0.3, 0.0, 0.0, 0.0])
    states, leaving, exact = [], [], []
    for k, t in enumerate(time):
        states.append([*y[:4], 0.0, *carried(max(k - 1, 0), t)])
        leaving.append([*y[:4], 0.0, *carried(k, t)])
        exact.append(y[4:])
        if k < last:
            y = solve_ivp(rates, (t, time[k + 1]), y, "DOP853", args=(k,), rtol=1e-12, atol=1e-13).y[:, -1]
    given = {piece: np.flatnonzero(owner == i).tolist() for i, piece in enumerate(pieces)}
    for at_once in (512, 2):
        monkeypatch.setattr("vsb.integrators.works.AT_ONCE", at_once)
        found = account(system, time, np.array(states), np.array(leaving), given, regular)
        np.testing.assert_allclose(found.works[:3].T, exact, atol=1e-9)
        assert not found.works[3].any()
    for k in range(last + 1):
        stroke, speed = beta / system.scale @ states[k][:2], beta @ states[k][2:4]
        for force, load in zip((found.taken, found.stopped), loads[owner[k]], strict=True):
            assert force[k] == pytest.approx(-(load.damping * speed + load.stiffness * stroke) + load.constant)
        np.testing.assert_allclose(found.rates[k], rates(time[k], np.append(states[k][:4], [0, 0, 0]), k)[2:4])


@pytest.mark.parametrize("constant", [0.0, 2.5])
def test_a_port_that_is_held_is_held_by_what_all_others_push(constant):
    """Waves, the force carried and the end stop; nothing moves there, so that no work is done."""
    system = two_masses()
    beta = system.shapes.T @ np.array([1.0, -0.7])
    phase = Carrying(system, beta, 0.0, 20.0, True, 0.02)
    piece, time = Piece(phase, Load(0.0, 0.0, 0.0), Load(0.0, 20.0, constant)), np.array([2.0, 2.02])
    state = np.array([0.6, -0.8, 0.5, 0.0, 0.0, 3.0, -1.0, 0.2, 0.1, 4.0, 0.3])
    state[3] = -beta[0] * state[2] / beta[1]
    states = np.array([state, state])
    found = account(system, time, states, states, {piece: [0, 1]}, np.array([True, True]))
    free = beta / np.linalg.norm(beta)
    for k, t in enumerate(time):
        push = (np.exp(-1j * system.omega * t) @ system.waves).real + state[5:7]
        stopped = constant - 20.0 * (beta / system.scale @ state[:2])
        rate = system.matrix[2:4] @ state[:4] + push + beta * stopped
        assert found.taken[k] == pytest.approx(-(beta @ rate) / (beta @ beta))
        np.testing.assert_allclose(found.rates[k], rate - free * (free @ rate), rtol=1e-12)
    assert found.works[1] == pytest.approx([0.0, 0.0], abs=1e-14)
