"""Equivalent linearisation of quadratic drag: its laws by quadrature, the port with drag against the full buoy."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from vsb.engine.motion.drag import GAUSSIAN, REGULAR, DraggedPort, best_damper, best_pair, with_load
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto, Port
from vsb.engine.motion.tuning import best_dampers, best_pairs

DRAG = 0.4


class Buoy:
    """A few coupled motions that radiate through one channel, some of them dragged, with every matrix at hand."""

    def __init__(self, seed, coefficient=DRAG, count=30, motions=3, dragged=1):
        rng = np.random.default_rng(seed)
        self.omega = np.linspace(0.5, 3.0, count)
        mass, stiffness = 10 ** rng.uniform(-0.5, 0.5, (2, motions))
        self.push = rng.normal(size=motions) * np.exp(-0.1 * self.omega[:, None] ** 2) + 0j
        radiated = 0.3 * np.real(self.push[:, :, None] * self.push[:, None, :].conj()) * self.omega[:, None, None] ** 3
        w = self.omega[:, None, None]
        self.dynamic = -(w**2) * np.diag(mass) - 1j * w * (radiated + 0.02 * np.eye(motions)) + np.diag(stiffness)
        self.b, self.d = rng.normal(size=motions), np.eye(motions)[:dragged]
        self.flow = -1j * (self.omega * np.exp(-0.1 * self.omega**2))[:, None] / (1 + np.arange(dragged))
        rate = -1j * self.omega
        free, pushed = self.solved(self.dynamic, self.push), self.solved(self.dynamic, self.b)
        forced = np.stack([self.solved(self.dynamic, d) for d in self.d], axis=-1)
        compliance = float(self.b @ (self.b / stiffness))
        port = Port(self.omega, rate * (pushed @ self.b), rate * (free @ self.b), compliance)
        past = rate[:, None] * (free @ self.d.T) - self.flow
        across, own = rate[:, None] * (forced.transpose(0, 2, 1) @ self.b), rate[:, None, None] * (self.d @ forced)
        self.port = DraggedPort(port, across, own, past, coefficient * (1 + np.arange(dragged)))

    def solved(self, dynamic, force):
        return np.linalg.solve(dynamic, np.broadcast_to(force, self.push.shape)[..., None])[..., 0]

    def velocities(self, damping, stiffness, drag):
        """Of the port and past the water, per wave amplitude, by the whole equation of motion under a linear drag."""
        w = self.omega[:, None, None]
        held = -1j * w * ((self.d.T * drag) @ self.d + damping * np.outer(self.b, self.b))
        moved = self.solved(
            self.dynamic + held + stiffness * np.outer(self.b, self.b), self.push + (drag * self.flow) @ self.d
        )
        rate = -1j * self.omega
        return rate * (moved @ self.b), rate[:, None] * (moved @ self.d.T) - self.flow


def seas(omega):
    """A regular wave and two seas, squared amplitudes."""
    peak = np.exp(-0.5 * ((omega - 1.3) / 0.3) ** 2)
    return np.array([np.eye(len(omega))[9], 0.1 * peak, 0.03 * np.ones_like(omega)])


def test_linearisation_coefficients():
    """First harmonic of |cos| cos; for a Gaussian the mean of |u| u u over that of u u, by quadrature."""
    phase = 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    assert 2 * np.mean(np.abs(np.cos(phase)) * np.cos(phase) ** 2) == pytest.approx(REGULAR, rel=1e-6)
    u = np.linspace(-12.0, 12.0, 4097)
    weight = np.exp(-(u**2) / 2)
    assert weight @ np.abs(u) ** 3 / (weight @ u**2) == pytest.approx(GAUSSIAN, rel=1e-5)


@pytest.mark.parametrize(("seed", "dragged"), [(0, 1), (1, 3)])
def test_equivalent_damping_is_consistent_with_its_motion(seed, dragged):
    """By the full equation of motion under that very damping."""
    buoy = Buoy(seed, dragged=dragged)
    waves, dampers, springs = seas(buoy.omega), np.array([0.1, 2.0]), np.array([0.0, 0.3])
    drag, power = buoy.port.equivalent(waves, dampers, springs), buoy.port.powers(waves, dampers, springs)
    for i, (c, k) in enumerate(zip(dampers, springs, strict=True)):
        for j, (square, factor) in enumerate(zip(waves, (REGULAR * np.sqrt(2), GAUSSIAN, GAUSSIAN), strict=True)):
            velocity, past = buoy.velocities(c, k, drag[i, j])
            spread = np.sqrt(0.5 * square @ np.abs(past) ** 2)
            assert drag[i, j] == pytest.approx(buoy.port.coefficient * factor * spread, rel=1e-9)
            assert power[i, j] == pytest.approx(0.5 * c * square @ np.abs(velocity) ** 2, rel=1e-10)


@pytest.mark.parametrize(("efficiency", "dragged"), [(1.0, 1), (0.8, 2)])
def test_conversion_losses_beside_drag_match_the_time_signal(dragged, efficiency):
    """Mean over a period of e p where p = F V is absorbed, of p/e where it is given back."""
    buoy = Buoy(0, dragged=dragged)
    wave, phase = seas(buoy.omega)[:1], 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    dampers, springs = np.array([0.1, 2.0, 0.5]), np.array([0.0, 0.3, -0.2])
    found = buoy.port.powers(wave, dampers, springs, efficiency)[:, 0]
    for c, k, drag, power in zip(
        dampers, springs, buoy.port.equivalent(wave, dampers, springs)[:, 0], found, strict=True
    ):
        velocity = buoy.velocities(c, k, drag)[0][9]
        turning = velocity * np.exp(-1j * phase)
        p = np.real((c + 1j * k / buoy.omega[9]) * turning) * turning.real
        assert power == pytest.approx(np.mean(np.where(p > 0, efficiency * p, p / efficiency)), rel=1e-5)
        one = with_load(buoy.port, wave, c, k, efficiency)
        assert (one.damping, one.stiffness, one.power) == (c, k, pytest.approx(power, rel=1e-9))


def test_vanishing_drag_gives_the_optimum_without_drag():
    buoy = Buoy(0, coefficient=1e-12)
    for square in seas(buoy.omega)[:, None]:
        free = best_dampers(buoy.port.port, square)
        damper = best_damper(buoy.port, square, 0.0, 1.0)
        assert damper == pytest.approx(free.damping[0], rel=1e-3)
        one = with_load(buoy.port, square, damper, 0.0, 1.0)
        assert one.power == pytest.approx(free.power, rel=1e-6)
        pair = best_pair(buoy.port, square, one, 1.0)
        assert pair.power == pytest.approx(best_pairs(buoy.port.port, square, free).power, rel=1e-6)


def test_no_take_off_in_a_table_beats_the_optimum_beside_drag():
    buoy, efficiency = Buoy(0), 0.8
    waves, softest = seas(buoy.omega), buoy.port.port.softest_spring
    c, k = (x.ravel() for x in np.meshgrid(np.geomspace(0.02, 50, 20), np.linspace(0.98 * softest, -3 * softest, 16)))
    table, alone = buoy.port.powers(waves, c, k, efficiency), buoy.port.powers(waves, c[:20], 0 * c[:20], efficiency)
    for j, square in enumerate(waves[:, None]):
        one = with_load(buoy.port, square, best_damper(buoy.port, square, 0.0, efficiency), 0.0, efficiency)
        assert alone[:, j].max() <= one.power[0] * (1 + 1e-9)
        pair = best_pair(buoy.port, square, one, efficiency)
        assert one.power[0] <= pair.power[0]
        assert table[:, j].max() <= pair.power[0] * (1 + 1e-6)
        again = with_load(buoy.port, square, pair.damping[0], pair.stiffness[0], efficiency)
        assert pair.power == pytest.approx(again.power, rel=1e-9)  # what it takes is what that load takes
    together = best_damper(buoy.port, waves, 0.0, efficiency)
    assert alone.sum(axis=1).max() <= with_load(buoy.port, waves, together, 0.0, efficiency).power.sum() * (1 + 1e-9)


@pytest.mark.parametrize("held", [False, True])
def test_port_of_a_buoy_with_drag_matches_one_with_dampers(held):
    """All motions, or two of which the port is in none but moves with those that are dragged."""
    omega, pair, at = np.linspace(0.5, 3.0, 12), ("influenced_dof", "radiating_dof"), np.array([0.7, 1.3, 2.6])
    force = np.array([200.0 + 0j, 60.0 - 30j, -80.0 + 10j]) * omega[:, None]
    radiated = 1e-3 * omega[:, None, None] ** 3 * np.real(force[:, :, None] * force[:, None, :].conj())
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, np.diag([500.0, 30.0, 80.0]) + 5.0), "hydrostatic_stiffness": (pair, np.diag([900.0, 200.0, 50.0])),
            "added_mass": (("omega", *pair), np.full((12, 3, 3), 20.0)), "radiation_damping": (("omega", *pair), radiated),
            "excitation_force": (("omega", "wave_direction", pair[0]), force[:, None]),
        },
        {"omega": omega, "wave_direction": [0.0]} | {dim: ["Heave", "Membrane0", "Membrane2"] for dim in pair},
    )  # fmt: skip
    buoy = LinearSystem(ds, np.diag([0.0, 5.0, 7.0]), LinearPto(0.0))
    motions = np.linalg.qr(np.array([[1.0, 0.0], [0.5, 1.0], [-0.3, 2.0]]))[0] if held else np.eye(3)
    b, d, drag = np.array([1.0, 0.4, -0.2]), np.array([[0.6, 0.8, 0.0], [0.0, 0.3, 1.0]]), np.array([40.0, 90.0])
    flow = np.array([[0.5 + 0.2j, -0.3j], [0.1 - 0.4j, 0.7], [0.2, 0.3 + 0.1j]])
    found = DraggedPort.of(buoy, at, motions, b, d, flow, np.array([3.0, 7.0]))
    rate = -1j * at[:, None]
    np.testing.assert_allclose(found.past, rate * (buoy.rao(at, motions) @ d.T) - flow, rtol=1e-10)
    np.testing.assert_array_equal(found.coefficient, [3.0, 7.0])
    braked = replace(buoy, structural_damping=buoy.structural_damping + d.T @ np.diag(drag) @ d)
    calm = DraggedPort.of(buoy, at, motions, b, d, 0 * flow, np.array([3.0, 7.0]))
    for name in ("admittance", "velocity", "compliance"):
        expected = getattr(braked.port(at, motions, b), name)
        np.testing.assert_allclose(getattr(calm.beside(drag), name), expected, rtol=1e-9, err_msg=name)
    alone = calm.seen(np.zeros(1), np.zeros(1)).with_drag(drag[None], np.zeros(1, int))[0]
    np.testing.assert_allclose(alone, rate * (braked.rao(at, motions) @ d.T), rtol=1e-9)
