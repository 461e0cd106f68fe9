"""Where a buoy rests and what holds it: degrees of freedom, equilibrium, stiffness and mooring, checks of stability.

A buoy heaves with its axisymmetric shell modes; one that also moves along and across the waves has further degrees of
freedom, azimuthal order by order.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import block_diag, null_space

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.orders import ORDER
from vsb.engine.hydro.variables import PAIR
from vsb.engine.motion.forces import loss, stiffening
from vsb.engine.motion.frequency import allowed_part, compliance, softest, unrestrained_motions
from vsb.engine.motion.linear import gas_compliance
from vsb.engine.motion.port import port_direction
from vsb.engine.motion.take_off import BetweenPort, PortChoice, ShellPort, StrainPort
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.device import Device
from vsb.engine.shell.loaded import (
    Buckling,
    ElasticShell,
    LoadedShell,
    buckling,
    complete_shell,
    equilibrium,
    equilibrium_near,
)
from vsb.engine.shell.lobes import with_lobes
from vsb.engine.shell.modes import Mode, ModeBasis, mode_basis, rigid_basis
from vsb.engine.shell.orders import OrderBasis, ballast_of, order_basis, prestress_stiffness, yaw
from vsb.engine.shell.rings import (
    HIGHEST,
    AttachmentModes,
    BeltLoad,
    KinkModes,
    Load,
    PressureLoad,
    RingLoad,
    RingModes,
    along_wall,
    around_axis,
    normal_to_wall,
    vertical,
)
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError, ConvergenceError
from vsb.study.resolution import loaded_at_ring, wet_degree
from vsb.study.sections import RIGID
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

# degrees of freedom -------------------------------------------------------------------------------------------------


def study_basis(study: Study) -> ModeBasis:
    """Return the union of the axisymmetric modes of all designs of a study."""
    if not study.flexible:
        return rigid_basis(study.device)
    return mode_basis(study.device, study.modes.basis, study.modes.max_degree)


def order_bases(study: Study, basis: ModeBasis) -> tuple[OrderBasis, ...]:
    """Return the degrees of freedom beside heave and axisymmetric modes, order by order; none of heave alone.

    A buoy that is free has each order twice, to both sides, and yaw.
    """
    if study.motion == "heave":
        return ()
    ballast, highest = ballast_of(study.device), study.modes.order if basis.modes else 1
    even = [order_basis(basis, order, ballast) for order in range(1, highest + 1)]
    if study.motion == "planar":
        return tuple(even)
    return (*(each for one in even for each in (one, one.turned())), yaw(basis, ballast))


def side_by_side(own: FloatArray, *others: FloatArray) -> FloatArray:
    """Return the block-diagonal matrix of the axisymmetric part and of further orders, if there are any."""
    return np.asarray(block_diag(own, *others)) if others else own


def whole_labels(study: Study, reference: ReferenceShell) -> tuple[str, ...]:
    """Return the names of the degrees of freedom of all orders, axisymmetric ones first."""
    others = (label for basis in order_bases(study, reference.basis) for label in basis.labels)
    return (*reference.basis.labels, *others)


def design_motions(study: Study, basis: ModeBasis, design: str) -> FloatArray:
    """Return the motions a design allows, shape (dof, free) [-]: heave alone, or heave and the unclamped modes.

    Likewise of the other azimuthal orders, where the buoy moves in more directions; less what the mooring holds. Raises
    `ConfigError` if the clamps leave no shell mode free.
    """
    chosen, clamps = study.designs[design], np.deg2rad(study.designs[design].clamp)
    loaded = loaded_at_ring(study, design)
    others = (order.allowed(chosen.flexible, clamps, loaded) for order in order_bases(study, basis))
    if not chosen.flexible:
        return side_by_side(np.eye(len(basis.labels), 1), *others)
    free = basis.clamped(clamps) if chosen.clamp else np.eye(len(basis.labels))
    if basis.rings and not loaded and not basis.rings.wet:
        free = free[:, : -len(basis.rings.labels)]
    if free.shape[1] < 2:
        raise ConfigError(
            f"designs.{design}.clamp: received {list(chosen.clamp)}, which leaves none of the {len(basis.modes)} shell "
            f"modes free; use fewer clamps, a larger modes.degree, or flexible: false"
        )
    if (held := mooring_rows(study, basis)).size:
        free = free @ null_space(held @ free)
    return side_by_side(free, *others)


def mooring_rows(study: Study, basis: ModeBasis) -> FloatArray:
    """Return what `pto.held` holds at zero of heave and axisymmetric modes, Phi q = 0, shape (constraint, dof) [-]."""
    held = study.pto.held
    if held is None:
        return np.zeros((0, len(basis.labels)))
    if held.place == "heave":
        return np.eye(1, len(basis.labels))
    at = np.deg2rad([held.colatitude])
    radial, meridional = basis.ring_displacement(at)
    return np.asarray((radial * np.cos(at) - meridional * np.sin(at)).T)


def motions_to_degree(study: Study, basis: ModeBasis, design: str, degree: int) -> FloatArray:
    """Return the motions a heaving design has with the shell modes to a degree, in a basis of more, (dof, free) [-].

    Raises `ConfigError` if the clamps leave none of those modes free.
    """
    smaller = replace(mode_basis(study.device, study.modes.basis, degree), rings=basis.rings)
    motions = design_motions(study, smaller, design)
    found = np.zeros((len(basis.labels), motions.shape[1]))
    found[[basis.labels.index(label) for label in smaller.labels]] = motions
    return found


# the loaded shell ---------------------------------------------------------------------------------------------------


def loaded_shell(study: Study, basis: ModeBasis) -> LoadedShell:
    """Return the shell of a study under weight, water and internal pressure."""
    device, water = study.device, study.water
    elastic = ElasticShell(basis)
    return LoadedShell(elastic, study.centre_height, water.density, water.gravity, device.internal_pressure, device.gas)


def rubber_shell(study: Study, basis: ModeBasis) -> LoadedShell | None:
    """Return the same of a flexible shell of rubber; None of another, whose forces about its rest are linear."""
    return loaded_shell(study, basis) if basis.shell.rubber and basis.modes else None


def complete_loaded_shell(study: Study) -> LoadedShell:
    """Return the same in a basis that resolves buckling, whatever the modes of the study."""
    return complete_shell(study.device, study.centre_height, study.water, study.device.internal_pressure)


def computed_buckling(study: Study) -> Buckling:
    """Return the linear buckling of the loaded shell in a basis that resolves it; of the sphere's the axisymmetric."""
    loaded = complete_loaded_shell(study)
    return buckling(loaded) if loaded.basis.shell.rest is None else with_lobes(loaded)


