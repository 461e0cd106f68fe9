"""Stages compare, figures and report: comparison table, statistics, validity ledger, figures and page of a study."""

import itertools
import json
import math
import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
import yaml
from matplotlib.figure import Figure

from vsb import __version__
from vsb.engine.hydro.bodies.body import OUTLINE
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.database import Check, stored_checks
from vsb.engine.hydro.dofs import flexible as is_flexible
from vsb.engine.motion.take_off import named_ports, port_kind
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.waves.kinds import (
    Irregular,
    RegularWave,
    Wave,
    jonswap_spectrum,
)
from vsb.engine.waves.seas import NO_WAVES, Peak
from vsb.engine.waves.water import group_velocity
from vsb.keys.quantities import canonical
from vsb.models.floating_system import FloatingSystem, band, expected_sea, floating_system, heading, study_sea
from vsb.models.rest import reference_shell
from vsb.report.answer import lowest
from vsb.report.canvas import PORT, StudyData, drawn
from vsb.report.figures import draw
from vsb.report.interactive import (
    PERIODS,
    SEEN,
    Grid,
    InteractiveSea,
    View,
    designs_data,
    frames_data,
    largest_motion,
    largest_shell,
    outline_data,
    shapes_data,
    study_data,
    thinned,
)
from vsb.report.page import Report, render
from vsb.report.shell_figures import round_factor, sketches
from vsb.results import comparison, ledger
from vsb.results import statistics as irregular
from vsb.results.comparison import in_direction
from vsb.results.constrained_year import SeenPort, force_steps
from vsb.results.gains import (
    AtForce,
    Elsewhere,
    Limited,
    Tuned,
    at_force,
    elsewhere,
    equal_tuning,
    fair_damping_checks,
    reference_power_checks,
    within_limits,
    worth_of_knowledge,
)
from vsb.results.ladder import ControlLevel, constrained_checks, material_checks
from vsb.results.ledger import agreement_checks, law_checks, sea_checks, transient_checks
from vsb.results.mean_power import linear_seas, mean_powers, of_seas, with_mean_powers, with_record_intervals
from vsb.results.statistics import families
from vsb.stages.stored import Inputs
from vsb.study import figure_names
from vsb.study.body import CONTENTS
from vsb.study.resolution import no_witness
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import write_text
from vsb.tools.stamps import read_text, record


def run_compare(compared: Study, trajectories: str, **files: str) -> None:
    """Write the comparison table, statistics of irregular seas, the validity ledger and the study in canonical form.

    Those are for people; what the report reads is one file of checked data, `tables`.
    """
    found = Inputs(compared, trajectories, files)
    reference = reference_shell(compared) if compared.has_shell else None
    in_seas = [in_a_sea(found, reference.basis if reference else None, wave) for wave in compared.waves]
    rows = [row for one in in_seas for row in one.rows]
    runs = {run: attrs for one in in_seas for run, attrs in one.runs.items()}
    checks = [check for one in in_seas for check in one.checks]
    if reference:
        checks = [*ledger.shell_checks(compared, reference), *checks]
    checks += [*ledger.angle_checks(compared), *transient_checks(runs, rows), *law_checks(runs)]
    lines: list[irregular.Line] = []
    tuned: list[Tuned] = []
    limited: list[Limited] = []
    controlled: list[AtForce] = []
    other_seas: list[Elsewhere] = []
    if compared.needs_bem:
        samples = {run: kept for one in in_seas for run, kept in one.samples.items()}
        lines = irregular.statistics(compared, samples)
        ladder = [
            ControlLevel(**row)
            for row in json.loads(read_text(files["levels"], files["manifest"], found.plan.ladder.id))
        ]
        checks += of_the_water(found, rows, runs, linear_seas(compared, runs, ladder))
        means = mean_powers(compared, rows, runs, ladder, found.response, samples)
        tuned, limited = equal_tuning(compared, ladder, means, runs), within_limits(compared, ladder)
        controlled = at_force(compared, ladder)
        if controlled and not (compared.pto.several or compared.plates):
            other_seas = elsewhere(compared, floating_system(compared, found.path("database")), compared.drawn_waves)
        rows, lines = with_mean_powers(rows, means), of_seas(compared, lines, means)
        checks += irregular.statistical_checks(compared, lines)
        checks += [*fair_damping_checks(tuned, compared.pto), *constrained_checks(ladder)]
        checks += [*reference_power_checks(compared, ladder), *material_checks(compared.pto, ladder)]
        checks += ledger.mode_checks(compared, ladder)
        checks += ledger.ring_width_checks(compared, found.path("database"))
    else:
        checks += ledger.assumed_pressure_checks(compared, rows)
        rows = with_mean_powers(rows, mean_powers(compared, rows, runs, (), None, {}))
    checks = ledger.worst_first(checks)
    invalid = ledger.invalid_designs(compared, checks)
    data = {
        "comparison": rows,
        "statistics": [line._asdict() for line in lines],
        "equal_tuning": [line._asdict() for line in tuned],
        "within_limits": [line._asdict() for line in limited],
        "at_force": [line._asdict() for line in controlled],
        "elsewhere": [line._asdict() for line in other_seas],
        "checks": [asdict(check) for check in checks],
        "invalid": [line._asdict() for line in invalid],
    }
    texts = {
        files["out"]: comparison.as_csv(rows),
        files["statistics"]: irregular.as_csv(lines),
        files["validity"]: ledger.ledger_json(compared.study, checks, invalid),
        files["study"]: canonical(compared) + "\n",
        files["tables"]: json.dumps(data, indent=1, allow_nan=False) + "\n",
    }
    for path, text in texts.items():
        write_text(path, text)
    record(files["manifest"], found.plan.identity, list(texts))


