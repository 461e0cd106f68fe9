"""What must not change the numbers of a run: limits out of reach, another window, other names."""

import re

import pytest
import yaml
from conftest import one_figure, tables_of
from stages.test_invariance import barge

import vsb
from vsb.engine.hydro.database import save_database
from vsb.pipeline.graph import BodyPlan, StudyPlan
from vsb.stages.side_by_side import lines
from vsb.study.body import load_body
from vsb.study.study import parse
from vsb.tools.words import power

STUDY = {
    "study": "plain",
    "device": {
        "radius": 2.0,
        "thickness": 0.015,
        "young_modulus": 4e7,
        "poisson_ratio": 0.3,
        "density": 1100.0,
        "mass": 17170.0,
    },
    "modes": {"basis": "full", "degree": 4},
    "designs": {"FSB": {"flexible": False}},
    "hydro": {"tolerance": 2e-3, "witness": "none", "omega_max": 8.0},
    "pto": {"damping": 9000.0, "stiffness": -15000.0},
    "waves": [
        {"kind": "jonswap", "hs": 0.6, "tp": 4.0, "seed": 3},
        {"kind": "regular", "amplitude": 0.2, "period": 3.0},
    ],
    "simulation": {"duration": 61.7, "window": [40.0, 61.7]},
}
OF_RECORD = ("displacement_pp", "velocity_pp", "power_peak", "energy", "record_power_mean")
OF_SEA = ("power_mean", "power_low", "power_high", "capture_width")


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Function changes -> comparison by design and sea; all in one folder, whose coefficients are shared."""
    folder = tmp_path_factory.mktemp("metamorphic")

    def found(name, **changes):
        study = parse({**STUDY, "study": name, **changes})
        if changes:
            results = tables_of(StudyPlan(study, root=str(folder)))
        else:
            with one_figure():
                results = vsb.run(study, folder)
        table = results.comparison.set_index(["design", "wave"])
        table.attrs["results"] = results
        return table

    return found


@pytest.fixture(scope="module")
def plain(table):
    return table("plain")


def test_every_surface_shows_one_power_with_its_interval(plain):
    """Table, control levels, page, comparison of studies and the words of notebooks, of one buoy without a gain."""
    results = plain.attrs["results"]
    ladder = results.ladder.set_index(["design", "wave", "rung"])
    compared = {(one.design, one.sea, one.tuning): one for one in lines([results.plan])}
    page = re.sub("<[^>]+>", "", results.report.read_text(encoding="utf-8"))
    for (design, label), row in plain.iterrows():
        shown = (row.power_mean, row.power_low, row.power_high)
        sea = next(wave.family for wave in results.study.waves if wave.label == label)
        level, line = ladder.loc[design, label, "fixed"], compared[design, sea, "fixed"]
        assert (level.power_mean, level.low, level.high) == pytest.approx(shown, rel=1e-9)
        assert (line.power_mean, line.power_low, line.power_high) == pytest.approx(shown, rel=1e-9)
        assert f"{design} absorbs" in page
        assert power(*shown) in page
        best = ladder.loc[design, label, "best_damper"]
        line = compared[design, sea, "each"]
        shown = (best.power_mean, best.low, best.high)
        assert (line.power_mean, line.power_low, line.power_high) == pytest.approx(shown, rel=1e-9)
        assert power(*shown) in page
    most = ladder.xs("best_damper", level="rung").power_mean.idxmax()
    best = ladder.loc[(*most, "best_damper")]
    assert power(best.power_mean, best.low, best.high) in repr(results)


LIMITS = {"stroke_limit": 50.0, "law": "saturated", "force_limit": 1e8}


def test_limits_that_are_never_reached_change_nothing(table, plain):
    """The spring, whose reactive power is not absorbed, among it."""
    found = table("limits", pto=STUDY["pto"] | LIMITS)
    for column in (*OF_RECORD, *OF_SEA):
        assert found[column].values == pytest.approx(plain[column].values, rel=1e-6), column


def test_peak_power_is_that_of_the_damper(plain):
    """c v^2 of the largest velocity: at most c times the square of the peak-to-peak velocity."""
    assert (plain.power_peak <= 9000.0 * plain.velocity_pp**2).all()
    assert (plain.power_peak >= 9000.0 * plain.velocity_pp**2 / 4).all()


def test_a_window_a_period_later_changes_the_record_alone(table, plain):
    """In a regular wave not even that, once transients are over."""
    later = table("later", simulation={"duration": 64.7, "window": [43.0, 64.7]})
    for column in OF_SEA:
        assert later[column].values == pytest.approx(plain[column].values, rel=1e-9), column
    for column in ("displacement_pp", "velocity_pp", "power_peak", "record_power_mean"):
        regular = [one[column].values[1] for one in (later, plain)]
        assert regular[0] == pytest.approx(regular[1], rel=2e-3), column
    assert later.record_power_mean.values[0] != pytest.approx(plain.record_power_mean.values[0], rel=1e-2)


def test_mean_power_does_not_depend_on_the_seed_nor_on_the_length_of_the_record(table, plain):
    waves = [STUDY["waves"][0] | {"seed": 8}]
    other = table("other", waves=waves, simulation={"duration": 20.0, "window": [10.0, 20.0]})
    for column in OF_SEA:
        assert other[column].values[0] == pytest.approx(plain[column].values[0], rel=1e-9), column


def test_designs_in_another_order_under_other_names_have_the_same_numbers(table, plain):
    designs = {"Z": {"flexible": False}, "A": {"flexible": False}}
    found = table("renamed", designs=designs)
    for name in designs:
        for column in (*OF_RECORD, *OF_SEA):
            assert found.loc[name][column].values == pytest.approx(plain.loc["FSB"][column].values, rel=1e-9), column
    assert found.power_gain_percent.abs().max() < 1e-9


# a body ---------------------------------------------------------------------------------------------------------------

SPRING = 4e5
BARGE = {
    "study": "barge",
    "body": {"database": "barge.nc", "stiffness": {"Surge": 8e5}, "damping": {"Heave": 4e5}},
    "water": {"density": 1000.0},
    "designs": {"rigid": {"dofs": ["Heave", "Pitch", "Surge"]}, "flexible": {}},
    "pto": {"port": {"dof": "Heave"}, "damping": 8e5, "stiffness": SPRING},
    "waves": [
        {"kind": "jonswap", "hs": 1.2, "tp": 9.0, "seed": 2},
        {"kind": "regular", "amplitude": 0.5, "period": 8.0},
    ],
    "simulation": {"duration": 240.0, "window": [160.0, 240.0]},
}


@pytest.fixture(scope="module")
def of_barge(tmp_path_factory):
    """Function name, changes -> comparison by design and sea of a barge known by its database."""
    folder = tmp_path_factory.mktemp("barge")
    save_database(barge(), None, folder / "barge.nc")

    def found(name, **changes):
        path = folder / f"{name}.yaml"
        path.write_text(yaml.safe_dump({**BARGE, "study": name, **changes}))
        located = load_body(path)
        plan = BodyPlan(located.study, root=str(folder / "results"), files=located.files)
        return tables_of(plan).comparison.set_index(["design", "wave"])

    return found


@pytest.fixture(scope="module")
def plain_barge(of_barge):
    return of_barge("plain")


def test_a_spring_moved_from_the_take_off_to_the_mooring_changes_no_power(of_barge):
    """What holds the body does not matter to its motion, and a spring absorbs nothing."""
    moored = BARGE["body"] | {"stiffness": {"Surge": 8e5, "Heave": SPRING}}
    short = {"simulation": {"duration": 60.0, "window": [30.0, 60.0]}, "designs": {"flexible": {}}}
    short["waves"] = BARGE["waves"][:1]
    plain = of_barge("short", **short)
    found = of_barge("moored", body=moored, pto=BARGE["pto"] | {"stiffness": 0.0}, **short)
    for column in (*OF_RECORD, *OF_SEA):
        assert found[column].values == pytest.approx(plain[column].values, rel=1e-6), column


@pytest.mark.slow
def test_limits_that_a_body_never_reaches_change_nothing(of_barge, plain_barge):
    found = of_barge("limits", pto=BARGE["pto"] | LIMITS)
    for column in (*OF_RECORD, *OF_SEA):
        assert found[column].values == pytest.approx(plain_barge[column].values, rel=1e-6), column


@pytest.mark.slow
def test_a_window_a_period_later_changes_nothing_of_a_body_in_a_regular_wave(of_barge, plain_barge):
    """But the energy, which is of the whole run: that of a period more, to what is left of transients."""
    later = of_barge("later", simulation={"duration": 248.0, "window": [168.0, 248.0]})
    regular = [one.xs("regular_A0.5_T8", level="wave") for one in (later, plain_barge)]
    for column in (*OF_RECORD, *OF_SEA):
        if column != "energy":
            assert regular[0][column].values == pytest.approx(regular[1][column].values, rel=2e-3), column
    more = regular[0]["energy"] - regular[1]["energy"]
    assert more.values == pytest.approx(8.0 * regular[1]["power_mean"].values, rel=1e-2)
    for column in OF_SEA:
        assert later[column].values == pytest.approx(plain_barge[column].values, rel=1e-9), column