@lru_cache(maxsize=4)
def _at_rest(loaded: LoadedShell, complete: LoadedShell | None = None) -> FloatArray:
    """The equilibrium of a shell, computed once, near that in a complete basis if given; not to be written to."""
    if complete is None:
        q = equilibrium(loaded)
    else:
        own, known = loaded.basis.shares, _at_rest(complete) @ complete.basis.shares
        displaced = np.zeros((2, own.shape[-1]))  # its basis may have fewer degrees, too
        few = min(own.shape[-1], known.shape[-1])
        displaced[:, :few] = known[:, :few]
        q = equilibrium_near(loaded, np.linalg.lstsq(np.hstack([*own]).T, displaced.ravel())[0])
    q.setflags(write=False)
    return q


def complete_at_rest(study: Study) -> tuple[LoadedShell, FloatArray]:
    """Return the loaded shell in a basis that resolves its buckling, and its equilibrium, shape (dof,) [m].

    Raises `ConvergenceError` if the growing load does not lead it to a stable rest shape.
    """
    loaded = complete_loaded_shell(study)
    return loaded, _at_rest(loaded)


def carries_load(study: Study) -> bool:
    """Return whether the growing load leads the shell to a stable rest shape, in a basis that resolves its buckling."""
    try:
        complete_at_rest(study)
    except ConvergenceError:
        return False
    return True


