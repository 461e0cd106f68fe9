"""A member of a campaign: one study over a site's year, what is not viable of it included."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from vsb.motion.port import Port
from vsb.results.bins import Bins
from vsb.results.year import DesignYear, Tuning, Year, best_for_all, year
from vsb.scenes.ports import ShapeWater, design_ports
from vsb.scenes.viability import viability
from vsb.shell.modes import ModeBasis
from vsb.shell.rest import ReferenceShell
from vsb.study.study import Study
from vsb.tools.units import FloatArray
from vsb.waves.climate import Climate

BY, BINS = ("design", "tuning"), ("hs", "te")
OF_DESIGNS = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "force_rms",
    "practice_power", "quadrature_error",
)  # fmt: skip
CURVES = ("tried_damping", "power_of_damping", "force_of_damping")
TRIED = np.geomspace(1 / 30, 30, 61)
"""Dampers the year's power is told of, in terms of the best one for the year."""
MATRICES = ("damping", "power_matrix", "power_deviation", "capture_width_matrix", "capture_width_deviation")


def member(
    study: Study, water: Callable[[ModeBasis], ShapeWater], climate: Climate, tunings: Sequence[Tuning]
) -> xr.Dataset:
    """Return what every design of a study takes of a year under every tuning; NaN of designs that are not viable.

    Parameters
    ----------
    study : Study
    water : callable
        Of the modes, to the coefficients of its shape; not called where there is no shape at rest.
    climate : Climate
    tunings : sequence of {'fixed', 'one', 'each'}
    """
    rest = viability(study)
    found = _missing(study, climate, tunings)
    viable = [design for design in study.designs if design not in rest.reasons]
    if rest.reference and viable:
        _fill(found, _of_viable(study, rest.reference, viable, water(rest.reference.basis), climate, tunings), viable)
    found["viable"] = ("design", np.array([design in viable for design in study.designs]))
    found["reason"] = ("design", np.array([rest.reasons.get(design, "") for design in study.designs], dtype=object))
    found["margin"] = ((), rest.margin)
    return found


def _of_viable(
    study: Study,
    at_rest: ReferenceShell,
    viable: Sequence[str],
    water: ShapeWater,
    climate: Climate,
    tunings: Sequence[Tuning],
) -> xr.Dataset:
    """The year of the designs that are viable."""
    some = with_designs(study, viable)
    ports = design_ports(some, at_rest, water)
    found = ports_year(some, ports, climate, tunings)
    of = found.dataset().assign(_curves(ports, climate))
    reference = found.reference
    return of if reference is None else of.assign(_gain_interval(of, reference, study.hydro.tolerance))


def with_designs(study: Study, designs: Sequence[str]) -> Study:
    """Return a study of some of its designs."""
    return study.model_copy(update={"designs": {design: study.designs[design] for design in designs}})


def ports_year(study: Study, ports: Mapping[str, Port], climate: Climate, tunings: Sequence[Tuning]) -> Year:
    """Return the year of the designs of a study from their ports."""
    dampers = {design: study.pto.damper(design) for design in study.designs}
    given = {design: damping for design, damping in dampers.items() if damping is not None}
    return year(ports, climate, study.water, tunings, given, study.reference_design)


def _curves(ports: Mapping[str, Port], climate: Climate) -> dict[str, tuple[tuple[str, ...], FloatArray]]:
    """Mean power of the year and rms force of dampers that stay as they are, each shape (design, damper)."""
    years = [DesignYear(port, climate) for port in ports.values()]
    tried = np.outer(best_for_all(years), TRIED)
    power = np.array([one.annual(dampers) for one, dampers in zip(years, tried, strict=True)])
    found = (tried, power, np.sqrt(tried * power))
    return {name: (("design", "damper"), values) for name, values in zip(CURVES, found, strict=True)}


def _gain_interval(of: xr.Dataset, reference: str, tolerance: float) -> dict[str, tuple[tuple[str, ...], FloatArray]]:
    """Where gains lie by the errors of numbers: quadrature over frequency, tolerance of the coefficients."""
    gain, at = of.gain_percent.values, list(of.design.values).index(reference)
    error = of.quadrature_error.values / of.annual_mean_power.values + tolerance
    width = (error + error[at]) * (100 + gain)
    width[at] = 0.0
    return {"gain_low": (BY, gain - width), "gain_high": (BY, gain + width)}


def _missing(study: Study, climate: Climate, tunings: Sequence[Tuning]) -> xr.Dataset:
    """All variables without a value, and how many seas there are in each bin."""
    bins = Bins(climate.hs, climate.te, climate.hours)
    sizes = (len(study.designs), len(tunings))
    names = [name for name in OF_DESIGNS if study.reference_design or not name.startswith("gain")]
    values: dict[str, tuple[tuple[str, ...], FloatArray]] = {name: (BY, np.full(sizes, np.nan)) for name in names}
    values |= {name: ((*BY, *BINS), np.full((*sizes, *bins.shape), np.nan)) for name in MATRICES}
    values |= {name: (("design", "damper"), np.full((len(study.designs), len(TRIED)), np.nan)) for name in CURVES}
    at = {"design": list(study.designs), "tuning": list(tunings), "hs": bins.hs_centres, "te": bins.te_centres}
    return xr.Dataset({**values, "count": (BINS, bins.count)}, coords=at)


def _fill(found: xr.Dataset, of: xr.Dataset, viable: Sequence[str]) -> None:
    """Put the values of some designs where they belong."""
    rows = [list(found.design.values).index(design) for design in viable]
    for name in (*OF_DESIGNS, *CURVES, *MATRICES):
        if name in of and name in found:
            found[name].values[rows] = of[name].values
