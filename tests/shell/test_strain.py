"""Linear strains of shells of revolution."""

import numpy as np
import pytest

from vsb.shell.deformed import DeformedShell
from vsb.shell.mode import natural_shapes
from vsb.shell.modes import ModeBasis
from vsb.shell.sphere import Shell
from vsb.shell.strain import strain_shapes
from vsb.study.meridian import RestMeridian, capsule, spheroid

EGG = RestMeridian((2.0,), (0.3, 2.2, 0.1, 0.05))  # unlike above and below
SHELLS = [
    Shell(body.radius if body else 1.7, 0.01, 10e6, 0.3, 2700.0, body)
    for body in (None, spheroid(2.0, 3.0), capsule(0.8, 1.0), EGG)
]
PHI = np.linspace(0.1, 3.0, 9)


@pytest.mark.parametrize("shell", SHELLS)
def test_strains_match_differences_of_the_deformed_meridian(shell):
    """Changes of lengths, radii and angles by central differences."""
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
def test_heave_has_no_strain(shell):
    basis = ModeBasis(shell, natural_shapes(shell, 3), 3000.0, bending=True)
    assert all(np.abs(part[0]).max() < 1e-13 for part in strain_shapes(basis, PHI))
