"""Run a study from Python, open what a run left: results as tables and labelled arrays, each read when asked for."""

import csv
import json
import os
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr

from vsb.api.best_buoy import BestBuoy
from vsb.api.campaign import Campaign
from vsb.api.plots import StudyPlots
from vsb.engine.hydro.database import load_database
from vsb.engine.motion.constrained import ConstrainedOptimum, optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port, Ports
from vsb.engine.motion.take_off import Pto, port_kind
from vsb.engine.waves.climate import OUTSIDE, Climate
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.scatter import climate_of_cells
from vsb.errors import ConfigError, DatabaseError
from vsb.models.build import DesignInSea, design_in_sea
from vsb.models.floating_system import FloatingSystem, band, floating_system, heading_in, study_sea
from vsb.pipeline.graph import AnyPlan, plan_for
from vsb.pipeline.plans import DesignPlan
from vsb.report.answer import answer_of_study
from vsb.results.comparison import time_series
from vsb.results.year import HEIGHT, PERIOD, Tuning, Year, frequencies, year
from vsb.stages import make
from vsb.study.body import LocatedBody, read_study
from vsb.study.campaign import check_conversion
from vsb.study.design import LoadedDesign
from vsb.study.specs import Run
from vsb.study.study import BuoyStudy, Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load
from vsb.tools.stamps import read_text
from vsb.tools.variables import described

UNITS = {
    "displacement_pp": "m", "velocity_pp": "m/s", "power_peak": "W", "power_mean": "W", "energy": "J",
    "capture_width": "m", "energy_gain_percent": "%", "power_gain_percent": "%", "energy_residual": "1",
    "limit_fraction": "1", "gap": "1", "noise": "1", "forecast": "s", "power_low": "W", "power_high": "W",
    "record_power_mean": "W", "record_power_low": "W", "record_power_high": "W", "record_start": "s", "record_end": "s",
}  # fmt: skip
"""Units of the columns of tables that do not depend on the port."""
HEIGHTS = HEIGHT * (np.arange(12) + 0.5)
PERIODS = PERIOD * (np.arange(2, 17) + 0.5)
"""Centres of the bins of a power matrix [m], [s]."""


@overload
def run(study: Study | LocatedBody, folder: str | Path = "results", *, quiet: bool | None = None) -> "Results": ...
@overload
def run(study: LoadedDesign, folder: str | Path = "results", *, quiet: bool | None = None) -> BestBuoy: ...
def run(
    study: Study | LocatedBody | LoadedDesign, folder: str | Path = "results", *, quiet: bool | None = None
) -> "Results | BestBuoy":
    """Run a whole study or design problem in this process: files and numbers are those of `vsb run`.

    Parameters
    ----------
    study : Study, LocatedBody or LoadedDesign
        See `vsb.load`, `vsb.load_body`, `vsb.load_design`.
    folder : str or Path
        Folder of all results, of which finished ones are kept; studies in it share their hydrodynamics.
    quiet : bool, optional
        Whether to say nothing of what begins and the time left; by default in a terminal and in notebooks it is said.

    Raises
    ------
    VsbError
        If the study cannot be run, a check of its hydrodynamics fails, or another run is at work in the folder.
    """
    if not isinstance(study, BuoyStudy | LocatedBody | LoadedDesign):
        raise ConfigError(f"vsb.run: received {study!r}, needs what vsb.load, load_body or load_design returns")
    if quiet is None:
        quiet = not (sys.stderr.isatty() or "ipykernel" in sys.modules)
    if isinstance(study, LoadedDesign):
        problem = DesignPlan(study, root=str(folder))
        make.run(problem, quiet=quiet)
        return BestBuoy(problem.folder)
    found, files = study if isinstance(study, LocatedBody) else (study, None)
    plan = plan_for(found, str(folder), files).with_degree()
    make.run(plan, quiet=quiet)
    return Results(plan.study, str(folder))


