"""The stages of the workflow: a rule and a command of one name, and the function `run_NAME` of a module here."""

import importlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from vsb.errors import ConfigError
from vsb.study import specs
from vsb.study.body import AnyStudy
from vsb.study.quantities import canonical, result_id
from vsb.study.reading import one_line
from vsb.study.specs import Spec
from vsb.tools.stamps import check_product

BEM_FILES = "database radiation response witness"
"""What a model without BEM does not have."""
BODY_FILES = "folder green mesh modes database wamit bemio"
"""Where frequencies solved are kept and the Green function's table, and the files a body is read from."""


@dataclass(frozen=True)
class Stage:
    """A stage: what it makes, the type of its specification, its files in and out; `optional` ones may be absent."""

    name: str
    home: str  # its module in this folder, in which its function is run_NAME
    text: str
    spec: Any  # a type, or a union of types; None of a stage without specification
    files: tuple[str, ...]
    optional: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()  # those of its files that it makes, or folders it writes into

    def run(self, files: Mapping[str, str | None], text: str) -> None:
        """Run the stage on files by option, with a specification as JSON; imports the science only now."""
        run = getattr(importlib.import_module(f"vsb.stages.{self.home}"), f"run_{self.name}")
        named = {name: files[name] or "" for name in (*self.files, *self.optional)}
        run(*([self.read(text)] if self.spec else []), **named)

    def check_outputs(self, files: Mapping[str, str | None], text: str) -> None:
        """Check that files it makes replace at most its own of an earlier run; raises `DatabaseError`."""
        try:
            tag = str(json.loads(text)["stage"]) if self.spec else self.name
        except (ValueError, LookupError, TypeError, RecursionError):
            tag = self.name  # of a study, or wrong, which `run` says
        for path in filter(None, (files[name] for name in self.writes)):
            check_product(path, self.name, tag)

    def read(self, text: str) -> Any:
        """Return the specification of a text; raises `ConfigError`."""
        source = "standard input"
        try:
            raw = json.loads(text)
        except json.JSONDecodeError as error:
            seen = repr(rest[:40]) if (rest := text[error.pos :].strip()) else "its end"
            raise ConfigError(
                f"{source}:{error.lineno}: no JSON from {seen} on; needs the specification of the rule"
            ) from None
        except (ValueError, RecursionError):
            raise ConfigError(
                f"{source}: numbers too long or parts too deep; needs the specification of the rule"
            ) from None
        if not isinstance(raw, dict):
            raise ConfigError(f"{source}: received {text[:40]}, needs a mapping")
        try:
            return TypeAdapter(self.spec).validate_python(raw)
        except ValidationError as error:
            raise ConfigError(f"{source}: {one_line(error, raw)}") from None


_ROWS: tuple[tuple[str, str, str, Any, str, str], ...] = (
    ("modes", "shell", "shell modes", specs.ModesSpec, ">out", ""),
    ("display", "shell", "viewable deformed meshes", specs.DisplaySpec, ">out >manifest", ""),
    ("mesh", "panels", "mean wetted mesh", specs.SphereMesh | specs.LoadedMesh, ">out", ""),
    ("green", "panels", "Green-function table", None, "folder >out", ""),
    ("deformed", "panels", "meshes of the mean and of deformed shells", specs.DeformedSpec, ">out", ""),
    ("witness", "panels", "two solvers on the mean and on deformed shells", specs.WitnessSpec, "meshes >out", ""),
    ("panels", "panels", "one block of frequencies by panels", specs.PanelsSpec, "mesh green >out", ""),
    ("spectral", "water", "one block of frequencies without panels", specs.SpectralSpec, ">out", ""),
    ("coefficients", "coefficients", "hydro database of a body, solved or read", specs.BodySpec, ">out", BODY_FILES),
    ("database", "water", "hydro database from blocks", specs.DatabaseSpec, "blocks >out", ""),
    ("radiation", "frequency", "radiation model", specs.RadiationSpec, "database >out", ""),
    ("response", "frequency", "frequency response", specs.ResponseSpec, "database >out", ""),
    ("ladder", "frequency", "power at every control level", specs.LadderSpec,
     "database >out >levels >manifest", "degrees"),
    ("simulate", "simulate", "one design in one sea", specs.SimulateSpec,
     ">out", "database radiation"),
    ("compare", "compare", "comparison and validity", specs.CompareSpec,
     "trajectories >out >statistics >validity >study >tables >manifest", f"{BEM_FILES} levels"),
    ("figures", "report", "all figures", AnyStudy, "trajectories >out >manifest", f"modes {BEM_FILES}"),
    ("report", "report", "HTML report", AnyStudy,
     "tables trajectories figures >out >manifest", f"modes {BEM_FILES}"),
    ("members", "campaign", "points of a campaign over the year", specs.MembersSpec, "climate folder root >out", ""),
    ("verification", "verification", "seas of the year in time", specs.VerificationSpec, "climate root >out", ""),
    ("campaign", "campaign", "a whole campaign", specs.CampaignSpec, "batches verifications >out >table >manifest", ""),
    ("campaign_report", "campaign_report", "figures and report of a campaign", specs.CampaignSpec,
     "data climate root >figures >out >manifest", ""),
    ("design_start", "design", "the best buoy from one start", specs.DesignStartSpec, "climate >out", ""),
    ("design_front", "design", "the best buoys over one limit", specs.DesignFrontSpec, "climate starts >out", ""),
    ("design_verification", "design_verification", "the best buoys in time", specs.DesignVerificationSpec,
     "climate starts root >out", ""),
    ("design_results", "design_results", "a whole design problem", specs.DesignSpec,
     "climate starts fronts verifications >folder >manifest", ""),
    ("design_report", "design_report", "figures and report of a design", specs.DesignSpec,
     "data >figures >out >manifest", ""),
)  # fmt: skip
"""Name, module, what it makes, specification, files and optional files of each stage, in the order of the workflow.

Those that a stage writes, or folders it writes into, begin with `>`.
"""
STAGES = tuple(
    Stage(
        name,
        home,
        text,
        spec,
        tuple(files.replace(">", "").split()),
        tuple(optional.split()),
        tuple(file.removeprefix(">") for file in files.split() if file.startswith(">")),
    )
    for name, home, text, spec, files, optional in _ROWS
)


def stamp(spec: Spec, *inputs: str) -> dict[str, str]:
    """Return the stamp of a netCDF file: its specification, and its id by that and the ids its inputs are named by."""
    ids = [Path(path).stem for path in inputs if path]
    return {"spec": canonical(spec), "spec_id": result_id(spec, *ids)}
