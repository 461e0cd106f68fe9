"""Radiation and diffraction by an axisymmetric shell: capytaine's Green functions, summed over rings of panels.

The only module that imports capytaine. For axisymmetric motions the unknowns are rings, not panels: the influence of a
ring is the sum over its panels, so an N-row mesh of any azimuthal fineness costs one N x N system per frequency. The
matrices are capytaine's; summed with its diagonal they reproduce capytaine's full solution to round-off. The
same holds for every azimuthal order m, where strengths go with cos(m theta): surge and pitch have m = 1.
"""

import os
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import IO, Any

import numpy as np
import xarray as xr
from scipy.special import j0, j1

from vsb.engine.hydro.database import solved_dataset
from vsb.engine.hydro.dofs import Displacement, azimuthal_order, normal_velocities, wave_around
from vsb.engine.hydro.panel_solver import panel_solver
from vsb.engine.hydro.sweep import IncidentWave
from vsb.engine.waves.water import wavenumber
from vsb.errors import ConfigError, DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray
from vsb.tools.files import CHANGED, atomic_write
from vsb.tools.stamps import MANIFEST, read_manifest, record, text_fault

try:
    import capytaine as cpt
except OSError:  # it makes a folder for tables in the home folder, which may not be writable and is not used
    os.environ["CAPYTAINE_CACHE_DIR"] = str(Path(tempfile.gettempdir(), f"capytaine-{os.getuid()}"))
    import capytaine as cpt
from capytaine.tools.cache_on_disk import cache_directory

cpt.set_logging("ERROR")
_LARGEST_DEPTH_IN_WAVENUMBERS = 9e4  # the finite-depth Green function has no infinite frequency


def green_function(folder: str | Path) -> cpt.Delhommeau:
    """Return capytaine's Green function; its table (16 s to compute) is read from or written to `folder`.

    A manifest in the folder holds the table's checksum; a readable table without an entry is added to it. Raises
    `DatabaseError` if the table has changed since it was written.

    In finite depth the older Prony decomposition is used: at kd = 50, without influence of the bottom, it gives the
    damping of deep water to 0.3 %, while capytaine 3.0's default is 15 % off and makes heave damping negative.
    """
    place, manifest = Path(folder), Path(folder, MANIFEST)
    place.mkdir(parents=True, exist_ok=True)
    known = {path: text_fault(path, panel_solver(), read_manifest(manifest)) for path in place.glob("*.npz")}
    wrong = [f"{path}: {fault.reason}" for path, fault in known.items() if fault and fault.kind != "nameless"]
    try:
        if not wrong:
            green = cpt.Delhommeau(tabulation_cache_dir=str(place), finite_depth_prony_decomposition_method="fortran")
    except (zipfile.BadZipFile, zlib.error):
        wrong = [f"{place}: {CHANGED}"]
    if wrong:
        raise DatabaseError(f"{wrong[0]}; delete the folder {place} and run again")
    if not known or any(known.values()):
        record(manifest, panel_solver(), place.glob("*.npz"))
    return green


def stored_green_function(folder: str | Path) -> cpt.Delhommeau:
    """Return `green_function`, its table copied from where capytaine keeps its own on this machine, or computed once.

    It is made in a temporary folder that is renamed, safe for concurrent runs.
    """
    place = Path(folder)
    if not place.is_dir():
        place.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place.parent, prefix=f".{place.name}.") as name:
            partial, tables = Path(name), _kept_tables()
            _copied(tables.glob("tabulation_*.npz"), partial)
            try:
                green_function(partial)
            except DatabaseError:  # one kept there is damaged
                for file in partial.iterdir():
                    file.unlink()
                green_function(partial)
            _copied(partial.glob("*.npz"), tables)
            partial.chmod(0o755)
            try:
                partial.replace(place)
            except OSError:
                if not place.is_dir():  # otherwise a concurrent run has finished first
                    raise
    return green_function(place)


def is_table_kept() -> bool:
    """Whether this machine keeps a table of the Green function, so that none is computed."""
    return any(_kept_tables().glob("tabulation_*.npz"))


def _kept_tables() -> Path:
    """Folder in which capytaine keeps tables of its Green function, for all that use it on this machine."""
    try:
        return Path(cache_directory())
    except OSError:  # which cannot be made
        return Path(tempfile.gettempdir(), f"capytaine-{os.getuid()}", cpt.__version__)


def _copied(files: Iterable[Path], folder: Path) -> None:
    """Copy files into a folder, each whole or not at all, as far as it can be written; those there stay."""
    for file in files:
        with suppress(OSError):
            if not (folder / file.name).exists():
                with atomic_write(folder / file.name) as temporary:
                    shutil.copyfile(file, temporary)


