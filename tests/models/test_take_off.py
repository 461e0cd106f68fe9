"""The take-off of a study in a scene: laws, limits, end stop, tuned dampers."""

import re
import sys
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from conftest import HERE, SMALL, only_run, run_at, varied

from benchmarks.hard_cases import hydro_files
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import legs, suited
from vsb.engine.integrators.switching import Switching
from vsb.engine.motion.forces import Damper, EndStop, Excitation, PortForce, Spring, TakeOff
from vsb.engine.motion.port import LinearPto, Port
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import LAWS, Pto
from vsb.engine.motion.tuning import best_matrix, frequencies, squares
from vsb.engine.waves.kinds import RegularWave
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.engine.waves.water import Water, wavenumber
from vsb.errors import ConfigError
from vsb.models.build import SCENES, TUNED, body_exact_design, design_in_sea, linear_design
from vsb.models.floating_system import FloatingSystem, floating_system
from vsb.models.take_off import (
    FORCES,
    LINEARISED,
    coefficients,
    end_stop,
    flow,
    given_matrix,
    matrix_kind,
    tuned_take_off,
    with_take_off,
)
from vsb.pipeline.graph import StudyPlan
from vsb.results.ladder import CAUSAL, SAME_FORCE, study_ladder
from vsb.stages.preview import check
from vsb.study.sections import Drag
from vsb.study.study import load, parse
from vsb.tools.files import load as load_file

DAMPER = LinearPto(4.0)
CONFIG = Path(__file__).parents[2] / "config"


@pytest.fixture
def plant():
    forces = {
        "hydrostatic": Spring(np.diag([50.0, 400.0])),
        "pto": Damper(np.diag([4.0, 0.0])),
        "excitation": Excitation(np.array([2.0]), np.array([[60.0 + 0j, 0.0]])),
    }
    return Scene(("Heave", "Membrane2"), np.array([[2.0, 0.3], [0.3, 1.0]]), forces, np.eye(2))


def piecewise_linear():
    """Laws whose force is a `TakeOff`, of damper and force limit; not the linear one, nor a controller, set in a sea."""
    known = [law for law in LAWS if set(LAWS[law].needs) <= {"force_limit"}]
    built = {law: FORCES[law](Pto(law=law, damping=4.0, force_limit=3.0), np.ones(1), 4.0, 0.0) for law in known}
    return [law for law, force in built.items() if isinstance(force, TakeOff) and law not in ("linear", "causal")]


@pytest.mark.parametrize("law", piecewise_linear())
def test_every_piecewise_linear_law_acts_on_heave_within_its_limit(plant, law):
    scene = with_take_off(plant, Pto(law=law, damping=4.0, force_limit=3.0), DAMPER)
    force = scene.forces["pto"]
    assert (force.latching_damping == 0.0) == (law == "declutching")
    assert force.direction.tolist() == [1.0, 0.0]
    assert "end_stop" not in scene.forces
    motion, _ = Switching(System.of(scene)).follow(np.linspace(0.0, 10.0, 501), (np.zeros(2), np.zeros(2)))
    assert np.abs(motion.forces["pto"]).max() == pytest.approx(3.0)


def test_end_stop_is_stiff_and_critically_damped(plant):
    scene = with_take_off(plant, Pto(damping=4.0, stroke_limit=0.2), DAMPER)
    stop, inverse = scene.forces["end_stop"], np.linalg.inv(plant.mass)[0, 0]
    assert isinstance(stop, EndStop)
    assert stop.stiffness == pytest.approx(100 * 50.0)
    assert stop.damping == pytest.approx(2 * np.sqrt(stop.stiffness / inverse))
    motion, _ = Switching(System.of(scene)).follow(np.linspace(0.0, 10.0, 501), (np.zeros(2), np.zeros(2)))
    given_way = np.abs(motion.position[:, 0]).max() - 0.2
    lossless = np.abs(motion.velocity[:, 0]).max() / np.sqrt(stop.stiffness * inverse)  # V sqrt(m/k)
    assert 0.2 * lossless < given_way < 0.6 * lossless  # 1/e of it where damping is critical, the waves' push besides


