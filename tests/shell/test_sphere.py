"""Closed forms of the spherical shell: natural frequencies, buckling pressure, validity."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.shell.sphere import Shell, frequency_parameter, natural_frequencies
from vsb.study.meridian import RestMeridian, spheroid

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


def test_product_and_sum_of_the_roots():
    for n in range(2, 41):
        lower, upper = frequency_parameter(SEED, n)
        nu, m, e = 0.3, n * (n + 1) - 2, (0.005**2) / 12
        a = 3 * (1 + nu) + m + e * (m + 3) * (m + 1 + nu)
        b = 1 - nu**2 + e * ((m + 1) ** 2 - nu**2)
        assert (1 - nu**2) * (lower + upper) == pytest.approx(a, rel=1e-13)
        assert (1 - nu**2) * lower * upper == pytest.approx(m * b / (1 - nu**2), rel=1e-13)


def test_buckling_pressure_and_mass_of_the_published_shell():
    assert SEED.buckling_pressure == pytest.approx(302.6, abs=0.1)
    assert SEED.mass == pytest.approx(1357.2, abs=0.1)


@pytest.mark.parametrize("thickness", [0.0, -0.01, 0.2, 1.0])
def test_thickness_outside_thin_shell_theory_is_refused(thickness):
    with pytest.raises(ValueError, match=r"thin-shell theory \(C3\) needs 0 < thickness < radius/10, got thickness="):
        Shell(2.0, thickness, 1e7, 0.3, 2700.0)


@pytest.mark.parametrize(("modulus", "ratio", "density"), [(-1.0, 0.3, 1.0), (1.0, 0.5, 1.0), (1.0, 0.3, 0.0)])
def test_impossible_material_is_refused(modulus, ratio, density):
    with pytest.raises(ValueError, match="a material needs E > 0"):
        Shell(2.0, 0.01, modulus, ratio, density)


@pytest.mark.parametrize("degree", [1, 2, 5, 40, 400])
def test_membrane_limit_of_vanishing_thickness(degree):
    """h -> 0: (1 - nu^2) Omega^4 - (m + 3 (1 + nu)) Omega^2 + m = 0, by companion-matrix roots."""
    thin = Shell(radius=1.0, thickness=1e-12, young_modulus=1.0, poisson_ratio=0.25, density=1.0)
    m = degree * (degree + 1) - 2
    roots = np.sort(np.roots([1 - 0.25**2, -(m + 3 * 1.25), m]))
    assert frequency_parameter(thin, degree) == pytest.approx(roots, rel=1e-9, abs=1e-15)


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


@given(st.floats(0.1, 50.0), st.integers(0, 40))
def test_frequencies_scale_inversely_with_size(factor, degree):
    larger = Shell(2.0 * factor, 0.01 * factor, 10e6, 0.3, 2700.0)
    assert natural_frequencies(larger, degree) * factor == pytest.approx(natural_frequencies(SEED, degree), rel=1e-11)


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


STRETCH, STIFFER, DENSER = 1.7, 3.0, 0.6


def larger(shell, stiffer=STIFFER):
    """The same shell 1.7 times as large, of a material so many times as stiff and 0.6 times as dense.

    At a radius of 2 m r^2 and 2 r are the same number: what holds of this shell, too, knows one from the other.
    """
    return Shell(
        STRETCH * shell.radius,
        STRETCH * shell.thickness,
        stiffer * shell.young_modulus,
        shell.poisson_ratio,
        DENSER * shell.density,
        shell.rest and shell.rest.scaled(STRETCH, STRETCH),
    )
