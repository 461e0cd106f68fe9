"""The few motions a design takes in waves and under its take-off, in place of all the shell's modes.

A shell may have hundreds of modes; what it does in waves, under any force at its ports, spans a dozen or two shapes. At
a few frequencies w the whole equation is solved for the waves, q = D(w)^-1 X, and for a force at each port,
D(w)^-1 b. The real and imaginary parts of these solutions, orthonormal in energy, are the reduced motions V, and the
equation in them is V^T D V: symmetric matrices stay symmetric, what dissipates still does, what rests stably still
does. Another frequency is added where the power of the port errs most (rational Krylov with a greedy choice), until
the error is below a tolerance at all frequencies looked at, also at some that were not to choose from.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from vsb.engine.hydro.orders import order_groups
from vsb.engine.hydro.variables import is_rigid
from vsb.engine.motion.linear import LinearSystem
from vsb.tools.arrays import ComplexArray, FloatArray

FEWEST = 24
"""Motions of a design up to which all are kept: fewer would save nothing."""
PRECISION = 1e-6
"""Largest relative error of the power at the optimal damper, beside which no other error counts [-]."""
TRANSIENT = 1e-3
"""Largest error of a motion at any frequency, over its largest, as the root of energy [-]: transients excite all."""
WORTH = 0.6
"""Part of all motions up to which reduced ones are worth their making."""
SWEEP_POINTS = 48
"""Frequencies of the band to choose from; between each two the error is measured."""
BEYOND, OF_START, FURTHER = 4.0, 20.0, 32
"""End of the frequencies looked at above the band, over its end and over the start's own, and their number; even, so
that the last one may be chosen."""
FAINT = 1e-4
"""Part of the largest power in the band below which errors of a power are relative to this part [-]."""
NEW = 5e-5
"""Part of a solution that is new beyond which it adds a motion, to begin with [-]; powers err by the square."""

ROUND_OFF = 1e-9
"""Such a part that is round-off [-]."""

_IN_BAND = 2 * SWEEP_POINTS - 1


@dataclass(frozen=True)
class ReducedMotions:
    """Motions of a design, reduced or all of them."""

    motions: FloatArray  # N (dof, motion), orthonormal
    error: float  # largest relative error of the power of a port, measured in the whole equation; 0 of all motions [-]
    all_motions: int  # how many the design has

    @property
    def reduced(self) -> bool:
        """Whether some are left out."""
        return bool(self.motions.shape[1] < self.all_motions)

    @property
    def notes(self) -> dict[str, int | float]:
        """What a run records of them; nothing of all motions."""
        if not self.reduced:
            return {}
        return {"motions": self.motions.shape[1], "all_motions": self.all_motions, "motions_error": self.error}


def reduced_motions(
    system: LinearSystem, motions: FloatArray, ports: FloatArray, start: FloatArray | None = None
) -> ReducedMotions:
    """Return the motions of a design in waves of all directions, under forces at its ports and after a start.

    All of them where there are few, or where a reduced set would not be much smaller.

    Parameters
    ----------
    system : LinearSystem
        A shell of revolution, without take-off.
    motions : ndarray, shape (dof, free)
        N, orthonormal.
    ports : ndarray, shape (dof,) or (dof, port)
    start : ndarray, shape (free,), optional
        The motion that begins with a displacement and a velocity; it is one of the reduced ones, like all rigid ones.
        Without it motions are steady.

    Notes
    -----
    Powers are those per squared wave amplitude at the optimal damper of one port and frequency, |V0|^2/4(|Y| + Re Y),
    of the waves that excite an azimuthal order most; of each order the motion is in the span.
    Any damper or spring at the ports is covered, since q = q_waves - q_port F. A start of y and y' acts like the forces
    K y and M y'; transients are measured far beyond the band, with the coefficients of its end.
    """
    whole = ReducedMotions(motions, 0.0, motions.shape[1])
    if motions.shape[1] <= FEWEST:
        return whole
    problem = _Problem.of(system, motions, ports.reshape(len(motions), -1), start)
    exact = [motions.T[:, i] for i, label in enumerate(system.labels) if is_rigid(label)]
    exact += [] if start is None else [start]
    basis = extended(np.zeros((motions.shape[1], 0)), problem.root @ np.column_stack(exact), 1e-9)
    choice = range(0, len(problem.omega), 2)  # those between are for the measured error alone
    chosen, new = [0, SWEEP_POINTS // 2 * 2, _IN_BAND - 1], NEW
    while new > ROUND_OFF:
        before = basis.shape[1]
        for k in chosen:
            basis = extended(basis, problem.snapshots(k), new)
        if basis.shape[1] > WORTH * motions.shape[1]:
            return whole
        if basis.shape[1] == before:
            new /= 4
            continue
        reduced = np.linalg.qr(solve_triangular(problem.root, basis))[0]
        power, moved = problem.errors(reduced)
        if power.max() <= PRECISION and moved.max() <= TRANSIENT:
            return ReducedMotions(motions @ reduced, float(power.max()), motions.shape[1])
        worst = list(dict.fromkeys(max(choice, key=error.__getitem__) for error in (power, moved)))
        chosen = [k for k in worst if power[k] > PRECISION or moved[k] > TRANSIENT] or worst
    return whole


def extended(basis: FloatArray, vectors: FloatArray, new: float) -> FloatArray:
    """Return an orthonormal basis (entry, vector) with what unit vectors add to it beyond a part `new` of them."""
    for _ in range(2):
        vectors = vectors - basis @ (basis.T @ vectors)
    shapes, sizes, _ = np.linalg.svd(vectors, full_matrices=False)
    added = shapes[:, sizes > new]
    return np.column_stack([basis, added - basis @ (basis.T @ added)])


@dataclass(frozen=True)
class _Problem:
    """The whole equation of a design at the frequencies looked at, those of the band first."""

    omega: FloatArray  # (omega,) [rad/s]
    stiffness: ComplexArray  # N^T D N (omega, free, free) [N/m]
    loads: ComplexArray  # waves of each order, unit forces of the ports, two of a start (omega, free, load)
    solutions: ComplexArray  # (omega, free, load)
    waves: int  # number of loads by waves
    ports: FloatArray  # N^T b (free, port)
    root: FloatArray  # R of the energy R^T R (free, free), upper triangular

    @classmethod
    def of(cls, system: LinearSystem, motions: FloatArray, ports: FloatArray, start: FloatArray | None) -> "_Problem":
        """Return the equation of a design."""
        first, last = system.database.omega.values[[0, -1]]
        omega, steady = np.linspace(first, last, _IN_BAND), [*(along := motions.T @ ports).T]
        if start is not None:
            inertia, moved = system.mass + system.added_mass_inf, motions @ start
            own = np.sqrt(max(float(moved @ system.stiffness @ moved), 0.0) / float(moved @ inertia @ moved))
            omega = np.append(omega, np.geomspace(last, max(BEYOND * last, OF_START * own), FURTHER + 1)[1:])
            steady += [motions.T @ inertia @ moved, motions.T @ system.stiffness @ moved]
        equation = system.extended_equation(omega)
        stiffness = np.concatenate([stiffness for _, stiffness in equation.blocks(motions)])
        force, groups = system.most_exciting_force(np.minimum(omega, last)), order_groups(system.database).values()
        waves = [force[:, group] @ motions[group] for group in groups]
        loads = np.stack([*waves, *(np.broadcast_to(one, waves[0].shape) for one in steady)], axis=-1)
        energy = system.stiffness + ((first + last) / 2) ** 2 * system.mass
        root = cholesky(motions.T @ energy @ motions)
        return cls(omega, stiffness, loads, np.linalg.solve(stiffness, loads), len(waves), along, root)

    @cached_property
    def _moved(self) -> ComplexArray:
        """Solutions measured by energy, (omega, free, load)."""
        return np.asarray(self.root @ self.solutions)

    @cached_property
    def _sizes(self) -> FloatArray:
        """Size of each solution (omega, load)."""
        return np.asarray(np.linalg.norm(self._moved, axis=1))

    def snapshots(self, k: int) -> FloatArray:
        """Return the parts of the solutions at a frequency, (free, part): in the band of length one, above it less."""
        sizes = self._sizes[k] if k < _IN_BAND else self._sizes.max(axis=0)
        scaled = self._moved[k] / np.where(sizes > 0, sizes, 1.0)
        return np.hstack([scaled.real, scaled.imag])

    def errors(self, reduced: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the largest errors of a power and of a motion in reduced motions (free, motion), each (omega,) [-].

        Above the band there is no power.
        """
        solved = np.linalg.solve(reduced.T @ self.stiffness @ reduced, reduced.T @ self.loads)
        missed = np.linalg.norm(self._moved - (self.root @ reduced) @ solved, axis=1)
        largest = self._sizes.max(axis=0)
        moved = np.divide(missed, largest, out=np.zeros_like(missed), where=largest > 0).max(axis=1)
        band = slice(0, _IN_BAND)
        exact, approximate = self._powers(self.solutions[band]), self._powers(reduced @ solved[band])
        size = np.maximum(exact, FAINT * exact.max(axis=0))
        relative = np.divide(np.abs(approximate - exact), size, out=np.zeros_like(exact), where=size > 0)
        power = np.zeros(len(self.omega))
        power[band] = relative.reshape(len(relative), -1).max(axis=1)
        return power, moved

    def _powers(self, solutions: ComplexArray) -> FloatArray:
        """Powers at the optimal dampers in the band, (omega, order, port) [W/m^2]; 0 of a port that does not move."""
        count, rate = self.ports.shape[1], -1j * self.omega[: len(solutions), None, None]
        velocity = rate * (self.ports.T @ solutions).swapaxes(1, 2)  # (omega, load, port)
        waves, forced = velocity[:, : self.waves], velocity[:, self.waves : self.waves + count]
        admittance = np.einsum("wii->wi", forced)[:, None]
        yielding = np.broadcast_to(4 * (np.abs(admittance) + admittance.real), waves.shape)
        return np.asarray(np.divide(np.abs(waves) ** 2, yielding, out=np.zeros(waves.shape), where=yielding > 0))
