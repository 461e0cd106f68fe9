"""BEMIO's .h5 file, which WEC-Sim reads: written of one body, read of one or several.

Paths, dimensions and normalization (`scaled` = 0: A/rho, B/(rho omega), X/(rho g), C/(rho g), K/rho, f/(rho g)) are
those of WEC-Sim's writeBEMIOH5, numbers those of WAMIT with ULEN = 1 m (`wamit`): phasors are Re(X e^{+i omega t}),
so X is conjugated on writing and reading. Rotations are about the centre of mass. Arrays are full over the modes 1 to
6 + N: rigid modes that the database lacks are zeros, as for a body held in them, and `mode_labels` (not BEMIO's) names
the others.

WEC-Sim reads only the block of generalized modes of `mass`, `damping` and `stiffness`; the inertia of the rigid modes
is in its own input.
"""

import math
import re
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.linalg import block_diag

from vsb.engine.hydro.formats.common import (
    GENERALIZED,
    POINTS,
    WATER,
    assembled,
    body_names,
    checked,
    floating,
    mode_labels,
    mode_numbers,
    point_of,
    readable,
    structure,
    turned_about,
    volume_of,
)
from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.hydro.variables import PAIR, body_of
from vsb.errors import DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.files import atomic_write, seal
from vsb.tools.variables import VARIABLES

_FOLDERS = {"excitation_force": "", "Froude_Krylov_force": "froude-krylov/", "diffraction_force": "scattering/"}
_WAVES, _BODY, _HYDRO = "/simulation_parameters/", "/body1/properties/", "/body1/hydro_coeffs/"
_COUPLED = ("hydro_coeffs/added_mass", "hydro_coeffs/radiation_damping", "properties/")
"""Datasets in which the rows of one of several bodies have columns of all of them."""
_RADIATED, _EXCITED = (f"{_HYDRO}{part}/impulse_response_fun/" for part in ("radiation_damping", "excitation"))
_MATRICES = {  # dataset of the .h5 file: variable, what it is divided by
    f"{_HYDRO}added_mass/all": ("added_mass", "rho"),
    f"{_HYDRO}added_mass/inf_freq": ("added_mass_inf", "rho"),
    f"{_HYDRO}radiation_damping/all": ("radiation_damping", "rho*w"),
    f"{_HYDRO}linear_restoring_stiffness": ("hydrostatic_stiffness", "rho*g"),
    f"{_BODY}mass": ("inertia_matrix", "1"),
    f"{_BODY}damping": ("structural_damping_matrix", "1"),
    f"{_BODY}stiffness": ("structural_stiffness", "1"),
}
_FACTS = {"displaced_volume": "disp_vol", "centre_of_buoyancy": "cb", "centre_of_mass": "cg"}
_UNITS = (
    "g=m/s^2 rho=kg/m^3 T=s w=rad/s wave_dir=deg disp_vol=m^3 cg=m cb=m mass=kg damping=kg/s stiffness=N/m t=s f=m^2/s"
)
_UNITS += " all=m^3 inf_freq=m^3 K=m^3/s^2 linear_restoring_stiffness=m^2 re=m^2 im=m^2 mag=m^2 phase=rad water_depth=m"
SAME = 1e-3
"""Difference of redundant numbers in a file, relative to the largest of their degree of freedom."""
LARGEST_DATASET, LARGEST_MODES = 10**8, 1000
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(8)


