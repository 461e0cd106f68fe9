"""From a mesh file and a file of displacements to a hydro database with its verdict: any body, any modes.

Every frequency is a file of its own under `blocks/`, named by the content of what it was solved from: it is never
solved twice, and an interrupted run goes on where it stopped.
"""

import hashlib
import time as clock
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

import meshio
import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from vsb import __version__, bem, quality
from vsb.bodies import (
    FlexibleBody,
    IntArray,
    at_centres,
    at_vertices,
    check_symmetry,
    detected_symmetry,
    hydrostatic_stiffness,
    interior_lid,
    panel_diameters,
)
from vsb.bodysolver import BodyProblem
from vsb.config import canonical, content_id
from vsb.database import Check, as_json, check_at_most, merged_blocks, with_excitation, with_symmetrized
from vsb.errors import ConfigError, DatabaseError
from vsb.reading import read_yaml, validated
from vsb.sections import Count, Finite, Name, Positive, Section, Water
from vsb.specs import LEAST_DEPTH_IN_WAVENUMBERS, panel_solver
from vsb.units import FloatArray, load, save
from vsb.waves import group_velocity, wavenumber

Spec = dict[str, Any]
Model = TypeVar("Model", bound=Section)
PHYSICS = 1
"""Hand-bumped version of the physics behind a block."""
PANEL_FILES = {".gdf", ".pnl", ".hst", ".mar", ".nemoh", ".hams"}
"""What capytaine reads and meshio does not; meshio keeps the numbers of the vertices, which displacements refer to."""
_FAILED = (OSError, ValueError, KeyError, IndexError, TypeError, RuntimeError, meshio.ReadError, SystemExit)


class BodyStudy(Section):
    """A body file: mesh, modes, water, frequencies [rad/s], wave directions [degrees], symmetry and lid.

    Paths count from the folder of the file. Symmetry `auto` is what the panels have. `lid` is the number of belts of
    panels on the water inside; without it (0) coefficients at irregular frequencies break the verdict's identities.
    """

    body: Name
    mesh: str
    modes: str
    water: Water = Water()
    omega: tuple[Positive, ...]
    wave_direction: tuple[Finite, ...] = (0.0,)
    symmetry: Literal["auto", "none", "xOz", "yOz", "xOz+yOz"] = "auto"
    lid: Annotated[Count, Field(ge=0, le=64)] = 8

    @model_validator(mode="after")
    def _usable(self) -> Self:
        for name, values in (("omega", self.omega), ("wave_direction", self.wave_direction)):
            if not values or list(values) != sorted(set(values)):
                raise ValueError(f"{name} {list(values)}: needs at least one value, ascending without repetition")
        kd, water = LEAST_DEPTH_IN_WAVENUMBERS, self.water
        lowest = np.sqrt(kd * np.tanh(kd) * water.gravity / water.depth)
        if self.omega[0] < lowest:
            raise ValueError(
                f"omega {self.omega[0]:g} rad/s: in {water.depth:g} m of water needs at least {lowest:.4g}"
            )
        return self


def read_config(path: str | Path, model: type[Model]) -> Model:
    """Read and validate a YAML file; `ConfigError` in one line with file, key, value received and needed."""
    return validated(model, read_yaml(path, "a file such as config/barge.yaml"), str(path))


def read_mesh(path: str | Path) -> tuple[FloatArray, IntArray]:
    """Return vertices (vertex, xyz) [m] and panels (panel, 4) of a mesh file.

    Quadrilaterals and triangles of any format meshio reads, in the order of the file; WAMIT, NEMOH, Hydrostar and HAMS
    panels; or netCDF with `vertices` (vertex, xyz) and `faces` (panel, corner).
    """
    vertices, faces = _panels(path)
    if (wrong := np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=-1))).size:
        corners, last = faces[wrong[0]].tolist(), len(vertices) - 1
        raise ConfigError(f"{path}: panel {wrong[0]} has corners {corners}; needs numbers from 0 to {last}")
    return vertices, faces


