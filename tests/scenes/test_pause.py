"""The best pause of latching and declutching: above every damper, below what any force can do."""

import importlib.util
import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import SEED, only_run, varied

from benchmarks.hard_cases import hydro_files
from vsb.errors import ConvergenceError
from vsb.integrators.settled import Trials, settled_power
from vsb.integrators.simulate import legs, simulate
from vsb.integrators.switching import Switching, switched
from vsb.motion.constrained import constrained_optimum, optimum_in_sea
from vsb.motion.force_bound import Limits
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import TakeOff
from vsb.motion.tuning import best_dampers, squares
from vsb.scenes import pause as pause_module
from vsb.scenes.afloat import linear_buoy, study_port
from vsb.scenes.build import SCENES
from vsb.scenes.pause import (
    KNOWN_WET,
    NEAR,
    SETTLED,
    BestPause,
    best_pair,
    best_pair_in_sea,
    best_pause,
    best_pause_in_sea,
    refined_pause,
    strongest,
    windowed_power,
    with_pause,
)
from vsb.study import study as config
from vsb.study.sections import Simulation
from vsb.waves.seas import NO_WAVES, Sea, sea

B, MASS, SPRING, LOSS = np.ones(1), 2.0, 50.0, 0.6
SETTINGS = Simulation(duration=60.0, window=(20.0, 60.0), initial_position=0.0, initial_velocity=0.0)
IRREGULAR = Sea(np.array([1.6, 1.9, 2.3]), np.array([0.3, 0.5 + 0.4j, -0.3j]))


def scene(law, sea):
    """2 y'' + 0.6 y' + 50 y = 30 times the elevation + take-off: natural frequency 5 rad/s."""
    waves = {"excitation": Excitation(sea.omega, 30.0 * sea.amplitude[:, None])} if sea.omega.size else {}
    forces = {"hydrostatic": Spring(np.array([[SPRING]])), "structural_damping": Damper(np.array([[LOSS]]))}
    return Scene(("Heave",), np.array([[MASS]]), {**forces, "pto": law, **waves}, np.eye(1))


def regular(omega):
    return Sea(np.array([omega]), np.array([1.0 + 0j]))


def impedance(omega):
    return LOSS + 1j * (SPRING / omega - omega * MASS)


def matched(sea):
    return float(np.sum(np.abs(30.0 * sea.amplitude) ** 2) / (8 * LOSS))


def passive(sea, damping):
    """Mean power of dampers, shape (damper,)."""
    per_component = (
        0.5 * damping[:, None] * np.abs(30.0 * sea.amplitude / (impedance(sea.omega) + damping[:, None])) ** 2
    )
    return per_component.sum(axis=1)


@pytest.fixture(scope="module", autouse=True)
def coarse():
    """Fewer pauses tried: these powers have one maximum, and a flat one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vsb.scenes.pause.SCANNED", 8)
        patch.setattr("vsb.scenes.pause.KNOWN", 0.01)
        yield


@pytest.fixture(scope="module")
def latched(coarse):
    """Latching in a regular wave far below resonance, its best pause."""
    law, sea = TakeOff(B, 2.0, pause=0.0, paused_damping=np.inf), regular(2.0)
    return scene(law, sea), sea, best_pause_in_sea(scene(law, sea), sea, SETTINGS)


def test_latching_is_far_above_the_best_damper_and_below_every_force_of_its_size(latched):
    """The port is held for what half the wave's period is longer than half its own."""
    held, sea, best = latched
    assert best.pause == pytest.approx(np.pi / 2 - np.pi / 5, rel=0.12)
    assert 5 * passive(sea, np.abs(impedance(sea.omega)))[0] < best.power < matched(sea)
    system = System.of(with_pause(held, best.pause))
    motion, _ = switched(system, np.linspace(0.0, 80 * np.pi, 80 * 64 + 1), (np.zeros(1), np.zeros(1)))
    taken = (motion.works["pto"][-1] - motion.works["pto"][-641]) / (10 * np.pi)
    assert best.power == pytest.approx(taken, rel=2 * SETTLED)
    force, stroke = (np.abs(x[-641:]).max() for x in (motion.forces["pto"], motion.position))
    harmonics = Harmonics(2.0, 1.0, 15)
    admittance = 1 / impedance(harmonics.port_omega)
    port = Port(harmonics.port_omega, admittance, 30.0 * admittance, 1 / SPRING)
    allowed = constrained_optimum(harmonics, port, np.eye(15)[0], Limits(force, stroke))
    assert best.power <= allowed.bound < matched(sea)


