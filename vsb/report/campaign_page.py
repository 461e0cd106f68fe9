"""The report of a campaign: the site's answer first, then the figures, then what to doubt."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from vsb import __version__
from vsb.engine.waves.climate import is_doubt
from vsb.report.animation import in_motion
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
from vsb.report.campaign_figures import FEWEST_OF_A_LINE, is_mapped
from vsb.report.html import captioned, page
from vsb.report.interactive import as_script
from vsb.study.campaign import CONSTRAINED
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import kind_of
from vsb.tools.words import gain_text, plain, short

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


@dataclass(frozen=True)
class CampaignReport:
    """What the report of a campaign is made of."""

    data: xr.Dataset
    figures: Mapping[str, str]  # name -> SVG
    interactive: Mapping[str, Any] | None = None  # data of its scripts, see `vsb.report.interactive`
    sketches: Sequence[Mapping[str, str]] = ()  # of each design: name, words, SVG
    animated: Mapping[str, Any] | None = None  # the buoys in motion, see `vsb.report.animation`
    notes: Sequence[str] = ()  # on the climate: records left out, and what is unknown


def render(report: CampaignReport) -> str:
    """Return the report as one HTML page."""
    ds = report.data
    tuning, reference = leading(ds)
    said = whole_answer(ds, reference, tuning)
    return page(
        "campaign.html.j2",
        campaign=ds.attrs["campaign"],
        climate=ds.attrs["climate"],
        answer=said.stands,
        below=said.below,
        sketches=report.sketches,
        kind="year",
        animated=in_motion(report.animated),
        still="" if report.animated else still(ds),
        interactive=as_script(report.interactive) if report.interactive else "",
        no_slider=NO_SLIDER if "damper_matrix" in ds else "",
        statements=statements(ds, reference, tuning),
        warnings=[*warnings(ds), *(f"Of the climate, {note}." for note in report.notes if is_doubt(note))],
        port=kind_of(ds),
        head=head(ds),
        body=rows(ds),
        shells=of_shells(ds),
        over=compared_with(ds, reference),
        explained=f"Tunings: {'; '.join(f'{name}, {TUNED[name]}' for name in map(str, ds.tuning.values))}.",
        left_out=max(0, int(ds.annual_mean_power.size) - MOST_ROWS),
        figures=captioned(report.figures, captions(ds)),
        facts={
            "Program": f"vsb {__version__}",
            "Command": f"vsb run {ds.attrs['campaign']}.yaml",
            "Study": ds.attrs["study"],
            "Climate": "; ".join([ds.attrs["climate"], *report.notes]),
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


def still(ds: xr.Dataset) -> str:
    """Return why a page has no animation."""
    if not of_shells(ds):
        return STILL_BODY
    return STILL_DAMPERS if "damper_matrix" in ds else STILL


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
    if bool((abs(over) > 1e-6).any()):  # of a table of JONSWAP seas it is the year itself
        found.append(
            f"Usual practice, JONSWAP seas at the centres of the bins, would change the annual energy by "
            f"{float(over.min()):+z.1f} to {float(over.max()):+z.1f} %."
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
    found += _failed(ds)
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


def _failed(ds: xr.Dataset) -> list[str]:
    """Runs in time that failed, and why."""
    failed = ds.attrs.get("failed_runs", "").splitlines()
    return [f"Of a point whose runs failed there is linear theory alone: {one}" for one in failed]


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
    numbers += [_matrix(one.damper_matrix.values)] if "damper_matrix" in one else []
    numbers += [_cell(float(one.margin))] if of_shells(one) else []
    return [where(one) or "-", design, tuning, *gains, *numbers]


def _matrix(values: FloatArray) -> str:
    """A damper matrix, row by row; a dash where there is none."""
    return "-" if np.isnan(values).any() else "; ".join(", ".join(map(short, row)) for row in values)


def _cell(value: float, form: str = "") -> str:
    """A number of the table; a dash where there is none."""
    return "-" if np.isnan(value) else format(value, form) if form else plain(value)


def _has_runs(ds: xr.Dataset) -> bool:
    """Whether time-domain runs correct gains."""
    return "verified_tuning" in ds.attrs and is_verified(ds, ds.attrs["verified_tuning"])
