"""Linear systems, shells and bodies: published power, limits, radiation channels, natural modes, refused input."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import labelled, varied

from vsb.engine.hydro.database import Check, Coefficients, as_json
from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import simulate
from vsb.engine.motion.coefficient_errors import INTERPOLATION, OF_OTHERS, RESOLVED, coefficient_errors
from vsb.engine.motion.frequency import LinearEquation, compliance, normal_modes, softest, unrestrained_motions
from vsb.engine.motion.linear import Channel, LinearSystem, linear_body, one_channel, with_added_mass_inf
from vsb.engine.motion.port import LinearPto, combination
from vsb.engine.motion.scene import linear_scene, together
from vsb.engine.motion.system import System
from vsb.engine.shell.device import MaxwellBranch
from vsb.engine.waves.seas import Sea
from vsb.errors import DatabaseError, StabilityError
from vsb.models.floating_system import body_motions
from vsb.models.rest import design_motions, study_basis
from vsb.study.body import BodyDesign


def power(buoy_of, study, design, omega):
    buoy = buoy_of(study)
    return buoy.absorbed_power(omega, buoy.rao(omega, design_motions(study, study_basis(study), design)))


@pytest.fixture(scope="module")
def published(seed):
    """The seed's buoy with c = 6000 N s/m and full resolution."""
    return varied(seed, pto={"damping": 6000.0})


def test_absorbed_power_matches_the_semi_analytic_estimate(buoy_of, published):
    """17.2 and 9.96 kW/m^2 rigid; about +39 % and -37 % for the free shell."""
    omega = np.array([2.0, 2 * np.pi / 2.5])
    rigid, free = (power(buoy_of, published, design, omega) for design in ("FSB", "VSWEC"))
    assert rigid == pytest.approx([17.2e3, 9.96e3], rel=5e-3)
    assert 100 * (free / rigid - 1) == pytest.approx([39.0, -37.0], abs=1.0)


def test_motion_of_many_modes_takes_less_memory_than_their_stiffness_over_frequency(rng_matrices):
    """At each frequency the solution is that of the whole equation there."""
    equation = rng_matrices(frequencies=600, dof=100)
    direction, motions = np.ones(100), np.eye(100)[:, 1:]
    tracemalloc.start()
    try:
        free, forced = equation.free_motion(motions, direction)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 600 * 100**2 * 16
    w, (added_mass, radiated, force) = equation.omega[599], (each[599] for each in equation.water)
    dynamic = equation.stiffness - w**2 * (equation.mass + added_mass) - 1j * w * (radiated + equation.damping)
    loads = np.column_stack([force, direction])[1:]
    expected = motions @ np.linalg.solve(dynamic[1:, 1:], loads)
    assert np.column_stack([free[599], forced[599]]) == pytest.approx(expected, rel=1e-9)


@pytest.fixture
def rng_matrices():
    """Equations of motion with matrices at random."""

    def made(frequencies, dof):
        rng = np.random.default_rng(1)
        shapes = rng.standard_normal((3, dof, dof)) / np.sqrt(dof)
        mass, damping, stiffness = (each @ each.T + np.eye(dof) for each in shapes)
        omega = np.linspace(0.5, 3.0, frequencies)
        water = Coefficients(
            np.broadcast_to(mass, (frequencies, dof, dof)), np.broadcast_to(damping, (frequencies, dof, dof)),
            rng.standard_normal((frequencies, dof)).astype(complex),
        )  # fmt: skip
        return LinearEquation(omega, water, mass, damping, stiffness)

    return made


def test_stiff_shell_approaches_the_rigid_buoy(buoy_of, seed):
    omega = np.linspace(0.5, 6.0, 23)
    gains = []
    for modulus in (1e9, 1e11):
        study = varied(seed, device={"young_modulus": modulus, "damping": {"alpha": 0.0, "beta": 0.0}})
        gains.append(np.abs(power(buoy_of, study, "VSWEC", omega) / power(buoy_of, study, "FSB", omega) - 1).max())
    assert gains[0] / gains[1] == pytest.approx(100, rel=0.2)  # flexibility is first order in 1/E


