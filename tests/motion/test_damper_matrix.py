"""Several ports at once: the optimal damper matrix, its slope, and what no matrix exceeds."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from motion.test_port import solved

from vsb.engine.hydro.database import Coefficients
from vsb.engine.motion.damper_matrix import Ports, best_matrix, matrix_within_force
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.port import LinearPto, Port, port_direction
from vsb.engine.motion.take_off import DistributedPort, SeveralPorts
from vsb.engine.motion.tuning import damper_within_force
from vsb.models.rest import design_motions, reference_shell, study_basis

ALL = np.ones(1)


def one_channel(rng, count, definite):
    """Ports of one radiation channel at one frequency, Z = x x^T - i X, with a reactance definite or not."""
    x, reactance = rng.normal(size=count), rng.normal(size=(count, count))
    reactance = (
        reactance @ reactance.T
        if definite
        else np.diag(np.linspace(-1.0, 1.5, count)) + 0.1 * (reactance + reactance.T)
    )
    admittance = np.linalg.inv(np.outer(x, x) - 1j * reactance)
    return Ports(ALL, admittance[None], (admittance @ x * (1 + 0.3j))[None]), reactance


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("definite", [True, False])
def test_matrix_reaches_the_matched_power_where_the_reactance_is_indefinite(count, definite):
    ports, reactance = one_channel(np.random.default_rng(7 * count), count, definite)
    assert (np.linalg.eigvalsh(reactance).min() > 0) == definite
    uniform, diagonal, full = (best_matrix(ports, ALL, kind).power for kind in ("uniform", "diagonal", "full"))
    matched, tried = ports.matched_power[0], np.geomspace(1e-2, 1e2, 2001)[:, None, None] * np.eye(count)
    assert uniform == pytest.approx(max(ports.power(damper)[0] for damper in tried), rel=1e-4)
    assert uniform <= diagonal * (1 + 1e-9)
    assert diagonal <= full * (1 + 1e-9)
    if definite:
        assert full < 0.99 * matched
    else:
        assert full == pytest.approx(matched, rel=1e-5)


def test_a_port_that_cannot_move_has_no_damper():
    """As a port of strain in a rigid design; the other has the damper of one port, |Z| in a regular wave."""
    ports = Ports(np.ones(1), np.zeros((1, 2, 2), dtype=complex), np.zeros((1, 2), dtype=complex))
    ports.admittance[0, 0, 0], ports.velocity[0, 0] = 1 / (3 + 4j), 2.0
    for kind in ("full", "diagonal"):
        found = best_matrix(ports, np.ones(1), kind)
        np.testing.assert_allclose(found.damping, [[5.0, 0.0], [0.0, 0.0]], rtol=1e-5)
        assert found.power == pytest.approx(3.125, rel=1e-9)


def test_slope_of_the_power_is_that_of_differences():
    rng = np.random.default_rng(3)
    x, reactance = rng.normal(size=(5, 3)), rng.normal(size=(5, 3, 3))
    z = x[:, :, None] * x[:, None, :] + 0.02 * np.eye(3) - 1j * (reactance + reactance.swapaxes(1, 2))
    ports, squares = Ports(np.linspace(1, 2, 5), np.linalg.inv(z), rng.normal(size=(5, 3)) + 0j), rng.random(5)
    root, change = rng.normal(size=(2, 3, 3))
    damping, change = root @ root.T, change + change.T
    power, slope = ports.power_and_slope(damping, squares)
    assert power == pytest.approx(squares @ ports.power(damping), rel=1e-12)
    differences = squares @ (ports.power(damping + 1e-5 * change) - ports.power(damping - 1e-5 * change)) / 2e-5
    assert np.sum(slope * change) == pytest.approx(differences, rel=1e-7)


def long_waves(stiffness, omega=1.0):
    """A body whose inertia and radiation have vanished: raising the water is lowering the body, X = K e_heave."""
    count = len(stiffness)
    none = np.zeros((1, count, count))
    water = Coefficients(none, none, stiffness[None, 0].astype(complex))
    return LinearEquation(np.array([omega]), water, none[0], none[0], stiffness)


@pytest.mark.parametrize("seed", range(4))
def test_no_damper_matrix_exceeds_the_waterplane_in_long_waves(seed):
    """P <= omega a^2 K_hh/4 for any C >= 0 anywhere, reached by C = K/omega; of heave alone K_eff = 1/(K^-1)_hh."""
    rng, omega, count = np.random.default_rng(seed), 0.7, 5
    root = rng.normal(size=(count, count))
    stiffness = root @ root.T + 0.1 * np.eye(count)
    equation, free = long_waves(stiffness, omega), np.eye(count)
    everywhere, bound = equation.ports(free, free), omega * stiffness[0, 0] / 4
    for _ in range(50):
        part = rng.normal(size=(count, rng.integers(1, count + 1))) * np.exp(2 * rng.normal())
        assert everywhere.power(part @ part.T)[0] <= bound * (1 + 1e-12)
    assert everywhere.power(stiffness / omega)[0] == pytest.approx(bound, rel=1e-12)
    softened = 1 / np.linalg.inv(stiffness)[0, 0]
    heave = equation.ports(free, free[:, :1])
    dampers = softened / omega * np.geomspace(0.1, 10.0, 21)[:, None, None]
    powers = [heave.power(damper)[0] for damper in dampers]
    assert max(powers) == powers[10] == pytest.approx(omega * softened / 4, rel=1e-12)
    # the shell alone: with heave held at most the shell's share of the stiffness, with the frame free nothing
    held = equation.ports(free[:, 1:], free)
    for _ in range(50):
        part = rng.normal(size=(count, rng.integers(1, count + 1))) * np.exp(2 * rng.normal())
        assert held.power(part @ part.T)[0] <= omega * (stiffness[0, 0] - softened) / 4 * (1 + 1e-12)
    shell = stiffness.copy()
    shell[0] = shell[:, 0] = 0.0
    assert held.power(shell / omega)[0] == pytest.approx(omega * (stiffness[0, 0] - softened) / 4, rel=1e-12)
    assert everywhere.power(shell)[0] == pytest.approx(0.0, abs=1e-20)


def test_seed_with_heave_and_area_reaches_the_limit_of_one_channel(seed):
    """Below 3.1 s, where the two ports' reactance is indefinite; two separate dampers absorb far less."""
    changes = {"modes": {"basis": "full", "degree": 6}, "device": {"damping": {"alpha": 0.0, "beta": 0.0}}}
    study = varied(seed, designs={"VSWEC": {}}, **changes)
    buoy, basis = solved(study), study_basis(study)
    choice = SeveralPorts(ports={"heave": "heave", "shell": {"strain": "area"}})
    directions = port_direction(choice, reference_shell(study).shape)
    omega = 2 * np.pi / np.array([3.0, 2.5, 2.0])
    ports = buoy.equation(omega).ports(design_motions(study, basis, "VSWEC"), directions)
    for i in range(len(omega)):
        one = ports.at(np.array([i]))
        values = np.linalg.eigvalsh(one.impedance[0].imag * np.outer(one.size, one.size) ** 0.5)
        assert values[0] < 0 < values[1]
        full, apart = (best_matrix(one, ALL, kind).power / one.matched_power[0] for kind in ("full", "diagonal"))
        assert full == pytest.approx(1.0, abs=1e-4)
        assert apart == pytest.approx((1.0, 0.476, 0.157)[i], abs=1e-2)
    alone, beside = (
        LinearPto(5e3),
        LinearPto(np.diag([5e3, 0.0]), port=directions),
    )  # a damper of heave, and none of area
    moved = np.random.default_rng(2).normal(size=(3, len(directions))) + 0j
    powers = [replace(buoy, pto=pto).absorbed_power(omega, moved) for pto in (alone, beside)]
    assert powers[1] == pytest.approx(powers[0], rel=1e-12)


