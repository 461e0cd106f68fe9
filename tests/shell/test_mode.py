"""Mode shapes: normalisation, order and symmetry."""

import numpy as np
import pytest

from vsb.shell.legendre import legendre
from vsb.shell.mode import natural_shapes, scaled
from vsb.shell.modes import ModeBasis
from vsb.shell.sphere import Shell
from vsb.study.meridian import spheroid

OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))


def test_natural_shapes_are_normalised_and_ordered_by_frequency():
    modes = natural_shapes(OBLATE, 6)
    basis = ModeBasis(OBLATE, modes, 3000.0, bending=True)
    v, u = basis.displacement(np.linspace(0.0, np.pi, 4001))
    assert [mode.label for mode in modes] == [f"Shell{i}" for i in range(1, 13)]
    assert np.hypot(v, u).max(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (v[:, 0] > 0).all()
    assert (np.diff(basis.dry_frequencies) > 0).all()
    assert sorted(mode.parts[0][0] for mode in modes[:3]) == [2, 3, 4]  # as of a sphere's lower branch


def test_symmetric_body_has_even_and_odd_modes():
    basis = ModeBasis(OBLATE, natural_shapes(OBLATE, 6), 3000.0, bending=True)
    phi = np.linspace(0.2, 1.4, 5)
    (above, _), (below, _) = basis.displacement(phi), basis.displacement(np.pi - phi)
    even, odd = (np.abs(above - sign * below).max(axis=1) < 1e-9 for sign in (1, -1))
    assert (even ^ odd).all()


@pytest.mark.parametrize(("radial", "meridional"), [(3.0, 1.0), (-0.2, 0.7), (0.1, -0.4), (-1e-3, -2.0)])
@pytest.mark.parametrize("degree", [1, 2, 5, 9])
def test_shape_of_one_degree_is_normalised_and_outward_at_the_top(degree, radial, meridional):
    mode = scaled("Some", degree, radial, meridional)
    phi = np.linspace(0.0, np.pi, 40001)
    p, dp, _ = legendre(degree, phi)
    largest = np.hypot(mode.radial * p[degree], mode.meridional * dp[degree]).max()
    assert 1 - (degree + 1) ** 4 * phi[1] ** 2 < largest < 1 + 1e-12
    assert mode.radial > 0
    assert mode.meridional / mode.radial == pytest.approx(meridional / radial, rel=1e-13)
    assert (mode.label, mode.degree, mode.others) == ("Some", degree, ())
