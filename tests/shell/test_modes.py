"""Axisymmetric shell modes: Table I of the publication, energy integrals, clamps, other meridians."""

import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh
from shell.test_shell import LOWER, TABLE_I

from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.meridian import RestMeridian, capsule, spheroid
from vsb.engine.shell.modes import (
    ModeBasis,
    check_rank,
    mode_basis,
    natural_shapes,
    paper_ratio,
    shell_modes,
    strain_shapes,
)
from vsb.engine.shell.ritz import mass_block, membrane_block, natural_modes
from vsb.engine.shell.shell import Shell, natural_frequencies
from vsb.errors import ConfigError
from vsb.models.rest import design_motions, study_basis

PAPER_RITZ = [51.434449987, 62.153777189, 86.525263883, 115.855327968, 146.580164630, 177.820039783, 209.298426663]


def basis_of(seed, basis, degree=6):
    return mode_basis(seed.device, basis, degree)


def test_dry_frequencies_match_table_1(seed):
    assert basis_of(seed, "membrane").dry_frequencies == pytest.approx(TABLE_I, rel=1e-10)
    assert basis_of(seed, "full").dry_frequencies == pytest.approx([*TABLE_I, *LOWER.values()], rel=2e-9)
    assert basis_of(seed, "paper").dry_frequencies == pytest.approx(PAPER_RITZ, rel=4e-8)
    assert basis_of(seed, "full").dry_frequencies[:7] == pytest.approx(TABLE_I, rel=1e-10)


@pytest.mark.parametrize("ratio", [1e-3, 0.09])
def test_dry_frequencies_match_the_closed_form_up_to_high_degree(seed, ratio):
    degree = 40
    device = {"thickness": ratio * seed.device.radius, "mass": 30000.0}  # heavy enough for the thickest
    basis = mode_basis(varied(seed, device=device).device, "full", degree)
    closed = np.array([natural_frequencies(basis.shell, n) for n in range(degree + 1)])
    quotients = dict(zip(basis.labels[1:], basis.dry_frequencies, strict=True))
    membrane = [quotients[f"Membrane{n}"] for n in range(degree + 1)]
    bending = [quotients[f"Bending{n}"] for n in range(2, degree + 1)]
    assert membrane == pytest.approx(closed[:, 1], rel=1e-12)
    assert bending == pytest.approx(closed[2:, 0], rel=1e-12)
    values = eigh(basis.stiffness[1:, 1:], basis.inertia[1:, 1:], eigvals_only=True)  # all degrees in one problem
    assert np.sqrt(values) == pytest.approx(np.sort([*membrane, *bending]), rel=1e-10)


@pytest.mark.parametrize(
    ("degree", "published"), [(0, [5.936208]), (2, [5.178951, 73.952054]), (3, [6.452965, 107.664566])]
)
def test_published_membrane_frequencies_under_water(degree, published):
    """Deep in unbounded water with the added mass 4 pi r^3 rho/((n+1)(2n+1)) on the radial displacement."""
    shell = Shell(2.0, 0.01, 10e6, 0.3, 2700.0)
    stiffness, mass = membrane_block(shell, degree), mass_block(shell, degree)
    mass[0, 0] += 4 * np.pi * shell.radius**3 * 1000.0 / ((degree + 1) * (2 * degree + 1))
    size = 2 if degree else 1  # breathing has no meridional part
    found = np.sqrt(eigh(stiffness[:size, :size], mass[:size, :size], eigvals_only=True))
    assert found == pytest.approx(published, abs=6e-7)


@pytest.mark.parametrize("name", ["paper", "membrane", "full"])
def test_largest_displacement_of_every_mode_is_one(seed, name):
    phi = np.linspace(0, np.pi, 20001)
    radial, meridional = basis_of(seed, name, 12).displacement(phi)
    largest = np.hypot(radial, meridional).max(axis=1)
    assert np.all(largest < 1 + 1e-12)
    assert np.all(largest > 1 - (12 * phi[1]) ** 2 / 8)  # a maximum between two samples
    assert np.all(radial[:, 0] > 0)


def test_clamps_that_leave_nothing_free_are_refused(seed):
    study = varied(seed, modes={"degree": 1}, designs={"FSB": {"flexible": False}, "tight": {"clamp": [0, 90]}})
    with pytest.raises(ConfigError, match=r"designs.tight.clamp: received \[0.0, 90.0\], which leaves none of the 2"):
        design_motions(study, study_basis(study), "tight")


def test_rigid_study_has_only_heave(seed):
    study = varied(seed, designs={"FSB": {"flexible": False}})
    basis = study_basis(study)
    assert basis.labels == ("Heave",)
    assert basis.inertia == pytest.approx(np.array([[17170.0]]))
    assert design_motions(study, basis, "FSB").shape == (1, 1)


@pytest.mark.parametrize("name", ["paper", "membrane", "full"])
def test_heave_has_the_mass_of_the_buoy_and_no_stiffness(seed, name):
    basis = basis_of(seed, name)
    assert basis.inertia[0, 0] == 17170.0
    assert np.all(basis.stiffness[0] == 0.0)
    assert np.all(basis.stiffness[:, 0] == 0.0)
    assert np.linalg.eigvalsh(basis.inertia).min() > 0


