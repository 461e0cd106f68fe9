"""The data of a page's scripts: ports and seas, from which a reader's choice of damping gives powers and gains.

The scripts use the algebra of `vsb.engine.motion.port`: a damping c absorbs c |Z V0|^2 / (2 |Z + c|^2) per squared wave
amplitude, and in a sea the sum over its components. Numbers are base64 of little-endian floats.
"""

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import markupsafe
import numpy as np
import numpy.typing as npt

from vsb.engine.motion.port import Port
from vsb.engine.waves.climate import YEAR_HOURS, Climate
from vsb.report.canvas import style
from vsb.results.year import band_weights, bins_of
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import FORCE, PortKind
from vsb.tools.words import superscripts

if TYPE_CHECKING:
    from vsb.results.force_steps import ForceSteps  # imports compiled code

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
    """Return the data of a study's page.

    Parameters
    ----------
    seas : sequence of InteractiveSea
        On those grids.
    bands : sequence of Grid
        For the curves over the band, one for each direction of the seas.
    limit : ndarray, shape (omega,) [W/m^2]
        Largest power of a body of revolution at the same frequencies.
    reference : str or None
        The design gains are measured against.
    efficiency : float
        Of the take-off [-].
    bound : str
        The capture width of that limit; empty where it does not hold.
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

    Parameters
    ----------
    points : sequence of mapping
        `words`; `ports` by design, at frequencies that contain the edges of the climate's bands; `given` damping by
        design; energy `flux` of every sea [W/m]; `efficiency` of conversion, if it is not 1.
    reference : str or None
        The design gains are measured against.

    Notes
    -----
    Power is linear in the spectrum, so the mean power of the seas of a bin is that of their mean spectrum.
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


def thinned(omega: FloatArray, most: int = MOST_FREQUENCIES) -> FloatArray:
    """Return indices of evenly chosen frequencies, at most so many, the last included."""
    return np.unique(np.linspace(0, len(omega) - 1, min(most, len(omega))).astype(int))


def as_script(data: Mapping[str, Any]) -> markupsafe.Markup:
    """Return data as JSON that may stand inside a script element."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return markupsafe.Markup(text.replace("<", "\\u003c"))
