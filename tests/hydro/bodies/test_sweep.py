from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with

from examples import barge
from vsb.errors import DatabaseError
from vsb.hydro import dofs
from vsb.hydro.bodies import sweep as bodysweep
from vsb.hydro.bodies.lid import interior_lid
from vsb.hydro.bodies.solver import BodyProblem
from vsb.hydro.bodies.study import _block
from vsb.hydro.bodies.sweep import Block, Measure, _in_units, error_estimate, least_sizes, sizes, swept
from vsb.hydro.database import with_excitation
from vsb.hydro.panels import rings as bem
from vsb.hydro.quality import negative_damping
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.sweep import MOST_SOLVES
from vsb.study.study import Water
from vsb.waves.dispersion import wavenumber

UNIT = Water(density=1.0, gravity=1.0)
SEA = Water(density=1025.0, gravity=9.81)
AHEAD = np.zeros(1)
KA = (0.1, 1.0, 3.5)
NAMES = ("added_mass", "radiation_damping", "excitation_force")


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def block(problem, omega):
    """What a run stores of a frequency."""
    return _block(problem, *problem.coarser(), {"omega": float(omega), "wave_direction": [0.0]})


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


@pytest.mark.parametrize("amplitude", [0.0, -0.15])
def test_the_estimate_bounds_the_error_of_spheres_and_spheroids_and_goes_with_it(green, amplitude):
    degrees, shell, rows = (0, 1, 2), shell_with(amplitude), np.array([6, 8, 10, 12])
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


def test_the_estimate_bounds_the_error_of_surge_on_triangles(green):
    reference = SpectralProblem(shell_with(0.0), (dofs.Displacement("surge", order=1),), 1.0, 1.0, 48)
    for rows in (6, 8):
        sphere = revolved_body(shell_with(0.0), rows, (0,), 2 * rows)
        cut = np.concatenate([sphere.faces[:, [0, 1, 2, 2]], sphere.faces[:, [0, 2, 3, 3]]])
        x = sphere.vertices[cut]
        faces = cut[np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) > 1e-9]
        body = made(sphere.vertices, faces, rigid(sphere.vertices)[:1], ("Surge",))
        problem = BodyProblem(green, body, UNIT, "none", interior_lid(body, 4))
        estimate, true = estimated_and_true(problem, reference, np.sqrt(KA))
        assert true < estimate < 8 * true, (rows, estimate, true)


def test_at_an_irregular_frequency_only_the_waves_tell_of_the_error(green):
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


def test_units_of_displacements_do_not_matter(green, box):
    found = []
    for scale in (1.0, 1e-3, 1e3):
        shapes = box.shapes * np.array([1.0, scale])[:, None, None]
        problem = BodyProblem(green, made(box.vertices, box.faces, shapes, box.labels), SEA, "xOz+yOz")
        found.append(error_estimate([block(problem, 1.2)], block(problem, np.inf), size_of(problem)))
    assert found == pytest.approx([found[0]] * 3, rel=1e-9)


