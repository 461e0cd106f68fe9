"""Bodies at random: boxes of any size that bend, twist and breathe, refused in one line or told from check to page.

Each is solved on a few panels, rough and cheap, which its study accepts more often than not; its designs hold some of
its motions, its take-off acts on some combination of them, its matrices are replaced or moored, and not all of it can
be.
"""

import math
import random
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks import torture
from benchmarks.measure import Outcome, tabulated
from examples.barge import box
from vsb.errors import ConvergenceError, DatabaseError
from vsb.hydro.bodies.body import FlexibleBody, at_centres
from vsb.hydro.bodies.files import write_body
from vsb.stages.body_preview import body_summary
from vsb.stages.make import make
from vsb.study.body import CHECKS, REPAIRS, load_body
from vsb.study.body_plan import BodyPlan
from vsb.tools.units import FloatArray

RIGID = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
FLEXIBLE = ("Bend1", "Bend2", "Twist", "Breathe", "Hinge")
LAWS = ("saturated", "coulomb")
"""Those without a pause, which is sought for minutes where a body is nearly stiff."""


def displaced(name: str, points: FloatArray, length: float) -> FloatArray:
    """Return a displacement of points, shape (point, xyz), its largest about one."""
    x, y, none = points[:, 0] / length, points[:, 1] / length, np.zeros(len(points))
    if name in RIGID:
        i = RIGID.index(name)
        along = np.eye(3)[i % 3]
        return np.tile(along, (len(points), 1)) if i < 3 else np.asarray(np.cross(along, points))
    if name == "Twist":
        return np.column_stack([none, -points[:, 2] * x, points[:, 1] * x])
    if name == "Breathe":
        return np.column_stack([none, y, x**2])
    rise = 2 * np.abs(x) if name == "Hinge" else np.cos(int(name[-1]) * math.pi * (x + 0.5))
    return np.column_stack([none, none, rise])


def body_of(rng: random.Random) -> tuple[FlexibleBody, float]:
    """Return a box with some motions, its mass spread over it, and its draught [m]."""
    length = 10 ** rng.uniform(0.0, 2.3)
    beam, draught = length * rng.uniform(0.2, 1.0), length * 10 ** rng.uniform(-1.0, 0.0)
    names = [name for name in RIGID if rng.random() < 0.5]
    names += [name for name in FLEXIBLE if rng.random() < 0.35]
    names = names or ["Heave"]
    vertices, faces = box(length, beam, draught, 2)
    shapes = np.array([displaced(name, vertices, length) for name in names])
    grid = np.meshgrid(*(np.linspace(-0.5, 0.5, 7) * side for side in (length, beam, draught)), indexing="ij")
    held = np.stack(grid, axis=-1).reshape(-1, 3)
    held[:, 2] += draught * rng.choice([-0.8, rng.uniform(-0.7, 0.3)])
    mass = 1025.0 * length * beam * draught * (1.0 if rng.random() < 0.8 else rng.uniform(0.2, 3.0))
    moved = np.array([displaced(name, held, length) for name in names])
    matrix = np.einsum("ipx,jpx->ij", moved, moved) * mass / len(held)
    stiff = np.diag([0.0 if name in RIGID else 10 ** rng.uniform(-1, 3) * mass * 9.81 / length for name in names])
    files = {"mass": matrix, "stiffness": stiff, "centre_of_mass": held.mean(axis=0)}
    if rng.random() < 0.1:
        files.pop(rng.choice(list(files)))
    modes = at_centres(vertices, faces, shapes)
    return FlexibleBody(vertices, faces, tuple(names), modes, shapes, **files), draught


