"""Rule response: the frequency response of all designs."""

from dataclasses import replace

import numpy as np
import xarray as xr

from vsb.motion import frequency as response
from vsb.motion.port import channels_reached
from vsb.motion.pto import LinearPto
from vsb.scenes.build import linear_buoy, study_port
from vsb.scenes.rest import design_motions
from vsb.stages.stage import stamp
from vsb.study.specs import ResponseSpec
from vsb.study.study import canonical
from vsb.study.take_off import Pto
from vsb.tools.files import save
from vsb.waves.seas import power_limit

TAKE_OFF = {True: "best_damping at each frequency", False: "the given damping"}
"""Whether tuning decides -> under what `rao` and `absorbed_power` are."""


def port_in_words(pto: Pto) -> str:
    """Return what the take-off acts on; of the volume, whose impedance is no mechanical one, with its units."""
    units = ": pressure against volume flow, impedance in Pa s/m^3, velocity in m^2/s" if pto.port == "volume" else ""
    return canonical(pto.port).strip('"') + units


def run(spec: ResponseSpec, database: str, out: str) -> None:
    """Write response amplitude operators, ports, powers, their limits, and wet natural frequencies of all designs.

    Best dampers are those beside the take-off's spring. Without a given damper `rao` and `absorbed_power` are at the
    best one of each frequency, natural frequencies and damping ratios without any.
    """
    bare, basis = linear_buoy(spec, database)
    omega = response.frequency_grid(spec.step, spec.lowest, spec.omega_max, spec.omega)
    pto = spec.pto
    direction = study_port(spec, bare, basis)
    reached = channels_reached(direction, bare.orders)
    rao, power, wet, ports, best = [], [], [], [], []
    for design in spec.designs:
        motions, damper = design_motions(spec, basis, design), pto.damper(design)
        ports.append(bare.port(omega, motions, direction))
        best.append(ports[-1].beside(pto.stiffness) if pto.stiffness else ports[-1])
        damping = best[-1].best_damping if damper is None else damper
        buoy = replace(bare, pto=LinearPto(damping, pto.stiffness, direction))
        rao.append(buoy.rao(omega, motions))
        power.append(buoy.absorbed_power(omega, rao[-1]))
        swinging = replace(buoy, pto=LinearPto(damper or 0.0, pto.stiffness, direction))
        wet += [(design, *pair) for pair in zip(*swinging.natural_modes(motions), strict=True)]
    water, told = spec.water, {"take_off": TAKE_OFF[pto.damping is None], "port": port_in_words(pto)}
    sea = (water.depth, water.density, water.gravity)
    if reached > 1:
        told["limit"] = f"{reached} λ/2π"
    designs, frequency, ratio = zip(*wet, strict=True)
    save(
        xr.Dataset(
            {
                "rao": (("design", "omega", "dof"), np.array(rao)),
                "absorbed_power": (("design", "omega"), np.array(power)),
                "port_impedance": (("design", "omega"), np.array([port.impedance for port in ports])),
                "port_velocity": (("design", "omega"), np.array([port.velocity for port in ports])),
                "best_damping": (("design", "omega"), np.array([port.best_damping for port in best])),
                "best_power": (("design", "omega"), np.array([port.best_power for port in best])),
                "matched_power": (("design", "omega"), np.array([port.matched_power for port in ports])),
                "power_limit": ("omega", reached * np.array([power_limit(w, *sea) for w in omega])),
                "wet_natural_frequency": ("wet_mode", list(frequency)),
                "wet_damping_ratio": ("wet_mode", list(ratio)),
            },
            coords={
                "design": list(spec.designs),
                "omega": omega,
                "dof": list(bare.labels),
                "wet_design": ("wet_mode", list(designs)),
            },
            attrs={**told, **stamp(spec, database)},
        ),
        out,
    )
