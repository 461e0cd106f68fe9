from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro import database
from vsb.hydro.spectral.sweep import converged_on_grid
from vsb.hydro.statespace import fit_radiation
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.motion.builders import linear_scene
from vsb.motion.frequency import LinearBuoy, with_open_chamber
from vsb.motion.port import Port, PortMotion, _between, channels_reached, combination, line_shares, port_direction
from vsb.motion.pto import LinearPto
from vsb.motion.system import System
from vsb.motion.tuning import best_dampers
from vsb.scenes.directions import order_bases
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.shell.deformed import DeformedShell, enclosed
from vsb.shell.modes import mode_basis
from vsb.stages.spectral import spectral_problem
from vsb.study.plan import StudyPlan
from vsb.study.take_off import BetweenPort, LinePort, ShellPort
from vsb.waves.dispersion import power_limit
from vsb.waves.seas import Sea

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
    """Its impedance is nearly all spring, Re Y/|Y| down to 1e-13: what is left beside the one channel is not in it."""
    study, buoy = lossless
    omega, bound = np.arange(0.2, 4.5, 0.0137), min(1e-4, study.hydro.tolerance)
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


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("between", [(30.0, 110.0), (0.0, 130.0)])
def test_a_port_between_two_points_moves_by_their_distance(seed, order, between):
    """Its change with each amplitude of an order by differences, from where points of the meridian theta = 0 go."""
    planar = varied(seed, motion="planar", modes={"degree": 3, "order": 2},
                    device={"centre_of_mass": -0.5, "ballast_inertia": 9e3})  # fmt: skip
    basis, radius = study_basis(planar), planar.device.radius
    (family,) = (each for each in order_bases(planar, basis) if each.order == order and not each.odd)
    at = np.deg2rad(between)
    out, along = np.stack([np.sin(at), np.cos(at)], axis=1), np.stack([np.cos(at), -np.sin(at)], axis=1)
    radial, meridional, _ = family.field(at)

    def distance(k, amplitude):
        places = (radius + amplitude * radial[k])[:, None] * out + amplitude * meridional[k][:, None] * along
        return np.linalg.norm(places[1] - places[0])

    slopes = [(distance(k, 1e-4) - distance(k, -1e-4)) / 2e-4 for k in range(len(family.labels))]
    slopes[: family.rigid] = [0.0] * family.rigid
    found = _between(BetweenPort(between=between), DeformedShell(basis, planar.centre_height), family)
    np.testing.assert_allclose(found, slopes, atol=1e-7)
    assert np.abs(found).max() > 0.1
    swollen = np.full(len(basis.labels), 0.02 * radius)
    for amplitude in (np.zeros(len(basis.labels)), swollen):  # not by round-off, nor by the shape at rest
        rest = DeformedShell(basis, planar.centre_height, amplitude)
        assert not _between(BetweenPort(between=between), rest, family)[: family.rigid].any()
        assert not _between(BetweenPort(between=between), rest, family.turned()).any()  # odd in y: none at theta = 0


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
        return enclosed(basis, shell.modal_amplitude[None])[0][0]

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


@given(ports, st.floats(0.1, 5.0), st.floats(0.1, 5.0))
def test_what_drifts_at_rest_has_of_two_springs_beside_it_their_sum(found, one, other):
    adrift = replace(found, compliance=np.inf)
    assert adrift.beside(one).compliance == pytest.approx(1 / one, rel=1e-14)
    both = adrift.beside(one).beside(other)
    assert both.compliance == pytest.approx(adrift.beside(one + other).compliance, rel=1e-12)
    assert both.admittance == pytest.approx(adrift.beside(one + other).admittance, rel=1e-9)


@given(ports, st.floats(0.0, 5.0))
def test_a_chamber_before_the_take_off_stores_but_takes_nothing(found, compliance):
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


def test_a_closed_turbine_leaves_the_gas_as_a_spring_and_an_open_one_none(chambered):
    study, closed = chambered
    omega, motions, b = np.linspace(0.4, 5.5, 9), np.eye(5), direction(study, "volume")
    opened = with_open_chamber(closed, b)
    assert opened.stiffness + np.outer(b, b) / opened.chamber == pytest.approx(closed.stiffness, rel=1e-9, abs=1e-3)
    shut, free = (replace(opened, pto=LinearPto(c, 0.0, b)).rao(omega, motions) for c in (1e12, 1e-9))
    assert shut == pytest.approx(closed.rao(omega, motions), rel=1e-4, abs=1e-7)
    assert free == pytest.approx(replace(opened, chamber=0.0).rao(omega, motions), rel=1e-6, abs=1e-9)
    assert with_open_chamber(opened, b) is opened


