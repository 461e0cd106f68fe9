"""Blocks of pages that are written whole: tables, and lines that commands print."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Literal

import vsb
from examples import claims
from examples import directions as directions_example
from examples.power_from_strain import HELD, TAKE_OFFS
from examples.published import speed
from examples.published.pages import MINUS, Value, Values, printed, table
from examples.published.sources import (
    AT_SITES,
    BASES,
    CONDITIONS,
    CONTROL_NAMES,
    DAMPINGS,
    DOUBTED,
    FORCES,
    HOME,
    LIMITS,
    MODULI,
    OWN_FORCE,
    PAPERS,
    PEAKS,
    SITE_FORCES,
    SOURCES,
)
from vsb.study.campaign import AT_FORCE, CAUSAL

MODELS = ("linear", "exact")
YEAR = {"VSWEC": "VSWEC, free", "VSWEC0": "VSWEC0, clamped at the top", "VSWEC90": "VSWEC90, clamped at the equator"}


def interval(values: Values, name: str, digits: int = 1) -> str:
    """Return a gain with its interval as a cell."""
    gain, low, high = (printed(values[f"{name}.{end}"], f"+.{digits}f") for end in ("percent", "low", "high"))
    return f"{gain} ({low} to {high})"


def year(values: Values) -> str:
    """Gains of the example's designs over a year."""
    rows = [
        [words, *(interval(values, f"study.year.{size}.{name}.{model}") for size in (1, 4) for model in MODELS)]
        for name, words in YEAR.items()
    ]
    head = ["design", "2 m: linear [%]", "body-exact [%]", "8 m: linear [%]", "body-exact [%]"]
    return table(head, rows)


def last_line(values: Values) -> str:
    """What the example study prints at its end."""
    return f"```text\n{values['study.last_line']}\n```"


def percent(value: Value, digits: int = 1) -> str:
    """Return a gain as a cell."""
    return printed(value, f"+.{digits}f")


def pays_map(values: Values) -> str:
    """Gain with a limited force by modulus, limit and peak period; next to nothing of the stiffest shell."""
    rows = [
        [f"{modulus} MPa", f"{force:g}", *(percent(values[f"map.{modulus}.{force:g}.{peak:g}"]) for peak in PEAKS)]
        for modulus in (10, 20, 40, 160, 4000)
        for force in FORCES[: 1 if modulus == 4000 else 2]
    ]
    first, *others = PEAKS
    return table(["Young's modulus", "limit", f"Tp {first:g} s", *(f"{peak:g} s" for peak in others)], rows)


def pays_in_a_year(values: Values) -> str:
    """Gain within limits of force over a year, by modulus."""
    rows = []
    for modulus in MODULI:
        strain = float(values[f"when_it_pays.{modulus}.strain"])
        doubt = ", in doubt" if strain > DOUBTED else ""
        gains = [interval(values, f"when_it_pays.{modulus}.{force}", 2) for force in LIMITS]
        rows.append([f"{modulus} MPa", f"{strain:.1f} %{doubt}", *gains])
    return table(["Young's modulus", "strain at rest", "4 kN", "12 kN", "40 kN"], rows)


def at_force(values: Values) -> str:
    """Gain over a year at a given rms force, by modulus and control."""
    rows = []
    for modulus in MODULI:
        strain = float(values[f"when_it_pays.{modulus}.strain"])
        shell = [f"{modulus} MPa", f"{strain:.1f} %{', in doubt' if strain > DOUBTED else ''}"]
        for force in LIMITS:
            weak, control = (interval(values, f"at_force.{modulus}.{force}.{tuning}", 2) for tuning in AT_FORCE)
            known = interval(values, f"when_it_pays.{modulus}.{force}", 2)
            rows.append([*shell, f"{force} kN", weak, control, known])
        damper, control = (interval(values, f"at_force.{modulus}.{OWN_FORCE}.{name}", 2) for name in ("one", CAUSAL))
        rows.append([*shell, "optimal damper's", damper, control, ""])
    return table(["Young's modulus", "strain at rest", "rms force", *CONTROLS], rows)


CONTROLS = ("best damper of that force", "causal control", "future known, limit of every instant")


def at_force_rigid(values: Values) -> str:
    """Energy of the rigid buoy's year at a given rms force."""
    named: list[tuple[str, str, tuple[str, str]]] = [(f"{force} kN", f"{force}", AT_FORCE) for force in LIMITS]
    named.append(("optimal damper's", OWN_FORCE, ("one", CAUSAL)))
    rows = [
        [words, *(printed(values[f"at_force.rigid.{force}.{tuning}"], ".1f") for tuning in tunings)]
        for words, force, tunings in named
    ]
    return table(["rms force", *CONTROLS[:2]], rows)


