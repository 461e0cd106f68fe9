"""The elastic shell without load; loads, statics and buckling are in `test_loaded`."""

import numpy as np
import pytest

from vsb.engine.shell.loaded import ElasticShell
from vsb.engine.shell.meridian import capsule, spheroid
from vsb.engine.shell.modes import ModeBasis, curvature_shapes, mode_basis, natural_shapes, shell_modes
from vsb.engine.shell.shell import Shell


@pytest.fixture(scope="module")
def elastic(seed):
    return ElasticShell(mode_basis(seed.device, "membrane", 6))


@pytest.mark.parametrize(
    "meridian", [spheroid(2.0, 3.0), spheroid(2.0, 6.0), capsule(2.0, 1.0)], ids=["flat", "long", "capsule"]
)
def test_area_volume_and_linear_stiffness_of_other_meridians(meridian):
    shell = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, meridian)
    basis = ModeBasis(shell, natural_shapes(shell, 4), 3000.0, bending=True)
    elastic, q = ElasticShell(basis), np.zeros(len(basis.labels))
    colatitude, area = elastic.rings
    assert area.sum() == pytest.approx(meridian.area, rel=1e-11)
    assert area @ shell.at_rest(colatitude).z == pytest.approx(0.0, abs=1e-9)
    assert elastic.volume(q) == pytest.approx(meridian.volume, rel=1e-12)
    stiffness = elastic.stiffness(q)
    np.testing.assert_allclose(stiffness, basis.stiffness, atol=1e-9 * np.abs(stiffness).max())
    (along, around), nu = curvature_shapes(basis, colatitude), shell.poisson_ratio
    bending = along @ (area * (along + nu * around)).T + around @ (area * (around + nu * along)).T
    bending *= shell.bending_stiffness
    np.testing.assert_allclose(bending[1:, 1:], basis.integrated("bending")[1:, 1:], atol=1e-6)


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_geometric_stiffness_is_the_work_of_membrane_forces_on_second_order_strains(meridian):
    shell = Shell(2.0, 0.01, 1e7, 0.3, 2700.0, meridian)
    elastic = ElasticShell(ModeBasis(shell, shell_modes(shell, "full", 4), 1e4, bending=True))
    colatitude, area = elastic.rings
    along, around = 3.0 + np.cos(colatitude), -2.0 + np.sin(colatitude) ** 2
    stiffness = elastic.geometric_stiffness(along, around)

    def work(q):
        meridional, hoop = elastic.strains(q)
        return float(area @ (along * meridional + around * hoop))

    random = np.random.default_rng(6)
    for q in 0.1 * random.normal(size=(5, len(elastic.basis.labels))):
        assert work(q) + work(-q) == pytest.approx(q @ stiffness @ q, rel=1e-10)
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-12 * np.abs(stiffness).max())


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_force_stiffness_and_volume_derivatives_match_differences(meridian):
    shell = Shell(2.0, 0.05, 1e7, 0.3, 2700.0, meridian)
    elastic = ElasticShell(ModeBasis(shell, shell_modes(shell, "full", 3), 1e4, bending=True))
    count, step = len(elastic.basis.labels), 1e-4
    q = 0.08 * np.cos(1.7 * np.arange(count) + 0.4)

    def slope(function):
        return np.array([(function(q + step * e) - function(q - step * e)) / (2 * step) for e in np.eye(count)])

    for found, expected in (
        (elastic.force(q), -slope(elastic.energy)),
        (elastic.stiffness(q), -slope(elastic.force)),
        (elastic.volume_gradient(q), slope(elastic.volume)),
        (elastic.volume_hessian(q), slope(elastic.volume_gradient)),
    ):
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    strains = elastic.deformation(q)
    work = np.sum(strains * shell.wall.resultants(strains), axis=0) @ elastic.rings[1] / 2
    assert elastic.energy(q) == pytest.approx(work, rel=1e-12)
