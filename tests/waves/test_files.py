"""Units, names and decimal commas of spectra and records as other programs write them; what is none is refused."""

import math
import random
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from vsb.engine.waves.kinds import Jonswap, RecordedSea, TabulatedSea
from vsb.engine.waves.measured_spectra import read_spectra
from vsb.engine.waves.scatter import read_scatter
from vsb.errors import ConfigError
from vsb.tools.units import Frequency, density, frequency, number, unit

HERTZ = np.linspace(0.05, 1.2, 231)
SEA = Jonswap(kind="jonswap", hs=1.0, tp=4.0)
DENSITY = 2 * np.pi * SEA.density(2 * np.pi * HERTZ)
TIME = 0.5 * np.arange(240)
ELEVATION = 0.3 * np.cos(2 * np.pi * TIME / 4.0) + 0.1 * np.cos(2 * np.pi * TIME / 7.5 + 1.0)


def columns(head, *values, between=",", digits=8):
    rows = [between.join(f"{one:.{digits}f}" for one in row) for row in zip(*values, strict=True)]
    return "\n".join([*([head] if head else []), *rows]) + "\n"


def of_file(kind, tmp_path, text):
    (tmp_path / "sea.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return {"spectrum": TabulatedSea, "record": RecordedSea}[kind](kind=kind, file=tmp_path / "sea.csv")


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("m^2/Hz", 1.0), ("m2 s", 1.0), ("M²/HZ", 1.0), ("(meter*meter)/hertz", 1.0), ("m^{2} s", 1.0),
        ("m^2 s/rad", 2 * math.pi), ("m**2.s.radian**-1", 2 * math.pi), ("m²·s·rad⁻¹", 2 * math.pi),
        ("m^2/(rad/s)", 2 * math.pi), ("cm^2/Hz", 1e-4), ("mm2 s", 1e-6), ("ft^2/Hz", 0.3048**2),
        ("m", None), ("J/m2/Hz", None), ("m2/Hz/deg", None), ("m2 s deg-1", None), ("m2/Hz/", None), ("m2/(Hz", None),
    ],
)  # fmt: skip
def test_densities_in_any_notation(text, meant):
    assert density(text, Frequency(1.0), False) == (None if meant is None else pytest.approx(meant))


def test_directional_densities_say_per_which_angle_and_frequency():
    """Per hertz and angle by default; over rad/s a density per radian alone does not say which radian it means."""
    hertz, angular = frequency("Hz"), frequency("rad s^-1")
    assert density("m2/Hz/degree", hertz, True) == pytest.approx(180 / math.pi)
    assert density("m2 s rad-1", hertz, True) == pytest.approx(1.0)
    assert density("m2 s/rad/deg", angular, True) == pytest.approx(360.0)
    assert density("m2 s rad-1", angular, True) is None
    assert density("m2 s", angular, False) == pytest.approx(2 * math.pi)


@pytest.mark.parametrize(
    ("cell", "value"), [("1,5", 1.5), ("1.5", 1.5), ("-1,5e-3", -1.5e-3), ("1,234.5", None), ("1_0", None)]
)
def test_decimal_commas(cell, value):
    assert number(cell) == value
    assert unit("4s") is None


SPECTRA = {
    "rad/s": columns("omega [rad/s],S [m^2 s/rad]", 2 * np.pi * HERTZ, DENSITY / 2 / np.pi),
    "per rad/s over Hz": columns("f [Hz],S [m^2 s/rad]", HERTZ, DENSITY / 2 / np.pi),
    "per Hz over rad/s": columns("w (rad/s),S (m^2/Hz)", 2 * np.pi * HERTZ, DENSITY),
    "per second over rad/s": columns("w (rad/s);S (m²·s)", 2 * np.pi * HERTZ, DENSITY / 2 / np.pi, between=";"),
    "periods": columns("T [s],S [m^2/Hz]", 1 / HERTZ[::-1], DENSITY[::-1]),
    "square centimetres": columns("f [Hz],S [cm^2/Hz]", HERTZ, 1e4 * DENSITY),
    "decimal commas": columns("f;S", HERTZ, DENSITY, between=";").replace(".", ","),
    "decimal commas between blanks": columns("", HERTZ, DENSITY, between=" ").replace(".", ","),
    "decimal commas between tabs": columns("f [Hz]\tS [m2/Hz]", HERTZ, DENSITY, between="\t").replace(".", ","),
    "units in a line of their own": columns("omega,S\n(rad/s),(m^2.s/rad)", 2 * np.pi * HERTZ, DENSITY / 2 / np.pi),
    "header as a comment": columns("# omega [rad/s] S [m^2 s/rad]", 2 * np.pi * HERTZ, DENSITY / 2 / np.pi, between=" "),
    "MHKiT": columns(",JONSWAP (4s)", HERTZ, DENSITY),
    "units in names": columns("freq_hz,energy density m^2/Hz", HERTZ, DENSITY),
    "a title": columns("Site A, 2010\n\nf [Hz],S [m^2/Hz]", HERTZ, DENSITY),
    "frequency and period": columns("T [s];f [Hz];E [m2/Hz];dir [deg]", 1 / HERTZ, HERTZ, DENSITY, HERTZ, between=";"),
    "quoted": '"f","S"\n' + "".join(f'"{f:.6f}","{s:.8f}"\n' for f, s in zip(HERTZ, DENSITY, strict=True)).replace(".", ","),
}  # fmt: skip
"""One sea: JONSWAP of Hs 1 m and Tp 4 s."""


