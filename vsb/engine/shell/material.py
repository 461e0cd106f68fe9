"""What the wall is made of: laws of elasticity of thin walls, what a study file says of them, materials by name.

Strains are principal Green strains of the sheet, E_i = (lambda_i^2 - 1)/2 with the stretches lambda_1 and lambda_2; the
energy W(E_1, E_2) is per undeformed volume, so S_i = dW/dE_i are second Piola-Kirchhoff stresses and the tension per
deformed width is T_1 = h lambda_1 S_1/lambda_2 = (h/lambda_2) dW/dlambda_1.

Rubber does not change its volume: with c_i = 1 + 2 E_i = lambda_i^2 the wall thins to lambda_3 = (c_1 c_2)^(-1/2), and
the invariants are I_1 = c_1 + c_2 + 1/(c_1 c_2), I_2 = c_1 c_2 + 1/c_1 + 1/c_2 (Ogden, Non-Linear Elastic Deformations,
1984). Stresses are written without differences of nearly equal numbers, so small strains keep their digits.

A wall of thickness h bends with changes of curvature k_1, k_2. At a distance Z of its middle surface, measured in the
undeformed wall, the strain is E_i + Z lambda_3 k_i; Gauss' rule with two points, Z = -+ h/sqrt(12), integrates the
energy of the wall,

    Psi(E, k) = h/2 [W(E + h/sqrt(12) lambda_3 k) + W(E - h/sqrt(12) lambda_3 k)]
              = h W(E) + (1/2) (h^3/12) lambda_3^2 k_i k_j d2W/dE_i dE_j + O(h^5 k^4),

which is bending of the thinned wall with the moduli of the stretched material; for Hooke's law it is exact.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, get_args

import numpy as np
from pydantic import Field

from vsb.keys.meanings import Key
from vsb.keys.quantities import NonNegative, Positive, Section, within
from vsb.keys.reading import nearest
from vsb.tools.arrays import FloatArray


class Moduli(NamedTuple):
    """Second derivatives of the energy by the strains, each of the strains' shape [Pa]."""

    first: FloatArray  # d2W/dE_1^2
    mixed: FloatArray  # d2W/dE_1 dE_2
    second: FloatArray  # d2W/dE_2^2
    shear: FloatArray  # stress over the angle of shear between the principal directions


class Thinning(NamedTuple):
    """Stretch of the thickness and its derivatives by E_1 and E_2 [-]."""

    stretch: FloatArray
    by: tuple[FloatArray, FloatArray]
    twice_by: tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
    by_shear: FloatArray  # second derivative by the angle of shear


class Range(NamedTuple):
    """How far a law holds: its name, what is measured, the values above which it is doubted, and does not hold."""

    law: str
    measure: str
    doubted: float
    invalid: float

    def is_doubted(self, measured: float) -> bool:
        """Whether the law is doubted at a measured value, beyond round-off."""
        return measured > (1 + AT_BOUND) * self.doubted

    def is_invalid(self, measured: float) -> bool:
        """Whether the law does not hold at a measured value, beyond round-off."""
        return measured > (1 + AT_BOUND) * self.invalid


AT_BOUND = 1e-6
"""Relative excess over the bound of a law that counts as at it: a design optimised under that bound rests at it."""


