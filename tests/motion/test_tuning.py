import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.motion.port import Port
from vsb.motion.tuning import (
    FINEST,
    Load,
    _ascent,
    _local_maxima,
    _summits,
    _with,
    best_damper_of_each,
    best_dampers,
    best_pairs,
    climbed,
    electrical_power,
    frequencies,
    mean_power,
    powers_of_all,
    squares,
)
from vsb.waves.seas import NO_WAVES, Sea


def random_port(rng, count=40, motions=3, drifting=False):
    """A passive buoy of a few coupled motions that radiate through one channel; one of them held by nothing."""
    omega = np.linspace(0.4, 4.0, count)
    mass = 10 ** rng.uniform(-1, 1, motions)
    stiffness = mass * rng.uniform(0.3, 6, motions) ** 2
    stiffness[0] *= not drifting
    push = rng.normal(size=motions) * np.exp(-(omega[:, None] ** 2) * rng.uniform(0, 0.3))
    radiated = push[:, :, None] * push[:, None, :] * omega[:, None, None] ** 3 * 10 ** rng.uniform(-3, 0)
    lost = radiated + 10 ** rng.uniform(-3, -1) * np.eye(motions)
    w = omega[:, None, None]
    dynamic = -(w**2) * np.diag(mass) - 1j * w * lost + np.diag(stiffness)
    b, rate = rng.normal(size=motions), -1j * omega
    free, forced = (np.linalg.solve(dynamic, x[..., None])[..., 0] @ b for x in (push, np.broadcast_to(b, push.shape)))
    return Port(omega, rate * forced, rate * free, np.inf if drifting else float(b @ (b / stiffness)))


def random_seas(rng, omega, count=6):
    """Regular waves, seas of one peak and of two."""
    seas = np.zeros((count, len(omega)))
    for i, sea in enumerate(seas):
        if i % 3 == 0:
            sea[rng.integers(len(omega))] = 1.0
            continue
        for share in (1.0, rng.uniform(0, 2))[: i % 3]:
            sea += share * np.exp(-0.5 * ((omega - rng.uniform(0.6, 3.5)) / rng.uniform(0.05, 0.8)) ** 2)
        sea[sea < 1e-9 * sea.max()] = 0.0
    return seas


def table(port, sea, efficiency, springs):
    """Power of a fine table of dampers beside some springs [W]."""
    dampers = np.geomspace(0.3 * port.impedance.real.min(), 30 * np.abs(port.impedance).max(), 120)
    c, k = (values.ravel() for values in np.meshgrid(dampers, springs))
    return powers_of_all(port, sea[None], c, k, efficiency).max()


@pytest.mark.parametrize("efficiency", [1.0, 0.8])
@pytest.mark.parametrize("seed", range(8))
def test_no_take_off_of_a_fine_table_beats_the_best(seed, efficiency):
    rng = np.random.default_rng(seed)
    port = random_port(rng)
    seas, given_spring = random_seas(rng, port.omega), (0.0, 0.3 / port.compliance)[seed % 2]
    dampers = best_dampers(port, seas, given_spring, efficiency)
    pairs = best_pairs(port, seas, dampers, efficiency)
    tuned, softest = -port.omega * port.impedance.imag, port.softest_spring * (1 - 1e-6)
    for i, sea in enumerate(seas):
        assert table(port, sea, efficiency, np.array([given_spring])) <= dampers.power[i] * (1 + 1e-9)
        low, high = max(min(tuned[sea > 0].min(), 0.0), softest), max(tuned[sea > 0].max(), 0.0)
        springs = np.concatenate([np.linspace(low, high, 100), np.clip(tuned[sea > 0], low, high)])
        assert table(port, sea, efficiency, springs) <= pairs.power[i] * (1 + 1e-9)
    assert mean_power(port, seas, *pairs[:2], efficiency) == pytest.approx(pairs.power, rel=1e-12)
    assert np.all(pairs.stiffness > port.softest_spring)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("efficiency", [1.0, 0.8])
