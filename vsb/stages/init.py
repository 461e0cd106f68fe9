"""Command init: a commented study of one's own, from the shipped one."""

import re
from pathlib import Path

import yaml

from vsb.errors import ConfigError
from vsb.study.study import load, parse
from vsb.study.vary import FROUDE
from vsb.tools.files import write_text
from vsb.tools.shipped import HOME

EXAMPLE = HOME / "config" / "buoy.yaml"
SMALLEST, LARGEST = 0.01, 100.0
"""Radii asked for [m]."""
NUMBER = r"-?\d+\.?\d*(?:e[-+]?\d+)?"


def init(path: str, radius: float | None = None) -> None:
    """Write a commented study that is named after its file: the shipped one, or that scaled by Froude to a radius [m].

    Raises
    ------
    ConfigError
        If the file exists, its name cannot be a study's, or no such buoy can be computed.
    """
    target = Path(path)
    if target.exists():
        raise ConfigError(f"{path}: exists already; give a new name")
    if target.suffix not in (".yaml", ".yml"):
        raise ConfigError(f"{path}: received a name without .yaml, needs one such as my_buoy.yaml")
    text = EXAMPLE.read_text(encoding="utf-8").replace("study: buoy", f"study: {target.stem}")
    text = re.sub("^#.*", f"# A study of vsb: `vsb check {target.name}`, then `vsb run {target.name}`.", text, count=1)
    if radius is not None:
        if not SMALLEST <= radius <= LARGEST:
            raise ConfigError(f"--radius: received {radius:g} m, needs {SMALLEST:g} to {LARGEST:g} m")
        text = scaled(text, radius / load(EXAMPLE).device.radius)
    parse(yaml.safe_load(text), source=path)
    write_text(path, text)


def scaled(text: str, scale: float) -> str:
    """Return a study's text with every quantity scaled by Froude: lengths by `scale`, times by its root."""

    def at_scale(found: re.Match[str]) -> str:
        factor = scale ** FROUDE[found["key"]]
        return re.sub(NUMBER, lambda one: _number(factor * float(one[0])), found[0])

    return re.sub(rf"\b(?P<key>{'|'.join(FROUDE)}): (?:{NUMBER}|\[.*?\])", at_scale, text)


def _number(value: float) -> str:
    """A number of six digits as YAML reads it."""
    return repr(float(f"{value:.6g}"))
