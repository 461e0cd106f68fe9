"""What an integrator gives: the motion of the free coordinates."""

from dataclasses import dataclass

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
