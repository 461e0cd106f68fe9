import pytest

from vsb.report.canvas import STYLES, style


def test_the_papers_designs_keep_their_colours_whatever_the_study():
    assert style("VSWEC", ["VSWEC"]) == style("VSWEC", ["FSB", "other", "VSWEC"])
    assert len({colour for colour, _ in STYLES.values()}) == 4


@pytest.mark.parametrize("count", [2, 4])
def test_other_designs_differ_from_each_other_and_from_the_papers(count):
    names = ["FSB", *(f"D{i}" for i in range(count))]
    colours = [style(name, names)["color"] for name in names]
    assert len(set(colours)) == len(names)
    assert style("D1", names) == style("D1", names)
