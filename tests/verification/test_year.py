"""A site's year of a body against its equation of motion, summed over every spectrum of the file."""

import gzip
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

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
