"""Figures of opened results for notebooks and papers: matplotlib axes in, axes out; a design keeps its colour."""

from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes

from vsb.engine.hydro.bodies.body import OUTLINE
from vsb.engine.hydro.variables import ROTATIONS, motion_of
from vsb.engine.motion.linear import direction_index
from vsb.errors import ConfigError
from vsb.models.floating_system import heading, study_sea
from vsb.report.canvas import bin_edges, number_cells, style
from vsb.report.interactive import displaced_outline, largest_motion, outline_data, surface, without_drift
from vsb.report.shell_figures import outline
from vsb.results.year import HEIGHT, PERIOD
from vsb.tools.arrays import FloatArray

FRAMES_PER_PERIOD = 24
PERIODS_SHOWN = 4
SEEN = 1.7
"""Half the width of the water in an animation, in half widths of the meridian."""


class _Moving(NamedTuple):
    """What an animation draws, frame by frame."""

    x: FloatArray  # (frame, point) [m]
    z: FloatArray
    place: FloatArray  # of the surface, along x (place,) [m]
    surface: FloatArray  # (frame, place) [m]
    heights: tuple[float, float]  # that are seen [m]


class StudyPlots:
    """Figures of a study's results.

    Parameters
    ----------
    results : vsb.Results
    """

    def __init__(self, results: Any) -> None:
        self._results = results

    def style(self, design: str) -> dict[str, Any]:
        """Return colour, line style and label of a design, as all figures have them: options of `Axes.plot`."""
        study = self._results.study
        return style(design, list(study.designs), study.reference_design)

    def rao(self, dof: str = "Heave", direction: float | None = None, ax: Axes | None = None) -> Axes:
        """Draw the modulus of the response amplitude operator of a degree of freedom over frequency.

        Its take-off is the given damper, or where none is given the optimal damping at each frequency.

        Parameters
        ----------
        dof : str
        direction : float [degrees], optional
            Of the waves, where the response has several; by default the first.
        ax : Axes, optional
        """
        return self._curves(abs(self._rao(dof, direction)), f"|RAO| of {dof} [{_unit(dof)}/m]", ax)

    def rao_phase(self, dof: str = "Heave", direction: float | None = None, ax: Axes | None = None) -> Axes:
        """Draw the phase by which a degree of freedom lags the wave crest at the origin; parameters as of `rao`."""
        rao = self._rao(dof, direction)
        degrees = xr.apply_ufunc(np.degrees, xr.apply_ufunc(np.angle, rao))
        return self._curves(degrees.where(abs(rao) > 0), f"phase of {dof} [degrees]", ax)

    def _rao(self, dof: str, direction: float | None) -> xr.DataArray:
        """The response amplitude operator of a degree of freedom in one direction (design, omega)."""
        rao = self._results.response.rao
        return _along(_motion(rao, "dof", dof), direction)

    def excitation(self, dof: str = "Heave", direction: float | None = None, ax: Axes | None = None) -> Axes:
        """Draw modulus (solid) and phase (dashed, right axis) of the wave excitation; parameters as of `rao`."""
        axes = _axes(ax)
        force = _along(_motion(self._results.database.excitation_force, "influenced_dof", dof), direction)
        axes.plot(force.omega, abs(force) / 1e3, color="black")
        unit = "kN" if _unit(dof) == "m" else "kN m"
        axes.set(xlabel="wave frequency [rad/s]", ylabel=f"|excitation| of {dof} [{unit}/m]")
        phase = axes.twinx()
        phase.plot(force.omega, np.degrees(np.unwrap(np.angle(force))), color="black", linestyle="--")
        phase.set_ylabel("phase [degrees]")
        return axes

    def power(self, at: str = "best", direction: float | None = None, ax: Axes | None = None) -> Axes:
        """Draw absorbed power over frequency.

        Parameters
        ----------
        at : {'best', 'given'}
            Optimal damping at each frequency, or the take-off of the study.
        direction : float [degrees], optional
            As of `rao`.
        ax : Axes, optional
        """
        response = self._results.response
        power = {"best": response.best_power, "given": response.absorbed_power}
        if at not in power:
            raise ConfigError(f"at: received {at!r}, needs one of {', '.join(power)}")
        axes = self._curves(_along(power[at], direction) / 1e3, "absorbed power per amplitude² [kW/m²]", ax)
        if self._results.study.LIMIT:  # of other bodies no limit is known
            limit, top = _along(response.power_limit, direction) / 1e3, axes.get_ylim()[1]
            axes.plot(limit.omega, limit, color="0.6", linewidth=3, alpha=0.6, label="limit", zorder=0)
            axes.set_ylim(0, top)
        axes.legend(frameon=False)
        return axes

    def power_matrix(self, design: str, matrix: xr.Dataset | None = None, ax: Axes | None = None) -> Axes:
        """Draw the power matrix of a design over Hs and Te [kW], numbers in the cells.

        Parameters
        ----------
        design : str
        matrix : Dataset, optional
            Of `vsb.Results.power_matrix`; by default that of all bins.
        ax : Axes, optional
        """
        found = (self._results.power_matrix() if matrix is None else matrix).isel(tuning=0)
        if design not in found.design.values:
            raise ConfigError(f"design: received {design!r}, needs one of {', '.join(map(str, found.design.values))}")
        axes = _matrix(found.power_matrix.sel(design=design) / 1e3, "mean power [kW]", ax)
        axes.set_title(design)
        return axes

    def motion(self, dof: str = "Heave", wave: str | None = None, ax: Axes | None = None) -> Axes:
        """Draw the displacement of a degree of freedom in time, all designs that have it, in the study's window."""
        axes, results = _axes(ax), self._results
        start, end = results.study.simulation.window
        for design in results.study.designs:
            run = results.trajectory(design, wave)
            if dof in run.dof.values:
                run = run.sel(time=slice(start, end))
                axes.plot(run.time, run.position.sel(dof=dof), **self.style(design))
        axes.set(xlabel="time [s]", ylabel=f"{dof} [{_unit(dof)}]")
        axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)  # curves fill the axes
        return axes

    def animate(self, design: str, wave: str | None = None, magnify: float = 1.0) -> FuncAnimation:
        """Return an animation of the last periods of the window: a buoy's meridian, or a body's hull cut along x.

        The water is the undisturbed surface, around a buoy the one at its axis.

        Show it in a notebook with `IPython.display.HTML(animation.to_jshtml())`, or write it with `animation.save`.

        Parameters
        ----------
        design, wave : str
        magnify : float
            Factor on the deformation of the shell, not on heave and waves; of a body on motion and waves.
        """
        results = self._results
        run, (first, end) = results.trajectory(design, wave), results.study.simulation.window
        period = results.period(wave)
        time = np.arange(max(first, end - PERIODS_SHOWN * period), end, period / FRAMES_PER_PERIOD)
        seen = (self._hull if results.study.KIND == "body" else self._meridian)(run.interp(time=time), wave, magnify)
        figure, axes = plt.subplots()
        (hull,) = axes.plot([], [], **self.style(design))
        (water,) = axes.plot([], [], color="#0072B2", linewidth=1)
        axes.set(xlim=seen.place[[0, -1]], ylim=seen.heights, aspect="equal", xlabel="x [m]", ylabel="z [m]")

        def draw(frame: int) -> tuple[Any, ...]:
            hull.set_data(seen.x[frame], seen.z[frame])
            water.set_data(seen.place, seen.surface[frame])
            axes.set_title(f"{design}, t = {time[frame]:.2f} s")
            return hull, water

        return FuncAnimation(figure, draw, frames=len(time), interval=1e3 * period / FRAMES_PER_PERIOD)

    def _meridian(self, at: xr.Dataset, wave: str | None, magnify: float) -> "_Moving":
        """A buoy at some times; in any wave its surface is the one at the axis."""
        modes = self._results.modes
        if "order" in modes and bool((modes["order"] > 0).any()):
            raise ConfigError("motion: an animation in Python is of axisymmetric motion; needs motion: heave")
        outlines = np.array([outline(modes, at.isel(time=i), magnify) for i in range(at.sizes["time"])])
        x, heave = outlines[:, 0], at.position.sel(dof="Heave").values[:, None]
        z = modes.attrs["centre_height"] + heave + outlines[:, 1]
        width = SEEN * float(np.abs(x).max())
        level = np.repeat(at.elevation.values[:, None], 2, axis=1)
        return _Moving(x, z, np.array([-width, width]), level, (-width, width))

    def _hull(self, at: xr.Dataset, wave: str | None, magnify: float) -> "_Moving":
        """A body at some times, and the surface along the middle of its hull."""
        study, ds = self._results.study, self._results.database
        if OUTLINE not in ds:
            raise ConfigError("body: its coefficients come without a mesh to animate; needs a body of a mesh")
        sea = next(one for one in study.waves if not wave or wave == one.label)
        waves, towards = study_sea(study, sea, ds), np.deg2rad(heading(sea))
        if waves.heading is not None:
            raise ConfigError("waves: an animation of a body is in waves of one direction; received a spread sea")
        view, data = outline_data(ds, magnify * largest_motion(ds, at))
        place = view.middle[0] + view.width * np.linspace(-1, 1, view.across)
        along = place * np.cos(towards) + view.middle[1] * np.sin(towards)
        level = magnify * surface(waves, at.time.values, along, study.water)
        rest = ds[OUTLINE].values[..., ::2]
        lines = rest + magnify * (displaced_outline(ds, without_drift(at.position)) - rest)
        apart = np.full((*lines.shape[:2], 1, 2), np.nan)  # lines are drawn in one stroke, with gaps
        points = np.concatenate([lines, apart], axis=2).reshape(len(lines), -1, 2)
        return _Moving(points[..., 0], points[..., 1], place, level, (-data["bottom"], data["top"]))

    def _curves(self, values: xr.DataArray, label: str, ax: Axes | None) -> Axes:
        """Values of all designs over frequency."""
        axes = _axes(ax)
        for design in map(str, values.design.values):
            axes.plot(values.omega, values.sel(design=design), **self.style(design))
        axes.set(xlabel="wave frequency [rad/s]", ylabel=label)
        axes.legend(frameon=False)
        return axes


