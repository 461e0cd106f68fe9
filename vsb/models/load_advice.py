"""What would carry the load of a shell that gives way: computed before it is advised, so that advice ends."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from vsb.engine.shell.device import Gas
from vsb.engine.shell.loaded import buckling, stable_path, viable_pressure
from vsb.engine.shell.lobes import LobedShell, with_lobes
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError, ConvergenceError
from vsb.models.rest import complete_loaded_shell, reference_shell
from vsb.models.viability import static_modal_amplitude, static_strain, wrinkles
from vsb.study.study import Study
from vsb.tools.words import plain

PRESSURES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0)
"""Internal pressures that are tried, in terms of that of water at the keel."""
STEP, MOST = 1.25, 200.0
"""Least factor between walls, or moduli, that are tried, and beyond which none is."""
INFLATED = 1.24
"""Pressure over mu h/r at which a sphere of neo-Hookean rubber inflates without bound: 2 (7^(-1/6) - 7^(-7/6))."""
GIVES_WAY = "of its load"
"""Words of an error of a shell that does not carry its load, `vsb.engine.shell.loaded`."""
UNSTABLE = "is unstable (least stiffness"
"""Likewise about the undeformed shape, `vsb.models.rest`."""
TRIALS = 4
"""Most walls, or moduli, that linear buckling allows and whose rest shape is followed under the growing load."""
CLOSE = 1.05
"""Likewise where the strain at rest says how much more is needed."""
OVERSTRAINED = 1.5
"""Linear strain at rest over the largest its law holds for, beyond which the true one, a lesser, is not computed."""


NOTHING = f"no thin wall, nor a modulus {MOST:g} times as large, does; needs a smaller radius"
"""What is said where nothing in reach stands."""


class Trial(NamedTuple):
    """A study at a pressure, and what linear theory says of its shell."""

    study: Study
    load_factor: float  # of buckling into axisymmetric shapes [-]
    strain: float  # at rest [-]

    @property
    def pressure(self) -> float:
        """The internal pressure [Pa]."""
        return self.study.device.internal_pressure


def advised(study: Study, error: ConfigError) -> ConfigError:
    """Return an error with what would carry the shell's load in place of general advice, if that is what is wrong."""
    if (GIVES_WAY if study.at_equilibrium else UNSTABLE) not in str(error):
        return error
    text = f"{str(error).partition(';')[0]}; {advice(study)}"
    return ConfigError(text, [text])


def advice(study: Study) -> str:
    """Return in words what carries the load of a shell: another pressure, or the least wall and the least modulus.

    Each is tried by what judges the study: about the equilibrium linear buckling, into lobes around the axis too where
    the shell is no sphere, and the limit point of rubber choose, and the rest shape under the growing load decides;
    about the undeformed shape linear buckling and the linear strain decide. Strains are within those of the material's
    law.
    """
    return _advice_at_rest(study) if study.at_equilibrium else _advice_undeformed(study)


def _advice_at_rest(study: Study) -> str:
    """What carries the load about the equilibrium."""
    trials = _trials(study)
    if (pressure := _standing(trials)) is not None:
        return f"device.internal_pressure of {pressure:g} Pa carries this shell (tried)"
    if study.device.gas is None and study.device.material.rubber:
        trapped = study.model_copy(update={"device": study.device.model_copy(update={"gas": Gas()})})
        if (pressure := _standing(_trials(trapped))) is not None:
            return f"trapped gas (device.gas) with device.internal_pressure of {pressure:g} Pa carries it (tried)"
    found = [text for of_wall in (True, False) if (text := _least(study, trials, of_wall=of_wall))]
    highest = f"{PRESSURES[-1] * _keel_pressure(study):.2g}"
    none = f"no device.internal_pressure from 0 to {highest} Pa carries this wall without straining it too far"
    if not found:
        return f"{none}, and {NOTHING}"
    return f"{none}; from {', or from '.join(found)}, it is stable (tried)"


def _advice_undeformed(study: Study) -> str:
    """What carries the load about the undeformed shape."""
    try:
        pressure, strain = viable(study)
    except ConvergenceError as error:
        none = str(error).partition(";")[0]
    else:
        less = "from" if study.device.internal_pressure < pressure else "at"
        text = f"by linear buckling viable {less} device.internal_pressure = {plain(pressure)} Pa, at "
        text += f"{100 * strain:.2g} % linear strain at rest"
        if strain < _range(study):
            return text
        none = f"{text}, where its law ends at {100 * _range(study):g} %"
    found = [text for of_wall in (True, False) if (text := _least_undeformed(study, of_wall=of_wall))]
    return f"{none}; from {', or from '.join(found)}, it is stable (tried)" if found else f"{none}; {NOTHING}"


class Viable(NamedTuple):
    """The least internal pressure at which a shell does not buckle by linear theory, and its strain there."""

    pressure: float  # rounded up to four digits [Pa]
    strain: float  # at rest, the larger of those of the complete basis and of the study's modes [-]


def viable(study: Study) -> Viable:
    """Return from which internal pressure a shell is viable by linear buckling, into lobes too if it is no sphere.

    Raises `ConvergenceError` if no pressure suffices.
    """
    sphere = study.device.shape is None
    lobes = (lambda _: ()) if sphere else (lambda loaded: LobedShell.of(loaded).pencils())
    pressure, found = viable_pressure(study.device, study.centre_height, study.water, lobes)
    least = float(f"{pressure:.3e}")
    least += 10.0 ** (math.floor(math.log10(least)) - 3) if 0 < least < pressure else 0.0  # it holds there
    least = float(f"{least:.3e}")
    at_it = study.model_copy(update={"device": study.device.model_copy(update={"internal_pressure": least})})
    reference = reference_shell(at_it)
    judged = static_strain(reference.basis, static_modal_amplitude(at_it, reference))
    return Viable(least, max(found.linear_strain, judged))


