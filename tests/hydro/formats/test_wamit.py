"""WAMIT's files written and read."""

from pathlib import Path

import numpy as np
import pytest
from hydro.formats.test_exchange import (
    HALF_DIGIT,
    PAIR,
    WATER,
    assembled,
    random_database,
    read_back,
    relative,
    rows,
    written,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.hydro.formats.wamit import import_wamit, wamit_texts
from vsb.errors import DatabaseError
from vsb.tools import files


def two_modes(**more):
    """Period 4 s, rho = 1000, g = 10: every number of the files can be worked out in the head."""
    omega = 2 * np.pi / 4
    return assembled(
        ["Heave", "Membrane0"],
        [omega],
        added=np.array([[[2000.0, -500.0], [-500.0, 4000.0]]]),
        damping=omega * np.array([[[1000.0, 250.0], [250.0, 3000.0]]]),
        force=1e4 * np.array([[[3.0 - 4.0j, 0.0 + 2.0j]]]),
        stiffness=1e4 * np.array([[4.0, -1.0], [-2.0, 8.0]]),
        added_mass_inf=(PAIR, np.array([[1000.0, 0.0], [0.0, 1000.0]])),
        **more,
    )


def test_files_of_two_modes_number_by_number():
    texts = wamit_texts(two_modes(), "memory")
    assert set(texts) == {".1", ".3", ".hst"}
    assert texts[".1"].splitlines()[1:] == [
        "  0.000000E+00     3     3  1.000000E+00",
        "  0.000000E+00     3     7  0.000000E+00",
        "  0.000000E+00     7     3  0.000000E+00",
        "  0.000000E+00     7     7  1.000000E+00",
        "  4.000000E+00     3     3  2.000000E+00  1.000000E+00",
        "  4.000000E+00     3     7 -5.000000E-01  2.500000E-01",
        "  4.000000E+00     7     3 -5.000000E-01  2.500000E-01",
        "  4.000000E+00     7     7  4.000000E+00  3.000000E+00",
    ]
    assert texts[".3"].splitlines()[1:] == [
        "  4.000000E+00  0.000000E+00     3  5.000000E+00  5.313010E+01  3.000000E+00  4.000000E+00",
        "  4.000000E+00  0.000000E+00     7  2.000000E+00 -9.000000E+01  0.000000E+00 -2.000000E+00",
    ]
    assert texts[".hst"].splitlines()[1:] == [
        "     3     3  4.000000E+00",
        "     3     7 -1.000000E+00",
        "     7     3 -2.000000E+00",
        "     7     7  8.000000E+00",
    ]
    for text in texts.values():
        assert "ULEN 1 density 1000 gravity 10 depth inf modes 3=Heave 7=Membrane0" in text.splitlines()[0]


def test_phase_convention_gives_the_same_force_in_time():
    ds = random_database(headings=2)
    for extension, name in ((".3", "excitation_force"), (".3fk", "Froude_Krylov_force"), (".3sc", "diffraction_force")):
        period, heading, mode, modulus, phase, re, im = rows(wamit_texts(ds, "memory")[extension]).T
        t, omega = 0.37, 2 * np.pi / period
        flat = ds[name].values[::-1].ravel()  # periods ascend, frequencies descend
        ours = np.real(flat * np.exp(-1j * omega * t)) / 1e4
        assert modulus * np.cos(omega * t + np.radians(phase)) == pytest.approx(ours, rel=1e-4)
        assert re * np.cos(omega * t) - im * np.sin(omega * t) == pytest.approx(ours, rel=1e-4)
        assert mode.astype(int).tolist() == [3, 7, 8] * 8
        assert np.unique(heading) == pytest.approx(np.degrees([-1.0, 2.0]))


def test_zero_frequency_is_a_limit(tmp_path):
    ds = random_database(modes=1, frequencies=2).assign_coords(omega=[0.0, np.pi])
    texts = wamit_texts(ds, "memory")
    lines = texts[".1"].splitlines()[1:]
    periods = ["-1.000000E+00", "0.000000E+00", "2.000000E+00"]
    assert [line.split()[0] for line in lines] == np.repeat(periods, 4).tolist()
    assert [len(line.split()) for line in lines] == [4] * 8 + [5] * 4
    assert float(lines[1].split()[3]) == pytest.approx(ds.added_mass.values[0, 0, 1] / 1000, rel=1e-6)
    assert len(rows(texts[".3"])) == 2
    back = import_wamit(written(tmp_path, texts), "buoy", density=1000.0, gravity=10.0)
    assert back.sizes["omega"] == 1
    assert back.added_mass_zero.values == pytest.approx(ds.added_mass.values[0], rel=1e-6)
    again = wamit_texts(back, "memory")
    assert again[".1"].splitlines()[1:] == lines
    assert back.attrs["history"] == "read from WAMIT's files buoy"


@settings(max_examples=10)
@given(st.integers(0, 3), st.integers(1, 5), st.integers(1, 3), st.integers(0, 10**6), st.sampled_from([0.3, 1.0, 7.0]))
def test_round_trip_to_the_digits_printed(tmp_path_factory, modes, frequencies, headings, seed, length):
    ds = random_database(modes, frequencies, headings, seed, spread=8.0)
    folder = tmp_path_factory.mktemp("wamit")
    back = read_back(folder, ds, length)
    assert relative(back.omega.values, ds.omega.values) <= HALF_DIGIT * 1.0001
    for name in ("added_mass", "added_mass_inf", "hydrostatic_stiffness"):
        assert relative(back[name].values, ds[name].values) <= HALF_DIGIT * 1.0001
    assert relative(back.radiation_damping.values, ds.radiation_damping.values) <= 2 * HALF_DIGIT * 1.0001
    for name in ("excitation_force", "Froude_Krylov_force", "diffraction_force"):
        assert relative(back[name].values.real, ds[name].values.real) <= HALF_DIGIT * 1.0001
        assert relative(back[name].values.imag, ds[name].values.imag) <= HALF_DIGIT * 1.0001
    assert set(back.data_vars) == set(ds.data_vars)
    for name in ("influenced_dof", "radiating_dof"):
        assert back[name].values.tolist() == ds[name].values.tolist()
    assert np.abs(back.wave_direction.values - ds.wave_direction.values).max() <= HALF_DIGIT * 2.0
    for name in ds.variables:
        assert (back[name].dims, back[name].attrs) == (ds[name].dims, ds[name].attrs)
    again = wamit_texts(back, "memory", length)
    for extension, text in wamit_texts(ds, "memory", length).items():
        kept = [0, 1, 2, 5, 6] if extension.startswith(".3") else slice(None)  # modulus and phase are of rounded parts
        for line, second in zip(text.splitlines()[1:], again[extension].splitlines()[1:], strict=True):
            assert np.array(line.split())[kept].tolist() == np.array(second.split())[kept].tolist()


FOREIGN = {
    ".1": """ WAMIT Numeric Output -- Filename  barge.1      01-Jan-2001  00:00:00
 -1.000000E+00     3     3  9.000000E+00
  0.000000E+00     1     1  5.000000E-01
  0.000000E+00     3     3  1.500000E+00
  0.000000E+00     3     9 -2.500000E-01
  0.000000E+00     9     9  1.000000E+00
  2.000000E+00     1     1  1.000000E+00  1.000000E+00
  2.000000E+00     3     3  2.000000E+00  3.000000E-01
  2.000000E+00     3     9  4.000000E-01  5.000000E-02
  2.000000E+00     9     9  6.000000D-01  7.000000D-02
  4.000000E+00     1     1  1.000000E+00  1.000000E+00
  4.000000E+00     3     3  2.500000E+00  3.500000E-01
  4.000000E+00     3     9  4.500000E-01  5.500000E-02
  4.000000E+00     9     9  6.500000E-01  7.500000E-02
""",
    ".3": """ WAMIT Numeric Output -- Filename  barge.3      01-Jan-2001  00:00:00
  2.000000E+00  9.000000E+01     1  1.000000E+00  9.000000E+01  0.000000E+00  1.000000E+00
  2.000000E+00  9.000000E+01     3  5.000000E+00  5.313010E+01  3.000000E+00  4.000000E+00
  2.000000E+00  9.000000E+01     9  2.000000E+00  1.800000E+02 -2.000000E+00  0.000000E+00
  4.000001E+00  9.000000E+01     1  1.000000E+00  9.000000E+01  0.000000E+00  1.000000E+00
  4.000001E+00  9.000000E+01     3  1.000000E+01 -5.313010E+01  6.000000E+00 -8.000000E+00
  4.000001E+00  9.000000E+01     9  1.000000E+00 -9.000000E+01  0.000000E+00 -1.000000E+00
""",
    ".hst": """ WAMIT -- Force Output File -- barge.hst      01-Jan-2001  00:00:00
     1     1   0.000000E+00
     3     3   7.000000E+00
     3     9   1.000000E+00
     9     3  -1.000000E+00
     9     9   2.000000E+00
     1     3   0.000000E+00
     1     9   0.000000E+00
     3     1   0.000000E+00
     9     1   5.000000E-01
""",
}


def test_output_of_wamit_with_generalized_modes(tmp_path):
    """ULEN = 2, rho = 1000, g = 10: rho L^3 = 8000 kg, rho g L^2 = 40000 N/m; of modes 1, 3 and 9, 1 is uncoupled."""
    ds = import_wamit(
        written(tmp_path, FOREIGN), "buoy", density=1000.0, gravity=10.0, length=2.0, depth=30.0, bodies=1
    )
    assert ds.influenced_dof.values.tolist() == ["Surge", "Heave", "Mode9"]
    assert ds.omega.values == pytest.approx([np.pi / 2, np.pi])
    assert ds.wave_direction.values == pytest.approx([np.pi / 2])
    assert ds.added_mass.values == pytest.approx(
        8000 * np.array([[[1, 0, 0], [0, 2.5, 0.45], [0, 0, 0.65]], [[1, 0, 0], [0, 2.0, 0.4], [0, 0, 0.6]]])
    )
    assert ds.added_mass_inf.values == pytest.approx(8000 * np.array([[0.5, 0, 0], [0, 1.5, -0.25], [0, 0, 1.0]]))
    long, short = ds.radiation_damping.values / np.pi
    assert short == pytest.approx(8000 * np.array([[1, 0, 0], [0, 0.3, 0.05], [0, 0, 0.07]]))
    assert long == pytest.approx(4000 * np.array([[1, 0, 0], [0, 0.35, 0.055], [0, 0, 0.075]]))
    assert ds.excitation_force.values[:, 0] == pytest.approx(4e4 * np.array([[-1j, 6 + 8j, 1j], [-1j, 3 - 4j, -2]]))
    assert ds.hydrostatic_stiffness.values == pytest.approx(4e4 * np.array([[0, 0, 0], [0, 7, 1], [0.5, -1, 2]]))
    assert ds.attrs["history"] == "read from WAMIT's files buoy; left out: zero frequency, not of all pairs"
    assert {name: ds.attrs[name] for name in WATER} == {**WATER, "water_depth": "30.0"}
    assert {name: ds[name].attrs["units"] for name in ds.data_vars} == {
        "added_mass": "kg",
        "added_mass_inf": "kg",
        "radiation_damping": "kg/s",
        "excitation_force": "N/m",
        "hydrostatic_stiffness": "N/m",
    }
    files.save(ds, tmp_path / "imported.nc")
    assert files.load(tmp_path / "imported.nc").equals(ds)


def edited(extension, old, new):
    assert old in FOREIGN[extension]
    return {**FOREIGN, extension: FOREIGN[extension].replace(old, new, 1)}


LINE = "  2.000000E+00     3     9  4.000000E-01  5.000000E-02\n"


FORCE = "  2.000000E+00  9.000000E+01     9  2.000000E+00  1.800000E+02 -2.000000E+00  0.000000E+00\n"


BROKEN = {
    "nan": (edited(".1", "4.000000E-01", "nan"), r"buoy\.1: the line that starts with \(2.0, 3, 9\) holds NaN; needs numbers"),
    "words": (edited(".1", "4.000000E-01", "********"), r"buoy\.1, line 9: .*is not of 4 or 5 finite numbers"),
    "columns": (edited(".1", "5.000000E-02", "1 2"), r"buoy\.1, line 9: .*needs numbers PER I J A, and B where PER > 0"),
    "no damping": (edited(".1", "  5.000000E-02", ""), r"buoy\.1, line 9: .*has no damping"),
    "half a mode": (edited(".1", "     3     9  4.0", "   3.5     9  4.0"), r"line 9: .*mode numbers that are not whole"),
    "mode zero": (edited(".1", "     3     9  4.0", "     0     9  4.0"), r"line 9: .*mode numbers that are not whole"),
    "repeated": (edited(".1", LINE, 2 * LINE), r"buoy\.1, line 10: .*repeats an earlier line"),
    "missing pair": (edited(".1", LINE, ""), r"buoy\.1: no line starts with \(2\.0, 3, 9\)"),
    "limit": (
        {**FOREIGN, ".1": "".join(line for line in FOREIGN[".1"].splitlines(True) if "-1.0" not in line and "0.000000E+00     3     9" not in line)},
        r"buoy\.1: no line starts with \(0\.0, 3, 9\); needs all periods, headings and modes",
    ),
    "period": (edited(".1", "-1.000000E+00", "-2.000000E+00"), r"buoy\.1: holds period -2; needs periods > 0, 0 or -1"),
    "no waves": ({**FOREIGN, ".1": "".join(FOREIGN[".1"].splitlines(True)[:6])}, r"buoy\.1: holds no period > 0; needs lines PER I J A B"),
    "nothing": ({**FOREIGN, ".1": "header\n"}, r"buoy\.1: holds no data; needs lines PER I J A"),
    "no force": (edited(".3", FORCE, ""), r"buoy\.3: no line starts with \(2\.0, 90\.0, 9\)"),
    "force nan": (edited(".3", "-2.000000E+00", "inf"), r"buoy\.3, line 4: .*is not of 7 finite numbers"),
    "modulus": (edited(".3", "  2.000000E+00  1.8", "  2.100000E+00  1.8"), r"buoy\.3, line 4: .*modulus that contradicts"),
    "force twice": (edited(".3", FORCE, 2 * FORCE), r"buoy\.3, line 5: .*repeats an earlier line"),
    "other periods": ({**FOREIGN, ".3": FOREIGN[".3"].replace("4.000001E+00", "4.001000E+00")}, r"buoy\.3: its periods are not those of .*buoy\.1"),
    "same periods": ({**FOREIGN, ".3": FOREIGN[".3"].replace("4.000001E+00", "2.000001E+00")}, r"buoy\.3: its periods are not those of"),
    "parts of another run": ({**FOREIGN, ".3fk": FOREIGN[".3"].replace("9.000000E+01  ", "0.000000E+00  ")}, r"buoy\.3fk: no line starts with"),
    "empty": ({**FOREIGN, ".3": "header\n"}, r"buoy\.3: holds no data; needs lines PER BETA I"),
    "stiffness": (edited(".hst", "     9     3  -1.000000E+00\n", ""), r"buoy\.hst: no line starts with \(9, 3\)"),
    "stiffness twice": (edited(".hst", "     9     3", "     3     9"), r"buoy\.hst, line 5: .*repeats an earlier line"),
    "stiffness nan": (edited(".hst", "7.000000E+00", "NaN"), r"buoy\.hst, line 3: .*is not of 3 finite numbers; needs numbers I J C"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_broken_files_are_refused_by_name_and_line(tmp_path, case):
    texts, message = BROKEN[case]
    with pytest.raises(DatabaseError, match=message) as error:
        import_wamit(written(tmp_path, texts), "buoy", density=1000.0, gravity=10.0, bodies=1)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("ending", [".1", ".3", ".hst"])
def test_a_last_number_that_lost_its_digits_is_refused(tmp_path, ending):
    """Cut in the last number; without its end of line alone the file is whole."""
    whole = FOREIGN[ending].rstrip("\n")
    folder = written(tmp_path, {**FOREIGN, ending: whole[:-2]})
    with pytest.raises(DatabaseError, match=rf"buoy\{ending}, line \d+: is shorter than those before, and has no end"):
        import_wamit(folder, "buoy", density=1000.0, gravity=10.0, bodies=1)
    written(tmp_path, {**FOREIGN, ending: whole})
    import_wamit(folder, "buoy", density=1000.0, gravity=10.0, bodies=1)


RM3 = Path(__file__).parents[2] / "data" / "rm3"


def rm3(folder, **changes):
    """RM3's files, with text exchanged in some of them: ending -> (old, new)."""
    for file in RM3.glob("rm3.*"):
        text = file.read_text() if file.suffix != ".nc" else ""
        old, new = changes.get(file.suffix[1:], ("", ""))
        assert old in text
        (folder / file.name).write_text(text.replace(old, new))
    return import_wamit(folder, "rm3", density=1000.0, gravity=9.81)


def test_rm3_published_numbers_of_two_bodies():
    """RM3, the published numbers: heave of float is mode 3, that of the spar mode 9, both translations."""
    ds = import_wamit(RM3, "rm3", density=1000.0, gravity=9.81)
    assert ds.influenced_dof.values.tolist() == ["body1__Heave", "body2__Heave"]
    assert np.diag(ds.hydrostatic_stiffness.values) == pytest.approx([285.5230 * 9810, 28.23846 * 9810])
    assert (ds.attrs["displaced_volume_body1"], ds.attrs["displaced_volume_body2"]) == (725.833, 886.687)
    assert ds.added_mass_inf.values[1, 1] == pytest.approx(8.918842e6)
    assert "centre_of_mass" not in ds.attrs


def test_masses_of_two_bodies(tmp_path):
    """Of a run with IALTFRC = 2: the first body 7e5 kg, the second 9e5 kg with a mooring of 3e4 N/m."""
    text = (RM3 / "rm3.mmx").read_text().replace("IALTFRC = 1", "IALTFRC = 2")
    rows = ["3 3 7.0E5 0.0 0.0", "3 9 0.0 0.0 0.0", "9 3 0.0 0.0 0.0", "9 9 9.0E5 0.0 3.0E4"]
    table = "\n".join([" External force matrices:", " I J MASS(I,J) DAMP(I,C) STIF(I,J)", *rows])
    for name in (".1", ".3", ".hst"):
        (tmp_path / f"rm3{name}").write_text((RM3 / f"rm3{name}").read_text())
    (tmp_path / "rm3.mmx").write_text(f"{text}\n{table}\n")
    ds = import_wamit(tmp_path, "rm3", density=1000.0, gravity=9.81)
    assert ds.inertia_matrix.values.tolist() == [[7e5, 0.0], [0.0, 9e5]]
    assert ds.structural_stiffness.values.tolist() == [[0.0, 0.0], [0.0, 3e4]]


def test_failed_periods_are_left_out(tmp_path):
    """All coefficients of two periods are NaN, in .1 and .3 alike, the first line of the file among them."""
    sound = rm3(tmp_path)
    periods = 2 * np.pi / sound.omega.values[[3, 7]]
    for name, columns in ((".1", 2), (".3", 4)):
        rows = [line.split() for line in (RM3 / f"rm3{name}").read_text().splitlines()[1:]]
        failed = [row for row in rows if np.isclose(float(row[0]), periods, rtol=1e-5).any()]
        for row in failed:
            row[-columns:] = ["NaN"] * columns
        kept = [row for row in rows if row not in failed]
        (tmp_path / f"rm3{name}").write_text("\n".join(map(" ".join, failed + kept)) + "\n")
    found = import_wamit(tmp_path, "rm3", density=1000.0, gravity=9.81)
    assert found.added_mass.values.tolist() == np.delete(sound.added_mass.values, [3, 7], axis=0).tolist()
    assert "left out: 2 periods, from " in found.attrs["history"]
    assert found.attrs["history"].endswith(" s, of which A and B are NaN")


def two_bodies(folder, modes=13):
    """Two bodies, the first with one generalized mode: A = n^2 in units of WAMIT of mode n, ULEN = 10 m."""
    pairs = [(i, j) for i in range(1, modes + 1) for j in range(1, modes + 1)]
    radiation = [
        f" {period:.6E} {i:5d} {j:5d} {(i == j) * i**2:.6E} {(i == j) * 0.1:.6E}"
        for period in (5.0, 8.0)
        for i, j in pairs
    ]
    force = [f" {period:.6E} 0.0 {i:5d} 1.0 0.0 1.0 0.0" for period in (5.0, 8.0) for i in range(1, modes + 1)]
    texts = {".1": radiation, ".3": force, ".hst": [f" {i:5d} {j:5d} {float(i == j):.6E}" for i, j in pairs]}
    return written(folder, {ending: "header\n" + "\n".join(lines) + "\n" for ending, lines in texts.items()})


def read_two(folder, **given):
    return import_wamit(folder, "buoy", density=1000.0, gravity=10.0, length=10.0, **given)


def test_roll_of_a_second_body_has_its_lengths_once_its_modes_are_known(tmp_path):
    """Mode 11 is roll of body 2 behind seven modes of body 1, one of twelve: 121 rho L^5, which L^3 would make 100 times less."""
    ds = read_two(two_bodies(tmp_path), modes=[7, 6])
    labels = ds.influenced_dof.values.tolist()
    assert labels[5:9] == ["body1__Yaw", "body1__Mode7", "body2__Surge", "body2__Sway"]
    inertia = dict(zip(labels, np.diagonal(ds.added_mass.values[0]), strict=True))
    assert inertia["body2__Roll"] == pytest.approx(121 * 1000.0 * 10.0**5)
    assert inertia["body1__Mode7"] == pytest.approx(49 * 1000.0 * 10.0**3)
    assert "body1 modes 1 to 7, body2 modes 8 to 13" in ds.attrs["history"]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, r"buoy.1: holds modes up to 13, and without .mmx nothing says of how many bodies; needs .*--bodies"),
        ({"bodies": 2}, r"holds modes up to 13 of 2 bodies, which have more than six each; needs .* such as 7,6"),
        ({"modes": [6, 6]}, r"received modes 6,6; needs the number of modes of each body"),
        ({"modes": [9, 4]}, r"received modes 9,4; needs .* six rigid ones among them"),
        ({"bodies": 3, "modes": [7, 6]}, r"received 3 bodies and modes of 2"),
        ({"modes": [7, 6], "labels": ["a"]}, r"is of 2 bodies; needs no labels"),
    ],
)
def test_bodies_are_asked_for_never_guessed(tmp_path, given, message):
    with pytest.raises(DatabaseError, match=message):
        read_two(two_bodies(tmp_path), **given)


