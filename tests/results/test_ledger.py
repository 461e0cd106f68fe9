import ast
import importlib
import inspect
import json
import pkgutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from vsb import results
from vsb.errors import ConvergenceError
from vsb.hydro.database import Check, as_json, check_at_most
from vsb.results import ledger
from vsb.results.ledger import largest_displacement, largest_strain, static_modal_amplitude
from vsb.scenes.rest import reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.shell.elastic import ElasticShell
from vsb.shell.sphere import Shell
from vsb.study.shape import Spheroid
from vsb.study.study import Jonswap, RegularWave, StillWater, Water, WhiteNoise
from vsb.tools.words import plain
from vsb.waves.dispersion import power_limit, wavenumber


def test_the_vented_shell_of_the_seed_is_not_viable(seed):
    """Keel pressure about 20 kPa over the classical 303 Pa."""
    buckling, computed, static, strain = ledger.shell_checks(seed, reference_shell(seed))
    assert (buckling.name, buckling.verdict) == ("buckling", "fail")
    assert (computed.name, computed.verdict) == ("computed_buckling", "fail")
    assert computed.value == pytest.approx(1 / 0.018667, rel=1e-3)
    assert "viable from device.internal_pressure = 16320 Pa" in computed.explanation
    assert strain.verdict == "doubt"
    assert buckling.value == pytest.approx(1025 * 9.81 * seed.draft / 302.6138, rel=1e-4)
    assert static.value * 2.0 == pytest.approx(0.137, abs=0.001)
    rigid = varied(seed, designs={"FSB": {"flexible": False}})
    assert ledger.shell_checks(rigid, reference_shell(rigid)) == []


@settings(max_examples=3)
@given(st.floats(0.5, 4.0), st.floats(5e-3, 2e-2), st.floats(6.5, 8.0), st.sampled_from([None, 1.4]))
@example(2.0, 5e-3, 7.0, 1.4)
def test_the_pressure_advised_is_one_that_passes(seed, radius, slenderness, modulus, index):
    """Rounded for people it still holds, and what the classical formula says is a remark there; so of trapped gas."""
    device = {"radius": radius, "thickness": slenderness * radius, "young_modulus": 10.0**modulus}
    device["gas"] = index and {"adiabatic_index": index}
    vented = varied(seed, device={**device, "mass": 4.0 / 3.0 * np.pi * radius**3 * 512.0})
    text = ledger.viable_text(vented)
    assume(vented.device.internal_pressure == 0.0 and "viable from" in text)
    advised = float(text.split("internal_pressure = ")[1].split(" Pa")[0])
    assume(advised > 0.0)
    study = varied(vented, device={"internal_pressure": advised})
    classical, computed = ledger.shell_checks(study, reference_shell(study))[:2]
    assert (classical.name, classical.verdict) == ("buckling", "ok")
    assert (computed.name, computed.verdict) == ("computed_buckling", "ok")
    assert "a remark" in classical.explanation
    below = varied(vented, device={"internal_pressure": 0.99 * advised})
    (check,) = ledger.viability_checks(below)
    assert check.value > 1.0
    assert check.verdict == ("doubt" if ledger.carries_load(below) else "fail")


@pytest.mark.parametrize(("pressure", "verdict"), [(14.0e3, "fail"), (14.6e3, "doubt"), (16.4e3, "ok")])
def test_under_internal_pressure_the_nonlinear_path_decides_and_linear_buckling_is_advice(seed, pressure, verdict):
    """The seed's shell rests stably from 14.3 kPa on, by linear buckling from 16.32 kPa."""
    study = varied(seed, device={"internal_pressure": pressure})
    classical, computed = ledger.shell_checks(study, reference_shell(study))[:2]
    assert (computed.name, computed.verdict) == ("computed_buckling", verdict)
    assert (computed.value > 1.0) == (verdict != "ok")
    assert classical.verdict == ("fail" if verdict == "fail" else "ok")
    assert ("advice only" in computed.explanation) == (verdict == "doubt")


def test_static_modal_amplitude_balance_the_load_to_first_order(seed):
    basis = study_basis(seed)
    static = static_modal_amplitude(seed, reference_shell(seed))
    assert static[1] == pytest.approx(-0.06, abs=0.02)  # the breathing mode is squeezed by about 6 cm

    def unbalance(scale):
        shell = DeformedShell(basis, seed.centre_height, scale * static)
        load = shell.hydrostatic_force(1025.0, 9.81) - 9.81 * basis.inertia[0]
        return np.abs(load - basis.stiffness @ (scale * static)).max()

    rest = DeformedShell(basis, seed.centre_height).hydrostatic_force(1025.0, 9.81) - 9.81 * basis.inertia[0]
    assert unbalance(1.0) < 0.1 * np.abs(rest).max()


