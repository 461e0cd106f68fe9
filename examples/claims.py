"""Published claims about flexible wave-energy converters, recomputed: the tables of docs/claims.md.

    python -m examples.claims results/claims

prints the figures of every claim; some of them by name:

    python -m examples.claims results/claims matched_limit longer_resonance
"""

import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import vsb
from examples import command
from examples.surprises import FLEXIBLE, RIGID, Figures, Ladder, regular, run, study_of
from vsb.hydro.orders import order_groups
from vsb.integrators.exact import propagate
from vsb.scenes.build import linear_design
from vsb.stages.make import hydro_files, make
from vsb.study.body import load_body
from vsb.study.plan import AnyPlan, BodyPlan, StudyPlan
from vsb.study.study import Study, load, parse
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load as load_file
from vsb.waves.dispersion import power_limit

PERIODS = np.linspace(2.0, 10.0, 161)
"""Of the regular waves in which designs are compared [s]."""


def response(study: Study, folder: Path) -> xr.Dataset:
    """Return the frequency response of a study, computed if it is not there yet."""
    name = f"{study.study}_{StudyPlan(study).response_id}"  # several studies of one name differ in their content
    return computed(StudyPlan(study.model_copy(update={"study": name}), root=str(folder)))


def computed(plan: AnyPlan) -> xr.Dataset:
    """Return the frequency response of a plan."""
    paths = list(plan.response_files.values())
    make(plan, paths)
    return load_file(paths[0], expected=plan.response_id)


def papers_shell(degree: int = 42, **device: Any) -> Study:
    """Return the shell of Shabara & Abdelkhalik (2022), rigid and free, with bending and no damper given."""
    raw = load("config/seed.yaml").model_dump()
    raw["device"] |= device
    raw["designs"] = {RIGID: {"flexible": False}, FLEXIBLE: {}}
    raw["hydro"] |= {"witness": "none"}
    return parse({**raw, "modes": {"basis": "full", "degree": degree}, "pto": {"tuning": "each"}})


def at_periods(values: xr.DataArray, periods: FloatArray = PERIODS) -> FloatArray:
    """Interpolate over frequency, shape (..., period)."""
    return np.asarray(values.interp(omega=2 * np.pi / periods, method="cubic").values)


def power(ds: xr.Dataset, damping: float, periods: FloatArray = PERIODS) -> FloatArray:
    """Return the mean power of all designs at one damper, c |V0/(1 + c/Z)|^2/2, shape (design, period) [W/m^2]."""
    velocity, impedance = (at_periods(ds[name], periods) for name in ("port_velocity", "port_impedance"))
    return np.asarray(damping * np.abs(velocity / (1 + damping / impedance)) ** 2 / 2)


def gain(powers: FloatArray) -> FloatArray:
    """Return the gain of the second design over the first [%]."""
    return np.asarray(100 * (powers[1] / powers[0] - 1))


# claims --------------------------------------------------------------------------------------------------------------


def with_radiation(folder: Path) -> Figures:
    """The shell of the 2022 paper in its wave, with radiation and all modes that matter."""
    figures = {}
    ds, wave = response(papers_shell(), folder), np.array([2.5])
    for damper in (6000.0, 8000.0):
        figures[f"gain at {damper:g} N s/m [%]"] = float(gain(power(ds, damper, wave))[0])
    figures["gain at optimal damping [%]"] = float(gain(at_periods(ds.best_power, wave))[0])
    return figures


def every_wave(folder: Path) -> Figures:
    """In which share of regular waves of 2 to 10 s the flexible buoy absorbs more, at equal and at optimal dampers."""
    shells = {"the paper's shell": papers_shell(), "the example's shell": study_of([regular(3.0)])}
    figures = {}
    for name, study in shells.items():
        ds = response(study, folder)
        gains = {f"{c:g} N s/m": gain(power(ds, c)) for c in (2000.0, 8000.0, 32000.0)}
        gains["optimal damping"] = gain(at_periods(ds.best_power))
        for at, values in gains.items():
            figures[f"{name}, {at}: waves with a gain [%]"] = 100 * float(np.mean(values > 0))
            figures[f"{name}, {at}: smallest gain [%]"] = float(values.min())
            figures[f"{name}, {at}: largest gain [%]"] = float(values.max())
    return figures


def softer_is_better(folder: Path) -> Figures:
    """Gain at optimal damping over Young's modulus: the example's shell, which carries its load from 10 MPa on."""
    figures = {}
    for modulus in (10e6, 20e6, 40e6, 160e6, 4e9):
        ds = response(study_of([regular(3.0)], device={"young_modulus": modulus}), folder)
        gains = gain(at_periods(ds.best_power))
        figures[f"{modulus / 1e6:g} MPa: mean gain over 2 to 10 s [%]"] = float(gains.mean())
        figures[f"{modulus / 1e6:g} MPa: largest gain [%]"] = float(gains.max())
    return figures


