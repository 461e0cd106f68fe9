"""Runs in time of the rigid sphere against Cummins' equation with the multipoles' memory, stepped apart."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from verification.conftest import SEED
from verification.multipoles import GRAVITY, Shell
from verification.transient import Pausing, coulomb, drag, excitation, heave, linear, saturated

RIGID = {"designs": {"FSB": {"flexible": False}}, "modes": {"basis": "membrane", "degree": 0}}
SHELL = Shell(mass=17170.0)


def settled(resolvent, power, period: float, amplitude: float, periods: int = 24, last: int = 8) -> float:
    """Mean power [W] of a regular wave over the last periods; two steps, extrapolated by their second order."""
    found = []
    for count in (160, 320):
        step, per = period / count, excitation(SHELL, period) * amplitude

        def force(t: float, per: complex = per) -> float:
            return float((per * np.exp(-2j * np.pi / period * t)).real)

        *_, middle = heave(SHELL, resolvent, periods * period, step, force)
        found.append(np.mean(power(middle[-last * count :])))
    return float((4 * found[1] - found[0]) / 3)


def taken(run, name: str, period: float, amplitude: float, pto: dict, **sections) -> dict:
    """Row of the package's own run in the same wave, over whole periods after the transient."""
    wave = {"kind": "regular", "amplitude": amplitude, "period": period}
    times = {"duration": 32 * period, "window": [24 * period, 32 * period]}
    return run(name, waves=[wave], pto=pto, simulation=times, **RIGID, **sections).comparison.to_dict("records")[0]


def test_free_decay(agree, run):
    """Released 0.3 m high at -0.8 m/s with a damper of 2000 N s/m: 12 s of a motion that is mostly memory."""
    start = {"initial_position": 0.3, "initial_velocity": -0.8}
    results = run(
        "decay",
        waves=[{"kind": "still"}],
        pto={"damping": 2000.0},
        simulation={"duration": 12.0, "window": [0.0, 12.0], **start},
        **RIGID,
    )
    motion = results.trajectory("FSB")
    time, position, *_ = heave(SHELL, linear(2000.0), 12.0, 0.01, position=0.3, velocity=-0.8)
    found = motion["position"].sel(dof="Heave")
    agree("radiation memory", "free decay, 12 s", np.interp(time, motion["time"], found), position, 5e-3)


def test_coulomb(agree, run):
    """Friction of 300 N in waves of 2.5 s and 0.1 m: the run that an earlier bound did not hold."""
    row = taken(run, "coulomb", 2.5, 0.1, {"law": "coulomb", "force_limit": 300.0})
    wanted = settled(coulomb(300.0), lambda v: 300 * np.abs(v), 2.5, 0.1)
    agree("take-off laws", "coulomb, 300 N", row["power_mean"], wanted, 5e-3)


def test_saturated(agree, run):
    """A damper of 13000 N s/m that gives no more than 900 N."""
    row = taken(run, "saturated", 2.5, 0.1, {"law": "saturated", "damping": 13000.0, "force_limit": 900.0})
    wanted = settled(saturated(13000.0, 900.0), lambda v: np.minimum(13000 * np.abs(v), 900.0) * np.abs(v), 2.5, 0.1)
    agree("take-off laws", "saturated damper, 900 N", row["power_mean"], wanted, 5e-3)


@pytest.mark.parametrize(("law", "period", "damping"), [("latching", 5.0, 12000.0), ("declutching", 2.2, 60000.0)])
def test_pausing(agree, run, law, period, damping):
    """A damper that holds, or lets go, after each reversal as long as takes most, the pause found by both."""
    row = taken(run, law, period, 0.1, {"law": law, "damping": damping})
    step, per = period / 400, excitation(SHELL, period) * 0.1

    def power(pause: float) -> float:
        resolvent = Pausing(damping, pause, hold=law == "latching", step=step)
        heave(SHELL, resolvent, 24 * period, step, lambda t: float((per * np.exp(-2j * np.pi / period * t)).real))
        return float(np.mean(resolvent.taken[-6 * 400 :]))

    pauses = np.linspace(0.0, 0.5, 21) * period
    powers = [power(pause) for pause in pauses]
    best = int(np.argmax(powers))
    near = (pauses[best - 1], pauses[best + 1])
    refined = minimize_scalar(lambda pause: -power(pause), bounds=near, method="bounded", options={"maxiter": 12})
    wanted = max(-refined.fun, powers[best])
    agree("take-off laws", law, row["power_mean"], wanted, 5e-3)
    assert wanted > 1.1 * powers[0]  # else the pause would not have been tested


