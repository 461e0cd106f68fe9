"""Compiled forces on the wet shell, in still water and waves: plain implementation, closed forms, linear limit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import j0

from vsb.engine.motion.wetted import WetShell, dynamic_head, elevation_at, incident, moment, wave_force
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.meridian import RestMeridian, capsule, spheroid
from vsb.engine.shell.modes import ModeBasis, mode_basis, natural_shapes
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.sampling import sampled
from vsb.engine.waves.seas import NO_WAVES, Sea

ONE_DIP = {"Bending6": -0.4}  # with the centre at -1.7 m the top pole dips under and a ring stays out


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


def amplitudes(basis, **by_label):
    return np.array([by_label.get(label, 0.0) for label in basis.labels])


def compiled(basis, height, q):
    static, uniform, moment = WetShell(basis, height).forces(q[None])
    return static[0], uniform[0], moment[0]


def wet_integral(shell, integrand, points):
    """Integral over the wet meridian; 0 of a dry shell."""
    return sum((integrand(shell.meridian(phi)) @ weight for phi, weight in shell._wet_points(points)), 0.0)


def uniform_twin(basis, height, q, points=120):
    """-int n.psi dS over the wet shell, in colatitude."""
    shell = DeformedShell(basis, height, q)

    def integrand(m):
        return m.x * (-m.dz * m.shape_x + m.dx * m.shape_z)

    return np.broadcast_to(-2 * np.pi * wet_integral(shell, integrand, points), len(q))


@settings(max_examples=20)
@given(st.lists(st.floats(-0.08, 0.08), min_size=12, max_size=12), st.floats(-2.6, 2.6))
def test_compiled_and_plain_forces_agree(full, modal, height):
    q = np.array([0.1, *modal])
    static, uniform, _ = compiled(full, height, q)
    assert static == pytest.approx(DeformedShell(full, height, q).hydrostatics(1.0, 1.0, 120)[0], abs=2e-11)
    assert uniform == pytest.approx(uniform_twin(full, height, q), abs=2e-11)


@pytest.mark.parametrize("height", [-1.72, -1.6])
def test_several_waterlines(full, height):
    q = amplitudes(full, **ONE_DIP)
    static, uniform, _ = compiled(full, height, q)
    assert static == pytest.approx(DeformedShell(full, height, q).hydrostatics(1.0, 1.0, 200)[0], abs=1e-11)
    assert uniform == pytest.approx(uniform_twin(full, height, q, 200), abs=1e-11)


def test_shallow_dimple_is_resolved(full):
    """The wet area grows as the square root of the depth; the force is continuous."""
    q = amplitudes(full, Membrane4=0.7)  # a dimple round the raised pole, its rim above it
    phi = np.linspace(0.0, 1.2, 20_001)
    z = DeformedShell(full, 0.0, q).meridian(phi).z
    dimple = np.flatnonzero((z[1:-1] < z[:-2]) & (z[1:-1] < z[2:]))[0] + 1
    touching = -z[dimple]
    depths = np.array([1e-8, 1e-7, 1e-6, 1e-5])
    wet = [compiled(full, touching - depth, q)[1] - compiled(full, touching + 1e-12, q)[1] for depth in depths]
    sizes = np.abs(wet).max(axis=1)
    assert np.all(sizes > 0)
    slopes = np.diff(np.log(sizes)) / np.diff(np.log(depths))
    assert np.all(np.abs(slopes - 0.5) < 0.05), slopes


def basis_of(meridian, degree=3):
    shell = Shell(meridian.radius, 0.005, 1e7, 0.3, 2700.0, meridian)
    return ModeBasis(shell, natural_shapes(shell, degree), 1e4, bending=True)


BODIES = [
    (spheroid(2.0, 3.0), 1e-10),
    (spheroid(1.5, 6.0), 1e-10),
    (capsule(1.0, 1.0), 1e-4),  # of whose series the compiled loops know the first terms
    (RestMeridian((1.0, 0.1), (0.0, 1.2, -0.05)), 1e-10),
]


@pytest.mark.parametrize(("meridian", "apart"), BODIES)
def test_compiled_and_plain_forces_of_any_meridian_agree(meridian, apart):
    basis = basis_of(meridian)
    for height in (-0.6, 0.0, 0.4):
        q = np.concatenate([[0.05], 0.03 * np.cos(np.arange(1.0, 7.0))])
        static, uniform, _ = (part[0] for part in WetShell(basis, height).forces(q[None]))
        shell = DeformedShell(basis, height, q)
        assert static == pytest.approx(shell.hydrostatics(1.0, 1.0, 120)[0], abs=apart)
        plain = -2 * np.pi * wet_integral(shell, lambda m: m.x * (-m.dz * m.shape_x + m.dx * m.shape_z), 120)
        assert uniform == pytest.approx(plain, abs=apart)


def test_dry_submerged_and_floating_spheroid():
    """Closed form: the affine image of the spherical cap."""
    basis = basis_of(spheroid(2.0, 3.0))
    q = np.zeros((1, 7))
    volume = 4 / 3 * np.pi * 4 * 1.5
    assert WetShell(basis, 2.0).forces(q)[0][0, 0] == 0.0
    assert WetShell(basis, -2.0).forces(q)[0][0, 0] == pytest.approx(volume, rel=1e-12)
    h = 1.0  # immersed, of 3
    cap = 0.75 * np.pi * (h / 0.75) ** 2 * (6 - h / 0.75) / 3
    assert WetShell(basis, 0.5).forces(q)[0][0, 0] == pytest.approx(cap, rel=1e-12)


G, OMEGA = 9.81, 2 * np.pi / 2.5
K = OMEGA**2 / G


def swell(amplitude, depth=np.inf, omega=OMEGA):
    return incident(Sea(np.array([omega]), np.array([amplitude + 0j])), depth, G, 2.0)


def force(basis, height, q, waves, time=0.0, **changes):
    shape = WetShell(basis, height).shape._replace(**changes)
    out = np.empty(len(q))
    wave_force(shape, q, waves, time, out)
    return out


def deformed(basis):
    q = np.zeros(len(basis.labels))
    q[[0, 1, 3, 9]] = 0.1, 0.05, -0.08, 0.06
    return q


@pytest.mark.parametrize("height", [-2.6, 0.4])
def test_still_water_limit(full, height):
    q = deformed(full)
    still = incident(NO_WAVES, np.inf, G, 2.0)
    assert force(full, height, q, still) == pytest.approx(WetShell(full, height).forces(q[None])[0][0], abs=1e-12)
    assert force(full, height, q, swell(0.0)) == pytest.approx(WetShell(full, height).forces(q[None])[0][0], abs=1e-12)


def test_small_waves_give_the_linear_froude_krylov_force(full):
    """Heave of the hemisphere, int J_0(kx) e^(kz) n_z dS; the error is of second order in the amplitude."""
    exact = (
        -2 * np.pi * quad(lambda c: j0(K * 2 * np.sqrt(1 - c * c)) * np.exp(2 * K * c) * 4 * c, -1, 0, epsabs=1e-13)[0]
    )
    q = np.zeros(len(full.labels))
    still = force(full, 0.0, q, swell(0.0))
    amplitudes = np.array([0.08, 0.04, 0.02, 0.01])
    errors = []
    for a in amplitudes:
        crest, trough = (force(full, 0.0, q, swell(s * a))[0] for s in (1, -1))
        errors.append([abs((crest - still[0]) / a - exact), abs((crest - trough) / (2 * a) - exact)])
    slopes = np.diff(np.log(errors), axis=0) / np.diff(np.log(amplitudes))[:, None]
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


def test_finite_depth_profile_and_deep_water_limit(full):
    q = deformed(full)
    deep = force(full, 0.1, q, swell(0.1))
    assert force(full, 0.1, q, swell(0.1, depth=200.0)) == pytest.approx(deep, abs=1e-10)
    shallow = swell(0.1, depth=4.0, omega=1.0)
    k = shallow.wavenumber[0]
    assert pytest.approx(G * k * np.tanh(4 * k)) == 1.0
    exact = quad(
        lambda c: j0(k * 2 * np.sqrt(1 - c * c)) * np.cosh(k * (2 * c + 4)) / np.cosh(4 * k) * 4 * c,
        -1,
        0,
        epsabs=1e-13,
    )[0]
    zero = np.zeros(len(full.labels))
    crest, trough = (force(full, 0.0, zero, swell(a, depth=4.0, omega=1.0))[0] for a in (1e-5, -1e-5))
    assert (crest - trough) / 2e-5 == pytest.approx(-2 * np.pi * exact, rel=1e-7)


def test_quadrature_has_converged(full):
    q, waves = deformed(full), swell(0.4)
    assert force(full, 0.2, q, waves, 0.4) == pytest.approx(force(full, 0.2, q, waves, 0.4, **exact(80)), abs=1e-8)


def exact(points):
    """A rule for all intervals, in place of one as fine as an interval needs."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return {"counts": np.array([points]), "nodes": nodes[None], "weights": weights[None]}


