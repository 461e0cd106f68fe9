"""Floating elastic hemisphere in deep water by Ursell's and Havelock's multipoles: an independent reference.

Nothing of the package is imported. Water: wave source and wave-free potentials at the centre of a half-submerged
sphere (Hulme 1982, J. Fluid Mech. 121, 443-463), Galerkin on the even Legendre polynomials of the hemisphere.
Shell: Rayleigh-Ritz in radial P_n(cos phi) and meridional dP_n(cos phi)/dphi with membrane and bending energy, whose
integrals have closed forms. Rest: undeformed, no internal pressure, mass of the displaced water. One heave damper.

Phasors exp(-i omega t), SI units, colatitude phi from the top pole; the polar angle of the water, theta = pi - phi,
is measured from the downward vertical, x = cos theta in [0, 1].
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.linalg import null_space

GRAVITY = 9.81


def legendre(x: np.ndarray, degree: int) -> np.ndarray:
    """P_n(x) for n = 0..degree, shape (degree + 1, x.size)."""
    p = np.ones((degree + 1, x.size))
    if degree:
        p[1] = x
    for n in range(1, degree):
        p[n + 1] = ((2 * n + 1) * x * p[n] - n * p[n - 1]) / (n + 1)
    return p


def legendre_by_degree(x: np.ndarray, degree: int) -> np.ndarray:
    """dP_nu(x)/dnu at nu = 0..degree: Bonnet's recurrence differentiated by its degree."""
    p = legendre(x, degree + 1)
    d = np.zeros((degree + 1, x.size))
    log = np.log((1 + x) / 2)
    d[0] = log
    if degree:
        d[1] = x * log + x - 1
    for n in range(1, degree):
        d[n + 1] = (2 * x * p[n] + (2 * n + 1) * x * d[n] - p[n - 1] - n * d[n - 1] - p[n + 1]) / (n + 1)
    return d


def wave_source(x: np.ndarray, ka: float, terms: int = 80) -> tuple[np.ndarray, np.ndarray]:
    """Potential of the free-surface source and its radial derivative on r = 1 (lengths in radii).

    1/r + K { -sum_m (-K r)^m/m! [(gamma + ln K r - H_m - i pi) P_m + dP_nu/dnu at m] }: the axis values
    -exp(-K y) Ei(K y) of int exp(-k y) J0(k R)/(k - K) dk, continued off the axis as a harmonic function,
    and the outgoing wave i pi exp(-K y) J0(K R).
    """
    m = np.arange(terms)
    factor = np.cumprod(np.concatenate([[1.0], -ka / m[1:]]))
    harmonic = np.concatenate([[0.0], np.cumsum(1 / m[1:])])
    p, d = legendre(x, terms - 1), legendre_by_degree(x, terms - 1)
    bracket = (np.euler_gamma + np.log(ka) - harmonic - 1j * np.pi)[:, None] * p + d
    value = 1 - ka * factor @ bracket
    slope = -1 - ka * factor @ (m[:, None] * bracket + p)
    return value, slope


@dataclass(frozen=True)
class Radiation:
    """Normal velocities P_0..P_N(cos phi): added mass/(rho a^3), damping/(rho omega a^3), far-field amplitudes."""

    added_mass: np.ndarray
    damping: np.ndarray
    amplitude: np.ndarray


@lru_cache(maxsize=512)
def radiation(ka: float, degree: int, multipoles: int = 0) -> Radiation:
    """Radiation of the hemisphere at wavenumber times radius `ka` for all normal velocities up to `degree`."""
    size = multipoles or max(160, 3 * degree)
    x, weight = leggauss(2 * size + 40)
    x, weight = (x + 1) / 2, weight / 2
    p = legendre(x, max(2 * size, degree))
    n = np.arange(1, size)
    source, source_slope = wave_source(x, ka)
    value = np.vstack([source, p[2 * n] + ka / (2 * n)[:, None] * p[2 * n - 1]])
    slope = np.vstack([source_slope, -(2 * n + 1)[:, None] * p[2 * n] - ka * p[2 * n - 1]])
    test = p[0 : 2 * size : 2] * np.sqrt(4 * np.arange(size) + 1)[:, None]
    sign = (-1.0) ** np.arange(degree + 1)
    velocity = sign[:, None] * p[: degree + 1]
    strength = np.linalg.solve((test * weight) @ slope.T, (test * weight) @ velocity.T)
    potential = value.T @ strength
    product = -2 * np.pi * (velocity * weight) @ potential
    return Radiation(product.real, product.imag, strength[0])


