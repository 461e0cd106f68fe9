"""Damper and spring at a port."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.errors import ConfigError
from vsb.motion.port import LinearPto


@pytest.mark.parametrize("port", [None, np.array([0.5, -1.0, 2.0])])
def test_force_is_along_the_port_and_power_is_c_v_squared(port):
    pto, velocity = LinearPto(8e3, 5e2, port), np.array([0.3, -0.2, 0.7])
    direction = pto.direction(3)
    assert direction.tolist() == ([1.0, 0.0, 0.0] if port is None else port.tolist())
    speed = direction @ velocity
    np.testing.assert_allclose(pto.matrix(3) @ velocity, 8e3 * speed * direction)
    np.testing.assert_allclose(pto.spring(3) @ velocity, 5e2 * speed * direction)
    assert velocity @ pto.matrix(3) @ velocity == pytest.approx(8e3 * speed**2)


@given(st.floats(0.01, 100.0), st.floats(-0.9, 20.0), st.floats(0.01, 1.0))
def test_series_compliance(damping, stiffness, compliance):
    """1/Z of the series is 1/(c + i k/omega) - i omega C, also for the relaxing damper beside its spring."""
    omega = np.array([0.3, 1.0, 4.0])
    series = 1 / (1 / (damping + 1j * stiffness / omega) - 1j * omega * compliance)
    pto = LinearPto(damping, stiffness)
    felt = pto.behind(compliance, omega)
    size = np.abs(series).max()
    assert felt.damping + 1j * felt.stiffness / omega == pytest.approx(series, rel=1e-9, abs=1e-9 * size)
    beside, own = pto.relaxed(compliance)
    relaxing = 1j * beside.stiffness / omega + 1 / (1 / beside.damping - 1j * omega * own)
    assert relaxing == pytest.approx(series, rel=1e-9, abs=1e-9 * size)


def test_spring_that_makes_the_air_chamber_unstable_is_refused():
    for stiffness in (-2.0, -3.5):
        words = (
            rf"^pto.stiffness: received {stiffness:g}, with which the gas before the take-off does not rest; needs more"
        )
        with pytest.raises(ConfigError, match=rf"{words} than -2$"):
            LinearPto(1.0, stiffness).relaxed(0.5)
    assert LinearPto(1.0, -1.9).relaxed(0.5)[1] == pytest.approx(0.5 * 0.05)
