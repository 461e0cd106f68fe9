"""The take-off of a study in a scene: its law, its limits, its end stop."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from conftest import only_run, varied

from benchmarks.hard_cases import hydro_files
from vsb.errors import ConfigError
from vsb.integrators.simulate import legs
from vsb.integrators.switching import switched
from vsb.motion import drag
from vsb.motion.forces import Damper, Excitation, Spring, SpringDamper
from vsb.motion.port import Port, port_direction
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import EndStop, TakeOff
from vsb.motion.tuning import best_dampers, frequencies, squares
from vsb.scenes.afloat import Afloat
from vsb.scenes.build import SCENES
from vsb.scenes.pause import BestPause
from vsb.scenes.rest import check_spring, reference_shell
from vsb.scenes.take_off import LAWS, end_stop, tuned_take_off, with_take_off
from vsb.study.study import load
from vsb.study.take_off import Pto
from vsb.study.waves import RegularWave
from vsb.waves.seas import NO_WAVES, Sea

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


def test_a_tuned_take_off_leaves_the_scene_as_it_is(plant):
    assert with_take_off(plant, Pto(damping=4.0), DAMPER) is plant


@pytest.mark.parametrize("law", [law for law in LAWS if law != "linear"])
def test_every_law_acts_on_heave_within_its_limit(plant, law):
    scene = with_take_off(plant, Pto(law=law, damping=4.0, force_limit=3.0), DAMPER)
    force = scene.forces["pto"]
    assert isinstance(force, TakeOff)
    assert (force.paused_damping == 0.0) == (law == "declutching")
    assert force.direction.tolist() == [1.0, 0.0]
    assert "end_stop" not in scene.forces
    motion, _ = switched(System.of(scene), np.linspace(0.0, 10.0, 501), (np.zeros(2), np.zeros(2)))
    assert np.abs(motion.forces["pto"]).max() == pytest.approx(3.0)


def test_the_end_stop_is_stiff_and_critically_damped_with_what_moves(plant):
    scene = with_take_off(plant, Pto(damping=4.0, stroke_limit=0.2), DAMPER)
    stop, inverse = scene.forces["end_stop"], np.linalg.inv(plant.mass)[0, 0]
    assert isinstance(stop, EndStop)
    assert stop.stiffness == pytest.approx(100 * 50.0)
    assert stop.damping == pytest.approx(2 * np.sqrt(stop.stiffness / inverse))
    motion, _ = switched(System.of(scene), np.linspace(0.0, 10.0, 501), (np.zeros(2), np.zeros(2)))
    given_way = np.abs(motion.position[:, 0]).max() - 0.2
    lossless = np.abs(motion.velocity[:, 0]).max() / np.sqrt(stop.stiffness * inverse)  # V sqrt(m/k)
    assert 0.2 * lossless < given_way < 0.6 * lossless  # 1/e of it where damping is critical, the waves' push besides


def test_an_end_stop_where_nothing_holds_the_port_is_refused(plant):
    """A spring beside it would; the port of a motion that is held elsewhere does not drift."""
    adrift = replace(plant, forces=plant.forces | {"hydrostatic": Spring(np.diag([0.0, 400.0]))})
    with pytest.raises(
        ConfigError, match=r"pto.stroke_limit: nothing holds this port at rest, so that no stroke counts"
    ):
        end_stop(adrift, np.array([1.0, 0.0]), 0.2)
    moored = replace(adrift, forces=adrift.forces | {"mooring": Spring(np.diag([7.0, 0.0]))})
    assert end_stop(moored, np.array([1.0, 0.0]), 0.2).stiffness == pytest.approx(100 * 7.0)
    assert end_stop(adrift, np.array([0.0, 1.0]), 0.2).stiffness == pytest.approx(100 * 400.0)


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
    floating = Afloat(OnePort(), {"A": np.eye(1)}, np.ones(1))
    return tuned_take_off(Pto(**keys), "A", floating, [(waves, sea) for sea in seas])


def regular(omega, amplitude=1.0):
    return Sea(np.array([omega]), np.array([amplitude + 0j]))


def test_the_damper_of_a_regular_wave_is_the_size_of_the_impedance_it_sees():
    """|Z|, with a spring beside it |Z + i k/omega|; a damper that is given stays."""
    for omega, k in ((0.7, 0.0), (2.0, 3.0), (2.0, -4.0)):
        z = 1 / OnePort().port(np.array([omega]), None, None).admittance[0] + 1j * k / omega
        found = tuned([regular(omega)], stiffness=k)
        assert found.damping == pytest.approx(abs(z), rel=1e-6)
        assert found.stiffness == k
    assert tuned([], damping={"A": 3.0, "B": 4.0}).damping == 3.0


@pytest.mark.parametrize("tuning", ["each", "one"])
def test_a_tuned_take_off_asks_for_no_damping_that_is_given(tuning):
    """Only a fixed one has it."""
    seas = [regular(2.0), regular(0.7, 0.5)]
    free = tuned(seas, tuning=tuning)
    assert free.damping != pytest.approx(77.0, rel=1e-3)
    assert tuned(seas, tuning=tuning, damping=77.0).damping == free.damping
    assert tuned(seas, tuning="fixed", damping=77.0).damping == 77.0


def test_the_damper_of_a_sea_knows_no_other_sea():
    """What a run finds alone is what the ladder finds among all seas."""
    seas = [Sea(np.array([0.8, 1.1]), np.array([1.0, 0.5j])), regular(2.5), regular(0.3)]
    omega = frequencies(seas)
    together = best_dampers(OnePort().port(omega, None, None), squares(seas, omega)).damping
    for waves, damper in zip(seas, together, strict=True):
        assert tuned([waves]).damping == pytest.approx(damper, rel=1e-9)


def test_one_damper_suits_the_sum_of_all_seas():
    shared = np.array([0.7, 2.5])
    seas = [regular(0.7), Sea(shared, np.array([0.6, 0.4])), Sea(shared, np.array([0.1, 0.5j]))]
    omega = frequencies(seas)
    port, dampers = OnePort().port(omega, None, None), np.geomspace(0.1, 50.0, 20001)
    power = port.power(dampers) @ squares(seas, omega).sum(axis=0)
    assert tuned([*seas, NO_WAVES], tuning="one").damping == pytest.approx(dampers[np.argmax(power)], rel=1e-3)


def test_where_nothing_comes_in_there_is_no_best_damper():
    with pytest.raises(ConfigError, match=r"pto.tuning: received 'each', but nothing comes in; needs pto.damping"):
        tuned([NO_WAVES])


def test_a_take_off_on_what_does_not_move_leaves_the_scene_as_it_is(plant):
    still = LinearPto(4.0, port=np.array([0.0, 1.0]))
    rigid = replace(plant, motions=np.eye(2, 1))
    assert with_take_off(rigid, Pto(damping=4.0, force_limit=3.0, stroke_limit=0.1), still) is rigid


def test_a_spring_pulls_back_to_where_it_is_slack_and_stores_what_it_takes():
    k, c, q0 = np.diag([3.0, 0.0]), np.diag([2.0, 0.0]), np.array([0.5, 0.0])
    force = SpringDamper(k, c, q0)
    q, v = np.array([[0.7, 1.0], [0.5, 0.0]]), np.array([[1.0, 1.0], [0.0, 0.0]])
    assert force.force(np.arange(2.0), q, v) == pytest.approx(np.array([[-3.0 * 0.2 - 2.0, 0.0], [0.0, 0.0]]))
    assert force.stored(q) == pytest.approx([0.5 * 3.0 * 0.04, 0.0])
    assert not force.linear().whole
    assert replace(force, rest=0 * q0).linear().whole
    scene = Scene(("Heave", "Membrane2"), np.eye(2), {"pto": force}, np.eye(2))
    assert scene.constant == pytest.approx([1.5, 0.0])


def test_a_spring_that_pushes_a_buoy_out_of_its_rest_is_refused(seed):
    """The border is that of heave: minus the waterplane's stiffness of a rigid buoy."""
    rigid = varied(seed, designs={"FSB": {"flexible": False}}, pto={"stiffness": -1e3})
    reference = reference_shell(rigid)
    border = float(reference.total[0, 0])
    check_spring(varied(rigid, pto={"stiffness": -0.999 * border}), reference)
    with pytest.raises(
        ConfigError, match=rf"pto.stiffness: received -.* N/m, with which .* more than -{border:.6g} N/m"
    ):
        check_spring(varied(rigid, pto={"stiffness": -1.001 * border}), reference)


