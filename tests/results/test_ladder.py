import csv
import io
import itertools
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from conftest import varied
from motion.test_drag import Buoy
from motion.test_drag import seas as dragged_seas
from scipy.optimize import minimize, minimize_scalar

from vsb.hydro import database
from vsb.hydro.dofs import displacements
from vsb.hydro.spectral.sweep import converged_on_grid
from vsb.motion.constrained import REFINED, optimum_in_sea
from vsb.motion.drag import under
from vsb.motion.force_bound import Limits
from vsb.motion.frequency import LinearBuoy
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port, port_direction
from vsb.motion.pto import LinearPto
from vsb.motion.tuning import Load, frequencies, mean_power, squares
from vsb.results.ladder import (
    Given,
    Limited,
    Rung,
    _peaks,
    as_csv,
    constrained_checks,
    constrained_rung,
    dragged_rungs,
    linear_rungs,
    rungs_of,
    study_ladder,
)
from vsb.scenes.afloat import Afloat, Met, afloat, headings, study_sea
from vsb.scenes.ports import ShapeWater, design_ports
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.stages.spectral import spectral_problem
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id
from vsb.waves.seas import Sea


def ladder(ports, seas, families, given, time, dragged=None):
    """Rungs of every design in every sea of one direction, from ports over `frequencies` of the seas."""
    waves = list(seas.values())
    met = {
        design: Met(port, squares(waves, port.omega), [np.searchsorted(port.omega, one.omega) for one in waves])
        for design, port in ports.items()
    }
    return rungs_of(met, seas, families, given, time, dragged)


def random_port(rng, omega):
    """A passive buoy of one motion, with a shell in series: a second resonance."""
    mass, loss, stiffness = 10 ** rng.uniform(-1, 1, (3, 2))
    y = sum(1 / (-1j * omega * m + b + 1j * k / omega) for m, b, k in zip(mass, loss, stiffness, strict=True))
    return Port(omega, y, rng.normal(size=len(omega)) + 1j * rng.normal(size=len(omega)), float(np.sum(1 / stiffness)))


@pytest.mark.parametrize("start", range(0, 200, 50))
def test_the_rungs_are_in_order_in_random_studies(start):
    for number in range(start, start + 50):
        rng = np.random.default_rng(number)
        seas = {}
        for name in "abcd":
            omega = rng.uniform(0.4, 2.0) + 0.1 * np.arange(rng.integers(1, 12))
            seas[name] = Sea(omega, rng.rayleigh(size=len(omega)) * np.exp(2j * np.pi * rng.uniform(size=len(omega))))
        omega = frequencies(list(seas.values()))
        ports = {"A": random_port(rng, omega), "B": random_port(rng, omega)}
        spring = rng.uniform(-0.9, 2.0) / max(port.compliance for port in ports.values())
        given = dict.fromkeys(ports, Given(10 ** rng.uniform(-2, 2), spring, 0.8 if number % 10 == 0 else 1.0))
        rungs = {(r.design, r.wave, r.rung): r for r in ladder(ports, seas, [0, 1, 3], given, 30.0)}
        assert len(rungs) == 2 * 4 * 5
        for design in ports:
            for wave in seas:
                power = {rung: r.power_mean for (d, w, rung), r in rungs.items() if (d, w) == (design, wave)}
                up = [power[name] for name in ("fixed", "best_damper", "best_spring_damper", "matched")]
                assert all(a <= b * (1 + 1e-9) + 1e-12 for a, b in itertools.pairwise(up)), (number, up)
                assert power["best_damper_all_seas"] <= power["best_damper"] * (1 + 1e-9) + 1e-12


def test_forces_and_strokes_are_those_of_the_realisation():
    """Sums of sines at many instants; a regular wave has its amplitudes."""
    omega = np.array([1.0, 1.3])
    port = Port(omega, 1 / np.array([2.0 + 1j, 1.0 - 2j]), np.array([1.0 + 0.5j, 0.3j]), 1.0)
    seas = {"wave": Sea(omega[:1], np.array([0.5 + 0j])), "sea": Sea(omega, np.array([1.0 + 0j, 0.7j]))}
    found = {(r.wave, r.rung): r for r in ladder({"A": port}, seas, [0, 1], {"A": Given(3.0)}, 200.0)}
    velocity = port.velocity_under(port.load(3.0)) * seas["sea"].amplitude
    time = np.linspace(0, 200, 20001)
    force = np.real(3.0 * velocity @ np.exp(-1j * np.outer(omega, time)))
    stroke = np.real((velocity / (-1j * omega)) @ np.exp(-1j * np.outer(omega, time)))
    fixed = found["sea", "fixed"]
    assert fixed.force_peak == pytest.approx(np.abs(force).max(), rel=0.02)  # eight instants a period
    assert fixed.stroke_peak == pytest.approx(np.abs(stroke).max(), rel=0.02)
    assert fixed.force_rms == pytest.approx(np.sqrt(np.mean(force**2)), rel=0.02)
    assert fixed.power_mean == pytest.approx(np.mean(force**2) / 3.0, rel=0.03)
    alone = found["wave", "fixed"]
    assert alone.force_peak == pytest.approx(np.sqrt(2) * alone.force_rms, rel=1e-12)
    assert alone.stroke_peak == pytest.approx(alone.force_peak / 3.0, rel=1e-12)


def test_a_port_that_cannot_move_is_marked_by_empty_cells():
    omega = np.ones(1)
    still = Port(omega, np.zeros(1, dtype=complex), np.zeros(1, dtype=complex), 0.0)
    text = as_csv(ladder({"A": still}, {"w": Sea(omega, np.ones(1, dtype=complex))}, [0], {"A": Given(None)}, 10.0))
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["rung"] for row in rows] == ["best_damper", "best_damper_all_seas", "best_spring_damper", "matched"]
    assert {(row["power_mean"], row["limit_fraction"], row["damping"]) for row in rows} == {("0", "", "")}


