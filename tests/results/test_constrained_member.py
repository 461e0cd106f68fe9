"""The tuning `constrained` of a member: its places in the results, what proves it, what is shared."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied
from results.test_year import climate
from scenes.test_ports import water

from vsb.motion.force_bound import Limits
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import PortMotion
from vsb.results.bins import Bins
from vsb.results.constrained_member import Optima, _beyond, _column, _gains, _motion_rms
from vsb.results.constrained_year import ConstrainedYear, constrained_year, harmonics_of_year
from vsb.results.ladder import GAP
from vsb.results.member import OF_LIMITS, member
from vsb.results.validity import LIMITS, wave_limits
from vsb.scenes.ports import designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.study.study import Water
from vsb.study.year_options import CONSTRAINED
from vsb.tools.units import check_finite
from vsb.waves.scatter import climate_of_cells

LIMIT, SECONDS = 2e4, 0.5


def optima_of(study, **changes):
    return Optima(**{"water": lambda basis, omega: water(study, omega=omega), "seconds": SECONDS, "seed": 1} | changes)


@pytest.fixture(scope="module")
def limited(seed):
    return varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "force_limit": LIMIT}, hydro={"omega_max": 8.0})


@pytest.fixture(scope="module")
def shared(limited):
    """Coefficients of the shape over all frequencies of the year."""
    return water(limited, omega=np.arange(0.1, 3.0, 0.01))


@pytest.fixture(scope="module")
def seas():
    return climate(seas=12)


@pytest.fixture(scope="module")
def found(limited, shared, seas):
    return member(limited, lambda basis: shared, seas, ("one", CONSTRAINED), optima_of(limited))


def test_optima_are_those_of_the_ports_at_harmonics(limited, shared, seas, found):
    """Power, force, matrix and gain of every design, from its port and the programme alone."""
    harmonics = harmonics_of_year(seas, float(shared.omega[0]), 8.0, SECONDS)
    waves = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.port_omega))
    years = {
        design: constrained_year(one.port, seas, limited.water, harmonics, Limits(LIMIT), SECONDS, 1)
        for design, one in waves.items()
    }
    at = found.sel(tuning=CONSTRAINED)
    for design, one in years.items():
        here = at.sel(design=design)
        assert float(here.annual_mean_power) == pytest.approx(one.annual_mean_power.mean, rel=1e-12)
        assert float(here.annual_energy) == pytest.approx(one.annual_mean_power.mean * 8.766e-3, rel=1e-12)
        flux = float(seas.flux(limited.water) @ seas.hours)
        assert float(here.capture_width) * flux == pytest.approx(one.annual_mean_power.mean, rel=1e-12)
        assert 2 * float(here.quadrature_error) == pytest.approx(np.ptp(one.annual_mean_power[1:]), rel=1e-12)
        assert float(here.force_rms) == pytest.approx(one.force_rms)
        assert one.force_rms < LIMIT
        np.testing.assert_allclose(here.power_matrix, one.power_matrix, rtol=1e-12)
        assert float((here.power_matrix * one.bins.share).sum()) == pytest.approx(one.taken, rel=1e-12)
        if design != "FSB":
            mean, low, high = one.gain(years["FSB"])
            assert float(here.gain_percent) == pytest.approx(mean, rel=1e-9)
            assert float(here.gain_low) < low < high < float(here.gain_high)


def test_a_damper_within_the_limit_takes_no_more(limited, shared, seas):
    """Where the limit is twenty times the damper's rms force, every optimum lies between damper and matched force."""
    wide = varied(limited, pto={"force_limit": 1e7})
    ds = member(wide, lambda basis: shared, seas, ("each", CONSTRAINED), optima_of(wide))
    assert bool((ds.annual_mean_power.sel(tuning=CONSTRAINED) > ds.annual_mean_power.sel(tuning="each")).all())


def test_every_optimum_has_its_proof(found):
    assert found.power_bound.dims == ("design",)
    at = found.sel(tuning=CONSTRAINED)
    assert bool((found.power_bound >= at.annual_mean_power).all())
    np.testing.assert_allclose(1 - at.annual_mean_power / found.power_bound, found.optimum_gap, atol=1e-12)
    assert float(found.optimum_gap.max()) < GAP
    assert found.optimum_share.values.tolist() == [1.0] * 4
    assert found.impossible_share.values.tolist() == [0.0] * 4


