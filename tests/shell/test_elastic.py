"""The elastic shell by itself; its derivatives, statics and buckling are in `test_loaded`."""

from dataclasses import replace

import numpy as np
import pytest

from vsb.shell.elastic import ElasticShell, converged_degree
from vsb.shell.modes import mode_basis
from vsb.shell.sphere import Shell


@pytest.fixture(scope="module")
def elastic(seed):
    return ElasticShell(mode_basis(seed.device, "membrane", 6))


def test_a_sphere_that_breathes_grows_by_its_area(elastic, seed):
    r, q = seed.device.radius, np.zeros(len(elastic.basis.labels))
    assert elastic.volume(q) == pytest.approx(4 / 3 * np.pi * r**3, rel=1e-13)
    at = elastic.basis.labels.index("Membrane0")
    assert elastic.volume_gradient(q)[at] == pytest.approx(4 * np.pi * r**2, rel=1e-13)
    _, area = elastic.rings
    assert area.sum() == pytest.approx(4 * np.pi * r**2, rel=1e-13)


def test_shapes_are_tabulated_once_for_all_materials_and_for_no_other_shapes(elastic, seed):
    stiffer = ElasticShell(mode_basis(seed.device.model_copy(update={"young_modulus": 1e9}), "membrane", 6))
    heavier = ElasticShell(replace(elastic.basis, total_mass=1.0, beta=0.0))
    finer = ElasticShell(mode_basis(seed.device, "membrane", 7))
    assert stiffer._tables is elastic._tables is heavier._tables
    assert finer._tables is not elastic._tables
    q = np.linspace(0.0, 0.01, len(elastic.basis.labels))
    assert stiffer.energy(q) == pytest.approx(100 * elastic.energy(q), rel=1e-12)


@pytest.mark.parametrize(("thickness", "degree"), [(0.01, 42), (0.1, 40), (0.0001, 412)])
def test_degrees_that_resolve_buckling_grow_with_slenderness(thickness, degree):
    """1.6 sqrt(r/h) [12 (1 - nu^2)]^(1/4), at least 40."""
    shell = Shell(radius=2.0, thickness=thickness, young_modulus=1e7, poisson_ratio=0.3, density=2700.0)
    assert converged_degree(shell) == degree
