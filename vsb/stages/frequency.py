"""Radiation memory, frequency response and power at every control level, from its hydro database."""

import json
import time as clock
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import load_database
from vsb.engine.hydro.orders import order_groups
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel, fit_radiation, joined
from vsb.engine.hydro.variables import PAIR
from vsb.engine.motion import frequency as response
from vsb.engine.motion.linear import NO_TAKE_OFF
from vsb.engine.motion.port import LinearPto, Port
from vsb.engine.motion.reduced import reduced_motions
from vsb.engine.motion.take_off import SeveralPorts, port_kind
from vsb.engine.motion.tuning import best_matrix
from vsb.engine.waves.water import power_limit
from vsb.keys.quantities import canonical
from vsb.models.floating_system import FloatingSystem, floating_system, stored_body
from vsb.models.take_off import given_matrix, matrix_kind
from vsb.report.answer import with_extremes
from vsb.results.ladder import as_csv, study_ladder
from vsb.stages.stage import Stamp
from vsb.study.specs import StudyPart
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import save, write_text
from vsb.tools.stamps import record

LONGEST = 60.0
"""Time the kernels of a body are shown for, times the end of its band [rad]."""


def run_radiation(
    tolerance: float, database: str, out: str, stamp: Stamp, added_mass_inf: Literal["fitted", "given"] | None = None
) -> None:
    """Fit and store the passive state-space radiation model, with the kernels of each motion by itself to compare."""
    ds = load_database(database, Path(database).stem)
    spectrum = DampingSpectrum(ds.omega.values, ds.radiation_damping.values)
    begun = clock.perf_counter()
    own: dict[str, Any] = {}
    repaired: dict[str, Any] = {}
    if added_mass_inf:
        fit = stored_body(database).memory(tolerance, limit=added_mass_inf)
        memory = Memory(fit.model, fit.error)
        own, repaired = {"added_mass_inf": (PAIR, fit.added_mass_inf)}, {"history": fit.history}
        repaired |= {"up_to": fit.up_to} if fit.up_to < np.inf else {}
        longest = LONGEST / float(ds.omega[-1])
    else:
        memory = fit_orders(ds, tolerance)
        longest = 40 / float(np.sqrt(float(ds.attrs["gravity"]) / float(ds.attrs["radius"])))
    model = memory.model
    time = np.linspace(0.0, longest, 401)
    labels = ds.influenced_dof.values
    damping = model.damping(ds.omega.values)
    channels = ("state",) if model.channel.ndim == 1 else ("state", "channel_of_order")
    save(
        xr.Dataset(
            {
                "state_matrix": (("state", "state_in"), model.state_matrix),
                "input_matrix": (("state", "radiating_dof"), model.input_matrix),
                "channel": (channels, model.channel),
                "kernel": (("time", "radiating_dof"), spectrum.diagonal.kernel(time)),
                "kernel_state_space": (("time", "radiating_dof"), model.own_kernels(time)),
                "damping_state_space": (("omega", "radiating_dof"), np.einsum("wii->wi", damping)),
                **own,
            },
            coords={"time": time, "omega": ds.omega.values, **dict.fromkeys(PAIR, labels)},
            attrs={
                **stamp,
                "order": model.order,
                "fit_error": memory.error,
                "passivity_margin": least_damping(spectrum, damping),
                "seconds": clock.perf_counter() - begun,
                **repaired,
            },
        ),
        out,
    )


class Memory(NamedTuple):
    """The radiation memory of all azimuthal orders."""

    model: RadiationModel
    error: float  # the largest of their fits [-]


def fit_orders(ds: xr.Dataset, tolerance: float) -> Memory:
    """Return the passive memory of a database, of each azimuthal order one of a single channel; see `fit_radiation`.

    Motions that move no water, as pitch about a sphere's centre, are none of it. Shapes beside a loaded ring move so
    little that their damping is known from excitation alone (Haskind), by which all that radiate like them are passive.
    """
    omega, damping = ds.omega.values, ds.radiation_damping.values.copy()
    if "Ring1" in ds.influenced_dof:
        own = order_groups(ds)[0]
        depth, density, gravity = (float(ds.attrs[name]) for name in ("water_depth", "water_density", "gravity"))
        alike = haskind_damping(ds.isel(dict.fromkeys(PAIR, own)), depth, density, gravity)
        damping[np.ix_(np.arange(len(omega)), own, own)] = alike.real
    models, errors, fits = [], [], {}
    for order, group in order_groups(ds).items():
        wet = group[np.einsum("wii->wi", damping[:, group[:, None], group]).any(axis=0)]
        if order >= 0:
            fits[order] = fit_radiation(DampingSpectrum(omega, damping[:, wet[:, None], wet]), tolerance)
        model, error = fits[abs(order)]  # a sine's is that of its cosine
        inputs = np.zeros((model.order, damping.shape[1]))
        inputs[:, wet] = model.input_matrix
        models.append(RadiationModel(model.state_matrix, inputs, model.channel))
        errors.append(error)
    return Memory(joined(models), max(errors))


