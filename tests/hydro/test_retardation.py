import numpy as np
import pytest
from scipy.integrate import quad

from vsb.errors import DatabaseError
from vsb.hydro.retardation import DampingSpectrum

OMEGA = np.arange(1, 121) * 0.1
TAIL = 2 / np.pi * 3 / (4 * 12.0**4)  # what w^-3 beyond 12 rad/s misses of w^-3 (1 - 3 w^-2 + ...)


def damping(w):
    """Smooth, ~ w^3 at low and w^-3 at high frequency, as a radiation damping is."""
    return w**3 / (1 + w**2) ** 3


@pytest.fixture(scope="module")
def spectrum():
    return DampingSpectrum(OMEGA, damping(OMEGA)[:, None, None])


@pytest.mark.parametrize("time", [0.0, 0.5, 3.0, 10.0])
def test_kernel_is_the_cosine_transform(spectrum, time):
    exact = 2 / np.pi * (quad(damping, 0, np.inf, weight="cos", wvar=time)[0] if time else quad(damping, 0, np.inf)[0])
    assert spectrum.kernel(np.array([time]))[0, 0, 0] == pytest.approx(exact, abs=1.1 * TAIL)


@pytest.mark.parametrize("omega", [0.55, 1.5, 4.0])
def test_added_mass_follows_from_damping_by_kramers_kronig(spectrum, omega):
    inner = quad(lambda v: damping(v) / (v + omega), 0, 60, weight="cauchy", wvar=omega, limit=400)[0]
    outer = quad(lambda v: damping(v) / (v**2 - omega**2), 60, np.inf)[0]
    exact = 2 / np.pi * (inner + outer)
    assert spectrum.added_mass_difference(np.array([omega]))[0, 0, 0] == pytest.approx(exact, abs=2e-5)


def test_added_mass_follows_from_the_kernel_by_ogilvie(spectrum):
    time = np.linspace(0, 300, 60001)
    kernel, omega = spectrum.kernel(time[time <= 100])[:, 0, 0], 1.2
    sine = np.trapezoid(kernel * np.sin(omega * time[: len(kernel)]), time[: len(kernel)])
    assert spectrum.added_mass_difference(np.array([omega]))[0, 0, 0] == pytest.approx(-sine / omega, abs=1e-4)


def test_interpolation_converges_at_fourth_order():
    steps = [0.2, 0.1, 0.05, 0.025, 0.0125]
    probe = np.linspace(1.013, 3.017, 57)
    errors = []
    for step in steps:
        omega = np.arange(1, round(12 / step) + 1) * step
        spectrum = DampingSpectrum(omega, damping(omega)[:, None, None])
        errors.append(np.abs(spectrum.at(probe)[:, 0, 0] - damping(probe)).max())
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes[1:] - 4.0) < 0.15), slopes


def test_damping_that_ends_straight_is_met_exactly():
    """One cubic, zero at 0 and without curvature at the end of the band, whose slope there is not zero."""
    omega = np.linspace(0.2, 4.0, 20)
    cubic = DampingSpectrum(omega, (omega**2 * (12.0 - omega))[:, None, None])
    probe = np.linspace(0.0, 4.0, 77)
    assert cubic.at(probe)[:, 0, 0] == pytest.approx(probe**2 * (12.0 - probe), abs=1e-11)


def test_transfer_function_is_damping_and_reactive_added_mass(spectrum):
    omega = np.array([0.7, 2.0])
    transfer = spectrum.transfer(omega)
    assert transfer.real == pytest.approx(spectrum.at(omega))
    assert transfer.imag == pytest.approx(omega[:, None, None] * spectrum.added_mass_difference(omega))


def test_damping_continues_beyond_the_band(spectrum):
    at = spectrum.at(np.array([12.0, 24.0]))[:, 0, 0]
    assert at[1] == pytest.approx(at[0] / 8)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["omega", "damping"])
def test_what_is_no_number_is_refused(where, value):
    given = {"omega": OMEGA.copy(), "damping": damping(OMEGA)[:, None, None]}
    given[where][7] = value
    with pytest.raises(DatabaseError, match=r"^radiation damping: received NaN or infinite values; solve these freq"):
        DampingSpectrum(**given)


