"""The one table of variables: name -> dimensions, units, meaning; and datasets with it applied."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vsb.errors import DatabaseError

if TYPE_CHECKING:
    import xarray as xr

PAIR = ("influenced_dof", "radiating_dof")
"""Dimensions of a matrix over the degrees of freedom."""


class Quantity(NamedTuple):
    """Dimensions, units and meaning of one variable."""

    dims: tuple[str, ...]
    units: str
    long_name: str


_EXCITATION = ("omega", "wave_direction", "influenced_dof")
_MOTION = ("time", "dof")
_SHAPE = ("mode", "colatitude")
_SHAPE_PAIR = ("shape_dof", "other_shape_dof")
_BY_COEFFICIENT = ("coefficient", "shape_dof")
_YEAR = ("...", "design", "tuning")
_BINS = ("hs", "te")
_BY_SHAPE = ("solver", "shape", "omega")

ATTRS: dict[str, Quantity] = {
    # coordinates
    "omega": Quantity(("omega",), "rad/s", "angular frequency"),
    "time": Quantity(("time",), "s", "time"),
    "colatitude": Quantity(("colatitude",), "rad", "colatitude from the top pole"),
    "wave_direction": Quantity(("wave_direction",), "rad", "wave direction"),
    # mesh
    "meridian_radius": Quantity(("node",), "m", "radius of the panel rows' edges"),
    "meridian_height": Quantity(("node",), "m", "height of the panel rows' edges above still water"),
    "lid_radius": Quantity(("lid_node",), "m", "radius of the edges of the interior lid's rows"),
    "row_colatitude": Quantity(("row",), "rad", "colatitude of the panel rows' middles on the undeformed sphere"),
    "normal_radius": Quantity(("row",), "1", "radial component of the shell's outward normal"),
    "normal_height": Quantity(("row",), "1", "vertical component of the shell's outward normal"),
    # shell modes
    "radial": Quantity(_SHAPE, "1", "radial displacement per unit modal amplitude"),
    "meridional": Quantity(_SHAPE, "1", "meridional displacement per unit modal amplitude"),
    "degree": Quantity(("mode",), "1", "Legendre degree of the mode"),
    "order": Quantity(("mode",), "1", "azimuthal order m of the mode, which goes with cos(m theta)"),
    "rest_radial": Quantity(("colatitude",), "m", "shape at rest beyond the sphere, along its radius"),
    "rest_meridional": Quantity(("colatitude",), "m", "shape at rest beyond the sphere, along its meridian"),
    "static_amplitude": Quantity(("mode",), "m", "modal amplitude of the shape at rest"),
    "dry_frequency": Quantity(("mode",), "rad/s", "natural angular frequency in vacuum"),
    # hydro database
    "added_mass": Quantity(("omega", *PAIR), "kg", "added mass"),
    "radiation_damping": Quantity(("omega", *PAIR), "kg/s", "radiation damping"),
    "added_mass_inf": Quantity(PAIR, "kg", "added mass at infinite frequency"),
    "added_mass_zero": Quantity(PAIR, "kg", "added mass at frequency zero"),
    "excitation_force": Quantity(_EXCITATION, "N/m", "excitation force per unit wave amplitude"),
    "Froude_Krylov_force": Quantity(_EXCITATION, "N/m", "Froude-Krylov force per unit wave amplitude"),
    "diffraction_force": Quantity(_EXCITATION, "N/m", "diffraction force per unit wave amplitude"),
    "added_mass_error": Quantity(("error", "omega", *PAIR), "kg", "estimated error of added mass"),
    "radiation_damping_error": Quantity(("error", "omega", *PAIR), "kg/s", "estimated error of radiation damping"),
    "excitation_force_error": Quantity(("error", *_EXCITATION), "N/m", "estimated error of the excitation force"),
    "hydrostatic_stiffness_error": Quantity(("error", *PAIR), "N/m", "estimated error of hydrostatic stiffness"),
    "hydrostatic_stiffness": Quantity(PAIR, "N/m", "hydrostatic stiffness"),
    "inertia_matrix": Quantity(PAIR, "kg", "inertia of buoy and shell"),
    "mooring_stiffness": Quantity(PAIR, "N/m", "stiffness of the mooring"),
    "azimuthal_order": Quantity(
        ("influenced_dof",), "1", "azimuthal order m of the motion, which goes with cos(m theta)"
    ),
    "structural_stiffness": Quantity(PAIR, "N/m", "structural stiffness of the shell"),
    "structural_damping_matrix": Quantity(PAIR, "kg/s", "structural damping of body and shell"),
    "prestress_stiffness": Quantity(PAIR, "N/m", "stiffness of the mean pressure difference"),
    "gas_stiffness": Quantity(PAIR, "N/m", "stiffness of the trapped gas"),
    "pole_radial_displacement": Quantity(
        ("influenced_dof",), "1", "radial displacement at the top pole per unit amplitude"
    ),
    "reference_amplitude": Quantity(
        ("influenced_dof",), "m", "heave and modal amplitudes of the shape the coefficients are about"
    ),
    # radiation model
    "kernel": Quantity(("time", *PAIR), "kg/s^2", "retardation kernel"),
    "kernel_state_space": Quantity(("time", *PAIR), "kg/s^2", "retardation kernel of the state space"),
    "damping_state_space": Quantity(("omega", *PAIR), "kg/s", "radiation damping of the state space"),
    "state_matrix": Quantity(("state", "state_in"), "1/s", "state matrix A = J - l l^T/2"),
    "input_matrix": Quantity(("state", "radiating_dof"), "kg^0.5/s", "input matrix G; output G^T"),
    "channel": Quantity(("state", "..."), "s^-0.5", "radiation channels L: radiated power |L^T x|^2/2"),
    # frequency response
    "rao": Quantity(("...", "design", "omega", "dof"), "m/m", "response amplitude operator"),
    "absorbed_power": Quantity(("...", "design", "omega"), "W/m^2", "mean absorbed power per squared wave amplitude"),
    "power_limit": Quantity(("omega",), "W/m^2", "theoretical limit, capture width of wavelength/(2 pi)"),
    "port_impedance": Quantity(("design", "omega"), "N s/m", "impedance the take-off sees"),
    "port_velocity": Quantity(("...", "design", "omega"), "1/s", "velocity of the free port per wave amplitude"),
    "best_damping": Quantity(("design", "omega"), "N s/m", "damper that takes most at one frequency"),
    "best_power": Quantity(("...", "design", "omega"), "W/m^2", "mean power it takes per squared wave amplitude"),
    "matched_power": Quantity(
        ("...", "design", "omega"), "W/m^2", "mean power of the best force per squared wave amplitude"
    ),
    "wet_natural_frequency": Quantity(("wet_mode",), "rad/s", "natural angular frequency in water"),
    "wet_damping_ratio": Quantity(("wet_mode",), "1", "damping ratio in water, power take-off included"),
    "wet_design": Quantity(("wet_mode",), "1", "design of the wet mode"),
    # shape dependence
    "added_mass_slope": Quantity(("shape_dof", "omega", *PAIR), "kg/m", "derivative of added mass by the shape"),
    "added_mass_curvature": Quantity((*_SHAPE_PAIR, "omega", *PAIR), "kg/m^2", "its second derivative"),
    "radiation_damping_slope": Quantity(("shape_dof", "omega", *PAIR), "kg/(m s)", "derivative of radiation damping"),
    "radiation_damping_curvature": Quantity((*_SHAPE_PAIR, "omega", *PAIR), "kg/(m^2 s)", "its second derivative"),
    "excitation_force_slope": Quantity(("shape_dof", *_EXCITATION), "N/m^2", "derivative of the excitation force"),
    "excitation_force_curvature": Quantity((*_SHAPE_PAIR, *_EXCITATION), "N/m^3", "its second derivative"),
    "added_mass_inf_slope": Quantity(("shape_dof", *PAIR), "kg/m", "derivative of added mass at infinite frequency"),
    "added_mass_inf_curvature": Quantity((*_SHAPE_PAIR, *PAIR), "kg/m^2", "its second derivative"),
    **{
        f"{name}_slope_error": Quantity(("shape_dof",), "1", "estimated relative error of the derivative")
        for name in ("added_mass", "radiation_damping", "excitation_force", "added_mass_inf")
    },
    "power_slope": Quantity(("design", "shape_dof", "omega"), "W/m^3", "derivative of absorbed power by the shape"),
    "power_swing": Quantity(("design", "omega"), "W/m^3", "largest first-order change of power over a cycle"),
    "power_undeformed": Quantity(("design", "omega"), "W/m^2", "first-order change with coefficients of the sphere"),
    "interpolation_error": Quantity(("expansion", "deformation"), "1", "relative error of the expansion"),
    "deformation": Quantity(("deformation",), "m", "size of the deformations tried"),
    "shape_reach": Quantity(("shape_dof",), "m", "largest amplitude the shape database holds"),
    "remainder": Quantity(_BY_COEFFICIENT, "1/m^3", "a sixth of the third derivative, relative"),
    "remainder_scale": Quantity(("coefficient",), "1", "estimated error in terms of the remainder"),
    "reference_error": Quantity(("coefficient",), "1", "relative error of the shape database at the reference shape"),
    "slope_noise": Quantity(_BY_COEFFICIENT, "1/m", "error of the first derivative in terms of the coefficient"),
    "tried_shape": Quantity(("tried", "shape_dof"), "m", "amplitudes of the shapes errors are measured on"),
    "tried_error": Quantity(("tried", "coefficient"), "1", "relative error measured there"),
    "power_at_shape": Quantity(("design", "wave", "instant"), "W", "mean power, coefficients of one instant's shape"),
    "power_at_rest": Quantity(("design", "wave"), "W", "mean power, coefficients of the shape at rest"),
    "power_at_reference": Quantity(("design", "wave"), "W", "mean power, coefficients of the reference shape"),
    # witness: two solvers on the mean and on deformed shapes
    "shape_added_mass": Quantity((*_BY_SHAPE, *PAIR), "kg", "added mass on a shape"),
    "shape_radiation_damping": Quantity((*_BY_SHAPE, *PAIR), "kg/s", "radiation damping on a shape"),
    "shape_excitation_force": Quantity((*_BY_SHAPE, *_EXCITATION[1:]), "N/m", "excitation force on a shape"),
    "deformation_amplitude": Quantity(("shape",), "m", "modal amplitude a shape is deformed by"),
    "witness_difference": Quantity((*_BY_SHAPE[1:], "coefficient"), "1", "difference of two solvers, relative"),
    "witness_estimate": Quantity(
        ("solver", "shape", "coefficient"), "1", "relative error a solver estimates of itself"
    ),
    "witness_seconds": Quantity(("solver", "shape"), "s", "time a solver took for a shape"),
    "slope_difference": Quantity(
        ("shape_dof", "omega", "coefficient"), "1", "relative difference of two solvers in the derivative by the shape"
    ),
    "slope_estimate": Quantity(("shape_dof", "coefficient"), "1", "relative difference to be expected there"),
    # a site's year
    "hs": Quantity(("hs",), "m", "significant wave height at the centres of bins"),
    "te": Quantity(("te",), "s", "energy period at the centres of bins"),
    "annual_mean_power": Quantity(_YEAR, "W", "mean power over the year"),
    "annual_energy": Quantity(_YEAR, "MWh", "energy of a year of 8766 hours"),
    "capture_width": Quantity(_YEAR, "m", "mean power of the year over its mean energy flux"),
    "force_rms": Quantity(_YEAR, "N", "root mean square of the take-off's force over the year"),
    "gain_percent": Quantity(_YEAR, "%", "gain of annual energy over the reference under the same tuning"),
    "gain_low": Quantity(_YEAR, "%", "least gain, by the errors of numbers of linear theory"),
    "gain_high": Quantity(_YEAR, "%", "largest gain, by the errors of numbers of linear theory"),
    "corrected_mean_power": Quantity(_YEAR[:2], "W", "mean power over the year, corrected by runs in time"),
    "corrected_power_low": Quantity(_YEAR[:2], "W", "least corrected mean power, 95 % by the scatter of the seas run"),
    "corrected_power_high": Quantity(_YEAR[:2], "W", "largest corrected mean power, 95 % by that scatter"),
    "corrected_gain_percent": Quantity(_YEAR[:2], "%", "gain of corrected mean power over the reference"),
    "corrected_gain_low": Quantity(_YEAR[:2], "%", "least corrected gain, 95 % by the scatter of the seas run"),
    "corrected_gain_high": Quantity(_YEAR[:2], "%", "largest corrected gain, 95 % by that scatter"),
    **{
        f"{begin}_{name}": Quantity(_YEAR[:2], unit, f"{what} by {runs} in time under the tuning that is verified")
        for begin, runs in (("body_exact", "body-exact runs"), ("in_time", "linear runs"))
        for name, unit, what in (
            ("mean_power", "W", "mean power over the year"),
            ("power_low", "W", "least mean power over the year, 95 %,"),
            ("power_high", "W", "largest mean power over the year, 95 %,"),
            ("gain_percent", "%", "gain over the reference"),
            ("gain_low", "%", "least gain over the reference, 95 % and errors of linear theory,"),
            ("gain_high", "%", "largest gain over the reference, 95 % and errors of linear theory,"),
        )
    },
    "energy_beyond": Quantity((*_YEAR, "limit"), "1", "share of energy from seas beyond a limit of linear theory"),
    "energy_beyond_validity": Quantity(_YEAR, "1", "share of energy from seas too steep, breaking or deforming much"),
    "beyond_validity": Quantity((*_YEAR, *_BINS), "1", "share of the seas of a bin that are such"),
    "drawn_sea": Quantity(("draw",), "1", "index of the sea in the climate"),
    "drawn_seed": Quantity(("draw",), "1", "seed of its phases"),
    "drawn_hs": Quantity(("draw",), "m", "its significant wave height"),
    "drawn_te": Quantity(("draw",), "s", "its energy period"),
    "drawn_weight": Quantity(("draw",), "1", "its share of the year over its chance to be drawn"),
    "run_power": Quantity(("design", "draw"), "W", "mean power of the run in time"),
    "linear_run_power": Quantity(("design", "draw"), "W", "mean power of linear theory in the same waves"),
    "drawn_power": Quantity(("design", "draw"), "W", "mean power of linear theory in all waves of the drawn sea"),
    "tried_damping": Quantity(("...", "design", "damper"), "N s/m", "dampers that stay as they are all year"),
    "power_of_damping": Quantity(("...", "design", "damper"), "W", "mean power over the year they take"),
    "force_of_damping": Quantity(("...", "design", "damper"), "N", "root mean square of their force over the year"),
    "viable": Quantity(("...", "design"), "1", "whether a design rests stably; results of others are missing"),
    "margin": Quantity(("...",), "1", "1 - static load over buckling load; below 0 the shell would buckle"),
    "practice_power": Quantity(_YEAR, "W", "mean power if seas were JONSWAP at the centres of bins"),
    "quadrature_error": Quantity(
        _YEAR, "W", "error of mean power by the quadrature over frequency; of optima half their 95 % interval"
    ),
    "power_bound": Quantity(_YEAR[:2], "W", "what no force within the limits takes of the year, proved"),
    "optimum_gap": Quantity(_YEAR[:2], "1", "distance of the optima from that bound, over it"),
    "optimum_share": Quantity(_YEAR[:2], "1", "share of the year's energy flux in the bins whose optima are known"),
    "optimum_excess": Quantity(_YEAR[:2], "1", "largest part by which a limit is exceeded between instants"),
    "impossible_share": Quantity(_YEAR[:2], "1", "share of the year in which no force keeps the stroke limit"),
    "damping": Quantity((*_YEAR, *_BINS), "N s/m", "mean damper of the seas of a bin, 0 where there is none"),
    "power_matrix": Quantity((*_YEAR, *_BINS), "W", "mean power in a bin, 0 where there is no sea"),
    "power_deviation": Quantity((*_YEAR, *_BINS), "W", "standard deviation of mean power within a bin"),
    "capture_width_matrix": Quantity((*_YEAR, *_BINS), "m", "mean capture width in a bin, 0 where there is no sea"),
    "capture_width_deviation": Quantity((*_YEAR, *_BINS), "m", "standard deviation of capture width within a bin"),
    "count": Quantity(_BINS, "1", "number of seas in a bin"),
    "occurrence": Quantity(_BINS, "1", "share of the year of a bin"),
    "flux_matrix": Quantity(("...", *_BINS), "W/m", "mean energy flux in a bin, 0 where there is no sea"),
    # trajectories
    "stroke": Quantity(("time",), "m", "displacement of the take-off's port"),
    "stroke_rate": Quantity(("time",), "m/s", "velocity of the take-off's port"),
    "position": Quantity(_MOTION, "m", "heave and modal amplitudes"),
    "velocity": Quantity(_MOTION, "m/s", "rates of heave and modal amplitudes"),
    "excitation": Quantity(_MOTION, "N", "wave excitation force"),
    "pto": Quantity(_MOTION, "N", "power take-off force"),
    "drag": Quantity(_MOTION, "N", "quadratic drag"),
    "end_stop": Quantity(_MOTION, "N", "force of the end stop"),
    "hydrostatic": Quantity(_MOTION, "N", "hydrostatic force"),
    "froude_krylov": Quantity(_MOTION, "N", "Froude-Krylov force on the instantaneous wet shell"),
    "diffraction": Quantity(_MOTION, "N", "diffraction force"),
    "preload": Quantity(_MOTION, "N", "elastic force that carries the mean load"),
    "weight": Quantity(_MOTION, "N", "weight"),
    "radiation": Quantity(_MOTION, "N", "radiation memory force"),
    "elastic": Quantity(_MOTION, "N", "elastic force of the shell"),
    "mooring": Quantity(_MOTION, "N", "force of the mooring"),
    "prestress": Quantity(_MOTION, "N", "force of the mean pressure difference"),
    "gas": Quantity(_MOTION, "N", "force of the trapped gas"),
    "structural_damping": Quantity(_MOTION, "N", "structural damping force"),
    "elevation": Quantity(("time",), "m", "undisturbed wave elevation at the buoy's axis"),
    "volume": Quantity(("time",), "m^3", "volume the shell encloses"),
    "area": Quantity(("time",), "m^2", "surface area of the shell"),
    "energy": Quantity(("time", "term"), "J", "energy since the start"),
}

_LABELS = (
    "mode",
    "influenced_dof",
    "radiating_dof",
    "dof",
    "design",
    "term",
    "complex",
    "wet_design",
    "shape_dof",
    "other_shape_dof",
    "coefficient",
    "wave",
    "expansion",
    "solver",
    "shape",
    "tuning",
    "reason",
    "member",
    "limit",
    "error",
)


AT_VOLUME = {
    "port_impedance": "Pa s/m^3", "port_velocity": "m^2/s", "best_damping": "Pa s/m^3", "damping": "Pa s/m^3",
    "tried_damping": "Pa s/m^3", "force_rms": "Pa", "force_of_damping": "Pa",
}  # fmt: skip
"""Units of what a take-off sees of a volume, and of what it does there: pressure against volume flow."""
AT_ROTATION = {
    "port_impedance": "N m s", "port_velocity": "rad/(m s)", "best_damping": "N m s", "damping": "N m s",
    "tried_damping": "N m s", "force_rms": "N m", "force_of_damping": "N m", "stroke": "rad", "stroke_rate": "rad/s",
}  # fmt: skip
"""Likewise of a rotation: moment against angular velocity."""


def described(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with dimensions in order and units on everything.

    Coordinates an attribute `varied` names, keys of a study, have units of their own; "..." are their dimensions. Where
    an attribute `port` says that a take-off acts on the volume or on a rotation, what it sees has units of that port.

    Raises
    ------
    DatabaseError
        If a variable is not in `ATTRS`.
    """
    varied = set(str(ds.attrs.get("varied", "")).split())
    if unknown := {str(name) for name in ds.variables} - set(ATTRS) - set(_LABELS) - varied:
        raise DatabaseError(f"variables {sorted(unknown)} are not in ATTRS of vsb/tools/units.py; add them there.")
    port = str(ds.attrs.get("port", ""))
    turned = port.startswith("pitch") or "against angular velocity" in port
    units = AT_VOLUME if port.startswith("volume") else AT_ROTATION if turned else {}
    known = {
        name: _told(ds.variables[name], ATTRS[str(name)], units.get(str(name)))
        for name in ds.variables
        if name in ATTRS and name not in varied
    }
    reordered = {name: variable for name, variable in known.items() if variable.dims != ds.variables[name].dims}
    out = ds.assign(reordered).set_coords(set(reordered) & set(ds.coords)) if reordered else ds.copy()
    for name, variable in known.items():
        out.variables[name].attrs = variable.attrs
    return out


