"""Content ids: a value changes the ids of the stages that read it and of no other."""

import json
import math
from fnmatch import fnmatchcase
from itertools import product
from typing import get_args

import pytest
from conftest import varied
from pydantic import BaseModel

from vsb.errors import ConfigError
from vsb.study.plan import StudyPlan
from vsb.study.specs import PHYSICS
from vsb.study.study import RegularWave, Study, canonical, content_id, parse


def ids(study):
    """Ids of all that a study computes, by stage."""
    plan = StudyPlan(study)
    found = {name: content_id(getattr(plan, name)) for name in ("modes", "display", "comparison")}
    if study.needs_bem:
        found |= {name: content_id(getattr(plan, name)) for name in ("database", "radiation", "response")}
        found["blocks"] = list(plan.bem_blocks)
    runs = {f"{n}-{w.label}": content_id(plan.simulation(n, w)) for n in study.designs for w in study.waves}
    return {**found, "simulate": runs}


# what changes an id -------------------------------------------------------------------------------------------------

SWELL, STILL = {"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "still"}
SEAS = {
    "jonswap": {"kind": "jonswap", "hs": 0.2, "tp": 3.5},
    "pierson_moskowitz": {"kind": "pierson_moskowitz", "hs": 0.2, "tp": 3.5},
    "white_noise": {"kind": "white_noise", "hs": 0.2, "band": [1.0, 3.0]},
}
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 30.0}}
PUBLISHED = {"source": "a paper", "values": {"FSB": {"power_mean": 1.0}}}
TABULATED = {"omega": [2.0, 2.5], "accept": ["rank_one"]}
SHAPES = {
    "spheroid": {"height": 3.6}, "capsule": {"length": 0.5},
    "profile": [[0, 2], [1.3, 1.5], [2, 0], [1.6, -1.2], [0, -2]],
}  # fmt: skip
STUDIES = {
    "sphere": {"hydro": TABULATED, "waves": [SWELL, STILL, SEAS["jonswap"]]},
    "equilibrium": {
        "reference_shape": "equilibrium", "hydro": TABULATED, "water": {"depth": 20.0},
        "device": {"internal_pressure": 17e3, "gas": {"adiabatic_index": 1.4}}, "waves": [SWELL, SEAS["white_noise"]],
    },
    "panels": {"hydro": {**TABULATED, "rows": 40, "witness": "none"}, "waves": [SWELL, SEAS["pierson_moskowitz"]]},
    "assumed": {"hydro": {"model": "assumed_pressure", "pressure": 100.0}, "waves": [SWELL]},
    "law": {"pto": {"law": "saturated", "force_limit": 3e3, "stroke_limit": 0.5}, "hydro": TABULATED, "waves": [SWELL]},
    "pto": {
        "pto": {"port": {"colatitude": 90}, "efficiency": 0.8, "stiffness": 500.0, "tuning": "each"},
        "hydro": TABULATED, "waves": [SWELL, SEAS["jonswap"]], "drag": {"heave": {"coefficient": 0.5, "area": 3.0}},
    },
    "between": {"pto": {"port": {"between": [0, 90]}}, "hydro": TABULATED, "waves": [SWELL]},
    "planar": {
        "motion": "planar", "device": {"centre_of_mass": -0.3, "ballast_inertia": 5e3}, "modes": {"order": 2},
        "mooring": [[2e4, 0, 0, 0, 1e3, 0], *([0] * 6,) * 3, [1e3, 0, 0, 0, 3e4, 0], [0] * 6], "hydro": TABULATED,
        "pto": {"port": {"line_to": [9.0, -20.0], "line_from": [0.0, -1.0]}}, "waves": [SWELL, SEAS["jonswap"]],
    },
    "drifting": {
        "motion": "planar", "device": {"centre_of_mass": -0.3, "ballast_inertia": 5e3}, "hydro": TABULATED,
        "waves": [SWELL],
    },
    "free": {
        "motion": "free", "device": {"centre_of_mass": -0.3, "ballast_inertia": 5e3, "ballast_yaw_inertia": 4e3},
        "mooring": [2e4, 2e4, 0, 0, 0, 1e3], "hydro": TABULATED, "waves": [{**SWELL, "direction": 20.0}],
        "drag": {key: {"coefficient": 0.5, "area": 3.0} for key in ("surge", "sway", "heave")}
        | {key: {"coefficient": 0.5, "area": 3.0, "lever": 2.0} for key in ("roll", "pitch", "yaw")},
    },
    "dofs": {"pto": {"port": {"dofs": {"Heave": 1.0, "Membrane0": 0.5}}}, "hydro": TABULATED, "waves": [SWELL]},
    "auto": {"hydro": {**TABULATED, "model": "auto", "power_tolerance": 0.01}, "waves": [SWELL]},
    **{
        name: {"device": {"shape": {name: shape}}, "modes": {"basis": "full", "degree": 2},
               "hydro": {**TABULATED, "witness": "none"}, "waves": [SWELL]}
        for name, shape in SHAPES.items()
    },
}  # fmt: skip
OTHERS = {
    "motion": ["heave"], "hydro.model": ["body_exact", "auto"], "hydro.tolerance": [6.25e-5], "hydro.accept.0": ["haskind"],
    "pto.law": ["coulomb"], "pto.tuning": ["each", "one"], "pto.port": ["volume"],
    "pto.port.direction": ["radial"], "pto.port.against": ["frame"],
}  # fmt: skip
"""Values of leaves whose next value is not near."""