def test_a_design_that_does_not_move_the_port_bounds_no_spring(seed):
    """A rigid buoy beside the shell: the border is the shell's own."""
    both = varied(seed, modes={"degree": 2}, designs={"FSB": {"flexible": False}, "VSWEC": {}})
    own = varied(seed, modes={"degree": 2}, designs={"VSWEC": {}})
    port, reference, borders = {"between": [0, 180]}, reference_shell(own), []
    for study in (both, own):
        check_spring(varied(study, pto={"port": port, "stiffness": 0.0}), reference)
        with pytest.raises(ConfigError, match="with which a buoy does not rest") as told:
            check_spring(varied(study, pto={"port": port, "stiffness": -1e9}), reference)
        borders.append(str(told.value))
    assert borders[0] == borders[1]


# a shell's own ports -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "port",
    ["volume", {"colatitude": 90, "direction": "radial"}, {"between": [0, 180]}],
    ids=["volume", "point", "between"],
)
def test_limits_stops_and_pauses_act_on_every_port_of_the_shell(seed, port, tmp_path_factory, monkeypatch):
    """In a vented shell; a shut valve holds the volume, as a latch the heave."""
    monkeypatch.setattr("vsb.scenes.build.best_pause_in_sea", lambda *_: BestPause(0.9, 0.0, 0.0))
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
        found = SCENES["linear"](only_run(study), hydro_files(study, tmp_path_factory.getbasetemp() / "pause"))
        (leg,) = legs(found.system, found.sea, study.simulation, None)
        assert leg.balance.residual < 1e-6
        b = found.scene.forces["pto"].direction
        force = leg.motion.forces["pto"] @ b / (b @ b)
        return np.abs(leg.motion.position @ b).max(), np.abs(leg.motion.velocity @ b), np.abs(force).max()

    stroke, _, force = followed(law="saturated", force_limit=1e9)
    assert followed(law="saturated", force_limit=0.5 * force)[2] == pytest.approx(0.5 * force)
    assert followed(law="coulomb", force_limit=0.5 * force)[2] == pytest.approx(0.5 * force)
    assert followed(stroke_limit=0.5 * stroke)[0] < 0.6 * stroke
    speed = followed(law="latching")[1]
    assert np.mean(speed < 1e-9 * speed.max()) > 0.2
    assert (followed(law="declutching")[1] > 0).mean() > 0.9


