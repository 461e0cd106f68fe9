"""Every check of the ledger is ok 1 % below its limit and not ok 1 % above it."""

from dataclasses import asdict, replace

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from scipy.optimize import brentq

from vsb.hydro import witness
from vsb.results import ledger, run_checks
from vsb.results.budget import Source
from vsb.results.equal_tuning import Tuned, fair_damping_checks, reference_power_checks
from vsb.results.ladder import Rung
from vsb.results.rung_errors import MODES
from vsb.results.statistics import FEWEST_BATCHES, Line, statistical_checks
from vsb.scenes.rest import reference_shell, study_basis
from vsb.study.study import PiersonMoskowitz, RegularWave, Water
from vsb.study.take_off import Pto
from vsb.waves.dispersion import power_limit

WAVE = RegularWave(kind="regular", amplitude=0.5, period=4.0)
LENGTH = 2 * np.pi * 9.81 / WAVE.omega**2
TIME = np.linspace(0.0, 60.0, 61)


def run(heave=0.0, breathing=0.0, residual=0.0, **attrs):
    """A run that heaves and breathes at 50 s only."""
    position = np.zeros((61, 8))
    position[50, :2] = heave, breathing
    labels = ["Heave", *(f"Membrane{n}" for n in range(7))]
    attrs = {"design": "VSWEC", "wave": "w", "energy_residual": residual, **attrs}
    return xr.Dataset({"position": (("time", "dof"), position)}, coords={"time": TIME, "dof": labels}, attrs=attrs)


def of_run(study, **motion):
    return ledger.run_checks(study, study_basis(study), run(**motion))


def of_auto(study, errors):
    """Errors of the automatic model in both designs."""
    two = varied(study, hydro={"model": "auto"}, designs={"FSB": {"flexible": False}, "VSWEC": {}})
    attrs = {"description": "linear", "left_out": "[]"}
    runs = {d: xr.Dataset(attrs={"power_error": e, **attrs}) for d, e in zip(two.designs, errors, strict=True)}
    return ledger.simplification_checks(two, two.waves[0], runs)


def of_wave(height):
    return ledger.wave_checks(RegularWave(kind="regular", amplitude=height / 2, period=4.0), Water(), 12.0)


def of_band(share):
    """A fully developed sea of which 1 - exp(-1.25 (omega_p/omega)^4) lies above 2 rad/s."""
    peak = 2.0 * (-np.log(1 - share) / 1.25) ** 0.25
    return ledger.wave_checks(PiersonMoskowitz(kind="pierson_moskowitz", hs=0.01, tp=2 * np.pi / peak), Water(), 2.0)


def of_lines(study, half=1.0, apart=0.0, batches=20):
    low, high = (None, None) if batches < FEWEST_BATCHES else (100.0 - half, 100.0 + half)
    line = Line("FSB", "sea", "random", 1, batches, 100.0 + apart, low, high, 90.0, 100.0, None, None, None)
    return statistical_checks(study, [line])


def of_radiation(study, error=0.0, margin=0.0):
    attrs = {"order": 8, "fit_error": error, "passivity_margin": margin}
    return ledger.radiation_checks(xr.Dataset(attrs=attrs), study.hydro.tolerance)


def of_limit(share):
    ds = xr.Dataset({"absorbed_power": (("design", "omega"), [[1.0, share]]), "power_limit": ("omega", [2.0, 1.0])})
    return [ledger.limit_check(ds)]


def of_pressure(study, share):
    """Mean power as a share of the limit of a wave with the same pressure."""
    pressure = 0.3 * 1025 * 9.81
    assumed = varied(study, hydro={"model": "assumed_pressure", "pressure": pressure}, waves=[WAVE.model_dump()])
    best = share * power_limit(WAVE.omega, np.inf, 1025.0, 9.81) * 0.3**2
    rows = [{"design": d, "wave": WAVE.label, "power_mean": p} for d, p in (("FSB", 0.5 * best), ("VSWEC", best))]
    return ledger.assumed_pressure_checks(assumed, rows)


def of_transient(difference):
    runs = {("FSB", "w"): {"steady_power": 100.0, "steady_decay": 0.1}}
    return ledger.transient_checks(runs, [{"design": "FSB", "wave": "w", "power_mean": 100.0 * (1 + difference)}])


