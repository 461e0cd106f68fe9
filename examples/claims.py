"""Published claims about flexible wave-energy converters, recomputed: tables and figures of docs/claims.md.

    python -m examples.claims results/claims

prints the table of every claim and writes it into results/claims, with its figure and its studies; some by name:

    python -m examples.claims results/claims matched_limit longer_resonance
"""

import argparse
import os
import shutil
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.integrate import cumulative_trapezoid

import vsb
from examples import command
from examples.surprises import FLEXIBLE, RIGID, Figures, Ladder, chosen, regular, study_of, table
from vsb.engine.hydro.bodies.body_file import RoundPlate
from vsb.engine.hydro.bodies.families import free_free_shape, plate_modes
from vsb.engine.hydro.orders import order_groups
from vsb.engine.integrators.exact import propagate
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.tuning import best_matrix
from vsb.engine.waves.water import power_limit
from vsb.keys.reading import read_yaml
from vsb.models.build import linear_design
from vsb.models.floating_system import floating_system
from vsb.models.mode_convergence import TAKE_OFFS, ModeConvergence
from vsb.pipeline.graph import AnyPlan, BodyPlan, StudyPlan
from vsb.pipeline.plans import planned
from vsb.report.canvas import RIGID_STYLE, STYLES, drawn, grid_of_axes, legend_above
from vsb.stages.make import hydro_files, make
from vsb.study.sections import Modes
from vsb.study.study import Study, load, parse
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load as load_file
from vsb.tools.files import write_text

PERIODS = np.linspace(2.0, 10.0, 161)
"""Of the regular waves in which designs are compared [s]."""
PERIOD, POWER = "wave period [s]", "mean power [kW/m²]"
"""Labels of axes; power of a wave of 1 m amplitude."""
LOOKS: dict[str, dict[str, Any]] = {
    "rigid": {"color": RIGID_STYLE[0], "label": "rigid"},
    "flexible": {"color": STYLES[0][0], "label": "flexible"},
    "hinged": {"color": STYLES[2][0], "linestyle": "-.", "label": "hinged"},
    "limit": {"color": "0.5", "linestyle": ":", "label": "limit λ/2π"},
}
"""Colour and line of each design and of the limit, in all figures."""


@dataclass(frozen=True)
class Claim:
    """What a claim comes to: figures by name, a drawing of them, and the studies they come from, as files have them."""

    figures: Figures
    drawing: Figure
    studies: Mapping[str, Mapping[str, Any]]

    @property
    def conditions(self) -> str:
        """Shells and their modes, which the figures hold for."""
        moduli: dict[tuple[str, str], list[float]] = {}
        for raw in self.studies.values():
            if "device" in raw:
                known = moduli.setdefault(shell_of(raw), [])
                known += {raw["device"]["young_modulus"] / 1e6} - set(known)
        shells = [f"{wall} of {', '.join(f'{e:g}' for e in some)} MPa, {rest}" for (wall, rest), some in moduli.items()]
        return "; ".join(shells)


def shell_of(raw: Mapping[str, Any]) -> tuple[str, str]:
    """Return the wall of a buoy, and what is inside with its shell modes, in words, of a study as a file has it."""
    device, modes = raw["device"], raw["modes"]
    pressure = f"{device['internal_pressure'] / 1e3:g} kPa inside" if device["internal_pressure"] else "open inside"
    air = ", trapped air" if device.get("gas") else ""
    return f"{1e3 * device['thickness']:g} mm", f"{pressure}{air}, {modes['basis']} modes to degree {modes['degree']}"


def with_conditions(name: str, figures: Figures, conditions: str) -> str:
    """Return the figures of a claim as the page has them, and below the shells they hold for."""
    return table(name, figures) + (f"\nComputed for: {conditions}.\n" if conditions else "")


def recorded(name: str, folder: Path) -> Claim:
    """Compute a claim and write its table, drawing and studies into a folder."""
    claim = CASES[name](folder)
    write_text(folder / f"{name}.md", with_conditions(name, claim.figures, claim.conditions))
    drawn(claim.drawing, name).write(str(folder), name)
    for study, raw in claim.studies.items():
        raw = with_files_beside({**raw, "study": f"{name}_{study}"}, folder / name)
        write_text(folder / name / f"{study}.yaml", yaml.safe_dump(raw, sort_keys=False, allow_unicode=True))
    return claim


def with_files_beside(value: Any, folder: Path) -> Any:
    """Return values of a study, the files it names copied into its folder, so that the folder can be moved."""
    match value:
        case Mapping():
            return {key: with_files_beside(one, folder) for key, one in value.items()}
        case str() if os.path.isabs(value):
            folder.mkdir(parents=True, exist_ok=True)
            return Path(shutil.copy2(value, folder)).name
    return value


