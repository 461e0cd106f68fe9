"""Hulls that stand on the sea bed: open there, sealed to it, moving along it."""

import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_mesh_files import VOLUME, N, R, T, cylinder, described, obj
from scipy.special import h1vp, hankel1, kve

from vsb.engine.hydro.bodies import build
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.bodies.mesh import joined
from vsb.engine.hydro.bodies.solver import BodyProblem
from vsb.engine.hydro.panels.bem import quick_green_function
from vsb.engine.waves.water import Water, wavenumber
from vsb.errors import ConfigError
from vsb.keys.reading import validated

G, RHO = 9.81, 1000.0
WATER = {"density": RHO, "depth": T, "gravity": G}


def pile(modes="rigid", draft=T, **changes):
    mesh = {"kind": "cylinder", "radius": R, "height": draft + 1, "draft": draft, "panel": 0.4}
    raw = {"body": "b", "mesh": mesh, "modes": modes, "mass": 4e4, "omega": [1.0], "water": WATER} | changes
    return build_body(validated(BodyFile, raw, "b.yaml"), {})


def decaying(omega):
    """Wavenumbers k of -k tan(k T) = omega^2/g by bisection, at infinite frequency of cos(k T) = 0 [1/m]."""
    low, high = (np.arange(1, 200) - 0.5) * np.pi, np.arange(1, 200) * np.pi
    if np.isinf(omega):
        return low / T
    start = low
    for _ in range(60):
        x = (low + high) / 2
        left, here = (y * np.sin(y) + omega**2 / G * T * np.cos(y) for y in (start, x))
        low, high = np.where(left * here > 0, x, low), np.where(left * here > 0, high, x)
    return low / T


def surge(omega):
    """Added mass + i damping/omega of a pile in surge [kg], a sum over the vertical eigenfunctions cos k(z + T).

    phi = sum_n c_n R_n(r) cos k_n(z + T) cos(theta) with R_n' = 1 at the wall, where the c_n add up to one.
    """
    k = decaying(omega)
    radial = -2 * R * kve(1, k * R) / ((kve(0, k * R) + kve(2, k * R)) * k * R) + 0j
    if np.isfinite(omega):
        wave = wavenumber(omega, T, G)
        k, radial = np.append(k, 1j * wave), np.append(radial, hankel1(1, wave * R) / (wave * h1vp(1, wave * R)))
    wall, square = np.sin(k * T) / k, T / 2 + np.sin(2 * k * T) / (4 * k)
    return -np.pi * R * RHO * np.sum(wall**2 / square * radial)


def test_a_pile_has_the_load_of_maccamy_and_fuchs_and_the_radiation_of_eigenfunctions():
    """MacCamy and Fuchs (1954): |X| = 4 rho g tanh(kT)/(k^2 |H_1'(kR)|)."""
    problem = BodyProblem(quick_green_function(), pile(["Surge"]), Water(**WATER), "xOz+yOz")
    assert problem.at_infinity().added_mass_inf.item() == pytest.approx(surge(np.inf).real, rel=0.015)
    for omega in (1.0, 3.0):
        ds, k = problem.solve(omega, np.array([0.0])), wavenumber(omega, T, G)
        load = 4 * RHO * G * np.tanh(k * T) / (k**2 * abs(h1vp(1, k * R)))
        assert abs((ds.Froude_Krylov_force + ds.diffraction_force).item()) == pytest.approx(load, rel=0.004)
        assert ds.added_mass.item() == pytest.approx(surge(omega).real, rel=0.006)
        assert ds.radiation_damping.item() == pytest.approx(omega * surge(omega).imag, rel=0.01)


def test_a_closed_hull_and_one_open_at_the_bed_are_the_same(tmp_path):
    points, side, keel = cylinder()
    points[:N, 2] = 1.0  # reaches out of the water
    bodies = [
        described(obj(tmp_path / "pile.obj", points, polygons), ["Surge", "Sway"], water=WATER)
        for polygons in (side, [*side, keel])
    ]
    for body in bodies:
        assert body.volumes == pytest.approx(np.full(3, VOLUME), rel=1e-8)
        assert body.centre_of_buoyancy == pytest.approx([0.0, 0.0, -T / 2], abs=1e-8)
        assert body.bed == -T
        assert not hydrostatic_stiffness(body, RHO, G).any()  # nothing rises
    assert np.array_equal(bodies[0].faces, bodies[1].faces)
    assert "panels on the sea bed left out, which no water touches: 10" in bodies[1].history


def test_only_motions_along_the_bed_are_those_of_a_hull_that_stands_on_it():
    assert pile().labels == ("Surge", "Sway")
    assert "Heave, Roll and Pitch left out: the hull stands on the sea bed" in pile().history
    for motion in ("Heave", "Roll", "Pitch"):
        with pytest.raises(ConfigError, match=rf"{motion} lifts the foot of a hull that stands on the sea bed.*hinge"):
            pile([motion], rotation_point=[0.0, 0.0, -T])
    with pytest.raises(ConfigError, match="families of modes, which lift the foot of a hull that stands on the sea"):
        pile({"rigid": ["Surge"], "bending": {"count": 2}})
    with pytest.raises(ConfigError, match=r"water.depth: received 3 m, less than the body's draught of 3.2 m"):
        pile(draft=T + 0.2)


def test_a_pile_bends_by_a_file_of_displacements_that_keeps_its_foot(tmp_path):
    points, side, _ = cylinder()
    rise = (points[:, 2] + T) / T

    def read(shape):
        data = {"vertices": (("vertex", "xyz"), points), "faces": (("panel", "corner"), np.array(side))}
        data |= {"mode_shape": (("dof", "vertex", "xyz"), shape[None])}
        xr.Dataset(data, coords={"dof": ["Bending"]}).to_netcdf(tmp_path / "pile.nc")
        return build.read_body(tmp_path / "pile.nc", tmp_path / "pile.nc", Water(**WATER))

    bending = np.column_stack([rise**2, 0 * rise, -2 * points[:, 0] * rise / T])  # the foot is clamped
    assert read(bending).volume == pytest.approx(VOLUME, rel=1e-8)
    with pytest.raises(ConfigError, match="Bending lifts the foot"):
        read(np.column_stack([rise, 0 * rise, -points[:, 0] / T]))


def test_piles_beside_each_other_are_apart_and_one_in_another_is_refused(tmp_path):
    points, side, _ = cylinder()

    def two(scale, x):
        both = joined([(points, np.array(side)), (points * [scale, scale, 1] + [x, 0, 0], np.array(side))])
        return described(obj(tmp_path / "piles.obj", *both), ["Surge"], water=WATER)

    assert two(1.0, 5.0).volume == pytest.approx(2 * VOLUME, rel=1e-8)
    with pytest.raises(ConfigError, match=r"24 panels of part 2 lie inside part 1"):
        two(0.5, 0.5)
