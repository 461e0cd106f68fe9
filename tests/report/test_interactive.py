"""The page's JavaScript computes what Python computes; frames of animated buoys and bodies; both work in a browser."""

import base64
import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from browser import asked, evaluated
from results.test_year import climate

from vsb.engine.hydro.bodies.body import FlexibleBody, cut
from vsb.engine.hydro.bodies.body_file import BoxHull, SphereHull
from vsb.engine.hydro.bodies.build import hull_panels
from vsb.engine.hydro.bodies.mesh import joined, wetted
from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import best_dampers, mean_power
from vsb.engine.waves.kinds import Jonswap, PiersonMoskowitz, jonswap_spectrum
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.engine.waves.water import Water
from vsb.report import page as pages
from vsb.report.canvas import style
from vsb.report.interactive import (
    FROM_LEFT,
    PER_PERIOD,
    PERIODS,
    PLANE,
    Grid,
    InteractiveSea,
    View,
    as_script,
    designs_data,
    displaced_outline,
    frames_data,
    in_motion,
    packed,
    shapes_data,
    study_data,
    surface,
    year_data,
)
from vsb.results.constrained_year import ForceSteps
from vsb.results.year import frequencies, year
from vsb.tools.variables import FORCE

TEMPLATES = Path(pages.__file__).parent / "templates"
ALGEBRA = (TEMPLATES / "algebra.js").read_text(encoding="utf-8")
MASS, SPRING = 25e3, np.array([120e3, 90e3])
DAMPERS = [300.0, 8e3, 4e5]
AGREE = {"rtol": 1e-6, "atol": 0.0}


def ports(omega):
    """Two floating oscillators with radiation damping, excited as Haskind has it."""
    loss = 8e3 * np.exp(-(((omega - 1.8) / 1.2) ** 2)) + 200.0
    impedance = [loss + 1j * (stiffness / omega - MASS * omega) for stiffness in SPRING]
    drive = np.sqrt(8 * loss * 1e4 / omega**3)
    return {
        name: Port(omega, 1 / z, drive / z, 1 / k)
        for name, z, k in zip(("FSB", "VSWEC"), impedance, SPRING, strict=True)
    }


def grid(omega):
    return Grid(omega, 5e3 / omega, ports(omega))


def integral(gamma):
    """Of the shape of a JONSWAP spectrum over frequencies in terms of the peak's."""
    return math.exp(-1.25) * gamma / jonswap_spectrum(np.array([1.0]), 4.0, 2 * math.pi, gamma)[0]


SWELL = np.array([2.5])
OMEGA, _ = Jonswap(kind="jonswap", hs=1.0, tp=5.0).components(12.0, 100.0)
KNOWN = OMEGA[OMEGA > 0.2]
WIDTH = 2 * float(OMEGA[0])


POWERS = {"FSB": (20.0, 38.0, 70.0), "VSWEC": (None, 59.0, 107.0)}
STEPS = ForceSteps((300.0, 600.0, 1200.0), POWERS, "FSB", 106.5)


def sea_of(tp, gamma=3.3):
    own = {"hs": 1.0, "tp": tp, "gamma": gamma, "width": WIDTH, "integral": integral(gamma)}
    return InteractiveSea(
        "a sea", 1, None, own | {"shortest": 2.0, "longest": 12.0}, {"FSB": 8e3, "VSWEC": 8e3}, {"FSB": 40.0}, STEPS
    )


@pytest.fixture
def data():
    """A swell and a JONSWAP sea."""
    swell = InteractiveSea("a swell", 0, np.array([0.04]), None, {"FSB": 8e3, "VSWEC": 8e3})
    band = grid(np.linspace(0.4, 3.5, 60))
    return study_data([grid(SWELL), grid(KNOWN)], [swell, sea_of(5.0)], [band], 1e4 / band.omega**3, "FSB")


def powers(omega, squares):
    """Python's answer: mean power of every damper, design by design."""
    rows = np.repeat(squares[None], len(DAMPERS), axis=0)
    return [mean_power(port, rows, np.array(DAMPERS), np.zeros(len(DAMPERS))) for port in ports(omega).values()]