def bemio_entries(ds: xr.Dataset, source: str) -> dict[str, Any]:
    """Return the datasets of BEMIO's .h5 file by path, dimensions in the order of HDF5, which MATLAB shows reversed.

    `mass`, `damping` and `stiffness` are those of `common.structure`; a database in which they couple a rigid mode to a
    generalized one, which WEC-Sim drops, is refused. Times of the impulse responses: `impulse_times`.
    """
    needed = ["excitation_force", *(name for place, (name, _) in _MATRICES.items() if place.startswith(_HYDRO))]
    ds = checked(ds.sel(omega=ds.omega > 0), source, needed)
    labels, omega, headings = (ds[name].values for name in ("influenced_dof", "omega", "wave_direction"))
    rho, g, depth = (float(ds.attrs[name]) for name in WATER)
    modes = mode_numbers(list(map(str, labels)))
    ds = _with_structure(ds, source, modes)
    body = floating(ds, source)
    ds = turned_about(ds, body.centre_of_mass, source)
    dof = max(6, *modes)
    time = impulse_times((1.5 * body.volume / np.pi) ** (1 / 3), g)
    waves = {"scaled": 0, "g": g, "rho": rho, "T": 2 * np.pi / omega, "w": omega, "wave_dir": np.degrees(headings)}
    facts: dict[str, Any] = {"body_number": 1, "dof": dof, "dof_start": 1, "dof_end": dof}
    facts |= dict(zip(_FACTS.values(), body, strict=True))
    lists = {f"{_WAVES}{key}": value for key, value in waves.items()} | {f"{_BODY}{k}": v for k, v in facts.items()}
    lists |= {f"{_RADIATED}t": time, f"{_EXCITED}t": (both := np.concatenate([-time[:0:-1], time]))}
    entries: dict[str, Any] = {place: np.reshape(value, (-1, 1)) for place, value in lists.items()}
    entries |= {"/bem_data/code": "vsb", f"{_BODY}name": "buoy", f"{_BODY}mode_labels": "\n".join(map(str, labels))}
    entries[f"{_WAVES}water_depth"] = "infinite" if np.isinf(depth) else np.array([[depth]])
    edges = _edges(np.concatenate([[0.0], omega]), time[-1])[1:]  # fine enough for the quadrature at the last time
    spectrum = DampingSpectrum(edges, DampingSpectrum(omega, ds.radiation_damping.values).at(edges))
    matrices = {f"{_RADIATED}K": spectrum.kernel(time) / rho}
    held = {place: item for place, item in _MATRICES.items() if item[0] in ds}
    matrices |= {place: ds[name].values / _divisor(by, rho, g, omega) for place, (name, by) in held.items()}
    entries |= {place: _spread(value, modes, dof, 2) for place, value in matrices.items()}
    for name, folder in [item for item in _FOLDERS.items() if item[0] in ds]:
        x = np.conj(_spread(ds[name].values, modes, dof, 1)) / (rho * g)
        parts = {"re": x.real, "im": x.imag, "mag": np.abs(x), "phase": np.angle(x)}
        entries |= {f"{_HYDRO}excitation/{folder}{part}": value for part, value in parts.items()}
    response = excitation_response(omega, ds.excitation_force.values, both) / (rho * g)
    return entries | {f"{_EXCITED}f": _spread(response, modes, dof, 1)}


def _with_structure(ds: xr.Dataset, source: str, modes: list[int]) -> xr.Dataset:
    """The dataset with damping, and with prestress and gas in its stiffness; rigid modes are uncoupled."""
    if (dry := structure(ds, source)) is None:
        if max(modes) >= GENERALIZED:
            raise DatabaseError(
                f"{source}: holds no inertia_matrix and structural_stiffness; generalized modes need both."
            )
        return ds
    rigid = np.array(modes) < GENERALIZED
    names = ("inertia_matrix", "structural_damping_matrix", "structural_stiffness")
    for name, matrix in zip(names, dry, strict=True):
        if np.abs(matrix[rigid[:, None] != rigid]).max(initial=0.0) > 1e-9 * np.abs(matrix).max():
            raise DatabaseError(
                f"{source}: {name} couples rigid and generalized modes, which WEC-Sim drops; needs another basis."
            )
    return ds.assign({name: (PAIR, m) for name, m in zip(names, dry, strict=True)})


def impulse_times(radius: float, gravity: float) -> FloatArray:
    """Return the 1001 times of the radiation's impulse response, from 0 [s]; the excitation's begin as long before 0.

    `radius` is that of a floating hemisphere of the body's displacement [m], the length scale of its waves and decay.
    Steps are the largest 1-2-5 number below 0.23 sqrt(radius/g): 0.1 s, up to 100 s, at a radius of 2 m. The highest
    frequency they resolve is Ka > 180, where no body makes waves.
    """
    bound = 0.23 * math.sqrt(radius / gravity)
    decade = 10.0 ** math.floor(math.log10(bound))
    step = float(f"{max(m * decade for m in (1, 2, 5) if m * decade <= bound):.0e}")
    return np.linspace(0.0, 1000 * step, 1001)


