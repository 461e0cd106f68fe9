"""Meridians and their derivatives."""

import numpy as np
import pytest

from vsb.shell.curve import bend, curve
from vsb.study.meridian import capsule

PHI = np.linspace(0.05, 3.1, 40)


def test_curve_is_the_sum_of_its_terms():
    body = capsule(1.0, 2.0)
    for i, phi in enumerate(PHI):
        assert [part[i] for part in curve(body, PHI)] == pytest.approx(body.at(phi), abs=1e-13)


def test_derivatives_match_differences():
    body, h = capsule(1.0, 2.0), 1e-5
    before, at, after = (curve(body, PHI + step) for step in (-h, 0.0, h))
    ddx, ddz = bend(body, PHI)
    for value, slope in ((0, at.dx), (1, at.dz), (2, ddx), (3, ddz)):
        assert (after[value] - before[value]) / (2 * h) == pytest.approx(slope, abs=1e-8)
