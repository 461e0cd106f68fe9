"""Every published claim stands on its page, and its studies are files that can be run."""

import numpy as np
import pytest
import yaml
from conftest import HERE
from scipy.linalg import eigh

import vsb
from examples import claims, surprises
from vsb.engine.hydro.bodies.build import read_body
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.study.study import load, parse

DOCS = HERE.parent / "docs"
PAGE = (DOCS / "claims.md").read_text()


@pytest.mark.parametrize("name", claims.CASES)
def test_every_case_is_on_the_page_with_its_figure(name):
    assert f"<!-- published: claims.{name} -->" in PAGE
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
    assert list(found.figures.values()) == pytest.approx([1, 3, 5, 7], rel=1e-4)
    assert "membrane modes to degree 6" in (tmp_path / "more_orders.md").read_text()
    assert "largest power" in (tmp_path / "more_orders.svg").read_text()
    assert load(tmp_path / "more_orders" / "papers_shell.yaml").motion == "planar"