@pytest.mark.parametrize("longest", [0.01, 7.0, 300.0])
def test_the_search_knows_no_units(longest):
    """Pauses over the longest one, dampers over the first and their powers are the same, and known as well."""

    def power(damping, pause):
        return np.exp(-(((pause / longest - 0.37) / 0.2) ** 2) - np.log(damping / longest / 3.0) ** 2)

    alone = best_pause(lambda pause: power(3.0 * longest, pause), longest)
    damper, pair = best_pair(power, [longest, 10 * longest], longest)
    for found in (alone, pair):
        assert found.pause / longest == pytest.approx(0.37, abs=pause_module.KNOWN)
        assert found.within == pytest.approx(pause_module.KNOWN * longest)
        assert found.power == pytest.approx(1.0, abs=4e-3)
    assert damper / longest == pytest.approx(3.0, rel=3 * pause_module.COARSE)
    assert pair.power == pytest.approx(power(damper, pair.pause), rel=1e-12)


def test_the_best_pause_is_no_worse_than_any_other(latched):
    held, _, best = latched
    for pause in (0.5, 0.9, 0.98):
        assert settled_power(System.of(with_pause(held, pause)), SETTLED)[0] <= best.power * (1 + 2 * SETTLED)


def test_latching_in_a_sea_is_above_every_damper_and_is_the_mean_of_the_run():
    law = TakeOff(B, 2.0, pause=0.0)
    best = best_pause_in_sea(scene(law, IRREGULAR), IRREGULAR, SETTINGS)
    assert 1.5 * passive(IRREGULAR, np.geomspace(0.1, 100.0, 200)).max() < best.power < matched(IRREGULAR)
    system = System.of(with_pause(scene(law, IRREGULAR), best.pause))
    motion, *_ = simulate(system, IRREGULAR, SETTINGS, None)
    taken = np.interp(SETTINGS.window, motion.time, motion.works["pto"])
    assert best.power == pytest.approx(np.diff(taken)[0] / 40.0, rel=1e-9)
    parts = [windowed_power(system, IRREGULAR, SETTINGS.model_copy(update={"window": w})) for w in ((20, 45), (45, 60))]
    assert 25 * parts[0] + 15 * parts[1] == pytest.approx(40 * best.power, rel=1e-9)


@pytest.mark.parametrize(
    ("law", "waves"),
    [
        (TakeOff(B, 2.0), regular(2.0)),
        (TakeOff(B, 60.0, paused_damping=0.0), regular(2.0)),
        (TakeOff(B, 2.0), IRREGULAR),
    ],
    ids=["latching", "declutching", "irregular"],
)
def test_quick_trials_find_what_a_search_over_runs_from_rest_finds(law, waves, monkeypatch):
    """To half a per cent of the power; two motions from rest are followed.

    The declutched one has two motions that repeat, and the better one is not met from rest at the pause the trials
    find: the search then goes over motions from rest.
    """
    followed, longest = [], float(np.pi / waves.omega[np.argmax(np.abs(waves.amplitude))])

    def power(system, sea, settings, known=pause_module._power):
        followed.append(known(system, sea, settings))
        return followed[-1]

    monkeypatch.setattr(pause_module, "_power", power)
    found = best_pause_in_sea(scene(law, waves), waves, SETTINGS)
    assert found.power in followed
    assert (len(followed) == 2) == (law.damping == 2.0)
    whole = best_pause(lambda p: power(System.of(with_pause(scene(law, waves), p)), waves, SETTINGS), longest)
    assert found.power == pytest.approx(whole.power, rel=5e-3)


