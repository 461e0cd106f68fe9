"""Campaign files: base study, points, errors."""

import pytest
import yaml
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.campaign import load, sections, study_at
from vsb.study.study import load as load_study
from vsb.study.study import parse

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


def test_paths_are_relative_to_the_campaign_file(folder, monkeypatch):
    monkeypatch.chdir("/")
    loaded = load(written(folder))
    assert loaded.base == load_study(SEED)
    assert loaded.climate_path == str(folder / "sea.txt")
    assert loaded.tuning == ("fixed", "one", "each")


@pytest.mark.parametrize(
    ("changes", "message"),
    [({"campaign": "hydro"}, "campaign: received 'hydro'; 'hydro' is the name of a results folder"),
        ({"campaign": "seed"}, "campaign: received 'seed', the name of its study; needs another"),
        ({"climate": {"spectra": "sea.txt", "gamma": 2}}, "gamma: received 2; unknown key"),
        ({"climate": None}, "climate: "),
        ({"climate": 5}, "climate: received 5; needs a mapping of keys and values"),
        ({"tuning": ["each", "each"]}, "tuning: .*needs every tuning once"),
        ({"vary": {"device.mass": 3}}, "vary: device.mass: received 3, needs a list"),
        ({"verify": {"seas": 5}}, "verify.seas: received 5"),
        (
            {"verify": {}, "vary": {"device.mass": {"linear": [1.6e4, 1.75e4, 501]}}},
            "verify: received a campaign of 501 points, each of which is simulated in time; needs at most 500",
        ),
        ({"waves": []}, "waves: .*unknown key"),
        ({"constrained": {"seconds": 5}}, "constrained: applies with the tuning constrained only; add it"),
        ({"vary": {"pto.port": ["pitch", "heave"]}}, "vary.pto.port: received heave, pitch, whose dampers and forces"),
        (
            {"verify": {}, "tuning": ["constrained"]},
            "verify: received tuning constrained alone, whose forces are of no law in time; needs fixed, one, each",
        )],
)  # fmt: skip
def test_errors_in_a_campaign_file(folder, changes, message):
    with pytest.raises(ConfigError, match=message) as caught:
        load(written(folder, **changes))
    assert "\n" not in str(caught.value)


def test_point_sets_its_keys_only():
    base = sections(load_study(SEED))
    one = study_at(base, {"device.young_modulus": 5e6, "designs.VSWEC0.clamp": 10.0})
    assert one.device.young_modulus == 5e6
    assert one.designs["VSWEC0"].clamp == (10.0,)
    assert one.device.model_copy(update={"young_modulus": 1e7}) == load_study(SEED).device
    assert study_at(base, {}).hydro.model == "linear"


def test_year_does_not_depend_on_time_domain_settings():
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


INERTIA = {"device.ballast_inertia": 9e3, "device.ballast_yaw_inertia": 9e3}


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ({"device.stiff": 1.0}, "with device.stiff: 1.0: device.stiff: received 1.0; unknown key"),
        ({"device.thickness": 1.0}, "with device.thickness: 1.0: device: thickness 1 m"),
        ({"device.mass.of": 1.0}, "device.mass.of: mass is a value, which has no key of"),
        ({"designs.NONE.clamp": 1.0}, "designs.NONE.clamp: the study has no NONE; needs one of FSB, VSWEC"),
        ({"drag": {"heave": {"coefficient": 1.0, "area": 3.0}}}, "drag: a year is computed by linear theory"),
        ({"motion": "free", "device.centre_of_mass": -0.6} | INERTIA, "motion: received 'free'; the seas of a year"),
        ({"scale": 0.0}, "scale: received 0.0, needs 0.001 to 1000"),
    ],
)
def test_errors_of_a_point(point, message):
    with pytest.raises(ConfigError, match=message):
        study_at(sections(load_study(SEED)), point)


