"""Stage radiation: a passive state space whose damping and kernels are those of the database."""

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import load_database
from vsb.engine.hydro.retardation import DampingSpectrum
from vsb.engine.hydro.statespace import RadiationModel, fit_radiation
from vsb.stages import frequency
from vsb.tools.files import load


def test_radiation_model_is_passive_and_within_its_stated_error(small):
    ds = load(small.radiation.out, expected=small.radiation.id)
    model = RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)
    assert ds.attrs["order"] == model.order
    assert np.linalg.eigvals(model.state_matrix).real.max() < 0
    assert ds.attrs["fit_error"] <= small.radiation.spec.tolerance
    damping = model.damping(ds.omega.values)
    np.testing.assert_allclose(ds.damping_state_space.values, np.einsum("wii->wi", damping))
    assert np.linalg.eigvalsh(damping).min() > -1e-9 * damping.max()
    np.testing.assert_allclose(ds.kernel_state_space, np.einsum("tii->ti", model.kernel(ds.time.values)), atol=1e-9)
    off = np.abs(ds.kernel - ds.kernel_state_space).max(dim="time") / np.abs(ds.kernel).max(dim="time")
    assert float(off.sel(radiating_dof="Heave")) < 0.01


def test_damping_of_the_model_is_that_of_the_database(small):
    ds, database = load(small.radiation.out), load_database(small.database.out, small.database.id)
    heave = {"influenced_dof": "Heave", "radiating_dof": "Heave"}
    truth = database.radiation_damping.sel(heave)
    assert float(np.abs(ds.damping_state_space.sel(radiating_dof="Heave") - truth).max()) < 0.01 * float(truth.max())


def test_every_azimuthal_order_has_its_own_memory():
    """A smooth and a peaked damping; sway has the memory of surge, a dry motion has none."""
    omega = np.linspace(0.1, 12.0, 120)
    smooth = omega**3 * np.exp(-2 * omega)
    peaked = smooth * (1 + 2 * np.exp(-(((omega - 2.0) / 0.3) ** 2)))
    heave, surge = peaked, smooth
    damping = np.zeros((len(omega), 4, 4))
    for place, values in enumerate((heave, surge, 0 * surge, surge)):
        damping[:, place, place] = values
    labels, pair = ["Heave", "Surge", "Pitch", "Sway"], ("influenced_dof", "radiating_dof")
    ds = xr.Dataset(
        {"radiation_damping": (("omega", *pair), damping), "azimuthal_order": ("influenced_dof", [0, 1, 1, -1])},
        coords={"omega": omega, **dict.fromkeys(pair, labels)},
    )
    found = frequency.fit_orders(ds, 1e-5)
    fits = [fit_radiation(DampingSpectrum(omega, one[:, None, None]), 1e-5) for one in (heave, surge)]
    assert len({error for _, error in fits}) == 2
    assert found.error == max(error for _, error in fits)
    own = [model.damping(omega)[:, 0, 0] for model, _ in fits]
    model = found.model.damping(omega)
    for place, values in enumerate((own[0], own[1], 0 * own[1], own[1])):
        np.testing.assert_allclose(model[:, place, place], values, rtol=1e-9, atol=1e-12)
