"""A causal controller as a filter of measured motion and own force, with a finite number of states.

    F = c V + k S + C x,    x' = A x + B V + E F,

with V the velocity and S the stroke of the port and F the force on the take-off, as measured. Through F the filter
knows what its force has made of the motion: it acts on the force of the waves alone, F_e = V/Y + F, also where a limit
cuts its force. With K_F and K_V its transfer functions from F and from V, K_F = K and K_V = K/Y give F = K F_e, the
optimal control of `vsb.engine.motion.causal`. Both are fitted with common poles in the left half plane.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import erf

from vsb.engine.hydro.radiation import partial_fractions, vector_fit
from vsb.engine.motion.causal import Controlled, StationaryPort
from vsb.errors import StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

ORDERS = (8, 12, 16, 20, 24)
FITTED = 2e-3
"""Error of the mean power, and of the rms force, over the known ones, with which a filter is good enough [-]."""
POINTS, BAND = 200, (0.3, 4.0)
"""Frequencies of a fit over the whole band and again where the waves are, over the frequency of their largest force."""
FLOOR = 1e-3
"""Least weight of a squared error, where there are no waves, over the largest."""
SLOW, FAST = 0.05, 3.0
"""Poles that are kept: above this part of the frequency of the largest force, below this multiple of the band."""
LIGHT = 0.02
"""Least damping ratio of poles that are kept: lighter ones follow a step of the spectrum, as where measured bands
begin, and leave a loop that rings for hours."""
LOUDEST = 10.0
"""Largest rms value of the force wanted over its limit: beyond, a force at its limit all the time changes little."""


@dataclass(frozen=True)
class Controller:
    """The filter."""

    state_matrix: FloatArray  # A (state, state) [1/s]
    of_velocity: FloatArray  # B (state,)
    of_force: FloatArray  # E (state,)
    output: FloatArray  # C (state,)
    damping: float  # c [N s/m]
    stiffness: float  # k [N/m]

    def transfer(self, omega: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return K_F [-] and K_V [N s/m], each shape (omega,)."""
        s = -1j * omega[:, None, None]
        rows = np.linalg.solve(s * np.eye(len(self.output)) - self.state_matrix.T, self.output[:, None])[..., 0]
        return rows @ self.of_force, rows @ self.of_velocity + self.damping - self.stiffness / (1j * omega)

    def gain(self, omega: FloatArray, admittance: ComplexArray) -> ComplexArray:
        """Return F/F_e in closed loop with a port, shape (omega,) [-]."""
        of_force, of_velocity = self.transfer(omega)
        seen = of_velocity * admittance
        return np.asarray(seen / (1 - of_force + seen))

    def stability(self, omega: FloatArray, admittance: ComplexArray) -> tuple[bool, float]:
        """Return whether the loop with a port is stable, and its margin (Nyquist) [-].

        The filter and the port are stable, so the loop is if 1 - K_F + K_V Y does not turn about zero. The margin is
        the least distance of the open loop, C Y with C = K_V/(1 - K_F), from -1.
        """
        of_force, of_velocity = self.transfer(omega)
        closed = 1 - of_force + of_velocity * admittance
        turned = np.unwrap(np.angle(closed))
        return bool(abs(turned[-1] - turned[0]) < 1.0), float(np.abs(closed / (1 - of_force)).min())


def achieved(port: StationaryPort, gain: ComplexArray, noise: float = 0.0) -> tuple[float, float]:
    """Return the mean power [W] and the rms force [N] of F = K (F_e + noise) in a sea.

    Parameters
    ----------
    gain : ndarray, shape (omega,) [-]
        K, see `StationaryPort.controller`.
    noise : float [-]
        Density of the noise over the peak of that of F_e.
    """
    square, density = np.abs(gain) ** 2, noise * port.excitation.max(initial=0.0)
    power = port.integral(port.absorbed(gain) - port.admittance.real * square * density)
    return power, float(np.sqrt(port.integral(square * (port.excitation + density))))


