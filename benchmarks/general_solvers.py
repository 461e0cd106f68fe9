"""General integrators on the motion of any scene: compiled ones, scipy's, and CVODE where scikit-sundae is installed.

All are given the same compiled right-hand side in plain coordinates (y, y', x), as a user would write it down. Their
tolerance is relative, and absolute in m, m/s and the root of J; RK4 has a number of steps between two instants instead.
Seconds are those a processor works. Failures are results: the status says what happened.
"""

import time as clock
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag

from benchmarks.compiled_solvers import COMPILED_DOP853, RK4, eighth_order, rk4
from vsb.engine.motion.system import Remainder, System, remainder
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.compiled import njit

try:
    from sksundae.cvode import CVODE
except ImportError:
    CVODE = None

NOT_INSTALLED = "not installed"
SUNDIALS = "CVODE (SUNDIALS)"
SCIPY = ("RK45", "Radau")
MOST_STEPS = 10_000_000
ENOUGH = 0.5
"""A run that takes so long is not repeated [s]."""
Rates = Callable[[float, FloatArray], FloatArray]


@njit(cache=True)
def linear_rates(t: float, z: FloatArray, matrix: FloatArray, omega: FloatArray, push: ComplexArray) -> FloatArray:
    """Return matrix z + Re sum_j push_j exp(-i omega_j t), the latter in the velocity rows."""
    out, free = matrix @ z, push.shape[1]
    for j in range(len(omega)):
        c, s = np.cos(omega[j] * t), np.sin(omega[j] * t)
        for i in range(free):
            out[free + i] += push[j, i].real * c + push[j, i].imag * s
    return out


@njit(cache=True)
def water_rates(
    t: float, z: FloatArray, matrix: FloatArray, omega: FloatArray, push: ComplexArray, water: Remainder
) -> FloatArray:
    """Return the same with the force on the instantaneous wet shell."""
    out, free = linear_rates(t, z, matrix, omega, push), push.shape[1]
    force = np.empty(free)
    remainder(water, t, z[:free].copy(), force)
    out[free : 2 * free] += force
    return out


@dataclass(frozen=True)
class Equation:
    """z' = f(t, z) of a scene, z = (y, y', x), and its start."""

    rates: Rates
    first: FloatArray  # (state,)
    free: int
    compiled: tuple[Any, tuple[Any, ...]]  # the same function as a loop calls it, and what it is given

    @classmethod
    def of(cls, system: System, start: tuple[FloatArray, FloatArray]) -> "Equation":
        """Return the equation of a scene, linear or body-exact."""
        free, modes = system.free, system.modes
        plain = block_diag(system.position, modes, np.eye(len(system.matrix) - 2 * free))
        matrix = np.ascontiguousarray(np.linalg.solve(plain.T, (plain @ system.matrix).T).T)
        omega, push = system.omega, np.ascontiguousarray(system.waves @ modes.T)
        given = np.concatenate([*start, np.zeros(len(matrix) - 2 * free)])
        if system.remainder is None:
            parts: tuple[Any, ...] = (matrix, omega, push)
            return cls(lambda t, z: np.asarray(linear_rates(t, z, *parts)), given, free, (linear_rates, parts))
        water = system.remainder._replace(
            position=np.ascontiguousarray(system.scene.motions),
            project=np.ascontiguousarray(modes @ system.remainder.project),
            constant=modes @ system.remainder.constant,
            tangent=np.ascontiguousarray(np.linalg.solve(system.position.T, (modes @ system.remainder.tangent).T).T),
        )
        parts = (matrix, omega, push, water)
        return cls(lambda t, z: np.asarray(water_rates(t, z, *parts)), given, free, (water_rates, parts))


@dataclass
class Counted:
    """A right-hand side that counts its calls and gives up at a deadline."""

    function: Rates
    deadline: float
    calls: int = 0

    def __call__(self, t: float, state: FloatArray) -> FloatArray:
        """Return the rates; `TimeoutError` after the deadline."""
        self.calls += 1
        if clock.process_time() > self.deadline:
            raise TimeoutError(f"stopped after its limit at t = {t:.4g} s")
        return self.function(t, state)

    def fill(self, t: float, state: FloatArray, out: FloatArray) -> None:
        """Fill the rates, as CVODE wants them."""
        out[:] = self(t, state)


class Solution(NamedTuple):
    """Heave and its velocity at given instants, only if the run completed, and what it took."""

    heave: FloatArray  # (time,) [m]
    velocity: FloatArray  # (time,) [m/s]
    seconds: float
    steps: int | None
    evaluations: int | None
    status: str = "completed"


def solved(equation: Equation, method: str, tolerance: float, time: FloatArray, limit: float) -> Solution:
    """Return the motion at given instants by one of `SCIPY` or by `SUNDIALS`, in so many seconds at most.

    Parameters
    ----------
    equation : Equation
    method : str
    tolerance : float
    time : ndarray, shape (time,) [s]
    limit : float [s]
    """
    none, begun = np.zeros(0), clock.process_time()
    if method == SUNDIALS and CVODE is None:
        return Solution(none, none, 0.0, None, None, NOT_INSTALLED)
    counted = Counted(equation.rates, begun + limit)
    run = {SUNDIALS: _by_cvode, RK4: _compiled, COMPILED_DOP853: _compiled}.get(method, _by_scipy)
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            states, steps = run(counted, equation, method, tolerance, time)
        if not np.isfinite(states).all():
            raise ArithmeticError("the motion is not finite")
    except (ArithmeticError, TimeoutError, ValueError, np.linalg.LinAlgError) as error:
        return Solution(none, none, clock.process_time() - begun, None, counted.calls, str(error))
    return Solution(states[0], states[equation.free], clock.process_time() - begun, steps, counted.calls)


def best(run: Callable[[], Solution]) -> Solution:
    """Return the fastest of three runs; the first alone where it takes long."""
    first = run()
    return first if first.seconds > ENOUGH else min(first, run(), run(), key=lambda solution: solution.seconds)


def _by_scipy(
    counted: Counted, equation: Equation, method: str, tolerance: float, time: FloatArray
) -> tuple[FloatArray, int | None]:
    """States (state, time) and number of steps."""
    options: dict[str, Any] = {"rtol": tolerance, "atol": tolerance, "method": method, "dense_output": True}
    out = solve_ivp(counted, (float(time[0]), float(time[-1])), equation.first, **options)
    if out.status < 0 or out.sol is None:
        raise ArithmeticError(str(out.message))
    return np.asarray(out.sol(time)), len(out.t) - 1


def _by_cvode(
    counted: Counted, equation: Equation, method: str, tolerance: float, time: FloatArray
) -> tuple[FloatArray, int | None]:
    """States (state, time); CVODE does not say its number of steps."""
    solver = cast(Any, CVODE)(counted.fill, rtol=tolerance, atol=tolerance, max_num_steps=MOST_STEPS)
    out = solver.solve(time, equation.first)
    if not out.success:
        raise ArithmeticError(str(out.message))
    return np.asarray(out.y).T, None


def _compiled(
    counted: Counted, equation: Equation, method: str, setting: float, time: FloatArray
) -> tuple[FloatArray, int | None]:
    """States (state, time) by a compiled loop, which does not count its steps; `setting` of RK4: steps an instant."""
    rates, given = equation.compiled
    if method == RK4:
        return np.asarray(rk4(rates, equation.first, time, int(setting), given)).T, int(setting) * (len(time) - 1)
    return np.asarray(eighth_order(rates, equation.first, time, setting, given)).T, None
