"""What bounds a buoy, and which buoys of a design file's ranges can float and keep the limits. Pure Python.

Both follow from masses and sizes alone. `shares` says of one buoy how far it is from what bounds it.

The radius is divided into cells. Let a cell reach from r_a to r_b, and let the height h of a shape, the thickness t and
the density d of the shell reach from their least to their largest values. A buoy of mass m in it needs

    floating:    max(m_low, t_low d_low A(r_a, h_low)) <= m <= min(m_high, mass limit, rho V(r_b, h_high)),
                 m_high at least the water displaced at the least draft there is,
    thin shell:  t_low < r_b/10,
    beam:        2 r_a lambda <= limit,
    surface:     A(r_a, h_low) lambda^2 <= limit,
    volume:      m <= rho limit, and V(r_a, h_low) <= limit where the hull keeps its shape,
    draft:       m <= rho V_below(limit, r_b) where the hull keeps its shape,

because area A and volume V of the undeformed hull grow with r and h. A hull at equilibrium shrinks by no more than its
Green-Lagrange strain e may: lambda = sqrt(1 - 2e); any other keeps its shape, lambda = 1. What no cell can meet, no
buoy can: these are proofs, not samples.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from vsb.engine.shell.device import NEAREST_POLE, THINNEST_SHELL, Device, cap_volume, full_volume, shell_mass, volume_to
from vsb.engine.waves.water import Water

THINNEST_RATIO = 10.0
"""Radius over thickness that thin-shell theory needs at least: an implied limit."""
OF_EVERY_BUOY = {
    "thin_shell": "a wall of a tenth of the least radius of curvature",
    "film": "a wall of a thirty-thousandth of the radius, below which it is a film",
    "wall_mass": "the mass of the wall and of the ballast that keeps the centre of mass",
    "least_draft": "the least draft there is",
    "floats": "the mass of the water displaced",
}
"""Limits that every buoy must keep, by name; the last two those of a rigid one."""
CELLS, CELLS_OF_SHAPE = 200, 10
"""Cells of the radius of a sphere, and of another meridian, whose area and volume take longer to compute."""
DEEPER = 1.02
"""Least depth of the water in drafts."""
HEIGHTS = ("device.shape.spheroid.height", "device.shape.capsule.length")
SERIES = "device.shape.series."
"""What keys of terms of a shape begin with."""
ROUND_OFF = 1e-9
"""Relative excess that is none."""
WHY = {
    "shell": "the shell alone has at least {needed:.4g} kg, and the buoy at most {limit:g} kg",
    "weight": "every buoy lies on the water: at the least draft there is, {part:g} radii, the smallest displaces "
    "{needed:.4g} kg, the heaviest has {limit:g} kg",
    "floats": "every buoy sinks: the largest displaces {limit:.4g} kg of water, the lightest has {needed:g} kg",
    "thin": "thickness from {needed:g} m and a radius/10 of at most {limit:g} m leave no thin shell",
    "mass": "every buoy has at least {needed:.4g} kg",
    "beam": "every hull is at least {needed:.4g} m wide",
    "surface": "every hull has at least {needed:.4g} m^2",
    "volume": "every hull has at least {needed:.4g} m^3",
    "draft": "every buoy has at least {needed:.4g} kg, and at that draft the largest carries {limit:.4g} kg",
}
"""Why a demand is not met, by name."""
Ends = tuple[float, float]


def shares(device: Device, water: Water, *, flexible: bool) -> dict[str, float]:
    """Return what a buoy uses of each limit of `OF_EVERY_BUOY` [-]: at most 1 if it can be made and floats.

    Parameters
    ----------
    flexible : bool
        Whether it has a wall; a rigid buoy is one of its size and mass alone.
    """
    most = 2 - NEAREST_POLE
    if math.isfinite(water.depth):
        rest = device.meridian
        most = min(most, 2 * water.depth / DEEPER / (2 * device.radius if rest is None else rest.highest - rest.lowest))
    least, full = (volume_to(device, part) * water.density for part in (NEAREST_POLE, most))
    found = {"least_draft": least / device.mass, "floats": device.mass / full}
    if not flexible:
        return found
    radius, thickness = device.radius, device.thickness
    sharpest = radius if device.meridian is None else device.meridian.sharpest
    return {
        "thin_shell": THINNEST_RATIO * thickness / sharpest,
        "film": THINNEST_SHELL * radius / thickness,
        "wall_mass": device.shell_mass / device.mass + abs(device.centre_of_mass or 0.0) / radius,
        **found,
    }


class Demand(NamedTuple):
    """The least that buoys of a cell need, and the most they may have, of one quantity."""

    needed: float
    limit: float

    @property
    def met(self) -> bool:
        """Whether some buoy may meet it."""
        return self.needed <= self.limit * (1 + ROUND_OFF)


class Unmet(NamedTuple):
    """A demand that no buoy of the ranges meets."""

    demand: str  # a limit by name, or shell, floats, thin, together
    why: str


class Reachable(NamedTuple):
    """Part of the ranges of radius [m] and mass [kg] outside of which no buoy meets the demands."""

    radius: Ends
    mass: Ends


class Cell(NamedTuple):
    """Bounds of the buoys whose radii lie between two."""

    radius: Ends
    area: float  # least of the undeformed hull [m^2]
    volume: float  # likewise [m^3]
    shell: float  # least mass of the shell [kg]
    light: float  # mass of the water that the smallest hull displaces at the least draft [kg]
    displaced: float  # mass of the water that the largest hull displaces [kg]


@dataclass(frozen=True)
class Ranges:
    """Ranges of what decides how a buoy floats, and the limits of a design file."""

    device: Device
    water: Water
    bounds: Mapping[str, Ends]  # of the variables, by key of the study
    limits: Mapping[str, float]  # by name
    deforms: bool  # whether the hull is that of a shell at equilibrium

    def ends(self, name: str) -> Ends:
        """Return the least and the largest value of a number of the device; both are its own if it is not varied."""
        value = float(getattr(self.device, name))
        return self.bounds.get(f"device.{name}", (value, value))

    @property
    def shrinkage(self) -> float:
        """Least length at rest over the undeformed length [-]; 0 where it is not bounded."""
        strain = self.limits.get("static_strain", math.inf) if self.deforms else 0.0
        return math.sqrt(max(0.0, 1.0 - 2.0 * strain))

    def judged(self) -> Unmet | Reachable:
        """Return the first demand that no buoy of the ranges meets, or the part of them where all may be met."""
        cells = self._cells()
        demands = [self._demands(cell) for cell in cells]
        for name in demands[0]:
            nearest = min((one[name] for one in demands), key=lambda demand: demand.needed / demand.limit)
            if not nearest.met:
                return Unmet(name, WHY[name].format(**nearest._asdict(), part=NEAREST_POLE))
        masses = [self._masses(cell) for cell in cells]
        kept = [i for i, one in enumerate(demands) if all(demand.met for demand in one.values()) and masses[i].met]
        if not kept:
            return Unmet("together", "no radius meets all demands at once, though each is met at some")
        radius = cells[kept[0]].radius[0], cells[kept[-1]].radius[1]
        return Reachable(radius, (min(masses[i].needed for i in kept), max(masses[i].limit for i in kept)))

    def _cells(self) -> list[Cell]:
        """Cells of the radius, one where it is not varied."""
        low, high = self.ends("radius")
        count = (CELLS if self.device.shape is None else CELLS_OF_SHAPE) if low < high else 1
        radii = [low * (high / low) ** (i / count) for i in range(count)] + [high]
        least, most = ([self._hull(radius, end) for radius in radii] for end in (0, 1))
        thickness, density = self.ends("thickness")[0], self.ends("density")[0]
        return [
            Cell(
                radius=(radii[i], radii[i + 1]),
                area=least[i][0],
                volume=least[i][1],
                shell=least[i][0] * thickness * density,
                light=least[i][2] * self.water.density,
                displaced=most[i + 1][1] * self.water.density,
            )
            for i in range(count)
        ]

    def _hull(self, radius: float, end: int) -> tuple[float, float, float]:
        """Area [m^2], volume and volume below the least draft [m^3] of a hull with the least (0) or largest (1) height.

        Of a hull that cannot be made, or whose terms are varied, bounds that exclude nothing.
        """
        shape = self.device.shape
        if any(key.startswith(SERIES) for key in self.bounds):
            return 0.0, math.inf if end else 0.0, 0.0
        for key in (key for key in HEIGHTS if key in self.bounds and shape):
            kind, name = key.split(".")[2:]
            sized = getattr(shape, kind).model_copy(update={name: self.bounds[key][end]})
            shape = shape and shape.model_copy(update={kind: sized})
        hull = self.device.model_copy(update={"radius": radius, "shape": shape})
        try:
            return shell_mass(hull.meridian, radius, 1.0, 1.0), full_volume(hull), volume_to(hull, NEAREST_POLE)
        except ValueError:
            return 0.0, math.inf if end else 0.0, 0.0

    def _demands(self, cell: Cell) -> dict[str, Demand]:
        """Demands on the buoys of a cell, each at the buoy of it that comes nearest, by name."""
        (lightest, heaviest), least, limits = self.ends("mass"), self.shrinkage, self.limits
        mass = max(lightest, cell.shell)
        needed = {
            "mass": mass,
            "beam": 2 * cell.radius[0] * least,
            "surface": cell.area * least**2,
            "volume": max(mass / self.water.density, 0.0 if self.deforms else cell.volume),
        }
        found = {
            "thin": Demand(self.ends("thickness")[0], cell.radius[1] / THINNEST_RATIO),
            "shell": Demand(cell.shell, heaviest),
            "weight": Demand(cell.light, heaviest),
            "floats": Demand(lightest, cell.displaced),
            **{name: Demand(value, limits[name]) for name, value in needed.items() if name in limits},
        }
        if "draft" in limits and not self.deforms:
            found["draft"] = Demand(mass, self._mass_at_draft(cell.radius[1]))
        return found

    def _masses(self, cell: Cell) -> Demand:
        """Least and largest mass of the buoys of a cell [kg]."""
        lightest, heaviest = self.ends("mass")
        most = [heaviest, cell.displaced, self.limits.get("mass", math.inf)]
        most.append(self.water.density * self.limits.get("volume", math.inf))
        if not self.deforms:
            most.append(self._mass_at_draft(cell.radius[1]))
        return Demand(max(lightest, cell.shell), min(most))

    def _mass_at_draft(self, radius: float) -> float:
        """Largest mass at the limit of draft [kg]; of another shape than the sphere as if its sides were upright."""
        draft = self.limits.get("draft", math.inf)
        if self.device.shape is None:
            return self.water.density * cap_volume(radius, min(draft / radius, 2.0))
        return self.water.density * math.pi * radius**2 * draft
