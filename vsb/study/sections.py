"""Sections of a study, validated and frozen: modes, designs, hydrodynamics, drag, directions; what one needs of others.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from vsb.engine.motion.take_off import LinePort, Pto
from vsb.engine.shell.device import Basis, Shape, cap_volume
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.keys.quantities import OR_AUTO, Colatitude, Count, Finite, Name, NonNegative, Number, Positive, Section, within

RestShape = Literal["undeformed", "equilibrium"]


DEGREES = (6, 9, 14, 20, 30, 42, 60, 90, 120)
"""Degrees a basis has that follows from a tolerance; few, that studies share their water."""
MODE_TOLERANCE = 0.005
"""Change of mean power, relative, and of gain, absolute, that shell modes left out may cause by default [-]."""


class Modes(Section):
    """Ritz basis of the shell: `paper`, `membrane` or `full`, up to Legendre degree `degree`.

    Without a degree a `full` basis has the least of `DEGREES` that is to leave out no more than `tolerance` of the mean
    power, relative, and of the gain, absolute (`vsb.study.resolution`); how much it leaves out is measured.
    `paper` and `membrane` leave out bending, so no degree of theirs converges: it is 6 unless given.

    Beside axisymmetric shapes, where the buoy moves in more directions than heave, those up to azimuthal order `order`.
    """

    basis: Basis = "full"
    degree: Annotated[Count, Field(ge=0, le=DEGREES[-1])] | None = None
    tolerance: Annotated[Number, Field(ge=1e-4, le=0.1)] = MODE_TOLERANCE
    order: Annotated[Count, Field(ge=1, le=8)] = 1

    @model_validator(mode="before")
    @classmethod
    def _degree_without_bending(cls, value: object) -> object:
        if isinstance(value, dict) and value.get("basis") in ("paper", "membrane"):
            return {"degree": DEGREES[0]} | value
        return value

    @property
    def without_tolerance(self) -> "Modes":
        """The basis without the tolerance that its degree follows from."""
        return self.model_copy(update={"tolerance": MODE_TOLERANCE})

    @property
    def max_degree(self) -> int:
        """Highest Legendre degree.

        Raises
        ------
        ConfigError
            If it is to follow from the tolerance, as a plan `with_degree` has it.
        """
        if self.degree is None:
            raise ConfigError(
                f"modes.degree: received none, so it follows from modes.tolerance {self.tolerance:g}; needs the study "
                "as `vsb.pipeline.plans.plan_of` returns it, or a degree"
            )
        return self.degree


class Design(Section):
    """One buoy of the comparison: rigid or flexible, clamped at colatitudes [degrees] from the top pole."""

    flexible: bool = True
    clamp: tuple[Colatitude, ...] = ()

    @field_validator("clamp", mode="before", json_schema_input_type=Colatitude | tuple[Colatitude, ...])
    @classmethod
    def _one_or_many(cls, value: object) -> object:
        return value if isinstance(value, list | tuple) else (value,)

    @model_validator(mode="after")
    def _clamp_needs_a_shell(self) -> Self:
        if self.clamp and not self.flexible:
            raise ValueError(
                f"clamp {list(self.clamp)}: a rigid design (flexible: false) has no shell to clamp; "
                "remove one of the two"
            )
        return self


POWER_TOLERANCE = 0.01
"""Error of mean absorbed power that model auto may cause, unless another is given [-]."""


class Hydro(Section):
    """Hydrodynamic model, tolerance [-], highest frequency solved [rad/s], optional tabulated frequencies [rad/s].

    `linear`: radiation, diffraction and hydrostatics about the mean shape, from BEM. `body_exact`: hydrostatics and
    Froude-Krylov forces on the instantaneous wet shell, the rest linear. `assumed_pressure`: hydrostatics and a uniform
    pressure [Pa] of the wave's period on the instantaneous wet shell, no radiation: the paper's loading. `auto`: for
    every design and sea the cheapest of linear and body-exact, shell modes and memory order, that changes mean absorbed
    power by less than `power_tolerance` [-], 0.01 if not given. The solver is `spectral` (no mesh) or `panels`
    (capytaine); `auto` takes panels with `rows`, or where the keel nearly touches the bottom. By default the
    other solver is `witness`, on the mean and on deformed shapes; `none` leaves it out.
    """

    model: Literal["linear", "body_exact", "assumed_pressure", "auto"] = "linear"
    pressure: Annotated[NonNegative, within(0.0, 1e8, "Pa", "this exceeds a thousand atmospheres")] | None = None
    power_tolerance: Annotated[Number, Field(gt=0, le=0.5)] | None = None
    solver: Literal["auto", "spectral", "panels"] = "auto"
    tolerance: Annotated[Number, Field(ge=1e-6, le=0.02)] = 1e-3
    omega_max: Annotated[Positive, OR_AUTO, Field(json_schema_extra={"default": "auto"})] = 12.0
    omega: tuple[Positive, ...] = ()
    rows: Annotated[Count, Field(ge=6, le=160)] | None = None
    accept: tuple[Name, ...] = ()
    witness: Literal["auto", "none"] = "auto"

    @model_validator(mode="after")
    def _keys_of_the_model(self) -> Self:
        if self.model == "assumed_pressure" and self.pressure is None:
            raise ValueError("pressure: missing; model assumed_pressure needs its amplitude in Pa")
        if self.model != "assumed_pressure" and self.pressure is not None:
            raise ValueError(f"pressure {self.pressure:g} Pa: only model assumed_pressure has one; remove it")
        if self.model != "auto" and self.power_tolerance is not None:
            raise ValueError(f"power_tolerance {self.power_tolerance:g}: only model auto has one; remove it")
        return self

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if list(self.omega) != sorted(set(self.omega)):
            raise ValueError(f"omega {list(self.omega)}: frequencies must ascend without repetition")
        return self


Measure = Literal["displacement_pp", "velocity_pp", "pto_force_pp", "power_peak", "power_mean", "energy"]


class Published(Section):
    """Figures published elsewhere, printed beside ours: design -> measure -> value, SI units."""

    source: str
    values: dict[str, dict[Measure, Finite]]


# quadratic drag -------------------------------------------------------------------------------------------------------


Coefficient = Annotated[NonNegative, within(0.0, 100.0, "", "this exceeds any shape")]


class Plate(Section):
    """Quadratic drag rho C A |u| u/2 on one direction: coefficient C [-] and reference area A [m^2]."""

    coefficient: Coefficient
    area: Positive


class Vane(Plate):
    """Quadratic drag on a rotation: that of a plate at a distance from the sphere's centre [m], rho C A l^3 |w| w/2."""

    lever: Positive