def test_reference_cases_of_wec_sims_control_example(buoy_of, seed):
    """Sphere of 10 m diameter, half immersed: best dampers and the reactive pair to three digits."""
    device = {"radius": 5.0, "thickness": 0.02, "mass": 2 / 3 * np.pi * 5.0**3 * 1000.0}
    hydro, water = {"omega_max": 3.0, "tolerance": 1e-4}, {"density": 1000.0}
    wave = [{"kind": "regular", "amplitude": 1.0, "period": 9.6664}]
    study = varied(seed, device=device, hydro=hydro, water=water, designs={"R": {"flexible": False}}, waves=wave)
    basis, omega = study_basis(study), 2 * np.pi / np.array([9.6664, 3.5])
    heave = port_direction("heave", DeformedShell(basis, study.centre_height))
    port = buoy_of(study).port(omega, design_motions(study, basis, "R"), heave)
    assert port.best_damping == pytest.approx([883448.0, 2.3202e5], rel=1e-3)
    assert port.impedance.real[0] == pytest.approx(4.9181e4, rel=1e-3)
    assert -omega[0] * port.impedance.imag[0] == pytest.approx(-5.7335e5, rel=1e-3)


def test_every_rung_is_paid_the_losses_of_its_own_take_off():
    """Power of damper and spring of each rung at the efficiency given, and no rung but the matched one without."""
    rng = np.random.default_rng(3)
    omega = 0.5 + 0.1 * np.arange(8)
    port, sea = random_port(rng, omega), Sea(omega, rng.rayleigh(size=len(omega)) + 0j)
    found = ladder({"A": port}, {"sea": sea}, [0], {"A": Given(2.0, 0.0, 0.8)}, 30.0)
    squares = np.abs(sea.amplitude[None]) ** 2
    for rung in (rung for rung in found if rung.rung != "matched"):
        damping, stiffness = np.array([rung.damping]), np.array([rung.stiffness])
        assert rung.power_mean == pytest.approx(mean_power(port, squares, damping, stiffness, 0.8)[0], rel=1e-9)


def test_the_best_force_moves_the_port_by_the_conjugate_of_its_admittance():
    """V0 - Y V0 / (2 Re Y) = V0 conj(Y) / (2 Re Y): half of the power the force takes is lost in the port."""
    omega, y, v = np.array([1.7]), np.array([0.4 - 0.9j]), np.array([0.6 + 0.2j])
    found = ladder(
        {"A": Port(omega, y, v, 1.0)}, {"w": Sea(omega, np.array([0.5 + 0j]))}, [0], {"A": Given(None)}, 10.0
    )
    (best,) = (rung for rung in found if rung.rung == "matched")
    assert best.force_peak == pytest.approx(0.5 * abs(v[0]) / 0.8, rel=1e-12)
    assert best.stroke_peak == pytest.approx(0.5 * abs(v[0] * y[0]) / 0.8 / 1.7, rel=1e-12)
    assert best.power_mean == pytest.approx(0.25 * abs(v[0]) ** 2 / 8 / 0.4, rel=1e-12)


# the optimum under limits --------------------------------------------------------------------------------------------


def oscillator(omega):
    """A passive buoy of one motion, at any frequencies."""
    y = 1 / (-1j * omega * 2.0 + 0.5 / (1 + omega**2) + 0.02 + 3j / omega)
    return Port(omega, y, y * (1.0 + 0.3j) * np.exp(-omega / 2), 1 / 3)


def sea_of_period(rng, spacing=0.05):
    """A sea that repeats."""
    omega = spacing * np.arange(12, 30)
    return Sea(omega, 0.1 * rng.rayleigh(size=len(omega)) * np.exp(2j * np.pi * rng.uniform(size=len(omega))))


def test_an_optimum_under_limits_that_do_not_bind_is_the_matched_one():
    for number in range(5):
        waves = sea_of_period(np.random.default_rng(number))
        rung = constrained_rung("A", "w", waves, oscillator, Limited(Limits(1e6, 1e6), 0.05, 3.0))
        port = oscillator(waves.omega)
        assert rung.power_mean == pytest.approx(waves.mean_of(port.matched_power), rel=1e-9)
        assert (rung.gap, rung.damping, rung.stiffness) == (pytest.approx(0.0, abs=1e-6), None, None)
        assert rung.limit_fraction == pytest.approx(1.0, rel=1e-9)
        force = port.matched_force * waves.amplitude
        assert rung.force_rms == pytest.approx(np.linalg.norm(force) / np.sqrt(2), rel=1e-9)


def test_an_optimum_under_limits_takes_at_least_what_any_damper_within_them_takes():
    """Dampers whose force and stroke keep the limits at every instant of the sea's period."""
    time = np.linspace(0.0, 2 * np.pi / 0.05, 4001)
    for number in range(5):
        rng = np.random.default_rng(number)
        waves = sea_of_period(rng)
        port, within, turning = oscillator(waves.omega), [], np.exp(-1j * np.outer(time, waves.omega))
        free = np.abs((turning @ (port.velocity * waves.amplitude / (-1j * waves.omega))).real).max()
        limits = Limits(0.3 * rng.uniform(0.5, 2.0), 1.02 * free)
        rung = constrained_rung("A", "w", waves, oscillator, Limited(limits, 0.05, 3.0))
        for damper in np.geomspace(1e-3, 1e2, 60):
            velocity = port.velocity_under(port.load(damper)) * waves.amplitude
            force, stroke = (turning @ (damper * velocity)).real, (turning @ (velocity / (-1j * waves.omega))).real
            if np.abs(force).max() <= limits.force and np.abs(stroke).max() <= limits.stroke:
                within.append(waves.mean_of(port.power(damper)))
        assert len(within) > 5
        bound = rung.power_mean / (1 - rung.gap)
        assert rung.power_mean >= max(within) * (1 - REFINED)
        assert max(within) <= bound < waves.mean_of(port.matched_power)
        assert rung.force_peak <= limits.force * (1 + 1e-8)
        proven = f"no force within the limits, of any harmonics, absorbs more than {bound:.4g} W"
        assert rung.note.startswith(f"{rung.power_mean:.4g} W found; {proven}")


