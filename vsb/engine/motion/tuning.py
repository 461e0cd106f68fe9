"""The optimal linear take-off: of a port a damper, or a spring and a damper; of several ports a damper matrix.

A sea is the squared amplitudes of its components, shape (omega,) [m^2]; many seas are rows over the frequencies of one
port, so that many dampers in many seas are one matrix product. In the logarithm u of the damper the power of each
frequency is proportional to 1/(R + |Z| cosh(u - ln |Z|)), which is analytic within pi/2 of the real axis.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize

from vsb.engine.motion.port import Port, Ports
from vsb.engine.waves.seas import Sea
from vsb.tools.arrays import BoolArray, FloatArray, IntArray, in_parts

LOG_STEP = 0.1
"""Step of the logarithm of the dampers tried first. In it P''/P >= -1 (the sum of 1/(R + |Z| cosh(u - ln |Z|)) over
frequencies): no maximum is more than a part LOG_STEP^2/8 above the nearest damper tried, and none can be missed."""
_HARDER = 100.0
"""Factor by which the range of dampers is extended where conversion has losses."""
PAIR_STEP = 0.4
SPRINGS = 32, 160
"""Where the spring is free as well, step of the dampers tried first, and springs, spread evenly and tuned to waves."""
RIVALS = 0.1
"""Local maxima of the pairs tried are followed if they come within this part of the best."""
MARGIN = 1e-6
"""Part of the stiffness of the resting buoy that a negative spring must leave it."""
FINEST = 1e-4
"""Step at which the climb ends, in the logarithm of the damper: power is then exact to the step's square and better."""
LIMIT_KEPT = 1e-9
"""Relative tolerance on a limit of force."""
SETTLED = 1e-8
"""Newton step [-] after which the next one is round-off.

Where power is flat round-off moves the optimal damper by as much, and with it, in proportion to the slope there, the
power of a run in time, whose own optimum is another one.
"""
STEPS = 200
"""Most steps of a climb: few are needed but on long narrow ridges."""


class Load(NamedTuple):
    """A damper and a spring in parallel for each sea, and the mean power they absorb."""

    damping: FloatArray  # (sea,) [N s/m]
    stiffness: FloatArray  # (sea,) [N/m]
    power: FloatArray  # (sea,) [W]

    def elementwise_best(self, other: "Load") -> "Load":
        """Return for each sea the better of two."""
        better = other.power > self.power
        return Load(*(np.where(better, b, a) for a, b in zip(self, other, strict=True)))


def frequencies(seas: Sequence[Sea]) -> FloatArray:
    """Return the frequencies of all components of some seas, ascending [rad/s]."""
    return np.unique(np.concatenate([sea.omega for sea in seas]))


def squares(seas: Sequence[Sea], omega: FloatArray) -> FloatArray:
    """Return the squared amplitudes of the components of seas, shape (sea, omega) [m^2]; zero where a sea has none."""
    out = np.zeros((len(seas), len(omega)))
    for row, waves in zip(out, seas, strict=True):
        row[np.searchsorted(omega, waves.omega)] = np.abs(waves.amplitude) ** 2
    return out


def electrical_power(
    damping: FloatArray, stiffness: FloatArray, speed: FloatArray, stroke: FloatArray, efficiency: float
) -> FloatArray:
    """Return the mean of e p+ + p-/e, p the power at the port, e the efficiency of both directions [W].

    Parameters
    ----------
    damping, stiffness : ndarray [N s/m], [N/m]
    speed, stroke : ndarray
        Mean squares of velocity and displacement [m^2/s^2], [m^2].

    Notes
    -----
    With correlation rho between force and velocity the mean of the negative part of p is
    s_F s_V (sqrt(1 - rho^2) - rho arccos rho)/pi: exact in a regular wave, and of the mean over all realisations of a
    sea, in which force and velocity are jointly Gaussian.
    """
    power = damping * speed
    if efficiency == 1.0:
        return np.asarray(power)
    size = np.sqrt((damping**2 * speed + stiffness**2 * stroke) * speed)
    return converted_power(np.asarray(power), size, efficiency)


def converted_power(power: FloatArray, size: FloatArray, efficiency: float) -> FloatArray:
    """Return `electrical_power` from the mean power at the port and the product of rms force and rms velocity [W]."""
    rho = np.clip(np.divide(power, size, out=np.ones_like(power), where=size > 0), -1.0, 1.0)
    returned = size * (np.sqrt(1 - rho**2) - rho * np.arccos(rho)) / np.pi
    return np.asarray(efficiency * power - (1 / efficiency - efficiency) * returned)