def least_damping(spectrum: DampingSpectrum, damping: np.ndarray) -> float:
    """Return the least eigenvalue of a model's damping, (omega, dof, dof), each motion in terms of its largest [-]."""
    scale = np.sqrt(np.einsum("wii->wi", spectrum.damping).max(axis=0))
    scale = np.where(scale > 0, scale, 1.0)  # of what moves no water
    return float(np.linalg.eigvalsh(damping / np.outer(scale, scale)).min())


TAKE_OFF = {True: "best_damping at each frequency", False: "the given damping"}
"""Whether tuning decides -> under what `rao` and `absorbed_power` are."""


PARTS = 5
"""Steps of a response in one of the database."""
BEYOND = 2.0
"""End of the natural frequencies listed of a shell, over the end of the band; a shell may have hundreds above."""


def run_response(
    study: StudyPart,
    omega: list[float],
    directions: list[float],
    database: str,
    out: str,
    stamp: Stamp,
    step: float | None = None,
    lowest: float | None = None,
    omega_max: float | None = None,
) -> None:
    """Write response amplitude operators, ports, powers, their limits, and wet natural frequencies of all designs.

    Best dampers are those beside the take-off's spring. Without a given damper `rao` and `absorbed_power` are at the
    best one of each frequency, natural frequencies and damping ratios without any. Frequencies are dense enough to show
    every resonance, and the largest and least gain over the rigid design in the first direction. Where waves have
    directions, as of a body, all that depends on them has one more dimension.
    """
    floating = floating_system(study, database)
    if step and lowest and omega_max:
        grid = response.frequency_grid(step, lowest, omega_max, omega)
    else:
        grid = refined(floating.linear.database.omega.values, omega)
    grid = with_resonances(study, floating, grid)
    if study.pto.several:
        found = xr.merge([at_several_ports(study, floating, grid), natural(study, floating)])
        save(found.assign_attrs(port_attributes(study), **stamp), out)
        return
    headings = directions or [0.0]
    designs = in_few_motions(floating)
    if study.reference_design and len(study.designs) > 1:
        grid = with_extremes(partial(best_powers, study, designs, headings[0]), grid, study.reference_design)
    seen = [ports_at(designs, grid, at) for at in headings]
    each = [in_waves(study, floating, designs, at, its) for at, its in zip(headings, seen, strict=True)]
    waves = each[0]
    if directions:
        waves = xr.concat(each, dim="wave_direction").assign_coords(wave_direction=np.deg2rad(directions))
    attrs, reached = port_attributes(study), floating.channels
    if reached > 1:
        attrs["limit"] = f"{reached} λ/2π"
    found = xr.merge([waves, at_port(study, seen[0], reached), natural(study, floating)])
    save(found.assign_attrs(attrs, **stamp), out)


def port_attributes(study: Study) -> dict[str, str]:
    """Return what a response says of the take-off."""
    pto = study.pto
    tuned, kind = pto.tuning != "fixed" if pto.several else pto.damping is None, port_kind(pto.port)
    return {"take_off": TAKE_OFF[tuned], "port": canonical(pto.port).strip('"'), "port_kind": kind.load}


