"""What a study's page computes with, gathered from its results: ports at the seas' components, and over the band."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from vsb.motion.port import Port
from vsb.report.band import LOWEST
from vsb.report.living import Grid, LivingSea, study_data, thinned
from vsb.results.force_steps import SeenPort, force_steps
from vsb.results.statistics import families
from vsb.scenes.afloat import linear_buoy, study_port
from vsb.scenes.rest import design_motions
from vsb.study.study import Irregular, IrregularSea, Jonswap, PiersonMoskowitz, RegularWave, StillWater, Study
from vsb.tools.units import FloatArray
from vsb.waves.dispersion import group_velocity
from vsb.waves.seas import components, jonswap_spectrum

MOST = 10_000
"""Most numbers of components of a sea, times designs, that a page holds: those of longer runs are as many."""
SEAS = 24
"""Most seas a reader can choose from."""


def living_study(
    study: Study, database: str, response: xr.Dataset, limited: Sequence[Mapping[str, Any]]
) -> dict[str, Any] | None:
    """Return the data of a study's page; none where no damper's power is known, or a spring or drag loses some of it.

    Nor where waves have directions: a page knows one free velocity of each port.

    Parameters
    ----------
    study : Study
    database : str
        Path of its hydro database.
    response : Dataset
        Its frequency response.
    limited : sequence of mapping
        Of `vsb.results.equal_tuning.Limited`.
    """
    pto = study.pto
    if not study.needs_bem or study.drag or study.directions or (pto.stiffness and pto.efficiency < 1):
        return None
    buoy, basis = linear_buoy(study, database)
    direction, water = study_port(study, buoy, basis), study.water
    low, high = (float(end) for end in buoy.database.omega.values[[0, -1]])
    motions = {design: design_motions(study, basis, design) for design in study.designs}

    def ports(omega: FloatArray) -> dict[str, Port]:
        return {design: buoy.port(omega, free, direction).beside(pto.stiffness) for design, free in motions.items()}

    def grid(omega: FloatArray) -> Grid:
        speed = np.array([group_velocity(w, water.depth, water.gravity) for w in omega])
        return Grid(omega, 0.5 * water.density * water.gravity * speed, ports(omega))

    grids: list[FloatArray] = []
    seas = [_sea(study, name, wave, (low, high), limited, grids) for name, wave in _seas(study).items()]
    if not seas:
        return None
    if pto.efficiency == 1:
        seen = {design: partial(buoy.port, motions=free, direction=direction) for design, free in motions.items()}
        seas = _with_steps(study, seas, seen, (low, study.hydro.omega_max))
    shown = _band(response, max(LOWEST, low), high)
    limit = np.interp(shown, response.omega.values, response.power_limit.values)
    found = [grid(omega) for omega in grids]
    return study_data(found, seas, grid(shown), limit, study.reference_design, pto.efficiency)


def _band(response: xr.Dataset, low: float, high: float) -> FloatArray:
    """Frequencies of the curves over the band, up to where some design takes a hundredth of the most at its best."""
    omega, power = response.omega.values, response.best_power.max("design").values
    high = min(high, float(omega[power >= 0.01 * power.max()].max()))
    inside = omega[(omega >= low) & (omega <= high)]
    return np.asarray(inside[thinned(inside)])


def _seas(study: Study) -> dict[str, RegularWave | Irregular]:
    """One wave of every sea by its name; none of still water."""
    irregular = {waves[0].label: name for name, waves in families(study).items()}
    drawn = (wave for wave in study.drawn_waves if not isinstance(wave, StillWater))
    return {irregular.get(wave.label, wave.label): wave for wave in itertools.islice(drawn, SEAS)}


def _with_steps(
    study: Study, seas: Sequence[LivingSea], seen: Mapping[str, SeenPort], within: tuple[float, float]
) -> list[LivingSea]:
    """Seas with optima at some limits of force, of forces within a band."""
    steps = partial(force_steps, reference=study.reference_design, seas=len(seas), stroke=study.pto.stroke_limit)
    pairs = zip(seas, _seas(study).values(), strict=True)
    return [replace(sea, steps=steps(wave, seen, band=within)) for sea, wave in pairs]


def _sea(
    study: Study,
    name: str,
    wave: RegularWave | Irregular,
    band: tuple[float, float],
    limited: Sequence[Mapping[str, Any]],
    grids: list[FloatArray],
) -> LivingSea:
    """A sea as a page needs it: its components where ports are known, on a grid that is added if it is new."""
    given = {design: study.pto.damper(design) for design in study.designs}
    within = {str(line["design"]): float(line["power"]) for line in limited if line["sea"] == name}
    squares, jonswap = None, None
    if isinstance(wave, IrregularSea):
        duration = min(study.simulation.duration, _longest(study))
        omega, amplitude = components(wave, study.hydro.omega_max, duration)
        width = 2 * float(omega[0]) if isinstance(wave, Jonswap | PiersonMoskowitz) else 0.0
        known = (omega >= band[0]) & (omega <= band[1])
        omega, squares = omega[known], amplitude[known] ** 2
        if isinstance(wave, Jonswap | PiersonMoskowitz):
            squares, jonswap = None, _jonswap(wave, width, band)
    else:
        omega, squares = np.array([wave.omega]), np.array([wave.amplitude**2])
    same = (i for i, grid in enumerate(grids) if np.array_equal(grid, omega))
    place = next(same, len(grids))
    if place == len(grids):
        grids.append(omega)
    return LivingSea(wave.description, place, squares, jonswap, given, within)


def _longest(study: Study) -> float:
    """Longest run whose components a page has room for [s]."""
    return 2 * math.pi * MOST / (1.1 * study.hydro.omega_max * len(study.designs))


def _jonswap(wave: Jonswap | PiersonMoskowitz, width: float, band: tuple[float, float]) -> dict[str, float]:
    """Parameters of a spectrum, and peak periods between which it lies within a band of frequencies."""
    gamma = wave.gamma if isinstance(wave, Jonswap) else 1.0
    periods = 2 * math.pi / np.array(band)
    own = {"hs": wave.hs, "tp": wave.tp, "gamma": gamma, "width": width, "integral": _integral(gamma)}
    return own | {"shortest": min(wave.tp, 5 * float(periods[1])), "longest": max(wave.tp, 0.5 * float(periods[0]))}


def _integral(gamma: float) -> float:
    """Integral of x^-5 exp(-1.25 x^-4) bump over x, frequencies of a JONSWAP sea in terms of its peak's [-]."""
    return math.exp(-1.25) * gamma / float(jonswap_spectrum(np.array([1.0]), 4.0, 2 * math.pi, gamma)[0])