def best_buoy(values: Values) -> str:
    """The best buoys and what separates size from flexibility."""
    names = ("flexible", "rigid competitor", "rigid twin", "undeformed shape")

    def row(head: str, key: str, form: str, some: Sequence[str] = names, scale: float = 1.0) -> list[str]:
        cells = [f"best_buoy.{name}.{key}" for name in names]
        shown = [
            printed(float(values[cell]) * scale, form) if name in some and cell in values else ""
            for name, cell in zip(names, cells, strict=True)
        ]
        return [head, *shown]

    both = names[:2]
    rows = [
        row("mean power of the year [W]", "power", ".0f"),
        row("radius of the undeformed sphere [m]", "device.radius", ".3f", both),
        row("wall [m]", "device.thickness", ".3f"),
        row("Young's modulus [MPa]", "device.young_modulus", ".3g", scale=1e-6),
        row("pressure [kPa]", "device.internal_pressure", ".1f", scale=1e-3),
        row("beam [m]", "beam", ".2f"),
        row("draft [m]", "draft", ".2f"),
        row("damper [N s/m]", "pto.damping", ".0f", both),
        row("spring [N/m]", "pto.stiffness", "+.0f", both),
    ]
    return table(
        ["", "flexible", "rigid", "rigid, shape and mass of the flexible one", "the sphere before inflation"], rows
    )


def best_buoy_errors(values: Values) -> str:
    """What the gain of the best buoy is uncertain by, the largest first."""
    begin = "best_buoy.error."
    known = {key.removeprefix(begin): float(value) for key, value in values.items() if key.startswith(begin)}
    words = [f"{name} {value:.2f}" for name, value in sorted(known.items(), key=lambda one: -one[1]) if value >= 0.005]
    return f"The gain is uncertain by, in points: {'; '.join(words)}. Inputs: see `uncertain`."


def best_buoy_force(values: Values) -> str:
    """The best buoys by the limit of the force."""
    rows = []
    for force in (10, 20, 40):
        flexible, rigid = (
            printed(values[f"best_buoy.{name}.force_rms.{1000 * force}"], ".0f")
            for name in ("flexible", "rigid competitor")
        )
        rows.append([str(force), flexible, rigid, percent(values[f"best_buoy.gain_at.{1000 * force}"], 2)])
    return table(["rms force at most [kN]", "flexible [W]", "rigid [W]", "gain [%]"], rows)


def best_buoy_sites(values: Values) -> str:
    """The best buoys at other sites and under causal control, by the limit of the force."""
    words, rows = {"one": "damper and spring", CAUSAL: "causal control"}, []
    for site, tuning in AT_SITES:
        for force in SITE_FORCES:
            at = f"best_buoy_of.{site} {CONTROL_NAMES[tuning]}"
            flexible, rigid = (
                printed(values[f"{at}.{name}.{force}"], ".0f") for name in ("flexible", "rigid competitor")
            )
            gain, low, high = (printed(values[f"{at}.gain.{force}.{end}"], "+.2f") for end in ("value", "low", "high"))
            rows.append([site, words[tuning], str(force), flexible, rigid, f"{gain} ({low} to {high})"])
    head = ["waves", "take-off", "rms force at most [kN]", "flexible [W]", "rigid [W]", "gain [%], linear theory"]
    return table(head, rows)


def directions(values: Values) -> str:
    """Share of the limit that the rigid buoy absorbs, and the gain of the free shell, by port and period."""
    rows = []
    for period in directions_example.PERIODS:
        cells = [f"{period:g}"]
        for port in directions_example.PORTS:
            at = f"directions.inflated.{port}.{period:g}"
            cells += [printed(values[f"{at}.rigid"], ".3f"), percent(values[f"{at}.gain"])]
        rows.append(cells)
    heads = [text for port in directions_example.PORTS for text in (f"{port}, rigid", "gain %")]
    return table(["T [s]", *heads], rows)


def strain(values: Values) -> str:
    """Shares of the power of a damper on heave by take-off and mooring."""
    rows = []
    for name in TAKE_OFFS:
        for mooring in HELD:
            key = f"{name}.{mooring}"
            if f"strain.strain.1.{key}" in values:
                cells = [f"strain.{study}.{scale}.{key}" for study in ("strain", "pressurised") for scale in (1, 4)]
                rows.append([name, mooring, *(printed(values[cell], ".1f") for cell in cells)])
    return table(["take-off", "mooring", "40 MPa, 2 m", "8 m", "10 MPa, 2 m", "8 m"], rows)


