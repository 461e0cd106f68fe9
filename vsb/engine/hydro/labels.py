"""Labels of degrees of freedom: rigid motions, of one of several bodies, modes of rings."""

from collections.abc import Iterable

RIGID = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
"""Labels of the six rigid motions, in everybody's order; of several bodies named with the body first: float__Heave."""


ROTATIONS = RIGID[3:]


def motion_of(label: str) -> str:
    """Return the motion a degree of freedom is, whichever body's: Heave of float__Heave."""
    return label.rpartition("__")[2]


def body_of(label: str) -> str:
    """Return the body a degree of freedom is of: float of float__Heave; the only one has no name."""
    return label.rpartition("__")[0]


def is_rigid(label: str) -> bool:
    """Return whether a degree of freedom is a rigid motion, of one of several bodies or of the only one."""
    return motion_of(label) in RIGID


def is_of_ring(label: str) -> bool:
    """Return whether a degree of freedom is a mode of rings: too short to be seen in the shape of the shell."""
    return label.startswith("Ring")


def of_bodies(labels: Iterable[str]) -> dict[str, list[int]]:
    """Return the places of each body's degrees of freedom, by its name; the only body has none."""
    places: dict[str, list[int]] = {}
    for place, label in enumerate(labels):
        places.setdefault(body_of(label), []).append(place)
    return places
