"""Frames of the animated buoys, and a page that plays them."""

import base64

import numpy as np
import pytest
import xarray as xr
from browser import asked

from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.engine.waves.water import Water
from vsb.report import html
from vsb.report.animation import (
    FROM_LEFT,
    PER_PERIOD,
    PERIODS,
    PLANE,
    View,
    frames_data,
    in_motion,
    shapes_data,
    surface,
)
from vsb.report.interactive import as_script, designs_data, packed

PERIOD = 4.0
SWELL = Sea(np.array([2 * np.pi / PERIOD]), np.array([0.3 + 0.0j]))
TIME = np.linspace(0.0, 60.0, 6001)
LABELS = ["Heave", "Membrane0", "Membrane2"]


def unpacked(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def run(labels):
    position = np.array([(n + 1) * np.cos(2 * np.pi / PERIOD * TIME) for n in range(len(labels))]).T
    return xr.DataArray(position, {"time": TIME, "dof": labels}, ("time", "dof"))


@pytest.fixture
def modes():
    colatitude = np.linspace(0.0, np.pi, 181)
    shapes = np.array([np.ones(181), np.cos(2 * colatitude)])
    return xr.Dataset(
        {
            "radial": (("mode", "colatitude"), shapes), "meridional": (("mode", "colatitude"), 0 * shapes),
            "static_amplitude": ("mode", [0.1, 0.0]),
        },
        coords={"colatitude": colatitude, "mode": LABELS[1:]},
        attrs={"radius": 2.0, "centre_height": 0.5},
    )  # fmt: skip


def frames(water=None, waves=SWELL):
    runs = {"FSB": run(LABELS[:1]), "VSWEC": run(LABELS)}
    return frames_data("a swell", runs, waves, (0.0, 60.0), PERIOD, View(3.4), water or Water(), LABELS[1:])


def test_frames_show_the_last_periods_of_the_run():
    found = frames()
    time = found["start"] + found["step"] * np.arange(found["frames"])
    assert (time[0], time[-1]) == (pytest.approx(60.0 - PERIODS * PERIOD), pytest.approx(60.0))
    assert found["frames"] == pytest.approx(PER_PERIOD * PERIODS, abs=2)
    rigid, shell = found["designs"]
    assert (rigid["modes"], shell["modes"], rigid["shell"]) == (0, 2, "")
    np.testing.assert_allclose(unpacked(rigid["heave"]), np.cos(2 * np.pi / PERIOD * time), atol=1e-4)
    amplitudes = unpacked(shell["shell"]).reshape(-1, 2)
    np.testing.assert_allclose(amplitudes, np.cos(2 * np.pi / PERIOD * time)[:, None] * [2, 3], atol=1e-3)


@pytest.mark.parametrize("depth", [np.inf, 3.0])
def test_surface_obeys_the_dispersion_relation(depth):
    """It is the incident elevation at the buoy's axis and travels towards x > 0."""
    water = Water(depth=depth)
    time, place = np.linspace(0, 8, 80, endpoint=False), np.array([0.0, 1.0])
    found = surface(SWELL, time, place, water)
    np.testing.assert_allclose(found[:, 0], SWELL.elevation(time), atol=1e-12)
    omega = SWELL.omega[0]
    delay = np.angle(np.exp(-1j * omega * time) @ found[:, 1] / (np.exp(-1j * omega * time) @ found[:, 0]))
    number = -delay  # later, not earlier: waves go to x > 0
    assert number * np.tanh(number * min(depth, 1e3)) == pytest.approx(omega**2 / 9.81, rel=1e-9)
    assert not surface(NO_WAVES, time, place, water).any()


@pytest.mark.parametrize("drift", [0.0, 0.2])
def test_surge_and_pitch_are_drawn_in_their_plane(drift):
    """Motions out of the plane are left out; surge is about its mean and its drift."""
    labels = ["Heave", "Membrane0", "Surge", "Pitch", "Membrane1c1", "Sway", "Membrane1s1"]
    place = xr.DataArray(50.0 + drift * TIME, {"time": TIME}, ("time",))
    drifting = run(labels) + place * xr.DataArray([0, 0, 1.0, 0, 0, 0, 0], {"dof": labels}, ("dof",))
    found = frames_data(
        "", {"A": drifting}, SWELL, (0.0, 60.0), PERIOD, View(3.4), Water(), ["Membrane0", "Membrane1c1"]
    )
    (one,) = found["designs"]
    assert one["modes"] == 2
    surge = unpacked(one["surge"])
    assert (surge.min(), surge.max()) == (pytest.approx(-3.0, rel=0.02), pytest.approx(3.0, rel=0.02))
    np.testing.assert_allclose(unpacked(one["pitch"]), 4.0 * unpacked(one["heave"]), atol=1e-3)
    moving = {"designs": [{"name": "A"}], "factor": 1.0, "shapes": {}, "seas": [found]}
    assert in_motion(moving)["view"] == PLANE
    assert in_motion({**moving, "seas": [frames()]})["view"] == FROM_LEFT
    assert in_motion(None) is None


def in_page(data, words):
    """A page with nothing but moving buoys."""
    scripts = "".join(f"<script>{html.text_of(name)}</script>" for name in html.SCRIPTS)
    body = html.page("buoys.html.j2", animated={"title": "Buoys", "words": words, "view": FROM_LEFT})
    stored = f'<script type="application/json" id="buoys-data">{as_script(data)}</script>'
    return f"<!doctype html><html><head></head><body>{body}{stored}{scripts}</body></html>"


def test_odd_orders_and_pitch_in_the_browser(modes, tmp_path):
    """Shapes of odd order change sign on the far side; pitch brings the top to the right."""
    quarter = {name: packed([value]) for name, value in {"heave": 0.25, "surge": 0.5, "pitch": np.pi / 2}.items()}
    sea = {**frames(), "frames": 1, "designs": [{**quarter, "modes": 2, "shell": packed([0.3, 0.2])}]}
    shapes = shapes_data(modes.assign(order=("mode", [1, 0])))
    data = {"designs": designs_data(["A"], None), "width": 3.4, "factor": 1.0, "shapes": shapes, "seas": [sea]}
    script = """
      buoys.play(false);
      const [one] = buoys.sea.designs;
      const tops = [false, true].map((opposite) => buoys.meridian(one, 0, opposite)[0]);
      return { errors, tops, placed: buoys.placed(one, 0, [0, 2], 10) };"""
    found = asked(in_page(data, "one buoy"), script, tmp_path)
    assert found["errors"] == []
    assert found["tops"] == [pytest.approx([0.0, 2.0 + 0.1 + each + 0.2]) for each in (0.3, -0.3)]
    assert found["placed"] == pytest.approx([10 * (0.5 + 2.0), -10 * (0.5 + 0.25)], abs=1e-5)


def test_reader_plays_pauses_and_steps(modes, tmp_path):
    data = {
        "designs": designs_data(["FSB", "VSWEC"], "FSB"), "width": 3.4, "factor": 0.1, "shapes": shapes_data(modes),
        "seas": [frames()],
    }  # fmt: skip
    script = """
      const part = (name) => document.querySelector(`#buoys [data-part="${name}"]`);
      const found = { errors, begins: buoys.playing, says: part("play").textContent };
      buoys.play(false);
      const due = [];
      globalThis.requestAnimationFrame = (step) => due.push(step);
      buoys.play(true);
      for (let now = 0; now <= 1000; now += 100) due.shift()(now);
      found.played = buoys.frame;
      part("moment").value = 12;
      part("moment").dispatchEvent(new Event("input"));
      const held = buoys.frame;
      while (due.length) due.shift()(9000);
      const [top, equator] = [buoys.meridian(buoys.sea.designs[1], 0)[0], buoys.meridian(buoys.sea.designs[1], 0)[23]];
      const pixels = part("canvas").getContext("2d").getImageData(0, 0, part("canvas").width, part("canvas").height).data;
      return { ...found, held, stays: buoys.frame, stopped: buoys.playing, moment: part("moment-says").textContent, top, equator, inked: pixels.some((v) => v > 0) };"""
    found = asked(in_page(data, "two buoys"), script, tmp_path)
    stored_frames = frames()
    assert (found["errors"], found["begins"], found["says"]) == ([], True, "pause")
    assert found["played"] == int(1.0 / stored_frames["step"]), "a second is a second"
    assert (found["held"], found["stays"], found["stopped"]) == (12, 12, False)
    assert found["moment"] == f"{stored_frames['start'] + 12 * stored_frames['step']:.2f} s"
    amplitudes = np.array([0.1, 0.0]) + 0.1 * unpacked(stored_frames["designs"][1]["shell"])[:2]
    assert found["top"] == pytest.approx([0.0, 2.0 + amplitudes.sum()], abs=1e-5)
    assert found["inked"]