def within_limit(port: StationaryPort, best: Controlled, noise: float, limit: float) -> ComplexArray:
    """Return K of a force that is cut at a limit, shape (omega,) [-].

    Parameters
    ----------
    best : Controlled
        The optimum whose force has that rms value at most.
    limit : float [N]

    Notes
    -----
    Of all weights of the force and all multiples of their K those are taken that absorb most if the force wanted is
    Gaussian and what is left of it has a spectrum of the same form: of a force of variance s^2 then erf(a/2^1/2)
    remains in its correlation with the waves (Bussgang 1952), a = limit/s. Runs in time show what it absorbs.
    """

    def gain(x: FloatArray) -> ComplexArray:
        weights = best.weights._replace(force=best.weights.force * np.exp(x[0]))
        return np.asarray(np.exp(x[1]) * port.controller(weights, noise))

    def lost(x: FloatArray) -> float:
        k = gain(x)
        force = np.abs(k) ** 2 * port.excitation
        size = np.sqrt(port.integral(force))
        a = limit / size
        kept = float(erf(a / np.sqrt(2)))
        squared = kept - np.sqrt(2 / np.pi) * a * np.exp(-(a**2) / 2) + a**2 * (1 - kept)
        along = port.integral(np.real(k.conj() * port.admittance) * port.excitation)
        beyond = max(size / (LOUDEST * limit) - 1, 0.0) + max(-x[1], 0.0)
        power = kept * along - squared * port.integral(port.admittance.real * force)
        return float(beyond - power / best.power)

    start = np.array([[0.0, 0.1], [1.0, 0.1], [0.0, 1.1]])
    options: Any = {"initial_simplex": start, "xatol": 1e-2, "fatol": 1e-5}
    return gain(minimize(lost, start[0], method="Nelder-Mead", options=options).x)


def realised(port: StationaryPort, gain: ComplexArray) -> tuple[Controller, float]:
    """Return a filter with F = K F_e at a port, and its error: of mean power or rms force, whichever is larger.

    Raises `StabilityError` if no filter is stable in closed loop.

    Parameters
    ----------
    gain : ndarray, shape (omega,) [-]
        K, see `StationaryPort.controller`.
    """
    wanted, found = achieved(port, gain), []
    for order in ORDERS:
        controller = _of_order(port, gain, order)
        stable, _ = controller.stability(port.omega, port.admittance)
        reached = achieved(port, controller.gain(port.omega, port.admittance))
        if stable:
            found.append((max(abs(a / b - 1) for a, b in zip(reached, wanted, strict=True)), controller))
        if stable and found[-1][0] <= FITTED:
            break
    if not found:
        raise StabilityError(
            f"pto.law causal: no filter of up to {ORDERS[-1]} states realises this controller with a stable closed "
            "loop; lower pto.force_limit, or raise pto.control.noise"
        )
    error, controller = min(found, key=lambda one: one[0])
    return controller, error


def _of_order(port: StationaryPort, gain: ComplexArray, order: int) -> Controller:
    """The filter of an order by vector fitting, then by least squares weighted with the force of the waves."""
    omega, peak = port.omega, port.omega[int(np.argmax(port.excitation))]
    near = peak * np.linspace(BAND[0], min(BAND[1], omega[-1] / peak), POINTS)
    at = np.unique(np.searchsorted(omega, np.append(np.geomspace(omega[0], omega[-1], POINTS), near)))
    at = at[at < len(omega)]
    s, k = 1j * omega[at], gain[at].conj()
    k_v = k / port.admittance[at].conj()
    bounded = k_v - k_v[-1].real - (k_v[0] * s[0]).real / s  # without damper and spring
    poles = vector_fit(omega[at], np.stack([k / np.abs(k).max(), bounded / np.abs(bounded).max()], axis=1), order)
    size = np.abs(poles)
    poles = poles[(size > SLOW * peak) & (size < FAST * omega[-1]) & (-poles.real > LIGHT * size)]
    basis, block, ones = partial_fractions(s, poles)
    weight = np.sqrt(port.excitation[at] / port.excitation.max() + FLOOR)

    def fitted(functions: ComplexArray, values: ComplexArray) -> FloatArray:
        rows = functions * weight[:, None]
        rows, right = (
            np.vstack([rows.real, rows.imag]),
            np.concatenate([(weight * values).real, (weight * values).imag]),
        )
        size = np.linalg.norm(rows, axis=0)
        return np.asarray(np.linalg.lstsq(rows / size, right, rcond=None)[0] / size)

    of_force = fitted(basis, k)
    seen = (port.admittance[at].conj() * (1 - k))[:, None]  # with K_V Y (1 - K) = K (1 - K_F) the loop closes to K
    of_both = fitted(np.column_stack([basis, np.ones(len(s)), 1 / s]) * seen, k * (1 - basis @ of_force))
    *of_velocity, c, stiffness = of_both
    unit = np.sqrt(np.linalg.norm(of_velocity) / np.linalg.norm(ones))  # states of the size of the port's motion
    return Controller(block.T, np.array(of_velocity) / unit, of_force / unit, unit * ones, float(c), float(stiffness))
