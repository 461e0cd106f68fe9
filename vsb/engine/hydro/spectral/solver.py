"""Radiation and diffraction by boundary elements of spectral order, for shells with one smooth wet side.

Motions and potentials vary like cos(m theta): heave and axisymmetric shapes for m = 0, surge and pitch for m = 1. With
K = omega^2/g, phasors exp(-i omega t), n out of the body and Green's function G = 1/r + 1/r' + waves integrated over
the azimuth (`meridian.py`, `green.py`), on the meridian

    2 pi phi(x) - int phi dG/dn' dS' = -int G w dS'      (radiation by the normal velocity w)
                                     = 4 pi phi_I(x)     (total potential of incident wave and fixed body)

and the same without 2 pi phi at points inside the body, which pins down what the surface alone leaves open at the
eigenfrequencies of the water inside ("irregular frequencies").

Over a band, points and frequencies are as few as the tolerances allow (`converged`, `converged_on_grid`).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import solved_dataset, with_excitation
from vsb.engine.hydro.dofs import Displacement, azimuthal_order, bessel, multiplicity, normal_velocities
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.spectral.green import FiniteDepthWavePart, WavePart, wave_profile
from vsb.engine.hydro.spectral.meridian import WetMeridian
from vsb.engine.hydro.sweep import AdaptiveSweep, IncidentWave, crowded, on_grid, relative
from vsb.engine.hydro.variables import PAIR, RESOLUTION
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.orders import semi_normalisation
from vsb.engine.waves.water import wavenumber
from vsb.errors import ConfigError, ConvergenceError
from vsb.tools.arrays import ComplexArray, FloatArray

_COARSER = 0.75
"""Relative number of points of the coarser run that the error is estimated from."""


_Column = tuple[FloatArray | ComplexArray, ...]
"""Added mass, damping, Froude-Krylov and diffraction force at one frequency."""


class Geometry(NamedTuple):
    """The wet meridian at some nodes, and the last waves' part of Green's function between them."""

    meridian: WetMeridian
    surface: list[WavePart]


@dataclass(frozen=True)
class SpectralProblem:
    """Radiation and diffraction of prescribed displacements of the immersed shell, all of one azimuthal order m.

    Conventions and results are those of `vsb.engine.hydro.panels.rings`' problem of the same arguments. For m >= 1 the
    wave's component of that order excites, of a wave to +x.
    """

    shell: DeformedShell
    displacements: tuple[Displacement, ...]
    density: float
    gravity: float
    nodes: int
    depth: float = np.inf
    known: dict[int, Geometry] = field(default_factory=dict, repr=False, compare=False)  # by nodes; of one shape shared
    _columns: dict[float, _Column] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        azimuthal_order(self.displacements)
        if not self.depth > 0:
            raise ConfigError(f"depth: received {self.depth} m; needs a positive depth, infinite for deep water")

    @cached_property
    def order(self) -> int:
        """Azimuthal order m of all displacements."""
        return azimuthal_order(self.displacements)

    @property
    def _geometry(self) -> Geometry:
        """What does not depend on displacements."""
        if self.nodes not in self.known:
            self.known[self.nodes] = Geometry(WetMeridian(self.shell, self.nodes, self.order), [])
        return self.known[self.nodes]

    @property
    def meridian(self) -> WetMeridian:
        """The wet side of the shell."""
        return self._geometry.meridian

    @cached_property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements at the nodes, shape (displacement, node) [m/s per m/s]."""
        p = self.meridian.points
        return normal_velocities(self.displacements, p.colatitude, np.array([p.x, p.z]), np.array([p.n_x, p.n_z]))

    @property
    def _normalisation(self) -> FloatArray:
        """Semi-normalised functions over those of the displacements, shape (displacement,) [-]; 1 of rigid motions."""
        m = self.order
        return np.array([semi_normalisation(d.degree, m) if m and not d.rigid else 1.0 for d in self.displacements])

    @cached_property
    def onto(self) -> FloatArray:
        """Generalized force of a unit potential at the nodes, -rho w_i dS, shape (displacement, node)."""
        return -2 * np.pi / multiplicity(self.order) * self.density * self.velocities * self.meridian.areas

    def _limit(self, image: float) -> FloatArray:
        """Added mass with G = 1/r + image/r' and what the bottom adds, shape (displacement, displacement) [kg]."""
        m = self.meridian
        influence = m.rankine[0] + image * m.rankine[1]
        if np.isfinite(self.depth):
            bottom = FiniteDepthWavePart(m, self.depth, 1 / self.depth)
            influence += (bottom.at_infinity() if image < 0 else bottom.at_zero()) * m.areas
        single, double = influence
        return np.real(self.onto @ m.solve(double + 0j, -single @ self.velocities.T + 0j))

    def at_infinity(self) -> FloatArray:
        """Added mass at infinite frequency, where the potential vanishes at z = 0 [kg]."""
        return self._limit(-1.0)

    def at_zero(self) -> FloatArray:
        """Added mass at frequency zero, where the water's surface is a wall [kg]; axisymmetric only in deep water."""
        return self._limit(1.0)

    def wavenumbers(self, omegas: list[float]) -> FloatArray:
        """Return the wavenumbers of waves of these frequencies, shape (omega,) [1/m]."""
        return np.array([wavenumber(omega, self.depth, self.gravity) for omega in omegas])

    def incident(self, k: FloatArray) -> ComplexArray:
        """Return the wave's component of this order at the equations' points in terms of -i g/omega, (k, target).

        Of amplitude one, along x: in deep water e^{kz} e^{ikx} = e^{kz} sum_m (2 - delta_m0) i^m J_m(kR) cos(m theta).
        """
        x, z = self.meridian.targets
        value, _ = bessel(self.order, np.outer(k, x))
        return np.asarray(multiplicity(self.order) * 1j**self.order * wave_profile(k, self.depth, z) * value)

    def _waves(self, omegas: list[float]) -> Iterator[ComplexArray]:
        """Influence of Green's function less 1/r + 1/r' at each frequency, per unit area, each (2, target, node)."""
        deep = np.square(omegas) / self.gravity
        surface = self._surface_to(float(deep.max())).influences(deep)
        if np.isinf(self.depth):
            return surface
        return map(np.add, surface, FiniteDepthWavePart(self.meridian, self.depth, float(deep.min())).influences(deep))

    def _surface_to(self, largest: float) -> WavePart:
        """The waves' part of Green's function up to a wavenumber [1/m]; what was made up to a larger one is kept."""
        surface = self._geometry.surface
        if not (surface and surface[0].largest >= largest):
            surface[:] = [WavePart(self.meridian, largest)]
        return surface[0]

    def solve(self, omegas: list[float]) -> xr.Dataset:
        """Solve at positive, finite frequencies (else: `ConfigError`), each once; dataset as of rings of panels.

        Pressure i omega rho phi, so A + iB/omega = -rho int phi_j w_i dS; incident potential -i g/omega `incident`.
        """
        new = [omega for omega in dict.fromkeys(omegas) if omega not in self._columns]
        for omega, incident, potentials in self._solved(new) if new or not omegas else ():
            forces = self.onto @ potentials
            froude_krylov = self.gravity * (self.onto @ incident[: self.meridian.count])
            radiated, total = forces[:, :-1], self.gravity * forces[:, -1]
            self._columns[omega] = radiated.real, omega * radiated.imag, froude_krylov, total - froude_krylov
        labels = [each.label for each in self.displacements]
        return solved_dataset(omegas, labels, [self._columns[omega] for omega in omegas])

    def potentials(self, omegas: list[float]) -> ComplexArray:
        """Return the potentials at the nodes at positive, finite frequencies, shape (omega, node, displacement + 1).

        Of motion of unit normal velocity of each displacement [m^2/s per m/s], and last of the incident wave with the
        body held, in terms of -i g/omega and the wave's amplitude [-].
        """
        return np.array([potentials for _, _, potentials in self._solved(omegas)])

    def _solved(self, omegas: list[float]) -> Iterator[tuple[float, ComplexArray, ComplexArray]]:
        """Frequency, incident wave at the equations' points and `potentials` of each frequency."""
        if not omegas or not all(0 < omega < np.inf for omega in omegas):
            raise ConfigError(f"omega: received {omegas} rad/s; needs positive, finite frequencies")
        m, incoming = self.meridian, self.incident(self.wavenumbers(omegas))
        for omega, incident, waves in zip(omegas, incoming, self._waves(omegas), strict=True):
            single, double = m.rankine.sum(axis=0) + waves * m.areas
            right = np.column_stack([-single @ self.velocities.T, 4 * np.pi * incident])
            yield omega, incident, m.solve(double, right)

    @cached_property
    def _coarser(self) -> "SpectralProblem":
        """The problem with fewer points."""
        return replace(self, nodes=int(_COARSER * self.nodes))

    def error_estimate(self, omegas: list[float]) -> xr.Dataset:
        """Return estimates of the errors of a run, relative to the largest entry at each frequency.

        Shapes count by their semi-normalised functions: P_n^m grows like n^m.

        Twice the largest difference from a run with three quarters of the points, whose own error is the larger one;
        for damping and excitation plus the misfit of Haskind's relation, an error common to both runs. `RESOLUTION` is
        the same of each displacement by itself, relative to its largest over these frequencies: the points that the
        shortest shapes need resolve the longer ones far better.
        """
        runs = [with_excitation(p.solve(omegas)) for p in (self._coarser, self)]
        forces = [ds.excitation_force.values[:, 0] for ds in runs]
        haskind = haskind_damping(runs[1], self.depth, self.density, self.gravity, self.order)
        share = self._normalisation
        shares = np.outer(share, share)
        missed = _relative(shares * haskind, shares * runs[1].radiation_damping.values)
        errors = {
            "added_mass": _relative(*(shares * ds.added_mass.values for ds in runs)),
            "radiation_damping": _relative(*(shares * ds.radiation_damping.values for ds in runs)) + missed,
            "excitation_force": _relative(*(share * force for force in forces)) + missed,
        }
        mass, damping = (
            [np.einsum("wii->iw", ds[name].values) for ds in runs] for name in ("added_mass", "radiation_damping")
        )
        flux = _relative(np.einsum("wii->iw", haskind), damping[1])
        own = np.maximum(_relative(*mass), flux + np.maximum(_relative(*damping), _relative(*(x.T for x in forces))))
        found = xr.Dataset({name: ("omega", 2 * e) for name, e in errors.items()}, coords={"omega": omegas})
        size = np.sqrt(np.abs(mass[1]).max(axis=1))
        return found.assign({RESOLUTION: xr.DataArray(2 * own * size, runs[1].influenced_dof.coords)})


