"""How finely a study is solved: degree of the shell modes, rows of panels, frequency grid and blocks."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from vsb.engine.hydro.panels import LEAST_DEPTH_IN_WAVENUMBERS, panel_solver
from vsb.engine.motion.take_off import (
    BetweenPort,
    DistributedPort,
    LinePort,
    SeveralPorts,
    ShellPort,
    StrainPort,
)
from vsb.engine.shell.device import StructuralDamping
from vsb.errors import ConfigError
from vsb.keys.quantities import content_id
from vsb.study.sections import DEGREES, Design
from vsb.study.specs import DeformedMeshes, Mesh, PanelsBlock, Rows, Shapes, SpectralBlock, Sphere, spec_of
from vsb.study.study import CLEARANCE, Study
from vsb.tools.arrays import FloatArray

AnyBlock = PanelsBlock | SpectralBlock
BLOCK = 32
"""Frequencies per job of panels: large enough to hide the second an import costs, small enough to spread over cores.

The band's upper end is rounded up to as many unrefined steps: studies of different omega_max share blocks.
"""
SPECTRAL_BLOCK = 128
"""Likewise of frequencies tabulated by the spectral solver, which needs less than a millisecond for each."""
SPLINE_ERROR = {"deep": (5e-5, 2), "finite": (4.6e-3, 3)}
"""Of cubic splines on the grid of `frequency_step`, where added mass leaves frequency zero, and the power of the step
it falls with; in finite depth added mass goes with log(omega) (measured in 2.041 m to 50 m of water, radius 2 m)."""
COARSEST_SWEEP = 1e-3
"""Largest tolerance of interpolation: of small modes, measured by the largest, more would be felt."""
LARGEST_KA, LARGEST_KA_OF_SHAPES = 40.0, 90.0
"""Largest omega^2 r/g the spectral solver is asked for: beyond, its points grow with the frequency."""
BEYOND_THE_PEAK = 4.2
"""omega^2 l/g to which radiation damping must be known, l the draft or the waterline's radius, the smaller: Ogilvie's
relation is then off by less than 2 % (drafts of 0.1 to 1.9 radii, modes to degree 2, in 0.06 sqrt(g/l))."""
HIGHER_DEGREES = 5.2
"""What every degree beyond 2 adds to the square of omega^2 a/g, a the waterline's radius, of spheres (likewise, to
degree 12; to degree 90 they need less)."""
AT_EDGE, EDGE_DEGREES, BELOW_EQUATOR = 22.0, 12.5, 0.45
"""What shell modes of other shapes add to omega^2/g: the first in terms of the curvature r/b^2 of a spheroid at its
equator, b half its height (of a capsule of 1/r), as the degree grows beyond the second, times r/b; the third, over b,
for every degree where the waterline lies below the equator, by the root of its share of b. Kramers and Kronig's
relation, which held in 45 cases from omega^2 r/g of 9 to 71 on, then holds, but at one draft of 0.35 heights, degree 4:
b of 0.4 to 1.5 radii, capsules of lengths of 0.3 to 1 radii, drafts of 0.2 to 0.65 heights, degrees 4 to 120.
"""
MAX_ROWS = 160
LID_ROWS_PER_WAVE = 6
ROWS_OF_A_DEFORMED_SHELL = 1.5
"""Factor on the rows of a sphere; with it Haskind's relation holds as well (seed's shell at 16.5 kPa, 14 % strain)."""
FEWEST_LID_ROWS = 16


ROWS_PER_HALF_WAVE = 6


def block_id(block: AnyBlock) -> str:
    """Return the content id of a block of frequencies."""
    return content_id(spec_of("block", block=block))


def frequency_step(radius: float, gravity: float) -> float:
    """Return the step of the absolute frequency grid [rad/s]: the largest 1-2-5 number below 0.05 sqrt(g/r).

    The coefficients vary on the scale sqrt(g/r); with a fixed, round step, studies of different omega_max share
    blocks.
    """
    bound = 0.05 * math.sqrt(gravity / radius)
    decade = 10.0 ** math.floor(math.log10(bound))
    return float(f"{max(m * decade for m in (1, 2, 5) if m * decade <= bound):.0e}")


def tolerance_rows(tolerance: float) -> int:
    """Return the panel rows that bring the error of A and B below a tolerance.

    Measured on the floating hemisphere (modes P_0..P_6, Ka <= 3): 40 rows 8e-4, second order.
    """
    return 2 * math.ceil(20 * math.sqrt(1e-3 / tolerance))


def mode_rows(degree: int) -> int:
    """Return the rows that put eight of them on every lobe of the highest mode, degree/2 lobes on the wetted shell."""
    return 4 * degree


def wave_rows(radius: float, wavelength: float) -> int:
    """Return the rows that put `ROWS_PER_HALF_WAVE` of them within half a wavelength of the surface.

    Rows are graded as colatitude = pi/2 (2 - cos(pi s/2)), so depth d is passed at s = 2/pi acos(1 - 2/pi asin(d/r)).
    """
    depth = min(wavelength / 2 / radius, 1.0)
    passed = 2 / math.pi * math.acos(1 - 2 / math.pi * math.asin(depth))
    return 2 * math.ceil(ROWS_PER_HALF_WAVE / passed / 2)


@dataclass(frozen=True)
class HydroPlan:
    """What a study needs of the boundary-element solvers, as specs with content ids."""

    study: Study

    def resolution(self, omega: float) -> Rows:
        """Panel rows, azimuthal panels and lid rows for frequencies up to omega [rad/s].

        Raises `ConfigError` if the wave is too short for any mesh of at most `MAX_ROWS` rows, or for the rows asked
        for.
        """
        study, radius = self.study, self.study.device.radius
        most = study.hydro.rows or MAX_ROWS
        highest = min(omega, study.hydro.omega_max)  # a block may reach beyond what the study asks for
        needed = wave_rows(radius, self._wavelength(highest))
        finer = ROWS_OF_A_DEFORMED_SHELL if study.rests_deformed else 1.0
        wanted = max(
            2 * math.ceil(finer * tolerance_rows(study.hydro.tolerance) / 2),
            mode_rows(self.study.modes.max_degree if self.study.flexible else 1),
            wave_rows(radius, self._wavelength(omega)),
        )
        if not study.hydro.rows and tolerance_rows(study.hydro.tolerance) > MAX_ROWS:
            least = 1e-3 * (40 / MAX_ROWS) ** 2
            raise ConfigError(f"hydro.tolerance: received {study.hydro.tolerance:g}, needs at least {least:g}")
        if needed > most:
            raise ConfigError(
                f"hydro.omega_max: received {study.hydro.omega_max:g} rad/s, whose wave of "
                f"{self._wavelength(highest):.3g} m is too short for the mesh: it needs {needed} rows of panels, there "
                f"are {most}; lower hydro.omega_max" + (" or raise hydro.rows" if study.hydro.rows else "")
            )
        rows = study.hydro.rows or min(wanted, MAX_ROWS)
        waterline = math.sqrt(radius**2 - study.centre_height**2)
        lid_rows = max(FEWEST_LID_ROWS, math.ceil(LID_ROWS_PER_WAVE * waterline / self._wavelength(omega)))
        return Rows(rows=rows, azimuth=2 * rows, lid_rows=lid_rows)

    def _wavelength(self, omega: float) -> float:
        """Length of a deep-water wave [m]: the shortest a frequency can have."""
        return 2 * math.pi * self.study.water.gravity / omega**2

    @property
    def shape(self) -> Sphere | Study:
        """Mean wetted shape: of the sphere, or of what its load makes of it at rest."""
        study, radius, height = self.study, self.study.device.radius, self.study.centre_height
        if not study.rests_deformed:
            return Sphere(radius=radius, centre_height=height, shape=study.device.shape)
        return self.shell(**self._at_rest)

    @property
    def _at_rest(self) -> dict[str, Any]:
        """Sections of a shell at rest, where neither damping nor depth matter."""
        device, water = self.study.device, self.study.water
        return {
            "device": device.model_copy(update={"damping": StructuralDamping()}),
            "water": water.model_copy(update={"depth": math.inf}),
        }

    def shell(self, *names: str, **changed: Any) -> Study:
        """Return what of the study its shell at rest follows from, for all its designs; and further sections."""
        parts: dict[str, Any] = {"designs": {"any": Design(flexible=self.study.flexible)}}
        if self.study.flexible:
            parts["modes"] = self.study.modes.without_tolerance
        return self.study.only("device", "water", "reference_shape", *names, **parts | changed)

    def displacements(self, order: int = 0) -> tuple[str, ...]:
        """Displacements of an order solved for: the sphere knows radial ones alone, its heave and surge degree 1 alone.

        Pitch about its centre moves no water. On another shape meridional ones do, too.
        """
        highest = max(1, self.study.modes.max_degree)
        shaped = self.study.device.shape is not None
        if not self.study.flexible:
            return ("Radial1", "Meridional1") if shaped else ("Radial1",)
        radial = tuple(f"Radial{n}" for n in range(order, highest + 1))
        meridional = tuple(f"Meridional{n}" for n in range(1, highest + 1))
        return (*radial, *meridional) if self.study.rests_deformed or shaped else radial

    def loaded_shell(self, *names: str, **changed: Any) -> Study:
        """Return what of the study its shell at rest, its ports and all clamps follow from; and further sections."""
        held = tuple(sorted({at for one in self.study.designs.values() for at in one.clamp}))
        loaded = {"pto": self.study.pto.place, "designs": {"any": Design(clamp=held)}}
        return self.shell(*names, **loaded | changed)

    def mesh(self, omega: float) -> Mesh:
        """Spec of the mesh that serves frequencies up to omega."""
        return Mesh(shape=self.shape, **dict(self.resolution(omega)))

    def _block(
        self, omega: list[float], highest: float, interpolation: float | None = None, order: int = 0
    ) -> AnyBlock:
        """Spec of one BEM job; of a sweep with the tolerance of interpolation, which lets it leave frequencies out."""
        asked: dict[str, Any] = {
            "water": self.study.water,
            "displacements": self.displacements(order),
            "omega": omega,
            "interpolation": interpolation,
            "order": order,
        }
        if self.study.uses_panels:
            return PanelsBlock(solver=panel_solver(), mesh=self.mesh(highest), **asked)
        shape: Sphere | Study = self.shape
        if wets_rings(self.study) and not order:
            shape = self.loaded_shell(**self._at_rest, motion="heave")
        return SpectralBlock(solver="spectral", shape=shape, tolerance=self.study.hydro.tolerance, **asked)

    @property
    def refinement(self) -> int:
        """How many times finer than that of panels the frequency grid is: 1, 2, 4, ...

        Such that splines through it are off by at most half the tolerance; a finer grid needs no more solves.
        """
        if self.study.uses_panels:
            return 1
        error, power = SPLINE_ERROR["deep" if math.isinf(self.study.water.depth) else "finite"]
        return int(2 ** max(0, math.ceil(math.log2(2 * error / self.study.hydro.tolerance) / power)))

    @property
    def step(self) -> float:
        """Step of the absolute frequency grid [rad/s]."""
        return frequency_step(self.study.device.radius, self.study.water.gravity) / self.refinement

    @property
    def lowest_omega(self) -> float:
        """Lowest frequency of the grid [rad/s]: its step, or what capytaine's Green function of finite depth allows."""
        if not self.study.uses_panels:
            return self.step if math.isinf(self.study.water.depth) else self.step * self.refinement
        kd, depth = LEAST_DEPTH_IN_WAVENUMBERS, self.study.water.depth
        return max(self.step, math.sqrt(kd * math.tanh(kd) * self.study.water.gravity / depth))

    @property
    def least_band(self) -> float:
        """Frequency to which the damping must be known [rad/s]."""
        study, radius, degree = self.study, self.study.waterline_radius, self.study.modes.degree or 0
        k = BEYOND_THE_PEAK / min(radius, study.draft)
        if study.flexible and study.device.shape is None:
            k = math.hypot(k, math.sqrt(HIGHER_DEGREES * max(0, degree - 2)) / radius)
        elif study.flexible:
            k += self._edge_wavenumber(degree)
        return math.sqrt(k * study.water.gravity)

    def _edge_wavenumber(self, degree: int) -> float:
        """What shell modes up to a degree of another shape than the sphere add to the wavenumber they need [1/m]."""
        device = self.study.device
        assert device.shape is not None
        assert device.meridian is not None
        half = (device.meridian.highest - device.meridian.lowest) / 2
        sharp = 1 / device.radius if device.shape.capsule else device.radius / half**2
        below = math.sqrt(max(0.0, 1 - self.study.draft / half))
        reached = 1 - math.exp(-degree * half / (EDGE_DEGREES * device.radius))
        return AT_EDGE * reached * sharp + BELOW_EQUATOR * degree * below / half

    @property
    def reach(self) -> float:
        """Highest frequency that is solved, the end of the last block [rad/s]."""
        block = BLOCK * self.refinement
        return float(math.ceil(self.study.hydro.omega_max / self.step / block - 1e-9) * block * self.step)

    @property
    def largest_band(self) -> float:
        """Highest frequency the spectral solver is asked for [rad/s]."""
        device = self.study.device
        largest = LARGEST_KA if device.shape is None else LARGEST_KA_OF_SHAPES
        return math.sqrt(largest * self.study.water.gravity / device.radius)

    def check_waves(self) -> None:
        """Check that no wave is longer than the lowest frequency solved, nor the band too wide for the solver.

        Raises `ConfigError`.
        """
        study, largest = self.study, self.largest_band
        if not study.uses_panels and study.hydro.omega_max > largest:
            raise ConfigError(
                f"hydro.omega_max: received {study.hydro.omega_max:g} rad/s, needs at most {largest:.4g} rad/s "
                "with the spectral solver; lower it, or set hydro.solver: panels"
            )
        judged = study.uses_panels or "kramers_kronig" in study.hydro.accept  # afterwards, or not at all
        if self.reach < self.least_band and not judged:
            beyond = "set hydro.solver: panels" if study.device.shape is None else "lower modes.degree"
            raise ConfigError(
                f"hydro.omega_max: received {study.hydro.omega_max:g} rad/s, needs at least "
                f"{self.least_band:.4g} rad/s, because the radiation memory rests on the damping to beyond its peak; "
                + ("raise it" if self.least_band < largest else beyond)
            )
        for i, wave in enumerate(self.study.waves):
            if wave.regular and wave.omega < self.first_omega:
                longest = 2 * math.pi / self.first_omega
                raise ConfigError(
                    f"waves.{i}.period: received {wave.period:g} s, needs at most {longest:.4g} s, the longest solved"
                )
            if wave.of_file:
                wave.check_band(self.first_omega, self.study.hydro.omega_max, f"waves.{i}.file")
            elif wave.irregular and wave.reach[0] < self.first_omega:
                raise ConfigError(
                    f"waves.{i}: received {wave.label}, from {wave.reach[0]:.4g} rad/s on; needs at least "
                    f"{self.first_omega:.4g} rad/s, the lowest solved"
                )

    def _grid(self, first: int, last: int) -> list[float]:
        """Frequencies of the absolute grid, as round as its step [rad/s]."""
        step = self.step
        digits = max(0, -math.floor(math.log10(step))) + 5
        return [round(step * i, digits) for i in range(first, last + 1)]

    @property
    def highest_omega(self) -> float:
        """Highest frequency a database is given [rad/s]: the first of the grid that is not below omega_max."""
        last = math.ceil(self.study.hydro.omega_max / self.step - 1e-9)
        return self._grid(last, last)[0]

    @cached_property
    def sweep_blocks(self) -> list[AnyBlock]:
        """Blocks of the absolute grid that cover (0, omega_max].

        Of each is solved what interpolation to half the tolerance needs; the other half is left for the splines through
        the grid. The spectral solver's is one for each azimuthal order. Panels have several, and one of their own for
        infinite frequency.
        """
        size, interpolation = BLOCK * self.refinement, min(self.study.hydro.tolerance, COARSEST_SWEEP) / 2
        count = math.ceil(self.study.hydro.omega_max / self.step / size - 1e-9)
        first = math.ceil(self.lowest_omega / self.step - 1e-9)
        if not self.study.uses_panels:
            grid = self._grid(first, size * count)
            return [self._block(grid, grid[-1], interpolation, order) for order in self.study.orders]
        grids = [self._grid(max(first, size * k + 1), size * (k + 1)) for k in range(count)]
        swept = [self._block(grid, grid[-1], interpolation=interpolation) for grid in grids]
        return [self._block([math.inf], grids[0][-1]), *swept]

    @property
    def first_omega(self) -> float:
        """Lowest frequency of the sweep [rad/s]."""
        return float(min(block.omega[0] for block in self.sweep_blocks))

    @cached_property
    def tabulated_blocks(self) -> list[AnyBlock]:
        """Blocks of the frequencies the study asks to tabulate, if it does."""
        omega = self.study.hydro.omega
        if self.study.uses_panels and omega and omega[0] < self.lowest_omega:
            raise ConfigError(
                f"hydro.omega: received {omega[0]:g} rad/s, needs at least {self.lowest_omega:.4g} rad/s with panels "
                f"in {self.study.water.depth:g} m of water"
            )
        size = BLOCK if self.study.uses_panels else SPECTRAL_BLOCK
        chunks = [list(omega[i : i + size]) for i in range(0, len(omega), size)]
        return [self._block(chunk, chunk[-1], order=order) for order in self.study.orders for chunk in chunks]

    @property
    def bem_blocks(self) -> dict[str, AnyBlock]:
        """All BEM jobs of the study by content id; none without BEM."""
        blocks = [*self.sweep_blocks, *self.tabulated_blocks] if self.study.needs_bem else []
        return {block_id(block): block for block in blocks}

    @property
    def mode_labels(self) -> tuple[str, ...]:
        """Labels of the shell modes, as the basis will name them."""
        if not self.study.flexible:
            return ()
        degree = self.study.modes.max_degree
        if self.study.device.shape is not None:
            return tuple(f"Shell{i}" for i in range(1, 2 * degree + 1))
        bending = range(2, degree + 1) if self.study.modes.basis == "full" else ()
        return (*(f"Membrane{n}" for n in range(degree + 1)), *(f"Bending{n}" for n in bending))

    @property
    def coordinates(self) -> int:
        """Number of degrees of freedom of all azimuthal orders."""
        if self.study.device.shape is not None:
            return 1 + len(self.mode_labels)
        families = {"heave": 1, "planar": 1, "free": 2}[self.study.motion]  # of each order m >= 1
        of_order = [sum(degree(label) >= order for label in self.mode_labels) for order in self.study.orders]
        return of_order[0] + families * sum(of_order[1:]) + {"heave": 1, "planar": 3, "free": 6}[self.study.motion]


