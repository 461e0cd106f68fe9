"""NEMOH's results as versions 2 and 3 write them: read to the digits printed, or refused in one line."""

import random
import re

import numpy as np
import pytest
from hydro.bodies.test_mesh_files import damaged

from vsb.cli import main
from vsb.engine.hydro.formats.nemoh import read_nemoh
from vsb.errors import DatabaseError
from vsb.tools.files import load

OMEGA = np.array([0.2, 0.4, 0.6])
MOTIONS = {"Heave": "1 0. 0. 1. 0. 0. 0.", "Pitch": "2 0. 1. 0. 0. 0. -7.5"}
CAL = """--- Environment ---
1000.0\t\t! RHO \t\t! KG/M**3 \t! Fluid specific volume
9.81\t\t! G\t\t\t! M/S**2\t! Gravity
{depth}\t\t! DEPTH\t\t\t! M\t\t! Water depth
0.\t0.\t\t! XEFF YEFF\t\t! M\t\t! Wave measurement point
--- Description of floating bodies ---
{count}\t\t! Number of bodies
{bodies}--- Load cases to be solved ---
1 3 0.2\t0.6\t\t! Freq type 1,2,3=[rad/s,Hz,s], Number of wave frequencies/periods, Min, and Max
2 0.0 90.0 ! Number of wave directions, Min and Max (degrees)
"""
BODY = """--- Body ---
Cylinder.dat\t\t! Name of mesh file
540\t300\t\t! Number of points and number of panels
2\t\t! Number of degrees of freedom
{motions}\t\t! Heave, Pitch about CdG
2\t\t! Number of resulting generalised forces
{motions}
0\t\t! Number of lines of additional information
"""


def tec(title, zones, axis="w (rad/s)", at=OMEGA):
    """A file of zones, each a title with its pairs of columns."""
    count = zones[0][1].shape[1] // 2
    lines = [f'VARIABLES="{axis}"  ', *(f'"A   1   {k + 1}" "B   1   {k + 1}"' for k in range(count))]
    for name, values in zones:
        lines.append(f'Zone t="{title}{name}",I=     3,F=POINT')
        lines += ["  ".join(f"{x: .7E}" for x in (w, *row)) for w, row in zip(at, values, strict=True)]
    return "\n".join(lines) + "\n"


def folder(place, bodies=1, *, depth="0.", small=False, axis="w (rad/s)", at=OMEGA, headings=(0.0, 90.0)):
    """A folder with heave and pitch of each body: numbers that tell motion, force and frequency."""
    n = 2 * bodies
    motions = "\n".join(MOTIONS.values())
    text = CAL.format(depth=depth, count=bodies, bodies=BODY.format(motions=motions) * bodies)
    results, mesh = (place / name for name in (("results", "mesh") if small else ("Results", "Mesh")))
    results.mkdir(parents=True)
    mesh.mkdir()
    (place / "Nemoh.cal").write_text(text)
    zones = []
    for i in range(n):
        values = np.array(
            [[[100 * (i + 1) + 10 * (j + 1) + k, (i == j) * (k + 1.0)] for j in range(n)] for k in range(3)]
        )
        zones.append((f"{i // 2 + 1:5d} in DoF {i % 2 + 1:3d}", values.reshape(3, -1)))
    (results / "RadiationCoefficients.tec").write_text(tec("Motion of body", zones, axis, at))
    forces = []
    for h, heading in enumerate(headings):
        values = np.array([[[1e3 * (j + 1) + 10 * h + k, -0.1 * (j + 1)] for j in range(n)] for k in range(3)])
        forces.append((f"{heading:9.3f} deg", values.reshape(3, -1)))
    (results / "ExcitationForce.tec").write_text(tec("Excitation force - beta =", forces, axis, at))
    for k in range(bodies):
        suffix = f"_{k}" if bodies > 1 else ""
        stiffness = np.diag([0, 0, 7.6e5, -3e7, -3.3e7, 0.0])
        rows = ["".join(f"{x:15.7E}" for x in row) for row in stiffness]
        (mesh / f"KH{suffix}.dat").write_text("\n".join(rows) + "\n")
        (mesh / f"Hydrostatics{suffix}.dat").write_text(
            " XF =   0.000 - XG =   0.000\n YF =   0.000 - YG =   0.000\n ZF =  -5.000 - ZG =  -7.500\n"
            " Displacement =  0.7764570E+03\n Waterplane area =  0.7764571E+02\n Mass = 0.7764570E+06\n"
        )
    return place