def test_dampers_beside_optima_are_what_they_are_alone(limited, shared, seas, found):
    alone = member(limited, lambda basis: shared, seas, ("one",))
    assert not set(OF_LIMITS) & set(alone)
    for name in alone.data_vars:
        here = found[name].sel(tuning=["one"]) if "tuning" in found[name].dims else found[name]
        np.testing.assert_array_equal(here.values, alone[name].values, err_msg=name)


def test_nothing_is_missing_but_what_usual_practice_says(found):
    check_finite(found, "a member")
    assert np.isnan(found.practice_power.sel(tuning=CONSTRAINED)).all()
    assert not np.isnan(found.practice_power.sel(tuning="one")).any()
    assert not found.damping.sel(tuning=CONSTRAINED).any()


def test_a_rigid_design_of_other_shells_is_solved_once(limited, shared, seas, monkeypatch):
    solved = []
    monkeypatch.setattr("vsb.results.constrained_member.constrained_year", _counted(solved))
    optima = optima_of(limited)
    for modulus in (1e7, 1e8):
        other = varied(limited, device={"young_modulus": modulus})
        member(other, lambda basis: shared, seas, (CONSTRAINED,), optima)
    assert solved.count(LIMIT) == 7  # four designs, then three
    rigid = varied(limited, designs={"FSB": {"flexible": False}})
    alone = water(rigid, omega=shared.omega)
    optima = optima_of(rigid, known=optima.known)
    monkeypatch.setattr("vsb.results.constrained_member.KEPT", 2)
    for limit in (1e6, 2e6):
        member(varied(rigid, pto={"force_limit": limit}), lambda basis: alone, seas, (CONSTRAINED,), optima)
    assert len(optima.known) == 2


def _counted(solved):
    def counted(*given):
        solved.append(given[4].force)
        return constrained_year(*given)

    return counted


def test_stroke_that_no_force_keeps_takes_nothing(limited, shared, seas):
    tight = varied(limited, pto={"force_limit": 100.0, "stroke_limit": 0.02})
    ds = member(tight, lambda basis: shared, seas, (CONSTRAINED,), optima_of(tight)).sel(tuning=CONSTRAINED)
    assert ds.impossible_share.sel(design="FSB") == 1
    assert ds.annual_mean_power.sel(design="FSB") == 0
    assert "gain_percent" not in ds or np.isnan(ds.gain_percent).all()


def test_shells_moved_by_the_best_force_are_judged_bin_by_bin(limited, shared, seas, found):
    """A bin whose shell deforms too much is marked whole; stiff shells and rigid buoys mark none."""
    soft = varied(limited, device={"young_modulus": 5e5}, pto={"stiffness": 1e5})
    ds = optima_of(soft)(soft, reference_shell(soft), seas, float(shared.omega[0]))
    ds = ds.sel(tuning=CONSTRAINED).assign_coords(limit=list(LIMITS))
    assert 0 < float(ds.energy_beyond.sel(design="VSWEC", limit="deformation")) <= 1
    assert float(ds.energy_beyond.sel(design="FSB", limit="deformation")) == 0
    assert bool((ds.energy_beyond_validity >= ds.energy_beyond.sel(limit="deformation") - 1e-12).all())
    marked = ds.beyond_validity.sel(design="VSWEC")
    assert set(np.unique(marked.where(found["count"] > 0, 0))) <= {0.0, 1.0} | set(
        np.unique(ds.beyond_validity.sel(design="FSB"))
    )


def test_motion_under_the_best_force_is_the_stroke_it_keeps(limited, seas):
    """Of a port at heave: what marks are told from is what the programme limits."""
    harmonics = Harmonics(0.1, 2.0, 30)
    one = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.port_omega))["VSWEC"]
    found = constrained_year(one.port, seas, limited.water, harmonics, Limits(LIMIT, 2.0), SECONDS, 1)
    strokes = [[np.linalg.norm(optimum.stroke) ** 2 / 2 for optimum in pair] for pair in found.optima]
    np.testing.assert_allclose(_motion_rms(found, one.motion)["heave"], np.sqrt(np.mean(strokes, axis=1)), rtol=1e-9)


