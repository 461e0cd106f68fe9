"""Files that are damaged, absurd, or of two bodies: one line each, and nothing is read that need not be."""

import random

import netCDF4
import numpy as np
import pytest

from tests.hydro.formats.test_foreign import CIRCLE, LABELS, sound
from vsb.cli import main
from vsb.errors import DatabaseError
from vsb.hydro.formats.bemio import bemio_entries, read_bemio, write_h5
from vsb.hydro.formats.modes import LARGEST, checked
from vsb.hydro.formats.wamit import import_wamit, wamit_texts
from vsb.tools import files

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
        (
            "simulation_parameters/wave_dir",
            np.nan,
            r"wave directions \[ 0\. nan\] degrees; needs finite ones, none twice",
        ),
        ("simulation_parameters/wave_dir", 0.0, r"wave directions \[0\. 0\.\] degrees; needs finite ones, none twice"),
        ("simulation_parameters/w", np.nan, r"frequencies \[0\.5 1\.  nan\] rad/s; needs finite, ascending"),
        ("simulation_parameters/w", 1e200, r"/simulation_parameters/T differs from the periods of /simulation_para"),
        ("simulation_parameters/g", -9.81, r"gravity: received -9\.81, needs a positive number of m/s\^2"),
        ("simulation_parameters/g", np.inf, r"gravity: received inf, needs a positive number of m/s\^2"),
        (
            "simulation_parameters/rho",
            1e300,
            r"water_density: received 1e\+300, needs a positive number of kg/m\^3 from",
        ),
        ("body1/properties/cg", np.inf, r"centre_of_mass \[ 0\.  0\. inf\] m; needs three finite numbers"),
        ("body1/properties/cb", np.nan, r"centre_of_buoyancy \[ 0\.  0\. nan\] m; needs three finite numbers"),
        ("body1/properties/disp_vol", -4.0, r"displaced_volume -4\.0 m\^3; needs a finite one, not negative"),
        ("body1/properties/dof", 7.5, r"holds 7\.5 degrees of freedom; needs six rigid and a few more"),
        ("body1/properties/dof", 1e9, r"holds 1e\+09 degrees of freedom; needs six rigid and a few more"),
        ("body1/hydro_coeffs/added_mass/inf_freq", 1e300, r"added_mass_inf holds 1e\+303; no body has that"),
    ],
)
def test_absurd_facts_and_coordinates_are_refused(h5, tmp_path, name, value, message):
    spread = (lambda v: v.__setitem__((0, 0), value)) if "inf_freq" in name else set_to(value)
    path = edited(h5, tmp_path, name, spread)
    with pytest.raises(DatabaseError, match=rf"edited\.h5: {message}") as error:
        read_bemio(path)
    assert "\n" not in str(error.value)


def test_any_flipped_bit_ends_in_numbers_or_in_one_line(h5, tmp_path, capsys):
    """Fifty, seeded: exit code 0, 1 or 2, and nothing but one line if it is 2."""
    whole, path, codes = h5.read_bytes(), tmp_path / "flipped.h5", []
    for seed in range(50):
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


def test_what_hdf_says_of_a_damaged_file_is_one_line(h5, tmp_path, monkeypatch):
    """netCDF4 raises RuntimeError, not OSError, for chunks that cannot be decoded."""

    def broken(*_):
        raise RuntimeError("NetCDF: HDF error\n in two lines")

    monkeypatch.setattr("vsb.hydro.formats.bemio._from_bemio", broken)
    with pytest.raises(DatabaseError, match=r"cannot be read: NetCDF: HDF error in two lines; needs BEMIO's \.h5 file"):
        read_bemio(h5)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9, 0.999])
