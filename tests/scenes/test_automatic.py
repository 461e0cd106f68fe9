"""The automatic model: honest about what it leaves out, no richer than it must be."""

import itertools
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConvergenceError, StabilityError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.harmonic_balance import harmonic_balance, steady_power
from vsb.scenes import automatic
from vsb.scenes.automatic import RIGID, Description, Scenes, chosen, linear_power, motion_ladder, truncated
from vsb.scenes.rest import study_basis
from vsb.shell.deformed import DeformedShell
from vsb.waves.seas import NO_WAVES, Sea, sea

DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 0}}
STIFF = {"device": {"young_modulus": 1e9}, "designs": DESIGNS}
"""A shell that hardly moves at rest: its linear and body-exact powers agree for small waves."""


@pytest.fixture(scope="module")
def scenes_of(seed, buoy_of, radiation_of):
    """Function (design, wave, changes of the seed study) -> its scenes."""

    def build(design, wave, **changes):
        study = varied(seed, **{"designs": DESIGNS, "waves": [wave], **changes})
        basis = study_basis(study)
        buoy, water = buoy_of(study), study.water
        attrs = {"gravity": water.gravity, "water_density": water.density, "water_depth": str(water.depth)}
        buoy = replace(buoy, database=buoy.database.assign_attrs(attrs))
        shape = DeformedShell(basis, study.centre_height, np.zeros(len(basis.labels)))
        waves = sea(study.waves[0], study.hydro.omega_max, study.simulation.duration)
        ladder = motion_ladder(study, basis, design)
        return Scenes(buoy, shape, radiation_of(seed), waves, ladder, study.simulation)

    return build


def swell(amplitude, period):
    return {"kind": "regular", "amplitude": amplitude, "period": period}


@pytest.mark.parametrize("amplitude", [1e-3, 0.05, 0.2])
@pytest.mark.parametrize(("design", "period"), [("FSB", 2.5), ("VSWEC", 4.0), ("VSWEC0", 2.5)])
@pytest.mark.parametrize("tolerance", [0.03, 0.003])
def test_what_it_leaves_out_changes_the_power_by_no_more_than_it_says(scenes_of, design, period, amplitude, tolerance):
    """Against body-exact motion of all modes with the radiation of the coefficients themselves."""
    scenes = scenes_of(design, swell(amplitude, period), **STIFF)
    choice = chosen(scenes, tolerance)
    whole = steady_power(scenes.system(scenes.full), 1e-8, scenes.buoy.spectrum.transfer)
    assert abs(scenes.power(choice.description) / whole - 1) <= choice.error + 1e-7
    assert choice.error <= tolerance


def test_gains_are_as_good_as_the_powers(scenes_of):
    both = [scenes_of(design, swell(0.1, 3.0), **STIFF) for design in ("FSB", "VSWEC")]
    choices = [chosen(scenes, 0.01) for scenes in both]
    found, whole = (
        [scenes.power(d) for scenes, d in zip(both, descriptions, strict=True)]
        for descriptions in ([c.description for c in choices], [scenes.full for scenes in both])
    )
    missed = abs(found[1] / found[0] / (whole[1] / whole[0]) - 1)
    assert missed <= 1.05 * sum(choice.error for choice in choices) + 1e-3  # the memory of `full` is a fit


def test_a_small_wave_on_a_rigid_buoy_needs_nothing_and_a_high_one_the_wet_surface(scenes_of):
    small, high = (chosen(scenes_of("FSB", swell(a, 4.0)), 0.01).description for a in (1e-3, 0.4))
    assert (small.degree, small.body_exact) == (RIGID, False)
    assert (high.degree, high.body_exact) == (RIGID, True)
    assert small.memory < 14


def test_a_stiffer_shell_needs_fewer_modes_until_it_needs_none(scenes_of):
    degrees = [
        chosen(scenes_of("VSWEC", swell(1e-3, 4.0), designs=DESIGNS, device={"young_modulus": e}), 0.01)
        .description.degree
        for e in (1e8, 1e9, 1e13)
    ]  # fmt: skip
    assert degrees == sorted(degrees, reverse=True)
    assert degrees[0] > RIGID == degrees[-1]


