"""Plans of bodies: content ids, files, runs."""

import pytest

from vsb.errors import ConfigError
from vsb.keys.quantities import content_id
from vsb.pipeline.graph import BodyPlan
from vsb.pipeline.plans import plan_of, planned
from vsb.study.body import LocatedBody, located

RAW = {
    "study": "raft",
    "body": {"database": "sha256:raft"},
    "designs": {"flexible": {}, "rigid": {"dofs": "rigid"}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "jonswap", "hs": 1.0, "tp": 7.0}],
}


def plan(**changes):
    found: LocatedBody = located({**RAW, **changes}, "raft.yaml")
    return BodyPlan(found.study, files=found.files)


STAGES = ("database", "radiation", "response", "ladder", "compare")


@pytest.mark.parametrize(
    ("changes", "renamed"),
    [
        ({"body": {"database": "sha256:other"}}, {"database", "radiation", "compare"}),
        ({"body": {**RAW["body"], "mass": {"Heave": 1.0}}}, {"database", "radiation", "compare"}),
        ({"hydro": {"omega_max": 2.0}}, {"database", "radiation", "compare"}),
        ({"hydro": {"repair": ["kramers_kronig"]}}, {"database", "radiation", "compare"}),
        ({"hydro": {"tolerance": 0.02}}, {"radiation", "compare"}),
        ({"hydro": {"added_mass_inf": "given"}}, {"radiation", "compare"}),
        ({"pto": {"damping": 1.0}}, {"response", "ladder", "compare"}),
        ({"pto": {"port": {"dof": "Pitch"}}}, {"response", "ladder", "compare"}),
        ({"simulation": {"duration": 90.0}}, {"ladder", "compare"}),
        ({"waves": [{**RAW["waves"][1], "seed": 2}, RAW["waves"][0]]}, {"ladder", "compare"}),
        ({"designs": {"flexible": {}, "rigid": {"dofs": ["Heave"]}}}, {"response", "ladder", "compare"}),
        ({"water": {"density": 1000.0}}, {"database", "radiation", "response", "ladder", "compare"}),
    ],
)
def test_key_changes_the_ids_of_the_stages_that_read_it(changes, renamed):
    before, after = plan(), plan(**changes)
    found = {name for name in STAGES if content_id(getattr(before, name).spec) != content_id(getattr(after, name).spec)}
    assert found == renamed
    assert before.identity != after.identity


def test_mesh_is_solved_with_a_green_function_table(tmp_path):
    body = {"body": "raft", "mesh": "sha256:m", "modes": "sha256:d", "omega": [0.6, 0.9]}
    own = plan(body={"file": body})
    assert own.study.uses_panels
    assert own.inputs == [f"{own.green.out}"]
    assert own.sources == {"folder": "results/hydro/bodies", "green": own.green.files["folder"]}
    assert own.database.spec.solver.startswith("capytaine")
    assert own.highest == 0.9
    assert plan().database.spec.solver == ""
    (tmp_path / "raft.nc").write_text("numbers")
    read = planned({**RAW, "body": {"database": "raft.nc"}, "root": "out"}, str(tmp_path / "raft.yaml"))
    assert read.root == "out"
    assert [name.endswith("raft.nc") for name in read.inputs] == [True]
    assert read.inputs == list(read.sources.values())


def test_a_hull_in_place_of_a_study_is_told_how_to_get_one():
    with pytest.raises(ConfigError, match=r"cad/hull.STL: received a hull.* vsb init my.yaml --body .* mesh: hull.STL"):
        plan_of("cad/hull.STL")