@pytest.mark.parametrize(
    ("limits", "omega", "wrong"),
    [
        (
            Limited(Limits(1e-6, 1e-6), 0.05, 3.0),
            0.05 * np.arange(12, 30),
            r"no force within force_limit keeps stroke_limit in ",
        ),
        (Limited(Limits(1.0, 1.0), 0.05, 3.0), np.array([1.0, 1.013, 1.1]), r"which never repeat"),
        (
            Limited(Limits(1.0, 1.0), 0.001, 3.0),
            0.001 * np.arange(500, 502),
            r"a force of 3000 harmonics has no optimum in .* 1024",
        ),
    ],
)
def test_an_optimum_that_is_not_known_is_a_row_that_says_why(limits, omega, wrong):
    rung = constrained_rung("A", "w", Sea(omega, np.ones(len(omega), dtype=complex)), oscillator, limits)
    assert re.search(wrong, rung.note)
    assert rung[3:11] == (None,) * 8
    (check,) = constrained_checks([rung])
    assert (check.verdict, check.design, check.wave) == ("doubt", "A", "w")
    assert check.explanation == f"no optimum: {rung.note}"
    assert as_csv([rung]).splitlines()[1] == "A,w,constrained,,,,,,,,,,"


def test_the_proof_of_an_optimum_stands_in_the_ledger():
    rung = constrained_rung(
        "A", "w", sea_of_period(np.random.default_rng(1)), oscillator, Limited(Limits(0.2, 1e6), 0.05, 3.0)
    )
    (check,) = constrained_checks([rung])
    assert (check.value, check.limit, check.verdict) == (rung.gap, 0.005, "ok")
    assert constrained_checks([rung._replace(gap=0.0051)])[0].verdict == "doubt"
    proved, other = constrained_checks([rung._replace(gap=0.0), rung._replace(rung="matched"), rung])
    assert (proved.value, proved.verdict, other) == (0.0, "ok", check)
    said = "distance of the best force found from the bound of every force within the limits"
    assert check.explanation == f"{said}: {rung.note}"


def test_no_take_off_gets_anything_at_a_port_that_cannot_move():
    def still(omega):
        return Port(omega, np.zeros(len(omega), dtype=complex), np.zeros(len(omega), dtype=complex), 0.0)

    rung = constrained_rung(
        "A", "w", sea_of_period(np.random.default_rng(1)), still, Limited(Limits(0.2, 1.0), 0.05, 3.0)
    )
    nothing = (0.0, None, 0.0, 0.0, 0.0, 0.0, "waves do not move this port")
    assert rung[:12] == ("A", "w", "constrained", None, None, *nothing)


@pytest.mark.parametrize(
    ("highest", "said"),
    [
        (1.024, "waves do not move this port"),
        (
            1.025,
            "a force of 1025 harmonics has no optimum in reasonable time, needs at most 1024; "
            "lower simulation.duration or hydro.omega_max",
        ),
    ],
)
def test_an_optimum_has_a_thousand_harmonics_at_most(highest, said):
    def still(omega):
        return Port(omega, np.zeros(len(omega), dtype=complex), np.zeros(len(omega), dtype=complex), 0.0)

    sea = Sea(0.001 * np.arange(500, 502), np.ones(2, dtype=complex))
    assert constrained_rung("A", "w", sea, still, Limited(Limits(0.2, 1.0), 0.001, highest)).note == said


# ports of real studies -----------------------------------------------------------------------------------------------

GRID = 0.1 * np.arange(1, 46)
"""Frequencies of all seas below, and of what is known of the ports [rad/s]."""
EXTENDED = 0.1 * np.arange(1, 350)
"""They and those at which the losses of a force are looked at."""
PORTS = ("heave", "ring", "between", "volume", "chamber")


@pytest.fixture(scope="module")
def water(seed):
    """Coefficients of the seed's sphere, which all materials, clamps and ports share."""
    study = varied(seed, modes={"degree": 4}, hydro={"omega_max": 5.0})
    (block,) = StudyPlan(study).sweep_blocks
    found = converged_on_grid(spectral_problem(block), list(block.omega), block.tolerance, block.interpolation)
    raw = database.with_symmetrized(database.with_excitation(found))
    count = raw.sizes["influenced_dof"]
    coefficients = LinearBuoy(raw, np.zeros((count, count)), LinearPto(0.0)).coefficients(
        np.minimum(EXTENDED, GRID[-1])
    )
    return study, ShapeWater(displacements(raw.influenced_dof.values), EXTENDED, coefficients)


def random_study(study, number):
    """A shell of another material, with another clamp, port and spring."""
    rng, kind = np.random.default_rng(number), PORTS[number % len(PORTS)]
    one, other = rng.uniform(0, 180, 2)
    ring = {"direction": str(rng.choice(["vertical", "radial"])), "against": str(rng.choice(["sea_bed", "frame"]))}
    port = {"ring": {"colatitude": one, **ring}, "between": {"between": [one, other]}, "chamber": "volume"}
    device = {"young_modulus": 10 ** rng.uniform(6.5, 9), "thickness": rng.uniform(0.005, 0.03)}
    device |= {"damping": {"alpha": 0.0, "beta": 10 ** rng.uniform(-4, -2)}}
    device |= {"gas": {"adiabatic_index": 1.4}} if kind == "chamber" else {}
    designs = {"FSB": {"flexible": False}, "free": {}, "clamped": {"clamp": float(rng.choice([0.0, 90.0, 180.0]))}}
    return varied(study, device=device, designs=designs, pto={"port": port.get(kind, kind)})


def random_seas(rng):
    """A regular wave and two seas that repeat."""
    waves = [GRID[[rng.integers(5, 40)]], *(GRID[k : k + rng.integers(5, 20)] for k in rng.integers(5, 25, 2))]
    amplitudes = [0.1 * rng.rayleigh(size=len(w)) * np.exp(2j * np.pi * rng.uniform(size=len(w))) for w in waves]
    return {f"sea{i}": Sea(w, a) for i, (w, a) in enumerate(zip(waves, amplitudes, strict=True))}


