"""Variables of a year in files: powers, gains and matrices over the bins of a climate."""

import xarray as xr

from vsb.tools.variables import Variable, at_port, register

_YEAR = ("...", "design", "tuning")
_BINS = ("hs", "te")
_IN_TIME = ("body_exact_", "in_time_")
_GAINS = ("gain_", "corrected_gain_", "body_exact_gain_", "in_time_gain_")


def _may_be_missing(ds: xr.Dataset, name: str) -> xr.DataArray | bool:
    """Where a year has no value: designs not viable, other control, gains over no power, runs that failed."""
    missing: xr.DataArray | bool = ~ds.viable if "viable" in ds and "design" in ds[name].dims else False
    if name == "practice_power" and "tuning" in ds[name].dims:
        missing = missing | ds.tuning.isin(["damper_same_force", "causal", "constrained"])
    if name == "damper_matrix":
        missing = missing | (ds.tuning == "causal")
    if name.startswith(_GAINS):
        power = ds["corrected_mean_power" if "annual_mean_power" not in ds else "annual_mean_power"]
        missing = missing | (power <= 0).any("design")
    if name.startswith(_IN_TIME) and ds.attrs.get("failed_runs"):
        missing = True
    return missing


register(
    {
        "hs": Variable(("hs",), "m", "significant wave height at the centres of bins"),
        "te": Variable(("te",), "s", "energy period at the centres of bins"),
        "annual_mean_power": Variable(_YEAR, "W", "mean power over the year"),
        "annual_mean_power_low": Variable(_YEAR, "W", "lower bound of the mean power from errors of linear theory"),
        "annual_mean_power_high": Variable(_YEAR, "W", "upper bound of the mean power from errors of linear theory"),
        "annual_energy": Variable(_YEAR, "MWh", "energy of a year of 8766 hours"),
        "capture_width": Variable(_YEAR, "m", "mean power of the year over its mean energy flux"),
        "force_rms": Variable(_YEAR, at_port("load_unit"), "root mean square of the take-off's force over the year"),
        "gain_percent": Variable(_YEAR, "%", "gain of annual energy over the reference at the same tuning"),
        "gain_low": Variable(_YEAR, "%", "lower bound of the gain from numerical errors of linear theory"),
        "gain_high": Variable(_YEAR, "%", "upper bound of the gain from numerical errors of linear theory"),
        "corrected_mean_power": Variable(_YEAR[:2], "W", "mean power over the year, corrected by time-domain runs"),
        "corrected_power_low": Variable(_YEAR[:2], "W", "lower end of its 95 % interval"),
        "corrected_power_high": Variable(_YEAR[:2], "W", "upper end of its 95 % interval"),
        "corrected_gain_percent": Variable(_YEAR[:2], "%", "gain of corrected mean power over the reference"),
        "corrected_gain_low": Variable(_YEAR[:2], "%", "lower end of its 95 % interval"),
        "corrected_gain_high": Variable(_YEAR[:2], "%", "upper end of its 95 % interval"),
        **{
            f"{begin}_{name}": Variable(_YEAR[:2], unit, f"{what} by {runs} in time under the tuning that is verified")
            for begin, runs in (("body_exact", "body-exact runs"), ("in_time", "linear runs"))
            for name, unit, what in (
                ("mean_power", "W", "mean power over the year"),
                ("power_low", "W", "least mean power over the year, 95 %,"),
                ("power_high", "W", "largest mean power over the year, 95 %,"),
                ("gain_percent", "%", "gain over the reference"),
                ("gain_low", "%", "least gain over the reference, 95 % and errors of linear theory,"),
                ("gain_high", "%", "largest gain over the reference, 95 % and errors of linear theory,"),
            )
        },
        "energy_beyond": Variable(
            (*_YEAR, "limit"), "1", "share of energy from seas beyond one limit of linear theory"
        ),
        "energy_beyond_validity": Variable(_YEAR, "1", "share of energy from seas beyond any of these limits"),
        "beyond_validity": Variable(
            (*_YEAR, *_BINS), "1", "share of the seas of a bin beyond the validity of linear theory"
        ),
        "drawn_sea": Variable(("draw",), "1", "index of the sea in the climate"),
        "drawn_seed": Variable(("draw",), "1", "seed of the phases of that sea"),
        "drawn_hs": Variable(("draw",), "m", "significant wave height of that sea"),
        "drawn_te": Variable(("draw",), "s", "energy period of that sea"),
        "drawn_weight": Variable(("draw",), "1", "share of the year over the probability of drawing that sea"),
        "run_power": Variable(("design", "draw"), "W", "mean power of the time-domain run"),
        "linear_run_power": Variable(("design", "draw"), "W", "mean power of linear theory in the same waves"),
        "drawn_power": Variable(
            ("design", "draw"), "W", "mean power of linear theory over the spectrum of the drawn sea"
        ),
        "tried_damping": Variable(
            ("...", "design", "damper"), at_port("damping_unit"), "constant damping over the year"
        ),
        "power_of_damping": Variable(("...", "design", "damper"), "W", "mean power of the year at that damping"),
        "force_of_damping": Variable(
            ("...", "design", "damper"), at_port("load_unit"), "root mean square of the take-off force at that damping"
        ),
        "viable": Variable(("...", "design"), "1", "whether the design is stable at rest; if not, results are missing"),
        "margin": Variable(
            ("...",),
            "1",
            "1 - static load over buckling load, 0 if it buckles by linear theory alone; below 0 the shell buckles",
        ),
        "practice_power": Variable(_YEAR, "W", "mean power with JONSWAP spectra at the centres of bins"),
        "quadrature_error": Variable(
            _YEAR, "W", "error of mean power from the quadrature over frequency; of optima, half their 95 % interval"
        ),
        "power_bound": Variable(_YEAR[:2], "W", "proved upper bound of mean power under the limits"),
        "optimum_gap": Variable(_YEAR[:2], "1", "gap between the optima and that bound, relative to it"),
        "optimum_share": Variable(_YEAR[:2], "1", "share of the year's energy flux in bins with a computed optimum"),
        "optimum_excess": Variable(_YEAR[:2], "1", "largest relative violation of a limit between collocation points"),
        "impossible_share": Variable(_YEAR[:2], "1", "share of the year in which no force keeps the stroke limit"),
        "damping": Variable(
            (*_YEAR, *_BINS), at_port("damping_unit"), "mean damping of the seas of a bin, 0 where there is none"
        ),
        "damper_matrix": Variable(
            (*_YEAR, "port", "port_"), at_port("damping_unit"), "mean damper matrix of the year at several ports"
        ),
        "power_matrix": Variable((*_YEAR, *_BINS), "W", "mean power in a bin, 0 where there is no sea"),
        "power_deviation": Variable((*_YEAR, *_BINS), "W", "standard deviation of mean power within a bin"),
        "capture_width_matrix": Variable((*_YEAR, *_BINS), "m", "mean capture width in a bin, 0 where there is no sea"),
        "capture_width_deviation": Variable((*_YEAR, *_BINS), "m", "standard deviation of capture width within a bin"),
        "count": Variable(_BINS, "1", "number of seas in a bin"),
        "occurrence": Variable(_BINS, "1", "share of the year of a bin"),
        "flux_matrix": Variable(("...", *_BINS), "W/m", "mean energy flux in a bin, 0 where there is no sea"),
    },
    missing=_may_be_missing,
)
