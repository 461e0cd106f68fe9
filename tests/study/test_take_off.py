"""Law and limits of the take-off in a study file."""

import jsonschema
import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.report.page import BODY_MEASURES, MEASURES
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load, parse
from vsb.study.take_off import DofPort, Pto, at_port, damper_unit


@pytest.fixture(scope="module")
def seed():
    return load(SEED)


def test_a_take_off_of_before_keeps_its_canonical_form(seed):
    """Keys at their default are not there: results of before keep their names."""
    assert canonical(seed.pto) == '{"damping":8000.0}'
    assert not seed.pto.switches


@pytest.mark.parametrize(
    ("keys", "form"),
    [
        ({"force_limit": 3e3}, '{"damping":8000.0,"force_limit":3000.0}'),
        ({"stroke_limit": 0.5}, '{"damping":8000.0,"stroke_limit":0.5}'),
        ({"law": "coulomb", "force_limit": 3e3}, '{"damping":8000.0,"force_limit":3000.0,"law":"coulomb"}'),
    ],
)
def test_a_law_is_part_of_the_canonical_form_and_comes_back(seed, keys, form):
    study = varied(seed, pto=keys)
    assert canonical(study.pto) == form
    assert Pto(**study.pto.model_dump()) == study.pto
    assert study.pto.switches


@pytest.mark.parametrize("law", ["saturated", "coulomb"])
def test_laws_of_a_limit_need_it(seed, law):
    with pytest.raises(ConfigError, match=f"pto: force_limit: missing; law {law} needs one in N"):
        varied(seed, pto={"law": law})


@pytest.mark.parametrize("keys", [{"force_limit": 0.0}, {"stroke_limit": -1.0}])
def test_limits_are_positive(seed, keys):
    (key,) = keys
    with pytest.raises(ConfigError, match=f"pto.{key}: received .*needs a number above 0"):
        varied(seed, pto=keys)


def test_a_model_that_cannot_follow_a_law_is_refused(seed):
    wrong = (
        "pto: received law saturated with force_limit 3000 N and stroke_limit inf m, for which hydro.model 'auto' "
        "cannot choose; needs hydro.model: linear or body_exact, or law: linear without limits"
    )
    keys = {"law": "saturated", "force_limit": 3e3}
    with pytest.raises(ConfigError, match=wrong):
        varied(seed, pto=keys, hydro={"model": "auto"})
    for model in ("linear", "body_exact"):
        assert varied(seed, pto=keys, hydro={"model": model}).pto.law == "saturated"


@pytest.mark.parametrize("law", ["latching", "declutching"])
def test_laws_that_pause_need_no_limit_but_waves(seed, law):
    study = varied(seed, pto={"law": law})
    assert study.pto.pauses
    assert study.pto.switches
    assert canonical(study.pto) == f'{{"damping":8000.0,"law":"{law}"}}'
    assert not seed.pto.pauses
    with pytest.raises(
        ConfigError, match=rf"pto.law '{law}': how long it pauses is found in waves, which hydro.model "
    ):
        varied(study, hydro={"model": "assumed_pressure", "pressure": 100.0})


def test_a_method_that_cannot_follow_a_law_is_refused(seed):
    with pytest.raises(
        ConfigError, match=r"simulation.method .exact.: cannot follow a take-off that switches; needs a"
    ):
        varied(seed, pto={"stroke_limit": 0.5}, simulation={"method": "exact"})


# tuning -------------------------------------------------------------------------------------------------------------

