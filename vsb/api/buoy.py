"""First results without files: a rigid and a flexible buoy by a few numbers, a site's mean power with derivatives."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr
import yaml

from vsb.api.plots import StudyPlots
from vsb.api.results import Results
from vsb.design.evaluation import DAMPER, DesignModel, Quantity
from vsb.engine.hydro.database import Check
from vsb.engine.hydro.variables import RIGID
from vsb.engine.motion.take_off import port_kind
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.water import power_limit
from vsb.errors import ConfigError
from vsb.models.rest import reference_shell
from vsb.pipeline.graph import StudyPlan
from vsb.results.ledger import shell_checks
from vsb.stages import make
from vsb.stages.init import example_of_radius
from vsb.study.design import QUANTITIES, unit_of
from vsb.study.study import Study, parse
from vsb.study.vary import unit

HEAVE = RIGID[2]


class Buoy:
    """A rigid and a flexible buoy of one size and mass, in regular waves, by linear theory.

    Nothing is written: hydrodynamics lie in a temporary folder while the object lives. A whole study, with intervals
    and checks, is a file (`vsb.load`, `vsb.run`).

    Parameters
    ----------
    radius : float [m]
    water : dict, optional
        Section `water` of a study: `{"depth": 30.0}`.
    **device
        Keys of the section `device`. What is not given is that of the example, scaled by Froude to the radius; with
        `clamp` [degrees] the flexible buoy is held at a colatitude.

    Raises
    ------
    ConfigError
        If a key or value is none of a device's; by its tables and figures if the shell fails a check at rest, such as
        that of its strain.
    ConvergenceError
        By these if the shell does not carry its load at rest.
    """

    def __init__(
        self, radius: float = 2.0, *, water: dict[str, float] | None = None, clamp: float | None = None, **device: Any
    ) -> None:
        example = yaml.safe_load(example_of_radius(radius))
        raw = {
            "study": "buoy",
            "device": example["device"] | {"radius": radius} | device,
            "reference_shape": example["reference_shape"],
            "water": water or {},
            "designs": {"rigid": {"flexible": False}, "flexible": {} if clamp is None else {"clamp": clamp}},
            "waves": [{"kind": "still"}],
            "hydro": {"witness": "none"},
        }
        self.study = parse(raw, source="vsb.Buoy")

    def power(self, periods: npt.ArrayLike, damping: float | None = None) -> pd.DataFrame:
        """Return mean power per squared wave amplitude at each design's optimal damping, or at a given one [W/m^2].

        Parameters
        ----------
        periods : array_like, shape (period,) [s]
        damping : float [N s/m], optional

        Returns
        -------
        DataFrame
            By period: `rigid`, `flexible`, `limit` (lambda/2pi) and `gain` [%].
        """
        at, omega = self._frequencies(periods)
        found = {}
        for design in self.study.designs:
            port = self._results.port(design, omega)
            found[design] = port.best_power if damping is None else port.power(damping)
        water = self.study.water
        found["limit"] = np.array([power_limit(w, water.depth, water.density, water.gravity) for w in omega])
        table = pd.DataFrame(found, index=at)
        return table.assign(gain=100 * (table.flexible / table.rigid - 1))

    def rao(self, periods: npt.ArrayLike) -> pd.DataFrame:
        """Return heave over wave amplitude at each design's optimal damping [-], by period."""
        at, omega = self._frequencies(periods)
        heave = self._results.response.rao.sel(dof=HEAVE).interp(omega=omega)
        return pd.DataFrame({name: np.abs(heave.sel(design=name).values) for name in self.study.designs}, index=at)

    @property
    def plot(self) -> StudyPlots:
        """Figures over frequency: `plot.power()`, `plot.rao()`, `plot.excitation()`."""
        return StudyPlots(self._results)

    @property
    def doubts(self) -> list[str]:
        """What is doubtful about the shell at rest, such as strains at which Hooke's law is not trusted."""
        return [check.line for check in self._checks if check.verdict != "ok"]

    @cached_property
    def _checks(self) -> list[Check]:
        """Checks of the shell at rest."""
        study = StudyPlan(self.study).with_degree().study
        return shell_checks(study, reference_shell(study))

    @cached_property
    def _results(self) -> Results:
        """The hydrodynamics and the response, solved when first asked for."""
        self._folder = tempfile.TemporaryDirectory(prefix="vsb-")
        plan = StudyPlan(self.study, root=self._folder.name).with_degree()
        if failed := [check for check in self._checks if check.verdict == "fail"]:
            raise ConfigError(f"vsb.Buoy: {failed[0].line}")
        make.hydro_files(plan.study, self._folder.name)
        if plan.study.needs_bem:
            make.make(plan, [plan.response.out])
        return Results(plan.study, self._folder.name)

    def _frequencies(self, periods: npt.ArrayLike) -> tuple[pd.Index, npt.NDArray[np.float64]]:
        """Periods as an index, and their frequencies [rad/s], within the band solved."""
        at = np.atleast_1d(np.asarray(periods, dtype=float))
        if at.ndim > 1:
            raise ConfigError(f"periods: received an array of shape {at.shape}, needs one row of periods [s]")
        omega = self._results.response.omega.values
        shortest, longest = 2 * np.pi / omega[-1], 2 * np.pi / omega[0]
        if not ((at >= shortest) & (at <= longest)).all():
            raise ConfigError(f"periods: received {at.tolist()} s, needs {shortest:.3g} to {longest:.3g} s")
        return pd.Index(at, name="period [s]"), 2 * np.pi / at

    def __repr__(self) -> str:
        """Say what is compared, and what to doubt."""
        device = self.study.device
        head = f"<vsb.Buoy: rigid and flexible, radius {device.radius:g} m, wall {device.thickness:g} m of "
        return "\n".join([f"{head}{device.young_modulus:.3g} Pa>", *self.doubts])