@cache
def quick_green_function() -> cpt.Delhommeau:
    """Return capytaine's Green function with a table of a quarter of the points, computed in 2 s and not stored.

    Coefficients of the cross-check's meshes then change by 2e-4 of their largest entry, a tenth of the panels' error.
    """
    return cpt.Delhommeau(
        tabulation_nr=338,
        tabulation_nz=186,
        tabulation_nb_integration_points=251,
        tabulation_cache_dir=None,
        finite_depth_prony_decomposition_method="fortran",
    )


@dataclass(frozen=True)
class RingMesh:
    """One wedge of panels, body rows before lid rows, and the half circle of copies whose sum is a ring."""

    wedge: cpt.Mesh
    copies: cpt.Mesh
    weights: FloatArray  # 2 for copies with a mirror image, else 1
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

    def harmonic(self, order: int) -> FloatArray:
        """Return the weights of the copies in a ring whose strengths go with cos(order theta), shape (copy,).

        The matrix of all panels is block-circulant: orders below half the number of panels around do not mix.
        """
        if not 0 <= 2 * order < self.azimuth:
            raise ConfigError(
                f"order: received {order} on {self.azimuth} panels around; needs 0 <= order < azimuth/2: refine mesh"
            )
        return np.asarray(self.weights * np.cos(2 * np.pi * order / self.azimuth * np.arange(len(self.weights))))


def _wedge(x: FloatArray, z: FloatArray, azimuth: int) -> cpt.Mesh:
    """One wedge of panels between the meridian points (x, z), normals to the right of the way along the meridian."""
    angle = np.pi / azimuth
    left, right = (np.column_stack([x * np.cos(a), x * np.sin(a), z]) for a in (-angle, angle))
    i = np.arange(len(x) - 1)
    faces = np.stack([i, i + len(x), i + len(x) + 1, i + 1], axis=1)
    return _mesh(np.concatenate([left, right]), faces)


def _mesh(vertices: FloatArray, faces: IntArray) -> cpt.Mesh:
    """Panels as a mesh of capytaine, nothing cleaned; its geometry by arrays, for capytaine loops over panels."""
    mesh = cpt.Mesh(vertices=vertices, faces=faces, auto_clean=False, auto_check=False)
    a, b, c, d = vertices[faces].swapaxes(0, 1)  # of a triangle c = d
    halves = [np.linalg.norm(np.cross(u, c - a), axis=1) / 2 for u in (b - a, d - a)]
    weighed = halves[0][:, None] * (a + b + c) / 3 + halves[1][:, None] * (a + c + d) / 3
    normals = np.cross(c - a, d - b)
    mesh.faces_areas = halves[0] + halves[1]
    mesh.faces_centers = weighed / mesh.faces_areas[:, None]
    mesh.faces_normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    mesh.faces_radiuses = np.linalg.norm(a - mesh.faces_centers, axis=1)
    return mesh


def ring_mesh(mesh: xr.Dataset, with_lid: bool = True) -> RingMesh:
    """Return the rings of a mean mesh (see `vsb.engine.hydro.panels.mesh.mean_mesh`)."""
    azimuth = int(mesh.attrs["azimuth"])
    body = _wedge(mesh.meridian_radius.values[::-1], mesh.meridian_height.values[::-1], azimuth)
    rows = body.nb_faces
    parts = [body]
    if with_lid and mesh.sizes["lid_node"] > 1:
        lid = mesh.lid_radius.values  # from the axis outwards, so that normals point down: with upward normals the
        parts.append(_wedge(lid, np.zeros(len(lid)), azimuth))  # lid resonates by itself (hemisphere: at Ka = 1.27)
    wedge = joined(parts)
    copies = [wedge.rotated_z(2 * np.pi * i / azimuth) for i in range(azimuth // 2 + 1)]
    weights = np.full(len(copies), 2.0)
    weights[0] = 1.0
    if azimuth % 2 == 0:
        weights[-1] = 1.0
    return RingMesh(wedge, joined(copies), weights, rows, azimuth)


def joined(meshes: list[cpt.Mesh]) -> cpt.Mesh:
    """Return one mesh of several, panel for panel (capytaine's own join may drop or reorder panels)."""
    offsets = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + offset for m, offset in zip(meshes, offsets, strict=False)]
    return _mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces))


