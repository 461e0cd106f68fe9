import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import labelled
from scipy.linalg import eigh

from examples.barge import Barge, box
from vsb.errors import ConfigError, DatabaseError, StabilityError
from vsb.hydro.bodies.body import FlexibleBody, at_centres
from vsb.hydro.bodies.study import solve
from vsb.hydro.database import open_database
from vsb.hydro.formats.modes import DRY
from vsb.hydro.passive import sizes
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.simulate import simulate
from vsb.motion import bodies
from vsb.motion.bodies import (
    LinearBody,
    Memory,
    body_scene,
    direction_index,
    linear_body,
    together,
    with_added_mass_inf,
)
from vsb.motion.port import combination
from vsb.motion.pto import LinearPto
from vsb.motion.system import System
from vsb.scenes.afloat import body_motions
from vsb.study.body import BodyDesign
from vsb.study.body_file import BodyFile
from vsb.study.quantities import RIGID
from vsb.study.study import Simulation
from vsb.waves.seas import NO_WAVES, Sea

BARGE = Barge(length=20.0, beam=8.0, draught=3.0, centre_of_mass=-1.5, bending_stiffness=2e8, modes=2)
DENSITY = 1025.0
OMEGA = tuple(round(0.2 + 0.1 * i, 1) for i in range(17))
OBLIQUE = np.pi / 4


def six(vertices):
    """Unit rigid motions, turning about the centre of mass."""
    arm = vertices - [0.0, 0.0, BARGE.centre_of_mass]
    return [*(np.tile(e, (len(vertices), 1)) for e in np.eye(3)), *(np.cross(e, arm) for e in np.eye(3))]


@pytest.fixture(scope="module")
def database(tmp_path_factory, green_folder):
    """A barge on 144 panels: six rigid motions and two bending modes in waves from two sides."""
    vertices, faces = box(BARGE.length, BARGE.beam, BARGE.draught, 2)
    shapes = np.array([*six(vertices), *BARGE.displacement(vertices)[2:]])
    m = DENSITY * BARGE.length * BARGE.beam * BARGE.draught
    turning = m / 12 * np.array([8.0**2 + 3.0**2, 20.0**2 + 3.0**2, 20.0**2 + 8.0**2])
    mass, stiffness = np.diag([m, m, m, *turning, m / 4, m / 4]), np.zeros((8, 8))
    stiffness[6:, 6:] = BARGE.stiffness[2:, 2:]
    centre = np.array([0.0, 0.0, BARGE.centre_of_mass])
    panels = at_centres(vertices, faces, shapes)
    body = FlexibleBody(vertices, faces, (*RIGID, *BARGE.labels[2:]), panels, shapes, mass, stiffness, centre)
    made = {"body": "barge", "mesh": "-", "modes": "-", "omega": OMEGA, "wave_direction": (0.0, 45.0), "lid": 0}
    folder = tmp_path_factory.mktemp("barge")
    solve(BodyFile(**made), body, folder, green_folder)
    return open_database(folder / "barge.nc")


def moored(database, **changes):
    """The barge on soft springs, its take-off on the bending between bow and middle."""
    labels = [str(label) for label in database.influenced_dof.values]
    springs = np.diag([2e4, 2e4, 0.0, 0.0, 0.0, 5e6, 0.0, 0.0])
    stiffness = database.structural_stiffness.values + springs
    pto = LinearPto(3e5, 1e4, combination(labels, {"Heave": 1.0, "Bending1": -0.6}))
    return linear_body(
        database, **{"stiffness": stiffness, "damping": 1e-3 * stiffness + 5.0 * springs, "pto": pto} | changes
    )


@pytest.fixture(scope="module")
def fit(database):
    return moored(database).memory(1e-3, limit="fitted")


def test_memory_of_a_solved_body_is_near_its_samples(database, fit):
    assert fit.error < 5e-3
    assert 0 < fit.shifted < 0.05
    samples = moored(database).samples
    shift = 1j * samples.omega[:, None, None] * (fit.added_mass_inf - samples.added_mass_inf)
    found = (fit.model.transfer(samples.omega) + shift) / np.outer(samples.size, samples.size)
    assert np.abs(found - samples.transfer).max() < 0.01


WAVES = {0.0: Sea(np.array([0.9, 1.4]), np.array([0.3, 0.1 + 0.1j])), OBLIQUE: Sea(np.array([1.1]), np.array([0.2j]))}


def run(scene, sea, duration=300.0, **settings):
    """Motion of a scene and its labelled record."""
    system = System.of(scene)
    motion, stride, _ = simulate(system, sea, Simulation(duration=duration, window=(0.0, duration), **settings), None)
    return motion, labelled(system, motion, sea, "barge", "waves", stride)


def test_time_domain_agrees_with_the_frequency_domain_in_waves_from_several_sides(database, fit):
    body = moored(database)
    motion, record = run(body_scene(body, fit, WAVES), together(WAVES))
    late = motion.time > 250.0
    expected = np.zeros((late.sum(), len(body.labels)))
    for direction, sea in WAVES.items():
        phasors = sea.amplitude[:, None] * replace(body, direction=direction).rao(sea.omega, np.eye(len(body.labels)))
        expected += np.real(np.exp(-1j * np.outer(motion.time[late], sea.omega)) @ phasors)
    missed = np.abs(motion.position[late] - expected).max(axis=0) / np.abs(expected).max(axis=0)
    assert missed.max() < 5e-3
    assert record.attrs["energy_residual"] < 1e-9
    lost = record.energy.isel(time=-1)
    assert float(lost.sel(term="pto")) > 0 < float(lost.sel(term="radiated"))


def test_free_decay_is_of_heave_and_loses_no_energy_unseen(database, fit):
    body = moored(database)
    motion, record = run(body_scene(body, fit, {}), NO_WAVES, 60.0, initial_position=0.5)
    assert motion.position[0] == pytest.approx(0.5 * np.eye(8)[2])
    assert np.abs(motion.position[:, 2]).max() == pytest.approx(0.5, rel=1e-6)
    assert record.attrs["energy_residual"] < 1e-9
    assert float(record.energy.isel(time=-1).sum()) == pytest.approx(0.0, abs=1e-6 * float(record.energy.max()))


