"""Plans of bodies: what names what."""

import math

import pytest
from conftest import SEED

from vsb.study.body import BodyDesign, LocatedBody, located
from vsb.study.body_file import PHYSICS
from vsb.study.body_plan import BodyPlan, plan_for
from vsb.study.campaign_plan import planned
from vsb.study.canonical import content_id
from vsb.study.study import load

RAW = {
    "study": "raft",
    "body": {"database": "sha256:raft"},
    "designs": {"flexible": {}, "rigid": {"dofs": "rigid"}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "jonswap", "hs": 1.0, "tp": 7.0}],
}


def plan(**changes):
    found: LocatedBody = located({**RAW, **changes}, "raft.yaml")
    return BodyPlan(found.study, files=found.files)


STAGES = ("database", "radiation", "response", "ladder", "comparison")


@pytest.mark.parametrize(
    ("changes", "renamed"),
    [
        ({"body": {"database": "sha256:other"}}, {"database", "radiation", "comparison"}),
        ({"body": {**RAW["body"], "mass": {"Heave": 1.0}}}, {"database", "radiation", "comparison"}),
        ({"hydro": {"omega_max": 2.0}}, {"database", "radiation", "comparison"}),
        ({"hydro": {"repair": ["kramers_kronig"]}}, {"database", "radiation", "comparison"}),
        ({"hydro": {"tolerance": 0.02}}, {"radiation", "comparison"}),
        ({"hydro": {"added_mass_inf": "given"}}, {"radiation", "comparison"}),
        ({"pto": {"damping": 1.0}}, {"response", "ladder", "comparison"}),
        ({"pto": {"port": {"dof": "Pitch"}}}, {"response", "ladder", "comparison"}),
        ({"simulation": {"duration": 90.0}}, {"ladder", "comparison"}),
        ({"waves": [{**RAW["waves"][1], "seed": 2}, RAW["waves"][0]]}, {"ladder", "comparison"}),
        ({"designs": {"flexible": {}, "rigid": {"dofs": ["Heave"]}}}, {"response", "ladder", "comparison"}),
        ({"water": {"density": 1000.0}}, {"database", "radiation", "response", "ladder", "comparison"}),
    ],
)
def test_a_key_changes_the_ids_of_the_stages_that_read_it(changes, renamed):
    before, after = plan(), plan(**changes)
    found = {name for name in STAGES if content_id(getattr(before, name)) != content_id(getattr(after, name))}
    assert found == renamed
    assert before.study_id != after.study_id


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("key", ["initial_position", "initial_velocity"])
def test_only_runs_with_a_start_of_their_own_know_what_it_is_of(key, sign):
    """Those from rest keep their names, whatever a start is of."""
    (wave, _) = plan().study.waves
    rest, moved = (plan(simulation=start).simulation("rigid", wave) for start in ({}, {key: sign * 0.1}))
    assert content_id(rest.model_copy(update={"start": 0})) == content_id(rest)
    assert content_id(moved.model_copy(update={"start": 0})) != content_id(moved)


def test_heave_by_name_is_a_port_of_its_own():
    """{dof: Heave} and {dofs: {Heave: 1}} are one."""
    short, long = plan(pto={"port": {"dof": "Heave"}}), plan(pto={"port": {"dofs": {"Heave": 1.0}}})
    assert short.study_id == long.study_id


def test_products_are_named_and_files_need_not_be_known():
    own = plan()
    assert plan_for(own.study).ids == own.ids
    assert set(own.products) <= set(own.ids)
    assert f"{own.folder}/report.html" in own.products
    assert f"{own.folder}/figures/spectra.csv" in own.products
    assert "spectra" not in plan(waves=RAW["waves"][:1]).figures
    assert not any("modes.nc" in path or "/mesh/" in path for path in own.products)
    assert own.ids[own.database_path] == content_id(own.database)
    assert own.simulation_megabytes(own.study.waves[1]) > own.simulation_megabytes(own.study.waves[0]) > 0
    assert plan_for(load(SEED)).study == load(SEED)


def test_a_mesh_is_solved_with_a_table(tmp_path):
    body = {"body": "raft", "mesh": "sha256:m", "modes": "sha256:d", "omega": [0.6, 0.9]}
    own = plan(body={"file": body})
    assert own.solves
    assert own.inputs == [f"{own.green_folder}.done"]
    assert own.sources == {"folder": "results/hydro/bodies", "green": own.green_folder}
    assert own.database.solver.startswith("capytaine")
    assert own.highest == 0.9
    assert plan().database.solver == ""
    (tmp_path / "raft.nc").write_text("numbers")
    read = BodyPlan.of({**RAW, "body": {"database": "raft.nc"}, "root": "out"}, str(tmp_path / "raft.yaml"))
    assert read.root == "out"
    assert [name.endswith("raft.nc") for name in read.inputs] == [True]
    assert read.inputs == list(read.sources.values())