def reference_shell(study: Study, basis: ModeBasis | None = None) -> ReferenceShell:
    """Return the shell a study is linearised about.

    Raises `ConfigError` if `reference_shape: equilibrium` is asked for and the shell buckles before it carries its
    load, in a basis that resolves its buckling: few modes would hide it.

    Parameters
    ----------
    basis : ModeBasis, optional
        Another basis than the study's own.

    Notes
    -----
    `undeformed`, open to constant pressure: the paper's shell, elastic and hydrostatic stiffness of the sphere. With
    internal pressure also its prestress, the geometric stiffness of the mean pressure difference and the follower part
    of the internal pressure. `equilibrium`: the tangent of the whole potential where the loaded shell rests. Trapped
    gas adds its own.
    """
    basis = basis or study_basis(study)
    parts = study.device, study.water, study.centre_height, study.at_equilibrium, study.flexible
    return _reference_shell(_Resting(basis, *parts, study))


@dataclass(frozen=True)
class _Resting:
    """All that the shape of a shell at rest follows from."""

    basis: ModeBasis
    device: Device
    water: Water
    centre_height: float
    at_equilibrium: bool
    flexible: bool
    study: Study = field(compare=False)


@lru_cache(maxsize=8)
def _reference_shell(one: _Resting) -> ReferenceShell:
    """The same, kept for what shares it, as members of a campaign that differ by their take-off; not to be written."""
    study, basis = one.study, one.basis
    loaded = loaded_shell(study, basis)
    if study.at_equilibrium:
        try:
            complete, _ = complete_at_rest(study)
        except ConvergenceError as error:
            raise ConfigError(f"reference_shape: received 'equilibrium', but {error}") from None
        undamped = replace(basis, alpha=0.0, beta=0.0)  # at rest nothing moves
        q = _at_rest(replace(loaded, elastic=ElasticShell(undamped)), complete)
    else:
        q = np.zeros(len(basis.labels))
    return ReferenceShell(DeformedShell(basis, study.centre_height, q), stiffness_about(study, loaded, q))


def stiffness_about(study: Study, loaded: LoadedShell, q: FloatArray) -> dict[str, FloatArray]:
    """Return the stiffness of a study's shell about a shape at rest, by the names of `reference_shell`, (dof, dof)."""
    basis = loaded.basis
    stiffness = {"structural": basis.stiffness, "hydrostatic": loaded.hydrostatic_stiffness(q)}
    if study.at_equilibrium:
        stiffness["structural"] = loaded.elastic.material_stiffness(q)
        geometric = loaded.elastic.geometric_stiffness(*loaded.elastic.resultants(q))
        stiffness["prestress"] = geometric + loaded.pressure_stiffness(q)
    elif study.device.internal_pressure and study.flexible:
        stiffness["prestress"] = loaded.prestress_stiffness
    if study.device.gas and study.flexible:
        stiffness["gas"] = loaded.gas_stiffness(q)
    return {name: (k + k.T) / 2 for name, k in stiffness.items()}


def seen_by_take_off(study: Study, reference: ReferenceShell) -> tuple[ReferenceShell, float]:
    """Return the shell at rest as the port finds it, and the compliance of the chamber before the take-off [m^3/Pa].

    Gas that a take-off of the volume lets out is in series with it, and no longer holds the shell.
    """
    if not (study.opens_chamber and "gas" in reference.stiffness):
        return reference, 0.0
    others = {name: stiffness for name, stiffness in reference.stiffness.items() if name != "gas"}
    chamber = gas_compliance(reference.stiffness["gas"], port_direction(study.pto.port, reference.shape))
    return replace(reference, stiffness=others), chamber


# stiffness of all directions ----------------------------------------------------------------------------------------


