"""Errors of the shell modes left out: an independent computation, and intervals that contain the converged gain.

The gains are those of a separate multipole computation of the floating hemisphere with exact membrane and bending
energy, which shares no code with the package, each design at its optimal damping, to 0.05 points.
"""

import math

import numpy as np
import pytest
from conftest import varied

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.engine.waves.seas import Sea
from vsb.errors import ConvergenceError
from vsb.models import mode_convergence
from vsb.models.floating_system import BuoyOfShape, floating_system, port_in_seas
from vsb.models.mode_convergence import (
    MOST_FREQUENCIES,
    ModeConvergence,
    _Around,
    _solved_around,
    directed,
    powers_of_ports,
    sampled,
)
from vsb.models.rest import reference_shell
from vsb.pipeline.graph import StudyPlan
from vsb.results.budget import left_out_of_year, modes_left_out
from vsb.results.year import band_weights, frequencies
from vsb.stages.make import make
from vsb.stages.members import swept_shape
from vsb.study.sections import Modes

PERIODS = (2.5, 3.0, 3.06, 3.3, 5.0, 8.0)
MULTIPOLES = {  # degree of the full basis: gains of the free shell over the rigid buoy [%]
    6: (-68.6, 5.1, 20.1, 18.5, -18.0, -22.1),
    40: (-77.5, -10.7, 9.4, 26.1, -20.8, -25.0),
}
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}}
WAVES = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in PERIODS]


SURGING = {
    "device": {"centre_of_mass": -0.6, "ballast_inertia": 4e3, "ballast_yaw_inertia": 4e3},
    "mooring": [2e4, 2e4, 0, 0, 0, 0],
    "pto": {"port": "surge", "damping": None, "tuning": "each"},
}


def convergence(study, **options):
    return ModeConvergence(
        StudyPlan(study).ladder.spec["study"],
        [wave.realisation(study.hydro.omega_max, 60.0) for wave in study.waves],
        **options,
    )


def left_out(study):
    return modes_left_out(
        StudyPlan(study).ladder.spec["study"],
        [(wave, wave.realisation(study.hydro.omega_max, 60.0)) for wave in study.waves],
    )


def gains(powers, study):
    """Gains over the rigid design at optimal damping [%]."""
    rigid = powers[list(study.designs).index("FSB")]
    return {name: 100 * (power / rigid - 1)[:, 1] for name, power in zip(study.designs, powers, strict=True)}


@pytest.fixture(scope="module")
def vented(seed):
    return varied(seed, designs=DESIGNS, waves=WAVES)


@pytest.fixture(scope="module")
def converged(vented):
    return convergence(vented)


@pytest.mark.parametrize("degree", [6, 40])
def test_gains_of_the_full_basis_agree_with_independent_multipoles(vented, converged, degree):
    """Of the free shell; those of clamped ones are in `tests/models/test_rest.py`."""
    found = gains(converged.powers(Modes(basis="full", degree=degree)), vented)
    assert found["VSWEC"] == pytest.approx(MULTIPOLES[degree], abs=0.1)


def test_interval_of_a_truncated_basis_contains_the_converged_gain(vented, converged):
    """Of power and gain at the given and at the optimal damping; the interval is not needlessly wide."""
    modes = {"basis": "membrane", "degree": 6}
    study = varied(vented, modes=modes)
    found, before = left_out(study), converged.powers(Modes(**modes))
    rich = converged.powers_of_degree(converged.finer)
    rigid = before[list(study.designs).index("FSB")]
    for name, change in (("power", rich / before - 1), ("gain", 100 * (rich - before) / rigid)):
        low, high = (found[name].sel(end=end).values for end in ("low", "high"))
        assert np.all(low <= change + 1e-8)
        assert np.all(change <= high + 1e-8)
        flexible = [i for i, design in enumerate(study.designs) if design != "FSB"]
        assert np.median((high - low)[flexible] / np.abs(change)[flexible]) < 2.0
    assert not found.sel(design="FSB").power.values.any()


@pytest.mark.slow
def test_few_modes_suffice_about_an_equilibrium(seed):
    """Gains at 16.5 kPa and 2.5 s from the independent computation."""
    study = varied(
        seed, designs=DESIGNS, waves=WAVES[:1], reference_shape="equilibrium", device={"internal_pressure": 16500.0}
    )
    found = convergence(study)
    for degree, gain in {6: -9.60, 14: -9.65}.items():
        assert gains(found.powers_of_degree(degree), study)["VSWEC"][0] == pytest.approx(gain, abs=0.03)


