import capytaine as cpt
import numpy as np
import pytest
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with

from examples import barge
from vsb.engine.hydro import dofs
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.bodies.lid import interior_lid
from vsb.engine.hydro.bodies.solver import BodyProblem, SymmetricPanels, unit_wave, unit_wave_slope
from vsb.engine.hydro.bodies.verdict import identities
from vsb.engine.hydro.panels import rings as bem
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
    monkeypatch.setattr(SymmetricPanels, "correction", property(lambda self: np.zeros(len(self._kept))))


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