def test_state_space_and_convolution_follow_the_same_decay(database):
    """Added mass by Kramers and Kronig, as the convolution has it."""
    spectrum = linear_body(database).spectrum
    added = database.added_mass_inf.values + spectrum.added_mass_difference(spectrum.omega)
    causal = database.assign(added_mass=(database.added_mass.dims, added))
    body = linear_body(causal, ["Heave", "Pitch"])
    scene = body_scene(body, body.memory(1e-3), {})
    system = System.of(scene)
    settings = Simulation(duration=20.0, window=(0.0, 20.0), initial_position=0.5)
    exact, _, _ = simulate(system, NO_WAVES, settings, None)
    convolved, _, _ = simulate(system, NO_WAVES, settings.model_copy(update={"method": "convolution"}), body.spectrum)
    at = np.interp(exact.time, convolved.time, convolved.position[:, 0])
    assert np.abs(at - exact.position[:, 0]).max() < 0.01 * 0.5


def test_a_stiff_barge_moves_as_the_rigid_one(database):
    """Free-free modes of a beam a thousand times as stiff: its rigid motions are those without the modes."""
    omega = np.linspace(0.3, 1.8, 16)
    rigid = linear_body(database, ["Surge", "Heave", "Pitch"])
    expected = rigid.rao(omega, np.eye(3))
    missed = []
    for factor in (1e3, 1e4):
        stiffness = factor * database.structural_stiffness.values
        whole = linear_body(database, stiffness=stiffness).rao(omega, np.eye(8))[:, [0, 2, 4]]
        missed.append(np.abs(whole - expected).max() / np.abs(expected).max())
    assert missed[1] < 1e-3
    assert missed[0] / missed[1] == pytest.approx(10.0, rel=0.05)


def test_a_barge_much_heavier_than_water_rings_as_a_free_free_beam(database):
    """Mass and stiffness grow alike, the water's share goes with one over them: (k_n/L)^2 sqrt(EI/m) of beam theory."""
    of_length = DENSITY * BARGE.beam * BARGE.draught
    beam = (np.array([4.730040744863, 7.853204624096]) / BARGE.length) ** 2 * np.sqrt(
        BARGE.bending_stiffness / of_length
    )
    missed = []
    for factor in (1e3, 1e4):
        mass, stiffness = factor * database.inertia_matrix.values, factor * database.structural_stiffness.values
        frequencies, _ = linear_body(database, mass=mass, stiffness=stiffness).natural_modes(np.eye(8))
        missed.append(np.abs(frequencies[-2:] / beam - 1).max())
    assert missed[1] < 1e-4
    assert missed[0] / missed[1] == pytest.approx(10.0, rel=0.05)


def test_held_motions_are_those_left_out(database):
    omega = np.array([0.7, 1.3])
    motions = np.eye(8)[:, [2, 4, 6]]
    some = linear_body(database, ["Heave", "Pitch", "Bending1"])
    whole = linear_body(database)
    assert whole.rao(omega, motions)[:, [2, 4, 6]] == pytest.approx(some.rao(omega, np.eye(3)), rel=1e-12)


def test_the_port_takes_what_the_damper_absorbs(database):
    omega, free = np.linspace(0.4, 1.8, 8), np.eye(8)
    body = replace(moored(database), direction=OBLIQUE)
    port = body.port(omega, free, body.pto.direction(8))
    absorbed = body.absorbed_power(omega, body.rao(omega, free))
    assert port.power(body.pto.damping, body.pto.stiffness) == pytest.approx(absorbed, rel=1e-9)
    assert (absorbed <= port.matched_power * (1 + 1e-9)).all()


def test_a_port_that_drifts_gives_way_without_end(database):
    labels = [str(label) for label in database.influenced_dof.values]
    adrift = linear_body(database, pto=LinearPto(1e4, 0.0, combination(labels, {"Surge": 1.0})))
    port = adrift.port(np.array([0.8]), np.eye(8), adrift.pto.direction(8))
    assert np.isinf(port.compliance)
    held = port.beside(5e3)
    assert held.compliance == pytest.approx(1 / 5e3)
    assert port.beside(0.0).compliance == np.inf
    assert held.power(1e4) == pytest.approx(port.power(1e4, 5e3))


def test_motions_nothing_holds_have_no_frequency_and_are_carried_along(database):
    """As with springs so soft that the three that drift take hours."""
    free, loose = np.eye(8), np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 30.0, 0.0, 0.0])
    body = linear_body(database)
    frequencies, ratios = body.natural_modes(free)
    held, damped = linear_body(database, stiffness=body.dry_stiffness + loose).natural_modes(free)
    assert len(frequencies) == 5
    assert held[3:] == pytest.approx(frequencies, rel=1e-5)
    assert damped[3:] == pytest.approx(ratios, rel=1e-4)
    alone = linear_body(database, ["Heave", "Roll", "Pitch", "Bending1", "Bending2"]).natural_modes(np.eye(5))[0]
    assert np.abs(alone / frequencies - 1).max() > 1e-3  # surge goes with pitch, sway with roll


def with_one_channel(buoy):
    """The buoy with the damping of its database that of one channel alone."""
    damping = buoy.database.radiation_damping.copy(data=buoy.coefficients(buoy.database.omega.values).damping)
    return replace(buoy, database=buoy.database.assign(radiation_damping=damping))


def test_the_buoy_by_the_general_route(buoy_of, radiation_of, coarse):
    """The database of the axisymmetric chain, its one channel not made use of; what is beside it is not in it."""
    buoy = with_one_channel(buoy_of(coarse))
    omega, free = buoy.spectrum.omega[4:-4:7], np.eye(len(buoy.mass))
    dry = buoy.stiffness - buoy.stiffness_parts["hydrostatic"]
    pto = replace(buoy.pto, port=free[0])
    body = linear_body(buoy.database, mass=buoy.mass, damping=buoy.structural_damping, stiffness=dry, pto=pto)
    assert body.rao(omega, free) == pytest.approx(buoy.rao(omega, free), rel=1e-9)
    some = linear_body(
        buoy.database, ["Heave", "Membrane0"], mass=buoy.mass[:2, :2], damping=free[:2, :2], stiffness=dry[:2, :2]
    )
    k, other = (m.transfer(omega)[:, :2, :2] for m in (some.memory(5e-3).model, radiation_of(coarse)))
    size = np.sqrt(np.einsum("wii->wi", some.spectrum.damping).max(axis=0))
    even = 0.5 * (k - other + (k - other).swapaxes(1, 2)) / np.outer(size, size)
    assert np.sqrt(np.mean(np.abs(even) ** 2, axis=0)).max() < 1e-2


