"""A site's year against the equation of motion, summed over every spectrum: of a body, and of several ports of a buoy."""

import gzip
from pathlib import Path

import numpy as np
import xarray as xr
import yaml
from scipy.optimize import minimize
from verification.conftest import SEED
from verification.multipoles import Shell, motion, strain_port

CONFIG = Path(__file__).parents[2] / "config"
DAMPING, STIFFNESS = 2.0e5, -5.0e4


def spectra(path):
    """Bands [rad/s] and mean densities [m^2 s] of NDBC's text; records with missing values left out."""
    with gzip.open(path, "rt") as file:
        head, *lines = (line.split() for line in file)
    hertz = np.array(head[4:], dtype=float)
    density = np.array([line[4:] for line in lines if line[0].isdigit()], dtype=float)
    middle = (hertz[1:] + hertz[:-1]) / 2
    edges = 2 * np.pi * np.array([1.5 * hertz[0] - 0.5 * hertz[1], *middle, 1.5 * hertz[-1] - 0.5 * hertz[-2]])
    return edges, density[(density < 900).all(axis=1)] / (2 * np.pi)


def power_of_year(ds, edges, density):
    """Mean power of the year [W] of the heaving float, c w^2 |z|^2 S dw over fine frequencies."""
    z = dict.fromkeys(("influenced_dof", "radiating_dof"), "Heave")
    step = 0.001
    omega = np.arange(max(edges[0], ds.omega.values[0]) + step / 2, min(edges[-1], ds.omega.values[-1]), step)
    here = ds.interp(omega=omega, method="cubic")
    force = here.excitation_force.sel(influenced_dof="Heave").isel(wave_direction=0)
    force = force.sel(complex="re").values + 1j * force.sel(complex="im").values
    inertia = float(ds.inertia_matrix.sel(z)) + here.added_mass.sel(z).values
    lossy = here.radiation_damping.sel(z).values + DAMPING
    moved = force / (-(omega**2) * inertia - 1j * omega * lossy + float(ds.hydrostatic_stiffness.sel(z)) + STIFFNESS)
    band = np.searchsorted(edges, omega) - 1
    each = density[:, band] @ (DAMPING * omega**2 * np.abs(moved) ** 2) * step
    return each.mean()


def test_year_of_a_body(agree, command, tmp_path, monkeypatch):
    """The floating cylinder in heave at NDBC 46042, 1996, under a given damper and spring."""
    study = yaml.safe_load((CONFIG / "float.yaml").read_text())
    study["body"] = {"file": {**study["body"]["file"], "modes": ["Heave"]}}
    study["designs"] = {"heave": {}}
    study["pto"] |= {"damping": DAMPING, "stiffness": STIFFNESS}
    (tmp_path / "float.yaml").write_text(yaml.safe_dump(study))
    site = CONFIG / "climate" / "ndbc46042_1996_spectra.txt.gz"
    year = {"campaign": "year", "study": "float.yaml", "climate": {"spectra": str(site)}, "tuning": ["fixed"]}
    (tmp_path / "year.yaml").write_text(yaml.safe_dump(year))
    monkeypatch.chdir(tmp_path)
    command("run", "year.yaml")
    with xr.open_dataset(tmp_path / "results" / "year" / "campaign.nc") as found:
        power = float(found.annual_mean_power.squeeze())
    (database,) = (tmp_path / "results" / "hydro" / "db").glob("*.nc")
    with xr.open_dataset(database) as ds:
        expected = power_of_year(ds, *spectra(site))
    agree("a year of a body", "mean power at NDBC 46042 [W]", power, expected, 1e-3)


def test_year_of_several_ports(agree, command, tmp_path, monkeypatch):
    """Heave and the change of area under a damper matrix, given and optimal, in five hours of NDBC 46042.

    The shell is one that carries its load, of 1 GPa and 20 mm.
    """
    site, degree = CONFIG / "climate" / "ndbc46042_1996_spectra.txt.gz", 6
    with gzip.open(site, "rt") as file:
        head, *lines = file.readlines()
    with gzip.open(tmp_path / "hours.txt.gz", "wt") as file:
        file.writelines([head, *lines[::1800]])
    edges, density = spectra(tmp_path / "hours.txt.gz")
    shell = Shell(young_modulus=1e9, thickness=0.02, mass=17170.0)
    area = strain_port(shell, degree, "area")
    width, parts = np.repeat(np.diff(edges), 8) / 8, np.arange(8) + 0.5
    omega = np.repeat(edges[:-1], 8) + width * np.tile(parts, len(edges) - 1)
    velocities, admittances = [], []
    for w in omega:
        water = motion(shell, 2 * np.pi / w, degree)
        stretch = water.modes.T @ area
        stretch[0] = 0.0
        one = water.network(np.column_stack([np.eye(len(stretch))[0], stretch]))
        velocities.append(one[0])
        admittances.append(one[1])
    velocity, admittance = np.array(velocities), np.array(admittances)
    band = np.repeat(density.mean(axis=0), 8) * width  # S dw, a^2 = 2 S dw

    def power(matrix: np.ndarray) -> float:
        moved = np.linalg.solve(np.eye(2) + admittance @ matrix, velocity[..., None])[..., 0]
        return float(band @ np.real(np.einsum("wi,ij,wj->w", moved.conj(), matrix, moved)))

    unit = 1 / np.sqrt(np.abs(np.einsum("wii->wi", admittance)).mean(axis=0))

    def full(x: np.ndarray) -> np.ndarray:
        factor = unit[:, None] * np.array([[x[0], 0.0], [x[1], x[2]]])
        return factor @ factor.T

    given = full(np.array([1.0, -0.5, 0.8]))
    starts = [(1.0, sign, size) for sign in (-1.0, 0.0, 1.0) for size in (0.1, 1.0, 10.0)]
    best = max(-minimize(lambda x: -power(full(x)), x, method="BFGS").fun for x in starts)
    device = {**SEED["device"], "young_modulus": 1e9, "thickness": 0.02}
    ports = {"frame": "heave", "wall": {"strain": "area"}}
    study = {**SEED, "device": device, "designs": {"VSWEC": {}}, "waves": [{"kind": "still"}]}
    study |= {"pto": {"ports": ports, "damping": given.tolist()}, "study": "two_ports"}
    (tmp_path / "two_ports.yaml").write_text(yaml.safe_dump(study))
    year = {"campaign": "year", "study": "two_ports.yaml", "climate": {"spectra": "hours.txt.gz"}}
    (tmp_path / "year.yaml").write_text(yaml.safe_dump({**year, "tuning": ["fixed", "one"]}))
    monkeypatch.chdir(tmp_path)
    command("run", "year.yaml")
    with xr.open_dataset(tmp_path / "results" / "year" / "campaign.nc") as found:
        own = found.annual_mean_power.squeeze()
        fixed, one = float(own.sel(tuning="fixed")), float(own.sel(tuning="one"))
        matrix = found.damper_matrix.sel(tuning="one").squeeze().values
    agree("a year of several ports", "mean power under a damper matrix [W]", fixed, power(given), 5e-4)
    agree("a year of several ports", "the same, under the optimal one", one, power(matrix), 5e-4)
    agree("a year of several ports", "the optimum, by BFGS from nine starts", power(matrix), best, 1e-4)
