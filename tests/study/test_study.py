"""A study as a whole: canonical form, floating, which models, methods and waves go together."""

import json

import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st
from study.test_sections import RAW, changed

from vsb.engine.integrators.settings import Simulation
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical
from vsb.keys.reading import validated
from vsb.study import study as config
from vsb.study.body import BodyStudy


def shuffled(data, rnd):
    if isinstance(data, dict):
        keys = list(data)
        rnd.shuffle(keys)
        return {key: shuffled(data[key], rnd) for key in keys}
    return [shuffled(item, rnd) for item in data] if isinstance(data, list) else data


def respelled(data):
    """Numbers as YAML readers may hand them over: 1e5 as text, whole numbers without a point."""
    if isinstance(data, dict):
        return {key: respelled(value) for key, value in data.items()}
    if isinstance(data, list):
        return [respelled(item) for item in data]
    if isinstance(data, float):
        return int(data) if data.is_integer() and abs(data) < 1e6 else f"{data!r}"
    return data


@settings(max_examples=25)
@given(st.randoms(use_true_random=False))
def test_canonical_form_ignores_order_and_spelling(rnd):
    studies = [config.parse(raw) for raw in (RAW, shuffled(RAW, rnd), respelled(RAW))]
    assert len({canonical(study) for study in studies}) == 1
    assert config.parse(json.loads(canonical(studies[0]))) == studies[0]


@given(st.floats(1400.0, 34000.0))
def test_any_floating_mass_is_that_of_the_displaced_water(mass):
    study = config.parse(changed(("device", "mass"), mass))
    assert 1025.0 * 3.141592653589793 * study.draft**2 * (6.0 - study.draft) / 3 == pytest.approx(mass, rel=1e-11)
    assert study.centre_height + study.draft == pytest.approx(2.0, rel=1e-14)


@pytest.mark.parametrize("mass", [6000.0, 17170.0, 28000.0])
def test_heave_frequency_follows_from_the_waterplane(seed, mass):
    """Without added mass; the stiffness by central differences of the displaced volume."""
    study = varied(seed, device={"mass": mass})
    h = 1e-4
    low, high = ((3 * study.device.radius - d) * d**2 / 3 for d in (study.draft - h, study.draft + h))
    stiffness = study.water.density * study.water.gravity * np.pi * (high - low) / (2 * h)
    assert study.heave_frequency == pytest.approx(np.sqrt(stiffness / mass), rel=1e-7)


REGULAR = {"kind": "regular", "amplitude": 0.1, "period": 4.0}
PRESSED = {"hydro": {"model": "assumed_pressure", "pressure": 100.0}, "waves": [REGULAR]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"device": {"gas": {}}}, "has no trapped gas and no viscous material; remove device.gas"),
        ({"device": {"internal_pressure": -5.0}}, "needs device.internal_pressure: 0 and reference_shape: undeformed"),
        ({"waves": [REGULAR, {"kind": "jonswap", "hs": 1.0, "tp": 7.0}]}, "has one period, of a regular wave; remove"),
        *(
            ({"hydro": {**PRESSED["hydro"], key: value}}, f"hydro.{key}: hydro.model 'assumed_pressure' has no coeffi")
            for key, value in (("omega", [1.0]), ("rows", 20), ("accept", ["haskind"]))
        ),
        ({"pto": {"damping": 5.0, "tuning": "each"}}, "pto.tuning 'each': an assumed pressure has no optimal"),
        ({"pto": {"law": "declutching"}}, "pto.law 'declutching': its latching time is found in waves"),
        ({"pto": {"port": {"colatitude": 90.0}}}, "has no other port than heave; needs hydro.model: linear"),
        ({"simulation": {"method": "exact"}}, "needs one of auto, exponential"),
    ],
    ids=str,
)
def test_limits_of_the_assumed_pressure(seed, changes, message):
    varied(seed, **PRESSED)
    with pytest.raises(ConfigError, match=message):
        varied(seed, **{**PRESSED, **changes})


