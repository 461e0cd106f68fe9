"""Derivatives of a design against differences, scaling laws and limits that are known in closed form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.design.conftest import campaigns_buoy, study_of
from vsb.design.compared import Buoy
from vsb.design.evaluation import DesignModel
from vsb.design.linearised import linearised
from vsb.design.optimise import Optimum, left_out
from vsb.design.problem import spread
from vsb.design.resting import RestingBuoy
from vsb.design.searched import judged_at_rest
from vsb.design.take_offs import SeveralYear
from vsb.design.year import FrequencyGrid, YearMotion
from vsb.engine.motion.take_off import SeveralPorts
from vsb.engine.motion.tuning import best_matrix, powers_of_all, priced_matrix
from vsb.engine.waves.climate import Climate
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.rest import stiffness_about
from vsb.study.campaign import sections
from vsb.study.design import PARTS, Fatigue
from vsb.study.resolution import expected_change, loaded_at_ring
from vsb.study.sections import Modes

RUBBER = {
    "device": {
        "material": {"law": "gent", "mu": 5e6, "jm": 3.0}, "young_modulus": None, "poisson_ratio": None, "thickness": 0.02,
    }
}  # fmt: skip
CLAMP = "designs.VSWEC90.clamp"
PORT = {"designs": {"VSWEC": {}, "VSWEC90": {"clamp": 80}}}
SPHEROID = {
    "reference_shape": "undeformed", "designs": {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 80}},
    "device": {"internal_pressure": 0.0, "thickness": 0.05, "young_modulus": 3e7, "shape": {"spheroid": {"height": 3.0}}},
}  # fmt: skip
OPENED = SPHEROID | {"device": SPHEROID["device"] | {"gas": {}}, "pto": {"port": "volume"}}
CAPSULE = SPHEROID | {"device": SPHEROID["device"] | {"shape": {"capsule": {"length": 1.0}}}}
INFLATED = CAPSULE | {"reference_shape": "equilibrium", "device": CAPSULE["device"] | {"internal_pressure": 2e4}}
EGG = [[np.sin(a) * (1 + 0.1 * np.cos(a)), np.cos(a)] for a in np.linspace(0.0, np.pi, 13)[1:-1]]
EGG = CAPSULE["device"] | {"internal_pressure": 2e4, "shape": {"profile": [[0.0, 1.0], *EGG, [0.0, -1.0]]}}
SERIES = {"radial": [1.0, 0.1, 0.04], "axial": [0.9, -0.05, 0.02]}
SERIES = INFLATED | {"device": INFLATED["device"] | {"shape": {"series": SERIES}}}
INFLATED_EGG = CAPSULE | {"reference_shape": "equilibrium", "device": EGG}
BELT = {"strain": "hoop", "belt": [60, 120]}
SEVERAL = {
    "full": {"ports": {"h": "heave", "v": "volume"}}, "spread": {"port": {"distributed": "membrane"}},
    "diagonal": {"ports": {"r": {"colatitude": 120}, "b": BELT, "v": "volume"}, "matrix": "diagonal"},
}  # fmt: skip
LENGTHS = {
    "device.radius": 1, "device.thickness": 1, "device.young_modulus": 1, "device.internal_pressure": 1,
    "device.mass": 3, "device.poisson_ratio": 0, "device.density": 0,
}  # fmt: skip
"""Exponents of the scale in Froude's law, at the same water and gravity."""


def model_of(study, design, climate, variables):
    """A model of fewer frequencies and nodes: derivatives are those of the discrete model."""
    profile = study.device.shape is not None and study.device.shape.profile
    grid, fatigue = FrequencyGrid.of(climate, 12.0, 8, 3), Fatigue(exponent=4.0, strain=0.1)
    several = isinstance(study.pto.port, SeveralPorts) or study.opens_chamber
    degree, nodes = study.modes.max_degree if study.flexible else 1, 64 if profile else 28
    plain = DesignModel(study, design, climate, tuple(variables), degree, nodes, grid)
    return plain if several else replace(plain, fatigue=fatigue)


