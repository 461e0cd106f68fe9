"""Seas of a spectrum in a file: what is read, what it holds, directions, refusals, a study."""

import numpy as np
import pytest
import yaml
from conftest import SMALL

from vsb.engine.waves.kinds import Jonswap, TabulatedSea
from vsb.errors import ConfigError
from vsb.pipeline.graph import plan_for
from vsb.study.study import load, parse

HERTZ = np.linspace(0.05, 1.2, 400)
SAME = Jonswap(kind="jonswap", hs=0.4, tp=5.0, seed=3)
PLANAR = {"motion": "planar", "mooring": [2e4, 0, 0, 0, 0, 0], "pto": {"damping": 8000.0, "port": "surge"}}


def columns(density, head="frequency [Hz],density [m2/Hz]\n"):
    return head + "".join(f"{f:.8f},{s:.12e}\n" for f, s in zip(HERTZ, density, strict=True))


def table(density, directions):
    rows = [",".join(f"{one:.9e}" for one in row) for row in np.column_stack([HERTZ, density])]
    return "\n".join([",".join(["f", *map(str, directions)]), *rows])


def of_file(tmp_path, text, **keys):
    (tmp_path / "sea.csv").write_text(text)
    return TabulatedSea(kind="spectrum", file=tmp_path / "sea.csv", **keys)


@pytest.fixture
def density():
    return 2 * np.pi * SAME.density(2 * np.pi * HERTZ)


@pytest.mark.parametrize("head", ["frequency [Hz],density [m2/Hz]\n", "f S\n0 0\n", "", "# a buoy\n"])
def test_spectrum_of_a_file_is_the_sea_it_was_written_from(head, density, tmp_path):
    wave, fine = of_file(tmp_path, columns(density, head)), np.linspace(0.01, 12.0, 50001)
    assert wave.hs == pytest.approx(SAME.hs, rel=1e-3)
    assert 16 * np.trapezoid(wave.density(fine), fine) == pytest.approx(wave.hs**2, rel=1e-6)
    assert 1 / wave.omega == pytest.approx(np.trapezoid(wave.density(fine) / fine, fine) / (wave.hs**2 / 16), rel=1e-5)
    amplitude, expected = (one.components(7.0, 200.0)[1] for one in (wave, SAME))
    assert amplitude == pytest.approx(expected, abs=5e-3 * expected.max())
    for cut in (1.2, 2.0):
        assert wave.share_above(cut) == pytest.approx(SAME.share_above(cut), abs=2e-3)
        assert wave.share_above(cut) + wave.share_below(cut) == pytest.approx(1.0, abs=1e-12)


def test_a_triangle_by_hand(tmp_path):
    """S = 0, 3, 0 m^2/Hz at 0.1, 0.2, 0.3 Hz: m0 = 0.3 m^2, m_-1 = 30 (0.1 - 0.1 ln 2) + 30 (0.3 ln 1.5 - 0.1) m^2 s."""
    wave = of_file(tmp_path, "0.1 0\n0.2 3\n0.3 0\n")
    assert wave.hs == pytest.approx(4 * np.sqrt(0.3))
    inverse = 30 * (0.1 - 0.1 * np.log(2)) + 30 * (0.3 * np.log(1.5) - 0.1)
    assert 2 * np.pi / wave.omega == pytest.approx(inverse / 0.3)
    assert wave.share_below(0.3 * np.pi) == pytest.approx(1 / 8)  # of 0.15 Hz
    assert wave.directions == (0.0,)


