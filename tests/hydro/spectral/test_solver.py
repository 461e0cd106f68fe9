"""The spectral solver: hemisphere, convergence, identities, limits, every azimuthal order, capytaine's panels."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from conftest import varied
from scipy.special import gammaln

from vsb.engine.hydro import dofs
from vsb.engine.hydro.database import displacements_of, in_modes, with_excitation
from vsb.engine.hydro.dofs import displacements, legendre_function
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.spectral.green import WavePart
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.hydro.variables import RESOLUTION
from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.engine.shell.meridian import capsule, spheroid
from vsb.engine.shell.modes import Mode, ModeBasis, natural_shapes
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError
from vsb.models.floating_system import buoy_at
from vsb.models.rest import reference_shell
from vsb.stages.members import swept_shape
from vsb.study import study as config

HERE = Path(__file__).parents[2]
FILE = 4e-6
"""Error of the hemisphere's file: six decimals, and its series at Ka = 10."""
KA = [0.1, 1.0, 3.0]


def labels(order):
    if not order:
        return tuple(f"Radial{n}" for n in range(7))
    return (("Surge", "Pitch") if order == 1 else ()) + tuple(f"Radial{n}" for n in range(order, order + 4))


def sphere(nodes=32, height=0.0, order=0, displacements=None):
    """A unit sphere in water of density one under gravity one: omega^2 = Ka."""
    moved = dofs.displacements(displacements or labels(order), order)
    return SpectralProblem(rigid_sphere(1.0, height), moved, 1.0, 1.0, nodes)


@pytest.fixture(scope="module")
def oblate():
    """The shell of the pressurised study at equilibrium, strained by 14 %, in radial and meridional displacements."""
    shape = reference_shell(config.load(HERE.parent / "config" / "pressurised.yaml")).shape

    def build(nodes=32, order=0):
        moved = dofs.displacements([*labels(order), f"Meridional{order + 1}"], order)
        return SpectralProblem(shape, moved, 1025.0, 9.81, nodes)

    return build


def omegas_of(ka):
    return [float(np.sqrt(k)) for k in ka]


