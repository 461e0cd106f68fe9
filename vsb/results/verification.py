"""A linear year corrected by few runs in time of a better model: which seas to run, the runs, and what they say.

Seas are drawn by the energy linear theory expects of them, the high and the steep more often, two within each of strata
of equal chance. What counts is the difference of the better model to linear theory in the very same waves: it is small,
and so is its scatter, while that of the power itself, from sea to sea and within a record, drops out.

With chances q that sum to 1 the sum of h N over the year is the mean of h N/q over draws (Hansen and Hurwitz), and that
of h L is known. The corrected year is the year by linear theory times the ratio of the means of h N/q and h L/q, L in
the very waves and window of N: what a record, or a sea, has more or less of than the year drops out of it. Its draws
are what h N/q leaves beside that ratio of h L/q; of two draws x, y in each of S equal strata the variance of the mean
is sum (x - y)^2/(4 S^2).

A record is `RECORD` energy periods of its sea after a start-up of `STARTUP` or more, as long as motions remember, but
at most `LONGEST`. Where motions remember longer, such as those of a shell without structural damping, linear theory
starts from rest, too, and what that changes of its own power widens the intervals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.engine.integrators.settings import RECORDS_PER_PERIOD, Simulation
from vsb.engine.integrators.simulate import legs
from vsb.engine.motion.controller import Controller
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, body_exact_scene, linear_scene
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import ConfigError, ConvergenceError
from vsb.models.build import Memory, body_exact_latching_time, check_followed, linear_latching_time, with_latching_time
from vsb.models.stationary import loop_rates, with_controller
from vsb.models.take_off import with_take_off
from vsb.results.campaign import GAIN, POWER
from vsb.results.ledger import energy_check
from vsb.results.statistics import Estimate, linear_batches, stratified_half_width
from vsb.results.year import Year
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray, IntArray

FEWEST = 4
"""Fewest seas to draw: two strata."""
STARTUP, RECORD = 3.0, 10.0
"""Energy periods of a sea before means are taken, and over which they are."""
DECAYS = 5.0
"""Start-up in decay times of the slowest motion of the port, if longer: a ten-thousandth of its power is left."""
TOLERANCE, FEWER_RECORDS = 1e-5, 50
"""Of the motion, and records per period where no take-off is nonlinear: mean powers err by 1e-6, intervals by 1e-3."""
LONGEST = 100.0
"""Most energy periods of a start-up."""
Model = Literal["linear", "body_exact"]
UNLIMITED = Pto()
"""A take-off without limits: a spring and a damper."""


class Control(NamedTuple):
    """A causal controller: the optimum of linear theory, the filter it is, and the one whose force is cut."""

    omega: FloatArray  # (omega,) [rad/s]
    gain: ComplexArray  # K, the force over the Thevenin force (omega,) [-]
    linear: Controller  # K as a filter
    limited: Controller  # that of a force that is cut at the limit


# seas to run --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sample:
    """Seas drawn from a climate, two of each stratum one after the other; each has its own seed of phases."""

    sea: IntArray  # index in the climate (draw,)
    seed: IntArray  # of the phases (draw,)
    weight: FloatArray  # hours over chance of the drawn sea (draw,) [-]

    @property
    def strata(self) -> int:
        """Number of strata."""
        return len(self.sea) // 2


def contributions(year: Year, tuning: str) -> FloatArray:
    """Return what each sea contributes to a year by linear theory, all designs alike, shape (sea,), sums to 1 [-].

    Raises `ConfigError` if the tuning is not there, or no design absorbs power.
    """
    if tuning not in year.tunings:
        raise ConfigError(f"verify: received the tuning {tuning!r}, needs one of {', '.join(year.tunings)}")
    energy = year.power[:, year.tunings.index(tuning)] * year.climate.hours
    totals = energy.sum(axis=1)
    if not totals.any():
        raise ConfigError(f"verify: received designs that absorb no power under {tuning}, needs one that does")
    return np.asarray((energy[totals > 0] / totals[totals > 0, None]).mean(axis=0))


def chances(year: Year, tuning: str) -> FloatArray:
    """Return how likely each sea is to be drawn, shape (sea,), sums to 1 [-]; raises `ConfigError` see `contributions`.

    Half by energy, a quarter by energy times Hs^4, a quarter by energy times (Hs/Te^2)^4. What linear theory leaves out
    grows with height or steepness, at first with its square, beyond a threshold faster: chances in proportion to the
    difference itself scatter least. No sea weighs more than twice what it does by energy alone.
    """
    energy, seas = contributions(year, tuning), year.climate
    high, steep = (energy * grows for grows in (seas.hs**4, (seas.hs / seas.te**2) ** 4))
    return np.asarray(energy / 2 + high / high.sum() / 4 + steep / steep.sum() / 4)


def drawn(share: FloatArray, hours: FloatArray, seas: int, seed: int) -> Sample:
    """Return seas drawn by their chances, two within each stratum of equal chance.

    Raises `ConfigError` if `seas` is odd or less than 4.

    Parameters
    ----------
    share : ndarray, shape (sea,) [-]
        See `chances`.
    hours : ndarray, shape (sea,) [-]
        Share of the year of each sea.
    seas : int
        How many, an even number.

    Notes
    -----
    Seas are put in the order of their chance per hour on a line of their chances, which is cut evenly into strata; a
    sea on a cut belongs to both sides, each with its part.
    """
    if seas < FEWEST or seas % 2:
        raise ConfigError(f"verify.seas: received {seas}, needs an even number of at least {FEWEST}")
    random = np.random.default_rng(seed)
    strata = seas // 2
    order = np.argsort(np.divide(share, hours, out=np.zeros_like(share), where=hours > 0), kind="stable")
    end = np.cumsum(share[order])
    at = (np.repeat(np.arange(strata), 2) + random.uniform(size=seas)) / strata * end[-1]
    sea = order[np.searchsorted(end, at, side="right").clip(max=len(order) - 1)]
    return Sample(sea, random.integers(2**31, size=seas), hours[sea] / share[sea])


# runs ---------------------------------------------------------------------------------------------------------------


def record_of(te: float, decay: float, settings: Simulation) -> Simulation:
    """Return the run in time of a sea: long enough in its periods, from rest.

    Parameters
    ----------
    te : float
        Energy period of the sea [s].
    decay : float
        Longest decay time of the motions it excites [s].
    settings : Simulation
        Its method, and its tolerance where that is larger than `TOLERANCE`.
    """
    startup = min(max(STARTUP * te, DECAYS * decay), LONGEST * te)
    end, tolerance = startup + RECORD * te, max(settings.tolerance, TOLERANCE)
    record = {"duration": end, "window": (startup, end), "tolerance": tolerance}
    return settings.model_copy(update={**record, "initial_position": 0.0, "initial_velocity": 0.0})


@dataclass(frozen=True)
class DesignInTime:
    """One design with its take-off, ready for any sea."""

    buoy: LinearSystem
    shape: DeformedShell | None  # at rest; a body has none
    radiation: Memory
    motions: FloatArray  # motions the design allows (dof, free)
    take_off: LinearPto
    pto: Pto = UNLIMITED  # its law and its limits in time
    rubber: LoadedShell | None = None  # the shell, if it is of rubber
    control: Control | None = None  # in place of the damper, with the law `causal`

    def with_damping(self, damping: FloatArray | float) -> "DesignInTime":
        """Return the design with another damper [N s/m], or another damper matrix (port, port)."""
        return replace(self, take_off=replace(self.take_off, damping=damping))

    def decay_time(self, omega_max: float) -> float:
        """Return the longest decay time 1/(zeta omega) of natural motions up to a frequency, beside the damper [s].

        Of those that move the port: a surge that lasts for hours beside a take-off of heave changes no power.
        """
        if self.control:
            rates = loop_rates(self._scene(NO_WAVES, "linear"), "the design")
            return 1 / float(np.min(-rates.real[np.abs(rates.imag) <= omega_max]))
        whole = replace(self.buoy, pto=self.take_off)
        omega, ratio = whole.natural_modes(self.motions, omega_max, self.take_off.direction(len(whole.labels)))
        slowest = float(np.min((ratio * omega)[omega <= omega_max], initial=np.inf))
        return 1 / slowest if slowest > 0 else np.inf

    def powers(self, sea: Sea, settings: Simulation, model: Model = "body_exact") -> tuple[float, float]:
        """Return mean power over the window [W], by the model and by linear theory in the same waves.

        After conversion: the power of these laws goes one way at every instant, and the efficiency is a factor.

        Parameters
        ----------
        sea : Sea
            A realisation, see `vsb.engine.waves.climate.realised`.
        settings : Simulation
            Its window begins after the transient, which linear theory does not have.
        model : {'body_exact', 'linear'}
        """
        if self.control:
            linear = self._linear_power(self.control, sea, settings)
        else:
            loads = self._absorbed(sea.omega) * sea.amplitude[:, None]
            linear = float(linear_batches(sea.omega, loads, settings.window, 1)[0])
        return self._run(sea, settings, model), self.pto.efficiency * linear

    def from_rest(self, sea: Sea, settings: Simulation) -> float:
        """Return the mean power over the window by linear theory from rest, its transient included [W]."""
        kept = {"efficiency": self.pto.efficiency, "law": "causal" if self.control else "linear"}
        control = self.control and self.control._replace(limited=self.control.linear)
        one = replace(self, pto=UNLIMITED.model_copy(update=kept), control=control)
        return one._run(sea, settings, "linear")

    def _linear_power(self, control: Control, sea: Sea, settings: Simulation) -> float:
        """Mean of F V over the window by linear theory, as the difference of the squares of (F + V)/2 and (F - V)/2."""
        port = self.buoy.port(sea.omega, self.motions, self.take_off.direction(len(self.buoy.mass)))
        gain = np.interp(sea.omega, control.omega, control.gain)
        force = gain * port.velocity * port.impedance * sea.amplitude
        velocity = port.velocity * sea.amplitude - port.admittance * force
        unit = np.sqrt(np.linalg.norm(force) / np.linalg.norm(velocity))
        both = ((force / unit + sign * velocity * unit)[:, None] / 2 for sign in (1, -1))
        more, less = (float(linear_batches(sea.omega, one, settings.window, 1)[0]) for one in both)
        return more - less

    def _absorbed(self, omega: FloatArray) -> ComplexArray:
        """L^T V of the take-off's dampers L L^T per wave amplitude, shape (omega, load) [W^0.5/m]."""
        direction = self.take_off.direction(len(self.buoy.mass))
        if self.take_off.several:
            matrix = np.asarray(self.take_off.damping)
            ports = self.buoy.equation(omega).ports(self.motions, direction)
            values, vectors = np.linalg.eigh(matrix)
            return np.asarray(ports.velocity_under(matrix) @ vectors * np.sqrt(values.clip(min=0.0)))
        port, damping = self.buoy.port(omega, self.motions, direction), float(self.take_off.damping)
        port = port.beside(float(self.take_off.stiffness))
        return np.asarray(np.sqrt(damping) * port.velocity_under(port.load(damping)))[:, None]

    def _scene(self, sea: Sea, model: Model) -> Scene:
        """The design with its take-off in a sea."""
        buoy = replace(self.buoy, pto=self.take_off)
        memory, limit = self.radiation.model, self.radiation.added_mass_inf
        if model == "linear":
            scene = linear_scene(buoy, memory, sea, self.motions, limit)
        else:
            assert self.shape is not None
            scene = body_exact_scene(buoy, self.shape, memory, sea, self.motions, self.rubber)
        scene = with_take_off(scene, self.pto, self.take_off)
        return with_controller(scene, self.control.limited) if self.control and scene.law else scene

    def _run(self, sea: Sea, settings: Simulation, model: Model) -> float:
        """Mean power over the window by a run [W]; `ConvergenceError` if its energy audit fails."""
        check_followed(self.radiation, sea, "the sea")
        buoy, scene = replace(self.buoy, pto=self.take_off), self._scene(sea, model)
        if self.pto.has_latching_time and scene.law:  # or nothing there moves
            best = linear_latching_time(self._scene(sea, "linear"), sea, settings)
            best = best if model == "linear" else body_exact_latching_time(scene, best, sea, settings)
            scene = with_latching_time(scene, best.time)
        system, absorbed = System.of(scene), []
        records = RECORDS_PER_PERIOD if system.switching else FEWER_RECORDS
        for leg in legs(system, sea, settings, buoy.spectrum, records=records):
            absorbed.append((leg.motion.time, leg.energy["pto"]))
        check_audit(settings, leg.balance.residual)
        first = [0] + [1] * (len(absorbed) - 1)  # a leg begins where the one before ended
        time, energy = (np.concatenate([one[k][i:] for one, i in zip(absorbed, first, strict=True)]) for k in (0, 1))
        start, end = settings.window
        return self.pto.efficiency * float(np.diff(CubicSpline(time, energy)([start, end]))[0] / (end - start))