def test_fast_branch_of_a_viscous_shell_is_a_damper(buoy_of, seed):
    """Of its ratio times its time, beside the stiffness of the shell."""
    omega, buoy = np.linspace(0.5, 6.0, 12), buoy_of(seed)
    viscous = replace(buoy, maxwell=(MaxwellBranch(ratio=10.0, time=1e-4),))
    damped = replace(buoy, structural_damping=buoy.structural_damping + 1e-3 * buoy.stiffness_parts["structural"])
    motions = design_motions(seed, study_basis(seed), "VSWEC")
    found, expected, plain = (one.rao(omega, motions) for one in (viscous, damped, buoy))
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected - plain).max()


@pytest.mark.parametrize(("structural", "pto", "radiated"), [(0.0, 0.0, 0.0), (70.0, 250.0, 400.0)])
def test_wet_damping_ratio_of_uncoupled_motions(structural, pto, radiated):
    """(B + D + c)/(2 w (M + A)), for heave and for a mode without coupling to it."""
    omega, pair = np.linspace(0.1, 12.0, 240), ("influenced_dof", "radiating_dof")
    curve = (omega / 2) ** 3 * np.exp(3 - 1.5 * omega)
    damping = radiated * curve[:, None, None] * np.diag([1.0, 0.1])
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, np.diag([500.0, 30.0])), "added_mass_inf": (pair, np.diag([300.0, 10.0])),
            "hydrostatic_stiffness": (pair, np.diag([3000.0, 0.0])), "structural_stiffness": (pair, np.diag([0.0, 900.0])),
            "radiation_damping": (("omega", *pair), damping),
        },
        coords={"omega": omega},
    )  # fmt: skip
    buoy = LinearSystem(ds, np.diag([0.0, structural]), LinearPto(pto))
    frequencies, ratios = buoy.natural_modes(np.eye(2))
    for at, (frequency, ratio) in enumerate(zip(frequencies, ratios, strict=True)):
        here = np.array([frequency])
        mass = (buoy.mass + buoy.added_mass_inf + buoy.spectrum.added_mass_difference(here)[0])[at, at]
        lost = buoy.spectrum.at(here)[0][at, at] + (pto, structural)[at]
        assert frequency == pytest.approx(np.sqrt((3000.0, 900.0)[at] / mass), rel=1e-9)
        assert ratio == pytest.approx(lost / (2 * frequency * mass), rel=1e-9, abs=1e-15)


def changed(buoy, **factors):
    """A buoy with variables of its database multiplied."""
    return replace(buoy, database=buoy.database.assign({name: buoy.database[name] * f for name, f in factors.items()}))


def test_natural_modes_of_a_light_shell_with_negative_total_inertia(buoy_of, seed):
    """The added mass of a nearly immersed body is negative at some frequencies."""
    device = {"mass": 29.5e3, "thickness": 0.003, "density": 800.0}
    study = varied(seed, device=device, modes={"degree": 3}, hydro={"tolerance": 1e-2, "omega_max": 9.0})
    buoy = buoy_of(study)
    free = np.eye(len(buoy.mass))
    omega = buoy.database.omega.values
    assert np.linalg.eigvalsh(buoy.mass + buoy.coefficients(omega).added_mass).min() < 0.0
    frequencies, ratios = buoy.natural_modes(free)
    assert (np.diff(frequencies) > 0).all()
    assert (ratios > 0).all()
    added = buoy.added_mass_inf + buoy.spectrum.added_mass_difference(frequencies)
    scale = np.sqrt(np.diag(buoy.stiffness))
    for w, a in zip(frequencies, added, strict=True):
        left = np.linalg.eigvalsh((buoy.stiffness - w**2 * (buoy.mass + a)) / np.outer(scale, scale))
        assert np.abs(left).min() < 1e-8 * np.abs(left).max()


