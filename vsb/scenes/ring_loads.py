"""Loads at rings of a shell, answered by all its degrees: what the modes of a basis leave out of clamps and ports.

A clamp, a ring that is held and a port at a ring load the wall along a line. All degrees yield to that: normal to the
wall like n^-4, by bending, but along it like n^-2, by stretching, so what degrees above N leave out falls like 1/N.
They answer statically (residual compliance, MacNeal 1971 and Rubin 1975): with the displacements R_n of the rings in
degree n and its elastic stiffness K_n,

    S = sum_{n > N} R_n K_n^-1 R_n^T,    d = R q + S g,    D q = X + R^T g

for ring displacements d under ring forces g, so that d = R D^-1 X + (R D^-1 R^T + S) g. Clamps hold their d at zero;
what is left at the port is its free velocity and its admittance.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import legendre_p_all

from vsb.hydro.dofs import flexible
from vsb.motion.port import Port
from vsb.scenes.floating_system import AtFrequencies
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, bending_block, membrane_block
from vsb.shell.shell import Shell
from vsb.study.specs import AnyBuoy
from vsb.study.take_off import ShellPort
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

HIGHEST = 4000
"""Degree to which compliances are summed; what is left of the sum is degree/HIGHEST of it."""
AT_POLE = 1e-9
"""Sine of a colatitude below which nothing moves along the meridian, by symmetry [-]."""


class Rings(NamedTuple):
    """Displacements by line loads on a shell: of modes, and of higher degrees."""

    rows: FloatArray  # per unit amplitude of heave and modes (row, dof) [-]
    colatitude: FloatArray  # (row,) [rad]
    along: FloatArray  # radial and meridional part of each; zero: not of the shell alone (row, 2) [-]


def all_degrees_answer(study: AnyBuoy) -> bool:
    """Return whether `ports_of_all_degrees` knows what higher degrees of a study's shell do at its rings.

    Of an elastic sphere without prestress, with both branches of modes; of a port in heave, of volume or at a ring.
    """
    device, modes, port = study.device, study.modes, study.pto.port
    plain = device.shape is None and not device.internal_pressure and not device.damping.maxwell
    return bool(
        plain
        and not study.at_equilibrium
        and modes.basis == "full"
        and not study.pto.several
        and (port in ("heave", "volume") or isinstance(port, ShellPort))
    )


def residual_compliance(shell: Shell, degree: int, colatitude: FloatArray, along: FloatArray) -> FloatArray:
    """Return S, displacements at rings of a sphere by forces there, of the degrees above one, shape (row, row) [m/N].

    Parameters
    ----------
    colatitude : ndarray, shape (row,) [rad]
    along : ndarray, shape (row, 2) [-]
        Radial and meridional part of each displacement.
    """
    p, by_cos = legendre_p_all(HIGHEST, np.cos(colatitude), diff_n=1)
    slope = -np.sin(colatitude) * by_cos
    compliance = np.zeros((len(along), len(along)))
    for n in range(max(degree, 1) + 1, HIGHEST + 1):
        rows = along * np.column_stack([p[n], slope[n]])
        compliance += rows @ np.linalg.solve(membrane_block(shell, n) + bending_block(shell, n), rows.T)
    return compliance


def rings_held(study: AnyBuoy, basis: ModeBasis, design: str) -> Rings:
    """Return what clamps and mooring of a design hold at zero, each once; nothing moves along the wall at a pole."""
    clamps = np.unique(np.deg2rad(study.designs[design].clamp))
    held, rows, along, at = study.pto.held, [], [], []
    both = basis.clamp_rows(clamps)
    for i, angle in enumerate(clamps):
        for row, direction in ((both[i], (1.0, 0.0)), (both[len(clamps) + i], (0.0, 1.0))):
            if direction[0] or abs(np.sin(angle)) > AT_POLE:
                rows.append(row)
                along.append(direction)
                at.append(angle)
    if held is not None and held.place == "heave":
        rows, along, at = [*rows, np.eye(len(basis.labels))[0]], [*along, (0.0, 0.0)], [*at, 0.0]
    elif held is not None:
        angle = np.deg2rad(held.colatitude)
        rows.append(DeformedShell(basis, 0.0).meridian(np.array([angle])).shape_z[:, 0])
        along.append((np.cos(angle), -np.sin(angle)))
        at.append(angle)
    return Rings(np.reshape(rows, (-1, len(basis.labels))), np.array(at), np.reshape(along, (-1, 2)))


def ports_of_all_degrees(
    study: AnyBuoy, basis: ModeBasis, buoy: AtFrequencies, degree: int | None = None
) -> dict[str, Port]:
    """Return the ports of the designs of a heaving study with the compliance of all higher degrees at its rings.

    Parameters
    ----------
    study : Study or BuoySystem
        One of which `all_degrees_answer`.
    buoy : AtFrequencies
        In the modes of a basis.
    degree : int, optional
        Of the highest modes that move; by default all.
    """
    highest = basis.highest_degree if degree is None else degree
    free = np.flatnonzero(np.array(basis.degrees) <= highest)
    found = {}
    for design, motions in buoy.motions.items():
        if flexible(basis.labels, motions):
            held = rings_held(study, basis, design)
            found[design] = _port(study, basis.shell, buoy, held, free, highest)
        else:
            found[design] = buoy.equation.port(motions, buoy.port)
    return found


def _port(study: AnyBuoy, shell: Shell, buoy: AtFrequencies, held: Rings, free: IntArray, degree: int) -> Port:
    """The port of a flexible design."""
    port, at, along = study.pto.port, 0.0, (0.0, 0.0)
    if isinstance(port, ShellPort):
        at = np.deg2rad(port.colatitude)
        along = (1.0, 0.0) if port.direction == "radial" else (np.cos(at), -np.sin(at))
    rows = np.vstack([held.rows, buoy.port])[:, free]
    residual = residual_compliance(shell, degree, np.append(held.colatitude, at), np.vstack([held.along, along]))
    equation, beta = buoy.equation, study.device.damping.beta
    omega, stiffness = equation.omega, equation.dynamic_stiffness[:, free[:, None], free]
    waves = equation.water.excitation[:, free, None]
    lines = np.broadcast_to(rows.T, (len(omega), *rows.T.shape))
    moved = rows @ np.linalg.solve(stiffness, np.concatenate([waves, lines], axis=2))
    yielding = moved[..., 1:] + residual / (1 - 1j * omega * beta)[:, None, None]
    velocity, admittance = _left_at_port(moved[..., 0], yielding)
    at_rest = rows @ np.linalg.solve(equation.stiffness[np.ix_(free, free)], rows.T) + residual
    _, yields = _left_at_port(np.zeros((1, len(rows))), at_rest[None])
    rate = -1j * omega
    return Port(omega, rate * admittance, rate * velocity, float(yields[0].real)).behind(equation.chamber)


def _left_at_port(
    free: ComplexArray | FloatArray, yielding: ComplexArray | FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Displacement of the last row and its own by a force there, the others held, each (omega,) [m], [m/N].

    Parameters
    ----------
    free : ndarray, shape (omega, row)
        Without forces.
    yielding : ndarray, shape (omega, row, row)
        By forces.
    """
    forces = np.concatenate([free[:, :-1, None], yielding[:, :-1, -1:]], axis=2)
    reactions = np.linalg.solve(yielding[:, :-1, :-1], forces)
    taken = (yielding[:, -1:, :-1] @ reactions)[:, 0]
    return np.asarray(free[:, -1] - taken[:, 0]), np.asarray(yielding[:, -1, -1] - taken[:, 1])