def test_trials_that_promise_what_no_motion_from_rest_takes_are_not_believed(latched, monkeypatch):
    held, sea, best = latched
    monkeypatch.setattr(Trials, "power", lambda _, system: 1e9 * system.scene.law.pause)
    found = best_pause_in_sea(held, sea, SETTINGS)
    assert found.pause == pytest.approx(best.pause, abs=best.within)
    assert found.power == pytest.approx(best.power, rel=5e-3)


@pytest.mark.parametrize(("more", "pause"), [(0.2, 0.5), (0.3, 0.0)])
def test_a_pause_must_take_more_from_rest_than_none_does(more, pause, monkeypatch):
    """Trials find 1 at half a second and 3/4 without a pause; from rest that is `more`, all else as in the trials."""

    def trial(system):
        return 1.0 - (system.scene.law.pause - 0.5) ** 2

    monkeypatch.setattr(Trials, "power", lambda _, system: trial(system))
    monkeypatch.setattr(
        pause_module, "_power", lambda system, *_: trial(system) + (more if system.scene.law.pause == 0.0 else 0.0)
    )
    found = best_pause_in_sea(scene(TakeOff(B, 2.0), regular(2.0)), regular(2.0), SETTINGS)
    assert found.pause == pytest.approx(pause, abs=found.within)
    assert found.power == pytest.approx(max(1.0, 0.75 + more), abs=1e-3)


@pytest.mark.parametrize(("share", "anew"), [(0.981, False), (0.979, True)])
def test_a_search_begins_anew_where_a_motion_from_rest_takes_less_than_98_per_cent_of_what_trials_promise(
    share, anew, monkeypatch
):
    followed = []

    def trial(system):
        return 1.0 - (system.scene.law.pause - 0.5) ** 2

    monkeypatch.setattr(Trials, "power", lambda _, system: trial(system))
    monkeypatch.setattr(pause_module, "_power", lambda system, *_: followed.append(system) or share * trial(system))
    best_pause_in_sea(scene(TakeOff(B, 2.0), regular(2.0)), regular(2.0), SETTINGS)
    assert (len(followed) > 2) == anew


@pytest.mark.parametrize(
    ("wave", "least"),
    [
        ({"kind": "regular", "amplitude": 0.1, "period": 5.0}, 3.0),
        ({"kind": "jonswap", "hs": 0.3, "tp": 5.0, "seed": 3}, 1.5),
    ],
    ids=["regular", "jonswap"],
)
def test_a_floating_buoy_that_latches_is_between_its_best_damper_and_the_optimum_under_its_own_limits(
    wave, least, tmp_path_factory, monkeypatch
):
    """The seed's rigid buoy, over one period of the waves, beside what any force no larger takes in no longer a stroke.

    Radiation is known to 7 rad/s, five to six times the waves' frequency: the optimum may switch about as sharply.
    """
    monkeypatch.setattr("vsb.scenes.pause.SCANNED", 4)
    monkeypatch.setattr("vsb.integrators.settled.MOST", 16)
    study = varied(
        config.load(SEED),
        designs={"FSB": {"flexible": False}},
        hydro={"omega_max": 7.0, "tolerance": 1e-2},
        pto={"damping": 11e3, "law": "latching"},
        waves=[wave],
        simulation={"duration": 40.0, "window": (20.0, 40.0), "initial_velocity": 0.0},
    )
    files, (wave,) = hydro_files(study, tmp_path_factory.getbasetemp() / "pause"), study.waves
    (buoy, basis), waves = linear_buoy(study, files["database"]), sea(wave, 7.0, 40.0)
    harmonics = Harmonics.of_sea(waves.omega, float(buoy.database.omega[0]), 7.0)
    seen, port = (
        buoy.extended_port(omega, np.ones((1, 1)), study_port(study, buoy, basis))
        for omega in (waves.omega, harmonics.port_omega)
    )
    (passive,) = best_dampers(seen, squares([waves], waves.omega)).power
    repeats = 2 * np.pi / harmonics.spacing
    begin = np.ceil(40.0 / repeats) * repeats
    settings = study.simulation.model_copy(update={"duration": begin + repeats, "window": (begin, begin + repeats)})
    run = only_run(study).model_copy(update={"simulation": settings})
    latched = SCENES["linear"](run, files)
    motion, *_ = simulate(latched.system, waves, settings, None)
    within = motion.time >= begin
    force, stroke = (float(np.abs(x[within]).max()) for x in (motion.forces["pto"], motion.position))
    best = optimum_in_sea(port, waves, harmonics, Limits(force, stroke))
    taken = float(np.diff(np.interp(settings.window, motion.time, motion.works["pto"]))[0]) / repeats
    assert taken == pytest.approx(latched.notes["pause_power"], rel=1e-3)
    assert least * passive < taken < best.bound < waves.mean_of(seen.matched_power)