def test_unstable_or_massless_motions_are_refused(buoy_of, seed):
    with pytest.raises(StabilityError, match=r"gives way at rest: received a stiffness of -.* needs more than 0"):
        changed(buoy_of(seed), structural_stiffness=-1.0).natural_modes(np.eye(8))
    with pytest.raises(DatabaseError, match=r"takes a mode's inertia; lower hydro.tolerance"):
        changed(buoy_of(seed), added_mass_inf=-1.0).natural_modes(np.eye(8))


@pytest.mark.parametrize(
    ("stiffness", "force", "moved"),
    [
        (np.diag([4.0, 0.0]), [1.0, 0.0], 0.25),
        (np.diag([4.0, 0.0]), [0.0, 1.0], np.inf),
        (np.diag([1e12, 1e-3]), [0.0, 1.0], 1e3),  # scales are no looseness
        (np.diag([4.0, 0.0]), [1e8, 1.0], 2.5e15),  # of which a hundredth of a millionth drifts
        (np.array([[1.0, 5e-12 - 1], [5e-12 - 1, 1.0]]), [1.0, 1.0], 4e11),
        (np.array([[1.0, 5e-13 - 1], [5e-13 - 1, 1.0]]), [1.0, 1.0], np.inf),  # held by round-off alone
        (np.array([[1.0, 5e-13 - 1], [5e-13 - 1, 1.0]]), [1.0, -1.0], 1.0),
    ],
)
def test_static_compliance_of_a_port(stiffness, force, moved):
    assert compliance(stiffness, np.array(force)) == pytest.approx(moved, rel=1e-3)


@pytest.mark.parametrize("coupling", [-8.0, 25.0])
def test_unrestrained_motion_moves_without_force(coupling):
    """Pitch stiffness k beside free surge: w^2 = k/(I - s^2/m); surge moves by -s/m of it, and may be damped there."""
    omega, pair = np.linspace(0.1, 12.0, 60), ("influenced_dof", "radiating_dof")
    mass, turning, stiffness, across, about = 50.0, 20.0, 90.0, 3.0, 2.0
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, np.array([[mass, coupling], [coupling, turning]])),
            "added_mass_inf": (pair, np.zeros((2, 2))),
            "hydrostatic_stiffness": (pair, np.diag([0.0, stiffness])),
            "radiation_damping": (("omega", *pair), np.zeros((60, 2, 2))),
        },
        {"omega": omega} | {dim: ["Surge", "Pitch"] for dim in pair},
    )
    buoy = LinearSystem(ds, np.diag([across, about]), LinearPto(0.0))
    (frequency,), (ratio,) = buoy.natural_modes(np.eye(2))
    left = turning - coupling**2 / mass
    assert frequency == pytest.approx(np.sqrt(stiffness / left), rel=1e-9)
    lost = about + across * (coupling / mass) ** 2
    assert ratio == pytest.approx(lost / (2 * frequency * left), rel=1e-9)


SOLVED = np.linspace(0.2, 6.0, 60)


def wave_force(omega):
    """Excitation of two motions of one order and one of another."""
    x = np.array([np.exp(-0.2 * omega), 0.3 * omega * np.exp(-0.4 * omega), omega**2 * np.exp(-omega)]).T
    return x * np.exp(1j * np.outer(omega, [0.1, 0.1, 0.4]))


@pytest.fixture
def two_orders():
    damping = np.zeros((60, 3, 3))
    for group, h in (([0, 1], 2.0), ([2], 1.0)):
        pick = np.array(group)
        damping[:, pick[:, None], pick] = h * SOLVED[:, None, None] ** 3 * one_channel(wave_force(SOLVED)[:, pick])
    dims = ("influenced_dof", "radiating_dof")
    return xr.Dataset(
        {
            "radiation_damping": (("omega", *dims), damping),
            "excitation_force": (("omega", "wave_direction", dims[0]), wave_force(SOLVED)[:, None]),
        },
        {"omega": SOLVED},
    )


