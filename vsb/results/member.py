"""A member of a campaign: one study over a site's year, what is not viable of it included."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from vsb.motion.port import Port
from vsb.results.bins import Bins
from vsb.results.constrained_member import OF_LIMITS, Optima
from vsb.results.validity import LIMITS, beyond_validity
from vsb.results.year import DesignYear, Tuning, Year, best_for_all, year
from vsb.scenes.ports import InWaves, ShapeWater, designs_in_waves
from vsb.scenes.viability import viability
from vsb.shell.modes import ModeBasis
from vsb.study.specs import CONSTRAINED, Tunings
from vsb.study.study import Study
from vsb.tools.units import FloatArray
from vsb.waves.climate import Climate

BY, BINS = ("design", "tuning"), ("hs", "te")
OF_DESIGNS = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "force_rms",
    "practice_power", "quadrature_error", "energy_beyond_validity",
)  # fmt: skip
CURVES = ("tried_damping", "power_of_damping", "force_of_damping")
TRIED = np.geomspace(1 / 30, 30, 61)
"""Dampers the year's power is told of, in terms of the best one for the year."""
MATRICES = (
    "damping", "power_matrix", "power_deviation", "capture_width_matrix", "capture_width_deviation", "beyond_validity",
)  # fmt: skip


def member(
    study: Study,
    water: Callable[[ModeBasis], ShapeWater],
    climate: Climate,
    tunings: Sequence[Tunings],
    optima: Optima | None = None,
) -> xr.Dataset:
    """Return what every design of a study takes of a year under every tuning; NaN of designs that are not viable.

    Parameters
    ----------
    study : Study
    water : callable
        Of the modes, to the coefficients of its shape; not called where there is no shape at rest.
    climate : Climate
    tunings : sequence of {'fixed', 'one', 'each', 'constrained'}
    optima : Optima, optional
        What finds the year within limits; needed for `constrained`.
    """
    rest = viability(study)
    found = _missing(study, climate, tunings)
    viable = [design for design in study.designs if design not in rest.reasons]
    if rest.reference and viable:
        some, shape = with_designs(study, viable), water(rest.reference.basis)
        waves = designs_in_waves(some, rest.reference, shape)
        damped = [tuning for tuning in tunings if tuning != CONSTRAINED]
        if damped:
            _fill(found, _damped(some, waves, climate, damped))
        _fill(found, xr.Dataset(_curves(_ports(some, waves), climate), coords={"design": viable}))
        if optima:
            _fill(found, optima.years(some, rest.reference, climate, float(shape.omega[0])))
    found["viable"] = ("design", np.array([design in viable for design in study.designs]))
    found["reason"] = ("design", np.array([rest.reasons.get(design, "") for design in study.designs], dtype=object))
    found["margin"] = ((), rest.margin)
    return found


def _ports(study: Study, waves: Mapping[str, InWaves]) -> dict[str, Port]:
    """Ports beside the spring of the take-off."""
    return {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}


def _damped(study: Study, waves: Mapping[str, InWaves], climate: Climate, tunings: Sequence[Tuning]) -> xr.Dataset:
    """The year of designs under dampers."""
    found = ports_year(study, _ports(study, waves), climate, tunings)
    of = found.dataset().assign(beyond_validity(found, waves, study.pto.stiffness, study.device.radius).data_vars)
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


def _missing(study: Study, climate: Climate, tunings: Sequence[str]) -> xr.Dataset:
    """All variables without a value, and how many seas there are in each bin."""
    bins = Bins(climate.hs, climate.te, climate.hours)
    sizes = {"design": len(study.designs), "tuning": len(tunings), "limit": len(LIMITS), "damper": len(TRIED)}
    sizes |= dict(zip(BINS, bins.shape, strict=True))
    names = [name for name in OF_DESIGNS if study.reference_design or not name.startswith("gain")]
    dims: dict[str, tuple[str, ...]] = dict.fromkeys(names, BY) | dict.fromkeys(MATRICES, (*BY, *BINS))
    dims |= dict.fromkeys(CURVES, ("design", "damper")) | {"energy_beyond": (*BY, "limit")}
    dims |= dict.fromkeys(OF_LIMITS if CONSTRAINED in tunings else (), ("design",))
    values = {name: (of, np.full([sizes[dim] for dim in of], np.nan)) for name, of in dims.items()}
    names_at = {"design": list(study.designs), "tuning": list(tunings), "limit": list(LIMITS)}
    at = {"hs": bins.hs_centres, "te": bins.te_centres}
    return xr.Dataset({**values, "count": (BINS, bins.count)}, coords={**names_at, **at})


def _fill(found: xr.Dataset, of: xr.Dataset) -> None:
    """Put the values of some designs, and of some tunings, where they belong."""
    for name in set(of.data_vars) & set(found.data_vars) - {"count"}:
        dims = [dim for dim in BY if dim in of[name].dims]
        at = np.ix_(*([found.indexes[dim].get_loc(label) for label in of.indexes[dim]] for dim in dims))
        found[name].values[at] = of[name].values
