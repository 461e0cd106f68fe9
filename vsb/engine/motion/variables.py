"""Variables of motion in files: frequency response and trajectories."""

from vsb.tools.variables import Variable, at_port, register

_MOTION, _BAND = ("time", "dof"), ("design", "omega")
_IN_WAVES, _IN_SEA = ("...", *_BAND), ("design", "wave")
_WET = "natural angular frequency in water; of a shell to twice the end of the band, and the first above"

register(
    {
        # frequency response
        "rao": Variable(("...", "design", "omega", "dof"), "m/m", "response amplitude operator"),
        "absorbed_power": Variable(_IN_WAVES, "W/m^2", "mean absorbed power per squared wave amplitude"),
        "power_limit": Variable(("omega",), "W/m^2", "theoretical limit, capture width of wavelength/(2 pi)"),
        "port_impedance": Variable((*_BAND, "..."), at_port("damping_unit"), "mechanical impedance of the port"),
        "port_velocity": Variable(
            _IN_WAVES, at_port("rate_per_amplitude"), "velocity of the free port per wave amplitude"
        ),
        "best_damping": Variable(_BAND, at_port("damping_unit"), "optimal damping at one frequency"),
        "best_power": Variable(_IN_WAVES, "W/m^2", "mean power at that damping per squared wave amplitude"),
        "matched_power": Variable(_IN_WAVES, "W/m^2", "largest mean power of any force per squared wave amplitude"),
        "wet_natural_frequency": Variable(("wet_mode",), "rad/s", _WET),
        "wet_damping_ratio": Variable(("wet_mode",), "1", "damping ratio in water, power take-off included"),
        # dependence of the power on the shape of the coefficients
        "power_slope": Variable(("design", "shape_dof", "omega"), "W/m^3", "derivative of absorbed power by the shape"),
        "power_swing": Variable(_BAND, "W/m^3", "largest first-order change of power over a cycle"),
        "power_undeformed": Variable(
            _BAND, "W/m^2", "first-order change of power with motion on the undeformed sphere"
        ),
        "power_at_shape": Variable(
            (*_IN_SEA, "instant"), "W", "mean power with the coefficients of the shape at one instant"
        ),
        "power_at_rest": Variable(_IN_SEA, "W", "mean power with the coefficients of the shape at rest"),
        "power_at_reference": Variable(_IN_SEA, "W", "mean power with the coefficients of the reference shape"),
        # trajectories
        "stroke": Variable(("time",), at_port("motion_unit"), "displacement of the take-off's port"),
        "stroke_rate": Variable(("time",), at_port("rate_unit"), "velocity of the take-off's port"),
        "position": Variable(_MOTION, "m", "heave and modal amplitudes"),
        "velocity": Variable(_MOTION, "m/s", "rates of heave and modal amplitudes"),
        "excitation": Variable(_MOTION, "N", "wave excitation force"),
        "pto": Variable(_MOTION, "N", "power take-off force"),
        "drag": Variable(_MOTION, "N", "quadratic drag"),
        "end_stop": Variable(_MOTION, "N", "force of the end stop"),
        "hydrostatic": Variable(_MOTION, "N", "hydrostatic force"),
        "froude_krylov": Variable(_MOTION, "N", "Froude-Krylov force on the instantaneous wet shell"),
        "diffraction": Variable(_MOTION, "N", "diffraction force"),
        "preload": Variable(_MOTION, "N", "elastic force balancing the mean load"),
        "weight": Variable(_MOTION, "N", "weight"),
        "radiation": Variable(_MOTION, "N", "radiation memory force"),
        "elastic": Variable(_MOTION, "N", "elastic force of the shell"),
        "mooring": Variable(_MOTION, "N", "force of the mooring"),
        "prestress": Variable(_MOTION, "N", "force of the prestress by the mean pressure difference"),
        "internal_pressure": Variable(_MOTION, "N", "force of the pressure inside a shell of rubber"),
        "gas": Variable(_MOTION, "N", "force of the trapped gas"),
        "structural_damping": Variable(_MOTION, "N", "structural damping force"),
        "viscous": Variable(_MOTION, "N", "force of the viscous branches of the shell's material"),
        "elevation": Variable(("time",), "m", "undisturbed wave elevation at the buoy's axis"),
        "power_absorbed": Variable(("time",), "W", "power absorbed by the take-off, its spring left out"),
        "energy": Variable(("time", "term"), "J", "energy since the start"),
    }
)
