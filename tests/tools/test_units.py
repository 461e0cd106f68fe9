import numpy as np
import pytest
from tools.test_files import rao

from vsb.errors import DatabaseError
from vsb.tools.units import ATTRS, check_finite, described, merged, separated


def test_separated_form_is_the_one_capytaine_writes():
    from capytaine.io.xarray import separate_complex_values

    ds = rao(np.arange(6).reshape(1, 3, 2) * (1 + 2j))
    ours, theirs = separated(ds), separate_complex_values(ds)
    assert ours.rao.transpose(*theirs.rao.dims).equals(theirs.rao)
    assert merged(ours).rao.equals(ds.rao)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, complex(0, np.nan)])
def test_one_bad_number_is_found(bad):
    values = np.ones((1, 3, 2), dtype=type(bad))
    check_finite(rao(values), "x")
    values[0, 1, 1] = bad
    with pytest.raises(
        DatabaseError, match=r"x: variable rao holds NaN or infinite values; this result cannot be used"
    ):
        check_finite(rao(values), "x")


def test_dimensions_are_put_in_order():
    ds = rao(np.arange(6.0).reshape(1, 3, 2)).transpose("dof", "omega", "design")
    out = described(ds)
    assert out.rao.dims == ATTRS["rao"].dims
    assert out.equals(rao(np.arange(6.0).reshape(1, 3, 2)))
    assert ds.rao.dims == ("dof", "omega", "design")  # the input stays


def test_real_datasets_are_left_as_they_are():
    ds = rao(np.ones((1, 3, 2)))
    assert separated(ds).identical(ds)
    assert merged(ds).identical(ds)


@pytest.mark.parametrize("name", sorted(ATTRS))
def test_every_variable_has_a_unit_and_a_meaning(name):
    quantity = ATTRS[name]
    assert quantity.units
    assert quantity.long_name
    assert len(set(quantity.dims)) == len(quantity.dims)
