from itertools import pairwise

import capytaine as cpt
import numpy as np
import pytest
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from examples import barge
from vsb.engine.hydro import dofs
from vsb.engine.hydro.bodies import body as bodies
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.bodies.mesh import joined
from vsb.engine.hydro.bodies.solver import (
    BodyProblem,
    coarser_body,
    coarser_panels,
    first_irregular_frequency,
    gap_resonance,
    interior_lid,
    unit_wave,
    unit_wave_slope,
)
from vsb.engine.hydro.bodies.verdict import identities
from vsb.engine.hydro.panels import bem
from vsb.engine.hydro.panels.mesh import polygon_radius, revolved
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.ritz import legendre
from vsb.engine.waves.water import Water, wavenumber

UNIT = Water(density=1.0, gravity=1.0)
SEA = Water(density=1025.0, gravity=9.81)
RIGID = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


@pytest.fixture(scope="module")
def box():
    """A box 6 x 4 x 2 m, 144 panels, with rigid motions and one of no symmetry at all."""
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    shapes = np.concatenate([rigid(vertices), np.exp(0.3 * vertices @ [[1.0, 0, 0], [0.5, 1, 0], [0, 0.2, 1]])[None]])
    return made(vertices, faces, shapes, (*RIGID, "Skew"))


def largest_difference(one, other):
    """Of two datasets, relative to the largest entry of each variable."""
    return max(float(np.abs(one[name] - other[name]).max() / np.abs(other[name]).max()) for name in other.data_vars)


@pytest.fixture
def plain(monkeypatch):
    """Capytaine's own diagonal."""
    monkeypatch.setattr(bem.SymmetricPanels, "correction", property(lambda self: np.zeros(self.part.nb_faces)))


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(("depth", "symmetry"), [(np.inf, "none"), (5.0, "xOz+yOz")])
def test_rigid_motions_equal_capytaines_own_to_round_off(green, box, depth, symmetry):
    omega, direction = 1.2, 0.7
    water = SEA.model_copy(update={"depth": depth})
    ours = BodyProblem(green, box, water, symmetry).solve(omega, np.array([direction]))
    body = cpt.FloatingBody(
        mesh=bem.panel_mesh(box.vertices, box.faces), dofs=cpt.rigid_body_dofs(rotation_center=(0, 0, 0))
    )
    sea = {"body": body, "omega": omega, "water_depth": depth, "rho": SEA.density, "g": SEA.gravity}
    problems = [*(cpt.RadiationProblem(radiating_dof=dof, **sea) for dof in RIGID)]
    problems.append(cpt.DiffractionProblem(wave_direction=direction, **sea))
    *radiated, scattered = cpt.BEMSolver(green_function=green, method="indirect").solve_all(
        problems, progress_bar=False, _check_wavelength=False
    )
    first = ours.isel(omega=0).sel(influenced_dof=list(RIGID), radiating_dof=list(RIGID))
    for name, theirs in (("added_mass", "added_masses"), ("radiation_damping", "radiation_dampings")):
        expected = np.array([[getattr(r, theirs)[dof] for r in radiated] for dof in RIGID])
        assert np.abs(first[name].values - expected).max() < 1e-11 * np.abs(expected).max()
    forces = np.array([scattered.forces[dof] for dof in RIGID])
    assert np.abs(first.diffraction_force.values[0] - forces).max() < 1e-11 * np.abs(forces).max()
    froude_krylov = cpt.bem.airy_waves.froude_krylov_force(problems[-1])
    expected = np.array([froude_krylov[dof] for dof in RIGID])
    assert np.abs(first.Froude_Krylov_force.values[0] - expected).max() < 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("belts", [pytest.param(0, marks=pytest.mark.slow), 2])
def test_planes_of_symmetry_change_no_coefficient(green, box, belts, monkeypatch):
    # capytaine takes the distance to a panel's first corner for its size, and a mirrored skew panel begins elsewhere
    def size(mesh):
        return np.linalg.norm(mesh.vertices[mesh.faces] - mesh.faces_centers[:, None], axis=2).max(1)

    monkeypatch.setattr(cpt.Mesh, "faces_radiuses", property(size, lambda mesh, first: None))
    lid = interior_lid(box, belts) if belts else None
    directions = np.array([0.0, 0.7])
    whole = BodyProblem(green, box, SEA, "none", lid)
    solved, limit = whole.solve(1.2, directions), whole.at_infinity()
    for symmetry in ("xOz", "yOz", "xOz+yOz"):
        problem = BodyProblem(green, box, SEA, symmetry, lid)
        assert largest_difference(problem.solve(1.2, directions), solved) < 1e-12
        assert largest_difference(problem.at_infinity(), limit) < 1e-12


