"""Power from strain, a whole run: two ports of strain, the frame held, what the material would allow."""

import numpy as np
import pytest

import vsb
from vsb.results.ladder import study_ladder

pytestmark = pytest.mark.slow
ENERGY, PERIOD = 0.01, 3.0


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A viscous shell of rubber-like stiffness in a regular wave, the optimal dampers at two strains of it."""
    place = tmp_path_factory.mktemp("strain")
    device = {
        "radius": 2.0, "thickness": 0.015, "young_modulus": 40e6, "poisson_ratio": 0.3, "density": 1100.0,
        "mass": 17170.0, "internal_pressure": 16.5e3, "damping": {"maxwell": [{"ratio": 0.2, "time": 0.3}]},
    }  # fmt: skip
    ports = {"area": {"strain": "area"}, "belt": {"strain": "hoop", "belt": [60, 120]}}
    study = vsb.Study.model_validate({
        "study": "strain", "device": device, "designs": {"VSWEC": {}}, "reference_shape": "equilibrium",
        "modes": {"basis": "full", "degree": 4}, "hydro": {"tolerance": 1e-2, "omega_max": 6.0, "witness": "none"},
        "pto": {"ports": ports, "held": {"place": "heave"}, "energy_per_cycle": ENERGY},
        "waves": [{"kind": "regular", "amplitude": 0.1, "period": PERIOD}],
        "simulation": {"duration": 30.0, "window": [18.0, 30.0]},
    })  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        yield vsb.run(study)


def test_levels_of_two_ports_and_of_the_material(results):
    """Of a regular wave the material allows e m/T."""
    levels = results.ladder.set_index("rung").power_mean
    assert levels["best_diagonal"] <= levels["best_damper"] * (1 + 1e-9) <= levels["matched"] * (1 + 2e-9)
    best = results.ladder.query("rung == 'best_damper'")
    assert (best.power_mean * 0.9 < best.low).all()
    assert (best.low < best.power_mean).all()
    assert (best.power_mean < best.high).all()
    device = results.study.device
    mass = 4 * np.pi * device.radius**2 * device.thickness * device.density
    assert levels["material"] == pytest.approx(ENERGY * mass / PERIOD, rel=1e-9)
    (check,) = results.checks.query("name == 'specific_energy'").itertuples()
    assert check.value == pytest.approx(levels["best_damper"] * PERIOD / mass, rel=1e-6)
    assert check.verdict == ("ok" if check.value <= ENERGY else "doubt" if check.value <= 5 * ENERGY else "fail")


def test_level_of_the_material_stands_with_its_sea(results):
    waves = [results.study.waves[0].model_copy(update={"period": period}) for period in (PERIOD, PERIOD + 1)]
    study = results.study.model_copy(update={"waves": tuple(waves)})
    found = [level.wave for level in study_ladder(study, results.plan.database_path)]
    assert found == sorted(found, key=[wave.label for wave in waves].index)


def test_time_and_frequency_domain_and_the_energy_of_a_viscous_shell(results):
    (row,) = results.comparison.itertuples()
    best = results.ladder.query("rung == 'best_damper'").power_mean.item()
    assert row.power_mean == pytest.approx(best, rel=2e-2)
    assert row.energy_residual < 1e-6
