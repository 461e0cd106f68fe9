"""A closed meridian at some of its angles."""

import math
from typing import NamedTuple

import numpy as np

from vsb.study.meridian import RestMeridian
from vsb.tools.arrays import ComplexArray, FloatArray


class Curve(NamedTuple):
    """Radius and height of a meridian at some angles phi, and their derivatives by phi, each shape (point,) [m]."""

    x: FloatArray
    z: FloatArray
    dx: FloatArray
    dz: FloatArray


def curve(meridian: RestMeridian, phi: FloatArray) -> Curve:
    """Return a meridian at angles, shape (point,) [rad]."""
    (a, j), (b, k) = _numbered(meridian)
    radial, slope = _sums(np.concatenate([np.zeros((2, 1)), np.array([a, j * a])], axis=1), phi)
    axial, fall = _sums(np.array([b, k * b]), phi)
    return Curve(radial.imag, axial.real, slope.real, -fall.imag)


def _sums(coefficients: FloatArray, phi: FloatArray) -> ComplexArray:
    """Sums c_k exp(i k phi) over k = 0, 1, ... of several series (series, term), shape (series, point).

    With k = m w + r it is sum_m exp(i m w phi) sum_r c_mr exp(i r phi): two short tables of exponentials and a product
    of matrices in place of one exponential for each term and point; long capsules have hundreds of terms.
    """
    series, terms = coefficients.shape
    width = math.isqrt(terms - 1) + 1
    rows = -(-terms // width)
    padded = np.zeros((series, rows * width))
    padded[:, :terms] = coefficients
    near, far = (np.exp(1j * np.outer(step * np.arange(count), phi)) for step, count in ((1, width), (width, rows)))
    inner = (padded.reshape(series * rows, width) @ near).reshape(series, rows, len(phi))
    return np.asarray((inner * far).sum(axis=1))


def bend(meridian: RestMeridian, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the second derivatives of radius and height by the angle, each shape (point,) [m]."""
    (a, j), (b, k) = _numbered(meridian)
    return -(j**2 * a) @ np.sin(np.outer(j, phi)), -(k**2 * b) @ np.cos(np.outer(k, phi))


def _numbered(meridian: RestMeridian) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Terms of radius and height, each with its number."""
    a, b = np.array(meridian.radial), np.array(meridian.axial)
    return (a, np.arange(1.0, len(a) + 1)), (b, np.arange(float(len(b))))
