"""The shell at degrees 40 and 80, thin and thick, dry and immersed, against checks that share no code with it."""

import numpy as np
import pytest
from conftest import varied
from scipy.linalg import eigh
from scipy.special import gammaln
from shell.test_modes import PAPER_RITZ
from shell.test_sphere import SEED, TABLE_I

from vsb.shell.legendre import legendre
from vsb.shell.modes import bending_block, mass_block, membrane_block, mode_basis
from vsb.shell.sphere import Shell, natural_frequencies

RATIOS = [1e-3, 5e-3, 0.03, 0.09]
NODE, WEIGHT = np.polynomial.legendre.leggauss(128)  # of cos(phi); exact up to degree 255
PHI = np.arccos(NODE)


def basis_of(seed, name, degree, ratio=5e-3):
    device = {"thickness": ratio * seed.device.radius, "mass": 30000.0}  # heavy enough for the thickest
    return mode_basis(varied(seed, device=device).device, name, degree)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("degree", [40, 80])
def test_ritz_frequencies_are_the_closed_form_at_every_degree(seed, degree, ratio):
    basis = basis_of(seed, "full", degree, ratio)
    closed = np.array([natural_frequencies(basis.shell, n) for n in range(degree + 1)])
    quotients = dict(zip(basis.labels[1:], basis.dry_frequencies, strict=True))
    membrane = [quotients[f"Membrane{n}"] for n in range(degree + 1)]
    bending = [quotients[f"Bending{n}"] for n in range(2, degree + 1)]
    assert membrane == pytest.approx(closed[:, 1], rel=1e-12)
    assert bending == pytest.approx(closed[2:, 0], rel=1e-12)
    values = eigh(basis.stiffness[1:, 1:], basis.inertia[1:, 1:], eigvals_only=True)  # all degrees in one problem
    assert np.sqrt(values) == pytest.approx(np.sort([*membrane, *bending]), rel=1e-10)


@pytest.mark.parametrize("name", ["paper", "membrane", "full"])
@pytest.mark.parametrize("degree", [40, 80])
def test_mass_matrix_is_the_integral_of_the_shapes(seed, name, degree):
    basis = basis_of(seed, name, degree)
    v, u = basis.displacement(PHI)
    shell = basis.shell
    areal = 2 * np.pi * shell.radius**2 * shell.density * shell.thickness
    brute = areal * ((v * WEIGHT) @ v.T + (u * WEIGHT) @ u.T)
    assert brute[0, 0] == pytest.approx(shell.mass, rel=1e-13)  # the shell's own share of heave
    brute[0, 0] = basis.total_mass
    size = np.sqrt(np.outer(np.diag(brute), np.diag(brute)))
    assert np.abs(basis.inertia - brute).max() < 1e-12 * size.max()
    assert np.abs((basis.inertia - brute) / size).max() < 1e-12
    if name != "paper":
        assert np.abs(brute / size - np.eye(len(size))).max() < 1e-12  # orthogonal, heave included


def test_mass_matrix_is_the_integral_over_the_sphere_in_space(seed):
    """Displacement vectors in x, y, z over colatitude and azimuth: no use of the local frame or of axisymmetry."""
    basis = basis_of(seed, "full", 12)
    azimuth = 2 * np.pi * np.arange(8) / 8
    v, u = (shape[:, :, None] for shape in basis.displacement(PHI))
    sin, cos = np.sqrt(1 - NODE**2)[:, None], NODE[:, None]
    outward = v * sin + u * cos
    vectors = np.stack([outward * np.cos(azimuth), outward * np.sin(azimuth), np.repeat(v * cos - u * sin, 8, axis=2)])
    shell = basis.shell
    element = shell.density * shell.thickness * shell.radius**2 * WEIGHT * (2 * np.pi / 8)
    brute = np.einsum("cipa,cjpa,p->ij", vectors, vectors, element)
    brute[0, 0] = basis.total_mass
    assert basis.inertia == pytest.approx(brute, rel=1e-12, abs=1e-10)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("degree", [2, 13, 40, 80])
