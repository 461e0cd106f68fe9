"""Rule modes: the shell modes in a file are those of the study's basis."""

import numpy as np
import pytest
from conftest import varied

from vsb.errors import ConfigError
from vsb.scenes.directions import order_bases
from vsb.scenes.rest import reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.shell.reference import ReferenceShell
from vsb.stages import modes
from vsb.study.meridian import RestMeridian
from vsb.study.plan import StudyPlan
from vsb.tools.files import load


def test_shapes_and_frequencies_are_the_bases_from_pole_to_pole(seed, tmp_path):
    study = varied(seed, modes={"basis": "full", "degree": 4})
    modes.run(StudyPlan(study).modes, str(tmp_path / "modes.nc"))
    ds, basis = load(tmp_path / "modes.nc"), study_basis(study)
    assert tuple(ds.mode.values) == basis.labels[1:]
    assert (ds.colatitude.values[0], ds.colatitude.values[-1]) == (0.0, pytest.approx(np.pi))
    radial, meridional = basis.displacement(ds.colatitude.values)
    np.testing.assert_array_equal(ds.radial.values, radial[1:])
    np.testing.assert_array_equal(ds.meridional.values, meridional[1:])
    np.testing.assert_array_equal(ds.dry_frequency.values, basis.dry_frequencies)
    assert not ds.static_amplitude.values.any()
    assert ds.attrs["centre_height"] == study.centre_height


def test_shapes_of_higher_orders_are_their_families_at_rest_undeformed(seed):
    """What holds a buoy at rest is axisymmetric: of an order above 0 nothing is deflected."""
    study = varied(seed, modes={"degree": 3}, motion="planar", device={"centre_of_mass": -0.5, "ballast_inertia": 9e3})
    ds = modes.shell_modes(study, reference_shell(study))
    (family,) = (each for each in order_bases(study, study_basis(study)) if not each.odd)
    of_order = ds.isel(mode=ds.order.values == family.order)
    radial, meridional, _ = family.field(ds.colatitude.values)
    assert of_order.sizes["mode"] == len(family.modes) > 0
    np.testing.assert_array_equal(of_order.radial.values, radial[family.rigid :])
    np.testing.assert_array_equal(of_order.meridional.values, meridional[family.rigid :])
    np.testing.assert_array_equal(of_order.dry_frequency.values, family.dry_frequencies)
    np.testing.assert_array_equal(of_order.static_amplitude.values, 0.0)


def test_a_design_that_leaves_nothing_free_writes_nothing(seed, tmp_path):
    clamps = list(range(0, 181, 30))
    with pytest.raises(ConfigError, match="clamp"):
        modes.run(StudyPlan(varied(seed, designs={"A": {"clamp": clamps}})).modes, str(tmp_path / "modes.nc"))
    assert list(tmp_path.iterdir()) == []


OF_SHAPES = {"basis": "full", "degree": 3}


def test_what_leads_from_the_sphere_to_another_meridian_and_back(seed, tmp_path):
    """Along e_r and e_phi of the sphere from its point at an angle to that of the meridian."""
    study = varied(seed, device={"shape": {"spheroid": {"height": 3.0}}}, modes=OF_SHAPES)
    modes.run(StudyPlan(study).modes, str(tmp_path / "modes.nc"))
    ds, r = load(tmp_path / "modes.nc"), study.device.radius
    phi = ds.colatitude.values
    out, along = r + ds.rest_radial.values, ds.rest_meridional.values
    rest = np.array([study.device.meridian.at(angle)[:2] for angle in phi]).T
    np.testing.assert_allclose(out * np.sin(phi) + along * np.cos(phi), rest[0], atol=1e-12)
    np.testing.assert_allclose(out * np.cos(phi) - along * np.sin(phi), rest[1], atol=1e-12)
    assert ds.rest_radial.dims == ds.rest_meridional.dims == ("colatitude",)
    assert ds.attrs["radius"] == r
    assert not set(modes.REST) & set(modes.shell_modes(seed, reference_shell(seed)).data_vars)


