"""Verdicts on numbers of other codes: sound ones pass, every limit is crossed from both sides, and causes are named."""

import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro.formats import foreign
from vsb.hydro.formats.foreign import BEMIO_WORDS, LEAST_SIZE, WAMIT_WORDS, causes, foreign_checks, sizes
from vsb.hydro.formats.haskind import Haskind
from vsb.hydro.quality import kinks
from vsb.tools import variables
from vsb.waves.dispersion import group_velocity, wavenumber

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
    return {check.name: check for check in foreign_checks(ds, **options)[0]}


def verdicts(ds, **options):
    return {name: check.verdict for name, check in judged(ds, **options).items()}


ALL = {"symmetry", "afloat", "positive_damping", "irregular_frequencies", "kramers_kronig", "long_waves", "phases"}
HASKIND = {"haskind", "haskind_scale", "haskind_long_waves"}


@pytest.mark.parametrize(
    "headings", [CIRCLE, np.roll(CIRCLE, 5) - 100.0, (*CIRCLE, 360.0), np.arange(-180.0, 181.0, 10.0)]
)
@pytest.mark.parametrize("depth", [np.inf, 30.0])
def test_sound_numbers_pass(headings, depth):
    checks, notes = foreign_checks(sound(headings=headings, depth=depth))
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


def test_what_holds_of_one_body_holds_of_two():
    """Rotations are measured by their body's size and heave by its own waterplane, whoever else is there."""
    one = sound(headings=[0.0])  # Haskind's relation would couple what sends out waves of one shape
    alone, together = judged(one), judged(of_two(one, one))
    assert {name: check.verdict for name, check in together.items()} == dict.fromkeys(ALL, "ok")
    assert {name: check.value for name, check in together.items()} == pytest.approx(
        {name: check.value for name, check in alone.items()}, abs=1e-12
    )
    heavy = edited(one, "inertia_matrix", lambda m: m.__setitem__((1, 1), 1.1 * m[1, 1]))
    high = edited(one, "hydrostatic_stiffness", lambda c: c.__imul__(1.3))
    for wrong, name in ((heavy, "afloat"), (high, "long_waves")):
        assert judged(of_two(one, wrong))[name].verdict == judged(wrong)[name].verdict != "ok"


def test_what_only_turns_is_measured_by_the_largest_added_mass_of_what_turns_beside_it():
    """Nothing tells of the water displaced: no volume, no translation."""
    pair = ("omega", *PAIR)
    ds = sound(("Roll", "Pitch"), (0.0,))
    ds = ds.drop_attrs().assign_attrs({name: ds.attrs[name] for name in ("water_density", "gravity", "water_depth")})
    ds = ds.assign(added_mass=(pair, np.tile(np.diag([1e-9, 5.0]), (len(ds.omega), 1, 1))))
    assert sizes(ds).added_mass == pytest.approx([LEAST_SIZE**2 * 5.0, 5.0], rel=1e-12)
    assert sizes(ds).wet.tolist() == [False, True]


def test_a_mass_or_a_volume_that_is_not_stated_is_not_judged():
    assert "afloat" in judged(sound())
    assert "afloat" not in judged(sound(displaced_volume=0.0))
    assert "afloat" not in judged(sound().assign(inertia_matrix=0.0 * sound().inertia_matrix))
    assert "afloat" not in judged(sound(("Surge", "Pitch")))


def test_the_size_of_a_rotation_is_that_of_its_own_body():
    """A model a tenth as long beside the body: its pitch, a hundred-thousandth, is no round-off of the large one's."""
    small = sound().map(lambda v: v * 1e-5).assign_attrs(sound().attrs)
    both = of_two(sound(), small).assign_attrs(displaced_volume_spar=0.04)
    wet = dict(zip(both.influenced_dof.values, sizes(both).wet, strict=True))
    assert wet["float__Pitch"]
    assert wet["spar__Pitch"]


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
    ("afloat", _heavier, 0.0099, 0.0101, "doubt"),
    ("afloat", _heavier, -0.0099, -0.0101, "doubt"),
    ("afloat", _heavier, 0.199, 0.201, "fail"),
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
def test_a_limit_from_both_sides(name, damage, below, above, verdict):
    better = {"doubt": "ok", "fail": "ok" if name in ("positive_damping", "long_waves", "haskind") else "doubt"}[
        verdict
    ]
    held, broken = (judged(damage(sound(), size))[name] for size in (below, above))
    assert (held.verdict, broken.verdict) == (better, verdict), (held, broken)


def test_a_second_channel_from_both_sides():
    """Two ring motions of one damping: what is not shared is a second channel, in terms of the first."""
    ds = sound(["Heave", "Bend"], [0.0])
    for share, verdict in ((0.0199, "ok"), (0.0202, "fail")):
        coupling = (1 - share) / (1 + share)  # eigenvalues 1 + c and 1 - c
        b = ds.radiation_damping.values + 0.0
        b[:, 0, 1] = b[:, 1, 0] = coupling * np.sqrt(b[:, 0, 0] * b[:, 1, 1])
        found = judged(ds.assign(radiation_damping=(("omega", *PAIR), b)), axisymmetric=True)["rank_one"]
        assert (found.verdict, found.value) == (verdict, pytest.approx(share, rel=1e-6))