def test_power_and_optimal_damping_agree_with_python(data, tmp_path):
    expression = """data.seas.map((sea) => {
      const grid = unpackedGrid(data.grids[sea.grid]);
      const squares = seaSquares(sea, grid);
      const own = grid.ports.map((port) => bestDamper(port, squares));
      return {
        powers: grid.ports.map((port) => [300, 8e3, 4e5].map((c) => power(port, squares, c))),
        own, best: grid.ports.map((port, i) => power(port, squares, own[i])),
        matched: grid.ports.map((port) => dot(squares, port.matched)), flux: dot(squares, grid.flux),
      };
    })"""
    found = evaluated([ALGEBRA], expression, data, tmp_path)
    amplitude = Jonswap(kind="jonswap", hs=1.0, tp=5.0).components(12.0, 100.0)[1][OMEGA > 0.2]
    for said, omega, squares in zip(found, (SWELL, KNOWN), (np.array([0.04]), amplitude**2), strict=True):
        np.testing.assert_allclose(said["powers"], powers(omega, squares), **AGREE)
        best = [best_dampers(port, squares[None]) for port in ports(omega).values()]
        np.testing.assert_allclose(said["best"], [one.power[0] for one in best], **AGREE)
        np.testing.assert_allclose(said["own"], [one.damping[0] for one in best], rtol=1e-4)
        np.testing.assert_allclose(said["matched"], [squares @ p.matched_power for p in ports(omega).values()], **AGREE)
        assert said["flux"] == pytest.approx(float(squares @ (5e3 / omega)), rel=1e-6)


@pytest.mark.parametrize(("tp", "gamma"), [(2.5, 3.3), (11.0, 3.3), (7.0, 1.0)])
def test_changed_peak_period_agrees_with_python(tp, gamma, tmp_path):
    """A Pierson-Moskowitz spectrum is a JONSWAP spectrum of gamma 1."""
    stored = study_data([grid(KNOWN)] * 2, [sea_of(5.0, gamma)], [grid(SWELL)], np.ones(1), None)
    expression = f"[...seaSquares(data.seas[0], unpackedGrid(data.grids[1]), {tp})]"
    wave = (
        Jonswap(kind="jonswap", hs=1.0, tp=tp, gamma=gamma)
        if gamma > 1
        else PiersonMoskowitz(kind="pierson_moskowitz", hs=1.0, tp=tp)
    )
    expected = wave.components(12.0, 100.0)[1][OMEGA > 0.2] ** 2
    found = np.array(evaluated([ALGEBRA], expression, stored, tmp_path))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * expected.max())
    np.testing.assert_allclose(powers(KNOWN, found), powers(KNOWN, expected), **AGREE)


def test_year_agrees_with_python(tmp_path):
    """Power matrices, annual means and optimal damping of two designs; a third is not viable."""
    seas = climate(30)
    at = frequencies(seas, 0.25, 2.2)
    point = {"words": "soft", "ports": ports(at), "given": {"FSB": 8e3}, "flux": np.full(30, 7.0)}
    stored = year_data(seas, [point], ["FSB", "VSWEC", "lost"], "FSB")
    expression = """(() => {
      const bins = unpackedBins(data.bins);
      const point = unpackedPoint(data.points[0]);
      const squares = yearSquares(bins, point);
      const there = point.ports.filter((port) => port);
      return {
        matrices: there.map((port) => [...binPowers(bins, point.weights, port, 8e3)]),
        means: there.map((port) => power(port, squares, 8e3)),
        best: there.map((port) => power(port, squares, bestDamper(port, squares))), lost: point.ports[2],
      };
    })()"""
    found = evaluated([ALGEBRA], expression, stored, tmp_path)
    expected = year(ports(at), seas, Water(), ["fixed", "one"], {"FSB": 8e3, "VSWEC": 8e3}, "FSB")
    occupied = [expected.bins.mean(row).ravel()[expected.bins.occupied] for row in expected.power[:, 0]]
    np.testing.assert_allclose(found["matrices"], occupied, **AGREE)
    np.testing.assert_allclose(found["means"], expected.annual_mean_power[:, 0], **AGREE)
    np.testing.assert_allclose(found["best"], expected.annual_mean_power[:, 1], **AGREE)
    assert found["lost"] is None
    assert (stored["points"][0]["given"], stored["points"][0]["flux"]) == ([8e3, None, None], pytest.approx(7.0))


