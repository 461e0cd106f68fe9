"""How the dependence of the coefficients on the shape changes the mean power of a study.

When may it be ignored? A deformation eta of a sphere of radius a changes heave's coefficients, in terms of themselves,
by about max(4/a, 2K) eta, K = omega^2/g: its size counts, and in damping e^{-2Kd} with the draft d (the seed: at
2.51 rad/s 12 % in damping per 0.1 m of heave, 304 % at 12 rad/s). One percent needs eta < a/400 and K eta < 0.005, five
percent five times that. Varying with the waves' frequency, first-order changes leave the mean power alone up to
second order in eta; a lasting deformation does not: the shape at rest must be the one solved on.

For a study's own motion its mean power is computed with the coefficients of each shape that its linear motion passes
through, and with those of the loaded shell's shape at rest.
"""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import Coefficients, with_structure
from vsb.engine.hydro.shape_dependence import ShapeDatabase, ShapeFamily, shape_database
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.take_off import Pto
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.loaded import equilibrium
from vsb.engine.waves.seas import Sea
from vsb.errors import ConfigError, ConvergenceError
from vsb.keys.quantities import canonical
from vsb.models.floating_system import study_sea
from vsb.models.rest import design_motions, loaded_shell, reference_shell
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import described

SIZES = (0.00625, 0.0125, 0.025, 0.05, 0.1)
"""Sizes of the deformations on which a study's expansion is put to the test, in radii."""
LEAST_REACH = 0.01
"""Amplitudes the shape database holds at least, in radii."""
NEGLIGIBLE = 0.01
"""Change of mean power that may be ignored [-]."""
INSTANTS = 96
"""Shapes of a motion that are computed: in a period of regular waves, in a run of others."""
SAMPLES = 8
"""Random directions for each of `SIZES`."""
TRIED = 20
"""Random combinations of amplitudes the shape database is measured on."""
_CURVES = {
    "added_mass": ("added mass", "#000000"),
    "radiation_damping": ("damping", "#D55E00"),
    "excitation_force": ("excitation", "#0072B2"),
}
_EXPANSIONS = {"first": ("first order", "#000000", "o"), "second": ("second order", "#D55E00", "s")}


def given_damper(study: Study) -> float:
    """Return the damper of a study whose take-off is one given damper on heave; `ConfigError` if it is another."""
    pto = study.pto
    if not isinstance(pto.damping, float) or pto != Pto(damping=pto.damping):
        raise ConfigError(f"pto: received {canonical(pto)}; shape dependence needs one damping, on heave, and no more")
    return pto.damping


def damped(buoy: LinearSystem, omega: FloatArray, c: Coefficients) -> LinearEquation:
    """Return the equation of motion of a buoy and its damper with other coefficients at some frequencies."""
    viscous = buoy.damping_at(omega), buoy.stiffness, buoy.stiffening_at(omega)
    return LinearEquation(omega, c, buoy.mass, *viscous)


def power_slope(buoy: LinearSystem, slopes: xr.Dataset, motions: FloatArray) -> FloatArray:
    """Return the derivative of absorbed power per squared wave amplitude by shape, shape (shape_dof, omega) [W/m^3].

    The database of the buoy is at the frequencies of `slopes`; `motions`, (dof, free), are those a design allows.
    Z q = X gives dq = Z^-1 (dX - dZ q) with dZ = -w^2 dA - i w dB; inertia and stiffness stay.
    """
    omega = buoy.database.omega.values
    equation, w = damped(buoy, omega, buoy.coefficients(omega)), omega[:, None, None]
    q = equation.response(equation.water.excitation, motions)
    change = -(w**2) * slopes.added_mass.values - 1j * w * slopes.radiation_damping.values
    load = slopes.excitation_force.values[:, :, 0] - np.einsum("kwij,wj->kwi", change, q)
    response = equation.response(load, motions)
    return np.asarray(buoy.pto.damping * omega**2 * (q[:, 0].conj() * response[..., 0]).real)


