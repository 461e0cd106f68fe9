import numpy as np
import pytest
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro import quality
from vsb.hydro.database import Check
from vsb.study.sections import Water
from vsb.waves.dispersion import group_velocity, wavenumber

OMEGA = np.arange(1, 121) * 0.1
RHO, G = 1000.0, 9.81
WATER = Water(density=RHO, gravity=G)


@pytest.fixture
def perfect():
    """A database that satisfies every identity exactly: one channel, Haskind's excitation, added mass by Ogilvie."""
    amplitude = np.stack([OMEGA**1.5 / (1 + OMEGA**2) ** 1.5, -0.3 * OMEGA**2.5 / (1 + OMEGA**2) ** 2], axis=1)
    damping = amplitude[:, :, None] * amplitude[:, None, :]
    factor = np.array([w**2 / G / (4 * RHO * G * group_velocity(w, np.inf, G)) for w in OMEGA])
    excitation = amplitude / np.sqrt(factor)[:, None] * np.exp(0.3j * OMEGA)[:, None]
    infinite = np.array([[2.0, 0.1], [0.1, 1.0]])
    added = infinite + quality.DampingSpectrum(OMEGA, damping).added_mass_difference(OMEGA)
    pair = ("influenced_dof", "radiating_dof")
    return xr.Dataset(
        {
            "added_mass": (("omega", *pair), added),
            "radiation_damping": (("omega", *pair), damping),
            "added_mass_inf": (pair, infinite),
            "excitation_force": (("omega", "wave_direction", "influenced_dof"), excitation[:, None, :]),
        },
        coords={"omega": OMEGA, "wave_direction": [0.0]},
    )


def failed(ds):
    checks = [*quality.pointwise_checks(ds, WATER), *quality.sweep_checks(ds)]
    return {check.name for check in checks if check.verdict == "fail"}


def test_a_perfect_database_passes(perfect):
    checks = quality.verdict(perfect, None, WATER)
    assert {check.verdict for check in checks} == {"ok"}
    assert max(check.value for check in checks if check.name != "irregular_frequencies") < 1e-6


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("of", [quality.negative_damping, quality.second_channel])
def test_negative_and_second_eigenvalues_are_shares_of_the_largest(perfect, of, size):
    """Of eigenvalues 4 and -1 at one frequency, less at the others; in whatever units."""
    ds = damaged(perfect, "radiation_damping", lambda b: b.__imul__(0.0))
    ds.radiation_damping.values[:] = size * np.diag([2.0, -0.25])
    ds.radiation_damping.values[7] = size * np.array([[1.5, 2.5], [2.5, 1.5]])
    assert of(ds, np.ones((2, 2))) == pytest.approx(0.25)


def damaged(ds, name, change):
    out = ds.copy(deep=True)
    change(out[name].values)
    return out


