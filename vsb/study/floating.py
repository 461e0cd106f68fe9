"""A sphere afloat: the cap of it under water. Pure Python."""

import math


def cap_volume(radius: float, height: float) -> float:
    """Return the volume of a spherical cap, pi h^2 (3r - h)/3, its height in radii [m^3]."""
    return math.pi * height**2 * (3 - height) / 3 * radius**3


def floating_height(radius: float, volume: float) -> float:
    """Return the height of the centre at which the immersed cap, pi h^2 (3r - h)/3, has the given volume."""
    low, high = 0.0, 2 * radius
    while high - low > 1e-15 * radius:
        h = 0.5 * (low + high)
        if h in (low, high):
            break
        low, high = (h, high) if math.pi * h * h * (3 * radius - h) / 3 < volume else (low, h)
    return radius - 0.5 * (low + high)
