import os
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks import coefficients as hp


def row(method, seconds, error, setting=1):
    return {"method": method, "setting": setting, "seconds": seconds, "error": error, "status": "completed"}


# the truth ----------------------------------------------------------------------------------------------------------


def test_reference_has_converged_to_round_off():
    coarser = hp.reference(48)
    for name, exact in hp.reference().items():
        assert np.abs(coarser[name] - exact).max() < 1e-13 * np.abs(exact).max(), name


def test_reference_agrees_with_the_multipole_series_to_its_error(hemisphere):
    i, at = hemisphere["Ka"].index(1.0), hp.reference().sel(omega=1.0)
    for found, series in (
        (at.added_mass.values, hemisphere["added_mass"][i]),
        (at.radiation_damping.values, hemisphere["radiation_damping"][i]),
        (np.abs(at.Froude_Krylov_force + at.diffraction_force).values[0], hemisphere["abs_excitation"][i]),
    ):
        assert np.abs(found - np.array(series)).max() < 1e-5 * np.abs(series).max()


def test_errors_are_relative_to_the_largest_entry_of_each_frequency():
    exact = hp.reference()
    assert hp.errors(exact) == {"error": 0.0, "error_added_mass": 0.0, "error_damping": 0.0, "error_excitation": 0.0}
    wrong = exact.copy(deep=True)
    wrong["added_mass"][1, 2, 3] += 0.02 * np.abs(exact.added_mass[1]).max()
    wrong["diffraction_force"] = exact.diffraction_force + 0.01j * np.abs(
        exact.Froude_Krylov_force + exact.diffraction_force
    ).max("influenced_dof")
    found = hp.errors(wrong)
    assert found["error"] == found["error_added_mass"] == pytest.approx(0.02, rel=1e-12)
    assert found["error_damping"] == 0.0
    assert found["error_excitation"] == pytest.approx(0.01, rel=1e-12)


# methods ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def solved(green_folder):
    """Name -> coefficients of the coarsest mesh."""
    names = [name for name in hp.METHODS if name != hp.SPECTRAL]
    return {n: hp.METHODS[n].solve(6, str(green_folder), [float(w) for w in np.sqrt(hp.KA)]) for n in names}


def test_capytaine_of_every_symmetry_and_the_rings_agree_to_round_off(solved):
    """So their errors are one, and seconds and memory all that differs; 12 panels around alias the wave."""
    plain = solved[hp.PLAIN]
    for name in ("capytaine, two planes", hp.ROTATION, "rings"):
        for quantity, limit in (("added_mass", 1e-12), ("radiation_damping", 1e-12), ("Froude_Krylov_force", 1e-9)):
            value = solved[name][quantity].transpose(*plain[quantity].dims).values
            assert np.abs(value - plain[quantity].values).max() < limit * np.abs(plain[quantity].values).max()


def test_flux_correction_is_more_precise_on_the_same_panels(solved):
    plain, corrected = (hp.errors(solved[name])["error"] for name in ("rings", "rings, flux correction"))
    assert corrected < plain / 4


def test_capytaine_counts_the_seconds_of_its_matrices_alone(solved):
    assert solved[hp.PLAIN].attrs["seconds"] > 0
    assert "seconds" not in solved["rings"].attrs


def test_spectral_error_falls_faster_than_any_power():
    omegas = [float(w) for w in np.sqrt(hp.KA)]
    found = [hp.errors(hp.METHODS[hp.SPECTRAL].solve(n, "", omegas))["error"] for n in (6, 12, 24)]
    assert found[1] < found[0] / 30
    assert found[2] < found[1] / 1000


@pytest.mark.parametrize(
    ("method", "rows", "size"),
    [(hp.PLAIN, 40, 491.5e6), ("capytaine, two planes", 40, 122.88e6), (hp.ROTATION, 40, 6.144e6), ("rings", 40, 0.0)],
)
def test_matrices_of_a_method(method, rows, size):
    """3200 panels: three complex matrices, or the part of them that symmetry leaves."""
    assert hp.METHODS[method].matrix_bytes(rows) == pytest.approx(size, rel=1e-3)


# runs in processes of their own -------------------------------------------------------------------------------------


def threads(sender, *args):
    sender.send({"threads": os.environ["OMP_NUM_THREADS"], "args": args})


def dies(sender):
    os._exit(3)


def hangs(sender):
    time.sleep(60)


