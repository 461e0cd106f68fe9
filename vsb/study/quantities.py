"""Numbers and names a study file may hold, and the sections they stand in.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field


def number(value: object) -> object:
    """Refuse what pydantic would silently turn into a number (true -> 1.0)."""
    if isinstance(value, bool):
        raise ValueError("a number is needed, not true/false")
    return value


def within(least: float, most: float, unit: str, because: str) -> AfterValidator:
    """Return what refuses a number beyond its physical range, and says why there is nothing."""

    def checked(value: float) -> float:
        if not least <= value <= most:
            bound = f"at most {most:g}" if value > most else f"at least {least:g}"
            raise ValueError(f"needs {bound} {unit}, because {because}")
        return value

    return AfterValidator(checked)


Number = Annotated[float, BeforeValidator(number)]
Count = Annotated[int, BeforeValidator(number)]
Positive = Annotated[Number, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[Number, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[Number, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]  # of files, too


class Section(BaseModel):
    """A part of a study: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True)
