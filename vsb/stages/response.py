"""Rule response: the frequency response of all designs."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import xarray as xr

from vsb.motion import frequency as response
from vsb.motion.frequency import LinearBuoy, LinearMotion
from vsb.motion.port import LinearPto, Port, channels_reached
from vsb.report.band import with_extremes
from vsb.scenes.floating_system import FloatingSystem, floating_system, towards
from vsb.stages.stage import stamp
from vsb.study.specs import BodyResponseSpec, ResponseSpec
from vsb.study.study import canonical
from vsb.study.take_off import port_kind
from vsb.tools.arrays import FloatArray
from vsb.tools.files import save
from vsb.waves.dispersion import power_limit

TAKE_OFF = {True: "best_damping at each frequency", False: "the given damping"}
"""Whether tuning decides -> under what `rao` and `absorbed_power` are."""


AnySpec = ResponseSpec | BodyResponseSpec
PARTS = 5
"""Steps of a response in one of the database."""


def run(spec: ResponseSpec | BodyResponseSpec, database: str, out: str) -> None:
    """Write response amplitude operators, ports, powers, their limits, and wet natural frequencies of all designs.

    Best dampers are those beside the take-off's spring. Without a given damper `rao` and `absorbed_power` are at the
    best one of each frequency, natural frequencies and damping ratios without any. Frequencies are dense enough to show
    every resonance, and the largest and least gain over the rigid design in the first direction. Where waves have
    directions, as of a body, all that depends on them has one more dimension.
    """
    floating = floating_system(spec, database)
    if isinstance(spec, BodyResponseSpec):
        omega = refined(floating.linear.database.omega.values, spec.omega)
    else:
        omega = response.frequency_grid(spec.step, spec.lowest, spec.omega_max, spec.omega)
    omega = with_resonances(spec, floating, omega)
    moving = [towards(floating.linear, at) for at in spec.directions or (0.0,)]
    if spec.reference_design and len(spec.designs) > 1:
        omega = with_extremes(partial(best_powers, spec, floating, moving[0]), omega, spec.reference_design)
    seen = [ports(floating, one, omega) for one in moving]
    headings = [in_waves(spec, floating, one, its) for one, its in zip(moving, seen, strict=True)]
    waves = headings[0]
    if spec.directions:
        waves = xr.concat(headings, dim="wave_direction").assign_coords(wave_direction=np.deg2rad(spec.directions))
    told = {"take_off": TAKE_OFF[spec.pto.damping is None], "port": canonical(spec.pto.port).strip('"')}
    told["port_kind"] = port_kind(spec.pto.port).load
    reached = channels_reached(floating.port, floating.linear.orders) if isinstance(floating.linear, LinearBuoy) else 1
    if reached > 1:
        told["limit"] = f"{reached} λ/2π"
    found = xr.merge([waves, at_port(spec, seen[0], reached), natural(spec, floating)])
    save(found.assign_attrs(told, **stamp(spec, database)), out)


def refined(omega: FloatArray, extra: Iterable[float]) -> FloatArray:
    """Return frequencies with others between them, `PARTS` to a step, and further ones [rad/s]."""
    between = [float(w) for ends in pairwise(omega) for w in np.linspace(*ends, PARTS, endpoint=False)]
    return np.array(sorted({*between, float(omega[-1]), *extra}))


def with_resonances(spec: AnySpec, floating: FloatingSystem, omega: FloatArray) -> FloatArray:
    """Return frequencies with those of the natural motions without a damper, and beside them at half their power."""
    pto = LinearPto(0.0, spec.pto.stiffness, floating.port)
    modes = [replace(floating.linear, pto=pto).natural_modes(motions) for motions in floating.motions.values()]
    near = [natural * (1 + ratio * side) for natural, ratio in modes for side in (-1, 0, 1)]
    every = np.concatenate([omega, *near])
    return np.unique(every[(every >= omega[0]) & (every <= omega[-1])])


def best_powers(spec: AnySpec, floating: FloatingSystem, linear: LinearMotion, omega: FloatArray) -> xr.DataArray:
    """Return the power of all designs at the best damper of each frequency, dims (design, omega) [W/m^2]."""
    best = [port.best_power for port in beside_spring(spec, ports(floating, linear, omega)).values()]
    return xr.DataArray(best, {"design": list(spec.designs), "omega": omega}, ("design", "omega"))


def ports(floating: FloatingSystem, linear: LinearMotion, omega: FloatArray) -> dict[str, Port]:
    """Return what the take-off sees of all designs in waves of one direction."""
    return {design: linear.port(omega, motions, floating.port) for design, motions in floating.motions.items()}


def beside_spring(spec: AnySpec, seen: Mapping[str, Port]) -> dict[str, Port]:
    """Return what a damper beside the take-off's spring sees of all designs."""
    spring = spec.pto.stiffness
    return {design: port.beside(spring) if spring else port for design, port in seen.items()}