@pytest.mark.parametrize("top", [(0.3, 0.2), (2.0, 0.71), (40.0, 0.97)])
def test_a_pair_is_found_that_no_pair_tried_beats(top):
    """A hill whose ridge runs across damper and pause."""
    tried = []

    def power(damper, pause):
        u, v = np.log(damper / top[0]), pause - top[1]
        tried.append(9.0 - u**2 - 40 * v**2 - 4 * u * v)
        return tried[-1]

    damper, best = best_pair(power, [0.2, 3.0, 45.0], 1.0)
    assert best.power == max(tried)
    assert best.power == pytest.approx(9.0, abs=0.03)
    assert best.pause == pytest.approx(top[1], abs=0.05)
    assert damper == pytest.approx(top[0], rel=0.2)


def test_a_damper_goes_beyond_those_tried_by_their_distance_a_half_a_quarter_and_an_eighth_of_it():
    """Four rounds, each half as far as the one before: a power that grows with the damper leads that far."""
    apart = np.log(10.0)
    damper, best = best_pair(lambda c, pause: c**0.1 * (1 - (pause - 0.4) ** 2), [1.0, 10.0, 100.0], 1.0)
    assert np.log(damper / 100.0) / apart == pytest.approx(1 + 1 / 2 + 1 / 4 + 1 / 8, abs=0.1)
    assert best.pause == pytest.approx(0.4, abs=2e-3)
    alone, _ = best_pair(lambda c, pause: c**0.1 * (1 - (pause - 0.4) ** 2), [100.0], 1.0)
    assert alone == pytest.approx(100.0, rel=2e-3)  # with no other beside it, it is the given one


def test_a_search_ends_where_a_round_gains_less_than_a_thousandth():
    """In each a damper is held while pauses are tried: one where all are as good, four where the power goes on growing."""

    def held(power):
        tried = []
        best_pair(lambda c, pause: tried.append((c, pause)) or power(c, pause), [1.0, 10.0], 1.0)
        turns = tried[2 * 9 :]  # of two dampers with nine pauses each
        return len({c for (c, pause), (other, last) in itertools.pairwise(turns) if c == other and pause != last})

    assert held(lambda c, pause: 1.0) == 1
    assert held(lambda c, pause: c * (1 - (pause - 0.4) ** 2)) == 4


def test_a_pause_is_refined_up_to_the_pauses_tried_beside_it_and_no_further():
    """Of nine the middle one is best; the power grows nearly to the next one and then drops."""
    top, asked = 0.5 + 0.95 / 8, []

    def power(damper, pause):
        asked.append((damper, pause))
        return 1.0 + min(pause - 0.5, top - 0.5 - 50 * (pause - top))

    _, best = best_pair(power, [1.0, 10.0], 1.0)
    assert best.pause == pytest.approx(top, abs=2 * pause_module.KNOWN)
    first = [pause for _, pause in itertools.takewhile(lambda pair: pair[0] == 10.0, asked[2 * 9 :])]
    assert 0.9 / 8 < max(abs(pause - 0.5) for pause in first) <= 1 / 8


