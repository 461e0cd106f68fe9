"""Bodies of many radiation channels against today's routes, in one run: error, seconds and their ratio.

Coefficients of a floating sphere, heave and three shapes of its shell, an irregular frequency among those solved: the
general route, capytaine's panels with a lid, against the spectral solver. Motions in waves: the passive state space
followed exactly, against the convolution with a retardation kernel that ends after some seconds, followed in steps, as
WEC-Sim does; of an oscillator of known poles, of a barge with its bending modes, and of two of them side by side. The
true motion is that of the frequency domain, which knows neither memory nor steps. Seconds are of one processor at work;
a ratio is what another method takes at an error that is no smaller, over the seconds of ours.
"""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import xarray as xr

from benchmarks.measure import Row, as_csv, timed
from benchmarks.time_cases import ModelKernel
from examples.barge import Barge, box, free_free_shape
from vsb.hydro.bodies.body import FlexibleBody, at_centres, joined
from vsb.hydro.bodies.study import solved
from vsb.hydro.database import stored_checks
from vsb.hydro.dofs import Displacement
from vsb.hydro.panels.mesh import graded_colatitudes, polygon_radius, revolved
from vsb.hydro.passive import PassiveFit, RadiationSamples, fit_passive, sizes
from vsb.hydro.passivity import least_damping
from vsb.hydro.realisation import StateSpace
from vsb.hydro.repairs import with_causal_added_mass, with_passive_damping
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.exact import propagate
from vsb.motion.forces import Damper, Excitation, Force, RadiationMemory, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.shell.deformed import rigid_sphere
from vsb.study.body_file import BodyFile
from vsb.study.quantities import RIGID
from vsb.study.sections import Water
from vsb.tools.files import write_text
from vsb.tools.units import ComplexArray, FloatArray

COLUMNS = (
    "case", "motions", "method", "setting", "order", "error", "estimate", "least_damping", "bound", "set_up", "seconds",
    "times_slower",
)  # fmt: skip
KA = (0.2, 0.5, 1.0, 1.5, 2.557)
"""Where errors are taken; the last is an irregular frequency of the sphere."""
DEGREES = (1, 0, 2, 3)
"""Of the radial shapes of the sphere."""
ROWS, NODES, REFERENCE_NODES = (4, 8, 12), (6, 8, 12, 16), 48
BAND = tuple(round(0.05 * i, 2) for i in range(2, 51))
"""Frequencies solved of barges [rad/s], irregular ones among them."""
BARGE = Barge(length=20.0, beam=8.0, draught=4.0, bending_stiffness=1.0, modes=4)
TOLERANCES = (2e-2, 1e-2)
STEPS, WINDOWS = (0.1, 0.05, 0.02), (20.0, 60.0)
"""Of the convolution [s]."""
DURATION, JUDGED = 240.0, 60.0
"""Of the motion, and of its end, where only the steady state is left [s]."""
LOSS, FREQUENCIES = 0.15, (0.4, 2.0)
"""Damping in terms of inertia [1/s], and where springs put the motions [rad/s]."""


def barges(count: int, modes: int, gap: float, panels: int) -> FlexibleBody:
    """Return barges side by side, each with six rigid motions about its middle and so many bending modes."""
    vertices, faces = box(BARGE.length, BARGE.beam, BARGE.draught, panels)
    own = _motions(vertices, modes)
    places = (np.arange(count) - (count - 1) / 2) * (BARGE.beam + gap)
    whole, quads = joined([(vertices + np.array([0.0, y, 0.0]), faces) for y in places])
    shapes = np.zeros((count, len(own), count, len(vertices), 3))
    shapes[range(count), :, range(count)] = own
    names = [*RIGID, *(f"Bending{n}" for n in range(1, modes + 1))]
    labels = names if count == 1 else [f"barge{i}__{name}" for i in range(1, count + 1) for name in names]
    moved = shapes.reshape(len(labels), -1, 3)
    middles = np.column_stack([0 * places, places, 0 * places])
    return FlexibleBody(whole, quads, tuple(labels), at_centres(whole, quads, moved), moved, centre_of_mass=middles)


def _motions(points: FloatArray, modes: int) -> FloatArray:
    """Displacements of a barge at the origin, shape (motion, point, xyz)."""
    rigid = [*(np.tile(axis, (len(points), 1)) for axis in np.eye(3)), *(np.cross(axis, points) for axis in np.eye(3))]
    bending = [free_free_shape(n, 2 * points[:, 0] / BARGE.length) for n in range(1, modes + 1)]
    lines = [np.column_stack([-points[:, 2] * 2 / BARGE.length * dw, 0 * w, w]) for w, dw in bending]
    return np.array([*rigid, *lines])


