"""Figures of the shell: its modes, the deformed buoys, volume and area; and a sketch of each design for the page."""

import html
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D, Transform

from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.variables import RIGID, is_of_ring
from vsb.engine.shell.orders import goes_with_sine
from vsb.report.canvas import WIDTH, StudyData, folded, grid_of_axes, panels, sheet, style, title_above
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

MOST_SHAPES = 24
"""Shell modes that are drawn, the lowest degrees first."""


def mode_shapes(data: StudyData) -> Figure:
    """Draw the undeformed circle and each deformed meridian, the paper's Fig. 4; of many modes the lowest degrees."""
    modes, total = data.modes, data.modes.sizes["mode"]
    if total > MOST_SHAPES:
        modes = modes.isel(mode=np.argsort(modes.degree.values, kind="stable")[:MOST_SHAPES])
    count, columns, title = modes.sizes["mode"], 5, 0.25  # the last and the next two in inches
    side, text = WIDTH / columns, 0.32
    figure, ax = sheet(title + max(1, math.ceil(count / columns)) * (side + text))
    phi, rest = modes.colatitude.values, _beyond_sphere(modes) / float(modes.attrs.get("radius", 1.0))
    undeformed, shapes = _closed(*2 * [_half(1.0, phi, *rest)]), []
    sides = np.broadcast_to(_opposite(modes), count)
    for v, u, degree, opposite in zip(
        modes.radial.values, modes.meridional.values, modes.degree.values, sides, strict=True
    ):
        shortened = float(-(v + np.gradient(u, phi)).min())  # of the meridian: drawn larger, it would fold into cusps
        amplitude = min(0.25 / max(1.0, float(degree) / 2) ** 0.7, 0.4 / max(shortened, 1e-9))
        halves = (_half(1.0, phi, *(rest + sign * amplitude * np.array([v, u]))) for sign in (1.0, opposite))
        shapes.append(_closed(*halves))
    scale = (side / 2 - 0.03) / max(float(np.abs(shape).max()) for shape in (undeformed, *shapes))
    for i, (mode, frequency, shape) in enumerate(
        zip(modes.mode.values, modes.dry_frequency.values, shapes, strict=True)
    ):
        x, top = (i % columns + 0.5) * side, figure.get_figheight() - title - i // columns * (side + text)
        place = _place(ax, x, top - text - side / 2, scale)
        ax.plot(*undeformed, color="black", linewidth=0.8, transform=place, label="_" if i else "_undeformed")
        ax.plot(*shape, color="#D55E00", transform=place, label=f"_{mode}")
        ax.text(x, top - text, f"{mode}\n{frequency:.2f} rad/s dry", fontsize=8, ha="center")
    some = f"{count} of {total} shell modes" if count < total else "Shell modes"
    title_above(figure, f"{some} (black: undeformed)" if count else "A rigid study has no shell modes")
    return figure


def _place(ax: Axes, x: float, y: float, width: float, height: float | None = None) -> Transform:
    """Where on a `sheet` something is drawn that has its own coordinates; so large is a unit of them [inch]."""
    return Affine2D().scale(width, height).translate(x, y) + ax.transData


