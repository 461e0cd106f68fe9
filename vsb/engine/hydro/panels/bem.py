"""Capytaine's Green function, panels and influence matrices; sources on panels of any symmetry. Imports capytaine.

Panels are images of some of them: mirrored in planes, or turned around an axis. In terms of the characters of such a
group, sums and differences of images or cos(m theta), every symmetry of the flow has a system of its own, with the
unknowns of one image. The matrices are capytaine's; with its diagonal they reproduce its full solution to round-off.
"""

import os
import shutil
import tempfile
import zipfile
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from vsb.engine.hydro.panels import panel_solver
from vsb.errors import DatabaseError
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vsb.tools.files import CHANGED, atomic_write, unwritable
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

    It is made in a temporary folder that is renamed, safe for concurrent runs. A process reads it once, as long as the
    folder holds the same files. Raises `DatabaseError` if it cannot be written.
    """
    place = Path(folder).absolute()
    if not place.is_dir():
        try:
            _make(place)
        except OSError as error:
            raise unwritable(place, error) from None
    return _read_once(place, tuple((file, os.stat(file).st_mtime_ns) for file in sorted(place.iterdir())))


def _make(place: Path) -> None:
    """Make the folder of the table, whole or not at all."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place.parent, prefix=f".{place.name}.") as name:
        partial = Path(name)
        _by_kept_tables(green_function, partial, _kept_tables())
        partial.chmod(0o755)
        try:
            partial.replace(place)
        except OSError:
            if not place.is_dir():  # otherwise a concurrent run has finished first
                raise


@lru_cache(maxsize=1)
def _read_once(place: Path, files: tuple[tuple[Path, int], ...]) -> cpt.Delhommeau:
    """The Green function of a folder, for as long as it holds these files, by path and time."""
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


def _by_kept_tables(make: Callable[[Path], cpt.Delhommeau], folder: Path, tables: Path) -> cpt.Delhommeau:
    """Return what `make` makes of a folder with a copy of the tables this machine keeps, and keep what it computed."""
    _copied(tables.glob("tabulation_*.npz"), folder)
    try:
        green = make(folder)
    except (DatabaseError, zipfile.BadZipFile, zlib.error):  # one kept there is damaged
        for file in folder.iterdir():
            file.unlink()
        green = make(folder)
    _copied(folder.glob("*.npz"), tables)
    return green


def _copied(files: Iterable[Path], folder: Path) -> None:
    """Copy files into a folder, each whole or not at all, as far as it can be written; those there stay."""
    for file in files:
        with suppress(OSError, DatabaseError):
            if not (folder / file.name).exists():
                with atomic_write(folder / file.name) as temporary:
                    shutil.copyfile(file, temporary)


@cache
def quick_green_function() -> cpt.Delhommeau:
    """Return capytaine's Green function with a table of a quarter of the points, computed in 2 s once per machine.

    Coefficients of the cross-check's meshes then change by 2e-4 of their largest entry, a tenth of the panels' error.
    """

    def of_quarter(folder: Path) -> cpt.Delhommeau:
        return cpt.Delhommeau(
            tabulation_nr=338,
            tabulation_nz=186,
            tabulation_nb_integration_points=251,
            tabulation_cache_dir=str(folder),
            finite_depth_prony_decomposition_method="fortran",
        )

    with tempfile.TemporaryDirectory(prefix="vsb-") as name:
        return _by_kept_tables(of_quarter, Path(name), _kept_tables() / "quick")


def panel_mesh(vertices: FloatArray, faces: IntArray) -> cpt.Mesh:
    """Return panels as a mesh of capytaine, nothing cleaned; geometry by arrays, for capytaine loops over panels."""
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


def joined(meshes: list[cpt.Mesh]) -> cpt.Mesh:
    """Return one mesh of several, panel for panel (capytaine's own join may drop or reorder panels)."""
    offsets = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + offset for m, offset in zip(meshes, offsets, strict=False)]
    return panel_mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces))


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


