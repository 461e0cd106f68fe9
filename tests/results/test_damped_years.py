"""Years under dampers: a rigid design that points have in common is computed once."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from results.test_member import TUNINGS
from results.test_year import climate
from scenes.test_ports import water

from vsb.results.damped_years import BY, CURVES, TRIED, DampedYears, _gains, _key, ports_year
from vsb.results.member import member
from vsb.results.validity import beyond_validity
from vsb.results.year import band_weights
from vsb.scenes.ports import designs_in_waves
from vsb.scenes.rest import reference_shell


@pytest.fixture(scope="module")
def study(seed):
    return varied(seed, modes={"degree": 2}, pto={"damping": 8e3})


@pytest.fixture(scope="module")
def shared(study):
    """Coefficients of the shape over all frequencies of the year."""
    return water(study, omega=np.arange(0.1, 3.0, 0.01))


@pytest.fixture(scope="module")
def seas():
    return climate(seas=12)


def counted(monkeypatch):
    """How many designs each call computed, from now on."""
    counts, own = [], DampedYears._computed
    monkeypatch.setattr(
        DampedYears, "_computed", lambda self, study, waves: counts.append([*waves]) or own(self, study, waves)
    )
    return counts


def test_a_rigid_design_is_computed_once_for_all_shells(study, shared, seas, monkeypatch):
    """What is known of it is what would be found again, to the bit; of another damper or radius nothing is known."""
    stiffer, counts, known = varied(study, device={"young_modulus": 3e7}), counted(monkeypatch), {}
    for one in (study, stiffer):
        kept = member(one, lambda basis: shared, seas, TUNINGS, known=known)
        assert kept.identical(member(one, lambda basis: shared, seas, TUNINGS))
    rigid, *others = study.designs
    assert counts == [[rigid, *others], [rigid, *others], others, [rigid, *others]]
    member(varied(study, pto={"damping": 9e3}), lambda basis: shared, seas, TUNINGS, known=known)
    assert counts[-1] == [rigid, *others]
    assert len(known) == 2


def test_no_more_rigid_designs_are_kept_than_a_sweep_may_want(study, shared, seas, monkeypatch):
    monkeypatch.setattr("vsb.results.damped_years.KEPT", 1)
    known, kept = {}, []
    for damping in (6e3, 7e3, 8e3, 9e3):
        member(varied(study, pto={"damping": damping}), lambda basis: shared, seas, TUNINGS, known=known)
        kept.append(len(known))
    assert kept == [1, 2, 1, 2]  # all go where there are more than one


def test_what_the_port_does_not_tell_of_the_water_is_not_taken_for_known(study, shared, seas):
    """The same coefficients in another water: energy flux, and so capture width, are that water's."""
    lighter, known = varied(study, water={"density": 1000.0}), {}
    member(study, lambda basis: shared, seas, TUNINGS, known=known)
    found = member(lighter, lambda basis: shared, seas, TUNINGS, known=known)
    assert found.identical(member(lighter, lambda basis: shared, seas, TUNINGS))
    for depth in (1e4, np.inf):
        member(varied(study, water={"depth": depth}), lambda basis: shared, seas, TUNINGS, known=known)
    assert len(known) == 3  # the last is the first


def test_a_gain_lies_within_the_errors_of_both_designs_and_of_their_coefficients():
    """Of 150 W known to 2 % over 100 W known to 5 %, coefficients to 2 % of the ratio: 50 % and 9 % of 1.5.

    Shell modes left out change it by -3 to +1 points more.
    """
    power = np.array([[100.0, 40.0], [150.0, 20.0]])
    error = np.array([[0.05, 0.0], [0.02, 0.1]]) * power
    found = _gains(
        {"annual_mean_power": (BY, power), "quadrature_error": (BY, error)},
        ["A", "B"],
        "A",
        np.full((2, 2), 0.02),
        np.array([[0.0, 0.0], [-3.0, 1.0]]),
    )
    gain, low, high = (found[name][1] for name in ("gain_percent", "gain_low", "gain_high"))
    assert gain == pytest.approx(np.array([[0.0, 0.0], [50.0, -50.0]]))
    assert high - gain == pytest.approx(np.array([[0.0, 0.0], [0.09 * 150 + 1, 0.12 * 50 + 1]]))
    assert gain - low == pytest.approx(np.array([[0.0, 0.0], [0.09 * 150 + 3, 0.12 * 50 + 3]]))


