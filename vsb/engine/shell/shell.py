"""Closed shell of revolution: meridian and material; for the sphere also natural frequencies and classical buckling."""

import math
from dataclasses import dataclass, replace

import numpy as np

from vsb.engine.shell.device import Device
from vsb.engine.shell.material import HookeLaw, Incompressible, Law, Wall
from vsb.engine.shell.meridian import ClosedMeridian, Curve, curve, spheroid
from vsb.tools.arrays import FloatArray


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
        if (rest := self.rest) is None or stepped or rest.stepped:
            return
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
        size, rubber = (device.radius, device.thickness), device.material.rubber
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


def converged_degree(shell: Shell, least: int = 40) -> int:
    """Return 1.6 times the classical degree of buckling, sqrt(r/h) [12 (1 - nu^2)]^(1/4), and no less than `least`.

    On other meridians than the sphere's times the most by which they stretch the angle, max |(x', z')|/r.
    """
    slenderness = (shell.radius / shell.thickness).real
    critical = math.sqrt(slenderness * math.sqrt(12 * (1 - shell.poisson_ratio.real**2)))
    degree = max(least, math.ceil(1.6 * critical))
    if shell.rest is None:
        return degree
    at = shell.at_rest(np.linspace(0.0, np.pi, 4 * shell.rest.terms + 41))
    stretch = float(np.hypot(at.dx.real, at.dz.real).max()) / shell.radius.real
    return math.ceil(degree * max(1.0, stretch - 1e-9))
