import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.special import eval_legendre, gammaln

from vsb.errors import ConfigError
from vsb.hydro import dofs
from vsb.hydro.panels import rings as bem
from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import DeformedShell, rigid_sphere
from vsb.shell.modes import mode_basis
from vsb.study import study as config

HERE = Path(__file__).parents[2]
RADIAL = tuple(f"Radial{n}" for n in range(7))
FILE = 4e-6
"""What the file of the hemisphere is off: six decimals, and its series at Ka = 10."""


@pytest.fixture(scope="module")
def unit(seed):
    """A basis on the sphere of radius one."""
    basis = mode_basis(seed.device, "full", 6)
    return dataclasses.replace(basis, shell=dataclasses.replace(basis.shell, radius=1.0))


@pytest.fixture(scope="module")
def sphere(unit):
    """Function nodes, height -> problem of a unit sphere with density and gravity one: omega^2 = Ka."""

    def build(nodes=32, height=0.0, labels=RADIAL, **amplitudes):
        q = np.array([amplitudes.get(label, 0.0) for label in unit.labels])
        return SpectralProblem(DeformedShell(unit, height, q), dofs.displacements(labels), 1.0, 1.0, nodes)

    return build


@pytest.fixture(scope="module")
def oblate():
    """The shell of the pressurised study at equilibrium, strained by 14 %, in all its displacements."""
    shape = reference_shell(config.load(HERE.parent / "config" / "pressurised.yaml")).shape
    labels = (*RADIAL, *(f"Meridional{n}" for n in range(1, 7)))
    return lambda nodes=32: SpectralProblem(shape, dofs.displacements(labels), 1025.0, 9.81, nodes)


