import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.modes import mode_basis
from vsb.surface import DeformedShell

RHO, G = 1025.0, 9.81


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


def amplitudes(full, **by_label):
    return np.array([by_label.get(label, 0.0) for label in full.labels])


@pytest.mark.parametrize("height", [-1.5, -0.3, 0.0, 0.7, 1.9])
def test_cap_of_a_sphere(full, height):
    shell, depth = DeformedShell(full, height), 2.0 - height
    assert shell.volume() == pytest.approx(np.pi * depth**2 * (6.0 - depth) / 3, rel=1e-12)
    assert shell.wet_area() == pytest.approx(2 * np.pi * 2.0 * depth, rel=1e-12)


def test_breathing_is_a_larger_sphere(full):
    larger = DeformedShell(full, 0.4, amplitudes(full, Membrane0=0.3))
    depth = 2.3 - 0.4
    assert larger.volume() == pytest.approx(np.pi * depth**2 * (6.9 - depth) / 3, rel=1e-12)


def test_dry_submerged_and_several_waterlines(full):
    assert DeformedShell(full, 2.5).wet_segments == []
    assert DeformedShell(full, 2.5).volume() == 0.0
    assert np.all(DeformedShell(full, 2.5).hydrostatic_force(RHO, G) == 0.0)
    assert DeformedShell(full, -2.5).wet_segments == [(0.0, np.pi)]
    assert DeformedShell(full, -2.5).volume() == pytest.approx(4 / 3 * np.pi * 8, rel=1e-12)
    dented = DeformedShell(full, -1.7, amplitudes(full, Bending6=-0.4))  # the top pole dips under, a ring stays out
    assert len(dented.wet_segments) == 2


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-0.05, 0.05), min_size=12, max_size=12), st.floats(-0.8, 0.8))
def test_buoyancy_is_the_weight_of_displaced_water(full, modal, height):
    """Archimedes for any deformed shape."""
    shell = DeformedShell(full, height, np.array([0.0, *modal]))
    assert shell.hydrostatic_force(RHO, G)[0] == pytest.approx(RHO * G * shell.volume(), rel=1e-10)


@pytest.mark.parametrize("height", [-0.6, 0.0, 0.00031, 0.9])
@pytest.mark.parametrize("deformed", [False, True])
def test_stiffness_is_the_exact_symmetric_jacobian(full, height, deformed):
    start = np.array([0.02, -0.03, 0.04, *np.linspace(-0.05, 0.05, 10)]) * deformed

    def force(q):
        return DeformedShell(full, height, q).hydrostatic_force(RHO, G)

    def central(j, h):
        return (force(start + h * np.eye(13)[j]) - force(start - h * np.eye(13)[j])) / (2 * h)

    stiffness = DeformedShell(full, height, start).hydrostatic_stiffness(RHO, G)
    largest = np.abs(stiffness).max()
    assert np.abs(stiffness - stiffness.T).max() < 1e-11 * largest
    h = 2e-3
    richardson = np.array([
        (64 * central(j, h / 4) - 20 * central(j, h / 2) + central(j, h)) / 45 for j in range(13)
    ]).T  # fmt: skip
    assert np.abs(stiffness + richardson).max() < 1e-9 * largest


def test_heave_stiffness_is_that_of_the_waterplane(full):
    stiffness = DeformedShell(full, 0.5).hydrostatic_stiffness(RHO, G)
    assert stiffness[0, 0] == pytest.approx(RHO * G * np.pi * (4.0 - 0.25), rel=1e-12)


def test_quadrature_converges_spectrally(full):
    shell = DeformedShell(full, 0.1, amplitudes(full, Membrane2=0.1, Bending4=-0.08))
    exact = shell.volume(120)
    errors = [abs(shell.volume(n) / exact - 1) for n in (6, 10, 14, 18, 40)]
    assert errors[-1] < 1e-12
    assert errors[0] > 100 * errors[1] > 1e4 * errors[3]