def _relative(other: ComplexArray | FloatArray, value: ComplexArray | FloatArray) -> FloatArray:
    """Largest difference at each frequency in terms of the largest value there, shape (omega,); none of nothing."""
    difference, size = (np.abs(a).reshape(len(value), -1).max(axis=1) for a in (other - value, value))
    return np.asarray(difference / np.maximum(size, np.finfo(float).tiny))


FEWEST_NODES = 16
NODES_OF_LOADS = 1.5
"""Nodes over the highest degree of what a wall does under a load: the higher, the less of it [-]."""
MOST_NODES = 256


def fewest_nodes(moved: Sequence[Displacement], each_degree: float = 0.0) -> int:
    """Return a power of two of nodes to begin with: enough for loads, of other shapes so many for each degree."""
    of_loads = NODES_OF_LOADS * max((one.highest for one in moved if one.kind == "load"), default=0)
    needed = max(of_loads, each_degree * max(one.highest for one in moved if one.kind != "load"))
    return max(FEWEST_NODES, 2 ** math.ceil(math.log2(needed)) if needed else 0)


def incident_wave(problem: SpectralProblem) -> IncidentWave:
    """Return the parts of a problem's excitation known without solving."""
    m = problem.meridian
    radius = float(m.shell.meridian(np.array([m.waterline])).x[0])

    def froude_krylov(omega: FloatArray) -> ComplexArray:
        incident = problem.incident(problem.wavenumbers(list(omega)))[:, : m.count]
        return np.asarray(problem.gravity * (incident @ problem.onto.T)[:, None])

    return IncidentWave(lambda omega: radius * problem.wavenumbers(list(omega)), froude_krylov, problem.order)


