import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import eval_legendre, gammaln, hankel1, ive, jv, kve

from vsb.errors import ConfigError
from vsb.hydro import dofs
from vsb.hydro.panels import rings as bem
from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.spectral.deepwater import WavePart
from vsb.hydro.spectral.finitedepth import FiniteDepthWavePart, wave_profile
from vsb.hydro.spectral.meridian import WetMeridian, unit_rule
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.shell.deformed import DeformedShell, rigid_sphere
from vsb.shell.modes import mode_basis
from vsb.waves.dispersion import group_velocity, wavenumber

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


def evanescent(k, depth, count):
    """The first roots of k_n tan k_n d = -K, by Newton's iteration."""
    n = np.pi * np.arange(1, count + 1)
    y = n - np.arctan(k * depth / n)
    for _ in range(8):
        y -= (y - n + np.arctan(k * depth / y)) / (1 - k * depth / (y**2 + (k * depth) ** 2))
    return y / depth


def john(order, k, depth, here, there):
    """Green's function of two rings of different radius: John's eigenfunctions, with Graf's addition theorem."""
    (x, z), (source, height) = here, there
    near, far = np.minimum(x, source), np.maximum(x, source)
    k0 = wavenumber(np.sqrt(k), depth, 1.0)
    bound = wave_profile(np.array([k0]), depth, np.array([z, height]))[0].prod()
    sech = 2 * np.exp(-k0 * depth) / (1 + np.exp(-2 * k0 * depth))
    outgoing = 2j * np.pi * k0**2 / (depth * (k0 * sech) ** 2 + k) * bound
    kn = evanescent(k, depth, int(60 + 14 * depth / (far - near)))
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


@pytest.mark.parametrize("order", [0, 1, 3])
@pytest.mark.parametrize("depth", [1.01, 1.3, 5.0, 100.0])
def test_greens_function_is_johns(shell, order, depth):
    meridian = WetMeridian(shell(), 12, order)
    assert max(relative(*kernels(meridian, depth, k)) for k in (1e-5, 1e-3, 0.1, 1.0)) < 1e-11


@pytest.mark.parametrize("order", [0, 1, 3])
@pytest.mark.parametrize("k", [10.0, 40.0])
def test_what_the_bottom_changes_is_what_johns_series_says_in_short_waves(shell, order, k):
    """Between two depths: the deep-water part, 1e-9 off at K = 40, drops out."""
    meridian = WetMeridian(shell(), 12, order)
    (ours, johns), (ours_deeper, johns_deeper) = (kernels(meridian, depth, k) for depth in (1.01, 3.0))
    assert relative(ours - ours_deeper, johns - johns_deeper) < 1e-11


@settings(max_examples=30)
@given(st.floats(1.01, 20.0), st.floats(-9.0, 3.0), st.integers(0, 2), st.floats(-0.5, 0.5))
def test_greens_function_is_johns_for_any_depth_and_wave(shell, ratio, log_k, order, height):
    meridian = WetMeridian(shell(height), 10, order)
    assert relative(*kernels(meridian, ratio * (1 - height), np.exp(log_k))) < 1e-9


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("clearance", [0.01, 0.1, 1.0, 9.0])
def test_the_image_in_the_bottom_is_integrated_exactly(shell, order, clearance):
    """Against 1500 points of Gauss, for the polynomials of the nodes."""
    meridian = WetMeridian(shell(), 16, order)
    part = FiniteDepthWavePart(meridian, 1 + clearance, 1.0)
    assert part.image_points < 300
    t, weight = unit_rule(1500)
    p, (x, z) = meridian.at(t), meridian.targets
    values = p.influence(order, x[:, None] - p.x, z[:, None] + p.z + 2 * part.depth, 1.0)
    exact = (values * weight * p.rate) @ meridian.interpolation(t)
    for ours, brute in zip(part.image * meridian.areas, exact, strict=True):
        assert relative(ours, brute) < 1e-11


@pytest.mark.parametrize("order", [0, 1])
def test_high_frequency_goes_over_into_the_limit(shell, order):
    part = FiniteDepthWavePart(WetMeridian(shell(), 12, order), 1.5, 1.0)
    errors = [relative(each, part.at_infinity()) for each in part.influences(np.array([50.0, 100.0, 200.0, 400.0]))]
    assert all(1.8 < a / b < 2.3 for a, b in itertools.pairwise(errors)), errors  # first order in 1/K


