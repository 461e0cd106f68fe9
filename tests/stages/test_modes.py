"""Stage modes: stored shapes and frequencies of the shell modes, and the rest shape."""

import numpy as np
import pytest
from conftest import varied

from vsb.models.rest import study_basis
from vsb.pipeline.graph import StudyPlan
from vsb.stages import shell
from vsb.tools.files import load


def test_stored_modes_are_those_of_the_basis(seed, tmp_path):
    study = varied(seed, modes={"basis": "full", "degree": 4})
    shell.run_modes(StudyPlan(study).modes.spec, str(tmp_path / "modes.nc"))
    ds, basis = load(tmp_path / "modes.nc"), study_basis(study)
    assert tuple(ds.mode.values) == basis.labels[1:]
    assert (ds.colatitude.values[0], ds.colatitude.values[-1]) == (0.0, pytest.approx(np.pi))
    radial, meridional = basis.displacement(ds.colatitude.values)
    np.testing.assert_array_equal(ds.radial.values, radial[1:])
    np.testing.assert_array_equal(ds.meridional.values, meridional[1:])
    np.testing.assert_array_equal(ds.dry_frequency.values, basis.dry_frequencies)
    assert not ds.static_amplitude.values.any()
    assert ds.attrs["centre_height"] == study.centre_height


def test_rest_shape_of_a_spheroid(seed, tmp_path):
    """Displacement along e_r and e_phi from the point of the sphere to that of the meridian at the same angle."""
    study = varied(seed, device={"shape": {"spheroid": {"height": 3.0}}}, modes={"basis": "full", "degree": 3})
    shell.run_modes(StudyPlan(study).modes.spec, str(tmp_path / "modes.nc"))
    ds, r = load(tmp_path / "modes.nc"), study.device.radius
    phi = ds.colatitude.values
    out, along = r + ds.rest_radial.values, ds.rest_meridional.values
    rest = np.array([study.device.meridian.at(angle)[:2] for angle in phi]).T
    np.testing.assert_allclose(out * np.sin(phi) + along * np.cos(phi), rest[0], atol=1e-12)
    np.testing.assert_allclose(out * np.cos(phi) - along * np.sin(phi), rest[1], atol=1e-12)