@pytest.mark.parametrize("amplitude", [0.15, pytest.param(-0.15, marks=pytest.mark.slow)])
def test_deformed_spheres_converge_to_the_spectral_solution_at_second_order(green, amplitude):
    degrees, omega, rows = (0, 1, 2), 1.0, np.array([4, 6, 8, 11])
    shell = shell_with(amplitude)
    reference = SpectralProblem(shell, dofs.displacements(f"Radial{n}" for n in degrees), 1.0, 1.0, 48)
    exact, limit = reference.solve([omega]), reference.at_infinity()
    errors = []
    for n in rows:
        body = revolved_body(shell, n, degrees, 4 * int(np.ceil(n / 2)))
        problem = BodyProblem(green, body, UNIT, "xOz+yOz", interior_lid(body, 4))
        ours = problem.solve(omega, np.zeros(1))
        names = ("added_mass", "radiation_damping", "excitation_force")
        pairs = [(with_sum(ours)[name].values, with_sum(exact)[name].values) for name in names]
        pairs.append((problem.at_infinity().added_mass_inf.values, limit))
        errors.append([np.abs(a - b).max() / np.abs(b).max() for a, b in pairs])
    orders = -np.polyfit(np.log(rows), np.log(errors), 1)[0]
    assert np.all((orders > 1.7) & (orders < 2.4)), (orders, errors)
    assert np.max(errors[-1]) < 0.03, errors


def with_sum(ds):
    return ds.assign(excitation_force=ds.Froude_Krylov_force + ds.diffraction_force)


@pytest.mark.parametrize("depth", [pytest.param(np.inf, marks=pytest.mark.slow), 4.0])
def test_identities_of_radiated_waves_converge(green, depth):
    found, panels = [], np.array([1, 2, 3, 4])
    for n in panels:
        vertices, faces = barge.box(6.0, 4.0, 2.0, n)
        body = made(vertices, faces, rigid(vertices)[[1, 2, 3, 4]], RIGID[1:5])
        problem = BodyProblem(green, body, SEA.model_copy(update={"depth": depth}), "xOz+yOz")
        found.append(list(identities(problem.solve(1.2, np.array([0.4])), problem).values()))
    orders = -np.polyfit(np.log(panels), np.log(found), 1)[0]
    assert np.all((orders > 1.2) & (orders < 2.8)), (orders, found)
    assert np.max(found[-1]) < 0.02


def test_lid_removes_an_irregular_frequency(green):
    body = revolved_body(shell_with(0.0), 6, (0, 1), 12)
    omega = np.sqrt(2.57)  # the lowest of the hemisphere: Ka = 2.557
    found = {}
    for belts in (0, 5):
        lid = interior_lid(body, belts) if belts else None
        problem = BodyProblem(green, body, UNIT, "xOz+yOz", lid)
        found[belts] = max(identities(problem.solve(omega, np.zeros(1)), problem).values())
    assert found[0] > 0.1
    assert found[5] < 0.02


def test_excitation_of_long_waves_is_hydrostatic(green, box):
    omega = np.array([0.1, 0.05])
    problem = BodyProblem(green, box, SEA, "xOz+yOz")
    stiffness = hydrostatic_stiffness(box, SEA.density, SEA.gravity)
    heave = RIGID.index("Heave")
    gaps = []
    for w in omega:
        ds = with_sum(problem.solve(float(w), np.array([0.3])))
        gaps.append(abs(ds.excitation_force.values[0, 0, heave] / stiffness[heave, heave] - 1))
        assert abs(ds.radiation_damping.values[0, heave, heave]) < 0.1 * w * ds.added_mass.values[0, heave, heave]
    assert gaps[1] < 0.3 * gaps[0]  # of second order in frequency
    assert gaps[1] < 2e-3


