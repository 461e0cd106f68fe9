import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro import quality
from vsb.engine.waves.water import Water, group_velocity
from vsb.errors import DatabaseError

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
def test_each_check_finds_its_fault(perfect, name):
    assert name in failed(damaged(perfect, *DAMAGES[name]))


def test_shape_beside_a_load_is_judged_though_its_limit_is_seen_from_within_the_band(perfect):
    """Its added mass at infinity follows from its other coefficients, whatever they are: these are not."""
    beside = {key: ["Ring1", "Heave"] for key in ("influenced_dof", "radiating_dof")}

    def judged(ds):
        ds.added_mass_inf.values[0] = ds.added_mass_inf.values[:, 0] = quality.by_ogilvie(ds)[0]
        return {check.name: check.verdict for check in quality.sweep_checks(ds.assign_coords(beside))}

    limit = perfect.added_mass_inf.values[0, 0]
    wrong = damaged(perfect, "added_mass", lambda a: a[:, 0, 0].__iadd__(0.4 * (a[:, 0, 0] - limit)))
    assert judged(perfect)["kramers_kronig"] == "ok"
    assert judged(wrong)["kramers_kronig"] == "fail"


def test_a_failure_is_one_line_and_can_be_accepted_by_name(perfect):
    wrong = damaged(perfect, *DAMAGES["haskind"])
    with pytest.raises(DatabaseError, match=r"check 'haskind' failed: 0.21, needs at most 0.05 \(damping follows"):
        quality.judged(quality.verdict(wrong, None, WATER), ())
    accepted = quality.judged(quality.verdict(wrong, None, WATER), ("haskind",))
    checks = {check.name: check.verdict for check in accepted}
    assert checks["haskind"] == "accepted"


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