@pytest.mark.parametrize(
    ("name", "damage", "size"),
    [
        ("symmetry", _asymmetric, 0.0201),
        ("positive_damping", _lively, 0.0101),
        ("irregular_frequencies", _spiky_alone, 0.101),
        ("kramers_kronig", _other_limit, 0.103),
    ],
)
def test_of_an_axisymmetric_body_the_other_motions_are_judged_as_of_any(name, damage, size):
    """Of surge, which sends out no ring wave: its numbers, and what they leave unchecked."""
    ds = damage(sound(["Heave", "Surge", "Bend"]), size)
    told, expected = (judged(ds, axisymmetric=ring)[name] for ring in (True, False))
    assert told == expected
    assert told.verdict != "ok"
    few = sound(["Heave", "Surge", "Bend"], omega=np.linspace(0.1, 1.0, 12))
    (note,) = (line for line in foreign_checks(few, axisymmetric=True)[1] if "kramers_kronig" in line)
    assert note.startswith("not checked: kramers_kronig of Heave, Surge, Bend, ")


# --- spikes and Kramers-Kronig


def test_a_resonance_the_frequencies_miss_is_a_doubt_and_a_spike_alone_fails():
    ds = sound()
    both, alone = judged(_spiky(ds, 0.5)), judged(_spiky_alone(ds, 0.5))
    assert both["irregular_frequencies"].verdict == "doubt"
    assert alone["irregular_frequencies"].verdict == "fail"
    assert "of one without the other; most at 2.1 rad/s in Heave" in alone["irregular_frequencies"].explanation

    def change(b):
        b[20, 2, 2] *= 4

    assert verdicts(edited(ds, "radiation_damping", change))["irregular_frequencies"] == "fail"


def test_a_spike_alone_is_told_where_it_is_beside_a_larger_one_of_both():
    ds = sound()
    alone, beside = (judged(_spiky_alone(each, 0.5))["irregular_frequencies"] for each in (ds, _spiky(ds, 2.0, 50)))
    assert beside.verdict == "fail"
    assert beside.value == pytest.approx(alone.value, rel=1e-3)
    assert "of one without the other; most at 2.1 rad/s in Heave" in beside.explanation


def test_a_spike_of_added_mass_beyond_what_headings_resolve_is_seen():
    """As a barge's A33, 92 times A33(inf) at one frequency, in 36 headings that do not resolve its surge there."""
    ds = sound()

    def spike(a):
        a[33, 1, 1] *= 92

    def ripple(x):
        x[50:, :, 0] *= np.cos(5 * ds.wave_direction.values)

    checks = verdicts(edited(edited(ds, "added_mass", spike), "excitation_force", ripple))
    assert (checks["irregular_frequencies"], checks["kramers_kronig"]) == ("fail", "fail")
    assert checks["haskind"] == "ok"  # of what is resolved


def test_a_narrow_resonance_is_never_taken_for_a_spike():
    """K(s) = c s/(s^2 + 2 z s + 1) as narrow as the steps, wherever they fall: at worst a doubt."""
    rng = np.random.default_rng(1)
    for width in np.geomspace(0.05, 0.3, 12):
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


def test_kinks_of_a_cubic_are_none_at_any_steps():
    omega = np.array([0.1, 0.2, 0.5, 0.6, 1.1, 1.9, 2.0])
    cubic = np.stack([omega**3 - omega, 2 - omega**2], axis=1)
    assert kinks(omega, cubic) == pytest.approx(np.zeros((3, 2)), abs=1e-13)
    cubic[3, 0] += 0.25
    assert kinks(omega, cubic)[1] == pytest.approx([0.25, 0.0], abs=1e-13)


def test_periods_taken_for_frequencies_are_seen_with_one_heading():
    """Two ways: the excitation of the longest wave is not the stiffness, and added mass not that of the damping."""
    ds = sound(headings=[0.0], omega=np.geomspace(0.02, 20.0, 120))
    assert set(verdicts(ds).values()) == {"ok"}
    wrong = ds.isel(omega=slice(None, None, -1)).assign_coords(omega=2 * np.pi / ds.omega.values[::-1] / 10)
    checks = verdicts(wrong)
    assert (checks["long_waves"], checks["kramers_kronig"]) == ("fail", "fail")


def test_added_mass_at_infinity_may_be_missing():
    ds = sound().drop_vars("added_mass_inf")
    assert verdicts(ds)["kramers_kronig"] == "ok"
    assert verdicts(_spiky_alone(ds, 0.5))["kramers_kronig"] == "fail"