def at_several_ports(study: Study, floating: FloatingSystem, omega: FloatArray) -> xr.Dataset:
    """Return the response with a damper matrix: the one given, else the best one of each frequency.

    `port_impedance` has the dimensions (design, omega, port, port_); the ports of a damper spread over the shell are
    the columns of L, its membrane's stiffness L L^T, by number.
    """
    pto, water, equation = study.pto, study.water, floating.linear.equation(omega)
    seen, kind = floating.several_ports(omega), matrix_kind(pto)
    rao, power, best = [], [], []
    for design, ports in seen.items():
        chosen = [best_matrix(ports, alone, kind) for alone in np.eye(len(omega))]
        matrices = np.array([one.damping for one in chosen])
        best.append([one.power for one in chosen])
        given = given_matrix(pto, design, floating.port.shape[1])
        used = matrices if given is None else np.broadcast_to(given, matrices.shape)
        lossy = floating.port @ used @ floating.port.T
        loaded = replace(equation, damping=equation.damping + lossy)
        rao.append(loaded.response(equation.water.excitation, floating.motions[design]))
        stroke = rao[-1] @ floating.port
        power.append(0.5 * omega**2 * np.real(np.einsum("wi,wij,wj->w", stroke.conj(), used, stroke)))
    by = ("design", "omega")
    found = {
        "rao": ((*by, "dof"), np.array(rao)),
        "absorbed_power": (by, np.array(power)),
        "best_power": (by, np.array(best)),
        "matched_power": (by, np.array([ports.matched_power for ports in seen.values()])),
        "power_limit": ("omega", [power_limit(w, water.depth, water.density, water.gravity) for w in omega]),
    }
    coords = {"design": list(seen), "omega": omega, "dof": list(floating.linear.labels)}
    numbers = [str(i) for i in range(floating.port.shape[1])]
    names = list(pto.port.ports) if isinstance(pto.port, SeveralPorts) else numbers
    found["port_impedance"] = ((*by, "port", "port_"), np.array([ports.impedance for ports in seen.values()]))
    found["port_velocity"] = ((*by, "port"), np.array([ports.velocity for ports in seen.values()]))
    coords |= {"port": names, "port_": names}
    return xr.Dataset(found, coords)


def refined(omega: FloatArray, extra: Iterable[float]) -> FloatArray:
    """Return frequencies with others between them, `PARTS` to a step, and further ones [rad/s]."""
    between = [float(w) for ends in pairwise(omega) for w in np.linspace(*ends, PARTS, endpoint=False)]
    return response.with_others(np.array([*extra]), [*between, float(omega[-1])])


def with_resonances(study: Study, floating: FloatingSystem, omega: FloatArray) -> FloatArray:
    """Return frequencies with those of the natural motions without a damper, and beside them at half their power."""
    pto = NO_TAKE_OFF if study.pto.several else LinearPto(0.0, study.pto.stiffness, floating.port)
    highest = natural_to(floating)
    modes = [replace(floating.linear, pto=pto).natural_modes(each, highest) for each in floating.motions.values()]
    near = [natural * (1 + ratio * side) for natural, ratio in modes for side in (-1, 0, 1)]
    found = np.concatenate([omega[:0], *near])
    return response.with_others(omega, found[(found > omega[0]) & (found < omega[-1])])


def natural_to(floating: FloatingSystem) -> float:
    """Return the frequency up to which natural motions are listed [rad/s]: of a shell `BEYOND` the end of the band."""
    return BEYOND * floating.band[1] if floating.shape else np.inf


class DesignMotion(NamedTuple):
    """One design, in all motions it has or in the few that it takes in waves and under its take-off."""

    system: FloatingSystem  # of this design alone
    shapes: FloatArray | None  # displacements of all degrees of freedom in its motions (dof, motion)


def in_few_motions(floating: FloatingSystem) -> dict[str, DesignMotion]:
    """Return all designs, each in what it moves in; of many shell modes in few motions, see `motion.reduced`."""
    found, linear = {}, floating.linear
    for design, motions in floating.motions.items():
        own, port, shapes = linear, floating.port, None
        if floating.shape and not linear.orders.any():
            shapes = reduced_motions(linear, motions, port).motions
            own, port, motions = linear.in_motions(shapes), response.allowed_part(port, shapes), np.eye(shapes.shape[1])
        found[design] = DesignMotion(replace(floating, linear=own, motions={design: motions}, port=port), shapes)
    return found


def ports_at(designs: Mapping[str, DesignMotion], omega: FloatArray, direction: float) -> dict[str, Port]:
    """Return what the take-off sees of all designs in waves of one direction [degrees]."""
    return {name: port for one in designs.values() for name, port in one.system.ports(omega, direction).items()}