def test_power_over_a_damper_that_stays_is_that_of_years_with_it_given(study, shared, seas):
    """The middle one is the best for all seas; a damper's mean power is its mean square force over it, P = F^2/c."""
    found = member(study, lambda basis: shared, seas, TUNINGS)
    tried, power, force = (found[f"{name}_damping"].values for name in ("tried", "power_of", "force_of"))
    best = np.nanmax(found.damping.sel(tuning="one").values, axis=(1, 2))
    assert tried == pytest.approx(np.outer(best, TRIED), rel=1e-12)
    assert (power.argmax(axis=1) == 30).all()
    for i in (0, 45):
        given = varied(study, pto={"damping": float(tried[0, i])})
        year = member(given, lambda basis: shared, seas, ("fixed",)).isel(design=0, tuning=0)
        assert power[0, i] == pytest.approx(float(year.annual_mean_power), rel=1e-9)
        assert force[0, i] == pytest.approx(float(year.force_rms), rel=1e-9)


def test_years_are_beside_the_spring_of_the_take_off(study, shared, seas):
    """With c + i k/omega at the port, P = c |v|^2/2 of every wave, and so over a damper that stays as it is."""
    spring = varied(study, pto={"damping": 8e3, "stiffness": 2e4})
    waves = designs_in_waves(spring, reference_shell(spring), shared)
    found = member(spring, lambda basis: shared, seas, ("fixed",))
    for i, one in enumerate(waves.values()):
        omega = one.port.omega
        weights = band_weights(omega, seas).T @ (seas.hours @ seas.density) / seas.hours.sum()

        def taken(damping, one=one, omega=omega, weights=weights):
            load = damping + 1j * 2e4 / omega
            return float(weights @ np.abs(one.port.velocity / (1 + one.port.admittance * load)) ** 2) * damping / 2

        assert float(found.annual_mean_power[i, 0]) == pytest.approx(taken(8e3), rel=2e-3)
        for k in (0, 30, 60):
            tried, power = (float(found[name][i, k]) for name in ("tried_damping", "power_of_damping"))
            assert power == pytest.approx(taken(tried), rel=2e-3)


def test_gains_are_told_of_what_absorbs_alone():
    """Nothing over nothing is no gain: of no design of the study, or without one to compare with."""
    power = np.array([[0.0], [10.0]])
    found = {"annual_mean_power": (BY, power), "quadrature_error": (BY, 0 * power)}
    assert _gains(found, ["A", "B"], "A", np.full((2, 1), 0.02), np.zeros((2, 2))) == {}


def test_a_damper_of_nothing_is_one_that_is_given(study, shared, seas):
    """It takes nothing, and that is what is asked."""
    waves = designs_in_waves(study, reference_shell(study), shared)
    ports = {design: one.port for design, one in waves.items()}
    given = varied(study, pto={"damping": 0.0})
    assert not ports_year(given, ports, seas, ("fixed",)).annual_mean_power.any()


def test_power_over_the_damper_is_told_about_the_best_one_whatever_tunings_are_asked_for(study, shared, seas):
    """Also where dampers are given or each sea has its own, or none is asked for at all."""
    waves = designs_in_waves(study, reference_shell(study), shared)
    known = DampedYears(seas, ("one",))(study, waves)
    for tunings in ((), ("fixed",), ("each", "fixed"), ("fixed", "one"), ("each", "one")):
        found = DampedYears(seas, tunings)(study, waves)
        for name in CURVES:
            np.testing.assert_allclose(found[name][1], known[name][1], rtol=1e-9, err_msg=f"{name} {tunings}")


def test_the_year_of_a_rigid_design_is_known_by_all_it_depends_on(study, shared):
    """Port, motion, damper, spring, radius and water, each by itself; by no other design's damper or material."""
    one = designs_in_waves(study, reference_shell(study), shared)["FSB"]
    port, motion = one.port, one.motion
    shell = tuple(part + 1.0 for part in motion.shell)
    others = [
        one._replace(port=replace(port, velocity=2 * port.velocity)),
        one._replace(port=replace(port, admittance=2 * port.admittance)),
        one._replace(motion=replace(motion, heave=(2 * motion.heave[0], motion.heave[1]))),
        one._replace(motion=replace(motion, heave=(motion.heave[0], 2 * motion.heave[1]))),
        one._replace(motion=replace(motion, shell=(shell[0], motion.shell[1]))),
        one._replace(motion=replace(motion, shell=(motion.shell[0], shell[1]))),
    ]
    changes = [
        {"pto": {"damping": 9e3}}, {"pto": {"damping": 8e3, "stiffness": 1e3}}, {"device": {"radius": 2.1}},
        {"water": {"density": 1000.0}}, {"water": {"depth": 30.0}}, {"water": {"gravity": 9.8}},
    ]  # fmt: skip
    keys = [_key(study, "FSB", each) for each in (one, *others)]
    keys += [_key(varied(study, **change), "FSB", one) for change in changes]
    assert len(set(keys)) == len(keys) == 13
    dampers = {"FSB": 8e3, **dict.fromkeys(list(study.designs)[1:], 5e3)}
    assert _key(varied(study, pto={"damping": dampers}, device={"young_modulus": 3e7}), "FSB", one) == keys[0]