def axes(columns: int = 1, height: float = 2.8, **options: Any) -> tuple[Figure, list[Axes]]:
    """Return a figure of page width with axes side by side."""
    figure, grid = grid_of_axes(height, 1, columns, **options)
    return figure, list(grid[0])


def shades(count: int) -> list[Any]:
    """Return colours of a parameter's values in their order, which are no design's."""
    return [mpl.colormaps["viridis"](share) for share in np.linspace(0.0, 0.85, count)]


def response(study: Study, folder: Path) -> xr.Dataset:
    """Return the frequency response of a study, computed if it is not there yet."""
    name = f"{study.study}_{StudyPlan(study).response.id}"  # several studies of one name differ in their content
    return computed(StudyPlan(study.model_copy(update={"study": name}), root=str(folder)))


def computed(plan: AnyPlan) -> xr.Dataset:
    """Return the frequency response of a plan."""
    paths = [plan.response.out]
    make(plan, paths)
    return load_file(paths[0], expected=plan.response.id)


def raw_of(study: Study) -> dict[str, Any]:
    """Return a study as a file has it."""
    return study.model_dump(exclude_none=True)


def body_plan(raw: Mapping[str, Any], folder: Path) -> BodyPlan:
    """Return the plan of a study of a body, its results in a folder."""
    plan = planned({**raw, "root": str(folder)}, "claims.yaml")
    assert isinstance(plan, BodyPlan)
    return plan


def barge() -> dict[str, Any]:
    """Return the study config/barge.yaml with its body inside, whose mesh is found from any folder."""
    raw: Any = read_yaml("config/barge.yaml", "a study file")
    body: Any = read_yaml("config/barge/body.yaml", "a body file")
    mesh = str(Path("config/barge/barge.nc").resolve())
    return {**raw, "body": {"file": {**body, "mesh": mesh, "modes": mesh}}}


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


def with_radiation(folder: Path) -> Claim:
    """The shell of the 2022 paper in its wave, with radiation and all modes that matter."""
    study, wave, periods = papers_shell(), np.array([2.5]), np.linspace(2.0, 4.0, 201)
    ds, figures = response(study, folder), {}
    drawing, panels = axes(3, sharey=True)
    for damper, ax in zip((6000.0, 8000.0, None), panels, strict=True):
        name = f"{damper:g} N s/m" if damper else "optimal damping"
        at_wave, over = (power(ds, damper, at) if damper else at_periods(ds.best_power, at) for at in (wave, periods))
        figures[f"gain at {name} [%]"] = float(gain(at_wave)[0])
        for design, values in zip(("rigid", "flexible"), over, strict=True):
            ax.plot(periods, values / 1e3, **LOOKS[design])
        ax.plot(periods, at_periods(ds.power_limit, periods) / 1e3, **LOOKS["limit"])
        ax.axvline(wave[0], color="0.8", zorder=0, label="claim, 2.5 s")
        ax.set(title=name, xlabel=PERIOD, ylim=(0.0, None))
    panels[0].set_ylabel(POWER)
    legend_above(drawing, *panels)
    return Claim(figures, drawing, {"papers_shell": raw_of(study)})


def every_wave(folder: Path) -> Claim:
    """In which share of regular waves of 2 to 10 s the flexible buoy absorbs more, at equal and at optimal dampers."""
    shells = {"the paper's shell": papers_shell(), "the example's shell": study_of([regular(3.0)])}
    figures = {}
    drawing, panels = axes(2)
    for (name, study), ax in zip(shells.items(), panels, strict=True):
        ds = response(study, folder)
        gains = {f"{c:g} N s/m": gain(power(ds, c)) for c in (2000.0, 8000.0, 32000.0)}
        gains["optimal damping"] = gain(at_periods(ds.best_power))
        for (at, values), colour, line in zip(gains.items(), shades(4), ("--", "-.", ":", "-"), strict=True):
            figures[f"{name}, {at}: waves with a gain [%]"] = 100 * float(np.mean(values > 0))
            figures[f"{name}, {at}: smallest gain [%]"] = float(values.min())
            figures[f"{name}, {at}: largest gain [%]"] = float(values.max())
            ax.plot(PERIODS, values, color=colour, linestyle=line, label=at)
        ax.axhline(0.0, color="0.5", linewidth=0.8)
        ax.set(title=name, xlabel=PERIOD)
    panels[0].set_ylabel("gain over the rigid buoy [%]")
    legend_above(drawing, *panels)
    studies = {name.removeprefix("the ").replace("'s ", "s_"): raw_of(study) for name, study in shells.items()}
    return Claim(figures, drawing, studies)