def test_end_stop_needs_a_restrained_port(plant):
    unrestrained = replace(plant, forces=plant.forces | {"hydrostatic": Spring(np.diag([0.0, 400.0]))})
    with pytest.raises(
        ConfigError, match=r"pto.stroke_limit: nothing holds this port at rest, so that no stroke counts"
    ):
        end_stop(unrestrained, np.array([1.0, 0.0]), 0.2)
    moored = replace(unrestrained, forces=unrestrained.forces | {"mooring": Spring(np.diag([7.0, 0.0]))})
    assert end_stop(moored, np.array([1.0, 0.0]), 0.2).stiffness == pytest.approx(100 * 7.0)
    assert end_stop(unrestrained, np.array([0.0, 1.0]), 0.2).stiffness == pytest.approx(100 * 400.0)


# springs and tuned dampers -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class OnePort:
    """Stands for a linear buoy: its port is an oscillator, whatever the direction."""

    direction: float = 0.0

    def port(self, omega, motions, direction):
        y = 1 / (-1j * omega * 2.0 + 0.7 + 5j / omega)
        return Port(omega, y, y * (1 + 0.2j), 1 / 5.0)


def tuned(seas, **keys):
    waves = RegularWave(kind="regular", amplitude=1.0, period=1.0)  # where they go is all that is asked of it
    floating = FloatingSystem(OnePort(), {"A": np.eye(1)}, np.ones(1))
    return tuned_take_off(Pto(**keys), "A", floating, [(waves, sea) for sea in seas])


def regular(omega, amplitude=1.0):
    return Sea(np.array([omega]), np.array([amplitude + 0j]))


def test_tuned_damper_of_a_regular_wave_is_the_impedance():
    """|Z|, with a spring |Z + i k/omega|; a given damper stays."""
    for omega, k in ((0.7, 0.0), (2.0, 3.0), (2.0, -4.0)):
        z = 1 / OnePort().port(np.array([omega]), None, None).admittance[0] + 1j * k / omega
        found = tuned([regular(omega)], stiffness=k)
        assert found.damping == pytest.approx(abs(z), rel=1e-6)
        assert found.stiffness == k
    assert tuned([], damping={"A": 3.0, "B": 4.0}).damping == 3.0


def test_common_damper_maximises_the_sum_over_seas():
    shared = np.array([0.7, 2.5])
    seas = [regular(0.7), Sea(shared, np.array([0.6, 0.4])), Sea(shared, np.array([0.1, 0.5j]))]
    omega = frequencies(seas)
    port, dampers = OnePort().port(omega, None, None), np.geomspace(0.1, 50.0, 20001)
    power = port.power(dampers) @ squares(seas, omega).sum(axis=0)
    assert tuned([*seas, NO_WAVES], tuning="one").damping == pytest.approx(dampers[np.argmax(power)], rel=1e-3)


def test_tuning_needs_waves():
    with pytest.raises(
        ConfigError, match=r"pto.tuning: received 'each', needs at least one sea with waves, or pto.damping"
    ):
        tuned([NO_WAVES])


def test_take_off_on_an_immobile_port_has_no_effect(plant):
    still = LinearPto(4.0, port=np.array([0.0, 1.0]))
    rigid = replace(plant, motions=np.eye(2, 1))
    assert with_take_off(rigid, Pto(damping=4.0, force_limit=3.0, stroke_limit=0.1), still) is rigid


# a shell's own ports -------------------------------------------------------------------------------------------------


def test_laws_act_on_ports_of_the_shell(seed, tmp_path_factory):
    port = {"colatitude": 90, "direction": "radial"}

    def followed(**pto):
        study = varied(
            seed,
            designs={"VSWEC": {}},
            modes={"degree": 2},
            hydro={"omega_max": 4.5, "tolerance": 1e-2},
            pto={"damping": 9000.0, "port": port, **pto},
            waves=[{"kind": "regular", "amplitude": 0.1, "period": 5.0}],
            simulation={"duration": 15.0, "window": (5.0, 15.0), "initial_velocity": 0.0},
        )
        found = SCENES["linear"](only_run(study), hydro_files(study, tmp_path_factory.getbasetemp() / "latching"))
        (leg,) = legs(found.system, found.sea, study.simulation, None)
        if "stroke_limit" in pto:  # a run in several legs ends in the same state
            ends = [one.end for one in legs(found.system, found.sea, study.simulation, None, longest=500)]
            assert len(ends) > 1
            np.testing.assert_allclose(ends[-1][0], leg.end[0], atol=1e-5 * np.abs(leg.motion.position).max())
        assert leg.balance.residual < 1e-6
        b = found.scene.forces["pto"].direction
        force = found.system.forces(leg.motion)["pto"] @ b / (b @ b)
        methods.append(leg.method)
        return np.abs(leg.motion.position @ b).max(), np.abs(force).max()

    methods: list[str] = []
    stroke, force = followed(law="saturated", force_limit=1e9)
    near = followed(law="saturated", force_limit=1.01 * force, stroke_limit=1.01 * stroke)
    assert near == (pytest.approx(stroke, rel=1e-4), pytest.approx(force, rel=0.01))  # of instants twice as dense
    assert methods == ["exact propagation", "exact propagation between switches"]  # far from limits nothing switches
    assert followed(law="saturated", force_limit=0.5 * force)[1] == pytest.approx(0.5 * force)
    assert followed(law="coulomb", force_limit=0.5 * force)[1] == pytest.approx(0.5 * force)
    assert followed(stroke_limit=0.5 * stroke)[0] < 0.6 * stroke


