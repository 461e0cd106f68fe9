"""Design files: variables, limits, errors with file, line and key."""

import pytest
import yaml
from conftest import SEED

from vsb.errors import ConfigError
from vsb.pipeline.jobs import jobs
from vsb.pipeline.plans import planned
from vsb.study.design import is_design, load_design

RAW = {
    "design": "best",
    "study": "seed.yaml",
    "climate": {"spectra": "sea.txt"},
    "variables": {"device.radius": [1.4, 2.6], "device.young_modulus": {"log": [1e6, 1e9]}, "device.mass": [7e3, 2e4]},
    "limits": {"beam": 4.8},
}


SPHEROID = {
    "radius": 2.0, "thickness": 0.05, "young_modulus": 3e7, "poisson_ratio": 0.3, "density": 1100.0, "mass": 12e3,
    "shape": {"spheroid": {"height": 3.0}},
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "seed.yaml").write_text(SEED.read_text())
    (tmp_path / "sea.txt").write_text("spectra")
    return tmp_path


def written(folder, **changes):
    raw = {key: value for key, value in {**RAW, **changes}.items() if value is not None}
    (folder / "design.yaml").write_text(yaml.safe_dump(raw, sort_keys=False))
    return folder / "design.yaml"


def test_a_design_file_names_variables_limits_and_a_competitor(folder):
    loaded = load_design(written(folder))
    radius, modulus, _mass = loaded.problem.variables
    assert (radius.key, radius.low, radius.high, radius.log) == ("device.radius", 1.4, 2.6, False)
    assert modulus.log
    assert modulus.value(0.5) == pytest.approx(10**7.5)
    assert modulus.scaled(modulus.value(0.3)) == pytest.approx(0.3)
    step = 1e-6
    for one in (radius, modulus):
        slope = (one.value(0.4 + step) - one.value(0.4 - step)) / (2 * step)
        assert one.slope(one.value(0.4)) == pytest.approx(slope, rel=1e-8)
    assert [one.key for one in loaded.competing] == ["device.radius", "device.mass"]
    assert loaded.problem.limits.given == {
        "load_factor": 1.5, "static_strain": 0.1, "beam": 4.8, "spring_pull": 0.05,
    }  # fmt: skip
    assert loaded.problem.limits.without_shell().given == {"beam": 4.8, "spring_pull": 0.05}
    assert loaded.flexible == "VSWEC"
    assert loaded.rigid == "FSB"
    assert loaded.rigid_sections["designs"] == {"FSB": {"flexible": False}}
    assert "modes" not in loaded.rigid_sections
    assert is_design(RAW)
    assert not is_design({"campaign": "year"})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"device.mass": [10, 20]}, r"design.yaml:13: variables.device.mass: the shell alone has at least 665.* kg"),
        (
            {"device.mass": [9e5, 9.1e5]},
            r"variables.device.mass: every buoy sinks: the largest displaces 7.546e\+04 kg",
        ),
        ({"device.radius": [3, 4]}, r"limits.beam: received 4.8 m, which no buoy of VSWEC can keep: .* at least 6 m"),
        (
            {"device.radius": [2, 2.0000000001]},
            r"device.radius: received \[2, 2.0000000001\], needs .* by more than 1e-06",
        ),
        ({"limits": {"beam": 1.0}}, r"limits.beam: received 1 m, which no buoy of VSWEC can keep"),
        ({"limits": {"draft": 0.01}}, r"limits.draft: received 0.01 m, which no buoy of VSWEC can keep"),
        ({"limits": {"mass": 100}}, r"limits.mass: received 100 kg, which no buoy of VSWEC can keep: .* 7000 kg"),
        ({"pareto": {"beam": [0.5, 4.0]}}, r"pareto.beam: received 0.5 m, which no buoy of VSWEC can keep"),
        ({"pareto": {"force_rms": [1e4, 1e4]}}, "pareto.force_rms: received 10000, 10000; needs every value once"),
        ({"limits": {"damage": 1.0, "beam": 4.8}}, r"limits.damage: needs cycles of strain that the wall bears"),
    ],
)
def test_what_no_buoy_of_the_ranges_can_meet_is_refused(folder, changes, message):
    """Before anything is solved, and by whatever reads the file: the ranges or limits leave no buoy that floats."""
    variables = RAW["variables"] | {key: value for key, value in changes.items() if "." in key}
    others = {key: value for key, value in changes.items() if "." not in key}
    with pytest.raises(ConfigError, match=message):
        load_design(written(folder, **{"limits": RAW["limits"], **others, "variables": variables}))


