"""Figures of the motion of a body: its port in time, and how far each degree of freedom moves."""

import numpy as np
from matplotlib.figure import Figure

from vsb.report.canvas import StudyData, folded, grid_of_axes, legend_above, panels, style
from vsb.tools.words import superscripts


def port_motion(data: StudyData, wave: str) -> Figure:
    """Draw displacement and velocity of the take-off's port."""
    kind = data.port
    moved = (f"port's {kind.motion} [{superscripts(kind.motion_unit)}]", lambda run: run.stroke)
    moves = (f"port's {kind.rate} [{superscripts(kind.rate_unit)}]", lambda run: run.stroke_rate)
    return panels(data, wave, [moved, moves])


def degrees_of_freedom(data: StudyData, wave: str) -> Figure:
    """Draw how far every degree of freedom moves in the window, half of it from end to end."""
    labels = list(dict.fromkeys(str(d) for design in data.designs for d in data.runs[design, wave].dof.values))
    figure, axes = grid_of_axes(1.6 + 0.28 * len(labels))
    ax, height = axes[0, 0], 0.8 / len(data.designs)
    for i, design in enumerate(data.designs):
        run = data.runs[design, wave].sel(time=slice(*data.window)).position
        half = (run.max("time") - run.min("time")) / 2
        rows = np.array([labels.index(str(label)) for label in half.dof.values])
        line = style(design, data.designs)
        ax.barh(
            rows + (i - (len(data.designs) - 1) / 2) * height,
            half.values,
            height,
            color=line["color"],
            label=line["label"],
        )
    ax.set_yticks(range(len(labels)), [folded(label, 24) for label in labels])
    ax.invert_yaxis()
    ax.set(xlabel="half of the range in the window [m, of rotations rad]")
    if any(bar.get_width() > 0 for bar in ax.patches):
        ax.set(xscale="log")
    legend_above(figure, ax)
    return figure
