"""A scene is its buoy: stiffness, damping and mass add up to the same, and what rests stays at rest."""

import itertools
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.motion.builders import (
    _loaded,
    _shell_springs,
    assumed_pressure_scene,
    body_exact_scene,
    linear_scene,
    still_scene,
)
from vsb.motion.forces import AssumedPressure, Damper, RelaxingDamper, Spring, SpringDamper
from vsb.motion.frequency import LinearBuoy
from vsb.motion.pto import LinearPto
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import mode_basis
from vsb.study.study import load
from vsb.waves.seas import NO_WAVES, Sea

SEA = Sea(np.array([1.5, 2.5]), np.array([0.05 + 0.02j, 0.03j]))
OMEGA = np.linspace(0.5, 6.0, 12)
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}}
PARTS = {"structural": "elastic", "hydrostatic": "hydrostatic", "prestress": "prestress", "gas": "gas"}


@pytest.fixture(scope="module")
def studies():
    """A vented shell about its sphere, one at its equilibrium full of gas under pressure; the shell of each at rest."""
    vented = varied(load(SEED), designs=DESIGNS, modes={"degree": 3}, device={"young_modulus": 3e7})
    gas = {"internal_pressure": 30e3, "gas": {"adiabatic_index": 1.4}}
    pressurised = varied(vented, reference_shape="equilibrium", device=gas)
    return {"vented": (vented, reference_shell(vented)), "pressurised": (pressurised, reference_shell(pressurised))}


def buoy_of(study, reference, parts=tuple(PARTS), *, structural=True, pto=8000.0, spring=0.0):
    """A buoy with the shell of a study and made-up coefficients, and its shape at rest."""
    dof, rng = len(reference.basis.labels), np.random.default_rng(4)
    root, pair = rng.normal(size=(dof, dof)), ("influenced_dof", "radiating_dof")
    push = 1e4 * (rng.normal(size=(len(OMEGA), 1, dof)) + 1j * rng.normal(size=(len(OMEGA), 1, dof)))
    steady = {"inertia_matrix": reference.basis.inertia, "added_mass_inf": 1e3 * (root @ root.T)}
    steady |= {f"{name}_stiffness": k for name, k in reference.stiffness.items() if name in parts}
    swept = {
        "added_mass": 2e3 * (root @ root.T) / (1 + OMEGA[:, None, None]),
        "radiation_damping": 1e3 * (root @ root.T),
    }
    forces = {"excitation_force": push, "diffraction_force": 0.4 * push, "Froude_Krylov_force": 0.6 * push}
    ds = xr.Dataset(
        {name: (pair, value) for name, value in steady.items()}
        | {name: (("omega", *pair), np.broadcast_to(v, (len(OMEGA), dof, dof))) for name, v in swept.items()}
        | {name: (("omega", "wave_direction", pair[0]), value) for name, value in forces.items()},
        coords={"omega": OMEGA, "influenced_dof": list(reference.basis.labels)},
        attrs={"water_density": study.water.density, "gravity": study.water.gravity, "water_depth": study.water.depth},
    )
    damping = reference.basis.damping if structural else 0 * reference.basis.damping
    return LinearBuoy(ds, damping, LinearPto(pto, spring)), reference.shape


def memory(dof):
    """A radiation memory of two states."""
    channel = np.array([1.0, 0.5])
    return RadiationModel(
        np.array([[0.0, 2.0], [-2.0, 0.0]]) - np.outer(channel, channel) / 2, np.ones((2, dof)), channel
    )


