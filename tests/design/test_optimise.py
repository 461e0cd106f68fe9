"""The optimiser and its certificate on problems whose optima are known in closed form."""

import re

import numpy as np
import pytest
from scipy.stats import norm

from tests.design.conftest import study_of
from vsb.design.certificate import curvature, multipliers, newton_step
from vsb.design.evaluation import Evaluation, Quantity
from vsb.design.optimise import (
    KKT,
    VIOLATION,
    _polished,
    converged,
    first_possible,
    left_out,
    optimised,
    start_places,
    within_limits,
)
from vsb.design.problem import Problem, probabilities
from vsb.design.searched import shares_of
from vsb.errors import ConvergenceError
from vsb.study.design import DIVISORS, Variable
from vsb.study.sections import DEGREES

MASS, SPRING = (Variable(key="device.mass", low=0.5, high=8.0), Variable(key="pto.stiffness", low=-4.0, high=4.0))


class Analytic:
    """A model of functions of the variables."""

    def __init__(self, function):
        self.function = function

    def at(self, values):
        return Evaluation(self.function(np.array(values)))


def problem(function, limits=None, variables=(MASS, SPRING), maximise="annual_mean_power", **others):
    return Problem(Analytic(function), variables, maximise, limits or {}, **others)


def nearest(values):
    """Power 20 - |x - (3, 1)|^2; the mass limits a disc about the origin."""
    away = values - [3.0, 1.0]
    return {
        "annual_mean_power": Quantity(20 - away @ away, -2 * away),
        "mass": Quantity(float(np.hypot(*values)), values / np.hypot(*values)),
    }


@pytest.mark.parametrize("start", [(0.5, -4.0), (8.0, 4.0), (1.0, 0.0)])
def test_nearest_point_of_a_disc_and_its_multiplier(start):
    """The point of the disc of radius 2 nearest to (3, 1), and dP/dR = 2 (sqrt(10) - 2)."""
    of = problem(nearest, {"mass": 2.0})
    found = optimised(of, of.at(of.place(start)))
    assert found.accepted
    assert found.kkt <= KKT
    assert found.violation <= VIOLATION
    assert found.point.values == pytest.approx(2 * np.array([3, 1]) / np.sqrt(10), abs=1e-7)
    power = 20 - (np.sqrt(10) - 2) ** 2
    assert found.objective == pytest.approx(power, rel=1e-9)
    assert found.multipliers == {"mass": pytest.approx(2 * 2 * (np.sqrt(10) - 2) / power, rel=1e-5)}


def test_limits_that_leave_no_buoy_are_named_with_the_bound_they_conflict_with():
    """|x| of at most 0.3 where x is at least 0.5: the nearest is (0.5, 0), 67 % too large, after a few evaluations."""
    of = problem(nearest, {"mass": 0.3})
    found = optimised(of, of.at(of.place([6.0, 3.0])))
    assert found.accepted is False  # no number of numpy, which JSON knows not
    assert (
        found.message
        == "no buoy keeps the limits: the nearest has mass exceeded by 67 %, device.mass at its lower bound, 0.5"
    )
    assert found.point.values == pytest.approx([0.5, 0.0], abs=1e-2)
    assert of.evaluations < 20
    led = within_limits(of := problem(nearest, {"mass": 0.6}), of.at(of.place([6.0, 3.0])))
    assert not led.conflict
    assert np.hypot(*led.point.values) <= 0.6


@pytest.mark.parametrize("place", [(5e-15, 1 - 5e-15), (0.0, 0.99), (1 - 1e-12, 1.0)])
def test_a_start_that_all_but_touches_bounds_is_led_within_limits(place):
    """As of the best buoy of another limit: round-off from its bounds, and far beyond this limit."""
    of = problem(nearest, {"mass": 2.0})
    led = within_limits(of, of.at(np.array(place)))
    assert not led.conflict
    assert np.hypot(*led.point.values) <= 2.0


def test_newton_step_from_beyond_a_limit_lands_on_the_optimum():
    """Exact of a quadratic power and a linear limit, m + k <= 3: the point of that line nearest to (3, 1)."""

    def straight(values):
        return {**nearest(values), "mass": Quantity(float(values.sum()), np.ones(2))}

    of = problem(straight, {"mass": 3.0})
    point = of.at(of.place([2.7, 0.4]))
    found = multipliers(point, 0.1)
    place = point.place + newton_step(point, found, curvature(of, point, found))
    assert of.values(place) == pytest.approx([2.5, 0.5], abs=1e-6)


