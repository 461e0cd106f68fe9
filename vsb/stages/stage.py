"""The stages of the workflow: of one name are a rule, a command, a file of this folder and its function `run`."""

import importlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from pydantic import TypeAdapter, ValidationError

from vsb.errors import ConfigError
from vsb.study import specs
from vsb.study.body import BodyStudy
from vsb.study.reading import one_line
from vsb.study.specs import Spec
from vsb.study.study import Study, canonical, result_id

BEM_FILES = ("database", "radiation", "response", "witness")
"""What a model without BEM does not have."""
BODY_FILES = ("folder", "green", "mesh", "modes", "database", "wamit", "bemio")
"""Where frequencies solved are kept and the Green function's table, and the files a body is read from."""


@dataclass(frozen=True)
class Stage:
    """A stage: what it makes, the type of its specification, its files in and out; `optional` ones may be absent."""

    name: str
    text: str
    spec: Any  # a type, or a union of types; None of a stage without specification
    files: tuple[str, ...]
    optional: tuple[str, ...] = ()

    def run(self, files: Mapping[str, str | None], text: str) -> None:
        """Run the stage on files by option, with a specification as JSON; imports the science only now."""
        module = importlib.import_module(f"vsb.stages.{self.name}")
        named = {name: files[name] or "" for name in (*self.files, *self.optional)}
        module.run(*([self.read(text)] if self.spec else []), **named)

    def read(self, text: str) -> Any:
        """Return the specification of a text.

        Raises
        ------
        ConfigError
        """
        source = "standard input"
        try:
            raw = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise ConfigError(f"{source}: not valid JSON ({error}); needs the specification of the rule") from None
        if not isinstance(raw, dict):
            raise ConfigError(f"{source}: received {text[:40]}, needs a mapping")
        mistakes = []
        for kind in get_args(self.spec) or (self.spec,):
            try:
                return TypeAdapter(kind).validate_python(raw)
            except ValidationError as error:
                mistakes.append(error)
        raise ConfigError(
            f"{source}: {one_line(min(mistakes, key=ValidationError.error_count), raw)}"
        )  # of the nearest type


STAGES = (
    Stage("modes", "shell modes", specs.ModesSpec, ("out",)),
    Stage("display", "viewable deformed meshes", specs.DisplaySpec, ("out", "manifest")),
    Stage("mesh", "mean wetted mesh", specs.SphereMesh | specs.LoadedMesh, ("out",)),
    Stage("green", "Green-function table", None, ("folder", "out")),
    Stage("deformed", "meshes of the mean and of deformed shells", specs.DeformedSpec, ("out",)),
    Stage("witness", "two solvers on the mean and on deformed shells", specs.WitnessSpec, ("meshes", "green", "out")),
    Stage("panels", "one block of frequencies by panels", specs.PanelsSpec, ("mesh", "green", "out")),
    Stage("spectral", "one block of frequencies without panels", specs.SpectralSpec, ("out",)),
    Stage("coefficients", "hydro database of a body, solved or read", specs.BodySpec, ("out",), BODY_FILES),
    Stage("database", "hydro database from blocks", specs.DatabaseSpec, ("blocks", "out")),
    Stage("radiation", "radiation model", specs.RadiationSpec | specs.BodyRadiationSpec, ("database", "out")),
    Stage("response", "frequency response", specs.ResponseSpec | specs.BodyResponseSpec, ("database", "out")),
    Stage(
        "ladder",
        "power under ever better take-offs",
        specs.LadderSpec | specs.BodyLadderSpec,
        ("database", "out", "rungs", "manifest"),
    ),
    Stage("simulate", "one design in one sea", specs.SimulateSpec | specs.BodySimulateSpec, ("out",), BEM_FILES[:2]),
    Stage(
        "compare",
        "comparison and validity",
        specs.CompareSpec | specs.BodyCompareSpec,
        ("trajectories", "out", "statistics", "validity", "study", "tables", "manifest"),
        (*BEM_FILES, "rungs"),
    ),
    Stage(
        "figures",
        "all figures",
        Study | BodyStudy,
        ("trajectories", "out", "manifest"),
        ("modes", *BEM_FILES),
    ),
    Stage(
        "report",
        "HTML report",
        Study | BodyStudy,
        ("tables", "trajectories", "figures", "out", "manifest"),
        ("modes", *BEM_FILES),
    ),
    Stage("members", "points of a campaign over the year", specs.MembersSpec, ("climate", "folder", "root", "out")),
    Stage("verification", "seas of the year in time", specs.VerificationSpec, ("climate", "root", "out")),
    Stage(
        "campaign",
        "a whole campaign",
        specs.CampaignSpec,
        ("batches", "verifications", "out", "table", "manifest"),
    ),
    Stage(
        "campaign_report",
        "figures and report of a campaign",
        specs.CampaignSpec,
        ("data", "climate", "root", "figures", "out", "manifest"),
    ),
)
"""In the order of the workflow."""


def stamp(spec: Spec, *inputs: str) -> dict[str, str]:
    """Return the stamp of a netCDF file: its specification, and its id by that and the ids its inputs are named by."""
    ids = [Path(path).stem for path in inputs if path]
    return {"spec": canonical(spec), "spec_id": result_id(spec, *ids)}