def softer_is_better(folder: Path) -> Claim:
    """Gain at optimal damping over Young's modulus: the example's shell, which carries its load from 10 MPa on."""
    figures, studies, moduli = {}, {}, (10e6, 20e6, 40e6, 160e6, 4e9)
    drawing, (ax,) = axes()
    for modulus, colour in zip(moduli, shades(len(moduli)), strict=True):
        study, name = study_of([regular(3.0)], device={"young_modulus": modulus}), f"{modulus / 1e6:g} MPa"
        gains = gain(at_periods(response(study, folder).best_power))
        figures[f"{name}: mean gain over 2 to 10 s [%]"] = float(gains.mean())
        figures[f"{name}: largest gain [%]"] = float(gains.max())
        studies[f"{modulus / 1e6:g}_MPa"] = raw_of(study)
        ax.plot(PERIODS, gains, color=colour, label=name)
    ax.axhline(0.0, color="0.5", linewidth=0.8)
    ax.set(xlabel=PERIOD, ylabel="gain over the rigid buoy [%]")
    legend_above(drawing, ax)
    return Claim(figures, drawing, studies)


def start_of_a_run(folder: Path) -> Claim:
    """How much of the energy that a shell gains in the first 30 s belongs to the start of the run."""
    study = study_of([regular(4.0)], pto={"damping": 8000.0}, simulation={"initial_velocity": 0.0})
    files, time, absorbed = hydro_files(study, folder), np.linspace(0.0, 30.0, 3001), []
    for design in (RIGID, FLEXIBLE):
        made = linear_design(StudyPlan(study).simulation(design, study.waves[0]).spec["run"], files)
        motion = propagate(made.system, time, made.scene.start(0.0, 0.0))
        speed = (motion.velocity @ made.scene.motions.T)[:, 0]
        absorbed.append(8000.0 * np.append(0.0, cumulative_trapezoid(speed**2, time)))
    energy = np.array(absorbed)
    first = energy[:, np.searchsorted(time, 8.0)]
    figures = {
        "gain in energy, first 8 s from rest [%]": float(gain(first)),
        "gain in energy, 8 to 30 s [%]": float(gain(energy[:, -1] - first)),
        "gain in energy, first 30 s from rest [%]": float(gain(energy[:, -1])),
        "gain in mean power, steady motion [%]": Ladder(study, folder).gain("fixed"),
        "gain in mean power, steady motion at optimal damping [%]": Ladder(study, folder).gain("best_damper"),
    }
    drawing, (left, right) = axes(2)
    for design, values in zip(("rigid", "flexible"), energy, strict=True):
        left.plot(time, values / 1e3, **LOOKS[design])
    left.set(xlabel="time [s]", ylabel="absorbed energy [kJ]")
    some = time >= 1.0  # before, next to nothing is absorbed
    right.plot(time[some], gain(energy[:, some]), **LOOKS["flexible"])
    right.axhline(figures["gain in mean power, steady motion [%]"], color="0.5", linestyle="--", label="steady motion")
    right.set(xlabel="time [s]", ylabel="gain in energy since the start [%]")
    legend_above(drawing, left, right)
    return Claim(figures, drawing, {"from_rest": raw_of(study)})


def matched_limit(_: Path) -> Claim:
    """The largest power that heave can absorb, over lambda/2 pi, for shells of any Young's modulus."""
    figures, studies, moduli = {}, {}, (1e7, 1e8, 1e9, 2e11)
    periods, change = PERIODS[::4], 0.0
    drawing, panels = axes(2, height=3.0)
    for modulus, colour, line in zip(moduli, shades(len(moduli)), ("-", "--", "-.", ":"), strict=True):
        for beta, ax in zip((0.0, 1e-3), panels, strict=True):
            shell = papers_shell(CONVERGED, young_modulus=modulus, damping={"alpha": 0.0, "beta": beta})
            fewer, lost = matched_losses(shell, periods)
            change = max(change, float(np.abs(lost - fewer).max()))
            figures[f"E = {modulus:.0e} Pa, beta = {beta:g} s: smallest loss [%]"] = float(lost.min())
            figures[f"E = {modulus:.0e} Pa, beta = {beta:g} s: largest loss [%]"] = float(lost.max())
            studies[f"{modulus / 1e6:g}_MPa_{'lossy' if beta else 'lossless'}"] = raw_of(shell)
            ax.plot(periods, lost, color=colour, linestyle=line, label=f"E = {modulus / 1e6:g} MPa")
            ax.set(title=f"structural damping β = {beta:g} s", xlabel=PERIOD)
    figures[f"largest change of a loss from degree {FEWER} to {CONVERGED} [points]"] = change
    panels[0].set(ylabel="matched power below λ/2π [%]", ylim=(-0.1, 0.1))
    legend_above(drawing, *panels)
    return Claim(figures, drawing, studies)