def test_data_cannot_close_their_script():
    text = as_script({"words": "</script><b>"})
    assert "<" not in text
    assert json.loads(text) == {"words": "</script><b>"}


@pytest.fixture
def page(data):
    """A page with nothing but what moves."""
    words = ("study", "published", "source", "dampings")
    lists = (
        "answer", "tuned", "best_bands", "bands", "seas", "tuning", "tuning_head", "statistics_head", "statistics",
        "published_head", "warnings", "sketches", "figures", "checks", "passed",
    )  # fmt: skip
    values = dict.fromkeys(words, "") | {name: [] for name in lists}
    head = ["design", "power"]
    body = [["B", "20"], ["A", "100"], ["C", "-3"]]
    return pages.page(
        "report.html.j2", interactive=as_script(data), kind="study", port=FORCE, facts={}, head=head, body=body, details_head=head, details=body,
        below=(), no_slider="", conversion="", parts_head=(), parts=(), more_failed=0, doubts=0, thing="buoy", compared=True, animated=None, still="", at_force=(), elsewhere=(), **values,
    )  # fmt: skip


def test_reader_drags_the_damper_and_the_table_follows(page, tmp_path):
    """Sliders, control laws, sorted tables and values under the pointer in one visit."""
    script = """
      const part = (name) => document.querySelector(`#live [data-part="${name}"]`);
      const rows = () => [...part("rows").rows].map((row) => [...row.cells].map((cell) => cell.textContent));
      const drag = (name, value) => { part(name).value = value; part(name).dispatchEvent(new Event("input")); };
      const pick = (name, value) => { part(name).value = value; part(name).dispatchEvent(new Event("change")); };
      const found = { errors, hidden: document.getElementById("live").hidden, own: rows() };
      found.keys = [...part("rows").querySelectorAll(".key path")].map((line) => line.getAttribute("stroke"));
      drag("damper", Math.log(8000));
      found.dragged = rows();
      pick("take-off", "matched");
      found.matched = rows();
      pick("sea", 1);
      drag("period", 9);
      part("given").click();
      found.sea = rows();
      found.within = part("within").disabled;
      const curve = part("over-damper").querySelector("[data-curve]").getBoundingClientRect();
      const at = { bubbles: true, clientX: curve.x + curve.width / 2, clientY: curve.y + curve.height / 2 };
      part("over-damper").dispatchEvent(new PointerEvent("pointermove", at));
      found.tip = document.querySelector(".tip").innerText;
      document.querySelectorAll("#comparison th button")[1].click();
      found.sorted = [...document.querySelectorAll("#comparison table tbody tr")].slice(0, 3).map((row) => row.cells[1].textContent);
      return found;"""
    found = asked(page, script, tmp_path)
    assert found["errors"] == []
    assert not found["hidden"]
    assert found["keys"] == [style(name, list(POWERS), "FSB")["color"] for name in POWERS], (
        "names stand beside their lines"
    )
    swell = np.array([0.04])
    best = [best_dampers(port, swell[None]) for port in ports(SWELL).values()]
    assert [float(row[2]) for row in found["own"]] == pytest.approx([one.power[0] for one in best], rel=1e-3)
    assert [float(row[2]) for row in found["dragged"]] == pytest.approx([p[1] for p in powers(SWELL, swell)], rel=1e-3)
    matched = [0.04 * float(port.matched_power[0]) for port in ports(SWELL).values()]
    assert [float(row[2]) for row in found["matched"]] == pytest.approx(matched, rel=1e-3)
    assert [row[3] for row in found["matched"]] == ["\N{EN DASH}"] * 2
    longer = Jonswap(kind="jonswap", hs=1.0, tp=9.0).components(12.0, 100.0)[1][OMEGA > 0.2] ** 2
    expected = [p[1] for p in powers(KNOWN, longer)]
    assert [float(row[2]) for row in found["sea"]] == pytest.approx(expected, rel=1e-3)
    gain = 100 * (expected[1] / expected[0] - 1)
    assert float(found["sea"][1][1].replace("\N{MINUS SIGN}", "-")) == pytest.approx(gain, abs=0.051)
    assert found["within"], "a stored optimum is of the sea as it was"
    assert found["tip"].startswith("damping [N s/m]: ")
    assert "FSB: " in found["tip"]
    assert found["sorted"] == ["\N{MINUS SIGN}3", "20", "100"]