def degree(mode: str) -> int:
    """Return the degree of a mode by its label."""
    return int(mode.removeprefix("Membrane").removeprefix("Bending"))


def in_band(study: Study, *, automatic: bool | None = None) -> Study:
    """Return a study whose automatic band reaches as far as the damping of its shell modes must be known.

    Parameters
    ----------
    automatic : bool, optional
        Whether its band is; by default it is where `hydro.omega_max` is not set.
    """
    plan = HydroPlan(study)
    given = "omega_max" in study.hydro.model_fields_set if automatic is None else not automatic
    if given or not study.needs_bem or study.uses_panels or plan.reach >= plan.least_band:
        return study
    if plan.least_band > plan.largest_band:
        return study  # refused by `HydroPlan.check_waves`
    digit = 10.0 ** (math.floor(math.log10(plan.least_band)) - 1)
    omega_max = min(float(f"{math.ceil(plan.least_band / digit) * digit:.2g}"), plan.largest_band)
    return study.model_copy(update={"hydro": study.hydro.model_copy(update={"omega_max": omega_max})})


MOST_MODES = 12
"""Modes, of the lowest degrees, that deform the shell and whose coefficients are compared."""
ROWS = 32
"""Panels err by 1e-3 with them, and say 3e-3: an error of one percent in either solver is seen."""
LONGEST, SHORTEST = 0.3, 3.0
"""Wavenumber times radius of the longest and the shortest wave of three: around the resonance of heave, near one."""


