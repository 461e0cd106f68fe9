"""What an integrator gives: the motion of the free coordinates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class Motion:
    """Motion of the free coordinates on equally spaced times."""

    time: FloatArray  # (time,) [s]
    position: FloatArray  # y (time, free) [m]
    velocity: FloatArray  # (time, free) [m/s]
    acceleration: FloatArray  # (time, free) [m/s^2]
    memory: FloatArray  # x (time, state), empty for the convolution
    seconds: float  # wall time [s]
    forces: Mapping[str, FloatArray] = field(default_factory=dict)  # q and v do not tell, each (time, dof) [N]
    works: Mapping[str, FloatArray] = field(default_factory=dict)  # from the start, where forces jump, (time,) [J]


def joined(parts: Sequence[Motion]) -> Motion:
    """Return one motion of several, each begun where the one before ended; works add up."""
    if len(parts) == 1:
        return parts[0]

    def whole(arrays: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate([arrays[0], *(later[1:] for later in arrays[1:])])

    names = ("time", "position", "velocity", "acceleration", "memory")
    works = {}
    for term in parts[0].works:
        before = np.cumsum([0.0, *(part.works[term][-1] for part in parts[:-1])])
        works[term] = whole([done + part.works[term] for done, part in zip(before, parts, strict=True)])
    return Motion(
        **{name: whole([getattr(part, name) for part in parts]) for name in names},
        seconds=sum(part.seconds for part in parts),
        forces={name: whole([part.forces[name] for part in parts]) for name in parts[0].forces},
        works=works,
    )
