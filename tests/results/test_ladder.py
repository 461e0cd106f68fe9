"""Control levels from fixed to matched: order, closed forms, constrained optima, independent computations."""

import csv
import io
import itertools

import numpy as np
import pytest
from conftest import varied
from motion.test_drag import Buoy
from scipy.optimize import minimize, minimize_scalar

from vsb.engine.hydro import database
from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.spectral.solver import SpectralProblem, converged_on_grid
from vsb.engine.motion.constrained import REFINED
from vsb.engine.motion.force_bound import Limits
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto, Port, port_direction
from vsb.engine.motion.tuning import frequencies, mean_power, squares
from vsb.engine.shell.deformed import rigid_sphere
from vsb.engine.waves.seas import Sea
from vsb.models.floating_system import FloatingSystem, PortInSeas
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.pipeline.graph import StudyPlan
from vsb.results.budget import NUMERICAL
from vsb.results.ladder import (
    Given,
    as_csv,
    constrained_level,
    levels_of,
    material_checks,
    material_levels,
    matrix_levels,
    study_ladder,
)
from vsb.stages.water import spectral_problem
from vsb.study.study import parse


def ladder(ports, seas, families, given, time, dragged=None):
    """Control levels of every design in every sea of one direction."""
    waves = list(seas.values())
    met = {
        design: PortInSeas(port, squares(waves, port.omega), [np.searchsorted(port.omega, one.omega) for one in waves])
        for design, port in ports.items()
    }
    return levels_of(met, seas, families, given, time, dragged)


def random_port(rng, omega):
    """A passive port with two resonances."""
    mass, loss, stiffness = 10 ** rng.uniform(-1, 1, (3, 2))
    y = sum(1 / (-1j * omega * m + b + 1j * k / omega) for m, b, k in zip(mass, loss, stiffness, strict=True))
    return Port(omega, y, rng.normal(size=len(omega)) + 1j * rng.normal(size=len(omega)), float(np.sum(1 / stiffness)))


def test_power_does_not_decrease_along_the_control_levels():
    for number in range(0, 50, 5):
        rng = np.random.default_rng(number)
        seas = {}
        for name in "abcd":
            omega = rng.uniform(0.4, 2.0) + 0.1 * np.arange(rng.integers(1, 12))
            seas[name] = Sea(omega, rng.rayleigh(size=len(omega)) * np.exp(2j * np.pi * rng.uniform(size=len(omega))))
        omega = frequencies(list(seas.values()))
        ports = {"A": random_port(rng, omega), "B": random_port(rng, omega)}
        spring = rng.uniform(-0.9, 2.0) / max(port.compliance for port in ports.values())
        given = dict.fromkeys(ports, Given(10 ** rng.uniform(-2, 2), spring, 0.8 if number % 10 == 0 else 1.0))
        levels = {(r.design, r.wave, r.rung): r for r in ladder(ports, seas, [0, 1, 3], given, 30.0)}
        assert len(levels) == 2 * 4 * 5
        for design in ports:
            for wave in seas:
                power = {level: r.power_mean for (d, w, level), r in levels.items() if (d, w) == (design, wave)}
                up = [power[name] for name in ("fixed", "best_damper", "best_spring_damper", "matched")]
                assert all(a <= b * (1 + 1e-9) + 1e-12 for a, b in itertools.pairwise(up)), (number, up)
                assert power["best_damper_all_seas"] <= power["best_damper"] * (1 + 1e-9) + 1e-12