@pytest.mark.parametrize(("group", "factor"), [((0, 1), 2.0), ((2,), 1.0)])
def test_channel_damping_between_solved_frequencies(two_orders, group, factor):
    channel, omega = Channel(two_orders, np.array(group)), np.array([0.25, 1.234, 5.5])
    assert channel.power == 3
    found, pick = channel.damping(omega, wave_force(omega)), np.array(group)
    expected = np.zeros_like(found)
    expected[:, pick[:, None], pick] = factor * omega[:, None, None] ** 3 * one_channel(wave_force(omega)[:, pick])
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


def test_damping_where_the_excitation_vanishes(two_orders):
    """The force changes sign at 3 rad/s, where the solver's damping is dominated by its error."""
    two_orders.excitation_force[:, 0, 2] = 3.0 - SOLVED
    damping = SOLVED**3 * (3.0 - SOLVED) ** 2
    near = np.abs(SOLVED - 3.0) < 0.06
    assert near.any()
    beside = np.abs(SOLVED - 3.0) < 0.06 + 2 * (SOLVED[1] - SOLVED[0])  # where its error is of the damping's own size
    two_orders.radiation_damping[:, 2, 2] = np.where(near, -1e-3, np.where(beside, 1.5 * damping, damping))
    channel, omega = Channel(two_orders, np.array([2])), np.array([2.9, 2.98, 3.02, 3.1])
    force = np.zeros((4, 3), dtype=complex)
    force[:, 2] = 3.0 - omega
    np.testing.assert_allclose(channel.damping(omega, force)[:, 2, 2], omega**3 * (3.0 - omega) ** 2, rtol=1e-10)


RIGID = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
WATER = np.diag([0.0, 0.0, 1.2e5, 8e4, 8e4, 0.0])


def moored(*lines, water=WATER):
    """Stiffness of lines k a a^T beside the water's."""
    return water + sum(k * np.outer(a, a) for k, a in lines)


