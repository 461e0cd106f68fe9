"""CPU time and memory of tasks, measured, and whether they fit into this machine.

Seconds are of one core of a desktop machine that does nothing else; on a busy one a core does half as much in a second.
"""

import math
from collections.abc import Collection

import psutil

from vsb.engine.hydro.bodies.body_file import SECONDS as SECONDS_PER_PANEL2
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.integrators.settings import RECORDS_PER_PERIOD, thinning
from vsb.engine.motion.take_off import DistributedPort, SeveralPorts
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.water import Water
from vsb.study.campaign import CAUSAL
from vsb.study.resolution import AnyBlock, degree_needed, wets_rings
from vsb.study.specs import PanelsBlock, VerificationSpec
from vsb.study.study import Study

WORKFLOW_SECONDS, JOB_SECONDS = 6.0, 2.3
"""Of Snakemake and the plan, and of a job that does nothing: a process, its imports, what Snakemake does of it."""
START_OF_A_PROCESS = 2.0
"""Of Python, its imports, and what is checked before a run."""
GREEN_SECONDS, GREEN_KEPT_SECONDS = 20.0, 0.2
"""Of the Green-function table of panels: computed once on a machine, then copied."""
OF_MOTIONS = {
    "display": (0.02, 0.001), "radiation": (0.2, 0.015), "response": (0.15, 0.007), "simulate": (0.0, 0.006),
    "figures": (0.0, 0.006),
}  # fmt: skip
"""Of stages, once and for each motion: of the shell, in response and figures of each flexible design. Measured with 13
to 121 motions, as all that depends on them."""
SPECTRAL_MEGABYTES = 0.06
"""Of coefficients over the band, over the displacements squared: 0.9 GB of 121, 3.5 GB of 241 [MB]."""
DATABASE_SECONDS = (0.06, 3e-5)
"""Of a database of the spectral solver, once and for its motions squared."""
LEFT_OUT_SECONDS = (0.08, 3e-4)
"""Of powers with up to twice as many shell modes, once and over their degree squared."""
WET_SECONDS, BESIDE_LOADS = 8.0, 2.0
"""The same where shapes beside loaded rings move water, beside it; and of coefficients over the band."""
START_SECONDS, RIGID_START_SECONDS = 30.0, 3.0
"""Of a start of a search for the best buoy, to know which starts share a job; `vsb check` measures."""
FIGURE_SECONDS = 0.055
"""Of a file of a figure; each has two."""
LADDER_SECONDS, CAUSAL_SECONDS, CAUSAL_AT_PORTS = 0.1, 0.4, (5.0, 25.0)
"""Of the control levels, and how many more of a design in an irregular sea, whose control is causal too; of a rigid
and of a flexible one at several ports."""
OF_FULL_MATRIX = 2.6
"""The latter over that of a damper at each port alone."""
BINS, ONCE = 90, 0.1
"""Bins of Hs and Te of the years in which causal control was timed, and the part of that time that any year takes."""
IN_A_SEA_SECONDS = 2.5e-4
"""Of what a take-off sees at the 1500 components of an irregular sea, over the squared motions of a flexible design."""
IN_SEAS = {"ladder": 6, "compare": 9, "figures": 4, "report": 1}
"""How often stages ask for that: for causal control in five seas, each with its own components, and others."""
COMPARED_SECONDS, REPORTED_SECONDS = (0.15, 0.1), (0.2, 0.1)
"""Of the tables and of the page, each also for every run in time."""
SPECTRAL_SECONDS = {"deep": (0.1, 2.6e-4), "finite": (0.1, 1.4e-3)}
"""Of the coefficients of one azimuthal order of a shape, all frequencies, once and for its displacements squared."""
PANEL_ROW2_SECONDS = 3e-5
"""Of a frequency per squared row count, lid included; measured with 40 + 8 rows."""
WITNESS_ROW2_SECONDS = 1.6e-4
"""Of a shape, by both solvers, per squared row count; measured with 32 rows, 7 modes and derivatives by them."""
RUN_SECONDS = {"linear": (0.05, 7e-4), "assumed_pressure": (0.5, 1e-2), "body_exact": (0.2, 3e-3), "auto": (0.4, 2e-3)}
"""Of a run in time, and of each second it follows, by model."""
SWITCHING_SECONDS = 7e-3
"""Of each second of a linear run more under a take-off that switches, as Coulomb friction or a limit does."""
DEGREE, BY_DEGREE, OF_RIGID = 9.0, 1.3, 1.5
"""Of the shell modes with which body-exact runs were timed, the power of it their time grows with, and the degree that
a rigid buoy counts as: measured from 6 to 20."""
OF_SHAPE = 3.0
"""How many times as long a body-exact run of another shape than the sphere takes: of capsules."""
LATCHING_TIME_SECONDS = {"rigid": 1.0, "flexible": 4.0, "body_exact": 20.0}
"""Of the search for a latching time in a regular wave, and how many more on the wet shell."""
LATCHED_SECONDS = {"rigid": 0.05, "flexible": 0.2, "body_exact": 0.5}
"""Likewise of each second of a run in another sea, all trials together."""
AT_THE_SHELL = 8.0
"""How many times as long it takes where the port moves with the wall, whose modes are far faster than the waves."""
REST_SECONDS, SAME_REST_SECONDS = 0.4, 0.06
"""What a point of a campaign about its equilibrium takes more: its rest and the modes left out; and one that shares
the shape of another, such as with another spring."""
SEA_SECONDS = {"linear": 0.05, "body_exact": 0.2}
"""Of one design in one sea of `verify`, by model."""
CONTROLLED_SEA_SECONDS = {"linear": 2.0, "body_exact": 8.0}
"""The same under a causal controller, its filter included."""
BODY_SECONDS, IN_FINITE_DEPTH = 0.1, 2.5
"""Of a frequency of a body beside its matrices, and how many times as long these take in finite depth."""
FREQUENCIES_SECONDS, MOST_OF_FREQUENCIES = 10.0, 32
"""What the frequencies of a body that are solved apart are to take at least, and in how many parts at most."""
MEMBER_SECONDS, BLOCK_SECONDS = 0.016, 2.0
"""Of a member of a campaign whose coefficients are there, of coefficients of a shape."""
CAUSAL_BAND = 12.0
"""Highest frequency to which causal control was timed [rad/s]: the time grows in proportion to it."""
CAUSAL_YEAR_SECONDS, CAUSAL_AT_PORTS_SECONDS = 5.0, 50.0
"""CPU time of the causal controllers of a design in a year of some ninety bins, at one port and at two."""
MATRICES_SECONDS = 10.0
"""Of the best full damper matrices of a design in each of these bins."""
SPREAD_SECONDS = 2.5e-4
"""Of a damper spread over the shell of a design, over its degree cubed; measured with degree 30."""
MATRICES_WITHIN_SECONDS = 150.0
"""Of the damper matrices of a given rms force in each of these bins."""
WITH_LOSSES = 5.0
"""That with losses in conversion, over it: weights are found by repetition."""
YEAR_MEGABYTES = 0.02
"""Of a design's year under one tuning, power matrices and all."""
OVER_BUDGET = 0.7
"""CPU time of optima within limits over their budget, by which their number was chosen."""
MOST_MEMORY = 0.7
"""Part of a machine's memory that a job may need without a doubt: the rest is the system's and other jobs'."""


