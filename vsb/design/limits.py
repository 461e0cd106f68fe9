"""What limits a design: the size of its hull, the strain of its shell at rest, its distance from buckling.

Fatigue of the wall: the damage that cycles of strain do over the years, and its derivatives.

A strain under a mean variance density is Gaussian. With the moments m_0 and m_2 of its variance density it rises
sqrt(m_2/m_0)/(2 pi) times a second through its mean, and if its band is narrow its ranges are 2 sqrt(2 m_0) times
Rayleigh's. The wall bears N (range/strain)^-m cycles of a range; by Miner's sum the damage over a time T is

    sum over seas of share T sqrt(m_2/m_0)/(2 pi N) (2 sqrt(2 m_0)/strain)^m Gamma(1 + m/2).

Of a wider band it is a bound from above on what counting rainflow cycles gives (Rychlik, Probabilistic Engineering
Mechanics 8, 1993). Strains are those of both faces of the wall along the meridian and around the axis, of membrane and
bending, about the shape at rest; the damage is that of the point of the wall where it is largest.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar

from vsb.design.linearised import Angle, motions_of, of_all
from vsb.design.resting import OF_DAMPING, RestingBuoy, Stepped, with_variable
from vsb.design.year import FrequencyGrid, YearMotion
from vsb.engine.shell.loaded import LoadedShell, PencilSlopes, buckling_pencil
from vsb.engine.shell.lobes import LobedShell, Lobes
from vsb.engine.shell.meridian import length, meridian_rule
from vsb.engine.shell.modes import curvature_shapes, rigid_basis, strain_shapes
from vsb.engine.waves.climate import YEAR_HOURS, Climate
from vsb.models.rest import complete_loaded_shell, loaded_shell
from vsb.study.design import Fatigue
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray

FACTORS = 4
"""Largest inverse load factors that are given: those of several buckling modes may cross."""
NO_MATTER = ("device.density", *(f"device.{name}" for name in OF_DAMPING))
"""Variables without effect on buckling: the load is the mass of the whole buoy."""
Slopes = tuple[float, list[float]]
"""A value and its derivatives by the variables of the device."""


def hull(buoy: RestingBuoy, stepped: Sequence[Stepped]) -> dict[str, Slopes]:
    """Return beam and draft [m], surface [m^2] and volume [m^3] of the hull at rest, and mass [kg], with derivatives.

    Where the hull is widest and deepest does not matter for derivatives: both are extrema along the meridian.
    """
    widest, deepest = (
        _highest(lambda phi: buoy.shape.curve(phi).x, buoy),
        _highest(lambda phi: -buoy.shape.curve(phi).z, buoy),
    )
    functions: dict[str, Callable[[RestingBuoy], AnyArray]] = {
        "beam": lambda b: 2 * b.shape.curve(widest).x[0],
        "draft": lambda b: -b.shape.curve(deepest).z[0],
        "surface": _surface,
        "volume": lambda b: np.asarray(b.loaded.elastic.volume(b.modal_amplitude)),
        "mass": lambda b: np.asarray(b.loaded.basis.total_mass),
    }
    return {
        name: (float(function(buoy)), [float(one.derivative(function)) for one in stepped])
        for name, function in functions.items()
    }


def _surface(buoy: RestingBuoy) -> AnyArray:
    """Area of the hull, int 2 pi x ds."""
    basis = buoy.loaded.basis
    phi, weight = meridian_rule(basis.shell.meridian.junctions, 8 * basis.turns + 48)
    at = buoy.shape.curve(phi)
    return np.asarray(2 * np.pi * (at.x * length(at.dx, at.dz)) @ weight)


def _highest(function: Callable[[FloatArray], FloatArray], buoy: RestingBuoy) -> FloatArray:
    """Colatitude where a function of it is largest, shape (1,) [rad]: on ever finer grids, then a parabola."""
    grid = colatitudes(buoy)
    for _ in range(2):
        at = int(np.argmax(function(grid)))
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], CLOSER)
    values = function(grid)
    at = int(np.argmax(values))
    if not 0 < at < len(grid) - 1:
        return grid[at : at + 1]
    before, most, after = values[at - 1 : at + 2]
    bend = before - 2 * most + after
    step = (grid[at] - grid[at - 1]) * ((before - after) / (2 * bend) if bend else 0.0)
    return np.array([grid[at] + step])


CLOSER = 33
"""Colatitudes between two of a grid at which a maximum is sought next."""


def colatitudes(buoy: RestingBuoy, per_turn: int = 40) -> FloatArray:
    """Return colatitudes that resolve the shape [rad], from pole to pole; on other meridians than the sphere's between.

    There strains are not computed at the poles, where their slope is zero.
    """
    aside = 1e-4 if buoy.loaded.basis.shell.rest else 0.0
    return np.linspace(aside, np.pi - aside, per_turn * (buoy.loaded.basis.turns + 1) + 1)


def static_strain(buoy: RestingBuoy, stepped: Sequence[Stepped]) -> Slopes:
    """Return the largest Green-Lagrange membrane strain of the shell at rest [-], with derivatives.

    Of the linear static solution about a shell that is taken as undeformed.
    """

    def displaced(b: RestingBuoy) -> FloatArray:
        return b.modal_amplitude if b.study.at_equilibrium else b.linear_rest

    def strains(b: RestingBuoy, q: FloatArray, phi: FloatArray) -> AnyArray:
        return np.array(b.loaded.elastic.strains(q, phi))

    q = displaced(buoy)
    which = int(np.abs(strains(buoy, q, colatitudes(buoy))).max(axis=1).argmax())
    at = _highest(lambda phi: np.abs(strains(buoy, q, phi)[which]), buoy)
    value = float(strains(buoy, q, at)[which, 0])
    slopes = [one.derivative(lambda b: strains(b, displaced(b), at)[which, 0]) for one in stepped]
    return abs(value), [float(np.sign(value) * slope) for slope in slopes]


def inverse_load_factors(study: Study, keys: Sequence[str]) -> list[Slopes]:
    """Return the largest inverse load factors of linear buckling [-], descending, with derivatives by keys of a device.

    Eigenvalues kappa of -K_1 x = kappa K_0 x (`vsb.engine.shell.loaded.buckling_pencil`): 1 buckles under its load, 0
    and less under no load. They are smooth where load factors leap to infinity. With x^T K_0 x = 1
    dkappa = -x^T (dK_1 + kappa dK_0) x. On other meridians than the sphere's those of lobes around the axis are among
    them (`vsb.engine.shell.lobes`).
    """
    loaded = complete_loaded_shell(study)
    elastic, load = buckling_pencil(loaded)
    kappa, x = eigh(-load, elastic, subset_by_index=[len(load) - FACTORS, len(load) - 1])
    found = [Lobes(float(k), 0, shape) for k, shape in zip(kappa, x.T, strict=True)]
    if loaded.basis.shell.rest is not None:
        found += LobedShell.of(loaded).buckling(FACTORS)
    found = sorted(found, key=lambda one: -one.inverse_load_factor)[:FACTORS]
    axisymmetric = PencilSlopes(loaded, np.array([one.shape for one in found if one.order == 0]).T)
    rigid = RestingBuoy(study, loaded_shell(study, rigid_basis(study.device)), np.zeros(1))  # it floats undeformed
    slopes = []
    for key in keys:
        if key in NO_MATTER:
            slopes.append([0.0] * FACTORS)
            continue
        step = rigid.with_step(key)
        changed = with_variable(loaded, key, 1j * step.size, study.device)
        changed = replace(changed, centre_height=step.buoy.loaded.centre_height)
        slopes.append([change / step.size for change in _changes(changed, found, axisymmetric)])
    return [(one.inverse_load_factor, [change[j] for change in slopes]) for j, one in enumerate(found)]


def _changes(changed: LoadedShell, shapes: Sequence[Lobes], axisymmetric: PencilSlopes) -> list[float]:
    """Imaginary parts of inverse load factors of a shell with an imaginary step, by the shapes of the one without."""
    lobed, found = LobedShell.of(changed), []
    without = iter(zip(*axisymmetric.of(changed), strict=True)) if axisymmetric.shapes.size else iter(())
    for kappa, order, x in shapes:
        pencil = lobed.pencil(order, x[:, None]) if order else next(without)
        elastic, load = (np.imag(one).item() for one in pencil) if order else pencil
        found.append(-float(load + kappa * elastic))
    return found


PER_TURN = 8
"""Colatitudes per degree of the shell, between which the largest damage is sought."""


@dataclass(frozen=True)
class SeaMoments:
    """Moments of a response in every sea of a climate from its response amplitudes at the frequencies of a grid."""

    grid: FrequencyGrid
    climate: Climate

    def of(self, values: AnyArray) -> AnyArray:
        """Return int S values dw of every sea, shape (..., sea), from values at the frequencies, (..., omega)."""
        return np.asarray(self._bands(values) @ self.climate.density.T)

    def back(self, weights: AnyArray) -> AnyArray:
        """Return the sum over seas of weights (sea,) times S dw at each frequency, shape (omega,)."""
        return np.asarray((weights @ self.climate.density)[self._band] * self._width)

    @property
    def _band(self) -> AnyArray:
        """The band of the climate each frequency is in."""
        return np.searchsorted(self.climate.edges, self.grid.omega, side="right") - 1

    @property
    def _width(self) -> FloatArray:
        """Width dw of each frequency [rad/s]."""
        return np.asarray(self.grid.variance / self.climate.mean_density[self._band])

    def _bands(self, values: AnyArray) -> AnyArray:
        """Integrals over the bands, shape (..., band)."""
        one_of_each = np.zeros((len(self.grid.omega), len(self.climate.omega)))
        one_of_each[np.arange(len(one_of_each)), self._band] = self._width
        return np.asarray(values @ one_of_each)


def damages(fatigue: Fatigue, climate: Climate, m_0: FloatArray, m_2: FloatArray) -> FloatArray:
    """Return the damage in every sea over the years, shape (..., sea) [-], from moments of strain [1], [rad^2/s^2]."""
    m, seconds = fatigue.exponent, fatigue.years * YEAR_HOURS * 3600 * climate.hours
    rate = np.sqrt(np.divide(m_2, m_0, out=np.zeros_like(m_2), where=m_0 > 0)) / (2 * np.pi)
    return np.asarray(
        seconds * rate / fatigue.cycles * (np.sqrt(8 * m_0) / fatigue.strain) ** m * math.gamma(1 + m / 2)
    )


def strain_rows(buoy: RestingBuoy, colatitude: FloatArray) -> AnyArray:
    """Return strains of the wall per unit of heave and functions about the rest shape, shape (4, dof, point) [1/m].

    Along the meridian on the outer and the inner face, then around the axis.
    """
    basis, at_rest = buoy.loaded.basis, buoy.modal_amplitude
    along, around, rotation = strain_shapes(basis, colatitude)
    bent_along, bent_around = (basis.shell.thickness / 2 * one for one in curvature_shapes(basis, colatitude))
    along = (1 + at_rest @ along) * along + (at_rest @ rotation) * rotation  # of E = e + (e^2 + rotation^2)/2
    around = (1 + at_rest @ around) * around
    rows = np.array([along + bent_along, along - bent_along, around + bent_around, around - bent_around])
    return buoy.framed(rows.swapaxes(1, 2)).swapaxes(1, 2)


@dataclass(frozen=True)
class Wall:
    """The strained wall of a buoy over the seas of a climate, its take-off included."""

    fatigue: Fatigue
    moments: SeaMoments
    amplitude: ComplexArray  # of each degree of freedom per wave amplitude, (omega, dof) [m/m]

    def damage(self, rows: FloatArray) -> FloatArray:
        """Return the damage under strains, shape (row,), of rows of strain per motion, shape (row, dof)."""
        return np.asarray(damages(self.fatigue, self.moments.climate, *self._moments(rows)).sum(axis=-1))

    def weights(self, row: FloatArray) -> FloatArray:
        """Return the derivative of the damage under a strain by |strain|^2 at each frequency, shape (omega,)."""
        m_0, m_2 = self._moments(row)
        share = damages(self.fatigue, self.moments.climate, m_0, m_2)
        by_m_0 = np.divide(share, m_0, out=np.zeros_like(share), where=m_0 > 0) * (self.fatigue.exponent - 1) / 2
        by_m_2 = np.divide(share, m_2, out=np.zeros_like(share), where=m_2 > 0) / 2
        return self.moments.back(by_m_0) + self.moments.grid.omega**2 * self.moments.back(by_m_2)

    def _moments(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Moments m_0 [1] and m_2 [rad^2/s^2] of strains in every sea, each (..., sea)."""
        square = np.abs(rows @ self.amplitude.T) ** 2
        return self.moments.of(square), self.moments.of(square * self.moments.grid.omega**2)


