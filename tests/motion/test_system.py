"""The door to integrators: z' = A z + B (n + waves) is M q'' = sum of forces, forwards and back."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLE, only_run, varied

from vsb.hydro.statespace import RadiationModel
from vsb.integrators.convolution import convolve
from vsb.integrators.exact import propagate
from vsb.integrators.exponential import ExponentialIntegrator
from vsb.motion.forces import (
    ConstantForce,
    Damper,
    Excitation,
    QuadraticDrag,
    RadiationMemory,
    RelaxingDamper,
    Spring,
    SpringDamper,
)
from vsb.motion.froude_krylov import incident
from vsb.motion.scene import Scene
from vsb.motion.system import EndStop, System, TakeOff, remainder
from vsb.motion.udwadia_kalaba import constrained
from vsb.scenes.build import assumed_pressure_design
from vsb.study.study import load
from vsb.waves.seas import Sea

OMEGA = np.array([1.3, 2.1])


@pytest.fixture(scope="module")
def wet():
    """The paper's free shell under its assumed pressure."""
    study = varied(load(EXAMPLE.parent / "paper.yaml"), published=None)
    one = varied(study, designs={"VSWEC": study.designs["VSWEC"].model_dump()})
    return assumed_pressure_design(only_run(one), {}).scene


@pytest.fixture(scope="module")
def linear():
    """Three coupled masses with springs, two dampers, waves and a memory of two states."""
    rng = np.random.default_rng(11)
    roots = rng.normal(size=(4, 3, 3))
    mass, stiffness, pto, structural = (root @ root.T + np.eye(3) for root in roots)
    channel, turning = np.array([1.0, 0.5]), np.array([[0.0, 1.0], [-1.0, 0.0]])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, rng.normal(size=(2, 3)), channel)
    forces = {
        "hydrostatic": Spring(5 * stiffness),
        "pto": Damper(0.3 * pto),
        "structural_damping": Damper(0.1 * structural),
        "excitation": Excitation(OMEGA, rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))),
        "radiation": RadiationMemory(memory),
    }
    return Scene(("Heave", "Radial2", "Radial3"), mass, forces, np.eye(3)[:, :2] + 0.1)


@pytest.fixture
def plants(linear, wet):
    return {"linear": linear, "wet": wet}


def moving(system, count=4):
    """Times and random states of the size of a motion."""
    time, rng = np.linspace(0.3, 1.7, count), np.random.default_rng(2)
    positions = np.linalg.solve(system.position, 0.02 * rng.normal(size=(system.free, count))).T
    return time, np.hstack([positions, rng.normal(size=(count, len(system.matrix) - system.free))])


@pytest.mark.parametrize(("stiffness", "omega"), [(0.0, 1.0), (1.0, 0.5), (36.0, 3.0)])
def test_heave_alone_has_the_frequency_of_its_spring_and_mass(stiffness, omega):
    alone = Scene(("Heave",), np.array([[4.0]]), {"hydrostatic": Spring(np.array([[stiffness]]))}, np.eye(1))
    assert System.of(alone).heaving == pytest.approx(omega, rel=1e-14)


def test_where_heave_is_not_first_its_frequency_is_that_of_the_motion_a_start_is_of():
    """Surge on a soft mooring beside it, in whatever order motions are allowed."""
    springs = {"hydrostatic": Spring(np.diag([0.04, 36.0]))}
    for lead, motions in ((1, np.eye(2)), (0, np.eye(2)[:, ::-1])):
        both = Scene(("Surge", "Heave"), 4.0 * np.eye(2), springs, motions, heave=np.eye(2)[lead])
        assert System.of(both).heaving == pytest.approx(3.0, rel=1e-14)


@pytest.mark.parametrize("name", ["linear", "wet"])
def test_the_system_is_the_equation_of_motion(plants, name):
    """N^T M N y'' = N^T of the named forces, and back to the same states."""
    plant = plants[name]
    system = System.of(plant)
    time, z = moving(system)
    motion = system.motion(time, z, system.forcing(time, z), 0.0)
    total = sum(system.forces(motion).values()) @ plant.motions
    inertia = motion.acceleration @ (plant.motions.T @ plant.mass @ plant.motions)
    assert inertia == pytest.approx(total, abs=1e-11 * np.abs(total).max())
    assert system.states(motion) == pytest.approx(z, abs=1e-12 * np.abs(z).max())
    assert system.first((motion.position[1], motion.velocity[1], motion.memory[1])) == pytest.approx(
        z[1], abs=1e-12 * np.abs(z).max()
    )