def of_the_water(
    found: Inputs, rows: list[comparison.Row], runs: comparison.Attributes, linear: set[str]
) -> list[Check]:
    """Return the checks of linear hydrodynamics: waves, coefficients, radiation memory, time and frequency domain.

    Of a buoy also the limit of its power, and what a second solver says. `linear` names the seas whose runs are.
    """
    study, database = found.study, found.database
    checks = ledger.limit_checks(study, found.response)
    checks += ledger.radiation_checks(found.radiation, study.hydro.tolerance)
    checks += [*ledger.seas_checks(study, database, linear), *agreement_checks(study, found.response, rows, runs)]
    checks += [replace(check, name=f"hydro {check.name}") for check in stored_checks(database)]
    return checks + ledger.witness_checks(study, database, found.witness)


class InASea(NamedTuple):
    """What the runs in a sea leave for the comparison; all runs at a time may be more than memory holds."""

    rows: list[comparison.Row]
    checks: list[Check]
    runs: dict[tuple[str, str], dict[str, Any]]  # their attributes
    samples: dict[tuple[str, str], irregular.Sample]  # of an irregular sea


def in_a_sea(found: Inputs, basis: ModeBasis | None, wave: Wave) -> InASea:
    """Return what the runs of all designs in a sea leave."""
    study, label = found.study, wave.label
    waves, spectral, whole = NO_WAVES, NO_WAVES, NO_WAVES
    if study.needs_bem:
        waves, spectral = (study_sea(study, one, found.database) for one in (wave, wave.expected))
        whole = expected_sea(study, wave, found.database)
    runs = {design: found.runs[design, label] for design in study.designs}
    samples = {}
    if study.needs_bem and wave.irregular:
        response = found.response
        samples = {
            (d, label): irregular.sample(study, wave, d, run, waves, spectral, response, whole)
            for d, run in runs.items()
        }
    return InASea(
        with_record_intervals(study, wave, comparison.comparison(study, wave, runs, whole), samples),
        sea_checks(study, wave, runs, basis, found.database),
        {(design, label): run.attrs for design, run in runs.items()},
        samples,
    )


FREQUENCIES = 2000
"""At which spectra are drawn."""


def run_figures(study: Study, trajectories: str, out: str, manifest: str, **files: str) -> None:
    """Draw and write all figures of a study into a folder: SVG, and their data as CSV."""
    found = Inputs(study, trajectories, files)
    written: list[str] = []
    with mpl.rc_context():  # the caller's own figures keep their looks
        for name, figure in figures_of(found):
            written += drawn(figure, name).write(out, name)
    record(manifest, found.plan.identity, written)


