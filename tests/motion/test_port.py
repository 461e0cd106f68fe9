"""Ports: Thevenin's equivalent of a buoy at its take-off, its limits of power, directions of all kinds of ports."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st
from shell.test_orders import DEVICE, at_order, deformed

from vsb.engine.hydro import database
from vsb.engine.hydro.spectral.solver import converged_on_grid
from vsb.engine.motion.linear import LinearSystem, with_open_chamber
from vsb.engine.motion.port import LinearPto, Port, channels_reached, combination, line_shares, port_direction
from vsb.engine.motion.take_off import BetweenPort, LinePort, ShellPort, StrainPort
from vsb.engine.shell.deformed import DeformedShell, enclosed
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.water import power_limit
from vsb.errors import ConfigError, DatabaseError
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.pipeline.graph import StudyPlan
from vsb.stages.water import spectral_problem


def solved(study):
    """The linear buoy of a study as a run makes it: few frequencies solved, the rest of the grid interpolated."""
    (block,), basis = StudyPlan(study).sweep_blocks, study_basis(study)
    found = converged_on_grid(spectral_problem(block), list(block.omega), block.tolerance, block.interpolation)
    raw = database.with_symmetrized(database.in_modes(database.with_excitation(found), basis))
    return LinearSystem(database.with_structure(raw, reference_shell(study)), basis.damping, LinearPto(0.0))


def direction(study, choice):
    basis = study_basis(study)
    return port_direction(choice, DeformedShell(basis, study.centre_height))


def port(buoy, study, design, omega, choice="heave"):
    motions = design_motions(study, study_basis(study), design)
    return buoy.port(omega, motions, direction(study, choice))


@pytest.fixture(scope="module")
def lossless(seed):
    """The published buoy without structural damping."""
    study = varied(seed, device={"damping": {"alpha": 0.0, "beta": 0.0}})
    return study, solved(study)


@pytest.mark.parametrize(
    "choice",
    [
        "heave", ShellPort(colatitude=60), "volume", BetweenPort(between=(0, 180)), StrainPort(strain="area"),
        StrainPort(strain="hoop", belt=(60, 120)),
    ],
    ids=str,
)  # fmt: skip
def test_matched_power_is_the_radiation_limit_of_one_channel(lossless, choice):
    """lambda/(2 pi) of crest for every port and shell; a rigid buoy does not move a port within the shell."""
    (study, buoy), omega = lossless, np.arange(0.2, 4.5, 0.0137)
    limit = np.array([power_limit(w, np.inf, 1025.0, 9.81) for w in omega])
    for design in study.designs:
        found = port(buoy, study, design, omega, choice)
        inner = design == "FSB" and choice not in ("heave", ShellPort(colatitude=60))
        assert found.moves is not inner
        assert found.matched_power == pytest.approx(0.0 * limit if inner else limit, rel=1e-4), design


def test_power_of_the_port_solves_the_equation_of_motion(seed, lossless):
    """The equivalent port under a damper against the response with the damper in its matrix."""
    omega, basis = np.linspace(0.3, 11.0, 57), study_basis(seed)
    damped = LinearSystem(lossless[1].database, basis.damping, LinearPto(8000.0))
    for design in seed.designs:
        whole = damped.absorbed_power(omega, damped.rao(omega, design_motions(seed, basis, design)))
        assert port(damped, seed, design, omega).power(8000.0) == pytest.approx(whole, rel=1e-9)


def test_port_directions_match_finite_differences(seed):
    """Distance of two points, height of one, enclosed volume."""
    basis = study_basis(seed)
    rest = 0.02 * np.arange(len(basis.labels)) / len(basis.labels)
    shape = DeformedShell(basis, 0.3, rest)

    def moved(step, quantity):
        return [
            quantity(DeformedShell(basis, 0.3, rest + step * e)) - quantity(DeformedShell(basis, 0.3, rest - step * e))
            for e in np.eye(len(rest))
        ]

    def apart(shell):
        m = shell.meridian(np.deg2rad([30.0, 140.0]))
        return np.hypot(np.diff(m.x)[0], np.diff(m.z)[0])

    def height(shell):
        return shell.meridian(np.deg2rad([70.0])).z[0]

    def volume(shell):
        return enclosed(basis, shell.modal_amplitude[None])[0][0]

    def area(shell):
        return enclosed(basis, shell.modal_amplitude[None])[1][0]

    belt = np.linspace(np.pi / 3, 2 * np.pi / 3, 8001)
    still = DeformedShell(basis, 0.3, rest).meridian(belt)
    ring = still.x * np.hypot(still.dx, still.dz)  # its area per angle

    def hoop(shell):
        return np.trapezoid(ring * shell.meridian(belt).x / still.x, belt) / np.trapezoid(ring, belt)

    def meridional(shell):
        m = shell.meridian(belt)
        return np.trapezoid(ring * np.hypot(m.dx, m.dz) / np.hypot(still.dx, still.dz), belt) / np.trapezoid(ring, belt)

    for choice, quantity in (
        (BetweenPort(between=(30, 140)), apart), (ShellPort(colatitude=70), height), ("volume", volume),
        (StrainPort(strain="area"), area), (StrainPort(strain="hoop", belt=(60, 120)), hoop),
        (StrainPort(strain="meridional", belt=(60, 120)), meridional),
    ):  # fmt: skip
        found = port_direction(choice, shape)
        assert found == pytest.approx(np.array(moved(1e-5, quantity)) / 2e-5, rel=1e-6, abs=1e-7 * np.abs(found).max())


@pytest.mark.parametrize("order", [1, 2])
def test_distance_of_two_points_of_the_meridian_in_shapes_of_an_order(order):
    """By differences of the deformed shell; rigid motions do not lengthen it."""
    basis = at_order(order)
    ends = np.deg2rad([30.0, 140.0])

    def apart(q):
        return np.linalg.norm(np.diff(deformed(basis, q, ends, 0.0)[0]))

    steps = 1e-6 * np.eye(len(basis.labels))
    shape = DeformedShell(mode_basis(DEVICE, "full", 4), 0.15)
    found = port_direction(BetweenPort(between=(30, 140)), shape, [basis])[len(shape.basis.labels) :]
    assert found == pytest.approx(np.array([apart(h) - apart(-h) for h in steps]) / 2e-6, abs=1e-8)
    assert np.abs(found).max() > 0.1


def passive(draw_from):
    """A passive port of three springs, masses and dampers in a row, at ten frequencies."""
    mass, damping, stiffness, free = draw_from
    omega = np.linspace(0.5, 3.0, 10)
    y = sum(1 / (-1j * omega * m + b + 1j * k / omega) for m, b, k in zip(mass, damping, stiffness, strict=True))
    return Port(omega, y, np.full(10, complex(*free)), sum(1 / k for k in stiffness))


triples = st.tuples(*[st.floats(0.1, 10.0)] * 3)
ports = st.tuples(triples, triples, triples, st.tuples(st.floats(-2, 2), st.floats(0.1, 2))).map(passive)


@given(ports, st.floats(1e-3, 1e3), st.floats(-0.5, 5.0))
def test_no_damper_beats_the_optimal_one_and_no_load_the_matched(found, damping, spring):
    assert np.all(found.power(damping) <= found.best_power * (1 + 1e-12))
    assert np.all(found.power(damping, spring) <= found.matched_power * (1 + 1e-12))
    best = np.diagonal(found.power(found.best_damping))
    assert best == pytest.approx(found.best_power, rel=1e-12)
    assert best == pytest.approx(found.matched_power * 2 / (1 + np.sqrt(1 + found.reactance_ratio**2)), rel=1e-12)


@given(ports)
def test_matched_spring_and_damper_absorb_the_matched_power(found):
    z = found.impedance
    for i, w in enumerate(found.omega):
        assert found.power(z.real[i], -w * z.imag[i])[i] == pytest.approx(found.matched_power[i], rel=1e-9)
    velocity = found.velocity - found.admittance * found.matched_force
    taken = 0.5 * np.real(found.matched_force * velocity.conj())
    assert taken == pytest.approx(found.matched_power, rel=1e-12)


@given(ports, st.floats(-0.02, 5.0), st.floats(0.01, 10.0))
def test_parallel_spring_is_part_of_the_load(found, spring, damping):
    beside = found.beside(spring)
    assert beside.power(damping) == pytest.approx(found.power(damping, spring), rel=1e-9)
    assert beside.matched_power == pytest.approx(found.matched_power, rel=1e-9)
    assert beside.softest_spring == pytest.approx(found.softest_spring - spring, rel=1e-9)


@given(ports, st.floats(0.0, 5.0))
def test_series_compliance_leaves_the_matched_power(found, compliance):
    behind = found.behind(compliance)
    assert behind.matched_power == pytest.approx(found.matched_power, rel=1e-12)
    assert behind.impedance == pytest.approx(1 / (found.admittance - 1j * found.omega * compliance), rel=1e-12)
    assert behind.compliance == pytest.approx(found.compliance + compliance)


@pytest.fixture(scope="module")
def chambered(seed):
    """The seed with trapped gas and a take-off of its volume, and its linear buoy before the chamber is opened."""
    gas = {"gas": {"adiabatic_index": 1.4}}
    study = varied(seed, device=gas, modes={"degree": 3}, hydro={"omega_max": 6.0}, pto={"port": "volume"})
    return study, solved(study)


def test_port_behind_a_chamber_solves_the_equation_of_motion(chambered):
    study, closed = chambered
    omega, b = np.linspace(0.4, 5.5, 9), direction(study, "volume")
    opened = with_open_chamber(closed, b)
    seen = port(opened, study, "VSWEC", omega, "volume")
    for pto in (LinearPto(400.0, 0.0, b), LinearPto(400.0, -50.0, b)):
        loaded = replace(opened, pto=pto)
        power = loaded.absorbed_power(omega, loaded.rao(omega, np.eye(5)))
        assert seen.power(pto.damping, pto.stiffness) == pytest.approx(power, rel=1e-9)
    without = port(replace(opened, chamber=0.0), study, "VSWEC", omega, "volume")
    assert seen.matched_power == pytest.approx(without.matched_power, rel=1e-9)
    assert seen.compliance == pytest.approx(without.compliance + opened.chamber)
    assert not port(opened, study, "FSB", omega, "volume").moves


def test_active_port_is_refused():
    with pytest.raises(DatabaseError, match=r"port: not passive at 2 rad/s, received Re Y = -0.1 .* lower hydro"):
        Port(np.array([1.0, 2.0]), np.array([0.1 + 0j, -0.1]), np.ones(2, dtype=complex), 1.0)


@pytest.mark.parametrize(("line", "height"), [(((-7.0, -12.0), (0.8, -0.4)), 0.6), (((2.0, -9.0), (-1.1, 0.3)), -0.3)])
def test_mooring_line_port_matches_differences_of_its_length(line, height):
    """Surge and heave shift, pitch rotates the attachment about the centre of the sphere."""
    (to, at) = line

    def length(surge, heave, pitch):
        x = surge + at[0] * np.cos(pitch) + at[1] * np.sin(pitch)
        z = height + heave - at[0] * np.sin(pitch) + at[1] * np.cos(pitch)
        return np.hypot(x - to[0], z - to[1])

    found = line_shares(LinePort(line_to=to, line_from=at), height)
    for name, way in zip(("Surge", "Heave", "Pitch"), 1e-5 * np.eye(3), strict=True):
        assert found[name] == pytest.approx((length(*way) - length(*-way)) / 2e-5, abs=1e-9)


def test_combined_port_and_its_errors():
    labels = ["Surge", "Heave", "Pitch"]
    assert combination(labels, {"Pitch": -2, "Surge": 0.5}).tolist() == [0.5, 0.0, -2.0]
    with pytest.raises(ConfigError, match=r"^pto.port: received Lid, Roof; needs some of Surge, Heave, Pitch\.$"):
        combination(labels, {"Roof": 1.0, "Heave": 1.0, "Lid": 2.0})
    for shares in ({"Heave": 0.0, "Pitch": 0.0}, {"Heave": np.inf}, {"Heave": 1.0, "Pitch": np.nan}, {}):
        with pytest.raises(ConfigError, match=r"^pto.port: received \{.*\}; needs finite shares, not all zero\.$"):
            combination(labels, shares)


@pytest.mark.parametrize(("way", "against"), [("vertical", "sea_bed"), ("radial", "frame")])
def test_port_of_a_ring_against_sea_bed_and_frame(seed, way, against):
    """By differences of the position of its points."""
    basis, at = study_basis(seed), np.deg2rad([50.0])
    rest = 0.02 * np.arange(len(basis.labels)) / len(basis.labels)

    def place(amplitude):
        m = DeformedShell(basis, 0.3, amplitude).meridian(at)
        return m.z[0] if way == "vertical" else m.x[0] * np.sin(at[0]) + m.z[0] * np.cos(at[0])

    expected = np.array([place(rest + 1e-5 * e) - place(rest - 1e-5 * e) for e in np.eye(len(rest))]) / 2e-5
    assert expected[0] == pytest.approx(1.0 if way == "vertical" else np.cos(at[0]), abs=1e-9)
    expected[0] *= against == "sea_bed"
    found = port_direction(ShellPort(colatitude=50, direction=way, against=against), DeformedShell(basis, 0.3, rest))
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_round_off_is_no_source_of_energy_where_waves_hardly_move_the_port():
    """Its matched power is then no more than elsewhere; where waves move the port, none can be told."""
    omega, admittance = np.array([1.0, 2.0]), np.array([1e-6 + 2e-6j, -3e-14 + 2e-6j])
    port = Port(omega, admittance, np.array([0.5, 1e-4 + 0j]), 1.0)
    assert 0 < port.matched_power[1] < port.matched_power[0]
    with pytest.raises(DatabaseError, match=r"port: not passive at 2 rad/s, received Re Y = -3e-14"):
        Port(omega, admittance, np.array([0.5, 0.5 + 0j]), 1.0)


@given(st.floats(0.01, 100.0), st.floats(-0.9, 20.0), st.floats(0.01, 1.0))
def test_series_compliance(damping, stiffness, compliance):
    """1/Z of the series is 1/(c + i k/omega) - i omega C, also for the relaxing damper beside its spring."""
    omega = np.array([0.3, 1.0, 4.0])
    series = 1 / (1 / (damping + 1j * stiffness / omega) - 1j * omega * compliance)
    pto = LinearPto(damping, stiffness)
    felt = pto.behind(compliance, omega)
    size = np.abs(series).max()
    assert felt.damping + 1j * felt.stiffness / omega == pytest.approx(series, rel=1e-9, abs=1e-9 * size)
    beside, own = pto.relaxed(compliance)
    relaxing = 1j * beside.stiffness / omega + 1 / (1 / beside.damping - 1j * omega * own)
    assert relaxing == pytest.approx(series, rel=1e-9, abs=1e-9 * size)


def test_spring_that_makes_the_air_chamber_unstable_is_refused():
    for stiffness in (-2.0, -3.5):
        words = rf"^pto.stiffness: received {stiffness:g}, which makes the air chamber statically unstable; needs more"
        with pytest.raises(ConfigError, match=rf"{words} than -2$"):
            LinearPto(1.0, stiffness).relaxed(0.5)
    assert LinearPto(1.0, -1.9).relaxed(0.5)[1] == pytest.approx(0.5 * 0.05)


@pytest.mark.parametrize(
    ("direction", "reached"), [([1, 0, 0, 0], 1), ([0, 1, -2, 0], 2), ([1, 0.5, 1, 3], 5), ([0, 0, 0, 0], 0)]
)
def test_number_of_radiation_channels_of_a_port(direction, reached):
    """One for heave, two for each higher order: its cosines and sines."""
    assert channels_reached(np.array(direction, dtype=float), np.array([0, 1, -1, 2])) == reached
