"""Radiation channels: damping between frequencies from the excitation of one channel."""

import numpy as np
import pytest
import xarray as xr

from vsb.motion.channel import Channel, channelled, one_channel

OMEGA = np.linspace(0.2, 6.0, 60)


def force(omega):
    """Excitation of two motions of one order and one of another."""
    x = np.array([np.exp(-0.2 * omega), 0.3 * omega * np.exp(-0.4 * omega), omega**2 * np.exp(-omega)]).T
    return x * np.exp(1j * np.outer(omega, [0.1, 0.1, 0.4]))


@pytest.fixture
def database():
    damping = np.zeros((60, 3, 3))
    for group, h in (([0, 1], 2.0), ([2], 1.0)):
        pick = np.array(group)
        damping[:, pick[:, None], pick] = h * OMEGA[:, None, None] ** 3 * one_channel(force(OMEGA)[:, pick])
    dims = ("influenced_dof", "radiating_dof")
    return xr.Dataset(
        {
            "radiation_damping": (("omega", *dims), damping),
            "excitation_force": (("omega", "wave_direction", dims[0]), force(OMEGA)[:, None]),
        },
        {"omega": OMEGA},
    )


@pytest.mark.parametrize(("group", "factor"), [((0, 1), 2.0), ((2,), 1.0)])
def test_damping_between_frequencies(database, group, factor):
    channel, omega = Channel.of(database, np.array(group)), np.array([0.25, 1.234, 5.5])
    assert channel.power == 3
    found, pick = channel.damping(omega, force(omega)), np.array(group)
    expected = np.zeros_like(found)
    expected[:, pick[:, None], pick] = factor * omega[:, None, None] ** 3 * one_channel(force(omega)[:, pick])
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


def test_damping_where_the_excitation_vanishes(database):
    """The force changes sign at 3 rad/s, where the solver's damping is dominated by its error."""
    database.excitation_force[:, 0, 2] = 3.0 - OMEGA
    damping = OMEGA**3 * (3.0 - OMEGA) ** 2
    near = np.abs(OMEGA - 3.0) < 0.06
    assert near.any()
    beside = np.abs(OMEGA - 3.0) < 0.06 + 2 * (OMEGA[1] - OMEGA[0])  # where its error is of the damping's own size
    database.radiation_damping[:, 2, 2] = np.where(near, -1e-3, np.where(beside, 1.5 * damping, damping))
    channel, omega = Channel.of(database, np.array([2])), np.array([2.9, 2.98, 3.02, 3.1])
    force = np.zeros((4, 3), dtype=complex)
    force[:, 2] = 3.0 - omega
    np.testing.assert_allclose(channel.damping(omega, force)[:, 2, 2], omega**3 * (3.0 - omega) ** 2, rtol=1e-10)


def test_channel_uses_the_direction_that_excites_it(database):
    """Like sway, excited by waves along y and not by those along x."""
    ahead, aside = database.excitation_force.copy(), database.excitation_force.copy()
    ahead[:, 0, 2] = 0.0
    aside[:, 0, :2] *= 0.5
    both = database.drop_vars("excitation_force").assign(
        excitation_force=xr.concat([ahead, aside], "wave_direction").transpose("omega", ...)
    )
    omega = np.array([0.25, 1.234, 5.5])
    for heading, group, factor in ((1, [2], 1.0), (0, [0, 1], 2.0), (1, [0, 1], 8.0)):
        channel, pick = Channel.of(both, np.array(group), heading), np.array(group)
        found = channel.damping(omega, force(omega))[:, pick[:, None], pick]
        expected = factor * omega[:, None, None] ** 3 * one_channel(force(omega)[:, pick])
        np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_projection_on_the_channel_keeps_the_trace(database):
    """The trace: of a solver's damping below zero less than nothing."""
    damping, excitation = database.radiation_damping.values.copy(), force(database.omega.values)
    damping[1::2] *= -0.7
    damping += 0.1 * np.abs(damping).max() * np.arange(9.0).reshape(3, 3) * (1 - np.eye(3))  # beside the channel
    found = channelled(damping, excitation)
    np.testing.assert_allclose(np.einsum("wii->w", found), np.einsum("wii->w", damping), rtol=1e-12)
    assert np.all(np.einsum("wii->w", found)[1::2] < 0)
    scale = np.einsum("wii->w", damping) / np.sum(np.abs(excitation) ** 2, axis=1)
    np.testing.assert_allclose(found, scale[:, None, None] * one_channel(excitation), rtol=1e-12)
