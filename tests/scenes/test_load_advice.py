"""Advice on a shell that does not carry its load has been tried, and ends."""

import pytest

from vsb.errors import ConfigError
from vsb.scenes.load_advice import advised
from vsb.scenes.rest import reference_shell
from vsb.study.study import parse


@pytest.mark.slow
@pytest.mark.parametrize("gas", [{}, {"gas": {}}], ids=["open", "trapped"])
def test_a_wall_that_no_pressure_carries_is_told_the_least_that_stands(gas):
    """Of rubber of 1 MPa, 12 mm thick and 3.2 m in radius: it inflates without bound from 1.24 mu h/r = 4.65 kPa, and
    buckles below the 32 kPa of the water at its keel, so that "more" and "less pressure" would be advised in turn.
    """
    device = {"radius": 3.2, "thickness": 0.012, "density": 1100.0, "internal_pressure": 16500.0, **gas}
    device["material"] = {"law": "neo_hookean", "mu": 1e6}
    study = parse(
        {"study": "a", "device": device, "modes": {"degree": 4}, "reference_shape": "equilibrium",
         "designs": {"V": {}}, "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip
    with pytest.raises(ConfigError) as error:
        reference_shell(study)
    text = str(advised(study, error.value))
    assert "no device.internal_pressure from 0 to" in text
    assert "from about" in text
    assert "mm at" in text
    assert "or from a shear modulus of" in text
