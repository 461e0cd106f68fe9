"""A block of frequencies by rings of panels on two meshes: coefficients and their estimated error."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import displacements_of, with_excitation
from vsb.engine.hydro.panel_solver import LEAST_DEPTH_IN_WAVENUMBERS
from vsb.engine.hydro.panels.rings import AxisymmetricProblem, quick_green_function
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.sweep import apart, coefficients, joined, largest, on_grid
from vsb.engine.hydro.witness import Runs, Waves, runs
from vsb.engine.shell.modes import ModeBasis

STRONGEST_KA = 0.5
"""k R near which damping is largest; errors of a block of high frequencies are relative to that damping, too."""


@dataclass(frozen=True)
class TwoMeshes:
    """A problem on the mesh asked for and on one of half its rows, half around and on the lid.

    Errors are relative to the largest entry of those solved and of those at `STRONGEST_KA`.

    Panels are of an order between one and two, so the error on the fine mesh is at most the change by half the rows.
    Errors common to both meshes, of a lid near resonance and of the Green function of finite depth, show in Haskind's
    relation. The estimate is the sum of both. Measured against the spectral solver (docs/decisions/0001).
    """

    fine: AxisymmetricProblem
    coarse: AxisymmetricProblem

    @property
    def strongest(self) -> xr.Dataset:
        """Coefficients on the fine mesh near the largest damping of all frequencies."""
        p = self.fine
        k = max(STRONGEST_KA / p.waterline, LEAST_DEPTH_IN_WAVENUMBERS / p.depth)
        return p.solve([float(np.sqrt(p.gravity * k * np.tanh(k * p.depth)))])

    def error_estimate(self, solved: xr.Dataset, strongest: xr.Dataset) -> float:
        """Return the estimated error of coefficients solved on the fine mesh [-]."""
        p, (a, b, x), sizes = self.fine, coefficients(solved), largest(solved, strongest)
        halved = coefficients(self.coarse.solve(solved.omega.values.tolist()))
        missed = apart(haskind_damping(with_excitation(solved), p.depth, p.density, p.gravity).reshape(b.shape), b)
        twisted = apart(solved.added_mass.values, solved.added_mass.values.transpose(0, 2, 1))
        both = (twisted / sizes[0], missed / sizes[1], missed / sizes[1])
        changes = [apart(*pair) for pair in zip((a, b, x), halved, strict=True)]
        return max(change / size + wrong for change, size, wrong in zip(changes, sizes, both, strict=True))

    def at_infinity(self) -> xr.Dataset:
        """Return added_mass_inf [kg], shape (displacement, displacement), with the attribute `error_estimate`."""
        fine, coarse = self.fine.at_infinity(), self.coarse.at_infinity()
        error = (apart(fine, coarse) + apart(fine, fine.T)) / (np.abs(fine).max() or 1.0)
        labels = [each.label for each in self.fine.displacements]
        coords = {"influenced_dof": labels, "radiating_dof": labels}
        return xr.Dataset({"added_mass_inf": (tuple(coords), fine)}, coords, {"error_estimate": error})

    def solve(self, frequencies: list[float], interpolation: float | None = None) -> xr.Dataset:
        """Return coefficients at frequencies, ascending [rad/s], solved or interpolated.

        Parameters
        ----------
        frequencies : list of float [rad/s]
        interpolation : float, optional
            Tolerance of interpolation [-]; without it every frequency is solved.

        Returns
        -------
        xarray.Dataset
            As of `AxisymmetricProblem.solve`, with the attributes `error_estimate`, of panels and interpolation
            together; `solves` and `frequencies`, their numbers.
        """
        strongest, at = self.strongest, cache(lambda omega: self.fine.solve([omega]))

        def solve(omegas: list[float]) -> xr.Dataset:
            return joined(*map(at, omegas))

        if interpolation is None:
            found, between = solve(frequencies), 0.0
            solved = found
        else:
            swept = on_grid(solve, frequencies, interpolation, self.fine.incident_wave, [strongest])
            found, solved = swept.coefficients, solve(swept.solved)
            between = swept.sweep.error if swept.sweep else 0.0
        error = self.error_estimate(solved, strongest) + between
        return found.assign_attrs(error_estimate=error, solves=solved.sizes["omega"], frequencies=len(frequencies))


def witness_runs(meshes: tuple[xr.Dataset, xr.Dataset], basis: ModeBasis, waves: Waves) -> Runs:
    """Return the panels' coefficients of a shape on two meshes, the finer one first."""
    green, moved = quick_green_function(), displacements_of(basis)
    fine, coarse = (
        AxisymmetricProblem(green, mesh, moved, waves.density, waves.depth, waves.gravity) for mesh in meshes
    )
    omegas = list(waves.omegas)
    return runs(lambda: fine.solve(omegas), lambda: coarse.solve(omegas), basis, waves)
