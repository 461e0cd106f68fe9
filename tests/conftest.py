"""Fixtures: one Green-function table and a few small hydro databases per test session.

Workers take whole files (--dist loadfile), the longest first, and share the table, which takes a quarter of a minute.
"""

import fcntl
import gc
import json
import shutil
from contextlib import chdir, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from hypothesis import settings
from scipy.integrate import solve_ivp

import vsb
from vsb.api.results import Results
from vsb.cli import main
from vsb.engine.hydro import database
from vsb.engine.hydro.panels import bem
from vsb.engine.hydro.radiation import DampingSpectrum, fit_radiation
from vsb.engine.hydro.spectral import solver as spectralsolver
from vsb.engine.integrators.audit import START, energies
from vsb.engine.integrators.simulate import Leg, recorded
from vsb.engine.motion.forces import Spring
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.keys.quantities import canonical
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import make
from vsb.stages.panels import mean_mesh, solve_block
from vsb.stages.stage import run_task
from vsb.stages.water import spectral_problem
from vsb.study import study as config
from vsb.study.specs import SpectralBlock
from vsb.study.study import Study

settings.register_profile("vsb", deadline=None)  # a machine may be busy
settings.load_profile("vsb")

HERE = Path(__file__).parent
SEED = HERE / "data" / "seed.yaml"
"""The paper's shell with few modes."""
EXAMPLE = HERE.parent / "config" / "buoy.yaml"
"""The study a stranger begins with."""


def shipped(name):
    """The file of a shipped study; of the seed the one with few modes."""
    return SEED if name == "seed" else EXAMPLE.with_name(f"{name}.yaml")


def varied(study: Study, **changes) -> Study:
    """A study with some sections updated: device={"mass": ...}, designs={...}."""
    data = study.model_dump()
    for section, update in changes.items():
        data[section] = (
            {**(data.get(section) or {}), **update} if isinstance(update, dict) and section != "designs" else update
        )
    return config.parse(data)


def only_run(study: Study):
    """What is simulated of the only design of a study in its first sea."""
    return StudyPlan(study).simulation(*study.designs, study.waves[0]).spec["run"]


def run_at(task, **files):
    """Run the stage of a task on other files."""
    run_task(replace(task, files={**task.files, **files}))


def springs(plant):
    """Stiffness of a scene without the tangent of the water's force, shape (free, free) [N/m]."""
    matrices = [force.stiffness for force in plant.forces.values() if isinstance(force, Spring)]
    return plant.motions.T @ sum(matrices, 0.0 * plant.mass) @ plant.motions


def compiled_motion(plant, time, start, rtol=1e-11):
    """Motion of a scene under assumed pressure by an explicit method of order 8 in plain coordinates, (time, free)."""
    mass = np.linalg.inv(plant.motions.T @ plant.mass @ plant.motions)
    stiffness, damping, n = springs(plant), plant.damping, plant.motions.shape[1]
    water, weight = plant.water, plant.forces["weight"].value

    def rates(t, y):
        static, uniform, _ = water.shell.forces((plant.motions @ y[:n])[None])
        force = (
            water.specific_weight * static[0]
            + water.assumed.amplitude * np.cos(water.assumed.omega * t) * uniform[0]
            + weight
        )
        return np.concatenate([y[n:], mass @ (plant.motions.T @ force - stiffness @ y[:n] - damping @ y[n:])])

    y0 = np.concatenate(start)
    return solve_ivp(rates, (0, time[-1]), y0, method="DOP853", rtol=rtol, atol=1e-13, t_eval=time).y[:n].T


def labelled(system, motion, sea, design, wave, stride):
    """A run as a dataset, every `stride`-th instant, with the audit of all instants; see `recorded`."""
    energy = energies(system, motion)
    leg = Leg(motion, {}, energy, START.after(energy), stride, 1, "", 0)
    attrs = {"design": design, "wave": wave, "energy_residual": leg.balance.residual, "status": "completed"}
    return recorded(system, leg, sea, (0.0, 0.0)).assign_attrs(attrs)


def error_line(arguments, capsys, run=main) -> str:
    """The one line that reports an error, after nothing was printed."""
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err.removeprefix("vsb: error: ").removesuffix("\n")