def table_2(name: str, head: str, values: Values) -> str:
    """The paper's Table II, published and ours."""
    published = vsb.load(HOME / "config" / f"{name}.yaml").published
    assert published is not None
    rows = []
    for design in ("FSB", "VSWEC90", "VSWEC", "VSWEC0"):
        said = published.values[design]
        ours = {key: float(values[f"paper.{name}.{design}.{key}"]) for key in said}
        scale = {key: 1e-3 if key == "energy" else 1.0 for key in said}
        digits = {key: 4 if key.endswith("pp") and "force" not in key else 0 for key in said} | {"energy": 2}
        rows += [
            [f"{design}, published", *(f"{scale[key] * said[key]:.{digits[key]}f}" for key in said)],
            [
                f"{design}, ours",
                *(
                    f"{scale[key] * ours[key]:.{digits[key]}f} ({100 * (ours[key] / said[key] - 1):+.0f} %)".replace(
                        "-", MINUS
                    )
                    for key in said
                ),
            ],
        ]
    return table([head, "displacement m", "velocity m/s", "control force N", "peak power W", "energy kJ"], rows)


def paper_choices(values: Values) -> str:
    """Peak power and energy by what the paper leaves unstated."""
    published = vsb.load(HOME / "config" / "paper_inferred.yaml").published
    assert published is not None
    designs = {"VSWECπ/2": "VSWEC90", "VSWEC": "VSWEC", "VSWEC0": "VSWEC0"}

    def cell(peak: float, energy: float) -> str:
        return f"{peak:.0f} W, {1e-3 * energy:.2f} kJ"

    said = [cell(*(published.values[name][key] for key in PEAK_AND_ENERGY)) for name in designs.values()]
    rows = [["published", *said]]
    for basis, beta in itertools.product(BASES, DAMPINGS):
        head = f"{basis}, β = {printed(beta, '.0e')} s" if beta else f"{basis}, none"
        at = f"paper.choices.{basis}.{beta:g}"
        ours = [cell(*(float(values[f"{at}.{name}.{key}"]) for key in PEAK_AND_ENERGY)) for name in designs.values()]
        rows.append([head, *ours])
    return table(["basis, structural damping", *designs], rows)


PEAK_AND_ENERGY: tuple[Literal["power_peak", "energy"], ...] = ("power_peak", "energy")


def paper_optimal(values: Values) -> str:
    """The paper's loading with each design's optimal damping."""
    rows = []
    for design in ("FSB", "VSWEC90", "VSWEC", "VSWEC0"):
        cells = [design]
        for name in PAPERS:
            at = f"paper.{name}.{design}"
            gains = ["", ""]
            if design != "FSB":
                gains = [
                    f", {printed(values[f'{at}.{gain}'], '+.1f')} %" for gain in ("gain_percent", "best_gain_percent")
                ]
            power, best = (printed(values[f"{at}.{key}"], ".1f") for key in ("power", "best_power"))
            cells += [f"{power}{gains[0]}", f"{printed(values[f'{at}.best_damping'], '.0f')}, {best}{gains[1]}"]
        rows.append(cells)
    head = [
        f"{name}: {text}"
        for name, damper in (("stated", 8000), ("inferred", 6000))
        for text in (f"at {damper} N s/m: W, gain", "at optimal damping: N s/m, W, gain")
    ]
    return table(["", *head], rows)


def case(name: str, values: Values) -> str:
    """Figures of a case of the claims or surprises, as its script prints them."""
    figures = {key.removeprefix(f"{name}."): value for key, value in values.items() if key.startswith(f"{name}.")}
    conditions = str(figures.pop(CONDITIONS, ""))
    numbers = {key: float(value) for key, value in figures.items()}
    return claims.with_conditions(name.partition(".")[2], numbers, conditions)


BLOCKS: Mapping[str, Callable[[Values], str]] = {
    "year": year,
    "last-line": last_line,
    "map": pays_map,
    "when_it_pays": pays_in_a_year,
    "at_force": at_force,
    "at_force-rigid": at_force_rigid,
    "directions": directions,
    "best-buoy": best_buoy,
    "best-buoy-errors": best_buoy_errors,
    "best-buoy-force": best_buoy_force,
    "best-buoy-sites": best_buoy_sites,
    "strain": strain,
    "paper": partial(table_2, "paper", "stated: P = 1800 Pa, c = 8000"),
    "paper_inferred": partial(table_2, "paper_inferred", "inferred: P = 360 Pa, c = 6000"),
    "paper-choices": paper_choices,
    "paper-optimal": paper_optimal,
    **speed.BLOCKS,
    **{name: partial(case, name) for name in SOURCES if name.startswith(("claims.", "surprises."))},
}
"""By the name in the marker."""
