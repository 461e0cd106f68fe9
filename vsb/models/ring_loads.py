"""Loads of a study at rings of its shell, and the shell with what all its degrees do under them.

A clamp, a ring that is held, a take-off at a ring or between two, and the edges of a belt whose strain drives one load
the wall along lines. The modes of a study end at some degree; `vsb.engine.shell.rings` has the answer of all higher
ones.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.variables import PAIR
from vsb.engine.motion.take_off import BetweenPort, PortChoice, SeveralPorts, ShellPort, StrainPort
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.rings import HIGHEST, BeltLoad, RingLoad, RingModes, along_wall, normal_to_wall, vertical
from vsb.engine.shell.shell import Shell
from vsb.models.rest import loaded_shell
from vsb.study.specs import AnyBuoy

KEPT = 12
"""Shells whose modes of rings are kept."""


Load = RingLoad | BeltLoad


def ring_loads(study: AnyBuoy) -> tuple[Load, ...]:
    """Return the loads at rings of all designs, mooring and take-off, each once."""
    found: list[Load] = []
    for angle in np.deg2rad(sorted({angle for design in study.designs.values() for angle in design.clamp})):
        found += [normal_to_wall(angle), along_wall(angle)]
    held = study.pto.held
    if held is not None and held.place == "ring":
        found.append(vertical(np.deg2rad(held.colatitude)))
    found += [load for port in _ports(study.pto.port) for load in _of_port(port)]
    return tuple(dict.fromkeys(load for load in found if load.moves))


def _ports(port: PortChoice) -> list[PortChoice]:
    """The ports of a take-off."""
    return list(port.ports.values()) if isinstance(port, SeveralPorts) else [port]


def _of_port(port: PortChoice) -> list[Load]:
    """The loads of a take-off at rings; none of one elsewhere."""
    if isinstance(port, StrainPort):
        upper, lower = map(float, np.deg2rad(port.belt))
        return [BeltLoad(upper, lower, float(port.strain != "meridional"), float(port.strain != "hoop"))]
    if isinstance(port, BetweenPort):
        return [way(angle) for angle in np.deg2rad(port.between) for way in (normal_to_wall, along_wall)]
    if not isinstance(port, ShellPort):
        return []
    angle = np.deg2rad(port.colatitude)
    return [normal_to_wall(angle) if port.direction == "radial" else vertical(angle)]


def has_attachment_modes(study: AnyBuoy) -> bool:
    """Return whether all degrees of a study's shell answer its loads at rings: of a sphere with both branches of modes.

    Of other shapes, and of modes one asks for by name, those of the basis do.
    """
    return bool(study.flexible and study.device.shape is None and study.modes.basis == "full")


def with_rings(
    study: AnyBuoy, reference: ReferenceShell, degree: int | None = None, highest: int = HIGHEST
) -> ReferenceShell:
    """Return a shell at rest with the modes of the rings that a study loads.

    Parameters
    ----------
    reference : ReferenceShell
        Without them.
    degree : int, optional
        Above which they answer; by default the highest of its modes.
    highest : int
        Degree up to which they do; without one above the modes there are none.
    """
    basis = reference.basis
    if not basis.modes or not has_attachment_modes(study) or not (loads := ring_loads(study)):
        return reference
    above = basis.highest_degree if degree is None else degree
    if highest <= max(above, 1):
        return reference
    rings = _ring_modes(basis.shell, above, loads, _tension(study, reference, loads), highest)
    whole = replace(basis, rings=rings)
    stiffness = {name: np.pad(matrix, (0, len(rings.labels))) for name, matrix in reference.stiffness.items()}
    stiffness["structural"] = stiffness["structural"] + whole.of_rings(rings.stiffness)
    if "prestress" in stiffness:
        stiffness["prestress"] = stiffness["prestress"] + whole.of_rings(rings.prestress)
    return ReferenceShell(_with_basis(reference.shape, whole), stiffness)


@lru_cache(maxsize=KEPT)
def _ring_modes(
    shell: Shell, degree: int, loads: tuple[Load, ...], tension: tuple[float, ...], highest: int
) -> RingModes:
    """Modes of rings; the last are kept, for members of a campaign that differ by their take-off have the same."""
    return RingModes(shell, degree, loads, tension, highest)


def _with_basis(shape: DeformedShell, basis: ModeBasis) -> DeformedShell:
    """A shape with the modes of rings, which are at rest."""
    more = len(basis.labels) - len(shape.modal_amplitude)
    return replace(shape, basis=basis, modal_amplitude=np.pad(shape.modal_amplitude, (0, more)))


def _tension(study: AnyBuoy, reference: ReferenceShell, loads: tuple[Load, ...]) -> tuple[float, ...]:
    """Membrane force along the meridian at rings [N/m]; none of a shell linearised without its load."""
    if "prestress" not in reference.stiffness:
        return (0.0,) * len(loads)
    loaded, at = loaded_shell(study, reference.basis), np.array([load.colatitude for load in loads])
    if study.at_equilibrium:
        force, _ = loaded.elastic.linear_resultants(reference.modal_amplitude, at)
    else:
        force, _ = loaded.linear_resultants(at)
    return tuple(force.tolist())


class Stored(NamedTuple):
    """A shell at rest as a hydro database has it, with the modes of rings."""

    database: xr.Dataset
    shape: DeformedShell


def stored_with_rings(study: AnyBuoy, database: xr.Dataset, shape: DeformedShell, highest: int = HIGHEST) -> Stored:
    """Return the database and the shape of a study with the modes of the rings that it loads; they move no water."""
    names = [name for name in ("structural", "prestress") if f"{name}_stiffness" in database]
    none = dict.fromkeys(names, np.zeros((len(shape.basis.labels),) * 2))
    found = with_rings(study, ReferenceShell(shape, none), highest=highest)
    if found.basis.rings is None:
        return Stored(database, shape)
    own = len(shape.basis.labels)
    labels = list(map(str, database.influenced_dof.values))
    labels = [*labels[:own], *found.basis.rings.labels, *labels[own:]]
    whole = database.reindex(influenced_dof=labels, radiating_dof=labels, fill_value=0)
    added = {f"{name}_stiffness": found.stiffness[name] for name in names}
    added["inertia_matrix"] = found.basis.of_rings(found.basis.rings.inertia)
    for name, matrix in added.items():
        padded = np.pad(matrix, (0, len(labels) - len(matrix)))
        whole[name] = whole[name] + xr.DataArray(padded, dims=PAIR, coords={dim: whole[dim] for dim in PAIR})
    return Stored(whole, found.shape)
