"""Results of a design problem: the best buoys, the gain and its interval, and the tables behind them."""

import io
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import xarray as xr

import vsb.design.variables  # noqa: F401  registers them
from vsb.study.study import Study, load
from vsb.tools.files import load as load_file
from vsb.tools.stamps import read_text


class Power(NamedTuple):
    """An annual mean power and its 95 % interval [W]."""

    value: float
    low: float
    high: float


class Gain(NamedTuple):
    """A gain over the best rigid buoy and its 95 % interval [%]."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, repr=False)
class BestBuoy:
    """Results of a design problem in its folder, such as `results/best_buoy`.

    Raises
    ------
    DatabaseError
        By everything here: if `design.nc` or a table is missing or damaged.
    """

    folder: str

    @cached_property
    def data(self) -> xr.Dataset:
        """Hulls at rest and quantities of the buoys compared, by `buoy`."""
        return load_file(f"{self.folder}/design.nc")

    @cached_property
    def facts(self) -> dict[str, Any]:
        """All that the report says, as nested mappings."""
        found: dict[str, Any] = json.loads(self.data.attrs["facts"])
        return found

    @property
    def name(self) -> str:
        """Name of the design problem."""
        return str(self.facts["name"])

    @property
    def answer(self) -> str:
        """The answer in one sentence."""
        return str(self.data.attrs["answer"])

    @property
    def gain(self) -> Gain:
        """Gain of the best flexible buoy over the best rigid one [%]."""
        return Gain(**self.facts["gain"])

    @property
    def power(self) -> dict[str, float]:
        """Annual mean power of the buoys compared [W]."""
        return dict(self.facts["power"])

    @property
    def power_intervals(self) -> dict[str, Power]:
        """The same with the interval of each by all known errors [W]; the page says which are not known."""
        return {name: Power(one["value"], one["low"], one["high"]) for name, one in self.facts["powers"].items()}

    @property
    def starts(self) -> pd.DataFrame:
        """Where every start ended: variables, limits, multipliers and the certificate."""
        return self._table("starts")

    @property
    def pareto(self) -> pd.DataFrame:
        """The best buoys over the values of limits."""
        return self._table("pareto")

    @property
    def sensitivity(self) -> pd.DataFrame:
        """Relative change of power with each variable, and what wider limits bring."""
        return self._table("sensitivity")

    @property
    def budget(self) -> pd.DataFrame:
        """What the gain is uncertain by, in percentage points."""
        return self._table("budget")

    @property
    def power_budget(self) -> pd.DataFrame:
        """What the powers of the buoys compared are uncertain by [W]."""
        return self._table("power_budget")

    @property
    def optimum(self) -> Study:
        """The best flexible buoy as a study, beside the rigid one of its shape and mass."""
        return load(f"{self.folder}/optimum.yaml")

    @property
    def competitor(self) -> Study:
        """The best rigid buoy as a study."""
        return load(f"{self.folder}/competitor.yaml")

    @property
    def report(self) -> Path:
        """Path of the report, to be opened in a browser."""
        return Path(self.folder, "report.html")

    def _table(self, name: str) -> pd.DataFrame:
        """A table by its name."""
        path = f"{self.folder}/{name}.csv"
        text = read_text(path, f"{self.folder}/manifest.json", str(self.data.attrs["spec_id"]))
        return pd.read_csv(io.StringIO(text))

    def __repr__(self) -> str:
        """Say the answer."""
        return f"<vsb.BestBuoy {self.name!r} in {self.folder}>\n{self.answer}"