@pytest.fixture(scope="module")
def studies(seed):
    """One study of every kind of plan, with every section given."""
    known = parse({**seed.model_dump(), "published": PUBLISHED})
    return {name: varied(known, designs=DESIGNS, **changes) for name, changes in STUDIES.items()}


HELD = {
    "sweep": ("shape", "mesh"), "tabulated": ("shape", "mesh"), "database": ("sweep", "tabulated"),
    "radiation": ("database",), "loaded": ("radius", "centre_height"), "witness": ("meshes",),
}  # fmt: skip
"""What of a specification says that of another stage, or its id."""


def reads(study):
    """Leaves of a study that the specification of each stage reads itself, as patterns; see `specifications`."""
    sphere, shell = ["device.radius", "device.mass", "water.density"], ["device.*", "modes.*", "water.*"]
    sphere += ["device.shape.*"]
    directed = ["motion", "mooring.*"]
    found = {
        "modes": [*shell, *directed, "reference_shape", "designs.*"],
        "display": [*shell[:1], "modes.basis", "modes.degree", *shell[2:], "reference_shape"],
        "comparison": ["*"],
    }
    for design, (i, wave) in product(study.designs, enumerate(study.waves)):
        sea = [f"waves.{i}.{key}*" for key in type(wave).model_fields if key != "realisations"]
        dynamics = [f"hydro.{key}" for key in ("model", "pressure", "power_tolerance", "omega_max")]
        pto = [f"pto.{key}*" for key in type(study.pto).model_fields if key != "damping" or study.pto.tuning == "fixed"]
        sections = [*directed, "reference_shape", *pto, "drag.*", "simulation.*", f"designs.{design}.*"]
        found["simulate", design, i] = [*shell, *sections, *sea, *dynamics]
    if not study.needs_bem:
        return found
    loaded = [f"device.{key}" for key in type(study.device).model_fields if key != "damping"]
    loaded += ["device.gas.*", "modes.*", "water.density", "water.gravity"]
    bem = ["water.*", "modes.degree", "reference_shape"]  # the last two are the displacements
    bem += ["motion", "modes.order"]  # of as many orders
    bem += [] if study.uses_panels else ["hydro.tolerance"]
    alone = study.motion != "heave" or study.device.shape  # what one solver alone knows
    bem += [] if study.uses_panels or alone else ["hydro.solver"]
    grid = ["hydro.omega.*", "hydro.omega_max"]
    grid += [f"waves.{i}.period" for i, wave in enumerate(study.waves) if isinstance(wave, RegularWave)]
    grid += [] if study.uses_panels else ["hydro.tolerance"]  # refines it
    grid += ["hydro.solver"] if math.isfinite(study.water.depth) else []  # has a lowest frequency
    if study.uses_panels:
        found["mesh"] = [*sphere, "reference_shape", "hydro.rows"]
    if study.hydro.witness == "auto":
        shapes = [*(loaded if study.at_equilibrium else sphere), "device.thickness", "device.poisson_ratio"]
        shapes += ["modes.basis", "modes.degree"]
        found |= {"witness": ["water.*", "device.radius"], "shapes": [*shapes, "water.depth", "reference_shape"]}
    driven = ["reference_shape", "designs.*", "pto.*", "drag.*"]
    without_method = [f"simulation.{key}*" for key in type(study.simulation).model_fields if key != "method"]
    return found | {
        "sphere": sphere,
        "loaded": [*(loaded if study.at_equilibrium else ["device.shape.*"]), "reference_shape"],
        "sweep": [*bem, "hydro.omega_max", "hydro.tolerance"],
        "tabulated": [*bem, "hydro.omega.*"],
        "database": [*shell, *directed, "reference_shape", *grid[:2], "hydro.tolerance", "hydro.accept.*"],
        "radiation": ["hydro.tolerance"],
        "response": [*shell, *directed, "designs.*", "pto.*", *grid, "waves.*.direction"],
        "ladder": [*shell, *directed, *driven, "waves.*", *without_method, "hydro.omega_max"],
    }


