"""Matrices of the exponential Adams steps: exact where what drives is a polynomial, of order six elsewhere."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from vsb.integrators import exponential_steps
from vsb.integrators.exponential_steps import (
    GROWTH,
    HISTORY,
    KEPT,
    LONGEST,
    PAST,
    PROBE,
    SAFE,
    SPENT,
    STARTS,
    step_matrices,
)
from vsb.integrators.phi import phi_integrals

A = np.array([[0.0, 3.0], [-3.0, -0.4]])
B = np.array([[0.0], [1.0]])
START = np.array([0.3, -1.0])


def steps(d, part=0.618):
    """Matrices of a step of size d, recorded at its half."""
    return step_matrices(*(phi_integrals(A, B, span, KEPT + 1) for span in (d, part * d, d / 2)), 1)


def exact(push, d):
    forced = quad_vec(lambda s: expm((d - s) * A) @ B[:, 0] * push(s), 0.0, d, epsabs=1e-14)[0]
    return expm(d * A) @ START + forced


@pytest.mark.parametrize("degree", range(PAST))
def test_a_push_that_past_values_continue_is_followed_exactly(degree):
    d = 0.2
    step, past = steps(d), (-d * np.arange(PAST)) ** degree
    found = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
    np.testing.assert_allclose(found, exact(lambda s: s**degree, d), atol=1e-13)


def test_the_new_value_corrects_one_degree_more():
    d = 0.2
    step, past = steps(d), (-d * np.arange(PAST)) ** PAST
    ahead = np.polyval(np.polyfit(-d * np.arange(PAST), past, PAST - 1), d)
    predicted = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
    found = predicted + (d**PAST - ahead) * step.corrected[0]
    np.testing.assert_allclose(found, exact(lambda s: s**PAST, d), atol=1e-13)


def test_predictions_err_with_the_sixth_power_of_the_step():
    errors = []
    for d in (0.04, 0.02, 0.01):
        step, past = steps(d), np.cos(1.4 - 4.0 * d * np.arange(PAST))
        found = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
        errors.append(np.abs(found - exact(lambda s: np.cos(1.4 + 4.0 * s), d)).max())
    slopes = np.diff(np.log2(errors))
    assert np.all(np.abs(slopes + 6) < 0.4), slopes


@pytest.mark.parametrize(("between", "accepted"), [(0.0, True), (0.5, True), (2.0, False)])
def test_what_forces_do_between_nodes_counts_as_error_of_a_step(monkeypatch, between, accepted):
    """At its nodes a step without a push has no error; one found between them, in limits, is put down or refused."""
    step, dt, tolerance, horizon = steps(0.1), 0.1, 1e-6, 2.0
    limit = exponential_steps.SAFE * tolerance * 1.5 * 0.1 / horizon

    def still(r, t, p, out):
        out[:] = 0.0

    monkeypatch.setattr(exponential_steps, "remainder", still)
    monkeypatch.setattr(exponential_steps, "_unseen", lambda *_: (between * limit, 1))
    z, past, places = START.copy(), np.zeros((HISTORY, 1)), np.zeros((HISTORY, 1))
    counters, levels = np.array([0, KEPT, 0, 0, 0]), np.array([1.5, 0.0, 0.0])
    out, pushes = np.zeros((2, 2)), np.zeros((2, 1))
    change = exponential_steps.march.py_func(
        SimpleNamespace(round_off=0.0), step, dt, 0, tolerance, horizon, z, past, places, counters, levels, out, pushes
    )
    assert change == (0 if accepted else -1)
    assert counters.tolist() == [2**20, KEPT + 1, 1, 2, 0] if accepted else [0, 0, 1, 2, HISTORY]
    np.testing.assert_allclose(out[1], expm(dt * A) @ START if accepted else 0.0, atol=1e-13)
    if accepted:
        np.testing.assert_allclose(levels, [1.5, between, (1 - between) * limit], rtol=1e-12, atol=0.0)


# the start -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def pushed(monkeypatch):
    """Function n(t, p) -> what it is asked, (t, p) by (t, p), as the compiled steps would ask the water."""

    def by(n):
        asked = []

        def remainder(r, t, p, out):
            asked.append((t, p.copy()))
            out[:] = n(t, p)

        monkeypatch.setattr(exponential_steps, "remainder", remainder)
        return asked

    return by


def started(step, t, limit):
    """Evaluations of a start, or -1, and the past it found."""
    past = np.full((HISTORY, step.forced.shape[1]), 7.0)
    with np.errstate(all="ignore"):  # as compiled steps do
        return exponential_steps._started.py_func(None, step, t, START, limit, past), past


def test_the_past_of_a_start_continues_backwards_what_its_first_steps_find(pushed):
    """Of a push of time alone a polynomial: found in one turn, confirmed by another and one step more."""
    d, t = 0.1, 2.0
    course = np.polynomial.Polynomial([0.3, -2.0, 1.5, 4.0])
    asked = pushed(lambda at, p: course(at - t))
    made, past = started(steps(d), t, 1e-6)
    assert made == len(asked) == 2 + 2 * PAST
    np.testing.assert_allclose(past[:KEPT, 0], course(-d * np.arange(KEPT)), atol=1e-11)
    turn = t + d * np.arange(1, KEPT)
    np.testing.assert_allclose([at for at, _ in asked], [t, *turn, *turn, t + KEPT * d], rtol=1e-14)
    for at, p in asked[-1 - PAST :]:  # along the exact motion
        assert p[0] == pytest.approx(exact(course, at - t)[0], abs=1e-12)


@pytest.mark.parametrize(("share", "made"), [(0.9, 2 + PAST), (1.1, -1)])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_start_whose_next_value_is_not_foreseen_is_refused(pushed, share, made, way):
    """A push that is nothing but at the first instant beyond the start: what it errs by is a tenth of the limit."""
    d, limit = 0.1, 1e-6
    step = steps(d)
    jump = way * share * 0.1 * limit / np.linalg.norm(step.missed[0])
    pushed(lambda t, p: jump * (t > (KEPT - 0.5) * d))
    assert started(step, 0.0, limit)[0] == made


@pytest.mark.parametrize(("worse", "turns"), [(lambda n: (-1.0) ** n, STARTS), (lambda n: np.inf, 1)])
def test_a_start_that_does_not_settle_is_given_up(pushed, worse, turns):
    """After its turns, or at once where nothing is finite any more."""
    asked = pushed(lambda t, p: worse(len(asked)) if t else 0.0)
    assert started(steps(0.1), 0.0, 1e-9)[0] == -1
    assert len(asked) == 1 + turns * PAST


# between the nodes ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def coupled():
    """A step of two coordinates with a memory, and the integrals it is made of."""
    rng = np.random.default_rng(8)
    a, b, d = rng.normal(size=(5, 5)), np.eye(5, 2, -2), 0.15
    return step_matrices(*(phi_integrals(a, b, span, KEPT + 1) for span in (d, PROBE * d, d / 2)), 2), a, b


def unseen(coupled, pushed, share, extra=0.0):
    """Error and evaluations of a step from t = 3 on whose position leaves that of the nodes by a share of the limit."""
    step, a, b = coupled
    rng, t, limit, d = np.random.default_rng(9), 3.0, 1e-3, step.spacing
    z, tangent, courses = rng.normal(size=5), rng.normal(size=(2, 2)), rng.normal(size=(KEPT, 2))

    def push(s):
        return np.polynomial.polynomial.polyval(s / d, courses)

    asked = pushed(lambda at, p: push(at - t) + extra)
    nodes = np.array([push(d * (1 - i)) for i in range(KEPT)])
    forced = quad_vec(lambda s: expm((PROBE * d - s) * a) @ b @ push(s), 0.0, PROBE * d, epsabs=1e-14)[0]
    position = (expm(PROBE * d * a) @ z + forced)[:2]
    stray = np.array([0.3, -1.1])
    stray *= share * 0.2 * limit / np.linalg.norm((tangent @ stray) @ step.corrected)
    places = np.tile(position - stray, (KEPT, 1))
    r = SimpleNamespace(tangent=tangent)
    return exponential_steps._unseen.py_func(r, step, t, z, nodes, places, limit), asked, position


@pytest.mark.parametrize("share", [0.0, 0.9])
def test_a_position_between_the_nodes_that_fits_them_needs_no_evaluation(coupled, pushed, share):
    """What the tangent makes of the difference is below a fifth of the limit."""
    found, asked, _ = unseen(coupled, pushed, share, extra=1.0)
    assert found == (0.0, 0)
    assert not asked


def test_forces_are_asked_where_and_when_a_step_is_between_its_nodes(coupled, pushed):
    """There a push that is the polynomial through the nodes errs by nothing, another by what it leaves that."""
    (error, looked), ((at, place),), position = unseen(coupled, pushed, 1.1)
    assert (looked, at) == (1, 3.0 + PROBE * coupled[0].spacing)
    np.testing.assert_allclose(place, position, rtol=1e-12)
    assert error == pytest.approx(0.0, abs=1e-13)
    away = np.array([0.2, -0.5])
    (error, looked), *_ = unseen(coupled, pushed, 1.1, away)
    assert (error, looked) == (pytest.approx(np.linalg.norm(away @ coupled[0].corrected), rel=1e-10), 1)


# records -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("longest", "filled"), [(9, 3), (6, 2)])
def test_records_inside_a_step_are_those_of_the_motion_as_far_as_there_are_any(longest, filled):
    """A step of four records of 0.05 s; n is a polynomial of degree five, so states and n are exact."""
    d, dt = 0.2, 0.05
    step = step_matrices(*(phi_integrals(A, B, span, KEPT + 1) for span in (d, PROBE * d, dt)), 1)
    course = np.polynomial.Polynomial([0.3, -2.0, 1.5, 40.0, -300.0, 900.0])
    nodes, out, pushes = course(d * (1.0 - np.arange(KEPT)))[:, None], np.zeros((longest, 2)), np.zeros((longest, 1))
    exponential_steps._record(step, START, nodes, 4, 3, out, pushes)
    for k in range(filled):
        np.testing.assert_allclose(out[4 + k], exact(course, (k + 1) * dt), atol=1e-11)
        assert pushes[4 + k, 0] == pytest.approx(course((k + 1) * dt), abs=1e-10)
    assert not out[:4].any()
    assert not out[4 + filled :].any()


@pytest.mark.parametrize("change", [1, -1])
def test_past_values_at_another_distance_are_those_of_the_polynomial_through_them(change):
    course = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.3, -0.2, 0.05])
    past = np.column_stack([course(-np.arange(float(HISTORY))), 3.0 * course(1.0 - np.arange(float(HISTORY)))])
    exponential_steps._resized(past, change)
    apart = -np.arange(float(KEPT)) * (2.0 if change > 0 else 0.5)
    np.testing.assert_allclose(past[:KEPT], np.column_stack([course(apart), 3.0 * course(1.0 + apart)]), rtol=1e-11)


# a march of one size -------------------------------------------------------------------------------------------------

PER_RECORD = 2**20


class March:
    """Steps of one size in a scene that nothing pushes, whose errors are such parts of their limits, and all it carries."""

    def __init__(self, monkeypatch, errors, level=0, known=KEPT, aside=0.0, troubled=0, peak=0.0, count=41, **more):
        self.dt, self.horizon, self.tolerance, self.round_off = 0.1, 2.0, 1e-6, more.get("round_off", 0.0)
        self.step, self.limits = steps(self.dt * 2.0**level), []
        left = iter(errors)

        def still(r, t, p, out):
            out[:] = 0.0

        def norm(matrix, vector):
            self.limits.append(self.limit)
            return next(left, 0.0) * self.limit

        monkeypatch.setattr(exponential_steps, "remainder", still)
        monkeypatch.setattr(exponential_steps, "_norm_of", norm)
        monkeypatch.setattr(exponential_steps, "_unseen", lambda *_: (0.0, 0))
        monkeypatch.setattr(exponential_steps, "_started", lambda *_: more.get("started", -1))
        self.z, self.out, self.pushes = START.copy(), np.zeros((count, 2)), np.zeros((count, 1))
        self.past, self.places = np.zeros((HISTORY, 1)), np.arange(float(HISTORY))[:, None]
        self.counters = np.array([more.get("tick", 0), known, 0, 0, troubled])
        self.levels = np.array([2.0, peak, aside])
        self.change = exponential_steps.march.py_func(
            SimpleNamespace(round_off=self.round_off), self.step, self.dt, level, self.tolerance, self.horizon, self.z,
            self.past, self.places, self.counters, self.levels, self.out, self.pushes,
        )  # fmt: skip

    @property
    def limit(self):
        """What a step may err by; the state is at its largest at the begin."""
        d = self.step.spacing
        return SAFE * self.tolerance * 2.0 * min(d / self.horizon, 1.0) + self.round_off * d


@pytest.mark.parametrize(("known", "peak", "steps"), [
    (KEPT, 0.0, HISTORY - KEPT), (HISTORY, 0.0, 1), (HISTORY, 0.02, 14), (KEPT, 0.02, 14), (HISTORY, 1.05 / GROWTH, 1),
    (HISTORY, 1.06 / GROWTH, 2),
])  # fmt: skip
def test_a_step_becomes_twice_as_long_where_it_may_and_its_past_is_known(monkeypatch, known, peak, steps):
    """Errors of late are forgotten by a twentieth a step; every other past value goes on to serve."""
    found = March(monkeypatch, [], known=known, peak=peak)
    assert found.change == 1
    assert found.counters.tolist() == [steps * PER_RECORD, KEPT, steps, steps, 0]
    assert found.levels[1] == 0.0
    for k in range(steps + 1):
        np.testing.assert_allclose(found.out[k], expm(k * 0.1 * A) @ START if k else 0.0, atol=1e-12)
    behind = [found.z[0], *found.out[steps - 1 : 0 : -1, 0], *range(HISTORY)]
    np.testing.assert_allclose(found.places[:KEPT, 0], behind[: 2 * KEPT : 2], atol=1e-12)


def test_the_error_of_late_is_that_of_the_worst_step(monkeypatch):
    """0.02 of the limit, then less: after 14 more it is below a hundredth."""
    found = March(monkeypatch, [0.5 / GROWTH, 2.0 / GROWTH, 0.5 / GROWTH, 0.7 / GROWTH], known=HISTORY - 1)
    assert found.counters[2] == 1
    found = March(monkeypatch, [2.0 / GROWTH, 0.5 / GROWTH, 0.7 / GROWTH], known=HISTORY - 1)
    assert found.counters[2] == 1 + 14


@pytest.mark.parametrize(
    ("level", "tick", "steps"), [(-1, 0, 2), (-1, PER_RECORD // 2, 1), (-2, 0, 2), (-2, PER_RECORD // 4, 1)]
)
def test_a_part_of_a_record_becomes_twice_as_long_where_such_parts_begin(monkeypatch, level, tick, steps):
    found = March(monkeypatch, [], level=level, known=HISTORY, tick=tick)
    assert (found.change, found.counters[2]) == (1, steps)


def test_the_longest_step_stays_as_it_is(monkeypatch):
    found = March(monkeypatch, [], level=LONGEST, known=HISTORY, count=2 * 2**LONGEST + 1)
    assert (found.change, found.counters[2]) == (0, 2)


@pytest.mark.parametrize(("troubled", "error", "accepted"), [
    (0, 0.99, True), (0, 1.01, False), (3, 1.0 + 0.99 * SPENT * 4.0, True), (3, 1.0 + 1.01 * SPENT * 4.0, False),
    (0, 1.0 + 0.99 * SPENT * 4.0, False), (1, 1.0 + 0.99 * SPENT * 4.0, True),
])  # fmt: skip
@pytest.mark.parametrize("round_off", [0.0, 1e-5])
def test_what_was_put_aside_is_spent_after_a_failure_alone(monkeypatch, troubled, error, accepted, round_off):
    """A tenth of it in one step; round-off of the forces counts as no error."""
    limit = SAFE * 1e-6 * 2.0 * 0.1 / 2.0 + round_off * 0.1
    found = March(monkeypatch, [error], aside=4.0 * limit, troubled=troubled, count=2, round_off=round_off)
    assert found.limits[0] == pytest.approx(limit)
    assert found.change == (0 if accepted else -1)
    assert found.counters[4] == (max(troubled - 1, 0) if accepted else HISTORY)
    if accepted:
        kept = min((4.0 + 1.0 - error) * limit, SAFE * 1e-6 * 2.0)
        assert found.levels.tolist() == pytest.approx([2.0, error, kept])


def test_no_more_is_put_aside_than_the_tolerance(monkeypatch):
    found = March(monkeypatch, [0.5] * 99, count=41)
    assert found.levels[2] == pytest.approx(SAFE * 1e-6 * 2.0)
    found = March(monkeypatch, [0.5] * 99, count=4)
    assert found.levels[2] == pytest.approx(3 * 0.5 * SAFE * 1e-6 * 2.0 * 0.1 / 2.0)


@pytest.mark.parametrize(("known", "kept"), [(KEPT, 0), (KEPT + 1, KEPT), (HISTORY, KEPT)])
def test_a_step_that_fails_is_begun_anew_by_interpolation_once(monkeypatch, known, kept):
    """Places of before stand at half the distance; nothing has moved."""
    found = March(monkeypatch, [1.5], known=known, peak=0.5)
    assert found.change == -1
    assert found.counters.tolist() == [0, kept, 1, 1, HISTORY]
    assert found.levels.tolist() == [2.0, 0.0, 0.0]
    np.testing.assert_array_equal(found.z, START)
    np.testing.assert_allclose(found.places[:KEPT, 0], np.arange(KEPT) / 2, atol=1e-12)
    assert not found.out.any()


@pytest.mark.parametrize(("made", "change"), [(-1, -1), (17, 0)])
def test_a_march_without_a_past_is_started_or_left_to_shorter_steps(monkeypatch, made, change):
    found = March(monkeypatch, [0.5] * 9, known=0, started=made, count=4)
    assert found.change == change
    expected = [3 * PER_RECORD, KEPT + 3, 3, 20, 0] if made > 0 else [0, 0, 0, 0, HISTORY]
    assert found.counters.tolist() == expected
    if made > 0:
        np.testing.assert_allclose(found.places[3:KEPT, 0], START[0])


def test_errors_count_over_no_longer_than_the_motion_or_what_it_remembers(monkeypatch):
    """A step longer than that may err by all of the tolerance."""
    found = March(monkeypatch, [0.9], level=6, count=65)
    assert found.limits[0] == pytest.approx(SAFE * 1e-6 * 2.0)
    assert found.change == 0


def test_the_error_of_a_step_is_what_one_past_value_more_would_change(coupled):
    """Of each coordinate: between the polynomials that are 1 at the new node and 0 at five, or at six, past ones."""
    step, a, b = coupled
    d, nodes = step.spacing, 1.0 - np.arange(KEPT + 1.0)

    def response(count):
        roots = nodes[1 : count + 1]

        def push(s):
            return np.prod((s / d - roots) / (1.0 - roots))

        return quad_vec(lambda s: expm((d - s) * a) @ b * push(s), 0.0, d, epsabs=1e-14)[0].T

    np.testing.assert_allclose(step.corrected, response(PAST), atol=1e-12)
    np.testing.assert_allclose(step.missed, response(KEPT) - response(PAST), atol=1e-12)
    assert step.forced.shape == (PAST, 2, 5)