@pytest.mark.parametrize("name", ["linear", "wet"])
def test_what_drives_the_flow_is_what_the_integrators_add(plants, name):
    system = System.of(plants[name])
    time, z = moving(system)
    added = system.added(time, z) + system.push(time)
    motion = system.motion(time, z, added, 0.0)
    assert system.driving(motion, system.forces(motion)) == pytest.approx(added, abs=1e-11 * np.abs(added).max())


def test_without_memory_states_radiation_is_what_the_other_forces_leave(linear):
    system = System.of(linear)
    time, z = moving(system)
    motion = system.motion(time, z, system.push(time), 0.0)
    bare = replace(motion, memory=np.zeros((len(time), 0)))
    known, found = (system.forces(m)["radiation"] @ linear.motions for m in (motion, bare))
    assert found == pytest.approx(known, abs=1e-11 * np.abs(known).max())
    expected = known @ system.modes + system.push(time)
    assert system.driving(bare, system.forces(bare)) == pytest.approx(expected, abs=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("slack", [0.0, 0.3])
def test_the_compiled_remainder_is_the_forces_own(wet, slack):
    """Beside a spring too, slack where the shell is not."""
    dof = len(wet.labels)
    spring = SpringDamper(3e4 * np.eye(dof), np.zeros((dof, dof)), slack * np.arange(1.0, dof + 1))
    wet = replace(wet, forces={**wet.forces, "spring": spring})
    system = System.of(wet)
    time, z = moving(system)
    found = np.empty((len(time), system.free))
    for i, t in enumerate(time):
        remainder(system.remainder, t, z[i, : system.free].copy(), found[i])
    expected = system.added(time, z)
    assert np.abs(expected).max() > 1.0
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(system.shapes.T @ wet.constant).max())


def test_losses_and_energies_are_those_of_the_matrices(linear):
    system = System.of(linear)
    time, z = moving(system)
    motion = system.motion(time, z, system.push(time), 0.0)
    q, v = motion.position @ linear.motions.T, motion.velocity @ linear.motions.T
    pto, structural = (linear.forces[name].damping for name in ("pto", "structural_damping"))
    p = np.linalg.solve(system.modes, motion.velocity.T).T
    for found, form, damping in zip(linear.lost(v), system.dampers(), (pto, structural), strict=True):
        assert found == pytest.approx(np.einsum("ti,ij,tj->t", v, damping, v))
        assert found == pytest.approx(np.einsum("ti,ij,tj->t", p, form, p))
    stored, kinetic = system.energy(motion)
    assert kinetic == pytest.approx(0.5 * np.sum(p**2, axis=1))
    springs = 0.5 * np.einsum("ti,ij,tj->t", q, linear.forces["hydrostatic"].stiffness, q)
    assert stored - kinetic - springs == pytest.approx(0.5 * np.sum(motion.memory**2, axis=1))


def test_a_scene_names_its_take_off(linear):
    v = np.random.default_rng(1).normal(size=(3, 3))
    pto, structural = linear.lost(v)
    other = replace(linear, take_off="structural_damping")
    assert other.lost(v)[0] == pytest.approx(structural)
    assert other.lost(v)[1] == pytest.approx(pto)
    assert [d.tolist() for d in System.of(other).dampers()] == [d.tolist() for d in System.of(linear).dampers()[::-1]]
    assert not replace(linear, take_off="none").lost(v)[0].any()


def test_a_share_of_the_waves(linear, wet):
    half = System.of(linear).raised(0.5)
    assert half.waves == pytest.approx(0.5 * System.of(linear).waves)
    assert half.push(np.zeros(1)) @ half.modes.T @ (linear.motions.T @ linear.mass @ linear.motions) == pytest.approx(
        half.scene.forces["excitation"].force(np.zeros(1), np.zeros((1, 3)), np.zeros((1, 3))) @ linear.motions
    )
    assert System.of(wet).raised(0.25).remainder.amplitude == 0.25 * System.of(wet).remainder.amplitude
    assert System.of(linear).frequencies.tolist() == OMEGA.tolist()