BodyDrag = Annotated[dict[Name, Vane | Plate], Field(min_length=1)]
"""Quadratic drag on degrees of freedom of a body, by name; of the body's velocity alone, the waves' flow left out."""


class Drag(Section):
    """Quadratic drag on the buoy's rigid motion past the water, whose flow is that of the undisturbed waves."""

    surge: Plate | None = None
    sway: Plate | None = None
    heave: Plate | None = None
    roll: Vane | None = None
    pitch: Vane | None = None
    yaw: Vane | None = None

    @model_validator(mode="after")
    def _acts(self) -> Self:
        if not self.directions:
            raise ValueError(f"needs one of {', '.join(type(self).model_fields)}")
        return self

    @property
    def plates(self) -> Mapping[str, Plate]:
        """What brakes each degree of freedom it acts on."""
        return {name.capitalize(): plate for name, plate in self.directions.items()}

    @property
    def directions(self) -> Mapping[str, Plate]:
        """The rigid motions it acts on, by name."""
        return {name: plate for name in type(self).model_fields if isinstance(plate := getattr(self, name), Plate)}


def check_followed(model: str, method: str, pto: Pto) -> None:
    """Check that the hydrodynamic model, the method in time and the take-off of a study can follow a drag.

    Raises `ValueError`.
    """
    if model not in ("linear", "body_exact"):
        raise ValueError(f"drag: hydro.model {model!r} knows none; needs linear or body_exact")
    if pto.nonlinear:
        raise ValueError(
            f"drag: cannot be followed beside a nonlinear take-off, received law {pto.law} with force_limit "
            f"{pto.force_limit:g} N and stroke_limit {pto.stroke_limit:g} m; needs law: linear without limits"
        )
    if method != "auto":
        raise ValueError(f"simulation.method {method!r}: cannot follow a drag; needs auto")


# directions of motion -------------------------------------------------------------------------------------------------


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
    moving = {"heave": ("heave",), "planar": tuple(RIGID[i] for i in IN_PLANE), "free": RIGID}[study.motion]
    for name in (name for name in (study.drag.directions if study.drag else ()) if name not in moving):
        raise ValueError(f"drag.{name}: motion {study.motion!r} has none; needs drag of {', '.join(moving)}")
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


# what follows from the size of the buoy, and what is known of its shape -----------------------------------------------


def check_shape(study: Any) -> None:
    """Check that a study, of `vsb.study.study`, asks of another shape than the sphere what is known of it.

    Raises `ValueError`: one line with the key, what was received and what is needed.
    """
    device, hydro = study.device, study.hydro
    if device.shape is None:
        return
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
    if study.reference_shape == "equilibrium" and device.material.rubber:
        raise ValueError(
            "reference_shape 'equilibrium': wrinkles of rubber are known of the sphere alone; device.shape with a "
            "material of rubber needs undeformed"
        )


HEAVIEST = 1e300
"""Mass [kg] that stands in where the real one cannot be computed."""


BAND = 5.4
"""omega_max over sqrt(g/r): beyond it waves are shorter than a quarter of the radius, and the damping has died out."""


