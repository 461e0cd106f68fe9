"""Bodies with generalized modes: time against frequency domain, limits of stiff and heavy hulls, refused input."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import labelled

from examples.barge import Barge, box
from vsb.errors import ConfigError, DatabaseError, StabilityError
from vsb.hydro.bodies.body import FlexibleBody
from vsb.hydro.bodies.mesh import at_centres
from vsb.hydro.bodies.study import solve
from vsb.hydro.database import Check, as_json, open_database
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.simulate import simulate
from vsb.motion.bodies import (
    LinearBody,
    Memory,
    body_scene,
    linear_body,
    together,
    with_added_mass_inf,
)
from vsb.motion.coefficient_errors import INTERPOLATION, OF_OTHERS, RESOLUTION, coefficient_errors
from vsb.motion.port import LinearPto, combination
from vsb.motion.system import System
from vsb.scenes.floating_system import body_motions
from vsb.study.body import BodyDesign, BodyFile
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


def test_fitted_radiation_reproduces_the_samples(database, fit):
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


def test_time_and_frequency_domain_agree_in_waves_from_several_directions(database, fit):
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


def test_free_decay_in_heave_conserves_the_energy_balance(database, fit):
    body = moored(database)
    motion, record = run(body_scene(body, fit, {}), NO_WAVES, 60.0, initial_position=0.5)
    assert motion.position[0] == pytest.approx(0.5 * np.eye(8)[2])
    assert np.abs(motion.position[:, 2]).max() == pytest.approx(0.5, rel=1e-6)
    assert record.attrs["energy_residual"] < 1e-9
    assert float(record.energy.isel(time=-1).sum()) == pytest.approx(0.0, abs=1e-6 * float(record.energy.max()))


def test_state_space_and_convolution_agree(database):
    """The added mass follows from Kramers-Kronig, as in the convolution."""
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


def test_stiff_barge_approaches_the_rigid_one(database):
    """Free-free modes of a beam a thousand times as stiff; the difference is of first order in compliance."""
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


def test_heavy_barge_has_the_natural_frequencies_of_a_free_free_beam(database):
    """Mass and stiffness grow alike, the share of the water vanishes: (k_n/L)^2 sqrt(EI/m) of beam theory."""
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


def test_power_of_the_port_is_that_absorbed_by_the_damper(database):
    omega, free = np.linspace(0.4, 1.8, 8), np.eye(8)
    body = replace(moored(database), direction=OBLIQUE)
    port = body.port(omega, free, body.pto.direction(8))
    absorbed = body.absorbed_power(omega, body.rao(omega, free))
    assert port.power(body.pto.damping, body.pto.stiffness) == pytest.approx(absorbed, rel=1e-9)
    assert (absorbed <= port.matched_power * (1 + 1e-9)).all()


def test_unrestrained_motions_have_no_natural_frequency(database):
    """BaseStudy with springs so soft that the three unrestrained motions take hours."""
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


def test_axisymmetric_and_general_formulations_agree(buoy_of, coarse):
    """The database of an axisymmetric buoy, its single radiation channel not used."""
    buoy = with_one_channel(buoy_of(coarse))
    omega, free = buoy.spectrum.omega[4:-4:7], np.eye(len(buoy.mass))
    dry = buoy.stiffness - buoy.stiffness_parts["hydrostatic"]
    pto = replace(buoy.pto, port=free[0])
    body = linear_body(buoy.database, mass=buoy.mass, damping=buoy.structural_damping, stiffness=dry, pto=pto)
    assert body.rao(omega, free) == pytest.approx(buoy.rao(omega, free), rel=1e-9)


def test_errors_of_a_body_from_panels_and_radiated_waves(database):
    body, at = moored(database), database.omega.values[2:4]
    checks = as_json([Check("error_estimate", 0.2, 0.05, "-", "doubt", "")])
    stated = body.database.assign_attrs(quality=checks)
    panels, waves = coefficient_errors(type(body)(stated, body.structural_damping, body.pto), np.array([at.mean()]))
    assert (panels.name, waves.name) == (f"{RESOLUTION} (fewer panels)", f"{RESOLUTION} (waves radiated)")
    assert panels.signed
    both = database.added_mass_error.sel(omega=at).values
    np.testing.assert_allclose(panels.error.added_mass[0], both[0].mean(axis=0), atol=1e-9 * np.abs(both).max())
    assert not waves.error.added_mass.any()
    assert np.abs(waves.error.damping).max() > 0
    assert np.abs(panels.stiffness).max() > 0
    assert not waves.stiffness.any()


def test_file_without_stated_error_gets_one_per_cent(database):
    body = moored(database)
    bare = body.database.drop_vars([name for name in body.database if str(name).endswith("_error")])
    stated = Check("interpolation_error", 0.02, 0.05, "-", "ok", "")
    for checks, names in (([], [OF_OTHERS]), ([stated], [OF_OTHERS, INTERPOLATION])):
        read = type(body)(bare.assign_attrs(quality=as_json(checks)), body.structural_damping, body.pto)
        errors = coefficient_errors(read, np.array([1.0]))
        assert [error.name for error in errors] == names
        known = read.coefficients(np.array([1.0])).added_mass
        np.testing.assert_allclose(errors[0].error.added_mass, 0.01 * np.abs(known))


def test_body_without_radiation_oscillates_undamped(database):
    body = linear_body(database, ["Heave"])
    motion, record = run(body_scene(body, None, {}), NO_WAVES, 30.0, initial_position=1.0)
    omega = np.sqrt(body.stiffness[0, 0] / (body.mass + body.added_mass_inf)[0, 0])
    assert motion.position[:, 0] == pytest.approx(np.cos(omega * motion.time), abs=1e-9)
    assert isinstance(body, LinearBody)
    assert isinstance(record, xr.Dataset)


def test_added_mass_at_infinite_frequency_is_robust_to_outliers():
    """K(s) = s/(s^2 + s + 1): B = Re K(i omega), A = A(inf) + Im K(i omega)/omega."""
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
    assert found.attrs["history"] == "added mass at infinite frequency from damping"


def floating_body(labels, mass, stiffness, direction=0.0, directions=(0.0,)):
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


@pytest.mark.parametrize("turns", [-2, 0, 1])
@pytest.mark.parametrize(("degrees", "force"), [(0.0, 1.0), (180.0, 2.0), (-90.0, 3.0)])
def test_wave_directions_are_periodic(turns, degrees, force):
    body = floating_body(("Heave",), [2.0], [3.0], np.deg2rad(degrees + 360.0 * turns), np.deg2rad([0.0, 180.0, 270.0]))
    assert body.coefficients(np.array([1.0, 2.0])).excitation == pytest.approx(np.full((2, 1), force))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"dofs": ["Heave", "Roof"]}, r"^degrees of freedom: received Heave, Roof; needs some of Heave, Pitch\.$"),
        ({"mass": np.eye(3)}, r"^mass: received shape \(3, 3\), needs finite numbers, shape \(2, 2\)\.$"),
        ({"mass": np.diag([1.0, np.nan])}, r"^mass: received shape \(2, 2\), needs finite numbers, shape \(2, 2\)"),
        ({"stiffness": np.array([[1.0, 2.0], [0.0, 1.0]])}, "^stiffness: received a matrix that is not symmetric"),
        ({"mass": np.diag([1.0, -1.0])}, "^mass: received Pitch without inertia, the water's at infinite"),
        ({"damping": np.diag([1.0, -2.0])}, "^damping: received a matrix that gives energy to Pitch, by 0.4/s; needs"),
        ({"damping": [[1.0, 3.0], [3.0, 4.0]]}, "^damping: received a matrix that gives energy to Heave, by 0.2/s"),
        ({"pto": LinearPto(1.0)}, "^pto: received no port, needs the motion it takes off"),
        ({"pto": LinearPto(1.0, 0.0, np.ones(3))}, r"^pto: received a port of \(3,\), needs \(2,\)"),
    ],
)
def test_invalid_bodies_are_refused(changes, message):
    bare = floating_body(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    given = {"mass": bare.mass, "damping": np.zeros((2, 2)), "stiffness": np.zeros((2, 2))} | changes
    given = {
        name: np.asarray(value) if isinstance(value, list) and name != "dofs" else value
        for name, value in given.items()
    }
    with pytest.raises(ConfigError, match=message):
        linear_body(bare.database, given.pop("dofs", None), **given)


def test_waves_that_were_not_solved_are_refused():
    body = floating_body(("Heave",), [4.0], [9.0])
    with pytest.raises(
        DatabaseError, match=r"^frequencies: received 0.3 to 5 rad/s, the database holds 0.5 to 4 rad/s"
    ):
        body.coefficients(np.array([0.3, 5.0]))
    with pytest.raises(DatabaseError, match=r"received 30 degrees, needs one of 0"):
        replace(body, direction=np.pi / 6).coefficients(np.array([1.0]))


def test_unstable_body_is_refused():
    bare = floating_body(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    capsizing = linear_body(bare.database, mass=bare.mass, damping=0 * bare.mass, stiffness=np.diag([0.0, -29.0]))
    told = r"^the body does not rest: received a negative stiffness of Pitch, growing by 2/s;"
    with pytest.raises(StabilityError, match=told):
        body_scene(capsizing, None, {})


def test_zero_stiffness_is_judged_relative_to_the_largest():
    body = floating_body(("Surge", "Heave"), [4.0, 4.0], [0.0, 9.0])
    for size in (1.0, 1e-6, 1e9):
        for soft in (-5e-9, 5e-9):
            loose = body.unrestrained(size * np.diag([soft, 9.0]), np.eye(2))
            assert loose == pytest.approx(np.array([[0.5], [0.0]]))
        assert body.unrestrained(size * np.diag([2e-8, 9.0]), np.eye(2)).shape == (2, 0)
        with pytest.raises(StabilityError, match=r"^the body does not rest: received a negative stiffness of Surge"):
            body.unrestrained(size * np.diag([-2e-8, 9.0]), np.eye(2))
    assert body.unrestrained(np.zeros((2, 2)), np.eye(2)).shape == (2, 2)


@pytest.mark.parametrize("place", ["body", "database", "memory"])
def test_initial_heave_respects_constraints_with_all_inertia(place):
    """Wherever the common inertia stands: body, database or fitted memory."""
    labels = ("Surge", "Heave", "Pitch", "Bending")
    mass = np.array([[4.0, 0.3, 0.8, 0.0], [0.3, 5.0, 0.0, 0.7], [0.8, 0.0, 6.0, 0.0], [0.0, 0.7, 0.0, 2.0]])
    own, none = np.diag([1.0, 2.0, 3.0, 1.5]), np.zeros((4, 4))
    bare = floating_body(labels, np.ones(4), np.ones(4))
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