def at(port, omega):
    """The port at some of its frequencies."""
    kept = np.searchsorted(EXTENDED, omega - 1e-9)
    return Port(omega, port.admittance[kept], port.velocity[kept], port.compliance)


def dampers_within(port, sea, limits):
    """Mean power of those of many dampers that keep the limits at every instant of a long time [W]."""
    here, time = at(port, sea.omega), np.linspace(0.0, 20 * np.pi, 1201)
    turning, dampers = np.exp(-1j * np.outer(sea.omega, time)), np.geomspace(1e-3, 1e3, 61) * here.best_damping.mean()
    velocity = here.velocity_under(here.load(dampers)) * sea.amplitude
    force = np.abs((dampers[:, None] * velocity @ turning).real).max(axis=1)
    stroke = np.abs((velocity / (-1j * sea.omega) @ turning).real).max(axis=1)
    between = 1 + (sea.omega[-1] * time[1]) ** 2 / 8  # of a sine at most
    kept = (between * force <= limits.force) & (between * stroke <= limits.stroke)
    return here.power(dampers[kept]) @ np.abs(sea.amplitude) ** 2


def check_order(water, number):
    """All rungs of a random study in their order, the optimum under limits among them; how many of these are known."""
    (study, shared), rng, known = water, np.random.default_rng(10_000 + number), 0
    study = random_study(study, number)
    extended, seas = design_ports(study, reference_shell(study), shared), random_seas(rng)
    ports = {design: at(port, GRID) for design, port in extended.items()}
    omega = frequencies(list(seas.values()))
    softest = max(port.softest_spring for port in ports.values())
    sizes = [size for port in ports.values() if (size := float(np.median(port.best_damping)))]
    given = Given(np.median(sizes) * 10 ** rng.uniform(-2, 2), rng.uniform(-0.9, 1.0) * abs(softest))
    rungs = ladder({d: at(p, omega) for d, p in ports.items()}, seas, [0, 1, 2], dict.fromkeys(ports, given), 60.0)
    for design, wave in itertools.product(ports, seas):
        power = {r.rung: r.power_mean for r in rungs if (r.design, r.wave) == (design, wave)}
        up = [power[name] for name in ("fixed", "best_damper", "best_spring_damper", "matched")]
        assert all(a <= b * (1 + 1e-9) + 1e-12 for a, b in itertools.pairwise(up)), (number, design, wave, up)
        assert power["best_damper_all_seas"] <= power["best_damper"] * (1 + 1e-9) + 1e-12
        peaks = {r.rung: r.force_peak for r in rungs if (r.design, r.wave) == (design, wave)}
        force = peaks["best_damper"] * 10 ** rng.uniform(-1.5, 0.5) or 1.0
        limits = Limits(force, np.inf)
        seen = partial(at, extended[design])
        best = constrained_rung(design, wave, seas[wave], seen, Limited(limits, GRID[0], GRID[-1]))
        assert best.power_mean is not None, (number, design, wave, best.note)
        assert best.power_mean <= power["matched"] * (1 + 1e-9) + 1e-12
        if ports[design].moves:
            within = dampers_within(ports[design], seas[wave], limits)
            assert best.power_mean >= within.max(initial=0.0) * (1 - REFINED), (number, design, wave)
            assert within.max(initial=0.0) <= best.power_mean / (1 - best.gap), (number, design, wave)
            known += within.size > 0
            free = peaks["matched"] <= 0.99 * limits.force
            assert not free or best.power_mean == pytest.approx(power["matched"], rel=1e-6)
    return known


@pytest.mark.parametrize("start", range(0, 40, 10))
def test_the_rungs_of_real_ports_are_in_order_with_the_optimum_under_limits(water, start):
    assert sum(check_order(water, number) for number in range(start, start + 10)) > 20


# held-back studies, a second method ----------------------------------------------------------------------------------

HELD_BACK = {
    "stiff, clamped, shallow": ({"radius": 3.3, "young_modulus": 7e7, "thickness": 0.02}, {"clamp": 40}, 9.0),
    "small, soft, clamped twice": ({"radius": 1.1, "young_modulus": 6e6}, {"clamp": [0, 120]}, np.inf),
    "large, rigid, shallow": ({"radius": 4.0, "thickness": 0.05}, {"flexible": False}, 6.0),
}