def _least_undeformed(study: Study, *, of_wall: bool) -> str:
    """The least wall, or modulus, that is viable at a strain its law holds for, in words; empty if none is."""
    factor, size, stiffer = 1.0, _size(study, of_wall=of_wall), study
    while True:
        try:
            pressure, strain = viable(stiffer)
            if strain < _range(study):
                return f"{_words(stiffer, of_wall=of_wall)} at {pressure:g} Pa"
            factor *= max(CLOSE, strain / _range(study))
        except ConvergenceError:
            factor *= STEP
        factor = _rounded_up(factor * size) / size  # what is tried is what is said
        if factor > MOST or (next_one := _stiffer(study, factor, of_wall=of_wall)) is None:
            return ""
        stiffer = next_one


def _least(study: Study, trials: Sequence[Trial], *, of_wall: bool) -> str:
    """The least wall, or modulus, that stands, with its pressure, in words; empty if none does.

    The load that buckles a wall grows with the cube of its thickness at most, so that no wall is passed over that
    stands; with the modulus in proportion, save of rubber, which bears more pressure then.
    """
    exponent = 1.0 if not of_wall and not study.device.material.rubber else 1 / 3
    factor, followed = 1.0, 0
    while followed < TRIALS:
        carried = max((trial.load_factor for trial in trials), default=1.0)  # share of the load
        factor *= max(STEP, carried**-exponent)
        size = _size(study, of_wall=of_wall)
        factor = _rounded_up(factor * size) / size  # what is tried is what is said
        if factor > MOST or (stiffer := _stiffer(study, factor, of_wall=of_wall)) is None:
            return ""
        trials = _trials(stiffer)
        if _allowed(trials):
            followed += 1
            if (pressure := _standing(trials)) is not None:
                return f"{_words(stiffer, of_wall=of_wall)} at {pressure:g} Pa"
    return ""


def _words(study: Study, *, of_wall: bool) -> str:
    """The wall, or the modulus, of a study in words."""
    size = f"{float(f'{_size(study, of_wall=of_wall):.2g}'):g}"
    if of_wall:
        return f"a thickness of about {size} mm"
    hooke = not study.device.material.rubber
    return f"young_modulus {size} MPa" if hooke else f"a shear modulus of {size} MPa"


def _size(study: Study, *, of_wall: bool) -> float:
    """The wall [mm], Young's modulus [MPa] or, of rubber, the shear modulus [MPa] of a study."""
    device = study.device
    if of_wall:
        return 1e3 * device.thickness
    return 1e-6 * device.young_modulus / (1 if not device.material.rubber else 3)


def _rounded_up(value: float) -> float:
    """The next larger number of two digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit - 1e-9) * unit


def _stiffer(study: Study, factor: float, *, of_wall: bool) -> Study | None:
    """The study with a thicker wall, or a stiffer material; None where the wall is no thin shell, or too heavy."""
    device = study.device
    if of_wall:
        thicker = device.model_copy(update={"thickness": factor * device.thickness})
        sharpest = device.radius if device.meridian is None else device.meridian.sharpest
        if not (10 * thicker.thickness < min(device.radius, sharpest) and thicker.shell_mass < thicker.mass):
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


def _trials(study: Study) -> list[Trial]:
    """The study at the pressures that inflation allows."""
    device, found = study.device, []
    rubber = device.material.rubber
    limit = INFLATED * device.young_modulus / 3 * device.thickness / device.radius
    for share in PRESSURES:
        pressure = float(f"{share * _keel_pressure(study):.3g}")
        if rubber and device.gas is None and pressure > limit:
            break
        trial = study.model_copy(update={"device": device.model_copy(update={"internal_pressure": pressure})})
        linear = buckling(complete_loaded_shell(trial))
        found.append(Trial(trial, linear.load_factor, linear.linear_strain))
    return found


def _allowed(trials: Sequence[Trial]) -> list[Trial]:
    """Those of some studies that linear theory allows, the one of the least pressure first."""
    return [trial for trial in trials if trial.load_factor > 1.0 and trial.strain < OVERSTRAINED * _range(trial.study)]


def _range(study: Study) -> float:
    """The largest strain the law of the shell's material holds for [-]."""
    return Shell.of(study.device).law.range.invalid


def _standing(trials: Sequence[Trial]) -> float | None:
    """The pressure of one of some studies that its growing load leads to a rest; None if none is.

    Neither overstrained nor wrinkled. Two at most are followed: the safest, and that of the least pressure, which
    strains least.
    """
    allowed = _allowed(trials)
    for trial in [max(allowed, key=lambda trial: trial.load_factor), allowed[0]] if allowed else []:
        loaded = complete_loaded_shell(trial.study)
        if loaded.basis.shell.rest is not None and with_lobes(loaded).load_factor <= 1.0:
            continue
        path = stable_path(loaded)
        if path.reached < 1.0 or loaded.basis.shell.law.range.is_invalid(static_strain(loaded.basis, path.amplitudes)):
            continue
        if not loaded.basis.shell.rubber or wrinkles(loaded, path.amplitudes).stiffness > 0:
            return trial.pressure
    return None
