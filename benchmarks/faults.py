"""Faults put into the package one at a time: whether its tests see them.

A fault is what a careless edit does to one place: a summand, factor, argument, condition or call left out, the larger
taken for the smaller, a branch never taken, a number doubled. Modules and functions are drawn at random, longer ones
more often. The tests of the module are asked first, then those of files that import it; a fault counts as caught if
what failed passes without it. Tests further away are not asked, and some faults change nothing anybody could see: those
that survive are to be read, and the share caught is a lower bound.
"""

import ast
import copy
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.measure import Outcome, tabulated

HERE = Path(__file__).parents[1]
LIMIT = 600.0
"""Seconds for the tests of one file or of all files near by."""
BAD = ("survived", "undecided")
ENOUGH = 0.95
"""Share of faults that are to be caught."""
COPIED = (
    "vsb", "tests", "workflow", "profiles", "config", "benchmarks", "examples", "docs", "pyproject.toml", "Snakefile",
    "Makefile", "README.md", "CHANGELOG.md",
)  # fmt: skip
"""What of a checkout tests may look at."""
OTHER = {"max": "min", "min": "max", "any": "all", "all": "any", "maximum": "minimum", "minimum": "maximum"}
TURNED = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE, ast.Eq: ast.NotEq, ast.In: ast.NotIn}
UNSEEN = {"annotation", "returns", "decorator_list"}
"""Fields of the syntax tree in which nothing is computed."""
Function = ast.FunctionDef | ast.AsyncFunctionDef


class Fault(NamedTuple):
    """What is written in place of a module."""

    path: str
    function: str
    line: int
    edit: str  # before -> after
    text: str  # of the whole module


# edits --------------------------------------------------------------------------------------------------------------


def edits(node: ast.AST) -> Iterator[ast.AST]:
    """Give what a careless edit may leave of a part of a function."""
    match node:
        case ast.BinOp(op=ast.Add() | ast.Mult()):
            yield from (node.left, node.right)
        case ast.BinOp(op=ast.Sub() | ast.Div()):
            yield node.left
        case ast.BoolOp():
            yield from (_without(node, "values", i) for i in range(len(node.values)))
        case ast.IfExp():
            yield from (node.body, node.orelse)
        case ast.Compare(ops=[op]) if type(op) in TURNED:
            yield _with(node, ops=[TURNED[type(op)]()])
        case ast.Call():
            yield from _calls(node)
        case ast.comprehension():
            yield from (_without(node, "ifs", i) for i in range(len(node.ifs)))
        case ast.If():
            yield _with(node, test=ast.Constant(False))
        case ast.Expr(value=ast.Call()) | ast.AugAssign():
            yield ast.Pass()
        case ast.Constant(value=float(value)) if value:
            yield ast.Constant(2 * value)


def _calls(node: ast.Call) -> Iterator[ast.AST]:
    """A call without one of its named arguments, or of the opposite function; what is called by name alone, dropped."""
    yield from (_without(node, "keywords", i) for i, one in enumerate(node.keywords) if one.arg)
    match node.func:
        case ast.Name(id=name) if name in OTHER:
            yield _with(node, func=ast.Name(OTHER[name]))
        case ast.Attribute(attr=name) if name in OTHER:
            yield _with(node, func=_with(node.func, attr=OTHER[name]))
        case ast.Name(id="abs" | "sorted"):
            yield node.args[0]


def _with(node: Any, **fields: object) -> Any:
    """A copy with other fields."""
    found = copy.copy(node)
    for name, value in fields.items():
        setattr(found, name, value)
    return found


def _without(node: ast.AST, field: str, index: int) -> Any:
    """A copy without one entry of a list; of two operands the other one."""
    left = [one for i, one in enumerate(getattr(node, field)) if i != index]
    return left[0] if field == "values" and len(left) == 1 else _with(node, **{field: left})


def parts(node: ast.AST) -> Iterator[ast.AST]:
    """Give all in which something is computed, from the outside in."""
    for field, value in ast.iter_fields(node):
        for part in value if isinstance(value, list) else [value]:
            if field not in UNSEEN and isinstance(part, ast.AST):
                yield part
                yield from parts(part)


class _Put(ast.NodeTransformer):
    """One part in place of another."""

    def __init__(self, old: ast.AST, new: ast.AST):
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        """What stands at a part's place."""
        return self.new if node is self.old else self.generic_visit(node)