def test_water_is_shared_by_buoys_of_one_shape_alone(seed):
    """A spring changes no shape; a softer wall changes that of an inflated buoy, and the depth the water around it."""

    def around(device=None, depth=np.inf, stiffness=0.0):
        study = varied(
            seed,
            device={"young_modulus": 40e6, "thickness": 0.015, "internal_pressure": 18e3} | (device or {}),
            reference_shape="equilibrium",
            modes={"basis": "full", "degree": 4},
            water={"depth": depth},
            pto={"stiffness": stiffness},
        )
        shape = reference_shell(study).shape
        return _Around.of(shape, study.water, 0, (Displacement("radial", 0),), (1.0, 2.0), 1e-4)

    assert around() == around(stiffness=5e3)
    assert hash(around()) == hash(around(stiffness=5e3))
    assert around() != around({"young_modulus": 39e6})
    assert around() != around(depth=8.0)


def test_sampled_seas_keep_their_energy():
    omega = np.linspace(0.2, 6.0, 400)
    amplitude = 0.05 * np.exp(-((omega - 1.3) ** 2) / 0.1) + 0j
    found = sampled([Sea(omega, amplitude), Sea(np.array([2.5]), np.array([0.1 + 0j]))])
    assert len(found.omega) <= MOST_FREQUENCIES + 1
    assert found.directions.tolist() == [0.0]
    assert found.squares[0].sum() == pytest.approx((amplitude.real**2).sum(), rel=1e-12)
    assert found.squares[1, 0, np.searchsorted(found.omega, 2.5)] == pytest.approx(0.01)
    mean = (found.squares[0, 0] @ found.omega) / found.squares[0].sum()
    assert mean == pytest.approx((amplitude.real**2 @ omega) / (amplitude.real**2).sum(), rel=2e-3)


def test_degrees_that_hold_all_that_yields_to_a_ring_leave_next_to_nothing_out(seed):
    """Of a thick stiff wall: what is beyond its degrees, nothing, was divided by nothing."""
    wall = {"thickness": 0.1, "young_modulus": 4e8, "density": 1000.0}
    study = varied(seed, device=wall, designs=CLAMPED, waves=WAVES[3:4], modes={"basis": "full", "degree": 42})
    assert np.abs(left_out(study).power).max() < 1e-2


def test_rigid_buoys_leave_no_modes_out(seed):
    assert not left_out(varied(seed, designs={"FSB": {"flexible": False}})).data_vars


TWO = {"ports": {"heave": "heave", "area": {"strain": "area"}}, "damping": None, "tuning": "each"}


@pytest.mark.parametrize(
    "pto",
    [
        {**TWO, "matrix": "diagonal"},
        pytest.param(TWO, marks=pytest.mark.slow),
        {"port": {"distributed": "membrane"}, "damping": None, "tuning": "each"},
    ],
)
def test_damper_matrices_have_an_interval_that_contains_the_powers_of_many_modes(seed, pto):
    """Of the optimal matrix, of a damper at each port, and of one spread over the shell."""
    study = varied(seed, pto=pto, designs={"VSWEC": {}}, waves=WAVES[3:4], modes={"basis": "full", "degree": 9})
    found, both = left_out(study).power, convergence(study)
    before, rich = (both.powers(Modes(basis="full", degree=n)) for n in (9, 60))
    change = np.divide(rich - before, before, out=np.zeros_like(before), where=before > 0)
    assert np.abs(change).max() > 1e-3
    assert np.all(found.sel(end="low").values <= change + 1e-9)
    assert np.all(change <= found.sel(end="high").values + 1e-9)


def test_in_shallow_water_modes_are_compared_to_the_degree_that_is_resolved(seed, monkeypatch):
    """A deep sphere at three diameters over the bed, where 128 points resolve neither 2 nor 1.5 times the degree."""
    study = varied(
        seed,
        device={"mass": 32500.0},
        water={"depth": 7.7},
        hydro={"omega_max": 6.0},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": 2.2}],
        modes={"basis": "full", "degree": 30},
    )
    enough = convergence(study).enough
    assert convergence(study).finer == 2 * enough
    monkeypatch.setattr(mode_convergence, "MOST_POINTS", 128)
    _solved_around.cache_clear()
    found = convergence(study)
    for factor in (2.0, 1.5):
        with pytest.raises(ConvergenceError):
            found._around(reference_shell(study).shape, math.ceil(factor * enough))
    assert found.finer == math.ceil(1.25 * enough)


