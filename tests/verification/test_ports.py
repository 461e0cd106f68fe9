"""Runs in time with ports of strain and with damper matrices, against the multipoles' equation of motion."""

import numpy as np
import pytest
from verification.multipoles import Shell, motion, strain_port

SHELL, DEGREE, AMPLITUDE = Shell(mass=17170.0), 6, 0.02
ALONE = {"designs": {"VSWEC": {}}}


def steady(period: float) -> dict:
    """A run of whole periods, most of them for the transient."""
    return {"duration": 60 * period, "window": [50 * period, 60 * period]}


def powers(run, name: str, period: float, pto: dict, degree: int = DEGREE) -> tuple[float, float]:
    """Mean power of the package's run in time, and of its frequency domain, W."""
    wave = {"kind": "regular", "amplitude": AMPLITUDE, "period": period}
    modes = {"basis": "full", "degree": degree}
    found = run(name, waves=[wave], pto=pto, simulation=steady(period), modes=modes, **ALONE)
    return found.comparison.power_mean.iloc[0], found.ladder.query("rung == 'fixed'").power_mean.iloc[0]


def absorbed(velocity: np.ndarray, admittance: np.ndarray, matrix: np.ndarray) -> float:
    """Mean power V^H C V/2 of the steady motion, V = V0 - Y C V, W."""
    moved = np.linalg.solve(np.eye(len(matrix)) + admittance @ matrix, velocity)
    return AMPLITUDE**2 / 2 * float(np.real(moved.conj() @ matrix @ moved))


@pytest.mark.parametrize(("kind", "held"), [("area", True), ("hoop", False)])
def test_strain(agree, run, kind, held):
    """A damper on the change of area with the frame held, and on the hoop strain of a belt with the frame free.

    The ends of a belt are line loads, under which the package knows what all degrees do: so do the multipoles.
    """
    period, belt = 3.0, (60.0, 120.0) if kind == "hoop" else (0.0, 180.0)
    solved, known = (30, 140) if kind == "hoop" else (DEGREE, DEGREE)
    water = motion(SHELL, period, known)
    port = (water.modes.T @ strain_port(SHELL, known, kind, belt))[:, None]
    port[0] = 0.0  # heave strains nothing
    velocity, admittance = water.network(port, slice(1 if held else 0, None))
    best = np.array([[1 / abs(admittance[0, 0])]])
    pto = {"port": {"strain": kind, "belt": list(belt)}, "damping": float(best[0, 0])}
    held_pto = {"held": {"place": "heave"}} if held else {}
    in_time, steady_state = powers(run, f"strain_{kind}", period, pto | held_pto, solved)
    wanted = absorbed(velocity, admittance, best)
    agree("strain ports", f"power of a damper on {kind}, frequency domain", steady_state, wanted, 5e-3)
    agree("strain ports", f"power of a damper on {kind}, in time", in_time, wanted, 2e-2)


def test_damper_matrix(agree, run):
    """Heave and change of area, coupled by the damper matrix of the take-off."""
    period = 3.0
    water = motion(SHELL, period, DEGREE)
    area = water.modes.T @ strain_port(SHELL, DEGREE, "area")
    heave = np.eye(len(area))[0]
    area[0] = 0.0
    velocity, admittance = water.network(np.column_stack([heave, area]))
    own = 1 / np.abs(np.diag(admittance))
    matrix = np.diag(own) - 0.8 * np.sqrt(own.prod()) * (np.ones((2, 2)) - np.eye(2))
    ports = {"frame": "heave", "wall": {"strain": "area"}}
    in_time, steady_state = powers(run, "matrix", period, {"ports": ports, "damping": matrix.tolist()})
    wanted = absorbed(velocity, admittance, matrix)
    agree("damper matrices", "power at heave and area, frequency domain", steady_state, wanted, 5e-3)
    agree("damper matrices", "power at heave and area, in time", in_time, wanted, 2e-2)
    apart = absorbed(velocity, admittance, np.diag(own))
    assert abs(wanted / apart - 1) > 0.1  # else the coupling would not have been tested