@pytest.mark.parametrize("up", [0.0, 0.7])
def test_the_way_from_the_sphere_is_that_from_its_own_centre_and_radius(up):
    """A sphere moved up is its own, lifted: cos phi along e_r and -sin phi along e_phi."""
    ball = RestMeridian((1.3,), (up, 1.3))
    (dims, radial), (_, meridional) = modes._beyond_sphere(ball, 1.3)
    np.testing.assert_allclose(radial, up * np.cos(modes.COLATITUDES), atol=1e-14)
    np.testing.assert_allclose(meridional, -up * np.sin(modes.COLATITUDES), atol=1e-14)
    assert dims == "colatitude"
    assert modes._beyond_sphere(ball, 1.0)[0][1] == pytest.approx(radial + 0.3, abs=1e-14)


def test_a_shell_at_its_equilibrium_is_told_by_its_amplitudes_and_how_high_it_floats(seed):
    study = varied(
        seed, device={"internal_pressure": 16.5e3}, modes={"basis": "full", "degree": 4}, reference_shape="equilibrium"
    )
    basis = study_basis(study)
    q = 0.01 * np.arange(1.0, len(basis.labels) + 1)
    resting = ReferenceShell(DeformedShell(basis, study.centre_height, q), {})
    ds = modes.shell_modes(study, resting)
    np.testing.assert_array_equal(ds.static_amplitude.values, q[1:])
    assert ds.attrs["centre_height"] == pytest.approx(study.centre_height + 0.01, rel=1e-14)
    assert ds.attrs["radius"] == study.device.radius
    assert modes.ORDER not in ds
    np.testing.assert_array_equal(ds.degree.values, basis.degrees[1:])


def test_a_shell_that_does_not_rest_writes_nothing(seed, tmp_path):
    crushed = varied(seed, device={"internal_pressure": -60e3}, modes={"basis": "full", "degree": 6})
    with pytest.raises(ConfigError, match=r"^device: the shell of design VSWEC is unstable"):
        modes.run(StudyPlan(crushed).modes, str(tmp_path / "modes.nc"))
    assert list(tmp_path.iterdir()) == []


def test_modes_of_all_orders_are_named_and_numbered_in_the_plane_of_the_waves(seed):
    """Of a buoy that moves freely the odd families are left out: they are the even ones turned."""
    study = varied(
        seed,
        motion="free",
        modes={"degree": 3, "order": 2},
        device={"centre_of_mass": -0.5, "ballast_inertia": 9e3, "ballast_yaw_inertia": 7e3},
    )
    reference = reference_shell(study)
    ds = modes.shell_modes(study, reference)
    families = [reference.basis, *(each for each in order_bases(study, reference.basis) if not each.odd)]
    assert [each.order for each in families[1:]] == [1, 2]
    listed = [(mode.label, mode.degree, getattr(each, "order", 0)) for each in families for mode in each.modes]
    assert list(zip(ds.mode.values, ds.degree.values, ds.order.values, strict=True)) == listed
    np.testing.assert_allclose(ds.dry_frequency.values, np.concatenate([each.dry_frequencies for each in families]))


@pytest.mark.parametrize("motion", ["planar", "free"])
def test_a_rigid_buoy_that_surges_and_pitches_has_no_shell_modes_at_all(seed, motion):
    ballast = {"centre_of_mass": -0.5, "ballast_inertia": 9e3, "ballast_yaw_inertia": 7e3 if motion == "free" else None}
    study = varied(seed, designs={"FSB": {"flexible": False}}, motion=motion, device=ballast)
    reference = reference_shell(study)
    ds = modes.shell_modes(study, reference)
    assert len(order_bases(study, reference.basis)) > 0
    assert dict(ds.sizes) == {"mode": 0, "colatitude": len(modes.COLATITUDES)}
    assert ds.order.dims == ("mode",)