@pytest.mark.parametrize("seed", range(4))
def test_what_nothing_holds_is_held_by_its_spring(seed, efficiency):
    """A port adrift rests stably with any spring above none: that tables begin at none, whose logarithm is nothing."""
    rng = np.random.default_rng(seed)
    port = random_port(rng, drifting=True)
    assert port.softest_spring == 0.0
    seas = random_seas(rng, port.omega)
    pairs = best_pairs(port, seas, best_dampers(port, seas, 0.0, efficiency), efficiency)
    tuned = -port.omega * port.impedance.imag
    for i, sea in enumerate(seas):
        high = max(tuned[sea > 0].max(), 1e-3 * np.abs(tuned).max())
        springs = np.linspace(1e-5 * high, high, 100)
        assert table(port, sea, efficiency, springs) <= pairs.power[i] * (1 + 1e-9)
    assert np.isfinite(pairs.stiffness).all()
    assert np.all(pairs.stiffness >= 0.0)


@pytest.mark.parametrize("seed", range(8))
def test_dampers_of_many_ports_are_those_of_each(seed):
    """To the last digit, one that does not move among them; and where power over the damper's logarithm is level."""
    rng = np.random.default_rng(seed)
    ports = [random_port(rng) for _ in range(5)]
    still = np.zeros_like(ports[0].velocity)
    ports.insert(2, Port(ports[0].omega, still, still, 0.0))
    sea = random_seas(rng, ports[0].omega)[seed % 6]
    found = best_damper_of_each(ports, sea)
    assert found.tolist() == [best_damper_of_each([port], sea)[0] for port in ports]
    assert best_damper_of_each(ports[::-1], 0 * sea).tolist() == [0.0] * 6
    for port, damping in zip(ports, found, strict=True):
        if port.moves:
            climbed = best_dampers(port, sea[None])
            assert damping == pytest.approx(climbed.damping[0], rel=1e-5)  # flat optimum: power is exact
            below, best, above = port.power(damping * np.exp([-1e-4, 0.0, 1e-4])) @ sea
            assert best == pytest.approx(climbed.power[0], rel=1e-14)
            assert abs(above - below) < 1e-11 * best
            assert max(above, below) < best


def test_of_two_maxima_of_a_port_the_higher_one_is_its_damper():
    """Two waves that want dampers a hundredfold apart: whichever brings more of the sea decides."""
    z = np.array([100.0 + 50.0j, 1e4 + 5e3j])
    port = Port(np.array([1.0, 2.0]), 1 / z, np.array([1.0, 1.0]) + 0j, 0.0)
    wants = np.abs(z)
    for low in (300.0, 30.0):  # in parts of the other wave's square: its matched power is a hundredth
        sea = np.array([low, 1.0])
        (damping,) = best_damper_of_each([port], sea)
        tried = np.geomspace(10, 1e5, 20001)
        assert damping == pytest.approx(tried[(port.power(tried) @ sea).argmax()], rel=1e-3)
    assert best_damper_of_each([port], np.array([1.0, 0.0]))[0] == pytest.approx(wants[0], rel=1e-9)
    assert best_damper_of_each([port], np.array([0.0, 1.0]))[0] == pytest.approx(wants[1], rel=1e-9)


def test_a_regular_wave_has_its_closed_forms():
    rng = np.random.default_rng(5)
    port, waves = random_port(rng), np.diag(np.linspace(0.5, 2.0, 40))
    dampers = best_dampers(port, waves)
    assert dampers.damping == pytest.approx(port.best_damping, rel=1e-5)  # flat optimum: power is exact
    assert dampers.power == pytest.approx(np.diag(waves) * port.best_power, rel=1e-9)
    pairs, stable = best_pairs(port, waves, dampers), -port.omega * port.impedance.imag > port.softest_spring
    assert stable.any()
    assert pairs.power[stable] == pytest.approx((np.diag(waves) * port.matched_power)[stable], rel=1e-9)
    assert pairs.damping[stable] == pytest.approx(port.impedance.real[stable], rel=1e-12)
    assert pairs.stiffness[stable] == pytest.approx((-port.omega * port.impedance.imag)[stable], rel=1e-12)


def test_a_wave_that_wants_a_spring_the_buoy_does_not_rest_with_gets_the_softest():
    """Matched it would take all there is, beside a rest it leaves at once."""
    z = np.array([500.0 + 2500.0j])  # wants -omega X = -5000 N/m
    port = Port(np.array([2.0]), 1 / z, np.array([1.0 + 0.0j]), 1e-3)  # rests with more than -1000 N/m
    squares = np.array([[1.0]])
    dampers = best_dampers(port, squares)
    best = best_pairs(port, squares, dampers)
    assert -1000.0 + 0.999e-3 < best.stiffness[0] < -990.0  # by the millionth that it must leave the buoy
    assert dampers.power[0] < best.power[0] < 0.9 * squares[0] @ port.matched_power
    rests = best_pairs(Port(port.omega, port.admittance, port.velocity, 1e-4), squares, dampers)
    assert rests.stiffness == pytest.approx(-5000.0)
    assert rests.power == pytest.approx(squares @ port.matched_power)


