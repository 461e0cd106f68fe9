"""What it costs to solve a body on panels, as far as a body file and the sizes of its files tell: resources of a job.

The matrices of a frequency grow with the square of the number of panels. That number is known of plain hulls and of
GDF files, and bounded by the size of other mesh files. Nothing is read but a header: Snakemake asks at every parse.
"""

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.plain_hulls import BoxHull, CapsuleHull, CylinderHull, SphereHull

GIGABYTES, SECONDS = 6.3e-8, 6.5e-7
"""Of a frequency on one core, per squared number of panels; measured with 3200 panels."""
_IN_FINITE_DEPTH = 5.0  # times as long at most
_FURTHER = 4.0  # times as long as the frequencies on a quick core: fewer panels for the error, lids, slower cores
_LEAST_MEGABYTES, _LEAST_MINUTES = 1500, 30
_UNKNOWN = 8000  # panels
_MOST = 60_000  # panels; beyond, `hydro.bodies.study` refuses the body or its symmetry decides
_HEADER = 4  # lines of a GDF: title, ULEN GRAV, ISX ISY, NPAN
_BYTES = {".stl": 50, ".nc": 56}
"""Of a panel at least: a binary STL has 50 of a triangle, netCDF four corners and one vertex."""
_TEXT_BYTES = 40  # a vertex and four numbers in text
_OF_DISPLACEMENTS = 6 * 24  # bytes of a vertex in netCDF that holds six displacements at least


class Resources(NamedTuple):
    """What a job asks a cluster for."""

    megabytes: int
    minutes: int


def hull_panel_count(hull: SphereHull | CylinderHull | CapsuleHull | BoxHull) -> float:
    """Return about how many panels the wetted part of a plain hull has; rows have as many all along a meridian."""
    depth = hull.draft
    if isinstance(hull, BoxHull):
        area = hull.length * hull.width + 2 * (hull.length + hull.width) * depth
        return 1.3 * area / hull.panel**2 + 16
    r = hull.radius
    if isinstance(hull, CylinderHull):
        meridian = r + depth
    else:  # a capsule's lower end is a sphere's
        sphere = depth if isinstance(hull, SphereHull) else min(depth, r)
        meridian = r * math.acos(1 - min(sphere / r, 2.0)) + depth - sphere
    return 1.2 * 2 * math.pi * r * meridian / hull.panel**2 + 16


def panel_count(file: BodyFile, paths: Mapping[str, str]) -> float:
    """Return about how many panels a body has at most; `paths` are those of its files, by key."""
    if file.hull:
        return hull_panel_count(file.hull)
    path = paths.get("mesh", "")
    if not os.path.isfile(path):
        return _UNKNOWN
    suffix = Path(path).suffix.lower()
    if suffix == ".gdf" and (found := _of_gdf(path)):
        return found
    each, size = _BYTES.get(suffix, _TEXT_BYTES), os.path.getsize(path)
    if suffix == ".nc" and file.rigid_motions is None and paths.get("modes") == path:
        each += _OF_DISPLACEMENTS
    return size / each


def _of_gdf(path: str) -> int | None:
    """Panels of a GDF with its mirrored parts; none if its header is not that."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            lines = [stream.readline(1000) for _ in range(_HEADER)]
        isx, isy = (int(word) for word in lines[2].split()[:2])
        mirrored = (isx == 1) + (isy == 1)
        return int(lines[3].split()[0]) << mirrored
    except (OSError, ValueError, IndexError):
        return None


def solve_resources(file: BodyFile, paths: Mapping[str, str]) -> Resources:
    """Return the memory and the time a job that solves a body asks for, frequencies one after the other."""
    squared = min(panel_count(file, paths), _MOST) ** 2
    slower = _FURTHER * (1.0 if math.isinf(file.water.depth) else _IN_FINITE_DEPTH)
    minutes = slower * SECONDS * squared * (len(file.omega) + 1) / 60
    return Resources(_LEAST_MEGABYTES + math.ceil(1e3 * GIGABYTES * squared), _LEAST_MINUTES + math.ceil(minutes))
