"""Measured spectra: the year of a buoy shipped with the package, other layouts, and files that are refused in one line."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from vsb.engine.waves.measured_spectra import read_ndbc
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError

SHIPPED = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
HEADER = "YY MM DD hh   .050   .100   .150\n"
ROWS = "96 01 01 00   1.00   2.00   0.50\n96 01 01 01   1.50   2.50   0.25\n"
TEXT = HEADER + ROWS
DENSITY = np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]])
"""Of the two records, per hertz [m^2/Hz]."""


def test_shipped_year():
    """Counts found in the file itself; variance of its first row, sum S df."""
    first = gzip.decompress(SHIPPED.read_bytes()).decode().splitlines()[1].split()[4:]
    climate = read_ndbc(SHIPPED)
    assert climate.density.shape == (8600, 38)
    notes = {"one record per 1 h, 72 of them not in the file", "8712 records, 112 with missing values left out"}
    assert notes <= set(climate.notes)
    assert climate.omega[[0, -1]] / (2 * np.pi) == pytest.approx([0.03, 0.40])
    assert climate.variance[0] == pytest.approx(sum(map(float, first)) * 0.01, rel=1e-12)
    assert float(climate.flux(Water()) @ climate.hours) == pytest.approx(26.5e3, rel=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        HEADER.replace("YY", "YYYY") + ROWS.replace("96 01", "1996 01"),
        HEADER.replace("YY MM DD hh", "#YY MM DD hh mm") + ROWS.replace(" 00  ", " 00 00 ").replace(" 01  ", " 01 00 "),
        b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode(),
        "\n" + HEADER + "# densities in m*m/Hz\n  \n" + ROWS + "\n",
        gzip.compress(TEXT.encode()),
        TEXT + "96 01 01 01   9.99   9.99   9.99\n",  # the second record of an instant
        TEXT + "96 01 01 02   999.0   9.99   9.99\n96 01 01 03   0.00   0.00   0.00\n",
        "#YY MM DD hh mm Sep_Freq  < spec_1 (freq_1) spec_2 (freq_2) ... >\n"
        "2020 01 01 00 00 0.1 1.00 (0.050) 2.00 (0.100) 0.50 (0.150)\n"
        "2020 01 01 01 00 0.1 1.50 (0.050) 2.50 (0.100) 0.25 (0.150)\n",
    ],
    ids=["four-digit years", "minutes", "Windows", "comments", "packed", "repeated", "missing and calm", "data_spec"],
)
def test_text_layouts(written, text):
    assert read_ndbc(written(text)).density * 2 * np.pi == pytest.approx(DENSITY, rel=1e-14)


def test_records_left_out_are_noted(written):
    rows = "96 01 01 01 1 1 2\n96 01 01 05 999.00 1 2\n96 01 01 06 .00 .00 .00\n"
    notes = "; ".join(read_ndbc(written(TEXT + rows)).notes)
    for note in (
        "1 records of an instant that has one already left out",
        "3 of them not in the file",
        "1 with missing values left out",
        "1 records of one value throughout left out",
        "0 days stand for a year: seasons are missing",
    ):
        assert note in notes


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "received 0 lines, needs a header"),
        ("YY MM DD hh hello\n96 01 01 00 1\n", ":1: received 'hello', needs a number"),
        ("#YY MM DD hh mm WDIR WSPD WVHT\n#yr\n20 01 01 00 00 9 2 1\n", "received the buoy's meteorological data"),
        (HEADER + ROWS + HEADER.replace(".050", ".040") + ROWS, ":4: received another header, needs one set"),
        ("YY MM DD hh 20. 10.\n96 01 01 00 1 2\n", ":1: received 2 frequencies from 20 to 10, needs them asc"),
        (
            "\n" + HEADER + "# a comment\n" + ROWS + "96 01 01 02 1.0\n",
            ":6: received 5 columns, needs 7 as the hea",
        ),
        (TEXT + "96 01 01 02 1.0 x 2\n", ":4: received 'x', needs a number"),
        (TEXT + "96 01 01 02 1.0 -1 2\n", ":4: received -1, needs a number of 0 or more"),
        (TEXT + "96 13 01 02 1.0 1 2\n", ":4: received the date '96 13 01 02', needs YY MM DD"),
        (HEADER + "96 01 01 00 999 999 999\n", "received 1 records, none with a spectrum"),
        (
            HEADER + ROWS.replace("0.50", "900.").replace("0.25", "900."),
            "records that are physically impossible, as Hs .* needs frequenc",
        ),
        (gzip.compress(TEXT.encode())[:-12], "a packed file that is cut or damaged, needs a whole one"),
        (b"\x89HDF\xff\xfe\x80\x81", "that is no text, needs UTF-8"),
    ],
)
def test_text_errors_are_one_line(written, text, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_ndbc(written(text))
    assert "\n" not in str(caught.value)
    assert "given.txt" in str(caught.value)


BANDS = 0.03 + 0.02 * np.arange(20)


def same_header(values):
    head = "#YY  MM DD hh mm " + " ".join(f"{f:.4f}" for f in BANDS)
    return head + "\n" + "".join(f"2020 01 01 {h:02d} 00 {' '.join(map(str, row))}\n" for h, row in enumerate(values))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (same_header(np.full((6, 20), 0.8) - 0.01 * np.arange(20)), r"numbers up to 0.8 .* coefficients r1 or r2 \(swr1"),
        (same_header(np.full((6, 20), 80) - np.arange(20)), "up to 80 with a median of 70.5, which are .* in hundredths"),
        (same_header(np.full((6, 20), 280.0) - np.arange(20)), r"which are directions in degrees \(swdir, swdir2\), no dens"),
        ("#YY MM DD hh mm alpha1_1 (freq_1) alpha1_2 (freq_2) ... >\n2020 01 01 00 00 281.0 (0.033) 290.0 (0.038)\n",
         r":1: received mean directions \(swdir\), no densities; needs the spectral wave density \(swden\)"),
    ],
)  # fmt: skip
def test_files_of_directions_are_not_read_as_densities(written, text, message):
    """Their headers are those of densities: r1 of a year read as densities was a sea of 2.35 m in place of 1.74 m."""
    with pytest.raises(ConfigError, match=message):
        read_ndbc(written(text))
    jonswap = 5.0 * (BANDS / 0.1) ** -5.0 * np.exp(-1.25 * (BANDS / 0.1) ** -4.0)
    for height in (0.02, 1.0, 20.0):  # calm seas have small densities, too
        assert read_ndbc(written(same_header(np.round(height * np.outer(np.ones(6), jonswap), 6)))).hs.size == 6


def test_a_file_most_of_whose_records_cannot_be_used_is_doubted(written):
    rows = "".join(f"96 01 01 {h:02d} 999.0 1.0 1.0\n" for h in range(2, 9))
    assert any(
        "2 of 9: more than half of the records are not used" in note for note in read_ndbc(written(TEXT + rows)).notes
    )
