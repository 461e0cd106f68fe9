"""Captions of a study's figures: what is drawn, in words."""

CAPTIONS = {
    "absorbed_power": "Mean absorbed power per squared wave amplitude over the whole band{gain}: {dampers}; grey: "
    "{limit}.{useful}",
    "reactance": "Why: the take-off sees a design as one impedance R + iX. The best damper takes the share "
    "2/(1 + √(1 + Q²)) of what any take-off could, Q = |X|/R{same}.",
    "spectra": "Spectra of the irregular seas; runs have components up to the highest frequency of the study alone.",
    "mode_shapes": "Shapes of the shell modes and their natural frequencies in vacuum. Points of the shell also move "
    "along it, which crowds them where the meridian is drawn narrow.",
    "added_mass_damping": "Added mass (dashed: at infinite frequency) and radiation damping of {moving}.",
    "radiation_kernel": "Retardation kernel: from the damping, and of the passive state space the time domain uses.",
    "witness": "Two solvers that share nothing but the shape, capytaine's panels and the spectral integral equation: "
    "how far apart they are on the mean shell and on shells deformed by each mode, in terms of the largest entry at "
    "each frequency, beside what their own estimates allow; what deformation does to heave's coefficients (panels "
    "dots, spectral solver open); in deep water also how far apart derivatives of the coefficients by the modes are.",
    "port_motion": "Displacement and velocity of the take-off's port.",
    "degrees_of_freedom": "How far every degree of freedom moves, take-off at work.",
    "heave_excitation": "Heave and the heave component of the excitation force.",
    "directions": "Surge, heave and pitch, of the top towards where the waves go, or all six motions. Without "
    "a mooring nothing holds surge, sway and yaw: what the start gives them, they keep.",
    "velocity_pto": "Heave velocity and power take-off force.",
    "power_energy": "Instantaneous absorbed power, and absorbed energy since the start.",
    "extreme_shapes": "Shells of all designs at their least height from pole to pole, displacement magnified.",
    "shapes_3d": "The first flexible design: at the start and at its least and greatest height from pole to pole in "
    "the window, displacement magnified. A shell that breathes is small at the one and large at the other.",
    "volume_area": "Volume enclosed by the shell and its surface area.",
    "energy_audit": "Where the work of the wave or the assumed pressure (black mark) went, start-up transient "
    "included. Stored is what motion, water and shell hold at the end beyond what they held at the start; below "
    "zero, they have given up what the run was started with.",
    "snapshots": "The buoys over the last period (dotted: undeformed). Shell displacement is magnified as said above "
    "the figure, heave and wave are to scale.",
}
HEAVE = "heave and modes. Heave (dotted) lies upon the mode of degree 1 where that moves the surface as heave does"
OF_THE_RESPONSE = ("absorbed_power", "reactance")
"""Figures of the frequency response, which knows no amplitude."""
OWN = "each design at its own best damper at every frequency"
LIMIT = "a capture width of a wavelength over 2π"
HEAVING = f"{LIMIT}, the limit of an axisymmetric heaving body"
REVOLUTION = "a body of revolution at this port"
SAME = (
    ", and that limit is the same for all shells but for their structural loss: under a best damper flexibility pays "
    "if and only if it lowers Q"
)


def captions(neglected: str = "", *, given: bool, body: bool, limit: str = "", compared: bool = True) -> dict[str, str]:
    """Return the captions of a study's figures by kind.

    Parameters
    ----------
    neglected : str
        What the frequency response leaves out, in words.
    given : bool
        Whether a damper is given, at which powers are drawn beside those of the best ones.
    body : bool
        Whether it is no buoy of revolution, whose limit is known whatever its shell.
    limit : str
        The capture width of that limit where the port reaches more than heave.
    compared : bool
        Whether there is a rigid design, and another, whose gain is drawn.
    """
    words = {
        "dampers": f"left {OWN}, right at the given damper" if given else OWN,
        "limit": LIMIT if body else f"a capture width of {limit}, the limit of {REVOLUTION}" if limit else HEAVING,
        "gain": ", and the gain over the rigid design" if compared else "",
        "useful": " Gains are drawn where at least 5 % of the largest power is absorbed." if compared else "",
        "same": "" if body else SAME,
        "moving": "all degrees of freedom; dotted: heave" if body else HEAVE,
    }
    found = {name: text.format(**words) for name, text in CAPTIONS.items()}
    return found | ({name: f"{neglected.capitalize()}: {found[name]}" for name in OF_THE_RESPONSE} if neglected else {})