@pytest.fixture
def workplace(tmp_path, monkeypatch) -> Path:
    """An empty current folder with a file in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("kept")
    return tmp_path


@pytest.fixture
def written(tmp_path):
    """Function text, or bytes -> path of the file that holds it, given.txt."""

    def write(text) -> Path:
        path = tmp_path / "given.txt"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@pytest.fixture(scope="session")
def seed() -> Study:
    return config.load(SEED)


@pytest.fixture(scope="session")
def hemisphere() -> dict:
    """Semi-analytic coefficients of the floating hemisphere (multipole series, source inside the file)."""
    return json.loads((HERE / "data" / "hemisphere.json").read_text())


def pytest_make_parametrize_id(config, val, argname):
    """Name a test by its argument where the value is bytes: packed ones hold their time, so two workers named it twice."""
    return argname if isinstance(val, bytes) else None


FIRST, LAST = ("hydro",), ("keys", "shell", "study", "tools", "waves")


def pytest_collection_modifyitems(items):
    """Put the workflow's tests first, the longest; beside them those that compile most loops; short files last.

    What comes next compiles none, so that no worker waits for loops that another one compiles.
    """

    def rank(item):
        name, room = item.path.name, item.path.relative_to(HERE).parts[0]
        return (
            name != "test_workflow.py", name != "test_audit.py", room not in FIRST, room in LAST or room.endswith(".py"),
        )  # fmt: skip

    items.sort(key=rank)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for no lost objects among the modules of the tests: a quarter of the time of collecting, and of every search.

    One worker after the other: the first compiles the tests, which all would do at the same time.
    """
    gc.disable()
    try:
        with Path(__file__).open() as handle:
            fcntl.flock(handle, fcntl.LOCK_EX)
            return (yield)
    finally:
        gc.freeze()
        gc.enable()


@contextmanager
def shared_by_workers(tmp_path_factory, worker_id, name):
    """A folder of all workers, held by one of them."""
    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == "master" else base.parent) / name
    with folder.with_suffix(".lock").open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield folder


@pytest.fixture(scope="session")
def green_folder(tmp_path_factory, worker_id) -> Path:
    """The Green-function table, copied from capytaine's own, which this machine keeps once it was computed."""
    import capytaine as cpt  # a second, which other tests do not wait for
    from capytaine.tools.cache_on_disk import cache_directory

    with shared_by_workers(tmp_path_factory, worker_id, "green") as folder:
        if not folder.exists():
            cpt.Delhommeau()
            shutil.copytree(cache_directory(), folder)
        bem.green_function(folder)
    return folder


SMALL = yaml.safe_load(SEED.read_text()) | {
    "study": "small",
    "modes": {"basis": "membrane", "degree": 2, "tolerance": 0.1},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
    "hydro": {"omega_max": 5.0, "tolerance": 1.0e-3, "witness": "none"},
}
"""A study whose results are there in seconds."""
SMALL["simulation"] |= {"duration": 8.0, "window": [4.0, 8.0]}
SMALL_PLAN = StudyPlan(config.parse(SMALL))


@contextmanager
def one_figure():
    """Studies draw one figure alone, for tests of what else is on their pages."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vsb.study.figure_names.of_study", lambda _: ["absorbed_power"])
        yield


def tables_of(plan):
    """Results of a study whose tables alone are made: no figures and no page."""
    make(plan, [f"{plan.folder}/comparison.csv", *(f"{plan.folder}/{name}" for name in ("ladder.csv", "ladder.json"))])
    return Results(plan.study, plan.root)


@pytest.fixture(scope="session")
def finished(tmp_path_factory, worker_id) -> Path:
    """A folder with the small study's file and its results, made by whichever worker asks first; not to be changed."""
    with shared_by_workers(tmp_path_factory, worker_id, "finished") as folder:
        folder.mkdir(exist_ok=True)
        with chdir(folder):
            Path("small.yaml").write_text(yaml.safe_dump(SMALL))
            vsb.run(vsb.load("small.yaml"))
    return folder


@pytest.fixture
def small(finished, monkeypatch) -> StudyPlan:
    """The small study, in whose folder results are read."""
    monkeypatch.chdir(finished)
    return SMALL_PLAN


def solved_block(spec, green_folder):
    """One BEM job, by the solver its spec names."""
    if isinstance(spec, SpectralBlock):
        return spectralsolver.converged(spectral_problem(spec), list(spec.omega), spec.tolerance)
    return solve_block(spec, mean_mesh(spec.mesh), mean_mesh(spec.mesh, coarser=2), green_folder)