@dataclass(frozen=True)
class Shell:
    """Spherical shell, half submerged; the seed's figures. Without a `mass` [kg] that of the displaced water."""

    radius: float = 2.0
    thickness: float = 0.01
    young_modulus: float = 10.0e6
    poisson_ratio: float = 0.3
    density: float = 2700.0
    beta: float = 1.0e-3
    water: float = 1025.0
    mass: float = 0.0

    @property
    def total_mass(self) -> float:
        return self.mass or self.water * 2 / 3 * np.pi * self.radius**3

    def stiffness(self, n: int, bending: bool = True) -> np.ndarray:
        """Second derivative of the elastic energy by the amplitudes of (radial P_n, meridional dP_n/dphi), N/m."""
        r, h, e, nu = self.radius, self.thickness, self.young_modulus, self.poisson_ratio
        lam, norm = n * (n + 1), 2 / (2 * n + 1)
        trace = np.array([2.0, -lam])
        membrane = np.outer(trace, trace) - 2 * (1 - nu) * np.array([[1, -lam / 2], [-lam / 2, lam / 2]])
        turn = np.array([[1.0, -1.0], [-1.0, 1.0]]) * (lam**2 - (1 - nu) * lam)
        stretching, flexural = e * h / (1 - nu**2), e * h**3 / (12 * (1 - nu**2)) / r**2
        return 2 * np.pi * norm * (stretching * membrane + bending * flexural * turn)

    def inertia(self, n: int) -> np.ndarray:
        """Mass of (radial P_n, meridional dP_n/dphi), kg."""
        surface = 2 * np.pi * self.radius**2 * self.density * self.thickness
        return surface * 2 / (2 * n + 1) * np.diag([1.0, n * (n + 1)])

    def modes(self, degree: int, basis: str) -> np.ndarray:
        """Columns: heave and shell motions in coordinates (radial 0..N, meridional 0..N).

        Degree one gives the combination whose momentum is zero; `membrane` keeps the upper branch of the membrane
        energy alone, one motion a degree.
        """
        size = degree + 1
        columns = []

        def add(n: int, radial: float, meridional: float) -> None:
            column = np.zeros(2 * size)
            column[n], column[size + n] = radial, meridional
            columns.append(column)

        add(1, 1.0, 1.0)
        for n in range(size):
            if n == 0:
                add(0, 1.0, 0.0)
            elif n == 1:
                add(1, 2.0, -1.0)
            elif basis == "full":
                add(n, 1.0, 0.0)
                add(n, 0.0, 1.0)
            else:
                m, k = self.inertia(n), self.stiffness(n, bending=False)
                values, vectors = np.linalg.eig(np.linalg.solve(m, k))
                add(n, *vectors[:, np.argmax(values.real)].real)
        return np.array(columns).T

    def natural_frequencies(self, degree: int, bending: bool = True) -> np.ndarray:
        """Dry frequencies, rad/s, of one degree: lower and upper branch (n = 0: the breathing one alone)."""
        keep = slice(0, 1) if degree == 0 else slice(0, 2)
        m, k = self.inertia(degree)[keep, keep], self.stiffness(degree, bending)[keep, keep]
        return np.sqrt(np.maximum(np.sort(np.linalg.eigvals(np.linalg.solve(m, k)).real), 0.0))

    def hydrostatics(self, degree: int) -> np.ndarray:
        """-dQ/dq of the follower pressure on the wet half, in coordinates (radial 0..N, meridional 0..N), N/m.

        Q_j = -2 pi int p x (-zeta' X_j + x' Z_j) dphi on the displaced meridian, p = -rho g z: zero at the waterline.
        """
        t, weight = leggauss(4 * degree + 60)
        phi, weight = np.pi * (3 + t) / 4, np.pi / 4 * weight
        s, c = np.sin(phi), np.cos(phi)
        p, lam = legendre(c, degree), np.arange(degree + 1) * (np.arange(degree + 1) + 1)
        first = np.zeros_like(p)
        first[1:] = np.arange(1, degree + 1)[:, None] * (c * p[1:] - p[:-1]) / s
        second = -lam[:, None] * p - c / s * first
        zero = np.zeros_like(p)
        v, dv = np.vstack([p, zero]), np.vstack([first, zero])
        u, du = np.vstack([zero, first]), np.vstack([zero, second])
        x_, z_ = v * s + u * c, v * c - u * s
        dx, dz = dv * s + v * c + du * c - u * s, dv * c - v * s - du * s - u * c
        r, rho_g = self.radius, self.water * GRAVITY
        normal = r * s * x_ + r * c * z_
        pressure = -rho_g * r * c
        stiff = -rho_g * ((normal * weight * r * s) @ z_.T) + (normal * weight * pressure) @ x_.T
        stiff += (z_ * weight * pressure * r * s) @ dx.T - (x_ * weight * pressure * r * s) @ dz.T
        return 2 * np.pi * stiff

    def equator(self, degree: int) -> np.ndarray:
        """Rows: radial and meridional displacement at the equator in the same coordinates."""
        p = legendre(np.zeros(1), degree)[:, 0]
        slope = np.zeros(degree + 1)
        slope[1:] = -np.arange(1, degree + 1) * p[:-1]
        zero = np.zeros(degree + 1)
        return np.array([np.concatenate([p, zero]), np.concatenate([zero, slope])])


