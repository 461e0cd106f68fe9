import numpy as np
import pytest
from hydro.bodies.test_body import made, rigid

from examples.barge import box
from vsb.errors import ConfigError
from vsb.hydro.bodies.body import joined
from vsb.hydro.bodies.files import read_body, write_body
from vsb.hydro.bodies.study import mesh_checks
from vsb.study.body import BodyFile


def heaving(vertices, faces):
    """A body of these panels that heaves."""
    return made(vertices, faces, rigid(vertices)[2:3], ("Heave",))


@pytest.mark.parametrize(("cut", "where"), [((1,), "y = 0"), ((0,), "x = 0"), ((0, 1), "x = 0 and y = 0")])
def test_a_part_of_a_body_cut_in_a_plane_of_symmetry_is_refused(cut, where):
    """A face missing in a plane through the origin adds nothing to the three volumes."""
    vertices, faces = box(4.0, 2.0, 1.0, 1)
    kept = (vertices[faces][..., list(cut)] >= -1e-9).all(axis=(1, 2))
    with pytest.raises(ConfigError, match=f"^mesh: open along {where}, where .* symmetry flags of its file"):
        heaving(vertices, faces[kept])


def cylinder(around_side, around_bottom):
    """Radius and draught 1 m; patches that do not meet corner by corner."""
    parts = []
    for count, loops in ((around_side, [(1, 0), (1, -1)]), (around_bottom, [(1, -1), (0.5, -1), (1e-3, -1)])):
        theta, i = 2 * np.pi * np.arange(count) / count, np.arange(count)
        points = np.vstack([np.column_stack([r * np.cos(theta), r * np.sin(theta), 0 * theta + z]) for r, z in loops])
        rows = [
            count * k + np.column_stack([i, i + count, np.roll(i, -1) + count, np.roll(i, -1)])
            for k in range(len(loops) - 1)
        ]
        parts.append((points, np.concatenate(rows)))
    points, faces = joined(parts)
    middle = np.column_stack(
        [
            i := len(points) - around_bottom + np.arange(around_bottom),
            0 * i + len(points),
            np.roll(i, -1),
            np.roll(i, -1),
        ]
    )
    return np.vstack([points, [0.0, 0.0, -1.0]]), np.concatenate([faces, middle])


def test_slivers_between_patches_are_accepted_with_their_effect_and_place(tmp_path):
    """72 panels around the side and 36 around the bottom: the circle's chords lie 3.8 mm apart."""
    write_body(heaving(*cylinder(72, 36)), tmp_path / "a.nc")
    body = read_body(tmp_path / "a.nc", tmp_path / "a.nc")
    assert body.part.max() == 0
    side, bottom = (n / 2 * np.sin(2 * np.pi / n) for n in (72, 36))
    file = BodyFile(body="a", mesh="a.nc", modes="a.nc", omega=[1.0])
    (check,) = (check for check in mesh_checks(file, body) if check.name == "closure")
    assert check.value == pytest.approx(1 - bottom / side, rel=1e-6)
    assert check.verdict == "doubt"
    assert "up to 0.0038 m wide at (" in body.history
    met = heaving(*cylinder(36, 36))
    assert "closure" not in {check.name for check in mesh_checks(file, met)}


def test_gaps_of_more_than_a_hundredth_of_the_volume_are_refused():
    """12 panels around the bottom of 24: 3.4 %."""
    with pytest.raises(ConfigError, match=r"^mesh: encloses 3.10583, 3.10583 and 3 m\^3 by the normals' x, y and z"):
        heaving(*cylinder(24, 12))
