"""Studies of bodies: one source, ids by contents, keys of buoys refused with a reason."""

from pathlib import Path

import pytest
import yaml

from vsb.errors import ConfigError
from vsb.study.body import Body, BodyDesign, BodyStudy, is_body, load_body, located
from vsb.study.canonical import canonical
from vsb.study.reading import validated
from vsb.study.study import parse

RAW = {
    "study": "raft",
    "body": {"database": "raft.nc"},
    "designs": {"flexible": {}, "rigid": {"dofs": "rigid"}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}],
}


def study(**changes):
    return validated(BodyStudy, {**RAW, **changes}, "raft.yaml")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"device": {}}, "device: is the spherical buoy; a study has a device or a body; remove it"),
        ({"modes": {}}, "modes: are shapes of the spherical shell; those of a body stand in its files; remove it"),
        (
            {"drag": {"heave": {"coefficient": 0.5, "area": 12.0}}},
            "drag: brakes the buoy's rigid motions past the water",
        ),
        ({"reference_shape": "equilibrium"}, "reference_shape: is of the spherical shell; a body is linear"),
        ({"hydro": {"witness": "none"}}, "hydro.witness: is for the buoy: its second solver knows no other body"),
        ({"hydro": {"solver": "panels", "rows": 20}}, r"hydro.solver: is for the buoy.* \(and 1 more\)"),
        ({"hydro": {"model": "body_exact"}}, "hydro.model 'body_exact': is of the spherical shell; a body is linear"),
        ({"hydro": {"accept": ["rank_two"]}}, r"\['rank_two'\]: no such check; needs some of error_estimate"),
        (
            {"hydro": {"repair": ["haskind"]}},
            r"hydro.repair.*\['haskind'\]: cannot be repaired; needs some of positive",
        ),
        (
            {"hydro": {"repair": ["kramers_kronig"], "accept": ["kramers_kronig"]}},
            r"repair \['kramers_kronig'\]: is accepted as well; needs to be accepted as it is, or repaired",
        ),
        ({"body": {"database": "a", "mass": {"float": [[1.0, "x"]]}}}, r"body.mass.*float.*received.*'x'"),
        ({"pto": {"port": "volume"}}, "pto.port: is of the spherical shell; needs {dof: NAME}"),
        ({"pto": {"port": {"colatitude": 90}}}, "pto.port: is of the spherical shell"),
        ({"pto": {"port": {"dofs": {"Heave": 0}}}}, "needs a share that is not zero"),
        (
            {"simulation": {"method": "exponential"}},
            "simulation.method 'exponential': cannot follow this body and take-off; needs auto, exact, convolution or ",
        ),
        *(
            (
                {"pto": {"port": {"dof": "Heave"}, **pto}, "simulation": {"method": method}},
                f"simulation.method '{method}': cannot follow this body and take-off; needs auto$",
            )
            for pto in ({"force_limit": 1e5}, {"law": "latching"})
            for method in ("exact", "convolution")
        ),
        ({"body": {}}, "received no source; needs one of file, database, wamit, bemio"),
        ({"body": {"wamit": "a", "bemio": "b"}}, "received wamit and bemio; needs one of"),
        ({"body": {"bemio": "b", "length": 2.0}}, "length 2 m: is WAMIT's ULEN, which bemio does not have"),
        ({"body": {"bemio": "b", "length": 0.5}}, "length 0.5 m: is WAMIT's ULEN, which bemio does not have; remove"),
        ({"designs": {"a": {"held": [{"Heave": 1.0}, {"Yaw": 0.0}]}}}, r"held {'Yaw': 0.0}: needs a share that is not"),
        (
            {"hydro": {"repair": ["kramers_kronig"], "accept": ["symmetry", "kramers_kronig"]}},
            r"repair \['kramers_kronig'\]: is accepted as well",
        ),
        ({"waves": RAW["waves"] * 2}, r"waves .*: the same sea is listed twice"),
        ({"pto": {"damping": {"rigid": 5.0}}}, "pto.damping: received dampers of rigid, needs one for every design: f"),
        (
            {"published": {"source": "elsewhere", "values": {"paper": {"energy": 1.0}}}},
            r"published.values \['paper'\]: no such design; needs some of flexible, rigid",
        ),
        (
            {"drag": {}, "modes": {}, "hydro": {"rows": 20, "model": "auto"}},
            r"modes: are shapes of the spherical shell.* \(and 3 more\)$",
        ),
        ({"designs": {"a": {"dofs": []}}}, r"dofs \[\]: needs at least one degree of freedom, and none twice"),
        ({"designs": {"a": {"held": [{"Heave": 0.0}]}}}, "needs a share that is not zero"),
        ({"designs": {"a": {"clamp": 90}}}, "designs.a.clamp"),
    ],
)
def test_what_makes_no_sense_is_refused_with_a_reason(changes, message):
    with pytest.raises(ConfigError, match=message):
        study(**changes)


