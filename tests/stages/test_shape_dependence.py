"""Command shape-dependence: counted on a terminal alone, finished results kept."""

import io
import sys

import pytest
import xarray as xr

from vsb import __version__
from vsb.stages import shape_dependence as stage
from vsb.study.study import content_id
from vsb.tools.files import save


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(("stream", "said"), [(Terminal(), "\rshape 1 of 2\rshape 2 of 2\n"), (io.StringIO(), "")])
def test_shapes_are_counted_on_a_terminal_and_nowhere_else(monkeypatch, stream, said):
    monkeypatch.setattr(sys, "stderr", stream)
    show = stage.counter(2)
    show()
    show()
    assert stream.getvalue() == said


def test_a_finished_result_of_the_same_study_is_not_computed_again(seed, tmp_path, monkeypatch):
    """Of another study, or damaged, it is."""
    path, asked = tmp_path / "a.nc", []
    identity = content_id([seed, __version__])
    assert stage._finished(str(path), identity) is None
    save(xr.Dataset(attrs={"spec_id": identity}), path)
    assert stage._finished(str(path), identity).attrs["spec_id"] == identity
    assert stage._finished(str(path), "0" * 16) is None
    monkeypatch.setattr(stage, "shape_dataset", lambda *_: asked.append("computed"))
    monkeypatch.setattr(stage, "shape_figure", lambda ds: None)
    monkeypatch.setattr(stage, "svg_text", lambda figure: "")
    monkeypatch.setattr(stage, "answer", lambda ds, name: f"{name}: the answer")
    assert stage.shape_dependence(seed, str(path), str(tmp_path / "a.svg")) == "seed: the answer"
    assert asked == []
    path.write_bytes(b"none")
    assert stage._finished(str(path), identity) is None
