"""Content ids of the shipped studies: results already there keep their names."""

import json

import pytest
from conftest import HERE, SEED, varied

from vsb.study import blocks
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id, load

PINNED = json.loads((HERE / "data" / "content_ids.json").read_text())


def ids(study):
    """Ids of all that a study computes, by stage."""
    plan = StudyPlan(study)
    found = {name: content_id(getattr(plan, name)) for name in ("modes", "display", "comparison")}
    if study.needs_bem:
        found |= {name: content_id(getattr(plan, name)) for name in ("database", "radiation", "response")}
        found["blocks"] = list(plan.bem_blocks)
    runs = {f"{n}-{w.label}": content_id(plan.simulation(n, w)) for n in study.designs for w in study.waves}
    return {**found, "simulate": runs}


@pytest.mark.parametrize("name", sorted(PINNED))
def test_ids_of_the_shipped_studies_stay(name, monkeypatch):
    if name.startswith("panels"):
        monkeypatch.setattr(blocks, "panel_solver", lambda: "capytaine 3.0")
    assert ids(study_of(name)) == PINNED[name]


def study_of(name):
    """A shipped study, by panels if its name says so."""
    by_panels = {"hydro": {"rows": 30, "omega": [1.0, 2.0]}} if name.startswith("panels") else {}
    return varied(load(SEED.with_name(f"{name.removeprefix('panels ')}.yaml")), **by_panels)
