"""Work and precision of hydrodynamic coefficients: error against seconds and memory of six ways to compute them.

The floating hemisphere in deep water, normal velocities P_0..P_6 and excitation, below the first irregular frequency:
no method needs a lid. Radius, density and gravity are one: omega^2 = Ka. Every method runs in a process of its own on
one thread. Errors are true ones, against the spectral solver at `REFERENCE_NODES`, where it has converged to round-off;
it shares nothing with panels, and the multipole series of the tests agrees with it to that series' own error, 3e-6.
"""

import multiprocessing
import os
import resource
import sys
import tempfile
import time as clock
import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import capytaine as cpt
import numpy as np
import xarray as xr

from benchmarks.measure import Row, as_csv, say
from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.panels import bem
from vsb.engine.hydro.panels.mesh import mean_mesh
from vsb.engine.hydro.panels.rings import AxisymmetricProblem
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import rigid_sphere
from vsb.tools.files import write_text

COLUMNS = (
    "method", "setting", "unknowns", "error", "error_added_mass", "error_damping", "error_excitation", "seconds",
    "frequencies", "memory_mb", "status",
)  # fmt: skip
DISPLACEMENTS = tuple(Displacement("radial", n) for n in range(7))
KA = (0.2, 0.5, 1.0, 1.5)
"""Where errors are taken; the first irregular frequency is at 2.557."""
SWEEP = 60
"""Frequencies between, of the methods whose set-up is worth sharing among them."""
REFERENCE_NODES = 64
TIME_LIMIT = 300.0
"""Of one method at one setting, repeats included [s]."""
MEMORY_LIMIT = 1.5e9
"""Of the matrices of one frequency [B]; with two planes capytaine 3.0 keeps those of every frequency."""
ENOUGH = 1.0
"""Repeats end when they have taken as long [s]."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
NODES = (8, 12, 16, 24, 32)


class FlatPanels(AxisymmetricProblem):
    """Rings with capytaine's own diagonal."""

    def rings(self, with_lid: bool) -> bem.SymmetricPanels:
        """Return rings without correction."""
        found = super().rings(with_lid)
        vars(found)["correction"] = np.zeros(found.part.nb_faces)
        return found


Solve = Callable[[int, str, list[float]], xr.Dataset]
"""Coefficients by setting, folder of the Green-function table and frequencies."""


_green = cache(bem.green_function)
"""The Green function of a folder; its table is read once, and neither its seconds nor its memory are a method's."""


def _rings(kind: type[AxisymmetricProblem], rows: int, green: str) -> AxisymmetricProblem:
    """Hemisphere of `rows` rows and twice as many panels around, no lid."""
    mesh = mean_mesh(1.0, 0.0, rows, 2 * rows, 0)
    return kind(_green(green), mesh, DISPLACEMENTS, 1.0, np.inf, 1.0)


def _by_rings(kind: type[AxisymmetricProblem], rows: int, green: str, omegas: list[float]) -> xr.Dataset:
    """One system of a row's unknowns each."""
    return _rings(kind, rows, green).solve(omegas)


