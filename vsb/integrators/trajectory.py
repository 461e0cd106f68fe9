"""Labelled time series of a run: motion, forces by name, and the energy audit."""

import numpy as np
import xarray as xr

from vsb.errors import ConvergenceError
from vsb.hydro.kernel import DampingSpectrum
from vsb.integrators.audit import flow
from vsb.integrators.energy_preserving import structure_preserving
from vsb.integrators.exact import convolve, propagate
from vsb.integrators.exponential import integrate
from vsb.motion.froude_krylov import wave_forces
from vsb.motion.motion import Motion
from vsb.motion.scene import ConstantForce, Damper, Excitation, Plant, Spring, WaterPressure
from vsb.study.study import Simulation
from vsb.tools.units import FloatArray
from vsb.waves.seas import Sea
from vsb.waves.superposition import superposed

EXCITING = ("excitation", "froude_krylov", "diffraction")
DAMPERS = ("pto", "structural_damping")
TERMS = ("wave", "pto", "radiated", "structural", "stored")
EXACT = "exact propagation"
CONVOLVED = 1e-4
"""Energy residual of a convolution: its motion is of second order, and so is what it loses."""
ROUND_OFF = 1e-9
"""Energy residual that is as good as none [-]."""
_FINEST = 5  # at most 2^5 samples per recorded step


def forces(plant: Plant, motion: Motion) -> dict[str, FloatArray]:
    """Return the forces of the scene by name, each shape (time, dof) [N].

    Radiation is what remains of the equation of motion, M q'' - sum of the other forces, in the allowed motions: it is
    the same line for the state space and for the convolution.
    """
    q, v = motion.position @ plant.motions.T, motion.velocity @ plant.motions.T
    out: dict[str, FloatArray] = {}
    for name, force in plant.forces.items():
        if isinstance(force, Spring):
            out[name] = -q @ force.stiffness.T
        elif isinstance(force, Damper):
            out[name] = -v @ force.damping.T
        elif isinstance(force, ConstantForce):
            out[name] = np.broadcast_to(force.force, q.shape)
        elif isinstance(force, WaterPressure):
            out |= _water_forces(force, motion.time, q)
        elif isinstance(force, Excitation):
            out[name] = superposed(force.omega, force.force, motion.time)
        elif motion.memory.size:
            out[name] = -motion.memory @ force.model.input_matrix
    if "radiation" in plant.forces and "radiation" not in out:
        inertia = motion.acceleration @ plant.motions.T @ plant.mass.T
        out["radiation"] = inertia - sum(out.values(), np.zeros_like(q))
    return out


def _water_forces(water: WaterPressure, time: FloatArray, q: FloatArray) -> dict[str, FloatArray]:
    """Hydrostatic force on the shell in still water, and what an assumed pressure or waves add, (time, dof) [N]."""
    static, uniform, _ = water.shell.forces(water.rest + q)
    out = {"hydrostatic": water.specific_weight * static}
    if water.assumed and water.assumed.amplitude:
        pressure = water.assumed.amplitude * np.cos(water.assumed.omega * time)
        out["excitation"] = pressure[:, None] * uniform
    if water.waves:
        total = wave_forces(water.shell.shape, water.rest + q, water.waves, time)
        out["froude_krylov"] = water.specific_weight * (total - static)
    return out


def energies(plant: Plant, motion: Motion) -> dict[str, FloatArray]:
    """Return the energy of each term since the start, each shape (time,) [J]: wave = the sum of the others.

    Notes
    -----
    Losses and the waves' work are integrated along the flow between records (`vsb.audit`), what is stored is read from
    the records.
    `turned` is no term of the sum: kinetic energy, and a billionth of the energy stored, below which all is round-off.
    With the state space, radiated power is (l.x)^2/2 and the memory stores x.x/2, both from the memory states alone:
    the audit is then a check on the whole chain. With the convolution the radiation force's work stands for both.
    """
    named, remembered = forces(plant, motion), motion.memory.size > 0
    none = np.zeros((len(motion.time), len(plant.labels)))
    undamped = Damper(np.zeros((len(plant.labels), len(plant.labels))))
    dampers = [plant.forces.get(name, undamped) for name in DAMPERS]
    exciting = sum((named[name] for name in EXCITING if name in named), none)
    pto, structural, radiated, wave, *convolved = flow(plant, motion, named).works(
        [damper.damping for damper in dampers if isinstance(damper, Damper)],
        plant.memory.channel if plant.memory and remembered else None,
        [exciting] if remembered else [exciting, -named.get("radiation", none)],
    )
    stored, kinetic = _stored(plant, motion)
    return {
        "wave": wave,
        "pto": pto,
        "radiated": sum(convolved, radiated),
        "structural": structural,
        "stored": stored - stored[0],
        "turned": kinetic + 1e-9 * np.abs(stored),
    }