def test_added_mass_at_infinity_follows_from_damping_where_it_is_missing(database):
    found = with_added_mass_inf(database.drop_vars("added_mass_inf"))
    heave = {"influenced_dof": "Heave", "radiating_dof": "Heave"}
    known = float(database.added_mass_inf.sel(heave))
    assert float(found.added_mass_inf.sel(heave)) == pytest.approx(known, rel=0.1)
    assert found.attrs["history"].endswith("added mass at infinite frequency from damping")
    assert with_added_mass_inf(database) is database


def test_a_limit_of_long_waves_in_the_database_is_no_frequency(database):
    """Its row at zero frequency, without damping, changes neither the added mass at infinity nor the band."""
    bare = database.drop_vars("added_mass_inf")
    still = bare.isel(omega=[0]).assign_coords(omega=[0.0])
    still = still.assign({name: 0 * still[name] for name in still.data_vars if "omega" in still[name].dims})
    one, other = linear_body(bare), linear_body(xr.concat([still, bare], "omega", data_vars="minimal"))
    assert other.added_mass_inf == pytest.approx(one.added_mass_inf, rel=1e-13)
    assert float(other.database.omega[0]) == float(database.omega[0])


@pytest.mark.parametrize("given", [(), ("mass",), ("damping", "stiffness"), ("mass", "damping", "stiffness")])
def test_what_is_not_given_of_the_dry_body_is_the_databases(database, given):
    """Matrix by matrix, in the degrees of freedom wanted."""
    ds = database.assign(structural_damping_matrix=database.inertia_matrix * 0.02)
    at, chosen = [2, 4], np.array([[7e5, 1e4], [1e4, 9e6]])
    stored = {"mass": ds.inertia_matrix, "damping": ds.structural_damping_matrix, "stiffness": ds.structural_stiffness}
    body = linear_body(ds, ["Heave", "Pitch"], **dict.fromkeys(given, chosen))
    found = {"mass": body.database.inertia_matrix, "stiffness": body.database.structural_stiffness}
    found["damping"] = body.structural_damping
    for name, held in stored.items():
        wanted = chosen if name in given else held.values[np.ix_(at, at)]
        np.testing.assert_array_equal(np.asarray(found[name]), wanted)


@pytest.mark.parametrize("given", [("mass",), ("mass", "stiffness"), ("mass", "damping", "stiffness")])
def test_without_structure_what_is_not_given_is_nothing(database, given):
    """A database of the water alone: no damping, no stiffness beside the mass."""
    bare = database.drop_vars([name for name in DRY if name in database])
    chosen = np.array([[7e5, 1e4], [1e4, 9e6]])
    body = linear_body(bare, ["Heave", "Pitch"], **dict.fromkeys(given, chosen))
    stiffness = body.database.structural_stiffness.values
    np.testing.assert_array_equal(stiffness, chosen if "stiffness" in given else 0 * chosen)
    np.testing.assert_array_equal(body.structural_damping, chosen if "damping" in given else 0 * chosen)


def test_the_motion_that_falls_is_named_by_its_energy_not_by_its_number(database):
    """Falling aside by 1 m and over by 0.5 rad: turning, metres from its own centre, holds most of the energy."""
    body = linear_body(database, ["Surge", "Pitch"])
    inertia = body.mass + body.added_mass_inf
    fall = inertia @ np.array([1.0, 0.5])
    assert inertia[1, 1] * 0.5**2 > 2 * inertia[0, 0]
    with pytest.raises(StabilityError, match=r"received a negative stiffness of Pitch, growing by"):
        body.drifting(-np.outer(fall, fall) / (fall @ np.array([1.0, 0.5])), np.eye(2))


class TestRefused:
    def test_bodies_that_cannot_be(self, database):
        with pytest.raises(ConfigError, match=r"received Heave, Roof; needs some of Surge, Sway"):
            linear_body(database, ["Heave", "Roof"])
        for name in ("mass", "damping", "stiffness"):
            needs = rf"^{name}: received shape \(2, 2\), needs finite numbers, shape \(1, 1\)\.$"
            with pytest.raises(ConfigError, match=needs):
                linear_body(database, ["Heave"], **{name: np.eye(2)})
        with pytest.raises(ConfigError, match=r"mass: received shape \(2, 2\), needs finite numbers, shape \(2, 2\)"):
            linear_body(database, ["Heave", "Pitch"], mass=np.array([[1.0, 0.0], [0.0, np.nan]]))
        with pytest.raises(ConfigError, match="stiffness: received a matrix that is not symmetric"):
            linear_body(database, ["Heave", "Pitch"], stiffness=np.array([[1.0, 2.0], [0.0, 1.0]]))
        with pytest.raises(ConfigError, match="mass: received Heave without inertia"):
            linear_body(database, ["Surge", "Heave"], mass=np.diag([1e5, -1e9]))
        dry = database.drop_vars(["inertia_matrix"])
        with pytest.raises(ConfigError, match="mass: received none, and the database holds no structure"):
            linear_body(dry)

    def test_take_offs_of_nothing(self, database):
        with pytest.raises(ConfigError, match="pto: received no port, needs the motion it takes off"):
            linear_body(database, pto=LinearPto(1.0))
        with pytest.raises(ConfigError, match=r"pto: received a port of \(3,\), needs \(8,\)"):
            linear_body(database, pto=LinearPto(1.0, 0.0, np.ones(3)))
        with pytest.raises(ConfigError, match="port: received Lid; needs some of Heave, Pitch"):
            combination(["Heave", "Pitch"], {"Lid": 1.0})
        with pytest.raises(ConfigError, match="needs finite shares, not all zero"):
            combination(["Heave", "Pitch"], {"Heave": 0.0})

    def test_waves_that_were_not_solved(self, database):
        body = linear_body(database)
        with pytest.raises(DatabaseError, match=r"received 0.1 to 3 rad/s, the database holds 0.2 to 1.8 rad/s"):
            body.coefficients(np.array([0.1, 3.0]))
        for beyond in (0.2 - 2e-9, 1.8 + 2e-9):
            with pytest.raises(DatabaseError, match=r"the database holds 0\.2 to 1\.8 rad/s; solve a wider band"):
                body.coefficients(np.array([beyond, 1.0]))
        body.coefficients(np.array([0.2 - 0.5e-9, 1.8 + 0.5e-9]))
        with pytest.raises(DatabaseError, match=r"received 30 degrees, needs one of 0, 45"):
            replace(body, direction=np.pi / 6).coefficients(np.array([1.0]))

    def test_a_body_that_falls_over(self, database):
        stiffness = database.structural_stiffness.values - 1e9 * np.eye(8)[3] * np.eye(8)[:, [3]]
        with pytest.raises(StabilityError, match=r"received a negative stiffness of Roll, growing by"):
            body_scene(linear_body(database, stiffness=stiffness), None, {})


