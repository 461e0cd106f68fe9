from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from vsb.hydro.statespace import RadiationModel
from vsb.integrators.audit import (
    BLOCK,
    START,
    TERMS,
    Balance,
    Flow,
    _extended,
    energies,
    flow,
    residual,
    step_integrals,
    terms,
)
from vsb.integrators.collocation import collocated
from vsb.integrators.exact import propagate
from vsb.motion.forces import Damper, Excitation, Force, Linear, QuadraticDrag, RadiationMemory, Spring
from vsb.motion.motion import Motion
from vsb.motion.scene import Scene
from vsb.motion.system import System


def one_mass(**forces):
    return Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1))


@settings(max_examples=40)
@given(st.floats(-3.0, 9.0))
def test_a_decay_of_any_rate_is_integrated(exponent):
    """int_0^1 exp(-2 a t) dt = (1 - exp(-2 a))/(2 a), a = 1e-3 ... 1e9."""
    rate = 10.0**exponent
    found = step_integrals(np.array([[-rate]]), np.ones((1, 1, 1)))[0, 0, 0]
    assert found == pytest.approx(-np.expm1(-2 * rate) / (2 * rate), rel=1e-13)


@settings(max_examples=40)
@given(st.floats(-2.0, 6.0))
def test_a_ring_of_any_frequency_is_integrated(exponent):
    """int_0^1 cos^2 w t dt = 1/2 + sin(2 w)/(4 w), to the round-off of the phase w."""
    w = 10.0**exponent
    form = np.diag([1.0, 0.0])[None]
    found = step_integrals(np.array([[0.0, w], [-w, 0.0]]), form)[0, 0, 0]
    assert found == pytest.approx(0.5 + np.sin(2 * w) / (4 * w), abs=1e-15 * (10 + w))


@settings(max_examples=30)
@given(st.integers(1, 6), st.floats(0.01, 30.0), st.integers(0, 10**6))
def test_the_integral_satisfies_lyapunovs_equation(states, size, seed):
    """X^T S + S X = exp(X^T) Q exp(X) - Q."""
    rng = np.random.default_rng(seed)
    skew, root = rng.normal(size=(2, states, states))
    x = size * (skew - skew.T - root @ root.T / states)
    form = rng.normal(size=(states, states))
    values, vectors = np.linalg.eig(x)
    flow = np.real(vectors * np.exp(values) @ np.linalg.inv(vectors))
    s = step_integrals(x, form[None])[0]
    assert x.T @ s + s @ x == pytest.approx(flow.T @ form @ flow - form, abs=1e-9 * (1 + size))


@pytest.mark.parametrize("damping", [1e-3, 1.0, 1e3, 1e6])
def test_what_a_damper_takes_is_the_kinetic_energy_lost(damping):
    """1/2 m v^2 (1 - exp(-2 c t/m)) at every record, be they thousands of time constants apart."""
    plant, time = one_mass(pto=Damper(np.array([[damping]]))), np.linspace(0.0, 3.0, 31)
    motion = propagate(System.of(plant), time, (np.zeros(1), np.array([0.8])))
    lost = -0.64 * np.expm1(-damping * time)
    assert energies(System.of(plant), motion)["pto"] == pytest.approx(lost, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("count", [6, 7, 8, 40])
def test_the_work_of_a_polynomial_force_is_exact(count):
    """A force of fifth degree in time on a free mass, from six records on: 1/2 m v^2 in closed form."""
    time = np.linspace(0.0, 2.0, count)
    force = np.polynomial.Polynomial(np.random.default_rng(2).normal(size=6))
    velocity = (force / 2.0).integ()
    columns = [p(time)[:, None] for p in (velocity.integ(), velocity, force / 2.0)]
    motion, system = Motion(time, *columns, np.zeros((count, 0)), 0.0), System.of(one_mass())
    push = force(time)[:, None] @ system.shapes
    _, work = flow(system, motion, push).works(np.zeros((1, len(system.matrix), len(system.matrix))), [push])
    assert work == pytest.approx(velocity(time) ** 2, abs=1e-12)


def test_the_work_of_a_wave_converges_with_the_sixth_power_of_the_records_distance():
    wave = Excitation(np.array([2.0, 3.3]), np.array([[30.0 + 5j], [-4j]]))
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[9.0]])), excitation=wave)
    counts = np.array([60, 120, 240, 480])
    errors = []
    for count in counts:
        motion = propagate(System.of(plant), np.linspace(0.0, 20.0, count + 1), (np.array([0.2]), np.zeros(1)))
        errors.append(residual(energies(System.of(plant), motion)))
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes - 6.0) < 0.5), (errors, slopes)


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_a_run_of_a_few_records_is_audited(count):
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[1.2]])))
    motion = propagate(System.of(plant), np.linspace(0.0, 5.0, count), (np.ones(1), np.zeros(1)))
    assert residual(energies(System.of(plant), motion)) < 1e-13


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_not_balanced_is_a_size_and_of_the_worst_leg(sign):
    """Work of the waves without an account, or an account without work; later legs that balance do not mend it."""
    none = np.zeros(3)
    wrong = {
        **dict.fromkeys(TERMS, none),
        "wave": sign * np.array([0.0, 2.0, 1.0]),
        "turned": np.array([0.0, 0.5, 0.1]),
    }
    right = {**dict.fromkeys(TERMS, none), "wave": np.ones(3), "pto": np.ones(3), "turned": none}
    first = Balance({}, 0.0, 0.0).after(wrong)
    assert (first.unbalanced, first.largest, first.ended["wave"]) == (2.0, 2.0, sign)
    second = first.after(right)
    assert (second.unbalanced, second.largest, second.ended["pto"]) == (2.0, 2.0, 1.0)


