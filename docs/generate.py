"""Pages of reference written from the code itself: keys of the files, commands, public names of Python."""

import argparse
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import vsb
from vsb.cli import parser
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.shell.material import NAMED
from vsb.keys.meanings import KEYS
from vsb.keys.schema import Schema, schema_of
from vsb.study.body import BodyStudy
from vsb.study.campaign import Campaign
from vsb.study.design import Optimisation
from vsb.study.study import BuoyStudy
from vsb.tools.commands import commands
from vsb.tools.words import superscripts

DOCS = Path(__file__).parent
FILES = {
    "Study": (
        BuoyStudy,
        "A study file",
        "For `vsb run` and `vsb check`; `vsb init my_buoy.yaml` writes one to begin with.",
    ),
    "BodyStudy": (
        BodyStudy,
        "A study file of a body",
        "For `vsb run` and `vsb check`, of any other body; [any body](../own-body.md) has a complete example.",
    ),
    "BodyFile": (
        BodyFile,
        "A body file",
        "For `vsb body`; [any body](../own-body.md) has a complete example.",
    ),
    "Campaign": (
        Campaign,
        "A campaign file",
        "Also for `vsb run` and `vsb check`: a study over a site's year, with some of its keys varied.",
    ),
    "Optimisation": (
        Optimisation,
        "A design file",
        "Also for `vsb run` and `vsb check`: the buoy that absorbs most in a site's year, within limits.",
    ),
}

KEYS_PREFACE = """\
Generated from the models that check a file, so it is complete. Units are SI; numbers may be written
`1.0e+7` or `10000000.0`, infinity `.inf`, or with a unit of the same kind: `15 mm`, `6.5 ft`, `30 %`, `8 kN s/m`.
A key with several units takes plain numbers.
Editors with a YAML language server complete and check files by `vsb schema`:
save its output as `vsb.schema.json` and begin a study with `# yaml-language-server: $schema=vsb.schema.json`."""
SEARCH = """\
<p hidden><label>Search keys: <input id="find-key" type="search" placeholder="device damping"></label>
<output id="found-keys" for="find-key"></output></p>"""
COMMANDS_PREFACE = """\
`vsb COMMAND --help` shows the same. Exit code 0 is success, 1 a failed check, 2 a mistake in a file or command,
reported in one line each."""


def write(folder: Path) -> None:
    """Write all pages of reference into a folder."""
    folder.mkdir(exist_ok=True)
    pages = {"keys": keys_page(), "commands": commands_page(), "python": python_page(), "materials": materials_table()}
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:  # else it would be built anew each time
            path.write_text(text, encoding="utf-8")


def materials_table() -> str:
    """Return the materials by name with their constants and sources."""
    lines = ["| `material` | constants | density [kg/m³] | source |", "|---|---|---|---|"]
    for name, found in NAMED.items():
        of_rubber = found.mu is not None
        law = f"neo-Hookean, μ = {found.mu / 1e6:g} MPa" if of_rubber else f"E = {found.young_modulus / 1e9:g} GPa, "
        law += "" if of_rubber else f"Poisson's ratio {found.poisson_ratio:g}"
        lines.append(f"| `{name}` | {law} | {found.density:g} | {found.source} |")
    return "\n".join(lines)


def keys_page() -> str:
    """Return every key with unit, default, range, example and meaning, from the models."""
    lines = ["# Every key", "", KEYS_PREFACE, "", SEARCH, ""]
    for root, (model, title, text) in FILES.items():
        schema = schema_of(model)
        lines += [f"## {title}", "", text, ""]
        for name, place, section in sections(schema, root):
            lines += [*([f"### `{place}`", ""] if place else []), *key_table(name, section), ""]
    return "\n".join(lines)


def sections(schema: Schema, root: str) -> Iterator[tuple[str, str, Schema]]:
    """Yield sections with the places they stand at, the top first, each once."""
    pending, seen = [(root, "", {key: value for key, value in schema.items() if key != "$defs"})], set()
    while pending:
        name, place, section = pending.pop(0)
        if name not in seen:
            seen.add(name)
            yield name, place, section
            for key, its in section.get("properties", {}).items():
                inner = dict.fromkeys(re.findall(r"#/\$defs/(\w+)", repr(its)))
                own = [(one, f"{place}.{key}".lstrip("."), schema["$defs"][one]) for one in inner]
                pending += [(one, f"{at}: {kind(one_section) or one}" if len(own) > 1 else at, one_section)
                            for one, at, one_section in own]  # fmt: skip