def test_only_whole_linear_parts_make_a_linear_system(linear, wet):
    assert System.of(linear).linear
    assert not System.of(wet).linear
    assert not System.of(replace(linear, forces={**linear.forces, "weight": ConstantForce(np.ones(3))})).linear


def test_losses_go_to_the_take_off_to_other_dampers_and_to_what_remembers(linear):
    """A memory that is the take-off, as a chamber of air is, gives to it."""
    system = System.of(linear)
    n, z = system.free, np.random.default_rng(3).normal(size=len(system.matrix))
    memory = linear.memories["radiation"].radiated
    own = [z[n : 2 * n] @ damper @ z[n : 2 * n] for damper in system.dampers()]
    remembered = z[2 * n :] @ memory @ z[2 * n :]
    assert [z @ form @ z for form in system.losses()] == pytest.approx([*own, remembered])
    through = System.of(replace(linear, take_off="radiation"))
    assert [z @ form @ z for form in through.losses()] == pytest.approx([remembered, sum(own), 0.0])


def test_a_linear_scene_has_no_scale_and_another_that_of_its_buoy(linear, wet):
    assert (System.of(linear).size, System.of(linear).least) == (0.0, 0.0)
    water, system = wet.water, System.of(wet)
    radius = water.shell.shape.radius
    assert system.size == pytest.approx(1e-6 * radius)
    assert system.least == pytest.approx(1e-6 * np.sqrt(water.specific_weight) * radius**2)
    assert System.of(replace(linear, forces={**linear.forces, "weight": ConstantForce(np.ones(3))})).size == 1e-6


def test_methods_of_linear_systems_refuse_others(wet):
    system, time = System.of(wet), np.linspace(0.0, 1.0, 5)
    start = wet.start(0.0, 0.0)
    with pytest.raises(ValueError, match=r"exact propagation: received nonlinear forces, needs a linear scene; use"):
        propagate(system, time, start)
    with pytest.raises(ValueError, match=r"convolution: received nonlinear forces, needs a linear scene; use"):
        convolve(system, None, time, start)
    with pytest.raises(ValueError, match=r"Eq. 90: received the nonlinear forces water, weight, needs a linear scene"):
        constrained(wet, wet.water.shell.basis.clamp_rows([0.0]))


def test_linear_waves_unlike_those_on_the_shell_are_refused(wet):
    """The compiled loop turns one set of phasors."""
    dof = len(wet.labels)
    other = Excitation(OMEGA, np.ones((2, dof), dtype=complex))
    lone = replace(wet, forces={**wet.forces, "diffraction": other})
    with pytest.raises(ValueError, match="received linear waves unlike those on the wet shell, needs one sea"):
        _ = ExponentialIntegrator(System.of(lone), 0.1).remainder
    sea = incident(Sea(OMEGA, np.ones(2, dtype=complex)), np.inf, 9.81, 2.0)
    same = replace(lone, forces={**lone.forces, "water": replace(wet.water, assumed=None, waves=sea)})
    assert ExponentialIntegrator(System.of(same), 0.1).remainder.diffraction.shape == (2, wet.motions.shape[1])


ALONG = np.array([0.5, -1.0, 2.0])


@pytest.fixture(scope="module")
def mixed(linear):
    """The three masses with a take-off behind a chamber, a slack spring, drag and a weight beside."""
    return replace(
        linear,
        forces={
            "radiation": linear.forces["radiation"], "hydrostatic": linear.forces["hydrostatic"],
            "pto": RelaxingDamper(2.0 * np.outer(ALONG, ALONG), ALONG, 4.0, 0.1),
            "mooring": SpringDamper(np.diag([1.0, 2.0, 3.0]), np.diag([0.3, 0.2, 0.1]), np.array([0.4, -0.5, 0.6])),
            "drag": QuadraticDrag(np.eye(3)[:2], np.array([3.0, 7.0]), OMEGA, np.ones((2, 2)) + 0.5j),
            "weight": ConstantForce(np.array([7.0, -1.0, 2.0])),
            "excitation": linear.forces["excitation"],
        },
    )  # fmt: skip


