"""Froude scaling of every quantity of a study."""

import inspect
import typing
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

from vsb.shell.modes import mode_basis
from vsb.study import study as config
from vsb.study.vary import FROUDE, scaled

SEED = Path(__file__).parents[1] / "data" / "seed.yaml"
KEPT = {
    "poisson_ratio", "density", "adiabatic_index", "atmospheric_pressure", "degree", "clamp", "depth",
    "gravity", "power_tolerance", "tolerance", "rows", "efficiency", "colatitude", "between", "seed", "realisations",
    "gamma", "values", "coefficient", "order", "direction", "dofs", "profile",
}  # fmt: skip
"""Numbers without dimension, angles, and what stays as it is: material, water, air, figures published elsewhere;
a profile has the radius of its buoy."""


NOWHERE = {"hs", "tp", "band"}
"""Irregular seas: a campaign's are the climate's, and the study that is begun with has none."""


def numbers(model):
    """Names of all keys of a model, and of the sections below it, that may hold numbers."""
    found = set()

    def look(name, annotation):
        if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
            found.update(numbers(annotation))
        elif annotation in {int, float}:
            found.add(name)
        for part in typing.get_args(annotation):
            if not isinstance(part, str):
                look(name, part)

    for name, field in model.model_fields.items():
        look(name, field.annotation)
    return found


def test_every_number_scales_or_is_known_to_stay():
    """A key added later would otherwise silently not scale."""
    found = numbers(config.Study)
    assert found > {"radius", "damping", "stroke_limit"}
    assert found - set(FROUDE) == KEPT | NOWHERE | {"mooring"}


def test_mooring_scales_by_force_and_moment_per_length_and_angle():
    """Forces go with the cube of lengths, moments with the fourth power."""
    raw = {"mooring": [1.0] * 6}
    assert scaled(raw, 2.0) == {"mooring": [4.0] * 3 + [16.0] * 3}
    rows = scaled({"mooring": [[1.0] * 6] * 6}, 2.0)["mooring"]
    assert rows == [[4.0] * 3 + [8.0] * 3] * 3 + [[8.0] * 3 + [16.0] * 3] * 3
    assert scaled({"mooring": None}, 2.0) == {"mooring": None}


TAKE_OFF = {"damping": 1.0, "stiffness": 1.0, "force_limit": 1.0, "stroke_limit": 1.0, "efficiency": 1.0}


@pytest.mark.parametrize(
    ("port", "expected"),
    [
        ("heave", (32.0, 16.0, 64.0, 4.0)),  # N s/m, N/m, N, m
        ({"line_to": [0.0, -20.0]}, (32.0, 16.0, 64.0, 4.0)),
        ("volume", (1 / 8, 1 / 16, 4.0, 64.0)),  # Pa s/m^3, Pa/m^3, Pa, m^3
        ("pitch", (512.0, 256.0, 256.0, 1.0)),  # N m s, N m, N m, rad
    ],
)
def test_take_off_scales_with_the_units_of_its_port(port, expected):
    found = scaled({"pto": {"port": port, **TAKE_OFF}}, 4.0)["pto"]
    assert tuple(found[key] for key in TAKE_OFF) == (*expected, 1.0)


@pytest.mark.parametrize("scale", [0.25, 4.0])
def test_natural_frequencies_scale_with_the_root_of_length(scale):
    study = config.load(SEED)
    larger = config.parse(scaled(study.model_dump(), scale), source="larger")
    own, other = (
        np.linalg.eigvals(np.linalg.solve(basis.inertia, basis.stiffness)).real
        for basis in (mode_basis(one.device, "full", 4) for one in (study, larger))
    )
    assert np.sort(other) == pytest.approx(np.sort(own) / scale, rel=1e-9, abs=1e-6)


"""Quantities by their units; a take-off's are those of a port that moves by a length."""
"""At the same density and gravity: kg/m^3 and m/s^2 stay."""