def written(index: int, folder: Path) -> Path:
    """Write the files of a study, always the same for an index; return the study's."""
    rng = random.Random(index)
    body, draught = body_of(rng)
    write_body(body, folder / "box.nc")
    highest = math.sqrt(9.81 / max(draught, float(np.ptp(body.vertices[:, 0])) / 12)) * rng.uniform(0.5, 1.0)
    if rng.random() < 0.1:
        highest *= 2.0  # too short for its panels
    omega = np.round(np.linspace(rng.uniform(0.1, 0.3), 1.0, rng.choice([4, 8, 16, 24, 32])) * highest, 6).tolist()
    file: dict[str, Any] = {
        "body": "box",
        "mesh": "box.nc",
        "modes": "box.nc",
        "omega": omega,
        "lid": rng.choice([0, 1]),
    }
    directions = [0.0, *rng.sample([30.0, 90.0, 180.0], rng.randint(0, 2))]
    file["wave_direction"] = sorted(directions)
    if rng.random() < 0.2:
        depth = draught * 10 ** rng.uniform(0.02, 1.3)
        file["water"] = {"depth": depth}
        file["omega"] = [each for each in omega if each > 0.31 * math.sqrt(9.81 / depth)] or omega
    if rng.random() < 0.8:
        file["tolerance"] = 0.01
    (folder / "box.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")
    (folder / "study.yaml").write_text(yaml.safe_dump(_study(rng, body, omega, directions)), encoding="utf-8")
    return folder / "study.yaml"


def _study(rng: random.Random, body: FlexibleBody, omega: list[float], directions: list[float]) -> torture.Raw:
    """A study of the box."""
    names, mass = list(body.labels), 1025.0 * body.volume
    whole: torture.Raw = {"file": "box.yaml"}
    held = np.ones(len(names)) * mass if body.mass is None else np.diag(body.mass)
    for key, size, range_ in (("stiffness", 9.81, (-4, 1)), ("damping", omega[0], (-4, 1)), ("mass", 1.0, (0, 0.3))):
        if rng.random() < 0.3:
            own = rng.sample(range(len(names)), rng.randint(1, len(names)))
            sign = -1 if rng.random() < 0.05 else 1
            whole[key] = {names[i]: sign * size * float(held[i]) * 10 ** rng.uniform(*range_) for i in own}
    accepted = rng.sample(CHECKS, rng.randint(0, 3)) if rng.random() < 0.2 else list(CHECKS)
    hydro: torture.Raw = {"accept": accepted, "added_mass_inf": rng.choice(["fitted", "given"])}
    if rng.random() < (0.2 if len(omega) > 8 else 0.02):
        hydro["repair"] = rng.sample(REPAIRS, rng.randint(1, 2))
        hydro["accept"] = [name for name in accepted if name not in hydro["repair"]]
    if rng.random() < 0.2:
        hydro["omega_max"] = omega[-1] * rng.uniform(0.5, 1.1)
    if rng.random() < 0.3:
        hydro["tolerance"] = 10 ** rng.uniform(-4, -1)
    period = 2 * math.pi / omega[-1]
    duration = rng.randint(5, 30) * period
    simulation: torture.Raw = {"duration": duration, "window": [rng.choice([0.0, 0.5]) * duration, duration]}
    for key, values in (("initial_position", [0.1]), ("initial_velocity", [-0.1]), ("tolerance", [1e-3, 1e-9])):
        if rng.random() < 0.2:
            simulation[key] = rng.choice(values)
    pto = _take_off(rng, names, mass, omega[-1])
    if rng.random() < 0.2 and "law" not in pto:
        simulation["method"] = rng.choice(["exact", "convolution", "structure_preserving"])
    seas = [_wave(rng, omega, directions) for _ in range(rng.randint(1, 3))]
    return {
        "study": "odd_body", "body": whole, "hydro": hydro, "simulation": simulation,
        "designs": {f"d{i}": _design(rng, names) for i in range(rng.randint(1, 3))},
        "pto": pto,
        "waves": [sea for i, sea in enumerate(seas) if sea not in seas[:i]],
    }  # fmt: skip