def figures_of(found: Inputs) -> Iterator[tuple[str, Figure]]:
    """Draw the figures of a study by name, one after the other."""
    study = found.study
    data = StudyData(
        designs=tuple(study.designs),
        reference=study.reference_design,
        wave_frequencies=tuple(wave.omega for wave in study.waves if not wave.still),
        periods={wave.label: _period(study, wave, found.response) for wave in study.waves},
        window=study.simulation.window,
        modes=found.modes,
        database=found.database,
        radiation=found.radiation,
        response=in_direction(found.response, study.waves[0]),
        runs=found.runs,
        witness=found.witness,
        tuned=study.pto.damping is None,
        limit=f"limit {found.response.attrs.get('limit', study.LIMIT)}" if study.LIMIT else "",
        spectra=_spectra(study, found.plan.highest),
        port=port_kind(study.pto.port),
        ports={name: port_kind(port) for name, port in named_ports(study.pto).items()},
        knowledge=_knowledge(study, found),
        raos=_raos(study, found),
    )
    yield from ((name, draw(name, data)) for name in figure_names.of_study(found.study))


def _raos(study: Study, found: Inputs) -> xr.DataArray:
    """Response amplitude operators, (wave_direction, design, omega, dof), the take-off's port among the motions."""
    if not study.needs_bem:
        return xr.DataArray()
    rao: xr.DataArray = found.response.rao
    rao = rao if "wave_direction" in rao.dims else rao.expand_dims(wave_direction=[0.0])
    names = [f"{PORT} {name}" for name in named_ports(study.pto)] if study.pto.several else [PORT]
    direction = floating_system(study, found.path("database")).port
    moved = [
        (rao * xr.DataArray(port, {"dof": rao.dof.values}, ("dof",))).sum("dof").expand_dims(dof=[name], axis=-1)
        for name, port in zip(names, np.atleast_2d(direction.T), strict=False)  # of a spread damper none has a name
    ]
    together: xr.DataArray = xr.concat([rao, *moved], "dof")
    return together


def _knowledge(study: Study, found: Inputs) -> dict[str, xr.Dataset]:
    """What knowledge of the waves is worth, by label of the seas with a figure of it."""
    waves = {f"forecast-{wave.label}": wave for wave in study.drawn_waves if wave.irregular}
    drawn = [wave for name, wave in waves.items() if name in figure_names.of_study(found.study)]
    if not drawn:
        return {}
    floating = floating_system(study, found.path("database"))
    return {wave.label: worth_of_knowledge(study, floating, wave) for wave in drawn}


def _spectra(study: Study, highest: float) -> xr.DataArray:
    """Spectral density of each irregular sea, by its words, up to the highest frequency runs have components at."""
    waves = [wave for wave in study.drawn_waves if wave.irregular]
    if not waves:
        return xr.DataArray()
    omega = np.geomspace(0.5 * min(wave.reach[0] for wave in waves), highest, FREQUENCIES)
    coords = {"sea": [wave.description for wave in waves], "omega": omega}
    return xr.DataArray([wave.density(omega) for wave in waves], coords)


def _period(study: Study, wave: Wave, response: xr.Dataset) -> float:
    """Period of a sea, in still water of the slowest free motion [s]; 2 pi if nothing is restrained."""
    if not wave.still:
        return 2 * np.pi / wave.omega
    if not study.needs_bem:
        return 2 * np.pi / study.heave_frequency  # without added mass
    return 2 * np.pi / (float(response.wet_natural_frequency.min()) if response.wet_natural_frequency.size else 1.0)


MOST = 10_000
"""Most numbers of components of a sea, times designs, that a page holds: those of longer runs are as many."""
SEAS = 24
"""Most seas a reader can choose from."""


def no_slider(study: Study) -> str:
    """Return why a reader cannot move the damping of a study on its page; empty if impedance and sea give its power."""
    spread = any(wave.spreads for wave in study.waves)
    reasons = (
        (study.plates, "drag takes power that depends on the amplitude"),
        (study.pto.spring_costs, "the spring loses reactive power"),
        (spread, "waves of a spread sea come from many directions"),
        (study.pto.several, "the take-off has several ports"),
    )
    return next((f"No slider of the damping: {why}." for applies, why in reasons if applies), "")


