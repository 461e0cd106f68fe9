import csv
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import bodies
from vsb.hydro.bodies.lid import interior_lid
from vsb.hydro.passive import PassiveFit


@pytest.fixture(scope="module")
def known():
    return bodies.known_poles()


def exact(known, step=0.1):
    """Motion with the memory that is known."""
    memory = PassiveFit(known.spectrum.model, 0.0, 0.0, 0.0, 0.0, known.samples.added_mass_inf)
    return bodies.followed(known, memory, step)


def test_followed_in_time_the_known_memory_gives_the_motion_of_the_frequency_domain(known):
    assert known.error(*exact(known)) < 1e-6


def test_a_whole_convolution_converges_to_it_with_the_second_order_of_its_steps(known):
    errors = [known.error(*bodies.convolved(known, step, 60.0)) for step in (0.2, 0.1)]
    assert errors[1] < 0.03
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_a_kernel_cut_off_early_misses_what_is_remembered(known):
    cut, whole = (known.error(*bodies.convolved(known, 0.05, window)) for window in (5.0, 60.0))
    assert cut > 10 * whole


def test_the_passive_memory_finds_the_known_poles_and_is_proven(known, monkeypatch):
    monkeypatch.setattr(bodies, "STEPS", (0.1,))
    monkeypatch.setattr(bodies, "WINDOWS", (20.0,))
    rows = bodies.motion_rows("known poles", known)
    passive, other = rows[-2], rows[-1]
    assert (passive["method"], passive["order"]) == ("passive", known.spectrum.model.order)
    assert passive["error"] < 1e-4
    assert passive["least_damping"] > passive["bound"] > -1e-7
    assert other["error"] > 1e3 * passive["error"]
    assert other["times_slower"] > 1.0


def test_a_ratio_is_to_ours_at_no_larger_an_error():
    rows = [
        {"method": "ours", "error": 1e-3, "seconds": 2.0},
        {"method": "ours", "error": 1e-2, "seconds": 1.0},
        {"method": "other", "error": 5e-3, "seconds": 6.0},
        {"method": "other", "error": 5e-2, "seconds": 3.0},
        {"method": "other", "error": 1e-4, "seconds": 9.0},
    ]
    assert [row["times_slower"] for row in bodies.with_ratios(rows, "ours")] == [None, None, 3.0, 3.0, None]


def test_panels_of_a_sphere_are_within_their_estimate_of_the_spectral_solver(green_folder, monkeypatch):
    monkeypatch.setattr(bodies, "ROWS", (4,))
    monkeypatch.setattr(bodies, "NODES", (12,))
    monkeypatch.setattr(bodies, "REFERENCE_NODES", 20)
    spectral, panels = bodies.coefficient_rows(green_folder)
    assert spectral["error"] < 1e-5 < panels["error"] < panels["estimate"]
    assert panels["times_slower"] > 1.0


def test_two_barges_move_apart_or_as_one():
    """Twelve rigid motions and the bending modes of both: none moves the other, both together are rigid."""
    body = bodies.barges(2, 2, 10.0, 1)
    assert len(body.labels) == 16
    assert body.labels[:2] == ("barge1__Surge", "barge1__Sway")
    left = body.vertices[:, 1] < 0
    assert not body.shapes[:8, ~left].any()
    assert not body.shapes[8:, left].any()
    heave = [body.labels.index(f"barge{i}__Heave") for i in (1, 2)]
    together = replace(body, labels=("Heave",), modes=body.modes[heave].sum(axis=0)[None],
                       shapes=body.shapes[heave].sum(axis=0)[None])  # fmt: skip
    assert list(together.rigid) == [0]
    assert len(interior_lid(body, 2)[1]) == 2 * len(interior_lid(bodies.barges(1, 2, 0.0, 1), 2)[1])


def test_the_table_holds_every_row(tmp_path, monkeypatch, known):
    monkeypatch.setattr(bodies, "coefficient_rows", lambda green: [{"case": "sphere", "error": 0.5}])
    monkeypatch.setattr(bodies, "motion_rows", lambda name, floating: [{"case": name, "seconds": 1.0}])
    monkeypatch.setattr(bodies, "CASES", {"known poles": lambda green: known})
    rows = bodies.benchmark(tmp_path)
    with (tmp_path / "bodies.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [row["case"] for row in table] == [row["case"] for row in rows] == ["sphere", "known poles"]
    assert tuple(table[0]) == bodies.COLUMNS
    assert np.isclose(float(table[0]["error"]), 0.5)
