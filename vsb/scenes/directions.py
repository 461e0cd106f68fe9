"""What holds a buoy that moves in several directions: stiffness of all azimuthal orders, and its mooring."""

import numpy as np
from scipy.linalg import block_diag

from vsb.errors import ConfigError
from vsb.motion.frequency import drifting_motions, softest
from vsb.shell.deformed import ReferenceShell
from vsb.shell.elastic import ElasticShell
from vsb.shell.loaded import LoadedShell
from vsb.shell.modes import ModeBasis
from vsb.shell.orders import OrderBasis, ballast_of, order_basis, prestress_stiffness, yaw
from vsb.study.directions import RIGID
from vsb.study.specs import AtRest, DesignsSpec, RestSpec
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray


def order_bases(study: Study | RestSpec | DesignsSpec, basis: ModeBasis) -> tuple[OrderBasis, ...]:
    """Return the degrees of freedom beside heave and axisymmetric modes, order by order; none of heave alone.

    A buoy that is free has each order twice, to both sides, and yaw.
    """
    if study.motion == "heave":
        return ()
    ballast, highest = ballast_of(study.device), study.modes.order if basis.modes and study.modes else 1
    even = [order_basis(basis, order, ballast) for order in range(1, highest + 1)]
    if study.motion == "planar":
        return tuple(even)
    return (*(each for one in even for each in (one, one.turned())), yaw(basis, ballast))


def side_by_side(own: FloatArray, *others: FloatArray) -> FloatArray:
    """Return the block-diagonal matrix of what is axisymmetric and of further orders, if there are any."""
    return np.asarray(block_diag(own, *others)) if others else own


def loaded_shell(study: AtRest | DesignsSpec, basis: ModeBasis) -> LoadedShell:
    """Return the shell of a study under weight, water and internal pressure."""
    device, water = study.device, study.water
    elastic = ElasticShell(basis)
    return LoadedShell(elastic, study.centre_height, water.density, water.gravity, device.internal_pressure, device.gas)


def order_stiffness(
    study: Study | RestSpec | DesignsSpec, basis: OrderBasis, reference: ReferenceShell
) -> dict[str, FloatArray]:
    """Return the stiffness of one order about the undeformed sphere, by the names of `reference_shell`.

    Trapped gas has none: no shape that goes around changes the volume in proportion to its amplitude.
    """
    water = study.water
    still = basis.hydrostatic_stiffness(study.centre_height, water.density, water.gravity)
    found = {"structural": basis.stiffness, "hydrostatic": (still + still.T) / 2}
    if "prestress" in reference.stiffness:
        load = prestress_stiffness(basis, loaded_shell(study, reference.basis))
        found["prestress"] = (load + load.T) / 2
    return found | ({"gas": np.zeros_like(still)} if "gas" in reference.stiffness else {})


def mooring_stiffness(study: Study | RestSpec | DesignsSpec, labels: tuple[str, ...]) -> dict[str, FloatArray]:
    """Return the stiffness of the mooring over labelled degrees of freedom, by its name; nothing without one."""
    if study.mooring is None:
        return {}
    names = [name.capitalize() for name in RIGID]
    among = np.array([[float(label == name) for name in names] for label in labels])
    return {"mooring": among @ np.array(study.mooring) @ among.T}


def whole_labels(study: Study | RestSpec | DesignsSpec, reference: ReferenceShell) -> tuple[str, ...]:
    """Return the names of the degrees of freedom of all orders, axisymmetric ones first."""
    return (
        *reference.basis.labels,
        *(label for basis in order_bases(study, reference.basis) for label in basis.labels),
    )


def whole_stiffness(study: Study | RestSpec | DesignsSpec, reference: ReferenceShell) -> FloatArray:
    """Return the sum of all stiffness over the degrees of freedom of all orders, shape (dof, dof) [N/m]."""
    parts = [
        np.sum(list(order_stiffness(study, basis, reference).values()), axis=0)
        for basis in order_bases(study, reference.basis)
    ]
    whole = side_by_side(reference.total, *parts)
    return np.asarray(whole + sum(mooring_stiffness(study, whole_labels(study, reference)).values()))


def check_upright(study: Study | RestSpec | DesignsSpec, reference: ReferenceShell) -> None:
    """Check that the buoy as a rigid body does not fall over.

    Raises
    ------
    ConfigError
    """
    names, stiffness = _rigid_stiffness(study, reference)
    tilts = {
        name: float(stiffness[names.index(name), names.index(name)]) for name in ("Pitch", "Roll") if name in names
    }
    if tilts and min(tilts.values()) <= 0.0:
        name = min(tilts, key=tilts.__getitem__)
        raise ConfigError(
            f"device.centre_of_mass: received {study.device.centre_of_mass:g} m above the sphere's centre, with which "
            f"the buoy does not stay upright (stiffness of {name.lower()} {tilts[name]:.4g} N m); needs one below it, "
            f"or a mooring that holds {name.lower()}"
        )


def check_moored(study: Study | RestSpec | DesignsSpec, reference: ReferenceShell) -> None:
    """Check that the mooring does not drive the buoy as a rigid body out of its rest; what nothing holds may drift.

    Raises
    ------
    ConfigError
    """
    names, stiffness = _rigid_stiffness(study, reference)
    least, shape = softest(stiffness, drifting_motions(stiffness, names, np.eye(len(names))))
    if least <= 0.0:
        most = names[np.argmax(np.abs(shape))].lower()
        raise ConfigError(
            f"mooring: received a stiffness that drives the buoy out of its rest, most in {most}; needs one that "
            "brings it back"
        )


def _rigid_stiffness(study: Study | RestSpec | DesignsSpec, reference: ReferenceShell) -> tuple[list[str], FloatArray]:
    """Rigid motions a buoy has, and their stiffness."""
    labels = whole_labels(study, reference)
    names: list[str] = [name for name in ("Surge", "Sway", "Heave", "Yaw", "Roll", "Pitch") if name in labels]
    rigid = [labels.index(name) for name in names]
    return names, whole_stiffness(study, reference)[np.ix_(rigid, rigid)]