def no_witness(study: Study) -> str:
    """Say why a study has no second solver; empty if it has."""
    if not study.needs_bem:
        return "an assumed pressure has no coefficients"
    if study.hydro.witness == "none":
        return "hydro.witness: none"
    if study.device.shape is not None:
        return "panels are those of the sphere"
    if study.water.depth < CLEARANCE * study.draft:
        return f"the spectral solver needs a water.depth of {CLEARANCE:g} drafts"
    return ""


def witness_meshes(plan: HydroPlan) -> DeformedMeshes:
    """Return the shapes both solvers are asked about, and the rows of panels on them."""
    study, device, water, shape = plan.study, plan.study.device, plan.study.water, plan.shape
    lowest = sorted(plan.mode_labels, key=degree)[:MOST_MODES]
    modes = tuple(label for label in plan.mode_labels if label in lowest)
    if study.flexible and isinstance(shape, Sphere):  # neither stiffness nor density matters to the modes
        wall = {"thickness": device.thickness, "poisson_ratio": device.poisson_ratio, "basis": study.modes.basis}
        shape = Shapes(**dict(shape), **wall)
    rows = max(ROWS, *(mode_rows(degree(mode)) for mode in modes), 0)
    return DeformedMeshes(
        shape=shape, deformed=modes, depth=water.depth, rows=rows, azimuth=2 * rows, lid_rows=FEWEST_LID_ROWS
    )