def plain_seconds(seconds: float) -> str:
    """Return a time in words, as precise as an estimate is."""
    if seconds < 100:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.2g} min" if seconds < 6000 else f"{seconds / 3600:.2g} h"


def memory_doubts(gigabytes: float) -> list[str]:
    """Return a doubt if a job needs most of the memory of this machine, or more than it has."""
    there = psutil.virtual_memory().total / 1e9
    if gigabytes <= MOST_MEMORY * there:
        return []
    return [
        f"doubt        memory: a frequency needs about {gigabytes:.2g} GB, and this machine has {there:.2g} GB; needs "
        "fewer panels, planes of symmetry, or a machine with more"
    ]


def block_seconds(block: AnyBlock) -> float:
    """Return the CPU time of the coefficients of a block of frequencies [s]."""
    if not isinstance(block, PanelsBlock):
        beside = BESIDE_LOADS if isinstance(block.shape, Study) and block.shape.has("pto") else 0.0
        return spectral_seconds(block.water, len(block.displacements)) + beside
    return PANEL_ROW2_SECONDS * len(block.omega) * float(block.mesh.rows + block.mesh.lid_rows) ** 2


def spectral_seconds(water: Water, displacements: int) -> float:
    """Return the CPU time of the coefficients of so many displacements by the spectral solver [s]."""
    once, each = SPECTRAL_SECONDS["deep" if math.isinf(water.depth) else "finite"]
    return once + each * displacements**2


