from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh
from shell.test_sphere import DENSER, LOWER, STIFFER, STRETCH, TABLE_I, larger

from vsb.errors import ConfigError
from vsb.scenes.rest import design_motions, study_basis
from vsb.shell.legendre import legendre
from vsb.shell.mode import Mode
from vsb.shell.modes import (
    ModeBasis,
    bending_block,
    check_rank,
    mass_block,
    membrane_block,
    mode_basis,
    paper_ratio,
    rigid_basis,
    shell_modes,
)
from vsb.shell.ritz import natural_modes
from vsb.shell.sphere import Shell, natural_frequencies
from vsb.study.meridian import RestMeridian, capsule

PAPER_RITZ = [51.434449987, 62.153777189, 86.525263883, 115.855327968, 146.580164630, 177.820039783, 209.298426663]


def basis_of(seed, basis, degree=6):
    return mode_basis(seed.device, basis, degree)


def test_ritz_frequencies_are_table_i(seed):
    assert basis_of(seed, "membrane").dry_frequencies == pytest.approx(TABLE_I, rel=1e-10)
    assert basis_of(seed, "full").dry_frequencies == pytest.approx([*TABLE_I, *LOWER.values()], rel=2e-9)
    assert basis_of(seed, "paper").dry_frequencies == pytest.approx(PAPER_RITZ, rel=4e-8)
    assert basis_of(seed, "full").dry_frequencies[:7] == pytest.approx(TABLE_I, rel=1e-10)


@pytest.mark.parametrize("degree", [6, 40])
def test_ritz_equals_closed_form_at_high_degree(seed, degree):
    basis = basis_of(seed, "full", degree)
    values = np.sqrt(np.abs(eigh(basis.stiffness[1:, 1:], basis.inertia[1:, 1:], eigvals_only=True)))
    closed = [natural_frequencies(basis.shell, n) for n in range(degree + 1)]
    exact = sorted([c[1] for c in closed] + [c[0] for c in closed[2:]])
    assert np.sort(values) == pytest.approx(exact, rel=1e-10)


def test_closed_form_blocks_are_the_energy_integrals(seed):
    """The (V, U) blocks against Gauss quadrature of the strain and curvature energies."""
    shell, n = basis_of(seed, "full").shell, 4
    x, w = np.polynomial.legendre.leggauss(60)
    phi = np.arccos(x)
    p, dp, ddp = (values[n] for values in legendre(n, phi))
    cot, nu, r = 1 / np.tan(phi), shell.poisson_ratio, shell.radius

    def form(pairs):  # 2 pi r^2 int (a_i a_j + b_i b_j + nu (a_i b_j + b_i a_j)) sin phi dphi
        return 2 * np.pi * r**2 * np.array([
            [np.sum(w * (a * c + b * d + nu * (a * d + b * c))) for c, d in pairs] for a, b in pairs
        ])  # fmt: skip

    strains = [(p / r, p / r), (ddp / r, cot * dp / r)]  # of V, of U
    curvatures = [(-ddp / r**2, -cot * dp / r**2), (ddp / r**2, cot * dp / r**2)]
    assert membrane_block(shell, n) == pytest.approx(shell.membrane_stiffness * form(strains), rel=1e-11)
    assert bending_block(shell, n) == pytest.approx(shell.bending_stiffness * form(curvatures), rel=1e-11)
    areal = 2 * np.pi * shell.density * shell.thickness * r**2
    assert np.diag(mass_block(shell, n)) == pytest.approx(areal * np.array([np.sum(w * p**2), np.sum(w * dp**2)]))


def test_rigid_heave_strains_nothing_and_is_orthogonal_to_the_true_mode(seed):
    rigid = np.ones(2)
    shell = basis_of(seed, "full").shell
    for block in (membrane_block(shell, 1), bending_block(shell, 1)):
        assert np.abs(block @ rigid).max() < 1e-12 * np.abs(block).max()
    coupling = {name: basis_of(seed, name).inertia[0, 2] / shell.mass for name in ("membrane", "full", "paper")}
    assert abs(coupling["membrane"]) < 1e-14
    assert abs(coupling["full"]) < 1e-14
    assert abs(coupling["paper"]) > 0.1  # the slipped shape is not orthogonal


@pytest.mark.parametrize("name", ["paper", "membrane", "full"])
def test_largest_displacement_of_every_mode_is_one(seed, name):
    phi = np.linspace(0, np.pi, 20001)
    radial, meridional = basis_of(seed, name, 12).displacement(phi)
    largest = np.hypot(radial, meridional).max(axis=1)
    assert np.all(largest < 1 + 1e-12)
    assert np.all(largest > 1 - (12 * phi[1]) ** 2 / 8)  # a maximum between two samples
    assert np.all(radial[:, 0] > 0)


