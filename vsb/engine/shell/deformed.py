"""The deformed shell in water: waterline, wet quadrature, volume, area, hydrostatic force and its exact Jacobian."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from vsb.engine.shell.meridian import (
    ArcMeridian,
    Curve,
    RestMeridian,
    arc_chord,
    gauss_rule,
    length,
    meridian_rule,
    parts,
)
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.ritz import polynomials, slopes_of_polynomials
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray


class Meridian(NamedTuple):
    """Points of a deformed meridian: radius x and height z [m], their derivatives by colatitude, the shapes there."""

    x: FloatArray  # (point,)
    z: FloatArray
    dx: FloatArray
    dz: FloatArray
    shape_x: FloatArray  # (dof, point), horizontal displacement per unit amplitude
    shape_z: FloatArray
    dshape_x: FloatArray
    dshape_z: FloatArray


_SHAPES = Meridian._fields[4:]
_FINER = 15
"""Subdivisions of the grid for finding curls."""
AT_ONCE = 512
"""Points at which shapes are tabulated at a time: for thousands of shapes some 100 MB."""
TABLE = 200_000
"""Entries of a table of Legendre polynomials that is kept at most."""


def _parts(points: FloatArray) -> list[FloatArray]:
    """Points in parts of at most `AT_ONCE`, at least one."""
    return np.array_split(points, max(1, -(-len(points) // AT_ONCE)))


def _grid(turns: int) -> FloatArray:
    """Colatitudes that resolve the highest degree of a meridian, pole to pole, shape (point,) [rad]."""
    return np.linspace(0.0, np.pi, 40 * (turns + 1) + 1)


@lru_cache(maxsize=4)
def _rest_on_grid(shell: Shell, turns: int, degree: int) -> tuple[Curve, FloatArray]:
    """The meridian at rest and Legendre polynomials on the grid, of all shapes of a shell: not to be written to."""
    grid = _grid(turns)
    found = shell.at_rest(grid), polynomials(np.cos(grid), degree)
    for values in (*found[0], found[1]):
        values.setflags(write=False)
    return found


@dataclass(frozen=True)
class DeformedShell:
    """A shell displaced by heave and modal amplitudes, in still water."""

    basis: ModeBasis
    centre_height: float  # height of the sphere centre above still water at zero heave [m]
    modal_amplitude: FloatArray = field(default_factory=lambda: np.zeros(0))  # heave and modes (dof,) [m]; empty: zero

    def __post_init__(self) -> None:
        """An undeformed shell has amplitudes of zero."""
        if not self.modal_amplitude.size:
            object.__setattr__(self, "modal_amplitude", np.zeros(len(self.basis.labels)))

    def meridian(self, colatitude: FloatArray) -> Meridian:
        """Return x = (r+v) sin + u cos, z = centre + (r+v) cos - u sin at colatitudes, shape (point,) [rad].

        On another meridian than the sphere's x and z at rest take the place of r sin and r cos.
        """
        at, sin, cos = self.basis.shell.at_rest(colatitude), np.sin(colatitude), np.cos(colatitude)
        v, u, dv, du = self.basis.displacement_and_slope(colatitude)
        shape_x, shape_z = v * sin + u * cos, v * cos - u * sin
        dshape_x, dshape_z = dv * sin + v * cos + du * cos - u * sin, dv * cos - v * sin - du * sin - u * cos
        q = self.modal_amplitude
        return Meridian(
            at.x + q @ shape_x,
            self.centre_height + at.z + q @ shape_z,
            at.dx + q @ dshape_x,
            at.dz + q @ dshape_z,
            shape_x,
            shape_z,
            dshape_x,
            dshape_z,
        )

    def strain_gradients(self, upper: float, lower: float) -> tuple[FloatArray, FloatArray, float]:
        """Return the derivatives of the mean strains between two colatitudes [rad] by the amplitudes, and the area.

        Returns
        -------
        hoop, meridional : ndarray, shape (dof,) [1/m]
            Means over the surface of x_j/x and (x' x_j' + z' z_j')/s^2, s^2 = x'^2 + z'^2, strains of this shape.
        area : float [m^2]
            Its derivative by the amplitudes is area times the sum of both.
        """
        phi, weight = self._rule(4 * self.basis.turns + 24, [(upper, lower)])
        m = self.meridian(phi)
        weight, arc = 2 * np.pi * weight, length(m.dx, m.dz)
        area: float = np.dot(weight, m.x * arc)
        hoop: FloatArray = m.shape_x @ (weight * arc) / area
        along: FloatArray = (m.dshape_x * m.dx + m.dshape_z * m.dz) @ (weight * m.x / arc) / area
        if rings := self.basis.rings:
            others, strains = len(hoop) - len(rings.labels), rings.mean_strains(upper, lower)
            hoop, along = (np.concatenate(pair) for pair in zip((hoop[:others], along[:others]), strains, strict=True))
        return hoop, along, area

    @cached_property
    def _series(self) -> FloatArray:
        """Legendre coefficients in cos(phi) of v and v', and of W' and W'', where u = dW/dphi = -sin(phi) W'.

        Shape (4, degree), zero where a derivative has fewer.
        """
        radial, meridional = self.modal_amplitude @ self.basis.shares
        slopes = slopes_of_polynomials(len(radial) - 1)
        first = meridional @ slopes
        return np.array([radial, radial @ slopes, first, first @ slopes])

    def curve(self, colatitude: FloatArray) -> Curve:
        """Return `meridian` without the shapes of the modes: one sum over degrees for any number of modes."""
        return self._displaced(colatitude, self.basis.shell.at_rest(colatitude))

    def _displaced(self, colatitude: FloatArray, at: Curve, p: FloatArray | None = None) -> Curve:
        """The same from the meridian at rest there, and the Legendre polynomials p, if known."""
        if not self.modal_amplitude.any():
            return at._replace(z=self.centre_height + at.z)
        sin, cos = np.sin(colatitude), np.cos(colatitude)
        v, slope, first, second = self._series @ (polynomials(cos, self.basis.highest_degree) if p is None else p)
        u, dv, du = -sin * first, -sin * slope, sin**2 * second - cos * first
        return Curve(
            at.x + v * sin + u * cos,
            self.centre_height + at.z + v * cos - u * sin,
            at.dx + dv * sin + v * cos + du * cos - u * sin,
            at.dz + dv * cos - v * sin - du * sin - u * cos,
        )

    def chord(self, start: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the vectors from colatitudes to those that lie an offset further, each shape (point,) [m].

        By products, as sin(k b) - sin(k a) = 2 cos(k (a + b)/2) sin(k (b - a)/2): a difference of coordinates of near
        points would be all round-off.
        """
        radial, axial = self._terms
        half = offset / 2
        middle, turned = (_powers(np.exp(1j * angle), len(radial)) for angle in (start + half, half))
        across, up = 2 * radial @ (middle.real * turned.imag), -2 * axial @ (middle.imag * turned.imag)
        rest = self.basis.shell.meridian
        if isinstance(rest, ArcMeridian):
            further, down = _chord_of_arcs(rest, start, offset)
            return np.asarray(across + further), np.asarray(up - down)
        return np.asarray(across), np.asarray(up)

    @cached_property
    def _terms(self) -> tuple[FloatArray, FloatArray]:
        """Terms of x = sum a_k sin(k phi) and z = sum b_k cos(k phi), k = 0, 1, ..., each shape (term,) [m].

        Those of the displacement by the discrete orthogonality of sines and cosines at midpoints, and those of a smooth
        meridian at rest.
        """
        rest, displaced = self.basis.shell.meridian, self.basis.highest_degree + 2
        phi = np.pi * (np.arange(displaced) + 0.5) / displaced
        angles, m = np.outer(np.arange(displaced), phi), self.meridian(phi)
        x, z = self.modal_amplitude @ m.shape_x, self.centre_height + self.modal_amplitude @ m.shape_z
        of_radius, of_height = (rest.radial, rest.axial) if isinstance(rest, RestMeridian) else ((), ())
        radial, axial = np.zeros((2, max(displaced, len(of_radius) + 1, len(of_height))))
        radial[:displaced], axial[:displaced] = 2 / displaced * np.sin(angles) @ x, 2 / displaced * np.cos(angles) @ z
        axial[0] /= 2
        radial[1 : len(of_radius) + 1] += of_radius
        axial[: len(of_height)] += of_height
        return radial, axial

    @property
    def _grid(self) -> FloatArray:
        """Colatitudes that resolve the highest degree, pole to pole, shape (point,) [rad]."""
        return _grid(self.basis.turns)

    @cached_property
    def _on_grid(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Radius, height and slope dx/dphi of the meridian there."""
        grid, degree = self._grid, self.basis.highest_degree
        if len(grid) * degree <= TABLE:
            return self._displaced(grid, *_rest_on_grid(self.basis.shell, self.basis.turns, degree))[:3]
        x, z, dx = zip(*(self.curve(part)[:3] for part in _parts(grid)), strict=True)
        return np.concatenate(x), np.concatenate(z), np.concatenate(dx)

    @cached_property
    def waterline(self) -> float:
        """Colatitude of the one waterline of a surface that can float [rad].

        Raises
        ------
        ConfigError
            If the meridian crosses the axis or itself, or there is not one waterline with the keel below it.
        """
        check_meridian(self)
        wet = self.wet_segments
        if len(wet) != 1 or wet[0][0] == 0.0 or wet[0][1] < np.pi:
            raise ConfigError(
                f"reference_shape: received a shape whose wet parts are {wet} rad; needs one waterline with the keel "
                "below it: change device.mass or device.internal_pressure"
            )
        return wet[0][0]

    @cached_property
    def wet_segments(self) -> list[tuple[float, float]]:
        """Colatitude intervals below the free surface: none (dry), one, or several (more than one waterline)."""
        grid, (_, z, _) = self._grid, self._on_grid
        below = z.real < 0
        sides = [slice(i, i + 2) for i in np.flatnonzero(below[:-1] != below[1:])]
        crossings = [self._crossing(grid[side], z.real[side]) for side in sides]
        edges = [0.0, *crossings, np.pi]
        middles = self.curve(np.array([(a + b) / 2 for a, b in itertools.pairwise(edges)])).z
        return [(a, b) for a, b, z in zip(edges[:-1], edges[1:], middles.real, strict=True) if z < 0]

    def _crossing(self, ends: FloatArray, heights: FloatArray) -> float:
        """Colatitude of the waterline between two others, by Newton's method kept between them.

        Of a complex step one more of Newton's, from the real one.
        """
        (a, b), found = ends, float(ends[0] - heights[0] * np.diff(ends)[0] / np.diff(heights)[0])
        while a < found < b:
            at = self.curve(np.array([found]))
            a, b = (a, found) if (at.z.real[0] > 0) == (heights[1] > 0) else (found, b)
            step = float(at.z.real[0] / at.dz.real[0]) if at.dz.real[0] else b - a
            if abs(step) < 1e-9:  # convergence is quadratic: the error left is its square
                found -= step
                break
            found = found - step if a < found - step < b else float(a + b) / 2
        at = self.curve(np.array([found]))
        return found - 1j * at.z.imag[0] / at.dz.real[0] if np.iscomplexobj(at.z) else found

    def _wet_points(self, points: int) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Colatitudes and weights of Gauss-Legendre quadrature, `points` per wet segment, some at a time."""
        rule = self._rule(points + 2 * (self.basis.turns - self.basis.highest_degree), self.wet_segments)
        if len(rule[0]):
            yield from zip(*map(_parts, rule), strict=True)

    def _rule(self, points: int, segments: Sequence[tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
        """Colatitudes and weights of Gauss-Legendre quadrature, so many on each part of segments between junctions."""
        node, weight = gauss_rule(points)
        junctions = self.basis.shell.meridian.junctions
        pieces = [piece for ends in segments for piece in parts(junctions, *ends)]
        phi = [(a + b) / 2 + (b - a) / 2 * node for a, b in pieces]
        return np.ravel(phi), np.ravel([(b - a) / 2 * weight for a, b in pieces])

    def volume(self, points: int = 40) -> float:
        """Return the volume of displaced water [m^3], -int 2 pi x z n_z: pi x^2 dz integrated by parts at z = 0.

        By Gauss-Legendre quadrature, `points` per wet segment.
        """
        total = 0.0
        for phi, weight in self._wet_points(points):
            m = self.meridian(phi)
            total += float((2 * np.pi * m.x * m.z * m.dx) @ weight)
        return total

    def hydrostatic_stiffness(self, density: float, gravity: float, points: int = 60) -> FloatArray:
        """Return the stiffness of the water, shape (dof, dof) [N/m]; see `hydrostatics`."""
        return self.hydrostatics(density, gravity, points)[1]

    def hydrostatics(
        self, density: float, gravity: float, points: int = 60, over: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the generalized hydrostatic force, shape (dof,) [N], and its stiffness, shape (dof, dof) [N/m].

        The latter `over` some shapes alone, if given (dof, shape), (shape, shape).

        Notes
        -----
        Q_j = -int p n.psi_j dS with p = -rho g z and n dS = 2 pi x (-z', x') dphi on the deformed surface.

        The stiffness is the exact Jacobian -dQ_j/dq_k. The waterline moves too, but the pressure vanishes there, so
        only the integrand is differentiated: height (buoyancy), radius and the turning and stretching of n dS (follower
        pressure). Symmetric, for a pressure field has a potential; capytaine's own matrix drops terms of it and is not.
        """
        dof = len(self.basis.labels)
        force, jacobian = np.zeros(dof), np.zeros((dof, dof) if over is None else (over.shape[1],) * 2)
        for phi, weight in self._wet_points(points):
            m = self.meridian(phi)
            ring, column = weight * m.x, weight * m.z * m.x
            normal_j = -m.dz * m.shape_x + m.dx * m.shape_z
            force = force + (m.z * m.x * normal_j) @ weight
            if over is not None:
                normal_j, m = over.T @ normal_j, m._replace(**{name: over.T @ getattr(m, name) for name in _SHAPES})
            turned = -(m.shape_x * column) @ m.dshape_z.T + (m.shape_z * column) @ m.dshape_x.T
            jacobian = jacobian + normal_j @ (ring * m.shape_z + weight * m.z * m.shape_x).T + turned
        stiffness = -2 * np.pi * density * gravity * jacobian
        return 2 * np.pi * density * gravity * force, stiffness if over is None else (stiffness + stiffness.T) / 2


def _chord_of_arcs(rest: ArcMeridian, start: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far across and down a meridian of arcs leads from angles to those an offset further, each (point,) [m].

    Where both lie on one arc all digits of the offset count; else those of what lies on each.
    """
    across, down, rate = np.zeros_like(start), np.zeros_like(start), rest.length / np.pi
    edges = (0.0, *rest.junctions, np.pi)
    first, last = (np.searchsorted(rest.junctions, phi, side="right") for phi in (start, start + offset))
    for i, arc in enumerate(rest.starts):
        a, b = (np.clip(phi, edges[i], edges[i + 1]) for phi in (start, start + offset))
        step = np.where((first == i) & (last == i), offset, b - a)
        tangent = arc.tangent + arc.curvature * (rate * a - arc.arc)
        one = arc_chord(np.full_like(a, arc.curvature), tangent, rate * step)
        across, down = across + one[0], down + one[1]
    return across, down


def check_meridian(shell: DeformedShell) -> None:
    """Raise `ConfigError` if a meridian crosses the axis or itself, and so bounds no body.

    Checked at 40 points per degree, and by the slope at the poles.
    """
    if not np.isfinite([shell.centre_height, *shell.modal_amplitude]).all():
        raise ConfigError("reference_shape: received a shape with NaN or infinite amplitudes; needs finite ones")
    phi, (x, z, dx) = shell._grid, shell._on_grid
    x, z = x.copy(), z - shell.centre_height
    deform_less = "deform the shell less: raise its stiffness, or change device.internal_pressure"
    if dx[0] <= 0 or dx[-1] >= 0 or x[1:-1].min() <= 0:
        at = int(np.argmin(x[1:-1])) + 1
        raise ConfigError(
            f"reference_shape: received a meridian that crosses the axis (radius {x[at]:.3g} m at colatitude "
            f"{phi[at]:.3g} rad, slope {dx[0]:.3g} m at the top, {dx[-1]:.3g} m at the keel); needs one clear of "
            f"it between its poles: {deform_less}"
        )
    x[0] = x[-1] = 0.0
    if (x[1:] * z[:-1] > x[:-1] * z[1:]).all():
        return  # star-shaped about the centre
    if crossing := _crossing(x, z) or _curl(shell):
        a, b = (phi[i] for i in crossing)
        raise ConfigError(
            f"reference_shape: received a meridian that crosses itself (colatitudes {a:.3g} and {b:.3g} rad); needs "
            f"one that does not: {deform_less}"
        )


def _curl(shell: DeformedShell) -> tuple[int, int] | None:
    """Indices of two neighbours on the grid that enclose a curl the grid does not resolve; None if there is none.

    The tangent of a meridian that does not cross itself turns by half a circle in all (Hopf).
    """
    count = len(shell._grid) - 1
    m = shell.meridian(np.linspace(0.0, np.pi, _FINER * count + 1))
    turned = np.unwrap(np.arctan2(m.dz, m.dx))
    if abs(turned[-1] - turned[0] + np.pi) < 1:
        return None
    at = int(np.argmin(np.hypot(m.dx, m.dz))) // _FINER
    return at, min(at + 1, count)


def _crossing(x: FloatArray, z: FloatArray) -> tuple[int, int] | None:
    """Indices of the first two sides of an open polygon that meet but are no neighbours."""
    a, b = np.column_stack([x, z])[:-1], np.column_stack([x, z])[1:]
    low, high = np.minimum(a, b), np.maximum(a, b)

    def beside(p: FloatArray, q: FloatArray, r: FloatArray) -> FloatArray:
        """Twice the area of the triangles p, q, r, positive to the left."""
        return np.asarray((q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0])

    for i in range(len(a) - 2):
        others = np.arange(i + 2, len(a))
        near = others[((low[others] <= high[i]) & (high[others] >= low[i])).all(axis=1)]
        start, end = np.broadcast_to(a[i], (len(near), 2)), np.broadcast_to(b[i], (len(near), 2))
        apart = beside(start, end, a[near]) * beside(start, end, b[near])
        aside = beside(a[near], b[near], start) * beside(a[near], b[near], end)
        if (found := near[(apart <= 0) & (aside <= 0)]).size:
            return i, int(found[0])
    return None


def enclosed(basis: ModeBasis, modal_amplitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the volume the whole shell encloses [m^3] and its surface area [m^2] along a motion.

    Parameters
    ----------
    modal_amplitude : ndarray, shape (time, dof) [m]
        Heave and modal amplitudes; heave is without effect.

    Returns
    -------
    volume, area : ndarray, shape (time,)
        -int pi x^2 dz and int 2 pi x ds over the deformed meridian.
    """
    phi, weight = meridian_rule(basis.shell.meridian.junctions, 4 * basis.turns + 24)  # the volume is exact
    m = DeformedShell(basis, 0.0).meridian(phi)
    x, dx, dz = (
        m.x + modal_amplitude @ m.shape_x,
        m.dx + modal_amplitude @ m.dshape_x,
        m.dz + modal_amplitude @ m.dshape_z,
    )
    return -np.pi * (x**2 * dz) @ weight, 2 * np.pi * (x * np.hypot(dx, dz)) @ weight


def rigid_sphere(radius: float, centre_height: float) -> DeformedShell:
    """Return an undeformed sphere in the water, of any material."""
    return rigid_buoy(Shell(radius, 0.01 * radius, 1.0, 0.0, 1.0), centre_height)


def rigid_buoy(shell: Shell, centre_height: float) -> DeformedShell:
    """Return an undeformed shell in the water, that moves as a whole."""
    return DeformedShell(ModeBasis(shell, (), 1.0, bending=False), centre_height, np.zeros(1))


def _powers(base: ComplexArray, count: int) -> ComplexArray:
    """Powers 0, 1, ... of complex numbers, shape (power, point): sines and cosines of multiples of angles."""
    found = np.ones((count, len(base)), dtype=complex)
    for k in range(1, count):
        np.multiply(found[k - 1], base, out=found[k])
    return found


@dataclass(frozen=True)
class ReferenceShell:
    """Shape at rest and the stiffness about it; motions are measured from there."""

    shape: DeformedShell
    stiffness: Mapping[str, FloatArray]  # structural, hydrostatic, and where there are: prestress, gas (dof, dof) [N/m]

    @property
    def basis(self) -> ModeBasis:
        """Heave and shell modes."""
        return self.shape.basis

    @property
    def total(self) -> FloatArray:
        """Sum of the stiffness, shape (dof, dof) [N/m]."""
        return np.asarray(sum(self.stiffness.values()))

    @property
    def modal_amplitude(self) -> FloatArray:
        """Heave and modal amplitudes of the shape at rest, shape (dof,) [m]; zero if undeformed."""
        return self.shape.modal_amplitude

    @property
    def keel_depth(self) -> float:
        """Depth of the keel below still water [m]."""
        return -float(self.shape.meridian(np.array([np.pi])).z[0])
