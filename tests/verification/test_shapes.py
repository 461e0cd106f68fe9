"""Shells that are spheroids at rest, and shells their load deforms, against own solutions on the meridian."""

import numpy as np
import pytest
from scipy.linalg import eigh, null_space
from verification.conftest import SEED
from verification.rest import Floating
from verification.revolution import Spheroid

PERIODS = (2.5, 3.0, 4.0, 6.0)


@pytest.fixture(scope="module", params=[3.0, 5.0], ids=["oblate", "prolate"])
def pair(request, run):
    """An own spheroid without structural damping, and the package's study of it."""
    own = Spheroid(2.0, request.param, 3e7, 10, beta=0.0)
    device = {
        "radius": 2.0,
        "thickness": 0.01,
        "young_modulus": 3e7,
        "poisson_ratio": 0.3,
        "density": 2700.0,
        "mass": own.mass,
        "shape": {"spheroid": {"height": request.param}},
    }
    results = run(
        f"spheroid{request.param:.0f}",
        device=device,
        modes={"basis": "full", "degree": 10},
        designs={"FSB": {"flexible": False}, "VSWEC": {}},
        waves=[{"kind": "regular", "amplitude": 0.05, "period": t} for t in PERIODS],
        simulation={"duration": 60.0, "window": [36.0, 60.0]},
    )
    return own, results


def test_gain(agree, pair):
    """Each buoy at its own best damper."""
    own, results = pair
    rows = {(r["design"], r["wave"]): r for r in results.ladder.to_dict("records") if r["rung"] == "best_damper"}
    labels = [
        r["wave"] for r in results.ladder.to_dict("records") if r["design"] == "FSB" and r["rung"] == "best_damper"
    ]
    power = {d: np.array([rows[d, label]["power_mean"] for label in labels]) for d in ("FSB", "VSWEC")}
    wanted = np.array([[0.0025 * p.power() for p in own.ports(t)] for t in PERIODS]).T
    name = f"spheroid {own.height:.0f} m"
    agree("rest shapes", f"power of the rigid {name}", power["FSB"] / wanted[0], np.ones(4), 2e-3)
    gain = 100 * (power["VSWEC"] / power["FSB"] - 1)
    agree("rest shapes", f"gain of the {name} [points]", gain, [own.gain(t) for t in PERIODS], 0.1, absolute=True)


def test_long_wave_force(agree, pair):
    """Excitation of the six lowest natural modes at the lowest frequency, in all their Legendre parts."""
    own, results = pair
    mass, elastic = own.structure
    heave = np.zeros(len(mass))
    heave[1] = heave[own.degree + 1] = 1
    free = null_space((mass @ heave)[None])
    vectors = free @ eigh(free.T @ elastic @ free, free.T @ mass @ free)[1]
    x, z, *_ = own.shapes(np.linspace(1e-6, np.pi - 1e-6, 4001))
    vectors /= np.sqrt(((vectors.T @ x) ** 2 + (vectors.T @ z) ** 2).max(axis=1))
    vectors *= np.sign((vectors.T @ z)[:, 0])
    database = results.database
    omega = float(database["omega"][0])
    shells = [f"Shell{n}" for n in range(1, 7)]
    found = database["excitation_force"].isel(omega=0, wave_direction=0).sel(influenced_dof=shells)
    wanted = own.radiation(omega)[2] @ vectors[:, :6]
    name = f"spheroid {own.height:.0f} m"
    agree("rest shapes", f"long-wave force of six modes of the {name}", np.asarray(found), wanted, 2e-3)
    still = own.long_wave_force() @ vectors[:, :6]
    agree("rest shapes", f"the same by -rho g int n.psi dS, {name}", np.asarray(found).real, still, 3e-2)


@pytest.mark.parametrize("height", [3.0, 5.0], ids=["oblate", "prolate"])
def test_gain_of_a_clamped_spheroid(agree, run, height):
    """A clamp is a line load, to which all degrees yield: the own solution's, extrapolated like 1/degree."""
    few, many = (Spheroid(2.0, height, 1e7, degree, thickness=0.02, clamp=90.0) for degree in (100, 200))
    wanted = [2 * many.gain(t) - few.gain(t) for t in PERIODS]
    device = {**SEED["device"], "thickness": 0.02, "mass": many.mass}
    results = run(
        f"clamped{height:.0f}",
        device={**device, "shape": {"spheroid": {"height": height}}},
        hydro={"tolerance": 1.0e-3, "omega_max": 14.0, "witness": "none"},  # modes of flat shells damp shorter waves
        modes={"basis": "full", "degree": 30},
        designs={"FSB": {"flexible": False}, "CLAMPED": {"clamp": 90}},
        waves=[{"kind": "regular", "amplitude": 0.05, "period": t} for t in PERIODS],
    )
    levels = results.ladder[results.ladder.rung == "best_damper"].pivot(
        index="wave", columns="design", values="power_mean"
    )
    rows = levels.loc[results.ladder.wave.unique()]
    found = 100 * (rows["CLAMPED"] / rows["FSB"] - 1)
    name = f"gain of the spheroid {height:.0f} m clamped at its equator [points]"
    agree("rest shapes", name, found, wanted, 0.1, absolute=True)


def test_rest_shape(agree, run):
    """The seed's shell under 20 kPa, afloat with its load: the more degrees, the nearer to splines' least energy."""
    phi = np.linspace(0, np.pi, 181)
    x, z = Floating(2.0, 0.01, 1e7, 0.3, 17170.0, 20e3).displacement(phi)
    for degree, tolerance in ((6, 1e-2), (14, 1.5e-3)):
        modes = run(
            f"rest{degree}",
            device={**SEED["device"], "internal_pressure": 20e3},
            modes={"basis": "full", "degree": degree},
            reference_shape="equilibrium",
            designs={"VSWEC": {}},
            hydro={"tolerance": 1e-2, "omega_max": 12.0, "witness": "none"},
            pto={"damping": 8000.0},
            waves=[{"kind": "still"}],
            simulation={"duration": 10.0, "window": [5.0, 10.0]},
        ).modes
        v, u = ((modes.static_amplitude @ modes[name]).values for name in ("radial", "meridional"))
        own = [v * np.sin(phi) + u * np.cos(phi), v * np.cos(phi) - u * np.sin(phi) + modes.attrs["centre_height"]]
        agree("rest shape", f"displacement by static load, degree {degree}", own, [x, z], tolerance)
