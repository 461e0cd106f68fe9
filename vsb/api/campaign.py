"""Results of a campaign: a year, or a sweep, as labelled arrays and a table; energy production of IEC TS 62600-100."""

import io
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr

from vsb.api.plots import CampaignPlots
from vsb.engine.waves.climate import YEAR_HOURS
from vsb.errors import ConfigError
from vsb.report.campaign_answer import closing_answer
from vsb.results.year import Bins
from vsb.study.campaign import CONSTRAINED
from vsb.tools.files import load
from vsb.tools.stamps import read_text


@dataclass(frozen=True, repr=False)
class Campaign:
    """Results of a campaign in its folder, such as `results/year`.

    Raises
    ------
    DatabaseError
        By everything here: if `campaign.nc` is missing or damaged.
    """

    folder: str

    @cached_property
    def data(self) -> xr.Dataset:
        """All results, with units: power, energy, gain, matrices over Hs and Te by design, tuning and varied key."""
        return load(f"{self.folder}/campaign.nc")

    @property
    def table(self) -> pd.DataFrame:
        """A row per point, design and tuning."""
        path = f"{self.folder}/campaign.csv"
        text = read_text(path, f"{self.folder}/manifest.json", str(self.data.attrs["spec_id"]))
        return pd.read_csv(io.StringIO(text))

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return str(self.data.attrs["campaign"])

    @property
    def designs(self) -> list[str]:
        """Names of the designs."""
        return [str(name) for name in self.data.design.values]

    @property
    def tunings(self) -> list[str]:
        """Tunings of the take-off."""
        return [str(name) for name in self.data.tuning.values]

    @property
    def varied(self) -> list[str]:
        """Dimensions of what is varied."""
        return str(self.data.attrs["varied"]).split()

    @property
    def report(self) -> Path:
        """Path of the report, to be opened in a browser."""
        return Path(self.folder, "report.html")

    @property
    def plot(self) -> CampaignPlots:
        """Figures: each method draws on matplotlib axes, given or new, and returns them."""
        return CampaignPlots(self)

    def at(self, **point: Any) -> xr.Dataset:
        """Return the results at one point of what is varied, by default the first of each key.

        Parameters
        ----------
        **point
            Values by dimension, as `scale=4.0`.

        Raises
        ------
        ConfigError
            If nothing of that name is varied, or not to that value.
        """
        data = self.data
        for name, value in point.items():
            if name not in self.varied:
                raise ConfigError(f"{name}: is not varied; needs one of {', '.join(self.varied) or 'nothing'}")
            known = data[name].values
            same = np.isclose(known, value, rtol=1e-9, atol=0) if known.dtype.kind == "f" else known == value
            if not np.any(same):
                raise ConfigError(f"{name}: received {value}; needs one of {', '.join(map(str, known.tolist()))}")
            data = data.isel({name: int(np.argmax(same))})
        return data.isel({name: 0 for name in self.varied if name in data.dims})

    def maep(self, design: str, tuning: str | None = None, **point: Any) -> float:
        """Return the mean annual energy production of a design by its capture width matrix [Wh], IEC TS 62600-100.

        It differs from `annual_energy`, which sums the seas one by one, by what bins lose.

        Raises
        ------
        ConfigError
            If there is no such design or tuning, the design is not viable, or the tuning is `constrained`, whose
            optimum is not solved in every bin.
        """
        chosen = tuning or self.tunings[0]
        if chosen == CONSTRAINED:
            raise ConfigError("tuning: received constrained, whose bins are not all solved; use annual_energy")
        for what, name, names in (("design", design, self.designs), ("tuning", chosen, self.tunings)):
            if name not in names:
                raise ConfigError(f"{what}: received {name!r}, needs one of {', '.join(names)}")
        one = self.at(**point).sel(design=design, tuning=chosen)
        return annual_energy(one.capture_width_matrix, one.flux_matrix, one.occurrence)

    def __repr__(self) -> str:
        """Say what was varied and the answer."""
        ds = self.data
        sizes = ", ".join(f"{ds.sizes[name]} of {name}" for name in self.varied if name in ds.sizes)
        lines = [
            f"<vsb.Campaign {self.name!r} in {self.folder}>",
            f"climate: {ds.attrs['climate']}; designs: {', '.join(self.designs)}; tunings: {', '.join(self.tunings)}",
            f"varied: {sizes or 'nothing'}",
            closing_answer(ds).strip(),
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the same with the table, for notebooks."""
        head = "<br>".join(repr(self).replace("<", "&lt;").replace(">", "&gt;").splitlines())
        columns = [*self.table.columns[: list(self.table.columns).index("tuning") + 1]]
        columns += ["annual_mean_power", "annual_energy", "capture_width", "gain_percent"]
        shown = self.table[[name for name in columns if name in self.table]]
        return f"<p>{head}</p>{shown.to_html(index=False, float_format=lambda x: f'{x:.5g}')}"


def power_matrix(
    hs: npt.ArrayLike, te: npt.ArrayLike, values: npt.ArrayLike, statistic: Literal["mean", "std", "frequency"] = "mean"
) -> xr.DataArray:
    """Return a quantity of many seas by bins of 0.5 m of Hs and 1 s of Te, dims (hs, te); NaN in empty bins.

    Parameters
    ----------
    hs, te : array_like, shape (sea,) [m], [s]
    values : array_like, shape (sea,)
        Power, capture width or energy flux of each sea.
    statistic : {'mean', 'std', 'frequency'}
        `frequency` is the share of seas in a bin, whatever the values.

    Raises
    ------
    ConfigError
        If the arrays differ in length or hold a number that is not finite.
    """
    height, period, value = (np.asarray(each, dtype=float) for each in (hs, te, values))
    if not height.shape == period.shape == value.shape or height.ndim != 1 or not height.size:
        raise ConfigError(
            f"power_matrix: received {height.shape} hs, {period.shape} te, {value.shape} values; needs as many of each"
        )
    if not all(np.isfinite(each).all() for each in (height, period, value)) or min(height.min(), period.min()) < 0:
        raise ConfigError("power_matrix: needs finite numbers, heights and periods not below 0")
    if statistic not in ("mean", "std", "frequency"):
        raise ConfigError(f"power_matrix: received {statistic!r}, needs one of mean, std, frequency")
    bins = Bins(height, period, np.full(len(height), 1 / len(height)))
    matrix = {"mean": bins.mean, "std": bins.deviation}[statistic](value) if statistic != "frequency" else bins.share
    at = {"hs": bins.hs_centres, "te": bins.te_centres}
    return xr.DataArray(np.where(bins.count > 0, matrix, np.nan), coords=at, dims=("hs", "te"))


def annual_energy(capture_width: npt.ArrayLike, energy_flux: npt.ArrayLike, frequency: npt.ArrayLike) -> float:
    """Return the mean annual energy production by matrices, 8766 h times the sum of L J f [Wh].

    Parameters
    ----------
    capture_width : array_like, shape (hs, te) [m]
    energy_flux : array_like, shape (hs, te) [W/m]
    frequency : array_like, shape (hs, te) [-]
        Share of the year of each bin. A bin without seas may be NaN in all three.

    Raises
    ------
    ConfigError
        If the shapes differ, shares sum to more than 1, or a bin with seas has no value.
    """
    width, flux, share = (np.asarray(each, dtype=float) for each in (capture_width, energy_flux, frequency))
    if not width.shape == flux.shape == share.shape or not width.size:
        raise ConfigError(f"annual_energy: received shapes {width.shape}, {flux.shape}, {share.shape}; needs one shape")
    share = np.where(np.isnan(share), 0.0, share)
    if share.sum() > 1 + 1e-9 or share.min() < 0:
        raise ConfigError(
            f"annual_energy: received shares that sum to {share.sum():.6g}; needs at most 1, none below 0"
        )
    occupied = share > 0
    energy = (width * flux * share)[occupied]
    if not np.isfinite(energy).all():
        raise ConfigError(
            f"annual_energy: received {np.count_nonzero(~np.isfinite(energy))} bins with seas but without a value, as "
            "of a design that is not viable; needs a value in each"
        )
    return float(YEAR_HOURS * energy.sum())


def annual_energy_of_series(capture_width: npt.ArrayLike, energy_flux: npt.ArrayLike) -> float:
    """Return the mean annual energy production by records of equal shares, 8766 h times the mean of L J [Wh].

    Parameters
    ----------
    capture_width : array_like, shape (record,) [m]
    energy_flux : array_like, shape (record,) [W/m]
    """
    width, flux = np.asarray(capture_width, float), np.asarray(energy_flux, float)
    if width.shape != flux.shape or not width.size or not np.isfinite(width * flux).all():
        raise ConfigError(
            f"annual_energy_of_series: received shapes {width.shape} and {flux.shape}; needs as many finite numbers"
        )
    return float(YEAR_HOURS * np.mean(width * flux))
