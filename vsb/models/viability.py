"""Whether a shell carries its load, a body rests stably: a campaign reports it for each point instead of failing."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vsb.engine.motion.port import LinearPto, port_direction
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.device import Gas
from vsb.engine.shell.loaded import Buckling, ElasticShell, LoadedShell, buckling, stable_path, viable_pressure
from vsb.engine.shell.lobes import LobedShell, softest_order, with_lobes
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.keys.quantities import canonical
from vsb.models.floating_system import FloatingSystem
from vsb.models.rest import (
    carries_load,
    check_rests,
    check_upright,
    complete_loaded_shell,
    computed_buckling,
    design_stiffness,
    loaded_shell,
    order_bases,
    reference_shell,
    seen_by_take_off,
)
from vsb.study.study import Study, parse
from vsb.tools.arrays import FloatArray
from vsb.tools.words import plain

MODULUS = 1e9
"""Young's modulus at which buckling is computed [Pa]: its load is proportional to it, and is cached by all else."""

MOST_LOAD = 2.0
"""Factor of its load to which a shell of rubber is followed."""
ORDERS, FOLDED = 12, 32
"""Azimuthal orders, and Legendre degrees, of the wrinkles that are looked for."""
ROUND_OFF = 1e-6
"""Compression over tension that is none."""
SPARE = 0.01
"""Stiffness against buckling that an advised pressure leaves, over that without load: where it ends strains do not."""
OVERLOADED = ("overstrained", "no equilibrium")
"""How reasons begin for which `advice` has an answer: the shell does not carry its load."""


@dataclass(frozen=True)
class Viability:
    """The shell of a buoy at rest, if there is one, how far it is from buckling, and why designs are not viable."""

    study: Study
    reference: ReferenceShell | None  # none of a body
    margin: float  # 1 - static load over buckling load: 0 on the line, 1 where no load buckles [-]
    reasons: Mapping[str, str]  # of designs that are not viable
    doubts: Mapping[str, str] = field(default_factory=dict)  # by design

    @property
    def designs(self) -> list[str]:
        """Names of the designs that are viable."""
        return [design for design in self.study.designs if design not in self.reasons]


def with_designs(study: Study, designs: Sequence[str]) -> Study:
    """Return a study, or what a stage reads of it, with some of its designs."""
    some = {design: study.designs[design] for design in designs}
    return study.model_copy(update={"designs": some})


def viability_of_body(study: Study, floating: FloatingSystem) -> Viability:
    """Return which designs of a body rest stably beside the spring of the take-off; nothing there buckles."""
    spring, reasons = LinearPto(0.0, study.pto.stiffness, floating.port).spring(len(floating.port)), {}
    for design, motions in floating.motions.items():
        try:
            floating.linear.unrestrained(motions.T @ (floating.linear.stiffness + spring) @ motions, motions)
        except StabilityError as error:
            reasons[design] = f"unstable: {str(error).partition(': ')[2].partition(';')[0]}"
    return Viability(study, None, 1.0, reasons)


def viability(study: Study) -> Viability:
    """Return whether the designs of a study rest stably; a shell that buckles about the sphere has a margin below 0."""
    margin = buckling_margin(study)
    try:
        reference = reference_shell(study)
    except (ConfigError, ConvergenceError) as error:
        if not study.at_equilibrium:
            raise
        return Viability(study, None, margin, dict.fromkeys(study.designs, _no_equilibrium(error)))
    try:
        check_upright(study, reference)
    except ConfigError:
        return Viability(study, reference, margin, dict.fromkeys(study.designs, "does not stay upright"))
    port = port_direction(study.pto.port, reference.shape, order_bases(study, reference.basis))
    seen, chamber = seen_by_take_off(study, reference)
    spring = LinearPto(0.0, study.pto.stiffness, port).relaxed(chamber)[0].spring(len(port))
    least = {design: design_stiffness(study, seen, design, spring) for design in study.designs}
    reasons = {design: f"unstable: least stiffness {k:.3g} N/m" for design, k in least.items() if k <= 0}
    flexible = [design for design, one in study.designs.items() if one.flexible]
    strain = static_strain(reference.basis, static_modal_amplitude(study, reference)) if flexible else 0.0
    holds = reference.basis.shell.law.range
    if holds.is_invalid(strain):
        words = f"{OVERLOADED[0]}: {100 * strain:.3g} % at rest, {holds.law} ends at {100 * holds.invalid:g} %"
        return Viability(study, reference, margin, dict.fromkeys(flexible, words) | reasons)
    words = f"doubtful: strained by {100 * strain:.3g} % at rest, above {100 * holds.doubted:g} %"
    doubts = dict.fromkeys(flexible, words) if holds.is_doubted(strain) else {}
    return Viability(study, reference, margin, reasons, doubts)


class Wrinkles(NamedTuple):
    """What compresses the wall of a shell at rest, and whether it folds into wrinkles."""

    force: float  # largest compressive membrane force [N/m]
    share: float  # over the largest tension [-]
    stiffness: float  # least of shapes that vary around the axis; not above 0 where the shell wrinkles [-]
    order: int  # azimuthal, of that shape

    @property
    def compressed(self) -> bool:
        """Whether anything is compressed."""
        return self.share > ROUND_OFF


