"""Every surprise of the fair comparison stands on its page."""

import pytest
from conftest import HERE, error_line

from examples import surprises

PAGE = (HERE.parent / "docs" / "surprises.md").read_text()


@pytest.mark.parametrize("name", surprises.CASES)
def test_every_case_is_on_the_page(name):
    assert f"<!-- published: surprises.{name} -->" in PAGE


def test_unknown_case_is_one_line(tmp_path, capsys):
    line = error_line([str(tmp_path / "out"), "drag", "nothing"], capsys, surprises.main)
    assert line.startswith("case: received nothing, needs some of one_damper, narrow_band")
