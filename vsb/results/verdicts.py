"""Which designs of a study are not valid, in which seas and why."""

from collections.abc import Sequence
from typing import NamedTuple

from vsb.hydro.database import Check
from vsb.study.body import BodyStudy
from vsb.study.study import BaseStudy, IrregularSea, Study


class Invalid(NamedTuple):
    """A check by which a design is not valid in a sea, all realisations together."""

    design: str
    sea: str
    name: str  # of the check
    value: float
    limit: float


def flexible_designs(study: BaseStudy) -> list[str]:
    """Return the designs that are not rigid."""
    if isinstance(study, BodyStudy):
        return [name for name, design in study.designs.items() if not design.rigid]
    assert isinstance(study, Study)
    return [name for name, design in study.designs.items() if design.flexible]


def invalid_designs(study: BaseStudy, checks: Sequence[Check]) -> list[Invalid]:
    """Return why designs are not valid: a line for each design, sea and check that invalidates.

    A check of no design is of all it may be of (`vsb.hydro.database.INVALIDATING`), one of no sea is of all seas.
    """
    families = {wave.label: wave.family if isinstance(wave, IrregularSea) else wave.label for wave in study.waves}
    found: dict[tuple[str, str, str], Invalid] = {}
    for check in checks:
        if (whose := check.invalidates) is None:
            continue
        name = check.name.removeprefix("hydro ")
        designs = [check.design] if check.design else list(study.designs) if whose == "all" else flexible_designs(study)
        for design in designs:
            for sea in [families[check.wave]] if check.wave else dict.fromkeys(families.values()):
                line = Invalid(design, sea, name, check.value, check.limit)
                before = found.get((design, sea, name), line)
                found[design, sea, name] = max(before, line, key=lambda one: one.value)  # the worst realisation
    return list(found.values())