@pytest.mark.parametrize("window", [(0.0, 60.0), (20.0, 60.0), (10.0, 15.0), (25.0, 50.0), (0.0, 20.0), (45.0, 60.0)])
def test_power_in_a_window_is_that_between_its_ends_whichever_parts_of_a_run_they_fall_into(window, monkeypatch):
    """Energy t^2 has the mean rate start + end."""
    parts = [np.arange(0.0, 21.0), np.arange(20.0, 46.0), np.arange(45.0, 61.0)]
    run = [SimpleNamespace(motion=SimpleNamespace(time=time), energy={"pto": time**2}) for time in parts]
    monkeypatch.setattr(pause_module, "legs", lambda *_: iter(run))
    settings = SETTINGS.model_copy(update={"window": window})
    assert windowed_power(None, IRREGULAR, settings) == pytest.approx(sum(window), rel=1e-12)


# on the wet shell ---------------------------------------------------------------------------------------------------


def test_a_pause_that_is_off_is_refined(latched):
    held, sea, best = latched
    off = best._replace(pause=best.pause - 0.8 * NEAR * np.pi / 2)
    refined = refined_pause(held, off, sea, SETTINGS)
    assert refined.pause == pytest.approx(best.pause, abs=0.04 * np.pi / 2)
    assert refined.power == pytest.approx(best.power, rel=0.02)
    assert refined.within == KNOWN_WET * np.pi / 2
    assert 0.0 <= refined_pause(held, best._replace(pause=0.0), sea, SETTINGS).pause <= NEAR * np.pi / 2


def test_a_refined_pause_in_a_sea_takes_more_and_never_less():
    held, near = scene(TakeOff(B, 2.0), IRREGULAR), NEAR * np.pi / 1.9
    for pause in (0.72, 0.98):
        before = windowed_power(System.of(with_pause(held, pause)), IRREGULAR, SETTINGS)
        refined = refined_pause(held, BestPause(pause, 0.0, 0.0), IRREGULAR, SETTINGS)
        assert abs(refined.pause - pause) < near
        after = windowed_power(System.of(with_pause(held, refined.pause)), IRREGULAR, SETTINGS)
        assert refined.power == pytest.approx(after, rel=1e-9)
        assert after > before


@pytest.mark.parametrize("sea", [regular(2.0), IRREGULAR], ids=["regular", "irregular"])
def test_a_pause_whose_motion_cannot_be_followed_takes_nothing(sea, monkeypatch):
    """Here all but the one of the linear scene."""

    def follow(self, *arguments, known=Switching.follow):
        if self.law.pause != 0.7:
            raise ConvergenceError("the take-off switches without end")
        return known(self, *arguments)

    monkeypatch.setattr(Switching, "follow", follow)
    refined = refined_pause(scene(TakeOff(B, 2.0), sea), BestPause(0.7, 0.0, 0.1), sea, SETTINGS)
    assert refined.pause == 0.7
    assert refined.power > 0