def resolved(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study as nested mappings with what it leaves to its size: mass by draft or half immersion, omega_max.

    What is needed for it and wrong, or missing, is left to be found by its own check. Raises `ValueError` if mass and
    draft are both given, or the draft is none of this sphere.
    """
    try:
        radius = _number(raw["device"], "radius", None)
        density, gravity = (_number(raw.get("water", {}), key, getattr(Water(), key)) for key in ("density", "gravity"))
    except (KeyError, TypeError, ValueError, AttributeError):
        return _without_words(raw)
    return {**raw, "device": _with_mass(raw["device"], radius, density), "hydro": _with_band(raw, radius, gravity)}


def _number(section: Any, key: str, default: float | None) -> float:
    """A number above zero of a section, which may be validated already."""
    value = section.get(key, default) if isinstance(section, Mapping) else getattr(section, key)
    if isinstance(value, bool) or not 0 < float(value) < math.inf:
        raise ValueError
    return float(value)


def _with_mass(device: Any, radius: float, density: float) -> Any:
    """The section `device` with its mass."""
    if not isinstance(device, Mapping) or ("mass" in device and "draft" not in device):
        return device
    if "mass" in device:
        raise ValueError("device: received mass and draft, needs one of them")
    if device.get("shape") is not None:
        return _with_mass_of_shape(device, radius, density)
    draft = device.get("draft", radius)
    if isinstance(draft, bool) or not isinstance(draft, int | float) or not 0 < draft < 2 * radius:
        raise ValueError(
            f"device.draft: received {draft!r}, needs more than 0 and less than two radii, {2 * radius:g} m"
        )
    others = {key: value for key, value in device.items() if key != "draft"}
    return {**others, "mass": density * cap_volume(radius, draft / radius)}


def _with_mass_of_shape(device: Mapping[str, Any], radius: float, density: float) -> Any:
    """The same of another shape than the sphere; half immersed is half of its volume."""
    try:
        shape = device["shape"] if isinstance(device["shape"], Shape) else Shape.model_validate(device["shape"])
        rest = shape.meridian(radius)
    except ValueError:
        return {
            "mass": 1.0,
            **{key: value for key, value in device.items() if key != "draft"},
        }  # reported by its check
    draft, height = device.get("draft"), rest.highest - rest.lowest
    if "draft" in device and (isinstance(draft, bool) or not isinstance(draft, int | float) or not 0 < draft < height):
        raise ValueError(f"device.draft: received {draft!r}, needs more than 0 and less than the height, {height:g} m")
    volume = rest.volume / 2 if draft is None else rest.volume_below(rest.lowest + draft)
    return {**{key: value for key, value in device.items() if key != "draft"}, "mass": density * volume}


def _with_band(raw: Mapping[str, Any], radius: float, gravity: float) -> Any:
    """The section `hydro` with its highest frequency, which is not among the fields set if it is automatic."""
    hydro, omega_max = raw.get("hydro", {}), float(f"{BAND * math.sqrt(gravity / radius):.2g}")
    if isinstance(hydro, Mapping) and hydro.get("omega_max", "auto") == "auto":
        try:
            hydro = Hydro.model_validate({key: value for key, value in hydro.items() if key != "omega_max"})
        except ValueError:
            return {**hydro, "omega_max": omega_max}  # reported by its check
    if not isinstance(hydro, Hydro) or "omega_max" in hydro.model_fields_set:
        return hydro
    found = hydro.model_copy(update={"omega_max": omega_max})
    found.model_fields_set.discard("omega_max")
    return found


def _without_words(raw: Mapping[str, Any]) -> dict[str, Any]:
    """A study without the omega_max that cannot be computed, and with a mass that passes the checks of the device."""
    found, hydro, device = dict(raw), raw.get("hydro"), raw.get("device")
    if isinstance(hydro, Mapping) and hydro.get("omega_max") == "auto":
        found["hydro"] = {key: value for key, value in hydro.items() if key != "omega_max"}
    if isinstance(device, Mapping):
        found["device"] = {"mass": HEAVIEST, **{key: value for key, value in device.items() if key != "draft"}}
    return found


def check_rubber(model: str, method: str, pto: Pto) -> None:
    """Check that the hydrodynamic model, the method in time and the take-off of a study can follow a shell of rubber.

    Raises `ValueError`.
    """
    if model == "assumed_pressure":
        raise ValueError(f"hydro.model {model!r}: knows no rubber; needs linear, body_exact or auto")
    if model == "body_exact" and method != "auto":
        raise ValueError(f"simulation.method {method!r}: cannot follow a shell of rubber; needs auto")
    if model == "body_exact" and pto.nonlinear:
        raise ValueError(
            "device.material: with hydro.model 'body_exact' rubber cannot be followed beside a nonlinear take-off, "
            f"received law {pto.law} with force_limit {pto.force_limit:g} N and stroke_limit {pto.stroke_limit:g} m; "
            "needs law: linear without limits, or hydro.model: linear"
        )