def test_deformation_is_the_length_of_what_a_point_moves_and_the_largest_of_all(limited, seas):
    """A shell that moves as the buoy does in both directions, half as far elsewhere: the root of two times heave."""
    harmonics = Harmonics(0.1, 2.0, 30)
    one = designs_in_waves(limited, reference_shell(limited), water(limited, omega=harmonics.port_omega))["VSWEC"]
    found = constrained_year(one.port, seas, limited.water, harmonics, Limits(LIMIT), SECONDS, 1)
    shell = tuple(np.stack([[0.5 * part, part, 0.2 * part]] * 2) for part in one.motion.heave)
    moved = _motion_rms(found, replace(one.motion, shell=shell))
    np.testing.assert_allclose(moved["deformation"], np.sqrt(2) * moved["heave"], rtol=1e-12)
    assert (moved["heave"] > 0).all()


def test_years_within_other_limits_are_not_taken_for_known(limited, seas):
    """Of one rigid design, and so one port: what is found after other limits is what is found alone, to the bit."""
    rigid, kept = varied(limited, designs={"FSB": {"flexible": False}}), None
    powers = []
    for pto in ({"force_limit": 1e4}, {"force_limit": 2e4}, {"force_limit": 2e4, "stroke_limit": 0.1}):
        one = varied(rigid, pto=pto)
        kept = kept or optima_of(one)
        found, alone = (of(one, reference_shell(one), seas, 0.1) for of in (kept, optima_of(one)))
        assert found.identical(alone)
        powers.append(float(found.annual_mean_power.squeeze()))
    assert len(kept.known) == len(set(powers)) == 3


SEAS = climate_of_cells(
    np.array([1.0, 4.0, 4.1, 6.0]), np.array([9.0, 7.0, 7.9, 6.5]), np.array([0.4, 0.2, 0.3, 0.1]), 3.3, "four"
)
"""Of the second and the third, which share a bin, the one alone is too steep in deep water."""


def by_hand(powers=((8e3, 6e3), (5e3, 7e3), (1e3, 2e3)), waves=((2.0, 1.0), (3.0, 4.0), (0.5, 0.2)), lost=()):
    """Optima of the bins of those seas, the highest first: powers and amplitudes of two realisations, no force."""
    bins = Bins(SEAS.hs, SEAS.te, SEAS.hours)
    none = np.zeros(1, dtype=complex)
    pairs = [
        [
            None
            if (i, k) in lost
            else SimpleNamespace(power=power, bound=1.1 * power, force=none, force_rms=power / 10, excess=power / 1e6)
            for k, power in enumerate(pair)
        ]
        for i, pair in enumerate(powers)
    ]
    amplitude = np.array(waves, dtype=complex)[..., None]
    matched = np.full(bins.shape, 2e4)
    return ConstrainedYear(bins, bins.occupied[::-1], amplitude, tuple(map(tuple, pairs)), matched, 0.75)


@pytest.mark.parametrize("depth", [np.inf, 15.0])
@pytest.mark.parametrize("largest", [0, 1, 3])
def test_of_a_bin_the_seas_beyond_count_by_their_hours_and_all_of_it_where_the_shell_deforms_too_much(depth, largest):
    """Sea by sea and bin by bin, each with its part of the energy; by a shell that moves as the waves in one place."""
    one, water = by_hand(), Water(depth=depth)
    rms = np.sqrt((np.abs(one.amplitude) ** 2).sum(axis=-1).mean(axis=1) / 2)
    over = np.sort(rms)[::-1]
    limit = np.inf if not largest else over[largest - 1] * (1 - 1e-9)  # of the deformation, over what it may be
    shell = np.array([[[0.0], [0.1 / 3.72 * 2.0 / limit]], [[0.0], [0.0]]], dtype=complex)
    motion = PortMotion((np.ones(1, dtype=complex), np.zeros(1, dtype=complex)), (shell, 0 * shell))
    study = SimpleNamespace(water=water, device=SimpleNamespace(radius=2.0))
    found = _beyond(study, one, motion, SEAS)
    seas = {one.name: one.seas for one in wave_limits(SEAS, water)}
    hours, marked = one.bins.share.ravel(), np.zeros(one.bins.shape).ravel()
    energy, together = dict.fromkeys(LIMITS, 0.0), 0.0
    for place, moved, pair in zip(one.solved, rms, one.optima, strict=True):
        its, power = one.bins.index == place, hours[place] * np.mean([each.power for each in pair])
        parts = {name: SEAS.hours[its & which].sum() / SEAS.hours[its].sum() for name, which in seas.items()}
        parts |= {"deformation": float(moved >= limit), "heave": float(3.72 * moved / 2.0 > 0.3)}
        steep = SEAS.hours[its & (seas["steepness"] | seas["breaking"])].sum() / SEAS.hours[its].sum()
        marked[place] = 1.0 if moved >= limit else steep
        energy = {name: energy[name] + parts[name] * power / one.taken for name in LIMITS}
        together += marked[place] * power / one.taken
    assert found["beyond_validity"].ravel() == pytest.approx(marked, abs=1e-12)
    assert found["energy_beyond"] == pytest.approx(np.array(list(energy.values())), abs=1e-12)
    assert found["energy_beyond_validity"] == pytest.approx(together, abs=1e-12)


