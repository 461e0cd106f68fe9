"""Numbers and names a study file may hold, and the sections they stand in.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import PurePath
from typing import Annotated, Any, ClassVar, Self, cast

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
    model_serializer,
)
from pydantic._internal._model_construction import ModelMetaclass  # the type of BaseModel
from pydantic_core import CoreSchema

from vsb.errors import ConfigError
from vsb.keys.meanings import Key, describe


def number(value: object) -> object:
    """Refuse what pydantic would silently turn into a number (true -> 1.0)."""
    if isinstance(value, bool):
        raise ValueError("a number is needed, not true/false")
    return value


@dataclass(frozen=True)
class Range(AfterValidator):
    """A check that a number lies in a range, and the range for those who write the number down."""

    least: float
    most: float

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the number's JSON schema with its range."""
        return {**handler(core), "minimum": self.least, "maximum": self.most}


def within(least: float, most: float, unit: str, because: str) -> Range:
    """Return what refuses a number beyond its physical range, and says why there is nothing."""

    def checked(value: float) -> float:
        if not least <= value <= most:
            bound = f"at most {most:g}" if value > most else f"at least {least:g}"
            raise ValueError(f"needs {bound} {unit}, because {because}")
        return value

    return Range(checked, least, most)


Number = Annotated[float, BeforeValidator(number)]
Count = Annotated[int, BeforeValidator(number)]
Positive = Annotated[Number, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[Number, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[Number, Field(allow_inf_nan=False)]
Colatitude = Annotated[Number, Field(ge=0, le=180)]  # [degrees]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]  # of files, too


OR_AUTO = WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"const": "auto"}]})
"""JSON schema of a number that follows from the size of the buoy if it is not given."""


class _Reported(ModelMetaclass):
    """Reports wrong values of a section made in Python as those of a file are: one line each, as `ConfigError`."""

    def __call__(cls, *args: Any, **values: Any) -> Any:
        """Make a section; pydantic itself makes those within a section without this call."""
        kind = cast(type[Section], cls).kind_of(values)
        try:
            return ModelMetaclass.__call__(kind, *args, **values)
        except ValidationError as error:
            from vsb.keys.reading import lines_of

            lines = [f"{error.title}: {line}" for line in lines_of(error, values, kind)]
            raise ConfigError(lines[0], lines) from None


class Section(BaseModel, metaclass=_Reported):
    """A part of a study: unknown keys are errors, values never change."""

    KEYS: ClassVar[Mapping[str, Key]] = {}  # what keys mean that `vsb.keys.meanings` does not list
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Describe the keys of a section with its own `KEYS` and those of the sections it is made from."""
        known = {name: key for base in reversed(cls.__mro__) for name, key in vars(base).get("KEYS", {}).items()}
        own = {name: key for name, key in known.items() if name in cls.model_fields}
        if own and not getattr(cls, "__abstractmethods__", None):
            describe(cls.__name__, own)

    @classmethod
    def kind_of(cls, raw: object) -> "type[Section]":
        """Return the class that keys are of: of several kinds one."""
        return cls

    def only(self, *names: str, **changed: Any) -> Self:
        """Return a part of a section: these keys alone, and some changed. Reading another raises `AttributeError`."""
        return self._of_keys({name: getattr(self, name) for name in names} | changed)

    def has(self, name: str) -> bool:
        """Whether a part of a section has a key."""
        return name in self.__dict__

    @classmethod
    def part(cls, raw: Mapping[str, Any], **within: "type[Section]") -> Self:
        """Return a part of a section from its JSON, by name the sections in it that are parts as well."""
        known: dict[str, Any] = dict(_defaults(cls)) if issubclass(cls, Brief) else {}
        for name, value in raw.items():
            if name not in cls.model_fields:
                raise ValueError(f"{name}: unknown key")
            known[name] = within[name].part(value) if name in within else _adapter(cls, name).validate_python(value)
        return cls._of_keys(known)

    @classmethod
    def _of_keys(cls, known: dict[str, Any]) -> Self:
        """Make one of keys that were checked, as unpickling does: `model_construct` would make all defaults first."""
        made, state = cls.__new__(cls), {"__dict__": known, "__pydantic_fields_set__": {*known}}
        made.__setstate__({**state, "__pydantic_extra__": None, "__pydantic_private__": None})
        return made


@cache
def _adapter(section: type[Section], name: str) -> TypeAdapter[Any]:
    """What checks the value of one key."""
    return TypeAdapter(section.model_fields[name].rebuild_annotation())


class Brief(Section):
    """A section that leaves keys out of its JSON while they have their defaults: those of `BRIEF`, or all.

    A key that came later changes no id of a study that does not use it.
    """

    BRIEF: ClassVar[tuple[str, ...]] = ()

    @model_serializer(mode="wrap")
    def _without_defaults(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        said: dict[str, Any] = dump(self)
        absent = {name for name, default in _defaults(type(self)) if name in said and getattr(self, name) == default}
        return {key: value for key, value in said.items() if key not in absent}


@cache
def _defaults(section: type[Brief]) -> list[tuple[str, Any]]:
    """Keys a section leaves out of its JSON while they have their defaults, and these."""
    fields = section.model_fields
    return [(name, fields[name].get_default(call_default_factory=True)) for name in section.BRIEF or fields]


def at_key(data: object, key: str) -> Any:
    """Return what stands at a key such as device.shape.series.radial.1 in sections, mappings and lists; or None."""
    found: Any = data
    for word in key.split("."):
        if isinstance(found, list | tuple):
            found = found[int(word)] if word.isdigit() and int(word) < len(found) else None
        else:
            found = found.get(word) if isinstance(found, dict) else getattr(found, word, None)
    return found


def canonical(data: object) -> str:
    """Return the canonical JSON of plain data: sorted keys, no spaces, infinity as a string."""
    return json.dumps(_plain(data), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _plain(data: object) -> object:
    """Make data fit for JSON: tuples to lists, numbers that are whole stay as floats, infinity to "inf"."""
    if isinstance(data, float):  # first: most of what is named by its contents are frequencies
        return ("inf" if data > 0 else "-inf") if math.isinf(data) else data + 0.0  # no negative zero
    if data is None or isinstance(data, str | int):
        return data
    if isinstance(data, dict):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    return _plain(data.model_dump()) if isinstance(data, BaseModel) else data


def leaves(data: object, name: str = "") -> dict[str, object]:
    """Return the values of nested mappings and lists by their names with dots."""
    below = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else None
    if not below:
        return {name: data}
    return {key: leaf for part, inner in below for key, leaf in leaves(inner, f"{name}.{part}".lstrip(".")).items()}


def content_id(data: object) -> str:
    """Return the content id (16 hex digits of sha256 over the canonical JSON) of a spec."""
    return hashlib.sha256(canonical(data).encode()).hexdigest()[:16]


def result_id(spec: object, *inputs: str) -> str:
    """Return the content id of a result: of its specification and the ids of its inputs it does not name itself."""
    return content_id({"spec": spec, "inputs": inputs} if inputs else spec)


def id_in(path: str | PurePath) -> str:
    """Return the content id in the name of a file that studies share, or the name of the folder it lies in."""
    name = PurePath(path)
    return name.stem if re.fullmatch("[0-9a-f]{16}", name.stem) else name.parent.name
