"""Modes by name: fields, masses and still-water stiffness of hinges, bending and polynomials; refusals."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.linalg import eigh

from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body, read_body
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.errors import ConfigError
from vsb.keys.reading import validated
from vsb.pipeline.plans import planned
from vsb.stages.body_preview import check

HOME = Path(__file__).parents[3]
BARGE = HOME / "config" / "barge" / "barge.nc"
RHO_G = 1025.0 * 9.81
L, B, T = 80.0, 10.0, 5.0
BOX = {"kind": "box", "length": L, "width": B, "height": 8.0, "draft": T, "panel": 2.5}


def described(modes="rigid", **changes):
    raw = {"body": "b", "mesh": BOX, "modes": modes, "mass": "displaced", "omega": [1.0], "centre_of_mass": [0, 0, 0]}
    return validated(BodyFile, raw | {"radii_of_gyration": [3.0, L / 12**0.5, L / 12**0.5]} | changes, "b.yaml")


def named(matrix, body, *labels):
    at = [body.labels.index(label) for label in labels]
    return matrix[np.ix_(at, at)]


def test_families_are_the_fields_of_the_shipped_barge():
    """Displacements of the corners, modal mass and stiffness of its file, of a mesh whose panels it reads."""
    file = described(
        {"rigid": ["Heave", "Pitch"], "bending": {"count": 4, "stiffness": 2.0e10}, "hinge": {"at": [0, 0]}},
        mesh=str(BARGE),
    )
    body, known = build_body(file, {"mesh": BARGE}), read_body(BARGE, BARGE)
    assert body.labels == known.labels
    assert np.abs(body.shapes - known.shapes).max() < 1e-9
    assert body.mass == pytest.approx(known.mass, abs=1e-7 * known.mass[0, 0])
    assert np.diag(body.stiffness) == pytest.approx(np.diag(known.stiffness), rel=1e-9)


def test_still_water_stiffness_of_a_barge():
    """Bending 1.91/1.95/2.05/2.24 MN/m, hinge 2.43 MN/m: along the inextensible path, with water in the hinge's gap."""
    body = build_body(described({"rigid": True, "bending": {"count": 4}, "hinge": {"at": [0, 0]}}), {})
    found = dict(zip(body.labels, np.diag(hydrostatic_stiffness(body, 1025.0, 9.81)) / 1e6, strict=True))
    assert [found[f"Bending{n}"] for n in (1, 2, 3, 4)] == pytest.approx([1.9132, 1.9450, 2.0540, 2.2408], abs=2e-4)
    assert found["Hinge"] == pytest.approx(RHO_G * (B * L / 3 - 0.05**2 * L * B * T * T / 2) / 1e6, rel=1e-9)
    assert body.labels[:6] == ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
    assert body.stiffness is None


@pytest.mark.parametrize(("x", "z"), [(10.0, 0.0), (-20.0, -5.0), (0.0, 2.0)])
def test_hinge_anywhere_is_two_closed_pieces(x, z):
    """Newman's forms of both; at a height they also shift sideways, which still water does not feel but the mass does."""
    body = build_body(described({"rigid": ["Heave"], "hinge": {"at": [x, z], "stiffness": 3.0e6}}), {})
    slope, length = 2 / np.array([40.0 + x, 40.0 - x]), np.array([40.0 + x, 40.0 - x])
    form = B * L / 3 - (slope**2 * length).sum() * B * T**2 / 2
    hinge = body.labels.index("Hinge")
    assert hydrostatic_stiffness(body, 1025.0, 9.81)[hinge, hinge] == pytest.approx(RHO_G * form, rel=1e-6)
    line = 1025.0 * B * T
    assert body.mass[hinge, hinge] == pytest.approx(line * (L / 3 + z**2 * (slope**2 * length).sum()), rel=1e-2)
    assert body.mass[hinge, 0] == pytest.approx(0.0, abs=1e-9 * line * L)
    assert body.stiffness[hinge, hinge] == pytest.approx(3.0e6 * slope.sum() ** 2, rel=1e-9)


