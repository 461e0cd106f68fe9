from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import DatabaseError, StabilityError
from vsb.motion.frequency import (
    LinearBuoy,
    allowed_part,
    compliance,
    frequency_grid,
    gas_compliance,
    port_of_motion,
    with_open_chamber,
)
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


NO_PTO = LinearPto(0.0)


def lone(stiffness, pto=NO_PTO, chamber=0.0, losses=0.0, **more):
    """Heave of 800 kg that makes no waves, on a spring."""
    omega, pair = np.linspace(0.1, 12.0, 60), ("influenced_dof", "radiating_dof")
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, [[500.0]]), "added_mass_inf": (pair, [[300.0]]),
            "hydrostatic_stiffness": (pair, [[stiffness]]), "radiation_damping": (("omega", *pair), np.zeros((60, 1, 1))),
        }
        | {f"{name}_stiffness": (pair, [[value]]) for name, value in more.items()},
        {"omega": omega} | {dim: ["Heave"] for dim in pair},
    )  # fmt: skip
    return LinearBuoy(ds, np.array([[losses]]), pto, chamber)


@pytest.mark.parametrize(("damper", "spring"), [(250.0, 0.0), (250.0, 300.0), (250.0, -400.0), (0.0, 300.0)])
@pytest.mark.parametrize("chamber", [0.0, 1e-3])
def test_a_mode_is_held_and_damped_by_its_take_off_as_that_feels_at_its_own_frequency(damper, spring, chamber):
    """w^2 (M + A) = K + k(w), c(w)/(2 w (M + A)): of a chamber those at w, neither at rest nor without it."""
    pto = LinearPto(damper, spring)
    (frequency,), (ratio,) = lone(3000.0, pto, chamber, losses=20.0).natural_modes(np.eye(1))
    felt = pto.behind(chamber, np.array(frequency)) if chamber else pto
    assert frequency**2 * 800.0 == pytest.approx(3000.0 + felt.stiffness, rel=1e-9)
    assert ratio == pytest.approx((20.0 + felt.damping) / (2 * frequency * 800.0), rel=1e-9)


def test_a_spring_of_the_take_off_holds_what_nothing_else_does():
    (frequency,), (ratio,) = lone(0.0, LinearPto(80.0, 3200.0)).natural_modes(np.eye(1))
    assert (frequency, ratio) == pytest.approx((2.0, 80.0 / (2 * 2.0 * 800.0)), rel=1e-9)
    with pytest.raises(StabilityError, match=r"gives way at rest: received a stiffness of -100 N/m, needs more than 0"):
        lone(3000.0, LinearPto(0.0, -3100.0)).natural_modes(np.eye(1))
    several = lone(0.0).database.isel(influenced_dof=[0, 0, 0], radiating_dof=[0, 0, 0])
    buoy = LinearBuoy(several.assign_coords(influenced_dof=["Heave", "Surge", "Pitch"]), np.zeros((3, 3)), NO_PTO)
    coupled = buoy.drifting(np.array([[4.001, 4.0], [4.0, 4.0]]), np.eye(3)[:, [0, 2]])
    assert coupled.shape == (2, 0)
    adrift = buoy.drifting(np.diag([1.0, 0.0, 2.0]), np.eye(3))
    np.testing.assert_allclose(np.abs(adrift), [[0.0], [1.0], [0.0]], atol=1e-15)
    with pytest.raises(StabilityError, match=r"received a stiffness of 0 N/m"):
        buoy.drifting(np.array([[1.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 1.0]]), np.eye(3))


def test_a_mode_as_slow_as_an_hour_s_is_found():
    (frequency,), _ = lone(0.01).natural_modes(np.eye(1))
    assert frequency == pytest.approx(np.sqrt(0.01 / 800.0), rel=1e-6)
    (fast,), _ = lone(3e12).natural_modes(np.eye(1))
    assert fast == pytest.approx(np.sqrt(3e12 / 800.0), rel=1e-9)


def test_stiffness_is_that_of_shell_water_prestress_gas_and_mooring():
    parts = {"structural": 1.0, "prestress": -2.0, "gas": 4.0, "mooring": 8.0}
    buoy = lone(16.0, LinearPto(3.0, 32.0), **parts)
    assert buoy.stiffness.item() == 27.0  # of them all
    assert {name: value.item() for name, value in buoy.stiffness_parts.items()} == parts | {"hydrostatic": 16.0}
    assert buoy.held.item() == 59.0
    assert buoy.damping.item() == 3.0
    assert lone(16.0, losses=5.0).damping.item() == 5.0


