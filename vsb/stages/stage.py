"""The stages of the workflow: a task's `stage` is a function `run_STAGE` of a module here."""

import importlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_type_hints

from pydantic import TypeAdapter, ValidationError

from vsb.errors import ConfigError
from vsb.keys.quantities import canonical, result_id
from vsb.keys.reading import one_line
from vsb.pipeline.graph import STAGES, Task
from vsb.study.specs import Spec
from vsb.tools.stamps import check_product, faults, read_manifest

GIVEN = "standard input"


def function_of(stage: str) -> Any:
    """Return the function of a stage; imports the science only now."""
    return getattr(importlib.import_module(f"vsb.stages.{STAGES[stage].module}"), f"run_{stage}")


def run_task(task: Task) -> None:
    """Run the stage of a task on its specification as text, as a job reads it: both give the same numbers."""
    run, spec = function_of(task.stage), json.loads(canonical(task.spec))
    run(*([specification(run, spec)] if spec is not None else []), **task.files)


def specification(run: Any, raw: Any) -> Any:
    """Return what a stage computes from, of the type of the first parameter of its function; raises `ConfigError`."""
    kind = next(iter(get_type_hints(run).values()))
    try:
        return TypeAdapter(kind).validate_python(raw)
    except ValidationError as error:
        raise ConfigError(f"{GIVEN}: {one_line(error, raw)}") from None


def run_job(rule: str, text: str) -> None:
    """Run the tasks of a job, as JSON; one whose files are there, and what they should be, is finished.

    Raises `ConfigError` by what are no tasks, `DatabaseError` if a file of the user would be replaced.
    """
    for task in read_tasks(text):
        if is_finished(task):
            continue
        tag = task.spec.get("stage", task.stage) if task.spec else task.stage
        for path in filter(None, (*task.makes, task.files.get("manifest"))):
            check_product(path, rule, tag)
        run_task(task)


def read_tasks(text: str) -> Iterator[Task]:
    """Yield the tasks of a text; raises `ConfigError`."""
    needs = "needs the tasks of a rule"
    try:
        raw = json.loads(text)
    except json.JSONDecodeError as error:
        seen = repr(rest[:40]) if (rest := text[error.pos :].strip()) else "its end"
        raise ConfigError(f"{GIVEN}:{error.lineno}: no JSON from {seen} on; {needs}") from None
    except (ValueError, RecursionError):
        raise ConfigError(f"{GIVEN}: numbers too long or parts too deep; {needs}") from None
    try:
        found = [TypeAdapter(Task).validate_python(one) for one in raw]
    except (ValidationError, TypeError):
        raise ConfigError(f"{GIVEN}: received {text[:40]}, {needs}") from None
    for task in found:
        if task.stage not in STAGES:
            raise ConfigError(f"{GIVEN}: stage: received {task.stage}, needs one of {', '.join(STAGES)}")
    yield from found


def is_finished(task: Task) -> bool:
    """Whether all that a task makes is there, of its specification and whole."""
    if not all(Path(path).exists() for path in task.makes):
        return False
    if not task.id:
        return True
    manifest = read_manifest(task.files["manifest"]) if "manifest" in task.files else {}
    return not faults(dict.fromkeys(task.makes, task.id), manifest)


def stamp(spec: Spec, *inputs: str) -> dict[str, str]:
    """Return the stamp of a netCDF file: its specification, and its id by that and the ids its inputs are named by."""
    ids = [Path(path).stem for path in inputs if path]
    return {"spec": canonical(spec), "spec_id": result_id(spec, *ids)}
