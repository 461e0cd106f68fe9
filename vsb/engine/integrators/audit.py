"""Energy audit of a run: losses and work of waves, integrated along the flow between recorded instants.

Between two instants the scene is z' = A z + B g(t), with every spring, damper and memory state in A and the other
forces in g, a polynomial through the nearest records. Powers are quadratic in (z, g), and their integrals over a step

    int w^T Q w dt = w_0^T S w_0,   S = int exp(A^T s) Q exp(A s) ds,

are known however fast a transient dies out or a mode rings. Each step starts from its own record: what the records
gain in energy is compared with work they were not made from.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import factorial
from typing import NamedTuple

import numpy as np

from vsb.engine.integrators.exact import series
from vsb.engine.motion.system import EXCITING, Motion, System
from vsb.tools.arrays import FloatArray

TERMS = ("wave", "pto", "radiated", "structural", "stored")
"""Of every run; see `terms`."""
RECORDS = 6  # that make a polynomial, two before the step
GAUSS = 6
ROUND_OFF = 1e-13  # of the largest force: directions below it are none
BLOCK = 512  # steps at a time: they stay in the cache


def step_integrals(generator: FloatArray, forms: FloatArray) -> FloatArray:
    """Return S = int_0^1 exp(X^T s) Q exp(X s) ds of quadratic forms Q, (form, state, state), X in units of a step.

    Gauss' rule on a step so short that |X h| <= 1/2, then S(2h) = S(h) + E^T S(h) E with E = exp(X h). Nothing grows
    that does not grow in the scene, unlike Van Loan's block exponential, and E - I is what is doubled,
    2 (E - I) + (E - I)^2: slow motion beside a stiff mode keeps its digits.
    """
    terms, doublings = series(generator)
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
    flows = np.tensordot(np.vander((nodes + 1) / 2, len(terms), increasing=True), np.array(terms), 1)
    start = np.array([sum(w * _through(form, e) for w, e in zip(weights, flows, strict=True)) for form in forms])
    out = 0.5**doublings / 2 * start
    change = np.sum(terms[:0:-1], axis=0)
    for _ in range(doublings):
        end = np.eye(len(generator)) + change
        out = out + end.T @ out @ end
        change = 2 * change + change @ change
    return out


def _through(form: FloatArray, flow: FloatArray) -> FloatArray:
    """E^T Q E by the rows and columns of Q that are not zero."""
    rows, columns = form.any(axis=1), form.any(axis=0)
    return np.asarray(flow[rows].T @ (form[np.ix_(rows, columns)] @ flow[columns]))


Factor = tuple[FloatArray, FloatArray]
"""A quadratic form sum_i s_i (R w)_i^2: s (rank,) and R (rank, state)."""


@dataclass(frozen=True)
class Flow:
    """Motion inside the steps of a run: records, what drives them, and the integrals of powers over a step."""

    dt: float  # [s]
    matrix: FloatArray  # A (state, state) [1/s]
    states: FloatArray  # z at the records (time, state)
    driven: FloatArray  # g at the records and two beyond either end, times dt (time + 4, free)

    def integrals(self, losses: FloatArray, directions: FloatArray) -> tuple[list[Factor], FloatArray]:
        """Return factors of the losses over a step, and the moments of the velocity against the records of a force.

        They act on w = (z, derivatives of g along orthonormal directions (free, direction) of all forces), of w' = X w,
        the moments of shape (direction records, state + direction records).
        """
        (n, few), order = directions.shape, self.states.shape[1]
        x = np.zeros((order + few * RECORDS, order + few * RECORDS))
        x[:order, :order] = self.dt * self.matrix
        x[order:, order:] = np.kron(np.eye(few), np.eye(RECORDS, k=1))
        x[n : 2 * n, order::RECORDS] = directions
        forms = np.zeros((len(losses) + 1, *x.shape))
        forms[:-1, :order, :order] = self.dt * losses
        forms[-1, order::RECORDS, n : 2 * n] = directions.T
        to_derivatives = np.eye(len(x))
        to_derivatives[order:, order:] = np.kron(np.eye(few), DERIVATIVES)
        over_step = to_derivatives.T @ step_integrals(x, forms) @ to_derivatives
        return [_factor(form) for form in over_step[:-1]], over_step[-1, order:]

    def steps(self, force: FloatArray, start: int) -> FloatArray:
        """Return the records about each step of a block, shape (step, direction records)."""
        windows = np.lib.stride_tricks.sliding_window_view(force, RECORDS, axis=0)
        stop = min(start + BLOCK, len(self.states) - 1)
        return windows[start:stop].reshape(stop - start, -1)

    def works(self, losses: FloatArray, acting: list[FloatArray]) -> FloatArray:
        """Return losses and the work of acting forces since the start, shape (loss + acting, time) [J].

        Losses are forms of power, (loss, state, state) [1/s] of the states the run has; acting forces on the modes,
        (time, free).
        """
        forces = [_extended(self.dt * force) for force in acting]
        _, sizes, vectors = np.linalg.svd(np.concatenate([self.driven, *forces]), full_matrices=False)
        directions = vectors[sizes > ROUND_OFF * sizes[0]].T  # regular waves have two
        driven, forces = self.driven @ directions, [np.asarray(force @ directions) for force in forces]
        factors, moments = self.integrals(losses, directions)
        rows = np.vstack([*(factor for _, factor in factors), moments])
        ends = np.cumsum([len(signs) for signs, _ in factors])
        out = np.zeros((len(factors) + len(forces), len(self.states)))
        for start in range(0, len(self.states) - 1, BLOCK):
            records = self.steps(driven, start)
            here = slice(start + 1, start + 1 + len(records))
            *lost, velocity = np.split(rows @ np.vstack([self.states[start : here.stop - 1].T, records.T]), ends)
            for i, (part, (signs, _)) in enumerate(zip(lost, factors, strict=True)):
                out[i, here] = signs @ part**2
            for i, applied in enumerate(forces, len(factors)):
                out[i, here] = np.einsum("it,ti->t", velocity, self.steps(applied, start))
        return np.asarray(np.cumsum(out, axis=1))


def _factor(form: FloatArray) -> Factor:
    """Signs s and rows R of a symmetric form, sum_i s_i (R w)_i^2, without what is round-off."""
    values, vectors = np.linalg.eigh(0.5 * (form + form.T))
    kept = np.abs(values) > 1e-14 * np.abs(values).max()
    return np.sign(values[kept]), (vectors[:, kept] * np.sqrt(np.abs(values[kept]))).T


_NODES = np.arange(RECORDS) - 2.0
DERIVATIVES = np.array([[factorial(k)] for k in range(RECORDS)]) * np.linalg.inv(np.vander(_NODES, increasing=True))
"""Derivatives 0..5 at the start of a step of the polynomial through its records, in units of the step."""


def _extended(force: FloatArray) -> FloatArray:
    """Two more records at either end, on the polynomial through the outermost ones."""
    count = min(RECORDS, len(force))
    nodes = np.vander(np.arange(count), increasing=True)
    beyond = np.vander([-2.0, -1.0], count, increasing=True) @ np.linalg.inv(nodes)
    return np.concatenate([beyond @ force[:count], force, (beyond @ force[: -count - 1 : -1])[::-1]])


def flow(system: System, motion: Motion, driving: FloatArray) -> Flow:
    """Return the motion of a run between its records, under `System.driving` (time, free)."""
    states, dt = system.states(motion), float(motion.time[1] - motion.time[0])
    known = states.shape[1]
    return Flow(dt, system.matrix[:known, :known], states, _extended(dt * driving))


def energies(system: System, motion: Motion, named: Mapping[str, FloatArray] | None = None) -> dict[str, FloatArray]:
    """Return the energy of each term since the start, each shape (time,) [J]: wave = the sum of the others.

    Losses and the waves' work are integrated along the flow between records (`Flow`), what is stored is read from the
    records. `named` are `System.forces` of the motion, where they are known.
    `turned` is no term of the sum: kinetic energy, and a billionth of the energy stored, below which all is round-off.
    With the state space, radiated power is |L^T x|^2/2 and the memory stores x.x/2, both from the memory states alone:
    the audit then checks the whole chain. With the convolution the radiation force's work stands for both.
    Where forces jump between records the motion brings its works along. A nonlinear force that is neither the water's
    nor the shell's dissipates what it does not store: the take-off as `pto`, others as a term of their own name.
    """
    stored, kinetic = system.energy(motion)
    held = {"stored": stored - stored[0], "turned": kinetic + 1e-9 * np.abs(stored)}
    if motion.works:
        return {**motion.works, **held}
    named = system.forces(motion) if named is None else named
    none = np.zeros((len(motion.time), system.free))
    acting: list[FloatArray] = [sum((named[name] @ system.shapes for name in EXCITING if name in named), none)]
    first = len(acting)
    if not motion.memory.size:
        acting += [-named[name] @ system.shapes for name in system.scene.memories]
    radiating, uncompiled, q = len(acting) - first, system.dissipating, motion.position @ system.scene.motions.T
    acting += [-named[name] @ system.shapes for name in uncompiled]
    run = flow(system, motion, system.driving(motion, named))
    known = run.states.shape[1]
    pto, structural, radiated, wave, *others = run.works(system.losses()[:, :known, :known], acting)
    energy = {"wave": wave, "pto": pto, "radiated": sum(others[:radiating], radiated), "structural": structural}
    for name, taken in zip(uncompiled, others[radiating:], strict=True):
        kept = system.scene.forces[name].potential_energy(q)
        term = "pto" if name == system.scene.take_off else name
        energy[term] = energy.get(term, 0.0) + taken - (kept - kept[0])
    return {**energy, **held}


def absorbed_power(system: System, motion: Motion, named: Mapping[str, FloatArray]) -> FloatArray:
    """Return the power the take-off absorbs along a motion, shape (time,) [W]; `energies` has its integral as `pto`.

    What a spring, or the gas of a chamber, stores and gives back is not absorbed (C7). `named` are `System.forces`.
    """
    scene, name = system.scene, system.scene.take_off
    if name not in scene.forces:
        return np.zeros(len(motion.time))
    if (memory := scene.memories.get(name)) is not None:
        states = motion.memory[:, scene.remembered[name]]
        return np.asarray(np.einsum("ti,ti->t", states @ memory.radiated, states))
    q, v = motion.position @ scene.motions.T, motion.velocity @ scene.motions.T
    return scene.forces[name].absorbed_power(q, v, named[name])


def terms(energy: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Return the terms of an audit, the waves' work first, what is stored last: `TERMS` and forces of their own."""
    others = [term for term in energy if term not in (*TERMS, "turned")]
    return (*TERMS[:-1], *others, TERMS[-1])


class Balance(NamedTuple):
    """Energy audit of a run so far."""

    ended: Mapping[str, float]  # energy of each term at the end [J]
    unbalanced: float  # the largest so far [J]
    largest: float  # of all terms and of the kinetic energy so far [J]

    def after(self, energy: Mapping[str, FloatArray]) -> "Balance":
        """Return the audit after one more leg; `energy` since the start of the run."""
        unbalanced = energy["wave"] - sum(energy[term] for term in terms(energy)[1:])
        largest = max(float(np.abs(part).max()) for part in energy.values())
        ended = {term: float(energy[term][-1]) for term in terms(energy)}
        return Balance(ended, max(self.unbalanced, float(np.abs(unbalanced).max())), max(self.largest, largest))

    @property
    def residual(self) -> float:
        """`residual` of the run so far."""
        return self.unbalanced / self.largest if self.largest else 0.0


START = Balance(dict.fromkeys(TERMS, 0.0), 0.0, 0.0)


def residual(energy: Mapping[str, FloatArray]) -> float:
    """Return the largest unbalanced energy relative to the energy that went round [-].

    |wave - pto - radiated - structural - stored| over the largest of the terms and of the kinetic energy: in free
    motion without losses every term is zero but for errors.
    """
    return START.after(energy).residual