def largest_error(estimate: xr.Dataset) -> float:
    """Return the largest of the estimated errors of added mass, damping and excitation."""
    return float(max(estimate.drop_vars(RESOLUTION).max().values()))


def _limits(problem: SpectralProblem) -> dict[str, xr.Variable]:
    """Added mass at infinite frequency and, where it has a limit, at zero."""
    limits = {"added_mass_inf": xr.Variable(PAIR, problem.at_infinity())}
    if np.isfinite(problem.depth) and not problem.order:
        return limits  # log K
    return limits | {"added_mass_zero": xr.Variable(PAIR, problem.at_zero())}


def _limit_difference(swept: AdaptiveSweep, limits: dict[str, xr.Variable]) -> float:
    """Largest relative difference of extrapolated limits of added mass from those solved directly."""
    if not swept.radiation.values.any():
        return 0.0  # the motions move no water
    far = {"added_mass_inf": swept.at_infinity, "added_mass_zero": swept.at_zero}
    return max(relative(far[name] - limit.values, limit.values) for name, limit in limits.items())


def resolved(
    problem: SpectralProblem, omegas: list[float], tolerance: float, most: int = MOST_NODES
) -> tuple[SpectralProblem, xr.Dataset]:
    """Return the problem with as many points as the frequencies need, by doubling, and its estimated errors.

    Raises `ConvergenceError` if `most` points do not reach the tolerance.
    """
    while problem.nodes <= most:
        estimate = problem.error_estimate(omegas)
        if (error := largest_error(estimate)) <= tolerance:
            return problem, estimate
        problem = replace(problem, nodes=2 * problem.nodes)
    raise ConvergenceError(
        f"hydro.tolerance: received {tolerance:g}, the spectral solver reaches {error:.1e} with {most} points; "
        "raise it, lower hydro.omega_max, or set hydro.solver: panels"
    )