def test_an_opened_chamber_has_the_gas_between_shell_and_take_off_alone():
    """K = b b^T/C once and no more; what has no gas stays as it is."""
    pair, b = ("influenced_dof", "radiating_dof"), np.array([3.0, -4.0])
    ds = xr.Dataset(
        {"gas_stiffness": (pair, np.outer(b, b) / 0.2), "hydrostatic_stiffness": (pair, np.diag([5.0, 6.0]))},
        {dim: ["Heave", "Membrane0"] for dim in pair},
    )
    closed = LinearBuoy(ds, np.zeros((2, 2)), LinearPto(2.0))
    opened = with_open_chamber(closed, b)
    assert opened.chamber == pytest.approx(0.2, rel=1e-14)
    assert gas_compliance(np.outer(b, b) / 0.2, b) == pytest.approx(0.2, rel=1e-14)
    np.testing.assert_array_equal(opened.stiffness, np.diag([5.0, 6.0]))
    bare = LinearBuoy(ds.drop_vars("gas_stiffness"), np.zeros((2, 2)), LinearPto(2.0))
    assert with_open_chamber(bare, b) is bare


@pytest.mark.parametrize("share", [1e-11, -1e-11, 1e-13, -1e-13, 0.0])
def test_a_port_s_part_in_a_motion_is_none_only_where_it_is_round_off(share):
    part = allowed_part(np.array([3.0, -4.0, 0.0]), np.array([[0.6, 0.8], [-0.8, 0.6], [0.0, 0.0]]).T[[0, 1]].T)
    assert part == pytest.approx([5.0, 0.0], abs=1e-14)
    assert part[1] == 0.0
    for size in (1.0, 1e-9, 1e9):  # of a volume, in square metres, or of a rotation
        found = allowed_part(size * np.array([1.0, share]), np.eye(2))
        assert found.tolist() == [size, size * share if abs(share) > 1e-12 else 0.0]


def test_a_port_yields_and_loses_by_its_part_in_the_motions_allowed():
    """Of round-off along what drifts it is still held, and moves not at all where all of it is round-off."""
    omega, one = np.array([0.5, 2.0]), np.eye(2)
    stiffness, lossy = np.diag([4.0, 0.0]), np.broadcast_to(np.diag([3.0, 1.0]), (2, 2, 2))
    dynamic = stiffness - 1j * omega[:, None, None] * lossy - omega[:, None, None] ** 2 * one
    b = np.array([2.0, 1e-13])
    free, forced = (
        np.linalg.solve(dynamic, np.tile(x, (2, 1))[..., None])[..., 0] for x in (one[0] + one[1], [2.0, 0.0])
    )
    port = port_of_motion(omega, free, forced, lossy, stiffness, one, b)
    assert port.compliance == pytest.approx(1.0, rel=1e-12)
    z = (3.0 + 1j * (4.0 / omega - omega)) / 4.0
    assert port.admittance == pytest.approx(1 / z, rel=1e-12)
    assert port.velocity == pytest.approx(0.5 / z, rel=1e-9)


@pytest.mark.parametrize(
    ("step", "lowest", "highest", "first", "last"),
    [(0.1, 0.1, 0.3, 0.1, 0.3), (0.1, 0.11, 0.29, 0.12, 0.28), (0.25, 0.3, 1.0, 0.3, 1.0), (0.3, 0.1, 0.7, 0.12, 0.66)],
)
def test_a_grid_of_fifths_stays_between_its_ends(step, lowest, highest, first, last):
    grid = frequency_grid(step, lowest, highest, [0.2000001, 0.15])
    own = np.array([w for w in grid if w not in (0.2000001, 0.15)])
    assert {0.2000001, 0.15} <= set(grid)
    assert (own[0], own[-1]) == pytest.approx((first, last), abs=1e-9)
    assert np.diff(own)[-1] == pytest.approx(step / 5, abs=1e-9)


def test_what_is_asked_for_beyond_the_band_is_told_with_the_longest_period():
    omega, pair = np.linspace(0.5, 3.0, 8), ("influenced_dof", "radiating_dof")
    ds = xr.Dataset(
        {
            "added_mass": (("omega", *pair), np.ones((8, 1, 1))),
            "radiation_damping": (("omega", *pair), omega[:, None, None] ** 3),
            "excitation_force": (("omega", "wave_direction", pair[0]), omega[:, None, None] + 0j),
        },
        {"omega": omega, "wave_direction": [0.0]} | {dim: ["Heave"] for dim in pair},
    )
    buoy = LinearBuoy(ds, np.zeros((1, 1)), LinearPto(0.0))
    assert buoy.coefficients(np.zeros(0)).damping.shape == (0, 1, 1)
    assert buoy.coefficients(np.array([0.5 - 5e-10, 3.0 + 5e-10])).damping.shape == (2, 1, 1)
    for beyond, told in (([0.499, 1.0], "0.499 to 1"), ([1.0, 3.001], "1 to 3.001"), ([0.5 - 2e-9, 1.0], "0.5 to 1"),
                         ([1.0, 0.499, 2.0], "0.499 to 2"), ([1.0, 3.001, 0.7], "0.7 to 3.001")):  # fmt: skip
        words = f"^frequencies {told} rad/s are asked for, the database holds 0.5 to 3 rad/s; raise hydro.omega_max, or use waves below 12.57 s.$"
        with pytest.raises(DatabaseError, match=words):
            buoy.coefficients(np.array(beyond))