def _edges(omega: FloatArray, last: float) -> FloatArray:
    """Frequencies and others between them, none further apart than 10/last [rad/s]."""
    counts = np.ceil(np.diff(omega) * last / 10).astype(int)
    return np.concatenate([*map(np.linspace, omega[:-1], omega[1:], counts, [False] * len(counts)), omega[-1:]])


def excitation_response(omega: FloatArray, force: ComplexArray, time: FloatArray) -> FloatArray:
    """Return the impulse response of the excitation, f(t) = (1/pi) int Re(X* e^{i omega t}) d omega.

    From phasors X as in the database (C1), shape (omega, wave_direction, dof) [N/m], to shape (time, wave_direction,
    dof) [N/(m s)]: the force of an elevation eta at the origin is F(t) = int f(s) eta(t - s) ds. It is not zero before
    s = 0: waves reach the body before they reach its origin.

    BEMIO's excitationIRF, from 0 instead of the lowest frequency: the cubic spline includes X(-omega) = X*. Above the
    highest frequency X is zero; at that frequency itself the inverse transform gives half of it.
    """
    both = np.concatenate([-omega[::-1], omega])
    spline = CubicSpline(both, np.concatenate([force[::-1], force.conj()]))
    edges = _edges(np.concatenate([[0.0], omega]), float(np.abs(time).max()))
    half = np.diff(edges)[:, None] / 2
    nodes = ((edges[:-1] + edges[1:])[:, None] / 2 + half * _NODE).ravel()
    x = (half * _WEIGHT).ravel()[:, None] * spline(nodes).reshape(len(nodes), -1)
    phase = np.outer(time, nodes)
    return np.asarray((np.cos(phase) @ x.real - np.sin(phase) @ x.imag) / np.pi).reshape(len(time), *force.shape[1:])


def _divisor(by: str, rho: float, g: float, omega: FloatArray) -> Any:
    """Divisor of a dataset of the .h5 file."""
    return {"rho": rho, "rho*w": rho * omega[:, None, None], "rho*g": rho * g, "1": 1.0}[by]


def _spread(values: Any, modes: list[int], dof: int, axes: int) -> Any:
    """Values over the database's modes, the last one or two axes, among all modes, zero for others; other axes last."""
    full, index = np.zeros((*values.shape[:-axes], *[dof] * axes), values.dtype), np.array(modes) - 1
    full[(..., index[:, None], index) if axes == 2 else (..., index)] = values
    return full.T if axes == 1 else np.moveaxis(full, 0, -1) if full.ndim == 3 else full


def write_h5(entries: dict[str, Any], path: Path) -> None:
    """Write datasets by path to an HDF5 file, complete or not at all; netCDF adds their sizes to its root."""
    units = dict(u.split("=") for u in _UNITS.split())
    with atomic_write(path) as temporary:
        with netCDF4.Dataset(temporary, "w") as file:
            for place, values in entries.items():
                for size in {*np.shape(values)} - {dimension.size for dimension in file.dimensions.values()}:
                    file.createDimension(f"n{size}", size)
                kind: Any = str if isinstance(values, str) else "f8"
                dimensions = [f"n{size}" for size in np.shape(values)]
                variable = file.createVariable(place, kind, dimensions, zlib=np.size(values) > 10_000)
                variable[...] = values
                variable.units = units.get(place.rpartition("/")[2], "")
        seal(temporary)


def read_bemio(path: str | Path) -> xr.Dataset:
    """Return the hydro database of a BEMIO .h5 file: all modes of all its bodies, dimensional.

    Parts of the excitation with NaN, BEMIO's mark of values not computed, are left out; `structural_stiffness` is all
    stiffness but the water's; labels are those of the file, else Surge, ..., Yaw, Mode7, ..., of several bodies with
    the name of the body: float__Heave. Only known datasets are read, and only of the shapes that follow from the
    numbers of modes, frequencies and headings. Raises `DatabaseError` if the file cannot be read, or is damaged.
    """
    with readable(path, "BEMIO's .h5 file with all its datasets"), netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        with np.errstate(over="ignore", invalid="ignore"):  # checked in the end
            found = _from_bemio(_Entries(file, str(path)), str(path))
    return found


