"""The second solver of a study: what panels and the spectral solver are both asked, on which shapes. Pure Python.

Nothing here depends on what the buoy is made of, its dampers or its seas: studies of one geometry share a witness.
"""

import math

from vsb.study.blocks import FEWEST_LID_ROWS, LEAST_DEPTH_IN_WAVENUMBERS, HydroPlan, degree, panel_solver
from vsb.study.resolution import mode_rows
from vsb.study.specs import DeformedSpec, LoadedShape, Shapes, Sphere, WitnessSpec
from vsb.study.study import CLEARANCE, Study

MOST_MODES = 12
"""Modes, of the lowest degrees, that deform the shell and whose coefficients are compared."""
ROWS = 32
"""Panels err by 1e-3 with them, and say 3e-3: an error of one percent in either solver is seen."""
LONGEST, SHORTEST = 0.3, 3.0
"""Wavenumber times radius of the longest and the shortest wave of three: around the resonance of heave, near one."""


def no_witness(study: Study) -> str:
    """Say why a study has no second solver; empty if it has."""
    if not study.needs_bem:
        return "an assumed pressure has no coefficients"
    if study.hydro.witness == "none":
        return "hydro.witness: none"
    if study.device.shape is not None:
        return "panels are those of the sphere"
    if study.water.depth < CLEARANCE * study.draft:
        return f"the spectral solver needs a water.depth of {CLEARANCE:g} drafts"
    return ""


def witness_spec(plan: HydroPlan) -> WitnessSpec:
    """Return what is asked of both solvers."""
    study, water = plan.study, plan.study.water
    modes = lowest_modes(plan.mode_labels)
    rows = max(ROWS, *(mode_rows(degree(mode)) for mode in modes), 0)
    meshes = DeformedSpec(
        shape=_shape(plan), deformed=modes, depth=water.depth, rows=rows, azimuth=2 * rows, lid_rows=FEWEST_LID_ROWS
    )
    longest = max(LONGEST / study.device.radius, LEAST_DEPTH_IN_WAVENUMBERS / water.depth)
    shortest = max(SHORTEST / study.device.radius, 2 * longest)
    omega = [
        round(math.sqrt(water.gravity * k * math.tanh(k * water.depth)), 6)
        for k in (longest, math.sqrt(longest * shortest), shortest)
    ]
    return WitnessSpec(solver=panel_solver(), meshes=meshes, water=water, omega=tuple(omega))


def lowest_modes(labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the `MOST_MODES` modes of the lowest degrees, in the order of the basis."""
    chosen = sorted(labels, key=degree)[:MOST_MODES]
    return tuple(label for label in labels if label in chosen)


def _shape(plan: HydroPlan) -> Sphere | Shapes | LoadedShape:
    """The shape at rest, and what its modes follow from: Poisson's ratio and thickness, not stiffness or density."""
    study, shape = plan.study, plan.shape
    if isinstance(shape, LoadedShape) or not study.flexible:
        return shape
    device = study.device
    return Shapes(
        **dict(shape), thickness=device.thickness, poisson_ratio=device.poisson_ratio, basis=study.modes.basis
    )