def check_audit(settings: Simulation, residual: float) -> None:
    """Refuse the power of a run whose energy audit fails; raises `ConvergenceError`."""
    check = energy_check(settings, residual)
    if check.verdict == "fail":
        raise ConvergenceError(
            f"the energy audit fails: {residual:.1e} of the energy is missing, needs {check.limit:.0e}; lower "
            "simulation.tolerance"
        )


# the corrected year -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Verification:
    """A year by linear theory and the mean powers of the drawn seas, of a better model and of linear theory."""

    linear_year: FloatArray  # annual mean power (design,) [W]
    linear_seas: FloatArray  # expected power of all seas (design, sea) [W]
    hours: FloatArray  # (sea,) [-]
    sample: Sample
    better: FloatArray  # mean power of the better model's runs (design, draw) [W]
    linear: FloatArray  # of linear theory in the same waves and window (design, draw) [W]
    steady: FloatArray | None = None  # of linear theory without transients, where `linear` may hold some

    @property
    def transient(self) -> FloatArray:
        """What transients that are not over change of linear theory in the draws, shape (design,) [-]."""
        if self.steady is None:
            return np.zeros(len(self.linear))
        steady = (self.sample.weight * self.steady).sum(axis=1)
        changed = (self.sample.weight * np.abs(self.linear - self.steady)).sum(axis=1)
        return np.asarray(np.divide(changed, steady, out=np.zeros_like(steady), where=steady > 0))

    @cached_property
    def differences(self) -> FloatArray:
        """Draws of the corrected year about its mean, shape (design, draw) [W]."""
        mean = self._linear.mean(axis=1)
        ratio = np.divide(self._better.mean(axis=1), mean, out=np.zeros_like(mean), where=mean > 0)
        return np.asarray(self._scale[:, None] * (self._better - ratio[:, None] * self._linear))

    @property
    def corrected(self) -> FloatArray:
        """Corrected annual mean power, shape (design,) [W]; the mean of draws where linear theory absorbs nothing."""
        return np.asarray(self._scale * self._better.mean(axis=1))

    @property
    def _better(self) -> FloatArray:
        """Draws of the year by the better model, h N/q, shape (design, draw) [W]."""
        return np.asarray(self.sample.weight * self.better)

    @property
    def _linear(self) -> FloatArray:
        """Draws of the year by linear theory in the same waves, h L/q, shape (design, draw) [W]."""
        return np.asarray(self.sample.weight * self.linear)

    @property
    def _scale(self) -> FloatArray:
        """Year by linear theory over its estimate from the draws, shape (design,) [-]; 1 where nothing is absorbed."""
        mean = self._linear.mean(axis=1)
        return np.asarray(np.divide(self.linear_year, mean, out=np.ones_like(mean), where=mean > 0))

    def power(self, design: int) -> Estimate:
        """Return the corrected annual mean power of a design and its interval [W]."""
        mean = float(self.corrected[design])
        return _estimate(mean, self.differences[design], abs(mean) * float(self.transient[design]))

    def gain(self, design: int, reference: int) -> Estimate | None:
        """Return the gain of the corrected year over another design's and its interval [%]; None over no power."""
        base = float(self.corrected[reference])
        if design == reference or not base > 0:
            return None
        ratio = float(self.corrected[design]) / base
        left = self.differences[design] - ratio * self.differences[reference]
        still = abs(ratio) * float(self.transient[design] + self.transient[reference])
        return _estimate(100 * (ratio - 1), 100 * left / base, 100 * still)