def snapshots(data: StudyData, wave: str) -> Figure:
    """Draw the deformed buoys in the wave at five instants of the last period, deformation magnified."""
    columns, names, title = 5, 0.25, 0.5  # the last two in inches
    side = (WIDTH - names) / columns
    figure, ax = sheet(title + side * len(data.designs))
    factor, end, modes = _magnification(data, wave), data.window[1], data.modes
    instants = end - min(data.periods[wave], end) * np.linspace(1, 0, columns, endpoint=False)
    reach = 1.5 * max(float(modes.attrs["radius"]), float(np.abs(_at_rest(modes)[1]).max()))
    scale, half = side / 2 / reach, 0.47 * side
    water, undeformed = [], []
    for row, design in enumerate(data.designs):
        y = side * (len(data.designs) - row - 0.5)
        ax.text(names / 2, y, folded(design), fontsize=7, rotation=90, ha="center", va="center")
        run = data.runs[design, wave].sel(time=instants, method="nearest")
        for i, instant in enumerate(instants):
            x, at = names + (i + 0.5) * side, run.isel(time=i)
            level = float(at.elevation) if "elevation" in at else 0.0
            surface = y + scale * level
            water.append([(x - half, y - half), (x + half, y - half), (x + half, surface), (x - half, surface)])
            centre = float(modes.attrs["centre_height"]) + float(at.position[0])
            undeformed.append(np.transpose(_at_rest(modes)) * scale + [x, y + scale * centre])
            ax.plot(
                *_turned(modes, at, factor) + np.array([[0.0], [centre]]),
                color=data.style(design)["color"],
                transform=_place(ax, x, y, scale),
                label=f"_{design}, t = {instant:.2f} s, water at {level:.4g} m",
            )
    for i, instant in enumerate(instants):
        ax.text(
            names + (i + 0.5) * side, figure.get_figheight() - 0.45, f"t = {instant:.2f} s", fontsize=8, ha="center"
        )
    ax.add_collection(PolyCollection(water, facecolor="#56B4E9", alpha=0.25, linewidth=0))
    ax.add_collection(LineCollection([corners[2:] for corners in water], color="#0072B2", linewidth=0.8))
    ax.add_collection(LineCollection(undeformed, color="#999999", linewidth=0.6, linestyle=":", zorder=1))
    rest = "heave, pitch and wave" if "order" in modes else "heave and wave"
    scaled = f"Shell displacement times {factor:g}, {rest} times 1" if factor > 1 else "All to scale"
    title_above(figure, f"{scaled} (dotted: undeformed)")
    return figure


def _magnification(data: StudyData, wave: str) -> float:
    """Round factor that makes the largest shell displacement about 0.2 radii."""
    steady = (data.runs[design, wave].sel(time=slice(*data.window)) for design in data.designs)
    largest = max((float(np.abs(_modal(run)).max()) for run in steady if flexible(run.dof.values)), default=0.0)
    return round_factor(largest, float(data.modes.attrs["radius"]))


def round_factor(largest: float, radius: float) -> float:
    """Return the round factor, at least one, that makes a largest displacement about a fifth of the radius."""
    if largest == 0.0:
        return 1.0
    raw = 0.2 * radius / largest
    decade = 10.0 ** math.floor(math.log10(raw))
    return max(1.0, max(m * decade for m in (1, 2, 5) if m * decade <= raw))


def _modal(run: xr.Dataset) -> FloatArray:
    """Amplitudes of the shell modes of a run that are seen on its meridian theta = 0 [m]; no rigid motions."""
    labels = [str(label) for label in run.dof.values if label not in RIGID]
    drawn = [label for label in labels if not (goes_with_sine(label) or is_of_ring(label))]
    return np.asarray(run.position.sel(dof=drawn).values)


def _opposite(modes: xr.Dataset) -> Any:
    """Sign of modes on the meridian theta = pi: (-1)^m; 1 of axisymmetric ones."""
    return (-1.0) ** modes.order.values if "order" in modes else 1.0


def _beyond_sphere(modes: xr.Dataset) -> FloatArray:
    """What leads from the sphere to another shape at rest, along its radius and its meridian, (2, colatitude) [m]."""
    if "rest_radial" not in modes:
        return np.zeros((2, modes.sizes["colatitude"]))
    return np.array([modes.rest_radial.values, modes.rest_meridional.values])


