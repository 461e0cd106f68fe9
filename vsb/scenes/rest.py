"""Where a study's shell rests: the modes it moves in, its equilibrium and its stiffness there."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from vsb.errors import ConfigError, ConvergenceError
from vsb.motion.frequency import allowed_part, compliance, drifting_motions, gas_compliance, softest
from vsb.motion.port import port_direction
from vsb.scenes.directions import (
    check_moored,
    check_upright,
    loaded_shell,
    order_bases,
    side_by_side,
    whole_labels,
    whole_stiffness,
)
from vsb.shell.deformed import DeformedShell, ReferenceShell
from vsb.shell.elastic import ElasticShell
from vsb.shell.loaded import Buckling, LoadedShell, buckling, complete_shell, equilibrium
from vsb.shell.modes import ModeBasis, mode_basis, rigid_basis
from vsb.study.specs import AtRest, Designed
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray


def study_basis(study: AtRest) -> ModeBasis:
    """Return the union of the modes of all designs of a study."""
    if not study.flexible or study.modes is None:
        return rigid_basis(study.device)
    return mode_basis(study.device, study.modes.basis, study.modes.max_degree)


def design_motions(study: Designed, basis: ModeBasis, design: str) -> FloatArray:
    """Return the motions a design allows, shape (dof, free) [-]: heave alone, or heave and the unclamped modes.

    Likewise of the other azimuthal orders, where the buoy moves in more directions.

    Raises
    ------
    ConfigError
        If the clamps leave no shell mode free.
    """
    chosen, clamps = study.designs[design], np.deg2rad(study.designs[design].clamp)
    others = (order.allowed(chosen.flexible, clamps) for order in order_bases(study, basis))
    if not chosen.flexible:
        return side_by_side(np.eye(len(basis.labels), 1), *others)
    free = basis.clamped(clamps) if chosen.clamp else np.eye(len(basis.labels))
    if free.shape[1] < 2:
        raise ConfigError(
            f"designs.{design}.clamp: received {list(chosen.clamp)}, which leaves none of the {len(basis.modes)} shell "
            f"modes free; use fewer clamps, a larger modes.degree, or flexible: false"
        )
    return side_by_side(free, *others)


def motions_to_degree(study: Designed, basis: ModeBasis, design: str, degree: int) -> FloatArray:
    """Return the motions a heaving design has with the shell modes to a degree, in a basis of more, (dof, free) [-].

    Raises
    ------
    ConfigError
        If the clamps leave none of those modes free.
    """
    smaller = mode_basis(study.device, study.modes.basis, degree)
    motions = design_motions(study, smaller, design)
    found = np.zeros((len(basis.labels), motions.shape[1]))
    found[[basis.labels.index(label) for label in smaller.labels]] = motions
    return found


def complete_loaded_shell(study: AtRest) -> LoadedShell:
    """Return the same in a basis that resolves buckling, whatever the modes of the study."""
    return complete_shell(study.device, study.centre_height, study.water, study.device.internal_pressure)


def reference_shell(study: AtRest, basis: ModeBasis | None = None) -> ReferenceShell:
    """Return the shell a study is linearised about.

    Parameters
    ----------
    study : Study, or a specification with its sections
    basis : ModeBasis, optional
        Another basis than the study's own.

    Raises
    ------
    ConfigError
        If `reference_shape: equilibrium` is asked for and the shell buckles before it carries its load.

    Notes
    -----
    `undeformed` and vented: the paper's shell, elastic and hydrostatic stiffness of the sphere. With internal pressure
    also its prestress, the geometric stiffness of the mean pressure difference and the follower part of the internal
    pressure. `equilibrium`: the tangent of the whole potential where the loaded shell rests. Trapped gas adds its own.
    """
    basis = basis or study_basis(study)
    loaded = loaded_shell(study, basis)
    if study.at_equilibrium:
        check_equilibrium(study)
        undamped = replace(basis, alpha=0.0, beta=0.0)  # at rest nothing moves
        q = _at_rest(replace(loaded, elastic=ElasticShell(undamped)))
    else:
        q = np.zeros(len(basis.labels))
    shape = DeformedShell(basis, study.centre_height, q)
    stiffness = {"structural": basis.stiffness, "hydrostatic": loaded.hydrostatic_stiffness(q)}
    if study.at_equilibrium:
        stiffness["structural"] = loaded.elastic.material_stiffness(q)
        geometric = loaded.elastic.geometric_stiffness(*loaded.elastic.resultants(q))
        stiffness["prestress"] = geometric + loaded.pressure_stiffness(q)
    elif study.device.internal_pressure and study.flexible:
        stiffness["prestress"] = loaded.prestress_stiffness
    if study.device.gas and study.flexible:
        stiffness["gas"] = loaded.gas_stiffness(q)
    return ReferenceShell(shape, {name: (k + k.T) / 2 for name, k in stiffness.items()})


@lru_cache(maxsize=4)
def _at_rest(loaded: LoadedShell) -> FloatArray:
    """The equilibrium of a shell, once for its water and for its year, not to be written to."""
    q = equilibrium(loaded)
    q.setflags(write=False)
    return q


def seen_by_take_off(study: Study, reference: ReferenceShell) -> tuple[ReferenceShell, float]:
    """Return the shell at rest as the port finds it, and the compliance of the chamber before the take-off [m^3/Pa].

    Gas that a take-off of the volume lets out stands in series with it, and no longer holds the shell.
    """
    if not (study.opens_chamber and "gas" in reference.stiffness):
        return reference, 0.0
    others = {name: stiffness for name, stiffness in reference.stiffness.items() if name != "gas"}
    chamber = gas_compliance(reference.stiffness["gas"], port_direction(study.pto.port, reference.shape))
    return replace(reference, stiffness=others), chamber


def check_equilibrium(study: AtRest) -> None:
    """Check that the loaded shell rests stably in a basis that resolves its buckling; few modes would hide it.

    Raises
    ------
    ConfigError
    """
    try:
        _at_rest(complete_loaded_shell(study))
    except ConvergenceError as error:
        raise ConfigError(f"reference_shape: received 'equilibrium', but {error}") from None


def carries_load(study: AtRest) -> bool:
    """Return whether the growing load leads the shell to a stable rest shape, in a basis that resolves its buckling."""
    try:
        _at_rest(complete_loaded_shell(study))
    except ConvergenceError:
        return False
    return True


def check_stable(study: Designed, reference: ReferenceShell) -> None:
    """Check that every design rests stably about the reference shape: a linear model of it grows without bound else.

    Raises
    ------
    ConfigError
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