def test_a_body_that_makes_no_waves_rings_on(database):
    body = linear_body(database, ["Heave"])
    motion, record = run(body_scene(body, None, {}), NO_WAVES, 30.0, initial_position=1.0)
    omega = np.sqrt(body.stiffness[0, 0] / (body.mass + body.added_mass_inf)[0, 0])
    assert motion.position[:, 0] == pytest.approx(np.cos(omega * motion.time), abs=1e-9)
    assert isinstance(body, LinearBody)
    assert isinstance(record, xr.Dataset)


def test_added_mass_at_infinity_is_the_median_of_what_each_frequency_says():
    """K(s) = s/(s^2 + s + 1): B = Re K(i omega) and A = A(inf) + Im K(i omega)/omega; a few wrong ones do nothing."""
    omega = np.linspace(0.05, 20.0, 201)
    memory = 1j * omega / (1 - omega**2 + 1j * omega)
    added = 7.0 + memory.imag / omega
    added[[0, 60, -1]] += 1e4
    pair = ("influenced_dof", "radiating_dof")
    data = {"added_mass": added, "radiation_damping": memory.real}
    ds = xr.Dataset({name: (("omega", *pair), value[:, None, None]) for name, value in data.items()}, {"omega": omega})
    found = with_added_mass_inf(ds)
    assert found.added_mass_inf.dims == pair
    assert found.added_mass_inf.item() == pytest.approx(7.0, abs=1e-3)
    words = "added mass at infinite frequency from damping"
    assert found.attrs["history"] == words
    assert with_added_mass_inf(ds.assign_attrs(history="read")).attrs["history"] == f"read; {words}"


def test_added_mass_is_constant_below_the_band_and_nears_its_limit_with_frequency_squared_above():
    omega, pair = np.linspace(0.5, 4.0, 36), ("influenced_dof", "radiating_dof")
    swept = {"added_mass": 3.0 + 0.1 * omega**3 - 0.2 * omega, "radiation_damping": 0 * omega + 1.0}
    ds = xr.Dataset(
        {name: (("omega", *pair), value[:, None, None]) for name, value in swept.items()}
        | {"added_mass_inf": (pair, [[2.0]]), "hydrostatic_stiffness": (pair, [[5.0]])}
        | {"excitation_force": (("omega", "wave_direction", pair[0]), np.ones((36, 1, 1), complex))},
        {"omega": omega, "wave_direction": [0.0]} | {dim: ["Heave"] for dim in pair},
    )
    one = np.ones((1, 1))
    body = linear_body(ds, mass=one, damping=0 * one, stiffness=0 * one)

    def inside(w):
        return 3.0 + 0.1 * w**3 - 0.2 * w

    for w in (0.5, 1.234, 4.0):
        assert body.added_mass_at(w).item() == pytest.approx(inside(w), rel=1e-12)
    assert body.added_mass_at(0.01).item() == pytest.approx(inside(0.5), rel=1e-12)
    for times in (1.1, 2.0, 10.0):
        assert body.added_mass_at(4.0 * times).item() - 2.0 == pytest.approx((inside(4.0) - 2.0) / times**2, rel=1e-12)


def test_wet_modes_ascend_each_with_its_own_damping_where_added_mass_has_a_resonance():
    """As of a body nearly immersed: each motion swings at three frequencies, and the stiffer one's may be found first."""
    omega, pair, at = np.linspace(0.02, 12.0, 1200), ("influenced_dof", "radiating_dof"), 2.8098533
    mass, stiffness, damping = np.array([0.42785637, 0.3485005]), np.array([6.9424027, 6.6098292]), np.array([0.1, 0.7])
    strength, width = np.array([1.12164434, 1.3309423]), 0.05042252921789762

    def added(w):
        apart = at**2 - np.asarray(w)[..., None] ** 2
        return strength * apart / (apart**2 + (width * np.asarray(w)[..., None]) ** 2)

    ds = xr.Dataset(
        {
            "added_mass": (("omega", *pair), added(omega)[:, :, None] * np.eye(2)),
            "radiation_damping": (("omega", *pair), np.zeros((1200, 2, 2))),
            "added_mass_inf": (pair, np.zeros((2, 2))),
            "hydrostatic_stiffness": (pair, np.zeros((2, 2))),
            "excitation_force": (("omega", "wave_direction", pair[0]), np.ones((1200, 1, 2), complex)),
        },
        {"omega": omega, "wave_direction": [0.0]} | {dim: ["one", "other"] for dim in pair},
    )
    body = linear_body(ds, mass=np.diag(mass), damping=np.diag(damping), stiffness=np.diag(stiffness))
    frequencies, ratios = body.natural_modes(np.eye(2))
    assert frequencies[1] > 1.2 * frequencies[0]
    for w, ratio in zip(frequencies, ratios, strict=True):
        inertia = mass + added(w)
        own = int(np.argmin(np.abs(stiffness - w**2 * inertia)))
        assert w**2 * inertia[own] == pytest.approx(stiffness[own], rel=1e-6)
        assert ratio == pytest.approx(damping[own] / (2 * w * inertia[own]), rel=1e-6)