@pytest.mark.parametrize("dialect", SPECTRA)
def test_one_spectrum_in_many_notations(dialect, tmp_path):
    """A factor 2 pi in the density is a factor 2.5 in Hs: units that a file states are read, not skipped."""
    wave = of_file("spectrum", tmp_path, SPECTRA[dialect])
    assert wave.hs == pytest.approx(1.0, rel=1e-3)
    assert 2 * np.pi / wave.omega == pytest.approx(3.618, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (columns("f [Hz],a [m]", HERTZ, DENSITY), r"a \[m\] is an amplitude and no density; needs S = a\^2/\(2 df\)"),
        (columns("f,amplitude", HERTZ, DENSITY), "amplitude is an amplitude and no density"),
        (columns("omega,S", HERTZ, DENSITY), r"of which omega and S state no unit; needs those of both, such as omega"),
        (columns("f,S [m^2 s/rad]", HERTZ, DENSITY), "of which f state no unit"),
        (columns("f [Hz],S [J/m^2/Hz]", HERTZ, DENSITY), r"sea.csv:1: received the unit 'J/m\^2/Hz' of S, needs"),
        (columns("f [Hz],S [m]", HERTZ, DENSITY), "is an amplitude and no density"),
        (columns("f [m],S [m2/Hz]", HERTZ, DENSITY), r"needs frequencies in Hz or rad/s, or periods in s, no f \[m\]"),
        (columns("f,S1,S2", HERTZ, DENSITY, DENSITY), "none of them known as a density; needs one"),
        (columns("f,S,E", HERTZ, DENSITY, DENSITY), "2 of them densities; needs one"),
        (columns("# all in rad/s and m^2 s/rad\nf,S", HERTZ, DENSITY), "sea.csv:1: .* states 'rad/s', but not of which"),
        (columns("", 2 * np.pi * HERTZ, DENSITY / 2 / np.pi), "Hs 0.9992 m with Te 0.5758 s, which are physically impossible"),
        (columns("f,S", HERTZ, DENSITY).replace("\n0.06", "\n0.06,1.0,", 1), "sea.csv:4: received .*, needs 2 cells"),
    ],
)  # fmt: skip
def test_what_a_spectrum_may_not_be_is_refused(text, message, tmp_path):
    with pytest.raises(ConfigError, match=message) as caught:
        of_file("spectrum", tmp_path, text)
    assert "\n" not in str(caught.value)


def test_a_spectrum_that_seems_to_go_on_is_noted(tmp_path):
    cut = np.argmax(DENSITY) + 2
    wave = of_file("spectrum", tmp_path, columns("f [Hz],S [m^2/Hz]", HERTZ[:cut], DENSITY[:cut]))
    assert any("of its peak: was the file cut?" in note for note in wave.file.notes)


@pytest.mark.parametrize("kind", ["spectrum", "record"])
def test_a_year_of_records_is_no_sea(kind, tmp_path):
    with pytest.raises(
        ConfigError, match=r"sea.csv:1: received many records, a row each, .* the climate of a campaign"
    ):
        of_file(
            kind, tmp_path, "#YY MM DD hh mm .05 .10 .15\n2020 01 01 00 00 1.0 2.0 1.0\n2020 01 01 01 00 1. 2. 1.\n"
        )