@pytest.mark.parametrize(
    ("changes", "doubt"),
    [
        ({"limits": {"load_factor": 1e9, "beam": 4.8}}, "limits.load_factor: received 1e+09, usual are 1 to 20"),
        ({"limits": {"static_strain": 50, "beam": 4.8}}, "limits.static_strain: received 50, usual are 0.0001 to 1"),
        (
            {"uncertain": {"device.young_modulus": 1}},
            "uncertain.device.young_modulus: received 1, a standard deviation",
        ),
        ({"device.radius": [0.02, 400]}, "variables.device.radius: received 0.02 to 400, of which VSWEC floats within"),
        ({"device.mass": [1e3, 1e6]}, "variables.device.mass: received 1000 to 1e+06, of which VSWEC floats within"),
        (
            {"pto.stiffness": [1e10, 1e11]},
            "variables.pto.stiffness: received 1e+10 to 1e+11, all of which hold the buoy",
        ),
        ({"pto.damping": [1e9, 1e10]}, "variables.pto.damping: received 1e+09 to 1e+10, all of which hold the buoy"),
    ],
)
def test_what_is_probably_a_slip_is_doubted(folder, changes, doubt):
    variables = RAW["variables"] | {key: value for key, value in changes.items() if "." in key}
    others = {key: value for key, value in changes.items() if "." not in key}
    doubts = load_design(written(folder, **{"limits": RAW["limits"], **others, "variables": variables})).doubts
    assert any(line.startswith(doubt) for line in doubts)
    assert load_design(written(folder)).doubts == []


