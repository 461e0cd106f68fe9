"""Law, limits, port and damping of the take-off in a study file."""

import pytest
from conftest import varied

from vsb.engine.motion.take_off import Pto, port_kind, positive_semidefinite
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical
from vsb.pipeline.graph import StudyPlan
from vsb.study.study import parse

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


TWO = {"ports": {"heave": "heave", "shell": {"strain": "area"}}, "damping": None}
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
            r"pto.tuning 'each': an assumed pressure has no optimal damping; needs",
        ),
        ({"pto": {"port": "volume"}, "hydro": {"model": "body_exact"}}, r"pto.port: hydro.model 'body_exact' has no"),
        ({"pto": {"port": {"strain": "hoop", "belt": [90, 30]}}}, r"pto.port.belt: received .90, 30.; needs two"),
        ({"pto": TWO | {"damping": [[1.0, 0.0]]}}, r"damping: needs 2 rows of 2 numbers, one for each port"),
        ({"pto": TWO | {"damping": [[1.0, 2.0], [0.0, 9.0]]}}, r"damping: needs a symmetric matrix"),
        ({"pto": TWO | {"damping": [[1.0, 2.0], [2.0, 3.0]]}}, r"damping: needs a matrix without negative eigenvalues"),
        ({"pto": TWO | {"damping": 8000.0}}, r"pto.port.damping|damping"),
        ({"pto": TWO | {"stiffness": 3.0}}, r"several ports, or a damper spread over the shell, have a damper matrix"),
        (
            {"pto": TWO | {"control": {"force_rms": 1e3}}},
            r"control.force_rms: received ports in N, N/m; needs one port",
        ),
        ({"pto": TWO | {"tuning": "fixed"}}, r"tuning: of several ports is fixed with a damping matrix"),
        ({"pto": {"ports": {"a": "pitch", "b": "heave"}}}, r"a: needs heave, volume, a ring, two points or the strain"),
        ({"pto": TWO, "hydro": {"model": "auto"}}, r"need motion: heave, hydro.model: linear or body_exact, and no"),
        ({"pto": {"held": {"place": "point"}}}, r"pto.held.*a point force on a thin shell has no limit as shell modes"),
        ({"pto": {"held": {"place": "heave"}}}, r"pto.held .place: heave.: leaves the rigid design FSB no motion"),
        (
            {"pto": {"held": {"place": "heave"}}, "designs": {"A": {}}},  # the seed starts with a velocity
            r"holds the take-off's port, heave; needs another pto.port",
        ),
        (
            {"pto": {"port": {"strain": "area"}, "held": {"place": "heave"}}, "designs": {"A": {}}},
            r"starts at rest; needs simulation.initial_position and initial_velocity of 0",
        ),
        ({"pto": {"port": {"between": [0, 180]}}, "hydro": {"model": "auto"}}, r"pto.port: hydro.model 'auto' has no"),
        (
            {"pto": {"port": "volume", "force_limit": 9.0}, "device": GAS},
            r"pto.port 'volume': with device.gas .*needs law: linear",
        ),
    ],
)
def test_combinations_a_model_cannot_compute(seed, changes, wrong):
    with pytest.raises(ConfigError, match=wrong):
        varied(seed, **changes)


@pytest.mark.parametrize(("tuning", "wave"), [("each", "still"), ("one", "still")])
def test_still_water_needs_a_given_damping(seed, tuning, wave):
    study = varied(seed, pto={"damping": None, "tuning": tuning}, waves=[STILL])
    with pytest.raises(ConfigError, match=r"waves.0 still: still water has no optimal damping; needs pto.damping"):
        study.check_dampers()
    varied(study, pto={"damping": 8000.0}).check_dampers()


def test_a_damper_matrix_is_a_damping_given(seed):
    ports = {"a": "heave", "b": {"strain": "area"}}
    study = varied(seed, pto={"ports": ports, "damping": [[2e4, 0.0], [0.0, 1e3]]})
    study.check_dampers()
    assert study.pto.tuning == "fixed"


@pytest.mark.parametrize(
    ("rows", "passive"),
    [
        ([[0.0, 0.0], [0.0, 0.0]], True), ([[1.0, 1.0], [1.0, 1.0]], True), ([[1.0, 1.001], [1.001, 1.0]], False),
        ([[0.0, 1.0], [1.0, 5.0]], False), ([[2e9, 3e4, 0.0], [3e4, 0.5, 0.1], [0.0, 0.1, 1.0]], True),
        ([[4.0, 2.0, 1.0], [2.0, 1.0, 0.0], [1.0, 0.0, 3.0]], False),
    ],
)  # fmt: skip
def test_damper_matrix_of_several_ports_must_be_passive(rows, passive):
    assert positive_semidefinite(rows) is passive


def test_several_ports_stand_beside_the_other_keys_of_the_take_off():
    matrix = [[1e5, 2e3], [2e3, 4e3]]
    given = Pto(ports=TWO["ports"], damping=matrix)
    assert given.tuning == "fixed"
    assert given.several
    assert [list(row) for row in given.port.damping] == matrix
    tuned = Pto(ports=TWO["ports"], matrix="diagonal")
    assert (tuned.tuning, tuned.port.damping, tuned.port.matrix) == ("each", None, "diagonal")
    for pto in (given, tuned, Pto(port={"distributed": "membrane"})):
        assert Pto(**pto.model_dump()) == pto
    assert port_kind({"distributed": "membrane"}).damping_unit == "s"


def test_damping_of_a_run(seed):
    """Per design its own, for all seas a realisation of each, in still water the given one."""
    designs, dampers = {"A": {"flexible": False}, "B": {}}, {"A": 1.0, "B": 2.0}
    study = varied(seed, designs=designs, pto={"damping": dampers}, waves=[SEA, SWELL, STILL])
    sea, again, swell, still = study.waves

    def pto(design, wave, **keys):
        return StudyPlan(varied(study, pto=keys)).simulation(design, wave).spec["run"].study.pto.model_dump()

    assert pto("B", sea) == {"damping": 2.0}
    assert pto("B", sea, tuning="each") == {"tuning": "each"}
    assert pto("B", still, tuning="each") == {"damping": 2.0}
    assert pto("B", still, tuning="one") == {"tuning": "one"}
    one = StudyPlan(varied(study, pto={"tuning": "one"})).simulation("A", again).spec["run"]
    assert one.seas == (sea, swell)
    assert StudyPlan(varied(study, pto={"tuning": "each"})).simulation("A", again).spec["run"].seas == ()
