"""The take-off of a study: what it acts on, and by which law.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import math
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    field_validator,
    model_validator,
)

from vsb.engine.hydro.variables import ROTATIONS, motion_of
from vsb.keys.meanings import KEYS
from vsb.keys.quantities import Brief, Colatitude, Finite, Name, NonNegative, Number, Positive, Section, within
from vsb.keys.reading import nearest
from vsb.tools.variables import FORCE, MEMBRANE, MOMENT, PRESSURE, SEVERAL, TENSION, WORK, PortKind
from vsb.tools.words import shortened


class ShellPort(Section):
    """Port at a ring of the shell: its colatitude [degrees], the direction it moves in, what the take-off stands on.

    Against the `frame`, sphere centre and ballast, the heave of the whole buoy does not count.
    """

    colatitude: Colatitude
    direction: Literal["vertical", "radial"] = "vertical"
    against: Literal["sea_bed", "frame"] = "sea_bed"


class BetweenPort(Section):
    """Port between two points of one meridian of the shell, colatitudes [degrees], along the line that joins them."""

    between: tuple[Colatitude, Colatitude]

    @field_validator("between")
    @classmethod
    def _apart(cls, value: tuple[float, float]) -> tuple[float, float]:
        if value[0] == value[1]:
            raise ValueError("needs two different colatitudes")
        return value


class StrainPort(Section):
    """Port that moves with the stretch of the shell between two colatitudes [degrees], by default of all of it.

    `area`: the change of its area [m^2]; `hoop`, `meridional`: the mean strain around the axis or along the meridian.
    """

    strain: Literal["area", "hoop", "meridional"]
    belt: tuple[Colatitude, Colatitude] = (0.0, 180.0)

    @field_validator("belt")
    @classmethod
    def _from_the_top(cls, value: tuple[float, float]) -> tuple[float, float]:
        if value[0] >= value[1]:
            raise ValueError("needs two colatitudes, the upper one first: the smaller from the top pole")
        return value


class HeldHeave(Section):
    """Restraint of the frame, sphere centre and ballast: it does not heave, as on a pile or with stiff tethers."""

    place: Literal["heave"]


class HeldRing(Section):
    """Restraint of a ring of the shell at a colatitude [degrees] against vertical motion, as by tethers all around."""

    place: Literal["ring"]
    colatitude: Annotated[Colatitude, Field(gt=0, lt=180)]


Held = Annotated[HeldHeave | HeldRing, Field(discriminator="place")]
"""What the mooring of all designs restrains, whatever their clamps hold against the frame."""


class LinePort(Section):
    """Port of a straight line to the sea bed, in the plane of the waves: anchor and attachment, each x and z [m].

    The anchor counts from the buoy's axis at rest and still water, the attachment, to the frame, from the sphere's
    centre.
    """

    line_to: tuple[Finite, Finite]
    line_from: tuple[Finite, Finite] = (0.0, 0.0)


def _one_or_many(schema: dict[str, Any]) -> None:
    """Tell editors that one degree of freedom may stand for itself."""
    schema["properties"]["dof"] = {"type": "string"}
    del schema["required"]


class DofPort(Section):
    """Port that moves with a combination of degrees of freedom, b.q = sum of share times amplitude, by their names.

    In a study file `{dof: Heave}` may stand for `{dofs: {Heave: 1.0}}`.
    """

    model_config = ConfigDict(json_schema_extra=_one_or_many)
    dofs: Annotated[dict[str, Finite], Field(min_length=1)]

    @model_validator(mode="before")
    @classmethod
    def _one_alone(cls, raw: Any) -> Any:
        """One degree of freedom may stand for itself."""
        if not isinstance(raw, dict) or set(raw) != {"dof"}:
            return raw
        if not isinstance(raw["dof"], str):
            raise ValueError(f"dof {shortened(repr(raw['dof']))}: needs the name of a degree of freedom")
        return {"dofs": {raw["dof"]: 1.0}}

    @field_validator("dofs")
    @classmethod
    def _moves(cls, value: dict[str, float]) -> dict[str, float]:
        if not any(value.values()):
            raise ValueError("needs a share that is not zero")
        return value


def _port_kind(value: object) -> str:
    """Which kind of port is meant, by its form."""
    if isinstance(value, dict | Section):
        keys = dict(value)
        kinds = {
            "strain": "stretch",
            "between": "points",
            "dofs": "motions",
            "dof": "motions",
            "line_to": "line",
            "line_from": "line",
        }
        return next((kind for key, kind in kinds.items() if key in keys), "shell")
    return "name"


SinglePort = Annotated[
    Annotated[Literal["heave", "surge", "pitch", "volume"], Tag("name")]
    | Annotated[ShellPort, Tag("shell")]
    | Annotated[BetweenPort, Tag("points")]
    | Annotated[StrainPort, Tag("stretch")]
    | Annotated[LinePort, Tag("line")]
    | Annotated[DofPort, Tag("motions")],
    Discriminator(_port_kind),
]
"""One port of a take-off: rigid motion against the sea bed, enclosed volume (pressure against flow), points or
strain of the shell, a line, or a combination of degrees of freedom."""


class DistributedPort(Section):
    """Damper spread over the shell: the power of strain rates in its membrane, damping [s] times its stiffness."""

    distributed: Literal["membrane"]


Matrix = Literal["full", "diagonal"]
AT_ONCE = ("heave", "volume")
"""Ports that are words and may stand beside others."""
PASSIVE = 1e-9
"""Share of a damper matrix, in units of its diagonal, that is round-off [-]."""


class SeveralPorts(Section):
    """Several ports at once and their damper matrix, force of each over rate of each, given or the optimal one.

    A full matrix couples the ports, a diagonal one is a damper at each.
    """

    ports: Annotated[dict[Name, SinglePort], Field(min_length=2, max_length=6)]
    damping: tuple[tuple[Finite, ...], ...] | None = None
    matrix: Matrix = "full"

    @field_validator("ports")
    @classmethod
    def _on_the_axis(cls, value: dict[str, Any]) -> dict[str, Any]:
        for name, port in value.items():
            if not isinstance(port, _AXISYMMETRIC) and port not in AT_ONCE:
                raise ValueError(
                    f"{name}: needs heave, volume, a ring, two points or the strain of a shell; bodies have one port"
                )
            if twin := next((other for other, seen in value.items() if other != name and seen == port), None):
                raise ValueError(f"{name}: received the port of {twin} once more; needs another")
        return value

    @model_validator(mode="after")
    def _passive(self) -> Self:
        if self.damping is None:
            return self
        count, rows = len(self.ports), [list(row) for row in self.damping]
        if any(len(row) != count for row in rows) or len(rows) != count:
            raise ValueError(f"damping: needs {count} rows of {count} numbers, one for each port")
        if any(rows[i][j] != rows[j][i] for i in range(count) for j in range(i)):
            raise ValueError("damping: needs a symmetric matrix: else it is no damper alone")
        if not positive_semidefinite(rows):
            raise ValueError("damping: needs a matrix without negative eigenvalues, or the take-off adds energy")
        return self


_AXISYMMETRIC = (ShellPort, BetweenPort, StrainPort)


def named_ports(pto: "Pto") -> dict[str, Any]:
    """Return several ports by name; of one, or of a damper spread over the shell, none."""
    return dict(pto.port.ports) if isinstance(pto.port, SeveralPorts) else {}


def positive_semidefinite(rows: list[list[float]]) -> bool:
    """Whether a symmetric matrix has no negative eigenvalue, to round-off, by elimination in units of its diagonal."""
    unit = [math.sqrt(max(row[i], 0.0)) or 1.0 for i, row in enumerate(rows)]
    left = [[entry / (unit[i] * unit[j]) for j, entry in enumerate(row)] for i, row in enumerate(rows)]
    while left:
        pivot = max(range(len(left)), key=lambda i: left[i][i])
        head, column = left[pivot][pivot], [row[pivot] for row in left]
        if head <= PASSIVE:
            return all(abs(entry) <= PASSIVE for row in left for entry in row)
        others = [i for i in range(len(left)) if i != pivot]
        left = [[left[i][j] - column[i] * column[j] / head for j in others] for i in others]
    return True


def _how_many(value: object) -> str:
    """Whether one port is meant, several, or the whole shell."""
    keys = dict(value) if isinstance(value, dict | Section) else {}
    return "several" if "ports" in keys else "spread" if "distributed" in keys else "one"


PortChoice = Annotated[
    Annotated[SinglePort, Tag("one")]
    | Annotated[DistributedPort, Tag("spread")]
    | Annotated[SeveralPorts, Tag("several")],
    Discriminator(_how_many),
]
"""What the take-off acts on."""


class Law(NamedTuple):
    """A law of the take-off in time: what it needs, and how a page names it; its force is in `vsb.models.take_off`."""

    needs: tuple[str, ...] = ()  # keys of `pto` without which there is no such law
    has_latching_time: bool = False
    words: str = ""  # of a law whose parameter is no damping: with keys of `pto` and fields of the port's `PortKind`


LAWS = {
    "linear": Law(),
    "saturated": Law(needs=("force_limit",)),
    "coulomb": Law(needs=("force_limit",), words="Coulomb friction of {force_limit:g} {load_unit}"),
    "latching": Law(has_latching_time=True),
    "declutching": Law(has_latching_time=True),
    "causal": Law(words="the optimal causal controller"),
}
DAMPERS = ("linear", "saturated")
"""Laws whose power is that of a damper; that of others is not what linear theory has of the damper."""
if TYPE_CHECKING:
    LawName = str
else:
    LawName = Literal[tuple(LAWS)]
LAWS_OF_PACKAGES = "vsb.take_off_laws"
"""Group of the entry points by which packages declare laws of their own, functions of the port's motion and time."""
LawOfPackage = Annotated[str, Field(pattern=r"^[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*$")]
LawChoice = Annotated[
    Annotated[LawName, Tag("name")] | Annotated[LawOfPackage, Tag("package")],
    Discriminator(lambda value: "package" if isinstance(value, str) and ":" in value else "name"),
]
"""A law by its name, or a function of an installed package, `my_package:law`."""
Tuning = Literal["fixed", "each", "one"]
Limit = Annotated[Number, Field(gt=0)]
STIFFEST = 1e12
"""Damper [N s/m] and spring [N/m] beyond which nothing moves."""
Damper = Annotated[NonNegative, within(0.0, STIFFEST, "N s/m", "this damping locks the take-off")]
Dampers = Annotated[
    Annotated[Damper, Tag("")] | Annotated[dict[Name, Damper], Tag("design")],
    Discriminator(lambda value: "design" if isinstance(value, dict) else ""),
]
"""One damper for all designs, or one for each."""


