"""Studies of bodies read from files: sources, content ids, keys that are refused."""

import json
import math
from pathlib import Path

import pytest
import yaml

from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical
from vsb.keys.reading import validated
from vsb.study.body import BodyStudy, is_body, load_body, located, wamit_files
from vsb.study.study import Study, parse

RAW = {
    "study": "raft",
    "body": {"database": "raft.nc"},
    "designs": {"flexible": {}, "rigid": {"dofs": "rigid"}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}],
}


def study(**changes):
    return validated(BodyStudy, {**RAW, **changes}, "raft.yaml")


def test_study_has_the_kind_of_its_keys(seed):
    """`Study` is of a body where there is one, of a buoy otherwise; what a stage reads of it likewise."""
    for one in (study(), seed):
        raw = one.model_dump()
        part = Study.part(json.loads(one.only("designs", *one.FLOATS).model_dump_json()))
        assert Study(**raw) == Study.model_validate(raw) == one
        assert type(part) is type(one)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"device": {}}, "device: is the spherical buoy; a study has a device or a body; remove it"),
        ({"hydro": {"witness": "none"}}, "hydro.witness: is for the buoy: its second solver knows no other body"),
        ({"hydro": {"model": "body_exact"}}, "hydro.model 'body_exact': is of the spherical shell; a body is linear"),
        ({"hydro": {"repair": ["kramers_kronig"], "accept": ["kramers_kronig"]}}, "is accepted as well"),
        ({"body": {"database": "a", "mass": {"float": [[1.0, "x"]]}}}, r"body.mass.*float.*received.*'x'"),
        ({"pto": {"port": "volume"}}, "pto.port: is of the spherical shell; needs {dof: NAME}"),
        ({"simulation": {"method": "exponential"}}, "simulation.method 'exponential': cannot follow this body and"),
        *(
            (
                {"pto": {"port": {"dof": "Heave"}, **pto}, "simulation": {"method": method}},
                f"simulation.method '{method}': cannot follow this body and take-off; needs auto$",
            )
            for pto in ({"force_limit": 1e5}, {"law": "latching"})
            for method in ("exact", "convolution")
        ),
        ({"body": {}}, "received no source; needs one of file, database, wamit, bemio"),
        (
            {"body": {"database": "a", "bodies": 2}},
            "bodies: is for WAMIT's files, which do not state it; database does",
        ),
        (
            {"body": {"wamit": "a", "bodies": 2, "modes": [7, 6, 6]}},
            r"modes \[7, 6, 6\]: needs a number for each of 2 bod",
        ),
        (
            {"hydro": {"repair": ["symmetry"]}},
            r"\['symmetry'\]: cannot be repaired; needs some of positive_damping, kramers",
        ),
        ({"hydro": {"accept": ["b"]}}, r"\['b'\]: no such check; needs some of error_estimate, "),
        ({"designs": {"a": {"held": [{"Heave": 1.0}, {"Yaw": 0.0}]}}}, r"held {'Yaw': 0.0}: needs a share that is not"),
        ({"drag": {"Heave": {"coefficient": 1.0, "area": -2.0}}}, r"drag.Heave"),
        ({"modes": {}, "hydro": {"rows": 20, "model": "auto"}}, r"modes: are shapes of the spherical"),
        ({"designs": {"a": {"dofs": []}}}, r"dofs \[\]: needs at least one degree of freedom, and none twice"),
        ({"designs": {"a": {"clamp": 90}}}, "designs.a.clamp"),
    ],
)
def test_invalid_body_study_is_refused(changes, message):
    with pytest.raises(ConfigError, match=message):
        study(**changes)


def test_content_of_files_is_part_of_the_study(tmp_path):
    (tmp_path / "raft.nc").write_bytes(b"one")
    (tmp_path / "raft.yaml").write_text(yaml.safe_dump(RAW))
    first = load_body(tmp_path / "raft.yaml")
    assert first.files == {"database": str(tmp_path / "raft.nc")}
    assert str(tmp_path) not in canonical(first.study)
    again = located(first.study.model_dump(), "elsewhere/raft.yaml")  # as it travels to a stage
    assert again == (first.study, {})
    (tmp_path / "raft.nc").write_bytes(b"two")
    assert load_body(tmp_path / "raft.yaml").study != first.study


