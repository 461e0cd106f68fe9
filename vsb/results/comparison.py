"""Figures of merit of runs, what linear theory expects of them, and the table that compares designs."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.variables import ROTATIONS, motion_of
from vsb.engine.motion.linear import direction_index
from vsb.engine.motion.port import Ports
from vsb.engine.motion.take_off import SeveralPorts
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import Water, group_velocity
from vsb.errors import ConfigError
from vsb.models.build import TUNED, TUNED_MATRIX
from vsb.models.take_off import LINEARISED, given_matrix
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import kind_of
from vsb.tools.words import csv_text

NO_POWER = 1e-9
"""Mean power that counts as none [W]."""
ROUND_OFF = 1e-9
"""Energy or power below this part of the best design's is round-off of a buoy at rest: no gain is stated over it."""

Row = dict[str, Any]
"""A row of the comparison table by column."""
Runs = Mapping[str, xr.Dataset]
"""Trajectories in one sea by design."""
Attributes = Mapping[tuple[str, str], Mapping[str, Any]]
"""Attributes of runs by design and label of the sea."""


class Merit(NamedTuple):
    """Figures of merit of one design in one sea."""

    displacement_pp: float  # heave of a buoy, stroke of a body's port: highest to lowest in the window [m]
    velocity_pp: float  # its velocity, likewise [m/s]
    power_peak: float  # largest absorbed power in the window [W]
    power_mean: float  # over whole wave periods at the end of the window; of the sea by `vsb.results.mean_power` [W]
    energy: float  # absorbed over the whole run [J]
    capture_width: float | None  # mean power over the energy flux of the sea [m]; None in still water


TAKE_OFF = ("damping", "stiffness", "power_gain_percent")
INTERVAL = ("low", "high")
"""Of the gain of mean power, by all known sources of error [%]."""
POWER_INTERVAL = ("power_low", "power_high")
"""Of mean power, likewise [W]."""
OF_RECORD = ("record_power_mean", "record_power_low", "record_power_high", "record_start", "record_end")
"""Mean power of the simulated record [W], the 95 % interval of the sea's by this record alone, and the times it is
taken over [s]."""
COLUMNS = (
    "design", "wave", *Merit._fields, "energy_gain_percent", "energy_residual", *TAKE_OFF, *INTERVAL, *POWER_INTERVAL,
    *OF_RECORD,
)  # fmt: skip


def energy_flux(sea: Sea, water: Water) -> float:
    """Return the energy flux of a sea per metre of crest, sum rho g |a|^2 v_g/2 [W/m]."""
    speed = np.array([group_velocity(w, water.depth, water.gravity) for w in sea.omega])
    return float(0.5 * water.density * water.gravity * np.sum(np.abs(sea.amplitude) ** 2 * speed))