def followed(model, folder, **pto):
    """An inflated shell with a take-off in a small wave: study, its files, its design, the run and its mean power."""
    study = varied(
        load(CONFIG / "pressurised.yaml"),
        designs={"VSWEC": {}},
        modes={"degree": 2},
        hydro={"omega_max": 4.5, "model": model},
        pto=pto,
        waves=[{"kind": "regular", "amplitude": 0.01, "period": 3.0}],
        simulation={"duration": 60.0, "window": (48.0, 60.0), "initial_velocity": 0.0, "tolerance": 1e-9},
    )
    files = hydro_files(study, folder / "wet")
    found = SCENES[model](only_run(study), files)
    (leg,) = legs(found.system, found.sea, study.simulation, None)
    assert leg.balance.residual < 1e-6
    start, end = np.interp([48.0, 60.0], leg.motion.time, leg.energy["pto"])
    return study, files, found, leg, (end - start) / 12.0


HELD = [None, {"place": "heave"}, {"place": "ring", "colatitude": 110}]


@pytest.mark.parametrize("model", ["linear", pytest.param("body_exact", marks=pytest.mark.slow)])
@pytest.mark.parametrize("held", HELD, ids=["free", "heave", "ring"])
def test_power_from_strain_in_time_is_that_of_the_port(held, model, tmp_path_factory):
    """A damper on the change of area, what the mooring holds stays; at finite amplitude along the gradient at rest."""
    port = {"strain": "area"}
    study, files, found, leg, mean = followed(model, tmp_path_factory.getbasetemp(), damping=2e3, port=port, held=held)
    moved = leg.motion.position @ found.scene.motions.T
    np.testing.assert_allclose(moved @ found.held.T, 0.0, atol=1e-12)
    assert len(found.held) == (held is not None)
    seen = floating_system(study, files["database"]).ports(np.array([2 * np.pi / 3.0]))["VSWEC"]
    assert mean == pytest.approx(0.01**2 * seen.power(2e3)[0], rel=5e-3 if model == "linear" else 1e-2)


