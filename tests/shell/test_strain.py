import numpy as np
import pytest
from shell.test_sphere import STRETCH, larger

from vsb.shell.deformed import DeformedShell
from vsb.shell.mode import natural_shapes
from vsb.shell.modes import ModeBasis
from vsb.shell.sphere import Shell
from vsb.shell.strain import strain_shapes
from vsb.study.meridian import RestMeridian, capsule, spheroid

EGG = RestMeridian((2.0,), (0.3, 2.2, 0.1, 0.05))  # unlike above and below
SHELLS = [Shell(2.0, 0.01, 10e6, 0.3, 2700.0, body) for body in (None, spheroid(2.0, 3.0), capsule(2.0, 1.0), EGG)]
PHI = np.linspace(0.1, 3.0, 9)


@pytest.mark.parametrize("shell", SHELLS)
def test_strains_are_those_of_the_deformed_meridian(shell):
    """Linear strains and rotation, by differences of the deformed lengths, radii and angles."""
    basis = ModeBasis(shell, natural_shapes(shell, 5), 3000.0, bending=True)
    rest = DeformedShell(basis, 0.0).meridian(PHI)
    for dof, (e, t, b) in enumerate(zip(*strain_shapes(basis, PHI), strict=True)):
        q = 1e-6 * np.eye(len(basis.labels))[dof]
        there, back = (DeformedShell(basis, 0.0, sign * q).meridian(PHI) for sign in (1, -1))
        lengths = [np.log(np.hypot(m.dx, m.dz)) for m in (there, back)]
        angles = [np.arctan2(m.dz * rest.dx - m.dx * rest.dz, m.dx * rest.dx + m.dz * rest.dz) for m in (there, back)]
        assert (lengths[0] - lengths[1]) / 2e-6 == pytest.approx(e, abs=1e-7)
        assert (np.log(there.x) - np.log(back.x)) / 2e-6 == pytest.approx(t, abs=1e-7)
        assert (angles[0] - angles[1]) / 2e-6 == pytest.approx(b, abs=1e-7)


@pytest.mark.parametrize("shell", SHELLS)
def test_heave_strains_nothing(shell):
    basis = ModeBasis(shell, natural_shapes(shell, 3), 3000.0, bending=True)
    assert all(np.abs(part[0]).max() < 1e-13 for part in strain_shapes(basis, PHI))


@pytest.mark.parametrize("shell", SHELLS)
def test_a_larger_shell_is_strained_less_by_the_same_displacement(shell):
    modes = natural_shapes(shell, 4)
    small, large = (ModeBasis(each, modes, 3000.0, bending=True) for each in (shell, larger(shell)))
    for one, other in zip(strain_shapes(small, PHI), strain_shapes(large, PHI), strict=True):
        np.testing.assert_allclose(STRETCH * other, one, rtol=1e-10, atol=1e-12)