def _half(radius: float, phi: FloatArray, v: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points of one meridian about the sphere centre: x = (r+v) sin + u cos, z = (r+v) cos - u sin."""
    return (radius + v) * np.sin(phi) + u * np.cos(phi), (radius + v) * np.cos(phi) - u * np.sin(phi)


def _closed(right: tuple[FloatArray, FloatArray], left: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Two meridians as one line around the shell in the plane of the waves."""
    return np.concatenate([right[0], -left[0][::-1]]), np.concatenate([right[1], left[1][::-1]])


def _meridians(modes: xr.Dataset, run: xr.Dataset, factor: float) -> list[tuple[FloatArray, FloatArray]]:
    """Both meridians in the plane of the waves at one instant, theta = 0 and pi."""
    r, phi = float(modes.attrs["radius"]), modes.colatitude.values
    q = modes.static_amplitude.values.copy()
    if flexible(run.dof.values):
        q += factor * _modal(run)
    found = []
    for side in (1.0, _opposite(modes)):
        at = side * q
        v, u = (at @ modes[name].values if len(q) else np.zeros_like(phi) for name in ("radial", "meridional"))
        found.append(_half(r, phi, *(_beyond_sphere(modes) + np.array([v, u]))))
    return found


def outline(modes: xr.Dataset, run: xr.Dataset, factor: float) -> tuple[FloatArray, FloatArray]:
    """Return x and z of a shell around its centre at one instant of a run, its deformation magnified [m]."""
    return _closed(*_meridians(modes, run, factor))


def _at_rest(modes: xr.Dataset) -> tuple[FloatArray, FloatArray]:
    """Outline of a shell at rest around its centre."""
    return _closed(*2 * [_half(float(modes.attrs["radius"]), modes.colatitude.values, *_beyond_sphere(modes))])


def _turned(modes: xr.Dataset, run: xr.Dataset, factor: float) -> FloatArray:
    """`outline` about the sphere's centre, pitched with the buoy; surge, which may drift, is left out."""
    x, z = outline(modes, run, factor)
    angle = float(run.position.sel(dof="Pitch")) if "Pitch" in run.dof else 0.0
    return np.array([x * np.cos(angle) + z * np.sin(angle), z * np.cos(angle) - x * np.sin(angle)])


def _height(data: StudyData, run: xr.Dataset) -> xr.DataArray:
    """Distance between the poles of a run's shell over time [m]; the n-th mode changes it by V (1 + (-1)^n)."""
    at_poles = data.modes.radial.isel(colatitude=0) + data.modes.radial.isel(colatitude=-1)
    change = _modal(run) @ at_poles.values if flexible(run.dof.values) else 0.0 * run.time.values
    rest = 2 * float(data.modes.attrs["radius"]) + _beyond_sphere(data.modes)[0, [0, -1]].sum()
    return xr.DataArray(rest + change, coords={"time": run.time})


def extreme_shapes(data: StudyData, wave: str) -> Figure:
    """Draw each design's shell where it is lowest from pole to pole in the window, the paper's Fig. 7."""
    figure, axes = grid_of_axes(3.6)
    ax, factor = axes[0, 0], _magnification(data, wave)
    for design in data.designs:
        run = data.runs[design, wave].sel(time=slice(*data.window))
        lowest = run.isel(time=int(np.argmin(_height(data, run).values)))
        ax.plot(*outline(data.modes, lowest, factor), **data.style(design))
    ax.set(aspect="equal", xlabel="radius [m]", ylabel="height above the sphere centre [m]")
    title_above(figure, f"Smallest distance between the poles; shell displacement magnified {factor:g} times")
    ax.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), fontsize=8)
    return figure