@pytest.mark.parametrize("height", [-0.9, 0.0, 0.5, 1.1])
def test_short_intervals_need_few_points(height):
    """Of a capsule, whose series has 96 terms, between still water and a wave: equal to the exact rule."""
    basis = basis_of(capsule(1.0, 1.0))
    q = np.concatenate([[0.05], 0.03 * np.cos(np.arange(1.0, 7.0))])
    one, shape = force(basis, height, q, swell(0.3), 0.7), WetShell(basis, height).shape
    assert len(shape.counts) > 3
    assert one == pytest.approx(force(basis, height, q, swell(0.3), 0.7, **exact(int(shape.counts[-1]))), abs=1e-12)


@pytest.mark.parametrize(("depth", "radius"), [(np.inf, 2.0), (20.0, 2.0), (1.5, 1.3)])
@pytest.mark.parametrize("height", [0.0, -0.4, -12.0])
def test_elevation_and_pressure_are_sums_over_components(depth, radius, height):
    """Re a J_0(k x) exp(-i w t), and cosh k(z + d)/cosh kd below the water; k r from 0.2 to 25, also far down."""
    if height < -1.0 and depth < 20.0:
        return
    omega, amplitude = np.array([1.2, 3.0, 5.0, 9.0, 11.0]), np.array([-0.2, 0.1, 0.05 + 0.01j, 0.02j, 0.01 - 0.03j])
    waves, time = incident(Sea(omega, amplitude), depth, G, radius), 0.7
    k, now = waves.wavenumber, (amplitude * np.exp(-1j * omega * time)).real
    x = radius * np.array([0.0, 0.3, 0.8, 1.0, 1.1, 2.0])
    z = min(height, 0.0) - radius * np.array([0.0, 0.2, 0.1, 0.6, 0.0, 0.4])
    around = j0(np.outer(x, k))
    bottom = np.exp(-2 * k * depth)
    profile = (np.exp(np.outer(z, k)) + bottom * np.exp(-np.outer(z, k))) / (1 + bottom)
    sea = moment(waves, time, height)
    np.testing.assert_allclose([elevation_at(waves, sea, at**2) for at in x], around @ now, atol=1e-14)
    np.testing.assert_allclose(dynamic_head(waves, sea, x**2, z), (around * profile) @ now, atol=2e-13)