def test_a_tighter_tolerance_leaves_out_less(scenes_of):
    scenes = scenes_of("VSWEC", swell(0.1, 2.5), **STIFF)
    found = [chosen(scenes, tolerance) for tolerance in (0.1, 0.01, 0.001)]
    assert [c.error for c in found] == sorted((c.error for c in found), reverse=True)
    assert [c.description.memory for c in found] == sorted(c.description.memory for c in found)
    assert found[0].description != found[-1].description


def test_a_collapsing_or_unstable_scene_is_left_whole(scenes_of, monkeypatch):
    scenes = scenes_of("VSWEC", swell(0.1, 2.5), **STIFF)

    def fails(*_):
        raise StabilityError("grows")

    monkeypatch.setattr(automatic, "steady_power", fails)
    choice = chosen(scenes, 0.01)
    assert choice.description == scenes.full
    assert [item.what for item in choice.left_out] == [f"memory_beyond_{scenes.radiation.order}_states"]
    assert 0 < choice.error < 0.01
    assert choice.notes["unmeasured"] == "grows"


@pytest.mark.parametrize("wave", [{"kind": "jonswap", "hs": 0.02, "tp": 4.0}, {"kind": "still"}])
def test_where_nothing_is_periodic_a_record_is_compared_with_itself(scenes_of, wave):
    scenes = scenes_of("FSB", wave, simulation={"duration": 60.0, "initial_velocity": -0.1})
    choice = chosen(scenes, 0.03)
    assert not choice.description.body_exact
    assert {item.what.split("_")[0] for item in choice.left_out} == {"memory", "body"}
    assert 0 < choice.error <= 0.03


def test_linear_power_of_phasors_is_that_of_harmonic_balance(scenes_of):
    system = scenes_of("VSWEC", swell(0.1, 3.0)).system(Description(6, 14, False))
    assert linear_power(system) == pytest.approx(harmonic_balance(system).power.pto, rel=1e-9)


@pytest.mark.parametrize("begin", [0.0, 11.0, 15.0])
def test_the_mean_of_a_steady_power_is_that_power_from_any_time_on(begin):
    time = np.linspace(10.0, 20.0, 101)
    motion = SimpleNamespace(time=time, velocity=np.ones((len(time), 1)))
    scene = SimpleNamespace(lost=lambda velocity: (7.0 * velocity[:, 0], None), motions=np.eye(1))
    assert automatic.absorbed(SimpleNamespace(scene=scene), motion, begin) == pytest.approx(7.0)


def test_every_rung_holds_the_one_below_and_the_clamps(seed):
    study = varied(seed, designs={"A": {"clamp": [0, 90]}})
    basis = study_basis(study)
    ladder = motion_ladder(study, basis, "A")
    rows = basis.clamp_rows(np.deg2rad(study.designs["A"].clamp))
    assert min(ladder) == RIGID
    assert max(ladder) == 6
    assert 0 not in ladder  # one mode, two clamps: nothing left
    rungs = [ladder[d] for d in sorted(ladder)]
    for smaller, larger in itertools.pairwise(rungs):
        projector = larger @ np.linalg.pinv(larger)
        assert np.allclose(projector @ smaller, smaller, atol=1e-10)
        assert np.abs(rows @ larger).max() < 1e-12


def test_a_ladder_has_a_rung_for_every_degree_from_breathing_on(seed):
    """Without clamps heave and one mode more a degree."""
    ladder = motion_ladder(varied(seed, designs={"A": {}}), study_basis(seed), "A")
    assert {degree: motions.shape[1] for degree, motions in ladder.items()} == {RIGID: 1} | {n: n + 2 for n in range(7)}


def test_ladder_of_a_rigid_design_has_one_rung(seed):
    assert list(motion_ladder(seed, study_basis(seed), "FSB")) == [RIGID]


@pytest.fixture(scope="module")
def memory(seed, radiation_of):
    return radiation_of(seed)