def test_a_process_of_its_own_reports_has_one_thread_and_leaves_ours_alone():
    before = os.environ.get("OMP_NUM_THREADS")
    assert hp._received(threads, 60.0, "a", 2) == {"threads": "1", "args": ("a", 2), "status": "completed"}
    assert os.environ.get("OMP_NUM_THREADS") == before


def test_failures_are_rows():
    assert hp._received(dies, 60.0) == {"status": "failed with exit code 3"}
    assert hp._received(hangs, 0.2) == {"status": "stopped after its limit of 0.2 s"}
    too_large = hp.attempt(hp.PLAIN, 80, "")
    assert too_large == {
        "method": hp.PLAIN, "setting": 80, "unknowns": 12800, "status": "not run: matrices of 7.9 GB, limit 1.5 GB"
    }  # fmt: skip


def test_a_measurement_is_complete():
    found = hp.measure(hp.SPECTRAL, 12, "")
    assert set(found) | {"method", "setting", "unknowns", "status"} == set(hp.COLUMNS)
    assert 1e-9 < found["error"] < 1e-3
    assert found["frequencies"] == len(hp.METHODS[hp.SPECTRAL].omegas) > hp.SWEEP
    assert found["seconds"] > 0


def test_memory_sees_what_numpy_takes_and_gives_back():
    assert hp._memory(lambda: np.ones(2_500_000).sum()) == pytest.approx(20.0, rel=0.2)


# ratios -------------------------------------------------------------------------------------------------------------


@given(st.floats(0.5, 3.0), st.floats(1.5, 200.0))
def test_ratios_of_two_power_laws(order, factor):
    """error = seconds^-order, the other method `factor` times faster: that much at every error, factor^order at every time."""
    seconds = np.geomspace(1.0, 1e6, 13)
    slow = [row(hp.PLAIN, t, t**-order) for t in seconds[5:8]]
    fast = [row("fast", t / factor, t**-order) for t in seconds]
    for found in hp.ratios(slow + fast):
        assert found["times_faster"] == pytest.approx(factor, rel=1e-9)
        assert found["times_more_precise"] == pytest.approx(factor**order, rel=1e-9)
        assert found["at_least"] == ""


def test_nothing_is_extrapolated():
    base = [row(hp.PLAIN, 1.0, 1e-2)]
    better = hp.ratios([*base, row("better", 1e-3, 1e-6)])[0]
    assert (better["times_faster"], better["times_more_precise"]) == pytest.approx((1e3, 1e4))
    assert better["at_least"] == "faster more precise"
    worse = hp.ratios([*base, row("worse", 2.0, 1e-1)])[0]
    assert (worse["times_faster"], worse["times_more_precise"], worse["at_least"]) == (0.0, 0.0, "")
    failed = {"method": "failed", "setting": 1, "status": "stopped"}
    assert hp.ratios([*base, failed])[0]["times_faster"] == 0.0


def test_a_slower_and_worse_run_is_no_point_of_the_curve():
    curve = hp.Curve.of([row("m", 1.0, 1e-3), row("m", 2.0, 1e-2), row("m", 4.0, 1e-4)], "m")
    assert list(curve.error) == [1e-3, 1e-3, 1e-4]
    assert curve.seconds_at(1e-2) == (1.0, True)


# output -------------------------------------------------------------------------------------------------------------


def test_tables_and_figure_of_a_benchmark(tmp_path, monkeypatch):
    """Every run of every method is a row, failed ones without numbers."""
    monkeypatch.setattr(hp.bem, "green_function", lambda folder: None)

    def attempt(name, setting, green):
        first = {"method": name, "setting": setting, "unknowns": 1}
        if setting == 80:
            return {**first, "status": "stopped"}
        return {**first, "error": 1.0 / setting, "seconds": 1e-3 * setting, "memory_mb": 0.0, "status": "completed"}

    monkeypatch.setattr(hp, "attempt", attempt)
    rows = hp.benchmark(tmp_path)
    assert len(rows) == sum(len(method.settings) for method in hp.METHODS.values())
    table = (tmp_path / "hydro_precision.csv").read_text().splitlines()
    assert table[0] == ",".join(hp.COLUMNS)
    assert sum(line.endswith(",,,,,,,,stopped") for line in table) == 5
    assert len(table) == len(rows) + 1
    ratios = (tmp_path / "hydro_precision_ratios.csv").read_text().splitlines()
    assert ratios[0] == ",".join(hp.RATIO_COLUMNS)
    svg = (tmp_path / "hydro_precision.svg").read_text()
    for text in (*hp.METHODS, "time per frequency [s]", "memory [MB]"):
        assert f"<!-- {text} -->" in svg
