"""What runs in time say about a member's year, as a dataset."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vsb.errors import ConfigError
from vsb.results.campaign import GAIN, POWER
from vsb.results.statistics import Estimate
from vsb.results.verification import Verification
from vsb.results.year import Year
from vsb.tools.arrays import AnyArray, FloatArray


def verified_dataset(year: Year, tuning: str, runs: Verification) -> xr.Dataset:
    """Return the corrected year of every design under a tuning with its intervals, and the runs it is from.

    Raises
    ------
    ConfigError
        If the corrected power of the reference is not above 0, over which gains are.
    """
    powers = [runs.power(i) for i in range(len(year.designs))]
    values: dict[str, tuple[tuple[str, ...], AnyArray]] = {
        name: (("design",), column) for name, column in zip(POWER, np.array(powers).T, strict=True)
    }
    if year.reference is not None:
        gains = _gains(year, runs, year.tunings.index(tuning)).T
        values |= {name: (("design",), column) for name, column in zip(GAIN, gains, strict=True)}
    sea = runs.sample.sea
    drawn = {"sea": sea, "seed": runs.sample.seed, "weight": runs.sample.weight}
    drawn |= {"hs": year.climate.hs[sea], "te": year.climate.te[sea]}
    values |= {f"drawn_{name}": (("draw",), column) for name, column in drawn.items()}
    powers_of = {"run_power": runs.better, "linear_run_power": runs.linear, "drawn_power": runs.linear_seas[:, sea]}
    values |= {name: (("design", "draw"), power) for name, power in powers_of.items()}
    return xr.Dataset(values, coords={"design": list(year.designs)})


def of_nothing(year: Year) -> xr.Dataset:
    """Return the corrected year of designs none of which takes anything by linear theory, so that no sea is drawn."""
    nothing = ("design", np.zeros(len(year.designs)))
    missing = ("design", np.full(len(year.designs), np.nan))
    values = dict.fromkeys(POWER, nothing) | (dict.fromkeys(GAIN, missing) if year.reference is not None else {})
    return xr.Dataset(values, coords={"design": list(year.designs)})


def _gains(year: Year, runs: Verification, tuning: int) -> FloatArray:
    """Gains of all designs over the reference and their intervals, none of its own; NaN if it takes nothing."""
    at = year.designs.index(str(year.reference))
    if not year.annual_mean_power[at, tuning] > 0:
        return np.full((len(year.designs), len(GAIN)), np.nan)
    if not (base := float(runs.corrected[at])) > 0:
        raise ConfigError(
            f"verify: received a corrected power of {base:.4g} W of the rigid {year.reference}; needs more than 0 W, "
            "more seas or a longer simulation.window"
        )
    return np.array([runs.gain(i, at) or Estimate(0.0, 0.0, 0.0) for i in range(len(year.designs))])


def with_lost(found: xr.Dataset, designs: Sequence[str], reference: str | None) -> xr.Dataset:
    """Return a dataset of viable designs with all designs, without values where a design is not viable."""
    names = (*POWER, *(GAIN if reference is not None else ()))
    lost = xr.Dataset({name: ("design", np.full(len(designs), np.nan)) for name in names})
    lost = lost.assign_coords(design=list(designs))
    whole = lost.assign(found.reindex(design=list(designs)).data_vars)
    return whole.assign(viable=("design", np.isin(designs, found.design.values)))
