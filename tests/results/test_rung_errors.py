"""Error budgets of take-offs: which impedance, which modes, and those within limits."""

import numpy as np
import pytest
import xarray as xr

from vsb.motion.port import Port
from vsb.results.budget import Budget, Source
from vsb.results.rung_errors import LIMITED, Errors, Loaded, _impedance, _of_modes, _with_limited

PORT = Port(np.array([2.0]), np.array([1 / (3 + 4j)]), np.array([1.0 + 0j]), compliance=1.0)


def test_the_best_force_of_all_is_that_of_the_conjugate_impedance():
    """At which a load takes the matched power, 1/2 Re Z |V|^2 = |V0|^2/(8 Re Y)."""
    matched = _impedance(PORT, Loaded("matched", None, None, 1.0))
    assert matched[0] == pytest.approx(3 - 4j)
    taken = 0.5 * matched.real * np.abs(PORT.velocity_under(matched)) ** 2
    assert taken == pytest.approx(PORT.matched_power)
    assert _impedance(PORT, Loaded("fixed", 5.0, 6.0, 1.0))[0] == pytest.approx(5 + 3j)


def test_modes_left_out_are_of_their_design_sea_and_take_off():
    dims = ("design", "wave", "take_off", "end")
    power = np.zeros((2, 2, 2, 2))
    power[0] = [[[-0.3, 0.0], [-0.2, 0.0]], [[0.0, 0.1], [0.0, 0.05]]]
    coords = {"design": ["A", "FSB"], "wave": ["w", "v"], "take_off": ["given", "optimal"], "end": ["low", "high"]}
    known = xr.Dataset({"power": (dims, power)}, coords)
    for wave, rung, low, high in (
        ("w", "fixed", -60.0, 0.0), ("w", "best_damper", -40.0, 0.0), ("w", "matched", -40.0, 0.0),
        ("v", "fixed", 0.0, 20.0), ("v", "best_damper_all_seas", 0.0, 10.0),
    ):  # fmt: skip
        (source,) = _of_modes(known, "A", wave, rung, "power", 200.0)
        assert (source.low, source.high, source.kind, source.shared) == (low, high, "bound", False)
    assert _of_modes(known, "FSB", "w", "fixed", "power", 200.0) == []
    assert _of_modes(known, "A", "w", "fixed", "gain", 1.0) == []


def test_an_optimum_within_limits_is_as_wrong_as_the_worse_of_its_ends():
    loads = {("A", "w"): [Loaded("best_damper", 1.0, 0.0, 10.0), Loaded("matched", None, None, 40.0)]}
    loads["A", "w"].append(Loaded(LIMITED, None, None, 20.0))
    known = {
        ("A", "w", "best_damper"): Errors(Budget((Source.within("c", 1.0),)), Budget((Source.within("c", 0.2),))),
        ("A", "w", "matched"): Errors(Budget((Source.within("c", 2.0),)), Budget((Source.within("c", 0.3),))),
    }
    found = _with_limited(known, loads)["A", "w", LIMITED]
    assert found.power.interval(20.0) == (18.0, 22.0)  # 10 % rather than 5 %
    assert found.gain.interval(0.0) == (-0.3, 0.3)
