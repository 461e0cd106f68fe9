"""The degree of the shell modes that a tolerance asks for, from the stiffness of the wall alone. Pure Python."""

import math
from collections.abc import Callable

from vsb.engine.motion.take_off import (
    BetweenPort,
    DistributedPort,
    LinePort,
    PortChoice,
    SeveralPorts,
    ShellPort,
    StrainPort,
)
from vsb.study.sections import DEGREES
from vsb.study.specs import AnyBuoy

WITHIN = 4.0
"""Change of the power of a port within the shell over that of a port that heaves, in terms of the wall's stiffness over
rho g [-]."""
AT_POINTS = 3.5
"""Degree that resolves what bends about the ends of a port between two points, over `bending_degree` [-]."""
TURNS = 5.0
"""The same of a port that surges or pitches with the buoy: the shell is a spring between water and ballast [-]."""
SHAPES = 2.0
"""The same of another shape than the sphere: some of its wall is flatter [-]."""
MARGIN = 2.0
"""Over the change that is expected, 0.3 to 2.5 times of which was found of stiff spheres [-]."""
SOFT = 8.0
"""Stiffness of a wall about which its shapes resonate in waves, which magnifies what is left out, over rho g [-]."""


def wall_stiffness(study: AnyBuoy, degree: int) -> float:
    """Return the stiffness per unit area k_n of a wall against a load of a Legendre degree, over rho g [-].

    k_n = (E h + T n(n+1) + D n^2 (n+1)^2/r^2)/r^2, by its membrane, by the tension T = p r/2 of an internal pressure,
    and by bending, D = E h^3/12(1 - nu^2).
    """
    device, water, r = study.device, study.water, _reach(study)
    membrane, turns = device.young_modulus * device.thickness, degree * (degree + 1)
    bending = membrane * device.thickness**2 / (12 * (1 - device.poisson_ratio**2))
    tension = max(device.internal_pressure, 0.0) * r / 2
    return (membrane + tension * turns + bending * turns**2 / r**2) / r**2 / (water.density * water.gravity)


def bending_degree(study: AnyBuoy) -> float:
    """Return the degree at which a wall is as stiff by bending as by its membrane, D n^4/r^4 = E h/r^2 [-]."""
    device = study.device
    return float((12 * (1 - device.poisson_ratio**2)) ** 0.25 * math.sqrt(_reach(study) / device.thickness))


def _reach(study: AnyBuoy) -> float:
    """Largest radius of the shell, or half its height [m]."""
    radius, rest = study.device.radius, study.device.meridian
    return radius if rest is None else max(radius, rest.highest, -rest.lowest)


def expected_change(study: AnyBuoy, degree: int) -> float:
    """Return the change of mean power by all shell modes above a degree that is to be expected, relative [-].

    Waves press on the wet part of the wall. Of such a load the Legendre degree n falls like n^-3/2, and the wall yields
    to it by 1/k_n, so that what degrees above n do is about rho g/(k_n n^1.4).
    """
    return 1 / (wall_stiffness(study, degree) * math.pow(degree, 1.4))


def degree_needed(study: AnyBuoy) -> int:
    """Return the least of `DEGREES` that is expected to leave out no more than `modes.tolerance`, or the highest.

    A wall as soft as the water resonates in waves; where the port lies within the shell, all power comes from what the
    wall yields, and of one between two points most of it yields near them; where the port surges or pitches, the shell
    is a spring between the water and the ballast. How much is left out is measured afterwards
    (`vsb.results.left_out`).
    """
    stiffness, port = wall_stiffness(study, 2), study.pto.port
    held = study.pto.held is not None and study.pto.held.place == "heave"
    within = _any(port, _within_shell) or (held and _any(port, _at_ring))
    turns = _any(port, _turns)
    flatter = SHAPES if study.device.shape is not None else 1.0
    factor = (
        MARGIN * flatter * (TURNS if turns else 1.0) * (1 + SOFT / stiffness + (WITHIN * stiffness if within else 0.0))
    )
    enough = study.modes.tolerance / factor
    least = AT_POINTS * bending_degree(study) if _any(port, _between_points) else 0.0
    return next((n for n in DEGREES if n >= least and expected_change(study, n) <= enough), DEGREES[-1])


def _any(port: PortChoice, kind: Callable[[PortChoice], bool]) -> bool:
    """Whether a port, or one of several, is of a kind."""
    return any(map(kind, port.ports.values() if isinstance(port, SeveralPorts) else [port]))


def _within_shell(port: PortChoice) -> bool:
    """Whether a port moves with the shell alone."""
    if isinstance(port, ShellPort):
        return port.against == "frame"
    return port == "volume" or isinstance(port, BetweenPort | DistributedPort | StrainPort)


def _at_ring(port: PortChoice) -> bool:
    """Whether a port acts at a ring of the shell; it moves with the shell alone where heave is held."""
    return isinstance(port, ShellPort)


def _between_points(port: PortChoice) -> bool:
    """Whether a port acts between two points, or rings, of the shell."""
    return isinstance(port, BetweenPort)


def _turns(port: PortChoice) -> bool:
    """Whether a port moves with surge or pitch."""
    return port in ("surge", "pitch") or isinstance(port, LinePort)