def test_a_file_is_planned_by_what_it_is(tmp_path):
    (tmp_path / "raft.nc").write_text("numbers")
    body = {**RAW, "body": {"database": "raft.nc"}}
    assert isinstance(planned(body, str(tmp_path / "raft.yaml")), BodyPlan)
    assert planned({**load(SEED).model_dump(), "root": "out"}, "seed.yaml").root == "out"


def test_the_response_is_asked_at_each_frequency_of_regular_waves_once_from_the_lowest_on():
    periods = (7.0, 3.0, 11.0, 5.0, 3.0)
    waves = [{"kind": "regular", "amplitude": a, "period": t} for a, t in enumerate(periods, 1)]
    assert plan(waves=waves).response.omega == tuple(2 * math.pi / t for t in (11.0, 7.0, 5.0, 3.0))


@pytest.mark.parametrize(
    ("pto", "damping", "seas"), [({"damping": 5.0}, 5.0, 0), ({}, None, 0), ({"tuning": "one"}, None, 2)]
)
def test_a_run_knows_all_seas_only_where_one_damper_is_best_over_them(pto, damping, seas):
    other = {**RAW["waves"][1], "seed": 2}  # of a sea there already
    own = plan(pto=pto, waves=[*RAW["waves"], other])
    spec = own.simulation("rigid", own.study.waves[0])
    assert (spec.pto.damping, spec.seas) == (damping, own.study.waves[:seas])
    assert list(spec.designs) == ["rigid"]
    assert spec.waves == own.study.waves[:1]


@pytest.mark.parametrize("study", [load(SEED), plan().study], ids=["shell", "body"])
def test_a_plan_is_of_the_folder_it_is_asked_for(study):
    for root in ("results", "elsewhere"):
        found = plan_for(study, root=root)
        assert found.root == root
        assert all(path.startswith(f"{root}/") for path in found.products)


@pytest.mark.parametrize(
    ("held", "taken"), [({"Heave": 1.0, "Pitch": 0.0}, True), ({"Heave": 0.0, "Pitch": 0.0}, False)]
)
def test_what_is_held_has_some_share(held, taken):
    if taken:
        assert BodyDesign(held=(held,)).held == (held,)
    else:
        with pytest.raises(ValueError, match="needs a share that is not zero"):
            BodyDesign(held=(held,))


def test_the_order_of_checks_accepted_or_repaired_names_nothing():
    for key, names in (("accept", ["symmetry", "haskind"]), ("repair", ["positive_damping", "kramers_kronig"])):
        one, other = (plan(hydro={key: order}).database for order in (names, names[::-1]))
        assert getattr(one, key) == tuple(sorted(names))
        assert one == other


def test_a_ladder_follows_no_motion_and_knows_no_method():
    exact = plan(simulation={"method": "exact"})
    assert exact.ladder == plan().ladder
    assert exact.simulation("rigid", exact.study.waves[0]).simulation.method == "exact"


def test_the_response_is_asked_at_no_frequency_of_an_irregular_sea():
    assert plan(waves=RAW["waves"][1:]).response.omega == ()


def test_a_damper_given_to_each_design_is_that_of_its_run_unless_it_is_tuned():
    """In still water none is best: there the one given holds."""
    waves = [RAW["waves"][0], {"kind": "still"}]
    for tuning in ("fixed", "each", "one"):
        own = plan(pto={"damping": {"flexible": 3.0, "rigid": 5.0}, "tuning": tuning}, waves=waves)
        sea, still = own.study.waves
        for design, damping in (("flexible", 3.0), ("rigid", 5.0)):
            asked = own.simulation(design, sea)
            assert (asked.pto.damping, asked.pto.tuning) == (damping if tuning == "fixed" else None, tuning)
            assert list(asked.designs) == [design]
        found = own.simulation("rigid", still).pto
        assert (found.damping, found.tuning) == ((5.0, "fixed") if tuning != "one" else (None, "one"))


def test_of_several_realisations_one_is_drawn_and_all_are_run():
    own = plan(waves=[{**RAW["waves"][1], "realisations": 3}])
    assert [wave.seed for wave in own.study.waves] == [1, 2, 3]
    assert [name for name in own.figures if name.startswith("port_motion")] == [
        f"port_motion-{own.study.waves[0].label}"
    ]
    assert sum("/trajectories/" in path for path in own.products) == 2 * 3


