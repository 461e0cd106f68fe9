"""Stage figures: all figures of a study."""

import json
from pathlib import Path

import pytest
from conftest import varied

from vsb.cli import main
from vsb.stages import report
from vsb.study.figure_names import FIGURE_KINDS, of_study


def test_every_figure_is_drawn_and_stamped(small):
    names = {f"{name}.{kind}" for name in of_study(small.study) for kind in FIGURE_KINDS}
    folder = Path(small.folder, "figures")
    assert {path.name for path in folder.iterdir()} == names
    stamps = json.loads(Path(small.manifest).read_text())
    for path in folder.iterdir():
        assert stamps[f"figures/{path.name}"]["spec_id"] == small.identity
        if path.suffix == ".svg":
            text = path.read_text()
            assert text.count("<path") > 5, path.name
            assert "nan" not in text.lower().replace("dominant", ""), path.name


def test_figures_are_drawn_for_print_and_a_file_of_the_user_stays(small, tmp_path, capsys):
    """Every figure as PDF and PNG; none at all if one would replace another file."""
    names, command = of_study(small.study), ["figures", f"{small.name}.yaml", "--out", str(tmp_path)]
    assert main([*command, "--pdf", "--png"]) == 0
    drawn = {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert set(drawn) == {f"{name}.{kind}" for name in names for kind in ("pdf", "png")}
    own = tmp_path / f"{names[-1]}.pdf"
    own.write_bytes(b"%PDF-1.4 my thesis")
    assert main([*command, "--pdf"]) == 2
    assert "no earlier output of vsb" in capsys.readouterr().err
    assert own.read_bytes() == b"%PDF-1.4 my thesis"
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir() if path != own} == {
        name: time for name, time in drawn.items() if name != own.name
    }


def test_spectra_of_irregular_seas_have_their_significant_height(seed):
    """The area of each is Hs^2/16; regular waves and still water have none."""
    waves = [{"kind": "jonswap", "hs": hs, "tp": tp} for hs, tp in ((1.0, 6.0), (3.0, 9.0))]
    others = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    study = varied(seed, waves=[others[0], *waves, others[1]])
    found = report._spectra(study, 20.0)
    assert list(found.sea.values) == [wave.description for wave in study.waves[1:3]]
    assert found.integrate("omega").values == pytest.approx([1 / 16, 9 / 16], rel=0.01)
    assert report._spectra(varied(seed, waves=others), 20.0).ndim == 0
