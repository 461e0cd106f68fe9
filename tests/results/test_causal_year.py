"""A year under causal control: order of tunings, one sea's level, a schedule that is linear in the spectra."""

from dataclasses import replace

import numpy as np
import pytest
from models.test_stationary import example  # noqa: F401
from motion.test_causal import coupled

from vsb.engine.motion.causal import StationaryPorts
from vsb.engine.motion.port import Ports, port_direction
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.scatter import climate_of_cells
from vsb.models.rest import reference_shell
from vsb.results.causal_year import causal_years, port_means, scheduled_at_ports, schedules
from vsb.results.year import DesignYear, MatrixYear, bins_of, frequencies


@pytest.fixture(scope="module")
def climate():
    """Three seas, two of them in one bin."""
    cells = np.array([1.0, 1.1, 1.6]), np.array([3.4, 3.9, 4.4])
    return climate_of_cells(*cells, np.array([0.5, 0.3, 0.2]), 3.3, "three seas")


def with_quality(floating):
    """The example with what a database says of its errors, as in a campaign."""
    water = {"water_depth": np.inf, "water_density": 1025.0, "gravity": 9.81}
    checked = floating.linear.database.assign_attrs(quality="[]", **water)
    return replace(floating, linear=replace(floating.linear, database=checked))


@pytest.fixture(scope="module")
def unlimited(example, climate):  # noqa: F811
    """The year of the example without a limit of force."""
    return causal_years(example[0], with_quality(example[1]), climate)


@pytest.mark.parametrize("limit", [1e3, np.inf])
def test_year_lies_between_dampers_and_the_matched_force(example, climate, unlimited, limit):  # noqa: F811
    study, floating = example[0], with_quality(example[1])
    limited = study.model_copy(update={"pto": Pto(force_limit=limit)})
    whole = unlimited if np.isinf(limit) else causal_years(limited, floating, climate)
    dampers, found = ({name: np.asarray(values)[:, i] for name, (_, values) in whole.items()} for i in (0, 1))
    assert (dampers["annual_mean_power"] < found["annual_mean_power"]).all()
    power, bins = found["annual_mean_power"], bins_of(climate)
    omega = frequencies(climate, *floating.band)
    for i, one in enumerate(floating.at(omega).in_waves().values()):
        year = DesignYear(one.port, climate)
        matched = float(year.squares @ one.port.matched_power)
        free = np.sqrt(0.5 * bins.mean_densities(climate) @ year.weights @ np.abs(one.port.velocity) ** 2)
        if limit == 1e3:
            assert 0.8 < power[i] / (1e3 * float(bins.share[bins.share > 0] @ free)) < 1.0
            assert found["force_rms"][i] == pytest.approx(1e3, rel=1e-5)
        else:
            best = float(year.absorbed("each", None).power @ climate.hours)
            assert 1.1 * best < power[i] < matched
            assert dampers["annual_mean_power"][i] == pytest.approx(best, rel=1e-2)  # of each bin, not of each sea
        assert found["annual_mean_power_low"][i] < power[i] < found["annual_mean_power_high"][i]
        assert (bins.share * found["power_matrix"][i]).sum() == pytest.approx(power[i])
    assert 0.0 < found["gain_percent"][1] < 5.0 if limit == 1e3 else found["gain_percent"][0] == 0.0
    assert all(np.isfinite(values).all() for values in found.values())


def converted(power, force, speed, efficiency, angles=4096):
    """Mean of e p+ + p-/e of jointly Gaussian force and velocity, by the trapezoidal rule over their angle."""
    rho = power / np.sqrt(force * speed)
    angle = 2 * np.pi * (np.arange(angles) + 0.5) / angles
    p = 2 * np.sqrt(force * speed)[:, None] * np.cos(angle) * np.cos(angle - np.arccos(rho)[:, None])
    return np.where(p > 0, efficiency * p, p / efficiency).mean(axis=1)


def test_losses_in_conversion_are_those_of_each_sea(example, climate, unlimited):  # noqa: F811
    """In a bin of two seas of other periods the mean of both, no better than the same part of the power at the port."""
    study, floating = example[0], with_quality(example[1])
    lossy = study.model_copy(update={"pto": Pto(efficiency=0.7, tuning="each")})
    (dampers, whole), (part, found) = (
        np.moveaxis(np.asarray(years["annual_mean_power"][1]), 1, 0)
        for years in (unlimited, causal_years(lossy, floating, climate))
    )
    np.testing.assert_allclose(part, 0.7 * dampers, rtol=1e-9)
    assert (part < found).all()
    assert (found < 0.7 * whole).all()
    bins, omega = bins_of(climate), frequencies(climate, *floating.band)
    waves = floating.at(omega).in_waves()
    by_bin = schedules(lossy, floating, climate, waves)
    for (design, one), total in zip(waves.items(), found, strict=True):
        own, year = by_bin[design], DesignYear(one.port, climate)
        seas = climate.density @ year.weights
        expected = 0.0
        for place, in_bin in zip(bins.occupied, own, strict=True):
            here = bins.index == place
            means = port_means(one.port, in_bin["causal"].force) @ seas[here].T
            expected += climate.hours[here] @ converted(*means, 0.7)
        assert total == pytest.approx(expected, rel=1e-3)  # noise and the grid of the controller


