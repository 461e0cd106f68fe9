"""Laws of elasticity against their own derivatives, inflated balloons in closed form, and each other."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import brentq, minimize
from verification import membrane

from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import ElasticShell, Gas, LoadedShell, complete_basis, equilibrium, stable_path
from vsb.engine.shell.material import GentLaw, HookeLaw, MooneyRivlinLaw, NeoHookeanLaw, Range, Wall
from vsb.engine.shell.meridian import spheroid
from vsb.engine.shell.modes import ModeBasis, natural_shapes
from vsb.engine.shell.shell import Shell
from vsb.errors import ConvergenceError

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


MU, RADIUS, THICKNESS = 1e5, 2.0, 0.05
GAS = Gas(adiabatic_index=1.4, atmospheric_pressure=101325.0)
MOST = 2 * MU * THICKNESS / RADIUS * (7 ** (-1 / 6) - 7 ** (-7 / 6))
"""Largest pressure in a neo-Hookean sphere [Pa]."""


def balloon(law, pressure, gas=None, degree=3):
    """A shell without water and weight."""
    return LoadedShell(ElasticShell(complete_basis(rubber_shell(law), degree, 1e4)), 0.0, 0.0, 0.0, pressure, gas)


def buoy(law, pressure, degree=6, thickness=THICKNESS, gas=None):
    elastic = ElasticShell(complete_basis(rubber_shell(law, thickness=thickness), degree, 17170.0))
    return LoadedShell(elastic, 0.0, 1025.0, 9.81, pressure, gas)


def held(loaded):
    """Its modes alone: nothing brings a heaving balloon back."""
    return np.eye(len(loaded.basis.labels))[:, 1:]


def inflated(stretch):
    """Pressure in a neo-Hookean sphere [Pa]."""
    return 2 * MU * THICKNESS / RADIUS * (1 / stretch - stretch**-7)


def test_a_balloon_under_constant_pressure_stretches_as_in_closed_form():
    pressure = 0.9 * MOST
    stretch = brentq(lambda value: inflated(value) - pressure, 1.0, 7 ** (1 / 6))
    loaded = balloon(NeoHookeanLaw(MU), pressure)
    q = equilibrium(loaded, held(loaded))
    assert 1 + q[1] / RADIUS == pytest.approx(stretch, rel=1e-9)
    assert np.abs(np.delete(q, 1)).max() < 1e-9


def test_a_damper_spread_over_rubber_has_the_moduli_of_the_stretched_material():
    """Of a breathing balloon d2W/dE2 = 12 mu/lambda^8 with both strains alike, and dE/dq = lambda/r."""
    elastic, stretch = balloon(NeoHookeanLaw(MU), 0.0).elastic, 1.3
    q = np.zeros(len(elastic.basis.labels))
    q[1] = RADIUS * (stretch - 1)
    factor = elastic.membrane_factor(q)
    assert (factor @ factor.T)[1, 1] == pytest.approx(48 * np.pi * MU * THICKNESS / stretch**6, rel=1e-9)


def test_the_limit_point_is_refused_with_its_pressure():
    with pytest.raises(ConvergenceError, match=r"passes its limit point at 0\.\d+ of its load, at an internal press"):
        equilibrium(loaded := balloon(NeoHookeanLaw(MU), 1.25 * MOST), held(loaded))
    reached = stable_path(replace(loaded, internal_pressure=MOST), held(loaded), until=2.0).reached
    assert 1 - 1e-3 < reached <= 1.0


def test_trapped_gas_leads_past_the_limit_point():
    filled = 8 * MOST + 4e5  # at the undeformed volume, gauge
    loaded = balloon(NeoHookeanLaw(MU), filled, GAS)
    q = equilibrium(loaded, held(loaded))
    stretch = brentq(lambda s: (101325.0 + filled) * s**-4.2 - 101325.0 - inflated(s), 1.1, 4.0)
    assert stretch > 7 ** (1 / 6)
    assert 1 + q[1] / RADIUS == pytest.approx(stretch, rel=1e-9)
    assert loaded.pressure(q) == pytest.approx(inflated(stretch), rel=1e-8)


def test_gent_stays_below_its_lock_up_under_any_pressure():
    stiffening = GentLaw(MU, 3.0)  # without a limit point
    loaded = balloon(stiffening, 20 * MOST)
    q = equilibrium(loaded, held(loaded))
    stretch = 1 + q[1] / RADIUS
    left = 3.0 - 2 * stretch**2 - stretch**-4 + 3
    assert 0 < left < 0.5
    assert inflated(stretch) * 3.0 / left == pytest.approx(20 * MOST, rel=1e-7)


@pytest.mark.parametrize(
    ("law", "slopes", "degree", "error"),
    [
        (NeoHookeanLaw(5e7), membrane.neo_hookean(5e7), 40, 4e-6),
        pytest.param(MooneyRivlinLaw(2e7, 5e6), membrane.mooney_rivlin(2e7, 5e6), 40, 4e-6, marks=pytest.mark.slow),
        pytest.param(NeoHookeanLaw(5e7), membrane.neo_hookean(5e7), 60, 1e-6, marks=pytest.mark.slow),
    ],
    ids=["neo_hookean", "mooney_rivlin", "neo_hookean_60"],
)
def test_a_floating_balloon_is_that_of_membrane_equations_by_shooting(law, slopes, degree, error):
    """A wall of a millimetre bends freely; what is left goes with the degree, for pressure has a kink at the water."""
    mass, thickness, pressure = membrane.WATER * 2 / 3 * np.pi * RADIUS**3, 1e-3, 24e3
    loaded = LoadedShell(
        ElasticShell(complete_basis(rubber_shell(law, thickness=thickness), degree, mass)),
        0.0,
        membrane.WATER,
        9.81,
        pressure,
    )
    shape = DeformedShell(loaded.basis, 0.0, equilibrium(loaded))
    poles, phi = shape.meridian(np.array([1e-9, np.pi - 1e-9])), np.linspace(0.05, np.pi - 0.05, 61)
    balloon = membrane.Balloon(RADIUS, thickness, slopes, mass, pressure)
    x, z = balloon.meridian(phi, (1.15, poles.z[0], 1.1, poles.z[1]))
    found = shape.meridian(phi)
    assert x.max() > 1.08 * RADIUS
    assert np.abs([found.x - x, found.z - z]).max() < error * RADIUS


def own_energy(q, law, shell, mass, contents, degree, count=2000):
    """Energy of a buoy at rest by the midpoint rule, from stretches of line elements, layers and a polygon of water."""
    phi = np.pi * (np.arange(count) + 0.5) / count
    r, h, dphi = shell.radius, shell.thickness, np.pi / count
    v, dv, ddv, u, du, ddu = np.zeros((6, count), dtype=complex)
    pairs = [(0, q[1], 0.0), (1, q[0] + q[2], q[0] - q[2] / 2)]
    pairs += [(n, q[2 * n - 1], q[2 * n] / n) for n in range(2, degree + 1)]
    for n, radial, along in pairs:
        p = np.polynomial.legendre.Legendre.basis(n)
        cos, sin = np.cos(phi), np.sin(phi)
        d0, d1 = p(cos), -sin * p.deriv()(cos)
        d2 = sin**2 * p.deriv(2)(cos) - cos * p.deriv()(cos)
        d3 = -(sin**3) * p.deriv(3)(cos) + 3 * sin * cos * p.deriv(2)(cos) + sin * p.deriv()(cos)
        v, dv, ddv = v + radial * d0, dv + radial * d1, ddv + radial * d2
        u, du, ddu = u + along * d1, du + along * d2, ddu + along * d3
    x, z = (r + v) * np.sin(phi) + u * np.cos(phi), (r + v) * np.cos(phi) - u * np.sin(phi)
    dx = (dv - u) * np.sin(phi) + (r + v + du) * np.cos(phi)
    dz = (dv - u) * np.cos(phi) - (r + v + du) * np.sin(phi)
    one, other = np.sqrt(dx**2 + dz**2) / r, x / (r * np.sin(phi))
    bent = np.array([-(ddv - du) / r**2, -(dv - u) / np.tan(phi) / r**2])
    node, weight = np.polynomial.legendre.leggauss(2)
    area, elastic = 2 * np.pi * r**2 * np.sin(phi) * dphi, 0.0
    for place, share in zip(node * h / 2, weight / 2, strict=True):
        a, b = (np.sqrt(s**2 + 2 * place / (one * other) * k) for s, k in zip((one, other), bent, strict=True))
        elastic = elastic + h * share * (law(a, b) @ area)
    volume = -np.pi * (x**2 * dz).sum() * dphi
    water = -1025.0 * 9.81 * np.pi * (np.where(z.real < 0, z**2, 0.0) * x * dx).sum() * dphi
    return elastic + contents(volume) + water + mass * 9.81 * q[0]


RANDOM = {
    "neo_hookean": (NeoHookeanLaw, lambda a, b, m: m[0] / 2 * (a**2 + b**2 + (a * b) ** -2 - 3)),
    "mooney_rivlin": (
        MooneyRivlinLaw,
        lambda a, b, m: m[0] * (a**2 + b**2 + (a * b) ** -2 - 3) + m[1] * (a**-2 + b**-2 + (a * b) ** 2 - 3),
    ),
    "gent": (GentLaw, lambda a, b, m: -m[0] * m[1] / 2 * np.log(1 - (a**2 + b**2 + (a * b) ** -2 - 3) / m[1])),
}


def trapped(pressure, gas=GAS):
    """The same of gas that obeys p V^1.4 = const., pressures with that of the air."""
    whole, air, first = gas.atmospheric_pressure + pressure, gas.atmospheric_pressure, 4 / 3 * np.pi * RADIUS**3
    return lambda volume: air * volume + whole * first / 0.4 * (first / volume) ** 0.4


def ring_held(colatitude, degree):
    """Motions that leave a ring of the shell on its frame, from both displacements there."""
    p, at = np.polynomial.legendre.Legendre.basis, np.deg2rad(colatitude)
    rows = np.zeros((2, 2 * degree + 1))
    for n in range(degree + 1):
        value, slope = p(n)(np.cos(at)), -np.sin(at) * p(n).deriv()(np.cos(at))
        rows[0, 2 * n - (n > 0) + (n < 2)] = value
        if n:
            rows[1, 2 * n] = -slope / 2 if n == 1 else slope / n
    return null_space(rows)


@pytest.mark.parametrize(("law", "kind"), [("gent", "near lock-up"), ("mooney_rivlin", "held"), ("neo_hookean", "gas")])
def test_random_buoys_rest_at_the_least_of_an_energy_written_anew(law, kind):
    random, (of, energy) = np.random.default_rng([len(law), len(kind)]), RANDOM[law]
    thickness, mu = random.uniform(0.04, 0.08), random.uniform(0.9e6, 1.5e6)
    moduli = {"neo_hookean": (mu,), "mooney_rivlin": (0.4 * mu, 0.1 * mu), "gent": (mu, 8.0)}[law]
    pressure, degree, mass = random.uniform(0.6, 0.8) * MOST * (mu * thickness) / (MU * THICKNESS), 4, 17170.0
    if kind == "near lock-up":
        moduli, pressure = (mu / 3, random.uniform(0.5, 0.6)), random.uniform(45e3, 60e3)
    pressure *= 3.0 if kind == "gas" else 1.0
    shell, gas = rubber_shell(of(*moduli), thickness=thickness), GAS if kind == "gas" else None
    loaded = buoy(shell.law, pressure, degree, thickness, gas)
    free = ring_held(random.uniform(40.0, 140.0), degree) if kind == "held" else np.eye(2 * degree + 1)
    inside = trapped(pressure) if gas else (lambda volume: -pressure * volume)

    def total(x):
        return own_energy(free @ x, lambda a, b: energy(a, b, moduli), shell, mass, inside, degree)

    def slope(x):
        return np.array([total(x + 1e-20j * e).imag / 1e-20 for e in np.eye(len(x))])

    q, unit = equilibrium(loaded, free), 0.02
    found = minimize(
        lambda y: total(unit * y).real,
        0.9 * free.T @ q / unit,
        jac=lambda y: unit * slope(unit * y),
        method="L-BFGS-B",  # whose steps grow: a long first one would be beyond lock-up
        options={"ftol": 1e-16, "gtol": 2e-5, "maxcor": 20},
    )
    np.testing.assert_allclose(free @ (unit * found.x), q, atol=1e-6 * RADIUS)
    assert np.abs(q).max() > 0.05
    if kind == "near lock-up":
        assert shell.law.strained(*loaded.elastic.strains(q)).max() > 0.7