def test_force_limit_steps_through_stored_optima(page, tmp_path):
    """Only in the sea they belong to."""
    script = """
      const part = (name) => document.querySelector(`#live [data-part="${name}"]`);
      const rows = () => [...part("rows").rows].map((row) => [...row.cells].map((cell) => cell.textContent));
      const pick = (name, value) => { part(name).value = value; part(name).dispatchEvent(new Event("change")); };
      const drag = (name, value) => { part(name).value = value; part(name).dispatchEvent(new Event("input")); };
      const shown = () => ["dampers", "limits"].map((name) => part(name).checkVisibility());
      const found = { errors, none: part("limited").hidden, damper: shown() };
      pick("sea", 1);
      pick("take-off", "limited");
      found.last = [rows(), part("limit-says").textContent];
      drag("limit", 0);
      found.first = [rows(), part("limit-says").textContent, part("over-damper").getAttribute("aria-label")];
      Object.assign(found, { limited: shown(), band: part("over-band").checkVisibility() });
      drag("period", 9);
      found.moved = [part("take-off").value, part("limited").disabled, part("over-band").checkVisibility()];
      return found;"""
    found = asked(page, script, tmp_path)
    assert (found["errors"], found["none"], found["damper"]) == ([], True, [True, False])
    (last, says), (first, least, words) = found["last"], found["first"]
    assert [row[2:4] for row in last] == [["70", "\N{EN DASH}"], ["107", "\N{EN DASH}"]]
    assert last[1][1] == f"+{100 * (107 / 70 - 1):.1f}"
    assert says == "1.2 kN, 100 % of what optimal damping of FSB needs; waves assumed to repeat after 106.5 s"
    assert [row[2] for row in first] == ["20", "\N{EN DASH}"]
    assert least.startswith("0.3 kN, 25 %")
    assert "VSWEC at most 107 W at 1.2 kN" in words
    assert (found["limited"], found["band"]) == ([False, True], False)
    assert found["moved"] == ["damper", True, True]


WAVE_PERIOD = 4.0
WAVES = Sea(np.array([2 * np.pi / WAVE_PERIOD]), np.array([0.3 + 0.0j]))
TIME = np.linspace(0.0, 60.0, 6001)
LABELS = ["Heave", "Membrane0", "Membrane2"]


