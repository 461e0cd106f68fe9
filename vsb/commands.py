"""One function per workflow rule: read files, compute, write files. The command line calls these and nothing else."""

import json
import math
import time as clock
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vsb import (
    __version__,
    bemio,
    compare,
    database,
    interchange,
    ledger,
    meshing,
    quality,
    radiation,
    response,
    seastatistics,
    spectral,
    spectralsweep,
    trajectory,
    wamit,
)
from vsb.config import RegularWave, StillWater, Study, canonical, content_id, parse
from vsb.constraint import constraint_drift
from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.generalized import check_positive
from vsb.harmonic import harmonic_balance
from vsb.integrate import Motion, propagate
from vsb.kernel import DampingSpectrum
from vsb.modes import design_motions
from vsb.plant import Plant
from vsb.reference import check_stable, reference_shell
from vsb.scenes import SCENES, linear_buoy
from vsb.specs import COARSEST_SWEEP
from vsb.surface import enclosed, rigid_sphere
from vsb.units import FloatArray, load, save, write_text
from vsb.waves import NO_WAVES, power_limit, sea

Spec = dict[str, Any]
COLATITUDES = np.linspace(0.0, np.pi, 181)


def partial_study(spec: Spec) -> Study:
    """Return a study from the sections a stage's spec holds; what the stage does not read takes harmless values."""
    defaults: Spec = {
        "study": "stage",
        "designs": {"any": {"flexible": bool(spec.get("modes"))}},
        "waves": [{"kind": "still"}],
    }
    keys = [key for key in Study.model_fields if spec.get(key) is not None]
    return parse({**defaults, **{key: spec[key] for key in keys}}, source="spec")


def shell_modes(spec: Spec, out: str) -> None:
    """Write the shell modes of a study, after checking that every design has motions left."""
    study = partial_study(spec)
    reference = reference_shell(study)
    check_stable(study, reference)
    basis = reference.basis
    radial, meridional = basis.displacement(COLATITUDES)
    modes = xr.Dataset(
        {
            "radial": (("mode", "colatitude"), radial[1:]),
            "meridional": (("mode", "colatitude"), meridional[1:]),
            "degree": ("mode", list(basis.degrees[1:])),
            "dry_frequency": ("mode", basis.dry_frequencies),
            "static_amplitude": ("mode", reference.amplitudes[1:]),
        },
        coords={"mode": list(basis.labels[1:]), "colatitude": COLATITUDES},
        attrs={
            "radius": study.device.radius,
            "centre_height": study.centre_height + reference.amplitudes[0],
            "basis": study.modes.basis,
        },
    )
    save(modes, out)


def mesh(spec: Spec, out: str) -> None:
    """Write the mean wetted mesh and lid a BEM job reads."""
    save(mean_mesh(spec), out)


def mean_mesh(spec: Spec, coarser: int = 1) -> xr.Dataset:
    """Return the mean wetted mesh and lid of a spec, or one with a fraction of the panels in each direction."""
    panels = {key: math.ceil(spec[key] / coarser) for key in ("rows", "azimuth", "lid_rows")}
    if spec.get("reference_shape") == "equilibrium":
        return meshing.deformed_mesh(reference_shell(partial_study(spec)).shape, **panels)
    return meshing.mean_mesh(spec["radius"], spec["centre_height"], **panels)


def display_meshes(spec: Spec, folder: str) -> None:
    """Write the viewable meshes: the mean wetted shell, and one deformed shell per mode and sign."""
    study = partial_study(spec)
    for name, shape in meshing.display_shapes(reference_shell(study).shape).items():
        meshing.write_wet_shell(shape, f"{folder}/{name}.vtu")


def green(folder: str, out: str) -> None:
    """Compute and store the Green-function table, once for all jobs."""
    from vsb import bem

    begun = clock.perf_counter()
    bem.stored_green_function(folder)
    write_text(out, f"{clock.perf_counter() - begun:.1f} s\n")


