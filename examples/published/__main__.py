"""Command line: `python -m examples.published [--stored] [SOURCE...]`, in the checkout."""

import argparse
import hashlib
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from PIL import Image

import vsb
from examples.published.pages import Value, Values, up_to_date
from examples.published.sources import HOME, SOURCES, stored
from examples.published.tables import BLOCKS
from vsb.cli import answer
from vsb.errors import ConfigError, VsbError
from vsb.tools.files import write_text

VALUES = HOME / "docs" / "published" / "values.json"
SENTENCES = HOME / "docs" / "published" / "sentences.yaml"
PICTURE = HOME / "docs" / "report.png"
FOLDER = HOME / "results" / "published"
"""Results of each source, in a folder of its name."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WINDOW = (1040, 912)
"""Size of the picture: the top of the report."""


def group(name: str) -> str:
    """Return the group of a source, whose folder it shares."""
    return name.partition(".")[0]


def chosen(names: Sequence[str]) -> list[str]:
    """Return the sources of some names or groups; all if there is none."""
    if unknown := set(names) - {*SOURCES, *map(group, SOURCES)}:
        raise ConfigError(f"source: received {', '.join(sorted(unknown))}, needs some of {', '.join(SOURCES)}")
    return [name for name in SOURCES if not names or name in names or group(name) in names]


def entry(name: str, *, fresh: bool) -> dict[str, Any]:
    """Compute a source: its command, the version, what it gives, and CPU seconds if nothing was there to be reused."""
    source, folder, begun = SOURCES[name], FOLDER / group(name), cpu_seconds()
    values = {key: rounded(value) for key, value in source.compute(folder).items()}
    took = {"cpu_seconds": round(cpu_seconds() - begun, 1)} if fresh else {}
    return {"command": source.command, "version": vsb.__version__, **took, "values": values}


def rounded(value: Value) -> Value:
    """Return a number with the digits that are worth storing."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def cpu_seconds() -> float:
    """Return what this process and those it waited for have used."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def update(name: str, found: Mapping[str, Any]) -> None:
    """Store what a source gave; the time it took stays if it was not measured anew."""
    known = json.loads(VALUES.read_text(encoding="utf-8")) if VALUES.exists() else {}
    kept = {key: value for key, value in known.get(name, {}).items() if key == "cpu_seconds"}
    known[name] = {**kept, **found}
    ordered = {key: known[key] for key in (*SOURCES, "picture") if key in known}
    write_text(VALUES, json.dumps(ordered, indent=1, ensure_ascii=False) + "\n")


def pages(values: Values) -> dict[Path, str]:
    """Return every page that holds published numbers, with those values."""
    sentences: dict[str, list[str]] = yaml.safe_load(SENTENCES.read_text(encoding="utf-8"))
    found = {}
    for name, some in sentences.items():
        page = (HOME / name).read_text(encoding="utf-8")
        found[HOME / name] = up_to_date(name, page, some or [], BLOCKS, values)
    return found


def draw(report: Path, answer_shown: str) -> None:
    """Draw the top of a report as README shows it, and store what it says."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise VsbError(f"{PICTURE.relative_to(HOME)}: not drawn anew, needs one of {', '.join(BROWSERS)} on the PATH")
    size = ",".join(map(str, WINDOW))
    with tempfile.TemporaryDirectory() as profile:
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={profile}"]
        options += [f"--window-size={size}", f"--screenshot={PICTURE}", "--virtual-time-budget=4000", report.as_uri()]
        subprocess.run([browser, *options], check=True, stderr=subprocess.DEVNULL, timeout=300)
    with Image.open(PICTURE) as image:
        few = image.convert("RGB").quantize(256)  # a third of the size
    few.save(PICTURE, optimize=True)
    update("picture", {"values": {"answer": answer_shown, "sha256": digest(PICTURE)}})


def digest(path: Path) -> str:
    """Return the checksum of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def run(args: argparse.Namespace) -> int:
    """Compute sources, store what they give, and bring the pages and the picture up to date."""
    os.chdir(HOME)
    names = [] if args.stored else chosen(args.sources)
    fresh = {name: not (FOLDER / group(name)).exists() for name in names}
    for name in names:
        print(f"{name}: {SOURCES[name].command}", flush=True)
        update(name, entry(name, fresh=fresh[name]))
    for drawing in FOLDER.glob("claims/*.svg"):
        shutil.copy(drawing, HOME / "docs" / "claims")
    values = stored(VALUES)
    for path, text in pages(values).items():
        if text != path.read_text(encoding="utf-8"):
            write_text(path, text)
            print(path.relative_to(HOME))
    if "study" in names:
        draw(FOLDER / "study" / "results" / "buoy" / "report.html", str(values["study.answer"]))
        print(PICTURE.relative_to(HOME))
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Write the published numbers anew."""
    line = argparse.ArgumentParser(prog="python -m examples.published", description=__doc__)
    line.add_argument("sources", metavar="SOURCE", nargs="*", help=f"some of {', '.join(SOURCES)}; all if none")
    line.add_argument("--stored", action="store_true", help="compute nothing: pages from the values stored")
    line.set_defaults(handler=run, writes={})
    return answer(line, argv)


if __name__ == "__main__":
    sys.exit(main())