def power_changes(motion: "StudyMotion", family: ShapeFamily) -> xr.Dataset:
    """Return how the power of every design depends to first order on the shape its coefficients are taken on.

    `absorbed_power` (design, omega) [W/m^2] per squared wave amplitude; its `power_slope` (design, shape_dof, omega)
    [W/m^3]; `power_swing` (design, omega) [W/m^3], max over t of sum_k P_k Re q_k e^{-i w t} per wave amplitude, with
    coefficients of the shape at that instant; `power_undeformed` (design, omega) [W/m^2], with those of the sphere.
    """
    study, reference, buoy, omega = motion.study, motion.reference, motion.buoy, np.array(family.omegas)
    motions = [design_motions(study, reference.basis, design) for design in study.designs]
    raos = np.array([buoy.rao(omega, free) for free in motions])
    slope = np.array([power_slope(buoy, family.slopes, free) for free in motions])
    wave, swing = ("design", "omega"), np.abs(np.einsum("dkw,dwk->dw", slope, raos))
    undeformed = -np.einsum("dkw,k->dw", slope, reference.modal_amplitude)
    return xr.Dataset(
        {
            "absorbed_power": (wave, [buoy.absorbed_power(omega, rao) for rao in raos], {"units": "W/m^2"}),
            "power_slope": (("design", "shape_dof", "omega"), slope, {"units": "W/m^3"}),
            "power_swing": (wave, swing, {"units": "W/m^3"}),
            "power_undeformed": (wave, undeformed, {"units": "W/m^2"}),
        },
        {"design": list(study.designs), "shape_dof": family.labels, "omega": omega},
    )


def study_family(study: Study, reference: ReferenceShell, frequencies: int = 60) -> ShapeFamily:
    """Return the shapes around that of a study; `ConfigError` unless the water is deep.

    Frequencies are those of a grid and of its regular waves; where a sea has waves below them, also its lowest one.
    """
    if np.isfinite(study.water.depth):
        raise ConfigError(f"water.depth: received {study.water.depth:g} m; shape dependence needs deep water, .inf")
    highest = study.hydro.omega_max
    grid = {round(highest * (i + 1) / frequencies, 10) for i in range(frequencies)}
    waves = {wave.omega for wave in study.waves if wave.regular}
    seas = (wave.realisation(highest, study.simulation.duration) for wave in study.waves)
    lowest = min((float(one.omega.min()) for one in seas if one.omega.size), default=np.inf)
    known = grid | waves
    return ShapeFamily(
        reference.shape, tuple(sorted({*known, min(lowest, *known)})), study.water.density, study.water.gravity
    )


def mean_power(buoy: LinearSystem, c: Coefficients, waves: Sea, motions: FloatArray) -> float:
    """Return the mean absorbed power in a sea [W] of a buoy with other coefficients, those at the sea's frequencies."""
    rao = damped(buoy, waves.omega, c).response(c.excitation, motions)
    return waves.mean_of(buoy.absorbed_power(waves.omega, rao))


