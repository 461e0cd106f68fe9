import numpy as np
import pytest

from vsb.shell.mode import Mode, natural_shapes, scaled
from vsb.shell.modes import ModeBasis
from vsb.shell.sphere import Shell
from vsb.study.meridian import spheroid

OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))


def test_a_mode_of_one_degree_has_one_part():
    mode = scaled("Membrane2", 2, -3.0, 1.0)
    assert mode.parts == ((2, mode.radial, mode.meridional),)
    assert mode.radial > 0
    assert Mode("a", 1, 1.0, 1.0, ((2, 0.5, 0.0),)).parts == ((1, 1.0, 1.0), (2, 0.5, 0.0))


def test_natural_shapes_are_scaled_and_ascend():
    modes = natural_shapes(OBLATE, 6)
    basis = ModeBasis(OBLATE, modes, 3000.0, bending=True)
    v, u = basis.displacement(np.linspace(0.0, np.pi, 4001))
    assert [mode.label for mode in modes] == [f"Shell{i}" for i in range(1, 13)]
    assert np.hypot(v, u).max(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (v[:, 0] > 0).all()
    assert (np.diff(basis.dry_frequencies) > 0).all()
    assert sorted(mode.parts[0][0] for mode in modes[:3]) == [2, 3, 4]  # as of a sphere's lower branch


def test_a_body_alike_above_and_below_has_even_and_odd_modes():
    basis = ModeBasis(OBLATE, natural_shapes(OBLATE, 6), 3000.0, bending=True)
    phi = np.linspace(0.2, 1.4, 5)
    (above, _), (below, _) = basis.displacement(phi), basis.displacement(np.pi - phi)
    even, odd = (np.abs(above - sign * below).max(axis=1) < 1e-9 for sign in (1, -1))
    assert (even ^ odd).all()