def held_back(seed, name):
    """Its linear buoy straight from the solver, the motions its design allows, and frequencies that are solved."""
    device, design, depth = HELD_BACK[name]
    device = {**device, "mass": 2 / 3 * np.pi * device["radius"] ** 3 * 1025.0}
    band = {"omega_max": round(6.0 / np.sqrt(device["radius"]), 1)}
    study = varied(
        seed, device=device, designs={"D": design}, water={"depth": depth}, hydro=band, modes={"degree": 3}, pto={}
    )
    (block,) = StudyPlan(study).sweep_blocks
    found = converged_on_grid(spectral_problem(block), list(block.omega), block.tolerance, block.interpolation)
    raw = database.with_symmetrized(database.in_modes(database.with_excitation(found), study_basis(study)))
    ds, basis = database.with_structure(raw, reference_shell(study)), study_basis(study)
    inside = np.flatnonzero(ds.omega.values > 0.15 * ds.omega.values[-1])
    return LinearBuoy(ds, basis.damping, LinearPto(0.0)), design_motions(study, basis, "D"), inside[:: len(inside) // 9]


def written_out(buoy, motions, kept, squares):
    """Mean power over damper and spring in the matrices of the whole equation of motion, by a dense solve of each."""
    ds, heave = buoy.database, np.eye(len(buoy.mass))[0]
    omega = ds.omega.values[kept]
    w = omega[:, None, None]
    still = -(w**2) * (buoy.mass + ds.added_mass.values[kept]) + buoy.stiffness
    still = still - 1j * w * (ds.radiation_damping.values[kept] + buoy.structural_damping)
    along, push = np.outer(heave, heave), ds.excitation_force.values[kept, 0]

    def power(damping, stiffness):
        whole = motions.T @ (still + (stiffness - 1j * w * damping) * along) @ motions
        moved = np.linalg.solve(whole, (push @ motions)[..., None])[..., 0] @ motions.T @ heave
        return float(0.5 * damping * np.sum(squares * omega**2 * np.abs(moved) ** 2))

    return power


@pytest.mark.parametrize("name", HELD_BACK)
def test_the_ladder_of_held_back_studies_by_a_second_method(seed, name):
    """Other radius, stiffness, clamps and depth: dense matrices and a simplex search, no port, within the tolerance."""
    buoy, motions, kept = held_back(seed, name)
    omega, rng = buoy.database.omega.values[kept], np.random.default_rng(len(name))
    sea = Sea(omega, 0.1 * rng.rayleigh(size=len(omega)) + 0j)
    port = buoy.port(omega, motions, np.eye(len(buoy.mass))[0])
    given = float(3 * np.median(port.best_damping))
    rungs = {r.rung: r for r in ladder({"D": port}, {"sea": sea}, [0], {"D": Given(given)}, 60.0)}
    power = written_out(buoy, motions, kept, np.abs(sea.amplitude) ** 2)
    assert rungs["fixed"].power_mean == pytest.approx(power(given, 0.0), rel=1e-4)

    def searched(x):
        return -power(np.exp(x[0]), port.softest_spring + np.exp(x[1]))

    dampers = np.log(given) + np.linspace(-5, 3, 33)
    near = max(dampers, key=lambda u: power(np.exp(u), 0.0))
    fine = minimize_scalar(lambda u: -power(np.exp(u), 0.0), bounds=(near - 0.25, near + 0.25), method="bounded")
    assert rungs["best_damper"].power_mean == pytest.approx(-fine.fun, rel=1e-4)
    springs = np.log(-port.softest_spring) + np.linspace(-5, 2, 29)
    first = max((-searched((u, v)), u, v) for u in dampers for v in springs)
    pair = minimize(searched, first[1:], method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-12})
    assert rungs["best_spring_damper"].power_mean == pytest.approx(-pair.fun, rel=1e-4)


@pytest.mark.parametrize("highest", [None, 2.5])
def test_an_optimum_has_the_band_that_is_solved(small, monkeypatch, highest):
    """All of it: the port is known from the first frequency of the database on, to the highest that waves may have."""

    class Asked(Exception):
        """The limits that an optimum is asked for."""

    def asked(design, label, sea, seen, limits):
        raise Asked(limits)

    monkeypatch.setattr("vsb.results.ladder.constrained_rung", asked)
    if highest:
        monkeypatch.setattr("vsb.results.ladder.band", lambda study, ds: (0.0, highest))
    limited = StudyPlan(varied(small.study, pto={"force_limit": 1.0e4, "stroke_limit": 2.0}))
    with pytest.raises(Asked) as caught:
        study_ladder(limited.ladder, small.database_path)
    omega = database.load_database(small.database_path, content_id(small.database)).omega.values
    assert caught.value.args[0] == Limited(Limits(1.0e4, 2.0), omega[0], highest or omega[-1])


def test_a_sea_counts_once_for_the_damper_of_all_seas_however_often_it_is_realised(small):
    def all_seas(**realised):
        sea = {"kind": "jonswap", "hs": 0.6, "tp": 4.0, **realised}
        study = varied(small.study, waves=[*small.study.model_dump()["waves"], sea])
        rungs = study_ladder(StudyPlan(study).ladder, small.database_path)
        return [rung.damping for rung in rungs if rung.rung == "best_damper_all_seas"]

    once, often = all_seas(), all_seas(realisations=3)
    assert (len(once), len(often)) == (4, 8)
    assert sorted(set(often)) == pytest.approx(sorted(set(once)), rel=1e-6)
    assert len(set(once)) == 2  # one of each design


def test_an_optimum_is_that_of_the_port_in_waves_of_its_own_direction(small, monkeypatch):
    asked, moving, towards = {}, {}, Afloat.towards

    def rung(design, label, sea, seen, limits):
        asked[design, label] = seen.func.__self__
        moving[design] = seen.keywords
        return Rung(design, label, "constrained", *[None] * 8)

    monkeypatch.setattr("vsb.results.ladder.constrained_rung", rung)
    monkeypatch.setattr(Afloat, "towards", lambda self, wave: replace(towards(self, wave), pto=LinearPto(wave.period)))
    swell = small.study.model_dump()["waves"][0]
    waves = [swell, {**swell, "period": 1.5 * swell["period"]}]
    study = varied(small.study, waves=waves, pto={"force_limit": 1.0e4})
    study_ladder(StudyPlan(study).ladder, small.database_path)
    periods = {wave.label: wave.period for wave in study.waves}
    assert {key: motion.pto.damping for key, motion in asked.items()} == {
        (design, label): period for design in study.designs for label, period in periods.items()
    }
    floating = afloat(StudyPlan(study).ladder, small.database_path)
    for design, given in moving.items():
        assert given.keys() == {"motions", "direction"}
        np.testing.assert_array_equal(given["motions"], floating.motions[design])
        np.testing.assert_array_equal(given["direction"], floating.port)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("omega", [[2.0], [1.0, 1.3, 1.7, 2.4]])
def test_a_peak_is_the_largest_size_crest_or_trough(sign, omega):
    """Components in phase at the beginning add up there, upwards or downwards; nowhere is there more."""
    sea = Sea(np.array(omega), np.ones(len(omega), dtype=complex))
    phasors = sign * np.array([np.arange(1.0, len(omega) + 1), np.full(len(omega), 3.0)]) + 0j
    assert _peaks(sea, phasors, 40.0) == pytest.approx(np.abs(phasors).sum(axis=1), rel=1e-12)