@dataclass(frozen=True)
class StudyMotion:
    """The linear motion of every design of a study in each of its seas."""

    study: Study
    reference: ReferenceShell
    buoy: LinearSystem

    @classmethod
    def of(cls, study: Study, reference: ReferenceShell, family: ShapeFamily) -> Self:
        """Return the motion with the coefficients of the family's reference shape; see `given_damper`."""
        pto, dry, maxwell = LinearPto(given_damper(study)), reference.basis.damping, study.device.damping.maxwell
        return cls(study, reference, LinearSystem(with_structure(family.centre, reference), dry, pto, maxwell=maxwell))

    @cached_property
    def runs(self) -> dict[tuple[str, str], tuple[Sea, FloatArray]]:
        """Sea and allowed motions by design and wave; still water is none."""
        seas = {wave.label: study_sea(self.study, wave, self.buoy.database) for wave in self.study.waves}
        motions = {design: design_motions(self.study, self.reference.basis, design) for design in self.study.designs}
        return {(d, label): (s, motions[d]) for d in motions for label, s in seas.items() if s.omega.size}

    def shapes(self, design: str, wave: str) -> FloatArray:
        """Amplitudes passed through, shape (instant, dof) [m]."""
        waves, motions = self.runs[design, wave]
        # amplitudes of the linear motion at `INSTANTS` of a period or run, shape (instant, dof) [m]
        span = 2 * np.pi / waves.omega[0] if len(waves.omega) == 1 else self.study.simulation.duration
        time = np.arange(INSTANTS) / INSTANTS * span
        phasors = waves.amplitude[:, None] * self.buoy.rao(waves.omega, motions)
        return np.asarray((np.exp(-1j * np.outer(time, waves.omega)) @ phasors).real)

    @cached_property
    def reach(self) -> FloatArray:
        """Largest amplitudes in any run, but at least `LEAST_REACH`, shape (dof,) [m]."""
        least = np.full((1, len(self.reference.basis.labels)), LEAST_REACH * self.study.device.radius)
        return np.asarray(np.abs(np.concatenate([least, *(self.shapes(*run) for run in self.runs)])).max(axis=0))

    def rest(self, design: str) -> FloatArray:
        """Shape at rest, amplitudes from the reference shape (dof,) [m]; `ConvergenceError` if the shell gives way."""
        if self.study.at_equilibrium:
            return np.zeros(len(self.reference.basis.labels))
        motions = design_motions(self.study, self.reference.basis, design)
        return equilibrium(loaded_shell(self.study, self.reference.basis), motions)


def study_powers(motion: StudyMotion, family: ShapeFamily, database: ShapeDatabase) -> xr.Dataset:
    """Return the mean power of every run [W] with the coefficients of other shapes, all else the same.

    `power_at_reference` (design, wave); `power_at_shape` (design, wave, instant) of the shapes its linear motion passes
    through; `power_at_rest` (design, wave) of the shape at rest, left out where a shell has none in the study's modes.
    Empty in still water.
    """
    if not motion.runs:
        return xr.Dataset()
    designs, waves = (list(dict.fromkeys(names)) for names in zip(*motion.runs, strict=True))
    table = (len(designs), len(waves))
    reference, passed = [], []  # with coefficients of the reference shape, and of every shape passed through
    for run, (incident, motions) in motion.runs.items():
        shapes = [np.zeros(len(database.labels)), *motion.shapes(*run)]
        powers = [mean_power(motion.buoy, database.at(incident.omega, shape), incident, motions) for shape in shapes]
        reference.append(powers[0])
        passed.append(powers[1:])
    ds = xr.Dataset(
        {
            "power_at_reference": (("design", "wave"), np.reshape(reference, table)),
            "power_at_shape": (("design", "wave", "instant"), np.reshape(passed, (*table, INSTANTS))),
        },
        {"design": designs, "wave": waves},
    )
    try:
        resting = np.reshape([_power_at_rest(motion, family, run) for run in motion.runs], table)
    except ConvergenceError:
        return ds
    return ds.assign(power_at_rest=(("design", "wave"), resting))


def _power_at_rest(motion: StudyMotion, family: ShapeFamily, run: tuple[str, str]) -> float:
    """Mean power [W] with coefficients solved on the shape at rest."""
    waves, motions = motion.runs[run]
    solved = with_structure(family.at(motion.rest(run[0])), motion.reference)
    return mean_power(motion.buoy, replace(motion.buoy, database=solved).coefficients(waves.omega), waves, motions)


def power_effects(ds: xr.Dataset) -> dict[tuple[str, str], dict[str, float]]:
    """Return relative changes of mean power by (design, wave): `least`, `most`, `average` of the motion, and `rest`."""
    effects = {}
    for design, wave in itertools.product(ds.design.values, ds.wave.values) if "wave" in ds else ():
        run = ds.sel(design=design, wave=wave)
        if run.power_at_reference > 0:
            change = run.power_at_shape.values / float(run.power_at_reference) - 1
            found = {"least": change.min(), "most": change.max(), "average": change.mean()}
            if "power_at_rest" in run:
                found["rest"] = float(run.power_at_rest / run.power_at_reference) - 1
            effects[str(design), str(wave)] = {name: float(value) for name, value in found.items()}
    return effects


