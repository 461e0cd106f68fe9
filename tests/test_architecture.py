"""The rules of the house, read from the code itself."""

import ast
import statistics
from pathlib import Path

import pytest

HOME = Path(__file__).parent.parent
ORDER = (
    "errors", "config", "specs", "units", "shell", "modes", "surface", "meshing", "waves", "kernel", "database", "quality",
    "bem", "radiation", "pto", "response", "plant", "integrate", "trajectory", "power", "compare", "figures", "report",
    "commands", "publish", "preview", "cli",
)  # fmt: skip
MODULES = {path.stem: path for path in (HOME / "vsb").glob("*.py") if path.stem != "__init__"}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}
HEAVY = {"numpy", "scipy", "xarray", "capytaine", "matplotlib", "netCDF4"}


def imported(tree):
    """Top-level packages and vsb modules a tree imports, anywhere."""
    packages, own = set(), set()
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module] if node.module != "vsb" else [f"vsb.{alias.name}" for alias in node.names]
        for name in names:
            top, _, rest = name.partition(".")
            packages.add(top)
            if top == "vsb" and rest and not rest.startswith("_"):
                own.add(rest)
    return packages, own


def functions(tree):
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def body_lines(function):
    """Lines of a function without its signature and docstring."""
    body = function.body[1:] if ast.get_docstring(function) else function.body
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0


def test_every_module_has_its_place():
    assert set(MODULES) == set(ORDER)


@pytest.mark.parametrize("name", ORDER)
def test_a_module_imports_only_from_modules_above_it(name):
    below = imported(TREES[name])[1] - set(ORDER[: ORDER.index(name)])
    assert not below, f"{name} imports {sorted(below)}, which stand below it"


@pytest.mark.parametrize("name", ORDER)
def test_only_bem_imports_capytaine(name):
    assert ("capytaine" in imported(TREES[name])[0]) == (name == "bem")


@pytest.mark.parametrize("name", ["errors", "config", "specs"])
def test_what_the_workflow_reads_at_every_parse_is_light(name):
    assert not imported(TREES[name])[0] & HEAVY


@pytest.mark.parametrize("name", ORDER)
def test_modules_are_short(name):
    assert len(MODULES[name].read_text(encoding="utf-8").splitlines()) <= 400


def test_functions_are_short():
    lengths = sorted(body_lines(f) for tree in TREES.values() for f in functions(tree))
    assert statistics.median(lengths) <= 8
    assert lengths[int(0.9 * len(lengths))] <= 40


@pytest.mark.parametrize("name", ORDER)
def test_everything_public_is_documented(name):
    nodes = [n for n in ast.walk(TREES[name]) if isinstance(n, ast.FunctionDef | ast.ClassDef)]
    nested = {id(child) for n in nodes if isinstance(n, ast.FunctionDef) for child in ast.walk(n) if child is not n}
    bare = [n.name for n in nodes if id(n) not in nested and not n.name.startswith("_") and not ast.get_docstring(n)]
    assert not bare


def test_every_rule_is_a_command_with_a_log():
    for path in (HOME / "workflow" / "rules").glob("*.smk"):
        text = path.read_text(encoding="utf-8")
        assert text.count("\nrule ") == text.count('"vsb ') == text.count("log:"), path.name
    assert len((HOME / "Snakefile").read_text(encoding="utf-8").splitlines()) <= 40
