"""The take-off of a study in a scene: laws, limits, end stop, tuned dampers."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from conftest import only_run, varied

from benchmarks.hard_cases import hydro_files
from vsb.engine.integrators.simulate import legs
from vsb.engine.integrators.switching import Switching
from vsb.engine.motion.damper_matrix import best_matrix
from vsb.engine.motion.forces import Damper, EndStop, Excitation, Spring, TakeOff
from vsb.engine.motion.port import LinearPto, Port
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import LAWS, Pto
from vsb.engine.motion.tuning import frequencies, squares
from vsb.engine.waves.kinds import RegularWave
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import ConfigError
from vsb.models.build import SCENES
from vsb.models.floating_system import FloatingSystem, floating_system
from vsb.models.take_off import FORCES, end_stop, given_matrix, matrix_kind, tuned_take_off, with_take_off
from vsb.study.study import load

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


@pytest.mark.parametrize(
    "port",
    ["volume", {"colatitude": 90, "direction": "radial"}],
    ids=["volume", "point"],
)
def test_laws_act_on_ports_of_the_shell(seed, port, tmp_path_factory):
    damping = 400.0 if port == "volume" else 9000.0

    def followed(**pto):
        study = varied(
            seed,
            designs={"VSWEC": {}},
            modes={"degree": 2},
            hydro={"omega_max": 4.5, "tolerance": 1e-2},
            pto={"damping": damping, "port": port, **pto},
            waves=[{"kind": "regular", "amplitude": 0.1, "period": 5.0}],
            simulation={"duration": 15.0, "window": (5.0, 15.0), "initial_velocity": 0.0},
        )
        found = SCENES["linear"](only_run(study), hydro_files(study, tmp_path_factory.getbasetemp() / "latching"))
        (leg,) = legs(found.system, found.sea, study.simulation, None)
        ends = [one.end for one in legs(found.system, found.sea, study.simulation, None, longest=500)]
        assert len(ends) > 1  # a run in several legs ends in the same state
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
