"""The seas of a campaign's year, from the file it was planned with."""

from pathlib import Path
from typing import Literal

from vsb.engine.waves.climate import Climate
from vsb.engine.waves.measured_spectra import read_spectra
from vsb.engine.waves.scatter import Spectrum, read_scatter
from vsb.errors import ConfigError
from vsb.study.specs import ClimateSpec
from vsb.tools.files import sha256_of


def read_climate(spec: ClimateSpec, path: str) -> Climate:
    """Read the seas of a year from the file whose contents a specification names.

    Raises `ConfigError` if it holds others, or cannot be read.
    """
    try:
        found = sha256_of(path)[:16]
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); needs the climate of the campaign") from None
    if found != spec.contents:
        raise ConfigError(f"{path}: changed since the run was planned; run vsb run CONFIG again")
    return read_seas(path, spec.form, spec.gamma or 1.0)


def read_seas(path: str | Path, form: Spectrum | Literal["spectra"] = "spectra", gamma: float = 3.3) -> Climate:
    """Read the seas of a year.

    Parameters
    ----------
    path : str or Path
        Measured spectra, or a scatter table of Hs and Te.
    form : {'spectra', 'jonswap', 'pierson_moskowitz'}
        What the file holds: spectra, or a table whose seas have spectra of this shape.
    gamma : float
        Peakedness of JONSWAP spectra of a table.

    Raises
    ------
    ConfigError
        If the file cannot be read, or holds something else.
    """
    if form != "spectra":
        return read_scatter(path, form, gamma)
    return read_spectra(path)