class _Entries(NamedTuple):
    """Datasets of an .h5 file by path, read one by one."""

    file: Any
    source: str

    def find(self, place: str) -> Any:
        """Return the variable at a path, or None."""
        group = self.file
        *groups, name = place.strip("/").split("/")
        for part in groups:
            if (group := group.groups.get(part)) is None:
                return None
        return group.variables.get(name)

    def numbers(self, place: str, *shape: int) -> FloatArray:
        """Return the numbers at a path, in a given shape; without one as a list."""
        if (variable := self.find(place)) is None:
            raise DatabaseError(f"{self.source}: holds no {place}; needs BEMIO's .h5 file with all its datasets.")
        found = tuple(int(size) for size in variable.shape)
        if shape and tuple(n for n in found if n != 1) != tuple(n for n in shape if n != 1):
            raise DatabaseError(f"{self.source}: {place} has shape {found}; needs {shape}.")
        if math.prod(found) > LARGEST_DATASET:
            raise DatabaseError(f"{self.source}: {place} has shape {found}; needs at most {LARGEST_DATASET} numbers.")
        return np.asarray(variable[...], dtype=float).reshape(shape or -1)

    def check_same(self, place: str, expected: Any, what: str, *shape: int) -> None:
        """Check that redundant numbers agree, if a file has them and they are known; `DatabaseError`."""
        if self.find(place) is not None and np.isfinite(expected).all():
            self.check_agree(place, self.numbers(place, *shape), expected, what)

    def check_agree(self, place: str, found: Any, expected: Any, what: str) -> None:
        """Check that numbers at a place agree with others to `SAME` of the largest of each first index."""
        size = np.abs(expected).reshape(len(expected), -1).max(axis=1).reshape(-1, *[1] * (np.ndim(expected) - 1))
        if (wrong := ~(np.abs(found - expected) <= SAME * np.maximum(size, 1e-6 * size.max()))).any():
            at = tuple(int(i) for i in np.argwhere(wrong)[0])
            raise DatabaseError(
                f"{self.source}: {place} differs from the {what} at {at}: the file contradicts itself; needs to be "
                "made again."
            )

    def number(self, place: str) -> float:
        """Return the one number at a path."""
        return float(self.numbers(place, 1)[0])

    def text(self, place: str) -> str:
        """Return the short text, or number as text, at a path; empty if there is none."""
        variable = self.find(place)
        if variable is not None and math.prod(variable.shape) > 1000:
            raise DatabaseError(f"{self.source}: {place} has shape {variable.shape}; needs a short text.")
        return "" if variable is None else "".join(map(str, np.ravel(variable[...])))


class _Part(NamedTuple):
    """One body of an .h5 file."""

    group: str
    size: int  # degrees of freedom in the file
    held: FloatArray  # places among them of those its labels name
    labels: list[str]  # with the name of the body if there are several


def _from_bemio(found: _Entries, source: str) -> xr.Dataset:
    """The database in the datasets of an .h5 file."""
    parts = _parts(found)
    rho, g = (found.number(f"{_WAVES}{key}") for key in ("rho", "g"))
    omega, headings = (found.numbers(f"{_WAVES}{name}") for name in ("w", "wave_dir"))
    found.check_same(f"{_WAVES}T", 2 * np.pi / omega, f"periods of {_WAVES}w", len(omega))
    scaled = bool(np.all(found.numbers(f"{_WAVES}scaled")))
    variables, history = {}, [f"read from {Path(source).name}"]
    for place, (name, by) in _MATRICES.items():
        inside = place.removeprefix("/body1/")
        if place.startswith(_HYDRO) or any(found.find(f"/{part.group}/{inside}") is not None for part in parts):
            value = _matrix(found, parts, inside, len(omega) if "omega" in VARIABLES[name].dims else 0)
            variables[name] = value * (1.0 if scaled else _divisor(by, rho, g, omega))
    for name, folder in _FOLDERS.items():
        if not folder or found.find(f"{_HYDRO}excitation/{folder}re") is not None:
            force = _forces(found, parts, f"hydro_coeffs/excitation/{folder}", (len(headings), len(omega)))
            if not folder or np.isfinite(force).all():
                variables[name] = force.T * (1.0 if scaled else rho * g)
            else:
                history.append(f"left out: {name}, which holds NaN")
    depth = found.text(f"{_WAVES}water_depth")
    water = rho, g, "inf" if "inf" in depth else str(float(depth))
    attrs = dict(zip(WATER, water, strict=True), source="BEMIO", history="; ".join(history))
    labels = [label for part in parts for label in part.labels]
    return assembled(source, (labels, omega, headings), variables, attrs | _facts(found, parts))


