"""Shape dependence of the coefficients: slopes of power against responses on deformed shapes, powers along a motion."""

import dataclasses

import numpy as np
import pytest
from conftest import varied

from vsb.engine.hydro.database import with_structure
from vsb.engine.hydro.shape_dependence import ShapeDatabase, ShapeFamily, measured_errors
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.shell.loaded import equilibrium
from vsb.models import shape_dependence as shapedependence
from vsb.models.rest import design_motions, loaded_shell, reference_shell
from vsb.models.shape_dependence import INSTANTS, StudyMotion, answer, power_effects
from vsb.stages import shape_dependence as stage
from vsb.tools import files

OMEGAS = (0.8, 1.6, 2.4, 3.2, 4.8, 6.4)


def family_of(shape, **options):
    return ShapeFamily(shape, OMEGAS, 1025.0, 9.81, **{"nodes": 20, **options})


@pytest.fixture(scope="module")
def small(seed):
    """The seed with four degrees of freedom, in the waves of a solved frequency."""
    waves = [{"kind": "regular", "amplitude": 0.2, "period": 2 * np.pi / 2.4}]
    return varied(seed, modes={"degree": 2}, waves=waves)


@pytest.fixture(scope="module")
def reference(small):
    return reference_shell(small)


@pytest.fixture(scope="module")
def family(reference):
    return family_of(reference.shape)


@pytest.fixture(scope="module")
def motion(small, reference, family):
    return StudyMotion.of(small, reference, family)


@pytest.fixture(scope="module")
def dataset(small, family):
    """All of the study."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shapedependence, "SAMPLES", 1)
        return shapedependence.shape_dataset(small, family, samples=4)


def test_power_slope_matches_responses_on_deformed_shapes(small, reference, family, motion):
    def power(eta, design):
        ds = with_structure(family.at(eta), reference)
        buoy = LinearSystem(ds, reference.basis.damping, LinearPto(small.pto.damping))
        omega = np.array(OMEGAS)
        return buoy.absorbed_power(omega, buoy.rao(omega, design_motions(small, reference.basis, design)))

    changes = shapedependence.power_changes(motion, family)
    direction, h = np.array([0.6, 0.3, -0.5, 0.4]), 4e-3
    for design in ("FSB", "VSWEC"):
        d = [(power(s * h * direction, design) - power(-s * h * direction, design)) / (2 * s * h) for s in (1, 2)]
        got = direction @ changes.power_slope.sel(design=design).values
        np.testing.assert_allclose(got, (4 * d[0] - d[1]) / 3, rtol=1e-5, atol=1e-5 * np.abs(got).max())
        np.testing.assert_allclose(changes.absorbed_power.sel(design=design), power(0 * direction, design), rtol=1e-12)


@pytest.mark.slow
def test_relative_slopes_are_logarithmic_derivatives(dataset, family):
    h = 0.01
    for name in ("added_mass", "excitation_force"):
        heave = [
            np.abs(family.at(np.array([s * h, 0, 0, 0]))[name].values.reshape(len(OMEGAS), -1)[:, 0]) for s in (1, -1)
        ]
        got = shapedependence.relative_slope(dataset, name).sel(shape_dof="Heave")
        np.testing.assert_allclose(got, np.log(heave[0] / heave[1]) / (2 * h), rtol=2e-3, atol=1e-4)


def test_database_covers_the_motion_within_its_estimated_error(dataset, motion, family):
    database, shapes = ShapeDatabase(dataset), motion.shapes("VSWEC", "regular_A0.2_T2.61799")
    np.testing.assert_array_equal(database.reach, motion.reach)
    every = np.concatenate([motion.shapes(*run) for run in motion.runs])
    assert np.abs(every[:, 0]).max() == motion.reach[0] > 0.1
    assert np.all(np.abs(every) <= motion.reach)
    some = shapes[:: INSTANTS // 6]
    estimated = np.array([list(database.error(eta).values()) for eta in some])
    assert np.all(measured_errors(database, family, some) <= estimated)


def test_power_along_the_motion_matches_solutions_on_its_shapes(dataset, motion, small, reference, family):
    wave = small.waves[0].label
    waves, motions = motion.runs["VSWEC", wave]
    run = dataset.sel(design="VSWEC", wave=wave)
    for i in (0, INSTANTS // 4, INSTANTS // 2, 3 * INSTANTS // 4):
        solved = with_structure(family.at(motion.shapes("VSWEC", wave)[i]), reference)
        buoy = dataclasses.replace(motion.buoy, database=solved)
        expected = shapedependence.mean_power(buoy, buoy.coefficients(waves.omega), waves, motions)
        assert float(run.power_at_shape[i]) == pytest.approx(expected, rel=3e-3)
    assert np.ptp(run.power_at_shape.values) > 0.05 * float(run.power_at_reference)


def test_power_swing_is_the_first_order_of_small_motions(small, dataset, motion):
    """The remainder is of second order in the scale of the motion."""
    wave, database = small.waves[0], ShapeDatabase(dataset)
    waves, motions = motion.runs["VSWEC", wave.label]
    passed, errors = motion.shapes("VSWEC", wave.label), []
    swing = float(dataset.power_swing.sel(design="VSWEC").sel(omega=wave.omega, method="nearest"))
    power = float(dataset.power_at_reference.sel(design="VSWEC", wave=wave.label))
    for scale in (0.2, 0.1, 0.05, 0.025):
        found = [shapedependence.mean_power(motion.buoy, database.at(waves.omega, scale * eta), waves, motions)
                 for eta in passed]  # fmt: skip
        expected = scale * wave.amplitude * swing * wave.amplitude**2
        errors.append(abs((max(found) - min(found)) / 2 - expected) / power)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 1.7), (errors, orders)


def test_power_at_rest_is_that_of_the_equilibrium_shape(dataset, small, reference, family, motion):
    wave = small.waves[0].label
    q = equilibrium(loaded_shell(small, reference.basis))
    buoy = dataclasses.replace(motion.buoy, database=with_structure(family.at(q), reference))
    waves, motions = motion.runs["VSWEC", wave]
    expected = shapedependence.mean_power(buoy, buoy.coefficients(waves.omega), waves, motions)
    assert float(dataset.power_at_rest.sel(design="VSWEC", wave=wave)) == pytest.approx(expected, rel=1e-12)
    fsb = dataset.sel(design="FSB", wave=wave)  # a rigid buoy floats where it is placed
    assert float(fsb.power_at_rest) == pytest.approx(float(fsb.power_at_reference), rel=1e-9)


@pytest.mark.parametrize(
    ("passed", "rest", "verdict"),
    [(0.009, -0.009, "may be ignored"), (0.05, 0.009, "averages out"), (0.009, 0.011, "matters")],
)
def test_verdict_on_shape_dependence(passed, rest, verdict, dataset):
    # the data set with other powers of one run, in terms of that of the reference shape
    run = dataset.isel(design=[1], wave=[0])
    phase = np.sin(2 * np.pi * np.arange(INSTANTS) / INSTANTS)
    power = run.power_at_reference.values[0, 0]
    ds = run.assign(
        power_at_shape=(run.power_at_shape.dims, power * (1 + passed * phase)[None, None]),
        power_at_rest=(run.power_at_rest.dims, [[power * (1 + rest)]]),
    )
    line = answer(ds, "seed")
    assert line.startswith(f"seed: the shape dependence {verdict} (limit 1 % of mean power): VSWEC, regular")
    assert f"changes by {-100 * passed:+.2g} to {100 * passed:+.2g} % by the shapes of the motion" in line
    assert f"{100 * rest:+.2g} % by that of the shape at rest" in line
    (effects,) = power_effects(ds).values()
    assert effects["average"] == pytest.approx(0.0, abs=1e-12)
    assert "\n" not in line


@pytest.fixture
def coarsely(monkeypatch, seed):
    """The rigid seed whose study's family is coarse; and every shape solved is noted."""
    solved, solve = [], ShapeFamily.solved

    def noted(self):
        solved.append(self.identity)
        return solve(self)

    monkeypatch.setattr(ShapeFamily, "solved", noted)
    monkeypatch.setattr(shapedependence, "SAMPLES", 1)
    monkeypatch.setattr(stage, "study_family", lambda study, reference: family_of(reference.shape, nodes=16))
    return varied(seed, designs={"FSB": {"flexible": False}}), solved