def test_low_frequency_goes_over_into_the_limit_for_order_one(shell):
    part = FiniteDepthWavePart(WetMeridian(shell(), 12, 1), 1.5, 1e-7)
    errors = [relative(each, part.at_zero()) for each in part.influences(np.array([1e-3, 1e-4, 1e-5, 1e-6]))]
    assert all(6 < a / b < 11 for a, b in itertools.pairwise(errors)), errors  # K log K


def test_the_bottom_of_the_ocean_neither_overflows_nor_is_lost(shell):
    """Image series of K = infinity if Kd >> 1; waves of a layer, 2 pi i pi/d, if kd << 1."""
    part = FiniteDepthWavePart(WetMeridian(shell(), 12), 1e6, 1e-12)
    long, short = part.influences(np.array([1e-12, 400.0]))
    assert relative(short, part.at_infinity()) < 1e-8
    assert long[0].imag == pytest.approx(2 * np.pi**2 / 1e6, rel=1e-5)


def test_wave_profile_satisfies_its_equations():
    k, depth, z = np.array([0.3, 2.0]), 1.7, np.array([-1.7, -1.7 + 1e-4, -1.7 - 1e-4, 0.0])
    profile = wave_profile(k, depth, z)
    assert profile[:, 3] == pytest.approx(1.0, rel=1e-15)
    assert profile[:, 0] == pytest.approx(1 / np.cosh(k * depth), rel=1e-14)
    assert profile[:, 1] == pytest.approx(profile[:, 2], rel=1e-12)  # even about the bottom
    assert wave_profile(k, np.inf, z) == pytest.approx(np.exp(np.outer(k, z)), rel=1e-15)
    assert wave_profile(np.array([500.0]), 10.0, z)[0] == pytest.approx(np.exp(500.0 * z), rel=1e-12)


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


def _gauss(edges):
    node, weight = unit_rule(24)
    length = np.diff(edges)[:, None]
    return (edges[:-1, None] + length * node).ravel(), (length * weight).ravel()


def contour(k, depth, end):
    """Wavenumbers and weights of a triangle below both poles and the real axis beyond."""
    back = max(2 * wavenumber(np.sqrt(k), depth, 1.0), k + 1)
    corner = back / 2 - 1j * min(back / 2, 1.0)
    s, w = _gauss(np.append(0.0, 2.0 ** np.arange(-16, 1)))
    real, weight = _gauss(np.arange(back, back + end, 1.5))
    return (
        np.concatenate([s * corner, corner + s * (back - corner), real]),
        np.concatenate([w * corner, w * (back - corner), weight]),
    )


def deep_source(k, x, z):
    """Potential 2/r + 2K int e^{kz} J0(kR)/(k - K) dk of a source at the origin and its rate by r, on the unit sphere.

    The integral F satisfies dF/dz = K F + 1/r, so it is integrated upwards from z = -2.
    """
    kk, w = contour(k, 50.0, 30.0)
    w = w * np.exp(-2 * kk) / (kk - k)
    below, below_x = jv(0, np.outer(x, kk)) @ w, -jv(1, np.outer(x, kk)) @ (kk * w)
    s, ds = unit_rule(60)
    height = -2 + np.outer(z + 2, s)
    r, grown = np.hypot(x[:, None], height), (z[:, None] + 2) * ds * np.exp(k * (z[:, None] - height))
    start = np.exp(k * (z + 2))
    f, f_x = start * below + (grown / r).sum(axis=1), start * below_x - (grown / r**3).sum(axis=1) * x
    return 2 + 2 * k * f, -2 + 2 * k * (x * f_x + z * (k * f + 1))


