"""Rule report: the page says what its checked data say."""

import json
from pathlib import Path

import pytest
from conftest import SEED, varied

from vsb.errors import DatabaseError
from vsb.stages import report
from vsb.study.study import load


def made(plan, out, **changes):
    files = {
        "tables": f"{plan.folder}/tables.json",
        "trajectories": f"{plan.folder}/trajectories",
        "figures": f"{plan.folder}/figures",
        **plan.hydro_files,
        **plan.response_files,
        **changes,
    }
    report.run(plan.study, out=str(out), manifest=changes.pop("manifest", plan.manifest), **files)


def test_the_page_says_its_powers_its_solver_and_its_figures(small):
    page = Path(f"{small.folder}/report.html").read_text()
    tables = json.loads(Path(f"{small.folder}/tables.json").read_text())
    for row in tables["comparison"]:
        assert row["design"] in page
        assert f"{row['power_mean']:.4g}" in page
    assert "spectral integral equation" in page
    assert "none (hydro.witness: none)" in page
    assert page.count("<svg") == len(list(Path(f"{small.folder}/figures").glob("*.svg")))


def test_tables_that_are_in_no_manifest_are_refused(small, tmp_path):
    (tmp_path / "tables.json").write_text("{}")
    with pytest.raises(DatabaseError, match=r"tables.json: "):
        made(small, tmp_path / "report.html", tables=str(tmp_path / "tables.json"))
    assert not (tmp_path / "report.html").exists()


def test_seas_are_told_in_words(seed):
    assert report._seas(seed) == {"regular_A0.179_T2.5": "regular waves of 0.179 m amplitude and 2.5 s period"}
    many = varied(seed, waves=[{"kind": "jonswap", "hs": 1, "tp": 4, "realisations": 2}])
    assert list(report._seas(many)) == [*(f"jonswap_Hs1_Tp4_g3.3_s{s}" for s in (1, 2)), "jonswap_Hs1_Tp4_g3.3"]
    paper = load(SEED.with_name("paper.yaml"))
    words = set(report._seas(paper).values())
    assert any(word.startswith("an assumed uniform pressure of ") for word in words)
