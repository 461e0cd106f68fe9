"""Numbers of a buoy that are possible, but likely only in another unit: a modulus of 40 Pa, a damper of 8 N s/m."""

import contextlib
import math
from collections.abc import Iterator
from typing import NamedTuple

from vsb.engine.motion.take_off import port_kind
from vsb.engine.shell.material import Hookean
from vsb.errors import ConfigError
from vsb.keys.schema import LIKELY
from vsb.study.study import BaseStudy, Study
from vsb.tools.units import value_in
from vsb.tools.variables import FORCE


class _Range(NamedTuple):
    """A key, its value and unit, and the range values usually have."""

    key: str
    value: float
    unit: str
    least: float
    most: float


def unlikely_units(study: BaseStudy) -> list[str]:
    """Return a line for every number outside its usual range that is within in another unit; of a body none."""
    return [line for one in _ranges(study) if (line := _line(one))] if isinstance(study, Study) else []


def _line(one: _Range) -> str:
    """A number and the quantity it probably means; empty of a usual one."""
    size = abs(one.value)
    if size == 0 or math.isinf(size) or one.least <= size <= one.most:
        return ""
    for other in LIKELY[one.unit]:
        meant = f"{one.value:.12g} {other}"
        if one.least <= abs(value_in(meant, one.unit)) <= one.most:
            side = "little" if size < one.least else "much"
            return f"{one.key}: {one.value:g} {one.unit} is very {side}; did you mean {meant}?"
    return ""


def _ranges(study: Study) -> Iterator[_Range]:
    """Usual ranges: of materials, and of what acts on a buoy against what the water does, rho, g and radius."""
    device, water, pto = study.device, study.water, study.pto
    radius, weight = device.radius, water.density * water.gravity
    yield _Range("water.density", water.density, "kg/m^3", 500.0, 2e4)
    if study.flexible:
        yield _Range("device.density", device.density, "kg/m^3", 20.0, 2.5e4)
        if isinstance(device.material, Hookean):
            yield _Range("device.young_modulus", device.young_modulus, "Pa", 1e3, 2e12)
        for name in ("mu", "c1", "c2"):
            if (modulus := getattr(device.material, name, None)) is not None:
                yield _Range(f"device.material.{name}", modulus, "Pa", 1e3, 1e9)
        yield _Range("device.internal_pressure", device.internal_pressure, "Pa", 5e-3 * weight * radius, 1e6)
    if port_kind(pto.port) != FORCE:
        return
    for design in study.designs if isinstance(pto.damping, dict) else ("",):
        damper = water.density * radius**3 * math.sqrt(water.gravity / radius)
        key = f"pto.damping.{design}".rstrip(".")
        yield _Range(key, pto.damper(design) or 0.0, "N s/m", 1e-3 * damper, 1e3 * damper)
    yield _Range("pto.stiffness", pto.stiffness, "N/m", 1e-3 * weight * radius**2, 1e3 * weight * radius**2)
    yield _Range("pto.force_limit", pto.force_limit, "N", 1e-3 * weight * radius**3, 1e3 * weight * radius**3)


@contextlib.contextmanager
def units_doubted(study: BaseStudy) -> Iterator[None]:
    """Put before a `ConfigError` raised inside the units that may be its cause."""
    try:
        yield
    except ConfigError as error:
        if not (lines := unlikely_units(study)):
            raise
        raise ConfigError(lines[0], [*lines, *error.mistakes]) from None