def scales(model):
    """Sizes of the variables."""
    return np.array([abs(value) or 1e4 for value in model.point])


def differences(model, direction, part):
    """Derivatives of all quantities in a direction, central differences extrapolated by Richardson."""
    point = np.array(model.point)

    def at(values):
        """All quantities without derivatives, which take most of the time; a damper given would be sought then."""
        if "pto.damping" in model.variables:
            return model.at(values).quantities
        return replace(model, study=model.study_at(values), variables=()).at(()).quantities

    def central(step):
        up, down = (at(point + sign * step * direction) for sign in (1, -1))
        return {name: (up[name].value - down[name].value) / (2 * step) for name in up}

    fine, coarse = central(part), central(2 * part)
    return {name: (4 * fine[name] - coarse[name]) / 3 for name in fine}


@pytest.mark.parametrize(
    ("design", "changes", "keys"),
    [
        ("VSWEC", {}, "device.radius device.internal_pressure device.damping.beta"),
        ("VSWEC90", {"designs": {"VSWEC90": {"clamp": 80}}, "water": {"depth": 4.0}}, f"{CLAMP} device.poisson_ratio"),
        ("VSWEC", {"device": {"gas": {}}}, "device.thickness"),
        ("FSB", {"pto": {"stiffness": -5e3}}, "device.mass pto.stiffness"),
        ("VSWEC", {"reference_shape": "undeformed"}, "device.mass"),
        ("VSWEC90", {"pto": {"stiffness": -5e3, "damping": 1e5}}, "pto.damping"),
        ("VSWEC", {"pto": {"stiffness": -3e4, "efficiency": 0.8}}, "device.internal_pressure pto.stiffness"),
        ("VSWEC90", {"pto": {"stiffness": -5e3, "damping": 1e5, "efficiency": 0.8}}, "pto.damping"),
        ("VSWEC", PORT | {"pto": {"port": "volume"}}, "device.radius"),
        ("VSWEC90", PORT | {"pto": {"port": {"between": [0, 180]}}}, "device.internal_pressure"),
        ("VSWEC", PORT | {"pto": {"port": {"strain": "area"}, "held": {"place": "heave"}}}, "device.internal_pressure"),
        ("VSWEC90", PORT | {"pto": {"port": {"colatitude": 20}, "held": {"place": "ring", "colatitude": 110}}}, f"{CLAMP} pto.port.colatitude"),
        ("VSWEC90", PORT | {"pto": {"port": {"colatitude": 60, "direction": "radial"}}}, "pto.port.colatitude"),
        ("FSB", SPHEROID, "device.shape.spheroid.height"),
        ("VSWEC90", SPHEROID, f"device.radius device.mass {CLAMP}"),
        ("VSWEC", SPHEROID | {"pto": {"port": {"colatitude": 70, "against": "frame"}}}, "pto.port.colatitude device.shape.spheroid.height"),
        ("VSWEC", SPHEROID | {"pto": {"port": {"colatitude": 180}}}, "device.shape.spheroid.height"),
        pytest.param("VSWEC", CAPSULE, "device.radius", marks=pytest.mark.slow),
        pytest.param("FSB", CAPSULE, "device.shape.capsule.length", marks=pytest.mark.slow),
        pytest.param("VSWEC", INFLATED, "device.shape.capsule.length", marks=pytest.mark.slow),
        pytest.param("VSWEC", INFLATED_EGG, "device.internal_pressure device.radius", marks=pytest.mark.slow),
        ("VSWEC", SPHEROID | {"pto": SEVERAL["diagonal"]}, "device.shape.spheroid.height"),
        ("VSWEC", RUBBER | {"pto": SEVERAL["spread"]}, "device.material.mu"),
        ("VSWEC", PORT | {"pto": SEVERAL["spread"]}, "device.radius"),
        ("VSWEC90", PORT | {"pto": SEVERAL["spread"] | {"damping": 0.05}}, "pto.damping"),
        ("VSWEC", PORT | {"pto": {"port": {"strain": "area", "belt": [60, 120]}}}, "pto.port.belt.0"),
        ("VSWEC90", SPHEROID | {"pto": {"port": {"strain": "meridional", "belt": [30, 120]}}}, "pto.port.belt.1"),
        ("VSWEC", INFLATED | {"pto": {"port": BELT}}, "pto.port.belt.1 device.young_modulus device.internal_pressure"),
        ("VSWEC", SPHEROID | {"pto": {"port": {"between": [40, 150]}}}, "pto.port.between.0"),
        ("VSWEC", PORT | {"pto": {"ports": {"b": BELT, "v": "volume"}}}, "pto.port.ports.b.belt.0 device.internal_pressure"),
        ("VSWEC90", SERIES, "device.radius device.shape.series.radial.2 device.shape.series.axial.1"),
        ("VSWEC", PORT | {"device": {"gas": {}}, "pto": {"port": "volume"}}, "device.internal_pressure"),
        ("VSWEC", OPENED, "device.shape.spheroid.height"),
        ("VSWEC", RUBBER, "device.material.jm device.material.mu"),
    ],
)  # fmt: skip
def test_derivatives_are_those_of_differences(climate, monkeypatch, design, changes, keys):
    """By several variables at once in the direction of their sizes, each with a factor of its own."""
    monkeypatch.setattr("vsb.engine.shell.rings.FINER", 1)
    monkeypatch.setattr("vsb.engine.shell.lobes.LEAST", 10)
    study = study_of(**changes)
    model, kinked = model_of(study, design, climate, keys.split()), study.device.shape and loaded_at_ring(study, design)
    part = 1e-3 if kinked else 1e-5  # responses with kinks have ten digits, of two points seven
    direction = scales(model) * [1.0, -0.7, 0.55][: len(model.variables)]
    found, expected = model.at(model.point).quantities, differences(model, direction, part)
    tolerance = 3e-4 if kinked and "between" in keys else 1e-6
    for name, quantity in found.items():
        slope = quantity.gradient @ direction
        least = min(abs(quantity.gradient * direction), default=0.0)
        assert abs(slope - expected[name]) <= tolerance * max(abs(quantity.value), 0.1 * least), name