def test_a_form_of_both_signs_is_integrated_with_them():
    """Kinetic less potential energy of an undamped oscillator, whose integral is that of cos 2 t."""
    time = np.linspace(0.0, 3.0, 301)
    states = np.stack([np.cos(time), -np.sin(time)], axis=1)
    still = Flow(0.01, np.array([[0.0, 1.0], [-1.0, 0.0]]), states, np.zeros((len(time) + 4, 1)))
    (found,) = still.works(np.diag([1.0, -1.0])[None], [])
    np.testing.assert_allclose(found, np.sin(2 * time) / 2, atol=1e-12)


def test_losses_and_works_of_two_coordinates_are_each_their_own():
    """Two forms without symmetry and two forces along a free motion, over more steps than are taken at once."""
    rng, dt, count = np.random.default_rng(4), 0.02, 3 * BLOCK // 2
    a = np.vstack([np.eye(2, 4, 2), [[-9.0, 1.0, -0.4, 0.1], [2.0, -25.0, 0.3, -0.2]]])
    losses, first, time = rng.normal(size=(2, 4, 4)), rng.normal(size=4), dt * np.arange(count + 1)
    values, vectors = np.linalg.eig(a)
    parts = np.linalg.solve(vectors, first)
    states = np.real((np.exp(np.outer(time, values)) * parts) @ vectors.T)
    forces = [np.stack([time**2, 1 - time], axis=1), np.stack([-time, 0.3 * time**3], axis=1)]
    found = Flow(dt, a, states, np.zeros((len(time) + 4, 2))).works(losses, forces)
    sums = values[:, None] + values
    grown = np.expm1(time[:, None, None] * sums) / sums
    for own, form in zip(found, losses, strict=False):
        exact = np.einsum("tij,i,j,ij->t", grown, parts, parts, vectors.T @ form @ vectors).real
        np.testing.assert_allclose(own, exact, atol=1e-11 * np.abs(exact).max())
    for own, force in zip(found[2:], forces, strict=True):
        powers = CubicSpline(time, np.sum(force * states[:, 2:], axis=1))
        exact = powers.antiderivative()(time)
        np.testing.assert_allclose(own, exact, atol=1e-4 * np.abs(exact).max())


@pytest.mark.parametrize("count", [2, 3, 6, 9])
def test_records_are_continued_at_either_end_by_the_polynomial_of_its_own(count):
    """Of degree 5, or less where records are few; beyond six records the other end has no part in it."""
    time = np.arange(-2.0, count + 2.0)
    course = np.stack([1 + 0.5 * time, time ** min(count - 1, 5)], axis=1)
    np.testing.assert_allclose(_extended(course[2:-2]), course, rtol=1e-9, atol=1e-6)
    if count > 6:
        jump = course[2:-2].copy()
        jump[-1] += 100.0
        np.testing.assert_allclose(_extended(jump)[:2], course[:2], rtol=1e-9, atol=1e-6)
        assert np.abs(_extended(jump)[-2:] - course[-2:]).min() > 100.0


def test_terms_of_an_audit_stand_in_one_order():
    energy = dict.fromkeys(["turned", "drag", "stored", "pto", "stop", "wave", "radiated", "structural"], np.zeros(2))
    assert terms(energy) == ("wave", "pto", "radiated", "structural", "drag", "stop", "stored")


def test_an_audit_counts_terms_of_their_own_and_nothing_makes_no_residual():
    none = np.zeros(3)
    energy = {**dict.fromkeys(TERMS, none), "wave": np.array([0.0, 1.0, 3.0]), "drag": np.array([0.0, -1.0, 4.0])}
    assert residual({**energy, "turned": none}) == pytest.approx(2.0 / 4.0)
    assert residual({**energy, "turned": np.array([0.0, 8.0, 0.0])}) == pytest.approx(2.0 / 8.0)
    assert residual({**dict.fromkeys(TERMS, none), "turned": none}) == 0.0
    assert START.after({**energy, "turned": none}).ended == {**dict.fromkeys(TERMS, 0.0), "wave": 3.0, "drag": 4.0}


