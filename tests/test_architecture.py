"""The rules of the house, read from the code itself."""

import ast
import re
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).parent.parent
ORDER = (
    "errors", "compiled", "sections", "reading", "config", "resolution", "specs", "units", "shell", "modes", "azimuthal", "surface", "prestress", "reference", "wetforce", "multibody",
    "wetbody", "meshing", "superposition", "waves", "ringsource", "meridian", "wavepart", "finitedepth", "spectral", "rational", "sweep", "spectralsweep", "waveforce", "kernel", "database", "generalized", "wamit", "bemio", "quality", "interchange", "bodies", "coarsening", "bem", "panelsweep", "bodysolver", "bodysweep", "bodystudy", "radiation", "pto", "response", "shapefamily", "shapedatabase", "plant",
    "integrate", "constraint", "phifunctions", "adams", "exponential", "gauss", "periodic", "regularwave", "harmonic", "audit", "trajectory", "automatic", "scenes", "power", "seastatistics", "compare", "ledger", "canvas", "barge", "shapedependence", "riemann", "workprecision", "hydroprecision", "shapes", "figures", "report",
    "commands", "hardcases", "generalsolvers", "timecases", "timeprecision", "publish", "preview", "cli",
)  # fmt: skip
MODULES = {path.stem: path for path in (HOME / "vsb").glob("*.py") if path.stem != "__init__"}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}
HEAVY = {"numpy", "scipy", "xarray", "capytaine", "matplotlib", "netCDF4"}


WORKFLOW = {p.name: p for p in (HOME / "Snakefile", *sorted((HOME / "workflow").rglob("*.smk")))}
PARSED = ("__init__", "errors", "config", "specs")  # read at every parse of the workflow
STATEMENT = re.compile(r"^[ \t]*((?:import|from)[ \t]+(?:[^(\n\\]|\\\n|\([^)]*\))*)", re.MULTILINE)
BY_NAME = re.compile(r"(?:__import__|import_module)\([^\"']*[\"'](\w[\w.]*)")


def named(node):
    """Modules an import statement, or a call of `__import__` or `import_module`, names in full."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        base = ".".join(part for part in ("vsb" if node.level else "", node.module) if part)
        return [f"vsb.{alias.name}" for alias in node.names] if base == "vsb" else [base]
    return BY_NAME.findall(ast.unparse(node)) if isinstance(node, ast.Call) else []


def imported(tree):
    """Top-level packages and vsb modules a tree imports, anywhere."""
    packages, own = set(), set()
    for name in (name for node in ast.walk(tree) for name in named(node)):
        top, _, rest = name.partition(".")
        packages.add(top)
        if top == "vsb" and rest and rest[0] not in "_*":
            own.add(rest.partition(".")[0])
    return packages, own


def workflow_tree(text):
    """The imports of a Snakefile as a tree: its other statements are not all Python."""
    lines = [match.strip() for match in STATEMENT.findall(text)]
    return ast.parse("\n".join([*lines, *(f"import {name}" for name in BY_NAME.findall(text))]))


def heavy(tree, trees):
    """Heavy packages a tree imports, itself or through the vsb modules it imports."""
    packages, pending, seen = set(imported(tree)[0]), list(imported(tree)[1]), set()
    while pending:
        name = pending.pop()
        if name in trees and name not in seen:
            seen.add(name)
            more, own = imported(trees[name])
            packages |= more
            pending += own
    return packages & HEAVY


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


@pytest.mark.parametrize("name", PARSED)
def test_what_the_workflow_reads_at_every_parse_is_light(name):
    assert not heavy(ast.parse((HOME / "vsb" / f"{name}.py").read_text(encoding="utf-8")), TREES)


@pytest.mark.parametrize("name", WORKFLOW)
def test_the_workflow_itself_is_light(name):
    assert not heavy(workflow_tree(WORKFLOW[name].read_text(encoding="utf-8")), TREES)


def test_parsing_the_workflow_loads_nothing_heavy():
    """The same, asked of the interpreter: third parties are in it too."""
    code = f"import sys, vsb, vsb.config, vsb.specs; print(*({HEAVY!r} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], cwd=HOME, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_package_imports_none_of_its_modules():
    """`import vsb` must not decide the order of imports."""
    assert imported(ast.parse((HOME / "vsb" / "__init__.py").read_text(encoding="utf-8")))[1] == set()


@pytest.mark.parametrize(
    ("code", "packages", "own"),
    [
        ("import numpy as np, scipy.linalg", {"numpy", "scipy"}, set()),
        ("def f():\n    from scipy.linalg import expm", {"scipy"}, set()),
        ("from vsb.modes import Mode", {"vsb"}, {"modes"}),
        ("from vsb import modes, __version__", {"vsb"}, {"modes"}),
        ("import vsb.modes as m", {"vsb"}, {"modes"}),
        ("from . import modes", {"vsb"}, {"modes"}),
        ("from .modes import Mode", {"vsb"}, {"modes"}),
        ("if x:\n    from .modes import *", {"vsb"}, {"modes"}),
        ("importlib.import_module('vsb.modes')", {"vsb"}, {"modes"}),
        ("x = __import__('capytaine')", {"capytaine"}, set()),
        ("x = 'import numpy'  # from scipy import linalg", set(), set()),
    ],
)
def test_the_checker_sees_every_form_of_import(code, packages, own):
    assert imported(ast.parse(code)) == (packages, own)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("import numpy\nrule all:\n    input: 1\n", {"numpy"}),
        ("rule all:\n    run:\n        import xarray as xr\n", {"xarray"}),
        ("from scipy.linalg import (\n    expm,\n    svd,\n)\nrule all:\n", {"scipy"}),
        ("import os, \\\n    matplotlib\n", {"matplotlib"}),
        ("X = __import__('capytaine').solver\nrule all:\n", {"capytaine"}),
        ("import vsb.modes\n", {"numpy", "scipy"}),
        ("from vsb import modes  # through it, numpy\n", {"numpy", "scipy"}),
        ("import os\nimport vsb.config\n# import numpy\nimportant = 1\nrule a:\n    shell: 'import x'\n", set()),
    ],
)
def test_the_checker_sees_what_a_workflow_imports(text, found):
    light = {"config": ast.parse("import os"), "modes": ast.parse("import numpy\nfrom .shell import Shell")}
    assert heavy(workflow_tree(text), {**light, "shell": ast.parse("from scipy import linalg")}) == found


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
    for path in (path for name, path in WORKFLOW.items() if name != "Snakefile"):
        text = path.read_text(encoding="utf-8")
        assert text.count("\nrule ") == text.count('"vsb ') == text.count("log:"), path.name
    assert len((HOME / "Snakefile").read_text(encoding="utf-8").splitlines()) <= 40