def _stored(plant: Plant, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Energy at every record in mass, springs, weight, water and memory, and its kinetic part, each (time,) [J]."""
    q, v = motion.position @ plant.motions.T, motion.velocity @ plant.motions.T
    kinetic = 0.5 * np.einsum("ti,ti->t", v @ plant.mass, v)
    stored = kinetic + 0.5 * np.einsum("ti,ti->t", motion.memory, motion.memory)
    for force in plant.forces.values():
        if isinstance(force, Spring):
            stored += 0.5 * np.einsum("ti,ti->t", q @ force.stiffness, q)
        elif isinstance(force, ConstantForce):
            stored -= q @ force.force
        elif isinstance(force, WaterPressure):
            stored -= force.specific_weight * force.shell.forces(force.rest + q)[2]
    return stored, kinetic


def residual(energy: dict[str, FloatArray]) -> float:
    """Return the largest unbalanced energy relative to the energy that went round [-].

    |wave - pto - radiated - structural - stored| over the largest of the terms and of the kinetic energy: in free
    motion without losses every term is zero but for errors.
    """
    unbalanced = energy["wave"] - sum(energy[term] for term in TERMS[1:])
    largest = max(float(np.abs(energy[term]).max()) for term in (*TERMS, "turned"))
    return float(np.abs(unbalanced).max() / largest) if largest else 0.0


def labelled(plant: Plant, motion: Motion, sea: Sea | None, design: str, wave: str, stride: int) -> xr.Dataset:
    """Return a run as a dataset, every `stride`-th instant, with the audit of all instants.

    A rigid design carries heave alone, a flexible one heave and all shell modes; an assumed pressure has no elevation.
    """
    flexible = plant.motions.shape[1] > 1
    labels = list(plant.labels if flexible else plant.labels[:1])
    motions = plant.motions[: len(labels)]
    energy = energies(plant, motion)
    kept = slice(None, None, stride)
    series: dict[str, FloatArray] = {"position": motion.position @ motions.T, "velocity": motion.velocity @ motions.T}
    series |= {name: force[:, : len(labels)] for name, force in forces(plant, motion).items()}
    run = xr.Dataset(
        {
            **{name: (("time", "dof"), values[kept]) for name, values in series.items()},
            "energy": (("time", "term"), np.stack([energy[term][kept] for term in TERMS], axis=1)),
        },
        coords={"time": motion.time[kept], "dof": labels, "term": list(TERMS)},
        attrs={"design": design, "wave": wave, "energy_residual": residual(energy), "status": "completed"},
    )
    return run.assign(elevation=("time", sea.elevation(motion.time[kept]))) if sea else run


def simulate(plant: Plant, sea: Sea, settings: Simulation, spectrum: DampingSpectrum | None) -> tuple[Motion, int, str]:
    """Return the motion of a scene, its energy audit closed.

    Parameters
    ----------
    plant : Plant
    sea : Sea
    settings : Simulation
        Duration, initial heave and velocity, method, tolerance. Exact propagation runs once. What is not linear is
        recorded at half the distance until the audit closes to the tolerance: this sharpens the audit, not the
        motion. For the convolution that distance is the step.
    spectrum : DampingSpectrum or None
        Only the convolution reads it.

    Returns
    -------
    motion : Motion
    stride : int
        Every how many instants make a readable record.
    method : str
        In words.

    Raises
    ------
    ConvergenceError
        If the audit of an exact propagation does not close.
    """
    recorded = _recorded_steps(plant, sea, settings)
    enough = max(settings.tolerance, CONVOLVED if settings.method == "convolution" else ROUND_OFF)
    found = [np.inf, np.inf]
    for halving in range(_FINEST + 1):
        stride = 2**halving
        time = np.linspace(0.0, settings.duration, recorded * stride + 1)
        motion, method = _motion(plant, time, settings, spectrum)
        found.append(residual(energies(plant, motion)))
        if found[-1] <= enough or found[-1] > 0.9 * found[-3]:  # closed, or finer records do not help
            break
        if method == EXACT:
            raise ConvergenceError(
                f"the energy audit does not close: {found[-1]:.1e} of the energy is missing, needs {enough:.0e}; "
                "near an undamped resonance add device.damping or pto.damping, else raise simulation.tolerance."
            )
    return motion, stride, method


def _motion(
    plant: Plant, time: FloatArray, settings: Simulation, spectrum: DampingSpectrum | None
) -> tuple[Motion, str]:
    """The motion by the method that suits the scene, and its name."""
    start = plant.start(settings.initial_position, settings.initial_velocity)
    if settings.method == "structure_preserving":
        motion, steps = structure_preserving(plant, time, start, settings.tolerance)
        return motion, f"structure-preserving, {steps} steps"
    if plant.water:
        motion, steps = integrate(plant, time, start, settings.tolerance)
        return motion, f"exponential Adams, {steps} steps"
    if settings.method == "convolution" and spectrum is not None:
        return convolve(plant, spectrum, time, start), "convolution"
    return propagate(plant, time, start), EXACT


def _recorded_steps(plant: Plant, sea: Sea, settings: Simulation) -> int:
    """Number of recorded steps: 200 a period of the shortest wave that matters.

    Without waves, of the faster of free heave and the assumed pressure: the buoy heaves freely until that has died out.
    """
    if sea.omega.size:
        strong = sea.omega[np.abs(sea.amplitude) > 0.05 * np.abs(sea.amplitude).max()]
        omega = float(strong.max())
    else:
        springs = plant.total(Spring)[0, 0] + (plant.water.tangent[0, 0] if plant.water else 0.0)
        omega = float(np.sqrt(max(springs, 0.0) / (plant.motions.T @ plant.mass @ plant.motions)[0, 0])) or 1.0
        if plant.water and plant.water.assumed and plant.water.assumed.amplitude:
            omega = max(omega, plant.water.assumed.omega)
    return int(np.ceil(200 * omega / (2 * np.pi) * settings.duration))
