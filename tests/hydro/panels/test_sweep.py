from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.hydro import dofs
from vsb.hydro.panels import rings as bem
from vsb.hydro.panels import sweep as panels
from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.panels.sweep import TwoMeshes
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.sweep import coefficients, largest
from vsb.hydro.witness import Waves
from vsb.shell.deformed import rigid_sphere
from vsb.waves.dispersion import group_velocity, wavenumber

LEGENDRE = dofs.displacements(f"Radial{n}" for n in range(5))
LOW = [round(0.1 * i, 10) for i in range(1, 33)]
FROM_KD = [w for w in LOW if w >= 0.7]  # kd > 0.3
HIGH = [round(0.1 * i, 10) for i in range(65, 97)]
SCENES = {
    "hemisphere": (0.0, LEGENDRE, np.inf, LOW),
    "heave": (0.0, LEGENDRE[1:2], np.inf, LOW),
    "high": (0.6, LEGENDRE, np.inf, LOW),
    "low": (-0.8, LEGENDRE, np.inf, LOW),
    "short waves": (-0.8, LEGENDRE, np.inf, HIGH),
    "deep enough": (0.0, LEGENDRE, 4.0, FROM_KD),
    "near the bottom": (0.0, LEGENDRE, 2.2, FROM_KD),
}


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def meshes(green, rows, height=0.0, displacements=LEGENDRE, depth=np.inf, density=1025.0):
    """The sphere of radius 2 m with its centre at a height, and an undemanding lid."""

    def problem(part):
        mesh = deformed_mesh(rigid_sphere(2.0, height), rows // part, 2 * rows // part, 16 // part)
        return bem.AxisymmetricProblem(green, mesh, displacements, density, depth, 9.81)

    return TwoMeshes(problem(1), problem(2))


def true_error(two, found):
    """Against the spectral solver, in terms of the largest entries the estimate is told of."""
    p, height = two.fine, 2.0 + float(two.fine.mesh.meridian_height.min())
    exact = SpectralProblem(rigid_sphere(2.0, height), p.displacements, p.density, 9.81, 48, depth=p.depth)
    reference = exact.solve(found.omega.values.tolist())
    sizes = largest(reference, two.strongest)
    pairs = zip(coefficients(found), coefficients(reference), sizes, strict=True)
    return max(float(np.abs(a - b).max()) / size for a, b, size in pairs)


@pytest.mark.parametrize("rows", [12, 20])
@pytest.mark.parametrize("scene", SCENES)
def test_the_estimate_bounds_the_error_of_panels_and_interpolation(green, scene, rows):
    *shape, frequencies = SCENES[scene]
    two = meshes(green, rows, *shape)
    found = two.solve(frequencies, 5e-4)
    estimate, error = found.attrs["error_estimate"], true_error(two, found)
    assert error <= estimate
    assert estimate <= (50 if scene == "short waves" else 8) * error


@pytest.mark.parametrize("depth", [np.inf, 4.0])
def test_the_estimate_at_infinite_frequency_bounds_the_error(green, depth):
    errors = []
    for rows in (12, 20, 28):
        two = meshes(green, rows, depth=depth)
        exact = SpectralProblem(rigid_sphere(2.0, 0.0), LEGENDRE, 1025.0, 9.81, 48, depth=depth).at_infinity()
        found = two.at_infinity()
        errors.append(np.abs(found.added_mass_inf.values - exact).max() / np.abs(exact).max())
        assert errors[-1] <= found.attrs["error_estimate"] <= 10 * errors[-1]
    assert errors[0] > errors[1] > errors[2]


def test_the_estimate_falls_at_the_order_of_the_panels(green):
    rows, omegas = np.array([12, 16, 24, 32]), [0.5, 1.5, 2.5]
    estimates = [meshes(green, n).solve(omegas).attrs["error_estimate"] for n in rows]
    slopes = -np.diff(np.log(estimates)) / np.diff(np.log(rows))
    assert np.all((slopes > 1.3) & (slopes < 2.7)), (estimates, slopes)


@pytest.mark.parametrize("scene", ["hemisphere", "heave", "high", "low", "short waves"])
def test_in_deep_water_few_frequencies_are_solved(green, scene):
    *shape, frequencies = SCENES[scene]
    two = meshes(green, 20, *shape)
    found = two.solve(frequencies, 5e-4)
    assert found.attrs["frequencies"] == len(frequencies) == found.sizes["omega"]
    assert found.attrs["solves"] <= 13
    direct = two.solve(frequencies)
    assert direct.attrs["solves"] == len(frequencies)
    sizes = largest(direct, two.strongest)
    pairs = zip(coefficients(found), coefficients(direct), sizes, strict=True)
    assert max(np.abs(a - b).max() / size for a, b, size in pairs) <= direct.attrs["error_estimate"] / 2


def test_what_is_asked_for_one_by_one_is_what_the_fine_mesh_gives(green):
    two = meshes(green, 12)
    for frequencies in ([1.3], [0.7, 1.3]):
        direct = two.fine.solve(frequencies)
        for interpolation in (None, 1e-3):  # too few to interpolate
            found = two.solve(frequencies, interpolation)
            assert found.attrs["solves"] == len(frequencies)
            for name in direct:
                np.testing.assert_array_equal(found[name].values, direct[name].values)


@given(st.integers(-4, 4), st.permutations(range(5)))
@settings(max_examples=5)
def test_neither_density_nor_order_of_displacements_matters(green, power, order):
    ours = meshes(green, 8).solve([1.0, 2.0]).attrs["error_estimate"]
    shuffled = tuple(LEGENDRE[i] for i in order)
    theirs = meshes(green, 8, displacements=shuffled, density=1025.0 * 2.0**power).solve([1.0, 2.0])
    assert theirs.attrs["error_estimate"] == pytest.approx(ours, rel=1e-9)


def test_motions_that_move_no_water_have_no_error(green):
    two = meshes(green, 8, displacements=dofs.displacements(["Meridional1"]))
    found = two.solve([1.0, 2.0])
    assert found.attrs["error_estimate"] == 0.0
    assert two.at_infinity().attrs["error_estimate"] == 0.0


@pytest.mark.parametrize("rows", [12, 24])
def test_the_estimate_bounds_the_distance_from_the_published_hemisphere(green, hemisphere, rows):
    """Against the multipole series, whose error of 3e-6 is nothing here."""
    chosen = [i for i, ka in enumerate(hemisphere["Ka"]) if ka <= 6]
    omegas = [float(np.sqrt(hemisphere["Ka"][i])) for i in chosen]
    shapes = dofs.displacements(f"Radial{n}" for n in range(7))

    def problem(part):
        mesh = deformed_mesh(rigid_sphere(1.0, 0.0), rows // part, 2 * rows // part, 16 // part)
        return bem.AxisymmetricProblem(green, mesh, shapes, 1.0, np.inf, 1.0)

    found = TwoMeshes(problem(1), problem(2)).solve(omegas)
    exact = [np.array(hemisphere[name])[chosen] for name in ("added_mass", "radiation_damping", "abs_excitation")]
    exact[1] = exact[1] * np.array(omegas)[:, None, None]
    a, b, x = coefficients(found)
    pairs = zip((a, b, np.abs(x)), exact, strict=True)
    errors = [np.abs(ours - theirs.reshape(ours.shape)).max() / np.abs(theirs).max() for ours, theirs in pairs]
    assert max(errors) <= found.attrs["error_estimate"] <= 10 * max(errors)


def test_what_both_meshes_have_wrong_is_no_small_part_of_the_error(green):
    """Of short waves the lid's error is on both meshes alike: what half the rows change is less than the error."""
    two, frequencies = meshes(green, 40), [5.0, 5.5, 6.0, 6.4]
    found = two.solve(frequencies)
    halves = two.coarse.solve(frequencies)
    sizes = largest(found, two.strongest)
    pairs = zip(coefficients(found), coefficients(halves), sizes, strict=True)
    change, error = max(np.abs(a - b).max() / size for a, b, size in pairs), true_error(two, found)
    assert change < error <= found.attrs["error_estimate"]


@pytest.mark.parametrize(
    ("fine", "coarse", "error"),
    [
        ([[4.0, 1.0], [1.0, -8.0]], [[4.0, 1.0], [1.0, -8.0]], 0.0),
        ([[4.0, 1.0], [1.0, -8.0]], [[4.5, 1.0], [1.0, -8.1]], 0.5 / 8),
        ([[4.0, 1.0], [1.4, -8.0]], [[4.5, 1.0], [1.4, -8.0]], (0.5 + 0.4) / 8),
        ([[0.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 0.0]], 0.0),
        ([[0.0, 0.0], [0.0, 0.0]], [[0.0, 0.2], [0.0, 0.0]], 0.2),
    ],
)
def test_the_error_at_infinite_frequency_is_what_half_the_rows_change_and_what_is_not_symmetric(fine, coarse, error):
    """In terms of the largest entry; as it is where there is none."""
    moved = [SimpleNamespace(label=name) for name in ("Heave", "Radial0")]
    problems = [SimpleNamespace(at_infinity=lambda a=a: np.array(a), displacements=moved) for a in (fine, coarse)]
    found = TwoMeshes(*problems).at_infinity()
    assert found.attrs["error_estimate"] == pytest.approx(error, rel=1e-12, abs=1e-15)
    assert found.added_mass_inf.values.tolist() == fine
    assert found.influenced_dof.values.tolist() == ["Heave", "Radial0"]


@pytest.mark.parametrize(("depth", "k"), [(np.inf, 0.25), (1.5, 0.25), (0.5, 0.6)])
def test_the_strongest_wave_has_half_a_radius_or_what_its_depth_allows(depth, k):
    """k R = 0.5, but not below kd = 0.3, which the Green function does not know."""
    asked = []
    fine = SimpleNamespace(waterline=2.0, depth=depth, gravity=3.0, solve=lambda omega: asked.append(omega) or "solved")
    assert TwoMeshes(fine, None).strongest == "solved"
    assert asked == [[pytest.approx(np.sqrt(3.0 * k * np.tanh(k * depth)))]]


def test_haskinds_damping_of_two_meshes_is_that_of_their_water():
    """Of what keeps the relation in its own water nothing is missed; of density, gravity and depth each counts."""
    omega, depth, density, gravity = np.array([1.0, 2.0]), 2.5, 700.0, 4.0
    factor = [
        wavenumber(w, depth, gravity) / (4 * density * gravity * group_velocity(w, depth, gravity)) for w in omega
    ]
    x = np.array([[3.0, -1.0], [2.0j, 1.0j]])  # in phase, so that damping is real
    damping = np.array(factor)[:, None, None] * (x[:, :, None] * x[:, None, :].conj()).real
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    solved = xr.Dataset({
        "added_mass": (pair, np.tile(np.diag([3.0, 1.0]), (2, 1, 1))), "radiation_damping": (pair, damping),
        "Froude_Krylov_force": (wave, 0.3 * x[:, None]), "diffraction_force": (wave, 0.7 * x[:, None]),
    }, {"omega": omega})  # fmt: skip
    water = {"depth": depth, "density": density, "gravity": gravity}

    def estimate(**changes):
        fine = SimpleNamespace(**(water | changes))
        return TwoMeshes(fine, SimpleNamespace(solve=lambda omegas: solved)).error_estimate(solved, 0.1 * solved)

    assert estimate() < 1e-12
    for change in ({"depth": np.inf}, {"density": 800.0}, {"gravity": 5.0}):
        assert estimate(**change) > 0.05


def recorded_problem(made):
    """Arguments of a problem instead of one."""
    return lambda *args, **named: made.append((args, named)) or SimpleNamespace(solve=lambda omegas: (args, omegas))


def test_a_witness_of_panels_solves_both_meshes_in_its_own_water(monkeypatch):
    made, said = [], []
    monkeypatch.setattr(panels, "green_function", lambda folder: f"green of {folder}")
    monkeypatch.setattr(panels, "AxisymmetricProblem", recorded_problem(made))
    monkeypatch.setattr(panels, "runs", lambda *args: said.append((args[0](), args[1](), *args[2:])) or "runs")
    monkeypatch.setattr(panels, "displacements_of", lambda basis: f"of {basis}")
    waves = Waves((1.0, 3.0), 700.0, 12.0, 4.0)
    assert panels.witness_runs("place", ("fine", "coarse"), "basis", waves) == "runs"
    arguments = [("green of place", mesh, "of basis", 700.0, 12.0, 4.0) for mesh in ("fine", "coarse")]
    assert made == [(each, {}) for each in arguments]
    assert said == [(*((each, [1.0, 3.0]) for each in arguments), "basis", waves)]


@pytest.mark.parametrize(("omega", "infinite"), [((1.0, 2.0), False), ((np.inf,), True)])
def test_a_block_is_solved_on_both_meshes_in_the_water_of_its_spec(monkeypatch, omega, infinite):
    made, asked = [], []
    monkeypatch.setattr(panels, "green_function", lambda folder: "green")
    monkeypatch.setattr(panels, "AxisymmetricProblem", recorded_problem(made))
    monkeypatch.setattr(TwoMeshes, "at_infinity", lambda self: "limit")
    monkeypatch.setattr(TwoMeshes, "solve", lambda self, *args: asked.append((self, args)) or "solved")
    water = SimpleNamespace(density=700.0, depth=12.0, gravity=4.0)
    spec = SimpleNamespace(water=water, displacements=("Radial0", "Heave"), omega=omega, interpolation=3e-4)
    assert panels.solve_block(spec, "fine", "coarse", "place") == ("limit" if infinite else "solved")
    moved = dofs.displacements(["Radial0", "Heave"])
    assert made == [(("green", mesh, moved, 700.0, 12.0, 4.0), {}) for mesh in ("fine", "coarse")]
    if not infinite:
        ((two, args),) = asked
        assert args == ([1.0, 2.0], 3e-4)
        assert [each.solve(())[0][1] for each in (two.fine, two.coarse)] == ["fine", "coarse"]


@pytest.mark.parametrize("worst", ["added_mass", "radiation_damping", "excitation"])
def test_an_estimate_is_what_half_the_rows_change_and_what_both_miss_in_the_worst_coefficient(worst):
    """Each in terms of the largest of its own, here or where waves are strongest, of either sign."""
    rng, omega = np.random.default_rng(3), np.array([1.0, 2.0])
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")

    def any_of(size=1.0):
        return xr.Dataset({
            "added_mass": (pair, size * rng.normal(size=(2, 2, 2))),
            "radiation_damping": (pair, size * rng.normal(size=(2, 2, 2))),
            "Froude_Krylov_force": (wave, size * (rng.normal(size=(2, 1, 2)) + 1j * rng.normal(size=(2, 1, 2)))),
            "diffraction_force": (wave, size * (rng.normal(size=(2, 1, 2)) - 1j * rng.normal(size=(2, 1, 2)))),
        }, {"omega": omega})  # fmt: skip

    fine, change, strongest, asked = any_of(), any_of(1e-3), -3.0 * any_of(), []
    for name in fine:
        own = "excitation" if "force" in name else name
        change[name] = change[name] * (1e4 if own == worst else 1.0)
    water = {"depth": 2.5, "density": 700.0, "gravity": 4.0}
    coarse = SimpleNamespace(solve=lambda omegas: asked.append(omegas) or fine + change)
    found = TwoMeshes(SimpleNamespace(**water), coarse).error_estimate(fine, strongest)
    assert asked == [[1.0, 2.0]]
    x = fine.Froude_Krylov_force.values + fine.diffraction_force.values
    factor = [wavenumber(w, 2.5, 4.0) / (4 * 700.0 * 4.0 * group_velocity(w, 2.5, 4.0)) for w in omega]
    haskind = np.array(factor)[:, None, None] * x[:, 0, :, None] * x[:, 0, None, :].conj()
    a, b = fine.added_mass.values, fine.radiation_damping.values
    twisted, missed = np.abs(a - a.swapaxes(1, 2)).max(), np.abs(haskind - b).max()
    whole = strongest.Froude_Krylov_force + strongest.diffraction_force
    sizes = [max(np.abs(one).max(), np.abs(other.values).max()) for one, other in (
        (a, strongest.added_mass), (b, strongest.radiation_damping), (x, whole))]  # fmt: skip
    changes = [np.abs(change[n].values).max() for n in ("added_mass", "radiation_damping")]
    changes.append(np.abs((change.Froude_Krylov_force + change.diffraction_force).values).max())
    errors = [
        changes[0] / sizes[0] + twisted / sizes[0],
        changes[1] / sizes[1] + missed / sizes[1],
        changes[2] / sizes[2] + missed / sizes[1],
    ]
    assert max(errors) == errors[["added_mass", "radiation_damping", "excitation"].index(worst)]
    assert found == pytest.approx(max(errors), rel=1e-9)


@pytest.mark.parametrize("swept", [True, False])
def test_what_is_interpolated_is_off_by_panels_and_interpolation_together(monkeypatch, swept):
    """The panels' error is of those solved, none of them twice; what could not be interpolated is off by panels alone."""
    asked, judged = [], []

    def solve(omegas):
        asked.extend(omegas)
        return xr.Dataset({"added_mass": ("omega", 2.0 * np.array(omegas))}, {"omega": list(omegas)})

    def on_grid(given, frequencies, tolerance, incident, elsewhere):
        assert (frequencies, tolerance, incident) == ([1.0, 2.0, 3.0, 4.0], 3e-4, "the wave")
        (strongest,) = elsewhere
        assert strongest.omega.values.tolist() == [pytest.approx(np.sqrt(3.0 * 0.25 * np.tanh(0.25 * 7.0)))]
        given([1.0, 4.0])
        found = given([1.0, 4.0, 3.0]).sortby("omega")
        sweep = SimpleNamespace(error=0.02) if swept else None
        return SimpleNamespace(coefficients=given(frequencies), sweep=sweep, solved=found.omega.values.tolist())

    monkeypatch.setattr(panels, "on_grid", on_grid)
    monkeypatch.setattr(TwoMeshes, "error_estimate", lambda self, *given: judged.append(given) or 0.05)
    fine = SimpleNamespace(waterline=2.0, depth=7.0, gravity=3.0, solve=solve, incident_wave="the wave")
    found = TwoMeshes(fine, None).solve([1.0, 2.0, 3.0, 4.0], 3e-4)
    assert found.attrs == {"error_estimate": pytest.approx(0.07 if swept else 0.05), "solves": 3, "frequencies": 4}
    assert sorted(asked[1:]) == [1.0, 2.0, 3.0, 4.0]
    ((solved, strongest),) = judged
    assert solved.omega.values.tolist() == [1.0, 3.0, 4.0]
    assert strongest.omega.values.tolist() == asked[:1]
    alone = TwoMeshes(fine, None).solve([1.0, 2.0])
    assert alone.attrs == {"error_estimate": 0.05, "solves": 2, "frequencies": 2}
    assert judged[1][0].omega.values.tolist() == [1.0, 2.0]
