"""Radiation and diffraction by an axisymmetric shell: capytaine's Green functions, summed over rings of panels.

The only module that imports capytaine. For axisymmetric motions the unknowns are rings, not panels: the influence of a
ring is the sum over its panels, so an N-row mesh of any azimuthal fineness costs one N x N system per frequency. The
matrices are capytaine's own; summed with its own diagonal they reproduce capytaine's full solution to round-off.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import capytaine as cpt
import numpy as np
import xarray as xr
from scipy.special import j0, j1

from vsb.modes import normal_velocities
from vsb.units import ComplexArray, FloatArray
from vsb.waves import wavenumber

cpt.set_logging("ERROR")
_LARGEST_DEPTH_IN_WAVENUMBERS = 9e4  # the finite-depth Green function has no infinite frequency


def green_function(folder: str | Path) -> cpt.Delhommeau:
    """Return capytaine's Green function; its table (16 s to compute) is read from or written to `folder`.

    Notes
    -----
    In finite depth the older Prony decomposition is taken: at kd = 50, where the bottom is not felt, it gives the
    damping of deep water to 0.3 %, capytaine 3.0's default one is 15 % off and turns heave damping negative.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    return cpt.Delhommeau(tabulation_cache_dir=str(folder), finite_depth_prony_decomposition_method="fortran")


@dataclass(frozen=True)
class RingMesh:
    """One wedge of panels, body rows first, lid rows after, and the half circle of copies whose sum is a ring."""

    wedge: cpt.Mesh
    copies: cpt.Mesh
    weights: FloatArray  # how often each copy counts: its mirror image acts alike
    body_rows: int
    azimuth: int

    @property
    def rows(self) -> int:
        """Number of rings, lid included."""
        return int(self.wedge.nb_faces)

    @property
    def centres(self) -> FloatArray:
        """Radius and height of the body rows' centres, shape (2, row) [m]."""
        centre = self.wedge.faces_centers[: self.body_rows]
        return np.array([np.hypot(centre[:, 0], centre[:, 1]), centre[:, 2]])

    @property
    def areas(self) -> FloatArray:
        """Area of the body's rings, shape (row,) [m^2]."""
        return self.azimuth * np.asarray(self.wedge.faces_areas[: self.body_rows])


def _wedge(x: FloatArray, z: FloatArray, azimuth: int) -> cpt.Mesh:
    """One wedge of panels between the meridian points (x, z), normals to the right of the way along the meridian."""
    angle = np.pi / azimuth
    left, right = (np.column_stack([x * np.cos(a), x * np.sin(a), z]) for a in (-angle, angle))
    i = np.arange(len(x) - 1)
    faces = np.stack([i, i + len(x), i + len(x) + 1, i + 1], axis=1)
    return cpt.Mesh(vertices=np.concatenate([left, right]), faces=faces, auto_clean=False)


