import numpy as np
import pytest
import xarray as xr
from tools.test_files import rao

from vsb.errors import DatabaseError
from vsb.tools.units import AT_ROTATION, AT_VOLUME, ATTRS, check_finite, described, merged, separated


def test_separated_form_is_the_one_capytaine_writes():
    from capytaine.io.xarray import separate_complex_values

    ds = rao(np.arange(6).reshape(1, 3, 2) * (1 + 2j))
    ours, theirs = separated(ds), separate_complex_values(ds)
    assert ours.rao.transpose(*theirs.rao.dims).equals(theirs.rao)
    assert merged(ours).rao.equals(ds.rao)
    for kept in (True, False, "default"):  # whatever a script of the user's has told xarray
        with xr.set_options(keep_attrs=kept):
            told = merged(separated(ds.assign(rao=ds.rao.assign_attrs(units="m/m"))))
        assert told.rao.attrs == {"units": "m/m"}


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, complex(0, np.nan)])
def test_one_bad_number_is_found(bad):
    values = np.ones((1, 3, 2), dtype=type(bad))
    check_finite(rao(values), "x")
    values[0, 1, 1] = bad
    with pytest.raises(
        DatabaseError, match=r"x: variable rao holds NaN or infinite values; this result cannot be used"
    ):
        check_finite(rao(values), "x")


def test_numbers_of_no_design_are_needed_also_where_none_is_viable():
    viable = xr.Dataset({"viable": ("design", [False, False])}, {"design": ["FSB", "VSWEC"]})
    check_finite(viable.assign(mean_power=("design", [np.nan, np.nan])), "x")
    with pytest.raises(DatabaseError, match="x: variable mean_power holds NaN"):
        check_finite(viable.assign(viable=("design", [True, False]), mean_power=("design", [np.nan, np.nan])), "x")
    with pytest.raises(DatabaseError, match="x: variable omega holds NaN"):
        check_finite(viable.assign(omega=("sample", [1.0, np.nan])), "x")


def test_labels_may_be_infinite():
    """As the frequency of a limit is, or the depth of deep water."""
    check_finite(xr.Dataset({"mass": ("omega", [1.0, 2.0])}, {"omega": [1.0, np.inf], "depth": np.inf}), "x")


@pytest.mark.parametrize("power", ["annual_mean_power", "corrected_mean_power"])
@pytest.mark.parametrize("gain", ["gain_percent", "gain_low", "gain_high", "corrected_gain_percent"])
def test_gains_over_nothing_may_be_missing_and_no_others(gain, power):
    """Of two designs, the first of which gains are over, and two tunings."""
    by = ("design", "tuning")
    coordinates = {"design": ["FSB", "VSWEC"], "tuning": ["fixed", "one"]}
    taken = np.array([[0.0, 2.0], [3.0, 4.0]])
    found = xr.Dataset({power: (by, taken), gain: (by, [[np.nan, 0.0], [np.nan, 100.0]])}, coordinates)
    check_finite(found, "x")
    for lost in (gain, power):
        worse = found.copy(deep=True)
        worse[lost].loc[{"design": "VSWEC", "tuning": "one"}] = np.nan
        with pytest.raises(DatabaseError, match=f"variable {lost} holds NaN"):
            check_finite(worse, "x")


def test_dimensions_are_put_in_order():
    ds = rao(np.arange(6.0).reshape(1, 3, 2)).transpose("dof", "omega", "design")
    out = described(ds)
    assert ("...", *out.rao.dims) == ATTRS["rao"].dims  # after any others, as of wave directions
    assert out.equals(rao(np.arange(6.0).reshape(1, 3, 2)))
    assert ds.rao.dims == ("dof", "omega", "design")  # the input stays


def test_what_a_take_off_sees_of_a_volume_is_in_units_of_pressure_and_flow():
    found = xr.Dataset({"port_velocity": ("omega", [1.0]), "best_power": ("omega", [2.0])}).expand_dims("design")
    units = {name: v.attrs["units"] for name, v in described(found.assign_attrs(port="volume: pressure")).items()}
    assert units == {"port_velocity": "m^2/s", "best_power": "W/m^2"}
    assert described(found.assign_attrs(port="heave")).port_velocity.attrs["units"] == "1/s"
    assert all(unit != ATTRS[name].units for at in (AT_VOLUME, AT_ROTATION) for name, unit in at.items())
    for port in ("pitch", '{"dofs":{"Roll":1.0}}: moment against angular velocity, impedance in N m s'):
        assert described(found.assign_attrs(port=port)).port_velocity.attrs["units"] == "rad/(m s)"