def bem_block(spec: Spec, mesh_path: str, green_folder: str, out: str) -> None:
    """Solve one block of frequencies, on the mesh and on a coarser one for the error."""
    from vsb import panelsweep

    begun = clock.perf_counter()
    meshes = load(mesh_path), mean_mesh(spec["mesh"], coarser=2)
    solved = panelsweep.solve_block(spec, *meshes, green_folder)
    attrs = {"spec": canonical(spec), "spec_id": content_id(spec), "seconds": clock.perf_counter() - begun}
    save(solved.assign_attrs(solved.attrs | attrs), out)


def spectral_block(spec: Spec, out: str) -> None:
    """Solve one block of frequencies without panels, as finely as the tolerance needs."""
    begun = clock.perf_counter()
    problem = spectral_problem(spec)
    if "interpolation" in spec:
        solved = spectralsweep.converged_on_grid(problem, spec["omega"], spec["tolerance"], spec["interpolation"])
    else:
        solved = spectralsweep.converged(problem, spec["omega"], spec["tolerance"])
    attrs = {"spec": canonical(spec), "spec_id": content_id(spec), "seconds": clock.perf_counter() - begun}
    save(solved.assign_attrs(attrs), out)


def spectral_problem(spec: Spec) -> spectral.SpectralProblem:
    """Return the problem of a block: the shape at rest and its displacements."""
    shape, water = spec["shape"], spec["water"]
    if shape.get("reference_shape") == "equilibrium":
        shell = reference_shell(partial_study(shape)).shape
    else:
        shell = rigid_sphere(shape["radius"], shape["centre_height"])
    return spectral.SpectralProblem(
        shell,
        tuple(spec["displacements"]),
        water["density"],
        water["gravity"],
        spectralsweep.FEWEST_NODES,
        depth=float(water["depth"]),
    )


def build_database(spec: Spec, blocks: Sequence[str], out: str) -> None:
    """Merge blocks, express them in the modes, check them, and store them with their verdict.

    Raises
    ------
    DatabaseError
        If a block is missing, foreign, or a check fails that the study does not accept.
    """
    study = partial_study(spec)
    reference = reference_shell(study)
    basis, water = reference.basis, study.water
    found = {block.attrs.get("spec_id"): block for block in map(load, blocks)}
    if missing := [name for name in (*spec["sweep"], *spec["tabulated"]) if name not in found]:
        raise DatabaseError(f"{out}: blocks {missing} are not among the files given ({list(found)}); run the bem rule.")

    def in_modes(ids: Sequence[str]) -> xr.Dataset:
        return database.with_excitation(database.in_modes(database.merged_blocks([found[i] for i in ids]), basis))

    def complete(raw: xr.Dataset) -> xr.Dataset:
        return database.with_structure(database.with_symmetrized(raw), reference)

    everywhere = in_modes(spec["sweep"])
    infinite = [block for block in spec["sweep"] if "omega" not in found[block].dims]
    tabulated = in_modes([*spec["tabulated"], *infinite]) if spec["tabulated"] else None
    solver = str(json.loads(next(iter(found.values())).attrs["spec"])["solver"])
    precision = min(1.0, spec["tolerance"] / COARSEST_SWEEP) if solver == "spectral" else 1.0
    checks = [
        *quality.estimate_checks([block.attrs for block in found.values()], spec["tolerance"]),
        *quality.verdict(everywhere, tabulated, water.depth, water.density, water.gravity, precision),
    ]
    attrs = {
        "title": "hydro database of an axisymmetric shell in heave and its modes",
        "source": f"vsb {__version__}",
        "spec": canonical(spec),
        "spec_id": content_id(spec),
        "quality": database.as_json(quality.judged(checks, spec["accept"])),
        "radius": study.device.radius,
        "centre_height": study.centre_height,
        "basis": spec["modes"]["basis"] if spec["modes"] else "rigid",
        "degree": spec["modes"]["degree"] if spec["modes"] else 1,
        "water_density": water.density,
        "water_depth": str(water.depth),
        "gravity": water.gravity,
        "solver": solver,
        "bem_seconds": sum(block.attrs["seconds"] for block in found.values()),
    }
    if tabulated is None:
        asked = complete(everywhere).sel(omega=slice(None, spec["omega_max"] + 1e-9))
        database.save_database(asked.assign_attrs(asked.attrs, **attrs), None, out)
    else:
        asked = complete(tabulated)
        database.save_database(asked.assign_attrs(asked.attrs, **attrs), complete(everywhere), out)