def test_a_rest_sought_from_a_close_one_is_that_of_the_growing_load(climate):
    """Of a shell that buckles on the way Newton's method finds another rest 3 cm off, which a study is refused."""
    rests, buckled = (study_of(device={"internal_pressure": pressure}) for pressure in (8.5e3, 8.0e3))
    near = RestingBuoy.of(rests, 6).modal_amplitude
    with pytest.raises(ConvergenceError, match="buckles at"):
        RestingBuoy.of(buckled, 6, near=near)
    model = model_of(study_of(), "VSWEC", climate, ["device.radius"])
    scatter = spread(model, study_of(device={"mass": 1.6e4}), None, {"draft": 3.0}, {"device.thickness": 0.1})
    assert scatter.shape == (1, 1)
    assert not model.rests  # those of a study of another mass are not its own


def test_an_optimum_whose_load_cannot_grow_is_not_accepted(climate):
    """Its study would be refused, however it was reached."""
    search = SimpleNamespace(base=sections(study_of()), variables=(SimpleNamespace(key="device.internal_pressure"),))
    for pressure, accepted in ((16.5e3, True), (8.0e3, False)):
        point = SimpleNamespace(values=np.array([pressure]))
        end = judged_at_rest(search, Optimum(point, 1.0, {}, 0.0, 0.0, (), (), True, "", 9), 6)
        assert end.accepted is accepted
        assert accepted or "buckles at" in end.message


def test_what_waves_do_not_matter_for_scales_by_froude(climate):
    model = model_of(study_of(), "VSWEC", climate, list(LENGTHS))
    found = model.at(model.point).quantities
    weights = np.array(list(LENGTHS.values())) * model.point
    powers = {"beam": 1, "draft": 1, "surface": 2, "volume": 3, "mass": 3, "static_strain": 0}
    for name, power in (powers | {f"load_factor_inverse_{i}": 0 for i in range(4)}).items():
        one, scale = found[name], np.abs(found[name].gradient * weights).max()
        assert one.gradient @ weights == pytest.approx(power * one.value, abs=1e-8 * scale), name


