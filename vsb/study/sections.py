"""The sections of a study: modes, designs, water, hydrodynamics, seas, simulation; validated and frozen.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from vsb.engine.shell.device import Basis
from vsb.errors import ConfigError
from vsb.keys.quantities import OR_AUTO, Colatitude, Count, Finite, Name, NonNegative, Number, Positive, Section, within

RestShape = Literal["undeformed", "equilibrium"]


DEGREES = (6, 9, 14, 20, 30, 42, 60, 90)
"""Degrees a basis has that follows from a tolerance; few, that studies share their water."""
MODE_TOLERANCE = 0.005
"""Change of mean power, relative, and of gain, absolute, that shell modes left out may cause by default [-]."""


class Modes(Section):
    """Ritz basis of the shell: `paper`, `membrane` or `full`, up to Legendre degree `degree`.

    Without a degree a `full` basis has the least of `DEGREES` that is to leave out no more than `tolerance` of the mean
    power, relative, and of the gain, absolute (`vsb.study.degree`); how much it leaves out is measured.
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
            If it is to follow from the tolerance, as in `vsb.pipeline.plans.with_degree`.
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
