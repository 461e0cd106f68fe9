"""Floating systems of studies: motions of designs, ports, seas of several directions as one port."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import varied
from hydro.formats.test_capytaine import LABELS
from motion.test_linear import floating_body as made_body

from vsb.engine.hydro.variables import PAIR
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.tuning import best_dampers, mean_power
from vsb.engine.waves.kinds import RegularWave, StillWater
from vsb.engine.waves.seas import NO_WAVES
from vsb.errors import ConfigError
from vsb.keys.reading import validated
from vsb.models.floating_system import (
    FloatingSystem,
    body_motions,
    floating_body,
    floating_system,
    headings,
    held_rows,
    moved,
    port_in_seas,
    stored_body,
    study_sea,
)
from vsb.models.rest import reference_shell
from vsb.study.body import BodyDesign, BodyStudy
from vsb.tools import files

RIGID = ["Surge", "Heave", "Pitch", "Mode7"]


def test_designs_choose_degrees_of_freedom():
    assert moved(BodyDesign(), RIGID) == tuple(RIGID)
    assert moved(BodyDesign(dofs="rigid"), RIGID) == ("Surge", "Heave", "Pitch")
    assert body_motions("a", BodyDesign(dofs=("Pitch",)), RIGID) == pytest.approx(np.eye(4)[:, [2]])


def test_held_motions_stay_zero():
    """A float locked to its spar has one common motion."""
    locked = BodyDesign(held=({"float__Heave": 1.0, "spar__Heave": -1.0},) * 2)
    motions = body_motions("locked", locked, LABELS)
    assert held_rows(locked, LABELS).shape == (2, 2)
    assert motions.shape == (2, 1)
    assert np.abs(motions[:, 0]) == pytest.approx(np.full(2, np.sqrt(0.5)))
    assert held_rows(locked, LABELS) @ motions == pytest.approx(np.zeros((2, 1)))


@pytest.mark.parametrize(
    ("design", "message"),
    [
        (BodyDesign(dofs=("Roof",)), "designs.a.dofs: received Roof; needs some of Surge, Heave, Pitch, Mode7"),
        (BodyDesign(held=({"Roof": 1.0},)), "designs.a.held: received Roof; needs some of"),
        (
            BodyDesign(held=({"Heave": 1.0}, {"Pitch": 1.0, "Roof": 2.0, "Keel": 1.0})),
            "designs.a.held: received Roof, Keel; needs some of Surge, Heave, Pitch, Mode7",
        ),
        (
            BodyDesign(dofs=("Heave",), held=({"Heave": 1.0},)),
            "designs.a: received dofs Heave, all held; needs one that moves",
        ),
    ],
)
def test_invalid_designs_are_refused(design, message):
    with pytest.raises(ConfigError, match=message):
        body_motions("a", design, RIGID)


def study(port, **changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [{"kind": "still"}]}
    return validated(BodyStudy, {**made, "pto": {"damping": 1.0, "port": port}, **changes}, "a.yaml")


def test_ports_of_a_body():
    body = made_body(("Surge", "Heave", "Pitch"), [1.0, 2.0, 3.0], [1.0, 2.0, 3.0])
    assert floating_body(study({"dofs": {"Heave": 1.0, "Pitch": -30.0}}), body).port == pytest.approx([0, 1, -30])
    assert floating_body(study("heave"), body).port == pytest.approx([0, 1, 0])
    with pytest.raises(ConfigError, match=r"pto.port: received Heave; needs some of Surge"):
        floating_body(study("heave"), made_body(("Surge",), [1.0], [1.0]))


@pytest.fixture(scope="module")
def floating():
    """A damped body in waves along x and at 45 degrees, its take-off on heave and pitch together."""
    port = LinearPto(3.0, 0.0, np.array([1.0, -0.6]))
    bare = made_body(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0], directions=np.deg2rad([0.0, 45.0]))
    body = replace(bare, structural_damping=np.diag([1.0, 0.5]), pto=port)
    return FloatingSystem(body, {"a": np.eye(2)}, port.port)


def test_seas_of_several_directions_form_one_port(floating):
    """Each sea gives the power of the port in its own direction; a damper for all suits their sum."""
    seas = []
    for period, direction in ((6.0, 0.0), (7.0, 45.0), (6.0, 45.0)):
        wave = RegularWave(kind="regular", amplitude=0.3, period=period, direction=direction)
        seas.append((wave, wave.realisation()))
    seen = port_in_seas(floating, "a", seas)
    alone = []
    for (wave, _), place, row in zip(seas, seen.places, seen.squares, strict=True):
        assert seen.port.omega[place] == pytest.approx([wave.omega])
        assert np.flatnonzero(row) == pytest.approx(place)
        own = floating.ports(np.array([wave.omega]), wave.direction)["a"]
        alone.append(0.3**2 * own.power(3.0)[0])
    found = mean_power(seen.port, seen.squares, np.full(3, 3.0), np.zeros(3))
    assert found == pytest.approx(alone, rel=1e-12)
    best = best_dampers(seen.port, seen.squares.sum(axis=0, keepdims=True))
    assert float(best.power[0]) >= found.sum() * (1 - 1e-9)


@pytest.mark.parametrize("first", [0, 1])
def test_still_water_among_seas_contributes_nothing(floating, first):
    wave = RegularWave(kind="regular", amplitude=0.3, period=6.0, direction=45.0)
    seas = [(wave, wave.realisation())]
    seas.insert(first, (StillWater(kind="still"), NO_WAVES))
    assert {going: omega.tolist() for going, omega in headings(seas).items()} == {45.0: [wave.omega]}
    seen, alone = port_in_seas(floating, "a", seas), port_in_seas(floating, "a", [(wave, wave.realisation())])
    np.testing.assert_array_equal(seen.port.velocity, alone.port.velocity)
    np.testing.assert_allclose(seen.squares, [[0.09], [0.0]] if first else [[0.0], [0.09]])
    assert [place.tolist() for place in seen.places] == ([[0], []] if first else [[], [0]])


def test_sea_is_cut_to_the_band_of_the_database(floating):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 6.0}
    asked = study("heave", waves=[sea])
    found = study_sea(asked, asked.waves[0], floating.linear.database)
    omega = floating.linear.database.omega.values
    assert omega[0] - 1e-9 <= found.omega.min()
    assert found.omega.max() <= omega[-1] + 1e-9


def test_stored_body_is_read_back(general_database):
    body = stored_body(general_database)
    assert body.labels == ("Heave", "Membrane0", "Membrane1", "Membrane2")
    assert body.structural_damping.any()


@pytest.fixture
def general_database(finished, tmp_path):
    from conftest import SMALL_PLAN

    from vsb.engine.hydro.formats.exchange import read_source
    from vsb.pipeline.graph import plan_for
    from vsb.stages.coefficients import store

    own = study("heave")
    task = plan_for(own).database
    path = tmp_path / "db" / f"{task.id}.nc"
    found = read_source("database", str(finished / SMALL_PLAN.database.out), own.water)
    store(task.spec["source"], found, str(path), {"spec_id": task.id})
    return str(path)


@pytest.mark.parametrize(("port", "chamber"), [("volume", 4 / 3 * np.pi * 2.0**3 / (1.4 * 101325.0)), ("heave", 0.0)])
def test_gas_is_a_chamber_for_a_take_off_of_the_volume(small, tmp_path, port, chamber):
    """C = V/(kappa p) of the sphere; elsewhere the gas stiffens the shell."""
    study = varied(small.study, device={"gas": {"adiabatic_index": 1.4}}, pto={"port": port})
    gas, path = reference_shell(study).stiffness["gas"], tmp_path / Path(small.database.out).name
    files.save(files.load(small.database.out).assign(gas_stiffness=(PAIR, gas)), path)
    buoy = floating_system(study, str(path)).linear
    assert buoy.chamber == pytest.approx(chamber, rel=1e-6)
    vented = floating_system(small.study, small.database.out).linear
    held = gas if port == "heave" else 0.0 * gas
    assert buoy.stiffness == pytest.approx(vented.stiffness + held, rel=1e-12, abs=1e-6)


def test_redundant_constraints_remove_no_further_motion():
    """Three conditions, two of them equivalent and one on a motion that is not chosen."""
    held = ({"Surge": 1.0, "Pitch": 2.0}, {"Surge": -2.0, "Pitch": -4.0}, {"Mode7": 5.0})
    motions = body_motions("a", BodyDesign(dofs=("Pitch", "Heave", "Surge"), held=held), RIGID)
    assert motions.shape == (4, 2)
    np.testing.assert_allclose(motions.T @ motions, np.eye(2), atol=1e-14)
    np.testing.assert_allclose(held_rows(BodyDesign(held=held), RIGID) @ motions, 0.0, atol=1e-14)
    free = body_motions("a", BodyDesign(dofs=("Pitch", "Surge"), held=({"Heave": 1.0},)), RIGID)
    np.testing.assert_array_equal(free, np.eye(4)[:, [2, 0]])
