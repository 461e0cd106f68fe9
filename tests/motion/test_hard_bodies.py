"""Bodies with motions that move no water, without damping or mass, and with thirty degrees of freedom."""

import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConfigError
from vsb.hydro.realisation import StateSpace, least_damping
from vsb.integrators.simulate import simulate
from vsb.motion.bodies import body_scene, linear_body
from vsb.motion.system import System
from vsb.study.sections import Simulation
from vsb.waves.seas import Sea

PAIR = ("influenced_dof", "radiating_dof")
OMEGA = np.arange(1, 81) * 0.05


def database(labels, channels, mass=1.0, stiffness=1.0):
    """Degrees of freedom that radiate through resonances s/(s^2 + 2 a s + b) of given directions (channel, dof)."""
    dof, s = len(labels), 1j * OMEGA
    poles = -0.4 + 1j * np.linspace(0.6, 1.8, len(channels))
    k = sum(
        (s / ((s - p) * (s - p.conjugate())))[:, None, None] * np.outer(c, c)
        for p, c in zip(poles, channels, strict=True)
    )
    k = np.zeros((len(OMEGA), dof, dof), complex) if isinstance(k, int) else k
    one = np.eye(dof)
    force = np.sqrt(np.abs(np.einsum("wii->wi", k.real)))[:, None, :].astype(complex)
    data = {
        "added_mass": (("omega", *PAIR), k.imag / OMEGA[:, None, None] + one),
        "radiation_damping": (("omega", *PAIR), k.real),
        "added_mass_inf": (PAIR, one),
        "excitation_force": (("omega", "wave_direction", "influenced_dof"), force),
        "hydrostatic_stiffness": (PAIR, stiffness * one),
        "inertia_matrix": (PAIR, np.diag(np.broadcast_to(mass, dof))),
        "structural_stiffness": (PAIR, 0.0 * one),
        "structural_damping_matrix": (PAIR, 0.0 * one),
    }
    return xr.Dataset(data, {"omega": OMEGA, "wave_direction": [0.0], **dict.fromkeys(PAIR, labels)})


def run(body, memory, duration=60.0):
    """Motion in a wave of one radian a second."""
    sea = Sea(np.array([1.0]), np.array([0.1 + 0.0j]))
    system = System.of(body_scene(body, memory, {0.0: sea}))
    found, _, _ = simulate(system, sea, Simulation(duration=duration, window=(0.0, duration), method="exact"), None)
    return found


def test_yaw_without_radiation_stays_out_of_the_memory():
    """Round-off of its damping is no radiation channel."""
    channels = np.array([[1.0, 0.3, 0.0], [-0.2, 0.8, 0.0]])
    ds = database(["Surge", "Pitch", "Yaw"], channels)
    rng = np.random.default_rng(0)
    noise = 1e-15 * rng.normal(size=ds.radiation_damping.shape)
    shaken = ds.assign(radiation_damping=ds.radiation_damping + noise + noise.swapaxes(1, 2))
    with_yaw, without = (linear_body(shaken, names) for names in (["Surge", "Pitch", "Yaw"], ["Surge", "Pitch"]))
    three, two = with_yaw.memory(1e-3), without.memory(1e-3)
    assert three.model.order == two.model.order
    assert np.abs(three.model.input_matrix[:, 2]).max() < 1e-12
    a, b = (run(body, memory).position for body, memory in ((with_yaw, three), (without, two)))
    assert a[:, :2] == pytest.approx(b, abs=1e-6 * np.abs(b).max())


def test_modes_without_dry_mass_and_without_any_inertia():
    ds = database(["Heave", "Mode7"], np.array([[1.0, 0.4]]), mass=np.array([1.0, 0.0]))
    body = linear_body(ds)
    assert np.isfinite(run(body, body.memory(1e-3)).position).all()
    light = ds.added_mass_inf.values.copy()
    light[1, 1] = 0.0
    with pytest.raises(ConfigError, match=r"mass: received Mode7 without inertia, the water's at infinite frequency"):
        linear_body(ds.assign(added_mass_inf=(PAIR, light)))


def test_radiation_of_thirty_degrees_of_freedom_is_passive():
    """Five channels of known poles, certified by the Hamiltonian matrix."""
    rng = np.random.default_rng(5)
    channels = rng.normal(size=(5, 30))
    labels = ["Heave", *(f"Mode{i}" for i in range(7, 36))]
    body = linear_body(database(labels, channels))
    fit = body.memory(1e-3)
    assert fit.error <= 1e-3
    assert fit.model.order <= 20
    g = fit.model.input_matrix / body.samples.size
    least = least_damping(StateSpace(fit.model.state_matrix, g, g.T))
    assert least.bound > -1e-6
    poles = np.sort(np.abs(np.linalg.eigvals(fit.model.state_matrix).imag))
    for known in np.linspace(0.6, 1.8, 5):
        assert np.abs(poles - known).min() < 0.02 * known
    assert np.isfinite(run(body, fit, 30.0).position).all()