def test_truncated_memory_is_passive_and_ever_better(memory):
    omega = np.linspace(0.1, 10.0, 100)
    exact = memory.transfer(omega)
    missed = [np.abs(truncated(memory, order).transfer(omega) - exact).max() for order in range(2, memory.order + 1, 4)]
    assert all(late < early for early, late in itertools.pairwise(missed))
    assert truncated(memory, memory.order) is memory
    for order in range(2, memory.order, 2):
        model = truncated(memory, order)  # its construction checks passivity
        assert model.order == order
        assert np.linalg.eigvalsh(model.damping(omega)).min() > -1e-9 * np.abs(exact).max()


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(1, 5))
def test_truncation_of_any_passive_model_is_passive(seed_of_numbers, order):
    rng = np.random.default_rng(seed_of_numbers)
    skew, channel = rng.normal(size=(6, 6)), rng.normal(size=6)
    model = RadiationModel(skew - skew.T - np.outer(channel, channel) / 2, rng.normal(size=(6, 3)), channel)
    small = truncated(model, order)
    defect = small.state_matrix + small.state_matrix.T + np.outer(small.channel, small.channel)
    assert np.abs(defect).max() < 1e-9 * np.abs(small.state_matrix).max()


class Told:
    """Descriptions whose powers are given: modes left out, memory cut, linearity are a factor each, all modes or not."""

    full = Description(3, 8, True)
    ladder = dict.fromkeys([RIGID, 0, 1, 2, 3], np.zeros(0))

    def __init__(self, modes=0.0, memory=0.0, nonlinear=(0.0, 0.0)):
        self.modes, self.memory, self.nonlinear = modes, memory, nonlinear

    def power(self, d):
        cut = self.memory * (d.memory not in (8, automatic.INFINITE))
        lost = self.modes * (d.degree < 3)
        exact = 1 + self.nonlinear[d.degree == 3] if d.body_exact else 1.0
        return 100.0 * (1 + lost) * (1 + cut) / exact

    def power_of_coefficients(self, degree, body_exact):
        return self.power(Description(degree, automatic.INFINITE, body_exact))

    def nonlinear_part(self, d):
        return automatic.relative(self.power(d), self.power(d._replace(body_exact=True)))

    def scene(self, d):
        return d


@pytest.mark.parametrize(
    ("made_of", "description", "left_out"),
    [
        ({}, (RIGID, 2, False), {"memory_beyond_2_states": 0, "shell_modes": 0, "body_exact_forces": 0}),
        ({"modes": 0.05}, (3, 2, False), {"memory_beyond_2_states": 0, "body_exact_forces": 0}),
        ({"memory": 0.05}, (RIGID, 8, False), {"memory_beyond_8_states": 0, "shell_modes": 0, "body_exact_forces": 0}),
        ({"nonlinear": (0.05, 0.05)}, (RIGID, 2, True), {"memory_beyond_2_states": 0, "shell_modes": 0}),
        ({"nonlinear": (0.05, 0.0)}, (3, 2, True), {"memory_beyond_2_states": 0}),
        ({"nonlinear": (0.0, 0.05)}, (3, 2, True), {"memory_beyond_2_states": 0}),
        (
            {"modes": 0.002, "memory": 0.001, "nonlinear": (0.0015, 0.0015)},
            (RIGID, 2, False),
            {"memory_beyond_2_states": 0.001, "shell_modes": 0.002, "body_exact_forces": 0.0015},
        ),
    ],
)  # fmt: skip
def test_each_simplification_is_judged_by_itself_and_said(made_of, description, left_out):
    """Nonlinearity also with the modes left out, through which forces may act."""
    choice = chosen(Told(**made_of), 0.01)
    assert choice.description == description
    assert {item.what: item.error for item in choice.left_out} == pytest.approx(left_out, abs=1e-6)
    assert choice.error == pytest.approx(1.25 * sum(left_out.values()), abs=1e-6)


@pytest.mark.parametrize(
    ("value", "exact", "error"),
    [(0.0, 0.0, 0.0), (3.0, 0.0, 3.0), (3.0, 2.0, 0.5), (-1.0, -2.0, 0.5), (0.0, -2.0, 1.0)],
)
def test_an_error_is_relative_to_what_is_exact_unless_that_is_nothing(value, exact, error):
    assert automatic.relative(value, exact) == error


def test_where_no_power_is_absorbed_everything_is_left_out_without_an_error():
    class Idle(Told):
        def power(self, d):
            return 0.0

    choice = chosen(Idle(), 0.01)
    assert (choice.description, choice.error) == ((RIGID, 2, False), 0.0)


def test_errors_that_work_together_are_more_than_their_sum_and_within_what_is_said():
    scenes = Told(modes=0.07, memory=0.07, nonlinear=(0.07, 0.07))
    choice = chosen(scenes, 0.3)
    together = automatic.relative(scenes.power(choice.description), scenes.power_of_coefficients(3, True))
    assert choice.description == (RIGID, 2, False)
    assert sum(item.error for item in choice.left_out) < together < choice.error < 1.2 * together


