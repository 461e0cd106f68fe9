"""A buoy from the coefficients of its shape, which studies of other materials share."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vsb.engine.hydro.database import Coefficients, shares
from vsb.engine.hydro.dofs import Displacement, displacements
from vsb.engine.hydro.orders import order_shares
from vsb.engine.motion.coefficient_errors import (
    INTERPOLATION,
    RESOLVED,
    CoefficientError,
    combined,
    haskind_misfits,
    relative_error,
)
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.linear import LinearSystem, channelled
from vsb.engine.motion.port import port_direction
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.orders import OrderBasis
from vsb.engine.waves.water import Water
from vsb.models.floating_system import AtFrequencies
from vsb.models.rest import (
    design_motions,
    motions_to_degree,
    order_bases,
    seen_by_take_off,
    side_by_side,
    viscous_parts,
    whole_stiffness,
)
from vsb.models.ring_loads import with_rings
from vsb.study.specs import AnyBuoy
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

POINTS = 13
"""Points of the meridian the shell's motion is given at, both poles and the equator among them."""
KEPT = 32
"""Combinations of displacements whose coefficients are kept: as many thicknesses as a sweep may well have."""
BUOYS = 4
"""Buoys that are kept in the water of a shape: with the modes of a study, and with more of them."""
GRIDS = 3
"""Sets of frequencies whose coefficients are kept: of a climate, and two of the harmonics of an optimum."""
OF_BUOY = {"device", "modes", "reference_shape", "designs", "water", "motion", "mooring"}
"""Sections of a study that its buoy follows from, without what its take-off does."""
OF_PORT = {"port", "held"}
"""Keys of a take-off by which it sees the buoy."""
STATED = ("error_estimate", "interpolation_error")
"""Errors that blocks estimate of themselves."""


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
    _errors: dict[Any, list[CoefficientError]] = field(default_factory=dict, repr=False, compare=False)  # the last ones
    _buoys: dict[str, AtFrequencies] = field(default_factory=dict, repr=False, compare=False)  # the last few

    def in_modes(self, basis: ModeBasis, families: Sequence[OrderBasis] = ()) -> Coefficients:
        """Return the coefficients of heave and modes, and of families of higher orders, each of one channel."""
        own = self._combined(shares(self.displacements, basis))
        return Coefficients.side_by_side([own, *(self._of_family(each) for each in families)])

    def buoy_of(self, key: str, made: Callable[[], AtFrequencies]) -> AtFrequencies:
        """Return the buoy in this water that a key stands for, made if it is none of the last few."""
        if key not in self._buoys:
            if len(self._buoys) == BUOYS:
                del self._buoys[next(iter(self._buoys))]
            self._buoys[key] = made()
        return self._buoys[key]

    def _of_family(self, family: OrderBasis) -> Coefficients:
        """Coefficients of one family of higher orders; of yaw, of order 0, which moves no water, none."""
        if not family.order:
            still = np.zeros((len(self.omega), 1, 1))
            return Coefficients(still, still, still[..., 0].astype(complex))
        water = self.orders[family.order - 1]
        return water._combined(order_shares(water.displacements, family))

    def errors(self, basis: ModeBasis, families: Sequence[OrderBasis], water: Water) -> list[CoefficientError]:
        """Return the estimated errors of `in_modes`, as of `vsb.engine.motion.coefficient_errors`, added up."""
        transform = shares(self.displacements, basis)
        if (key := (transform.tobytes(), *families, water)) not in self._errors:
            self._errors.clear()
            self._errors[key] = combined(self._estimated(transform, self.in_modes(basis, families), water))
        return self._errors[key]

    def _estimated(self, transform: FloatArray, found: Coefficients, water: Water) -> list[CoefficientError]:
        """Errors by source of the coefficients of combinations of the displacements, and of families."""
        own = len(transform)
        mass, damping, force = (self.interpolation * np.abs(values) for values in found)
        mass[:, :own, :own], damping[:, :own, :own], force[:, :own] = haskind_misfits(
            self.omega,
            transform @ self.coefficients.damping @ transform.T,
            found.damping[:, :own, :own],
            found.excitation[:, :own],
            water.depth,
            water.density,
            water.gravity,
        )
        between = Coefficients(mass, damping, force.astype(complex))
        return [
            relative_error(RESOLVED, found, self.resolution),
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


@dataclass(frozen=True)
class SweptShape:
    """A shape whose coefficients are solved, to be had at any frequencies of the band."""

    buoys: tuple[LinearSystem, ...]  # in displacements, of azimuthal orders 0, 1, ...
    _known: dict[bytes, ShapeWater] = field(default_factory=dict, repr=False, compare=False)  # the last few

    def at(self, omega: FloatArray) -> ShapeWater:
        """Return the coefficients at frequencies; outside the band those of its nearest end."""
        if (key := omega.tobytes()) not in self._known:
            if len(self._known) == GRIDS:
                del self._known[next(iter(self._known))]
            self._known[key] = self._at(omega)
        return self._known[key]

    def _at(self, omega: FloatArray) -> ShapeWater:
        """The coefficients at frequencies."""
        known = np.clip(omega, *self.band)
        first, *others = (
            ShapeWater(displacements(buoy.labels, order), omega, buoy.coefficients(known))
            for order, buoy in enumerate(self.buoys)
        )
        attrs = [buoy.database.attrs for buoy in self.buoys]
        resolution, interpolation = (max(float(each.get(name, 0.0)) for each in attrs) for name in STATED)
        return replace(first, orders=tuple(others), resolution=resolution, interpolation=interpolation)

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency solved [rad/s]."""
        first, last = self.buoys[0].database.omega.values[[0, -1]]
        return float(first), float(last)


@dataclass(frozen=True)
class BuoyOfShape:
    """The buoy of a study at rest in the coefficients of its shape, which studies of other materials share."""

    study: Study
    reference: ReferenceShell
    swept: SweptShape

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency solved [rad/s]."""
        return self.swept.band

    @property
    def moving(self) -> ReferenceShell:
        """Its shell at rest with all degrees of freedom it moves in: also the modes of rings that are loaded."""
        return with_rings(self.study, self.reference)

    def at(self, omega: FloatArray) -> AtFrequencies:
        """Return it at frequencies; outside the band with the coefficients of its nearest end.

        Kept for members of a campaign that differ by what their take-off does alone.
        """
        return kept_buoy(self.study, self.reference, self.swept.at(omega))

    def errors(self, omega: FloatArray) -> list[CoefficientError]:
        """Return the estimated errors of its coefficients at frequencies."""
        basis = self.moving.basis
        return self.swept.at(omega).errors(basis, order_bases(self.study, basis), self.study.water)


def kept_buoy(study: AnyBuoy, reference: ReferenceShell, water: ShapeWater) -> AtFrequencies:
    """Return the same as `buoy_at`, kept for studies that differ by what their take-off does alone."""
    parts = study.model_dump_json(include=OF_BUOY), study.pto.model_dump_json(include=OF_PORT)
    return water.buoy_of(" ".join(parts), lambda: buoy_at(study, reference, water))


def buoy_at(study: AnyBuoy, reference: ReferenceShell, water: ShapeWater, degree: int | None = None) -> AtFrequencies:
    """Return the buoy of a study at the frequencies of the coefficients of its shape.

    Parameters
    ----------
    study : Study or BuoySystem
    reference : ReferenceShell
    water : ShapeWater
    degree : int, optional
        Of a study in heave: higher shell modes of its basis are held, but for what they do under loads at rings.
    """
    reference = with_rings(study, reference, degree)
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
    motions = {design: design_motions(study, basis, design) for design in study.designs}
    if degree is not None:
        motions = {design: motions_to_degree(study, basis, design, degree) for design in study.designs}
    port = port_direction(study.pto.port, reference.shape, families)
    return AtFrequencies(equation, motions, port, shell_shapes(basis, families))


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