def test_real_datasets_are_left_as_they_are():
    ds = rao(np.ones((1, 3, 2)))
    assert separated(ds).identical(ds)
    assert merged(ds).identical(ds)


@pytest.mark.parametrize("name", sorted(ATTRS))
def test_every_variable_has_a_unit_and_a_meaning(name):
    quantity = ATTRS[name]
    assert quantity.units
    assert quantity.long_name
    assert len(set(quantity.dims)) == len(quantity.dims)


def dimension(units):
    """Powers of metre, kilogram and second of a unit without prefix, "kg/(m^2 s)", shape (3,)."""
    known = {"1": (0, 0, 0), "rad": (0, 0, 0), "m": (1, 0, 0), "kg": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2)}
    known |= {"W": (2, 1, -3), "J": (2, 1, -2)}
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
        ("prestress_stiffness", "hydrostatic_stiffness"),
        ("gas_stiffness", "hydrostatic_stiffness"),
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
        ("port_impedance port_velocity port_velocity", "matched_power"),
        ("best_damping port_velocity port_velocity", "best_power"),
        ("power_slope position", "absorbed_power"),
        ("excitation velocity time", "energy"),
        ("power_at_rest time", "energy"),
    ],
)
def test_units_are_those_of_the_equations_the_quantities_stand_in(left, right):
    both = (sum(dimension(ATTRS[name].units) for name in side.split()) for side in (left, right))
    assert np.array_equal(*both)


def test_derivatives_by_the_shape_are_per_metre():
    for name, quantity in ATTRS.items():
        for end, order in (("_slope", 1), ("_curvature", 2)):
            base = "absorbed_power" if name == "power_slope" else name.removesuffix(end)
            if name.endswith(end) and base in ATTRS:
                apart = dimension(ATTRS[base].units) - dimension(quantity.units)
                assert apart.tolist() == [order, 0, 0], name


def test_what_is_told_leaves_the_original_as_it_was():
    ds = xr.Dataset({"annual_energy": (("tuning", "design"), np.eye(2))}, coords={"design": ["A", "B"], "hs": [0.25]})
    found = described(ds)
    assert found.annual_energy.dims == ("design", "tuning")
    assert found.annual_energy.attrs["units"] == "MWh"
    assert found.hs.attrs["units"] == "m"
    assert not ds.annual_energy.attrs
    assert not ds.hs.attrs
    assert ds.annual_energy.dims == ("tuning", "design")


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
def test_units_of_a_year_are_those_of_the_means_and_ratios_it_is_told_in(left, right):
    both = (sum(dimension(ATTRS[name].units) for name in side.split()) for side in (left, right))
    assert np.array_equal(*both)


def test_results_of_a_member_know_no_design_where_they_are_of_the_shell_or_the_climate():
    """A campaign's dimensions, member by member: what is stored with others in front keeps its own order."""
    assert ATTRS["margin"].units == ATTRS["viable"].units == "1"
    for name in ("margin", "viable", "power_of_damping", "force_of_damping", "tried_damping"):
        assert ATTRS[name].dims[0] == "..."
    assert ("design" in ATTRS["margin"].dims, "design" in ATTRS["viable"].dims) == (False, True)


def test_usual_practice_is_missing_under_a_tuning_that_has_none_and_under_no_other():
    """Optima are of no practice; of anything else each tuning has its own."""
    coordinates = {"design": ["FSB", "VSWEC"], "tuning": ["fixed", "constrained"]}
    by, values = ("design", "tuning"), np.array([[1.0, np.nan], [2.0, np.nan]])
    check_finite(xr.Dataset({"practice_power": (by, values)}, coordinates), "x")
    with pytest.raises(DatabaseError, match="x: variable practice_power holds NaN"):
        check_finite(xr.Dataset({"practice_power": (by, values[:, ::-1])}, coordinates), "x")
    with pytest.raises(DatabaseError, match="x: variable capture_width holds NaN"):
        check_finite(xr.Dataset({"capture_width": (by, values)}, coordinates), "x")


def test_keys_a_study_varies_have_units_of_their_own_also_where_a_variable_is_called_so():
    coordinates = {"device.radius": [1.0, 2.0], "hs": [3.0, 4.0, 5.0], "design": ["A"], "tuning": ["one"]}
    dims = ("tuning", "hs", "design", "device.radius")
    ds = xr.Dataset({"annual_energy": (dims, np.ones((1, 3, 1, 2)))}, coordinates, {"varied": "device.radius hs"})
    ds["hs"].attrs = {"units": "ft"}
    found = described(ds)
    assert found.annual_energy.dims == ("hs", "device.radius", "design", "tuning")
    assert found.hs.attrs == {"units": "ft"}
    assert described(ds.assign_attrs(varied="device.radius")).hs.attrs["units"] == "m"
    with pytest.raises(DatabaseError, match=r"variables \['device.radius'\] are not in ATTRS"):
        described(ds.assign_attrs(varied="hs"))


