"""Response amplitude operators and excitation: amplitudes in the units of their axes, phases without jumps."""

import io

import numpy as np
import pytest
import xarray as xr
from report import test_curves

from vsb.report.canvas import PORT
from vsb.report.figures import draw
from vsb.report.response_figures import phases

OMEGA = test_curves.OMEGA
DIMS = ("wave_direction", "design", "omega", "dof")
LABELS = ["Surge", "Sway", "Heave", "Pitch", "Bend", PORT]


def raos(headings=(0.0, np.pi / 4), port=2.0):
    """Motions that lag further at higher frequencies, the second design's and heading's by half and a third as much."""
    fading = np.exp(-((OMEGA - 1.5) ** 2)) * np.exp(1j * OMEGA)
    sizes = np.array([0.5, 1e-9, 1.0, 0.1, 3.0, port])
    by_heading, by_design = 1 / (1 + np.arange(len(headings)) / 2), np.array([1.0, 0.5])
    values = np.einsum("h,d,w,k->hdwk", by_heading, by_design, fading, sizes)
    return xr.DataArray(
        values,
        {"wave_direction": list(headings), "design": list(test_curves.DESIGNS), "omega": OMEGA, "dof": LABELS},
        DIMS,
    )


def drawn(name, **changes):
    given = test_curves.responding()
    return draw(name, test_curves.data(response=given.response, **changes))


def test_response_has_a_row_for_every_motion_and_the_port_and_a_curve_for_every_design_and_heading():
    axes = drawn("rao", raos=raos()).axes
    assert [ax.get_ylabel() for ax in axes[:8:2]] == [
        "surge\n[m/m]", "heave\n[m/m]", "pitch\n[degrees/m]", "port's displacement\n[m/m]"
    ]  # fmt: skip
    near = int(np.argmin(abs(OMEGA - 1.5)))
    for row, size in enumerate((0.5, 1.0, np.degrees(0.1), 2.0)):
        size *= abs(raos().values[0, 0, near, 2])
        for label, share in (("FSB, waves to 0°", 1.0), ("VSWEC, waves to 45°", 1 / 3)):
            assert test_curves.curve(axes[2 * row], label)[1][near] == pytest.approx(share * size)
            assert test_curves.curve(axes[2 * row + 1], label)[1][near] == pytest.approx(np.degrees(OMEGA[near]))


def test_design_without_a_motion_has_no_phase_of_it_at_several_headings():
    held = raos()
    held.loc[{"design": test_curves.DESIGNS[1], "dof": "Surge"}] = 0.0
    figure = drawn("rao", raos=held)
    figure.savefig(io.BytesIO(), format="svg")
    amplitude, phase = figure.axes[:2]
    assert (len(amplitude.lines), len(phase.lines)) == (4, 2)


def test_of_many_headings_the_excitation_shows_those_of_the_waves():
    headings = np.radians(np.arange(0, 100, 10))
    size = (1e4 * (1 + np.arange(10)))[:, None, None] * np.exp(-OMEGA)[:, None] * np.array([1.0, 2.0, 1e-6, 3.0])
    coords = {"wave_direction": headings, "omega": OMEGA, "influenced_dof": ["Heave", "Pitch", "Roll", "Bend"]}
    database = xr.Dataset({"excitation_force": (("wave_direction", "omega", "influenced_dof"), size + 0j)}, coords)
    axes = drawn("excitation", raos=raos(headings=np.radians([0.0, 48.0])), database=database).axes
    assert [ax.get_ylabel() for ax in axes[:6:2]] == ["heave\n[kN/m]", "pitch\n[kN m/m]", "modes\n[kN/m]"]
    assert [line.get_label() for line in axes[0].lines] == ["waves to 0°", "waves to 50°"]
    np.testing.assert_allclose(test_curves.curve(axes[2], "waves to 50°")[1], 6 * 20 * np.exp(-OMEGA))
    np.testing.assert_allclose(test_curves.curve(axes[4], "Bend")[1], 30 * np.exp(-OMEGA))


def test_phases_are_continuous_start_in_one_turn_and_leave_out_noise():
    omega = np.linspace(0.0, 4.0, 401)
    shown = omega <= 3.0
    lagging = np.exp(4j * omega)
    opposite = -lagging * np.exp(-1e-9j)  # half a turn from the first, but for noise
    quiet = np.where(omega < 1.0, 1e-6, 1.0) * lagging
    first, second, third = phases([lagging, opposite, quiet], shown)
    np.testing.assert_allclose(first[shown], np.degrees(4 * omega[shown]), atol=1e-9)
    np.testing.assert_allclose(second[shown], first[shown] + 180, atol=1e-6)
    np.testing.assert_allclose(third[shown & (omega >= 1.0)] % 360, first[shown & (omega >= 1.0)] % 360)
    assert np.isnan(third[omega < 1.0]).all()
    assert np.isnan(first[~shown]).all()
