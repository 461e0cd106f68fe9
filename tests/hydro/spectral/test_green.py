import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import hankel1, ive, j0, jv, kve, struve, y0

from vsb.engine.hydro import dofs
from vsb.engine.hydro.spectral.green import FiniteDepthWavePart, WavePart, wave_profile
from vsb.engine.hydro.spectral.meridian import WetMeridian
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.water import group_velocity, wavenumber
from vsb.errors import ConfigError

NODE, WEIGHT = np.polynomial.legendre.leggauss(80)


def deep_water(k, rho, z):
    """2K PV int_0^inf e^{qz} J0(q rho)/(q - K) dq + 2 pi i K e^{Kz} J0(K rho) as a finite integral, Newman (1985)."""
    u = np.arcsinh(z / rho)[..., None] * (NODE + 1) / 2  # t = rho sinh u takes the root away
    finite = -np.arcsinh(z / rho) * (np.exp(k * (z[..., None] - rho[..., None] * np.sinh(u))) @ (WEIGHT / 2))
    oscillating = np.pi * (struve(0, k * rho) + y0(k * rho)) - 2j * np.pi * j0(k * rho)
    return -k * (2 * finite + np.exp(k * z) * oscillating)


def of_ring(order, k, x, source, z, angles=600):
    """Its integral over the azimuth against cos(m theta), by the midpoint rule."""
    theta = 2 * np.pi * (np.arange(angles) + 0.5) / angles
    rho = np.sqrt((x - source) ** 2 + 4 * x * source * np.sin(theta / 2) ** 2)
    return 2 * np.pi * np.mean(np.cos(order * theta) * deep_water(k, rho, np.full_like(rho, z)))


@pytest.mark.parametrize("order", [0, 1, 3])
@pytest.mark.parametrize(("k", "largest"), [(0.2, 5.0), (5.0, 5.0), (1.0, 1.0), (1e-2, 1e-2), (1e-3, 1e-3)])
def test_influence_is_the_integral_of_the_waves_over_the_azimuth(order, k, largest):
    """Between points apart and on one ring; the derivative by central differences along the normal."""
    meridian, h = WetMeridian(rigid_sphere(1.0, 0.0), 12, order), 1e-4
    found = next(WavePart(meridian, largest).influences(np.array([k])))
    (x, z), p = meridian.targets, meridian.points
    size = np.abs(found).max(axis=(1, 2))
    for i, j in ((0, 6), (4, 4), (7, 2), (11, 5), (13, 8)):
        ahead, here, behind = (
            of_ring(order, k, x[i], p.x[j] + s * p.n_x[j], z[i] + p.z[j] + s * p.n_z[j]) for s in (h, 0.0, -h)
        )
        assert abs(found[0, i, j] - here) < 1e-9 * size[0], (i, j)
        assert abs(found[1, i, j] - (ahead - behind) / (2 * h)) < 1e-6 * size[1], (i, j)


RADIAL = tuple(f"Radial{n}" for n in range(5))
KA = (0.01, 0.3, 1.0, 3.0)


@pytest.fixture(scope="module")
def shell(seed):
    """Function height -> a sphere of radius one."""
    basis = mode_basis(seed.device, "full", 2)
    unit = dataclasses.replace(basis, shell=dataclasses.replace(basis.shell, radius=1.0))
    return lambda height=0.0: DeformedShell(unit, height)


