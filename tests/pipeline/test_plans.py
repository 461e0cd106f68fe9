"""Members and batches of campaigns; the degree of the shell modes in a plan."""

import itertools

import pytest
import yaml
from conftest import EXAMPLE, SEED, varied

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.spectral.solver import MOST_NODES, SpectralProblem, largest_error
from vsb.errors import ConfigError
from vsb.models.rest import reference_shell
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import CampaignPlan, degree_lines, plan_of
from vsb.study.resolution import bending_degree, block_id, degree_needed
from vsb.study.sections import DEGREES
from vsb.study.study import load


@pytest.fixture
def planned(tmp_path):
    (tmp_path / "seed.yaml").write_text(SEED.read_text())
    (tmp_path / "sea.txt").write_text("spectra")

    def plan(vary=None, name="sweep", study=None, **changes):
        if study:
            raw = yaml.safe_load(SEED.read_text())
            for section, update in study.items():
                raw[section] = {**raw[section], **update} if isinstance(update, dict) else update
            (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
        raw = {"campaign": name, "study": "seed.yaml", "climate": {"spectra": "sea.txt"}, "vary": vary or {}, **changes}
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(raw))
        return plan_of(str(tmp_path / f"{name}.yaml"))

    return plan


def ids(plan):
    return [one.id for one in plan.members]


def test_member_ids_ignore_what_a_year_does_not_depend_on(planned):
    before = ids(planned({"device.mass": [16000.0, 17000.0]}))
    other = planned(
        {"device.mass": [17000.0, 16000.0]},
        name="other",
        study={"study": "renamed", "waves": [{"kind": "still"}], "simulation": {"duration": 100.0}},
    )
    assert set(ids(other)) == set(before)


@pytest.mark.parametrize(
    "study",
    [
        {"device": {"density": 2600.0}},
        {"modes": {"degree": 5}},
        {"water": {"gravity": 9.8}},
        {"pto": {"damping": 1.0}},
        {"hydro": {"tolerance": 1e-4}},
        {"designs": {"NEW": {"clamp": 45.0}}},
        {"reference_shape": "equilibrium"},
    ],
)
def test_member_ids_include_what_a_year_depends_on(planned, study):
    before = ids(planned())
    assert ids(planned(study={"reference_shape": "undeformed", **study})) != before


def test_widened_sweep_keeps_its_members(planned):
    narrow = planned({"device.young_modulus": {"log": [1e6, 1e9, 4]}})
    wide = planned({"device.young_modulus": {"log": [1e6, 1e10, 5]}, "device.thickness": [0.01, 0.02]})
    assert set(ids(narrow)) < set(ids(wide))


def test_materials_and_clamps_of_a_sphere_share_its_hydrodynamics(planned):
    vary = {"device.young_modulus": [1e6, 1e9], "device.thickness": [0.01, 0.02], "designs.VSWEC0.clamp": [0.0, 45.0]}
    sphere = planned(vary)
    assert {one.spec.sweep for one in sphere.members} == {
        tuple(block_id(block) for block in StudyPlan(sphere.loaded.base).sweep_blocks)
    }
    assert len({one.spec.sweep for one in planned({**vary, "device.mass": [16000.0, 17000.0]}).members}) == 2
    deformed = planned(vary, study={"reference_shape": "equilibrium"})
    assert len({one.spec.sweep for one in deformed.members}) == 4  # clamps are of designs, not of the shape at rest


def test_batches_follow_from_the_file_alone(planned, tmp_path, monkeypatch):
    vary = {"device.young_modulus": {"log": [1e6, 1e9, 40]}, "device.thickness": {"linear": [0.01, 0.1, 25]}}
    plan = planned(vary)
    batches = {name: [str(point) for point in one.spec["points"]] for name, one in plan.batches.items()}
    monkeypatch.chdir(tmp_path)
    again = CampaignPlan(plan.loaded, root="elsewhere")
    assert {name: [str(point) for point in one.spec["points"]] for name, one in again.batches.items()} == batches
    assert sorted(itertools.chain(*batches.values())) == sorted(str(one.point) for one in plan.members)
    assert len(set(ids(plan))) == 1000
    thicknesses = [{point["device.thickness"] for point in one.spec["points"]} for one in plan.batches.values()]
    assert len(thicknesses) == 3
    assert sum(map(len, thicknesses)) <= 25 + 2  # shapes and buckling of each are computed in one batch, or in two


