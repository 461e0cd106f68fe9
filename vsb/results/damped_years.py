"""The years of a member's designs under dampers; a rigid design that points have in common is computed once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from vsb.motion.coefficient_errors import CoefficientError, sensitivity
from vsb.motion.port import Port
from vsb.results.validity import beyond_validity
from vsb.results.year import DesignYear, Tuning, Year, best_for_all, gain_percent, year
from vsb.scenes.ports import InWaves
from vsb.scenes.viability import with_designs
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, FloatArray
from vsb.waves.climate import Climate

Values = Mapping[str, tuple[tuple[str, ...], AnyArray]]
"""Dimensions and values by name: a dataset is made of all at the end, for each costs as much as what it holds."""
BY = ("design", "tuning")
CURVES = ("tried_damping", "power_of_damping", "force_of_damping")
TRIED = np.geomspace(1 / 30, 30, 61)
"""Dampers the year's power is told of, in terms of the best one for the year."""
KEPT = 32
"""Rigid designs that are kept: no material and no thickness changes them."""


@dataclass(frozen=True)
class DampedYears:
    """What finds the years of designs under dampers, and mean power over a damper that stays as it is."""

    climate: Climate
    tunings: Sequence[Tuning]
    known: dict[bytes, Values] = field(default_factory=dict)  # of rigid designs of the points before

    def __call__(
        self,
        study: Study,
        waves: Mapping[str, InWaves],
        errors: Sequence[CoefficientError] = (),
        left_out: FloatArray | None = None,
    ) -> Values:
        """Return the figures of some designs of a study in waves, each shape (design, ...), and their gains.

        The intervals of gains are of quadrature over frequency, of errors of the coefficients, which designs share, and
        of shell modes left out.

        Parameters
        ----------
        study : Study
        waves : mapping design -> InWaves
        errors : sequence of CoefficientError
        left_out : ndarray, shape (design, end) [percentage points], optional
            As of `vsb.results.left_out.gain_of_year`.
        """
        rigid = {name: _key(study, name, one) for name, one in waves.items() if not study.designs[name].flexible}
        parts = {name: self.known[key] for name, key in rigid.items() if key in self.known}
        if new := {name: one for name, one in waves.items() if name not in parts}:
            found = self._computed(with_designs(study, list(new)), new)
            parts |= {name: _of_design(found, i) for i, name in enumerate(new)}
        if len(self.known) > KEPT:
            self.known.clear()
        self.known.update({key: parts[name] for name, key in rigid.items()})
        together = _stacked([parts[name] for name in waves])
        if (reference := study.reference_design) is None or "annual_mean_power" not in together:
            return together
        apart = self._apart(study, waves, together, errors)
        beyond = np.zeros((len(waves), 2)) if left_out is None else left_out
        return {**together, **_gains(together, list(waves), reference, apart, beyond)}

    def _apart(
        self, study: Study, waves: Mapping[str, InWaves], found: Values, errors: Sequence[CoefficientError]
    ) -> FloatArray:
        """Largest relative change of every design's power over the reference's by the errors, (design, tuning) [-].

        At the given damper, else at the best one for the year, near which the best ones of most of its energy lie.
        """
        spring, best = study.pto.stiffness, np.asarray(found["tried_damping"][1])[:, len(TRIED) // 2]
        apart = np.zeros((len(waves), len(self.tunings)))
        for j, tuning in enumerate(self.tunings):
            slopes = []
            for (design, one), damping in zip(waves.items(), best, strict=True):
                damper = float(study.pto.damper(design) or 0.0) if tuning == "fixed" else float(damping)
                squares = DesignYear(one.port, self.climate).squares
                load = one.port.load(damper, spring)
                slopes.append(sensitivity(one.port.omega, one.moved, one.port, load, squares))
            base = slopes[list(waves).index(study.reference_design or "")]
            apart[:, j] = [sum((one - base).to(error) for error in errors) for one in slopes]
        return apart

    def _computed(self, study: Study, waves: Mapping[str, InWaves]) -> Values:
        """The figures of designs that are not known."""
        ports = {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}
        if not self.tunings:
            return _curves(ports, self.climate, None)
        of = ports_year(study, ports, self.climate, self.tunings)
        beyond = beyond_validity(of, waves, study.pto.stiffness, study.device.radius)
        return {**of.values, **beyond, **_curves(ports, self.climate, of)}


def _key(study: Study, design: str, waves: InWaves) -> bytes:
    """All that the year of a rigid design depends on in one climate, its motion among it."""
    parts = (waves.port.velocity, waves.port.admittance, *waves.motion.heave, *waves.motion.shell)
    pto, water = study.pto, study.water  # of which the port does not tell the energy flux and breaking
    given = (pto.stiffness, pto.damper(design) or 0.0, study.device.radius, water.density, water.depth, water.gravity)
    return b"".join(part.tobytes() for part in parts) + np.array(given).tobytes()


def _of_design(found: Values, i: int) -> Values:
    """The figures of one of the designs."""
    return {name: (dims[1:], values[i]) for name, (dims, values) in found.items() if dims[0] == "design"}


def _stacked(parts: Sequence[Values]) -> dict[str, tuple[tuple[str, ...], AnyArray]]:
    """The figures of designs together, (design, ...); gains are none of one design alone."""
    names = [name for name in parts[0] if not name.startswith("gain")]
    return {name: (("design", *parts[0][name][0]), np.stack([part[name][1] for part in parts])) for name in names}


def ports_year(study: Study, ports: Mapping[str, Port], climate: Climate, tunings: Sequence[Tuning]) -> Year:
    """Return the year of the designs of a study from their ports."""
    dampers = {design: study.pto.damper(design) for design in study.designs}
    given = {design: damping for design, damping in dampers.items() if damping is not None}
    return year(ports, climate, study.water, tunings, given, study.reference_design)


def _curves(ports: Mapping[str, Port], climate: Climate, of: Year | None) -> Values:
    """Mean power of the year and rms force of dampers that stay as they are, each shape (design, damper)."""
    years = [DesignYear(port, climate) for port in ports.values()]
    known = of.damping[:, of.tunings.index("one"), 0] if of and "one" in of.tunings else None
    tried = np.outer(best_for_all(years) if known is None else known, TRIED)
    power = np.array([one.annual(dampers) for one, dampers in zip(years, tried, strict=True)])
    found = (tried, power, np.sqrt(tried * power))
    return {name: (("design", "damper"), values) for name, values in zip(CURVES, found, strict=True)}


def _gains(found: Values, designs: Sequence[str], reference: str, apart: FloatArray, left_out: FloatArray) -> Values:
    """Gains over the reference under the same tuning, and where they lie by the errors that are known.

    Those are quadrature over frequency; `apart`, what errors of the coefficients do to the ratio of powers; and what
    shell modes left out may change.
    """
    at, power = designs.index(reference), _plain(found, "annual_mean_power")
    if (gain := gain_percent(power, at)) is None:
        return {}
    error = np.divide(_plain(found, "quadrature_error"), power, out=np.zeros_like(power), where=power > 0)
    width = (error + error[at] + apart) * (100 + gain)
    width[at] *= 0.0
    low, high = left_out.T[:, :, None]
    return {"gain_percent": (BY, gain), "gain_low": (BY, gain - width + low), "gain_high": (BY, gain + width + high)}


def _plain(found: Values, name: str) -> FloatArray:
    """Numbers of a name."""
    return np.asarray(found[name][1], dtype=float)
