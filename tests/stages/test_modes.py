"""Rule modes: the shell modes in a file are those of the study's basis."""

import numpy as np
import pytest
from conftest import varied

from vsb.errors import ConfigError
from vsb.scenes.directions import order_bases
from vsb.scenes.rest import reference_shell, study_basis
from vsb.stages import modes
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