class Law(ABC):
    """Law of elasticity of an isotropic sheet in plane stress.

    Strains and what follows from them have any shape; they may be complex, for derivatives by a complex step.
    """

    young_modulus: float  # of small strains [Pa]
    poisson_ratio: float  # of small strains [-]
    range: ClassVar[Range]  # how far the law holds

    @abstractmethod
    def strained(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return what `range` measures [-]."""

    def admits(self, first: FloatArray, second: FloatArray) -> bool:
        """Return whether the material can be strained so at all."""
        return True

    @abstractmethod
    def energy(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy per undeformed volume by the principal Green strains [J/m^3]."""

    @abstractmethod
    def stresses(self, first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the second Piola-Kirchhoff stresses dW/dE_1, dW/dE_2 [Pa]."""

    @abstractmethod
    def moduli(self, first: FloatArray, second: FloatArray) -> Moduli:
        """Return the tangent moduli [Pa]."""

    @abstractmethod
    def thinning(self, first: FloatArray, second: FloatArray) -> Thinning:
        """Return the stretch of the thickness."""

    def tensions(self, stretch: FloatArray, other: FloatArray, thickness: float) -> tuple[FloatArray, FloatArray]:
        """Return the tensions per deformed width of a sheet by its principal stretches, T_1 and T_2 [N/m]."""
        first, second = self.stresses((stretch**2 - 1) / 2, (other**2 - 1) / 2)
        return thickness * stretch / other * first, thickness * other / stretch * second


@dataclass(frozen=True)
class HookeLaw(Law):
    """Hooke's law of Green strains (St Venant-Kirchhoff): W = E/2(1 - nu^2) (E_1^2 + E_2^2 + 2 nu E_1 E_2).

    It is that of small strains: the wall keeps its thickness.
    """

    young_modulus: float
    poisson_ratio: float
    range: ClassVar[Range] = Range("Hooke's law", "largest membrane strain", 0.02, 0.1)

    @property
    def _modulus(self) -> float:
        """E/(1 - nu^2) [Pa]."""
        return self.young_modulus / (1 - self.poisson_ratio**2)

    def strained(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the larger of the Green strains."""
        return np.maximum(np.abs(first), np.abs(second))

    def energy(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy per undeformed volume [J/m^3]."""
        return np.asarray(self._modulus / 2 * (first**2 + second**2 + 2 * self.poisson_ratio * first * second))

    def stresses(self, first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return S_1 and S_2 [Pa]."""
        nu, modulus = self.poisson_ratio, self._modulus
        return modulus * (first + nu * second), modulus * (second + nu * first)

    def moduli(self, first: FloatArray, second: FloatArray) -> Moduli:
        """Return the tangent moduli [Pa], the same at all strains."""
        one = np.ones_like(first)
        normal = self._modulus * one
        return Moduli(normal, self.poisson_ratio * normal, normal, (1 - self.poisson_ratio) / 2 * normal)

    def thinning(self, first: FloatArray, second: FloatArray) -> Thinning:
        """Return the stretch of the thickness: one, as the wall keeps its thickness."""
        one, zero = np.ones_like(first), np.zeros_like(first)
        return Thinning(one, (zero, zero), ((zero, zero), (zero, zero)), zero)


class Derivatives(NamedTuple):
    """Derivatives of a rubber's energy by its invariants I_1 and I_2 [Pa]."""

    first: FloatArray | float  # dW/dI_1
    second: FloatArray | float  # dW/dI_2
    twice_first: FloatArray | float  # d2W/dI_1^2


class Incompressible(Law):
    """Rubber: an energy of the invariants I_1 and I_2 at constant volume, nu = 1/2."""

    poisson_ratio = 0.5

    @abstractmethod
    def of_invariants(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy by I_1 - 3 and I_2 - 3 [J/m^3]."""

    @abstractmethod
    def derivatives(self, first: FloatArray) -> Derivatives:
        """Return the derivatives of the energy by I_1 - 3."""

    @cached_property
    def young_modulus(self) -> float:  # type: ignore[override]  # computed, and as constant
        """E = 3 mu = 6 (dW/dI_1 + dW/dI_2) at rest [Pa]."""
        at_rest = self.derivatives(np.zeros(1))
        young_modulus: float = np.ravel(6 * (np.asarray(at_rest.first) + at_rest.second))[0].item()
        return young_modulus

    def strained(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the largest change of length, |lambda - 1|."""
        stretches = np.sqrt(1 + 2 * np.array([first, second]))
        return np.asarray(np.abs(stretches - 1).max(axis=0))

    def invariants(self, first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return I_1 - 3 and I_2 - 3, of second order in small strains [-]."""
        product = first * second
        area = 2 * (first + second) + 4 * product  # c_1 c_2 - 1
        return (2 * (first + second) * area - 4 * product) / (1 + area), (area**2 - 4 * product) / (1 + area)

    def energy(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy per undeformed volume [J/m^3]."""
        return self.of_invariants(*self.invariants(first, second))

    def stresses(self, first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return S_1 = 2 (c_1 - 1/(c_1 c_2)) (W_1 + c_2 W_2)/c_1 and S_2."""
        c, d, area = 1 + 2 * first, 1 + 2 * second, 2 * (first + second) + 4 * first * second
        by, both = self.derivatives(self.invariants(first, second)[0]), 1 + area
        unlike = (2 * first + c * area, 2 * second + d * area)  # c_1^2 c_2 - 1
        return (
            2 * unlike[0] / (c * both) * (by.first + d * by.second),
            2 * unlike[1] / (d * both) * (by.first + c * by.second),
        )

    def moduli(self, first: FloatArray, second: FloatArray) -> Moduli:
        """Return 4 d2W/dc_i dc_j and (S_1 - S_2)/(c_1 - c_2)."""
        c, d = 1 + 2 * first, 1 + 2 * second
        by, both = self.derivatives(self.invariants(first, second)[0]), c * d
        slope, other = 1 - 1 / (c * both), 1 - 1 / (d * both)  # of I_1
        return Moduli(
            4 * (2 * by.first / (c**2 * both) + 2 * by.second / c**3 + by.twice_first * slope**2),
            4 * (by.first / both**2 + by.second + by.twice_first * slope * other),
            4 * (2 * by.first / (d**2 * both) + 2 * by.second / d**3 + by.twice_first * other**2),
            2 * (by.first / both**2 + by.second * ((c + d) / both**2 - 1)),
        )

    def thinning(self, first: FloatArray, second: FloatArray) -> Thinning:
        """Return lambda_3 = (c_1 c_2)^(-1/2)."""
        c, d = 1 + 2 * first, 1 + 2 * second
        stretch = 1 / np.sqrt(c * d)
        mixed = stretch / (c * d)
        return Thinning(
            stretch,
            (-stretch / c, -stretch / d),
            ((3 * stretch / c**2, mixed), (mixed, 3 * stretch / d**2)),
            stretch**3,
        )


@dataclass(frozen=True)
class NeoHookeanLaw(Incompressible):
    """W = mu/2 (I_1 - 3): rubber to stretches of about 1.5 (Treloar, The Physics of Rubber Elasticity, 1975)."""

    mu: float  # shear modulus [Pa]
    range: ClassVar[Range] = Range("a neo-Hookean material", "largest change of length", 0.5, 1.0)

    def of_invariants(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy by I_1 - 3 and I_2 - 3 [J/m^3]."""
        return np.asarray(self.mu / 2 * first)

    def derivatives(self, first: FloatArray) -> Derivatives:
        """Return the derivatives of the energy by its invariants [Pa]."""
        return Derivatives(self.mu / 2, 0.0, 0.0)


@dataclass(frozen=True)
class MooneyRivlinLaw(Incompressible):
    """W = c1 (I_1 - 3) + c2 (I_2 - 3): rubber to stretches of about 2; mu = 2 (c1 + c2)."""

    c1: float  # [Pa]
    c2: float
    range: ClassVar[Range] = Range("a Mooney-Rivlin material", "largest change of length", 1.0, 2.0)

    def of_invariants(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy by I_1 - 3 and I_2 - 3 [J/m^3]."""
        return np.asarray(self.c1 * first + self.c2 * second)

    def derivatives(self, first: FloatArray) -> Derivatives:
        """Return the derivatives of the energy by its invariants [Pa]."""
        return Derivatives(self.c1, self.c2, 0.0)


@dataclass(frozen=True)
class GentLaw(Incompressible):
    """W = -(mu Jm/2) ln(1 - (I_1 - 3)/Jm): rubber to its lock-up at I_1 - 3 = Jm, where its chains are straight.

    Gent, A new constitutive relation for rubber, Rubber Chemistry and Technology 69 (1996).
    """

    mu: float  # shear modulus of small strains [Pa]
    jm: float  # [-]
    range: ClassVar[Range] = Range(
        "Gent's law, in I1 - 3 over that of lock-up,", "largest I1 - 3 over that of lock-up", 0.5, 0.9
    )

    def strained(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return (I_1 - 3)/Jm."""
        return self.invariants(first, second)[0] / self.jm

    def admits(self, first: FloatArray, second: FloatArray) -> bool:
        """Return whether the strains are below lock-up."""
        return bool(np.all(self.strained(first, second) < 1))

    def of_invariants(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the energy by I_1 - 3 and I_2 - 3 [J/m^3]; it ends at lock-up."""
        return np.asarray(-self.mu * self.jm / 2 * np.log1p(-first / self.jm))

    def derivatives(self, first: FloatArray) -> Derivatives:
        """Return the derivatives of the energy by its invariants [Pa]."""
        left = self.jm - first
        return Derivatives(self.mu * self.jm / (2 * left), 0.0, self.mu * self.jm / (2 * left**2))


class WallModuli(NamedTuple):
    """Second derivatives of the energy of a wall."""

    normal: FloatArray  # by E_1, E_2, k_1, k_2, shape (4, 4, ...) [N/m], [N], [N m]
    shear: FloatArray  # by the angle of shear and twice the twist, shape (2, 2, ...)


@dataclass(frozen=True)
class Wall:
    """A wall of some thickness: energy per undeformed area Psi(E, k) of strains and changes of curvature.

    Strains come as E_1, E_2 [-], k_1, k_2 [1/m], an array of shape (4, ...).
    """

    law: Law
    thickness: float  # undeformed [m]

    @property
    def _offset(self) -> float:
        """Distance of the layers from the middle surface, h/sqrt(12) [m]."""
        return self.thickness / math.sqrt(12)

    def _number(self, strains: FloatArray) -> np.dtype[Any]:
        """Type of numbers of what follows from strains: complex in a complex step of any of its arguments."""
        return np.result_type(strains, self.thickness, *vars(self.law).values())

    def _layers(self, strains: FloatArray) -> tuple[tuple[float, FloatArray], ...]:
        """Signed distance of each layer, and its strains E + Z lambda_3 k, shape (2, ...)."""
        thin = self.law.thinning(strains[0], strains[1]).stretch
        return tuple((z, strains[:2] + z * thin * strains[2:]) for z in (-self._offset, self._offset))

    def energy(self, strains: FloatArray) -> FloatArray:
        """Return Psi [J/m^2]."""
        layers = self._layers(strains)
        return np.asarray(self.thickness / 2 * sum(self.law.energy(*layer) for _, layer in layers))

    def resultants(self, strains: FloatArray) -> FloatArray:
        """Return dPsi by E_1, E_2 (membrane forces [N/m]) and by k_1, k_2 (moments [N]), shape (4, ...)."""
        thin, total = self.law.thinning(strains[0], strains[1]), np.zeros(strains.shape, self._number(strains))
        for z, layer in self._layers(strains):
            stress = np.array(self.law.stresses(*layer))
            moment = (stress * strains[2:]).sum(axis=0)
            total[:2] += stress + z * np.array(thin.by) * moment
            total[2:] += z * thin.stretch * stress
        return self.thickness / 2 * total

    def moduli(self, strains: FloatArray) -> WallModuli:
        """Return the second derivatives of Psi, those by shear about no shear."""
        thin, shape = self.law.thinning(strains[0], strains[1]), strains.shape[1:]
        number = self._number(strains)
        normal, shear = (np.zeros((n, n, *shape), dtype=number) for n in (4, 2))
        for z, layer in self._layers(strains):
            stress, c = np.array(self.law.stresses(*layer)), self.law.moduli(*layer)
            tangent = np.array([[c.first, c.mixed], [c.mixed, c.second]])
            moment = (stress * strains[2:]).sum(axis=0)
            by = np.zeros((2, 4, *shape), dtype=number)  # derivatives of the layer's strains
            for i in range(2):
                by[i, i], by[i, 2 + i] = 1.0, z * thin.stretch
                by[i, :2] += z * strains[2 + i] * np.array(thin.by)
            normal += np.einsum("iw...,ix...->wx...", by, np.einsum("ij...,jx...->ix...", tangent, by))
            normal[:2, :2] += z * np.array(thin.twice_by) * moment
            mixed = z * np.array([[one * s for s in stress] for one in thin.by])
            normal[:2, 2:] += mixed
            normal[2:, :2] += mixed.swapaxes(0, 1)
            twisted = z * thin.stretch
            shear += c.shear * np.array([[np.ones(shape), twisted], [twisted, twisted**2]])
            shear[0, 0] += z * moment * thin.by_shear
        return WallModuli(self.thickness / 2 * normal, self.thickness / 2 * shear)


RUBBERS = "L. A. Wood, in Brandrup and Immergut, Polymer Handbook, Physical constants of rubbers (density)"
ASHBY = "M. F. Ashby, Materials Selection in Mechanical Design, 3rd ed. 2005, Appendix C, middle of the range"


@dataclass(frozen=True)
class NamedMaterial:
    """Constants of a material, and their source."""

    density: float  # [kg/m^3]
    source: str
    mu: float | None = None  # of rubber [Pa]
    young_modulus: float | None = None  # of Hooke's law [Pa]
    poisson_ratio: float | None = None  # [-]

    @property
    def keys(self) -> dict[str, Any]:
        """What stands for the name in the section `device`."""
        if self.mu is not None:
            return {"material": {"law": "neo_hookean", "mu": self.mu}}
        return {"young_modulus": self.young_modulus, "poisson_ratio": self.poisson_ratio}


NAMED = {
    "natural_rubber": NamedMaterial(
        970.0, f"L. R. G. Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, chapter 5 (mu); {RUBBERS}", mu=0.39e6
    ),
    "silicone": NamedMaterial(
        1030.0, "Sylgard 184 cured at 25 °C: Johnston et al., J. Micromech. Microeng. 24 (2014) 035017", mu=0.44e6
    ),
    "nitrile": NamedMaterial(
        1200.0, "Shore A 60, by hardness: A. N. Gent, Trans. Inst. Rubber Ind. 34 (1958) 46 (E = 3.6 MPa)", mu=1.2e6
    ),
    "polyethylene": NamedMaterial(950.0, ASHBY, young_modulus=0.76e9, poisson_ratio=0.42),
    "glass_fibre": NamedMaterial(1860.0, f"{ASHBY}, GFRP", young_modulus=21.5e9, poisson_ratio=0.31),
    "aluminium": NamedMaterial(2700.0, "EN 1999-1-1, 3.2.5", young_modulus=70e9, poisson_ratio=0.3),
    "steel": NamedMaterial(7850.0, "EN 1993-1-1, 3.2.6", young_modulus=210e9, poisson_ratio=0.3),
    "concrete": NamedMaterial(2500.0, "C30/37: EN 1992-1-1, table 3.1", young_modulus=33e9, poisson_ratio=0.2),
}
"""By the names a study file may use."""


Modulus = Annotated[Positive, within(1.0, 1e9, "Pa", "rubber has 1e5 to 1e7 Pa")]


class BaseMaterial(Section):
    """What every material answers, so that nobody else asks which it is."""

    @property
    @abstractmethod
    def rubber(self) -> Incompressible | None:
        """The law of rubber; None of Hooke's law, whose moduli are the device's."""


class Hookean(BaseMaterial):
    """Hooke's law, of the device's young_modulus [Pa] and poisson_ratio [-]."""

    KEYS: ClassVar = {"law": Key("", "hookean", "Hooke's law, with young_modulus and poisson_ratio of the device")}
    law: Literal["hookean"] = "hookean"

    @property
    def rubber(self) -> None:
        """None: it is no rubber."""
        return None


class NeoHookean(BaseMaterial):
    """Rubber of shear modulus mu [Pa]."""

    KEYS: ClassVar = {
        "law": Key("", "neo_hookean", "rubber to stretches of about 1.5"),
        "mu": Key("Pa", "4.0e+5", "shear modulus; Young's modulus of small strains is three times as large"),
    }
    law: Literal["neo_hookean"]
    mu: Modulus

    @property
    def young_modulus(self) -> float:
        """Young's modulus of small strains [Pa]."""
        return 3 * self.mu

    @property
    def rubber(self) -> Incompressible:
        """The law of rubber."""
        return NeoHookeanLaw(self.mu)


class MooneyRivlin(BaseMaterial):
    """Rubber of moduli c1 and c2 [Pa]; its shear modulus is 2 (c1 + c2)."""

    KEYS: ClassVar = {
        "law": Key("", "mooney_rivlin", "rubber to stretches of about 2"),
        "c1": Key("Pa", "1.6e+5", "modulus of the first invariant; the shear modulus is 2 (c1 + c2)"),
        "c2": Key("Pa", "4.0e+4", "modulus of the second invariant"),
    }
    law: Literal["mooney_rivlin"]
    c1: Modulus
    c2: Annotated[NonNegative, within(0.0, 1e9, "Pa", "rubber has 1e5 to 1e7 Pa")]

    @property
    def young_modulus(self) -> float:
        """Young's modulus of small strains [Pa]."""
        return 6 * (self.c1 + self.c2)

    @property
    def rubber(self) -> Incompressible:
        """The law of rubber."""
        return MooneyRivlinLaw(self.c1, self.c2)


class Gent(BaseMaterial):
    """Rubber of shear modulus mu [Pa] whose chains are straight at I1 - 3 = jm [-]."""

    KEYS: ClassVar = {
        "law": Key("", "gent", "rubber up to the stretch at which its chains are straight"),
        "mu": Key("Pa", "4.0e+5", "shear modulus of small strains"),
        "jm": Key("-", "30.0", "first invariant, less 3, at which the chains are straight"),
    }
    law: Literal["gent"]
    mu: Modulus
    jm: Annotated[Positive, within(0.1, 1e6, "", "rubber has 10 to 200; above it is neo-Hookean")]

    @property
    def young_modulus(self) -> float:
        """Young's modulus of small strains [Pa]."""
        return 3 * self.mu

    @property
    def rubber(self) -> Incompressible:
        """The law of rubber."""
        return GentLaw(self.mu, self.jm)


Rubber = NeoHookean | MooneyRivlin | Gent
Material = Annotated[Hookean | Rubber, Field(discriminator="law")]


def with_moduli(device: Any) -> Any:
    """Return the section `device` as nested mappings with the moduli that rubber implies.

    A material by name stands for its constants, and for its density where none is given. Raises `ValueError` if the
    section has moduli beside those of its material, or the name is unknown.
    """
    if isinstance(device, dict) and isinstance(device.get("material"), str):
        device = _by_name(device)
    material = device.get("material") if isinstance(device, dict) else None  # valid, or being read
    law = material.get("law") if isinstance(material, dict) else getattr(material, "law", None)
    if law in (None, "hookean"):
        return device
    for key in ("young_modulus", "poisson_ratio"):
        if key in device:
            raise ValueError(f"{key}: received {device[key]!r} beside material {law}, which has its own; remove it")
    return {**device, "young_modulus": _young_modulus(device["material"]), "poisson_ratio": 0.5}


def _by_name(device: dict[str, Any]) -> dict[str, Any]:
    """The section with the constants of its named material."""
    name = device["material"]
    if name not in NAMED:
        near = nearest(name, NAMED)
        meant = f"did you mean {near}? It" if near else "it"
        law = "a law, such as {law: neo_hookean, mu: 4.0e+5}"
        raise ValueError(f"material: received {name!r}; {meant} needs one of {', '.join(NAMED)}, or {law}")
    found = NAMED[name]
    for key in ("young_modulus", "poisson_ratio"):
        if key in device:
            raise ValueError(f"{key}: received {device[key]!r} beside material {name}, which has its own; remove it")
    rest = {key: value for key, value in device.items() if key != "material"}
    return {"density": found.density, **rest, **found.keys}


def _young_modulus(material: Any) -> float:
    """Young's modulus of rubber; 1 where what is wrong with it is left to be found by its own check."""
    for rubber in get_args(Rubber):
        try:
            return float(rubber.model_validate(material).young_modulus)
        except ValueError:
            continue
    return 1.0
