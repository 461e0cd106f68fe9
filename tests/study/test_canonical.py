"""Canonical JSON: one text for one meaning, and the ids made of it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.study import body, body_file, campaign, device, drag, sections, take_off, waves
from vsb.study.canonical import canonical, content_id, result_id
from vsb.study.quantities import Section

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@given(st.dictionaries(st.text(), PLAIN))
def test_the_order_of_keys_means_nothing(data):
    assert canonical(dict(reversed(data.items()))) == canonical(data)
    assert content_id(dict(reversed(data.items()))) == content_id(data)


def test_infinity_is_a_word_and_zero_has_no_sign():
    assert canonical({"b": (math.inf, -math.inf), "a": -0.0}) == '{"a":0.0,"b":["inf","-inf"]}'


def test_nan_is_no_value():
    with pytest.raises(ValueError, match="Out of range float values"):
        canonical({"a": math.nan})


def test_an_id_is_sixteen_digits_of_a_published_hash():
    """sha256 of '{}', as any other tool gives it."""
    assert content_id({}) == "44136fa355b3678a"


def test_a_result_without_inputs_has_the_id_of_its_specification():
    assert result_id({"a": 1}) == content_id({"a": 1})
    assert (
        len({result_id({"a": 1}), result_id({"a": 1}, "x"), result_id({"a": 1}, "x", "y"), result_id({"a": 2}, "x")})
        == 4
    )


DEFAULTS = {
    "Body.length": 1.0, "BodyFile.lid": 8, "BodyFile.symmetry": "auto", "BodyFile.wave_direction": (0.0,),
    "BodyHydro.added_mass_inf": "fitted", "BodyHydro.tolerance": 0.01, "Constrained.seconds": 10.0, "Constrained.seed": 1,
    "Device.internal_pressure": 0.0, "Gas.adiabatic_index": 1.4, "Gas.atmospheric_pressure": 101325.0,
    "Hydro.model": "linear", "Hydro.omega_max": 12.0, "Hydro.tolerance": 1e-3, "IrregularSea.amplitudes": "fixed", "IrregularSea.realisations": 1,
    "IrregularSea.seed": 1, "Jonswap.gamma": 3.3, "LinePort.line_from": (0.0, 0.0), "Modes.basis": "full",
    "Modes.degree": None, "Modes.order": 1, "Modes.tolerance": 0.005, "Pto.efficiency": 1.0, "Pto.force_limit": math.inf, "Pto.law": "linear",
    "Pto.port": "heave", "Pto.stiffness": 0.0, "Pto.stroke_limit": math.inf, "RayleighDamping.alpha": 0.0,
    "RayleighDamping.beta": 0.0, "Scatter.gamma": 3.3, "Scatter.spectrum": "jonswap", "ShellPort.against": "sea_bed",
    "ShellPort.direction": "vertical", "Simulation.duration": 60.0, "Simulation.initial_position": 0.0,
    "Simulation.initial_velocity": 0.0, "Simulation.tolerance": 1e-6, "Simulation.window": (40.0, 60.0),
    "Travelling.direction": 0.0, "Verify.model": "body_exact", "Verify.seas": 24, "Verify.seed": 1,
    "Water.density": 1025.0, "Water.depth": math.inf, "Water.gravity": 9.81,
}  # fmt: skip


def test_what_is_not_said_goes_on_meaning_the_same():
    """A default is not in the canonical form: with another one the same id would name other physics."""
    rooms = (body, body_file, campaign, device, drag, sections, take_off, waves)
    found = {
        f"{name}.{key}": field.default
        for name, model in ((name, model) for room in rooms for name, model in vars(room).items())
        if isinstance(model, type) and issubclass(model, Section)
        for key, field in model.model_fields.items()
    }
    assert {key: found[key] for key in DEFAULTS} == DEFAULTS