def design_stiffness(
    study: Designed, reference: ReferenceShell, design: str, beside: FloatArray | float = 0.0
) -> float:
    """Return the least stiffness of a design about the reference shape [N/m]; what rests stably has more than 0.

    Of what is held at all: surge without a mooring drifts, which may be. `beside` is that of springs of the take-off,
    shape (dof, dof).
    """
    motions = design_motions(study, reference.basis, design)
    stiffness = motions.T @ (whole_stiffness(study, reference) + beside) @ motions
    return softest(stiffness, drifting_motions(stiffness, whole_labels(study, reference), motions))[0]


def check_spring(study: Study, reference: ReferenceShell) -> None:
    """Check that the take-off's spring does not push a buoy out of its rest.

    Raises
    ------
    ConfigError
    """
    direction = port_direction(study.pto.port, reference.shape, order_bases(study, reference.basis))
    reference, chamber = seen_by_take_off(study, reference)
    stiffness, least = whole_stiffness(study, reference), -np.inf
    for design in study.designs:
        motions = design_motions(study, reference.basis, design)
        yields = chamber + compliance(motions.T @ stiffness @ motions, allowed_part(direction, motions))
        if yields == np.inf and study.pto.stroke_limit < np.inf:
            raise ConfigError(
                f"pto.stroke_limit: received {study.pto.stroke_limit:g} m, but nothing holds the port of design "
                f"{design} at rest, from where it counts; needs a mooring that does"
            )
        least = max(least, -1 / yields if yields > 0 else -np.inf)
    if not (study.pto.stiffness > least or study.pto.stiffness == least == 0.0):
        raise ConfigError(
            f"pto.stiffness: received {study.pto.stiffness:g} N/m, with which a buoy does not rest; needs more than "
            f"{least + 0.0:.6g} N/m"
        )


def check_rests(study: Study, reference: ReferenceShell) -> None:
    """Check that every design comes to rest where the water acts on the shell as it is; a linear model needs no rest.

    Raises
    ------
    ConfigError
    """
    if study.hydro.model == "linear":
        return
    from vsb.motion.builders import still_scene  # what is compiled is read where it is needed

    for design in study.designs:
        try:
            still_scene(
                reference, study.water.density, study.water.gravity, design_motions(study, reference.basis, design)
            )
        except ConvergenceError as error:
            raise ConfigError(f"hydro.model: received {study.hydro.model!r} for design {design}, but {error}") from None


def computed_buckling(study: AtRest) -> Buckling:
    """Return the linear buckling of the loaded shell in a basis that resolves it."""
    return buckling(complete_loaded_shell(study))
