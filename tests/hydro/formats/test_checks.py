"""Verdicts on numbers of other codes: sound ones pass, every limit is crossed from both sides, and causes are named."""

import capytaine as cpt
import numpy as np
import pytest
import xarray as xr
from capytaine.io.xarray import merge_complex_values

from vsb.engine.hydro.formats.capytaine import read_capytaine
from vsb.engine.hydro.formats.checks import coefficient_checks, sizes
from vsb.engine.hydro.formats.wamit import import_wamit
from vsb.engine.waves.water import group_velocity, wavenumber
from vsb.errors import ConfigError, DatabaseError
from vsb.tools import variables

PAIR, WAVE = ("influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
RHO, G = 1000.0, 9.81
CIRCLE = tuple(np.arange(0.0, 360.0, 30.0))
LABELS = ("Surge", "Heave", "Pitch", "Bend")
MASS = {"Surge": 3e6, "Heave": 2e6, "Pitch": 4e8, "Roll": 4e8, "Yaw": 4e8, "Bend": 1e6}
ORDER = {"Heave": 0, "Surge": 1, "Pitch": 2, "Bend": 3, "Yaw": 4}  # of the waves sent around the body


def narrowness(omega, depth):
    return np.array([wavenumber(w, depth, G) / (4 * RHO * G * group_velocity(w, depth, G)) for w in omega])


def sound(labels=LABELS, headings=CIRCLE, *, omega=None, depth=np.inf, **facts):
    """Uncoupled modes with damping of a resonance, K(s) = c s/(s^2 + s + 1), and all that follows from it.

    Damping is Re K(i omega), added mass A(inf) + Im K(i omega)/omega (Kramers and Kronig), excitation that of Haskind,
    heave stiffness the excitation in the longest wave.
    """
    omega, headings = np.array(np.linspace(0.1, 8.0, 80) if omega is None else omega), np.radians(headings)
    mass = np.array([MASS[label] for label in labels])
    memory = 1j * omega / (1 - omega**2 + 1j * omega)
    damping = 0.5 * memory.real[:, None] * mass
    wave = np.stack(
        [np.cos(ORDER.get(name, 0) * headings) * np.sqrt(2.0 if ORDER.get(name) else 1.0) for name in labels], 1
    )
    force = (
        np.sqrt(damping / narrowness(omega, depth)[:, None])[:, None, :] * wave * np.exp(0.3j * omega)[:, None, None]
    )
    force = force * np.where(np.array(labels) == "Surge", -1j, 1.0)  # of the acceleration of the water
    stiffness = np.diag([float(abs(force[0, 0, i])) if name == "Heave" else 0.0 for i, name in enumerate(labels)])
    added = mass + 0.5 * (memory.imag / omega)[:, None] * mass
    data = {
        "added_mass": (("omega", *PAIR), added[:, :, None] * np.eye(len(labels))),
        "radiation_damping": (("omega", *PAIR), damping[:, :, None] * np.eye(len(labels))),
        "added_mass_inf": (PAIR, np.diag(mass)),
        "excitation_force": (WAVE, force),
        "hydrostatic_stiffness": (PAIR, stiffness),
        "inertia_matrix": (PAIR, np.diag(np.where(np.array(labels) == "Heave", 4e6, 1e6))),
    }
    attrs = {"water_density": RHO, "gravity": G, "water_depth": str(depth), "displaced_volume": 4000.0, **facts}
    coords = {"omega": omega, "wave_direction": headings, **{dof: list(labels) for dof in PAIR}}
    return variables.described(xr.Dataset(data, coords, attrs))


def edited(ds, name, change):
    """The database with one variable changed in place, by a function of its values."""
    values = ds[name].values.copy()
    change(values)
    return ds.assign({name: (ds[name].dims, values)})


def judged(ds, **options):
    return {check.name: check for check in coefficient_checks(ds, **options)[0]}


def verdicts(ds, **options):
    return {name: check.verdict for name, check in judged(ds, **options).items()}


ALL = {
    "symmetry",
    "displaced_mass",
    "positive_damping",
    "irregular_frequencies",
    "kramers_kronig",
    "long_waves",
    "phases",
}
HASKIND = {"haskind", "haskind_scale", "haskind_long_waves"}


@pytest.mark.parametrize("headings", [CIRCLE, np.roll(CIRCLE, 5) - 100.0, np.arange(-180.0, 181.0, 10.0)])
@pytest.mark.parametrize("depth", [np.inf, 30.0])
def test_consistent_coefficients_pass_all_checks(headings, depth):
    checks, notes = coefficient_checks(sound(headings=headings, depth=depth))
    assert notes == []
    assert {check.name for check in checks} == ALL | HASKIND
    assert {check.verdict for check in checks} == {"ok"}
    assert max(check.value for check in checks if check.name in HASKIND) < 1e-12


def of_two(first, second):
    """Two bodies too far apart to feel each other, one database."""
    parts = [
        ds.assign_coords({dof: [f"{name}__{label}" for label in ds[dof].values] for dof in PAIR})
        for name, ds in (("float", first), ("spar", second))
    ]
    one, other = xr.align(*parts, join="outer", fill_value=0.0)
    both = one + other
    order = [label for p in parts for label in p.influenced_dof.values]
    volumes = {f"displaced_volume_{name}": 4000.0 for name in ("float", "spar")}
    water = {key: value for key, value in first.attrs.items() if key != "displaced_volume"}
    return both.sel(dict.fromkeys(PAIR, order)).assign_attrs(water | volumes)


def test_checks_of_two_bodies_are_those_of_each():
    """Rotations are measured by their body's size and heave by its own waterplane, whoever else is there."""
    one = sound(headings=[0.0])  # Haskind's relation would couple what sends out waves of one shape
    alone, together = judged(one), judged(of_two(one, one))
    assert alone.pop("haskind_long_waves").verdict == "ok"  # of one body alone
    assert {name: check.verdict for name, check in together.items()} == dict.fromkeys(ALL, "ok")
    assert {name: check.value for name, check in together.items()} == pytest.approx(
        {name: check.value for name, check in alone.items()}, abs=1e-12
    )
    heavy = edited(one, "inertia_matrix", lambda m: m.__setitem__((1, 1), 1.1 * m[1, 1]))
    high = edited(one, "hydrostatic_stiffness", lambda c: c.__imul__(1.3))
    for wrong, name in ((heavy, "displaced_mass"), (high, "long_waves")):
        assert judged(of_two(one, wrong))[name].verdict == judged(wrong)[name].verdict != "ok"


def test_one_direction_shows_the_scale_of_damping():
    """In long waves heave sends out ring waves: k X^2/(4 rho g v_g), which damping per unit density is not."""
    wrong = edited(sound(headings=[90.0]), "radiation_damping", lambda b: b.__imul__(1025.0))
    check = judged(wrong)["haskind_long_waves"]
    assert check.verdict == "fail"
    assert check.value == pytest.approx(1024.0, rel=0.05)


# --- every limit from both sides


def _asymmetric(ds, size):
    def change(a):
        a[40, 0, 1] += size * np.sqrt(np.prod([abs(b[40, i, i] / omega + 1j * a[40, i, i]) for i in (0, 1)]))

    omega, b = ds.omega.values[40], ds.radiation_damping.values
    return edited(ds, "added_mass", change)


def _heavier(ds, size):
    return ds.assign_attrs(displaced_volume=4000.0 / (1 + size))


def _lively(ds, size):
    def change(b):
        b[60, 1, 1] = -size * b[:, 1, 1].max()

    return edited(ds, "radiation_damping", change)


def _spiky(ds, size, at=20):
    """Of added mass and of damping, as a resonance between two frequencies would be."""

    def heavy(a):
        a[at, 1, 1] += size * np.median(a[:, 1, 1])

    def wavy(b):
        b[at, 1, 1] += size * ds.omega.values[at] * np.median(ds.added_mass.values[:, 1, 1])

    return edited(edited(ds, "added_mass", heavy), "radiation_damping", wavy)


def _spiky_alone(ds, size):
    def change(a):
        a[20, 1, 1] += size * np.median(a[:, 1, 1])

    return edited(ds, "added_mass", change)


def _other_limit(ds, size):
    def change(a):
        a[1, 1] -= size * np.median(ds.added_mass.values[:, 1, 1])

    return edited(ds, "added_mass_inf", change)


def _stiff(ds, size):
    limit = judged(ds)["long_waves"].limit

    def change(c):
        c[1, 1] /= 1 + size * limit

    return edited(ds, "hydrostatic_stiffness", change)


def _pushed(ds, size):
    def change(x):
        x[9, :, 1] *= np.sqrt(1 + size)  # where damping is largest

    return edited(ds, "excitation_force", change)


def _scaled(ds, size):
    return ds.assign(excitation_force=np.sqrt(1 + size) * ds.excitation_force)


def _pushed_by_long_waves(ds, size):
    def change(x):
        x[1, :, 1] *= np.sqrt(1 + size)  # the first of 3 % of the largest damping

    return edited(ds, "excitation_force", change)


LIMITS = [
    ("symmetry", _asymmetric, 0.0199, 0.0201, "doubt"),
    ("symmetry", _asymmetric, 0.099, 0.101, "fail"),
    ("displaced_mass", _heavier, 0.0099, 0.0101, "doubt"),
    ("displaced_mass", _heavier, -0.0099, -0.0101, "doubt"),
    ("displaced_mass", _heavier, 0.199, 0.201, "fail"),
    ("positive_damping", _lively, 0.0099, 0.0101, "fail"),
    ("irregular_frequencies", _spiky_alone, 0.099, 0.101, "fail"),
    ("irregular_frequencies", _spiky_alone, 0.018, 0.022, "doubt"),
    ("irregular_frequencies", _spiky, 0.0045, 0.0053, "doubt"),
    ("kramers_kronig", _other_limit, 0.018, 0.022, "doubt"),
    ("kramers_kronig", _other_limit, 0.097, 0.103, "fail"),
    ("long_waves", _stiff, 0.9, 1.1, "fail"),
    ("haskind", _pushed, 0.0499, 0.0501, "fail"),
    ("haskind_scale", _scaled, 0.0099, 0.0101, "doubt"),
    ("haskind_scale", _scaled, -0.0099, -0.0101, "doubt"),
    ("haskind_scale", _scaled, 0.0499, 0.0501, "fail"),
    ("haskind_long_waves", _pushed_by_long_waves, 0.0499, 0.0501, "doubt"),
    ("haskind_long_waves", _pushed_by_long_waves, 0.249, 0.251, "fail"),
]


@pytest.mark.parametrize(("name", "damage", "below", "above", "verdict"), LIMITS)
def test_each_limit_from_both_sides(name, damage, below, above, verdict):
    better = {"doubt": "ok", "fail": "ok" if name in ("positive_damping", "long_waves", "haskind") else "doubt"}[
        verdict
    ]
    held, broken = (judged(damage(sound(), size))[name] for size in (below, above))
    assert (held.verdict, broken.verdict) == (better, verdict), (held, broken)


def test_limit_of_a_second_radiation_channel():
    """Two ring motions of one damping: what is not shared is a second channel, in terms of the first."""
    ds = sound(["Heave", "Bend"], [0.0])
    for share, verdict in ((0.0199, "ok"), (0.0202, "fail")):
        coupling = (1 - share) / (1 + share)  # eigenvalues 1 + c and 1 - c
        b = ds.radiation_damping.values + 0.0
        b[:, 0, 1] = b[:, 1, 0] = coupling * np.sqrt(b[:, 0, 0] * b[:, 1, 1])
        found = judged(ds.assign(radiation_damping=(("omega", *PAIR), b)), axisymmetric=True)["rank_one"]
        assert (found.verdict, found.value) == (verdict, pytest.approx(share, rel=1e-6))


# --- spikes and Kramers-Kronig


def test_narrow_resonance_is_not_a_failure():
    """K(s) = c s/(s^2 + 2 z s + 1) as narrow as the steps, wherever they fall: at worst a doubt."""
    rng = np.random.default_rng(1)
    for width in np.geomspace(0.05, 0.3, 6):
        omega = np.linspace(0.1, 6.0, 60) + rng.uniform(-0.02, 0.02, 60)
        memory = 1j * omega / (1 - omega**2 + 2j * width * omega)
        ds = sound(omega=omega)
        size = 4e5 * np.eye(4)
        ds = ds.assign(
            radiation_damping=(("omega", *PAIR), memory.real[:, None, None] * size),
            added_mass=(("omega", *PAIR), 2e6 * np.eye(4) + (memory.imag / omega)[:, None, None] * size),
            added_mass_inf=(PAIR, 2e6 * np.eye(4)),
        )
        checks = verdicts(ds)
        assert checks["irregular_frequencies"] in ("ok", "doubt"), width
        assert checks.get("kramers_kronig", "ok") in ("ok", "doubt"), width


def test_periods_read_as_frequencies_are_found_with_one_heading():
    """Two ways: the excitation of the longest wave is not the stiffness, and added mass not that of the damping."""
    ds = sound(headings=[0.0], omega=np.geomspace(0.02, 20.0, 120))
    assert set(verdicts(ds).values()) == {"ok"}
    wrong = ds.isel(omega=slice(None, None, -1)).assign_coords(omega=2 * np.pi / ds.omega.values[::-1] / 10)
    checks = verdicts(wrong)
    assert (checks["long_waves"], checks["kramers_kronig"]) == ("fail", "fail")


# --- Haskind


def test_haskind_is_checked_where_headings_resolve_the_waves():
    """Excitation of surge turns six times around the body from 0.6 to 1.5 rad/s, at twelve headings: up to there."""
    ds = sound()

    def ripple(x):
        x[5:15, :, 0] *= np.cos(5 * ds.wave_direction.values)

    checks, notes = coefficient_checks(edited(ds, "excitation_force", ripple))
    assert {check.verdict for check in checks} == {"ok"}
    assert notes == [
        "not checked: haskind of Surge (75 of 80 frequencies, from 0.6 rad/s), which 12 directions do not resolve"
    ]
    assert verdicts(_pushed(edited(ds, "excitation_force", ripple), 0.1))["haskind"] == "fail"


def test_wrong_length_is_found_and_wrong_density_needs_the_mass():
    ds = sound()
    scale = judged(_scaled(ds, 0.02))["haskind_scale"]
    assert scale.explanation.endswith("length/gravity is 1.02 times that of the run")
    wrong = ds.assign_attrs(water_density=2 * RHO)
    wrong = wrong.assign({name: 2 * ds[name] for name in ds.data_vars if name != "inertia_matrix"})
    assert {name for name, verdict in verdicts(wrong).items() if verdict != "ok"} == {"displaced_mass"}
    unseen = coefficient_checks(wrong.drop_vars("inertia_matrix"))
    assert {check.verdict for check in unseen[0]} == {"ok"}
    assert unseen[1] == [
        "not checked: density, with which all coefficients grow alike; it needs mass in heave and displaced volume"
    ]


@pytest.mark.parametrize(
    ("true", "given", "found_depth"), [(30.0, np.inf, 30.0), (30.0, 60.0, 30.0), (np.inf, 30.0, np.inf)]
)
def test_wrong_depth_is_found_and_the_right_one_reported(true, given, found_depth):
    ds = sound(depth=true).assign_attrs(water_depth=str(given))
    found = judged(ds)["haskind_long_waves"]
    assert found.verdict in ("doubt", "fail")
    if np.isinf(found_depth):
        assert found.explanation.endswith("; deep water would fit")
    else:
        metres = float(found.explanation.rpartition("; ")[2].removesuffix(" m would fit"))
        assert metres == pytest.approx(found_depth, rel=0.1)


def test_axisymmetric_identities_apply_to_ring_waves_only():
    """One heading of a ring wave: heave and mode, whatever surge does."""
    ds = sound(["Heave", "Bend", "Surge"], [0.0])
    b = ds.radiation_damping.values + 0.0
    b[:, 0, 1] = b[:, 1, 0] = np.sqrt(b[:, 0, 0] * b[:, 1, 1])
    x = ds.excitation_force.values + 0.0
    x[:, :, 1] /= np.sqrt(2)  # a ring wave, too
    ring = ds.assign(radiation_damping=(("omega", *PAIR), b), excitation_force=(WAVE, x))
    assert "rank_one" not in verdicts(ring)
    held = verdicts(ring, axisymmetric=True)
    assert {held[name] for name in ("rank_one", *HASKIND)} == {"ok"}
    wrong = verdicts(ring.assign(excitation_force=2 * ring.excitation_force), axisymmetric=True)
    assert (wrong["rank_one"], wrong["haskind"], wrong["haskind_scale"]) == ("ok", "fail", "fail")
    with pytest.raises(ConfigError, match="--axisymmetric: received Surge, Pitch; needs heave or modes"):
        coefficient_checks(sound(["Surge", "Pitch"]), axisymmetric=True)


# --- modes that move no water


def with_noise(ds, label, size):
    """Added mass, damping and excitation of a mode that are round-off of a size, of any sign."""
    rng, i = np.random.default_rng(3), list(ds.influenced_dof.values).index(label)

    def change(values):
        values[..., i] = values[..., i, :] = 0.0
        values[..., i, i] = size * rng.normal(size=values.shape[:-2])

    def push(x):
        x[..., i] = size * rng.normal(size=x.shape[:-1])

    for name in ("added_mass", "radiation_damping", "added_mass_inf"):
        ds = edited(ds, name, change)
    return edited(ds, "excitation_force", push)


@pytest.mark.parametrize("size", [1e-9, 1.0])
def test_round_off_of_a_mode_without_water_is_not_an_error(size):
    """Yaw of a round body, beside pitch of 4e8 kg m^2."""
    ds = with_noise(sound(("Surge", "Heave", "Pitch", "Yaw")), "Yaw", size)
    checks, notes = coefficient_checks(ds)
    assert {check.verdict for check in checks} == {"ok"}, checks
    assert notes == []
    assert sizes(ds).wet.tolist() == [True, True, True, False]


def test_motions_without_waves_are_accepted():
    ds = sound(("Surge", "Heave", "Pitch", "Yaw"))
    moving = np.array([1.0, 1.0, 1.0, 0.0])
    still = ds.assign(
        {n: ds[n] * np.outer(moving, moving) for n in ("added_mass", "added_mass_inf", "radiation_damping")}
    )
    still = variables.described(still.assign(excitation_force=ds.excitation_force * moving))
    assert set(verdicts(still).values()) == {"ok"}
    with pytest.raises(DatabaseError, match="radiation damping is zero for all motions"):
        coefficient_checks(still.assign(radiation_damping=0 * still.radiation_damping))


# --- several bodies, still modes, pairs


def test_kramers_kronig_of_coupled_motions():
    """In terms of both; of one whose damping lasts beyond the band what couples it is left out."""
    ds = sound()
    size = sizes(ds).added_mass

    def couple(one, other, share):
        def change(a):
            a[one, other] += share * np.sqrt(size[one] * size[other])

        return change

    found = judged(edited(ds, "added_mass_inf", couple(2, 1, 0.05)))["kramers_kronig"]
    assert (found.value, found.verdict) == (pytest.approx(0.05, rel=0.02), "doubt")
    assert found.explanation.endswith(" in Pitch and Heave")
    lasting = edited(ds, "radiation_damping", lambda b: b.__setitem__((-1, 0, 0), 0.1 * b[:, 0, 0].max()))
    for one, other, verdict in ((0, 1, "ok"), (3, 0, "ok"), (0, 0, "fail")):
        checks, _ = coefficient_checks(edited(lasting, "added_mass_inf", couple(one, other, -0.5)))
        (causal,) = [check for check in checks if check.name == "kramers_kronig"]
        assert causal.verdict == verdict
        assert causal.explanation.endswith("of Surge only what exceeds the error of band and steps")
    found = judged(edited(lasting, "added_mass_inf", couple(1, 1, -0.06)))["kramers_kronig"]
    assert (found.value, found.verdict) == (pytest.approx(0.06, rel=0.02), "doubt")
    assert "rad/s in Heave" in found.explanation


FORCES = ("excitation_force", "Froude_Krylov_force", "diffraction_force")


def phases(ds, dofs=None):
    (found,) = [check for check in coefficient_checks(ds, dofs=dofs)[0] if check.name == "phases"]
    return found


def conjugated(ds, names=FORCES):
    return ds.assign({name: ds[name].conj() for name in names})


@pytest.mark.parametrize("kept", [None, ["Heave"], ["Heave", "Pitch"]])
def test_conjugated_forces_are_found(ball, kept):
    """Of heave alone by its own phase -omega B; surge tells it for those that are kept."""
    ds = read_capytaine(ball)
    assert phases(ds, kept).verdict == "ok"
    found = phases(conjugated(ds), kept)
    assert (found.verdict, found.value) == ("fail", pytest.approx(2.0, abs=0.02))
    assert "their complex conjugates would fit" in found.explanation
    alone = ds.sel(influenced_dof=["Heave"], radiating_dof=["Heave"])
    assert (phases(alone).verdict, phases(conjugated(alone)).verdict) == ("ok", "fail")
    assert phases(conjugated(ds, ["diffraction_force"])).verdict == "fail", "one part alone"


@pytest.mark.parametrize(("factor", "where"), [(np.pi / 180, "radians where"), (180 / np.pi, "degrees where")])
def test_headings_in_another_unit_are_found(ball, factor, where):
    ds = read_capytaine(ball)
    found = phases(ds.assign_coords(wave_direction=ds.wave_direction * factor))
    assert found.verdict == "fail"
    assert f"headings would fit in {where}" in found.explanation


def test_body_away_from_the_origin_passes(ball):
    """Its phases are those of the place, of surge and heave alike."""
    ds = read_capytaine(ball)
    delay = np.exp(1j * ds.omega**2 / 9.81 * 30.0 * np.cos(ds.wave_direction))
    assert phases(ds.assign({name: ds[name] * delay for name in FORCES})).verdict == "ok"


def test_constant_error_of_all_phases_is_found(ball):
    """As of a wave that is a sine at the origin: no distance of the body explains it."""
    ds = read_capytaine(ball)
    found = phases(ds.assign({name: 1j * ds[name] for name in FORCES}))
    assert (found.verdict, found.value) == ("fail", pytest.approx(np.sqrt(2), abs=0.1))
    assert "phases later by 270 degrees would fit" in found.explanation or "269" in found.explanation


def _turned_round(ds):
    """Moments of the other sign, as files of NEMOH had them."""
    sign = xr.where(ds.influenced_dof.isin(["Roll", "Pitch", "Yaw"]), -1.0, 1.0)
    return ds.assign({name: ds[name] * sign for name in FORCES})


def _about_another_point(ds):
    return ds.assign_attrs(rotation_centre=ds.attrs["rotation_centre"] + np.array([0.0, 0.0, 1.0]))


@pytest.mark.parametrize("kept", [FORCES, ["excitation_force"]])
@pytest.mark.parametrize(
    ("damage", "verdict"), [(xr.Dataset.copy, "ok"), (_turned_round, "fail"), (_about_another_point, "fail")]
)
def test_moments_in_long_waves(ball, damage, verdict, kept):
    ds = damage(read_capytaine(ball)).drop_vars([name for name in FORCES if name not in kept])
    assert judged(ds)["tilt"].verdict == verdict


def test_added_mass_of_another_unit_is_found(ball):
    """Of a file whose numbers are divided by the density though it says they are not."""
    ds = read_capytaine(ball)
    found = judged(
        ds.assign({name: ds[name] / 1025.0 for name in ("added_mass", "added_mass_inf", "radiation_damping")})
    )
    assert found["displaced_volume"].verdict == "fail"
    assert "times that water" in found["displaced_volume"].explanation


def test_displaced_volume_by_the_force_of_long_waves(ball):
    ds = read_capytaine(ball)
    for factor, verdict in ((1.0, "ok"), (1.3, "doubt"), (5.0, "fail")):
        checks = coefficient_checks(ds.assign_attrs(displaced_volume=factor * ds.attrs["displaced_volume"]))[0]
        (found,) = [check for check in checks if check.name == "displaced_volume"]
        assert found.verdict == verdict, found


def test_exchanged_limits_of_added_mass_are_found(ball, tmp_path):
    """Of capytaine's own writer: rows PER = -1 and 0 exchanged, as version 2.3 wrote them."""
    with xr.open_dataset(ball) as ds:
        cpt.export_dataset(tmp_path / "ball", merge_complex_values(ds), format="wamit")
    rows = (tmp_path / "ball.1").read_text()
    swapped = rows.replace("-1.000000e+00", "_").replace("0.000000e+00\t", "-1.0\t").replace("_", "0.0")
    for text, verdict in ((rows, "ok"), (swapped, "fail")):
        (tmp_path / "ball.1").write_text(text)
        found = verdicts(import_wamit(tmp_path, "ball", density=1025.0, gravity=9.81))
        assert (found["added_mass_limits"], found["phases"]) == (verdict, "ok")
