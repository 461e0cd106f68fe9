"""A campaign file: the study it names, its points, what is refused."""

import hashlib

import pytest
import yaml
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.campaign import Campaign, Scatter, _scale, load, sections, study_at, where_of
from vsb.study.device import Gas
from vsb.study.froude import scaled
from vsb.study.study import content_id, parse
from vsb.study.study import load as load_study

RAW = {"campaign": "year", "study": "seed.yaml", "climate": {"spectra": "sea.txt"}}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "seed.yaml").write_text(SEED.read_text())
    (tmp_path / "sea.txt").write_text("spectra")
    return tmp_path


def written(folder, **changes):
    raw = {key: value for key, value in {**RAW, **changes}.items() if value is not None}
    (folder / "campaign.yaml").write_text(yaml.safe_dump(raw))
    return folder / "campaign.yaml"


def test_files_are_relative_to_the_campaign_s(folder, monkeypatch):
    monkeypatch.chdir("/")
    loaded = load(written(folder))
    assert loaded.base == load_study(SEED)
    assert loaded.climate_path == str(folder / "sea.txt")
    assert loaded.tuning == ("fixed", "one", "each")


def test_what_is_not_there_is_told_by_its_kind(folder):
    with pytest.raises(
        ConfigError, match=r"absent.yaml: cannot .*; give the path of a campaign file such as config/year.yaml$"
    ):
        load(folder / "absent.yaml")
    with pytest.raises(
        ConfigError, match=r"absent.yaml: cannot .*; give the path of a study file such as config/buoy.yaml$"
    ):
        load(written(folder, study="absent.yaml"))
    told = (
        r"climate: received absent.txt, which cannot be read \(No such file or directory\); needs the path of a file, "
        "relative to this one$"
    )
    with pytest.raises(ConfigError, match=told):
        load(written(folder, climate={"spectra": "absent.txt"}))


def test_the_climate_counts_by_its_contents(folder):
    before = load(written(folder)).climate_id
    assert before == hashlib.sha256(b"spectra").hexdigest()[:16]
    (folder / "other.txt").write_text("spectra")
    assert load(written(folder, climate={"spectra": "other.txt"})).climate_id == before
    (folder / "sea.txt").write_text("other spectra")
    assert load(written(folder)).climate_id != before


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"campaign": "hydro"}, "campaign: received 'hydro'; 'hydro' is the name of a results folder"),
        ({"campaign": "seed"}, "campaign: received 'seed', the name of its study; needs another"),
        ({"study": "absent.yaml"}, "absent.yaml: cannot be read"),
        ({"climate": {"spectra": "absent.txt"}}, "climate: received absent.txt, which cannot be read"),
        ({"climate": {"spectra": "sea.txt", "gamma": 2}}, "gamma: received 2; unknown key"),
        ({"climate": None}, "climate: "),
        ({"climate": 5}, "climate: received 5; needs a mapping of keys and values"),
        ({"climate": {"scatter": "sea.txt", "gamma": 20}}, "gamma: received 20"),
        ({"tuning": ["each", "each"]}, "tuning: .*needs every tuning once"),
        ({"tuning": ["best"]}, "tuning.0: received 'best'"),
        ({"vary": {"device.mass": 3}}, "vary: device.mass: received 3, needs a list"),
        ({"verify": {"seas": 5}}, "verify.seas: received 5"),
        ({"verify": {"seas": 2}}, "verify.seas: received 2"),
        ({"verify": {"model": "auto"}}, "verify.model: received 'auto'"),
        (
            {"verify": {}, "vary": {"device.mass": [1.6e4, 1.65e4, 1.7e4, 1.72e4, 1.75e4]}},
            "verify: received a campaign of 5 points, each of which is simulated in time; needs at most 4",
        ),
        ({"waves": []}, "waves: .*unknown key"),
        ({"constrained": {"seconds": 0}, "tuning": ["constrained"]}, "constrained.seconds: received 0"),
        ({"constrained": {"seconds": 5}, "tuning": ["one"]}, "constrained: received without that tuning; needs const"),
        ({"constrained": {"seconds": 5}}, "constrained: received without that tuning; needs constrained among tuning"),
        (
            {"vary": {"pto.port": ["pitch", "heave"]}},
            "vary.pto.port: received heave, pitch, whose dampers and forces have other units; needs pitch alone, or",
        ),
        (
            {"vary": {"pto.port": ["volume", "heave"]}},
            "vary.pto.port: received heave, volume, whose dampers and forces have other units; needs volume alone, or",
        ),
        (
            {"vary": {"pto.port": ["pitch", "volume", "heave"]}},
            "vary.pto.port: received heave, pitch, volume, whose dampers .* units; needs volume alone, or others without it",
        ),
        (
            {"verify": {}, "tuning": ["constrained"]},
            "verify: received tuning constrained alone, whose forces are of no law in time; needs fixed, one or each",
        ),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_one_line(folder, changes, message):
    with pytest.raises(ConfigError, match=message) as caught:
        load(written(folder, **changes))
    assert "\n" not in str(caught.value)