def ring_mesh(mesh: xr.Dataset, with_lid: bool = True) -> RingMesh:
    """Return the rings of a mean mesh (see `vsb.meshing.mean_mesh`)."""
    azimuth = int(mesh.attrs["azimuth"])
    body = _wedge(mesh.meridian_radius.values[::-1], mesh.meridian_height.values[::-1], azimuth)
    rows = body.nb_faces
    parts = [body]
    if with_lid:
        lid = mesh.lid_radius.values  # from the axis outwards, so that normals point down: with upward normals the
        parts.append(_wedge(lid, np.zeros(len(lid)), azimuth))  # lid resonates by itself (hemisphere: at Ka = 1.27)
    wedge = _joined(parts)
    copies = [wedge.rotated_z(2 * np.pi * i / azimuth) for i in range(azimuth // 2 + 1)]
    weights = np.full(len(copies), 2.0)
    weights[0] = 1.0
    if azimuth % 2 == 0:
        weights[-1] = 1.0
    return RingMesh(wedge, _joined(copies), weights, rows, azimuth)


def _joined(meshes: list[cpt.Mesh]) -> cpt.Mesh:
    """Join meshes, panel for panel (capytaine's own join may drop or reorder panels)."""
    offsets = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return cpt.Mesh(
        vertices=np.concatenate([m.vertices for m in meshes]),
        faces=np.concatenate([m.faces + offset for m, offset in zip(meshes, offsets, strict=False)]),
        auto_clean=False,
    )


def ring_matrices(
    green: cpt.Delhommeau, rings: RingMesh, k: float, depth: float = np.inf
) -> tuple[ComplexArray, ComplexArray]:
    """Return the influence matrices S and D of rings on rings, shape (row, row).

    S sigma is the potential and D sigma the normal velocity of sources sigma, capytaine's sign and diagonal (I/2).
    """
    s, d = green.evaluate(rings.wedge, rings.copies, wavenumber=k, water_depth=depth, adjoint_double_layer=True)
    summed = [m.reshape(rings.rows, len(rings.weights), rings.rows).transpose(0, 2, 1) @ rings.weights for m in (s, d)]
    return summed[0], summed[1]


def flux_correction(green: cpt.Delhommeau, rings: RingMesh) -> FloatArray:
    """Return what the diagonal of D lacks because panels are flat, shape (row,); zero on the lid.

    Notes
    -----
    A flat panel induces no normal velocity on itself; a piece of the curved surface does, by an amount proportional to
    its size, which makes plain panel methods first order. Gauss' theorem says how much: through the closed surface made
    of body and mirror image, the flux of any source on it is half its strength, so sum_i a_i D_ij = a_j for
    G = -(1/r + 1/r')/(4 pi). Setting the diagonal to satisfy it takes away nearly all of the first-order
    error: 40 rows on the hemisphere go from 1.2 % to 0.05 % error in added mass (Ka = 1, modes P_0..P_6), at second
    order down to 0.05 %. What neighbouring panels miss of each other stays, a thirtieth of the first-order error.
    """
    _, d = ring_matrices(green, rings, 0.0)
    body = slice(0, rings.body_rows)
    area = rings.areas
    correction = np.zeros(rings.rows)
    correction[body] = 1.0 - (area @ d[body, body].real) / area
    return correction


@dataclass(frozen=True)
class AxisymmetricProblem:
    """Radiation and diffraction of prescribed displacements of the immersed shell.

    Radial<n> is P_n(cos phi) along e_r, Meridional<n> is dP_n/dphi along e_phi, phi the colatitude on the undeformed
    sphere. On the sphere itself the meridional ones move no water.
    """

    green: cpt.Delhommeau
    mesh: xr.Dataset
    displacements: tuple[str, ...]
    density: float
    depth: float
    gravity: float

    @property
    def normals(self) -> tuple[FloatArray, FloatArray]:
        """Unit normals of the shell on the body rows, keel first: radial and vertical component, each shape (row,)."""
        return self.mesh.normal_radius.values[::-1], self.mesh.normal_height.values[::-1]

    @property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements, shape (displacement, row) [m/s per m/s]."""
        return normal_velocities(self.displacements, self.mesh.row_colatitude.values[::-1], self.normals)

    def incident(self, rings: RingMesh, omega: float) -> tuple[ComplexArray, ComplexArray]:
        """Axisymmetric part of the incident wave's potential and normal velocity, each shape (row,).

        The azimuthal mean of exp(ikx) is J_0(kR): phi_0 = -i g/omega cosh k(z+d)/cosh kd J_0(kR).
        """
        k = wavenumber(omega, self.depth, self.gravity)
        x, z = rings.centres
        n_x, n_z = self.normals
        mirror = np.exp(-2 * k * (z + self.depth)) if np.isfinite(self.depth) else np.zeros_like(z)
        floor = 1 + (np.exp(-2 * k * self.depth) if np.isfinite(self.depth) else 0.0)
        profile, slope = np.exp(k * z) * (1 + mirror) / floor, np.exp(k * z) * (1 - mirror) / floor
        scale = -1j * self.gravity / omega
        return scale * profile * j0(k * x), scale * k * (n_z * slope * j0(k * x) - n_x * profile * j1(k * x))

    def at_infinity(self) -> FloatArray:
        """Added mass at infinite frequency, shape (degree, degree) [kg]; the potential vanishes at z = 0: no lid."""
        rings = ring_mesh(self.mesh, with_lid=False)
        correction = flux_correction(self.green, rings)
        k = np.inf if np.isinf(self.depth) else _LARGEST_DEPTH_IN_WAVENUMBERS / self.depth
        s, d = ring_matrices(self.green, rings, k, self.depth)
        w = self.velocities
        potential = s @ np.linalg.solve(d + np.diag(correction), w.T)
        return -self.density * np.real((w * rings.areas) @ potential)

    def solve(self, omegas: list[float]) -> xr.Dataset:
        """Solve radiation and diffraction at finite frequencies; see `blocks` for what is returned."""
        rings = ring_mesh(self.mesh)
        correction = flux_correction(self.green, rings)
        w = self.velocities
        columns = [self._at(rings, correction, w, omega) for omega in omegas]
        added_mass, damping, froude_krylov, diffraction = (np.array(c) for c in zip(*columns, strict=True))
        labels = list(self.displacements)
        pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
        return xr.Dataset(
            {
                "added_mass": (pair, added_mass),
                "radiation_damping": (pair, damping),
                "Froude_Krylov_force": (wave, froude_krylov[:, None]),
                "diffraction_force": (wave, diffraction[:, None]),
            },
            coords={"omega": omegas, "wave_direction": [0.0], "influenced_dof": labels, "radiating_dof": labels},
        )

    def _at(
        self, rings: RingMesh, correction: FloatArray, w: FloatArray, omega: float
    ) -> tuple[FloatArray, FloatArray, ComplexArray, ComplexArray]:
        """Added mass, damping, Froude-Krylov and diffraction force at one frequency.

        Phasors exp(-i omega t) (C1): pressure i omega rho phi, so A + iB/omega = -rho int phi_j w_i dS.
        """
        s, d = ring_matrices(self.green, rings, wavenumber(omega, self.depth, self.gravity), self.depth)
        incident, incident_velocity = self.incident(rings, omega)
        velocity = np.zeros((rings.rows, len(w) + 1), dtype=complex)
        velocity[: rings.body_rows] = np.column_stack([w.T, -incident_velocity])
        potential = (s @ np.linalg.solve(d + np.diag(correction), velocity))[: rings.body_rows]
        onto = -self.density * w * rings.areas
        radiated, scattered = onto @ potential[:, :-1], onto @ potential[:, -1]
        return radiated.real, omega * radiated.imag, 1j * omega * (onto @ incident), 1j * omega * scattered


def solve_block(spec: dict[str, Any], mesh: xr.Dataset, green_folder: str | Path) -> xr.Dataset:
    """Solve one block of frequencies (`vsb.specs`).

    Returns
    -------
    xarray.Dataset
        added_mass, radiation_damping, Froude_Krylov_force, diffraction_force over the displacements Radial<n> and
        Meridional<n>; for the block of infinite frequency added_mass_inf alone.
    """
    water = spec["water"]
    problem = AxisymmetricProblem(
        green_function(green_folder),
        mesh,
        tuple(spec["displacements"]),
        water["density"],
        float(water["depth"]),
        water["gravity"],
    )
    if spec["omega"] == ["inf"]:
        labels = list(problem.displacements)
        return xr.Dataset(
            {"added_mass_inf": (("influenced_dof", "radiating_dof"), problem.at_infinity())},
            coords={"influenced_dof": labels, "radiating_dof": labels},
        )
    return problem.solve(spec["omega"])