def of_keel(study, share):
    """Internal pressure that leaves a share of the classical buckling pressure at the keel."""
    keel = study.water.density * study.water.gravity * reference_shell(study).keel_depth
    inside = keel - share * ledger.Shell.of(study.device).buckling_pressure
    pressed = varied(study, device={"internal_pressure": inside})
    return [ledger.classical_check(pressed, reference_shell(pressed), carried=False)]


def of_buckling(study, share):
    """A shell stiff enough for a load of this share of its buckling load."""
    modulus = study.device.young_modulus * ledger.viability_checks(study)[0].value
    return ledger.viability_checks(varied(study, device={"young_modulus": modulus / share}))


def of_static_load(study, name, value):
    """A shell soft enough for this static deformation or strain."""
    shell = reference_shell(study)

    def checks(softness):
        stiffness = {part: matrix / softness for part, matrix in shell.stiffness.items()}
        return {check.name: check for check in ledger.static_checks(study, replace(shell, stiffness=stiffness))}

    softness = brentq(lambda s: checks(s)[name].value - value, 1e-3, 10.0)
    return [checks(softness)[name]]


def at_rest(study, breathing):
    """A shell compressed at rest."""
    resting, shape = varied(study, reference_shape="equilibrium"), reference_shell(study).shape
    squeezed = replace(shape, modal_amplitude=-2.0 * breathing * np.eye(8)[1])
    return ledger.static_checks(resting, replace(reference_shell(study), shape=squeezed))


def of_modes(study, change):
    """Change of the power by the shell modes left out, at the optimal damping."""
    one = varied(study, designs={"VSWEC": {}}, waves=[WAVE.model_dump()])
    left = [asdict(Source(MODES, -4.0 * change, 0.0))]
    rung = Rung("VSWEC", one.waves[0].label, "best_damper", 1e4, 0.0, 4.0, *[None] * 5, power_error=left)
    return ledger.mode_checks(one, [rung])


def of_witness(share, parts):
    """Two solvers, or derivatives by a mode, that differ by a share of their error estimates."""
    where = {"shape": ["mean"], "shape_dof": ["Membrane0"], "omega": [1.0, 2.0], "coefficient": ["added_mass"]}
    apart, estimate = np.array([[[0.1], [share * 0.3]]]), np.array([[[0.1]], [[0.2]]])
    if parts == "derivatives":
        half = {"witness_difference": (("shape", "omega", "coefficient"), 0 * apart)}
        half |= {"slope_difference": (("shape_dof", "omega", "coefficient"), apart)}
        half |= {"slope_estimate": (("shape_dof", "coefficient"), [[0.3]])}
    else:
        half = {"witness_difference": (("shape", "omega", "coefficient"), apart)}
    told = {"witness_estimate": (("solver", "shape", "coefficient"), estimate)}
    return witness.witness_checks(xr.Dataset(half | told, {"solver": list(witness.SOLVERS), **where}))


def of_tuning(lost):
    return fair_damping_checks(
        [Tuned("A", "w", 2e4, 100.0, 0.0, 8e3, 100 * (1 - lost), 0.0, 1 - lost)], Pto(damping=8e3)
    )


def of_reference(study, left):
    two = varied(study, designs={"FSB": {"flexible": False}, "VSWEC": {}})
    powers = (("best_damper", 1.0), ("matched", left))
    rows = [Rung("FSB", two.waves[0].label, name, 1e4, 0.0, w, *[None] * 5) for name, w in powers]
    return reference_power_checks(two, rows)


