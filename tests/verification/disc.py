"""A thin elastic disc of no draft on the water, with a damper all over it: derived apart from the package.

On still water phi_z = K phi, K = omega^2/g, except under the disc, where phi_z = -i omega w. With s = K phi - phi_z
there, in Hankel space of azimuthal order m and in water of depth h, all lengths in radii,

    phi = phi_I - int J_m(k r) s(k)/(k tanh kh - K) k dk,

the pole passed so that waves leave the disc. Zernike's polynomials R_n^m, n = m + 2j, have the transforms
(-1)^j J_{n+1}(k)/k, so potential and deflection in them turn this into one matrix per order. The disc is Kirchhoff's
plate with a free edge, by its energy: rho g w + D grad^4 w - omega^2 m w - i omega c w = i omega rho phi.
"""

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import brentq
from scipy.special import comb, jv


def zernike(n: int, m: int) -> Polynomial:
    """The radial polynomial R_n^m, one at the edge."""
    coefficients = np.zeros(n + 1)
    for k in range((n - m) // 2 + 1):
        coefficients[n - 2 * k] = (-1) ** k * comb(n - k, k) * comb(n - 2 * k, (n - m) // 2 - k)
    return Polynomial(coefficients)


def bending(m: int, degrees: list[int], nu: float) -> np.ndarray:
    """Bending energies of the polynomials cos(m theta), in units of D and of pi, of order 0 of 2 pi."""
    r, weight = np.polynomial.legendre.leggauss(40)
    r, weight = (r + 1) / 2, weight / 2
    rows = []
    for n in degrees:
        f = zernike(n, m)
        radial, around = f.deriv(2)(r), f.deriv(1)(r) / r - m**2 * f(r) / r**2
        twist = m * (f.deriv(1)(r) / r - f(r) / r**2)
        rows.append((radial, around, twist))
    a, b, t = np.moveaxis(np.array(rows), 1, 0)
    inner = r * weight
    mean = (a + b) * inner @ (a + b).T
    return mean - (1 - nu) * ((a * inner) @ b.T + (b * inner) @ a.T - 2 * (t * inner) @ t.T)


def green(m: int, degrees: list[int], k_deep: float, depth: float) -> tuple[np.ndarray, float]:
    """Matrix of the integral above in the polynomials of one order, and the wavenumber, both in radii."""
    k0 = brentq(lambda k: k * np.tanh(k * depth) - k_deep, 1e-6, k_deep + 10 / depth)
    node, weight = np.polynomial.legendre.leggauss(24)
    edges = np.concatenate([[0.0, 2 * k0], 2 * k0 + 0.5 * np.pi * np.arange(1, 800)])
    k = (edges[:-1, None] + np.diff(edges)[:, None] * (node + 1) / 2).ravel()  # symmetric about the pole
    step = (np.diff(edges)[:, None] * weight / 2).ravel()
    signs = np.array([(-1.0) ** ((n - m) // 2) for n in degrees])
    waves = signs[:, None] * np.array([jv(n + 1, k) for n in degrees])
    principal = (waves * step / (k * (k * np.tanh(k * depth) - k_deep))) @ waves.T
    at_pole = signs * np.array([jv(n + 1, k0) for n in degrees])
    slope = np.tanh(k0 * depth) + k0 * depth / np.cosh(k0 * depth) ** 2
    return principal + 1j * np.pi * np.outer(at_pole, at_pole) / (k0 * slope), k0


def power(
    omega: float,
    damping: float,
    *,
    radius: float,
    depth: float,
    rigidity: float,
    mass: float,
    nu: float,
    rho: float,
    g: float,
    degree: int = 12,
    orders: int = 7,
    highest: int | None = None,
) -> tuple[float, float]:
    """Mean power per squared wave amplitude [W/m^2]: of the dampers, and what the waves far away have lost.

    `damping` in N s/m^3, `mass` in kg/m^2; polynomials to `degree`, of the deflection to `highest` (1: a rigid disc).
    """
    k_deep, absorbed, lost = omega**2 / g * radius, 0.0, 0.0
    for m in range(orders):
        degrees = list(range(m, degree + 1, 2))
        moving = sum(highest is None or n <= highest for n in degrees)
        norm = np.diag([1 / (2 * (n + 1)) for n in degrees])
        pick = np.eye(len(degrees))[:, :moving]
        matrix, k0 = green(m, degrees, k_deep, depth / radius)
        transform = np.array([(-1.0) ** ((n - m) // 2) * jv(n + 1, k0) / k0 for n in degrees])
        incident = -1j * g / omega * (1 if m == 0 else 2) * 1j**m  # times J_m(kr) cos(m theta), elevation exp(ikx)
        plate = (rho * g - omega**2 * mass - 1j * omega * damping) * norm + rigidity / radius**4 * bending(
            m, degrees, nu
        )
        system = np.block(
            [
                [norm + k_deep * matrix, 1j * omega * radius * matrix @ pick],
                [-1j * omega * rho * pick.T @ norm, pick.T @ plate @ pick],
            ]
        )
        found = np.linalg.solve(system, np.concatenate([incident * transform, np.zeros(moving)]))
        phi, w = found[: len(degrees)], pick @ found[len(degrees) :]
        around = np.pi * (2 if m == 0 else 1)
        absorbed += around * radius**2 * damping * omega**2 / 2 * float(np.real(w.conj() @ norm @ w))
        slope = np.tanh(k0 * depth / radius) + k0 * depth / radius / np.cosh(k0 * depth / radius) ** 2
        scattered = -1j * np.pi * k0 / slope * (transform @ (k_deep * phi + 1j * omega * radius * w))
        column = (np.sinh(2 * k0 * depth / radius) / (4 * k0) + depth / radius / 2) / np.cosh(k0 * depth / radius) ** 2
        change = abs(incident / 2) ** 2 - abs(incident / 2 + scattered) ** 2
        lost += rho * omega / np.pi * around * radius * column * change
    return absorbed, lost
