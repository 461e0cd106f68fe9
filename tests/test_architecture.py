"""Dependencies between the parts of the package, read from its source."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).parent.parent
ROOMS = ("errors", "tools", "keys", "engine", "study", "pipeline", "models", "results", "design", "report", "stages", "api",
         "cli", "__main__")  # fmt: skip
"""Each imports only from itself and those before it."""
ENGINE = ("waves", "shell", "hydro", "motion", "integrators")
"""Likewise within the engine."""
HEAVY = {"scipy", "xarray", "capytaine", "matplotlib", "netCDF4"}
BY_NAME = re.compile(r"(?:__import__|import_module)\([^\"']*[\"'](\w[\w.]*)")


def named(node):
    """Full names of the modules that an import, or a call of `import_module`, refers to."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        base = ".".join(part for part in ("vsb" if node.level else "", node.module) if part)
        return [f"{base}.{alias.name}" for alias in node.names] if base.split(".")[0] == "vsb" else [base]
    called = getattr(node, "func", None)
    by_name = getattr(called, "attr", getattr(called, "id", "")) in ("__import__", "import_module")
    return BY_NAME.findall(ast.unparse(node)) if by_name else []


def imported(tree):
    """Packages, and names in vsb without that prefix, that a module imports anywhere."""
    names = [name.partition(".") for node in ast.walk(tree) for name in named(node)]
    return {top for top, _, _ in names}, {rest for top, _, rest in names if top == "vsb" and rest and rest[0] != "_"}


@pytest.fixture(scope="module")
def trees():
    """Source of every module; parsed by the tests that ask, as it takes seconds."""
    paths = [path for path in sorted((HOME / "vsb").rglob("*.py")) if path.stem != "__init__"]
    names = [".".join(path.relative_to(HOME).with_suffix("").parts) for path in paths]
    return {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in zip(names, paths, strict=True)}


@pytest.fixture(scope="module")
def imports(trees):
    """What every module imports."""
    return {name: imported(tree) for name, tree in trees.items()}


def modules(imports, name):
    """Modules of vsb that one imports, or imports something from."""
    own = imports[name][1]
    return {one for one in imports if any(f"{found}.".startswith(f"{one.removeprefix('vsb.')}.") for found in own)}


@pytest.mark.parametrize(
    ("code", "packages", "own"),
    [
        ("import numpy as np, scipy.linalg", {"numpy", "scipy"}, set()),
        ("def f():\n    from vsb.modes import Mode", {"vsb"}, {"modes.Mode"}),
        ("from vsb import modes, __version__", {"vsb"}, {"modes"}),
        ("if x:\n    from .modes import *", {"vsb"}, {"modes.*"}),
        ("importlib.import_module('vsb.modes')", {"vsb"}, {"modes"}),
        ("x = 'import numpy'  # from scipy import linalg", set(), set()),
    ],
)
def test_every_form_of_import_is_found(code, packages, own):
    assert imported(ast.parse(code)) == (packages, own)


def test_modules_import_only_from_lower_levels(imports):
    assert {name.split(".")[1] for name in imports} == set(ROOMS)
    for name, (_, own) in imports.items():
        below = set(ROOMS[: ROOMS.index(name.split(".")[1]) + 1])
        assert {found.partition(".")[0] for found in own} <= below, name
        if name.startswith("vsb.engine."):
            lower = set(ENGINE[: ENGINE.index(name.split(".")[2]) + 1])
            assert {found.split(".")[1] for found in own if found.startswith("engine.")} <= lower, name


def test_there_are_no_circular_imports(imports):
    left = {name: modules(imports, name) - {name} for name in imports}
    while ready := [name for name, needs in left.items() if not needs & left.keys()]:
        for name in ready:
            del left[name]
    assert not left


def test_imports_that_are_reserved_to_one_place(imports):
    """Capytaine to the panels; of motion the integrators see systems alone."""
    for name, (packages, _) in imports.items():
        assert not packages & {"benchmarks", "examples", "tests"}, name
        assert "capytaine" not in packages or name.startswith("vsb.engine.hydro.panels."), name
        if name.startswith("vsb.engine.integrators."):
            motion = {one for one in modules(imports, name) if one.startswith("vsb.engine.motion.")}
            assert motion <= {"vsb.engine.motion.system"}, name


def test_parsing_the_workflow_imports_nothing_heavy():
    code = f"import sys, vsb, vsb.study.study, vsb.pipeline.plans; print(*({HEAVY!r} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], cwd=HOME, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_dataclasses_are_frozen(trees):
    """But for those named here, which change while they work."""
    found = {
        (node.name, any(k.arg == "frozen" for d in node.decorator_list if isinstance(d, ast.Call) for k in d.keywords))
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and any("dataclass" in ast.unparse(d) for d in node.decorator_list)
    }
    assert {name for name, frozen in found if not frozen} == {"Optima", "Sampler", "Track", "Trials", "Work"}