def best_powers(study: Study, designs: Mapping[str, DesignMotion], direction: float, omega: FloatArray) -> xr.DataArray:
    """Return the power of all designs at the best damper of each frequency, dims (design, omega) [W/m^2]."""
    best = [port.best_power for port in beside_spring(study, ports_at(designs, omega, direction)).values()]
    return xr.DataArray(best, {"design": list(study.designs), "omega": omega}, ("design", "omega"))


def beside_spring(study: Study, seen: Mapping[str, Port]) -> dict[str, Port]:
    """Return what a damper beside the take-off's spring sees of all designs."""
    spring = study.pto.stiffness
    return {design: port.beside(spring) if spring else port for design, port in seen.items()}


def in_waves(
    study: Study,
    floating: FloatingSystem,
    designs: Mapping[str, DesignMotion],
    direction: float,
    seen: Mapping[str, Port],
) -> xr.Dataset:
    """Return what all designs do in waves of one direction, by their ports."""
    pto, rao, power, best = study.pto, [], [], beside_spring(study, seen)
    omega = next(iter(seen.values())).omega
    for design, (system, shapes) in designs.items():
        damper = pto.damper(design)
        damping = best[design].best_damping if damper is None else damper
        moving = replace(system.towards(direction), pto=LinearPto(damping, pto.stiffness, system.port))
        moved = moving.rao(omega, system.motions[design])
        power.append(moving.absorbed_power(omega, moved))
        rao.append(moved if shapes is None else moved @ shapes.T)
    labels = list(floating.linear.labels)
    return xr.Dataset(
        {
            "rao": (("design", "omega", "dof"), np.array(rao)),
            "absorbed_power": (("design", "omega"), np.array(power)),
            "port_velocity": (("design", "omega"), np.array([port.velocity for port in seen.values()])),
            "best_power": (("design", "omega"), np.array([port.best_power for port in best.values()])),
            "matched_power": (("design", "omega"), np.array([port.matched_power for port in seen.values()])),
        },
        coords={"design": list(study.designs), "omega": omega, "dof": labels},
    )


def at_port(study: Study, seen: Mapping[str, Port], reached: int) -> xr.Dataset:
    """Return what does not depend on where waves come from: impedances, best dampers, the limit of heave alone."""
    water, best, omega = study.water, beside_spring(study, seen), next(iter(seen.values())).omega
    limit = [reached * power_limit(w, water.depth, water.density, water.gravity) for w in omega]
    return xr.Dataset(
        {
            "port_impedance": (("design", "omega"), np.array([port.impedance for port in seen.values()])),
            "best_damping": (("design", "omega"), np.array([port.best_damping for port in best.values()])),
            "power_limit": ("omega", limit),
        },
        coords={"design": list(study.designs), "omega": omega},
    )


def natural(study: Study, floating: FloatingSystem) -> xr.Dataset:
    """Return wet natural frequencies and damping ratios of all designs; an unrestrained motion has none.

    Of a shell those to `natural_to`, and the first above.
    """
    wet: list[tuple[str, float, float]] = []
    for design in study.designs:
        pto = LinearPto(study.pto.damper(design) or 0.0, study.pto.stiffness, floating.port)
        if study.pto.several:
            given = given_matrix(study.pto, design, floating.port.shape[1])
            pto = NO_TAKE_OFF if given is None else LinearPto(given, port=floating.port)
        modes = replace(floating.linear, pto=pto).natural_modes(floating.motions[design], natural_to(floating))
        wet += [(design, float(frequency), float(ratio)) for frequency, ratio in zip(*modes, strict=True)]
    return xr.Dataset(
        {
            "wet_natural_frequency": ("wet_mode", [frequency for _, frequency, _ in wet]),
            "wet_damping_ratio": ("wet_mode", [ratio for *_, ratio in wet]),
        },
        coords={"wet_design": ("wet_mode", [design for design, *_ in wet])},
    )


def run_ladder(study: StudyPart, database: str, out: str, levels: str, manifest: str, stamp: Stamp) -> None:
    """Write the ladder of a study for people, and all its digits, with notes, for the stages after it."""
    found = study_ladder(study, database)
    write_text(out, as_csv(found))
    write_text(levels, json.dumps([level._asdict() for level in found], indent=1, allow_nan=False) + "\n")
    record(manifest, stamp["spec_id"], [out, levels])
