"""Repairs of coefficients: as little as it takes, bounded, and reported with their size."""

import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.hydro.repairs import (
    PAIR,
    repaired,
    with_causal_added_mass,
    with_passive_damping,
    with_symmetric_stiffness,
)
from vsb.errors import ConfigError

LABELS = ["Heave", "Pitch"]
OMEGA = np.arange(1, 61) * 0.1


def two_channels(omega=OMEGA, labels=LABELS):
    """Two resonances of known poles, one of each combination of two motions: passive and causal by construction."""
    damping, mass = np.zeros((2, len(omega), 2, 2))
    for pole, along in ((-0.5 + 1.0j, np.array([1.0, 0.5])), (-0.8 + 2.0j, np.array([-0.3, 1.0]))):
        s = 1j * omega
        k = s / ((s - pole) * (s - pole.conjugate()))  # s/(s^2 + 2 a s + b), positive real
        damping += k.real[:, None, None] * np.outer(along, along)
        mass += (k.imag / omega)[:, None, None] * np.outer(along, along)
    data = {"added_mass": (("omega", *PAIR), mass + 3 * np.eye(2)), "radiation_damping": (("omega", *PAIR), damping)}
    coords = {"omega": omega, **dict.fromkeys(PAIR, labels)}
    return xr.Dataset(data, coords, {"water_density": 1.0, "displaced_volume": 1.0, "history": "read"})


def noisy(ds, drawn):
    """Damping with `drawn` of one motion's largest taken away along the other diagonal, where waves are long."""
    b = ds.radiation_damping.values.copy()
    b[:5] -= drawn * b.max() * np.eye(2)
    return ds.assign(radiation_damping=(("omega", *PAIR), b))


def test_passive_damping_is_not_changed():
    ds = two_channels()
    mended, checks = repaired(ds, ["positive_damping"])
    assert np.array_equal(mended.radiation_damping.values, ds.radiation_damping.values)
    assert checks[0].value == 0.0
    assert repaired(ds, ()) == (ds, [])


def test_repaired_damping_is_positive_between_frequencies():
    ds = noisy(two_channels(), 0.05)
    assert np.linalg.eigvalsh(ds.radiation_damping.values).min() < 0
    mended, checks = repaired(ds, ["positive_damping"])
    fine = np.linspace(OMEGA[0], OMEGA[-1], 5000)
    assert np.linalg.eigvalsh(CubicSpline(OMEGA, mended.radiation_damping.values)(fine)).min() >= 0
    assert np.array_equal(mended.radiation_damping.values[9:], ds.radiation_damping.values[9:])
    assert np.array_equal(mended.added_mass.values, ds.added_mass.values)
    changed = (mended.radiation_damping.values != ds.radiation_damping.values).any(axis=(1, 2)).sum()
    note = f"read; damping made positive definite at {changed} of {len(OMEGA)} frequencies"
    assert mended.attrs["history"].startswith(note)
    assert 5 <= changed <= 9
    (check,) = checks
    assert (check.name, check.verdict, check.limit) == ("repaired positive_damping", "doubt", 0.2)
    assert 0.04 < check.value < 0.08
    assert "rad/s" in check.explanation


def test_repaired_added_mass_follows_from_damping():
    ds = two_channels(np.arange(1, 201) * 0.1)
    rng = np.random.default_rng(1)
    shaken = ds.added_mass.values + 0.02 * (n := rng.normal(size=ds.added_mass.shape)) + 0.02 * n.swapaxes(1, 2)
    mended, (check,) = repaired(ds.assign(added_mass=(("omega", *PAIR), shaken)), ["kramers_kronig"])
    error, before = (np.abs(x - ds.added_mass.values).max() for x in (mended.added_mass.values, shaken))
    assert error < 0.15 * before
    spectrum = DampingSpectrum(ds.omega.values, ds.radiation_damping.values)
    change = spectrum.added_mass_difference(ds.omega.values)
    assert mended.added_mass.values - change == pytest.approx(np.array([mended.added_mass_inf.values] * 200))
    assert check.name == "repaired kramers_kronig"
    assert np.array_equal(mended.radiation_damping.values, ds.radiation_damping.values)


def test_damping_is_repaired_before_added_mass_follows_from_it():
    both, checks = repaired(noisy(two_channels(), 0.05), ["kramers_kronig", "positive_damping"])
    assert [check.name for check in checks] == ["repaired positive_damping", "repaired kramers_kronig"]
    first = with_passive_damping(noisy(two_channels(), 0.05))
    assert np.array_equal(both.added_mass.values, with_causal_added_mass(first).added_mass.values)


def test_more_than_noise_is_refused():
    expected = (
        r"hydro.repair: positive_damping would change damping, .* by 0\.\d+ \(most at .* rad/s\), needs at most 0.2"
    )
    with pytest.raises(ConfigError, match=expected):
        repaired(noisy(two_channels(), 0.5), ["positive_damping"])
    ds = two_channels()
    with pytest.raises(
        ConfigError, match=r"kramers_kronig would change added mass.* needs at most 0.1, the size of noise"
    ):
        repaired(ds.assign(added_mass=ds.added_mass + 4 * np.sin(ds.omega)), ["kramers_kronig"])
    with pytest.raises(ConfigError, match=r"hydro.repair: kramers_kronig needs 10 frequencies, received 5"):
        repaired(ds.isel(omega=slice(5)), ["kramers_kronig"])


def test_stiffness_becomes_symmetric_by_the_rows_of_rigid_motions():
    """WAMIT's barge: by surge two bending modes are pushed, which push nothing along."""
    labels = ["Surge", "Heave", "Mode7", "Mode8"]
    c = np.array([[0, 0, 0, 0], [0, 8, 1.0, 0], [-100, 3.0, 2, 0.1], [0, 0, 0.3, 2.0]])
    ds = xr.Dataset({"hydrostatic_stiffness": (PAIR, c)}, dict.fromkeys(PAIR, labels), {"history": "read"})
    mended, (check,) = with_symmetric_stiffness(ds)
    expected = [[0, 0, 0, 0], [0, 8, 1.0, 0], [0, 1.0, 2, 0.2], [0, 0, 0.2, 2.0]]
    assert mended.hydrostatic_stiffness.values == pytest.approx(np.array(expected))
    assert (check.name, check.verdict) == ("hydrostatic_symmetry", "doubt")
    assert "Surge and Mode7; made so" in check.explanation
    assert mended.attrs["history"] == "read; hydrostatic stiffness made symmetric"
    again, nothing = with_symmetric_stiffness(mended)
    assert nothing == []
    assert again.attrs["history"] == mended.attrs["history"]
