"""The automatic model: what it leaves out changes the power by no more than stated."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from conftest import varied

from vsb.engine.integrators.harmonic_balance import harmonic_balance, steady_power
from vsb.engine.motion.forces import ElasticForce
from vsb.engine.shell.deformed import DeformedShell
from vsb.models.automatic import (
    RIGID,
    Choice,
    Description,
    LeftOut,
    Scenes,
    chosen,
    linear_power,
    motion_ladder,
    truncated,
)
from vsb.models.rest import reference_shell, rubber_shell, study_basis
from vsb.study.study import parse

DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 0}}
STIFF = {"device": {"young_modulus": 1e9}, "designs": DESIGNS}
"""A shell that hardly moves at rest: its linear and body-exact powers agree for small waves."""


@pytest.fixture(scope="module")
def scenes_of(seed, buoy_of, radiation_of):
    """Function (design, wave, changes of the seed study) -> its scenes."""

    def build(design, wave, **changes):
        study = varied(seed, **{"designs": DESIGNS, "waves": [wave], **changes})
        basis = study_basis(study)
        buoy, water = buoy_of(study), study.water
        attrs = {"gravity": water.gravity, "water_density": water.density, "water_depth": str(water.depth)}
        buoy = replace(buoy, database=buoy.database.assign_attrs(attrs))
        shape = DeformedShell(basis, study.centre_height, np.zeros(len(basis.labels)))
        waves = study.waves[0].realisation(study.hydro.omega_max, study.simulation.duration)
        ladder = motion_ladder(study, basis, design)
        return Scenes(buoy, shape, radiation_of(seed), waves, ladder, study.simulation)

    return build


def swell(amplitude, period):
    return {"kind": "regular", "amplitude": amplitude, "period": period}


@pytest.mark.parametrize(
    ("design", "period", "amplitude"), [("FSB", 2.5, 0.2), ("VSWEC", 4.0, 0.05), ("VSWEC0", 2.5, 1e-3)]
)
@pytest.mark.parametrize("tolerance", [0.03, pytest.param(0.003, marks=pytest.mark.slow)])
def test_error_of_the_chosen_model_is_within_its_statement(scenes_of, design, period, amplitude, tolerance):
    """Against body-exact motion of all modes with the radiation of the coefficients themselves."""
    scenes = scenes_of(design, swell(amplitude, period), **STIFF)
    choice = chosen(scenes, tolerance)
    whole = steady_power(scenes.system(scenes.full), 1e-8, scenes.buoy.spectrum.transfer)
    assert abs(scenes.power(choice.description) / whole - 1) <= choice.error + 1e-7
    assert choice.error <= tolerance


def test_stated_error_contains_that_of_all_parts_together(scenes_of):
    scenes, parts = scenes_of("FSB", swell(1e-3, 4.0)), np.array([0.003, 0.004, 0.002])
    left_out = tuple(LeftOut("a part", error) for error in parts)
    choice = Choice(scenes.full, left_out, scenes.scene(scenes.full))
    assert np.prod(1 + parts) - 1 <= choice.error


def test_body_exact_forces_are_chosen_in_high_waves_only(scenes_of):
    small, high = (chosen(scenes_of("FSB", swell(a, 4.0)), 0.01).description for a in (1e-3, 0.4))
    assert (small.degree, small.body_exact) == (RIGID, False)
    assert (high.degree, high.body_exact) == (RIGID, True)
    assert small.memory < 14


def test_stiffer_shells_need_fewer_modes(scenes_of):
    degrees = [
        chosen(scenes_of("VSWEC", swell(1e-3, 4.0), designs=DESIGNS, device={"young_modulus": e}), 0.01)
        .description.degree
        for e in (1e8, 1e13)
    ]  # fmt: skip
    assert degrees == sorted(degrees, reverse=True)
    assert degrees[0] > RIGID == degrees[-1]


@pytest.mark.parametrize("wave", [{"kind": "jonswap", "hs": 0.02, "tp": 4.0}, {"kind": "still"}])
def test_aperiodic_motion_is_compared_on_a_record(scenes_of, wave):
    scenes = scenes_of("FSB", wave, simulation={"duration": 60.0, "initial_velocity": -0.1})
    choice = chosen(scenes, 0.03)
    assert not choice.description.body_exact
    assert {item.what.split("_")[0] for item in choice.left_out} == {"memory", "body"}
    assert 0 < choice.error <= 0.03


def test_linear_power_matches_harmonic_balance(scenes_of):
    system = scenes_of("VSWEC", swell(0.1, 3.0)).system(Description(6, 14, False))
    assert linear_power(system) == pytest.approx(harmonic_balance(system).power.pto, rel=1e-9)


@pytest.fixture(scope="module")
def memory(seed, radiation_of):
    return radiation_of(seed)


def test_truncated_memory_is_passive_and_converges(memory):
    omega = np.linspace(0.1, 10.0, 100)
    exact = memory.transfer(omega)
    missed = [np.abs(truncated(memory, order).transfer(omega) - exact).max() for order in range(2, memory.order + 1, 4)]
    assert all(late < early for early, late in itertools.pairwise(missed))
    assert truncated(memory, memory.order) is memory
    for order in range(2, memory.order, 2):
        model = truncated(memory, order)  # its construction checks passivity
        assert model.order == order
        assert np.linalg.eigvalsh(model.damping(omega)).min() > -1e-9 * np.abs(exact).max()


@pytest.mark.slow
def test_memory_in_a_high_long_wave_is_judged_body_exact(scenes_of):
    """Linear theory finds two states sufficient: 0.5 % lost there, 1.3 % with body-exact forces."""
    scenes = scenes_of("FSB", swell(0.36, 6.237), pto={"damping": 558.0})
    choice = chosen(scenes, 0.03)
    whole = steady_power(scenes.system(scenes.full), 1e-8, scenes.buoy.spectrum.transfer)
    assert choice.description.body_exact
    assert abs(scenes.power(choice.description) / whole - 1) <= choice.error


def test_the_model_chosen_for_rubber_is_exact_where_its_stretch_counts(seed, buoy_of, radiation_of):
    """Small waves leave an inflated shell linear about its rest; in high ones rubber and water are exact."""
    device = {
        "radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0, "internal_pressure": 2.2e4,
        "material": {"law": "neo_hookean", "mu": 1e6},
    }  # fmt: skip
    study = parse({
        "study": "rubber", "device": device, "designs": {"VSWEC": {}}, "reference_shape": "equilibrium",
        "modes": {"basis": "full", "degree": 2}, "hydro": {"model": "auto", "tolerance": 1e-2, "omega_max": 6.0},
        "pto": {"damping": 8000.0}, "waves": [swell(1e-3, 4.0), swell(0.5, 4.0)],
    })  # fmt: skip
    basis, buoy = study_basis(study), buoy_of(study)
    attrs = {"gravity": 9.81, "water_density": 1025.0, "water_depth": "inf"}
    buoy = replace(buoy, database=buoy.database.assign_attrs(attrs))
    shape, rubber = reference_shell(study, basis).shape, rubber_shell(study, basis)
    ladder, memory = motion_ladder(study, basis, "VSWEC"), radiation_of(study)
    seas = [wave.realisation(study.hydro.omega_max, 60.0) for wave in study.waves]
    small, high = (chosen(Scenes(buoy, shape, memory, one, ladder, study.simulation, rubber), 0.02) for one in seas)
    assert not small.description.body_exact
    assert high.description.body_exact
    assert high.description.degree == RIGID or isinstance(high.scene.forces["elastic"], ElasticForce)
    assert max(small.error, high.error) <= 0.02
