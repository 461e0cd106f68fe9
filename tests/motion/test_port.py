import numpy as np
import pytest
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st

from vsb.errors import DatabaseError
from vsb.hydro import database
from vsb.hydro.spectral.sweep import converged_on_grid
from vsb.motion.frequency import LinearBuoy
from vsb.motion.port import Port, port_direction
from vsb.motion.pto import LinearPto
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import DeformedShell, enclosed
from vsb.shell.modes import design_motions, study_basis
from vsb.stages.spectral import spectral_problem
from vsb.study.plan import StudyPlan
from vsb.study.take_off import BetweenPort, ShellPort
from vsb.waves.seas import power_limit

LOSSLESS = {"damping": {"alpha": 0.0, "beta": 0.0}}
SHELL_PORTS = (
    "volume",
    ShellPort(colatitude=90, direction="radial"),
    ShellPort(colatitude=120, direction="radial", against="frame"),
    BetweenPort(between=(0, 180)),
    BetweenPort(between=(30, 110)),
)


def solved(study):
    """The linear buoy of a study as a run makes it: few frequencies solved, the rest of the grid interpolated."""
    (block,), basis = StudyPlan(study).sweep_blocks, study_basis(study)
    found = converged_on_grid(spectral_problem(block), list(block.omega), block.tolerance, block.interpolation)
    raw = database.with_symmetrized(database.in_modes(database.with_excitation(found), basis))
    return LinearBuoy(database.with_structure(raw, reference_shell(study)), basis.damping, LinearPto(0.0))


def direction(study, choice):
    basis = study_basis(study)
    return port_direction(choice, DeformedShell(basis, study.centre_height))


def port(buoy, study, design, omega, choice="heave"):
    motions = design_motions(study, study_basis(study), design)
    return buoy.port(omega, motions, direction(study, choice))


@pytest.fixture(scope="module", params=[1e-3, 1e-6], ids=str)
def lossless(seed, request):
    study = varied(seed, device=LOSSLESS, hydro={"tolerance": request.param})
    return study, solved(study)


def share_of_limit(found):
    limit = np.array([power_limit(w, np.inf, 1025.0, 9.81) for w in found.omega])
    return found.matched_power / limit


@pytest.mark.parametrize("choice", ["heave", ShellPort(colatitude=60)], ids=str)
def test_what_any_force_can_take_does_not_depend_on_the_shell(lossless, choice):
    """One radiation channel: lambda/(2 pi) of crest, whatever port and shell, as exactly as the coefficients are."""
    study, buoy = lossless
    omega, bound = np.arange(0.2, 4.5, 0.0137), min(1e-4, study.hydro.tolerance)
    for design in study.designs:
        assert share_of_limit(port(buoy, study, design, omega, choice)) == pytest.approx(1.0, abs=bound), design


@pytest.mark.parametrize("choice", SHELL_PORTS, ids=str)
def test_a_port_within_the_shell_can_take_as_much(lossless, choice):
    """Its impedance is nearly all spring, Re Y/|Y| down to 1e-13: no digit of the coefficients is to spare."""
    study, buoy = lossless
    omega, bound = np.arange(0.25, 4.5, 0.0137), study.hydro.tolerance
    for design in ("VSWEC", "VSWEC0"):
        assert share_of_limit(port(buoy, study, design, omega, choice)) == pytest.approx(1.0, abs=bound), design


CHECKED = {  # period: rigid c*, its share of the limit, free shell's c*, share; multipole computation, physics.md 8
    2.5: (13093, 0.7802, 15565, 0.5548, -28.9, -34.0),
    3.06: (14159, 0.8174, 8228, 0.9217, 12.8, None),
    3.3: (20308, 0.6547, 13138, 0.7032, 7.4, 30.0),
    4.0: (38796, 0.3813, 29575, 0.3656, -4.1, 19.0),
    5.0: (64282, 0.1999, 51929, 0.1807, -9.6, 9.5),
    8.0: (135991, 0.0414, 113179, 0.0356, -14.0, 3.0),
}


def test_fair_comparison_of_the_seed(seed):
    """Independent multipole computation, exactly half submerged: power to 0.2 %, the best damper to 0.3 %."""
    half = 1025.0 * 2 / 3 * np.pi * 2.0**3
    study = varied(seed, device={"mass": half})
    buoy, omega = solved(study), 2 * np.pi / np.array(list(CHECKED))
    rigid, free = (port(buoy, study, design, omega) for design in ("FSB", "VSWEC"))
    limit = np.array([power_limit(w, np.inf, 1025.0, 9.81) for w in omega])
    c_rigid, p_rigid, c_free, p_free, gain, _ = np.array(list(CHECKED.values()), dtype=float).T
    assert rigid.best_damping == pytest.approx(c_rigid, rel=3e-3)
    assert free.best_damping == pytest.approx(c_free, rel=3e-3)
    assert rigid.best_power / limit == pytest.approx(p_rigid, rel=2e-3)
    assert free.best_power / limit == pytest.approx(p_free, rel=2e-3)
    assert 100 * (free.best_power / rigid.best_power - 1) == pytest.approx(gain, abs=0.25)
    fixed = 100 * (free.power(8000.0) / rigid.power(8000.0) - 1)
    stated = np.array([row[-1] is not None for row in CHECKED.values()])
    assert fixed[stated] == pytest.approx([row[-1] for row in CHECKED.values() if row[-1] is not None], abs=0.7)