def witness_omega(study: Study) -> tuple[float, ...]:
    """Return the frequencies both are asked at [rad/s]."""
    device, water = study.device, study.water
    longest = max(LONGEST / device.radius, LEAST_DEPTH_IN_WAVENUMBERS / water.depth)
    shortest = max(SHORTEST / device.radius, 2 * longest)
    return tuple(
        round(math.sqrt(water.gravity * k * math.tanh(k * water.depth)), 6)
        for k in (longest, math.sqrt(longest * shortest), shortest)
    )


# degree of the shell modes --------------------------------------------------------------------------------------------


WITHIN = 4.0
"""Change of the power of a port within the shell over that of a port that heaves, in terms of the wall's stiffness over
rho g [-]."""
AT_POINTS = 4.5
"""Degree that resolves what bends about the ends of a port between two points, over `bending_degree` [-]."""
AT_WET_POINTS = 1.5
"""The same where shapes beside them move water, too [-]."""
AT_JUNCTION = 0.15
"""Change of mean power by all degrees above one, times that degree, of a capsule about its equilibrium: where its
curvature jumps its load bends the wall [-]."""
RADIAL = 8.0
"""Change of the power of a port normal to the wall at a ring, which drives the bending of a soft wall in waves, over
that of one that heaves [-]."""
WET_RADIAL = 3.0
"""The same where the shapes beside its ring move water, too [-]."""
TURNS = 5.0
"""The same of a port that surges or pitches with the buoy: the shell is a spring between water and ballast [-]."""
SHAPES = 2.0
"""The same of another shape than the sphere: some of its wall is flatter [-]."""
MARGIN = 2.0
"""Over the change that is expected, 0.3 to 2.5 times of which was found of stiff spheres [-]."""
SOFT = 8.0
"""Stiffness of a wall about which its shapes resonate in waves, which magnifies what is left out, over rho g [-]."""