DAMAGES = {
    "symmetry": ("added_mass", lambda a: a.__setitem__((40, 0, 1), a[40, 0, 1] + 0.1)),
    "rank_one": ("radiation_damping", lambda b: b.__iadd__(0.05 * np.abs(b).max() * np.eye(2))),
    "positive_damping": ("radiation_damping", lambda b: b.__isub__(0.05 * np.abs(b).max() * np.eye(2))),
    "haskind": ("excitation_force", lambda x: x.__imul__(1.1)),
    "irregular_frequencies": ("radiation_damping", lambda b: b.__setitem__(30, 1.2 * b[30])),
    "kramers_kronig": ("added_mass", lambda a: a.__iadd__(0.1 * np.eye(2))),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_each_check_sees_its_own_damage(perfect, name):
    assert name in failed(damaged(perfect, *DAMAGES[name]))


@pytest.mark.parametrize("matrix", ["added_mass", "radiation_damping"])
def test_either_matrix_alone_may_lack_symmetry(perfect, matrix):
    def skew(m):
        m += 0.02 * np.abs(m).max() * np.array([[0.0, 1.0], [-1.0, 0.0]])

    assert "symmetry" in failed(damaged(perfect, matrix, skew))


def test_a_failure_is_one_line_and_can_be_accepted_by_name(perfect):
    wrong = damaged(perfect, *DAMAGES["haskind"])
    with pytest.raises(DatabaseError, match=r"check 'haskind' failed: 0.21, needs at most 0.05 \(damping follows"):
        quality.judged(quality.verdict(wrong, None, WATER), ())
    accepted = quality.judged(quality.verdict(wrong, None, WATER), ("haskind",))
    checks = {check.name: check.verdict for check in accepted}
    assert checks["haskind"] == "accepted"


def test_only_a_failure_can_be_accepted():
    """A doubt that is named stays a doubt, with its advice."""
    given = [Check("haskind", 0.1, 0.05, "-", verdict, "why") for verdict in ("ok", "doubt", "fail")]
    assert [check.verdict for check in quality.judged(given, ("haskind",))] == ["ok", "doubt", "accepted"]


def test_tabulated_frequencies_are_judged_with_the_sweep(perfect):
    tabulated = perfect.isel(omega=[10, 50]).assign_coords(omega=[1.13, 5.17])
    tabulated = damaged(tabulated, "radiation_damping", lambda b: b.__imul__(3.0))
    with pytest.raises(DatabaseError, match="check 'haskind' failed"):
        quality.judged(quality.verdict(perfect, tabulated, WATER), ())


def test_estimates_of_solver_and_sweep_are_judged_by_the_tolerance():
    swept = {
        "error_estimate": 2e-4,
        "interpolation_error": 3e-4,
        "limit_difference": 1e-5,
        "solves": 13,
        "frequencies": 128,
    }
    blocks = [swept, {"error_estimate": 5e-4, "solves": 3, "frequencies": 3}]
    for tolerance, verdicts in (
        (1e-3, ["ok", "ok", "ok"]),
        (4e-4, ["doubt", "ok", "ok"]),
        (1e-4, ["doubt", "fail", "ok"]),
    ):
        checks = quality.estimate_checks(blocks, tolerance)
        assert [check.name for check in checks] == ["error_estimate", "interpolation_error", "limit_difference"]
        assert [check.value for check in checks] == [5e-4, 3e-4, 1e-5]
        assert [check.verdict for check in checks] == verdicts
        assert checks[0].explanation.endswith("16 solves for 131 frequencies")
    wrong = quality.estimate_checks([{**swept, "limit_difference": 0.03}], 0.1)
    assert wrong[2].verdict == "doubt"
    assert quality.estimate_checks([{"seconds": 1.0}], 1e-3) == []  # of others


@pytest.mark.parametrize(("size", "verdicts"), [(1e-6, "ok ok"), (1e-3, "ok doubt"), (0.1, "fail fail")])
def test_identities_are_held_to_the_precision_asked_for(size, verdicts):
    checks = [quality.identity_check("haskind", size, 0.05, precision, "") for precision in (1.0, 0.01)]
    assert " ".join(check.verdict for check in checks) == verdicts
    assert [check.limit for check in checks] == [0.05, 0.05 if verdicts == "fail fail" else 5e-4]  # what it failed


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("kramers_kronig", "raise hydro.omega_max: the band must reach"),
        ("interpolation_error", "raise hydro.tolerance, change hydro.omega_max"),
        ("symmetry", "lower hydro.tolerance or raise hydro.rows, change hydro.omega_max"),
    ],
)
def test_a_failure_says_what_to_change(name, advice):
    with pytest.raises(DatabaseError, match=rf"check '{name}' failed: .*; {advice}.*, or list the name under"):
        quality.judged([Check(name, 1.0, 0.1, "-", "fail", "why")], ())


def test_the_second_channel_is_the_second_of_many():
    """Eigenvalues 1, 0.1 and 0 of three motions."""
    damping = np.diag([1.0, 0.1, 0.0])[None]
    ds = xr.Dataset({"radiation_damping": (("omega", "influenced_dof", "radiating_dof"), damping)})
    assert quality.second_channel(ds, np.ones((3, 3))) == pytest.approx(0.1)


def test_limits_are_those_of_panels_unless_more_is_asked_for(perfect):
    """And a fraction of them to that precision, of what needs the whole band no less than a tenth."""
    identities = {"symmetry": 0.01, "positive_damping": 0.01, "rank_one": 0.02, "haskind": 0.05}
    known = {check.name: check.limit for check in quality.pointwise_checks(perfect, WATER)}
    assert known == identities
    assert {check.name: check.limit for check in quality.sweep_checks(perfect)} == dict.fromkeys(
        ("irregular_frequencies", "kramers_kronig"), 0.02
    )
    whole = {check.name: check.limit for check in quality.verdict(perfect, None, WATER)}
    assert whole == identities | {"irregular_frequencies": 0.02, "kramers_kronig": 0.02}
    strict = {check.name: check.limit for check in quality.verdict(perfect, None, WATER, 0.01)}
    expected = {name: 0.01 * limit for name, limit in identities.items()}
    assert strict == pytest.approx(expected | {"irregular_frequencies": 0.02, "kramers_kronig": 0.002})
    assert failed(perfect) == set()
    assert quality.haskind_difference(perfect, np.inf, RHO, G) < 1e-9
    twice = quality.haskind_damping(perfect, np.inf, RHO, G, 1) * 2
    np.testing.assert_allclose(quality.haskind_damping(perfect, np.inf, RHO, G), twice)