def relative(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


def values(ds):
    """Added mass, damping and excitation of a dataset, frequency first."""
    force = (ds.Froude_Krylov_force + ds.diffraction_force).values[:, 0]
    return ds.added_mass.values, ds.radiation_damping.values, force


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


def test_coefficients_of_the_hemisphere(hemisphere):
    errors = from_file(sphere().solve(omegas_of(hemisphere["Ka"])), hemisphere)
    assert errors.max() < FILE, errors
    assert errors[:, :-1].max() < 2e-6, errors


def test_convergence_to_the_hemisphere_is_spectral(hemisphere):
    nodes = (8, 10, 12, 14, 16)
    errors = [from_file(sphere(n).solve(omegas_of(hemisphere["Ka"])), hemisphere)[0].max() for n in nodes]
    assert all(later < earlier / 3 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[0] > 1e-3  # otherwise this tests nothing
    assert errors[-1] < FILE


def at_equator(order, degree):
    """|P_n^m(0)| for even, |dP_n^m/dmu(0)| for odd n - m, and sqrt(int_0^1 (P_n^m)^2 dmu), as logarithms."""
    odd = (degree - order) % 2
    value = (order + odd) * np.log(2.0) - np.log(np.pi) / 2
    value = value + gammaln((degree + order + 1 + odd) / 2) - gammaln((degree - order + 2 - odd) / 2)
    return value, (gammaln(degree + order + 1) - gammaln(degree - order + 1) - np.log(2 * degree + 1)) / 2


def in_closed_form(order, parity, count=4, terms=20_000):
    """Added mass of the hemisphere for Radial<n> in harmonics r^-(l+1) P_l^m of l - m odd (infinity) or even (zero).

    A = pi sum_l I_ln I_lk/((l+1) N_l), I_ln = int_0^1 P_l^m P_n^m dmu, N_l = I_ll, from Legendre's equation: at mu = 0
    only the product of a value and a slope is left over, divided by l(l+1) - n(n+1).
    """
    degree = order + parity + 2 * np.arange(terms)
    at_l, norm = at_equator(order, degree)
    signs = (-1.0) ** np.arange(terms)  # of successive values, or slopes, at the equator
    rows = []
    for n in range(order, order + count):
        if (n - order) % 2 == parity:
            rows.append(np.where(degree == n, np.exp(at_equator(order, np.array(n))[1]), 0.0))
        else:
            product = np.exp(at_equator(order, np.array(n))[0] + at_l - norm) * signs * (-1.0) ** ((n - order) // 2)
            rows.append(product / (degree * (degree + 1.0) - n * (n + 1)) * (1 if parity else -1))
    mirror = (-1.0) ** np.add.outer(np.arange(count), np.arange(count))  # from above the water to below it
    summand = mirror[:, :, None] * np.einsum("il,jl,l->ijl", rows, rows, np.pi / (degree + 1))
    return summand.sum(axis=2) + terms * summand[:, :, -1] / 2  # terms fall like l^-3


@pytest.mark.parametrize("order", [1, 3])
@pytest.mark.parametrize(("parity", "limit"), [(1, "at_infinity"), (0, "at_zero")])
def test_limits_of_frequency_are_legendre_series(order, parity, limit):
    problem = sphere(40, order=order, displacements=tuple(f"Radial{n}" for n in range(order, order + 4)))
    assert relative(getattr(problem, limit)(), in_closed_form(order, parity)) < 1e-9


@pytest.mark.parametrize(("limit", "name"), [("at_infinity", "infinite"), ("at_zero", "zero")])
def test_axisymmetric_limits_of_frequency(hemisphere, limit, name):
    added_mass = getattr(sphere(), limit)()
    assert relative(added_mass, np.array(hemisphere[f"added_mass_{name}_frequency"])) < 6e-6
    assert np.abs(added_mass - added_mass.T).max() < 1e-11


def wave_free(order, degree, k, x, z):
    """Potential P_n^m/r^(n+1) + K/(n-m) P_{n-1}^m/r^n of Ursell and Havelock, n - m even, and its gradient (x, z).

    In the angle from the downward vertical; K phi = dphi/dz at z = 0 without waves at infinity.
    """
    r, angle = np.hypot(x, z), np.arctan2(x, -z)
    total, outward, across = 0.0, 0.0, 0.0
    for n, factor in ((degree, 1.0), (degree - 1, k / (degree - order))):
        p, slope = legendre_function(n, order, angle)
        total = total + factor * p / r ** (n + 1)
        outward = outward - factor * (n + 1) * p / r ** (n + 2)
        across = across + factor * slope / r ** (n + 2)
    sin, cos = x / r, -z / r
    return total, outward * sin + across * cos, -outward * cos + across * sin


def wave_free_error(problem, k, degree):
    """Distance of the solution, in the norm of the surface, from the wave-free potential it has the velocity of."""
    m = problem.meridian
    p = m.points
    exact, by_x, by_z = wave_free(problem.order, degree, k, p.x, p.z)
    single, double = m.rankine.sum(axis=0) + next(WavePart(m, k).influences(np.array([k]))) * m.areas
    phi = m.solve(double, (-single @ (p.n_x * by_x + p.n_z * by_z))[:, None])[:, 0]
    return np.sqrt((m.areas @ np.abs(phi - exact) ** 2) / (m.areas @ exact**2))


@pytest.mark.parametrize(
    ("order", "k", "shape"), [(0, 2.0, "low"), (1, 0.3, "hemisphere"), (2, 2.0, "low"), (3, 2.0, "oblate")]
)
def test_potentials_without_waves_are_reproduced(oblate, order, k, shape):
    """An exact solution at any frequency on any body around the origin, of kernel, wave part and interior equations."""
    build = {"hemisphere": lambda n: sphere(n, order=order), "low": lambda n: sphere(n, -0.3, order)}
    problems = [build.get(shape, lambda n: oblate(n, order))(n) for n in (10, 14, 18, 24)]
    errors = [wave_free_error(problem, k, order + 2) for problem in problems]
    assert all(later < earlier / 4 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[0] > 1e-5  # otherwise this tests nothing
    assert errors[-1] < 1e-6


@pytest.mark.parametrize("order", [0, 2])
def test_self_convergence_goes_on_to_round_off(order):
    omegas = omegas_of(KA)
    fine = sphere(44, order=order).solve(omegas)
    errors = [distance(sphere(n, order=order).solve(omegas), fine).max() for n in (12, 16, 20, 24, 32)]
    assert all(later < earlier / 20 for earlier, later in itertools.pairwise(errors[:4])), errors
    assert 1e-5 < errors[0] < 1e-2
    assert errors[-1] < 1e-11


def test_scan_is_as_exact_near_irregular_frequencies_as_elsewhere(hemisphere):
    ka = [k + d for k in hemisphere["irregular_Ka_axisymmetric"] for d in (-1e-3, -1e-6, 0.0, 1e-6, 1e-3)]
    omegas = omegas_of([*ka, 10.0])
    assert distance(sphere(20).solve(omegas), sphere(28).solve(omegas)).max() < 1e-7


def identities(problem, omegas):
    """Distance from symmetry, Haskind's damping and rank one, each relative to the largest entry at the frequency."""
    ds = problem.solve(omegas)
    a, b, _ = values(ds)
    water = problem.depth, problem.density, problem.gravity
    haskind = haskind_damping(with_excitation(ds), *water, problem.order)
    eigenvalues = np.sort(np.abs(np.linalg.eigvalsh(b + b.transpose(0, 2, 1))), axis=1)
    pairs = [(a, a.transpose(0, 2, 1)), (b, b.transpose(0, 2, 1)), (haskind, b)]
    worst = [max(relative(*each) for each in zip(p, q, strict=True)) for p, q in pairs]
    return [*worst, (eigenvalues[:, -2] / eigenvalues[:, -1]).max()]


@pytest.mark.parametrize("order", [0, 1])
def test_symmetry_haskind_and_rank_one_of_a_deformed_shell(oblate, order):
    assert max(identities(oblate(32, order), [0.5, 2.0, 5.0, 8.0])) < 1e-9


@pytest.mark.parametrize("nodes", [8, 12, 20])
def test_the_estimate_bounds_the_error(oblate, nodes):
    for build, omegas in ((sphere, omegas_of([0.1, 1.0, 3.0, 10.0])), (oblate, [0.5, 2.0, 5.0, 8.0])):
        estimate = build(nodes).error_estimate(omegas)
        error = distance(build(nodes).solve(omegas), build(40).solve(omegas))
        for kind, true in zip(("added_mass", "radiation_damping", "excitation_force"), error, strict=True):
            assert np.all(estimate[kind].values > true), (kind, nodes)
            assert estimate[kind].values.max() < 1e4 * true.max(), (kind, nodes)


@pytest.mark.parametrize(("nodes", "waves"), [(16, [0.1, 1.0, 3.0]), (20, [8.0])])
def test_each_displacement_has_an_error_of_its_own_that_bounds_the_true_one(nodes, waves):
    """Points that hardly resolve degree 16 resolve heave to nearly all digits; in short waves damping misleads."""
    omegas, named = omegas_of(waves), ("Radial1", "Radial6", "Radial16")
    estimate = sphere(nodes, 0.3, displacements=named).error_estimate(omegas)[RESOLUTION].values
    poor, rich = (with_excitation(sphere(count, 0.3, displacements=named).solve(omegas)) for count in (nodes, 48))
    mass, damping = (
        [np.abs(np.einsum("wii->wi", ds[name].values)) for ds in (poor, rich)]
        for name in ("added_mass", "radiation_damping")
    )
    force = [ds.excitation_force.values[:, 0] for ds in (poor, rich)]
    true = np.max([np.abs(a - b).max(axis=0) / np.abs(b).max(axis=0) for a, b in (mass, damping, force)], axis=0)
    relative_estimate = estimate / np.sqrt(mass[1].max(axis=0))
    assert np.all(true < relative_estimate)
    assert relative_estimate[0] < 1e-3 * relative_estimate[2]


def test_size_density_and_gravity_scale_out():
    large = SpectralProblem(rigid_sphere(2.0, 0.6), dofs.displacements(labels(0)), 1025.0, 9.81, 20)
    a, b, x = values(large.solve([np.sqrt(9.81 * 0.5)]))
    a1, b1, x1 = values(sphere(20, 0.3).solve([1.0]))
    assert relative(a, 1025 * 8 * a1) < 1e-12
    assert relative(b, 1025 * 8 * np.sqrt(9.81 / 2) * b1) < 1e-12
    assert relative(x, 1025 * 9.81 * 4 * x1) < 1e-12


def test_surge_force_in_long_waves():
    """K -> 0: surge feels -i K g times the mass of displaced water and its own added mass, at a wall."""
    problem, k = sphere(20, 0.3, 1, displacements=("Surge",)), 1e-6
    ds = problem.solve(omegas_of([k]))
    volume = problem.shell.volume()
    assert ds.Froude_Krylov_force.item() == pytest.approx(-1j * k * volume, rel=1e-5)
    assert values(ds)[2].item() == pytest.approx(-1j * k * (volume + problem.at_zero().item()), rel=1e-5)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_froude_krylov_force_is_the_pressure_of_the_whole_wave(oblate, order):
    """-rho g int e^{kz + ikx} w cos(m theta) dS, with the azimuth by a sum."""
    problem, k = oblate(32, order), 0.8
    p, theta = problem.meridian.points, 2 * np.pi * np.arange(64) / 64
    wave = np.exp(k * p.z[:, None] + 1j * k * np.outer(p.x, np.cos(theta))) @ np.cos(order * theta) / len(theta)
    exact = -1025.0 * 9.81 * 2 * np.pi * (problem.velocities * problem.meridian.areas) @ wave
    found = problem.solve([np.sqrt(9.81 * k)]).Froude_Krylov_force.values[0, 0]
    assert relative(found, exact) < 1e-12


@pytest.mark.parametrize("height", [1.5, -1.5])
def test_a_shell_without_waterline_is_refused(height):
    with pytest.raises(ConfigError, match="needs one waterline with the keel"):
        sphere(12, height).at_infinity()


DENSITY, GRAVITY = 1025.0, 9.81


def _at_rest(meridian, centre_height=0.0, degree=0):
    shell = Shell(meridian.radius, 0.002 * meridian.radius, 1e7, 0.3, 2700.0, meridian)
    modes = natural_shapes(shell, degree) if degree else ()
    return DeformedShell(ModeBasis(shell, modes, 1e4, bending=True), centre_height)


def _lamb(a, c):
    """Added mass over displaced mass of a spheroid far from all, along and across its axis (Lamb 1932, art. 114)."""
    if c > a:
        e = math.sqrt(1 - a**2 / c**2)
        log = math.log((1 + e) / (1 - e))
        along, across = 2 * (1 - e**2) / e**3 * (log / 2 - e), 1 / e**2 - (1 - e**2) / (2 * e**3) * log
    else:
        e = math.sqrt(1 - c**2 / a**2)
        root = math.sqrt(1 - e**2)
        along, across = 2 / e**3 * (e - root * math.asin(e)), root / e**3 * math.asin(e) - (1 - e**2) / e**2
    return along / (2 - along), across / (2 - across)


@pytest.mark.parametrize("height", [1.6, 3.0, 6.0, 10.0])
def test_limits_of_half_immersed_spheroids_are_lambs(height):
    """Mirrored, the body is whole: odd at infinite frequency, so heave is along its axis; even at zero, so surge is."""
    body, displaced = _at_rest(spheroid(2.0, height)), DENSITY * 4 / 3 * math.pi * 4.0 * height / 4
    along, across = _lamb(2.0, height / 2)
    heave = SpectralProblem(body, displacements(["Heave"]), DENSITY, GRAVITY, 48)
    assert heave.at_infinity()[0, 0] == pytest.approx(along * displaced, rel=1e-6)
    surge = SpectralProblem(body, displacements(["Surge"], 1), DENSITY, GRAVITY, 48)
    assert surge.at_zero()[0, 0] == pytest.approx(across * displaced, rel=1e-6)


def test_a_spheroid_is_a_sphere_deformed_into_it():
    a, c = 2.0, 1.6
    v = {0: (2 * a + c) / 3 - a, 2: 2 * (c - a) / 3}
    modes = (Mode("Membrane0", 0, 1.0, 0.0), Mode("Membrane2", 2, v[2], (c - a) / 3))
    sphere = ModeBasis(Shell(a, 0.01, 1e7, 0.3, 2700.0), modes, 1e4, bending=True)
    deformed = DeformedShell(sphere, 0.3, np.array([0.0, v[0], 1.0]))
    asked = displacements(["Heave", "Radial0", "Radial3", "Meridional2"])
    one, other = (
        SpectralProblem(shell, asked, DENSITY, GRAVITY, 32).solve([1.0, 2.5])
        for shell in (deformed, _at_rest(spheroid(a, 2 * c), 0.3))
    )
    for name in ("added_mass", "radiation_damping", "diffraction_force", "Froude_Krylov_force"):
        assert other[name].values == pytest.approx(
            one[name].values, rel=1e-9, abs=1e-9 * np.abs(one[name].values).max()
        )


BODIES = [_at_rest(spheroid(2.0, 3.0), 0.4, 3), _at_rest(capsule(1.0, 1.0), 0.5, 2)]


@pytest.mark.parametrize("body", BODIES, ids=["spheroid", "capsule"])
def test_reciprocity_and_haskind_of_shell_modes(body):
    basis = body.basis
    asked = displacements(
        [*(f"Radial{n}" for n in range(basis.highest_degree + 1)),
         *(f"Meridional{n}" for n in range(1, basis.highest_degree + 1))]
    )  # fmt: skip
    found = with_excitation(in_modes(SpectralProblem(body, asked, DENSITY, GRAVITY, 20).solve([2.0]), basis))
    for name in ("added_mass", "radiation_damping"):
        value = found[name].values
        assert np.abs(value - value.transpose(0, 2, 1)).max() < 1e-8 * np.abs(value).max()
    implied = haskind_damping(found, np.inf, DENSITY, GRAVITY).real
    assert np.abs(found.radiation_damping.values - implied).max() < 1e-8 * np.abs(implied).max()


@pytest.mark.parametrize(("draft", "depth"), [(3.5, np.inf), (2.0, np.inf), (1.995, np.inf), (4.2, np.inf), (3.5, 4.0)])
def test_capsule_converges_spectrally_on_each_side_of_its_junctions(draft, depth):
    """Also where the waterline meets a junction, or nearly does, and over a level bottom."""
    meridian, found = capsule(2.0, 2.0), []
    body = _at_rest(meridian, -(meridian.lowest + draft))
    for nodes in (16, 48):
        problem = SpectralProblem(body, displacements(["Heave"]), DENSITY, GRAVITY, nodes, depth=depth)
        found.append(with_excitation(problem.solve([2.618])))
    for name in ("added_mass", "radiation_damping", "excitation_force"):
        assert found[0][name].values == pytest.approx(found[1][name].values, rel=2e-5), name
    implied = haskind_damping(found[1], depth, DENSITY, GRAVITY).real
    assert implied == pytest.approx(found[1].radiation_damping.values, rel=5e-7)


SPHEROID = {
    "device": {"shape": {"spheroid": {"height": 3.0}}, "young_modulus": 3e7, "mass": 12880.529879718},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
}
SHAPES = [
    SPHEROID["device"],
    {"shape": {"profile": [[0.0, 2.0], [1.0, 1.8], [1.9, 0.4], [1.6, -0.9], [0.0, -1.7]]}, "mass": 9000.0},
]


@pytest.mark.parametrize("device", SHAPES, ids=["spheroid", "profile"])
def test_force_on_modes_in_long_waves_is_hydrostatic(seed, device):
    """X of a mode tends to -rho g int n.psi dS over the wet surface, integrated here on its own quadrature."""
    study = varied(seed, device=device, modes={"basis": "full", "degree": 7}, hydro={"witness": "none"})
    shell = reference_shell(study).shape
    basis, omega = shell.basis, 0.02
    problem = SpectralProblem(shell, displacements_of(basis), DENSITY, GRAVITY, 32)
    found = with_excitation(in_modes(problem.solve([omega]), basis)).excitation_force.values[0, 0]
    node, weight = np.polynomial.legendre.leggauss(400)
    half = (np.pi - shell.waterline) / 2
    phi, weight = shell.waterline + half * (node + 1), half * weight
    at = basis.shell.at_rest(phi)
    v, u = basis.displacement(phi)
    along_x, along_z = v * np.sin(phi) + u * np.cos(phi), v * np.cos(phi) - u * np.sin(phi)
    expected = -DENSITY * GRAVITY * 2 * np.pi * ((-at.dz * along_x + at.dx * along_z) * at.x * weight).sum(axis=1)
    np.testing.assert_allclose(found.real, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize(("degree", "expected"), [(10, [-4.745, -2.833, 0.761, -1.948])])
def test_gains_of_a_flexible_spheroid_are_those_of_an_independent_computation(seed, tmp_path, degree, expected):
    """Own Ritz solution of the shell and multipoles by least squares on its meridian, sharing no code; at |Z| each."""
    study = varied(seed, **SPHEROID, modes={"basis": "full", "degree": degree}, hydro={"witness": "none"})
    omega = 2 * np.pi / np.array([6.0, 4.0, 3.0, 2.5])
    reference = reference_shell(study)
    seen = buoy_at(study, reference, swept_shape(study, reference.basis, str(tmp_path)).at(omega)).ports()
    gain = 100 * (seen["VSWEC"].best_power / seen["FSB"].best_power - 1)
    np.testing.assert_allclose(gain, expected, atol=2e-3)
