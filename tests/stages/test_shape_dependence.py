"""Command shape-dependence: counted on a terminal alone, finished results kept."""

import dataclasses
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


@pytest.mark.parametrize("stored", ["none", "another's"])
def test_shapes_solved_wait_beside_the_result_until_it_is_there(seed, tmp_path, monkeypatch, stored):
    """Counted after each; the figure and the line are of the result, which has the id of its study and version."""
    path, shapes, asked = tmp_path / "a.b.nc", tmp_path / "a.b.shapes", []
    if stored != "none":
        save(xr.Dataset(attrs={"spec_id": "0" * 16}), path)

    @dataclasses.dataclass(frozen=True)
    class Family:
        store: object = None
        after_each: object = None

    def dataset(study, family):
        shapes.mkdir()
        (shapes / "one.nc").write_text("a shape")
        asked.append(("solved", study, family))
        return xr.Dataset(attrs={"number": 3.0})

    monkeypatch.setattr(stage, "reference_shell", lambda study: ("shell", study))
    monkeypatch.setattr(stage, "study_family", lambda *given: asked.append(given) or Family())
    monkeypatch.setattr(stage, "shapes_of_study", lambda study, family: asked.append((study, family.store)) or 7)
    monkeypatch.setattr(stage, "counter", lambda total: f"counter to {total}")
    monkeypatch.setattr(stage, "shape_dataset", dataset)
    monkeypatch.setattr(stage, "shape_figure", lambda ds: f"figure of {ds.attrs['number']}")
    monkeypatch.setattr(stage, "svg_text", lambda figure: f"text of {figure}")
    monkeypatch.setattr(stage, "answer", lambda ds, name: f"{name}: {ds.attrs['number']}")
    assert stage.shape_dependence(seed, str(path), str(tmp_path / "a.svg")) == "seed: 3.0"
    assert asked == [
        (seed, ("shell", seed)), (seed, shapes), ("solved", seed, Family(shapes, "counter to 7")),
    ]  # fmt: skip
    assert (tmp_path / "a.svg").read_text() == "text of figure of 3.0"
    found = stage._finished(str(path), content_id([seed, __version__]))
    assert found.attrs["number"] == 3.0
    assert not shapes.exists()