def unpacked(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def cosines(labels):
    position = np.array([(n + 1) * np.cos(2 * np.pi / WAVE_PERIOD * TIME) for n in range(len(labels))]).T
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


def frames(water=None, waves=WAVES):
    runs = {"FSB": cosines(LABELS[:1]), "VSWEC": cosines(LABELS)}
    return frames_data("a swell", runs, waves, (0.0, 60.0), WAVE_PERIOD, View(3.4), water or Water(), LABELS[1:])


def test_frames_show_the_last_periods_of_the_run():
    found = frames()
    time = found["start"] + found["step"] * np.arange(found["frames"])
    assert (time[0], time[-1]) == (pytest.approx(60.0 - PERIODS * WAVE_PERIOD), pytest.approx(60.0))
    assert found["frames"] == pytest.approx(PER_PERIOD * PERIODS, abs=2)
    rigid, shell = found["designs"]
    assert (rigid["modes"], shell["modes"], rigid["shell"]) == (0, 2, "")
    np.testing.assert_allclose(unpacked(rigid["heave"]), np.cos(2 * np.pi / WAVE_PERIOD * time), atol=1e-4)
    amplitudes = unpacked(shell["shell"]).reshape(-1, 2)
    np.testing.assert_allclose(amplitudes, np.cos(2 * np.pi / WAVE_PERIOD * time)[:, None] * [2, 3], atol=1e-3)


@pytest.mark.parametrize("depth", [np.inf, 3.0])
def test_surface_obeys_the_dispersion_relation(depth):
    """It is the incident elevation at the buoy's axis and travels towards x > 0."""
    water = Water(depth=depth)
    time, place = np.linspace(0, 8, 80, endpoint=False), np.array([0.0, 1.0])
    found = surface(WAVES, time, place, water)
    np.testing.assert_allclose(found[:, 0], WAVES.elevation(time), atol=1e-12)
    omega = WAVES.omega[0]
    delay = np.angle(np.exp(-1j * omega * time) @ found[:, 1] / (np.exp(-1j * omega * time) @ found[:, 0]))
    number = -delay  # later, not earlier: waves go to x > 0
    assert number * np.tanh(number * min(depth, 1e3)) == pytest.approx(omega**2 / 9.81, rel=1e-9)
    assert not surface(NO_WAVES, time, place, water).any()


@pytest.mark.parametrize("drift", [0.0, 0.2])
def test_surge_and_pitch_are_drawn_in_their_plane(drift):
    """Motions out of the plane are left out; surge is about its mean and its drift."""
    labels = ["Heave", "Membrane0", "Surge", "Pitch", "Membrane1c1", "Sway", "Membrane1s1"]
    place = xr.DataArray(50.0 + drift * TIME, {"time": TIME}, ("time",))
    drifting = cosines(labels) + place * xr.DataArray([0, 0, 1.0, 0, 0, 0, 0], {"dof": labels}, ("dof",))
    found = frames_data(
        "", {"A": drifting}, WAVES, (0.0, 60.0), WAVE_PERIOD, View(3.4), Water(), ["Membrane0", "Membrane1c1"]
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
    scripts = "".join(f"<script>{pages.text_of(name)}</script>" for name in pages.SCRIPTS)
    body = pages.page("buoys.html.j2", animated={"title": "Buoys", "words": words, "view": FROM_LEFT})
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


CENTRE = np.array([0.0, 0.0, 1.0])


def floating(*hulls):
    """Bodies that heave, and pitch about a point above still water, by hull and its place along y."""
    parts = []
    for hull, y in hulls:
        vertices, faces = hull_panels(hull)
        wet = wetted(vertices, faces)
        parts.append((wet.vertices + np.array([0.0, y, 0.0]), wet.faces))
    vertices, faces = joined(parts) if len(parts) > 1 else parts[0]
    shapes = np.array([np.tile([0.0, 0.0, 1.0], (len(vertices), 1)), np.cross([0.0, 1.0, 0.0], vertices - CENTRE)])
    return FlexibleBody(
        vertices, faces, ("Heave", "Pitch"), shapes[:, faces].mean(axis=2), shapes, centre_of_mass=CENTRE
    )


@pytest.fixture
def box():
    hull = BoxHull(kind="box", length=8.0, width=4.0, height=3.0, draft=2.0, panel=1.0)
    return cut(floating((hull, 0.0)))


def test_corner_of_a_box_moves_as_heave_and_pitch_do(box):
    """Linear: x + theta (z - z0), z + heave - theta x; a positive pitch takes the bow, x > 0, down."""
    heave, theta = np.array([0.0, 0.3]), np.array([0.0, 0.02])
    position = xr.DataArray(np.array([theta, heave]).T, {"dof": ["Pitch", "Heave"]}, ("time", "dof"))
    rest, moved = displaced_outline(box, position)
    ends = box.outline.values
    assert (ends.min(axis=(0, 1)), ends.max(axis=(0, 1))) == (pytest.approx([-4, 0, -2]), pytest.approx([4, 0, 0]))
    lengths = np.linalg.norm(rest[:, 1] - rest[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(8.0 + 2 * 2.0)
    corner = np.isclose(rest, [4.0, -2.0]).all(axis=-1)
    assert corner.sum() == 2, "of the bottom and of the bow"
    expected = [4.0 + 0.02 * (-2.0 - 1.0), -2.0 + 0.3 - 0.02 * 4.0]
    np.testing.assert_allclose(moved[corner], [expected, expected], atol=1e-12)


def test_every_part_is_cut_through_its_own_middle():
    """Two spheres beside each other: half circles of their radius, as well as panels are spheres."""
    sphere = SphereHull(kind="sphere", radius=3.0, draft=3.0, panel=0.5)
    ends = cut(floating((sphere, -5.0), (sphere, 5.0))).outline.values
    assert set(ends[..., 1].round(9).ravel()) == {-5.0, 5.0}
    np.testing.assert_allclose(np.linalg.norm(ends[..., ::2], axis=-1), 3.0, rtol=0.02)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(2 * 3.0 * np.pi, rel=0.02)
