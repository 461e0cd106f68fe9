"""Designs: what a quotient changes by, against multipoles; damage of a wall, by strains of multipoles and cycles counted."""

from dataclasses import replace
from math import gamma

import numpy as np
import pytest
import yaml
from verification.conftest import SEED
from verification.multipoles import Shell, legendre, motion
from verification.test_gradients import year

import vsb

DEGREE, EXPONENT, STRAIN, CYCLES, YEARS = 6, 3.0, 0.02, 1e6, 20.0
SHELL = Shell(thickness=0.05, young_modulus=5e7)
RADIUS, MASS = (1.8, 2.0), (SHELL.total_mass, 1.3 * SHELL.total_mass)
NARROW = np.linspace(0.19, 0.21, 5)  # Hz; the middle one alone has waves: a band of 2.5 % of its frequency


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A design of the least mass at the largest radius, where the buoy is half submerged; and its climate."""
    folder = tmp_path_factory.mktemp("design")
    lines = ["#YY MM DD hh mm " + " ".join(f"{f:.4f}" for f in NARROW)]
    lines += [f"2020 01 01 {hour:02d} 00 0.00 0.00 {density:.2f} 0.00 0.00" for hour, density in enumerate((8.0, 30.0))]
    (folder / "sea.txt").write_text("\n".join(lines) + "\n")
    device = SEED["device"] | {"thickness": 0.05, "young_modulus": 5e7, "mass": SHELL.total_mass}
    designs = {name: SEED["designs"][name] for name in ("FSB", "VSWEC")}
    study = {**SEED, "device": device, "designs": designs, "waves": [{"kind": "still"}]}
    (folder / "shell.yaml").write_text(yaml.safe_dump(study))
    design = {
        "design": "quotient", "study": "shell.yaml", "climate": {"spectra": "sea.txt"}, "starts": 1,
        "maximise": "power_per_mass", "limits": {"load_factor": None, "static_strain": None, "damage": 1e30},
        "variables": {"device.radius": {"log": list(RADIUS)}, "device.mass": {"log": list(MASS)}},
        "fatigue": {"exponent": EXPONENT, "strain": STRAIN, "cycles": CYCLES, "years": YEARS},
    }  # fmt: skip
    (folder / "quotient.yaml").write_text(yaml.safe_dump(design))
    return vsb.run(vsb.load_design(str(folder / "quotient.yaml")), str(folder / "results"), quiet=True), vsb.read_seas(
        folder / "sea.txt"
    )


def test_a_quotient_changes_with_size_as_multipoles_say(agree, found):
    """Multipliers of the bounds of radius and mass, along the line on which both keep the buoy half submerged."""
    results, climate = found
    starts = results.starts.set_index("buoy")
    for buoy, flexible in (("flexible", True), ("rigid competitor", False)):
        one = starts.loc[buoy]
        assert one["accepted"] == "yes"
        assert [one["device.radius"], one["device.mass"]] == pytest.approx([RADIUS[1], MASS[0]], rel=1e-9)
        by_radius = one["multiplier upper bound of device.radius"] / np.log(RADIUS[1] / RADIUS[0])
        by_mass = -one["multiplier lower bound of device.mass"] / np.log(MASS[1] / MASS[0])
        values = [
            np.log(year(replace(SHELL, radius=2.0 * (1 + step)), climate, flexible) / (1 + step) ** 3)
            for step in (-0.02, -0.01, 0.01, 0.02)
        ]
        wanted = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / 0.12
        agree("power per mass of a design", f"d ln(P/m)/d ln r, {buoy}", by_radius + 3 * by_mass, wanted, 1e-6)


def strains(phi):
    """Strains of a wall, outer and inner face, along the meridian and around, by (radial P_n, meridional dP_n/dphi)."""
    s, c = np.sin(phi), np.cos(phi)
    p, n = legendre(c, DEGREE), np.arange(DEGREE + 1)[:, None]
    first = np.zeros_like(p)
    first[1:] = n[1:] * (c * p[1:] - p[:-1]) / s
    second, zero = -n * (n + 1) * p - c / s * first, np.zeros_like(p)
    v, dv, ddv, u, du = (
        np.vstack(pair) for pair in ((p, zero), (first, zero), (second, zero), (zero, first), (zero, second))
    )
    r, half = SHELL.radius, SHELL.thickness / 2
    along, around = (du + v) / r, (u * c / s + v) / r
    bent_along, bent_around = half * (du - ddv) / r**2, half * c / s * (u - dv) / r**2
    return np.hstack([along + bent_along, along - bent_along, around + bent_around, around - bent_around])


def rainflow(values):
    """Ranges of the cycles of a record by ASTM E1049, those left at its end as half cycles: ranges and counts."""
    step, bend = (values[2:] - values[:-2]) / 2, values[2:] - 2 * values[1:-1] + values[:-2]
    turning = np.diff(values)[1:] * np.diff(values)[:-1] < 0
    turns = values[1:-1][turning] - step[turning] ** 2 / (2 * bend[turning])  # of a parabola through three samples
    stack, ranges, counts = [], [], []
    for turn in turns:
        stack.append(turn)
        while len(stack) >= 3:
            last, before = abs(stack[-1] - stack[-2]), abs(stack[-2] - stack[-3])
            if last < before:
                break
            ranges.append(before)
            counts.append(0.5 if len(stack) == 3 else 1.0)
            del stack[-3 if len(stack) == 3 else slice(-3, -1)]
    return np.array([*ranges, *np.abs(np.diff(stack))]), np.array([*counts, *[0.5] * (len(stack) - 1)])


def test_damage_of_a_wall_is_that_of_strains_of_multipoles_and_of_cycles_counted(agree, found):
    """Narrow band: Rayleigh's ranges in closed form, and rainflow cycles of a Gaussian record of two weeks."""
    results, climate = found
    one = results.starts.set_index("buoy").loc["flexible"]
    node, weight = np.polynomial.legendre.leggauss(6)
    band = int(np.argmax(climate.mean_density))
    low, high = climate.edges[band : band + 2]
    omega, width = (low + high) / 2 + (high - low) / 2 * node, (high - low) / 2 * weight
    amplitude = []
    for w in omega:
        at = motion(SHELL, 2 * np.pi / w, DEGREE)
        dynamic = at.dynamic.copy()
        dynamic[0, 0] -= 1j * w * one["damping"]
        amplitude.append(at.modes @ np.linalg.solve(dynamic, at.force))
    square = np.abs(np.array(amplitude) @ strains(np.linspace(1e-3, np.pi - 1e-3, 4001))) ** 2
    m_0, m_2 = (width * omega**power @ square for power in (0, 2))  # per density of the sea
    seconds = YEARS * 365.25 * 86400 * climate.hours
    each = (np.sqrt(8 * m_0) / STRAIN) ** EXPONENT * gamma(1 + EXPONENT / 2) * np.sqrt(m_2 / m_0) / (2 * np.pi)
    damage = (seconds @ climate.density[:, band] ** (EXPONENT / 2)) * each / CYCLES
    agree("damage of a wall", "Miner's sum, strains of multipoles", one["damage"], damage.max(), 1e-5)

    worst, step, count = square[:, damage.argmax()], 0.3, 2**22
    grid = 2 * np.pi * np.fft.rfftfreq(count, step)
    density = np.where((grid >= low) & (grid < high), np.interp(grid, omega, worst), 0.0)
    drawn = np.random.default_rng(7).normal(size=(2, len(grid))) * np.sqrt(density)
    record = np.fft.irfft(drawn[0] + 1j * drawn[1], count)
    record *= np.sqrt(m_0[damage.argmax()] / record.var())
    ranges, counts = rainflow(record)
    counted = (counts @ (ranges / STRAIN) ** EXPONENT) / (count * step)
    total = (seconds @ climate.density[:, band] ** (EXPONENT / 2)) * counted / CYCLES
    agree("damage of a wall", "the same, cycles counted by rainflow", one["damage"], total, 0.03)
