"""Compiled forces on the wet shell against the plain implementation, energy and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.motion.wetted import WetShell
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.meridian import RestMeridian, capsule, spheroid
from vsb.engine.shell.modes import ModeBasis, mode_basis, natural_shapes
from vsb.engine.shell.shell import Shell

ONE_DIP = {"Bending6": -0.4}  # with the centre at -1.7 m the top pole dips under and a ring stays out


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


def amplitudes(basis, **by_label):
    return np.array([by_label.get(label, 0.0) for label in basis.labels])


def compiled(basis, height, q):
    static, uniform, moment = WetShell(basis, height).forces(q[None])
    return static[0], uniform[0], moment[0]


def wet_integral(shell, integrand, points):
    """Integral over the wet meridian; 0 of a dry shell."""
    return sum((integrand(shell.meridian(phi)) @ weight for phi, weight in shell._wet_points(points)), 0.0)


def uniform_twin(basis, height, q, points=120):
    """-int n.psi dS over the wet shell, in colatitude."""
    shell = DeformedShell(basis, height, q)

    def integrand(m):
        return m.x * (-m.dz * m.shape_x + m.dx * m.shape_z)

    return np.broadcast_to(-2 * np.pi * wet_integral(shell, integrand, points), len(q))


@settings(max_examples=20)
@given(st.lists(st.floats(-0.08, 0.08), min_size=12, max_size=12), st.floats(-2.6, 2.6))
def test_compiled_and_plain_forces_agree(full, modal, height):
    q = np.array([0.1, *modal])
    static, uniform, _ = compiled(full, height, q)
    assert static == pytest.approx(DeformedShell(full, height, q).hydrostatics(1.0, 1.0, 120)[0], abs=2e-11)
    assert uniform == pytest.approx(uniform_twin(full, height, q), abs=2e-11)


@pytest.mark.parametrize("height", [-1.72, -1.6])
def test_several_waterlines(full, height):
    q = amplitudes(full, **ONE_DIP)
    static, uniform, _ = compiled(full, height, q)
    assert static == pytest.approx(DeformedShell(full, height, q).hydrostatics(1.0, 1.0, 200)[0], abs=1e-11)
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


def basis_of(meridian, degree=3):
    shell = Shell(meridian.radius, 0.005, 1e7, 0.3, 2700.0, meridian)
    return ModeBasis(shell, natural_shapes(shell, degree), 1e4, bending=True)


BODIES = [
    (spheroid(2.0, 3.0), 1e-10),
    (spheroid(1.5, 6.0), 1e-10),
    (capsule(1.0, 1.0), 1e-4),  # of whose series the compiled loops know the first terms
    (RestMeridian((1.0, 0.1), (0.0, 1.2, -0.05)), 1e-10),
]


@pytest.mark.parametrize(("meridian", "apart"), BODIES)
def test_compiled_and_plain_forces_of_any_meridian_agree(meridian, apart):
    basis = basis_of(meridian)
    for height in (-0.6, 0.0, 0.4):
        q = np.concatenate([[0.05], 0.03 * np.cos(np.arange(1.0, 7.0))])
        static, uniform, _ = (part[0] for part in WetShell(basis, height).forces(q[None]))
        shell = DeformedShell(basis, height, q)
        assert static == pytest.approx(shell.hydrostatics(1.0, 1.0, 120)[0], abs=apart)
        plain = -2 * np.pi * wet_integral(shell, lambda m: m.x * (-m.dz * m.shape_x + m.dx * m.shape_z), 120)
        assert uniform == pytest.approx(plain, abs=apart)


def test_dry_submerged_and_floating_spheroid():
    """Closed form: the affine image of the spherical cap."""
    basis = basis_of(spheroid(2.0, 3.0))
    q = np.zeros((1, 7))
    volume = 4 / 3 * np.pi * 4 * 1.5
    assert WetShell(basis, 2.0).forces(q)[0][0, 0] == 0.0
    assert WetShell(basis, -2.0).forces(q)[0][0, 0] == pytest.approx(volume, rel=1e-12)
    h = 1.0  # immersed, of 3
    cap = 0.75 * np.pi * (h / 0.75) ** 2 * (6 - h / 0.75) / 3
    assert WetShell(basis, 0.5).forces(q)[0][0, 0] == pytest.approx(cap, rel=1e-12)
