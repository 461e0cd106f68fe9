"""The shell a study is linearised about."""

import numpy as np
import pytest

from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, shell_modes
from vsb.shell.reference import ReferenceShell
from vsb.shell.sphere import Shell
from vsb.study.meridian import capsule


@pytest.mark.parametrize("radius", [0.8, 3.0])
def test_keel_depth_of_a_deformed_shell_and_of_a_capsule(radius):
    shell = Shell(radius, 0.01, 1e7, 0.3, 2700.0)
    basis = ModeBasis(shell, shell_modes(shell, "full", 2), 1e4, bending=True)
    q = np.array([{"Heave": 0.1, "Membrane0": 0.05}.get(label, 0.0) for label in basis.labels])
    reference = ReferenceShell(DeformedShell(basis, 0.2, q), {})
    assert reference.keel_depth == pytest.approx(radius + 0.05 - 0.2 - 0.1, rel=1e-12)
    capsuled = Shell(radius, 0.01, 1e7, 0.3, 2700.0, capsule(radius, 1.0).scaled(1.0, 1.0, 0.3))
    rest = ReferenceShell(DeformedShell(ModeBasis(capsuled, (), 1e4, False), 0.2), {})
    assert rest.keel_depth == pytest.approx(radius + 0.5 - 0.2 - 0.3, rel=1e-6)
