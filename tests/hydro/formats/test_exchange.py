"""Exchange with WAMIT's numeric files and BEMIO's .h5: conventions by numbers worked out by hand, and round trips."""

import json
import re

import capytaine as cpt
import numpy as np
import pytest
import xarray as xr
from hydro.formats.test_capytaine import dataset

from vsb.cli import main
from vsb.engine.hydro import database
from vsb.engine.hydro.database import load_database
from vsb.engine.hydro.formats.bemio import read_bemio, write_h5
from vsb.engine.hydro.formats.capytaine import read_capytaine
from vsb.engine.hydro.formats.exchange import exported, is_own, read_source, source_checks
from vsb.engine.hydro.formats.wamit import import_wamit, wamit_texts
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError, DatabaseError
from vsb.tools import files, variables

PAIR, WAVE = ("influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")


HALF_DIGIT = 5e-7  # of seven significant digits


WATER = {"water_density": 1000.0, "gravity": 10.0, "water_depth": "inf"}


def assembled(labels, omega, directions=(0.0,), *, added, damping, force, stiffness, **more):
    """A hydro database of given arrays."""
    data = {
        "added_mass": (("omega", *PAIR), added),
        "radiation_damping": (("omega", *PAIR), damping),
        "excitation_force": (WAVE, force),
        "hydrostatic_stiffness": (PAIR, stiffness),
        **more,
    }
    coords = {"omega": list(omega), "wave_direction": list(directions), **{dof: list(labels) for dof in PAIR}}
    return variables.described(xr.Dataset(data, coords).assign_attrs(WATER))


def random_database(modes=2, frequencies=4, headings=1, seed=0, spread=0.0):
    """Random numbers over 10^±spread, in all that a database may hold."""
    rng, n = np.random.default_rng(seed), modes + 1

    def numbers(*shape):
        return rng.choice([-1, 1], shape) * rng.uniform(1, 10, shape) * 10.0 ** rng.uniform(-spread, spread, shape)

    def wave():
        shape = (frequencies, headings, n)
        return WAVE, numbers(*shape) + 1j * numbers(*shape)

    labels = ["Heave", *(f"Membrane{i}" for i in range(modes))]
    ds = assembled(
        labels,
        np.cumsum(rng.uniform(0.05, 1.0, frequencies)),
        np.linspace(-1.0, 2.0, headings),
        added=numbers(frequencies, n, n),
        damping=numbers(frequencies, n, n),
        force=wave()[1],
        stiffness=numbers(n, n),
        added_mass_inf=(PAIR, numbers(n, n)),
    )
    return variables.described(ds.assign(Froude_Krylov_force=wave(), diffraction_force=wave()))


def with_structure(ds, alpha=0.0, beta=0.0, heave_mass=4000.0):
    """The same with inertia, stiffness of structure, prestress and gas, heave apart, and the facts of a study."""
    n, modes = ds.sizes["influenced_dof"], np.arange(1.0, ds.sizes["influenced_dof"])
    inertia, stiffness = np.diag([heave_mass, *100 * modes]), np.diag([0.0, *1e5 * modes])
    prestress = 3e3 * (np.eye(n, k=1) + np.eye(n, k=-1))
    prestress[0, :] = prestress[:, 0] = 0.0
    dry = {"inertia_matrix": inertia, "structural_stiffness": stiffness}
    dry |= {"prestress_stiffness": prestress, "gas_stiffness": stiffness / 50}
    spec = json.dumps({"device": {"damping": {"alpha": alpha, "beta": beta}}})
    facts = {"radius": 2.0, "centre_height": 0.0, "spec": spec, "spec_id": "a" * 16, "quality": "[]"}
    return variables.described(ds.assign({name: (PAIR, m) for name, m in dry.items()}).assign_attrs(facts))


def written(folder, texts, name="buoy"):
    for extension, text in texts.items():
        (folder / f"{name}{extension}").write_text(text)
    return folder


def read_back(folder, ds, length=1.0):
    written(folder, wamit_texts(ds, "memory", length))
    labels = list(ds.influenced_dof.values)
    return import_wamit(folder, "buoy", density=1000.0, gravity=10.0, length=length, labels=labels)


def rows(text):
    """Numbers of a file without its header."""
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()[1:]])


def relative(values, reference):
    return np.max(np.abs(values - reference) / np.abs(reference))


@pytest.fixture
def stored(elastic, tmp_path):
    path = tmp_path / "db" / f"{'a' * 16}.nc"
    database.save_database(elastic, None, path)
    return path


ALL = ["buoy.1", "buoy.3", "buoy.3fk", "buoy.3sc", "buoy.hst", "buoy.mmx", "buoy.h5"]


