"""The sections of a study: modes, designs, water, hydrodynamics, seas, simulation; validated and frozen.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import math
from abc import abstractmethod
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from vsb.study.quantities import OR_AUTO, Count, Extended, Finite, Name, NonNegative, Number, Positive, Section, within

DEEPEST = 2e4
"""No sea is deeper [m]."""
RestShape = Literal["undeformed", "equilibrium"]
Colatitude = Annotated[Number, Field(ge=0, le=180)]


class Modes(Extended):
    """Ritz basis of the shell: `paper`, `membrane` or `full`, up to Legendre degree `degree`.

    Beside axisymmetric shapes, where the buoy moves in more directions than heave, those up to azimuthal order `order`.
    """

    LATER = ("order",)
    basis: Literal["paper", "membrane", "full"] = "membrane"
    degree: Annotated[Count, Field(ge=0, le=40)] = 6
    order: Annotated[Count, Field(ge=1, le=8)] = 1


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


class Water(Section):
    """Density [kg/m^3], depth [m] (`.inf` for deep water), gravity [m/s^2]."""

    density: Annotated[Positive, within(1.0, 2e4, "kg/m^3", "mercury has 13 534 kg/m^3")] = 1025.0
    depth: Annotated[Number, Field(gt=0)] = math.inf
    gravity: Annotated[Positive, within(0.01, 300.0, "m/s^2", "on the sun it is 274 m/s^2")] = 9.81

    @field_validator("depth")
    @classmethod
    def _on_earth(cls, value: float) -> float:
        if DEEPEST < value < math.inf:
            raise ValueError(f"needs at most {DEEPEST:g} m, or .inf for deep water")
        return value


POWER_TOLERANCE = 0.01
"""Error of mean absorbed power that model auto may cause, unless another is given [-]."""


class Hydro(Extended):
    """Hydrodynamic model, tolerance [-], highest frequency solved [rad/s], optional tabulated frequencies [rad/s].

    `linear`: radiation, diffraction and hydrostatics about the mean shape, from BEM. `body_exact`: hydrostatics and
    Froude-Krylov forces on the instantaneous wet shell, the rest linear. `assumed_pressure`: hydrostatics and a uniform
    pressure [Pa] of the wave's period on the instantaneous wet shell, no radiation: the paper's loading. `auto`: for
    every design and sea the cheapest of linear and body-exact, shell modes and memory order, that changes mean absorbed
    power by less than `power_tolerance` [-], 0.01 if not given. The solver is `spectral` (no mesh) or `panels`
    (capytaine); `auto` takes panels with `rows`, or where the keel nearly touches the bottom. By default the
    other solver is `witness`, on the mean and on deformed shapes; `none` leaves it out.
    """

    LATER = ("witness",)
    model: Literal["linear", "body_exact", "assumed_pressure", "auto"] = "linear"
    pressure: Annotated[NonNegative, within(0.0, 1e8, "Pa", "no wave presses like a thousand atmospheres")] | None = (
        None
    )
    power_tolerance: Annotated[Number, Field(gt=0, le=0.5)] | None = None
    solver: Literal["auto", "spectral", "panels"] = "auto"
    tolerance: Annotated[Number, Field(ge=1e-6, le=0.1)] = 1e-3
    omega_max: Annotated[Positive, OR_AUTO] = 12.0
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


Height = Annotated[Positive, within(1e-9, 100.0, "m", "the highest wave ever measured had 30 m, molecules have 1e-9 m")]
Period = Annotated[Positive, within(1e-3, 1e7, "s", "waves of gravity take longer than ripples and less than seasons")]


class StillWater(Section):
    """No waves: free decay."""

    kind: Literal["still"]

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return "still"

    @property
    def description(self) -> str:
        """The sea in words."""
        return "still water"


class RegularWave(Section):
    """Sine wave: amplitude [m], period [s]."""

    kind: Literal["regular"]
    amplitude: Height
    period: Period

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return f"regular_A{self.amplitude:g}_T{self.period:g}"

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"regular waves of {self.amplitude:g} m amplitude and {self.period:g} s period"

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return 2 * math.pi / self.period

    @property
    def fastest(self) -> float:
        """Its one frequency [rad/s]."""
        return self.omega


class IrregularSea(Section):
    """A sea of many components: significant height [m], seed of the random phases, number of realisations.

    Realisations have seeds one after the other; a study lists each as a sea of its own and takes statistics over all.
    """

    hs: Height
    seed: Annotated[Count, Field(ge=0)] = 1
    realisations: Annotated[Count, Field(ge=1, le=1000)] = 1

    @model_validator(mode="after")
    def _seeds_fit_a_file_name(self) -> Self:
        if self.seed + self.realisations > 2**32:
            raise ValueError(f"seed of {len(str(self.seed))} digits: needs at most 2^32 - realisations")
        return self

    @property
    @abstractmethod
    def family(self) -> str:
        """Name of the sea without its seed."""

    @property
    @abstractmethod
    def omega(self) -> float:
        """Frequency of the peak or of the middle of the band [rad/s]."""

    @property
    def reach(self) -> tuple[float, float]:
        """Frequencies the sea must find solved [rad/s]: below 0.4 times the peak there is less than 1e-10 of it."""
        return 0.4 * self.omega, self.omega

    @property
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""
        return 4.3 * self.omega

    @property
    def memory(self) -> float:
        """Time after which the waves have forgotten what they were [s]: ten peak periods."""
        return 20 * math.pi / self.omega

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return f"{self.family}_s{self.seed}"


class Jonswap(IrregularSea):
    """JONSWAP sea: significant height [m], peak period [s], peakedness [-], random seed."""

    kind: Literal["jonswap"]
    tp: Period
    gamma: Annotated[Number, Field(ge=1, le=10)] = 3.3

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return f"jonswap_Hs{self.hs:g}_Tp{self.tp:g}_g{self.gamma:g}"

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"a JONSWAP sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s"

    @property
    def omega(self) -> float:
        """Peak angular frequency [rad/s]."""
        return 2 * math.pi / self.tp


class PiersonMoskowitz(IrregularSea):
    """Fully developed sea of Pierson and Moskowitz: significant height [m], peak period [s], random seed."""

    kind: Literal["pierson_moskowitz"]
    tp: Period

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return f"pierson_moskowitz_Hs{self.hs:g}_Tp{self.tp:g}"

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"a Pierson-Moskowitz sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s"

    @property
    def omega(self) -> float:
        """Peak angular frequency [rad/s]."""
        return 2 * math.pi / self.tp


class WhiteNoise(IrregularSea):
    """Sea of constant spectral density over a band [rad/s]: significant height [m], random seed."""

    kind: Literal["white_noise"]
    band: tuple[Positive, Positive]

    @field_validator("band")
    @classmethod
    def _ascending(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 1.01 * value[0] <= value[1]:
            raise ValueError("needs the lowest frequency first, then one at least 1 % higher, in rad/s")
        return value

    @property
    def reach(self) -> tuple[float, float]:
        """Frequencies the sea must find solved [rad/s]: its band."""
        return self.band

    @property
    def fastest(self) -> float:
        """Highest frequency of the band [rad/s]."""
        return self.band[1]

    @property
    def memory(self) -> float:
        """Time after which the waves have forgotten what they were [s]: ten periods, or twice 2 pi over the band."""
        return max(20 * math.pi / self.omega, 4 * math.pi / (self.band[1] - self.band[0]))

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return f"white_noise_Hs{self.hs:g}_w{self.band[0]:g}-{self.band[1]:g}"

    @property
    def description(self) -> str:
        """The sea in words."""
        low, high = self.band
        return f"white noise of {low:g} to {high:g} rad/s and Hs = {self.hs:g} m"

    @property
    def omega(self) -> float:
        """Frequency in the middle of the band [rad/s]."""
        return 0.5 * (self.band[0] + self.band[1])


Irregular = Jonswap | PiersonMoskowitz | WhiteNoise
Wave = Annotated[StillWater | RegularWave | Irregular, Field(discriminator="kind")]


class Simulation(Section):
    """Time-domain run: duration [s], window of the statistics [s], initial heave [m] and heave velocity [m/s]."""

    duration: Annotated[Positive, within(1e-3, 2e5, "s", "no sea stays the same for two days")] = 60.0
    window: tuple[NonNegative, Positive] = (40.0, 60.0)
    initial_position: Annotated[Finite, within(-1e4, 1e4, "m", "no buoy starts out of sight of the sea")] = 0.0
    initial_velocity: Annotated[Finite, within(-1e3, 1e3, "m/s", "faster it would be a shell of another kind")] = 0.0
    tolerance: Annotated[Number, Field(ge=1e-12, le=0.1)] = 1e-6
    method: Literal["auto", "exact", "convolution", "exponential", "structure_preserving"] = "auto"

    @model_validator(mode="after")
    def _window_inside(self) -> Self:
        start, end = self.window
        if not start < end <= self.duration:
            raise ValueError(f"window {list(self.window)}: needs 0 <= start < end <= duration = {self.duration:g} s")
        return self


Measure = Literal["displacement_pp", "velocity_pp", "pto_force_pp", "power_peak", "power_mean", "energy"]


class Published(Section):
    """Figures published elsewhere, printed beside ours: design -> measure -> value, SI units."""

    source: str
    values: dict[str, dict[Measure, Finite]]
