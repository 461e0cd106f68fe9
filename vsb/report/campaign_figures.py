"""Figures of a campaign: matrices of power, power over the damper and over its force, gains over what is varied."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from vsb.report.campaign_answer import is_verified, reported_bounds, reported_gain, shown_member
from vsb.report.canvas import bin_edges, grid_of_axes, legend_above, note, number_cells, plain_numbers, style
from vsb.results.campaign import damper
from vsb.results.year import HEIGHT, PERIOD
from vsb.study.campaign import CONSTRAINED
from vsb.tools.variables import kind_of
from vsb.tools.words import quantity, superscripts

MOST_ACROSS, MOST_CELLS, SIDE_BY_SIDE = 18, 18 * 14, 12
"""Bins of period, and all bins, up to which a matrix has numbers; bins of period up to which two stand side by side."""
CELL, CORNER = 0.17, 0.35
"""Height of a bin with a number [inch], and how far from its middle a mark beside the number is [bin]."""
GAIN = "RdBu"
"""Colours of gains: blue more than the rigid design, red less."""
NOT_VIABLE = "no design is viable"
HATCH = "////"
LIMIT = "force_limit"
FEWEST_OF_A_LINE = 3
"""Points from which on a line is drawn through them."""
PREFIXED = ("Pa", "N", "W")
"""Units that ticks have with a prefix: 3 MPa, 20 kN."""
MOST_ROWS = 6
"""Values of a third key that have a map."""
MOST_TICKS = 5
"""Numbers of a key each of which has a tick of its own; words have one each, however many."""


def power_matrices(ds: xr.Dataset, tuning: str, reference: str | None) -> Figure:
    """Draw mean power over the bins of height and period, all designs in one scale, with numbers where they fit."""
    one, designs = shown_member(ds, tuning, reference), list(ds.design.values)
    power = one.power_matrix.sel(tuning=tuning).where(one["count"] > 0) / 1e3
    occupied = one["count"] > 0
    across, up = (_span(occupied.any(dim).values) for dim in ("hs", "te"))
    numbered = across <= MOST_ACROSS and across * up <= MOST_CELLS
    columns = 1 if numbered and across > SIDE_BY_SIDE else min(2, len(designs))
    rows = -(-len(designs) // columns)
    height = max(2.3, 0.7 + CELL * up) if numbered else 2.3
    figure, axes = grid_of_axes(0.6 + 0.6 * numbered + height * rows, rows, columns, sharex=True, sharey=True)
    image = None
    for ax, design in zip(axes.ravel(), designs, strict=False):
        ax.grid(visible=False)
        ax.set_title(design, fontsize=9, color=_style(ds, design)["color"])
        if not bool(one.viable.sel(design=design)):
            note(ax, "not viable")
            continue
        edges = (bin_edges(ds.te.values, PERIOD), bin_edges(ds.hs.values, HEIGHT))
        image = ax.pcolormesh(*edges, power.sel(design=design), vmin=0, vmax=float(power.max()), cmap="viridis")
        if numbered:
            number_cells(ax, ds.te.values, ds.hs.values, power.sel(design=design).values, float(power.max()))
        _mark_beyond(ax, one.beyond_validity.sel(design=design, tuning=tuning), CORNER * numbered)
    for ax in axes.ravel()[len(designs) :]:
        ax.set_visible(False)
    for ax in axes[-1]:
        ax.set_xlabel("energy period Te [s]")
    for ax in axes[:, 0]:
        ax.set_ylabel("Hs [m]")
    if image is not None:
        axes[0, 0].set_xlim(*bin_edges(ds.te.values[occupied.any("hs").values], PERIOD)[[0, -1]])
        axes[0, 0].set_ylim(*bin_edges(ds.hs.values[occupied.any("te").values], HEIGHT)[[0, -1]])
        bar: dict[str, Any] = {"orientation": "horizontal", "aspect": 50} if numbered else {}  # width is for numbers
        figure.colorbar(image, ax=axes, label="mean power [kW]", **bar)
    return figure


def _style(ds: xr.Dataset, design: str) -> dict[str, Any]:
    """Colour, line style and label of a design of a campaign."""
    return style(design, list(ds.design.values), ds.attrs.get("reference"))


def _span(occupied: np.ndarray) -> int:
    """How many bins there are from the first to the last occupied one."""
    return int(np.ptp(np.flatnonzero(occupied))) + 1 if occupied.any() else 0


def _mark_beyond(ax: Axes, share: xr.DataArray, aside: float) -> None:
    """Mark bins with seas beyond the validity of linear theory with a cross, the larger the more of them.

    It stands so much of a bin right of and above the middle.
    """
    beyond = share.stack(bin=("hs", "te"), create_index=False)
    beyond = beyond[(beyond > 0).values]
    x, y = beyond.te + aside * PERIOD, beyond.hs + aside * HEIGHT
    ax.scatter(x, y, s=4 + (6 if aside else 20) * beyond, marker="x", color="#d55e00", linewidths=0.9)


def tuned_power(ds: xr.Dataset, tuning: str, reference: str | None) -> Figure:
    """Draw mean power of the year against a constant damping, and that at optimal damping in each sea."""
    one, designs = shown_member(ds, tuning, reference), list(ds.design.values)
    if not bool(one.viable.any()):
        return _without_curves(NOT_VIABLE)
    if not bool((one.tried_damping > 0).any()):
        return _without_curves("no damping absorbs power")
    figure, axes = grid_of_axes(3.4)
    ax, dampers = axes[0, 0], damper(one)
    for design in designs:
        line, at = _style(ds, design), one.sel(design=design)
        if not bool(at.viable):
            continue
        ax.plot(at.tried_damping, at.power_of_damping / 1e3, **line)
        for name, marker in (("one", "o"), ("fixed", "s")):
            if name in ds.tuning.values:
                x, y = dampers.sel(design=design, tuning=name), at.annual_mean_power.sel(tuning=name) / 1e3
                ax.plot(
                    x, y, marker, color=line["color"], markerfacecolor="white" if name == "fixed" else line["color"]
                )
        if "each" in ds.tuning.values:
            ax.axhline(float(at.annual_mean_power.sel(tuning="each")) / 1e3, color=line["color"], linewidth=0.8, ls=":")
    ax.set(
        xscale="log", xlabel=f"damping [{superscripts(kind_of(ds).damping_unit)}]", ylabel="mean power of the year [kW]"
    )
    ax.set_ylim(bottom=0)
    legend_above(figure, ax)
    return figure


def pareto(ds: xr.Dataset, tuning: str, reference: str | None) -> Figure:
    """Draw mean power of the year against the rms force: damping up to the optimum, and optima within limits."""
    one, designs = shown_member(ds, tuning, reference), list(ds.design.values)
    if not bool(one.viable.any()):
        return _without_curves(NOT_VIABLE)
    figure, axes = grid_of_axes(3.4)
    ax = axes[0, 0]
    for design in designs:
        at, line = one.sel(design=design), _style(ds, design)
        if bool(at.viable):
            upto = int(np.argmax(at.power_of_damping.values)) + 1
            force, power = at.force_of_damping[:upto] / 1e3, at.power_of_damping[:upto] / 1e3
            ax.plot(force, power, **line)
            ax.plot(force[-1], power[-1], "o", color=line["color"])
        if CONSTRAINED in ds.tuning.values:
            within = _over_limits(ds, one).sel(design=design, tuning=CONSTRAINED)
            finite = within.annual_mean_power.notnull()
            force, power = within.force_rms[finite] / 1e3, within.annual_mean_power[finite] / 1e3
            ax.plot(force, power, "-s", color=line["color"], markerfacecolor="white", markersize=5, linewidth=0.8)
    wide, kind = CONSTRAINED in ds.tuning.values, kind_of(ds)
    ax.set(xlabel=f"rms {kind.load} of the take-off [k{kind.load_unit}]", ylabel="mean power of the year [kW]")
    ax.set(xscale="log", yscale="log") if wide else ax.set(xlim=(0, None), ylim=(0, None))
    for axis in (ax.xaxis, ax.yaxis) if wide else ():
        plain_numbers(axis)
    legend_above(figure, ax)
    return figure


def _over_limits(ds: xr.Dataset, one: xr.Dataset) -> xr.Dataset:
    """The points that differ from one in the limit of the force alone, along it."""
    if LIMIT not in ds.dims:
        return one.expand_dims("point")
    others = {name: one[name].item() for name in str(ds.attrs["varied"]).split() if name != LIMIT}
    return ds.sel(others).sortby(LIMIT)


def sweep(ds: xr.Dataset, tuning: str, reference: str | None) -> Figure:
    """Draw gains over what is varied: lines over one key, a map over two, the line of buckling over it."""
    ds = ds.drop_dims(("hs", "te", "damper"), errors="ignore")  # what is sorted is copied
    varied = str(ds.attrs["varied"]).split()
    keys = [name for name in varied if ds[name].size > 1]
    others = [design for design in ds.design.values if design != reference]
    if not bool(ds.viable.any()):
        return _without_curves(NOT_VIABLE)
    if reference is None and not is_mapped(ds):
        return _powers(ds, tuning, keys[0])
    if reference is None or not others:
        nothing = "a rigid design that absorbs no power" if ds.attrs.get("reference") else "no rigid design"
        return _without_curves(f"{'no flexible design' if reference else nothing} to compare with")
    return _maps(ds, tuning, keys, others) if is_mapped(ds) else _lines(ds, tuning, keys[0], others)


def _without_curves(text: str) -> Figure:
    """A low figure that says why there is nothing to draw."""
    figure, axes = grid_of_axes(1.5)
    note(axes[0, 0], text)
    return figure


def is_mapped(ds: xr.Dataset) -> bool:
    """Return whether gains are drawn as maps: over a grid of more than one key."""
    return "member" not in ds.dims and sum(ds[name].size > 1 for name in str(ds.attrs["varied"]).split()) > 1


def _lines(ds: xr.Dataset, tuning: str, key: str, others: Sequence[str]) -> Figure:
    """Gains over one key, with their intervals."""
    figure, ax, places, at = _over_key(ds, tuning, key)
    for design in others:
        line, one = _style(ds, design), at.sel(design=design).squeeze()
        _with_interval(ax, places, line, reported_gain(one, tuning), reported_bounds(one, tuning))
        if is_verified(one, tuning):
            look = {"ls": ":"} if len(places) >= FEWEST_OF_A_LINE else {"ls": "none", "marker": "x", "markersize": 4}
            ax.plot(places, one.gain_percent, color=line["color"], linewidth=0.8, **look)
    ax.axhline(0, color="black", linewidth=0.8)
    ax.set(ylabel="gain [%]")
    legend_above(figure, ax)
    return figure


def _powers(ds: xr.Dataset, tuning: str, key: str) -> Figure:
    """Mean powers of the year over one key, with their intervals."""
    figure, ax, places, at = _over_key(ds, tuning, key)
    for design in ds.design.values:
        names = ("annual_mean_power", "annual_mean_power_low", "annual_mean_power_high")
        power, low, high = (at[name].sel(design=design).squeeze() / 1e3 for name in names)
        _with_interval(ax, places, _style(ds, design), power, (low, high))
    ax.set(ylabel="mean power of the year [kW]")
    legend_above(figure, ax)
    return figure


def _over_key(ds: xr.Dataset, tuning: str, key: str) -> tuple[Figure, Axes, Any, xr.Dataset]:
    """Axes over one key, the places of its values, and the results there."""
    figure, axes = grid_of_axes(3.4)
    ax, ordered = axes[0, 0], ds.sortby(key) if ds[key].dtype.kind == "f" else ds
    ax.set(xlabel=_label(ds, key), xscale=_scale(ds, key))
    if not _is_spaced(ds, key):
        _tick(ax.xaxis, ordered, key)
    elif ds[key].attrs.get("units") in PREFIXED:
        ax.xaxis.set_major_formatter(EngFormatter(unit=ds[key].attrs["units"]))
    return figure, ax, _places(ordered, key), ordered.sel(tuning=tuning)


def _with_interval(
    ax: Axes, places: Any, line: dict[str, Any], values: xr.DataArray, bounds: tuple[xr.DataArray, xr.DataArray]
) -> None:
    """A curve, its points marked where they are few, in the band of its interval; two points have no line between."""
    if len(places) < FEWEST_OF_A_LINE:
        ax.vlines(places, *bounds, color=line["color"], alpha=0.4, linewidth=3)
        line = {**line, "linestyle": "none"}
    else:
        ax.fill_between(places, *bounds, color=line["color"], alpha=0.2, linewidth=0)
    ax.plot(places, values, marker="" if len(places) > 12 else "o", markersize=4, **line)


def _maps(ds: xr.Dataset, tuning: str, keys: Sequence[str], others: Sequence[str]) -> Figure:
    """Gains over two keys, rows for a third, further ones at their first values; with marks, see `_mark`."""
    y, x, *rest = keys
    ds = ds.sortby([key for key in (y, x) if ds[key].dtype.kind == "f"])  # cells lie side by side
    third, at = rest[:1], ds.sel(tuning=tuning).isel(dict.fromkeys(rest[1:], 0))
    rows_of: list[dict[str, int]] = [{name: i} for name in third for i in range(min(MOST_ROWS, ds.sizes[name]))] or [{}]
    shown = [(design, place) for place in rows_of for design in others]
    columns = len(others) if third else min(2, len(others))
    rows = -(-len(shown) // columns)
    figure, axes = grid_of_axes(0.8 + 2.5 * rows, rows, columns, sharex=True, sharey=True)
    gains = reported_gain(at, tuning).sel(design=list(others)).values
    largest = max(1.0, float(np.nanpercentile(np.abs(gains), 95)))
    for ax, (design, place) in zip(axes.ravel(), shown, strict=False):
        one = at.sel(design=design).isel(place).squeeze(drop=True).transpose(y, x, ...)
        cells = (_cells(ds, x), _cells(ds, y))
        image = ax.pcolormesh(*cells, reported_gain(one, tuning), cmap=GAIN, vmin=-largest, vmax=largest)
        _mark(ax, ds, one, x, y, reported_bounds(one, tuning))
        if not any(place.values()):
            ax.set_title(design, fontsize=9, color=_style(ds, design)["color"])
        ax.grid(visible=False)
        ax.set(xscale=_scale(ds, x), yscale=_scale(ds, y))
        for axis, key in ((ax.xaxis, x), (ax.yaxis, y)):
            if ds.sizes[key] <= MOST_TICKS or not _is_spaced(ds, key):
                _tick(axis, ds, key)
            elif ds[key].attrs.get("units") in PREFIXED:
                axis.set_major_formatter(EngFormatter(unit=ds[key].attrs["units"]))
    for ax in axes.ravel()[len(shown) :]:
        ax.set_visible(False)
    for ax in axes[-1]:
        ax.set_xlabel(_label(ds, x))
    for i, ax in enumerate(axes[:, 0]):
        ax.set_ylabel(_label(ds, y) + "".join(f"\n{_value(ds, name, i)}" for name in third))
    figure.colorbar(image, ax=axes, label="gain over the rigid design [%]", extend="both")
    return figure


def _value(ds: xr.Dataset, key: str, i: int) -> str:
    """A value of a key in words."""
    return f"{key.replace('_', ' ')} {quantity(ds[key].values[i].item(), ds[key].attrs.get('units', '1'))}"


def _mark(ax: Axes, ds: xr.Dataset, one: xr.Dataset, x: str, y: str, bounds: tuple[xr.DataArray, xr.DataArray]) -> None:
    """Hatch where the interval of the gain includes zero or nothing is viable; draw the line of buckling."""
    places = (_places(ds, x), _places(ds, y))
    across, up = _cells(ds, x), _cells(ds, y)
    cells = [
        [(across[j + a], up[i + b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        for i, j in np.argwhere(((bounds[0] <= 0) & (bounds[1] >= 0)).values)
    ]
    if cells:
        ax.add_collection(PolyCollection(cells, facecolor="none", edgecolor="black", linewidth=0, hatch=HATCH))
    margin = one.margin.values
    if margin.min() < 0 < margin.max():
        ax.contour(*places, np.log10(1 - np.minimum(margin, 1 - 1e-6)), levels=[0.0], colors="black", linewidths=1.8)
    if not one.viable.values.all():
        ax.set_facecolor("#bbbbbb")


def _is_spaced(ds: xr.Dataset, key: str) -> bool:
    """Whether values of a key are finite numbers: neither words nor infinite depth."""
    values = ds[key].values
    return values.dtype.kind == "f" and bool(np.isfinite(values).all())


def _places(ds: xr.Dataset, key: str) -> np.ndarray:
    """Where values of a key stand on an axis: at whole numbers if they are not finite numbers."""
    values = ds[key].values
    return values if _is_spaced(ds, key) else np.arange(len(values))


def _tick(axis: Axis, ds: xr.Dataset, key: str) -> None:
    """Put a tick where each value of a key stands, and no others."""
    units = ds[key].attrs.get("units", "1")
    numbered = EngFormatter(unit=units) if units in PREFIXED else _number
    axis.set_ticks(_places(ds, key), [numbered(value) for value in ds[key].values.tolist()])
    axis.set_ticks([], minor=True)


def _cells(ds: xr.Dataset, key: str) -> np.ndarray:
    """Edges of the cells around the values of a key, halfway to their neighbours as the scale of its axis has it."""
    places = _places(ds, key)
    stretched = np.log(places) if _scale(ds, key) == "log" else places
    middles = (stretched[1:] + stretched[:-1]) / 2
    edges = np.array([2 * stretched[0] - middles[0], *middles, 2 * stretched[-1] - middles[-1]])
    return np.exp(edges) if _scale(ds, key) == "log" else edges


def _number(value: object) -> str:
    """A value beside an axis, with an exponent as study files have it; a huge one to four digits."""
    huge = isinstance(value, float) and abs(value) >= 1e6
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:.4g}" if huge else quantity(value, "1"))


def _scale(ds: xr.Dataset, key: str) -> str:
    """Scale of the axis of a key: logarithmic if its values span a decade."""
    values = ds[key].values
    wide = _is_spaced(ds, key) and values.min() > 0 and values.max() >= 10 * values.min()
    return "log" if wide else "linear"


def _label(ds: xr.Dataset, key: str) -> str:
    """Label of the axis of a key."""
    units = ds[key].attrs.get("units", "1")
    name = key.replace("_", " ")
    return name if units in PREFIXED else f"{name} [{'-' if units == '1' else units}]"


DRAWN = {"power_matrices": power_matrices, "tuned_power": tuned_power, "pareto": pareto, "sweep": sweep}
"""Figures by name, see `vsb.study.figure_names.of_campaign`."""