def test_what_to_know_before_solving(folder):
    """Power grows with size; and a damper that is optimal for power does not give way to a limit of its force."""
    assert load_design(written(folder, optimise="VSWEC")).notes == []
    (note,) = load_design(written(folder)).notes
    assert note.startswith("optimise: none given of the flexible designs")
    (note,) = load_design(written(folder, optimise="VSWEC", limits={"mass": 2e4})).notes
    assert "the radius will stand at its bound, 2.6 m" in note
    (note,) = load_design(written(folder, optimise="VSWEC", limits={"force_rms": 2e4})).notes
    assert note.startswith("limits.force_rms: the damper is the optimal one for power")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variables": {"device.radius": [2.6, 1.4]}}, r"design.yaml:5: variables: device.radius: received \[2.6, 1.4\], needs the lower bound first"),
        ({"variables": {"device.radius": 2}}, r"variables: device.radius: received 2, needs \[lowest, highest\] or"),
        ({"variables": {"device.radius": [1, 2, 3]}}, r"device.radius: received \[1, 2, 3\], needs \[lowest, highest\]"),
        ({"variables": {"device.radius": [True, 2]}}, "device.radius: received"),
        ({"variables": {"device.poisson_ratio": [0.3, 0.6]}}, "needs bounds above -0.99 and below 0.5"),
        ({"variables": {"device.thickness": [0, 0.1]}}, "needs bounds above 0"),
        ({"variables": {"pto.stiffness": {"log": [-1, 1]}}}, "needs bounds above 0 to be varied by the logarithm"),
        ({"variables": {"device.mass": [1, float("inf")]}}, "needs finite bounds"),
        ({"variables": {"device.masss": [1, 2]}}, "device.masss: needs one of .*; did you mean device.mass?"),
        ({"variables": {}}, r"variables: received \{\}, needs keys of the study"),
        ({"variables": {"device.thickness": [0.3, 0.4]}}, r"design.yaml:6: variables.device.thickness: thickness from 0.3 m"),
        ({"limits": {"bream": 4.8}}, r"design.yaml:\d+: limits.bream: received 4.8; unknown key; did you mean beam?"),
        ({"limits": {"mass": 1e3}, "variables": {"device.thickness": [0.01, 0.02]}}, r"design.yaml:\d+: limits.mass: received 1000 kg, and the mass is 17170 kg"),
        ({"limits": {"beam": -1}}, "limits.beam: received -1"),
        ({"maximise": "money"}, "maximise: received 'money'"),
        ({"competitor": {"variables": ["device.thickness"]}}, "competitor.variables: received device.thickness; a rigid buoy has only"),
        ({"competitor": {"variables": ["pto.stiffness"]}}, "competitor.variables: received pto.stiffness, which has no bounds"),
        ({"optimise": "FSB"}, "optimise: received 'FSB', needs a flexible design: VSWEC"),
        ({"design": "hydro"}, "'hydro' is the name of a results folder"),
        ({"design": "seed"}, "design: received 'seed', the name of its study"),
        ({"pareto": {"forces": [1.0]}}, r"design.yaml:\d+: pareto.forces: needs one of load_factor, .*did you mean force_rms"),
        ({"uncertain": {"pto.damping": 0.1}}, "uncertain.pto.damping: needs one of device.radius"),
        ({"uncertain": {"device.internal_pressure": 0.1}}, "uncertain.device.internal_pressure: seed.yaml has no"),
        ({"climate": {"spectra": "absent.txt"}}, r"design.yaml:\d+: climate: received absent.txt, which cannot be read"),
        ({"starts": 0}, "starts: received 0"),
        ({"tuning": "each"}, "tuning: received 'each'"),
        ({"tuning": "causal"}, r"design.yaml:\d+: limits: received no force_rms; tuning causal needs it"),
        ({"tuning": "causal", "limits": {"force_rms": 1e4}, "variables": {"pto.damping": [1e3, 1e5]}}, "variables.pto.damping: received with tuning causal, whose controller is the whole force"),
        ({"tuning": "causal", "limits": {"force_rms": 1e4}, "verify": {"seas": 8}}, "verify: received with tuning causal; runs in time of designs need one damper"),
        ({"study": "absent.yaml"}, "absent.yaml: cannot be read"),
    ],
)  # fmt: skip
def test_errors_in_a_design_file(folder, changes, message):
    with pytest.raises(ConfigError, match=message):
        load_design(written(folder, **changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"designs": {"FSB": {"flexible": False}}}, "study: received seed.yaml without a flexible design"),
        ({"hydro": {"model": "assumed_pressure", "pressure": 1800.0}}, "which knows no waves"),
        (
            {"pto": {"damping": 8000.0, "force_limit": 1000.0}},
            r"a nonlinear take-off \(force_limit: 1000\).*needs law: linear",
        ),
        ({"pto": {"damping": 8000.0, "law": "latching"}}, r"\(law: latching\).*or tuning: causal"),
        ({"pto": {"damping": 8000.0, "port": "volume"}}, "pto.port that a rigid buoy does not move.*needs heave"),
        ({"pto": {"damping": 8000.0, "port": {"colatitude": 0, "against": "frame"}}}, "a rigid buoy does not move"),
        ({"pto": {"control": {"force_rms": 1e3}}}, r"study: pto.control.force_rms: received 1000; that of a design is"),
    ],
)
def test_studies_whose_year_has_no_derivatives_are_refused(folder, changes, message):
    raw = {**yaml.safe_load(SEED.read_text()), **changes}
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    with pytest.raises(ConfigError, match=message):
        load_design(written(folder))


