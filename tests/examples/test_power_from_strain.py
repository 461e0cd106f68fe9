"""Power from strain over a year: the order of take-offs, and what holds for any of them."""

import pytest

from examples.power_from_strain import AREA, BOTH, FLEXIBLE, RIGID, SEAS, power_of_year, with_take_off
from vsb.stages.check import read_seas
from vsb.study.study import load


@pytest.mark.slow
def test_shares_of_a_year_of_a_soft_shell(tmp_path):
    """An independent computation of the shell of 10 MPa gives 0.8, 9.0, 14.3, 94.6 and 94.6 %."""
    study, climate = load("config/pressurised.yaml"), read_seas(SEAS)

    def power(pto, designs=FLEXIBLE):
        return power_of_year(with_take_off(study, 1.0, pto, designs), climate, tmp_path)

    rigid, held = power({"port": "heave"}, RIGID), {"place": "heave"}
    area, moored = power({"port": AREA}), power({"port": AREA, "held": held})
    spread = power({"port": {"distributed": "membrane"}, "held": held})
    apart, together = (power({"ports": BOTH, "matrix": matrix}) for matrix in ("diagonal", "full"))
    assert together >= apart * (1 - 1e-9)
    found = [100 * one / rigid for one in (area, moored, spread, apart, together)]
    assert found == pytest.approx([0.8, 9.0, 14.3, 94.6, 94.6], abs=0.2)
