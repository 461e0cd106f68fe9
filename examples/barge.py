"""A flexible barge by the general route: free-free bending modes, graded panels, and how the results converge.

The barge is a uniform Euler-Bernoulli beam afloat at rest, mass = rho V, without rotary inertia. Its sections stay
plane and turn about the axis through the centre of mass: displacement (-(z - z_G) W'(x), 0, W(x)). Heave is W = 1,
pitch is W = -x (a rotation about y, bow down), bending modes have W = 1 at the bow. A hinge amidships adds
W = 2|s| - 1, s = 2x/L: straight halves, ends up by 1 m when the middle goes down by 1 m, without momentum as they are.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator
from pydantic import Field, model_validator
from scipy.optimize import minimize_scalar

from examples import command
from vsb.cli import print_verdict
from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import write_body
from vsb.engine.hydro.bodies.families import free_free_root, free_free_shape
from vsb.engine.hydro.bodies.mesh import at_centres, joined
from vsb.engine.hydro.bodies.solution import read_config, run, solve
from vsb.engine.hydro.database import Check, stored_checks
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.keys.quantities import Count, Finite, NonNegative, Number, Positive, Section, canonical
from vsb.keys.reading import validated
from vsb.report.canvas import grid_of_axes, legend_above, style, svg_text
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.files import load, write_text
from vsb.tools.words import csv_text

GRADING = 0.5
"""Between equal panels (0) and cosine spacing (1), whose panels at the edges shrink with the square of the number."""
Few = Annotated[Count, Field(ge=1, le=40)]


class Barge(Section):
    """Box afloat: length along x, beam, draught [m], height of the centre of mass above still water [m].

    `bending_stiffness` is EI [N m^2], `modes` the number of bending modes, `hinge_stiffness` that of a hinge amidships,
    if there is one [N m/rad].
    """

    length: Positive
    beam: Positive
    draught: Positive
    centre_of_mass: Finite = 0.0
    bending_stiffness: Positive
    modes: Few = 4
    hinge_stiffness: NonNegative | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Heave, Pitch, Bending1, ..., and Hinge if it has one."""
        bending = (f"Bending{n}" for n in range(1, self.modes + 1))
        return ("Heave", "Pitch", *bending, *["Hinge"] * self.hinged)

    @property
    def hinged(self) -> bool:
        """Whether it has a hinge."""
        return self.hinge_stiffness is not None

    def displacement(self, points: FloatArray) -> FloatArray:
        """Return the displacements of points, shape (point, xyz) -> (dof, point, xyz) [-]."""
        x, z = points[:, 0], points[:, 2] - self.centre_of_mass
        s = 2 * x / self.length
        bending = [free_free_shape(n, s) for n in range(1, self.modes + 1)]
        bending += [(2 * np.abs(s) - 1, 2 * np.sign(s))] * self.hinged
        lines = [(np.ones_like(x), 0 * x), (-x, -np.ones_like(x)), *((w, 2 / self.length * dw) for w, dw in bending)]
        return np.array([np.column_stack([-z * slope, 0 * x, w]) for w, slope in lines])

    def mass(self, density: float) -> FloatArray:
        """Return the modal mass matrix, shape (dof, dof) [kg]; a free beam's mode has a quarter of its mass.

        Notes
        -----
        Of the hinge a third. With an even mode W it shares int_0^1 2 s W ds = 2 W''(0)/k^4 of the mass, as W is its own
        fourth derivative over k^4; with odd ones nothing.
        """
        total = density * self.length * self.beam * self.draught
        mass = np.diag([1.0, self.length**2 / 12, *[1 / 4] * self.modes, *[1 / 3] * self.hinged])
        for n in range(1, self.modes + 1, 2) if self.hinged else ():
            k = free_free_root(n)
            mass[-1, n + 1] = mass[n + 1, -1] = (1 / np.cosh(k) - 1 / np.cos(k)) / k**2
        return np.asarray(total * mass)

    @property
    def stiffness(self) -> FloatArray:
        """Modal stiffness matrix, EI (2 k_n/L)^4 L/4, and the hinge's by the angle 8/L between its halves [N/m]."""
        roots = np.array([free_free_root(n) for n in range(1, self.modes + 1)])
        bending = self.bending_stiffness * (2 * roots / self.length) ** 4 * self.length / 4
        hinge = [] if self.hinge_stiffness is None else [self.hinge_stiffness * (8 / self.length) ** 2]
        return np.diag([0.0, 0.0, *bending, *hinge])

    def body(self, panels: int, density: float) -> FlexibleBody:
        """Return the barge at rest with its panels, see `box`, and its modal matrices."""
        vertices, faces = box(self.length, self.beam, self.draught, panels)
        shapes = self.displacement(vertices)
        return FlexibleBody(
            vertices,
            faces,
            self.labels,
            at_centres(vertices, faces, shapes),
            shapes,
            self.mass(density),
            self.stiffness,
            np.array([0.0, 0.0, self.centre_of_mass]),
        )