@pytest.mark.slow
def test_interrupted_run_is_resumed(coarsely, tmp_path, monkeypatch):
    """No shape is solved twice, a complete file is not solved again, nothing else is left behind."""
    study, solved = coarsely
    out = [str(tmp_path / name) for name in ("a.nc", "a.svg")]
    with monkeypatch.context() as patch:
        patch.setattr(shapedependence, "power_changes", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            stage.shape_dependence(study, *out)
    before = len(solved)
    assert before > 20
    assert not (tmp_path / "a.nc").exists()
    line = stage.shape_dependence(study, *out)
    assert len(set(solved)) == len(solved) == before
    assert stage.shape_dependence(study, *out) == line
    assert len(solved) == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.nc", "a.svg"]
    assert "size of the deformation" in (tmp_path / "a.svg").read_text()
    assert ShapeDatabase(files.load(out[0])).labels == ["Heave"]
    assert answer(files.load(out[0]), study.study) == line


OF_GRID = (2.0, pytest.approx(2.4), 4.0, 6.0, 8.0, 10.0, 12.0)


def test_frequencies_contain_those_of_the_waves(small, reference):
    family = shapedependence.study_family(small, reference, frequencies=6)
    assert family.omegas == OF_GRID
    others = [
        {"kind": "regular", "amplitude": 0.1, "period": 2 * np.pi / 7},
        {"kind": "white_noise", "hs": 0.3, "band": [3.0, 5.0]},
    ]
    more = varied(small, waves=[*small.waves, {"kind": "still"}, *others])
    omegas = shapedependence.study_family(more, reference, frequencies=6).omegas
    assert omegas == (*OF_GRID[:4], pytest.approx(7.0), *OF_GRID[4:])
