"""Closed shells: natural frequencies and buckling of the sphere in closed form, meridians, Legendre functions."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.engine.shell.meridian import RestMeridian, spheroid
from vsb.engine.shell.ritz import legendre
from vsb.engine.shell.shell import Shell, natural_frequencies

SEED = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
TABLE_I = [51.434449987, 62.994144454, 86.823947954, 115.941895367, 146.610087987, 177.832640732, 209.304856685]
LOWER = {2: 22.3593100, 3: 26.4773949, 4: 28.1000629, 5: 28.9095098, 6: 29.3859861}


def test_upper_branch_matches_table_1():
    upper = [natural_frequencies(SEED, n)[1] for n in range(7)]
    assert upper == pytest.approx(TABLE_I, rel=1e-11)


def test_lower_branch_and_rigid_heave():
    assert natural_frequencies(SEED, 1)[0] == 0.0
    assert [natural_frequencies(SEED, n)[0] for n in LOWER] == pytest.approx(list(LOWER.values()), rel=2e-9)


def test_steel_sphere_matches_published_frequencies():
    """AFNOR/VPCS SDLS07: bending branch of a closed steel sphere, to its printed digits."""
    steel = Shell(radius=2.5, thickness=0.1, young_modulus=2e11, poisson_ratio=0.3, density=7800.0)
    lines = (Path(__file__).parents[1] / "data" / "shell_SDLS07.csv").read_text().splitlines()[1:]
    for row in csv.DictReader(lines):
        hertz = natural_frequencies(steel, int(row["n"]))[0] / (2 * np.pi)
        published = row["f_Hz_published"]
        digits = len(published.partition(".")[2])
        assert hertz == pytest.approx(float(published), abs=0.5 * 10**-digits)
        formula = next(value for key, value in row.items() if key.startswith("f_Hz_formula"))
        assert hertz == pytest.approx(float(formula), abs=0.5e-4)  # the same, to the digits of the closed form


def test_buckling_pressure_and_mass_of_the_published_shell():
    assert SEED.buckling_pressure == pytest.approx(302.6, abs=0.1)
    assert SEED.mass == pytest.approx(1357.2, abs=0.1)


@pytest.mark.parametrize("thickness", [0.0, 0.2])
def test_thickness_outside_thin_shell_theory_is_refused(thickness):
    with pytest.raises(ValueError, match=r"thin-shell theory \(C3\) needs 0 < thickness < radius/10, got thickness="):
        Shell(2.0, thickness, 1e7, 0.3, 2700.0)


@pytest.mark.parametrize(("modulus", "ratio", "density"), [(-1.0, 0.3, 1.0), (1.0, 0.51, 1.0), (1.0, 0.3, 0.0)])
def test_impossible_material_is_refused(modulus, ratio, density):
    with pytest.raises(ValueError, match="a material needs E > 0"):
        Shell(2.0, 0.01, modulus, ratio, density)


def test_lower_branch_approaches_a_plate_at_high_degree():
    """omega^2 -> D k^4/(rho h) + E/(rho r^2), k = n/r, for waves short against the radius and long against h."""
    shell = Shell(radius=1.0, thickness=1e-4, young_modulus=1.0, poisson_ratio=0.3, density=1.0)
    ratios = []
    for n in (200, 400, 800):
        plate = shell.bending_stiffness * (n + 0.5) ** 4 / 1e-4 + 1.0
        ratios.append(abs(natural_frequencies(shell, n)[0] ** 2 / plate - 1))
    assert ratios[0] > 3 * ratios[1] > 9 * ratios[2]
    assert ratios[2] < 1e-4


@given(st.floats(0.1, 50.0), st.floats(1e-4, 0.09), st.floats(1e5, 1e12), st.floats(-0.9, 0.49), st.floats(10.0, 2e4))
def test_breathing_frequency_of_any_sphere(radius, ratio, modulus, nu, density):
    shell = Shell(radius, ratio * radius, modulus, nu, density)
    exact = np.sqrt(2 * modulus / (density * radius**2 * (1 - nu)))
    assert natural_frequencies(shell, 0) == pytest.approx([0.0, exact], rel=1e-12)


OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))


def test_mass_and_volume_of_a_spheroid():
    assert OBLATE.mass == pytest.approx(2700.0 * 0.01 * spheroid(2.0, 3.0).area)
    assert OBLATE.volume == pytest.approx(4 / 3 * np.pi * 2.0**2 * 1.5)
    assert SEED.volume == pytest.approx(4 / 3 * np.pi * 2.0**3)
    at, sphere = OBLATE.at_rest(np.array([0.5])), SEED.at_rest(np.array([0.5]))
    assert (at.x, at.z) == (pytest.approx(sphere.x), pytest.approx(0.75 * sphere.z))


@pytest.mark.parametrize("closed_form", [lambda s: s.buckling_pressure, lambda s: natural_frequencies(s, 2)])
def test_closed_forms_are_refused_for_other_shapes(closed_form):
    with pytest.raises(ValueError, match="closed forms are those of the sphere"):
        closed_form(OBLATE)


def test_meridian_must_match_radius_and_thickness():
    with pytest.raises(ValueError, match=r"needs the shell's radius, 1\.0 m, got 2\.0 m"):
        Shell(1.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))
    with pytest.raises(ValueError, match=r"a tenth of the radii of curvature, got thickness=0\.1 m for a least radius"):
        Shell(2.0, 0.1, 10e6, 0.3, 2700.0, spheroid(2.0, 1.0))


@pytest.mark.parametrize(
    ("radial", "axial", "reach"),
    [(2.0, (0.0, 1.5), 2.0), (2.0, (0.0, 3.0), 3.0), (2.0, (0.5, 3.0), 3.5), (2.0, (-0.5, 3.0), 3.5)],
    ids=["flat", "long", "high", "low"],
)
def test_reach_is_the_largest_distance_from_the_centre(radial, axial, reach):
    assert Shell(2.0, 0.01, 1e7, 0.3, 2700.0, RestMeridian((radial,), axial)).reach == pytest.approx(reach, rel=1e-12)
    assert SEED.reach == 2.0


def test_legendre_equation_and_poles():
    """(sin phi P')' + n(n+1) sin phi P = 0; at the poles P = (+-1)^n, P' = 0, P'' = -n(n+1)/2 P."""
    phi, n = np.linspace(0.3, 2.8, 9), np.arange(13)[:, None]
    p, dp, ddp = legendre(12, phi)
    assert ddp * np.sin(phi) + dp * np.cos(phi) == pytest.approx(-n * (n + 1) * np.sin(phi) * p, abs=1e-11)
    p, dp, ddp = legendre(12, np.array([0.0, np.pi]))
    assert p == pytest.approx(np.hstack([n**0, (-1) ** n]))
    assert np.abs(dp).max() < 1e-13
    assert ddp == pytest.approx(-n * (n + 1) / 2 * p)