def test_a_maximum_between_the_dampers_tried_may_be_the_higher_one():
    """By 3e-4: the table has it 6e-4 too low, the other one exactly."""
    z, omega = np.array([np.exp(0.05), np.exp(8.0)]), np.array([1.0, 2.0])
    port = Port(omega, 1 / z + 0j, np.sqrt(8 / z) + 0j, 1.0)
    found = best_dampers(port, np.array([[1.0003, 1.0]]))
    assert found.damping[0] == pytest.approx(z[0], rel=0.01)
    others = powers_of_all(port, np.array([[1.0003, 1.0]]), z, np.zeros(2), 1.0)
    assert found.power[0] >= others.max() > others[1, 0]


def test_a_pair_between_the_dampers_tried_may_be_the_better_one():
    """Two waves, each with a spring of its own; the table has the better one's damper a tenth off."""
    z = np.array([1.0 - 1e3j, 0.5 * np.exp(1.6) - 3e3j])
    port = Port(np.array([1.0, 2.0]), 1 / z, z.real**0.5 / z, 1e-3)
    waves = np.array([[1.001, 1.0]])
    found = best_pairs(port, waves, best_dampers(port, waves))
    assert found.stiffness[0] == pytest.approx(1e3, rel=1e-2)
    assert found.power[0] >= 1.001 / 8


def test_two_peaks_have_two_maxima_and_the_higher_is_found():
    """One sea of two waves whose best dampers are decades apart."""
    omega = np.array([1.0, 2.0])
    port = Port(omega, 1 / np.array([1.0 + 0j, 1e4]), np.array([1.0 + 0j, 1e-2]), 1.0)
    for share, best in ((2.0, 1.0), (0.5, 1e4)):
        found = best_dampers(port, np.array([[share, 1.0]]) * np.array([1.0, 1.0]))
        assert found.damping[0] == pytest.approx(best, rel=1e-3)


@given(st.floats(0.1, 10), st.floats(-10, 10), st.floats(0.3, 1.0), st.floats(0.3, 3.0))
def test_losses_of_reactive_power_are_those_of_the_time_signal(damping, stiffness, efficiency, omega):
    """Mean of e p+ + p-/e over a period of v = cos(omega t)."""
    phase = 2 * np.pi * (np.arange(20000) + 0.5) / 20000
    power = (damping * np.cos(phase) + stiffness / omega * np.sin(phase)) * np.cos(phase)
    expected = np.mean(np.where(power > 0, efficiency * power, power / efficiency))
    args = (np.array(v) for v in (damping, stiffness, 0.5, 0.5 / omega**2))
    assert electrical_power(*args, efficiency) == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_losses_of_reactive_power_in_a_gaussian_sea():
    """Force and velocity of correlation rho: sampled, 4 million times, the mean is met to its statistical error."""
    rng = np.random.default_rng(0)
    v, x = rng.normal(size=(2, 4_000_000)) * np.array([[1.3], [0.7]])
    power = (2.0 * v + 3.0 * x) * v
    sampled = np.where(power > 0, 0.7 * power, power / 0.7)
    args = (np.array(value) for value in (2.0, 3.0, 1.3**2, 0.7**2))
    assert electrical_power(*args, 0.7) == pytest.approx(sampled.mean(), abs=4 * sampled.std() / 2000)


def test_a_port_that_cannot_move_takes_nothing():
    still = Port(np.ones(1), np.zeros(1, dtype=complex), np.zeros(1, dtype=complex), 0.0)
    dampers = best_dampers(still, np.ones((2, 1)), 250.0)
    assert not dampers.power.any()
    assert not dampers.damping.any()
    assert dampers.stiffness.tolist() == [250.0, 250.0]
    assert best_pairs(still, np.ones((2, 1)), dampers) == dampers