def hemisphere(rows: int) -> FlexibleBody:
    """Return the wetted unit sphere of so many rows of panels, four times as many around, and its radial shapes."""
    phi, azimuth = graded_colatitudes(np.pi / 2, rows), 4 * rows
    x, z = np.append(np.sin(phi[:-1]), 0.0), np.append(0.0, np.cos(phi[1:]))
    vertices, corners = revolved(polygon_radius(azimuth) * x, z, azimuth)
    faces = corners.astype(int)
    theta = np.tile(2 * np.pi * np.arange(azimuth) / azimuth, rows + 1)
    p = np.repeat(phi, azimuth)
    outward = np.column_stack([np.sin(p) * np.cos(theta), np.sin(p) * np.sin(theta), np.cos(p)])
    shapes = np.array([np.polynomial.Legendre.basis(n)(np.cos(p))[:, None] * outward for n in DEGREES])
    labels = tuple(f"Radial{n}" for n in DEGREES)
    return FlexibleBody(vertices, faces, labels, at_centres(vertices, faces, shapes), shapes)


# coefficients -------------------------------------------------------------------------------------------------------


def by_panels(rows: int, green: Path) -> xr.Dataset:
    """Return coefficients by the general route: panels, a lid, half the rows for the estimate."""
    with tempfile.TemporaryDirectory() as folder:
        omega = tuple(float(w) for w in np.sqrt(KA))
        file = BodyFile(body="sphere", mesh="-", modes="-", water=_UNIT, omega=omega, lid=rows)
        return solved(file, hemisphere(rows), folder, green)[0]


_UNIT = Water(density=1.0, gravity=1.0)


def by_spectral(nodes: int) -> xr.Dataset:
    """Return coefficients by the axisymmetric chain's solver."""
    moved = tuple(Displacement("radial", n) for n in DEGREES)
    return SpectralProblem(rigid_sphere(1.0, 0.0), moved, 1.0, 1.0, nodes).solve([float(w) for w in np.sqrt(KA)])


def coefficient_error(found: xr.Dataset, true: xr.Dataset) -> float:
    """Return the largest error of added mass, damping or excitation, relative to the largest entry of the band [-]."""
    pairs = [
        (found.added_mass.values, true.added_mass.values),
        (found.radiation_damping.values, true.radiation_damping.values),
        (_excitation(found), _excitation(true)),
    ]
    return max(float(np.abs(one - other).max() / np.abs(other).max()) for one, other in pairs)


def _excitation(ds: xr.Dataset) -> ComplexArray:
    """Force of the undisturbed and the scattered wave, shape (omega, dof)."""
    force = ds.Froude_Krylov_force + ds.diffraction_force
    return np.asarray(force.transpose("omega", ..., "influenced_dof")).reshape(len(KA), -1)


def coefficient_rows(green: Path) -> list[Row]:
    """Return error, estimate and seconds per frequency of panels and of the spectral solver, on the sphere."""
    true, rows = by_spectral(REFERENCE_NODES), []
    by_panels(ROWS[0], green)  # reads or makes the table, loads libraries
    for method, settings, solve in (
        ("spectral", NODES, by_spectral),
        ("panels and lid", ROWS, partial(by_panels, green=green)),
    ):
        for setting in settings:
            seconds, found = timed(partial(solve, setting))
            estimate = {c.name: c.value for c in stored_checks(found)} if "quality" in found.attrs else {}
            row = {"case": "sphere", "motions": len(DEGREES), "method": method, "setting": setting}
            row |= {"error": coefficient_error(found, true), "seconds": seconds / len(KA)}
            rows.append(row | {"estimate": estimate.get("error_estimate")})
    return with_ratios(rows, "spectral")


