"""Closed shell of revolution: meridian and material; for the sphere also natural frequencies and classical buckling."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import legendre_p_all

from vsb.engine.shell.device import Device
from vsb.engine.shell.elasticity import HookeLaw, Incompressible, Law, Wall, law_of
from vsb.engine.shell.material import Hookean
from vsb.engine.shell.meridian import ArcMeridian, ClosedMeridian, RestMeridian, spheroid
from vsb.tools.arrays import AnyArray, FloatArray


class Curve(NamedTuple):
    """Radius and height of a meridian at some angles phi, and their derivatives by phi, each shape (point,) [m]."""

    x: FloatArray
    z: FloatArray
    dx: FloatArray
    dz: FloatArray


def curve(meridian: ClosedMeridian, phi: FloatArray) -> Curve:
    """Return a meridian at angles, shape (point,) [rad]; analytic in its numbers and in angles of a complex step."""
    if isinstance(meridian, ArcMeridian):
        return _on_arcs(meridian, phi)[0]
    assert isinstance(meridian, RestMeridian)
    (a, j), (b, k) = _numbered(meridian)
    if np.iscomplexobj(phi):
        (sin_j, cos_j), (sin_k, cos_k) = ((np.sin(np.outer(n, phi)), np.cos(np.outer(n, phi))) for n in (j, k))
        return Curve(a @ sin_j, b @ cos_k, (j * a) @ cos_j, -(k * b) @ sin_k)
    (_, x), (dx, _) = _sums(np.concatenate([np.zeros((2, 1)), np.array([a, j * a])], axis=1), phi).swapaxes(0, 1)
    (z, _), (_, fall) = _sums(np.array([b, k * b]), phi).swapaxes(0, 1)
    return Curve(x, z, dx, -fall)


def _on_arcs(meridian: ArcMeridian, phi: FloatArray) -> tuple[Curve, tuple[FloatArray, FloatArray]]:
    """A meridian of arcs at angles, and its second derivatives."""
    which = np.searchsorted(np.real(meridian.junctions), np.real(phi), side="right")
    curvature, arc, x, z, tangent = np.array(meridian.starts)[which].T
    rate = meridian.length / np.pi
    along = rate * phi - arc
    across, down = arc_chord(curvature, tangent, along)
    dx, dz, bent = (
        rate * np.cos(tangent + curvature * along),
        -rate * np.sin(tangent + curvature * along),
        rate * curvature,
    )
    return Curve(x + across, z - down, dx, dz), (bent * dz, -bent * dx)


def arc_chord(curvature: FloatArray, tangent: FloatArray, arc: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far across and down arcs lead, of `vsb.engine.shell.meridian.ArcMeridian`, each shape (point,) [m]."""
    half = curvature * arc / 2
    straight = half == 0.0
    chord = arc * np.where(straight, 1.0, np.sin(half) / np.where(straight, 1.0, half))
    return chord * np.cos(tangent + half), chord * np.sin(tangent + half)