CLAMPED = {"VSWEC90": {"clamp": 90}}
PLANAR = {
    "motion": "planar",
    "device": {"centre_of_mass": -0.5, "ballast_inertia": 5e3},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
    "mooring": [2e4, 0, 0, 0, 0, 0],
    "modes": {"basis": "full", "degree": 3},
    "hydro": {"omega_max": 6.0, "accept": ["kramers_kronig"]},
    "waves": [{"kind": "regular", "amplitude": 0.1, "period": 3.0, "direction": angle} for angle in (0.0, 180.0)],
}


FREE = {
    "motion": "free",
    "mooring": [[2e4, 5e3, 0, 0, 0, 0], [5e3, 1e4, 0, 0, 0, 1e3], *[[0] * 6] * 3, [0, 1e3, 0, 0, 0, 2e4]],
    "device": {**PLANAR["device"], "ballast_yaw_inertia": 5e3},
    "waves": [{"kind": "regular", "amplitude": 0.1, "period": 3.0, "direction": angle} for angle in (30.0, 90.0)],
}
"""A mooring that couples surge, sway and yaw."""


@pytest.mark.parametrize(
    ("port", "changes"),
    [
        pytest.param("pitch", {}, marks=pytest.mark.slow),
        ({"line_to": [20.0, -30.0], "line_from": [0.0, -1.5]}, {"designs": {"FSB": {"flexible": False}, **CLAMPED}}),
        ({"dofs": {"Surge": 1.0, "Membrane2c1": 0.5}}, FREE),
        pytest.param({"dofs": {"Sway": 1.0, "Bending2s1": 0.3}}, FREE, marks=pytest.mark.slow),
    ],
)
def test_powers_of_ports_that_turn_are_those_of_the_study(seed, port, changes, tmp_path):
    """In waves from several sides, between which an oblique line distinguishes, of the study's own degree."""
    study = varied(seed, **{**PLANAR, **changes}, pto={"port": port, "damping": None, "tuning": "each"})
    plan = StudyPlan(study, root=str(tmp_path))
    make(plan, plan.hydro_files.values())
    seas = [(wave, wave.realisation(study.hydro.omega_max, 60.0)) for wave in study.waves]
    floating = floating_system(study, plan.hydro_files["database"])
    found = ModeConvergence(plan.ladder.spec["study"], [directed(*one) for one in seas]).powers(study.modes)
    for i, design in enumerate(study.designs):
        port_seen, squares, _ = port_in_seas(floating, design, seas)
        assert found[i, :, 1] == pytest.approx(best_dampers(port_seen, squares).power, rel=2e-3)


@pytest.mark.slow
def test_interval_of_a_spheroid_contains_the_gain_of_more_modes(seed):
    """Gains of degree 16 from a separate Ritz and multipole computation."""
    waves = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (6.0, 4.0, 3.0, 2.5)]
    device = {"shape": {"spheroid": {"height": 3.0}}, "young_modulus": 3e7, "mass": 12880.529879718}
    study = varied(
        seed, device=device, designs={"FSB": {"flexible": False}, "VSWEC": {}}, waves=waves,
        modes={"basis": "full", "degree": 10}, hydro={"witness": "none"}, pto={"damping": None, "tuning": "each"},
    )  # fmt: skip
    before, found = (
        convergence(study).powers(study.modes),
        left_out(study).gain.sel(design="VSWEC", take_off="best_damper"),
    )
    gain = gains(before, study)["VSWEC"]
    assert gain == pytest.approx([-4.745, -2.833, 0.761, -1.948], abs=2e-3)
    more = np.array([-4.955, -3.005, 0.754, -2.109])
    assert np.all(gain + found.sel(end="low") - 2e-3 <= more)
    assert np.all(more <= gain + found.sel(end="high") + 2e-3)
    assert np.all(found.sel(end="high") - found.sel(end="low") < 1.0)


@pytest.mark.parametrize("changes", [{}, {"motion": "planar", **SURGING}])
def test_water_of_a_shape_and_a_database_give_a_clamped_design_the_same_port(seed, tmp_path, changes):
    """With the modes of its rings, which have no part in either; errors are of the same degrees of freedom."""
    designs = {"FSB": {"flexible": False}, "VSWEC90": {"clamp": 90}}
    study = varied(
        seed,
        modes={"basis": "full", "degree": 6},
        designs=designs,
        hydro={"omega_max": 5.0},
        waves=WAVES[:1],
        **changes,
    )
    plan, reference = StudyPlan(study, root=str(tmp_path)), reference_shell(study)
    make(plan, [plan.database.out])
    shared = BuoyOfShape(study, reference, swept_shape(study, reference.basis, str(tmp_path)))
    omega = np.linspace(1.0, 4.0, 7)
    at, stored = shared.at(omega), floating_system(study, plan.database.out).ports(omega)
    for design, port in at.ports().items():
        assert port.admittance == pytest.approx(stored[design].admittance, rel=1e-4), design
        assert port.velocity == pytest.approx(stored[design].velocity, rel=1e-4), design
    assert {one.error.excitation.shape for one in shared.errors(omega)} == {(len(omega), len(at.port))}