def test_strain_and_displacement_of_breathing(seed):
    basis = study_basis(seed)
    breathing = np.array([9.9, 0.1, 0, 0, 0, 0, 0, 0])  # heave does not strain
    assert largest_strain(basis, breathing) == pytest.approx(0.05)
    assert largest_displacement(basis, breathing) == pytest.approx(0.1)


@pytest.mark.parametrize("mode", range(1, 8))
def test_the_largest_strain_is_that_of_the_elastic_shell(seed, mode):
    """Of every mode, along the meridian and around: to first order in its amplitude."""
    basis = study_basis(seed)
    q = 1e-7 * np.eye(len(basis.labels))[mode]
    strains = ElasticShell(basis).strains(q, np.linspace(0.01, np.pi - 0.01, 361))
    assert largest_strain(basis, q) == pytest.approx(np.abs(strains).max(), rel=1e-5)


def test_pressure_inside_carries_its_part_of_the_water_at_the_keel(seed):
    study = varied(seed, device={"internal_pressure": 5000.0})
    check = ledger.classical_check(study, reference_shell(study), carried=False)
    assert check.value == pytest.approx((1025 * 9.81 * seed.draft - 5000.0) / 302.6138, rel=1e-4)


def test_gas_that_expands_with_the_shell_carries_less_of_the_water_at_the_keel(seed):
    """Of a stiff shell as by Boyle's and Poisson's law of its volume at rest, to first order in the load or beyond."""
    device = {"internal_pressure": 2e4, "gas": {"adiabatic_index": 1.4}, "young_modulus": 1e9}
    found = []
    for shape in ("undeformed", "equilibrium"):
        study = varied(seed, device=device, reference_shape=shape)
        reference = reference_shell(study)
        found.append(ledger.pressure_at_rest(study, reference))
        keel = 1025 * 9.81 * reference.keel_depth - found[-1]
        check = ledger.classical_check(study, reference, carried=False)
        assert check.value * Shell.of(study.device).buckling_pressure == pytest.approx(max(0.0, keel))
    volume = ElasticShell(reference.basis).volume(reference.modal_amplitude)
    whole = (101325.0 + 2e4) * (32 / 3 * np.pi / volume) ** 1.4 - 101325.0
    assert found[1] == pytest.approx(whole, abs=1e-6)
    assert 0.005 * 2e4 < 2e4 - found[1] < 0.1 * 2e4
    assert found[0] == pytest.approx(whole, rel=5e-3)


def test_what_was_accepted_stands_before_what_is_in_doubt():
    verdicts = ("ok", "doubt", "accepted", "fail", "ok")
    checks = [Check(str(i), 0.0, 1.0, "-", verdict, "") for i, verdict in enumerate(verdicts)]
    assert [check.name for check in ledger.worst_first(checks)] == ["3", "2", "1", "0", "4"]


def test_waves_are_checked_for_steepness_and_band():
    mild, steep = (RegularWave(kind="regular", amplitude=a, period=4.0) for a in (0.1, 1.0))
    assert ledger.wave_checks(mild, Water(), 12.0)[0].value == pytest.approx(0.2 / (9.81 * 16 / (2 * np.pi)))
    assert ledger.wave_checks(steep, Water(), 12.0)[0].verdict == "doubt"
    cut = ledger.wave_checks(Jonswap(kind="jonswap", hs=0.5, tp=4.0), Water(), 2.0)[1]
    assert cut.name.startswith("spectrum_cut")
    assert cut.verdict != "ok"
    assert cut.explanation == "share of the sea above hydro.omega_max"
    below = ledger.wave_checks(Jonswap(kind="jonswap", hs=0.5, tp=4.0), Water(), 2.0, 1.4)[1]
    assert below.value > cut.value
    assert "beyond 1.4 to 2 rad/s of the database" in below.explanation
    assert ledger.wave_checks(StillWater(kind="still"), Water(), 12.0) == []


def test_ledger_is_plain_json():
    data = json.loads(ledger.ledger_json("s", [Check("buckling", 66.0, 1.0, "-", "fail", "why")]))
    assert data["checks"][0] == {
        "name": "buckling", "design": "", "wave": "", "value": 66.0, "limit": 1.0, "unit": "-", "verdict": "fail", "explanation": "why",
    }  # fmt: skip


def test_a_ledger_has_numbers_alone():
    """What is none is no JSON; the study is named."""
    assert json.loads(ledger.ledger_json("a_study", [])) == {"study": "a_study", "checks": [], "invalid": []}
    for value in (np.nan, np.inf):
        with pytest.raises(ValueError, match="Out of range float values are not JSON compliant"):
            ledger.ledger_json("s", [Check("buckling", value, 1.0, "-", "fail", "why")])


def run_with(**attrs):
    return xr.Dataset(attrs=attrs)


