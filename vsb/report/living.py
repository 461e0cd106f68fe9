"""The numbers a page computes with: ports and seas, so that a reader can drag the damper.

The page's algebra is that of `vsb.motion.port`: a damper c takes c |Z V0|^2 / (2 |Z + c|^2) per squared amplitude, and
of a sea the sum of that over its components. Numbers travel as base64 of little-endian floats.
"""

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import markupsafe
import numpy as np
import numpy.typing as npt

from vsb.motion.port import Port
from vsb.report.canvas import style
from vsb.results.year import band_weights, bins_of
from vsb.tools.arrays import FloatArray
from vsb.tools.ports import FORCE, PortKind
from vsb.tools.words import superscripts
from vsb.waves.climate import YEAR_HOURS, Climate

if TYPE_CHECKING:
    from vsb.results.force_steps import ForceSteps  # which reads what is compiled

DASHES = {"-": "", "--": "7 3", "-.": "8 3 2 3", ":": "2 3"}
"""Line styles of designs as SVG has them."""
SHOWN = 240
"""Most frequencies of the curves over the band."""


@dataclass(frozen=True)
class Grid:
    """Components that seas share, and the ports at their frequencies, the take-off's spring built in."""

    omega: FloatArray  # (component,) [rad/s]
    flux: FloatArray  # energy flux per squared amplitude, rho g v_g/2 (component,) [W/m^3]
    ports: Mapping[str, Port]  # by design


@dataclass(frozen=True)
class LivingSea:
    """A sea of a study as a page needs it: on one of its grids, by squared amplitudes or by parameters."""

    words: str
    grid: int
    squares: FloatArray | None  # of the components' amplitudes (component,) [m^2]; none of a sea by parameters
    jonswap: dict[str, float] | None = None  # of its spectrum, see `algebra.js`
    given: Mapping[str, float | None] | None = None  # dampers as given [N s/m]
    limited: Mapping[str, float] | None = None  # power of the optimum within limits by design, where known [W]
    steps: "ForceSteps | None" = None  # optima at further limits of force
    band: int = 0  # which of the curves over the band is of its direction


def packed(values: npt.ArrayLike, kind: str = "<f4") -> str:
    """Return numbers as base64 of little-endian floats, by default of four bytes."""
    return base64.b64encode(np.asarray(values, dtype=kind).tobytes()).decode()


def port_data(port: Port) -> dict[str, str]:
    """Return what a damper's power follows from: |Z V0|^2, R and X, packed."""
    impedance = port.impedance
    return {
        "drive": packed(np.abs(impedance * port.velocity) ** 2),
        "resistance": packed(impedance.real),
        "reactance": packed(impedance.imag),
    }


def designs_data(designs: Sequence[str], reference: str | None) -> list[dict[str, Any]]:
    """Return names and looks of designs, those of all figures, and which one gains are over."""
    looks = {name: style(name, designs) for name in designs}
    return [
        {"name": name, "colour": look["color"], "dash": DASHES[look["linestyle"]], "reference": name == reference}
        for name, look in looks.items()
    ]


def study_data(
    grids: Sequence[Grid],
    seas: Sequence[LivingSea],
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
    grids : sequence of Grid
    seas : sequence of LivingSea
        On those grids.
    bands : sequence of Grid
        Over the band figures show, of each direction seas go to.
    limit : ndarray, shape (omega,) [W/m^2]
        Over the same frequencies, the most a body of revolution takes.
    reference : str or None
        The design gains are over.
    efficiency : float
        Of the take-off [-].
    bound : str
        The capture width of that limit.
    kind : PortKind
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
        "seas": [
            {
                "words": sea.words,
                "grid": sea.grid,
                "band": sea.band,
                "squares": None if sea.squares is None else packed(sea.squares),
                "jonswap": sea.jonswap,
                "given": [(sea.given or {}).get(design) for design in designs],
                "limited": [(sea.limited or {}).get(design) for design in designs],
                "steps": sea.steps and _steps_data(sea.steps, designs),
            }
            for sea in seas
        ],
    }


def _steps_data(steps: "ForceSteps", designs: Sequence[str]) -> dict[str, Any]:
    """Optima at some limits of force, design by design."""
    powers = [steps.powers[design] for design in designs]
    return {"limits": steps.limits, "of": steps.of, "repeats": steps.repeats, "powers": powers}


def _grid_data(grid: Grid) -> dict[str, Any]:
    """A grid, packed; frequencies to all digits, because spectra are steep."""
    ports = [{**port_data(port), "matched": packed(port.matched_power)} for port in grid.ports.values()]
    return {"omega": packed(grid.omega, "<f8"), "flux": packed(grid.flux), "ports": ports}


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
    climate : Climate
    points : sequence of mapping
        `words`; `ports` by design, at frequencies that hold the edges of the climate's bands; dampers `given` by
        design [N s/m]; energy `flux` of every sea [W/m].
    designs : sequence of str
    reference : str or None
        The design gains are over.
    kind : PortKind

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


def _port_units(kind: PortKind) -> dict[str, str]:
    """What scripts say of a port."""
    return {"load": kind.load, "load_unit": kind.load_unit, "damping": superscripts(kind.damping_unit)}


def _point_data(point: Mapping[str, Any], climate: Climate, designs: Sequence[str]) -> dict[str, Any]:
    """A point, packed; weights of frequencies in bands are few, so each stands with its place."""
    ports: Mapping[str, Port] = point["ports"]
    weights = band_weights(next(iter(ports.values())).omega, climate)
    band, at = np.nonzero(weights)
    return {
        "words": point["words"],
        "flux": float(point["flux"] @ climate.hours),
        "given": [point["given"].get(design) for design in designs],
        "ports": [port_data(ports[design]) if design in ports else None for design in designs],
        "weights": {"band": packed(band), "at": packed(at), "value": packed(weights[band, at], "<f8")},
    }


def thinned(omega: FloatArray, most: int = SHOWN) -> FloatArray:
    """Return every so-many-th index of frequencies, the last included."""
    return np.unique(np.linspace(0, len(omega) - 1, min(most, len(omega))).astype(int))


def as_script(data: Mapping[str, Any]) -> markupsafe.Markup:
    """Return data as JSON that may stand inside a script element."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return markupsafe.Markup(text.replace("<", "\\u003c"))
