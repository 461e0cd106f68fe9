"""Stage figures: all figures of a study."""

import json

import matplotlib as mpl
import pytest
from conftest import varied

from vsb.stages import figures
from vsb.study.plan import figure_names
from vsb.study.results_plan import FIGURE_KINDS


def test_every_figure_is_drawn_and_matplotlib_settings_are_kept(small, tmp_path):
    looks = dict(mpl.rcParams)
    files = {**small.hydro_files, **small.response_files}
    out, manifest = str(tmp_path / "figures"), str(tmp_path / "manifest.json")
    figures.run(small.study, f"{small.folder}/trajectories", out, manifest, modes=f"{small.folder}/modes.nc", **files)
    assert dict(mpl.rcParams) == looks
    names = {f"{name}.{kind}" for name in figure_names(small.study) for kind in FIGURE_KINDS}
    assert {path.name for path in (tmp_path / "figures").iterdir()} == names
    assert {entry["spec_id"] for entry in json.loads((tmp_path / "manifest.json").read_text()).values()} == {
        small.study_id
    }
    for name in (name for name in names if name.endswith(".svg")):
        drawn = (tmp_path / "figures" / name).read_text()
        assert drawn.count("<path") > 5, name
        assert "nan" not in drawn.lower().replace("dominant", ""), name


def test_spectra_of_irregular_seas_have_their_significant_height(seed):
    """The area of each is Hs^2/16; regular waves and still water have none."""
    waves = [{"kind": "jonswap", "hs": hs, "tp": tp} for hs, tp in ((1.0, 6.0), (3.0, 9.0))]
    others = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    study = varied(seed, waves=[others[0], *waves, others[1]])
    found = figures._spectra(study, 20.0)
    assert list(found.sea.values) == [wave.description for wave in study.waves[1:3]]
    assert found.integrate("omega").values == pytest.approx([1 / 16, 9 / 16], rel=0.01)
    assert figures._spectra(varied(seed, waves=others), 20.0).ndim == 0
