import numpy as np
import pytest
from conftest import varied
from scipy.linalg import eigh
from test_shell import LOWER, TABLE_I

from vsb.errors import ConfigError
from vsb.modes import bending_block, design_motions, legendre, mass_block, membrane_block, mode_basis, study_basis
from vsb.shell import natural_frequencies

PAPER_RITZ = [51.434449987, 62.153777189, 86.525263883, 115.855327968, 146.580164630, 177.820039783, 209.298426663]


def basis_of(seed, basis, degree=6):
    return mode_basis(seed.device, basis, degree)


def test_ritz_frequencies_are_table_i(seed):
    assert basis_of(seed, "membrane").dry_frequencies == pytest.approx(TABLE_I, rel=1e-10)
    assert basis_of(seed, "full").dry_frequencies == pytest.approx([*TABLE_I, *LOWER.values()], rel=2e-9)
    assert basis_of(seed, "paper").dry_frequencies == pytest.approx(PAPER_RITZ, rel=4.5e-8)


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
