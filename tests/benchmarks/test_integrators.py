"""Baseline discs, order of the quadratures, errors of the integrators, the table and its figures. No timings."""

import csv
import io
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import varied

from benchmarks import integrators as workprecision
from benchmarks import quadrature as riemann
from benchmarks.general_solvers import Equation, solved
from benchmarks.integrators import (
    COLUMNS,
    EXPONENTIAL,
    FIGURES,
    PLAIN,
    SOLVERS,
    TOLERANCES,
    benchmark,
    case_of_design,
    integrator_precision,
    plain_rates,
    precision_figure,
)
from benchmarks.quadrature import (
    disc_area,
    disc_force,
    disc_volume,
    fitted_order,
    gauss_force,
    quadrature_precision,
    scene_of_design,
    typical_state,
)
from vsb.errors import ConfigError
from vsb.motion.system import System
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import rigid_basis
from vsb.study import study as config

PAPER = Path(__file__).parents[2] / "config" / "paper.yaml"


@pytest.fixture(scope="module", autouse=True)
def short():
    """Fewer discs and less plain motion than in a benchmark."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(riemann, "DISCS", (10, 32, 100, 316, 1000, 3162, 10_000))
        patch.setattr(workprecision, "PLAIN_SPAN", 0.2)
        yield


@pytest.fixture(scope="module")
def paper():
    """The paper's study, two seconds of it."""
    return varied(config.load(PAPER), simulation={"duration": 2.0, "window": [1.0, 2.0]}, published=None)


@pytest.fixture(scope="module")
def deformed(paper):
    """The free shell in a typical deformed state."""
    scene = scene_of_design(paper, "VSWEC")
    return DeformedShell(scene.water.shell.basis, paper.centre_height, typical_state(scene))


@pytest.fixture(scope="module")
def measured(paper):
    return {design: integrator_precision(paper, design) for design in ("FSB", "VSWEC0")}


@pytest.fixture(scope="module")
def quadrature(paper):
    return quadrature_precision(paper)


def errors(rows, case, method):
    return np.array([row["error"] for row in rows if (row["case"], row["method"]) == (case, method)])


def test_the_state_is_deformed_and_half_out_of_the_water(deformed):
    q = deformed.modal_amplitude
    assert 0.01 < abs(q[0]) < 0.4
    assert np.all(np.abs(q[1:]) > 1e-4)
    assert abs(q[1]) == pytest.approx(0.08, abs=0.03)  # breathing under the static load
    ((top, keel),) = deformed.wet_segments
    assert 1.0 < top < 2.0
    assert keel == np.pi


# discs ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [1.7, 1.0, 0.3, -0.4, -1.2])
@pytest.mark.parametrize("discs", [7, 40, 333])
def test_lower_and_upper_sums_bracket_a_sphere_cap(paper, height, discs):
    depth = 2.0 - height
    sphere = DeformedShell(rigid_basis(paper.device), height)
    for found, exact in (
        (disc_volume(sphere, discs), np.pi * depth**2 * (3 * 2.0 - depth) / 3),
        (disc_area(sphere, discs), 2 * np.pi * 2.0 * depth),
    ):
        assert found.lower < exact < found.upper * (1 + 0.5 / discs**2)  # a radius largest inside a disc, a chord
        assert found.mean == (found.lower + found.upper) / 2


def test_a_dry_sphere_has_no_discs_and_a_drowned_one_all(paper):
    dry, drowned = (DeformedShell(rigid_basis(paper.device), height) for height in (2.5, -2.5))
    assert disc_volume(dry, 50) == disc_area(dry, 50) == (0.0, 0.0)
    assert np.all(disc_force(dry, 50)[0] == 0.0)
    assert disc_volume(drowned, 2000).mean == pytest.approx(4 / 3 * np.pi * 8, rel=1e-6)
    assert disc_area(drowned, 2000).mean == pytest.approx(4 * np.pi * 4, rel=1e-6)
    assert disc_force(drowned, 20000)[0][0] == pytest.approx(4 / 3 * np.pi * 8, rel=1e-3)


