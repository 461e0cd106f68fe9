"""The choice of the method, methods and forces written by a user, recorded instants."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from conftest import EXAMPLE, only_run, varied
from motion.test_scene import made_up_buoy

from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.exponential import phi_integrals
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import METHODS, legs, recorded_steps, simulate
from vsb.engine.motion.forces import Damper, Excitation, Force, Linear, Spring
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, body_exact_scene
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import StabilityError
from vsb.models.build import assumed_pressure_design
from vsb.models.rest import reference_shell
from vsb.study.study import load

SWELL = Sea(np.array([2.5]), np.array([0.1 + 0j]))


def exponential_time_differencing(system, tolerance, spectrum):
    """Cox and Matthews' predictor-corrector method of second order, as a user would write it."""

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
    """Duffing's spring f = -k q - k3 q^3, a force the package does not contain."""

    stiffness: float
    cubic: float

    def linear(self):
        return Linear(stiffness=np.array([[self.stiffness]]), fully_linear=False)

    def force(self, time, q, v):
        return -self.stiffness * q - self.cubic * q**3

    def potential_energy(self, q):
        return (self.stiffness * q**2 / 2 + self.cubic * q**4 / 4).sum(axis=1)


@pytest.fixture(scope="module")
def paper():
    study = load(EXAMPLE.parent / "paper.yaml")
    short = varied(study, published=None, simulation={"duration": 2.0, "window": (1.0, 2.0)})
    return varied(short, designs={"FSB": short.designs["FSB"].model_dump()})


@pytest.fixture(scope="module")
def oscillator():
    wave = Excitation(SWELL.omega, np.array([[30.0 + 5j]]))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]])), "excitation": wave}
    return System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))


@pytest.mark.parametrize("name", ["linear", "body-exact"])
def test_method_written_by_a_user_has_second_order(paper, oscillator, name):
    system = oscillator if name == "linear" else assumed_pressure_design(only_run(paper), {}).system
    errors, counts, start = [], np.array([100, 200, 400, 800]), (np.array([0.1]), np.array([-0.3]))
    best = "exact" if system.linear else "exponential"
    for count in counts:
        time = np.linspace(0.0, 2.0, count + 1)
        follow, true = (f(system, 1e-12, None) for f in (exponential_time_differencing, METHODS[best].follower))
        errors.append(np.abs(follow(time, start)[0].position - true(time, start)[0].position).max())
    orders = -np.diff(np.log2(errors))
    assert np.all(np.abs(orders - 2.0) < 0.1), (orders, errors)


def test_auto_chooses_exact_propagation_for_a_linear_scene(paper, oscillator):
    assert paper.simulation.method == "auto"
    assert simulate(oscillator, SWELL, paper.simulation, None)[2] == "exact propagation"
    forced = paper.simulation.model_copy(update={"method": "exact"})
    with pytest.raises(ValueError, match="exact propagation: received nonlinear forces"):
        next(legs(assumed_pressure_design(only_run(paper), {}).system, NO_WAVES, forced, None))


def test_convolution_without_radiation_damping_is_refused(paper, oscillator):
    settings = paper.simulation.model_copy(update={"method": "convolution"})
    with pytest.raises(ValueError, match="convolution: received no radiation damping, needs a scene with a hydro data"):
        simulate(oscillator, SWELL, settings, None)
    omega = np.linspace(0.1, 8.0, 80)
    calm = DampingSpectrum(omega, np.zeros((80, 1, 1)))
    assert simulate(oscillator, SWELL, settings, calm)[2] == "convolution"


def test_duffing_oscillator_in_time_and_by_harmonic_balance(oscillator):
    plant = replace(oscillator.scene, forces={**oscillator.scene.forces, "hydrostatic": Hardening(50.0, 40.0)})
    system, period = System.of(plant), 2 * np.pi / 2.5
    found = harmonic_balance(system, 1e-8)
    linear = harmonic_balance(oscillator).harmonics[1, 0]
    assert abs(abs(found.harmonics[1, 0] / linear) - 1) > 0.05  # clearly nonlinear
    assert found.power.residual < 1e-8
    time = np.linspace(0.0, 20 * period, 20 * 256 + 1)
    follow = exponential_time_differencing(system, 0.0, None)
    motion, _ = follow(time, tuple(values[0] for values in found.at(np.zeros(1))))
    assert np.abs(motion.position - found.at(time)[0]).max() < 2e-4 * np.abs(motion.position).max()
    assert residual(energies(system, motion)) < 1e-3  # of the motion's own second order


def test_records_resolve_the_fastest_significant_wave(oscillator):
    """200 per period; components below a twentieth of the largest are ignored; without waves, free heave at 5 rad/s."""
    settings = Simulation(duration=30.0, window=(1.0, 30.0))

    def count(*amplitudes):
        return recorded_steps(oscillator, Sea(2.5 * np.arange(1, len(amplitudes) + 1), np.array(amplitudes)), settings)

    periods = 2.5 * 30.0 / (2 * np.pi)
    assert count(0.3j) == count(1.0, 0.049j) == np.ceil(200 * periods)
    assert count(1.0, 0.051j) == count(0.06, -1.0j, 0.049) == np.ceil(400 * periods)
    assert count() == np.ceil(200 * 5.0 * 30.0 / (2 * np.pi))
    brief = Simulation(duration=30.0, window=(1.0, 1.0 + 1e-3))
    assert recorded_steps(oscillator, NO_WAVES, brief) == pytest.approx(4e3 * 30.0, abs=1)


def test_buoy_that_leaves_the_water_for_good_is_refused(seed):
    """A spring almost as negative as the waterplane is stiff: beyond small motion nothing holds the buoy."""
    study = varied(seed, modes={"degree": 2}, designs={"FSB": {"flexible": False}})
    buoy, shape = made_up_buoy(study, reference_shell(study))
    waterplane = study.water.density * study.water.gravity * np.pi * study.device.radius**2
    buoy = replace(buoy, pto=LinearPto(8e3, stiffness=-0.95 * waterplane))
    plant = body_exact_scene(buoy, shape, None, NO_WAVES, np.eye(len(buoy.labels), 1))
    settings = Simulation(duration=60.0, window=(40.0, 60.0), initial_velocity=2.0)
    with pytest.raises(StabilityError, match=r"the buoy heaves by .* more than 100 radii.*raise pto\.stiffness"):
        list(legs(System.of(plant), NO_WAVES, settings, None))