def _sums(coefficients: AnyArray, phi: FloatArray) -> AnyArray:
    """Sums c_k cos(k phi) and c_k sin(k phi) over k = 0, 1, ... of several series, shape (2, series, point).

    With k = m w + r sum c_k exp(i k phi) is sum_m exp(i m w phi) sum_r c_mr exp(i r phi): two short tables of
    exponentials and a product of matrices in place of one exponential for each term and point; long capsules have
    hundreds of terms.
    """
    if np.iscomplexobj(coefficients):
        return np.asarray(_sums(coefficients.real, phi) + 1j * _sums(coefficients.imag, phi))
    series, terms = coefficients.shape
    width = math.isqrt(terms - 1) + 1
    rows = -(-terms // width)
    padded = np.zeros((series, rows * width))
    padded[:, :terms] = coefficients
    near, far = (np.exp(1j * np.outer(step * np.arange(count), phi)) for step, count in ((1, width), (width, rows)))
    inner = (padded.reshape(series * rows, width) @ near).reshape(series, rows, len(phi))
    found = (inner * far).sum(axis=1)
    return np.stack([found.real, found.imag])


def length(dx: FloatArray, dz: FloatArray) -> FloatArray:
    """Return the root of dx^2 + dz^2, analytic in a complex step of them."""
    return np.sqrt(dx**2 + dz**2) if np.iscomplexobj(dx) or np.iscomplexobj(dz) else np.hypot(dx, dz)


def bend(meridian: ClosedMeridian, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the second derivatives of radius and height by the angle, each shape (point,) [m]."""
    if isinstance(meridian, ArcMeridian):
        return _on_arcs(meridian, phi)[1]
    assert isinstance(meridian, RestMeridian)
    (a, j), (b, k) = _numbered(meridian)
    return -(j**2 * a) @ np.sin(np.outer(j, phi)), -(k**2 * b) @ np.cos(np.outer(k, phi))


def _numbered(meridian: RestMeridian) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Terms of radius and height, each with its number."""
    a, b = np.array(meridian.radial), np.array(meridian.axial)
    return (a, np.arange(1.0, len(a) + 1)), (b, np.arange(float(len(b))))


@cache
def gauss_rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of Gauss-Legendre quadrature on [-1, 1], each shape (points,), not to be written to."""
    rule = np.polynomial.legendre.leggauss(points)
    for values in rule:
        values.setflags(write=False)
    return rule


FEWEST_ON_PART = 16
"""Points of a quadrature on each part of a meridian with junctions, beside its share of them."""


def parts(junctions: Sequence[float], start: float, end: float) -> list[tuple[float, float]]:
    """Return the parts of a meridian between two angles that its junctions leave [rad]."""
    inside = [phi for phi in junctions if np.real(start) < np.real(phi) < np.real(end)]
    return list(itertools.pairwise((start, *inside, end)))


def meridian_rule(junctions: Sequence[float], points: int) -> tuple[FloatArray, FloatArray]:
    """Return angles and weights of dphi of a Gauss-Legendre rule in cos(phi) from pole to pole, each (point,) [rad].

    On a meridian with junctions `points` are shared among the parts between them, `FEWEST_ON_PART` more on each.
    """
    if not junctions:
        cos, weight = gauss_rule(points)
        return np.arccos(cos), weight / np.sin(np.arccos(cos))
    found = []
    for a, b in parts(junctions, 0.0, math.pi):
        node, weight = gauss_rule(FEWEST_ON_PART + math.ceil(points * np.real(b - a) / math.pi))
        top, bottom = np.cos(a), np.cos(b)
        phi = np.arccos((top + bottom) / 2 + (top - bottom) / 2 * node)
        found.append((phi, (top - bottom) / 2 * weight / np.sin(phi)))
    phis, weights = zip(*found, strict=True)
    return np.concatenate(phis), np.concatenate(weights)


def legendre(degree: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return P_n(cos phi) and its first and second derivatives by phi for n = 0..degree.

    Parameters
    ----------
    colatitude : ndarray, shape (point,) [rad]

    Returns
    -------
    tuple of ndarray, each shape (degree + 1, point) [-]
    """
    cos, sin = np.cos(colatitude), np.sin(colatitude)
    p, dp, ddp = legendre_p_all(degree, cos, diff_n=2)
    return p, -sin * dp, sin**2 * ddp - cos * dp


@dataclass(frozen=True, slots=True)
class Shell:
    """Thin closed shell of revolution of one isotropic material, by default a sphere.

    Examples
    --------
    The publication's shell: mass [kg], and the outer pressure it buckles under [Pa].

    >>> from vsb import Shell
    >>> shell = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
    >>> round(shell.mass, 1), round(shell.buckling_pressure, 1)
    (1357.2, 302.6)
    """

    radius: float  # largest [m]
    thickness: float  # [m]
    young_modulus: float  # of small strains [Pa]
    poisson_ratio: float  # of small strains [-]
    density: float  # [kg/m^3]
    rest: ClosedMeridian | None = None  # another meridian than the sphere's
    rubber: Incompressible | None = None  # in place of Hooke's law

    def __post_init__(self) -> None:
        """Check the thin-shell limit and the material; of numbers of a complex step their real parts."""
        if not 0.0 < self.thickness.real < 0.1 * self.radius.real:
            raise ValueError(
                f"thin-shell theory (C3) needs 0 < thickness < radius/10, got thickness={self.thickness} m "
                f"for radius={self.radius} m; use a thinner shell."
            )
        if not (self.young_modulus.real > 0 and self.density.real > 0 and -1 < self.poisson_ratio.real <= 0.5):
            raise ValueError(
                f"a material needs E > 0, density > 0 and -1 < nu <= 0.5, got E={self.young_modulus} Pa, "
                f"density={self.density} kg/m^3, nu={self.poisson_ratio}."
            )
        law = self.law
        if (law.young_modulus, law.poisson_ratio) != (self.young_modulus, self.poisson_ratio):
            raise ValueError(
                f"a shell of rubber needs E and nu of its small strains, {law.young_modulus} Pa and "
                f"{law.poisson_ratio}, got E={self.young_modulus} Pa, nu={self.poisson_ratio}."
            )
        stepped = any(isinstance(size, complex) for size in (self.radius, self.thickness))
        if self.rest is not None and not (stepped or self.rest.stepped):
            self._check_rest(self.rest)

    def _check_rest(self, rest: ClosedMeridian) -> None:
        """Check that another meridian is of this radius, and nowhere too sharp for a thin shell."""
        if not math.isclose(rest.radius, self.radius, rel_tol=1e-9):
            raise ValueError(f"a meridian needs the shell's radius, {self.radius} m, got {rest.radius} m.")
        if not self.thickness < 0.1 * rest.sharpest:
            raise ValueError(
                f"thin-shell theory (C3) needs thickness < a tenth of the radii of curvature, got thickness="
                f"{self.thickness} m for a least radius of curvature of {rest.sharpest:.4g} m; use a thinner shell."
            )

    @classmethod
    def of(cls, device: Device) -> "Shell":
        """Return the shell of a study's device."""
        given, size = device.material, (device.radius, device.thickness)
        rubber = None if isinstance(given, Hookean) else law_of(given)
        law = rubber or HookeLaw(device.young_modulus, device.poisson_ratio)
        return cls(*size, law.young_modulus, law.poisson_ratio, device.density, device.meridian, rubber)

    @property
    def law(self) -> Law:
        """The law of elasticity of its material."""
        return self.rubber or HookeLaw(self.young_modulus, self.poisson_ratio)

    @property
    def wall(self) -> Wall:
        """Energy of its wall by strains and changes of curvature."""
        return Wall(self.law, self.thickness)

    @property
    def of_unit_material(self) -> "Shell":
        """The same shell of unit modulus and density, which has the same natural modes."""
        return replace(self, young_modulus=1.0, density=1.0, rubber=None)

    @property
    def meridian(self) -> ClosedMeridian:
        """The meridian at rest, about an origin in the middle of its height."""
        return self.rest or spheroid(self.radius, 2 * self.radius)

    def at_rest(self, colatitude: FloatArray) -> Curve:
        """Return the meridian at rest at colatitudes, shape (point,) [rad]; r sin and r cos of the sphere."""
        if self.rest is not None:
            return curve(self.rest, colatitude)
        x, z = self.radius * np.sin(colatitude), self.radius * np.cos(colatitude)
        return Curve(x, z, z, -x)

    @property
    def mass(self) -> float:
        """Mass of the shell alone [kg]."""
        area = 4 * math.pi * self.radius**2 if self.rest is None else self.rest.area
        return area * self.thickness * self.density

    @property
    def reach(self) -> float:
        """Largest radius or height at rest, from the centre [m]."""
        return self.radius if self.rest is None else max(self.radius, self.rest.highest, -self.rest.lowest)

    @property
    def volume(self) -> float:
        """Volume it encloses at rest [m^3]."""
        return 4 / 3 * math.pi * self.radius**3 if self.rest is None else self.rest.volume

    def check_sphere(self) -> None:
        """Raise `ValueError` for other shapes than the sphere, which have no closed forms."""
        if self.rest is not None:
            raise ValueError("closed forms are those of the sphere, got a shell of another meridian.")

    @property
    def membrane_stiffness(self) -> float:
        """E h/(1 - nu^2) of small strains [N/m]."""
        return self.young_modulus * self.thickness / (1 - self.poisson_ratio**2)

    @property
    def shear_stiffness(self) -> float:
        """G h = E h/2(1 + nu) of small strains [N/m]."""
        return self.membrane_stiffness * (1 - self.poisson_ratio) / 2

    @property
    def bending_stiffness(self) -> float:
        """D = E h^3/12(1 - nu^2) of small strains [N m]."""
        return self.membrane_stiffness * self.thickness**2 / 12

    @property
    def buckling_pressure(self) -> float:
        """Classical external buckling pressure 2 E (h/r)^2/sqrt(3 (1 - nu^2)) [Pa]."""
        self.check_sphere()
        ratio = self.thickness / self.radius
        return 2 * self.young_modulus * ratio**2 / math.sqrt(3 * (1 - self.poisson_ratio**2))


def frequency_parameter(shell: Shell, degree: int) -> tuple[float, float]:
    """Return the squared frequency parameters (lower, upper) of one degree in closed form.

    Parameters
    ----------
    degree : int
        Legendre degree n >= 0. The lower value is 0 for n = 0 (no such mode) and n = 1 (rigid heave).

    Returns
    -------
    tuple of float [-]
        Omega^2 = [A -+ sqrt(A^2 - 4 m B)]/(2 (1 - nu^2)) with m = n(n+1) - 2,
        A = 3(1+nu) + m + e (m+3)(m+1+nu), B = 1 - nu^2 + e [(m+1)^2 - nu^2], e = (h/r)^2/12.

    Notes
    -----
    Shabara & Abdelkhalik Eqs. 52-56; their print of Eqs. 54-56 does not give their Table I, this form does
    (to 1e-11). For n = 0 the degree-0 meridional function is zero, so only the root with A^2 - 4mB survives.
    """
    shell.check_sphere()
    nu, m = shell.poisson_ratio, degree * (degree + 1) - 2
    e = (shell.thickness / shell.radius) ** 2 / 12
    if degree == 0:
        return 0.0, 2 / (1 - nu)
    a = 3 * (1 + nu) + m + e * (m + 3) * (m + 1 + nu)
    b = 1 - nu**2 + e * ((m + 1) ** 2 - nu**2)
    upper = (a + math.sqrt(a * a - 4 * m * b)) / (2 * (1 - nu**2))
    return m * b / ((1 - nu**2) ** 2 * upper), upper  # product of the roots: no cancellation in the lower one


def natural_frequencies(shell: Shell, degree: int) -> FloatArray:
    """Return the closed-form dry natural frequencies (lower, upper) of one degree, shape (2,) [rad/s].

    omega = sqrt(E/rho)/r Omega. Eq. 56 of the paper prints Omega^2 in the denominator; Table I is met with
    it in the numerator, E = 10 MPa, r = 2 m and rho = 2700 kg/m^3 (the paper states no density).
    """
    scale = math.sqrt(shell.young_modulus / shell.density) / shell.radius
    return scale * np.sqrt(frequency_parameter(shell, degree))
