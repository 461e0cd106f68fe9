"""Designs under causal control: derivatives, order of take-offs, an optimum without better neighbours."""

from dataclasses import replace

import numpy as np
import pytest

from tests.design.conftest import study_of
from tests.design.test_evaluation import differences, scales
from vsb.design.evaluation import DesignModel
from vsb.design.linearised import linearised
from vsb.design.optimise import VIOLATION, optimised
from vsb.design.problem import POWER, Problem
from vsb.design.resting import RestingBuoy
from vsb.design.take_offs import ControlGrid, ControlledYear
from vsb.design.year import PortYear, YearMotion
from vsb.engine.motion.causal import RmsLimits
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.study.design import LEAST_STROKE, Variable

OMEGA = np.linspace(0.3, 3.0, 55)


def waves(height, period):
    """A year of one sea, whose density has no ends: signals die away."""
    density = jonswap_spectrum(OMEGA, height, period, 3.3)[None]
    return Climate.of_spectra(OMEGA, density, np.ones(1), f"waves of {period:g} s")


@pytest.fixture(scope="module")
def climate():
    return waves(1.6, 6.0)


FORCE, BOTH, BEYOND, NONE = RmsLimits(8e3), RmsLimits(8e3, 0.6), RmsLimits(8e3, 0.5), RmsLimits()


def model_of(climate, limits, keys, design="VSWEC", finer=0.4, **changes):
    """A model of fewer nodes and frequencies: derivatives are those of the discrete model."""
    study, grid = study_of(**changes), ControlGrid.of_control(climate, 12.0, 10, finer, 4 * finer)
    return DesignModel(study, design, climate, tuple(keys), study.modes.max_degree, 28, grid, control=limits)


@pytest.mark.parametrize(
    ("limits", "key", "control"),
    [
        (FORCE, "device.radius", {}),
        (FORCE, "device.mass", {"noise": 1e-3, "forecast": 1.0}),
        (BOTH, "device.internal_pressure", {}),
        (BEYOND, "device.radius", {}),  # no control keeps the stroke
        (NONE, "device.young_modulus", {}),
        (FORCE, "device.radius", {"noise": 0.1}),  # a damper absorbs more
        (NONE, "device.mass", {"noise": 1.0}),
    ],
)
def test_derivatives_are_those_of_differences(climate, limits, key, control):
    model = model_of(climate, limits, [key], pto={"control": control})
    found, expected = model.at(model.point).quantities, differences(model, scales(model), 1e-4)
    names = ["annual_mean_power", "force_rms", "stroke_rms", *({LEAST_STROKE} & set(found))]
    for name in names:
        error = found[name].gradient[0] * model.point[0] - expected[name]
        assert abs(error) <= 1e-6 * max(found[name].value, abs(expected[name])), name


def test_a_narrow_resonance_has_as_many_frequencies_as_it_needs():
    """Of a small force in long waves: with those that resolve the sea the power is 0.3 % off, and jumps with the buoy."""
    device = {"radius": 1.4, "thickness": 0.1, "young_modulus": 3.2e6, "internal_pressure": 3.2e3, "mass": 10376.0}
    model = DesignModel.of(study_of(device=device), "VSWEC", waves(2.5, 10.0), [], control=RmsLimits(1e4, 0.6))
    powers = [one.at([])[POWER].value for one in (model, replace(model, closer=2))]
    assert powers[0] == pytest.approx(powers[1], rel=2e-4)


FORCES = {"h": "heave", "r": {"colatitude": 120}}
THREE = FORCES | {"s": {"colatitude": 60}}


def years(model):
    """Function values of the variables -> the year under the controller alone, which is not compared with dampers."""

    def at(values):
        study = model.study_at(values)
        buoy = RestingBuoy.of(study, model.degree, model.design)
        matrices = linearised(buoy, model.design, [], model.grid.solved, model.nodes)
        return model.controlled(study, YearMotion(model.grid, *matrices, 0.0)).found

    return at


