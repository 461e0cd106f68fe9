"""The data of a page's scripts: ports and seas, from which a choice of damping gives powers, and animated designs.

The scripts use the algebra of `vsb.engine.motion.port`: a damping c absorbs c |Z V0|^2 / (2 |Z + c|^2) per squared wave
amplitude, and in a sea the sum over its components. Numbers are base64 of little-endian floats. Motion is that of runs
in store: frames, thinned, and the shapes of the shell or hull.
"""

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import markupsafe
import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.engine.hydro.bodies.body import DISPLACED, OUTLINE
from vsb.engine.hydro.variables import motion_of
from vsb.engine.motion.port import Port
from vsb.engine.waves.climate import YEAR_HOURS, Climate
from vsb.engine.waves.seas import Sea, superposed
from vsb.engine.waves.water import Water, wavenumber
from vsb.report.canvas import style
from vsb.report.shell_figures import round_factor
from vsb.results.year import band_weights, bins_of
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import FORCE, PortKind
from vsb.tools.words import superscripts

if TYPE_CHECKING:
    from vsb.results.constrained_year import ForceSteps  # imports compiled code


DASHES = {"-": "", "--": "7 3", "-.": "8 3 2 3", ":": "2 3"}
"""Line styles of designs in SVG."""
MOST_FREQUENCIES = 240
"""Of the curves over the band."""


@dataclass(frozen=True)
class Grid:
    """Frequencies that seas share, and the ports there, the take-off's spring included."""

    omega: FloatArray  # (component,) [rad/s]
    flux: FloatArray  # energy flux per squared amplitude, rho g v_g/2 (component,) [W/m^3]
    ports: Mapping[str, Port]  # by design


@dataclass(frozen=True)
class InteractiveSea:
    """A sea of a study on one of its grids: squared amplitudes, or the parameters of a spectrum."""

    words: str
    grid: int
    squares: FloatArray | None  # of the components' amplitudes (component,) [m^2]; None of a spectrum
    jonswap: dict[str, float] | None = None  # parameters of the spectrum, see `algebra.js`
    given: Mapping[str, float | None] | None = None  # given damping by design
    limited: Mapping[str, float] | None = None  # power of the optimum within limits by design, where known [W]
    steps: "ForceSteps | None" = None  # optima at further limits of force
    band: int = 0  # which of the curves over the band has its direction


def packed(values: npt.ArrayLike, kind: str = "<f4") -> str:
    """Return numbers as base64 of little-endian floats, by default of four bytes."""
    return base64.b64encode(np.asarray(values, dtype=kind).tobytes()).decode()


def designs_data(designs: Sequence[str], reference: str | None) -> list[dict[str, Any]]:
    """Return names and styles of designs, the same as in all figures, and which one gains are measured against."""
    looks = {name: style(name, designs, reference) for name in designs}
    return [
        {"name": name, "colour": look["color"], "dash": DASHES[look["linestyle"]], "reference": name == reference}
        for name, look in looks.items()
    ]


def study_data(
    grids: Sequence[Grid],
    seas: Sequence[InteractiveSea],
    bands: Sequence[Grid],
    limit: FloatArray,
    reference: str | None,
    efficiency: float = 1.0,
    bound: str = "λ/2π",
    kind: PortKind = FORCE,
) -> dict[str, Any]:
    """Return the data of a study's page: seas on their grids, and curves over a band for each direction of these.

    `limit` is the largest power of a body of revolution at the bands' frequencies [W/m^2], `bound` its capture width,
    empty where it does not hold; gains are against `reference`.
    """
    designs = list(bands[0].ports)
    return {
        "kind": "study",
        "port": _port_units(kind),
        "efficiency": efficiency,
        "designs": designs_data(designs, reference),
        "bands": [_grid_data(band) for band in bands],
        "limit": packed(limit),
        "bound": bound,
        "grids": [_grid_data(grid) for grid in grids],
        "seas": [_sea_data(sea, designs) for sea in seas],
    }