def test_notes_of_a_run_say_what_was_left_out(scenes_of):
    choice = chosen(scenes_of("FSB", swell(1e-3, 4.0)), 0.01)
    notes = choice.notes
    assert notes["model"] == "linear"
    assert notes["description"].startswith("linear, rigid, ")
    assert sum(item["error"] for item in json.loads(notes["left_out"])) * automatic.INTERPLAY == notes["power_error"]


def test_a_high_long_wave_wants_its_memory_measured_body_exact(scenes_of):
    """Where linear theory finds two states good enough by half: 0.5 % lost there, 1.3 % body-exact."""
    scenes = scenes_of("FSB", swell(0.36, 6.237), pto={"damping": 558.0})
    choice = chosen(scenes, 0.03)
    whole = steady_power(scenes.system(scenes.full), 1e-8, scenes.buoy.spectrum.transfer)
    assert choice.description.body_exact
    assert abs(scenes.power(choice.description) / whole - 1) <= choice.error


def of_sea(omega, amplitude, duration=1e3, kind=Scenes):
    """Descriptions in a sea, of a buoy of 3 kg and 1 kg of water on 36 N/m: free heave at 3 rad/s."""
    matrices = {"stiffness": [[36.0]], "mass": [[3.0]], "added_mass_inf": [[1.0]]}
    buoy = SimpleNamespace(**{name: np.array(value) for name, value in matrices.items()})
    settings = SimpleNamespace(duration=duration, initial_position=0.1, initial_velocity=0.2)
    waves = Sea(np.array(omega), np.array(amplitude, dtype=complex)) if omega else NO_WAVES
    return kind(buoy, None, SimpleNamespace(order=4), waves, {RIGID: np.eye(1)}, settings)


@pytest.mark.parametrize(
    ("omega", "amplitude", "fastest"),
    [
        ([], [], 3.0),
        ([1.0, 2.0], [1.0, 1.0], 3.0),
        ([1.0, 4.0], [1.0, 0.051j], 4.0),
        ([1.0, 4.0], [-1.0, 0.049], 3.0),
        ([4.0, 5.0], [1.0, 0.0], 4.0),
    ],
)
def test_a_record_has_fifty_instants_in_the_shortest_period_that_matters(omega, amplitude, fastest):
    """Of free heave, or of a wave of a twentieth of the largest or more."""
    assert of_sea(omega, amplitude)._sampling == pytest.approx(2 * np.pi / fastest / 50, rel=1e-12)


@pytest.mark.parametrize(
    ("omega", "amplitude", "duration", "begin", "end"),
    [
        ([1.0, 2.0], [0.5, 1j], 1e3, 10 * np.pi, 40 * np.pi),  # ten to forty periods of the largest component
        ([1.0, 2.0], [0.5, 1j], 60.0, 15.0, 60.0),  # a short run but for its first quarter
        ([1.0, 2.0], [0.5, 1j], 126.0, 10 * np.pi, 40 * np.pi),
        ([1.0, 2.0], [0.5, 1j], 125.0, 125.0 / 4, 125.0),
        ([], [], 60.0, 0.0, 60.0),  # in still water all of it
    ],
)
@pytest.mark.parametrize("linear", [True, False])
def test_what_part_of_a_record_is_compared(monkeypatch, linear, omega, amplitude, duration, begin, end):
    seen = {}

    def followed(system, time, start, *precision):
        seen.update(time=time, start=start, precision=precision)
        return "motion" if linear else ("motion", 1)

    monkeypatch.setattr(automatic, "propagate" if linear else "integrate", followed)
    monkeypatch.setattr(automatic, "absorbed", lambda system, motion, begin: (motion, begin))
    scenes = of_sea(omega, amplitude, duration)
    system = SimpleNamespace(linear=linear, scene=SimpleNamespace(start=lambda x, v: (x, v)))
    assert scenes._recorded_power(system) == ("motion", pytest.approx(begin, rel=1e-12))
    time = seen["time"]
    assert (time[0], time[-1]) == (0.0, pytest.approx(end, rel=1e-12))
    step = scenes._sampling
    assert step * (1 - 2 / len(time)) < time[1] <= step * (1 + 1e-12)
    assert seen["start"] == (0.1, 0.2)
    assert seen["precision"] == (() if linear else (automatic.PRECISION,))


