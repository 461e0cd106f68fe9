"""Rule response: what a damper takes is half c |w X|^2, never more than its best, that never more than matched."""

import numpy as np
import pytest
from conftest import varied

from vsb.stages import response
from vsb.study.plan import StudyPlan
from vsb.study.take_off import Pto
from vsb.tools.files import load
from vsb.tools.units import AT_ROTATION, described


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


@pytest.mark.parametrize("port", ["pitch", {"dof": "Roll"}])
def test_a_response_at_a_rotation_is_in_units_of_moments(port, ds):
    told = described(ds.assign_attrs(port=response.port_in_words(Pto(port=port))))
    seen = ("port_impedance", "port_velocity", "best_damping")
    assert [told[name].attrs["units"] for name in seen] == [AT_ROTATION[name] for name in seen]


def test_a_response_has_five_steps_in_one_of_the_database_and_what_is_asked_for():
    assert response.refined(np.array([1.0, 1.5, 2.5]), [2.2, 1.5]) == pytest.approx(
        [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 1.9, 2.1, 2.2, 2.3, 2.5]
    )