def test_multiplier_is_what_a_wider_limit_gives():
    """A multiplier is d ln(objective) / d ln(limit)."""
    powers = []
    for limit in (2.0 * (1 - 1e-4), 2.0, 2.0 * (1 + 1e-4)):
        of = problem(nearest, {"mass": limit})
        powers.append(optimised(of, of.at(np.array([0.2, 0.5]))).objective)
    of = problem(nearest, {"mass": 2.0})
    (value,) = optimised(of, of.at(np.array([0.2, 0.5]))).multipliers.values()
    assert np.log(powers[2] / powers[0]) / 2e-4 == pytest.approx(value, rel=1e-4)


def test_multipliers_are_relative_to_where_newtons_steps_end():
    """dP/dR = 2 (sqrt(10) - 2) over P there, not over P where they began, 1e-4 off."""
    of = problem(nearest, {"mass": 2.0})
    near = of.at(of.place(1.999 * np.array([np.cos(0.34), np.sin(0.34)])))
    point, found, _ = _polished(of.rescaled(near), near)
    assert np.log(point.objective / near.objective) > 1e-5
    assert found.limits[0] == pytest.approx(4 * (np.sqrt(10) - 2) / point.objective, rel=1e-6)


def test_bounds_that_hold_are_named():
    of = problem(nearest, variables=(MASS.model_copy(update={"high": 2.0}), SPRING))
    found = optimised(of, of.at(np.array([0.1, 0.1])))
    assert found.accepted
    assert found.multipliers.keys() == {"upper bound of device.mass"}
    assert found.point.values == pytest.approx([2.0, 1.0], abs=1e-7)


def test_a_flat_ridge_is_named_and_accepted():
    """Only the product of the two counts: with logarithms a straight ridge."""
    stiff = Variable(key="device.young_modulus", low=1.0, high=100.0, log=True)
    thick = Variable(key="device.thickness", low=1.0, high=100.0, log=True)

    def product(values):
        e, h = values
        away = np.log(e * h / 50.0)
        return {"annual_mean_power": Quantity(10 - away**2, -2 * away / values)}

    of = problem(product, variables=(stiff, thick))
    found = optimised(of, of.at(np.array([0.3, 0.2])))
    assert found.accepted
    assert np.prod(found.point.values) == pytest.approx(50.0, rel=1e-6)
    assert found.flat == ("+device.young_modulus -device.thickness",) or found.flat == (
        "-device.young_modulus +device.thickness",
    )


def saddle(values):
    m, k = values - [4.25, 0.0]
    return {"annual_mean_power": Quantity(10 - m**2 + k**2 + k**3 / 9, np.array([-2 * m, 2 * k + k**2 / 3]))}


def test_a_search_that_ends_at_a_saddle_goes_on_from_beside_it():
    of = problem(saddle)
    found = optimised(of, of.at(np.array([0.9, 0.5])))  # on the line along which the saddle is a maximum
    assert found.accepted is True  # no number of numpy, which JSON knows not
    assert found.point.values[0] == pytest.approx(4.25, abs=1e-6)
    assert list(found.multipliers) == ["upper bound of pto.stiffness"]  # the side that gives more


def test_a_saddle_is_left_to_the_other_side_where_the_better_one_ends_at_no_optimum():
    def partly(values):
        if values[1] > 0.4:
            raise ConvergenceError("the shell has no equilibrium")
        return saddle(values)

    of = problem(partly)
    found = optimised(of, of.at(np.array([0.9, 0.5])))
    assert found.accepted
    assert list(found.multipliers) == ["lower bound of pto.stiffness"]


def test_the_line_search_backs_off_where_the_shell_does_not_rest():
    def partly(values):
        if values[0] > 3.2:
            raise ConvergenceError("the shell has no equilibrium")
        return nearest(values)

    of = problem(partly)
    found = optimised(of, of.at(np.array([0.05, 0.9])))
    assert found.accepted
    assert found.point.values == pytest.approx([3.0, 1.0], abs=1e-6)


def test_an_optimum_beyond_the_last_shell_that_rests_is_shown_and_not_accepted():
    def partly(values):
        if values[0] > 2.5:
            raise ConvergenceError("the shell has no equilibrium")
        return nearest(values)

    of = problem(partly)
    found = optimised(of, of.at(np.array([0.05, 0.6])))
    assert found.accepted is False  # no number of numpy, which JSON knows not
    assert "first-order" in found.message
    assert found.point.values[0] <= 2.5