def specifications(study):
    """Specifications of a study by stage, several of meshes and blocks; of runs by design and number of the sea."""
    plan = StudyPlan(study)
    found = {name: [getattr(plan, name)] for name in ("modes", "display", "comparison")}
    for design, (i, wave) in product(study.designs, enumerate(study.waves)):
        found["simulate", design, i] = [plan.simulation(design, wave)]
    if study.needs_bem:
        found |= {name: [getattr(plan, name)] for name in ("database", "radiation", "response", "ladder")}
        found |= {"sweep": plan.sweep_blocks, "tabulated": plan.tabulated_blocks}
        sphere = {"radius": plan.shape.radius, "centre_height": plan.shape.centre_height}
        found |= {"sphere": [sphere], "loaded": [plan.shape]}
    if plan.witness:
        found |= {"witness": [plan.witness], "shapes": [plan.witness.meshes]}
    if study.uses_panels:
        found["mesh"] = [block.mesh for block in plan.tabulated_blocks]
    return {stage: [json.loads(canonical(spec)) for spec in specs] for stage, specs in found.items()}


def own(specs):
    """What specifications say themselves, by stage."""
    return {
        stage: [{key: value for key, value in spec.items() if key not in HELD.get(stage, ())} for spec in several]
        for stage, several in specs.items()
    }


def results(study):
    """Ids of the results of a study, by what they are; of runs by design and number of the sea."""
    plan = StudyPlan(study)
    found = {"report": plan.study_id, "modes": content_id(plan.modes)}
    for design, (i, wave) in product(study.designs, enumerate(study.waves)):
        found["simulate", design, i] = plan.trajectory_id(design, wave)
    return found | ({"response": plan.response_id} if study.needs_bem else {})


def stamped(changed, study):
    """Results of which the specification or what they are made from is among the stages changed."""
    solved = {"database", "radiation"}
    shown = reads(study).keys() - {"display"}  # meshes are looked at with other tools
    made_from = {"report": shown, "modes": set(), "response": {"database"}}
    return {stage for stage in results(study) if changed & ({stage} | made_from.get(stage, solved))}


def differing(before, after):
    """Stages whose specifications differ."""
    return {stage for stage, specs in before.items() if after.get(stage) != specs}


def with_inputs(changed, study):
    """Stages changed, and those whose specifications hold such or their ids, in the order of the work."""
    flow = [
        ("loaded", {"sphere"}), ("sweep", {"loaded", "mesh"}), ("tabulated", {"loaded", "mesh"}), ("witness", {"shapes"}),
        ("database", {"sweep", "tabulated"}), ("radiation", {"database"}),
    ]  # fmt: skip
    for stage, held in flow:
        changed = changed | ({stage} if changed & held and study.needs_bem else set())
    return changed & reads(study).keys()


def leaves(data, path=()):
    """Paths and values of what a study is made of; what is not given is none, an empty list one leaf."""
    if isinstance(data, dict | list | tuple) and data:
        items = data.items() if isinstance(data, dict) else enumerate(data)
        for key, value in items:
            yield from leaves(value, (*path, key))
    elif data is not None:
        yield path, data