@pytest.mark.parametrize("depth", [np.inf, 7.0, 1e5])
def test_unit_wave_solves_laplace_the_free_surface_and_the_bed(depth):
    omega, gravity, h = 1.3, 9.81, 1e-4
    k = wavenumber(omega, depth, gravity)
    x = np.array([[0.3, -0.8, -1.1]])
    beta = np.array([0.4])

    def f(dx):
        return unit_wave(x + np.asarray(dx), k, depth, beta)[0, 0]

    steps = h * np.eye(3)
    laplacian = sum(f(d) - 2 * f(0 * d) + f(-d) for d in steps) / h**2
    assert abs(laplacian) < 1e-6
    slopes = [unit_wave_slope(x, e[None], k, depth, beta)[0, 0] for e in np.eye(3)]
    assert slopes == pytest.approx([(f(d) - f(-d)) / (2 * h) for d in steps], rel=1e-6)
    top, up = np.array([[0.3, -0.8, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    surface = unit_wave_slope(top, up, k, depth, beta) - omega**2 / gravity * unit_wave(top, k, depth, beta)
    assert abs(surface.item()) < 1e-12
    if np.isfinite(depth):
        assert abs(unit_wave_slope(np.array([[0.3, -0.8, -depth]]), up, k, depth, beta).item()) < 1e-12


def test_added_mass_of_a_deeply_submerged_sphere(green):
    """4 pi rho/((n + 1)(2n + 1)) of P_n e_r, ten radii below still water; flat panels miss it by second order."""
    degrees, rows, found = np.array([1, 2, 3]), np.array([12, 16]), []
    for count in rows:
        phi = np.linspace(0.0, np.pi, count + 1)
        x = np.append(np.append(0.0, polygon_radius(2 * count) * np.sin(phi[1:-1])), 0.0)
        vertices, faces = revolved(x, np.cos(phi) - 10.0, 2 * count)
        radial = vertices + np.array([0.0, 0.0, 10.0])
        radial[:, :2] /= polygon_radius(2 * count)
        shapes = np.array([legendre(3, np.repeat(phi, 2 * count))[0][n][:, None] * radial for n in degrees])
        problem = BodyProblem(green, made(vertices, faces, shapes), UNIT, "xOz+yOz")
        found.append(np.diag(problem.solve(0.6, np.zeros(1)).added_mass.values[0]))
    true = 4 * np.pi / ((degrees + 1) * (2 * degrees + 1))
    missed = 1 - np.array(found) / true
    assert missed[0] / missed[1] == pytest.approx((16 / 12) ** 2, rel=0.06)
    extrapolated = (rows[1] ** 2 * found[1] - rows[0] ** 2 * found[0]) / (rows[1] ** 2 - rows[0] ** 2)
    assert extrapolated == pytest.approx(true, rel=0.015)


BOTH = ("xOz", "yOz")


def areas(vertices, faces):
    """Vector areas of the panels."""
    x = vertices[faces]
    return np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]) / 2


def sides(vertices, faces):
    """Area of the panels that look along each axis, both ways, and what is left."""
    a = areas(vertices, faces)
    return np.array([*np.maximum(a, 0).sum(axis=0), *np.maximum(-a, 0).sum(axis=0), np.linalg.norm(a, axis=1).sum()])


@pytest.mark.parametrize(("panels", "planes"), [(1, ("xOz",)), (2, BOTH), (3, ())])
def test_box_becomes_the_box_of_half_the_resolution(panels, planes):
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2 * panels)
    (coarse, share), half = coarser_panels(vertices, faces, planes), barge.box(6.0, 4.0, 2.0, panels)

    def listed(x, f):
        return np.column_stack([x[f].mean(axis=1), areas(x, f)])

    ours, theirs = listed(vertices, coarse), listed(*half)
    assert len(ours) == len(theirs)
    assert share == pytest.approx(1.0)
    assert cKDTree(ours).query(theirs)[0].max() < 1e-9


@settings(max_examples=10)
@given(seed=st.integers(0, 10_000), length=st.floats(1.0, 100.0), panels=st.integers(1, 3))
@example(seed=77, length=1.0, panels=3)  # a corner that bends a side by 9 degrees
def test_sides_of_a_triangulated_box_keep_their_areas(seed, length, panels):
    vertices, faces = barge.box(length, 4.0, 2.0, panels)
    # quadrilaterals cut along a diagonal drawn by lot
    turn = np.random.default_rng(seed).integers(0, 2, len(faces))
    q = np.array([np.roll(face, k) for face, k in zip(faces, turn, strict=True)])
    halves = np.stack([q[:, [0, 1, 2, 2]], q[:, [0, 2, 3, 3]]], axis=1).reshape(-1, 4)
    cut = halves[[len(set(half.tolist())) == 3 for half in halves]]
    coarse = coarser_panels(vertices, cut, ()).faces
    assert len(coarse) < 0.7 * len(cut)
    assert sides(vertices, coarse) == pytest.approx(sides(vertices, faces), rel=1e-12, abs=1e-9)
    assert len(np.unique(np.sort(coarse, axis=1), axis=0)) == len(coarse)


