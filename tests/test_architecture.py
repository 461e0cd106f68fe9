"""The rules of the house, read from the code itself."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from vsb.stages.stage import STAGES

HOME = Path(__file__).parent.parent
ROOMS = (
    "errors", "tools", "study", "shell", "waves", "hydro", "motion", "integrators", "scenes", "results", "report",
    "stages", "cli", "__main__",
)  # fmt: skip
"""Each room imports only from rooms before it."""
MODULES = {
    ".".join(path.relative_to(HOME).with_suffix("").parts): path
    for folder in ("vsb", "benchmarks", "examples")
    for path in sorted((HOME / folder).rglob("*.py"))
    if path.stem != "__init__"
}
PACKAGE = [name for name in MODULES if name.startswith("vsb.")]
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}
OUTSIDE = {"benchmarks", "examples"}
HEAVY = {"numpy", "scipy", "xarray", "capytaine", "matplotlib", "netCDF4"}


WHOLE = {"study.study.Study", "study.specs.Designed", "study.specs.AtRest"}
"""A study, and what may be one."""
NAMED = ast.Name | ast.Attribute
FORCES = {"Force"} | {
    node.name
    for name in PACKAGE
    if name.startswith("vsb.motion.")
    for node in TREES[name].body
    if isinstance(node, ast.ClassDef) and "Force" in map(ast.unparse, node.bases)
}
WORKFLOW = {
    str(path.relative_to(HOME)): path
    for path in (HOME / "Snakefile", HOME / "workflow" / "Snakefile", *sorted((HOME / "workflow").rglob("*.smk")))
}
PARSED = ("__init__", "errors", "study/study", "study/plan")  # read at every parse of the workflow
STATEMENT = re.compile(r"^[ \t]*((?:import|from)[ \t]+(?:[^(\n\\]|\\\n|\([^)]*\))*)", re.MULTILINE)
BY_NAME = re.compile(r"(?:__import__|import_module)\([^\"']*[\"'](\w[\w.]*)")


def named(node):
    """Modules an import statement, or a call of `__import__` or `import_module`, names in full."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        base = ".".join(part for part in ("vsb" if node.level else "", node.module) if part)
        return [f"{base}.{alias.name}" for alias in node.names] if base.split(".")[0] == "vsb" else [base]
    return BY_NAME.findall(ast.unparse(node)) if isinstance(node, ast.Call) else []


def imported(tree):
    """Top-level packages and vsb modules (or names in them) a tree imports, anywhere."""
    packages, own = set(), set()
    for name in (name for node in ast.walk(tree) for name in named(node)):
        top, _, rest = name.partition(".")
        packages.add(top)
        if top == "vsb" and rest and rest[0] not in "_*":
            own.add(rest)
    return packages, own


def rooms(tree):
    """Rooms of vsb a tree imports from."""
    return {name.partition(".")[0] for name in imported(tree)[1]}


def modules(tree, trees):
    """Modules of vsb a tree imports, whether it names them or something in them."""
    own = imported(tree)[1]
    return {name for name in trees if any(f"{found}.".startswith(f"{name.removeprefix('vsb.')}.") for found in own)}


def workflow_tree(text):
    """The imports of a Snakefile as a tree: its other statements are not all Python."""
    lines = [match.strip() for match in STATEMENT.findall(text)]
    return ast.parse("\n".join([*lines, *(f"import {name}" for name in BY_NAME.findall(text))]))


def heavy(tree, trees):
    """Heavy packages a tree imports, itself or through the vsb modules it imports."""
    packages, pending, seen = set(imported(tree)[0]), modules(tree, trees), set()
    while pending:
        name = pending.pop()
        seen.add(name)
        packages |= imported(trees[name])[0]
        pending |= modules(trees[name], trees) - seen
    return packages & HEAVY


def asked(tree):
    """Names of the classes a tree asks objects for, by `isinstance` or `issubclass`."""
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and len(node.args) == 2]
    kinds = [node.args[1] for node in calls if ast.unparse(node.func) in ("isinstance", "issubclass")]
    return {re.split(r"\W", ast.unparse(n))[-1] for kind in kinds for n in ast.walk(kind) if isinstance(n, NAMED)}


def functions(tree):
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def test_every_module_has_its_room():
    assert {name.split(".")[1] for name in PACKAGE} == set(ROOMS)


@pytest.mark.parametrize("name", PACKAGE)
def test_a_room_imports_only_from_rooms_before_it(name):
    own = name.split(".")[1]
    after = rooms(TREES[name]) - set(ROOMS[: ROOMS.index(own) + 1])
    assert not after, f"{name} imports from {sorted(after)}, which come after {own}"


def test_modules_import_each_other_in_no_circle():
    """Kahn's order exists: every module can be read after all it imports."""
    left = {name: modules(TREES[name], TREES) - {name} for name in PACKAGE}
    while ready := [name for name, needs in left.items() if not needs & left.keys()]:
        for name in ready:
            del left[name]
    assert not left, f"circles among {sorted(left)}"


@pytest.mark.parametrize("name", PACKAGE)
def test_the_package_knows_neither_benchmarks_nor_examples(name):
    assert not imported(TREES[name])[0] & OUTSIDE


@pytest.mark.parametrize("name", PACKAGE)
def test_only_the_room_of_panels_imports_capytaine(name):
    assert "capytaine" not in imported(TREES[name])[0] or name.startswith("vsb.hydro.panels.")