def test_beside_drag_each_sea_has_its_own_best_damper_or_what_is_known_to_be_better(monkeypatch):
    """Searches that find little, of which each sea takes what is best of all it knows; springs start from there."""
    port = Buoy(3).port
    waves, given, asked = dragged_seas(port.port.omega), Given(2.0, -0.05, 0.8), []

    def damper(of, squares, stiffness, efficiency):
        asked.append((len(squares), stiffness, efficiency))
        return 0.9 if len(squares) == 2 else 40.0 if np.ptp(squares) else 0.4  # far too much but of the flat sea

    def pair(of, squares, known, efficiency):
        asked.append((squares.tolist(), float(known.damping[0]), efficiency))
        return Load(known.damping + 1.0, known.stiffness - 0.1, known.power + 3.0)

    monkeypatch.setattr("vsb.results.ladder.best_damper", damper)
    monkeypatch.setattr("vsb.results.ladder.best_pair", pair)
    found = dragged_rungs(port, waves, [0, 2], given)
    assert list(found) == ["fixed", "best_damper", "best_damper_all_seas", "best_spring_damper"]
    fixed, one = (under(port, waves, c, -0.05, 0.8) for c in (2.0, 0.9))
    for name, load in (("fixed", fixed), ("best_damper_all_seas", one)):
        for got, expected in zip(found[name], load, strict=True):
            assert got == pytest.approx(expected, rel=1e-12), name
    for i, here in enumerate(waves[:, None]):
        own = under(port, here, 40.0 if i < 2 else 0.4, -0.05, 0.8)
        known = {load.power[k]: load.damping[k] for load, k in ((own, 0), (one, i), (fixed, i))}
        assert found["best_damper"].power[i] == pytest.approx(max(known))
        assert found["best_damper"].damping[i] == known[max(known)]
        assert found["best_spring_damper"].power[i] == pytest.approx(max(known) + 3.0)
    assert asked[0] == (2, -0.05, 0.8)
    assert asked[1::2] == [(1, -0.05, 0.8)] * 3
    assert asked[2::2] == [
        (w.tolist(), c, 0.8) for w, c in zip(waves[:, None], found["best_damper"].damping, strict=True)
    ]
    assert "fixed" not in dragged_rungs(port, waves, [0], Given(None))


def test_beside_drag_forces_and_strokes_are_those_of_the_drag_that_settles_in_each_sea():
    """Of every load the drag of that sea under it; of the matched force none, which knows no drag."""
    dragged, rng = Buoy(3).port, np.random.default_rng(1)
    omega = dragged.port.omega
    seas = {"wave": Sea(omega[[9]], np.array([1.0 + 0j])), "sea": Sea(omega, 0.4 * rng.rayleigh(size=len(omega)) + 0j)}
    met = {"A": Met(dragged.port, squares(list(seas.values()), omega), [np.array([9]), np.arange(len(omega))])}
    for rung in rungs_of(met, seas, [0, 1], {"A": Given(2.0, 0.1)}, 60.0, {"A": dragged}):
        at, here = met["A"][2][list(seas).index(rung.wave)], seas[rung.wave]
        if rung.rung == "matched":
            port, force = dragged.port, dragged.port.matched_force
            velocity = port.velocity - port.admittance * force
        else:
            spectrum = squares([here], omega)
            load = np.array([rung.damping]), np.array([rung.stiffness])
            port = dragged.beside(dragged.settled(spectrum, *load)[0, 0])
            impedance = rung.damping + 1j * rung.stiffness / omega
            velocity = port.velocity / (1 + port.admittance * impedance)
            force = impedance * velocity
            assert rung.power_mean == pytest.approx(dragged.powers(spectrum, *load)[0, 0], rel=1e-6)
        amplitude = np.abs(here.amplitude)
        assert rung.force_rms == pytest.approx(np.sqrt(0.5 * np.sum(np.abs(force[at] * amplitude) ** 2)), rel=1e-6)
        if rung.wave == "wave":
            assert rung.stroke_peak == pytest.approx(abs(velocity[9]) / omega[9], rel=1e-6), rung.rung


def test_an_optimum_under_limits_is_told_with_its_own_force_stroke_and_share():
    """In waves of which the first harmonic of the force is the fourth."""
    waves, limits = sea_of_period(np.random.default_rng(2)), Limits(0.2, 1e6)
    harmonics = Harmonics.of_sea(waves.omega, 0.2, 3.0)
    assert harmonics.first == 4
    best = optimum_in_sea(oscillator(harmonics.port_omega), waves, harmonics, limits)
    rung = constrained_rung("A", "w", waves, oscillator, Limited(limits, 0.2, 3.0))
    told = (rung.power_mean, rung.force_rms, rung.force_peak, rung.stroke_peak, rung.gap)
    assert told == pytest.approx((best.power, best.force_rms, best.force_peak, best.stroke_peak, best.gap), abs=1e-12)
    assert abs(best.force_peak / best.stroke_peak - 1) > 0.1
    assert rung.limit_fraction == pytest.approx(best.power / waves.mean_of(oscillator(waves.omega).matched_power))
    proven = f"no force within the limits, of any harmonics, absorbs more than {best.bound:.4g} W"
    assert rung.note == f"{best.power:.4g} W found; {proven}"
    held = constrained_rung("A", "w", waves, oscillator, Limited(Limits(1e6, 0.5 * best.stroke_peak), 0.2, 3.0))
    assert re.search(r" W; between the instants limits are exceeded by up to [\d.]+ %$", held.note)


