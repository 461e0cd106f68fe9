"""Scenes every integrator follows: one design from rest, linear or body-exact, in a regular wave or an irregular sea.

All give the motion at the same instants, where a converged solution tells their errors.
"""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from scipy.integrate import simpson

from benchmarks.general_solvers import Equation, Solution, solved
from benchmarks.hard_cases import hydro_files
from benchmarks.measure import Row
from vsb.errors import VsbError
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.energy_preserving import fixed_step
from vsb.integrators.exact import convolve
from vsb.integrators.exponential import integrate
from vsb.motion.forces import RadiationMemory
from vsb.motion.scene import Scene
from vsb.motion.system import Motion, System
from vsb.scenes.build import SCENES, DesignInSea
from vsb.study.plan import StudyPlan
from vsb.study.study import Study, parse
from vsb.tools.arrays import FloatArray

CONVOLUTION, STEPS = "convolution", "structure-preserving"
REGULAR, IRREGULAR = "regular wave", "irregular sea"
PERIOD = 2.5
"""Of the regular wave [s]."""
SEAS = {
    REGULAR: {"kind": "regular", "amplitude": 0.179, "period": PERIOD},
    IRREGULAR: {"kind": "jonswap", "hs": 0.5, "tp": 4.0},
}
MODELS = {"linear": {"model": "linear"}, "body-exact": {"model": "body_exact"}}
PER_PERIOD = 64
"""Instants at which motions are compared in a `PERIOD`."""
FINEST = 1e-13
"""Tolerance of DOP853 for the converged solution of a linear scene."""
STRIDES = (8, 4, 2, 1, -2, -4)
"""Instants a fixed step takes, or their negative parts."""
TIME_LIMIT = 10.0
"""Of one run [s]."""


@dataclass(frozen=True)
class ModelKernel(DampingSpectrum):
    """Kernel of the state space itself, so that a convolution differs by its own errors alone."""

    model: RadiationModel

    def kernel(self, time: FloatArray) -> FloatArray:
        """Return the kernel of the model."""
        return self.model.kernel(time)


def remembering(scene: Scene, model: RadiationModel) -> Scene:
    """Return a scene with another radiation memory."""
    return replace(scene, forces={**scene.forces, "radiation": RadiationMemory(model)})


def scene_of(study: Study, folder: str | Path) -> DesignInSea:
    """Return the scene of the only design in the only sea of a study; its hydro files are made in a folder."""
    (design,), (wave,) = study.designs, study.waves
    paths = hydro_files(study, folder)
    one = StudyPlan(study).simulation(design, wave)
    return SCENES[one.hydro.model](one, paths)


def varied(study: Study, design: str, model: str, sea: str, duration: float, **changes: object) -> Study:
    """Return a study of one design with one of `MODELS` in one of `SEAS`; `changes` are of its device and modes."""
    data = study.model_dump()
    data |= {"published": None, "designs": {design: data["designs"][design]}, "waves": [SEAS[sea]]}
    data["hydro"] = {**{k: data["hydro"][k] for k in ("tolerance", "omega_max")}, **MODELS[model]}
    still = {"initial_position": 0.0, "initial_velocity": 0.0, "method": "auto"}
    data["simulation"] |= {"duration": duration, "window": [duration / 2, duration], **still}
    for section, change in changes.items():
        data[section] |= change
    return parse(data, source=study.study)


@dataclass(frozen=True)
class Case:
    """The motion of one scene, at common instants."""

    system: System
    time: FloatArray  # common instants (time,) [s]
    start: tuple[FloatArray, FloatArray]  # y and y'
    spectrum: DampingSpectrum | None = None  # of the memory, for a convolution

    @cached_property
    def equation(self) -> Equation:
        """The equation in plain coordinates, compiled."""
        equation = Equation.of(self.system, self.start)
        equation.rates(0.0, equation.first)
        return equation

    @cached_property
    def reference(self) -> Solution:
        """Converged solution; DOP853 at 1e-12 checks ours in the tables."""
        return self.general("DOP853", FINEST, 3 * TIME_LIMIT) if self.system.linear else self.exponential(1e-11)

    def exponential(self, tolerance: float) -> Solution:
        """Run the exponential Adams method."""
        return self.ours(partial(integrate, self.system, self.time, self.start, tolerance))

    def ours(self, run: Callable[[], Motion | tuple[Motion, int]], stride: int = 1) -> Solution:
        """Run one of our integrators, whose instants are the common ones, every so many of them or parts of them."""
        begun, none = clock.perf_counter(), np.zeros(0)
        try:
            out = run()
        except VsbError as error:
            return Solution(none, none, clock.perf_counter() - begun, None, None, str(error))
        motion, steps = out if isinstance(out, tuple) else (out, len(out.time) - 1)
        seconds, every = clock.perf_counter() - begun, max(-stride, 1)
        return Solution(motion.position[::every, 0], motion.velocity[::every, 0], seconds, steps, None)

    def general(self, method: str, tolerance: float, limit: float = TIME_LIMIT) -> Solution:
        """Run a general integrator."""
        return solved(self.equation, method, tolerance, self.time, limit)

    def stepped(self, method: str, stride: int) -> Solution:
        """Run a method of fixed steps."""
        count = (len(self.time) - 1) * max(-stride, 1) // max(stride, 1)
        time = np.linspace(0.0, self.time[-1], count + 1)
        if method == STEPS:
            return self.ours(partial(fixed_step, self.system, time, self.start), stride)
        assert self.spectrum is not None  # of a convolution
        return self.ours(partial(convolve, self.system, self.spectrum, time, self.start), stride)

    def errors(self, found: Solution, stride: int = 1) -> Row:
        """Largest error of heave over its range, and error of the energy a damper takes; none of a run that failed.

        What was followed for a shorter time is compared over that.
        """
        every = slice(0, max(stride, 1) * len(found.heave), max(stride, 1))
        time, heave, velocity = self.time[every], self.reference.heave[every], self.reference.velocity[every]
        if not len(heave):
            return {}
        exact, energy = (float(simpson(v**2, x=time)) for v in (velocity, found.velocity))
        error = float(np.abs(found.heave - heave).max() / np.ptp(self.reference.heave[: every.stop]))
        return {"error": error, "error_energy": abs(energy / exact - 1) if self.system.dampers()[0].any() else None}


def case_of(scene: DesignInSea, duration: float) -> Case:
    """The motion of a scene from rest for so long; a convolution of it has the kernel of its state space.

    Instants are `PER_PERIOD` a period, a multiple of the longest stride.
    """
    system, spectrum, model = scene.system, scene.spectrum, scene.scene.memory
    assert spectrum is not None  # of a database
    assert model is not None
    intervals = int(np.ceil(PER_PERIOD * duration / PERIOD / STRIDES[0]))
    time = np.linspace(0.0, duration, STRIDES[0] * intervals + 1)
    return Case(system, time, scene.scene.start(0.0, 0.0), ModelKernel(spectrum.omega, spectrum.damping, model))
