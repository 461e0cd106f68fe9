"""Labels of degrees of freedom."""

import pytest

from vsb.engine.hydro import labels


@pytest.mark.parametrize(
    ("label", "body", "motion", "rigid"),
    [("Heave", "", "Heave", True), ("float__Heave", "float", "Heave", True), ("Mode7", "", "Mode7", False),
     ("left__float__Pitch", "left__float", "Pitch", True), ("Heave__Mode7", "Heave", "Mode7", False)],
)  # fmt: skip
def test_labels_of_motions_of_several_bodies(label, body, motion, rigid):
    """A body's name may be two words, or that of a motion."""
    assert (labels.body_of(label), labels.motion_of(label)) == (body, motion)
    assert labels.is_rigid(label) is rigid