def shapes_3d(data: StudyData, wave: str) -> Figure:
    """Draw the first flexible design at the start and at its least and greatest height, the paper's Fig. 8.

    The first of all where none has shell modes, as `hydro.model: auto` may choose.
    """
    design = next((d for d in data.designs if flexible(data.runs[d, wave].dof.values)), next(iter(data.designs)))
    run, factor = data.runs[design, wave], _magnification(data, wave)
    height = _height(data, run)
    inside = height.sel(time=slice(*data.window))
    instants = {
        "start": 0.0,
        "smallest height": float(inside.time[int(np.argmin(inside.values))]),
        "largest height": float(inside.time[int(np.argmax(inside.values))]),
    }
    shapes = [_meridians(data.modes, run.sel(time=at, method="nearest"), factor)[0] for at in instants.values()]
    figure, ax = sheet(2.6)
    side = WIDTH / len(shapes)
    scale = (side / 2 - 0.1) / max(float(np.hypot(*shape).max()) for shape in shapes)
    for i, ((name, instant), shape) in enumerate(zip(instants.items(), shapes, strict=True)):
        x, z = (values[::3] for values in shape)
        place, looks = ((i + 0.5) * side, side / 2 - 0.05), {"color": data.style(design)["color"], "linewidth": 0.5}
        for behind in (1.0, -1.0):  # the half behind is pale
            lines = _wires(x, behind * x, z)
            ax.plot(*lines, transform=_place(ax, *place, scale), alpha=0.4 if behind > 0 else 1.0, label="_", **looks)
        ax.plot(x, z, transform=_place(ax, *place, scale, scale * np.cos(ELEVATION)), label=f"_{name}", **looks)
        words = f"{name}\nt = {instant:.2f} s, {float(height.sel(time=instant, method='nearest')):.3f} m"
        ax.text(place[0], figure.get_figheight() - 0.5, words, fontsize=8, ha="center")
    title_above(figure, f"{design}, height between the poles; shell displacement magnified {factor:g} times")
    return figure


ELEVATION = np.radians(25.0)
"""Of the eye above the horizon, to bodies in space."""


