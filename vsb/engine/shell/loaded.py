"""The loaded shell: one potential energy, and from it force, tangent stiffness, equilibrium and buckling.

Potential = membrane + bending energy - work of the internal pressure + hydrostatic potential + weight, over heave and
the axisymmetric modes. Buckling into shapes that vary with azimuth is that of `vsb.engine.shell.lobes`; imperfections
are left out.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple, cast

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.optimize import brentq, minimize_scalar

from vsb.engine.shell.deformed import DeformedShell, Meridian
from vsb.engine.shell.device import Device, Gas
from vsb.engine.shell.meridian import length, meridian_rule
from vsb.engine.shell.modes import Mode, ModeBasis, curvature_shapes, strain_shapes
from vsb.engine.shell.shell import Shell, converged_degree
from vsb.engine.waves.water import Water
from vsb.errors import ConvergenceError
from vsb.tools.arrays import FloatArray


class Tables(NamedTuple):
    """Shapes at the quadrature points of the undeformed shell."""

    colatitude: FloatArray  # (point,) [rad]
    area: FloatArray  # of the ring of each point, (point,) [m^2]
    dphi: FloatArray  # weights of int f dphi, (point,) [rad]
    strains: tuple[FloatArray, FloatArray, FloatArray]  # `strain_shapes`
    curvatures: tuple[FloatArray, FloatArray]  # `curvature_shapes`
    meridian: Meridian


@lru_cache(maxsize=16)
def _tables(basis: ModeBasis, points: int) -> Tables:
    """Shapes at a number of quadrature points, cached for all materials; not to be written to."""
    colatitude, dphi = meridian_rule(basis.shell.meridian.junctions, points)
    at = basis.shell.at_rest(colatitude)
    area = 2 * np.pi * at.x * length(at.dx, at.dz) * dphi
    meridian = DeformedShell(basis, 0.0).meridian(colatitude)
    strains, curvatures = strain_shapes(basis, colatitude), curvature_shapes(basis, colatitude)
    return Tables(colatitude, area, dphi, strains, curvatures, meridian)


@dataclass(frozen=True)
class ElasticShell:
    """Elastic energy and enclosed volume over the amplitudes of a basis; bending always included.

    The energy is the integral of the wall's, Psi(E, kappa), over the undeformed surface
    (`vsb.engine.shell.material`). The Green strains E_phi = e_phi + (e_phi^2 + beta^2)/2 and E_theta = e_theta +
    e_theta^2/2 are those of the deformed surface, whatever the displacements; changes of curvature kappa are linear in
    them. With Hooke's law every integrand is a polynomial in cos phi, of degree at most 4N (energy) or 3N+2 (volume),
    so Gauss-Legendre quadrature with 2N+2 points or more is exact; rubber is given further points.
    """

    basis: ModeBasis

    @cached_property
    def _tables(self) -> Tables:
        prestress = converged_degree(self.basis.shell) // 2  # points for membrane forces of more degrees than the basis
        further = 4 * (self.basis.turns + 16) if self.basis.shell.rest is not None else 0
        if self.basis.shell.rubber is not None:
            further += 2 * self.basis.highest_degree + 16
        return _tables(self.basis.immaterial, 2 * self.basis.highest_degree + 2 + prestress + further)

    @property
    def rings(self) -> tuple[FloatArray, FloatArray]:
        """Colatitudes of the quadrature points [rad] and the areas of their rings [m^2], each shape (point,)."""
        return self._tables.colatitude, self._tables.area

    @property
    def shapes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Linear strains e_phi, e_theta and rotation beta per unit amplitude there, each shape (dof, point) [1/m]."""
        return self._tables.strains

    def strains(self, q: FloatArray, colatitude: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return Green-Lagrange strains E_phi, E_theta, each shape (point,) [-]; at the quadrature points if none."""
        shapes = self._tables.strains if colatitude is None else strain_shapes(self.basis, colatitude)
        meridional, hoop, rotation = (q @ shape for shape in shapes)
        return meridional + (meridional**2 + rotation**2) / 2, hoop + hoop**2 / 2

    def deformation(self, q: FloatArray) -> FloatArray:
        """Return strains and changes of curvature E_phi, E_theta, kappa_phi, kappa_theta, shape (4, point)."""
        return np.array([*self.strains(q), *(q @ shape for shape in self._tables.curvatures)])

    def resultants(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the membrane forces N_phi = dPsi/dE_phi, N_theta, each (point,) [N per metre undeformed]."""
        meridional, hoop, *_ = self.basis.shell.wall.resultants(self.deformation(q))
        return meridional, hoop

    def linear_resultants(self, q: FloatArray, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the membrane forces of small strains, C (e_phi + nu e_theta), N_theta, each shape (point,) [N/m]."""
        tables = self._tables
        shapes = tables.strains if colatitude is tables.colatitude else strain_shapes(self.basis, colatitude)
        meridional, hoop, _ = (q @ shape for shape in shapes)
        stiffness, nu = self.basis.shell.membrane_stiffness, self.basis.shell.poisson_ratio
        return stiffness * (meridional + nu * hoop), stiffness * (hoop + nu * meridional)

    def admits(self, q: FloatArray) -> bool:
        """Return whether the material can be strained so."""
        return self.basis.shell.law.admits(*self.strains(q))

    def energy(self, q: FloatArray) -> float:
        """Return U = int Psi dA [J]; of amplitudes (time, dof) shape (time,)."""
        energy = self.basis.shell.wall.energy(self.deformation(q)) @ self._tables.area
        if self._of_rings is not None:
            energy = energy + np.einsum("...i,ij,...j->...", q, self._of_rings, q) / 2
        return cast(float, energy)

    @cached_property
    def _of_rings(self) -> FloatArray | None:
        """Stiffness of the modes of rings, linear whatever the wall, shape (dof, dof) [N/m]; None without them."""
        rings = self.basis.rings
        return self.basis.of_rings(rings.stiffness + rings.prestress) if rings else None

    def force(self, q: FloatArray) -> FloatArray:
        """Return the elastic force -dU/dq, shape (dof,) [N]; of amplitudes (time, dof) that shape."""
        (e, t, b), (kappa, around), area = self._tables.strains, self._tables.curvatures, self._tables.area
        meridional, hoop, moment, other = area * self.basis.shell.wall.resultants(self.deformation(q))
        along, across = (meridional * (1 + q @ e)) @ e.T + (meridional * (q @ b)) @ b.T, (hoop * (1 + q @ t)) @ t.T
        force = np.asarray(-(along + across + moment @ kappa.T + other @ around.T))
        return force if self._of_rings is None else force - q @ self._of_rings

    def _gradients(self, q: FloatArray) -> tuple[FloatArray, ...]:
        """Derivatives of `deformation` by the amplitudes, each shape (dof, point)."""
        meridional, hoop, rotation = self._tables.strains
        along = (1 + q @ meridional) * meridional + (q @ rotation) * rotation
        return along, (1 + q @ hoop) * hoop, *self._tables.curvatures

    def membrane_factor(self, q: FloatArray) -> FloatArray:
        """Return L of the membrane's stiffness L L^T at amplitudes q, shape (dof, rank) [(N/m)^0.5]."""
        values, vectors = np.linalg.eigh(self.membrane_stiffness(q))
        kept = values > 1e-12 * values[-1]
        return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))

    def membrane_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the membrane's stiffness at amplitudes q, without bending, shape (dof, dof) [N/m].

        h d2W/dE_i dE_j dA in the gradients of the Green strains, the moduli those of the material as it is stretched.
        """
        along, hoop, *_ = self._gradients(q)
        moduli, volume = self.basis.shell.law.moduli(*self.strains(q)), self.basis.shell.thickness * self._tables.area
        mixed = (volume * moduli.mixed * along) @ hoop.T
        whole = (volume * moduli.first * along) @ along.T + (volume * moduli.second * hoop) @ hoop.T + mixed + mixed.T
        return np.asarray(whole)

    def material_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the part of the Hessian of U that holds the elastic moduli, bending included, (dof, dof) [N/m]."""
        gradients, moduli = (
            self._gradients(q),
            self._tables.area * self.basis.shell.wall.moduli(self.deformation(q)).normal,
        )
        return np.asarray(
            sum(
                one @ sum(c * other for c, other in zip(row, gradients, strict=True)).T
                for one, row in zip(gradients, moduli, strict=True)
            )
        )

    def geometric_stiffness(self, meridional: FloatArray, hoop: FloatArray) -> FloatArray:
        """Return int [N_phi (e_phi e_phi + beta beta) + N_theta e_theta e_theta] dA, shape (dof, dof) [N/m]."""
        (e, t, b), area = self._tables.strains, self._tables.area
        return (area * meridional * e) @ e.T + (area * meridional * b) @ b.T + (area * hoop * t) @ t.T

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return the Hessian of U, material and geometric, shape (dof, dof) [N/m]."""
        stiffness = self.material_stiffness(q) + self.geometric_stiffness(*self.resultants(q))
        return stiffness if self._of_rings is None else stiffness + self._of_rings

    def _deformed(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Radius x of the deformed meridian, dx/dphi and dz/dphi at the quadrature points, each shape (point,) [m]."""
        m = self._tables.meridian
        return m.x + q @ m.shape_x, m.dx + q @ m.dshape_x, m.dz + q @ m.dshape_z

    def volume(self, q: FloatArray) -> float:
        """Return the enclosed volume pi int x^2 dz over the closed meridian [m^3]; of (time, dof) shape (time,)."""
        x, _, dz = self._deformed(q)
        volume: float = -np.pi * np.dot(x**2 * dz, self._tables.dphi)  # phi runs downwards
        return volume

    def volume_gradient(self, q: FloatArray) -> FloatArray:
        """Return dV/dq_j = int n.psi_j dS, shape (dof,) [m^2]; of amplitudes (time, dof) that shape."""
        (x, dx, dz), weight, m = self._deformed(q), 2 * np.pi * self._tables.dphi, self._tables.meridian
        return np.asarray((weight * x * dx) @ m.shape_z.T - (weight * x * dz) @ m.shape_x.T)

    def volume_hessian(self, q: FloatArray) -> FloatArray:
        """Return d2V/dq_j dq_k = -2 pi int [x_j x_k z' + x (x_j z_k' + x_k z_j')] dphi, shape (dof, dof) [m]."""
        (x, _, dz), weight = self._deformed(q), 2 * np.pi * self._tables.dphi
        shape = self._tables.meridian.shape_x
        mixed = (x * weight * shape) @ self._tables.meridian.dshape_z.T
        return -((dz * weight * shape) @ shape.T + mixed + mixed.T)


