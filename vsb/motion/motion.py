"""What an integrator gives: the motion of the free coordinates."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from vsb.tools.units import FloatArray


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
