"""Estimated errors of a body's coefficients against true ones, and the verdict."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with

from examples import barge
from vsb.engine.hydro import dofs
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.solution import Measure, solved_block, swept
from vsb.engine.hydro.bodies.solver import BodyProblem, interior_lid
from vsb.engine.hydro.bodies.verdict import Block, error_estimate, least_sizes, mesh_checks, sizes
from vsb.engine.hydro.database import with_excitation
from vsb.engine.hydro.panels import bem
from vsb.engine.hydro.quality import negative_damping
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.waves.water import Water, wavenumber

UNIT = Water(density=1.0, gravity=1.0)
SEA = Water(density=1025.0, gravity=9.81)
KA = (0.1, 1.0, 3.5)
NAMES = ("added_mass", "radiation_damping", "excitation_force")


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def block(problem, omega):
    """What a run stores of a frequency."""
    return solved_block(problem, *problem.coarser(), {"omega": float(omega), "wave_direction": [0.0]})


def size_of(problem):
    return sizes(problem.at_infinity().added_mass_inf.values, least_sizes(problem.body, problem.water.density))


def estimated_and_true(problem, reference, omegas):
    """Estimated error, and the true one in the same terms."""
    blocks, infinite = [block(problem, omega) for omega in omegas], block(problem, np.inf)
    exact, limit = with_excitation(reference.solve(list(omegas))), reference.at_infinity()
    own = infinite.own.added_mass_inf.values
    size = np.sqrt(np.diag(own))
    pair, errors = np.outer(size, size), []
    for name in NAMES:
        unit = pair if exact[name].dims[-1] == "radiating_dof" else size
        found = np.concatenate([with_excitation(b.own)[name].values / unit for b in blocks])
        true = exact[name].values / unit
        if name == "added_mass":
            found, true = np.concatenate([found, (own / pair)[None]]), np.concatenate([true, (limit / pair)[None]])
        errors.append(np.abs(found - true).max() / np.abs(found).max())
    return error_estimate(blocks, infinite, size_of(problem)), max(errors)


@pytest.mark.parametrize(
    ("amplitude", "rows"), [(-0.15, (6, 10)), pytest.param(0.0, (6, 8, 10, 12), marks=pytest.mark.slow)]
)
def test_estimate_bounds_the_error_of_spheres_and_spheroids(green, amplitude, rows):
    degrees, shell = (0, 1, 2), shell_with(amplitude)
    reference = SpectralProblem(shell, dofs.displacements(f"Radial{n}" for n in degrees), 1.0, 1.0, 48)
    found = []
    for n in rows:
        body = revolved_body(shell, n, degrees, 4 * int(np.ceil(n / 2)))
        problem = BodyProblem(green, body, UNIT, "xOz+yOz", interior_lid(body, 6))
        found.append(estimated_and_true(problem, reference, np.sqrt(KA)))
    estimate, true = np.array(found).T
    assert np.all((estimate > true) & (estimate < 8 * true)), found
    order = -np.polyfit(np.log(rows), np.log(estimate), 1)[0]
    assert 1.2 < order < 2.8, found


def test_estimate_bounds_the_error_at_an_irregular_frequency(green):
    """Both meshes have it, without a lid: what fewer panels change is less than the error."""
    body = revolved_body(shell_with(0.0), 12, (1,), 24)
    problem, irregular = BodyProblem(green, body, UNIT, "xOz+yOz"), np.sqrt(2.56)
    reference = SpectralProblem(shell_with(0.0), dofs.displacements(["Radial1"]), 1.0, 1.0, 32)
    estimate, true = estimated_and_true(problem, reference, [irregular])
    found, infinite = block(problem, irregular), block(problem, np.inf)
    believed = found._replace(waves=with_excitation(found.own)[list(NAMES[1:])])
    assert error_estimate([believed], infinite, size_of(problem)) < true < estimate < 8 * true


@pytest.fixture(scope="module")
def box():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    return made(vertices, faces, rigid(vertices)[[2, 4]], ("Heave", "Pitch"))


def test_estimate_does_not_depend_on_the_unit_of_a_displacement(green, box):
    found = []
    for scale in (1.0, 1e-3):
        shapes = box.shapes * np.array([1.0, scale])[:, None, None]
        problem = BodyProblem(green, made(box.vertices, box.faces, shapes, box.labels), SEA, "xOz+yOz")
        found.append(error_estimate([block(problem, 1.2)], block(problem, np.inf), size_of(problem)))
    assert found == pytest.approx([found[0]] * 2, rel=1e-9)


def test_yaw_of_a_round_body_does_not_spoil_the_verdict(green):
    """Its added mass is the round-off of triangles: an error in terms of it says nothing."""
    sphere = revolved_body(shell_with(0.0), 6, (0,), 14)
    cut = np.concatenate([sphere.faces[:, [0, 1, 2, 2]], sphere.faces[:, [0, 2, 3, 3]]])
    x = sphere.vertices[cut]
    faces = cut[np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) > 1e-9]
    labels = ("Surge", "Heave", "Pitch", "Yaw")
    motions = dict(zip(("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"), rigid(sphere.vertices), strict=True))
    body = made(sphere.vertices, faces, np.array([motions[label] for label in labels]), labels)
    problem = BodyProblem(green, body, UNIT, "none", interior_lid(body, 4))
    solved, infinite, size = [block(problem, w) for w in (0.5, 1.5)], block(problem, np.inf), size_of(problem)
    assert error_estimate(solved, infinite, size) < 0.5
    assert max(negative_damping(each.own, np.outer(size, size)) for each in solved) < 0.01
    assert max(each.own.attrs[name] for each in solved for name in ("symmetry", "far_field", "haskind")) < 0.1


@pytest.mark.parametrize(
    ("fewer", "waves", "expected"),
    [((0.7, 0.9, 0.9), (0.95, 0.97), 0.3 / 0.6), ((0.9, 0.8, 0.9), (1.0, 0.9), 0.2 / 0.6 + 0.1)],
)
def test_estimate_is_the_change_over_r_minus_1_and_what_both_meshes_miss(fewer, waves, expected):
    """Panels 1.6 times as large change mass, damping and force; far field and Haskind differ from damping and force."""
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    matrices = {name: (pair, np.ones((1, 1, 1))) for name in NAMES[:2]}
    forces = {name: (wave, np.full((1, 1, 1), 0.5 + 0j)) for name in ("Froude_Krylov_force", "diffraction_force")}
    dofs_of = {"influenced_dof": ["Heave"], "radiating_dof": ["Heave"]}
    own = xr.Dataset(matrices | forces, {"omega": [1.0], "wave_direction": [0.0], **dofs_of})
    whole = with_excitation(own)
    other = xr.Dataset({name: whole[name] * share for name, share in zip(NAMES, fewer, strict=True)})
    known = xr.Dataset({name: whole[name] * share for name, share in zip(NAMES[1:], waves, strict=True)})
    limit = xr.Dataset({"added_mass_inf": (pair[1:], [[1.0]])})
    infinite = Block(limit.assign_attrs(resolution_ratio=1.6), limit, xr.Dataset())
    assert error_estimate([Block(own, other, known)], infinite, np.ones(1)) == pytest.approx(expected, rel=1e-12)


def smooth(omega, directions, sizes, centre):
    """Coefficients of two motions in closed form, of a body at a place."""
    w = np.asarray(omega)[:, None, None]
    pair = np.outer(sizes, sizes)
    added = (2.0 + np.cos(w) + np.array([[0.0, 0.3], [0.3, 0.5]]) * np.sin(0.7 * w)) * pair
    damping = (1.0 + 0.5 * np.sin(1.3 * w)) * pair
    k = np.array([wavenumber(float(each), np.inf, SEA.gravity) for each in omega])
    phase = np.exp(1j * np.outer(k, centre[0] * np.cos(directions) + centre[1] * np.sin(directions)))[..., None]
    diffracted = phase * (np.cos(0.9 * w) + 0.4j * np.sin(w)) * sizes
    undisturbed = phase * (1.0 + 0.2j * np.cos(w)) * sizes
    wave, dof = ("omega", "wave_direction", "influenced_dof"), ["Heave", "Pitch"]
    matrices = {"added_mass": added, "radiation_damping": damping}
    forces = {"Froude_Krylov_force": undisturbed, "diffraction_force": diffracted}
    return xr.Dataset(
        {name: (("omega", *("influenced_dof", "radiating_dof")), value) for name, value in matrices.items()}
        | {name: (wave, value) for name, value in forces.items()},
        {"omega": list(omega), "wave_direction": directions, "influenced_dof": dof, "radiating_dof": dof},
    )


def test_sweep_interpolates_coefficients_of_a_distant_body_to_tolerance():
    """Motions of sizes one and a hundred."""
    tolerance = 1e-4
    unit, centre, directions = np.array([1.0, 100.0]), np.array([200.0, -100.0, -3.0]), np.deg2rad([0.0, 70.0])
    omega, asked = np.linspace(0.4, 2.4, 33).tolist(), []

    def solve(w):
        asked.append(w)
        own = smooth([w], directions, unit, centre)
        return Block(own, own, own)

    def froude_krylov(w):
        return smooth(w, directions, unit, centre).Froude_Krylov_force.values

    measure = Measure(unit, centre, directions, SEA)
    found = swept(solve, froude_krylov, omega, tolerance, measure)
    solved = [float(block.own.omega[0]) for block in found.solved]
    assert solved == sorted(set(asked))
    assert 3 < len(solved) < 33
    assert 0 < found.error <= tolerance
    true = smooth(omega, directions, unit, centre)
    assert found.coefficients.omega.values.tolist() == omega
    for name in ("added_mass", "radiation_damping", "Froude_Krylov_force", "diffraction_force"):
        units = unit if "force" in name else np.outer(unit, unit)
        missed = np.abs(found.coefficients[name].values - true[name].values) / units
        assert missed.max() <= 3 * tolerance * (np.abs(true[name].values) / units).max(), name
    all_of_them = swept(solve, froude_krylov, omega, None, measure)
    assert (len(all_of_them.solved), all_of_them.error) == (33, 0.0)
    assert all_of_them.coefficients.added_mass.values == pytest.approx(true.added_mass.values, rel=1e-12)


def wave(body, k):
    """Vertical displacement cos(k x)."""
    shape = np.zeros_like(body.vertices)
    shape[:, 2] = np.cos(k * body.vertices[:, 0])
    return shape


AHEAD = 1025.0 * 48.0 * np.array([[1.0, -0.5], [-0.5, 3.0]])  # the centre of mass is at x = 0.5 m
CASES = [  # check, body as a function of the box (coarse, heave and pitch), verdict
    ("displaced_mass", lambda b: replace(b, mass=np.diag([1025.0 * 48.0 * 1.009, 1.0])), "ok"),
    ("displaced_mass", lambda b: replace(b, mass=np.diag([1025.0 * 48.0 * 0.9, 1.0])), "fail"),
    *(
        ("mass_coupling", lambda b, x=x: replace(b, mass=AHEAD, centre_of_mass=np.array([x, 0.0, 0.3])), verdict)
        for x, verdict in ((0.5, "ok"), (0.7, "doubt"), (-0.5, "fail"))
    ),
    ("rigid_names", lambda b: made(b.vertices, b.faces, 1.04 * b.shapes, b.labels), "doubt"),
    ("rigid_names", lambda b: made(b.vertices, b.faces, b.shapes, b.labels[::-1]), "fail"),
    ("corners", lambda b: replace(b, modes=b.modes * np.array([1.0, 0.8])[:, None, None]), "doubt"),
    ("modes", lambda b: made(b.vertices, b.faces, wave(b, 0.5)[None]), "ok"),
    ("modes", lambda b: made(b.vertices, b.faces, wave(b, 0.7)[None]), "doubt"),
    ("modes", lambda b: made(b.vertices, b.faces, wave(b, 1.5)[None]), "fail"),
    ("second_order", lambda b: made(b.vertices, b.faces, wave(b, 0.7)[None] * [0.0, 0.0, 1.0]), "doubt"),
    ("panels", lambda b: b, "ok"),
]


@pytest.mark.parametrize(("name", "change", "expected"), CASES)
def test_verdict_on_mesh_and_displacements(name, change, expected):
    """Panels of the box are 1.4 m in size, lobes of cos(k x) pi/k long: 4.6, 2.7 and 1.5 panels."""
    vertices, faces = barge.box(6.0, 4.0, 2.0, 1)
    body = made(vertices, faces, rigid(vertices)[[2, 4]], ("Heave", "Pitch"))
    file = BodyFile(body="b", mesh="-", modes="-", omega=[1.0])
    checks = {check.name: check for check in mesh_checks(file, change(body))}
    assert checks[name].verdict == expected, checks[name]
    if name == "panels":
        longest = max(np.linalg.norm(c[2] - c[0]) for c in vertices[faces])
        for depth in (np.inf, 3.0):
            water = {"depth": depth}
            (found, *_) = mesh_checks(file.model_copy(update={"water": Water(**water)}), body)
            assert found.value == pytest.approx(longest * wavenumber(1.0, depth, 9.81) / (2 * np.pi), rel=1e-9)