def averaging_window(wave: Wave, window: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the window means are taken over [s]: as many whole periods as fit, at its end (C8)."""
    start, end = window
    if not wave.regular or end - start < wave.period:
        return start, end
    return end - np.floor((end - start) / wave.period + 1e-9) * wave.period, end


def merit(run: xr.Dataset, wave: Wave, sea: Sea, water: Water, window: tuple[float, float]) -> Merit:
    """Return the figures of merit of a run (see `vsb.engine.integrators.simulate.recorded`)."""
    time = run.time.values
    inside = (time >= window[0] - 1e-9) & (time <= window[1] + 1e-9)
    if not inside.any():
        raise ConfigError(
            f"simulation.window: received {list(window)} s, which holds none of the instants recorded, "
            f"{time[1] - time[0]:.4g} s apart; needs to be longer than that"
        )
    if "stroke" in run:
        displacement, rate = run.stroke.values, run.stroke_rate.values
    else:
        displacement, rate = run.position.values[:, 0], run.velocity.values[:, 0]
    absorbed: FloatArray = run.energy.sel(term="pto").values
    start, end = averaging_window(wave, window)
    mean = float(np.diff(CubicSpline(time, absorbed)([start, end]))[0] / (end - start))
    flux = energy_flux(sea, water)
    return Merit(
        float(np.ptp(displacement[inside])),
        float(np.ptp(rate[inside])),
        float(run.power_absorbed.values[inside].max()) + 0.0,  # no negative zero
        mean,
        float(absorbed[-1]) + 0.0,
        mean / flux if flux else None,
    )


def comparison(study: Study, wave: Wave, runs: Runs, sea: Sea) -> list[Row]:
    """Return one row per design in a sea; gains of energy and of mean power are over the first rigid design's.

    Energy is that of the whole run, start-up included; in still water there is no gain of mean power. Mean powers are
    those of the records: of the seas they are, with all intervals, left to `vsb.results.mean_power`.

    Parameters
    ----------
    sea : Sea
        Its energy flux is what capture widths are measured by.
    """
    window = study.simulation.window
    record = averaging_window(wave, window)
    merits = {design: merit(runs[design], wave, sea, study.water, window) for design in study.designs}
    energy = gains({d: m.energy for d, m in merits.items()}, study.reference_design)
    power = gains({d: m.power_mean for d, m in merits.items()}, study.reference_design)
    rows: list[Row] = []
    for design, values in merits.items():
        row = {"design": design, "wave": wave.label, **values._asdict(), "energy_gain_percent": energy[design]}
        row["energy_residual"] = float(runs[design].attrs["energy_residual"])
        gain = None if wave.still else power[design]
        damper = damper_of(study, design, runs[design].attrs) if study.pto.law_has_damping else None
        take_off = (damper, study.pto.stiffness, gain)
        row |= dict(zip(TAKE_OFF, take_off, strict=True)) | dict.fromkeys((*INTERVAL, *POWER_INTERVAL, *OF_RECORD))
        rows.append({**row, "record_power_mean": values.power_mean, "record_start": record[0], "record_end": record[1]})
    return rows


def gains(values: Mapping[str, float], reference: str | None) -> dict[str, float | None]:
    """Return the gain of each design over the reference [%]; None without a reference or over round-off."""
    base = values[reference] if reference else None
    if base is None or base <= ROUND_OFF * max(values.values()):
        return dict.fromkeys(values)
    return {design: 100 * (value / base - 1) for design, value in values.items()}


def as_csv(rows: Sequence[Row]) -> str:
    """Return the comparison as CSV; an empty cell is a quantity that does not exist, such as a gain over no power."""
    return csv_text(COLUMNS, ([row[name] for name in COLUMNS] for row in rows))


# what linear theory expects of a run --------------------------------------------------------------------------------


def relative_difference(mean: float, expected: float) -> float:
    """Return |mean/expected - 1| of mean powers [-]; where `NO_POWER` is expected, |mean| [W].

    Two powers of round-off, as of bodies held together or of waves that reach both alike, do not contradict each other.
    """
    return abs(mean / expected - 1) if abs(expected) > NO_POWER else abs(mean)


def damper_of(study: Study, design: str, run: Mapping[str, Any]) -> float | None:
    """Return the damper of a design in a run, by its attributes: given or tuned [N s/m]; None of a damper matrix."""
    if isinstance(study.pto.port, SeveralPorts):
        return None
    return float(run.get(TUNED, study.pto.damper(design) or 0.0))


def damper_matrix_of(study: Study, design: str, run: Mapping[str, Any], count: int) -> FloatArray:
    """Return the damper matrix of a design in a run at several ports, shape (port, port)."""
    if TUNED_MATRIX in run:
        return np.reshape(run[TUNED_MATRIX], (count, count))
    if TUNED in run:
        return float(run[TUNED]) * np.eye(count)
    given = given_matrix(study.pto, design, count)
    return np.zeros((count, count)) if given is None else given


def in_direction(response: xr.Dataset, wave: Wave) -> xr.Dataset:
    """Return the frequency response in the direction of a sea; a buoy has one for all, in still water any will do.

    Raises `ConfigError` if the response is of other directions.
    """
    if "wave_direction" not in response.dims:
        return response
    if wave.still:
        return response.isel(wave_direction=0)
    place = direction_index(response.wave_direction.values, float(np.deg2rad(wave.direction)))
    if place is None:
        known = ", ".join(f"{each:g}" for each in np.degrees(response.wave_direction.values))
        raise ConfigError(f"wave_direction: received {wave.direction:g} degrees, needs one of {known}")
    return response.isel(wave_direction=place)


def power_waves(study: Study, response: xr.Dataset, design: str, run: Mapping[str, Any]) -> xr.DataArray:
    """Return u per wave amplitude, |u|^2/2 the power the take-off absorbs, dims (omega, load) [W^0.5/m].

    u = sqrt(c) V of a damper c, V = V0 Z/(Z + c + ik/omega), Z and V0 of the port; 0 where the port cannot move. At
    several ports u = S V with the damper matrix S^T S and V = (1 + Y C)^-1 V0.
    """
    here = response.sel(design=design)
    if study.pto.several:
        velocity, impedance = here.port_velocity.transpose("omega", "port").values, here.port_impedance.values
        matrix = damper_matrix_of(study, design, run, velocity.shape[1])
        seen = Ports(here.omega.values, np.linalg.pinv(impedance, rcond=1e-13), velocity)
        values, vectors = np.linalg.eigh(matrix)
        root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        return xr.DataArray(seen.velocity_under(matrix) @ root.T, {"omega": here.omega}, ("omega", "load"))
    damper = damper_of(study, design, run) or 0.0
    total = here.port_impedance + damper + 1j * study.pto.stiffness / here.omega
    found: xr.DataArray = here.port_velocity * here.port_impedance / total.where(here.port_impedance != 0, 1.0)
    scaled: xr.DataArray = (np.sqrt(damper) * found).expand_dims("load", axis=-1)
    return scaled


def power_response(study: Study, response: xr.Dataset, design: str, run: Mapping[str, Any]) -> xr.DataArray:
    """Return the mean power linear theory expects of a run, per squared wave amplitude, dims (omega,) [W/m^2].

    Parameters
    ----------
    response : xarray.Dataset
        The frequency response of the study, in the direction of the waves.
    run : mapping
        Attributes of a run of the design; what a tuned damper absorbs is that of `power_waves`.
    """
    if TUNED not in run and TUNED_MATRIX not in run:
        given: xr.DataArray = response.absorbed_power.sel(design=design)
        return given
    found: xr.DataArray = 0.5 * (abs(power_waves(study, response, design, run)) ** 2).sum("load")
    return found


def linear_mean(study: Study, wave: Wave, frequency: xr.Dataset, design: str, run: Mapping[str, Any]) -> float | None:
    """Return the mean power linear theory expects of a run in a regular wave [W], beside drag with its dampers.

    None in other seas, and of a nonlinear take-off.
    """
    if not wave.regular or study.pto.nonlinear:
        return None
    if LINEARISED in run:
        return float(run[LINEARISED])
    found = power_response(study, in_direction(frequency, wave), design, run)
    return float(found.sel(omega=wave.omega, method="nearest")) * wave.amplitude**2


# a run as time series under WEC-Sim's names, for those who read its `output` structure ------------------------------

# Forces act on the body: they add up to its mass and added mass at infinite frequency times its acceleration.

BODY_FORCES = {
    "forceExcitation": ("excitation", "froude_krylov", "diffraction"),
    "forceRadiationDamping": ("radiation",),
    "forceRestoring": ("hydrostatic", "weight"),
    "forceMorisonAndViscous": ("drag",),
    "forceLinearDamping": ("structural_damping", "viscous"),
    "forceMooring": ("mooring",),
    "forceElastic": ("elastic", "prestress", "preload", "gas"),
}
"""Force of a body under WEC-Sim's name -> the forces of a run it is the sum of; `forceElastic` is no name of WEC-Sim's.

`forceRadiationDamping` has the opposite sign of WEC-Sim's, which is subtracted there.
"""
PTO, END_STOP = "pto", "end_stop"
WORDS = {
    "wave_elevation": "undisturbed wave elevation at the buoy's axis",
    "bodies_position": "displacements and modal amplitudes",
    "bodies_velocity": "their rates",
    "bodies_forceTotal": "all forces on the body but the take-off's",
    "ptos_position": "displacement of the take-off's port",
    "ptos_velocity": "velocity of the take-off's port",
    "ptos_forceTotal": "force of take-off and end stop at the port",
    "ptos_forceInternalMechanics": "force of the take-off at the port",
    "ptos_powerInternalMechanics": "that force times the velocity of the port, a spring's share included",
    "power_absorbed": "power absorbed by the take-off, without what its spring gives back",
}
"""Variable -> its meaning; what stands before the first _ is a field of WEC-Sim's `output`, what follows one of it."""


def time_series(run: xr.Dataset, port: xr.DataArray) -> xr.Dataset:
    """Return the time series of a run under WEC-Sim's names.

    Parameters
    ----------
    run : Dataset
        See `vsb.engine.integrators.simulate.recorded`.
    port : DataArray, dims (dof,)
        b of the take-off, which moves with b.q.

    Returns
    -------
    Dataset
        Dims (time,) and (time, dof), each variable with `units` and `long_name`. Of degrees of freedom that are
        rotations units are rad and N m in place of m and N. The attribute `left_out` names the variables of the run
        that have no name of WEC-Sim's.
    """
    kind, moving = kind_of(run), port.reindex(dof=run.dof, fill_value=0.0)
    forces = [str(name) for name, v in run.data_vars.items() if v.dims == ("time", "dof")]
    forces = [name for name in forces if name not in ("position", "velocity")]
    own = [name for name in forces if name not in (PTO, END_STOP)]
    listed = {name for names in BODY_FORCES.values() for name in names}
    named = {**BODY_FORCES, **{f"force{name.title().replace('_', '')}": (name,) for name in own if name not in listed}}
    none = xr.zeros_like(run.velocity)

    def total(names: list[str]) -> xr.DataArray:
        return sum((run[name] for name in names), none)

    found = {"wave_elevation": run["elevation"]} if "elevation" in run else {}
    found |= {"bodies_position": run.position, "bodies_velocity": run.velocity}
    present = {name: [part for part in parts if part in own] for name, parts in named.items()}
    found |= {f"bodies_{name}": total(parts) for name, parts in present.items() if parts}
    found["bodies_forceTotal"] = total(own)
    along = moving / float(moving @ moving) if float(moving @ moving) else moving
    force, velocity = total([n for n in forces if n == PTO]), run.velocity @ moving
    found |= {"ptos_position": run.position @ moving, "ptos_velocity": velocity}
    found["ptos_forceTotal"] = total([name for name in forces if name not in own]) @ along
    found["ptos_forceInternalMechanics"] = force @ along
    found |= {"ptos_powerInternalMechanics": (force * run.velocity).sum("dof"), "power_absorbed": run.power_absorbed}
    units = {"ptos_position": kind.motion_unit, "ptos_velocity": kind.rate_unit, "wave_elevation": "m"}
    units |= {"ptos_powerInternalMechanics": "W", "power_absorbed": "W"}
    units |= {"bodies_position": "m", "bodies_velocity": "m/s"}
    out = xr.Dataset()
    for name, values in found.items():
        unit = units.get(name, kind.load_unit if name.startswith("ptos") else "N")
        words = WORDS.get(name) or f"sum of {', '.join(present[name.removeprefix('bodies_')])}"
        out[name] = values.drop_attrs().assign_attrs(units=unit, long_name=words)
    kept = ("design", "wave", "method", "model", "energy_residual", "spec_id")
    attrs = {name: run.attrs[name] for name in kept if name in run.attrs}
    unnamed = {*map(str, run.data_vars)} - {"position", "velocity", "elevation", "power_absorbed", *forces}
    out = out.assign_attrs(left_out=", ".join(sorted(unnamed)))
    return out.assign_coords(time=run.time.assign_attrs(units="s", long_name="time")).assign_attrs(attrs)


def series_csv(series: xr.Dataset) -> str:
    """Return time series as CSV: a column of each variable, or of each of its degrees of freedom, with its unit."""
    columns = [("time [s]", series.time.values), *_columns(series)]
    return csv_text([name for name, _ in columns], zip(*(values.tolist() for _, values in columns), strict=True))


def _columns(series: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Heads and values of the columns but time."""
    for name, values in series.data_vars.items():
        unit = str(values.attrs["units"])
        if "dof" not in values.dims:
            yield f"{name} [{unit}]", values.values
            continue
        for dof in map(str, values.dof.values):
            turned = motion_of(dof) in ROTATIONS
            its = {"m": "rad", "m/s": "rad/s", "N": "N m"}[unit] if turned else unit
            yield f"{name}_{dof} [{its}]", values.sel(dof=dof).values
