"""The page on published claims gives what the script finds, and its studies are files that can be run."""

import re

import numpy as np
import pytest
import yaml
from conftest import HERE
from scipy.linalg import eigh

import vsb
from examples import claims, surprises
from vsb.hydro.bodies.files import read_body
from vsb.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.study.study import load, parse

DOCS = HERE.parent / "docs"
PAGE = (DOCS / "claims.md").read_text()


def on_the_page(name):
    """The figures of a claim as the page has them."""
    (table,) = re.findall(rf"\| `{name}` \| \|\n\|---\|---\|\n((?:\|.*\|\n)+)", PAGE)
    return {key: float(value) for key, value in re.findall(r"\| (.*) \| (.*) \|", table)}


@pytest.mark.parametrize("name", claims.CASES)
def test_every_case_is_on_the_page(name):
    assert surprises.table(name, on_the_page(name)) in PAGE
    assert f"](claims/{name}.svg)" in PAGE
    assert (DOCS / "claims" / f"{name}.svg").read_text().startswith("<svg")


def test_study_as_a_file_is_the_study(monkeypatch):
    monkeypatch.chdir(HERE.parent)
    for study in (claims.papers_shell(), surprises.study_of([surprises.regular(3.0)])):
        assert parse(yaml.safe_load(yaml.safe_dump(claims.raw_of(study)))) == study


def test_study_of_a_body_moves_with_the_files_it_names(tmp_path, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    text = yaml.safe_dump(claims.with_files_beside(claims.barge(), tmp_path / "here"))
    (tmp_path / "here" / "barge.yaml").write_text(text)
    (tmp_path / "here").rename(tmp_path / "there")
    moved = vsb.load_body(tmp_path / "there" / "barge.yaml")
    assert moved.study == vsb.load_body("config/barge.yaml").study


def test_tube_of_the_claims_rings_like_a_pipe(tmp_path):
    """In vacuum, its stern open: c/4L, 3c/4L; still water outside neither stiffens nor softens its bulges."""
    claims.write_tube(tmp_path / "tube.nc", 1000.0, 3.0)
    body = read_body(tmp_path / "tube.nc", tmp_path / "tube.nc")
    square = eigh(body.stiffness, body.mass, eigvals_only=True)
    pipe = np.pi * 3.0 / (2 * claims.TUBE_LENGTH) * np.array([1.0, 3.0])
    assert np.sqrt(square[:2]) == pytest.approx(pipe, rel=5e-2)  # the modes' slope vanishes at the stern
    assert np.abs(hydrostatic_stiffness(body, 1000.0, 9.81)).max() < 5e-3 * body.stiffness[0, 0]


@pytest.mark.slow
def test_each_azimuthal_order_adds_twice_the_limit_of_heave(tmp_path, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    found = claims.recorded("more_orders", tmp_path)
    assert list(found.values()) == pytest.approx([1, 3, 5, 7], rel=1e-4)
    assert on_the_page("more_orders") == pytest.approx(found, rel=2e-3)
    assert "largest power" in (tmp_path / "more_orders.svg").read_text()
    assert load(tmp_path / "more_orders" / "papers_shell.yaml").motion == "planar"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["flexible_barge", "start_of_a_run"])
def test_page_gives_what_the_script_finds(name, tmp_path, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    assert on_the_page(name) == pytest.approx(claims.CASES[name](tmp_path).figures, rel=2e-3, abs=1e-3)
