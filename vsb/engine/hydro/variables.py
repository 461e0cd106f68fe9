"""Variables of hydrodynamic coefficients in files, and labels of degrees of freedom: of bodies, rigid, of rings.

Names of the database are capytaine's where it has them.
"""

from collections.abc import Iterable

from vsb.tools.variables import Variable, register

RIGID = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
"""Labels of the six rigid motions, in everybody's order; of several bodies named with the body first: float__Heave."""


ROTATIONS = RIGID[3:]


def motion_of(label: str) -> str:
    """Return the motion a degree of freedom is, whichever body's: Heave of float__Heave."""
    return label.rpartition("__")[2]


def body_of(label: str) -> str:
    """Return the body a degree of freedom is of: float of float__Heave; the only one has no name."""
    return label.rpartition("__")[0]


def is_rigid(label: str) -> bool:
    """Return whether a degree of freedom is a rigid motion, of one of several bodies or of the only one."""
    return motion_of(label) in RIGID


def is_of_ring(label: str) -> bool:
    """Return whether a degree of freedom is a mode of rings: too short to be seen in the shape of the shell."""
    return label.startswith("Ring")


def of_bodies(labels: Iterable[str]) -> dict[str, list[int]]:
    """Return the places of each body's degrees of freedom, by its name; the only body has none."""
    places: dict[str, list[int]] = {}
    for place, label in enumerate(labels):
        places.setdefault(body_of(label), []).append(place)
    return places


PAIR = ("influenced_dof", "radiating_dof")
"""Dimensions of a matrix over the degrees of freedom."""
RESOLUTION = "resolution"
"""Variable with the error of the solver in each degree of freedom, over the root of the largest added mass of it."""
OF_GEOMETRY = {
    name: f"geometry_{name}"
    for name in ("added_mass", "radiation_damping", "excitation_force", "hydrostatic_stiffness")
}
"""Attributes: relative errors of coefficients of heave by what is unknown of the shape, at `AT_GEOMETRY` [rad/s]."""
AT_GEOMETRY = "geometry_omega"
_EXCITATION = ("omega", "wave_direction", "influenced_dof")
_SHAPE_PAIR = ("shape_dof", "other_shape_dof")
_BY_COEFFICIENT = ("coefficient", "shape_dof")
_BY_SHAPE = ("solver", "shape", "omega")

