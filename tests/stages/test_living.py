"""The page of a study computes with the numbers the study was computed with."""

import base64
import json
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from browser import asked, evaluated
from conftest import varied
from scipy.integrate import quad

from vsb.report import html
from vsb.report.living import SHOWN
from vsb.results.force_steps import SHARES
from vsb.stages import living as module
from vsb.stages.living import MOST, _band, _integral, _jonswap, _longest, living_study
from vsb.study.study import RegularWave
from vsb.study.waves import Jonswap, PiersonMoskowitz, WhiteNoise
from vsb.tools.files import load
from vsb.waves.dispersion import wavenumber
from vsb.waves.seas import components


def living(plan, study=None, limited=()):
    """Data of the page of a study, or of another one of the same buoy."""
    return living_study(study or plan.study, plan.database_path, load(plan.response_files["response"]), limited)


@pytest.fixture
def tables(small):
    with open(f"{small.folder}/tables.json", encoding="utf-8") as file:
        return json.load(file)


def test_the_page_finds_the_optima_of_the_ladder(small, tables, tmp_path):
    data = living(small, limited=tables["within_limits"])
    expression = """data.seas.map((sea) => {
      const grid = unpackedGrid(data.grids[sea.grid]);
      const squares = seaSquares(sea, grid);
      return grid.ports.map((port) => power(port, squares, bestDamper(port, squares)));
    })"""
    found = evaluated([html.text_of("algebra.js")], expression, data, tmp_path)
    assert np.ravel(found) == pytest.approx([line["best_power"] for line in tables["equal_tuning"]], rel=1e-6)
    assert [design["name"] for design in data["designs"]] == list(small.study.designs)
    assert [design["name"] for design in data["designs"] if design["reference"]] == [small.study.reference_design]


@pytest.mark.parametrize(
    ("low", "high", "ends"), [(0.1, 6.0, (0.1, 3.1)), (0.5, 6.0, (0.5, 3.1)), (0.1, 2.55, (0.1, 2.5))]
)
def test_curves_end_where_no_design_takes_a_hundredth_of_the_most(low, high, ends):
    """A hundredth is left 1.1 rad/s from the peak."""
    omega = np.linspace(0.1, 6.0, 60)
    power = 3e3 * np.exp(-((omega - 2.0) ** 2) * np.log(100.0) / 1.1001**2) * np.array([[0.5], [1.0]])
    response = xr.Dataset({"best_power": (("design", "omega"), power)}, {"design": ["A", "B"], "omega": omega})
    shown = _band(response, low, high)
    assert (shown[0], shown[-1]) == pytest.approx(ends)


def test_seas_of_one_grid_share_its_ports(small):
    """Realisations are one sea, spectra are parameters, noise is not, still water is no sea."""
    waves = [
        {"kind": "jonswap", "hs": 1, "tp": 4, "realisations": 2}, {"kind": "pierson_moskowitz", "hs": 1, "tp": 4},
        {"kind": "white_noise", "hs": 1, "band": [1.0, 2.0]}, {"kind": "still"},
    ]  # fmt: skip
    data = living(
        small, varied(small.study, waves=waves), [{"design": "FSB", "sea": "jonswap_Hs1_Tp4_g3.3", "power": 7.0}]
    )
    assert [sea["grid"] for sea in data["seas"]] == [0, 0, 1]
    assert [sea["jonswap"] and sea["jonswap"]["gamma"] for sea in data["seas"]] == [3.3, 1.0, None]
    assert [sea["squares"] is None for sea in data["seas"]] == [True, True, False]
    assert [sea["limited"][0] for sea in data["seas"]] == [7.0, None, None]
    omega = np.frombuffer(base64.b64decode(data["grids"][0]["omega"]), "<f8")
    apart = np.diff(omega)  # a component holds the energy between its neighbours
    assert all(apart == pytest.approx(sea["jonswap"]["width"]) for sea in data["seas"][:2])