def spectral_megabytes(displacements: int) -> int:
    """Return the memory of the coefficients of so many displacements by the spectral solver [MB]."""
    return math.ceil(max(1000.0, 300.0 + SPECTRAL_MEGABYTES * displacements**2))


def left_out_seconds(study: Study) -> float:
    """Return the CPU time of powers with up to twice as many shell modes, their water left out [s]."""
    beside_rings = WET_SECONDS if study.has_shell and wets_rings(study) else 0.0
    once, each = LEFT_OUT_SECONDS
    return float(once + each * _enough(study) ** 2) + beside_rings


def finer_water_seconds(buoy: Study) -> float:
    """Return the CPU time of the water around these modes, at the frequencies of a year's mean sea [s]."""
    return spectral_seconds(buoy.water, 2 * _enough(buoy) * (1 if buoy.device.shape is None else 2))


def _enough(buoy: Study) -> int:
    """Degree of the shell modes with which powers are compared, 0 without a shell."""
    return max(buoy.modes.max_degree, degree_needed(buoy)) if buoy.has_shell else 0


def motions_seconds(stage: str, motions: int) -> float:
    """Return the CPU time of a stage by the number of motions [s]."""
    once, each = OF_MOTIONS[stage]
    return once + each * motions


def latching_seconds(study: Study, wave: Wave, *, flexible: bool) -> float:
    """Return the CPU time of the search for the latching time of one design in a sea [s]; with its damping twice."""
    if not study.pto.has_latching_time or wave.still:
        return 0.0
    costs = LATCHING_TIME_SECONDS if wave.regular else LATCHED_SECONDS
    each = costs["flexible" if flexible else "rigid"] * (1 + (study.tuning(wave) == "each"))
    each *= AT_THE_SHELL if flexible and study.pto.port != "heave" else 1.0
    wet = costs["body_exact"] if study.hydro.model != "linear" else 0.0
    return (each + wet) * (1.0 if wave.regular else study.simulation.duration)


def witness_seconds(shapes: int, rows: int) -> float:
    """Return the CPU time of both solvers on deformed shapes [s]."""
    return shapes * WITNESS_ROW2_SECONDS * float(rows) ** 2


def matrices_seconds(file: BodyFile, panels: float) -> float:
    """Return the CPU time of the matrices of a frequency in deep water [s]: they grow with the square of their number.

    Planes of symmetry halve them; those of a mesh that are to be found are not known here.
    """
    planes = file.symmetry.count("O") if file.symmetry != "auto" else 2 if file.hull else 0
    return float(SECONDS_PER_PANEL2 * panels**2 / 2**planes)


def body_seconds(file: BodyFile, matrices: float) -> float:
    """Return the CPU time of the coefficients of a body on panels, `matrices` that of a frequency in deep water [s]."""
    return len(file.omega) * (BODY_SECONDS + matrices * (1.0 if math.isinf(file.water.depth) else IN_FINITE_DEPTH))