def relative(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


def values(ds):
    """Added mass, damping and excitation of a dataset, frequency first."""
    return (
        ds.added_mass.values,
        ds.radiation_damping.values,
        (ds.Froude_Krylov_force + ds.diffraction_force).values[:, 0],
    )


def distance(ds, other):
    """Largest difference at every frequency in A, B and X, relative to the largest entry, shape (kind, omega)."""
    return np.array(
        [[relative(a, b) for a, b in zip(x, y, strict=True)] for x, y in zip(values(ds), values(other), strict=True)]
    )


def from_file(ds, hemisphere):
    omega = ds.omega.values[:, None]
    a, b, x = values(ds)
    pairs = ((a, "added_mass"), (b / omega[:, None], "radiation_damping"), (np.abs(x), "abs_excitation"))
    return np.array(
        [[relative(*each) for each in zip(ours, np.array(hemisphere[name]), strict=True)] for ours, name in pairs]
    )


def omegas_of(ka):
    return [float(np.sqrt(k)) for k in ka]


def in_closed_form(parity, terms=100_000):
    """Added mass of the hemisphere in the limits: odd (infinity) or even (zero) harmonics r^-(l+1) P_l, n = 0 only.

    A_00 = 2 pi sum (2l+1)/(l+1) (int_0^1 P_l dmu)^2, int_0^1 P_l = P_{l-1}(0)/(l+1) for odd l.
    """
    if not parity:
        return 2 * np.pi
    m = np.arange(terms)
    at_zero = np.exp(gammaln(2 * m + 1) - 2 * gammaln(m + 1) - 2 * m * np.log(2.0))  # |P_2m(0)|
    term = (4 * m + 3) / (2 * m + 2) * (at_zero / (2 * m + 2)) ** 2
    return 2 * np.pi * (term.sum() + terms * term[-1] / 2)  # terms fall like m^-3


def test_coefficients_of_the_hemisphere(sphere, hemisphere):
    errors = from_file(sphere().solve(omegas_of(hemisphere["Ka"])), hemisphere)
    assert errors.max() < FILE, errors
    assert errors[:, :-1].max() < 2e-6, errors


def test_convergence_to_the_hemisphere_is_spectral_until_the_file_ends(sphere, hemisphere):
    nodes = (8, 10, 12, 14, 16)
    errors = [from_file(sphere(n).solve(omegas_of(hemisphere["Ka"])), hemisphere)[0].max() for n in nodes]
    assert all(later < earlier / 3 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[0] > 1e-3  # otherwise this tests nothing
    assert errors[-1] < FILE


def test_self_convergence_goes_on_to_round_off(sphere):
    omegas = omegas_of([0.1, 1.0, 3.0])
    fine = sphere(44).solve(omegas)
    errors = [distance(sphere(n).solve(omegas), fine).max() for n in (12, 16, 20, 24, 32)]
    assert all(later < earlier / 20 for earlier, later in itertools.pairwise(errors[:4])), errors
    assert 1e-5 < errors[0] < 1e-2
    assert errors[-1] < 1e-11


@pytest.mark.parametrize(("parity", "limit", "name"), [(1, "at_infinity", "infinite"), (0, "at_zero", "zero")])
def test_limits_of_frequency(sphere, hemisphere, parity, limit, name):
    added_mass = getattr(sphere(), limit)()
    assert relative(added_mass, np.array(hemisphere[f"added_mass_{name}_frequency"])) < 6e-6
    assert added_mass[0, 0] == pytest.approx(in_closed_form(parity), rel=1e-9)
    assert np.abs(added_mass - added_mass.T).max() < 1e-11


def test_heave_added_mass_of_the_hemisphere_at_infinity_is_half_the_displaced_water(sphere):
    assert sphere().at_infinity()[1, 1] == pytest.approx(np.pi / 3, rel=1e-12)


def test_frequencies_go_over_into_the_limits(sphere):
    problem = sphere()
    low, lower = (relative(problem.solve([w]).added_mass.values[0], problem.at_zero()) for w in (0.1, 0.01))
    assert lower < 0.03 * low < 2e-3  # K log K
    far, farther = (relative(problem.solve([w]).added_mass.values[0], problem.at_infinity()) for w in (5.0, 10.0))
    assert farther < 0.5 * far < 0.1


@pytest.mark.parametrize(
    ("ka", "added_mass", "damping"), [(0.1, 0.8627, 0.1816), (0.3, 0.7157, 0.3254), (1.0, 0.4284, 0.2484)]
)
def test_heave_of_the_hemisphere_after_hulme_1982(sphere, ka, added_mass, damping):
    result = sphere(20, labels=("Radial1",)).solve(omegas_of([ka]))
    volume = 2 * np.pi / 3
    assert result.added_mass.item() / volume == pytest.approx(added_mass, abs=1e-4)
    assert result.radiation_damping.item() / volume / np.sqrt(ka) == pytest.approx(damping, abs=1e-4)


def test_scan_is_as_exact_near_irregular_frequencies_as_elsewhere(sphere, hemisphere):
    ka = [k + d for k in hemisphere["irregular_Ka_axisymmetric"] for d in (-1e-3, -1e-6, 0.0, 1e-6, 1e-3)]
    omegas = omegas_of([*ka, 10.0])
    assert distance(sphere(20).solve(omegas), sphere(28).solve(omegas)).max() < 1e-7


@pytest.mark.parametrize("height", [-0.5, -0.3, 0.3, 0.5, 0.7])
def test_spheres_that_float_high_or_low_converge_as_fast(sphere, height):
    omegas = omegas_of([0.1, 1.0, 3.0])
    fine = sphere(36, height)
    exact = fine.solve(omegas)
    errors = [distance(sphere(n, height).solve(omegas), exact).max() for n in (10, 14, 18, 24)]
    assert all(later < earlier / 4 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[-1] < 1e-7
    assert relative(sphere(24, height).at_infinity(), fine.at_infinity()) < 1e-8


def identities(problem, omegas):
    """Distance from symmetry, Haskind's damping and rank one, each relative to the largest entry at the frequency."""
    ds = problem.solve(omegas)
    a, b, x = values(ds)
    scale = (np.array(omegas) ** 3 / (2 * problem.density * problem.gravity**3))[:, None, None]
    haskind = scale * x[:, :, None] * x[:, None, :].conj()
    eigenvalues = np.sort(np.abs(np.linalg.eigvalsh(b + b.transpose(0, 2, 1))), axis=1)
    pairs = [(a, a.transpose(0, 2, 1)), (b, b.transpose(0, 2, 1)), (haskind, b)]
    return [*(max(map(relative, p, q)) for p, q in pairs), (eigenvalues[:, -2] / eigenvalues[:, -1]).max()]


@pytest.mark.parametrize("height", [-0.4, 0.0, 0.4])
def test_symmetry_haskind_and_rank_one_of_spheres(sphere, height):
    assert max(identities(sphere(32, height), omegas_of([0.1, 1.0, 3.0, 10.0]))) < 3e-8


def test_symmetry_haskind_and_rank_one_of_a_deformed_shell(oblate):
    assert max(identities(oblate(), [0.5, 2.0, 5.0, 8.0])) < 1e-9


def test_a_deformed_shell_converges_as_fast(oblate):
    omegas = [0.5, 2.0, 5.0, 8.0]
    fine = oblate(40).solve(omegas)
    errors = [distance(oblate(n).solve(omegas), fine).max() for n in (12, 16, 20, 24)]
    assert all(later < earlier / 10 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[-1] < 1e-8


@pytest.mark.parametrize("nodes", [8, 10, 12, 14, 16, 20])
def test_the_estimate_bounds_the_error(sphere, oblate, nodes):
    for build, omegas in ((sphere, omegas_of([0.1, 1.0, 3.0, 10.0])), (oblate, [0.5, 2.0, 5.0, 8.0])):
        estimate = build(nodes).error_estimate(omegas)
        error = distance(build(nodes).solve(omegas), build(40).solve(omegas))
        for kind, true in zip(("added_mass", "radiation_damping", "excitation_force"), error, strict=True):
            assert np.all(estimate[kind].values > true), (kind, nodes)
            assert estimate[kind].values.max() < 1e4 * true.max(), (kind, nodes)


def test_a_heaved_shell_is_a_raised_sphere(sphere):
    omegas = [0.5, 1.5]
    assert distance(sphere(24, 0.1, Heave=0.2).solve(omegas), sphere(24, 0.3).solve(omegas)).max() < 1e-12


def test_size_density_and_gravity_scale_out(sphere, seed, unit):
    large = dataclasses.replace(unit, shell=dataclasses.replace(unit.shell, radius=2.0))
    problem = SpectralProblem(DeformedShell(large, 0.6), dofs.displacements(RADIAL), 1025.0, 9.81, 20)
    a, b, x = values(problem.solve([np.sqrt(9.81 * 0.5)]))
    a1, b1, x1 = values(sphere(20, 0.3).solve([1.0]))
    assert relative(a, 1025 * 8 * a1) < 1e-12
    assert relative(b, 1025 * 8 * np.sqrt(9.81 / 2) * b1) < 1e-12
    assert relative(x, 1025 * 9.81 * 4 * x1) < 1e-12


def test_long_waves_push_like_hydrostatics(sphere):
    """K -> 0: the water rises as one, so the force is -rho g int w dS."""
    problem = sphere(20, 0.3)
    x = values(problem.solve([1e-3]))[2][0]
    mu, weight = np.polynomial.legendre.leggauss(20)
    mu = -1 + 0.35 * (mu + 1)  # from the keel to the waterline, cos phi = -0.3
    exact = [-2 * np.pi * 0.35 * weight @ eval_legendre(n, mu) for n in range(7)]
    assert np.abs(x - exact).max() < 1e-4


def test_meridional_displacements_of_a_sphere_move_no_water(sphere):
    ds = sphere(16, 0.2, labels=("Radial1", "Meridional3")).solve([1.0])
    assert np.abs(ds.added_mass.values[0, 1]).max() < 1e-14
    assert np.abs(ds.added_mass.values[0, :, 1]).max() < 1e-14


def panel_errors(green_folder, shape, problem, omegas, rows):
    """Distance of capytaine's rings from the high-order solution, shape (rows, kind), and of A at infinity."""
    fine, infinite, errors, at_infinity = problem.solve(omegas), problem.at_infinity(), [], []
    for n in rows:
        mesh = deformed_mesh(shape, n, 2 * n, n // 2)
        panels = bem.AxisymmetricProblem(
            bem.green_function(green_folder), mesh, problem.displacements, problem.density, np.inf, problem.gravity
        )
        ds = panels.solve(omegas)
        assert ds.sizes == fine.sizes
        assert relative(ds.Froude_Krylov_force.values, fine.Froude_Krylov_force.values) < 2 / n**2
        errors.append(distance(ds, fine).max(axis=1))
        at_infinity.append(relative(panels.at_infinity(), infinite))
    return np.array(errors), at_infinity


@pytest.mark.parametrize("case", ["low", "high", "oblate"])
def test_panels_converge_to_it(green_folder, sphere, oblate, case):
    problem = oblate() if case == "oblate" else sphere(32, {"low": -0.5, "high": 0.5}[case])
    omegas = [1.0, 2.5] if case == "oblate" else omegas_of([0.3, 1.2])
    errors, infinite = panel_errors(green_folder, problem.shell, problem, omegas, (12, 24, 48))
    assert np.all(errors[-1] < 1e-2), errors
    assert np.all(errors[-1] < errors[0] / 4), errors
    assert infinite[-1] < infinite[0] / 8 < 1e-2, infinite


@pytest.mark.parametrize("height", [1.5, -1.5])
def test_a_shell_without_waterline_is_refused(sphere, height):
    with pytest.raises(ConfigError, match="needs one waterline with the keel"):
        sphere(12, height).at_infinity()


def test_shapes_of_high_degree_have_no_floor_of_the_singular_integrals():
    """Odd degrees are multipoles of their own at infinite frequency: A_nn = 2 pi/((n + 1)(2n + 1)), no coupling."""
    degree = np.array([1, 9, 19, 29, 39])
    exact = np.diag(2 * np.pi / ((degree + 1) * (2 * degree + 1)))
    shapes = dofs.displacements(f"Radial{n}" for n in degree)
    errors = [
        np.abs(SpectralProblem(rigid_sphere(1.0, 0.0), shapes, 1.0, 1.0, nodes).at_infinity() - exact).max()
        for nodes in (32, 48, 64, 96)
    ]
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[2] < 1e-8
    assert errors[3] < 1e-11
