import numpy as np
import pytest

from vsb.shell.legendre import legendre
from vsb.shell.mode import Mode, _natural_shape, natural_shapes, scaled
from vsb.shell.modes import ModeBasis
from vsb.shell.sphere import Shell
from vsb.study.meridian import spheroid

OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))


def test_a_mode_of_one_degree_has_one_part():
    mode = scaled("Membrane2", 2, -3.0, 1.0)
    assert mode.parts == ((2, mode.radial, mode.meridional),)
    assert mode.radial > 0
    assert Mode("a", 1, 1.0, 1.0, ((2, 0.5, 0.0),)).parts == ((1, 1.0, 1.0), (2, 0.5, 0.0))


def test_natural_shapes_are_scaled_and_ascend():
    modes = natural_shapes(OBLATE, 6)
    basis = ModeBasis(OBLATE, modes, 3000.0, bending=True)
    v, u = basis.displacement(np.linspace(0.0, np.pi, 4001))
    assert [mode.label for mode in modes] == [f"Shell{i}" for i in range(1, 13)]
    assert np.hypot(v, u).max(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (v[:, 0] > 0).all()
    assert (np.diff(basis.dry_frequencies) > 0).all()
    assert sorted(mode.parts[0][0] for mode in modes[:3]) == [2, 3, 4]  # as of a sphere's lower branch


def test_a_body_alike_above_and_below_has_even_and_odd_modes():
    basis = ModeBasis(OBLATE, natural_shapes(OBLATE, 6), 3000.0, bending=True)
    phi = np.linspace(0.2, 1.4, 5)
    (above, _), (below, _) = basis.displacement(phi), basis.displacement(np.pi - phi)
    even, odd = (np.abs(above - sign * below).max(axis=1) < 1e-9 for sign in (1, -1))
    assert (even ^ odd).all()


@pytest.mark.parametrize(("along", "degree"), [(0.5, 4), (0.4, 2)])
def test_a_shape_of_many_degrees_is_told_by_the_one_that_moves_it_most(along, degree):
    """Along the meridian U dP_n/dphi moves it as sqrt(n (n + 1)) U does: of degree 4 by 4.47 U, here beside 2 P_2."""
    shape = np.zeros(9)
    shape[2], shape[4 + 4] = 2.0, along
    mode = _natural_shape("Shell1", shape)
    assert mode.degree == degree
    assert sorted(part[0] for part in mode.parts) == [0, 1, 2, 3, 4]
    v, u = ({part[0]: part[i] for part in mode.parts} for i in (1, 2))
    assert u[4] / v[2] == pytest.approx(along / 2.0, rel=1e-14)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_shape_that_leaves_the_top_at_rest_is_positive_at_the_keel(sign):
    """P_1 - P_2 is 0 at the top and -2 at the keel."""
    mode = _natural_shape("Shell1", np.array([0.0, sign, -sign, 0.0, 0.0]))
    v = {part[0]: part[1] for part in mode.parts}
    assert (v[1], v[2]) == pytest.approx((-0.5, 0.5), rel=1e-12)


def test_a_shell_of_another_meridian_has_two_modes_of_the_first_degree_if_none_is_asked_for():
    """Degree 0 alone would leave the surface no way to move along itself."""
    assert natural_shapes(OBLATE, 0) == natural_shapes(OBLATE, 1)
    assert [mode.label for mode in natural_shapes(OBLATE, 0)] == ["Shell1", "Shell2"]


@pytest.mark.parametrize(("radial", "meridional"), [(3.0, 1.0), (-0.2, 0.7), (0.1, -0.4), (-1e-3, -2.0)])
@pytest.mark.parametrize("degree", [1, 2, 5, 9])
def test_a_shape_of_one_degree_moves_the_shell_by_one_at_most_and_outwards_at_the_top(degree, radial, meridional):
    """Whatever its signs; its two amplitudes keep their ratio, and by a fine grid none goes farther."""
    mode = scaled("Some", degree, radial, meridional)
    phi = np.linspace(0.0, np.pi, 40001)
    p, dp, _ = legendre(degree, phi)
    largest = np.hypot(mode.radial * p[degree], mode.meridional * dp[degree]).max()
    assert 1 - (degree + 1) ** 4 * phi[1] ** 2 < largest < 1 + 1e-12
    assert mode.radial > 0
    assert mode.meridional / mode.radial == pytest.approx(meridional / radial, rel=1e-13)
    assert (mode.label, mode.degree, mode.others) == ("Some", degree, ())


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_natural_shape_is_turned_by_its_top_where_that_moves_and_scaled_as_a_whole(sign):
    """Up at the keel and down at the top; the parts of all degrees keep their ratios, the leading one stands first."""
    shape = sign * np.array([0.1, -0.3, 0.2, -0.6, 0.05, 0.25, -0.1])
    mode = _natural_shape("Shell7", shape)
    parts = {n: (v, u) for n, v, u in mode.parts}
    amplitudes = np.array([*(parts[n][0] for n in range(4)), *(parts[n][1] for n in range(1, 4))])
    factor = amplitudes[0] / shape[0]
    np.testing.assert_allclose(amplitudes, factor * shape, rtol=1e-13)
    assert sum(parts[n][0] for n in range(4)) > 0
    p, dp, _ = legendre(3, np.linspace(0.0, np.pi, 40001))
    v, u = amplitudes[:4] @ p, amplitudes[4:] @ dp[1:]
    assert np.hypot(v, u).max() == pytest.approx(1.0, abs=1e-7)
    assert mode.label == "Shell7"
    assert mode.degree == mode.parts[0][0] == 3
    assert [part[0] for part in mode.others] == [0, 1, 2]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("top", "decides"), [(3e-6, "top"), (-3e-6, "top"), (0.3e-6, "keel"), (-0.3e-6, "keel"), (0.2, "top")]
)
def test_the_top_decides_which_way_a_shape_is_turned_unless_it_hardly_moves(top, decides, sign):
    """P_1 - P_2 and a little of P_0: at the keel it moves most, by 2, and the other way."""
    shape = sign * np.array([top * 2.0, 1.0, -1.0, 0.0, 0.0])
    v = {part[0]: part[1] for part in _natural_shape("Shell1", shape).parts}
    at_top, at_keel = v[0] + v[1] + v[2], v[0] - v[1] + v[2]
    assert (at_top if decides == "top" else at_keel) > 0
    assert abs(at_keel) == pytest.approx(1.0, abs=0.3)
