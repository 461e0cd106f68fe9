"""The seas of a campaign's year, from the file it was planned with."""

from vsb.errors import ConfigError
from vsb.study.specs import ClimateSpec
from vsb.tools.bounded import open_regular, sha256_of
from vsb.waves.climate import Climate
from vsb.waves.ndbc import SWAN, read_ndbc, read_spectra
from vsb.waves.scatter import read_scatter

NETCDF = (b"CDF", b"\x89HDF")
"""What netCDF files begin with."""


def read_climate(spec: ClimateSpec, path: str) -> Climate:
    """Read the seas of a year from the file whose contents a specification names.

    Raises
    ------
    ConfigError
        If it holds others, or cannot be read.
    """
    try:
        found = sha256_of(path)[:16]
        with open_regular(path) as file:
            begin = file.read(len(SWAN))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); needs the climate of the campaign") from None
    if found != spec.contents:
        raise ConfigError(f"{path}: changed since the run was planned; run vsb run CONFIG again")
    if spec.form != "spectra":
        return read_scatter(path, spec.form, spec.gamma or 1.0)
    return read_spectra(path) if begin.startswith((*NETCDF, SWAN)) else read_ndbc(path)
