"""Faults at random: what edits leave, which tests are asked, when one counts as caught."""

import ast
import random
import subprocess

import pytest

from benchmarks import faults
from benchmarks.__main__ import main
from benchmarks.faults import Fault, drawn, edited, edits, fate, near, parts
from benchmarks.measure import Outcome

AREA = '''def area(width: float, height: float, share: float = 0.5) -> float:
    """Area of a share of a rectangle."""
    if share > 1.0:
        raise ValueError("more than all")
    return share * width * height


def spare(width: float) -> float:
    return width + 3.0
'''
LOOP = """

@njit
def loop(x: float) -> float:
    return x * 2.0
"""
TEST = """from vsb.flat import area


def test_half():
    assert area.area(2.0, 3.0) == 3.0
"""
FAR = """from vsb.flat.area import area


def test_all():
    assert area(2.0, 3.0, 1.0) == 6.0
"""


@pytest.fixture
def project(tmp_path):
    """A project of one module, its own tests and a user's."""
    texts = {
        "vsb/flat/area.py": AREA, "tests/flat/test_area.py": TEST, "tests/test_far.py": FAR,
        "tests/test_other.py": "import vsb.flat.areas\n",
    }  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def left(text):
    """What edits leave of an expression or a statement."""
    node = ast.parse(text).body[0]
    return [
        ast.unparse(new) for new in edits(node.value if isinstance(node, ast.Expr) and "pass" not in text else node)
    ]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("a + b", ["a", "b"]),
        ("a * b", ["a", "b"]),
        ("a - b", ["a"]),
        ("a / b", ["a"]),
        ("a ** b", []),
        ("a and b", ["b", "a"]),
        ("a or b or c", ["b or c", "a or c", "a or b"]),
        ("a if c else b", ["a", "b"]),
        ("a < b", ["a > b"]),
        ("a < b < c", []),
        ("a is b", []),
        ("f(a, b=1, **c)", ["f(a, **c)"]),
        ("max(a, b)", ["min(a, b)"]),
        ("np.any(a)", ["np.all(a)"]),
        ("abs(a)", ["a"]),
        ("sorted(a, key=f)", ["sorted(a)", "a"]),
        ("0.5", ["1.0"]),
        ("0.0", []),
        ("2", []),
        ("'text'", []),
        ("x += 1", ["pass"]),
        ("if a:\n    pass", ["if False:\n    pass"]),
    ],
)
def test_an_edit_leaves_something_out_or_takes_the_opposite(text, found):
    assert left(text) == found


def test_a_call_may_be_dropped_and_a_filter_but_no_docstring():
    assert [ast.unparse(new) for new in edits(ast.parse("check(x)").body[0])] == ["pass"]
    assert list(edits(ast.parse("'''What it does.'''").body[0])) == []
    comprehension = ast.parse("[x for x in y if x > 1 if x < 3]").body[0].value.generators[0]
    assert [ast.unparse(new).strip() for new in edits(comprehension)] == ["for x in y if x < 3", "for x in y if x > 1"]


def test_what_is_said_of_types_and_what_decorates_is_no_part():
    function = ast.parse("@f(1.5)\ndef g(x: 'a' = 2.5) -> 3.5:\n    y: 4.5 = 5.5\n    return y").body[0]
    assert [part.value for part in parts(function) if isinstance(part, ast.Constant)] == [2.5, 5.5]


def test_a_fault_is_one_edit_of_one_function_and_compiled_loops_have_none():
    found = {edited("vsb/area.py", AREA + LOOP, random.Random(i)) for i in range(200)}
    assert {fault.function for fault in found} == {"area", "spare"}
    assert {fault.edit for fault in found} >= {
        "share * width -> width",
        "width + 3.0 -> width",
        "3.0 -> 6.0",
        "share > 1.0 -> share < 1.0",
    }
    sound = ast.unparse(ast.parse(AREA + LOOP)).splitlines()
    for fault in found:
        compile(fault.text, fault.path, "exec")
        own = fault.text.splitlines()
        assert len(own) == len(sound)
        assert sum(a != b for a, b in zip(own, sound, strict=True)) == 1
    assert next(fault.line for fault in found if fault.edit == "3.0 -> 6.0") == 9
    assert edited("vsb/area.py", "X = 1.0\n", random.Random(0)) is None
    assert edited("vsb/area.py", "def f(x):\n    return x\n", random.Random(0)) is None


