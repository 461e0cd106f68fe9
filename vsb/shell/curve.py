"""A closed meridian at some of its angles."""

from typing import NamedTuple

import numpy as np

from vsb.study.meridian import RestMeridian
from vsb.tools.units import FloatArray


class Curve(NamedTuple):
    """Radius and height of a meridian at some angles phi, and their derivatives by phi, each shape (point,) [m]."""

    x: FloatArray
    z: FloatArray
    dx: FloatArray
    dz: FloatArray


def curve(meridian: RestMeridian, phi: FloatArray) -> Curve:
    """Return a meridian at angles, shape (point,) [rad]."""
    (a, j), (b, k) = _numbered(meridian)
    up, down = np.cos(np.outer(k, phi)), np.sin(np.outer(k, phi))
    return Curve(a @ np.sin(np.outer(j, phi)), b @ up, (j * a) @ np.cos(np.outer(j, phi)), -(k * b) @ down)


def bend(meridian: RestMeridian, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the second derivatives of radius and height by the angle, each shape (point,) [m]."""
    (a, j), (b, k) = _numbered(meridian)
    return -(j**2 * a) @ np.sin(np.outer(j, phi)), -(k**2 * b) @ np.cos(np.outer(k, phi))


def _numbered(meridian: RestMeridian) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Terms of radius and height, each with its number."""
    a, b = np.array(meridian.radial), np.array(meridian.axial)
    return (a, np.arange(1.0, len(a) + 1)), (b, np.arange(float(len(b))))
