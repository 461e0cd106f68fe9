"""Smaller panels for a body whose coefficients fail a check: tried before they are refused, within a bounded cost."""

from collections.abc import Sequence

import numpy as np

from vsb.engine.hydro.bodies.body import FlexibleBody, panel_diameters
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.cost import GIGABYTES, SECONDS
from vsb.engine.hydro.bodies.lid import first_irregular_frequency
from vsb.engine.hydro.bodies.verdict import BELOW_IRREGULAR
from vsb.engine.hydro.database import Check

REFINABLE = ("error_estimate", "far_field", "haskind", "symmetry", "panels", "lid")
"""Checks whose failure smaller panels may mend."""
MOST_GIGABYTES, MOST_SECONDS = 1.0, 120.0
"""Memory of a frequency, and time of all on one core, that a refinement may take."""
SMALLEST_STEP, LARGEST_STEP = 0.5, 0.75
"""Bounds of the size of panels over that before: errors fall with it at least in proportion."""


def refined_file(file: BodyFile, body: FlexibleBody, checks: Sequence[Check]) -> BodyFile | None:
    """Return a body file with panels small enough for its failed checks; None where none, or no affordable ones, help.

    A hull is meshed anew, panels of a mesh file are divided. Panels with displacements of their own stay, and where
    irregular frequencies are solved without a lid no panels help.
    """
    failed = [check for check in checks if check.verdict == "fail"]
    bare = not file.lid and file.omega[-1] > BELOW_IRREGULAR * first_irregular_frequency(body, file.water.gravity)
    if not any(check.name in REFINABLE for check in failed) or file.rigid_motions is None or bare:
        return None
    wanted = min(0.8 * check.limit / check.value for check in failed if check.name in REFINABLE)
    factor = min(max(wanted, SMALLEST_STEP), LARGEST_STEP)
    squared = (len(body.faces) / factor**2) ** 2
    if GIGABYTES * squared > MOST_GIGABYTES or SECONDS * squared * len(file.omega) > MOST_SECONDS:
        return None
    if file.hull is not None:
        hull = file.hull.model_copy(update={"panel": factor * file.hull.panel})
        return file.model_copy(update={"mesh": hull})
    longest = file.panel or float(panel_diameters(body).max() / np.sqrt(2))
    return file.model_copy(update={"panel": factor * longest})


def history_of(file: BodyFile, finer: BodyFile, checks: Sequence[Check]) -> str:
    """Return what a refinement changes and why, for the history of a database."""
    failed = ", ".join(f"{check.name} {check.value:.3g}" for check in checks if check.verdict == "fail")
    return f"panels made smaller, to {_panel(finer):.3g} m{_before(file)}, because of {failed}"


def _panel(file: BodyFile) -> float:
    """Size of the panels a file asks for [m]."""
    return file.hull.panel if file.hull else file.panel or np.nan


def _before(file: BodyFile) -> str:
    """The size before, where the file says it."""
    return "" if np.isnan(_panel(file)) else f" from {_panel(file):.3g} m"