@dataclass(frozen=True)
class SymmetricPanels:
    """Panels of a body, then of a lid, that are images of a part of them."""

    green: cpt.Delhommeau
    part: cpt.Mesh
    images: cpt.Mesh  # image after image, the part itself first
    weights: FloatArray  # how often each image is there (image,)
    characters: FloatArray  # of the flows to be solved, weights included (character, image)
    of_body: BoolArray  # which panels of the part are the body's, not the lid's (panel,)
    depth: float  # [m]
    through_bed: FloatArray | float = 0.0  # share of flux through the bed below the body (panel,)

    def influence(self, k: float) -> tuple[ComplexArray, ComplexArray]:
        """Return potential S and normal velocity D on every image by sources of the part, (image, panel, panel).

        Capytaine's sign and diagonal (I/2). k = 0 and infinite k are walls and no walls.
        """
        if np.isinf(k) and np.isfinite(self.depth):
            k = _LARGEST_DEPTH_IN_WAVENUMBERS / self.depth
        water = {"free_surface": 0.0, "water_depth": self.depth if k else np.inf, "wavenumber": k}
        s, d = self.green.evaluate(self.images, self.part, adjoint_double_layer=True, **water)
        shape = len(self.weights), self.part.nb_faces, self.part.nb_faces
        return s.reshape(shape), d.reshape(shape)

    @cached_property
    def correction(self) -> FloatArray:
        """Correction of the diagonal of D for the flatness of a body's panels, shape (panel,); zero on the lid.

        A flat panel induces no normal velocity on itself; a piece of the curved surface does, by an amount proportional
        to its size, which makes plain panel methods first order. Gauss' theorem says how much: through the closed
        surface made of body and mirror image, the flux of any source on it is half its strength, so
        sum_i a_i D_ij = a_j for G = -(1/r + 1/r')/(4 pi). Setting the diagonal to satisfy it takes away nearly all of
        the first-order error: 40 rows on the hemisphere go from 1.2 % to 0.05 % error in added mass (Ka = 1, modes
        P_0..P_6), at second order down to 0.05 %. The error of neighbouring panels remains, a thirtieth of the
        first-order error. The correction is local, so it serves every symmetry: surge of 40 rows at infinite frequency
        goes from 1.9 % to 0.03 %, P_4^3 from 1.9 % to 0.2 %. A hull that stands on the sea bed is closed by the bed
        below it, through which some of the flux passes.
        """
        areas = self.part.faces_areas
        flux = np.where(self.of_body, areas, 0.0) @ np.tensordot(self.weights, self.influence(0.0)[1].real, axes=1)
        return np.where(self.of_body, 1.0 - self.through_bed - flux / areas, 0.0)

    def solve(self, k: float, velocities: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the sources that make normal velocities, and their potentials, each (character, panel, column)."""
        s, d = (np.tensordot(self.characters, m, axes=1) for m in self.influence(k))
        sources = np.linalg.solve(d + np.diag(self.correction), velocities)
        return sources, s @ sources


class Solved(NamedTuple):
    """Coefficients of displacements at one frequency in waves of some directions."""

    added_mass: FloatArray  # (dof, dof) [kg]
    damping: FloatArray  # (dof, dof) [N s/m]
    froude_krylov: ComplexArray  # (direction, dof) [N/m]
    diffraction: ComplexArray  # (direction, dof) [N/m]
    sources: ComplexArray  # of the radiated waves (dof, panel), lid included


class PanelProblem(ABC):
    """Radiation and diffraction by sources on panels: what bodies of revolution and all others have in common."""

    @property
    @abstractmethod
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements on the body's panels, shape (dof, panel) [m/s per m/s]."""

    @property
    @abstractmethod
    def onto(self) -> FloatArray:
        """Generalized force of a unit potential on them, -rho w_i dS, shape (dof, panel)."""

    @abstractmethod
    def potentials(self, k: float, velocities: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the sources on all panels that make velocities of the body's, and the potentials there, (n, panel).

        Without a lid at infinite k: the potential vanishes at z = 0.
        """

    def added_mass_inf(self) -> FloatArray:
        """Return added mass at infinite frequency, shape (dof, dof) [kg]."""
        return np.real(self.onto @ self.potentials(np.inf, self.velocities + 0j)[1].T)

    def coefficients(self, omega: float, k: float, incident: ComplexArray, velocity: ComplexArray) -> Solved:
        """Return the coefficients at one frequency.

        Phasors exp(-i omega t) (C1): pressure i omega rho phi, so A + iB/omega = -rho int phi_j w_i dS. `incident` and
        `velocity` are potential and normal velocity of the incident waves on the body's panels, (direction, panel).
        """
        count = len(self.velocities)
        sources, potentials = self.potentials(k, np.concatenate([self.velocities, -velocity]))
        forces = potentials @ self.onto.T
        radiated, scattered = forces[:count].T, forces[count:]
        froude_krylov = 1j * omega * (incident @ self.onto.T)
        return Solved(radiated.real, omega * radiated.imag, froude_krylov, 1j * omega * scattered, sources[:count])
