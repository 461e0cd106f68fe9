"""A floating system in linear waves: mass, damping, stiffnesses by name and coefficients over frequency.

It is a buoy (a shell of revolution with its modes) or a body of any shape; they differ in how they are made and in how
their coefficients are interpolated. A body's database may be its own, or come from WAMIT, BEMIO or capytaine
(`vsb.engine.hydro.formats`); mass, damping and stiffness of the dry body are the database's where they are not given.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

from vsb.engine.hydro.database import Coefficients, transformed, with_history
from vsb.engine.hydro.formats.common import DRY, Structure, structure
from vsb.engine.hydro.orders import Directions, heading_shares, most_exciting, order_groups, orders_of, own_headings
from vsb.engine.hydro.passive import Limit, PassiveFit, RadiationSamples, fit_lowest, sizes
from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.hydro.variables import PAIR
from vsb.engine.motion.forces import loss, stiffening
from vsb.engine.motion.frequency import LinearEquation, softest, unrestrained_motions
from vsb.engine.motion.port import LinearPto, Port
from vsb.engine.shell.device import MaxwellBranch
from vsb.errors import ConfigError, DatabaseError, StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

FASTEST = 1e9
"""Frequency [rad/s] above which no mode is sought."""
STILL = 1e-3
"""Share of the most a natural motion moves a port, at equal energy, below which it does not move it [-]."""
STIFFNESS = ("structural", "hydrostatic", "prestress", "gas", "mooring")
"""Stiffnesses of a database, by name."""
NO_TAKE_OFF = LinearPto(0.0)
_SAME_DIRECTION = 1e-6  # [rad]
_UNEVEN = 1e-6  # asymmetry of a matrix, relative to its largest entry, that is round-off
_UNRESTRAINED = 1e-9  # square of a growth rate, relative to the largest of a frequency, that is round-off
_BESIDE = 2  # frequencies to either side of a negative damping that are left out of a channel
_FEWEST = 4  # points of a spline
_KEPT = 32  # frequencies whose eigenvalues are kept
_TURNS = 12  # of a natural frequency and its shape, before bisection


@dataclass(frozen=True)
class LinearSystem:
    """Degrees of freedom about the mean position, from a hydro database; every design moves in a subspace of them."""

    database: xr.Dataset
    structural_damping: FloatArray  # (dof, dof) [N s/m]; that of Maxwell branches is beside it
    pto: LinearPto = NO_TAKE_OFF
    chamber: float = 0.0  # compliance between port and take-off, of the gas before a turbine [m^3/Pa]
    direction: float | Directions = 0.0  # the waves go to [rad]
    axisymmetric: bool = True  # each azimuthal order has one radiation channel; False: a body of any shape
    maxwell: tuple[MaxwellBranch, ...] = ()  # of the shell's material

    def __post_init__(self) -> None:
        """Refuse a body of any shape without inertia, with negative damping, or with a take-off without port."""
        if self.axisymmetric:
            return
        inertia = self.mass + self.added_mass_inf
        scale = np.sqrt(np.abs(np.diag(inertia)))
        if not (scale > 0).all() or np.linalg.eigvalsh(inertia / np.outer(scale, scale))[0] <= 0:
            still = [label for label, own in zip(self.labels, np.diag(inertia), strict=True) if own <= 0]
            raise ConfigError(
                f"body.mass: received {', '.join(still) or 'motions'} without inertia, the water's at infinite "
                "frequency included; needs a positive definite mass, or other degrees of freedom."
            )
        rates, shapes = np.linalg.eigh(self.structural_damping / np.outer(scale, scale))
        if rates[0] < -_UNEVEN * np.abs(rates).max():
            most = self.labels[int(np.abs(shapes[:, 0]).argmax())]
            raise ConfigError(
                f"body.damping: received a matrix that gives energy to {most}, by {-rates[0]:.3g}/s; needs one "
                "without a negative eigenvalue."
            )
        if self.pto.port is None and (np.any(self.pto.damping) or self.pto.stiffness):
            raise ConfigError("pto: received no port, needs the motion it takes off; see `combination`.")
        if self.pto.port is not None and self.pto.port.shape != (len(inertia),):
            raise ConfigError(f"pto: received a port of {self.pto.port.shape}, needs {(len(inertia),)}.")

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return tuple(map(str, self.database.influenced_dof.values))

    @property
    def orders(self) -> IntArray:
        """Azimuthal order of each degree of freedom of a shell of revolution, shape (dof,)."""
        return orders_of(self.database)

    @cached_property
    def spectrum(self) -> DampingSpectrum:
        """Radiation damping over frequency."""
        return DampingSpectrum(self.database.omega.values, self.database.radiation_damping.values)

    @cached_property
    def mass(self) -> FloatArray:
        """Inertia, shape (dof, dof) [kg]."""
        return np.asarray(self.database.inertia_matrix.values)

    @cached_property
    def added_mass_inf(self) -> FloatArray:
        """Added mass at infinite frequency, shape (dof, dof) [kg]."""
        return np.asarray(self.database.added_mass_inf.values)

    @cached_property
    def stiffness(self) -> FloatArray:
        """Sum of all stiffnesses, shape (dof, dof) [N/m]."""
        return np.asarray(sum(self.stiffness_parts.values()))

    @cached_property
    def stiffness_parts(self) -> dict[str, FloatArray]:
        """Stiffnesses by name, each shape (dof, dof) [N/m]; of a body `structural` is its own and the mooring's."""
        names = [name for name in STIFFNESS if f"{name}_stiffness" in self.database]
        return {name: np.asarray(self.database[f"{name}_stiffness"].values) for name in names}

    def pto_at(self, omega: FloatArray) -> LinearPto:
        """Return damper and spring of the take-off as the port feels them, through the chamber if there is one."""
        return self.pto.behind(self.chamber, omega) if self.chamber else self.pto

    def damping_at(self, omega: FloatArray) -> FloatArray:
        """Return structural and power take-off damping, shape ([omega,] dof, dof) [N s/m]."""
        return self.lossy_at(omega) + self.pto_at(omega).matrix(len(self.mass))

    def held_at(self, omega: FloatArray) -> FloatArray:
        """Return stiffness of the system and of the power take-off, shape ([omega,] dof, dof) [N/m]."""
        return self.stiffness + self.stiffening_at(omega) + self.pto_at(omega).spring(len(self.mass))

    def lossy_at(self, omega: FloatArray) -> FloatArray:
        """Return structural damping with that of a viscous material, shape ([omega,] dof, dof) [N s/m]."""
        if not self.maxwell:
            return self.structural_damping
        elastic = self.stiffness_parts["structural"]
        return self.structural_damping + loss(self.maxwell, omega)[..., None, None] * elastic

    def stiffening_at(self, omega: FloatArray) -> FloatArray | float:
        """Return what a viscous material adds to the stiffness in motion, shape ([omega,] dof, dof) [N/m]; 0 of none.

        Its branches are beside the elastic stiffness of the shape at rest.
        """
        if not self.maxwell:
            return 0.0
        return stiffening(self.maxwell, omega)[..., None, None] * self.stiffness_parts["structural"]

    @property
    def damping(self) -> FloatArray:
        """Damping at frequency zero, shape ([omega,] dof, dof) [N s/m]."""
        return self.damping_at(np.zeros(()))

    @property
    def held(self) -> FloatArray:
        """Stiffness at rest, shape (dof, dof) [N/m]."""
        return self.held_at(np.zeros(()))

    # coefficients ---------------------------------------------------------------------------------------------------

    @property
    def heading_index(self) -> int:
        """Place of the waves' direction among those of the database; 0 of a shell, whose orders answer all alike.

        Raises `DatabaseError` if it is not there.
        """
        if self.axisymmetric:
            return 0
        known, going = self.database.wave_direction.values, self.direction
        near = None if isinstance(going, Directions) else direction_index(known, going)
        if near is None:
            received = "several" if isinstance(going, Directions) else f"{np.degrees(going):g} degrees"
            raise DatabaseError(
                f"wave direction: received {received}, needs one of {', '.join(f'{d:g}' for d in np.degrees(known))}."
            )
        return near

    @cached_property
    def _channels(self) -> list["Channel"]:
        """The radiation channel of each azimuthal order."""
        going = own_headings(self.database)
        return [Channel(self.database, group, going[group[0]]) for group in order_groups(self.database).values()]

    @cached_property
    def _unit(self) -> CubicSpline:
        """Splines through unit vectors, of which those of all coefficients are sums: few values are asked for."""
        omega = self.database.omega.values
        return CubicSpline(omega, np.eye(len(omega)))

    def _between(self, name: str, omega: FloatArray) -> FloatArray | ComplexArray:
        """Cubic splines of a coefficient between the solved frequencies; a force on a shell is that of its waves."""
        of_shell = self.axisymmetric and name.endswith("_force")
        values = most_exciting(self.database, name) if of_shell else self.database[name].values
        return np.tensordot(self._unit(omega), values, 1)

    def check_band(self, omega: FloatArray) -> None:
        """Check that frequencies lie in the band solved; raises `DatabaseError`."""
        first, last = self.database.omega.values[[0, -1]]
        if omega.size and (omega.min() < first - 1e-9 or omega.max() > last + 1e-9):
            received, holds = f"{omega.min():.4g} to {omega.max():.4g} rad/s", f"{first:g} to {last:g} rad/s"
            raise DatabaseError(
                f"frequencies {received} are asked for, the database holds {holds}; raise hydro.omega_max, or use "
                f"waves below {2 * np.pi / first:.4g} s."
                if self.axisymmetric
                else f"frequencies: received {received}, the database holds {holds}; solve a wider band, or use waves "
                "within it."
            )

    def coefficients(self, omega: FloatArray) -> Coefficients:
        """Return the coefficients by cubic splines between solved frequencies.

        Raises `DatabaseError`: outside the band solved, or if a body's database does not hold the direction of the
        waves.

        Motions of one azimuthal order of a shell radiate through one channel, B = h X X^H (Haskind). With the damping
        computed this way the largest power, |V0|^2/(8 Re Y), is the same at every port, as exactly as h. The rest of
        the solver's damping is its error, which the check `rank_one` of the database judges, and which would exceed
        the channel where a port hardly radiates.
        """
        self.check_band(omega)
        added_mass = self._between("added_mass", omega).real
        if not self.axisymmetric:
            force = self._between("excitation_force", omega).astype(complex)
            return Coefficients(
                added_mass, self._between("radiation_damping", omega).real, force[:, self.heading_index]
            )
        force = self.most_exciting_force(omega)
        radiated = np.sum([channel.damping(omega, force) for channel in self._channels], axis=0)
        shares = self._shares(omega)
        return Coefficients(added_mass, radiated, np.asarray(force * shares, dtype=complex))

    def most_exciting_force(self, omega: FloatArray) -> ComplexArray:
        """Return the excitation of a shell by the waves that excite each motion most, shape (omega, dof) [N/m]."""
        return self._between("excitation_force", omega).astype(complex)

    def diffraction(self, omega: FloatArray) -> ComplexArray:
        """Return the diffraction force on a shell per wave amplitude, shape (omega, dof) [N/m]; in the band solved."""
        self.check_band(omega)
        force = self._between("diffraction_force", omega)
        return np.asarray(force * self._shares(omega), dtype=complex)

    def _shares(self, omega: FloatArray) -> FloatArray:
        """Factors of the excitation of a shell's orders in the waves' direction, shape (dof,) or (omega, dof)."""
        if isinstance(self.direction, Directions):
            return self.direction.shares(self.orders, omega)
        return heading_shares(self.orders, self.direction)

    def added_mass_at(self, omega: float) -> FloatArray:
        """Return the added mass at any frequency, in the band or not, shape (dof, dof) [kg].

        Of a shell by Kramers and Kronig; of a body constant below the band and approaching its limit as 1/omega^2
        above.
        """
        if self.axisymmetric:
            return np.asarray(self.added_mass_inf + self.spectrum.added_mass_difference(np.array([omega]))[0])
        first, last = self.database.omega.values[[0, -1]]
        inside = self._between("added_mass", np.clip(omega, first, last)).real
        return self.added_mass_inf + (inside - self.added_mass_inf) * min(1.0, float(last / omega)) ** 2

    @cached_property
    def samples(self) -> RadiationSamples:
        """Radiation at the frequencies of the database, each motion measured by its damping."""
        omega, damping = self.spectrum.omega, self.spectrum.damping
        size = sizes(omega, damping, np.diag(self.mass + self.added_mass_inf))
        return RadiationSamples(omega, self.database.added_mass.values, damping, self.added_mass_inf, size)

    def memory(self, tolerance: float, *, limit: Limit = "given") -> PassiveFit:
        """Return the passive radiation memory; see `vsb.engine.hydro.passive.fit_lowest`."""
        return fit_lowest(self.samples, tolerance, limit=limit)

    def in_motions(self, motions: FloatArray) -> "LinearSystem":
        """Return a shell of revolution that heaves in a few motions y, q = N y, projected before it is interpolated.

        N has shape (dof, motion). The factor of its radiation channel stays that of all degrees of freedom. Shapes of
        the database are left out.
        """
        ds = self.database
        force, damping = ds.excitation_force.values[:, 0], ds.radiation_damping.values
        channel = channelled(trace(damping), force)
        ds = ds.assign(radiation_damping=(ds.radiation_damping.dims, channel))
        matrices = ["added_mass", "radiation_damping", "added_mass_inf", "excitation_force", "inertia_matrix"]
        names = [*matrices, *(f"{name}_stiffness" for name in self.stiffness_parts)]
        labels = [f"Motion{i}" for i in range(1, motions.shape[1] + 1)]
        port = motions.T @ self.pto.direction(len(motions))
        return replace(
            self,
            database=transformed(ds[names], motions.T, labels),
            structural_damping=motions.T @ self.structural_damping @ motions,
            pto=replace(self.pto, port=port),
        )

    # motion ---------------------------------------------------------------------------------------------------------

    def rao(self, omega: FloatArray, motions: FloatArray) -> ComplexArray:
        """Return displacement per unit wave amplitude under the take-off, shape (omega, dof) [m/m].

        Of a design at frequencies omega [rad/s]; `motions` (dof, free) are those it allows.
        """
        equation = self.equation(omega)
        beside, dof = self.pto_at(omega), len(self.mass)
        loaded = replace(
            equation,
            damping=equation.damping + beside.matrix(dof),
            stiffness=equation.stiffness + beside.spring(dof),
        )
        return loaded.response(equation.water.excitation, motions)

    def equation(self, omega: FloatArray, known: FloatArray | None = None) -> LinearEquation:
        """Return its equation of motion at frequencies, without take-off; with coefficients of others, if given."""
        water = self.coefficients(omega if known is None else known)
        viscous = self.lossy_at(omega), self.stiffness, self.stiffening_at(omega)
        return LinearEquation(omega, water, self.mass, *viscous, self.chamber)

    def extended_equation(self, omega: FloatArray) -> LinearEquation:
        """Return `equation` at any frequencies: outside the band solved with the coefficients of its nearest end."""
        first, last = self.database.omega.values[[0, -1]]
        return self.equation(omega, np.clip(omega, first, last))

    def port(self, omega: FloatArray, motions: FloatArray, direction: FloatArray) -> Port:
        """Return what a take-off sees of a design; see `vsb.engine.motion.frequency.LinearEquation.port`."""
        return self.equation(omega).port(motions, direction)

    def extended_port(self, omega: FloatArray, motions: FloatArray, direction: FloatArray) -> Port:
        """Return `port` at any frequency: outside the band solved with the coefficients of its nearest end."""
        return self.extended_equation(omega).port(motions, direction)

    def absorbed_power(self, omega: FloatArray, rao: ComplexArray) -> FloatArray:
        """Return the mean absorbed power per squared wave amplitude, c w^2 |b.q|^2/2, shape (omega,) [W/m^2]."""
        if self.pto.several:
            lossy = self.pto.matrix(len(self.mass))
            return np.asarray(0.5 * omega**2 * np.real(np.einsum("wi,ij,wj->w", rao.conj(), lossy, rao)))
        stroke = rao @ self.pto.direction(len(self.mass))
        return np.asarray(0.5 * self.pto_at(omega).damping * omega**2 * np.abs(stroke) ** 2)

    def unrestrained(self, stiffness: FloatArray, motions: FloatArray) -> FloatArray:
        """Return the motions without restoring force, in those a design allows, shape (free, unrestrained).

        Of a shell these can be surge, sway and yaw without mooring; water and elasticity hold the others. `stiffness`
        is that in the motions a design allows (dof, free), shape (free, free) [N/m]. Raises `StabilityError` if the
        system is unstable at rest.
        """
        if self.axisymmetric:
            loose = unrestrained_motions(stiffness, self.labels, motions)
            least, _ = softest(stiffness, loose)
            if least <= 0.0:
                raise StabilityError(
                    f"the buoy gives way at rest: received a stiffness of {least:.4g} N/m, needs more than 0; "
                    "raise device.young_modulus, device.thickness or device.internal_pressure"
                )
            return loose
        inertia = self.mass + self.added_mass_inf
        values, shapes = eigh(stiffness, motions.T @ inertia @ motions)
        size = _UNRESTRAINED * max(abs(values[-1]), 1e-300)
        if values[0] < -size:
            most = np.abs(motions @ shapes[:, 0]) * np.sqrt(np.diag(inertia))
            raise StabilityError(
                f"the body is statically unstable: received a negative stiffness of {self.labels[int(most.argmax())]}, "
                f"growing by {np.sqrt(-values[0]):.3g}/s; needs a lower centre of mass, a mooring, or this motion held."
            )
        return np.asarray(shapes[:, values <= size])

    def natural_modes(
        self, motions: FloatArray, highest: float = np.inf, port: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return wet natural frequencies [rad/s] and damping ratios [-] with the take-off, ascending.

        Raises `StabilityError` if the system is unstable at rest.

        Parameters
        ----------
        motions : ndarray, shape (dof, free)
        highest : float
            Frequencies above are left out but for the first [rad/s].
        port : ndarray, shape (dof,) or (dof, port), optional
            Motions at equal energy that move it by less than `STILL` of the most are left out.

        Notes
        -----
        w_i solves 1 = w^2 mu_i(w), the i-th eigenvalue, largest first, of M + A(w) against K + C. The stiffness is
        positive definite; inertia need not be, as the added mass of a nearly immersed buoy is negative at some
        frequencies. Unrestrained motions have no frequency; the others carry them along without force. The ratio counts
        radiation, structure and power take-off on the mode's diagonal; a damper behind a chamber acts as it does at
        w_i.
        """
        loose = self.unrestrained(motions.T @ self.held @ motions, motions)
        held = null_space(loose.T) if loose.size else np.eye(motions.shape[1])
        problem = _WetModes(self, motions, loose, held)
        count = held.shape[1]
        if highest < np.inf:
            count = min(int(np.count_nonzero(problem.eigen(highest)[0] > 1.0)) + 1, count)
        modes = []
        for i in range(count):
            w, damping, shape = problem.mode(i)
            modes.append((w, damping, 1.0 if port is None else w * float(np.linalg.norm(port.T @ shape))))
        frequency, ratio, moves = np.array(modes).reshape(-1, 3).T
        frequency, ratio = (values[moves > STILL * moves.max(initial=0.0)] for values in (frequency, ratio))
        order = np.argsort(frequency)
        return frequency[order], ratio[order]


@dataclass(frozen=True)
class _WetModes:
    """The eigenvalue problem of `LinearSystem.natural_modes` in the motions of a design, projected once."""

    system: LinearSystem
    motions: FloatArray  # (dof, free)
    loose: FloatArray  # unrestrained (free, loose)
    held: FloatArray  # the others (free, held)
    _known: dict[float, tuple[FloatArray, FloatArray]] = field(default_factory=dict)

    @cached_property
    def _mass(self) -> FloatArray:
        """Inertia with the added mass at infinite frequency, (free, free) [kg]."""
        return self._projected(self.system.mass + self.system.added_mass_inf)

    @cached_property
    def _damping(self) -> FloatArray:
        """Radiation damping at the solved frequencies, one row each (omega, free x free) [kg/s]."""
        damping = self.system.spectrum.damping
        return self._projected(damping).reshape(len(damping), -1)

    def _projected(self, matrix: FloatArray) -> FloatArray:
        """A matrix in the motions allowed."""
        return np.asarray(self.motions.T @ matrix @ self.motions)

    @cached_property
    def _at_rest(self) -> FloatArray:
        """Stiffness at rest, (free, free) [N/m]."""
        return self._projected(self.system.held)

    def _stiffness(self, omega: float) -> FloatArray:
        """Stiffness at a frequency, (free, free) [N/m]; of gas and viscous materials it depends on it."""
        if not (self.system.chamber or self.system.maxwell):
            return self._at_rest
        return self._projected(self.system.held_at(np.asarray(omega)))

    def eigen(self, omega: float) -> tuple[FloatArray, FloatArray]:
        """Return all w^2 mu_i, largest first, and their shapes of unit stiffness (free, held)."""
        if omega not in self._known:
            if len(self._known) == _KEPT:
                self._known.clear()
            if self.system.axisymmetric:
                shares = self.system.spectrum.added_mass_shares(np.array([omega]))[0]
                inertia = self._mass + (shares @ self._damping).reshape(self._mass.shape)
            else:
                inertia = self._projected(self.system.mass + self.system.added_mass_at(omega))
            loose, held = self.loose, self.held
            along = held - loose @ np.linalg.solve(loose.T @ inertia @ loose, loose.T @ inertia @ held)
            values, vectors = eigh(along.T @ inertia @ along, held.T @ self._stiffness(omega) @ held)
            self._known[omega] = omega**2 * values[::-1], (along @ vectors)[:, ::-1]
        return self._known[omega]

    def mode(self, i: int) -> tuple[float, float, FloatArray]:
        """Return frequency [rad/s], damping ratio [-] and shape of unit stiffness (dof,) of a natural mode."""
        omega = self.frequency(i)
        shape = self.eigen(omega)[1][:, i]
        still = np.asarray(self.motions @ shape)
        radiated = self.system.spectrum.shares(np.array([omega]))[0] @ self._damping @ np.outer(shape, shape).ravel()
        return omega, float(omega * (radiated + still @ self.system.damping_at(np.asarray(omega)) @ still) / 2), still

    def frequency(self, i: int) -> float:
        """Return the i-th natural frequency [rad/s]: of w^2 mu_i - 1, one root.

        By the root of its Rayleigh quotient, whose error is the square of that of the shape, until both agree; where
        shapes cross, by bisection of the eigenvalue itself.
        """
        upper = 1.0
        while self.eigen(upper)[0][i] <= 1.0:
            upper *= 2
            if upper > FASTEST:
                raise DatabaseError("added mass at infinite frequency takes a mode's inertia; lower hydro.tolerance")
        omega = upper
        for _ in range(_TURNS if self.system.axisymmetric and not self.loose.size else 0):
            before, omega = omega, self._rayleigh(self.eigen(omega)[1][:, i], upper)
            if abs(omega - before) < 1e-10:
                return before  # whose shape is known
        return float(brentq(lambda w: self.eigen(w)[0][i] - 1.0, 1e-3, upper, xtol=1e-10))

    def _rayleigh(self, shape: FloatArray, upper: float) -> float:
        """Frequency of a motion in a shape (free,) alone [rad/s]; `upper` if its inertia leaves it none below."""
        mass, damping = shape @ self._mass @ shape, self._damping @ np.outer(shape, shape).ravel()

        def beyond(omega: float) -> float:
            shares = self.system.spectrum.added_mass_shares(np.array([omega]))[0]
            stiffness = shape @ self._stiffness(omega) @ shape
            return float(omega**2 * (mass + shares @ damping) - stiffness)

        return float(brentq(beyond, 1e-3, upper, xtol=1e-11)) if beyond(1e-3) < 0 < beyond(upper) else upper


def direction_index(known: FloatArray, direction: float) -> int | None:
    """Return the place of a wave direction [rad] among those known, modulo full turns; None if it is not there."""
    apart = np.abs((known - direction + np.pi) % (2 * np.pi) - np.pi)
    near = int(np.argmin(apart))
    return near if apart[near] <= _SAME_DIRECTION else None


# radiation channels of a shell of revolution ------------------------------------------------------------------------


class Channel:
    """Damping h X X^H of motions of one azimuthal order (Haskind), with h = tr B/|X|^2 between solved frequencies.

    h leaves zero with omega^3 in deep water, with omega in shallow: divided by that power it is smooth. Where hardly
    any wave is made, B and X are the solver's error: next to a damping below zero h is interpolated from the
    frequencies around.
    """

    def __init__(self, database: xr.Dataset, group: IntArray, heading: int = 0) -> None:
        """Interpolate h of the motions `group`, from X in waves of the `heading`-th direction, which excite them."""
        omega, damping = database.omega.values, database.radiation_damping.values[:, group[:, None], group]
        factor = channel_factor(trace(damping), database.excitation_force.values[:, heading, group])
        known = np.convolve(factor <= 0, np.ones(2 * _BESIDE + 1))[_BESIDE:-_BESIDE] == 0
        if known.sum() >= _FEWEST:
            omega, factor = omega[known], factor[known]
        slope = np.log(factor[1] / factor[0]) / np.log(omega[1] / omega[0])
        self.group, self.power = group, int(np.clip(np.rint(slope), 1, 3))
        self.factor = CubicSpline(omega, factor / omega**self.power)

    def damping(self, omega: FloatArray, excitation: ComplexArray) -> FloatArray:
        """Return the damping from the excitation (omega, dof), zero of other orders, shape (omega, dof, dof)."""
        out = np.zeros((len(omega), excitation.shape[1], excitation.shape[1]))
        own = (self.factor(omega) * omega**self.power)[:, None, None] * one_channel(excitation[:, self.group])
        out[:, self.group[:, None], self.group] = own
        return out


def one_channel(excitation: ComplexArray) -> FloatArray:
    """Return Re X X^H of excitation forces (omega, dof), shape (omega, dof, dof)."""
    real, imaginary = excitation.real, excitation.imag
    found = real[:, :, None] * real[:, None, :]
    found += imaginary[:, :, None] * imaginary[:, None, :]
    return np.asarray(found)


def trace(damping: FloatArray) -> FloatArray:
    """Return tr B of damping (omega, dof, dof), shape (omega,)."""
    return np.asarray(np.einsum("wii->w", damping))


def channel_factor(lost: FloatArray, excitation: ComplexArray) -> FloatArray:
    """Return h = tr B/|X|^2 of the trace of the damping (omega,) and excitation (omega, dof), shape (omega,)."""
    return np.asarray(lost / (np.abs(excitation) ** 2).sum(axis=1))


def channelled(lost: FloatArray, excitation: ComplexArray) -> FloatArray:
    """Return the part h Re X X^H of a damping, (omega, dof, dof), from its trace: the rest is the solver's error."""
    found = one_channel(excitation)
    found *= channel_factor(lost, excitation)[:, None, None]
    return found


# how systems are made -----------------------------------------------------------------------------------------------


def with_open_chamber(buoy: LinearSystem, direction: FloatArray) -> LinearSystem:
    """Return the buoy whose trapped gas stands between the shell and a take-off of its volume, b (dof,) [m^2].

    The gas resists volume alone, K = b b^T/C. Once it can leave through the take-off it no longer stiffens the shell:
    the compliances of port and gas add up (`Port.behind`).
    """
    gas = buoy.stiffness_parts.get("gas")
    if gas is None:
        return buoy
    return replace(buoy, database=buoy.database.drop_vars("gas_stiffness"), chamber=gas_compliance(gas, direction))


def gas_compliance(stiffness: FloatArray, direction: FloatArray) -> float:
    """Return C of a trapped gas from its stiffness b b^T/C [m^3/Pa]."""
    return float((direction @ direction) ** 2 / (direction @ stiffness @ direction))


def linear_body(
    database: xr.Dataset,
    dofs: Sequence[str] | None = None,
    *,
    mass: FloatArray | None = None,
    damping: FloatArray | None = None,
    stiffness: FloatArray | None = None,
) -> LinearSystem:
    """Return a body of any shape from a hydro database.

    Raises `ConfigError` or `DatabaseError` if something is missing or makes no sense.

    Parameters
    ----------
    dofs : sequence of str, optional
        Degrees of freedom in the order wanted, the others held; all of them.
    mass, damping, stiffness : ndarray, shape (dof, dof), optional
        Of the dry body, in the degrees of freedom wanted; of the database. Without structure: no damping, no stiffness.
    """
    labels = [str(label) for label in database.influenced_dof.values]
    wanted = labels if dofs is None else [str(label) for label in dofs]
    if not wanted or len(set(wanted)) < len(wanted) or not set(wanted) <= set(labels):
        raise ConfigError(
            f"degrees of freedom: received {', '.join(wanted) or 'none'}; needs some of {', '.join(labels)}."
        )
    index = [labels.index(label) for label in wanted]
    chosen = database.isel(influenced_dof=index, radiating_dof=index)
    chosen = with_added_mass_inf(chosen.sel(omega=chosen.omega > 0))
    given = (mass, damping, stiffness)
    dry = None if all(matrix is not None for matrix in given) else structure(chosen, "database", damping)
    if mass is None and dry is None:
        raise ConfigError("mass: received none, and the database holds no structure; needs the mass matrix.")
    none = np.zeros((len(index), len(index)))
    own = dry or Structure(none, none, none)
    chosen_mass, chosen_damping, chosen_stiffness = (
        held if matrix is None else np.asarray(matrix, dtype=float) for held, matrix in zip(own, given, strict=True)
    )
    for name, matrix in (("mass", chosen_mass), ("damping", chosen_damping), ("stiffness", chosen_stiffness)):
        if matrix.shape != none.shape or not np.isfinite(matrix).all():
            raise ConfigError(f"{name}: received shape {matrix.shape}, needs finite numbers, shape {none.shape}.")
        if np.abs(matrix - matrix.T).max() > _UNEVEN * np.abs(matrix).max():
            raise ConfigError(f"{name}: received a matrix that is not symmetric, needs a symmetric one.")
    complete = chosen.drop_vars([name for name in DRY if name in chosen]).assign(
        inertia_matrix=(PAIR, chosen_mass), structural_stiffness=(PAIR, chosen_stiffness)
    )
    return LinearSystem(complete, chosen_damping, axisymmetric=False)


def with_added_mass_inf(ds: xr.Dataset) -> xr.Dataset:
    """Return a database with the added mass at infinite frequency, by Kramers and Kronig if it had none: `history`."""
    if "added_mass_inf" in ds:
        return ds
    omega = ds.omega.values
    change = DampingSpectrum(omega, ds.radiation_damping.values).added_mass_difference(omega)
    limit = np.median(ds.added_mass.values - change, axis=0)
    return with_history(ds.assign(added_mass_inf=(PAIR, limit)), "added mass at infinite frequency from damping")