def test_seas_from_two_sides_have_ports_of_their_own(small):
    """A buoy that heaves, of which no study asks it, takes the same of both: two grids, two bands, equal numbers."""
    wave = RegularWave(kind="regular", amplitude=0.1, period=3.0)
    aside, higher = (wave.model_copy(update=more) for more in ({"direction": 90.0}, {"amplitude": 0.2}))
    data = living(small, small.study.model_copy(update={"waves": (wave, aside, higher)}))
    assert [(sea["grid"], sea["band"]) for sea in data["seas"]] == [(0, 0), (1, 1), (0, 0)]
    assert data["grids"][0] == data["grids"][1]
    assert data["bands"][0] == data["bands"][1]


def test_every_sea_has_optima_at_limits_of_force_unless_power_is_lost_on_the_way(small):
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "jonswap", "hs": 1, "tp": 4}]
    data = living(small, varied(small.study, waves=waves))
    for sea in data["seas"]:
        limits, powers = sea["steps"]["limits"], sea["steps"]["powers"]
        assert len(limits) == len(powers[0]) == len(SHARES)
        assert all(np.diff(power).min() > 0 for power in powers)
    lossy = living(small, varied(small.study, waves=waves, pto={"damping": 8000.0, "efficiency": 0.8}))
    assert [sea["steps"] for sea in lossy["seas"]] == [None, None]


def test_a_long_run_has_no_more_components_on_its_page(small):
    long = varied(small.study, simulation={"duration": 1e5, "window": [0.0, 1e5]})
    longest = _longest(len(long.designs), long.hydro.omega_max)
    assert longest * 1.1 * long.hydro.omega_max / (2 * np.pi) * len(long.designs) == pytest.approx(MOST)
    data = living(small, varied(long, waves=[{"kind": "jonswap", "hs": 1, "tp": 4}]))
    assert len(data["grids"][0]["omega"]) * len(long.designs) <= 11 * MOST