def _sea_data(sea: InteractiveSea, designs: Sequence[str]) -> dict[str, Any]:
    """A sea, packed."""
    steps = sea.steps and {
        "limits": sea.steps.limits,
        "of": sea.steps.of,
        "repeats": sea.steps.repeats,
        "powers": [sea.steps.powers[design] for design in designs],
    }
    return {
        "words": sea.words,
        "grid": sea.grid,
        "band": sea.band,
        "squares": None if sea.squares is None else packed(sea.squares),
        "jonswap": sea.jonswap,
        "given": [(sea.given or {}).get(design) for design in designs],
        "limited": [(sea.limited or {}).get(design) for design in designs],
        "steps": steps,
    }


def _grid_data(grid: Grid) -> dict[str, Any]:
    """A grid, packed; frequencies to all digits, because spectra are steep."""
    ports = [{**port_data(port), "matched": packed(port.matched_power)} for port in grid.ports.values()]
    return {"omega": packed(grid.omega, "<f8"), "flux": packed(grid.flux), "ports": ports}


def port_data(port: Port) -> dict[str, str]:
    """Return what power follows from: |Z V0|^2, R and X, packed."""
    impedance = port.impedance
    return {
        "drive": packed(np.abs(impedance * port.velocity) ** 2),
        "resistance": packed(impedance.real),
        "reactance": packed(impedance.imag),
    }


def _port_units(kind: PortKind) -> dict[str, str]:
    """Name and units of the load of a port, and the unit of damping."""
    return {"load": kind.load, "load_unit": kind.load_unit, "damping": superscripts(kind.damping_unit)}


def year_data(
    climate: Climate,
    points: Sequence[Mapping[str, Any]],
    designs: Sequence[str],
    reference: str | None,
    kind: PortKind = FORCE,
) -> dict[str, Any]:
    """Return the data of a campaign's page: mean spectra of the bins of a year, and ports of some of its points.

    A point has `words`; `ports` by design, at frequencies that contain the edges of the climate's bands; `given`
    damping by design; energy `flux` of every sea [W/m]; `efficiency` of conversion. Power is linear in the spectrum, so
    the mean power of the seas of a bin is that of their mean spectrum.
    """
    bins = bins_of(climate)
    share = bins.share.ravel()[bins.occupied]
    density = np.array(
        [bins.total(climate.hours * band).ravel()[bins.occupied] / share for band in climate.density.T]
    ).T
    row, column = np.unravel_index(bins.occupied, bins.shape)
    return {
        "kind": "year",
        "port": _port_units(kind),
        "name": climate.name,
        "hours": YEAR_HOURS,
        "designs": designs_data(designs, reference),
        "bins": {
            "hs": list(bins.hs_centres), "te": list(bins.te_centres), "row": row.tolist(), "column": column.tolist(),
            "share": packed(share, "<f8"), "density": packed(density.ravel(), "<f8"), "bands": len(climate.omega),
        },
        "points": [_point_data(point, climate, designs) for point in points],
    }  # fmt: skip


def _point_data(point: Mapping[str, Any], climate: Climate, designs: Sequence[str]) -> dict[str, Any]:
    """A point, packed; the matrix of weights of frequencies in bands is sparse."""
    ports: Mapping[str, Port] = point["ports"]
    weights = band_weights(next(iter(ports.values())).omega, climate)
    band, at = np.nonzero(weights)
    part = float(point.get("efficiency", 1.0))  # of the power of every damper
    return {
        "words": point["words"],
        "flux": float(point["flux"] @ climate.hours),
        "given": [point["given"].get(design) for design in designs],
        "ports": [port_data(ports[design]) if design in ports else None for design in designs],
        "weights": {"band": packed(band), "at": packed(at), "value": packed(part * weights[band, at], "<f8")},
    }


def thinned(omega: FloatArray) -> FloatArray:
    """Return indices of at most `MOST_FREQUENCIES` evenly chosen frequencies, the last included."""
    return np.unique(np.linspace(0, len(omega) - 1, min(MOST_FREQUENCIES, len(omega))).astype(int))