@pytest.mark.parametrize(
    ("given", "left_out"),
    [({"database": "raft.nc"}, {}), ({"wamit": "raft", "length": 2.0}, {}), ({"wamit": "raft"}, {"length": 1.0})],
)
def test_a_body_says_what_is_given_but_a_length_of_one(given, left_out):
    assert Body(**given, **left_out).model_dump() == given


def test_gains_are_over_the_first_design_that_moves_in_rigid_motions_alone():
    assert study().reference_design == "rigid"
    both = {"a": {"dofs": ["Heave", "Mode7"]}, "b": {"dofs": ["float__Heave", "spar__Heave"]}}
    assert study(designs=both).reference_design == "b"
    assert study(designs={"z": {"dofs": "rigid"}, **both}).reference_design == "b"
    assert study(designs={"a": {}}).reference_design is None
    assert [BodyDesign(dofs=d).rigid for d in ("all", "rigid", ("Yaw",))] == [False, True, True]


def test_shares_that_cancel_hold_a_combination():
    opposite = {"float__Heave": 1.0, "spar__Heave": -1.0}
    assert BodyDesign(held=(opposite,)).held == (opposite,)


def test_degrees_of_freedom_kept_are_those_of_all_designs():
    assert study().dofs is None
    assert study(designs={"a": {"dofs": "rigid"}, "b": {"dofs": ["Mode7", "Heave"]}}).dofs == (
        "Heave",
        "Mode7",
        "rigid",
    )
    assert study().flexible
    assert not study(designs={"a": {"dofs": "rigid"}}).flexible


def test_directions_of_the_seas_each_once():
    swell = {"kind": "regular", "amplitude": 0.5, "period": 7.0}
    waves = [{**swell, "direction": d} for d in (0.0, 45.0)] + [{**swell, "period": 8.0, "direction": 45.0}]
    assert study(waves=waves).directions == (0.0, 45.0)
    assert study(waves=[{"kind": "still"}]).directions == (0.0,)
    assert study(waves=waves[1:] + waves[:1]).directions == (45.0, 0.0)  # in the order of the seas


def test_a_study_knows_its_files_by_contents(tmp_path):
    (tmp_path / "raft.nc").write_bytes(b"one")
    (tmp_path / "raft.yaml").write_text(yaml.safe_dump(RAW))
    first = load_body(tmp_path / "raft.yaml")
    assert first.files == {"database": str(tmp_path / "raft.nc")}
    assert str(tmp_path) not in canonical(first.study)
    again = located(first.study.model_dump(), "elsewhere/raft.yaml")  # as it travels to a stage
    assert again == (first.study, {})
    (tmp_path / "raft.nc").write_bytes(b"two")
    assert load_body(tmp_path / "raft.yaml").study != first.study


def test_wamit_is_all_of_its_files(tmp_path):
    raw = {**RAW, "body": {"wamit": "run/raft"}}
    (tmp_path / "run").mkdir()
    for ending in (".1", ".3"):
        (tmp_path / "run" / f"raft{ending}").write_text(ending)
    with pytest.raises(ConfigError, match=r"body.wamit: .*raft.hst cannot be read \(No such file or directory\)"):
        located(raw, str(tmp_path / "raft.yaml"))
    (tmp_path / "run" / "raft.hst").write_text("")
    three = located(raw, str(tmp_path / "raft.yaml")).study
    (tmp_path / "run" / "raft.mmx").write_text("")
    four = located(raw, str(tmp_path / "raft.yaml")).study
    assert four != three
    for ending in (".1", ".3", ".hst", ".mmx"):
        file = tmp_path / "run" / f"raft{ending}"
        held = file.read_text()
        file.write_text("other")
        assert located(raw, str(tmp_path / "raft.yaml")).study != four
        file.write_text(held)
    assert located(raw, str(tmp_path / "raft.yaml")).study == four


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({".hst": "stiff", ".mmx": ""}, {".hst": "", ".mmx": "stiff"}),
        ({".hst": "stiff", ".mmx": "mass"}, {".hst": "stiffmass", ".mmx": ""}),
        ({".hst": "", ".3fk": "force"}, {".hst": "", ".3sc": "force"}),
        ({".hst": "", ".mmx": "mass"}, {".hst": ".mmx mass"}),
    ],
)
def test_what_stands_in_which_of_wamits_files_names_the_study(tmp_path, first, second):
    """The same text in another file, or cut elsewhere, is another body."""
    found = []
    for i, contents in enumerate((first, second)):
        (tmp_path / str(i)).mkdir()
        for ending, text in {".1": "1", ".3": "3", **contents}.items():
            (tmp_path / str(i) / f"raft{ending}").write_text(text)
        found.append(located({**RAW, "body": {"wamit": f"{i}/raft"}}, str(tmp_path / "raft.yaml")).study)
    assert found[0] != found[1]


