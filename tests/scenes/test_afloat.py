"""What studies let float: designs' motions, ports, seas of several directions as one port."""

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from hydro.formats.test_capytaine import LABELS
from motion.test_bodies import database, moored  # noqa: F401
from scipy.linalg import block_diag

from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers, mean_power
from vsb.scenes.afloat import (
    Afloat,
    body_motions,
    body_port,
    headings,
    held_rows,
    linear_buoy,
    met,
    moved,
    rest_shape,
    stored_body,
    study_sea,
    towards,
)
from vsb.scenes.directions import order_bases
from vsb.scenes.rest import reference_shell, study_basis
from vsb.study.body import BodyDesign, BodyStudy
from vsb.study.reading import validated
from vsb.study.waves import RegularWave, StillWater
from vsb.tools import files
from vsb.tools.units import PAIR
from vsb.waves.seas import NO_WAVES, Sea, regular, sea

RIGID = ["Surge", "Heave", "Pitch", "Mode7"]


def test_designs_choose_degrees_of_freedom():
    assert moved(BodyDesign(), RIGID) == tuple(RIGID)
    assert moved(BodyDesign(dofs="rigid"), RIGID) == ("Surge", "Heave", "Pitch")
    assert body_motions("a", BodyDesign(dofs=("Pitch",)), RIGID) == pytest.approx(np.eye(4)[:, [2]])


def test_what_is_held_stays_zero():
    """A float locked to its spar: one motion of both."""
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
def test_designs_of_nothing_are_refused(design, message):
    with pytest.raises(ConfigError, match=message):
        body_motions("a", design, RIGID)


def study(port, **changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [{"kind": "still"}]}
    return validated(BodyStudy, {**made, "pto": {"damping": 1.0, "port": port}, **changes}, "a.yaml")


def test_ports_of_a_body():
    assert body_port(study({"dofs": {"Heave": 1.0, "Pitch": -30.0}}), RIGID) == pytest.approx([0, 1, -30, 0])
    assert body_port(study("heave"), RIGID) == pytest.approx([0, 1, 0, 0])
    with pytest.raises(ConfigError, match=r"pto.port: received Heave; needs some of Surge"):
        body_port(study("heave"), ["Surge"])


@pytest.fixture
def barge(database):  # noqa: F811
    """The barge of the general route, its bending taken off."""
    body = moored(database)
    return Afloat(body, {"a": np.eye(8)}, body.pto.direction(8))


def test_seas_of_several_directions_are_one_port(barge):
    """Each sea takes the power of its own direction's port; a damper for both suits their sum."""
    seas = []
    for period, direction in ((6.0, 0.0), (7.0, 45.0), (6.0, 45.0)):
        wave = RegularWave(kind="regular", amplitude=0.3, period=period, direction=direction)
        seas.append((wave, regular(wave)))
    seen = met(barge, "a", seas)
    alone = []
    for (wave, _), place, row in zip(seas, seen.places, seen.squares, strict=True):
        assert seen.port.omega[place] == pytest.approx([wave.omega])
        assert np.flatnonzero(row) == pytest.approx(place)
        own = towards(barge.linear, wave.direction).port(np.array([wave.omega]), barge.motions["a"], barge.port)
        alone.append(0.3**2 * own.power(2e5)[0])
    found = mean_power(seen.port, seen.squares, np.full(3, 2e5), np.zeros(3))
    assert found == pytest.approx(alone, rel=1e-12)
    best = best_dampers(seen.port, seen.squares.sum(axis=0, keepdims=True))
    assert float(best.power[0]) >= found.sum() * (1 - 1e-9)


@pytest.mark.parametrize("first", [0, 1])
def test_still_water_among_seas_goes_nowhere_and_brings_nothing(barge, first):
    """Whether it is named before or after them."""
    wave = RegularWave(kind="regular", amplitude=0.3, period=6.0, direction=45.0)
    seas = [(wave, regular(wave))]
    seas.insert(first, (StillWater(kind="still"), NO_WAVES))
    assert {going: omega.tolist() for going, omega in headings(seas).items()} == {45.0: [wave.omega]}
    seen, alone = met(barge, "a", seas), met(barge, "a", [(wave, regular(wave))])
    np.testing.assert_array_equal(seen.port.velocity, alone.port.velocity)
    np.testing.assert_allclose(seen.squares, [[0.09], [0.0]] if first else [[0.0], [0.09]])
    assert [place.tolist() for place in seen.places] == ([[0], []] if first else [[], [0]])