Degrees = TypeVar("Degrees", float, FloatArray)


def wall_stiffness(study: Study, degree: Degrees) -> Degrees:
    """Return the stiffness per unit area k_n of a wall against a load of a Legendre degree, or of each, over rho g [-].

    k_n = (E h + T n(n+1) + D n^2 (n+1)^2/r^2)/r^2, by its membrane, by the tension T = p r/2 of an internal pressure,
    and by bending, D = E h^3/12(1 - nu^2).
    """
    device, water, r = study.device, study.water, _reach(study)
    membrane, turns = device.young_modulus * device.thickness, degree * (degree + 1)
    bending = membrane * device.thickness**2 / (12 * (1 - device.poisson_ratio**2))
    tension = max(device.internal_pressure, 0.0) * r / 2
    return (membrane + tension * turns + bending * turns**2 / r**2) / r**2 / (water.density * water.gravity)


def bending_degree(study: Study) -> float:
    """Return the degree at which a wall is as stiff by bending as by its membrane, D n^4/r^4 = E h/r^2 [-]."""
    device = study.device
    return float((12 * (1 - device.poisson_ratio**2)) ** 0.25 * math.sqrt(_reach(study) / device.thickness))


MOST_DRY = 42
"""Degree above which what the wall does beside the waterline replaces shell modes: these take hundreds of megabytes."""
LAST = 4.0
"""Degree of the last ones that yield to a load along a line, over `bending_degree` [-]."""
FELT = 0.6
"""`line_change` by dry degrees, over the tolerance, that powers feel [-]."""
BESIDE_WATERLINE = 2
"""Degree without what the wall does beside the waterline over that with it, for the same error, at least [-]."""


