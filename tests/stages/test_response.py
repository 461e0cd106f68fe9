"""Rule response: what a damper takes is half c |w X|^2, never more than its best, that never more than matched."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.motion.port import Port
from vsb.motion.pto import LinearPto
from vsb.report.band import gain_band
from vsb.scenes.afloat import Afloat, afloat
from vsb.stages import response
from vsb.study.body_specs import BodyResponseSpec
from vsb.study.plan import StudyPlan
from vsb.study.sections import Water
from vsb.study.take_off import Pto
from vsb.tools.files import load
from vsb.tools.units import AT_ROTATION, described
from vsb.waves.dispersion import power_limit


@pytest.fixture
def ds(small):
    return load(small.response_files["response"], expected=small.response_id)


def test_power_is_that_of_the_damper_on_heave(small, ds):
    heave = np.abs(ds.rao.sel(dof="Heave").values)
    taken = 0.5 * small.study.pto.damping * (ds.omega.values * heave) ** 2
    np.testing.assert_allclose(ds.absorbed_power.values, taken, rtol=1e-9, atol=1e-12)


def test_the_given_damper_the_best_one_and_matched_take_ever_more_and_the_limit_most(ds):
    slack = 1 + 1e-9
    assert (ds.absorbed_power <= slack * ds.best_power).all()
    assert (ds.best_power <= slack * ds.matched_power).all()
    assert (ds.matched_power.sel(design="FSB") <= 1.005 * ds.power_limit).all()  # within the solver's error


def test_a_port_moves_without_take_off_as_its_velocity_says(ds):
    """The best damper is |Z|, and the wave pushes with V Z."""
    np.testing.assert_allclose(ds.best_damping.values, np.abs(ds.port_impedance.values), rtol=1e-9)
    matched = np.abs(ds.port_velocity * ds.port_impedance) ** 2 / (8 * ds.port_impedance.real)
    np.testing.assert_allclose(ds.matched_power.values, matched.values, rtol=1e-9)


def test_best_dampers_are_those_beside_the_spring_and_the_port_is_that_without(small, ds, tmp_path):
    """A spring adds i k/omega to what a damper sees: best is |Z + i k/omega|, power |V Z|^2 c/(2 |Z + i k/omega + c|^2)."""
    plan = StudyPlan(varied(small.study, pto={"stiffness": 4.0e4}))
    response.run(plan.response, small.database_path, str(tmp_path / "sprung.nc"))
    sprung = load(tmp_path / "sprung.nc")
    shared = np.intersect1d(sprung.omega, ds.omega)  # beside resonances and extremes each has its own
    assert len(shared) > 0.8 * ds.sizes["omega"]
    sprung, ds = sprung.sel(omega=shared), ds.sel(omega=shared)
    np.testing.assert_allclose(sprung.port_impedance.values, ds.port_impedance.values, rtol=1e-12)
    z, pushed = sprung.port_impedance, np.abs(sprung.port_velocity * sprung.port_impedance) ** 2
    seen = z + 4.0e4j / z.omega
    np.testing.assert_allclose(sprung.best_damping.values, np.abs(seen).values, rtol=1e-9)
    assert np.abs(sprung.best_damping / ds.best_damping - 1).max() > 0.1
    for power, damper in (("best_power", np.abs(seen)), ("absorbed_power", small.study.pto.damping)):
        taken = 0.5 * damper * pushed / np.abs(seen + damper) ** 2
        np.testing.assert_allclose(
            sprung[power].values, taken.transpose("design", "omega").values, rtol=1e-8, atol=1e-9
        )


def test_wave_frequencies_are_of_the_grid_and_a_response_made_again_is_the_same(small, ds, tmp_path):
    (wave,) = small.study.waves
    assert wave.omega in ds.omega.values
    response.run(small.response, small.database_path, str(tmp_path / "again.nc"))
    assert load(tmp_path / "again.nc").identical(ds)
    assert set(ds.wet_design.values) == {"FSB", "VSWEC"}


def test_frequencies_show_resonances_and_extremes_of_gains(small, ds):
    """A grid thirty times as fine shows no larger and no smaller gain than the one that is written."""
    floating = afloat(small.response, small.database_path)
    for motions in floating.motions.values():
        natural, _ = replace(floating.linear, pto=LinearPto(0.0, 0.0, floating.port)).natural_modes(motions)
        shown = natural[natural < float(ds.omega[-1])]
        assert np.abs(ds.omega.values[:, None] - shown).min(axis=0).max() < 1e-9
    fine = np.linspace(*ds.omega.values[[0, -1]], 30 * ds.sizes["omega"])
    powers = response.best_powers(small.response, floating, floating.linear, fine)
    found, exact = ((100 * (p / p.sel(design="FSB") - 1)).where(gain_band(p, "FSB")) for p in (ds.best_power, powers))
    assert float(found.max()) == pytest.approx(float(exact.max()), abs=0.05)
    assert float(found.min()) == pytest.approx(float(exact.min()), abs=0.05)


@pytest.mark.parametrize("port", ["pitch", {"dof": "Roll"}])
def test_a_response_at_a_rotation_is_in_units_of_moments(port, ds):
    told = described(ds.assign_attrs(port=response.port_in_words(Pto(port=port))))
    seen = ("port_impedance", "port_velocity", "best_damping")
    assert [told[name].attrs["units"] for name in seen] == [AT_ROTATION[name] for name in seen]


def test_a_response_has_five_steps_in_one_of_the_database_and_what_is_asked_for():
    assert response.refined(np.array([1.0, 1.5, 2.5]), [2.2, 1.5]) == pytest.approx(
        [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 1.9, 2.1, 2.2, 2.3, 2.5]
    )


# hand-made motions ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rings:
    """A motion of two degrees of freedom whose answers are plain numbers of what it is asked."""

    database: xr.Dataset
    direction: float = 0.0
    pto: LinearPto | None = None
    orders: str = "orders"

    def port(self, omega, motions, port):
        """A port that depends on everything."""
        size = 1.0 + motions.sum() + port @ [1.0, 10.0]
        admittance = (0.01 + 0.02j * omega) / size
        return Port(omega, admittance, (1.0 + 1j * self.direction) * size * np.ones(len(omega)) + 0j, 1.0)

    def rao(self, omega, motions):
        """Damper, spring and direction at every frequency."""
        np.testing.assert_array_equal(self.pto.direction(2), PORT_IN)
        damping = np.broadcast_to(self.pto.damping, omega.shape)
        return np.stack([damping + 1j * self.pto.stiffness, motions.sum() + 1j * self.direction + 0 * omega], axis=1)

    def absorbed_power(self, omega, rao):
        """A number of both."""
        return np.abs(rao).sum(axis=1) * omega

    def natural_modes(self, motions):
        """As many as there are motions: none of what drifts."""
        np.testing.assert_array_equal(self.pto.direction(2), PORT_IN)
        count = np.arange(motions.shape[1])
        return 3.0 + count + motions.sum(), 0.01 * self.pto.damping + 1e-3 * self.pto.stiffness + count


OMEGA, PORT_IN, WATER = np.array([0.5, 1.0, 2.0]), np.array([1.0, 0.2]), Water(density=1000.0, depth=7.0)
MOTIONS = {"A": np.eye(2), "B": np.array([[1.0], [0.5]]), "C": np.zeros((2, 0))}


@pytest.fixture
def written(monkeypatch):
    """Function spec, reached -> what a response writes of three designs of such a motion."""
    database = xr.Dataset(coords={"influenced_dof": ["Heave", "Pitch"], "omega": OMEGA})
    floating, found = Afloat(Rings(database), MOTIONS, PORT_IN), []
    monkeypatch.setattr(response, "afloat", lambda spec, path: floating)
    monkeypatch.setattr(response, "LinearBuoy", Rings)
    monkeypatch.setattr(response, "stamp", lambda spec, *paths: {"spec_id": f"of {' '.join(paths)}"})
    monkeypatch.setattr(response, "save", lambda ds, out: found.append((ds, out)))
    monkeypatch.setattr(response.response, "frequency_grid", lambda *given: found.append(given) or OMEGA)

    def by(reached=1, directions=(), **pto):
        monkeypatch.setattr(response, "channels_reached", lambda port, orders: reached)
        spec = SimpleNamespace(
            pto=Pto(**pto), water=WATER, designs=dict.fromkeys(MOTIONS), directions=directions,
            reference_design=None, step=0.1, lowest=0.2, omega_max=3.0, omega=(0.7,),
        )  # fmt: skip
        response.run(spec, "database.nc", "out.nc")
        grid, (ds, out) = found
        assert (grid, out) == ((0.1, 0.2, 3.0, (0.7,)), "out.nc")
        return ds

    return by


def test_each_design_has_its_own_damper_or_the_best_one_of_each_frequency(written):
    given = written(damping={"A": 5.0, "B": 7.0, "C": 0.0}, stiffness=30.0)
    np.testing.assert_allclose(given.rao.values[:, :, 0], np.array([[5.0], [7.0], [0.0]]) + 30j + 0 * OMEGA)
    assert given.attrs["take_off"] == "the given damping"
    assert given.attrs["spec_id"] == "of database.nc"
    assert given.dof.values.tolist() == ["Heave", "Pitch"]
    power = np.abs(given.rao).sum("dof") * OMEGA
    np.testing.assert_allclose(given.absorbed_power.values, power.values)
    beside = given.port_impedance.values + 30j / OMEGA  # the best is beside the spring whatever damper is given
    np.testing.assert_allclose(given.best_damping.values, np.abs(beside))
    pushed = np.abs(given.port_velocity.values * given.port_impedance.values) ** 2
    np.testing.assert_allclose(given.best_power.values, pushed / (4 * (np.abs(beside) + beside.real)))


@pytest.mark.parametrize("stiffness", [0.0, 30.0, -4.0])
def test_without_a_damper_best_ones_are_taken_and_natural_modes_are_without_any(written, stiffness):
    """The port is seen without the spring, best dampers and what they take beside it; what drifts has no mode."""
    found = written(stiffness=stiffness)
    assert found.attrs["take_off"] == "best_damping at each frequency"
    sizes = [1.0 + m.sum() + PORT_IN @ [1.0, 10.0] for m in MOTIONS.values()]
    impedance = np.array([size / (0.01 + 0.02j * OMEGA) for size in sizes])
    np.testing.assert_allclose(found.port_impedance.values, impedance)
    np.testing.assert_allclose(found.port_velocity.values, np.outer(sizes, np.ones(3)))
    beside = impedance + 1j * stiffness / OMEGA
    np.testing.assert_allclose(found.best_damping.values, np.abs(beside))
    np.testing.assert_allclose(found.rao.values[:, :, 0], np.abs(beside) + 1j * stiffness)
    pushed = np.abs(found.port_velocity.values * impedance) ** 2
    np.testing.assert_allclose(found.best_power.values, pushed / (4 * (np.abs(beside) + beside.real)))
    np.testing.assert_allclose(found.matched_power.values, pushed / (8 * impedance.real))
    assert found.wet_design.values.tolist() == ["A", "A", "B"]
    np.testing.assert_allclose(found.wet_natural_frequency.values, [5.0, 6.0, 4.5])
    np.testing.assert_allclose(found.wet_damping_ratio.values, 1e-3 * stiffness + np.array([0.0, 1.0, 0.0]))


def test_natural_modes_are_damped_by_the_damper_of_their_own_design(written):
    found = written(damping={"A": 5.0, "B": 7.0, "C": 2.0})
    np.testing.assert_allclose(found.wet_damping_ratio.values, [0.05, 1.05, 0.07])


def test_waves_of_several_directions_have_one_more_dimension(written):
    """In radians; what does not depend on them has none."""
    found = written(directions=(0.0, 90.0, 30.0), damping=5.0)
    turned = np.deg2rad([0.0, 90.0, 30.0])
    np.testing.assert_allclose(found.wave_direction.values, turned)
    for name in ("rao", "absorbed_power", "port_velocity", "best_power", "matched_power"):
        assert found[name].dims[0] == "wave_direction"
    for name in ("port_impedance", "best_damping", "power_limit", "wet_natural_frequency"):
        assert "wave_direction" not in found[name].dims
    np.testing.assert_allclose(found.rao.isel(dof=1, design=1, omega=0).values, 1.5 + 1j * turned)
    sizes = np.array([1.0 + m.sum() + PORT_IN @ [1.0, 10.0] for m in MOTIONS.values()])
    np.testing.assert_allclose(found.port_velocity.values[:, :, 2], (1 + 1j * turned)[:, None] * sizes)


def test_a_body_responds_at_the_frequencies_of_its_database_and_between_them(monkeypatch):
    """And at those of its seas, each in all directions; of no body a limit is known."""
    database, found = xr.Dataset(coords={"influenced_dof": ["Heave", "Pitch"], "omega": OMEGA}), []
    monkeypatch.setattr(response, "afloat", lambda spec, path: Afloat(Rings(database), MOTIONS, PORT_IN))
    monkeypatch.setattr(response, "stamp", lambda spec, *paths: {})
    monkeypatch.setattr(response, "save", lambda ds, out: found.append(ds))
    asked = {
        "water": WATER,
        "designs": dict.fromkeys(MOTIONS, SimpleNamespace(rigid=False)),
        "directions": (0.0, 90.0),
        "omega": (0.77, 1.3),
    }
    response.run(BodyResponseSpec.model_construct(pto=Pto(damping=5.0), **asked), "database.nc", "out.nc")
    (ds,) = found
    np.testing.assert_allclose(ds.omega.values, response.refined(OMEGA, (0.77, 1.3)))
    assert ds.rao.shape == (2, 3, len(ds.omega), 2)
    assert "limit" not in ds.attrs


@pytest.mark.parametrize(("reached", "told"), [(1, None), (3, "3 λ/2π")])
def test_the_limit_is_that_of_all_channels_a_port_reaches(written, reached, told):
    """Of waves in water of the study's own depth and density."""
    found = written(reached, damping=5.0)
    exact = [reached * power_limit(w, 7.0, 1000.0, WATER.gravity) for w in OMEGA]
    np.testing.assert_allclose(found.power_limit.values, exact)
    assert found.attrs.get("limit") == told


@pytest.mark.parametrize(("port", "words"), [
    ("heave", "heave"), ("surge", "surge"),
    ("volume", "volume: pressure against volume flow, impedance in Pa s/m^3, velocity in m^2/s"),
    ("pitch", "pitch: moment against angular velocity, impedance in N m s, velocity in rad/s"),
    ({"dof": "Heave"}, '{"dofs":{"Heave":1.0}}'),
])  # fmt: skip
def test_a_port_is_told_with_its_units_where_it_is_no_displacement(port, words):
    assert response.port_in_words(Pto(port=port)) == words