def in_waves(spec: AnySpec, floating: FloatingSystem, linear: LinearMotion, seen: Mapping[str, Port]) -> xr.Dataset:
    """Return what all designs do in waves of one direction, by their ports."""
    pto, rao, power, best = spec.pto, [], [], beside_spring(spec, seen)
    omega = next(iter(seen.values())).omega
    for design, motions in floating.motions.items():
        damper = pto.damper(design)
        damping = best[design].best_damping if damper is None else damper
        moving = replace(linear, pto=LinearPto(damping, pto.stiffness, floating.port))
        rao.append(moving.rao(omega, motions))
        power.append(moving.absorbed_power(omega, rao[-1]))
    labels = list(map(str, linear.database.influenced_dof.values))
    return xr.Dataset(
        {
            "rao": (("design", "omega", "dof"), np.array(rao)),
            "absorbed_power": (("design", "omega"), np.array(power)),
            "port_velocity": (("design", "omega"), np.array([port.velocity for port in seen.values()])),
            "best_power": (("design", "omega"), np.array([port.best_power for port in best.values()])),
            "matched_power": (("design", "omega"), np.array([port.matched_power for port in seen.values()])),
        },
        coords={"design": list(spec.designs), "omega": omega, "dof": labels},
    )


def at_port(spec: AnySpec, seen: Mapping[str, Port], reached: int) -> xr.Dataset:
    """Return what does not depend on where waves come from: impedances, best dampers, the limit of heave alone."""
    water, best, omega = spec.water, beside_spring(spec, seen), next(iter(seen.values())).omega
    limit = [reached * power_limit(w, water.depth, water.density, water.gravity) for w in omega]
    return xr.Dataset(
        {
            "port_impedance": (("design", "omega"), np.array([port.impedance for port in seen.values()])),
            "best_damping": (("design", "omega"), np.array([port.best_damping for port in best.values()])),
            "power_limit": ("omega", limit),
        },
        coords={"design": list(spec.designs), "omega": omega},
    )


def natural(spec: AnySpec, floating: FloatingSystem) -> xr.Dataset:
    """Return wet natural frequencies and damping ratios of all designs; what drifts has none."""
    wet: list[tuple[str, float, float]] = []
    for design in spec.designs:
        pto = LinearPto(spec.pto.damper(design) or 0.0, spec.pto.stiffness, floating.port)
        modes = replace(floating.linear, pto=pto).natural_modes(floating.motions[design])
        wet += [(design, float(frequency), float(ratio)) for frequency, ratio in zip(*modes, strict=True)]
    return xr.Dataset(
        {
            "wet_natural_frequency": ("wet_mode", [frequency for _, frequency, _ in wet]),
            "wet_damping_ratio": ("wet_mode", [ratio for *_, ratio in wet]),
        },
        coords={"wet_design": ("wet_mode", [design for design, *_ in wet])},
    )