def test_bodies_that_contradict_the_mmx_file_are_refused(tmp_path):
    rm3(tmp_path)
    with pytest.raises(DatabaseError, match=r"rm3.mmx: is of 2 bodies, received 1; needs the files of one run"):
        import_wamit(tmp_path, "rm3", density=1000.0, gravity=9.81, bodies=1)


def test_generalized_modes_of_one_body_need_no_more_than_that_there_is_one(tmp_path):
    assert read_two(two_bodies(tmp_path, 8), bodies=1).influenced_dof.values.tolist()[-2:] == ["Mode7", "Mode8"]


def test_fields_of_fortran_that_touch_are_read(tmp_path):
    """A sign ends the field before, 7.9-116 is 7.9E-116; digits that could be cut in two ways are refused."""
    texts = dict(FOREIGN)
    texts[".1"] = (
        texts[".1"]
        .replace("4.000000E-01  5.000000E-02", "4.000000E-01-5.000000E-02")
        .replace("7.000000D-02", "7.9-116")
    )
    texts[".3"] = (
        texts[".3"]
        .replace("5.000000E+00  5.313010E+01", "5.000000E+00 -5.313010E+01")
        .replace("6.000000E+00 -8.000000E+00", "6.000000E+00-8.000000E+00")
    )
    ds = import_wamit(written(tmp_path, texts), "buoy", density=1000.0, gravity=10.0, bodies=1)
    assert ds.radiation_damping.values[1, 1, 2] == pytest.approx(-0.05 * 1000 * np.pi)
    assert ds.radiation_damping.values[1, 2, 2] == pytest.approx(7.9e-116 * 1000 * np.pi)
    assert ds.excitation_force.values[0, 0, 1] == pytest.approx(1e4 * (6 + 8j))
    texts[".1"] = texts[".1"].replace("4.500000E-01  5.500000E-02", "123456.123456234567.123456")
    with pytest.raises(DatabaseError, match=r"line 13: .*is not of 4 or 5 finite numbers"):
        import_wamit(written(tmp_path, texts), "buoy", density=1000.0, gravity=10.0, bodies=1)


def test_haskinds_excitation_serves_where_there_is_no_other(tmp_path):
    folder = written(tmp_path, {ending: text for ending, text in FOREIGN.items() if ending != ".3"})
    with pytest.raises(DatabaseError, match=r"buoy\.3: cannot be read .*, nor is there a \.2"):
        import_wamit(folder, "buoy", density=1000.0, gravity=10.0, bodies=1)
    (folder / "buoy.2").write_text(FOREIGN[".3"])
    ds = import_wamit(folder, "buoy", density=1000.0, gravity=10.0, bodies=1)
    assert ds.excitation_force.values[0, 0, 1] == pytest.approx(1e4 * (6 + 8j))
    assert "excitation of .2, by Haskind's relation, as there is no .3" in ds.attrs["history"]