def test_what_no_damper_says_is_not_offered(small):
    still = varied(small.study, waves=[{"kind": "still"}])
    lossy = varied(small.study, pto={"damping": 8000.0, "stiffness": 100.0, "efficiency": 0.8})
    dry = varied(small.study, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    dragged = varied(small.study, drag={"heave": {"coefficient": 1.0, "area": 12.0}})
    for study in (still, lossy, dry, dragged):
        assert living(small, study) is None
    for pto in ({"stiffness": 100.0}, {"efficiency": 0.8}):  # a spring or losses alone leave the damper's power known
        assert living(small, varied(small.study, pto=pto)) is not None


def test_the_whole_page_has_no_errors_and_fits_a_phone(small, tmp_path):
    with open(f"{small.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = (
        "return { errors, wide: document.documentElement.scrollWidth, hidden: document.getElementById('live').hidden };"
    )
    assert asked(page, script, tmp_path, width=360) == {"errors": [], "wide": 360, "hidden": False}


def test_figures_can_be_read_on_a_phone(small, tmp_path):
    """Letters of figures and charts are 9 pixels high or more: drawings move sideways in boxes of their own."""
    with open(f"{small.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = """
      for (const folded of document.querySelectorAll("details")) folded.open = true;
      const size = (text) => {
        const { a, b } = text.getScreenCTM();
        return parseFloat(getComputedStyle(text).fontSize) * Math.hypot(a, b);
      };
      const least = (where) => Math.min(...[...document.querySelectorAll(`${where} svg text`)].map(size));
      return { drawn: least(".drawn"), charts: least(".chart"), wide: document.documentElement.scrollWidth };"""
    found = asked(page, script, tmp_path, width=360)
    assert found["wide"] == 360
    assert min(found["drawn"], found["charts"]) >= 9


@pytest.mark.parametrize(
    ("tp", "shortest", "longest"), [(4.0, 4.0, 2 * np.pi), (7.0, 7.0, 7.0), (9.0, 2.5 * np.pi, 9.0)]
)
def test_a_peak_may_be_moved_between_five_of_the_shortest_periods_and_half_of_the_longest(tp, shortest, longest):
    """Of a band from 0.5 to 4 rad/s; the sea's own peak is always among them."""
    sea = Jonswap(kind="jonswap", hs=1.5, tp=tp, gamma=2.0)
    found = _jonswap(sea, 0.01, (0.5, 4.0))
    assert (found["shortest"], found["longest"]) == pytest.approx((shortest, longest), rel=1e-12)
    assert (found["hs"], found["tp"], found["gamma"], found["width"]) == (1.5, tp, 2.0, 0.01)
    assert _jonswap(PiersonMoskowitz(kind="pierson_moskowitz", hs=1.5, tp=tp), 0.01, (0.5, 4.0))["gamma"] == 1.0


@pytest.mark.parametrize("gamma", [1.0, 3.3, 10.0])
def test_the_integral_of_a_spectrum_by_quadrature(gamma):
    """1/(4 * 1.25) without a peak; the bump is gamma to the power exp(-(x - 1)^2/(2 s^2)), s 0.07 below, 0.09 above."""

    def density(x):
        bump = gamma ** np.exp(-((x - 1) ** 2) / (2 * (0.07 if x <= 1 else 0.09) ** 2))
        return x**-5.0 * np.exp(-1.25 * x**-4.0) * bump

    whole = quad(density, 0.05, 1.0, epsabs=1e-12)[0] + quad(density, 1.0, 2.0)[0] + quad(density, 2.0, np.inf)[0]
    assert _integral(gamma) == pytest.approx(whole, rel=1e-4)
    assert gamma > 1 or whole == pytest.approx(0.2, rel=1e-9)


def test_ports_are_in_waves_of_their_own_direction_beside_the_spring(seed, monkeypatch):
    """Waves bring rho g v_g/2 per metre and square of amplitude; limits of force know all seas and the stroke."""
    monkeypatch.setattr(
        module, "headed", lambda linear, towards: SimpleNamespace(extended_port=partial(linear, towards))
    )

    def port(towards, omega, motions, direction):
        return SimpleNamespace(beside=lambda spring: (towards, list(omega), motions, direction, spring))

    water = {"density": 1000.0, "depth": 20.0, "gravity": 9.0}
    study = varied(seed, water=water, pto={"damping": 5e3, "stiffness": 700.0, "stroke_limit": 1.5})
    seen = module._Seen(study, SimpleNamespace(linear=port, motions={"A": "a", "B": "b"}, port="heave"))
    omega = np.array([0.3, 1.0, 2.0])
    grid = seen.grid(omega, 30.0)
    k = np.array([wavenumber(w, 20.0, 9.0) for w in omega])
    speed = omega / (2 * k) * (1 + 2 * k * 20.0 / np.sinh(2 * k * 20.0))
    assert grid.ports == {name: (30.0, [0.3, 1.0, 2.0], name.lower(), "heave", 700.0) for name in "AB"}
    found = next(value for value in vars(grid).values() if isinstance(value, np.ndarray) and value is not grid.omega)
    np.testing.assert_allclose(found, 0.5 * 1000.0 * 9.0 * speed, rtol=1e-9)
    asked = []

    def force_steps(wave, ports, **named):
        assert ports["B"](omega).beside(0.0) == (wave.direction, list(omega), "b", "heave", 0.0)
        asked.append((wave, named))
        return wave

    monkeypatch.setattr(module, "force_steps", force_steps)
    seas = [module.LivingSea(name, 0, None, None, {}, {}) for name in "abc"]
    wave = RegularWave(kind="regular", amplitude=0.1, period=3.0)
    waves = [wave.model_copy(update={"direction": direction}) for direction in (0.0, 30.0, 90.0)]
    assert [sea.steps for sea in seen.with_steps(seas, waves, (0.3, 2.0))] == waves
    named = {"reference": study.reference_design, "seas": 3, "stroke": 1.5, "band": (0.3, 2.0)}
    assert asked == [(wave, named) for wave in waves]


def test_a_reader_chooses_among_the_first_seas_by_the_names_of_their_families(seed):
    calm, sea = {"kind": "still"}, {"kind": "jonswap", "hs": 1, "tp": 4, "realisations": 2}
    regular = [{"kind": "regular", "amplitude": 0.1, "period": 3.0 + i} for i in range(module.SEAS)]
    study = varied(seed, waves=[calm, sea, *regular])
    found = module._seas(study)
    assert len(found) == module.SEAS
    assert list(found)[:2] == ["jonswap_Hs1_Tp4_g3.3", study.waves[3].label]
    assert list(found.values()) == [study.waves[1], *study.waves[3 : module.SEAS + 2]]


@pytest.mark.parametrize(("first", "ends"), [(0.2, (0.3, 4.0)), (0.5, (0.5, 4.0))])
@pytest.mark.parametrize(("pto", "steps"), [({"damping": 5e3}, True), ({"damping": 5e3, "efficiency": 0.8}, False)])
def test_a_page_is_of_all_directions_and_of_the_band_in_which_the_first_sea_s_response_is_known(
    seed, monkeypatch, first, ends, pto, steps
):
    """Of seas to 90, -30 and 90 degrees, in their order; forces may have components beyond the database, up to the highest of the runs."""
    wave = RegularWave(kind="regular", amplitude=0.1, period=3.0, direction=90.0)
    waves = tuple(
        wave.model_copy(update=more) for more in ({}, {"direction": -30.0}, {"amplitude": 0.2, "period": 4.0})
    )
    study, asked = varied(seed, pto=pto).model_copy(update={"waves": waves}), []
    database = xr.Dataset(coords={"omega": [first, 1.0, 4.0]})
    floating = SimpleNamespace(linear=SimpleNamespace(database=database))

    class Seen:
        """What is seen of a study, by its arguments."""

        def __init__(self, of, afloat):
            assert (of, afloat) == (study, floating)
            self.floating = floating

        def grid(self, omega, towards):
            return list(omega), towards

        def with_steps(self, seas, waves, within):
            asked.append((waves, within))
            return [f"steps of {sea.words}" for sea in seas]

    def sea(of, name, wave, known, highest, limited, grids):
        asked.append((name, known, highest, limited))
        grids.append((np.array([wave.omega]), wave.direction))
        return module.LivingSea(name, 0, None)

    monkeypatch.setattr(module, "_Seen", Seen)
    monkeypatch.setattr(module, "_sea", sea)
    monkeypatch.setattr(module, "afloat", lambda study, path: asked.append(path) or floating)
    monkeypatch.setattr(module, "band", lambda study, database: (0.0, 9.0))
    monkeypatch.setattr(module, "in_direction", lambda response, wave: (response, wave))
    monkeypatch.setattr(
        module, "_band", lambda given, low, high: asked.append((given, low, high)) or np.array([0.5, 1.5])
    )
    monkeypatch.setattr(module, "study_data", lambda *given: given)
    omega = np.array([0.0, 1.0, 2.0])
    response = xr.Dataset({"power_limit": ("omega", [10.0, 20.0, 60.0])}, {"omega": omega}, {"limit": "2 λ/2π"})
    grids, seas, bands, limit, *others = living_study(study, "path", response, "limited")
    labels = [wave.label for wave in waves]
    assert asked.pop(0) == "path"
    assert [asked.pop(0) for _ in waves] == [(label, (first, 4.0), 9.0, "limited") for label in labels]
    if steps:
        assert asked.pop(0) == (list(waves), (first, 9.0))
        assert seas == [f"steps of {label}" for label in labels]
    else:
        assert [(sea.words, sea.band) for sea in seas] == list(zip(labels, (0, 1, 0), strict=True))
    assert asked == [((response, waves[0]), *ends)]
    assert grids == [([wave.omega], wave.direction) for wave in waves]
    assert bands == [([0.5, 1.5], 90.0), ([0.5, 1.5], -30.0)]
    assert limit.tolist() == [15.0, 40.0]
    assert others == [study.reference_design, study.pto.efficiency, "2 λ/2π"]
    monkeypatch.setattr(module, "_seas", lambda study: {})
    assert living_study(study, "path", response, "limited") is None


def test_a_limit_without_a_name_is_a_wavelength_over_two_pi(small):
    response = load(small.response_files["response"])
    response.attrs.pop("limit", None)
    assert living_study(small.study, small.database_path, response, ())["bound"] == "λ/2π"


def test_a_sea_has_its_own_components_where_ports_are_known_on_the_first_grid_that_fits(seed):
    """Of one direction and of equal frequencies; dampers and optima within limits are of each design, of this sea."""
    designs = {"A": {"flexible": False}, "B": {}, "C": {"clamp": [90]}}
    pto = {"damping": {"A": 1e3, "B": 2e3, "C": 3e3}}
    study = varied(seed, designs=designs, pto=pto)
    wave = RegularWave(kind="regular", amplitude=0.3, period=3.0)
    turned = wave.model_copy(update={"direction": 90.0})
    limited = [
        {"design": "B", "sea": "mine", "power": "7.5"}, {"design": "A", "sea": "other", "power": 3.0},
        {"design": "C", "sea": "mine", "power": 9.0},
    ]  # fmt: skip
    grids = [(np.array([1.0]), 0.0), (np.array([wave.omega]), 90.0)]
    found = module._sea(study, "mine", wave, (0.5, 4.0), 6.0, limited, grids)
    assert (found.words, found.grid, found.jonswap) == (wave.description, 2, None)
    assert found.squares == pytest.approx([0.09])
    assert (found.given, found.limited) == ({"A": 1e3, "B": 2e3, "C": 3e3}, {"B": 7.5, "C": 9.0})
    assert [(on.tolist(), to) for on, to in grids[2:]] == [([wave.omega], 0.0)]
    assert module._sea(study, "turned", turned, (0.5, 4.0), 6.0, limited, grids).grid == 1
    assert module._sea(study, "again", wave, (0.5, 4.0), 6.0, limited, grids).grid == 2
    assert len(grids) == 3


@pytest.mark.parametrize(("duration", "taken"), [(60.0, 60.0), (1e5, None)])
def test_components_of_a_sea_are_those_of_its_run_between_the_ends_of_what_is_known(seed, duration, taken):
    """Of noise between 1 and 2 rad/s those from 1.2 to 1.7, squared; a run too long for a page has fewer."""
    study = varied(seed, simulation={"duration": duration, "window": [0.0, 0.5 * duration]})
    noise = WhiteNoise(kind="white_noise", hs=1.0, band=(1.0, 2.0))
    taken = taken or _longest(len(study.designs), 2.5)
    assert taken <= duration
    grids = []
    found = module._sea(study, "noise", noise, (1.2, 1.7), 2.5, (), grids)
    omega, amplitude = components(noise, 2.5, taken)
    kept = (omega >= 1.2) & (omega <= 1.7)
    assert 0 < kept.sum() < len(kept)
    ((on, to),) = grids
    np.testing.assert_array_equal(on, omega[kept])
    np.testing.assert_allclose(found.squares, amplitude[kept] ** 2, rtol=1e-12)
    assert (to, found.jonswap) == (noise.direction, None)
    swell = Jonswap(kind="jonswap", hs=1.5, tp=4.0)
    found = module._sea(study, "swell", swell, (1.2, 1.7), 2.5, (), grids)
    assert found.squares is None
    assert found.jonswap == _jonswap(swell, 2 * components(swell, 2.5, taken)[0][0], (1.2, 1.7))


def test_curves_are_of_the_best_of_all_designs_and_of_no_more_frequencies_than_are_shown():
    """The first design takes most, the second longest; both ends are among them."""
    omega = np.linspace(0.1, 6.0, 1000)
    power = np.array([1e3 * np.exp(-((omega - 2.0) ** 2) / 0.02), np.where(omega < 4.0, 20.0, 1.0)])
    response = xr.Dataset({"best_power": (("design", "omega"), power)}, {"design": ["A", "B"], "omega": omega})
    for one in (response, response.isel(design=[1, 0])):
        shown = _band(one, 0.1, 6.0)
        assert (shown[0], shown[-1]) == (omega[0], omega[omega < 4.0][-1])
        assert len(shown) <= SHOWN
        assert set(shown) <= set(omega)


def test_a_page_has_room_for_two_dozen_seas_and_ten_thousand_numbers_of_components():
    """More would make it heavy: numbers travel inside it."""
    assert (module.SEAS, MOST) == (24, 10_000)