def test_what_kramers_kronig_cannot_judge_is_said():
    ends = "not checked: kramers_kronig of Surge, Heave, Pitch, Bend, whose damping lasts beyond the band"
    assert foreign_checks(sound(omega=np.linspace(0.1, 1.3, 30)))[1] == [ends]
    assert ends in foreign_checks(sound(omega=np.linspace(0.8, 8.0, 75)))[1], "nor one that begins before the band"
    steps = "not checked: kramers_kronig of Surge, Heave, Pitch, Bend, whose damping needs smaller steps of frequency"
    assert foreign_checks(sound(omega=[*np.linspace(0.1, 8.0, 10)]))[1] == [steps]
    few = foreign_checks(sound(omega=[0.1, 1.0, 2.0]))[1]
    assert few == [
        "not checked: irregular_frequencies, which needs five frequencies; received 3",
        "not checked: kramers_kronig, which needs ten frequencies; received 3",
    ]


def test_long_waves_are_judged_only_where_they_are_long():
    assert foreign_checks(sound(["Surge"]))[1][0] == "not checked: long_waves, which needs heave and a waterplane"
    short = foreign_checks(sound(omega=np.linspace(2.0, 8.0, 60)))
    assert "long_waves" not in {check.name for check in short[0]}
    assert "not checked: long_waves, of which 2 rad/s is none for this body" in short[1]


@pytest.mark.parametrize("start", [0.2, 0.9])
def test_the_limit_of_long_waves_is_a_twentieth_and_twice_their_second_order(start):
    """The longer the waves, the nearer the lift is to the hydrostatic stiffness; beyond a fifth nothing is said."""
    ds = sound(omega=np.linspace(start, 8.0, 60))
    checks, notes = foreign_checks(ds)
    i = ds.influenced_dof.values.tolist().index("Heave")
    added, stiffness = (float(np.abs(v).max()) for v in (ds.added_mass[:, i, i], ds.hydrostatic_stiffness[i, i]))
    least, most = (start**2 * share * added / stiffness for share in (1.0, 2.0))
    limits = [check.limit for check in checks if check.name == "long_waves"]
    if limits:
        assert 0.05 + 1.5 * least <= limits[0] <= 0.05 + 2 * most + 0.02
        assert limits[0] <= 0.45 + 1e-9
    else:
        assert any(note.startswith("not checked: long_waves, of which") for note in notes)
        assert most > 0.1


def test_zero_frequency_says_nothing_of_waves():
    ds = sound()
    still = ds.isel(omega=[0]).assign_coords(omega=[0.0])
    both = xr.concat([still, ds], dim="omega", data_vars="minimal", coords="minimal", compat="override")
    assert judged(both.assign_attrs(ds.attrs)) == judged(ds)


# --- Haskind


@pytest.mark.parametrize("headings", [(0.0,), (0.0, 180.0), CIRCLE[:-1], (*CIRCLE[:-1], 345.0), CIRCLE[::3]])
def test_too_few_headings_are_said_to_be(headings):
    checks, missing = foreign_checks(sound(headings=headings))
    assert {check.name for check in checks} == ALL
    assert missing[-1].startswith("not checked: haskind, the only check that sees a wrong length, gravity or depth")
    assert missing[-1].endswith(f"received {len(headings)}")


def test_haskind_is_judged_where_headings_resolve_it_and_the_rest_is_counted():
    """Excitation of surge turns six times around the body from 0.6 to 1.5 rad/s, at twelve headings: up to there."""
    ds = sound()

    def ripple(x):
        x[5:15, :, 0] *= np.cos(5 * ds.wave_direction.values)

    checks, notes = foreign_checks(edited(ds, "excitation_force", ripple))
    assert {check.verdict for check in checks} == {"ok"}
    assert notes == [
        "not checked: haskind of Surge (75 of 80 frequencies, from 0.6 rad/s), which 12 directions do not resolve"
    ]
    assert verdicts(_pushed(edited(ds, "excitation_force", ripple), 0.1))["haskind"] == "fail"


@pytest.mark.parametrize("pair", [(0, 1), (1, 0), (1, 1)])
def test_haskind_judges_no_pair_of_which_headings_do_not_resolve_both(monkeypatch, pair):
    """What excitation says of a mode between headings is anything."""
    ds = sound()
    resolved = np.ones((ds.sizes["omega"], ds.sizes["influenced_dof"]), dtype=bool)
    resolved[4, 1] = False
    damping = ds.radiation_damping.values.copy()
    damping[4][pair] += 10 * np.abs(damping).max()
    monkeypatch.setattr(foreign, "haskind_headings", lambda *_, **__: Haskind(damping, resolved))
    assert verdicts(ds)["haskind"] == "ok"
    monkeypatch.setattr(foreign, "haskind_headings", lambda *_, **__: Haskind(damping, resolved | True))
    assert verdicts(ds)["haskind"] == "fail"


def test_haskind_of_modes_that_turn_too_often_is_not_judged():
    ds = sound()
    turning = np.cos(5 * ds.wave_direction.values)[:, None] * np.abs(ds.excitation_force.values).max(
        axis=1, keepdims=True
    )
    few = foreign_checks(ds.assign(excitation_force=(WAVE, turning)))
    assert HASKIND & {check.name for check in few[0]} == set()
    assert few[1][-1].startswith("not checked: haskind, the only check")


