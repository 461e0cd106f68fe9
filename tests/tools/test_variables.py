"""Variables of results: units, dimensions, complex numbers, missing values."""

import numpy as np
import pytest
import xarray as xr
from tools.test_files import rao

import vsb.results.variables  # noqa: F401  (registers variables of all rooms)
from vsb.errors import DatabaseError
from vsb.tools.files import merged, separated
from vsb.tools.variables import FORCE, KINDS, MOMENT, VARIABLES, check_finite, described


def test_complex_numbers_are_stored_as_capytaine_does():
    from capytaine.io.xarray import separate_complex_values

    ds = rao(np.arange(6).reshape(1, 3, 2) * (1 + 2j))
    ours, theirs = separated(ds), separate_complex_values(ds)
    assert ours.rao.transpose(*theirs.rao.dims).equals(theirs.rao)
    assert merged(ours).rao.equals(ds.rao)
    for kept in (True, False, "default"):  # whatever a script of the user's has text xarray
        with xr.set_options(keep_attrs=kept):
            text = merged(separated(ds.assign(rao=ds.rao.assign_attrs(units="m/m"))))
        assert text.rao.attrs == {"units": "m/m"}


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, complex(0, np.nan)])
def test_nan_and_infinity_are_refused(bad):
    values = np.ones((1, 3, 2), dtype=type(bad))
    check_finite(rao(values), "x")
    values[0, 1, 1] = bad
    with pytest.raises(DatabaseError, match=r"x: variable rao holds NaN or infinite values; this result cannot be"):
        check_finite(rao(values), "x")


def test_values_of_designs_that_are_not_viable_may_be_missing():
    viable = xr.Dataset({"viable": ("design", [False, False])}, {"design": ["FSB", "VSWEC"]})
    check_finite(viable.assign(mean_power=("design", [np.nan, np.nan])), "x")
    with pytest.raises(DatabaseError, match="x: variable mean_power holds NaN"):
        check_finite(viable.assign(viable=("design", [True, False]), mean_power=("design", [np.nan, np.nan])), "x")
    with pytest.raises(DatabaseError, match="x: variable omega holds NaN"):
        check_finite(viable.assign(omega=("sample", [1.0, np.nan])), "x")


def test_dimensions_are_put_in_order():
    ds = rao(np.arange(6.0).reshape(1, 3, 2)).transpose("dof", "omega", "design")
    out = described(ds)
    assert ("...", *out.rao.dims) == VARIABLES["rao"].dims  # after any others, as of wave directions
    assert out.equals(rao(np.arange(6.0).reshape(1, 3, 2)))
    assert ds.rao.dims == ("dof", "omega", "design")  # the input stays


def test_units_follow_the_port():
    found = xr.Dataset({"port_velocity": ("omega", [1.0]), "best_power": ("omega", [2.0])}).expand_dims("design")
    for kind, unit in (("pressure", "m^2/s"), ("moment", "rad/(m s)"), ("force", "1/s")):
        units = {name: v.attrs["units"] for name, v in described(found.assign_attrs(port_kind=kind)).items()}
        assert units == {"port_velocity": unit, "best_power": "W/m^2"}
    assert described(found).port_velocity.attrs["units"] == "1/s"


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_units_of_a_port_are_consistent(kind):
    """Load times rate is a power; damping and stiffness are load over rate and over motion."""
    load, motion, rate = map(dimension, (kind.load_unit, kind.motion_unit, kind.rate_unit))
    assert np.array_equal(load + rate, dimension("W"))
    assert np.array_equal(motion - rate, dimension("s"))
    assert np.array_equal(load - rate, dimension(kind.damping_unit))
    assert np.array_equal(load - motion, dimension(kind.stiffness_unit))
    assert np.array_equal(rate - dimension("m"), dimension(kind.rate_per_amplitude))
    assert (kind is MOMENT) == ("rad" in kind.rate_unit)