def test_methods_of_each_model(seed):
    every = {"auto", "exact", "convolution", "exponential"}
    followed = {
        "linear": every - {"exponential"},
        "body_exact": every - {"exact", "convolution"},
        "assumed_pressure": every - {"exact", "convolution"},
        "auto": {"auto"},
    }
    for model, known in followed.items():
        hydro = PRESSED["hydro"] if model == "assumed_pressure" else {"model": model}
        for method in every:
            asked = {"waves": [REGULAR], "hydro": hydro, "simulation": {"method": method}}
            if method in known:
                assert varied(seed, **asked).simulation.method == method
            else:
                order = ("auto", "exact", "convolution", "exponential")
                suitable = ", ".join(each for each in order if each in known)
                expected = rf"simulation.method '{method}': hydro.model '{model}' needs one of {suitable}( \(|$)"
                with pytest.raises(ConfigError, match=expected):
                    varied(seed, **asked)


def test_waves_and_frequencies_must_lie_within_the_band(seed):
    """The second sea and the last frequency as well."""
    noise = {"kind": "white_noise", "hs": 0.1}
    for band in ((1.0, 8.0), (1.0, 8.001), (8.5, 9.0)):
        asked = {"waves": [REGULAR, {**noise, "band": band}], "hydro": {"omega_max": 8.0}}
        if band[1] == 8.0:
            assert varied(seed, **asked).waves[1].band == band
        else:
            with pytest.raises(ConfigError, match=r"waves.1.band .* rad/s: needs at most hydro.omega_max = 8"):
                varied(seed, **asked)
    assert varied(seed, hydro={"omega_max": 8.0, "omega": [1.0, 8.0]}).hydro.omega == (1.0, 8.0)
    with pytest.raises(ConfigError, match=r"hydro.omega 8.001 rad/s: needs at most hydro.omega_max = 8 rad/s"):
        varied(seed, hydro={"omega_max": 8.0, "omega": [1.0, 8.001]})
    longest = {**REGULAR, "period": 2 * np.pi / 8.0}
    assert varied(seed, waves=[REGULAR, longest], hydro={"omega_max": 8.0}).waves[1].omega == 8.0
    short = {**REGULAR, "period": 0.78}
    with pytest.raises(ConfigError, match=r"waves.1 regular_A0.1_T0.78: the wave is too short .* at least 0.7854 s"):
        varied(seed, waves=[REGULAR, short], hydro={"omega_max": 8.0})
    assert varied(seed, **{**PRESSED, "waves": [short]}).waves[0].omega > 8.0
    with pytest.raises(ConfigError, match=r"waves.2.direction 30 degrees: a buoy of revolution answers waves of all"):
        varied(seed, waves=[REGULAR, {"kind": "still"}, {**longest, "direction": 30.0}])


def test_buoy_floats_between_its_poles_and_above_the_bed(seed):
    """In water of another density as well."""
    full = 4 / 3 * np.pi * 8 * 900.0
    device = {"thickness": 1e-3, "density": 1.0}
    with pytest.raises(ConfigError, match=rf"kg: the buoy would sink; needs less than {full:.6g} kg"):
        varied(seed, device={**device, "mass": full}, water={"density": 900.0})
    pole = np.pi * 0.01**2 * 2.99 / 3 * 8 * 900.0  # of the water in a cap a hundredth of the radius high
    for mass in (1.001 * pole, full - 1.001 * pole):
        assert varied(seed, device={**device, "mass": mass}, water={"density": 900.0}).device.mass == mass
    for mass in (0.99999 * full, 1e-5 * full, 0.999 * pole, full - 0.999 * pole):
        with pytest.raises(ConfigError, match=r"because the waterplane is too small within 0.01 radii of a pole"):
            varied(seed, device={**device, "mass": mass}, water={"density": 900.0})
    with pytest.raises(ConfigError, match=rf"m: needs more than the draft of the buoy, {seed.draft:.4g} m"):
        varied(seed, water={"depth": seed.draft})
    assert varied(seed, water={"depth": 1.001 * seed.draft}).uses_panels
    just = {"water": {"depth": 1.02 * seed.draft}, "hydro": {"solver": "spectral"}}
    assert not varied(seed, **just).uses_panels
    assert not varied(seed, water=just["water"]).uses_panels


