"""Hydrodynamics, shell and gains of the half-submerged sphere against multipoles, closed forms and published values."""

import json

import numpy as np
import pytest
import yaml
from verification.conftest import SEED
from verification.multipoles import Shell, gain, ports, radiation

import vsb

PERIODS = (2.5, 3.0, 3.3, 5.0, 8.0)
ALL_DEGREES = 180
"""From where on gains under a clamp change by less than 0.02 points."""


def sphere(radius: float = 1.0) -> vsb.DeformedShell:
    """Half submerged, of no modes."""
    shell = vsb.Shell(radius, radius / 200, 1e7, 0.3, 2700.0)
    return vsb.DeformedShell(vsb.ModeBasis(shell, (), 1.0, True), 0.0)


def test_solver_against_multipoles(agree):
    """Radial velocities of degrees 0 to 20: added mass and damping from long to short waves."""
    shapes = tuple(vsb.Displacement("radial", n) for n in range(21))
    problem = vsb.SpectralProblem(sphere(), shapes, 1000.0, 9.81, 32)
    wavenumbers = np.array([0.05, 0.3, 1.0, 3.0, 10.0])
    omega = np.sqrt(9.81 * wavenumbers)
    found = problem.solve(omega.tolist())
    added, damping = found["added_mass"].values / 1000, found["radiation_damping"].values / 1000
    for at, ka in enumerate(wavenumbers):
        water = radiation(float(ka), 20)
        agree("hydrodynamic solver", f"added mass, P0 to P20, Ka = {ka}", added[at], water.added_mass, 1e-5)
        agree("hydrodynamic solver", f"damping, Ka = {ka}", damping[at] / omega[at], water.damping, 1e-5)


HEAVE = {0.1: (0.8627, 0.1816), 0.3: (0.7157, 0.3254), 1.0: (0.4284, 0.2484)}
SURGE = {0.5: (0.6439, 0.0987), 1.0: (0.5740, 0.3535), 1.2: (0.4860, 0.3978)}
"""Hulme (1982), J. Fluid Mech. 121, tables 1 and 2: Ka, A and B/omega in units of 2/3 pi rho a^3."""


@pytest.mark.parametrize(("kind", "order", "table"), [("heave", 0, HEAVE), ("surge", 1, SURGE)])
def test_solver_against_hulme(agree, kind, order, table):
    """Heave and surge of a hemisphere as published, to the digits printed."""
    problem = vsb.SpectralProblem(sphere(), (vsb.Displacement(kind, order=order),), 1000.0, 9.81, 32)
    omega = np.sqrt(9.81 * np.array(list(table)))
    found = problem.solve(omega.tolist())
    unit = 2 / 3 * np.pi * 1000.0
    added, damping = (found[name].values[:, 0, 0] / unit for name in ("added_mass", "radiation_damping"))
    wanted = np.array(list(table.values()))
    name = "azimuthal orders" if order else "hydrodynamic solver"
    agree(name, f"{kind}, Hulme's table", np.column_stack([added, damping / omega]), wanted, 1.5e-4, absolute=True)


def test_natural_frequencies(agree, command, tmp_path):
    """Dry shell, degrees 0 to 6: both roots of the closed form of membrane and bending theory (Baker; Lamb)."""
    path = tmp_path / "shell.yaml"
    waves = {"waves": [{"kind": "still"}], "pto": {"damping": 8000.0}}
    path.write_text(yaml.safe_dump({**SEED, **waves}), encoding="utf-8")
    printed = json.loads(command("shell", path, "--json")[0])
    e, nu, rho, r, h = 1e7, 0.3, 2700.0, 2.0, 0.01
    n, k = np.arange(7), (h / r) ** 2 / 12
    m = n * (n + 1) - 2.0  # degree 0: the upper root alone; degree 1: the lower is rigid heave
    a = 3 * (1 + nu) + m + k * (m + 3) * (m + 1 + nu)
    b = 1 - nu**2 + k * ((m + 1) ** 2 - nu**2)
    root = np.sqrt(a**2 - 4 * m * b)
    unit = e / (2 * (1 - nu**2) * rho * r**2)
    upper, lower = np.sqrt(unit * (a + root)), np.sqrt(unit * (a - root)[2:])
    at = {key: {row["degree"]: row["omega"] for row in printed[key]} for key in ("membrane", "bending")}
    agree("shell", "upper branch, degrees 0 to 6", [at["membrane"][i] for i in n], upper, 1e-9)
    agree("shell", "lower branch, degrees 2 to 6", [at["bending"][i] for i in n[2:]], lower, 1e-9)
    zoelly = 2 * e * (h / r) ** 2 / np.sqrt(3 * (1 - nu**2))
    agree("buckling", "uniform external pressure, Zoelly", printed["buckling_pressure"], zoelly, 1e-12)


@pytest.mark.parametrize(("basis", "degree"), [("membrane", 6), ("full", 6), ("full", 30)])
def test_gain(agree, run, basis, degree):
    """Gain, power and best damper of the free and of the clamped shell in regular waves.

    A clamp of a wall that bends is a line load, under which the package knows what all degrees do: so do the multipoles.
    """
    periods = PERIODS if degree == 6 else (2.5, 3.0)
    waves = [{"kind": "regular", "amplitude": 0.1, "period": t} for t in periods]
    brief = {"duration": 40.0, "window": [32.0, 40.0]}
    results = run(f"{basis}{degree}", modes={"basis": basis, "degree": degree}, waves=waves, simulation=brief)
    rows = {(r["design"], r["wave"], r["rung"]): r for r in results.ladder.to_dict("records")}
    labels = list(dict.fromkeys(r["wave"] for r in results.ladder.to_dict("records")))
    shell, name = Shell(mass=17170.0), f"{basis} {degree}"
    at = {d: [rows[d, label, "best_damper"] for label in labels] for d in ("FSB", "VSWEC", "VSWEC90")}
    power = {d: np.array([row["power_mean"] for row in at[d]]) for d in at}
    for design, clamp in (("VSWEC", False), ("VSWEC90", True)):
        if clamp and (basis, degree) == ("full", 6):  # what six degrees of the water leave out is in the interval
            continue
        known = ALL_DEGREES if clamp and basis == "full" else degree
        own = [ports(shell, t, known, basis, clamp)[1] for t in periods]
        found = 100 * (power[design] / power["FSB"] - 1)
        wanted = [gain(shell, t, known, basis, clamp) for t in periods]
        agree("converged modes", f"gain of {design}, {name} [points]", found, wanted, 0.2, absolute=True)
        damper = np.array([row["damping"] for row in at[design]])
        agree(
            "ladder",
            f"best damper of {design}, {name}",
            damper / [abs(p.impedance) for p in own],
            np.ones(len(periods)),
            5e-3,
        )
    rigid = [ports(shell, t, 1)[0] for t in periods]
    wanted = np.array([0.01 * p.power() for p in rigid])
    agree("ladder", f"power of FSB at its best damper, {name}", power["FSB"] / wanted, np.ones(len(periods)), 2e-3)
    matched = np.array([rows["FSB", label, "matched"]["power_mean"] for label in labels])
    agree("ladder", "matched power of FSB, J lambda/2pi", matched, [0.01 * p.limit for p in rigid], 1e-3)
