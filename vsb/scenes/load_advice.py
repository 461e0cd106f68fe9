"""What would carry the load of a shell that gives way: computed before it is advised, so that advice ends."""

from collections.abc import Sequence

from vsb.errors import ConfigError
from vsb.scenes.rest import complete_loaded_shell, computed_buckling
from vsb.shell.loaded import stable_path
from vsb.study.device import Gas
from vsb.study.material import Hookean
from vsb.study.study import Study

PRESSURES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0)
"""Internal pressures that are tried, in terms of that of water at the keel."""
STEP, MOST = 1.25, 200.0
"""Factor between walls, or moduli, that are tried, and beyond which none is."""
INFLATED = 1.24
"""Pressure over mu h/r at which a sphere of neo-Hookean rubber inflates without bound: 2 (7^(-1/6) - 7^(-7/6))."""
GIVES_WAY = "of its load"
"""Words of an error of a shell that does not carry its load, `vsb.shell.loaded`."""
TRIALS = 4
"""Most walls, or moduli, that linear buckling allows and whose rest shape is followed under the growing load."""


def advised(study: Study, error: ConfigError) -> ConfigError:
    """Return an error with what would carry the shell's load in place of general advice, if that is what is wrong."""
    if not (study.at_equilibrium and study.device.shape is None and GIVES_WAY in str(error)):
        return error
    text = f"{str(error).partition(';')[0]}; {advice(study)}"
    return ConfigError(text, [text])


def advice(study: Study) -> str:
    """Return in words what carries the load: another pressure, or the least wall and the least modulus that stand.

    Each is tried: linear buckling and the limit point of a sphere choose, the rest shape under the growing load
    decides.
    """
    if (pressure := _standing_pressure(study)) is not None:
        return f"device.internal_pressure of {pressure:.3g} Pa carries this shell (tried)"
    if study.device.gas is None:
        trapped = study.model_copy(update={"device": study.device.model_copy(update={"gas": Gas()})})
        if (pressure := _standing_pressure(trapped)) is not None:
            return f"trapped gas (device.gas) with device.internal_pressure of {pressure:.3g} Pa carries it (tried)"
    found = [text for of_wall in (True, False) if (text := _least(study, of_wall=of_wall))]
    highest = f"{PRESSURES[-1] * _keel_pressure(study):.2g}"
    none = f"no device.internal_pressure from 0 to {highest} Pa carries this wall"
    if not found:
        return f"{none}, and no thin wall, nor a modulus {MOST:g} times as large, does; needs a smaller radius"
    return f"{none}; from {', or from '.join(found)}, it stands (tried)"


def _least(study: Study, *, of_wall: bool) -> str:
    """The least wall, or modulus, that stands, with its pressure, in words; empty if none does."""
    factor, trials = STEP, 0
    while factor < MOST and trials < TRIALS and (stiffer := _stiffer(study, factor, of_wall=of_wall)) is not None:
        if candidates := _candidates(stiffer):
            trials += 1
            if (pressure := _standing(candidates)) is not None:
                return f"{_size(stiffer, of_wall=of_wall)} at {pressure:.3g} Pa"
        factor *= STEP
    return ""


def _size(study: Study, *, of_wall: bool) -> str:
    """The wall, or the modulus, of a study in words."""
    device = study.device
    if of_wall:
        return f"about {1e3 * device.thickness:.2g} mm"
    if isinstance(device.material, Hookean):
        return f"young_modulus {1e-6 * device.young_modulus:.2g} MPa"
    return f"a shear modulus of {1e-6 * device.young_modulus / 3:.2g} MPa"


def _stiffer(study: Study, factor: float, *, of_wall: bool) -> Study | None:
    """The study with a thicker wall, or a stiffer material; None where the wall is no thin shell, or too heavy."""
    device = study.device
    if of_wall:
        thicker = device.model_copy(update={"thickness": factor * device.thickness})
        if not (10 * thicker.thickness < thicker.radius and thicker.shell_mass < thicker.mass):
            return None
        return study.model_copy(update={"device": thicker})
    moduli = {
        name: factor * getattr(device.material, name) for name in ("mu", "c1", "c2") if hasattr(device.material, name)
    }
    material = device.material.model_copy(update=moduli)
    changes = {"material": material, "young_modulus": factor * device.young_modulus}
    return study.model_copy(update={"device": device.model_copy(update=changes)})


def _keel_pressure(study: Study) -> float:
    """Pressure of the water at the keel [Pa]."""
    return study.water.density * study.water.gravity * study.draft


def _standing_pressure(study: Study) -> float | None:
    """A pressure with which the shell of a study carries its load; None if none that is tried does."""
    return _standing(_candidates(study))


def _candidates(study: Study) -> list[Study]:
    """The study with the pressures that linear buckling and inflation allow, the safest first."""
    device, found = study.device, []
    rubber = not isinstance(device.material, Hookean)
    limit = INFLATED * device.young_modulus / 3 * device.thickness / device.radius
    for share in PRESSURES:
        pressure = share * _keel_pressure(study)
        if rubber and device.gas is None and pressure > limit:
            break
        trial = study.model_copy(update={"device": device.model_copy(update={"internal_pressure": pressure})})
        if (factor := computed_buckling(trial).load_factor) > 1.0:
            found.append((factor, -pressure, trial))
    return [trial for *_, trial in sorted(found, key=lambda one: one[:2], reverse=True)]


def _standing(trials: Sequence[Study]) -> float | None:
    """The pressure of the first of some studies, two at most, whose shell the growing load leads to a rest."""
    for trial in trials[:2]:
        if stable_path(complete_loaded_shell(trial)).reached >= 1.0:
            return trial.device.internal_pressure
    return None
