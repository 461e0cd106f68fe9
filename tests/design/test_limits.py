"""Damage of a wall by fatigue: Rayleigh's ranges, the strains of a study, limits known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import find_peaks
from scipy.stats import rayleigh

from tests.design.conftest import campaigns_buoy, study_of
from vsb.design.evaluation import DesignModel
from vsb.design.limits import damages
from vsb.design.year import FrequencyGrid
from vsb.engine.shell.modes import curvature_shapes, strain_shapes
from vsb.engine.waves.climate import YEAR_HOURS, Climate
from vsb.models.rest import reference_shell
from vsb.study.design import Fatigue

THICK = {"thickness": 0.1, "internal_pressure": 0.0, "young_modulus": 3e7}
SPHERE = {"designs": {"VSWEC": {}}, "reference_shape": "undeformed", "device": THICK}
SPHEROID = {"reference_shape": "undeformed", "device": THICK | {"shape": {"spheroid": {"height": 3.0}}}}


@pytest.mark.parametrize("exponent", [1.0, 3.0, 8.5])
def test_damage_of_a_sea_is_that_of_ranges_by_rayleigh(climate, exponent):
    """Miner's sum of cycles at the rate of m_2/m_0, ranges twice Rayleigh's amplitudes."""
    fatigue, m_0, m_2 = Fatigue(exponent=exponent, strain=0.1, cycles=1e5, years=3.0), 2e-4, 5e-4
    each = rayleigh(scale=2 * np.sqrt(m_0)).expect(lambda span: (span / 0.1) ** exponent / 1e5)
    cycles = 3 * YEAR_HOURS * 3600 * np.sqrt(m_2 / m_0) / (2 * np.pi)
    found = damages(fatigue, climate, np.array([m_0]), np.array([m_2]))
    assert found.sum() == pytest.approx(cycles * each, rel=1e-9)


def test_damage_of_a_narrow_band_is_that_of_cycles_counted(climate):
    """A Gaussian strain of a narrow band, its ranges counted from each trough to the next crest."""
    omega, rng = np.linspace(1.0, 1.04, 41), np.random.default_rng(1)
    a = rng.normal(size=(len(omega), 2)) @ [1, 1j] * 1e-2
    time = np.arange(0.0, 2 * np.pi / 0.001, 0.05)  # one period of the record
    strain = np.real(np.exp(-1j * np.outer(time, omega)) @ a)
    peaks = strain[find_peaks(strain)[0]]
    m_0, m_2 = (float((np.abs(a) ** 2 * omega**power).sum() / 2) for power in (0, 2))
    fatigue = Fatigue(exponent=2.0, strain=1.0, cycles=1.0, years=time[-1] / (YEAR_HOURS * 3600))
    counted = float(((2 * peaks) ** 2).sum())
    assert damages(fatigue, climate, np.array([m_0]), np.array([m_2])).sum() == pytest.approx(counted, rel=0.01)


@pytest.mark.parametrize(("design", "changes"), [("VSWEC", SPHERE), ("VSWEC90", SPHEROID)])
def test_strains_are_those_of_a_study(climate, design, changes):
    """Natural modes in place of functions, coefficients solved where the year is integrated, a fine search."""
    study, fatigue = study_of(**changes), Fatigue(exponent=3.0, strain=0.02)
    model = replace(DesignModel.of(study, design, climate, []), fatigue=fatigue)
    found, grid, basis = model.at([]), model.grid, reference_shell(study).basis
    buoy = campaigns_buoy(study, grid, model.nodes)
    q, under = buoy.in_waves()[design].moved
    resisting = 1j * grid.omega * found["damping"].value
    amplitude = q + (resisting * (q @ buoy.port) / (1 - resisting * (under @ buoy.port)))[:, None] * under
    phi, half = np.linspace(1e-4, np.pi - 1e-4, 4001), study.device.thickness / 2
    membrane, bending = strain_shapes(basis, phi)[:2], curvature_shapes(basis, phi)
    strains = [e + side * half * k for e, k in zip(membrane, bending, strict=True) for side in (1, -1)]
    square = np.abs(amplitude[:, : len(membrane[0])] @ np.array(strains)) ** 2
    m_0, m_2 = (np.tensordot(square, grid.variance * grid.omega**power, ((1,), (0,))) for power in (0, 2))
    expected = damages(fatigue, climate, m_0[..., None], m_2[..., None]).sum(axis=-1).max()
    assert found["damage"].value == pytest.approx(expected, rel=1e-5)


def test_damage_follows_the_line_of_the_material_and_the_height_of_the_seas(climate):
    """In seas twice as high a wall of exponent m wears 2^m as fast, and one that bears twice the strain 2^-m."""
    study, fatigue = study_of(**SPHERE), Fatigue(exponent=3.0, strain=0.02)
    high = Climate.of_spectra(climate.omega, 4 * climate.density, climate.hours, "twice as high")

    def damage(seas, **changed):
        line = fatigue.model_copy(update=changed)
        model = replace(DesignModel.of(study, "VSWEC", seas, []), fatigue=line)
        return replace(model, grid=FrequencyGrid.of(seas, 12.0, 8, 3)).at([])["damage"].value

    once = damage(climate)
    assert damage(high) == pytest.approx(8 * once, rel=1e-9)
    assert damage(climate, strain=0.04) == pytest.approx(once / 8, rel=1e-9)
    assert damage(climate, years=60.0, cycles=3e6) == pytest.approx(once, rel=1e-9)