def afloat(labels, mass, stiffness, direction=0.0, directions=(0.0,)):
    """A body that makes no waves, in waves whose force is the number of their direction, from one on."""
    omega, pair, dof = np.linspace(0.5, 4.0, 8), ("influenced_dof", "radiating_dof"), len(labels)
    force = np.ones((8, len(directions), dof)) * (1.0 + np.arange(len(directions)))[:, None]
    ds = xr.Dataset(
        {name: (("omega", *pair), np.zeros((8, dof, dof))) for name in ("added_mass", "radiation_damping")}
        | {"added_mass_inf": (pair, np.zeros((dof, dof))), "hydrostatic_stiffness": (pair, np.diag(stiffness))}
        | {"excitation_force": (("omega", "wave_direction", pair[0]), force.astype(complex))},
        {"omega": omega, "wave_direction": list(directions)} | {dim: list(labels) for dim in pair},
    )
    none = np.zeros((dof, dof))
    return replace(linear_body(ds, mass=np.diag(mass), damping=none, stiffness=none), direction=direction)


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
@pytest.mark.parametrize(("degrees", "force"), [(0.0, 1.0), (180.0, 2.0), (-90.0, 3.0)])
def test_a_direction_and_full_turns_from_it_are_one(turns, degrees, force):
    body = afloat(("Heave",), [2.0], [3.0], np.deg2rad(degrees + 360.0 * turns), np.deg2rad([0.0, 180.0, 270.0]))
    assert body.coefficients(np.array([1.0, 2.0])).excitation == pytest.approx(np.full((2, 1), force))


def test_the_motion_told_of_a_body_that_falls_over_has_most_of_the_energy():
    """Not the largest number: a light part goes far with a heavy one that falls."""
    body = afloat(("Heave", "Light"), [1e4, 1e-2], [0.0, 1.0])
    matrix = np.array([[-1e4, -10.0], [-10.0, 1.0]])
    _, shapes = eigh(matrix, body.mass)
    assert abs(shapes[1, 0]) > 5 * abs(shapes[0, 0])
    with pytest.raises(StabilityError, match="negative stiffness of Heave, growing by"):
        body.drifting(matrix, np.eye(2))


def test_a_scene_has_the_added_mass_its_memory_was_fitted_with():
    """Of a fit that found another limit than the database's; without memory the database's own."""
    body = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    model = RadiationModel(np.array([[-0.5]]), np.array([[1.0, 0.3]]), np.ones(1))
    added = np.array([[3.0, 0.5], [0.5, 2.0]])
    np.testing.assert_array_equal(body_scene(body, Memory(model, added), {}).mass, np.diag([4.0, 5.0]) + added)
    np.testing.assert_array_equal(body_scene(body, None, {}).mass, np.diag([4.0, 5.0]))


def test_a_scene_of_a_body_has_no_force_that_the_body_lacks():
    """No spring of a structure where there is none, no damper, no waves."""
    labels, port = ("Heave", "Pitch"), LinearPto(1e4, 0.0, np.eye(2)[0])
    bare = afloat(labels, [4.0, 5.0], [9.0, 9.0])
    assert set(body_scene(bare, None, {}).forces) == {"hydrostatic"}
    sprung = linear_body(bare.database, mass=bare.mass, damping=0 * bare.mass, stiffness=np.diag([0.0, 1.0]))
    assert set(body_scene(sprung, None, {}).forces) == {"hydrostatic", "elastic"}
    damped = replace(bare, structural_damping=np.diag([0.0, 1.0]))
    assert set(body_scene(damped, None, {}).forces) == {"hydrostatic", "structural_damping"}
    assert set(body_scene(replace(bare, pto=port), None, {}).forces) == {"hydrostatic", "pto"}
    seas = {0.0: NO_WAVES, 1.0: Sea(np.array([1.0]), np.ones(1, complex))}
    assert set(body_scene(bare, None, {0.0: seas[0.0]}).forces) == {"hydrostatic"}


@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_a_start_is_of_heave_and_what_is_held_with_it_follows(unit):
    """Whatever rotations are counted in: next to heave alone, surge turned against by the mass they have in common."""
    labels, counted = ("Surge", "Heave", "Pitch", "Bending"), np.diag([1.0, 1.0, 1 / unit, 1.0])
    mass = np.array([[4.0, 0.3, 0.8, 0.0], [0.3, 5.0, 0.0, 0.7], [0.8, 0.0, 6.0, 0.0], [0.0, 0.7, 0.0, 2.0]])
    none = np.zeros((4, 4))
    bare = afloat(labels, np.ones(4), np.ones(4))
    body = linear_body(bare.database, mass=counted @ mass @ counted, damping=none, stiffness=none)

    def begun(*held):
        scene = body_scene(body, None, {}, body_motions("one", BodyDesign(held=held), labels))
        return [counted @ scene.motions @ y for y in scene.start(0.3, -0.6)]

    for position, velocity in (begun(), begun({"Bending": 2.0}), begun({"Surge": 1.0, "Pitch": 3.0})):
        assert position == pytest.approx([0.0, 0.3, 0.0, 0.0], abs=1e-15)
        assert velocity == pytest.approx([0.0, -0.6, 0.0, 0.0], abs=1e-15)
    position, _ = begun({"Heave": 1.0, "Pitch": -2.0 / unit})
    assert position == pytest.approx([-0.8 / 4.0 * 0.15, 0.3, 0.15, 0.0], rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(
    ("labels", "design", "started"),
    [
        (("float__Surge", "float__Heave", "plate__Heave"), {}, "float__Heave"),
        (("float__Surge", "float__Heave", "plate__Heave"), {"held": [{"float__Heave": 1.0}]}, "plate__Heave"),
        (("Surge", "Pitch", "Bending"), {}, "Surge"),
        (("Surge", "Pitch", "Bending"), {"dofs": ["Bending", "Pitch"]}, "Pitch"),
        (("Surge", "Pitch", "Heave"), {"dofs": ["Pitch", "Heave"]}, "Heave"),
        (("Surge", "Pitch", "Heave"), {"dofs": ["Pitch", "Surge"]}, "Surge"),
    ],
)
def test_a_start_is_of_the_first_heave_there_is_or_of_the_first_motion(labels, design, started):
    body = afloat(labels, 2.0 + np.arange(3), np.ones(3))
    scene = body_scene(body, None, {}, body_motions("one", BodyDesign(**design), labels))
    position, velocity = (scene.motions @ y for y in scene.start(0.3, -0.6))
    assert position == pytest.approx(0.3 * np.array([label == started for label in labels]), abs=1e-15)
    assert velocity == pytest.approx(-2 * position)
    assert System.of(scene).heaving == pytest.approx((1.0 / body.mass.diagonal()[labels.index(started)]) ** 0.5)


@pytest.mark.parametrize(
    ("matrix", "rate", "most"),
    [
        ([[1.0, 0.0], [0.0, -2.0]], "0.4", "Pitch"),
        ([[-2.0, 0.0], [0.0, 1.0]], "0.5", "Heave"),
        ([[1.0, 3.0], [3.0, 4.0]], "0.2", "Heave"),
        ([[5.0, -4.0], [-4.0, 1.0]], "0.312", "Pitch"),
        ([[5.0, 4.0], [4.0, 1.0]], "0.312", "Pitch"),
    ],
)
def test_dampers_of_the_dry_body_give_no_energy(matrix, rate, most):
    """Nor do several together, each of which alone takes some; what is none by round-off is none."""
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])

    def damped(matrix):
        return linear_body(bare.database, mass=bare.mass, damping=np.asarray(matrix), stiffness=0 * bare.mass)

    with pytest.raises(
        ConfigError, match=rf"damping: received a matrix that gives energy to {most}, by {rate}/s; needs"
    ):
        damped(matrix)
    assert damped(np.ones((2, 2))).structural_damping.any()
    three = afloat(("Heave", "Pitch", "Bend"), [4.0, 5.0, 6.0], [9.0, 9.0, 9.0])
    with pytest.raises(ConfigError, match="damping: received a matrix that gives energy to Bend, by "):
        linear_body(
            three.database, mass=three.mass, stiffness=0 * three.mass,
            damping=np.array([[1.0, 0.5, 2.0], [0.5, 3.0, 1.0], [2.0, 1.0, 1.0]]),
        )  # fmt: skip
    assert damped(np.array([[1.0, 1.0], [1.0, 1.0 - 1e-8]])).structural_damping.any()
    assert not damped(np.zeros((2, 2))).structural_damping.any()