def ring_matrices(
    green: cpt.Delhommeau, rings: RingMesh, k: float, depth: float = np.inf, order: int = 0
) -> tuple[ComplexArray, ComplexArray]:
    """Return the influence matrices S and D of rings on rings, shape (row, row); see `RingMesh.harmonic` for errors.

    S sigma is the potential and D sigma the normal velocity at theta = 0 of sources sigma cos(order theta), capytaine's
    sign and diagonal (I/2).
    """
    weights = rings.harmonic(order)
    s, d = green.evaluate(rings.wedge, rings.copies, wavenumber=k, water_depth=depth, adjoint_double_layer=True)
    summed = [m.reshape(rings.rows, len(weights), rings.rows).transpose(0, 2, 1) @ weights for m in (s, d)]
    return summed[0], summed[1]


def flux_correction(green: cpt.Delhommeau, rings: RingMesh) -> FloatArray:
    """Return the correction of the diagonal of D for the flatness of a body's panels, without lid, shape (row,).

    A flat panel induces no normal velocity on itself; a piece of the curved surface does, by an amount proportional to
    its size, which makes plain panel methods first order. Gauss' theorem says how much: through the closed surface made
    of body and mirror image, the flux of any source on it is half its strength, so sum_i a_i D_ij = a_j for
    G = -(1/r + 1/r')/(4 pi). Setting the diagonal to satisfy it takes away nearly all of the first-order
    error: 40 rows on the hemisphere go from 1.2 % to 0.05 % error in added mass (Ka = 1, modes P_0..P_6), at second
    order down to 0.05 %. The error of neighbouring panels remains, a thirtieth of the first-order error. The
    correction is local, so it serves every azimuthal order: surge of 40 rows at infinite frequency goes from 1.9 %
    to 0.03 %, P_4^3 from 1.9 % to 0.2 %.
    """
    _, d = ring_matrices(green, rings, 0.0)
    return np.asarray(1.0 - (rings.areas @ d.real) / rings.areas)


@dataclass(frozen=True)
class AxisymmetricProblem:
    """Radiation and diffraction of prescribed displacements of the immersed shell, all of one azimuthal order m.

    On the sphere itself the meridional ones move no water.
    """

    green: cpt.Delhommeau
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

    @cached_property
    def body(self) -> RingMesh:
        """The shell's rings, without lid."""
        return ring_mesh(self.mesh, with_lid=False)

    @property
    def normals(self) -> tuple[FloatArray, FloatArray]:
        """Unit normals on the body rows, keel first: radial and vertical component, each shape (row,).

        The shell's own for m = 0; the panels' for m > 0: rigid motions and wave are capytaine's to round-off.
        """
        if self.order:
            return self.body.wedge.faces_normals[:, 0], self.body.wedge.faces_normals[:, 2]
        return self.mesh.normal_radius.values[::-1], self.mesh.normal_height.values[::-1]

    @property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements at theta = 0, shape (displacement, row) [m/s per m/s]."""
        colatitude = self.mesh.row_colatitude.values[::-1]
        return normal_velocities(self.displacements, colatitude, self.body.centres, np.array(self.normals))

    @property
    def onto(self) -> FloatArray:
        """Generalized force of a unit potential, -rho w_i dS, shape (displacement, row); cos^2 halves a ring's."""
        return -self.density * self.velocities * self.body.areas / (2 if self.order else 1)

    @cached_property
    def correction(self) -> FloatArray:
        """Correction of the diagonal of D on the body's rings, shape (row,); see `flux_correction`."""
        return flux_correction(self.green, self.body)

    @cached_property
    def _with_lid(self) -> RingMesh:
        """All rings."""
        return ring_mesh(self.mesh)

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
            return np.array([[1j * w * (self.onto @ self.incident(self.body, w)[0])] for w in omega])

        return IncidentWave(phase, froude_krylov, self.order)

    def incident(self, rings: RingMesh, omega: float) -> tuple[ComplexArray, ComplexArray]:
        """Part of azimuthal order m of the incident wave's potential and normal velocity, each shape (row,).

        phi_0 = -i g/omega cosh k(z+d)/cosh kd exp(ikx). The azimuthal mean of exp(ikx) is J_0(kR), free of the aliasing
        of few panels. For m > 0, 2 i^m J_m(kR) is replaced by the sum over panels: with it and the panels' own normals
        the result is capytaine's.
        """
        k = wavenumber(omega, self.depth, self.gravity)
        x, z = rings.centres
        n_x, _, n_z = rings.wedge.faces_normals[: rings.body_rows].T
        mirror = np.exp(-2 * k * (z + self.depth)) if np.isfinite(self.depth) else np.zeros_like(z)
        floor = 1 + (np.exp(-2 * k * self.depth) if np.isfinite(self.depth) else 0.0)
        profile, slope = np.exp(k * z) * (1 + mirror) / floor, np.exp(k * z) * (1 - mirror) / floor
        scale = -1j * self.gravity / omega
        wave, rise = (j0(k * x), -j1(k * x)) if not self.order else wave_around(self.order, rings.azimuth, k * x)
        return scale * profile * wave, scale * k * (n_z * slope * wave + n_x * profile * rise)

    def at_infinity(self) -> FloatArray:
        """Added mass at infinite frequency, shape (degree, degree) [kg]; the potential vanishes at z = 0: no lid."""
        k = np.inf if np.isinf(self.depth) else _LARGEST_DEPTH_IN_WAVENUMBERS / self.depth
        s, d = ring_matrices(self.green, self.body, k, self.depth, self.order)
        return np.real(self.onto @ (s @ np.linalg.solve(d + np.diag(self.correction), self.velocities.T)))

    def solve(self, omegas: list[float]) -> xr.Dataset:
        """Solve radiation and diffraction at finite frequencies [rad/s].

        Returns
        -------
        xarray.Dataset
            added_mass, radiation_damping, Froude_Krylov_force, diffraction_force over the displacements.
        """
        return solved_dataset(omegas, self.displacements, [self._at(omega) for omega in omegas])

    def _at(self, omega: float) -> tuple[FloatArray, FloatArray, ComplexArray, ComplexArray]:
        """Added mass, damping, Froude-Krylov and diffraction force at one frequency.

        Phasors exp(-i omega t) (C1): pressure i omega rho phi, so A + iB/omega = -rho int phi_j w_i dS.
        """
        rings, k = self._with_lid, wavenumber(omega, self.depth, self.gravity)
        s, d = ring_matrices(self.green, rings, k, self.depth, self.order)
        correction = np.pad(self.correction, (0, rings.rows - rings.body_rows))  # the lid is flat
        incident, incident_velocity = self.incident(rings, omega)
        w, onto = self.velocities, self.onto
        velocity = np.zeros((rings.rows, len(w) + 1), dtype=complex)
        velocity[: rings.body_rows] = np.column_stack([w.T, -incident_velocity])
        potential = (s @ np.linalg.solve(d + np.diag(correction), velocity))[: rings.body_rows]
        radiated, scattered = onto @ potential[:, :-1], onto @ potential[:, -1]
        return radiated.real, omega * radiated.imag, 1j * omega * (onto @ incident), 1j * omega * scattered


