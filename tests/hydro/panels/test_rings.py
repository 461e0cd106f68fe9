import io
import resource
import shutil
from pathlib import Path

import capytaine as cpt
import numpy as np
import pytest

from vsb.engine.hydro import dofs
from vsb.engine.hydro.panels import bem
from vsb.engine.hydro.panels.mesh import deformed_mesh, graded_colatitudes, mean_mesh, polygon_radius, revolved
from vsb.engine.hydro.panels.rings import AxisymmetricProblem, TwoMeshes
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.hydro.sweep import coefficients, largest
from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.water import group_velocity, wavenumber
from vsb.errors import DatabaseError
from vsb.tools.stamps import read_manifest

DEGREES = tuple(range(7))


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def unit_problem(green, rows, *, lid_rows=None, degrees=DEGREES, depth=np.inf):
    """Hemisphere of radius, density and gravity one: omega^2 = Ka."""
    mesh = mean_mesh(1.0, 0.0, rows, 2 * rows, lid_rows or rows // 2)
    return AxisymmetricProblem(green, mesh, dofs.displacements(f"Radial{n}" for n in degrees), 1.0, depth, 1.0)


def errors(result, hemisphere, ka):
    """Errors of A, B and |X| against the multipole series, relative to the largest entry."""
    i = hemisphere["Ka"].index(ka)
    omega = np.sqrt(ka)
    at = result.sel(omega=omega)
    pairs = [
        (at.added_mass.values, hemisphere["added_mass"][i]),
        (at.radiation_damping.values / omega, hemisphere["radiation_damping"][i]),
        (np.abs(at.Froude_Krylov_force + at.diffraction_force).values[0], hemisphere["abs_excitation"][i]),
    ]
    return [np.abs(ours - np.array(exact)).max() / np.abs(exact).max() for ours, exact in pairs]


def test_geometry_of_quadrangles_and_triangles_is_capytaines_own():
    vertices = np.array([[0.0, 0.0, -1.0], [1.0, 0.1, -1.2], [1.1, 1.0, -0.9], [0.1, 1.2, -1.0], [2.0, 1.0, -0.5]])
    faces = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    own = cpt.Mesh(vertices=vertices, faces=faces, auto_clean=False, auto_check=False)
    mesh = bem.panel_mesh(vertices, faces)
    for name in ("faces_areas", "faces_centers", "faces_normals", "faces_radiuses"):
        np.testing.assert_allclose(getattr(mesh, name), getattr(own, name), rtol=1e-14, atol=1e-15, err_msg=name)


def test_quick_table_changes_coefficients_by_a_tenth_of_the_panels_error(green):
    omegas = [float(np.sqrt(ka)) for ka in (0.3, 1.0, 3.0)]
    whole, quick = (unit_problem(one, 20).solve(omegas) for one in (green, bem.quick_green_function()))
    for name in ("added_mass", "radiation_damping", "diffraction_force"):
        assert float(abs(quick[name] - whole[name]).max()) < 3e-4 * float(abs(whole[name]).max()), name


def tampered(content):
    """Another table, whole and of the same name and size."""
    with np.load(io.BytesIO(content)) as table:
        arrays = dict(table)
    arrays["values"] = 1.001 * arrays["values"]
    changed = io.BytesIO()
    np.savez(changed, **arrays)
    return changed.getvalue()


def flipped(content):
    bad = bytearray(content)
    bad[len(bad) // 2] ^= 4
    return bytes(bad)


@pytest.mark.parametrize(("damage", "known"), [(tampered, True), (flipped, False), (tampered, False)])
def test_changed_table_of_the_green_function_is_refused(green_folder, tmp_path, damage, known):
    """A readable table without an entry in the manifest is accepted and added to it."""
    place = tmp_path / "green"
    shutil.copytree(green_folder, place, ignore=None if known else shutil.ignore_patterns("manifest.json"))
    (table,) = place.glob("*.npz")
    table.write_bytes(damage(table.read_bytes()))
    if damage is tampered and not known:
        bem.green_function(place)
        assert [Path(path).name for path in read_manifest(place / "manifest.json")] == [table.name]
        return
    with pytest.raises(DatabaseError, match=r"its contents are not those it was .*; delete the folder .*green and run"):
        bem.green_function(place)


@pytest.mark.parametrize("damaged", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_table_of_the_green_function_is_computed_once_for_all_folders_of_a_machine(
    green_folder, tmp_path, monkeypatch, damaged
):
    """A second folder copies the first one's; one that is damaged is computed anew."""
    monkeypatch.setenv("CAPYTAINE_CACHE_DIR", str(tmp_path / "kept"))
    kept = bem._kept_tables()
    (table,) = green_folder.glob("*.npz")
    (kept / table.name).write_bytes(flipped(table.read_bytes()) if damaged else table.read_bytes())
    computed = []
    compute = bem.cpt.Delhommeau._create_tabulation
    monkeypatch.setattr(bem.cpt.Delhommeau, "_create_tabulation", lambda *a: (computed.append(1), compute(*a))[1])
    bem.stored_green_function(tmp_path / "results" / "green")
    assert len(computed) == damaged
    assert [file.name for file in (tmp_path / "results" / "green").glob("*.npz")] == [table.name]


def test_table_that_finds_no_space_is_one_line(green_folder, tmp_path, monkeypatch):
    """As on a full disk: files may not be longer than 64 kB."""
    monkeypatch.setenv("CAPYTAINE_CACHE_DIR", str(tmp_path / "kept"))
    (table,) = green_folder.glob("*.npz")
    with np.load(table) as held:  # computing it takes 16 s
        known = {f"tabulated_{'integrals' if name == 'values' else name}": held[name] for name in held}
    monkeypatch.setattr(bem.cpt.Delhommeau, "_create_tabulation", lambda own, *size: vars(own).update(known))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**16, hard))
    try:
        with pytest.raises(DatabaseError, match=r"results/green: cannot be written \(.*\); needs space in a folder"):
            bem.stored_green_function(tmp_path / "results" / "green")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list((tmp_path / "results").iterdir())


@pytest.fixture(scope="module")
def tabulation():
    """Capytaine's computation of a table, of each size once."""
    compute, known = bem.cpt.Delhommeau._create_tabulation, {}

    def computed(own, *size):
        if size not in known:
            compute(own, *size)
            known[size] = {name: value for name, value in vars(own).items() if name.startswith("tabulated")}
        vars(own).update(known[size])

    return computed


@pytest.mark.parametrize("writable", [True, False])
def test_table_of_the_cross_check_is_computed_once_on_a_machine(tmp_path, monkeypatch, writable, tabulation):
    """Or each time where none can be kept; the one kept gives the same influences."""
    monkeypatch.setenv("CAPYTAINE_CACHE_DIR", str(tmp_path / "kept"))
    if not writable:
        (bem._kept_tables() / "quick").write_text("a file, no folder", encoding="utf-8")
    computed = []
    monkeypatch.setattr(bem.cpt.Delhommeau, "_create_tabulation", lambda *a: (computed.append(1), tabulation(*a))[1])
    first, second = (bem.quick_green_function.__wrapped__() for _ in range(2))
    assert len(computed) == 2 - writable
    np.testing.assert_array_equal(first.tabulated_integrals, second.tabulated_integrals)
    assert not bem.is_table_kept()  # of panels


def test_coefficients_of_the_hemisphere_at_the_default_resolution(green, hemisphere):
    ka = [k for k in hemisphere["Ka"] if k <= 6]
    result = unit_problem(green, 40).solve([float(np.sqrt(k)) for k in ka])
    worst = np.array([errors(result, hemisphere, k) for k in ka]).max(axis=0)
    assert worst[0] < 2e-3, worst  # added mass
    assert worst[1] < 5e-3, worst  # damping
    assert worst[2] < 6e-3, worst  # excitation


def errors_at_infinity(green, hemisphere, rows, degrees=(0, 1, 2, 3)):
    exact = np.array(hemisphere["added_mass_infinite_frequency"])[np.ix_(degrees, degrees)]
    return [np.abs(unit_problem(green, n, degrees=degrees).added_mass_inf() - exact).max() for n in rows]


def test_flat_panels_converge_at_first_order_and_the_flux_correction_at_second(green, hemisphere, monkeypatch):
    rows = np.array([8, 12, 16, 24])
    corrected = errors_at_infinity(green, hemisphere, rows)
    monkeypatch.setattr(bem.SymmetricPanels, "correction", property(lambda self: np.zeros(self.part.nb_faces)))
    flat = errors_at_infinity(green, hemisphere, rows)
    slopes = [-np.diff(np.log(e)) / np.diff(np.log(rows)) for e in (corrected, flat)]
    assert np.all(np.abs(slopes[1] - 1.0) < 0.1), slopes
    # two errors of opposite sign share the corrected one: single slopes vary, their mean is two
    assert abs(np.log(corrected[0] / corrected[-1]) / np.log(rows[-1] / rows[0]) - 2.0) < 0.15, slopes
    assert corrected[-1] < flat[-1] / 10


def test_damping_is_smooth_across_irregular_frequencies_and_resonances_of_the_lid(green):
    for band in (np.linspace(1.15, 1.40, 11), np.linspace(2.45, 2.67, 11)):  # lid with upward normals; Ka = 2.5573
        damping = unit_problem(green, 20, degrees=(0, 1)).solve([float(np.sqrt(k)) for k in band]).radiation_damping
        for n in (0, 1):
            b = damping.values[:, n, n]
            assert np.abs(np.diff(b, 3)).max() < 2e-4 * b.max(), band


def test_added_mass_at_infinite_frequency_in_finite_depth(green):
    deep, near, far = (
        unit_problem(green, 20, degrees=(1,), depth=d).added_mass_inf().item() for d in (np.inf, 2.0, 40.0)
    )
    assert far == pytest.approx(deep, rel=1e-3)
    assert near > 1.01 * deep  # the bottom confines the flow


def order_problem(green, rows, displacements, order, *, azimuth=None, depth=np.inf):
    """Hemisphere of radius, density and gravity one."""
    mesh = mean_mesh(1.0, 0.0, rows, azimuth or 2 * rows, rows // 2)
    return AxisymmetricProblem(green, mesh, dofs.displacements(displacements, order), 1.0, depth, 1.0)


def full_mesh(wedge, azimuth):
    return cpt.Mesh.join_meshes(*[wedge.rotated_z(2 * np.pi * i / azimuth) for i in range(azimuth)])


def capytaines_own(green, problem, omega):
    """The same panels, every one an unknown, rigid motions as capytaine defines them."""
    rings, n = problem.rings(with_lid=True), problem.mesh.attrs["azimuth"]
    lid = full_mesh(rings.part.extract_faces(np.flatnonzero(~rings.of_body)), n)
    mesh = full_mesh(problem.body.part, n)
    theta = 2 * np.pi * np.repeat(np.arange(n), problem.body.part.nb_faces) / n
    along = np.tile(problem.velocities, n) * np.cos(problem.order * theta)
    moved = {d.label: w[:, None] * mesh.faces_normals for d, w in zip(problem.displacements, along, strict=True)}
    if problem.order == 1:
        x, z = mesh.faces_centers[:, 0], mesh.faces_centers[:, 2]
        moved["Surge"] = np.tile([1.0, 0.0, 0.0], (mesh.nb_faces, 1))
        moved["Pitch"] = np.column_stack([z, 0 * x, -x])
    name = f"order {problem.order} {n} {problem.depth}"
    body = cpt.FloatingBody(mesh=mesh, lid_mesh=lid, dofs=moved, name=name)
    water = {"omega": omega, "water_depth": problem.depth, "rho": 1.0, "g": 1.0}
    cases = [cpt.RadiationProblem(body=body, radiating_dof=d, **water) for d in moved]
    cases.append(cpt.DiffractionProblem(body=body, wave_direction=0.0, **water))
    solver = cpt.BEMSolver(green_function=green, method="indirect")
    names = [each.label for each in problem.displacements]
    solved = cpt.assemble_dataset([solver.solve(case) for case in cases])
    return solved.sel(influenced_dof=names, radiating_dof=names)


@pytest.mark.parametrize(
    ("order", "displacements", "azimuth", "depth"),
    [
        (0, ("Radial0", "Radial1", "Radial4"), 12, np.inf),
        (1, ("Surge", "Pitch", "Radial2", "Meridional2"), 13, np.inf),
        (2, ("Radial2", "Radial3"), 12, 3.0),
    ],
)
def test_every_order_equals_capytaines_full_solution_to_round_off(
    green, order, displacements, azimuth, depth, monkeypatch
):
    monkeypatch.setattr(bem.SymmetricPanels, "correction", property(lambda self: np.zeros(self.part.nb_faces)))
    around = azimuth if order else azimuth + 8  # the mean of the wave around is exact, capytaine's is aliased
    mesh = mean_mesh(1.0, 0.2, 5, around, 2)
    problem = AxisymmetricProblem(green, mesh, dofs.displacements(displacements, order), 1.0, depth, 1.0)
    ours, theirs = problem.solve([1.1]), capytaines_own(green, problem, 1.1)
    for name in ours:
        expected = theirs[name].transpose(*ours[name].dims).values
        size = np.abs(expected).max()
        if name == "radiation_damping":  # next to nothing at high orders: round-off is that of the added mass
            size = max(size, np.abs(theirs.added_mass.values).max())
        assert np.abs(ours[name].values - expected).max() < 1e-11 * size, name


@pytest.mark.parametrize(
    ("order", "names", "depth"), [(1, ("Surge", "Radial2"), 3.0), (2, ("Radial2", "Radial3"), np.inf)]
)
def test_haskind_of_every_order(green, order, names, depth):
    """B = k X X^H/(8 pi rho g c_g) int cos^2(m beta) d beta: half that of order zero."""
    omega = 1.0
    result = order_problem(green, 24, names, order, depth=depth).solve([omega])
    x = (result.Froude_Krylov_force + result.diffraction_force).values[0, 0]
    k = wavenumber(omega, depth, 1.0)
    haskind = k * np.outer(x, x.conj()) / (8 * group_velocity(omega, depth, 1.0))
    b = result.radiation_damping.values[0]
    assert np.abs(haskind - b).max() < (2e-3 if np.isinf(depth) else 2e-2) * b.max()


@pytest.mark.slow
@pytest.mark.parametrize(("order", "names"), [(1, ("Surge", "Radial2"))])
def test_every_order_converges_to_the_solver_without_panels(green, order, names):
    """At second order so far, from the flux correction; with the phases of excitation."""
    omegas = [0.6, 1.0, 1.6]
    exact = SpectralProblem(rigid_sphere(1.0, -0.2), dofs.displacements(names, order), 1.0, 1.0, 32).solve(omegas)
    errors = []
    for rows in (10, 14, 20, 28):
        mesh = mean_mesh(1.0, -0.2, rows, 2 * rows, rows // 2)
        found = AxisymmetricProblem(green, mesh, dofs.displacements(names, order), 1.0, np.inf, 1.0).solve(omegas)
        errors.append([float(np.abs(found[name] - exact[name]).max() / np.abs(exact[name]).max()) for name in exact])
    slopes = np.log(np.array(errors[0]) / errors[-1]) / np.log(2.8)
    assert np.all((slopes > 1.5) & (slopes < 2.2)), slopes
    assert np.max(errors[-1]) < 6e-3, errors


LEGENDRE = dofs.displacements(f"Radial{n}" for n in range(5))
LOW = [round(0.1 * i, 10) for i in range(1, 33)]
FROM_KD = [w for w in LOW if w >= 0.7]  # kd > 0.3
HIGH = [round(0.1 * i, 10) for i in range(65, 97)]
SCENES = {
    "hemisphere": (0.0, LEGENDRE, np.inf, LOW),
    "low": (-0.8, LEGENDRE, np.inf, LOW),
    "short waves": (-0.8, LEGENDRE, np.inf, HIGH),
    "near the bottom": (0.0, LEGENDRE, 2.2, FROM_KD),
}


def meshes(green, rows, height=0.0, displacements=LEGENDRE, depth=np.inf, density=1025.0):
    """The sphere of radius 2 m with its centre at a height, and an undemanding lid."""

    def problem(part):
        mesh = deformed_mesh(rigid_sphere(2.0, height), rows // part, 2 * rows // part, 16 // part)
        return AxisymmetricProblem(green, mesh, displacements, density, depth, 9.81)

    return TwoMeshes(problem(1), problem(2))


def true_error(two, found):
    """Against the spectral solver, in terms of the largest entries that the estimate knows."""
    p, height = two.fine, 2.0 + float(two.fine.mesh.meridian_height.min())
    exact = SpectralProblem(rigid_sphere(2.0, height), p.displacements, p.density, 9.81, 48, depth=p.depth)
    reference = exact.solve(found.omega.values.tolist())
    sizes = largest(reference, two.strongest)
    pairs = zip(coefficients(found), coefficients(reference), sizes, strict=True)
    return max(float(np.abs(a - b).max()) / size for a, b, size in pairs)


@pytest.mark.parametrize("scene", ["hemisphere", "low", "short waves", "near the bottom"])
def test_the_estimate_bounds_the_error_of_panels_and_interpolation(green, scene):
    *shape, frequencies = SCENES[scene]
    two = meshes(green, 12, *shape)
    found = two.solve(frequencies, 5e-4)
    estimate, error = found.attrs["error_estimate"], true_error(two, found)
    assert error <= estimate
    assert estimate <= (50 if scene == "short waves" else 8) * error


@pytest.mark.parametrize("depth", [np.inf, 4.0])
def test_the_estimate_at_infinite_frequency_bounds_the_error(green, depth):
    errors = []
    for rows in (12, 20):
        two = meshes(green, rows, depth=depth)
        exact = SpectralProblem(rigid_sphere(2.0, 0.0), LEGENDRE, 1025.0, 9.81, 48, depth=depth).at_infinity()
        found = two.at_infinity()
        errors.append(np.abs(found.added_mass_inf.values - exact).max() / np.abs(exact).max())
        assert errors[-1] <= found.attrs["error_estimate"] <= 10 * errors[-1]
    assert errors[0] > errors[1]


def test_in_deep_water_few_frequencies_are_solved(green):
    *shape, frequencies = SCENES["short waves"]
    two = meshes(green, 20, *shape)
    found = two.solve(frequencies, 5e-4)
    assert found.attrs["frequencies"] == len(frequencies) == found.sizes["omega"]
    assert found.attrs["solves"] <= 13
    direct = two.solve(frequencies)
    assert direct.attrs["solves"] == len(frequencies)
    sizes = largest(direct, two.strongest)
    pairs = zip(coefficients(found), coefficients(direct), sizes, strict=True)
    assert max(np.abs(a - b).max() / size for a, b, size in pairs) <= direct.attrs["error_estimate"] / 2


def panel_area(vertices, faces):
    a, b, c, d = (vertices[faces[:, i]] for i in range(4))
    return 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)


def enclosed_volume(vertices, faces):
    """Volume below z = 0 by the divergence theorem on two triangles per panel; positive for outward normals."""
    a, b, c, d = (vertices[faces[:, i]] for i in range(4))
    return sum(np.einsum("ij,ij->i", p, np.cross(q, r)).sum() for p, q, r in ((a, b, c), (a, c, d))) / 6


@pytest.mark.parametrize("height", [-0.6, 0.0, 0.9])
def test_area_and_volume_of_the_mean_mesh_converge_at_second_order(height):
    depth, rows = 2.0 - height, np.array([20, 40, 80, 160, 320])
    exact = np.array([2 * np.pi * 2.0 * depth, np.pi * depth**2 * (6.0 - depth) / 3])
    errors = []
    for n in rows:
        mesh = mean_mesh(2.0, height, n, 2 * n, 8)
        vertices, faces = revolved(mesh.meridian_radius.values, mesh.meridian_height.values, 2 * n)
        assert (vertices.shape, faces.shape) == (((n + 1) * 2 * n, 3), (n * 2 * n, 4))
        found = np.array([panel_area(vertices, faces).sum(), enclosed_volume(vertices, faces)])
        errors.append(np.abs(found / exact - 1))
    slopes = -np.diff(np.log(errors), axis=0) / np.diff(np.log(rows))[:, None]
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


def test_normals_of_a_deformed_shell_are_across_its_meridian_into_the_water(seed):
    """By the chord from row to row, to second order; lid, azimuth and colatitudes are as of the sphere."""
    shell = DeformedShell(mode_basis(seed.device, "full", 4), 0.3, np.array([0.0, 0.1, 0, 0.05, 0, 0, -0.1, 0, 0]))
    mesh = deformed_mesh(shell, 60, 24, 5)
    chord = np.diff([mesh.meridian_radius / polygon_radius(24), mesh.meridian_height], axis=1)
    across = np.array([-chord[1], chord[0]]) / np.hypot(*chord)
    assert np.array([mesh.normal_radius, mesh.normal_height]) == pytest.approx(across, abs=5e-3)
    edges = graded_colatitudes(shell.waterline, 60)
    assert mesh.row_colatitude.values == pytest.approx((edges[1:] + edges[:-1]) / 2)
    tangent = shell.meridian(mesh.row_colatitude.values)
    along = mesh.normal_radius.values * tangent.dx + mesh.normal_height.values * tangent.dz
    assert along == pytest.approx(np.zeros(60), abs=1e-13)
    assert np.hypot(mesh.normal_radius, mesh.normal_height).values == pytest.approx(np.ones(60), rel=1e-14)
    assert mesh.lid_radius.values == pytest.approx(np.linspace(0, mesh.meridian_radius.values[0], 6))
    assert (mesh.meridian_height.values[0], mesh.meridian_radius.values[-1]) == (0.0, 0.0)