def test_forces_and_strokes_are_those_of_the_realisation():
    """Against the sum of sines; in a regular wave exactly."""
    omega = np.array([1.0, 1.3])
    port = Port(omega, 1 / np.array([2.0 + 1j, 1.0 - 2j]), np.array([1.0 + 0.5j, 0.3j]), 1.0)
    seas = {"wave": Sea(omega[:1], np.array([0.5 + 0j])), "sea": Sea(omega, np.array([1.0 + 0j, 0.7j]))}
    found = {(r.wave, r.rung): r for r in ladder({"A": port}, seas, [0, 1], {"A": Given(3.0)}, 200.0)}
    velocity = port.velocity_under(port.load(3.0)) * seas["sea"].amplitude
    time = np.linspace(0, 200, 20001)
    force = np.real(3.0 * velocity @ np.exp(-1j * np.outer(omega, time)))
    stroke = np.real((velocity / (-1j * omega)) @ np.exp(-1j * np.outer(omega, time)))
    fixed = found["sea", "fixed"]
    assert fixed.force_peak == pytest.approx(np.abs(force).max(), rel=0.02)  # peaks are sampled eight times a period
    assert fixed.stroke_peak == pytest.approx(np.abs(stroke).max(), rel=0.02)
    assert fixed.force_rms == pytest.approx(np.sqrt(np.mean(force**2)), rel=0.02)
    assert fixed.power_mean == pytest.approx(np.mean(force**2) / 3.0, rel=0.03)
    alone = found["wave", "fixed"]
    assert alone.force_peak == pytest.approx(np.sqrt(2) * alone.force_rms, rel=1e-12)
    assert alone.stroke_peak == pytest.approx(alone.force_peak / 3.0, rel=1e-12)


def test_port_that_cannot_move_has_empty_cells():
    omega = np.ones(1)
    still = Port(omega, np.zeros(1, dtype=complex), np.zeros(1, dtype=complex), 0.0)
    text = as_csv(ladder({"A": still}, {"w": Sea(omega, np.ones(1, dtype=complex))}, [0], {"A": Given(None)}, 10.0))
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["rung"] for row in rows] == ["best_damper", "best_damper_all_seas", "best_spring_damper", "matched"]
    assert {(row["power_mean"], row["limit_fraction"], row["damping"]) for row in rows} == {("0", "", "")}


def test_optimal_dampings_of_wec_sims_control_example():
    """Half-submerged sphere of 10 m diameter: optimal dampings and the reactive pair, published to three digits."""
    omega = 2 * np.pi / np.array([9.6664, 3.5])
    ds = SpectralProblem(rigid_sphere(5.0, 0.0), (Displacement("heave"),), 1000.0, 9.81, 24).solve(omega.tolist())
    inertia, stiffness = 2 / 3 * np.pi * 5.0**3 * 1000.0 + ds.added_mass.values[:, 0, 0], 9810.0 * np.pi * 25.0
    impedance = ds.radiation_damping.values[:, 0, 0] + 1j * (stiffness / omega - omega * inertia)
    port = Port(omega, 1 / impedance, np.ones(2, dtype=complex), 1 / stiffness)
    assert port.best_damping == pytest.approx([883448.0, 2.3202e5], rel=1e-3)
    assert port.impedance.real[0] == pytest.approx(4.9181e4, rel=1e-3)
    assert -omega[0] * port.impedance.imag[0] == pytest.approx(-5.7335e5, rel=1e-3)


def test_matched_force_has_its_closed_form():
    """F = V0 / (2 Re Y), V = V0 conj(Y) / (2 Re Y), P = |V0|^2 / (8 Re Y)."""
    omega, y, v = np.array([1.7]), np.array([0.4 - 0.9j]), np.array([0.6 + 0.2j])
    found = ladder(
        {"A": Port(omega, y, v, 1.0)}, {"w": Sea(omega, np.array([0.5 + 0j]))}, [0], {"A": Given(None)}, 10.0
    )
    (best,) = (level for level in found if level.rung == "matched")
    assert best.force_peak == pytest.approx(0.5 * abs(v[0]) / 0.8, rel=1e-12)
    assert best.stroke_peak == pytest.approx(0.5 * abs(v[0] * y[0]) / 0.8 / 1.7, rel=1e-12)
    assert best.power_mean == pytest.approx(0.25 * abs(v[0]) ** 2 / 8 / 0.4, rel=1e-12)


def oscillator(omega):
    """A passive port at any frequencies."""
    y = 1 / (-1j * omega * 2.0 + 0.5 / (1 + omega**2) + 0.02 + 3j / omega)
    return Port(omega, y, y * (1.0 + 0.3j) * np.exp(-omega / 2), 1 / 3)


