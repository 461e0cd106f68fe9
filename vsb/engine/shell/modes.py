"""Rayleigh-Ritz basis of the shell: mode shapes, modal mass, stiffness and damping, clamps.

Every shape of the sphere is one Legendre degree n: radial displacement v = V P_n(cos phi), meridional u = U dP_n/dphi.
Rigid heave is the shape n = 1, V = U = 1. Degrees are orthogonal, so mass and energy are closed-form 2 x 2 blocks per
degree. On another meridian each natural mode has all degrees, and both come from quadrature (`vsb.engine.shell.ritz`).
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import block_diag, eigh, svd
from scipy.optimize import minimize_scalar

from vsb.engine.shell.device import Basis, Device
from vsb.engine.shell.rings import AttachmentModes, RingModes
from vsb.engine.shell.ritz import (
    Strains,
    bending_block,
    legendre,
    mass_block,
    matrices,
    membrane_block,
    natural_modes,
    of_degrees,
    strains,
)
from vsb.engine.shell.shell import Shell, frequency_parameter
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray

POINTS = 20
"""Points of a half wave among which its largest displacement is sought."""


@dataclass(frozen=True)
class Mode:
    """One shape: v = radial P_n, u = meridional dP_n/dphi, scaled to max|displacement| = 1 (C5)."""

    label: str
    degree: int
    radial: float
    meridional: float
    others: tuple[tuple[int, float, float], ...] = ()  # degrees, radial and meridional, beside; on other meridians

    @property
    def parts(self) -> tuple[tuple[int, float, float], ...]:
        """Degree, radial and meridional amplitude of all parts."""
        return ((self.degree, self.radial, self.meridional), *self.others)


def scaled(label: str, degree: int, radial: float, meridional: float) -> Mode:
    """Return a shape of one degree scaled to max|displacement| = 1, radial at the top pole positive.

    The largest displacement is at the pole or about the first extremum of dP_n/dphi: P_n^2 + (dP_n/dphi)^2/n(n+1) falls
    from the pole to the equator.
    """

    def displacement(phi: FloatArray) -> FloatArray:
        p, dp, _ = legendre(degree, np.atleast_1d(phi))
        return np.asarray(np.hypot(radial * p[degree], meridional * dp[degree]))

    beside_pole = np.linspace(0.0, np.pi / (degree + 0.5), POINTS + 1)
    largest = largest_along(displacement, beside_pole, displacement(beside_pole))
    scale = np.copysign(1.0, radial) / largest
    return Mode(label, degree, radial * scale, meridional * scale)


def largest_along(displacement: Callable[[FloatArray], FloatArray], grid: FloatArray, there: FloatArray) -> float:
    """Return the largest displacement along the meridian from that at points, `POINTS` or more a half wave."""
    peak, step = grid[np.argmax(there)], grid[1] - grid[0]
    refined = minimize_scalar(
        lambda phi: -float(displacement(phi)[0]), bounds=(peak - step, peak + step), options={"xatol": 1e-12}
    )
    return max(-float(refined.fun), float(np.max(there)))


def natural_shapes(shell: Shell, degree: int) -> tuple[Mode, ...]:
    """Return the natural modes of a shell of another meridian, by ascending frequency, from `Shell1` on.

    Each is scaled to max|displacement| = 1, with the largest radial amplitude at a pole positive.
    """
    highest = max(1, degree)
    shapes = natural_modes(shell, highest).shapes
    radial, meridional = shapes[: highest + 1].T, np.pad(shapes[highest + 1 :].T, ((0, 0), (1, 0)))
    grid = np.linspace(0.0, np.pi, POINTS * highest + 3)
    p, dp, _ = legendre(highest, grid)
    there = np.hypot(radial @ p, meridional @ dp)
    rows = enumerate(zip(radial, meridional, there, strict=True), 1)
    return tuple(_natural_shape(f"Shell{i}", v, u, grid, row) for i, (v, u, row) in rows)


def _natural_shape(label: str, radial: FloatArray, meridional: FloatArray, grid: FloatArray, there: FloatArray) -> Mode:
    """A mode of all degrees, scaled, from its amplitudes by degree and its displacement at points."""
    highest = len(radial) - 1

    def displacement(phi: FloatArray) -> FloatArray:
        p, dp, _ = legendre(highest, np.atleast_1d(phi))
        return np.asarray(np.hypot(radial @ p, meridional @ dp))

    largest = largest_along(displacement, grid, there)
    at_poles = np.array([radial.sum(), radial @ (-1.0) ** np.arange(highest + 1)])
    scale = np.copysign(1.0, at_poles[0] if abs(at_poles[0]) > 1e-6 * largest else at_poles[1]) / largest
    parts = [(n, scale * float(v), scale * float(u)) for n, (v, u) in enumerate(zip(radial, meridional, strict=True))]
    leading = max(parts, key=lambda part: math.hypot(part[1], math.sqrt(part[0] * (part[0] + 1)) * part[2]))
    return Mode(label, *leading, tuple(part for part in parts if part is not leading))


HEAVE = "Heave"
SAME = 1e-12
"""Singular values of the constraint below this, relative to the largest, are zero: repeated clamps, poles [-]."""
DISTINCT = 1e-8
"""Singular values above this are independent constraints; their direction then keeps eight digits [-]."""


def mass_of(shell: Shell, shapes: Iterable[Mode]) -> FloatArray:
    """Return the mass of the shell over shapes of one degree each, shape (shape, shape) [kg]."""
    return _assembled(lambda degree: mass_block(shell, degree), shapes)


def stiffness_of(shell: Shell, shapes: Iterable[Mode], *, bending: bool) -> FloatArray:
    """Return the elastic stiffness over shapes of one degree each, shape (shape, shape) [N/m]."""
    if not bending:
        return _assembled(lambda degree: membrane_block(shell, degree), shapes)
    return _assembled(lambda degree: membrane_block(shell, degree) + bending_block(shell, degree), shapes)


def _assembled(block: Callable[[IntArray], FloatArray], shapes: Iterable[Mode]) -> FloatArray:
    """Matrix of a quadratic form that couples equal degrees only, from its (V, U) blocks of degrees."""
    degrees, radial, meridional = zip(*((mode.degree, mode.radial, mode.meridional) for mode in shapes), strict=True)
    vectors = np.column_stack([radial, meridional])
    forces = np.einsum("si,sij->sj", vectors, block(np.array(degrees)))
    return np.where(np.equal.outer(degrees, degrees), forces @ vectors.T, 0.0)


@dataclass(frozen=True)
class ModeBasis:
    """Shapes of a study and their structural matrices; heave first, then the shell modes."""

    shell: Shell
    modes: tuple[Mode, ...]
    total_mass: float  # [kg]
    bending: bool  # whether the energy of bending is part of the stiffness
    alpha: float = 0.0  # mass-proportional damping [1/s]
    beta: float = 0.0  # stiffness-proportional damping [s]
    rings: AttachmentModes | None = None  # what higher degrees do under loads at rings
    order_rings: tuple[RingModes, ...] = ()  # the same of azimuthal orders 1, 2, ..., see `vsb.engine.shell.orders`

    @cached_property
    def shapes(self) -> tuple[Mode, ...]:
        """Rigid heave and the shell modes; those of rings are too short to be seen in the shape or by the water."""
        rings = self.rings.labels if self.rings else ()
        return (Mode(HEAVE, 1, 1.0, 1.0), *self.modes, *(Mode(label, 0, 0.0, 0.0) for label in rings))

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return tuple(mode.label for mode in self.shapes)

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """Legendre degree of each degree of freedom."""
        return tuple(mode.degree for mode in self.shapes)

    @cached_property
    def highest_degree(self) -> int:
        """Highest Legendre degree of the basis."""
        return max(degree for mode in self.shapes for degree, _, _ in mode.parts)

    @property
    def turns(self) -> int:
        """Highest degree of the deformed meridian: the shapes' and, other than for the sphere, its own."""
        return self.highest_degree + (self.shell.rest.terms - 2 if self.shell.rest else 0)

    @cached_property
    def pole_radial_displacement(self) -> FloatArray:
        """Radial displacement at the top pole per unit amplitude, shape (dof,) [-]: P_n(1) = 1."""
        return np.array([sum(radial for _, radial, _ in mode.parts) for mode in self.shapes])

    @cached_property
    def shares(self) -> FloatArray:
        """Radial and meridional amplitude of each degree in each shape, shape (2, dof, degree) [-]."""
        found = np.zeros((2, len(self.shapes), self.highest_degree + 1))
        for i, mode in enumerate(self.shapes):
            for degree, radial, meridional in mode.parts:
                found[:, i, degree] = radial, meridional
        return found

    @cached_property
    def displacements(self) -> FloatArray:
        """Each shape in terms of the displacements of `vsb.engine.shell.ritz`, shape (dof, displacement) [-]."""
        radial, meridional = self.shares
        return np.hstack([radial, meridional[:, 1:]])

    def integrated(self, *names: str) -> FloatArray:
        """Return the sum of matrices of `vsb.engine.shell.ritz` over the shapes, (dof, dof) [kg], [N/m]."""
        shapes, found = self.displacements, matrices(self.shell, self.highest_degree)
        return np.asarray(sum(shapes @ getattr(found, name) @ shapes.T for name in names))

    @cached_property
    def inertia(self) -> FloatArray:
        """Mass of ballast and shell over heave and modes, shape (dof, dof) [kg].

        Heave carries the whole buoy. A mode couples to heave only through degree 1, and there only if it is not
        orthogonal to rigid heave, as the paper's slipped n = 1 shape is not.
        """
        if self.shell.rest is None:
            matrix = mass_of(self.shell, self.shapes)
        else:
            matrix = self.integrated("mass")
            matrix[0, 1:] = matrix[1:, 0] = 0.0  # exact: natural modes are orthogonal to rigid heave
        matrix = matrix.astype(np.result_type(matrix, self.total_mass))
        matrix[0, 0] = self.total_mass
        if self.rings:
            matrix += self.of_rings(self.rings.inertia)
        return matrix

    @cached_property
    def stiffness(self) -> FloatArray:
        """Elastic stiffness over heave and modes, shape (dof, dof) [N/m]; zero for rigid heave."""
        if self.shell.rest is None:
            matrix = stiffness_of(self.shell, self.shapes, bending=self.bending)
        else:
            matrix = self.integrated("membrane", *(["bending"] if self.bending else []))
        matrix[0, :] = matrix[:, 0] = 0.0  # exact: rigid motion strains nothing
        if self.rings:
            matrix += self.of_rings(self.rings.stiffness)
        return matrix

    def of_rings(self, matrix: FloatArray) -> FloatArray:
        """Return a matrix over the modes of rings as one over all degrees of freedom, shape (dof, dof)."""
        return np.pad(matrix, (len(self.labels) - len(matrix), 0))

    @property
    def damping(self) -> FloatArray:
        """Rayleigh damping alpha M + beta K of the shell modes, shape (dof, dof) [kg/s]; none for rigid heave."""
        matrix = self.alpha * self.inertia + self.beta * self.stiffness
        matrix[0, :] = matrix[:, 0] = 0.0
        return matrix

    @cached_property
    def dry_frequencies(self) -> FloatArray:
        """Rayleigh quotient of each shell mode, shape (mode,) [rad/s]."""
        return np.sqrt(np.diag(self.stiffness)[1:] / np.diag(self.inertia)[1:])

    def displacement(self, colatitude: FloatArray, derivative: int = 0) -> tuple[FloatArray, FloatArray]:
        """Return radial and meridional shapes at points, or their derivative by colatitude (0 or 1).

        Returns
        -------
        radial, meridional : ndarray, shape (dof, point) [-]
        """
        radial, meridional, *slopes = self.displacement_and_slope(colatitude)
        return (slopes[0], slopes[1]) if derivative else (radial, meridional)

    def displacement_and_slope(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return radial and meridional shapes at points, then their slopes by colatitude, each (dof, point) [-]."""
        tables = legendre(self.highest_degree, colatitude)
        if self.shell.rest is not None or any(mode.others for mode in self.modes):
            (radial, meridional), (p, dp, ddp) = self.shares, tables
            return radial @ p, meridional @ dp, radial @ dp, meridional @ ddp
        p, dp, ddp = (table[list(self.degrees)] for table in tables)
        radial, meridional = self.amplitudes
        return radial * p, meridional * dp, radial * dp, meridional * ddp

    @cached_property
    def amplitudes(self) -> FloatArray:
        """Radial and meridional amplitude of each shape, shape (2, dof, 1) [-]."""
        return np.array([[mode.radial, mode.meridional] for mode in self.shapes]).T[:, :, None]

    def meridian_strains(self, colatitude: FloatArray) -> Strains:
        """Return the strains of the displacements of `vsb.engine.shell.ritz` between the poles of another meridian."""
        assert self.shell.rest is not None
        return strains(self.shell.rest, colatitude, of_degrees(self.highest_degree, colatitude))

    def clamp_rows(self, colatitudes: Iterable[float]) -> FloatArray:
        """Return the constraint matrix Phi_c with Phi_c q = 0, shape (2 * clamp, dof) [-].

        Notes
        -----
        The shell does not move relative to the sphere centre at the clamped colatitudes [rad]: one radial and one
        meridional row each, the heave column zero. At a pole the meridional row is zero by symmetry.
        """
        rows = np.concatenate([part.T for part in self.ring_displacement(np.asarray(list(colatitudes), dtype=float))])
        rows[:, 0] = 0.0
        return rows

    def ring_displacement(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return radial and meridional displacements of rings, those by the modes of rings too, each (dof, point) [-].

        Parameters
        ----------
        colatitude : ndarray, shape (point,) [rad]
        """
        radial, meridional = self.displacement(colatitude)
        if self.rings is None:
            return radial, meridional
        others, (v, u, _) = len(radial) - len(self.rings.labels), self.rings.displacement(colatitude)
        return np.concatenate([radial[:others], v]), np.concatenate([meridional[:others], u])

    def clamped(self, colatitudes: Iterable[float]) -> FloatArray:
        """Return an orthonormal basis of the motions the clamps allow, shape (dof, free); heave is the first column.

        Notes
        -----
        Null space of `clamp_rows` by singular values: repeated and zero rows are harmless. With q = N y the constraint
        holds at all times by construction: no multipliers, no drift. Not to be written to.
        """
        return _allowed(self.immaterial, tuple(colatitudes))

    @cached_property
    def immaterial(self) -> "ModeBasis":
        """The same shapes of a dummy material: quantities that depend on shapes alone are cached by this basis."""
        shell = replace(self.shell, thickness=1e-9 * self.shell.radius)
        return replace(self, shell=shell.of_unit_material, total_mass=1.0, alpha=0.0, beta=0.0)


@lru_cache(maxsize=64)
def _allowed(basis: ModeBasis, colatitudes: tuple[float, ...]) -> FloatArray:
    """The motions clamps allow."""
    free = np.asarray(block_diag(np.eye(1), null_space(basis.clamp_rows(colatitudes)[:, 1:])))
    free.setflags(write=False)
    return free


def null_space(rows: FloatArray) -> FloatArray:
    """Return an orthonormal basis of what constraints allow, shape (dof, free); raises as of `check_rank`."""
    _, _, vt = svd(rows, full_matrices=True)
    return np.asarray(vt[check_rank(rows) :].T)


def check_rank(rows: FloatArray) -> int:
    """Return the number of independent constraints among the rows.

    Raises `ConfigError` if a singular value lies between `SAME` and `DISTINCT` of the largest: clamps so close that
    round-off decides whether they are one or two.

    Parameters
    ----------
    rows : ndarray, shape (constraint, dof) [-]
        Phi, from `ModeBasis.clamp_rows`; repeated and zero rows are harmless.

    Notes
    -----
    Two clamps d apart [rad] leave a smallest singular value of the order of d, down to 0.1 d for one mode per degree.
    Clamps on the same spot leave 1e-14 or less, up to degree 80.
    """
    singular = svd(rows, compute_uv=False) if rows.size else np.zeros(0)
    relative = singular / (singular.max(initial=0.0) or 1.0)
    if (doubtful := relative[(relative > SAME) & (relative < DISTINCT)]).size:
        raise ConfigError(
            f"clamp: received clamps closer than the basis resolves "
            f"(relative singular value {doubtful.max():.1e}; needs more than {DISTINCT:g}, or less than {SAME:g} for "
            f"the same clamp twice); move them apart, drop one, or raise modes.degree"
        )
    return int(np.sum(relative >= DISTINCT))


def constraint_drift(positions: FloatArray, rows: FloatArray) -> float:
    """Return the largest displacement of a clamped point, max |Phi q| over time and rows [m]; exact motion has none.

    Parameters
    ----------
    positions : ndarray, shape (time, dof) [m]
        Heave and all modal amplitudes.
    rows : ndarray, shape (constraint, dof) [-]
    """
    return float(np.abs(positions @ rows.T).max(initial=0.0))


def paper_ratio(shell: Shell, degree: int) -> float:
    """Return the paper's amplitude ratio V/U, C_n = (1 + (1+nu) Omega^4)/(1 - Omega^4).

    The right ratio is (1 + (1+nu) Omega^2)/(1 - Omega^2): Omega^2 was squared once too often. With the slip, and
    Omega that of the membrane alone (h -> 0), the Rayleigh quotient gives the paper's Table I, "Rayleigh-Ritz" column,
    to 7e-12; with Omega of the bending shell to 4e-8 only; without the slip the true frequency.
    """
    membrane = replace(shell, thickness=1e-9 * shell.radius)
    omega4 = frequency_parameter(membrane, degree)[1] ** 2
    return (1 + (1 + shell.poisson_ratio) * omega4) / (1 - omega4)


@lru_cache(maxsize=1024)
def _degree_modes(shell: Shell, basis: Basis, degree: int) -> tuple[Mode, ...]:
    """Shell modes of one degree in a basis."""
    if degree == 0:
        return (Mode("Membrane0", 0, 1.0, 0.0),)
    if basis == "paper":
        return (scaled(f"Membrane{degree}", degree, paper_ratio(shell, degree), 1.0),)
    stiffness = membrane_block(shell, degree) + bending_block(shell, degree)
    lower, upper = eigh(stiffness, mass_block(shell, degree))[1].T  # (V, U) of both branches of the complete shell
    membrane = scaled(f"Membrane{degree}", degree, *upper)
    if basis == "membrane" or degree == 1:  # the lower branch of n = 1 is rigid heave (C4)
        return (membrane,)
    return (membrane, scaled(f"Bending{degree}", degree, *lower))


def mode_basis(device: Device, basis: Basis, degree: int) -> ModeBasis:
    """Return the Ritz basis of a device.

    Parameters
    ----------
    basis : {"paper", "membrane", "full"}
        One slipped shape per degree and membrane energy (the publication); the upper branch; both branches.
    degree : int
        Highest Legendre degree.
    """
    shell, damping = Shell.of(device), device.damping
    modes = shell_modes(shell, basis, degree)
    return ModeBasis(shell, modes, device.mass, basis != "paper", damping.alpha, damping.beta)


def shell_modes(shell: Shell, basis: Basis, degree: int) -> tuple[Mode, ...]:
    """Return the shapes of a shell, all membrane modes, then all bending modes, whatever its stiffness and density.

    Mass and stiffness scale with these, so shapes follow from Poisson's ratio and thickness over radius alone.
    """
    return _shapes(shell.of_unit_material, basis, degree)


@lru_cache(maxsize=64)
def _shapes(shell: Shell, basis: Basis, degree: int) -> tuple[Mode, ...]:
    """The same, once for all materials."""
    if shell.rest is not None:
        if basis != "full":
            raise ConfigError(
                f"modes.basis: received {basis!r}, but on another shape than the sphere modes have no branches; needs "
                "full"
            )
        return natural_shapes(shell, degree)
    modes = [mode for n in range(degree + 1) for mode in _degree_modes(shell, basis, n)]
    return tuple(sorted(modes, key=lambda mode: mode.label.startswith("Bending")))


def rigid_basis(device: Device) -> ModeBasis:
    """Return the basis of a study without a flexible design: heave alone."""
    return ModeBasis(Shell.of(device), (), device.mass, bending=False)


def strain_shapes(basis: ModeBasis, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return linear meridional and hoop strain and rotation per unit amplitude, each shape (dof, point) [1/m].

    e_phi = (u' + v)/r, e_theta = (u cot phi + v)/r, beta = (v' - u)/r. By Legendre's equation
    u cot phi = -n(n+1) U P_n - u', which holds at the poles too and makes all three exactly zero for rigid heave. On
    another meridian, between its poles, those of `vsb.engine.shell.ritz`.
    """
    if basis.shell.rest is not None:
        found, shapes = basis.meridian_strains(colatitude), basis.displacements
        return shapes @ found.meridional, shapes @ found.hoop, shapes @ found.rotation
    p, dp, ddp = (table[list(basis.degrees)] for table in legendre(basis.highest_degree, colatitude))
    radial, meridional = basis.amplitudes
    n, r = np.array(basis.degrees)[:, None], basis.shell.radius
    hoop = (radial - n * (n + 1) * meridional) * p - meridional * ddp
    return (radial * p + meridional * ddp) / r, hoop / r, (radial - meridional) * dp / r


def curvature_shapes(basis: ModeBasis, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return meridional and hoop changes of curvature per unit amplitude, each shape (dof, point) [1/m^2].

    kappa_phi = -(v'' - u')/r^2, kappa_theta = -cot phi (v' - u)/r^2 = (n(n+1) P_n + P_n'') (V - U)/r^2 of a degree. On
    another meridian, between its poles, those of `vsb.engine.shell.ritz`.
    """
    if basis.shell.rest is not None:
        found, shapes = basis.meridian_strains(colatitude), basis.displacements
        return shapes @ found.meridional_bending, shapes @ found.hoop_bending
    p, _, ddp = (table[list(basis.degrees)] for table in legendre(basis.highest_degree, colatitude))
    n, r = np.array(basis.degrees)[:, None], basis.shell.radius
    turned = np.subtract(*basis.amplitudes) / r**2
    return -turned * ddp, turned * (n * (n + 1) * p + ddp)