def test_a_chamber_gives_way_to_nothing_at_rest(chambered):
    """At frequency zero gas does not resist: the damper is all there is of damping, as without a chamber."""
    study, closed = chambered
    b = direction(study, "volume")
    opened = replace(with_open_chamber(closed, b), pto=LinearPto(1e3, 0.0, b))
    bare = replace(opened, chamber=0.0)
    assert opened.chamber > 0
    np.testing.assert_allclose(opened.damping, bare.damping, rtol=1e-12)
    np.testing.assert_allclose(opened.held, bare.held, rtol=1e-12)
    assert np.abs(opened.damping_at(np.array(1.0)) - bare.damping).max() > 1e-3 * np.abs(bare.damping).max()


def test_the_port_behind_a_chamber_is_the_whole_equation_of_motion(chambered):
    """Thevenin's power at the turbine is that of the response; what any force can take is that without a chamber."""
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


def test_wet_modes_ring_between_those_of_an_open_and_of_a_closed_chamber(chambered):
    study, closed = chambered
    b, motions = direction(study, "volume"), np.eye(5)
    opened = with_open_chamber(closed, b)
    rings = [
        buoy.natural_modes(motions)
        for buoy in (opened, *(replace(opened, pto=LinearPto(c, 0.0, b)) for c in (300.0, 1e9)), closed)
    ]
    free, half, shut, trapped = (frequency for frequency, _ in rings)
    assert np.all(free <= half * (1 + 1e-9))
    assert np.all(half <= trapped * (1 + 1e-9))
    assert half[0] != pytest.approx(free[0], rel=1e-3)
    assert shut == pytest.approx(trapped, rel=1e-6)
    assert np.all(rings[1][1] > rings[3][1])  # a turbine damps, what is trapped does not


def test_a_run_behind_a_chamber_takes_what_the_port_tells(chambered):
    """Settled power against the frequency domain, radiation straight from the coefficients."""
    study, closed = chambered
    b, omega = direction(study, "volume"), np.array([2 * np.pi / 3.0])
    opened = with_open_chamber(closed, b)
    radiation, _ = fit_radiation(opened.spectrum, 1e-3)
    for pto in (LinearPto(400.0, 0.0, b), LinearPto(400.0, -50.0, b), LinearPto(0.0, 90.0, b), LinearPto(0.0, 0.0, b)):
        scene = linear_scene(replace(opened, pto=pto), radiation, Sea(omega, np.array([0.1 + 0j])), np.eye(5))
        found = harmonic_balance(System.of(scene), transfer=opened.spectrum.transfer)
        steady = found.power
        seen = port(opened, study, "VSWEC", omega, "volume").power(pto.damping, pto.stiffness)[0]
        assert steady.pto == pytest.approx(0.01 * seen, rel=1e-3, abs=1e-9)
        assert steady.residual < 1e-9
        assert ("pto" in scene.forces) == bool(pto.damping or pto.stiffness)


def test_a_source_of_energy_is_refused():
    with pytest.raises(DatabaseError, match=r"port: gives out energy at 2 rad/s, received Re Y = -0.1 .* lower hydro"):
        Port(np.array([1.0, 2.0]), np.array([0.1 + 0j, -0.1]), np.ones(2, dtype=complex), 1.0)


def test_round_off_is_no_source_of_energy_where_waves_hardly_move_the_port():
    """Its matched power is then no more than elsewhere; where waves move the port, none can be told."""
    omega, admittance = np.array([1.0, 2.0]), np.array([1e-6 + 2e-6j, -3e-14 + 2e-6j])
    port = Port(omega, admittance, np.array([0.5, 1e-4 + 0j]), 1.0)
    assert 0 < port.matched_power[1] < port.matched_power[0]
    with pytest.raises(DatabaseError, match=r"port: gives out energy at 2 rad/s, received Re Y = -3e-14"):
        Port(omega, admittance, np.array([0.5, 0.5 + 0j]), 1.0)