@dataclass(frozen=True)
class Port:
    """Heave port of one design in a regular wave of unit amplitude."""

    impedance: complex
    velocity: complex
    limit: float

    def power(self, damping: float | None = None) -> float:
        """Mean power of a heave damper, W/m^2; without a value of its best, |Z|."""
        c = abs(self.impedance) if damping is None else damping
        return 0.5 * c * abs(self.impedance * self.velocity) ** 2 / abs(self.impedance + c) ** 2


@dataclass(frozen=True)
class Motion:
    """The equation of motion at one frequency, -w^2 (M + A) - i w (B + D) + K, over heave and shell motions."""

    omega: float
    modes: np.ndarray  # in coordinates (radial 0..N, meridional 0..N) (coordinate, motion)
    dynamic: np.ndarray  # (motion, motion)
    force: np.ndarray  # of a wave of unit amplitude (motion,)

    def network(self, ports: np.ndarray, free: slice = slice(None)) -> tuple[np.ndarray, np.ndarray]:
        """Free velocities and admittances of ports, the columns over the motions, of which some may be held."""
        dynamic, b = self.dynamic[free, free], ports[free]
        scaling = 1 / np.sqrt(np.abs(np.diag(dynamic)))
        right = np.column_stack([self.force[free], b]) * scaling[:, None]
        solved = scaling[:, None] * np.linalg.solve(scaling[:, None] * dynamic * scaling, right)
        answer = -1j * self.omega * b.T @ solved
        return answer[:, 0], answer[:, 1:]


def motion(shell: Shell, period: float, degree: int, basis: str = "full", clamp: bool = False) -> Motion:
    """Heave and shell in waves of a period. A `clamp` holds the shell at the equator to the frame."""
    omega = 2 * np.pi / period
    a, rho = shell.radius, shell.water
    water = radiation(omega**2 / GRAVITY * a, degree)
    size = degree + 1
    added, damping, excitation = np.zeros((2 * size, 2 * size)), np.zeros((2 * size, 2 * size)), np.zeros(2 * size) * 0j
    added[:size, :size] = water.added_mass * rho * a**3
    damping[:size, :size] = water.damping * rho * omega * a**3
    excitation[:size] = 2 * np.pi * rho * GRAVITY * a**2 * water.amplitude  # Haskind; Green's theorem about the source
    modes = shell.modes(degree, basis)
    if clamp:
        hold = shell.equator(degree) @ modes[:, 1:]
        rows = hold / np.linalg.norm(hold, axis=1).max()
        modes = np.column_stack([modes[:, 0], modes[:, 1:] @ null_space(rows)])
    mass, elastic = np.zeros((2 * size, 2 * size)), np.zeros((2 * size, 2 * size))
    for n in range(size):
        pair = np.ix_([n, size + n], [n, size + n])
        mass[pair] = shell.inertia(n)
        elastic[pair] = shell.stiffness(n, bending=basis == "full")
    mass, elastic = modes.T @ mass @ modes, modes.T @ elastic @ modes
    mass[0, 0] = shell.total_mass
    added, damping = modes.T @ added @ modes, modes.T @ damping @ modes
    still = modes.T @ shell.hydrostatics(degree) @ modes
    loss = shell.beta * elastic
    dynamic = -(omega**2) * (mass + added) - 1j * omega * (damping + loss) + elastic + still
    return Motion(omega, modes, dynamic, modes.T @ excitation)