def as_script(data: Mapping[str, Any]) -> markupsafe.Markup:
    """Return data as JSON that may stand inside a script element."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return markupsafe.Markup(text.replace("<", "\\u003c"))


PER_PERIOD = 24
"""Frames of a period."""
PERIODS = 8
"""Periods of a sea that are shown, the last ones of its window."""
COLATITUDES = 46
"""Points of a meridian."""
ACROSS = 9
"""Points of the water surface around a buoy."""
ACROSS_BODY = 65
"""Points of the water surface around a body, which may be longer than waves."""
SEEN = 1.7
"""Half the width of the water around a buoy [radii]."""
LIVELY = 400
"""Moments of a run at which the motion of a body is measured."""
RIGID = {"heave": "Heave", "surge": "Surge", "pitch": "Pitch"}
"""Rigid motions in the plane that is drawn, by their name in the page's data."""
FROM_LEFT = "Waves come from the left; dotted: undeformed."
PLANE = (
    "The view is the vertical plane of surge, about its mean; a drifting buoy is followed. Waves towards 0 degrees "
    "come from the left; dotted: undeformed, with the line from the centre to the top."
)
HULL = (
    "The view is the vertical plane along x, {:.3g} m wide: the wetted hull cut through the middle of each body, surge "
    "about its mean, and the undisturbed water at y = {:g} m. Waves towards 0 degrees come from the left; dotted: at "
    "rest."
)


class View(NamedTuple):
    """A piece of water that is drawn."""

    width: float  # half of it [m]
    middle: tuple[float, float] = (0.0, 0.0)  # x and y [m]
    across: int = ACROSS  # points of the surface


def shapes_data(modes: xr.Dataset) -> dict[str, Any]:
    """Return the shapes of the shell along a meridian, of stage `modes`, thinned, and its amplitudes at rest."""
    kept = np.linspace(0, modes.sizes["colatitude"] - 1, COLATITUDES).astype(int)
    return {
        "radius": float(modes.attrs["radius"]),
        "centre": float(modes.attrs["centre_height"]),
        "colatitude": packed(modes.colatitude.values[kept]),
        "radial": packed(modes.radial.values[:, kept].ravel()),
        "meridional": packed(modes.meridional.values[:, kept].ravel()),
        "rest": packed(modes.static_amplitude.values),
        **({"order": packed(modes["order"].values)} if "order" in modes else {}),
        **{name: packed(modes[name].values[kept]) for name in ("rest_radial", "rest_meridional") if name in modes},
    }


def frames_data(
    words: str,
    runs: Mapping[str, xr.DataArray],
    waves: Sea,
    span: tuple[float, float],
    period: float,
    view: View,
    water: Water,
    shell: Sequence[str],
    direction: float = 0.0,
) -> dict[str, Any]:
    """Return the frames of one sea: time, water surface, rigid motions and shell amplitudes of every design.

    Positions `runs` [m] by design over the last `PERIODS` of the `span` [s]; `waves` have no components in still water;
    `shell` are the labels of the modes, of a body of all its degrees of freedom; the waves travel to `direction` [rad].
    """
    start, end = max(span[0], span[1] - PERIODS * period), span[1]
    time = np.linspace(start, end, int(PER_PERIOD * (end - start) / period) + 2)
    x, y = view.middle[0] + view.width * np.linspace(-1, 1, view.across), view.middle[1]
    place = x * np.cos(direction) + y * np.sin(direction)
    return {
        "words": words,
        "start": float(time[0]),
        "step": float(time[1] - time[0]),
        "frames": len(time),
        "calm": not len(waves.omega),
        "surface": packed(surface(waves, time, place, water).ravel()),
        "designs": [_amplitudes(run, time, shell) for run in runs.values()],
    }


def surface(waves: Sea, time: FloatArray, place: FloatArray, water: Water) -> FloatArray:
    """Return the undisturbed surface Re sum a exp(i(k x - w t)), shape (time, place) [m]; flat in still water."""
    if not len(waves.omega):
        return np.zeros((len(time), len(place)))
    number = np.array([wavenumber(w, water.depth, water.gravity) for w in waves.omega])
    amplitude = waves.amplitude[:, None] * np.exp(1j * number[:, None] * place)
    return superposed(waves.omega, amplitude, time)


def _amplitudes(run: xr.DataArray, time: FloatArray, shell: Sequence[str]) -> dict[str, Any]:
    """Motions in the plane that is drawn at some times, surge without its drift; no shell of a rigid design."""
    moved = np.array([np.interp(time, run.time.values, column) for column in run.values.T]).T
    at = without_drift(xr.DataArray(moved, {"time": time, "dof": run.dof.values}, ("time", "dof")))
    found = dict(zip(map(str, at.dof.values), at.values.T, strict=True))
    rigid = {name: packed(found[label]) for name, label in RIGID.items() if label in found}
    none = np.zeros(len(time))
    shown = [found.get(label, none) for label in shell] if set(shell) & set(found) else []
    return {**rigid, "modes": len(shown), "shell": packed(np.array(shown).T.ravel())}


