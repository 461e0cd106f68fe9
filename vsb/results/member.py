"""A member of a campaign: one study over a site's year, what is not viable of it included."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from vsb.motion.port import Port
from vsb.results.bins import Bins, bins_of
from vsb.results.validity import LIMITS, beyond_validity
from vsb.results.year import DesignYear, Tuning, Year, best_for_all, year
from vsb.scenes.ports import InWaves, ShapeWater, designs_in_waves
from vsb.scenes.viability import viability
from vsb.shell.modes import ModeBasis
from vsb.shell.reference import ReferenceShell
from vsb.study.study import Study
from vsb.study.year_options import CONSTRAINED, Tunings
from vsb.tools.units import AnyArray
from vsb.waves.climate import Climate

Values = Mapping[str, tuple[tuple[str, ...], AnyArray]]
"""Dimensions and values by name: a dataset is made of all at the end, for each costs as much as what it holds."""
Labels = dict[str, list[str]]
YearsWithin = Callable[[Study, ReferenceShell, Climate, float], xr.Dataset]
"""Of viable designs, their shape and the climate, from a frequency on [rad/s], to their years within limits."""
BY, BINS = ("design", "tuning"), ("hs", "te")
OF_DESIGNS = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "force_rms",
    "practice_power", "quadrature_error", "energy_beyond_validity",
)  # fmt: skip
OF_LIMITS = ("power_bound", "optimum_gap", "optimum_share", "optimum_excess", "impossible_share")
"""What is said of the optima of a design beside what every tuning has."""
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
    optima: YearsWithin | None = None,
) -> xr.Dataset:
    """Return what every design of a study takes of a year under every tuning; NaN of designs that are not viable.

    Parameters
    ----------
    study : Study
    water : callable
        Of the modes, to the coefficients of its shape; not called where there is no shape at rest.
    climate : Climate
    tunings : sequence of {'fixed', 'one', 'each', 'constrained'}
    optima : callable, optional
        What finds the years within limits, `vsb.results.constrained_member.Optima`; needed for `constrained`.
    """
    rest = viability(study)
    bins = bins_of(climate)
    found = _missing(study, bins, tunings)
    at: Labels = {"design": list(study.designs), "tuning": list(tunings)}
    if rest.viable:
        some, reference = rest.viable
        shape = water(reference.basis)
        waves = designs_in_waves(some, reference, shape)
        ports = {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}
        damped: list[Tuning] = [tuning for tuning in tunings if tuning != CONSTRAINED]
        here: Labels = {"design": list(some.designs), "tuning": [*damped]}
        of = ports_year(some, ports, climate, damped) if damped else None
        if of:
            _fill(found, at, _damped(some, of, waves), here)
        _fill(found, at, _curves(ports, climate, of), here)
        if optima:
            within = optima(some, reference, climate, float(shape.omega[0]))
            values: Values = {str(name): (tuple(map(str, v.dims)), v.values) for name, v in within.items()}
            _fill(found, at, values, here | {"tuning": [CONSTRAINED]})
    reasons = np.array([rest.reasons.get(design, "") for design in study.designs], dtype=object)
    found |= {"viable": (BY[:1], np.array([design not in rest.reasons for design in study.designs]))}
    found |= {"reason": (BY[:1], reasons), "margin": ((), np.array(rest.margin))}
    of_bins = {"hs": bins.hs_centres, "te": bins.te_centres}
    return xr.Dataset(found, coords={**at, "limit": list(LIMITS), **of_bins})


def _damped(study: Study, of: Year, waves: Mapping[str, InWaves]) -> Values:
    """The year of designs under dampers, and how much of it is beyond what is described."""
    found = {**of.values, **beyond_validity(of, waves, study.pto.stiffness, study.device.radius)}
    return found if of.reference is None else {**found, **_gain_interval(of, study.hydro.tolerance)}


def ports_year(study: Study, ports: Mapping[str, Port], climate: Climate, tunings: Sequence[Tuning]) -> Year:
    """Return the year of the designs of a study from their ports."""
    dampers = {design: study.pto.damper(design) for design in study.designs}
    given = {design: damping for design, damping in dampers.items() if damping is not None}
    return year(ports, climate, study.water, tunings, given, study.reference_design)


def _curves(ports: Mapping[str, Port], climate: Climate, of: Year | None) -> Values:
    """Mean power of the year and rms force of dampers that stay as they are, each shape (design, damper)."""
    years = [DesignYear(port, climate) for port in ports.values()]
    known = of.damping[:, of.tunings.index("one"), 0] if of and "one" in of.tunings else None
    tried = np.outer(best_for_all(years) if known is None else known, TRIED)
    power = np.array([one.annual(dampers) for one, dampers in zip(years, tried, strict=True)])
    found = (tried, power, np.sqrt(tried * power))
    return {name: (("design", "damper"), values) for name, values in zip(CURVES, found, strict=True)}


def _gain_interval(year: Year, tolerance: float) -> Values:
    """Where gains lie by the errors of numbers: quadrature over frequency, tolerance of the coefficients."""
    if (gain := year.gain_percent) is None:
        return {}
    at = year.designs.index(str(year.reference))
    error = year.quadrature_error / year.annual_mean_power + tolerance
    width = (error + error[at]) * (100 + gain)
    width[at] = 0.0
    return {"gain_low": (BY, gain - width), "gain_high": (BY, gain + width)}


def _missing(study: Study, bins: Bins, tunings: Sequence[str]) -> dict[str, tuple[tuple[str, ...], AnyArray]]:
    """All variables without a value, and how many seas there are in each bin."""
    sizes = {"design": len(study.designs), "tuning": len(tunings), "limit": len(LIMITS), "damper": len(TRIED)}
    sizes |= dict(zip(BINS, bins.shape, strict=True))
    names = [name for name in OF_DESIGNS if study.reference_design or not name.startswith("gain")]
    dims: dict[str, tuple[str, ...]] = dict.fromkeys(names, BY) | dict.fromkeys(MATRICES, (*BY, *BINS))
    dims |= dict.fromkeys(CURVES, ("design", "damper")) | {"energy_beyond": (*BY, "limit")}
    dims |= dict.fromkeys(OF_LIMITS if CONSTRAINED in tunings else (), ("design",))
    return {name: (of, np.full([sizes[dim] for dim in of], np.nan)) for name, of in dims.items()} | {
        "count": (BINS, bins.count)
    }


def _fill(found: Values, at: Labels, of: Values, here: Labels) -> None:
    """Put the values of some designs, and of some tunings, where they belong."""
    for name in of.keys() & found.keys() - {"count"}:
        dims, values = of[name]
        places = [[at[dim].index(label) for label in here[dim]] for dim in BY if dim in dims]
        found[name][1][np.ix_(*places)] = values