def test_waves_in_which_no_force_keeps_the_limits_move_nothing():
    """Of the second bin one realisation of two, of the third both."""
    one = by_hand(lost={(1, 1), (2, 0), (2, 1)})
    ones = np.ones(1, dtype=complex)
    shell = np.full((2, 1, 1), 0.1 + 0j)
    moved = _motion_rms(one, PortMotion((ones, ones), (shell, 0 * shell)))
    expected = np.sqrt(np.array([(4.0 + 1.0) / 2, 9.0 / 2, 0.0]) / 2)
    assert moved["heave"] == pytest.approx(expected)
    assert moved["deformation"] == pytest.approx(0.1 * np.sqrt(2) * expected)


def test_the_figures_of_one_design_are_those_of_its_bins_and_their_hours():
    """Bins of 0.1, 0.5 and 0.4 of the year, the highest first."""
    one, flux = by_hand(lost={(2, 1)}), SEAS.flux(Water())
    column = _column(one, SEAS, flux)
    power = dict(zip(one.solved, (7e3, 6e3, 0.5e3), strict=True))
    for place in range(one.bins.share.size):
        its = one.bins.index == place
        known = SEAS.hours[its].sum() * power[place] / (flux * SEAS.hours)[its].sum() if its.any() else 0.0
        assert column["capture_width_matrix"].ravel()[place] == pytest.approx(known, rel=1e-12)
    assert column["power_matrix"].ravel()[one.solved] == pytest.approx(list(power.values()))
    assert column["force_rms"] == pytest.approx(np.sqrt(0.1 * 50e4 + 0.5 * 37e4 + 0.4 * 0.5e4))
    told = {f"optimum_{name}": column[f"optimum_{name}"] for name in ("share", "excess", "gap")}
    assert told == pytest.approx({"optimum_share": 0.75, "optimum_excess": 8e-3, "optimum_gap": 1 - 1 / 1.1})
    some = replace(one, solved=one.solved[:2], amplitude=one.amplitude[:2], optima=one.optima[:2])
    assert some.annual_mean_power.mean > some.taken  # the bins not solved are extrapolated, and prove nothing
    gap = 1 - (700 + 3000) / (1.1 * (700 + 3000) + 0.4 * 2e4)
    assert _column(some, SEAS, flux)["optimum_gap"] == pytest.approx(gap)
    assert column["impossible_share"] == pytest.approx(0.4 / 2)
    assert column["power_bound"] == pytest.approx(1.1 * (700 + 3000 + 200))
    assert not any(column[name].any() for name in ("damping", "power_deviation", "capture_width_deviation"))