def relative(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


# Green's function


def john(order, k, depth, here, there):
    """Green's function of two rings of different radius: John's eigenfunctions, with Graf's addition theorem."""
    (x, z), (source, height) = here, there
    near, far = np.minimum(x, source), np.maximum(x, source)
    k0 = wavenumber(np.sqrt(k), depth, 1.0)
    bound = wave_profile(np.array([k0]), depth, np.array([z, height]))[0].prod()
    sech = 2 * np.exp(-k0 * depth) / (1 + np.exp(-2 * k0 * depth))
    outgoing = 2j * np.pi * k0**2 / (depth * (k0 * sech) ** 2 + k) * bound
    # the first roots of k_n tan k_n d = -K, by Newton's iteration
    n = np.pi * np.arange(1, int(60 + 14 * depth / (far - near)) + 1)
    y = n - np.arctan(k * depth / n)
    for _ in range(8):
        y -= (y - n + np.arctan(k * depth / y)) / (1 - k * depth / (y**2 + (k * depth) ** 2))
    kn = y / depth
    terms = np.cos(kn * (z + depth)) * np.cos(kn * (height + depth)) / (depth - k / (kn**2 + k**2))
    radial = ive(order, kn * near) * kve(order, kn * far) * np.exp(-kn * (far - near))
    return 2 * np.pi * (outgoing * jv(order, k0 * near) * hankel1(order, k0 * far) + 4 * terms @ radial)


def kernels(meridian, depth, k):
    """Green's function and John's series between nodes with a third of the radius between them, each shape (pair,)."""
    part = FiniteDepthWavePart(meridian, depth, k)
    smooth = next(part.influences(np.array([k])))[0] - part.image[0]
    smooth += next(WavePart(meridian, k).influences(np.array([k])))[0]
    p, pairs = meridian.points, []
    for i, j in itertools.permutations(range(0, meridian.nodes, 3), 2):
        if abs(p.x[i] - p.x[j]) > 0.3:
            heights = [(p.z[i] - p.z[j], -1.0), (p.z[i] + p.z[j], 1.0), (p.z[i] + p.z[j] + 2 * depth, 1.0)]
            rings = sum(p.influence(meridian.order, p.x[i] - p.x, np.full_like(p.x, h), s)[0, j] for h, s in heights)
            pairs.append((smooth[i, j] + rings, john(meridian.order, k, depth, (p.x[i], p.z[i]), (p.x[j], p.z[j]))))
    return np.array(pairs).T


@settings(max_examples=30)
@given(st.floats(1.01, 20.0), st.floats(-9.0, 3.0), st.integers(0, 2), st.floats(-0.5, 0.5))
def test_greens_function_equals_johns_series(shell, ratio, log_k, order, height):
    meridian = WetMeridian(shell(height), 10, order)
    assert relative(*kernels(meridian, ratio * (1 - height), np.exp(log_k))) < 1e-9


def test_very_deep_water_does_not_overflow(shell):
    """Image series of K = infinity if Kd >> 1; waves of a layer, 2 pi i pi/d, if kd << 1."""
    part = FiniteDepthWavePart(WetMeridian(shell(), 12), 1e6, 1e-12)
    long, short = part.influences(np.array([1e-12, 400.0]))
    assert relative(short, part.at_infinity()) < 1e-8
    assert long[0].imag == pytest.approx(2 * np.pi**2 / 1e6, rel=1e-5)


# Bodies


@pytest.fixture(scope="module")
def bowl(shell):
    """Function depth, nodes, height, order -> a sphere in water of density and gravity one; meridians are shared."""
    shared = {}

    def build(depth, nodes=28, height=0.0, order=0):
        labels = ("Surge", "Pitch", "Radial2") if order else RADIAL
        problem = SpectralProblem(shell(height), dofs.displacements(labels, order), 1.0, 1.0, nodes, depth)
        problem.__dict__["meridian"] = shared.setdefault((nodes, height, order), problem.meridian)
        return problem

    return build


def values(ds):
    """A + iB/omega and excitation of a dataset, frequency first."""
    radiation = ds.added_mass.values + 1j * ds.radiation_damping.values / ds.omega.values[:, None, None]
    return radiation, (ds.Froude_Krylov_force + ds.diffraction_force).values[:, 0]


def solved(problem, ka):
    return values(problem.solve([float(np.sqrt(k)) for k in ka]))


def distance(result, other):
    return max(relative(a, b) for x, y in zip(result, other, strict=True) for a, b in zip(x, y, strict=True))


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("height", [-0.2, 0.3])
@pytest.mark.parametrize("ratio", [1.01, 1.5, 20.0])
def test_symmetry_and_haskind(bowl, order, height, ratio):
    """B = k0 X X^H/(4 rho g v_g) of the depth's wave, half of that for order 1."""
    depth, ka = ratio * (1 - height), [1e-3, *KA, 10.0]
    radiation, force = solved(bowl(depth, height=height, order=order), ka)
    for k, a, x in zip(ka, radiation, force, strict=True):
        omega = np.sqrt(k)
        scale = wavenumber(omega, depth, 1.0) / (4 * (1 + order) * group_velocity(omega, depth, 1.0))
        assert relative(a, a.T) < 1e-9
        assert relative(scale * np.outer(x, x.conj()), omega * a.imag) < 3e-8


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize(("depth", "factor", "last"), [(1.01, 8, 1e-7), (1.2, 50, 1e-9), (3.0, 50, 1e-9)])
def test_convergence_is_spectral(bowl, order, depth, factor, last):
    fine = solved(bowl(depth, 32, order=order), KA)
    errors = [distance(solved(bowl(depth, n, order=order), KA), fine) for n in (8, 12, 16, 20)]
    assert all(later < earlier / factor for earlier, later in itertools.pairwise(errors)), errors
    assert errors[0] > 2e-4  # otherwise this tests nothing
    assert errors[-1] < last


def test_deep_water_is_the_limit(bowl):
    """A vertical dipole's images, z = 0 reflecting by -1 if Kd >> 1: third order in 1/d."""
    deep = bowl(np.inf)
    exact, infinite = solved(deep, [1.0, 2.0]), deep.at_infinity()
    depths = (8.0, 16.0, 32.0, 64.0)
    at_infinity = [relative(bowl(depth).at_infinity(), infinite) for depth in depths]
    errors = [distance(solved(bowl(depth), [1.0, 2.0]), exact) for depth in depths]
    for each in (at_infinity, errors):
        assert all(7 < a / b < 12 for a, b in itertools.pairwise(each)), each


@pytest.mark.parametrize("depth", [1.2, 3.0])
def test_low_frequency_added_mass_is_that_of_a_source_in_a_layer(bowl, depth):
    """dA/d log K -> -V V/(4 pi d), B/omega -> V V/(4 d) with V the flux through the shell."""
    body = bowl(depth)
    flux = 2 * np.pi * body.velocities @ body.meridian.areas
    layer = np.outer(flux, flux) / (4 * np.pi * depth)
    for k in (1e-4, 1e-7):
        lower, upper = solved(body, [k, 2 * k])[0]
        assert relative((lower - upper).real / np.log(2), layer) < 100 * k
        assert relative(lower.imag, np.pi * layer) < 100 * k


def test_force_in_long_waves_is_hydrostatic_in_shallow_water(bowl):
    body = bowl(1.1)
    assert solved(body, [1e-7])[1][0] == pytest.approx(body.onto.sum(axis=1), abs=1e-3)


# Refusals


@pytest.mark.parametrize("depth", [0.5, 1.0, 1.009])
def test_a_shell_on_the_bottom_is_refused(shell, depth):
    with pytest.raises(ConfigError, match=r"under a shell of 1 m draft; needs at least 1\.01 m"):
        FiniteDepthWavePart(WetMeridian(shell(), 12), depth, 1.0)


def test_zero_frequency_has_no_limit_for_order_zero(bowl):
    with pytest.raises(ConfigError, match="grows like -log omega; needs infinite depth or a positive frequency"):
        bowl(2.0, 12).at_zero()
