"""The documentation: pages written from the code, links that lead somewhere, examples that run."""

import doctest
import importlib
import importlib.util
import json
import re
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
import yaml
from meshio import Mesh

import vsb
from vsb.cli import main, parser
from vsb.engine.hydro.bodies.body import detected_symmetry
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import read_body
from vsb.engine.hydro.bodies.hydrostatics import linear_share
from vsb.engine.hydro.bodies.solution import read_config
from vsb.engine.hydro.panels.mesh import revolved
from vsb.engine.waves.scatter import read_scatter
from vsb.keys.schema import dotted, schema_of
from vsb.pipeline import plans as planning
from vsb.pipeline.plans import plan_of
from vsb.stages.body_preview import check
from vsb.study.body import BodyStudy, load_body
from vsb.study.study import BuoyStudy, load
from vsb.tools.commands import commands, long_options

HOME = Path(__file__).parent.parent
PAGES = sorted([*HOME.glob("*.md"), *(HOME / "docs").glob("*.md"), *(HOME / "docs" / "decisions").glob("*.md")])
GENERATED = {f"reference/{name}.md" for name in ("keys", "commands", "python")}


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("generate", HOME / "docs" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_key_stands_in_the_reference(generate):
    page = generate.keys_page()
    for model in (BuoyStudy, BodyStudy, BodyFile):
        for name in dotted(schema_of(model)):
            assert f"\n| `{name.rpartition('.')[2]}` |" in page
    assert (
        page.count(
            "| `young_modulus` | Young's modulus of the shell; required without a material | Pa | none | from 1 to 1e+16 |"
        )
        == 1
    )
    assert "| `depth` | depth of the sea; .inf is deep water | m | `.inf` | above 0 |" in page


def test_files_named_on_a_page_exist():
    for page in PAGES:
        if page.parent.name == "decisions" or page.name == "CHANGELOG.md":
            continue
        for name in set(re.findall(r"`([a-z_/]+\.(?:py|smk))`", page.read_text(encoding="utf-8"))):
            folders = (HOME, HOME / "vsb", HOME / "docs", HOME / "examples")
            assert any((folder / name).is_file() for folder in folders), f"{page}: {name}"


def test_every_command_and_option_stands_in_the_reference(generate):
    page = generate.commands_page()
    for name, one in commands(parser()).items():
        assert f"## `vsb {name}`" in page
        assert all(option in page for option in long_options(one))


def test_every_public_name_stands_in_the_reference(generate):
    page = generate.python_page()
    assert {name for name in vsb.__all__ if f"## `{name}`" not in page} == set()


def anchors(path):
    """Anchors of a page's headings, as GitHub and MyST make them."""
    heads = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_links_resolve():
    links = [
        (page, link) for page in PAGES for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    ]
    for page, link in links:
        target, _, anchor = link.partition("#")
        if target.startswith(("http", "mailto:")) or target in GENERATED:
            continue
        place = (page.parent / target).resolve() if target else page
        assert place.exists(), f"{page}: {link}"
        assert not anchor or anchor in anchors(place), f"{page}: {link}"


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", (HOME / "docs" / page).read_text(encoding="utf-8"), re.S | re.M)


def test_rubber_of_the_documentation(tmp_path, capsys):
    (study,), (program,) = blocks("materials.md", "yaml"), blocks("materials.md", "python")
    (tmp_path / "rubber.yaml").write_text(study)
    assert load(tmp_path / "rubber.yaml").device.young_modulus == 3e6
    exec(program, {})
    printed = [line.split()[-2] for line in capsys.readouterr().out.splitlines()]
    assert f"prints {printed[0]}, {printed[1]} and {printed[2]} Pa for" in (HOME / "docs" / "materials.md").read_text()


def test_body_of_the_documentation(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (program,), (_, _, _, _, file, made, *_) = blocks("own-body.md", "python"), blocks("own-body.md", "yaml")
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


def test_rigid_body_of_the_documentation(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file, made, whole, *_ = blocks("own-body.md", "yaml")
    Path("float.yaml").write_text(file)
    Path("study.yaml").write_text(made)
    Path("capsule.yaml").write_text(whole)
    vertices, faces = revolved(np.array([0.0, 5.0, 5.0, 0.0]), np.array([1.0, 1.0, -3.0, -3.0]), 12)
    triangles = np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])
    with np.errstate(invalid="ignore"):  # normals of those without area
        Mesh(vertices, [("triangle", triangles)]).write("cylinder.stl")
    body = check(planning.plan_of("study.yaml"))[0]
    assert body.labels == ("Surge", "Heave", "Pitch")
    assert body.mass[1, 1] == pytest.approx(1025.0 * 6 * 25 * np.sin(np.pi / 6) * 3.0, rel=1e-6)
    capsule = check(planning.plan_of("capsule.yaml"))[0]
    assert capsule.mass.item() == pytest.approx(1025.0 * np.pi * 4 * (4.0 + 4 / 3), rel=0.03)


def test_study_of_the_tutorial(tmp_path):
    from vsb.stages.init import init

    path = tmp_path / "my_buoy.yaml"
    init(str(path))
    (change,) = blocks("tutorial.md", "yaml")
    text = re.sub(r"^waves:.*$", change.strip(), path.read_text(), flags=re.M)
    path.write_text(text)
    assert load(path).waves[0].period == yaml.safe_load(change)["waves"][0]["period"]


def readme(language):
    return re.findall(rf"^```{language}\n(.*?)^```", (HOME / "README.md").read_text(encoding="utf-8"), re.S | re.M)


def test_study_and_program_of_the_readme(finished, tmp_path, monkeypatch):
    """Its study is valid; its program runs, on results that are there already."""
    (study,), (program,) = readme("yaml"), readme("python")
    Path(tmp_path / "my.yaml").write_text(study)
    assert list(load(tmp_path / "my.yaml").designs) == ["rigid", "free", "held"]
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    exec(program.replace("my.yaml", "small.yaml"), variables := {})
    assert variables["port"].power([2e3, 8e3, 32e3]).shape == (3, 3)


def test_examples_of_the_public_names(finished, tmp_path, monkeypatch, capsys):
    (program,) = blocks("api.md", "python")
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    exec(program.replace("my.yaml", "small.yaml"), {})
    assert "none.yaml: cannot be read" in capsys.readouterr().out


def test_citation_has_the_version_of_the_package():
    citation, meta = (
        yaml.safe_load((HOME / "CITATION.cff").read_text()),
        json.loads((HOME / "codemeta.json").read_text()),
    )
    project = tomllib.loads((HOME / "pyproject.toml").read_text())["project"]
    assert citation["version"] == meta["version"] == project["version"] == vsb.__version__
    assert citation["license"] == project["license"] == meta["license"].rpartition("/")[2]
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert meta["description"] == project["description"]


def test_doctests():
    for path in sorted(path for path in (HOME / "vsb").rglob("*.py") if ">>> " in path.read_text(encoding="utf-8")):
        module = importlib.import_module(".".join(path.relative_to(HOME).with_suffix("").parts))
        found = doctest.testmod(module)
        assert (found.failed, found.attempted > 0) == (0, True), path


def test_campaign_of_the_documentation(tmp_path, monkeypatch):
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
