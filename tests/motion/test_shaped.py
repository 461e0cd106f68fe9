"""Compiled forces on wet shells of any meridian."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0

from vsb.motion.froude_krylov import incident, rotated, wave_force
from vsb.motion.wetted import ShapedWetShell, WetShell, wet_shell
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, mode_basis, natural_shapes
from vsb.shell.shell import Shell
from vsb.study.meridian import RestMeridian, capsule, spheroid
from vsb.waves.seas import Sea

G, OMEGA = 9.81, 2.0
K = OMEGA**2 / G


def basis_of(meridian, degree=3):
    shell = Shell(meridian.radius, 0.005, 1e7, 0.3, 2700.0, meridian)
    return ModeBasis(shell, natural_shapes(shell, degree), 1e4, bending=True)


BODIES = [spheroid(2.0, 3.0), spheroid(1.5, 6.0), capsule(1.0, 1.0), RestMeridian((1.0, 0.1), (0.0, 1.2, -0.05))]


@pytest.mark.parametrize("meridian", BODIES)
def test_compiled_and_plain_forces_agree(meridian):
    basis = basis_of(meridian)
    for height in (-0.6, 0.0, 0.4):
        q = np.concatenate([[0.05], 0.03 * np.cos(np.arange(1.0, 7.0))])
        static, uniform, _ = (part[0] for part in wet_shell(basis, height).forces(q[None]))
        shell = DeformedShell(basis, height, q)
        assert static == pytest.approx(shell.hydrostatic_force(1.0, 1.0, 120), abs=1e-10)
        plain = -2 * np.pi * shell._wet_integral(lambda m: m.x * (-m.dz * m.shape_x + m.dx * m.shape_z), 120)
        assert uniform == pytest.approx(plain, abs=1e-10)


def test_spherical_spheroid_equals_the_sphere(seed):
    """The same polynomials from terms and by interpolation."""
    device = seed.device
    sphere = mode_basis(device, "full", 4)
    ball = ModeBasis(Shell(*(getattr(sphere.shell, name) for name in
                             ("radius", "thickness", "young_modulus", "poisson_ratio", "density")),
                           spheroid(2.0, 4.0)), sphere.modes, device.mass, bending=True)  # fmt: skip
    one, other = WetShell(sphere, 0.3).shape, wet_shell(ball, 0.3).shape
    for name in one._fields:
        assert getattr(other, name) == pytest.approx(getattr(one, name), abs=1e-13), name
    assert type(wet_shell(sphere, 0.3)) is WetShell
    assert type(wet_shell(ball, 0.3)) is ShapedWetShell


def test_dry_submerged_and_floating_spheroid():
    """Closed form: the affine image of the spherical cap."""
    basis = basis_of(spheroid(2.0, 3.0))
    q = np.zeros((1, 7))
    volume = 4 / 3 * np.pi * 4 * 1.5
    assert wet_shell(basis, 2.0).forces(q)[0][0, 0] == 0.0
    assert wet_shell(basis, -2.0).forces(q)[0][0, 0] == pytest.approx(volume, rel=1e-12)
    h = 1.0  # immersed, of 3
    cap = 0.75 * np.pi * (h / 0.75) ** 2 * (6 - h / 0.75) / 3
    assert wet_shell(basis, 0.5).forces(q)[0][0, 0] == pytest.approx(cap, rel=1e-12)


@pytest.mark.parametrize("meridian", BODIES[:2])
def test_small_waves_give_the_linear_froude_krylov_force(meridian):
    """Heave of half a spheroid, int J_0(kx) e^(kz) n_z dS; the error is of second order in the amplitude."""
    a, b = meridian.radial[0], meridian.axial[1]
    exact = -2 * np.pi * quad(
        lambda c: j0(K * a * np.sqrt(1 - c * c)) * np.exp(K * b * c) * a**2 * c, -1, 0, epsabs=1e-13
    )[0]  # fmt: skip
    basis = basis_of(meridian)
    shape, q, errors = wet_shell(basis, 0.0).shape, np.zeros(7), []
    for amplitude in (0.04, 0.02):
        waves = incident(Sea(np.array([OMEGA]), np.array([amplitude + 0j])), np.inf, G, basis.shell.reach)
        crest, trough = np.empty(7), np.empty(7)
        wave_force(shape, q, waves, rotated(waves, 0.0), crest)
        wave_force(shape, q, waves, rotated(waves, np.pi / OMEGA), trough)
        errors.append(abs((crest - trough)[0] / (2 * amplitude) - exact))
    assert errors[0] < 5e-3 * exact
    assert 3.0 < errors[0] / errors[1] < 5.0