def test_what_is_known_without_losses_alone_is_refused_with_an_efficiency(folder):
    raw = {**yaml.safe_load(SEED.read_text()), "pto": {"efficiency": 0.9}}
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    load_design(written(folder))
    with pytest.raises(ConfigError, match=r"tuning: received causal with pto.efficiency 0.9 .* or tuning: one"):
        load_design(written(folder, tuning="causal", limits={"force_rms": 1e4}))
    with pytest.raises(ConfigError, match=r"verify: received with pto.efficiency 0.9"):
        load_design(written(folder, verify={"seas": 8}))


def test_a_climate_is_known_by_its_contents_wherever_it_lies(folder):
    """Neither the ids nor the files that jobs need change with its path, so nothing runs again."""
    (folder / "moved.txt").write_text("spectra")
    plans = [
        planned({**RAW, "climate": {"spectra": name}}, str(folder / "x.yaml")) for name in ("sea.txt", "moved.txt")
    ]
    first, second = (
        {(job.makes, job.needs, job.ids) for job in jobs(plan) if job.rule == "design_start"} for plan in plans
    )
    assert first == second
    assert not any(str(folder) in need for job in jobs(plans[0]) for need in job.needs)


def test_the_height_of_a_spheroid_may_be_varied_by_rigid_buoys_too(folder):
    raw = {**yaml.safe_load(SEED.read_text()), "device": {**SPHEROID}, "modes": {"degree": 4}}
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    variables = {"device.shape.spheroid.height": [2.0, 5.0], "device.thickness": [0.05, 0.1]}
    limits = {"load_factor": 2.0, "beam": 4.8}
    loaded = load_design(written(folder, optimise="VSWEC", variables=variables, limits=limits))
    assert [one.key for one in loaded.competing] == ["device.shape.spheroid.height"]
    assert loaded.notes == []
    with pytest.raises(ConfigError, match=r"seed.yaml has no device.shape.capsule.length"):
        load_design(written(folder, variables={"device.shape.capsule.length": [1.0, 2.0]}))
    del raw["device"]["mass"]  # half immersed: a draft of one shape
    (folder / "seed.yaml").write_text(yaml.safe_dump(raw))
    with pytest.raises(
        ConfigError, match=r"device.shape.spheroid.height: received with the draft .* needs device.mass"
    ):
        load_design(written(folder, optimise="VSWEC", variables=variables, limits=limits))


def test_a_clamp_and_structural_damping_may_be_varied(folder):
    variables = {"designs.VSWEC90.clamp": [60, 120], "device.damping.beta": {"log": [1e-4, 1e-2]}}
    loaded = load_design(written(folder, optimise="VSWEC90", variables=variables))
    assert [one.key for one in loaded.problem.variables] == ["device.damping.beta", "designs.VSWEC90.clamp"]
    with pytest.raises(ConfigError, match=r"variables.designs.VSWEC90.clamp: received a clamp that VSWEC, which is"):
        load_design(written(folder, variables=variables))
    with pytest.raises(ConfigError, match=r"variables: designs.VSWEC90.clamp: .*needs bounds above 0 and below 180"):
        load_design(written(folder, optimise="VSWEC90", variables={"designs.VSWEC90.clamp": [0, 90]}))
    with pytest.raises(ConfigError, match=r"variables.device.material.mu: seed.yaml has no device.material.mu"):
        load_design(written(folder, variables={"device.material.mu": [1e5, 1e6]}))


def test_a_study_of_a_body_is_refused(folder):
    (folder / "seed.yaml").write_text("study: raft\nbody: raft.nc\n")
    with pytest.raises(ConfigError, match=r"study: received seed.yaml, a study of a body; needs a buoy"):
        load_design(written(folder))


def test_the_shipped_example_is_valid():
    loaded = load_design(SEED.parents[2] / "config" / "best_buoy.yaml")
    assert loaded.notes == []
