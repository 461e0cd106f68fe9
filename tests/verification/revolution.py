"""Elastic shells of revolution, half immersed in deep water: spheroids by multipoles and an own Ritz solution.

Nothing of the package is imported. Points of the meridian are named by an angle phi in [0, pi] from the top; a shell
displaces them by v (sin phi, cos phi) + u (cos phi, -sin phi), v and u sums of P_n(cos phi) and dP_n/dphi. Strains and
changes of curvature are those of thin shells of revolution; water by least squares of the multipoles of `multipoles.py`
on the meridian, which converge for spheroids whose foci lie within the largest sphere about the centre.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.linalg import null_space
from verification.multipoles import GRAVITY, Port, legendre, legendre_by_degree


def slopes(x: np.ndarray, p: np.ndarray) -> np.ndarray:
    """dP_n/dx by the recurrence differentiated."""
    d = np.zeros_like(p)
    d[1] = 1
    for n in range(1, len(p) - 1):
        d[n + 1] = ((2 * n + 1) * (p[n] + x * d[n]) - n * d[n - 1]) / (n + 1)
    return d


def slopes_by_degree(x: np.ndarray, p: np.ndarray, dp: np.ndarray, d: np.ndarray) -> np.ndarray:
    """d/dx of dP_nu/dnu at whole degrees, likewise."""
    s = np.zeros_like(d)
    s[0], s[1] = 1 / (1 + x), np.log((1 + x) / 2) + x / (1 + x) + 1
    for n in range(1, len(d) - 1):
        rest = 2 * (p[n] + x * dp[n]) - dp[n - 1] - dp[n + 1]
        s[n + 1] = (rest + (2 * n + 1) * (d[n] + x * s[n]) - n * s[n - 1]) / (n + 1)
    return s


@dataclass(frozen=True)
class Spheroid:
    """A spheroidal shell of equatorial radius and height, vented, with a heave damper. Half its volume is immersed."""

    radius: float
    height: float
    young_modulus: float
    degree: int
    thickness: float = 0.01
    poisson_ratio: float = 0.3
    density: float = 2700.0
    beta: float = 1.0e-3
    water: float = 1025.0
    clamp: float | None = None  # degrees from the top, where the shell cannot move against the ballast

    @property
    def mass(self) -> float:
        """Of the displaced water, kg."""
        return self.water * 2 / 3 * np.pi * self.radius**2 * self.height / 2

    def meridian(self, phi: np.ndarray) -> tuple[np.ndarray, ...]:
        """x, z, their first and their second derivatives."""
        a, b = self.radius, self.height / 2
        s, c = np.sin(phi), np.cos(phi)
        return a * s, b * c, a * c, -b * s, -a * s, -b * c

    def shapes(self, phi: np.ndarray) -> tuple[np.ndarray, ...]:
        """X, Z of all displacements (radial 0..N, meridional 1..N) with first and second derivatives, (shape, point)."""
        s, c = np.sin(phi), np.cos(phi)
        p = legendre(c, self.degree)
        n = np.arange(self.degree + 1)[:, None]
        lam = n * (n + 1)
        p1 = -s * slopes(c, p)
        p2 = -lam * p - c / s * p1
        p3 = -lam * p1 + p1 / s**2 - c / s * p2
        v, u = (np.vstack([q, 0 * q[1:]]) for q in (p, p1, p2)), (np.vstack([0 * p, q[1:]]) for q in (p1, p2, p3))
        (v, v1, v2), (u, u1, u2) = v, u
        x, z = v * s + u * c, v * c - u * s
        x1, z1 = (v1 - u) * s + (u1 + v) * c, (v1 - u) * c - (u1 + v) * s
        b, d, b1, d1 = v1 - u, u1 + v, v2 - u1, u2 + v1
        x2, z2 = (b1 - d) * s + (d1 + b) * c, (b1 - d) * c - (d1 + b) * s
        return x, z, x1, z1, x2, z2

    @cached_property
    def structure(self) -> tuple[np.ndarray, np.ndarray]:
        """Mass [kg] and elastic stiffness [N/m] of the displacements."""
        t, weight = leggauss(8 * self.degree + 80)
        phi, weight = np.pi * (1 + t) / 2, np.pi / 2 * weight
        r, _, r1, z1, r2, z2 = self.meridian(phi)
        x, z, dx, dz, ddx, ddz = self.shapes(phi)
        a = np.hypot(r1, z1)
        tr, tz = r1 / a, z1 / a  # along the meridian; the normal into the water is (-tz, tr)
        curvature = (r1 * z2 - z1 * r2) / a**2  # of the tangent by phi
        xs, zs = dx / a, dz / a
        da = (r1 * r2 + z1 * z2) / a
        xss, zss = (ddx - xs * da) / a, (ddz - zs * da) / a  # derivatives of xs, zs by phi
        e1, e2 = tr * xs + tz * zs, x / r
        turn = -tz * xs + tr * zs
        dturn = (-tz * xss + tr * zss) - curvature * e1
        k1, k2 = -dturn / a, -turn * tr / r
        area = 2 * np.pi * r * a * weight
        e, h, nu = self.young_modulus, self.thickness, self.poisson_ratio

        def energy(f: np.ndarray, g: np.ndarray) -> np.ndarray:
            cross = (f * area) @ g.T
            return (f * area) @ f.T + (g * area) @ g.T + nu * (cross + cross.T)

        stiff = e * h / (1 - nu**2) * energy(e1, e2) + e * h**3 / (12 * (1 - nu**2)) * energy(k1, k2)
        return self.density * h * ((x * area) @ x.T + (z * area) @ z.T), stiff

    @cached_property
    def _wet(self) -> tuple[np.ndarray, ...]:
        """Nodes of the wet meridian: phi, weights."""
        t, weight = leggauss(200)
        return np.pi * (3 + t) / 4, np.pi / 4 * weight

    @cached_property
    def hydrostatics(self) -> np.ndarray:
        """-dQ/dq of the follower pressure on the wet half, N/m."""
        phi, weight = self._wet
        r, height, r1, z1, *_ = self.meridian(phi)
        x, z, dx, dz, *_ = self.shapes(phi)
        normal, p = -z1 * x + r1 * z, -self.water * GRAVITY * height
        stiff = -self.water * GRAVITY * ((normal * r * weight) @ z.T) + (normal * p * weight) @ x.T
        return 2 * np.pi * (stiff + (z * r * p * weight) @ dx.T - (x * r * p * weight) @ dz.T)

    def long_wave_force(self) -> np.ndarray:
        """Excitation of unit amplitude at frequency zero, -rho g int n.psi dS over the wet surface, N/m."""
        phi, weight = self._wet
        r, _, r1, z1, *_ = self.meridian(phi)
        x, z, *_ = self.shapes(phi)
        return -2 * np.pi * self.water * GRAVITY * (-z1 * x + r1 * z) @ (r * weight)

    def radiation(self, omega: float, terms: int = 60) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Added mass [kg], damping [kg/s] and excitation [N/m] of the displacements."""
        k = omega**2 / GRAVITY
        phi, weight = self._wet
        x, z, x1, z1, *_ = self.meridian(phi)
        r = np.hypot(x, z)
        c, s = -z / r, x / r  # of the angle from straight down
        size = 2 * terms
        p = legendre(c, size)
        dp = slopes(c, p)
        m = np.arange(size)[:, None]
        unit = min(self.radius, self.height / 2)
        values, radial, along = [], [], []  # potentials, d/dr and d/dtheta / r
        # the wave source: 1/r - K sum (-K r)^m/m! [(gamma + ln K r - H_m - i pi) P_m + dP_nu/dnu]
        low = m[:60]
        factor = np.cumprod(np.vstack([np.ones_like(r), -k * r / low[1:]]), axis=0)
        harmonic = np.concatenate([[0.0], np.cumsum(1 / np.arange(1, 60))])[:, None]
        d = legendre_by_degree(c, 59)
        log = np.euler_gamma + np.log(k * r) - harmonic - 1j * np.pi
        values.append(1 / r - k * np.sum(factor * (log * p[:60] + d), axis=0))
        radial.append(-1 / r**2 - k / r * np.sum(factor * (low * (log * p[:60] + d) + p[:60]), axis=0))
        ds = slopes_by_degree(c, p[:61], dp[:61], d)
        along.append(k * s / r * np.sum(factor * (log * dp[:60] + ds), axis=0))
        for n in range(1, terms):
            ratio = (unit / r) ** (2 * n + 1)
            values.append(ratio * (p[2 * n] + k * r / (2 * n) * p[2 * n - 1]))
            radial.append(-ratio / r * ((2 * n + 1) * p[2 * n] + k * r * p[2 * n - 1]))
            along.append(-ratio * s / r * (dp[2 * n] + k * r / (2 * n) * dp[2 * n - 1]))
        values, radial, along = np.array(values), np.array(radial), np.array(along)
        # e_r = (s, -c), e_theta = (c, s) in x, z; normal times length (-z1, x1)
        flux = radial * (-z1 * s - x1 * c) + along * (-z1 * c + x1 * s)
        dx, dz, *_ = self.shapes(phi)
        wanted = -z1 * dx + x1 * dz
        root = np.sqrt(weight * x)
        scale = np.linalg.norm(flux * root, axis=1)
        strength = np.linalg.lstsq((flux * root / scale[:, None]).T, (wanted * root).T.astype(complex), rcond=1e-13)[0]
        strength = strength / scale[:, None]
        product = -2 * np.pi * self.water * (wanted * x * weight) @ (values.T @ strength)
        product = (product + product.T) / 2
        return product.real, omega * product.imag, 2 * np.pi * self.water * GRAVITY * strength[0]

    def ports(self, period: float) -> tuple[Port, Port]:
        """Rigid and flexible buoy in a regular wave; shell motions carry no momentum of their own."""
        omega = 2 * np.pi / period
        added, damping, force = self.radiation(omega)
        mass, elastic = self.structure
        heave = np.zeros(len(mass))
        heave[1] = heave[self.degree + 1] = 1
        free = null_space((mass @ heave)[None])
        if self.clamp is not None:
            x, z, *_ = self.shapes(np.deg2rad([self.clamp]))
            free = free @ null_space(np.hstack([x, z]).T @ free)
        modes = np.column_stack([heave, free])
        m, e = modes.T @ mass @ modes, modes.T @ elastic @ modes
        m[0, 0] = self.mass
        still = modes.T @ self.hydrostatics @ modes
        dynamic = -(omega**2) * (m + modes.T @ added @ modes) - 1j * omega * (modes.T @ damping @ modes + self.beta * e)
        dynamic = dynamic + e + still
        force, k = modes.T @ force, omega**2 / GRAVITY
        limit = 0.5 * self.water * GRAVITY * omega / (2 * k) / k

        def port(count: int) -> Port:
            right = np.column_stack([np.eye(count)[0], force[:count]])
            answer = -1j * omega * np.linalg.solve(dynamic[:count, :count], right)[0]
            return Port(1 / answer[0], answer[1], limit)

        return port(1), port(len(modes.T))

    def gain(self, period: float) -> float:
        """Gain over the rigid buoy, per cent, each at its own best heave damper."""
        rigid, flexible = self.ports(period)
        return 100 * (flexible.power() / rigid.power() - 1)
