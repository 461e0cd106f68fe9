import dataclasses
import itertools
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import ConfigError, ConvergenceError
from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import with_structure
from vsb.hydro.shapes.database import ShapeDatabase, measured_errors
from vsb.hydro.shapes.family import ShapeFamily
from vsb.motion.frequency import LinearBuoy
from vsb.motion.pto import LinearPto
from vsb.report.shape_figures import shape_figure
from vsb.scenes import shape_dependence as shapedependence
from vsb.scenes.directions import loaded_shell
from vsb.scenes.rest import design_motions, reference_shell
from vsb.scenes.shape_dependence import INSTANTS, StudyMotion, answer, power_effects
from vsb.shell.loaded import equilibrium
from vsb.stages import shape_dependence as stage
from vsb.study import study as config
from vsb.tools import files
from vsb.waves.seas import sea

HERE = Path(__file__).parents[1]
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
    return StudyMotion(small, reference, shapedependence.linear_buoy(small, reference, family))


@pytest.fixture(scope="module")
def counted(small, reference):
    """All of the study, and how many shapes it took."""
    seen = []
    family = family_of(reference.shape, after_each=lambda: seen.append(1))
    return shapedependence.shape_dataset(small, family, samples=4), len(seen)


@pytest.fixture(scope="module")
def dataset(counted):
    return counted[0]


def test_the_power_slope_is_that_of_the_response_on_deformed_shapes(small, reference, family):
    def power(eta, design):
        ds = with_structure(family.at(eta), reference)
        buoy = LinearBuoy(ds, reference.basis.damping, LinearPto(small.pto.damping))
        omega = np.array(OMEGAS)
        return buoy.absorbed_power(omega, buoy.rao(omega, design_motions(small, reference.basis, design)))

    changes = shapedependence.power_changes(small, reference, family)
    direction, h = np.array([0.6, 0.3, -0.5, 0.4]), 4e-3
    for design in ("FSB", "VSWEC"):
        d = [(power(s * h * direction, design) - power(-s * h * direction, design)) / (2 * s * h) for s in (1, 2)]
        got = direction @ changes.power_slope.sel(design=design).values
        np.testing.assert_allclose(got, (4 * d[0] - d[1]) / 3, rtol=1e-5, atol=1e-5 * np.abs(got).max())
        np.testing.assert_allclose(changes.absorbed_power.sel(design=design), power(0 * direction, design), rtol=1e-12)


def test_the_swing_is_the_largest_change_over_a_cycle(small, reference, family):
    changes = shapedependence.power_changes(small, reference, family)
    buoy = LinearBuoy(with_structure(family.centre, reference), reference.basis.damping, LinearPto(small.pto.damping))
    q = buoy.rao(np.array(OMEGAS), design_motions(small, reference.basis, "VSWEC"))
    phase = np.linspace(0, 2 * np.pi, 2001)
    motion = np.real(q[:, :, None] * np.exp(-1j * phase))
    change = np.einsum("kw,wkt->wt", changes.power_slope.sel(design="VSWEC").values, motion)
    np.testing.assert_allclose(changes.power_swing.sel(design="VSWEC"), change.max(axis=1), rtol=1e-5)


def test_power_of_the_undeformed_sphere(small, reference, family):
    """None about the sphere itself; about another shape, minus its amplitudes times the slope."""
    assert np.all(shapedependence.power_changes(small, reference, family).power_undeformed == 0)
    q = np.array([0.1, 0.05, 0.0, -0.02])
    moved = dataclasses.replace(reference, shape=dataclasses.replace(reference.shape, modal_amplitude=q))
    changes = shapedependence.power_changes(small, moved, family)
    np.testing.assert_allclose(
        changes.power_undeformed, -np.einsum("k,dkw->dw", q, changes.power_slope.values), rtol=1e-12
    )


def test_everything_has_units_and_the_dimensions_named(dataset):
    assert all(data.attrs["units"] for data in dataset.data_vars.values())
    assert dataset.added_mass_slope.dims == ("shape_dof", "omega", "influenced_dof", "radiating_dof")
    assert dataset.excitation_force_curvature.dims == (
        "shape_dof",
        "other_shape_dof",
        "omega",
        "wave_direction",
        "influenced_dof",
    )
    assert dataset.added_mass_inf_slope.dims == ("shape_dof", "influenced_dof", "radiating_dof")
    assert dataset.radiation_damping_slope.attrs["units"] == "kg/(m s)"


def test_relative_slopes_are_logarithmic_derivatives(dataset, family):
    h = 0.01
    for name in ("added_mass", "excitation_force"):
        heave = [
            np.abs(family.at(np.array([s * h, 0, 0, 0]))[name].values.reshape(len(OMEGAS), -1)[:, 0]) for s in (1, -1)
        ]
        got = shapedependence.relative_slope(dataset, name).sel(shape_dof="Heave")
        np.testing.assert_allclose(got, np.log(heave[0] / heave[1]) / (2 * h), rtol=2e-3, atol=1e-4)


def test_the_table_of_errors_is_that_of_the_family(dataset, family):
    size = float(dataset.deformation[2])
    found = family.interpolation_error(size, samples=shapedependence.SAMPLES).to_array().max("variable")
    at = dataset.interpolation_error.sel(deformation=size)
    assert float(at.sel(expansion="first")) == pytest.approx(float(found.sel(order=1)), rel=1e-9)
    assert float(at.sel(expansion="second")) == pytest.approx(float(found.sel(order=2)), rel=1e-9)