def test_an_assumed_pressure_has_no_year(folder):
    raw = yaml.safe_load(SEED.read_text())
    raw["hydro"] = {"model": "assumed_pressure", "pressure": 1800.0}
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    with pytest.raises(ConfigError, match=r"hydro\.model 'assumed_pressure', which knows no waves"):
        load(written(folder))


def test_without_a_damper_no_tuning_is_fixed(folder):
    raw = yaml.safe_load(SEED.read_text())
    del raw["pto"]
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    assert load(written(folder)).tuning == ("one", "each")
    with pytest.raises(ConfigError, match=r"tuning: received fixed, but seed\.yaml has no pto.damping"):
        load(written(folder, tuning=["fixed"]))


def test_no_tuning_is_said_by_nothing_too(folder):
    (folder / "campaign.yaml").write_text(yaml.safe_dump({**RAW, "tuning": None}))
    assert load(folder / "campaign.yaml") == load(written(folder))


def test_a_table_of_occurrences_made_in_python_is_one():
    table = Scatter(scatter="sea.csv", gamma=2.0)
    assert Campaign(campaign="year", study="seed.yaml", climate=table).climate is table


def test_a_budget_stands_for_itself_where_optima_are_asked_for(folder):
    assert load(written(folder, tuning=["one"])).constrained is None
    assert load(written(folder, tuning=["one", "constrained"])).constrained.seconds == 10.0
    given = {"tuning": ["constrained"], "constrained": {"seconds": 3, "seed": 2}}
    assert load(written(folder, **given)).constrained.model_dump() == {"seconds": 3.0, "seed": 2}


def test_a_point_sets_keys_and_nothing_else():
    base = sections(load_study(SEED))
    one = study_at(base, {"device.young_modulus": 5e6, "designs.VSWEC0.clamp": 10.0})
    assert one.device.young_modulus == 5e6
    assert one.designs["VSWEC0"].clamp == (10.0,)
    assert one.device.model_copy(update={"young_modulus": 1e7}) == load_study(SEED).device
    assert study_at(base, {}).hydro.model == "linear"


def test_a_point_sets_a_key_of_a_section_that_is_off_by_default():
    base = sections(load_study(SEED))
    assert base["device"]["gas"] is None
    one = study_at(base, {"device.gas.adiabatic_index": 1.2})
    assert one.device.gas == Gas(adiabatic_index=1.2)
    assert one.device.model_copy(update={"gas": None}) == load_study(SEED).device


def test_a_year_depends_on_nothing_that_only_a_run_in_time_has():
    """Waves, runs, the model and its tolerance, the name, figures published elsewhere: left out of a point."""
    seed = load_study(SEED)
    changed = {
        "waves": [{"kind": "regular", "amplitude": 0.1, "period": 3.0}],
        "simulation": {"duration": 77.0},
        "published": {"source": "x", "values": {"FSB": {"energy": 1.0}}},
        "hydro": {"model": "auto", "power_tolerance": 0.02},
    }
    other = parse({**varied(seed, **changed).model_dump(), "study": "other"})
    assert sections(other) == sections(seed)
    assert study_at(sections(other), {}) == study_at(sections(seed), {})
    assert sections(varied(seed, pto={"damping": 1.0})) != sections(seed)


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ({"device.stiff": 1.0}, "with device.stiff: 1.0: device.stiff: received 1.0; unknown key"),
        ({"device.thickness": 1.0}, "with device.thickness: 1.0: device: thickness 1 m"),
        ({"device.mass.of": 1.0}, "device.mass.of: mass is a value, which has no key of"),
        ({"designs.NONE.clamp": 1.0}, "designs.NONE.clamp: the study has no NONE; needs one of FSB, VSWEC"),
        ({"pto.efficiency": 0.8}, r"with pto.efficiency: 0.8: pto.efficiency: received 0.8; a year needs 1"),
        (
            {"drag": {"heave": {"coefficient": 1.0, "area": 3.0}}},
            "drag: a year is of linear theory, in which what waves",
        ),
        ({"scale": 0.0}, "scale: received 0.0, needs 0.001 to 1000"),
        ({"scale": "big"}, "scale: received 'big'"),
    ],
)
def test_a_point_without_a_study_is_told_in_one_line(point, message):
    with pytest.raises(ConfigError, match=message):
        study_at(sections(load_study(SEED)), point)