@pytest.mark.parametrize(
    ("mass", "added", "without"),
    [
        ([[4.0, 0.0], [0.0, 0.0]], 0.0, "Pitch"),
        ([[0.0, 0.0], [0.0, 5.0]], 0.0, "Heave"),
        ([[-2.0, 0.0], [0.0, -5.0]], 1.0, "Heave, Pitch"),
        ([[4.0, 5.0], [5.0, 5.0]], 0.0, "motions"),  # each has some, both together less than none
        ([[4.0, -5.0], [-5.0, 5.0]], 0.0, "motions"),
        ([[0.0, 0.0], [0.0, -1.0]], 1.0, "Pitch"),
        ([[0.0, 0.0], [0.0, -1.0]], 2.0, None),  # the water's is enough
    ],
)
def test_what_has_no_inertia_with_the_water_s_is_told_by_name(mass, added, without):
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    ds = bare.database.assign(added_mass_inf=bare.database.added_mass_inf + added * np.eye(2))
    none = np.zeros((2, 2))
    if without is None:
        assert linear_body(ds, mass=np.array(mass), damping=none, stiffness=none).labels == ("Heave", "Pitch")
        return
    with pytest.raises(ConfigError, match=f"^mass: received {without} without inertia, the water's at infinite"):
        linear_body(ds, mass=np.array(mass), damping=none, stiffness=none)


@pytest.mark.parametrize(("damping", "stiffness"), [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (np.array([0.0, 2.0]), 0.0)])
def test_a_take_off_that_does_something_needs_a_port(damping, stiffness):
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    with pytest.raises(
        ConfigError, match=r"^pto: received no port, needs the motion it takes off; see `combination`\.$"
    ):
        replace(bare, pto=LinearPto(damping, stiffness))
    assert replace(bare, pto=LinearPto(0.0, 0.0)).pto.port is None


def test_what_falls_is_told_by_its_rate_with_the_water_s_inertia_and_what_holds_it_does():
    """exp(s t) of (M + A) s^2 = -k; the take-off's spring, or a motion held, keeps it up."""
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    ds = bare.database.assign(added_mass_inf=bare.database.added_mass_inf + np.diag([1.0, 3.0]))
    none = np.zeros((2, 2))

    def falling(**spring):
        return linear_body(ds, mass=bare.mass, damping=none, stiffness=np.diag([0.0, -41.0]), **spring)

    with pytest.raises(
        StabilityError, match=r"^the body does not rest: received a negative stiffness of Pitch, growing by 2/s;"
    ):
        body_scene(falling(), None, {})
    up = falling(pto=LinearPto(0.0, 50.0, np.eye(2)[1]))
    assert body_scene(up, None, {}).stiffness == pytest.approx(np.diag([9.0, 18.0]))
    assert body_scene(falling(), None, {}, np.eye(2)[:, :1]).stiffness == pytest.approx(np.diag([9.0]))


@pytest.mark.parametrize("motions", [np.eye(2), np.eye(2)[::-1], np.array([[0.0, -0.5], [3.0, 0.0]])])
@pytest.mark.parametrize(("added", "named"), [([100.0, 0.0], "Heave"), ([0.0, 100.0], "Pitch"), ([0.0, 0.0], "Pitch")])
def test_the_motion_that_falls_is_named_by_the_energy_of_the_water_too(motions, added, named):
    """Half as far in heave as in pitch, of nearly the same mass; in whatever motions a design has."""
    bare, none = afloat(("Heave", "Pitch"), [1.0, 1.2], [9.0, 9.0]), np.zeros((2, 2))
    ds = bare.database.assign(added_mass_inf=bare.database.added_mass_inf + np.diag(added))
    body = linear_body(ds, mass=bare.mass, damping=none, stiffness=none)
    fall = (body.mass + body.added_mass_inf) @ np.array([1.0, 2.0])
    stiffness = -4.0 * np.outer(fall, fall) / (fall @ np.array([1.0, 2.0]))
    with pytest.raises(StabilityError, match=f"received a negative stiffness of {named}, growing by 2/s; needs"):
        body.drifting(motions.T @ stiffness @ motions, motions)


