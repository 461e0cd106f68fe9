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

from vsb.engine.hydro.orders import ORDER
from vsb.engine.hydro.variables import PAIR
from vsb.engine.motion.take_off import BetweenPort, PortChoice, SeveralPorts, ShellPort, StrainPort
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.rings import (
    HIGHEST,
    AttachmentModes,
    BeltLoad,
    KinkModes,
    RingLoad,
    RingModes,
    along_wall,
    around_axis,
    normal_to_wall,
    vertical,
)
from vsb.engine.shell.shell import Shell
from vsb.models.rest import loaded_shell, order_bases, order_stiffness, side_by_side
from vsb.study.specs import AnyBuoy
from vsb.tools.arrays import FloatArray

KEPT = 12
"""Shells whose modes of rings are kept."""


Load = RingLoad | BeltLoad


def ring_loads(study: AnyBuoy) -> tuple[Load, ...]:
    """Return the loads at rings of all designs, mooring and take-off, each once."""
    found: list[Load] = []
    for angle in _clamps(study):
        found += [normal_to_wall(angle), along_wall(angle)]
    held = study.pto.held
    if held is not None and held.place == "ring":
        found.append(vertical(np.deg2rad(held.colatitude)))
    found += [load for port in _ports(study.pto.port) for load in _of_port(port)]
    return tuple(dict.fromkeys(load for load in found if load.moves))


def order_loads(study: AnyBuoy) -> tuple[RingLoad, ...]:
    """Return the loads at rings of all designs and take-off that go with cos(m theta), m >= 1, each once.

    A clamp holds a ring also around the axis; a port between two points of a meridian pulls at them in its plane.
    """
    found = [way(angle) for angle in _clamps(study) for way in (normal_to_wall, along_wall, around_axis)]
    between = [port for port in _ports(study.pto.port) if isinstance(port, BetweenPort)]
    found += [load for port in between for load in _of_port(port) if isinstance(load, RingLoad) and load.moves]
    return tuple(dict.fromkeys(found))


def _clamps(study: AnyBuoy) -> list[float]:
    """Colatitudes of the clamps of all designs [rad]."""
    return [float(np.deg2rad(at)) for at in sorted({at for one in study.designs.values() for at in one.clamp})]


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
    """Return whether all degrees of a study's shell answer its loads at rings: those with both branches of modes.

    Of modes one asks for by name those of the basis do.
    """
    return bool(study.flexible and study.modes.basis == "full")


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
    rings = attachment_modes(basis.shell, above, loads, _tension(study, reference, loads), highest)
    further = order_loads(study)
    orders = range(1, 1 + (study.modes.order if study.motion != "heave" and further else 0))
    tension = _tension(study, reference, further)
    whole = replace(
        basis,
        rings=rings,
        order_rings=tuple(_ring_modes(basis.shell, above, further, tension, highest, m) for m in orders),
    )
    stiffness = {name: np.pad(matrix, (0, len(rings.labels))) for name, matrix in reference.stiffness.items()}
    stiffness["structural"] = stiffness["structural"] + whole.of_rings(rings.stiffness)
    if "prestress" in stiffness:
        stiffness["prestress"] = stiffness["prestress"] + whole.of_rings(rings.prestress)
    return ReferenceShell(_with_basis(reference.shape, whole), stiffness)


_ring_modes, _kink_modes = lru_cache(KEPT)(RingModes), lru_cache(KEPT)(KinkModes)
"""Members of a campaign that differ by their take-off have the same."""


def _with_basis(shape: DeformedShell, basis: ModeBasis) -> DeformedShell:
    """A shape with the modes of rings, which are at rest."""
    more = len(basis.labels) - len(shape.modal_amplitude)
    return replace(shape, basis=basis, modal_amplitude=np.pad(shape.modal_amplitude, (0, more)))


def _tension(study: AnyBuoy, reference: ReferenceShell, loads: tuple[Load, ...]) -> tuple[float, ...]:
    """Membrane force along the meridian at rings [N/m]; none of a shell linearised without its load."""
    if "prestress" not in reference.stiffness:
        return (0.0,) * len(loads)
    return tension_at(
        loads, loaded_shell(study, reference.basis), reference.modal_amplitude if study.at_equilibrium else None
    )


def tension_at(loads: tuple[Load, ...], loaded: LoadedShell, at_rest: FloatArray | None) -> tuple[float, ...]:
    """Return the membrane force along the meridian at rings of a shell at rest, or of the undeformed one [N/m]."""
    at = np.array([load.colatitude for load in loads])
    elastic = loaded.elastic
    force, _ = loaded.linear_resultants(at) if at_rest is None else elastic.linear_resultants(at_rest, at)
    return tuple(force.tolist())


def attachment_modes(
    shell: Shell, degree: int, loads: tuple[Load, ...], tension: tuple[float, ...], highest: int = HIGHEST
) -> AttachmentModes:
    """Return what all degrees above one do under loads at rings, kept for shells of the same wall."""
    modes = _ring_modes if shell.rest is None else _kink_modes
    return modes(shell, degree, loads, tension, highest)


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
    families = order_bases(study, found.basis)
    labels = [*found.basis.labels, *(label for one in families for label in one.labels)]
    new = ~np.isin(labels, database.influenced_dof.values)
    whole = database.reindex(influenced_dof=labels, radiating_dof=labels, fill_value=0)
    if families:
        counts = [len(found.basis.labels), *(len(one.labels) for one in families)]
        of = np.repeat([0, *(one.signed for one in families)], counts)
        whole[ORDER] = whole[ORDER].copy(data=of)
    own = {f"{name}_stiffness": found.stiffness[name] for name in names}
    own["inertia_matrix"] = found.basis.of_rings(found.basis.rings.inertia)
    own["hydrostatic_stiffness"] = np.zeros_like(own["inertia_matrix"])
    stiffness = [order_stiffness(study, one, found) for one in families]
    for name, matrix in own.items():
        others = (
            one.inertia if name == "inertia_matrix" else each[name.removesuffix("_stiffness")]
            for one, each in zip(families, stiffness, strict=True)
        )
        added = np.where(np.logical_or.outer(new, new), side_by_side(matrix, *others), 0.0)
        whole[name] = whole[name] + xr.DataArray(added, dims=PAIR, coords={dim: whole[dim] for dim in PAIR})
    return Stored(whole, found.shape)
