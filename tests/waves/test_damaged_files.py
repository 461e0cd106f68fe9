"""Files of seas that are damaged at random: read, or refused in one line of our own words."""

import random
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from vsb.engine.waves.kinds import RecordedSea, TabulatedSea
from vsb.engine.waves.measured_spectra import read_spectra
from vsb.engine.waves.scatter import read_scatter
from vsb.errors import ConfigError

TIME = 0.5 * np.arange(64)
FREQUENCY = np.linspace(0.05, 0.4, 24)
DENSITY = 5e-4 / FREQUENCY**5 * np.exp(-1.25 * (0.1 / FREQUENCY) ** 4)
COLUMNS = "\n".join(f"{f:.4f}, {s:.5f}" for f, s in zip(FREQUENCY, DENSITY, strict=True))
NDBC = "#YY MM DD hh mm " + " ".join(f"{f:.4f}" for f in FREQUENCY) + "\n" + "\n".join(
    f"2020 01 01 {h:02d} 00 " + " ".join(f"{s:.3f}" for s in DENSITY) for h in range(6)
)  # fmt: skip
TEXTS = {
    "record": "time [ms];eta [cm]\n" + "\n".join(f"{1000 * t:.0f};{30 * np.cos(t):.3f}".replace(".", ",") for t in TIME),
    "dates": "time,eta\n" + "\n".join(f"2020-01-01 00:00:{t:04.1f},{0.3 * np.cos(t):.4f}" for t in TIME),
    "spectrum": f"omega [rad/s], S [m^2 s/rad]\n{COLUMNS}",
    "directions": "f, -30, 0, 30\n" + "\n".join(f"{f:.3f}, {s:.4f}, {2 * s:.4f}, {s:.4f}" for f, s in zip(FREQUENCY, DENSITY, strict=True)),
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