@dataclass(frozen=True)
class LoadedShell:
    """An elastic shell with ballast, internal pressure and still water around it; q is heave and modes [m]."""

    elastic: ElasticShell
    centre_height: float  # of the sphere centre above still water at zero heave [m]
    water_density: float  # [kg/m^3]
    gravity: float  # [m/s^2]
    internal_pressure: float = 0.0  # gauge, at the undeformed volume if gas is trapped [Pa]
    gas: Gas | None = None  # None: a reservoir keeps the pressure constant

    @property
    def basis(self) -> ModeBasis:
        """Shapes of the amplitudes."""
        return self.elastic.basis

    def scaled(self, factor: float) -> "LoadedShell":
        """Return the same shell under `factor` times gravity and internal pressure."""
        return replace(self, gravity=factor * self.gravity, internal_pressure=factor * self.internal_pressure)

    @property
    def _contents(self) -> tuple[float, float, float]:
        """Adiabatic index, outer pressure and undeformed volume; constant pressure is a gas of index 0."""
        index, outside = (self.gas.adiabatic_index, self.gas.atmospheric_pressure) if self.gas else (0.0, 0.0)
        if self.gas is None:
            return index, outside, 1.0
        sphere = self.basis.shell.rest is None
        return index, outside, self.basis.shell.volume if sphere else self.elastic.volume(self._undisplaced)

    @property
    def _undisplaced(self) -> FloatArray:
        """Amplitudes of zero."""
        return np.zeros(len(self.basis.labels))

    @cached_property
    def _weighed(self) -> FloatArray:
        """The mass that gravity moves per unit of each amplitude, shape (dof,) [kg].

        That of the heave row of the inertia: a mode orthogonal to rigid heave has none. So the ballast hangs from the
        shell as the shell's own weight does, evenly over its area. Functions of other meridians than the sphere's, that
        have momentum of their own, raise as much of it as of the shell.
        """
        basis = self.basis
        if basis.shell.rest is None:
            return np.asarray(basis.inertia[0])
        momentum = basis.integrated("mass")[0]
        return np.asarray(basis.total_mass * momentum / momentum[0])

    def pressure(self, q: FloatArray) -> float:
        """Return the internal gauge pressure, (p_atm + p_i)(V_0/V)^gamma - p_atm for a trapped gas [Pa]."""
        index, outside, reference = self._contents
        pressure: float = (outside + self.internal_pressure) * (reference / self.elastic.volume(q)) ** index - outside
        return pressure

    def contents_energy(self, q: FloatArray) -> FloatArray:
        """Return minus the work of the internal pressure from the undeformed volume, of amplitudes (..., dof) [J]."""
        (index, outside, reference), volume = self._contents, self.elastic.volume(q)
        ratio = volume / reference
        grown = np.log(ratio) if index == 1 else (ratio ** (1 - index) - 1) / (1 - index)
        return np.asarray(outside * (volume - reference) - (outside + self.internal_pressure) * reference * grown)

    def _water(self, q: FloatArray) -> tuple[DeformedShell, int]:
        """The shell in the water, and the points per wet arc that resolve integrands of degree 4N+3."""
        return DeformedShell(self.basis, self.centre_height, q), 4 * self.basis.highest_degree + 40

    def force(self, q: FloatArray, water: FloatArray | None = None) -> FloatArray:
        """Return minus the gradient of the total potential, shape (dof,) [N]; that of the water may be known."""
        water = self.water_force(q) if water is None else water
        pressure = self.pressure(q) * self.elastic.volume_gradient(q)
        return np.asarray(self.elastic.force(q) + pressure + water - self.gravity * self._weighed)

    def pressure_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the follower part of a constant internal pressure, -p d2V/dq2, shape (dof, dof) [N/m]."""
        return -self.pressure(q) * self.elastic.volume_hessian(q)

    def gas_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the stiffness of trapped gas, gamma (p_atm + p)/V dV/dq dV/dq^T, shape (dof, dof) [N/m]."""
        if self.gas is None:
            return np.zeros((len(q), len(q)))
        (index, outside, _), gradient = self._contents, self.elastic.volume_gradient(q)
        return np.outer(gradient, gradient) * (index * (outside + self.pressure(q)) / self.elastic.volume(q))

    def water_force(self, q: FloatArray) -> FloatArray:
        """Return the force of the water, shape (dof,) [N]."""
        return self._hydrostatics(q)[0]

    def hydrostatic_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the stiffness of the water, shape (dof, dof) [N/m]; its round-off asymmetry removed."""
        return self._hydrostatics(q)[1]

    def _hydrostatics(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force and stiffness of the water; those of the undeformed shell depend on its shapes alone and are cached."""
        if not q.any():
            weight, (force, stiffness) = self.water_density * self.gravity, _undeformed(self._of_shapes)
            return weight * force, weight * stiffness
        if (key := q.tobytes()) not in self._last_water:
            shell, points = self._water(q)
            force, stiffness = shell.hydrostatics(self.water_density, self.gravity, points)
            self._last_water.clear()
            self._last_water[key] = force, (stiffness + stiffness.T) / 2
        return self._last_water[key]

    @cached_property
    def _last_water(self) -> dict[bytes, tuple[FloatArray, FloatArray]]:
        """The last found of these, by the amplitudes: several matrices at one rest are asked for in turn."""
        return {}

    def _hydrostatics_over(self, shapes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force of the water on the undeformed shell, (dof,) [N], and its stiffness over some shapes of it alone."""
        shell = self.basis.shell
        if np.imag(self.centre_height) or np.imag(shell.radius) or (shell.rest and shell.rest.stepped):
            water, points = self._water(self._undisplaced)
            return water.hydrostatics(self.water_density, self.gravity, points, shapes)
        force, stiffness = replace(self, centre_height=np.real(self.centre_height))._hydrostatics(self._undisplaced)
        return force, shapes.T @ stiffness @ shapes

    @property
    def _of_shapes(self) -> "LoadedShell":
        """The same shapes of a dummy material, empty, in water of unit weight."""
        return LoadedShell(ElasticShell(self.basis.immaterial), self.centre_height, 1.0, 1.0)

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return the Hessian of the total potential, the tangent stiffness, shape (dof, dof) [N/m]."""
        return self.force_and_stiffness(q)[1]

    def force_and_stiffness(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `force` and `stiffness`, which share the meridian in the water."""
        water, stiffness = self._hydrostatics(q)
        contents = self.pressure_stiffness(q) + self.gas_stiffness(q)
        return self.force(q, water), self.elastic.stiffness(q) + contents + stiffness

    @cached_property
    def unloaded_stiffness(self) -> FloatArray:
        """Stiffness at zero load: the shell and, if trapped, the gas at rest, shape (dof, dof) [N/m]."""
        q = self._undisplaced
        return self.elastic.stiffness(q) + self.scaled(0.0).gas_stiffness(q)

    @cached_property
    def first_order(self) -> FloatArray:
        """Modal amplitudes to first order in the load, K_unloaded^-1 force(0), heave zero, shape (dof,) [m]."""
        force = self.force(self._undisplaced)
        return np.append(0.0, np.linalg.solve(self.unloaded_stiffness[1:, 1:], force[1:]))

    def linear_resultants(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the membrane forces that carry the load on the undeformed sphere, each shape (point,) [N/m]."""
        degree = max(converged_degree(self.basis.shell), self.basis.highest_degree)
        basis = complete_basis(self.basis.shell, degree, self.basis.total_mass)
        complete = self if basis == self.basis else replace(self, elastic=ElasticShell(basis))
        return complete.elastic.linear_resultants(complete.first_order, colatitude)

    @cached_property
    def prestress_stiffness(self) -> FloatArray:
        """Geometric stiffness of the load and follower part of its pressure on the undeformed sphere, (dof, dof) [N/m].

        The membrane forces N are those of the linear static solution in a complete basis, not in the study's: they are
        statically determinate, so they belong to the load and must not depend on how many modes a study keeps; and the
        same energy gives them, so ballast, waterline and bending layer are those of `stiffness`. Of that, this is the
        part of first order in the load, less what classical buckling omits, strain and rotation before buckling (of
        relative order N/C); `stiffness` at an `equilibrium` has those too.
        """
        forces, q = self.linear_resultants(self.elastic.rings[0]), np.zeros(len(self.basis.labels))
        return self.elastic.geometric_stiffness(*forces) - self.pressure_inside * self.elastic.volume_hessian(q)

    @property
    def pressure_inside(self) -> float:
        """Gauge pressure inside at rest, to first order of the load; trapped gas expands with the shell [Pa]."""
        (index, outside, volume), q = self._contents, np.zeros(len(self.basis.labels))
        expansion: float = np.dot(self.elastic.volume_gradient(q), self.first_order) / volume
        return self.internal_pressure - index * outside * expansion


@lru_cache(maxsize=128)
def _undeformed(shell: LoadedShell) -> tuple[FloatArray, FloatArray]:
    """Force and stiffness of the water about an undeformed shell, cached for all materials; not to be written to."""
    water, points = shell._water(np.zeros(len(shell.basis.labels)))
    force, stiffness = water.hydrostatics(shell.water_density, shell.gravity, points)
    found = force, (stiffness + stiffness.T) / 2
    for values in found:
        values.setflags(write=False)
    return found


def complete_basis(shell: Shell, degree: int, mass: float) -> ModeBasis:
    """Return all shapes up to a degree as separate radial and meridional functions: the span of `full`.

    Degree 1 has one function beside rigid heave, V = 1, U = -1/2, of no momentum. Meridional ones are scaled by 1/n.
    """
    return ModeBasis(shell, _functions(degree), mass, bending=True)


@lru_cache(maxsize=64)
def _functions(degree: int) -> tuple[Mode, ...]:
    """The same as modes, kept: comparing bases is then fast."""
    modes = [Mode("Radial0", 0, 1.0, 0.0), Mode("Membrane1", 1, 1.0, -0.5)]
    for n in range(2, degree + 1):
        modes += [Mode(f"Radial{n}", n, 1.0, 0.0), Mode(f"Meridional{n}", n, 0.0, 1 / n)]
    return tuple(modes)


def _dominant_degree(elastic: ElasticShell, q: FloatArray) -> int:
    """Degree that holds most of the linear elastic energy of a shape; degrees are orthogonal."""
    return int(np.bincount(elastic.basis.degrees, q * (elastic.stiffness(0 * q) @ q)).argmax())


class Path(NamedTuple):
    """How far the growing load leads a shell in stable equilibrium."""

    amplitudes: FloatArray  # of the last stable state, (dof,) [m]
    reached: float  # factor of gravity and internal pressure there


def stable_path(loaded: LoadedShell, motions: FloatArray | None = None, until: float = 1.0) -> Path:
    """Return where a shell comes to as gravity and internal pressure grow from 0 to a factor of theirs.

    Newton's method in adaptive steps. The tangent stiffness must stay positive definite and the material within what it
    can bear: a step that would jump past a buckling or limit point is halved, and the path ends within 0.001 of it.
    `motions`, shape (dof, free), are those that clamps allow; all if not given.
    """
    n = np.eye(len(loaded.basis.labels)) if motions is None else motions
    q: FloatArray = np.zeros(n.shape[0])
    reached, step = 0.0, 0.25
    while reached < until:
        trial = min(until, reached + step)
        found = _newton(loaded.scaled(trial), n, q)
        if found is not None:
            q, reached, step = found, trial, 2 * step
        elif step < 1e-3:
            break
        else:
            step /= 2
    return Path(q, reached)


def equilibrium(loaded: LoadedShell, motions: FloatArray | None = None) -> FloatArray:
    """Return the static equilibrium reached from the undeformed shell as the load grows, shape (dof,) [m].

    Trapped gas loses pressure as the shell expands, and so leads a shell of rubber past the limit point it would burst
    at under constant pressure. Raises `ConvergenceError` if `stable_path` ends before the whole load is reached.
    """
    path = stable_path(loaded, motions)
    if path.reached < 1.0:
        n = np.eye(len(loaded.basis.labels)) if motions is None else motions
        raise ConvergenceError(_lost(loaded, n, path))
    return path.amplitudes


def equilibrium_near(loaded: LoadedShell, near: FloatArray, within: float = math.inf) -> FloatArray:
    """Return the static equilibrium near amplitudes (dof,) [m], else that of `equilibrium`, shape (dof,) [m].

    Of a shell whose growing load was followed with other modes, or of one that is close to it: of such a one the
    equilibrium that Newton's method finds may be that of a shell that has buckled on its way, unless it lies `within` a
    small distance [m]. Raises `ConvergenceError` as `equilibrium` does.
    """
    found = _newton(loaded, np.eye(len(near)), near)
    if found is None or np.abs(found - near).max() > within:
        return equilibrium(loaded)
    return found


def _newton(loaded: LoadedShell, n: FloatArray, q: FloatArray) -> FloatArray | None:
    """Newton's method in the motions n; none if it leaves the stable region or does not converge."""
    for _ in range(12):
        if not loaded.elastic.admits(q):
            return None
        try:
            force, stiffness = loaded.force_and_stiffness(q)
            correction = n @ cho_solve(cho_factor(n.T @ stiffness @ n), n.T @ force)
        except np.linalg.LinAlgError:
            return None
        largest, q = np.abs(correction).max() / loaded.basis.shell.radius, q + correction
        if not largest < 0.5:
            return None
        if largest < 1e-9:  # convergence is quadratic: the error left is its square
            return q
    return None


def _lost(loaded: LoadedShell, n: FloatArray, path: Path) -> str:
    """Message with the load and shape at which stability ends: the softest motion of the last stable state."""
    q, reached = path
    there = loaded.scaled(max(reached, 1e-3))
    stiffness, unloaded = there.stiffness(q), loaded.unloaded_stiffness.copy()
    unloaded[0, 0] = stiffness[0, 0]  # heave has no elastic stiffness to lose
    softest = n @ eigh(n.T @ stiffness @ n, n.T @ unloaded @ n, subset_by_index=[0, 0])[1][:, 0]
    degree, thickness = _dominant_degree(loaded.elastic, softest), loaded.basis.shell.thickness
    if degree == 0 and there.pressure(q) > 0:
        return (
            f"the shell passes its limit point at {reached:.3g} of its load, at an internal pressure of "
            f"{there.pressure(q):.4g} Pa: beyond it less pressure inflates it further; lower device.internal_pressure "
            f"(now {loaded.internal_pressure:g} Pa, gauge), trap the gas (device.gas), or raise device.thickness (now "
            f"{thickness:g} m)"
        )
    return (
        f"the shell buckles at {reached:.3g} of its load, into a shape of degree {degree}; raise "
        f"device.internal_pressure (now {loaded.internal_pressure:g} Pa, gauge) or device.thickness (now {thickness:g} "
        "m)"
    )


@dataclass(frozen=True)
class Buckling:
    """Linear buckling under gravity and internal pressure times one factor."""

    load_factor: float  # least factor that buckles the shell; inf: none does [-]
    degree: int  # Legendre degree with most of the mode's elastic energy
    linear_strain: float  # largest strain of the linear static solution: over-estimates large ones [-]
    order: int = 0  # number of waves around the axis; above 0 the degree remains that of axisymmetric buckling


def buckling_pencil(loaded: LoadedShell) -> tuple[FloatArray, FloatArray]:
    """Return K_0 and K_1 of K(L) = K_0 + L K_1 over the shell modes, the buoy free to heave, (mode, mode) [N/m]."""
    zero = np.zeros(len(loaded.basis.labels))
    gas = loaded.gas_stiffness(zero) - loaded.scaled(0.0).gas_stiffness(zero)
    load = loaded.prestress_stiffness + loaded.hydrostatic_stiffness(zero) + gas
    if load[0, 0].real > 0.0:  # a floating buoy finds its own heave: L cancels in the coupling over the waterplane
        load = load - np.outer(load[:, 0], load[0]) / load[0, 0]
    return loaded.unloaded_stiffness[1:, 1:], load[1:, 1:]


@dataclass(frozen=True)
class PencilSlopes:
    """How K_0 and K_1 of `buckling_pencil` change over few shapes: their matrices of a changed shell are not formed."""

    loaded: LoadedShell
    shapes: FloatArray  # (mode, shape), without heave

    @cached_property
    def _factor(self) -> tuple[FloatArray, bool]:
        """Of the stiffness at zero load."""
        return cho_factor(self.loaded.unloaded_stiffness[1:, 1:])

    def of(self, stepped: LoadedShell) -> tuple[FloatArray, FloatArray]:
        """Return the imaginary parts of x^T K_0 x and x^T K_1 x of a shell with an imaginary step, each (shape,)."""
        elastic, x = stepped.elastic, np.pad(self.shapes, ((1, 0), (0, 0)))
        tables, zero, known = elastic._tables, np.zeros(len(x)), self.loaded.first_order
        parts = (*tables.strains[:2], *tables.curvatures)
        moduli = tables.area * stepped.basis.shell.wall.moduli(elastic.deformation(zero)).normal
        (index, outside, reference), gradient = stepped._contents, elastic.volume_gradient(zero)
        gas = index * outside / elastic.volume(zero)

        def stressed(strains: Sequence[FloatArray]) -> list[FloatArray]:
            return [np.asarray(sum(c * e for c, e in zip(row, strains, strict=True))) for row in moduli]

        along, swept = [x.T @ part for part in parts], gradient @ x
        unloaded = sum((e * s).sum(axis=1) for e, s in zip(along, stressed(along), strict=True)) + gas * swept**2
        held = sum(part @ s for part, s in zip(parts, stressed([known @ part for part in parts]), strict=True))
        force, water = stepped._hydrostatics_over(np.column_stack([np.eye(len(x), 1), x]))
        left = stepped.force(zero, force) - held - gas * (gradient @ known) * gradient
        at_rest = known + 1j * np.append(0.0, cho_solve(self._factor, left.imag[1:]))

        (e, t, b), shell, m = (x.T @ part for part in tables.strains), stepped.basis.shell, tables.meridian
        strained, around = at_rest @ tables.strains[0], at_rest @ tables.strains[1]
        meridional, hoop = strained + shell.poisson_ratio * around, around + shell.poisson_ratio * strained
        stretched = (meridional * tables.area) * (e**2 + b**2) + (hoop * tables.area) * t**2
        inside = stepped.internal_pressure - index * outside * (gradient @ at_rest) / reference
        out, down, weight = x.T @ m.shape_x, x.T @ m.dshape_z, 2 * np.pi * tables.dphi
        growing = -((m.dz * weight) * out**2 + 2 * (m.x * weight) * out * down).sum(axis=1)
        load = shell.membrane_stiffness * stretched.sum(axis=1) - inside * growing + np.diag(water)[1:]
        load = load + index * stepped.internal_pressure / elastic.volume(zero) * swept**2
        if water[0, 0].real > 0.0:  # as in `buckling_pencil`
            load = load - water[0, 1:] ** 2 / water[0, 0]
        return np.imag(unloaded), np.imag(load)


def buckling(loaded: LoadedShell) -> Buckling:
    """Return the least L > 0 at which K_elastic + L (prestress + hydrostatic stiffness) is singular, heave free."""
    elastic, load = buckling_pencil(loaded)
    values, vectors = eigh(-load, elastic)
    e, t, _ = loaded.elastic._tables.strains
    return Buckling(
        1 / float(values[-1]) if values[-1] > 0 else math.inf,
        _dominant_degree(loaded.elastic, np.append(0.0, vectors[:, -1])),
        float(np.abs([loaded.first_order @ e, loaded.first_order @ t]).max()),
    )


def complete_shell(device: Device, centre_height: float, water: Water, internal_pressure: float) -> LoadedShell:
    """Return the loaded shell of a device, with its gas if it has some, in a basis that resolves its buckling."""
    basis = complete_basis(Shell.of(device), converged_degree(Shell.of(device)), device.mass)
    return LoadedShell(ElasticShell(basis), centre_height, water.density, water.gravity, internal_pressure, device.gas)


Pencil = tuple[FloatArray, FloatArray]
"""K_0 and K_1 of K(L) = K_0 + L K_1 over some shapes [N/m]."""


def viable_pressure(
    device: Device,
    centre_height: float,
    water: Water,
    further: Callable[[LoadedShell], Sequence[Pencil]] = lambda _: (),
    spare: float = 0.0,
) -> tuple[float, Buckling]:
    """Return the least internal pressure [Pa, gauge] with a buckling load factor of at least 1, and the latter.

    K_0 + K_1(p) is linear in p, so its least eigenvalue is concave: above its maximum more pressure does not
    help, below it the root is unique; raises `ConvergenceError` if no pressure suffices. For trapped gas it is the
    pressure at the undeformed volume, which falls as the shell expands. Imperfect shells buckle earlier than computed.

    Parameters
    ----------
    further : callable
        Pencils of a loaded shell beside `buckling_pencil`, such as those of lobes; the `Buckling` is without them.
    spare : float
        Part of the stiffness without load that every shape keeps: with none the shell gives way without end [-].
    """
    empty = complete_shell(device, centre_height, water, 0.0)
    breathing = 2 * empty.basis.shell.membrane_stiffness * (1 + device.poisson_ratio) / device.radius  # fails at it
    left = (replace(empty, internal_pressure=breathing).pressure_inside - empty.pressure_inside) / breathing
    highest = breathing / left
    below, above = ([buckling_pencil(one), *further(one)] for one in (empty, replace(empty, internal_pressure=highest)))

    def least(pressure: float) -> float:
        share = pressure / highest
        return -spare + min(
            float(eigh(k + (1 - share) * a + share * b, k, eigvals_only=True, subset_by_index=[0, 0])[0])
            for (k, a), (_, b) in zip(below, above, strict=True)
        )

    best = float(minimize_scalar(lambda p: -least(p), bounds=(0.0, highest), options={"xatol": 1e-6 * highest}).x)
    if least(best) < 0.0:
        raise ConvergenceError(
            f"no internal pressure keeps a shell of thickness {device.thickness:g} m from buckling under its load; "
            "raise device.thickness or device.young_modulus"
        )
    pressure = 0.0 if least(0.0) >= 0.0 else float(brentq(least, 0.0, best, xtol=1e-9 * highest))
    return pressure, buckling(replace(empty, internal_pressure=pressure))