def test_window_without_one_is_the_last_third():
    assert Simulation(duration=300.0).window == (200.0, 300.0)
    assert Simulation().window == (40.0, 60.0)
    assert Simulation(duration=30.0, window=(5.0, 20.0)).window == (5.0, 20.0)


def test_limits_of_duration_and_window(seed):
    """A convolution's is shorter; a window is a part of the slowest motion."""
    fast, slow = {**REGULAR, "period": 1.0}, {**REGULAR, "period": 50.0}

    def asked(waves, method="auto", window=(40.0, 60.0), duration=60.0):
        simulation = {"duration": duration, "window": window, "method": method}
        return varied(seed, waves=waves, simulation=simulation)

    most = 2**16 / 200 * 1.0
    asked([slow, fast], "convolution", duration=0.999 * most).check_record()
    asked([slow, fast], duration=1.001 * most).check_record()
    with pytest.raises(ConfigError, match=r"needs at most 327.7 s in waves.1 regular_A0.1_T1, whose fastest .* all of"):
        asked([slow, fast], "convolution", duration=1.001 * most).check_record()
    asked([fast, slow], window=(58.99, 60.0)).check_record()
    with pytest.raises(ConfigError, match=r"needs to be at least 1 s long, because the motion in waves.1 .* takes 50"):
        asked([fast, slow], window=(59.01, 60.0)).check_record()


BODY = {"study": "raft", "body": {"database": "raft.nc"}, "designs": {"a": {}, "b": {"dofs": "rigid"}}}
SWELL, STILL = {"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "still"}


def study(**changes):
    return validated(BodyStudy, {**BODY, "waves": [SWELL], **changes}, "raft.yaml")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waves": [SWELL, STILL, SWELL]}, r"waves \['regular_A0.5_T7', 'still', 'regular_A0.5_T7'\]: the same sea is"),
        ({"study": "logs"}, "study: received 'logs'; 'logs' is the name of a results folder; choose another"),
        ({"pto": {"damping": {"a": 1.0}}}, "pto.damping: received dampers of a, needs one for every design: a, b"),
        ({"pto": {"damping": {}}}, "pto.damping: received dampers of no design, needs one for every design: a, b"),
        ({"published": {"source": "x", "values": {"d": {}, "a": {}, "c": {}}}}, r"published.values \['c', 'd'\]: no"),
    ],
)
def test_errors_common_to_both(changes, message):
    with pytest.raises(ConfigError, match=message):
        study(**changes)


def test_realisations_are_seas_of_their_own():
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 7.0, "realisations": 3}
    found = study(waves=[sea, STILL, {**SWELL, "direction": 20.0}])
    assert [wave.label for wave in found.one_of_each_sea] == ["jonswap_Hs1_Tp7_g3.3_s1", "regular_A0.5_T7_d20"]
    assert len(found.waves) == 5
    assert [(wave.seed, wave.realisations) for wave in found.waves[:3]] == [(1, 1), (2, 1), (3, 1)]
    assert found.has_spectra
    assert not study(waves=[STILL, SWELL]).has_spectra
    later = study(waves=[STILL, {**sea, "seed": 7}, {**sea, "tp": 5.0, "realisations": 1}])
    assert [wave.seed for wave in later.waves[1:]] == [7, 8, 9, 1]
    assert later.drawn_waves == (later.waves[0], later.waves[1], later.waves[4])
    assert later.one_of_each_sea == later.drawn_waves[1:]
    assert [found.tuning(wave) for wave in found.waves[-2:]] == ["fixed", "each"]
    with pytest.raises(ConfigError, match=r"waves.3 still: still water has no optimal damping"):
        found.check_dampers()


def test_damping_in_still_water():
    """Without waves the given damping holds; with other seas the tuned one holds in still water too."""
    for waves, tuned in (([STILL], "fixed"), ([STILL, SWELL], "one")):
        found = study(waves=waves, pto={"damping": 5.0, "tuning": "one"})
        assert found.tuning(found.waves[0]) == tuned
        assert [found.tuning(wave) for wave in found.waves[1:]] == [tuned] * (len(waves) - 1)