class CampaignPlots:
    """Figures of a campaign's results.

    Parameters
    ----------
    campaign : vsb.Campaign
    """

    def __init__(self, campaign: Any) -> None:
        self._campaign = campaign

    def power_matrix(
        self,
        design: str,
        tuning: str | None = None,
        quantity: str = "power_matrix",
        ax: Axes | None = None,
        **point: Any,
    ) -> Axes:
        """Draw a matrix over Hs and Te with its numbers in the cells.

        Parameters
        ----------
        design : str
        tuning : str, optional
            By default the first of the campaign.
        quantity : str
            `power_matrix` [kW in the figure], `capture_width_matrix` [m], `damping`.
        ax : Axes, optional
        **point
            Values of what is varied, as `scale=4.0`; by default the first.
        """
        data = self._campaign.at(**point).sel(design=design, tuning=tuning or self._campaign.tunings[0])
        values = data[quantity].where(data["count"] > 0)
        factor, unit = (1e-3, "kW") if values.attrs.get("units") == "W" else (1.0, values.attrs.get("units", ""))
        axes = _matrix(values * factor, f"{values.attrs.get('long_name', quantity)} [{unit}]", ax)
        axes.set_title(design)
        return axes

    def scatter(self, ax: Axes | None = None) -> Axes:
        """Draw how often seas of each Hs and Te occur in the year, in per cent, numbers in the cells."""
        data = self._campaign.at()
        return _matrix(100 * data.occurrence.where(data["count"] > 0), "occurrence [%]", ax)

    def power(self, tuning: str | None = None, ax: Axes | None = None, **point: Any) -> Axes:
        """Draw annual mean power of the designs as bars [kW]."""
        axes = _axes(ax)
        data = self._campaign.at(**point).sel(tuning=tuning or self._campaign.tunings[0])
        designs = [str(name) for name in data.design.values]
        colours = [style(design, designs, data.attrs.get("reference"))["color"] for design in designs]
        axes.bar(designs, data.annual_mean_power / 1e3, color=colours)
        axes.set_ylabel("annual mean power [kW]")
        return axes