# motions ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Floating:
    """Motions of many radiation channels in waves of some of the frequencies sampled, each on a spring and a damper."""

    samples: RadiationSamples
    spectrum: DampingSpectrum  # whose kernel the convolution takes
    force: ComplexArray  # at the frequencies sampled (omega, dof) [N]

    @cached_property
    def chosen(self) -> slice:
        """Frequencies of the waves: every second of the middle half of those sampled."""
        count = len(self.samples.omega)
        return slice(count // 4, 3 * count // 4, 2)

    @cached_property
    def mass(self) -> FloatArray:
        """Of the dry bodies, as much as the water's, without couplings (dof, dof) [kg]."""
        return np.diag(np.diag(self.samples.added_mass_inf))

    @cached_property
    def springs(self) -> FloatArray:
        """Stiffness that puts the motions at frequencies of their own (dof, dof) [N/m]."""
        own = np.linspace(*FREQUENCIES, len(self.samples.size))
        return np.diag(own**2 * 2 * np.diag(self.mass))

    @cached_property
    def phasors(self) -> ComplexArray:
        """True motion by the frequency domain, shape (component, dof) [m]."""
        s, here = self.samples, self.chosen
        omega = s.omega[here, None, None]
        inertia, damping = self.mass + s.added_mass[here], LOSS * 2 * self.mass + s.damping[here]
        impedance = -(omega**2) * inertia - 1j * omega * damping + self.springs
        return np.asarray(np.linalg.solve(impedance, self.force[here, :, None])[..., 0])

    def scene(self, memory: RadiationModel | None, added_mass_inf: FloatArray) -> Scene:
        """Return the linear scene with a memory, or without one."""
        forces: dict[str, Force] = {"springs": Spring(self.springs), "losses": Damper(LOSS * 2 * self.mass)}
        forces["excitation"] = Excitation(self.samples.omega[self.chosen], self.force[self.chosen])
        if memory:
            forces["radiation"] = RadiationMemory(memory)
        labels = tuple(f"Motion{i}" for i in range(len(self.samples.size)))
        return Scene(labels, self.mass + added_mass_inf, forces, np.eye(len(labels)))

    def error(self, when: FloatArray, position: FloatArray) -> float:
        """Return the rms of what is missed at the end, motions weighed by their inertia, over that of the motion."""
        last = when >= when[-1] - JUDGED
        turn = np.exp(-1j * np.outer(when[last], self.samples.omega[self.chosen]))
        true, weight = np.real(turn @ self.phasors), np.diag(self.mass)
        return float(np.sqrt(((position[last] - true) ** 2 @ weight).sum() / (true**2 @ weight).sum()))


def convolved(floating: Floating, step: float, window: float) -> tuple[FloatArray, FloatArray]:
    """Return instants and positions with the memory as a convolution, shape (time,) and (time, dof).

    Average acceleration, the integral over the past by the trapezoidal rule, all as one matrix times the velocities of
    the window; what is older has no weight.
    """
    system = System.of(floating.scene(None, floating.samples.added_mass_inf))
    when = np.arange(round(DURATION / step) + 1) * step
    length, n = round(window / step), system.free
    kernel = system.shapes.T @ floating.spectrum.kernel(when[: length + 1]) @ system.shapes
    kernel[-1] /= 2  # of the trapezoidal rule
    past = np.ascontiguousarray(kernel[:0:-1].transpose(1, 0, 2).reshape(n, -1)) * step
    damping = -system.matrix[n : 2 * n, n : 2 * n] + step / 2 * kernel[0]
    stiffness = -system.matrix[n : 2 * n, :n] * system.scale
    inverse = np.linalg.inv(np.eye(n) + step / 2 * damping + step**2 / 4 * stiffness)
    push = system.push(when)
    p, v, a = np.zeros((len(when), n)), np.zeros((len(when) + length, n)), push[0]
    for i in range(1, len(when)):
        here = length + i  # rows of v before the start are zero: the water is at rest
        guess_p, guess_v = p[i - 1] + step * v[here - 1] + step**2 / 4 * a, v[here - 1] + step / 2 * a
        remembered = past @ v[here - length : here].ravel()
        a = inverse @ (push[i] - remembered - damping @ guess_v - stiffness @ guess_p)
        v[here], p[i] = guess_v + step / 2 * a, guess_p + step**2 / 4 * a
    return when, p @ system.modes.T


def followed(floating: Floating, fit: PassiveFit, step: float) -> tuple[FloatArray, FloatArray]:
    """Return instants and positions with the passive memory, exactly."""
    system = System.of(floating.scene(fit.model, fit.added_mass_inf))
    when = np.arange(round(DURATION / step) + 1) * step
    n = system.free
    return when, propagate(system, when, (np.zeros(n), np.zeros(n))).position


def motion_rows(case: str, floating: Floating) -> list[Row]:
    """Return error and seconds of the passive memory, with its proof, and of convolutions."""
    rows: list[Row] = []
    common = {"case": case, "motions": len(floating.samples.size)}
    for tolerance in TOLERANCES:
        set_up, fit = timed(partial(fit_passive, floating.samples, tolerance, limit="fitted"))
        seconds, found = timed(partial(followed, floating, fit, STEPS[0]))
        g = fit.model.input_matrix / floating.samples.size
        proof = least_damping(StateSpace(fit.model.state_matrix, g, g.T))
        row = {**common, "method": "passive", "setting": f"tolerance {tolerance:g}", "order": fit.model.order}
        row |= {"error": floating.error(*found), "estimate": fit.error, "set_up": set_up, "seconds": seconds}
        rows.append(row | {"least_damping": proof.value, "bound": proof.bound})
    for window in WINDOWS:
        for step in STEPS:
            seconds, found = timed(partial(convolved, floating, step, window))
            row = {**common, "method": "convolution", "setting": f"{window:g} s in steps of {step:g} s"}
            rows.append(row | {"error": floating.error(*found), "seconds": seconds})
    return with_ratios(rows, "passive")


# cases --------------------------------------------------------------------------------------------------------------


_FADING = 0.5  # channel of every state by itself: memory falls at least as exp(-t/8)


def known_poles(dof: int = 10, states: int = 12, channels: int = 4) -> Floating:
    """Return motions of a passive memory whose poles are known: coupled oscillators, driven, seen and damped."""
    rng, half = np.random.default_rng(1), states // 2
    rate = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.diag(rng.uniform(0.4, 2.0, half)))
    g, driven = rng.normal(size=(2, half, max(dof, channels)))
    channel = np.hstack([np.vstack([0 * driven, driven])[:, :channels], _FADING * np.eye(states)])
    model = RadiationModel(rate - channel @ channel.T / 2, np.vstack([0 * g, g])[:, :dof], channel)
    omega = np.arange(1, 81) * 0.05
    k, inertia = model.transfer(omega), 20.0 * np.eye(dof)
    size = sizes(omega, k.real, np.diag(inertia))
    samples = RadiationSamples(omega, inertia + k.imag / omega[:, None, None], k.real, inertia, size)
    force = np.exp(2j * np.pi * rng.random((len(omega), dof)))
    return Floating(samples, ModelKernel(omega, k.real, model), force)