def test_a_stiffness_that_is_none_by_round_off_lets_drift_and_does_not_fall():
    """In terms of the stiffest, be it of a model in a basin or of a ship."""
    body = afloat(("Surge", "Heave"), [4.0, 4.0], [0.0, 9.0])
    for size in (1.0, 1e-6, 1e9):
        for soft in (-5e-9, 5e-9):
            loose = body.drifting(size * np.diag([soft, 9.0]), np.eye(2))
            assert loose == pytest.approx(np.array([[0.5], [0.0]]))
        assert body.drifting(size * np.diag([2e-8, 9.0]), np.eye(2)).shape == (2, 0)
        with pytest.raises(StabilityError, match=r"^the body does not rest: received a negative stiffness of Surge"):
            body.drifting(size * np.diag([-2e-8, 9.0]), np.eye(2))
    assert body.drifting(np.zeros((2, 2)), np.eye(2)).shape == (2, 2)


def test_each_motion_s_radiation_is_measured_by_its_damping_and_its_inertia_with_the_water_s():
    omega, pair = np.linspace(0.5, 4.0, 8), ("influenced_dof", "radiating_dof")
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    damping = omega[:, None, None] * np.diag([2.0, 0.0])
    ds = bare.database.assign(
        added_mass_inf=(pair, np.diag([1.0, 300.0])), radiation_damping=(("omega", *pair), damping),
        added_mass=(("omega", *pair), np.broadcast_to(np.diag([1.0, 300.0]), (8, 2, 2))),
    )  # fmt: skip
    samples = linear_body(ds, mass=bare.mass, damping=0 * bare.mass, stiffness=0 * bare.mass).samples
    np.testing.assert_array_equal(samples.size, sizes(omega, damping, np.array([5.0, 305.0])))
    assert not np.allclose(samples.size, sizes(omega, damping, np.array([4.0, 5.0])), rtol=1e-12)


def test_still_water_among_several_seas_is_none_and_no_seas_are_one_without_waves():
    sea = Sea(np.array([1.0, 2.0]), np.array([0.3, 0.1j]))
    assert together({}).omega.size == together({}).amplitude.size == 0
    both = together({0.0: NO_WAVES, 1.0: sea, 2.0: Sea(np.array([1.5]), np.array([0.2 + 0j]))})
    assert both.omega.tolist() == [1.0, 2.0, 1.5]
    assert both.amplitude.tolist() == [0.3, 0.1j, 0.2]
    body = afloat(("Heave",), [2.0], [3.0], directions=(0.0, 1.0, 2.0))
    assert body.coefficients(np.zeros(0)).excitation.shape == (0, 1)
    pushed = body_scene(
        body, None, {0.0: NO_WAVES, 1.0: sea, 2.0: Sea(np.array([1.5]), np.array([0.2 + 0j]))}
    ).excitation
    assert pushed.omega.tolist() == [1.0, 2.0, 1.5]
    assert pushed.phasors[:, 0] == pytest.approx([0.6, 0.2j, 0.6])


@pytest.mark.parametrize(
    ("motions", "started"),
    [
        (-np.eye(3), "Heave"),
        (np.array([[1.0, 0.0], [0.0, -1.0], [0.0, 0.0]]), "Heave"),
        (np.array([[1.0, 0.0], [1e-17, 1e-16], [0.0, 1.0]]), "Surge"),  # heave is held but for round-off
        (np.array([[-1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]), "Surge"),
        (np.array([[-1e-14], [0.0], [-0.8]]), "Pitch"),
    ],
)
@pytest.mark.parametrize("size", [1.0, 1e-10, 1e8])
def test_a_start_is_one_metre_up_whatever_the_sign_and_size_of_the_motions_allowed(motions, started, size):
    labels = ("Surge", "Heave", "Pitch")
    body = afloat(labels, [4.0, 5.0, 6.0], [1.0, 1.0, 1.0])
    scene = body_scene(body, None, {}, size * motions)
    position, velocity = (scene.motions @ y for y in scene.start(0.3, -0.6))
    assert position == pytest.approx(0.3 * np.array([label == started for label in labels]), abs=1e-12)
    assert velocity == pytest.approx(-2 * position)


@pytest.mark.parametrize("name", ["mass", "damping", "stiffness"])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_matrices_of_the_dry_body_are_symmetric_to_a_millionth_of_their_largest_entry(name, scale):
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    sound = {"mass": scale * np.diag([4.0, 5.0]), "damping": np.zeros((2, 2)), "stiffness": np.zeros((2, 2))}
    for part in (0.9, -0.9, 1.1, -1.1):
        wrong = sound | {name: scale * np.array([[4.0, 1.0], [1.0 + 5e-6 * part, 5.0]])}
        if abs(part) < 1:
            linear_body(bare.database, **wrong)
            continue
        with pytest.raises(ConfigError, match=f"^{name}: received a matrix that is not symmetric, needs a symmetric"):
            linear_body(bare.database, **wrong)


@pytest.mark.parametrize(
    ("wanted", "told"), [([], "none"), (["Pitch", "Pitch"], "Pitch, Pitch"), (["Heave", "Yaw"], "Heave, Yaw")]
)
def test_degrees_of_freedom_wanted_are_some_of_those_there_each_once(wanted, told):
    body = afloat(("Surge", "Heave", "Pitch"), [4.0, 5.0, 6.0], [1.0, 2.0, 3.0])
    none = xr.zeros_like(body.database.inertia_matrix)
    some = linear_body(body.database.assign(structural_damping_matrix=none), ["Pitch", "Surge"])
    assert (some.labels, np.diag(some.mass).tolist(), np.diag(some.stiffness).tolist()) == (
        ("Pitch", "Surge"), [6.0, 4.0], [3.0, 1.0],
    )  # fmt: skip
    with pytest.raises(
        ConfigError, match=rf"^degrees of freedom: received {told}; needs some of Surge, Heave, Pitch\.$"
    ):
        linear_body(body.database, wanted, mass=np.eye(2), damping=np.eye(2), stiffness=np.eye(2))


def test_frequencies_beyond_the_band_are_told_from_the_lowest_to_the_highest():
    body = afloat(("Heave",), [4.0], [9.0])
    for asked in ([4.5, 1.0], [0.3, 3.9], [5.0, 0.1, 2.0]):
        with pytest.raises(
            DatabaseError,
            match=rf"^frequencies: received {min(asked):.4g} to {max(asked):.4g} rad/s, the database holds 0.5 to 4 rad/s; ",
        ):
            body.coefficients(np.array(asked))


@pytest.mark.parametrize("place", ["body", "database", "memory"])
def test_what_is_held_with_heave_follows_by_the_inertia_of_the_water_too(place):
    """Of the database, or as the memory was fitted with it: the same start wherever the mass in common stands."""
    labels = ("Surge", "Heave", "Pitch", "Bending")
    mass = np.array([[4.0, 0.3, 0.8, 0.0], [0.3, 5.0, 0.0, 0.7], [0.8, 0.0, 6.0, 0.0], [0.0, 0.7, 0.0, 2.0]])
    own, none = np.diag([1.0, 2.0, 3.0, 1.5]), np.zeros((4, 4))
    bare = afloat(labels, np.ones(4), np.ones(4))
    inf = {"body": none, "database": mass - own, "memory": 0.1 * np.eye(4)}[place]
    ds = bare.database.assign(added_mass_inf=(("influenced_dof", "radiating_dof"), inf))
    body = linear_body(ds, mass=mass if place == "body" else own, damping=none, stiffness=none)
    model = RadiationModel(np.array([[-0.5]]), np.array([[1.0, 0.3, 0.0, 0.0]]), np.ones(1))
    radiation = Memory(model, mass - own) if place == "memory" else None
    held = ({"Heave": 1.0, "Pitch": -2.0},)
    scene = body_scene(body, radiation, {}, body_motions("one", BodyDesign(held=held), labels))
    position, velocity = (scene.motions @ y for y in scene.start(0.3, -0.6))
    assert position == pytest.approx([-0.8 / 4.0 * 0.15, 0.3, 0.15, 0.0], rel=1e-12, abs=1e-15)
    assert velocity == pytest.approx(-2 * position)


@pytest.mark.parametrize("turn", [0.0, 2 * np.pi, -4 * np.pi])
@pytest.mark.parametrize("side", [1, -1])
def test_a_direction_is_one_of_those_there_to_a_millionth(turn, side):
    known = np.array([0.0, np.pi / 2, -3.0])
    for place, direction in enumerate(known):
        assert direction_index(known, direction + turn + 0.9e-6 * side) == place
        assert direction_index(known, direction + turn + 1.1e-6 * side) is None


def test_a_memory_is_fitted_to_the_samples_of_the_body_as_near_and_with_the_limit_asked_for(monkeypatch):
    body, asked = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0]), []
    monkeypatch.setattr(bodies, "fit_passive", lambda *given, **options: asked.append((given, options)))
    body.memory(0.02)
    body.memory(1e-4, limit="fitted")
    assert asked == [((body.samples, 0.02), {"limit": "given"}), ((body.samples, 1e-4), {"limit": "fitted"})]