def verified(
    year: Year,
    tuning: str,
    sample: Sample,
    better: FloatArray,
    linear: FloatArray,
    steady: FloatArray | None = None,
) -> Verification:
    """Return the correction of a year by runs in the drawn seas.

    Raises `ConfigError` if powers are missing or not finite.

    Parameters
    ----------
    tuning : str
        Under which the runs were made.
    better, linear : ndarray, shape (design, draw) [W]
        Mean powers of the better model and of linear theory, in the same waves and window.
    steady : ndarray, optional
        Those of linear theory without transients; as `linear` where it is not given.
    """
    needed = (len(year.designs), len(sample.sea))
    for name, values in (("better", better), ("linear", linear)):
        if values.shape != needed or not np.all(np.isfinite(values)):
            raise ConfigError(
                f"verify: received {name} powers of shape {values.shape}, {int(np.sum(~np.isfinite(values)))} of them "
                f"not finite; needs {needed[0]} designs by {needed[1]} seas, all finite"
            )
    j = year.tunings.index(tuning)
    seas = year.power[:, j]
    return Verification(year.annual_mean_power[:, j], seas, year.climate.hours, sample, better, linear, steady)


def _estimate(mean: float, draws: FloatArray, beyond: float) -> Estimate:
    """An estimate with the interval its draws give, and a bound beyond."""
    half = stratified_half_width(draws) + beyond
    return Estimate(mean, mean - half, mean + half)