def test_the_take_off_of_a_study_is_that_of_its_ladder_and_lines_stand_by_design_sea_and_rung(small, monkeypatch):
    """Each design's own damper, spring and efficiency, peaks over the whole run; the optimum before the matched power."""
    asked = []

    def some(ports, seas, families, given, time, dragged):
        asked.append((families, given, time, dragged))
        return [
            Rung(d, w, name, *[None] * 8) for d in ports for w in seas for name in ("matched", "best_damper", "fixed")
        ]

    monkeypatch.setattr("vsb.results.ladder.rungs_of", some)
    seen = {}

    def constrained(design, wave, sea, port, limits):
        seen[design, wave] = port
        return Rung(design, wave, "constrained", *[None] * 8)

    monkeypatch.setattr("vsb.results.ladder.constrained_rung", constrained)
    swell = small.study.model_dump()["waves"][0]
    waves = [
        swell,
        {"kind": "jonswap", "hs": 0.6, "tp": 4.0, "realisations": 2},
        {**swell, "period": 1.3 * swell["period"]},
    ]
    dampers = {name: 1e3 * (i + 1) for i, name in enumerate(small.study.designs)}
    pto = {"damping": dampers, "stiffness": 300.0, "efficiency": 0.9, "force_limit": 1e4}
    study = varied(small.study, waves=[{"kind": "still"}, *waves], pto=pto)
    found = study_ladder(StudyPlan(study).ladder, small.database_path)
    labels = [wave.label for wave in study.waves[1:]]
    assert [(rung.design, rung.wave, rung.rung) for rung in found] == list(
        itertools.product(study.designs, labels, ("fixed", "best_damper", "constrained", "matched"))
    )
    given = {design: Given(damper, 300.0, 0.9) for design, damper in dampers.items()}
    assert asked == [([0, 1, 3], given, study.simulation.duration, None)]
    floating = afloat(StudyPlan(study).ladder, small.database_path)
    assert seen.keys() == set(itertools.product(study.designs, labels))
    for (design, _), port in seen.items():
        known = floating.towards(study.waves[1]).port(GRID[5:9], floating.motions[design], floating.port)
        np.testing.assert_array_equal(port(GRID[5:9]).admittance, known.admittance)
        np.testing.assert_array_equal(port(GRID[5:9]).velocity, known.velocity)


@pytest.mark.parametrize("drag", [None, {"heave": {"coefficient": 1.0, "area": 12.57}}])
def test_beside_drag_every_design_climbs_with_a_port_of_its_own(small, monkeypatch, drag):
    """Known in all seas of the ladder; without drag there is none."""
    asked = []
    monkeypatch.setattr("vsb.results.ladder.dragged_port", lambda of, floating, *given: (of.drag, *given))
    monkeypatch.setattr("vsb.results.ladder.rungs_of", lambda *given: asked.append(given[-1]) or [])
    waves = [*small.study.model_dump()["waves"], {"kind": "jonswap", "hs": 0.6, "tp": 4.0}]
    study = varied(small.study, waves=waves, drag=drag)
    assert study_ladder(StudyPlan(study).ladder, small.database_path) == []
    (ports,) = asked
    if drag is None:
        assert ports is None
        return
    assert list(ports) == list(study.designs)
    ds = database.load_database(small.database_path, content_id(small.database))
    pairs = [(wave, study_sea(study, wave, ds)) for wave in study.waves]
    for design, (given, name, known) in ports.items():
        assert (given, name) == (study.drag, design)
        assert known.keys() == {0.0}
        np.testing.assert_array_equal(known[0.0], headings(pairs)[0.0])


def test_each_sea_has_its_own_best_damper_or_what_is_known_to_be_better(monkeypatch):
    """Searches that find little: the damper given, or that of all seas, is taken where it is better; pairs start there."""
    rng, asked = np.random.default_rng(5), []
    omega = 0.5 + 0.1 * np.arange(8)
    port, waves, given = random_port(rng, omega), rng.uniform(0.0, 1.0, (3, 8)), Given(2.0, 0.3, 0.8)

    def taken(damping, some=waves):
        loads = np.full(len(some), damping), np.full(len(some), 0.3)
        return Load(*loads, mean_power(port, some, *loads, 0.8))

    tried = {c: taken(c).power for c in np.geomspace(1e-2, 1e2, 30)}
    weak, fair = min(tried, key=lambda c: tried[c][0]), 0.5

    def dampers(of, squares, stiffness, efficiency):
        asked.append((squares.tolist(), stiffness, efficiency))
        return taken(fair if len(squares) == 1 else weak, squares)

    def pairs(of, squares, known, efficiency):
        asked.append((squares.tolist(), known, efficiency))
        return known

    monkeypatch.setattr("vsb.results.ladder.best_dampers", dampers)
    monkeypatch.setattr("vsb.results.ladder.best_pairs", pairs)
    for damping in (None, 2.0, weak):
        asked.clear()
        found = linear_rungs(port, waves, [0, 2], given._replace(damping=damping))
        known = [taken(c).power for c in (weak, fair, *([damping] if damping else []))]
        assert found["best_damper"].power == pytest.approx(np.max(known, axis=0), rel=1e-12)
        assert found["best_damper_all_seas"].damping.tolist() == [fair] * 3
        assert ("fixed" in found) == (damping is not None)
        assert found["best_spring_damper"] is asked[-1][1] is found["best_damper"]
        assert asked[0] == ([pytest.approx(waves[[0, 2]].sum(axis=0))], 0.3, 0.8)
        assert asked[1] == (waves.tolist(), 0.3, 0.8)
        assert (asked[2][0], asked[2][2]) == (waves.tolist(), 0.8)
    fixed = linear_rungs(port, waves, [0], given)["fixed"]
    for got, expected in zip(fixed, taken(2.0), strict=True):
        assert got == pytest.approx(expected, rel=1e-12)


def test_every_design_has_its_own_take_off_and_its_own_frequencies():
    """Two designs at ports over other frequencies, one with a damper given, beside another spring, the other without."""
    rng = np.random.default_rng(8)
    omega = 0.5 + 0.1 * np.arange(8)
    sea = {"sea": Sea(omega[2:7], rng.rayleigh(size=5) + 0j)}
    ports = {"A": random_port(rng, omega), "B": random_port(rng, omega[2:])}
    given = {"A": Given(2.0, 0.1, 0.9), "B": Given(None, 0.2)}
    both = ladder(ports, sea, [0], given, 30.0)
    alone = [rung for name in ports for rung in ladder({name: ports[name]}, sea, [0], {name: given[name]}, 30.0)]
    assert both == alone
    assert next(rung.rung for rung in both if rung.design == "B") == "best_damper"
    assert {rung.stiffness for rung in both if rung.rung == "best_damper"} == {0.1, 0.2}