@pytest.mark.parametrize("port", [{"colatitude": 60}, {"between": [0, 180]}], ids=["point", "between"])
def test_on_the_wet_shell_a_port_of_the_shell_takes_what_linear_theory_says_in_small_waves(port, tmp_path_factory):
    """The difference grows with the square of the waves; limits are kept and energy is closed there too."""

    def followed(model, amplitude, **pto):
        study = varied(
            load(CONFIG / "pressurised.yaml"),
            designs={"VSWEC": {}},
            modes={"degree": 2},
            hydro={"omega_max": 4.5, "model": model},
            pto={"damping": 9000.0, "port": port, **pto},
            waves=[{"kind": "regular", "amplitude": amplitude, "period": 3.0}],
            simulation={"duration": 39.0, "window": (30.0, 39.0), "initial_velocity": 0.0, "tolerance": 1e-9},
        )
        found = SCENES[model](only_run(study), hydro_files(study, tmp_path_factory.getbasetemp() / "wet"))
        (leg,) = legs(found.system, found.sea, study.simulation, None)
        assert leg.balance.residual < 1e-6
        force = found.scene.forces["pto"].force(leg.motion.time, leg.motion.position, leg.motion.velocity)
        start, end = np.interp([30.0, 39.0], leg.motion.time, leg.energy["pto"])
        return end - start, np.linalg.norm(force, axis=1).max() / np.linalg.norm(
            port_direction(study.pto.port, found.shape)
        )

    waves = (0.02, 0.04, 0.08, 0.16)
    apart = [followed("body_exact", a)[0] / followed("linear", a)[0] - 1 for a in waves]
    assert np.log2(np.divide(apart[1:], apart[:-1])) == pytest.approx([2.0, 2.0, 2.0], abs=0.25)
    power, force = followed("body_exact", 0.16)
    held = followed("body_exact", 0.16, law="saturated", force_limit=0.5 * force)
    assert held[1] == pytest.approx(0.5 * force)
    assert 0.3 * power < held[0] < power


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("law", LAWS)
def test_springs_and_strokes_count_from_where_the_buoy_rests(plant, law, side):
    """In the stroke of its port, b N y, to either side; a friction has no spring."""
    b, motions, rest = np.array([1.0, -0.5]), np.array([[1.0, 0.0], [0.0, 2.0]]), side * np.array([0.3, -0.7])
    held = np.array([[50.0, 90.0], [90.0, 400.0]])
    forces = plant.forces | {"hydrostatic": Spring(held)}
    resting = replace(plant, forces=forces, motions=motions, origin=rest)
    pto = Pto(law=law, damping=4.0, stiffness=6.0 if law != "coulomb" else 0.0, force_limit=3.0, stroke_limit=0.2)
    scene = with_take_off(resting, pto, LinearPto(4.0, 6.0, b))
    force, stop = scene.law, scene.stop
    assert force.rest == stop.rest == pytest.approx(side * (0.3 - 0.5 * 2 * -0.7))
    assert (force.limit, stop.stroke) == (3.0, 0.2)
    assert (force.damping, force.stiffness) == ((np.inf, 0.0) if law == "coulomb" else (4.0, 6.0))
    for one in (force, stop):
        np.testing.assert_array_equal(one.direction, b)
    pushed = np.linalg.solve(motions.T @ plant.mass @ motions, motions.T @ b) @ (motions.T @ b)
    yields = b @ np.linalg.solve(held, b)
    assert stop.stiffness == pytest.approx(100.0 / yields, rel=1e-12)
    assert stop.damping == pytest.approx(2 * np.sqrt(stop.stiffness / pushed), rel=1e-12)