def test_a_coordinate_put_in_order_is_still_one():
    ds = xr.Dataset({"added_mass_inf": (("radiating_dof", "influenced_dof"), np.ones((3, 2)))})
    found = described(ds.set_coords("added_mass_inf"))
    assert found.added_mass_inf.dims == ("influenced_dof", "radiating_dof")
    assert list(found.coords) == ["added_mass_inf"]
    assert not list(described(ds).coords)


def test_what_may_be_missing_for_several_reasons_may_be_so_for_each_and_no_other():
    """Practice: of a design that is not viable, and of optima; gains: of the first, and where the reference takes none."""
    coordinates = {"design": ["FSB", "VSWEC", "W"], "tuning": ["fixed", "constrained", "one"]}
    by, viable = ("design", "tuning"), ("design", [True, False, True])
    lost = np.zeros((3, 3), dtype=bool)
    lost[1] = True
    for name, column in (("practice_power", 1), ("gain_percent", 2)):
        power = np.array([[1.0, 2.0, 0.0], [np.nan] * 3, [3.0, 4.0, 5.0]])
        missing = lost.copy()
        missing[:, column] = True
        ds = xr.Dataset({"viable": viable, "annual_mean_power": (by, power)}, coordinates)
        check_finite(ds.assign({name: (by, np.where(missing, np.nan, 1.0))}), "x")
        for at in np.argwhere(~missing):
            worse = np.where(missing, np.nan, 1.0)
            worse[tuple(at)] = np.nan
            with pytest.raises(DatabaseError, match=f"x: variable {name} holds NaN"):
                check_finite(ds.assign({name: (by, worse)}), "x")


def test_what_no_design_has_a_part_in_is_never_missing():
    """The sea's own numbers, whichever design is not viable."""
    ds = xr.Dataset({"viable": ("design", [False, True]), "margin": ((), np.nan)}, {"design": ["A", "B"]})
    with pytest.raises(DatabaseError, match="x: variable margin holds NaN"):
        check_finite(ds, "x")


def test_gains_are_over_the_mean_power_of_the_year_where_both_are_there():
    """Corrected or not; a negative one is nothing to gain over either."""
    coordinates, by = {"design": ["FSB", "VSWEC"]}, ("design",)
    gains = {name: (by, [np.nan, np.nan]) for name in ("gain_low", "corrected_gain_low")}
    power = {"annual_mean_power": (by, [-1.0, 2.0]), "corrected_mean_power": (by, [1.0, 2.0])}
    check_finite(xr.Dataset(gains | power, coordinates), "x")
    power |= {"annual_mean_power": (by, [1.0, 2.0]), "corrected_mean_power": (by, [-1.0, 2.0])}
    with pytest.raises(DatabaseError, match="holds NaN"):
        check_finite(xr.Dataset(gains | power, coordinates), "x")


@pytest.mark.parametrize("units", [AT_VOLUME, AT_ROTATION], ids=["volume", "rotation"])
def test_everything_a_port_changes_the_units_of_has_those_and_its_meaning(units):
    port = "volume: pressure" if units is AT_VOLUME else "pitch: moment"
    for name, unit in units.items():
        ds = xr.Dataset(
            {name: ([dim if dim != "..." else "x" for dim in ATTRS[name].dims], np.ones([1] * len(ATTRS[name].dims)))}
        )
        found = described(ds.assign_attrs(port=port))[name].attrs
        assert found == {"units": unit, "long_name": ATTRS[name].long_name}


def test_parts_of_a_complex_number_are_put_together_real_part_first():
    ds = rao(np.array([1.0 + 2j, -3.0, 4j]).reshape(1, 3, 1) * np.ones(2))
    parts = separated(ds)
    np.testing.assert_array_equal(parts.rao.sel(complex="re").transpose(*ds.rao.dims).values, ds.rao.values.real)
    np.testing.assert_array_equal(parts.rao.sel(complex="im").transpose(*ds.rao.dims).values, ds.rao.values.imag)
    swapped = merged(parts.isel(complex=[1, 0]))
    np.testing.assert_array_equal(swapped.rao.transpose(*ds.rao.dims).values, ds.rao.values)
    assert "complex" not in swapped.coords