FEWER, CONVERGED = 60, 90
"""Degrees of the shell modes of `matched_limit`: its soft shell dissipates in modes of high degree (9.4 % to degree 14,
11.65 % to 30, 11.92 % to 60)."""


def matched_losses(study: Study, periods: FloatArray) -> FloatArray:
    """Return by how much the flexible design's matched power is below lambda/2 pi with `FEWER` and `CONVERGED` modes.

    Shape (2, period) [%].
    """
    raw, water = raw_of(study), study.water
    waves = parse({**raw, "waves": [regular(period, 1.0) for period in periods.tolist()]}).waves
    buoy = StudyPlan(study).ladder.spec["study"]
    found = ModeConvergence(buoy, [wave.realisation(study.hydro.omega_max, 0.0) for wave in waves])
    at = list(study.designs).index(FLEXIBLE), slice(None), TAKE_OFFS.index("matched")
    powers = np.array([found.powers(Modes(basis="full", degree=degree))[at] for degree in (FEWER, CONVERGED)])
    omega = 2 * np.pi / periods
    limit = np.array([power_limit(one, water.depth, water.density, water.gravity) for one in omega.tolist()])
    return np.asarray(100 * (1 - powers / limit))


def longer_resonance(folder: Path) -> Claim:
    """Natural period of heave in water: rigid, open to constant pressure, and with trapped gas."""
    figures, studies, periods = {}, {}, {}
    gas = {"adiabatic_index": 1.4, "atmospheric_pressure": 101325.0}
    for modulus in (40e6, 160e6):
        for name, contents, pressure in (("constant pressure", None, 16.5e3), ("trapped air", gas, 30e3)):
            inside = {"gas": contents, "internal_pressure": pressure}  # trapped air loses pressure as the shell expands
            study, case = (
                study_of([regular(3.0)], device={"young_modulus": modulus, **inside}),
                f"{modulus / 1e6:g} MPa",
            )
            first = response(study, folder).wet_natural_frequency.groupby("wet_design").min()
            rigid, flexible = (2 * np.pi / float(first.sel(wet_design=design)) for design in (RIGID, FLEXIBLE))
            figures[f"{case}, {name}: rigid, same rest shape [s]"] = rigid
            figures[f"{case}, {name}: flexible [s]"] = flexible
            studies[f"{case}_{name}".replace(" ", "_")] = raw_of(study)
            periods[f"{case}, {name}"] = (rigid, flexible)
    growth = [100 * (flexible / rigid - 1) for rigid, flexible in periods.values()]
    figures |= {"smallest growth of the period [%]": min(growth), "largest growth of the period [%]": max(growth)}
    drawing, (ax,) = axes(height=2.2)
    places, ends = np.arange(len(periods)), np.transpose(list(periods.values()))
    ax.hlines(places, *ends, color="0.7", zorder=1)
    for design, values in zip(("rigid", "flexible"), ends, strict=True):
        ax.plot(values, places, "o", **LOOKS[design])
    ax.set_yticks(places, list(periods))
    ax.set(xlabel="natural period of heave in water [s]")
    ax.invert_yaxis()
    legend_above(drawing, ax)
    return Claim(figures, drawing, studies)