def test_froude_scaling_keeps_water_and_density():
    """A buoy four times as large in the same water."""
    seed, large = load_study(SEED), study_at(sections(load_study(SEED)), {"scale": 4.0})
    assert large.device.radius == 4 * seed.device.radius
    assert large.draft / large.device.radius == pytest.approx(seed.draft / seed.device.radius, rel=1e-12)
    assert large.hydro.omega_max == seed.hydro.omega_max / 2
    assert large.pto.damping == 32 * seed.pto.damping
    assert large.device.damping.beta == 2 * seed.device.damping.beta
    assert (large.device.density, large.water) == (seed.device.density, seed.water)
    assert study_at(sections(seed), {"scale": 4.0, "device.mass": 2e6}).device.mass == 2e6


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tuning": ["constrained"]}, "tuning: received constrained, and a study with several ports"),
        ({"tuning": ["fixed"]}, "tuning: received fixed, but seed.yaml has no pto.damping"),
        ({"vary": {"pto.port": ["heave", "volume"]}}, "vary.pto.port: received several ports in the study"),
    ],
)
def test_damper_matrices_of_a_year_are_linear_and_unlimited(folder, changes, message):
    pto = {"ports": {"a": "heave", "b": "volume"}}
    (folder / "seed.yaml").write_text(yaml.safe_dump({**yaml.safe_load(SEED.read_text()), "pto": pto}))
    with pytest.raises(ConfigError, match=message):
        load(written(folder, **changes))


def test_a_varied_damper_is_refused_where_every_tuning_has_its_own(folder):
    """Its points would be the same, under names that say otherwise."""
    dampers = {"pto.damping": [1e4, 2e4]}
    load(written(folder, vary=dampers, tuning=["fixed", "one"]))
    with pytest.raises(ConfigError, match=r"vary: pto.damping: received without the tuning fixed.* needs fixed in"):
        load(written(folder, vary=dampers, tuning=["one", "each"]))


def test_conversion_with_losses_is_known_of_dampers_and_causal_control(folder):
    lossy = varied(load_study(SEED), pto={"efficiency": 0.8})
    sprung = varied(load_study(SEED), pto={"efficiency": 0.8, "stiffness": 1e3})
    load(written(folder, tuning=["fixed", "one", "each", "causal"])).check_take_off(lossy, "here")
    load(written(folder, tuning=["damper_same_force", "causal"])).check_take_off(sprung, "here")
    for tuning, study, message in (
        (["one", "constrained"], lossy, r"here: pto.efficiency: received 0.8; optima of tuning constrained"),
        (["one", "causal"], sprung, r"here: pto.stiffness: received 1000 with an efficiency of 0.8.* tuning one"),
    ):
        with pytest.raises(ConfigError, match=message):
            load(written(folder, tuning=tuning)).check_take_off(study, "here")


@pytest.mark.parametrize(
    ("pto", "message"),
    [
        ({"stiffness": 1e3}, "here: pto.stiffness: received 1000.0; runs in time of tuning causal need 0.0"),
        ({"efficiency": 0.9}, "here: pto.efficiency: received 0.9; runs in time of tuning causal need 1.0"),
        ({"control": {"forecast": 2.0}}, "here: pto.control.forecast: received 2.0; runs in time of tuning causal"),
        ({"law": "coulomb", "force_limit": 1e3}, "here: pto.law: received coulomb; runs in time of tuning causal need"),
    ],
)
def test_causal_control_is_verified_where_its_law_can_run(folder, pto, message):
    loaded = load(written(folder, tuning=["damper_same_force", "causal"], verify={"seas": 4}))
    loaded.check_take_off(varied(load_study(SEED), pto={"force_limit": 2e3}), "here")
    with pytest.raises(ConfigError, match=message):
        loaded.check_take_off(varied(load_study(SEED), pto=pto), "here")


def test_switching_take_off_needs_time_domain_or_constrained_optimum(folder):
    switching = varied(load_study(SEED), pto={"force_limit": 2e3})
    for tuning, blind in ((["fixed"], "fixed"), (["one", "constrained"], "one"), (["constrained"], "")):
        loaded = load(written(folder, tuning=tuning))
        if blind:
            with pytest.raises(ConfigError, match=rf"linear theory of tuning {blind} does not see; needs tuning: "):
                loaded.check_take_off(switching, "here")
        else:
            loaded.check_take_off(switching, "here")