def test_constrained_optimum_absorbs_at_least_as_much_as_any_damper_within_the_limits():
    """Dampers whose force and stroke stay within the limits over the whole period of the sea."""
    time = np.linspace(0.0, 2 * np.pi / 0.05, 4001)
    for number in (0, 2):
        rng = np.random.default_rng(number)
        omega = 0.05 * np.arange(12, 30)
        waves = Sea(omega, 0.1 * rng.rayleigh(size=len(omega)) * np.exp(2j * np.pi * rng.uniform(size=len(omega))))
        port, within, turning = oscillator(waves.omega), [], np.exp(-1j * np.outer(time, waves.omega))
        free = np.abs((turning @ (port.velocity * waves.amplitude / (-1j * waves.omega))).real).max()
        limits = Limits(0.3 * rng.uniform(0.5, 2.0), 1.02 * free)
        level = constrained_level("A", "w", waves, oscillator, limits, (0.05, 3.0))
        for damper in np.geomspace(1e-3, 1e2, 60):
            velocity = port.velocity_under(port.load(damper)) * waves.amplitude
            force, stroke = (turning @ (damper * velocity)).real, (turning @ (velocity / (-1j * waves.omega))).real
            if np.abs(force).max() <= limits.force and np.abs(stroke).max() <= limits.stroke:
                within.append(waves.mean_of(port.power(damper)))
        assert len(within) > 5
        bound = level.power_mean / (1 - level.gap)
        assert level.power_mean >= max(within) * (1 - REFINED)
        assert max(within) <= bound < waves.mean_of(port.matched_power)
        assert level.force_peak <= limits.force * (1 + 1e-8)


def test_power_within_limits_is_ordered_with_expectations_whatever_the_run(small):
    """A limit of force above every peak leaves the matched power, that of the spectrum; a lower one takes some of it."""
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 4.0}
    power = {}
    run = {"duration": 40.0, "window": [20.0, 40.0]}
    data = small.study.model_dump() | {"waves": [sea], "designs": {"FSB": {"flexible": False}}, "simulation": run}
    for limit in (1e7, 2e3):
        plan = StudyPlan(parse(data | {"pto": {"damping": 8e3, "force_limit": limit}}))
        levels = {one.rung: one for one in study_ladder(plan.ladder.spec["study"], small.database.out)}
        power[limit] = levels["constrained"].power_mean
        matched = levels["matched"].power_mean
        assert levels["constrained"].limit_fraction == pytest.approx(power[limit] / matched, rel=1e-12)
    assert power[1e7] == pytest.approx(matched, rel=1e-4)
    assert power[2e3] < 0.9 * matched


STUDIES = {
    "small, soft, clamped twice": ({"radius": 1.1, "young_modulus": 6e6}, {"clamp": [0, 120]}, np.inf),
    "large, rigid, shallow": ({"radius": 4.0, "thickness": 0.05}, {"flexible": False}, 6.0),
}


def buoy_and_motions(seed, name):
    """Its linear buoy, the motions of its design, and some of the frequencies solved."""
    device, design, depth = STUDIES[name]
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
    return (
        LinearSystem(ds, basis.damping, LinearPto(0.0)),
        design_motions(study, basis, "D"),
        inside[:: len(inside) // 9],
    )


def dense_power(buoy, motions, kept, squares):
    """Function (damping, stiffness) -> mean power from dense solves of the equation of motion."""
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


@pytest.mark.parametrize("name", STUDIES)
def test_control_levels_agree_with_dense_solves_and_a_general_optimiser(seed, name):
    """Without the port: dense matrices and a simplex search."""
    buoy, motions, kept = buoy_and_motions(seed, name)
    omega, rng = buoy.database.omega.values[kept], np.random.default_rng(len(name))
    sea = Sea(omega, 0.1 * rng.rayleigh(size=len(omega)) + 0j)
    port = buoy.port(omega, motions, np.eye(len(buoy.mass))[0])
    given = float(3 * np.median(port.best_damping))
    levels = {r.rung: r for r in ladder({"D": port}, {"sea": sea}, [0], {"D": Given(given)}, 60.0)}
    power = dense_power(buoy, motions, kept, np.abs(sea.amplitude) ** 2)
    assert levels["fixed"].power_mean == pytest.approx(power(given, 0.0), rel=1e-4)

    def searched(x):
        return -power(np.exp(x[0]), port.softest_spring + np.exp(x[1]))

    dampers = np.log(given) + np.linspace(-5, 3, 33)
    near = max(dampers, key=lambda u: power(np.exp(u), 0.0))
    fine = minimize_scalar(lambda u: -power(np.exp(u), 0.0), bounds=(near - 0.25, near + 0.25), method="bounded")
    assert levels["best_damper"].power_mean == pytest.approx(-fine.fun, rel=1e-4)
    springs = np.log(-port.softest_spring) + np.linspace(-5, 2, 29)
    first = max((-searched((u, v)), u, v) for u in dampers for v in springs)
    pair = minimize(searched, first[1:], method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-12})
    assert levels["best_spring_damper"].power_mean == pytest.approx(-pair.fun, rel=1e-4)