def kind(section: Schema) -> str:
    """Name of a kind of wave, or nothing."""
    return str(section.get("properties", {}).get("kind", {}).get("const", ""))


def key_table(name: str, section: Schema) -> list[str]:
    """Return a table of a section's keys."""
    lines = ["| key | meaning | unit | default | range | example |", "|---|---|---|---|---|---|"]
    for key, its in section["properties"].items():
        entry, required = KEYS[name][key], key in section.get("required", [])
        default = "**required**" if required else shown(its.get("default"))
        cells = (f"`{key}`", entry.meaning, superscripts(entry.unit), default, allowed(its), f"`{entry.example}`")
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines


def shown(value: Any) -> str:
    """A default as YAML."""
    if value is None or value in ([], {}):
        return "none"
    if isinstance(value, dict | list):
        return "those of its keys" if isinstance(value, dict) else f"`{value}`"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def allowed(its: Schema) -> str:
    """The range or the choices of a key in words."""
    forms = its.get("anyOf") or its.get("oneOf") or [its]
    return " or ".join(dict.fromkeys(text for form in forms if (text := bounds(form))))


def bounds(form: Schema) -> str:
    """The range or the choices of one form of a value."""
    if "anyOf" in form:
        return allowed(form)
    if "enum" in form:
        return ", ".join(f"`{choice}`" for choice in form["enum"])
    if form.get("type") == "array" and isinstance(form.get("items"), dict):
        return f"list, each {inner}" if (inner := bounds(form["items"])) else "list"
    low = [f"above {form['exclusiveMinimum']:g}"] if "exclusiveMinimum" in form else []
    least = form.get("minimum")
    if least is not None and least > form.get("exclusiveMinimum", least - 1):
        low = [f"from {least:g}"]
    below, most = form.get("exclusiveMaximum"), form.get("maximum")
    high = [f"to {most:g}"] if most is not None and (below is None or most < below) else []
    high = [f"below {below:g}"] if below is not None and not high else high
    return " ".join([*(["whole"] if form.get("type") == "integer" else []), *low, *high])


def commands_page() -> str:
    """Return every command with its arguments and options, from the parser."""
    lines = ["# Commands", "", COMMANDS_PREFACE, ""]
    for name, one in commands(parser()).items():
        lines += [f"## `vsb {name}`", "", str(one.description or "").strip(), "", "```", usage(one), "```", ""]
        shown = [action for action in one._actions if action.dest != "help"]
        described = [f"`{label(action)}`\n: {action.help}" for action in shown if action.help]
        lines += ["\n\n".join(described), "", *([one.epilog, ""] if one.epilog else [])]
    return "\n".join(lines)


def usage(one: argparse.ArgumentParser) -> str:
    """Usage in one line."""
    return " ".join(one.format_usage().removeprefix("usage: ").split())


def label(action: argparse.Action) -> str:
    """How an argument or option is written."""
    names = ", ".join(action.option_strings) or str(action.metavar or action.dest)
    return f"{names} {action.metavar}" if action.option_strings and action.metavar else names


def python_page() -> str:
    """Return the docstrings of the public names."""
    rows = [line for line in (DOCS / "api.md").read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    names = re.findall(r"`(\w+)`", " ".join(line.split("|")[1] for line in rows))
    lines = ["# Python", "", "[The public names](../api.md) in one table; here are their docstrings.", ""]
    for name in names:
        found = getattr(vsb, name)
        what = "autoclass" if isinstance(found, type) else "autofunction"
        members = [":members:"] if name in ("Results", "Port", "LinearSystem", "DeformedShell") else []
        lines += [f"## `{name}`", "", "```{eval-rst}", f".. {what}:: {found.__module__}.{found.__qualname__}"]
        lines += [*(f"   {option}" for option in members), "```", ""]
    return "\n".join(lines)