def _by_capytaine(symmetry: str, rows: int, green: str, omegas: list[float]) -> xr.Dataset:
    """Capytaine's own solver with all panels as unknowns: no symmetry, two planes or a rotation.

    The attribute seconds is of matrices, linear systems and products alone, by capytaine's own timer.
    """
    problem = _rings(FlatPanels, rows, green)
    azimuth = int(problem.mesh.attrs["azimuth"])
    wedges = [problem.body.part.rotated_z(2 * np.pi * (i + 0.5) / azimuth) for i in range(azimuth)]
    mesh: Any = bem.joined(wedges[: azimuth // 4] if symmetry == "planes" else wedges)
    if symmetry == "planes":
        mesh = cpt.ReflectionSymmetricMesh(cpt.ReflectionSymmetricMesh(mesh, plane="yOz"), plane="xOz")
    elif symmetry == "rotation":
        mesh = cpt.RotationSymmetricMesh(wedges[0], n=azimuth)
    along = np.tile(problem.velocities, azimuth)
    dofs = {d.label: w[:, None] * mesh.faces_normals for d, w in zip(problem.displacements, along, strict=True)}
    body = cpt.FloatingBody(mesh=mesh, dofs=dofs, name=f"{symmetry} {mesh.nb_faces}")
    names = {"rho": [problem.density], "g": [problem.gravity], "water_depth": [problem.depth], "wave_direction": [0.0]}
    wanted = xr.Dataset(coords={"omega": omegas, "radiating_dof": list(dofs), **names})
    solver = cpt.BEMSolver(green_function=problem.green)
    solved: xr.Dataset = solver.fill_dataset(wanted, body, hydrostatics=False, progress_bar=False)
    seconds = sum(step["timing"] for step in solver.timer.timings if not step["step"].startswith("Total"))
    return solved.sel(influenced_dof=list(dofs), radiating_dof=list(dofs)).assign_attrs(seconds=seconds)


def _by_spectral(nodes: int, green: str, omegas: list[float]) -> xr.Dataset:
    """Without panels or table."""
    return SpectralProblem(rigid_sphere(1.0, 0.0), DISPLACEMENTS, 1.0, 1.0, nodes).solve(omegas)


@dataclass(frozen=True)
class Method:
    """One way to the coefficients."""

    solve: Solve
    settings: tuple[int, ...]  # rows of panels, or nodes
    parts: Callable[[int], int] | None = None  # like parts of the matrix of all panels, of which one is computed

    def unknowns(self, setting: int) -> int:
        """Return the unknowns of one right-hand side."""
        return 2 * setting**2 if self.parts else setting

    def matrix_bytes(self, setting: int) -> float:
        """Return the size of the matrices of all panels: two complex ones and the factors of one [B]."""
        return 48 * self.unknowns(setting) ** 2 / self.parts(setting) if self.parts else 0.0

    @property
    def omegas(self) -> list[float]:
        """Frequencies solved: those of `KA`, and a sweep between where set-up is shared among them."""
        own = np.sqrt(KA)
        return [float(w) for w in (own if self.parts else np.union1d(own, np.linspace(own[0], own[-1], SWEEP)))]


PLAIN, ROTATION, CORRECTED, SPECTRAL = "capytaine", "capytaine, rotation", "rings, flux correction", "spectral"
METHODS: Mapping[str, Method] = {
    PLAIN: Method(partial(_by_capytaine, "none"), (10, 20, 40), lambda rows: 1),
    "capytaine, two planes": Method(partial(_by_capytaine, "planes"), (20,), lambda rows: 4),
    ROTATION: Method(partial(_by_capytaine, "rotation"), (10, 20, 40, 80), lambda rows: 2 * rows),
    "rings": Method(partial(_by_rings, FlatPanels), (20, 80)),
    CORRECTED: Method(partial(_by_rings, AxisymmetricProblem), (10, 20, 40, 80)),
    SPECTRAL: Method(_by_spectral, NODES),
}


# measurement --------------------------------------------------------------------------------------------------------


@cache
def reference(nodes: int = REFERENCE_NODES) -> xr.Dataset:
    """Return the coefficients every method is measured against."""
    return _by_spectral(nodes, "", [float(w) for w in np.sqrt(KA)])


def errors(solved: xr.Dataset) -> Row:
    """Return the largest errors at `KA`, each relative to the largest entry at its frequency, and the largest of them.

    Errors of the complex excitation hold those of its phase.
    """
    exact = reference()
    solved = solved.sel(omega=exact.omega, method="nearest")

    def worst(*names: str) -> float:
        value, true = (sum(np.asarray(ds[n].transpose(*exact[n].dims)) for n in names) for ds in (solved, exact))
        size = np.abs(true).reshape(len(KA), -1).max(axis=1)
        return float((np.abs(value - true).reshape(len(KA), -1).max(axis=1) / size).max())

    parts = {
        "error_added_mass": worst("added_mass"),
        "error_damping": worst("radiation_damping"),
        "error_excitation": worst("Froude_Krylov_force", "diffraction_force"),
    }
    return {"error": max(parts.values()), **parts}


def _resident(*, forget: bool = False) -> float:
    """Largest memory of this process so far [MB], whoever asked for it; Linux can forget earlier peaks."""
    if forget and sys.platform == "linux":
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform == "linux" else 1024**2)


def _memory(run: Callable[[], object]) -> float:
    """Memory a run adds [MB]: the larger of what the process grows by and what Python and NumPy ask for.

    The first sees all of Fortran but misses what fits into memory freed before, the second the other way round.
    """
    before = _resident(forget=True)
    tracemalloc.start()
    run()
    traced = tracemalloc.get_traced_memory()[1] / 1024**2
    tracemalloc.stop()
    return max(_resident() - before, traced)


def _run(method: Method, setting: int, green: str) -> tuple[xr.Dataset, float]:
    """Coefficients and the seconds a processor worked on them; the share it gave of its time holds for every part."""
    begun, busy = clock.perf_counter(), clock.process_time()
    solved = method.solve(setting, green, method.omegas)
    took = clock.perf_counter() - begun
    return solved, solved.attrs.get("seconds", took) * (clock.process_time() - busy) / took


def measure(name: str, setting: int, green: str) -> Row:
    """Return errors, seconds per frequency and memory of one method at one setting, in this process.

    Seconds are those of one processor at work, the least of several runs. Ours are of everything, set-up shared among
    the frequencies; capytaine's are of its matrices, systems and products by its own timer, without meshes, checks and
    datasets. Memory is what a run adds to a process that has already solved a small case.
    """
    method = METHODS[name]
    method.solve(method.settings[0], green, method.omegas[:1])  # loads libraries and table
    memory = _memory(partial(_run, method, setting, green))
    deadline = clock.perf_counter() + ENOUGH
    solved, least = _run(method, setting, green)
    while clock.perf_counter() < deadline:
        least = min(least, _run(method, setting, green)[1])
    count = len(method.omegas)
    return {**errors(solved), "seconds": least / count, "frequencies": count, "memory_mb": memory}


def _child(sender: Connection, name: str, setting: int, green: str) -> None:
    """Measure and report to the parent."""
    sender.send(measure(name, setting, green))


def _received(target: Callable[..., None], limit: float, *args: object) -> Row:
    """What a process of its own sends within its limit, or a status that says why it sent nothing."""
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=target, args=(sender, *args), daemon=True)
    process.start()
    sender.close()
    try:
        if not receiver.poll(limit):
            return {"status": f"stopped after its limit of {limit:g} s"}
        return {**receiver.recv(), "status": "completed"}
    except EOFError:
        process.join()
        return {"status": f"failed with exit code {process.exitcode}"}
    finally:
        process.kill()
        process.join()


