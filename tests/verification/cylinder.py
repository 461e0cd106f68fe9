"""Floating vertical cylinder in water of finite depth by matched eigenfunctions (Yeung 1981): a reference for panels.

R. W. Yeung, Applied Ocean Research 3 (1981) 119-133. No irregular frequencies, no panels. Nothing of the package is
imported. Phasors exp(-i omega t); s = z + h counts from the bottom.
"""

import numpy as np
from scipy.optimize import brentq
from scipy.special import h1vp, hankel1, ive, kve

GRAVITY = 9.81


def radiation(
    omega: float, radius: float, draft: float, depth: float, motion: str, density: float = 1000.0, terms: int = 120
) -> tuple[float, float]:
    """Added mass [kg] and damping [kg/s] of `heave` or `surge` of the cylinder."""
    a, d, h = radius, depth - draft, depth
    m = 0 if motion == "heave" else 1
    k0 = omega**2 / GRAVITY
    wave = brentq(lambda k: k * np.tanh(k * h) - k0, 1e-12, max(10 * k0, 10 / h))
    j = np.arange(1, terms)
    decaying = [
        brentq(lambda x: x * np.sin(x) + k0 * h * np.cos(x), (i - 0.5) * np.pi + 1e-12, i * np.pi) / h for i in j
    ]
    k = np.concatenate([[1j * wave], decaying])  # cos(k s) is cosh of the wave's
    norm = np.sqrt((1 + np.sin(2 * k * h) / (2 * k * h)) / 2)  # mean square of cos(k s) over the depth
    # radial functions whose derivative at r = a is one
    outer = np.zeros(terms, dtype=complex)
    outer[0] = hankel1(m, wave * a) / (wave * h1vp(m, wave * a))
    x = k[1:].real * a
    outer[1:] = a * kve(m, x) / (-(kve(m - 1, x) + kve(m + 1, x)) / 2 * x)
    n = np.arange(terms)
    lam = n * np.pi / d
    # int_0^d cos(lam s) cos(k s) ds = (-1)^n k sin(k d)/(k^2 - lam^2)
    overlap = (-1.0) ** n[:, None] * k * np.sin(k * d) / (k**2 - lam[:, None] ** 2) / norm
    wall = (np.sin(k * h) - np.sin(k * d)) / k / norm
    y = lam[1:] * a
    slope = np.concatenate([[m / a], lam[1:] * (ive(m - 1, y) + ive(m + 1, y)) / 2 / ive(m, y)])
    share = np.where(n == 0, 1.0, 2.0) / d
    if motion == "heave":  # ((z + h)^2 - r^2/2)/(2 d) moves the bottom of the cylinder at unit velocity
        particular = np.concatenate([[d**2 / 6 - a**2 / 4], (-1.0) ** n[1:] / lam[1:] ** 2])
        flux = -a / (2 * d) * overlap[0]
    else:
        particular, flux = np.zeros(terms), wall
    inner = overlap.T * (slope * share)
    matrix = h * np.eye(terms) - inner @ (overlap * outer)
    strength = np.linalg.solve(matrix, flux - inner @ particular)
    if motion == "heave":
        c = share * (overlap @ (outer * strength) - particular)
        radial = np.concatenate([[a**2 / 2], a * ive(1, y) / ive(0, y) / lam[1:]])
        total = 2 * np.pi * density * ((d**2 * a**2 / 2 - a**4 / 8) / (2 * d) + np.sum((-1.0) ** n * c * radial))
    else:
        total = -np.pi * a * density * np.sum(strength * outer * wall)
    return float(total.real), float(omega * total.imag)