def mean_power(
    port: Port, squares: FloatArray, damping: FloatArray, stiffness: FloatArray, efficiency: float = 1.0
) -> FloatArray:
    """Return the mean power of loads, each in its own sea, shape (sea,) [W].

    Parameters
    ----------
    squares : ndarray, shape (sea, omega) [m^2]
    damping, stiffness : ndarray, shape (sea,) [N s/m], [N/m]
    """
    square = 0.5 * squares * port.speed_under(damping, stiffness)
    return electrical_power(damping, stiffness, square.sum(axis=1), (square / port.omega**2).sum(axis=1), efficiency)


def powers_of_all(
    port: Port, squares: FloatArray, damping: FloatArray, stiffness: FloatArray, efficiency: float
) -> FloatArray:
    """Return the mean power of every load in every sea, shape (load, sea) [W]; arguments as `mean_power`."""
    if len(parts := in_parts(len(damping), len(port.omega))) > 1:
        return np.concatenate([powers_of_all(port, squares, damping[i], stiffness[i], efficiency) for i in parts])
    square = 0.5 * port.speed_under(damping, stiffness)
    speed = square @ squares.T
    stroke = speed if efficiency == 1.0 else (square / port.omega**2) @ squares.T
    return electrical_power(damping[:, None], stiffness[:, None], speed, stroke, efficiency)


def best_dampers(port: Port, squares: FloatArray, stiffness: float = 0.0, efficiency: float = 1.0) -> Load:
    """Return the optimal damper in each sea beside a given spring: the global optimum.

    Parameters
    ----------
    port : Port
        Without the spring.
    squares : ndarray, shape (sea, omega) [m^2]
    stiffness : float [N/m]
    efficiency : float
        Of both directions: a spring sends power back and forth.
    """
    count = len(squares)
    if not port.moves or not squares.any():
        return Load(np.zeros(count), np.full(count, stiffness), np.zeros(count))
    start, sea = _rivals(port, squares, stiffness, efficiency)

    def power(x: FloatArray, start: IntArray) -> FloatArray:
        return mean_power(port, squares[sea[start]], np.exp(x[:, 0]), spring[start], efficiency)

    spring = np.full(len(sea), stiffness)
    x, found = climbed(power, start[:, None], np.full((len(sea), 1), LOG_STEP))
    return _best_of_each(sea, count, np.exp(x[:, 0]), spring, found)


def _rivals(port: Port, squares: FloatArray, stiffness: float, efficiency: float) -> tuple[FloatArray, IntArray]:
    """Logarithms of tried dampers from which a climb may end at the best one, and the sea of each, (start,)."""
    sizes = port.beside(stiffness).best_damping[squares.any(axis=0)]
    reach = 1.0 if efficiency == 1.0 else _HARDER
    least, most = np.floor(np.log([sizes.min() / reach, sizes.max() * reach]) / LOG_STEP)
    while True:
        tried = LOG_STEP * np.arange(least - 1, most + 3)  # independent of the other seas
        powers = powers_of_all(port, squares, np.exp(tried), np.full(len(tried), stiffness), efficiency)
        if not np.any(powers.max(axis=0) < 0.0):
            break
        most += np.ceil(np.log(_HARDER) / LOG_STEP)  # the spring costs more than any of these absorbs
    rivals = powers >= powers.max(axis=0) * (1 - LOG_STEP**2 / 4)
    at, sea = np.nonzero(rivals & _local_maxima(powers))
    return tried[at], sea


def damper_within_force(
    port: Port, squares: FloatArray, limit: float, stiffness: float = 0.0, efficiency: float = 1.0
) -> Load:
    """Return the optimal damper in one sea among those whose force, with that of a spring, has at most a given rms.

    Without the spring where its force alone exceeds the limit.

    Parameters
    ----------
    port : Port
        Without the spring.
    squares : ndarray, shape (1, omega) [m^2]
    limit : float [N]
    stiffness : float [N/m]
    efficiency : float
        Of both directions of power.
    """
    best = best_dampers(port, squares, stiffness, efficiency)
    if not best.power.any():
        return best

    def excess(logarithm: float) -> float:
        load = port.load(np.exp([logarithm]), stiffness)
        square = float(0.5 * squares[0] @ np.abs(load[0] * port.velocity_under(load)[0]) ** 2)
        return float(0.5 * np.log(square) - np.log(limit))

    def power(damping: FloatArray | float) -> FloatArray:
        dampers = np.atleast_1d(damping)
        return powers_of_all(port, squares, dampers, np.full(len(dampers), stiffness), efficiency)[:, 0]

    top = float(np.log(best.damping[0]))
    if excess(top) <= LIMIT_KEPT:
        return best
    # with little damping force and power are proportional to it: none of less than this is needed
    tried = np.arange(top - np.log(_HARDER) - max(excess(top), 0.0), top + np.log(_HARDER), LOG_STEP)
    over = np.array([excess(u) for u in tried])
    kept = over <= 0
    if not kept.any():
        return damper_within_force(port, squares, limit, 0.0, efficiency) if stiffness else best
    at = [brentq(excess, tried[i], tried[i + 1], xtol=1e-12) for i in np.flatnonzero(kept[1:] != kept[:-1])]
    found = np.exp(np.append(tried[kept], at))
    best_found = int(power(found).argmax())
    return Load(found[[best_found]], np.array([stiffness]), power(found[best_found]))


