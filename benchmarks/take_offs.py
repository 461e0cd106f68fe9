"""Best take-offs of many seas against plain methods in one run: seconds, their ratio, and error.

Dampers and pairs of four designs in 200 seas against a search by scipy in each sea; the optimum under a limit of force
against the same interior point with its matrix multiplied out. Seconds are of one machine, ratios are not.
"""

from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor
from scipy.optimize import minimize, minimize_scalar

from benchmarks.measure import Row, as_csv, timed
from vsb.motion.constrained import optimum_in_sea
from vsb.motion.force_bound import NODES, Limits
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.motion.tuning import Load, best_dampers, best_pairs, mean_power
from vsb.tools.files import write_text
from vsb.tools.units import FloatArray
from vsb.waves.seas import Sea

SEAS, COMPONENTS, SPACING = 200, 125, 0.08
"""Seas, components of each and their distance [rad/s]: records of 80 s."""
OMEGA = SPACING * np.arange(1, COMPONENTS + 1)
"""Their frequencies [rad/s]."""
SEARCHED = 20
"""Seas in which the plain method is run: it takes the same in all."""
LIMITED = 10
COLUMNS = ("case", "method", "seas", "seconds_per_sea", "ratio", "error")


def ports(omega: FloatArray) -> list[Port]:
    """Four buoys of two motions, one beside the other: what shells of other stiffness look like at the port."""
    found = []
    for stiffness in (9e4, 1.8e5, 4e5, 1.2e6):
        rate = -1j * omega
        heave = rate * 2.6e4 + 9e3 * omega**3 * np.exp(-omega) + 1.2e5 / rate
        shell = rate * 3e3 + 40.0 + stiffness / rate
        y = 1 / heave + 1 / shell
        pushed = 1.0 / heave + 0.1 / shell
        compliance = 1 / 1.2e5 + 1 / stiffness
        found.append(Port(omega, np.asarray(y), np.asarray(1e5 * np.exp(-omega / 2) * pushed), compliance))
    return found


def seas() -> FloatArray:
    """Squared amplitudes of seas of one peak each, shape (sea, omega) [m^2]."""
    rng, omega = np.random.default_rng(1), OMEGA
    peak, width = rng.uniform(0.6, 2.5, (2, SEAS, 1))
    return np.asarray(np.exp(-0.5 * ((omega - peak) / (0.2 * width)) ** 2) * rng.exponential(size=(SEAS, COMPONENTS)))


def searched_damper(port: Port, sea: FloatArray) -> float:
    """Mean power of the best damper of a sea by a scan and Brent's method [W]."""

    def loss(u: float) -> float:
        return -float(mean_power(port, sea[None], np.exp([u]), np.zeros(1))[0])

    tried = np.log(np.geomspace(port.best_damping.min(), port.best_damping.max(), 60))
    near = min(tried, key=loss)
    step = float(tried[1] - tried[0])
    return -float(minimize_scalar(loss, bounds=(near - step, near + step), method="bounded").fun)


def searched_pair(port: Port, sea: FloatArray) -> float:
    """Mean power of the best spring and damper of a sea by a scan and a simplex [W]."""
    softest = port.softest_spring

    def loss(x: FloatArray) -> float:
        k = softest + np.exp(x[1:])
        return -float(mean_power(port, sea[None], np.exp(x[:1]), k)[0])

    dampers = np.log(np.geomspace(port.impedance.real.min(), port.best_damping.max(), 24))
    springs = np.log(-softest) + np.linspace(-6, 3, 40)
    first = min((np.array([u, v]) for u in dampers for v in springs), key=loss)
    return -float(minimize(loss, first, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-9}).fun)


def reactive(port: Port, squares: FloatArray) -> Load:
    """The best spring and damper of every sea."""
    return best_pairs(port, squares, best_dampers(port, squares))


CASES = {"damper": (best_dampers, searched_damper), "spring and damper": (reactive, searched_pair)}
"""Rung -> of all seas at once, and by a search in one."""


def linear_rows(case: str) -> list[Row]:
    """A rung of four designs in all seas, beside its plain search: error is the most by which a search is better."""
    (ours, plain), squares, every = CASES[case], seas(), ports(OMEGA)
    seconds, loads = timed(lambda: [ours(port, squares) for port in every])
    slow, found = timed(lambda: [[plain(port, sea) for sea in squares[:SEARCHED]] for port in every])
    own = np.array([load.power[:SEARCHED] for load in loads])
    each, searched = seconds / (SEAS * len(every)), slow / (SEARCHED * len(every))
    better = max(0.0, float(np.max(np.array(found) / own - 1)))
    return [
        {"case": case, "method": "all at once", "seas": SEAS, "seconds_per_sea": each, "ratio": 1.0, "error": better},
        {"case": case, "method": "search", "seas": SEARCHED, "seconds_per_sea": searched, "ratio": searched / each},
    ]


def limited_rows() -> list[Row]:
    """The bound and the best force under a limit of force, error their gap, and the same steps with dense matrices."""
    harmonics, squares = Harmonics(SPACING, 1.0, COMPONENTS), seas()[:LIMITED]
    (whole, *_), (port, *_) = ports(harmonics.port_omega), ports(harmonics.omega)
    rng = np.random.default_rng(2)
    phases = np.exp(2j * np.pi * rng.uniform(size=squares.shape))
    waves = [Sea(port.omega, np.sqrt(row) * turned) for row, turned in zip(squares, phases, strict=True)]
    loads = best_dampers(port, squares)
    speeds = [np.abs(port.velocity_under(port.load(c))) ** 2 for c in loads.damping]
    limits = [c * np.sqrt(v @ row / 2) for c, v, row in zip(loads.damping, speeds, squares, strict=True)]
    optimum_in_sea(whole, waves[0], harmonics, Limits(limits[0]))  # compiles
    seconds, found = timed(lambda: [optimum_in_sea(whole, *pair) for pair in _pairs(waves, harmonics, limits)])
    nodes = NODES * harmonics.instants
    angle = 2 * np.pi * np.arange(nodes) / nodes
    turning = np.exp(-1j * np.outer(angle, 1 + np.arange(COMPONENTS)))
    columns, weights = np.hstack([turning.real, turning.imag]), rng.uniform(0.5, 1.0, nodes)
    step, _ = timed(
        lambda: [cho_factor((columns.T * weights) @ columns + np.eye(2 * COMPONENTS)) for _ in range(LIMITED)]
    )
    each, dense = seconds / LIMITED, step / LIMITED * float(np.mean([one.steps for one in found]))
    case, gap = "optimum under a limit of force", max(one.gap for one in found)
    return [
        {"case": case, "method": "structured", "seas": LIMITED, "seconds_per_sea": each, "ratio": 1.0, "error": gap},
        {"case": case, "method": "dense", "seas": LIMITED, "seconds_per_sea": dense, "ratio": dense / each},
    ]


def _pairs(waves: list[Sea], harmonics: Harmonics, limits: list[float]) -> list[tuple[Sea, Harmonics, Limits]]:
    """Arguments of the optimum in each sea."""
    return [(sea, harmonics, Limits(float(limit))) for sea, limit in zip(waves, limits, strict=True)]


def benchmark(folder: str | Path) -> list[Row]:
    """Write take_offs.csv into a folder and return its rows."""
    rows = [row for case in CASES for row in linear_rows(case)] + limited_rows()
    write_text(Path(folder, "take_offs.csv"), as_csv(rows, COLUMNS))
    return rows