def put(data, path, value):
    """Nested data with one leaf replaced."""
    if not path:
        return value
    if isinstance(data, dict):
        return {**data, path[0]: put(data[path[0]], path[1:], value)}
    return [put(old, path[1:], value) if i == path[0] else old for i, old in enumerate(data)]


def other_values(path, value):
    """Values a leaf could have instead, the first that a study accepts is taken."""
    if (name := ".".join(map(str, path))) in OTHERS:
        return [other for other in OTHERS[name] if other != value]
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1]
    if isinstance(value, float):
        return [20.0] if math.isinf(value) else [0.7 * value, 0.99 * value, 1.01 * value] if value else [0.5]
    if isinstance(value, str):
        names = [
            "random",
            "undeformed",
            "equilibrium",
            "paper",
            "membrane",
            "full",
            "exact",
            "exponential",
            "panels",
            "spectral",
            "auto",
        ]
        return [*(name for name in names if name != value), f"{value}2"]
    return [[30.0], ["haskind"]]  # an empty list


WHOLE = ("sphere", "equilibrium", "panels")
"""Studies of which every leaf is changed; of the others those of the sections that make them."""


def changed_leaves(name, study):
    """Leaves of a study by their path, with the study in which it alone is another."""
    data = study.model_dump()
    for path, value in leaves(data):
        if name not in WHOLE and path[0] not in STUDIES[name]:
            continue
        for other in other_values(path, value):
            try:
                yield path, parse(put(data, path, other))
                break
            except ConfigError:
                continue


def keys_of(model, path=()):
    """Paths of all keys a section can have; names of designs and numbers of seas stand for each other."""
    for name, field in model.model_fields.items():
        sections = sections_in(field.annotation)
        for part in sections:
            yield from keys_of(part, (*path, name))
        if not sections:
            yield (*path, name)


def sections_in(annotation):
    """Sections an annotation names, however deep."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for part in get_args(annotation) for found in sections_in(part)]


@pytest.mark.parametrize("name", sorted(STUDIES))
def test_key_changes_the_ids_of_the_stages_that_read_it_and_no_other(studies, name):
    study = studies[name]
    before, patterns = specifications(study), reads(study)
    for path, other in changed_leaves(name, study):
        leaf, after = ".".join(map(str, path)), specifications(other)
        reading = {
            s for s, ps in patterns.items() if any(fnmatchcase(leaf, p) or fnmatchcase(f"{leaf}.", p) for p in ps)
        }
        assert (leaf, differing(own(before), own(after))) == (leaf, reading)
        assert (leaf, differing(before, after)) == (leaf, with_inputs(reading, study))
        assert (leaf, differing(results(study), results(other))) == (leaf, stamped(differing(before, after), study))


def test_every_key_is_covered(studies):
    seen = {
        tuple(key for key in path if isinstance(key, str))
        for name, study in studies.items()
        for path, _ in changed_leaves(name, study)
    }
    seen = {(*path[:1], *path[2:]) if path[0] == "designs" else path for path in seen}
    seen = {path[:2] if path[0] == "published" else path for path in seen}
    seen = {path[:3] if path[:3] == ("pto", "port", "dofs") else path for path in seen}
    assert set(keys_of(Study)) - seen == {("waves", "kind"), ("modes", "tolerance")}


TAGGED = {
    "mesh": {"mesh", "modes", "display", "shapes"}, "bem": {"sweep", "tabulated"}, "compare": {"comparison"},
    **{name: {name} for name in ("database", "radiation", "response", "simulate", "witness", "ladder")},
}  # fmt: skip
"""Version of the physics -> stages it stands in; others are of bodies and campaigns."""


@pytest.mark.parametrize("tag", PHYSICS)
def test_version_of_the_physics_is_part_of_the_ids_of_its_stage(studies, tag, monkeypatch):
    study = studies["sphere"]
    before, after = specifications(study), results(study)
    monkeypatch.setitem(PHYSICS, tag, PHYSICS[tag] + 1)
    tagged = TAGGED.get(tag, set())
    named = {stage for stage in before if (stage if isinstance(stage, str) else stage[0]) in tagged}
    assert differing(before, specifications(study)) == with_inputs(named, study)
    assert differing(after, results(study)) == stamped(with_inputs(named, study), study)