def scenes(study, buoy, shape, design, sea=NO_WAVES):
    """The linear and the body-exact scene of a design, as functions: not every buoy comes to rest."""
    motions = design_motions(study, shape.basis, design)
    radiation = memory(len(motions))
    return {
        "linear": lambda: linear_scene(buoy, radiation, sea, motions),
        "body_exact": lambda: body_exact_scene(buoy, shape, radiation, sea, motions),
    }


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("name", ["vented", "pressurised"])
@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_a_scene_has_all_the_stiffness_damping_and_mass_of_its_buoy(studies, name, model, design):
    """Of a rigid design that of heave: shell, prestress and gas do not feel it."""
    buoy, shape = buoy_of(*studies[name])
    assert set(buoy.stiffness_parts) == ({"structural", "hydrostatic"} if name == "vented" else set(PARTS))
    plant = scenes(studies[name][0], buoy, shape, design, SEA)[model]()
    n = plant.motions
    assert plant.stiffness == pytest.approx(n.T @ buoy.stiffness @ n, rel=1e-9, abs=1e-9 * np.abs(buoy.stiffness).max())
    assert plant.damping == pytest.approx(n.T @ buoy.damping @ n, rel=1e-12, abs=1e-12 * np.abs(buoy.damping).max())
    assert plant.mass == pytest.approx(buoy.mass + buoy.added_mass_inf, rel=1e-15)
    assert plant.memory.order == 2


@pytest.mark.parametrize(
    "kept", [c for n in range(4) for c in itertools.combinations(("structural", "prestress", "gas"), n)]
)
@pytest.mark.parametrize(("structural", "pto"), [(True, 0.0), (False, 8000.0)])
def test_a_linear_scene_has_the_forces_of_its_buoy_and_no_others(studies, kept, structural, pto):
    study, reference = studies["pressurised"]
    buoy, shape = buoy_of(study, reference, ("hydrostatic", *kept), structural=structural, pto=pto)
    plant = scenes(study, buoy, shape, "VSWEC", SEA)["linear"]()
    damped = {"structural_damping"} if structural else {"pto"}
    assert plant.forces.keys() == {PARTS[k] for k in kept} | {"hydrostatic", "radiation", "excitation"} | damped
    assert plant.stiffness == pytest.approx(plant.projected(buoy.stiffness_parts.values()), rel=1e-15)
    assert plant.damping == pytest.approx(plant.projected([buoy.damping]), rel=1e-15)
    for part in kept:
        assert plant.forces[PARTS[part]].stiffness == pytest.approx(buoy.stiffness_parts[part], rel=1e-15)


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("name", ["vented", "pressurised"])
def test_a_body_exact_scene_stays_where_it_rests_in_still_water(studies, name, design):
    """All named forces cancel there, weight and preload among them; a shell at its equilibrium rests where it is."""
    buoy, shape = buoy_of(*studies[name])
    plant = scenes(studies[name][0], buoy, shape, design)["body_exact"]()
    weight = 9.81 * studies[name][0].device.mass
    assert plant.forces["weight"].value[0] == pytest.approx(-weight, rel=1e-12)
    rest = (plant.motions @ plant.rest)[None]
    at_rest = plant.named(np.zeros(1), rest, np.zeros_like(rest))
    total = sum(at_rest.values()) @ plant.motions
    assert np.abs(total).max() < 1e-9 * weight
    assert at_rest["hydrostatic"][0, 0] == pytest.approx(weight, rel=1e-6)
    start, rate = plant.start(0.0, 0.0)
    assert not rate.any()
    assert np.abs(plant.motions @ start - rest).max() < 1e-9
    if name == "pressurised":
        assert np.abs(rest).max() < 1e-9