def edited(path: str, text: str, rng: random.Random) -> Fault | None:
    """Return a module with one edit in one of its functions; None if nothing in that can be edited."""
    tree = ast.parse(text)
    functions = [node for node in ast.walk(tree) if isinstance(node, Function) and not _compiled(node)]
    lengths = [len(ast.unparse(node)) for node in functions]
    function = rng.choices(functions, lengths)[0] if functions else None
    found = [(old, new) for old in parts(function) for new in edits(old)] if function else []
    if not function or not found:
        return None
    old, new = rng.choice(found)
    edit = f"{ast.unparse(old)} -> {ast.unparse(new)}"
    return Fault(
        path, function.name, getattr(old, "lineno", function.lineno), edit, ast.unparse(_Put(old, new).visit(tree))
    )


def _compiled(function: Function) -> bool:
    """Whether a function is a compiled loop; each edit would compile all of them again."""
    return any("njit" in ast.unparse(one) for one in function.decorator_list)


def drawn(count: int, root: Path, seed: int = 0) -> Iterator[Fault]:
    """Give so many faults of the package, always the same for a seed; a module is drawn by its length."""
    texts = {str(path.relative_to(root)): path.read_text("utf-8") for path in sorted((root / "vsb").rglob("*.py"))}
    rng, names = random.Random(seed), list(texts)
    lengths = [texts[name].count("\n") for name in names]
    while count:
        name = rng.choices(names, lengths)[0]
        if fault := edited(name, texts[name], rng):
            count -= 1
            yield fault


# their fate ---------------------------------------------------------------------------------------------------------


def near(path: str, root: Path) -> list[list[str]]:
    """Return the test files of a module: its own, if it has one, and those that import it."""
    module = path.removesuffix(".py").replace("/", ".")
    parts = Path(path).parts[1:]
    own = str(Path("tests", *parts[:-1], f"test_{parts[-1]}"))
    files = {str(file.relative_to(root)): file for file in sorted((root / "tests").rglob("test_*.py"))}
    users = [name for name, file in files.items() if name != own and module in _imported(file)]
    return [group for group in ([own] if own in files else [], users) if group]


def _imported(file: Path) -> set[str]:
    """Names of modules, and of what is taken from them, in the imports of a file."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def failed(tests: Sequence[str], root: Path) -> list[str]:
    """Run tests until one fails and return which; none if all pass.

    Raises
    ------
    subprocess.TimeoutExpired
        If they take longer than `LIMIT`.
    """
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", *tests]
    environment = {**os.environ, "PYTHONPATH": str(root), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    ran = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, timeout=LIMIT, check=False)
    if ran.returncode == 0:
        return []
    return re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", ran.stdout, re.MULTILINE) or list(tests)


def fate(fault: Fault, root: Path) -> Outcome:
    """Return what becomes of a fault in a copy of the project: caught, or one of `BAD`."""
    place = root / fault.path
    sound = place.read_text("utf-8")
    for tests in near(fault.path, root):
        try:
            place.write_text(fault.text, "utf-8")
            found = failed(tests, root)
            place.write_text(sound, "utf-8")
            if found and not failed(found, root):
                return Outcome("caught", f"{fault.edit}: {found[0]}")
        except subprocess.TimeoutExpired:
            return Outcome("undecided", f"{fault.edit}: {', '.join(tests)} take longer than {LIMIT:g} s")
        finally:
            place.write_text(sound, "utf-8")
    return Outcome("survived", fault.edit)


def _copied(place: Path, target: Path) -> None:
    """Copy a file or a folder that is there."""
    if place.is_dir():
        shutil.copytree(place, target)
    elif place.is_file():
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(place, target)


def fates(count: int, root: Path, seed: int) -> Iterator[tuple[tuple[object, ...], Outcome]]:
    """Meet so many faults with their fate, in a copy of a checkout."""
    with tempfile.TemporaryDirectory() as folder:
        copied = Path(folder, "vsb")
        for name in COPIED:
            _copied(root / name, copied / name)
        for fault in drawn(count, root, seed):
            yield (fault.path, fault.line, fault.function), fate(fault, copied)


def benchmark(count: int, out: str, seed: int = 0) -> Counter[str]:
    """Write what becomes of so many faults as a table; count those of `BAD`, none where `ENOUGH` are caught."""
    found = tabulated(fates(count, HERE, seed), ("file", "line", "function"), BAD, out)
    return found if found.total() > (1 - ENOUGH) * count else Counter()