def _wires(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Half a body of revolution as meridians and rings, seen from `ELEVATION`: one line with gaps.

    Of a meridian: radius, the same with the sign of the half, and height.
    """
    azimuth, around = np.pi * np.arange(7)[:, None] / 6, np.linspace(0, np.pi, 25)
    rings = slice(5, -1, 5)
    meridians = np.stack(np.broadcast_arrays(x * np.cos(azimuth), y * np.sin(azimuth), z))
    circles = np.stack(
        np.broadcast_arrays(np.outer(x[rings], np.cos(around)), np.outer(y[rings], np.sin(around)), z[rings, None])
    )
    gaps = (np.pad(lines, [(0, 0), (0, 0), (0, 1)], constant_values=np.nan) for lines in (meridians, circles))
    across, deep, up = np.concatenate([lines.reshape(3, -1) for lines in gaps], axis=1)
    return across, up * np.cos(ELEVATION) + deep * np.sin(ELEVATION)


def volume_area(data: StudyData, wave: str) -> Figure:
    """Draw the volume the shell encloses and its surface area, the paper's Fig. 9."""
    volume = ("enclosed volume [m³]", lambda run: run.volume)
    return panels(data, wave, [volume, ("surface area [m²]", lambda run: run.area)])


Outline = Callable[[float], tuple[float, float]]
"""Radius and height of a buoy's surface about its centre by colatitude [radii]."""
_WATERLINE, _BED = 62.0, 118.0
_SCALE = 34.0  # of a radius
_POLES = {0.0: "at the top", 90.0: "at the equator", 180.0: "at the keel"}


def design_in_words(design: dict[str, Any]) -> str:
    """Return what a design is, from its canonical form."""
    if not design["flexible"]:
        return "rigid"
    held = [_POLES.get(float(clamp), f"{clamp:g}° from the top") for clamp in design["clamp"]]
    return f"elastic shell, held {' and '.join(held)}" if held else "elastic shell, free"


def sketches(study: Study) -> list[dict[str, str]]:
    """Return a sketch of each buoy of a study with its name, and what it is in words."""
    if study.KIND == "body":
        return []
    designs = study.model_dump()["designs"]
    height, outline = study.centre_height / study.device.radius, _outline(study)
    return [
        {"name": name, "words": design_in_words(one), "svg": sketch(name, designs, height, outline)}
        for name, one in designs.items()
    ]


def _sphere(colatitude: float) -> tuple[float, float]:
    """Outline of the sphere."""
    return math.sin(colatitude), math.cos(colatitude)


def _outline(study: Study) -> Outline:
    """Outline of a study's buoy."""
    if (rest := study.device.meridian) is None:
        return _sphere

    def outline(colatitude: float) -> tuple[float, float]:
        x, z, _, _ = rest.at(colatitude)
        return x / study.device.radius, z / study.device.radius

    return outline


def sketch(name: str, designs: dict[str, dict[str, Any]], height: float, outline: Outline = _sphere) -> str:
    """Return the sketch of a design as SVG of 140 by 120; `height` of the buoy's centre above still water in radii."""
    reference = next((one for one, values in designs.items() if not values["flexible"]), None)
    design, colour = designs[name], style(name, list(designs), reference)["color"]
    scale = _SCALE / max(1.0, outline(0.0)[1], -outline(math.pi)[1])
    centre = _WATERLINE - scale * height
    keel = centre - scale * outline(math.pi)[1]
    body = f'{_surface(outline, centre, scale)} fill="{colour}" stroke="{colour}"'
    parts = [
        f'<rect x="0" y="{_WATERLINE:g}" width="140" height="{_BED - _WATERLINE:g}" class="water"/>',
        f'<{body} fill-opacity="0.12" stroke-width="{2 if design["flexible"] else 5}"/>',
        *([_swollen(outline, centre, scale, colour, design["clamp"])] if design["flexible"] else []),
        f'<path d="M70 {keel:.1f}V{_BED:g}M63 {_BED - 7:g}h14M63 {_BED - 12:g}v5m14 0v-5" class="takeoff"/>',
        *(_clamp(outline, centre, scale, clamp) for clamp in design["clamp"]),
    ]
    words = html.escape(f"{name}, {design_in_words(design)}")
    return f'<svg viewBox="0 0 140 120" role="img" aria-label="{words}">{"".join(parts)}</svg>'


def _surface(outline: Outline, centre: float, scale: float) -> str:
    """The buoy as an element of SVG, open for its attributes: a circle if it is a sphere."""
    if outline is _sphere:
        return f'circle cx="70" cy="{centre:.1f}" r="{scale:g}"'
    half = [outline(math.pi * i / 48) for i in range(49)]
    around = [*half, *((-x, z) for x, z in reversed(half))]
    return f'path d="M{"L".join(f"{70 + scale * x:.1f} {centre - scale * z:.1f}" for x, z in around)}Z"'


def _swollen(outline: Outline, centre: float, scale: float, colour: str, clamps: Sequence[float]) -> str:
    """The shell swollen and squeezed, dotted, still where it is held."""
    angles = [math.pi * i / 24 for i in range(49)]
    paths = []
    for sign in (1, -1):
        points = []
        for angle in angles:
            free = math.prod(
                abs(math.sin((abs(math.remainder(angle, 2 * math.pi)) - math.radians(c)) / 2)) * 1.4 for c in clamps
            )
            size = scale * (1 + 0.13 * sign * min(1.0, free))
            x, z = outline(angle)
            points.append(f"{70 + size * x:.1f} {centre - size * z:.1f}")
        paths.append("M" + "L".join(points))
    return f'<path d="{"".join(paths)}" fill="none" stroke="{colour}" stroke-width="0.9" stroke-dasharray="1.5 2.5"/>'


def _clamp(outline: Outline, centre: float, scale: float, colatitude: float) -> str:
    """Marks on either side where a shell is held."""
    x, z = outline(math.radians(colatitude))
    x, y = scale * x, centre - scale * z
    return "".join(f'<circle cx="{70 + side * x:.1f}" cy="{y:.1f}" r="3.5" class="clamp"/>' for side in (-1, 1))
