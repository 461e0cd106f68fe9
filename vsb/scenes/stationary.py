"""Ports in stationary seas at equally spaced frequencies from next to zero to beyond the band, for causal control."""

import numpy as np

from vsb.motion.causal import StationaryPort
from vsb.scenes.floating_system import FloatingSystem, Heading, heading_in
from vsb.study.waves import Wave
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.seas import PARTS, Sea

BEYOND = 4.0
"""End of the frequencies of a controller, over that of the band: its force may change within a time step."""
POINTS = 64
"""Frequencies beyond the band at which the port is computed; between them it is interpolated."""


def stationary_port(floating: FloatingSystem, design: str, wave: Wave, sea: Sea) -> StationaryPort:
    """Return the port of a design in a sea whose components carry its spectrum.

    Parameters
    ----------
    wave : Wave
        Of a spectrum.
    sea : Sea
        See `vsb.scenes.floating_system.expected_sea`: components at the centres of equal bands that begin at zero.

    Notes
    -----
    Outside the band the port has the coefficients of its nearest end. The directions of a spread sea take turns along
    its components: the density of the free velocity is averaged over a round of them.
    """
    spacing = float(np.diff(sea.omega).min())
    at = np.rint(sea.omega / spacing - 0.5).astype(int)
    count = int(np.ceil(max(floating.band[1] / spacing, at.max() + 1)))
    omega = (np.arange(count) + 0.5) * spacing
    port = floating.extended_port(design, omega)
    free = floating.towards(heading_in(wave, sea)).port(sea.omega, floating.motions[design], floating.port).velocity
    spectrum = np.zeros(count)
    spectrum[at] = np.abs(free * sea.amplitude) ** 2 / (2 * spacing)
    if sea.heading is not None:
        spectrum = np.convolve(spectrum, np.full(PARTS, 1 / PARTS), mode="same")
    beyond = (np.arange(count, int(BEYOND * count)) + 0.5) * spacing
    admittance = np.append(port.admittance, _continued(floating, design, 0.0, beyond))
    passive = np.maximum(admittance.real, 0.0) + 1j * admittance.imag
    return StationaryPort(spacing, passive, np.append(spectrum, np.zeros(len(beyond))))


def _continued(floating: FloatingSystem, design: str, direction: Heading, omega: FloatArray) -> ComplexArray:
    """Admittance beyond the band, from that at some frequencies."""
    some = np.geomspace(omega[0], omega[-1], POINTS)
    known = floating.extended_port(design, some, direction).admittance
    return np.asarray(np.interp(np.log(omega), np.log(some), known))