def test_a_scene_of_all_kinds_of_forces_is_the_equation_of_motion(mixed):
    """Two memories, each with its own states, a spring and a damper slack elsewhere: forwards and back."""
    system = System.of(mixed)
    time, z = moving(system)
    motion = system.motion(time, z, system.forcing(time, z), 0.0)
    named = system.forces(motion)
    total = sum(named.values()) @ mixed.motions
    inertia = motion.acceleration @ (mixed.motions.T @ mixed.mass @ mixed.motions)
    assert inertia == pytest.approx(total, abs=1e-11 * np.abs(total).max())
    q = motion.position @ mixed.motions.T
    chamber = motion.memory[:, 2:] @ mixed.forces["pto"].model.input_matrix
    assert named["pto"] == pytest.approx(-2.0 * np.outer(q @ ALONG, ALONG) - chamber, abs=1e-12)
    water = motion.memory[:, :2] @ mixed.forces["radiation"].model.input_matrix
    assert named["radiation"] == pytest.approx(-water, abs=1e-12)
    driven = system.driving(motion, named)
    assert driven == pytest.approx(system.forcing(time, z), abs=1e-11 * np.abs(driven).max())
    rows = slice(1, 3)
    assert system.added_during(time)(z[rows], rows) == pytest.approx(system.added(time, z)[rows], abs=1e-12)


def test_losses_of_a_scene_of_two_memories_go_to_whom_each_belongs(mixed):
    system = System.of(mixed)
    n, z = system.free, np.random.default_rng(3).normal(size=len(system.matrix))
    taken, lost, radiated = (z @ form @ z for form in system.losses())
    x = z[2 * n :]
    assert radiated == pytest.approx(x[:2] @ mixed.forces["radiation"].model.radiated @ x[:2])
    assert taken == pytest.approx(x[2] ** 2 / (4.0 * 0.1))
    v = z[n : 2 * n] @ system.shapes.T
    assert lost == pytest.approx(v @ mixed.forces["mooring"].damping @ v)


def test_what_forces_store_beyond_their_tangents_is_that_of_smooth_nonlinear_ones(mixed):
    """A slack spring K (q - q0)^2/2 less K q^2/2, a weight -f.q; neither linear springs nor laws that switch."""
    laws = {"law": TakeOff(ALONG, 4.0, 10.0, 5.0), "end_stop": EndStop(ALONG, 0.01, 100.0, 30.0)}
    position = np.random.default_rng(4).normal(size=(3, 2))
    q, slack = position @ mixed.motions.T, np.array([0.4, -0.5, 0.6])
    k = np.diag([1.0, 2.0, 3.0])
    expected = 0.5 * slack @ k @ slack - q @ k @ slack - q @ np.array([7.0, -1.0, 2.0])
    for more in ({}, laws):
        system = System.of(replace(mixed, forces={**mixed.forces, **more}))
        assert system.beyond_tangents(position) == pytest.approx(expected)
    assert (
        not System.of(replace(mixed, forces={"hydrostatic": mixed.forces["hydrostatic"]}))
        .beyond_tangents(position)
        .any()
    )


def test_a_system_knows_what_switches_pauses_jumps_and_is_foreign(mixed, wet):
    """Of each law, of an end stop alone, and of none."""
    stop = EndStop(ALONG, 0.7, 100.0, 30.0)
    laws = {
        "none": (None, (False, False, False)),
        "smooth": (TakeOff(ALONG, 4.0), (True, False, False)),
        "friction": (TakeOff(ALONG, np.inf, limit=5.0), (True, False, True)),
        "latched": (TakeOff(ALONG, 4.0, pause=0.3), (True, True, False)),
    }
    for law, expected in laws.values():
        system = System.of(replace(mixed, forces={**mixed.forces, **({"law": law} if law else {})}))
        assert (system.switching, system.pauses, system.jumps) == expected
    stopped = System.of(replace(mixed, forces={**mixed.forces, "end_stop": stop}))
    assert (stopped.switching, stopped.pauses, stopped.jumps) == (True, False, False)
    assert stopped.foreign == ["drag", "end_stop"]
    with pytest.raises(ValueError, match=r"^received a take-off that switches, needs smooth forces; use `switched`\.$"):
        stopped.check_compiled()
    with pytest.raises(ValueError, match=r"^received the force drag, which compiled steps do not know; use"):
        System.of(mixed).check_compiled()
    System.of(mixed).check_smooth()
    System.of(wet).check_compiled()
    assert System.of(wet).foreign == []


