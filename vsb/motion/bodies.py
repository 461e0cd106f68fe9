"""A body of any shape in linear waves: from a hydro database of any source to response, port, memory and scene.

The database may be a body's own, or come from WAMIT, BEMIO or capytaine (`vsb.hydro.formats`); mass, damping and
stiffness of the dry body are the database's where they are not given.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, final

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh, null_space

from vsb.errors import ConfigError, DatabaseError, StabilityError
from vsb.hydro.database import Coefficients
from vsb.hydro.formats.common import DRY, Structure, structure
from vsb.hydro.passive import Limit, PassiveFit, RadiationSamples, fit_lowest, sizes
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel
from vsb.hydro.variables import PAIR
from vsb.motion.builders import take_off
from vsb.motion.forces import Damper, Excitation, Force, RadiationMemory, Spring
from vsb.motion.frequency import LinearMotion
from vsb.motion.port import LinearPto
from vsb.motion.scene import Scene
from vsb.study.quantities import motion_of
from vsb.tools.arrays import FloatArray
from vsb.waves.seas import Sea

_SAME_DIRECTION = 1e-6  # [rad]
_UNEVEN = 1e-6  # asymmetry of a matrix, in terms of its largest entry, that is round-off
_ADRIFT = 1e-9  # square of a growth rate, in terms of the largest of a frequency, that is round-off
_UNMOVED = 1e-9  # share of a degree of freedom in the motions allowed that is round-off: it is held
NO_TAKE_OFF = LinearPto(0.0)


@final
@dataclass(frozen=True)
class LinearBody(LinearMotion):
    """Degrees of freedom of one or more bodies in waves of one direction; made by `linear_body`, checked when made."""

    direction: float = 0.0  # the waves go to [rad]

    def __post_init__(self) -> None:
        """Refuse what cannot move."""
        dof = len(self.labels)
        dry = {"mass": self.mass, "damping": self.structural_damping, "stiffness": self.dry_stiffness}
        for name, matrix in dry.items():
            if np.shape(matrix) != (dof, dof) or not np.isfinite(matrix).all():
                raise ConfigError(
                    f"{name}: received shape {np.shape(matrix)}, needs finite numbers, shape {(dof, dof)}."
                )
            if np.abs(matrix - matrix.T).max() > _UNEVEN * np.abs(matrix).max():
                raise ConfigError(f"{name}: received a matrix that is not symmetric, needs a symmetric one.")
        inertia = self.mass + self.added_mass_inf
        scale = np.sqrt(np.abs(np.diag(inertia)))
        if not (scale > 0).all() or np.linalg.eigvalsh(inertia / np.outer(scale, scale))[0] <= 0:
            still = [label for label, own in zip(self.labels, np.diag(inertia), strict=True) if own <= 0]
            raise ConfigError(
                f"mass: received {', '.join(still) or 'motions'} without inertia, the water's at infinite frequency "
                "included; needs a positive definite mass, or other degrees of freedom."
            )
        rates, shapes = np.linalg.eigh(self.structural_damping / np.outer(scale, scale))
        if rates[0] < -_UNEVEN * np.abs(rates).max():
            most = self.labels[int(np.abs(shapes[:, 0]).argmax())]
            raise ConfigError(
                f"damping: received a matrix that gives energy to {most}, by {-rates[0]:.3g}/s; needs one without a "
                "negative eigenvalue."
            )
        if self.pto.port is None and (np.any(self.pto.damping) or self.pto.stiffness):
            raise ConfigError("pto: received no port, needs the motion it takes off; see `combination`.")
        if self.pto.port is not None and self.pto.port.shape != (dof,):
            raise ConfigError(f"pto: received a port of {self.pto.port.shape}, needs {(dof,)}.")

    @property
    def dry_stiffness(self) -> FloatArray:
        """Stiffness of the dry body and its mooring, shape (dof, dof) [N/m]."""
        return self.stiffness_parts["structural"]

    @cached_property
    def samples(self) -> RadiationSamples:
        """Radiation at the frequencies of the database, each motion measured by its damping."""
        omega, damping = self.spectrum.omega, self.spectrum.damping
        size = sizes(omega, damping, np.diag(self.mass + self.added_mass_inf))
        return RadiationSamples(omega, self.database.added_mass.values, damping, self.added_mass_inf, size)

    def memory(self, tolerance: float, *, limit: Limit = "given") -> PassiveFit:
        """Return the passive radiation memory; see `vsb.hydro.passive.fit_lowest`."""
        return fit_lowest(self.samples, tolerance, limit=limit)

    @cached_property
    def _splines(self) -> tuple[CubicSpline, CubicSpline, CubicSpline]:
        """Added mass, damping and excitation of all directions between the frequencies solved."""
        names = ("added_mass", "radiation_damping", "excitation_force")
        mass, damping, force = (CubicSpline(self.database.omega.values, self.database[name].values) for name in names)
        return mass, damping, force

    @property
    def heading_index(self) -> int:
        """Place of the waves' direction among those of the database.

        Raises
        ------
        DatabaseError
            If it is not there.
        """
        known = self.database.wave_direction.values
        if (near := direction_index(known, self.direction)) is None:
            raise DatabaseError(
                f"wave direction: received {np.degrees(self.direction):g} degrees, needs one of "
                f"{', '.join(f'{d:g}' for d in np.degrees(known))}."
            )
        return near

    def coefficients(self, omega: FloatArray) -> Coefficients:
        """Return the coefficients by cubic splines, in waves of one of the database's directions.

        Raises
        ------
        DatabaseError
            Outside the band, or if the direction is not there.
        """
        first, last = self.database.omega.values[[0, -1]]
        if omega.size and (omega.min() < first - 1e-9 or omega.max() > last + 1e-9):
            raise DatabaseError(
                f"frequencies: received {omega.min():.4g} to {omega.max():.4g} rad/s, the database holds {first:g} to "
                f"{last:g} rad/s; solve a wider band, or use waves within it."
            )
        added_mass, damping, force = (spline(omega) for spline in self._splines)
        return Coefficients(added_mass, damping, np.asarray(force[:, self.heading_index], dtype=complex))

    def added_mass_at(self, omega: float) -> FloatArray:
        """Return the added mass, beyond the band as constant below and as it nears its limit above, (dof, dof) [kg]."""
        first, last = self.database.omega.values[[0, -1]]
        inside = np.asarray(self._splines[0](np.clip(omega, first, last)))
        return self.added_mass_inf + (inside - self.added_mass_inf) * min(1.0, float(last / omega)) ** 2

    def unrestrained(self, stiffness: FloatArray, motions: FloatArray) -> FloatArray:
        """Return the motions nothing holds; see `LinearMotion.drifting`."""
        inertia = motions.T @ (self.mass + self.added_mass_inf) @ motions
        values, shapes = eigh(stiffness, inertia)
        size = _ADRIFT * max(abs(values[-1]), 1e-300)
        if values[0] < -size:
            most = np.abs(motions @ shapes[:, 0]) * np.sqrt(np.diag(self.mass + self.added_mass_inf))
            raise StabilityError(
                f"the body does not rest: received a negative stiffness of {self.labels[int(most.argmax())]}, growing "
                f"by {np.sqrt(-values[0]):.3g}/s; needs a lower centre of mass, a mooring, or this motion held."
            )
        return np.asarray(shapes[:, values <= size])


def direction_index(known: FloatArray, direction: float) -> int | None:
    """Return the place of a wave direction [rad] among those known, full turns left out; none if it is not there."""
    apart = np.abs((known - direction + np.pi) % (2 * np.pi) - np.pi)
    near = int(np.argmin(apart))
    return near if apart[near] <= _SAME_DIRECTION else None


def linear_body(
    database: xr.Dataset,
    dofs: Sequence[str] | None = None,
    *,
    mass: FloatArray | None = None,
    damping: FloatArray | None = None,
    stiffness: FloatArray | None = None,
    pto: LinearPto = NO_TAKE_OFF,
) -> LinearBody:
    """Return a body from a hydro database.

    Parameters
    ----------
    database : xarray.Dataset
    dofs : sequence of str, optional
        Degrees of freedom in the order wanted, the others held; all of them.
    mass, damping, stiffness : ndarray, shape (dof, dof), optional
        Of the dry body, in the degrees of freedom wanted; of the database. Without structure: no damping, no stiffness.
    pto : LinearPto
        With its port over the degrees of freedom wanted; see `combination`.

    Raises
    ------
    ConfigError, DatabaseError
        If something is missing or makes no sense.
    """
    labels = [str(label) for label in database.influenced_dof.values]
    wanted = labels if dofs is None else [str(label) for label in dofs]
    if not wanted or len(set(wanted)) < len(wanted) or not set(wanted) <= set(labels):
        raise ConfigError(
            f"degrees of freedom: received {', '.join(wanted) or 'none'}; needs some of {', '.join(labels)}."
        )
    index = [labels.index(label) for label in wanted]
    chosen = database.isel(influenced_dof=index, radiating_dof=index)
    chosen = with_added_mass_inf(chosen.sel(omega=chosen.omega > 0))
    given = (mass, damping, stiffness)
    dry = None if all(matrix is not None for matrix in given) else structure(chosen, "database", damping)
    if mass is None and dry is None:
        raise ConfigError("mass: received none, and the database holds no structure; needs the mass matrix.")
    none = np.zeros((len(index), len(index)))
    own = dry or Structure(none, none, none)
    chosen_mass, chosen_damping, chosen_stiffness = (
        held if matrix is None else np.asarray(matrix, dtype=float) for held, matrix in zip(own, given, strict=True)
    )
    for name, matrix in (("mass", chosen_mass), ("damping", chosen_damping), ("stiffness", chosen_stiffness)):
        if matrix.shape != none.shape:
            raise ConfigError(f"{name}: received shape {matrix.shape}, needs finite numbers, shape {none.shape}.")
    complete = chosen.drop_vars([name for name in DRY if name in chosen]).assign(
        inertia_matrix=(PAIR, chosen_mass), structural_stiffness=(PAIR, chosen_stiffness)
    )
    return LinearBody(complete, chosen_damping, pto)


def with_added_mass_inf(ds: xr.Dataset) -> xr.Dataset:
    """Return a database with the added mass at infinite frequency, by Kramers and Kronig if it had none: `history`."""
    if "added_mass_inf" in ds:
        return ds
    omega = ds.omega.values
    change = DampingSpectrum(omega, ds.radiation_damping.values).added_mass_difference(omega)
    limit = np.median(ds.added_mass.values - change, axis=0)
    told = f"{ds.attrs.get('history', '')}; added mass at infinite frequency from damping".lstrip("; ")
    return ds.assign(added_mass_inf=(PAIR, limit)).assign_attrs(history=told)


class Memory(NamedTuple):
    """What a scene needs of a `PassiveFit`."""

    model: RadiationModel
    added_mass_inf: FloatArray  # (dof, dof) [kg]
    up_to: float = np.inf  # frequency up to which it follows the coefficients [rad/s]


def body_scene(
    body: LinearBody,
    radiation: Memory | PassiveFit | None,
    waves: Mapping[float, Sea],
    motions: FloatArray | None = None,
) -> Scene:
    """Return the linear scene of a body in seas of several directions, with the forces it has and no others.

    Parameters
    ----------
    body : LinearBody
    radiation : Memory, PassiveFit or None
        Of `LinearBody.memory`, its added mass at infinite frequency included; None: the body makes no waves.
    waves : mapping of float to Sea
        Direction [rad] -> sea; none: still water.
    motions : ndarray, shape (dof, free), optional
        Those allowed; all. An initial position is one of heave (see `_heave`).

    Raises
    ------
    StabilityError
        If the body does not rest stably.
    """
    dof = len(body.labels)
    free = np.eye(dof) if motions is None else motions
    body.unrestrained(free.T @ body.held @ free, free)
    forces: dict[str, Force] = {"hydrostatic": Spring(body.stiffness_parts["hydrostatic"])}
    if radiation:
        forces["radiation"] = RadiationMemory(radiation.model)
    if body.dry_stiffness.any():
        forces["elastic"] = Spring(body.dry_stiffness)
    if body.structural_damping.any():
        forces["structural_damping"] = Damper(body.structural_damping)
    forces |= take_off(body.pto, dof)
    if seas := {direction: sea for direction, sea in waves.items() if sea.omega.size}:
        towards = {direction: replace(body, direction=direction) for direction in seas}
        parts = [sea.amplitude[:, None] * towards[at].coefficients(sea.omega).excitation for at, sea in seas.items()]
        forces["excitation"] = Excitation(together(seas).omega, np.concatenate(parts))
    mass = body.mass + (radiation.added_mass_inf if radiation else body.added_mass_inf)
    return Scene(body.labels, mass, forces, free, heave=_heave(body.labels, mass, free))


def _heave(labels: Sequence[str], mass: FloatArray, free: FloatArray) -> FloatArray:
    """Return y of a unit of heave, of the first body that heaves, or of the first motion there is, shape (free,).

    Where a design holds it together with others it is the motion q = N y next to heave alone, in the kinetic energy of
    the difference: (q - e)^T M (q - e) least for q_heave = 1, whatever units and order the motions have.
    """
    moving = [i for i, row in enumerate(free) if np.abs(row).max() > _UNMOVED * np.abs(free).max()]
    lead = next((i for i in moving if motion_of(labels[i]) == "Heave"), moving[0])
    y, others = free[lead] / (free[lead] @ free[lead]), null_space(free[lead][None])
    besides, apart = free @ others, free @ y - np.eye(len(labels))[lead]
    return np.asarray(y - others @ np.linalg.solve(besides.T @ mass @ besides, besides.T @ mass @ apart))


def together(waves: Mapping[float, Sea]) -> Sea:
    """Return seas of several directions as one, the elevation at the origin."""
    none = Sea(np.zeros(0), np.zeros(0, dtype=complex))
    seas = list(waves.values()) or [none]
    return Sea(np.concatenate([sea.omega for sea in seas]), np.concatenate([sea.amplitude for sea in seas]))