@pytest.mark.parametrize(
    ("design", "force", "keys", "control"),
    [
        ("VSWEC", 8e3, "device.radius pto.port.ports.r.colatitude", {"forecast": 1.0, "noise": 1e-3}),
        ("FSB", 8e3, "device.mass", {}),  # all ports move alike
        ("VSWEC", np.inf, "device.young_modulus", {}),
    ],
)
def test_derivatives_at_several_ports_are_those_of_differences(climate, design, force, keys, control):
    """Signals outlast the frequencies of these few waves: derivatives are those of the very numbers."""
    pto = {"ports": FORCES, "matrix": "diagonal", "control": control}
    model = model_of(climate, RmsLimits(force), keys.split(), design, pto=pto)
    found, year, x = model.at(model.point).quantities, years(model), np.array(model.point)
    own = year(x)
    names = {"annual_mean_power": "power", "force_rms": "force_rms"}
    steps = {part: year(x * (1 + part)) for part in (-1e-4, -5e-5, 5e-5, 1e-4)}
    for name, part in names.items():
        assert found[name].value == pytest.approx(getattr(own, part), rel=1e-9), name
        near = {one: getattr(end, part) for one, end in steps.items()}
        expected = (8 * (near[5e-5] - near[-5e-5]) - (near[1e-4] - near[-1e-4])) / 6e-4
        error, scale = found[name].gradient @ x - expected, max(found[name].value, abs(expected))
        assert abs(error) <= (1e-5 if name == "force_rms" and force == np.inf else 1e-6) * scale, name


@pytest.mark.parametrize(
    ("key", "ports", "control"),
    [
        ("device.mass", FORCES, {"noise": 0.1}),
        pytest.param("device.internal_pressure", THREE, {"noise": 0.1}, marks=pytest.mark.slow),
    ],
)
def test_a_damper_matrix_that_absorbs_more_has_the_derivatives_of_differences(climate, key, ports, control):
    pto = {"ports": ports, "matrix": "diagonal", "control": control}
    model = model_of(climate, RmsLimits(8e3), [key], pto=pto)
    found, expected = model.at(model.point).quantities, differences(model, scales(model), 1e-4)
    assert found["annual_mean_power"].value > years(model)(model.point).power
    for name in ("annual_mean_power", "force_rms"):
        error = found[name].gradient[0] * model.point[0] - expected[name]
        assert abs(error) <= 1e-6 * max(found[name].value, abs(expected[name])), name


@pytest.mark.slow
def test_three_ports_absorb_more_than_dampers_and_the_more_the_longer_the_forecast():
    """In bands with ends signals are long: without fading them out the controller had 16 % less than the dampers."""
    omega, density = np.array([0.8, 1.2, 1.6]), np.array([[0.4, 0.6, 0.0]])
    climate = Climate.of_spectra(omega, density, np.ones(1), "two bands")
    powers = []
    for forecast in (0.0, 2.0):
        pto = {"ports": THREE, "matrix": "diagonal", "control": {"forecast": forecast}}
        model = model_of(climate, FORCE, [], finer=1.0, pto=pto)
        matrices = linearised(
            RestingBuoy.of(model.study, model.degree, model.design), model.design, [], model.grid.solved, model.nodes
        )
        year = model.controlled(model.study, YearMotion(model.grid, *matrices, 0.0))
        powers += [year.other_levels["damper_same_force"], year.found.power, year.other_levels["future_known"]]
    dampers, causal, _, _, ahead, known = powers
    assert 1.02 * dampers < causal < ahead < known < 1.01 * causal


@pytest.mark.parametrize(("design", "force"), [("FSB", 1e3), ("VSWEC90", 3e4)])
def test_power_grows_with_knowledge_and_the_worth_of_the_limit_is_its_slope(climate, design, force):
    model = model_of(climate, RmsLimits(force), [], design)
    found = model.at([])
    power, study = found["annual_mean_power"].value, model.study
    matrices = linearised(RestingBuoy.of(study, model.degree, design), design, [], model.grid.solved, model.nodes)
    levels = ControlledYear(
        PortYear(YearMotion(model.grid, *matrices, 0.0)), model.control, study.pto.control
    ).other_levels
    assert levels["damper_same_force"] * (1 - 1e-9) <= power < levels["future_known"] < 1.1 * power
    wider, closer = (
        replace(model, control=RmsLimits(force * (1 + s))).at([])["annual_mean_power"].value for s in (1e-3, -1e-3)
    )
    assert (wider - closer) / (2e-3 * power) == pytest.approx(found.worth["force_rms"], rel=1e-4)


def test_no_neighbour_within_the_limits_of_an_optimum_is_better(climate):
    keys, bounds = ["device.radius", "device.young_modulus", "device.mass"], [(1.8, 2.2), (1e7, 4e7), (1.4e4, 2e4)]
    variables = tuple(Variable(key=key, low=low, high=high) for key, (low, high) in zip(keys, bounds, strict=True))
    of = Problem(model_of(climate, FORCE, keys), variables, "annual_mean_power", {"beam": 4.2})
    found = optimised(of, of.at(np.full(3, 0.5)))
    assert found.accepted, found.message
    assert found.multipliers["force_rms"] > 0.5
    for step in np.random.default_rng(5).normal(size=(8, 3)):
        near = of.at(np.clip(found.point.place + 0.02 * step, 0.0, 1.0))
        assert near.objective <= found.objective * (1 + 1e-9) or near.violation > VIOLATION