@pytest.mark.parametrize(("rows", "azimuth"), [(6, 16), (9, 20), (5, 18)])
def test_fewer_panels_of_a_sphere_keep_orientation_and_symmetry(rows, azimuth):
    body = revolved_body(shell_with(0.0), rows, (0,), azimuth)
    planes = bodies.SYMMETRIES[bodies.detected_symmetry(body)]
    coarse, share = coarser_panels(body.vertices, body.faces, planes)
    a, x = areas(body.vertices, coarse), body.vertices[coarse].mean(axis=1)
    assert len(coarse) < 0.4 * len(body.faces)
    assert share > 0.6
    assert np.all(np.sum(a * x, axis=1) > 0.85 * np.linalg.norm(a, axis=1) * np.linalg.norm(x, axis=1))
    assert np.linalg.norm(a, axis=1).sum() == pytest.approx(2 * np.pi, rel=0.12)
    for plane in planes:
        sign = np.where(np.arange(3) == bodies.PLANES[plane], -1.0, 1.0)
        assert cKDTree(x).query(x * sign)[0].max() < 1e-9


def test_displacements_are_those_of_the_corners():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    body = made(vertices, faces, rigid(vertices))
    fewer, _ = coarser_body(body, BOTH)
    assert fewer.labels == body.labels
    assert fewer.modes == pytest.approx(rigid(fewer.centres), abs=1e-12)
    assert fewer.volumes == pytest.approx(body.volumes)


def disc_and_walls(radii, around=72, draught=0.2):
    """Wetted surface of a flat ring between two radii, or of a disc where the inner one is zero."""
    theta = 2 * np.pi * np.arange(around) / around
    circle, i = np.column_stack([np.cos(theta), np.sin(theta)]), np.arange(around)
    loops = [(radii[1], 0.0), (radii[1], -draught), (radii[0], -draught), (radii[0], 0.0)][: 4 if radii[0] else 3]
    vertices = np.vstack([np.column_stack([r * circle, np.full(around, z)]) for r, z in loops])
    faces = [
        np.column_stack([a + i, b + i, b + np.roll(i, -1), a + np.roll(i, -1)])
        for a, b in pairwise(around * np.arange(len(loops)))
    ]
    return vertices, np.concatenate(faces)


def test_lid_lies_inside_the_waterlines_with_normals_down():
    """A spar of 2 m in the moonpool of a ring."""
    vertices, faces = joined([disc_and_walls((3.0, 7.0)), disc_and_walls((0.0, 2.0))])
    lid, panels = interior_lid(made(vertices, faces, rigid(vertices)[2:3]), 8)
    corner = lid[panels]
    away = np.linalg.norm(corner[..., :2], axis=-1)
    assert (((away > 3.0) & (away < 7.0)) | (away < 2.0)).all()
    assert (away < 2.0).any()
    assert (away > 3.0).any()
    assert (np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])[:, 2] < 0).all()
    assert len(np.unique(corner.mean(axis=1).round(6), axis=0)) == len(panels)


def test_lower_bound_of_irregular_frequencies():
    vertices, faces = barge.box(10.0, 8.0, 4.0, 1)
    body = made(vertices, faces, rigid(vertices)[2:3])
    p = np.pi * np.hypot(0.1, 0.125)
    assert first_irregular_frequency(body, 9.81) == pytest.approx(np.sqrt(9.81 * p / np.tanh(4 * p)), rel=1e-12)
    hemisphere = revolved_body(shell_with(0.0), 8, (1,), 16)
    assert 0.8 * 2.557 < first_irregular_frequency(hemisphere, 1.0) ** 2 < 2.557
    below = np.concatenate([faces, faces[:, ::-1] + len(vertices)])
    vertices = np.concatenate([vertices, vertices * [1, 1, -1]]) - [0.0, 0.0, 5.0]
    under = made(vertices, below, rigid(vertices)[2:3])
    assert first_irregular_frequency(under, 9.81) == np.inf
    assert interior_lid(under, 8) is None


def test_resonance_of_a_gap_between_two_bodies():
    """Ring of 3.3 to 5 m around a spar of 3 m: damping of heave peaks and added mass turns negative at 1.70 rad/s."""
    vertices, faces = joined([disc_and_walls((3.3, 5.0), draught=3.0), disc_and_walls((0.0, 3.0), draught=3.0)])
    found = gap_resonance(made(vertices, faces, rigid(vertices)[2:3]), 9.81)
    assert found.omega == pytest.approx(1.70, rel=0.01)
    assert found.width == pytest.approx(0.3, rel=1e-6)
    vertices, faces = joined([disc_and_walls((6.0, 8.0), draught=3.0), disc_and_walls((0.0, 3.0), draught=3.0)])
    assert gap_resonance(made(vertices, faces, rigid(vertices)[2:3]), 9.81) is None