def test_a_transient_left_in_the_window_shows():
    runs = {(d, "w"): {"steady_power": 100.0, "steady_decay": 0.5} for d in "AB"} | {
        ("C", "w"): {"no_steady_state": "grows"}, ("D", "w"): {},
        ("E", "w"): {"steady_power": 100.0, "steady_unsettled": 2e-5},
    }  # fmt: skip
    powers = (100.1, 103.0, 5.0, 5.0, 101.0)
    rows = [{"design": d, "wave": "w", "power_mean": p} for d, p in zip("ABCDE", powers, strict=True)]
    near, far, none, settled = ledger.transient_checks(runs, rows)
    assert (near.verdict, far.verdict, none.verdict, settled.verdict) == ("ok", "fail", "doubt", "doubt")
    assert settled.explanation.endswith("100 W in the steady state; its periods differ by 2.0e-05")
    assert near.value == pytest.approx(1e-3)
    assert "a period leaves 0.5 of a transient" in far.explanation
    assert "grows" in none.explanation


def test_what_the_automatic_model_left_out_is_in_the_ledger_with_its_error(seed):
    study = varied(seed, hydro={"model": "auto"}, designs={"FSB": {"flexible": False}, "VSWEC": {}})
    (wave,) = study.waves
    left_out = json.dumps([{"what": "shell_modes", "error": 0.002}])
    common = {"description": "linear, rigid, 8 memory states", "left_out": left_out}
    runs = {"FSB": run_with(power_error=0.002, **common), "VSWEC": run_with(power_error=0.02, **common)}
    fixed, flexible, gain = ledger.simplification_checks(study, wave, runs)
    assert (fixed.verdict, flexible.verdict) == ("ok", "fail")
    assert fixed.explanation.endswith("described as linear, rigid, 8 memory states; left out: shell modes 2.0e-03")
    assert (gain.design, gain.value, gain.verdict) == ("VSWEC", pytest.approx(0.022), "fail")
    runs["FSB"] = run_with(power_error=0.0, **common)  # nothing left out: gains over it are judged all the same
    *_, gain = ledger.simplification_checks(study, wave, runs)
    assert (gain.name, gain.design, gain.value) == ("gain_error", "VSWEC", pytest.approx(0.02))


@pytest.mark.parametrize(
    ("band", "share"),
    [
        ((1.0, 3.0), 0.5),
        ((1.0, 2.0), 0.0),
        ((2.0, 3.0), 1.0),
        ((2.5, 3.0), 1.0),
        ((1.0, 2.001), 1e-3),
        ((1.9, 2.0011), 0.011),
    ],
)
def test_white_noise_beyond_the_band_is_cut(band, share):
    """By as much as there is, however little: no quadrature would meet it."""
    (_, cut) = ledger.wave_checks(WhiteNoise(kind="white_noise", hs=0.5, band=band), Water(), 2.0)
    assert cut.value == pytest.approx(share, rel=0.02)
    assert (cut.verdict == "ok") == (share < 0.01)


@pytest.mark.parametrize(("lowest", "highest", "share"), [(1.25, 2.5, 0.375), (0.5, 2.5, 0.25), (1.25, 3.5, 0.125)])
def test_what_is_cut_below_a_body_s_band_and_above_it_adds_up(lowest, highest, share):
    """Of a flat spectrum from 1 to 3 rad/s the part of the band that is left out."""
    sea = WhiteNoise(kind="white_noise", hs=0.5, band=(1.0, 3.0))
    (_, cut) = ledger.wave_checks(sea, Water(), highest, lowest)
    assert cut.value == pytest.approx(share, rel=1e-9)


CHECKS = {  # name: limit, unit, whether up to five times it is a doubt
    "pitch": (0.3, "rad", True), "surge": (0.5, "-", True), "rotation": (0.2, "rad", True),
    "translation": (0.3, "-", True), "constrained": (0.005, "-", True), "buckling": (1.0, "-", False),
    "power_limit": (1.01, "-", False), "computed_buckling": (1.0, "-", False), "static_strain": (0.02, "-", True),
    "steepness": (0.05, "-", True), "heave": (0.3, "-", True), "passivity": (1e-12, "-", False),
    "spectrum_cut": (0.01, "-", True), "deformation": (0.1, "-", True), "strain": (0.02, "-", True),
    "assumed_pressure": (1.0, "-", False), "transient": (0.005, "-", True),
    "pause": (0.8, "-", True), "time_and_frequency_domain": (0.005, "-", True), "linearity": (0.05, "-", True),
    "drag": (0.05, "-", True), "constraint_drift": (1e-9, "m", False), "statistical_error": (0.1, "-", True),
    "record_length": (1.0, "-", True),
}  # fmt: skip
OF_THE_STUDY = {
    "static_deformation",
    "radiation_fit",
    "left_out",
    "modes_left_out",
    "gain_error",
    "energy_residual",
    "spectral_prediction",
}
"""Checks whose limits a study says; each has cases of its own."""


