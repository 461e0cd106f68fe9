"""A balloon of rubber afloat against the equations of a membrane, solved by shooting."""

import numpy as np
from verification.conftest import SEED
from verification.membrane import WATER, Balloon, neo_hookean

MASS = WATER * 2 / 3 * np.pi * 2.0**3
"""Of a sphere of 2 m that is half immersed before it is inflated."""


def test_rest_shape(agree, run):
    """Inflated by a seventh; the other 4e-5 or so of the radius are modes beyond degree 14."""
    thickness, mu, pressure = 0.004, 12.5e6, 24e3
    modes = run(
        "balloon",
        device={
            "radius": 2.0,
            "thickness": thickness,
            "density": 1100.0,
            "mass": MASS,
            "material": {"law": "neo_hookean", "mu": mu},
            "internal_pressure": pressure,
        },
        modes={"basis": "full", "degree": 14},
        reference_shape="equilibrium",
        designs={"VSWEC": {}},
        water=SEED["water"],
        hydro={"tolerance": 1e-2, "omega_max": 12.0, "witness": "none"},
        pto={"damping": 8000.0},
        waves=[{"kind": "still"}],
        simulation={"duration": 10.0, "window": [5.0, 10.0]},
    ).modes
    phi = np.linspace(0.1, np.pi - 0.1, 117)
    v, u = ((modes.static_amplitude @ modes[name]).interp(colatitude=phi).values for name in ("radial", "meridional"))
    x = (2.0 + v) * np.sin(phi) + u * np.cos(phi)
    z = modes.attrs["centre_height"] + (2.0 + v) * np.cos(phi) - u * np.sin(phi)
    stretch = np.hypot(np.gradient(x, phi), np.gradient(z, phi))[[0, -1]] / 2.0
    guess = (stretch[0], z[0] + 0.01, stretch[1], z[-1] - 0.01)
    own = Balloon(2.0, thickness, neo_hookean(mu), MASS, pressure).meridian(phi, guess)
    agree("rubber", "meridian of a floating balloon, degree 14", [x, z], own, 3e-4)