def test_the_figure_shows_heave_the_largest_mode_and_power(dataset):
    slopes, errors, powers = shape_figure(dataset).axes
    labels = [line.get_label() for line in slopes.get_lines()]
    assert shapedependence.largest_mode(dataset) == "Membrane0"
    assert labels == [f"{s} by {m}" for m in ("Heave", "Membrane0") for s in ("added mass", "damping", "excitation")]
    np.testing.assert_array_equal(errors.get_lines()[0].get_ydata(), dataset.interpolation_error.sel(expansion="first"))
    run = dataset.isel(design=1, wave=0)
    expected = 100 * (run.power_at_shape / run.power_at_reference - 1)
    drawn = next(line for line in powers.get_lines() if line.get_label() == "VSWEC")
    np.testing.assert_allclose(drawn.get_ydata(), expected)


def test_the_database_of_a_study_covers_its_motion(dataset, motion, family):
    """Its estimate holds on the very shapes the study passes through."""
    database, shapes = ShapeDatabase(dataset), motion.shapes("VSWEC", "regular_A0.2_T2.61799")
    np.testing.assert_array_equal(database.reach, motion.reach)
    every = np.concatenate([motion.shapes(*run) for run in motion.runs])
    assert np.abs(every[:, 0]).max() == motion.reach[0] > 0.1
    assert np.all(np.abs(every) <= motion.reach)
    some = shapes[:: INSTANTS // 6]
    estimated = np.array([list(database.error(eta).values()) for eta in some])
    assert np.all(measured_errors(database, family, some) <= estimated)


def test_the_motion_is_the_response(motion, small):
    """Its amplitude in a regular wave is |RAO| a, but for the spacing of the instants."""
    wave = small.waves[0]
    rao = motion.buoy.rao(np.array([wave.omega]), design_motions(small, motion.reference.basis, "VSWEC"))[0]
    largest = np.abs(motion.shapes("VSWEC", wave.label)).max(axis=0)
    np.testing.assert_allclose(largest, np.abs(rao) * wave.amplitude, rtol=(np.pi / INSTANTS) ** 2)


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC0", "VSWEC90"])
def test_mean_power_is_that_of_the_buoy(motion, small, design):
    waves, motions = motion.runs[design, small.waves[0].label]
    c = motion.buoy.coefficients(waves.omega)
    expected = waves.mean_of(motion.buoy.absorbed_power(waves.omega, motion.buoy.rao(waves.omega, motions)))
    assert shapedependence.mean_power(motion.buoy, c, waves, motions) == pytest.approx(expected, rel=1e-12)
    silent = Coefficients(c.added_mass, c.damping, 0 * c.excitation)
    assert shapedependence.mean_power(motion.buoy, silent, waves, motions) == 0


def test_power_along_the_motion_is_that_of_solutions_on_its_shapes(dataset, motion, small, reference, family):
    """Within what the database's error can do to it; and not the power of the reference shape."""
    wave = small.waves[0].label
    waves, motions = motion.runs["VSWEC", wave]
    run = dataset.sel(design="VSWEC", wave=wave)
    for i in (0, INSTANTS // 4, INSTANTS // 2, 3 * INSTANTS // 4):
        solved = with_structure(family.at(motion.shapes("VSWEC", wave)[i]), reference)
        buoy = dataclasses.replace(motion.buoy, database=solved)
        expected = shapedependence.mean_power(buoy, buoy.coefficients(waves.omega), waves, motions)
        assert float(run.power_at_shape[i]) == pytest.approx(expected, rel=3e-3)
    assert np.ptp(run.power_at_shape.values) > 0.05 * float(run.power_at_reference)


def test_the_swing_of_power_is_the_first_order_of_a_small_motion(small, dataset, motion):
    """A tenth of the wave: the largest relative change is `power_swing` a to first order; the next is ten times less."""
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


def test_power_at_rest_is_that_of_the_loaded_shape(dataset, small, reference, family, motion):
    wave = small.waves[0].label
    q = equilibrium(loaded_shell(small, reference.basis))
    buoy = dataclasses.replace(motion.buoy, database=with_structure(family.at(q), reference))
    waves, motions = motion.runs["VSWEC", wave]
    expected = shapedependence.mean_power(buoy, buoy.coefficients(waves.omega), waves, motions)
    assert float(dataset.power_at_rest.sel(design="VSWEC", wave=wave)) == pytest.approx(expected, rel=1e-12)
    fsb = dataset.sel(design="FSB", wave=wave)  # a rigid buoy floats where it is placed
    assert float(fsb.power_at_rest) == pytest.approx(float(fsb.power_at_reference), rel=1e-9)


def test_about_the_equilibrium_the_shape_at_rest_is_the_reference():
    study = config.load(HERE.parent / "config" / "pressurised.yaml")
    assert not StudyMotion(study, reference_shell(study), None).rest("VSWEC").any()


def test_a_shell_that_gives_way_has_no_power_at_rest(dataset, small, family, motion, monkeypatch):
    def collapsed(loaded, motions):
        raise ConvergenceError("the shell buckles")

    monkeypatch.setattr(shapedependence, "equilibrium", collapsed)
    powers = shapedependence.study_powers(motion, family, ShapeDatabase(dataset))
    assert set(powers.data_vars) == {"power_at_reference", "power_at_shape"}
    assert "no shape at rest found" in answer(powers, "seed")
    assert len(shape_figure(dataset.drop_vars("power_at_rest")).axes) == 3


def with_powers(dataset, passed, rest):
    """The data set with other powers of one run, in terms of that of the reference shape."""
    run = dataset.isel(design=[1], wave=[0])
    phase = np.sin(2 * np.pi * np.arange(INSTANTS) / INSTANTS)
    power = run.power_at_reference.values[0, 0]
    return run.assign(
        power_at_shape=(run.power_at_shape.dims, power * (1 + passed * phase)[None, None]),
        power_at_rest=(run.power_at_rest.dims, [[power * (1 + rest)]]),
    )


@pytest.mark.parametrize(
    ("passed", "rest", "verdict"),
    [
        (0.009, -0.009, "may be ignored"),
        (0.05, 0.009, "averages out"),
        (0.009, 0.011, "matters"),
        (0.05, -0.05, "matters"),
    ],
)
def test_the_answer_is_one_line(passed, rest, verdict, dataset):
    ds = with_powers(dataset, passed, rest)
    line = answer(ds, "seed")
    assert line.startswith(f"seed: the shape dependence {verdict} (limit 1 % of mean power): VSWEC, regular")
    assert f"changes by {-100 * passed:+.2g} to {100 * passed:+.2g} % by the shapes of the motion" in line
    assert f"{100 * rest:+.2g} % by that of the shape at rest" in line
    (effects,) = power_effects(ds).values()
    assert effects["average"] == pytest.approx(0.0, abs=1e-12)
    assert "\n" not in line


def test_effects_are_the_extremes_and_the_mean_of_all_shapes_passed(dataset):
    """Of shapes among which most are alike: neither the first nor the middle of the extremes is their mean."""
    run = with_powers(dataset, 0.0, 0.03)
    changes = np.full(run.power_at_shape.shape, 0.01)
    changes[..., 1], changes[..., -1] = -0.2, 0.5
    power = float(run.power_at_reference.values[0, 0])
    (effects,) = power_effects(run.assign(power_at_shape=(run.power_at_shape.dims, power * (1 + changes)))).values()
    assert effects == pytest.approx({"least": -0.2, "most": 0.5, "average": changes.mean(), "rest": 0.03}, rel=1e-9)


def test_the_answer_is_by_the_run_it_matters_most_to(dataset):
    effects = power_effects(dataset)
    assert len(effects) == 4
    (design, _), _ = max(effects.items(), key=lambda item: max(map(abs, item[1].values())))
    assert f"{design}, regular" in answer(dataset, "seed")


def test_a_run_matters_by_its_largest_change_not_its_least(dataset, monkeypatch):
    designs, wave = dataset.design.values, str(dataset.wave.values[0])
    swings = {"least": -0.05, "most": 0.05, "average": 0.0, "rest": 0.0}
    lasts = {"least": 0.01, "most": 0.02, "average": 0.015, "rest": 0.02}
    loses = {"least": -0.2, "most": 0.01, "average": -0.1, "rest": -0.1}
    for first, second, worst in ((swings, lasts, 0), (lasts, swings, 1), (loses, swings, 0), (swings, loses, 1)):
        effects = {(str(designs[0]), wave): first, (str(designs[1]), wave): second}
        monkeypatch.setattr(shapedependence, "power_effects", lambda ds, effects=effects: effects)
        assert f"matters (limit 1 % of mean power): {designs[worst]}, " in answer(dataset, "seed")


def test_effects_are_the_same_of_any_power(dataset):
    powers = ["power_at_reference", "power_at_shape", "power_at_rest"]
    small = dataset.assign({name: 1e-6 * dataset[name] for name in powers})
    for run, effects in power_effects(dataset).items():
        assert power_effects(small)[run] == pytest.approx(effects, abs=1e-12)


def test_without_power_there_is_nothing_to_answer(dataset):
    silent = dataset.assign(
        power_at_reference=0 * dataset.power_at_reference, power_at_shape=0 * dataset.power_at_shape
    )
    assert answer(silent, "seed") == "seed: no power is absorbed, so none depends on the shape"
    assert len(shape_figure(silent).axes) == 2


def test_powers_stand_under_their_own_runs_whatever_the_names(monkeypatch):
    """Designs and seas in the order of the study."""
    names = [("b", "z"), ("b", "y"), ("a", "z"), ("a", "y")]
    known = {run: float(1 + place) for place, run in enumerate(names)}
    monkeypatch.setattr(
        shapedependence, "_run_powers", lambda motion, database, run: (known[run], [10 * known[run]] * INSTANTS)
    )
    monkeypatch.setattr(shapedependence, "_power_at_rest", lambda motion, family, run: 100 * known[run])
    found = shapedependence.study_powers(SimpleNamespace(runs=dict.fromkeys(names)), None, None)
    assert (found.design.values.tolist(), found.wave.values.tolist()) == (["b", "a"], ["z", "y"])
    for (design, wave), power in known.items():
        one = found.sel(design=design, wave=wave)
        assert (one.power_at_reference.item(), one.power_at_rest.item()) == (power, 100 * power)
        assert one.power_at_shape.values.tolist() == [10 * power] * INSTANTS


def test_in_still_water_there_is_nothing_to_answer(small, reference, family, dataset):
    motion = StudyMotion(varied(small, waves=[{"kind": "still"}]), reference, None)
    powers = shapedependence.study_powers(motion, family, ShapeDatabase(dataset))
    assert answer(powers, "seed") == "seed: no power is absorbed, so none depends on the shape"
    np.testing.assert_array_equal(motion.reach, np.full(4, shapedependence.LEAST_REACH * 2.0))


@pytest.mark.parametrize("place", [1, 2, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_mode_is_the_one_of_the_largest_relative_slope_heave_left_out(place, sign):
    """Wherever it stands among the shapes, whatever its sign, at whatever frequency, however much heave changes."""
    slope = np.full((4, 2, 2), 0.1)
    slope[0], slope[place] = 9.0, np.array([[0.0], [sign * 2.0]])
    ds = xr.Dataset(
        {
            "added_mass": (("omega", "influenced_dof"), [[2.0, 1.0], [4.0, 1.0]]),
            "added_mass_slope": (("shape_dof", "omega", "influenced_dof"), slope),
        },
        {"shape_dof": ["Heave", "Membrane0", "Membrane2", "Bending2"]},
    )
    assert shapedependence.largest_mode(ds) == ds.shape_dof.values[place]


def test_an_irregular_sea_is_looked_at_over_the_run(small, reference, family):
    wave = {"kind": "jonswap", "gamma": 3.3, "hs": 0.3, "tp": 3.0, "seed": 3}
    study = varied(small, waves=[wave], simulation={"duration": 20.0, "window": (10.0, 20.0)}, hydro={"omega_max": 6.0})
    wide = dataclasses.replace(family, omegas=(0.1, *OMEGAS))
    motion = StudyMotion(study, reference, shapedependence.linear_buoy(study, reference, wide))
    (label,) = {label for _, label in motion.runs}
    waves = sea(study.waves[0], 6.0, 20.0)
    rigid = motion.buoy.rao(waves.omega, design_motions(study, reference.basis, "FSB"))[:, 0]
    expected = [
        np.real(np.sum(waves.amplitude * rigid * np.exp(-1j * waves.omega * i * 20.0 / INSTANTS))) for i in (0, 7)
    ]
    np.testing.assert_allclose(motion.shapes("FSB", label)[[0, 7], 0], expected, rtol=1e-12)


@pytest.mark.parametrize("amplitudes", [(0.1, 0.2), (0.2, 0.1)])
def test_runs_are_of_every_design_in_every_sea_but_still_water(small, reference, family, dataset, amplitudes):
    """Powers go with the square of a wave, and the database reaches as far as the highest takes any design."""
    waves = [{"kind": "still"}, *({**small.waves[0].model_dump(), "amplitude": a} for a in amplitudes)]
    study = varied(small, waves=waves, designs={"FSB": {"flexible": False}, "VSWEC": {}})
    motion = StudyMotion(study, reference, shapedependence.linear_buoy(study, reference, family))
    assert list(motion.runs) == list(itertools.product(study.designs, [w.label for w in study.waves[1:]]))
    highest = study.waves[1 + int(np.argmax(amplitudes))].label
    moved = [np.abs(motion.shapes(design, highest)).max(axis=0) for design in study.designs]
    np.testing.assert_allclose(motion.reach, np.maximum(np.max(moved, axis=0), shapedependence.LEAST_REACH * 2.0))
    powers = shapedependence.study_powers(motion, family, ShapeDatabase(dataset))
    assert powers.power_at_reference.dims == ("design", "wave")
    for name in ("power_at_reference", "power_at_rest"):
        first, second = powers[name].values.T
        np.testing.assert_allclose(second / first, (amplitudes[1] / amplitudes[0]) ** 2, rtol=1e-9)
        assert first[1] != pytest.approx(first[0], rel=0.01)
    swings = np.ptp((powers.power_at_shape / powers.power_at_reference).values, axis=2)
    assert ((swings[:, 1] > 1.5 * swings[:, 0]) == (amplitudes[1] > amplitudes[0])).all()


def test_a_rigid_buoy_has_heave_alone(seed):
    rigid = varied(seed, designs={"FSB": {"flexible": False}})
    family = family_of(reference_shell(rigid).shape, nodes=24)
    ds = shapedependence.shape_dataset(rigid, family, samples=2)
    assert shapedependence.largest_mode(ds) is None
    assert len(shape_figure(ds).axes[0].get_lines()) == 3


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


def test_a_run_interrupted_goes_on(coarsely, tmp_path, monkeypatch):
    """No shape is solved twice; a complete file is not solved again; nothing else stays behind."""
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
    assert ShapeDatabase.load(out[0]).labels == ["Heave"]
    assert answer(files.load(out[0]), study.study) == line
    stage.shape_dependence(varied(study, pto={"damping": 5000.0}), *out)
    assert len(solved) > before  # another study


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_is_for_terminals(terminal, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)
    show = stage.counter(3)
    for _ in range(3):
        show()
    expected = "\rshape 1 of 3\rshape 2 of 3\rshape 3 of 3\n" if terminal else ""
    assert capsys.readouterr().err == expected


def test_the_number_of_shapes_of_a_study(small, family, counted):
    assert counted[1] == shapedependence.shapes_of_study(small, family, samples=4)
    more = varied(small, waves=[*small.waves, {"kind": "still"}, {"kind": "jonswap", "hs": 0.3, "tp": 3.0}])
    assert shapedependence.shapes_of_study(more, family, samples=4) == counted[1] + len(small.designs)


OF_GRID = (2.0, pytest.approx(2.4), 4.0, 6.0, 8.0, 10.0, 12.0)


def test_frequencies_of_a_study_hold_its_waves(small, reference):
    family = shapedependence.study_family(small, reference, frequencies=6)
    assert family.omegas == OF_GRID
    others = [
        {"kind": "regular", "amplitude": 0.1, "period": 2 * np.pi / 7},
        {"kind": "white_noise", "hs": 0.3, "band": [3.0, 5.0]},
    ]
    more = varied(small, waves=[*small.waves, {"kind": "still"}, *others])
    omegas = shapedependence.study_family(more, reference, frequencies=6).omegas
    assert omegas == (*OF_GRID[:4], pytest.approx(7.0), *OF_GRID[4:])


def test_a_sea_of_longer_waves_than_the_grid_has_is_solved_down_to_its_longest(small, reference, family):
    """Bands of equal width, the first one's middle; the waves of the study's own motion lie between those solved."""
    one, noise, last = ({"kind": "white_noise", "hs": 0.3, "band": [low, 2.0]} for low in (0.5, 0.1, 0.3))
    rigid = varied(
        small, waves=[{"kind": "still"}, one, noise, last, *small.waves], designs={"FSB": {"flexible": False}}
    )
    count = int(np.ceil(1.9 * 1.1 * rigid.simulation.duration / (2 * np.pi)))
    asked = shapedependence.study_family(rigid, reference, frequencies=6)
    assert asked.omegas == (pytest.approx(0.1 + 0.5 * 1.9 / count, rel=1e-12), *OF_GRID)
    motion = StudyMotion(
        rigid,
        reference,
        shapedependence.linear_buoy(rigid, reference, dataclasses.replace(family, omegas=asked.omegas)),
    )
    assert motion.reach[0] > 0.1


def test_finite_depth_is_refused(small, reference):
    shallow = varied(small, water={"depth": 20.0})
    with pytest.raises(ConfigError, match=r"water\.depth: received 20 m"):
        shapedependence.study_family(shallow, reference)


@pytest.mark.parametrize(
    "pto",
    [
        {"damping": None, "tuning": "each"}, {"damping": {"FSB": 1.0, "VSWEC": 2.0}}, {"port": "volume"}, {"stiffness": 1.0},
        {"tuning": "each"}, {"efficiency": 0.7}, {"law": "coulomb", "force_limit": 1.0}, {"law": "latching"},
        {"stroke_limit": 1.0},
    ],
    ids=str,
)  # fmt: skip
def test_a_slope_of_power_is_of_one_damper_on_heave_alone(small, pto):
    """Whatever else a take-off has would be left out without a word."""
    assert shapedependence.given_damper(small) == small.pto.damping
    other = small.model_copy(update={"pto": small.pto.model_copy(update=pto)})
    with pytest.raises(
        ConfigError, match=r"pto: received .*; shape dependence needs one damping, on heave, and no more"
    ):
        shapedependence.given_damper(other)


def test_expansions_are_put_to_the_test_on_sizes_in_radii(dataset):
    np.testing.assert_allclose(dataset.deformation, 2.0 * np.array([0.00625, 0.0125, 0.025, 0.05, 0.1]), rtol=1e-12)
    assert dataset.expansion.values.tolist() == ["first", "second"]


@pytest.mark.parametrize(
    ("first", "second", "verdict"),
    [
        ({"least": -0.2, "most": 0.1, "average": 0.002}, {"least": 0.0, "most": 0.03, "average": 0.02}, "matters"),
        ({"least": -0.2, "most": 0.1, "average": 0.002}, {"least": 0.0, "most": 0.03, "average": -0.02}, "matters"),
        ({"least": -0.2, "most": 0.1, "average": 0.002}, {"least": 0.0, "most": 0.03, "average": 0.01}, "averages out"),
        ({"least": 0.002, "most": 0.01, "average": 0.002}, {"least": 0.0, "most": 0.003, "average": 0.0}, "may be ignored"),
        ({"least": -0.0101, "most": 0.0, "average": 0.01}, {"least": 0.0, "most": 0.003, "average": 0.0}, "averages out"),
        ({"least": 0.0, "most": 0.009, "average": 0.0, "rest": -0.0101}, {"least": 0.0, "most": 0.0, "average": 0.0}, "matters"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("turned", [False, True])
def test_what_lasts_in_any_run_matters_without_a_shape_at_rest_as_well(monkeypatch, first, second, verdict, turned):
    """Told by the run of the largest change, of whichever sign, with its own numbers."""
    powers = (("design", "wave"), [[80.0, 70.0], [34.5, 12.5]])
    known = xr.Dataset({"power_at_reference": powers}, {"design": ["FSB", "VSWEC"], "wave": ["regular", "another"]})
    effects = {("FSB", "regular"): second, ("VSWEC", "another"): first}
    effects = dict(reversed(effects.items())) if turned else effects
    monkeypatch.setattr(shapedependence, "power_effects", lambda ds: effects)
    rest = f"{100 * first['rest']:+.2g} % by that of the shape at rest" if "rest" in first else "no shape at rest found"
    assert answer(known, "seed") == (
        f"seed: the shape dependence {verdict} (limit 1 % of mean power): VSWEC, another: 12.5 W changes by "
        f"{100 * first['least']:+.2g} to {100 * first['most']:+.2g} % by the shapes of the motion, "
        f"{100 * first['average']:+.2g} % on average, {rest}"
    )


def test_a_family_is_of_the_water_of_its_study_at_sixty_frequencies_and_its_longest_wave(small, reference):
    """The longest wave of a sea is that of the study's own run."""
    noise = {"kind": "white_noise", "hs": 0.3, "band": [0.05, 2.0]}
    study = varied(
        small,
        water={"density": 1010.0, "gravity": 9.7},
        hydro={"omega_max": 9.0},
        waves=[noise],
        simulation={"duration": 35.0, "window": (10.0, 30.0)},
    )
    found = shapedependence.study_family(study, reference)
    count = int(np.ceil(1.95 * 1.1 * 35.0 / (2 * np.pi)))
    longest = 0.05 + 0.5 * 1.95 / count
    grid = 0.15 * np.arange(1, 61)
    expected = [longest, *grid] if longest < 0.15 else grid
    np.testing.assert_allclose(found.omegas, expected, rtol=1e-9)
    assert (found.density, found.gravity, found.shape) == (1010.0, 9.7, reference.shape)
    coarse = shapedependence.study_family(study, reference, 5).omegas
    np.testing.assert_allclose(coarse, [longest, *(1.8 * np.arange(1, 6))], rtol=1e-9)


@pytest.mark.parametrize("radius", [1.5, 3.0])
def test_a_database_reaches_a_hundredth_of_any_radius(small, reference, radius):
    device = {"radius": radius, "thickness": 0.01, "mass": 800.0 * radius**3}
    still = varied(small, device=device, waves=[{"kind": "still"}])
    assert StudyMotion(still, reference, None).reach == pytest.approx(np.full(4, 0.01 * radius), rel=1e-14)
    assert StudyMotion(still, reference, None).runs == {}


def test_a_database_reaches_as_far_as_any_run_in_each_motion(small, monkeypatch):
    """To either side, whichever design and sea it is; a motion that hardly any run has, to a hundredth of the radius."""
    passed = {
        ("A", "p"): [[0.5, -0.01, 0.0], [-0.2, 0.0, 0.0]],
        ("B", "p"): [[0.1, -0.3, 0.0], [0.0, 0.2, 0.001]],
        ("B", "q"): [[-0.7, 0.1, -0.001], [0.6, 0.0, 0.0]],
    }
    monkeypatch.setattr(StudyMotion, "runs", passed)
    monkeypatch.setattr(StudyMotion, "shapes", lambda self, *run: np.array(passed[run]))
    labels = dataclasses.make_dataclass("Basis", ["labels"])(("Heave", "one", "other"))
    motion = StudyMotion(small, dataclasses.make_dataclass("Reference", ["basis"])(labels), None)
    assert motion.reach == pytest.approx([0.7, 0.3, 0.01 * small.device.radius], rel=1e-14)


def test_all_of_a_study_is_put_together_of_what_its_parts_find(small, reference, monkeypatch):
    """Errors are the worst of any coefficient, by order and size in radii; the database is measured as often as asked."""
    study = varied(small, device={"radius": 1.5, "mass": 7e3}, waves=[{"kind": "still"}])
    asked = []

    class Family:
        labels = ("Heave",)

        def interpolation_error(self, size, samples):
            asked.append((pytest.approx(size, rel=1e-12), samples))
            return xr.Dataset(
                {"one": ("order", [3 * size, 2 * size]), "other": ("order", [size, 7 * size])}, {"order": [1, 2]}
            )

    family = Family()
    for name, known in {
        "reference_shell": lambda study: reference,
        "linear_buoy": lambda *given: ("buoy", *given),
        "StudyMotion": lambda *given: dataclasses.make_dataclass("Motion", ["given", "reach"])(given, "reach"),
        "shape_database": lambda *given: (
            databases.append(given) or dataclasses.make_dataclass("D", ["dataset"])(stored)
        ),
        "power_changes": lambda *given: xr.Dataset({"b": float(given == (study, reference, family))}),
        "study_powers": lambda motion, of, database: xr.Dataset(
            {"c": float(motion.given == (study, reference, ("buoy", study, reference, family)) and of is family)}
        ),
        "described": lambda ds: ds.assign(d=4.0),
    }.items():
        monkeypatch.setattr(shapedependence, name, known)
    stored, databases = xr.Dataset({"a": 2.0}), []
    for samples in ((), (7,)):
        ds = shapedependence.shape_dataset(study, family, *samples)
        assert databases.pop() == (family, "reach", *(samples or (20,)))
        assert [float(ds[name]) for name in "abcd"] == [2.0, 1.0, 1.0, 4.0]
        sizes = 1.5 * np.array([0.00625, 0.0125, 0.025, 0.05, 0.1])
        np.testing.assert_allclose(ds.deformation, sizes, rtol=1e-12)
        assert ds.interpolation_error.dims == ("deformation", "expansion")
        np.testing.assert_allclose(ds.interpolation_error.sel(expansion="first"), 3 * sizes, rtol=1e-12)
        np.testing.assert_allclose(ds.interpolation_error.sel(expansion="second"), 7 * sizes, rtol=1e-12)
    assert [samples for _, samples in asked] == [8] * 10


def test_effects_of_every_run_are_relative_to_its_own_power(monkeypatch):
    """Of two designs in two seas; one that absorbs nothing and one that gives power have none."""
    reference = np.array([[2.0, 0.0], [4.0, -1.0]])
    passed = np.array([[[1.0, 2.0, 6.0], [1.0, 2.0, 3.0]], [[4.4, 3.0, 4.0], [1.0, 1.0, 1.0]]])
    ds = xr.Dataset(
        {
            "power_at_reference": (("design", "wave"), reference),
            "power_at_shape": (("design", "wave", "instant"), passed),
            "power_at_rest": (("design", "wave"), [[3.0, 1.0], [3.0, 1.0]]),
        },
        {"design": ["A", "B"], "wave": ["p", "q"]},
    )
    first = {"least": -0.5, "most": 2.0, "average": 0.5}
    second = {"least": -0.25, "most": 0.1, "average": -0.05}
    found = power_effects(ds)
    assert list(found) == [("A", "p"), ("B", "p")]
    assert found["A", "p"] == pytest.approx({**first, "rest": 0.5})
    assert found["B", "p"] == pytest.approx({**second, "rest": -0.25})
    without = power_effects(ds.drop_vars("power_at_rest"))
    assert without["A", "p"] == pytest.approx(first)
    assert without["B", "p"] == pytest.approx(second)
    assert power_effects(xr.Dataset()) == {}


def test_the_swing_and_the_power_of_each_design_are_its_own(small, reference, monkeypatch):
    """Slopes and motions of two designs, by hand: sums over shapes, in their phases, and minus what the shape at rest is."""
    omega = np.array([1.0, 2.0, 3.0])
    rao = {
        "FSB": np.array([[1.0, 0.5j], [2.0, 1.0], [1j, 0.0]]),
        "VSWEC": np.array([[0.3, 1.0], [1.0, -1j], [0.0, 2.0]]),
    }
    slope = {
        "FSB": np.array([[1.0, 2.0, 3.0], [-1.0, 4.0, 1.0]]),
        "VSWEC": np.array([[2.0, -3.0, 1.0], [1.0, 1.0, 5.0]]),
    }

    class Buoy:
        def rao(self, omega, motions):
            return rao[motions]

        def absorbed_power(self, omega, rao):
            return omega * np.abs(rao[:, 0])

    monkeypatch.setattr(shapedependence, "linear_buoy", lambda *given: Buoy())
    monkeypatch.setattr(shapedependence, "design_motions", lambda study, basis, design: design)
    monkeypatch.setattr(shapedependence, "power_slope", lambda buoy, slopes, motions: slope[motions])
    family = dataclasses.make_dataclass("F", ["omegas", "slopes", "labels"])(tuple(omega), None, ["Heave", "Membrane0"])
    q = np.array([0.2, -0.1])
    told = dataclasses.make_dataclass("R", ["basis", "modal_amplitude"])(None, q)
    study = small.model_copy(update={"designs": {name: small.designs[name] for name in ("FSB", "VSWEC")}})
    ds = shapedependence.power_changes(study, told, family)
    for design in ("FSB", "VSWEC"):
        own = ds.sel(design=design)
        np.testing.assert_allclose(own.absorbed_power, omega * np.abs(rao[design][:, 0]))
        np.testing.assert_array_equal(own.power_slope.transpose("shape_dof", "omega"), slope[design])
        swing = np.abs([slope[design][:, i] @ rao[design][i] for i in range(3)])
        np.testing.assert_allclose(own.power_swing, swing)
        np.testing.assert_allclose(own.power_undeformed, -(q @ slope[design]))
    np.testing.assert_array_equal(ds.omega, omega)
    assert ds.shape_dof.values.tolist() == ["Heave", "Membrane0"]


def test_a_relative_slope_is_that_of_heave_alone_and_of_the_size_of_a_force():
    """Re(X'/X) is the derivative of log |X|, whatever the phase; of matrices heave's own entry counts."""
    random = np.random.default_rng(3)
    a, da = random.normal(size=(4, 2, 2)) + 3.0, random.normal(size=(2, 4, 2, 2))
    x, dx = (random.normal(size=(*n, 4, 1, 2)) + 1j * random.normal(size=(*n, 4, 1, 2)) for n in ((), (2,)))
    pair, force = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    known = {"added_mass": (pair, a), "excitation_force": (force, x)}
    known |= {"added_mass_slope": (("shape_dof", *pair), da), "excitation_force_slope": (("shape_dof", *force), dx)}
    ds = xr.Dataset(known, {"shape_dof": ["Heave", "Membrane0"]})
    found = shapedependence.relative_slope(ds, "added_mass")
    assert found.dims == ("shape_dof", "omega")
    np.testing.assert_allclose(found, da[:, :, 0, 0] / a[:, 0, 0], rtol=1e-14)
    step = 1e-6
    lengths = [np.log(np.abs(x[:, 0, 0] + s * step * dx[:, :, 0, 0])) for s in (1, -1)]
    slope = (lengths[0] - lengths[1]) / (2 * step)
    np.testing.assert_allclose(shapedependence.relative_slope(ds, "excitation_force"), slope, rtol=1e-6, atol=1e-8)


def test_a_slope_of_power_is_the_difference_of_powers_with_other_coefficients():
    """Of two designs of three degrees of freedom, by hand: c omega^2 |q|^2/2 of heave on either side."""
    random, omega, damper, step = np.random.default_rng(4), np.array([0.7, 1.3]), 5.0, 1e-5
    mass, loss = np.diag([3.0, 2.0, 1.0]), 0.1 * np.ones((3, 3)) + np.diag([1.0, 0.5, 0.7])
    stiffness = np.array([[9.0, 1.0, 0.0], [1.0, 7.0, -2.0], [0.0, -2.0, 5.0]])
    added, radiated = random.normal(size=(2, 2, 3, 3))
    pull = random.normal(size=(2, 3)) + 1j * random.normal(size=(2, 3))
    changes = random.normal(size=(3, 2, 2, 3, 3))  # by shape: of added mass and of damping
    pulls = random.normal(size=(3, 2, 3)) + 1j * random.normal(size=(3, 2, 3))

    def rao(motions, eta=(0.0, 0.0, 0.0)):
        a, b = (own + np.einsum("k,kwij->wij", eta, changes[:, i]) for i, own in enumerate((added, radiated)))
        x, found = pull + np.einsum("k,kwi->wi", eta, pulls), []
        for i, w in enumerate(omega):
            heave = damper * np.eye(3, 1) @ np.eye(1, 3)
            z = -(w**2) * (mass + a[i]) - 1j * w * (loss + b[i] + heave) + stiffness
            found.append(motions @ np.linalg.solve(motions.T @ z @ motions, motions.T @ x[i]))
        return np.array(found)

    class Buoy:
        database = xr.Dataset(coords={"omega": omega})
        pto = LinearPto(damper)

        def coefficients(self, omega):
            return Coefficients(added, radiated, pull)

        def damping_at(self, omega):
            return loss + damper * np.eye(3, 1) @ np.eye(1, 3)

        def rao(self, omega, motions):
            return rao(motions)

    buoy = Buoy()
    buoy.mass, buoy.stiffness = mass, stiffness
    every, force = ("shape_dof", "omega", "influenced_dof", "radiating_dof"), pulls[:, :, None]
    slopes = xr.Dataset(
        {
            "added_mass": (every, changes[:, 0]),
            "radiation_damping": (every, changes[:, 1]),
            "excitation_force": (("shape_dof", "omega", "wave_direction", "influenced_dof"), force),
        }
    )
    for motions in (np.eye(3), np.array([[1.0, 0.0], [0.0, 0.6], [0.0, -0.8]]), np.eye(3, 1)):
        found = shapedependence.power_slope(buoy, slopes, motions)
        for k, eta in enumerate(step * np.eye(3)):
            more, less = (0.5 * damper * omega**2 * np.abs(rao(motions, s * eta)[:, 0]) ** 2 for s in (1, -1))
            np.testing.assert_allclose(found[k], (more - less) / (2 * step), rtol=1e-6, atol=1e-8)


def test_powers_of_a_run_are_of_its_own_sea_its_own_shapes_and_its_own_design_at_rest(monkeypatch):
    """That of the reference is of no deformation; solved at rest is the shape of the design that runs."""

    @dataclasses.dataclass(frozen=True)
    class Buoy:
        database: object

        def coefficients(self, omega):
            return self.database, omega[0]

    seas = {"p": SimpleNamespace(omega=np.array([2.0])), "q": SimpleNamespace(omega=np.array([3.0]))}
    runs = {(design, wave): (seas[wave], f"motions of {design}") for design in "AB" for wave in "pq"}
    places = {("B", "q"): [[1.0, 2.0], [-3.0, 4.0]], ("A", "p"): [[7.0, 7.0]]}
    motion = SimpleNamespace(
        runs=runs,
        buoy=Buoy("centre"),
        reference="reference",
        shapes=lambda *run: np.array(places[run]),
        rest=lambda design: f"rest of {design}",
    )
    monkeypatch.setattr(shapedependence, "mean_power", lambda *given: given)
    monkeypatch.setattr(shapedependence, "with_structure", lambda *given: given)
    database = SimpleNamespace(labels=["Heave", "Membrane0"], at=lambda omega, eta: (omega[0], *eta))
    own = seas["q"], "motions of B"
    reference, passed = shapedependence._run_powers(motion, database, ("B", "q"))
    assert reference == (Buoy("centre"), (3.0, 0.0, 0.0), *own)
    assert passed == [(Buoy("centre"), (3.0, *eta), *own) for eta in ((1.0, 2.0), (-3.0, 4.0))]
    family = SimpleNamespace(at=lambda eta: f"solved at {eta}")
    solved = (("solved at rest of B", "reference"), 3.0)
    assert shapedependence._power_at_rest(motion, family, ("B", "q")) == (Buoy("centre"), solved, *own)
