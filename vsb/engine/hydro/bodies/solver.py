"""Radiation and diffraction by a body of any shape with any displacements, on capytaine's panels."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from scipy.linalg import hadamard
from scipy.spatial import cKDTree

from vsb.engine.hydro.bodies.body import PLANES, SYMMETRIES, FlexibleBody, detected_symmetry
from vsb.engine.hydro.bodies.coarsening import coarser_body, coarser_panels
from vsb.engine.hydro.bodies.mesh import joined, solid_angle_share
from vsb.engine.hydro.panels.rings import influence, panel_mesh
from vsb.engine.hydro.variables import PAIR
from vsb.engine.waves.water import Water, haskind_factor, wavenumber
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

_WAVE = ("omega", "wave_direction", "influenced_dof")


def unit_wave(points: FloatArray, k: float, depth: float, directions: FloatArray) -> ComplexArray:
    """Return f = cosh k(z+d)/cosh kd e^{ik(x cos b + y sin b)} [-]: a wave of unit amplitude is -i g/omega f.

    Parameters
    ----------
    points : ndarray, shape (point, xyz) [m]
    k, depth : float [1/m, m]
    directions : ndarray, shape (direction,) [rad]

    Returns
    -------
    ndarray, shape (direction, point)
    """
    z = points[:, 2]
    floor = (1 + np.exp(-2 * k * (z + depth))) / (1 + np.exp(-2 * k * depth))
    ahead = np.column_stack([np.cos(directions), np.sin(directions)])
    return np.asarray(np.exp(k * z + 1j * k * ahead @ points[:, :2].T) * floor)


def unit_wave_slope(
    points: FloatArray, normals: FloatArray, k: float, depth: float, directions: FloatArray
) -> ComplexArray:
    """Return the derivative of `unit_wave` along normals, shape (direction, point) [1/m]."""
    ahead = np.column_stack([np.cos(directions), np.sin(directions)])
    down = np.tanh(k * (points[:, 2] + depth))
    slope = 1j * ahead @ normals[:, :2].T + normals[:, 2] * down
    return np.asarray(k * slope * unit_wave(points, k, depth, directions))


@dataclass(frozen=True)
class SymmetricPanels:
    """Panels of any surface, the body's first, with their planes of symmetry: a half or quarter of the matrices.

    Velocities need no symmetry: they are split into their parts of every parity.
    """

    green: Any  # of `rings.green_function`
    vertices: FloatArray
    faces: IntArray  # (panel, 4)
    of_body: int  # number of the body's panels; the others are the lid
    planes: tuple[str, ...]
    depth: float
    bed_lid: FloatArray  # (triangle, 3, xyz), which closes a hull on the sea bed; none of a floating one

    @cached_property
    def whole(self) -> Any:
        """All panels in their own order, as capytaine's mesh."""
        return panel_mesh(self.vertices, self.faces)

    @cached_property
    def _images(self) -> IntArray:
        """Panels by the half or quarter they lie in, shape (image, panel), each in the column of its images."""
        centres = self.whole.faces_centers
        sides = [centres[:, PLANES[plane]] > 0 for plane in self.planes]
        images = [centres[np.all([np.ones(len(centres)), *sides], axis=0)]]
        for plane in self.planes:
            images += [image * np.where(np.arange(3) == PLANES[plane], -1.0, 1.0) for image in images]
        return np.asarray(cKDTree(centres).query(images)[1])

    @property
    def _kept(self) -> IntArray:
        """Panels of the half or quarter that is mirrored."""
        return np.asarray(self._images[0])

    @cached_property
    def _meshes(self) -> tuple[Any, Any]:
        """All panels image after image, and those kept, as capytaine's meshes."""
        return tuple(panel_mesh(self.vertices, self.faces[some]) for some in (self._images.ravel(), self._kept))

    def _influence(self, k: float) -> tuple[ComplexArray, ComplexArray]:
        """S and D of the panels kept on themselves and on their images, each shape (image, panel, panel)."""
        shape = (*self._images.shape, len(self._kept))
        s, d = influence(self.green, *self._meshes, k, self.depth)
        return s.reshape(shape), d.reshape(shape)

    @cached_property
    def correction(self) -> FloatArray:
        """Correction of the diagonal of D in the half or quarter, as `rings.flux_correction`; zero on the lid.

        A hull that stands on the sea bed is closed by the bed below it, through which some of the flux passes.
        """
        body, areas = self._kept < self.of_body, self.whole.faces_areas[self._kept]
        d = self._influence(0.0)[1]
        under = solid_angle_share(self.bed_lid, self.whole.faces_centers[self._kept])
        return np.where(body, 1.0 - under - np.where(body, areas, 0.0) @ d.sum(axis=0).real / areas, 0.0)

    def potentials(self, k: float, velocities: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return strengths and potentials of the sources that make given normal velocities, each shape (n, panel).

        The characters (+1, -1) of the group of reflections are the rows of Hadamard's matrix: in sums and differences
        of images every parity has a system of its own, of a half or quarter of the unknowns.
        """
        parity = hadamard(len(self._images))
        s, d = (np.tensordot(parity, m, axes=1) for m in self._influence(k))
        right = np.tensordot(parity, velocities[:, self._images], axes=(1, 1)).swapaxes(1, 2)
        sources = np.linalg.solve(d + np.diag(self.correction), right)
        fields = np.tensordot(parity, np.stack([sources, s @ sources], axis=1), axes=1) / len(parity)
        found = np.empty((2, *velocities.shape), dtype=complex)
        found[:, :, self._images] = fields.transpose(1, 3, 0, 2)
        return found[0], found[1]


@dataclass(frozen=True)
class BodyProblem:
    """A body in waves. Its panels have the symmetry given (`body.SYMMETRIES`); displacements and waves need none.

    The lid, vertices and panels with normals down, removes irregular frequencies.
    """

    green: Any  # of `rings.green_function`
    body: FlexibleBody
    water: Water
    symmetry: str = "none"
    lid: tuple[FloatArray, IntArray] | None = None

    def coarser(self) -> tuple["BodyProblem", float]:
        """Return the problem on fewer panels, those of the lid as well, and their share (`coarsening.Coarser`)."""
        planes = SYMMETRIES[detected_symmetry(self.body)]  # also if the solver does not use them
        lid = (self.lid[0], coarser_panels(*self.lid, planes).faces) if self.lid else None
        body, share = coarser_body(self.body, planes)
        return replace(self, body=body, lid=lid), share

    def _surface(self, *parts: tuple[FloatArray, IntArray]) -> SymmetricPanels:
        """The body and further panels."""
        vertices, faces = joined([(self.body.vertices, self.body.faces), *parts])
        planes, own = SYMMETRIES[self.symmetry], len(self.body.faces)
        return SymmetricPanels(self.green, vertices, faces, own, planes, self.water.depth, self.body.bed_lid)

    @cached_property
    def _panels(self) -> SymmetricPanels:
        """Panels of the body, then of the lid."""
        return self._surface(self.lid) if self.lid else self._surface()

    def _onto(self, velocities: FloatArray) -> FloatArray:
        """Generalized force of a unit potential on each panel of the body, -rho w_i dS, shape (dof, panel)."""
        return np.asarray(-self.water.density * velocities * self._panels.whole.faces_areas[: len(self.body.faces)])

    @cached_property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements, shape (dof, panel) [m/s per m/s]."""
        normals = self._panels.whole.faces_normals[: len(self.body.faces)]
        return np.asarray(np.einsum("ipx,px->ip", self.body.modes, normals))

    def at_infinity(self) -> xr.Dataset:
        """Return added_mass_inf [kg], shape (dof, dof); the potential vanishes at z = 0: no lid is needed."""
        _, potentials = self._surface().potentials(np.inf, self.velocities + 0j)
        labels = list(self.body.labels)
        matrix = np.real(self._onto(self.velocities) @ potentials.T)
        return xr.Dataset({"added_mass_inf": (PAIR, matrix)}, coords=dict.fromkeys(PAIR, labels))

    def froude_krylov(self, omegas: FloatArray, directions: FloatArray) -> ComplexArray:
        """Return the force of the undisturbed wave, shape (omega, direction, dof) [N/m]; parameters as of `solve`."""
        water, centres = self.water, self._panels.whole.faces_centers[: len(self.body.faces)]
        k = [wavenumber(float(omega), water.depth, water.gravity) for omega in omegas]
        waves = np.array([unit_wave(centres, each, water.depth, directions) for each in k])
        return np.asarray(water.gravity * waves @ self._onto(self.velocities).T)

    def solve(self, omega: float, directions: FloatArray) -> xr.Dataset:
        """Solve one frequency [rad/s] in waves of given directions [rad].

        Returns
        -------
        xarray.Dataset
            added_mass, radiation_damping, Froude_Krylov_force, diffraction_force, and from the radiated waves
            `haskind_force`, the excitation by Haskind's relation, and `far_field_damping`, by the energy they carry.

        Notes
        -----
        With sources sigma that make the potential phi_j = -int sigma/(4 pi) (1/r + ...), Green's theorem turns
        Haskind's relation into X_j = -rho g sum_k a_k sigma_jk f(x_k), exact for these sources. Energy is
        B_ij = k/(8 pi rho g v_g) int X_i X_j^* d beta, the trapezoidal rule exact to round-off.
        """
        water, panels, n = self.water, self._panels.whole, len(self.body.faces)
        k = wavenumber(omega, water.depth, water.gravity)
        unit = -1j * water.gravity / omega  # potential of a wave over its f
        wave = unit_wave(panels.faces_centers, k, water.depth, directions)
        slope = unit_wave_slope(panels.faces_centers, panels.faces_normals, k, water.depth, directions)
        dofs = len(self.body.labels)
        velocities = np.zeros((dofs + len(directions), len(panels.faces_areas)), dtype=complex)
        velocities[:dofs, :n] = self.velocities
        velocities[dofs:, :n] = -unit * slope[:, :n]
        sources, potentials = self._panels.potentials(k, velocities)
        forces = potentials[:, :n] @ self._onto(self.velocities).T
        strength = -water.density * water.gravity * panels.faces_areas * sources[:dofs]
        excitation = {
            "Froude_Krylov_force": self.froude_krylov(np.array([omega]), directions)[0],
            "diffraction_force": 1j * omega * forces[dofs:],
            "haskind_force": wave @ strength.T,
        }
        matrices = {
            "added_mass": forces[:dofs].real.T,
            "radiation_damping": omega * forces[:dofs].imag.T,
            "far_field_damping": self._far_field_damping(omega, strength),
        }
        labels = list(self.body.labels)
        return xr.Dataset(
            {name: (("omega", *PAIR), matrix[None]) for name, matrix in matrices.items()}
            | {name: (_WAVE, force[None]) for name, force in excitation.items()},
            coords={"omega": [omega], "wave_direction": directions, **dict.fromkeys(PAIR, labels)},
        )

    def _far_field_damping(self, omega: float, strength: ComplexArray) -> FloatArray:
        """Damping by the waves the sources send in all directions, shape (dof, dof) [N s/m]."""
        water = self.water
        k = wavenumber(omega, water.depth, water.gravity)
        count = 32 + 4 * int(np.ceil(k * self.body.size))
        circle = 2 * np.pi * np.arange(count) / count
        x = strength @ unit_wave(self._panels.whole.faces_centers, k, water.depth, circle).T
        (factor,) = haskind_factor(np.array([omega]), water.depth, water.density, water.gravity)
        return np.asarray(factor / count * (x @ x.conj().T).real)