register(
    {
        "wave_direction": Variable(("wave_direction",), "rad", "wave direction"),
        # mesh of an axisymmetric buoy, or of several shapes
        "meridian_radius": Variable(("...", "node"), "m", "radius of the panel rows' edges"),
        "meridian_height": Variable(("...", "node"), "m", "height of the panel rows' edges above still water"),
        "lid_radius": Variable(("...", "lid_node"), "m", "radius of the edges of the interior lid's rows"),
        "row_colatitude": Variable(("...", "row"), "rad", "colatitude of the middles of panel rows, undeformed"),
        "normal_radius": Variable(("...", "row"), "1", "radial component of the shell's outward normal"),
        "normal_height": Variable(("...", "row"), "1", "vertical component of the shell's outward normal"),
        # hydro database
        "added_mass": Variable(("omega", *PAIR), "kg", "added mass"),
        "radiation_damping": Variable(("omega", *PAIR), "kg/s", "radiation damping"),
        "added_mass_inf": Variable(PAIR, "kg", "added mass at infinite frequency"),
        "added_mass_zero": Variable(PAIR, "kg", "added mass at frequency zero"),
        "excitation_force": Variable(_EXCITATION, "N/m", "excitation force per unit wave amplitude"),
        "Froude_Krylov_force": Variable(_EXCITATION, "N/m", "Froude-Krylov force per unit wave amplitude"),
        "diffraction_force": Variable(_EXCITATION, "N/m", "diffraction force per unit wave amplitude"),
        "added_mass_error": Variable(("error", "omega", *PAIR), "kg", "estimated error of added mass"),
        "radiation_damping_error": Variable(("error", "omega", *PAIR), "kg/s", "estimated error of radiation damping"),
        "excitation_force_error": Variable(("error", *_EXCITATION), "N/m", "estimated error of the excitation force"),
        "hydrostatic_stiffness_error": Variable(("error", *PAIR), "N/m", "estimated error of hydrostatic stiffness"),
        RESOLUTION: Variable(
            ("influenced_dof",), "kg^0.5", "estimated relative error times the root of the largest added mass"
        ),
        "hydrostatic_stiffness": Variable(PAIR, "N/m", "hydrostatic stiffness"),
        "inertia_matrix": Variable(PAIR, "kg", "inertia of buoy and shell"),
        "mooring_stiffness": Variable(PAIR, "N/m", "stiffness of the mooring"),
        "azimuthal_order": Variable(
            ("influenced_dof",), "1", "azimuthal order m of the motion, proportional to cos(m theta)"
        ),
        "structural_stiffness": Variable(PAIR, "N/m", "elastic stiffness of the shell"),
        "structural_damping_matrix": Variable(PAIR, "kg/s", "structural damping of body and shell"),
        "prestress_stiffness": Variable(PAIR, "N/m", "geometric stiffness of the mean pressure difference"),
        "gas_stiffness": Variable(PAIR, "N/m", "stiffness of the trapped gas"),
        "pole_radial_displacement": Variable(
            ("influenced_dof",), "1", "radial displacement at the top pole per unit amplitude"
        ),
        "reference_amplitude": Variable(
            ("influenced_dof",), "m", "heave and modal amplitudes of the shape the coefficients are for"
        ),
        "outline": Variable(("line", "end", "xyz"), "m", "wetted hull cut along x through the middle of each part"),
        "outline_displacement": Variable(
            ("influenced_dof", "line", "end", "xyz"), "1", "displacement of the outline per unit amplitude"
        ),
        # radiation model
        "kernel": Variable(("time", "radiating_dof"), "kg/s^2", "retardation kernel of a motion by itself"),
        "kernel_state_space": Variable(
            ("time", "radiating_dof"), "kg/s^2", "retardation kernel of a motion by itself, of the state space"
        ),
        "damping_state_space": Variable(
            ("omega", "radiating_dof"), "kg/s", "radiation damping of a motion by itself, of the state space"
        ),
        "state_matrix": Variable(("state", "state_in"), "1/s", "state matrix A = J - l l^T/2"),
        "input_matrix": Variable(("state", "radiating_dof"), "kg^0.5/s", "input matrix G; output G^T"),
        "channel": Variable(("state", "..."), "s^-0.5", "radiation channels L: radiated power |L^T x|^2/2"),
        # shape dependence of the coefficients
        "added_mass_slope": Variable(("shape_dof", "omega", *PAIR), "kg/m", "derivative of added mass by the shape"),
        "added_mass_curvature": Variable((*_SHAPE_PAIR, "omega", *PAIR), "kg/m^2", "second derivative by the shape"),
        "radiation_damping_slope": Variable(
            ("shape_dof", "omega", *PAIR), "kg/(m s)", "derivative of radiation damping"
        ),
        "radiation_damping_curvature": Variable(
            (*_SHAPE_PAIR, "omega", *PAIR), "kg/(m^2 s)", "second derivative by the shape"
        ),
        "excitation_force_slope": Variable(("shape_dof", *_EXCITATION), "N/m^2", "derivative of the excitation force"),
        "excitation_force_curvature": Variable((*_SHAPE_PAIR, *_EXCITATION), "N/m^3", "second derivative by the shape"),
        "added_mass_inf_slope": Variable(
            ("shape_dof", *PAIR), "kg/m", "derivative of added mass at infinite frequency"
        ),
        "added_mass_inf_curvature": Variable((*_SHAPE_PAIR, *PAIR), "kg/m^2", "second derivative by the shape"),
        **{
            f"{name}_slope_error": Variable(("shape_dof",), "1", "estimated relative error of the derivative")
            for name in ("added_mass", "radiation_damping", "excitation_force", "added_mass_inf")
        },
        "interpolation_error": Variable(("expansion", "deformation"), "1", "relative error of the expansion"),
        "deformation": Variable(("deformation",), "m", "size of the test deformations"),
        "shape_reach": Variable(("shape_dof",), "m", "largest amplitude the shape database covers"),
        "remainder": Variable(_BY_COEFFICIENT, "1/m^3", "a sixth of the third derivative, relative"),
        "remainder_scale": Variable(("coefficient",), "1", "factor from the remainder to the estimated error"),
        "reference_error": Variable(
            ("coefficient",), "1", "relative error of the shape database at the reference shape"
        ),
        "slope_noise": Variable(_BY_COEFFICIENT, "1/m", "error of the first derivative relative to the coefficient"),
        "tried_shape": Variable(("tried", "shape_dof"), "m", "amplitudes of the test shapes"),
        "tried_error": Variable(("tried", "coefficient"), "1", "relative error on the test shapes"),
        # cross-check: two solvers on the mean and on deformed shapes
        "shape_added_mass": Variable((*_BY_SHAPE, *PAIR), "kg", "added mass on a shape"),
        "shape_radiation_damping": Variable((*_BY_SHAPE, *PAIR), "kg/s", "radiation damping on a shape"),
        "shape_excitation_force": Variable((*_BY_SHAPE, *_EXCITATION[1:]), "N/m", "excitation force on a shape"),
        "deformation_amplitude": Variable(("shape",), "m", "modal amplitude of the deformation"),
        "witness_difference": Variable(
            (*_BY_SHAPE[1:], "coefficient"), "1", "relative difference between the two solvers"
        ),
        "witness_estimate": Variable(("solver", "shape", "coefficient"), "1", "relative error estimated by the solver"),
        "witness_seconds": Variable(("solver", "shape"), "s", "computing time of a solver for one shape"),
        "slope_difference": Variable(
            ("shape_dof", "omega", "coefficient"),
            "1",
            "relative difference between the two solvers' derivatives by the shape",
        ),
        "slope_estimate": Variable(
            ("shape_dof", "coefficient"), "1", "expected relative difference of these derivatives"
        ),
    }
)