def test_starts_are_a_function_of_the_seed_and_their_number_and_those_without_a_buoy_are_replaced():
    """However many there are; each with places of its own where none rests."""
    every = [[start_places(i, 3, seed, np.full(3, 0.5)) for i in range(5)] for seed in (7, 7, 8)]
    assert all((a == b).all() for one, other in zip(*every[:2], strict=True) for a, b in zip(one, other, strict=True))
    assert (every[0][0][0] == 0.5).all()
    assert len({tuple(place) for one in every[0] for place in one}) == sum(map(len, every[0]))
    assert (every[2][1][0] != every[0][1][0]).any()
    sobol = np.array([every[0][0][1], *(one[0] for one in every[0][1:4])])
    for column in np.sort(sobol, axis=0).T:  # the first four are one in each quarter
        assert (np.floor(4 * column) == np.arange(4)).all()

    def partly(values):
        if values[0] < 4.0:
            raise ConvergenceError("sinks")
        return nearest(values)

    start, reasons = first_possible(problem(partly), [np.array([x, 0.5]) for x in (0.1, 0.2, 0.9)])
    assert start.place[0] == 0.9
    assert reasons == ["sinks", "sinks"]
    with pytest.raises(ConvergenceError, match="none of 1 buoys tried rests: sinks"):
        first_possible(problem(partly), [np.zeros(2)])


def test_objectives_over_a_quantity_have_the_quotients_derivative():
    rng = np.random.default_rng(1)

    def smooth(values):
        m, k = values
        return {
            "annual_mean_power": Quantity(m * np.exp(0.1 * k), np.array([np.exp(0.1 * k), 0.1 * m * np.exp(0.1 * k)])),
            "mass": Quantity(m**2 + 1, np.array([2 * m, 0.0])),
            "surface": Quantity(m + k**2, np.array([1.0, 2 * k])),
            "force_rms": Quantity(np.sqrt(m), np.array([0.5 / np.sqrt(m), 0.0])),
            "cost": Quantity(np.exp(m), np.array([np.exp(m), 0.0])),
        }

    for maximise in (*DIVISORS, "gain"):
        twin = Analytic(lambda v: {"annual_mean_power": Quantity(v[0] ** 3, np.array([3 * v[0] ** 2, 0.0]))})
        of = problem(smooth, {"surface": 5.0}, maximise=maximise, twin=twin if maximise == "gain" else None)
        place = rng.uniform(0.2, 0.8, 2)
        here = of.at(place)
        for i, step in enumerate(1e-5 * np.eye(2)):
            ahead, behind = of.at(place + step), of.at(place - step)
            assert (ahead.cost - behind.cost) / 2e-5 == pytest.approx(here.slope[i], rel=1e-6, abs=1e-9)
            assert (ahead.excess - behind.excess) / 2e-5 == pytest.approx(here.jacobian[:, i], rel=1e-6, abs=1e-9)


def test_load_factors_and_the_thin_shell_are_limits():
    radius = Variable(key="device.radius", low=1.0, high=3.0)

    def of_radius(values):
        kappa = {f"load_factor_inverse_{i}": Quantity(0.5 - 0.1 * i, np.zeros(1)) for i in range(4)}
        return {"annual_mean_power": Quantity(values[0], np.ones(1)), **kappa}

    def thin(values):
        return {"thin_shell": 10 * 0.15 / values[0]}

    of = Problem(Analytic(of_radius), (radius,), "annual_mean_power", {"load_factor": 1.5}, thin)
    point = of.at(of.place([1.2]))
    assert of.limit_names == ["load_factor_0", "load_factor_1", "load_factor_2", "load_factor_3", "thin_shell"]
    assert point.excess == pytest.approx([-0.25, -0.4, -0.55, -0.7, np.log(1.25)], abs=2e-6)
    assert point.jacobian[-1] == pytest.approx([-1 / 1.2 * 2.0])
    assert multipliers(of.at(of.place([1.5]))).limits == pytest.approx(np.zeros(5))


