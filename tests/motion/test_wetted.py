"""Compiled forces on the wet sphere against the plain implementation, energy and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.motion.wetted import WetShell
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import mode_basis, rigid_basis

ONE_DIP = {"Bending6": -0.4}  # with the centre at -1.7 m the top pole dips under and a ring stays out


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


def amplitudes(basis, **by_label):
    return np.array([by_label.get(label, 0.0) for label in basis.labels])


def compiled(basis, height, q):
    static, uniform, moment = WetShell(basis, height).forces(q[None])
    return static[0], uniform[0], moment[0]


def uniform_twin(basis, height, q, points=120):
    """-int n.psi dS over the wet shell, in colatitude."""
    shell = DeformedShell(basis, height, q)

    def integrand(m):
        return m.x * (-m.dz * m.shape_x + m.dx * m.shape_z)

    return np.broadcast_to(-2 * np.pi * shell._wet_integral(integrand, points), len(q))


@settings(max_examples=20)
@given(st.lists(st.floats(-0.08, 0.08), min_size=12, max_size=12), st.floats(-2.6, 2.6))
def test_compiled_and_plain_forces_agree(full, modal, height):
    q = np.array([0.1, *modal])
    static, uniform, _ = compiled(full, height, q)
    assert static == pytest.approx(DeformedShell(full, height, q).hydrostatic_force(1.0, 1.0, 120), abs=2e-11)
    assert uniform == pytest.approx(uniform_twin(full, height, q), abs=2e-11)


@pytest.mark.parametrize("height", [-1.72, -1.7, -1.66, -1.6, -1.5])
def test_several_waterlines(full, height):
    q = amplitudes(full, **ONE_DIP)
    static, uniform, _ = compiled(full, height, q)
    assert static == pytest.approx(DeformedShell(full, height, q).hydrostatic_force(1.0, 1.0, 200), abs=1e-11)
    assert uniform == pytest.approx(uniform_twin(full, height, q, 200), abs=1e-11)


def test_shallow_dimple_is_resolved(full):
    """The wet area grows as the square root of the depth; the force is continuous."""
    q = amplitudes(full, Membrane4=0.7)  # a dimple round the raised pole, its rim above it
    phi = np.linspace(0.0, 1.2, 20_001)
    z = DeformedShell(full, 0.0, q).meridian(phi).z
    dimple = np.flatnonzero((z[1:-1] < z[:-2]) & (z[1:-1] < z[2:]))[0] + 1
    touching = -z[dimple]
    depths = np.array([1e-8, 1e-7, 1e-6, 1e-5])
    wet = [compiled(full, touching - depth, q)[1] - compiled(full, touching + 1e-12, q)[1] for depth in depths]
    sizes = np.abs(wet).max(axis=1)
    assert np.all(sizes > 0)
    slopes = np.diff(np.log(sizes)) / np.diff(np.log(depths))
    assert np.all(np.abs(slopes - 0.5) < 0.05), slopes


def test_uniform_pressure_acts_on_the_waterplane(full):
    q = amplitudes(full, Membrane2=0.05)
    shell = DeformedShell(full, 0.4, q)
    ((start, _),) = shell.wet_segments
    assert compiled(full, 0.4, q)[1][0] == pytest.approx(np.pi * shell.meridian(np.array([start])).x[0] ** 2, rel=1e-12)
    assert compiled(full, -2.6, q)[1][0] == pytest.approx(0.0, abs=1e-12)
    assert np.all(compiled(full, 2.6, q)[1] == 0.0)


def test_rigid_hemisphere(seed):
    static, uniform, moment = compiled(rigid_basis(seed.device), 0.0, np.zeros(1))
    assert static[0] == pytest.approx(2 / 3 * np.pi * 8, rel=1e-14)
    assert uniform[0] == pytest.approx(4 * np.pi, rel=1e-14)
    assert moment == pytest.approx(-np.pi * 16 / 4, rel=1e-14)  # -pi r^4/4