def test_a_start_of_water_that_is_not_at_rest_has_its_states(mixed):
    system, rng = System.of(mixed), np.random.default_rng(6)
    y, rate, memory = rng.normal(size=2), rng.normal(size=2), rng.normal(size=3)
    z = system.first((y, rate, memory))
    assert z[4:].tolist() == memory.tolist()
    assert system.position @ z[:2] == pytest.approx(y)
    assert system.modes @ z[2:4] == pytest.approx(rate)
    assert system.first((y, rate))[4:].tolist() == [0.0] * 3


def test_a_motion_that_falls_has_a_matrix_that_lets_it_grow_and_heave_that_falls_no_frequency():
    """p'' = 9 p of one mode, -25 p of the other: whatever its sign a square has a scale."""
    scene = Scene(("Heave", "Radial2"), np.eye(2), {"hydrostatic": Spring(np.diag([-9.0, 25.0]))}, np.eye(2))
    system = System.of(scene)
    assert system.scale == pytest.approx([3.0, 5.0])
    assert np.sort(np.linalg.eigvals(system.matrix).real) == pytest.approx([-3.0, 0.0, 0.0, 3.0], abs=1e-12)
    assert system.heaving == 1.0


def test_a_frequency_of_several_forces_is_one(mixed):
    twice = {**mixed.forces, "diffraction": Excitation(np.array([2.1, 0.4]), np.ones((2, 3)) + 0j)}
    assert System.of(replace(mixed, forces=twice)).frequencies.tolist() == [0.4, 1.3, 2.1]
    assert System.of(replace(mixed, forces={"hydrostatic": mixed.forces["hydrostatic"]})).frequencies.size == 0


@pytest.mark.parametrize("begin", [0.0, 0.7])
def test_the_compiled_remainder_of_a_later_leg_goes_on_with_its_waves(wet, begin):
    """Time counts from the begin of the leg; pressure, waves on the wet shell and linear ones from that of the run."""
    dof = len(wet.labels)
    sea = Sea(OMEGA, np.array([0.05 + 0.02j, -0.03j]))
    waves = incident(sea, np.inf, 9.81, 2.0)
    beside = Excitation(OMEGA, 1e3 * (np.arange(2 * dof).reshape(2, dof) + 0.5j))
    water = replace(wet.water, assumed=None, waves=waves)
    pressed, driven = (
        System.of(wet),
        System.of(replace(wet, forces={**wet.forces, "water": water, "diffraction": beside})),
    )
    for system, diffraction in ((pressed, None), (driven, beside.phasors @ driven.shapes)):
        time, z = moving(system)
        known = system.remainder._replace(begin=begin)
        known = known if diffraction is None else known._replace(diffraction=np.ascontiguousarray(diffraction))
        found = np.empty((len(time), system.free))
        for i, t in enumerate(time):
            remainder(known, t - begin, z[i, : system.free].copy(), found[i])
        expected = system.forcing(time, z)
        assert found == pytest.approx(expected, abs=1e-12 * np.abs(system.shapes.T @ wet.constant).max())


def test_forces_that_an_integrator_alone_knows_are_those_of_the_motion(mixed):
    """In place of what position and velocity would give; radiation without states is what they leave."""
    system = System.of(mixed)
    time, z = moving(system)
    motion = system.motion(time, z, system.forcing(time, z), 0.0)
    told = replace(motion, forces={"drag": np.full((4, 3), 7.0)})
    before, after = system.forces(motion), system.forces(told)
    assert before.keys() == after.keys()
    np.testing.assert_array_equal(after["drag"], np.full((4, 3), 7.0))
    for name in before.keys() - {"drag"}:
        np.testing.assert_array_equal(after[name], before[name])
    alone = replace(mixed, forces={name: force for name, force in mixed.forces.items() if name != "pto"})
    bare = replace(told, memory=np.zeros((4, 0)))
    found = System.of(alone).forces(bare)
    inertia = motion.acceleration @ mixed.motions.T @ mixed.mass
    np.testing.assert_allclose(sum(found.values()), inertia, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(found["drag"], np.full((4, 3), 7.0))