@pytest.mark.parametrize(
    ("design", "stiffness"), [*((design, 2e4) for design in DESIGNS), ("FSB", -1e4), ("VSWEC", -1e4)]
)
@pytest.mark.parametrize("name", ["vented", "pressurised"])
def test_a_spring_at_the_take_off_is_slack_where_the_buoy_rests_without_it(studies, name, design, stiffness):
    """There it neither pulls nor stores; a centimetre above it pulls down by its stiffness, in either scene."""
    study, reference = studies[name]
    found = []
    for spring in (0.0, stiffness):
        buoy, shape = buoy_of(study, reference, spring=spring)
        found.append(scenes(study, buoy, shape, design))
    (_, free), (linear, exact) = ([one[model]() for model in ("linear", "body_exact")] for one in found)
    assert exact.rest == pytest.approx(free.rest, abs=1e-12)
    assert exact.start(0.0, 0.0)[0] == pytest.approx(free.rest, abs=1e-12)
    assert exact.stiffness - free.stiffness == pytest.approx(
        stiffness * np.outer(*2 * [np.eye(len(free.rest))[0]]), abs=1e-3
    )
    for plant, rest in ((linear, 0.0 * free.rest), (exact, free.rest)):
        q = plant.motions @ rest + np.outer([0.0, 0.01], plant.motions[:, 0])
        assert plant.forces["pto"].force(np.zeros(2), q, 0 * q)[:, 0] == pytest.approx(
            [0.0, -0.01 * stiffness], abs=1e-6
        )
        assert plant.forces["pto"].stored(q) == pytest.approx([0.0, 0.5e-4 * stiffness], abs=1e-9)


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("name", ["vented", "pressurised"])
def test_in_still_water_a_buoy_rests_where_its_scene_in_waves_does(studies, name, design):
    """What water does to it in motion, and what takes power, change nothing there."""
    study, reference = studies[name]
    buoy, shape = buoy_of(study, reference)
    moving = scenes(study, buoy, shape, design, SEA)["body_exact"]()
    still = still_scene(reference, 1025.0, 9.81, moving.motions)
    assert still.origin == pytest.approx(moving.origin, abs=1e-12)
    assert still.stiffness == pytest.approx(moving.stiffness, rel=1e-9, abs=1e-3)
    assert still.mass == pytest.approx(reference.basis.inertia, rel=1e-15)


@pytest.mark.parametrize("sea", [SEA, Sea(SEA.omega[1:], SEA.amplitude[1:])], ids=["two", "one"])
@pytest.mark.parametrize("design", DESIGNS)
def test_waves_of_a_body_exact_scene_are_froude_krylov_and_diffraction(studies, design, sea):
    """To first order in the waves; linear theory has their sum as excitation."""
    study, reference = studies["vented"]
    buoy, shape = buoy_of(study, reference)
    linear, exact = (scenes(study, buoy, shape, design, sea)[name]() for name in ("linear", "body_exact"))
    expected = buoy.coefficients(sea.omega).excitation * sea.amplitude[:, None]
    assert linear.excitation.phasors == pytest.approx(expected, rel=1e-12)
    assert exact.excitation.phasors == pytest.approx(0.4 * expected, rel=1e-9)
    assert exact.water.waves.omega == pytest.approx(sea.omega)
    assert exact.water.waves.amplitude == pytest.approx(sea.amplitude)
    assert exact.water.waves.wavenumber == pytest.approx(sea.omega**2 / 9.81, rel=1e-12)
    assert exact.water.waves.radius == study.device.radius
    assert linear.excitation.omega == pytest.approx(sea.omega)
    assert exact.excitation.omega == pytest.approx(sea.omega)


@pytest.mark.parametrize("depth", [3.0, 30.0])
def test_waves_of_a_body_exact_scene_feel_the_bed(studies, depth):
    """w^2 = g k tanh(k h), of the database's own depth and gravity."""
    study, reference = studies["vented"]
    buoy, shape = buoy_of(study, reference)
    attrs = {"water_depth": depth, "gravity": 9.7, "water_density": 1010.0}
    shallow = replace(buoy, database=buoy.database.assign_attrs(attrs))
    plant = scenes(study, shallow, shape, "VSWEC", SEA)["body_exact"]()
    waves = plant.water.waves
    assert plant.water.specific_weight == pytest.approx(1010.0 * 9.7, rel=1e-15)
    assert plant.forces["weight"].value == pytest.approx(-9.7 * shape.basis.inertia[0], rel=1e-15)
    assert 9.7 * waves.wavenumber * np.tanh(waves.wavenumber * depth) == pytest.approx(SEA.omega**2, rel=1e-12)


