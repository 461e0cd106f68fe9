"""The documentation: pages written from the code, links that lead somewhere, examples that run."""

import doctest
import importlib
import importlib.util
import json
import re
import tomllib
from pathlib import Path

import pytest
import yaml

import vsb
from vsb.cli import main, parser
from vsb.hydro.bodies.body import detected_symmetry
from vsb.hydro.bodies.files import read_body
from vsb.hydro.bodies.hydrostatics import linear_share
from vsb.hydro.bodies.study import read_config
from vsb.study.body import BodyStudy, load_body
from vsb.study.body_file import BodyFile
from vsb.study.campaign_plan import plan_of
from vsb.study.schema import dotted, schema_of
from vsb.study.study import Study, load
from vsb.tools.completion import commands, options
from vsb.waves.scatter import read_scatter

HOME = Path(__file__).parent.parent
PAGES = sorted([*HOME.glob("*.md"), *(HOME / "docs").glob("*.md"), *(HOME / "docs" / "decisions").glob("*.md")])
GENERATED = {f"reference/{name}.md" for name in ("keys", "commands", "python")}


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("generate", HOME / "docs" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_key_stands_in_the_reference_once_per_section(generate):
    page = generate.keys_page()
    for model in (Study, BodyStudy, BodyFile):
        for name in dotted(schema_of(model)):
            assert f"\n| `{name.rpartition('.')[2]}` |" in page
    assert page.count("| `young_modulus` | Young's modulus of the shell | Pa | **required** | from 1 to 1e+16 |") == 1
    assert "| `depth` | depth of the sea; .inf is deep water | m | `.inf` | above 0 |" in page
    assert "### `device.damping`" in page
    assert "### `waves: jonswap`" in page


def test_ranges_are_those_that_are_checked(generate):
    found = [generate.allowed(its) for its in (
        {"type": "number", "exclusiveMinimum": 0}, {"type": "number", "exclusiveMinimum": 0, "minimum": 0.1, "maximum": 2},
        {"type": "number", "exclusiveMinimum": -1, "minimum": -0.99, "exclusiveMaximum": 0.5, "maximum": 0.5},
        {"enum": ["a", "b"]}, {"type": "integer", "minimum": 1}, {"type": "array", "items": {"type": "number", "minimum": 0}},
        {"anyOf": [{"type": "number", "minimum": 0}, {"type": "null"}]}, {"type": "string"},
    )]  # fmt: skip
    assert found == ["above 0", "from 0.1 to 2", "from -0.99 below 0.5", "`a`, `b`", "whole from 1", "list, each from 0",
                     "from 0", ""]  # fmt: skip


NAMED = [
    (str(page.relative_to(HOME)), name)
    for page in PAGES
    if page.parent.name != "decisions" and page.name != "CHANGELOG.md"
    for name in sorted(set(re.findall(r"`([a-z_/]+\.(?:py|smk))`", page.read_text(encoding="utf-8"))))
]


@pytest.mark.parametrize(("page", "name"), NAMED)
def test_files_of_code_that_a_page_names_are_there(page, name):
    assert any((folder / name).is_file() for folder in (HOME, HOME / "vsb", HOME / "docs", HOME / "examples"))


def test_every_command_and_option_stands_in_the_reference(generate):
    page = generate.commands_page()
    for name, one in commands(parser()).items():
        assert f"## `vsb {name}`" in page
        assert all(option in page for option in options(one))


def test_every_public_name_stands_in_the_reference(generate):
    page = generate.python_page()
    assert {name for name in vsb.__all__ if f"## `{name}`" not in page} == set()


def anchors(path):
    """Anchors of a page's headings, as GitHub and MyST make them."""
    heads = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(HOME)))
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        target, _, anchor = link.partition("#")
        if target.startswith(("http", "mailto:")) or target in GENERATED:
            continue
        place = (page.parent / target).resolve() if target else page
        assert place.exists(), f"{page}: {link}"
        assert not anchor or anchor in anchors(place), f"{page}: {link}"


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", (HOME / "docs" / page).read_text(encoding="utf-8"), re.S | re.M)


