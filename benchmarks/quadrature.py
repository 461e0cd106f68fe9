"""Force, volume and area of the wet shell by the paper's Riemann discs, and what three quadratures cost.

The discs are a baseline, measured against Gauss-Legendre quadrature and the compiled exact kernel; no model uses them.
"""

import timeit
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.measure import Row
from vsb.errors import ConfigError
from vsb.motion.builders import assumed_pressure_scene
from vsb.motion.forces import AssumedPressure
from vsb.motion.port import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.wetted import WetShell
from vsb.scenes.rest import design_motions, study_basis
from vsb.shell.deformed import DeformedShell, Meridian
from vsb.study.study import RegularWave, Study
from vsb.tools.arrays import FloatArray

DISCS = (10, 32, 100, 316, 1000, 3162, 10_000, 31_623, 100_000)
POINTS = (4, 6, 8, 10, 12, 16, 20, 24, 30, 40, 60)
CONVERGED = 300  # points


# the baseline: Riemann discs ----------------------------------------------------------------------------------------


class Bounds(NamedTuple):
    """Lower and upper sum of a Riemann integral; their mean is the estimate, Eq. 108.

    The paper takes the mean to be of second order; the disc the waterline cuts leaves it at the first.
    """

    lower: float
    upper: float

    @property
    def mean(self) -> float:
        """Mean of the two."""
        return 0.5 * (self.lower + self.upper)


def _nodes(shell: DeformedShell, discs: int) -> Meridian:
    """Edges of discs equally spaced in colatitude on the whole meridian, from the top pole to the keel."""
    return shell.meridian(np.linspace(0.0, np.pi, discs + 1))


def _bounds(ends: FloatArray, z: FloatArray) -> Bounds:
    """Sum the smaller value over wholly wet discs, the larger one over partly wet ones too; ends (2, disc)."""
    wet = z <= 0.0
    return Bounds(
        float(ends.min(axis=0)[wet[1:] & wet[:-1]].sum()),
        float(ends.max(axis=0)[wet[1:] | wet[:-1]].sum()),
    )


def disc_volume(shell: DeformedShell, discs: int) -> Bounds:
    """Return lower and upper sum of the submerged volume, sum pi R^2 dz, Eqs. 98-101 [m^3].

    Least and largest radius of a disc are those of its edges: exact unless the radius has an extremum inside.
    """
    m = _nodes(shell, discs)
    return _bounds(-np.pi * np.stack([m.x[:-1], m.x[1:]]) ** 2 * np.diff(m.z), m.z)


def disc_area(shell: DeformedShell, discs: int) -> Bounds:
    """Return lower and upper sum of the wet area, sum 2 pi R ds [m^2].

    Notes
    -----
    Eqs. 105 and 106 print 2 pi R^2 dz, which is no area (m^3). With R in place of R^2, and the distance from the centre
    the paper takes for R, it is Archimedes' area of a sphere's zone and holds on no other shape; hence the cone's.
    """
    m = _nodes(shell, discs)
    return _bounds(2 * np.pi * np.stack([m.x[:-1], m.x[1:]]) * np.hypot(np.diff(m.x), np.diff(m.z)), m.z)


def disc_force(shell: DeformedShell, discs: int) -> tuple[FloatArray, FloatArray]:
    """Return the generalized forces on the wet shell by the rectangle rule on discs, first order: a baseline only.

    Parameters
    ----------
    shell : DeformedShell
    discs : int
        Of the whole meridian. The highest wet one lies wholly below the water, Eq. 96.

    Returns
    -------
    static, uniform : ndarray, shape (dof,)
        Of the pressure -rho g z per rho g [m^3], and of a uniform one per Pa [m^2], as `vsb.motion.wetted.wet_force`.

    Notes
    -----
    Pressure, radius and shapes are those of a disc's lower edge, the normal that of its cone. Literally, Eq. 95 divides
    the weight of the water a disc displaces by cos psi and lets it act along the normal. Over heave this sums to
    Archimedes' force, over the modes to a wrong one: where the meridian is vertical, at the waterline of the
    half-submerged sphere, cos psi vanishes and the sum diverges. On the breathing mode it is 3.5 times the force of the
    water with 100 discs and 10.4 times with 100 000, and the shell collapses.
    """
    m = _nodes(shell, discs)
    wet = (m.z[1:] <= 0.0) & (m.z[:-1] <= 0.0)
    flux = 2 * np.pi * m.x[1:] * (np.diff(m.x) * m.shape_z[:, 1:] - np.diff(m.z) * m.shape_x[:, 1:])
    return flux[:, wet] @ m.z[1:][wet], -flux[:, wet].sum(axis=1)


def gauss_force(shell: DeformedShell, points: int) -> tuple[FloatArray, FloatArray]:
    """Return the same forces by Gauss-Legendre quadrature in colatitude, `points` per wet segment, plain NumPy."""
    static, uniform = np.zeros(len(shell.basis.labels)), np.zeros(len(shell.basis.labels))
    node, weight = np.polynomial.legendre.leggauss(points)
    for a, b in shell.wet_segments:
        m = shell.meridian((a + b) / 2 + (b - a) / 2 * node)
        flux = np.pi * (b - a) * weight * m.x * (m.dx * m.shape_z - m.dz * m.shape_x)
        static, uniform = static + flux @ m.z, uniform - flux.sum(axis=1)
    return static, uniform


