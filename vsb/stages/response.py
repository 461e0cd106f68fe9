"""Rule response: the frequency response of all designs."""

import numpy as np
import xarray as xr

from vsb.motion import frequency as response
from vsb.motion.port import port_direction
from vsb.scenes.build import linear_buoy
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import design_motions
from vsb.stages.stage import partial_study, stamp
from vsb.study.specs import ResponseSpec
from vsb.tools.files import save
from vsb.waves.seas import power_limit


def run(spec: ResponseSpec, database: str, out: str) -> None:
    """Write response amplitude operators, ports, powers, their limits, and wet natural frequencies of all designs."""
    study = partial_study(spec)
    buoy, basis = linear_buoy(study, database)
    omega = response.frequency_grid(spec.step, spec.lowest, spec.omega_max, spec.omega)
    heave = port_direction("heave", DeformedShell(basis, study.centre_height))
    rao, power, wet, ports = [], [], [], []
    for design in study.designs:
        motions = design_motions(study, basis, design)
        ports.append(buoy.port(omega, motions, heave))
        rao.append(buoy.rao(omega, motions))
        power.append(buoy.absorbed_power(omega, rao[-1]))
        wet += [(design, *pair) for pair in zip(*buoy.natural_modes(motions), strict=True)]
    water = study.water
    designs, frequency, ratio = zip(*wet, strict=True)
    save(
        xr.Dataset(
            {
                "rao": (("design", "omega", "dof"), np.array(rao)),
                "absorbed_power": (("design", "omega"), np.array(power)),
                "port_impedance": (("design", "omega"), np.array([port.impedance for port in ports])),
                "port_velocity": (("design", "omega"), np.array([port.velocity for port in ports])),
                "best_damping": (("design", "omega"), np.array([port.best_damping for port in ports])),
                "best_power": (("design", "omega"), np.array([port.best_power for port in ports])),
                "matched_power": (("design", "omega"), np.array([port.matched_power for port in ports])),
                "power_limit": ("omega", [power_limit(w, water.depth, water.density, water.gravity) for w in omega]),
                "wet_natural_frequency": ("wet_mode", list(frequency)),
                "wet_damping_ratio": ("wet_mode", list(ratio)),
            },
            coords={
                "design": list(study.designs),
                "omega": omega,
                "dof": list(basis.labels),
                "wet_design": ("wet_mode", list(designs)),
            },
            attrs=stamp(spec, database),
        ),
        out,
    )