def test_discs_are_of_first_order(deformed):
    """The force in every refinement; volume and area, which scatter with the disc the waterline cuts, in the mean."""
    counts = np.array([100, 200, 400, 800, 1600, 3200, 6400])
    exact = deformed.hydrostatic_force(1.0, 1.0, 100)
    found = [np.linalg.norm(disc_force(deformed, int(n))[0] - exact) for n in counts]
    orders = -np.diff(np.log(found)) / np.diff(np.log(counts))
    assert len(orders) >= 4
    assert np.all(np.abs(orders - 1) < 0.05), orders
    for rule, true in ((disc_volume, deformed.volume(100)), (disc_area, deformed.wet_area(100))):
        spread = [
            np.sqrt(np.mean([(rule(deformed, int(n) + i).mean / true - 1) ** 2 for i in range(0, n // 2, n // 50)]))
            for n in counts
        ]
        assert abs(fitted_order(counts, spread) - 1) < 0.1


def test_equation_95_taken_literally_diverges_on_the_modes(paper):
    """Weight of the water of a disc over cos psi, along the normal: what `disc_force` says of it."""
    sphere = DeformedShell(scene_of_design(paper, "VSWEC").water.shell.basis, 0.0)
    true, found = sphere.hydrostatic_force(1.0, 1.0, 60), []
    for discs in (100, 1000, 10_000, 100_000):
        m = sphere.meridian(np.linspace(0.0, np.pi, discs + 1)[discs // 2 + 1 :])
        displaced = np.pi * m.x**2 * -np.diff(np.append(0.0, m.z))
        along = m.shape_z + m.dz / -m.dx * m.shape_x  # shape.normal/cos psi, the normal being (-z', x')
        found.append(along @ displaced)
    found = np.array(found)
    assert found[-1, 0] == pytest.approx(true[0], rel=1e-3)  # heave: Archimedes
    growth = np.diff(found[:, 1] / true[1])
    assert np.all(growth == pytest.approx(growth[-1], rel=0.02))  # breathing: logarithmic
    assert found[[0, -1], 1] / true[1] == pytest.approx([3.5, 10.4], abs=0.05)


def test_rectangle_gauss_and_compiled_forces_agree(paper, deformed):
    wet = scene_of_design(paper, "VSWEC").water.shell
    static, uniform, _ = (values[0] for values in wet.forces(deformed.modal_amplitude[None]))
    for rule, points, bound in ((gauss_force, 40, 1e-13), (disc_force, 20000, 2e-4)):
        ours = rule(deformed, points)
        assert np.linalg.norm(ours[0] - static) < bound * np.linalg.norm(static)
        assert np.linalg.norm(ours[1] - uniform) < 2 * bound * np.linalg.norm(uniform)
    assert gauss_force(deformed, 7)[0] == pytest.approx(deformed.hydrostatic_force(1.0, 1.0, 7), rel=1e-12)


# quadrature ----------------------------------------------------------------------------------------------------------


def test_quadrature_first_order_spectral_and_round_off(quadrature):
    for case in ("force", "volume", "wet area"):
        discs = [row for row in quadrature if (row["case"], row["method"]) == (case, "discs")]
        assert [row["setting"] for row in discs] == list(riemann.DISCS)
        assert discs[0]["order"] == pytest.approx(1.0, abs=0.05 if case == "force" else 0.25)
        gauss = errors(quadrature, case, "Gauss-Legendre")
        assert gauss[0] > 1e-6
        assert np.all(gauss[3:5] < 1e-2 * gauss[1:3])  # ten points: two digits for every two more
        assert np.all(gauss[6:] < 1e-13)
    for case in ("force", "volume"):
        assert errors(quadrature, case, "exact kernel") < 1e-13
    assert not errors(quadrature, "wet area", "exact kernel").size


def test_fitted_order_of_powers():
    n = np.array([10, 20, 40])
    assert fitted_order(n, 3.0 / n**2) == pytest.approx(2.0)


def test_quadrature_of_a_rigid_study(paper):
    rows = quadrature_precision(varied(paper, designs={"FSB": {"flexible": False}}))
    assert errors(rows, "force", "exact kernel") < 1e-13


# integrators ---------------------------------------------------------------------------------------------------------


def test_right_hand_sides_are_one(paper):
    scene = scene_of_design(paper, "VSWEC90")
    n = scene.motions.shape[1]
    state = 0.02 * np.random.default_rng(1).normal(size=2 * n)
    fast, plain = (
        Equation.of(System.of(scene), scene.start(0.0, 0.0)).rates(0.3, state),
        plain_rates(scene, gauss_force, 40)(0.3, state),
    )
    assert np.abs(fast - plain).max() < 1e-12 * np.abs(fast).max()
    discs = plain_rates(scene, disc_force, 20000)(0.3, state)
    assert 1e-8 < np.abs(fast - discs).max() / np.abs(fast).max() < 1e-2


@pytest.mark.parametrize("design", ["FSB", "VSWEC0"])
def test_errors_fall_with_the_tolerance(measured, design):
    for method, tolerances in {EXPONENTIAL: TOLERANCES, **SOLVERS}.items():
        rows = [row for row in measured[design] if row["method"] == method and row["table"] == "integrators"]
        assert [row["setting"] for row in rows] == list(tolerances)
        found = np.array([row["error"] for row in rows])
        assert np.all(found[1:] < 1.05 * found[:-1]), (method, found)
        assert found[-1] < 0.02 * found[0], (method, found)
        assert rows[-1]["error_energy"] < 1e-4


@pytest.mark.parametrize("design", ["FSB", "VSWEC0"])
def test_the_converged_solution_is_confirmed(measured, design):
    (check,) = (row for row in measured[design] if row["table"] == "reference")
    assert check["error"] < 1e-10
    assert check["error_energy"] < 1e-10


@pytest.mark.parametrize("design", ["FSB", "VSWEC0"])
def test_plain_forces_are_extrapolated_and_say_so(measured, design):
    found = {row["method"]: row for row in measured[design]}
    for method in PLAIN:
        row = found[method]
        assert row["status"] == "completed: 0.2 s of motion, seconds for the evaluations of compiled RK45"
        assert row["evaluations"] > 50
    assert found["RK45, NumPy"]["error"] < 1e-3 < found["RK45, discs"]["error"] < 0.1


def test_failures_are_results(paper):
    case = case_of_design(paper, "FSB")

    def explodes(t, state):
        return 1e3 * (1 + state**2)

    explosion = replace(case.equation, rates=explodes)
    for method in SOLVERS:
        late = solved(explosion, method, 1e-6, case.time, 0.0)
        assert late.status.startswith("stopped after its limit at t = "), late.status
        assert late.evaluations == 1
    broken = solved(explosion, "RK45", 1e-6, case.time, 20.0)
    assert "step size" in broken.status
    row = workprecision.measured(case, "FSB", "RK45", 1e-6, broken)
    assert row["seconds"] >= 0.0
    assert "error" not in row
    endless = replace(case.equation, rates=lambda t, state: np.full(2, np.inf))
    endless = solved(endless, "RK45", 1e-6, case.time, 0.2)
    assert endless.status != "completed"
    crushed = case_of_design(varied(paper, hydro={"pressure": 1e8}), "VSWEC").exponential(1e-8)
    assert "cannot be followed" in crushed.status


def test_without_take_off_there_is_no_energy_to_compare(paper):
    case = case_of_design(varied(paper, pto={"damping": 0.0}), "FSB")
    row = workprecision.measured(case, "FSB", EXPONENTIAL, 1e-6, case.exponential(1e-6))
    assert row["error"] < 1e-6
    assert row["error_energy"] is None


def test_other_models_and_still_water_are_refused(seed, paper):
    with pytest.raises(ConfigError, match=r"received hydro\.model 'linear'.*need assumed_pressure and a regular wave"):
        quadrature_precision(seed)
    with pytest.raises(ConfigError, match=r"seas \['still'\]; .*need assumed_pressure and a regular wave"):
        integrator_precision(varied(paper, waves=[{"kind": "still"}]), "FSB")


# output --------------------------------------------------------------------------------------------------------------


def test_table_and_figures(paper, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(workprecision, "TOLERANCES", (1e-3, 1e-5))
    monkeypatch.setattr(workprecision, "SOLVERS", {"RK45": (1e-3, 1e-5)})
    monkeypatch.setattr(workprecision, "PUBLISHED_DURATION", 2.0)
    one = varied(paper, designs={name: paper.designs[name].model_dump() for name in ("FSB", "VSWEC")})
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    benchmark(one, tmp_path)
    assert "integrators, VSWEC" in capsys.readouterr().err
    text = (tmp_path / "workprecision.csv").read_text()
    assert "nan" not in text.lower()
    rows = list(csv.DictReader(io.StringIO(text)))
    assert tuple(rows[0]) == COLUMNS
    assert {row["table"] for row in rows} == {"quadrature", "integrators", "reference", "paper"}
    for row in rows:
        assert row["status"].startswith("completed")
        assert float(row["error"]) >= 0.0
        assert float(row["seconds"]) > 0.0
    ours = {row["case"]: row for row in rows if row["table"] == "paper"}
    assert set(ours) == {"FSB", "VSWEC"}
    assert (float(ours["FSB"]["published_seconds"]), float(ours["VSWEC"]["published_seconds"])) == (126.6, 8640.0)
    for row in ours.values():
        assert float(row["ratio"]) == pytest.approx(float(row["published_seconds"]) / float(row["seconds"]), rel=1e-4)
        assert float(row["setting"]) == one.simulation.tolerance
    for name in FIGURES:
        assert (tmp_path / "workprecision" / f"{name}.svg").read_text().startswith("<?xml")


def test_figures_show_every_case_and_method_and_leave_out_failures(measured):
    rows = [row for found in measured.values() for row in found]
    failed = {**rows[0], "method": "RK45", "error": None, "status": "stopped"}
    figure = precision_figure([*rows, failed], "integrators", FIGURES["integrators"])
    panels = [ax for ax in figure.axes if ax.axison]
    assert [ax.get_title() for ax in panels] == ["FSB", "VSWEC0"]
    for ax in panels:
        assert {line.get_label() for line in ax.get_lines()} == {EXPONENTIAL, *SOLVERS, *PLAIN}
        assert ax.get_xscale() == ax.get_yscale() == "log"
        assert len({(line.get_color(), line.get_marker()) for line in ax.get_lines()}) == len(ax.get_lines())