def converged(problem: SpectralProblem, omegas: list[float], tolerance: float) -> xr.Dataset:
    """Return coefficients solved at these frequencies and at infinity, with as few points as a tolerance needs.

    Parameters and attributes as of `converged_on_grid`. Raises `ConvergenceError` as of `resolved`.
    """
    problem, estimate = resolved(problem, omegas, tolerance)
    ds = problem.solve(omegas).assign(_limits(problem)).assign({RESOLUTION: estimate[RESOLUTION]})
    return ds.assign_attrs(error_estimate=largest_error(estimate), solves=len(omegas), frequencies=len(omegas))


def converged_on_grid(
    problem: SpectralProblem, frequencies: list[float], tolerance: float, interpolation: float
) -> xr.Dataset:
    """Return coefficients on a grid of frequencies and at infinity, from as few points and solves as tolerances need.

    Raises `ConvergenceError` as of `resolved`.

    Parameters
    ----------
    problem : SpectralProblem
        With the fewest points.
    frequencies : list of float [rad/s]
        Ascending.
    tolerance, interpolation : float [-]
        Of the boundary elements' error at the frequencies solved, and of interpolation between them.

    Returns
    -------
    xarray.Dataset
        With the attributes `error_estimate`, of the boundary elements; `interpolation_error`, of the sweep and of cubic
        splines through these frequencies; `limit_difference` of added mass extrapolated by the sweep to infinite
        frequency, and in deep water to zero, from that solved there, relative to its largest entry; `solves` and
        `frequencies`, their numbers.
    """
    omegas, error = [frequencies[i] for i in crowded(len(frequencies))], np.inf
    while error > tolerance:
        problem, _ = resolved(problem, omegas, tolerance)
        found = on_grid(problem.solve, frequencies, interpolation, incident_wave(problem))
        omegas, estimate = found.solved, problem.error_estimate(found.solved)
        error = largest_error(estimate)
    limits = _limits(problem)
    attrs: dict[str, float] = {"error_estimate": error, "solves": len(omegas), "frequencies": len(frequencies)}
    if found.sweep:
        attrs["interpolation_error"] = found.sweep.error + found.spline_error(found.sweep.at)
        attrs["limit_difference"] = _limit_difference(found.sweep, limits)
    else:
        attrs["interpolation_error"] = found.spline_error(problem.solve)
    return found.coefficients.assign(limits).assign({RESOLUTION: estimate[RESOLUTION]}).assign_attrs(attrs)