def test_length_and_gravity_are_told_to_a_per_cent_and_density_not_at_all():
    ds = sound()
    scale = judged(_scaled(ds, 0.02))["haskind_scale"]
    assert scale.explanation.endswith("length/gravity is 1.02 times that of the run")
    wrong = ds.assign_attrs(water_density=2 * RHO)
    wrong = wrong.assign({name: 2 * ds[name] for name in ds.data_vars if name != "inertia_matrix"})
    assert {name for name, verdict in verdicts(wrong).items() if verdict != "ok"} == {"afloat"}
    unseen = foreign_checks(wrong.drop_vars("inertia_matrix"))
    assert {check.verdict for check in unseen[0]} == {"ok"}
    assert unseen[1] == [
        "not checked: density, with which all coefficients grow alike; it needs mass in heave and displaced volume"
    ]


@pytest.mark.parametrize(("true", "given", "told"), [(30.0, np.inf, 30.0), (30.0, 60.0, 30.0), (np.inf, 30.0, np.inf)])
def test_a_wrong_depth_is_seen_and_the_right_one_told(true, given, told):
    ds = sound(depth=true).assign_attrs(water_depth=str(given))
    found = judged(ds)["haskind_long_waves"]
    assert found.verdict in ("doubt", "fail")
    if np.isinf(told):
        assert found.explanation.endswith("; deep water would fit")
    else:
        metres = float(found.explanation.rpartition("; ")[2].removesuffix(" m would fit"))
        assert metres == pytest.approx(told, rel=0.1)


def test_identities_of_axisymmetric_motions_only_where_they_hold():
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
        foreign_checks(sound(["Surge", "Pitch"]), axisymmetric=True)


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


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1.0])
def test_round_off_of_a_mode_that_moves_no_water_is_no_fault(size):
    """Yaw of a round body, beside pitch of 4e8 kg m^2."""
    ds = with_noise(sound(("Surge", "Heave", "Pitch", "Yaw")), "Yaw", size)
    checks, notes = foreign_checks(ds)
    assert {check.verdict for check in checks} == {"ok"}, checks
    assert notes == []
    assert sizes(ds).wet.tolist() == [True, True, True, False]


def test_rotations_of_a_sphere_about_its_centre_are_all_round_off():
    ds = sound(("Heave", "Roll", "Pitch", "Yaw"))
    for label in ("Roll", "Pitch", "Yaw"):
        ds = with_noise(ds, label, 1e-3)
    assert set(verdicts(ds).values()) == {"ok"}
    bare = ds.drop_attrs().assign_attrs({k: v for k, v in ds.attrs.items() if k != "displaced_volume"})
    assert {name for name, verdict in verdicts(bare).items() if verdict != "ok"} == set()


def test_a_mode_that_moves_little_water_counts_by_itself():
    """Heave of a spar, a thirtieth of surge: an error of its own size is a failure."""
    ds = sound()
    little = np.array([1.0, 1 / 30, 1.0, 1.0])
    for name, power in (("added_mass", 1.0), ("added_mass_inf", 1.0), ("radiation_damping", 1.0)):
        ds = ds.assign({name: ds[name] * np.diag(little**power)})
    ds = ds.assign(excitation_force=ds.excitation_force * np.sqrt(little))
    ds = variables.described(ds.assign(hydrostatic_stiffness=ds.hydrostatic_stiffness / np.sqrt(30)))
    assert set(verdicts(ds).values()) == {"ok"}
    assert verdicts(_pushed(ds, 0.06))["haskind"] == "fail"
    assert verdicts(_lively(ds, 0.02))["positive_damping"] == "fail"


def test_motions_that_make_no_waves_at_all_do_no_harm():
    ds = sound(("Surge", "Heave", "Pitch", "Yaw"))
    moving = np.array([1.0, 1.0, 1.0, 0.0])
    still = ds.assign(
        {n: ds[n] * np.outer(moving, moving) for n in ("added_mass", "added_mass_inf", "radiation_damping")}
    )
    still = variables.described(still.assign(excitation_force=ds.excitation_force * moving))
    assert set(verdicts(still).values()) == {"ok"}
    with pytest.raises(DatabaseError, match="radiation damping is zero for all motions"):
        foreign_checks(still.assign(radiation_damping=0 * still.radiation_damping))


def test_energy_from_nowhere_is_seen():
    ds = sound()
    assert verdicts(ds.assign(radiation_damping=-ds.radiation_damping))["positive_damping"] == "fail"


# --- causes


def test_every_check_that_does_not_hold_has_causes_of_its_own():
    """Depth, the commonest, wherever it can be one; nothing of units where damping is negative."""
    ds = sound(["Heave", "Bend"], CIRCLE)
    for check in [*foreign_checks(ds)[0], *foreign_checks(ds, axisymmetric=True)[0]]:
        for words in (WAMIT_WORDS, BEMIO_WORDS):
            line = causes(check, words)
            assert line.startswith(f"{check.name}: ")
            assert (words["depth"] in line) == (check.name in ("haskind", "haskind_long_waves"))
            assert (words["density"] in line) == (check.name == "afloat")
            if check.name in ("positive_damping", "symmetry", "rank_one"):
                assert not any(words[key] in line for key in ("length", "gravity", "period"))