def graded(length: float, count: int) -> FloatArray:
    """Return count + 1 points from 0 to length, crowded to both ends by `GRADING`."""
    s = np.linspace(0.0, 1.0, count + 1)
    return length * ((1 - GRADING) * s + GRADING * (1 - np.cos(np.pi * s)) / 2)


def box(length: float, beam: float, draught: float, panels: int) -> tuple[FloatArray, IntArray]:
    """Return vertices and panels of the wetted sides of a box, mirrored in both vertical planes, normals outwards.

    `panels` over the draught, `2 panels` over the beam and `8 panels` over the length; all crowd to the edges.
    """
    x = graded(length, 8 * panels) - length / 2
    y = graded(beam, 2 * panels) - beam / 2
    z = graded(draught, panels) - draught
    parts = [_patch(0, 1, 2, x, y, -draught, flip=True)]
    for side in (-1, 1):
        parts.append(_patch(0, 2, 1, x, z, side * beam / 2, flip=side > 0))
        parts.append(_patch(1, 2, 0, y, z, side * length / 2, flip=side < 0))
    return joined(parts)


def _patch(
    first: int, second: int, normal: int, a: FloatArray, b: FloatArray, at: float, *, flip: bool
) -> tuple[FloatArray, IntArray]:
    """A rectangle of panels in two coordinates, the third constant."""
    vertices = np.empty((len(a), len(b), 3))
    vertices[..., first], vertices[..., second], vertices[..., normal] = a[:, None], b[None, :], at
    index = np.arange(len(a) * len(b)).reshape(len(a), len(b))
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    faces = np.stack(corners[::-1] if flip else corners, axis=-1).reshape(-1, 4)
    return vertices.reshape(-1, 3), faces


class Convergence(Section):
    """Meshes to compare, by panels over the draught, and the frequency they are compared at [rad/s]."""

    panels: Annotated[tuple[Few, ...], Field(min_length=4)]
    omega: Positive


class BargeStudy(Section):
    """A barge in waves: frequencies [rad/s], directions [degrees], panels over the draught, and what to compare.

    `tolerance` [-] of interpolation between the frequencies solved, as of `vsb.engine.hydro.bodies.body_file.BodyFile`.
    """

    barge: Barge
    water: Water = Water()
    omega: tuple[Positive, ...]
    wave_direction: tuple[Finite, ...] = (0.0,)
    panels: Few
    convergence: Convergence
    tolerance: Annotated[Number, Field(ge=1e-5, le=0.1)] | None = None

    @model_validator(mode="after")
    def _floats_above_the_ground(self) -> "BargeStudy":
        if not self.omega or list(self.omega) != sorted(set(self.omega)):
            raise ValueError(f"omega {list(self.omega)}: needs at least one value, ascending without repetition")
        if not self.water.depth > self.barge.draught:
            raise ValueError(f"water.depth {self.water.depth:g} m: needs more than the draught")
        return self

    def body_study(self, name: str, omega: tuple[float, ...]) -> BodyFile:
        """Body file of a mesh of this barge; below the first irregular frequency no lid is needed."""
        kept = {key: getattr(self, key) for key in ("water", "wave_direction", "tolerance")}
        file = {"body": name, "mesh": "body.nc", "modes": "body.nc", "omega": omega, "lid": 0, **kept}
        return validated(BodyFile, file, name)