def test_body_file_brings_its_water(tmp_path):
    body = {"body": "raft", "mesh": "m.nc", "modes": "d.nc", "omega": [0.6, 0.9], "water": {"depth": 20.0}}
    (tmp_path / "file.yaml").write_text(yaml.safe_dump(body))
    for name in ("m.nc", "d.nc"):
        (tmp_path / name).write_text(name)
    found = located({**RAW, "body": "file.yaml"}, str(tmp_path / "raft.yaml"))
    assert found.study.water.depth == 20.0
    assert found.files == {"mesh": str(tmp_path / "m.nc"), "modes": str(tmp_path / "d.nc")}
    (tmp_path / "file.yaml").write_text("# of another name\n" + yaml.safe_dump({**body, "body": "other"}))
    assert located({**RAW, "body": "file.yaml"}, str(tmp_path / "raft.yaml")).study == found.study
    assert located({**RAW, "body": "file.yaml", "water": {"depth": 20}}, str(tmp_path / "raft.yaml")) == found
    with pytest.raises(ConfigError, match=r"water: differs from that of .*file.yaml; needs the same, or none"):
        located({**RAW, "body": "file.yaml", "water": {"depth": 30.0}}, str(tmp_path / "raft.yaml"))


def test_body_file_within_a_study(tmp_path):
    """Its mesh is found from the study's folder; the study travels to a stage unchanged."""
    (tmp_path / "hull.stl").write_text("hull")
    sphere = {"kind": "sphere", "radius": 2.0, "draft": 2.0, "panel": 0.5}
    for mesh, files in (("hull.stl", {"mesh": str(tmp_path / "hull.stl")}), (sphere, {})):
        file = {"body": "raft", "mesh": mesh, "modes": "rigid", "omega": [0.6, 0.9], "water": {"depth": 20.0}}
        found = located({**RAW, "body": {"file": file}}, str(tmp_path / "raft.yaml"))
        assert found.files == files
        assert found.study.water.depth == 20.0
        assert str(tmp_path) not in canonical(found.study)
        assert located(found.study.model_dump(), "elsewhere/raft.yaml") == (found.study, {})


def test_body_study_is_not_a_buoy_study():
    assert is_body(RAW)
    assert not is_body({"body": "raft", "mesh": "m.nc"})
    with pytest.raises(ConfigError, match=r"body: received a study of a body, needs one of a buoy, with a device"):
        parse(RAW)
    with pytest.raises(ConfigError, match=r"^raft.yaml: study: missing; .*`vsb body raft.yaml FOLDER`"):
        parse({"body": "raft", "mesh": "m.nc"}, "raft.yaml")


RAFT = {"body": "raft", "mesh": "raft.nc", "modes": "raft.nc", "omega": [0.6, 0.9]}


@pytest.mark.parametrize(("gravity", "depth"), [(9.81, 10.0), (3.7, 2.0)])
def test_lowest_frequency_of_the_panels(gravity, depth):
    """Wavenumber times depth of 0.3."""
    lowest = math.sqrt(gravity * 0.3 / depth * math.tanh(0.3))
    water = {"gravity": gravity, "depth": depth}
    validated(BodyFile, {**RAFT, "water": water, "omega": [1.0001 * lowest, 9.0]}, "raft.yaml")
    with pytest.raises(ConfigError, match=rf"in {depth:g} m of water needs at least {lowest:.4g}$"):
        validated(BodyFile, {**RAFT, "water": water, "omega": [0.9999 * lowest, 9.0]}, "raft.yaml")


def test_a_run_of_wamit_is_known_by_the_excitation_it_has_and_by_its_bodies(tmp_path):
    """`.2` counts only where `.3` is missing; the modes of each body make another body of the same files."""
    for ending in (".1", ".2", ".hst", ".mmx"):
        (tmp_path / f"two{ending}").write_text(ending)

    def found(**body):
        (tmp_path / "two.yaml").write_text(yaml.safe_dump({**RAW, "body": {"wamit": "two", **body}}))
        return load_body(tmp_path / "two.yaml").study.body

    by_haskind = found()
    assert found(modes=[7, 6]).wamit == by_haskind.wamit
    assert canonical(found(modes=[7, 6])) != canonical(by_haskind) == canonical(found())
    assert [Path(name).suffix for name in wamit_files(str(tmp_path / "two"))] == [".1", ".2", ".hst", ".mmx"]
    (tmp_path / "two.3").write_text(".3")
    assert [Path(name).suffix for name in wamit_files(str(tmp_path / "two"))] == [".1", ".3", ".hst", ".mmx"]
    assert found().wamit != by_haskind.wamit
    for given, message in (("two.1", "is one of WAMIT's files; .* all have, two$"), (".", "is a folder; .* ./NAME$")):
        with pytest.raises(ConfigError, match=message):
            found(wamit=given)
