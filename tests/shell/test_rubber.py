"""Shells of rubber under load: balloons without water in closed form, limit points, buoys at rest."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from verification import membrane

from vsb.errors import ConvergenceError
from vsb.shell.deformed import DeformedShell
from vsb.shell.elastic import ElasticShell
from vsb.shell.loaded import Gas, LoadedShell, complete_basis, equilibrium, stable_path
from vsb.shell.materials import GentLaw, MooneyRivlinLaw, NeoHookeanLaw
from vsb.shell.shell import Shell

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
