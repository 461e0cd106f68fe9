"""Errors that the benchmarks state beside their seconds: references, quadrature, integrators. No timings."""

from pathlib import Path

import numpy as np
import pytest
from conftest import varied

from benchmarks import coefficients as hp
from benchmarks.general_solvers import Equation
from benchmarks.integrators import EXPONENTIAL, SOLVERS, TOLERANCES, integrator_precision, plain_rates
from benchmarks.quadrature import disc_force, disc_volume, gauss_force, quadrature_precision, scene_of_design
from vsb.motion.system import System
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import rigid_basis
from vsb.study import study as config

CONFIG = Path(__file__).parents[2] / "config"


@pytest.fixture(scope="module")
def paper():
    """The paper's study, two seconds of it."""
    return varied(
        config.load(CONFIG / "paper.yaml"), simulation={"duration": 2.0, "window": [1.0, 2.0]}, published=None
    )


@pytest.fixture(scope="module")
def solved(green_folder):
    """Name -> coefficients of the coarsest mesh."""
    names = [name for name in hp.METHODS if name != hp.SPECTRAL]
    return {n: hp.METHODS[n].solve(6, str(green_folder), [float(w) for w in np.sqrt(hp.KA)]) for n in names}


def test_reference_agrees_with_the_multipole_series_to_its_error(hemisphere):
    i, at = hemisphere["Ka"].index(1.0), hp.reference().sel(omega=1.0)
    for found, series in (
        (at.added_mass.values, hemisphere["added_mass"][i]),
        (at.radiation_damping.values, hemisphere["radiation_damping"][i]),
        (np.abs(at.Froude_Krylov_force + at.diffraction_force).values[0], hemisphere["abs_excitation"][i]),
    ):
        assert np.abs(found - np.array(series)).max() < 1e-5 * np.abs(series).max()


def test_capytaine_of_every_symmetry_and_the_rings_agree_to_round_off(solved):
    """So their errors are one, and seconds and memory all that differs; 12 panels around alias the wave."""
    plain = solved[hp.PLAIN]
    for name in ("capytaine, two planes", hp.ROTATION, "rings"):
        for quantity, limit in (("added_mass", 1e-12), ("radiation_damping", 1e-12), ("Froude_Krylov_force", 1e-9)):
            value = solved[name][quantity].transpose(*plain[quantity].dims).values
            assert np.abs(value - plain[quantity].values).max() < limit * np.abs(plain[quantity].values).max()


def test_spectral_error_falls_faster_than_any_power():
    omegas = [float(w) for w in np.sqrt(hp.KA)]
    found = [hp.errors(hp.METHODS[hp.SPECTRAL].solve(n, "", omegas))["error"] for n in (6, 12, 24)]
    assert found[1] < found[0] / 30
    assert found[2] < found[1] / 1000


def test_right_hand_sides_are_one(paper):
    scene = scene_of_design(paper, "VSWEC90")
    n = scene.motions.shape[1]
    state = 0.02 * np.random.default_rng(1).normal(size=2 * n)
    fast, plain = (
        Equation.of(System.of(scene), scene.start(0.0, 0.0)).rates(0.3, state),
        plain_rates(scene, gauss_force, 40)(0.3, state),
    )
    assert np.abs(fast - plain).max() < 1e-12 * np.abs(fast).max()
    discs = plain_rates(scene, disc_force, 20000)(0.3, state)
    assert 1e-8 < np.abs(fast - discs).max() / np.abs(fast).max() < 1e-2


@pytest.mark.parametrize("height", [1.0, -1.2])
def test_lower_and_upper_sums_of_discs_bracket_a_sphere_cap(paper, height):
    depth = 2.0 - height
    found = disc_volume(DeformedShell(rigid_basis(paper.device), height), 333)
    assert found.lower < np.pi * depth**2 * (3 * 2.0 - depth) / 3 < found.upper


def test_quadrature_is_exact_where_discs_are_of_first_order(paper):
    rows = quadrature_precision(paper)

    def force(method):
        return [row for row in rows if (row["case"], row["method"]) == ("force", method)]

    assert force("discs")[0]["order"] == pytest.approx(1.0, abs=0.05)
    assert force("Gauss-Legendre")[-1]["error"] < 1e-13
    assert force("exact kernel")[0]["error"] < 1e-13


def test_errors_of_integrators_fall_with_the_tolerance_and_the_reference_is_confirmed(paper):
    rows = integrator_precision(paper, "VSWEC0")
    for method, tolerances in {EXPONENTIAL: TOLERANCES, **SOLVERS}.items():
        found = np.array([r["error"] for r in rows if (r["method"], r["table"]) == (method, "integrators")])
        assert len(found) == len(tolerances)
        assert np.all(found[1:] < 1.05 * found[:-1]), (method, found)
    (check,) = (row for row in rows if row["table"] == "reference")
    assert check["error"] < 1e-10
