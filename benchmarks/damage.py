"""Damage to finished results at random: flipped bits in any file, cuts and edits of those that hold JSON.

Each is reported in one line, by `vsb verify` and by a run that decides what is to be done, or changes nothing
that is read.
"""

import io
import json
import os
import random
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import chdir, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from benchmarks import torture
from benchmarks.measure import Outcome, tabulated
from vsb.errors import VsbError
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import make
from vsb.stages.verify import stale_products, verify
from vsb.study.study import load
from vsb.tools.commands import HOME
from vsb.tools.files import read_groups, write_text

FEW_MODES = HOME / "config" / "few_modes.yaml"
STUDY = "small.yaml"
JUNK: tuple[Any, ...] = (
    None, True, "", "x", "../../small.yaml", "/nowhere", "\ud800", "a\x00b", [], {}, [[]], {"size": 1}, -1, 0.5, 10**30,
    "9" * 100_000,
)  # fmt: skip
TOKENS = ("{", "}", "[", "]", ",", ":", '"', "\\", "\x00", "\ufeff", "NaN", "-Infinity", "1e999", "[" * 100_000)
"""What is put into a text anywhere; the last is deeper than anybody reads."""
BAD = ("silent", "traceback", "long message")
"""What must not become of damage: changed values unseen, ..."""


class Damage(NamedTuple):
    """What was done to a file."""

    path: str
    what: str
    content: bytes


def small_text(duration: float, **hydro: str) -> str:
    """Return the text of a study that takes seconds."""
    raw = yaml.safe_load(FEW_MODES.read_text(encoding="utf-8"))
    raw |= {"study": "small", "modes": {"basis": "membrane", "degree": 2}}
    raw |= {"designs": {"FSB": {"flexible": False}, "VSWEC": {}}}
    raw["hydro"] = {"omega_max": 5.0, "tolerance": 1.0e-3, **hydro}
    raw["simulation"] |= {"duration": duration, "window": [duration / 2, duration]}
    return yaml.safe_dump(raw, sort_keys=False)


def finish() -> StudyPlan:
    """Put the study and its results into the current folder; sound ones, or every damage to them would be reported."""
    write_text(STUDY, small_text(8.0, witness="none"))
    plan = StudyPlan(load(STUDY))
    make(plan, plan.products)
    verify(STUDY)
    return plan


# damage -------------------------------------------------------------------------------------------------------------


def flipped(rng: random.Random, files: list[str]) -> Damage:
    """Flip one bit of one file, of larger ones more often."""
    (path,) = rng.choices(files, [os.path.getsize(each) ** 0.5 for each in files])
    content = bytearray(Path(path).read_bytes())
    bit = rng.randrange(8 * len(content))
    content[bit // 8] ^= 1 << (bit % 8)
    return Damage(path, f"bit {bit}", bytes(content))


def edited(rng: random.Random, files: list[str]) -> Damage:
    """Cut a text anywhere, put something into it anywhere, or change one of the values it holds."""
    path = rng.choice(files)
    content = Path(path).read_bytes()
    at, kind = rng.randrange(len(content)), rng.randrange(3)
    if kind == 0:
        return Damage(path, f"cut at {at}", content[:at])
    if kind == 1:
        token = rng.choice(TOKENS)
        return Damage(path, f"{token[:12]!r} at {at}", content[:at] + token.encode() + content[at:])
    data = json.loads(content)
    place = torture.damage(rng, data, JUNK)
    return Damage(path, place, json.dumps(data, indent=1).encode())


# its fate -----------------------------------------------------------------------------------------------------------


def fate(plan: StudyPlan, damage: Damage) -> Outcome:
    """Return what becomes of damage to results in the current folder, which is put right again afterwards.

    The file keeps its old time: it is not to be found by that.
    """
    path = Path(damage.path)
    good, read, times = path.read_bytes(), _read(path), path.stat()
    path.write_bytes(damage.content)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    try:
        outcomes = [_answer(lambda: verify(STUDY)), _answer(lambda: _decided(plan))]
        worst = next((one for one in outcomes if one.verdict in BAD), None)
        if worst or outcomes[0].verdict == "reported":
            return worst or outcomes[0]
        return Outcome("harmless", "") if _read(path) == read else Outcome("silent", damage.what)
    finally:
        path.write_bytes(good)


def _read(path: Path) -> object:
    """What is read of a sound file: of a netCDF file its values and names, of others their bytes."""
    if path.suffix == ".nc":
        return {name: ds.to_dict() for name, ds in read_groups(path).items()}
    return path.read_bytes()


def _decided(plan: StudyPlan) -> None:
    """What a run makes anew is reported in one line, like an error."""
    said = io.StringIO()
    with redirect_stdout(said):
        stale = stale_products(plan, dry=True)
    if stale:
        raise VsbError(said.getvalue().strip())


def _answer(ask: Callable[[], object]) -> Outcome:
    """What a command answers: reported or harmless, or one of `BAD`."""
    try:
        ask()
    except Exception as error:
        return Outcome.of(error, "reported", lines=2)
    return Outcome("harmless", "")


def trials(flips: int, edits: int) -> Iterator[Damage]:
    """Give damage to the finished study in the current folder, always the same."""
    files = sorted(str(path) for path in Path("results").rglob("*") if path.is_file() and path.stat().st_size)
    texts = [path for path in files if path.endswith(".json")]
    for index in range(flips):
        yield flipped(random.Random(index), files)
    for index in range(edits):
        yield edited(random.Random(index), texts)


def benchmark(count: int, out: str) -> Counter[str]:
    """Flip so many bits in the results of a small study, edit half as often; write a table, count those of `BAD`."""
    target = os.path.abspath(out)
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        plan = finish()
        tried = trials(count, count // 2)
        fates = (((one.path, one.what), fate(plan, one)) for one in tried)
        return tabulated(fates, ("file", "damage"), BAD, target)
