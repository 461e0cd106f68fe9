import io
import os
import shutil
import subprocess
import sys
from math import factorial
from pathlib import Path

import capytaine as cpt
import numpy as np
import pytest
from scipy.special import eval_legendre, legendre_p_all

from vsb.errors import DatabaseError
from vsb.hydro import dofs
from vsb.hydro.bodies.solver import unit_wave, unit_wave_slope
from vsb.hydro.panels import rings as bem
from vsb.hydro.panels.mesh import mean_mesh
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.shell.deformed import rigid_sphere
from vsb.tools.stamps import read_manifest
from vsb.waves.dispersion import group_velocity

DEGREES = tuple(range(7))


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def unit_problem(green, rows, *, lid_rows=None, degrees=DEGREES, depth=np.inf):
    """Hemisphere of radius, density and gravity one: omega^2 = Ka."""
    mesh = mean_mesh(1.0, 0.0, rows, 2 * rows, lid_rows or rows // 2)
    return bem.AxisymmetricProblem(green, mesh, dofs.displacements(f"Radial{n}" for n in degrees), 1.0, depth, 1.0)


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


def tampered(content):
    """Another table, whole and of the same name and size."""
    with np.load(io.BytesIO(content)) as table:
        arrays = dict(table)
    arrays["values"] = 1.001 * arrays["values"]
    changed = io.BytesIO()
    np.savez_compressed(changed, **arrays)
    return changed.getvalue()


def flipped(content):
    bad = bytearray(content)
    bad[len(bad) // 2] ^= 4
    return bytes(bad)


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("damage", [tampered, flipped])
def test_a_table_that_is_not_the_one_written_is_one_line(green_folder, tmp_path, damage, known):
    """But for another one put where none was known: of before the stamps, it is taken for what it is and stamped."""
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


def test_rings_equal_capytaines_full_solution_to_round_off(green):
    azimuth, ka = 12, 1.3
    rings = bem.ring_mesh(mean_mesh(1.0, 0.0, 6, azimuth, 3), with_lid=False)
    wedge = rings.wedge
    full = cpt.Mesh.join_meshes(*[wedge.rotated_z(2 * np.pi * i / azimuth) for i in range(azimuth)])
    assert full.nb_faces == azimuth * rings.rows
    mu = full.faces_centers[:, 2] / np.linalg.norm(full.faces_centers, axis=1)
    velocity = eval_legendre(2, mu)
    body = cpt.FloatingBody(mesh=full, dofs={"P2": velocity[:, None] * full.faces_normals}, name="ring test")
    problem = cpt.RadiationProblem(body=body, radiating_dof="P2", wavenumber=ka, rho=1.0, g=1.0)
    result = cpt.BEMSolver(green_function=green, method="indirect").solve(problem)
    s, d = bem.ring_matrices(green, rings, ka)
    force = -rings.areas * velocity[: rings.rows] @ (s @ np.linalg.solve(d, velocity[: rings.rows]))
    assert force.real == pytest.approx(result.added_masses["P2"], rel=1e-10)
    assert np.sqrt(ka) * force.imag == pytest.approx(result.radiation_dampings["P2"], rel=1e-10)


def test_coefficients_of_the_hemisphere_at_the_default_resolution(green, hemisphere):
    ka = [k for k in hemisphere["Ka"] if k <= 6]
    result = unit_problem(green, 40).solve([float(np.sqrt(k)) for k in ka])
    worst = np.array([errors(result, hemisphere, k) for k in ka]).max(axis=0)
    assert worst[0] < 2e-3, worst  # added mass
    assert worst[1] < 5e-3, worst  # damping
    assert worst[2] < 6e-3, worst  # excitation


@pytest.mark.parametrize(
    ("ka", "added_mass", "damping"), [(0.1, 0.8627, 0.1816), (0.3, 0.7157, 0.3254), (1.0, 0.4284, 0.2484)]
)
def test_heave_of_the_hemisphere_after_hulme_1982(green, ka, added_mass, damping):
    result = unit_problem(green, 40, degrees=(1,)).solve([float(np.sqrt(ka))])
    volume = 2 * np.pi / 3
    assert result.added_mass.item() / volume == pytest.approx(added_mass, abs=1e-3)
    assert result.radiation_damping.item() / volume / np.sqrt(ka) == pytest.approx(damping, abs=1e-3)


def errors_at_infinity(green, hemisphere, rows, degrees=(0, 1, 2, 3)):
    exact = np.array(hemisphere["added_mass_infinite_frequency"])[np.ix_(degrees, degrees)]
    return [np.abs(unit_problem(green, n, degrees=degrees).at_infinity() - exact).max() for n in rows]


def test_flat_panels_converge_at_first_order_and_the_flux_correction_at_second(green, hemisphere, monkeypatch):
    rows = np.array([8, 12, 16, 24])
    corrected = errors_at_infinity(green, hemisphere, rows)
    monkeypatch.setattr(bem, "flux_correction", lambda green, rings: np.zeros(rings.rows))
    flat = errors_at_infinity(green, hemisphere, rows)
    slopes = [-np.diff(np.log(e)) / np.diff(np.log(rows)) for e in (corrected, flat)]
    assert np.all(np.abs(slopes[1] - 1.0) < 0.1), slopes
    # two errors of opposite sign share the corrected one: single slopes vary, their mean is two
    assert abs(np.log(corrected[0] / corrected[-1]) / np.log(rows[-1] / rows[0]) - 2.0) < 0.15, slopes
    assert corrected[-1] < flat[-1] / 10


def test_added_mass_at_infinite_frequency(green, hemisphere):
    exact = np.array(hemisphere["added_mass_infinite_frequency"])
    assert np.abs(unit_problem(green, 40).at_infinity() - exact).max() < 1e-3 * np.abs(exact).max()


def test_damping_is_smooth_across_irregular_frequencies_and_the_lids_own_band(green):
    for band in (np.linspace(1.15, 1.40, 11), np.linspace(2.45, 2.67, 11)):  # lid with upward normals; Ka = 2.5573
        damping = unit_problem(green, 20, degrees=(0, 1)).solve([float(np.sqrt(k)) for k in band]).radiation_damping
        for n in (0, 1):
            b = damping.values[:, n, n]
            assert np.abs(np.diff(b, 3)).max() < 2e-4 * b.max(), band


def test_without_lid_the_irregular_frequency_is_there(green):
    problem = unit_problem(green, 20, degrees=(1,))
    rings = bem.ring_mesh(problem.mesh, with_lid=False)
    conditions = [np.linalg.cond(bem.ring_matrices(green, rings, k)[1]) for k in (2.3, 2.5573, 2.8)]
    assert conditions[1] > 5 * max(conditions[0], conditions[2])


def test_lid_covers_the_waterplane_and_faces_down(green):
    rings = bem.ring_mesh(mean_mesh(2.0, 0.5, 10, 20, 7))
    lid = slice(rings.body_rows, None)
    assert rings.azimuth * rings.wedge.faces_areas[lid].sum() == pytest.approx(np.pi * (2.0**2 - 0.5**2), rel=1e-12)
    assert np.all(rings.wedge.faces_normals[lid, 2] < 0)
    assert np.all(rings.wedge.faces_normals[: rings.body_rows, 2] < 0)


@pytest.mark.parametrize("ka", [0.3, 1.0, 3.0])
def test_haskind_rank_one_and_common_phase(green, ka):
    omega = float(np.sqrt(ka))
    result = unit_problem(green, 40).solve([omega])
    x = (result.Froude_Krylov_force + result.diffraction_force).values[0, 0]
    b = result.radiation_damping.values[0]
    haskind = ka * np.outer(x, x.conj()) / (4 * group_velocity(omega, np.inf, 1.0))
    assert np.abs(haskind - b).max() < 1e-3 * b.max()
    eigenvalues = np.sort(np.abs(np.linalg.eigvalsh(b + b.T)))
    assert eigenvalues[-2] < 1e-3 * eigenvalues[-1]


def test_finite_depth_tends_to_deep_water(green):
    deep = unit_problem(green, 10, degrees=(1,)).solve([1.0])
    differences = [
        abs(unit_problem(green, 10, degrees=(1,), depth=depth).solve([1.0]).added_mass.item() - deep.added_mass.item())
        for depth in (3.0, 8.0, 30.0)
    ]
    assert differences[0] > differences[1] > differences[2]
    assert differences[2] < 1e-3 * deep.added_mass.item()


def test_added_mass_at_infinite_frequency_in_finite_depth(green):
    deep, near, far = (unit_problem(green, 20, degrees=(1,), depth=d).at_infinity().item() for d in (np.inf, 2.0, 40.0))
    assert far == pytest.approx(deep, rel=1e-3)
    assert near > 1.01 * deep  # the bottom confines the flow


def test_haskind_holds_in_finite_depth(green):
    omega, depth = 1.0, 3.0
    problem = unit_problem(green, 20, degrees=(0, 1), depth=depth)
    result = problem.solve([omega])
    x = (result.Froude_Krylov_force + result.diffraction_force).values[0, 0]
    k = bem.wavenumber(omega, depth, 1.0)
    haskind = k * np.abs(x) ** 2 / (4 * group_velocity(omega, depth, 1.0))
    assert haskind == pytest.approx(np.diag(result.radiation_damping.values[0]), rel=2e-2)


def order_problem(green, rows, displacements, order, *, azimuth=None, depth=np.inf):
    """Hemisphere of radius, density and gravity one."""
    mesh = mean_mesh(1.0, 0.0, rows, azimuth or 2 * rows, rows // 2)
    return bem.AxisymmetricProblem(green, mesh, dofs.displacements(displacements, order), 1.0, depth, 1.0)


class Plain(bem.AxisymmetricProblem):
    """Capytaine's own diagonal."""

    def correction(self, rings):
        return np.zeros(rings.rows)


def full_mesh(wedge, azimuth):
    return cpt.Mesh.join_meshes(*[wedge.rotated_z(2 * np.pi * i / azimuth) for i in range(azimuth)])


def capytaines_own(green, problem, omega):
    """The same panels, every one an unknown, rigid motions as capytaine defines them."""
    rings, n = bem.ring_mesh(problem.mesh), problem.mesh.attrs["azimuth"]
    lid = full_mesh(rings.wedge.extract_faces(np.arange(rings.body_rows, rings.rows)), n)
    mesh = full_mesh(problem.body.wedge, n)
    theta = 2 * np.pi * np.repeat(np.arange(n), rings.body_rows) / n
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


@pytest.mark.parametrize("depth", [np.inf, 3.0])
@pytest.mark.parametrize("azimuth", [12, 13])
@pytest.mark.parametrize(
    ("order", "displacements"),
    [
        (0, ("Radial0", "Radial1", "Radial4")),
        (1, ("Surge", "Pitch", "Radial2", "Meridional2")),
        (2, ("Radial2", "Radial3")),
        (5, ("Radial5", "Radial6")),
    ],
)
def test_every_order_equals_capytaines_full_solution_to_round_off(green, order, displacements, azimuth, depth):
    around = azimuth if order else azimuth + 8  # the mean of the wave around is exact, capytaine's is aliased
    mesh = mean_mesh(1.0, 0.2, 5, around, 2)
    problem = Plain(green, mesh, dofs.displacements(displacements, order), 1.0, depth, 1.0)
    ours, theirs = problem.solve([1.1]), capytaines_own(green, problem, 1.1)
    for name in ours:
        expected = theirs[name].transpose(*ours[name].dims).values
        size = np.abs(expected).max()
        if name == "radiation_damping":  # next to nothing at high orders: round-off is that of the added mass
            size = max(size, np.abs(theirs.added_mass.values).max())
        assert np.abs(ours[name].values - expected).max() < 1e-11 * size, name


def exact_at_infinity(n, m):
    """Added mass of P_n^m, n - m odd: one multipole, pi (n + m)!/((n - m)! (2n + 1)(n + 1)); orders m > 0."""
    return np.pi * factorial(n + m) / (factorial(n - m) * (2 * n + 1) * (n + 1))


@pytest.mark.parametrize(("degree", "order"), [(2, 1), (4, 3)])
def test_flux_correction_takes_most_of_the_first_order_error_from_every_order(green, degree, order):
    rows = np.array([20, 28, 40, 56])
    meshes = [mean_mesh(1.0, 0.0, n, 2 * n, 1) for n in rows]
    plain, corrected = (
        [
            kind(green, mesh, (dofs.Displacement("radial", degree, order),), 1.0, np.inf, 1.0).at_infinity().item()
            for mesh in meshes
        ]
        / np.array(exact_at_infinity(degree, order))
        - 1
        for kind in (Plain, bem.AxisymmetricProblem)
    )
    slopes = -np.diff(np.log(plain)) / np.diff(np.log(rows))
    assert np.all(np.abs(slopes - 1.0) < 0.22), slopes
    assert np.all(np.abs(corrected[1:]) < plain[1:] / 7), (plain, corrected)
    assert np.all(np.abs(corrected[-2:]) < plain[-2:] / 10), (plain, corrected)


def surge_at_infinity():
    """Multipoles P_n^1, n even: pi sum <sin, P_n^1>^2/((n + 1) N_n), N_n = n (n + 1)/(2n + 1), over the half sphere."""
    node, weight = np.polynomial.legendre.leggauss(400)
    mu, weight = (node + 1) / 2, weight / 2
    p = legendre_p_all(300, mu, diff_n=1)[1][2::2] * np.sqrt(1 - mu**2)
    n = np.arange(2, 301, 2)
    terms = np.pi * (p @ (weight * np.sqrt(1 - mu**2))) ** 2 * (2 * n + 1) / (n * (n + 1) ** 2)
    return terms.sum()


def test_surge_of_the_hemisphere_at_infinite_and_vanishing_frequency(green):
    volume = 2 * np.pi / 3
    assert surge_at_infinity() / volume == pytest.approx(0.2732, abs=5e-5)  # Hulme (1982)
    problem = order_problem(green, 20, ("Surge",), 1)
    assert problem.at_infinity().item() == pytest.approx(surge_at_infinity(), rel=1e-3)
    still = problem.solve([0.03])  # a wall at z = 0: half a sphere in unbounded water
    assert still.added_mass.item() / volume == pytest.approx(0.5, rel=2e-3)


@pytest.mark.parametrize(("order", "names"), [(1, ("Surge", "Radial2")), (2, ("Radial2", "Radial3"))])
@pytest.mark.parametrize("depth", [np.inf, 3.0])
def test_haskind_of_every_order(green, order, names, depth):
    """B = k X X^H/(8 pi rho g c_g) int cos^2(m beta) d beta: half that of order zero."""
    omega = 1.0
    result = order_problem(green, 24, names, order, depth=depth).solve([omega])
    x = (result.Froude_Krylov_force + result.diffraction_force).values[0, 0]
    k = bem.wavenumber(omega, depth, 1.0)
    haskind = k * np.outer(x, x.conj()) / (8 * group_velocity(omega, depth, 1.0))
    b = result.radiation_damping.values[0]
    assert np.abs(haskind - b).max() < (2e-3 if np.isinf(depth) else 2e-2) * b.max()


@pytest.mark.parametrize(("order", "names"), [(1, ("Surge", "Radial2", "Radial3")), (2, ("Radial2", "Radial3"))])
def test_every_order_converges_to_the_solver_without_panels(green, order, names):
    """At second order so far, from the flux correction; with the phases of excitation."""
    omegas = [0.6, 1.0, 1.6]
    exact = SpectralProblem(rigid_sphere(1.0, -0.2), dofs.displacements(names, order), 1.0, 1.0, 32).solve(omegas)
    errors = []
    for rows in (10, 14, 20, 28):
        mesh = mean_mesh(1.0, -0.2, rows, 2 * rows, rows // 2)
        found = bem.AxisymmetricProblem(green, mesh, dofs.displacements(names, order), 1.0, np.inf, 1.0).solve(omegas)
        errors.append([float(np.abs(found[name] - exact[name]).max() / np.abs(exact[name]).max()) for name in exact])
    slopes = np.log(np.array(errors[0]) / errors[-1]) / np.log(2.8)
    assert np.all((slopes > 1.5) & (slopes < 2.2)), slopes
    assert np.max(errors[-1]) < 6e-3, errors


def patch_of_panels():
    """Three unequal rectangles in the quarter x, y > 0, under water; vertices and faces."""
    right = [[1.0, 0.2, -0.2], [1.0, 0.9, -0.2], [1.0, 0.9, -0.8], [1.0, 0.2, -0.8]]
    under = [[0.3, 0.3, -1.0], [0.9, 0.3, -1.0], [0.9, 0.8, -1.0], [0.3, 0.8, -1.0]]
    behind = [[0.2, 1.1, -0.3], [0.7, 1.1, -0.3], [0.7, 1.1, -0.6], [0.2, 1.1, -0.6]]
    return np.array([*right, *under, *behind]), np.arange(12).reshape(3, 4)


@pytest.mark.parametrize("planes", [(), ("xOz",), ("yOz",), ("xOz", "yOz")])
def test_a_mesh_is_mirrored_in_every_plane_it_says_and_nothing_is_reordered(planes):
    vertices, faces = patch_of_panels()
    mesh = bem.panel_mesh(vertices, faces, planes)
    centres = mesh.faces_centers if not planes else mesh.merged().faces_centers
    own = bem.panel_mesh(vertices, faces).faces_centers
    assert len(centres) == 3 * 2 ** len(planes)
    np.testing.assert_allclose(own, vertices[faces].mean(axis=1))
    np.testing.assert_allclose(centres[:3], own)
    signs = {(1.0, 1.0)}
    for plane in planes:
        signs |= {(sx * (-1.0 if plane == "yOz" else 1.0), sy * (-1.0 if plane == "xOz" else 1.0)) for sx, sy in signs}
    expected = np.concatenate([own * [*sign, 1.0] for sign in signs])
    assert sorted(map(tuple, centres.round(9))) == sorted(map(tuple, expected.round(9)))


@pytest.mark.parametrize("depth", [np.inf, 2.5])
@pytest.mark.parametrize(("order", "names"), [(0, ("Heave",)), (1, ("Surge",)), (3, ("Radial3",))])
def test_of_an_undisturbed_wave_rings_see_what_panels_around_see_of_their_order(depth, order, names):
    """Potential and normal velocity, by the wave over general panels; of order 0 the mean, by more points around."""
    problem = bem.AxisymmetricProblem(
        "green", mean_mesh(1.5, 0.2, 4, 12, 0), dofs.displacements(names, order), 7.0, depth, 2.0
    )
    rings, omega, ahead = problem.body, 1.6, np.zeros(1)
    theta = 2 * np.pi * np.arange(12 if order else 96) / (12 if order else 96)
    weight = (2 if order else 1) * np.cos(order * theta) / len(theta)
    k, (x, z) = bem.wavenumber(omega, depth, 2.0), rings.centres
    n_x, _, n_z = rings.wedge.faces_normals.T

    def around(radial, upright):
        return np.array(
            [[r * np.cos(theta), r * np.sin(theta), 0 * theta + u] for r, u in zip(radial, upright, strict=True)]
        )

    at, normals = around(x, z).swapaxes(1, 2).reshape(-1, 3), around(n_x, n_z).swapaxes(1, 2).reshape(-1, 3)
    expected = unit_wave(at, k, depth, ahead), unit_wave_slope(at, normals, k, depth, ahead)
    for found, wave in zip(problem.incident(rings, omega), expected, strict=True):
        whole = -1j * 2.0 / omega * wave.reshape(len(x), len(theta)) @ weight
        np.testing.assert_allclose(found, whole, rtol=1e-9, atol=1e-12 * np.abs(whole).max())


def test_no_home_folder_is_needed():
    """Capytaine makes a folder for its tables there when it is imported; ours lie with the results."""
    environment = {
        **os.environ,
        "HOME": "/dev/null/none",
        "XDG_CACHE_HOME": "",
        "CAPYTAINE_CACHE_DIR": "/dev/null/none",
    }
    command = [sys.executable, "-c", "import vsb.hydro.panels.rings"]
    assert subprocess.run(command, env=environment, check=False, capture_output=True).returncode == 0
