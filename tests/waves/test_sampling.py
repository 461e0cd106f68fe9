"""Signals of many components at any instant: their error against the sum itself, and the spans they are sampled for."""

import numpy as np
import pytest

from vsb.engine.waves.sampling import (
    INTERPOLATED,
    WIDTH,
    Sampler,
    kernel_transform,
    relative_error,
    sampled,
    signals,
    signals_along,
)
from vsb.engine.waves.seas import FEW

OMEGA_MAX = 8.0


def some(count, seed=1):
    """Three signals of as many components as a sea has, of one spacing, and random phasors."""
    rng = np.random.default_rng(seed)
    omega = OMEGA_MAX * (np.arange(count) + 0.5) / count
    return signals(omega, rng.normal(size=(count, 3)) + 1j * rng.normal(size=(count, 3)))


def summed(source, time):
    """The sums themselves."""
    return np.real(np.exp(-1j * np.outer(time, source.omega)) @ source.phasors)


@pytest.mark.parametrize(("count", "begin"), [(FEW + 1, 0.0), (1500, 0.0), (1500, 10_000.0)])
def test_error_is_within_its_bound_at_any_instant(count, begin):
    """Also late in a long run, where the phases themselves are round-off of omega t."""
    source, time = some(count), begin + np.random.default_rng(2).uniform(0.0, 100.0, 200)
    found = signals_along(sampled(source, begin, begin + 100.0), time)
    bound = relative_error(OMEGA_MAX, begin + 100.0) * np.abs(source.phasors).sum(axis=0)
    assert (np.abs(found - summed(source, time)) < bound).all()


def test_bound_holds_the_aliases_of_every_frequency():
    """The first two on either side, relative to what is wanted."""
    xi = np.linspace(0.0, np.pi / 2, 200)
    aliases = sum(np.abs(kernel_transform(xi + 2 * np.pi * m)) for m in (-2, -1, 1, 2))
    assert (aliases / kernel_transform(xi)).max() < INTERPOLATED


def test_components_are_summed_beyond_the_samples():
    source = some(FEW + 1)
    held = sampled(source, 0.0, 10.0)
    time = held.begin + held.spacing * np.array([-50.0, len(held.samples) + 50.0])
    np.testing.assert_allclose(signals_along(held, time), summed(source, time), atol=1e-11)


def test_samples_of_a_part_serve_the_next_parts():
    """A long run is followed in parts: samples are as many as components, so that few parts need new ones."""
    sampler, source = Sampler(some(400)), some(400)
    first = sampler.during(0.0, 5.0)
    reach = (len(first.samples) - 2 * WIDTH) * first.spacing
    assert reach > 0.9 * np.pi / 2 / OMEGA_MAX * 400
    assert sampler.during(5.0, reach) is first
    assert sampler.during(reach, 2 * reach) is not first
    time = np.array([2 * reach])
    np.testing.assert_allclose(signals_along(sampler.held, time), summed(source, time), atol=1e-10)


def test_few_components_are_never_sampled():
    assert not len(sampled(some(FEW), 0.0, 1e4).samples)