def test_a_take_off_without_a_spring_has_none():
    """At a port so soft that a newton per metre counts."""
    omega = np.array([0.5, 1.0, 2.0])
    soft, squares = Port(omega, np.array([1.0 + 1j, 2.0, 1.0 - 3j]), np.ones(3) + 0j, 1e-9), np.ones((1, 3))
    assert np.all(soft.load(2.0) == 2.0)
    for name in ("power", "speed_under"):
        found = getattr(soft, name)(2.0)
        assert found == pytest.approx(np.abs(soft.velocity_under(np.full(3, 2.0))) ** 2, rel=1e-14)
        assert found == pytest.approx(getattr(soft, name)(2.0, 0.0), rel=1e-14)
        assert np.all(np.abs(getattr(soft, name)(2.0, 1.0) / found - 1) > 0.05)
    assert best_dampers(soft, squares).stiffness.tolist() == [0.0]
    assert best_dampers(soft, squares).power == best_dampers(soft, squares, 0.0, 1.0).power


@pytest.mark.parametrize("choice", ["surge", "pitch"])
def test_a_rigid_port_has_the_speed_of_its_motion(seed, choice):
    """One metre or radian of it is one of the take-off, of every other motion none."""
    planar = varied(
        seed, motion="planar", modes={"degree": 3, "order": 2}, device={"centre_of_mass": -0.5, "ballast_inertia": 1e4}
    )
    basis = study_basis(planar)
    orders = order_bases(planar, basis)
    labels = [*basis.labels, *(label for each in orders for label in each.labels)]
    found = port_direction(choice, DeformedShell(basis, planar.centre_height), orders)
    np.testing.assert_array_equal(found, [float(label == choice.capitalize()) for label in labels])


@pytest.mark.parametrize(
    ("direction", "reached"),
    [([1, 0, 0, 0, 0], 1), ([0, 1, 0, 0, 0], 2), ([0, 0, 1, 0, 0], 2), ([0, 1, -2, 0, 0], 2), ([1, 1, 1, 0, 0], 3),
     ([1, 0.5, 1, 1, 3], 5), ([0, 0, 0, 0, 1], 2), ([0, 0, 0, 0, 0], 0), ([0, -1, 0, 0, 0], 2), ([-2, 0, 0, 0, -1], 3)],
)  # fmt: skip
def test_a_port_reaches_one_channel_of_heave_and_two_of_each_higher_order(direction, reached):
    """Cosines and sines of an order have them together: waves from one side come as one of the two."""
    assert channels_reached(np.array(direction, dtype=float), np.array([0, 1, -1, 2, -2])) == reached


@pytest.mark.parametrize(
    "line", [((3.0, -40.0), (0.0, -1.5)), ((-7.0, -12.0), (0.8, -0.4)), ((2.0, -9.0), (-1.1, 0.3))]
)
@pytest.mark.parametrize("height", [0.6, -0.3])
def test_a_line_to_the_bed_grows_with_each_motion_as_its_ends_go_apart(line, height):
    """By differences of its length: surge and heave shift, pitch turns the attachment about the sphere's centre."""
    (to, at) = line

    def length(surge, heave, pitch):
        x = surge + at[0] * np.cos(pitch) + at[1] * np.sin(pitch)
        z = height + heave - at[0] * np.sin(pitch) + at[1] * np.cos(pitch)
        return np.hypot(x - to[0], z - to[1])

    found = line_shares(LinePort(line_to=to, line_from=at), height)
    for name, way in zip(("Surge", "Heave", "Pitch"), 1e-5 * np.eye(3), strict=True):
        assert found[name] == pytest.approx((length(*way) - length(*-way)) / 2e-5, abs=1e-9)


def test_what_comes_with_a_port_follows_its_force_under_each_load():
    """free - F forced, F = Z V: heave of loads and frequencies, the shell of points in two directions beside."""
    rng = np.random.default_rng(2)
    omega = np.array([0.5, 1.0, 2.0])
    port = Port(omega, np.array([1.0 + 1j, 2.0, 1.0 - 3j]), np.array([1.0, 2j, -0.5]), 1.0)
    free, forced = rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))
    shell, pushed = rng.normal(size=(2, 2, 4, 3)) + 1j * rng.normal(size=(2, 2, 4, 3))
    load = port.load(np.array([2.0, 0.3]), np.array([-1.0, 4.0]))
    heave, moved = PortMotion((free, forced), (shell, pushed)).under(port, load)
    for i, (c, k) in enumerate(((2.0, -1.0), (0.3, 4.0))):
        for j, w in enumerate(omega):
            z = c + 1j * k / w
            force = z * port.velocity[j] / (1 + port.admittance[j] * z)
            assert heave[i, j] == pytest.approx(free[j] - force * forced[j], rel=1e-12)
            np.testing.assert_allclose(moved[i, :, :, j], shell[:, :, j] - force * pushed[:, :, j], rtol=1e-12)


