"""A stage of the workflow: the study its specification describes."""

from typing import Any

from vsb.study.study import Study, parse

Spec = dict[str, Any]


def partial_study(spec: Spec) -> Study:
    """Return a study from the sections a stage's spec holds; what the stage does not read takes harmless values."""
    defaults: Spec = {
        "study": "stage",
        "designs": {"any": {"flexible": bool(spec.get("modes"))}},
        "waves": [{"kind": "still"}],
    }
    keys = [key for key in Study.model_fields if spec.get(key) is not None]
    return parse({**defaults, **{key: spec[key] for key in keys}}, source="spec")