def test_a_climb_follows_a_bent_ridge_to_its_top():
    def ridge(x, _):
        return -((x[:, 0] - 1) ** 2) - 10 * (x[:, 1] - x[:, 0] ** 2) ** 2

    x, value = climbed(ridge, np.array([[-1.0, 1.0], [2.0, 2.0]]), np.full((2, 2), 0.4))
    assert x == pytest.approx(np.ones((2, 2)), abs=3e-3)
    assert value == pytest.approx(np.zeros(2), abs=1e-5)


@pytest.mark.parametrize("size", [1, 2])
def test_a_climb_stays_where_nothing_is_higher(size):
    """On a plain no direction is preferred, and a top that is found is not left."""
    start = np.linspace(-1.0, 2.0, 3 * size).reshape(3, size)
    x, value = climbed(lambda x, _: np.full(len(x), 7.0), start, np.full(start.shape, 0.3))
    assert (x.tolist(), value.tolist()) == (start.tolist(), [7.0] * 3)
    x, value = climbed(lambda x, _: -np.sum((x - start[:1]) ** 2, axis=1), start[:1], np.full((1, size), 0.3))
    assert (x.tolist(), value.tolist()) == (start[:1].tolist(), [0.0])


def test_of_loads_as_good_the_one_at_hand_stays():
    """Also where one or both cost power."""
    numbers = np.arange(1.0, 7.0)
    at_hand = Load(numbers, 10 * numbers, np.array([5.0, 5.0, 5.0, -1.0, -4.0, 2.0]))
    other = Load(-numbers, -10 * numbers, np.array([5.0, 6.0, 4.0, -3.0, -2.0, -7.0]))
    better = at_hand.or_better(other)
    taken = np.array([1, -1, 1, 1, -1, 1]) * numbers
    assert [value.tolist() for value in better] == [
        taken.tolist(), (10 * taken).tolist(), [5.0, 6.0, 5.0, -1.0, -2.0, 2.0],
    ]  # fmt: skip


@pytest.mark.parametrize("efficiency", [1.0, 0.8])
def test_a_sea_without_waves_keeps_the_load_it_was_given_and_the_others_get_their_own(efficiency):
    """Whichever place it has: what is best in one sea knows nothing of another."""
    rng = np.random.default_rng(3)
    port = random_port(rng)
    seas = random_seas(rng, port.omega, 5)
    seas[2] = 0.0
    given = Load(np.full(5, 3.0), np.full(5, 0.2), np.zeros(5))
    found = best_pairs(port, seas, given, efficiency)
    assert [value[2] for value in found] == [3.0, 0.2, 0.0]
    assert (np.delete(found.power, 2) > 0).all()
    for i in (0, 1, 3, 4):
        alone = best_pairs(port, seas[[i]], Load(np.ones(1), np.ones(1), np.zeros(1)), efficiency)
        assert found.power[i] == pytest.approx(alone.power[0], rel=1e-8)
    assert best_dampers(port, seas, 0.1, efficiency).power[2] == 0.0


def test_dampers_are_tried_around_those_that_waves_want_beside_the_spring():
    """Of two waves one is tuned by it: what it wants there is a thousandth of what it wants without."""
    z, omega, spring = np.array([10.0 - 1e4j, 1e4 - 5e3j]), np.array([1.0, 2.0]), 1e4
    port = Port(omega, 1 / z, 1 / z, 1e-3)
    assert np.abs(z + 1j * spring / omega) == pytest.approx([10.0, 1e4])
    for sea, wanted in (([1.0, 100.0], 10.0), ([1.0, 1e5], 1e4)):
        tried = np.geomspace(1.0, 1e5, 2001)
        best = tried[(port.power(tried, np.full(2001, spring)) @ sea).argmax()]
        (damping,) = best_dampers(port, np.array([sea]), spring).damping
        assert damping == pytest.approx(best, rel=1e-2)
        assert damping == pytest.approx(wanted, rel=0.2)


def test_what_is_found_for_some_seas_stands_there_where_it_is_better():
    """In the order it is found in; what was at hand stays as it was."""
    at_hand = Load(np.array([1.0, 2.0, 3.0]), np.array([10.0, 20.0, 30.0]), np.array([5.0, 5.0, 5.0]))
    found = Load(np.array([4.0, 6.0]), np.array([40.0, 60.0]), np.array([6.0, 4.0]))
    for seas, expected in (([2, 0], [1.0, 2.0, 4.0]), ([0, 1], [4.0, 2.0, 3.0])):
        together = _with(at_hand, np.array(seas), found)
        assert together.damping.tolist() == expected
        assert together.stiffness.tolist() == [10 * value for value in expected]
        assert together.power.tolist() == [6.0 if value == 4.0 else 5.0 for value in expected]
    assert at_hand.damping.tolist() == [1.0, 2.0, 3.0]


