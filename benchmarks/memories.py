"""Radiation memory of many motions by three fits of the same samples: passivity, error, order, seconds.

`passive` is `vsb.hydro.passive`, `vector fit` its first step alone, common poles with full residues, and
`entry by entry` what identification of single kernels does: every entry of K with poles of its own, as FDI.
The least damping is proven over all frequencies (`vsb.hydro.passivity`), in terms of each motion's largest damping.
"""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.linalg import block_diag

from benchmarks.measure import Row, as_csv
from vsb.errors import VsbError
from vsb.hydro.passive import RadiationSamples, entry_error, fit_passive, sizes
from vsb.hydro.passivity import least_damping
from vsb.hydro.realisation import StateSpace, rational_fit
from vsb.hydro.retardation import DampingSpectrum
from vsb.tools.files import write_text
from vsb.tools.units import ComplexArray, FloatArray

TOLERANCES = (1e-2, 1e-3)
POLES = (4, 6, 8, 10, 12, 14, 16)
COLUMNS = ("case", "motions", "method", "tolerance", "order", "error", "least_damping", "at", "seconds", "status")


def smooth(dof: int, noise: float = 0.0, last: float = 8.0) -> RadiationSamples:
    """Return samples of two smooth channels, which no state space has exactly, with noise, up to a frequency."""
    omega = np.arange(1, 161) * 0.05
    n = np.arange(1.0, dof + 1)
    one, other = omega[:, None] ** 2 * np.exp(-omega[:, None] * n / dof), omega[:, None] * np.exp(-omega[:, None] / n)
    damping = one[:, :, None] * one[:, None, :] + other[:, :, None] * other[:, None, :] * (-1) ** (n[:, None] + n)
    change = DampingSpectrum(omega, damping).added_mass_difference(omega)
    size = sizes(omega, damping, np.zeros(dof))
    random = np.random.default_rng(1).normal(size=(2, *damping.shape)) * noise * np.outer(size, size)
    random += random.swapaxes(-1, -2)
    kept = omega <= last
    added = np.eye(dof) + change + random[0] / omega[:, None, None]
    return RadiationSamples(omega[kept], added[kept], (damping + random[1])[kept], np.eye(dof), size)


def passive(samples: RadiationSamples, tolerance: float) -> StateSpace:
    """The project's fit."""
    model = fit_passive(samples, tolerance).model
    g = model.input_matrix / samples.size
    return StateSpace(model.state_matrix, g, g.T)


def vector_fitted(samples: RadiationSamples, tolerance: float) -> StateSpace:
    """Common poles and full residues, as many as the tolerance asks for."""
    return _first_within(rational_fit, samples.omega, samples.transfer, tolerance)


def entry_by_entry(samples: RadiationSamples, tolerance: float) -> StateSpace:
    """Every entry with poles of its own."""
    dof, k = len(samples.size), samples.transfer
    parts = [
        (i, j, _first_within(rational_fit, samples.omega, k[:, i, j, None, None], tolerance))
        for i in range(dof)
        for j in range(dof)
    ]
    a = block_diag(*(part.state_matrix for _, _, part in parts))
    b = np.vstack([np.outer(part.input_matrix[:, 0], np.eye(dof)[j]) for _, j, part in parts])
    c = np.hstack([np.outer(np.eye(dof)[i], part.output_matrix[0]) for i, _, part in parts])
    return StateSpace(a, b, c)


def _first_within(fit: Callable[..., StateSpace], omega: FloatArray, k: ComplexArray, tolerance: float) -> StateSpace:
    """The fit with the fewest poles within a tolerance, or the best of all."""
    fits = []
    for poles in POLES:
        found = fit(omega, k, poles)
        fits.append((entry_error(found.transfer(omega) - k), found))
        if fits[-1][0] <= tolerance:
            break
    return min(fits, key=lambda one: one[0])[1]


METHODS = {"passive": passive, "vector fit": vector_fitted, "entry by entry": entry_by_entry}
CASES: dict[str, Callable[[], RadiationSamples]] = {
    "smooth": lambda: smooth(6),
    "with noise 1e-3": lambda: smooth(6, noise=1e-3),
    "band ends early": lambda: smooth(6, last=4.0),
    "twelve motions": lambda: smooth(12),
}


def measured(case: str, samples: RadiationSamples, method: str, tolerance: float) -> Row:
    """Return one row of the table; a fit that gives up says why."""
    row = {"case": case, "motions": len(samples.size), "method": method, "tolerance": tolerance, "status": "ok"}
    begun = time.perf_counter()
    try:
        system = METHODS[method](samples, tolerance)
    except VsbError as error:
        return row | {"status": " ".join(str(error).split())}
    row["seconds"] = time.perf_counter() - begun
    least = least_damping(system)
    missed = entry_error(system.transfer(samples.omega) - samples.transfer)
    return row | {"order": len(system.state_matrix), "error": missed, "least_damping": least.value, "at": least.omega}


def benchmark(folder: str | Path) -> list[Row]:
    """Write memories.csv into a folder and return its rows."""
    rows = [
        measured(case, made(), method, tolerance)
        for case, made in CASES.items()
        for method in METHODS
        for tolerance in TOLERANCES
    ]
    write_text(Path(folder, "memories.csv"), as_csv(rows, COLUMNS))
    return rows