def test_panels_that_cannot_be_joined_say_nothing_of_their_error(green):
    corners = np.array([[x, y, z] for z in (-1.0, 0.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
    faces = np.array([[3, 2, 1, 0], *([i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4))])
    problem = BodyProblem(green, made(corners, faces, rigid(corners)[2:3], ("Heave",)), SEA)
    assert error_estimate([block(problem, 1.2)], block(problem, np.inf), size_of(problem)) == 1.0


@pytest.mark.parametrize("away", [0.0, 300.0])
def test_a_sweep_solves_few_frequencies_wherever_the_body_lies(green, box, away):
    vertices = box.vertices + np.array([away, 0.0, 0.0])
    problem = BodyProblem(green, made(vertices, box.faces, box.shapes, box.labels), SEA, "xOz")
    omega, directions, blocks = np.linspace(0.5, 2.0, 30).tolist(), np.array([0.0, 0.8]), {}

    def solve(w):
        if w not in blocks:
            blocks[w] = _block(problem, problem, 1.0, {"omega": w, "wave_direction": np.rad2deg(directions).tolist()})
        return blocks[w]

    def froude_krylov(w):
        return problem.froude_krylov(w, directions)

    size = np.sqrt(np.diag(block(problem, np.inf).own.added_mass_inf.values))
    measure = Measure(size, np.array([away, 0.0, -1.0]), directions, SEA)
    found = swept(solve, froude_krylov, omega, 5e-3, measure)
    assert len(blocks) == len(found.solved) < 18
    everything = swept(solve, froude_krylov, omega, None, measure)
    assert len(everything.solved) == 30
    assert everything.error == 0.0
    ours, true = (with_excitation(s.coefficients) for s in (found, everything))
    units = {"excitation_force": size}
    missed = [
        np.abs((ours[n] - true[n]) / units.get(n, np.outer(size, size))).max()
        / np.abs(true[n] / units.get(n, np.outer(size, size))).max()
        for n in NAMES
    ]
    assert max(missed) <= found.error
    assert found.error <= 5e-3
    for each in found.solved:
        assert np.array_equal(ours.added_mass.sel(omega=each.own.omega), each.own.added_mass)


def test_added_mass_that_is_none_is_refused():
    with pytest.raises(DatabaseError, match="added_mass_inf: received a diagonal not above zero"):
        Measure(np.array([1.0, 0.0]), np.zeros(3), AHEAD, SEA)


@pytest.mark.parametrize("labels", [("Surge", "Heave", "Pitch"), ("Surge", "Heave", "Pitch", "Yaw")])
def test_yaw_of_a_round_body_moves_no_water_and_spoils_nothing(green, labels):
    """Its added mass is the round-off of triangles: an error in terms of it says nothing."""
    sphere = revolved_body(shell_with(0.0), 6, (0,), 14)
    cut = np.concatenate([sphere.faces[:, [0, 1, 2, 2]], sphere.faces[:, [0, 2, 3, 3]]])
    x = sphere.vertices[cut]
    faces = cut[np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) > 1e-9]
    motions = dict(zip(("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"), rigid(sphere.vertices), strict=True))
    body = made(sphere.vertices, faces, np.array([motions[label] for label in labels]), labels)
    problem = BodyProblem(green, body, UNIT, "none", interior_lid(body, 4))
    solved, infinite, size = [block(problem, w) for w in (0.5, 1.5)], block(problem, np.inf), size_of(problem)
    assert error_estimate(solved, infinite, size) < 0.5
    assert max(negative_damping(each.own, np.outer(size, size)) for each in solved) < 0.01
    assert max(each.own.attrs[name] for each in solved for name in ("symmetry", "far_field", "haskind")) < 0.1


@pytest.mark.parametrize("count", [13, 14, 15, 20, 27, 31, 39, 40, 41])
def test_coefficients_too_rough_to_be_interpolated_are_all_solved_once(green, box, count):
    problem, solved = BodyProblem(green, box, SEA, "xOz+yOz"), []
    pattern = problem.solve(1.0, AHEAD)
    noise, omega = np.random.default_rng(count), np.linspace(0.5, 2.0, count).tolist()

    def solve(w):
        if w not in (each.own.omega.item() for each in solved):
            rough = pattern.assign_coords(omega=[w]) * (1 + 0.1 * noise.standard_normal())
            solved.append(Block(rough, rough, rough))
        return next(each for each in solved if each.own.omega.item() == w)

    def froude_krylov(w):
        return problem.froude_krylov(w, AHEAD)

    measure = Measure(np.ones(2), np.zeros(3), AHEAD, SEA)
    found = swept(solve, froude_krylov, omega, 1e-4, measure)
    assert sorted(each.own.omega.item() for each in solved) == omega
    assert found.error == 0.0
    assert found.coefficients.omega.values.tolist() == omega


def synthetic(value, omega=(1.0,)):
    """Coefficients of one motion in one direction, all one value."""
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    n, dof = len(omega), {"influenced_dof": ["Heave"], "radiating_dof": ["Heave"]}
    forces = {"Froude_Krylov_force": 0.25, "diffraction_force": 0.75, "excitation_force": 1.0}
    matrices = {name: (pair, np.full((n, 1, 1), value)) for name in ("added_mass", "radiation_damping")}
    return xr.Dataset(
        matrices | {name: (wave, np.full((n, 1, 1), part * value + 0j)) for name, part in forces.items()},
        {"omega": list(omega), "wave_direction": [0.0], **dof},
    )


@pytest.mark.parametrize(
    ("part", "name", "expected"),
    [
        ("fewer", "added_mass", 0.1 / 0.6),
        ("fewer", "radiation_damping", 0.1 / 0.6),
        ("fewer", "excitation_force", 0.1 / 0.6),
        ("infinite", "added_mass_inf", 0.1 / 0.6),
        ("waves", "radiation_damping", 0.1),
        ("waves", "excitation_force", 0.1),
        ("none", "", 0.0),
    ],
)
def test_every_part_of_the_estimate_counts_alone(part, name, expected):
    """A tenth of the largest entry each: what fewer panels change over r - 1, and what both meshes have wrong."""
    own = synthetic(1.0).drop_vars("excitation_force")
    parts = {"fewer": synthetic(1.0), "waves": synthetic(1.0)[["radiation_damping", "excitation_force"]]}
    pair = ("influenced_dof", "radiating_dof")
    limits = [xr.Dataset({"added_mass_inf": (pair, [[1.0]])}) for _ in range(2)]
    limits[0].attrs["resolution_ratio"] = 1.6
    if part == "infinite":
        limits[1] = limits[1] * 0.9
    elif part != "none":
        parts[part] = parts[part].assign({name: 0.9 * parts[part][name]})
    found = error_estimate([Block(own, **parts)], Block(*limits, xr.Dataset()), np.ones(1))
    assert found == pytest.approx(expected, abs=1e-15)


def test_a_body_that_feels_no_waves_has_an_error_of_its_added_mass_alone():
    own = synthetic(0.0).drop_vars("excitation_force").assign(added_mass=synthetic(1.0).added_mass)
    fewer = synthetic(0.0).assign(added_mass=0.9 * synthetic(1.0).added_mass)
    waves = synthetic(0.0)[["radiation_damping", "excitation_force"]]
    limits = [xr.Dataset({"added_mass_inf": (("influenced_dof", "radiating_dof"), [[1.0]])}) for _ in range(2)]
    limits[0].attrs["resolution_ratio"] = 1.6
    found = error_estimate([Block(own, fewer, waves)], Block(*limits, xr.Dataset()), np.ones(1))
    assert found == pytest.approx(0.1 / 0.6, abs=1e-15)


@pytest.mark.parametrize("depth", [5.0, np.inf])
def test_forces_are_measured_in_those_of_a_unit_wave_on_the_surface_over_the_middle(depth):
    """By size, of phase k (x cos b + y sin b), whatever the depth of the middle."""
    omega, beta = np.array([0.8, 1.6]), np.deg2rad([0.0, 60.0, 90.0])
    water, centre, size = Water(depth=depth), np.array([3.0, -2.0, -1.5]), np.array([2.0, 30.0])
    k = np.array([wavenumber(w, depth, water.gravity) for w in omega])
    phase = np.outer(k, 3.0 * np.cos(beta) - 2.0 * np.sin(beta))
    expected = np.exp(1j * phase)[..., None] * size
    np.testing.assert_allclose(Measure(size, centre, beta, water).force(omega), expected, rtol=1e-12)


def test_the_least_size_is_of_all_the_water_moving_like_the_surface(box):
    """Of a unit shift every part of the surface moves by one; three times as much in all directions."""
    shifts = np.stack([rigid(box.vertices)[2], rigid(box.vertices)[:3].sum(axis=0), box.vertices])
    body = made(box.vertices, box.faces, shifts, ("Heave", "All", "Stretch"))
    mean = (body.centres**2).sum(axis=1).mean()
    expected = 0.3 * np.sqrt(1025.0 * 48.0 * np.array([1.0, 3.0, mean]))
    assert least_sizes(body, 1025.0) == pytest.approx(expected, rel=1e-9)


def test_sizes_are_roots_of_added_mass_or_the_least():
    mass = np.array([[4.0, 9.0, 9.0], [9.0, -1.0, 9.0], [9.0, 9.0, 25.0]])
    assert sizes(mass, np.array([1.9, 3.0, 5.1])) == pytest.approx([2.0, 3.0, 5.1])


@pytest.mark.parametrize(
    ("fewer", "waves", "expected"),
    [
        ((0.9, 0.9, 0.9), (0.9, 0.95), 0.1 / 0.6 + 0.15),
        ((0.7, 0.9, 0.9), (0.95, 0.97), 0.3 / 0.6),
        ((0.9, 0.8, 0.9), (1.0, 0.9), 0.2 / 0.6 + 0.1),
        ((0.9, 0.9, 1.3), (1.05, 0.9), 0.3 / 0.6 + 0.15),
    ],
)
@pytest.mark.parametrize("worst", [0, 1, 2])
def test_what_both_meshes_have_wrong_is_added_to_damping_and_excitation_alone(fewer, waves, expected, worst):
    """At one of three frequencies, in terms of the largest entry at another."""
    omega, scale = (1.0, 2.0, 3.0), 4.0
    own = synthetic(1.0, omega).drop_vars("excitation_force")
    own = own.map(lambda v: v * xr.where(own.omega == omega[worst - 1], scale, 1.0)).transpose("omega", ...)
    there = own.omega == omega[worst]
    whole = with_excitation(own)
    names = ("added_mass", "radiation_damping", "excitation_force")
    other = xr.Dataset({n: whole[n] + scale * (f - 1) * there for n, f in zip(names, fewer, strict=True)})
    known = xr.Dataset({n: whole[n] + scale * (f - 1) * there for n, f in zip(names[1:], waves, strict=True)})
    limits = [xr.Dataset({"added_mass_inf": (("influenced_dof", "radiating_dof"), [[1.0]])}) for _ in range(2)]
    limits[0].attrs["resolution_ratio"] = 1.6
    blocks = [Block(*(ds.isel(omega=[i]) for ds in (own, other, known))) for i in range(3)]
    found = error_estimate(blocks, Block(*limits, xr.Dataset()), np.ones(1))
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("ratio", "told"), [(1.19, 1.0), (1.2, 0.5), (2.0, 0.1)])
def test_two_resolutions_say_something_from_a_fifth_apart_on(ratio, told):
    own, fewer = synthetic(1.0).drop_vars("excitation_force"), synthetic(0.9)
    limits = [xr.Dataset({"added_mass_inf": (("influenced_dof", "radiating_dof"), [[1.0]])}) for _ in range(2)]
    limits[0].attrs["resolution_ratio"] = ratio
    waves = synthetic(1.0)[["radiation_damping", "excitation_force"]]
    found = error_estimate([Block(own, fewer, waves)], Block(*limits, xr.Dataset()), np.ones(1))
    assert found == pytest.approx(told, rel=1e-9)


def test_what_is_measured_is_undone_in_all_but_round_off():
    """Two motions of unequal sizes in two directions at two frequencies: matrices by both sizes, forces by waves."""
    omega, beta = [0.8, 1.6], np.deg2rad([30.0, 100.0])
    rng, dof = np.random.default_rng(2), ["Heave", "Pitch"]
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    data = {name: (pair, rng.normal(size=(2, 2, 2))) for name in ("added_mass", "radiation_damping")}
    data |= {
        name: (wave, rng.normal(size=(2, 2, 2)) + 1j * rng.normal(size=(2, 2, 2)))
        for name in ("Froude_Krylov_force", "diffraction_force")
    }
    ds = xr.Dataset(data, {"omega": omega, "wave_direction": beta, "influenced_dof": dof, "radiating_dof": dof})
    measure = Measure(np.array([2.0, 30.0]), np.array([3.0, -2.0, -1.0]), beta, SEA)
    small, back = measure.applied(ds), measure.undone(measure.applied(ds))
    assert small.added_mass.values == pytest.approx(ds.added_mass.values / [[4.0, 60.0], [60.0, 900.0]], rel=1e-12)
    force = measure.force(np.array(omega))
    assert small.diffraction_force.values == pytest.approx(ds.diffraction_force.values / force, rel=1e-12)
    for name in data:
        assert back[name].values == pytest.approx(ds[name].values, rel=1e-12)


def smooth(omega, directions, sizes, centre):
    """Coefficients of two motions that swing slowly with frequency, of bodies of sizes seen from a place, in closed form."""
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


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_what_is_not_solved_is_interpolated_in_units_of_the_body_and_turned_back(tolerance):
    """Sizes of a metre and of a hundred, a body far off the origin: as few solves as the smoothness asks for."""
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


def test_matrices_are_told_by_both_units_of_displacement_and_excitation_by_one():
    """Each by its own, of degrees of freedom unlike in size; what there is not is left out."""
    size = np.array([2.0, 5.0])
    pair, force = np.array([[[1.0, 2.0], [3.0, 4.0]]]), np.array([[[6.0 + 2.0j, 10.0j], [4.0, 5.0]]])
    ds = xr.Dataset({
        "added_mass": (("omega", "i", "j"), pair), "radiation_damping": (("omega", "i", "j"), 10 * pair),
        "excitation_force": (("omega", "b", "i"), force), "Froude_Krylov_force": (("omega", "b", "i"), force),
    })  # fmt: skip
    found = _in_units(ds, size)
    assert sorted(found) == ["added_mass", "excitation_force", "radiation_damping"]
    assert found["added_mass"] == pytest.approx(np.array([[[0.25, 0.2], [0.3, 0.16]]]))
    assert found["radiation_damping"] == pytest.approx(np.array([[[2.5, 2.0], [3.0, 1.6]]]))
    assert found["excitation_force"] == pytest.approx(np.array([[[3.0 + 1.0j, 2.0j], [2.0, 1.0]]]))
    assert sorted(_in_units(ds[["excitation_force"]], size)) == ["excitation_force"]


def test_as_many_solves_as_anywhere_may_be_made_before_a_body_is_held_to_be_rough(monkeypatch):
    """However few the frequencies are: each of a body costs more than all that is interpolated. No phase turns them."""
    asked, unit, centre, directions = [], np.array([1.0, 100.0]), np.array([2.0, -1.0, -3.0]), np.deg2rad([0.0, 70.0])
    omega = [0.4, 0.9, 1.4]

    def solve(w):
        own = smooth([w], directions, unit, centre)
        return Block(own, own, own)

    def on_grid(given, frequencies, tolerance, incident, **more):
        asked.append((frequencies, tolerance, more))
        assert incident.order == 0
        assert incident.phase(np.array(omega)).tolist() == [0.0] * 3
        force = measure.force(np.array(omega))
        assert incident.froude_krylov(np.array(omega)) == pytest.approx(froude_krylov(omega) / force)
        some = given(omega)
        assert some.added_mass.values == pytest.approx(smooth(omega, directions, np.ones(2), centre).added_mass.values)
        return SimpleNamespace(solved=[0.4, 1.4], sweep=SimpleNamespace(error=0.003), coefficients=some)

    def froude_krylov(w):
        return smooth(w, directions, unit, centre).Froude_Krylov_force.values

    measure = Measure(unit, centre, directions, SEA)
    monkeypatch.setattr(bodysweep, "on_grid", on_grid)
    found = swept(solve, froude_krylov, omega, 0.02, measure)
    assert asked == [(omega, 0.02, {"most": MOST_SOLVES})]
    assert found.error == 0.003
    assert [float(block.own.omega[0]) for block in found.solved] == [0.4, 1.4]
    true = smooth(omega, directions, unit, centre)
    for name in ("added_mass", "diffraction_force"):
        np.testing.assert_allclose(found.coefficients[name].values, true[name].values, rtol=1e-12)
