"""The ports of all designs of a study from the coefficients of its shape, which studies of other materials share."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from vsb.hydro.database import Coefficients, shares
from vsb.hydro.dofs import Displacement
from vsb.hydro.orders import order_shares
from vsb.motion.coefficient_errors import INTERPOLATION, RESOLUTION, CoefficientError, haskind_misfits, relative_error
from vsb.motion.frequency import LinearEquation
from vsb.motion.linear import channelled
from vsb.motion.port import Port, PortMotion, port_direction
from vsb.scenes.rest import (
    design_motions,
    motions_to_degree,
    order_bases,
    seen_by_take_off,
    side_by_side,
    viscous_parts,
    whole_stiffness,
)
from vsb.shell.deformed import ReferenceShell
from vsb.shell.modes import ModeBasis
from vsb.shell.orders import OrderBasis
from vsb.study.study import Study, Water
from vsb.tools.arrays import ComplexArray, FloatArray

POINTS = 13
"""Points of the meridian the shell's motion is given at, both poles and the equator among them."""
KEPT = 32
"""Combinations of displacements whose coefficients are kept: as many thicknesses as a sweep may well have."""


@dataclass(frozen=True)
class ShapeWater:
    """Coefficients of the displacements of one wetted shape."""

    displacements: tuple[Displacement, ...]
    omega: FloatArray  # (omega,) [rad/s]
    coefficients: Coefficients  # of the displacements
    orders: tuple["ShapeWater", ...] = ()  # those of azimuthal orders 1, 2, ..., if the buoy moves in them
    resolution: float = 0.0  # estimated relative error of what is solved, and of what is interpolated between [-]
    interpolation: float = 0.0
    _known: dict[bytes, Coefficients] = field(default_factory=dict, repr=False, compare=False)

    def in_modes(self, basis: ModeBasis, families: Sequence[OrderBasis] = ()) -> Coefficients:
        """Return the coefficients of heave and modes, and of families of higher orders, each of one channel."""
        own = self._combined(shares(self.displacements, basis))
        others = [self.orders[each.order - 1] for each in families]
        beyond = [
            water._combined(order_shares(water.displacements, each))
            for water, each in zip(others, families, strict=True)
        ]
        return Coefficients.side_by_side([own, *beyond])

    def errors(self, basis: ModeBasis, families: Sequence[OrderBasis], water: Water) -> list[CoefficientError]:
        """Return the estimated errors of `in_modes`, as of `vsb.motion.coefficient_errors`."""
        found, own, transform = self.in_modes(basis, families), len(basis.labels), shares(self.displacements, basis)
        mass, damping, force = (self.interpolation * np.abs(values) for values in found)
        misfits = haskind_misfits(
            self.omega,
            transform @ self.coefficients.damping @ transform.T,
            found.damping[:, :own, :own],
            found.excitation[:, :own],
            water.depth,
            water.density,
            water.gravity,
        )
        mass[:, :own, :own], damping[:, :own, :own], force[:, :own] = misfits
        between = Coefficients(mass, damping, force.astype(complex))
        return [
            relative_error(RESOLUTION, found, self.resolution),
            CoefficientError(INTERPOLATION, between, signed=False),
        ]

    def _combined(self, transform: FloatArray) -> Coefficients:
        """Coefficients of combinations of the displacements, once for all materials that combine them alike."""
        if (key := transform.tobytes()) not in self._known:
            if len(self._known) == KEPT:
                self._known.clear()
            self._known[key] = self._transformed(transform)
        return self._known[key]

    def _transformed(self, transform: FloatArray) -> Coefficients:
        """Those of one combination, which radiate through one channel as a buoy's do."""
        added_mass, damping, excitation = self.coefficients
        force, lost = excitation @ transform.T, transform @ damping @ transform.T
        return Coefficients(transform @ added_mass @ transform.T, channelled(lost, force), force)


class InWaves(NamedTuple):
    """One design in waves of unit amplitude: what its take-off sees of it, and what moves with that."""

    port: Port
    motion: PortMotion
    moved: tuple[ComplexArray, ComplexArray]  # free, forced (omega, dof) [m/m], [m/N]

    def position(self, damping: float, stiffness: float) -> ComplexArray:
        """Return all degrees of freedom per wave amplitude under a damper and a spring, shape (omega, dof) [m/m]."""
        load = self.port.load(damping, stiffness)
        return self.moved[0] - (load * self.port.velocity_under(load))[:, None] * self.moved[1]


def designs_in_waves(
    study: Study, reference: ReferenceShell, water: ShapeWater, degree: int | None = None
) -> dict[str, InWaves]:
    """Return every design of a study in waves, without its take-off.

    Parameters
    ----------
    study : Study
    reference : ReferenceShell
    water : ShapeWater
    degree : int, optional
        Of a study in heave: higher shell modes of its basis are held.
    """
    basis, families = reference.basis, order_bases(study, reference.basis)
    seen, chamber = seen_by_take_off(study, reference)
    inertia, damping = (
        side_by_side(getattr(basis, name), *(getattr(each, name) for each in families))
        for name in ("inertia", "damping")
    )
    omega, stiffness = water.omega, whole_stiffness(study, seen)
    lossy, stiffer = viscous_parts(study, reference, omega) if study.device.damping.maxwell else (0.0, 0.0)
    equation = LinearEquation(
        omega, water.in_modes(basis, families), inertia, damping + lossy, stiffness, stiffer, chamber
    )
    direction, shapes = port_direction(study.pto.port, reference.shape, families), shell_shapes(basis, families)
    found = {}
    for design in study.designs:
        motions = design_motions(study, basis, design)
        if degree is not None:
            motions = motions_to_degree(study, basis, design, degree)
        moved = equation.free_motion(motions, direction)
        heave, shell = zip(*((one[:, 0], _of_shell(one, shapes)) for one in moved), strict=True)
        port = equation.port_of_motion(*moved, motions, direction)
        found[design] = InWaves(port, PortMotion(heave, shell), moved)
    return found


def _of_shell(amplitude: ComplexArray, shapes: FloatArray) -> ComplexArray:
    """Displacements of points of the shell, heave left out, (2, point, omega) [-], of amplitudes (omega, dof)."""
    count, *places = shapes[1:].shape
    parts = np.stack([amplitude.real, amplitude.imag])[:, :, 1:] @ shapes[1:].reshape(count, math.prod(places))
    return np.asarray((parts[0] + 1j * parts[1]).T.reshape(*places, len(amplitude)))


def shell_shapes(basis: ModeBasis, families: Sequence[OrderBasis] = ()) -> FloatArray:
    """Return displacements in both directions of points of a meridian, rigid motions none, (dof, 2, point) [-].

    With families of higher orders on both meridians in the plane of the waves, theta = 0 and pi.
    """
    at = np.linspace(0.0, np.pi, POINTS)
    axisymmetric = np.stack(basis.displacement(at), axis=1)
    if not families:
        return axisymmetric
    found = [np.concatenate([axisymmetric, axisymmetric], axis=2)]
    for each in families:
        one = np.stack(each.field(at)[:2], axis=1)
        one[: each.rigid] = 0.0
        found.append(np.concatenate([one, (-1) ** each.order * one], axis=2))
    return np.concatenate(found)


def design_ports(study: Study, reference: ReferenceShell, water: ShapeWater) -> dict[str, Port]:
    """Return what the damper of the take-off sees of every design, its spring built in."""
    waves = designs_in_waves(study, reference, water)
    return {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}
