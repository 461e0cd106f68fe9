"""Stage figures: all figures of a study."""

import json
from pathlib import Path

import pytest
from conftest import varied

from vsb.cli import main
from vsb.stages import report
from vsb.study.figure_names import FIGURE_KINDS, of_buoy


def test_every_figure_is_drawn_and_stamped(small):
    names = {f"{name}.{kind}" for name in of_buoy(small.study) for kind in FIGURE_KINDS}
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
    """Every figure as PDF and PNG, again in place of them, but not of another file of that name."""
    command = ["figures", f"{small.name}.yaml", "--pdf", "--png", "--out", str(tmp_path)]
    for _ in range(2):
        assert main(command) == 0
    named = {f"{name}.{kind}" for name in of_buoy(small.study) for kind in ("pdf", "png")}
    assert {path.name for path in tmp_path.iterdir()} == named
    own = tmp_path / f"{of_buoy(small.study)[0]}.pdf"
    own.write_bytes(b"%PDF-1.4 my thesis")
    assert main(command) == 2
    assert "no earlier output of vsb" in capsys.readouterr().err
    assert own.read_bytes() == b"%PDF-1.4 my thesis"


def test_spectra_of_irregular_seas_have_their_significant_height(seed):
    """The area of each is Hs^2/16; regular waves and still water have none."""
    waves = [{"kind": "jonswap", "hs": hs, "tp": tp} for hs, tp in ((1.0, 6.0), (3.0, 9.0))]
    others = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    study = varied(seed, waves=[others[0], *waves, others[1]])
    found = report._spectra(study, 20.0)
    assert list(found.sea.values) == [wave.description for wave in study.waves[1:3]]
    assert found.integrate("omega").values == pytest.approx([1 / 16, 9 / 16], rel=0.01)
    assert report._spectra(varied(seed, waves=others), 20.0).ndim == 0