def test_columns_left_out_and_units_taken_are_noted(tmp_path):
    wave = of_file("spectrum", tmp_path, columns("f,S,phase", HERTZ, DENSITY, HERTZ))
    assert wave.file.notes == ("units that are not stated taken as Hz and m^2/Hz", "columns left out: phase")
    assert "columns left out: phase" in wave.description
    plain = of_file("spectrum", tmp_path, columns("", HERTZ, DENSITY))
    assert plain.file.notes == ()
    assert plain.label == wave.label  # the same sea, whatever its file says beside


RECORDS = {
    "plain": columns("", TIME, ELEVATION),
    "milliseconds": columns("time [ms],eta [m]", 1000 * TIME, ELEVATION),
    "centimetres": columns("t [s],eta [cm]", TIME, 100 * ELEVATION),
    "millimetres in a name": columns("time_s;elevation_mm", TIME, 1000 * ELEVATION, between=";").replace(".", ","),
    "feet": columns("t (s)\teta (ft)", TIME, ELEVATION / 0.3048, between="\t"),
    "days": columns("time [d],eta [m]", TIME / 86400, ELEVATION, digits=10),
    "dates": "time,eta\n" + "".join(f"2020-01-01 00:{t // 60:02.0f}:{t % 60:04.1f},{e:.8f}\n" for t, e in zip(TIME, ELEVATION, strict=True)),
    "dates between blanks": "".join(f"2020/01/01 00:{t // 60:02.0f}:{t % 60:04.1f} {e:.8f}\n" for t, e in zip(TIME, ELEVATION, strict=True)),
    "a temperature, in letters of older Windows": columns(
        "# Höhe der Boje\nt [s],eta [m],T [°C]", TIME, ELEVATION, TIME
    ).encode("cp1252"),
    "other columns": columns("t [s],wind [m/s],eta [m],flag", TIME, TIME, ELEVATION, TIME),
    "rounded times": columns("t,eta", TIME * 0.78125 / 0.5, ELEVATION, digits=2),
}  # fmt: skip
"""One record of two periods, 4 s and 7.5 s."""


@pytest.mark.parametrize("dialect", RECORDS)
def test_one_record_in_many_notations(dialect, tmp_path):
    wave = of_file("record", tmp_path, RECORDS[dialect])
    assert wave.hs == pytest.approx(4 * ELEVATION.std(), rel=2e-2)
    assert wave.file.step == pytest.approx(0.78125 if dialect == "rounded times" else 0.5, rel=1e-4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (columns("t [s],a [m/s^2]", TIME, ELEVATION), r"needs times in s and elevations in m, or units of these, no a"),
        (columns("t [s],eta [V]", TIME, ELEVATION), r"sea.csv:1: received the unit 'V' of eta, needs lengths"),
        (columns("t,eta1,eta2", TIME, ELEVATION, ELEVATION), "none of them known as an elevation"),
        (columns("t [s],eta1 [m],eta2 [m]", TIME, ELEVATION, ELEVATION), "2 of them elevations"),
        (columns("", 737791 + TIME / 86400, ELEVATION, digits=9), "which are physically impossible; needs time in s"),
        (columns("", TIME, ELEVATION, ELEVATION), "sea.csv:1: received .* needs two numbers"),
    ],
)
def test_what_a_record_may_not_be_is_refused(text, message, tmp_path):
    with pytest.raises(ConfigError, match=message) as caught:
        of_file("record", tmp_path, text)
    assert "\n" not in str(caught.value)