def test_realisations_do_not_change_the_damper_of_all_seas():
    """A sea counts once, however many realisations it has."""
    rng, omega = np.random.default_rng(4), 0.5 + 0.1 * np.arange(8)
    port, sizes = random_port(rng, omega), rng.rayleigh(size=(2, 8))
    seas = {"swell": Sea(omega, sizes[0] + 0j)}
    seas |= {f"sea{k}": Sea(omega, sizes[1] * np.exp(1j * rng.uniform(0, 6, 8))) for k in range(3)}
    once = ladder({"A": port}, dict(list(seas.items())[:2]), [0, 1], {"A": Given(None)}, 10.0)
    often = ladder({"A": port}, seas, [0, 1], {"A": Given(None)}, 10.0)
    dampers = [{r.damping for r in levels if r.rung == "best_damper_all_seas"} for levels in (once, often)]
    assert dampers[0] == dampers[1]
    assert len(dampers[0]) == 1


def test_forces_with_drag_use_the_equivalent_damping_of_each_sea():
    """The matched force is that without drag."""
    dragged, rng = Buoy(3).port, np.random.default_rng(1)
    omega = dragged.port.omega
    seas = {"wave": Sea(omega[[9]], np.array([1.0 + 0j])), "sea": Sea(omega, 0.4 * rng.rayleigh(size=len(omega)) + 0j)}
    met = {"A": PortInSeas(dragged.port, squares(list(seas.values()), omega), [np.array([9]), np.arange(len(omega))])}
    for level in levels_of(met, seas, [0, 1], {"A": Given(2.0, 0.1)}, 60.0, {"A": dragged}):
        at, here = met["A"][2][list(seas).index(level.wave)], seas[level.wave]
        if level.rung == "matched":
            port, force = dragged.port, dragged.port.matched_force
            velocity = port.velocity - port.admittance * force
        else:
            spectrum = squares([here], omega)
            load = np.array([level.damping]), np.array([level.stiffness])
            port = dragged.beside(dragged.equivalent(spectrum, *load)[0, 0])
            impedance = level.damping + 1j * level.stiffness / omega
            velocity = port.velocity / (1 + port.admittance * impedance)
            force = impedance * velocity
            assert level.power_mean == pytest.approx(dragged.powers(spectrum, *load)[0, 0], rel=1e-6)
        amplitude = np.abs(here.amplitude)
        assert level.force_rms == pytest.approx(np.sqrt(0.5 * np.sum(np.abs(force[at] * amplitude) ** 2)), rel=1e-6)
        if level.wave == "wave":
            assert level.stroke_peak == pytest.approx(abs(velocity[9]) / omega[9], rel=1e-6), level.rung


def test_every_level_has_the_power_and_force_of_its_own_load():
    rng = np.random.default_rng(9)
    omega = 0.5 + 0.1 * np.arange(8)
    amplitudes = {"a": (0, 8), "b": (2, 5), "c": (5, 6)}
    seas = {name: Sea(omega[i:k], rng.rayleigh(size=k - i) + 0j) for name, (i, k) in amplitudes.items()}
    ports = {"A": random_port(rng, omega), "B": random_port(rng, omega)}
    found = ladder(ports, seas, [0, 1, 2], {"A": Given(2.0, 0.1), "B": Given(0.5, 0.1)}, 30.0)
    matched = {(level.design, level.wave): level.power_mean for level in found if level.rung == "matched"}
    assert len(set(matched.values())) == 6
    for level in found:
        waves = squares([seas[level.wave]], omega)
        own = matched[level.design, level.wave]
        assert own == pytest.approx(float(waves[0] @ ports[level.design].matched_power), rel=1e-12)
        assert level.limit_fraction == pytest.approx(level.power_mean / own, rel=1e-12)
        if level.rung != "matched":
            load = np.array([level.damping]), np.array([level.stiffness])
            assert level.power_mean == pytest.approx(mean_power(ports[level.design], waves, *load, 1.0)[0], rel=1e-9)
            spring = level.stiffness / omega
            velocity = ports[level.design].velocity / (
                1 + ports[level.design].admittance * (level.damping + 1j * spring)
            )
            force = np.abs((level.damping + 1j * spring) * velocity) ** 2
            assert level.force_rms == pytest.approx(np.sqrt(0.5 * float(waves[0] @ force)), rel=1e-9)