def test_derivative_of_the_shapes(seed):
    basis, phi, h = basis_of(seed, "full", 20), np.linspace(0.0, np.pi, 41), 1e-5
    for order in (0, 1):
        ahead, behind = basis.displacement(phi + h)[order], basis.displacement(phi - h)[order]
        assert basis.displacement(phi, derivative=1)[order] == pytest.approx((ahead - behind) / (2 * h), abs=2e-6)


@pytest.mark.parametrize(
    ("colatitudes", "constraints"),
    [([0.0], 1), ([np.pi / 2], 2), ([0.0, 0.0], 1), ([0.0, np.pi], 2), ([0.3, 1.2, 0.3], 4)],
)
def test_clamps_by_null_space(seed, colatitudes, constraints):
    basis = basis_of(seed, "full")
    free = basis.clamped(colatitudes)
    assert free.shape == (13, 13 - constraints)
    assert free.T @ free == pytest.approx(np.eye(13 - constraints), abs=1e-13)
    assert np.abs(basis.clamp_rows(colatitudes) @ free).max() < 1e-12
    assert np.array_equal(free[:, 0], np.eye(13)[0])


def test_clamps_that_leave_nothing_free_are_refused(seed):
    study = varied(seed, modes={"degree": 1}, designs={"FSB": {"flexible": False}, "tight": {"clamp": [0, 90]}})
    with pytest.raises(
        ConfigError, match=r"designs.tight.clamp: received \[0.0, 90.0\], which leaves none of the 2 shell"
    ):
        design_motions(study, study_basis(study), "tight")


def test_a_rigid_study_has_heave_alone(seed):
    study = varied(seed, designs={"FSB": {"flexible": False}})
    basis = study_basis(study)
    assert basis.labels == ("Heave",)
    assert basis.inertia == pytest.approx(np.array([[17170.0]]))
    assert design_motions(study, basis, "FSB").shape == (1, 1)


def test_rayleigh_quotients_of_both_branches_are_the_closed_form_up_to_degree_40(seed):
    full = basis_of(seed, "full", 40)
    closed = np.array([natural_frequencies(full.shell, n) for n in range(41)])
    assert full.dry_frequencies == pytest.approx([*closed[:, 1], *closed[2:, 0]], rel=1e-10)
    assert basis_of(seed, "membrane", 40).dry_frequencies == pytest.approx(closed[:, 1], rel=1e-10)


def test_the_two_branches_of_a_degree_are_orthogonal_in_mass_and_stiffness(seed):
    basis = basis_of(seed, "full")
    for matrix in (basis.inertia[1:, 1:], basis.stiffness[1:, 1:]):
        scale = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
        assert np.abs(matrix / scale - np.eye(12)).max() < 1e-11


def test_shapes_solve_legendres_equation():
    phi = np.linspace(0.05, np.pi - 0.05, 101)
    p, dp, ddp = legendre(40, phi)
    n = np.arange(41)[:, None]
    residual = ddp + dp / np.tan(phi) + n * (n + 1) * p
    assert np.abs(residual).max() < 1e-11 * 40 * 41
    assert p[2] == pytest.approx((3 * np.cos(phi) ** 2 - 1) / 2, abs=1e-14)


def test_derivatives_of_legendre_polynomials_are_finite_at_both_poles():
    n = np.arange(41)
    p, dp, ddp = legendre(40, np.array([0.0, np.pi]))
    assert p == pytest.approx(np.array([np.ones(41), (-1.0) ** n]).T, abs=1e-12)
    assert np.abs(dp).max() < 1e-11
    assert ddp[:, 0] == pytest.approx(-n * (n + 1) / 2, rel=1e-12)


def test_rigid_heave_is_a_vertical_translation(seed):
    phi = np.linspace(0.0, np.pi, 31)
    radial, meridional = basis_of(seed, "membrane").displacement(phi)
    vertical = radial[0] * np.cos(phi) - meridional[0] * np.sin(phi)
    horizontal = radial[0] * np.sin(phi) + meridional[0] * np.cos(phi)
    assert vertical == pytest.approx(np.ones(31), abs=1e-15)
    assert horizontal == pytest.approx(np.zeros(31), abs=1e-15)


@pytest.mark.parametrize("name", ["paper", "membrane", "full"])
def test_heave_carries_the_buoy_and_no_elastic_force(seed, name):
    basis = basis_of(seed, name)
    assert basis.inertia[0, 0] == 17170.0
    assert np.all(basis.stiffness[0] == 0.0)
    assert np.all(basis.stiffness[:, 0] == 0.0)
    assert np.linalg.eigvalsh(basis.inertia).min() > 0