@dataclass(frozen=True)
class Hardening(Force):
    """f = -k3 q^3 on every coordinate."""

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return -40.0 * q**3

    def stored(self, q):
        """Return its potential energy."""
        return (10.0 * q**4).sum(axis=1)


@pytest.mark.parametrize("take_off", ["pto", "drag", "stiffer", "none"])
def test_what_a_force_that_is_not_linear_takes_is_the_take_offs_or_its_own(take_off):
    """By sums over the instants of a motion of two coordinates that begin away from rest; what is stored nobody takes."""
    drag = QuadraticDrag(np.eye(2), np.array([3.0, 1.0]), np.zeros(0), np.zeros((0, 2), dtype=complex))
    dampers = {"pto": np.diag([1.2, 0.7]), "structural_damping": np.array([[0.2, 0.1], [0.1, 0.3]])}
    forces = {name: Damper(matrix) for name, matrix in dampers.items()} | {"drag": drag, "stiffer": Hardening()}
    scene = Scene(("Heave", "Membrane0"), np.array([[2.0, 0.3], [0.3, 1.0]]), forces, np.eye(2), take_off=take_off)
    time = np.linspace(0.0, 2.0, 801)
    motion, _ = collocated(System.of(scene), time, (np.array([0.3, -0.4]), np.array([0.5, 0.8])), 1e-8)
    q, v, found = motion.position, motion.velocity, energies(System.of(scene), motion)

    def work(power):
        return np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])

    taken = {name: work(np.einsum("ti,ij,tj->t", v, matrix, v)) for name, matrix in dampers.items()}
    taken |= {"drag": work(np.abs(v) ** 3 @ [3.0, 1.0]), "stiffer": 0.0 * time}
    own = {"pto": taken.pop(take_off, 0.0 * time)}
    structural = sum(taken.pop(name, 0.0 * time) for name in ("pto", "structural_damping"))
    own |= {"structural": structural, "radiated": 0.0 * time, "wave": 0.0 * time, **taken}
    stored = 10.0 * (q**4).sum(axis=1)
    kinetic = 0.5 * np.einsum("ti,ij,tj->t", v, scene.mass, v)
    own |= {"stored": stored + kinetic - stored[0] - kinetic[0], "turned": kinetic * (1 + 1e-9) + 1e-9 * stored}
    assert found.keys() == own.keys()
    for term, expected in own.items():
        assert found[term] == pytest.approx(expected, abs=2e-4), term


def test_energy_that_is_stored_below_zero_went_round_as_much_as_any():
    """A spring that pushes away: its billionth is no negative one."""
    plant, time = one_mass(hydrostatic=Spring(np.array([[-50.0]]))), np.linspace(0.0, 0.5, 11)
    motion = propagate(System.of(plant), time, (np.array([0.3]), np.zeros(1)))
    kinetic, stored = motion.velocity[:, 0] ** 2, -25.0 * motion.position[:, 0] ** 2
    found = energies(System.of(plant), motion)
    np.testing.assert_allclose(found["stored"], kinetic + stored - stored[0], atol=1e-12)
    np.testing.assert_allclose(found["turned"], kinetic + 1e-9 * np.abs(kinetic + stored), rtol=1e-12)


def test_works_a_motion_brings_along_are_taken_as_they_are():
    plant, time = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.eye(1))), np.linspace(0.0, 0.5, 11)
    motion = propagate(System.of(plant), time, (np.array([0.3]), np.zeros(1)))
    works = {"wave": time, "pto": 2 * time, "radiated": 3 * time, "structural": 4 * time}
    plain, found = (energies(System.of(plant), one) for one in (motion, replace(motion, works=works)))
    assert found.keys() == plain.keys()
    for term, expected in (plain | works).items():
        np.testing.assert_array_equal(found[term], expected)


def test_a_motion_without_memory_states_is_audited_by_its_forces():
    """As of a convolution: what radiates is work of the radiation force, taken and stored, and the sum is none."""
    channel = np.array([1.0, 0.6])
    turning = np.array([[0.0, 1.4], [-1.4, 0.0]]) - np.outer(channel, channel) / 2
    memory = RadiationMemory(RadiationModel(turning, np.array([[0.8], [0.5]]), channel))
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[1.2]])), radiation=memory)
    system, time = System.of(plant), np.linspace(0.0, 5.0, 1001)
    motion = propagate(system, time, (np.array([0.3]), np.array([-0.2])))
    kept, bare = energies(system, motion), energies(system, replace(motion, memory=np.zeros((len(time), 0))))
    assert residual(bare) < 1e-8
    assert bare["pto"] == pytest.approx(kept["pto"], abs=1e-8)
    held = 0.5 * np.sum(motion.memory**2, axis=1)
    assert bare["radiated"] == pytest.approx(kept["radiated"] + held - held[0], abs=1e-8)
    assert bare["stored"] == pytest.approx(kept["stored"] - held + held[0], abs=1e-12)
    assert held.max() > 1e-3