@pytest.mark.parametrize("damped", [True, False])
@pytest.mark.parametrize("design", DESIGNS)
def test_a_scene_under_an_assumed_pressure_has_the_shell_the_water_and_the_damper(studies, design, damped):
    study, _ = studies["vented"]
    device = {"damping": {"alpha": 0.0, "beta": 1e-3 if damped else 0.0}}
    basis = study_basis(varied(study, device=device))
    shape = reference_shell(study, basis).shape
    motions = design_motions(study, basis, design)
    load_, pto = AssumedPressure(100.0, 2.0), LinearPto(8000.0 if damped else 0.0)
    plant = assumed_pressure_scene(shape, pto, load_, 1025.0, 9.81, motions)
    stiffness = basis.stiffness + shape.hydrostatic_stiffness(1025.0, 9.81)
    assert plant.stiffness == pytest.approx(plant.projected([stiffness]), rel=1e-12, abs=1e-6)
    assert plant.damping == pytest.approx(
        plant.projected([basis.damping, pto.matrix(len(motions))]), rel=1e-12, abs=1e-9
    )
    assert plant.mass == pytest.approx(basis.inertia, rel=1e-15)
    assert plant.forces["weight"].value == pytest.approx(-9.81 * basis.inertia[0], rel=1e-15)
    moving = {"elastic"} if design != "FSB" else set()
    lossy = {"pto", *({"structural_damping"} if design != "FSB" else set())} if damped else set()
    assert plant.forces.keys() == {"water", "weight"} | moving | lossy


def test_under_an_assumed_pressure_the_undeformed_shell_displaces_its_cap_and_is_pressed_on_its_waterplane(studies):
    """V = pi h^2 (3 r - h)/3 of the part h below water, and pi (r^2 - z^2) of the section at its surface."""
    study, _ = studies["vented"]
    shape, (r, z) = reference_shell(study).shape, (study.device.radius, study.centre_height)
    motions = design_motions(study, shape.basis, "VSWEC")
    plant = assumed_pressure_scene(shape, LinearPto(0.0), AssumedPressure(100.0, 2.0), 1000.0, 10.0, motions)
    rest = np.zeros((2, len(motions)))
    named = plant.named(np.array([0.0, np.pi / 2]), rest, rest)
    assert named["hydrostatic"][:, 0] == pytest.approx(2 * [1e4 * np.pi * (r - z) ** 2 * (2 * r + z) / 3], rel=1e-6)
    assert np.abs(named["excitation"][:, 0]) == pytest.approx(2 * [100 * np.pi * (r**2 - z**2)], rel=1e-6)
    assert named["excitation"][1] == pytest.approx(-named["excitation"][0], rel=1e-12)


@pytest.mark.parametrize(("modulus", "rests"), [(3e7, True), (6e4, False)])
def test_a_shell_that_its_static_load_collapses_has_no_scene_under_an_assumed_pressure(studies, modulus, rests):
    """A motion that begins undeformed would not tell."""
    study = varied(studies["vented"][0], device={"young_modulus": modulus})
    shape = reference_shell(study).shape
    with nullcontext() if rests else pytest.raises(ConvergenceError, match=r"rest: its shell gives way"):
        motions = design_motions(study, shape.basis, "VSWEC")
        assumed_pressure_scene(shape, LinearPto(0.0), AssumedPressure(100.0, 2.0), 1025.0, 9.81, motions)