def test_a_vented_shell_is_released_earlier_than_its_linear_scene_says(tmp_path_factory, monkeypatch):
    """It rests deformed: the pause of 0.98 s of the linear scene takes a fifth less than a shorter one."""
    for name, value in {"FEWEST": 8, "CONTINUED": 4}.items():
        monkeypatch.setattr(f"vsb.integrators.settled.{name}", value)
    monkeypatch.setattr("vsb.scenes.pause.SETTLED_WET", 0.05)
    monkeypatch.setattr("vsb.scenes.pause.NEAR", 0.06)
    monkeypatch.setattr("vsb.scenes.pause.KNOWN_WET", 0.03)
    study = varied(
        config.load(SEED),
        designs={"VSWEC": {}},
        modes={"degree": 2},
        hydro={"model": "body_exact", "omega_max": 4.5, "tolerance": 1e-2},
        pto={"damping": 9000.0, "law": "latching"},
        waves=[{"kind": "regular", "amplitude": 0.05, "period": 5.0}],
        simulation={"initial_velocity": 0.0},
    )
    monkeypatch.setattr("vsb.scenes.build.best_pause_in_sea", lambda *_: BestPause(0.98, 246.0, 0.0025))
    powers = []
    monkeypatch.setattr(Trials, "power", lambda *given, known=Trials.power: powers.append(known(*given)) or powers[-1])
    files = hydro_files(study, tmp_path_factory.getbasetemp() / "pause")
    design = SCENES["body_exact"](only_run(study), files)
    assert design.notes["linear_pause"] == 0.98
    assert 0.8 < design.notes["pause"] < 0.95
    assert design.scene.forces["pto"].pause == design.notes["pause"]
    assert design.notes["pause_power"] == max(powers) > 1.15 * powers[0]


def test_declutching_helps_a_damper_that_is_too_strong():
    sea = regular(2.0)
    best = best_pause_in_sea(scene(TakeOff(B, 60.0, pause=0.0, paused_damping=0.0), sea), sea, SETTINGS)
    assert best.power > 1.5 * passive(sea, np.array([60.0]))[0]
    assert best.power > passive(sea, np.abs(impedance(sea.omega)))[0]


def test_as_shipped_a_pause_loses_no_more_power_than_its_trials_are_known_to():
    """Of a maximum as narrow as the search promises not to miss, wherever it lies; constants are those of the file."""
    spec = importlib.util.spec_from_file_location("as_shipped", pause_module.__file__)
    shipped = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(shipped)
    width = 2 / shipped.SCANNED
    for top in np.linspace(0.13, 0.87, 200):
        found = shipped.best_pause(lambda pause, top=top: float(np.exp(-(((pause - top) / width) ** 2))), 1.0)
        assert found.power > 1 - SETTLED
        assert abs(found.pause - top) < found.within


@pytest.mark.parametrize("top", [0.0, 0.37, 0.7311, 1.0])
def test_a_maximum_is_found_within_what_is_stated(top):
    best = best_pause(lambda pause: 5.0 - (pause - top) ** 2, 1.0)
    assert best.pause == pytest.approx(top, abs=0.01)
    assert best.within == 0.01
    steps = best_pause(lambda pause: float(pause >= 0.95), 1.0)
    assert (steps.pause, steps.power) == (1.0, 1.0)


def test_still_water_needs_no_pause():
    none = best_pause_in_sea(scene(TakeOff(B, 2.0), NO_WAVES), NO_WAVES, SETTINGS)
    assert none == (0.0, 0.0, 0.0)
    for given in (none, BestPause(0.7, 5.0, 0.1)):
        assert refined_pause(scene(TakeOff(B, 2.0), NO_WAVES), given, NO_WAVES, SETTINGS) == given