def _turns(study: Study) -> bool:
    """Whether a port surges or pitches with the buoy."""
    return any(one in ("surge", "pitch") or isinstance(one, LinePort) for one in study.pto.single_ports)


def _bends_wall(study: Study) -> bool:
    """Whether a port drives the bending of the wall."""
    return any(
        isinstance(one, BetweenPort) or (isinstance(one, ShellPort) and one.direction == "radial")
        for one in study.pto.single_ports
    )


def loaded_at_ring(study: Study, design: str) -> bool:
    """Return whether a clamp, a take-off at the shell or a mooring acts at a ring of the shell of a design."""
    if study.designs[design].clamp:
        return True
    held = study.pto.held
    return bool(study.pto.on_shell or (held and held.place == "ring"))


def line_change(study: Study, degree: int) -> float:
    """Return what water on degrees above one changes of the displacement under a load along a line, relative [-].

    To such a load all degrees yield about alike, by 1/k_n, and still water adds rho g to k_n: sum_(n > N) 1/k_n^2 over
    sum_n 1/k_n. A thin wall of rubber yields by degrees to `bending_degree`, of which waves need a few alone.
    """
    yields = 1 / wall_stiffness(study, np.arange(2.0, math.ceil(LAST * bending_degree(study))))
    return float((yields[max(0, degree - 1) :] ** 2).sum() / yields.sum())