@pytest.mark.parametrize(("spring", "damper"), [(0.0, 0.0), (0.0, 40.0), (30.0, 0.0), (30.0, 40.0), (-30.0, 40.0)])
@pytest.mark.parametrize("chamber", [0.0, 0.02])
def test_a_take_off_is_the_spring_and_the_damper_it_has_before_a_chamber_and_behind_one(
    studies, spring, damper, chamber
):
    """Behind a compliance C: k/(1 + k C) at rest, and a damper c/(1 + k C)^2 in series with C (1 + k C)."""
    study, reference = studies["vented"]
    buoy, shape = buoy_of(study, reference, pto=damper, spring=spring)
    b = np.linspace(0.5, 1.5, len(shape.basis.labels))
    buoy = replace(buoy, chamber=chamber, pto=replace(buoy.pto, port=b))
    plant = scenes(study, buoy, shape, "VSWEC")["linear"]()
    share = 1 + spring * chamber
    if not (spring or damper):
        assert "pto" not in plant.forces
        return
    force, along = plant.forces["pto"], np.outer(b, b)
    stiffness = plant.linear["pto"].stiffness
    assert (0 * along if stiffness is None else stiffness) == pytest.approx(spring / share * along, rel=1e-12)
    assert type(force) is (RelaxingDamper if chamber and damper else SpringDamper if spring else Damper)
    if chamber and damper:
        assert (force.damping, force.compliance) == pytest.approx((damper / share**2, chamber * share), rel=1e-12)
        assert force.direction == pytest.approx(b)
    else:
        damping = plant.linear["pto"].damping
        assert (0 * along if damping is None else damping) == pytest.approx(damper * along, rel=1e-12)


@pytest.mark.parametrize("model", ["linear", "body_exact"])
@pytest.mark.parametrize(("chamber", "damper"), [(0.0, 8000.0), (0.02, 40.0), (0.02, 0.0)])
def test_a_mooring_holds_beside_a_shell_and_whatever_the_take_off_stands_behind(studies, model, chamber, damper):
    study, reference = studies["pressurised"]
    buoy, shape = buoy_of(study, reference, pto=damper)
    dof = len(shape.basis.labels)
    mooring = 700.0 * np.outer(*2 * [np.linspace(1.0, 0.2, dof)])
    database = buoy.database.assign(mooring_stiffness=(("influenced_dof", "radiating_dof"), mooring))
    plant = scenes(study, replace(buoy, database=database, chamber=chamber), shape, "VSWEC")[model]()
    np.testing.assert_array_equal(plant.forces["mooring"].stiffness, mooring)
    assert plant.stiffness == pytest.approx(plant.projected([buoy.stiffness, mooring]), rel=1e-9, abs=1e-3)
    assert ("pto" in plant.forces) == bool(damper)
    assert "mooring" not in scenes(study, buoy, shape, "VSWEC")[model]().forces


@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_a_rigid_buoy_has_no_forces_of_a_shell(studies, model):
    """Its neighbour of the same shell has: elastic, of prestress and gas, and of structural damping."""
    study, reference = studies["pressurised"]
    buoy, shape = buoy_of(study, reference)
    rigid, elastic = (set(scenes(study, buoy, shape, design)[model]().forces) for design in ("FSB", "VSWEC"))
    common = {"radiation", "pto"} | ({"hydrostatic"} if model == "linear" else {"water", "weight"})
    assert rigid == common
    shell = {"elastic", "prestress", "gas", "structural_damping"} | ({"preload"} if model == "body_exact" else set())
    assert elastic == common | shell


def test_waves_are_known_as_far_as_the_shell_reaches_from_its_centre(studies):
    """Of a shell higher than wide half its height, of a wider one its radius."""
    for height, reach in ((5.0, 2.5), (2.0, 1.5)):
        device = {"radius": 1.5, "shape": {"spheroid": {"height": height}}, "mass": 1.1e3 * np.pi * height}
        study = varied(studies["vented"][0], designs={"FSB": {"flexible": False}}, device=device)
        buoy, shape = buoy_of(study, reference_shell(study))
        waves = scenes(study, buoy, shape, "FSB", SEA)["body_exact"]().water.waves
        assert waves.radius == pytest.approx(reach)
        np.testing.assert_allclose(waves.powers[:, 1], waves.wavenumber * reach, rtol=1e-12)