def line(degrees, height=0.0, arm=0.0):
    """How a horizontal line of a direction pulls: at a height above the centre, past it at an arm."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([c, s, 0.0, -height * s, height * c, arm])


@pytest.mark.parametrize(
    ("lines", "left"),
    [
        ([], 3),
        ([(2e4, line(20.0))], 2),
        ([(2e4, line(20.0)), (1e3, line(21.0))], 1),
        ([(2e4, line(20.0, arm=2.0))], 2),
        ([(2e4, line(20.0, arm=2.0)), (2e4, line(20.0, arm=-2.0))], 1),
        ([(2e4, line(20.0)), (2e4, line(110.0)), (1.0, line(20.0, arm=2.0))], 0),
    ],
)
def test_every_independent_line_restrains_one_more_motion(lines, left):
    stiffness = moored(*lines)
    loose = unrestrained_motions(stiffness, RIGID, np.eye(6))
    assert loose.shape == (6, left)
    np.testing.assert_allclose(loose.T @ loose, np.eye(left), atol=1e-12)
    np.testing.assert_allclose(stiffness @ loose, 0.0, atol=1e-10)
    np.testing.assert_allclose(loose[2:5], 0.0, atol=1e-15)  # surge, sway and yaw alone
    least, motion = softest(stiffness, loose)
    assert least > 0.0
    np.testing.assert_allclose(motion @ stiffness @ motion, least, rtol=1e-9)
    np.testing.assert_allclose(loose.T @ motion, 0.0, atol=1e-10)


def test_normal_modes_with_unrestrained_motions():
    """Beside them those of the line and of the water, each of its own mass, whatever couples them."""
    rng = np.random.default_rng(7)
    mass = np.diag([2e4, 2.5e4, 3e4, 9e3, 8e3, 7e3])
    mass[0, 4] = mass[4, 0] = 4e3
    mass[1, 3] = mass[3, 1] = -5e3
    for angle in rng.uniform(0.0, 360.0, 5):
        stiffness = moored((2e4, line(angle, height=-1.5)))
        loose = unrestrained_motions(stiffness, RIGID, np.eye(6))
        squares, modes = normal_modes(stiffness, mass, loose)
        assert (squares[:2] == 0.0).all()
        assert (np.diff(squares) >= 0.0).all()
        np.testing.assert_allclose(modes.T @ mass @ modes, np.eye(6), atol=1e-10)
        np.testing.assert_allclose(modes.T @ stiffness @ modes, np.diag(squares), atol=1e-10 * squares[-1])
        reckoned = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
        np.testing.assert_allclose(squares, reckoned, rtol=1e-9, atol=1e-9)


PAIR = ("influenced_dof", "radiating_dof")
OBLIQUE = np.pi / 4


@pytest.fixture(scope="module")
def database():
    """Surge, heave, pitch and bending that radiate through two resonances, in waves from two sides."""
    omega, one = np.arange(1, 81) * 0.05, np.eye(4)
    s, radiated = 1j * omega[:, None, None], np.zeros((80, 4, 4), dtype=complex)
    for pole, channel in ((-0.4 + 0.6j, [1.0, 0.3, 0.2, 0.1]), (-0.4 + 1.8j, [-0.2, 0.8, 0.5, -0.4])):
        radiated += s / ((s - pole) * (s - pole.conjugate())) * np.outer(channel, channel)
    ahead = np.sqrt(np.einsum("wii->wi", radiated.real)) * np.exp(1j * np.arange(4.0))
    force = np.stack([ahead, 0.7 * ahead[:, ::-1]], axis=1)
    values = {
        "added_mass": (("omega", *PAIR), radiated.imag / omega[:, None, None] + one),
        "radiation_damping": (("omega", *PAIR), radiated.real),
        "excitation_force": (("omega", "wave_direction", PAIR[0]), force),
        "added_mass_inf": (PAIR, one), "hydrostatic_stiffness": (PAIR, np.diag([0.0, 1.5, 0.8, 0.0])),
        "inertia_matrix": (PAIR, one), "structural_stiffness": (PAIR, np.diag([0.3, 0.0, 0.0, 2.0])),
        "structural_damping_matrix": (PAIR, np.diag([0.1, 0.0, 0.1, 0.1])),
    }  # fmt: skip
    coords = {"omega": omega, "wave_direction": [0.0, OBLIQUE]}
    labels = ["Surge", "Heave", "Pitch", "Bending1"]
    return xr.Dataset(values, coords | {dim: labels for dim in PAIR})  # noqa: C420


def test_time_and_frequency_domain_agree_in_waves_from_several_directions(database):
    labels = [str(label) for label in database.influenced_dof.values]
    pto = LinearPto(0.2, 0.1, combination(labels, {"Heave": 1.0, "Bending1": -0.6}))
    body = replace(linear_body(database), pto=pto)
    fit = body.memory(1e-3, limit="fitted")
    waves = {
        0.0: Sea(np.array([0.9, 1.4]), np.array([0.3, 0.1 + 0.1j])),
        OBLIQUE: Sea(np.array([1.1]), np.array([0.2j])),
    }
    scene, sea = linear_scene(body, fit.model, waves, None, fit.added_mass_inf), together(waves)
    system = System.of(scene)
    motion, stride, _ = simulate(system, sea, Simulation(duration=300.0, window=(0.0, 300.0)), None)
    late = motion.time > 250.0
    expected = np.zeros((late.sum(), len(labels)))
    for direction, some in waves.items():
        phasors = some.amplitude[:, None] * replace(body, direction=direction).rao(some.omega, np.eye(len(labels)))
        expected += np.real(np.exp(-1j * np.outer(motion.time[late], some.omega)) @ phasors)
    missed = np.abs(motion.position[late] - expected).max(axis=0) / np.abs(expected).max(axis=0)
    assert missed.max() < 5e-3
    record = labelled(system, motion, sea, "body", "waves", stride)
    assert record.attrs["energy_residual"] < 1e-9
    lost = record.energy.isel(time=-1)
    assert float(lost.sel(term="pto")) > 0 < float(lost.sel(term="radiated"))


def with_one_channel(buoy):
    """The buoy with the damping of its database that of one channel alone."""
    damping = buoy.database.radiation_damping.copy(data=buoy.coefficients(buoy.database.omega.values).damping)
    return replace(buoy, database=buoy.database.assign(radiation_damping=damping))


def test_axisymmetric_and_general_formulations_agree(buoy_of, seed):
    """The database of an axisymmetric buoy, its single radiation channel not used."""
    buoy = with_one_channel(buoy_of(seed))
    omega, free = buoy.spectrum.omega[4:-4:7], np.eye(len(buoy.mass))
    dry = buoy.stiffness - buoy.stiffness_parts["hydrostatic"]
    body = linear_body(buoy.database, mass=buoy.mass, damping=buoy.structural_damping, stiffness=dry)
    loaded = replace(body, pto=replace(buoy.pto, port=free[0]))
    assert loaded.rao(omega, free) == pytest.approx(buoy.rao(omega, free), rel=1e-9)


def test_errors_stored_in_a_database(database):
    """By coarser panels and by the waves radiated, on straight lines between the frequencies."""
    body, rng, at = linear_body(database), np.random.default_rng(1), database.omega.values[2:4]
    matrix = rng.normal(size=(2, 80, 4, 4))
    errors = {
        "added_mass_error": (("error", "omega", *PAIR), matrix * np.array([1.0, 0.0])[:, None, None, None]),
        "radiation_damping_error": (("error", "omega", *PAIR), matrix),
        "excitation_force_error": (("error", "omega", "wave_direction", PAIR[0]), matrix[:, :, :2] + 0j),
        "hydrostatic_stiffness_error": (("error", *PAIR), matrix[:, 0]),
    }
    stored = body.database.assign(errors).assign_coords(error=["fewer panels", "waves radiated"])
    stored = stored.assign_attrs(quality=as_json([]))
    panels, waves = coefficient_errors(replace(body, database=stored), np.array([at.mean()]))
    assert (panels.name, waves.name) == (f"{RESOLVED} (fewer panels)", f"{RESOLVED} (waves radiated)")
    assert panels.signed
    assert panels.error.added_mass[0] == pytest.approx(matrix[0, 2:4].mean(axis=0))
    assert not waves.error.added_mass.any()
    assert waves.error.damping[0] == pytest.approx(matrix[1, 2:4].mean(axis=0))
    assert panels.stiffness == pytest.approx(matrix[0, 0])


def test_file_without_stated_error_gets_one_per_cent(database):
    body, stated = linear_body(database), Check("interpolation_error", 0.02, 0.05, "-", "ok", "")
    for checks, names in (([], [OF_OTHERS]), ([stated], [OF_OTHERS, INTERPOLATION])):
        read = replace(body, database=body.database.assign_attrs(quality=as_json(checks)))
        errors = coefficient_errors(read, np.array([1.0]))
        assert [error.name for error in errors] == names
        known = read.coefficients(np.array([1.0])).added_mass
        np.testing.assert_allclose(errors[0].error.added_mass, 0.01 * np.abs(known))


def test_added_mass_at_infinite_frequency_is_robust_to_outliers():
    """K(s) = s/(s^2 + s + 1): B = Re K(i omega), A = A(inf) + Im K(i omega)/omega."""
    omega = np.linspace(0.05, 20.0, 201)
    memory = 1j * omega / (1 - omega**2 + 1j * omega)
    added = 7.0 + memory.imag / omega
    added[[0, 60, -1]] += 1e4
    data = {"added_mass": added, "radiation_damping": memory.real}
    ds = xr.Dataset({name: (("omega", *PAIR), value[:, None, None]) for name, value in data.items()}, {"omega": omega})
    found = with_added_mass_inf(ds)
    assert found.added_mass_inf.dims == PAIR
    assert found.added_mass_inf.item() == pytest.approx(7.0, abs=1e-3)
    assert found.attrs["history"] == "added mass at infinite frequency from damping"


def floating_body(labels, mass, stiffness, direction=0.0, directions=(0.0,)):
    """A body that makes no waves, in waves whose force is the number of their direction, from one on."""
    omega, pair, dof = np.linspace(0.5, 4.0, 8), PAIR, len(labels)
    force = np.ones((8, len(directions), dof)) * (1.0 + np.arange(len(directions)))[:, None]
    ds = xr.Dataset(
        {name: (("omega", *pair), np.zeros((8, dof, dof))) for name in ("added_mass", "radiation_damping")}
        | {"added_mass_inf": (pair, np.zeros((dof, dof))), "hydrostatic_stiffness": (pair, np.diag(stiffness))}
        | {"excitation_force": (("omega", "wave_direction", pair[0]), force.astype(complex))},
        {"omega": omega, "wave_direction": list(directions)} | {dim: list(labels) for dim in pair},
    )
    none = np.zeros((dof, dof))
    return replace(linear_body(ds, mass=np.diag(mass), damping=none, stiffness=none), direction=direction)


@pytest.mark.parametrize(("turns", "degrees", "force"), [(0, 180.0, 2.0), (-2, 0.0, 1.0), (1, -90.0, 3.0)])
def test_wave_directions_are_periodic(turns, degrees, force):
    body = floating_body(("Heave",), [2.0], [3.0], np.deg2rad(degrees + 360.0 * turns), np.deg2rad([0.0, 180.0, 270.0]))
    assert body.coefficients(np.array([1.0, 2.0])).excitation == pytest.approx(np.full((2, 1), force))


def test_unstable_body_is_refused():
    bare = floating_body(("Heave", "Pitch"), [4.0, 5.0], [9.0, 9.0])
    capsizing = linear_body(bare.database, mass=bare.mass, damping=0 * bare.mass, stiffness=np.diag([0.0, -29.0]))
    message = r"^the body is statically unstable: received a negative stiffness of Pitch, growing by 2/s;"
    with pytest.raises(StabilityError, match=message):
        linear_scene(capsizing, None, {})


@pytest.mark.parametrize("place", ["database", "memory"])
def test_initial_heave_respects_constraints_with_all_inertia(place):
    """Wherever the common inertia stands: body, database or fitted memory."""
    labels = ("Surge", "Heave", "Pitch", "Bending")
    mass = np.array([[4.0, 0.3, 0.8, 0.0], [0.3, 5.0, 0.0, 0.7], [0.8, 0.0, 6.0, 0.0], [0.0, 0.7, 0.0, 2.0]])
    own, none = np.diag([1.0, 2.0, 3.0, 1.5]), np.zeros((4, 4))
    bare = floating_body(labels, np.ones(4), np.ones(4))
    inf = {"database": mass - own, "memory": 0.1 * np.eye(4)}[place]
    ds = bare.database.assign(added_mass_inf=(PAIR, inf))
    body = linear_body(ds, mass=own, damping=none, stiffness=none)
    model = RadiationModel(np.array([[-0.5]]), np.array([[1.0, 0.3, 0.0, 0.0]]), np.ones(1))
    held = ({"Heave": 1.0, "Pitch": -2.0},)
    fitted = (model, {}) if place == "memory" else (None, {})
    motions = body_motions("one", BodyDesign(held=held), labels)
    scene = linear_scene(body, *fitted, motions, mass - own if place == "memory" else None)
    position, velocity = (scene.motions @ y for y in scene.start(0.3, -0.6))
    assert position == pytest.approx([-0.8 / 4.0 * 0.15, 0.3, 0.15, 0.0], rel=1e-12, abs=1e-15)
    assert velocity == pytest.approx(-2 * position)