@pytest.mark.parametrize("chosen", [np.array([2, 0]), np.array([True, False, True])])
def test_a_port_at_some_of_its_frequencies_is_the_same_there(chosen):
    port = Port(np.array([0.5, 1.0, 2.0]), np.array([1.0 + 1j, 2.0, 1.0 - 3j]), np.array([1.0, 2j, -0.5]), 0.7)
    some = port.at(chosen)
    for name in ("omega", "admittance", "velocity", "matched_power", "best_damping", "impedance", "matched_force"):
        np.testing.assert_array_equal(getattr(some, name), getattr(port, name)[chosen])
    assert some.compliance == 0.7


def test_a_combination_is_in_the_order_of_the_motions_and_names_all_that_are_not_there():
    labels = ["Surge", "Heave", "Pitch"]
    assert combination(labels, {"Pitch": -2, "Surge": 0.5}).tolist() == [0.5, 0.0, -2.0]
    with pytest.raises(ConfigError, match=r"^pto.port: received Lid, Roof; needs some of Surge, Heave, Pitch\.$"):
        combination(labels, {"Roof": 1.0, "Heave": 1.0, "Lid": 2.0})
    for shares in ({"Heave": 0.0, "Pitch": 0.0}, {"Heave": np.inf}, {"Heave": 1.0, "Pitch": np.nan}, {}):
        with pytest.raises(ConfigError, match=r"^pto.port: received \{.*\}; needs finite shares, not all zero\.$"):
            combination(labels, shares)


@pytest.mark.parametrize("at", [0, 1])
def test_a_source_of_energy_is_told_where_it_is_and_what_nothing_moves_is_none(at):
    admittance, velocity = np.array([-0.1 + 1j, -0.2 + 0j]), np.zeros(2, dtype=complex)
    assert not Port(np.array([1.0, 2.0]), admittance, velocity, 1.0).moves
    velocity[at] = -0.3j
    with pytest.raises(
        DatabaseError, match=rf"^port: gives out energy at {1 + at} rad/s, received Re Y = -0.{1 + at} m"
    ):
        Port(np.array([1.0, 2.0]), admittance, velocity, 1.0)
    with pytest.raises(DatabaseError, match=r"received Re Y = 0 m"):
        Port(np.array([1.0, 2.0]), np.zeros(2, dtype=complex), velocity, 1.0)


def test_a_port_that_only_yields_has_no_share_and_no_power():
    """Admittance without loss or none at all: neither is divided by."""
    port = Port(np.array([1.0, 2.0, 3.0]), np.array([0.0, 2j, 3.0 - 4j]), np.array([0.0, 0.0, 5.0 + 0j]), 0.0)
    assert port.impedance.tolist() == [0.0, -0.5j, pytest.approx((3.0 + 4j) / 25)]
    assert port.reactance_ratio.tolist() == [0.0, 0.0, pytest.approx(4 / 3)]
    assert port.matched_power.tolist() == [0.0, 0.0, pytest.approx(25 / 24)]
    assert port.matched_force.tolist() == [0.0, 0.0, pytest.approx(5 / 6)]
    assert port.moves
    assert port.softest_spring == -np.inf
    assert port.beside(0.0) is port.behind(0.0) is port


def test_of_several_loads_those_without_a_spring_have_none_and_one_of_both_is_shared():
    """|V|^2 under c + i k/omega, springs of either sign: of rows of both, of one damper and of one spring."""
    port = Port(np.array([0.5, 1.0, 2.0]), np.array([1.0 + 1j, 2.0, 1.0 - 3j]), np.array([1.0, 2j, -0.5]), 1.0)
    dampers, springs = np.array([2.0, 0.3, 1.0]), np.array([0.0, 4.0, -1.0])
    for c, k in ((dampers, springs), (dampers, 4.0), (0.7, springs), (dampers, 0.0), (0.7, -1.0)):
        under = np.abs(port.velocity / (1 + port.admittance * (c + 1j * k / port.omega[:, None]).T)) ** 2
        under = under if np.ndim(c) or np.ndim(k) else under[0]
        np.testing.assert_allclose(port.speed_under(c, k), under, rtol=1e-12)
        np.testing.assert_allclose(port.power(c, k), 0.5 * np.asarray(c)[..., None] * under, rtol=1e-12)
        np.testing.assert_allclose(np.abs(port.velocity_under(port.load(c, k))) ** 2, under, rtol=1e-12)