def test_invalid_point_names_the_file(planned):
    with pytest.raises(ConfigError, match=r"sweep.yaml: vary: with device.thickness: 1.0: device: thickness 1 m"):
        _ = planned({"device.thickness": [0.01, 1.0]}).members


def test_every_product_has_an_id(planned):
    """Batches and verifications have their own, all else that of the campaign."""
    plan = planned({"device.mass": [1.2e4, 1.4e4, 1.6e4, 1.7e4]}, verify={})
    assert set(plan.file_ids) == set(plan.products)
    assert not any(map(plan.is_shared, plan.products))
    assert (len(plan.batches), len(plan.verifications)) == (2, 4)
    own = {f"results/sweep/batches/{one}.nc": one for one in plan.batches}
    own |= {f"results/sweep/verification/{one}.nc": one for one in plan.verifications}
    assert plan.file_ids == dict.fromkeys(plan.products, plan.identity) | own
    assert len({*own.values(), plan.identity}) == 7


RADII = {"device.radius": [2.0, 3.0]}


def test_draft_or_half_immersion_follows_the_radius(planned, tmp_path):
    raw = yaml.safe_load(SEED.read_text())
    del raw["device"]["mass"]
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    for one in planned(RADII).members:
        assert one.study.draft == pytest.approx(one.study.device.radius, rel=1e-9)
    for one in planned({"water.density": [1000.0, 1025.0]}).members:
        assert one.study.draft == pytest.approx(2.0, rel=1e-9)
    raw["device"]["draft"] = 1.8
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    for one in planned(RADII).members:
        assert one.study.draft == pytest.approx(1.8, rel=1e-9)
    assert [one.study.draft for one in planned({"device.draft": [1.5, 2.2]}).members] == pytest.approx([1.5, 2.2])
    with pytest.raises(ConfigError, match=r"received with device.draft 1.8 as given"):
        planned(RADII | {"scale": [1.0, 2.0]})
    both = planned(RADII | {"scale": [1.0, 2.0], "device.draft": [1.5]})
    assert [one.study.draft for one in both.members] == pytest.approx([1.5] * 4, rel=1e-9)


def test_draft_or_half_immersion_follows_the_shape(planned, tmp_path):
    lengths, raw = {"device.shape.capsule.length": [0.5, 1.0]}, yaml.safe_load(SEED.read_text())
    raw["device"] |= {"shape": {"capsule": {"length": 0.5}}}
    raw["modes"] = {"degree": 4}
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    with pytest.raises(ConfigError, match=r"device.mass 17170 as given in .*other shapes float otherwise"):
        planned(lengths)
    planned(lengths | {"device.mass": [17170.0]})
    del raw["device"]["mass"]
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    radius = raw["device"]["radius"]
    for one, length in zip(planned(lengths).members, [0.5, 1.0], strict=True):
        assert one.study.draft == pytest.approx(radius + length / 2, rel=1e-9)
    raw["device"]["draft"] = 1.8
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    assert [one.study.draft for one in planned(lengths).members] == pytest.approx([1.8, 1.8], rel=1e-9)


@pytest.mark.parametrize(
    ("vary", "study"),
    [
        ({"water.depth": [20.0, 30.0]}, {}),
        ({"reference_shape": ["undeformed", "equilibrium"]}, {}),
        ({"device.young_modulus": [1e7, 2e7]}, {"reference_shape": "equilibrium"}),
    ],
    ids=str,
)
def test_member_uses_the_blocks_of_its_own_study(planned, vary, study):
    found = planned(vary, study=study).members
    for one in found:
        assert one.spec.sweep == tuple(block_id(block) for block in StudyPlan(one.study).sweep_blocks)
    assert len({one.spec.sweep for one in found}) == 2


TOLERANT = {"basis": "full", "degree": None, "tolerance": 0.005}


@pytest.fixture(scope="module")
def asked():
    """The example in one wave, with modes by tolerance."""
    return varied(load(EXAMPLE), modes=TOLERANT, designs={"FSB": {"flexible": False}, "VSWEC": {}})


def test_degree_stands_in_the_ids_and_depends_on_the_buoy_alone(asked):
    plan = StudyPlan(asked).with_degree()
    assert plan.study.modes.degree in DEGREES
    other = varied(asked, waves=[{"kind": "regular", "amplitude": 0.1, "period": 6.0}])
    assert StudyPlan(other).with_degree().database.id == plan.database.id
    given = StudyPlan(varied(asked, modes={"basis": "full", "degree": 20}))
    assert given.with_degree() is given
    assert given.database.id != plan.database.id