def ladder_seconds(study: Study) -> float:
    """Return the CPU time of the control levels of a study [s]."""
    irregular = sum(wave.irregular for wave in study.waves)
    once = LADDER_SECONDS + left_out_seconds(study)
    if not study.pto.several:
        return once + CAUSAL_SECONDS * irregular * len(study.designs)
    full = OF_FULL_MATRIX if isinstance(study.pto.port, SeveralPorts) and study.pto.port.matrix == "full" else 1.0
    return once + irregular * full * sum(CAUSAL_AT_PORTS[one.flexible] for one in study.designs.values())


def run_seconds(study: Study, wave: Wave, *, flexible: bool = True) -> float:
    """Return the CPU time of a run in time of one design in one sea [s]."""
    once, each = RUN_SECONDS[study.hydro.model]
    if study.pto.nonlinear and study.hydro.model == "linear":
        each += SWITCHING_SECONDS
    seas = 2.0 if wave.irregular else 1.0  # of many components
    if study.hydro.model == "body_exact":
        seas *= _of_wall(study, flexible=flexible)
    shell = flexible and study.has_shell
    return once + seas * each * study.simulation.duration + latching_seconds(study, wave, flexible=shell)


def _of_wall(buoy: Study, *, flexible: bool) -> float:
    """How many times as long a body-exact run of a design takes as one of a sphere of modes to `DEGREE`."""
    degree = buoy.modes.max_degree if flexible else OF_RIGID
    return float((max(degree, OF_RIGID) / DEGREE) ** BY_DEGREE * (OF_SHAPE if buoy.device.shape else 1.0))


def verification_seconds(spec: VerificationSpec) -> float:
    """Return the CPU time of the seas of a member that are simulated, with the radiation memory they need [s]."""
    controlled = CAUSAL in spec.tuning
    each = (CONTROLLED_SEA_SECONDS if controlled else SEA_SECONDS)[spec.verify.model] * spec.verify.seas
    study = spec.study
    designs = float(len(study.designs))
    if spec.verify.model == "body_exact":
        designs = sum(_of_wall(study, flexible=one.flexible) for one in study.designs.values())
    year = CAUSAL_YEAR_SECONDS * len(study.designs) if controlled else 0.0
    year = max(year, matrices_of_year(study, spec.tuning))
    return motions_seconds("radiation", 0) + each * designs + year


def matrices_of_year(study: Study, tuning: Collection[str]) -> float:
    """Return the CPU time of the damper matrices of all designs in the seas of a year [s]; 0 of one port.

    Where a damper is spread over the shell, that of a table of its sizes.
    """
    port, designs = study.pto.port, len(study.designs)
    if isinstance(port, DistributedPort):
        return float(SPREAD_SECONDS * designs * _enough(study) ** 3)
    if not isinstance(port, SeveralPorts) or "each" not in tuning:
        return 0.0
    return MATRICES_SECONDS * designs / (1.0 if port.matrix == "full" else OF_FULL_MATRIX)


def record_megabytes(study: Study, wave: Wave, coordinates: int) -> int:
    """Return the memory of the time series of a design in a sea [MB]: nine of every coordinate, ten others."""
    instants = int(RECORDS_PER_PERIOD * study.fastest(wave) * study.simulation.duration / (2 * math.pi))
    return math.ceil(8e-6 * (9 * coordinates + 10) * instants / thinning(instants + 1))


def run_megabytes(study: Study, wave: Wave, coordinates: int, highest: float) -> int:
    """Return the memory of a run in a sea [MB]: three times its record, one leg, the sea's components to `highest`."""
    band = highest if wave.irregular else 0.0
    length = wave.file.length if wave.recorded else study.simulation.duration
    return 800 + 3 * record_megabytes(study, wave, coordinates) + math.ceil(6e-4 * band * length)


def study_megabytes(study: Study, coordinates: int) -> int:
    """Return the memory of the time series of all designs in a sea at once [MB], and of drawing them."""
    largest = max(record_megabytes(study, wave, coordinates) for wave in study.waves)
    return 800 + math.ceil(1.2 * len(study.designs) * largest)
