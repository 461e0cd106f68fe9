from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import DatabaseError, StabilityError
from vsb.motion.frequency import LinearBuoy, compliance, frequency_grid
from vsb.motion.pto import LinearPto
from vsb.scenes.rest import design_motions, study_basis
from vsb.waves.dispersion import power_limit


def power(buoy_of, study, design, omega):
    buoy = buoy_of(study)
    return buoy.absorbed_power(omega, buoy.rao(omega, design_motions(study, study_basis(study), design)))


@pytest.fixture(scope="module")
def published(seed):
    """The seed's buoy with c = 6000 N s/m and full resolution."""
    return varied(seed, pto={"damping": 6000.0})


def test_absorbed_power_of_the_seed(buoy_of, published):
    """Independent semi-analytic estimate: 17.2 and 9.96 kW/m^2 rigid; about +39 % and -37 % for the free shell."""
    omega = np.array([2.0, 2 * np.pi / 2.5])
    rigid, free = (power(buoy_of, published, design, omega) for design in ("FSB", "VSWEC"))
    assert rigid == pytest.approx([17.2e3, 9.96e3], rel=5e-3)
    assert 100 * (free / rigid - 1) == pytest.approx([39.0, -37.0], abs=1.0)


def test_stiff_shell_is_the_rigid_buoy(buoy_of, coarse):
    omega = np.linspace(0.5, 6.0, 23)
    gains = []
    for modulus in (1e9, 1e11, 1e13):
        study = varied(coarse, device={"young_modulus": modulus, "damping": {"alpha": 0.0, "beta": 0.0}})
        gains.append(np.abs(power(buoy_of, study, "VSWEC", omega) / power(buoy_of, study, "FSB", omega) - 1).max())
    assert gains[2] < 1e-5
    assert gains[0] / gains[1] == pytest.approx(100, rel=0.2)  # flexibility is first order in 1/E
    assert gains[1] / gains[2] == pytest.approx(100, rel=0.2)


def test_no_design_exceeds_the_limit(buoy_of, coarse):
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


def test_low_frequency_buoy_follows_the_wave(buoy_of, coarse):
    rao = buoy_of(coarse).rao(np.array([0.2]), np.eye(8, 1))[0, 0]
    assert rao == pytest.approx(1.0, abs=0.02)


def test_rigid_wet_frequency_solves_its_own_equation(buoy_of, coarse):
    buoy = buoy_of(coarse)
    (frequency,), (ratio,) = buoy.natural_modes(np.eye(8, 1))
    added = buoy.coefficients(np.array([frequency])).added_mass[0, 0, 0]
    assert frequency == pytest.approx(np.sqrt(buoy.stiffness[0, 0] / (buoy.mass[0, 0] + added)), rel=1e-3)
    assert 0.1 < ratio < 0.2


@pytest.mark.parametrize("structural", [0.0, 70.0])
@pytest.mark.parametrize("pto", [0.0, 250.0])
@pytest.mark.parametrize("radiated", [0.0, 400.0])
def test_wet_damping_ratio_is_all_damping_over_twice_the_frequency_times_the_mass(structural, pto, radiated):
    """(B + D + c)/(2 w (M + A)), of heave and of a mode that nothing couples to it."""
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
    """Half submerged: from 51 rad/s dry to about 13-17 rad/s wet (semi-analytic estimate)."""
    frequencies, _ = buoy_of(coarse).natural_modes(np.eye(8))
    assert np.sum((frequencies > 13) & (frequencies < 17)) == 1
    full = varied(coarse, modes={"basis": "full"})
    soft, _ = buoy_of(full).natural_modes(np.eye(13))
    assert np.sum((soft > 5) & (soft < 11)) >= 2


def changed(buoy, **factors):
    """A buoy with variables of its database multiplied."""
    return replace(buoy, database=buoy.database.assign({name: buoy.database[name] * f for name, f in factors.items()}))


def test_light_shells_swing_though_their_inertia_is_negative_somewhere(buoy_of, seed):
    """The added mass of what is nearly immersed is negative at some frequencies: M + A(w) of a light shell as well."""
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


def test_what_gives_way_or_has_no_inertia_has_no_frequency(buoy_of, coarse):
    with pytest.raises(StabilityError, match=r"gives way at rest: received a stiffness of -.* needs more than 0"):
        changed(buoy_of(coarse), structural_stiffness=-1.0).natural_modes(np.eye(8))
    with pytest.raises(DatabaseError, match=r"takes a mode's inertia; lower hydro.tolerance"):
        changed(buoy_of(coarse), added_mass_inf=-1.0).natural_modes(np.eye(8))


def test_clamped_shells_do_not_move_at_the_clamp(buoy_of, coarse):
    basis = study_basis(coarse)
    for design, colatitude in (("VSWEC0", 0.0), ("VSWEC90", np.pi / 2)):
        rao = buoy_of(coarse).rao(np.array([2.0]), design_motions(coarse, basis, design))[0]
        assert np.abs(basis.clamp_rows([colatitude]) @ rao).max() < 1e-12