def test_energies_of_one_degree_are_the_integrals_of_strain_and_curvature(degree, ratio):
    """P_n by Fourier series: exact derivatives, no code shared."""
    shell, r = Shell(2.0, 2.0 * ratio, 10e6, 0.3, 2700.0), 2.0
    p, dp, ddp = fourier(degree, PHI)
    cot, nu = NODE / np.sqrt(1 - NODE**2), shell.poisson_ratio

    def energy(pairs):
        forms = [[a * c + b * d + nu * (a * d + b * c) for c, d in pairs] for a, b in pairs]
        return 2 * np.pi * r**2 * np.array(forms) @ WEIGHT

    strains = energy([(p / r, p / r), (ddp / r, cot * dp / r)])
    curvatures = energy([(-ddp / r**2, -cot * dp / r**2), (ddp / r**2, cot * dp / r**2)])
    assert membrane_block(shell, degree) == pytest.approx(shell.membrane_stiffness * strains, rel=1e-11)
    assert bending_block(shell, degree) == pytest.approx(shell.bending_stiffness * curvatures, rel=1e-11)
    areal = 2 * np.pi * shell.density * shell.thickness * r**2
    assert np.diag(mass_block(shell, degree)) == pytest.approx(areal * np.array([p**2, dp**2]) @ WEIGHT, rel=1e-11)


def fourier(degree, phi):
    """P_n(cos phi) = sum_k a_k a_(n-k) cos (n-2k) phi, a_k = (2k)!/(2^k k!)^2, and two derivatives."""
    k = np.arange(degree + 1)
    a = np.exp(gammaln(2 * k + 1) - 2 * gammaln(k + 1) - k * np.log(4))
    m, weight = degree - 2 * k, a * a[::-1]
    angle = np.outer(m, phi)
    return weight @ np.cos(angle), -(weight * m) @ np.sin(angle), -(weight * m**2) @ np.cos(angle)


@pytest.mark.parametrize("degree", [0, 1, 2, 7, 40, 80])
def test_legendre_functions_are_their_fourier_series(degree):
    phi = np.linspace(0.0, np.pi, 501)
    for order, (ours, series) in enumerate(zip(legendre(80, phi), fourier(degree, phi), strict=True)):
        assert np.abs(ours[degree] - series).max() < 2e-13 * max(1, degree) ** order


def test_legendre_functions_obey_the_recursions():
    phi = np.linspace(0.0, np.pi, 501)
    p, dp, _ = legendre(80, phi)
    n = np.arange(1, 80)[:, None]
    assert np.abs((n + 1) * p[2:] - (2 * n + 1) * np.cos(phi) * p[1:-1] + n * p[:-2]).max() < 1e-12 * 80
    assert np.abs(dp[2:] - dp[:-2] + (2 * n + 1) * np.sin(phi) * p[1:-1]).max() < 1e-12 * 80
    assert np.abs(np.sin(phi) * dp[1:-1] - n * (np.cos(phi) * p[1:-1] - p[:-2])).max() < 1e-12 * 80


def test_legendre_functions_at_the_poles_and_the_equator():
    n = np.arange(81)
    p, dp, ddp = legendre(80, np.array([0.0, np.pi, np.pi / 2]))
    sign, curvature = (-1.0) ** n, n * (n + 1) / 2  # P_n'(1)
    assert p[:, :2] == pytest.approx(np.array([np.ones(81), sign]).T, rel=1e-14)
    assert np.abs(dp[:, :2]).max() < 1e-12  # sin(pi) is not zero in floating point
    assert ddp[:, :2] == pytest.approx(-np.array([curvature, sign * curvature]).T, rel=1e-13)
    half = np.arange(41)
    middle = (-1.0) ** half * np.exp(gammaln(2 * half + 1) - 2 * gammaln(half + 1) - half * np.log(4))
    assert p[::2, 2] == pytest.approx(middle, rel=1e-12)
    assert np.abs(p[1::2, 2]).max() < 1e-14
    assert dp[1::2, 2] == pytest.approx(-n[1::2] * middle[:-1], rel=1e-12)