def more_orders(folder: Path) -> Claim:
    """Limit of absorbed power when every motion up to an azimuthal order is controlled, in terms of lambda/2 pi."""
    raw = load("config/seed.yaml").model_dump()
    raw["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8000.0}
    raw["designs"], raw["motion"] = {FLEXIBLE: {}}, "planar"
    raw["modes"] = {"basis": "membrane", "degree": 6, "order": 3}
    study = parse({**raw, "mooring": [2e4, 0, 0, 0, 0, 0], "pto": {"tuning": "each"}})
    ds = vsb.open_database(hydro_files(study, folder)["database"])
    waves = ds.sel(omega=slice(2 * np.pi / 6.0, 2 * np.pi / 2.0))
    at = int(np.abs(waves.omega.values - 2 * np.pi / 3.0).argmin())
    water = study.water
    limit = np.array([power_limit(one, water.depth, water.density, water.gravity) for one in waves.omega.values])
    figures, total = {}, np.zeros(limit.size)
    drawing, (ax,) = axes()
    groups = order_groups(ds)
    for (order, rows), colour in zip(groups.items(), shades(len(groups)), strict=True):
        damping = waves.radiation_damping.values[:, rows][:, :, rows]
        force = waves.excitation_force.isel(wave_direction=0).values[:, rows]
        for i, (b, x) in enumerate(zip(damping, force, strict=True)):
            total[i] += float(np.vdot(x, np.linalg.lstsq(b, x, rcond=1e-9)[0]).real / 8)
        figures[f"orders up to {order}"] = float(total[at] / limit[at])
        ax.plot(2 * np.pi / waves.omega, total / limit, color=colour, label=f"orders up to {order}")
        ax.axhline(1 + 2 * order, color="0.5", linestyle=":", zorder=0)
    ax.set(xlabel=PERIOD, ylabel="largest power over that of λ/2π", ylim=(0.0, 8.0))
    legend_above(drawing, ax)
    return Claim(figures, drawing, {"papers_shell": raw_of(study)})


def band_mean(values: FloatArray, omega: FloatArray) -> float:
    """Return the mean over a band of frequencies, which crowd at resonances: of the integral."""
    return float(np.trapezoid(values, omega) / np.ptp(omega))


def over_band(power: FloatArray, rigid: FloatArray, omega: FloatArray) -> dict[str, float]:
    """Return how a power compares with that of the rigid design over a band of frequencies."""
    return {
        "frequencies with a gain [%]": 100 * band_mean(np.where(power > rigid, 1.0, 0.0), omega),
        "gain in power, mean over all frequencies [%]": 100 * (band_mean(power, omega) / band_mean(rigid, omega) - 1),
    }


def flexible_barge(folder: Path) -> Claim:
    """A barge with a take-off at its bow: rigid, bending, and with a hinge amidships as well."""
    raw = barge()
    plan = body_plan(raw, folder)
    ds = computed(plan).sel(wave_direction=0.0)
    some = ds.best_power.sel(omega=slice(2 * np.pi / 12, 2 * np.pi / 5))
    omega = some.omega.values
    figures: dict[str, float] = {}
    rigid = some.sel(design="rigid").values
    for design in ("flexible", "hinged"):
        figures |= {
            f"{design}: {what}": value
            for what, value in over_band(some.sel(design=design).values, rigid, omega).items()
        }
        resonances = ds.wet_natural_frequency[(ds.wet_design == design).values]
        figures[f"{design}: natural periods above 5 s"] = int((2 * np.pi / resonances > 5).sum())
    first = ds.wet_natural_frequency[(ds.wet_design == "rigid").values]
    figures["rigid: natural periods above 5 s"] = int((2 * np.pi / first > 5).sum())
    floating = floating_system(plan.study, plan.hydro_files["database"])
    x = np.linspace(-40.0, 40.0, 5)
    rises: dict[str, FloatArray] = {"Heave": np.ones(5), "Pitch": -x, "Hinge": np.abs(x) / 20 - 1}
    rises |= {f"Bending{n}": free_free_shape(n, x / 40)[0] for n in (1, 2, 3, 4)}
    along = np.array([rises[label] for label in floating.linear.labels])
    equation = floating.linear.equation(some.omega.values)
    drawing, panels = axes(2, sharey=True)
    absorbed = {}
    for design in ("rigid", "flexible", "hinged"):
        ports = equation.ports(floating.motions[design], along)
        each = [best_matrix(ports.at(np.array([i])), np.ones(1), "uniform").power for i in range(len(some.omega))]
        absorbed[design] = band_mean(np.array(each), omega)
        for values, ax in zip((some.sel(design=design).values, np.array(each)), panels, strict=True):
            ax.plot(2 * np.pi / some.omega, values / 1e3, **LOOKS[design])
    for ax, title in zip(panels, ("take-off at the bow", "five equal take-offs"), strict=True):
        ax.set(title=title, xlabel=PERIOD, ylim=(0.0, None))
    panels[0].set_ylabel(POWER)
    legend_above(drawing, *panels)
    for design in ("flexible", "hinged"):
        gain_of_five = 100 * (absorbed[design] / absorbed["rigid"] - 1)
        figures[f"{design}: gain with five equal take-offs along it [%]"] = gain_of_five
    return Claim(figures, drawing, {"barge": raw})


WEC_SIM_BENDING = (6.077064e6 / 1.079216e6, 4.382532e7 / 1.209976e6, 2.741026e8 / 2.391821e6, 4.664370e8 / 1.830601e6)
"""Squares of the dry natural frequencies of bending in WEC-Sim's example Generalized_Body_Modes, barge.frc [1/s^2]."""


def wec_sim_barge(folder: Path) -> Claim:
    """The barge of WEC-Sim's example with its own frequencies of bending; take-off at the bow, waves of 5 to 12 s."""
    raw = barge()
    quarter = 1025.0 * 80.0 * 10.0 * 5.0 / 4  # modal mass of free-free bending [kg]
    stiffness = {f"Bending{n}": quarter * square for n, square in enumerate(WEC_SIM_BENDING, 1)}
    raw |= {"study": "wec_sim_barge", "body": {**raw["body"], "stiffness": stiffness}}
    ds = computed(body_plan(raw, folder)).sel(wave_direction=0.0)
    some = ds.best_power.sel(omega=slice(2 * np.pi / 12, 2 * np.pi / 5))
    rigid, flexible = (some.sel(design=design).values for design in ("rigid", "flexible"))
    at = ds.best_power.interp(omega=2 * np.pi / 8, method="cubic") / 1e3
    figures = {
        "waves of 8 s and 1 m amplitude: rigid [kW]": float(at.sel(design="rigid")),
        "waves of 8 s and 1 m amplitude: flexible [kW]": float(at.sel(design="flexible")),
        **over_band(flexible, rigid, some.omega.values),
    }
    drawing, (ax,) = axes()
    for design in ("rigid", "flexible"):
        ax.plot(2 * np.pi / some.omega, some.sel(design=design) / 1e3, **LOOKS[design])
        ax.plot(8.0, at.sel(design=design), "o", color=LOOKS[design]["color"])
    ax.set(xlabel=PERIOD, ylabel=POWER, ylim=(0.0, None))
    legend_above(drawing, ax)
    return Claim(figures, drawing, {"barge": raw})


DISC: dict[str, Any] = {
    "study": "elastic_disc",
    "body": {
        "file": {
            "body": "disc",
            "mesh": {"kind": "cylinder", "radius": 10.0, "height": 1.2, "draft": 0.6, "panel": 0.8},
            "modes": {"rigid": ["Heave", "Pitch"], "plate": {"degree": 4, "stiffness": 2e5, "poisson_ratio": 0.3}},
            "mass": "displaced",
            "water": {"density": 1025.0, "depth": 50.0, "gravity": 9.81},
            "omega": np.linspace(0.8, 1.8, 11).round(3).tolist(),
            "lid": 0,
        }
    },
    "water": {"density": 1025.0, "depth": 50.0, "gravity": 9.81},
    "designs": {"rigid": {"dofs": "rigid"}, "flexible": {}},
    "hydro": {"accept": ["error_estimate"]},  # its coarser mesh has panels larger than twice the draft
    "pto": {"port": {"dof": "Heave"}},
    "waves": [regular(6.0)],
}
"""A round plate of 10 m radius, 1.2 m thick, half immersed; it absorbs some 4 % less than a disc of no draft."""


def elastic_disc(folder: Path) -> Claim:
    """A floating elastic disc with dampers to the sea bed all over it, the same everywhere and optimal in each wave."""
    plan = body_plan(DISC, folder)
    computed(plan)
    floating = floating_system(plan.study, plan.hydro_files["database"])
    ds, radius = floating.linear.database, float(DISC["body"]["file"]["mesh"]["radius"])
    omega = ds.omega.values
    plates = plate_modes(RoundPlate(degree=4), np.full(3, -radius), np.full(3, radius))

    def all_over(points: FloatArray, area: FloatArray) -> FloatArray:
        """B (dof, dof): the velocities at points (point, xy), each with an area, are as B^T q' in square and sum."""
        at = np.column_stack([points, np.zeros(len(points))])
        modes = [np.ones(len(at)), -at[:, 0], *(plate.at(at)[:, 2] for plate in plates)]
        root = np.array(modes) * np.sqrt(area)
        return np.asarray(root @ np.linalg.svd(root, full_matrices=False)[2].T)

    r, weight = np.polynomial.legendre.leggauss(8)
    r, angle = radius * (r + 1) / 2, np.arange(32) * np.pi / 16
    disc = np.stack(np.broadcast_arrays(r[:, None] * np.cos(angle), r[:, None] * np.sin(angle)), axis=-1)
    everywhere = all_over(disc.reshape(-1, 2), np.repeat(weight * r * radius / 2 * np.pi / 16, 32))
    limit = np.array([power_limit(one, 50.0, 1025.0, 9.81) for one in omega])

    def powers(design: str, equation: LinearEquation) -> tuple[FloatArray, FloatArray]:
        """Optimal damping of an area [N s/m^3] and the power [W/m^2], each (omega,)."""
        ports = equation.ports(floating.motions[design], everywhere)
        found = [best_matrix(ports.at(np.array([i])), np.ones(1), "uniform") for i in range(len(omega))]
        return np.array([one.damping[0, 0] for one in found]), np.array([one.power for one in found])

    given = floating.linear.equation(omega)
    dampers, rigid = powers("rigid", given)
    figures = {"rigid: largest power in terms of lambda/2 pi": float((rigid / limit).max())}
    drawing, (left, right) = axes(2)
    left.plot(2 * np.pi / omega, rigid / limit, **LOOKS["rigid"])
    for share, dash in zip((1e-4, 1e-3, 1e-2), ("-", "--", ":"), strict=True):
        stiffer = share * 1025.0 * 9.81 * radius**4 / 2e5 - 1
        equation = replace(given, stiffness=given.stiffness + stiffer * ds.structural_stiffness.values)
        dampers, power = powers("flexible", equation)
        name = f"D = {share:g} rho g a^4"
        figures |= {f"{name}: {what}": value for what, value in over_band(power, rigid, omega).items()}
        figures[f"{name}: largest power in terms of lambda/2 pi"] = float((power / limit).max())
        look = LOOKS["flexible"] | {"linestyle": dash, "label": f"D = {share:g} " + r"$\rho g a^4$"}
        left.plot(2 * np.pi / omega, power / limit, **look)
        if share != 1e-3:
            continue
        changes = {}
        for side in (3, 5, 9):
            line = radius * (2 * np.arange(side) + 1 - side) / side
            grid = np.array([(x, y) for x in line for y in line if np.hypot(x, y) < radius])
            units = all_over(grid, np.full(len(grid), np.pi * radius**2 / len(grid)))
            ports = equation.ports(floating.motions["flexible"], units)
            absorbed = [ports.at(np.array([i])).power(c * np.eye(units.shape[1]))[0] for i, c in enumerate(dampers)]
            changes[len(grid)] = 100 * float(np.abs(absorbed / power - 1).max())
            figures[f"{name}, {len(grid)} dampers in their place: largest change of power [%]"] = changes[len(grid)]
        right.loglog(list(changes), list(changes.values()), "o--", color=LOOKS["flexible"]["color"])
        right.set_xticks(list(changes), [str(number) for number in changes])
        right.set_yticks([0.5, 1.0, 2.0, 5.0, 10.0], ["0.5", "1", "2", "5", "10"])
        right.minorticks_off()
    left.set(xlabel=PERIOD, ylabel="power over that of λ/2π", ylim=(0.0, None))
    right.set(xlabel="number of dampers", ylabel="largest change of power [%]")
    legend_above(drawing, left, right)
    return Claim(figures, drawing, {"disc": DISC})


TUBE_LENGTH, TUBE_RADIUS, TUBE_DEPTH = 7.0, 0.125, 0.25
"""Of a tube like that of Chaplin et al. (2012) [m]; its axis lies one diameter below the surface."""
BULGES = 10
"""Modes of its cross-section along the tube."""


def write_tube(path: Path, density: float, speed: float) -> None:
    """Write a tube full of water, anchored, closed at the bow, whose section swells by 2 pi a cos(n pi x/L) per metre.

    The water inside flows along it, A u = -int dS/dt dx, and leaves at the stern, where the uniform mode alone moves
    it. The wall gives way to pressure by dA/dp = A/(rho c^2), c the `speed` of bulges [m/s] without water outside.
    """
    around, along = 16, 56
    angle, x = 2 * np.pi * np.arange(around) / around, np.linspace(0.0, TUBE_LENGTH, along + 1)
    ring = np.column_stack([np.zeros(around), np.cos(angle), np.sin(angle)])
    centre = np.array([0.0, 0.0, -TUBE_DEPTH])
    wall = (x[:, None, None] * np.eye(3)[0] + TUBE_RADIUS * ring + centre).reshape(-1, 3)
    vertices = np.concatenate([wall, [centre, centre + x[-1] * np.eye(3)[0]]])
    k, j = np.arange(around), np.roll(np.arange(around), -1)
    faces = [np.column_stack([i + k, i + around + k, i + around + j, i + j]) for i in range(0, along * around, around)]
    bow, stern, last = len(wall), len(wall) + 1, along * around
    faces += [
        np.column_stack([np.full(around, bow), k, j, j]),
        np.column_stack([last + j, last + k, *[np.full(around, stern)] * 2]),
    ]
    numbers = np.arange(BULGES)
    shares = np.cos(np.pi * numbers[:, None] * x / TUBE_LENGTH)  # of a radius that swells by 1 m
    shapes = np.zeros((BULGES, len(vertices), 3))
    shapes[:, : len(wall)] = (shares[:, :, None, None] * ring).reshape(BULGES, -1, 3)
    second = np.zeros((BULGES, BULGES, len(vertices), 3))  # the section's area is linear in the amplitudes
    pairs = -shares[:, None] * shares[None] / TUBE_RADIUS
    second[:, :, : len(wall)] = (pairs[..., None, None] * ring).reshape(BULGES, BULGES, -1, 3)
    girth, area = 2 * np.pi * TUBE_RADIUS, np.pi * TUBE_RADIUS**2
    s, weight = np.polynomial.legendre.leggauss(60)
    s, weight = TUBE_LENGTH * (s + 1) / 2, TUBE_LENGTH * weight / 2
    flow = girth * np.array(
        [s, *(TUBE_LENGTH / (n * np.pi) * np.sin(n * np.pi * s / TUBE_LENGTH) for n in numbers[1:])]
    )
    swells = girth * np.cos(np.pi * numbers[:, None] * s / TUBE_LENGTH)
    pair = ("influenced_dof", "radiating_dof")
    xr.Dataset(
        {
            "vertices": (("vertex", "xyz"), vertices),
            "faces": (("panel", "corner"), np.concatenate(faces)[:, ::-1]),
            "mode_shape": (("dof", "vertex", "xyz"), shapes),
            "second_order": ((*pair, "vertex", "xyz"), second),
            "inertia_matrix": (pair, density / area * (flow * weight) @ flow.T),
            "structural_stiffness": (pair, density * speed**2 / area * (swells * weight) @ swells.T),
        },
        coords={"dof": [f"Bulge{n}" for n in numbers]},
    ).to_netcdf(path)


def bulge_tube(folder: Path) -> Claim:
    """Capture width of a tube whose bulges travel slower than waves, as fast or faster; optimal damper at the stern."""
    folder.mkdir(parents=True, exist_ok=True)
    water = {"density": 1000.0, "depth": float("inf"), "gravity": 9.81}
    path = str((folder / "tube.nc").resolve())
    write_tube(Path(path), water["density"], 1.0)
    file = {"body": "tube", "mesh": path, "modes": path, "water": water, "lid": 0}
    raw = {
        "study": "bulge_tube",
        "body": {"file": file | {"omega": [2.8, 3.0, 3.2, 3.4, 3.6, 3.8, 4.0, 4.2]}},
        "water": water,
        "designs": {"tube": {}},
        "pto": {"port": {"dof": "Bulge0"}},
        "waves": [regular(1.8)],
    }
    plan = body_plan(raw, folder)
    computed(plan)
    floating = floating_system(plan.study, plan.hydro_files["database"])
    ds, omega = floating.linear.database, floating.linear.database.omega.values
    given, elastic, waves = floating.linear.equation(omega), ds.structural_stiffness.values, 9.81 / omega
    flux = np.array([power_limit(one, np.inf, 1000.0, 9.81) for one in omega]) / (
        waves**2 / 9.81
    )  # of a metre of crest
    figures, widths = {}, {}
    drawing, (ax,) = axes()
    for share in (0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0):
        stiffer = ((share * waves) ** 2 - 1)[:, None, None] * elastic
        equation = replace(given, stiffening=stiffer)
        best = equation.port(floating.motions["tube"], floating.port).best_power
        widths[share] = band_mean(best / flux, omega) / (2 * TUBE_RADIUS)
        figures[f"bulges at {share:g} of the waves' speed: capture width in diameters"] = widths[share]
        if share == 1.0:
            loss = 0.1 * (elastic + stiffer) / omega[:, None, None]
            best = (
                replace(equation, damping=given.damping + loss).port(floating.motions["tube"], floating.port).best_power
            )
            lossy = band_mean(best / flux, omega) / (2 * TUBE_RADIUS)
            figures["the same, loss factor of the wall 0.1"] = lossy
            ax.plot(share, lossy, "s", color=LOOKS["flexible"]["color"], label="loss factor of the wall 0.1")
    figures["twice as fast, over equally fast [%]"] = 100 * widths[2.0] / widths[1.0]
    ax.plot(list(widths), list(widths.values()), "o-", color=LOOKS["flexible"]["color"], label="wall without loss")
    ax.set(xlabel="speed of bulges over that of the waves", ylabel="mean capture width in diameters", ylim=(0.0, None))
    legend_above(drawing, ax)
    return Claim(figures, drawing, {"tube": raw})


CASES: Mapping[str, Callable[[Path], Claim]] = {
    case.__name__: case
    for case in (
        with_radiation, every_wave, softer_is_better, start_of_a_run, matched_limit, longer_resonance, more_orders,
        flexible_barge, wec_sim_barge, elastic_disc, bulge_tube,
    )
}  # fmt: skip
"""By name."""


def run(args: argparse.Namespace) -> int:
    """Write and print some claims, or all."""
    for name in chosen(args.cases, CASES):
        claim = recorded(name, Path(args.folder))
        print(with_conditions(name, claim.figures, claim.conditions), flush=True)
    return 0


main = command("claims", __doc__, run, "{folder}/", folder="FOLDER", cases="CASE...")

if __name__ == "__main__":
    sys.exit(main(None))