def test_levels_of_a_damper_spread_over_the_shell_and_of_its_material(seed, spectral_seed):
    """Of a regular wave the material allows e m/T; of a rigid buoy, which does not move the port, nothing."""
    energy, omega = 0.5, np.array([1.5])
    study = varied(seed, pto={"port": {"distributed": "membrane"}, "damping": None, "tuning": "each"})
    study = varied(study, pto={"energy_per_cycle": energy})
    basis, spec = study_basis(study), StudyPlan(study).ladder.spec["study"]
    port = port_direction(study.pto.port, reference_shell(study).shape)
    motions = {design: design_motions(study, basis, design) for design in ("FSB", "VSWEC")}
    floating = FloatingSystem(spectral_seed, motions, port)
    seas = {"wave": Sea(omega, np.array([0.2 + 0j]))}
    levels = matrix_levels(spec, floating, seas, [0])[0]
    powers = {level.rung: level.power_mean for level in levels if level.design == "VSWEC"}
    assert powers["best_damper"] == pytest.approx(powers["best_damper_all_seas"], rel=1e-9)
    assert 0 < powers["best_damper"] < powers["matched"]
    (material,) = material_levels(spec, floating, seas, levels)
    allowed = energy * study.device.shell_mass * omega[0] / (2 * np.pi)
    assert (material.design, material.power_mean) == ("VSWEC", pytest.approx(allowed, rel=1e-9))
    (check,) = material_checks(study.pto, [*levels, material])
    assert check.value == pytest.approx(energy * powers["best_damper"] / allowed, rel=1e-12)


@pytest.mark.parametrize("limit", [np.inf, 300.0])
def test_causal_control_lies_between_damper_and_known_future_at_its_force(small, limit):
    """At the rms of the force limit, or of the optimal damper; regular waves have no such level."""
    sea, regular = {"kind": "jonswap", "hs": 0.5, "tp": 3.0}, {"kind": "regular", "amplitude": 0.1, "period": 3.0}
    data = small.study.model_dump() | {"waves": [sea, regular]}
    pto = {"tuning": "each", "force_limit": limit, "control": {"noise": 1e-6, "forecast": 0.5}}
    plan = StudyPlan(parse(data | {"pto": pto}))
    levels = study_ladder(plan.ladder.spec["study"], small.database.out)
    assert {level.wave for level in levels if level.rung == "causal"} == {plan.study.waves[0].label}
    for design in data["designs"]:
        by = {level.rung: level for level in levels if level.design == design and level.wave != "regular_A0.1_T3"}
        causal, damper = by["causal"], by["damper_same_force"]
        wanted = by["best_damper"].force_rms if np.isinf(limit) else limit
        assert (causal.force_rms, damper.force_rms) == pytest.approx((wanted, wanted), rel=1e-6)
        assert damper.power_mean < causal.power_mean < by["matched"].power_mean
        assert causal.low < causal.power_mean < causal.high
        assert (causal.noise, causal.forecast, damper.noise) == (1e-6, 0.5, None)
        assert causal.limit_fraction == pytest.approx(causal.power_mean / by["matched"].power_mean)
        assert causal.gain_error is None or NUMERICAL in [row["name"] for row in causal.gain_error]
    header, row = (
        line for line in as_csv(levels).splitlines() if "rung" in line or (",causal," in line and "FSB" in line)
    )
    assert header.endswith(",noise,forecast")
    assert row.endswith(",1e-06,0.5")


