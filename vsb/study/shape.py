"""Rest shapes of a buoy a study may name in place of the sphere. Pure Python."""

import copy
import csv
import math
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from vsb.errors import ConfigError
from vsb.study.meridian import RestMeridian, capsule, spheroid, through
from vsb.study.quantities import Finite, NonNegative, Positive, Section, within
from vsb.tools.bounded import LARGEST_STUDY, read_bounded

SLENDEREST = 10.0
"""Of the diameter: height, or either of them, beyond which shapes and waves are no longer resolved."""


class Spheroid(Section):
    """An ellipsoid of revolution by its height from pole to pole [m]; the device's radius is that of its equator."""

    height: Annotated[Positive, within(1e-3, 1e4, "m", "no buoy is larger")]


class Capsule(Section):
    """A cylinder between two hemispheres by its length [m], the curvature passing smoothly from one to the other."""

    length: Annotated[NonNegative, within(0.0, 1e4, "m", "no buoy is larger")]


class Shape(Section):
    """One of a spheroid, a capsule and a profile: points (x, z) from top to keel in any unit, scaled to the radius."""

    spheroid: Spheroid | None = None
    capsule: Capsule | None = None
    profile: tuple[tuple[Finite, Finite], ...] | None = Field(
        default=None, json_schema_extra={"anyOf": [{"type": "array"}, {"type": "string"}, {"type": "null"}]}
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [name for name in ("spheroid", "capsule", "profile") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"received {' and '.join(given) or 'none'}: needs one of spheroid, capsule and profile")
        return self

    def meridian(self, radius: float) -> RestMeridian:
        """Return the meridian of a largest radius [m].

        Raises
        ------
        ValueError
            If it bounds no body, or is too slender or too flat.
        """
        if self.spheroid:
            key, found = "spheroid", spheroid(radius, self.spheroid.height)
        elif self.capsule:
            key, found = "capsule", capsule(radius, self.capsule.length)
        else:
            key = "profile"
            try:
                found = through(self.profile or (), radius)
            except ValueError as error:
                raise ValueError(f"shape.profile: {error}") from None
        ratio = (found.highest - found.lowest) / (2 * radius)
        if not 1 / SLENDEREST <= ratio <= SLENDEREST:
            raise ValueError(
                f"shape.{key}: received a height of {ratio:.4g} diameters, needs {1 / SLENDEREST:g} to {SLENDEREST:g}"
            )
        return found


def with_points(raw: Any, source: str) -> Any:
    """Return a study as nested mappings with the points of its shape's profile in place of the file that holds them.

    Parameters
    ----------
    raw : mapping
    source : str
        File of the study, which the profile's name is relative to.

    Raises
    ------
    ConfigError
        If the file cannot be read, or holds no rows of two numbers.
    """
    try:
        name = raw["device"]["shape"]["profile"]
    except (KeyError, TypeError):
        return raw
    if not isinstance(name, str):
        return raw
    found = copy.deepcopy(raw)
    found["device"]["shape"]["profile"] = _points(Path(source).parent / name, f"{source}: device.shape.profile")
    return found


def _points(path: Path, where: str) -> list[list[float]]:
    """Rows x, z of a file, a line of words before them left out."""
    try:
        lines = read_bounded(path, LARGEST_STUDY).decode("utf-8-sig").splitlines()
        rows = [row for row in csv.reader(lines) if any(map(str.strip, row))]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else "no text"
        raise ConfigError(f"{where}: received {path.name}, which cannot be read ({reason}); needs a CSV file") from None
    points = []
    for i, row in enumerate(rows):
        try:
            x, z = map(float, row)
        except ValueError:
            if i == 0:
                continue  # names of the columns
            raise ConfigError(
                f"{where}: received {','.join(row)[:40]!r} in {path.name}, needs two numbers x,z"
            ) from None
        points.append([x, z])
    return points


def shell_mass(meridian: RestMeridian | None, radius: float, thickness: float, density: float) -> float:
    """Return the mass of a shell [kg], a sphere without another meridian."""
    area = 4 * math.pi * radius**2 if meridian is None else meridian.area
    return area * thickness * density


def check_shape(study: Any) -> None:
    """Check that a study, of `vsb.study.study`, asks of another shape than the sphere what is known of it.

    Raises
    ------
    ValueError
        One line with the key, what was received and what is needed.
    """
    device, hydro = study.device, study.hydro
    if hydro.model not in ("linear", "body_exact"):
        raise ValueError(
            f"hydro.model {hydro.model!r}: is known of the sphere alone; device.shape needs linear or body_exact"
        )
    if study.motion != "heave":
        raise ValueError(f"motion {study.motion!r}: is known of the sphere alone; device.shape needs heave")
    if study.uses_panels:
        raise ValueError(
            "hydro.solver: panels are those of the sphere; device.shape needs the spectral solver, without hydro.rows "
            "and in water the keel clears"
        )
    if study.flexible and study.modes.basis != "full":
        raise ValueError(
            f"modes.basis {study.modes.basis!r}: modes of another shape than the sphere have no branches; device.shape "
            "needs full"
        )
    if study.flexible and study.modes.degree == 0:
        raise ValueError("modes.degree 0: device.shape needs at least 1")
    if (study.reference_shape, device.internal_pressure, device.gas) != ("undeformed", 0.0, None):
        raise ValueError(
            "device.shape: prestress and buckling are known of the sphere alone; needs reference_shape: undeformed "
            "and no device.internal_pressure or device.gas"
        )
