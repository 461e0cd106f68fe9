"""Rule database: blocks merged, expressed in the modes, checked, stored with their verdict."""

import json
from collections.abc import Sequence

import xarray as xr

from vsb import __version__
from vsb.errors import DatabaseError
from vsb.hydro import database, quality
from vsb.scenes.rest import reference_shell
from vsb.stages.stage import stamp
from vsb.study.blocks import COARSEST_SWEEP
from vsb.study.specs import DatabaseSpec
from vsb.tools.files import load


def run(spec: DatabaseSpec, blocks: str, out: str) -> None:
    """Merge the blocks in a folder, express them in the modes, check them, and store them with their verdict.

    Raises
    ------
    DatabaseError
        If a block is missing or foreign, or a check fails that the study does not accept.
    """
    reference = reference_shell(spec)
    basis, water = reference.basis, spec.water
    found = {name: _block(f"{blocks}/{name}.nc", name) for name in (*spec.sweep, *spec.tabulated)}

    def in_modes(ids: Sequence[str]) -> xr.Dataset:
        return database.with_excitation(database.in_modes(database.merged_blocks([found[i] for i in ids]), basis))

    def complete(raw: xr.Dataset) -> xr.Dataset:
        return database.with_structure(database.with_symmetrized(raw), reference)

    everywhere = in_modes(spec.sweep)
    infinite = [block for block in spec.sweep if "omega" not in found[block].dims]
    tabulated = in_modes([*spec.tabulated, *infinite]) if spec.tabulated else None
    solver = str(json.loads(next(iter(found.values())).attrs["spec"])["solver"])
    precision = min(1.0, spec.tolerance / COARSEST_SWEEP) if solver == "spectral" else 1.0
    checks = [
        *quality.estimate_checks([block.attrs for block in found.values()], spec.tolerance),
        *quality.verdict(everywhere, tabulated, water.depth, water.density, water.gravity, precision),
    ]
    attrs = {
        "title": "hydro database of an axisymmetric shell in heave and its modes",
        "source": f"vsb {__version__}",
        **stamp(spec),
        "quality": database.as_json(quality.judged(checks, spec.accept)),
        "radius": spec.device.radius,
        "centre_height": spec.centre_height,
        "basis": spec.modes.basis if spec.modes else "rigid",
        "degree": spec.modes.degree if spec.modes else 1,
        "water_density": water.density,
        "water_depth": str(water.depth),
        "gravity": water.gravity,
        "solver": solver,
        "bem_seconds": sum(block.attrs["seconds"] for block in found.values()),
    }
    if tabulated is None:
        asked = complete(everywhere).sel(omega=slice(None, spec.omega_max + 1e-9))
        database.save_database(asked.assign_attrs(asked.attrs, **attrs), None, out)
    else:
        asked = complete(tabulated)
        database.save_database(asked.assign_attrs(asked.attrs, **attrs), complete(everywhere), out)


def _block(path: str, name: str) -> xr.Dataset:
    """The block of a name."""
    block = load(path)
    if (found := block.attrs.get("spec_id")) != name:
        raise DatabaseError(f"{path}: holds block {found}, needs {name}; delete it and run again.")
    return block
