"""What every study has, whatever floats in it: designs, a take-off, seas, runs in time.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import field_validator

from vsb.errors import ConfigError
from vsb.study.quantities import Section
from vsb.study.sections import Published, Simulation, Water
from vsb.study.take_off import Pto, Tuning
from vsb.study.waves import IrregularSea, StillWater, Wave

RESERVED_NAMES = ("hydro", "hydro_precision", "barge", "logs", "benchmarks", "trash")


class BaseStudy(Section):
    """Designs compared in seas: the keys that studies of a buoy and of a body share are declared by each of them."""

    if TYPE_CHECKING:
        study: str
        designs: Mapping[str, Section]
        water: Water
        pto: Pto
        waves: tuple[Wave, ...]
        simulation: Simulation
        hydro: Any  # of a buoy or of a body
        published: Published | None

    @field_validator("study", check_fields=False)
    @classmethod
    def _not_reserved(cls, value: str) -> str:
        if value in RESERVED_NAMES:
            raise ValueError(
                f"{value!r} is the name of a results folder; choose a name other than {', '.join(RESERVED_NAMES)}"
            )
        return value

    @field_validator("waves", check_fields=False)
    @classmethod
    def _each_realisation(cls, value: tuple[Wave, ...]) -> tuple[Wave, ...]:
        """Seas of several realisations become as many seas, of seeds one after the other."""
        seas: list[Wave] = []
        for wave in value:
            if isinstance(wave, IrregularSea):
                seeds = range(wave.seed, wave.seed + wave.realisations)
                seas += [wave.model_copy(update={"seed": seed, "realisations": 1}) for seed in seeds]
            else:
                seas.append(wave)
        return tuple(seas)

    def check_labels(self) -> None:
        """Check that no sea is there twice; `ValueError`."""
        labels = [wave.label for wave in self.waves]
        if len(set(labels)) < len(labels):
            raise ValueError(f"waves {labels}: the same sea is listed twice")

    def check_dampers_of_designs(self) -> None:
        """Check that dampers given one by one are those of the designs; `ValueError`."""
        if isinstance(self.pto.damping, dict) and set(self.pto.damping) != set(self.designs):
            raise ValueError(
                f"pto.damping: received dampers of {', '.join(self.pto.damping) or 'no design'}, needs one for every "
                f"design: {', '.join(self.designs)}"
            )

    def check_published(self) -> None:
        """Check that figures are published of designs there are; `ValueError`."""
        if self.published and (absent := sorted(set(self.published.values) - set(self.designs))):
            raise ValueError(f"published.values {absent}: no such design; needs some of {', '.join(self.designs)}")

    @property
    @abstractmethod
    def needs_bem(self) -> bool:
        """Whether the hydrodynamic model rests on radiation and diffraction coefficients."""

    @property
    @abstractmethod
    def reference_design(self) -> str | None:
        """The first rigid design by name, the order of results: gains are measured against it."""

    @abstractmethod
    def fastest(self, wave: Wave) -> float:
        """Frequency of the fastest motion a run in a sea must show [rad/s]."""

    def tuning(self, wave: Wave) -> Tuning:
        """Return how the damper of a run is found; none is best where nothing comes in: there the given one holds."""
        alone = isinstance(wave, StillWater) and (self.pto.tuning == "each" or not self.one_of_each_sea)
        return "fixed" if alone else self.pto.tuning

    def check_dampers(self) -> None:
        """Check that every run has a damper.

        Raises
        ------
        ConfigError
        """
        for i, wave in enumerate(self.waves):
            if self.tuning(wave) == "fixed" and self.pto.damping is None:
                raise ConfigError(
                    f"waves.{i} {wave.label}: no damper is best where nothing comes in; needs pto.damping in N s/m"
                )

    @property
    def one_of_each_sea(self) -> tuple[Wave, ...]:
        """The seas one damper is to suit: of several realisations the first, still water left out."""
        return tuple(wave for wave in self.drawn_waves if not isinstance(wave, StillWater))

    @property
    def drawn_waves(self) -> tuple[Wave, ...]:
        """The seas figures are drawn of: of several realisations the first."""
        first = {wave.family if isinstance(wave, IrregularSea) else wave.label: wave for wave in reversed(self.waves)}
        return tuple(wave for wave in self.waves if wave in first.values())

    @property
    def has_spectra(self) -> bool:
        """Whether any of the seas is irregular."""
        return any(isinstance(wave, IrregularSea) for wave in self.waves)


def check_all(*checks: Callable[[], None]) -> None:
    """Make all checks; `ValueError` with every mistake found, a line each."""
    mistakes = []
    for check in checks:
        try:
            check()
        except ValueError as mistake:
            mistakes.append(str(mistake))
    if mistakes:
        raise ValueError("\n".join(mistakes))