def interactive_study(
    study: Study, database: str, response: xr.Dataset, limited: Sequence[Mapping[str, Any]]
) -> dict[str, Any] | None:
    """Return the data of a study's page; none without waves that radiate, or for one of the reasons of `no_slider`.

    A port has a free velocity for every direction waves go to: seas share a grid if they share both.
    """
    if not study.needs_bem or no_slider(study):
        return None
    pto, seen = study.pto, _Seen(study, floating_system(study, database))
    names = {waves[0].label: name for name, waves in families(study).items()}  # of irregular seas
    moving = (wave for wave in study.drawn_waves if not wave.still)
    waves = {names.get(wave.label, wave.label): wave for wave in itertools.islice(moving, SEAS)}
    if not waves:
        return None
    ds = seen.floating.linear.database
    low, high, highest = float(ds.omega[0]), float(ds.omega[-1]), band(study, ds)[1]
    grids: list[tuple[FloatArray, float]] = []
    seas = [_sea(study, name, wave, (low, high), highest, limited, grids) for name, wave in waves.items()]
    going = list(dict.fromkeys(wave.direction for wave in waves.values()))
    seas = [replace(sea, band=going.index(wave.direction)) for sea, wave in zip(seas, waves.values(), strict=True)]
    if pto.efficiency == 1:
        seas = seen.with_steps(seas, list(waves.values()), (low, highest))
    omega, power = response.omega.values, in_direction(response, study.waves[0]).best_power.max("design").values
    last = min(high, float(omega[power >= 0.01 * power.max()].max()))  # where some design absorbs a hundredth
    shown = omega[(omega >= max(lowest(low, high), low)) & (omega <= last)]
    shown = np.asarray(shown[thinned(shown)])
    limit = np.interp(shown, response.omega.values, response.power_limit.values)
    bands = [seen.grid(shown, towards) for towards in going]
    bound = response.attrs.get("limit", study.LIMIT)
    on = [seen.grid(*one) for one in grids]
    return study_data(on, seas, bands, limit, study.reference_design, pto.efficiency, bound, port_kind(pto.port))


@dataclass(frozen=True)
class _Seen:
    """What the take-off of a study sees of all designs, in waves of any direction [degrees]."""

    study: Study
    floating: FloatingSystem

    def ports(self, towards: float) -> dict[str, SeenPort]:
        """Ports by design, to be had at any frequencies."""
        floating = self.floating
        return {name: partial(floating.extended_port, name, direction=towards) for name in floating.motions}

    def grid(self, omega: FloatArray, towards: float) -> Grid:
        """Ports beside the spring, and what energy waves bring, at some frequencies."""
        water, spring = self.study.water, self.study.pto.stiffness
        speed = np.array([group_velocity(w, water.depth, water.gravity) for w in omega])
        ports = {design: port(omega).beside(spring) for design, port in self.ports(towards).items()}
        return Grid(omega, 0.5 * water.density * water.gravity * speed, ports)

    def with_steps(
        self, seas: Sequence[InteractiveSea], waves: Sequence[RegularWave | Irregular], within: tuple[float, float]
    ) -> list[InteractiveSea]:
        """Seas with optima at some limits of force, of forces within a band."""
        study, stroke = self.study, self.study.pto.stroke_limit
        steps = partial(force_steps, reference=study.reference_design, seas=len(seas), stroke=stroke, band=within)
        pairs = zip(seas, waves, strict=True)
        return [replace(sea, steps=steps(wave, self.ports(wave.direction))) for sea, wave in pairs]


def _sea(
    study: Study,
    name: str,
    wave: RegularWave | Irregular,
    known: tuple[float, float],
    highest: float,
    limited: Sequence[Mapping[str, Any]],
    grids: list[tuple[FloatArray, float]],
) -> InteractiveSea:
    """A sea as a page needs it: its components where ports are known, on a grid that is added if it is new."""
    given = {design: study.pto.damper(design) for design in study.designs}
    within = {str(line["design"]): float(line["power"]) for line in limited if line["sea"] == name}
    squares, jonswap = None, None
    if wave.irregular:
        room = 2 * math.pi * MOST / (1.1 * highest * len(study.designs))  # longest run that a page has room for [s]
        duration = min(study.simulation.duration, room)
        omega, amplitude = wave.components(highest, duration)
        width = 2 * float(omega[0])
        kept = (omega >= known[0]) & (omega <= known[1])
        omega, squares = omega[kept], amplitude[kept] ** 2
        if peak := wave.jonswap:
            squares, jonswap = None, _jonswap(peak, width, known)
    else:
        omega, squares = np.array([wave.omega]), np.array([wave.amplitude**2])
    same = (i for i, (on, to) in enumerate(grids) if to == wave.direction and np.array_equal(on, omega))
    place = next(same, len(grids))
    if place == len(grids):
        grids.append((omega, wave.direction))
    return InteractiveSea(wave.description, place, squares, jonswap, given, within)


