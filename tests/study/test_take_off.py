"""Law, limits, port and damping of the take-off in a study file."""

import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load, parse
from vsb.study.take_off import Pto, port_kind


@pytest.fixture(scope="module")
def seed():
    return load(SEED)


@pytest.mark.parametrize("law", ["saturated", "coulomb"])
def test_laws_with_a_limit_need_it(seed, law):
    with pytest.raises(ConfigError, match=f"pto: force_limit: missing; law {law} needs one in N"):
        varied(seed, pto={"law": law})


def test_automatic_model_cannot_follow_a_law(seed):
    wrong = (
        "pto: received law saturated with force_limit 3000 N and stroke_limit inf m, for which hydro.model 'auto' "
        "cannot choose; needs hydro.model: linear or body_exact, or law: linear without limits"
    )
    keys = {"law": "saturated", "force_limit": 3e3}
    with pytest.raises(ConfigError, match=wrong):
        varied(seed, pto=keys, hydro={"model": "auto"})
    for model in ("linear", "body_exact"):
        assert varied(seed, pto=keys, hydro={"model": model}).pto.law == "saturated"


# tuning -------------------------------------------------------------------------------------------------------------

SEA = {"kind": "jonswap", "hs": 0.5, "tp": 4.0, "realisations": 2}
SWELL, STILL = {"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "still"}


@pytest.mark.parametrize(
    ("keys", "form"),
    [
        ({}, '{"tuning":"each"}'),
        ({"tuning": "one"}, '{"tuning":"one"}'),
        ({"damping": 8000, "tuning": "each"}, '{"damping":8000.0,"tuning":"each"}'),
        ({"damping": {"B": 2, "A": 1}}, '{"damping":{"A":1.0,"B":2.0}}'),
        ({"damping": 1, "stiffness": -3, "efficiency": 0.8}, '{"damping":1.0,"efficiency":0.8,"stiffness":-3.0}'),
        (
            {"damping": 1, "port": {"colatitude": 90}},
            '{"damping":1.0,"port":{"against":"sea_bed","colatitude":90.0,"direction":"vertical"}}',
        ),
    ],
)
def test_canonical_form_of_the_take_off(keys, form):
    """Without a damping it is tuned; keys at their default are absent."""
    pto = Pto(**keys)
    assert canonical(pto) == form
    assert Pto(**pto.model_dump()) == pto


GAS = {"gas": {"adiabatic_index": 1.4}}


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [({"damping": -1}, r"pto.damping: received -1; needs a number of at least 0"),
        ({"damping": {"FSB": 1}}, r"pto.damping: received dampers of FSB, needs one for every design: FSB, VSWEC"),
        ({"damping": None, "tuning": "fixed"}, r"pto: damping: missing; tuning fixed needs one in N s/m"),
        ({"tuning": "best"}, r"pto.tuning: received 'best'; needs 'fixed', 'each' or 'one'"),
        ({"efficiency": 1.1}, r"pto.efficiency: received 1.1; needs a number of at most 1"),
        ({"port": "sway"}, r"pto.port: received 'sway'; needs 'heave', 'surge', 'pitch' or 'volume'")],
)  # fmt: skip
def test_errors_of_the_take_off(seed, keys, wrong):
    raw = {**seed.model_dump(), "pto": keys, "designs": {"FSB": {"flexible": False}, "VSWEC": {}}}
    with pytest.raises(ConfigError, match=wrong):
        parse(raw)


@pytest.mark.parametrize(
    ("changes", "wrong"),
    [
        (
            {"pto": {"damping": None}, "hydro": {"model": "assumed_pressure", "pressure": 9.0}},
            r"pto.tuning 'each': an assumed pressure does not answer to the motion, so no damper is best; needs",
        ),
        (
            {"pto": {"port": "volume"}, "hydro": {"model": "body_exact"}},
            r"pto.port: hydro.model 'body_exact' has no other port than heave and those at points of the shell; needs",
        ),
        (
            {"pto": {"port": {"between": [0, 180]}}, "hydro": {"model": "auto"}},
            r"pto.port: hydro.model 'auto' has no other port than heave; needs hydro.model: linear",
        ),
        (
            {"pto": {"port": "volume", "force_limit": 9.0}, "device": GAS},
            r"pto.port 'volume': behind the gas .* a flow without inertia, not the shell's: .* needs law: linear .* no device.gas",
        ),
    ],
)
def test_combinations_a_model_cannot_compute(seed, changes, wrong):
    with pytest.raises(ConfigError, match=wrong):
        varied(seed, **changes)


@pytest.mark.parametrize(("tuning", "wave"), [("each", "still"), ("one", "still")])
def test_still_water_needs_a_given_damping(seed, tuning, wave):
    study = varied(seed, pto={"damping": None, "tuning": tuning}, waves=[STILL])
    with pytest.raises(
        ConfigError, match=r"waves.0 still: no damper is best where nothing comes in; needs pto.damping"
    ):
        study.check_dampers()
    varied(study, pto={"damping": 8000.0}).check_dampers()


def test_damping_of_a_run(seed):
    """Per design its own, for all seas a realisation of each, in still water the given one."""
    designs, dampers = {"A": {"flexible": False}, "B": {}}, {"A": 1.0, "B": 2.0}
    study = varied(seed, designs=designs, pto={"damping": dampers}, waves=[SEA, SWELL, STILL])
    sea, again, swell, still = study.waves

    def pto(design, wave, **keys):
        return StudyPlan(varied(study, pto=keys)).simulation(design, wave).pto.model_dump()

    assert pto("B", sea) == {"damping": 2.0}
    assert pto("B", sea, tuning="each") == {"tuning": "each"}
    assert pto("B", still, tuning="each") == {"damping": 2.0}
    assert pto("B", still, tuning="one") == {"tuning": "one"}
    one = StudyPlan(varied(study, pto={"tuning": "one"})).simulation("A", again)
    assert one.seas == (sea, swell)
    assert StudyPlan(varied(study, pto={"tuning": "each"})).simulation("A", again).seas == ()


@pytest.mark.parametrize(
    ("port", "unit"),
    [("heave", "N s/m"), ("surge", "N s/m"), ("pitch", "N m s"), ("volume", "Pa s/m^3"), ({"colatitude": 90.0}, "N s/m"),
     ({"dofs": {"Pitch": 1.0}}, "N m s"), ({"dofs": {"float__Roll": 1.0, "spar__Pitch": -1.0}}, "N m s"),
     ({"dofs": {"float__Pitch": 1.0, "float__Heave": 2.0}}, "N s/m")],
    ids=str,
)  # fmt: skip
def test_unit_of_damping_follows_the_port(port, unit):
    assert port_kind(port).damping_unit == port_kind(Pto(port=port).port).damping_unit == unit


def test_zero_damping_is_a_given_damping():
    assert Pto(damping=0.0).idle
    assert Pto(damping=0.0).tuning == "fixed"
    assert Pto(damping={"FSB": 5.0, "VSWEC": 0.0}).idle
    assert not Pto(damping={"FSB": 5.0, "VSWEC": 1.0}).idle
    assert not Pto().idle
    assert Pto(damping=None).tuning == "each"
    with pytest.raises(ConfigError, match="damping: missing; tuning fixed needs one in N s/m"):
        Pto(tuning="fixed", stiffness=5.0)