def wrinkles(loaded: LoadedShell, q: FloatArray) -> Wrinkles:
    """Return the compression of a shell at rest, and how stiff its softest shape is where there is any."""
    meridional, hoop = loaded.elastic.resultants(q)
    least, most = float(np.minimum(meridional, hoop).min()), float(np.maximum(meridional, hoop).max())
    force = max(0.0, -least)
    found = Wrinkles(force, force / (max(most, -least) or 1.0), 1.0, 0)
    return Wrinkles(*found[:2], *softest_order(loaded, q, ORDERS, FOLDED)) if found.compressed else found


def static_modal_amplitude(study: Study, reference: ReferenceShell) -> FloatArray:
    """Return heave and modal amplitudes at rest, shape (dof,) [m]: of the equilibrium, or linear about the sphere."""
    if study.at_equilibrium:
        return reference.modal_amplitude
    load = loaded_shell(study, reference.basis).force(reference.modal_amplitude)
    return np.asarray(np.linalg.solve(reference.total, load))


def static_strain(basis: ModeBasis, modal_amplitude: FloatArray) -> float:
    """Return the strain of the shell at rest as its law measures it, `Law.strained` [-]."""
    return float(basis.shell.law.strained(*ElasticShell(basis).strains(modal_amplitude)).max())


def _no_equilibrium(error: Exception) -> str:
    """Why there is no shape at rest, in few words."""
    text = str(error).removeprefix("reference_shape: received 'equilibrium', but ")
    return f"{OVERLOADED[1]}: {text.partition(';')[0]}"


def buckling_margin(study: Study) -> float:
    """Return 1 - static load over computed buckling load [-]; 1 of a study without flexible designs.

    Without trapped gas the load is that of weight, water and internal pressure, which does not depend on the modulus:
    the buckling load is proportional to it. Rubber at its equilibrium is followed along the growing load instead, to
    `MOST_LOAD` at most. As in the checks of a study, a shell that buckles by linear theory but comes to a stable rest
    shape along the growing load carries it: 0; not if it buckles into lobes, which that path does not see.
    """
    if not study.flexible:
        return 1.0
    rubber = study.device.material.rubber
    if rubber and study.at_equilibrium:
        return 1.0 - 1.0 / rubber_load_factor(complete_loaded_shell(study))
    if rubber or study.device.gas:
        found = computed_buckling(study)
        margin = 1.0 - 1.0 / found.load_factor
    else:
        found = _buckling_at_modulus(_at_modulus(study))
        margin = 1.0 - MODULUS / study.device.young_modulus / found.load_factor
    if margin < 0 and not found.order and (study.at_equilibrium or study.device.internal_pressure > 0):
        return 0.0 if carries_load(study) else margin
    return margin


@lru_cache(maxsize=16)
def rubber_load_factor(loaded: LoadedShell) -> float:
    """Return the factor of its load at which a shell of rubber becomes unstable, `MOST_LOAD` at most [-]."""
    return max(stable_path(loaded, until=MOST_LOAD).reached, 1e-3)


def _at_modulus(study: Study) -> str:
    """All that buckling depends on, as text, with the modulus it is computed at."""
    device = study.device.model_copy(update={"young_modulus": MODULUS})
    water = study.water.model_copy(update={"depth": math.inf})
    return canonical({"device": device.model_dump(exclude={"damping"}), "water": water})


@lru_cache(maxsize=4096)
def _buckling_at_modulus(text: str) -> Buckling:
    """Linear buckling of the shell of a text of `_at_modulus`."""
    raw = json.loads(text)
    study = parse({"study": "shell", "designs": {"shell": {}}, "waves": [{"kind": "still"}], **raw}, source="shell")
    return computed_buckling(study)


# what would carry the load of a shell that gives way ----------------------------------------------------------------

# It is computed before it is advised, so that advice ends.

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


def check_rests_advised(study: Study, reference: ReferenceShell) -> None:
    """Check that every design comes to rest in body-exact water; if not, an internal pressure that does is named.

    Raises `ConfigError`.
    """
    try:
        check_rests(study, reference)
    except ConfigError as error:
        text, _, others = str(error).partition("; raise ")
        trials = [_at_pressure(study, share) for share in PRESSURES] if others else []
        found = next((f"{one.device.internal_pressure:g}" for one in trials if _comes_to_rest(one)), "")
        if found:
            text += f"; device.internal_pressure of {found} Pa carries it (tried), or use hydro.model: linear"
        elif trials:
            text += f"; no device.internal_pressure from 0 to {trials[-1].device.internal_pressure:g} Pa carries it"
            text += " (tried); needs a thicker or stiffer shell, or hydro.model: linear"
        raise ConfigError(text, [text]) from None


def _comes_to_rest(study: Study) -> bool:
    """Whether no design buckles and all rest in body-exact water, at strains the law of the material holds for."""
    try:
        rest = viability(study)
        if rest.reasons or rest.reference is None or rest.margin < 0:
            return False
        check_rests(study, rest.reference)
    except (ConfigError, ConvergenceError):
        return False
    return True


def _at_pressure(study: Study, share: float) -> Study:
    """The study at an internal pressure, in terms of that of the water at the keel."""
    pressure = float(f"{share * _keel_pressure(study):.3g}")
    return study.model_copy(update={"device": study.device.model_copy(update={"internal_pressure": pressure})})


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
    pressure, found = viable_pressure(study.device, study.centre_height, study.water, lobes, SPARE)
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
        trial = _at_pressure(study, share)
        if rubber and device.gas is None and trial.device.internal_pressure > limit:
            break
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