def test_paper_basis_has_no_bending_energy(seed):
    basis = basis_of(seed, "paper")
    for i, mode in enumerate(basis.shapes[1:], start=1):
        vector = np.array([mode.radial, mode.meridional])
        membrane = vector @ membrane_block(basis.shell, mode.degree) @ vector
        assert basis.stiffness[i, i] == pytest.approx(membrane, rel=1e-14)


def test_a_basis_of_which_no_damping_is_said_has_none():
    shell = Shell(2.0, 0.01, 1e7, 0.3, 2700.0)
    assert not ModeBasis(shell, (Mode("Radial0", 0, 1.0, 0.0),), 2e4, bending=False).damping.any()


def test_rayleigh_damping_of_the_modes_only(seed):
    basis = mode_basis(varied(seed, device={"damping": {"alpha": 0.7, "beta": 2e-3}}).device, "full", 3)
    expected = 0.7 * basis.inertia + 2e-3 * basis.stiffness
    assert basis.damping[1:, 1:] == pytest.approx(expected[1:, 1:], rel=1e-14)
    assert np.all(basis.damping[0] == 0.0)
    assert np.all(basis.damping[:, 0] == 0.0)


def test_pole_displacement_is_the_shape_at_the_top(seed):
    basis = basis_of(seed, "full")
    radial, meridional = basis.displacement(np.array([0.0]))
    assert basis.pole_radial_displacement == pytest.approx(radial[:, 0], rel=1e-13)
    assert np.all(meridional == 0.0)


@settings(max_examples=40)
@given(st.lists(st.integers(0, 36), min_size=1, max_size=5), st.sampled_from([6, 12, 40]))
def test_clamped_motions_satisfy_any_clamps(seed, fives, degree):
    colatitudes = [np.deg2rad(5.0 * five) for five in fives]
    basis = basis_of(seed, "full", degree)
    free = basis.clamped(colatitudes * 2)  # every clamp twice
    assert np.array_equal(free[:, 0], np.eye(len(basis.labels))[0])
    assert free.T @ free == pytest.approx(np.eye(free.shape[1]), abs=1e-12)
    rows = basis.clamp_rows(colatitudes)
    assert np.abs(rows @ free).max() < 1e-12 * max(1.0, np.abs(rows).max())
    assert free.shape[1] >= len(basis.labels) - 2 * len(set(colatitudes))


def test_duplicate_clamps_allow_the_same_motions(seed):
    basis = basis_of(seed, "full")
    once, often = (basis.clamped(c) for c in ([0.0, 1.1], [1.1, 0.0, 0.0, 1.1, 1.1]))
    assert once @ once.T == pytest.approx(often @ often.T, abs=1e-12)


def test_no_clamps_leave_every_mode_free(seed):
    assert basis_of(seed, "full").clamped([]).shape == (13, 13)


def test_a_design_allows_its_own_motions(seed):
    basis = study_basis(seed)
    free = {name: design_motions(seed, basis, name).shape[1] for name in seed.designs}
    assert free == {"FSB": 1, "VSWEC": 8, "VSWEC0": 7, "VSWEC90": 6}


def test_shapes_are_the_same_of_every_material():
    shells = [Shell(2.0, 0.01, modulus, 0.3, density) for modulus, density in ((1e7, 2700.0), (3e10, 950.0))]
    first, second = (shell_modes(shell, "full", 4) for shell in shells)
    assert first is second


CAPSULE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, capsule(2.0, 1.0))