def test_samples_of_radiation_are_those_of_the_database():
    omega, pair = np.linspace(0.5, 4.0, 8), ("influenced_dof", "radiating_dof")
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    rng = np.random.default_rng(0)
    added, factor = rng.normal(size=(2, 8, 2, 2))
    added, damping = added + added.swapaxes(1, 2), factor @ factor.swapaxes(1, 2)
    ds = bare.database.assign(
        added_mass=(("omega", *pair), added),
        radiation_damping=(("omega", *pair), damping),
        added_mass_inf=(pair, np.diag([1.0, 3.0])),
    )
    samples = linear_body(ds, mass=bare.mass, damping=0 * bare.mass, stiffness=0 * bare.mass).samples
    for found, known in ((samples.omega, omega), (samples.added_mass, added), (samples.damping, damping)):
        np.testing.assert_array_equal(found, known)
    np.testing.assert_array_equal(samples.added_mass_inf, np.diag([1.0, 3.0]))


def test_damping_that_is_given_need_not_be_stored(database):
    """Mass and stiffness are then the database's; of what is not given it says what it lacks."""
    bare = database.drop_vars("structural_damping_matrix", errors="ignore").drop_attrs()
    with pytest.raises(DatabaseError, match=r"^database: holds no spec; needs structural_damping_matrix"):
        linear_body(bare)
    stored = linear_body(database)
    given = linear_body(bare, damping=np.diag(np.arange(1.0, 9.0)))
    np.testing.assert_array_equal(given.structural_damping, np.diag(np.arange(1.0, 9.0)))
    np.testing.assert_array_equal(given.mass, stored.mass)
    np.testing.assert_array_equal(given.stiffness, stored.stiffness)
    with pytest.raises(ConfigError, match=r"^damping: received shape \(2, 2\), needs finite numbers, shape \(8, 8\)"):
        linear_body(bare, damping=np.eye(2))


@pytest.mark.parametrize("name", ["mass", "damping", "stiffness"])
def test_a_matrix_of_other_motions_is_told_by_its_name(name):
    """Whichever of the three it is, the others being sound."""
    body = afloat(("Surge", "Heave", "Pitch"), [4.0, 5.0, 6.0], [1.0, 2.0, 3.0])
    sound = {"mass": np.eye(2), "damping": np.eye(2), "stiffness": np.eye(2)}
    for wrong in (np.eye(3), np.eye(1), np.ones(2), np.ones((2, 3))):
        with pytest.raises(
            ConfigError, match=rf"^{name}: received shape {re.escape(str(wrong.shape))}, needs finite .* shape \(2, 2\)"
        ):
            linear_body(body.database, ["Pitch", "Surge"], **(sound | {name: wrong}))


@pytest.mark.parametrize("port", [np.ones(3), np.ones(1), np.ones((2, 1)), np.zeros(0)])
def test_a_take_off_of_other_motions_is_refused(port):
    """Of more of them, of fewer, or of none."""
    bare = afloat(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    with pytest.raises(ConfigError, match=rf"^pto: received a port of {re.escape(str(port.shape))}, needs \(2,\)"):
        replace(bare, pto=LinearPto(1.0, 0.0, port))