def test_a_sea_keeps_what_lies_in_the_band(barge):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 6.0}
    asked = study("heave", waves=[sea])
    found = study_sea(asked, asked.waves[0], barge.linear.database)
    omega = barge.linear.database.omega.values
    assert omega[0] - 1e-9 <= found.omega.min()
    assert found.omega.max() <= omega[-1] + 1e-9


def test_a_stored_body_is_what_was_stored(general_database):
    body = stored_body(general_database)
    assert body.labels == ("Heave", "Membrane0", "Membrane1", "Membrane2")
    assert body.structural_damping.any()


@pytest.fixture
def general_database(finished, tmp_path):
    from conftest import SMALL_PLAN

    from vsb.hydro.formats.sources import read_source
    from vsb.stages.coefficients import store
    from vsb.study.body_plan import plan_for
    from vsb.study.canonical import content_id

    own = study("heave")
    spec = plan_for(own).database
    path = tmp_path / "db" / f"{content_id(spec)}.nc"
    store(spec, read_source("database", str(finished / SMALL_PLAN.database_path), own.water), str(path))
    return str(path)


@pytest.mark.parametrize(("beyond", "kept"), [(5e-10, 1), (2e-9, 0)])
def test_a_wave_at_an_edge_of_the_band_is_in_it_but_for_round_off(seed, barge, beyond, kept):
    """At the highest frequency of a buoy, at both ends of what a body's database holds."""
    wave, omega = seed.waves[0], barge.linear.database.omega.values[[0, -1]]
    cut = seed.model_copy(update={"hydro": seed.hydro.model_copy(update={"omega_max": wave.omega - beyond})})
    assert study_sea(cut, wave, None).omega.size == kept
    for edge in (omega[0] - beyond, omega[1] + beyond):
        asked = study("heave", waves=[{"kind": "regular", "amplitude": 0.1, "period": float(2 * np.pi / edge)}])
        assert study_sea(asked, asked.waves[0], barge.linear.database).omega.size == kept


@pytest.mark.parametrize(("port", "chamber"), [("volume", 4 / 3 * np.pi * 2.0**3 / (1.4 * 101325.0)), ("heave", 0.0)])
def test_gas_of_a_database_is_a_chamber_before_a_take_off_of_the_volume_alone(small, tmp_path, port, chamber):
    """C = V/(kappa p) of the sphere; elsewhere the gas holds the shell."""
    study = varied(small.study, device={"gas": {"adiabatic_index": 1.4}}, pto={"port": port})
    gas, path = reference_shell(study).stiffness["gas"], tmp_path / Path(small.database_path).name
    files.save(files.load(small.database_path).assign(gas_stiffness=(PAIR, gas)), path)
    buoy, _ = linear_buoy(study, str(path))
    assert buoy.chamber == pytest.approx(chamber, rel=1e-6)
    vented, _ = linear_buoy(small.study, small.database_path)
    held = gas if port == "heave" else 0.0 * gas
    assert buoy.stiffness == pytest.approx(vented.stiffness + held, rel=1e-12, abs=1e-6)


def test_of_several_motions_held_none_is_left():
    """Two conditions on three motions leave one, whatever the order they are told in."""
    for held in (({"Surge": 1.0, "Pitch": -2.0}, {"Mode7": 3.0}), ({"Mode7": 3.0}, {"Surge": 1.0, "Pitch": -2.0})):
        motions = body_motions("a", BodyDesign(dofs=("Surge", "Pitch", "Mode7"), held=held), RIGID)
        assert motions.shape == (4, 1)
        np.testing.assert_allclose(motions[:, 0] / motions[2, 0], [2.0, 0.0, 1.0, 0.0], atol=1e-14)


@dataclass(frozen=True)
class Heading:
    """Stands for a body: its velocity per wave height tells frequency and direction."""

    direction: float = 0.0

    def port(self, omega, motions, direction):
        return Port(omega, 1 / omega + 0j, omega * (2.0 + self.direction) * (direction @ motions)[0], 0.25)