class Measured(Scenes):
    """Powers that tell of what, and whether on a record, they are."""

    def system(self, d):
        return d

    def power(self, d):
        return 8.0 if d.body_exact else 9.0

    def _recorded_power(self, d):
        return 8.0 if d.body_exact else 10.0


@pytest.mark.parametrize(("omega", "error"), [([], 1 / 8), ([1.0], 1 / 8), ([1.0, 2.0], 2 / 8)])
def test_what_is_not_linear_is_measured_on_the_same_record_where_there_is_no_steady_state(omega, error):
    """A linear scene has one in any waves, a body-exact one in regular waves alone."""
    scenes = of_sea(omega, [1.0] * len(omega), kind=Measured)
    assert scenes.nonlinear_part(Description(RIGID, 2, False)) == pytest.approx(error, rel=1e-12)


class Named(Measured):
    """Descriptions in place of the powers they give."""

    def power(self, d):
        return d


@pytest.mark.parametrize("omega", [[], [1.0], [1.0, 2.0]], ids=["still", "regular", "irregular"])
@pytest.mark.parametrize("body_exact", [False, True])
def test_where_coefficients_have_no_steady_motion_to_act_on_the_whole_memory_stands_for_them(
    omega, body_exact, monkeypatch
):
    """In still water, and body-exact in an irregular sea; else in its steady motion, linear by linear theory."""
    found = []
    monkeypatch.setattr(automatic, "steady_power", lambda *given: found.append(given) or 7.0)
    scenes = of_sea(omega, [0.2] * len(omega), kind=Named)
    whole = Description(RIGID, 4, body_exact)
    scenes.buoy.spectrum = SimpleNamespace(transfer="coefficients")
    scenes.buoy.rao = lambda omega, motions: motions[0, 0] * omega
    scenes.buoy.absorbed_power = lambda omega, rao: 100.0 * rao
    power = [scenes.power_of_coefficients(RIGID, body_exact) for _ in range(2)]  # the second time from memory
    steady, linear = len(omega) == 1 and body_exact, len(omega) > 0 and not body_exact
    assert power == 2 * [7.0 if steady else pytest.approx(100.0 * 0.2**2 * sum(omega)) if linear else whole]
    assert found == ([(whole, automatic.PRECISION, "coefficients")] if steady else [])


class Apart(Told):
    """Powers lost at each degree and with so many states, by linear theory and on the wet shell."""

    def __init__(self, modes, states):
        super().__init__(nonlinear=(0.05, 0.05))
        self.modes, self.states = modes, states

    def power(self, d):
        lost = 0.05 * (d.degree < self.modes[d.body_exact])
        cut = 0.02 * (0 <= d.memory < self.states[d.body_exact])
        return 100.0 * (1 + lost) * (1 + cut) / (1.05 if d.body_exact else 1.0)


@pytest.mark.parametrize(
    ("modes", "states", "degree", "memory"),
    [
        ((2, RIGID), (4, 2), 2, 4),  # what linear theory needs stays
        ((RIGID, 1), (2, 6), 1, 6),  # the wet shell needs more
        ((1, 3), (6, 4), 3, 6),
        ((0, 0), (8, 8), 0, 8),
        ((1, 1), (5, 5), 1, 6),  # states come in pairs
    ],
)
def test_on_the_wet_shell_no_less_is_kept_than_linear_theory_needs(modes, states, degree, memory):
    choice = chosen(Apart(modes, states), 0.01)
    assert choice.description == (degree, memory, True)
    lost = {f"memory_beyond_{memory}_states": 0.0} | ({} if degree == 3 else {"modes_above_degree": 0.0})
    assert {item.what: item.error for item in choice.left_out} == lost


def test_what_is_left_out_of_a_body_exact_scene_is_measured_on_the_wet_shell():
    """By linear theory it would be nothing."""

    class Wet(Told):
        def power(self, d):
            cut, lost = 1e-3 * (d.memory == 2), 2e-3 * (d.degree < 3)
            return 100.0 * ((1 + cut + lost) / 1.05 if d.body_exact else 1.0)

    choice = chosen(Wet(), 0.01)
    assert choice.description == (RIGID, 2, True)
    errors = {item.what: item.error for item in choice.left_out}
    expected = {"memory_beyond_2_states": 1e-3 / 1.002, "shell_modes": 2e-3 / 1.001}
    assert errors == {what: pytest.approx(error, rel=2e-3) for what, error in expected.items()}