def _motion(values: xr.DataArray, dim: str, dof: str) -> xr.DataArray:
    """Values of a degree of freedom."""
    if dof not in (known := [str(label) for label in values[dim].values]):
        raise ConfigError(f"dof: received {dof!r}, needs one of {', '.join(known)}")
    return values.sel({dim: dof})


def _along(values: xr.DataArray, direction: float | None) -> xr.DataArray:
    """Values in waves of one direction [degrees], by default the first; a buoy in heave has one for all."""
    if "wave_direction" not in values.dims:
        return values
    known = values.wave_direction.values
    place = 0 if direction is None else direction_index(known, np.deg2rad(direction))
    if place is None:
        needed = ", ".join(f"{each:g}" for each in np.degrees(known))
        raise ConfigError(f"direction: received {direction:g} degrees, needs one of {needed}")
    return values.isel(wave_direction=place)


def _unit(dof: str) -> str:
    """Unit of a degree of freedom."""
    return "rad" if motion_of(dof) in ROTATIONS else "m"


def _axes(ax: Axes | None) -> Axes:
    """The axes given, or new ones."""
    if ax is not None:
        return ax
    _, axes = plt.subplots(layout="constrained")
    axes.grid(alpha=0.3)
    return axes


def _matrix(values: xr.DataArray, label: str, ax: Axes | None) -> Axes:
    """Values over bins of Hs and Te as coloured cells with numbers."""
    axes = _axes(ax)
    values = values.transpose("hs", "te")
    rows, columns = (np.flatnonzero(values.notnull().any(dim)) for dim in ("te", "hs"))
    if not rows.size:
        raise ConfigError("matrix: no bin has a value, as of a design that is not viable")
    values = values[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    edges = (bin_edges(values.te.values, PERIOD), bin_edges(values.hs.values, HEIGHT))
    image = axes.pcolormesh(*edges, values, cmap="viridis")
    largest = float(values.max())
    number_cells(axes, values.te.values, values.hs.values, values.values, largest)
    axes.grid(visible=False)
    axes.set(xlabel="energy period Te [s]", ylabel="significant wave height Hs [m]")
    axes.figure.colorbar(image, ax=axes, label=label)
    return axes