def import_wamit(
    folder: str,
    name: str,
    out: str,
    *,
    density: float,
    gravity: float,
    length: float,
    depth: float,
    axisymmetric: bool,
) -> tuple[list[database.Check], list[str]]:
    """Read WAMIT's output into a database file; return its verdict and what was left out."""
    values = (density, "kg/m^3"), (gravity, "m/s^2"), (length, "m"), (depth, "m")
    for option, (value, unit) in zip(("density", "gravity", "length", "depth"), values, strict=True):
        check_positive(f"--{option}", value, unit, infinite=option == "depth")
    ds = wamit.import_wamit(folder, name, density=density, gravity=gravity, length=length, depth=depth)
    return _store_foreign(ds, out, axisymmetric)


def import_bemio(path: str, out: str, *, axisymmetric: bool) -> tuple[list[database.Check], list[str]]:
    """Read BEMIO's .h5 into a database file; return its verdict and what was left out."""
    return _store_foreign(bemio.read_bemio(path), out, axisymmetric)


def _store_foreign(ds: xr.Dataset, out: str, axisymmetric: bool) -> tuple[list[database.Check], list[str]]:
    """Store a database of another code with the verdict of the identities that need no other data."""
    checks, missing = interchange.foreign_checks(ds, axisymmetric=axisymmetric)
    notes = [ds.attrs["history"], *[missing] * bool(missing)]
    attrs = {"quality": database.as_json(checks), "spec_id": Path(out).stem, "separate_sweep": 0}
    save(ds.assign_attrs(**attrs, history="; ".join(notes)), out)
    return checks, notes


def fit_radiation(spec: Spec, database_path: str, out: str) -> None:
    """Fit and store the passive state-space radiation model, with the kernels to compare."""
    ds = database.load_database(database_path, spec["database"])
    spectrum = DampingSpectrum(ds.omega.values, ds.radiation_damping.values)
    begun = clock.perf_counter()
    model, error = radiation.fit_radiation(spectrum, spec["tolerance"])
    time = np.linspace(0.0, 40 / np.sqrt(float(ds.attrs["gravity"]) / float(ds.attrs["radius"])), 401)
    pair = ("influenced_dof", "radiating_dof")
    labels = ds.influenced_dof.values
    damping = model.damping(ds.omega.values)
    scale = np.sqrt(np.einsum("wii->wi", ds.radiation_damping.values).max(axis=0))
    margin = float(np.linalg.eigvalsh(damping / np.outer(scale, scale)).min())
    save(
        xr.Dataset(
            {
                "state_matrix": (("state", "state_in"), model.state_matrix),
                "input_matrix": (("state", "radiating_dof"), model.input_matrix),
                "channel": ("state", model.channel),
                "kernel": (("time", *pair), spectrum.kernel(time)),
                "kernel_state_space": (("time", *pair), model.kernel(time)),
                "damping_state_space": (("omega", *pair), damping),
            },
            coords={"time": time, "omega": ds.omega.values, "influenced_dof": labels, "radiating_dof": labels},
            attrs={
                "spec": canonical(spec),
                "spec_id": content_id(spec),
                "order": model.order,
                "fit_error": error,
                "passivity_margin": margin,
                "seconds": clock.perf_counter() - begun,
            },
        ),
        out,
    )


