"""Advice on a shell that does not carry its load has been tried, and ends."""

import re

import pytest

from vsb.errors import ConfigError
from vsb.models.load_advice import advised
from vsb.models.rest import check_stable, computed_buckling, reference_shell
from vsb.models.viability import static_strain
from vsb.results.ledger import shell_checks
from vsb.study.study import parse


@pytest.mark.slow
@pytest.mark.parametrize("gas", [{}, {"gas": {}}], ids=["open", "trapped"])
def test_a_wall_that_no_pressure_carries_is_told_the_least_that_stands(gas):
    """Of rubber of 1 MPa, 12 mm thick and 3.2 m in radius: it inflates without bound from 1.24 mu h/r = 4.65 kPa, and
    buckles below the 32 kPa of the water at its keel, so that "more" and "less pressure" would be advised in turn.
    """
    device = {"radius": 3.2, "thickness": 0.012, "density": 1100.0, "internal_pressure": 16500.0, **gas}
    device["material"] = {"law": "neo_hookean", "mu": 1e6}
    study = parse(
        {"study": "a", "device": device, "modes": {"degree": 4}, "reference_shape": "equilibrium",
         "designs": {"V": {}}, "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip
    with pytest.raises(ConfigError) as error:
        reference_shell(study)
    text = str(advised(study, error.value))
    assert "no device.internal_pressure from 0 to" in text
    assert "from a thickness of about" in text
    assert "mm at" in text
    assert "or from a shear modulus of" in text


def soft(changes, **device):
    """A study about its equilibrium of a shell of 10 MPa, 5 mm thick, but for some changes."""
    shell = {"radius": 2.0, "thickness": 0.005, "young_modulus": 1e7, "poisson_ratio": 0.3, "density": 1100.0}
    return parse(
        {"study": "a", "device": {**shell, **device, **changes}, "modes": {"degree": 4}, "designs": {"V": {}},
         "reference_shape": "equilibrium", "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip


@pytest.mark.parametrize(
    "device",
    [
        {"mass": 17170.0, "internal_pressure": 5e3},
        pytest.param({"mass": 12e3, "shape": {"spheroid": {"height": 3.0}}}, marks=pytest.mark.slow),
        pytest.param({"mass": 3e4, "shape": {"capsule": {"length": 2.0}}}, marks=pytest.mark.slow),
    ],
    ids=["sphere", "spheroid", "capsule"],
)
def test_modulus_and_pressure_that_are_advised_carry_the_shell_at_strains_hookes_law_holds_for(device):
    """Each shell of 10 MPa would stand at some pressure, strained beyond 10 %: that is no advice."""
    study = soft({}, **device)
    with pytest.raises(ConfigError) as error:
        reference_shell(study)
    text = str(advised(study, error.value))
    assert "without straining it too far; from a thickness of about" in text
    modulus, pressure = re.search(r"or from young_modulus (\S+) MPa at (\S+) Pa, it is stable \(tried\)", text).groups()
    better = soft({"young_modulus": 1e6 * float(modulus), "internal_pressure": float(pressure)}, **device)
    rest = reference_shell(better)
    assert static_strain(rest.basis, rest.modal_amplitude) < 0.1
    assert computed_buckling(better).load_factor > 1.0


@pytest.mark.parametrize(
    "shape",
    [{}, pytest.param({"shape": {"spheroid": {"height": 3.0}}}, marks=pytest.mark.slow)],
    ids=["sphere", "spheroid"],
)
def test_what_is_advised_about_the_undeformed_shape_passes_its_checks(shape):
    """The pressure from which a shell of 10 MPa does not buckle strains it beyond the 10 % of Hooke's law: raising the
    pressure and then a stiffer shell would be advised in turn.
    """
    study = soft({}, mass=17170.0, **shape).model_copy(update={"reference_shape": "undeformed"})
    (line,) = (check for check in shell_checks(study, reference_shell(study)) if check.name == "computed_buckling")
    words = r"where its law ends at 10 %; from a thickness of about (\S+) mm at (\S+) Pa, or from young_modulus (\S+) MPa at (\S+) Pa"
    wall, at, modulus, pressure = map(float, re.search(words, line.advice).groups())
    for changes in (
        {"thickness": 1e-3 * wall, "internal_pressure": at},
        {"young_modulus": 1e6 * modulus, "internal_pressure": pressure},
    ):
        better = study.model_copy(update={"device": study.device.model_copy(update=changes)})
        assert all(check.verdict != "fail" for check in shell_checks(better, reference_shell(better)))


def test_a_shell_that_its_pressure_makes_unstable_is_advised_less():
    """More of modulus, wall or pressure is no advice where the pressure, 60 times what the shell needs, is the cause."""
    shell = {"young_modulus": 2e6, "thickness": 0.015}
    study = soft(shell, mass=17170.0, internal_pressure=2e5, shape={"spheroid": {"height": 3.0}})
    study = study.model_copy(update={"reference_shape": "undeformed"})
    with pytest.raises(ConfigError, match="is unstable") as error:
        check_stable(study, reference_shell(study))
    text = str(advised(study, error.value))
    modulus, pressure = re.search(r"from young_modulus (\S+) MPa at (\S+) Pa, it is stable \(tried\)", text).groups()
    assert float(pressure) < 2e5
    device = {"young_modulus": 1e6 * float(modulus), "internal_pressure": float(pressure)}
    better = study.model_copy(update={"device": study.device.model_copy(update=device)})
    check_stable(better, reference_shell(better))


def test_pressure_that_strains_a_shell_beyond_its_law_is_advised_to_be_less():
    """Thirteen times the water's pressure at the keel: the shell stands, at strains no law of linear elasticity holds for."""
    study = soft({"young_modulus": 4e7, "thickness": 0.015}, mass=17170.0, internal_pressure=2e5)
    (line,) = (check for check in shell_checks(study, reference_shell(study)) if check.name == "static_strain")
    assert line.verdict == "fail"
    (pressure,) = re.search(r"device.internal_pressure of (\S+) Pa carries this shell \(tried\)", line.advice).groups()
    assert float(pressure) < 2e5


def test_pressure_that_is_advised_for_rubber_leaves_no_wrinkles():
    """Four spans between too little pressure and too much: buckled, wrinkled, at rest, burst."""
    device = {"radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0}
    device |= {"material": {"law": "neo_hookean", "mu": 1e6}, "internal_pressure": 1e4}
    study = parse(
        {"study": "a", "device": device, "modes": {"degree": 4}, "reference_shape": "equilibrium",
         "designs": {"V": {}}, "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip
    with pytest.raises(ConfigError, match="buckles at") as error:
        reference_shell(study)
    (pressure,) = re.search(r"device.internal_pressure of (\S+) Pa carries", str(advised(study, error.value))).groups()
    device = study.device.model_copy(update={"internal_pressure": float(pressure)})
    better = study.model_copy(update={"device": device})
    assert all(check.verdict == "ok" for check in shell_checks(better, reference_shell(better)))
