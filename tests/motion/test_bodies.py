"""Bodies of any shape: time against frequency domain, the axisymmetric formulation, stated errors, refused input."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import labelled

from vsb.engine.hydro.database import Check, as_json
from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import simulate
from vsb.engine.motion.builders import linear_scene, together
from vsb.engine.motion.coefficient_errors import INTERPOLATION, OF_OTHERS, RESOLVED, coefficient_errors
from vsb.engine.motion.linear import linear_body, with_added_mass_inf
from vsb.engine.motion.port import LinearPto, combination
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import Sea
from vsb.errors import StabilityError
from vsb.models.floating_system import body_motions
from vsb.study.body import BodyDesign

PAIR = ("influenced_dof", "radiating_dof")
OBLIQUE = np.pi / 4


@pytest.fixture(scope="module")
def database():
    """Surge, heave, pitch and bending that radiate through two resonances, in waves from two sides."""
    omega, one = np.arange(1, 81) * 0.05, np.eye(4)
    s, radiated = 1j * omega[:, None, None], np.zeros((80, 4, 4), dtype=complex)
    for pole, channel in ((-0.4 + 0.6j, [1.0, 0.3, 0.2, 0.1]), (-0.4 + 1.8j, [-0.2, 0.8, 0.5, -0.4])):
        radiated += s / ((s - pole) * (s - pole.conjugate())) * np.outer(channel, channel)
    ahead = np.sqrt(np.einsum("wii->wi", radiated.real)) * np.exp(1j * np.arange(4.0))
    force = np.stack([ahead, 0.7 * ahead[:, ::-1]], axis=1)
    values = {
        "added_mass": (("omega", *PAIR), radiated.imag / omega[:, None, None] + one),
        "radiation_damping": (("omega", *PAIR), radiated.real),
        "excitation_force": (("omega", "wave_direction", PAIR[0]), force),
        "added_mass_inf": (PAIR, one), "hydrostatic_stiffness": (PAIR, np.diag([0.0, 1.5, 0.8, 0.0])),
        "inertia_matrix": (PAIR, one), "structural_stiffness": (PAIR, np.diag([0.3, 0.0, 0.0, 2.0])),
        "structural_damping_matrix": (PAIR, np.diag([0.1, 0.0, 0.1, 0.1])),
    }  # fmt: skip
    coords = {"omega": omega, "wave_direction": [0.0, OBLIQUE]}
    labels = ["Surge", "Heave", "Pitch", "Bending1"]
    return xr.Dataset(values, coords | {dim: labels for dim in PAIR})  # noqa: C420


def test_time_and_frequency_domain_agree_in_waves_from_several_directions(database):
    labels = [str(label) for label in database.influenced_dof.values]
    pto = LinearPto(0.2, 0.1, combination(labels, {"Heave": 1.0, "Bending1": -0.6}))
    body = replace(linear_body(database), pto=pto)
    fit = body.memory(1e-3, limit="fitted")
    waves = {
        0.0: Sea(np.array([0.9, 1.4]), np.array([0.3, 0.1 + 0.1j])),
        OBLIQUE: Sea(np.array([1.1]), np.array([0.2j])),
    }
    scene, sea = linear_scene(body, fit.model, waves, None, fit.added_mass_inf), together(waves)
    system = System.of(scene)
    motion, stride, _ = simulate(system, sea, Simulation(duration=300.0, window=(0.0, 300.0)), None)
    late = motion.time > 250.0
    expected = np.zeros((late.sum(), len(labels)))
    for direction, some in waves.items():
        phasors = some.amplitude[:, None] * replace(body, direction=direction).rao(some.omega, np.eye(len(labels)))
        expected += np.real(np.exp(-1j * np.outer(motion.time[late], some.omega)) @ phasors)
    missed = np.abs(motion.position[late] - expected).max(axis=0) / np.abs(expected).max(axis=0)
    assert missed.max() < 5e-3
    record = labelled(system, motion, sea, "body", "waves", stride)
    assert record.attrs["energy_residual"] < 1e-9
    lost = record.energy.isel(time=-1)
    assert float(lost.sel(term="pto")) > 0 < float(lost.sel(term="radiated"))


def with_one_channel(buoy):
    """The buoy with the damping of its database that of one channel alone."""
    damping = buoy.database.radiation_damping.copy(data=buoy.coefficients(buoy.database.omega.values).damping)
    return replace(buoy, database=buoy.database.assign(radiation_damping=damping))


def test_axisymmetric_and_general_formulations_agree(buoy_of, seed):
    """The database of an axisymmetric buoy, its single radiation channel not used."""
    buoy = with_one_channel(buoy_of(seed))
    omega, free = buoy.spectrum.omega[4:-4:7], np.eye(len(buoy.mass))
    dry = buoy.stiffness - buoy.stiffness_parts["hydrostatic"]
    body = linear_body(buoy.database, mass=buoy.mass, damping=buoy.structural_damping, stiffness=dry)
    loaded = replace(body, pto=replace(buoy.pto, port=free[0]))
    assert loaded.rao(omega, free) == pytest.approx(buoy.rao(omega, free), rel=1e-9)


def test_errors_stored_in_a_database(database):
    """By coarser panels and by the waves radiated, on straight lines between the frequencies."""
    body, rng, at = linear_body(database), np.random.default_rng(1), database.omega.values[2:4]
    matrix = rng.normal(size=(2, 80, 4, 4))
    errors = {
        "added_mass_error": (("error", "omega", *PAIR), matrix * np.array([1.0, 0.0])[:, None, None, None]),
        "radiation_damping_error": (("error", "omega", *PAIR), matrix),
        "excitation_force_error": (("error", "omega", "wave_direction", PAIR[0]), matrix[:, :, :2] + 0j),
        "hydrostatic_stiffness_error": (("error", *PAIR), matrix[:, 0]),
    }
    stored = body.database.assign(errors).assign_coords(error=["fewer panels", "waves radiated"])
    stored = stored.assign_attrs(quality=as_json([]))
    panels, waves = coefficient_errors(replace(body, database=stored), np.array([at.mean()]))
    assert (panels.name, waves.name) == (f"{RESOLVED} (fewer panels)", f"{RESOLVED} (waves radiated)")
    assert panels.signed
    assert panels.error.added_mass[0] == pytest.approx(matrix[0, 2:4].mean(axis=0))
    assert not waves.error.added_mass.any()
    assert waves.error.damping[0] == pytest.approx(matrix[1, 2:4].mean(axis=0))
    assert panels.stiffness == pytest.approx(matrix[0, 0])


def test_file_without_stated_error_gets_one_per_cent(database):
    body, stated = linear_body(database), Check("interpolation_error", 0.02, 0.05, "-", "ok", "")
    for checks, names in (([], [OF_OTHERS]), ([stated], [OF_OTHERS, INTERPOLATION])):
        read = replace(body, database=body.database.assign_attrs(quality=as_json(checks)))
        errors = coefficient_errors(read, np.array([1.0]))
        assert [error.name for error in errors] == names
        known = read.coefficients(np.array([1.0])).added_mass
        np.testing.assert_allclose(errors[0].error.added_mass, 0.01 * np.abs(known))


def test_added_mass_at_infinite_frequency_is_robust_to_outliers():
    """K(s) = s/(s^2 + s + 1): B = Re K(i omega), A = A(inf) + Im K(i omega)/omega."""
    omega = np.linspace(0.05, 20.0, 201)
    memory = 1j * omega / (1 - omega**2 + 1j * omega)
    added = 7.0 + memory.imag / omega
    added[[0, 60, -1]] += 1e4
    data = {"added_mass": added, "radiation_damping": memory.real}
    ds = xr.Dataset({name: (("omega", *PAIR), value[:, None, None]) for name, value in data.items()}, {"omega": omega})
    found = with_added_mass_inf(ds)
    assert found.added_mass_inf.dims == PAIR
    assert found.added_mass_inf.item() == pytest.approx(7.0, abs=1e-3)
    assert found.attrs["history"] == "added mass at infinite frequency from damping"


def floating_body(labels, mass, stiffness, direction=0.0, directions=(0.0,)):
    """A body that makes no waves, in waves whose force is the number of their direction, from one on."""
    omega, pair, dof = np.linspace(0.5, 4.0, 8), PAIR, len(labels)
    force = np.ones((8, len(directions), dof)) * (1.0 + np.arange(len(directions)))[:, None]
    ds = xr.Dataset(
        {name: (("omega", *pair), np.zeros((8, dof, dof))) for name in ("added_mass", "radiation_damping")}
        | {"added_mass_inf": (pair, np.zeros((dof, dof))), "hydrostatic_stiffness": (pair, np.diag(stiffness))}
        | {"excitation_force": (("omega", "wave_direction", pair[0]), force.astype(complex))},
        {"omega": omega, "wave_direction": list(directions)} | {dim: list(labels) for dim in pair},
    )
    none = np.zeros((dof, dof))
    return replace(linear_body(ds, mass=np.diag(mass), damping=none, stiffness=none), direction=direction)


@pytest.mark.parametrize(("turns", "degrees", "force"), [(0, 180.0, 2.0), (-2, 0.0, 1.0), (1, -90.0, 3.0)])
def test_wave_directions_are_periodic(turns, degrees, force):
    body = floating_body(("Heave",), [2.0], [3.0], np.deg2rad(degrees + 360.0 * turns), np.deg2rad([0.0, 180.0, 270.0]))
    assert body.coefficients(np.array([1.0, 2.0])).excitation == pytest.approx(np.full((2, 1), force))


def test_unstable_body_is_refused():
    bare = floating_body(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    capsizing = linear_body(bare.database, mass=bare.mass, damping=0 * bare.mass, stiffness=np.diag([0.0, -29.0]))
    message = r"^the body is statically unstable: received a negative stiffness of Pitch, growing by 2/s;"
    with pytest.raises(StabilityError, match=message):
        linear_scene(capsizing, None, {})


@pytest.mark.parametrize("place", ["database", "memory"])
def test_initial_heave_respects_constraints_with_all_inertia(place):
    """Wherever the common inertia stands: body, database or fitted memory."""
    labels = ("Surge", "Heave", "Pitch", "Bending")
    mass = np.array([[4.0, 0.3, 0.8, 0.0], [0.3, 5.0, 0.0, 0.7], [0.8, 0.0, 6.0, 0.0], [0.0, 0.7, 0.0, 2.0]])
    own, none = np.diag([1.0, 2.0, 3.0, 1.5]), np.zeros((4, 4))
    bare = floating_body(labels, np.ones(4), np.ones(4))
    inf = {"database": mass - own, "memory": 0.1 * np.eye(4)}[place]
    ds = bare.database.assign(added_mass_inf=(PAIR, inf))
    body = linear_body(ds, mass=own, damping=none, stiffness=none)
    model = RadiationModel(np.array([[-0.5]]), np.array([[1.0, 0.3, 0.0, 0.0]]), np.ones(1))
    held = ({"Heave": 1.0, "Pitch": -2.0},)
    fitted = (model, {}) if place == "memory" else (None, {})
    motions = body_motions("one", BodyDesign(held=held), labels)
    scene = linear_scene(body, *fitted, motions, mass - own if place == "memory" else None)
    position, velocity = (scene.motions @ y for y in scene.start(0.3, -0.6))
    assert position == pytest.approx([-0.8 / 4.0 * 0.15, 0.3, 0.15, 0.0], rel=1e-12, abs=1e-15)
    assert velocity == pytest.approx(-2 * position)