def test_cost_is_the_sum_of_what_is_priced(climate):
    model = model_of(study_of(), "VSWEC", climate, ["device.radius", "pto.damping"])
    prices = {"mass": 4.0, "force_rms": 0.3, "surface": 120.0}
    found = replace(model, cost=prices).at([2.0, 1e5])
    assert found["cost"].value == pytest.approx(sum(price * found[of].value for of, price in prices.items()))
    assert found["cost"].gradient == pytest.approx(sum(price * found[of].gradient for of, price in prices.items()))


def test_hull_of_a_sphere_has_its_measures(climate):
    """Beam 2 r, surface 4 pi r^2, volume 4 pi r^3/3 and the draft of the study, with their slopes."""
    study = study_of(designs={"FSB": {"flexible": False}})
    found, r = model_of(study, "FSB", climate, ["device.radius", "device.mass"]).at([2.0, 17170.0]), 2.0
    expected = {"beam": (2 * r, 2.0), "surface": (4 * np.pi * r**2, 8 * np.pi * r)}
    expected |= {"volume": (4 / 3 * np.pi * r**3, 4 * np.pi * r**2), "mass": (17170.0, 0.0)}
    for name, (value, slope) in expected.items():
        assert found[name].value == pytest.approx(value, rel=1e-9), name
        assert found[name].gradient[0] == pytest.approx(slope, rel=1e-9, abs=1e-9), name
    assert found["draft"].value == pytest.approx(study.draft, rel=1e-9)


def test_weight_hangs_on_the_mean_motion_of_a_shell_that_is_no_sphere():
    """Statics in the shell's own functions: a force m g on the mean of its motion, sum (m_j/m_0) q_j."""
    rest = RestingBuoy.of(study_of(**SPHEROID), 4)
    loaded, momentum, none = rest.loaded, rest.loaded.basis.integrated("mass")[0], 0 * rest.modal_amplitude
    assert np.abs(momentum[1:]).max() > 0.01 * momentum[0]
    force = loaded.force(none)
    stiffness = sum(stiffness_about(rest.study, loaded, none).values())
    assert rest.linear_rest == pytest.approx(np.linalg.solve(stiffness, force), rel=1e-9, abs=1e-12)


def test_a_rigid_sphere_in_long_waves_absorbs_its_stiffness():
    """P = w a^2 K/4 at c = K/w, a^2 = 2 S dw; K = rho g pi x^2 by the waterline's radius x, x^2 = r^2 - z^2.

    The cap below it holds the displaced volume, pi h^2 (3 r - h)/3 = m/rho with h = r - z: dz/dm = -1/(rho pi x^2) and
    dz/dr = 1 + h^2/x^2.
    """
    omega, radius, mass = 0.02, 2.0, 12000.0
    density, step = np.array([[0.0, 1.0, 0.0]]), 1e-3
    long = Climate.of_spectra(omega + step * np.array([-1.0, 0.0, 1.0]), density, np.ones(1), "long waves")
    study = study_of(designs={"FSB": {"flexible": False}}, device={"radius": radius, "mass": mass})
    model = model_of(study, "FSB", long, ["device.mass", "device.radius"])
    found, z = model.at(model.point), study.centre_height
    stiffness = 1025.0 * 9.81 * np.pi * (radius**2 - z**2)
    by_mass = 2 * 9.81 * z / (radius**2 - z**2)
    by_radius = 1025.0 * 9.81 * 2 * np.pi * (radius - z * (1 + (radius - z) / (radius + z)))
    power, damping = found["annual_mean_power"], found["damping"]
    assert damping.value == pytest.approx(stiffness / omega, rel=2e-3)
    assert power.value == pytest.approx(omega * 2 * step * stiffness / 4, rel=3e-3)
    for gradient, by in zip(power.gradient, (by_mass, by_radius), strict=True):
        assert gradient / power.value == pytest.approx(by / stiffness, rel=3e-3)


