"""Volume and area of a shell deformed in shapes of several azimuthal orders; rigid motions change neither."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsb.engine.shell.modes import ModeBasis, strain_shapes
from vsb.engine.shell.orders import OrderBasis
from vsb.engine.shell.shell import gauss_rule
from vsb.tools.arrays import FloatArray

AT_ONCE = 4096
"""Instants at which a surface is drawn at one time: some tens of megabytes."""


class _Shapes(NamedTuple):
    """Displacements per unit amplitude along e_r, e_phi, e_theta and their derivatives, each (dof, point)."""

    value: FloatArray  # (3, dof, point)
    by_colatitude: FloatArray
    by_azimuth: FloatArray


def enclosed_in_orders(
    basis: ModeBasis, orders: Sequence[OrderBasis], amplitudes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the volume a shell encloses [m^3] and its surface area [m^2] along a motion.

    Parameters
    ----------
    amplitudes : ndarray, shape (time, dof) [m]
        Of all degrees of freedom, axisymmetric ones first; rigid ones are without effect.

    Returns
    -------
    volume, area : ndarray, shape (time,)
        int r.N/3 and int |N| over colatitude and azimuth, N = r_phi x r_theta; the volume without error of quadrature.
    """
    highest, order = basis.highest_degree, max((each.order for each in orders), default=0)
    node, weight = gauss_rule(2 * highest + 24)
    count = 4 * order + 8
    phi = np.repeat(np.arccos(node), count)
    theta = np.tile(2 * np.pi * np.arange(count) / count, len(node))
    area = np.repeat(weight, count) / np.sin(phi) * 2 * np.pi / count
    shapes = _tabulated(basis, orders, phi, theta)
    parts = [
        _enclosed(basis.shell.radius, shapes, np.asarray(part), phi, area)
        for part in np.array_split(amplitudes, max(1, -(-len(amplitudes) // AT_ONCE)))
    ]
    volume, surface = zip(*parts, strict=True)
    return np.concatenate(volume), np.concatenate(surface)


def _tabulated(basis: ModeBasis, orders: Sequence[OrderBasis], phi: FloatArray, theta: FloatArray) -> _Shapes:
    """Shapes of all degrees of freedom at points, rigid ones zero."""
    v, u = basis.displacement(phi)
    dv, du = basis.displacement(phi, derivative=1)
    none = np.zeros_like(v)
    found = [(np.array([v, u, none]), np.array([dv, du, none]), np.array([none, none, none]))]
    found[0][0][:, 0], found[0][1][:, 0] = 0.0, 0.0  # heave
    for each in orders:
        m, cos, sin = each.order, np.cos(each.order * theta), np.sin(each.order * theta)
        at, slope = np.array(each.field(phi)), np.array(each.field(phi, derivative=1))
        at[:, : each.rigid], slope[:, : each.rigid] = 0.0, 0.0
        if each.odd:  # the same, a quarter of a period further around
            cos, sin = sin, -cos
        around, turned = np.array([cos, cos, sin])[:, None], np.array([-m * sin, -m * sin, m * cos])[:, None]
        found.append((at * around, slope * around, at * turned))
    return _Shapes(*(np.concatenate(part, axis=1) for part in zip(*found, strict=True)))


def _enclosed(
    radius: float, shapes: _Shapes, amplitudes: FloatArray, phi: FloatArray, area: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Volume and area at some instants."""
    sin, cos = np.sin(phi), np.cos(phi)
    v, u, w = (amplitudes @ shape for shape in shapes.value)
    dv, du, dw = (amplitudes @ shape for shape in shapes.by_colatitude)
    tv, tu, tw = (amplitudes @ shape for shape in shapes.by_azimuth)
    out = radius + v
    along = (dv - u, out + du, dw)
    around = (tv - w * sin, tu - w * cos, tw + out * sin + u * cos)
    normal = (
        along[1] * around[2] - along[2] * around[1],
        along[2] * around[0] - along[0] * around[2],
        along[0] * around[1] - along[1] * around[0],
    )
    volume = (out * normal[0] + u * normal[1] + w * normal[2]) @ area / 3
    return volume, np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) @ area


def largest_deformation(basis: ModeBasis, orders: Sequence[OrderBasis], amplitudes: FloatArray) -> tuple[float, float]:
    """Return the largest displacement of the shell relative to its frame [m] and its largest membrane strain [-].

    Parameters
    ----------
    amplitudes : ndarray, shape (dof,) [m]
        Of all degrees of freedom, axisymmetric ones first; rigid ones are without effect.
    """
    grid, around = np.linspace(0.01, np.pi - 0.01, 181), 8 * max((each.order for each in orders), default=0) + 1
    end = np.pi  # even shapes are the same on both sides
    if any(each.odd for each in orders):
        around, end = 2 * around - 1, 2 * np.pi
    phi, theta = np.repeat(grid, around), np.tile(np.linspace(0, end, around), len(grid))
    value, by_colatitude, by_azimuth = (amplitudes @ part for part in _tabulated(basis, orders, phi, theta))
    meridional = by_colatitude[1] + value[0]
    hoop = value[1] / np.tan(phi) + value[0] + by_azimuth[2] / np.sin(phi)
    strain = np.maximum(np.abs(meridional), np.abs(hoop)).max() / basis.shell.radius
    return float(np.sqrt((value**2).sum(axis=0)).max()), float(strain)


def largest_displacement(basis: ModeBasis, modal_amplitude: FloatArray) -> float:
    """Return the largest displacement of the shell relative to its centre [m]."""
    u = basis.displacement(np.linspace(0.0, np.pi, 361))
    modal_amplitude = np.concatenate([[0.0], modal_amplitude[1:]])
    return float(np.hypot(modal_amplitude @ u[0], modal_amplitude @ u[1]).max())


def largest_strain(basis: ModeBasis, modal_amplitude: FloatArray) -> float:
    """Return the largest membrane strain, |(u' + v)/r| or |(u cot phi + v)/r| [-]."""
    strains = strain_shapes(basis, np.linspace(0.01, np.pi - 0.01, 361))[:2]
    return float(np.abs([modal_amplitude[1:] @ strain[1:] for strain in strains]).max())