SEA = {"kind": "jonswap", "hs": 0.5, "tp": 4.0, "realisations": 2}
SWELL, STILL = {"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "still"}


@pytest.mark.parametrize(
    ("keys", "form"),
    [
        ({}, '{"tuning":"each"}'),
        ({"damping": None}, '{"tuning":"each"}'),
        ({"tuning": "one"}, '{"tuning":"one"}'),
        ({"damping": 8000, "tuning": "fixed"}, '{"damping":8000.0}'),
        ({"damping": 8000, "tuning": "each"}, '{"damping":8000.0,"tuning":"each"}'),
        ({"damping": {"B": 2, "A": 1}}, '{"damping":{"A":1.0,"B":2.0}}'),
        ({"damping": 1, "stiffness": -3, "efficiency": 0.8}, '{"damping":1.0,"efficiency":0.8,"stiffness":-3.0}'),
        (
            {"damping": 1, "port": {"colatitude": 90}},
            '{"damping":1.0,"port":{"against":"sea_bed","colatitude":90.0,"direction":"vertical"}}',
        ),
        ({"damping": 1, "port": "heave", "stiffness": 0, "efficiency": 1}, '{"damping":1.0}'),
    ],
)
def test_what_is_meant_stands_in_the_canonical_form(keys, form):
    """Without a damping tuning decides, and says so; keys at their default are absent."""
    pto = Pto(**keys)
    assert canonical(pto) == form
    assert Pto(**pto.model_dump()) == pto


GAS = {"gas": {"adiabatic_index": 1.4}}


def test_a_take_off_of_the_volume_opens_the_chamber(seed):
    assert varied(seed, pto={"port": "volume"}, device=GAS).opens_chamber
    assert not varied(seed, pto={"port": "volume"}).opens_chamber
    assert not varied(seed, device=GAS).opens_chamber


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [
        ({"damping": -1}, r"pto.damping: received -1; needs a number of at least 0"),
        ({"damping": {"FSB": -1}}, r"pto.damping.FSB: received -1; needs a number of at least 0"),
        ({"damping": {"FSB": 1}}, r"pto.damping: received dampers of FSB, needs one for every design: FSB, VSWEC"),
        ({"damping": {}}, r"pto.damping: received dampers of no design, needs one for every design: FSB, VSWEC"),
        ({"damping": None, "tuning": "fixed"}, r"pto: damping: missing; tuning fixed needs one in N s/m"),
        ({"tuning": "best"}, r"pto.tuning: received 'best'; needs 'fixed', 'each' or 'one'"),
        ({"stiffness": float("inf")}, r"pto.stiffness: received inf; needs a finite number"),
        ({"stiffness": -1e13}, r"pto.stiffness: received -10000000000000.0; needs at least -1e\+12 N/m, because a spring that holds"),
        ({"efficiency": 1.1}, r"pto.efficiency: received 1.1; needs a number of at most 1"),
        ({"efficiency": 0}, r"pto.efficiency: received 0; needs a number above 0"),
        ({"port": "sway"}, r"pto.port: received 'sway'; needs 'heave', 'surge', 'pitch' or 'volume'"),
    ],
)  # fmt: skip
def test_a_take_off_that_makes_no_sense_is_one_line(seed, keys, wrong):
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
        (
            {"pto": {"port": "volume"}, "device": GAS, "simulation": {"method": "convolution"}},
            r"simulation.method 'convolution': knows no chamber's pressure beside the motion's past; needs auto",
        ),
        (
            {"pto": {"damping": {"FSB": 0.0, "VSWEC": 1.0, "VSWEC0": 1.0, "VSWEC90": 1.0}}, "hydro": {"model": "auto"}},
            r"hydro.model 'auto': judges by mean absorbed power; needs pto.damping above 0",
        ),
    ],
)
def test_what_a_model_cannot_do_with_a_take_off_is_refused(seed, changes, wrong):
    with pytest.raises(ConfigError, match=wrong):
        varied(seed, **changes)


@pytest.mark.parametrize(("tuning", "wave"), [("each", "still"), ("one", "still")])
def test_where_nothing_comes_in_no_damper_is_best(seed, tuning, wave):
    study = varied(seed, pto={"damping": None, "tuning": tuning}, waves=[STILL])
    with pytest.raises(
        ConfigError, match=r"waves.0 still: no damper is best where nothing comes in; needs pto.damping"
    ):
        study.check_dampers()
    varied(study, pto={"damping": 8000.0}).check_dampers()


