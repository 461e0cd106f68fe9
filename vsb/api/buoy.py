"""A first result without files: a rigid and a flexible buoy by a few numbers, over wave periods."""

import tempfile
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import yaml

from vsb.api.plots import StudyPlots
from vsb.api.results import Results
from vsb.engine.hydro.database import Check
from vsb.engine.hydro.labels import RIGID
from vsb.engine.waves.water import power_limit
from vsb.errors import ConfigError
from vsb.models.rest import reference_shell
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import with_degree
from vsb.results.ledger import shell_checks
from vsb.stages import make
from vsb.stages.init import example_of_radius
from vsb.study.study import parse

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
        study = with_degree(StudyPlan(self.study)).study
        return shell_checks(study, reference_shell(study))

    @cached_property
    def _results(self) -> Results:
        """The hydrodynamics and the response, solved when first asked for."""
        self._folder = tempfile.TemporaryDirectory(prefix="vsb-")
        plan = with_degree(StudyPlan(self.study, root=self._folder.name))
        if failed := [check for check in self._checks if check.verdict == "fail"]:
            raise ConfigError(f"vsb.Buoy: {failed[0].line}")
        make.hydro_files(plan.study, self._folder.name)
        if plan.study.needs_bem:
            make.make(plan, [plan.response.out])
        return Results(plan.study, self._folder.name)

    def _frequencies(self, periods: npt.ArrayLike) -> tuple[pd.Index, npt.NDArray[np.float64]]:
        """Periods as an index, and their frequencies [rad/s], within the band solved."""
        at = np.atleast_1d(np.asarray(periods, dtype=float))
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
