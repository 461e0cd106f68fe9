"""Error budgets of the ladder: what errors of the coefficients, and modes left out, do to every power and gain."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.motion.coefficient_errors import CoefficientError, Sensitivity, coefficient_errors, sensitivity
from vsb.motion.port import Port
from vsb.results.budget import Budget, Source
from vsb.scenes.floating_system import FloatingSystem, heading
from vsb.study.study import Wave
from vsb.tools.arrays import ComplexArray
from vsb.waves.seas import Sea

MODES = "modes left out"
LIMITED = "constrained"
"""The rung of an optimum within limits, whose errors are taken as the larger of those with and without limits."""


class Loaded(NamedTuple):
    """A take-off at work: damper and spring, or the best force of all if both are none; and its mean power."""

    rung: str
    damping: float | None  # [N s/m]
    stiffness: float | None  # [N/m]
    power: float  # [W]


class Errors(NamedTuple):
    """Error budgets of one rung: of its mean power [W], and of its gain over the reference [percentage points]."""

    power: Budget
    gain: Budget | None  # None of the reference, or without one


Places = Mapping[tuple[str, str], Sequence[Loaded]]
"""Take-offs by design and label of the sea."""


def rung_errors(
    floating: FloatingSystem,
    seas: Sequence[tuple[Wave, Sea]],
    loads: Places,
    reference: str | None,
    left_out: xr.Dataset,
) -> dict[tuple[str, str, str], Errors]:
    """Return the error budgets of take-offs, by design, label of the sea and rung.

    Parameters
    ----------
    floating : FloatingSystem
    seas : sequence of (Wave, Sea)
    loads : mapping (design, label) -> sequence of Loaded
    reference : str or None
        Design gains are over. All designs share one database: of a gain only what their errors do not have in common
        is left.
    left_out : xarray.Dataset
        See `vsb.results.left_out.modes_left_out`.
    """
    found: dict[tuple[str, str, str], Errors] = {}
    known: dict[bytes, dict[tuple[str, str], _Computed]] = {}
    for wave, sea in seas:
        here = {design: loads.get((design, wave.label), ()) for design in floating.motions}
        key = repr((heading(wave), here)).encode() + sea.omega.tobytes() + np.abs(sea.amplitude).tobytes()
        if key not in known:  # realisations of a sea of the same amplitudes are one
            known[key] = _of_sea(floating, wave, sea, here)
        computed = known[key]
        for (design, rung), one in computed.items():
            numbers = [Source.within(e.name, one.power * one.slopes.to(e), shared=True) for e in one.errors]
            power = Budget((*numbers, *_of_modes(left_out, design, wave.label, rung, "power", one.power)))
            gain, base = None, computed.get((reference or "", rung))
            if base is not None and design != reference:
                ratio, apart = 100 * one.power / base.power if base.power > 0 else 0.0, one.slopes - base.slopes
                numbers = [Source.within(e.name, ratio * apart.to(e), shared=True) for e in one.errors]
                gain = Budget((*numbers, *_of_modes(left_out, design, wave.label, rung, "gain", 1.0)))
            found[design, wave.label, rung] = Errors(power, gain)
    return _with_limited(found, loads)


class _Computed(NamedTuple):
    """Power of a take-off [W], its derivatives, and the errors of the coefficients it is of."""

    power: float
    slopes: Sensitivity
    errors: Sequence[CoefficientError]


def _of_sea(
    floating: FloatingSystem, wave: Wave, sea: Sea, here: Mapping[str, Sequence[Loaded]]
) -> dict[tuple[str, str], _Computed]:
    """Derivatives of the powers of all designs in one sea, by design and rung."""
    linear, squares, found = floating.towards(wave), np.abs(sea.amplitude) ** 2, {}
    errors = coefficient_errors(linear, sea.omega)
    for design, motions in floating.motions.items():
        port = linear.port(sea.omega, motions, floating.port)
        moved = linear.free_motion(sea.omega, motions, floating.port)
        for load in here[design]:
            if load.rung != LIMITED:
                slopes = sensitivity(sea.omega, moved, port, _impedance(port, load), squares)
                found[design, load.rung] = _Computed(load.power, slopes, errors)
    return found


def _impedance(port: Port, load: Loaded) -> ComplexArray:
    """Impedance of a take-off; the best force of all is that of the conjugate impedance."""
    if load.damping is None or load.stiffness is None:
        return np.conj(port.impedance)
    return port.load(load.damping, load.stiffness)


def _of_modes(left_out: xr.Dataset, design: str, label: str, rung: str, name: str, size: float) -> list[Source]:
    """What modes left out may change, of a power or of a gain; nothing where it is not known or none."""
    if name not in left_out:
        return []
    take_off = {"fixed": "given", "best_spring_damper": "optimal_spring"}.get(rung, "optimal")
    low, high = (size * float(end) for end in left_out[name].sel(design=design, wave=label, take_off=take_off))
    return [Source(MODES, low, high)] if low or high else []


def _with_limited(found: dict[tuple[str, str, str], Errors], loads: Places) -> dict[tuple[str, str, str], Errors]:
    """The same with optima within limits: in terms of power at most as wrong as the larger of those at either end.

    Where limits hardly bind the optimum is the matched force; where they bind most its power goes with |V0| alone,
    which the optimal damper feels twice as much.
    """
    for (design, label), some in loads.items():
        for load in (one for one in some if one.rung == LIMITED):
            ends = [one for one in some if one.rung in ("best_damper", "matched") and one.power > 0]
            wrong = [(one.power, found[design, label, one.rung]) for one in ends]
            if wrong:
                power, errors = max(wrong, key=lambda each: (each[1].power.high - each[1].power.low) / each[0])
                gains = [each.gain for _, each in wrong if each.gain is not None]
                gain = max(gains, key=lambda budget: budget.high - budget.low) if gains else None
                found[design, label, LIMITED] = Errors(errors.power.scaled(load.power / power), gain)
    return found
