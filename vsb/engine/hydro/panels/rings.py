"""Radiation and diffraction by an axisymmetric shell on rings of panels, and the estimated error of a sweep.

For axisymmetric motions the unknowns are rings, not panels: the influence of a ring is the sum over its panels, so an
N-row mesh of any azimuthal fineness costs one N x N system per frequency. The same holds for every azimuthal order m,
where strengths go with cos(m theta): surge and pitch have m = 1.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import j0, j1

from vsb.engine.hydro.database import displacements_of, solved_dataset, with_excitation
from vsb.engine.hydro.dofs import Displacement, azimuthal_order, multiplicity, normal_velocities, wave_around
from vsb.engine.hydro.panels import LEAST_DEPTH_IN_WAVENUMBERS
from vsb.engine.hydro.panels.bem import PanelProblem, SymmetricPanels, joined, panel_mesh, quick_green_function
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.sweep import IncidentWave, apart, coefficients, largest, on_grid
from vsb.engine.hydro.sweep import joined as joined_frequencies
from vsb.engine.hydro.witness import Runs, Waves, runs
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.waves.water import wavenumber
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray


def _wedge(x: FloatArray, z: FloatArray, azimuth: int) -> Any:
    """One wedge of panels between the meridian points (x, z), normals to the right of the way along the meridian."""
    angle = np.pi / azimuth
    left, right = (np.column_stack([x * np.cos(a), x * np.sin(a), z]) for a in (-angle, angle))
    i = np.arange(len(x) - 1)
    faces = np.stack([i, i + len(x), i + len(x) + 1, i + 1], axis=1)
    return panel_mesh(np.concatenate([left, right]), faces)


@dataclass(frozen=True)
class AxisymmetricProblem(PanelProblem):
    """Radiation and diffraction of prescribed displacements of the immersed shell, all of one azimuthal order m.

    `mesh` is as of `vsb.engine.hydro.panels.mesh.mean_mesh`. On the sphere itself the meridional displacements move no
    water.
    """

    green: Any  # of `bem`
    mesh: xr.Dataset
    displacements: tuple[Displacement, ...]
    density: float
    depth: float
    gravity: float

    def __post_init__(self) -> None:
        """Check that the displacements have one order."""
        azimuthal_order(self.displacements)

    @cached_property
    def order(self) -> int:
        """Azimuthal order m of all displacements."""
        return azimuthal_order(self.displacements)

    def rings(self, with_lid: bool) -> SymmetricPanels:
        """Return one wedge of panels, keel first and lid last, and the half circle of copies whose sum is a ring.

        The matrix of all panels is block-circulant: orders below half the number of panels around do not mix.
        """
        mesh, azimuth = self.mesh, int(self.mesh.attrs["azimuth"])
        if 2 * self.order >= azimuth:
            raise ConfigError(
                f"order: received {self.order} on {azimuth} panels around; needs 0 <= order < azimuth/2: refine mesh"
            )
        parts = [_wedge(mesh.meridian_radius.values[::-1], mesh.meridian_height.values[::-1], azimuth)]
        if with_lid and mesh.sizes["lid_node"] > 1:
            lid = mesh.lid_radius.values  # from the axis outwards, so that normals point down: with upward normals the
            parts.append(_wedge(lid, np.zeros(len(lid)), azimuth))  # lid resonates by itself (hemisphere: at Ka = 1.27)
        wedge = joined(parts)
        angle = 2 * np.pi * np.arange(azimuth // 2 + 1) / azimuth
        weights = np.where((angle > 0) & (angle < np.pi), 2.0, 1.0)  # copies with a mirror image
        images = joined([wedge.rotated_z(each) for each in angle])
        of_body = np.arange(wedge.nb_faces) < parts[0].nb_faces
        return SymmetricPanels(
            self.green, wedge, images, weights, weights[None] * np.cos(self.order * angle), of_body, self.depth
        )

    @cached_property
    def body(self) -> SymmetricPanels:
        """The shell's rings, without lid."""
        return self.rings(with_lid=False)

    @cached_property
    def _with_lid(self) -> SymmetricPanels:
        """All rings."""
        return self.rings(with_lid=True)

    @property
    def centres(self) -> FloatArray:
        """Radius and height of the body rows' centres, shape (2, row) [m]."""
        x, y, z = self.body.part.faces_centers.T
        return np.array([np.hypot(x, y), z])

    @cached_property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements at theta = 0, shape (displacement, row) [m/s per m/s].

        By the shell's own normals for m = 0; the panels' for m > 0: rigid motions and wave are capytaine's to
        round-off.
        """
        normal = np.array([self.mesh.normal_radius.values[::-1], self.mesh.normal_height.values[::-1]])
        if self.order:
            normal = self.body.part.faces_normals[:, [0, 2]].T
        return normal_velocities(self.displacements, self.mesh.row_colatitude.values[::-1], self.centres, normal)

    @cached_property
    def onto(self) -> FloatArray:
        """Generalized force of a unit potential, -rho w_i dS, shape (displacement, row); cos^2 halves a ring's."""
        areas = int(self.mesh.attrs["azimuth"]) * np.asarray(self.body.part.faces_areas)
        return np.asarray(-self.density * self.velocities * areas / multiplicity(self.order))

    @property
    def waterline(self) -> float:
        """Radius of the waterline [m]."""
        return float(self.mesh.meridian_radius.values[0])

    @property
    def incident_wave(self) -> IncidentWave:
        """Parts of the excitation known without solving."""

        def phase(omega: FloatArray) -> FloatArray:
            return self.waterline * np.array([wavenumber(w, self.depth, self.gravity) for w in omega])

        def froude_krylov(omega: FloatArray) -> ComplexArray:
            return np.array([[1j * w * (self.onto @ self.incident(w)[0])] for w in omega])

        return IncidentWave(phase, froude_krylov, self.order)

    def incident(self, omega: float) -> tuple[ComplexArray, ComplexArray]:
        """Part of azimuthal order m of the incident wave's potential and normal velocity, each shape (row,).

        phi_0 = -i g/omega cosh k(z+d)/cosh kd exp(ikx). The azimuthal mean of exp(ikx) is J_0(kR), free of the aliasing
        of few panels. For m > 0, 2 i^m J_m(kR) is replaced by the sum over panels: with it and the panels' own normals
        the result is capytaine's.
        """
        k = wavenumber(omega, self.depth, self.gravity)
        (x, z), (n_x, _, n_z) = self.centres, self.body.part.faces_normals.T
        mirror, floor = np.exp(-2 * k * (z + self.depth)), 1 + np.exp(-2 * k * self.depth)
        profile, slope = np.exp(k * z) * (1 + mirror) / floor, np.exp(k * z) * (1 - mirror) / floor
        scale = -1j * self.gravity / omega
        azimuth = int(self.mesh.attrs["azimuth"])
        wave, rise = wave_around(self.order, azimuth, k * x) if self.order else (j0(k * x), -j1(k * x))
        return scale * profile * wave, scale * k * (n_z * slope * wave + n_x * profile * rise)

    def potentials(self, k: float, velocities: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return sources and potentials of rings; see `PanelProblem.potentials`."""
        rings = self.body if np.isinf(k) else self._with_lid
        right = np.zeros((1, rings.part.nb_faces, len(velocities)), dtype=complex)
        right[0, rings.of_body] = velocities.T
        sources, potentials = rings.solve(k, right)
        return sources[0].T, potentials[0, rings.of_body].T

    def solve(self, omegas: list[float]) -> xr.Dataset:
        """Return added mass, damping, Froude-Krylov and diffraction force at finite frequencies [rad/s]."""
        columns = []
        for omega in omegas:
            incident = (each[None] for each in self.incident(omega))
            columns.append(self.coefficients(omega, wavenumber(omega, self.depth, self.gravity), *incident)[:4])
        return solved_dataset(omegas, [each.label for each in self.displacements], columns)


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
        fine, coarse = self.fine.added_mass_inf(), self.coarse.added_mass_inf()
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
            return joined_frequencies(*map(at, omegas))

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
