"""The table of methods: what `auto` is, and that a new method is a function and a row."""

import time as clock
from dataclasses import dataclass, replace

import numpy as np
import pytest
from conftest import HERE, SEED, only_run, varied

from vsb.hydro.retardation import DampingSpectrum
from vsb.integrators.audit import energies, residual
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.phi import phi_integrals
from vsb.integrators.simulate import METHODS, Method, legs, recorded_steps, simulate
from vsb.motion.forces import ConstantForce, Damper, Excitation, Force, Linear, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.scenes.build import assumed_pressure_design
from vsb.study.study import Simulation, load
from vsb.waves.seas import NO_WAVES, Sea

SWELL = Sea(np.array([2.5]), np.array([0.1 + 0j]))


def exponential_time_differencing(system, tolerance, spectrum):
    """Cox and Matthews' method of second order: predicted with n at the start, corrected by its slope over the step."""

    def follow(time, start):
        h, z = time[1] - time[0], [system.first(start)]
        whole, (one, slope) = (phi := phi_integrals(system.matrix, system.input, h, 2)).exponential, phi.integrals
        for t in time[:-1]:
            here = forcing(t, z[-1])
            ahead = whole @ z[-1] + one @ here
            z.append(ahead + slope @ (forcing(t + h, ahead) - here) / h)
        return system.motion(time, np.array(z), system.forcing(time, np.array(z)), 0.0), len(time) - 1

    def forcing(t, state):
        return system.forcing(np.array([t]), state[None])[0]

    return follow


@dataclass(frozen=True)
class Hardening(Force):
    """f = -k q - k3 q^3 on every coordinate: a law no module of the package knows."""

    stiffness: float
    cubic: float

    def linear(self):
        """Return its tangent at rest."""
        return Linear(stiffness=np.array([[self.stiffness]]), whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return -self.stiffness * q - self.cubic * q**3

    def stored(self, q):
        """Return its potential energy."""
        return (self.stiffness * q**2 / 2 + self.cubic * q**4 / 4).sum(axis=1)


@pytest.fixture(scope="module")
def paper():
    study = load(SEED.parent / "paper.yaml")
    short = varied(study, published=None, simulation={"duration": 2.0, "window": (1.0, 2.0)})
    return varied(short, designs={"FSB": short.designs["FSB"].model_dump()})


@pytest.fixture(scope="module")
def oscillator():
    wave = Excitation(SWELL.omega, np.array([[30.0 + 5j]]))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]])), "excitation": wave}
    return System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))


def added(monkeypatch, settings):
    """Settings that ask for the method of these tests, which becomes a row of the table."""
    monkeypatch.setitem(METHODS, "etd2", Method("exponential time differencing", exponential_time_differencing))
    return settings.model_copy(update={"method": "etd2"})


def test_a_new_method_is_a_function_and_a_row(paper, monkeypatch):
    """Body-exact heave of the paper's rigid buoy; it closes its audit and says its name."""
    system = assumed_pressure_design(only_run(paper), {}).system
    exact, _, words = simulate(system, NO_WAVES, paper.simulation, None)
    motion, _, name = simulate(system, NO_WAVES, added(monkeypatch, paper.simulation), None)
    assert words.startswith("exponential Adams, ")
    assert name == f"exponential time differencing, {len(motion.time) - 1} steps"
    every = (len(motion.time) - 1) // (len(exact.time) - 1)
    assert np.abs(motion.position[::every] - exact.position).max() < 1e-3 * np.ptp(exact.position)


@pytest.mark.parametrize("name", ["linear", "body-exact"])
def test_the_new_method_has_its_order(paper, oscillator, name):
    system = oscillator if name == "linear" else assumed_pressure_design(only_run(paper), {}).system
    errors, counts, start = [], np.array([100, 200, 400, 800]), (np.array([0.1]), np.array([-0.3]))
    best = "exact" if system.linear else "exponential"
    for count in counts:
        time = np.linspace(0.0, 2.0, count + 1)
        follow, true = (f(system, 1e-12, None) for f in (exponential_time_differencing, METHODS[best].follower))
        errors.append(np.abs(follow(time, start)[0].position - true(time, start)[0].position).max())
    orders = -np.diff(np.log2(errors))
    assert np.all(np.abs(orders - 2.0) < 0.1), (orders, errors)