def answer(ds: xr.Dataset, name: str) -> str:
    """Return one line: whether the study `name` may ignore the shape dependence, by the run it matters most to.

    Yes if no shape of the motion, nor that at rest, changes a mean power by more than `NEGLIGIBLE`; on average if their
    changes over the motion cancel to that, as those of first order do.
    """
    effects = power_effects(ds)
    if not effects:
        return f"{name}: no power is absorbed, so none depends on the shape"
    (design, wave), worst = max(effects.items(), key=lambda item: max(map(abs, item[1].values())))
    lasting = max(abs(e[kind]) for e in effects.values() for kind in ("average", "rest") if kind in e)
    largest = max(map(abs, worst.values()))
    verdict = "may be ignored" if largest <= NEGLIGIBLE else "averages out" if lasting <= NEGLIGIBLE else "matters"
    rest = f"{100 * worst['rest']:+.2g} % by that of the shape at rest" if "rest" in worst else "no shape at rest found"
    power = float(ds.power_at_reference.sel(design=design, wave=wave))
    return (
        f"{name}: the shape dependence {verdict} (limit {100 * NEGLIGIBLE:g} % of mean power): {design}, {wave}: "
        f"{power:.4g} W changes by {100 * worst['least']:+.2g} to {100 * worst['most']:+.2g} % by the shapes of the "
        f"motion, {100 * worst['average']:+.2g} % on average, {rest}"
    )


def shape_dataset(study: Study, family: ShapeFamily, samples: int = TRIED) -> xr.Dataset:
    """Return all of it for a study: its shape database, what it means for power, errors of expansions.

    `interpolation_error`, dimensions (expansion, deformation): of the `first` and `second` order in random directions;
    `deformation` is its size [m]. The database is measured on `samples` random combinations within its reach.
    """
    reference = reference_shell(study)
    motion = StudyMotion.of(study, reference, family)
    database = shape_database(family, motion.reach, samples)
    sizes = study.device.radius * np.array(SIZES)
    errors = [family.interpolation_error(size, samples=SAMPLES).to_array().max("variable") for size in sizes]
    table = xr.Dataset(
        {"interpolation_error": (("deformation", "expansion"), np.array(errors), {"units": "1"})},
        {"expansion": list(_EXPANSIONS), "deformation": ("deformation", sizes, {"units": "m"})},
    )
    powers = study_powers(motion, family, database)
    changes = power_changes(motion, family)
    return described(database.dataset.merge(changes).merge(table).merge(powers))


def relative_slope(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return the derivative of the logarithm of heave's coefficient `name` (of |X|), (shape_dof, omega) [1/m]."""
    heave = {dim: 0 for dim in ds[name].dims if dim != "omega"}
    relative: xr.DataArray = (ds[f"{name}_slope"].isel(heave, drop=True) / ds[name].isel(heave, drop=True)).real
    return relative


def largest_mode(ds: xr.Dataset) -> str | None:
    """Return the mode that changes heave's added mass most, relative, in the band; none of a rigid buoy."""
    change = abs(relative_slope(ds, "added_mass")).max("omega").values
    return str(ds.shape_dof.values[1 + change[1:].argmax()]) if len(change) > 1 else None


def shapes_of_study(study: Study, family: ShapeFamily) -> int:
    """Return the number of shapes `shape_dataset` looks at, where every design has a shape at rest."""
    checks = 1 + 2 * len(family.labels) + TRIED + len(SIZES) * SAMPLES
    seas = sum(not wave.still for wave in study.waves)
    return family.shapes_of_derivatives + checks + seas * len(study.designs)