def test_the_body_of_the_documentation_is_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (program,), (file, made, *_) = blocks("own-body.md", "python"), blocks("own-body.md", "yaml")
    exec(program, {})
    Path("raft.yaml").write_text(file)
    Path("my_raft.yaml").write_text(made)
    assert set(load_body("my_raft.yaml").files) == {"mesh", "modes"}
    study = read_config("raft.yaml", BodyFile)
    body = read_body(study.mesh, study.modes)
    assert body.labels == ("Heave", "Pitch", "Bending")
    assert body.volume == pytest.approx(20.0 * 8.0 * 2.0)
    assert detected_symmetry(body) == "xOz+yOz"
    assert linear_share(body) is None  # its bending is a beam's


def test_the_change_of_the_tutorial_is_a_study(tmp_path):
    from vsb.stages.init import init

    path = tmp_path / "my_buoy.yaml"
    init(str(path))
    (change,) = blocks("tutorial.md", "yaml")
    text = re.sub(r"^waves:.*$", change.strip(), path.read_text(), flags=re.M)
    path.write_text(text)
    assert load(path).waves[0].period == yaml.safe_load(change)["waves"][0]["period"]


def test_what_others_cite_is_this_version():
    citation, meta = (
        yaml.safe_load((HOME / "CITATION.cff").read_text()),
        json.loads((HOME / "codemeta.json").read_text()),
    )
    project = tomllib.loads((HOME / "pyproject.toml").read_text())["project"]
    assert citation["version"] == meta["version"] == project["version"] == vsb.__version__
    assert citation["license"] == project["license"] == meta["license"].rpartition("/")[2]
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert meta["description"] == project["description"]


def test_captions_of_the_workflow_report_are_there_and_used():
    rules = "".join(
        path.read_text() for path in (HOME / "workflow").rglob("*") if path.name == "Snakefile" or path.suffix == ".smk"
    )
    used = set(re.findall(r'"(?:\.\./)?report/(\w+\.rst)"', rules))
    assert used == {path.name for path in (HOME / "workflow" / "report").iterdir()}


EXAMPLES = sorted(path for path in (HOME / "vsb").rglob("*.py") if ">>> " in path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_in_docstrings_say_what_comes_out(path):
    module = importlib.import_module(".".join(path.relative_to(HOME).with_suffix("").parts))
    found = doctest.testmod(module)
    assert (found.failed, found.attempted > 0) == (0, True)


def test_the_container_is_made_from_the_lock_file_by_a_python_the_package_takes():
    recipe = (HOME / "Dockerfile").read_text()
    project = tomllib.loads((HOME / "pyproject.toml").read_text())["project"]
    assert project["requires-python"] == ">=3.11,<3.13"
    assert set(re.findall(r"^FROM python:(\S+?)-slim", recipe, re.M)) <= {"3.11", "3.12"}
    made = re.findall(r"pip install (.+)$", (HOME / "Makefile").read_text(), re.M)
    for what in ("-r requirements.lock", "--no-deps --no-build-isolation"):
        assert any(what in line for line in made)
        assert what in recipe


def test_the_year_of_ones_own_site_is_planned_as_it_is_told(tmp_path, monkeypatch):
    page = (HOME / "docs" / "own-buoy.md").read_text()
    (table,) = re.findall(r"```text\n(Hs/Te.+?)```", page, re.S)
    (campaign,) = re.findall(r"```yaml\n(campaign: my_site.+?)```", page, re.S)
    (tmp_path / "site.csv").write_text(table)
    (tmp_path / "my_site.yaml").write_text(campaign)
    monkeypatch.chdir(tmp_path)
    assert main(["init", "my_buoy.yaml"]) == 0
    plan = plan_of("my_site.yaml")
    climate = read_scatter(plan.loaded.climate_path)
    assert (plan.name, len(climate.hs), climate.te.max()) == ("my_site", 22, pytest.approx(9.0, rel=1e-3))
