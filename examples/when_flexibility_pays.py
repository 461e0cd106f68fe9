"""When does a flexible buoy pay? Gain over wave period, force limit and Young's modulus, each design at its optimum.

Both designs have the optimal control force under the same limit, within half a per cent of a proven upper bound. Limits
are in units of the rms force of the rigid buoy's optimal damper in the same waves.

    python -m examples.when_flexibility_pays results/when_flexibility_pays
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from examples import command
from vsb.engine.motion.constrained import optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port
from vsb.engine.waves.seas import Sea
from vsb.errors import ConfigError
from vsb.models.floating_system import floating_system
from vsb.models.rest import computed_buckling
from vsb.report.canvas import svg_text
from vsb.stages.make import hydro_files
from vsb.study.study import Study, load, parse
from vsb.tools.files import write_text
from vsb.tools.words import csv_text

PERIODS = (2.0, 2.4, 2.7, 3.0, 3.3, 3.6, 4.0, 4.5, 5.0, 6.0, 7.0, 8.0)
"""Of regular waves and of the peaks of JONSWAP seas [s]."""
SOFTNESS = (0.25, 0.5, 1.0, 2.0, 4.0, 16.0, 100.0)
"""Young's modulus in terms of the study's."""
LIMITS = (0.1, 0.3, 1.0, np.inf)
"""Limits of the force, relative to the rms force of the rigid buoy's optimal damper."""
STEEPNESS = 0.01
"""Wave height over length; the limits scale with it, so gains do not depend on it."""
FLEXIBLE, RIGID = "VSWEC", "FSB"
DEGREE = 14
"""Of the shell modes of a study that gives none: the example's shell needs 9, a softer one more."""
SCALE = 4.0
"""Of the buoy the upper axis of the figure is for: by Froude's law the same gains, at its root times the periods."""


class Row(NamedTuple):
    """One point of the map."""

    shell: str
    young_modulus: float  # [Pa]
    buckling_factor: float  # computed buckling load over the static load, proportional to the modulus [-]
    wave: str  # regular or jonswap
    period: float  # [s]
    force_limit: float  # in terms of the rigid best damper's rms force [-]
    rigid_power: float  # [W]
    flexible_power: float  # [W]
    gain_percent: float
    gap: float  # of the worse of both optima [-]


def softened(study: Study, factor: float) -> Study:
    """Return the study with another Young's modulus, a rigid and a free design."""
    raw = study.model_dump()
    raw["device"]["young_modulus"] *= factor
    raw["designs"] = {RIGID: {"flexible": False}, FLEXIBLE: {}}
    if study.modes.degree is None:
        raw["modes"] |= {"degree": DEGREE}
    return parse({**raw, "published": None})


def waves_of(study: Study) -> Iterator[tuple[str, float, Sea]]:
    """Regular waves and seas of all periods, of one steepness, within the band solved."""
    gravity, end, highest = study.water.gravity, study.simulation.duration, study.hydro.omega_max
    for period in PERIODS:
        height = STEEPNESS * gravity * period**2 / (2 * np.pi)
        for kind, size in (
            ("regular", {"amplitude": height / 2, "period": period}),
            ("jonswap", {"hs": height, "tp": period}),
        ):
            (wave,) = parse({**study.model_dump(), "published": None, "waves": [{"kind": kind, **size}]}).waves
            yield kind, period, wave.realisation(highest, end)


def best_damper_force(port: Port, waves: Sea, at: np.ndarray) -> float:
    """Rms force of the optimal damper of a sea, by search over closely spaced dampers [N]."""
    dampers = np.geomspace(0.1, 10.0, 200) * float(np.median(port.best_damping[at]))
    squares = np.abs(waves.amplitude) ** 2
    best = dampers[int(np.argmax(port.power(dampers)[:, at] @ squares))]
    velocity = port.velocity_under(port.load(best))[at]
    return float(best * np.sqrt(np.sum(np.abs(velocity) ** 2 * squares) / 2))


