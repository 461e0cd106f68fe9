"""What a study's page computes with, gathered from its results: ports at the seas' components, and over the band."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from vsb.report.band import lowest
from vsb.report.living import Grid, LivingSea, study_data, thinned
from vsb.results.comparison import in_direction
from vsb.results.force_steps import SeenPort, force_steps
from vsb.results.statistics import families
from vsb.scenes.floating_system import AnyStudy, FloatingSystem, band, floating_system
from vsb.scenes.floating_system import towards as headed
from vsb.study.study import Irregular, IrregularSea, Jonswap, PiersonMoskowitz, RegularWave, StillWater, Study
from vsb.study.take_off import port_kind
from vsb.tools.arrays import FloatArray
from vsb.waves.dispersion import group_velocity
from vsb.waves.seas import components, jonswap_spectrum

MOST = 10_000
"""Most numbers of components of a sea, times designs, that a page holds: those of longer runs are as many."""
SEAS = 24
"""Most seas a reader can choose from."""


def living_study(
    study: AnyStudy, database: str, response: xr.Dataset, limited: Sequence[Mapping[str, Any]]
) -> dict[str, Any] | None:
    """Return the data of a study's page; none where no damper's power is known, or a spring or drag loses some of it.

    Parameters
    ----------
    study : Study or BodyStudy
    database : str
        Path of its hydro database.
    response : Dataset
        Its frequency response.
    limited : sequence of mapping
        Of `vsb.results.gains.Limited`.

    Notes
    -----
    A port has a free velocity for every direction waves go to: seas share a grid if they share both.
    """
    pto = study.pto
    dragged = isinstance(study, Study) and study.drag
    if not study.needs_bem or dragged or pto.spring_costs:
        return None
    seen, waves = _Seen(study, floating_system(study, database)), _seas(study)
    if not waves:
        return None
    ds = seen.floating.linear.database
    low, high, highest = float(ds.omega[0]), float(ds.omega[-1]), band(study, ds)[1]
    grids: list[tuple[FloatArray, float]] = []
    seas = [_sea(study, name, wave, (low, high), highest, limited, grids) for name, wave in waves.items()]
    going = list(dict.fromkeys(wave.direction for wave in waves.values()))
    seas = [replace(sea, band=going.index(wave.direction)) for sea, wave in zip(seas, waves.values(), strict=True)]
    if pto.efficiency == 1:
        seas = seen.with_steps(seas, list(waves.values()), (low, highest))
    shown = _band(in_direction(response, study.waves[0]), max(lowest(low, high), low), high)
    limit = np.interp(shown, response.omega.values, response.power_limit.values)
    bands, bound = [seen.grid(shown, towards) for towards in going], response.attrs.get("limit", "λ/2π")
    on = [seen.grid(*one) for one in grids]
    return study_data(on, seas, bands, limit, study.reference_design, pto.efficiency, bound, port_kind(pto.port))


@dataclass(frozen=True)
class _Seen:
    """What the take-off of a study sees of all designs, in waves of any direction [degrees]."""

    study: AnyStudy
    floating: FloatingSystem

    def ports(self, towards: float) -> dict[str, SeenPort]:
        """Ports by design, to be had at any frequencies."""
        linear, port = headed(self.floating.linear, towards), self.floating.port
        motions = self.floating.motions
        return {name: partial(linear.extended_port, motions=n, direction=port) for name, n in motions.items()}

    def grid(self, omega: FloatArray, towards: float) -> Grid:
        """Ports beside the spring, and what energy waves bring, at some frequencies."""
        water, spring = self.study.water, self.study.pto.stiffness
        speed = np.array([group_velocity(w, water.depth, water.gravity) for w in omega])
        ports = {design: port(omega).beside(spring) for design, port in self.ports(towards).items()}
        return Grid(omega, 0.5 * water.density * water.gravity * speed, ports)

    def with_steps(
        self, seas: Sequence[LivingSea], waves: Sequence[RegularWave | Irregular], within: tuple[float, float]
    ) -> list[LivingSea]:
        """Seas with optima at some limits of force, of forces within a band."""
        study, stroke = self.study, self.study.pto.stroke_limit
        steps = partial(force_steps, reference=study.reference_design, seas=len(seas), stroke=stroke, band=within)
        pairs = zip(seas, waves, strict=True)
        return [replace(sea, steps=steps(wave, self.ports(wave.direction))) for sea, wave in pairs]


def _band(response: xr.Dataset, low: float, high: float) -> FloatArray:
    """Frequencies of the curves over the band, up to where some design takes a hundredth of the most at its best."""
    omega, power = response.omega.values, response.best_power.max("design").values
    high = min(high, float(omega[power >= 0.01 * power.max()].max()))
    inside = omega[(omega >= low) & (omega <= high)]
    return np.asarray(inside[thinned(inside)])


def _seas(study: AnyStudy) -> dict[str, RegularWave | Irregular]:
    """One wave of every sea by its name; none of still water."""
    irregular = {waves[0].label: name for name, waves in families(study).items()}
    drawn = (wave for wave in study.drawn_waves if not isinstance(wave, StillWater))
    return {irregular.get(wave.label, wave.label): wave for wave in itertools.islice(drawn, SEAS)}


def _sea(
    study: AnyStudy,
    name: str,
    wave: RegularWave | Irregular,
    known: tuple[float, float],
    highest: float,
    limited: Sequence[Mapping[str, Any]],
    grids: list[tuple[FloatArray, float]],
) -> LivingSea:
    """A sea as a page needs it: its components where ports are known, on a grid that is added if it is new."""
    given = {design: study.pto.damper(design) for design in study.designs}
    within = {str(line["design"]): float(line["power"]) for line in limited if line["sea"] == name}
    squares, jonswap = None, None
    if isinstance(wave, IrregularSea):
        duration = min(study.simulation.duration, _longest(len(study.designs), highest))
        omega, amplitude = components(wave, highest, duration)
        width = 2 * float(omega[0]) if isinstance(wave, Jonswap | PiersonMoskowitz) else 0.0
        kept = (omega >= known[0]) & (omega <= known[1])
        omega, squares = omega[kept], amplitude[kept] ** 2
        if isinstance(wave, Jonswap | PiersonMoskowitz):
            squares, jonswap = None, _jonswap(wave, width, known)
    else:
        omega, squares = np.array([wave.omega]), np.array([wave.amplitude**2])
    same = (i for i, (on, to) in enumerate(grids) if to == wave.direction and np.array_equal(on, omega))
    place = next(same, len(grids))
    if place == len(grids):
        grids.append((omega, wave.direction))
    return LivingSea(wave.description, place, squares, jonswap, given, within)


def _longest(designs: int, highest: float) -> float:
    """Longest run whose components a page has room for [s], by how many designs there are and the highest frequency."""
    return 2 * math.pi * MOST / (1.1 * highest * designs)


def _jonswap(wave: Jonswap | PiersonMoskowitz, width: float, band: tuple[float, float]) -> dict[str, float]:
    """Parameters of a spectrum, and peak periods between which it lies within a band of frequencies."""
    gamma = wave.gamma if isinstance(wave, Jonswap) else 1.0
    periods = 2 * math.pi / np.array(band)
    own = {"hs": wave.hs, "tp": wave.tp, "gamma": gamma, "width": width, "integral": _integral(gamma)}
    return own | {"shortest": min(wave.tp, 5 * float(periods[1])), "longest": max(wave.tp, 0.5 * float(periods[0]))}


def _integral(gamma: float) -> float:
    """Integral of x^-5 exp(-1.25 x^-4) bump over x, frequencies of a JONSWAP sea in terms of its peak's [-]."""
    return math.exp(-1.25) * gamma / float(jonswap_spectrum(np.array([1.0]), 4.0, 2 * math.pi, gamma)[0])