def test_a_run_knows_its_own_damper_or_how_to_find_it(seed):
    """Of a damper per design its own, of one for all seas a realisation of each, in still water the given one."""
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


def test_a_damper_of_each_design_makes_the_runs_of_one_for_all(seed):
    same = varied(seed, pto={"damping": dict.fromkeys(seed.designs, 8000.0)})
    for design in seed.designs:
        wave = seed.waves[0]
        assert StudyPlan(same).simulation(design, wave) == StudyPlan(seed).simulation(design, wave)


@pytest.mark.parametrize(
    ("port", "on_shell"), [("heave", False), ("volume", False), ({"colatitude": 90}, True), ({"between": [0, 180]}, True)]
)  # fmt: skip
def test_a_shell_moved_by_the_water_as_it_is_has_ports_at_its_points(seed, port, on_shell):
    assert Pto(damping=1.0, port=port).on_shell == on_shell
    if port != "volume":
        assert varied(seed, pto={"port": port}, hydro={"model": "body_exact"}).pto.on_shell == on_shell


def test_a_port_between_two_points_needs_two():
    with pytest.raises(ConfigError, match=r"between.*needs two different colatitudes"):
        parse({**load(SEED).model_dump(), "pto": {"damping": 8000.0, "port": {"between": [30.0, 30.0]}}})


def test_a_take_off_of_the_volume_is_spoken_of_in_pressures_and_of_a_rotation_in_moments():
    """And of any other in forces, as it is written."""
    said = ["damper [N s/m]", "rms force [kN]", "rms force of the take-off [kN]", "gain [%]"]
    assert [at_port(text, "heave") for text in said] == said
    assert [at_port(text, "volume") for text in said] == [
        "damper [Pa s/m³]", "rms pressure [kPa]", "rms pressure of the take-off [kPa]", "gain [%]"
    ]  # fmt: skip
    for port in ("pitch", {"dofs": {"fore__Pitch": 1.0, "aft__Pitch": -1.0}}, DofPort(dofs={"Roll": 1.0})):
        assert [at_port(text, port) for text in said] == [
            "damper [N m s]", "rms moment [kN m]", "rms moment of the take-off [kN m]", "gain [%]"
        ]  # fmt: skip
        assert damper_unit(port) == "N m s"
    for port in ({"dofs": {"Heave": 1.0, "Pitch": -40.0}}, {"line_to": (20.0, -50.0)}, "surge"):
        assert [at_port(text, port) for text in said] == said


def test_what_moves_at_a_port_that_turns_is_told_in_radians():
    """All a page of a body says of its port's motion; heave of a buoy that is held by a moment stays in metres."""
    heads = [head for _, head, *_ in BODY_MEASURES[:2]]
    assert [at_port(head, {"dofs": {"Pitch": 1.0}}) for head in heads] == [
        "port, peak to peak [rad]",
        "port's velocity, peak to peak [rad/s]",
    ]
    assert [at_port(head, {"dofs": {"Pitch": -40.0, "Heave": 1.0}}) for head in heads] == heads
    assert [at_port(head, "pitch") for _, head, *_ in MEASURES[:2]] == [
        "heave, peak to peak [m]",
        "velocity, peak to peak [m/s]",
    ]


def test_points_of_the_shell_may_be_given_from_below_and_shares_may_cancel():
    assert Pto(port={"between": [170.0, 20.0]}).port.between == (170.0, 20.0)
    with pytest.raises(ValueError, match="needs two different colatitudes"):
        Pto(port={"between": [20.0, 20.0]})
    assert Pto(port={"dofs": {"float__Heave": 1.0, "spar__Heave": -1.0}}).port.dofs["spar__Heave"] == -1.0
    with pytest.raises(ValueError, match="needs a share that is not zero"):
        Pto(port={"dofs": {"float__Heave": 0.0, "spar__Heave": 0.0}})