@pytest.mark.parametrize(
    ("parts", "worst", "error"), [({1: 0.06, 2: -0.1}, "Pitch", 0.1), ({0: -0.03, 3: 0.08}, "Bend", 0.08)]
)
def test_of_long_waves_the_mode_that_is_off_most_is_named_whichever_way(parts, worst, error):
    """At the first frequency of more than 3 % of the largest damping: 0.2 rad/s."""

    def change(x):
        for mode, part in parts.items():
            x[1, :, mode] *= np.sqrt(1 + part)

    found = judged(edited(sound(), "excitation_force", change))["haskind_long_waves"]
    assert found.value == pytest.approx(error, rel=1e-9)
    assert f"so they do in the longest waves, which feel the depth; most at 0.2 rad/s in {worst}" in found.explanation


def test_one_scale_is_told_as_the_factor_of_length_over_gravity():
    found = judged(sound().pipe(_scaled, 0.5))["haskind_scale"]
    assert found.explanation == "excitation and damping have one scale; length/gravity is 1.5 times that of the run"
    assert found.value == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize(("low", "high", "scale"), [(0.0, 0.1, 1.0), (0.1, 0.5, 1.5), (0.5, 1.0, 1.0)])
def test_the_scale_is_the_median_of_where_more_than_a_tenth_of_the_largest_damping_is_radiated(low, high, scale):
    """Of 80 frequencies 52 radiate less, 18 up to half as much, 10 more: those between are the larger part."""
    ds = sound()
    damping = np.einsum("wii->wi", ds.radiation_damping.values)
    share = damping / damping.max(axis=0)

    def change(x):
        x *= np.sqrt(np.where((share > low) & (share <= high), 1.5, 1.0))[:, None, :]

    found = judged(edited(ds, "excitation_force", change))["haskind_scale"]
    assert found.explanation.endswith(f"length/gravity is {scale:g} times that of the run")


def test_a_mode_that_moves_no_water_is_never_the_one_that_is_off_most():
    """Its damping and its excitation are round-off each, of which no ratio says anything."""
    ds = sound(("Surge", "Heave", "Pitch", "Yaw"))
    known, noisy = (judged(one)["haskind_long_waves"] for one in (ds, with_noise(ds, "Yaw", 1e-6)))
    assert (noisy.value, noisy.verdict) == (pytest.approx(known.value, abs=1e-12), "ok")
    assert "Yaw" not in noisy.explanation
    led = with_noise(_pushed_by_long_waves(sound(("Yaw", "Surge", "Heave", "Pitch")), 0.08), "Yaw", 1e-6)
    assert "most at 0.2 rad/s in Surge" in judged(led)["haskind_long_waves"].explanation


def test_scale_and_long_waves_are_judged_of_what_headings_resolve_alone():
    """Surge and pitch turn too often around the body from 0.5 rad/s on: of them a fifth of the largest is resolved."""
    ds = sound(("Surge", "Heave", "Pitch"))

    def ripple(x):
        x[4:, :, ::2] *= 3 * np.cos(5 * ds.wave_direction.values)[:, None]
        x[1, :, 0] *= np.sqrt(1.04)

    found = judged(edited(ds, "excitation_force", ripple))
    assert (found["haskind_scale"].value, found["haskind_long_waves"].value) == pytest.approx((0.0, 0.04), abs=1e-9)
    assert "most at 0.2 rad/s in Surge" in found["haskind_long_waves"].explanation


# --- several bodies, still modes, pairs


def bare(labels, added, damping, omega=(0.5, 1.0, 2.0), **facts):
    """Uncoupled coefficients over frequencies (omega, dof), and nothing else."""
    eye = np.eye(len(labels))
    data = {"added_mass": (("omega", *PAIR), np.asarray(added)[:, :, None] * eye)}
    data["radiation_damping"] = (("omega", *PAIR), np.asarray(damping)[:, :, None] * eye)
    return xr.Dataset(
        data, {"omega": list(omega), **{dof: list(labels) for dof in PAIR}}, {"water_density": RHO, **facts}
    )


def test_sizes_are_of_the_water_of_each_body_of_its_translations_or_of_modes_like_it():
    """The volume of one is known, of the other it is not; a mode is measured by the largest mode of its body."""
    labels = ["float__Surge", "float__Heave", "float__Pitch", "float__Bend", "float__Twist"]
    labels += ["spar__Heave", "spar__Sway", "spar__Roll", "spar__Bend"]
    mass = np.array([7000.0, -40.0, 2.0, 300.0, 1.0, 20.0, 500.0, 3.0, 9.0])
    largest = np.array([900.0, 1e-3, 1e-3, 2.0, 1e-3, 1e-3, 8.0, 1e-3, 5.0])
    top = np.array([0, 1, 2, 1, 2, 0, 1, 2, 1])
    damping = np.where(np.arange(3)[:, None] == top, -largest, 0.1 * largest)
    ds = bare(labels, np.outer([10.0, 1.0, 0.5], mass), damping, displaced_volume_float=3.0, displaced_volume=99.0)
    share, water, other = LEAST_SIZE**2, 3000.0, 500.0
    turn, small = water * 3.0 ** (2 / 3), other * 0.5 ** (2 / 3)
    least = share * np.array([water, water, turn, 300.0, 300.0, other, other, small, 9.0])
    size = np.maximum(np.abs(mass), least)
    found = sizes(ds)
    assert found.added_mass == pytest.approx(size, rel=1e-12)
    floor = 1e-3 * np.array([0.5, 1.0, 2.0])[top] * size
    assert found.damping == pytest.approx(np.maximum(largest, floor), rel=1e-12)
    assert found.wet.tolist() == (np.abs(mass) > 1e-4 * least).tolist()
    assert np.count_nonzero(floor > largest) == 5
    some = np.arange(9) % 3 == 1
    assert all(part.tolist() == whole[some].tolist() for part, whole in zip(found.of(some), found, strict=True))