def _jonswap(peak: Peak, width: float, band: tuple[float, float]) -> dict[str, float]:
    """Parameters of a spectrum, and peak periods between which it lies within a band of frequencies.

    The integral is that of x^-5 exp(-1.25 x^-4) bump over x, frequencies in terms of the peak's [-].
    """
    periods, gamma = 2 * math.pi / np.array(band), peak.gamma
    integral = math.exp(-1.25) * gamma / float(jonswap_spectrum(np.array([1.0]), 4.0, 2 * math.pi, gamma)[0])
    own = {**peak._asdict(), "width": width, "integral": integral}
    return own | {"shortest": min(peak.tp, 5 * float(periods[1])), "longest": max(peak.tp, 0.5 * float(periods[0]))}


ASSUMED = "hydrostatic and assumed uniform pressure of {:g} Pa on the instantaneous wet shell; no radiation"


def run_report(study: Study, trajectories: str, out: str, manifest: str, **files: str) -> None:
    """Write the report of a study, from its checked results alone."""
    stored = Inputs(study, trajectories, files)
    study_id = stored.plan.identity
    found = json.loads(read_text(files["tables"], manifest, study_id))
    page = Report(
        study=study.model_dump(),
        seas=_seas(study),
        rows=found["comparison"],
        irregular=[wave.label for waves in families(study).values() for wave in waves],
        statistics=found["statistics"],
        equal_tuning=found["equal_tuning"],
        within_limits=found["within_limits"],
        at_force=found["at_force"],
        elsewhere=found["elsewhere"],
        invalid=found["invalid"],
        checks=found["checks"],
        response=in_direction(stored.response, study.waves[0]) if study.needs_bem else None,
        reference=study.reference_design,
        sketches=sketches(study),
        thing=study.KIND,
        flexible=study.has_shell or (study.flexible and is_flexible(stored.response.dof.values)),
        animated=animated_study(stored, _seas(study)),
        interactive=interactive_study(study, stored.path("database"), stored.response, found["within_limits"]),
        no_slider=no_slider(study),
        figures={
            n: read_text(f"{files['figures']}/{n}.svg", manifest, study_id) for n in figure_names.of_study(stored.study)
        },
        facts=_facts(stored, stored.runs.attributes()),
    )
    write_text(out, render(page))
    record(manifest, study_id, [out])


def _seas(study: Study) -> dict[str, str]:
    """Every sea in words; an assumed pressure is no sea."""
    if study.needs_bem:
        names = {name: waves[0].description for name, waves in families(study).items()}
        return {wave.label: wave.description for wave in study.waves} | names
    words = f"an assumed uniform pressure of {study.hydro.pressure:g} Pa and {{:g}} s period"
    return {w.label: w.description if w.still else words.format(2 * np.pi / w.omega) for w in study.waves}