def ports(shell: Shell, period: float, degree: int, basis: str = "full", clamp: bool = False) -> tuple[Port, Port]:
    """Rigid and flexible buoy, whose heave is the port's."""
    found = motion(shell, period, degree, basis, clamp)
    wavenumber = found.omega**2 / GRAVITY
    limit = 0.5 * shell.water * GRAVITY * found.omega / (2 * wavenumber) / wavenumber
    heave = np.eye(len(found.force), 1)

    def port(count: int) -> Port:
        velocity, admittance = found.network(heave, slice(count))
        return Port(1 / admittance[0, 0], velocity[0], limit)

    return port(1), port(len(found.force))


def strain_port(shell: Shell, degree: int, kind: str, belt: tuple[float, float] = (0.0, 180.0)) -> np.ndarray:
    """Change of area (m), or mean hoop strain of a belt (1/m), by the coordinates (radial 0..N, meridional 0..N).

    Strains of a sphere: hoop (v + u cot phi)/r, meridional (v + du/dphi)/r, which with the surface element
    2 pi r^2 sin phi dphi give an area 8 pi r per metre of breathing, of all other degrees none.
    """
    size = degree + 1
    found = np.zeros(2 * size)
    if kind == "area":
        found[0] = 8 * np.pi * shell.radius
        return found
    t, weight = leggauss(4 * degree + 40)
    low, high = np.deg2rad(belt)
    phi, weight = (low + high) / 2 + (high - low) / 2 * t, weight * (high - low) / 2
    s, c = np.sin(phi), np.cos(phi)
    p = legendre(c, degree)
    slope = np.zeros_like(p)
    slope[1:] = np.arange(1, size)[:, None] * (c * p[1:] - p[:-1]) / s
    whole = shell.radius * (weight @ s)
    found[:size], found[size:] = p @ (weight * s) / whole, slope @ (weight * c) / whole
    return found


def gain(shell: Shell, period: float, degree: int, basis: str = "full", clamp: bool = False) -> float:
    """Gain over the rigid buoy, per cent, each at its own best heave damper."""
    rigid, flexible = ports(shell, period, degree, basis, clamp)
    return 100 * (flexible.power() / rigid.power() - 1)


def table(shell: Shell) -> str:
    """Gains of the seed's buoy by basis, degree, clamp and period, as text."""
    periods = (2.5, 3.0, 3.06, 3.3, 5.0, 8.0)
    lines = [f"gain over the rigid buoy [%], each at its own damper c = |Z|; undeformed, deep water, {shell}"]
    lines.append(
        f"{'basis, degree':14s}" + "".join(f"{t:>9.2f}" for t in periods) + "   | clamped at 90 deg, same periods"
    )
    for basis, degree in [("membrane", 6), *(("full", n) for n in (6, 9, 14, 16, 20, 24, 30, 40, 42, 48, 60, 80, 90))]:
        rows = ["".join(f"{gain(shell, t, degree, basis, clamp):9.3f}" for t in periods) for clamp in (False, True)]
        lines.append(f"{basis + ' ' + str(degree):14s}" + rows[0] + "   |" + rows[1])
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(Shell()), table(Shell(mass=17170.0)), sep="\n\n")
