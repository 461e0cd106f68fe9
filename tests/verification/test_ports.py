"""Runs in time with ports of strain and with damper matrices, against the multipoles' equation of motion."""

import numpy as np
import pytest
from scipy.special import eval_legendre
from verification.conftest import SEED
from verification.multipoles import Shell, motion, strain_port

SHELL, DEGREE, ALL, AMPLITUDE = Shell(mass=17170.0), 6, 140, 0.02
ALONE = {"designs": {"VSWEC": {}}}


def steady(period: float) -> dict:
    """A run of whole periods, most of them for the transient."""
    return {"duration": 60 * period, "window": [50 * period, 60 * period]}


def powers(run, name: str, period: float, pto: dict, degree: int = DEGREE, **sections) -> tuple[float, float]:
    """Mean power of the package's run in time, and of its frequency domain, W."""
    wave = {"kind": "regular", "amplitude": AMPLITUDE, "period": period}
    modes = {"basis": "full", "degree": degree}
    found = run(name, waves=[wave], pto=pto, simulation=steady(period), modes=modes, **ALONE, **sections)
    return found.comparison.power_mean.iloc[0], found.ladder.query("rung == 'fixed'").power_mean.iloc[0]


def absorbed(velocity: np.ndarray, admittance: np.ndarray, matrix: np.ndarray) -> float:
    """Mean power V^H C V/2 of the steady motion, V = V0 - Y C V, W."""
    moved = np.linalg.solve(np.eye(len(matrix)) + admittance @ matrix, velocity)
    return AMPLITUDE**2 / 2 * float(np.real(moved.conj() @ matrix @ moved))


@pytest.mark.parametrize(("kind", "held"), [("area", True), ("hoop", False)])
def test_strain(agree, run, kind, held):
    """A damper on the change of area with the frame held, and on the hoop strain of a belt with the frame free.

    At the ends of a belt, and where the pressure of so soft a wall's water sets in, the package knows what all degrees
    do: so do the multipoles.
    """
    period, belt = 3.0, (60.0, 120.0) if kind == "hoop" else (0.0, 180.0)
    solved = 30 if kind == "hoop" else DEGREE
    water = motion(SHELL, period, ALL)
    port = (water.modes.T @ strain_port(SHELL, ALL, kind, belt))[:, None]
    port[0] = 0.0  # heave strains nothing
    velocity, admittance = water.network(port, slice(1 if held else 0, None))
    best = np.array([[1 / abs(admittance[0, 0])]])
    pto = {"port": {"strain": kind, "belt": list(belt)}, "damping": float(best[0, 0])}
    held_pto = {"held": {"place": "heave"}} if held else {}
    in_time, steady_state = powers(run, f"strain_{kind}", period, pto | held_pto, solved)
    wanted = absorbed(velocity, admittance, best)
    agree("strain ports", f"power of a damper on {kind}, frequency domain", steady_state, wanted, 5e-3)
    agree("strain ports", f"power of a damper on {kind}, in time", in_time, wanted, 2e-2)


@pytest.mark.parametrize(
    ("port", "order", "tolerance"),
    [({"between": [0.0, 180.0]}, 2, 2e-5), ({"colatitude": 120.0, "direction": "radial"}, 3, 2e-6)],
)
def test_ports_that_bend_the_wall(agree, run, port, order, tolerance):
    """Between the poles, and normal to the wall below water: degrees to 240, all in the water, and no modes of rings.

    Under such loads errors of the multipoles fall with that order of the degree. The package has 20 degrees, and what
    further ones do beside the port and the waterline sees the water; without, the power between the poles would be
    1.5 % off.
    """
    period, name, wall = 3.3, next(iter(port)), {"thickness": 0.02, "young_modulus": 6.0e7, "density": 1100.0}
    shell = Shell(**wall)

    def network(degree: int) -> tuple[np.ndarray, np.ndarray]:
        n, water = np.arange(degree + 1), motion(shell, period, degree)
        cos = np.cos(np.deg2rad(port.get("colatitude", 90.0)))
        radial = 1 + (-1.0) ** n if name == "between" else eval_legendre(n, cos)
        moved = (water.modes.T @ np.concatenate([radial, 0 * radial]))[:, None]
        moved[0] = cos if name == "colatitude" else 0.0  # heave
        return water.network(moved)

    few, many = network(120), network(240)
    best = np.array([[1 / abs(many[1][0, 0])]])
    wanted = (2**order * absorbed(*many, best) - absorbed(*few, best)) / (2**order - 1)
    pto, device = {"port": port, "damping": float(best[0, 0])}, SEED["device"] | wall | {"mass": shell.total_mass}
    in_time, steady_state = powers(run, name, period, pto, 20, device=device, hydro=SEED["hydro"] | {"tolerance": 1e-4})
    agree("ports that bend the wall", f"power of a damper, {name}, frequency domain", steady_state, wanted, tolerance)
    agree("ports that bend the wall", f"power of a damper, {name}, in time", in_time, wanted, tolerance)


def test_damper_matrix(agree, run):
    """Heave and change of area, coupled by the damper matrix of the take-off.

    With degrees to 6 alone the power would be 22 % off: what all do at the waterline is in the package.
    """
    period = 3.0
    water = motion(SHELL, period, ALL)
    area = water.modes.T @ strain_port(SHELL, ALL, "area")
    heave = np.eye(len(area))[0]
    area[0] = 0.0
    velocity, admittance = water.network(np.column_stack([heave, area]))
    own = 1 / np.abs(np.diag(admittance))
    matrix = np.diag(own) - 0.8 * np.sqrt(own.prod()) * (np.ones((2, 2)) - np.eye(2))
    ports = {"frame": "heave", "wall": {"strain": "area"}}
    in_time, steady_state = powers(run, "matrix", period, {"ports": ports, "damping": matrix.tolist()})
    wanted = absorbed(velocity, admittance, matrix)
    agree("damper matrices", "power at heave and area, frequency domain", steady_state, wanted, 1e-3)
    agree("damper matrices", "power at heave and area, in time", in_time, wanted, 2e-2)
    apart = absorbed(velocity, admittance, np.diag(own))
    assert abs(wanted / apart - 1) > 0.1  # else the coupling would not have been tested