def test_the_port_is_the_whole_equation_of_motion(seed):
    """Thevenin's power under a damper is that of the response with the damper in its matrix."""
    omega = np.linspace(0.3, 11.0, 57)
    buoy = solved(seed)
    for design in seed.designs:
        motions = design_motions(seed, study_basis(seed), design)
        damped = LinearBuoy(buoy.database, buoy.structural_damping, LinearPto(8000.0))
        whole = damped.absorbed_power(omega, damped.rao(omega, motions))
        assert port(buoy, seed, design, omega).power(8000.0) == pytest.approx(whole, rel=1e-9)


def test_a_rigid_buoy_does_not_move_a_port_of_its_own(seed):
    buoy, omega = solved(seed), np.linspace(0.3, 11.0, 7)
    for choice in (BetweenPort(between=(0, 180)), ShellPort(colatitude=40, against="frame"), "volume"):
        still = port(buoy, seed, "FSB", omega, choice)
        assert not still.moves
        assert still.compliance == 0.0
        assert still.softest_spring == -np.inf
        for nothing in (still.power(1e4), still.matched_power, still.best_power, still.reactance_ratio):
            assert not nothing.any()


def test_a_clamp_holds_a_port(seed):
    held = port(solved(seed), seed, "VSWEC90", np.array([2.0]), ShellPort(colatitude=90, direction="radial"))
    assert not held.moves


def test_directions_are_what_points_and_volume_do(seed):
    """Finite differences of the deformed shell: distance of two points, height of one, volume enclosed."""
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
        return enclosed(basis, shell.amplitudes[None])[0][0]

    for choice, quantity in (
        (BetweenPort(between=(30, 140)), apart), (ShellPort(colatitude=70), height), ("volume", volume)
    ):  # fmt: skip
        found = port_direction(choice, shape)
        assert found == pytest.approx(np.array(moved(1e-5, quantity)) / 2e-5, rel=1e-6, abs=1e-7 * np.abs(found).max())


def passive(draw_from):
    """A passive port of three springs, masses and dampers in a row, at ten frequencies."""
    mass, damping, stiffness, free = draw_from
    omega = np.linspace(0.5, 3.0, 10)
    y = sum(1 / (-1j * omega * m + b + 1j * k / omega) for m, b, k in zip(mass, damping, stiffness, strict=True))
    return Port(omega, y, np.full(10, complex(*free)), sum(1 / k for k in stiffness))


triples = st.tuples(*[st.floats(0.1, 10.0)] * 3)
ports = st.tuples(triples, triples, triples, st.tuples(st.floats(-2, 2), st.floats(0.1, 2))).map(passive)


@given(ports, st.floats(1e-3, 1e3), st.floats(-0.5, 5.0))
def test_no_damper_beats_the_best_one_and_no_load_the_matched(found, damping, spring):
    assert np.all(found.power(damping) <= found.best_power * (1 + 1e-12))
    assert np.all(found.power(damping, spring) <= found.matched_power * (1 + 1e-12))
    best = np.diagonal(found.power(found.best_damping))
    assert best == pytest.approx(found.best_power, rel=1e-12)
    assert best == pytest.approx(found.matched_power * 2 / (1 + np.sqrt(1 + found.reactance_ratio**2)), rel=1e-12)


@given(ports)
def test_spring_and_damper_of_one_frequency_take_the_matched_power(found):
    z = found.impedance
    for i, w in enumerate(found.omega):
        assert found.power(z.real[i], -w * z.imag[i])[i] == pytest.approx(found.matched_power[i], rel=1e-9)
    velocity = found.velocity - found.admittance * found.matched_force
    taken = 0.5 * np.real(found.matched_force * velocity.conj())
    assert taken == pytest.approx(found.matched_power, rel=1e-12)


@given(ports, st.floats(-0.02, 5.0), st.floats(0.01, 10.0))
def test_a_spring_beside_the_take_off_is_part_of_the_load(found, spring, damping):
    beside = found.beside(spring)
    assert beside.power(damping) == pytest.approx(found.power(damping, spring), rel=1e-9)
    assert beside.matched_power == pytest.approx(found.matched_power, rel=1e-9)
    assert beside.softest_spring == pytest.approx(found.softest_spring - spring, rel=1e-9)


@given(ports, st.floats(0.0, 5.0))
def test_a_chamber_before_the_take_off_stores_but_takes_nothing(found, compliance):
    behind = found.behind(compliance)
    assert behind.matched_power == pytest.approx(found.matched_power, rel=1e-12)
    assert behind.impedance == pytest.approx(1 / (found.admittance - 1j * found.omega * compliance), rel=1e-12)
    assert behind.compliance == pytest.approx(found.compliance + compliance)


def test_a_source_of_energy_is_refused():
    with pytest.raises(DatabaseError, match=r"port: gives out energy at 2 rad/s, received Re Y = -0.1 .* lower hydro"):
        Port(np.array([1.0, 2.0]), np.array([0.1 + 0j, -0.1]), np.ones(2, dtype=complex), 1.0)
