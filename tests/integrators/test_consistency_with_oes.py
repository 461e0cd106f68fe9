"""The OES Task 10 heaving sphere: free decay on its instantaneous wet surface, from 1 to 6 m, and regular waves.

Wendt et al. (2019), Ocean Energy Systems wave energy modelling task, J. Mar. Sci. Eng. 7, 379: radius 5 m, mass
261.8e3 kg, centre in the water's surface at rest, fresh water, deep. Hydrostatics of a sphere in closed form are the
independent check: of a sphere of radius R with its centre at height c, |c| <= R, pi (2 R^3/3 - R^2 c + c^3/3) is wet.
"""

import numpy as np
import pytest
from conftest import varied
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.exponential import integrate
from vsb.engine.motion.scene import body_exact_scene, linear_scene
from vsb.engine.motion.system import System
from vsb.engine.shell.deformed import rigid_sphere
from vsb.engine.waves.seas import NO_WAVES

RADIUS, MASS, DENSITY, GRAVITY = 5.0, 261.8e3, 1000.0, 9.81
WEIGHT = DENSITY * GRAVITY
PUBLISHED = ((2.213, -0.8671), (4.418, 0.6350), (6.597, -0.4649), (8.770, 0.3467), (10.945, -0.2575), (13.119, 0.1917))
"""Extrema (s, m) of the linear semi-analytic decay from 1 m."""
SPREAD = 0.024
"""Largest root mean square difference of the six published codes from it over 40 s [m]."""
TIME = np.linspace(0.0, 40.0, 4001)
PERIODS = (3.0, 4.0, 4.4, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0)
"""Of the task's regular waves [s]."""
DAMPERS = (
    398736.034, 118149.758, 90080.857, 161048.558, 322292.419, 479668.979, 633979.761, 784083.286, 932117.647, 1077123.445,
)  # fmt: skip
"""Its best take-off in each [N s/m]."""
WAVES = (0.177, 0.314, 0.380, 0.491, 0.706, 0.961, 1.256, 1.589, 1.962, 2.374)
"""Amplitudes of the waves of steepness 0.002 [m]."""
HEAVES = (0.01395, 0.18485, 0.35725, 0.40790, 0.50395, 0.66610, 0.86800, 1.10205, 1.36555, 1.65765)
"""Amplitudes of heave beside these take-offs, from 500 s on: reference runs of HydroChrono (github.com/NREL/HydroChrono,
`demos/sphere/postprocessing/ref_sphere_reg_waves_*.txt`) [m]."""


@pytest.fixture(scope="module")
def sphere(seed):
    return varied(
        seed, device={"radius": RADIUS, "mass": MASS}, water={"density": DENSITY}, hydro={"omega_max": 6.0},
        designs={"sphere": {"flexible": False}}, pto={"damping": 0.0}, waves=[{"kind": "still"}],
    )  # fmt: skip


@pytest.fixture(scope="module")
def scenes(sphere, wet_buoy):
    """The linear scene, and that on the instantaneous wet surface."""
    buoy, shape, radiation, motions = wet_buoy(sphere, "sphere")
    linear = linear_scene(buoy, radiation, NO_WAVES, motions)
    return linear, body_exact_scene(buoy, shape, radiation, NO_WAVES, motions)


@pytest.fixture(scope="module")
def decay(scenes):
    """Function height -> body-exact motion from rest there."""
    cache = {}

    def run(height):
        if height not in cache:
            cache[height] = integrate(System.of(scenes[1]), TIME, scenes[1].start(height, 0.0), 1e-10)[0]
        return cache[height]

    return run


def turns(motion):
    """Times and heights at which the velocity vanishes after the start, shape (turn, 2)."""
    heave = CubicHermiteSpline(TIME, motion.position[:, 0], motion.velocity[:, 0])
    velocity = CubicHermiteSpline(TIME, motion.velocity[:, 0], motion.acceleration[:, 0])
    signs = np.flatnonzero(motion.velocity[1:-1, 0] * motion.velocity[2:, 0] < 0) + 1
    times = [brentq(velocity, TIME[i], TIME[i + 1], xtol=1e-12) for i in signs]
    return np.array([(t, heave(t)) for t in times])


