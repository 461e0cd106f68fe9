"""The canonical JSON of plain data and of sections, and the content ids made of it. Pure Python."""

import hashlib
import json
import math

from pydantic import BaseModel


def canonical(data: object) -> str:
    """Return the canonical JSON of plain data: sorted keys, no spaces, infinity as a string."""
    return json.dumps(_plain(data), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _plain(data: object) -> object:
    """Make data fit for JSON: tuples to lists, numbers that are whole stay as floats, infinity to "inf"."""
    if isinstance(data, BaseModel):
        return _plain(data.model_dump())
    if isinstance(data, dict):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, float) and math.isinf(data):
        return "inf" if data > 0 else "-inf"
    return data + 0.0 if isinstance(data, float) else data  # no negative zero


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