def _panels(path: str | Path) -> tuple[FloatArray, IntArray]:
    """Vertices and panels as the file has them."""
    if not Path(path).is_file():
        raise ConfigError(f"{path}: mesh not found; needs the path of a mesh file, from the folder of the body file")
    try:
        if Path(path).suffix == ".nc":
            with xr.open_dataset(path) as ds:
                return np.array(ds.vertices.values, dtype=float), np.array(ds.faces.values, dtype=int)
        if Path(path).suffix in PANEL_FILES:
            return bem.read_panels(path)
        with np.errstate(over="ignore"):  # meshio takes the first bytes of an STL in plain text for a huge count
            mesh = meshio.read(path)
    except (*_FAILED, AttributeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ConfigError(f"{path}: cannot be read as a mesh ({reason}); needs a format of meshio or netCDF") from None
    cells = [block.data for block in mesh.cells if block.type in ("quad", "triangle")]
    if not cells:
        raise ConfigError(f"{path}: holds {[b.type for b in mesh.cells]}; needs quadrilaterals or triangles")
    panels = [np.column_stack([c, c[:, 2]]) if c.shape[1] == 3 else c for c in cells]
    points = np.asarray(mesh.points, dtype=float)
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), np.concatenate(panels).astype(int)


def read_body(mesh: str | Path, modes: str | Path) -> FlexibleBody:
    """Return a body from a mesh file and a netCDF file of its displacements.

    The latter holds `mode_shape` (dof, vertex or panel, xyz) with names on `dof`, and optionally `inertia_matrix` and
    `structural_stiffness` (influenced_dof, radiating_dof) and `centre_of_mass` (xyz).
    """
    vertices, faces = read_mesh(mesh)
    try:
        with xr.open_dataset(modes, engine="netcdf4") as opened:
            ds = opened.load()
    except _FAILED as error:
        raise ConfigError(f"{modes}: cannot be read as netCDF ({' '.join(str(error).split())})") from None
    if "mode_shape" not in ds or "dof" not in ds.coords:
        raise ConfigError(f"{modes}: holds {[*map(str, ds.variables)]}; needs mode_shape (dof, vertex, xyz) and dof")
    dims = ds.mode_shape.dims
    counts: dict[tuple[Any, ...], int] = {("dof", "vertex", "xyz"): len(vertices), ("dof", "panel", "xyz"): len(faces)}
    if counts.get(dims) != ds.mode_shape.shape[1] or ds.mode_shape.shape[2] != 3:
        raise ConfigError(
            f"{modes}: mode_shape {dict(ds.mode_shape.sizes)}; needs (dof, vertex, xyz) or (dof, panel, xyz) with "
            f"{len(vertices)} vertices or {len(faces)} panels, as {mesh} has"
        )
    values = np.array(ds.mode_shape.values, dtype=float)
    known = {name: np.array(ds[name].values, dtype=float) for name in _MATRICES.values() if name in ds}
    by_vertex = dims[1] == "vertex"
    try:
        return FlexibleBody(
            vertices,
            faces,
            tuple(map(str, ds.dof.values)),
            at_centres(vertices, faces, values) if by_vertex else values,
            values if by_vertex else at_vertices(vertices, faces, values),
            **{field: known.get(name) for field, name in _MATRICES.items()},
        )
    except (ConfigError, IndexError) as error:
        raise ConfigError(f"{mesh}, {modes}: {error}") from None


_MATRICES = {"mass": "inertia_matrix", "stiffness": "structural_stiffness", "centre_of_mass": "centre_of_mass"}


def write_body(body: FlexibleBody, path: str | Path) -> None:
    """Write a body as one netCDF file that is both the mesh and the modes `read_body` reads."""
    pair = ("influenced_dof", "radiating_dof")
    data: dict[str, Any] = {
        "vertices": (("vertex", "xyz"), body.vertices),
        "faces": (("panel", "corner"), body.faces),
        "mode_shape": (("dof", "vertex", "xyz"), body.shapes),
    }
    for field, name in _MATRICES.items():
        if getattr(body, field) is not None:
            data[name] = (("xyz",) if name == "centre_of_mass" else pair, getattr(body, field))
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    xr.Dataset(data, coords={"dof": list(body.labels)}).to_netcdf(path, engine="netcdf4")


