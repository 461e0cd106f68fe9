"""Databases from other codes' files."""

from pathlib import Path

import xarray as xr

from vsb.hydro import database
from vsb.hydro.formats import bemio, foreign, wamit
from vsb.hydro.formats.modes import check_positive
from vsb.hydro.repairs import with_symmetric_stiffness
from vsb.tools.files import save

FACTS = {"density": "kg/m^3", "gravity": "m/s^2", "length": "m", "depth": "m"}
"""What WAMIT's files do not say of a run, and its units."""
Verdict = tuple[list[database.Check], list[str], list[str]]
"""Checks, what was left out of the file or of the checks, and what to look at where a check does not hold."""


def import_wamit(folder: str, name: str, out: str, *, axisymmetric: bool, **facts: float) -> Verdict:
    """Read WAMIT's output into a database file and return the verdict on it; facts of the run as in `FACTS`."""
    for option, unit in FACTS.items():
        check_positive(f"--{option}", facts[option], unit, infinite=option == "depth")
    ds = wamit.import_wamit(folder, name, labels=None, **facts)
    return _store_foreign(ds, out, axisymmetric, foreign.WAMIT_WORDS)


def import_bemio(path: str, out: str, *, axisymmetric: bool) -> Verdict:
    """Read BEMIO's .h5 into a database file and return the verdict on it."""
    return _store_foreign(bemio.read_bemio(path), out, axisymmetric, foreign.BEMIO_WORDS)


def _store_foreign(ds: xr.Dataset, out: str, axisymmetric: bool, words: dict[str, str]) -> Verdict:
    """Store a database of another code with the verdict of the identities that need no other data."""
    checks, missing = foreign.foreign_checks(ds, axisymmetric=axisymmetric)
    checks += with_symmetric_stiffness(ds)[1]
    notes = [ds.attrs["history"], *missing]
    attrs = {"quality": database.as_json(checks), "spec_id": Path(out).stem, "separate_sweep": 0}
    save(ds.assign_attrs(**attrs, history="; ".join(notes)), out)
    return checks, notes, [foreign.causes(check, words) for check in checks if check.verdict != "ok"]
