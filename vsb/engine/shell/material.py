"""What the shell is made of: its law of elasticity, in a study file.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

from typing import Annotated, Any, Literal, get_args

from pydantic import Field

from vsb.engine.shell.named_materials import NAMED
from vsb.keys.quantities import NonNegative, Positive, Section, within
from vsb.keys.reading import nearest

Modulus = Annotated[Positive, within(1.0, 1e9, "Pa", "rubber has 1e5 to 1e7 Pa")]


class Hookean(Section):
    """Hooke's law, of the device's young_modulus [Pa] and poisson_ratio [-]."""

    law: Literal["hookean"] = "hookean"


class NeoHookean(Section):
    """Rubber of shear modulus mu [Pa]."""

    law: Literal["neo_hookean"]
    mu: Modulus

    @property
    def young_modulus(self) -> float:
        """Young's modulus of small strains [Pa]."""
        return 3 * self.mu


class MooneyRivlin(Section):
    """Rubber of moduli c1 and c2 [Pa]; its shear modulus is 2 (c1 + c2)."""

    law: Literal["mooney_rivlin"]
    c1: Modulus
    c2: Annotated[NonNegative, within(0.0, 1e9, "Pa", "rubber has 1e5 to 1e7 Pa")]

    @property
    def young_modulus(self) -> float:
        """Young's modulus of small strains [Pa]."""
        return 6 * (self.c1 + self.c2)


class Gent(Section):
    """Rubber of shear modulus mu [Pa] whose chains are straight at I1 - 3 = jm [-]."""

    law: Literal["gent"]
    mu: Modulus
    jm: Annotated[Positive, within(0.1, 1e6, "", "rubber has 10 to 200; above it is neo-Hookean")]

    @property
    def young_modulus(self) -> float:
        """Young's modulus of small strains [Pa]."""
        return 3 * self.mu


Rubber = NeoHookean | MooneyRivlin | Gent
Material = Annotated[Hookean | Rubber, Field(discriminator="law")]


def with_moduli(device: Any) -> Any:
    """Return the section `device` as nested mappings with the moduli that rubber implies.

    A material by name stands for its constants, and for its density where none is given. Raises `ValueError` if the
    section has moduli beside those of its material, or the name is unknown.
    """
    if isinstance(device, dict) and isinstance(device.get("material"), str):
        device = _by_name(device)
    if not isinstance(device, dict) or (law := _law(device.get("material"))) in (None, "hookean"):
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


def _law(material: Any) -> Any:
    """The law of a material, valid or being read; None where there is none."""
    return material.get("law") if isinstance(material, dict) else getattr(material, "law", None)


def _young_modulus(material: Any) -> float:
    """Young's modulus of rubber; 1 where what is wrong with it is left to be found by its own check."""
    for rubber in get_args(Rubber):
        try:
            return float(rubber.model_validate(material).young_modulus)
        except ValueError:
            continue
    return 1.0
