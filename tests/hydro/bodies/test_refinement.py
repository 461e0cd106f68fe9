"""Panels too coarse are made smaller before a body is refused; what they cannot mend is named."""

import math
from dataclasses import replace

import pytest

from vsb.engine.hydro import database
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.refinement import refined_file
from vsb.engine.hydro.database import Check
from vsb.engine.hydro.panels.rings import quick_green_function
from vsb.stages.coefficients import finely_solved

SPHERE = {"kind": "sphere", "radius": 3.0, "draft": 3.0, "panel": 1.4}
FAILED = Check("error_estimate", 0.5, 0.05, "-", "fail", "")


def body_file(**changes):
    """A body file of a coarse sphere, up to beyond its first irregular frequency."""
    given = {"body": "ball", "mesh": SPHERE, "modes": ["Heave"], "omega": [1.0, 3.4]}
    return BodyFile.model_validate(given | changes)


def test_panels_of_a_hull_become_smaller_by_no_more_than_a_half():
    """Errors fall at least in proportion to the panels: a tenth of the error would need a tenth of them, step by step."""
    file = body_file()
    body = build_body(file, {})
    assert refined_file(file, body, [FAILED]).mesh.panel == pytest.approx(0.7)
    assert refined_file(file, body, [replace(FAILED, value=0.06)]).mesh.panel == pytest.approx(1.4 * 0.8 / 1.2)
    assert refined_file(file, body, [replace(FAILED, verdict="doubt")]) is None


@pytest.mark.parametrize("changes", [{"lid": 0}, {"mesh": {**SPHERE, "panel": 0.12}}])
def test_panels_stay_where_smaller_ones_do_not_help_or_cost_too_much(changes):
    """Irregular frequencies without a lid are there on any mesh."""
    file = body_file(**changes)
    assert refined_file(file, build_body(file, {}), [FAILED]) is None


def test_a_coarse_sphere_is_solved_on_smaller_panels(tmp_path):
    """64 panels of half a radius fail at 3.4 rad/s; the database says what was changed and why."""
    found = finely_solved(body_file(), (), {}, str(tmp_path), green=quick_green_function())
    assert "panels made smaller, to 0.7 m from 1.4 m, because of error_estimate" in found.attrs["history"]
    assert not [check for check in database.stored_checks(found) if check.verdict == "fail"]


def test_resonance_of_enclosed_water_is_named_apart_from_resolution(tmp_path):
    """Inside a ring the water heaves like a piston near 1.6 rad/s, where finer panels change little."""
    path = tmp_path / "ring.obj"
    path.write_text(ring(24, 12, radius=6.0, tube=1.5))
    file = body_file(mesh="ring.obj", omega=[0.5, 0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.3])
    found = finely_solved(file, ("error_estimate",), {"mesh": str(path)}, str(tmp_path), green=quick_green_function())
    checks = {check.name: check for check in database.stored_checks(found)}
    assert checks["resonance"].verdict == "doubt"
    assert "Heave at about 1.6 rad/s" in checks["resonance"].explanation
    assert checks["error_estimate"].value < 0.5 * checks["resonance"].value


def ring(around, about, radius, tube):
    """A ring of round section as OBJ, normals outward, no corner in still water."""
    lines = []
    for i in range(around):
        for j in range(about):
            theta, phi = 2 * math.pi * i / around, 2 * math.pi * (j + 0.5) / about
            r = radius + tube * math.cos(phi)
            lines.append(f"v {r * math.cos(theta):.9g} {r * math.sin(theta):.9g} {tube * math.sin(phi):.9g}")
    for i in range(around):
        for j in range(about):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            lines.append("f " + " ".join(str(a % around * about + b % about + 1) for a, b in corners))
    return "\n".join(lines) + "\n"
