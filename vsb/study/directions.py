"""Directions a buoy of a study moves in, and what they need of it: motion, mooring, balance. Pure Python."""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator

from vsb.engine.motion.take_off import LinePort
from vsb.keys.quantities import Finite
from vsb.study.sections import DEGREES

Motion = Literal["heave", "planar", "free"]
"""Heave alone; surge, heave and pitch, with shell modes of azimuthal orders from 0 on; all six, in any waves."""
RIGID = ("surge", "sway", "heave", "roll", "pitch", "yaw")
"""Rigid motions in the order of a mooring's rows."""
IN_PLANE = (0, 2, 4)
"""Of these, the ones of planar motion."""
_UNEVEN = 1e-9  # of its largest number: asymmetry of a matrix that was rounded


def _rows(value: object) -> object:
    """Six numbers are the diagonal of a matrix."""
    if not isinstance(value, list | tuple) or len(value) != 6:
        raise ValueError("needs six rows of six numbers, or the six of its diagonal")
    if not any(isinstance(one, list | tuple) for one in value):
        return [[one if i == j else 0.0 for j in range(6)] for i, one in enumerate(value)]
    return value


def _symmetric(value: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
    """Refuse what is no spring."""
    largest = max(abs(one) for row in value for one in row)
    if any(abs(value[i][j] - value[j][i]) > _UNEVEN * largest for i in range(6) for j in range(i)):
        raise ValueError("needs a symmetric matrix, because a spring has an energy")
    return value


_Row = tuple[Finite, Finite, Finite, Finite, Finite, Finite]
_Rows = tuple[_Row, _Row, _Row, _Row, _Row, _Row]
Mooring = Annotated[_Rows, BeforeValidator(_rows, json_schema_input_type=_Rows | _Row), AfterValidator(_symmetric)]
"""Stiffness over `RIGID` motions about the sphere's centre [N/m, N, N m]; of six numbers they are the diagonal."""


def check_directions(study: Any) -> None:
    """Check that the motion of a study, of `vsb.study.study`, suits its device, its shell and its model.

    Raises `ValueError`: one line with the key, what was received and what is needed.
    """
    _check_drag(study)
    if study.motion == "heave":
        _check_heave(study)
        return
    device, hydro = study.device, study.hydro
    needed = ("centre_of_mass", "ballast_inertia", *(("ballast_yaw_inertia",) if study.motion == "free" else ()))
    if absent := [key for key in needed if getattr(device, key) is None]:
        reason = (
            "yaw turns the ballast, too"
            if absent[0] == "ballast_yaw_inertia"
            else ("a ballast at the sphere's centre has no pitch stiffness")
        )
        raise ValueError(f"device.{absent[0]}: missing; motion {study.motion!r} needs it, because {reason}")
    if hydro.model != "linear":
        raise ValueError(f"hydro.model {hydro.model!r}: follows heave alone; motion {study.motion!r} needs linear")
    if study.uses_panels:
        raise ValueError(
            f"hydro.solver: panels solve axisymmetric motions alone; motion {study.motion!r} needs the spectral "
            "solver, without hydro.rows and in water the keel clears"
        )
    if study.flexible and study.reference_shape != "undeformed":
        raise ValueError(
            f"motion {study.motion!r}: knows shells about the undeformed sphere; needs reference_shape: undeformed"
        )
    degree = DEGREES[0] if study.modes.degree is None else study.modes.degree  # where it is to follow: the least
    if study.flexible and study.modes.order > max(1, degree):
        raise ValueError(
            f"modes.order {study.modes.order}: needs at most modes.degree = {degree}, because P_n^m has "
            "no order above its degree"
        )
    _check_mooring(study)
    _check_line(study)


def check_heading(study: Any, direction: float, where: str) -> None:
    """Check that a buoy of a study knows waves going to a direction [degrees]; raises `ValueError`."""
    received = f"{where}.direction {direction:g} degrees"
    if study.motion == "heave" and direction:
        raise ValueError(
            f"{received}: a buoy of revolution answers waves of all directions alike; remove it, or describe a body, "
            "or let the buoy surge: motion: free"
        )
    if study.motion == "planar" and direction % 180:
        raise ValueError(f"{received}: motion 'planar' knows waves along its plane, 0 and 180; needs motion: free")


def check_spreading(study: Any, where: str) -> None:
    """Check that a buoy of a study feels waves from several directions, and that its forces know them.

    Raises `ValueError`.
    """
    if study.motion == "heave":
        raise ValueError(
            f"{where}: a buoy of revolution that heaves answers waves of all directions alike; remove it, or "
            "let the buoy surge: motion: planar or free"
        )
    if study.drag is not None:
        raise ValueError(f"{where}: drag is past the flow of waves of one direction; needs no drag")


def _check_heave(study: Any) -> None:
    """Heave alone has axisymmetric modes, no mooring and no port in another direction."""
    if study.modes.order > 1:
        raise ValueError(
            f"modes.order {study.modes.order}: motion 'heave' has axisymmetric modes; needs motion: planar"
        )
    if study.mooring is not None:
        raise ValueError("mooring: motion 'heave' has none; needs motion: planar, or pto.stiffness")
    if study.pto.port in ("surge", "pitch") or isinstance(study.pto.port, LinePort):
        raise ValueError("pto.port: motion 'heave' moves it in no other direction; needs motion: planar")


def _check_drag(study: Any) -> None:
    """Drag brakes what moves."""
    moving = {"heave": ("heave",), "planar": tuple(RIGID[i] for i in IN_PLANE), "free": RIGID}[study.motion]
    for name in (name for name in (study.drag.directions if study.drag else ()) if name not in moving):
        raise ValueError(f"drag.{name}: motion {study.motion!r} has none; needs drag of {', '.join(moving)}")


def _check_mooring(study: Any) -> None:
    """A mooring of planar motion must not couple the plane of the waves with motions out of it."""
    rows = (study.mooring or ()) if study.motion == "planar" else ()
    for i in IN_PLANE:
        for j in set(range(6)) - set(IN_PLANE):
            if rows and rows[i][j]:
                raise ValueError(
                    f"mooring: received {rows[i][j]:g} between {RIGID[i]} and {RIGID[j]}, which motion "
                    f"{study.motion!r} does not have; needs 0, or motion: free"
                )


def _check_line(study: Any) -> None:
    """A line of the take-off has a length, and ends in the water or at its bed."""
    line = study.pto.port
    if not isinstance(line, LinePort):
        return
    (x, z), (from_x, from_z), depth = line.line_to, line.line_from, study.water.depth
    if not -depth <= z < 0:
        raise ValueError(f"pto.port.line_to: received z = {z:g} m; needs one below still water and above the sea bed")
    if math.hypot(from_x, from_z) > study.device.radius:
        raise ValueError(
            f"pto.port.line_from: received {list(line.line_from)} m; needs a point inside the sphere, of radius "
            f"{study.device.radius:g} m"
        )
    if math.hypot(x, z - study.centre_height) <= study.device.radius:
        raise ValueError(f"pto.port.line_to: received {list(line.line_to)} m; needs an anchor outside the sphere")