def _parts(found: _Entries) -> list[_Part]:
    """Bodies of an .h5 file, in its order."""
    groups = sorted(name for name in found.file.groups if re.fullmatch(r"body\d+", name))
    if {*groups} != {f"body{k + 1}" for k in range(len(groups))}:
        raise DatabaseError(f"{found.source}: holds {', '.join(groups)}; needs body1, body2, ... without a gap.")
    groups = [f"body{k + 1}" for k in range(len(groups) or 1)]
    names = body_names([found.text(f"/{group}/properties/name") for group in groups])
    parts = []
    for group, name in zip(groups, names, strict=True):
        size = found.number(f"/{group}/properties/dof")
        if not (size == int(size) and 6 <= size <= LARGEST_MODES):
            raise DatabaseError(f"{found.source}: holds {size:g} degrees of freedom; needs six rigid and a few more.")
        stated = found.text(f"/{group}/properties/mode_labels").splitlines()
        labels = stated or mode_labels(range(1, int(size) + 1))
        if (last := max(6, *mode_numbers(labels))) != size:
            raise DatabaseError(
                f"{found.source}: holds {size:g} degrees of freedom; needs {last} for its mode_labels {labels}."
            )
        index = np.array(mode_numbers(labels)) - 1
        parts.append(_Part(group, int(size), index, [f"{name}__{label}" if name else label for label in labels]))
    return parts


def _matrix(found: _Entries, parts: list[_Part], inside: str, frequencies: int) -> FloatArray:
    """One matrix over the degrees of freedom of all bodies, whose rows are in the group of each, frequencies first."""
    sizes = [part.size for part in parts]
    columns = np.concatenate([np.sum(sizes[:k], dtype=int) + part.held for k, part in enumerate(parts)])
    shape, rows = (frequencies,) if frequencies else (), []
    coupled = inside.startswith(_COUPLED)
    for part in parts:
        width, own = (sum(sizes), columns) if coupled else (part.size, part.held)
        value = found.numbers(f"/{part.group}/{inside}", part.size, width, *shape)
        rows.append(value[np.ix_(part.held, own)])
    value = np.concatenate(rows) if coupled else block_diag(*rows)
    return np.moveaxis(value, -1, 0) if frequencies else value


def _forces(found: _Entries, parts: list[_Part], inside: str, shape: tuple[int, int]) -> ComplexArray:
    """Phasors (C1) of the degrees of freedom of all bodies, (dof, wave_direction, omega)."""
    rows = []
    for part in parts:
        re, im = (found.numbers(f"/{part.group}/{inside}{name}", part.size, *shape) for name in ("re", "im"))
        place, force = f"/{part.group}/{inside}", re + 1j * im
        found.check_same(f"{place}mag", np.abs(force), f"moduli of {place}re and im", part.size, *shape)
        if found.find(f"{place}phase") is not None and np.isfinite(force).all():
            phase = found.numbers(f"{place}phase", part.size, *shape)
            phase = np.radians(phase) if np.abs(phase).max() > 2 * np.pi + SAME else phase  # of the first BEMIO
            found.check_agree(f"{place}phase", np.abs(force) * np.exp(1j * phase), force, f"phases of {place}re and im")
        rows.append(force.conj()[part.held])
    return np.concatenate(rows)


def _facts(found: _Entries, parts: list[_Part]) -> dict[str, Any]:
    """Displaced volume of each body, and centres, which of several bodies are not needed."""
    facts: dict[str, Any] = {}
    for part in parts:
        name, place = body_of(part.labels[0]), f"/{part.group}/properties/"
        facts[volume_of(name)] = found.number(f"{place}disp_vol")
        for point, key in zip(POINTS, ("cb", "cg", "cg"), strict=True):
            if not name or found.find(f"{place}{key}") is not None:
                facts[point_of(point, name)] = found.numbers(f"{place}{key}", 3)
    return facts
