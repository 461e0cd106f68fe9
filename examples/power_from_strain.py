"""Does taking power from strain pay, free or moored? Mean power of a measured year by port, restraint and scale.

Each take-off has its best damper, or damper matrix, for the year; shares are of the rigid buoy of the same rest shape
with a damper on heave.

    python -m examples.power_from_strain results/power_from_strain config/strain.yaml config/pressurised.yaml
"""

import argparse
import sys
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from examples import command
from vsb.engine.motion.tuning import best_dampers, best_matrix
from vsb.engine.waves.climate import Climate
from vsb.models.floating_system import floating_system
from vsb.models.take_off import matrix_kind
from vsb.results.year import band_weights, frequencies
from vsb.stages.check import read_seas
from vsb.stages.make import hydro_files
from vsb.study.study import Study, load, parse
from vsb.study.vary import scaled
from vsb.tools.files import write_text
from vsb.tools.words import csv_text

SCALES = (1.0, 4.0)
"""Of lengths, by Froude's law, in the same seas."""
SEAS = "config/climate/ndbc46042_1996_spectra.txt.gz"
AREA, BELT = {"strain": "area"}, {"strain": "hoop", "belt": [60, 120]}
BOTH = {"heave": "heave", "shell": AREA}
TAKE_OFFS: Mapping[str, dict[str, Any]] = {
    "heave": {"port": "heave"},
    "change of area": {"port": AREA},
    "hoop strain, 60 to 120 degrees": {"port": BELT},
    "damper spread over the shell": {"port": {"distributed": "membrane"}},
    "heave and area, two dampers": {"ports": BOTH, "matrix": "diagonal"},
    "heave and area, damper matrix": {"ports": BOTH, "matrix": "full"},
}
HELD: Mapping[str, dict[str, Any] | None] = {
    "free": None,
    "frame held": {"place": "heave"},
    "ring held at 110 degrees": {"place": "ring", "colatitude": 110},
}
FLEXIBLE: Mapping[str, Any] = {"flexible": {}}
RIGID: Mapping[str, Any] = {"rigid": {"flexible": False}, **FLEXIBLE}
"""Of the same shape at rest as the flexible one."""


class Row(NamedTuple):
    """One take-off of one buoy over the year."""

    study: str
    scale: float
    take_off: str
    mooring: str
    power: float  # [W]
    share_percent: float  # of the rigid buoy with a damper on heave


def with_take_off(study: Study, scale: float, pto: Mapping[str, Any], designs: Mapping[str, Any]) -> Study:
    """Return a study at another scale with another take-off."""
    raw = scaled(study.model_dump(), scale)
    raw |= {"pto": dict(pto), "designs": dict(designs)}
    raw["simulation"] |= {"initial_position": 0.0, "initial_velocity": 0.0}
    return parse(raw, source=study.study)


def power_of_year(study: Study, climate: Climate, folder: Path) -> float:
    """Return the mean power of the first design of a study over a year, at its best damper or damper matrix [W]."""
    floating, design = floating_system(study, hydro_files(study, folder)["database"]), next(iter(study.designs))
    solved = floating.linear.database.omega.values
    omega = frequencies(climate, float(solved[0]), float(solved[-1]))
    squares = np.asarray(climate.mean_density @ band_weights(omega, climate))
    if study.pto.several:
        return best_matrix(floating.several_ports(omega)[design], squares, matrix_kind(study.pto)).power
    return float(best_dampers(floating.ports(omega)[design], squares[None]).power[0])


def rows_of(study: Study, climate: Climate, folder: Path) -> Iterator[Row]:
    """All take-offs of one buoy; what a mooring holds is no port."""
    for scale in SCALES:
        row = partial(Row, study.study, scale)
        heave = power_of_year(with_take_off(study, scale, {"port": "heave"}, RIGID), climate, folder)
        yield row("heave", "rigid", heave, 100.0)
        for mooring, held in HELD.items():
            for name, pto in TAKE_OFFS.items():
                if held and "heave" in name:
                    continue
                one = with_take_off(study, scale, {**pto, "held": held}, FLEXIBLE)
                power = power_of_year(one, climate, folder)
                yield row(name, mooring, power, 100 * power / heave)


def run(args: argparse.Namespace) -> int:
    """Write the table."""
    out, climate = Path(args.folder), read_seas(SEAS)
    rows = [row for path in args.studies for row in rows_of(load(path), climate, out)]
    write_text(out / "power_from_strain.csv", csv_text(Row._fields, rows, 6))
    print(out / "power_from_strain.csv")
    return 0


main = command("power_from_strain", __doc__, run, "{folder}/", folder="FOLDER", studies="STUDY...")

if __name__ == "__main__":
    sys.exit(main(None))