def test_one_degree_of_freedom_stands_for_itself_alone():
    assert DofPort.model_validate({"dof": "Pitch"}) == DofPort(dofs={"Pitch": 1.0})
    editor = jsonschema.Draft202012Validator(DofPort.model_json_schema())
    for port, valid in (
        ({"dof": "Pitch"}, True),
        ({"dofs": {"a": 1.0}}, True),
        ({"dof": 3}, False),
        ({"dofs": 3}, False),
    ):
        assert editor.is_valid(port) is valid
    for more in ({"dofs": {"Heave": 2.0}}, {"share": 2.0}):
        with pytest.raises(ValueError, match="Extra inputs are not permitted"):
            DofPort.model_validate({"dof": "Pitch", **more})


def test_a_line_without_its_anchor_misses_it(seed):
    with pytest.raises(ConfigError, match=r"pto.port.line_to: missing, but required"):
        varied(seed, pto={"port": {"line_from": [0.0, -1.0]}})


@pytest.mark.parametrize(
    ("port", "unit"),
    [("heave", "N s/m"), ("surge", "N s/m"), ("pitch", "N m s"), ("volume", "Pa s/m³"), ({"colatitude": 90.0}, "N s/m"),
     ({"dofs": {"Pitch": 1.0}}, "N m s"), ({"dofs": {"float__Roll": 1.0, "spar__Pitch": -1.0}}, "N m s"),
     ({"dofs": {"float__Pitch": 1.0, "float__Heave": 2.0}}, "N s/m")],
    ids=str,
)  # fmt: skip
def test_a_damper_is_of_a_moment_where_all_that_moves_turns(port, unit):
    """As a file says the port, and as a study has it."""
    assert damper_unit(port) == damper_unit(Pto(port=port).port) == unit


def test_what_is_said_of_a_force_is_said_of_a_moment():
    said = "port's displacement [m], port's velocity [m/s], port, peak to peak [m], rms force [kN], limit of force [kN]"
    turned = "port's rotation [rad], port's velocity [rad/s], port, peak to peak [rad], rms moment [kN m], limit of moment [kN m]"
    assert at_port(said, "pitch") == turned
    assert at_port(said, "heave") == said
    assert at_port("rms force [kN], limit of force [kN]", "volume") == "rms pressure [kPa], limit of pressure [kPa]"
    page = "the take-off's force of ${short(force / 1e3)} kN at 5 N s/m"
    assert at_port(page, "volume") == "the take-off's pressure of ${short(force / 1e3)} kPa at 5 Pa s/m³"
    assert at_port(page, "pitch") == "the take-off's moment of ${short(force / 1e3)} kN m at 5 N m s"


def test_a_take_off_is_limited_by_either_limit_and_switches_by_law_or_limit():
    for keys, limited, switches, pauses in (
        ({}, False, False, False),
        ({"force_limit": 1e3}, True, True, False),
        ({"stroke_limit": 0.5}, True, True, False),
        ({"law": "latching"}, False, True, True),
        ({"law": "declutching"}, False, True, True),
        ({"law": "coulomb", "force_limit": 1e3}, True, True, False),
    ):
        pto = Pto(damping=1.0, **keys)
        assert (pto.limited, pto.switches, pto.pauses) == (limited, switches, pauses)
    for law in ("saturated", "coulomb"):
        with pytest.raises(ValueError, match=f"force_limit: missing; law {law} needs one in N"):
            Pto(damping=1.0, law=law, stroke_limit=0.5)


def test_a_damper_of_zero_is_given_and_idle_whichever_design_has_it():
    assert Pto(damping=0.0).idle
    assert Pto(damping=0.0).tuning == "fixed"
    assert Pto(damping={"FSB": 5.0, "VSWEC": 0.0}).idle
    assert not Pto(damping={"FSB": 5.0, "VSWEC": 1.0}).idle
    assert not Pto().idle
    assert Pto(damping=None).tuning == "each"
    with pytest.raises(ValueError, match="damping: missing; tuning fixed needs one in N s/m"):
        Pto(tuning="fixed", stiffness=5.0)