def study(config: str | Path, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Write a barge as files of mesh, modes and body, solve those, and compare meshes; return the verdict.

    `out` gets body.nc, body.yaml, the database barge.nc, convergence.csv and barge.svg.
    """
    chosen = read_config(config, BargeStudy)
    density = chosen.water.density
    if chosen.omega[-1] >= (first := first_irregular_frequency(chosen.barge, chosen.water.gravity)):
        raise ConfigError(f"{config}: omega: received {chosen.omega[-1]:g} rad/s, needs less than {first:.4g} rad/s")
    folder = Path(out)
    table = Path(tables) if tables else folder / "green"
    for omega in (chosen.omega, (chosen.convergence.omega,)):
        chosen.body_study("barge", omega)  # before anything is written
    write_body(chosen.barge.body(chosen.panels, density), folder / "body.nc")
    write_text(folder / "body.yaml", canonical(chosen.body_study("barge", chosen.omega)) + "\n")
    checks = run(folder / "body.yaml", folder, table)
    levels = []
    for panels in chosen.convergence.panels:
        one = chosen.body_study(f"panels_{panels}", (chosen.convergence.omega,))
        solve(one, chosen.barge.body(panels, density), folder / "convergence", table)
        levels.append(load(folder / "convergence" / f"panels_{panels}.nc"))
    rows = convergence(chosen.convergence.panels, levels)
    write_text(folder / "convergence.csv", as_csv(rows))
    write_text(folder / "barge.svg", svg_text(figure(rows, load(folder / "barge.nc"), chosen.barge.length)))
    return checks


def first_irregular_frequency(barge: Barge, gravity: float) -> float:
    """Return the lowest eigenfrequency of water in the box with a lid of zero pressure [rad/s].

    omega^2 = g k coth(kT), k = pi sqrt(1/L^2 + 1/B^2).
    """
    k = np.pi * np.hypot(1 / barge.length, 1 / barge.beam)
    return float(np.sqrt(gravity * k / np.tanh(k * barge.draught)))


def limit_and_order(count: Sequence[float], values: FloatArray) -> tuple[FloatArray, float]:
    """Return limit v and order p of values (level, quantity) that behave as v + a count^-p, by least squares.

    One p for all quantities, which should be of like size.
    """
    n = np.asarray(count, dtype=float)

    def fitted(p: float) -> tuple[FloatArray, float]:
        terms = np.column_stack([np.ones_like(n), n**-p])
        coefficients = np.linalg.lstsq(terms, values, rcond=None)[0]
        return coefficients[0], float(np.sum((terms @ coefficients - values) ** 2))

    best = minimize_scalar(lambda p: fitted(p)[1], bounds=(0.2, 4.0), method="bounded", options={"xatol": 1e-10})
    return fitted(float(best.x))[0], float(best.x)


def scaled_coefficients(levels: Sequence[xr.Dataset]) -> dict[str, FloatArray]:
    """Return coefficients of several meshes at one frequency, (level, quantity), in terms of diagonals of the last."""
    found = {}
    for name in ("added_mass_inf", "added_mass", "radiation_damping"):
        matrices = np.array([ds[name].values.reshape(-1, ds[name].shape[-1], ds[name].shape[-1])[0] for ds in levels])
        root = np.sqrt(np.diag(matrices[-1]))
        found[name] = (matrices / np.outer(root, root)).reshape(len(levels), -1)
    forces = np.array([ds.excitation_force.values[0] for ds in levels])
    scaled = forces / np.abs(forces[-1]).max(axis=0)
    found["excitation_force"] = np.stack([scaled.real, scaled.imag], axis=-1).reshape(len(levels), -1)
    return found


def convergence(panels: Sequence[int], levels: Sequence[xr.Dataset]) -> list[dict[str, Any]]:
    """Return per mesh and quantity the largest distance of any entry from the limit, and the order; and identities."""
    rows = []
    for name, values in scaled_coefficients(levels).items():
        limit, order = limit_and_order(panels, values)
        errors = np.abs(values - limit).max(axis=1)
        rows += [_row(n, name, error, order) for n, error in zip(panels, errors, strict=True)]
    for name in ("error_estimate", "far_field", "haskind", "symmetry"):
        errors = np.array([check.value for ds in levels for check in stored_checks(ds) if check.name == name])
        order = -float(np.polyfit(np.log(panels), np.log(errors), 1)[0])
        rows += [_row(n, name, error, order) for n, error in zip(panels, errors, strict=True)]
    return rows


def _row(panels: int, quantity: str, error: float, order: float) -> dict[str, Any]:
    """One line of the table; `box` has 36 panels^2 faces."""
    return {"panels": panels, "faces": 36 * panels**2, "quantity": quantity, "error": error, "order": order}


def as_csv(rows: Sequence[dict[str, Any]]) -> str:
    """Return the convergence table as text."""
    return csv_text(rows[0], (row.values() for row in rows), 6)


_CURVES = {
    "added_mass_inf": ("A at infinity", "#999999", "-", "v"),
    "added_mass": ("A", "#000000", "-", "o"),
    "radiation_damping": ("B", "#D55E00", "-", "s"),
    "excitation_force": ("X", "#0072B2", "-", "^"),
    "error_estimate": ("estimate of the largest", "#009E73", ":", "D"),
    "far_field": ("B against far field", "#D55E00", "--", "x"),
    "haskind": ("X against Haskind", "#0072B2", "--", "+"),
}


def figure(rows: Sequence[dict[str, Any]], ds: xr.Dataset, length: float) -> Figure:
    """Draw how the coefficients converge, and the excitation of every degree of freedom."""
    drawing, axes = grid_of_axes(3.4, 1, 2)
    _draw_convergence(axes[0, 0], rows)
    labels = [str(label) for label in ds.influenced_dof.values]
    for label in labels:
        lever, name = (length / 2, f"{label} by L/2") if label == "Pitch" else (1.0, label)
        force = np.abs(ds.excitation_force.sel(influenced_dof=label).isel(wave_direction=0)) / lever / 1e6
        axes[0, 1].plot(ds.omega, force, **{**style(label, labels), "label": name})
    axes[0, 1].set(xlabel="frequency [rad/s]", ylabel="excitation, first direction [MN/m]")
    axes[0, 1].legend(fontsize=7)
    legend_above(drawing, axes[0, 0])
    return drawing


def _draw_convergence(ax: Axes, rows: Sequence[dict[str, Any]]) -> None:
    """Errors against the number of panels, with the orders found."""
    for quantity, (name, colour, line, marker) in _CURVES.items():
        mine = [row for row in rows if row["quantity"] == quantity]
        label = f"{name}, order {mine[0]['order']:.1f}"
        look = {"color": colour, "linestyle": line, "marker": marker, "markersize": 4}
        ax.loglog([row["faces"] for row in mine], [row["error"] for row in mine], label=label, **look)
    faces = sorted({row["faces"] for row in rows})
    ax.xaxis.set(major_locator=FixedLocator(faces), minor_locator=NullLocator())
    ax.xaxis.set_major_formatter(FixedFormatter([str(n) for n in faces]))
    ax.set(xlabel="panels", ylabel="error")


def _solved(args: argparse.Namespace) -> int:
    """Solve a barge; 1 if a check fails."""
    return print_verdict(study(args.config, args.out), f"{args.out}/barge.nc {args.out}/barge.svg")


main = command("barge", study.__doc__, _solved, "{out}/", config="CONFIG", out="FOLDER")

if __name__ == "__main__":
    sys.exit(main(None))