@pytest.mark.parametrize(("count", "seen"), [(4, 0.0), (5, 1.0), (7, 1.0), (49, 1.0), (60, 1.0)])
def test_a_spike_is_seen_as_soon_as_there_are_four_neighbours(count, seen):
    """A single frequency off a smooth damping, in terms of the largest value: itself."""
    b = np.zeros((count, 1, 1))
    b[count // 2] = 3.0
    ds = xr.Dataset({"radiation_damping": (("omega", "influenced_dof", "radiating_dof"), b)})
    assert quality.largest_kink(ds.assign_coords(omega=0.1 * np.arange(1, count + 1))) == pytest.approx(seen)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_haskinds_damping_is_that_of_its_water_and_its_order(order):
    """Of two frequencies and motions out of phase in water of finite depth: rows are conjugate to columns."""
    omega, depth, density, gravity = np.array([0.9, 2.0]), 3.0, 700.0, 5.0
    x = np.array([[[1.0 + 2.0j, -3.0 + 0.5j]], [[0.3 - 1.0j, 2.0 + 2.0j]]])
    ds = xr.Dataset({"excitation_force": (("omega", "wave_direction", "influenced_dof"), x)}, {"omega": omega})
    found = quality.haskind_damping(ds, depth, density, gravity, order)
    for w, (force,), made in zip(omega, x, found, strict=True):
        flux = 4 * (2 if order else 1) * density * gravity * group_velocity(w, depth, gravity)
        expected = wavenumber(w, depth, gravity) * np.outer(force, force.conj()) / flux
        np.testing.assert_allclose(made, expected, rtol=1e-12)


@pytest.mark.parametrize("order", [0, 1])
def test_the_checks_of_a_database_are_of_its_water_and_its_order(perfect, order):
    """The same damping with the excitation that it has in other water holds there, and nowhere else."""
    water = Water(density=650.0, gravity=4.0, depth=2.5)
    force = perfect.excitation_force.values[:, 0]
    factor = [
        wavenumber(w, 2.5, 4.0) / (4 * (2 if order else 1) * 650.0 * 4.0 * group_velocity(w, 2.5, 4.0)) for w in OMEGA
    ]
    mine = np.array([w**2 / G / (4 * RHO * G * group_velocity(w, np.inf, G)) for w in OMEGA])
    other = perfect.assign(
        excitation_force=(perfect.excitation_force.dims, (force * np.sqrt(mine / factor)[:, None])[:, None])
    )
    checks = quality.verdict(other, None, water, order=order)
    assert {check.verdict for check in checks} == {"ok"}
    assert [check.explanation.startswith("order 1: ") for check in checks] == [order == 1] * 6
    wrong = [water.model_copy(update=change) for change in ({"density": 1000.0}, {"gravity": 9.81}, {"depth": np.inf})]
    for there in wrong:
        assert quality.haskind_difference(other, there.depth, there.density, there.gravity, order) > 0.05
        assert "haskind" in {c.name for c in quality.pointwise_checks(other, there, 1.0, order) if c.verdict == "fail"}


def test_damping_is_scaled_by_the_largest_of_each_motion_of_either_sign():
    """Of two motions the second is drawn from, by half of its largest; in terms of the largest eigenvalue, 2/3."""
    damping = np.array([np.diag([9.0, -0.3]), np.diag([2.0, 0.2]), np.diag([4.5, 0.1])])
    ds = xr.Dataset({"radiation_damping": (("omega", "influenced_dof", "radiating_dof"), damping)})
    assert quality._scale(ds) == pytest.approx(np.outer([3.0, 0.3**0.5], [3.0, 0.3**0.5]))
    assert quality.negative_damping(ds) == pytest.approx(1.0)
    assert quality.scaled_eigenvalues(ds, quality._scale(ds)) == pytest.approx(
        np.array([[-1.0, 1.0], [2 / 9, 2 / 3], [1 / 3, 0.5]])
    )
    alone = ds.isel(influenced_dof=[0], radiating_dof=[0])
    assert quality.second_channel(alone) == quality.negative_damping(alone) == 0.0


def test_kinks_are_distances_from_the_cubic_through_four_neighbours_however_far_apart():
    omega = np.array([0.1, 0.25, 0.7, 0.9, 1.6, 2.0, 2.1])
    cubic = np.array([[1.0, -2.0], [0.5, 3.0]]) * (1 - omega + 2 * omega**3)[:, None, None]
    assert quality.kinks(omega, cubic) == pytest.approx(np.zeros((3, 2, 2)), abs=1e-12)
    cubic[3, 1, 0] -= 0.25
    assert quality.kinks(omega, cubic)[1] == pytest.approx(np.array([[0.0, 0.0], [0.25, 0.0]]), abs=1e-12)


def test_the_limit_is_compared_in_the_mean_of_the_lower_half_and_in_terms_of_both_motions(perfect):
    """A coupling that is less by 0.05 at all frequencies of the lower half, or at two of every three."""
    lower = 0.5 * OMEGA[-1] >= OMEGA
    for chosen, share in ((lower, 1.0), (lower & (np.arange(120) % 3 > 0), 2 / 3), (~lower, 0.0)):
        off = damaged(
            perfect, "added_mass", lambda a, chosen=chosen: a.__setitem__((chosen, 0, 1), a[chosen, 0, 1] - 0.05)
        )
        assert quality.added_mass_difference(off) == pytest.approx(0.05 * share / np.sqrt(2.0), abs=1e-9)


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("afloat", "correct the mass, or how deep the mesh lies"),
        ("rigid_names", "correct the names of the displacements"),
        ("corners", "correct the displacements: of panels and of corners they are two"),
        ("haskind", "ask the author"),
    ],
)
def test_a_failure_of_what_came_from_elsewhere_has_its_own_advice(name, advice):
    """Of several failures the first that is not accepted is told, with the limit it missed."""
    checks = [Check("rank_one", 1.0, 0.1, "-", "fail", ""), Check(name, 2.0, 0.25, "-", "fail", "why")]
    with pytest.raises(
        DatabaseError,
        match=rf"^hydro database: check '{name}' failed: 2, needs at most 0.25 \(why\); {advice}, or list the name under hyd",
    ):
        quality.judged([*checks, Check("last", 3.0, 0.1, "-", "fail", "")], ("rank_one",), "ask the author")