def test_auto_is_exact_where_all_is_linear_and_exponential_elsewhere(paper, oscillator):
    assert paper.simulation.method == "auto"
    assert simulate(oscillator, SWELL, paper.simulation, None)[2] == "exact propagation"
    forced = paper.simulation.model_copy(update={"method": "exact"})
    with pytest.raises(ValueError, match="exact propagation: received nonlinear forces"):
        next(legs(assumed_pressure_design(only_run(paper), {}).system, NO_WAVES, forced, None))


def test_a_convolution_without_damping_is_refused(paper, oscillator):
    settings = paper.simulation.model_copy(update={"method": "convolution"})
    with pytest.raises(ValueError, match="convolution: received no radiation damping, needs a scene with a hydro data"):
        simulate(oscillator, SWELL, settings, None)
    omega = np.linspace(0.1, 8.0, 80)
    calm = DampingSpectrum(omega, np.zeros((80, 1, 1)))
    assert simulate(oscillator, SWELL, settings, calm)[2] == "convolution"


def test_a_new_force_is_followed_audited_and_balanced(oscillator):
    """Duffing's oscillator: a method in time after its transient, and the steady state by harmonic balance."""
    plant = replace(oscillator.scene, forces={**oscillator.scene.forces, "hydrostatic": Hardening(50.0, 40.0)})
    system, period = System.of(plant), 2 * np.pi / 2.5
    found = harmonic_balance(system, 1e-8)
    linear = harmonic_balance(oscillator).harmonics[1, 0]
    assert abs(abs(found.harmonics[1, 0] / linear) - 1) > 0.05  # the cube matters
    assert found.power.residual < 1e-8
    time = np.linspace(0.0, 20 * period, 20 * 256 + 1)
    follow = exponential_time_differencing(system, 0.0, None)
    motion, _ = follow(time, tuple(values[0] for values in found.at(np.zeros(1))))
    assert np.abs(motion.position - found.at(time)[0]).max() < 2e-4 * np.abs(motion.position).max()
    assert residual(energies(system, motion)) < 1e-3  # of the motion's own second order


def test_a_constant_force_moves_the_mean_alone(oscillator):
    forces = {**oscillator.scene.forces, "weight": ConstantForce(np.array([-3.0]))}
    found, plain = (harmonic_balance(s) for s in (System.of(replace(oscillator.scene, forces=forces)), oscillator))
    assert found.harmonics[0, 0] == pytest.approx(-3.0 / 50.0, rel=1e-9)
    assert found.harmonics[1, 0] == pytest.approx(plain.harmonics[1, 0], rel=1e-9)


def test_the_recipe_for_an_integrator_is_followed(oscillator, monkeypatch):
    """The first block of `docs/extending.md`, at most 15 lines without its row, as it stands there."""
    recipe = (HERE.parent / "docs" / "extending.md").read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    assert len(recipe.split("METHODS[")[0].strip().splitlines()) <= 15
    rows = dict(METHODS)
    exec(recipe, {"np": np, "clock": clock, "phi_integrals": phi_integrals, "METHODS": rows, "Method": Method})
    errors, start = [], (np.array([0.1]), np.array([-0.3]))
    for count in (200, 400, 800):
        time = np.linspace(0.0, 2.0, count + 1)
        new, true = (rows[name].follower(oscillator, 0.0, None)(time, start)[0] for name in ("euler", "exact"))
        errors.append(np.abs(new.position - true.position).max())
    assert np.all(np.abs(-np.diff(np.log2(errors)) - 1.0) < 0.1), errors


@pytest.mark.parametrize("omega", [0.5, 2.5])
@pytest.mark.parametrize("duration", [30.0, 90.0])
def test_records_are_two_hundred_a_period_of_the_fastest_wave_that_matters(oscillator, omega, duration):
    """A wave below a twentieth of the highest does not matter, one above does; without any, free heave at 5 rad/s."""
    settings = Simulation(duration=duration, window=(1.0, duration))

    def count(sea):
        return recorded_steps(oscillator, sea, settings)

    periods = omega * duration / (2 * np.pi)
    assert count(Sea(np.array([omega]), np.array([0.3j]))) == np.ceil(200 * periods)
    assert count(Sea(np.array([omega, 2 * omega]), np.array([1.0, 0.049j]))) == np.ceil(200 * periods)
    assert count(Sea(np.array([omega, 2 * omega]), np.array([1.0, 0.051j]))) == np.ceil(400 * periods)
    assert count(NO_WAVES) == np.ceil(200 * 5.0 * duration / (2 * np.pi))  # sqrt(50/2) rad/s
    brief = Simulation(duration=duration, window=(1.0, 1.0 + 1e-3))
    assert recorded_steps(oscillator, NO_WAVES, brief) == pytest.approx(4e3 * duration, abs=1)