CASES = {
    "buckling": (1.0, "-", of_keel),
    "computed_buckling": (1.0, "-", of_buckling),
    "static_deformation": (0.05, "-", lambda s, x: of_static_load(s, "static_deformation", x)),
    "static_deformation at rest": (0.2, "-", at_rest),
    "static_strain": (0.02, "-", lambda s, x: of_static_load(s, "static_strain", x)),
    "modes_left_out": (0.005, "-", of_modes),
    "witness": (1.0, "-", lambda s, x: of_witness(x, "shapes")),
    "witness_derivatives": (1.0, "-", lambda s, x: of_witness(x, "derivatives")),
    "fair_damping": (0.05, "-", lambda s, x: of_tuning(x)),
    "reference_power": (1e3, "-", of_reference),
    "energy_residual": (1e-6, "-", lambda s, x: of_run(s, residual=x)),
    "heave": (0.3, "-", lambda s, x: of_run(s, heave=2.0 * x)),
    "constraint_drift": (1e-9, "m", lambda s, x: of_run(s, constraint_drift=x)),
    "deformation": (0.1, "-", lambda s, x: of_run(s, breathing=2.0 * x)),
    "strain": (0.02, "-", lambda s, x: of_run(s, breathing=2.0 * x)),
    "steepness": (0.05, "-", lambda s, x: of_wave(x * LENGTH)),
    "spectrum_cut": (0.01, "-", lambda s, x: of_band(x)),
    "transient": (0.005, "-", lambda s, x: of_transient(x)),
    "time_and_frequency_domain": (0.005, "-", lambda s, x: [run_checks.steady_state_check(s, WAVE, 4.0, 1.0 + x, "FSB")]),
    "linearity": (0.05, "-", lambda s, x: [run_checks.linearity_check(s, WAVE, 4.0, 1.0 - x, "FSB")]),
    "left_out": (0.01, "-", lambda s, x: of_auto(s, (0.0, x))),
    "gain_error": (0.02, "-", lambda s, x: of_auto(s, (0.009, x - 0.009))),
    "power_limit": (1.01, "-", lambda s, x: of_limit(x)),
    "radiation_fit": (1e-3, "-", lambda s, x: of_radiation(s, error=x)),
    "passivity": (1e-12, "-", lambda s, x: of_radiation(s, margin=-x)),
    "assumed_pressure": (1.0, "-", of_pressure),
    "statistical_error": (0.1, "-", lambda s, x: of_lines(s, half=100 * x)),
    "spectral_prediction": (0.005, "-", lambda s, x: of_lines(s, apart=100.0 * x)),
}  # fmt: skip


FAILS = ("buckling", "computed_buckling", "constraint_drift", "left_out", "gain_error", "power_limit", "passivity",
         "assumed_pressure")  # fmt: skip
"""Checks that fail at once; the others are in doubt first."""


@pytest.mark.parametrize("name", CASES)
def test_check_changes_its_verdict_at_its_limit(seed, name):
    limit, unit, checks = CASES[name]
    below, above = (
        next(check for check in reversed(checks(seed, x * limit)) if check.name == name.split()[0])
        for x in (0.99, 1.01)
    )
    assert (below.verdict, above.verdict) == ("ok", "fail" if name in FAILS else "doubt")
    for check, share in ((below, 0.99), (above, 1.01)):
        assert (check.limit, check.unit) == (pytest.approx(limit, rel=1e-12), unit)
        assert check.value == pytest.approx(share * limit, rel=2e-3)


def test_record_with_too_few_batches_is_reported(seed):
    assert [c.name for c in of_lines(seed, batches=6)] == ["statistical_error", "spectral_prediction"]
    short, _ = of_lines(seed, batches=5)
    assert (short.name, short.verdict, short.value) == ("record_length", "doubt", 1.2)


def test_sharp_gain_of_a_scattered_power_is_ok(seed):
    """In the same waves: power to 60 %, gain to 0.2 %."""
    rigid = Line("FSB", "sea", "random", 1, 20, 100.0, 40.0, 160.0, 100.0, 100.0, None, None, None)
    soft = Line("VSWEC", "sea", "random", 1, 20, 120.0, 50.0, 190.0, 120.0, 120.0, 20.0, 19.76, 20.24)
    other = rigid._replace(sea="other")
    checks = {
        (c.design, c.wave): c for c in statistical_checks(seed, [rigid, soft, other]) if c.name == "statistical_error"
    }
    assert checks["VSWEC", "sea"].value == checks["FSB", "sea"].value == pytest.approx(0.002)
    assert (checks["FSB", "other"].value, checks["FSB", "other"].verdict) == (pytest.approx(0.6), "fail")


def test_only_the_averaging_window_counts(seed):
    study = varied(seed, simulation={"window": [51.0, 60.0]})
    values = {check.name: check.value for check in of_run(study, heave=5.0, breathing=1.0)}
    assert (values["heave"], values["deformation"], values["strain"]) == (0.0, 0.0, 0.0)
