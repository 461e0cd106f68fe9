"""Laws of elasticity against their own derivatives, inflated balloons in closed form, and each other."""

import numpy as np
import pytest
from scipy.optimize import brentq

from vsb.engine.shell.loaded import ElasticShell, complete_basis
from vsb.engine.shell.material import GentLaw, HookeLaw, MooneyRivlinLaw, NeoHookeanLaw, Range, Wall
from vsb.engine.shell.meridian import spheroid
from vsb.engine.shell.modes import ModeBasis, natural_shapes
from vsb.engine.shell.shell import Shell

LAWS = [HookeLaw(1e6, 0.3), NeoHookeanLaw(1e5), MooneyRivlinLaw(4e4, 1e4), GentLaw(1e5, 30.0)]
RUBBERS = LAWS[1:]
STEP = 1e-30


def rubber_shell(law, radius=2.0, thickness=0.05, rest=None):
    return Shell(radius, thickness, law.young_modulus, law.poisson_ratio, 1100.0, rest, law)


def slopes(function, at):
    """Derivatives of a function of an array by each of its first axis, by a complex step."""
    units = np.eye(len(at)).reshape(len(at), len(at), *[1] * (at.ndim - 1))
    return np.array([function(at + 1j * STEP * unit).imag / STEP for unit in units])


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_stresses_moduli_and_moments_are_derivatives_of_the_energy(law):
    random = np.random.default_rng(3)
    strains = np.concatenate([random.uniform(-0.1, 0.6, (2, 20)), random.normal(size=(2, 20))])
    wall = Wall(law, 0.05)
    np.testing.assert_allclose(slopes(lambda e: law.energy(*e), strains[:2]), law.stresses(*strains[:2]), rtol=1e-13)
    np.testing.assert_allclose(slopes(wall.energy, strains), wall.resultants(strains), rtol=1e-11, atol=1e-7)
    found = wall.moduli(strains).normal
    np.testing.assert_allclose(slopes(wall.resultants, strains), found, atol=1e-13 * np.abs(found).max())


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_shear_turns_the_principal_directions(law):
    # energy of a strain tensor from its eigenvalues: its second derivative by the angle of shear, by differences
    (a, b), step = (0.4, 0.1), 1e-3

    def energy(shear):
        return float(law.energy(*np.linalg.eigvalsh([[a, shear / 2], [shear / 2, b]])))

    second = (energy(step) - 2 * energy(0.0) + energy(-step)) / step**2
    assert law.moduli(np.array(a), np.array(b)).shear == pytest.approx(second, rel=1e-5)
    at_rest = law.moduli(np.zeros(1), np.zeros(1))
    assert at_rest.shear == pytest.approx(law.young_modulus / (2 * (1 + law.poisson_ratio)))
    assert at_rest.mixed / at_rest.first == pytest.approx(law.poisson_ratio)
    assert at_rest.first == pytest.approx(law.young_modulus / (1 - law.poisson_ratio**2))


@pytest.mark.parametrize("law", RUBBERS, ids=lambda law: type(law).__name__)
def test_a_wall_of_rubber_bends_as_its_thinned_thickness_and_tangent_moduli(law):
    wall, bent = Wall(law, 0.01), np.array([0.5, 0.2, 0.03, -0.02])
    flat = bent * [1, 1, 0, 0]
    moduli, thin = wall.moduli(flat).normal, law.thinning(*flat[:2]).stretch
    c = law.moduli(*flat[:2])
    bending = 0.01**3 / 12 * thin**2 * np.array([[c.first, c.mixed], [c.mixed, c.second]])
    np.testing.assert_allclose(moduli[2:, 2:], bending, rtol=1e-12)
    energy = wall.energy(bent) - 0.01 * law.energy(*flat[:2])
    assert energy == pytest.approx(bent[2:] @ bending @ bent[2:] / 2, rel=1e-5)


def test_tensions_of_a_neo_hookean_sheet():
    # uniaxial: lambda_2 = lambda^(-1/2), true stress mu (lambda^2 - 1/lambda) in a wall thinned to h lambda^(-1/2)
    stretch, mu, h = 1.7, 1e5, 0.01
    along, across = NeoHookeanLaw(mu).tensions(stretch, stretch**-0.5, h)
    assert along == pytest.approx(h * stretch**-0.5 * mu * (stretch**2 - 1 / stretch), rel=1e-12)
    assert across == pytest.approx(0.0, abs=1e-10 * along)


