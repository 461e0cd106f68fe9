"""The flexible barge: beam modes, hydrostatics, convergence, and the body that is shipped."""

import numpy as np
import pytest
import yaml
from conftest import EXAMPLE
from scipy.integrate import quad
from scipy.special import roots_legendre

from examples import barge
from vsb.engine.hydro.bodies.build import build_body, read_body
from vsb.engine.hydro.bodies.families import free_free_root, free_free_shape
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.study.body import load_body
from vsb.tools.files import load

TABULATED = (4.730040744862704, 7.853204624095838, 10.99560783800167, 14.13716549125746)  # Blevins (1979), table 8-1
FINE = np.linspace(-1.0, 1.0, 2001)


@pytest.fixture(scope="module")
def box():
    """80 x 10 x 5 m."""
    return barge.Barge(length=80.0, beam=10.0, draught=5.0, centre_of_mass=-0.5, bending_stiffness=2e10)


def test_roots_are_the_tabulated_ones():
    assert [2 * free_free_root(n) for n in range(1, 5)] == pytest.approx(TABULATED, rel=1e-14)
    for n in (1, 2, 5, 9):
        b = 2 * free_free_root(n)
        assert np.cos(b) == pytest.approx(1 / np.cosh(b), abs=1e-12)


@pytest.mark.parametrize("n", [1, 200])
def test_shapes_solve_the_beam_equation_with_free_ends(n):
    """W = (t + h)/2 with t'' = -k^2 t and h'' = k^2 h: W'' = k^2 (W - t), W''' = k^2 (W' - t'), zero at both ends."""
    k = free_free_root(n)
    w, slope = free_free_shape(n, FINE)
    even = n % 2 == 1
    t = np.cos(k * FINE) / np.cos(k) if even else np.sin(k * FINE) / np.sin(k)
    dt = -k * np.sin(k * FINE) / np.cos(k) if even else k * np.cos(k * FINE) / np.sin(k)
    assert w[-1] == pytest.approx(1.0, abs=1e-12)
    assert w[::-1] == pytest.approx(w if even else -w, abs=1e-12)
    assert np.abs(w).max() <= 1.0 + 1e-12
    assert (w - t)[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert (slope - dt)[[0, -1]] / k == pytest.approx([0.0, 0.0], abs=1e-11)
    if n <= 41:
        h = np.cosh(k * FINE) / np.cosh(k) if even else np.sinh(k * FINE) / np.sinh(k)
        assert 2 * w - t == pytest.approx(h, abs=1e-12)


@pytest.mark.parametrize("n", [1, 30])
def test_slope_is_the_derivative(n):
    h = 1e-6
    (ahead, _), (behind, _), (_, slope) = (free_free_shape(n, 0.9 * FINE + d) for d in (h, -h, 0.0))
    scale = free_free_root(n) ** 3
    assert (ahead - behind) / (2 * h) == pytest.approx(slope, abs=h**2 * scale + 1e-9)


def test_shapes_are_orthogonal_with_a_quarter_of_the_mass():
    node, weight = roots_legendre(200)
    rows = [np.ones_like(node), node, *(free_free_shape(n, node)[0] for n in range(1, 13))]
    gram = np.einsum("is,js,s->ij", rows, rows, weight) / 2
    assert gram == pytest.approx(np.diag([1.0, 1 / 3, *[0.25] * 12]), abs=1e-12)


@pytest.mark.parametrize("n", [1, 4])
def test_modal_stiffness_is_the_strain_energy(box, n):
    k = free_free_root(n)

    def curvature(s):
        t = np.cos(k * s) / np.cos(k) if n % 2 else np.sin(k * s) / np.sin(k)
        return k**2 * (free_free_shape(n, np.array([s]))[0][0] - t)

    energy = quad(lambda s: curvature(s) ** 2, -1, 1, epsabs=1e-9)[0] * 8 / box.length**3
    assert box.stiffness[n + 1, n + 1] == pytest.approx(box.bending_stiffness * energy, rel=1e-10)


def test_hinge_mode_is_straight_halves_without_momentum(box):
    """Energies by quadrature over the length."""
    hinged = box.model_copy(update={"hinge_stiffness": 3e9})
    assert hinged.labels == (*box.labels, "Hinge")
    node, weight = roots_legendre(400)
    s = np.concatenate([(node - 1) / 2, (node + 1) / 2])
    moved = hinged.displacement(np.column_stack([40 * s, 0 * s, 0 * s]))[:, :, 2]
    gram = 1025.0 * 80 * 10 * 5 * np.einsum("is,js,s->ij", moved, moved, np.tile(weight, 2)) / 4
    assert gram == pytest.approx(hinged.mass(1025.0), rel=1e-10, abs=1e-5)
    assert hinged.mass(1025.0)[:-1, :-1] == pytest.approx(box.mass(1025.0))
    before, after = (hinged.displacement(np.array([[x, 0.0, 1.0]]))[-1, 0] for x in (-1e-3, 1e-3))
    assert abs(before - after)[0] == pytest.approx(1.5 * 8 / 80)  # a metre above the water, half a one above the mass
    assert hinged.stiffness[-1, -1] == pytest.approx(3e9 * (8 / 80) ** 2)
    assert hinged.stiffness[:-1, :-1] == pytest.approx(box.stiffness)
    assert not hinged.body(2, 1025.0).rigid.keys() - {0, 1}


def test_inextensible_bending_stiffness_in_closed_form(box):
    """U = B {int w^2/2 + T (T/2 + z_G) [int w'^2/2 - (w w') at the ends]}, coupling of modes included."""
    node, weight = roots_legendre(60)
    w, slope = np.array([free_free_shape(n, node) for n in range(1, 5)]).swapaxes(0, 1)
    end, turn = np.array([free_free_shape(n, np.array([-1.0, 1.0])) for n in range(1, 5)]).swapaxes(0, 1) * [
        [[1]],
        [[2 / 80.0]],
    ]
    size = box.length / 2 * weight
    edge = np.einsum("ie,je,e->ij", end, turn, [-1.0, 1.0])
    bracket = np.einsum("is,js,s->ij", slope, slope, size) * (2 / box.length) ** 2 - edge - edge.T
    draught = box.draught
    exact = box.beam * (np.einsum("is,js,s->ij", w, w, size) + draught * (draught / 2 + box.centre_of_mass) * bracket)
    found = hydrostatic_stiffness(box.body(3, 1.0), 1.0, 1.0)[2:6, 2:6]
    assert found == pytest.approx(exact, abs=2e-4 * np.abs(exact).max())


def test_power_law_is_recovered():
    n = np.array([2, 3, 4, 6, 8])
    values = np.array([1.0, -2.0]) + np.outer(n**-1.7, [0.5, 0.3])
    limit, order = barge.limit_and_order(n, values)
    assert limit == pytest.approx([1.0, -2.0], abs=1e-6)
    assert order == pytest.approx(1.7, abs=1e-5)


def study(folder, **changes):
    raw = {
        "barge": {"length": 20.0, "beam": 6.0, "draught": 2.0, "bending_stiffness": 1e8, "modes": 2},
        "omega": [0.9, 1.2],
        "panels": 2,
        "convergence": {"panels": [1, 2, 3, 4], "omega": 1.0},
    }
    (folder / "barge.yaml").write_text(yaml.safe_dump(raw | changes))
    return folder / "barge.yaml"


@pytest.mark.slow
def test_study_converges_at_second_order_and_draws(tmp_path, green_folder):
    checks = barge.study(study(tmp_path), tmp_path / "out", green_folder)
    assert {check.verdict for check in checks} <= {"ok", "doubt"}
    ds = load(tmp_path / "out/barge.nc")
    assert list(ds.influenced_dof.values) == ["Heave", "Pitch", "Bending1", "Bending2"]
    rows = [line.split(",") for line in (tmp_path / "out/convergence.csv").read_text().splitlines()[1:]]
    orders = {row[2]: float(row[4]) for row in rows}
    for quantity in ("added_mass", "radiation_damping", "excitation_force", "far_field", "haskind"):
        assert 1.2 < orders[quantity] < 2.8, orders
    estimate = {row[0]: float(row[3]) for row in rows if row[2] == "error_estimate"}
    for panels, _, quantity, error, _ in rows:
        assert quantity == "error_estimate" or float(error) < estimate[panels], (panels, quantity)
    assert (tmp_path / "out/barge.svg").read_text().lstrip().startswith("<?xml")


def test_shipped_body_is_what_the_script_writes():
    """The port of the shipped study is the bow."""
    located = load_body(EXAMPLE.with_name("barge.yaml"))
    found = read_body(located.files["mesh"], located.files["modes"])
    size = {"length": 80.0, "beam": 10.0, "draught": 5.0, "centre_of_mass": 0.0}
    box = barge.Barge(**size, bending_stiffness=2e10, hinge_stiffness=0.0)
    made = box.body(3, 1025.0)
    assert found.labels == made.labels
    for name in ("vertices", "faces", "shapes", "mass", "stiffness"):
        assert getattr(found, name) == pytest.approx(getattr(made, name), rel=1e-12, abs=1e-9)
    bow = box.displacement(np.array([[40.0, 0.0, 0.0]]))[:, 0, 2]
    assert [located.study.pto.port.dofs[label] for label in box.labels] == pytest.approx(bow)
    assert located.study.reference_design == "rigid"
    assert located.study.directions == (0.0, 45.0)
    hinge = load_body(EXAMPLE.with_name("hinged_barge.yaml"))
    assert hinge.study.pto.port.dofs == {"Hinge": 1.0}
    by_name = build_body(hinge.study.body.file, hinge.files)
    assert by_name.labels == found.labels
    for name in ("shapes", "mass", "stiffness"):
        expected = getattr(found, name)
        assert getattr(by_name, name) == pytest.approx(expected, rel=1e-7, abs=1e-10 * abs(expected).max())