@pytest.mark.parametrize("mass", [8e3, 2.8e4])
def test_a_buoy_comes_back_from_its_stroke_over_the_pull_of_its_spring(climate, mass):
    """In still water a weak spring below zero holds a light buoy out of the water, a heavy one below it."""
    study = study_of(designs={"FSB": {"flexible": False}}, device={"mass": mass}, pto={"stiffness": -5e3})
    found = model_of(study, "FSB", climate, []).at([]).quantities
    held = Buoy("FSB", study, "FSB", None, {}).displacement_held
    pull = max(found[part].value for part in PARTS["spring_pull"])
    assert pull * held == pytest.approx(found["stroke_rms"].value, rel=1e-3)


def test_power_of_the_optimal_damper_does_not_change_with_the_damper(climate):
    best = model_of(study_of(), "VSWEC", climate, ["device.radius"]).at([2.0])
    model = model_of(study_of(), "VSWEC", climate, ["device.radius", "pto.damping"])
    given = model.at([2.0, best["damping"].value])
    power = best["annual_mean_power"]
    assert given["annual_mean_power"].value == pytest.approx(power.value, rel=1e-12)
    assert given["annual_mean_power"].gradient[0] == pytest.approx(power.gradient[0], rel=1e-9)
    assert abs(given["annual_mean_power"].gradient[1]) * best["damping"].value < 1e-9 * power.value


def test_power_after_conversion_is_that_of_each_sea(climate):
    """In every sea that of the engine, with the damper that absorbs most; without a spring eta times that at the port."""
    density = np.array([[0.4, 0.6, 0.0], [0.3, 0.0, 0.0], [0.0, 0.1, 0.2]])
    seas = Climate.of_spectra(climate.omega, density, np.array([0.5, 0.2, 0.3]), "three seas")
    study = study_of(pto={"stiffness": -3e4, "efficiency": 0.7})
    model = DesignModel.of(study, "VSWEC", seas, [])
    found, grid = model.at([]).quantities, model.grid
    port, band = (
        campaigns_buoy(model.study, model.grid, model.nodes).ports(0.0)["VSWEC"],
        np.searchsorted(seas.edges, grid.omega) - 1,
    )
    squares = 2 * density[:, band] * grid.variance / seas.mean_density[band]
    dampers = found["damping"].value * np.array([0.99, 1.0, 1.01])
    powers = powers_of_all(port, squares, dampers, np.full(3, -3e4), 0.7)
    year = powers @ seas.hours
    assert found["annual_mean_power"].value == pytest.approx(year[1], rel=1e-7)
    assert year[1] == year.max()
    plain, lossy = (
        model_of(study_of(pto={"efficiency": part}), "FSB", seas, []).at([]).quantities for part in (1.0, 0.7)
    )
    assert lossy["annual_mean_power"].value == pytest.approx(0.7 * plain["annual_mean_power"].value, rel=1e-12)
    assert lossy["damping"].value == pytest.approx(plain["damping"].value, rel=1e-9)


def test_what_cannot_be_evaluated_is_named(climate):
    for changes, design, keys, words in (
        ({}, "none", [], "design: received 'none'"),
        ({}, "FSB", ["device.colour"], "variables: received device.colour"),
        ({"pto": {"port": {"dofs": {"Heave": 1.0, "Membrane2": 0.5}}}}, "VSWEC", [], r"pto\.port.*no natural modes"),
        ({"pto": {"port": "volume"}, "device": {"gas": {}}}, "VSWEC", ["pto.stiffness"], r"pto\.stiffness"),
        ({"motion": "planar", "device": {"centre_of_mass": -0.5, "ballast_inertia": 1e4}}, "FSB", [], "motion"),
        ({"modes": {"basis": "membrane", "degree": 4}}, "VSWEC", [], "modes.basis"),
    ):
        with pytest.raises(ConfigError, match=words):
            DesignModel.of(study_of(**changes), design, climate, keys)
    with pytest.raises(ConfigError, match=r"pto\.port.*does not move"):
        model_of(study_of(pto={"port": "volume"}), "FSB", climate, []).at([])
    with pytest.raises(ConfigError, match=r"designs\.VSWEC90\.clamp"):
        model_of(study_of(), "VSWEC90", climate, [CLAMP]).at([0.0])
    model = model_of(study_of(), "VSWEC", climate, ["device.internal_pressure"])
    with pytest.raises(ConvergenceError, match="buckles"):
        model.at([-3.0e4])
    with pytest.raises(ConfigError, match=r"device\.thickness"):
        model_of(study_of(), "VSWEC", climate, ["device.thickness"]).at([0.3])