def test_a_wall_heavier_than_the_buoy_is_a_limit_and_no_error():
    """Most power per mass of two, r, h: the wall is all of the mass, 4 pi r^2 h rho = m, exactly."""
    keys = ("device.radius", "device.thickness", "device.mass")
    bounds = ((1.5, 2.5), (0.01, 0.1), (500.0, 2e4))
    variables = tuple(Variable(key=key, low=a, high=b, log=True) for key, (a, b) in zip(keys, bounds, strict=True))

    def lighter(values):
        radius, _, mass = values
        slopes = np.array([3 * radius**2 / mass, 0.0, -(radius**3) / mass**2])
        return {"annual_mean_power": Quantity(radius**3 / mass, slopes)}

    of = problem(lighter, variables=variables, shares=shares_of(study_of(), keys))
    found = optimised(of, of.at(np.full(3, 0.8)))
    radius, thickness, mass = found.point.values
    assert found.accepted
    assert mass == pytest.approx(4 * np.pi * radius**2 * thickness * 2700.0, rel=3e-6)
    assert {"wall_mass", "upper bound of device.radius", "lower bound of device.thickness"} == set(found.multipliers)
    assert found.multipliers["wall_mass"] == pytest.approx(1.0, rel=1e-5)


def test_modes_are_added_until_the_objective_stands():
    """A truncated model whose power errs by 0.5^degree: solved at 2, 4, 6; the changes after 6 are small."""

    def of(degree):
        def truncated(values):
            found = nearest(values)
            left = 0.5**degree
            power = found["annual_mean_power"]
            return {"annual_mean_power": Quantity(power.value * (1 - left), power.gradient * (1 - left))}

        return problem(truncated)

    found = converged(of, (2, 4, 6, 8, 10), 0.02, [np.array([0.5, 0.5])])
    assert found.optimum.accepted
    assert found.degree == 6
    change = (1 - 0.5**10) / (1 - 0.5**6) - 1
    assert found.truncation == pytest.approx((-change, 2 * change))
    assert found.optimum.objective == pytest.approx(20 * (1 - 0.5**6))


def test_limits_hold_with_all_shell_modes_or_the_start_is_not_accepted():
    """A truncated strain, (1 - 0.5^degree) of the true one: an optimum at the limit of its own basis exceeds it."""

    def of(degree, more=0.0):
        def truncated(values):
            found = nearest(values)
            part = 1 - 0.5**degree
            strain = Quantity(found["mass"].value * part + more * (degree > 6), found["mass"].gradient * part)
            return {"annual_mean_power": found["annual_mean_power"], "mass": strain}

        return problem(truncated, {"mass": 2.0})

    found = converged(of, (6, 9, 14), 0.1, [np.array([0.5, 0.5])])
    true = float(np.hypot(*found.optimum.point.values))
    assert found.optimum.accepted
    assert 2.0 * (1 - 0.05) < true <= 2.0
    unmet = converged(lambda degree: of(degree, more=3.0), (6, 9, 14), 0.1, [np.array([0.5, 0.5])])
    assert not unmet.optimum.accepted
    assert re.search(r"with more shell modes the limit of mass is exceeded by .* %", unmet.optimum.message)
    unknown = converged(of, (4, 6), 0.1, [np.array([0.5, 0.5])])
    assert "what more shell modes change the limit of mass by is not known" in unknown.optimum.message


def test_probabilities_that_limits_hold_are_those_of_normal_inputs():
    """One limit met exactly holds of every second buoy, two of opposite signs never together; margins of 2 sigma."""
    scatter = np.array([[0.1, 0.0], [-0.1, 0.0], [0.0, 0.0]])
    holds = probabilities(np.array([0.0, 0.0, -0.3]), scatter, ["beam", "draft", "mass"])
    assert holds["beam"] == pytest.approx(0.5, abs=0.01)
    assert holds["mass"] == 1.0
    assert holds["all"] < 0.01
    away = probabilities(np.array([-0.2, -0.5, -0.3]), scatter, ["beam", "draft", "mass"])
    assert away["beam"] == pytest.approx(norm.cdf(2), abs=2e-3)
    assert away["all"] == pytest.approx(norm.cdf(2), abs=2e-3)


def test_what_further_modes_change_holds_errors_of_first_order_and_none_that_seem_small_by_chance():
    """Powers 1 - c/degree: the last of all lies at the end; steps of two signs leave both sides open."""
    for i, degree in enumerate(DEGREES[:-2]):
        power = [1 - 0.1 / n for n in DEGREES[i : i + 3]]
        low, high = left_out([one / power[0] - 1 for one in power[1:]])
        assert low == pytest.approx(-high / 2)
        assert 0.1 / degree <= 1.000001 * high * power[0] <= 0.13 / degree
    assert left_out([0.002, -0.001]) == pytest.approx((-0.004, 0.003))
    assert left_out([1e-5, 2e-5], least=1e-3) == pytest.approx((-1e-3, 1.02e-3))
