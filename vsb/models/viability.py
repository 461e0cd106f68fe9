"""Whether a shell carries its load, a body rests stably: a campaign reports it for each point instead of failing."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np

from vsb.engine.motion.port import LinearPto, port_direction
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.loaded import Buckling, ElasticShell, LoadedShell, stable_path
from vsb.engine.shell.lobes import softest_order
from vsb.engine.shell.modes import ModeBasis
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.keys.quantities import canonical
from vsb.models.floating_system import AnyBody, FloatingSystem
from vsb.models.rest import (
    carries_load,
    check_upright,
    complete_loaded_shell,
    computed_buckling,
    design_stiffness,
    loaded_shell,
    order_bases,
    reference_shell,
    seen_by_take_off,
)
from vsb.study.body import BodyStudy
from vsb.study.specs import BodySystem
from vsb.study.study import Study, parse
from vsb.tools.arrays import FloatArray

MODULUS = 1e9
"""Young's modulus at which buckling is computed [Pa]: its load is proportional to it, and is cached by all else."""

MOST_LOAD = 2.0
"""Factor of its load to which a shell of rubber is followed."""
ORDERS, FOLDED = 12, 32
"""Azimuthal orders, and Legendre degrees, of the wrinkles that are looked for."""
ROUND_OFF = 1e-6
"""Compression over tension that is none."""


Some = TypeVar("Some", Study, BodyStudy | BodySystem, Study | BodyStudy | BodySystem)


@dataclass(frozen=True)
class Viability:
    """The shell of a buoy at rest, if there is one, how far it is from buckling, and why designs are not viable."""

    study: Study | AnyBody
    reference: ReferenceShell | None  # none of a body
    margin: float  # 1 - static load over buckling load: 0 on the line, 1 where no load buckles [-]
    reasons: Mapping[str, str]  # of designs that are not viable
    doubts: Mapping[str, str] = field(default_factory=dict)  # by design

    @property
    def designs(self) -> list[str]:
        """Names of the designs that are viable."""
        return [design for design in self.study.designs if design not in self.reasons]


def with_designs(study: Some, designs: Sequence[str]) -> Some:
    """Return a study, or what a stage reads of it, with some of its designs."""
    some = {design: study.designs[design] for design in designs}
    return study.model_copy(update={"designs": some})


def viability_of_body(study: AnyBody, floating: FloatingSystem) -> Viability:
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
        words = f"overstrained: {100 * strain:.3g} % at rest, {holds.law} ends at {100 * holds.invalid:g} %"
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
    return f"no equilibrium: {text.partition(';')[0]}"


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