def rows_of(study: Study, shell: str, folder: Path) -> Iterator[Row]:
    """All points of one shell."""
    floating = floating_system(study, hydro_files(study, folder)["database"])
    factor = computed_buckling(study).load_factor
    for kind, period, waves in waves_of(study):
        harmonics = Harmonics.of_sea(waves.omega, float(floating.linear.database.omega[0]), study.hydro.omega_max)
        seen = {name: floating.extended_port(name, harmonics.port_omega) for name in study.designs}
        at = np.searchsorted(harmonics.omega, waves.omega - 1e-9)
        unit = best_damper_force(seen[RIGID], waves, at)
        for limit in LIMITS:
            within = Limits(limit * unit)
            rigid, flexible = (optimum_in_sea(seen[name], waves, harmonics, within) for name in (RIGID, FLEXIBLE))
            gain = 100 * (flexible.power / rigid.power - 1)
            worse = max(rigid.gap, flexible.gap)
            yield Row(
                shell, study.device.young_modulus, factor, kind, period, limit, rigid.power, flexible.power, gain, worse
            )


def mapped(studies: dict[str, str], folder: Path) -> list[Row]:
    """Return the map of all shells; shells without a stable shape at rest are left out with a message."""
    rows: list[Row] = []
    for shell, path in studies.items():
        for factor in SOFTNESS:
            study = softened(load(path), factor)
            try:
                rows += rows_of(study, shell, folder)
            except ConfigError as error:
                print(f"{shell}, E = {study.device.young_modulus:.3g} Pa: no stable shape at rest ({error})")
    return rows


def drawn(rows: Sequence[Row]) -> Figure:
    """Gain over period and Young's modulus: shells and kinds of waves down, force limits across.

    Solid: no gain. Dashed: the buckling load is the static load; below it the shell gives way. The upper axis is of a
    buoy `SCALE` times as large, in lengths and Young's modulus.
    """
    panels = list(dict.fromkeys((row.shell, row.wave) for row in rows))
    figure = Figure(figsize=(10.0, 2.6 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), len(LIMITS), sharex=True, squeeze=False)
    for line, (shell, wave) in zip(axes, panels, strict=True):
        here = [row for row in rows if (row.shell, row.wave) == (shell, wave)]
        moduli = sorted({row.young_modulus for row in here})
        for ax, limit in zip(line, LIMITS, strict=True):
            gain = {(row.young_modulus, row.period): row.gain_percent for row in here if row.force_limit == limit}
            z = np.array([[gain[e, t] for t in PERIODS] for e in moduli])
            shown = ax.pcolormesh(
                PERIODS, moduli, z, cmap="RdBu", vmin=-30, vmax=30, shading="nearest", rasterized=True
            )
            ax.axhline(here[0].young_modulus / here[0].buckling_factor, color="black", linestyle="--")
            ax.set_yscale("log")
            if min(z.shape) > 1 and z.min() < 0 < z.max():
                ax.contour(PERIODS, moduli, z, levels=[0.0], colors="black", linewidths=1.0)
            ax.set_title("force free" if np.isinf(limit) else f"force limit {limit:g}", fontsize=9)
        line[0].set_ylabel(f"{shell}, {wave}\nYoung's modulus [Pa]")
    for ax in axes[-1]:
        ax.set_xlabel("period, peak period [s]")
    for ax in axes[0]:
        upper = ax.secondary_xaxis("top", functions=(lambda t: SCALE**0.5 * t, lambda t: t / SCALE**0.5))
        upper.set_xlabel(f"at {SCALE:g} times the size [s]", fontsize=8)
    figure.colorbar(shown, ax=axes, label="power gained by flexibility [%]", extend="both")
    return figure


def as_csv(rows: Sequence[Row]) -> str:
    """The map as a table."""
    return csv_text(Row._fields, rows, 8)


def run(args: argparse.Namespace) -> int:
    """Write table and figure."""
    out = Path(args.folder)
    rows = mapped({"buoy": "config/buoy.yaml"}, out)
    write_text(out / "map.csv", as_csv(rows))
    write_text(out / "map.svg", svg_text(drawn(rows)))
    print(out / "map.csv", out / "map.svg", sep="\n")
    return 0


main = command("when_flexibility_pays", __doc__, run, "{folder}/", folder="FOLDER")

if __name__ == "__main__":
    sys.exit(main(None))