@pytest.mark.parametrize("efficiency", [1.0, 0.6])
def test_a_tuned_damper_is_that_of_what_the_efficiency_leaves_of_power_both_ways(efficiency):
    """Beside a spring it is heavier the more is lost on the way forth and back."""
    seas, stiffness = [regular(2.0), regular(1.1, 0.5)], -4.0
    omega = frequencies(seas)
    port, together = OnePort().port(omega, None, None), squares(seas, omega).sum(axis=0, keepdims=True)
    expected = best_dampers(port, together, stiffness, efficiency).damping[0]
    found = tuned(seas, stiffness=stiffness, efficiency=efficiency, tuning="one")
    assert found.damping == pytest.approx(expected, rel=1e-9)
    assert abs(best_dampers(port, together, stiffness, 0.8).damping[0] / expected - 1) > 1e-3


def test_beside_a_drag_a_damper_is_tuned_to_the_sum_of_the_seas_from_all_sides(monkeypatch):
    """With the spring and the efficiency of the take-off; what has no waves is left out."""
    seen = []
    monkeypatch.setattr(drag, "best_damper", lambda *given: seen.append(given) or 55.0)
    sides = [
        RegularWave(kind="regular", amplitude=1.0, period=1.0, direction=direction) for direction in (0.0, 40.0, 0.0)
    ]
    seas = list(zip(sides, [regular(2.0), regular(1.1, 0.5j), NO_WAVES], strict=True))
    floating = Afloat(OnePort(), {"A": np.eye(1)}, np.ones(1))
    asked = []
    found = tuned_take_off(
        Pto(tuning="each", stiffness=-3.0, efficiency=0.7),
        "A", floating, seas, lambda *given: asked.append(given) or "dragged",
    )  # fmt: skip
    assert (found.damping, found.stiffness, found.port) == (55.0, -3.0, floating.port)
    ((afloat, design, going),) = asked
    assert (afloat, design) == (floating, "A")
    assert {at: omega.tolist() for at, omega in going.items()} == {0.0: [2.0], 40.0: [1.1]}
    ((port, amplitudes, stiffness, efficiency),) = seen
    assert (port, stiffness, efficiency) == ("dragged", -3.0, 0.7)
    np.testing.assert_allclose(amplitudes, [[1.0, 0.0], [0.0, 0.25]])