TIME_DAMAGED_FILES = 0.5 * np.arange(64)
FREQUENCY = np.linspace(0.05, 0.4, 24)
DENSITY_DAMAGED_FILES = 5e-4 / FREQUENCY**5 * np.exp(-1.25 * (0.1 / FREQUENCY) ** 4)
COLUMNS = "\n".join(f"{f:.4f}, {s:.5f}" for f, s in zip(FREQUENCY, DENSITY_DAMAGED_FILES, strict=True))
NDBC = "#YY MM DD hh mm " + " ".join(f"{f:.4f}" for f in FREQUENCY) + "\n" + "\n".join(
    f"2020 01 01 {h:02d} 00 " + " ".join(f"{s:.3f}" for s in DENSITY_DAMAGED_FILES) for h in range(6)
)  # fmt: skip
TEXTS = {
    "record": "time [ms];eta [cm]\n" + "\n".join(f"{1000 * t:.0f};{30 * np.cos(t):.3f}".replace(".", ",") for t in TIME_DAMAGED_FILES),
    "dates": "time,eta\n" + "\n".join(f"2020-01-01 00:00:{t:04.1f},{0.3 * np.cos(t):.4f}" for t in TIME_DAMAGED_FILES),
    "spectrum": f"omega [rad/s], S [m^2 s/rad]\n{COLUMNS}",
    "directions": "f, -30, 0, 30\n" + "\n".join(f"{f:.3f}, {s:.4f}, {2 * s:.4f}, {s:.4f}" for f, s in zip(FREQUENCY, DENSITY_DAMAGED_FILES, strict=True)),
    "table": "Title\nHs [m]/Te [s],<6,6-8,8-10,Total\n0-1,10,20,5,35\n1-2,-,30,15,45\n>2,<0.1,9.95,10,19.95\nTotal,10,60,30,100\n",
    "list": "dir,Hs,Tp,percent\n0,0.5,5.5,60\n0,1.5,7.5,30\n90,0.5,5.5,10\n",
    "series": "time,Hs (m),Te (s)\n" + "\n".join(f"2020-01-01 {h:02d}:00,{1 + 0.1 * h:.2f},7.{h}" for h in range(9)),
    "spectra": NDBC,
}  # fmt: skip
READERS = {
    "record": lambda path: RecordedSea(kind="record", file=path, repair=["gaps", "spikes"]),
    "spectrum": lambda path: TabulatedSea(kind="spectrum", file=path),
    "table": read_scatter,
    "spectra": read_spectra,
}
READERS |= {"dates": READERS["record"], "directions": READERS["spectrum"], "list": read_scatter, "series": read_scatter}
JUNK = [b"", b"x", b"-", b"nan", b"inf", b"-1", b"1e400", b"1e-320", b",", b";;", b"\t", b'"', b"[", b"<", b"\xff\xfe", b"\x00", b"\n\n", b"#", b"1,5", b"\xc2\xb2", b"Hs", b"Total", b"[m^2/Hz]"]  # fmt: skip
FOREIGN = re.compile(
    r"numpy|xarray|pandas|Errno|literal|convert|NoneType|ufunc|broadcast|dtype|HDF|codec|\n", re.IGNORECASE
)


def damaged(data, draw):
    """A file cut, with bytes changed, or with lines or cells lost, repeated or replaced."""
    lines = data.split(b"\n")
    at, kind = draw.randrange(len(lines)), draw.randrange(6)
    if kind == 0:
        return data[: draw.randrange(len(data))]
    if kind == 1:
        changed = bytearray(data)
        for _ in range(draw.randrange(1, 6)):
            changed[draw.randrange(len(changed))] = draw.randrange(256)
        return bytes(changed)
    if kind == 2:
        lines[at] = lines[draw.randrange(len(lines))]
    elif kind == 3:
        lines.insert(at, draw.choice(JUNK) * draw.randrange(1, 4))
    else:  # a cell, mostly of the first lines
        at = at if kind == 4 else min(at, 1)
        cells = re.split(rb"([,;\s]+)", lines[at])
        cells[draw.randrange(len(cells))] = draw.choice(JUNK)
        lines[at] = b"".join(cells)
    return b"\n".join(lines)


def refusal(reader, path):
    """What is said of a file that is refused, empty of one that is read; warnings are errors."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            reader(path)
    except ConfigError as error:
        return str(error).replace(str(path), "")
    return ""


@pytest.mark.parametrize("kind", TEXTS)
def test_damaged_texts(kind, tmp_path):
    draw, path = random.Random(len(kind)), tmp_path / "file.csv"
    path.write_text(TEXTS[kind])
    READERS[kind](path)
    for _ in range(30):
        path.write_bytes(damaged(TEXTS[kind].encode(), draw))
        assert not FOREIGN.search(refusal(READERS[kind], path))


def test_damaged_netcdf(tmp_path):
    time = np.array([f"2020-01-01T{h:02d}" for h in range(9)], dtype="datetime64[ns]")
    series = {
        name: ("time", values, {"units": unit})
        for name, values, unit in (("swh", np.linspace(1, 2, 9), "m"), ("mwp", np.linspace(6, 8, 9), "s"))
    }
    xr.Dataset(series, {"time": time}).to_netcdf(tmp_path / "series.nc")
    stored = Path(__file__).parents[1] / "data" / "spectra" / "ww3.nc"
    for data, reader in (((tmp_path / "series.nc").read_bytes(), read_scatter), (stored.read_bytes(), read_spectra)):
        draw, path = random.Random(1), tmp_path / "file.nc"
        for _ in range(10):
            path.write_bytes(damaged(data, draw))
            assert not FOREIGN.search(refusal(reader, path))