def test_a_body_file_brings_its_water_and_is_known_by_what_it_says(tmp_path):
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
    with pytest.raises(ConfigError, match=r"water: is not that of .*file.yaml; needs the same, or leave it"):
        located({**RAW, "body": "file.yaml", "water": {"depth": 30.0}}, str(tmp_path / "raft.yaml"))


def test_a_study_of_a_body_is_none_of_a_buoy():
    assert is_body(RAW)
    assert not is_body({"body": "raft", "mesh": "m.nc"})
    with pytest.raises(ConfigError, match=r"body: received a study of a body, needs one of a buoy, with a device"):
        parse(RAW)


def test_still_water_shows_a_period_of_a_second():
    found = study(waves=[{"kind": "still"}], pto={"damping": 1.0})
    assert found.fastest(found.waves[0]) == pytest.approx(6.2832, rel=1e-4)
    assert found.needs_bem
    assert not Path("raft.nc").exists()


def test_what_is_not_repaired_is_not_said():
    """Ids of studies of before stay what they were."""
    assert "repair" not in canonical(study())
    assert "repair" in canonical(study(hydro={"repair": ["kramers_kronig"]}))


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        ({"database": "a.nc"}, '{"database":"a.nc"}'),
        ({"wamit": "run", "length": 1.0}, '{"wamit":"run"}'),
        ({"wamit": "run", "length": 2.0}, '{"length":2.0,"wamit":"run"}'),
        ({"database": "a.nc", "mass": [[1.0]]}, '{"database":"a.nc","mass":[[1.0]]}'),
    ],
)
def test_ids_of_bodies_are_of_what_is_said_of_them(raw, said):
    assert canonical(Body(**raw)) == said


@pytest.mark.parametrize(
    ("key", "why"),
    [
        ("hydro.solver", "is for the buoy; the body's file says how it is solved"),
        ("hydro.rows", "are of the sphere's mesh; the body has a mesh of its own"),
        ("hydro.omega", "is of the body's file, or of the database read"),
        ("hydro.pressure", "is of the paper's model of the buoy"),
        ("hydro.power_tolerance", "is of hydro.model: auto, which the buoy has"),
        ("hydro.witness", "is for the buoy: its second solver knows no other body"),
        ("device", "is the spherical buoy; a study has a device or a body"),
        ("modes", "are shapes of the spherical shell; those of a body stand in its files"),
        ("drag", "brakes the buoy's rigid motions past the water; a body is linear, its dampers are body.damping"),
        ("reference_shape", "is of the spherical shell; a body is linear about the rest its files are of"),
    ],
)
def test_each_key_of_a_buoy_is_refused_for_its_own_reason(key, why):
    *section, name = key.split(".")
    for value in (None, {}, 1.0):
        with pytest.raises(ConfigError) as error:
            study(**({"hydro": {name: value, "tolerance": 0.01}} if section else {name: value}))
        assert str(error.value).endswith(f": body study: {key}: {why}; remove it")


def test_every_check_on_the_database_of_a_body_may_be_accepted_and_two_be_repaired():
    """Those of meshes solved and of files read."""
    names = [
        "error_estimate", "interpolation_error", "one_resolution", "symmetry", "far_field", "haskind", "positive_damping",
        "panels", "modes", "corners", "rigid_names", "closure", "lid", "afloat", "irregular_frequencies", "kramers_kronig", "long_waves",
        "haskind_scale", "haskind_long_waves",
    ]  # fmt: skip
    for name in names:
        assert study(hydro={"accept": [name]}).hydro.accept == (name,)
        if name in ("positive_damping", "kramers_kronig"):
            assert study(hydro={"repair": [name]}).hydro.repair == (name,)
            continue
        with pytest.raises(
            ConfigError, match=rf"\['{name}'\]: cannot be repaired; needs some of positive_damping, kramers"
        ):
            study(hydro={"repair": [name]})
    with pytest.raises(ConfigError, match=r"hydro.repair.*\['symmetry', 'b'\]: cannot be repaired; needs some of"):
        study(hydro={"repair": ["positive_damping", "symmetry", "kramers_kronig", "b"]})
    with pytest.raises(ConfigError, match=rf"\['b', 'a'\]: no such check; needs some of {', '.join(names)}"):
        study(hydro={"accept": ["b", "symmetry", "a"]})


