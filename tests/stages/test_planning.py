"""The degree of the shell modes: it follows from the tolerance and the wall, and is part of the ids."""

import pytest
import yaml
from conftest import EXAMPLE, varied

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.spectral.solver import MOST_NODES, SpectralProblem, largest_error
from vsb.models.rest import reference_shell
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import degree_lines, plan_of, with_degree
from vsb.study.degree import bending_degree, degree_needed
from vsb.study.sections import DEGREES
from vsb.study.study import load

TOLERANT = {"basis": "full", "degree": None, "tolerance": 0.005}


@pytest.fixture(scope="module")
def asked():
    """The example in one wave, with modes by tolerance."""
    return varied(load(EXAMPLE), modes=TOLERANT, designs={"FSB": {"flexible": False}, "VSWEC": {}})


def test_degree_stands_in_the_ids_and_depends_on_the_buoy_alone(asked):
    plan = with_degree(StudyPlan(asked))
    assert plan.study.modes.degree in DEGREES
    other = varied(asked, waves=[{"kind": "regular", "amplitude": 0.1, "period": 6.0}])
    assert with_degree(StudyPlan(other)).database.id == plan.database.id
    given = StudyPlan(varied(asked, modes={"basis": "full", "degree": 20}))
    assert with_degree(given) is given
    assert given.database.id != plan.database.id


def test_softer_thinner_and_vented_walls_and_smaller_tolerances_need_more_degrees(asked):
    def needed(tolerance=0.005, **device):
        return degree_needed(varied(asked, device=device, modes={"tolerance": tolerance}))

    assert needed(tolerance=1e-4) > needed()
    for softer in ({"young_modulus": 5e6}, {"thickness": 0.004}, {"internal_pressure": 0.0}):
        assert needed(**softer) > needed()


def test_ports_between_points_and_in_surge_need_more_degrees(asked):
    """The former resolve what bends about the points, over sqrt(r h)."""
    turning = {"device": {"centre_of_mass": -0.5, "ballast_inertia": 8e3}, "reference_shape": "undeformed"}
    surging = varied(asked, motion="planar", mooring=[2e4, 0, 0, 0, 0, 0], pto={"port": "surge"}, **turning)
    between = varied(asked, pto={"port": {"between": [0, 180]}}, designs={"VSWEC": {}})
    assert degree_needed(surging) > degree_needed(asked)
    assert degree_needed(between) >= 3.5 * bending_degree(asked)


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