@pytest.mark.parametrize("depth", [np.inf, 20.0])
def test_trial_state_far_under_water_raises_no_error(depth):
    """A step predicted too long may ask for waves 1000 m down: it must fail by its size."""
    waves = incident(Sea(np.array([1.0, 12.0]), np.array([0.1, 0.1j])), depth, G, 2.0)
    sea = moment(waves, 0.3, -1000.0)
    found = dynamic_head(waves, sea, np.array([0.0, 1.0]), np.array([-1000.0, -1001.0]))
    assert depth < np.inf or np.abs(found).max() < 1e-12


def test_samples_in_time_do_not_change_the_force(full):
    """A sea of many components, its coefficients from samples and summed one by one."""
    rng, count = np.random.default_rng(3), 200
    omega = 8.0 * (np.arange(count) + 0.5) / count
    amplitude = 0.3 / np.sqrt(count) * (rng.normal(size=count) + 1j * rng.normal(size=count))
    waves, q = incident(Sea(omega, amplitude), np.inf, G, 2.0), deformed(full)
    faster = waves._replace(signals=sampled(waves.signals, 100.0, 130.0))
    for time in rng.uniform(100.0, 130.0, 10):
        one_by_one = force(full, 0.1, q, waves, time)
        assert force(full, 0.1, q, faster, time) == pytest.approx(one_by_one, abs=1e-12 * np.abs(one_by_one).max())