def test_a_mode_without_damping_moves_no_water_whatever_its_added_mass():
    ds = bare(["Heave", "Pitch"], np.full((3, 2), 50.0), np.outer([1.0, 2.0, 1.0], [3.0, 0.0]), displaced_volume=0.1)
    assert sizes(ds).wet.tolist() == [True, False]


@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("place", [0, 2])
def test_a_motion_that_makes_no_waves_changes_nothing_said_of_the_others(axisymmetric, place):
    labels = ["Heave", "Bend"]
    ds = sound(labels, (0.0,) if axisymmetric else CIRCLE)
    ds = _asymmetric(_pushed(ds.isel(influenced_dof=[1, 0], radiating_dof=[1, 0]), 0.03), 0.003)
    labels = ["Bend", "Heave"]
    labels.insert(place, "Yaw")
    more = ds.reindex(dict.fromkeys(PAIR, labels), fill_value=0.0).assign_attrs(ds.attrs)
    expected, found = (foreign_checks(one, axisymmetric=axisymmetric) for one in (ds, more))
    assert found == expected
    assert {"haskind"} <= {check.name for check in found[0]}


def test_an_asymmetric_pair_is_named_by_both_and_a_motion_once():
    ds = sound()
    told = judged(_asymmetric(ds, 0.05))["symmetry"].explanation
    assert (
        told
        == f"added mass and damping are symmetric matrices; most at {ds.omega.values[40]:.4g} rad/s in Surge and Heave"
    )
    assert judged(_pushed(ds, 0.03))["haskind"].explanation.endswith(f"most at {ds.omega.values[9]:.4g} rad/s in Heave")
    lowest = judged(_lively(ds, 0.02))["positive_damping"].explanation
    assert lowest == f"no motion can draw energy from calm water; most at {ds.omega.values[60]:.4g} rad/s"


@pytest.mark.parametrize("size", [0.015, -0.03])
def test_damping_that_is_not_symmetric_counts_by_the_impedances_of_both(size):
    ds = sound()
    z = [
        abs(ds.radiation_damping.values[40, i, i] + 1j * ds.omega.values[40] * ds.added_mass.values[40, i, i])
        for i in (1, 2)
    ]

    def change(b):
        b[40, 2, 1] += size * np.sqrt(z[0] * z[1])

    assert judged(edited(ds, "radiation_damping", change))["symmetry"].value == pytest.approx(abs(size), rel=1e-9)


def test_beside_a_mode_without_water_asymmetry_is_measured_by_what_is_least_at_its_frequency():
    """Yaw that moves none: a thousandth of the impedance of its least added mass."""
    ds = with_noise(sound(("Surge", "Heave", "Pitch", "Yaw")), "Yaw", 1e-9)
    omega, turned = ds.omega.values[40], LEAST_SIZE**2 * RHO * 4000.0 * 4000.0 ** (2 / 3)
    assert sizes(ds).added_mass[3] == pytest.approx(turned, rel=1e-12)
    z = abs(ds.radiation_damping.values[40, 1, 1] + 1j * omega * ds.added_mass.values[40, 1, 1])

    def change(a):
        a[40, 3, 1] += 0.01 * np.sqrt(z * 1e-3 * omega * turned) / omega

    assert judged(edited(ds, "added_mass", change))["symmetry"].value == pytest.approx(0.01, rel=1e-6)


@pytest.mark.parametrize("at", [3, 20, 60])
def test_a_resonance_shows_in_both_alike_at_low_and_high_frequencies(at):
    """A spike of A and one of B of omega times its size are no spikes alone."""
    found = judged(_spiky(sound(), 0.5, at))["irregular_frequencies"]
    assert (found.verdict, "of one without the other" in found.explanation) == ("doubt", False)


@pytest.mark.parametrize("count", [80, 81])
def test_every_other_frequency_is_left_out_but_the_last(monkeypatch, count):
    """What the band holds at its end decides the integral."""
    seen = []

    class Seen(foreign.DampingSpectrum):
        def __init__(self, omega, damping):
            seen.append((omega, damping))
            super().__init__(omega, damping)

    monkeypatch.setattr(foreign, "DampingSpectrum", Seen)
    ds = sound(omega=np.linspace(0.1, 8.0, count))
    assert judged(ds)["kramers_kronig"].verdict == "ok"
    omega, damping = ds.omega.values, ds.radiation_damping.values
    (whole, its), (fewer, theirs) = seen
    assert (whole.tolist(), fewer.tolist()) == (omega.tolist(), omega[::-1][::2][::-1].tolist())
    assert (its == damping).all()
    assert (theirs == damping[::-1][::2][::-1]).all()