def test_several_ports_of_a_given_rms_force(small):
    """A rigid buoy, which moves one of them alone, has what that port has by itself."""
    data = small.study.model_dump() | {"waves": [{"kind": "jonswap", "hs": 0.5, "tp": 3.0}]}
    data["designs"] = {"FSB": {"flexible": False}, "VSWEC": {}}
    both = {"ports": {"heave": "heave", "top": {"colatitude": 0.0, "against": "frame"}}}
    plans = (StudyPlan(parse(data | {"pto": pto | {"control": {"force_rms": 300.0}}})) for pto in (both, {}))
    several, one = (
        {(level.design, level.rung): level for level in study_ladder(plan.ladder.spec["study"], small.database.out)}
        for plan in plans
    )
    for rung in ("damper_same_force", "causal"):
        for design in data["designs"]:
            assert several[design, rung].force_rms == pytest.approx(300.0, rel=1e-5)
            assert one[design, rung].force_rms == pytest.approx(300.0, rel=1e-5)
        assert several["FSB", rung].power_mean == pytest.approx(one["FSB", rung].power_mean, rel=1e-5)
        most = several["VSWEC", rung].power_mean * (1 + several["VSWEC", rung].numerical.size)
        assert most > one["VSWEC", rung].power_mean  # by less than the frequencies resolve where force is so scarce
    same, causal, best = (several["VSWEC", rung] for rung in ("damper_same_force", "causal", "best_damper"))
    assert same.power_mean < causal.power_mean
    assert same.power_mean < 0.5 * best.power_mean
    assert "damper matrix" in same.note


def test_causal_control_beside_drag_lies_between_damper_and_matched_power(small):
    sea, drag = {"kind": "jonswap", "hs": 0.5, "tp": 3.0}, {"heave": {"coefficient": 2.0, "area": 12.0}}
    data = small.study.model_dump() | {"waves": [sea], "pto": {"tuning": "each"}, "drag": drag}
    data["designs"] = {"VSWEC": {}}
    levels = study_ladder(StudyPlan(parse(data)).ladder.spec["study"], small.database.out)
    for design in data["designs"]:
        by = {level.rung: level for level in levels if level.design == design}
        assert by["damper_same_force"].power_mean == by["best_damper"].power_mean
        assert by["best_damper"].power_mean < by["causal"].power_mean < by["matched"].power_mean
        assert by["causal"].force_rms == pytest.approx(by["best_damper"].force_rms, rel=1e-6)
        assert by["causal"].low < by["causal"].power_mean < by["causal"].high
        assert "equivalent to it under this control" in by["causal"].note


def test_damper_is_the_causal_level_where_noise_hides_the_waves(small):
    data = small.study.model_dump() | {"waves": [{"kind": "jonswap", "hs": 0.5, "tp": 6.0}]}
    data["designs"] = {"FSB": {"flexible": False}}
    plan = StudyPlan(parse(data | {"pto": {"force_limit": 300.0, "control": {"noise": 0.5}}}))
    by = {level.rung: level for level in study_ladder(plan.ladder.spec["study"], small.database.out)}
    assert by["causal"].power_mean == by["damper_same_force"].power_mean
    assert by["causal"].damping == by["damper_same_force"].damping > 0
    assert "damper" in by["causal"].note


def test_causal_control_of_several_ports_lies_between_damper_matrix_and_matched_power(small):
    """A rigid buoy, which moves one of the ports alone, has the level that this port has by itself."""
    data = small.study.model_dump() | {"waves": [{"kind": "jonswap", "hs": 0.5, "tp": 3.0}]}
    both = {"ports": {"heave": "heave", "top": {"colatitude": 0.0, "against": "frame"}}}
    alone = data | {"pto": {"tuning": "each"}, "designs": {"FSB": {"flexible": False}}}
    several, one = (
        study_ladder(StudyPlan(parse(raw)).ladder.spec["study"], small.database.out)
        for raw in (data | {"pto": both}, alone)
    )
    assert {level.rung for level in several} >= {"damper_same_force", "causal", "best_diagonal"}
    for design in data["designs"]:
        by, own = ({level.rung: level for level in levels if level.design == design} for levels in (several, one))
        assert by["damper_same_force"].power_mean < by["causal"].power_mean < by["matched"].power_mean
        assert by["causal"].force_rms == pytest.approx(by["damper_same_force"].force_rms, rel=1e-6)
        assert by["causal"].low < by["causal"].power_mean < by["causal"].high
        if not small.study.designs[design].flexible:
            assert by["causal"].power_mean == pytest.approx(own["causal"].power_mean, rel=1e-5)
