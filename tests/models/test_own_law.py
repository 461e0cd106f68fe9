"""Take-off laws of other packages: the example of the documentation, installed, in linear and body-exact runs."""

import re
import sys
import tomllib

import numpy as np
import pytest
import yaml
from conftest import HERE, SMALL, only_run, varied

from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.motion.forces import PortForce
from vsb.engine.motion.take_off import Pto
from vsb.errors import ConfigError
from vsb.models.build import design_in_sea
from vsb.pipeline.graph import StudyPlan
from vsb.stages.preview import check
from vsb.stages.simulate import run_simulate
from vsb.study.study import parse
from vsb.tools.files import load

PAGE = (
    (HERE.parent / "docs" / "extending.md")
    .read_text(encoding="utf-8")
    .split("## A take-off law of your own package\n")[1]
)


def block(language):
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.S)[1]


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Function version, code -> the package of the documentation as pip would leave it in a folder of packages."""
    monkeypatch.syspath_prepend(tmp_path)

    def installed(version="1.0", code=None):
        project = tomllib.loads(block("toml"))["project"]
        (tmp_path / "my_take_off.py").write_text(code or block("python"))
        sys.modules.pop("my_take_off", None)
        info = tmp_path / "my_take_off.dist-info"
        info.mkdir(exist_ok=True)
        info.joinpath("METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {version}\n")
        entries = project["entry-points"]["vsb.take_off_laws"]
        lines = "".join(f"{name} = {value}\n" for name, value in entries.items())
        info.joinpath("entry_points.txt").write_text(f"[vsb.take_off_laws]\n{lines}")

    yield installed
    sys.modules.pop("my_take_off", None)


def study(model="linear", **pto):
    raw = SMALL | {"pto": yaml.safe_load(block("yaml"))["pto"] | pto, "designs": {"FSB": {"flexible": False}}}
    return parse(raw | {"hydro": SMALL["hydro"] | {"model": model}})


def test_name_version_and_parameters_go_into_the_id(install):
    install("1.0")
    first = study()
    install("1.1")
    second, other = study(), study(parameters={"coefficient": 1.0, "exponent": 2.0, "ramp": 5.0})
    ids = {StudyPlan(one).simulation("FSB", one.waves[0]).id for one in (first, second, other)}
    assert len(ids) == 3
    assert (first.pto.distribution, second.pto.distribution) == ("my-take-off 1.0", "my-take-off 1.1")
    assert parse(first.model_dump()).pto == first.pto  # results of before are still read
    with pytest.raises(
        ConfigError, match=r"received my_take_off:law of my-take-off 1.1, needs that of my-take-off 1.0"
    ):
        check(StudyPlan(first))


@pytest.mark.parametrize("model", ["linear", pytest.param("body_exact", marks=pytest.mark.slow)])
def test_work_of_the_law_is_the_absorbed_power(model, install, small, tmp_path):
    install()
    one = study(model)
    check(StudyPlan(one))
    run_simulate(only_run(one), str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc")
    velocity, parameters = run.velocity.sel(dof="Heave").values, one.pto.parameters
    law = -parameters["coefficient"] * np.abs(velocity) ** 1.5 * np.sign(velocity) * np.clip(run.time / 5.0, 0, 1)
    assert run.pto.sel(dof="Heave").values == pytest.approx(law.values, rel=1e-9)
    assert run.attrs["energy_residual"] < 1e-5
    work = float(-np.trapezoid(law * velocity, run.time))
    assert float(run.energy.sel(term="pto")[-1]) == pytest.approx(work, rel=1e-4)
    assert "time" in run.attrs["no_steady_state"]


def test_linear_law_is_a_damper(install, small):
    """The steady state of a package's -c v is that of pto.damping."""
    install(code="def law(position, velocity, time, parameters):\n    return -parameters['c'] * velocity\n")
    own = design_in_sea(only_run(study(parameters={"c": 8000.0})), dict(small.hydro_files))
    known = varied(small.study, designs={"FSB": {"flexible": False}}, pto={"damping": 8000.0})
    damped = design_in_sea(only_run(known), dict(small.hydro_files))
    expected = harmonic_balance(damped.system, 1e-8).power.pto
    assert isinstance(own.scene.forces["pto"], PortForce)
    assert harmonic_balance(own.system, 1e-8).power.pto == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import no_such_module", r"my_take_off:law of my-take-off 1.0 cannot be imported \(No module named"),
        ("def law(s, v, t, p):\n    return v / 0.0 * t", r"received NaN or infinite values of my_take_off:law"),
        ("def law(s, v, t, p):\n    return 1.0", r"received shape \(\) of .*, needs a finite force .* shape \(3,\)"),
        ("def law(s, v, t, p):\n    return p['k'] * s", r"my_take_off:law of my-take-off 1.0 raised KeyError: 'k'"),
        ("def law(s, v):\n    return -v", r"raised TypeError"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero")
def test_laws_that_give_no_force_are_refused_before_a_run(code, message, install):
    install(code=code)
    one = study()
    with pytest.raises(ConfigError, match=message):
        check(StudyPlan(one))


@pytest.mark.parametrize(
    ("pto", "message"),
    [
        (
            {"law": "other:law"},
            r"law 'other:law': no installed package declares it; needs an entry point .*my_take_off:law",
        ),
        ({"law": "my_takeoff:lw"}, "did you mean my_take_off:law?"),
        ({"law": "my_take_off:law", "force_limit": 10.0}, "is the whole force; needs no force_limit"),
        ({"law": "coulomb", "force_limit": 10.0, "parameters": {"c": 1.0}}, "parameters: are of a law of a package"),
        ({"law": "a:b:c"}, "law 'a:b:c': no installed package declares it"),
    ],
)
def test_what_is_no_law_is_refused(pto, message, install):
    install()
    with pytest.raises(ConfigError, match=message):
        Pto(**pto)