def order_stiffness(study: Study, basis: OrderBasis, reference: ReferenceShell) -> dict[str, FloatArray]:
    """Return the stiffness of one order about the undeformed sphere, by the names of `reference_shell`.

    Trapped gas has none: no shape that varies around the axis changes the volume in proportion to its amplitude.
    """
    water = study.water
    still = basis.hydrostatic_stiffness(study.centre_height, water.density, water.gravity)
    found = {"structural": basis.stiffness, "hydrostatic": (still + still.T) / 2}
    if "prestress" in reference.stiffness:
        load = prestress_stiffness(basis, loaded_shell(study, reference.basis))
        found["prestress"] = (load + load.T) / 2
    return found | ({"gas": np.zeros_like(still)} if "gas" in reference.stiffness else {})


def mooring_stiffness(study: Study, labels: tuple[str, ...]) -> dict[str, FloatArray]:
    """Return the stiffness of the mooring over labelled degrees of freedom, by its name; empty without one."""
    if study.mooring is None:
        return {}
    among = np.array([[float(label == name.capitalize()) for name in RIGID] for label in labels])
    return {"mooring": among @ np.array(study.mooring) @ among.T}


def whole_stiffness(study: Study, reference: ReferenceShell) -> FloatArray:
    """Return the sum of all stiffness over the degrees of freedom of all orders, shape (dof, dof) [N/m]."""
    orders = (order_stiffness(study, basis, reference) for basis in order_bases(study, reference.basis))
    whole = side_by_side(reference.total, *(np.sum(list(parts.values()), axis=0) for parts in orders))
    return np.asarray(whole + sum(mooring_stiffness(study, whole_labels(study, reference)).values()))