def test_polynomials_bend_like_beams():
    """EI int W'' W'' ds of P_2, P_3 and P_4 by hand, and the stiffness of a beam's quadratic in still water."""
    body = build_body(described({"rigid": ["Heave"], "polynomial": {"count": 3, "stiffness": 1.0e9}}), {})
    bent = named(body.stiffness, body, *(f"Polynomial{n}" for n in (1, 2, 3)))
    exact = np.array([[18.0, 0.0, 60.0], [0.0, 150.0, 0.0], [60.0, 0.0, 690.0]])  # int P_n'' P_m'' over -1..1
    assert bent == pytest.approx(1.0e9 * (2 / L) ** 3 * exact, rel=1e-9, abs=1.0)
    found = hydrostatic_stiffness(body, 1025.0, 9.81)[1, 1]
    moment = B * T**2 / 2  # int -z dA over a section; int W W'' ds vanishes, as W'' of P_2 is constant
    assert found == pytest.approx(RHO_G * (B * L / 5 - 12 / L * moment), rel=1e-4)


def test_rotation_point_is_a_combination_of_motions_about_the_centre_of_mass():
    """About a point 3 m below it pitch is that about the centre plus 3 m of surge: a congruence of both matrices."""
    labels = ["Surge", "Heave", "Pitch"]
    about = build_body(described(labels), {})
    below = build_body(described({"rigid": labels}, rotation_point=[0.0, 0.0, -3.0]), {})
    to = np.array([[1.0, 0.0, 3.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert below.mass == pytest.approx(to.T @ about.mass @ to, rel=1e-12, abs=1e-3)
    stiffness = [hydrostatic_stiffness(body, 1025.0, 9.81) for body in (about, below)]
    assert stiffness[1] == pytest.approx(to.T @ stiffness[0] @ to, rel=1e-9, abs=1e-3)


def test_study_of_the_documentation():
    """It holds all it needs, and its still water is that of the barge, on larger panels."""
    page = (HOME / "docs" / "own-body.md").read_text().split("## Hinges and bending by name\n")[1]
    raw = yaml.safe_load(page.split("```yaml\n")[1].split("```")[0])
    body = check(planned(raw, "study.yaml")).body
    stiffness = np.diag(body.stiffness_parts["hydrostatic"]) / 1e6
    assert body.labels == ("Heave", "Pitch", "Bending1", "Bending2", "Bending3", "Bending4", "Hinge")
    assert stiffness[2:] == pytest.approx([1.91, 1.95, 2.05, 2.24, 2.43], abs=6e-3)


DISC = {"kind": "cylinder", "radius": 10.0, "height": 1.0, "draft": 0.5, "panel": 0.6}


def test_round_plate_in_vacuum():
    """Frequencies of a free plate, nu = 0.3: lambda^2 = 5.358, 9.003, 12.439, 20.475 (Leissa 1969); w = x^2 - y^2."""
    plate = {"degree": 9, "stiffness": 2.0e6, "poisson_ratio": 0.3}
    body = build_body(described({"rigid": ["Heave"], "plate": plate}, mesh=DISC), {})
    assert np.abs(body.mass[0, 1:]).max() < 1e-3 * body.mass[0, 0]  # a polygon of the circle's area
    bent = 8 * np.pi * 0.7 * 2.0e6 / 10.0**2
    assert named(body.stiffness, body, "Plate2_2")[0, 0] == pytest.approx(bent, rel=2e-3)
    unit = np.pi * 10.0**2 * 2.0e6 / (body.mass[0, 0] * 10.0**4)  # D/(m a^4), m the mass of an area
    square = eigh(body.stiffness[1:, 1:], body.mass[1:, 1:], eigvals_only=True)
    assert np.sqrt(square[:4] / unit) == pytest.approx([5.358, 9.003, 12.439, 20.475], rel=3e-3)


def test_plate_of_a_box_is_refused():
    with pytest.raises(ConfigError, match=r"modes\.plate: received a hull of 80 x 10 m; needs a round one"):
        build_body(described({"rigid": ["Heave"], "plate": {"degree": 2}}), {})