@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_a_study_pauses_as_long_as_takes_most_of_its_sea_and_says_so(model, tmp_path_factory, monkeypatch):
    monkeypatch.setattr("vsb.scenes.pause.KNOWN_WET", 0.03)
    monkeypatch.setattr("vsb.scenes.pause.SCANNED", 4)
    monkeypatch.setattr("vsb.scenes.pause.KNOWN", 0.1)
    monkeypatch.setattr("vsb.integrators.settled.MOST", 16)
    study = varied(
        config.load(SEED),
        designs={"FSB": {"flexible": False}},
        hydro={"model": model, "omega_max": 4.5, "tolerance": 1e-2},
        pto={"damping": 8000.0, "law": "latching", "force_limit": 5e4}
        | ({"stroke_limit": 3.0} if model == "linear" else {}),
        waves=[{"kind": "regular", "amplitude": 0.1, "period": 5.0}],
        simulation={"initial_velocity": 0.0},
    )
    files = hydro_files(study, tmp_path_factory.getbasetemp() / "pause")
    design = SCENES[model](only_run(study), files)
    assert 0.5 < design.notes["pause"] < 1.5
    assert design.scene.forces["pto"].pause == design.notes["pause"]
    assert design.notes["pause_within"] == pytest.approx(0.25 if model == "linear" else 0.075)
    wet = {name: design.notes[name] for name in ("linear_pause", "pause_tried") if name in design.notes}
    assert wet == ({} if model == "linear" else {"linear_pause": wet["linear_pause"], "pause_tried": 2.5 * NEAR})
    assert abs(design.notes["pause"] - wet.get("linear_pause", design.notes["pause"])) < 2.5 * NEAR
    parts = list(legs(design.system, design.sea, study.simulation, None))
    assert max(part.balance.residual for part in parts) < 1e-6
    absorbed = np.diff(np.interp([50.0, 60.0], parts[-1].motion.time, parts[-1].energy["pto"]))[0] / 10.0
    assert absorbed == pytest.approx(design.notes["pause_power"], rel=0.05)


def test_a_damper_that_tuning_is_to_find_is_found_with_its_pause(tmp_path_factory, monkeypatch):
    """It is recorded as the damper of the run, lighter than the best one alone, and takes more."""
    monkeypatch.setattr("vsb.scenes.pause.PAIRED", 4)
    monkeypatch.setattr("vsb.scenes.pause.ROUNDS", 1)
    monkeypatch.setattr("vsb.integrators.settled.MOST", 16)
    study = varied(
        config.load(SEED),
        designs={"FSB": {"flexible": False}},
        hydro={"omega_max": 4.5, "tolerance": 1e-2},
        pto={"damping": None, "tuning": "each", "law": "latching"},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": 5.0}],
    )
    files = hydro_files(study, tmp_path_factory.getbasetemp() / "pause")
    design = SCENES["linear"](only_run(study), files)
    law = design.scene.forces["pto"]
    alone = SCENES["linear"](only_run(varied(study, pto={"law": "linear"})), files).notes["tuned_damping"]
    assert law.damping == design.notes["tuned_damping"] < 0.5 * alone
    assert law.pause == design.notes["pause"] > 0.5
    assert design.notes["pause_power"] > 1.5 * settled_power(System.of(with_pause(design.scene, 0.0, alone)))[0]


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_no_pause_is_tried_below_none_or_beyond_the_longest(slope, monkeypatch):
    """Where power rises up to one of them that is the best, with its whole power."""
    asked = []

    def power(damper, pause):
        asked.append(pause)
        return 5.0 + slope * pause

    longest, end = 1.3, 1.3 if slope > 0 else 0.0
    for best in (best_pause(lambda pause: power(0.0, pause), longest), best_pair(power, [1.0, 10.0], longest)[1]):
        assert best.pause == end
        assert best.power == 5.0 + slope * end
    monkeypatch.setattr(Trials, "power", lambda _, system: power(0.0, system.scene.law.pause))
    sea = regular(np.pi / longest)
    near = refined_pause(scene(TakeOff(B, 2.0), sea), BestPause(end, 1.0, 0.1), sea, SETTINGS)
    assert near == (end, 5.0 + slope * end, pytest.approx(KNOWN_WET * longest))
    assert 0.0 <= min(asked) < max(asked) <= longest


@pytest.mark.parametrize(
    ("amplitude", "at"), [([0.5, -2.0, 1.5j], 2.0), ([0.5, 1.0, -3j], 3.0), ([-1.0, 0.9, 0.0], 1.0)]
)
def test_the_strongest_component_of_a_sea_is_that_of_the_largest_amplitude_whatever_its_phase(amplitude, at):
    assert strongest(Sea(np.array([1.0, 2.0, 3.0]), np.array(amplitude, dtype=complex))) == at


