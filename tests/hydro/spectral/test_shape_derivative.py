"""Derivatives of added mass, damping and excitation by the wetted shape against differences of solutions."""

import numpy as np
import pytest

from vsb.engine.hydro.dofs import displacements
from vsb.engine.hydro.spectral.shape_derivative import shape_derivative
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import complete_basis
from vsb.engine.shell.meridian import Curve
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError

BASIS = complete_basis(Shell(2.0, 0.01, 1e7, 0.3, 2700.0), 3, 17170.0)
MOVED = displacements(["Radial0", "Radial1", "Meridional1", "Radial3", "Meridional3"])
OMEGAS = [0.5, 2.0]


def problem(amplitude, depth, nodes=32):
    """A deformed shell, floating deeper than half."""
    rest = np.array([0.0, 0.1, 0.05, -0.1, 0.05, 0.04, 0.1])
    return SpectralProblem(DeformedShell(BASIS, -0.3, rest + amplitude), MOVED, 1025.0, 9.81, nodes, depth)


@pytest.mark.parametrize("depth", [np.inf, 4.0])
def test_derivatives_are_those_of_differences(depth):
    ways = np.vstack([np.eye(7)[:2], np.random.default_rng(3).normal(size=(2, 7)) / 4])

    def directions(colatitude):
        shapes = DeformedShell(BASIS, 0.0).meridian(colatitude)
        return Curve(*(ways @ part for part in shapes[4:]))

    def solved(amplitude):
        one = problem(amplitude, depth)
        forces = one.onto @ one.potentials(OMEGAS)
        return forces[..., :-1], one.gravity * forces[..., -1]

    found = shape_derivative(problem(np.zeros(7), depth), OMEGAS, directions)
    at_rest = solved(np.zeros(7))
    for values, expected in zip((found.radiation, found.excitation), at_rest, strict=True):
        np.testing.assert_allclose(values, expected, rtol=1e-12)
    for k, way in enumerate(ways):
        steps = {
            h: [np.subtract(*each) / (2 * h) for each in zip(solved(h * way), solved(-h * way), strict=True)]
            for h in (2e-3, 4e-3)
        }
        for change, fine, coarse in zip(
            (found.radiation_change, found.excitation_change), *steps.values(), strict=True
        ):
            expected = (4 * fine - coarse) / 3
            for part in (np.real, np.imag):
                off = np.abs(part(change[:, k] - expected)).max()
                assert off < 1e-8 * np.abs(part(expected)).max()


def test_only_axisymmetric_motion_has_derivatives():
    surge = SpectralProblem(DeformedShell(BASIS, 0.0), displacements(["Surge"], 1), 1025.0, 9.81, 16)
    with pytest.raises(ConfigError, match="azimuthal order 1"):
        shape_derivative(surge, [1.0], lambda phi: Curve(*np.zeros((4, 0, len(phi)))))
