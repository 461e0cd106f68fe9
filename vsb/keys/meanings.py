"""What every key of a study and of a body file means, once: for editors, the reference of the keys, and help.

Keys of kinds of waves and of materials stand at their classes, as `KEYS`.
"""

from collections.abc import Mapping
from typing import NamedTuple


class Key(NamedTuple):
    """Unit (`-` of pure numbers, empty of words and sections), an example as YAML, and the meaning in one line."""

    unit: str
    example: str
    meaning: str
    at_port: str = ""  # where the unit depends on the port: field of `vsb.tools.variables.PortKind`


_SEAS_GO_TO = Key("degrees", "0.0", "direction all seas of the year travel to, from the x axis; for a body only")

_HULL = {
    "draft": Key("m", "2.0", "depth of the lowest point below still water"),
    "panel": Key("m", "0.5", "size of the panels"),
}
_HEIGHT = {"height": Key("m", "5.0", "from the lowest point to the highest")}
_RADIUS = {"radius": Key("m", "2.0", "radius of the hull")}
"""Of hulls that are meshed."""

KEYS: dict[str, dict[str, Key]] = {
    "Study": {
        "study": Key("", "my_buoy", "name of the study and of its folder of results"),
        "device": Key(
            "",
            "{radius: 2.0, thickness: 0.01, young_modulus: 1.0e+7, poisson_ratio: 0.3, density: 2700.0, mass: 17170.0}",
            "the spherical buoy, shell and ballast",
        ),
        "motion": Key("", "planar", "directions of the buoy: heave; planar: surge, heave, pitch; free: all six"),
        "modes": Key("", "{tolerance: 0.005}", "shell modes the motion is made of"),
        "reference_shape": Key(
            "", "equilibrium", "shape the coefficients are about: the sphere, or that of the loaded shell at rest"
        ),
        "designs": Key(
            "", "{FSB: {flexible: false}, VSWEC: {}}", "buoys compared; the first rigid one by name is the reference"
        ),
        "water": Key("", "{density: 1025.0, depth: 50.0}", "the sea without its waves"),
        "mooring": Key(
            "N/m, N, N m",
            "[2.0e+4, 0, 0, 0, 0, 0]",
            "spring over surge, sway, heave, roll, pitch, yaw about the sphere's centre: six rows of six numbers, or "
            "the six of its diagonal",
        ),
        "hydro": Key("", "{model: linear, tolerance: 1.0e-3}", "hydrodynamic model and its accuracy"),
        "pto": Key("", "{damping: 8000.0}", "power take-off"),
        "drag": Key("", "{heave: {coefficient: 0.5, area: 12.57}}", "quadratic drag on rigid motion past the water"),
        "waves": Key("", "[{kind: jonswap, hs: 1.0, tp: 5.0}]", "seas; every design is simulated in each"),
        "simulation": Key("", "{duration: 600.0, window: [100.0, 600.0]}", "runs in time"),
        "published": Key(
            "",
            "{source: a paper, values: {FSB: {energy: 43420.0}}}",
            "figures from elsewhere, printed beside the study's own",
        ),
    },
    "Device": {
        "radius": Key("m", "2.0", "radius of the undeformed sphere, or largest radius of another shape"),
        "shape": Key(
            "", "{spheroid: {height: 3.0}}", "another shape at rest than the sphere: spheroid, capsule, profile"
        ),
        "thickness": Key("m", "0.01", "thickness of the shell; thin-shell theory needs less than radius/10"),
        "young_modulus": Key("Pa", "1.0e+7", "Young's modulus of the shell; required without a material"),
        "poisson_ratio": Key("-", "0.3", "Poisson's ratio of the shell; required without a material"),
        "material": Key("", "{law: neo_hookean, mu: 4.0e+5}", "material by name, or law of elasticity of the shell"),
        "density": Key("kg/m^3", "2700.0", "density of the shell's material; required unless that is given by name"),
        "mass": Key("kg", "17170.0", "mass of shell and ballast together; it decides the draft"),
        "draft": Key("m", "2.0", "in place of the mass: depth of the keel; without both the sphere is half immersed"),
        "internal_pressure": Key(
            "Pa", "20000.0", "gauge pressure inside: prestress that keeps the shell from buckling"
        ),
        "gas": Key("", "{adiabatic_index: 1.4}", "gas trapped inside; without it the internal pressure is constant"),
        "damping": Key("", "{beta: 1.0e-3}", "structural damping of the shell"),
        "centre_of_mass": Key(
            "m", "-0.5", "height of the whole buoy's centre of mass above the sphere's; pitch needs it"
        ),
        "ballast_inertia": Key(
            "kg m^2", "8000.0", "transverse inertia of the ballast about its own centre of mass; pitch needs it"
        ),
        "ballast_yaw_inertia": Key(
            "kg m^2", "9000.0", "inertia of the ballast about the vertical axis; motion: free needs it"
        ),
    },
    "Shape": {
        "spheroid": Key("", "{height: 3.0}", "ellipsoid of revolution; the radius is that of its equator"),
        "capsule": Key("", "{length: 1.0}", "cylinder between two hemispheres"),
        "series": Key(
            "", "{radial: [1.0, 0.05], axial: [0.8]}", "smooth shape by terms of a series, scaled to the radius"
        ),
        "profile": Key(
            "",
            "profile.csv",
            "points x, z from the top to the keel, both on the axis, as rows or a CSV file beside the study; a smooth "
            "curve through them is scaled to the radius",
        ),
    },
    "Spheroid": {"height": Key("m", "3.0", "height from pole to pole")},
    "Capsule": {"length": Key("m", "1.0", "length of the cylinder; its height is two radii more")},
    "Series": {
        "radial": Key("-", "[1.0, 0.05]", "a_1, a_2, ... of the radius x = sum a_k sin k phi, phi from top to keel"),
        "axial": Key("-", "[0.8, 0.0, 0.1]", "b_1, b_2, ... of the height z = sum b_k cos k phi"),
    },
    "StructuralDamping": {
        "alpha": Key("1/s", "0.0", "damping per modal mass"),
        "beta": Key("s", "1.0e-3", "damping per modal stiffness"),
        "maxwell": Key(
            "", "[{ratio: 0.2, time: 0.5}]", "viscous material: springs in series with dashpots beside the shell"
        ),
    },
    "MaxwellBranch": {
        "ratio": Key("-", "0.2", "stiffness of the branch over that of the shell at rest"),
        "time": Key("s", "0.5", "relaxation time, dashpot over spring; the loss is largest at its inverse in rad/s"),
    },
    "Gas": {
        "adiabatic_index": Key("-", "1.4", "ratio of specific heats; 1 is isothermal"),
        "atmospheric_pressure": Key("Pa", "101325.0", "pressure of the air outside"),
    },
    "Drag": {
        "surge": Key("", "{coefficient: 0.5, area: 6.28}", "drag on surge, past the waves' flow at half the draft"),
        "sway": Key("", "{coefficient: 0.5, area: 6.28}", "likewise on sway"),
        "heave": Key("", "{coefficient: 0.5, area: 12.57}", "likewise on heave"),
        "roll": Key("", "{coefficient: 1.0, area: 2.0, lever: 2.0}", "drag on roll; waves do not turn the water"),
        "pitch": Key("", "{coefficient: 1.0, area: 2.0, lever: 2.0}", "likewise on pitch"),
        "yaw": Key("", "{coefficient: 1.0, area: 2.0, lever: 2.0}", "likewise on yaw"),
    },
    "Vane": {
        "coefficient": Key("-", "1.0", "C of the moment rho C A l^3 |w| w/2, w the rate of the rotation"),
        "area": Key("m^2", "2.0", "A of that moment, of the plate that turns"),
        "lever": Key("m", "2.0", "l of that moment, how far from the sphere's centre the plate turns"),
    },
    "Plate": {
        "coefficient": Key("-", "0.5", "C of the force rho C A |u| u/2, u the velocity past the water"),
        "area": Key("m^2", "12.57", "A of that force, for heave usually that of the waterplane"),
    },
    "Modes": {
        "basis": Key(
            "", "full", "membrane: stretching alone; full: stretching and bending; paper: the publication's own"
        ),
        "order": Key("-", "2", "highest azimuthal order of shell modes, cos(order theta); of motion beside heave"),
        "degree": Key("-", "14", "highest Legendre degree; without it the least that meets `tolerance`"),
        "tolerance": Key(
            "-", "0.005", "change of mean power, relative, and of gain, absolute, that modes left out may cause"
        ),
    },
    "Design": {
        "flexible": Key("", "false", "whether the shell deforms; false is the rigid buoy"),
        "clamp": Key(
            "degrees", "[0, 90]", "colatitudes from the top pole where the shell cannot move against the ballast"
        ),
    },
    "Hydro": {
        "model": Key(
            "",
            "body_exact",
            "linear; body_exact: hydrostatics and Froude-Krylov forces on the instantaneous wet shell; auto: as simple "
            "as power_tolerance allows; assumed_pressure: the paper's loading, without radiation",
        ),
        "pressure": Key("Pa", "1800.0", "amplitude of the pressure of model assumed_pressure, which needs it"),
        "power_tolerance": Key(
            "-", "0.01", "error of mean absorbed power that model auto may cause; 0.01 if not given"
        ),
        "solver": Key(
            "", "panels", "spectral: no mesh; panels: capytaine; auto: panels with rows or in very shallow water"
        ),
        "tolerance": Key("-", "1.0e-3", "error of the coefficients, relative to the largest"),
        "omega_max": Key(
            "rad/s", "12.0", "highest frequency solved; auto: 5.4 sqrt(gravity/radius), more where shell modes need it"
        ),
        "omega": Key("rad/s", "[1.0, 2.0]", "frequencies tabulated in the database, beside those the study chooses"),
        "rows": Key("-", "40", "rows of panels between keel and waterline; asks for panels"),
        "accept": Key("", "[haskind]", "checks of the database whose failure is accepted"),
        "witness": Key("", "none", "auto: a second solver, capytaine, checks the first; none leaves it out"),
    },
    "Pto": {
        "damping": Key(
            "in units of the port",
            "8000.0",
            "damper (heave: N s/m) of all designs, or of each; without it tuning decides",
            "damping_unit",
        ),
        "stiffness": Key(
            "in units of the port",
            "-5000.0",
            "spring beside the damper, N/m in heave; below zero while the buoy rests stably",
            "stiffness_unit",
        ),
        "tuning": Key(
            "",
            "one",
            "fixed: the damper given; each: every design's optimal one in each sea; one: its optimum over all seas",
        ),
        "efficiency": Key(
            "-",
            "0.9",
            "of both directions of power, in control levels but `constrained` and `matched`, in campaigns and designs",
        ),
        "port": Key(
            "",
            "{colatitude: 90}",
            "what the take-off acts on: heave, surge, pitch, a line to the sea bed, a ring of the shell, two points, "
            "its strain, or its volume",
        ),
        "ports": Key(
            "",
            "{heave: heave, shell: {strain: area}}",
            "several ports at once, by name; damping is then a matrix of load over rate, or optimal",
        ),
        "matrix": Key("", "diagonal", "optimal damper matrix of several ports: full, or a damper at each alone"),
        "held": Key("", "{place: heave}", "what the mooring holds of all designs: heave of the frame, or a ring"),
        "law": Key(
            "",
            "coulomb",
            "linear: a damper; saturated: one with a force limit; coulomb: friction of the force limit; latching, "
            "declutching: a damper that holds the port, or lets it go, after each reversal, for the optimal time; "
            "causal: the optimal controller that knows no future waves; "
            "my_package:law: a function of an installed package",
        ),
        "parameters": Key("", "{exponent: 2.0}", "numbers that the law of a package is called with"),
        "distribution": Key("", "my-package 1.0", "name and version of that package; found out if it is not given"),
        "energy_per_cycle": Key(
            "J/kg", "10.0", "of ports of strain: what a kilogram of the shell converts in a cycle at most"
        ),
        "force_limit": Key(
            "in units of the port", "5000.0", "largest force of the take-off, N in heave; .inf is none", "load_unit"
        ),
        "stroke_limit": Key(
            "in units of the port",
            "0.5",
            "motion from rest at which an end stop begins, m in heave; .inf is none",
            "motion_unit",
        ),
        "control": Key("", "{noise: 1.0e-4, forecast: 2.0}", "what the controller of the level `causal` knows"),
    },
    "Control": {
        "noise": Key("-", "1.0e-4", "density of the noise it measures, over the largest of the waves' force"),
        "forecast": Key("s", "2.0", "how far ahead it knows the waves"),
        "force_rms": Key(
            "N",
            "2000.0",
            "rms force of `causal` and `damper_same_force` (a port's own unit of load), of several ports of all forces "
            "together; without it the force limit, or what the optimal damper has",
            "load_unit",
        ),
    },
    "ShellPort": {
        "colatitude": Key("degrees", "90", "ring of the shell the take-off acts on, from the top pole"),
        "direction": Key("", "radial", "direction of the port's motion"),
        "against": Key("", "frame", "what the take-off stands on: the sea bed, or sphere centre and ballast"),
    },
    "StrainPort": {
        "strain": Key(
            "", "area", "stretch of the shell the take-off acts on: change of its area, mean hoop or meridional strain"
        ),
        "belt": Key("degrees", "[60, 120]", "colatitudes that bound the part of the shell; without them all of it"),
    },
    "DistributedPort": {
        "distributed": Key("", "membrane", "damper spread over the shell: damping [s] times its membrane's stiffness")
    },
    "SeveralPorts": {
        "ports": Key("", "{heave: heave, shell: {strain: area}}", "the ports by name"),
        "damping": Key("", "[[1.0e+5, 0.0], [0.0, 2.0e+3]]", "damper matrix, load of each port over rate of each"),
        "matrix": Key("", "diagonal", "form of the optimal matrix if none is given: full, or diagonal"),
    },
    "HeldHeave": {"place": Key("", "heave", "what the mooring holds: heave of the frame, sphere centre and ballast")},
    "HeldRing": {
        "place": Key("", "ring", "what the mooring holds: a ring of the shell, against vertical motion"),
        "colatitude": Key("degrees", "110", "the ring, from the top pole"),
    },
    "LinePort": {
        "line_to": Key("m", "[20.0, -50.0]", "anchor, x from the buoy's axis at rest and z from still water"),
        "line_from": Key("m", "[0.0, -1.5]", "attachment to the frame, x and z from the sphere's centre"),
    },
    "BetweenPort": {"between": Key("degrees", "[0, 180]", "colatitudes of two points the take-off acts between")},
    "DofPort": {
        "dofs": Key(
            "-", "{float__Heave: 1.0, spar__Heave: -1.0}", "degrees of freedom the port moves with, each with its share"
        ),
        "dof": Key("", "Heave", "one degree of freedom the port moves with, in place of dofs"),
    },
    "BodyStudy": {
        "study": Key("", "my_barge", "name of the study and of its folder of results"),
        "body": Key(
            "",
            "{database: barge.nc, mass: {Heave: 4.0e+6}}",
            "what floats, in place of a device: a body file, or a database of this project, capytaine, WAMIT or BEMIO",
        ),
        "designs": Key(
            "",
            "{rigid: {dofs: rigid}, flexible: {}}",
            "variants compared; the first rigid one by name is the reference",
        ),
        "water": Key("", "{density: 1000.0}", "the sea without its waves; of a body file its own if it is left out"),
        "hydro": Key("", "{tolerance: 0.01}", "radiation memory and checks of the coefficients"),
        "pto": Key("", "{damping: 1.0e+6, port: {dof: Mode7}}", "power take-off; its port is of degrees of freedom"),
        "drag": Key("", "{Heave: {coefficient: 1.0, area: 12.0}}", "quadratic drag on the velocity of the body itself"),
        "waves": Key("", "[{kind: jonswap, hs: 1.0, tp: 7.0, direction: 45.0}]", "seas, each with a direction"),
        "simulation": Key("", "{duration: 600.0, window: [100.0, 600.0]}", "runs in time"),
        "published": Key(
            "",
            "{source: a paper, values: {rigid: {power_mean: 43420.0}}}",
            "figures from elsewhere, printed beside the study's own",
        ),
    },
    "Body": {
        "file": Key("", "my_body.yaml", "a body file, as `vsb body` takes; `body: my_body.yaml` is the same"),
        "database": Key("", "body.nc", "a hydro database of this project, or capytaine's; of several bodies too"),
        "wamit": Key("", "folder/name", "WAMIT's files name.1, .3 (or .2), .hst and, if there, .3fk, .3sc and .mmx"),
        "bemio": Key("", "body.h5", "BEMIO's .h5, as WEC-Sim reads it"),
        "length": Key("m", "1.0", "ULEN of WAMIT's run"),
        "bodies": Key("-", "2", "bodies of WAMIT's run (NBODY), which its files state in .mmx only"),
        "modes": Key("-", "[7, 6]", "modes of each of WAMIT's bodies: six, and its generalized ones (NEWMDS)"),
        "mass": Key(
            "kg",
            "{Heave: 4.0e+6, Pitch: 2.1e+9, Surge Pitch: 0.0}",
            "entries of the mass matrix by one or two degrees of freedom, rows by a body, or all rows; in place of the "
            "file's",
        ),
        "damping": Key("N s/m, N m s", "{Mode7: 1.0e+4}", "likewise of structural damping"),
        "stiffness": Key("N/m, N m", "{Surge: 4.0e+4}", "likewise of structure and mooring, without the water's"),
    },
    "BodyDesign": {
        "dofs": Key("", "[Heave, Pitch, Mode7]", "degrees of freedom it moves in: all, rigid, or their names"),
        "held": Key(
            "-",
            "[{float__Heave: 1.0, spar__Heave: -1.0}]",
            "combinations of degrees of freedom that stay zero: clamps, locks and hinges held",
        ),
    },
    "BodyHydro": {
        "model": Key("", "linear", "the only model for bodies"),
        "tolerance": Key("-", "0.01", "error of the radiation memory, relative to each motion's largest damping"),
        "added_mass_inf": Key(
            "", "given", "fitted: added mass at infinite frequency as suits all others; given: as the database has it"
        ),
        "omega_max": Key("rad/s", "3.0", "frequencies of the database above it are left out"),
        "accept": Key("", "[haskind]", "checks of the database whose failure is accepted"),
        "repair": Key("", "[positive_damping, kramers_kronig]", "checks whose cause is repaired, reported as a doubt"),
    },
    "Simulation": {
        "duration": Key("s", "60.0", "time simulated"),
        "window": Key("s", "[40.0, 60.0]", "part of it for means and extremes; without it the last third"),
        "initial_position": Key("m", "0.0", "heave at the start, from rest"),
        "initial_velocity": Key("m/s", "-0.8", "heave velocity at the start"),
        "tolerance": Key("-", "1.0e-6", "error of the motion in time, relative to its largest value"),
        "method": Key(
            "",
            "convolution",
            "auto: exact, or the fastest for the model; convolution: Cummins' integral, the reference",
        ),
    },
    "Published": {
        "source": Key("", "Table II of a paper", "source of the figures"),
        "values": Key("", "{FSB: {energy: 43420.0}}", "design, measure and value, SI units"),
    },
    "SphereHull": {"kind": Key("", "sphere", "a sphere"), **_RADIUS, **_HULL},
    "CylinderHull": {"kind": Key("", "cylinder", "an upright cylinder"), **_RADIUS, **_HEIGHT, **_HULL},
    "CapsuleHull": {
        "kind": Key("", "capsule", "an upright cylinder between two hemispheres"),
        **_RADIUS,
        **_HEIGHT,
        **_HULL,
    },
    "BoxHull": {
        "kind": Key("", "box", "a box"),
        "length": Key("m", "10.0", "length along x"),
        "width": Key("m", "6.0", "width along y"),
        **_HEIGHT,
        **_HULL,
    },
    "ModeFamilies": {
        "rigid": Key("", "[Heave, Pitch]", "rigid motions: true for all, false for none, or their names"),
        "bending": Key("", "{count: 4}", "free-free bending modes of a uniform beam along the hull"),
        "polynomial": Key("", "{count: 4}", "Legendre polynomials from degree 2 along the hull, in place of bending"),
        "hinge": Key("", "{at: [0.0, 0.0]}", "a hinge, or a list of them: both ends of the hull rise by 1 m per unit"),
        "plate": Key("", "{degree: 6}", "bending modes of a round hull as a plate, symmetric about the x-z plane"),
    },
    "RoundPlate": {
        "degree": Key("-", "6", "highest degree of its polynomials"),
        "stiffness": Key("N m", "1.0e+7", "bending stiffness of the plate, E h^3/12(1 - nu^2)"),
        "poisson_ratio": Key("-", "0.3", "Poisson's ratio"),
    },
    "Line": {
        "count": Key("-", "4", "how many modes"),
        "axis": Key("", "x", "direction of the beam"),
        "stiffness": Key("N m^2", "1.0e+10", "bending stiffness EI"),
    },
    "Hinge": {
        "at": Key("m", "[0.0, 0.0]", "where the hinge lies along the axis, and its height above still water"),
        "axis": Key("", "x", "direction the hinge lies across"),
        "stiffness": Key("N m/rad", "1.0e+7", "spring by the angle between the two sides"),
    },
    "PlacedMesh": {
        "file": Key("", "hull.stl", "file of the hull's panels, path from the file's folder"),
        "scale": Key("-", "0.001", "lengths of the file are multiplied by it to be metres"),
        "unit": Key("", "mm", "unit of length of the file, in place of scale"),
        "up": Key("", "y", "axis of the file that points upwards; the hull is turned about the others"),
        "draft": Key("m", "2.0", "depth of the lowest point below still water, to which the hull is moved"),
    },
    "BodyFile": {
        "body": Key("", "raft", "name of the body and of its database"),
        "panel": Key("m", "0.8", "longest edge: larger panels of the mesh, as of CAD, are divided into triangles"),
        "mesh": Key(
            "",
            "raft.stl",
            "file of the hull's panels, normals outward, path from the file's folder; {file: hull.stl, unit: mm, "
            "up: y, draft: 2.0} if it is not in metres, upright or at its draft; or a simple hull: sphere, cylinder, "
            "capsule, box",
        ),
        "modes": Key(
            "",
            "raft_modes.nc",
            "file of the displacements of the mesh's corners; or made here: rigid, a list such as [Heave, Pitch], or "
            "families, {rigid: true, bending: {count: 4}, hinge: {at: [0.0, 0.0]}}",
        ),
        "mass": Key("kg", "displaced", "mass for rigid modes; displaced is that of the displaced water"),
        "density": Key("kg/m^3", "500.0", "mean density in place of a mass; the mesh must be closed above water, too"),
        "centre_of_mass": Key(
            "m",
            "[0.0, 0.0, -1.0]",
            "rotations of rigid modes are about it; without it, that of the mesh filled evenly with the mass",
        ),
        "radii_of_gyration": Key(
            "m",
            "[2.0, 2.0, 3.0]",
            "about the x, y and z axis through the centre of mass; without them, of the mesh filled evenly",
        ),
        "rotation_point": Key(
            "m", "[0.0, 0.0, 0.0]", "rotations of rigid modes are about it, in place of the centre of mass"
        ),
        "water": Key("", "{depth: 20.0}", "the sea without its waves"),
        "omega": Key("rad/s", "[0.5, 1.0, 1.5]", "frequencies of the database"),
        "wave_direction": Key("degrees", "[0.0, 45.0]", "directions the waves travel to, from the x axis"),
        "symmetry": Key("", "xOz+yOz", "planes of symmetry used; auto finds them"),
        "lid": Key(
            "-",
            "8",
            "panels of a lid from the middle to the waterline, at most; it removes irregular frequencies; 0 is none",
        ),
        "tolerance": Key(
            "-",
            "0.01",
            "error of interpolation over frequency: as few frequencies are solved as it allows; without it all",
        ),
    },
    "Campaign": {
        "campaign": Key("", "softness", "name of the campaign and of its folder of results"),
        "study": Key("", "buoy.yaml", "study file, relative to this one; its waves are not used"),
        "vary": Key(
            "",
            "{device.young_modulus: {log: [1.0e+6, 1.0e+9, 7]}, device.thickness: [0.01, 0.02]}",
            "keys of the study, or scale, and their values: every combination; pairs, latin_hypercube",
        ),
        "climate": Key("", "{spectra: sea.txt}", "seas of the year: measured spectra, or a table of occurrences"),
        "tuning": Key(
            "",
            "[one, each, causal]",
            "dampers of the year; causal: a controller that knows no future waves, of the rms force of the limit or of "
            "the optimal damper, scheduled over sea states; damper_same_force: dampers of that force; constrained: the "
            "best force within the take-off's limits",
        ),
        "constrained": Key("", "{seconds: 10.0}", "amount of computation for the optima within limits"),
        "verify": Key("", "{seas: 24}", "seas simulated in time beside linear theory, which they correct"),
    },
    "Optimisation": {
        "design": Key("", "best_buoy", "name of the design problem and of its folder of results"),
        "study": Key(
            "", "buoy.yaml", "study file, relative to this one: all that is not varied; its waves are not used"
        ),
        "optimise": Key(
            "", "VSWEC", "flexible design of the study that is optimised; the first one by name if not given"
        ),
        "climate": Key("", "{spectra: sea.txt}", "seas of the year: measured spectra, or a table of occurrences"),
        "variables": Key(
            "",
            "{device.radius: [1.4, 2.6], device.young_modulus: {log: [1.0e+6, 1.0e+9]}}",
            "keys of the study that are free, each between two bounds; log: by the logarithm. Without pto.damping "
            "every buoy has the damper that is optimal for its year",
        ),
        "tuning": Key(
            "",
            "causal",
            "one: a damper for the year; causal: a controller for the year that knows no future waves, within "
            "limits.force_rms; pto.control of the study says what it knows",
        ),
        "maximise": Key(
            "",
            "power_per_mass",
            "annual_mean_power; gain: over the rigid buoy of the same shape and mass; or power over rms force, mass, "
            "surface, cost",
        ),
        "cost": Key(
            "",
            "{per_kg: 4.0, per_newton: 0.3, per_square_metre: 120.0}",
            "prices, in any currency, of mass, of the take-off's rms force and of the shell's area: for "
            "power_per_cost, and for a limit of cost",
        ),
        "fatigue": Key("", "{exponent: 5.0, strain: 0.6}", "cycles of strain the wall bears, for a limit of damage"),
        "limits": Key("", "{load_factor: 1.5, beam: 4.8, force_rms: 2.0e+4}", "limits that every buoy must satisfy"),
        "competitor": Key("", "{variables: [device.radius, device.mass]}", "the rigid buoy that is also optimised"),
        "starts": Key("-", "8", "how many places the optimiser starts from: the study's own and others spread evenly"),
        "seed": Key("-", "1", "seed of the places it starts from"),
        "pareto": Key("", "{force_rms: [1.0e+4, 2.0e+4]}", "limits whose other values give a Pareto front"),
        "uncertain": Key(
            "-", "{device.young_modulus: 0.1}", "relative standard deviations of inputs, for the interval of the gain"
        ),
        "verify": Key("", "{seas: 48}", "seas in which the best buoys are simulated in time"),
    },
    "Fatigue": {
        "exponent": Key("-", "5.0", "m of the cycles to failure N = cycles (range/strain)^-m"),
        "strain": Key("-", "0.6", "range of strain, from its least to its largest, that the wall bears for `cycles`"),
        "cycles": Key("-", "1.0e+6", "cycles to failure under that range"),
        "years": Key("-", "20.0", "years the wall is to last [a]"),
    },
    "Cost": {
        "per_kg": Key("", "4.0", "price of a kilogram of shell and ballast"),
        "per_newton": Key("", "0.3", "price of a newton of the take-off's rms force over the year"),
        "per_square_metre": Key("", "120.0", "price of a square metre of the shell"),
    },
    "Limits": {
        "load_factor": Key("-", "1.5", "least buckling load over static load"),
        "static_strain": Key("-", "0.1", "largest strain of the shell at rest"),
        "beam": Key("m", "4.8", "largest diameter at rest"),
        "draft": Key("m", "3.0", "depth of the keel at rest"),
        "mass": Key("kg", "20000.0", "mass of shell and ballast"),
        "surface": Key("m^2", "60.0", "area of the shell"),
        "volume": Key("m^3", "40.0", "volume the shell encloses"),
        "force_rms": Key(
            "N", "20000.0", "root mean square of the take-off's force over the year, of several together", "load_unit"
        ),
        "stroke_rms": Key("m", "0.6", "root mean square of the take-off's motion over the year", "motion_unit"),
        "spring_pull": Key(
            "-",
            "0.05",
            "force of a spring below zero at the rms stroke over the most by which the water brings the buoy back: its "
            "weight or, if less, its buoyancy left; at 0.05 it comes back from 20 rms strokes",
        ),
        "cost": Key("-", "5.0e+4", "cost by the prices given, in their currency"),
        "damage": Key("-", "1.0", "fatigue of the wall by Miner's sum over its years; at 1 it is expected to fail"),
        "sigmas": Key(
            "-",
            "2.0",
            "standard deviations by the `uncertain` inputs by which a buoy keeps away from all limits; 0: it may meet "
            "them as designed",
        ),
    },
    "Competitor": {
        "variables": Key(
            "",
            "[device.radius, device.mass]",
            "variables the rigid buoy is optimised in; if not given, every variable it has",
        ),
        "port": Key(
            "",
            "heave",
            "its take-off acts on heave whatever `pto.port` of the study; needed where a rigid buoy does not move that "
            "port. Its damper is then the optimal one, unless both take-offs act with a force: then it has the same "
            "variables and limits; if not given, the port of the study",
        ),
    },
    "Spectra": {
        "spectra": Key("", "sea.txt.gz", "spectra: NDBC's text, plain or gz, SWAN's text, or netCDF"),
        "direction": _SEAS_GO_TO,
    },
    "Scatter": {
        "scatter": Key("", "site.csv", "table of occurrences over significant height and period"),
        "spectrum": Key("", "jonswap", "form of the spectra of its cells"),
        "gamma": Key("-", "3.3", "peak enhancement of JONSWAP"),
        "direction": _SEAS_GO_TO,
    },
    "Constrained": {
        "seconds": Key(
            "s",
            "10.0",
            "budget of each design at each point, in seconds of a usual core; counted in operations, not by the clock",
        ),
        "seed": Key("-", "1", "seed of the phases of the waves"),
    },
    "Verify": {
        "seas": Key("-", "12", "how many seas, two from each stratum of the year's energy"),
        "model": Key("", "body_exact", "hydrodynamics of the runs"),
        "seed": Key("-", "1", "seed of the draw and of the phases"),
    },
}
"""Section of the models -> key -> what it means."""
AT_PORT = {f"pto.{name}": key.at_port for name, key in KEYS["Pto"].items() if key.at_port}
"""Keys of a take-off whose units depend on its port: field of `PortKind`."""
UNITS: dict[str, str] = {}
"""Units of numbers by the last word of their key, SI where they are several; others have none."""


def describe(section: str, keys: Mapping[str, Key]) -> None:
    """Say what the keys of a section mean."""
    KEYS[section] = dict(keys)
    for name, key in keys.items():
        if key.unit not in ("", "-"):
            UNITS[name] = key.unit if UNITS.get(name, key.unit) == key.unit else "SI"


for _section in [*KEYS]:
    describe(_section, KEYS[_section])
