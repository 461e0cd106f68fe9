"""The hydro database: blocks merged, expressed in the modes of a study, checked, and stored with its verdict."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from vsb.engine.hydro.dofs import Displacement, displacements
from vsb.engine.hydro.variables import PAIR, RESOLUTION
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.modes import ModeBasis
from vsb.errors import DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.files import load, locked, save, write_text


class Coefficients(NamedTuple):
    """Hydrodynamic coefficients at any frequencies."""

    added_mass: FloatArray  # (omega, dof, dof) [kg]
    damping: FloatArray  # (omega, dof, dof) [kg/s]
    excitation: ComplexArray  # (omega, dof) [N/m]

    @classmethod
    def side_by_side(cls, parts: Sequence["Coefficients"]) -> "Coefficients":
        """Return coefficients of motions that do not couple through the water, as those of azimuthal orders."""
        if len(parts) == 1:
            return parts[0]
        return cls(
            _blocks([part.added_mass for part in parts]),
            _blocks([part.damping for part in parts]),
            np.concatenate([part.excitation for part in parts], axis=1),
        )


def _blocks(matrices: Sequence[FloatArray]) -> FloatArray:
    """Matrices over frequency as blocks of one, (omega, dof, dof)."""
    return np.array([block_diag(*at) for at in zip(*matrices, strict=True)])


Verdict = Literal["ok", "doubt", "fail", "accepted"]
SWEEP = "sweep"
"""Group of the full frequency sweep when the study tabulates frequencies of its own."""
ESTIMATE = "error"
"""Dimension and suffix of names of the signed errors of coefficients by each way to estimate them."""


INVALIDATING: dict[str, Literal["flexible", "all"]] = {
    "buckling": "flexible",
    "computed_buckling": "flexible",
    "static_strain": "flexible",
    "strain": "flexible",
    "modes_left_out": "flexible",
    "modes": "flexible",
    "panels": "all",
    "energy_residual": "all",
    "power_limit": "all",
    "assumed_pressure": "all",
}
"""Checks whose failure makes a result invalid, and the designs concerned where a check names none.

An accepted failure is still a failure: numbers are computed, but they are no answer.
"""


@dataclass(frozen=True)
class Check:
    """One line of a verdict: a value against its limit."""

    name: str
    value: float
    limit: float
    unit: str
    verdict: Verdict
    explanation: str
    design: str = ""  # empty: all designs
    wave: str = ""  # label of the sea; empty: all seas
    advice: str = ""  # what would do, tried for this case; empty: general advice of its name, if any

    @property
    def invalidates(self) -> Literal["flexible", "all"] | None:
        """Designs made invalid where the check names none; None if it passes, or leaves results valid."""
        failed = self.verdict in ("fail", "accepted")
        return INVALIDATING.get(self.name.removeprefix("hydro ")) if failed else None

    @property
    def line(self) -> str:
        """The check as printed by commands."""
        text = f"{self.explanation}; {self.advice}" if self.advice else self.explanation
        return f"{self.verdict:12} {self.name} = {self.value:.3g} (limit {self.limit:g}): {text}"


def check_at_most(
    name: str,
    value: float,
    limit: float,
    unit: str,
    explanation: str,
    *,
    doubt: bool = False,
    design: str = "",
    wave: str = "",
) -> Check:
    """Return a check that passes if value <= limit; else it fails, or with `doubt` is a doubt up to 5 limit."""
    verdict: Verdict = "ok" if value <= limit else "doubt" if doubt and value <= 5 * limit else "fail"
    return Check(name, float(value), float(limit), unit, verdict, explanation, design, wave)


class Rule(NamedTuple):
    """Limit of a check, its meaning, and likely causes where it does not hold."""

    limit: float
    explanation: str
    doubt: float = 5.0
    """Values up to this many limits are a doubt, beyond they are a failure."""
    causes: str = ""

    def check(self, name: str, value: float, more: str = "", limit: float | None = None) -> Check:
        """Return the check of a value, with more of an explanation, and with another limit if given."""
        most = self.limit if limit is None else limit
        verdict: Verdict = "ok" if value <= most else "doubt" if value <= self.doubt * most else "fail"
        return Check(name, float(value), float(most), "-", verdict, self.explanation + more)


def solved_dataset(
    omegas: Sequence[float],
    labels: Sequence[str],
    columns: Sequence[tuple[FloatArray | ComplexArray, ...]],
    directions: Sequence[float] | FloatArray = (0.0,),
) -> xr.Dataset:
    """Return a solver's coefficients of displacements at frequencies [rad/s] in waves of some directions [rad].

    Each column holds added mass, damping, Froude-Krylov and diffraction force at one frequency.
    """
    added_mass, damping, *forces = (np.array(each) for each in zip(*columns, strict=True))
    shape, matrix = (len(omegas), len(directions), len(labels)), ("omega", *PAIR)
    froude_krylov, diffraction = ((("omega", "wave_direction", PAIR[0]), force.reshape(shape)) for force in forces)
    return xr.Dataset(
        {
            "added_mass": (matrix, added_mass),
            "radiation_damping": (matrix, damping),
            "Froude_Krylov_force": froude_krylov,
            "diffraction_force": diffraction,
        },
        {"omega": list(omegas), "wave_direction": list(directions), **{dim: list(labels) for dim in PAIR}},
    )


def merged_blocks(blocks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return blocks of disjoint frequencies as one dataset, frequencies ascending.

    Raises `DatabaseError` if a frequency occurs twice or the blocks differ in their degrees of freedom.
    """
    labels = {tuple(map(str, block.influenced_dof.values)) for block in blocks}
    if len(labels) != 1:
        raise DatabaseError(
            f"blocks with different degrees of freedom {sorted(labels)}; merge blocks of one spec only."
        )
    finite = [block for block in blocks if "omega" in block.dims]
    merged = xr.concat(finite, dim="omega", data_vars="minimal", coords="minimal", compat="override").sortby("omega")
    omega = merged.omega.values
    if np.any(np.diff(omega) <= 0):
        repeated = np.unique(omega[1:][np.diff(omega) <= 0]).tolist()
        raise DatabaseError(f"frequencies {repeated} rad/s occur in more than one block; merge each block once.")
    infinite = [block for block in blocks if "added_mass_inf" in block]
    return merged.assign(added_mass_inf=infinite[0].added_mass_inf) if infinite else merged