def best_damper_of_each(ports: Sequence[Port], squares: FloatArray) -> FloatArray:
    """Return the optimal damper in one sea at each of some ports, shape (port,) [N s/m]; see `best_dampers`.

    Parameters
    ----------
    ports : sequence of Port
        Over the same frequencies.
    squares : ndarray, shape (omega,) [m^2]
    """
    moving = [i for i, port in enumerate(ports) if port.moves and squares.any()]
    found = np.zeros(len(ports))
    if not moving:
        return found
    starts = [_rivals(ports[i], squares[None], 0.0, 1.0)[0] for i in moving]
    which = np.repeat(np.arange(len(moving)), [len(start) for start in starts])
    weight = np.array([0.5 * squares * ports[i].speed_under(0.0) for i in moving])
    admittance = np.array([ports[i].admittance for i in moving])
    loss, size = 2 * np.ascontiguousarray(admittance.real), np.abs(admittance) ** 2
    x, power = _summits(weight[which], loss[which], size[which], np.concatenate(starts))
    found[moving] = _best_of_each(which, len(moving), np.exp(x), 0 * power, power).damping
    return found


def _summits(
    weight: FloatArray, loss: FloatArray, size: FloatArray, start: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Maxima over u of P = sum w/(e^-u + 2 Re Y + |Y|^2 e^u), c = e^u, next to each start, and P there, (start,).

    Newton's method on P' = 0: all starts at once, independently.
    """
    x, power, left = start.copy(), np.zeros(len(start)), np.arange(len(start))
    for _ in range(STEPS):
        falling, rising = np.exp(-x[left])[:, None], size[left] * np.exp(x[left])[:, None]
        whole = falling + loss[left] + rising
        each, slant = weight[left] / whole, (rising - falling) / whole
        power[left], slope = each.sum(axis=1), -(each * slant).sum(axis=1)
        bend = (each * (2 * slant**2 - (rising + falling) / whole)).sum(axis=1)
        newton = np.divide(-slope, bend, out=np.sign(slope), where=bend < 0)
        move = np.clip(newton, -LOG_STEP, LOG_STEP)
        x[left] += move
        left = left[np.abs(move) > SETTLED]
        if not left.size:
            break
    return x, power


def best_pairs(port: Port, squares: FloatArray, given: Load, efficiency: float = 1.0) -> Load:
    """Return the optimal spring and damper in each sea, among those with which the buoy is statically stable.

    Parameters
    ----------
    squares : ndarray, shape (sea, omega) [m^2]
    given : Load
        Lower bound: an optimal damper beside the given spring.
    """
    if not port.moves or not squares.any():
        return given
    single = (squares > 0).sum(axis=1) == 1  # regular waves: each needs its own range of springs
    best, searched = given, squares.any(axis=1)
    if efficiency == 1.0:
        best = given.elementwise_best(_matched_pairs(port, squares, single))
        searched &= ~single | (best.power < (1 - 1e-9) * (squares @ port.matched_power))
    for seas in (np.flatnonzero(searched & ~single), *np.flatnonzero(searched & single)[:, None]):
        if len(seas):
            used = squares[seas].any(axis=0)
            found = _searched_pairs(port.at(used), squares[seas][:, used], efficiency)
            best = _with(best, seas, found)
    return best


def _with(best: Load, seas: IntArray, found: Load) -> Load:
    """The loads of all seas with better ones of some."""
    whole = Load(*(values.copy() for values in best))
    for values, new in zip(whole, Load(*(v[seas] for v in best)).elementwise_best(found), strict=True):
        values[seas] = new
    return whole


def _softest(port: Port) -> float:
    """Least stiffness of a spring that leaves the buoy at rest [N/m]."""
    return port.softest_spring * (1 - MARGIN)


def _matched_pairs(port: Port, squares: FloatArray, alone: BoolArray) -> Load:
    """Spring and damper that match the impedance, c = R and k = -omega X, where a sea is one wave and rests stably."""
    at = squares.argmax(axis=1)
    z, omega = port.impedance[at], port.omega[at]
    stable = alone & (-omega * z.imag >= _softest(port))
    damping, stiffness = np.where(stable, z.real, 0.0), np.where(stable, -omega * z.imag, 0.0)
    return Load(damping, stiffness, mean_power(port, squares, damping, stiffness))


def _searched_pairs(port: Port, squares: FloatArray, efficiency: float) -> Load:
    """The best pairs by a table of them and a climb from its local maxima.

    A spring beyond all that tune the buoy to one of the frequencies, k = -omega X, and beyond k = 0 only costs power.
    For an unrestrained port springs begin above 0, by the margin of the stiffest that tunes it.
    """
    tuned = -port.omega * port.impedance.imag
    margin = MARGIN * (-port.softest_spring or np.abs(tuned).max())
    low = max(min(tuned.min(), 0.0), _softest(port) or margin)
    high = max(tuned.max(), 0.0, low)
    waves = np.unique(np.linspace(0, len(tuned) - 1, min(SPRINGS[1], len(tuned))).astype(int))
    springs = np.unique(np.concatenate([np.clip(tuned[waves], low, high), np.linspace(low, high, SPRINGS[0])]))
    largest = np.abs(port.impedance + 1j * np.array([[low], [high]]) / port.omega).max()
    dampers = np.arange(np.log(0.5 * port.impedance.real.min()), np.log(2 * largest) + PAIR_STEP, PAIR_STEP)
    u, k = (values.ravel() for values in np.meshgrid(dampers, springs, indexing="ij"))
    powers = powers_of_all(port, squares, np.exp(u), k, efficiency)
    table = powers.reshape(len(dampers), len(springs), -1)
    i, j, sea = np.nonzero((table >= (1 - RIVALS) * table.max(axis=(0, 1))) & _local_maxima(table, axes=2))
    left = springs[j] - port.softest_spring  # above static instability, whose logarithm is unbounded
    width = np.exp(dampers[i]) * np.exp(np.log(port.omega).mean()) / left  # of a resonance in k: omega (R + c)
    start, step = np.stack([dampers[i], np.log(left)], axis=1), PAIR_STEP * np.stack([np.ones(len(i)), width], axis=1)
    least = np.log(margin)

    def stiffness(x: FloatArray) -> FloatArray:
        return np.asarray(port.softest_spring + np.exp(np.maximum(x[:, 1], least)))

    def power(x: FloatArray, start: IntArray) -> FloatArray:
        return mean_power(port, squares[sea[start]], np.exp(x[:, 0]), stiffness(x), efficiency)

    x, found = climbed(power, start, np.minimum(step, 1.0))
    return _best_of_each(sea, len(squares), np.exp(x[:, 0]), stiffness(x), found)


def _local_maxima(table: FloatArray, axes: int = 1) -> BoolArray:
    """Whether an entry is no less than its neighbours along the first axes, diagonals included."""
    padded = np.pad(table, [(1, 1)] * axes + [(0, 0)], constant_values=-np.inf)
    best = np.ones(table.shape, dtype=bool)
    for shift in np.ndindex(*(3,) * axes):
        neighbour = tuple(slice(s, s + n) for s, n in zip(shift, table.shape, strict=False))
        best &= table >= padded[neighbour]
    return best


def _best_of_each(sea: IntArray, count: int, *values: FloatArray) -> Load:
    """The best of several finds for each sea; damping, stiffness, power."""
    order = np.lexsort([values[2], sea])
    last = order[np.searchsorted(sea[order], np.arange(count), side="right") - 1]
    return Load(*(value[last] for value in values))


def climbed(
    function: Callable[[FloatArray, IntArray], FloatArray], start: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the local maxima reached from many points at once, and the values there.

    Parameters
    ----------
    function : callable
        Points, shape (point, dimension), and which start each belongs to, to values, shape (point,).
    start, step : ndarray, shape (start, dimension)
        One or two dimensions.

    Notes
    -----
    Newton's method on the parabola through the neighbours a step away: none of its steps is longer or goes downhill,
    and the distance shrinks as the maximum comes to lie between them. The last step follows the slope alone.
    """
    left = np.arange(len(start))
    x, value, step = start.copy(), function(start, left), step.copy()
    offsets = np.array(list(np.ndindex(*(3,) * x.shape[1]))) - 1
    for _ in range(STEPS):
        here, size = x[left], step[left]
        tried = [here + size * offset for offset in offsets]
        found = [function(point, left) if o.any() else value[left] for o, point in zip(offsets, tried, strict=True)]
        move = _ascent(offsets, np.array(found))
        tried.append(here + size * move)
        found.append(function(tried[-1], left))
        best = np.where(np.max(found, axis=0) > value[left], np.argmax(found, axis=0), len(offsets) // 2)
        between = (best == len(offsets)) & (np.abs(move).max(axis=1) < 0.25)
        stays = best == len(offsets) // 2
        x[left], value[left] = np.array(tried)[best, np.arange(len(left))], np.max(found, axis=0)
        step[left] /= np.where(between, 4.0, np.where(stays, 2.0, 1.0))[:, None]
        left = left[step[left].max(axis=1) > FINEST]
        if not left.size:
            break
    # values tell points of a flat maximum apart to the root of round-off only, slopes to round-off over the step
    whole, size = np.arange(len(x)), FINEST * step / step.max(axis=1, keepdims=True)
    move = _ascent(offsets, np.array([function(x + size * offset, whole) for offset in offsets]))
    x = np.where(np.abs(move).max(axis=1, keepdims=True) < 1.0, x + size * move, x)
    return x, function(x, whole)


def _ascent(offsets: IntArray, values: FloatArray) -> FloatArray:
    """Newton's step on the parabola through a stencil, at most one step long, uphill where it has no maximum.

    Parameters
    ----------
    offsets : ndarray, shape (point, dimension)
        Of the stencil, -1, 0 or 1.
    values : ndarray, shape (point, start)

    Returns
    -------
    ndarray, shape (start, dimension)
    """
    dimension = offsets.shape[1]
    on_axis = (np.abs(offsets).sum(axis=1) <= 1)[:, None]
    axis = offsets * on_axis
    gradient = axis.T @ values / 2
    hessian = np.einsum("pi,pj,ps->sij", offsets, offsets, np.where(on_axis, 0.0, values)) / 4
    for i in range(dimension):
        hessian[:, i, i] = (axis[:, i] ** 2) @ values - 2 * values[len(offsets) // 2]
    curve, vectors = np.linalg.eigh(hessian) if dimension > 1 else (hessian[:, 0], np.ones_like(hessian))
    along = np.einsum("sij,is->sj", vectors, gradient)
    move = np.where(curve < 0, -along / np.where(curve < 0, curve, 1.0), np.sign(along))
    return np.asarray(np.clip(np.einsum("sij,sj->si", vectors, move), -1.0, 1.0))


STEP = 0.05
"""Step of the logarithm of the dampers of a table: fine enough to miss no maximum, see `motion.tuning.LOG_STEP`."""
NEIGHBOURS = 5
"""Entries on either side of the best one that the polynomial goes through: its error is about 1e-13."""
NEWTON = 6
"""Newton's steps to the maximum of the polynomial: three would do."""
FLAT = 1e-9
"""Curvature of a polynomial, in its value, that is numerical error: a straight line has no maximum."""


def dampers(port: Port) -> FloatArray:
    """Return dampers among which the optimum of any sea lies, evenly spread in logarithm, shape (damper,) [N s/m].

    No sea's optimal damper is outside the range of |Z|; the table extends beyond for the polynomials.
    """
    sizes = np.log(port.best_damping)
    low, high = float(sizes.min()) - (NEIGHBOURS + 1) * STEP, float(sizes.max()) + (NEIGHBOURS + 1) * STEP
    return np.asarray(np.exp(low + STEP * np.arange(int(np.ceil((high - low) / STEP)) + 1)))


def best_of_table(damping: FloatArray, table: FloatArray) -> Load:
    """Return the optimal damper in each sea, from a table of powers.

    Parameters
    ----------
    damping : ndarray, shape (damper,) [N s/m]
        See `dampers`.
    table : ndarray, shape (damper, sea) [W]
    """
    near = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    at = np.clip(table.argmax(axis=0), NEIGHBOURS, len(damping) - NEIGHBOURS - 1)
    values = table[at + near[:, None], np.arange(table.shape[1])]
    # Powers of the distance in steps, highest first, as polyval wants them.
    polynomial = _through(NEIGHBOURS) @ values
    x = _highest(polynomial)
    step = np.log(damping[1] / damping[0])
    found = damping[at] * np.exp(NEIGHBOURS * step * x)
    return Load(found, np.zeros_like(found), np.polyval(polynomial, x))


@cache
def _through(neighbours: int) -> FloatArray:
    """Coefficients, highest first, of Lagrange's polynomials of x = -1 to 1 in equal steps, shape (power, point)."""
    nodes = np.arange(-neighbours, neighbours + 1)
    others = [np.delete(nodes, i) for i in range(len(nodes))]
    of_steps = np.array([np.poly(rest) / np.prod(node - rest) for node, rest in zip(nodes, others, strict=True)])
    return np.asarray((of_steps * float(neighbours) ** np.arange(len(nodes) - 1, -1, -1)).T)


def _highest(polynomial: FloatArray) -> FloatArray:
    """Where polynomials, one a column, are highest near 0."""
    degree = np.arange(len(polynomial) - 1, -1, -1)[:, None]
    slope = (polynomial * degree)[:-1]
    curvature = (slope * (degree[:-1] - 1))[:-1]
    flat = -FLAT * np.abs(polynomial[-1])
    x = np.zeros(polynomial.shape[1])
    for _ in range(NEWTON):
        bend = np.polyval(curvature, x)
        move = np.divide(-np.polyval(slope, x), bend, out=np.zeros_like(x), where=bend < flat)
        before, x = x, np.clip(x + move, -1.0 / NEIGHBOURS, 1.0 / NEIGHBOURS)
        if np.abs(x - before).max(initial=0.0) < 1e-9:  # convergence is quadratic
            break
    return x


# several ports ------------------------------------------------------------------------------------------------------

# With L L^T = C, P = 1/2 Re V^H C V and dP = Re mu^H dC V/2, mu = (1 + C Y)^-H (V - Y^H F). With one radiation channel
# a real matrix reaches the matched power where the reactance X of the ports is indefinite: locked in a ratio u with
# u^T X u = 0 they are one port in resonance. Where X is definite no matrix does.

Kind = Literal["full", "diagonal", "uniform"]
"""What a damper matrix may be: symmetric, a damper at each port alone, or the same damper at all ports."""
DRAWN = 64
"""Damper matrices tried first, drawn about the ports' own impedances, always the same ones."""
CLIMBED = 4
"""The best of them that are followed to a maximum."""
SPREAD = 2.5
"""Standard deviation of the logarithm of those dampers over the ports' own impedances."""
LOCKED = 1e4
"""Norm of a Cholesky factor, in the ports' own units, beyond which round-off exceeds the power that more of it adds."""
FORCE_KEPT, NEAR_PRICE = 1e-6, 1e-2
"""Relative tolerance on a limit of the rms of all forces, and of its price before secants."""


class DamperMatrix(NamedTuple):
    """A damper matrix and the mean power it absorbs."""

    damping: FloatArray  # C (port, port)
    power: float  # [W]


def best_matrix(
    ports: Ports,
    squares: FloatArray,
    kind: Kind = "full",
    newton_steps: int = 0,
    price: float = 0.0,
    near: FloatArray | None = None,
) -> DamperMatrix:
    """Return the damper matrix C >= 0, real and symmetric, that absorbs most in a sea.

    Parameters
    ----------
    squares : ndarray, shape (omega,)
        Squared amplitudes [m^2]: of one sea, of several together, or of a year.
    kind : {'full', 'diagonal', 'uniform'}
    newton_steps : int
        Most Newton steps after quasi-Newton's: of a matrix whose power is to be differentiated, for then slopes by the
        ports are as exact as the matrix. Of one damper for all ports none.
    price : float [m/(N s)]
        Of the mean square of all forces, which is taken from the power that is maximised; not of one damper for all.
    near : ndarray, shape (port, port)
        Matrix whose nearest maximum is wanted; none: the largest of all.

    Notes
    -----
    Over the Cholesky factor, or the logarithms of the dampers, of ports in terms of their own impedances: quasi-Newton
    with the exact slope from the best of `DRAWN` matrices. A full matrix also starts from the best diagonal one: it
    absorbs no less. A port that cannot move has no damper. One damper for all ports is the best of a table
    (`Ports.equal_dampers`), which all seas share.
    """
    used = (squares > 0) & (np.abs(ports.velocity).max(axis=1) > 0)
    count = ports.velocity.shape[1]
    if not used.any():
        return DamperMatrix(np.zeros((count, count)), 0.0)
    if kind == "uniform":
        if price or near is not None:
            raise ValueError("uniform: received a price or a matrix nearby, needs neither: it is the best of all")
        dampers, powers = ports.equal_dampers
        equal = float(best_of_table(dampers, (powers @ squares)[:, None]).damping[0]) * np.eye(count)
        return DamperMatrix(equal, float(squares[used] @ ports.at(used).power(equal)))
    moving = ports.admittance.any(axis=(0, 2))
    if not moving.all():  # as in a rigid design, which a port of strain does not move with
        part = Ports(ports.omega, ports.admittance[:, moving][:, :, moving], ports.velocity[:, moving])
        chosen = None if near is None else near[np.ix_(moving, moving)]
        some, whole = best_matrix(part, squares, kind, newton_steps, price, chosen), np.zeros((count, count))
        whole[np.ix_(moving, moving)] = some.damping
        return DamperMatrix(whole, some.power)
    seen, weights, unit = ports.at(used), squares[used], 1 / np.sqrt(ports.size)
    form = _FORMS[kind](count)
    limit = float(weights @ seen.matched_power) or 1.0

    def loss(x: FloatArray) -> tuple[float, FloatArray]:
        damping, pull = form.matrix(x, unit)
        power, slope = seen.power_and_slope(damping, weights, price)
        return -power / limit, -pull(slope) / limit

    def powers_of(points: Sequence[FloatArray]) -> FloatArray:
        dampers = np.array([form.matrix(x, unit)[0] for x in points])
        velocity = seen.velocity_under(dampers)
        force = velocity @ dampers
        return np.asarray(0.5 * np.real(((velocity - price * force).conj() * force).sum(axis=-1)) @ weights)

    starts = (
        form.starts(np.random.default_rng(count)) if near is None else [form.of_matrix(near / np.outer(unit, unit))]
    )
    powers = np.concatenate([powers_of(starts[part]) for part in in_parts(len(starts), seen.admittance.size)])
    followed = [starts[i] for i in np.argsort(-powers, kind="stable")[:CLIMBED]]
    if isinstance(form, _Full) and near is None:
        own = best_matrix(ports, squares, "diagonal", price=price).damping
        followed.append(form.of_diagonal(np.diag(own) / unit**2))
    found = [minimize(loss, x, jac=True, method="L-BFGS-B", options={"ftol": 1e-13, "gtol": 1e-9}) for x in followed]
    best: FloatArray = min(found, key=lambda one: float(one.fun)).x
    for _ in range(newton_steps):
        best = _newton_step(loss, best)
    damping, _ = form.matrix(best, unit)
    return DamperMatrix(damping, float(weights @ seen.power(damping)))


def _newton_step(loss: Callable[[FloatArray], tuple[float, FloatArray]], x: FloatArray) -> FloatArray:
    """A point after a Newton step towards the least loss, the Hessian by differences of slopes; itself if no better.

    Along directions in which the loss hardly bends, such as those of dampers that lock, the point stays.
    """
    value, slope = loss(x)
    steps = 1e-5 * np.diag(1 + np.abs(x))
    hessian = np.array([(loss(x + step)[1] - loss(x - step)[1]) / (2 * step.sum()) for step in steps])
    bends, directions = np.linalg.eigh((hessian + hessian.T) / 2)
    kept = bends > 1e-9 * bends[-1]
    moved = x - directions[:, kept] @ ((slope @ directions[:, kept]) / bends[kept])
    after, slope_after = loss(moved)
    better = after <= value + 1e-14 and np.abs(slope_after).max() < np.abs(slope).max()
    return np.asarray(moved if better else x)


def priced_matrix(
    ports: Ports, squares: FloatArray, limit: float, kind: Kind = "full", newton_steps: int = 0
) -> tuple[DamperMatrix, float]:
    """Return the damper matrix that absorbs most in a sea with a given rms of all forces together at most.

    And the price of the squared force at which it is the best one. With Newton steps, see `best_matrix`, power less the
    price times the squared force is as exact as without limit.

    Parameters
    ----------
    limit : float [N]
        Of ports whose forces have one unit.
    """

    def at(logarithm: float, near: FloatArray | None = None, steps: int = 0) -> DamperMatrix:
        return best_matrix(ports, squares, kind, steps, float(np.exp(logarithm)), near)

    def excess(found: DamperMatrix) -> float:
        return float(np.log(np.linalg.norm(ports.force_rms(found.damping, squares)) / limit))

    best = best_matrix(ports, squares, kind, newton_steps)
    if not best.power > 0 or excess(best) <= FORCE_KEPT:
        return best, 0.0
    free = 0.5 * squares @ np.abs(ports.velocity) ** 2
    high = float(np.log(np.sqrt(free.sum()) / (2 * limit)))  # where the force alone costs, the limit holds
    low = high - 1.0
    while excess(at(low)) < 0:
        low -= 2.0
    close = NEAR_PRICE if newton_steps else FORCE_KEPT
    root = float(brentq(lambda price: excess(at(price)), low, high, xtol=close))
    if not newton_steps:
        tried = ((at(one), one) for one in (root, root + 2 * FORCE_KEPT, high))
        return next((one, float(np.exp(price))) for one, price in tried if excess(one) <= FORCE_KEPT)
    found = at(root, at(root).damping, newton_steps)
    for apart in (close, close**2):  # secants
        beside = at(root + apart, found.damping, newton_steps)
        root -= apart * excess(found) / (excess(beside) - excess(found))
        found = at(root, found.damping, newton_steps)
    return found, float(np.exp(root))


def matrix_text(matrix: FloatArray, digits: int) -> str:
    """Return a damper matrix as text, in SI units of its ports; nothing if it is missing."""
    if np.isnan(matrix).any():
        return ""
    return str([[float(f"{entry:.{digits}g}") for entry in row] for row in matrix.tolist()])


class _Full:
    """C = S L L^T S of a lower triangular L, S the ports' units."""

    def __init__(self, count: int) -> None:
        self.at, self.count = np.tril_indices(count), count

    def factor(self, x: FloatArray) -> FloatArray:
        """L."""
        found = np.zeros((self.count, self.count))
        found[self.at] = x
        return found

    def matrix(self, x: FloatArray, unit: FloatArray) -> tuple[FloatArray, Callable[[FloatArray], FloatArray]]:
        """C and what takes its slope back to x: dP/dL = 2 S G S L. Beyond `LOCKED` x counts as the nearest within."""
        beyond = max(1.0, float(np.linalg.norm(x)) / LOCKED)
        factor, scale = self.factor(x / beyond), np.outer(unit, unit)

        def pull(slope: FloatArray) -> FloatArray:
            found: FloatArray = (2 * (scale * slope) @ factor)[self.at] / beyond
            return found if beyond == 1.0 else found - x * (x @ found) / (x @ x)

        return scale * (factor @ factor.T), pull

    def starts(self, rng: np.random.Generator) -> list[FloatArray]:
        """Dampers of all sizes along all combinations of the ports."""
        found = []
        for _ in range(DRAWN):
            turned = np.linalg.qr(rng.standard_normal((self.count, self.count)))[0]
            size = np.exp(SPREAD * rng.standard_normal(self.count))
            found.append(np.linalg.cholesky((turned * size) @ turned.T)[self.at])
        return found

    def of_matrix(self, matrix: FloatArray) -> FloatArray:
        """The point of a matrix in the ports' units."""
        sizes, along = np.linalg.eigh(matrix)
        return np.asarray(np.linalg.qr((along * np.sqrt(np.maximum(sizes, 0.0))).T)[1].T[self.at])

    def of_diagonal(self, dampers: FloatArray) -> FloatArray:
        """The point of a diagonal matrix, off its axis: there the slope across it would vanish."""
        root = np.sqrt(np.maximum(dampers, 1e-12))
        return np.asarray((np.diag(root) + 1e-6 * np.tril(np.outer(root, root) ** 0.5, -1))[self.at])


class _Diagonal:
    """C = S diag(e^x) S: a damper of its own at each port."""

    def __init__(self, count: int) -> None:
        self.count = count

    def matrix(self, x: FloatArray, unit: FloatArray) -> tuple[FloatArray, Callable[[FloatArray], FloatArray]]:
        """C and what takes its slope back to x."""
        dampers = unit**2 * np.exp(np.clip(x, -40.0, 40.0))
        return np.diag(dampers), lambda slope: np.diag(slope) * dampers

    def of_matrix(self, matrix: FloatArray) -> FloatArray:
        """The point of a matrix in the ports' units."""
        return np.asarray(np.log(np.maximum(np.diag(matrix), np.exp(-40.0))))

    def starts(self, rng: np.random.Generator) -> list[FloatArray]:
        """Dampers of all sizes."""
        return list(SPREAD * rng.standard_normal((DRAWN, self.count)))


_FORMS: Mapping[str, type[_Full | _Diagonal]] = {"full": _Full, "diagonal": _Diagonal}
