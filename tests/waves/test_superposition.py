import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.study.study import Jonswap
from vsb.waves.seas import sea
from vsb.waves.superposition import FEW, superposed


def direct(omega, phasors, time):
    """The same sum as it stands, phases to 64 bits."""
    angle = np.outer(time.astype(np.longdouble), omega.astype(np.longdouble))
    return np.asarray(np.cos(angle) @ phasors.real + np.sin(angle) @ phasors.imag, dtype=float)


def random_phasors(count, signals, seed=0):
    rng = np.random.default_rng(seed)
    return (rng.normal(size=(count, signals)) + 1j * rng.normal(size=(count, signals))) / np.sqrt(count)


@settings(max_examples=40)
@given(st.integers(1, 3 * FEW), st.integers(1, 700), st.floats(-50.0, 50.0), st.floats(1e-3, 2.0), st.booleans())
def test_sum_equals_direct_summation(components, instants, start, dt, even):
    """Few and many components, of one spacing and not, at any instants."""
    rng = np.random.default_rng(components)
    omega = np.linspace(0.3, 9.0, components) if even else np.sort(rng.uniform(0.1, 9.0, components))
    phasors, time = random_phasors(components, 3), start + dt * np.arange(instants)
    error = np.abs(superposed(omega, phasors, time) - direct(omega, phasors, time)).max()
    assert error < 1e-14 * (100 + 9.0 * np.abs(time).max())  # of the phase: omega t is rounded


def test_one_hour_of_a_sea_loses_no_digits():
    """7565 components at 100 000 instants; a sum as it stands would need 6 GB of cosines."""
    waves = sea(Jonswap(kind="jonswap", hs=1.0, tp=6.0), 12.0, 3600.0)
    time = np.linspace(0.0, 3600.0, 100_001)
    some = np.random.default_rng(1).integers(0, len(time), 50)
    found = superposed(waves.omega, waves.amplitude[:, None], time)[some]
    assert len(waves.omega) > 7000
    assert np.abs(found - direct(waves.omega, waves.amplitude[:, None], time[some])).max() < 1e-11


def test_nearly_equal_spacing_keeps_each_frequency():
    """Off by a millionth: after an hour their phases are."""
    omega = np.linspace(0.3, 9.0, 3 * FEW)
    omega[FEW] *= 1 + 1e-6
    phasors, time = random_phasors(len(omega), 1), np.linspace(0.0, 3600.0, 7201)
    assert superposed(omega, phasors, time) == pytest.approx(direct(omega, phasors, time), abs=1e-9)


def test_no_components_make_no_signal():
    assert not superposed(np.zeros(0), np.zeros((0, 2), dtype=complex), np.linspace(0.0, 1.0, 5)).any()


def test_gap_among_equally_spaced_components():
    omega = np.delete(0.1 * np.arange(1, 100), 40)
    phasors, time = random_phasors(len(omega), 2), np.linspace(0.0, 20.0, 333)
    assert superposed(omega, phasors, time) == pytest.approx(direct(omega, phasors, time), abs=1e-12)
