"""Strains and rotation of a shell by its modes."""

import numpy as np

from vsb.shell.legendre import legendre
from vsb.shell.modes import ModeBasis
from vsb.shell.ritz import strains
from vsb.tools.arrays import FloatArray


def strain_shapes(basis: ModeBasis, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return linear meridional and hoop strain and rotation per unit amplitude, each shape (dof, point) [1/m].

    e_phi = (u' + v)/r, e_theta = (u cot phi + v)/r, beta = (v' - u)/r. By Legendre's equation
    u cot phi = -n(n+1) U P_n - u', which holds at the poles too and makes all three exactly zero for rigid heave. On
    another meridian, between its poles, those of `vsb.shell.ritz`.
    """
    if basis.shell.rest is not None:
        found, shapes = strains(basis.shell.rest, basis.highest_degree, colatitude), basis.displacements
        return shapes @ found.meridional, shapes @ found.hoop, shapes @ found.rotation
    p, dp, ddp = (table[list(basis.degrees)] for table in legendre(basis.highest_degree, colatitude))
    radial, meridional = np.array([[mode.radial, mode.meridional] for mode in basis.shapes]).T[:, :, None]
    n, r = np.array(basis.degrees)[:, None], basis.shell.radius
    hoop = (radial - n * (n + 1) * meridional) * p - meridional * ddp
    return (radial * p + meridional * ddp) / r, hoop / r, (radial - meridional) * dp / r
