"""The degree of the shell modes that a tolerance asks for, from the stiffness of the wall alone. Pure Python."""

import math

from vsb.engine.motion.take_off import BetweenPort, DistributedPort, PortChoice, SeveralPorts, StrainPort
from vsb.study.sections import DEGREES
from vsb.study.specs import AnyBuoy

WITHIN = 4.0
"""Change of the power of a port within the shell over that of a port that heaves, in terms of the wall's stiffness over
rho g [-]."""
MARGIN = 2.0
"""Over the change that is expected, 0.3 to 2.5 times of which was found of stiff spheres [-]."""
SOFT = 8.0
"""Stiffness of a wall about which its shapes resonate in waves, which magnifies what is left out, over rho g [-]."""


def wall_stiffness(study: AnyBuoy, degree: int) -> float:
    """Return the stiffness per unit area k_n of a wall against a load of a Legendre degree, over rho g [-].

    k_n = (E h + T n(n+1) + D n^2 (n+1)^2/r^2)/r^2, by its membrane, by the tension T = p r/2 of an internal pressure,
    and by bending, D = E h^3/12(1 - nu^2).
    """
    device, water, rest = study.device, study.water, study.device.meridian
    r = device.radius if rest is None else max(device.radius, rest.highest, -rest.lowest)
    membrane, turns = device.young_modulus * device.thickness, degree * (degree + 1)
    bending = membrane * device.thickness**2 / (12 * (1 - device.poisson_ratio**2))
    tension = max(device.internal_pressure, 0.0) * r / 2
    return (membrane + tension * turns + bending * turns**2 / r**2) / r**2 / (water.density * water.gravity)


def expected_change(study: AnyBuoy, degree: int) -> float:
    """Return the change of mean power by all shell modes above a degree that is to be expected, relative [-].

    Waves press on the wet part of the wall. Of such a load the Legendre degree n falls like n^-3/2, and the wall yields
    to it by 1/k_n, so that what degrees above n do is about rho g/(k_n n^1.4).
    """
    return 1 / (wall_stiffness(study, degree) * math.pow(degree, 1.4))


def degree_needed(study: AnyBuoy) -> int:
    """Return the least of `DEGREES` that is expected to leave out no more than `modes.tolerance`, or the highest.

    A wall as soft as the water resonates in waves; where the port lies within the shell, all power comes from what the
    wall yields. How much is left out is measured afterwards (`vsb.results.left_out`).
    """
    stiffness = wall_stiffness(study, 2)
    factor = MARGIN * (1 + SOFT / stiffness + (WITHIN * stiffness if _within_shell(study.pto.port) else 0.0))
    enough = study.modes.tolerance / factor
    return next((degree for degree in DEGREES if expected_change(study, degree) <= enough), DEGREES[-1])


def _within_shell(port: PortChoice) -> bool:
    """Whether a port, or one of several, moves with the shell alone."""
    if isinstance(port, SeveralPorts):
        return any(map(_within_shell, port.ports.values()))
    return port == "volume" or isinstance(port, BetweenPort | DistributedPort | StrainPort)