def _design(rng: random.Random, names: list[str]) -> torture.Raw:
    """All motions, rigid ones, or some, of which a combination may be held."""
    design: torture.Raw = {"dofs": rng.choice(["all", "all", "rigid", rng.sample(names, rng.randint(1, len(names)))])}
    moves = names if isinstance(design["dofs"], str) else design["dofs"]
    if rng.random() < 0.2:
        design["held"] = [{name: rng.uniform(-1, 1) for name in rng.sample(moves, min(2, len(moves)))}]
    return design


def _wave(rng: random.Random, omega: list[float], directions: list[float]) -> torture.Raw:
    """A sea of any kind, mostly within the band."""
    tp, kind = 2 * math.pi / rng.uniform(omega[0], omega[-1]), rng.choice(["regular", "regular", "jonswap", "still"])
    if kind == "still":
        return {"kind": kind}
    direction = rng.choice(directions) - (360.0 if rng.random() < 0.05 else 0.0)
    sea = {"amplitude": 0.1, "period": tp} if kind == "regular" else {"hs": 0.1, "tp": 2 * tp, "seed": 1}
    return {"kind": kind, "direction": direction, **sea}


def _take_off(rng: random.Random, names: list[str], mass: float, omega: float) -> torture.Raw:
    """A port on some motions, a tuning, a law and limits, of which about half are the default."""
    shares = {name: rng.choice([1.0, 1.0, rng.uniform(-30, 30)]) for name in rng.sample(names, min(2, len(names)))}
    damping = mass * omega * 10 ** rng.uniform(-4, 1)
    law = rng.choice(LAWS) if rng.random() < 0.2 else None
    fixed = rng.random() < 0.5
    kept = {
        "port": rng.choice(["heave"] * ("Heave" in names) + [{"dof": rng.choice(names)}, {"dofs": shares}]),
        "damping": rng.choice([damping, damping, damping, 0.0]) if fixed else None,
        "tuning": rng.choice(["each", "one", "fixed" if fixed else "each"]) if rng.random() < 0.3 else None,
        "stiffness": mass * omega**2 * rng.uniform(-0.1, 1.0) if rng.random() < 0.2 else None,
        "efficiency": rng.uniform(0.3, 1.0) if rng.random() < 0.2 else None,
        "law": law,
        "force_limit": mass * 10 ** rng.uniform(-4, 0) if law else None,
        "stroke_limit": 10 ** rng.uniform(-2, 1) if rng.random() < 0.1 else None,
    }
    return {key: value for key, value in kept.items() if value is not None}


def fate(index: int, folder: Path, shared: Path) -> Outcome:
    """Return what becomes of a study: check it, run it in this process if it passes, to its page."""
    checked = False
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("error", UserWarning)
        try:
            located = load_body(written(index, folder))
            plan = BodyPlan(located.study, root=str(folder / "results"), files=located.files)
            Path(plan.green_folder).parent.mkdir(parents=True)
            Path(plan.green_folder).symlink_to(shared, target_is_directory=True)
            body_summary(plan)
            checked = True
            make(plan, plan.products)
            worst = torture.not_finite(Path(plan.folder))
        except Exception as error:
            return Outcome.of(error, _verdict(error) if checked else "refused")
    return Outcome("not finite" if worst else "completed", worst)


def _verdict(error: Exception) -> str:
    """Of an error after the check: what only solving shows, of coefficients on few panels, or what was to be known."""
    told = ("hydro.repair", "radiation damping")
    shown = isinstance(error, DatabaseError | ConvergenceError) or str(error).startswith(told)
    return "unsound coefficients" if shown else "failed after check"


def fates(count: int) -> Iterator[tuple[tuple[int], Outcome]]:
    """Meet so many studies with their fate; they share the table of the Green function."""
    with tempfile.TemporaryDirectory() as shared:
        for index in range(count):
            with tempfile.TemporaryDirectory() as folder:
                yield (index,), fate(index, Path(folder), Path(shared))


def benchmark(count: int, out: str) -> Counter[str]:
    """Write what becomes of so many bodies as a table; return how often each of `torture.BAD` fell."""
    return tabulated(fates(count), ("index",), torture.BAD, out)