def test_a_point_is_told_by_its_values_in_their_order():
    assert where_of({"scale": 2.0, "modes.basis": "full"}) == "with scale: 2.0, modes.basis: full"
    assert where_of({}) == "with nothing varied"
    with pytest.raises(ConfigError, match=r"^with nothing varied: pto.efficiency: received 0.8; a year needs 1"):
        study_at(sections(varied(load_study(SEED), pto={"efficiency": 0.8})), {})


def test_a_scale_is_taken_up_to_a_thousand_either_way():
    assert [_scale(1e-3), _scale(1e3)] == [1e-3, 1e3]
    for beyond in (0.999e-3, 1.001e3):
        with pytest.raises(ConfigError, match=r"needs 0.001 to 1000"):
            _scale(beyond)


def test_scaled_by_one_is_the_study_itself():
    raw = load_study(SEED).model_dump()
    assert content_id(parse(scaled(raw, 1.0))) == content_id(load_study(SEED))


def test_froude_scales_everything_but_water_and_density():
    """A buoy four times as large in the same water: sqrt(g/r), draft over radius, |Z|/(rho sqrt(g) r^2.5) stay."""
    seed, large = load_study(SEED), study_at(sections(load_study(SEED)), {"scale": 4.0})
    assert large.device.radius == 4 * seed.device.radius
    assert large.draft / large.device.radius == pytest.approx(seed.draft / seed.device.radius, rel=1e-12)
    assert large.hydro.omega_max == seed.hydro.omega_max / 2
    assert large.pto.damping == 32 * seed.pto.damping
    assert large.device.damping.beta == 2 * seed.device.damping.beta
    assert (large.device.density, large.water) == (seed.device.density, seed.water)
    assert study_at(sections(seed), {"scale": 4.0, "device.mass": 2e6}).device.mass == 2e6


def test_dampers_of_designs_are_scaled_as_dampers():
    assert scaled({"pto": {"damping": {"FSB": 1.0}, "law": "linear"}, "flexible": True}, 4.0) == {
        "pto": {"damping": {"FSB": 32.0}, "law": "linear"},
        "flexible": True,
    }


@pytest.mark.parametrize("ports", [["volume"], ["heave"], ["heave", "surge"], ["pitch"]])
def test_ports_of_one_unit_may_be_varied(folder, ports):
    assert load(written(folder, vary={"pto.port": ports})).campaign.vary.values["pto.port"] == tuple(ports)


@pytest.mark.parametrize("name", ["hydro", "hydro_precision", "barge", "logs", "benchmarks"])
def test_no_campaign_has_the_name_of_a_folder(folder, name):
    with pytest.raises(ConfigError, match=rf"campaign: received '{name}'; '{name}' is the name of a results folder"):
        load(written(folder, campaign=name))


def test_what_a_study_says_enough_for_may_be_asked_for_alone(folder):
    assert load(written(folder, tuning=["fixed"])).tuning == ("fixed",)
    four = {"device.mass": [1.6e4, 1.65e4, 1.7e4, 1.72e4]}
    assert len(load(written(folder, vary=four, verify={})).campaign.vary.points) == 4


def test_a_year_is_of_spheres(folder):
    raw = yaml.safe_load(SEED.read_text())
    raw["device"] |= {"shape": {"spheroid": {"height": 3.0}}, "mass": 9000.0}
    raw |= {"modes": {"basis": "full", "degree": 2}}
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    with pytest.raises(ConfigError, match=r"study: received seed.yaml with device.shape, whose buckling, which a year"):
        load(written(folder))


def test_runs_in_time_check_the_tuning_a_campaign_is_told_at_alone(folder):
    """Not the first: of the others linear theory says what it does not see."""
    loaded = load(written(folder, tuning=["fixed", "one"], verify={}))
    switching = varied(load_study(SEED), pto={"law": "latching"})
    needed = r"needs tuning: \[constrained\], or \[fixed\] with verify$"
    with pytest.raises(
        ConfigError,
        match=rf"^here: pto: received law latching, .* which linear theory of tuning fixed does not see; {needed}",
    ):
        loaded.check_take_off(switching, "here")
    limited = varied(load_study(SEED), pto={"force_limit": 2e3, "stroke_limit": 0.5})
    with pytest.raises(ConfigError, match=r"received law linear, force_limit 2000 N, stroke_limit 0.5 m, which linear"):
        loaded.check_take_off(limited, "here")
    loaded.check_take_off(load_study(SEED), "here")
    load(written(folder, tuning=["fixed", "constrained"], verify={})).check_take_off(switching, "here")


