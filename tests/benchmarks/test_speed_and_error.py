"""Errors that the benchmarks state beside their seconds: references, integrators. No timings."""

from pathlib import Path

import numpy as np
import pytest
from conftest import varied

from benchmarks import coefficients as hp
from benchmarks.time_domain import under_pressure
from vsb.study import study as config

CONFIG = Path(__file__).parents[2] / "config"


@pytest.fixture(scope="module")
def paper():
    """Two seconds of the paper's shell, clamped at the top, under its assumed pressure."""
    study = config.load(CONFIG / "paper.yaml")
    designs = {"VSWEC0": study.designs["VSWEC0"].model_dump()}
    short = varied(study, designs=designs, simulation={"duration": 2.0, "window": [1.0, 2.0]}, published=None)
    ((_, case),) = under_pressure(short, "unused")
    return case


def test_reference_agrees_with_the_multipole_series_to_its_error(hemisphere):
    i, at = hemisphere["Ka"].index(1.0), hp.reference().sel(omega=1.0)
    for found, series in (
        (at.added_mass.values, hemisphere["added_mass"][i]),
        (at.radiation_damping.values, hemisphere["radiation_damping"][i]),
        (np.abs(at.Froude_Krylov_force + at.diffraction_force).values[0], hemisphere["abs_excitation"][i]),
    ):
        assert np.abs(found - np.array(series)).max() < 1e-5 * np.abs(series).max()


def test_capytaine_of_every_symmetry_and_the_rings_agree_to_round_off(green_folder):
    """So their errors are one, and only seconds and memory differ; 12 panels around alias the wave."""
    omegas = [float(w) for w in np.sqrt(hp.KA[:2])]
    plain, *others = (
        hp.METHODS[name].solve(6, str(green_folder), omegas)
        for name in (hp.PLAIN, "capytaine, two planes", hp.ROTATION, "rings")
    )
    for found in others:
        for quantity, limit in (("added_mass", 1e-12), ("radiation_damping", 1e-12), ("Froude_Krylov_force", 1e-9)):
            value = found[quantity].transpose(*plain[quantity].dims).values
            assert np.abs(value - plain[quantity].values).max() < limit * np.abs(plain[quantity].values).max()


def test_spectral_error_falls_faster_than_any_power():
    omegas = [float(w) for w in np.sqrt(hp.KA)]
    found = [hp.errors(hp.METHODS[hp.SPECTRAL].solve(n, "", omegas))["error"] for n in (6, 12, 24)]
    assert found[1] < found[0] / 30
    assert found[2] < found[1] / 1000


@pytest.mark.slow
def test_errors_of_integrators_fall_with_their_setting_and_the_reference_is_confirmed(paper):
    runs = {
        "exponential Adams": [(paper.exponential(tolerance), 1) for tolerance in (1e-4, 1e-6, 1e-8)],
        "RK45": [(paper.general("RK45", tolerance), 1) for tolerance in (1e-3, 1e-7)],
        "Radau": [(paper.general("Radau", tolerance), 1) for tolerance in (1e-3, 1e-5)],
    }
    for method, found in runs.items():
        errors = np.array([paper.errors(one, stride)["error"] for one, stride in found])
        assert np.all(errors[1:] < errors[:-1] / 3), (method, errors)
    assert paper.errors(paper.general("DOP853", 1e-12))["error"] < 1e-10