def verified_dataset(year: Year, tuning: str, runs: Verification) -> xr.Dataset:
    """Return the corrected year of every design under a tuning with its intervals, and the runs behind it.

    Raises `ConfigError` if the corrected power of the reference is not above 0, over which gains are.
    """
    powers = [runs.power(i) for i in range(len(year.designs))]
    values: dict[str, tuple[tuple[str, ...], AnyArray]] = {
        name: (("design",), column) for name, column in zip(POWER, np.array(powers).T, strict=True)
    }
    if year.reference is not None:
        gains = _gains(year, runs, year.tunings.index(tuning)).T
        values |= {name: (("design",), column) for name, column in zip(GAIN, gains, strict=True)}
    sea = runs.sample.sea
    drawn = {"sea": sea, "seed": runs.sample.seed, "weight": runs.sample.weight}
    drawn |= {"hs": year.climate.hs[sea], "te": year.climate.te[sea]}
    values |= {f"drawn_{name}": (("draw",), column) for name, column in drawn.items()}
    powers_of = {"run_power": runs.better, "linear_run_power": runs.linear, "drawn_power": runs.linear_seas[:, sea]}
    values |= {name: (("design", "draw"), power) for name, power in powers_of.items()}
    return xr.Dataset(values, coords={"design": list(year.designs)})