def test_modes_of_another_meridian_are_orthogonal_and_of_its_natural_frequencies():
    basis = ModeBasis(CAPSULE, shell_modes(CAPSULE, "full", 6), 3e4, bending=True)
    mass, stiffness = basis.inertia, basis.stiffness
    size = np.sqrt(np.diag(mass))
    assert basis.dry_frequencies == pytest.approx(natural_modes(CAPSULE, 6).omega, rel=1e-9)
    assert np.abs(mass / np.outer(size, size) - np.eye(13)).max() < 1e-9
    assert np.abs(stiffness - np.diag(np.diag(stiffness))).max() < 1e-9 * stiffness.max()
    assert mass[0, 0] == 3e4
    assert not any(part.any() for part in (mass[0, 1:], mass[1:, 0], stiffness[0], stiffness[:, 0]))
    assert len(basis.clamped([np.pi / 2])[0]) == 13 - 2
    assert basis.pole_radial_displacement == pytest.approx(basis.displacement(np.array([0.0]))[0][:, 0])


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_without_bending_the_stiffness_goes_with_the_thickness_and_bending_with_its_cube(meridian):
    """Of the same shapes: K = h K_membrane + h^3 K_bending."""
    thin, thick = (Shell(2.0, h, 10e6, 0.3, 2700.0, meridian) for h in (0.01, 0.02))
    whole = [ModeBasis(shell, shell_modes(thin, "full", 4), 3e4, bending=True) for shell in (thin, thick)]
    alone = [replace(basis, bending=False) for basis in whole]
    largest = whole[0].stiffness.max()
    np.testing.assert_allclose(alone[1].stiffness, 2 * alone[0].stiffness, rtol=1e-10, atol=1e-12 * largest)
    bent = [basis.stiffness - without.stiffness for basis, without in zip(whole, alone, strict=True)]
    assert np.linalg.eigvalsh(bent[0][1:, 1:])[-1] > 1e-6 * largest
    np.testing.assert_allclose(bent[1], 8 * bent[0], rtol=1e-7, atol=1e-12 * largest)


@pytest.mark.parametrize("basis", ["paper", "membrane"])
def test_other_meridians_have_no_branches(basis):
    with pytest.raises(ConfigError, match=rf"modes.basis: received '{basis}', but on another shape than the sphere"):
        shell_modes(CAPSULE, basis, 4)


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.3, 0.45])
@pytest.mark.parametrize("degree", [1, 2, 5, 12])
def test_the_papers_ratio_takes_the_frequency_of_the_membrane_alone_squared_once_too_often(nu, degree):
    """(1 - nu^2) x^2 - (n(n+1) + 1 + 3 nu) x + n(n+1) - 2 = 0 (Baker 1961), its larger root as Omega^2."""
    m = degree * (degree + 1)
    omega2 = max(np.roots([1 - nu**2, -(m + 1 + 3 * nu), m - 2]))
    for thickness in (1e-3, 0.1):  # of any shell
        shell = Shell(2.0, thickness, 1e7, nu, 2700.0)
        expected = (1 + (1 + nu) * omega2**2) / (1 - omega2**2)
        assert paper_ratio(shell, degree) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_constraints_are_counted_whatever_they_are_measured_in(scale):
    """Three rows of which one is twice another; two apart by 1e-9 cannot be told, by 1e-3 they are two."""
    one, other = np.array([1.0, 2.0, 0.0, 1.0]), np.array([0.0, 1.0, 1.0, 3.0])
    assert check_rank(scale * np.array([one, other, 2 * one])) == 2
    assert check_rank(scale * np.array([one, one + 1e-3 * other])) == 2
    with pytest.raises(ConfigError, match="so near each other that it cannot be decided"):
        check_rank(scale * np.array([one, one + 1e-9 * other]))
    assert (check_rank(np.zeros((2, 4))), check_rank(np.zeros((0, 4)))) == (0, 0)


SEED = Shell(2.0, 0.01, 10e6, 0.3, 2700.0)


@pytest.mark.parametrize("kind", ["paper", "membrane", "full", "capsule"])
def test_modes_of_a_larger_shell_are_the_same_and_so_much_heavier_and_stiffer(kind):
    """Mass, stiffness and damping by their dimensions; what is said of shapes alone is that of the smaller one."""
    shell, name = (CAPSULE, "full") if kind == "capsule" else (SEED, kind)
    small, large = (
        ModeBasis(one, shell_modes(one, name, 4), mass, name != "paper", alpha, beta)
        for one, mass, alpha, beta in (
            (shell, 3e4, 0.4, 2e-3),
            (larger(shell), 3e4 * DENSER * STRETCH**3, 0.8, 6e-3),
        )
    )
    mass, stiffness = DENSER * STRETCH**3 * small.inertia, STIFFER * STRETCH * small.stiffness
    damping = 0.8 * mass + 6e-3 * stiffness
    damping[0, :] = damping[:, 0] = 0.0
    for found, expected in ((large.inertia, mass), (large.stiffness, stiffness), (large.damping, damping)):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())
    slower = np.sqrt(STIFFER / DENSER) / STRETCH
    assert large.dry_frequencies == pytest.approx(slower * small.dry_frequencies, rel=1e-9)
    assert (large.labels, large.degrees, large.turns) == (small.labels, small.degrees, small.turns)
    phi = np.linspace(0.0, np.pi, 7)
    for found, expected in (
        (large.displacement(phi), small.displacement(phi)),
        (large.displacement(phi, 1), small.displacement(phi, 1)),
    ):
        np.testing.assert_allclose(found, expected, atol=1e-10)
    np.testing.assert_allclose(large.clamp_rows([0.4, 2.0]), small.clamp_rows([0.4, 2.0]), atol=1e-11)


