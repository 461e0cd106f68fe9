import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.integrate import quad
from scipy.special import j0

from vsb.motion.froude_krylov import incident, rotated, wave_force
from vsb.motion.shaped import ShapedWetShell, wet_shell
from vsb.motion.wetted import WetShell
from vsb.shell.deformed import DeformedShell
from vsb.shell.mode import natural_shapes
from vsb.shell.modes import ModeBasis, mode_basis
from vsb.shell.sphere import Shell
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


def test_a_spheroid_of_two_radii_has_the_sphere_s_tables(seed):
    """Series of the same polynomials: made from terms, and by interpolation."""
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


@pytest.mark.parametrize("meridian", BODIES)
def test_tables_hold_the_meridian_and_its_slopes(meridian):
    c = np.linspace(-0.9, 0.9, 7)
    x, z, dz, dx = chebyshev.chebval(c, wet_shell(basis_of(meridian), 0.25).shape.sphere.T)
    for i, phi in enumerate(np.arccos(c)):
        at = meridian.at(phi)
        s = np.sin(phi)
        assert (x[i] * s, z[i], dx[i], -s * dz[i]) == pytest.approx((at[0], at[1] + 0.25, at[2], at[3]), abs=1e-12)


def test_a_dry_a_wet_and_a_floating_spheroid():
    """Closed form: nothing, the whole volume, the affine image of the cap."""
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
    """Heave of half a spheroid, int J_0(kx) e^(kz) n_z dS; its error falls with the square of the amplitude."""
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


@pytest.mark.parametrize("meridian", BODIES)
@pytest.mark.parametrize("height", [-0.2, 0.4])
def test_quadrature_is_exact_whatever_the_meridian(meridian, height):
    """Points four times as many change nothing, on a shell that is deformed in all its shapes."""
    basis = basis_of(meridian)
    q = np.concatenate([[0.05], 0.03 * np.cos(np.arange(1.0, 7.0))])[None]
    few, many = wet_shell(basis, height), wet_shell(basis, height)
    node, weight = np.polynomial.legendre.leggauss(4 * len(few.shape.node))
    many.__dict__["shape"] = few.shape._replace(node=node, weight=weight)
    for one, other in zip(few.forces(q), many.forces(q), strict=True):
        assert one == pytest.approx(other, abs=1e-11)
    assert len(few.shape.node) == 2 * basis.turns + 3
    assert len(few.shape.grid) == 6 * (basis.turns + 1) + 1