def barge_case(count: int, modes: int, gap: float, green: Path, panels: int = 2) -> Floating:
    """Return barges solved by the general route in waves from 45 degrees, their phases drawn."""
    body = barges(count, modes, gap, panels)
    file = BodyFile(body="barges", mesh="-", modes="-", omega=BAND, lid=2, wave_direction=(45.0,))
    with tempfile.TemporaryDirectory() as folder:
        ds = with_causal_added_mass(with_passive_damping(solved(file, body, folder, green)[0]))
    omega, damping, limit = ds.omega.values, ds.radiation_damping.values, ds.added_mass_inf.values
    samples = RadiationSamples(omega, ds.added_mass.values, damping, limit, sizes(omega, damping, np.diag(limit)))
    phase = np.exp(2j * np.pi * np.random.default_rng(1).random(len(omega)))
    return Floating(samples, DampingSpectrum(omega, damping), phase[:, None] * ds.excitation_force.values[:, 0])


CASES: dict[str, Callable[[Path], Floating]] = {
    "known poles": lambda green: known_poles(),
    "barge that bends": partial(barge_case, 1, 4, 0.0),
    "two barges that bend": partial(barge_case, 2, 1, 10.0),
}


def with_ratios(rows: Sequence[Row], ours: str) -> list[Row]:
    """Return rows with how many times slower they are than our fastest of an error that is no larger."""

    def ratio(row: Row) -> float | None:
        as_good = [r["seconds"] for r in rows if r["method"] == ours and r["error"] <= row["error"]]
        return row["seconds"] / max(min(as_good), 1e-9) if as_good else None

    return [row | {"times_slower": ratio(row) if row["method"] != ours else None} for row in rows]


def benchmark(folder: str | Path) -> list[Row]:
    """Write bodies.csv into a folder and return its rows."""
    green = Path(folder, "green")
    rows = [*coefficient_rows(green), *(row for name, made in CASES.items() for row in motion_rows(name, made(green)))]
    write_text(Path(folder, "bodies.csv"), as_csv(rows, COLUMNS))
    return rows