def test_the_wall_of_no_consequence_is_that_of_all_materials_and_masses():
    """Of a sphere and of another meridian: what clamps allow is found once."""
    for shell in (SEED, CAPSULE):
        modes = shell_modes(shell, "full", 3)
        one, other = (
            ModeBasis(replace(shell, young_modulus=e, density=d, thickness=h), modes, mass, True, alpha, beta)
            for e, d, h, mass, alpha, beta in ((1e7, 2700.0, 0.01, 3e4, 0.1, 2e-3), (3e9, 900.0, 0.03, 5e4, 0.0, 0.0))
        )
        assert one.immaterial == other.immaterial
        assert one.clamped([0.7]) is other.clamped([0.7])
        assert one.immaterial.shell.radius == shell.radius


def test_the_highest_degree_is_that_of_all_parts_of_all_modes_and_the_meridian_turns_beside():
    """Natural modes are told by a degree below the highest they hold; a sphere's own turns are none."""
    parts = ((5, 0.1, 0.0), (3, 0.2, 0.1))
    mode = Mode("Shell1", 2, 1.0, 0.3, parts)
    assert ModeBasis(SEED, (mode,), 1e4, True).highest_degree == 5
    assert ModeBasis(SEED, (mode,), 1e4, True).turns == 5
    assert ModeBasis(SEED, (), 1e4, True).highest_degree == 1
    rest = RestMeridian((2.0, 0.0, 0.05), (0.1, 2.5, 0.05, 0.02, 0.01))
    bulged = ModeBasis(Shell(rest.radius, 0.01, 1e7, 0.3, 2700.0, rest), (mode, Mode("Shell2", 1, 1.0, 0.3)), 1e4, True)
    assert (bulged.highest_degree, bulged.turns) == (5, 5 + 3)
    assert bulged.pole_radial_displacement.tolist() == pytest.approx([1.0, 1.3, 1.0])
    shares = bulged.shares
    assert shares.shape == (2, 3, 6)
    assert pytest.approx(np.array([[0, 0], [0, 0], [1.0, 0.3], [0.2, 0.1], [0, 0], [0.1, 0]])) == shares[:, 1].T


@pytest.mark.parametrize(("degree", "labels"), [
    (0, ["Membrane0"]),
    (1, ["Membrane0", "Membrane1"]),
    (3, ["Membrane0", "Membrane1", "Membrane2", "Membrane3", "Bending2", "Bending3"]),
])  # fmt: skip
def test_every_degree_has_an_upper_branch_and_from_two_on_a_lower_one(seed, degree, labels):
    for kind in ("paper", "membrane", "full"):
        expected = labels if kind == "full" else [label for label in labels if label.startswith("Membrane")]
        basis = mode_basis(seed.device, kind, degree)
        assert basis.labels == ("Heave", *expected)
        assert basis.bending is (kind != "paper")
        assert basis.degrees == (1, *(int(label[-1]) for label in expected))
        assert basis.total_mass == seed.device.mass


@pytest.mark.parametrize(("relative", "count"), [(0.9e-12, 1), (1.1e-12, None), (0.9e-8, None), (1.1e-8, 2)])
def test_a_constraint_is_one_of_its_own_or_none_by_its_part_of_the_largest(relative, count):
    """In rows of any size: of three, one of this part of the largest and one of a thousandth more."""
    turn = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [0.3, 1.0, 2.0], [1.0, 0.0, 1.0]]))[0]
    for scale in (1e-3, 40.0):
        rows = scale * turn @ np.diag([1.0, relative, 0.0])
        if count is not None:
            assert check_rank(rows) == count
            continue
        with pytest.raises(ConfigError) as refused:
            check_rank(scale * turn @ np.diag([1.0, relative, 1.001 * relative if relative < 1e-10 else 1.2e-12]))
        told = f"(relative singular value {1.001 * relative if relative < 1e-10 else relative:.1e}; needs more than 1e-08, "
        assert str(refused.value).startswith(
            "clamp: received clamps so near each other that it cannot be decided whether they are one or several "
        )
        assert told + "or less than 1e-12 for the same clamp twice); move them apart, drop one, or raise" in str(
            refused.value
        )


def test_a_study_without_flexible_designs_heaves_alone_with_its_whole_mass(seed):
    basis = rigid_basis(seed.device.model_copy(update={"mass": 9e3}))
    assert (basis.labels, basis.total_mass, basis.bending) == (("Heave",), 9e3, False)
    assert basis.shell == Shell.of(seed.device)