@pytest.mark.parametrize("design", DESIGNS)
def test_in_other_water_a_buoy_rests_where_that_carries_its_weight(studies, design):
    """By its own density and gravity: deeper in what is lighter."""
    study, reference = studies["vented"]
    motions = design_motions(study, reference.basis, design)
    depths = []
    for density, gravity in ((1025.0, 9.81), (900.0, 9.0), (900.0, 9.81)):
        still = still_scene(reference, density, gravity, motions)
        assert still.water.specific_weight == pytest.approx(density * gravity, rel=1e-15)
        assert still.forces["weight"].value == pytest.approx(-gravity * reference.basis.inertia[0], rel=1e-15)
        assert ("elastic" in still.forces) == study.designs[design].flexible
        rest = (motions @ still.rest)[None]
        pushed = sum(still.named(np.zeros(1), rest, 0 * rest).values())[0] @ motions
        assert np.abs(pushed).max() < 1e-9 * gravity * study.device.mass
        depths.append(rest[0, 0])
    assert depths[1] < depths[0] - 0.1
    assert depths[2] < depths[0] - 0.1


@pytest.mark.parametrize("design", DESIGNS)
def test_under_an_assumed_pressure_a_motion_starts_undeformed_and_strokes_count_from_where_the_buoy_rests(
    studies, design
):
    study, _ = studies["vented"]
    shape = reference_shell(study).shape
    motions = design_motions(study, shape.basis, design)
    plant = assumed_pressure_scene(shape, LinearPto(4.0), AssumedPressure(100.0, 2.0), 900.0, 9.0, motions)
    assert not plant.start(0.0, 0.0)[0].any()
    calm, rest = plant.raised(0.0), (motions @ plant.rest)[None]
    pushed = sum(calm.named(np.zeros(1), rest, 0 * rest).values())[0] @ motions
    assert np.abs(pushed).max() < 1e-9 * 9.0 * study.device.mass
    assert rest[0, 0] < -0.1
    np.testing.assert_array_equal(calm.rest, plant.rest)


def test_a_shell_has_the_springs_it_is_given_also_one_that_does_not_pull():
    """By their names in a run; dampers where there are any."""
    given = {"structural": np.eye(2), "hydrostatic": 3 * np.eye(2), "prestress": np.zeros((2, 2)), "gas": 5 * np.eye(2)}
    springs = _shell_springs(given, np.zeros((2, 2)))
    assert {name: spring.stiffness[0, 0] for name, spring in springs.items()} == {
        "elastic": 1.0,
        "prestress": 0.0,
        "gas": 5.0,
    }
    assert set(_shell_springs({"structural": np.eye(2)}, np.eye(2))) == {"elastic", "structural_damping"}


def test_what_a_prestressed_shell_carries_at_rest_is_all_of_water_and_weight(seed):
    """Also of modes with momentum along heave, as the publication's has: nothing moves from there."""
    basis = mode_basis(seed.device, "paper", 3)
    assert np.abs(basis.inertia[0, 1:]).max() > 1.0
    for amplitudes in (np.zeros(5), np.array([0.02, 0.01, -0.03, 0.02, 0.01])):
        shape = DeformedShell(basis, seed.centre_height, amplitudes)
        springs = {"prestress": Spring(np.eye(5))}
        forces = _loaded(springs, shape, np.eye(5), 900.0 * 9.0, 9.0, None)
        parts = [force.force(np.zeros(1), np.zeros((1, 5)), np.zeros((1, 5)))[0] for force in forces.values()]
        np.testing.assert_allclose(sum(parts), np.zeros(5), atol=1e-9 * np.abs(forces["weight"].value).max())
    assert "preload" not in _loaded({}, shape, np.eye(5), 900.0 * 9.0, 9.0, None)
