"""Derivatives of a year's power against multipoles, and against numbers that were computed apart from the package."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from verification.conftest import SEED
from verification.multipoles import Shell, ports

import vsb

CLIMATE = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
WAVES = {"waves": [{"kind": "still"}]}


@pytest.fixture(scope="module")
def climate():
    """NDBC 46042, 1996."""
    return vsb.read_seas(CLIMATE)


def year(shell: Shell, climate, flexible: bool) -> float:
    """Mean power of the mean spectrum under its best damper: Gauss' rule in each band, search over dampers."""
    node, weight = np.polynomial.legendre.leggauss(3)
    half = np.diff(climate.edges)[:, None] / 2
    omega, squares = (
        (climate.omega[:, None] + half * node).ravel(),
        (2 * climate.mean_density[:, None] * half * weight).ravel(),
    )
    waves = [ports(shell, 2 * np.pi / w, 6)[flexible] for w in omega]

    def lost(log_damping: float) -> float:
        return -sum(s * wave.power(np.exp(log_damping)) for s, wave in zip(squares, waves, strict=True))

    return -float(minimize_scalar(lost, bounds=(9.0, 14.0), method="bounded", options={"xatol": 1e-8}).fun)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_gradient_against_multipoles(agree, climate, design):
    """A thick shell, half submerged, undeformed; as its radius changes its mass keeps it half submerged."""
    shell = Shell(thickness=0.05, young_modulus=5e7)
    device = SEED["device"] | {"thickness": 0.05, "young_modulus": 5e7, "mass": shell.total_mass}
    path = {"device.radius": "radius"} if design == "FSB" else {
        "device.radius": "radius", "device.thickness": "thickness", "device.young_modulus": "young_modulus",
        "device.poisson_ratio": "poisson_ratio", "device.density": "density",
    }  # fmt: skip
    study = vsb.Study.model_validate({**SEED, **WAVES, "device": device, "designs": {design: SEED["designs"][design]}})
    found = vsb.gradient(study, climate, [*path, "device.mass"])
    power = float(found.annual_mean_power[0])
    slopes = (found.annual_mean_power_gradient[0] * found.value / power).values
    slopes[0] += 3 * slopes[-1]
    wanted = []
    for name in path.values():
        values = [
            np.log(year(replace(shell, **{name: getattr(shell, name) * (1 + step)}), climate, design == "VSWEC"))
            for step in (-0.02, -0.01, 0.01, 0.02)
        ]
        wanted.append((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / 0.12)
    agree("gradient of a year", f"mean power, {design}", power, year(shell, climate, design == "VSWEC"), 1e-6)
    agree("gradient of a year", f"d ln P/d ln (r, h, E, nu, rho), {design}", slopes[:-1], wanted, 1e-6)


def test_a_flexible_buoy_rests_stably_up_to_the_spring_of_the_multipoles(climate):
    """A negative spring overcomes what heave and shell together resist, 1/(b^T K^-1 b), K of shell and water."""
    shell = Shell(thickness=0.05, young_modulus=5e6)
    modes = shell.modes(6, "full")
    stiffness = modes.T @ shell.hydrostatics(6) @ modes
    for n in range(7):
        stiffness += modes[[n, 7 + n]].T @ shell.stiffness(n) @ modes[[n, 7 + n]]
    bears = 1 / np.linalg.inv((stiffness + stiffness.T) / 2)[0, 0]
    assert bears < 0.95 * shell.water * 9.81 * np.pi * shell.radius**2  # what the rigid sphere bears
    device = SEED["device"] | {"thickness": 0.05, "young_modulus": 5e6, "mass": shell.total_mass}

    def year_with(spring: float) -> float:
        study = {**SEED, **WAVES, "device": device, "designs": {"VSWEC": {}}, "pto": {"stiffness": spring}}
        return float(vsb.gradient(vsb.Study.model_validate(study), climate, []).annual_mean_power[0])

    assert year_with(-bears * (1 - 1e-6)) > 0
    with pytest.raises(vsb.VsbError, match="not stable at rest: its least stiffness"):
        year_with(-bears * (1 + 1e-6))


def test_gradient_against_stored_numbers(agree, climate):
    """The seed's shell under 16.5 kPa at its equilibrium: values of a prototype of its own in other coordinates."""
    device = SEED["device"] | {"internal_pressure": 16.5e3}
    study = {**SEED, **WAVES, "device": device, "designs": {"VSWEC": {}}, "reference_shape": "equilibrium"}
    keys = [f"device.{name}" for name in ("radius", "thickness", "young_modulus", "internal_pressure", "mass")]
    found = vsb.gradient(vsb.Study.model_validate(study), climate, keys)
    power = float(found.annual_mean_power[0])
    slopes = (found.annual_mean_power_gradient[0] * found.value / power).values
    stored = [1.7945833, -0.0638289, -0.0637780, 0.1574780, -0.0265769]
    agree("gradient of a year", "mean power, pressurised shell", power, 11895.0336, 5e-6)
    agree("gradient of a year", "its damper", float(found.damping[0]), 158085.0, 5e-6)
    agree("gradient of a year", "d ln P/d ln (r, h, E, p, m)", slopes, stored, 5e-7, absolute=True)