def damage(
    fatigue: Fatigue,
    climate: Climate,
    buoy: RestingBuoy,
    design: str,
    steps: Sequence[Stepped | Angle],
    places: Sequence[int],
    motion: YearMotion,
    damper: tuple[float, FloatArray],
) -> tuple[float, FloatArray]:
    """Return the damage of the wall where it is largest [-], and its derivatives, shape (variable,).

    With q = D^-1 X the motion beside the damper and l = D^-1 e the one under forces along a strain e, D is symmetric,
    and the strain changes by de.q + l.(dX - dD q). The place does not matter for derivatives: the damage is largest
    there.

    Parameters
    ----------
    design : str
        Whose clamp holds.
    steps : sequence of Stepped
        Or of an angle.
    places : sequence of int
        Of these among the variables.
    motion : YearMotion
        Of the buoy without its damper, over its free motions.
    damper : tuple of float and ndarray
        Damper [N s/m] and its derivatives, shape (variable,).
    """
    (motions, turned), count = motions_of(buoy, design, steps), len(buoy.modal_amplitude)
    matrix = damper[0] * np.eye(len(motion.rows))
    q = motion.damped(matrix, motion.undamped[0])
    motions, turned = motions[:count], turned[:, :count]  # modes of rings strain the wall at their rings alone
    wall = Wall(fatigue, SeaMoments(motion.grid, climate), q @ motions.T)
    face, at = _worst(wall, buoy)

    def row(b: RestingBuoy) -> AnyArray:
        return strain_rows(b, at)[face, :, 0]

    here = row(buoy)
    change = np.array([one.derivative(row) if isinstance(one, Stepped) else np.zeros(len(here)) for one in steps])
    free = here @ motions
    row_change = of_all(change.reshape(-1, len(here)) @ motions + here @ turned, places, len(damper[1]))
    strained = np.linalg.solve(motion.dynamic, np.broadcast_to(free, q.shape)[..., None])[..., 0]
    under = motion.damped(matrix, strained)
    slopes = row_change @ q.T + motion.slopes(under, q, matrix, damper[1][:, None, None] * np.eye(len(matrix)))
    strain = q @ free
    return float(wall.damage(here)), 2 * (strain.conj() * slopes).real @ wall.weights(here)


def _worst(wall: Wall, buoy: RestingBuoy) -> tuple[int, FloatArray]:
    """The strain that does most damage, and the colatitude where it does, shape (1,) [rad]."""
    grid = colatitudes(buoy, PER_TURN)
    found = wall.damage(strain_rows(buoy, grid).swapaxes(1, 2))
    face, place = divmod(int(found.argmax()), len(grid))
    bounds = grid[max(place - 1, 0)], grid[min(place + 1, len(grid) - 1)]

    def less(phi: float) -> float:
        return -float(wall.damage(strain_rows(buoy, np.array([phi]))[face, :, 0]))

    best = minimize_scalar(less, bounds=bounds, options={"xatol": 1e-10})
    return face, np.array([best.x if -best.fun > found[face, place] else grid[place]])
