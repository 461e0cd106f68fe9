"""Reading of YAML files into checked values: one line for every mistake."""

from collections.abc import Hashable
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from vsb.errors import ConfigError

Model = TypeVar("Model", bound=BaseModel)


class _UniqueKeyLoader(yaml.SafeLoader):
    """YAML loader that refuses a key given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Build a mapping; a repeated key is an error."""
        seen: set[object] = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=deep)
            if key in seen:
                raise yaml.MarkedYAMLError(problem=f"key {key!r} is given twice", problem_mark=key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


def read_yaml(path: str | Path, wanted: str) -> object:
    """Return what a YAML file holds.

    Parameters
    ----------
    path : path
    wanted : str
        What kind of file is needed, in words.

    Raises
    ------
    ConfigError
        If it cannot be read, is not YAML, or gives a key twice.
    """
    try:
        return yaml.load(Path(path).read_text(encoding="utf-8"), Loader=_UniqueKeyLoader)  # noqa: S506 (a SafeLoader)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); give the path of {wanted}") from None
    except RecursionError:
        raise ConfigError(f"{path}: not valid YAML (nested too deeply); give {wanted}") from None
    except (yaml.YAMLError, TypeError, ValueError) as error:
        raise ConfigError(f"{path}: not valid YAML ({' '.join(str(error).split())})") from None


def validated(model: type[Model], raw: object, source: str) -> Model:
    """Return a model from nested mappings.

    Raises
    ------
    ConfigError
        One line with the source, the key, the value received and the value needed.
    """
    if not isinstance(raw, dict):
        raise ConfigError(
            f"{source}: received {type(raw).__name__}, needs a mapping with keys {', '.join(model.model_fields)}"
        )
    if key := _unprintable(raw):
        raise ConfigError(f"{source}: {key}: received a number of too many digits; needs at most {DIGITS}")
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        raise ConfigError(f"{source}: {one_line(error)}") from None


def _unprintable(raw: object) -> str:
    """Key of the first integer Python does not print: libraries that word a mistake would fail in doing so."""
    items = (
        list(raw.items()) if isinstance(raw, dict) else list(enumerate(raw)) if isinstance(raw, list | tuple) else []
    )
    for key, value in items:
        if isinstance(key, int) and abs(key) >= 10**DIGITS:
            return "a key"
        if isinstance(value, int) and abs(value) >= 10**DIGITS:
            return str(key)
        if below := _unprintable(value):
            return f"{key}.{below}"
    return ""


def one_line(error: ValidationError) -> str:
    """Return the first error of a validation in one line, and how many more: a misspelt key before what it left out."""
    first, *more = sorted(error.errors(), key=lambda one: one["type"] != "extra_forbidden")
    key = ".".join(str(part) for part in first["loc"]) or error.title.lower()
    received = "" if isinstance(first["input"], dict | BaseModel) else f" received {_shown(first['input'])};"
    what = first["msg"].removeprefix("Value error, ")
    tag = str(first.get("ctx", {}).get("tag", ""))
    if len(tag) > LONGEST:
        what = what.replace(tag, _cut(tag))
    if first["type"] == "extra_forbidden":
        what = "unknown key; remove it or correct its spelling"
    return " ".join(f"{key}:{received} {what}".split()) + (f" (and {len(more)} more)" if more else "")


LONGEST = 80
"""Characters of a value that are repeated."""
DIGITS = 4300
"""Digits of an integer, more of which Python does not print."""


def _shown(value: object) -> str:
    """A value as it is repeated to people: no page of it."""
    return _cut(repr(value))


def _cut(text: str) -> str:
    """A text, or its beginning and how long it is."""
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}... ({len(text)} characters)"
