"""Resolution of frequencies and panels."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.hydro.panels.mesh import graded_colatitudes
from vsb.study import sections
from vsb.study.blocks import frequency_step, tolerance_rows, wave_rows


@given(st.floats(0.01, 1000.0), st.floats(1.0, 30.0))
def test_step_is_the_largest_round_number_below_its_bound(radius, gravity):
    step, bound = frequency_step(radius, gravity), 0.05 * math.sqrt(gravity / radius)
    assert step <= bound * (1 + 1e-12)
    assert bound < 2.5 * step * (1 + 1e-12)
    assert f"{step:.0e}"[0] in "125"
    assert float(f"{step:.0e}") == step


@given(st.floats(1e-5, 0.1))
def test_rows_give_second_order_error_below_the_tolerance(tolerance):
    rows = tolerance_rows(tolerance)
    assert rows % 2 == 0
    assert 1e-3 * (40 / rows) ** 2 <= tolerance * (1 + 1e-12)  # second order: the error is met
    assert rows == 2 or 1e-3 * (40 / (rows - 2)) ** 2 > tolerance * (1 - 1e-12)  # and by no fewer


@pytest.mark.parametrize(("radius", "wavelength"), [(2.0, 0.1), (2.0, 0.43), (2.0, 3.0), (5.0, 1.0)])
def test_six_rows_lie_within_half_a_wavelength_of_the_surface(radius, wavelength):
    def within(rows):
        depth = -radius * np.cos(graded_colatitudes(np.pi / 2, rows))
        return np.sum(depth[1:] <= wavelength / 2 * (1 + 1e-12))

    rows = wave_rows(radius, wavelength)
    assert rows % 2 == 0
    assert within(rows) >= 6 > within(rows - 2)


@pytest.mark.parametrize(
    ("instants", "every"),
    [(0, 0), (1, 1), (2**17, 1), (2**17 + 1, 2), (9 * 2**17 + 1, 10), (2**22, 10)],
)
def test_long_records_are_thinned(instants, every):
    assert sections.thinning(instants) == every
