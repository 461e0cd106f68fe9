"""Units: a quantity is the very number a file would give in SI, and no unit is guessed."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.keys.meanings import KEYS
from vsb.tools.units import parsed_unit, split, unit, value_in
from vsb.tools.variables import KINDS


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("15 mm", "m", 0.015),
        ("15mm", "m", 0.015),
        ("6.5 ft", "m", 1.9812),
        ("30 %", "-", 0.3),
        ("1.1 g/cm3", "kg/m^3", 1100.0),
        ("1.1 g/cm³", "kg/m^3", 1100.0),
        ("1e3 kg m^-3", "kg/m^3", 1000.0),
        ("8 kN*s/m", "N s/m", 8000.0),
        ("8 kN/(m/s)", "N s/m", 8000.0),
        ("3 kNm", "N m", 3000.0),
        ("3 N-m", "N m", 3.0),
        ("45°", "degrees", 45.0),
        ("0.5 rad", "degrees", math.degrees(0.5)),
        ("0.2 Hz", "rad/s", 0.4 * math.pi),
        ("12 m^2 s/rad", "m^2/Hz", 24 * math.pi),
        ("2 psi", "Pa", 2 * 4.4482216152605 / 0.0254**2),
    ],
)
def test_quantities_are_read_in_the_unit_of_their_key(text, unit, value):
    """By hand from the definitions: 1 in = 25.4 mm, 1 lbf = 0.45359237 kg x 9.80665 m/s^2, Hz = 2 pi rad/s."""
    assert value_in(text, unit) == pytest.approx(value, rel=1e-15)


@given(st.decimals(min_value=-1000, max_value=1000, places=4))
def test_a_quantity_is_the_number_written_out(number):
    """Ids follow from numbers: 16.5 kPa must be the float 16500.0, not its neighbour."""
    assert value_in(f"{number} mm", "m") == float(number.scaleb(-3))
    assert value_in(f"{number} kPa", "Pa") == float(number.scaleb(3))


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("15 kg", "m", "kg is of another kind"),
        ("8 kN/m", "N s/m", "kN/m is of another kind"),
        ("3 1/s", "rad/s", "1/s is of another kind"),
        ("40 Mpa", "Pa", r"'Mpa' is no unit known here; did you mean MPa\?"),
        ("40 mpa", "Pa", "did you mean mPa?"),
        ("3 kn", "N", r"did you mean kN\?"),
        ("3 N/(m", "N/m", "a bracket of the unit is not closed"),
        ("2 m)", "m", "a bracket is closed that is not open"),
        ("3 m/", "m", "'/' is no unit"),
        ("1.0e5", "m", "is no number with a unit"),
        ("mm", "m", "is no number with a unit"),
    ],
)
def test_what_is_no_quantity_of_a_key_is_refused(text, unit, message):
    with pytest.raises(ValueError, match=message):
        value_in(text, unit)


@pytest.mark.parametrize("text", ["1e999999999 m", "1" * 5000 + " m", "3 m^999999999"])
def test_no_quantity_takes_long_to_read(text):
    """Fractions of such numbers would fill the memory."""
    if split(text):
        with pytest.raises(ValueError, match="no unit"):
            value_in(text, "m")


@pytest.mark.parametrize(
    "text", ["m^2/Hz/deg", "rad/(m s)", "cm/s", "m2 s rad-1", "m**2.s", "m²·s/rad", "m⁻¹", "m^{2}", "cycles per second"]
)
def test_headers_and_values_follow_one_rule_of_products(text):
    """Only the angles, by their names in headers, and small letters differ."""
    assert unit(text).in_radians() == unit(text.upper()).in_radians() == parsed_unit(text)


def test_a_header_tells_degrees_from_radians():
    """A density per degree is another quantity than per radian per second, whereas 180 degrees are pi radians."""
    assert len({unit(f"m^2 s/{angle}").powers for angle in ("rad", "deg", "cycle")}) == 3
    assert len({parsed_unit(f"m^2 s/{angle}").powers for angle in ("rad", "deg", "cycle")}) == 1


@pytest.mark.parametrize(
    "text", ["", "()", "m/", "m//s", "m**s", "12", "m2/(Hz", "s)", "4s", "V", "t", "kN", "m " * 50]
)
def test_what_is_no_unit_of_a_header_is_refused(text):
    assert unit(text) is None


def test_units_of_all_keys_and_ports_are_known():
    of_ports = {getattr(kind, name) for kind in KINDS.values() for name in ("load_unit", "damping_unit", "motion_unit")}
    of_keys = {key.unit for section in KEYS.values() for key in section.values() if key.unit and not key.at_port}
    for known in {one for units in of_keys | of_ports for one in units.split(", ")}:
        assert parsed_unit(known).factor > 0