def displacements_of(basis: ModeBasis) -> tuple[Displacement, ...]:
    """Return the radial and meridional displacements that heave and modes consist of."""
    degrees = sorted({degree for mode in basis.shapes for degree, _, _ in mode.parts})
    return (*(Displacement("radial", n) for n in degrees), *(Displacement("meridional", n) for n in degrees if n))


def in_modes(raw: xr.Dataset, basis: ModeBasis) -> xr.Dataset:
    """Return coefficients of radial and meridional displacements as coefficients of heave and modes.

    BEM is linear in them, so on one shape every basis, design and material shares one BEM run. Meridional displacements
    that were not solved for, on the undeformed sphere, move no water.
    """
    return transformed(raw, shares(displacements(raw.influenced_dof.values), basis), basis.labels)


def transformed(raw: xr.Dataset, transform: FloatArray, labels: Sequence[str]) -> xr.Dataset:
    """Return coefficients of displacements as those of the labelled combinations of them, (dof, displacement) each.

    Of their errors nothing is known of the signs.
    """
    found = {}
    for name, data in raw.items():
        by = np.abs(transform) if name == RESOLUTION else transform
        values = data.values @ by.T
        found[name] = data.dims, by @ values if {*PAIR} <= {*data.dims} else values
    coords = {dim: list(labels) if dim in PAIR else raw.coords[dim] for dim in raw.sizes if dim in raw.coords}
    return xr.Dataset(found, coords)


def shares(solved: Sequence[Displacement], basis: ModeBasis) -> FloatArray:
    """Return the displacements that heave and modes consist of, shape (dof, displacement) [-].

    Those under loads at rings, the first ones of the modes of rings, are parts of these, which move no other water.
    Raises `DatabaseError` if a displacement they need was not solved for.
    """
    degrees = {degree for mode in basis.shapes for degree, _, _ in mode.parts}
    place = {each.label: j for j, each in enumerate(solved)}
    if lacking := sorted({f"Radial{n}" for n in degrees} - {*place}):
        raise DatabaseError(f"displacements {lacking} of the modes are not among those solved, {[*place]}.")
    found = np.zeros((len(basis.shapes), len(solved)))
    for row, mode in zip(found, basis.shapes, strict=True):
        for degree, radial, meridional in mode.parts:
            row[place[f"Radial{degree}"]] += radial
            if degree and (j := place.get(f"Meridional{degree}")) is not None:
                row[j] += meridional
    if basis.rings and (loads := [j for j, each in enumerate(solved) if each.kind == "load"]):
        found[-len(basis.rings.labels) :, loads] = basis.rings.of_loads(len(loads))
    return found


def with_excitation(ds: xr.Dataset) -> xr.Dataset:
    """Return the dataset with excitation_force = Froude-Krylov + diffraction."""
    return ds.assign(excitation_force=ds.Froude_Krylov_force.variable + ds.diffraction_force.variable)


def with_symmetrized(ds: xr.Dataset) -> xr.Dataset:
    """Return the dataset with added mass and damping made symmetric, the repair recorded in `history`.

    The asymmetry is discretization error (`check_symmetry` bounds it); energy needs exact symmetry.
    """
    names = [n for n in ("added_mass", "radiation_damping", "added_mass_inf", "added_mass_zero") if n in ds]
    swapped = {"influenced_dof": "radiating_dof", "radiating_dof": "influenced_dof"}
    even = {name: 0.5 * (ds[name] + ds[name].rename(swapped).transpose(*ds[name].dims)) for name in names}
    return with_history(ds.assign(even), "added mass and damping symmetrized")


