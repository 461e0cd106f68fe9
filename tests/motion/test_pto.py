"""Damper and spring at a port: they act along it alone, and take c V^2."""

import numpy as np
import pytest

from vsb.motion.pto import LinearPto


@pytest.mark.parametrize("port", [None, np.array([0.5, -1.0, 2.0])])
def test_force_is_along_the_port_and_power_is_that_of_its_velocity(port):
    pto, velocity = LinearPto(8e3, 5e2, port), np.array([0.3, -0.2, 0.7])
    direction = pto.direction(3)
    assert direction.tolist() == ([1.0, 0.0, 0.0] if port is None else port.tolist())
    speed = direction @ velocity
    np.testing.assert_allclose(pto.matrix(3) @ velocity, 8e3 * speed * direction)
    np.testing.assert_allclose(pto.spring(3) @ velocity, 5e2 * speed * direction)
    assert velocity @ pto.matrix(3) @ velocity == pytest.approx(8e3 * speed**2)


def test_a_damper_of_each_frequency_has_a_matrix_of_each():
    matrices = LinearPto(np.array([1.0, 2.0])).matrix(2)
    np.testing.assert_array_equal(matrices, [[[1.0, 0.0], [0.0, 0.0]], [[2.0, 0.0], [0.0, 0.0]]])
