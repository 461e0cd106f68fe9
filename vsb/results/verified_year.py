"""What runs in time say about a member's year, as a dataset; and put beside the linear years of a whole campaign."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.errors import ConfigError
from vsb.results.statistics import Estimate
from vsb.results.verification import Verification
from vsb.results.year import Year
from vsb.study.specs import CampaignSpec, leading_tuning
from vsb.tools.units import FloatArray

NumericArray = npt.NDArray[Any]
POWER = ("corrected_mean_power", "corrected_power_low", "corrected_power_high")
GAIN = ("corrected_gain_percent", "corrected_gain_low", "corrected_gain_high")


def verified_dataset(year: Year, tuning: str, runs: Verification) -> xr.Dataset:
    """Return the corrected year of every design under a tuning with its intervals, and the runs it is from.

    Raises
    ------
    ConfigError
        If the corrected power of the reference is not above 0, over which gains are.
    """
    powers = [runs.power(i) for i in range(len(year.designs))]
    values: dict[str, tuple[tuple[str, ...], NumericArray]] = {
        name: (("design",), column) for name, column in zip(POWER, np.array(powers).T, strict=True)
    }
    if year.reference is not None:
        gains = np.array(_gains(year, runs)).T
        values |= {name: (("design",), column) for name, column in zip(GAIN, gains, strict=True)}
    sea = runs.sample.sea
    drawn = {"sea": sea, "seed": runs.sample.seed, "weight": runs.sample.weight}
    drawn |= {"hs": year.climate.hs[sea], "te": year.climate.te[sea]}
    values |= {f"drawn_{name}": (("draw",), column) for name, column in drawn.items()}
    both = {"run_power": runs.better, "linear_run_power": runs.linear}
    values |= {name: (("design", "draw"), power) for name, power in both.items()}
    return xr.Dataset(values, coords={"design": list(year.designs)})


def _gains(year: Year, runs: Verification) -> list[Estimate]:
    """Gains of all designs over the reference, none of its own."""
    at = year.designs.index(str(year.reference))
    if not (base := float(runs.corrected[at])) > 0:
        raise ConfigError(
            f"verify: received a corrected power of {base:.4g} W of the rigid {year.reference}; needs more than 0 W, "
            "more seas or a longer simulation.window"
        )
    return [runs.gain(i, at) or Estimate(0.0, 0.0, 0.0) for i in range(len(year.designs))]


def with_lost(found: xr.Dataset, designs: Sequence[str], reference: str | None) -> xr.Dataset:
    """Return a dataset of viable designs with all designs, without values where a design is not viable."""
    names = (*POWER, *(GAIN if reference is not None else ()))
    lost = xr.Dataset({name: ("design", np.full(len(designs), np.nan)) for name in names})
    lost = lost.assign_coords(design=list(designs))
    whole = lost.assign(found.reindex(design=list(designs)).data_vars)
    return whole.assign(viable=("design", np.isin(designs, found.design.values)))


def with_verification(spec: CampaignSpec, ds: xr.Dataset, runs: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the results of a campaign with what runs in time say: intervals of gains under their tuning are theirs.

    Parameters
    ----------
    spec : CampaignSpec
    ds : Dataset
        See `vsb.results.campaign.gathered`.
    runs : sequence of Dataset
        See `verified_dataset`, in the order of the members; none of a campaign that verifies nothing.
    """
    if not runs:
        return ds
    names = [name for name in (*POWER, *GAIN) if name in runs[0]]
    found = ds.assign({name: _unfolded(ds, [one[name] for one in runs]) for name in names})
    tuning = leading_tuning(spec.tuning)
    told = f"tuning {tuning}: {runs[0].attrs['runs']}"
    if "gain_percent" in found:
        here = found.tuning == tuning
        for end in ("low", "high"):
            found[f"gain_{end}"] = found[f"gain_{end}"].where(~here, found[f"corrected_gain_{end}"])
        told += "; there gain_low and gain_high are the 95 % interval of the corrected gain"
    found = found.drop_vars(GAIN[1:], errors="ignore")
    return found.assign_attrs(
        {**ds.attrs, "verification": told, "verified_tuning": tuning, "verified_model": runs[0].attrs["model"]}
    )


def _unfolded(ds: xr.Dataset, values: Sequence[xr.DataArray]) -> tuple[tuple[str, ...], FloatArray]:
    """Values of members over the dimensions of what is varied."""
    stacked = np.stack([one.values for one in values])
    dims = (*map(str, ds.margin.dims), *map(str, values[0].dims))
    return dims, stacked.reshape((*ds.margin.shape, *stacked.shape[1:]))
