"""Points a file states, of boxes in the undisturbed wave, whose forces are integrals of its pressure over their walls."""

import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro.formats.points import point_checks

RHO, G, K = 1025.0, 9.81, np.linspace(0.02, 1.2, 30)
LENGTH, WIDTH, DRAFT = 6.0, 4.0, 1.5
VOLUME = LENGTH * WIDTH * DRAFT
MOTIONS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


def forces(x0, turned):
    """Froude-Krylov forces of waves to +x on a box about x0, (omega, heading, motion), moments about a point."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    k = K[:, None]
    z, dz = DRAFT / 2 * (nodes - 1), DRAFT / 2 * weights
    x, dx = x0 + LENGTH / 2 * nodes, LENGTH / 2 * weights
    ends = np.exp(1j * k * (x0 + LENGTH / 2)) - np.exp(1j * k * (x0 - LENGTH / 2))
    walls = -RHO * G * WIDTH * np.exp(k * z) * ends * dz
    floor = RHO * G * WIDTH * np.exp(-k * DRAFT + 1j * k * x) * dx
    pitch = (walls * (z - turned[2])).sum(1) - (floor * (x - turned[0])).sum(1)
    none = 0 * pitch
    return np.stack([walls.sum(1), none, floor.sum(1), none, pitch, none], axis=-1)[:, None]


def boxes(*places, turned=-0.3, **facts):
    """A database of boxes without added mass, which turn about a height; about their places in x."""
    names = ["", *(f"b{n}__" for n in range(len(places)))][len(places) > 1 :][: len(places)]
    labels = [name + motion for name in names for motion in MOTIONS]
    pair, n = ("influenced_dof", "radiating_dof"), len(labels)
    x = np.concatenate([forces(at, np.array([at, 0.0, turned])) for at in places], axis=-1)
    area = LENGTH * WIDTH
    own = [0, 0, area, area * WIDTH**2 / 12, area * LENGTH**2 / 12, 0]
    arm = VOLUME * (-DRAFT / 2 - turned) * np.array([0, 0, 0, 1, 1, 0])
    force = (("omega", "wave_direction", "influenced_dof"), x)
    data = {
        "excitation_force": force, "Froude_Krylov_force": force,
        "added_mass": (("omega", *pair), np.zeros((len(K), n, n))),
        "radiation_damping": (("omega", *pair), np.zeros((len(K), n, n))),
        "hydrostatic_stiffness": (pair, RHO * G * np.diag(np.tile(own + arm, len(places)))),
        "inertia_matrix": (pair, RHO * VOLUME * np.diag(np.tile([1.0, 1, 1, 2, 4, 4], len(places)))),
    }  # fmt: skip
    attrs = {"water_density": RHO, "gravity": G, "water_depth": "inf"}
    for name, at in zip(names, places, strict=True):
        of = f"_{name[:-2]}" if name else ""
        attrs |= {f"displaced_volume{of}": VOLUME, f"centre_of_buoyancy{of}": [at, 0.0, -DRAFT / 2]}
        attrs |= {f"{point}{of}": [at, 0.0, turned] for point in ("centre_of_mass", "rotation_centre")}
    return xr.Dataset(
        data, {"omega": np.sqrt(G * K), "wave_direction": [0.0], **dict.fromkeys(pair, labels)}, attrs | facts
    )


def wrong(ds):
    """Names of the checks that do not hold."""
    return {check.name for check in point_checks(ds) if check.verdict != "ok"}


@pytest.mark.parametrize("places", [(0.0,), (-20.0, 15.0)])
def test_consistent_points_pass(places):
    assert {check.name: check.verdict for check in point_checks(boxes(*places))} == dict.fromkeys(
        ["rotation_centre", "centre_of_buoyancy", "waterplane", "mass_coupling", *["places"] * (len(places) > 1)], "ok"
    )
    assert all(check.value < 0.01 for check in point_checks(boxes(*places)))


def test_heights_of_centres_are_found():
    """What BEMIO's file calls cg is the point of moments, too; WAMIT's and capytaine's files state both."""
    below, above = [0.0, 0.0, -1.1], [0.0, 0.0, 0.1]
    assert wrong(boxes(0.0, centre_of_mass=above, rotation_centre=above)) == {"rotation_centre"}
    assert "0 along the waves and z = -0.3 m" in point_checks(boxes(0.0, rotation_centre=above))[0].explanation
    assert wrong(boxes(0.0, centre_of_mass=above)) == {"mass_coupling"}
    assert wrong(boxes(0.0, centre_of_buoyancy=below)) == {"centre_of_buoyancy"}
    without = boxes(0.0, centre_of_mass=[0.0, 0.0, -2.0], rotation_centre=[0.0, 0.0, -2.0])
    assert wrong(without.drop_vars("Froude_Krylov_force")) == {"waterplane"}


def test_phases_about_the_place_of_each_body_are_found():
    ds, apart = boxes(-20.0, 15.0), boxes(0.0, 0.0)
    names = ["excitation_force", "Froude_Krylov_force"]
    about_each = ds.assign({name: apart[name] for name in names})
    assert wrong(about_each) == {"rotation_centre", "centre_of_buoyancy", "places"}
    assert wrong(about_each.drop_vars("Froude_Krylov_force")) == {"places"}