def test_directions_are_those_of_the_table_at_each_frequency(density, tmp_path):
    """Long waves go to -30 degrees, short ones to 30 and 60 in parts of 1 and 3; the energy is that of all together."""
    short = HERTZ[:, None] > 0.22
    parts = np.where(short, [0.0, 0.0, 0.25, 0.75], [1.0, 0.0, 0.0, 0.0])
    wave = of_file(tmp_path, table(density[:, None] * parts / 30.0, [-30, 0, 30, 60]), direction=10.0, seed=2)
    assert wave.hs == pytest.approx(SAME.hs, rel=1e-3)
    assert wave.directions == (-20.0, 10.0, 40.0, 70.0)
    found = wave.realisation(7.0, 600.0)
    assert set(found.heading[found.omega < 2 * np.pi * 0.217]) == {-20.0}
    beyond, energy = found.omega > 2 * np.pi * 0.223, np.abs(found.amplitude) ** 2
    assert set(found.heading[beyond]) == {40.0, 70.0}
    share = energy[beyond & (found.heading == 70.0)].sum() / energy[beyond].sum()
    assert share == pytest.approx(0.75, abs=0.01)
    assert np.array_equal(found.heading, wave.realisation(7.0, 600.0).heading)


def test_a_buoy_that_heaves_takes_all_directions_together(density, tmp_path):
    (tmp_path / "sea.csv").write_text(table(np.outer(density, [0.2, 0.8]) / 90.0, [0, 90]))
    (tmp_path / "alone.csv").write_text(columns(density))
    for name in ("sea", "alone"):
        written = SMALL | {"waves": [{"kind": "spectrum", "file": f"{name}.csv"}]}
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(written))
    one, other = load(tmp_path / "sea.yaml"), load(tmp_path / "alone.yaml")
    assert one.waves[0].file.directions == ()
    assert one.waves[0].hs == pytest.approx(other.waves[0].hs, rel=1e-8)
    assert plan_for(parse(other.model_dump())).identity == plan_for(other).identity


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0.1 1\n0.2 x\n", r"sea.csv:2: received '0.2 x', needs 2 numbers of 0 or more"),
        ("0.1 1\n0.2 -1\n", r"sea.csv:2: received '0.2 -1', needs 2 numbers of 0 or more"),
        ("0.1 1 0.3\n0.2 1 0.4\n", r"sea.csv:1: received '0.1 1 0.3', needs 2 numbers of 0 or more, .*; a word and"),
        ("0.2 1\n0.1 1\n", r"sea.csv:2: received 0.1 Hz after 0.2 Hz, needs ascending frequencies"),
        ("0 1\n0.1 1\n", r"frequency.*greater than 0|received 0"),
        ("0.1 1\n", r"received 1 frequencies in sea.csv, needs 2 to 10000"),
        ("0.1 0\n0.2 0\n", r"variance_density: received 0 throughout, needs waves"),
        ("f 0 x 20\n0.1 1 1 1\n0.2 1 1 1\n", r"sea.csv:1: received 'f 0 x 20', needs a word and up to 72 directions"),
        ("f 0 10 30\n0.1 1 1 1\n0.2 1 1 1\n", r"sea.csv:1: received directions 10 to 20 degrees apart, needs equal"),
        ("f 0 10 20\n0.1 1 1 1\n0.2 1 1\n", r"sea.csv:3: received '0.2 1 1', needs 4 cells as the other rows have"),
    ],
)  # fmt: skip
def test_what_is_no_spectrum_is_refused(text, message, tmp_path):
    (tmp_path / "sea.csv").write_text(text)
    with pytest.raises(ConfigError, match=message):
        parse(SMALL | {"waves": [{"kind": "spectrum", "file": "sea.csv"}]}, source=str(tmp_path / "s.yaml"))


def test_directions_are_refused_where_they_cannot_be_followed(density, tmp_path):
    (tmp_path / "sea.csv").write_text(table(np.outer(density, [0.2, 0.8]) / 90.0, [0, 90]))
    wave = {"kind": "spectrum", "file": "sea.csv"}
    with pytest.raises(ConfigError, match=r"spreading: the file holds directions of its own; remove it"):
        parse(SMALL | PLANAR | {"waves": [wave | {"spreading": {"s": 4.0}}]}, source=str(tmp_path / "s.yaml"))
