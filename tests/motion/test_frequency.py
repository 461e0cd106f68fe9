"""Frequency domain: published power, limits of rigid and long-wave buoys, wet natural modes, take-off behind a chamber."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import DatabaseError, StabilityError
from vsb.motion.frequency import (
    LinearBuoy,
    compliance,
)
from vsb.motion.port import LinearPto
from vsb.scenes.rest import design_motions, study_basis
from vsb.waves.dispersion import power_limit


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


def test_stiff_shell_approaches_the_rigid_buoy(buoy_of, coarse):
    omega = np.linspace(0.5, 6.0, 23)
    gains = []
    for modulus in (1e9, 1e11, 1e13):
        study = varied(coarse, device={"young_modulus": modulus, "damping": {"alpha": 0.0, "beta": 0.0}})
        gains.append(np.abs(power(buoy_of, study, "VSWEC", omega) / power(buoy_of, study, "FSB", omega) - 1).max())
    assert gains[2] < 1e-5
    assert gains[0] / gains[1] == pytest.approx(100, rel=0.2)  # flexibility is first order in 1/E
    assert gains[1] / gains[2] == pytest.approx(100, rel=0.2)


def test_no_design_exceeds_the_radiation_limit(buoy_of, coarse):
    omega = np.linspace(0.5, 8.0, 76)
    limit = np.array([power_limit(w, np.inf, 1025.0, 9.81) for w in omega])
    for design in coarse.designs:
        assert (power(buoy_of, coarse, design, omega) / limit).max() < 1.01


def test_optimal_damping_at_resonance_reaches_the_limit(buoy_of, coarse):
    frequency = buoy_of(coarse).natural_modes(np.eye(8, 1))[0][0]
    at = np.array([frequency])
    damping = buoy_of(coarse).coefficients(at).damping[0, 0, 0]
    best = power(buoy_of, varied(coarse, pto={"damping": float(damping)}), "FSB", at)[0]
    assert best == pytest.approx(power_limit(frequency, np.inf, 1025.0, 9.81), rel=1e-2)


def test_buoy_follows_long_waves(buoy_of, coarse):
    rao = buoy_of(coarse).rao(np.array([0.2]), np.eye(8, 1))[0, 0]
    assert rao == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("structural", [0.0, 70.0])
@pytest.mark.parametrize("pto", [0.0, 250.0])
@pytest.mark.parametrize("radiated", [0.0, 400.0])
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
    buoy = LinearBuoy(ds, np.diag([0.0, structural]), LinearPto(pto))
    frequencies, ratios = buoy.natural_modes(np.eye(2))
    for at, (frequency, ratio) in enumerate(zip(frequencies, ratios, strict=True)):
        here = np.array([frequency])
        mass = (buoy.mass + buoy.added_mass_inf + buoy.spectrum.added_mass_difference(here)[0])[at, at]
        lost = buoy.spectrum.at(here)[0][at, at] + (pto, structural)[at]
        assert frequency == pytest.approx(np.sqrt((3000.0, 900.0)[at] / mass), rel=1e-9)
        assert ratio == pytest.approx(lost / (2 * frequency * mass), rel=1e-9, abs=1e-15)


def test_water_lowers_the_breathing_mode_to_the_published_range(buoy_of, coarse):
    """Half submerged: from 51 rad/s dry to 13-17 rad/s wet (semi-analytic estimate)."""
    frequencies, _ = buoy_of(coarse).natural_modes(np.eye(8))
    assert np.sum((frequencies > 13) & (frequencies < 17)) == 1
    full = varied(coarse, modes={"basis": "full"})
    soft, _ = buoy_of(full).natural_modes(np.eye(13))
    assert np.sum((soft > 5) & (soft < 11)) >= 2


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


def test_unstable_or_massless_motions_are_refused(buoy_of, coarse):
    with pytest.raises(StabilityError, match=r"gives way at rest: received a stiffness of -.* needs more than 0"):
        changed(buoy_of(coarse), structural_stiffness=-1.0).natural_modes(np.eye(8))
    with pytest.raises(DatabaseError, match=r"takes a mode's inertia; lower hydro.tolerance"):
        changed(buoy_of(coarse), added_mass_inf=-1.0).natural_modes(np.eye(8))


def test_frequencies_outside_the_database_are_refused(buoy_of, coarse):
    with pytest.raises(DatabaseError, match=r"database holds 0.1 to 9.6 rad/s; raise hydro.omega_max"):
        buoy_of(coarse).coefficients(np.array([11.0]))


@pytest.mark.parametrize(
    ("stiffness", "force", "moved"),
    [
        (np.diag([4.0, 0.0]), [1.0, 0.0], 0.25),
        (np.diag([4.0, 0.0]), [0.0, 1.0], np.inf),
        (np.diag([1e12, 1e-3]), [0.0, 1.0], 1e3),  # scales are no looseness
        (np.diag([4.0, 0.0]), [1e-8, 1e-8], np.inf),  # nor is a port of small parts held
        (np.diag([4.0, 0.0]), [1e8, 1.0], 2.5e15),  # of which a hundredth of a millionth drifts
        (np.array([[1.0, 5e-12 - 1], [5e-12 - 1, 1.0]]), [1.0, 1.0], 4e11),
        (np.array([[1.0, 5e-13 - 1], [5e-13 - 1, 1.0]]), [1.0, 1.0], np.inf),  # held by round-off alone
        (np.array([[1.0, 5e-13 - 1], [5e-13 - 1, 1.0]]), [1.0, -1.0], 1.0),
    ],
)
def test_static_compliance_of_a_port(stiffness, force, moved):
    assert compliance(stiffness, np.array(force)) == pytest.approx(moved, rel=1e-3)


@pytest.mark.parametrize("coupling", [-8.0, 0.0, 25.0])
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
    buoy = LinearBuoy(ds, np.diag([across, about]), LinearPto(0.0))
    (frequency,), (ratio,) = buoy.natural_modes(np.eye(2))
    left = turning - coupling**2 / mass
    assert frequency == pytest.approx(np.sqrt(stiffness / left), rel=1e-9)
    lost = about + across * (coupling / mass) ** 2
    assert ratio == pytest.approx(lost / (2 * frequency * left), rel=1e-9)