def frequency_response(spec: Spec, database_path: str, out: str) -> None:
    """Write response amplitude operators, absorbed power, its limit, and wet natural frequencies of all designs."""
    study = partial_study(spec)
    buoy, basis = linear_buoy(study, database_path)
    omega = response.frequency_grid(spec["step"], spec["lowest"], spec["omega_max"], spec["omega"])
    rao, power, wet = [], [], []
    for design in study.designs:
        motions = design_motions(study, basis, design)
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
        ),
        out,
    )


def simulate(spec: Spec, paths: dict[str, Any], out: str) -> None:
    """Run one design in one sea and write its trajectory."""
    study = partial_study(spec)
    (design,), (wave,) = study.designs, study.waves
    plant, shape, waves, spectrum, notes = SCENES[study.hydro.model](study, paths)
    motion, stride, method = trajectory.simulate(plant, waves, study.simulation, spectrum)
    run = trajectory.labelled(plant, motion, waves if study.needs_bem else None, design, wave.label, stride)
    moved = np.zeros((run.sizes["time"], len(shape.amplitudes)))
    moved[:, : run.sizes["dof"]] = run.position.values
    volume, area = enclosed(shape.basis, shape.amplitudes + moved)
    attrs = {"method": method, "instants": len(motion.time), "seconds": motion.seconds, **notes}
    if isinstance(study.waves[0], RegularWave):
        attrs |= _steady(plant)
    if rows := study.designs[design].clamp:
        attrs["constraint_drift"] = _drift(study, plant, motion, shape.basis.clamp_rows(np.deg2rad(rows)))
    save(run.assign(volume=("time", volume), area=("time", area)).assign_attrs(run.attrs, **attrs), out)


def _steady(plant: Plant) -> dict[str, float | str]:
    """Mean power of the steady state and what a period leaves of a transient; or why there is none."""
    try:
        found = harmonic_balance(plant, 1e-6)
    except (ConvergenceError, StabilityError) as error:
        return {"no_steady_state": str(error)}
    return {"steady_power": found.power.pto, "steady_decay": found.decay}


def _drift(study: Study, plant: Plant, motion: Motion, rows: FloatArray) -> float:
    """Largest slip at the clamps [m]: over the run, and where motion is linear over 10 000 wave periods."""
    drift = constraint_drift(motion.position @ plant.motions.T, rows)
    if plant.water or isinstance(study.waves[0], StillWater):
        return drift
    time = np.linspace(0.0, 1e4 * 2 * np.pi / study.waves[0].omega, 20_001)
    start = plant.start(study.simulation.initial_position, study.simulation.initial_velocity)
    return max(drift, constraint_drift(propagate(plant, time, start).position @ plant.motions.T, rows))


def compare_designs(spec: Spec, paths: dict[str, Any], trajectories: Sequence[str]) -> None:
    """Write the comparison table, statistics of irregular seas, the validity ledger and the study in canonical form."""
    study = parse(spec["study"], source="spec")
    runs = {(run.attrs["design"], run.attrs["wave"]): run for run in map(load, trajectories)}
    bem = study.needs_bem
    seas = {
        wave.label: sea(wave, study.hydro.omega_max, study.simulation.duration) if bem else NO_WAVES
        for wave in study.waves
    }
    rows = compare.comparison(study, runs, seas)
    checks, lines = [*ledger.run_ledger(study, runs), *ledger.transient_checks(runs, rows)], []
    if bem:
        ds = database.load_database(paths["database"], Path(paths["database"]).stem)
        frequency = load(paths["response"])
        lines = seastatistics.statistics(study, runs, seas, frequency)
        checks += ledger.linear_ledger(study, ds, load(paths["radiation"]), frequency, rows, runs)
        checks += seastatistics.statistical_checks(study, lines)
    else:
        checks += ledger.assumed_pressure_checks(study, rows)
    checks = ledger.worst_first(checks)
    write_text(paths["out"], compare.as_csv(rows))
    write_text(paths["statistics"], seastatistics.as_csv(lines))
    write_text(paths["validity"], ledger.ledger_json(study.study, checks))
    write_text(paths["study"], canonical(study) + "\n")
