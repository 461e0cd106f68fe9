"""The report of a campaign and its figures: the site's answer first, then the figures, then what to doubt."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from vsb import __version__
from vsb.engine.waves.climate import is_doubt
from vsb.report.campaign_answer import (
    MODELS,
    TUNED,
    answer,
    is_verified,
    leading,
    of_points,
    of_shells,
    reported_bounds,
    reported_gain,
    second_tuning,
    share_range,
    shown_member,
    too_steep_or_breaking,
    where,
    whole_answer,
)
from vsb.report.canvas import bin_edges, grid_of_axes, legend_above, note, number_cells, style
from vsb.report.interactive import as_script, in_motion
from vsb.report.page import captioned, page
from vsb.results.campaign import TABLE_OF_SEAS, damper
from vsb.results.year import HEIGHT, PERIOD
from vsb.study.campaign import CONSTRAINED
from vsb.tools.variables import kind_of
from vsb.tools.words import gain_text, plain, quantity, short, superscripts

CAPTIONS = {
    "spectra": "Spectra of the year: mean, median at each frequency, and the range between the 10 % and 90 % "
    "quantiles (shaded).",
    "power_matrices": "Mean power in bins of significant wave height and energy period (IEC TS 62600-100), "
    "{tuned}{at}. White: no sea in the bin.{crosses}",
    "tuned_power": "Mean power of the year against one damping for all seas{at}.{dampings}",
    "pareto": "Mean power of the year against the root mean square of the take-off's {load}{at}, for "
    "damping up to the optimal one, without limits.{within}",
    "sweep": "Gain of annual energy over {over}, {tuned}{marks}.",
}
DAMPINGS = {
    "one": "full: optimal damping",
    "fixed": "open: given damping",
    "each": "dotted: optimal damping in each sea",
}
"""What the marks of each tuning are in the figure of the power over the damping."""
CROSSES = (
    " Crosses: seas beyond the validity of linear theory, the larger the more of the bin (Hs above 0.05 of the "
    "wavelength at the energy period, or the highest of a thousand waves breaks{deformed})."
)
BEYOND = {
    "steepness": "too steep",
    "breaking": "with breaking waves",
    "deformation": "with shells deformed by more than a tenth of their radius",
}
"""Limits of linear theory that mark a sea, in words."""
BUCKLING = ". Black line: the shell buckles under its static load"
MAPPED = "; hatched: the interval of the gain includes zero; grey: not viable"
MOST_ROWS = 24
NO_SLIDER = "No slider of the damping and no curve over it: the take-off has a damper matrix."
STILL = "No animation: no design is viable at the point of the answer."
STILL_DAMPERS = "No animation: the take-off is not one damper."
STILL_BODY = "No animation: the page of a study of this body has one, if its mesh is known."


def render(
    ds: xr.Dataset,
    figures: Mapping[str, str],
    interactive: Mapping[str, Any] | None = None,
    sketches: Sequence[Mapping[str, str]] = (),
    animated: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
) -> str:
    """Return the report as one HTML page, with figures as SVG by name, data of its scripts, notes on the climate."""
    tuning, reference = leading(ds)
    said, matrices = whole_answer(ds, reference, tuning), "damper_matrix" in ds
    return page(
        "campaign.html.j2",
        campaign=ds.attrs["campaign"],
        climate=ds.attrs["climate"],
        answer=said.stands,
        below=said.below,
        sketches=sketches,
        kind="year",
        animated=in_motion(animated),
        still="" if animated else STILL_BODY if not of_shells(ds) else STILL_DAMPERS if matrices else STILL,
        interactive=as_script(interactive) if interactive else "",
        no_slider=NO_SLIDER if matrices else "",
        statements=statements(ds, reference, tuning),
        warnings=[*warnings(ds), *(f"Of the climate, {note}." for note in notes if is_doubt(note))],
        port=kind_of(ds),
        head=head(ds),
        body=rows(ds),
        shells=of_shells(ds),
        over=compared_with(ds, reference),
        explained=f"Tunings: {'; '.join(f'{name}, {TUNED[name]}' for name in map(str, ds.tuning.values))}.",
        left_out=max(0, int(ds.annual_mean_power.size) - MOST_ROWS),
        figures=captioned(figures, captions(ds)),
        facts={
            "Program": f"vsb {__version__}",
            "Command": f"vsb run {ds.attrs['campaign']}.yaml",
            "Study": ds.attrs["study"],
            "Climate": "; ".join([ds.attrs["climate"], *notes]),
            "Content id": ds.attrs["spec_id"],
        },
    )


def compared_with(ds: xr.Dataset, reference: str | None) -> str:
    """Return what gains are over: of a body, whose designs may all be rigid, the design by its name."""
    return f"the design {reference}" if reference and not of_shells(ds) else "the rigid design"


def captions(ds: xr.Dataset) -> dict[str, str]:
    """Return the captions of the figures of a campaign."""
    tuning, reference = leading(ds)
    one = shown_member(ds, tuning, reference)
    at, marks = where(one), [text for name, text in DAMPINGS.items() if name in ds.tuning.values]
    words = {"tuned": TUNED[tuning], "at": f" at {at}" if at else ""}
    words["load"], words["over"] = kind_of(ds).load, compared_with(ds, reference)
    deformed = " or deforms the shell by more than a tenth of its radius" if of_shells(ds) else ""
    crossed = bool((one.beyond_validity.sel(tuning=tuning) > 0).any())
    words["crosses"] = CROSSES.format(deformed=deformed) if crossed else ""
    words["dampings"] = f" {'; '.join(marks).capitalize()}." if marks else ""
    words["within"] = " Squares: optimal force within each limit." if CONSTRAINED in ds.tuning.values else ""
    points = max((ds[name].size for name in str(ds.attrs["varied"]).split()), default=1)
    band, linear = ("bars", "crosses") if points < FEWEST_OF_A_LINE else ("shaded", "dotted")
    words["marks"] = (BUCKLING if of_shells(ds) else "") + MAPPED if is_mapped(ds) else f"; {band}: interval"
    if is_verified(ds, tuning):
        alone = "" if is_mapped(ds) else f"; {linear}: linear theory alone"
        words["marks"] += f"; corrected by time-domain runs{alone}"
    found = {name: text.format(**words) for name, text in CAPTIONS.items()}
    if reference is None and not is_mapped(ds):
        found["sweep"] = f"Mean power of the year, {TUNED[tuning]}, by linear theory; {band}: interval."
    return found


def statements(ds: xr.Dataset, reference: str | None, tuning: str) -> list[str]:
    """Return further statements: the best design at each further tuning, seas beyond validity, usual practice."""
    if not bool(ds.viable.any()):
        return []
    found, second = [], second_tuning(ds, tuning)
    if words := ds.attrs.get("efficiency"):
        found.append(f"All powers are after conversion, with an efficiency {words} in both directions of power.")
    further = (name for name in TUNED if name in ds.tuning.values and name not in (tuning, second))
    found += [answer(ds, reference, other) for other in further]
    if ds.margin.size > 1 and reference is not None and second:
        found.append(of_points(ds, reference, tuning))
    marked = 100 * ds.energy_beyond_validity.sel(tuning=tuning)
    shares = [f"{_shares(ds, name, tuning)} {words}" for name, words in BEYOND.items() if name in ds.limit]
    found.append(
        f"{share_range(marked)} of the energy comes from the seas crossed in the matrices: {', '.join(shares)}."
        if float(marked.max()) >= 0.5
        else f"Less than 0.5 % of the energy comes from {too_steep_or_breaking(ds)}."
    )
    over = 100 * (ds.practice_power / ds.annual_mean_power.where(ds.annual_mean_power > 0) - 1)
    if ds.attrs.get("seas") != TABLE_OF_SEAS and bool((abs(over) > 1e-6).any()):
        low, high = (f"{float(end):+z.1f}" for end in (over.min(), over.max()))
        found.append(
            f"Usual practice, JONSWAP seas at the centres of the bins, would change the annual energy by "
            f"{low if low == high else f'{low} to {high}'} %."
        )
    return found


def warnings(ds: xr.Dataset) -> list[str]:
    """Return what makes the answer doubtful."""
    found = ["All results are linear theory; intervals contain numerical errors, not errors of the theory."]
    if "verification" in ds.attrs:
        found = [
            f"Time-domain runs correct the answer ({ds.attrs['verification']}). Figures of power and other tunings are "
            "linear theory; their intervals contain numerical errors only.",
            *_unresolved(ds),
            "Intervals of time-domain runs are 95 % intervals of mean power (measured coverage 93 to 97 %). For "
            "quantities set by a few storms (breaking, limits, large deformation) coverage is 77 to 95 % with 12 seas, "
            "89 to 96 % with 24.",
        ]
    failed = ds.attrs.get("failed_runs", "").splitlines()
    found += [f"Of a point whose runs failed there is linear theory alone: {one}" for one in failed]
    if (
        of_shells(ds)
        and 100 * float(ds.energy_beyond.sel(limit="heave", tuning=leading(ds)[0]).where(ds.viable).max()) >= 0.5
    ):
        found.append(
            f"Seas with {_shares(ds, 'heave', leading(ds)[0])} of the year's energy have heave amplitudes above 0.3 of "
            "the radius, where coefficients of the shape at rest are inaccurate."
        )
    if CONSTRAINED in ds.tuning.values:
        found += _warned_of_optima(ds)
    buckled = int((ds.margin < 0).sum())
    if buckled and ds.margin.size > 1:
        share = f"{buckled} of {ds.margin.size} points"
        found.append(f"At {share} the shell would buckle under its static load (margin below 0).")
    elif buckled:
        found.append(f"The shell would buckle: its static load is {1 - ds.margin.item():.3g} times what it can carry.")
    if lost := int((~ds.viable).sum()):
        reasons = sorted({str(text).partition(":")[0] for text in ds.reason.values[~ds.viable.values]})
        found.append(
            f"{lost} of {ds.viable.size} combinations of design and point are not viable: {', '.join(reasons)}."
        )
    if strained := int((ds.viable & (ds.reason != "")).sum()):
        found.append(
            f"{strained} of {ds.viable.size} combinations of design and point have a strain above 2 % at rest, where "
            "Hooke's law is doubtful."
        )
    return found


def _unresolved(ds: xr.Dataset) -> list[str]:
    """Gains whose sign the number of time-domain runs does not resolve."""
    tuning = ds.attrs["verified_tuning"]
    if not is_verified(ds, tuning):
        return []
    at = ds.sel(tuning=tuning)
    low, high = reported_bounds(at, tuning)
    open_ = (low <= 0) & (high >= 0) & (at.design != ds.attrs["reference"])
    if not bool(open_.any()):
        return []
    names = [str(one.design.item()) for one in at.design if bool(open_.sel(design=one).any())]
    return [f"The interval of the gain of {', '.join(names)} includes zero: more verify.seas would narrow it."]


def _warned_of_optima(ds: xr.Dataset) -> list[str]:
    """Limits of the optima within constraints."""
    found = ["The optimal force within limits knows all waves in advance: it is an upper bound for any controller."]
    if (solved := float(ds.optimum_share.min())) < 1 - 1e-9:
        share = f"{math.floor(1e3 * solved) / 10:.1f} %"  # never all of it
        found.append(f"Optima were computed in bins with {share} of the energy flux only: raise constrained.seconds.")
    if (none := float(ds.impossible_share.max())) > 0:
        year = f"{100 * none:.1f} % of the year"
        found.append(f"In up to {year} no force keeps the stroke within its limit: counted as zero power.")
    return found


def _shares(ds: xr.Dataset, limit: str, tuning: str) -> str:
    """Range of the shares of energy beyond a limit over designs and points."""
    return share_range(100 * ds.energy_beyond.sel(limit=limit, tuning=tuning))


def head(ds: xr.Dataset) -> list[str]:
    """Return the head of the table; gains first, because the right of a table lies off a narrow screen."""
    kind, runs = kind_of(ds), [f"gain by {MODELS[ds.attrs['verified_model']]} [%]"] if _has_runs(ds) else []
    known = ["point", "design", "tuning", "gain [%]", *runs, "energy [MWh/year]", "capture width [m]"]
    force = f"rms {kind.load} [k{kind.load_unit}]"
    if "force_rms" not in ds:
        force = f"damper matrix of {', '.join(ds.port.values)} [SI]"
    return [*known, force, *(["margin [-]"] if of_shells(ds) else [])]


def rows(ds: xr.Dataset) -> list[list[str]]:
    """Return the cells of the table, the first `MOST_ROWS` of them."""
    points = [str(dim) for dim in ds.margin.dims]
    stacked = ds.stack(point=points, create_index=False) if points else ds.expand_dims("point")
    found: list[list[str]] = []
    for i in range(stacked.sizes["point"]):
        one = stacked.isel(point=i)
        for design in ds.design.values:
            for tuning in ds.tuning.values:
                if len(found) == MOST_ROWS:
                    return found
                found.append(_row(one.sel(design=design, tuning=tuning), str(design), str(tuning)))
    return found


def _row(one: xr.Dataset, design: str, tuning: str) -> list[str]:
    """Cells of one design under one tuning."""
    gain = float(one.gain_percent) if "gain_percent" in one else np.nan
    gains = [_cell(gain, "+z.1f")]
    if _has_runs(one):
        low, high = (float(end) for end in reported_bounds(one, one.attrs["verified_tuning"]))
        known = tuning == one.attrs["verified_tuning"] and not np.isnan(low)
        texts = [gain_text(value, low, high) for value in (float(reported_gain(one, tuning)), low, high)]
        gains.append("{} ({} to {})".format(*texts) if known else "-")
    numbers = [_cell(float(one.annual_energy)), _cell(float(one.capture_width), ".3g")]
    numbers += [_cell(float(one.force_rms) / 1e3)] if "force_rms" in one else []
    if "damper_matrix" in one:  # row by row
        matrix = one.damper_matrix.values
        numbers.append("-" if np.isnan(matrix).any() else "; ".join(", ".join(map(short, row)) for row in matrix))
    numbers += [_cell(float(one.margin))] if of_shells(one) else []
    return [where(one) or "-", design, tuning, *gains, *numbers]


def _cell(value: float, form: str = "") -> str:
    """A number of the table; a dash where there is none."""
    return "-" if np.isnan(value) else format(value, form) if form else plain(value)


def _has_runs(ds: xr.Dataset) -> bool:
    """Whether time-domain runs correct gains."""
    return "verified_tuning" in ds.attrs and is_verified(ds, ds.attrs["verified_tuning"])


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
MOST_MAPS = 6
"""Values of a third key that have a map."""
MOST_DRAWN = 10_000
"""Cells of a map each of which is drawn by itself, in 130 bytes; more are an image."""
MOST_TICKS = 5
"""Numbers of a key each of which has a tick of its own; words have one each, however many."""


def power_matrices(ds: xr.Dataset, tuning: str, reference: str | None) -> Figure:
    """Draw mean power over the bins of height and period, all designs in one scale, with numbers where they fit."""
    one, designs = shown_member(ds, tuning, reference), list(ds.design.values)
    power = one.power_matrix.sel(tuning=tuning).where(one["count"] > 0) / 1e3
    occupied = one["count"] > 0
    there = [np.flatnonzero(occupied.any(dim).values) for dim in ("hs", "te")]
    across, up = (int(np.ptp(bins)) + 1 if bins.size else 0 for bins in there)
    numbered = across <= MOST_ACROSS and across * up <= MOST_CELLS
    columns = 1 if numbered and across > SIDE_BY_SIDE else min(2, len(designs))
    rows = -(-len(designs) // columns)
    height = max(2.3, 0.7 + CELL * up) if numbered else 2.3
    figure, axes = grid_of_axes(
        0.6 + 0.6 * numbered + height * rows, rows, columns, "constrained", sharex=True, sharey=True
    )
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
    rows_of: list[dict[str, int]] = [{name: i} for name in third for i in range(min(MOST_MAPS, ds.sizes[name]))] or [{}]
    shown = [(design, place) for place in rows_of for design in others]
    columns = len(others) if third else min(2, len(others))
    rows = -(-len(shown) // columns)
    figure, axes = grid_of_axes(0.8 + 2.5 * rows, rows, columns, "constrained", sharex=True, sharey=True)
    gains = reported_gain(at, tuning).sel(design=list(others)).values
    largest = max(1.0, float(np.nanpercentile(np.abs(gains), 95)))
    for ax, (design, place) in zip(axes.ravel(), shown, strict=False):
        one = at.sel(design=design).isel(place).squeeze(drop=True).transpose(y, x, ...)
        cells = (_cells(ds, x), _cells(ds, y))
        gain, many = reported_gain(one, tuning), one.sizes[x] * one.sizes[y] > MOST_DRAWN
        image = ax.pcolormesh(*cells, gain, cmap=GAIN, vmin=-largest, vmax=largest, rasterized=many)
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
        values = ((name, quantity(ds[name].values[i].item(), ds[name].attrs.get("units", "1"))) for name in third)
        ax.set_ylabel(_label(ds, y) + "".join(f"\n{name.replace('_', ' ')} {value}" for name, value in values))
    figure.colorbar(image, ax=axes, label="gain over the rigid design [%]", extend="both")
    return figure


def _mark(ax: Axes, ds: xr.Dataset, one: xr.Dataset, x: str, y: str, bounds: tuple[xr.DataArray, xr.DataArray]) -> None:
    """Hatch where the interval of the gain includes zero or nothing is viable; draw the line of buckling."""
    places = (_places(ds, x), _places(ds, y))
    across, up = _cells(ds, x), _cells(ds, y)
    cells = [
        [(across[j + a], up[i + b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        for i, j in np.argwhere(((bounds[0] <= 0) & (bounds[1] >= 0)).values)
    ]
    if cells:
        look: Any = {"facecolor": "none", "edgecolor": "black", "linewidth": 0, "hatch": HATCH}
        ax.add_collection(PolyCollection(cells, rasterized=len(cells) > MOST_DRAWN, **look))
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
