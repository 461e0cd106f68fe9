"""Rule radiation: the model in a file is passive, and its kernel that of the database."""

import numpy as np
import pytest
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro.database import load_database
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel, fit_radiation
from vsb.stages import radiation
from vsb.study.specs import RadiationSpec
from vsb.study.study import content_id
from vsb.tools.files import load


def test_the_model_is_passive_and_as_good_as_it_says(small):
    ds = load(small.radiation_path, expected=content_id(small.radiation))
    model = RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)
    assert ds.attrs["order"] == model.order
    assert np.linalg.eigvals(model.state_matrix).real.max() < 0
    assert ds.attrs["fit_error"] <= small.radiation.tolerance
    np.testing.assert_allclose(ds.damping_state_space.values, model.damping(ds.omega.values))
    assert np.linalg.eigvalsh(ds.damping_state_space.values).min() > -1e-9 * ds.damping_state_space.values.max()
    off = np.abs(ds.kernel - ds.kernel_state_space).max(dim="time") / np.abs(ds.kernel).max(dim="time")
    assert float(off.sel(influenced_dof="Heave", radiating_dof="Heave")) < 0.01


def test_kernels_are_shown_for_forty_times_the_time_a_wave_takes_along_the_buoy(small):
    """In units of the root of r/g; at 400 intervals."""
    ds, water = load(small.radiation_path), small.study.water
    assert (ds.time.values[0], ds.sizes["time"]) == (0.0, 401)
    assert float(ds.time[-1]) == pytest.approx(40 * np.sqrt(small.study.device.radius / water.gravity))


def test_its_damping_is_the_databases(small):
    ds, database = load(small.radiation_path), load_database(small.database_path, content_id(small.database))
    heave = {"influenced_dof": "Heave", "radiating_dof": "Heave"}
    truth = database.radiation_damping.sel(heave)
    assert float(np.abs(ds.damping_state_space.sel(heave) - truth).max()) < 0.01 * float(truth.max())


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_the_least_damping_has_no_unit(size):
    """A tiny buoy's, or a volume's, is judged as a large one's; a motion without water counts nothing."""
    damping = np.array([np.diag([4.0, 1.0, 0.0]), np.diag([2.0, -0.5, 0.0])])
    sized = damping * size * np.outer([1.0, 1e3, 1.0], [1.0, 1e3, 1.0])
    assert radiation.least_damping(DampingSpectrum(np.array([1.0, 2.0]), sized), sized) == pytest.approx(-0.5)


def test_another_database_is_refused(small, tmp_path):
    spec = RadiationSpec(database="0" * 16, tolerance=1e-3)
    with pytest.raises(DatabaseError, match=r"needs '?0{16}"):
        radiation.run(spec, small.database_path, str(tmp_path / "out.nc"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("turned", [False, True])
def test_of_several_orders_each_has_its_own_memory_and_the_worst_error_is_told(turned):
    """A smooth and a peaked damping, either first; a sine has the memory of its cosine, what is dry has none."""
    omega = np.linspace(0.1, 12.0, 120)
    smooth = omega**3 * np.exp(-2 * omega)
    peaked = smooth * (1 + 2 * np.exp(-(((omega - 2.0) / 0.3) ** 2)))
    heave, surge = (peaked, smooth) if turned else (smooth, peaked)
    damping = np.zeros((len(omega), 4, 4))
    for place, values in enumerate((heave, surge, 0 * surge, surge)):
        damping[:, place, place] = values
    labels, pair = ["Heave", "Surge", "Pitch", "Sway"], ("influenced_dof", "radiating_dof")
    ds = xr.Dataset(
        {"radiation_damping": (("omega", *pair), damping), "azimuthal_order": ("influenced_dof", [0, 1, 1, -1])},
        coords={"omega": omega, **dict.fromkeys(pair, labels)},
    )
    found = radiation.fit_orders(ds, 1e-5)
    fits = [fit_radiation(DampingSpectrum(omega, one[:, None, None]), 1e-5) for one in (heave, surge)]
    assert len({error for _, error in fits}) == 2
    assert found.error == max(error for _, error in fits)
    own = [model.damping(omega)[:, 0, 0] for model, _ in fits]
    model = found.model.damping(omega)
    for place, values in enumerate((own[0], own[1], 0 * own[1], own[1])):
        np.testing.assert_allclose(model[:, place, place], values, rtol=1e-9, atol=1e-12)