def with_history(ds: xr.Dataset, *entries: str) -> xr.Dataset:
    """Return the dataset with more entries in its history."""
    said = [ds.attrs["history"]] if ds.attrs.get("history") else []
    return ds.assign_attrs(history="; ".join([*said, *entries]))


def with_structure(ds: xr.Dataset, reference: ReferenceShell) -> xr.Dataset:
    """Return the dataset with inertia, the stiffness of the reference shell by name, and the scale of the modes."""
    basis = reference.basis
    stiffness = {f"{name}_stiffness": (PAIR, matrix) for name, matrix in reference.stiffness.items()}
    return ds.assign(stiffness).assign(
        inertia_matrix=(PAIR, basis.inertia),
        pole_radial_displacement=("influenced_dof", basis.pole_radial_displacement),
        reference_amplitude=("influenced_dof", reference.modal_amplitude),
    )


def as_json(checks: Sequence[Check]) -> str:
    """Return checks as JSON text, as a verdict is stored with its database."""
    return json.dumps([asdict(check) for check in checks], allow_nan=False)


def stored_checks(ds: xr.Dataset) -> list[Check]:
    """Return the checks stored with a dataset."""
    return [Check(**item) for item in json.loads(ds.attrs["quality"])]


def open_database(path: str | Path) -> xr.Dataset:
    """Return the frequency sweep of a stored database: of a study, of a body, or read from another code's files.

    Raises
    ------
    DatabaseError
        If the file is unreadable, or no hydro database.
    """
    return _sweep(load(path), path)


def load_database(path: str | Path, expected_id: str) -> xr.Dataset:
    """Return the frequency sweep of a stored database after checking its id.

    The last one read is kept while its file does not change: every stage of a study in one process needs it. Raises
    `DatabaseError` if the file is unreadable, no database, or holds another spec than its name says.
    """
    known = Path(path).stat() if Path(path).is_file() else None
    return _loaded(str(path), expected_id, (known.st_mtime_ns, known.st_size) if known else ()).copy(deep=True)


@lru_cache(maxsize=1)
def _loaded(path: str, expected_id: str, written: tuple[int, ...]) -> xr.Dataset:
    """The sweep of a database as its file was written, nanoseconds and bytes; callers get copies."""
    ds = load(path)
    found = ds.attrs.get("spec_id")
    if found != expected_id:
        raise DatabaseError(
            f"{path}: holds the database {found!r}, needs {expected_id!r}; delete or move the file and run again."
        )
    return _sweep(ds, path)


def _sweep(ds: xr.Dataset, path: str | Path) -> xr.Dataset:
    """Frequency sweep of a file: in a group of its own if other frequencies are tabulated."""
    if "separate_sweep" not in ds.attrs:
        raise DatabaseError(f"{path}: holds no hydro database; needs one of results/hydro/db, or an imported one.")
    if not ds.attrs["separate_sweep"]:
        return ds
    constant = [name for name in ds.data_vars if "omega" not in ds[name].dims]
    return load(path, group=SWEEP).assign({name: ds[name] for name in constant}).assign_attrs(ds.attrs)


def save_database(tabulated: xr.Dataset, sweep: xr.Dataset | None, path: str | Path) -> None:
    """Write a database, the full sweep in a group of its own if other frequencies are tabulated, and refresh INDEX."""
    attrs = {**tabulated.attrs, "Conventions": "CF-1.8", "separate_sweep": int(sweep is not None)}
    save(tabulated.assign_attrs(attrs), path, groups={SWEEP: sweep} if sweep is not None else None)
    folder = Path(path).parent
    with locked(folder / ".index.lock"):
        write_text(folder.parent / "INDEX.tsv", index_text(folder))


def index_text(folder: Path) -> str:
    """Return the index of the databases in a folder."""
    columns = ("id", "radius_m", "basis", "degree", "frequencies", "omega_max", "water_depth_m", "verdict")
    rows: list[Sequence[object]] = [columns]
    for path in sorted(folder.glob("*.nc")):
        try:
            ds = load(path)
            fields = [ds.attrs.get(key, "-") for key in ("radius", "basis", "degree")]  # of a body none
            verdicts, depth = {check.verdict for check in stored_checks(ds)}, ds.attrs["water_depth"]
        except (DatabaseError, KeyError, TypeError, ValueError):  # a file of another kind
            rows.append([path.stem, *["-"] * 6, "unreadable"])
            continue
        omega = ds.omega.values
        worst = next(v for v in ("fail", "accepted", "doubt", "ok") if v in verdicts or v == "ok")
        rows.append([path.stem, *fields, len(omega), f"{omega[-1]:g}", depth, worst])
    return "".join("\t".join(map(str, row)) + "\n" for row in rows)