POWER, GAIN = "annual_mean_power", "gain_percent"


def gradient(
    study: Study,
    climate: Climate,
    variables: Sequence[str],
    uncertain: Mapping[str, float] | None = None,
    degree: int | None = None,
) -> xr.Dataset:
    """Return a site's mean power and what limits a buoy, of all designs, with exact derivatives by keys of the study.

    Parameters
    ----------
    study : Study
        A buoy that heaves; its waves are not used, nor its damper unless it is a variable.
    climate : Climate
        See `read_seas`.
    variables : sequence of str
        Keys, such as `device.radius`; `vsb.study.design.VARIABLES`, or `designs.NAME.clamp`.
    uncertain : mapping key -> float, optional
        Relative standard deviations of some of the variables; the others are known.
    degree : int, optional
        Highest Legendre degree of the shell's displacements; that of the study if not given, which may follow from its
        `modes.tolerance`.

    Returns
    -------
    xarray.Dataset
        For every quantity, such as `annual_mean_power(design)`, its derivatives
        `annual_mean_power_gradient(design, variable)` per unit of each variable and, with `uncertain`, its standard
        deviation `annual_mean_power_deviation(design)`; `gain_percent` if there is a rigid design. Coordinates
        `value(variable)` and `unit(variable)`. See `vsb.design.evaluation.DesignModel.at`.

    Raises
    ------
    ConfigError
        If the study has no such keys, or its year depends on more than axisymmetric motion.
    ConvergenceError
        If the shell buckles before it carries its load.
    StabilityError
        If a design is not stable at rest.
    """
    given = dict(uncertain or {})
    if unknown := [key for key in given if key not in variables]:
        raise ConfigError(f"uncertain: received {unknown[0]}; needs some of the variables, {', '.join(variables)}")
    if DAMPER in variables and not (isinstance(study.pto.damping, float) and study.pto.damping > 0):
        raise ConfigError(f"pto.damping: received {study.pto.damping}; needs one above 0, or not to be a variable")
    if study.flexible and degree is None and study.modes.degree is None:
        degree = StudyPlan(study).with_degree().study.modes.max_degree
    model = DesignModel.of(study, next(iter(study.designs)), climate, variables, degree)
    models = {name: replace(model, design=name) for name in study.designs}
    found = {name: dict(model.at(model.point).quantities) for name, model in models.items()}
    if (reference := study.reference_design) is not None:
        power = found[reference][POWER]
        for quantities in found.values():
            quantities[GAIN] = quantities[POWER].gain(power)
    point = np.array(model.point)
    deviations = np.abs(point) * [given.get(key, 0.0) for key in variables]
    kind, names = port_kind(study.pto.port), list(next(iter(found.values())))
    data: dict[str, xr.Variable] = {}
    for name in names:
        each: list[Quantity] = [quantities[name] for quantities in found.values()]
        meaning, of = QUANTITIES[name].meaning, unit_of(name, kind)
        data[name] = xr.Variable("design", [one.value for one in each], {"units": of, "long_name": meaning})
        data[f"{name}_gradient"] = xr.Variable(
            ("design", "variable"),
            [one.gradient for one in each],
            {"units": f"{of} per unit of the variable", "long_name": f"derivatives of the {meaning}"},
        )
        if given:
            data[f"{name}_deviation"] = xr.Variable(
                "design",
                [one.deviation(deviations) for one in each],
                {"units": of, "long_name": f"standard deviation of the {meaning}, to first order"},
            )
    coords = {
        "design": list(found),
        "variable": list(variables),
        "value": ("variable", point),
        "unit": ("variable", [unit(key, kind) for key in variables]),
    }
    return xr.Dataset(data, coords)