def test_a_cut_file_is_one_line(h5, tmp_path, part, capsys):
    data = h5.read_bytes()
    (tmp_path / "cut.h5").write_bytes(data[: int(part * len(data))])
    assert main(["import-bemio", str(tmp_path / "cut.h5"), str(tmp_path / "out.nc")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out.nc").exists()


def test_only_what_is_needed_is_read(h5, tmp_path):
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
    with pytest.raises(
        DatabaseError, match=r"/simulation_parameters/w has shape \(2000000000,\); needs at most 100000000"
    ):
        read_bemio(path)


def test_shapes_of_another_size_are_refused(h5, tmp_path):
    """As one of two bodies has them: six rows, twelve columns."""
    entries = bemio_entries(sound(("Heave",), (0.0,), omega=(0.5, 1.0), **FACTS).drop_vars("inertia_matrix"), "memory")
    place = "/body1/hydro_coeffs/added_mass/all"
    write_h5(entries | {place: np.zeros((6, 12, 2))}, tmp_path / "two.h5")
    with pytest.raises(DatabaseError, match=rf"two\.h5: {place} has shape \(6, 12, 2\); needs \(6, 6, 2\)"):
        read_bemio(tmp_path / "two.h5")


def test_numbers_no_body_has_are_refused():
    ds = sound()
    assert checked(ds.assign(added_mass=ds.added_mass * 0 + LARGEST), "memory").added_mass.values.max() == LARGEST
    with pytest.raises(DatabaseError, match=r"memory: added_mass holds 1\.01e\+40; no body has that"):
        checked(ds.assign(added_mass=ds.added_mass * 0 + 1.01 * LARGEST), "memory")


@pytest.mark.parametrize(
    ("omega", "needed"),
    [
        ([1e-6, 1e6], ""),
        ([0.0, 1e-6], ""),
        ([0.9e-6, 1.0], "needs them from 1e-06 to 1e+06."),
        ([0.0, 0.9e-6], "needs them from 1e-06 to 1e+06."),
        ([1.0, 1.1e6], "needs them from 1e-06 to 1e+06."),
        ([1.0, 1.0], "needs finite, ascending ones, none negative."),
        ([-1.0, 1.0], "needs finite, ascending ones, none negative."),
        ([], "needs finite, ascending ones, none negative."),
    ],
)
def test_the_lowest_and_the_highest_frequency_there_is(omega, needed):
    ds = sound(omega=(0.5, 1.0)).isel(omega=slice(len(omega))).assign_coords(omega=np.array(omega))
    if not needed:
        assert checked(ds, "memory").omega.values.tolist() == omega
        return
    with pytest.raises(DatabaseError) as refused:
        checked(ds, "memory")
    assert str(refused.value) == f"memory: frequencies {np.array(omega)} rad/s; {needed}"


def test_waves_come_from_somewhere():
    with pytest.raises(DatabaseError, match=r"memory: wave directions \[\] degrees; needs finite ones, none twice"):
        checked(sound().isel(wave_direction=[]), "memory")


@pytest.mark.parametrize("wrong", [[4000.0, 1.0], -1.0, np.nan, 1.01 * LARGEST])
def test_a_displaced_volume_is_one_number_not_negative(wrong):
    with pytest.raises(DatabaseError, match=r"memory: displaced_volume .* m\^3; needs a finite one, not negative"):
        checked(sound().assign_attrs(displaced_volume=wrong), "memory")
    checked(sound().assign_attrs(displaced_volume=0.0), "memory")


# --- WAMIT


def written(folder, texts):
    for extension, text in texts.items():
        (folder / f"body{extension}").write_text(text)
    return folder


@pytest.fixture
def wamit(tmp_path):
    return written(tmp_path, wamit_texts(sound(LABELS, CIRCLE).drop_vars("inertia_matrix"), "memory"))


@pytest.mark.parametrize("option", ["length", "density", "gravity"])
@pytest.mark.parametrize("value", ["1e308", "1e-308"])
def test_options_of_no_body_are_one_line(wamit, option, value, capsys):
    assert main(["import-wamit", str(wamit), "body", str(wamit / "out.nc"), f"--{option}", value]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"vsb: error: --{option}: received {float(value)}, needs a positive number of")
    assert error.endswith("from 1e-06 to 1e+06.\n")


@pytest.mark.parametrize("extension", [".1", ".3", ".hst"])
@pytest.mark.parametrize("part", [0.0, 0.4, 0.97])
def test_cut_text_is_one_line(wamit, extension, part, capsys):
    path = wamit / f"body{extension}"
    text = path.read_text()
    path.write_text(text[: int(part * len(text))])
    assert main(["import-wamit", str(wamit), "body", str(wamit / "out.nc"), "--density", "1000"]) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err.count("\n")) == ("", 1)


def test_a_sound_export_is_read_with_all_its_checks(wamit, capsys):
    assert main(["import-wamit", str(wamit), "body", str(wamit / "out.nc"), "--density", "1000"]) == 0
    out = capsys.readouterr().out
    assert out.count("ok  ") == 9
    assert "look at" not in out
    assert "not checked: density" in files.load(wamit / "out.nc").attrs["history"]


def two_bodies(folder, modes, stiffness):
    """WAMIT's files of modes that do not feel each other, with a diagonal stiffness."""
    one = "".join(f" 2.0 {i} {i} 1.0 0.5\n" for i in modes)
    force = "".join(f" 2.0 0.0 {i} 1.0 0.0 1.0 0.0\n" for i in modes)
    pairs = "".join(f" {i} {j} {stiffness.get((i, j), 0.0)}\n" for i in modes for j in modes)
    return written(folder, {".1": one, ".3": force, ".hst": pairs})


def read(folder):
    return import_wamit(folder, "body", density=1000.0, gravity=9.81)


TWELVE = range(1, 13)
BOTH = {(3, 3): 5.0, (4, 4): 2.0, (9, 9): 4.0, (10, 10): 1.0, (11, 11): 1.0}


@pytest.mark.parametrize(
    ("modes", "stiffness"),
    [
        (TWELVE, BOTH),
        (TWELVE, {**BOTH, (9, 11): -0.3, (10, 12): 0.2}),  # a centre of gravity off the axis
        (range(1, 19), {**BOTH, (16, 16): 1.0}),
        ((3, 9), {(3, 3): 5.0, (9, 9): 4.0}),  # heave of both only
    ],
)
def test_a_second_rigid_body_is_recognized(tmp_path, modes, stiffness):
    with pytest.raises(DatabaseError, match=r"body\.hst: modes \d+ to \d+ restore in heave, roll or pitch, apart from"):
        read(two_bodies(tmp_path, modes, stiffness))


@pytest.mark.parametrize(
    ("modes", "stiffness"),
    [
        (TWELVE, {**BOTH, (7, 7): 1.0}),  # a mode that is restored where surge is not
        (TWELVE, {**BOTH, (12, 12): 1.0}),
        (TWELVE, {**BOTH, (3, 9): 0.5}),  # shares a waterplane with heave
        (TWELVE, {(3, 3): 5.0}),  # bends under water
        (range(1, 12), BOTH),  # five modes
        ((3, 9), {(3, 3): 5.0, (9, 9): 4.0, (9, 3): 0.1}),
    ],
)
def test_generalized_modes_are_not_taken_for_a_second_body(tmp_path, modes, stiffness):
    assert read(two_bodies(tmp_path, modes, stiffness)).sizes["influenced_dof"] == len(modes)


@pytest.mark.parametrize("name", ["centre_of_buoyancy", "centre_of_mass"])
def test_a_centre_has_three_finite_numbers(name):
    for wrong in ([0.0, -1.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, np.nan], [0.0, 0.0, 1.01 * LARGEST]):
        with pytest.raises(DatabaseError, match=rf"memory: {name} .* m; needs three finite numbers"):
            checked(sound().assign_attrs({name: wrong}), "memory")
    checked(sound().assign_attrs({name: [0.0, 0.0, LARGEST]}), "memory")