def wets_rings(study: Study) -> bool:
    """Return whether shapes beside the rings a port loads and beside the waterline move water, if linear.

    Where a port drives the bending of the wall, or the wall is so soft and thin that it needs many shell modes without,
    or that dry degrees beside a loaded ring would be felt. Panels and a moving wetted surface would not resolve them.
    """
    if not study.flexible or study.modes.basis != "full" or study.hydro.model != "linear" or study.uses_panels:
        return False
    if _bends_wall(study) or _turns(study):
        return _bends_wall(study)
    dry = max(study.modes.degree or 0, degree_needed(study, wet=False))
    at_ring = any(loaded_at_ring(study, design) for design in study.designs)
    return dry > MOST_DRY or (at_ring and line_change(study, dry) > FELT * study.modes.tolerance)


WET, MOST_WET = 6.0, 240
"""Degree to which what bends beside a loaded ring moves water, over `bending_degree`, and at most."""


def wet_degree(study: Study) -> int:
    """Return the degree to which the shapes beside loaded rings move water, if they do.

    It rises with that of the modes, so that their change with it holds what it leaves out, too.
    """
    return min(MOST_WET, max(math.ceil(WET * bending_degree(study)), 2 * study.modes.max_degree))


def _reach(study: Study) -> float:
    """Largest radius of the shell, or half its height [m]."""
    radius, rest = study.device.radius, study.device.meridian
    return radius if rest is None else max(radius, rest.highest, -rest.lowest)


