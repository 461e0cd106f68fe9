"""A member of a campaign: one study over a site's year, what is not viable of it included."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
import xarray as xr

from vsb.results.bins import bins_of
from vsb.results.damped_years import BY, CURVES, TRIED, DampedYears, Values
from vsb.results.left_out import gain_of_year
from vsb.results.validity import LIMITS
from vsb.scenes.directions import order_bases
from vsb.scenes.ports import ShapeWater, designs_in_waves
from vsb.scenes.viability import viability
from vsb.shell.modes import ModeBasis
from vsb.shell.reference import ReferenceShell
from vsb.study.campaign import CONSTRAINED, Tunings
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, FloatArray
from vsb.waves.climate import Climate

Labels = dict[str, list[str]]
YearsWithin = Callable[[Study, ReferenceShell, Climate, float, FloatArray | None], xr.Dataset]
"""Of viable designs, their shape, the climate, from a frequency on [rad/s], and what modes left out may change of gains
(`gain_of_year`), to their years within limits."""
BINS = ("hs", "te")
OF_DESIGNS = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "force_rms",
    "practice_power", "quadrature_error", "energy_beyond_validity",
)  # fmt: skip
OF_LIMITS = ("power_bound", "optimum_gap", "optimum_share", "optimum_excess", "impossible_share")
"""What is said of the optima of a design beside what every tuning has."""
TOLD: dict[str, tuple[str, ...]] = {"viable": ("design",), "reason": ("design",), "margin": ()}
"""What is said of every design, viable or not, and of the shell."""
MATRICES = (
    "damping", "power_matrix", "power_deviation", "capture_width_matrix", "capture_width_deviation", "beyond_validity",
)  # fmt: skip

SAME_FOR_ALL = ("count", "occurrence")
"""What is said of the year alone."""


def member(
    study: Study,
    water: Callable[[ModeBasis], ShapeWater],
    climate: Climate,
    tunings: Sequence[Tunings],
    optima: YearsWithin | None = None,
    known: dict[bytes, Values] | None = None,
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
    known : dict, optional
        Rigid designs of the members before, which members of other shells share; added to.
    """
    rest = viability(study)
    blank = _blank(tuple(study.designs), tuple(tunings), climate, study.reference_design is not None)
    found = {name: (dims, values.copy()) for name, (dims, values) in _plain(blank).items()}
    at: Labels = {"design": list(study.designs), "tuning": list(tunings)}
    if rest.viable:
        some, reference = rest.viable
        shape = water(reference.basis)
        damped = DampedYears(climate, [one for one in tunings if one != CONSTRAINED], {} if known is None else known)
        here: Labels = {"design": list(some.designs), "tuning": [*damped.tunings]}
        errors = shape.errors(reference.basis, order_bases(some, reference.basis), some.water)
        compared = some.reference_design is not None
        waves = designs_in_waves(some, reference, shape)
        left_out = gain_of_year(some, reference, shape, climate, waves) if compared else None
        _fill(found, at, damped(some, waves, errors, left_out), here)
        if optima:
            within = optima(some, reference, climate, float(shape.omega[0]), left_out)
            _fill(found, at, _plain(within), here | {"tuning": [CONSTRAINED]})
    words = {**rest.doubts, **rest.reasons}
    reasons = np.array([words.get(design, "") for design in study.designs], dtype=object)
    told = {"viable": np.array([design not in rest.reasons for design in study.designs]), "reason": reasons}
    filled = {name: values for name, (_, values) in found.items()} | told | {"margin": np.array(rest.margin)}
    flux = bins_of(climate).mean(climate.flux(study.water))
    return blank.copy(data=filled).assign(flux_matrix=(BINS, flux))


def _plain(ds: xr.Dataset) -> Values:
    """Dimensions and values of the data of a dataset."""
    return {str(name): (tuple(map(str, ds.variables[name].dims)), ds.variables[name].values) for name in ds.data_vars}


@lru_cache(maxsize=4)
def _blank(designs: tuple[str, ...], tunings: tuple[str, ...], climate: Climate, compared: bool) -> xr.Dataset:
    """All variables without a value, and how many seas a bin holds: made once, for it takes as long as to fill it."""
    bins = bins_of(climate)
    sizes = {"design": len(designs), "tuning": len(tunings), "limit": len(LIMITS), "damper": len(TRIED)}
    sizes |= dict(zip(BINS, bins.shape, strict=True))
    names = [name for name in OF_DESIGNS if compared or not name.startswith("gain")]
    dims: dict[str, tuple[str, ...]] = dict.fromkeys(names, BY) | dict.fromkeys(MATRICES, (*BY, *BINS))
    dims |= dict.fromkeys(CURVES, ("design", "damper")) | {"energy_beyond": (*BY, "limit")}
    dims |= dict.fromkeys(OF_LIMITS if CONSTRAINED in tunings else (), ("design",))
    values: dict[str, tuple[tuple[str, ...], AnyArray]]
    values = {name: (of, np.full([sizes[dim] for dim in of], np.nan)) for name, of in dims.items()}
    told = {name: (of, np.zeros([sizes[dim] for dim in of])) for name, of in TOLD.items()}
    at = {"design": list(designs), "tuning": list(tunings), "limit": list(LIMITS)}
    of_bins = {"hs": bins.hs_centres, "te": bins.te_centres}
    year = {"count": (BINS, bins.count), "occurrence": (BINS, bins.share)}
    return xr.Dataset({**values, **year, **told}, coords=at | of_bins)


def _fill(found: Values, at: Labels, of: Values, here: Labels) -> None:
    """Put the values of some designs, and of some tunings, where they belong."""
    for name in of.keys() & found.keys() - {*SAME_FOR_ALL, "flux_matrix"}:
        dims, values = of[name]
        places = [[at[dim].index(label) for label in here[dim]] for dim in BY if dim in dims]
        found[name][1][np.ix_(*places)] = values