def start_of_a_run(folder: Path) -> Figures:
    """How much of the energy that a shell gains in the first 30 s belongs to the start of the run."""
    study = study_of([regular(4.0)], pto={"damping": 8000.0}, simulation={"initial_velocity": 0.0})
    files, energy = hydro_files(study, folder), {}
    time = np.linspace(0.0, 30.0, 3001)
    for design in (RIGID, FLEXIBLE):
        made = linear_design(StudyPlan(study).simulation(design, study.waves[0]), files)
        motion = propagate(made.system, time, made.scene.start(0.0, 0.0))
        speed = (motion.velocity @ made.scene.motions.T)[:, 0]
        energy[design] = [8000.0 * np.trapezoid(speed[some] ** 2, time[some]) for some in (time <= 8.0, time >= 8.0)]
    first, later = (np.array([energy[design][part] for design in (RIGID, FLEXIBLE)]) for part in (0, 1))
    return {
        "gain in energy, first 8 s from rest [%]": float(gain(first)),
        "gain in energy, 8 to 30 s [%]": float(gain(later)),
        "gain in energy, first 30 s from rest [%]": float(gain(first + later)),
        "gain in mean power, steady motion [%]": Ladder(study, folder).gain("fixed"),
        "gain in mean power, steady motion at optimal damping [%]": Ladder(study, folder).gain("best_damper"),
    }


def matched_limit(folder: Path) -> Figures:
    """The largest power that heave can absorb, over lambda/2 pi, for shells of any Young's modulus."""
    figures = {}
    for modulus in (1e7, 1e8, 1e9, 2e11):
        for beta in (0.0, 1e-3):
            shell = papers_shell(14, young_modulus=modulus, damping={"alpha": 0.0, "beta": beta})
            ds = response(shell, folder)
            waves = ds.sel(design=FLEXIBLE, omega=slice(2 * np.pi / PERIODS[-1], 2 * np.pi / PERIODS[0]))
            lost = 100 * (1 - waves.matched_power / waves.power_limit)
            figures[f"E = {modulus:.0e} Pa, beta = {beta:g} s: smallest loss [%]"] = float(lost.min())
            figures[f"E = {modulus:.0e} Pa, beta = {beta:g} s: largest loss [%]"] = float(lost.max())
    return figures


def longer_resonance(folder: Path) -> Figures:
    """Natural period of heave in water: rigid, open to constant pressure, and with trapped gas."""
    figures = {}
    gas = {"adiabatic_index": 1.4, "atmospheric_pressure": 101325.0}
    for modulus in (40e6, 160e6):
        for name, contents, pressure in (("constant pressure", None, 16.5e3), ("trapped air", gas, 30e3)):
            inside = {"gas": contents, "internal_pressure": pressure}  # trapped air loses pressure as the shell expands
            study = study_of([regular(3.0)], device={"young_modulus": modulus, **inside})
            ds = response(study, folder)
            first = ds.wet_natural_frequency.groupby("wet_design").min()
            rigid, flexible = (2 * np.pi / float(first.sel(wet_design=design)) for design in (RIGID, FLEXIBLE))
            figures[f"{modulus / 1e6:g} MPa, {name}: rigid, same rest shape [s]"] = rigid
            figures[f"{modulus / 1e6:g} MPa, {name}: flexible [s]"] = flexible
    return figures


def more_orders(folder: Path) -> Figures:
    """Limit of absorbed power when every motion up to an azimuthal order is controlled, in terms of lambda/2 pi."""
    raw = load("config/seed.yaml").model_dump()
    raw["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8000.0}
    raw["designs"], raw["motion"] = {FLEXIBLE: {}}, "planar"
    raw["modes"] = {"basis": "membrane", "degree": 6, "order": 3}
    study = parse({**raw, "mooring": [2e4, 0, 0, 0, 0, 0], "pto": {"tuning": "each"}})
    ds = vsb.open_database(hydro_files(study, folder)["database"])
    figures, total = {}, 0.0
    at = ds.sel(omega=2 * np.pi / 3.0, method="nearest")
    limit = power_limit(float(at.omega), study.water.depth, study.water.density, study.water.gravity)
    for order, rows in order_groups(ds).items():
        damping = at.radiation_damping.values[np.ix_(rows, rows)]
        force = at.excitation_force.values[0][rows]
        total += float(np.vdot(force, np.linalg.lstsq(damping, force, rcond=1e-9)[0]).real / 8)
        figures[f"orders up to {order}"] = total / limit
    return figures


def flexible_barge(folder: Path) -> Figures:
    """A barge with a take-off at its bow: rigid, bending, and with a hinge amidships as well."""
    body = load_body("config/barge.yaml")
    ds = computed(BodyPlan(body.study, root=str(folder), files=body.files)).sel(wave_direction=0.0)
    some = ds.best_power.sel(omega=slice(2 * np.pi / 12, 2 * np.pi / 5))
    mean = some.mean("omega")
    figures = {}
    for design in ("flexible", "hinged"):
        better = some.sel(design=design) > some.sel(design="rigid")
        figures[f"{design}: frequencies with a gain [%]"] = 100 * float(better.mean())
        figures[f"{design}: gain in power, mean over all frequencies [%]"] = 100 * float(
            mean.sel(design=design) / mean.sel(design="rigid") - 1
        )
        resonances = ds.wet_natural_frequency[(ds.wet_design == design).values]
        figures[f"{design}: natural periods above 5 s"] = int((2 * np.pi / resonances > 5).sum())
    first = ds.wet_natural_frequency[(ds.wet_design == "rigid").values]
    figures["rigid: natural periods above 5 s"] = int((2 * np.pi / first > 5).sum())
    return figures


CASES: Mapping[str, Callable[[Path], Figures]] = {
    case.__name__: case
    for case in (
        with_radiation, every_wave, softer_is_better, start_of_a_run, matched_limit, longer_resonance, more_orders,
        flexible_barge,
    )
}  # fmt: skip
"""By name."""


main = command("claims", __doc__, partial(run, CASES), "{folder}/", folder="FOLDER", cases="CASE...")

if __name__ == "__main__":
    sys.exit(main(None))