def _facts(stored: Inputs, runs: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """How the results were made, in words."""
    study = stored.study
    if study.needs_bem:
        hydrodynamics = _water_facts(stored) | _cross_check_facts(stored)
    else:
        hydrodynamics = {"Hydrodynamics": ASSUMED.format(study.hydro.pressure)}
    printed = study.model_dump(exclude_none=True)
    for wave, sea in zip(printed["waves"], study.waves, strict=True):
        if sea.of_file:  # of records and spectra how much they hold
            wave["file"] = sea.file.size
    text = yaml.safe_dump(printed, sort_keys=False, default_flow_style=None, width=100)
    files = ", where checksums stand for the files" if CONTENTS in text else ""
    return {
        "Program": f"vsb {__version__}, {clock.strftime('%Y-%m-%d')}",
        "Command": f"vsb run {study.study}.yaml, that file being the study at the end of this table{files}",
        "Inputs": _inputs(stored),
        **hydrodynamics,
        "Time domain": f"{runs[0]['method']}, {study.simulation.duration:g} s of motion in "
        f"{max(run['seconds'] for run in runs):.3f} s or less per design and sea",
        "Largest energy residual": f"{max(run['energy_residual'] for run in runs):.1e}",
        "Study": text,
    }


def _inputs(stored: Inputs) -> str:
    """What the results rest on, each by its content."""
    study, plan = stored.study, stored.plan
    files = [f"study {plan.identity}", *(f"{name} {Path(path).stem}" for name, path in plan.hydro_files.items())]
    files += [f"{wave.kind} {wave.file.digest}" for wave in study.waves if wave.of_file]
    if study.KIND == "body":
        given = getattr(study.body, study.body.kind)
        named = given.paths if isinstance(given, BodyFile) else {study.body.kind: given}
        files += [f"{name} {content}" for name, content in named.items()]
    return ", ".join(files)


def _water_facts(stored: Inputs) -> dict[str, str]:
    """Where the hydrodynamic coefficients come from."""
    ds, model, labels = stored.database, stored.radiation.attrs, list(map(str, stored.database.influenced_dof.values))
    history = "; ".join(text for text in (ds.attrs.get("history", ""), model.get("history", "")) if text)
    solver, seconds = ds.attrs["solver"], ds.attrs.get("bem_seconds")
    return {
        "Coefficients": "spectral integral equation" if solver == "spectral" else str(solver),
        "Hydro database": f"{Path(stored.path('database')).name}: {ds.sizes['omega']} frequencies from "
        f"{float(ds.omega[0]):g} to {float(ds.omega[-1]):g} rad/s, {len(labels)} degrees of freedom: "
        f"{', '.join(labels)}",
        **({} if seconds is None else {"Seconds of solving": f"{float(seconds):.1f} on one core"}),
        "Radiation model": f"{model['order']} states, rms error {model['fit_error']:.1e}, "
        f"fitted in {model['seconds']:.1f} s",
        **({"History": history} if history else {}),
    }


def _cross_check_facts(stored: Inputs) -> dict[str, str]:
    """What the second solver was, and how long it took; nothing of a body, which none knows."""
    if (study := stored.study).KIND == "body":
        return {}
    if reason := no_witness(study):
        return {"Cross-check": f"none ({reason})"}
    ds, name = stored.witness, Path(stored.path("witness")).name
    panels, spectral = (float(ds.witness_seconds.sel(solver=solver).sum()) for solver in ("panels", "spectral"))
    return {
        "Cross-check": f"{name}: {ds.sizes['shape']} shapes at {ds.sizes['omega']} frequencies by "
        f"{ds.attrs['panels']} on {ds.attrs['rows']} rows ({panels:.1f} s) and the spectral solver ({spectral:.1f} s)"
    }


ANIMATED_SEAS = 4
"""Most seas whose motion a page holds."""


def animated_study(stored: Inputs, words: Mapping[str, str]) -> dict[str, Any] | None:
    """Return the motion of all designs in the first seas of a study, its still water left out where there are waves.

    None of a body whose coefficients come without its mesh.
    """
    study, shown = stored.study, _shown(stored)
    if radius := study.radius:
        labels = list(map(str, stored.modes.mode.values))
        factor = round_factor(_largest(stored, lambda run: largest_shell(run.position, labels)), radius)
        view, drawn = View(SEEN * radius), {"factor": factor, "shapes": shapes_data(stored.modes)}
    elif OUTLINE in (ds := stored.database):
        labels = list(map(str, ds.influenced_dof.values))
        view, drawn = outline_data(ds, _largest(stored, lambda run: largest_motion(ds, run)))
    else:
        return None
    return {
        "designs": designs_data(list(study.designs), study.reference_design),
        "width": view.width,
        **drawn,
        "seas": [_frames(stored, wave, words[wave.label], view, labels) for wave in shown],
    }


def _shown(stored: Inputs) -> tuple[Wave, ...]:
    """Seas that are drawn."""
    return (stored.study.one_of_each_sea or stored.study.drawn_waves)[:ANIMATED_SEAS]


def _largest(stored: Inputs, motion: Callable[[xr.Dataset], float]) -> float:
    """Largest motion [m] of all designs in the seas that are drawn, within the study's window."""
    window, designs = slice(*stored.study.simulation.window), stored.study.designs
    return max(motion(stored.runs[one, wave.label].sel(time=window)) for wave in _shown(stored) for one in designs)


def _frames(stored: Inputs, wave: Wave, words: str, view: View, labels: Sequence[str]) -> dict[str, Any]:
    """Frames of one sea; of a spread one the line through the designs does not tell its surface."""
    study = stored.study
    runs = {design: stored.runs[design, wave.label].position for design in study.designs}
    sea = study_sea(study, wave, stored.database) if study.needs_bem else NO_WAVES
    moved = sea if sea.heading is None else NO_WAVES
    period = study.simulation.duration / PERIODS if wave.still else 2 * math.pi / wave.omega
    towards = math.radians(heading(wave))
    return frames_data(words, runs, moved, study.simulation.window, period, view, study.water, labels, towards)