def test_faults_are_the_same_for_a_seed(project):
    assert list(drawn(5, project)) == list(drawn(5, project))
    assert list(drawn(5, project)) != list(drawn(5, project, seed=1))
    assert {fault.path for fault in drawn(5, project)} == {"vsb/flat/area.py"}


def test_tests_of_a_module_are_its_own_and_those_of_files_that_import_it(project):
    assert near("vsb/flat/area.py", project) == [["tests/flat/test_area.py"], ["tests/test_far.py"]]
    (project / "tests/flat/test_area.py").unlink()
    assert near("vsb/flat/area.py", project) == [["tests/test_far.py"]]


def fault(project, old, new):
    text = (project / "vsb/flat/area.py").read_text()
    assert text.count(old) == 1
    return Fault("vsb/flat/area.py", "area", 6, f"{old} -> {new}", text.replace(old, new))


def test_a_fault_is_caught_by_the_first_test_that_fails_with_it_alone(project):
    sound = (project / "vsb/flat/area.py").read_text()
    own = fate(fault(project, "share * width", "width"), project)
    assert own == Outcome("caught", "share * width -> width: tests/flat/test_area.py::test_half")
    assert fate(fault(project, "share > 1.0", "share == 1.0"), project).reason.endswith(": tests/test_far.py::test_all")
    assert (project / "vsb/flat/area.py").read_text() == sound


def test_what_fails_without_the_fault_catches_nothing(project):
    (project / "tests/test_far.py").unlink()
    (project / "tests/flat/test_area.py").write_text("import vsb.flat.area\n\n\ndef test_red():\n    assert False\n")
    assert fate(fault(project, "share * width", "width"), project).verdict == "survived"


def test_tests_that_take_too_long_decide_nothing(project, monkeypatch):
    def slow(tests, root):
        raise subprocess.TimeoutExpired("pytest", 600.0)

    monkeypatch.setattr(faults, "failed", slow)
    found = fate(fault(project, "share * width", "width"), project)
    assert found == Outcome("undecided", "share * width -> width: tests/flat/test_area.py take longer than 600 s")


def test_nor_do_those_that_take_too_long_without_the_fault(project, monkeypatch):
    sound = (project / "vsb/flat/area.py").read_text()

    def slow(tests, root):
        if (root / "vsb/flat/area.py").read_text() == sound:
            raise subprocess.TimeoutExpired("pytest", 600.0)
        return list(tests)

    monkeypatch.setattr(faults, "failed", slow)
    assert fate(fault(project, "share * width", "width"), project).verdict == "undecided"


@pytest.mark.parametrize(("missed", "code"), [(1, 0), (2, 1)])
def test_one_in_twenty_may_survive(project, monkeypatch, capsys, missed, code):
    verdicts = iter([*["survived"] * missed, *["caught"] * 20])
    monkeypatch.setattr(faults, "HERE", project)
    monkeypatch.setattr(faults, "fate", lambda fault, root: Outcome(next(verdicts), fault.edit))
    assert main(["faults", "20", str(project / "table.csv")]) == code
    assert len((project / "table.csv").read_text().splitlines()) == 21
    assert f"{20 - missed} caught, {missed} survived" in capsys.readouterr().out


def test_faults_are_put_into_a_copy_without_results(project, monkeypatch):
    """Of which a room of the package has the name."""
    for name in ("vsb/results/one.py", "results/one.nc", "pyproject.toml"):
        (project / name).parent.mkdir(exist_ok=True)
        (project / name).write_text("")
    before, copies = sorted(project.rglob("*")), []

    def look(fault, root):
        copies.append(root)
        assert (root / fault.path).is_file()
        assert (root / "vsb/results/one.py").is_file()
        assert (root / "pyproject.toml").is_file()
        assert not (root / "results").exists()
        return Outcome("caught", "")

    monkeypatch.setattr(faults, "fate", look)
    (found,) = faults.fates(1, project, 0)
    assert found[1].verdict == "caught"
    assert sorted(project.rglob("*")) == before
    assert project not in copies
    assert not copies[0].exists()