def without_drift(position: xr.DataArray) -> xr.DataArray:
    """Return positions, dims (time, dof), with the surge of every body about its mean and drift."""
    time, values = position.time.values, position.values.copy()
    for i in (i for i, label in enumerate(position.dof.values) if motion_of(str(label)) == "Surge"):
        surge = values[:, i]  # the drift is the line through the means of the first and of the last period
        velocity = (surge[-PER_PERIOD:].mean() - surge[:PER_PERIOD].mean()) / (
            time[-PER_PERIOD:].mean() - time[:PER_PERIOD].mean() or np.inf
        )
        values[:, i] = surge - (surge.mean() + velocity * (time - time.mean()))
    return position.copy(data=values)


def largest_shell(run: xr.DataArray, shell: Sequence[str]) -> float:
    """Return the largest amplitude of the shell modes of a run [m]; zero of a rigid design."""
    moved = run.isel(dof=run.dof.isin(list(shell)).values)
    return float(abs(moved).max()) if moved.size else 0.0


def displaced_outline(ds: xr.Dataset, position: xr.DataArray) -> FloatArray:
    """Return the lines of a body displaced in the x-z plane, shape (time, line, end, xz) [m].

    Points x move to x + sum_i q_i psi_i(x), as linear theory has it, rotations included: q is `position`, psi the
    `outline_displacement` of its hydro database.
    """
    moved = ds[DISPLACED].sel(influenced_dof=position.dof.values).values[..., ::2]
    return np.asarray(ds[OUTLINE].values[..., ::2] + np.tensordot(position.values, moved, 1))


def largest_motion(ds: xr.Dataset, run: xr.Dataset) -> float:
    """Return the largest displacement in a run of a body without its drift, or elevation if that is larger [m]."""
    seen = run.isel(time=np.linspace(0, run.sizes["time"] - 1, LIVELY).astype(int))
    moved = displaced_outline(ds, without_drift(seen.position)) - ds[OUTLINE].values[..., ::2]
    return max(float(np.abs(moved).max()), float(np.abs(run.elevation).max()))


def outline_data(ds: xr.Dataset, largest: float) -> tuple[View, dict[str, Any]]:
    """Return the view of a body with room for its largest motion [m]; factor on motion, shapes, what is seen of z."""
    points = ds[OUTLINE].values
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    size, middle = max(high[0] - low[0], -low[2]) / 2, (low + high) / 2
    factor = round_factor(largest, size)
    beside = max(0.35 * size, 1.3 * factor * largest)
    view = View(float(size + beside), (float(middle[0]), float(middle[1])), ACROSS_BODY)
    shapes = {
        "outline": packed(points[..., ::2].ravel()),
        "displacement": packed(ds[DISPLACED].values[..., ::2].ravel()),
    }
    seen = {"middle": list(view.middle), "top": float(beside), "bottom": float(beside - low[2])}
    return view, {"factor": factor, "shapes": shapes, **seen}


def in_motion(animated: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return what a page says of animated buoys, and their data for its scripts; None of none."""
    if animated is None:
        return None
    seas, factor = animated["seas"], animated["factor"]
    of_body = "outline" in animated["shapes"]
    names = [design["name"] for design in animated["designs"]]
    shown = f"{', '.join(names)}{' side by side' if len(names) > 1 and not of_body else ''}"
    if factor <= 1:
        scale = "all is to scale"
    elif of_body:
        scale = f"motion and waves are magnified {factor:g} times"
    else:
        scale = f"shell displacement is magnified {factor:g} times, heave and waves are to scale"
    if of_body:
        view = HULL.format(2 * animated["width"], round(animated["middle"][1], 3) + 0.0)
    elif any("surge" in design for sea in seas for design in sea["designs"]):
        view = PLANE
    else:
        view = "Dotted: undeformed." if all(sea["calm"] for sea in seas) else FROM_LEFT
    words = f"{animated.get('message', '')} {shown}; {scale}.".strip()
    title = "The body in the waves" if of_body else "The buoys in the waves"
    return {"title": title, "words": words, "view": view, "data": as_script(animated)}