@pytest.mark.parametrize("degree", [2, 3, 10, 40, 80])
def test_second_derivative_by_cosine_at_the_pole(degree):
    """P_n''(1) = (n-1) n (n+1) (n+2)/8, from (d2P/dphi2 - cot phi dP/dphi)/sin^2 phi close to the pole."""
    phi = np.array([0.01 / degree])
    _, dp, ddp = (values[degree, 0] for values in legendre(degree, phi))
    exact = (degree - 1) * degree * (degree + 1) * (degree + 2) / 8
    second = ((ddp - dp / np.tan(phi)) / np.sin(phi) ** 2)[0]
    assert second == pytest.approx(exact, rel=2e-5)


def test_both_columns_of_table_i(seed):
    """The paper's Ritz column too: its slipped ratio takes the frequency of the membrane alone."""
    assert basis_of(seed, "full", 6).dry_frequencies[:7] == pytest.approx(TABLE_I, rel=1e-10)
    assert basis_of(seed, "paper", 6).dry_frequencies == pytest.approx(PAPER_RITZ, rel=1e-10)


def immersed_frequencies(shell, degree, water_density, bending=True):
    """Natural frequencies of the shell deep in unbounded water [rad/s]: lower and upper branch, of n = 0 one.

    K x = omega^2 (M + diag(m_w, 0)) x on (V, U): water moves with the radial part alone. Its potential
    a/(n+1) (a/r)^(n+1) P_n has the added mass m_w = 4 pi a^3 rho/((n+1)(2n+1)).
    """
    stiffness, mass = membrane_block(shell, degree), mass_block(shell, degree)
    if bending:
        stiffness = stiffness + bending_block(shell, degree)
    mass[0, 0] += 4 * np.pi * shell.radius**3 * water_density / ((degree + 1) * (2 * degree + 1))
    if degree == 0:
        return np.sqrt(stiffness[:1, 0] / mass[:1, 0])
    squares = eigh(stiffness, mass, eigvals_only=True)
    if degree == 1:
        squares[0] = 0.0  # exact: rigid motion strains nothing
    return np.sqrt(squares)


@pytest.mark.parametrize(
    ("degree", "published"), [(0, [5.936208]), (2, [5.178951, 73.952054]), (3, [6.452965, 107.664566])]
)
def test_membrane_frequencies_under_water(degree, published):
    assert immersed_frequencies(SEED, degree, 1000.0, bending=False) == pytest.approx(published, abs=6e-7)


@pytest.mark.parametrize("ratio", RATIOS)
def test_frequencies_under_no_water_are_dry(ratio):
    shell = Shell(2.0, 2.0 * ratio, 10e6, 0.3, 2700.0)
    assert immersed_frequencies(shell, 0, 0.0) == pytest.approx(natural_frequencies(shell, 0)[1:], rel=1e-14)
    for n in range(1, 81):
        assert immersed_frequencies(shell, n, 0.0) == pytest.approx(natural_frequencies(shell, n), rel=1e-12)


def test_added_mass_under_water_is_the_kinetic_energy_of_the_flow():
    """Potential a/(n+1) (a/r)^(n+1) P_n outside the sphere: the added mass of the one-mode Rayleigh quotient."""
    for n in (0, 2, 5, 40):
        p = fourier(n, PHI)[0]
        added = 1000.0 * 2 * np.pi * SEED.radius**2 * WEIGHT @ (SEED.radius / (n + 1) * p * p)
        heavy = mass_block(SEED, n) + np.diag([added, 0.0])
        stiffness = membrane_block(SEED, n) + bending_block(SEED, n)
        if n == 0:
            assert immersed_frequencies(SEED, 0, 1000.0)[0] ** 2 == pytest.approx(stiffness[0, 0] / heavy[0, 0])
        else:
            expected = np.sqrt(eigh(stiffness, heavy, eigvals_only=True))
            assert immersed_frequencies(SEED, n, 1000.0) == pytest.approx(expected, rel=1e-10)


def test_water_lowers_every_frequency_and_bending_raises_it():
    for n in range(2, 41):
        wet, dry = immersed_frequencies(SEED, n, 1025.0), natural_frequencies(SEED, n)
        assert np.all(wet < dry)
        assert wet[1] > dry[0]  # a constraint on the radial motion alone: the branches interlace
        assert np.all(wet > immersed_frequencies(SEED, n, 1025.0, bending=False))
    assert immersed_frequencies(SEED, 1, 1025.0)[0] == 0.0  # rigid
