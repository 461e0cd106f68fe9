"""Materials by name, with typical constants at 20 °C and where these are published; measure those of your own.

Rubbers have the shear modulus mu of a neo-Hookean solid, all else Young's modulus and Poisson's ratio of Hooke's law.
"""

from dataclasses import dataclass
from typing import Any

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