@pytest.mark.parametrize("small", [False, True])
def test_a_folder_of_one_body_is_read_number_by_number(tmp_path, small):
    ds = read_nemoh(folder(tmp_path / "buoy", small=small))
    assert ds.influenced_dof.values.tolist() == ["Heave", "Pitch"]
    assert ds.omega.values == pytest.approx(OMEGA)
    assert np.degrees(ds.wave_direction.values) == pytest.approx([0.0, 90.0])
    assert float(ds.added_mass.sel(radiating_dof="Heave", influenced_dof="Pitch")[1]) == 121.0
    assert np.diagonal(ds.radiation_damping.values[2]) == pytest.approx([3.0, 3.0])
    assert ds.excitation_force.values[2, 1, 1] == pytest.approx(2012 * np.exp(-0.2j))
    assert np.diag(ds.hydrostatic_stiffness.values) == pytest.approx([7.6e5, -3.3e7])
    assert (ds.attrs["water_density"], ds.attrs["water_depth"]) == (1000.0, "inf")
    assert ds.attrs["displaced_volume"] == pytest.approx(776.457)
    assert list(ds.attrs["rotation_centre"]) == [0.0, 0.0, -7.5]
    assert list(ds.attrs["centre_of_buoyancy"]) == [0.0, 0.0, -5.0]


def test_two_bodies_finite_depth_and_periods(tmp_path):
    """NEMOH 3 may write over periods, longest last; frequencies ascend here."""
    ds = read_nemoh(folder(tmp_path / "two", 2, depth="30.", axis="T (s)", at=2 * np.pi / OMEGA[::-1]))
    assert ds.influenced_dof.values.tolist() == ["body1__Heave", "body1__Pitch", "body2__Heave", "body2__Pitch"]
    assert ds.omega.values == pytest.approx(OMEGA, rel=1e-6)
    assert ds.added_mass.values[0, 0, 0] == 112.0
    assert ds.attrs["water_depth"] == "30.0"
    assert ds.attrs["displaced_volume_body2"] == pytest.approx(776.457)


def test_directions_given_again_and_files_that_are_missing_are_noted(tmp_path):
    place = folder(tmp_path / "buoy", headings=(0.0, 180.0, 360.0))
    (place / "Mesh" / "KH.dat").unlink()
    ds = read_nemoh(place)
    assert "left out: wave direction 360 degrees, which is 0 again; not there: KH.dat" in ds.attrs["history"]
    assert ds.sizes["wave_direction"] == 2
    assert "hydrostatic_stiffness" not in ds


def changed(place, name, old, new):
    path = place / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("Nemoh.cal", "1 0. 0. 1.", "1 0. 0. .5", r"Nemoh.cal, line 12: motion .*needs unit translations"),
        ("Nemoh.cal", "9.81", "g", r"Nemoh.cal, line 3: received 'g.*needs 1 finite numbers"),
        ("Results/RadiationCoefficients.tec", "Motion of body", "Motion", r"holds no zones of motion of body"),
        ("Results/RadiationCoefficients.tec", "w (rad/s)", "k (1/m)", r"needs w \(rad/s\), f \(Hz\), T \(s\)"),
        (
            "Results/ExcitationForce.tec",
            "2.0000000E-01",
            "2.1000000E-01",
            r"zone of other frequencies|other frequencies",
        ),
        ("Mesh/KH.dat", "7.6000000E+05", "*************", r"KH.dat, line 3: .*needs 6 finite numbers"),
    ],
)
def test_wrong_folders_are_refused_by_file_and_line(tmp_path, name, old, new, message):
    place = folder(tmp_path / "buoy")
    changed(place, name, old, new)
    with pytest.raises(DatabaseError, match=message):
        read_nemoh(place)


def test_damaged_folders_raise_lines_of_our_own(tmp_path):
    """Forty changes of its files: read, or one line that names the file."""
    place, chance = folder(tmp_path / "buoy"), random.Random(5)
    files = sorted(path for path in place.rglob("*") if path.is_file())
    for _ in range(40):
        path = chance.choice(files)
        whole = path.read_bytes()
        path.write_bytes(damaged(whole, chance))
        try:
            read_nemoh(place)
        except DatabaseError as error:
            assert str(place) in str(error)  # noqa: PT017
            assert not re.search(r"index|numpy|codec|unpack|NoneType|literal|could not", str(error))  # noqa: PT017
        path.write_bytes(whole)


def test_the_command_makes_a_database_and_others_name_the_folder(tmp_path, capsys):
    place, out = folder(tmp_path / "buoy"), tmp_path / "buoy.nc"
    assert main(["import-nemoh", str(place), str(out)]) in (0, 1)
    assert load(out).influenced_dof.values.tolist() == ["Heave", "Pitch"]
    capsys.readouterr()
    assert main(["import-wamit", str(place), "buoy", str(tmp_path / "other.nc")]) == 2
    assert "is a folder of NEMOH; use vsb import-nemoh" in capsys.readouterr().err
    assert main(["import-wamit", str(tmp_path), "buoy.hst", str(tmp_path / "other.nc")]) == 2
    assert "buoy.hst: is one of WAMIT's files; needs the name of all of them, buoy" in capsys.readouterr().err
