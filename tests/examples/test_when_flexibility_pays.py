"""The map of when flexibility pays, for one shell and two periods."""

import csv
import itertools

import numpy as np
import pytest
from conftest import varied

from examples import when_flexibility_pays as example
from vsb.keys.quantities import canonical
from vsb.study.vary import scaled


def small(seed):
    return varied(seed, modes={"degree": 2}, hydro={"omega_max": 6.0})


@pytest.fixture(scope="module", autouse=True)
def fewer_limits():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(example, "LIMITS", (0.1, 1.0, np.inf))
        yield


@pytest.fixture(scope="module")
def rows(tmp_path_factory, seed):
    folder = tmp_path_factory.mktemp("map")
    (folder / "small.yaml").write_text(canonical(small(seed).model_dump(exclude_none=True)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(example, "PERIODS", (3.06, 5.0))
        patch.setattr(example, "SOFTNESS", (1.0, 4.0))
        found = example.mapped({"vented": str(folder / "small.yaml")}, folder)
        figure = example.drawn(found)
    assert len(figure.axes) == 2 * len(example.LIMITS) + 1
    figure.draw_without_rendering()
    (upper,) = figure.axes[0].child_axes
    lower = figure.axes[0].get_xlim()
    assert upper.get_xlim() == pytest.approx([2 * x for x in lower])
    return found


def test_unlimited_force_makes_the_shell_irrelevant(rows):
    """With one radiation channel the maximum power is the same whatever the shell, less its structural loss."""
    free = [row.gain_percent for row in rows if np.isinf(row.force_limit)]
    assert len(free) == 8
    assert all(-1.0 < gain < 0.0 for gain in free)


def test_power_grows_with_the_force_limit_and_the_shell_helps_at_small_force(rows):
    cases = {(row.young_modulus, row.wave, row.period) for row in rows}
    for case in cases:
        here = [row for row in rows if (row.young_modulus, row.wave, row.period) == case]
        assert [row.force_limit for row in here] == list(example.LIMITS)
        for name in ("rigid_power", "flexible_power"):
            powers = [getattr(row, name) for row in here]
            assert all(less < more for less, more in itertools.pairwise(powers))
        assert here[0].gain_percent > 1.0
        assert max(row.gap for row in here) <= 0.005


def test_stiffer_shell_gains_less_and_buckles_later(rows):
    soft, stiff = ([row for row in rows if row.young_modulus == e] for e in (10e6, 40e6))
    assert all(a.gain_percent > b.gain_percent for a, b in zip(soft, stiff, strict=True) if a.force_limit == 0.1)
    assert stiff[0].buckling_factor == pytest.approx(4 * soft[0].buckling_factor, rel=1e-9)
    table = list(csv.reader(example.as_csv(rows).splitlines()))
    assert tuple(table[0]) == example.Row._fields
    assert len(table) == len(rows) + 1


def test_map_obeys_froude_scaling(rows, seed, tmp_path, monkeypatch):
    """Four times the size at twice the periods; lengths, Young's modulus and structural times scaled."""
    raw = scaled(small(seed).model_dump(exclude_none=True), example.SCALE)
    (tmp_path / "large.yaml").write_text(canonical(raw))
    monkeypatch.setattr(example, "PERIODS", (6.12,))
    monkeypatch.setattr(example, "SOFTNESS", (1.0,))
    large = example.mapped({"vented": str(tmp_path / "large.yaml")}, tmp_path)
    here = [row for row in rows if (row.young_modulus, row.period) == (10e6, 3.06)]
    assert [row.young_modulus for row in large] == [40e6] * len(here)
    gains = [[row.gain_percent for row in some] for some in (large, here)]
    assert gains[0] == pytest.approx(gains[1], rel=1e-3, abs=0.01)
    assert large[0].rigid_power == pytest.approx(here[0].rigid_power * example.SCALE**3.5, rel=1e-3)


def test_unit_of_force_in_closed_form(seed):
    """|Z| |V| at c = |Z| in a regular wave."""
    omega = np.array([2.0])
    port = example.Port(omega, np.array([1e-5 + 2e-5j]), np.array([0.3 + 0.1j]), 0.0)
    velocity = port.velocity / (1 + port.admittance * port.best_damping)
    exact = float(np.abs(port.best_damping * velocity)[0] / np.sqrt(2))
    waves = example.Sea(omega, np.array([1.0 + 0j]))
    assert example.best_damper_force(port, waves, np.array([0])) == pytest.approx(exact, rel=0.02)