def inflation(law, shell, stretch):
    """Pressure in an inflated sphere and the slope of pressure over stretch, from the energy of the shell."""
    elastic = ElasticShell(complete_basis(shell, 4, 1e4))
    q = np.zeros(len(elastic.basis.labels))
    q[1] = (stretch - 1) * shell.radius
    pressure = -elastic.force(q)[1] / elastic.volume_gradient(q)[1]
    softening = elastic.stiffness(q)[1, 1] - pressure * elastic.volume_hessian(q)[1, 1]
    others = np.delete(elastic.force(q) + pressure * elastic.volume_gradient(q), 1)
    assert np.abs(others).max() < 1e-9 * abs(elastic.force(q)[1])  # it stays a sphere
    return pressure, softening * shell.radius / elastic.volume_gradient(q)[1]


@pytest.mark.parametrize("stretch", [1.001, 1.2, 1.383, 2.5])
def test_inflated_balloons_in_closed_form(stretch):
    mu, alpha, jm, ratio = 1e5, 0.2, 30.0, 0.05 / 2.0
    neo = 2 * mu * ratio * (1 / stretch - stretch**-7)
    expected = {
        NeoHookeanLaw(mu): neo,
        MooneyRivlinLaw(mu / 2, alpha * mu / 2): neo * (1 + alpha * stretch**2),
        GentLaw(mu, jm): neo * jm / (jm - 2 * stretch**2 - stretch**-4 + 3),
    }
    for law, pressure in expected.items():
        assert inflation(law, rubber_shell(law), stretch)[0] == pytest.approx(pressure, rel=1e-8)


def test_pressure_is_largest_at_the_limit_point():
    law = NeoHookeanLaw(1e5)
    peak = brentq(lambda stretch: inflation(law, rubber_shell(law), stretch)[1], 1.2, 1.6, xtol=1e-13)
    assert peak == pytest.approx(7 ** (1 / 6), rel=1e-9)
    locking = GentLaw(1e5, 30.0)  # falls after its limit point, and rises again before lock-up
    signs = [np.sign(inflation(locking, rubber_shell(locking), stretch)[1]) for stretch in (1.2, 2.0, 3.8)]
    assert signs == [1, -1, 1]


@pytest.mark.parametrize("law", RUBBERS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("rest", [None, spheroid(2.0, 3.0)], ids=["sphere", "spheroid"])
def test_force_and_stiffness_are_derivatives_of_the_energy_of_a_shell(law, rest):
    shell = rubber_shell(law, rest=rest)
    modes = complete_basis(shell, 4, 1e4).modes if rest is None else natural_shapes(shell, 3)
    elastic = ElasticShell(ModeBasis(shell, modes, 1e4, bending=True))
    q = 0.2 * np.cos(1.7 * np.arange(len(elastic.basis.labels)) + 0.4)
    force, stiffness = elastic.force(q), elastic.stiffness(q)
    np.testing.assert_allclose(-slopes(elastic.energy, q), force, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(-slopes(elastic.force, q), stiffness, atol=1e-12 * np.abs(stiffness).max())
    several = np.array([q, 0.5 * q])
    np.testing.assert_allclose(elastic.force(several)[0], force, rtol=1e-12)
    assert elastic.energy(several)[1] == pytest.approx(elastic.energy(0.5 * q), rel=1e-12)


@pytest.mark.parametrize("law", RUBBERS, ids=lambda law: type(law).__name__)
def test_small_strains_are_those_of_hooke_to_second_order(law):
    shell = rubber_shell(law)
    hooke = Shell(shell.radius, shell.thickness, shell.young_modulus, shell.poisson_ratio, shell.density)
    ours, theirs = (ElasticShell(complete_basis(one, 5, 1e4)) for one in (shell, hooke))
    q = np.cos(1.3 * np.arange(len(ours.basis.labels)) + 0.2)
    q[0] = 0.0
    away = [np.abs(ours.force(step * q) - theirs.force(step * q)).max() for step in (1e-3, 5e-4)]
    assert away[0] / away[1] == pytest.approx(4.0, rel=0.05)
    np.testing.assert_allclose(ours.stiffness(0 * q), ours.basis.stiffness, atol=1e-9 * ours.basis.stiffness.max())


def test_gent_admits_nothing_beyond_lock_up():
    law = GentLaw(1e5, 3.0)
    assert law.admits(np.array([0.5]), np.array([0.5]))
    assert not law.admits(np.array([0.5, 3.0]), np.array([0.5, 3.0]))


def test_a_shell_of_rubber_needs_the_moduli_of_its_law():
    with pytest.raises(ValueError, match="a shell of rubber needs E and nu of its small strains"):
        Shell(2.0, 0.05, 1e7, 0.3, 1100.0, None, NeoHookeanLaw(1e5))


def test_a_strain_at_a_bound_of_its_law_is_not_beyond_it():
    """A design optimised under that bound rests at it to round-off."""
    bounds = Range("a law", "strain", 0.1, 0.2)
    assert not bounds.is_doubted(0.1 * (1 + 1e-9))
    assert bounds.is_doubted(0.1001)
    assert not bounds.is_invalid(0.2 * (1 + 1e-9))
    assert bounds.is_invalid(0.2001)
