"""Rule radiation: the model in a file is passive, and its kernel that of the database."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro.database import load_database
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel, fit_radiation
from vsb.stages import radiation
from vsb.stages.stage import stamp
from vsb.study.body_specs import BodyRadiationSpec
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
    damping = np.array([np.diag([2.0, 0.5, 0.0]), np.diag([4.0, 1.0, 0.0]), np.diag([3.0, -0.5, 0.0])])
    for units in ([1.0, 1e3, 1.0], [1e3, 1.0, 1.0]):  # what draws energy is the larger motion, or the smaller
        sized = damping * size * np.outer(units, units)
        assert radiation.least_damping(DampingSpectrum(np.array([1.0, 2.0, 3.0]), sized), sized) == pytest.approx(-0.5)


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


@pytest.mark.parametrize("limit", ["given", "fitted"])
def test_the_memory_of_a_body_is_stored_with_its_limit_its_history_and_its_kernels(monkeypatch, limit):
    """Of two channels; shown for sixty over the end of the band. What draws is told in terms of each motion's size."""
    omega, labels, pair = np.array([0.5, 1.0, 2.5]), ["Heave", "Pitch"], ("influenced_dof", "radiating_dof")
    skew, channel = (
        np.array([[0.0, 1.3, 0.2], [-1.3, 0.0, -0.4], [-0.2, 0.4, 0.0]]),
        np.array([[1, 0.2], [0, 1], [1, 0]]),
    )
    g = np.array([[1.0, 20.0], [0.5, -3.0], [0.0, 7.0]])
    model = RadiationModel(skew - channel @ channel.T / 2, g, channel)
    damping = model.damping(omega) * np.array([[1.1, 1.0], [1.0, 0.9]])
    ds = xr.Dataset({"radiation_damping": (("omega", *pair), damping)}, {"omega": omega, **dict.fromkeys(pair, labels)})
    asked, saved = [], []

    class Body:
        def memory(self, tolerance, *, limit="given"):
            asked.append((tolerance, limit))
            return SimpleNamespace(
                model=model,
                error=0.0123,
                added_mass_inf=np.array([[3.0, 1.0], [1.0, 8.0]]),
                history="as it was repaired",
                up_to=np.inf,
            )

    monkeypatch.setattr(radiation, "load_database", lambda path, identity: asked.append((path, identity)) or ds)
    monkeypatch.setattr(radiation, "stored_body", lambda path: asked.append(path) or Body())
    monkeypatch.setattr(radiation, "save", lambda *given: saved.append(given))
    spec = BodyRadiationSpec(database="a" * 16, tolerance=2e-3, added_mass_inf=limit)
    radiation.run(spec, "body.nc", "memory.nc")
    assert asked == [("body.nc", "a" * 16), "body.nc", (2e-3, limit)]
    ((found, out),) = saved
    assert out == "memory.nc"
    time = np.linspace(0.0, 60.0 / 2.5, 401)
    spectrum, own = DampingSpectrum(omega, damping), np.sqrt(np.einsum("wii->wi", damping).max(axis=0))
    expected = {
        "state_matrix": model.state_matrix, "input_matrix": g, "channel": channel, "kernel": spectrum.kernel(time),
        "kernel_state_space": model.kernel(time), "damping_state_space": model.damping(omega),
        "added_mass_inf": np.array([[3.0, 1.0], [1.0, 8.0]]), "time": time, "omega": omega,
    }  # fmt: skip
    for name, values in expected.items():
        np.testing.assert_allclose(found[name].values, values, rtol=1e-12, atol=1e-12, err_msg=name)
    assert found.channel.dims == ("state", "channel_of_order")
    assert found.kernel.dims == found.kernel_state_space.dims == ("time", *pair)
    assert found.influenced_dof.values.tolist() == found.radiating_dof.values.tolist() == labels
    least = np.linalg.eigvalsh(model.damping(omega) / np.outer(own, own)).min()
    assert found.attrs["passivity_margin"] == pytest.approx(least, abs=1e-12)
    told = {name: found.attrs[name] for name in ("order", "fit_error", "history", "spec_id", "spec")}
    assert told == {"order": 3, "fit_error": 0.0123, "history": "as it was repaired", **stamp(spec)}
    assert 0 <= found.attrs["seconds"] < 60


def test_only_what_is_wet_of_an_order_is_fitted_and_stands_at_its_place():
    """The dry one before the wet ones of its order, which are not beside each other; orders alternate."""
    omega = np.linspace(0.1, 12.0, 120)
    bump = omega**3 * np.exp(-2 * omega)
    one = np.stack([bump**0.5, 2 * bump**0.5], axis=1)
    damping = np.zeros((len(omega), 5, 5))
    damping[:, [[2], [4]], [2, 4]] = one[:, :, None] * one[:, None, :]
    damping[:, 1, 1] = 7 * bump
    labels, pair = ["Pitch", "Heave", "Surge", "Yaw", "Bend"], ("influenced_dof", "radiating_dof")
    ds = xr.Dataset(
        {"radiation_damping": (("omega", *pair), damping), "azimuthal_order": ("influenced_dof", [1, 0, 1, 1, 1])},
        coords={"omega": omega, **dict.fromkeys(pair, labels)},
    )
    found = radiation.fit_orders(ds, 1e-4)
    model, error = fit_radiation(DampingSpectrum(omega, damping[:, [[2], [4]], [2, 4]]), 1e-4)
    heave, other = fit_radiation(DampingSpectrum(omega, damping[:, 1:2, 1:2]), 1e-4)
    assert found.error == max(error, other)
    expected = np.zeros((len(omega), 5, 5))
    expected[:, [[2], [4]], [2, 4]], expected[:, 1, 1] = model.damping(omega), heave.damping(omega)[:, 0, 0]
    np.testing.assert_allclose(found.model.damping(omega), expected, atol=1e-12)


@pytest.mark.parametrize(("radius", "gravity", "longest"), [(2.5, 10.0, 20.0), (0.81, 9.0, 12.0)])
def test_the_memory_of_a_buoy_is_shown_for_the_time_of_its_size_and_stored_with_its_error(
    monkeypatch, radius, gravity, longest
):
    """Forty times the root of the radius over gravity; of one channel, with no limit and no history of its own."""
    omega, pair = np.array([0.5, 1.0, 2.5]), ("influenced_dof", "radiating_dof")
    model = RadiationModel(np.array([[-0.5, 1.3], [-1.3, 0.0]]), np.array([[1.0], [0.0]]), np.array([1.0, 0.0]))
    coords = {"omega": omega, **{name: ["Heave"] for name in pair}}
    ds = xr.Dataset({"radiation_damping": (("omega", *pair), model.damping(omega))}, coords)
    ds, asked, saved = ds.assign_attrs(radius=radius, gravity=gravity), [], []
    monkeypatch.setattr(radiation, "load_database", lambda *_: ds)
    monkeypatch.setattr(radiation, "fit_orders", lambda *given: asked.append(given) or radiation.Memory(model, 0.0123))
    monkeypatch.setattr(radiation, "save", lambda *given: saved.append(given))
    radiation.run(RadiationSpec(database="a" * 16, tolerance=2e-3), "d.nc", "memory.nc")
    ((found, out),) = saved
    assert (asked[0][1], out, found.attrs["fit_error"], found.channel.dims) == (2e-3, "memory.nc", 0.0123, ("state",))
    np.testing.assert_allclose(found.time.values, np.linspace(0.0, longest, 401), rtol=1e-12)
    assert not {"added_mass_inf", "history"} & {*found.data_vars, *found.attrs}