def test_a_damper_goes_as_far_as_its_neighbours_are_on_the_average_apart():
    """Of three tried, unequally far apart, half of what the outer ones are: where power grows with it alone."""
    damper, _ = best_pair(lambda c, pause: c**0.1, [1.0, 50.0, 100.0], 1.0)
    assert np.log(damper / 100.0) / np.log(10.0) == pytest.approx(1 + 1 / 2 + 1 / 4 + 1 / 8, abs=0.1)


def test_a_take_off_keeps_its_damper_where_only_its_pause_changes():
    held = scene(TakeOff(B, 2.0, 7.0, 30.0, rest=0.2), regular(2.0))
    for damping, expected in ((None, 2.0), (0.0, 0.0), (3.0, 3.0)):
        law = with_pause(held, 0.4, damping).law
        assert (law.pause, law.damping, law.stiffness, law.limit, law.rest) == (0.4, expected, 7.0, 30.0, 0.2)


def test_pauses_are_tried_up_to_half_a_period_of_the_strongest_component_and_known_to_a_part_of_that(monkeypatch):
    asked = []

    def search(sought, *_):
        return sought(lambda damper, pause: asked.append(pause) or -((pause - 0.5) ** 2))

    monkeypatch.setattr(pause_module, "_sought", search)
    held, longest = scene(TakeOff(B, 2.0), IRREGULAR), np.pi / 1.9
    _, pair = best_pair_in_sea(held, IRREGULAR, SETTINGS, [1.0, 10.0])
    assert max(asked) == pytest.approx(longest)
    asked.clear()
    alone = best_pause_in_sea(held, IRREGULAR, SETTINGS)
    assert max(asked) == pytest.approx(longest)
    assert pair.within == alone.within == pytest.approx(pause_module.KNOWN * longest)


@pytest.mark.parametrize(("given", "tried"), [(1e-9, pause_module.TRIED), (0.02, 0.02)])
def test_trials_in_an_irregular_sea_are_the_run_followed_as_coarsely_as_is_known_enough(given, tried, monkeypatch):
    followed = []
    monkeypatch.setattr(pause_module, "windowed_power", lambda *asked: followed.append(asked) or 3.0)
    settings = SETTINGS.model_copy(update={"tolerance": given})
    assert pause_module._trials(IRREGULAR, settings)("system") == 3.0
    ((system, sea, used),) = followed
    assert (system, sea, used.tolerance, used.window) == ("system", IRREGULAR, tried, SETTINGS.window)


def test_power_in_a_regular_wave_is_that_of_the_settled_motion_whatever_the_window(monkeypatch):
    monkeypatch.setattr(pause_module, "settled_power", lambda system, error: (len(system) + error, None))
    monkeypatch.setattr(pause_module, "windowed_power", lambda *_: 8.0)
    assert pause_module._power("four", regular(2.0), SETTINGS) == 4.0 + SETTLED
    assert pause_module._power("four", IRREGULAR, SETTINGS) == 8.0


@pytest.mark.parametrize(("paused", "without", "anew"), [(0.99, 0.5, False), (0.99, 0.995, True), (0.97, 0.5, True)])
def test_what_a_search_finds_is_told_with_the_power_from_rest_under_its_own_damper(paused, without, anew, monkeypatch):
    """The trials promise 1 of a damper that is not the take-off's; else the search over motions from rest is told."""

    def from_rest(system, sea, settings):
        assert (sea, settings) == (waves, SETTINGS)
        return {(3.0, 0.5): paused, (3.0, 0.0): without}[system.scene.law.damping, system.scene.law.pause]

    def search(power):
        return 3.0, BestPause(0.5, power(3.0, 0.5), 0.25 if power(3.0, 0.5) == 1.0 else 0.125)

    waves = regular(2.0)
    monkeypatch.setattr(pause_module, "_power", from_rest)
    monkeypatch.setattr(pause_module, "_trials", lambda sea, settings: lambda system: 1.0)
    found = pause_module._sought(search, scene(TakeOff(B, 2.0), waves), waves, SETTINGS)
    assert found == (3.0, (0.5, paused, 0.125 if anew else 0.25))
