"""WAMIT's files of panels: a header, NPAN panels of twelve numbers, and whatever stands behind them."""

from pathlib import Path
from typing import NamedTuple

from vsb.errors import ConfigError

_HEADER = 4  # lines: title, ULEN GRAV, ISX ISY, NPAN
_FEET = (32.0, 32.3)  # GRAV in feet/s^2
_SAME_GRAVITY = 0.01


class Gdf(NamedTuple):
    """What a file of panels holds."""

    panels: str  # header and NPAN panels, as capytaine reads them
    gravity: float  # GRAV, in the length unit of the panels per s^2
    left: int  # lines behind the panels, which nobody reads

    @property
    def note(self) -> str:
        """Return what was left out of the file, in words."""
        return f"{self.left} lines behind the panels of the GDF ignored" if self.left else ""


def read_gdf(path: Path) -> Gdf:
    """Return what a file of panels holds; ValueError where it is none."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    wanted, last = 12 * int(lines[_HEADER - 1].split()[0]), _HEADER
    numbers: list[str] = []
    while len(numbers) < wanted and last < len(lines):
        numbers += lines[last].split()
        last += 1
    if len(numbers) < wanted:
        raise ValueError(f"NPAN is {wanted // 12}, but {len(numbers) // 12} panels follow")
    rows = [" ".join(numbers[k : k + 3]) for k in range(0, wanted, 3)]
    left = sum(bool(line.strip()) for line in lines[last:])
    return Gdf("\n".join([*lines[:_HEADER], *rows]), float(lines[1].split()[1]), left)


def check_gravity(path: Path, gravity: float) -> None:
    """Raise `ConfigError` if GRAV of a GDF says that its lengths are no metres, in water of a gravity [m/s^2]."""
    found = read_gdf(path).gravity
    if abs(found / gravity - 1) <= _SAME_GRAVITY:
        return
    unit = "which is in feet" if _FEET[0] < found < _FEET[1] else "another unit of length or another planet"
    raise ConfigError(
        f"{path}:2: GRAV: received {found:g}, {unit}; needs water.gravity, {gravity:g} m/s^2: convert the mesh, "
        "and its displacements, to metres"
    )