@pytest.mark.slow
def test_interval_of_a_year_contains_the_gain_of_many_modes(seed, tmp_path):
    omega = np.linspace(0.4, 3.0, 40)
    year = Climate.of_spectra(omega, jonswap_spectrum(omega, 1.0, 5.0, 1.0)[None], np.ones(1), "a sea")

    def computed(modes):
        study = varied(seed, modes=modes, designs=DESIGNS, hydro={"omega_max": 5.0})
        reference = reference_shell(study)
        buoy = BuoyOfShape(study, reference, swept_shape(study, reference.basis, str(tmp_path)))
        omega = frequencies(year, *buoy.band)
        squares = (year.mean_density @ band_weights(omega, year))[None]
        waves = buoy.at(omega).in_waves()
        ports = {design: seen.port for design, seen in waves.items()}
        gain = 100 * (
            powers_of_ports(ports, study.pto, squares)[:, 0, :2] / powers_of_ports(ports, study.pto, squares)[0, :, :2]
            - 1
        )
        return gain, left_out_of_year(study, buoy, year).gain

    gain, interval = computed({"basis": "membrane", "degree": 6})
    many, _ = computed({"basis": "full", "degree": 42})
    assert np.all(interval[0] == 0.0)
    assert np.all((gain + interval[:, :1])[1:] <= many[1:])
    assert np.all(many[1:] <= (gain + interval[:, 1:])[1:])
    assert np.all((gain - many)[1:, 1] > 0)  # more modes absorb less


@pytest.mark.slow
def test_about_an_equilibrium_the_rigid_design_depends_on_the_modes_through_its_shape(seed):
    study = varied(
        seed,
        device={"young_modulus": 40e6, "thickness": 0.015, "internal_pressure": 18e3},
        reference_shape="equilibrium",
        modes={"basis": "full", "degree": 6},
        designs={"FSB": {"flexible": False}, "VSWEC": {}},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.4}],
    )
    found = left_out(study).isel(wave=0)
    convergence = ModeConvergence(study, [study.waves[0].realisation(12.0, 0.0)])
    poor, rich = (convergence.powers(Modes(basis="full", degree=n))[:, 0] for n in (6, 20))
    power, gain = rich / poor - 1, 100 * (rich[1] / rich[0] - poor[1] / poor[0])
    assert np.abs(power[0]).max() > 1e-5
    assert not found.gain.sel(design="FSB").any()  # over itself
    for bounds, value in ((found.power, power), (found.gain.sel(design="VSWEC"), gain)):
        assert np.all(bounds.sel(end="low") <= value)
        assert np.all(value <= bounds.sel(end="high"))


def test_interval_of_a_clamped_shell_that_pitches_contains_the_powers_of_many_modes(seed):
    """Its half-width is three times the error at most."""
    study = varied(
        seed,
        **{**SURGING, "motion": "planar", "pto": {**SURGING["pto"], "port": "pitch"}},
        designs={"FSB": {"flexible": False}, "CLAMPED": {"clamp": 75}},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 4.0)],
        modes={"basis": "full", "degree": 14, "tolerance": 0.1},
    )
    found, bounds = convergence(study), left_out(study).power.sel(design="CLAMPED", take_off="best_damper").values
    few, many = (found.powers(Modes(basis="full", degree=n), 42)[1, :, 1] for n in (14, 42))
    change = many / few - 1
    assert np.all((bounds[:, 0] <= change) & (change <= bounds[:, 1]))
    assert np.ptp(bounds, axis=1).max() < 6 * np.abs(change).max()


def test_interval_of_a_shell_clamped_at_a_ring_contains_the_powers_of_many_modes(seed):
    """Bending about the clamp takes part from degree 28 on."""
    study = varied(
        seed,
        device={"young_modulus": 9.16e8, "thickness": 0.0084, "density": 1100.0},
        designs={"FSB": {"flexible": False}, "CLAMPED": {"clamp": 97.5}},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 3.0, 3.5, 5.0)],
        modes={"basis": "full", "degree": 6},
    )
    found = convergence(study)
    powers = {n: found.powers(Modes(basis="full", degree=n))[1] for n in (6, 60)}
    bounds = left_out(study).power.sel(design="CLAMPED")
    change = powers[60] / powers[6] - 1
    assert np.all(bounds.sel(end="low") <= change)
    assert np.all(change <= bounds.sel(end="high"))