def read_panels(path: str | Path | IO[str], form: str) -> tuple[FloatArray, IntArray]:
    """Return vertices and panels of a file of WAMIT, NEMOH, Hydrostar or HAMS, mirrored where the file says so.

    `form` is gdf, mar, hst or pnl, whatever the name of the file.
    """
    mesh = cpt.load_mesh(path, form).merged()
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def box_panels(size: tuple[float, float, float], counts: tuple[int, int, int]) -> tuple[FloatArray, IntArray]:
    """Return vertices and panels of a box around the origin, normals outward; sides [m] and panels along x, y, z."""
    mesh = cpt.mesh_parallelepiped(size=size, resolution=counts)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def immersed_panels(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Return vertices and panels of the part of a mesh below z = 0, and the panel each of them is a piece of."""
    corners = [face[: 3 if face[2] == face[3] else 4] for face in faces.tolist()]
    number = {"parent": np.arange(len(corners))}
    mesh = cpt.Mesh(vertices, corners, faces_metadata=number, auto_clean=False, auto_check=False).immersed_part()
    return np.array(mesh.vertices), np.asarray(mesh.faces), np.asarray(mesh.faces_metadata["parent"])


def panel_mesh(vertices: FloatArray, faces: IntArray) -> Any:
    """Return panels as a mesh of capytaine; nothing is cleaned or reordered."""
    return _mesh(vertices, faces)


def influence(green: cpt.Delhommeau, mesh: Any, kept: Any, k: float, depth: float) -> tuple[ComplexArray, ComplexArray]:
    """Return the influence of panels on those of a mesh of which they are the first, S and D, (panel, panel kept).

    Sign and diagonal as of `ring_matrices`. k = 0 and infinite k are walls and no walls.
    """
    if np.isinf(k) and np.isfinite(depth):
        k = _LARGEST_DEPTH_IN_WAVENUMBERS / depth
    water = {"free_surface": 0.0, "water_depth": depth if k else np.inf, "wavenumber": k}
    s, d = green.evaluate(mesh, kept, adjoint_double_layer=True, **water)
    return s, d