def test_damper_spread_over_the_membrane_has_its_stiffness(seed):
    """L L^T is the elastic stiffness of the membrane basis about the sphere, but for the little its shapes bend."""
    study = varied(seed, designs={"VSWEC": {}})
    spread = port_direction(DistributedPort(distributed="membrane"), reference_shell(study).shape)
    stiffness = study_basis(study).stiffness
    np.testing.assert_allclose(spread @ spread.T, stiffness, rtol=2e-5, atol=1e-9 * stiffness.max())


def test_matrix_within_a_force_is_the_best_of_those_that_keep_it():
    """Of one port it is the damper within the force; a price's slope is that of power less price times mean square."""
    rng = np.random.default_rng(8)
    omega = np.linspace(0.5, 3.0, 120)
    at = omega[:, None, None]
    loss, mass, stiffness = (
        np.array(rows) for rows in ([[5.0, 1.0], [1.0, 3.0]], [[4.0, 0.5], [0.5, 2.0]], [[9.0, 1.0], [1.0, 8.0]])
    )
    y = np.linalg.inv(loss - 1j * at * mass + 1j * stiffness / at)
    ports, squares = Ports(omega, y, y @ np.array([3.0, 1.0])), 0.02 * np.exp(-(((omega - 1.5) / 0.4) ** 2))
    best = best_matrix(ports, squares)
    limit = 0.3 * float(np.linalg.norm(ports.force_rms(best.damping, squares)))
    found = matrix_within_force(ports, squares, limit)
    assert np.linalg.norm(ports.force_rms(found.damping, squares)) == pytest.approx(limit, rel=1e-5)
    for _ in range(20):
        factor, sizes = rng.standard_normal((2, 2)), np.geomspace(1e-2, 1e2, 200)
        tried = sizes[:, None, None] * (found.damping + rng.uniform(0.0, 2.0) * (factor @ factor.T))
        kept = [one for one in tried if np.linalg.norm(ports.force_rms(one, squares)) <= limit]
        assert float(squares @ ports.power(kept[-1])) <= found.power * (1 + 1e-6)
    assert matrix_within_force(ports, squares, 10 * limit).power == pytest.approx(best.power)
    alone, single = (
        Port(omega, y[:, 0, 0], ports.velocity[:, 0], 1.0),
        Ports(omega, y[:, :1, :1], ports.velocity[:, :1]),
    )
    damper = damper_within_force(alone, squares[None], limit)
    assert matrix_within_force(single, squares, limit).power == pytest.approx(float(damper.power[0]), rel=1e-5)
    step, matrix, price = 1e-6, np.array([[2.0, 0.3], [0.3, 1.0]]), 0.07
    change = np.array([[1.0, 0.5], [0.5, -0.4]])
    ends = [ports.power_and_slope(matrix + s * step * change, squares, price)[0] for s in (1, -1)]
    slope = ports.power_and_slope(matrix, squares, price)[1]
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(float((slope * change).sum()), rel=1e-6)