def test_softer_thinner_and_vented_walls_and_smaller_tolerances_need_more_degrees(asked):
    def needed(tolerance=0.005, **device):
        return degree_needed(varied(asked, device=device, modes={"tolerance": tolerance}))

    assert needed(tolerance=1e-4) > needed()
    for softer in ({"young_modulus": 5e6}, {"thickness": 0.004}, {"internal_pressure": 0.0}):
        assert needed(**softer) > needed()


def test_ports_that_bend_the_wall_and_in_surge_need_more_degrees(asked):
    """Those between two points resolve what bends about these, over sqrt(r h)."""
    turning = {"device": {"centre_of_mass": -0.5, "ballast_inertia": 8e3}, "reference_shape": "undeformed"}
    surging = varied(asked, motion="planar", mooring=[2e4, 0, 0, 0, 0, 0], pto={"port": "surge"}, **turning)
    between = varied(asked, pto={"port": {"between": [0, 180]}}, designs={"VSWEC": {}})
    assert degree_needed(surging) > degree_needed(asked)
    assert degree_needed(between, wet=False) >= min(4.5 * bending_degree(asked), DEGREES[-1])
    assert 1.5 * bending_degree(asked) <= degree_needed(between) < degree_needed(between, wet=False)
    vertical, radial = (
        varied(asked, pto={"port": {"colatitude": 60, "direction": way}}) for way in ("vertical", "radial")
    )
    assert degree_needed(radial) > degree_needed(vertical) == degree_needed(asked)


def test_water_around_other_shapes_is_solved_to_the_highest_degree(asked):
    """With 128 points of the meridian the solver is off by 4 % around a capsule at degree 90."""
    soft = {"thickness": 0.002, "young_modulus": 1e7, "internal_pressure": 0.0}
    capsule = varied(asked, device={**soft, "shape": {"capsule": {"length": 2.0}}}, reference_shape="undeformed")
    highest = degree_needed(capsule)
    assert highest == DEGREES[-1]
    shape = reference_shell(varied(capsule, modes={"degree": 6})).shape
    moved = tuple(Displacement(kind, n) for kind in ("radial", "meridional") for n in (1, highest - 1, highest))
    problem = SpectralProblem(shape, moved, 1025.0, 9.81, MOST_NODES)
    assert largest_error(problem.error_estimate([0.5, 12.0])) < 1e-6


def test_degree_does_not_depend_on_units_of_length(asked):
    """Froude scaling in the same water: lengths and stresses grow alike."""
    device = asked.device
    large = {"radius": 2 * device.radius, "thickness": 2 * device.thickness, "mass": 8 * device.mass}
    stresses = {"young_modulus": 2 * device.young_modulus, "internal_pressure": 2 * device.internal_pressure}
    tolerances = (0.05, 0.005, 5e-4, 1e-4)
    one, other = (
        [degree_needed(varied(study, modes={"tolerance": tolerance})) for tolerance in tolerances]
        for study in (asked, varied(asked, device=large | stresses))
    )
    assert one == other


def test_campaign_has_the_degree_of_its_thinnest_shell(asked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "buoy.yaml").write_text(yaml.safe_dump(asked.model_dump(exclude_none=True)))
    (tmp_path / "site.csv").write_text("Hs/Te, 5, 6\n0.75, 5, 8\n1.25, 4, 10\n")
    given = {"campaign": "site", "study": "buoy.yaml", "climate": {"scatter": "site.csv"}, "tuning": ["one"]}

    def degree(thickness):
        (tmp_path / "site.yaml").write_text(yaml.safe_dump({**given, "vary": {"device.thickness": thickness}}))
        return plan_of("site.yaml").loaded.base.modes.degree

    assert degree([0.008]) > degree([0.03])
    assert degree([0.03, 0.008]) == degree([0.008])


def test_check_compares_given_modes_with_the_tolerance(asked):
    needed = degree_needed(asked)

    def lines(**modes):
        return degree_lines(StudyPlan(varied(asked, modes=modes)))

    assert not lines(basis="full", degree=needed)
    assert f"needs the full basis to about degree {needed}" in lines(basis="full", degree=needed - 1)[0]
    assert lines(basis="membrane", degree=90)[0].startswith("doubt")