def without_power(year: Year) -> xr.Dataset:
    """Return the corrected year of designs that absorb nothing by linear theory, so that no sea is drawn."""
    nothing = ("design", np.zeros(len(year.designs)))
    missing = ("design", np.full(len(year.designs), np.nan))
    values = dict.fromkeys(POWER, nothing) | (dict.fromkeys(GAIN, missing) if year.reference is not None else {})
    return xr.Dataset(values, coords={"design": list(year.designs)})


def _gains(year: Year, runs: Verification, tuning: int) -> FloatArray:
    """Gains of all designs over the reference and their intervals, none of its own; NaN if it absorbs nothing."""
    at = year.designs.index(str(year.reference))
    if not year.annual_mean_power[at, tuning] > 0:
        return np.full((len(year.designs), len(GAIN)), np.nan)
    if not (base := float(runs.corrected[at])) > 0:
        raise ConfigError(
            f"verify: received a corrected power of {base:.4g} W of the rigid {year.reference}; needs more than 0 W, "
            "more seas or a longer simulation.window"
        )
    return np.array([runs.gain(i, at) or Estimate(0.0, 0.0, 0.0) for i in range(len(year.designs))])


def with_all_designs(found: xr.Dataset, designs: Sequence[str], reference: str | None) -> xr.Dataset:
    """Return a dataset of viable designs extended to all designs, NaN where a design is not viable."""
    names = (*POWER, *(GAIN if reference is not None else ()))
    blank = xr.Dataset({name: ("design", np.full(len(designs), np.nan)) for name in names})
    blank = blank.assign_coords(design=list(designs))
    whole = blank.assign(found.reindex(design=list(designs)).data_vars)
    return whole.assign(viable=("design", np.isin(designs, found.design.values)))
