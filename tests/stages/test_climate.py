"""Which reader a climate's file gets, and that it is the one planned with."""

import gzip
import hashlib
from pathlib import Path

import pytest

from vsb.errors import ConfigError
from vsb.stages.climate import read_climate
from vsb.study.specs import ClimateSpec

CLIMATES = Path(__file__).parents[2] / "config" / "climate"
BUOY = CLIMATES / "ndbc46042_1996_spectra.txt.gz"
TABLE = CLIMATES / "PacWave-South_Oregon_Wave-Resource.csv"


def spec(path, form, gamma=None):
    """What is planned with a file."""
    return ClimateSpec(form=form, gamma=gamma, contents=hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16])


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Two days of the buoy, unpacked."""
    path = tmp_path_factory.mktemp("climate") / "short.txt"
    path.write_text("".join(gzip.decompress(BUOY.read_bytes()).decode().splitlines(keepends=True)[:49]))
    return path


def test_text_of_a_buoy(short):
    climate = read_climate(spec(short, "spectra"), str(short))
    assert len(climate.hs) == 48 - sum("999" in line for line in short.read_text().splitlines()[1:])
    assert climate.hours.sum() == pytest.approx(1.0)


def test_a_table_is_of_the_form_planned():
    """The peak of JONSWAP seas is 3.3 times higher, nearly; heights are the table's own."""
    sharp, broad = (read_climate(spec(TABLE, form, 3.3), str(TABLE)) for form in ("jonswap", "pierson_moskowitz"))
    assert sharp.hs == pytest.approx(broad.hs)
    assert (sharp.density.max(axis=1) > 1.5 * broad.density.max(axis=1)).all()


def test_a_file_that_changed_is_refused(short, tmp_path):
    planned, other = spec(short, "spectra"), tmp_path / "other.txt"
    other.write_text(short.read_text() + "\n")
    with pytest.raises(ConfigError, match=r"other.txt: changed since the run was planned; run vsb run CONFIG again"):
        read_climate(planned, str(other))
    with pytest.raises(ConfigError, match=r"nowhere.txt: cannot be read .*; needs the climate of the campaign"):
        read_climate(planned, str(tmp_path / "nowhere.txt"))