def _told(variable: "xr.Variable", quantity: Quantity, units: str | None = None) -> "xr.Variable":
    """A variable with its dimensions in order, its units or others in their place, and its meaning."""
    ordered = variable.transpose(*(... if dim == "..." else dim for dim in quantity.dims))
    ordered.attrs = {"units": units or quantity.units, "long_name": quantity.long_name}
    return ordered


def separated(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with complex variables as reals on a dimension `complex` = re, im (capytaine's form)."""
    import xarray as xr  # half a second, which commands that read no data do not wait for

    out = ds.copy()
    for name, variable in ds.data_vars.items():
        if np.iscomplexobj(variable):
            parts = xr.concat([variable.real, variable.imag], dim="complex").assign_coords(complex=["re", "im"])
            out[name] = parts.assign_attrs(variable.attrs)
    return out


def merged(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with complex variables put together again: the inverse of `separated`.

    Raises
    ------
    DatabaseError
        If a dimension of that name holds anything but real and imaginary parts.
    """
    if "complex" not in ds.dims:
        return ds
    if sorted(labels := [str(label) for label in ds["complex"].values]) != ["im", "re"]:
        raise DatabaseError(f"dimension complex: received {', '.join(labels)}, needs re, im")
    parts = {
        name: (v.sel(complex="re", drop=True) + 1j * v.sel(complex="im", drop=True)).assign_attrs(v.attrs)
        for name, v in ds.data_vars.items()
        if "complex" in v.dims
    }
    return ds.assign(parts).drop_vars("complex")


GAINS = ("gain_", "corrected_gain_", "body_exact_gain_", "in_time_gain_")
"""Begins of names of what is missing where the design that gains are over takes nothing."""
UNTOLD = {"practice_power": "constrained"}
"""Variables that do not exist under a tuning: usual practice knows no optima."""


def check_finite(ds: "xr.Dataset", source: str) -> None:
    """Raise `DatabaseError` if any number of the dataset is NaN or infinite.

    But of designs that are not `viable`, of what a tuning has not (`UNTOLD`), and of gains over nothing (`GAINS`).
    """
    for name, numbers in ds.variables.items():
        if not np.issubdtype(numbers.dtype, np.number) or np.isfinite(numbers.values).all() or name in ds.coords:
            continue
        variable = ds[name]
        missing = ~ds.viable if "viable" in ds and "design" in variable.dims else False
        if "tuning" in variable.dims and name in UNTOLD:
            missing = missing | (ds.tuning == UNTOLD[name])
        if str(name).startswith(GAINS):
            power = ds["corrected_mean_power" if "annual_mean_power" not in ds else "annual_mean_power"]
            missing = missing | (power <= 0).any("design")
        if not (np.isfinite(variable) | missing).all():
            raise DatabaseError(f"{source}: variable {name} holds NaN or infinite values; this result cannot be used.")