def test_a_port_s_free_motion_knows_nothing_of_the_take_off():
    """Neither of its damper nor of its spring: what it does is told by what it sees."""
    omega, pair, at = np.linspace(0.5, 3.0, 12), ("influenced_dof", "radiating_dof"), np.array([0.7, 1.3])
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, np.diag([500.0, 30.0])), "hydrostatic_stiffness": (pair, np.diag([900.0, 200.0])),
            "added_mass": (("omega", *pair), np.full((12, 2, 2), 20.0)),
            "radiation_damping": (("omega", *pair), 1e-3 * omega[:, None, None] ** 3 * np.ones((2, 2))),
            "excitation_force": (("omega", "wave_direction", pair[0]), np.ones((12, 1, 2)) + 0j),
        },
        {"omega": omega, "wave_direction": [0.0]} | {dim: ["Heave", "Membrane0"] for dim in pair},
    )  # fmt: skip
    b, lossy = np.array([1.0, 0.4]), np.diag([0.0, 5.0])
    bare = LinearBuoy(ds, lossy, LinearPto(0.0))
    loaded = replace(bare, pto=LinearPto(250.0, 300.0, b))
    free, forced = loaded.free_motion(at, np.eye(2), b)
    np.testing.assert_array_equal((free, forced), bare.free_motion(at, np.eye(2), b))
    np.testing.assert_allclose(free, bare.rao(at, np.eye(2)), rtol=1e-12)
    port = loaded.port(at, np.eye(2), b)
    np.testing.assert_allclose(port.admittance, -1j * at * (forced @ b), rtol=1e-9)
    np.testing.assert_allclose(port.velocity, -1j * at * (free @ b), rtol=1e-12)
    moved = free - (port.load(250.0, 300.0) * port.velocity_under(port.load(250.0, 300.0)))[:, None] * forced
    np.testing.assert_allclose(loaded.rao(at, np.eye(2)), moved, rtol=1e-9)


@pytest.mark.parametrize("shares", [[1.0, 0.0, 0.0], [0.0, 1.0, -0.5], [2.0, 0.3, 1.0]])
@pytest.mark.parametrize("adrift", [False, True])
def test_a_design_swings_in_the_motions_it_allows_and_no_others(shares, adrift):
    """w^2 = K/M of one shape of heave and two modes, beside surge, which goes along where nothing holds it."""
    omega, pair = np.linspace(0.1, 12.0, 60), ("influenced_dof", "radiating_dof")
    mass = np.array(
        [[500.0, 20.0, 0.0, 90.0], [20.0, 30.0, 5.0, 0.0], [0.0, 5.0, 40.0, -7.0], [90.0, 0.0, -7.0, 600.0]]
    )
    stiffness = np.diag([900.0, 70.0, 20.0, 0.0])
    stiffness[0, 1] = stiffness[1, 0] = 15.0
    ds = xr.Dataset(
        {
            "inertia_matrix": (pair, mass), "added_mass_inf": (pair, 0.1 * mass),
            "hydrostatic_stiffness": (pair, stiffness), "radiation_damping": (("omega", *pair), np.zeros((60, 4, 4))),
        },
        {"omega": omega} | {dim: ["Heave", "Membrane0", "Membrane1", "Surge"] for dim in pair},
    )  # fmt: skip
    lost = np.diag([3.0, 2.0, 1.0, 0.0])
    shape, surge = np.array([*shares, 0.0]), np.eye(4)[3]
    motions = np.stack([shape, surge], axis=1) if adrift else shape[:, None]
    (frequency,), (ratio,) = LinearBuoy(ds, lost, LinearPto(0.0)).natural_modes(motions)
    along = shape - surge * (surge @ mass @ shape) / mass[3, 3] if adrift else shape
    inertia = 1.1 * along @ mass @ along
    assert frequency == pytest.approx(np.sqrt(shape @ stiffness @ shape / inertia), rel=1e-9)
    assert ratio == pytest.approx(along @ lost @ along / (2 * frequency * inertia), rel=1e-9)