@dataclass(frozen=True, repr=False)
class Results:
    """Results of a study: read when asked for, and refused if they are not what the study asks for.

    Raises
    ------
    DatabaseError
        By everything here: if a file is missing, damaged, or of another study.
    ConfigError
        If the study has no such design or sea, or its model no such result.
    """

    study: Study
    folder: str = "results"  # of all results

    @cached_property
    def plan(self) -> AnyPlan:
        """Names and content ids of all files."""
        return plan_for(self.study, self.folder).with_degree()

    # tables ----------------------------------------------------------------------------------------------------------

    @property
    def comparison(self) -> pd.DataFrame:
        """A row per design and sea; units of the columns in `attrs["units"]`."""
        return self._table("comparison")

    @property
    def statistics(self) -> pd.DataFrame:
        """A row per design and irregular sea, over its realisations."""
        return self._table("statistics")

    @property
    def gains(self) -> pd.DataFrame:
        """The gain of each design in each sea at optimal damping and at the given one, with intervals [%]."""
        return self._table("equal_tuning")

    @property
    def checks(self) -> pd.DataFrame:
        """The validity ledger, worst first."""
        return self._table("checks")

    @property
    def ladder(self) -> pd.DataFrame:
        """A row per design, sea and control level; NaN where a level has no such value."""
        path = self._with_bem("control levels", f"{self.plan.folder}/ladder.csv")
        rows = csv.DictReader(read_text(path, self.plan.manifest, self.plan.file_ids[path]).splitlines())
        words = ("design", "wave", "rung")
        return self._frame([{k: v if k in words else float(v or "nan") for k, v in row.items()} for row in rows])

    # arrays ----------------------------------------------------------------------------------------------------------

    @cached_property
    def response(self) -> xr.Dataset:
        """Response amplitude operators, ports, powers and wet natural frequencies of all designs.

        By `omega` [rad/s], with `period` [s] beside it.
        """
        path = self._with_bem("frequency response", f"{self.plan.folder}/response.nc")
        stored = load(path, expected=self.plan.response.id)
        return stored.assign_coords(period=("omega", 2 * np.pi / stored.omega.values, {"units": "s"}))

    @cached_property
    def database(self) -> xr.Dataset:
        """The hydro database: added mass, radiation damping and excitation by frequency."""
        path = self._with_bem("hydro database", *self.plan.hydro_files.values())
        return load_database(path, Path(path).stem)

    @cached_property
    def modes(self) -> xr.Dataset:
        """Shapes of the shell modes along a meridian, and the amplitudes at rest."""
        if (modes := self.plan.modes) is None:
            raise ConfigError("body: has no shell modes; needs a study of a buoy")
        return load(modes.out, expected=modes.id)

    def trajectory(self, design: str, wave: str | None = None) -> xr.Dataset:
        """Return the time series of a design in a sea, named by its label; by default in the first."""
        found = self._wave(wave)
        run = self.plan.simulation(self._design(design), found)
        return load(run.out, expected=run.id)

    def series(self, design: str, wave: str | None = None) -> xr.Dataset:
        """Return the time series of a design in a sea under the names of WEC-Sim's `output`: motion, forces, power.

        Parameters
        ----------
        design : str
        wave : str, optional
            By default the first.

        Returns
        -------
        Dataset
            See `vsb.results.comparison.time_series`: forces act on the body, `power_absorbed` is positive where power
            is absorbed, and its mean over the averaging window is `record_power_mean` of `comparison`.
        """
        run = self.trajectory(design, wave)
        if self.study.needs_bem:
            labels = list(self._floating.linear.labels)  # those of rings that clamps load among them
            port = xr.DataArray(self._floating.port, {"dof": labels}, ("dof",))
        else:  # an assumed pressure knows no other port than heave
            port = xr.DataArray([1.0], {"dof": ["Heave"]}, ("dof",))
        return time_series(run, port)

    # models ----------------------------------------------------------------------------------------------------------

    def scene(self, design: str, wave: str | None = None, pto: Pto | None = None) -> DesignInSea:
        """Return the scene of a design in a sea, for `vsb.simulate` and `vsb.harmonic_balance`.

        Parameters
        ----------
        design, wave : str
        pto : Pto, optional
            Another take-off than the one simulated: any law, limit or damping.
        """
        run: Run = self.plan.simulation(self._design(design), self._wave(wave)).spec["run"]
        if pto is not None:
            run = run.model_copy(update={"study": run.study.model_copy(update={"pto": pto})})
        return design_in_sea(run, dict(self.plan.hydro_files))

    def optimum(
        self, design: str, wave: str | None = None, force_limit: float = np.inf, stroke_limit: float = np.inf
    ) -> ConstrainedOptimum:
        """Return the best force within limits in a sea: power, bound of every force, force and stroke by harmonic.

        Parameters
        ----------
        design, wave : str
        force_limit, stroke_limit : float [N], [m]

        Raises
        ------
        StabilityError
            If no force within its limit keeps the stroke limit.
        """
        found = self._wave(wave)
        if self.study.pto.several:
            raise ConfigError("pto.port: the best force within limits is of one port; received several")
        low, high = band(self.study, self.database)
        sea = study_sea(self.study, found, self.database)
        harmonics = Harmonics.of_sea(sea.omega, float(max(low, self.database.omega[0])), high)
        port = self._floating.extended_port(self._design(design), harmonics.port_omega, heading_in(found, sea))
        return optimum_in_sea(port, sea, harmonics, Limits(force_limit, stroke_limit))

    def year(self, climate: Climate, tunings: Sequence[Tuning] = ("one", "each"), direction: float = 0.0) -> xr.Dataset:
        """Return power, energy, dampers and matrices of all designs over a year, by linear theory.

        Parameters
        ----------
        climate : Climate
            See `vsb.read_seas`.
        tunings : sequence of {'fixed', 'one', 'each'}
            The damper as given, one optimal damper for the year, the optimal one in each sea.
        direction : float [degrees]
            All seas go to.

        Raises
        ------
        ConfigError
            If the study has drag, which a year by linear theory does not know, or a spring and an efficiency below 1.
        """
        return self._over(climate, tunings, direction).dataset()

    def power_matrix(
        self,
        hs: npt.ArrayLike = HEIGHTS,
        te: npt.ArrayLike | None = None,
        tunings: Sequence[Tuning] = ("each",),
        gamma: float = 3.3,
        direction: float = 0.0,
    ) -> xr.Dataset:
        """Return power, capture width and damping in JONSWAP seas of many heights and periods, by linear theory.

        Limits of force and stroke are not part of it; a campaign over a scatter table has intervals, too.

        Parameters
        ----------
        hs : array_like, shape (hs,) [m]
            Significant wave heights.
        te : array_like, shape (te,) [s], optional
            Energy periods; by default the centres of bins of 1 s whose seas lie in the band of the hydrodynamics.
        tunings : sequence of {'fixed', 'one', 'each'}
            The damper as given, one optimal damper for all these seas, the optimal one in each.
        gamma : float
            Peakedness of the spectra.
        direction : float [degrees]
            All seas go to.

        Returns
        -------
        Dataset, dims (design, tuning, hs, te)
            `power_matrix` [W], `capture_width_matrix` [m], `damping`.

        Raises
        ------
        ConfigError
            If more than 1 % of a sea lies outside the band of the hydrodynamics, or as `year`.
        """
        heights, ends = np.atleast_1d(np.asarray(hs, dtype=float)), (float(self.database.omega[0]), self._highest)

        def seas_of(hs: FloatArray, te: FloatArray) -> Climate:
            return climate_of_cells(hs, te, np.full(len(hs), 1 / len(hs)), gamma, "matrix")

        def outside(period: float) -> float:
            return seas_of(np.ones(1), np.array([period])).variance_outside(*ends)

        asked = PERIODS if te is None else np.atleast_1d(np.asarray(te, dtype=float))
        periods = np.array([period for period in asked if outside(float(period)) <= OUTSIDE])
        if not len(periods) or (te is not None and len(periods) < len(asked)):
            far = [f"{period:g}" for period in asked if period not in periods]
            raise ConfigError(
                f"te: received {', '.join(far)} s, seas of which more than {OUTSIDE:.0%} lies outside "
                f"{ends[0]:.4g} to {ends[1]:.4g} rad/s, which the study solves; needs other periods or hydro.omega_max"
            )
        every = np.repeat(heights, len(periods)), np.tile(periods, len(heights))
        found = self._over(seas_of(*every), tunings, direction)
        of_seas = {"power_matrix": found.power, "capture_width_matrix": found.power / found.flux}
        of_seas["damping"] = np.asarray(found.damping)
        shape, dims = (*found.power.shape[:2], len(heights), len(periods)), ("design", "tuning", "hs", "te")
        at = {"design": list(found.designs), "tuning": list(found.tunings), "hs": heights, "te": periods}
        values = {name: (dims, value.reshape(shape)) for name, value in of_seas.items()}
        return described(xr.Dataset(values, coords=at, attrs={"port_kind": port_kind(self.study.pto.port).load}))

    @property
    def _highest(self) -> float:
        """End of the band of the hydrodynamics [rad/s]."""
        return float(band(self.study, self.database)[1])

    def _over(self, climate: Climate, tunings: Sequence[Tuning], direction: float) -> Year:
        """All designs over the seas of a climate, by linear theory."""
        pto = self.study.pto
        if self.study.plates:
            raise ConfigError("drag: a year by linear theory does not know it; needs a study without drag")
        check_conversion(pto, "pto", tunings)
        omega = frequencies(climate, float(self.database.omega[0]), self._highest)
        ports = {design: self.port(design, omega, direction).beside(pto.stiffness) for design in self.study.designs}
        given = {design: damping for design in ports if (damping := pto.damper(design)) is not None}
        reference, water, spring = self.study.reference_design, self.study.water, pto.stiffness
        return year(ports, climate, water, tunings, given, reference, pto.efficiency, stiffness=spring)

    def period(self, wave: str | None = None) -> float:
        """Return the period of a sea [s]: of an irregular one the peak period, of still water the record."""
        found = self._wave(wave)
        return self.study.simulation.duration if found.still else 2 * np.pi / found.omega

    def port(self, design: str, omega: npt.ArrayLike | None = None, direction: float = 0.0) -> Port:
        """Return impedance and free velocity at the take-off of a design.

        Parameters
        ----------
        design : str
        omega : array_like, shape (omega,) [rad/s], optional
            By default the frequencies of the database.
        direction : float [degrees]
            Of the waves.
        """
        at = self.database.omega.values if omega is None else np.atleast_1d(np.asarray(omega, dtype=float))
        if self.study.pto.several:
            raise ConfigError("pto.port: several ports have no one impedance; needs several_ports")
        return self._floating.ports(at, direction)[self._design(design)]

    def several_ports(self, design: str, omega: npt.ArrayLike | None = None) -> Ports:
        """Return impedances between several ports and their free velocities, of a design.

        Parameters
        ----------
        design : str
        omega : array_like, shape (omega,) [rad/s], optional
            By default the frequencies of the database.

        Raises
        ------
        ConfigError
            If the study's take-off has one port.
        """
        if not self.study.pto.several:
            raise ConfigError("pto.port: received one port; needs pto.ports, or a distributed one")
        at = self.database.omega.values if omega is None else np.asarray(omega, dtype=float)
        return self._floating.several_ports(at)[self._design(design)]

    # pages -----------------------------------------------------------------------------------------------------------

    @property
    def report(self) -> Path:
        """Path of the report, to be opened in a browser."""
        return Path(self.plan.folder, "report.html")

    @property
    def plot(self) -> StudyPlots:
        """Figures: each method draws on matplotlib axes, given or new, and returns them."""
        return StudyPlots(self)

    def __repr__(self) -> str:
        """Say what was compared, the answer, and what the ledger says."""
        found = self._tables
        answer = answer_of_study(self.study, found).rstrip("; ")
        verdicts = pd.Series([check["verdict"] for check in found["checks"]]).value_counts()
        seas = ", ".join(wave.label for wave in self.study.waves)
        lines = [
            f"<vsb.Results of study {self.study.study!r} in {self.plan.folder}>",
            f"designs: {', '.join(self.study.designs)}; seas: {seas}",
            answer or "no gain to state",
            f"ledger: {', '.join(f'{count} {verdict}' for verdict, count in verdicts.items())}",
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the same with the comparison as a table, for notebooks."""
        head = "<br>".join(repr(self).replace("<", "&lt;").replace(">", "&gt;").splitlines())
        return f"<p>{head}</p>{self.comparison.to_html(index=False, float_format=lambda x: f'{x:.5g}')}"

    @cached_property
    def _tables(self) -> dict[str, list[dict[str, Any]]]:
        """Tables as rows."""
        found: dict[str, list[dict[str, Any]]] = json.loads(
            read_text(f"{self.plan.folder}/tables.json", self.plan.manifest, self.plan.identity)
        )
        return found

    def _table(self, name: str) -> pd.DataFrame:
        """One of the tables."""
        return self._frame(self._tables[name])

    def _frame(self, rows: list[dict[str, Any]]) -> pd.DataFrame:
        """Rows as a table with units, those of the take-off as its port has them."""
        found, port = pd.DataFrame(rows), port_kind(self.study.pto.port)
        units = UNITS | {"damping": port.damping_unit, "stiffness": port.stiffness_unit}
        if self.study.KIND == "body":  # columns are of the port's motion
            units |= {"displacement_pp": port.motion_unit, "velocity_pp": port.rate_unit}
        units |= {"best_damping": port.damping_unit, "best_power": "W", "power": "W"}
        units |= {"force_rms": port.load_unit, "force_peak": port.load_unit, "stroke_peak": port.motion_unit}
        found.attrs["units"] = {name: units[name] for name in found.columns if name in units}
        return found

    @cached_property
    def _floating(self) -> FloatingSystem:
        """What floats."""
        return floating_system(self.study, self._with_bem("port", *self.plan.hydro_files.values()))

    def _with_bem(self, what: str, *paths: str) -> str:
        """The first of the files that only a model with BEM has."""
        if not self.study.needs_bem:
            raise ConfigError(f"hydro.model: received {self.study.hydro.model!r}, which has no {what}; needs linear")
        return paths[0]

    def _design(self, name: str) -> str:
        """A design there is."""
        return _known("design", name, self.study.designs)

    def _wave(self, label: str | None) -> Wave:
        """A sea there is."""
        waves = {wave.label: wave for wave in self.study.waves}
        return waves[_known("wave", label or next(iter(waves)), waves)]


def _known(what: str, name: str, names: Iterable[str]) -> str:
    """Check a name."""
    if name not in (known := list(names)):
        raise ConfigError(f"{what}: received {name!r}, needs one of {', '.join(known)}")
    return name


def open(path: str | Path) -> Results | Campaign | BestBuoy:
    """Open the results of a study, of a campaign or of a design problem.

    Parameters
    ----------
    path : str or Path
        Its folder, such as `results/buoy` or `results/year`.

    Raises
    ------
    DatabaseError
        If the folder holds no results.
    """
    root, name = os.path.split(Path(path).resolve())
    root = os.path.relpath(root)
    folder = Path(root, name)
    if (folder / "campaign.nc").is_file():
        return Campaign(str(folder))
    if (folder / "design.nc").is_file():
        return BestBuoy(str(folder))
    text = folder / "study.json"
    if not text.is_file():
        raise DatabaseError(f"{folder}: holds no results; needs what vsb run wrote, such as results/buoy")
    try:
        raw = json.loads(text.read_text(encoding="utf-8"))
    except (ValueError, RecursionError):
        raise DatabaseError(f"{text}: is damaged; delete it and run vsb run CONFIG again") from None
    study = read_study(raw, str(text)).study
    if name != study.study:
        raise DatabaseError(f"{folder}: holds the study {study.study}; needs a folder of that name")
    return Results(study, root)
