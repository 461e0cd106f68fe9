"""How finely to resolve: frequencies, instants, and rows of panels by tolerance, mode and wave. Pure Python."""

import math

ROWS_PER_HALF_WAVE = 6
RECORDS_PER_PERIOD = 200
"""Instants recorded per period of the shortest wave that matters."""
LEG = 2**17
"""Instants followed at one time."""
KEPT, THINNEST = 2**17, 10
"""A run of more instants than that keeps a part of them, a tenth at least: 20 a period."""


def frequency_step(radius: float, gravity: float) -> float:
    """Return the step of the absolute frequency grid [rad/s]: the largest 1-2-5 number below 0.05 sqrt(g/r).

    The coefficients vary on the scale sqrt(g/r); with a fixed, round step, studies of different omega_max share
    blocks.
    """
    bound = 0.05 * math.sqrt(gravity / radius)
    decade = 10.0 ** math.floor(math.log10(bound))
    return float(f"{max(m * decade for m in (1, 2, 5) if m * decade <= bound):.0e}")


def tolerance_rows(tolerance: float) -> int:
    """Return the panel rows that bring the error of A and B below a tolerance.

    Measured on the floating hemisphere (modes P_0..P_6, Ka <= 3): 40 rows 8e-4, second order.
    """
    return 2 * math.ceil(20 * math.sqrt(1e-3 / tolerance))


def mode_rows(degree: int) -> int:
    """Return the rows that put eight of them on every lobe of the highest mode, degree/2 lobes on the wetted shell."""
    return 4 * degree


def wave_rows(radius: float, wavelength: float) -> int:
    """Return the rows that put `ROWS_PER_HALF_WAVE` of them within half a wavelength of the surface.

    Rows are graded as colatitude = pi/2 (2 - cos(pi s/2)), so depth d is passed at s = 2/pi acos(1 - 2/pi asin(d/r)).
    """
    depth = min(wavelength / 2 / radius, 1.0)
    passed = 2 / math.pi * math.acos(1 - 2 / math.pi * math.asin(depth))
    return 2 * math.ceil(ROWS_PER_HALF_WAVE / passed / 2)


def thinning(instants: int) -> int:
    """Return every how many instants a run of so many is recorded."""
    return min(THINNEST, math.ceil(instants / KEPT))