def test_seas_are_rows_of_squares_over_the_frequencies_of_all():
    seas = [
        Sea(np.array([1.0, 3.0]), np.array([1.0 + 1j, -2.0])), NO_WAVES, Sea(np.array([2.0, 3.0]), np.array([3j, 1.0])),
        Sea(np.array([0.5]), np.array([-1j])),
    ]  # fmt: skip
    omega = frequencies(seas)
    assert omega.tolist() == [0.5, 1.0, 2.0, 3.0]
    np.testing.assert_allclose(squares(seas, omega), [[0, 2, 0, 4], [0] * 4, [0, 0, 9, 1], [1, 0, 0, 0]], rtol=1e-15)
    assert frequencies([NO_WAVES]).size == 0


@pytest.mark.parametrize("efficiency", [1.0, 0.7])
def test_loads_each_in_its_sea_take_what_they_take_in_all_of_them(efficiency):
    """By the sum over frequencies of what one load takes of one wave, springs of either sign."""
    rng = np.random.default_rng(11)
    port = random_port(rng)
    seas, c, k = random_seas(rng, port.omega, 3), np.array([0.3, 2.0, 0.9]), np.array([0.2, 0.0, -0.1])
    together = powers_of_all(port, seas, c, k, efficiency)
    assert mean_power(port, seas, c, k, efficiency) == pytest.approx(np.diag(together), rel=1e-12)
    for i, j in np.ndindex(3, 3):
        speed = 0.5 * seas[j] * np.abs(port.velocity_under(port.load(c[i], k[i]))) ** 2
        taken = electrical_power(c[i], k[i], speed.sum(), (speed / port.omega**2).sum(), efficiency)
        assert together[i, j] == pytest.approx(float(taken), rel=1e-12)
        if efficiency == 1.0:
            assert together[i, j] == pytest.approx(c[i] * speed.sum(), rel=1e-12)
    assert mean_power(port, seas, c, k).tolist() == mean_power(port, seas, c, k, 1.0).tolist()


@pytest.mark.parametrize("size", [1, 2])
def test_each_start_climbs_its_own_hill_however_long_the_others_take(size):
    """Hills of unlike tops, heights and widths; steps of unlike sizes in either direction."""
    tops = np.array([[0.0, 0.0], [3.0, -2.0], [0.3, 0.1], [-5.0, 4.0], [1.0, 1.0], [2.0, 1.0]])[:, :size]
    heights, sharpness = np.array([1.0, -2.0, 3.0, 4.0, 5.0, -6.0]), np.array([1.0, 30.0])[:size]

    def hills(x, start):
        apart = x - tops[start]
        return heights[start] - (2 * (np.exp(apart) - 1 - apart) * sharpness).sum(axis=1)  # steeper to one side

    for steps in ([0.5, 0.5], [0.5, 3e-4], [3e-4, 0.5]):
        apart = np.array([[0.0, 0.0], [1.0, -0.3], [-0.2, 0.5], [0.03, 0.01], [0.9, 0.0], [0.0, 0.9]]) * np.minimum(
            60 * np.array(steps), 1.0
        )
        near = tops + apart[:, :size]
        x, value = climbed(hills, near, np.tile(steps[:size], (6, 1)))
        np.testing.assert_allclose(x, tops, atol=2 * FINEST)
        np.testing.assert_allclose(value, heights, atol=1e-6)


