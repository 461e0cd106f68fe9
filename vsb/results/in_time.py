"""Runs in time of the seas drawn from a climate: a better model beside linear theory, in the same waves."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.simulate import legs
from vsb.motion.builders import body_exact_scene, linear_scene
from vsb.motion.frequency import LinearBuoy
from vsb.motion.port import LinearPto
from vsb.motion.system import System
from vsb.results.run_checks import energy_check
from vsb.results.verification import linear_power
from vsb.scenes.pause import best_pause_in_sea, refined_pause, with_pause
from vsb.scenes.take_off import with_take_off
from vsb.shell.deformed import DeformedShell
from vsb.study.study import Simulation
from vsb.study.take_off import Pto
from vsb.tools.arrays import FloatArray
from vsb.waves.seas import Sea

Model = Literal["linear", "body_exact"]
LINEAR = Pto()
"""A take-off without limits: a spring and a damper."""


@dataclass(frozen=True)
class DesignInTime:
    """One design with its take-off, ready for any sea."""

    buoy: LinearBuoy
    shape: DeformedShell
    radiation: RadiationModel
    motions: FloatArray  # the motions the design allows (dof, free)
    take_off: LinearPto
    pto: Pto = LINEAR  # its law and its limits in time

    def under(self, damping: float) -> "DesignInTime":
        """Return the design under another damper [N s/m]."""
        return replace(self, take_off=replace(self.take_off, damping=damping))

    def decay_time(self, omega_max: float) -> float:
        """Return the longest decay time 1/(zeta omega) of natural motions up to a frequency, beside the damper [s]."""
        omega, ratio = replace(self.buoy, pto=self.take_off).natural_modes(self.motions)
        return float(np.max(1 / (ratio * omega)[omega <= omega_max], initial=0.0))

    def powers(self, sea: Sea, settings: Simulation, model: Model = "body_exact") -> tuple[float, float]:
        """Return mean power over the window, of the model and of linear theory in the same waves [W].

        Parameters
        ----------
        sea : Sea
            A realisation, see `vsb.waves.climate.realised`.
        settings : Simulation
            Its window after the transient, which linear theory has none of.
        model : {'body_exact', 'linear'}
        """
        direction = self.take_off.direction(len(self.buoy.mass))
        port = self.buoy.port(sea.omega, self.motions, direction).beside(float(self.take_off.stiffness))
        return self._run(sea, settings, model), linear_power(port, sea, float(self.take_off.damping), settings.window)

    def _run(self, sea: Sea, settings: Simulation, model: Model) -> float:
        """Mean power over the window by a run [W]; `ConvergenceError` if its energy audit fails."""
        buoy = replace(self.buoy, pto=self.take_off)
        scene = linear = linear_scene(buoy, self.radiation, sea, self.motions)
        if model != "linear":
            scene = body_exact_scene(buoy, self.shape, self.radiation, sea, self.motions)
        scene = with_take_off(scene, self.pto, self.take_off)
        if self.pto.pauses and scene.law:  # or nothing there moves
            best = best_pause_in_sea(with_take_off(linear, self.pto, self.take_off), sea, settings)
            scene = with_pause(scene, (best if model == "linear" else refined_pause(scene, best, sea, settings)).pause)
        taken = []
        for leg in legs(System.of(scene), sea, settings, buoy.spectrum):
            taken.append((leg.motion.time, leg.energy["pto"]))
        check_audit(settings, leg.balance.residual)
        first = [0] + [1] * (len(taken) - 1)  # a leg begins where the one before ended
        time, energy = (np.concatenate([one[k][i:] for one, i in zip(taken, first, strict=True)]) for k in (0, 1))
        start, end = settings.window
        gained = np.diff(CubicSpline(time, energy)([start, end]))[0]
        return float(gained / (end - start))


def check_audit(settings: Simulation, residual: float) -> None:
    """Check that no power is taken from a run whose energy audit fails.

    Raises
    ------
    ConvergenceError
    """
    check = energy_check(settings, residual)
    if check.verdict == "fail":
        raise ConvergenceError(
            f"the energy audit fails: {residual:.1e} of the energy is missing, needs {check.limit:.0e}; lower "
            "simulation.tolerance"
        )