# quadrature ---------------------------------------------------------------------------------------------------------


def regular_wave(study: Study) -> RegularWave:
    """The first regular wave of a body-exact study."""
    wave = next((wave for wave in study.waves if isinstance(wave, RegularWave)), None)
    if study.needs_bem or wave is None:
        raise ConfigError(
            f"study {study.study!r}: received hydro.model {study.hydro.model!r} and seas "
            f"{[wave.label for wave in study.waves]}; work and precision need assumed_pressure and a regular wave"
        )
    return wave


def scene_of_design(study: Study, design: str) -> Scene:
    """Return the body-exact scene of one design in the first regular wave of a study."""
    wave, basis, water = regular_wave(study), study_basis(study), study.water
    shell, load = DeformedShell(basis, study.centre_height), AssumedPressure(study.hydro.pressure or 0.0, wave.omega)
    motions = design_motions(study, basis, design)
    return assumed_pressure_scene(
        shell, LinearPto(study.pto.damper(design) or 0.0), load, water.density, water.gravity, motions
    )


def typical_state(scene: Scene) -> FloatArray:
    """Return heave and modal amplitudes in mid-wave, shape (dof,) [m].

    The linear static ones, plus a fifth of the radius in heave and a hundredth, alternating and falling, in the modes.
    """
    water, n, free = scene.water, scene.motions, scene.motions.shape[1]
    assert water is not None  # built by `scene_of_design`
    still = water.shell.forces(np.zeros((1, len(scene.labels))))[0][0]
    wave = 0.01 * (-1.0) ** np.arange(free) / np.maximum(np.arange(free), 1)
    wave[0] = 0.2
    static = np.linalg.solve(scene.stiffness, n.T @ (water.specific_weight * still + scene.constant))
    return n @ (static + water.shell.basis.shell.radius * wave)


def _seconds(call: Callable[[], object]) -> float:
    """Least wall time of several calls [s], the first of which warms up."""
    return min(timeit.repeat(call, number=1, repeat=6))


def fitted_order(settings: Sequence[float], errors: Sequence[float]) -> float:
    """Return the order p of an error that falls as setting^-p, by least squares of the logarithms."""
    return -float(np.polyfit(np.log(settings), np.log(np.maximum(errors, 1e-17)), 1)[0])


def quadrature_precision(study: Study) -> list[Row]:
    """Return error and seconds of generalized hydrostatic force, submerged volume and wet area, by three methods.

    The free shell in a typical deformed state. Discs: fitted order of all counts, which for volume and area scatter
    with where the waterline cuts a disc. Seconds are per evaluation, the waterline included; those of the kernel in a
    batch of 1000, as the integrators use it. Its volume is the heave component of its force; it gives no area.
    """
    design = next((name for name, d in study.designs.items() if d.flexible and not d.clamp), next(iter(study.designs)))
    scene = scene_of_design(study, design)
    assert scene.water is not None
    wet, q = scene.water.shell, typical_state(scene)

    def fresh() -> DeformedShell:  # it caches its waterline
        return DeformedShell(wet.basis, wet.centre_height, q)

    quantities: dict[str, tuple[Callable[[int], Any], Callable[[int], Any]]] = {
        "force": (lambda n: disc_force(fresh(), n)[0], lambda n: fresh().hydrostatic_force(1.0, 1.0, n)),
        "volume": (lambda n: disc_volume(fresh(), n).mean, lambda n: fresh().volume(n)),
        "wet area": (lambda n: disc_area(fresh(), n).mean, lambda n: fresh().wet_area(n)),
    }
    rows: list[Row] = []
    for case, (discs, gauss) in quantities.items():
        exact = gauss(CONVERGED)
        found = [_measured(case, "discs", n, discs, exact) for n in DISCS]
        order = fitted_order(DISCS, [row["error"] for row in found])
        rows += [{**row, "order": order} for row in found]
        rows += [_measured(case, "Gauss-Legendre", n, gauss, exact) for n in POINTS]
        if case != "wet area":
            rows.append(_kernel_row(case, wet, q, exact))
    return rows


def _relative(value: Any, exact: Any) -> float:
    """Norm of the error over the norm of the exact value [-]."""
    return float(np.linalg.norm(np.subtract(value, exact)) / np.linalg.norm(exact))


def _measured(case: str, method: str, setting: int, rule: Callable[[int], Any], exact: Any) -> Row:
    """Error and seconds of one rule."""
    found = {"error": _relative(rule(setting), exact), "seconds": _seconds(lambda: rule(setting))}
    return {"table": "quadrature", "case": case, "method": method, "setting": setting, **found, "status": "completed"}


def _kernel_row(case: str, wet: WetShell, q: FloatArray, exact: Any) -> Row:
    """Error and seconds of the compiled kernel, over a batch."""
    batch = np.tile(q, (1000, 1))
    static = wet.forces(batch)[0][0]
    row = _measured(
        case, "exact kernel", len(wet.shape.node), lambda _: static if case == "force" else static[0], exact
    )
    return {**row, "seconds": _seconds(lambda: wet.forces(batch)) / len(batch)}