@pytest.mark.parametrize("name", [name for name in PACKAGE if name.startswith("vsb.integrators.")])
def test_integrators_see_systems_and_motions_alone(name):
    own = {module for module in modules(TREES[name], TREES) if module.startswith("vsb.motion.")}
    assert own <= {"vsb.motion.system", "vsb.motion.motion"}


@pytest.mark.parametrize("name", [name for name in PACKAGE if name.split(".")[1] in ROOMS[1 : ROOMS.index("scenes")]])
def test_below_scenes_nobody_sees_a_study(name):
    """Rooms below are told sections and numbers; the room `study` alone knows what it makes of them."""
    assert name.startswith("vsb.study.") or not imported(TREES[name])[1] & WHOLE


@pytest.mark.parametrize("name", [f"vsb.stages.{stage.name}" for stage in STAGES])
def test_no_stage_makes_up_a_study(name):
    """It reads its specification, or the study itself where that is what it works on."""
    calls = (node.func for node in ast.walk(TREES[name]) if isinstance(node, ast.Call))
    assert not {"Study", "parse"} & {ast.unparse(each).split(".")[-1] for each in calls}


@pytest.mark.parametrize("name", [name for name in MODULES if not name.startswith("vsb.motion.")])
def test_no_force_is_asked_for_its_type(name):
    """What is asked of a force its methods say; only its own room knows kinds of forces."""
    assert not asked(TREES[name]) & FORCES


def test_the_checker_sees_who_is_asked():
    tree = ast.parse("isinstance(f, Spring | forces.Damper)\nisinstance(x, (int, Excitation))\nSpring(1)")
    assert asked(tree) & FORCES == {"Spring", "Damper", "Excitation"}


@pytest.mark.parametrize("name", [name for name in PACKAGE if name.startswith("vsb.study.")])
def test_a_study_is_read_without_numpy(name):
    assert not heavy(TREES[name], TREES)


@pytest.mark.parametrize("name", PARSED)
def test_what_the_workflow_reads_at_every_parse_is_light(name):
    assert not heavy(ast.parse((HOME / "vsb" / f"{name}.py").read_text(encoding="utf-8")), TREES)


def test_parsing_the_workflow_loads_nothing_heavy():
    """Asked of the interpreter: third parties are in it too. A degree looked for imports what solves, a kept one does not."""
    code = f"import sys, vsb, vsb.study.study, vsb.stages.planning; print(*({HEAVY!r} & sys.modules.keys()))"
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
        ("from vsb.modes import Mode", {"vsb"}, {"modes.Mode"}),
        ("from vsb import modes, __version__", {"vsb"}, {"modes"}),
        ("import vsb.modes as m", {"vsb"}, {"modes"}),
        ("from . import modes", {"vsb"}, {"modes"}),
        ("from .modes import Mode", {"vsb"}, {"modes.Mode"}),
        ("if x:\n    from .modes import *", {"vsb"}, {"modes.*"}),
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
    light = {"vsb.config": ast.parse("import os"), "vsb.modes": ast.parse("import numpy\nfrom .shell import Shell")}
    assert heavy(workflow_tree(text), {**light, "vsb.shell": ast.parse("from scipy import linalg")}) == found


def test_values_are_frozen():
    """Checked once, when they are made; what changes on its way is named here."""
    found = {
        (node.name, any(k.arg == "frozen" for d in node.decorator_list if isinstance(d, ast.Call) for k in d.keywords))
        for tree in TREES.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and any("dataclass" in ast.unparse(d) for d in node.decorator_list)
    }
    assert {name for name, frozen in found if not frozen} == {"Counted", "Optima", "Swept", "Track", "Trials", "Work"}


def test_pairs_and_texts_say_how_they_are_made():
    """Without `strict` the longer of two lists is cut in silence; without `encoding` a text depends on the machine."""
    calls = [(name, node) for name in PACKAGE for node in ast.walk(TREES[name]) if isinstance(node, ast.Call)]
    said = ((r"zip", "strict"), (r".*\.read_text", "encoding"))
    silent = [
        f"{name}:{call.lineno}"
        for name, call in calls
        for made, key in said
        if re.fullmatch(made, ast.unparse(call.func), re.DOTALL) and key not in {k.arg for k in call.keywords}
    ]
    assert not silent


@pytest.mark.parametrize("name", MODULES)
def test_everything_public_is_documented(name):
    nodes = [n for n in ast.walk(TREES[name]) if isinstance(n, ast.FunctionDef | ast.ClassDef)]
    nodes = [n for n in nodes if "overload" not in map(ast.unparse, n.decorator_list)]
    nested = {id(child) for n in nodes if isinstance(n, ast.FunctionDef) for child in ast.walk(n) if child is not n}
    bare = [n.name for n in nodes if id(n) not in nested and not n.name.startswith("_") and not ast.get_docstring(n)]
    assert not bare


def test_every_rule_is_a_command_with_a_log():
    for path in (path for name, path in WORKFLOW.items() if path.suffix == ".smk"):
        text = path.read_text(encoding="utf-8")
        assert text.count("\nrule ") == text.count('"vsb ') == text.count("log:"), path.name
    assert len((HOME / "workflow" / "Snakefile").read_text(encoding="utf-8").splitlines()) <= 40
    assert (HOME / "Snakefile").read_text(encoding="utf-8").startswith('include: "workflow/Snakefile"\n')