def closed_form(plant, centre, height, *, cubic=True):
    """Decay with the wet volume of a sphere in closed form and the scene's memory, by an explicit method of order 8.

    Without `cubic` the restoring force is that about rest.
    """
    model, inertia = plant.memory, plant.mass[0, 0]
    g = model.input_matrix[:, 0]

    def restoring(z):
        c = np.clip(centre + z, -RADIUS, RADIUS)
        area, third = RADIUS**2 * (c - centre), (c**3 - centre**3) / 3
        return -WEIGHT * np.pi * (area - third if cubic else (RADIUS**2 - centre**2) * z)

    def rates(_, y):
        force = restoring(y[0]) - g @ y[2:]
        return np.concatenate([[y[1], force / inertia], model.state_matrix @ y[2:] + g * y[1]])

    first = np.concatenate([[height, 0.0], np.zeros(model.order)])
    return solve_ivp(rates, (0, TIME[-1]), first, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=TIME).y


@pytest.mark.parametrize("height", [1.0, 6.0, -3.0])
def test_decay_agrees_with_the_closed_form_of_a_sphere(height, scenes, decay, sphere):
    """From 6 m too, out of the water."""
    expected = closed_form(scenes[1], sphere.centre_height, height)
    motion = decay(height)
    assert np.abs(motion.position[:, 0] - expected[0]).max() < 1e-8 * abs(height)
    assert np.abs(motion.velocity[:, 0] - expected[1]).max() < 1e-7 * abs(height)


def test_linear_decay_has_the_published_extrema(scenes):
    found = turns(propagate(System.of(scenes[0]), TIME, scenes[0].start(1.0, 0.0)))[:6]
    assert np.all(np.abs(found - PUBLISHED) < (0.02, 0.01)), found - PUBLISHED


def test_decay_from_one_metre_is_within_the_published_spread(scenes, decay):
    """Nearer to linear theory than the farthest of them, and later at every extremum, by less than 1 %."""
    linear = propagate(System.of(scenes[0]), TIME, scenes[0].start(1.0, 0.0))
    difference = decay(1.0).position[:, 0] - linear.position[:, 0]
    assert 1e-3 < np.sqrt(np.mean(difference**2)) < SPREAD
    late = turns(decay(1.0))[:6, 0] / turns(linear)[:6, 0] - 1
    assert np.all((late > 1e-3) & (late < 1e-2)), late


def test_optimal_dampings_in_regular_waves_are_as_published():
    omega = 2 * np.pi / np.array(PERIODS)
    impedance, _ = heave_alone(omega)
    assert np.abs(impedance) == pytest.approx(DAMPERS, rel=2e-3)


def test_heave_with_optimal_damping_is_as_published():
    omega = 2 * np.pi / np.array(PERIODS)
    impedance, force = heave_alone(omega)
    heave = np.abs(force / (omega * (impedance + DAMPERS))) * WAVES
    assert heave == pytest.approx(HEAVES, rel=1e-2)


def heave_alone(omega):
    """Impedance B + i(K/w - w(m + A)) [N s/m] and excitation [N/m] of the sphere, by the spectral solver."""
    problem = SpectralProblem(rigid_sphere(RADIUS, 0.0), (Displacement("heave"),), DENSITY, GRAVITY, 24)
    ds = problem.solve(omega.tolist())
    inertia, stiffness = MASS + ds.added_mass.values[:, 0, 0], WEIGHT * np.pi * RADIUS**2
    force = (ds.Froude_Krylov_force + ds.diffraction_force).values.reshape(-1)
    return ds.radiation_damping.values[:, 0, 0] + 1j * (stiffness / omega - omega * inertia), force