def test_a_buoy_that_does_not_rest_stably_has_no_power(climate):
    """The hydrostatic stiffness of a half-immersed sphere is rho g pi r^2; a thin soft spheroid buckles."""
    half, water = 2 / 3 * np.pi * 2.0**3 * 1025, 1025 * 9.81 * np.pi * 2.0**2
    model = model_of(study_of(reference_shape="undeformed", device={"mass": half}), "FSB", climate, ["pto.stiffness"])
    assert model.at([-0.99 * water])["annual_mean_power"].value > 0
    for spring in (-0.99, -1.01):  # a search looks beyond
        share = replace(model, beyond=True).at([spring * water])["spring_share"]
        assert [share.value, share.gradient[0] * spring * water] == pytest.approx([-spring, -spring], rel=1e-9)
    with pytest.raises(StabilityError, match=r"design FSB .* its least stiffness"):
        model.at([-1.01 * water])
    soft = SPHEROID | {"device": SPHEROID["device"] | {"thickness": 0.005, "young_modulus": 1e6}}
    with pytest.raises(StabilityError, match=r"design VSWEC .* its least stiffness"):
        model_of(study_of(**soft), "VSWEC", climate, []).at([])


@pytest.mark.parametrize(
    ("design", "changes"),
    [
        ("FSB", {}),
        ("VSWEC", {"pto": {"stiffness": 5e3}}),
        ("VSWEC90", SPHEROID),
        ("VSWEC90", SPHEROID | {"pto": {"port": {"colatitude": 70, "against": "frame"}}}),
        ("VSWEC", SPHEROID | {"pto": {"port": {"dof": "Heave"}}}),
        ("VSWEC", OPENED),
        ("VSWEC", {"reference_shape": "undeformed", "water": {"depth": 5.0}, "device": {"thickness": 0.1}}),
    ],
)
def test_the_year_is_that_of_a_campaign(climate, design, changes):
    """Natural modes, the study's ports and coefficients solved where the year is integrated."""
    study = study_of(**changes)
    model = DesignModel.of(study, design, climate, [])
    found, grid = model.at([]), model.grid
    port = campaigns_buoy(model.study, model.grid, model.nodes).ports(study.pto.stiffness)[design]
    damping = np.array([found["damping"].value * factor for factor in (0.99, 1.0, 1.01)])
    power = port.power(damping) @ (2 * grid.variance)
    assert found["annual_mean_power"].value == pytest.approx(power[1], rel=1e-7)
    assert power[1] == power.max()


@pytest.mark.parametrize(
    ("design", "changes", "take_off"),
    [("VSWEC90", SPHEROID, "full"), ("VSWEC", SPHEROID, "diagonal"), ("VSWEC", {}, "spread")],
)
def test_the_year_of_several_ports_is_that_of_a_campaign(climate, design, changes, take_off):
    """No damper matrix of the kind absorbs more in it, and no take-off more than V0^H (Re Y)^-1 V0/8."""
    model = DesignModel.of(study_of(**changes, pto=SEVERAL[take_off]), design, climate, [])
    found, squares = model.at([]), 2 * model.grid.variance
    ports = campaigns_buoy(model.study, model.grid, model.nodes).several_ports()[design]
    spread = take_off == "spread"
    dampers = found["damping"].value * np.eye(ports.velocity.shape[1]) if spread else found.dampers
    power = squares @ ports.power(dampers)
    assert found["annual_mean_power"].value == pytest.approx(power, rel=1e-7)
    best = best_matrix(ports, squares, "uniform" if spread else take_off)
    assert best.power == pytest.approx(power, rel=1e-9)
    assert power < squares @ ports.matched_power
    if spread:
        assert max(squares @ ports.power(dampers * factor) for factor in (0.99, 1.01)) < power