def test_rayleigh_damping_acts_on_the_modes_only(seed):
    basis = mode_basis(varied(seed, device={"damping": {"alpha": 0.7, "beta": 2e-3}}).device, "full", 3)
    expected = 0.7 * basis.inertia + 2e-3 * basis.stiffness
    assert basis.damping[1:, 1:] == pytest.approx(expected[1:, 1:], rel=1e-14)
    assert np.all(basis.damping[0] == 0.0)
    assert np.all(basis.damping[:, 0] == 0.0)


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


def test_number_of_motions_of_each_design(seed):
    basis = study_basis(seed)
    free = {name: design_motions(seed, basis, name).shape[1] for name in seed.designs}
    assert free == {"FSB": 1, "VSWEC": 8, "VSWEC0": 7, "VSWEC90": 6}


CAPSULE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, capsule(2.0, 1.0))


def test_modes_of_a_capsule_are_orthogonal_with_its_natural_frequencies():
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


@pytest.mark.parametrize("basis", ["paper", "membrane"])
def test_branches_exist_on_the_sphere_only(basis):
    with pytest.raises(ConfigError, match=rf"modes.basis: received '{basis}', but on another shape than the sphere"):
        shell_modes(CAPSULE, basis, 4)


@pytest.mark.parametrize("nu", [-0.3, 0.45])
@pytest.mark.parametrize("degree", [1, 5])
def test_published_amplitude_ratio_follows_from_its_slip(nu, degree):
    """(1 - nu^2) x^2 - (n(n+1) + 1 + 3 nu) x + n(n+1) - 2 = 0 (Baker 1961); the publication uses its larger root as Omega^2."""
    m = degree * (degree + 1)
    omega2 = max(np.roots([1 - nu**2, -(m + 1 + 3 * nu), m - 2]))
    for thickness in (1e-3, 0.1):  # of any shell
        shell = Shell(2.0, thickness, 1e7, nu, 2700.0)
        expected = (1 + (1 + nu) * omega2**2) / (1 - omega2**2)
        assert paper_ratio(shell, degree) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_rank_of_constraints_does_not_depend_on_their_scale(scale):
    one, other = np.array([1.0, 2.0, 0.0, 1.0]), np.array([0.0, 1.0, 1.0, 3.0])
    assert check_rank(scale * np.array([one, other, 2 * one])) == 2
    assert check_rank(scale * np.array([one, one + 1e-3 * other])) == 2
    with pytest.raises(ConfigError, match="received clamps closer than the basis resolves"):
        check_rank(scale * np.array([one, one + 1e-9 * other]))
    assert (check_rank(np.zeros((2, 4))), check_rank(np.zeros((0, 4)))) == (0, 0)


OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))


def test_natural_shapes_are_normalised_and_ordered_by_frequency():
    modes = natural_shapes(OBLATE, 6)
    basis = ModeBasis(OBLATE, modes, 3000.0, bending=True)
    v, u = basis.displacement(np.linspace(0.0, np.pi, 4001))
    assert [mode.label for mode in modes] == [f"Shell{i}" for i in range(1, 13)]
    assert np.hypot(v, u).max(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (v[:, 0] > 0).all()
    assert (np.diff(basis.dry_frequencies) > 0).all()
    assert sorted(mode.parts[0][0] for mode in modes[:3]) == [2, 3, 4]  # as of a sphere's lower branch


EGG = RestMeridian((2.0,), (0.3, 2.2, 0.1, 0.05))  # unlike above and below
SHELLS = [
    Shell(body.radius if body else 1.7, 0.01, 10e6, 0.3, 2700.0, body)
    for body in (None, spheroid(2.0, 3.0), capsule(0.8, 1.0), EGG)
]
PHI = np.linspace(0.1, 3.0, 9)


@pytest.mark.parametrize("shell", SHELLS)
def test_strains_match_differences_of_the_deformed_meridian(shell):
    """Changes of lengths, radii and angles by central differences."""
    basis = ModeBasis(shell, natural_shapes(shell, 5), 3000.0, bending=True)
    rest = DeformedShell(basis, 0.0).meridian(PHI)
    for dof, (e, t, b) in enumerate(zip(*strain_shapes(basis, PHI), strict=True)):
        q = 1e-6 * np.eye(len(basis.labels))[dof]
        there, back = (DeformedShell(basis, 0.0, sign * q).meridian(PHI) for sign in (1, -1))
        lengths = [np.log(np.hypot(m.dx, m.dz)) for m in (there, back)]
        angles = [np.arctan2(m.dz * rest.dx - m.dx * rest.dz, m.dx * rest.dx + m.dz * rest.dz) for m in (there, back)]
        assert (lengths[0] - lengths[1]) / 2e-6 == pytest.approx(e, abs=1e-7)
        assert (np.log(there.x) - np.log(back.x)) / 2e-6 == pytest.approx(t, abs=1e-7)
        assert (angles[0] - angles[1]) / 2e-6 == pytest.approx(b, abs=1e-7)