def test_gains_are_over_the_reference_wherever_it_stands():
    """The second of three; over one that takes nothing under one tuning there is none there."""
    power = np.array([[150.0, 20.0], [100.0, 0.0], [80.0, 10.0]])
    error = np.array([[0.02, 0.1], [0.05, 0.0], [0.01, 0.02]]) * power
    found = _gains(
        {"annual_mean_power": (BY, power), "quadrature_error": (BY, error)},
        ["A", "B", "C"],
        "B",
        np.full((3, 2), 0.02),
        np.zeros((3, 2)),
    )
    gain, low, high = (found[name][1] for name in ("gain_percent", "gain_low", "gain_high"))
    assert gain[:, 0] == pytest.approx([50.0, 0.0, -20.0])
    assert (high - gain)[:, 0] == pytest.approx([0.09 * 150, 0.0, 0.08 * 80])
    assert (gain - low)[:, 0] == pytest.approx([0.09 * 150, 0.0, 0.08 * 80])
    assert np.isnan([gain[:, 1], low[:, 1], high[:, 1]]).all()


@pytest.mark.filterwarnings("error")
def test_an_error_of_what_takes_nothing_is_that_of_its_coefficients():
    """Nothing is divided by nothing."""
    power = np.array([[100.0], [0.0]])
    found = _gains(
        {"annual_mean_power": (BY, power), "quadrature_error": (BY, 0.02 * power)},
        ["A", "B"],
        "A",
        0 * power,
        np.zeros((2, 2)),
    )
    assert [found[name][1][1, 0] for name in ("gain_percent", "gain_low", "gain_high")] == [-100.0] * 3


def test_motions_are_judged_beside_the_spring_of_the_take_off_and_by_the_radius(study, shared, seas, monkeypatch):
    """Under the dampers of the year that is told."""
    asked, own = [], beyond_validity
    monkeypatch.setattr("vsb.results.damped_years.beyond_validity", lambda *given: asked.append(given) or own(*given))
    spring = varied(study, pto={"damping": 8e3, "stiffness": 2e4})
    waves = designs_in_waves(spring, reference_shell(spring), shared)
    found = DampedYears(seas, ("fixed", "one"))(spring, waves)
    ((of, seen, stiffness, radius),) = asked
    assert (dict(seen), stiffness, radius) == (waves, 2e4, spring.device.radius)
    np.testing.assert_array_equal(of.annual_mean_power, found["annual_mean_power"][1])
    for name, (dims, values) in own(of, waves, 2e4, spring.device.radius).items():
        assert found[name][0] == dims
        np.testing.assert_array_equal(found[name][1], values)


def test_the_year_of_ports_is_of_the_study_s_water_dampers_and_reference(study, shared, seas):
    """Each design at its own damper given."""
    dampers = {name: 5e3 * (i + 1) for i, name in enumerate(study.designs)}
    given = varied(study, pto={"damping": dampers}, water={"density": 900.0})
    waves = designs_in_waves(given, reference_shell(given), shared)
    of = ports_year(given, {design: one.port for design, one in waves.items()}, seas, ("one", "fixed"))
    assert (of.reference, of.water, of.tunings) == (given.reference_design, given.water, ("one", "fixed"))
    assert of.damping[:, 1, 0].tolist() == list(dampers.values())


def test_of_rigid_designs_each_is_known_by_itself(study, shared, seas, monkeypatch):
    """Two of them under dampers of their own: of the second's other damper the first need not be computed again."""
    designs, counts = {"R": {"flexible": False}, "S": {}, "Q": {"flexible": False}}, counted(monkeypatch)
    first, second = (
        varied(study, designs=designs, pto={"damping": {"R": 8e3, "S": 8e3, "Q": damper}}) for damper in (5e3, 6e3)
    )
    years = DampedYears(seas, ("fixed",))
    for one in (first, second, first):
        waves = designs_in_waves(one, reference_shell(one), shared)
        found = years(one, waves)
        alone = DampedYears(seas, ("fixed",))(one, waves)
        for name, (dims, values) in alone.items():
            assert found[name][0] == dims
            np.testing.assert_allclose(found[name][1], values, rtol=1e-12, err_msg=name)
    assert counts[::2] == [["R", "S", "Q"], ["S", "Q"], ["S"]]
    assert len(years.known) == 3