def calls_of(module):
    """The calls of `check_at_most` in a module, as (name, limit, unit, doubt); no limit where a study says it."""
    for node in ast.walk(ast.parse(inspect.getsource(module))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "check_at_most":
            name, _, limit, unit = (ast.unparse(arg) for arg in node.args[:4])
            known = not {n.id for n in ast.walk(node.args[2]) if isinstance(n, ast.Name)} - vars(module).keys()
            doubt = [ast.unparse(k.value) for k in node.keywords if k.arg == "doubt"]
            value = eval(limit, vars(module)) if known else None
            yield ast.literal_eval(name), value, ast.literal_eval(unit), doubt == ["True"]


def test_every_limit_has_an_ok_below_and_a_doubt_or_a_failure_above():
    rooms = [importlib.import_module(f"vsb.results.{one.name}") for one in pkgutil.iter_modules(results.__path__)]
    found = {name: told for room in rooms for name, *told in calls_of(room)}
    assert {name for name, (limit, *_) in found.items() if limit is None} == OF_THE_STUDY
    assert {name: tuple(told) for name, told in found.items() if told[0] is not None} == CHECKS
    for name, (limit, unit, doubt) in CHECKS.items():
        below, above, far = (
            check_at_most(name, part * limit, limit, unit, "", doubt=doubt).verdict for part in (0.999, 1.001, 5.001)
        )
        assert (below, above, far) == ("ok", "doubt" if doubt else "fail", "fail")


def test_an_equilibrium_may_lie_farther_from_the_sphere_than_what_is_linearised_about(seed, monkeypatch):
    monkeypatch.setattr(
        ledger, "static_modal_amplitude", lambda study, reference: np.zeros(len(reference.basis.labels))
    )
    reference = reference_shell(seed)
    for shape, limit in (("undeformed", 0.05), ("equilibrium", 0.2)):
        static, _ = ledger.static_checks(varied(seed, reference_shape=shape), reference)
        assert (static.limit, static.value) == (limit, 0.0)
        assert ("undeformed" in static.explanation) == (shape == "undeformed")


ABOUT = {
    "": {
        "buckling", "computed_buckling", "static_deformation", "static_strain", "power_limit", "radiation_fit",
        "passivity", "hydro error_estimate", "hydro interpolation_error", "hydro limit_difference", "hydro symmetry",
        "hydro positive_damping", "hydro rank_one", "hydro haskind", "hydro irregular_frequencies",
        "hydro kramers_kronig",
    },
    "wave": {"steepness", "reference_power"},
    "design wave": {
        "transient", "time_and_frequency_domain", "modes_left_out", "fair_damping", "energy_residual", "heave",
        "deformation", "strain",
    },
}  # fmt: skip
"""What checks name, the study's own aside."""


def test_every_check_names_the_design_and_the_sea_it_is_about(small):
    with open(f"{small.folder}/validity.json", encoding="utf-8") as file:
        checks = json.load(file)["checks"]
    found = {}
    for check in checks:
        about = " ".join(key for key in ("design", "wave") if check[key])
        found.setdefault(about, set()).add(check["name"])
        assert check["design"] in ("", *small.study.designs)
        assert check["wave"] in ("", *(wave.label for wave in small.study.waves))
    assert found == ABOUT


@pytest.mark.parametrize(("computed", "classical", "told"), [(0.9, 1.1, True), (1.1, 0.9, False), (1.0, 0.9, False)])
def test_a_shell_that_buckles_as_computed_is_told_what_would_hold_it(seed, monkeypatch, computed, classical, told):
    found = SimpleNamespace(load_factor=computed, classical_factor=classical, degree=7)
    monkeypatch.setattr(ledger, "computed_buckling", lambda study: found)
    monkeypatch.setattr(ledger, "viable_text", lambda study: "; viable from much")
    (check,) = ledger.viability_checks(seed)
    assert (check.value, check.limit, check.verdict) == (1 / computed, 1.0, "fail" if told else "ok")
    assert check.explanation.endswith("into a shape of degree 7" + "; viable from much" * told)


@pytest.mark.parametrize(("model", "left_out"), [("linear", []), ("body_exact", []), ("auto", ["left out"])])
def test_what_is_left_out_is_told_of_the_automatic_model_alone(seed, monkeypatch, model, left_out):
    monkeypatch.setattr(ledger, "run_checks", lambda study, basis, run: [run])
    monkeypatch.setattr(ledger, "simplification_checks", lambda *_: ["left out"])
    study = varied(seed, hydro={"model": model})
    runs = {design: f"checks of {design}" for design in study.designs}
    assert ledger.sea_checks(study, None, study.waves[0], runs) == [*runs.values(), *left_out]
    flexible = varied(study, designs={name: d for name, d in study.model_dump()["designs"].items() if d["flexible"]})
    assert flexible.reference_design is None  # nor does it need a rigid one
    assert ledger.sea_checks(flexible, None, study.waves[0], runs)[len(flexible.designs) :] == left_out


def test_what_is_not_known_stands_above_its_limit(seed):
    transient = ledger.transient_checks({("A", "w"): {"no_steady_state": "grows"}}, [{"design": "A", "wave": "w"}])
    shaped = seed.model_copy(update={"device": seed.device.model_copy(update={"shape": Spheroid(height=3.0)})})
    witness = ledger.witness_checks(shaped, None, None)
    assert [check.explanation for check in witness] == ["no second solver: panels are those of the sphere"]
    for check in (*transient, *witness):
        assert (check.value, check.limit, check.verdict) == (1.0, 0.0, "doubt")
    assert ledger.witness_checks(varied(seed, hydro={"witness": "none"}), None, None) == []


@pytest.mark.parametrize("asked", [None, 0.03])
def test_what_was_left_out_is_judged_by_the_tolerance_asked_for_and_gains_by_twice_it(seed, asked):
    """Of the same error in both designs: below and above it, or a hundredth where none is asked for."""
    study = varied(
        seed, hydro={"model": "auto", "power_tolerance": asked}, designs={"FSB": {"flexible": False}, "VSWEC": {}}
    )
    limit = asked or 0.01
    for part, verdict in ((0.99, "ok"), (1.01, "fail")):
        said = {"description": "-", "left_out": "[]", "power_error": part * limit}
        checks = ledger.simplification_checks(study, study.waves[0], {d: run_with(**said) for d in study.designs})
        assert [(check.name, check.verdict) for check in checks] == [
            ("left_out", verdict), ("left_out", verdict), ("gain_error", verdict),
        ]  # fmt: skip
        assert [check.limit for check in checks] == [limit, limit, 2 * limit]


def test_what_a_database_says_of_its_own_errors_is_allowed_it_beside_a_second_solver(seed, monkeypatch):
    """Both of them: of the solver, and of the interpolation between its frequencies; of nothing else."""
    own = [Check(n, v, 1.0, "-", "ok", "") for n, v in (("error_estimate", 1e-4), ("interpolation_error", 2e-4))]
    ds = xr.Dataset(attrs={"quality": as_json([*own, Check("haskind", 0.5, 1.0, "-", "ok", "")])})
    asked = []
    monkeypatch.setattr(ledger.witness, "witness_checks", lambda found: [f"shapes of {found}"])
    monkeypatch.setattr(ledger.witness, "database_checks", lambda *given: asked.append(given[1:]) or ["database"])
    study = varied(seed, hydro={"witness": "auto"})
    assert ledger.witness_checks(study, ds, "both") == ["shapes of both", "database"]
    assert asked == [(ds, pytest.approx(3e-4))]


def test_what_is_known_of_buckling_goes_by_the_shape_and_by_where_it_is_reckoned(seed, monkeypatch):
    """No classical criterion of a shape that is no sphere; about the equilibrium, which holds, it is a remark."""
    told = Check("computed_buckling", 0.5, 1.0, "-", "ok", "")
    found, carried = [told], []
    monkeypatch.setattr(ledger, "static_checks", lambda *_: ["static"])
    monkeypatch.setattr(ledger, "viability_checks", lambda study: found)
    monkeypatch.setattr(ledger, "classical_check", lambda study, reference, held: carried.append(held) or "classical")
    assert ledger.shell_checks(seed, None) == ["classical", told, "static"]
    found = []
    assert ledger.shell_checks(seed, None) == ["classical", "static"]
    found = [replace(told, verdict="doubt")]
    ledger.shell_checks(seed, None)
    found = [replace(told, verdict="fail")]
    ledger.shell_checks(seed, None)
    assert carried == [True, True, True, False]
    shaped = seed.model_copy(update={"device": seed.device.model_copy(update={"shape": Spheroid(height=3.0)})})
    assert ledger.shell_checks(shaped, None) == [*found, "static"]


def test_whether_a_shape_that_is_no_sphere_buckles_is_not_known_and_about_an_equilibrium_nothing_is_to_be_said(seed):
    shaped = seed.model_copy(update={"device": seed.device.model_copy(update={"shape": Spheroid(height=3.0)})})
    (check,) = ledger.viability_checks(shaped)
    assert (check.name, check.value, check.limit, check.verdict) == ("computed_buckling", 1.0, 1.0, "doubt")
    assert ledger.viability_checks(varied(seed, reference_shape="equilibrium")) == []


@pytest.mark.parametrize(
    ("pressure", "advised"), [(12341.2, 12350), (12348.0, 12350), (12340.0, 12340), (987.61, 987.7)]
)
def test_the_pressure_advised_is_rounded_up_in_its_fourth_digit(seed, monkeypatch, pressure, advised):
    found = SimpleNamespace(linear_strain=0.01234)
    monkeypatch.setattr(ledger, "viable_pressure", lambda *_: (pressure, found))
    expected = f"; by linear buckling viable from device.internal_pressure = {plain(advised)} Pa, at 1.2 % linear strain at rest"
    assert ledger.viable_text(seed) == expected


def test_where_no_pressure_makes_a_shell_viable_that_is_said(seed, monkeypatch):
    def none(*_):
        raise ConvergenceError("no pressure carries it")

    monkeypatch.setattr(ledger, "viable_pressure", none)
    assert ledger.viable_text(seed) == "; no pressure carries it"


def test_a_shell_squeezed_at_rest_is_measured_as_one_that_is_blown_up(seed, monkeypatch):
    """By 0.1 m of 2.5 m: 4 % either way, of strain 4 % and half their square."""
    study = varied(seed, device={"radius": 2.5})
    reference = reference_shell(study)
    for sign in (1, -1):
        breathing = sign * 0.1 * np.eye(len(reference.basis.labels))[1]
        monkeypatch.setattr(ledger, "static_modal_amplitude", lambda *_, moved=breathing: moved)
        static, strain = ledger.static_checks(study, reference)
        assert (static.value, strain.value) == pytest.approx((0.04, 0.04 + sign * 0.04**2 / 2), rel=1e-9)


def test_a_sea_is_as_steep_as_its_depth_and_its_height_make_it():
    """Regular by twice its amplitude, irregular by its significant height; every check names the sea."""
    water = Water(depth=6.0, gravity=9.0)
    swell = RegularWave(kind="regular", amplitude=0.3, period=6.0)
    sea = Jonswap(kind="jonswap", hs=0.5, tp=7.0)
    for wave, height in ((swell, 0.6), (sea, 0.5)):
        checks = ledger.wave_checks(wave, water, 12.0)
        assert checks[0].value == pytest.approx(height * wavenumber(wave.omega, 6.0, 9.0) / (2 * np.pi), rel=1e-12)
        assert {check.wave for check in checks} == {wave.label}
        assert len(checks) == (1 if wave is swell else 2)


def moved(study, **at):
    """A run of 60 s at rest but for some motions [m] at some instants [s], by name of the motion."""
    labels = list(study_basis(study).labels)
    position = np.zeros((61, len(labels)))
    for name, (second, value) in at.items():
        position[second, labels.index(name)] = value
    attrs = {"design": "VSWEC", "wave": "w", "energy_residual": 0.0}
    return xr.Dataset({"position": (("time", "dof"), position)}, {"time": np.arange(61.0), "dof": labels}, attrs)


def test_a_run_is_judged_by_the_most_it_does_downwards_and_inwards_too(seed, monkeypatch):
    """Heave by itself, the shell where all of it is most out of shape, attitude in the window alone."""
    seen = []
    monkeypatch.setattr(ledger, "attitude_checks", lambda study, run: seen.append(run.time.values.tolist()) or ["even"])
    monkeypatch.setattr(ledger, "drift_checks", lambda study, run: [f"held over {len(run.time)} instants"])
    run = moved(seed, Heave=(45, -0.28), Membrane0=(50, -0.3), Membrane1=(45, 0.05))
    energy, heave, *held, deformation, strain = ledger.run_checks(seed, study_basis(seed), run)
    assert (energy.name, held) == ("energy_residual", ["held over 61 instants", "even"])
    assert seen == [list(np.arange(40.0, 61.0))]
    assert (heave.value, deformation.value, strain.value) == pytest.approx((0.14, 0.15, 0.15), rel=1e-6)
    assert {(check.design, check.wave) for check in (energy, heave, deformation, strain)} == {("VSWEC", "w")}


def test_all_that_is_left_out_is_told_and_what_could_not_be_measured_is_a_doubt(seed):
    """Of two designs each by itself; a power that is within its tolerance is doubted all the same."""
    study = varied(seed, hydro={"model": "auto"}, designs={"FSB": {"flexible": False}, "VSWEC": {}})
    (wave,) = study.waves
    parts = json.dumps([{"what": "shell_modes", "error": 2e-3}, {"what": "wet_shape", "error": 1e-4}])
    known = run_with(power_error=0.003, description="linear", left_out=parts)
    blind = run_with(power_error=0.004, description="exact", left_out="[]", unmeasured="no steady state")
    checks = ledger.simplification_checks(study, wave, {"VSWEC": blind, "FSB": known})
    assert [(c.name, c.design, c.wave, c.verdict) for c in checks] == [
        ("left_out", "FSB", wave.label, "ok"), ("left_out", "VSWEC", wave.label, "doubt"), ("gain_error", "VSWEC", wave.label, "ok"),
    ]  # fmt: skip
    assert [c.value for c in checks] == [0.003, 0.004, pytest.approx(0.007)]
    assert [c.explanation for c in checks[:2]] == [
        "estimated error of mean power; described as linear; left out: shell modes 2.0e-03, wet shape 1.0e-04",
        "errors of simplifications could not be measured (no steady state); estimated error of mean power; described as "
        "exact; left out: -",
    ]


def test_the_limit_of_absorbed_power_is_told_as_the_response_names_it():
    of = xr.Dataset({"absorbed_power": (("design", "omega"), [[1.0, 3.0]]), "power_limit": ("omega", [2.0, 4.0])})
    for attrs, named in (({}, "an axisymmetric heaving body"), ({"limit": "three motions"}, "three motions")):
        check = ledger.limit_check(of.assign_attrs(attrs))
        assert check.value == 0.75
        assert check.explanation == f"largest absorbed power over the limit of {named}, within mesh error"


def test_what_a_wave_of_an_assumed_pressure_could_give_is_that_of_its_depth_and_its_water(seed):
    water = {"depth": 5.0, "density": 900.0, "gravity": 9.0}
    wave = {"kind": "regular", "amplitude": 0.5, "period": 6.0}
    study = varied(seed, hydro={"model": "assumed_pressure", "pressure": 0.2 * 900 * 9.0}, water=water, waves=[wave])
    (one,) = study.waves
    most = power_limit(one.omega, 5.0, 900.0, 9.0) * 0.04
    (check,) = ledger.assumed_pressure_checks(study, [{"design": "FSB", "wave": one.label, "power_mean": 0.6 * most}])
    assert check.value == pytest.approx(0.6, rel=1e-9)
    assert "a wave of the same surface pressure, 0.2 m in amplitude, can give" in check.explanation


def test_a_shell_whose_gas_carries_more_than_the_water_at_the_keel_has_nothing_to_carry(seed):
    study = varied(seed, device={"internal_pressure": 5e4})
    for carried in (True, False):
        check = ledger.classical_check(study, reference_shell(study), carried)
        assert (check.value, check.verdict) == (0.0, "ok")
        assert check.explanation.startswith("net pressure at the keel 0 Pa over the classical buckling pressure ")
    failing = ledger.classical_check(seed, reference_shell(seed), carried=False)
    assert replace(failing, verdict="ok", explanation="") == replace(
        ledger.classical_check(seed, reference_shell(seed), carried=True), explanation=""
    )
    assert failing.explanation.endswith("above 1 the shell would buckle and the design is not viable")


def test_nothing_absorbed_where_nothing_can_be_is_within_the_limit():
    of = xr.Dataset({"absorbed_power": (("design", "omega"), [[0.0, 1.0]]), "power_limit": ("omega", [0.0, 4.0])})
    assert ledger.limit_check(of).value == 0.25
    assert ledger.limit_check(0.0 * of).value == 0.0
    of["absorbed_power"] = (("design", "omega"), [[0.0, 1.0], [0.0, 5.0]])  # the second of two designs
    assert (ledger.limit_check(of).value, ledger.limit_check(of).verdict) == (1.25, "fail")


def test_the_design_that_takes_most_of_an_assumed_pressure_is_told_wave_by_wave(seed):
    waves = [{"kind": "regular", "amplitude": 0.5, "period": period} for period in (6.0, 4.0)]
    waves.insert(1, {"kind": "still"})
    study = varied(seed, hydro={"model": "assumed_pressure", "pressure": 2000.0}, waves=waves)
    amplitude = 2000.0 / (study.water.density * study.water.gravity)
    first, _, second = study.waves
    powers = {first: (300.0, 500.0), second: (900.0, 700.0)}
    rows = [
        {"design": design, "wave": wave.label, "power_mean": power}
        for wave, both in powers.items()
        for design, power in zip(("FSB", "VSWEC"), both, strict=True)
    ]
    checks = ledger.assumed_pressure_checks(study, rows)
    assert [(check.design, check.wave) for check in checks] == [("VSWEC", first.label), ("FSB", second.label)]
    for check, wave, most in zip(checks, (first, second), (500.0, 900.0), strict=True):
        limit = power_limit(wave.omega, np.inf, study.water.density, study.water.gravity) * amplitude**2
        assert check.value == pytest.approx(most / limit, rel=1e-9)


@pytest.mark.parametrize(("margin", "value"), [(0.3, 0.0), (0.0, 0.0), (-0.3, 0.3)])
def test_a_model_of_radiation_is_judged_by_its_fit_and_by_what_it_would_give_back(margin, value):
    model = xr.Dataset(attrs={"order": 7, "fit_error": 2e-3, "passivity_margin": margin})
    for tolerance, verdict in ((3e-3, "ok"), (1e-3, "doubt")):
        fit, passive = ledger.radiation_checks(model, tolerance)
        assert (fit.name, fit.value, fit.limit, fit.verdict) == ("radiation_fit", 2e-3, tolerance, verdict)
        assert fit.explanation.startswith("rms error of the 7-state radiation model")
        assert (passive.name, passive.value) == ("passivity", value)
        assert passive.verdict == ("ok" if value == 0 else "fail")


def test_shells_that_move_aside_too_are_measured_with_all_their_motions_and_in_the_window_alone(seed, monkeypatch):
    """What happens before the window is of no account; where the buoy has more motions, all of them make the largest."""
    asked = []

    def largest(basis, orders, peaks):
        asked.append((orders, peaks.tolist()))
        return 0.4, 0.7

    monkeypatch.setattr(ledger, "largest_deformation", largest)
    run = moved(seed, Heave=(45, -0.28), Membrane0=(50, -0.3), Membrane1=(45, 0.05))
    run.position[5] = 9.0
    basis = study_basis(seed)
    _, heave, deformation, strain = ledger.run_checks(seed, basis, run)
    assert (heave.value, deformation.value, strain.value) == pytest.approx((0.14, 0.15, 0.15), rel=1e-6)
    assert asked == []
    monkeypatch.setattr(ledger, "order_bases", lambda *_: "orders")
    wide = seed.model_copy(update={"device": seed.device.model_copy(update={"radius": 2.5})})
    _, heave, deformation, strain = ledger.run_checks(wide, basis, run)
    assert (heave.value, deformation.value, strain.value) == pytest.approx((0.112, 0.16, 0.7))
    assert asked == [("orders", run.position.values[50].tolist())]


def test_a_transient_is_told_in_the_power_of_the_window_and_of_the_steady_state_of_its_own_run():
    runs = {("A", w): {"steady_power": p, "steady_decay": 0.1} for w, p in (("v", 50.0), ("w", -200.0))}
    runs["A", "v"]["no_steady_state"] = "none"
    rows = [{"design": "A", "wave": w, "power_mean": p} for w, p in (("v", 60.0), ("w", -150.0))]
    none, slow = ledger.transient_checks(runs, rows)
    assert (none.wave, none.value, none.verdict) == ("v", 1.0, "doubt")
    assert (slow.wave, slow.value) == ("w", pytest.approx(0.25))
    assert slow.explanation == (
        "mean power is -150 W in the window, -200 W in the steady state; a period leaves 0.1 of a transient"
    )


def test_the_shell_at_rest_is_that_of_the_equilibrium_or_what_the_load_about_the_reference_makes_of_it(monkeypatch):
    asked = []

    def loaded(study, basis):
        asked.append((study, basis))
        return SimpleNamespace(force=lambda q: np.array([1.0, 2.0]) + q)

    monkeypatch.setattr("vsb.scenes.viability.loaded_shell", loaded)
    at, total = np.array([0.5, -0.25]), np.array([[2.0, 1.0], [0.0, 4.0]])
    reference = SimpleNamespace(modal_amplitude=at, total=total, basis="basis")
    assert static_modal_amplitude(SimpleNamespace(at_equilibrium=True), reference) is at
    assert asked == []
    study = SimpleNamespace(at_equilibrium=False)
    assert static_modal_amplitude(study, reference) == pytest.approx([(1.5 - 1.75 / 4) / 2, 1.75 / 4])
    assert asked == [(study, "basis")]


def test_a_steady_state_in_which_nothing_is_taken_is_one_to_compare_with():
    """What the window has is all of the difference, in watts; where nothing is told of a steady state there is none."""
    runs = {("A", "w"): {"steady_power": 0.0, "steady_decay": 0.1}, ("B", "w"): {}}
    rows = [{"design": design, "wave": "w", "power_mean": -0.02} for design in "AB"]
    (left,) = ledger.transient_checks(runs, rows)
    assert (left.design, left.value, left.limit) == ("A", 0.02, 0.005)
    assert left.verdict != "ok"
    assert "-0.02 W in the window, 0 W in the steady state" in left.explanation


def test_the_pressure_advised_is_of_the_shell_as_it_floats_in_its_water(seed, monkeypatch):
    asked = []
    found = (2e4, SimpleNamespace(linear_strain=0.01))
    monkeypatch.setattr(ledger, "viable_pressure", lambda *given: asked.append(given) or found)
    study = varied(seed, water={"density": 1000.0, "depth": 30.0}, device={"mass": 14e3})
    ledger.viable_text(study)
    assert asked == [(study.device, study.centre_height, study.water)]
    assert study.centre_height > 0.1