def test_seas_of_components_in_any_phase_are_one_port_direction_by_direction():
    """Two seas of one direction share their frequencies; still water is in between; squares are those of amplitudes."""
    named = [
        (30.0, [1.0, 2.0], [0.3, 0.4j]),
        (None, [], []),
        (-90.0, [0.5, 2.0, 3.0], [-0.2, 0.1 + 0.1j, 0.5]),
        (30.0, [2.0, 4.0], [-0.6j, 0.7]),
    ]
    waves = {None: StillWater(kind="still")} | {
        at: RegularWave(kind="regular", amplitude=1.0, period=1.0, direction=at) for at in (30.0, -90.0)
    }
    seas = [(waves[at], Sea(np.array(omega), np.array(a, dtype=complex))) for at, omega, a in named]
    seen = met(Afloat(Heading(), {"a": 3.0 * np.ones((1, 1))}, np.ones(1)), "a", seas)
    omega = np.array([1.0, 2.0, 4.0, 0.5, 2.0, 3.0])
    np.testing.assert_array_equal(seen.port.omega, omega)
    np.testing.assert_array_equal(seen.port.admittance, 1 / omega)
    np.testing.assert_allclose(seen.port.velocity, 3.0 * omega * (2.0 + np.deg2rad([30.0] * 3 + [-90.0] * 3)))
    assert seen.port.compliance == 0.25
    assert [place.tolist() for place in seen.places] == [[0, 1], [], [3, 4, 5], [1, 2]]
    expected = [[0.09, 0.16, 0, 0, 0, 0], [0] * 6, [0, 0, 0, 0.04, 0.02, 0.25], [0, 0.36, 0.49, 0, 0, 0]]
    np.testing.assert_allclose(seen.squares, expected, rtol=1e-14)


def test_a_buoy_rests_in_the_axisymmetric_amplitudes_of_its_database(seed):
    basis = study_basis(seed)
    q = 0.01 * np.arange(1.0, len(basis.labels) + 3)
    shape = rest_shape(
        seed, SimpleNamespace(database=xr.Dataset({"reference_amplitude": ("influenced_dof", q)})), basis
    )
    np.testing.assert_array_equal(shape.modal_amplitude, q[:-2])
    assert shape.centre_height == seed.centre_height


def test_a_buoy_is_damped_in_all_orders_of_its_database_by_its_own_material(seed, monkeypatch):
    """By the factors of mass and stiffness; rigid motions are not."""
    study = varied(
        seed,
        motion="free",
        modes={"degree": 3, "order": 2},
        device={"centre_of_mass": -0.5, "ballast_inertia": 9e3, "ballast_yaw_inertia": 7e3}
        | {"damping": {"alpha": 0.4, "beta": 3e-3}},
    )
    basis = study_basis(study)
    parts = [basis, *order_bases(study, basis)]
    labels = [label for part in parts for label in part.labels]
    rigid = [label in ("Heave", "Surge", "Pitch", "Sway", "Roll", "Yaw") for label in labels]
    expected = block_diag(*(0.4 * part.inertia + 3e-3 * part.stiffness for part in parts))
    expected[rigid, :] = expected[:, rigid] = 0.0
    held = xr.Dataset(coords={"influenced_dof": labels})
    monkeypatch.setattr("vsb.scenes.afloat.database.load_database", lambda path, name: held)
    buoy, found = linear_buoy(study, "some.nc")
    assert found.labels == basis.labels
    np.testing.assert_allclose(buoy.structural_damping, expected, rtol=1e-12, atol=1e-9)
    assert np.diag(expected)[np.logical_not(rigid)].all()
    assert (buoy.pto.damping, buoy.chamber) == (0.0, 0.0)


def test_a_buoy_whose_database_holds_heave_alone_is_a_rigid_one(seed, monkeypatch):
    held = xr.Dataset(coords={"influenced_dof": ["Heave"]})
    monkeypatch.setattr("vsb.scenes.afloat.database.load_database", lambda path, name: held)
    buoy, basis = linear_buoy(varied(seed, designs={"FSB": {"flexible": False}}), "some.nc")
    assert basis.labels == ("Heave",)
    assert buoy.structural_damping.tolist() == [[0.0]]


@pytest.mark.parametrize(("design", "labels", "told"), [
    (BodyDesign(dofs="rigid"), ["Mode7", "Mode8"], "none"),
    (BodyDesign(dofs=("Heave", "Pitch"), held=({"Heave": 1.0}, {"Pitch": 2.0})), RIGID, "Heave, Pitch"),
])  # fmt: skip
def test_a_design_that_leaves_nothing_to_move_is_told_by_what_it_chose(design, labels, told):
    with pytest.raises(ConfigError, match=rf"^designs\.some: received dofs {told}, all held; needs one that moves$"):
        body_motions("some", design, labels)


