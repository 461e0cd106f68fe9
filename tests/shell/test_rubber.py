"""Shells of rubber under load: balloons without water in closed form, limit points, buoys at rest."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import brentq, minimize
from verification import membrane

from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import ElasticShell, Gas, LoadedShell, complete_basis, equilibrium, stable_path
from vsb.engine.shell.material import GentLaw, MooneyRivlinLaw, NeoHookeanLaw
from vsb.engine.shell.shell import Shell
from vsb.errors import ConvergenceError

MU, RADIUS, THICKNESS = 1e5, 2.0, 0.05
GAS = Gas(adiabatic_index=1.4, atmospheric_pressure=101325.0)
MOST = 2 * MU * THICKNESS / RADIUS * (7 ** (-1 / 6) - 7 ** (-7 / 6))
"""Largest pressure in a neo-Hookean sphere [Pa]."""


def shell_of(law, thickness=THICKNESS):
    return Shell(RADIUS, thickness, law.young_modulus, law.poisson_ratio, 1100.0, None, law)


def balloon(law, pressure, gas=None, degree=3):
    """A shell without water and weight."""
    return LoadedShell(ElasticShell(complete_basis(shell_of(law), degree, 1e4)), 0.0, 0.0, 0.0, pressure, gas)


def buoy(law, pressure, degree=6, thickness=THICKNESS, gas=None):
    elastic = ElasticShell(complete_basis(shell_of(law, thickness), degree, 17170.0))
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


@pytest.mark.parametrize("law", [NeoHookeanLaw(1e6), MooneyRivlinLaw(4e5, 1e5), GentLaw(1e6, 20.0)])
def test_a_buoy_rests_where_its_forces_balance_and_its_stiffness_is_their_slope(law):
    loaded = buoy(law, 25e3)
    q, step = equilibrium(loaded), 1e-5
    force, stiffness = loaded.force_and_stiffness(q)
    scale = loaded.gravity * loaded.basis.total_mass
    assert np.abs(force).max() < 1e-9 * scale
    assert q[1] > 0.05 * RADIUS  # not small
    slope = [(loaded.force(q - step * e) - loaded.force(q + step * e)) / (2 * step) for e in np.eye(len(q))]
    np.testing.assert_allclose(stiffness, slope, atol=1e-7 * np.abs(stiffness).max())


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
        ElasticShell(complete_basis(shell_of(law, thickness), degree, mass)), 0.0, membrane.WATER, 9.81, pressure
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


def constant(pressure):
    """Energy of what is inside under constant pressure, by the volume."""
    return lambda volume: -pressure * volume


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


@pytest.mark.parametrize(
    ("law", "kind"),
    [*((law, "open") for law in RANDOM), ("gent", "near lock-up"), ("mooney_rivlin", "held"), ("neo_hookean", "gas")],
)
def test_random_buoys_rest_at_the_least_of_an_energy_written_anew(law, kind):
    random, (of, energy) = np.random.default_rng([len(law), len(kind)]), RANDOM[law]
    thickness, mu = random.uniform(0.04, 0.08), random.uniform(0.9e6, 1.5e6)
    moduli = {"neo_hookean": (mu,), "mooney_rivlin": (0.4 * mu, 0.1 * mu), "gent": (mu, 8.0)}[law]
    pressure, degree, mass = random.uniform(0.6, 0.8) * MOST * (mu * thickness) / (MU * THICKNESS), 4, 17170.0
    if kind == "near lock-up":
        moduli, pressure = (mu / 3, random.uniform(0.5, 0.6)), random.uniform(45e3, 60e3)
    pressure *= 3.0 if kind == "gas" else 1.0
    shell, gas = shell_of(of(*moduli), thickness), GAS if kind == "gas" else None
    loaded = buoy(shell.law, pressure, degree, thickness, gas)
    free = ring_held(random.uniform(40.0, 140.0), degree) if kind == "held" else np.eye(2 * degree + 1)
    inside = trapped(pressure) if gas else constant(pressure)

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