def dimension(units):
    """Powers of metre, kilogram and second of a unit without prefix, "kg/(m^2 s)", shape (3,)."""
    units = units if isinstance(units, str) else units(FORCE)
    known = {"1": (0, 0, 0), "rad": (0, 0, 0), "m": (1, 0, 0), "kg": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2)}
    known |= {"W": (2, 1, -3), "J": (2, 1, -2), "Pa": (-1, 1, -2)}
    over, _, under = units.partition("/")
    parts = [(part, sign) for text, sign in ((over, 1), (under, -1)) for part in text.strip("()").split()]
    powers = [(*part.partition("^")[::2], sign) for part, sign in parts]
    return sum((sign * float(power or 1) * np.array(known[name]) for name, power, sign in powers), np.zeros(3))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("hydrostatic_stiffness position", "excitation"),
        ("excitation_force position", "excitation"),
        ("structural_stiffness", "hydrostatic_stiffness"),
        ("added_mass omega omega", "hydrostatic_stiffness"),
        ("inertia_matrix", "added_mass"),
        ("added_mass omega", "radiation_damping"),
        ("structural_damping_matrix velocity", "excitation"),
        ("kernel time", "radiation_damping"),
        ("kernel_state_space", "kernel"),
        ("input_matrix input_matrix time", "radiation_damping"),
        ("input_matrix channel velocity time input_matrix channel velocity time", "pto velocity"),
        ("state_matrix time", "rao"),
        ("rao excitation_force omega", "absorbed_power"),
        ("power_limit", "absorbed_power"),
        ("best_damping port_velocity port_velocity", "best_power"),
        ("power_slope position", "absorbed_power"),
        ("power_at_rest time", "energy"),
    ],
)
def test_units_are_consistent_with_the_equations_of_motion(left, right):
    both = (sum(dimension(VARIABLES[name].units) for name in side.split()) for side in (left, right))
    assert np.array_equal(*both)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("capture_width flux_matrix", "annual_mean_power"),
        ("capture_width_matrix", "capture_width"),
        ("capture_width_deviation", "capture_width"),
        ("force_rms force_rms", "damping annual_mean_power"),
        ("force_of_damping", "force_rms"),
        ("tried_damping", "damping"),
        *((name, "annual_mean_power") for name in (
            "power_of_damping", "practice_power", "quadrature_error", "power_bound", "power_matrix", "power_deviation",
            "corrected_mean_power", "corrected_power_low", "corrected_power_high", "run_power", "linear_run_power",
            "drawn_power", "power_at_shape", "power_at_reference",
        )),
        *((name, "margin") for name in (
            "viable", "optimum_gap", "optimum_share", "optimum_excess", "impossible_share", "count", "occurrence",
            "energy_beyond", "energy_beyond_validity", "beyond_validity", "drawn_sea", "drawn_seed", "drawn_weight",
        )),
        ("hs", "position"),
        ("drawn_hs", "hs"),
        ("drawn_te", "te"),
        ("stroke", "position"),
        ("stroke_rate", "velocity"),
        ("stroke_rate te", "stroke"),
    ],
)  # fmt: skip
def test_units_of_annual_results_are_consistent(left, right):
    both = (sum(dimension(VARIABLES[name].units) for name in side.split()) for side in (left, right))
    assert np.array_equal(*both)


def test_varied_keys_keep_their_units():
    coordinates = {"device.radius": [1.0, 2.0], "hs": [3.0, 4.0, 5.0], "design": ["A"], "tuning": ["one"]}
    dims = ("tuning", "hs", "design", "device.radius")
    ds = xr.Dataset({"annual_energy": (dims, np.ones((1, 3, 1, 2)))}, coordinates, {"varied": "device.radius hs"})
    ds["hs"].attrs = {"units": "ft"}
    found = described(ds)
    assert found.annual_energy.dims == ("hs", "device.radius", "design", "tuning")
    assert found.hs.attrs == {"units": "ft"}
    assert described(ds.assign_attrs(varied="device.radius")).hs.attrs["units"] == "m"
    with pytest.raises(DatabaseError, match=r"variables \['device.radius'\] are unknown"):
        described(ds.assign_attrs(varied="hs"))