def expected_change(study: Study, degree: int, *, wet: bool = False) -> float:
    """Return the change of mean power by all shell modes above a degree that is to be expected, relative [-].

    Waves press on the wet part of the wall. Of such a load the Legendre degree n falls like n^-3/2, and the wall yields
    to it by 1/k_n, so that what degrees above n do is about rho g/(k_n n^1.4). Where shapes beside the waterline move
    water, they hold most of it.
    """
    if wet and not _bends_wall(study):
        degree *= BESIDE_WATERLINE
    return 1 / (wall_stiffness(study, degree) * math.pow(degree, 1.4))


def degree_needed(study: Study, wet: bool | None = None) -> int:
    """Return the least of `DEGREES` that is expected to leave out no more than `modes.tolerance`, or the highest.

    A wall as soft as the water resonates in waves; where the port lies within the shell, all power comes from what the
    wall yields, and of one between two points most of it yields near them; where the port surges or pitches, the shell
    is a spring between the water and the ballast; a port normal to the wall drives its bending. How much is left out is
    measured afterwards (`vsb.results.budget`).

    Parameters
    ----------
    study : Study
    wet : bool, optional
        Whether shapes beside loaded rings move water; by default as of `wets_rings`.
    """
    wet = wets_rings(study) if wet is None else wet
    stiffness, port = wall_stiffness(study, 2), study.pto.port
    ports = [*port.ports.values()] if isinstance(port, SeveralPorts) else [port]
    rings = [one for one in ports if isinstance(one, ShellPort)]
    held = study.pto.held is not None and study.pto.held.place == "heave"  # then rings move with the shell alone
    within = any(held or one.against == "frame" for one in rings) or any(
        one == "volume" or isinstance(one, BetweenPort | DistributedPort | StrainPort) for one in ports
    )
    factor = MARGIN * (1 + SOFT / stiffness + (WITHIN * stiffness if within else 0.0))
    if study.device.shape is not None:
        factor *= SHAPES
    if _turns(study):
        factor *= TURNS
    if any(one.direction == "radial" for one in rings):
        factor *= WET_RADIAL if wet else RADIAL
    enough = study.modes.tolerance / factor
    between = any(isinstance(one, BetweenPort) for one in ports)
    least = (AT_WET_POINTS if wet else AT_POINTS) * bending_degree(study) if between else 0.0
    if study.at_equilibrium and study.device.shape is not None and study.device.shape.capsule:
        least = max(least, AT_JUNCTION / study.modes.tolerance)
    return next((n for n in DEGREES if n >= least and expected_change(study, n, wet=wet) <= enough), DEGREES[-1])
