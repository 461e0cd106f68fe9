"""Energy audit: integrals over a step, work of every kind of force, order."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.integrators.audit import (
    energies,
    flow,
    residual,
    step_integrals,
)
from vsb.integrators.exact import propagate
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import Motion, System


def one_mass(**forces):
    return Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1))


@settings(max_examples=40)
@given(st.floats(-3.0, 9.0))
def test_integral_of_a_decay_has_its_closed_form(exponent):
    """int_0^1 exp(-2 a t) dt = (1 - exp(-2 a))/(2 a), a = 1e-3 ... 1e9."""
    rate = 10.0**exponent
    found = step_integrals(np.array([[-rate]]), np.ones((1, 1, 1)))[0, 0, 0]
    assert found == pytest.approx(-np.expm1(-2 * rate) / (2 * rate), rel=1e-13)


@settings(max_examples=40)
@given(st.floats(-2.0, 6.0))
def test_integral_of_an_oscillation_has_its_closed_form(exponent):
    """int_0^1 cos^2 w t dt = 1/2 + sin(2 w)/(4 w), to the round-off of the phase w."""
    w = 10.0**exponent
    form = np.diag([1.0, 0.0])[None]
    found = step_integrals(np.array([[0.0, w], [-w, 0.0]]), form)[0, 0, 0]
    assert found == pytest.approx(0.5 + np.sin(2 * w) / (4 * w), abs=1e-15 * (10 + w))


@settings(max_examples=30)
@given(st.integers(1, 6), st.floats(0.01, 30.0), st.integers(0, 10**6))
def test_step_integral_satisfies_lyapunovs_equation(states, size, seed):
    """X^T S + S X = exp(X^T) Q exp(X) - Q."""
    rng = np.random.default_rng(seed)
    skew, root = rng.normal(size=(2, states, states))
    x = size * (skew - skew.T - root @ root.T / states)
    form = rng.normal(size=(states, states))
    values, vectors = np.linalg.eig(x)
    flow = np.real(vectors * np.exp(values) @ np.linalg.inv(vectors))
    s = step_integrals(x, form[None])[0]
    assert x.T @ s + s @ x == pytest.approx(flow.T @ form @ flow - form, abs=1e-9 * (1 + size))


@pytest.mark.parametrize("damping", [1e-3, 1.0, 1e6])
def test_damper_absorbs_the_kinetic_energy_lost(damping):
    """1/2 m v^2 (1 - exp(-2 c t/m)), even with thousands of time constants between records."""
    plant, time = one_mass(pto=Damper(np.array([[damping]]))), np.linspace(0.0, 3.0, 31)
    motion = propagate(System.of(plant), time, (np.zeros(1), np.array([0.8])))
    lost = -0.64 * np.expm1(-damping * time)
    assert energies(System.of(plant), motion)["pto"] == pytest.approx(lost, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("count", [6, 40])
def test_work_of_a_polynomial_force_is_exact(count):
    """A force of fifth degree in time on a free mass: 1/2 m v^2."""
    time = np.linspace(0.0, 2.0, count)
    force = np.polynomial.Polynomial(np.random.default_rng(2).normal(size=6))
    velocity = (force / 2.0).integ()
    columns = [p(time)[:, None] for p in (velocity.integ(), velocity, force / 2.0)]
    motion, system = Motion(time, *columns, np.zeros((count, 0)), 0.0), System.of(one_mass())
    push = force(time)[:, None] @ system.shapes
    _, work = flow(system, motion, push).works(np.zeros((1, len(system.matrix), len(system.matrix))), [push])
    assert work == pytest.approx(velocity(time) ** 2, abs=1e-12)


def test_work_of_waves_converges_with_order_six():
    wave = Excitation(np.array([2.0, 3.3]), np.array([[30.0 + 5j], [-4j]]))
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[9.0]])), excitation=wave)
    counts = np.array([60, 120, 240, 480])
    errors = []
    for count in counts:
        motion = propagate(System.of(plant), np.linspace(0.0, 20.0, count + 1), (np.array([0.2]), np.zeros(1)))
        errors.append(residual(energies(System.of(plant), motion)))
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes - 6.0) < 0.5), (errors, slopes)


@pytest.mark.parametrize("count", [2, 5])
def test_audit_of_few_records_closes(count):
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[1.2]])))
    motion = propagate(System.of(plant), np.linspace(0.0, 5.0, count), (np.ones(1), np.zeros(1)))
    assert residual(energies(System.of(plant), motion)) < 1e-13