def test_the_year_of_a_rigid_design_is_known_by_port_limits_and_water_and_of_a_flexible_one_nothing_is(
    limited, monkeypatch
):
    """Each by itself; at the member's own harmonics, budget and seed."""
    asked = []
    monkeypatch.setattr(
        "vsb.results.constrained_member.constrained_year", lambda *given: asked.append(given) or object()
    )
    optima, harmonics = optima_of(limited, seed=7, seconds=3.0), Harmonics(0.1, 2.0, 5)
    port = SimpleNamespace(velocity=np.full(5, 1.0 + 1j), admittance=np.full(5, 2.0 + 1j))
    ports = [port, SimpleNamespace(**{**vars(port), "velocity": 2 * port.velocity})]
    ports.append(SimpleNamespace(**{**vars(port), "admittance": 2 * port.admittance}))
    changes = [
        {"pto": {"force_limit": 3e4}}, {"pto": {"stroke_limit": 0.5}}, {"water": {"density": 1000.0}},
        {"water": {"depth": 30.0}}, {"water": {"gravity": 9.8}},
    ]  # fmt: skip
    studies = [limited, *(varied(limited, **change) for change in changes)]
    cases = [*((limited, each) for each in ports), *((study, port) for study in studies[1:])]
    found = [optima._year(study, "FSB", SimpleNamespace(port=each), SEAS, harmonics) for study, each in cases]
    again = [optima._year(study, "FSB", SimpleNamespace(port=each), SEAS, harmonics) for study, each in cases]
    assert [a is b for a, b in zip(found, again, strict=True)] == [True] * len(cases)
    assert len(set(map(id, found))) == len(asked) == len(optima.known) == len(cases) == 8
    for (study, each), given in zip(cases, asked, strict=True):
        limits = Limits(study.pto.force_limit, study.pto.stroke_limit)
        assert given == (each, SEAS, study.water, harmonics, limits, 3.0, 7)
    shells = [
        optima._year(
            limited,
            "VSWEC",
            SimpleNamespace(port=SimpleNamespace(**{**vars(port), "velocity": 3 * port.velocity})),
            SEAS,
            harmonics,
        )
        for _ in (0, 1)
    ]
    assert shells[0] is not shells[1]
    assert len(optima.known) == 8


@pytest.mark.filterwarnings("error")
def test_designs_that_take_nothing_prove_nothing_and_bring_no_energy_from_beyond():
    """Of a port that waves do not move: no bound is missed, and there is nothing to part."""
    still = replace(by_hand(powers=((0.0, 0.0),) * 3), matched=np.zeros(by_hand().bins.shape))
    column = _column(still, SEAS, SEAS.flux(Water()))
    told = [column[name] for name in ("annual_mean_power", "annual_energy", "capture_width", "force_rms")]
    assert told == [0.0] * 4
    assert (column["power_bound"], column["optimum_gap"], column["quadrature_error"]) == (0.0, 0.0, 0.0)
    assert not column["capture_width_matrix"].any()
    ones, none = np.ones(1, dtype=complex), np.zeros((2, 1, 1), dtype=complex)
    study = SimpleNamespace(water=Water(), device=SimpleNamespace(radius=2.0))
    found = _beyond(study, still, PortMotion((ones, 0 * ones), (none, none)), SEAS)
    assert found["energy_beyond"].tolist() == [0.0] * len(LIMITS)
    assert found["energy_beyond_validity"] == 0.0
    assert found["beyond_validity"].max() > 0


def test_gains_are_over_the_reference_wherever_it_stands_and_none_over_one_that_takes_nothing():
    """Widened by errors of the coefficients and by modes left out; of itself it gains nothing for sure."""
    years = {"B": by_hand(powers=((9e3, 8e3), (6e3, 6e3), (2e3, 1e3))), "A": by_hand()}
    left_out = np.array([[-1.5, 0.5], [-1.5, 0.5]])
    for reference, other in (("A", "B"), ("B", "A")):
        found = _gains(years, reference, [0.02, 0.02], left_out)
        assert found[reference] == {"gain_percent": pytest.approx(0.0, abs=1e-9), "gain_low": 0.0, "gain_high": 0.0}
        mean, low, high = years[other].gain(years[reference])
        width = 0.02 * (100 + mean)
        told = {"gain_percent": mean, "gain_low": low - width - 1.5, "gain_high": high + width + 0.5}
        assert found[other] == pytest.approx(told, rel=1e-12)
    years["C"] = by_hand(powers=((0.0, 0.0),) * 3)
    assert _gains(years, "C", [0.0] * 3, np.zeros((3, 2))) == {}


def test_a_shell_is_judged_by_its_point_that_moves_most_wherever_it_stands():
    """Of three points the first, then the second, then the last; both directions and both realisations count."""
    one = by_hand()
    ones, sizes = np.ones(1, dtype=complex), np.array([3.0, 1.0, 2.0]) / 100
    rms = np.sqrt((np.abs(one.amplitude[..., 0]) ** 2).mean(axis=1) / 2)
    for turn in range(3):
        along = np.roll(sizes, turn)[:, None] + 0j
        shell = np.stack([0.6 * along, 0.8j * along])
        moved = _motion_rms(one, PortMotion((2 * ones, 0 * ones), (shell, 0 * shell)))
        assert moved["deformation"] == pytest.approx(0.03 * rms)
        assert moved["heave"] == pytest.approx(2 * rms)