TOP = {"ports": {"heave": "heave", "top": {"colatitude": 0.0, "against": "frame"}}}


def test_year_of_several_ports_lies_between_damper_matrices_and_matched_forces(example, climate, unlimited):  # noqa: F811
    """A rigid buoy, which moves one of the ports alone, has the year that this port has by itself."""
    study, floating = example[0], with_quality(example[1])
    several = study.model_copy(update={"pto": Pto.model_validate(TOP)})
    ports = replace(floating, port=port_direction(several.pto.port, reference_shell(several)))
    found = causal_years(several, ports, climate)
    seen = ports.several_ports(frequencies(climate, *ports.band))
    power, low, high = (
        np.asarray(found[name][1]) for name in ("annual_mean_power", "annual_mean_power_low", "annual_mean_power_high")
    )
    for i, (design, port) in enumerate(seen.items()):
        year = MatrixYear(port, climate)
        matrix = float(year.absorbed("each", None).power @ climate.hours)
        assert power[i, 0] == pytest.approx(matrix, rel=5e-3)  # of each bin, not of each sea
        assert power[i, 0] < power[i, 1] < float(year.squares @ port.matched_power)
        assert low[i, 1] < power[i, 1] < high[i, 1]
        alone = np.asarray(unlimited["annual_mean_power"][1])[i]
        if study.designs[design].flexible:
            assert (power[i] > alone).all()
        else:
            np.testing.assert_allclose(power[i], alone, rtol=1e-5)
    matrices = np.asarray(found["damper_matrix"][1])
    assert np.isfinite(matrices[:, 0]).all()
    assert np.isnan(matrices[:, 1]).all()


def test_schedule_of_ports_does_not_depend_on_what_they_are_turned_by():
    """The forces of a schedule absorb its power, whatever combinations of them are called ports."""
    ports, seen, squares = coupled(0.02)
    density = squares[None, 1:-1] / (2 * ports.spacing)
    seas = Climate.of_spectra(seen.omega[1:-1], density, np.ones(1), "one sea")

    def schedule(turn):
        own = Ports(seen.omega, turn.T @ seen.admittance @ turn, seen.velocity @ turn)
        year = MatrixYear(own, seas)
        return own, scheduled_at_ports(Pto.model_validate(TOP), year, squares, ports.over(turn))

    powers = []
    for angle in (0.0, 0.7):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        own, found = schedule(turn)
        for one in found.values():
            velocity = own.velocity - (own.admittance @ one.force[..., None])[..., 0]
            absorbed = 0.5 * squares @ np.real(np.einsum("wi,wi->w", one.force.conj(), velocity))
            assert absorbed == pytest.approx(one.power, rel=2e-3)  # less what noise costs
        powers.append([(one.power, one.force_rms) for one in found.values()])
    np.testing.assert_allclose(powers[1], powers[0], rtol=1e-4)
    assert powers[0][0][0] < powers[0][1][0]


def test_two_equal_ports_that_are_not_coupled_absorb_twice_as_much():
    ports, seen, squares = coupled()
    seas = Climate.of_spectra(seen.omega[1:-1], squares[None, 1:-1] / (2 * ports.spacing), np.ones(1), "one sea")

    def schedule(twice):
        y, s = ports.admittance[:, :1, :1] * np.eye(len(twice)), ports.spectrum[:, :1, :1] * np.outer(twice, twice)
        year = MatrixYear(Ports(seen.omega, y, seen.velocity[:, :1] * twice), seas, kind="diagonal")
        return scheduled_at_ports(Pto.model_validate(TOP), year, squares, StationaryPorts(ports.spacing, y, s))

    one, both = schedule(np.ones(1)), schedule(np.ones(2))
    for name, found in both.items():
        assert found.power == pytest.approx(2 * one[name].power, rel=1e-5)
        assert found.force_rms == pytest.approx(np.sqrt(2) * one[name].force_rms, rel=1e-4)