def green_table(folder: Path) -> Any:
    """Capytaine's Green function; a table half written is never found under its name."""
    if not folder.is_dir():
        partial = folder.with_name(f".{folder.name}.partial")
        bem.green_function(partial)
        partial.replace(folder)
    return bem.green_function(folder)


def run(config: str | Path, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Solve what a body file asks for into `out` and return the verdict; `tables` keeps the Green function's table."""
    study = read_config(config, BodyStudy)
    folder = Path(config).parent
    return solve(study, read_body(folder / study.mesh, folder / study.modes), out, tables)


def solve(study: BodyStudy, body: FlexibleBody, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Solve a body into the database `out`/<name>.nc and return the verdict; blocks already there are kept."""
    symmetry = detected_symmetry(body) if study.symmetry == "auto" else study.symmetry
    check_symmetry(body, symmetry)
    lid = interior_lid(body, study.lid) if study.lid else None
    table = Path(tables or Path(out, "green", panel_solver().replace(" ", "-")))
    specs = [_spec(study, body, omega) for omega in (np.inf, *study.omega)]
    paths = [Path(out, "blocks", f"{content_id(spec)}.nc") for spec in specs]
    problem: BodyProblem | None = None
    for spec, path in zip(specs, paths, strict=True):
        if not _is_solved(path, content_id(spec)):
            problem = problem or BodyProblem(green_table(table), body, study.water, symmetry, lid)
            save(_block(problem, spec), path)
    return _write_database(study, body, symmetry, [load(path) for path in paths], Path(out, f"{study.body}.nc"))


def _spec(study: BodyStudy, body: FlexibleBody, omega: float) -> Spec:
    """What one frequency is solved from; symmetry only saves time, infinite frequency has neither waves nor lid."""
    digest = hashlib.sha256()
    for array in (body.vertices, body.faces.astype(np.int64), body.modes):
        digest.update(np.ascontiguousarray(array).tobytes())
    spec = {"stage": "body", "physics": PHYSICS, "solver": panel_solver(), "omega": float(omega)}
    spec |= {"panels_and_modes": digest.hexdigest(), "labels": list(body.labels), "water": study.water.model_dump()}
    return spec if np.isinf(omega) else spec | {"lid": study.lid, "wave_direction": list(study.wave_direction)}


def _is_solved(path: Path, spec_id: str) -> bool:
    """Whether a block is there; what cannot be read is solved again."""
    try:
        return path.is_file() and load(path).attrs.get("spec_id") == spec_id
    except DatabaseError:
        return False


def _block(problem: BodyProblem, spec: Spec) -> xr.Dataset:
    """Coefficients at one frequency, and how far they are from what their own waves say."""
    begun = clock.perf_counter()
    attrs: Spec = {"spec": canonical(spec), "spec_id": content_id(spec)}
    if np.isinf(spec["omega"]):
        ds = problem.at_infinity()
    else:
        solved = problem.solve(spec["omega"], np.deg2rad(spec["wave_direction"]))
        attrs |= identities(solved, problem)
        ds = solved.drop_vars(["haskind_force", "far_field_damping"])
    return ds.assign_attrs(attrs, seconds=clock.perf_counter() - begun)


def identities(ds: xr.Dataset, problem: BodyProblem) -> dict[str, float]:
    """Return errors at one frequency in terms of the radiation impedance |B_ii + i omega A_ii| of both motions [-].

    Of A and B from symmetry, of B from the energy of the far field, of excitation from Haskind's relation. An entry of
    B is measured by sqrt(Z_i Z_j), of X_i by the excitation that damping Z_i has, sqrt(4 rho g v_g Z_i/k).
    """
    omega, water = float(ds.omega[0]), problem.water
    impedance = (ds.radiation_damping + 1j * omega * ds.added_mass).values[0]
    z = np.abs(np.diag(impedance))
    pair = np.sqrt(np.outer(z, z))
    k, v_g = (f(omega, water.depth, water.gravity) for f in (wavenumber, group_velocity))
    wave = np.sqrt(4 * water.density * water.gravity * v_g / k * z)
    far = (ds.radiation_damping - ds.far_field_damping).values[0]
    haskind = (ds.Froude_Krylov_force + ds.diffraction_force - ds.haskind_force).values[0]
    return {
        "symmetry": float(np.abs((impedance - impedance.T) / pair).max()),
        "far_field": float(np.abs(far / pair).max()),
        "haskind": float(np.abs(haskind / wave).max()),
    }


_MEANING = {
    "symmetry": "added mass and damping are symmetric matrices",
    "far_field": "damping is the energy of the waves sent in all directions",
    "haskind": "excitation follows from the waves radiated",
}


def verdict(study: BodyStudy, body: FlexibleBody, blocks: list[xr.Dataset]) -> list[Check]:
    """Return the checks of a database before it is symmetrized."""
    ds, finite = merged_blocks(blocks), [block for block in blocks if "omega" in block.dims]
    longest = float(panel_diameters(body).max())
    k = wavenumber(study.omega[-1], study.water.depth, study.water.gravity)
    misfit = np.abs(at_centres(body.vertices, body.faces, body.shapes) - body.modes).max(axis=(1, 2))
    between = float((misfit / np.abs(body.modes).max(axis=(1, 2))).max())
    negative = quality.negative_damping(ds)
    checks = [
        *(
            check_at_most(name, max(block.attrs[name] for block in finite), 0.02, "-", text, doubt=True)
            for name, text in _MEANING.items()
        ),
        check_at_most("positive_damping", negative, 0.01, "-", "no motion can draw energy from calm water"),
        check_at_most("panels", longest * k / (2 * np.pi), 0.25, "-", "largest panel in wavelengths", doubt=True),
        check_at_most("corners", between, 0.05, "-", "displacement of panels agrees with that of corners", doubt=True),
    ]
    heave = [i for i, (t, a) in body.rigid.items() if np.allclose([*t, *a], [0, 0, 1, 0, 0, 0], atol=1e-9)]
    if body.mass is not None and heave:
        afloat = abs(body.mass[heave[0], heave[0]] / (study.water.density * body.volume) - 1)
        checks.append(check_at_most("afloat", afloat, 0.01, "-", "mass in heave is that of the water displaced"))
    return checks


def _write_database(
    study: BodyStudy, body: FlexibleBody, symmetry: str, blocks: list[xr.Dataset], path: Path
) -> list[Check]:
    """Merge the blocks into the database with capytaine's names, and return its verdict."""
    checks, pair = verdict(study, body, blocks), ("influenced_dof", "radiating_dof")
    stiffness = hydrostatic_stiffness(body, study.water.density, study.water.gravity)
    structure = {"inertia_matrix": body.mass, "structural_stiffness": body.stiffness}
    matrices = {"hydrostatic_stiffness": stiffness, **{k: m for k, m in structure.items() if m is not None}}
    ds = with_symmetrized(with_excitation(merged_blocks(blocks)))
    spec = {"stage": "body_database", "study": study.model_dump(), "blocks": [b.attrs["spec_id"] for b in blocks]}
    attrs = {
        "Conventions": "CF-1.8",
        "title": f"hydro database of {study.body}: {len(body.faces)} panels, {len(body.labels)} degrees of freedom",
        "source": f"vsb {__version__}",
        "solver": panel_solver(),
        "spec": canonical(spec),
        "spec_id": content_id(spec),
        "quality": as_json(checks),
        "separate_sweep": 0,
        "symmetry": symmetry,
        "water_density": study.water.density,
        "water_depth": str(study.water.depth),
        "gravity": study.water.gravity,
        "bem_seconds": sum(block.attrs["seconds"] for block in blocks),
    }
    complete = ds.assign({name: (pair, matrix) for name, matrix in matrices.items()})
    save(complete.assign_attrs(ds.attrs, **attrs), path)
    return checks