@pytest.mark.parametrize("device", [{"mass": 17170.0}, {"draft": 1.8}, {}], ids=str)
@pytest.mark.parametrize("vary", [("device.radius",), ("device.radius", "scale"), ("scale",)], ids=str)
@pytest.mark.parametrize("beside", [None, "device.mass", "device.draft"])
def test_a_mass_stays_behind_a_radius_and_a_draft_behind_one_of_a_scaled_buoy(folder, device, vary, beside):
    """Unless either is varied, too; what is half immersed follows in any case."""
    raw = yaml.safe_load(SEED.read_text())
    raw["device"] = {key: value for key, value in raw["device"].items() if key != "mass"} | device
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    varied = {"device.radius": [2.0, 2.5], "scale": [1.0, 2.0], "device.mass": [1.7e4], "device.draft": [1.7]}
    asked = written(folder, vary={key: varied[key] for key in (*vary, beside) if key})
    stays = {"mass"} if "scale" not in vary else {"mass", "draft"}
    if "device.radius" in vary and stays & set(device) and beside is None:
        (key,) = device
        with pytest.raises(ConfigError, match=rf"vary: device.radius: received with device.{key} {device[key]:g} as"):
            load(asked)
    else:
        assert load(asked).floats_by == pytest.approx(device)


def test_a_take_off_that_switches_is_seen_by_a_run_in_time_or_by_its_own_optimum_alone(folder):
    switching = varied(load_study(SEED), pto={"force_limit": 2e3})
    for tuning, blind in ((["fixed"], "fixed"), (["one", "constrained"], "one"), (["constrained"], "")):
        loaded = load(written(folder, tuning=tuning))
        if blind:
            with pytest.raises(ConfigError, match=rf"linear theory of tuning {blind} does not see; needs tuning: "):
                loaded.check_take_off(switching, "here")
        else:
            loaded.check_take_off(switching, "here")


def test_a_year_is_of_waves_that_go_one_way_in_the_plane_or_not():
    device = {"centre_of_mass": -0.5, "ballast_inertia": 8e3, "ballast_yaw_inertia": 7e3}
    base = sections(varied(load_study(SEED), device=device))
    assert [study_at(base, {"motion": motion}).motion for motion in ("heave", "planar")] == ["heave", "planar"]
    with pytest.raises(ConfigError, match=r"^with motion: free: motion: received 'free'; the seas of a year have no"):
        study_at(base, {"motion": "free"})


def test_a_damper_of_nothing_is_one_that_may_be_fixed(folder):
    raw = yaml.safe_load(SEED.read_text())
    raw["pto"] |= {"damping": 0.0}
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    assert load(written(folder)).tuning == ("fixed", "one", "each")
    assert load(written(folder, tuning=["fixed"])).tuning == ("fixed",)


def test_a_long_climate_counts_to_its_last_byte(folder):
    found = set()
    for last in (b"a", b"b"):
        (folder / "sea.txt").write_bytes(bytes(3 * 2**20) + last)
        found.add(load(written(folder)).climate_id)
    assert len(found) == 2


def test_a_study_is_scaled_before_keys_are_set_in_whatever_order_they_are_varied():
    base = sections(load_study(SEED))
    one, other = study_at(base, {"scale": 4.0, "device.mass": 2e6}), study_at(base, {"device.mass": 2e6, "scale": 4.0})
    assert one == other
    assert (other.device.mass, other.device.radius) == (2e6, 8.0)


def test_a_damper_that_is_not_there_is_missed_wherever_fixed_stands(folder):
    raw = yaml.safe_load(SEED.read_text())
    del raw["pto"]
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    for tuning in (["one", "fixed"], ["each", "one", "fixed"]):
        with pytest.raises(
            ConfigError, match=r"tuning: received fixed, but seed\.yaml has no pto.damping; needs one in"
        ):
            load(written(folder, tuning=tuning))


def test_a_tuning_that_does_not_see_the_take_off_is_told_wherever_it_stands(folder):
    switching = varied(load_study(SEED), pto={"force_limit": 2e3})
    for tuning, blind in ((["constrained", "one"], "one"), (["constrained", "each", "fixed"], "each")):
        with pytest.raises(ConfigError, match=rf"linear theory of tuning {blind} does not see; needs tuning: "):
            load(written(folder, tuning=tuning)).check_take_off(switching, "here")