@pytest.mark.parametrize("model", ["linear", pytest.param("body_exact", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "pto",
    [
        {"ports": {"heave": "heave", "shell": {"strain": "area"}}, "damping": [[5e4, -2e3], [-2e3, 4e3]]},
        {"ports": {"heave": "heave", "shell": {"strain": "area"}}, "damping": None},
        {"port": {"distributed": "membrane"}, "damping": 0.3},
    ],
    ids=["given", "tuned", "spread"],
)
def test_damper_matrix_in_time_absorbs_what_it_does_in_frequency(pto, model, tmp_path_factory):
    study, files, _, _, mean = followed(model, tmp_path_factory.getbasetemp(), **{"damping": None, **pto})
    seen = floating_system(study, files["database"]).several_ports(np.array([2 * np.pi / 3.0]))["VSWEC"]
    kind = matrix_kind(study.pto)
    given = given_matrix(study.pto, "VSWEC", seen.velocity.shape[1])
    power = best_matrix(seen, np.ones(1), kind).power if given is None else seen.power(given)[0]
    assert mean == pytest.approx(0.01**2 * power, rel=5e-3 if model == "linear" else 2e-2)


@pytest.mark.parametrize("law", ["linear", "saturated", "coulomb"])
def test_springs_and_strokes_are_relative_to_the_equilibrium(plant, law):
    b, motions, rest = np.array([1.0, -0.5]), np.array([[1.0, 0.0], [0.0, 2.0]]), np.array([0.3, -0.7])
    held = np.array([[50.0, 90.0], [90.0, 400.0]])
    forces = plant.forces | {"hydrostatic": Spring(held)}
    resting = replace(plant, forces=forces, motions=motions, origin=rest)
    pto = Pto(law=law, damping=4.0, stiffness=6.0 if law != "coulomb" else 0.0, force_limit=3.0, stroke_limit=0.2)
    scene = with_take_off(resting, pto, LinearPto(4.0, 6.0, b))
    force, stop = scene.law, scene.stop
    assert force.rest == stop.rest == pytest.approx(0.3 - 0.5 * 2 * -0.7)
    assert (force.limit, stop.stroke) == (3.0, 0.2)
    assert (force.damping, force.stiffness) == ((np.inf, 0.0) if law == "coulomb" else (4.0, 6.0))
    for one in (force, stop):
        np.testing.assert_array_equal(one.direction, b)
    pushed = np.linalg.solve(motions.T @ plant.mass @ motions, motions.T @ b) @ (motions.T @ b)
    yields = b @ np.linalg.solve(held, b)
    assert stop.stiffness == pytest.approx(100.0 / yields, rel=1e-12)
    assert stop.damping == pytest.approx(2 * np.sqrt(stop.stiffness / pushed), rel=1e-12)


WAVE = {"kind": "regular", "amplitude": 0.5, "period": 4.0}
PLATE = {"heave": {"coefficient": 1.0, "area": 12.57}}


def study_of(small, design="VSWEC", drag=PLATE, wave=WAVE, **sections):
    """The small study with one design, one wave and drag."""
    data = small.study.model_dump()
    data |= {"designs": {design: data["designs"][design]}, "waves": [wave], **({"drag": drag} if drag else {})}
    return varied(parse(data), **sections)


def run_of(study):
    """The specification of the run of a study of one design in one wave."""
    (design,), (wave,) = study.designs, study.waves
    return StudyPlan(study).simulation(design, wave).spec["run"]


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_quadratic_drag_agrees_with_its_equivalent_damper(small, design):
    """Harmonic balance against equivalent linearisation; drag is a tenth of all damping here."""
    at = linear_design(run_of(study_of(small, design)), small.hydro_files)
    found = harmonic_balance(at.system)
    assert at.notes[LINEARISED] == pytest.approx(found.power.pto, rel=2e-3)
    free = linear_design(run_of(study_of(small, design, drag=None)), small.hydro_files)
    assert LINEARISED not in free.notes
    assert harmonic_balance(free.system).power.pto > 1.01 * found.power.pto
    assert suited(at.system) == "collocation"
    assert suited(free.system) == "exact"


def test_tuned_damper_is_optimal_beside_drag(small):
    """By linear theory and in the steady state."""

    def taken(damping):
        return linear_design(run_of(study_of(small, pto={"damping": damping, "tuning": "fixed"})), small.hydro_files)

    best = linear_design(run_of(study_of(small, pto={"tuning": "each"})), small.hydro_files)
    for factor in (0.8, 1.25):
        assert taken(best.notes[TUNED] * factor).notes[LINEARISED] < best.notes[LINEARISED]
        assert harmonic_balance(taken(best.notes[TUNED] * factor).system).power.pto < (
            harmonic_balance(best.system).power.pto
        )


def test_drag_force_in_still_water(small):
    at = linear_design(run_of(study_of(small, wave={"kind": "still"})), small.hydro_files)
    assert at.notes == {"model": "linear"}
    assert at.scene.forces["drag"].force(np.zeros(1), np.zeros((1, 4)), np.array([[2.0, 0.0, 0.0, 0.0]]))[0] == (
        pytest.approx([-0.5 * 1025.0 * 1.0 * 12.57 * 4.0, 0.0, 0.0, 0.0])  # rho C A |v| v/2
    )


def test_drag_in_a_body_exact_scene(small):
    study = study_of(small, "FSB", wave={**WAVE, "amplitude": 0.02}, hydro={"model": "body_exact"})
    at = body_exact_design(run_of(study), small.hydro_files)
    linear = linear_design(run_of(varied(study, hydro={"model": "linear"})), small.hydro_files)
    assert suited(at.system) == "collocation"
    assert at.notes[LINEARISED] == linear.notes[LINEARISED]
    assert harmonic_balance(at.system).power.pto == pytest.approx(harmonic_balance(linear.system).power.pto, rel=1e-3)


def test_control_levels_are_ordered_beside_drag(small):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "gamma": 3.3, "seed": 1}
    data = small.study.model_dump() | {"waves": [WAVE, sea], "designs": {"VSWEC": {}}}
    free, dragged = (
        study_ladder(StudyPlan(parse(data | extra)).ladder.spec["study"], small.database.out)
        for extra in ({}, {"drag": PLATE})
    )
    of_linear_water = (SAME_FORCE, CAUSAL)  # beside drag a row says why it has no power
    free, dragged = ([r for r in some if r.rung not in of_linear_water] for some in (free, dragged))
    for before, after in zip(free, dragged, strict=True):
        assert before[:3] == after[:3]
        lost = 1 - after.power_mean / before.power_mean
        assert lost == 0 if after.rung == "matched" else 1e-3 < lost < 0.7
    power = {(r.wave, r.rung): r.power_mean for r in dragged}
    for wave in {r.wave for r in dragged}:
        fixed, common, best, pair = (
            power[wave, level] for level in ("fixed", "best_damper_all_seas", "best_damper", "best_spring_damper")
        )
        assert max(fixed, common) <= best * (1 + 1e-9)
        assert best <= pair * (1 + 1e-9)
    fixed = next(r for r in dragged if r.rung == "fixed")
    run = linear_design(run_of(study_of(small)), small.hydro_files)
    assert fixed.power_mean == pytest.approx(run.notes[LINEARISED], rel=1e-9)
    assert fixed.force_peak == pytest.approx(8000.0 * fixed.stroke_peak * 2 * np.pi / 4.0, rel=1e-9)


@pytest.mark.parametrize(("coefficient", "area"), [(0.5, 12.57), (2.0, 3.0)])
def test_drag_coefficients(coefficient, area):
    """rho C A |u| u/2; on a rotation the lever enters cubed."""
    plate = {"coefficient": coefficient, "area": area}
    drag = Drag(heave=plate, surge=plate, pitch={**plate, "lever": 2.0})
    found = coefficients(drag.plates.values(), 1025.0)
    assert found == pytest.approx(512.5 * coefficient * area * np.array([1.0, 1.0, 8.0]), rel=1e-14)


@pytest.mark.parametrize("towards", [0.0, 30.0, 120.0, -90.0])
def test_wave_velocity_at_finite_depth(towards):
    """w cosh k(z + d)/sinh kd along the wave, -i w sinh k(z + d)/sinh kd upwards, no rotation."""
    plate, vane = {"coefficient": 1.0, "area": 1.0}, {"coefficient": 1.0, "area": 1.0, "lever": 2.0}
    drag = Drag(surge=plate, sway=plate, heave=plate, roll=vane, pitch=vane, yaw=vane)
    run = SimpleNamespace(KIND="buoy", plates=drag.plates, water=Water(depth=10.0, gravity=9.6), draft=3.0)
    omega = np.array([0.7, 1.9])
    k = np.array([wavenumber(w, 10.0, 9.6) for w in omega])
    along = omega * np.cosh(k * 8.5) / np.sinh(k * 10.0)
    expected = np.zeros((2, 6), dtype=complex)
    expected[:, 0], expected[:, 1] = np.cos(np.deg2rad(towards)) * along, np.sin(np.deg2rad(towards)) * along
    expected[:, 2] = -1j * omega * np.sinh(k * 8.5) / np.sinh(k * 10.0)
    np.testing.assert_allclose(flow(run, omega, towards), expected, rtol=1e-10, atol=1e-15)


PAGE = (
    (HERE.parent / "docs" / "extending.md")
    .read_text(encoding="utf-8")
    .split("## A take-off law of your own package\n")[1]
)


def block(language):
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.S)[1]


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Function version, code -> the package of the documentation as pip would leave it in a folder of packages."""
    monkeypatch.syspath_prepend(tmp_path)

    def installed(version="1.0", code=None):
        project = tomllib.loads(block("toml"))["project"]
        (tmp_path / "my_take_off.py").write_text(code or block("python"))
        sys.modules.pop("my_take_off", None)
        info = tmp_path / "my_take_off.dist-info"
        info.mkdir(exist_ok=True)
        info.joinpath("METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {version}\n")
        entries = project["entry-points"]["vsb.take_off_laws"]
        lines = "".join(f"{name} = {value}\n" for name, value in entries.items())
        info.joinpath("entry_points.txt").write_text(f"[vsb.take_off_laws]\n{lines}")

    yield installed
    sys.modules.pop("my_take_off", None)


def study(model="linear", **pto):
    raw = SMALL | {"pto": yaml.safe_load(block("yaml"))["pto"] | pto, "designs": {"FSB": {"flexible": False}}}
    return parse(raw | {"hydro": SMALL["hydro"] | {"model": model}})


def test_name_version_and_parameters_go_into_the_id(install):
    install("1.0")
    first = study()
    install("1.1")
    second, other = study(), study(parameters={"coefficient": 1.0, "exponent": 2.0, "ramp": 5.0})
    ids = {StudyPlan(one).simulation("FSB", one.waves[0]).id for one in (first, second, other)}
    assert len(ids) == 3
    assert (first.pto.distribution, second.pto.distribution) == ("my-take-off 1.0", "my-take-off 1.1")
    assert parse(first.model_dump()).pto == first.pto  # results of before are still read
    with pytest.raises(
        ConfigError, match=r"received my_take_off:law of my-take-off 1.1, needs that of my-take-off 1.0"
    ):
        check(StudyPlan(first))


@pytest.mark.parametrize("model", ["linear", pytest.param("body_exact", marks=pytest.mark.slow)])
def test_work_of_the_law_is_the_absorbed_power(model, install, small, tmp_path):
    install()
    one = study(model)
    check(StudyPlan(one))
    task = StudyPlan(one).simulation(*one.designs, one.waves[0])
    run_at(task, out=str(tmp_path / "run.nc"), **small.hydro_files)
    run = load_file(tmp_path / "run.nc")
    velocity, parameters = run.velocity.sel(dof="Heave").values, one.pto.parameters
    law = -parameters["coefficient"] * np.abs(velocity) ** 1.5 * np.sign(velocity) * np.clip(run.time / 5.0, 0, 1)
    assert run.pto.sel(dof="Heave").values == pytest.approx(law.values, rel=1e-9)
    assert run.attrs["energy_residual"] < 1e-5
    work = float(-np.trapezoid(law * velocity, run.time))
    assert float(run.energy.sel(term="pto")[-1]) == pytest.approx(work, rel=1e-4)
    assert "time" in run.attrs["no_steady_state"]


def test_linear_law_is_a_damper(install, small):
    """The steady state of a package's -c v is that of pto.damping."""
    install(code="def law(position, velocity, time, parameters):\n    return -parameters['c'] * velocity\n")
    own = design_in_sea(only_run(study(parameters={"c": 8000.0})), dict(small.hydro_files))
    known = varied(small.study, designs={"FSB": {"flexible": False}}, pto={"damping": 8000.0})
    damped = design_in_sea(only_run(known), dict(small.hydro_files))
    expected = harmonic_balance(damped.system, 1e-8).power.pto
    assert isinstance(own.scene.forces["pto"], PortForce)
    assert harmonic_balance(own.system, 1e-8).power.pto == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import no_such_module", r"my_take_off:law of my-take-off 1.0 cannot be imported \(No module named"),
        ("def law(s, v, t, p):\n    return v / 0.0 * t", r"received NaN or infinite values of my_take_off:law"),
        ("def law(s, v, t, p):\n    return 1.0", r"received shape \(\) of .*, needs a finite force .* shape \(3,\)"),
        ("def law(s, v, t, p):\n    return p['k'] * s", r"my_take_off:law of my-take-off 1.0 raised KeyError: 'k'"),
        ("def law(s, v):\n    return -v", r"raised TypeError"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero")
def test_laws_that_give_no_force_are_refused_before_a_run(code, message, install):
    install(code=code)
    one = study()
    with pytest.raises(ConfigError, match=message):
        check(StudyPlan(one))


@pytest.mark.parametrize(
    ("pto", "message"),
    [
        (
            {"law": "other:law"},
            r"law 'other:law': no installed package declares it; needs an entry point .*my_take_off:law",
        ),
        ({"law": "my_takeoff:lw"}, "did you mean my_take_off:law?"),
        ({"law": "my_take_off:law", "force_limit": 10.0}, "is the whole force; needs no force_limit"),
        ({"law": "coulomb", "force_limit": 10.0, "parameters": {"c": 1.0}}, "parameters: are of a law of a package"),
        ({"law": "a:b:c"}, "law 'a:b:c': no installed package declares it"),
    ],
)
def test_what_is_no_law_is_refused(pto, message, install):
    install()
    with pytest.raises(ConfigError, match=message):
        Pto(**pto)