@pytest.fixture(scope="session")
def solved(request):
    """Function study -> raw hydro sweep of its plan (normal velocities P_n), each shape solved once."""
    cache: dict[str, object] = {}

    def folder(block):
        return None if isinstance(block, SpectralBlock) else request.getfixturevalue("green_folder")

    def solve(study: Study):
        blocks = StudyPlan(study).sweep_blocks
        for block in blocks:
            key = canonical(block)
            if key not in cache:
                cache[key] = solved_block(block, folder(block))
        return database.with_excitation(database.merged_blocks([cache[canonical(block)] for block in blocks]))

    return solve


@pytest.fixture(scope="session")
def spectral_seed(seed) -> LinearSystem:
    """The seed up to 6 rad/s by the spectral solver, without a take-off."""
    study = varied(seed, hydro={"omega_max": 6.0})
    basis = study_basis(study)
    blocks = [solved_block(block, None) for block in StudyPlan(study).sweep_blocks]
    raw = database.in_modes(database.with_excitation(database.merged_blocks(blocks)), basis)
    ds = database.with_structure(database.with_symmetrized(raw), reference_shell(study))
    ds = ds.assign_attrs(gravity=9.81, water_depth="inf", water_density=1025.0)
    return LinearSystem(ds, basis.damping, LinearPto(0.0))


@pytest.fixture(scope="session")
def coarse(seed) -> Study:
    """The seed study on 20 rows up to 8 rad/s: mesh error below 1 %."""
    return varied(seed, hydro={"rows": 20, "omega_max": 8.0})


@pytest.fixture(scope="session")
def buoy_of(solved):
    """Function study -> its linear buoy."""

    def build(study: Study) -> LinearSystem:
        basis = study_basis(study)
        raw = database.with_symmetrized(database.in_modes(solved(study), basis))
        ds = database.with_structure(raw, reference_shell(study))
        return LinearSystem(ds, basis.damping, LinearPto(study.pto.damping))

    return build


@pytest.fixture(scope="session")
def radiation_of(buoy_of):
    """Function study -> passive radiation model of its database, fitted once per spectrum."""
    cache: dict[str, object] = {}

    def fit(study: Study):
        key = canonical(
            {"hydro": study.hydro, "device": study.device, "modes": study.modes, "rigid": not study.flexible}
        )
        if key not in cache:
            ds = buoy_of(study).database
            cache[key] = fit_radiation(DampingSpectrum(ds.omega.values, ds.radiation_damping.values), 1e-3)[0]
        return cache[key]

    return fit


@pytest.fixture(scope="session")
def wet_buoy(buoy_of, radiation_of):
    """Function (study, design) -> buoy with its attributes, shape at rest, radiation model, motions: of a body-exact scene."""

    def build(study: Study, design: str):
        reference = reference_shell(study)
        buoy = buoy_of(study)
        attrs = {"gravity": study.water.gravity, "water_depth": "inf", "water_density": study.water.density}
        buoy = replace(buoy, database=buoy.database.assign_attrs(attrs))
        return buoy, reference.shape, radiation_of(study), design_motions(study, reference.basis, design)

    return build


@pytest.fixture(scope="session")
def ball(tmp_path_factory):
    """A floating hemisphere of 1 m as capytaine solves and writes it, with all that `fill_dataset` may be asked.

    It turns about a point 0.3 m below its centre of mass.
    """
    import capytaine as cpt  # a second, which other tests do not wait for

    mesh = cpt.mesh_sphere(radius=1.0, resolution=(8, 8)).immersed_part()
    body = cpt.FloatingBody(
        mesh, lid_mesh=mesh.generate_lid(), dofs=cpt.rigid_body_dofs(rotation_center=(0, 0, -0.5)),
        center_of_mass=(0, 0, -0.2), name="ball",
    )  # fmt: skip
    body.inertia_matrix = body.compute_rigid_body_inertia()
    body.hydrostatic_stiffness = body.compute_hydrostatic_stiffness()
    asked = {"omega": [0.0, *np.linspace(0.5, 6.0, 12), np.inf], "wave_direction": np.radians([0.0, 90.0, 180.0])}
    water = {"radiating_dof": list(body.dofs), "water_depth": [np.inf], "rho": [1025.0]}
    ds = cpt.BEMSolver().fill_dataset(xr.Dataset(coords=asked | water), body, hydrostatics=True, progress_bar=False)
    path = tmp_path_factory.mktemp("capytaine") / "ball.nc"
    cpt.export_dataset(path, ds)
    return path
