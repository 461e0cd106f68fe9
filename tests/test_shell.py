import csv
from pathlib import Path

import numpy as np
import pytest

from vsb.shell import Shell, frequency_parameter, natural_frequencies

SEED = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
TABLE_I = [51.434449987, 62.994144454, 86.823947954, 115.941895367, 146.610087987, 177.832640732, 209.304856685]
LOWER = {2: 22.3593100, 3: 26.4773949, 4: 28.1000629, 5: 28.9095098, 6: 29.3859861}


def test_full_formulation_of_table_i():
    upper = [natural_frequencies(SEED, n)[1] for n in range(7)]
    assert upper == pytest.approx(TABLE_I, rel=1e-11)


def test_lower_branch_and_rigid_heave():
    assert natural_frequencies(SEED, 1)[0] == 0.0
    assert [natural_frequencies(SEED, n)[0] for n in LOWER] == pytest.approx(list(LOWER.values()), rel=2e-9)


def test_steel_sphere_as_published():
    """AFNOR/VPCS SDLS07: bending branch of a closed steel sphere, to its printed digits."""
    steel = Shell(radius=2.5, thickness=0.1, young_modulus=2e11, poisson_ratio=0.3, density=7800.0)
    lines = (Path(__file__).parent / "data" / "shell_SDLS07.csv").read_text().splitlines()[1:]
    for row in csv.DictReader(lines):
        hertz = natural_frequencies(steel, int(row["n"]))[0] / (2 * np.pi)
        assert hertz == pytest.approx(float(row["f_Hz_published"]), abs=0.012)


def test_product_and_sum_of_the_roots():
    for n in range(2, 41):
        lower, upper = frequency_parameter(SEED, n)
        nu, m, e = 0.3, n * (n + 1) - 2, (0.005**2) / 12
        a = 3 * (1 + nu) + m + e * (m + 3) * (m + 1 + nu)
        b = 1 - nu**2 + e * ((m + 1) ** 2 - nu**2)
        assert (1 - nu**2) * (lower + upper) == pytest.approx(a, rel=1e-13)
        assert (1 - nu**2) * lower * upper == pytest.approx(m * b / (1 - nu**2), rel=1e-13)


def test_classical_buckling_pressure_and_mass_of_the_seed():
    assert SEED.buckling_pressure == pytest.approx(302.6, abs=0.1)
    assert SEED.mass == pytest.approx(1357.2, abs=0.1)


@pytest.mark.parametrize("thickness", [0.0, -0.01, 0.2, 1.0])
def test_thick_or_no_shell_is_refused(thickness):
    with pytest.raises(ValueError, match=r"thin-shell theory \(C3\) needs 0 < thickness < radius/10, got thickness="):
        Shell(2.0, thickness, 1e7, 0.3, 2700.0)


@pytest.mark.parametrize(("modulus", "ratio", "density"), [(-1.0, 0.3, 1.0), (1.0, 0.5, 1.0), (1.0, 0.3, 0.0)])
def test_impossible_material_is_refused(modulus, ratio, density):
    with pytest.raises(ValueError, match="a material needs E > 0"):
        Shell(2.0, 0.01, modulus, ratio, density)