def test_a_body_whose_degrees_of_freedom_are_not_known_yet_may_have_forty():
    assert plan().coordinates == 40
    named = plan(designs={"a": {"dofs": ["Heave", "Pitch"]}, "b": {"dofs": ["Heave", "Mode7"]}})
    assert named.coordinates == 3


def test_the_database_is_made_of_the_files_there_must_be(tmp_path):
    for ending in (".1", ".3", ".hst"):
        (tmp_path / f"run{ending}").write_text(ending)
    raw = {**RAW, "body": {"wamit": "run"}, "root": "out"}
    own = BodyPlan.of(raw, str(tmp_path / "raft.yaml"))
    assert [name.rpartition(".")[2] for name in own.inputs] == ["1", "3", "hst"]
    solved = plan_for(plan(body={"file": MESHED}).study, root="out")
    assert solved.sources == {"folder": "out/hydro/bodies", "green": solved.green_folder}
    assert solved.green_folder.startswith("out/hydro/green/capytaine-")


def test_files_are_named_from_where_a_run_begins(tmp_path, monkeypatch):
    (tmp_path / "raft.nc").write_text("numbers")
    monkeypatch.chdir(tmp_path)
    assert BodyPlan.of({**RAW, "body": {"database": "raft.nc"}}, tmp_path / "raft.yaml").inputs == ["raft.nc"]


MESHED = {"body": "raft", "mesh": "sha256:m", "modes": "sha256:d", "omega": [0.6, 0.9]}


def test_figures_are_those_of_the_band_of_all_seas_and_of_each_that_is_drawn():
    own = plan()
    band = ["absorbed_power", "reactance", "added_mass_damping", "radiation_kernel"]
    sea = ["port_motion", "degrees_of_freedom", "power_energy", "energy_audit"]
    first, second = (wave.label for wave in own.study.waves)
    each = [f"{name}-{label}" for label in (first, second) for name in sea]
    assert own.figures == [*band, "spectra", *each]
    assert plan(waves=RAW["waves"][:1]).figures == [*band, *each[:4]]


def test_a_body_read_of_a_file_may_meet_waves_up_to_twenty_radians_a_second():
    assert plan().highest == 20.0
    assert plan().solves is False


def test_every_stage_reads_the_directions_seas_water_and_take_off_of_the_study():
    waves = [{**RAW["waves"][0], "direction": 30.0}, {**RAW["waves"][1], "direction": -45.0}, {"kind": "still"}]
    pto, simulation = {"damping": 7.0, "port": {"dof": "Pitch"}}, {"duration": 90.0, "window": [50.0, 90.0]}
    own = plan(waves=waves, pto=pto, simulation=simulation, water={"depth": 30.0}, hydro={"omega_max": 3.0})
    study = own.study
    run = own.simulation("rigid", study.waves[1])
    assert own.response.directions == (30.0, -45.0)
    assert own.ladder.waves == study.waves
    for spec in (own.response, own.ladder, run):
        assert spec.water == study.water
        assert spec.pto.port == study.pto.port
    assert own.response.designs == own.ladder.designs == study.designs
    assert run.designs == {"rigid": study.designs["rigid"]}
    assert (run.waves, run.simulation) == (study.waves[1:2], study.simulation)
    assert own.ladder.simulation == study.simulation
    assert (own.database.water, own.database.omega_max, own.database.body) == (study.water, 3.0, study.body)
    assert own.radiation.database == content_id(own.database)
    assert (own.radiation.tolerance, own.radiation.added_mass_inf) == (0.01, "fitted")
    assert own.comparison.study == study


def test_only_what_is_solved_of_a_mesh_knows_the_version_of_what_solves_it():
    assert (plan(body={"file": MESHED}).database.solved, plan().database.solved) == (PHYSICS, 0)


def test_a_database_of_a_mesh_is_made_of_its_files_and_of_where_it_is_solved(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file.yaml").write_text("body: raft\nmesh: m.nc\nmodes: d.nc\nomega: [0.6, 0.9]\n")
    for name in ("m.nc", "d.nc"):
        (tmp_path / name).write_text(name)
    own = BodyPlan.of({**RAW, "body": "file.yaml", "root": "out"}, tmp_path / "raft.yaml")
    assert own.sources == {
        "mesh": "m.nc", "modes": "d.nc", "folder": "out/hydro/bodies", "green": own.green_folder,
    }  # fmt: skip
    assert own.inputs == ["m.nc", "d.nc", f"{own.green_folder}.done"]