def test_a_step_of_a_climb_is_newton_s_to_the_top_of_a_parabola_and_uphill_by_one_where_it_has_none():
    offsets = np.array(list(np.ndindex(3, 3))) - 1
    slopes = np.array([[0.3, -0.4], [0.3, -0.4], [-0.3, 0.4], [0.0, 0.1]])
    bends = np.array(
        [
            [[-2.0, 0.7], [0.7, -1.5]],
            [[-2.0, -0.7], [-0.7, -1.5]],
            [[1.0, 0.0], [0.0, -1.0]],
            [[-1.0, 0.0], [0.0, -0.05]],
        ]
    )
    values = offsets @ slopes.T + 0.5 * np.einsum("pi,sij,pj->ps", offsets, bends, offsets) + 9.0
    expected = [-np.linalg.solve(bends[0], slopes[0]), -np.linalg.solve(bends[1], slopes[1]), [-1.0, 0.4], [0.0, 1.0]]
    np.testing.assert_allclose(_ascent(offsets, values), expected, atol=1e-12)
    line = np.array([[-1], [0], [1]])
    rows = [line[:, 0] * g + 0.5 * line[:, 0] ** 2 * h for g, h in ((0.3, -2.0), (0.3, 1.0), (-0.3, 0.0), (0.4, -0.2))]
    np.testing.assert_allclose(_ascent(line, np.array(rows).T), [[0.15], [1.0], [-1.0], [1.0]], atol=1e-12)


def test_a_local_maximum_of_a_table_is_no_less_than_any_neighbour_diagonals_and_edges_included():
    """Of each sea by itself, below zero too."""
    table = -np.array([[9.0, 5.0, 9.0, 1.0], [5.0, 9.0, 9.0, 9.0], [9.0, 9.0, 2.0, 9.0], [3.0, 9.0, 9.0, 2.0]])
    expected = np.zeros((4, 4), dtype=bool)
    for i, j in np.ndindex(4, 4):
        expected[i, j] = table[i, j] == table[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].max()
    assert expected.sum() == 6
    found = _local_maxima(np.stack([table, table[::-1]], axis=2), axes=2)
    np.testing.assert_array_equal(found, np.stack([expected, expected[::-1]], axis=2))
    row = np.array([[-1.0, -3.0], [-2.0, -2.0], [-2.0, -2.0], [-4.0, -1.0]])
    assert _local_maxima(row).T.tolist() == [[True, False, True, False], [False, True, False, True]]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("efficiency", [0.9, 0.7, 0.5])
def test_beside_a_spring_that_costs_much_the_best_damper_is_as_hard_as_it_takes(efficiency):
    """A small buoy tuned to long waves, where it loses little: softer dampers bring less than the spring costs."""
    omega = 2 * np.pi / np.array([12.0, 10.0, 4.0])
    z = 165.0 * omega**3 * 10 - 2.5e4j * omega + 1.26e5j / omega
    port, spring = Port(omega, 1 / z, 1.1e5 / z, 1 / 1.26e5), 2.5e4 * omega[0] ** 2 - 1.26e5
    waves = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.3], [0.0, 0.0, 0.0], [0.4, 1.0, 0.0]])
    tried = np.geomspace(1.0, 1e8, 4001)
    powers = powers_of_all(port, waves, tried, np.full(4001, spring), efficiency)
    for seas in ([0, 1, 2, 3], [0], [3, 0], [2, 1]):
        found = best_dampers(port, waves[seas], spring, efficiency)
        best = powers[:, seas]
        assert np.all(found.power >= best.max(axis=0) * (1 - 1e-12))
        assert found.power == pytest.approx(best.max(axis=0), rel=1e-4)
        moved = waves[seas].any(axis=1)
        assert found.damping[moved] == pytest.approx(tried[best.argmax(axis=0)][moved], rel=0.02)
        assert not found.power[~moved].any()
    assert np.median(powers[:, 0]) < 0 < powers[:, 0].max()


def test_a_summit_is_reached_from_either_side_however_hollow_the_way_to_it():
    """Of one wave each, at c = 1/|Y| and of w/(2 Re Y + 2 |Y|) there; each start knows its own."""
    y = np.array([3e-3 - 4e-3j, 2e-4 + 1e-5j, 1e-6 + 5e-2j])
    away = np.array([[-6.0], [-0.04], [0.0], [0.03], [7.0]])
    top, which = -np.log(np.abs(y)), np.tile(np.arange(3), 5)
    w = np.array([2.0, 3.0, 5.0])
    given = (w[which][:, None], 2 * y.real[which][:, None], np.abs(y[which][:, None]) ** 2)
    x, power = _summits(*given, (top + away).ravel())
    np.testing.assert_allclose(x, top[which], atol=1e-9)
    np.testing.assert_allclose(power, (w / (2 * y.real + 2 * np.abs(y)))[which], rtol=1e-12)