@pytest.mark.parametrize("error", [ConvergenceError("does not settle"), StabilityError("grows")])
def test_a_body_exact_power_that_cannot_be_had_leaves_the_linear_error_of_the_whole_memory(error):
    """That of all modes: 3 of the coefficients' 100 W."""

    class Lost(Told):
        def power(self, d):
            if d.body_exact:
                raise error
            return 103.0 if d.degree == 3 else 90.0

        def power_of_coefficients(self, degree, body_exact):
            assert not body_exact
            return 100.0 if degree == 3 else 80.0

    choice = chosen(Lost(), 0.5)
    assert (choice.description, choice.scene, choice.unmeasured) == (Told.full, Told.full, str(error))
    assert [tuple(item) for item in choice.left_out] == [("memory_beyond_8_states", pytest.approx(0.03))]
    assert choice.notes["unmeasured"] == str(error)
    assert choice.notes["model"] == "body_exact"


@pytest.mark.parametrize(
    ("description", "text"),
    [
        (Description(RIGID, 4, False), "linear, rigid, 4 memory states"),
        (Description(0, 6, True), "body-exact, shell modes to degree 0, 6 memory states"),
    ],
)
def test_a_description_in_words(description, text):
    assert description.text == text


@pytest.mark.parametrize("body_exact", [True, False])
def test_a_scene_is_of_the_memory_and_the_motions_of_its_description(monkeypatch, body_exact):
    monkeypatch.setattr(automatic, "truncated", lambda model, states: (model, states))
    monkeypatch.setattr(automatic, "linear_scene", lambda *given: given)
    monkeypatch.setattr(automatic, "body_exact_scene", lambda buoy, shape, *given: (buoy, *given, shape))
    scenes = replace(of_sea([1.0], [0.5]), ladder={RIGID: "rigid", 1: "first", 3: "third"}, shape="shape")
    found = scenes.scene(Description(1, 2, body_exact))
    assert found == (scenes.buoy, (scenes.radiation, 2), scenes.sea, "first", *(["shape"] if body_exact else []))
    assert scenes.full == (3, 4, True)


@pytest.mark.parametrize(
    ("omega", "linear", "way"),
    [
        ([], True, "record"), ([], False, "record"), ([1.0], True, "phasors"), ([1.0], False, "balance"),
        ([1.0, 2.0], True, "phasors"), ([1.0, 2.0], False, "record"),
    ],
)  # fmt: skip
def test_a_power_is_that_of_a_steady_state_where_there_is_one(monkeypatch, omega, linear, way):
    system = SimpleNamespace(linear=linear)
    monkeypatch.setattr(automatic, "linear_power", lambda given: ("phasors", given))
    monkeypatch.setattr(automatic, "steady_power", lambda given, precision: ("balance", given, precision))
    monkeypatch.setattr(Scenes, "_recorded_power", lambda scenes, given: ("record", given))
    found = of_sea(omega, [0.2] * len(omega))._power(system)
    assert found == (way, system, *([automatic.PRECISION] if way == "balance" else []))


@pytest.mark.parametrize("body_exact", [True, False])
@pytest.mark.parametrize("unmeasured", ["", "does not settle"])
def test_notes_of_a_choice_are_all_there_is_to_say(body_exact, unmeasured):
    left_out = (automatic.LeftOut("memory_beyond_4_states", 0.002), automatic.LeftOut("shell_modes", 0.01))
    choice = automatic.Choice(Description(RIGID, 4, body_exact), left_out, None, unmeasured)
    assert choice.notes == {
        "model": "body_exact" if body_exact else "linear",
        "description": f"{'body-exact' if body_exact else 'linear'}, rigid, 4 memory states",
        "left_out": '[{"what": "memory_beyond_4_states", "error": 0.002}, {"what": "shell_modes", "error": 0.01}]',
        "power_error": pytest.approx(1.25 * 0.012, rel=1e-12),
    } | ({"unmeasured": unmeasured} if unmeasured else {})