def test_a_format_that_cannot_be_written_is_left_out(stored, elastic, tmp_path):
    with pytest.raises(ConfigError, match=r"length: received 0\.0, needs"):
        wamit_texts(elastic, "memory", 0.0)
    with pytest.raises(DatabaseError, match="needs 'c'"):
        exported(stored, tmp_path / "out", "buoy", expected_id="c")
    database.save_database(elastic.drop_vars("hydrostatic_stiffness"), None, stored)
    with pytest.raises(DatabaseError, match=rf"{re.escape(str(stored))}: holds no hydrostatic_stiffness; needs a"):
        exported(stored, tmp_path / "out", "buoy")
    files.save(elastic.drop_attrs().assign_attrs(spec_id="c"), tmp_path / "block.nc")
    with pytest.raises(DatabaseError, match=r"block\.nc: holds no rho, g, water_depth; needs a hydro database of"):
        exported(tmp_path / "block.nc", tmp_path / "out", "buoy")
    assert not (tmp_path / "out").exists()
    coupled = elastic.inertia_matrix + 10.0 * (np.eye(3, k=1) + np.eye(3, k=-1))
    database.save_database(elastic.assign(inertia_matrix=coupled), None, stored)
    found = exported(stored, tmp_path / "out", "buoy")
    assert any(
        re.match(rf"no .*: {re.escape(str(stored))}: .* couples rigid and generalized modes", line) for line in found
    )


def test_interrupted_export_leaves_the_old_file(tmp_path):
    path = tmp_path / "buoy.h5"
    path.write_text("old")
    with pytest.raises((TypeError, ValueError)):
        write_h5({"/first": np.ones((1, 1)), "/second": object()}, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_rotations_of_the_h5_file_are_about_the_centre_of_mass(ball, tmp_path, capsys):
    """Of capytaine's own file, which turns about a point 0.3 m below: as capytaine solves it about the centre of mass."""
    assert main(["export", str(ball), str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.split() == [
        str(tmp_path / "out" / f"ball{end}") for end in (".1", ".3", ".3fk", ".3sc", ".hst", ".h5")
    ]
    mesh = cpt.mesh_sphere(radius=1.0, resolution=(8, 8)).immersed_part()
    body = cpt.FloatingBody(
        mesh, lid_mesh=mesh.generate_lid(), dofs=cpt.rigid_body_dofs(rotation_center=(0, 0, -0.2)),
        center_of_mass=(0, 0, -0.2),
    )  # fmt: skip
    asked = {"omega": [1.0], "wave_direction": [0.0], "radiating_dof": ["Pitch"], "rho": [1025.0]}
    true = cpt.BEMSolver().fill_dataset(xr.Dataset(coords=asked), body, progress_bar=False)
    found, own = read_bemio(tmp_path / "out" / "ball.h5"), read_capytaine(ball)
    pitch = {"influenced_dof": "Pitch", "radiating_dof": "Pitch"}
    inertia = float(true.added_mass.sel(pitch).squeeze())
    assert float(found.added_mass.sel(pitch).sel(omega=1.0, method="nearest")) == pytest.approx(inertia, rel=1e-6)
    assert float(own.added_mass.sel(pitch).sel(omega=1.0)) > 1.4 * inertia
    moment = found.excitation_force.sel(influenced_dof="Pitch").isel(wave_direction=0).sel(omega=1.0, method="nearest")
    assert complex(moment) == pytest.approx(
        complex(true.excitation_force.sel(influenced_dof="Pitch").squeeze()), rel=1e-5
    )
    assert " rotations about 0 0 -0.5 modes " in (tmp_path / "out" / "ball.1").read_text().splitlines()[0]
    back = import_wamit(tmp_path / "out", "ball", density=1025.0, gravity=9.81)
    assert back.attrs["rotation_centre"] == [0.0, 0.0, -0.5]


def test_buoy_is_read_back_from_every_format(small, tmp_path):
    own = load_database(small.database.out, small.database.out.split("/")[-1].removesuffix(".nc"))
    exported(small.database.out, tmp_path, "buoy")
    water = small.study.water
    found = {
        "database": read_source("database", small.database.out, water),
        "wamit": read_source("wamit", str(tmp_path / "buoy"), water),
        "bemio": read_source("bemio", str(tmp_path / "buoy.h5"), water),
    }
    for kind, ds in found.items():
        assert ds.added_mass.values == pytest.approx(own.added_mass.values, rel=1e-5, abs=1e-2), kind
        checks, unseen = source_checks(ds)
        assert all(check.verdict != "fail" for check in checks), kind
        assert bool(unseen) == (kind != "database")
    written(tmp_path, wamit_texts(own, "memory", 2.0), "long")
    ds = read_source("wamit", str(tmp_path / "long"), water, 2.0)
    assert ds.added_mass.values == pytest.approx(own.added_mass.values, rel=1e-5, abs=1e-2)


def test_netcdf_files_of_capytaine_are_recognised(small, tmp_path):
    assert is_own(small.database.out)
    dataset().to_netcdf(tmp_path / "theirs.nc")
    assert not is_own(str(tmp_path / "theirs.nc"))
    assert read_source("database", str(tmp_path / "theirs.nc"), Water()).attrs["source"] == "capytaine"
    with pytest.raises(DatabaseError, match="cannot be read"):
        is_own(str(tmp_path / "nothing.nc"))
