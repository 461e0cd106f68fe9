"""The table of methods: what `auto` is, and that a new method is a function and a row."""

import numpy as np
import pytest
from conftest import SEED, varied

from vsb.hydro.kernel import DampingSpectrum
from vsb.integrators.phi import phi_integrals
from vsb.integrators.simulate import METHODS, Method, legs, simulate
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.scene import Plant
from vsb.motion.system import System
from vsb.scenes.build import assumed_pressure_scene
from vsb.study.study import load
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


@pytest.fixture(scope="module")
def paper():
    study = load(SEED.parent / "paper.yaml")
    short = varied(study, published=None, simulation={"duration": 2.0, "window": (1.0, 2.0)})
    return varied(short, designs={"FSB": short.designs["FSB"].model_dump()})


@pytest.fixture(scope="module")
def oscillator():
    wave = Excitation(SWELL.omega, np.array([[30.0 + 5j]]))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]])), "excitation": wave}
    return System.of(Plant(("Heave",), np.array([[2.0]]), forces, np.eye(1)))


def added(monkeypatch, settings):
    """Settings that ask for the method of these tests, which becomes a row of the table."""
    monkeypatch.setitem(METHODS, "etd2", Method("exponential time differencing", exponential_time_differencing))
    return settings.model_copy(update={"method": "etd2"})


def test_a_new_method_is_a_function_and_a_row(paper, monkeypatch):
    """Body-exact heave of the paper's rigid buoy; it closes its audit and says its name."""
    system = assumed_pressure_scene(paper, {}).system
    exact, _, words = simulate(system, NO_WAVES, paper.simulation, None)
    motion, _, name = simulate(system, NO_WAVES, added(monkeypatch, paper.simulation), None)
    assert words.startswith("exponential Adams, ")
    assert name == f"exponential time differencing, {len(motion.time) - 1} steps"
    every = (len(motion.time) - 1) // (len(exact.time) - 1)
    assert np.abs(motion.position[::every] - exact.position).max() < 1e-3 * np.ptp(exact.position)


@pytest.mark.parametrize("name", ["linear", "body-exact"])
def test_the_new_method_has_its_order(paper, oscillator, name):
    system = oscillator if name == "linear" else assumed_pressure_scene(paper, {}).system
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
        next(legs(assumed_pressure_scene(paper, {}).system, NO_WAVES, forced, None))


def test_a_convolution_without_damping_is_refused(paper, oscillator):
    settings = paper.simulation.model_copy(update={"method": "convolution"})
    with pytest.raises(ValueError, match="convolution: received no radiation damping, needs a scene with a hydro data"):
        simulate(oscillator, SWELL, settings, None)
    omega = np.linspace(0.1, 8.0, 80)
    calm = DampingSpectrum(omega, np.zeros((80, 1, 1)))
    assert simulate(oscillator, SWELL, settings, calm)[2] == "convolution"
