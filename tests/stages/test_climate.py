"""The climate file of a campaign: recognised by its content, and the one that was planned with."""

import gzip
import hashlib
from pathlib import Path

import pytest

from vsb.errors import ConfigError
from vsb.stages.climate import read_climate
from vsb.study.specs import ClimateSpec

CLIMATES = Path(__file__).parents[2] / "config" / "climate"
BUOY = CLIMATES / "ndbc46042_1996_spectra.txt.gz"


def spec(path, form, gamma=None):
    """The specification of a climate file."""
    return ClimateSpec(form=form, gamma=gamma, contents=hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16])


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Two days of the buoy, unpacked."""
    path = tmp_path_factory.mktemp("climate") / "short.txt"
    path.write_text("".join(gzip.decompress(BUOY.read_bytes()).decode().splitlines(keepends=True)[:49]))
    return path


def test_changed_or_missing_climate_file_is_refused(short, tmp_path):
    planned, other = spec(short, "spectra"), tmp_path / "other.txt"
    other.write_text(short.read_text() + "\n")
    with pytest.raises(ConfigError, match=r"other.txt: changed since the run was planned; run vsb run CONFIG again"):
        read_climate(planned, str(other))
    with pytest.raises(ConfigError, match=r"nowhere.txt: cannot be read .*; needs the climate of the campaign"):
        read_climate(planned, str(tmp_path / "nowhere.txt"))