@pytest.mark.parametrize("against", ["sea_bed", "frame"])
@pytest.mark.parametrize("way", ["vertical", "radial"])
def test_a_ring_is_a_port_upwards_or_outwards_and_heaves_with_the_buoy_against_the_sea_bed_alone(seed, way, against):
    """By differences of where its points are."""
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
    assert (ShellPort(colatitude=50).direction, ShellPort(colatitude=50).against) == ("vertical", "sea_bed")


@pytest.mark.parametrize("height", [0.6, -0.3])
def test_a_line_is_a_port_of_rigid_motions_at_the_height_the_buoy_floats_at(seed, height):
    planar = varied(
        seed, motion="planar", modes={"degree": 3, "order": 2}, device={"centre_of_mass": -0.5, "ballast_inertia": 1e4}
    )
    basis, line = study_basis(planar), LinePort(line_to=(3.0, -40.0), line_from=(0.8, -0.4))
    orders = order_bases(planar, basis)
    labels = [*basis.labels, *(label for each in orders for label in each.labels)]
    found = dict(zip(labels, port_direction(line, DeformedShell(basis, height), orders), strict=True))
    assert found == dict.fromkeys(labels, 0.0) | line_shares(line, height)


@pytest.mark.parametrize("radius", [2e-3, 2.0, 2e4])
def test_what_a_mode_has_no_share_in_is_nothing_whatever_the_size(seed, radius):
    """The volume of a sphere knows membrane modes of degree 0 alone, a ring at the equator none of odd degrees."""
    device = seed.device.model_copy(update={"radius": radius, "thickness": radius / 200})
    basis = mode_basis(device, "membrane", 6)
    shape, degrees = DeformedShell(basis, 0.0), np.array(basis.degrees[1:])
    volume = port_direction("volume", shape)
    assert np.flatnonzero(volume).tolist() == [1]
    assert volume[1] == pytest.approx(4 * np.pi * radius**2)
    ring = port_direction(ShellPort(colatitude=90, direction="radial", against="frame"), shape)
    assert (ring[1:] != 0).tolist() == (degrees % 2 == 0).tolist()


@pytest.mark.parametrize("choice", ["heave", "volume", ShellPort(colatitude=40)], ids=str)
def test_a_port_of_the_axisymmetric_shell_has_no_part_in_higher_orders(seed, choice):
    planar = varied(
        seed, motion="planar", modes={"degree": 3, "order": 2}, device={"centre_of_mass": -0.5, "ballast_inertia": 1e4}
    )
    basis = study_basis(planar)
    shape, orders = DeformedShell(basis, 0.3), order_bases(planar, basis)
    found, count = port_direction(choice, shape, orders), len(basis.labels)
    assert len(found) == count + sum(len(each.labels) for each in orders)
    np.testing.assert_array_equal(found[:count], port_direction(choice, shape))
    assert not found[count:].any()
    assert found[:count].any()
    assert found[0] == pytest.approx(float(choice != "volume"), abs=1e-12)


@pytest.mark.parametrize("between", [(30.0, 110.0), (0.0, 130.0)])
def test_a_port_between_two_points_has_its_part_in_every_order_in_turn(seed, between):
    planar = varied(
        seed, motion="planar", modes={"degree": 3, "order": 3}, device={"centre_of_mass": -0.5, "ballast_inertia": 1e4}
    )
    basis, choice = study_basis(planar), BetweenPort(between=between)
    shape, orders = DeformedShell(basis, 0.3), order_bases(planar, basis)
    found = np.split(
        port_direction(choice, shape, orders), np.cumsum([len(basis.labels), *(len(o.labels) for o in orders)])
    )
    np.testing.assert_array_equal(found[0], port_direction(choice, shape))
    for part, order in zip(found[1:-1], orders, strict=True):
        np.testing.assert_array_equal(part, _between(choice, shape, order))
        assert part.any()


@pytest.mark.parametrize("spring", [3.0, -1.5, 1e-9, -1.999])
def test_a_spring_beside_a_port_at_rest_adds_to_what_holds_it(spring):
    """Of either sign: another one may be so much softer or less; what cannot move has no other compliance."""
    held = Port(np.array([1.0, 2.0]), np.array([1.0 + 1j, 2.0]), np.array([1.0, 2j]), 0.5)
    assert held.softest_spring == -2.0
    assert held.beside(spring).compliance == pytest.approx(1 / (2.0 + spring), rel=1e-12)
    assert held.beside(spring).softest_spring == pytest.approx(-2.0 - spring, rel=1e-12)
    assert replace(held, compliance=0.0).beside(spring).compliance == 0.0