def test_drag(agree, run):
    """Quadratic drag of the waterplane's area past the water's own motion at half the draft, beside a damper."""
    area = np.pi * 4.0
    plate = {"heave": {"coefficient": 2.0, "area": float(area)}}
    row = taken(run, "drag", 3.3, 0.4, {"damping": 15000.0}, drag=plate)
    omega = 2 * np.pi / 3.3
    depth = (omega**2 / GRAVITY) * 1.0

    def flow(t: float) -> float:
        return float((-1j * omega * 0.4 * np.exp(-depth - 1j * omega * t)).real)

    law = drag(15000.0, 0.5 * SHELL.water * 2.0 * area, flow)
    wanted = settled(law, lambda v: 15000 * v**2, 3.3, 0.4)
    agree("quadratic drag", "power of a damper beside it", row["power_mean"], wanted, 5e-3)
    free = settled(linear(15000.0), lambda v: 15000 * v**2, 3.3, 0.4)
    assert wanted < 0.9 * free  # else the drag would not have been tested


def test_record(agree, run, folder):
    """A measured sea from rest, 50 s: every harmonic drives Cummins' equation with its own excitation and phase."""
    step, count = 0.25, 240
    time, harmonic = step * np.arange(count), np.arange(count)
    draw = np.random.default_rng(7)
    inside = (harmonic > 11) & (harmonic < 31)  # 1.2 to 3.2 rad/s
    waves = np.where(inside, draw.normal(size=count) * 0.01, 0.0) * np.exp(2j * np.pi * draw.random(count))
    omega = 2 * np.pi * harmonic / (step * count)
    elevation = (waves * np.exp(-1j * np.outer(time, omega))).sum(axis=1).real
    lines = [f"{t:.4f},{e:.12f}" for t, e in zip(time, elevation, strict=True)]
    (folder / "record.csv").write_text("\n".join(["time [s],elevation [m]", *lines]) + "\n", encoding="utf-8")

    sample = np.fft.rfft(elevation)[: count // 2]  # again from the file's samples, conjugated: C1
    driven = {k: 2 * np.conj(sample[k]) / count * excitation(SHELL, 2 * np.pi / omega[k]) for k in harmonic[inside]}

    def force(t: float) -> float:
        return float(sum((f * np.exp(-1j * omega[k] * t)).real for k, f in driven.items()))

    wave = {"kind": "record", "file": str(folder / "record.csv")}
    times = {"duration": 50.0, "window": [10.0, 50.0]}
    results = run("record", waves=[wave], pto={"damping": 8000.0}, simulation=times, **RIGID)
    found = results.trajectory("FSB")
    at, position, *_ = heave(SHELL, linear(8000.0), 50.0, 0.02, force)
    moved = found["position"].sel(dof="Heave")
    agree("records of the sea", "motion over 50 s", np.interp(at, found["time"], moved), position, 1e-2)


def test_spreading(agree, run, folder):
    """A surging buoy in a short-crested sea over the long-crested one: cos^2 over the energy of all directions.

    A damper of any size absorbs S(w) D(b) cos^2 b P(w) of each direction b: the double sum of D(b) cos^2 b, D the
    density cos^2s of half the angle, whatever the buoy's response is.
    """
    spread, wave = 8, {"kind": "jonswap", "hs": 0.1, "tp": 3.5, "seed": 1}
    device = {"centre_of_mass": -0.5, "ballast_inertia": 5.0e3}
    sections = {
        "device": {**SEED["device"], **device},
        "motion": "planar",
        "mooring": [2.0e4, 0, 0, 0, 0, 0],
        "pto": {"damping": 9000.0, "port": "surge"},
        "simulation": {"duration": 300.0, "window": [100.0, 300.0]},
    }
    directions, hertz = np.arange(-170, 181, 10), np.linspace(0.15, 0.6, 91)
    files = {"long": [("f", "S")], "wide": [("f", *directions)]}
    by_direction = np.cos(np.radians(directions) / 2) ** (2 * spread)
    for f in hertz:
        energy = 0.01 * np.exp(-(((f - 0.29) / 0.05) ** 2))
        files["long"].append((f, energy))
        files["wide"].append((f, *(energy * by_direction / np.sum(by_direction) / 10)))
    for name, rows in files.items():
        (folder / f"{name}.csv").write_text("\n".join(",".join(map(str, row)) for row in rows), encoding="utf-8")
    measured = [{"kind": "spectrum", "file": str(folder / f"{name}.csv")} for name in files]
    seas = [wave, {**wave, "spreading": {"s": spread, "directions": 15}}, *measured]
    rows = run("spread", waves=seas, **sections, **RIGID).ladder.query("rung == 'fixed'")
    long_crested, short_crested, along, around = rows.power_mean
    angle = np.linspace(-np.pi, np.pi, 20001)
    density = np.cos(angle / 2) ** (2 * spread)
    share = np.sum(density * np.cos(angle) ** 2) / np.sum(density)
    agree("short-crested seas", "power at a surging port, s = 8", short_crested / long_crested, share, 2e-2)
    agree("spectra over frequency and direction", "power at a surging port, s = 8", around / along, share, 2e-2)
    assert share < 0.85