@pytest.mark.parametrize(("key", "kept", "refused"), [
    ("tolerance", [1e-6, 0.1], [0.99e-6, 0.101]), ("omega_max", [1e-9, None], [0.0, -1.0]),
    ("added_mass_inf", ["fitted", "given"], ["median"]), ("model", ["linear"], ["auto"]),
])  # fmt: skip
def test_hydrodynamics_of_a_body_have_their_limits(key, kept, refused):
    for value in kept:
        assert getattr(study(hydro={key: value}).hydro, key) == value
    for value in refused:
        with pytest.raises(ConfigError, match=rf"hydro\.{key}"):
            study(hydro={key: value})


def test_what_is_not_said_of_a_bodys_hydrodynamics_has_a_default():
    hydro = study().hydro
    assert (hydro.tolerance, hydro.added_mass_inf, hydro.omega_max) == (0.01, "fitted", None)
    assert (hydro.accept, hydro.repair) == ((), ())


@pytest.mark.parametrize("method", ["auto", "exact", "convolution", "structure_preserving"])
def test_a_linear_body_and_take_off_are_followed_by_all_methods_but_one(method):
    assert study(simulation={"method": method}).simulation.method == method
    heave = {"port": {"dof": "Heave"}, "force_limit": 1e5}
    if method == "auto":
        assert study(pto=heave, simulation={"method": method}).pto.switches
        return
    with pytest.raises(ConfigError, match=r"cannot follow this body and take-off; needs auto$"):
        study(pto=heave, simulation={"method": method})


def test_a_design_names_every_degree_of_freedom_once():
    with pytest.raises(ConfigError, match=r"dofs \['Heave', 'Yaw', 'Heave'\]: needs at least one .*, and none twice"):
        study(designs={"a": {"dofs": ["Heave", "Yaw", "Heave"]}})


def test_the_fastest_motion_in_waves_is_that_of_the_waves():
    waves = [{"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "jonswap", "hs": 1.0, "tp": 7.0}]
    found = study(waves=[*waves, {"kind": "still"}], pto={"damping": 1.0})
    assert [found.fastest(wave) for wave in found.waves] == [
        found.waves[0].fastest, found.waves[1].fastest, pytest.approx(6.2832, rel=1e-4),
    ]  # fmt: skip
    assert found.waves[0].fastest != found.waves[1].fastest


def test_another_mesh_or_other_modes_are_another_body(tmp_path):
    body = {"body": "raft", "mesh": "m.nc", "modes": "d.nc", "omega": [0.6, 0.9]}
    (tmp_path / "file.yaml").write_text(yaml.safe_dump(body))
    found = []
    for mesh, modes in (("one", "two"), ("one", "three"), ("four", "two"), ("two", "one"), ("one", "two")):
        (tmp_path / "m.nc").write_text(mesh)
        (tmp_path / "d.nc").write_text(modes)
        found.append(located({**RAW, "body": {"file": "file.yaml"}}, str(tmp_path / "raft.yaml")).study)
    assert [found.index(one) for one in found] == [0, 1, 2, 3, 0]
    (tmp_path / "d.nc").unlink()
    with pytest.raises(ConfigError, match=r"file.yaml: modes: .*d.nc cannot be read \(No such file or directory\)"):
        located({**RAW, "body": "file.yaml"}, str(tmp_path / "raft.yaml"))


@pytest.mark.parametrize("kind", ["database", "bemio"])
def test_a_file_alone_is_read_by_its_own_kind(tmp_path, kind):
    (tmp_path / "raft.h5").write_text("numbers")
    found = located({**RAW, "body": {kind: "raft.h5"}}, str(tmp_path / "raft.yaml"))
    assert found.files == {kind: str(tmp_path / "raft.h5")}
    assert found.study.body.kind == kind
    assert found.study.body.model_dump()[kind].startswith("sha256:")
    with pytest.raises(ConfigError, match=rf"raft.yaml: body.{kind}: .*gone.h5 cannot be read"):
        located({**RAW, "body": {kind: "gone.h5"}}, str(tmp_path / "raft.yaml"))


@pytest.mark.parametrize("kind", ["database", "wamit"])
def test_a_long_file_counts_to_its_last_byte(tmp_path, kind):
    """The second of several as well."""
    found = []
    for last in (b"a", b"b"):
        for name in ("raft", "raft.1", "raft.3", "raft.hst"):
            (tmp_path / name).write_bytes(bytes(3 * 2**20) + (last if name in ("raft", "raft.3") else b""))
        found.append(located({**RAW, "body": {kind: "raft"}}, str(tmp_path / "raft.yaml")).study)
    assert found[0] != found[1]