def port_kind(port: object) -> PortKind:
    """Return what a take-off acts with at a port, given as `pto.port` or its canonical form."""
    said = port if isinstance(port, dict) else dict(port) if isinstance(port, Section) else {}
    dofs = said.get("dofs", {})
    if port == "volume":
        return PRESSURE
    if "distributed" in said:
        return MEMBRANE
    if "ports" in said:
        return SEVERAL
    if strain := said.get("strain"):
        return TENSION if strain == "area" else WORK
    turned = port == "pitch" or (bool(dofs) and all(motion_of(name) in ROTATIONS for name in dofs))
    return MOMENT if turned else FORCE


def entry_point(law: str) -> EntryPoint:
    """Return the entry point that declares a law `my_package:law`.

    Raises `ValueError` if no installed package does.
    """
    known = {one.value.replace(" ", ""): one for one in entry_points(group=LAWS_OF_PACKAGES)}
    if law not in known:
        there, near = ", ".join(sorted(known)) or "there are none", nearest(law, known)
        raise ValueError(
            f"law {law!r}: no installed package declares it; needs an entry point of the group {LAWS_OF_PACKAGES} "
            f"({there})" + (f"; did you mean {near}?" if near else "")
        )
    return known[law]


def distribution_of(entry: EntryPoint) -> str:
    """Return the name and the version of the distribution an entry point is of."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.module


def _several_alone(schema: dict[str, Any]) -> None:
    """Tell editors that several ports stand beside the other keys, with a damper matrix."""
    several = {"type": "object", "minProperties": 2}
    schema["properties"] |= {"ports": several, "matrix": {"enum": ["full", "diagonal"]}}
    damping = schema["properties"]["damping"]
    damping["anyOf"] = [*damping["anyOf"], {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}]


class Control(Brief):
    """What a causal controller knows: `noise` of what it measures, `forecast` seconds of the waves to come.

    The noise is white; it is given by its density over the largest one of the force of the waves at the port.
    `force_rms` [N] is the rms force of the levels `causal` and `damper_same_force`, of several ports that of all forces
    together; without it that is the force limit, or what the optimal damper has.
    """

    noise: Annotated[Positive, within(1e-14, 1.0, "-", "below noise is not resolved, above it hides the waves")] = 1e-5
    forecast: Annotated[NonNegative, within(0.0, 600.0, "s", "no sea is known so far ahead")] = 0.0
    force_rms: Limit = math.inf


class Pto(Brief):
    """Power take-off: damping [N s/m] of all designs or of each, stiffness [N/m] of a spring beside it, its port.

    At the volume damping is in Pa s/m^3, stiffness in Pa/m^3: pressure over flow, over volume. Gas that `device.gas`
    traps is then a chamber between shell and take-off.

    `tuning` says which damper a run has: `fixed`, as given; `each`, the design's own best in its sea; `one`, the
    design's best for the sum of all seas; best by linear theory, beside the spring. Without a damping it is `each`.
    `port: {ports: ...}` acts on several motions at once with a damper matrix; a file says `ports`, `damping` and
    `matrix` beside the other keys.
    `energy_per_cycle` [J/kg] is what a kilogram of the shell converts in a cycle at most, of ports of strain.
    `efficiency` [-] of both directions of power judges the dampers and springs of the control levels, and `causal`.
    `control` says what the controller of the level `causal` knows.

    The law in time: `linear`, whose force saturates at a force limit [N] if there is one; `saturated` insists on the
    limit. `coulomb`: friction of the force limit, the pressure of a hydraulic take-off; the damping is then that of the
    linear response alone. `latching` holds the port after each reversal of its velocity, `declutching` lets it go, both
    for the latching time that maximises mean power in each sea. `causal`: the controller of the level `causal` as a
    filter of measured motion and own force, cut at the force limit. At the stroke limit [m] an end stop begins.
    A law `my_package:law` is a function of an installed package with `parameters` of its own; which `distribution` it
    is of, name and version, is found out.
    """

    model_config = ConfigDict(json_schema_extra=_several_alone)
    damping: Dampers | None = None
    stiffness: Annotated[Finite, within(-STIFFEST, STIFFEST, "N/m", "this spring locks the take-off")] = 0.0
    tuning: Tuning = "fixed"
    efficiency: Annotated[Number, Field(gt=0, le=1)] = 1.0
    port: PortChoice = "heave"
    held: Held | None = None
    law: LawChoice = "linear"
    parameters: dict[str, Finite] = Field(default_factory=dict)
    distribution: str | None = None
    force_limit: Limit = math.inf
    stroke_limit: Limit = math.inf
    energy_per_cycle: Annotated[Positive, within(1e-6, 1e6, "J/kg", "no elastomer converts so much")] | None = None
    control: Control = Control()

    @property
    def limited(self) -> bool:
        """Whether its force or its stroke has a limit."""
        return self.force_limit < math.inf or self.stroke_limit < math.inf

    @property
    def nonlinear(self) -> bool:
        """Whether its force in time is not that of damper and spring alone."""
        return self.law != "linear" or self.limited

    @property
    def of_package(self) -> bool:
        """Whether its law is a function of a package."""
        return ":" in self.law

    @property
    def law_has_damping(self) -> bool:
        """Whether the damping is a parameter of its law; of others it is that of the linear response alone."""
        return self.law in LAWS and not LAWS[self.law].words

    @property
    def has_latching_time(self) -> bool:
        """Whether its law is latching or declutching."""
        return self.law in LAWS and LAWS[self.law].has_latching_time

    @property
    def spring_costs(self) -> bool:
        """Whether its spring loses power, both ways through the efficiency."""
        return bool(self.stiffness) and self.efficiency < 1.0

    @property
    def single_ports(self) -> tuple[Any, ...]:
        """Its ports one by one: that of one port alone."""
        return tuple(self.port.ports.values()) if isinstance(self.port, SeveralPorts) else (self.port,)

    @property
    def place(self) -> "Pto":
        """Its port alone, whatever its dampers."""
        port = self.port.model_copy(update={"damping": None}) if isinstance(self.port, SeveralPorts) else self.port
        return Pto(port=port)

    @property
    def on_shell(self) -> bool:
        """Whether a port of it is at points of the shell, or moves with its strain."""
        return any(isinstance(port, _AXISYMMETRIC) for port in self.single_ports)

    @property
    def moved_by_heave(self) -> bool:
        """Whether the heave of a rigid buoy moves its port, or one of several."""
        return self.held is None and any(_moved_by_heave(port) for port in self.single_ports)

    @property
    def several(self) -> bool:
        """Whether it acts on more than one motion at once, with a damper matrix."""
        return isinstance(self.port, SeveralPorts | DistributedPort)

    @property
    def idle(self) -> bool:
        """Whether the damping given to some design is zero."""
        given = self.damping.values() if isinstance(self.damping, dict) else [self.damping]
        return 0.0 in given

    @property
    def has_damper(self) -> bool:
        """Whether a damper is given, or the damper matrix of several ports."""
        return self.damping is not None or (isinstance(self.port, SeveralPorts) and self.port.damping is not None)

    def damper(self, design: str) -> float | None:
        """Return the damping given to a design [N s/m]; none where there is none."""
        return self.damping[design] if isinstance(self.damping, dict) else self.damping

    @field_validator("held", mode="before")
    @classmethod
    def _no_point(cls, raw: Any) -> Any:
        """A shell has no response to a force at a point."""
        if isinstance(raw, dict) and raw.get("place") == "point":
            raise ValueError(
                "place 'point': a point force on a thin shell has no limit as shell modes are added; needs ring, with "
                "a colatitude between 0 and 180"
            )
        return raw

    @model_validator(mode="before")
    @classmethod
    def _tuned_by_default(cls, raw: Any) -> Any:
        """Without a damping, tuning decides; the damping of several ports is their matrix."""
        if isinstance(raw, dict) and "ports" in raw:
            own = {key: raw[key] for key in ("ports", "damping", "matrix") if raw.get(key) is not None}
            raw = {key: value for key, value in raw.items() if key not in ("ports", "damping", "matrix")}
            raw = {**raw, "port": own}
        if isinstance(raw, dict) and raw.get("damping") is None:
            given = isinstance(raw.get("port"), dict) and raw["port"].get("damping") is not None
            return {"tuning": "fixed" if given else "each", **raw}
        return raw

    @model_validator(mode="before")
    @classmethod
    def _declared(cls, raw: Any) -> Any:
        """A law of a package is known by its distribution, too, so that another version is another law."""
        law = raw.get("law") if isinstance(raw, dict) else None
        if not (isinstance(law, str) and ":" in law) or raw.get("distribution") is not None:
            return raw
        return {**raw, "distribution": distribution_of(entry_point(law))}

    @model_validator(mode="after")
    def _of_package(self) -> Self:
        """What the law of a package does itself is not to be given beside it."""
        if not self.of_package:
            if given := [name for name in ("parameters", "distribution") if getattr(self, name)]:
                raise ValueError(f"{given[0]}: are of a law of a package, my_package:law; received law {self.law}")
            return self
        if self.limited or self.stiffness:
            raise ValueError(
                f"law {self.law!r}: is the whole force; needs no force_limit, stroke_limit or stiffness beside it"
            )
        return self

    @model_validator(mode="after")
    def _given(self) -> Self:
        if isinstance(self.port, SeveralPorts):
            if self.damping is not None:
                raise ValueError("damping: of several ports needs a matrix, as pto: {ports: ..., damping: [[...]]}")
            if (self.tuning == "fixed") != (self.port.damping is not None):
                raise ValueError("tuning: of several ports is fixed with a damping matrix, each or one without")
        elif self.tuning == "fixed" and self.damping is None:
            raise ValueError(f"damping: missing; tuning fixed needs one in {port_kind(self.port).damping_unit}")
        if self.law == "causal" and (self.control.forecast or self.stiffness):
            raise ValueError(
                f"law 'causal': measures motion and force alone, and is the whole force; received control.forecast "
                f"{self.control.forecast:g} s and stiffness {self.stiffness:g}, needs both to be 0"
            )
        return self

    @model_validator(mode="after")
    def _linear_at_several(self) -> Self:
        if self.several and (self.nonlinear or self.stiffness or self.efficiency < 1.0):
            raise ValueError(
                "port: several ports, or a damper spread over the shell, have a damper matrix alone; needs law: linear "
                "without limits, stiffness and efficiency: of several ports the level causal keeps the rms of all "
                "forces together of the optimal matrix, and one port alone has force_limit"
            )
        return self

    @model_validator(mode="after")
    def _forces_alike(self) -> Self:
        if self.control.force_rms == math.inf or not self.several:
            return self
        units = {port_kind(port).load_unit for port in named_ports(self).values()}
        if len(units) != 1:
            there = f"ports in {', '.join(sorted(units))}" if units else "a damper spread over the shell"
            raise ValueError(f"control.force_rms: received {there}; needs one port, or several with forces of one unit")
        return self

    @model_validator(mode="after")
    def _of_strain(self) -> Self:
        strained = all(isinstance(port, StrainPort | DistributedPort) for port in self.single_ports)
        if self.energy_per_cycle is not None and not strained:
            raise ValueError("energy_per_cycle: is of a material that is strained; needs ports of strain alone")
        return self

    @model_validator(mode="after")
    def _needed_by_the_law(self) -> Self:
        for name in LAWS[self.law].needs if self.law in LAWS else ():
            if getattr(self, name) == DEFAULTS[name]:
                key = KEYS["Pto"][name]
                unit = getattr(port_kind(self.port), key.at_port) if key.at_port else key.unit
                raise ValueError(f"{name}: missing; law {self.law} needs one in {unit}")
        return self


def _moved_by_heave(port: object) -> bool:
    """Whether the heave of a rigid buoy moves a port."""
    if isinstance(port, DofPort):
        return set(port.dofs) == {"Heave"}
    if not isinstance(port, ShellPort):
        return port == "heave"
    return port.against == "sea_bed" and (port.direction, port.colatitude) != ("radial", 90)


DEFAULTS = {name: field.get_default(call_default_factory=True) for name, field in Pto.model_fields.items()}
"""Values of the keys a canonical take-off leaves out."""