def test_every_mode_is_compared_in_its_own_longest_wave(monkeypatch):
    """Heave begins to radiate at 1 rad/s, surge at the second frequency; depths that would fit are asked of both."""
    ds = sound(("Surge", "Heave"))
    late = ds.omega.values < 0.95

    def quiet(b):
        b[late, 1, 1] *= 1e-3

    def push(x):
        x[late, :, 1] *= np.sqrt(1e-3)
        x[9, :, 1] *= np.sqrt(0.9)
        x[1, :, 0] *= np.sqrt(1.04)

    asked = []
    monkeypatch.setattr(foreign, "fitting_depth", lambda *given: asked.append(given))
    found = judged(edited(edited(ds, "radiation_damping", quiet), "excitation_force", push))["haskind_long_waves"]
    assert found.value == pytest.approx(0.1, rel=1e-9)
    assert found.explanation.endswith("which feel the depth; most at 1 rad/s in Heave")
    ratio, omega, depth, gravity = asked[0]
    assert (ratio, omega) == (pytest.approx([1.04, 0.9]), pytest.approx([0.2, 1.0]))
    assert (depth, gravity) == (np.inf, G)


@pytest.mark.parametrize("count", [4, 5, 9, 10])
def test_spikes_need_five_frequencies_and_causality_ten(count):
    """Over a band that holds the damping."""
    checks, notes = foreign_checks(sound(omega=np.linspace(0.05, 30.0, count)))
    names = {check.name for check in checks}
    few = {"irregular_frequencies": count < 5, "kramers_kronig": count < 10}
    needs = {"irregular_frequencies": "five", "kramers_kronig": "ten"}
    for name, missing in few.items():
        assert (f"not checked: {name}, which needs {needs[name]} frequencies; received {count}" in notes) == missing
    assert ("irregular_frequencies" in names) == (count >= 5)


def test_water_turned_by_the_cube_root_of_its_volume_is_what_a_rotation_has_at_least():
    """Without a volume the largest added mass of a translation is the water's."""
    ds = bare(["Sway", "Yaw"], np.full((3, 2), [8000.0, 0.0]), np.full((3, 2), 1.0))
    assert sizes(ds).added_mass == pytest.approx([8000.0, LEAST_SIZE**2 * 8000.0 * 4.0], rel=1e-12)
    assert sizes(ds.assign_attrs(displaced_volume=27.0)).added_mass[1] == pytest.approx(0.09 * 27e3 * 9.0, rel=1e-12)


def test_added_mass_that_couples_motions_follows_from_damping_as_well():
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
        checks, _ = foreign_checks(edited(lasting, "added_mass_inf", couple(one, other, -0.5)))
        (causal,) = [check for check in checks if check.name == "kramers_kronig"]
        assert causal.verdict == verdict
        assert causal.explanation.endswith("of Surge only what exceeds the error of band and steps")
    found = judged(edited(lasting, "added_mass_inf", couple(1, 1, -0.06)))["kramers_kronig"]
    assert (found.value, found.verdict) == (pytest.approx(0.06, rel=0.02), "doubt")
    assert "rad/s in Heave" in found.explanation


def test_what_headings_resolve_only_where_little_is_radiated_is_too_few():
    """A tenth of the largest damping is little."""
    ds = sound(("Surge", "Heave", "Pitch"))
    damping = np.einsum("wii->wi", ds.radiation_damping.values)
    large = damping[:, 0] > 0.1 * damping[:, 0].max()
    assert 0 < large.sum() < len(large)

    def ripple(x):
        x[large] *= np.cos(5 * ds.wave_direction.values)[:, None]

    checks, notes = foreign_checks(edited(ds, "excitation_force", ripple))
    assert not HASKIND & {check.name for check in checks}
    assert notes[-1].endswith("or one direction and --axisymmetric; received 12")

    def less(x):
        x[damping[:, 0].argmax() + 1 :] *= np.cos(5 * ds.wave_direction.values)[:, None]

    assert {"haskind"} <= {check.name for check in foreign_checks(edited(ds, "excitation_force", less))[0]}


def test_ring_waves_are_judged_at_the_depth_of_the_run():
    ds = sound(["Heave"], [0.0], depth=30.0)
    checks = judged(ds, axisymmetric=True)
    assert max(checks[name].value for name in HASKIND) < 1e-9
    assert checks["rank_one"].value < 1e-9
    deep = judged(ds.assign_attrs(water_depth="inf"), axisymmetric=True)["haskind_long_waves"]
    assert deep.verdict != "ok"
    assert float(deep.explanation.rpartition("; ")[2].removesuffix(" m would fit")) == pytest.approx(30.0, rel=0.1)