def test_what_is_held_twice_over_or_not_among_the_chosen_takes_no_more_motion():
    """Three conditions of which two say the same and one is on what does not move: one is left to hold."""
    held = ({"Surge": 1.0, "Pitch": 2.0}, {"Surge": -2.0, "Pitch": -4.0}, {"Mode7": 5.0})
    motions = body_motions("a", BodyDesign(dofs=("Pitch", "Heave", "Surge"), held=held), RIGID)
    assert motions.shape == (4, 2)
    np.testing.assert_allclose(motions.T @ motions, np.eye(2), atol=1e-14)
    np.testing.assert_allclose(held_rows(BodyDesign(held=held), RIGID) @ motions, 0.0, atol=1e-14)
    free = body_motions("a", BodyDesign(dofs=("Pitch", "Surge"), held=({"Heave": 1.0},)), RIGID)
    np.testing.assert_array_equal(free, np.eye(4)[:, [2, 0]])


@pytest.mark.parametrize("direction", [-135.0, 0.0, 60.0])
def test_a_motion_goes_with_the_waves_in_radians(direction):
    assert towards(Heading(7.0), direction).direction == pytest.approx(np.pi * direction / 180)
    wave = RegularWave(kind="regular", amplitude=1.0, period=1.0, direction=direction)
    floating = Afloat(Heading(7.0), {}, np.ones(1))
    assert floating.towards(wave).direction == pytest.approx(np.pi * direction / 180)
    assert floating.towards(StillWater(kind="still")).direction == 0.0


@pytest.mark.parametrize("port", ["heave", "volume"])
@pytest.mark.parametrize("gas", [None, {"adiabatic_index": 1.4}])
def test_a_chamber_is_opened_of_gas_before_a_take_off_of_the_volume_alone(seed, monkeypatch, port, gas):
    """By the port of the study about the buoy's own shape; else the buoy is as its database has it."""
    held = xr.Dataset(coords={"influenced_dof": ["Heave", "Membrane0", "Membrane1"]})
    monkeypatch.setattr("vsb.scenes.afloat.database.load_database", lambda path, name: held)
    monkeypatch.setattr("vsb.scenes.afloat.study_port", lambda study, buoy, basis: (study, buoy, basis))
    monkeypatch.setattr("vsb.scenes.afloat.with_open_chamber", lambda buoy, direction: ("opened", buoy, direction))
    study = varied(seed, modes={"degree": 1}, device={"gas": gas}, pto={"port": port})
    found, basis = linear_buoy(study, "some.nc")
    if gas and port == "volume":
        word, buoy, direction = found
        assert (word, direction) == ("opened", (study, buoy, basis))
    else:
        buoy = found
    assert buoy.database is held
    assert basis.labels == ("Heave", "Membrane0", "Membrane1")


@pytest.mark.parametrize(("low", "high"), [(0.5, 2.0), (0.2, 0.9), (1.1, 3.0), (0.1, 4.0)])
def test_the_sea_of_a_body_is_cut_to_the_band_of_its_database_at_both_ends(low, high):
    """Components within keep frequency and amplitude; one at an edge is in it but for round-off."""
    ds = xr.Dataset(coords={"omega": [low, 0.5 * (low + high), high]})
    asked = study("heave", waves=[{"kind": "white_noise", "hs": 0.5, "band": [0.3, 3.5], "seed": 4}])
    whole = sea(asked.waves[0], high, asked.simulation.duration)
    found = study_sea(asked, asked.waves[0], ds)
    kept = (whole.omega >= low) & (whole.omega <= high)
    assert kept.any()
    assert kept.all() == (low < 0.3 and high > 3.5)
    np.testing.assert_array_equal(found.omega, whole.omega[kept])
    np.testing.assert_array_equal(found.amplitude, whole.amplitude[kept])
    for edge, way in ((low, -1), (high, 1)):
        for beyond, count in ((5e-10, 1), (2e-9, 0)):
            period = 2 * np.pi / (edge + way * beyond)
            one = study("heave", waves=[{"kind": "regular", "amplitude": 0.1, "period": period}])
            assert study_sea(one, one.waves[0], ds).omega.size == count


def test_a_stored_body_has_the_damping_of_its_file_and_no_take_off(monkeypatch):
    damping, asked = np.array([[3.0, 1.0], [1.0, 2.0]]), []
    pair = ("influenced_dof", "radiating_dof")
    held = xr.Dataset({"structural_damping_matrix": (pair, damping)}, {name: ["Heave", "Mode7"] for name in pair})
    monkeypatch.setattr(
        "vsb.scenes.afloat.database.load_database", lambda path, name: asked.append((path, name)) or held
    )
    monkeypatch.setattr("vsb.scenes.afloat.LinearBody", lambda *given: given)
    ds, loss, pto = stored_body("some/ab12.nc")
    assert asked == [("some/ab12.nc", "ab12")]
    assert ds is held
    np.testing.assert_array_equal(loss, damping)
    assert (pto.damping, pto.stiffness) == (0.0, 0.0)