@pytest.mark.parametrize(("losses", "degree"), [
    ({-1: 0.02, 0: 0.004, 1: 0.001, 2: 0.001}, 1), ({-1: 0.02, 0: 0.001, 1: 0.02, 2: 0.001}, 0), ({-1: 0.002}, -1),
    ({-1: 0.02, 0: 0.02, 1: 0.02, 2: 0.004}, 3),
])  # fmt: skip
def test_the_lowest_rung_within_a_third_of_the_tolerance_is_taken(losses, degree):
    """Of 0.01 over 3 and the interplay 1.25, 0.00267, each."""

    class Rungs(Told):
        ladder = dict.fromkeys([3, 1, RIGID, 2, 0], np.zeros(0))  # told in any order

        def power(self, d):
            return 100.0 * (1 + losses.get(d.degree, 0.0))

    choice = chosen(Rungs(), 0.01)
    assert choice.description == (degree, 2, False)
    what = {"shell_modes" if degree == RIGID else "modes_above_degree": losses.get(degree)} if degree < 3 else {}
    errors = {item.what: item.error for item in choice.left_out}
    assert errors == pytest.approx({"memory_beyond_2_states": 0.0, **what, "body_exact_forces": 0.0}, abs=1e-12)


@pytest.mark.parametrize(("cut", "memory"), [
    ({2: 0.01, 4: 0.001, 6: 0.01}, 4), ({2: 0.01, 4: 0.01, 6: 0.0027}, 8), ({2: 0.01, 4: 0.01, 6: 0.0026}, 6),
    ({2: -0.01, 4: -0.002}, 4),
])  # fmt: skip
def test_the_fewest_states_within_a_third_of_the_tolerance_are_taken_two_by_two(cut, memory):
    class States(Told):
        def power(self, d):
            assert d.memory in (2, 4, 6, 8, automatic.INFINITE)
            return 100.0 * (1 + cut.get(d.memory, 0.0))

    choice = chosen(States(), 0.01)
    assert choice.description == (RIGID, memory, False)
    assert choice.left_out[0] == (f"memory_beyond_{memory}_states", pytest.approx(abs(cut.get(memory, 0.0)), abs=1e-12))


@pytest.mark.parametrize("begin", [0.5, 1.0])
def test_the_mean_power_of_a_record_is_of_all_degrees_of_freedom_by_its_own_instants(begin):
    """Velocities of a design's motions, some of them before the time it is taken from; steps are unequal."""
    time = np.array([0.0, 1.0, 1.5, 3.0, 7.0])
    motions = np.array([[1.0, 0.0], [0.5, -2.0], [0.0, 3.0]])
    velocity = np.array([[9.0, 9.0], [1.0, -1.0], [0.5, 2.0], [-2.0, 0.0], [1.0, 1.0]])
    scene = SimpleNamespace(lost=lambda v: (v**2 @ np.array([1.0, 10.0, 100.0]), None), motions=motions)
    power = [(motions @ v) ** 2 @ [1.0, 10.0, 100.0] for v in velocity]
    mean = (0.25 * (power[1] + power[2]) + 0.75 * (power[2] + power[3]) + 2.0 * (power[3] + power[4])) / 6.0
    found = automatic.absorbed(SimpleNamespace(scene=scene), SimpleNamespace(time=time, velocity=velocity), begin)
    assert found == pytest.approx(mean, rel=1e-14)


def test_linear_power_is_half_of_what_both_parts_of_every_phasor_lose(monkeypatch):
    """Of the velocities alone, which stand behind the positions, in the shapes of the design."""
    phasors = np.array([[5.0, 7.0, 1.0 + 2j, -3j, 9.0], [5j, 7.0, -0.5, 1.0 - 1j, 9.0]])
    shapes, damping = np.array([[1.0, 0.5], [0.0, 2.0], [-1.0, 1.0]]), np.diag([1.0, 10.0, 100.0])
    monkeypatch.setattr(automatic, "steady_state", lambda system: phasors)
    scene = SimpleNamespace(lost=lambda v: (np.einsum("ij,jk,ik->i", v, damping, v), None))
    velocity = phasors[:, 2:4] @ shapes.T
    expected = sum(0.5 * (v.conj() @ damping @ v).real for v in velocity)
    assert linear_power(SimpleNamespace(free=2, shapes=shapes, scene=scene)) == pytest.approx(expected, rel=1e-14)