def by_multipoles(k, depth, terms):
    """A + iB/omega of the hemisphere from a source and wave-free multipoles at the origin (Hulme 1982), with bottom.

    Wave-free: P_2n/r^(2n+1) + K P_(2n-1)/(2n r^2n) = int k^(2n-1) (k + K)/(2n)! e^{kz} J0(kR) dk; the bottom turns
    e^{kz} into e^{kz} + [(k + K) e^{kz} + (k - K) e^{-kz}]/[(k - K) e^{2kd} - k - K]. Normal velocities by least squares.
    """
    u, w = unit_rule(80)
    mu, weight = u**2, 2 * u * w
    x, z = np.sqrt(1 - mu**2), -mu
    kk, w = contour(k, depth, (60 + 3 * terms) / (2 * depth - 1))
    w = w / ((kk - k) - (kk + k) * np.exp(-2 * kk * depth))
    up, down = ((kk + s * k) * np.exp(s * np.outer(z, kk) - 2 * kk * depth) for s in (1, -1))
    j_0, j_1 = (jv(m, np.outer(x, kk)) for m in (0, 1))
    bottom = np.stack([(up + down) * j_0, kk * (z[:, None] * (up - down) * j_0 - x[:, None] * (up + down) * j_1)])
    columns = [np.stack(deep_source(k, x, z)) + bottom @ (w * 2 * kk / (kk - k))]
    for n in range(1, terms):
        even, odd = eval_legendre(2 * n, mu), eval_legendre(2 * n - 1, mu)
        free = np.stack([even + k / (2 * n) * odd, -(2 * n + 1) * even - k * odd])
        columns.append(free + bottom @ (w * np.exp((2 * n - 1) * np.log(kk) - gammaln(2 * n + 1)) * (kk + k)))
    potential, velocity = np.stack(columns, axis=2)
    wanted = np.stack([eval_legendre(n, -mu) for n in range(len(RADIAL))], axis=1)
    root = np.sqrt(weight)[:, None]
    strengths = np.linalg.lstsq(root * velocity, root * wanted, rcond=1e-14)[0]
    return -2 * np.pi * (weight[:, None] * wanted).T @ potential @ strengths


@pytest.mark.parametrize("depth", [1.1, 3.0])
def test_multipoles_of_the_hemisphere_converge_to_it(bowl, depth):
    ours, _ = solved(bowl(depth), [0.1, 1.0])
    for k, coefficients in zip([0.1, 1.0], ours, strict=True):
        errors = [relative(by_multipoles(k, depth, terms), coefficients) for terms in (5, 10, 20, 40)]
        assert all(5 < a / b < 20 for a, b in itertools.pairwise(errors)), errors  # about third order in the terms
        assert errors[-1] < 1e-6


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("height", [-0.2, 0.0, 0.3])
@pytest.mark.parametrize("ratio", [1.01, 1.05, 1.5, 20.0])
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


def test_low_frequency_is_the_limit_for_surge_and_pitch(bowl):
    problem = bowl(1.3, order=1)
    limit = problem.at_zero()
    errors = [relative(a.real, limit) for a in solved(problem, [1e-2, 1e-3, 1e-4, 1e-5])[0]]
    assert all(5 < a / b < 11 for a, b in itertools.pairwise(errors)), errors  # K log K


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


def test_long_waves_push_like_hydrostatics_in_shallow_water(bowl):
    body = bowl(1.1)
    assert solved(body, [1e-7])[1][0] == pytest.approx(body.onto.sum(axis=1), abs=1e-3)


@pytest.mark.parametrize("depth", [1.2, 3.0])
def test_panels_converge_to_it(green_folder, bowl, shell, depth):
    """Rings of capytaine's panels; its finite-depth Green function alone is some 1e-3 off."""
    ka = [0.3, 1.0]
    ours, errors = solved(bowl(depth), ka), []
    for rows in (6, 12, 24):
        mesh = deformed_mesh(shell(), rows, 2 * rows, rows // 2)
        problem = bem.AxisymmetricProblem(
            bem.green_function(green_folder), mesh, dofs.displacements(RADIAL), 1.0, depth, 1.0
        )
        ds = problem.solve([float(np.sqrt(k)) for k in ka])
        errors.append(distance(values(ds), ours))
    assert errors[1] < errors[0] / 2, errors
    assert errors[2] < 6e-3, errors


# Refusals


@pytest.mark.parametrize("depth", [0.5, 1.0, 1.009])
def test_a_shell_on_the_bottom_is_refused(shell, depth):
    with pytest.raises(ConfigError, match=r"under a shell of 1 m draft; needs at least 1\.01 m"):
        FiniteDepthWavePart(WetMeridian(shell(), 12), depth, 1.0)


def test_zero_frequency_has_no_limit_for_order_zero(bowl):
    with pytest.raises(ConfigError, match="grows like -log omega; needs infinite depth or a positive frequency"):
        bowl(2.0, 12).at_zero()


@pytest.mark.parametrize("clearance", [0.0099, 0.0101])
def test_water_may_be_one_percent_of_the_draft_deeper_than_it(clearance):
    meridian = WetMeridian(rigid_sphere(3.0, 0.6), 12)
    if clearance > 0.01:
        assert FiniteDepthWavePart(meridian, 2.4 * (1 + clearance), 1.0).draft == pytest.approx(2.4)
        return
    with pytest.raises(
        ConfigError,
        match=r"^water.depth: received 2.42376 m under a shell of 2.4 m draft; needs at least 2.424 m: deepen",
    ):
        FiniteDepthWavePart(meridian, 2.4 * (1 + clearance), 1.0)