def test_every_entry_of_a_matrix_has_its_own_transform(spectrum):
    """Which is linear: a coupling that is negative, one of another shape, and none; each at its place."""
    one = damping(OMEGA)
    other = OMEGA**2 / (1 + OMEGA**4) ** 1.5
    flat = {(0, 0): one, (0, 1): -2.0 * other, (1, 0): 0.5 * one, (1, 1): 0.0 * one, (2, 1): other, (2, 2): 3.0 * one}
    matrix = np.zeros((len(OMEGA), 3, 3))
    for (i, j), values in flat.items():
        matrix[:, i, j] = values
    whole, alone = DampingSpectrum(OMEGA, matrix), DampingSpectrum(OMEGA, other[:, None, None])
    time, omega = np.array([0.0, 0.7, 4.0]), np.array([0.0, 0.35, 2.0, 11.0])
    for name, at in (("kernel", time), ("added_mass_difference", omega), ("at", np.append(omega, 18.0))):
        first, second = (getattr(each, name)(at)[:, 0, 0] for each in (spectrum, alone))
        expected = np.zeros((len(at), 3, 3))
        for place, of in {
            (0, 0): first,
            (0, 1): -2 * second,
            (1, 0): first / 2,
            (2, 1): second,
            (2, 2): 3 * first,
        }.items():
            expected[:, *place] = of
        np.testing.assert_allclose(getattr(whole, name)(at), expected, atol=1e-12)


def test_below_the_band_damping_falls_to_nothing_at_frequency_zero(spectrum):
    assert spectrum.at(np.zeros(1)).item() == 0.0
    assert 0.0 < spectrum.at(np.array([0.05])).item() < spectrum.at(np.array([0.1])).item()
    assert spectrum.transfer(np.zeros(1)).item() == 0.0


def ends_high(v):
    """A cubic up to 4 rad/s, omega^-3 beyond, which has half of all there is."""
    return v**2 * (12.0 - v) if v < 4.0 else 128.0 * (4.0 / v) ** 3


@pytest.fixture(scope="module")
def cubic():
    omega = np.linspace(0.2, 4.0, 20)
    return DampingSpectrum(omega, (omega**2 * (12.0 - omega))[:, None, None])


@pytest.mark.parametrize("omega", [0.0, 0.9, 2.7])
def test_added_mass_of_a_damping_that_ends_high_holds_what_is_beyond_the_band(cubic, omega):
    """By quadrature of its own; the pole apart, what is about it by Cauchy's weight."""
    if omega:
        below = quad(lambda v: ends_high(v) / (v + omega), 0, 4.0, weight="cauchy", wvar=omega)[0]
    else:
        below = quad(lambda v: 12.0 - v, 0, 4.0)[0]
    above = quad(lambda v: ends_high(v) / (v**2 - omega**2), 4.0, np.inf)[0]
    assert cubic.added_mass_difference(np.array([omega])).item() == pytest.approx(2 / np.pi * (below + above), rel=1e-7)


@pytest.mark.parametrize("time", [0.0, 0.8, 5.0])
def test_a_kernel_of_a_damping_that_ends_high_holds_what_is_beyond_the_band(cubic, time):
    below = quad(lambda v: ends_high(v) * np.cos(v * time), 0, 4.0, epsabs=1e-10)[0]
    above = quad(ends_high, 4.0, np.inf, weight="cos", wvar=time, epsabs=1e-10)[0] if time else 256.0
    assert cubic.kernel(np.array([time])).item() == pytest.approx(2 / np.pi * (below + above), abs=1e-6)


@pytest.mark.parametrize("slow", [1e-4, 1e4])
def test_a_spectrum_knows_no_unit_of_time(slow):
    """The same damping at other frequencies is the same damping, within the band and beyond, its transforms in step."""
    values, at = damping(OMEGA)[:, None, None], np.array([0.0, 0.05, 0.75, 3.3, 11.0, 30.0])
    one, other = DampingSpectrum(OMEGA, values), DampingSpectrum(slow * OMEGA, values)
    assert other.at(slow * at) == pytest.approx(one.at(at), rel=1e-9)
    difference = one.added_mass_difference(at)
    assert slow * other.added_mass_difference(slow * at) == pytest.approx(difference, abs=1e-9)
    assert other.kernel(at / slow) / slow == pytest.approx(one.kernel(at), abs=1e-9)