def attempt(name: str, setting: int, green: str, *, limit: float = TIME_LIMIT) -> Row:
    """Return the row of one method at one setting; a run that is too large, too slow or fails has a status alone."""
    method = METHODS[name]
    row = {"method": name, "setting": setting, "unknowns": method.unknowns(setting)}
    if (needed := method.matrix_bytes(setting)) > MEMORY_LIMIT:
        return {**row, "status": f"not run: matrices of {needed / 1e9:.1f} GB, limit {MEMORY_LIMIT / 1e9:g} GB"}
    return {**row, **_received(_child, limit, name, setting, green)}


def benchmark(out: str | Path) -> list[Row]:
    """Measure every method at every setting and write a table.

    Returns
    -------
    list of Row
        A run that failed, was stopped or not tried has a status and no numbers.
    """
    os.environ.update(dict.fromkeys(THREADS, "1"))  # of the processes that measure
    rows = []
    with tempfile.TemporaryDirectory() as green:
        bem.green_function(green)  # computes the table, once
        for name, method in METHODS.items():
            for setting in method.settings:
                rows.append(attempt(name, setting, green))
                say(", ".join(f"{v:.3g}" if isinstance(v, float) else str(v) for v in rows[-1].values()))
    write_text(out, as_csv(rows, COLUMNS))
    return rows
