"""Command init: a commented study of one's own, of a buoy or of a body, or a campaign, from shipped ones."""

import json
import os
import re
from numbers import Real
from pathlib import Path

import yaml

from vsb.errors import ConfigError
from vsb.keys.reading import read_yaml
from vsb.study.body import located, read_study
from vsb.study.campaign import read
from vsb.study.design import read as read_design
from vsb.study.study import load, parse
from vsb.study.vary import powers
from vsb.tools.commands import HOME
from vsb.tools.files import write_text

EXAMPLE, BODY, CAMPAIGN, DESIGN = (HOME / "config" / f"{name}.yaml" for name in ("buoy", "float", "year", "best_buoy"))
BODY_CAMPAIGN = HOME / "config" / "float_year.yaml"
SITE = """Hs/Te, 5,  6, 7, 8, 9
0.75,  5,  8, 6, 3, 1
1.25,  4, 10, 9, 5, 2
1.75,  1,  6, 9, 6, 3
2.5,   0,  3, 6, 5, 3
3.5,   0,  0, 1, 2, 2
"""
"""A table of occurrences, percent of the year, to be replaced by one's own."""
SMALLEST, LARGEST = 0.01, 100.0
"""Radii asked for [m]."""
NUMBER = r"-?\d+\.?\d*(?:e[-+]?\d+)?"


def init(path: str, radius: float | None = None) -> None:
    """Write a commented study that is named after its file: the shipped one, or that scaled by Froude to a radius [m].

    Raises `ConfigError` if the file exists, its name cannot be a study's, or no such buoy can be computed.
    """
    target = _new(path)
    text = _adapted(EXAMPLE, target, study=target.stem)
    if radius is not None:
        text = _of_radius(text, radius, "--radius")
    parse(yaml.safe_load(text), source=path)
    write_text(path, text)


def example_of_radius(radius: float) -> str:
    """Return the text of the shipped study, scaled by Froude to a radius [m]."""
    return _of_radius(EXAMPLE.read_text(encoding="utf-8"), radius, "radius")


def _of_radius(text: str, radius: float, name: str) -> str:
    """The text of the shipped study scaled to a radius [m], which errors give a name."""
    if not (isinstance(radius, Real) and SMALLEST <= radius <= LARGEST):
        raise ConfigError(f"{name}: received {radius!r}, needs {SMALLEST:g} to {LARGEST:g} m")
    return scaled(text, radius / load(EXAMPLE).device.radius)


def init_body(path: str) -> None:
    """Write a commented study of a body that is named after its file; raises as `init`."""
    target = _new(path)
    text = _adapted(BODY, target, study=target.stem)
    located(yaml.safe_load(text), path)
    write_text(path, text)


def init_campaign(path: str, study: str) -> str:
    """Write a commented campaign of a study, named after its file; return a table of occurrences, written beside it.

    Raises `ConfigError` as `init`, if the study is none of a buoy or a body, or the table exists.
    """
    target, base = _new(path), os.path.relpath(study, Path(path).parent)
    site = target.with_name(f"{target.stem}_site.csv")
    if site.exists():
        raise ConfigError(f"{site}: exists already; give the campaign a new name")
    raw = read_yaml(study, "a study file such as config/buoy.yaml")
    of_body = read_study(raw, study).study.KIND == "body"
    base = base if re.fullmatch(r"[\w./-]+", base) else json.dumps(base)  # quoted as YAML reads it
    climate = f"{{scatter: {site.name}{', direction: 0.0' * of_body}}}"
    shipped = BODY_CAMPAIGN if of_body else CAMPAIGN
    text = _adapted(shipped, target, campaign=target.stem, study=base, climate=climate)
    text = re.sub("# or {scatter:.*", "# percent of the year: put your site's in its place, or {spectra: FILE}", text)
    write_text(site, SITE)
    read(yaml.safe_load(text), path)
    write_text(path, text)
    return str(site)


def init_design(path: str) -> str:
    """Write a design problem, named after its file, and the study it varies; return that. Raises as `init`."""
    target = _new(path)
    study = target.with_name(f"{target.stem}_study.yaml")
    init(str(study))
    text = _adapted(DESIGN, target, design=target.stem, study=study.name)
    text = text.replace("climate/", f"{HOME / 'config'}/climate/")
    try:
        read_design(yaml.safe_load(text), path)
    except ConfigError:
        study.unlink()
        raise
    write_text(path, text)
    return str(study)


def _new(path: str) -> Path:
    """A study file that is not there yet."""
    target = Path(path)
    if target.exists():
        raise ConfigError(f"{path}: exists already; give a new name")
    if target.suffix not in (".yaml", ".yml"):
        raise ConfigError(f"{path}: received a name without .yaml, needs one such as my_buoy.yaml")
    if not (target.stem.isidentifier() and target.stem.isascii()):  # before it is put into YAML
        raise ConfigError(f"{path!r}: received {target.stem!r}; needs letters, digits and _, first a letter")
    return target


def _adapted(shipped: Path, target: Path, **values: str) -> str:
    """Text of a shipped file with other values of keys at its left margin; its first line says how to run it."""
    title = f"# `vsb check {target.name}`, then `vsb run {target.name}`."
    text = re.sub("^#.*", title, shipped.read_text(encoding="utf-8"), count=1)
    for key, value in values.items():  # a comment keeps its column where the value leaves room
        old = re.search(rf"^{key}: [^#\n]*", text, flags=re.M)
        assert old is not None
        new, comment = f"{key}: {value}", text[old.end() : old.end() + 1] == "#"
        text = text[: old.start()] + (f"{new}    ".ljust(len(old[0])) if comment else new) + text[old.end() :]
    return text


def scaled(text: str, scale: float) -> str:
    """Return a study's text with every quantity scaled by Froude: lengths by `scale`, times by its root."""
    known = {key: power for key, power in powers().items() if power}

    def at_scale(found: re.Match[str]) -> str:  # to six digits, as YAML reads them
        factor = scale ** known[found["key"]]
        return re.sub(NUMBER, lambda one: repr(float(f"{factor * float(one[0]):.6g}")), found[0])

    return re.sub(rf"\b(?P<key>{'|'.join(known)}): (?:{NUMBER}|\[.*?\])", at_scale, text)
