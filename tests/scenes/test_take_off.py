"""The take-off of a study in a scene: its law, its limits, its end stop."""

import numpy as np
import pytest

from vsb.integrators.switching import switched
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import EndStop, TakeOff
from vsb.scenes.take_off import LAWS, STIFFER, with_take_off
from vsb.study.take_off import Pto

DAMPER = LinearPto(4.0)


@pytest.fixture
def plant():
    forces = {
        "hydrostatic": Spring(np.diag([50.0, 400.0])),
        "pto": Damper(np.diag([4.0, 0.0])),
        "excitation": Excitation(np.array([2.0]), np.array([[60.0 + 0j, 0.0]])),
    }
    return Scene(("Heave", "Membrane2"), np.array([[2.0, 0.3], [0.3, 1.0]]), forces, np.eye(2))


def test_a_linear_take_off_leaves_the_scene_as_it_is(plant):
    assert with_take_off(plant, Pto(damping=4.0), DAMPER) is plant


@pytest.mark.parametrize("law", [law for law in LAWS if law != "linear"])
def test_every_law_acts_on_heave_within_its_limit(plant, law):
    scene = with_take_off(plant, Pto(law=law, damping=4.0, force_limit=3.0), DAMPER)
    force = scene.forces["pto"]
    assert isinstance(force, TakeOff)
    assert (force.paused_damping == 0.0) == (law == "declutching")
    assert force.direction.tolist() == [1.0, 0.0]
    assert "end_stop" not in scene.forces
    motion, _ = switched(System.of(scene), np.linspace(0.0, 10.0, 501), (np.zeros(2), np.zeros(2)))
    assert np.abs(motion.forces["pto"]).max() == pytest.approx(3.0)


def test_the_end_stop_is_stiff_and_critically_damped_with_what_moves(plant):
    scene = with_take_off(plant, Pto(damping=4.0, stroke_limit=0.2), DAMPER)
    stop, inverse = scene.forces["end_stop"], np.linalg.inv(plant.mass)[0, 0]
    assert isinstance(stop, EndStop)
    assert stop.stiffness == pytest.approx(STIFFER * 50.0)
    assert stop.damping == pytest.approx(2 * np.sqrt(stop.stiffness / inverse))
    motion, _ = switched(System.of(scene), np.linspace(0.0, 10.0, 501), (np.zeros(2), np.zeros(2)))
    given_way = np.abs(motion.position[:, 0]).max() - 0.2
    lossless = np.abs(motion.velocity[:, 0]).max() / np.sqrt(stop.stiffness * inverse)  # V sqrt(m/k)
    assert 0.2 * lossless < given_way < 0.6 * lossless  # 1/e of it where damping is critical, the waves' push besides
