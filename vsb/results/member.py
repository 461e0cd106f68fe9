"""A member of a campaign: the designs of one study over a site's year under every tuning, gains and their intervals.

A rigid design does not depend on material and thickness: members share its year, computed once.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import xarray as xr

from vsb.engine.motion.coefficient_errors import CoefficientError, sensitivity
from vsb.engine.motion.port import Port
from vsb.engine.motion.take_off import named_ports
from vsb.engine.waves.climate import Climate
from vsb.models.floating_system import AnyBody, Floating, InWaves
from vsb.models.viability import Viability, with_designs
from vsb.results.causal_year import causal_years
from vsb.results.left_out import LeftOut, left_out_of_year
from vsb.results.matrix_year import MatrixYears
from vsb.results.year import (
    POWER_ENDS,
    DesignYear,
    Tuning,
    Values,
    Year,
    best_for_all,
    bins_of,
    frequencies,
    gains_within,
    powers_within,
    year,
)
from vsb.results.year_validity import beyond_validity, limits_of, motion_rms
from vsb.study.campaign import AT_FORCE, CONSTRAINED, Tunings
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, FloatArray

Labels = dict[str, list[str]]
YearsWithin = Callable[[Study | AnyBody, Floating, Climate, LeftOut | None], xr.Dataset]
"""Study of viable designs, what floats in it, climate, shell modes left out -> their years within limits."""

BY, BINS = ("design", "tuning"), ("hs", "te")
OF_DESIGNS = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "force_rms",
    "practice_power", "quadrature_error", "energy_beyond_validity", *POWER_ENDS,
)  # fmt: skip
MATRICES = (
    "damping", "power_matrix", "power_deviation", "capture_width_matrix", "capture_width_deviation", "beyond_validity",
)  # fmt: skip
MATRIX = "damper_matrix"
OF_DAMPERS = ("force_rms", "damping")
"""Variables that a take-off of one damper has alone; of several ports there is a matrix."""
CURVES = ("tried_damping", "power_of_damping", "force_of_damping")
OF_LIMITS = ("power_bound", "optimum_gap", "optimum_share", "optimum_excess", "impossible_share")
"""Variables of designs that only optima within limits have."""
OF_ALL: dict[str, tuple[str, ...]] = {"viable": ("design",), "reason": ("design",), "margin": ()}
"""Variables of every design, viable or not, and of the shell."""
TRIED = np.geomspace(1 / 30, 30, 61)
"""Dampers the curves are computed at, over the best one for the year."""
KEPT = 32
"""Rigid designs whose years are kept."""

SAME_FOR_ALL = ("count", "occurrence")
"""Variables of the year alone."""


def member(
    rest: Viability,
    floating: Callable[[], Floating],
    climate: Climate,
    tunings: Sequence[Tunings],
    optima: YearsWithin | None = None,
    known: dict[bytes, Values] | None = None,
) -> xr.Dataset:
    """Return the year of every design of a study under every tuning; NaN of designs that are not viable.

    Parameters
    ----------
    rest : Viability
        Of the study, a buoy's or a body's.
    floating : callable
        Returns what floats of the designs that are viable; not called where none is.
    tunings : sequence of {'fixed', 'one', 'each', 'damper_same_force', 'causal', 'constrained'}
    optima : callable, optional
        Computes the years within limits, `vsb.results.constrained_year.Optima`; needed for `constrained`.
    known : dict, optional
        Rigid designs of earlier members; added to.
    """
    study = rest.study
    limits, compared = limits_of(radius_of(study)), study.reference_design is not None
    names = (*(named_ports(study.pto) or ("shell",)),) if study.pto.several else ()
    blank = _blank(tuple(study.designs), tuple(tunings), climate, limits, compared, names)
    found = {name: (dims, values.copy()) for name, (dims, values) in _values(blank).items()}
    at: Labels = {"design": list(study.designs), "tuning": list(tunings)}
    if rest.designs:
        some = with_designs(study, rest.designs)
        system = floating()
        omega = frequencies(climate, *system.band)
        dampers = [one for one in tunings if one not in (*AT_FORCE, CONSTRAINED)]
        damped = DampedYears(climate, dampers, {} if known is None else known)
        here: Labels = {"design": list(some.designs), "tuning": [*damped.tunings]}
        errors, moving = system.errors(omega), system.at(omega)
        ports = moving.several_in_waves() if some.pto.several else {}
        waves = {} if ports else moving.in_waves()
        left_out = left_out_of_year(some, system, climate)
        own: Values = {}
        if ports and damped.tunings:
            own = MatrixYears(climate, damped.tunings)(some, ports, errors, left_out)
        elif not ports:
            own = damped(some, waves, errors, left_out)
        _fill(found, at, own, here)
        if at_force := [str(one) for one in tunings if one in AT_FORCE]:
            _fill(found, at, causal_years(some, system, climate, at_force, left_out), here | {"tuning": at_force})
        if optima:
            within = optima(some, system, climate, left_out)
            _fill(found, at, _values(within), here | {"tuning": [CONSTRAINED]})
    words = {**rest.doubts, **rest.reasons}
    filled = {name: values for name, (_, values) in found.items()} | {
        "viable": np.array([design not in rest.reasons for design in study.designs]),
        "reason": np.array([words.get(design, "") for design in study.designs], dtype=object),
        "margin": np.array(rest.margin),
    }
    flux = bins_of(climate).mean(climate.flux(study.water))
    return blank.copy(data=filled).assign(flux_matrix=(BINS, flux))


def _values(ds: xr.Dataset) -> Values:
    """Dimensions and values of the variables of a dataset."""
    return {str(name): (tuple(map(str, ds.variables[name].dims)), ds.variables[name].values) for name in ds.data_vars}


def radius_of(study: Study | AnyBody) -> float | None:
    """Return the radius of a buoy, in terms of which its motion is judged [m]; None of a body."""
    return study.buoy.device.radius if study.buoy else None


@lru_cache(maxsize=4)
def _blank(
    designs: tuple[str, ...],
    tunings: tuple[str, ...],
    climate: Climate,
    limits: tuple[str, ...],
    compared: bool,
    ports: tuple[str, ...],
) -> xr.Dataset:
    """All variables without values, and how many seas a bin holds; made once, for it takes as long as to fill it."""
    bins = bins_of(climate)
    sizes = {"design": len(designs), "tuning": len(tunings), "limit": len(limits), "damper": len(TRIED)}
    sizes |= dict(zip(BINS, bins.shape, strict=True))
    names = [name for name in OF_DESIGNS if compared or not name.startswith("gain")]
    dims: dict[str, tuple[str, ...]] = dict.fromkeys(names, BY) | dict.fromkeys(MATRICES, (*BY, *BINS))
    dims |= {"energy_beyond": (*BY, "limit")}
    if ports:
        sizes |= {"port": len(ports), "port_": len(ports)}
        dims = {name: of for name, of in dims.items() if name not in OF_DAMPERS} | {MATRIX: (*BY, "port", "port_")}
    else:
        dims |= dict.fromkeys(CURVES, ("design", "damper"))
    dims |= dict.fromkeys(OF_LIMITS if CONSTRAINED in tunings else (), ("design",))
    values: dict[str, tuple[tuple[str, ...], AnyArray]]
    values = {name: (of, np.full([sizes[dim] for dim in of], np.nan)) for name, of in dims.items()}
    of_all = {name: (of, np.zeros([sizes[dim] for dim in of])) for name, of in OF_ALL.items()}
    at = {"design": list(designs), "tuning": list(tunings), "limit": list(limits)}
    at |= {"port": list(ports), "port_": list(ports)} if ports else {}
    of_bins = {"hs": bins.hs_centres, "te": bins.te_centres}
    of_year = {"count": (BINS, bins.count), "occurrence": (BINS, bins.share)}
    return xr.Dataset({**values, **of_year, **of_all}, coords=at | of_bins)


def _fill(found: Values, at: Labels, of: Values, here: Labels) -> None:
    """Put the values of some designs, and of some tunings, in their places."""
    for name in of.keys() & found.keys() - {*SAME_FOR_ALL, "flux_matrix"}:
        dims, values = of[name]
        places = [[at[dim].index(label) for label in here[dim]] for dim in BY if dim in dims]
        found[name][1][np.ix_(*places)] = values


def ports_year(study: Study | AnyBody, ports: Mapping[str, Port], climate: Climate, tunings: Sequence[Tuning]) -> Year:
    """Return the year of the designs of a study from their ports."""
    dampers = {design: study.pto.damper(design) for design in study.designs}
    given = {design: damping for design, damping in dampers.items() if damping is not None}
    return year(ports, climate, study.water, tunings, given, study.reference_design, study.pto.efficiency)


@dataclass(frozen=True)
class DampedYears:
    """Years of designs under dampers, and their mean power over a damper that stays the same all year."""

    climate: Climate
    tunings: Sequence[Tuning]
    known: dict[bytes, Values] = field(default_factory=dict)  # of rigid designs of earlier members

    def __call__(
        self,
        study: Study | AnyBody,
        waves: Mapping[str, InWaves],
        errors: Sequence[CoefficientError] = (),
        left_out: LeftOut | None = None,
    ) -> Values:
        """Return the results of some designs of a study in waves, each shape (design, ...), and their gains.

        Parameters
        ----------
        waves : mapping design -> InWaves
        errors : sequence of CoefficientError
            Shared by all designs; with quadrature over frequency they make the intervals of powers and gains.
        left_out : LeftOut, optional
            Added to these intervals.
        """
        keys = {name: self._key(study, name, one) for name, one in waves.items() if not study.designs[name].flexible}
        parts = {name: self.known[key] for name, key in keys.items() if key in self.known}
        if new := {name: one for name, one in waves.items() if name not in parts}:
            found = self._computed(with_designs(study, list(new)), new)
            for i, name in enumerate(new):
                of_designs = {k: (dims[1:], values[i]) for k, (dims, values) in found.items() if dims[0] == "design"}
                parts[name] = {k: value for k, value in of_designs.items() if not k.startswith("gain")}
        if len(self.known) > KEPT:
            self.known.clear()
        self.known.update({key: parts[name] for name, key in keys.items()})
        some = [parts[name] for name in waves]
        together: dict[str, tuple[tuple[str, ...], AnyArray]] = {
            name: (("design", *dims), np.stack([part[name][1] for part in some])) for name, (dims, _) in some[0].items()
        }
        if "annual_mean_power" not in together:
            return together
        return {**together, **self._intervals(study, waves, together, errors, left_out)}

    def _key(self, study: Study | AnyBody, design: str, waves: InWaves) -> bytes:
        """All that the year of a rigid design depends on in one climate."""
        parts = (waves.port.velocity, waves.port.admittance, *waves.motion.heave, *waves.motion.shell)
        pto, water = study.pto, study.water  # which the energy flux and breaking depend on, the port does not
        given = (pto.stiffness, pto.damper(design) or 0.0, pto.efficiency, radius_of(study) or 0.0)
        return (
            b"".join(part.tobytes() for part in parts)
            + np.array([*given, water.density, water.depth, water.gravity]).tobytes()
        )

    def _computed(self, study: Study | AnyBody, waves: Mapping[str, InWaves]) -> Values:
        """Results of designs that are not known yet."""
        ports = {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}
        if not self.tunings:
            return self._curves(ports, None, study.pto.efficiency)
        of = ports_year(study, ports, self.climate, self.tunings)

        def motions(design: str, tuning: str) -> dict[str, FloatArray]:
            damping = of.dampers[of.designs.index(design), of.tunings.index(tuning)]
            return motion_rms(waves[design], self.climate, damping, study.pto.stiffness)

        beyond, curves = beyond_validity(of, motions, radius_of(study)), self._curves(ports, of, study.pto.efficiency)
        return {**of.values, **beyond, **curves}

    def _curves(self, ports: Mapping[str, Port], of: Year | None, efficiency: float) -> Values:
        """Mean power of the year and rms force of dampers that stay the same, each shape (design, damper)."""
        years = [DesignYear(port, self.climate, efficiency) for port in ports.values()]
        known = of.dampers[:, of.tunings.index("one"), 0] if of and "one" in of.tunings else None
        tried = np.outer(best_for_all(years) if known is None else known, TRIED)
        power = np.array([one.annual(dampers) for one, dampers in zip(years, tried, strict=True)])
        found = (tried, power, np.sqrt(tried * power / efficiency))
        return {name: (("design", "damper"), values) for name, values in zip(CURVES, found, strict=True)}

    def _intervals(
        self,
        study: Study | AnyBody,
        waves: Mapping[str, InWaves],
        found: Values,
        errors: Sequence[CoefficientError],
        left_out: LeftOut | None,
    ) -> Values:
        """Intervals of powers by all known errors, gains over the reference under the same tuning, and theirs.

        What errors of the coefficients do to powers and their ratio is taken at the given damper, else at the best one
        for the year, near which the best ones of most of its energy lie.
        """
        reference = None if study.reference_design is None else list(waves).index(study.reference_design)
        power, error = (np.asarray(found[name][1], dtype=float) for name in ("annual_mean_power", "quadrature_error"))
        best = np.asarray(found["tried_damping"][1])[:, len(TRIED) // 2]
        of_power, of_ratio = np.zeros((2, *power.shape))
        for j, tuning in enumerate(self.tunings):
            slopes = []
            for (design, one), damping in zip(waves.items(), best, strict=True):
                damper = float(study.pto.damper(design) or 0.0) if tuning == "fixed" else float(damping)
                squares, load = DesignYear(one.port, self.climate).squares, one.port.load(damper, study.pto.stiffness)
                slopes.append(sensitivity(one.port.omega, one.moved, one.port, load, squares))
            of_power[:, j] = [sum(one.to(each) for each in errors) for one in slopes]
            if reference is not None:
                base = slopes[reference]
                of_ratio[:, j] = [
                    0.0 if one is base else sum((one - base).to(each) for each in errors) for one in slopes
                ]
        within = powers_within(power, error, of_power, left_out.power if left_out else None)
        if reference is None:
            return within
        return {**within, **gains_within(power, error, of_ratio, reference, left_out.gain if left_out else None)}
