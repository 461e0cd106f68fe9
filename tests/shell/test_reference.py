"""The shell a study is linearised about: amplitudes counted from the sphere, stiffness by name."""

import numpy as np
import pytest

from vsb.scenes.rest import study_basis
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, shell_modes
from vsb.shell.reference import ReferenceShell
from vsb.shell.sphere import Shell
from vsb.study.meridian import capsule


def test_an_undeformed_shell_has_amplitudes_of_zero_and_a_deformed_one_its_own(seed):
    basis = study_basis(seed)
    size = len(basis.labels)
    assert ReferenceShell(DeformedShell(basis, 0.0), {}).modal_amplitude.tolist() == [0.0] * size
    moved = np.linspace(0.0, 0.1, size)
    reference = ReferenceShell(DeformedShell(basis, 0.0, moved), {})
    assert reference.modal_amplitude is moved
    assert reference.basis is basis


def test_the_total_is_the_sum_of_what_there_is(seed):
    parts = {"structural": np.diag([0.0, 2.0]), "hydrostatic": np.array([[1.0, 0.5], [0.5, 3.0]]), "gas": np.eye(2)}
    reference = ReferenceShell(DeformedShell(study_basis(seed), 0.0), parts)
    np.testing.assert_array_equal(reference.total, [[2.0, 0.5], [0.5, 6.0]])


@pytest.mark.parametrize("heave", [0.0, -0.3])
def test_the_keel_is_a_radius_below_the_centre(seed, heave):
    basis = study_basis(seed)
    shape = DeformedShell(basis, 0.4, heave * np.eye(len(basis.labels))[0])
    assert ReferenceShell(shape, {}).keel_depth == pytest.approx(2.0 - 0.4 - heave)


@pytest.mark.parametrize("radius", [0.8, 3.0])
def test_the_keel_of_a_shell_that_is_swollen_lies_deeper(radius):
    shell = Shell(radius, 0.01, 1e7, 0.3, 2700.0)
    basis = ModeBasis(shell, shell_modes(shell, "full", 2), 1e4, bending=True)
    q = np.array([{"Heave": 0.1, "Membrane0": 0.05}.get(label, 0.0) for label in basis.labels])
    reference = ReferenceShell(DeformedShell(basis, 0.2, q), {})
    assert reference.keel_depth == pytest.approx(radius + 0.05 - 0.2 - 0.1, rel=1e-12)
    capsuled = Shell(radius, 0.01, 1e7, 0.3, 2700.0, capsule(radius, 1.0).scaled(1.0, 1.0, 0.3))
    rest = ReferenceShell(DeformedShell(ModeBasis(capsuled, (), 1e4, False), 0.2), {})
    assert rest.keel_depth == pytest.approx(radius + 0.5 - 0.2 - 0.3, rel=1e-6)