def viscous_parts(study: Study, reference: ReferenceShell, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return damping [N s/m] and added stiffness [N/m] of the material's Maxwell branches, each (omega, dof, dof)."""
    orders = (basis.stiffness for basis in order_bases(study, reference.basis))
    own, branches = side_by_side(reference.stiffness["structural"], *orders), study.device.damping.maxwell
    damping, stiffness = (share(branches, omega)[:, None, None] * own for share in (loss, stiffening))
    return damping, stiffness


def design_stiffness(study: Study, reference: ReferenceShell, design: str, beside: FloatArray | float = 0.0) -> float:
    """Return the least stiffness of a design about the reference shape [N/m]; one that rests stably has more than 0.

    Only of what is held at all: surge without a mooring may drift. `beside` is that of springs of the take-off, shape
    (dof, dof).
    """
    motions = design_motions(study, reference.basis, design)
    stiffness = motions.T @ (whole_stiffness(study, reference) + beside) @ motions
    return softest(stiffness, unrestrained_motions(stiffness, whole_labels(study, reference), motions))[0]


# checks -------------------------------------------------------------------------------------------------------------


def _rigid_stiffness(study: Study, reference: ReferenceShell) -> tuple[list[str], FloatArray]:
    """Rigid motions a buoy has, and their stiffness."""
    labels = whole_labels(study, reference)
    names: list[str] = [name for name in ("Surge", "Sway", "Heave", "Yaw", "Roll", "Pitch") if name in labels]
    rigid = [labels.index(name) for name in names]
    return names, whole_stiffness(study, reference)[np.ix_(rigid, rigid)]


def check_upright(study: Study, reference: ReferenceShell) -> None:
    """Check that the buoy as a rigid body does not fall over; raises `ConfigError`."""
    names, stiffness = _rigid_stiffness(study, reference)
    tilts = {name: float(stiffness[i, i]) for i, name in enumerate(names) if name in ("Pitch", "Roll")}
    if tilts and min(tilts.values()) <= 0.0:
        name = min(tilts, key=tilts.__getitem__)
        raise ConfigError(
            f"device.centre_of_mass: received {study.device.centre_of_mass:g} m above the sphere's centre, with which "
            f"the buoy does not stay upright (stiffness of {name.lower()} {tilts[name]:.4g} N m); needs one below it, "
            f"or a mooring that holds {name.lower()}"
        )


def check_moored(study: Study, reference: ReferenceShell) -> None:
    """Check that the mooring does not drive the buoy as a rigid body out of its rest; what nothing holds may drift.

    Raises `ConfigError`.
    """
    names, stiffness = _rigid_stiffness(study, reference)
    least, shape = softest(stiffness, unrestrained_motions(stiffness, names, np.eye(len(names))))
    if least <= 0.0:
        most = names[np.argmax(np.abs(shape))].lower()
        raise ConfigError(
            f"mooring: received a stiffness that drives the buoy out of its rest, most in {most}; needs one that "
            "brings it back"
        )


def check_stable(study: Study, reference: ReferenceShell) -> None:
    """Check that every design rests stably about the reference shape: else a linear model of it grows without bound.

    Raises `ConfigError`.
    """
    check_upright(study, reference)
    check_moored(study, reference)
    for design in study.designs:
        least = design_stiffness(study, reference, design)
        if least <= 0:
            raise ConfigError(
                f"device: the shell of design {design} is unstable (least stiffness {least:.3g} N/m) with "
                f"young_modulus {study.device.young_modulus:g} Pa, thickness {study.device.thickness:g} m and "
                f"internal_pressure {study.device.internal_pressure:g} Pa; needs more of one of them"
            )


def check_spring(study: Study, reference: ReferenceShell) -> None:
    """Check that the take-off's spring does not push a buoy out of its rest; raises `ConfigError`."""
    if study.pto.several:  # without a spring
        return
    direction = port_direction(study.pto.port, reference.shape, order_bases(study, reference.basis))
    reference, chamber = seen_by_take_off(study, reference)
    stiffness, least = whole_stiffness(study, reference), -np.inf
    for design in study.designs:
        motions = design_motions(study, reference.basis, design)
        yields = chamber + compliance(motions.T @ stiffness @ motions, allowed_part(direction, motions))
        if yields == np.inf and study.pto.stroke_limit < np.inf:
            raise ConfigError(
                f"pto.stroke_limit: received {study.pto.stroke_limit:g} m, but the port of design {design} has "
                "no position of rest to measure it from; needs a mooring that holds it"
            )
        least = max(least, -1 / yields if yields > 0 else -np.inf)
    if not (study.pto.stiffness > least or study.pto.stiffness == least == 0.0):
        raise ConfigError(
            f"pto.stiffness: received {study.pto.stiffness:g} N/m, which makes the buoy statically unstable; needs "
            f"more than {least + 0.0:.6g} N/m"
        )


def check_rests(study: Study, reference: ReferenceShell) -> None:
    """Check that every design comes to rest where the water acts on the shell as it is; a linear model needs no rest.

    Raises `ConfigError`.
    """
    if study.hydro.model == "linear":
        return
    from vsb.engine.motion.scene import still_scene  # compiled

    water = study.water
    for design in study.designs:
        motions = design_motions(study, reference.basis, design)
        try:
            still_scene(reference, water.density, water.gravity, motions, rubber_shell(study, reference.basis))
        except ConvergenceError as error:
            raise ConfigError(f"hydro.model: received {study.hydro.model!r} for design {design}, but {error}") from None


# loads at rings of the shell ----------------------------------------------------------------------------------------

# A clamp, a ring that is held, a take-off at a ring or between two, and the edges of a belt whose strain drives one
# load the wall along lines. The modes of a study end at some degree; `vsb.engine.shell.rings` has the answer of all
# higher ones.

KEPT = 12
"""Shells whose modes of rings are kept."""
BESIDE_POLE = 1e-6
"""Distance from a pole at which its tension is taken: at the pole itself strains are 0/0 [rad]."""


def ring_loads(study: Study, waterline: float | None = None, wet: Sequence[float] = ()) -> tuple[Load, ...]:
    """Return the loads of the take-off at rings, then those of all designs and of the mooring, each once.

    Parameters
    ----------
    study : Study
    waterline : float, optional
        Colatitude of the waterline [rad], if shapes beside loads move water; that of water follows those that do.
    wet : sequence of float
        Colatitudes of the clamps that do, too [degrees].
    """
    found: list[Load] = [load for port in study.pto.single_ports for load in _of_port(port)]
    if waterline is not None:
        found += [way(at) for at in np.deg2rad(wet).tolist() for way in (normal_to_wall, along_wall)]
        found += [PressureLoad(waterline, power) for power in (0, 1)]
    found += [way(at) for at in np.deg2rad(clamps(study)).tolist() for way in (normal_to_wall, along_wall)]
    held = study.pto.held
    if held is not None and held.place == "ring":
        found.append(vertical(np.deg2rad(held.colatitude)))
    return tuple(dict.fromkeys(load for load in found if load.moves))


def clamps(study: Study) -> tuple[float, ...]:
    """Return the colatitudes of the clamps of all designs [degrees]."""
    return tuple(sorted({at for one in study.designs.values() for at in one.clamp}))


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


def has_attachment_modes(study: Study) -> bool:
    """Return whether all degrees of a study's shell answer its loads at rings: those with both branches of modes.

    Of modes one asks for by name those of the basis do.
    """
    return bool(study.flexible and study.modes.basis == "full")


def with_rings(
    study: Study, reference: ReferenceShell, highest: int = HIGHEST, *, wet: Sequence[float] | None = None
) -> ReferenceShell:
    """Return a shell at rest with the modes of the rings that a study loads.

    Parameters
    ----------
    reference : ReferenceShell
        Without them.
    highest : int
        Degree up to which they do; without one above the modes there are none.
    wet : sequence of float, optional
        If water moves with them, beside the waterline, too, and still water acts on them: at which clamps [degrees].
    """
    basis, shape = reference.basis, reference.shape
    if not basis.modes or not has_attachment_modes(study):
        return reference
    if not (loads := ring_loads(study) if wet is None else ring_loads(study, shape.waterline, wet)):
        return reference
    above = basis.highest_degree
    if highest <= max(above, 1):
        return reference
    rings = attachment_modes(basis.shell, above, loads, _tension(study, reference, loads), highest)
    # the loads at rings of all designs and take-off that go with cos(m theta), m >= 1, each once
    found = [way(at) for at in np.deg2rad(clamps(study)) for way in (normal_to_wall, along_wall, around_axis)]
    between = [port for port in study.pto.single_ports if isinstance(port, BetweenPort)]
    found += [load for port in between for load in _of_port(port) if isinstance(load, RingLoad) and load.moves]
    further = tuple(dict.fromkeys(found))
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
    more = len(whole.labels) - len(shape.modal_amplitude)
    q = np.pad(shape.modal_amplitude, (0, more))  # the modes of rings are at rest
    if rings.wet and "hydrostatic" in stiffness:
        stiffness["hydrostatic"] = _of_still_water(study, replace(shape, basis=whole, modal_amplitude=q))
    return ReferenceShell(replace(shape, basis=whole, modal_amplitude=q), stiffness)


def _of_still_water(study: Study, shape: DeformedShell) -> FloatArray:
    """Stiffness of still water over all degrees of freedom, those of rings by their degrees that it acts on [N/m]."""
    basis, rings = shape.basis, shape.basis.rings
    assert rings is not None
    responses = rings.under_loads(wet_degree(study))[:, : rings.wet]
    amplitudes = np.einsum("ml,aln->man", rings.of_loads(rings.wet), responses)
    modes = tuple(_of_parts(label, parts) for label, parts in zip(rings.labels, amplitudes, strict=True))
    whole = replace(shape, basis=replace(basis, modes=(*basis.modes, *modes), rings=None))
    points = 4 * whole.basis.highest_degree + 40
    stiffness = whole.hydrostatic_stiffness(study.water.density, study.water.gravity, points)
    return (stiffness + stiffness.T) / 2


def _of_parts(label: str, amplitudes: FloatArray) -> Mode:
    """A shape of several degrees by their radial and meridional amplitudes, (2, degree)."""
    first, *others = _parts(amplitudes)
    return Mode(label, *first, tuple(others))


def _parts(amplitudes: FloatArray) -> tuple[tuple[int, float, float], ...]:
    """Degrees that take part, with their radial and meridional amplitudes; the first one in any case."""
    return tuple((n, *pair) for n, pair in enumerate(amplitudes.T.tolist()) if any(pair) or not n)


def load_displacements(study: Study, reference: ReferenceShell) -> tuple[Displacement, ...]:
    """Return what the wall does under each load at a ring or of water, by all degrees that move water."""
    still = ReferenceShell(reference.shape, {k: v for k, v in reference.stiffness.items() if k != "hydrostatic"})
    if (rings := with_rings(study, still, wet=clamps(study)).basis.rings) is None:
        return ()
    responses = rings.under_loads(wet_degree(study)).swapaxes(0, 1)[: rings.wet]
    return tuple(Displacement("load", i, parts=_parts(one)) for i, one in enumerate(responses, 1))


_ring_modes, _kink_modes = lru_cache(KEPT)(RingModes), lru_cache(KEPT)(KinkModes)
"""Members of a campaign that differ by their take-off have the same."""


def attachment_modes(
    shell: Shell, degree: int, loads: tuple[Load, ...], tension: tuple[float, ...], highest: int = HIGHEST
) -> AttachmentModes:
    """Return what all degrees above one do under loads at rings, kept for shells of the same wall."""
    modes = _ring_modes if shell.rest is None else _kink_modes
    return modes(shell, degree, loads, tension, highest)


def _tension(study: Study, reference: ReferenceShell, loads: tuple[Load, ...]) -> tuple[float, ...]:
    """Membrane force along the meridian at rings [N/m]; none of a shell linearised without its load."""
    if "prestress" not in reference.stiffness:
        return (0.0,) * len(loads)
    return tension_at(
        loads, loaded_shell(study, reference.basis), reference.modal_amplitude if study.at_equilibrium else None
    )


def tension_at(loads: tuple[Load, ...], loaded: LoadedShell, at_rest: FloatArray | None) -> tuple[float, ...]:
    """Return the membrane force along the meridian at rings of a shell at rest, or of the undeformed one [N/m]."""
    at = np.array([load.colatitude for load in loads])
    at = np.where(np.abs(np.sin(at)) < BESIDE_POLE, at + np.copysign(BESIDE_POLE, np.pi / 2 - at.real), at)
    elastic = loaded.elastic
    force, _ = loaded.linear_resultants(at) if at_rest is None else elastic.linear_resultants(at_rest, at)
    return tuple(force.tolist())


def without_rings(database: xr.Dataset) -> xr.Dataset:
    """Return a database without what it may know of the water beside loaded rings."""
    labels = [label for label in database.influenced_dof.values if str(label).startswith("Ring")]
    return database.drop_sel(dict.fromkeys(PAIR, labels)) if labels else database


class Stored(NamedTuple):
    """A shell at rest as a hydro database has it, with the modes of rings."""

    database: xr.Dataset
    shape: DeformedShell


def stored_with_rings(
    study: Study,
    database: xr.Dataset,
    shape: DeformedShell,
    highest: int = HIGHEST,
    *,
    wet: Sequence[float] | None = None,
) -> Stored:
    """Return the database and the shape of a study with the modes of the rings that it loads.

    They move no water that the database does not know of; `wet` as of `with_rings`.
    """
    names = [name for name in ("structural", "prestress") if f"{name}_stiffness" in database]
    none = dict.fromkeys(names, np.zeros((len(shape.basis.labels),) * 2))
    found = with_rings(study, ReferenceShell(shape, none), highest, wet=wet)
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
