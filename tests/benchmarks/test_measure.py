"""Tables of benchmarks, and what becomes of anything tried at random."""

import pytest

from benchmarks.measure import Outcome, as_csv, tabulated
from vsb.errors import VsbError


def test_an_empty_cell_is_what_does_not_exist():
    row = {"table": "integrators", "error": None, "seconds": 0.25, "status": "a, b"}
    assert (
        as_csv([row], ("table", "error", "seconds", "order", "status")).splitlines()[1] == 'integrators,,0.25,,"a, b"'
    )


@pytest.mark.parametrize(
    ("error", "lines", "verdict"),
    [
        (VsbError("one line"), 1, "told"),
        (VsbError("one\ntwo"), 1, "long message"),
        (VsbError("one\ntwo"), 2, "told"),
        (VsbError("x" * 1001), 1, "long message"),
        (ZeroDivisionError("no answer"), 1, "traceback"),
    ],
)
def test_a_user_is_told_in_a_line(error, lines, verdict):
    found = Outcome.of(error, "told", lines)
    assert found.verdict == verdict
    assert str(error) in found.reason


def test_what_is_bad_is_told_at_once_and_counted(tmp_path, capsys):
    fates = [((1, "a"), Outcome("told", "b\nc")), ((2, "d"), Outcome("lost", "e"))]
    assert tabulated(fates, ("index", "what"), ("lost", "silent"), str(tmp_path / "t.csv")) == {"lost": 1}
    assert (tmp_path / "t.csv").read_text() == "index,what,verdict,reason\n1,a,told,b c\n2,d,lost,e\n"
    assert capsys.readouterr().out == "2, d: lost: e\n1 told, 1 lost\n"