def test_outside_the_band_is_refused(buoy_of, coarse):
    with pytest.raises(DatabaseError, match=r"database holds 0.1 to 9.6 rad/s; raise hydro.omega_max"):
        buoy_of(coarse).coefficients(np.array([11.0]))


def test_grid_holds_what_is_asked_for():
    grid = frequency_grid(0.1, 0.1, 12.0, [2.5132741, 2.0])
    assert grid[0] == 0.1
    assert grid[-1] == 12.0
    assert 2.5132741 in grid
    assert len(grid) == len(set(grid))
    assert np.all(np.diff(grid) > 0)


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
def test_a_port_gives_way_by_what_holds_it_and_drifts_where_nothing_does(stiffness, force, moved):
    assert compliance(stiffness, np.array(force)) == pytest.approx(moved, rel=1e-3)


@pytest.mark.parametrize("direction", [0.0, 0.4, np.pi / 2, -2.0])
def test_waves_from_a_side_excite_and_diffract_by_the_cosine_and_the_sine_of_their_direction(direction):
    """Of heave, surge and sway; the database holds each in the waves that excite it most."""
    omega, pair = np.linspace(0.5, 3.0, 8), ("influenced_dof", "radiating_dof")
    own = np.array([2.0 + 1j, 3.0 - 1j, 3.0 - 1j]) * omega[:, None]
    sway = own * np.array([0.0, 0.0, 1.0])
    stored = np.stack([own - sway, sway + own * np.array([1.0, 0.0, 0.0])], axis=1)  # along x, then along y
    force = ("omega", "wave_direction", pair[0])
    ds = xr.Dataset(
        {
            "added_mass": (("omega", *pair), np.ones((8, 3, 3))),
            "radiation_damping": (("omega", *pair), omega[:, None, None] ** 3 * np.eye(3)),
            "excitation_force": (force, stored),
            "diffraction_force": (force, 0.3 * stored),
            "azimuthal_order": (pair[0], [0, 1, -1]),
        },
        {"omega": omega, "wave_direction": [0.0, np.pi / 2]} | {dim: ["Heave", "Surge", "Sway"] for dim in pair},
    )
    buoy, at = LinearBuoy(ds, np.zeros((3, 3)), LinearPto(0.0), direction=direction), np.array([1.1, 2.3])
    expected = np.array([2.0 + 1j, 3.0 - 1j, 3.0 - 1j]) * at[:, None] * [1.0, np.cos(direction), np.sin(direction)]
    np.testing.assert_allclose(buoy.coefficients(at).excitation, expected, atol=1e-12)
    np.testing.assert_allclose(buoy.diffraction(at), 0.3 * expected, atol=1e-12)
    for beyond in (0.4, 3.1):
        with pytest.raises(DatabaseError, match=r"the database holds 0.5 to 3 rad/s"):
            buoy.diffraction(np.array([beyond]))


@pytest.mark.parametrize("coupling", [-8.0, 0.0, 25.0])
def test_what_nothing_holds_goes_along_without_force(coupling):
    """Of a pitch stiffness k beside free surge w^2 = k/(I - s^2/m); surge goes by -s/m of it, and may be damped there."""
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


@pytest.mark.parametrize("stiffness", [0.0, 300.0, -40.0])
@pytest.mark.parametrize("chamber", [0.0, 1e-3])
def test_power_taken_through_a_chamber_is_that_of_the_port_behind_it(stiffness, chamber):
    """What rao and damper give is what a damper at Thevenin's equivalent takes."""
    omega, pair = np.linspace(0.5, 3.0, 12), ("influenced_dof", "radiating_dof")
    force = np.array([200.0 + 0j, 60.0 - 30j]) * omega[:, None]
    radiated = 1e-3 * omega[:, None, None] ** 3 * np.real(force[:, :, None] * force[:, None, :].conj())
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, np.diag([500.0, 30.0])), "hydrostatic_stiffness": (pair, np.diag([900.0, 200.0])),
            "added_mass": (("omega", *pair), np.full((12, 2, 2), 20.0)), "radiation_damping": (("omega", *pair), radiated),
            "excitation_force": (("omega", "wave_direction", pair[0]), force[:, None]),
        },
        {"omega": omega, "wave_direction": [0.0]} | {dim: ["Heave", "Membrane0"] for dim in pair},
    )  # fmt: skip
    pto = LinearPto(250.0, stiffness, np.array([1.0, 0.4]))
    buoy, at, free = LinearBuoy(ds, np.diag([0.0, 5.0]), pto, chamber), np.array([0.7, 1.3, 2.6]), np.eye(2)
    taken = buoy.absorbed_power(at, buoy.rao(at, free))
    assert taken == pytest.approx(buoy.port(at, free, pto.direction(2)).power(250.0, stiffness), rel=1e-9)