@pytest.mark.parametrize("apart", [0, 1, 2, 3, 5])
def test_spikes_of_added_mass_and_damping_are_one_where_they_are_neighbours_to_either_side(apart):
    """A resonance between two frequencies shows in both at one of them, or at one each."""
    found = []
    for side in (1, -1):
        ds = sound()
        size, at = 0.5 * np.median(ds.added_mass.values[:, 1, 1]), 30 + side * apart

        def heavy(a, size=size):
            a[30, 1, 1] += size

        def wavy(b, size=size, at=at, omega=ds.omega.values):
            b[at, 1, 1] += size * omega[at]

        found.append(
            judged(edited(edited(ds, "added_mass", heavy), "radiation_damping", wavy))["irregular_frequencies"]
        )
    assert {check.verdict for check in found} == {"doubt" if apart < 2 else "fail"}
    assert {"of one without the other" in check.explanation for check in found} == {apart >= 2}
    assert found[0].value == pytest.approx(found[1].value, rel=0.05)


@pytest.mark.parametrize("part", [1.2, 0.8])
def test_a_mode_resolved_in_long_waves_alone_counts_among_them(monkeypatch, part):
    """Surge where it radiates less than eight per cent of its largest; heave, as it should be, everywhere."""
    ds = sound(("Surge", "Heave"))
    own = np.einsum("wii->wi", ds.radiation_damping.values)
    share = own[:, 0] / own[:, 0].max()
    first = int((share > 0.03).argmax())
    assert share[first] < 0.08
    resolved = np.stack([share < 0.08, np.ones(len(share), dtype=bool)], axis=1)
    damping = ds.radiation_damping.values.copy()
    damping[first, 0, 0] *= part
    monkeypatch.setattr(foreign, "haskind_headings", lambda *_, **__: Haskind(damping, resolved))
    found = judged(ds)["haskind_long_waves"]
    assert found.value == pytest.approx(0.2, rel=1e-9)
    assert f"most at {ds.omega.values[first]:.4g} rad/s in Surge" in found.explanation


def test_added_mass_of_a_motion_that_makes_no_waves_may_be_ragged():
    """Nothing follows from it, and nothing of it is said."""
    ds = sound(("Heave", "Bend"))
    more = ds.reindex({dim: ["Heave", "Yaw", "Bend"] for dim in PAIR}, fill_value=0.0).assign_attrs(ds.attrs)

    def rag(a):
        a[:, 1, 1] += 4e8 * (2 + (-1.0) ** np.arange(len(a)))

    assert foreign_checks(edited(more, "added_mass", rag)) == foreign_checks(ds)


@pytest.mark.parametrize("pair", [(0, 1), (1, 0)])
def test_a_coupling_one_way_follows_from_damping_that_way(pair):
    """Files of others need not be symmetric: rows of added mass follow from rows of damping."""
    ds = sound()
    a, b = ds.added_mass.values.copy(), ds.radiation_damping.values.copy()
    share = 0.3 * np.sqrt(MASS["Heave"] / MASS["Surge"])
    a[:, *pair] = share * (a[:, 0, 0] - MASS["Surge"])
    b[:, *pair] = share * b[:, 0, 0]
    one_way = ds.assign(added_mass=(("omega", *PAIR), a), radiation_damping=(("omega", *PAIR), b))
    found, base = (judged(each)["kramers_kronig"].value for each in (one_way, ds))
    assert found == pytest.approx(base, rel=1e-3)


@pytest.mark.parametrize(("share", "verdict"), [(0.15, "fail"), (0.25, "doubt")])
@pytest.mark.parametrize("turned", [False, True])
def test_a_spike_is_compared_with_the_largest_about_it_not_with_how_rough_all_is(share, verdict, turned):
    """A spike of the one, at the other a zigzag from point to point around it that is off its cubics by a share of that."""
    ds = sound()
    omega, size = ds.omega.values, 0.15 * np.median(ds.added_mass.values[:, 1, 1])
    spike, zigzag = np.zeros(80), np.zeros(80)
    spike[6] = size
    zigzag[3:10] = -3 / 8 * share * size * (-1.0) ** np.arange(7)
    mass, wave = (zigzag, spike) if turned else (spike, zigzag)

    def heavy(a):
        a[:, 1, 1] += mass

    def wavy(b):
        b[:, 1, 1] += omega * wave

    check = judged(edited(edited(ds, "added_mass", heavy), "radiation_damping", wavy))["irregular_frequencies"]
    assert check.verdict == verdict
    assert ("of one without the other; most at 0.7 rad/s in Heave" in check.explanation) == (verdict == "fail")


@pytest.mark.parametrize(
    ("masses", "error"), [((1.0, 1.03), 0.03), ((1.04, 1.0), 0.04), ((0.96, 1.02), 0.04), ((1.02, 0.74), 0.26)]
)
def test_of_two_bodies_the_one_furthest_from_afloat_is_told_too_heavy_or_too_light(masses, error):
    one = sound(headings=[0.0])

    def weighed(part):
        return edited(one, "inertia_matrix", lambda m: m.__setitem__((1, 1), part * 4e6))

    (check,) = foreign.afloat_checks(of_two(*map(weighed, masses)))
    assert check.value == pytest.approx(error, rel=1e-9)
    assert (check.name, check.limit, check.verdict) == ("afloat", 0.01, "fail" if error > 0.2 else "doubt")