@pytest.mark.parametrize("matrix", [pytest.param("full", marks=pytest.mark.slow), "diagonal"])
def test_several_ports_share_the_force_they_are_allowed(climate, matrix):
    """The matrix of that force is the engine's; power less its price has the derivatives of differences."""
    ports = {"h": "heave", "r": {"colatitude": 100}}
    study, key = study_of(designs={"VSWEC": {}}, pto={"ports": ports, "matrix": matrix}), "device.internal_pressure"
    model = replace(model_of(study, "VSWEC", climate, [key]), fatigue=None)
    free = model.at(model.point)
    matrices = linearised(RestingBuoy.of(study, model.degree, "VSWEC"), "VSWEC", [], model.grid.solved, model.nodes)
    several, squares = SeveralYear(YearMotion(model.grid, *matrices, 0.0)).ports, 2 * model.grid.variance
    most = 0.5 * float(np.linalg.norm(several.force_rms(free.dampers, squares)))
    model = replace(model, most_force=most)
    found, expected = model.at(model.point), differences(model, scales(model), 1e-4)
    assert found["force_rms"].value == most
    assert np.linalg.norm(several.force_rms(found.dampers, squares)) == pytest.approx(most, rel=1e-6)
    power, best = found["annual_mean_power"], priced_matrix(several, squares, most, matrix)[0]
    assert power.value == pytest.approx(best.power, rel=3e-6)
    assert power.value < free["annual_mean_power"].value
    assert abs(power.gradient[0] * model.point[0] - expected["annual_mean_power"]) <= 1e-6 * power.value
    wider, closer = (
        replace(model, most_force=most * (1 + s)).at(model.point)["annual_mean_power"].value for s in (1e-3, -1e-3)
    )
    assert (wider - closer) / (2e-3 * power.value) == pytest.approx(found.worth["force_rms"], rel=1e-4)


def test_what_a_clamped_design_leaves_out_holds_the_power_of_all_degrees(climate):
    """To degree 9 the power is within what it allows for, and 20 times closer than that of modes alone, 1 % off."""
    vented = {"internal_pressure": 0.0, "thickness": 0.1, "young_modulus": 3e7}
    study = study_of(reference_shape="undeformed", device=vented)
    design, few, many = "VSWEC90", (9, 14, 20), 30
    power, damping = {}, 0.0
    for degree in few:
        at = study.model_copy(update={"modes": Modes(basis="full", degree=degree)})
        found = DesignModel.of(at, design, climate, []).at([])
        power[degree], damping = found["annual_mean_power"].value, damping or found["damping"].value
    grid = DesignModel.of(study, design, climate, []).grid
    whole = study.model_copy(update={"modes": Modes(basis="full", degree=many)})
    port = campaigns_buoy(whole, grid, 60).ports(0.0)[design]
    change = float(port.power(damping) @ (2 * grid.variance)) / power[9] - 1
    finer = [power[degree] / power[9] - 1 for degree in few[1:]]
    low, high = left_out(finer, expected_change(study, few[-1]))
    assert low < change < high
    assert abs(change) < 5e-4
    assert high - low < 5e-3


def test_numerical_errors_are_small(climate):
    model = DesignModel.of(
        study_of(water={"depth": 6.0}), "VSWEC", climate, ["device.radius", "device.internal_pressure"]
    )
    model = replace(model, fatigue=Fatigue(exponent=6.0, strain=0.1))
    found, finer = model.at(model.point), model.finer.at(model.point)
    for name in ("annual_mean_power", "force_rms", "stroke_rms", "damping", "damage"):
        one, other = found[name], finer[name]
        assert one.value == pytest.approx(other.value, rel=1e-8)
        np.testing.assert_allclose(one.gradient, other.gradient, rtol=1e-6)


def test_nodes_resolve_the_shortest_shell_modes(climate):
    """The first step to more nodes changes little, but not by round-off: a wavelength of degree 68 has few of them."""
    model = DesignModel.of(study_of(modes={"basis": "full", "degree": 68}), "VSWEC", climate, [])
    assert model.nodes > 68
