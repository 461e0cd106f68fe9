"""Files that are damaged, absurd, or of two bodies: one line each, and nothing is read that need not be."""

import random

import netCDF4
import numpy as np
import pytest

from tests.hydro.formats.test_checks import CIRCLE, LABELS, sound
from vsb.cli import main
from vsb.engine.hydro.formats.bemio import bemio_entries, read_bemio, write_h5
from vsb.engine.hydro.formats.wamit import wamit_texts
from vsb.errors import DatabaseError

FACTS = {
    name: [0.0, 0.0, z]
    for name, z in {"centre_of_buoyancy": -2.0, "centre_of_mass": 0.5, "rotation_centre": 0.5}.items()
}


@pytest.fixture(scope="module")
def h5(tmp_path_factory):
    """A small .h5 file, most of it HDF's own."""
    path = tmp_path_factory.mktemp("h5") / "body.h5"
    ds = sound(("Surge", "Heave"), (0.0, 90.0), omega=(0.5, 1.0, 1.5), **FACTS).drop_vars("inertia_matrix")
    entries = bemio_entries(ds, "memory")
    write_h5({place: value for place, value in entries.items() if "impulse_response_fun" not in place}, path)
    return path


def edited(h5, folder, place, change):
    """A copy of the file with one dataset changed."""
    path = folder / "edited.h5"
    path.write_bytes(h5.read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        values = file[place][...]
        change(values)
        file[place][...] = values
    return path


def set_to(value):
    def change(values):
        values[-1] = value

    return change


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("simulation_parameters/wave_dir", np.nan, r"wave directions \[ 0\. nan\] degrees; needs finite ones, none"),
        ("simulation_parameters/wave_dir", 0.0, r"wave directions \[0\. 0\.\] degrees; needs finite ones, none twice"),
        ("simulation_parameters/w", np.nan, r"frequencies \[0\.5 1\.  nan\] rad/s; needs finite, ascending"),
        ("simulation_parameters/w", 1e200, r"/simulation_parameters/T differs from the periods of /simulation_para"),
        ("simulation_parameters/g", -9.81, r"gravity: received -9\.81, needs a positive number of m/s\^2"),
        ("simulation_parameters/g", np.inf, r"gravity: received inf, needs a positive number of m/s\^2"),
        ("simulation_parameters/rho", 1e300, r"water_density: received 1e\+300, needs a positive number of kg/m\^3"),
        ("body1/properties/cg", np.inf, r"centre_of_mass \[ 0\.  0\. inf\] m; needs three finite numbers"),
        ("body1/properties/cb", np.nan, r"centre_of_buoyancy \[ 0\.  0\. nan\] m; needs three finite numbers"),
        ("body1/properties/disp_vol", -4.0, r"displaced_volume -4\.0 m\^3; needs a finite one, not negative"),
        ("body1/properties/dof", 7.5, r"holds 7\.5 degrees of freedom; needs six rigid and a few more"),
        ("body1/properties/dof", 1e9, r"holds 1e\+09 degrees of freedom; needs six rigid and a few more"),
        ("body1/hydro_coeffs/added_mass/inf_freq", 1e300, r"added_mass_inf holds 1e\+303; no body has that"),
    ],
)
def test_implausible_facts_and_coordinates_are_refused(h5, tmp_path, name, value, message):
    spread = (lambda v: v.__setitem__((0, 0), value)) if "inf_freq" in name else set_to(value)
    path = edited(h5, tmp_path, name, spread)
    with pytest.raises(DatabaseError, match=rf"edited\.h5: {message}") as error:
        read_bemio(path)
    assert "\n" not in str(error.value)


def test_flipped_bits_end_in_a_database_or_in_one_line(h5, tmp_path, capsys):
    """Seeded: exit code 0, 1 or 2, and nothing but one line if it is 2."""
    whole, path, codes = h5.read_bytes(), tmp_path / "flipped.h5", []
    for seed in range(25):
        rng, data = random.Random(seed), bytearray(whole)
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        path.write_bytes(data)
        codes.append(main(["import-bemio", str(path), str(tmp_path / "out.nc")]))
        captured = capsys.readouterr()
        assert codes[-1] in (0, 1, 2), seed
        if codes[-1] == 2:
            assert (captured.out, captured.err.count("\n")) == ("", 1), seed
            assert captured.err.startswith("vsb: error: "), seed
    assert codes.count(2) > 0


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9, 0.99])
def test_cut_h5_file_is_refused_in_one_line(h5, tmp_path, part, capsys):
    data = h5.read_bytes()
    (tmp_path / "cut.h5").write_bytes(data[: int(part * len(data))])
    assert main(["import-bemio", str(tmp_path / "cut.h5"), str(tmp_path / "out.nc")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out.nc").exists()


def test_huge_datasets_are_not_read(h5, tmp_path):
    """Sixteen gigabytes beside the datasets, and the same under a name that is read."""
    path = tmp_path / "large.h5"
    path.write_bytes(h5.read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("many", 2_000_000_000)
        for name in ("/film/frames", "/simulation_parameters/more", "/body1/properties/more"):
            file.createVariable(name, "f8", ("many",), chunksizes=(1_000_000,))[-1] = 1.0
    assert read_bemio(path).equals(read_bemio(h5))
    entries = bemio_entries(sound(("Heave",), (0.0,), omega=(0.5, 1.0), **FACTS).drop_vars("inertia_matrix"), "memory")
    write_h5({place: value for place, value in entries.items() if not place.endswith("/w")}, path)
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("many", 2_000_000_000)
        file.createVariable("/simulation_parameters/w", "f8", ("many",), chunksizes=(1_000_000,))
    with pytest.raises(DatabaseError, match=r"/simulation_parameters/w has shape \(2000000000,\); needs at most"):
        read_bemio(path)


# --- WAMIT


def written(folder, texts):
    for extension, text in texts.items():
        (folder / f"body{extension}").write_text(text)
    return folder


@pytest.fixture
def wamit(tmp_path):
    return written(tmp_path, wamit_texts(sound(LABELS, CIRCLE).drop_vars("inertia_matrix"), "memory"))


@pytest.mark.parametrize("extension", [".1", ".3", ".hst"])
@pytest.mark.parametrize("part", [0.0, 0.4, 0.97])
def test_cut_text_is_refused_in_one_line(wamit, extension, part, capsys):
    path = wamit / f"body{extension}"
    text = path.read_text()
    path.write_text(text[: int(part * len(text))])
    assert main(["import-wamit", str(wamit), "body", str(wamit / "out.nc"), "--density", "1000"]) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err.count("\n")) == ("", 1)