@pytest.mark.parametrize(
    ("name", "limit"), [("error_estimate", 1e-3), ("interpolation_error", 1e-3), ("limit_difference", 0.02)]
)
def test_an_estimate_is_held_to_its_limit_in_the_worst_block(name, limit):
    for value, good in ((limit, True), (1.01 * limit, False)):
        blocks = [{name: 0.1 * limit}, {name: value}, {name: 0.5 * limit}]
        (check,) = quality.estimate_checks(blocks, 1e-3)
        assert (check.name, check.value, check.limit) == (name, value, limit)
        assert check.verdict == ("ok" if good else "fail" if name == "interpolation_error" else "doubt")


def test_the_limit_is_in_terms_of_its_diagonal_however_large_its_couplings_are():
    """Without damping Ogilvie's limit is the added mass itself: in the mean up to half of the last frequency."""
    omega, pair = np.array([0.5, 1.0, 2.0, 2.5, 4.0]), ("influenced_dof", "radiating_dof")
    limit, off = np.array([[4.0, 5.0], [5.0, 9.0]]), np.zeros((5, 2, 2))
    off[:, 0, 1] = [0.3, -0.6, 0.9, 7.0, 7.0]
    off[:, 1, 1] = [-0.5, -0.5, 0.0, 7.0, 7.0]
    ds = xr.Dataset({
        "added_mass": (("omega", *pair), limit + off), "radiation_damping": (("omega", *pair), np.zeros((5, 2, 2))),
        "added_mass_inf": (pair, limit),
    }, {"omega": omega})  # fmt: skip
    assert quality.added_mass_difference(ds) == pytest.approx(max(0.2 / 6.0, 1.0 / 3.0 / 9.0))
    ds.added_mass.values[0, 0, 0] -= 0.9
    assert quality.added_mass_difference(ds) == pytest.approx(0.3 / 4.0)


def test_the_first_of_several_failures_is_told_that_is_not_accepted():
    given = [Check(name, 1.0, 0.1, "-", "fail", "why") for name in ("symmetry", "haskind", "rank_one", "afloat")]
    for accept, told in (((), "symmetry"), (("symmetry", "afloat"), "haskind"), (("haskind", "symmetry"), "rank_one")):
        with pytest.raises(DatabaseError, match=f"^hydro database: check '{told}' failed: 1, needs at most 0.1 "):
            quality.judged(given, accept)
    kept = quality.judged(given, [check.name for check in given])
    assert [(check.name, check.verdict) for check in kept] == [(check.name, "accepted") for check in given]