def test_peaks_are_looked_for_over_the_whole_time_eight_times_in_the_shortest_period(monkeypatch):
    asked = []
    monkeypatch.setattr(
        "vsb.results.ladder.superposed", lambda omega, phasors, at: asked.append(at) or np.zeros((len(at), 2))
    )
    omega = np.array([0.2, 0.3, 2.0])
    _peaks(Sea(omega, np.ones(3, dtype=complex)), np.ones((2, 3), dtype=complex), 50.0)
    (at,) = asked
    assert (at[0], at[-1]) == (0.0, 50.0)
    assert np.ptp(np.diff(at)) < 1e-9
    assert 0.9 * np.pi / 8 < at[1] <= np.pi / 8


def test_every_rung_takes_the_part_of_the_matched_power_of_its_own_sea_with_its_own_load():
    """Of three seas and two designs."""
    rng = np.random.default_rng(9)
    omega = 0.5 + 0.1 * np.arange(8)
    amplitudes = {"a": (0, 8), "b": (2, 5), "c": (5, 6)}
    seas = {name: Sea(omega[i:k], rng.rayleigh(size=k - i) + 0j) for name, (i, k) in amplitudes.items()}
    ports = {"A": random_port(rng, omega), "B": random_port(rng, omega)}
    found = ladder(ports, seas, [0, 1, 2], {"A": Given(2.0, 0.1), "B": Given(0.5, 0.1)}, 30.0)
    matched = {(rung.design, rung.wave): rung.power_mean for rung in found if rung.rung == "matched"}
    assert len(set(matched.values())) == 6
    for rung in found:
        waves = squares([seas[rung.wave]], omega)
        own = matched[rung.design, rung.wave]
        assert own == pytest.approx(float(waves[0] @ ports[rung.design].matched_power), rel=1e-12)
        assert rung.limit_fraction == pytest.approx(rung.power_mean / own, rel=1e-12)
        if rung.rung != "matched":
            load = np.array([rung.damping]), np.array([rung.stiffness])
            assert rung.power_mean == pytest.approx(mean_power(ports[rung.design], waves, *load, 1.0)[0], rel=1e-9)
            spring = rung.stiffness / omega
            velocity = ports[rung.design].velocity / (1 + ports[rung.design].admittance * (rung.damping + 1j * spring))
            force = np.abs((rung.damping + 1j * spring) * velocity) ** 2
            assert rung.force_rms == pytest.approx(np.sqrt(0.5 * float(waves[0] @ force)), rel=1e-9)


def test_every_design_has_drag_of_its_own(monkeypatch):
    """Beside dampers that are not searched for."""
    monkeypatch.setattr("vsb.results.ladder.best_damper", lambda *_: 1.5)
    monkeypatch.setattr("vsb.results.ladder.best_pair", lambda port, squares, known, efficiency: known)
    dragged = {"A": Buoy(3).port, "B": Buoy(4).port}
    omega, rng = dragged["A"].port.omega, np.random.default_rng(1)
    seas = {"wave": Sea(omega[[9]], np.array([1.0 + 0j])), "sea": Sea(omega, 0.4 * rng.rayleigh(size=len(omega)) + 0j)}
    places = [np.array([9]), np.arange(len(omega))]
    given = {"A": Given(2.0, 0.1), "B": Given(3.0, 0.1)}

    def rungs(*designs):
        met = {name: Met(dragged[name].port, squares(list(seas.values()), omega), places) for name in designs}
        return rungs_of(met, seas, [0, 1], given, 60.0, dragged)

    both = rungs("A", "B")
    assert both == rungs("A") + rungs("B")
    assert len({rung.power_mean for rung in both}) > len(both) // 2


def test_a_damper_of_nothing_is_given_and_has_its_rung(monkeypatch):
    """It takes nothing in any sea, beside drag as without."""
    rng = np.random.default_rng(8)
    omega = 0.5 + 0.1 * np.arange(8)
    found = linear_rungs(random_port(rng, omega), rng.uniform(0.0, 1.0, (3, 8)), [0, 1], Given(0.0))
    monkeypatch.setattr("vsb.results.ladder.best_damper", lambda *_: 1.5)
    monkeypatch.setattr("vsb.results.ladder.best_pair", lambda port, squares, known, efficiency: known)
    port = Buoy(3).port
    dragged = dragged_rungs(port, dragged_seas(port.port.omega), [0, 1], Given(0.0))
    for rungs in (found, dragged):
        assert rungs["fixed"].damping.tolist() == rungs["fixed"].power.tolist() == [0.0] * 3
        assert rungs["best_damper"].power.min() > 0


def test_two_waves_that_do_not_meet_in_the_time_looked_at_have_no_peak_of_both():
    """Opposed at the beginning, of nearly one frequency: within a second they are a tenth apart; one is its amplitude."""
    omega, ones = np.array([1.0, 1.1]), np.ones(2, dtype=complex)
    (peak,) = _peaks(Sea(omega, ones), np.array([[1.0 + 0j, -1.0]]), 1.0)
    assert peak == pytest.approx(np.cos(1.0) - np.cos(1.1), rel=1e-12)
    assert _peaks(Sea(omega[:1], ones[:1]), np.array([[-0.3 + 0.4j]]), 1.0) == pytest.approx([0.5])


def test_an_optimum_of_nothing_is_proved_where_waves_do_not_move_the_port():
    """0 W for sure; what is not known is in doubt, whatever stands before it."""
    still = Rung("A", "w", "constrained", None, None, 0.0, None, 0.0, 0.0, 0.0, 0.0, "waves do not move this port")
    unknown = Rung("B", "v", "constrained", *[None] * 8, "they never repeat")
    proved, doubted = constrained_checks([still, unknown])
    assert (proved.design, proved.wave, proved.value, proved.verdict) == ("A", "w", 0.0, "ok")
    assert (doubted.design, doubted.wave, doubted.verdict) == ("B", "v", "doubt")
