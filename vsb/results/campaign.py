"""Members of a campaign, and all of them together: one dimension for each varied key, and the same as a table."""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from vsb.engine.motion.coefficient_errors import CoefficientError, sensitivity
from vsb.engine.motion.port import Port, Ports
from vsb.engine.motion.take_off import Pto, named_ports, port_kind
from vsb.engine.motion.tuning import matrix_text
from vsb.engine.waves.climate import Climate
from vsb.models.floating_system import Floating, InWaves
from vsb.models.take_off import given_damper, matrix_kind
from vsb.models.viability import Viability, with_designs
from vsb.results.budget import LeftOut, left_out_of_year
from vsb.results.causal_year import causal_years
from vsb.results.year import (
    POWER_ENDS,
    DesignYear,
    Tuning,
    Values,
    Year,
    beyond_validity,
    bins_of,
    frequencies,
    limits_of,
    motion_rms,
    spring_squares,
    within_errors,
    year,
)
from vsb.study.campaign import (
    AT_FORCE,
    CONSTRAINED,
    GAIN_IN_TIME,
    IN_TIME,
    POWER_IN_TIME,
    Scatter,
    Tunings,
    leading_tuning,
)
from vsb.study.specs import CampaignSpec
from vsb.study.study import Study
from vsb.study.vary import MEMBER, PORT, unit
from vsb.tools.arrays import AnyArray, FloatArray
from vsb.tools.variables import PortKind
from vsb.tools.words import csv_text

BY = ("design", "tuning")
TABLE = (
    "viable", "margin", "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high",
    "force_rms", "practice_power", "quadrature_error", "energy_beyond_validity",
)  # fmt: skip
"""Variables of a table with a row for each point, design and tuning; dampers and reasons stand beside them."""
EFFICIENCY = "pto.efficiency"
TABLE_OF_SEAS = "cells of a table"
"""Attribute `seas` of years that usual practice computes like this one, at the centres of the table's own bins."""
OF_OPTIMA = ("power_bound", "impossible_share")
"""Variables only the tuning `constrained` has."""
VARIABLES = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "damping",
    "force_rms", "viable", "margin", "reason", "practice_power", "quadrature_error", "power_matrix", "power_deviation",
    "capture_width_matrix", "capture_width_deviation", "count", "tried_damping", "power_of_damping",
    "force_of_damping", "damper_matrix", "damper", "design", "tuning", "hs", "te", "energy_beyond", "limit",
    "energy_beyond_validity", "beyond_validity", "power_bound", "optimum_gap", "optimum_share", "optimum_excess",
    "impossible_share", "occurrence", "flux_matrix", "annual_mean_power_low", "annual_mean_power_high",
    *(f"{model}_{name}" for model in IN_TIME.values() for name in (*POWER_IN_TIME, *GAIN_IN_TIME)),
)  # fmt: skip
"""Names in the results that no varied key can have."""
POWER, GAIN = (tuple(f"corrected_{name}" for name in names) for names in (POWER_IN_TIME, GAIN_IN_TIME))
"""Powers and gains of a year corrected by runs in time (`vsb.results.verification`)."""


def stacked(members: Sequence[xr.Dataset], ids: Sequence[str]) -> xr.Dataset:
    """Return members along a dimension of their ids; how often seas of a bin occur is the same for all."""
    first = members[0]
    names = [name for name in first.data_vars if name not in SAME_FOR_ALL]
    values = {
        name: ((MEMBER, *first.variables[name].dims), np.stack([one.variables[name].values for one in members]))
        for name in names
    }
    same = {name: first[name] for name in SAME_FOR_ALL if name in first}
    return xr.Dataset({**values, **same}, coords={**first.coords, MEMBER: list(ids)})


def gathered(spec: CampaignSpec, batches: Iterable[xr.Dataset]) -> xr.Dataset:
    """Return the results of all members over the dimensions of what is varied.

    Parameters
    ----------
    batches : iterable of Dataset
        Each with the dimension `member`, whose coordinate holds ids; one after the other, for all are gigabytes.
    """
    names, kind = spec.vary.dimensions(VARIABLES), _port_kind(spec)
    coordinates = {
        name: (MEMBER if spec.vary.together else name, _values(values), {"units": unit(key, kind), "long_name": key})
        for (key, name), values in zip(names.items(), spec.vary.lists, strict=True)
    }
    attrs = {"varied": " ".join(names.values()), **_attrs(spec)}
    place, found = {one: i for i, one in enumerate(spec.members)}, dict[str, tuple[tuple[str, ...], AnyArray]]()
    for batch in batches:
        at, same = [place[str(one)] for one in batch[MEMBER].values], batch.drop_dims(MEMBER)
        for name, variable in batch.drop_vars(MEMBER).data_vars.items():
            if MEMBER not in variable.dims:
                continue
            dims, values = tuple(map(str, variable.dims[1:])), variable.values
            if name not in found:
                found[str(name)] = (dims, np.empty((len(place), *values.shape[1:]), values.dtype))
            found[str(name)][1][at] = values
    over, shape = ((MEMBER,), (len(place),)) if spec.vary.together and names else ((*names.values(),), spec.vary.shape)
    unfolded = {name: ((*over, *dims), one.reshape((*shape, *one.shape[1:]))) for name, (dims, one) in found.items()}
    return same.assign(unfolded).assign_coords(coordinates).assign_attrs(attrs)


def _attrs(spec: CampaignSpec) -> dict[str, str]:
    """Attributes of the file: names, reference design, conventions."""
    reference = Study.kind_of(spec.base).part({"designs": spec.base["designs"]}).reference_design
    names = {"campaign": spec.campaign, "study": spec.study, "climate": spec.climate_name}
    efficiency = spec.base["pto"].get("efficiency", 1.0)
    words = "as varied" if EFFICIENCY in spec.vary.keys else f"of {efficiency:g}" if efficiency < 1 else ""
    after = {"efficiency": words} if words else {}
    if isinstance(spec.climate, Scatter):
        after["seas"] = TABLE_OF_SEAS
    kind = _port_kind(spec).load
    return {**names, "reference": reference or "", "Conventions": "CF-1.8", "port_kind": kind, **after}


def _port_kind(spec: CampaignSpec) -> PortKind:
    """What the take-off acts with, the same at every point (`vsb.study.campaign`)."""
    return port_kind(spec.vary.values.get(PORT, (spec.base["pto"].get("port"),))[0])


def _values(values: Sequence[float | str]) -> AnyArray:
    """Values of a key as a coordinate."""
    return np.array(values, dtype=object if isinstance(values[0], str) else float)


def with_verification(spec: CampaignSpec, ds: xr.Dataset, runs: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the results of a campaign with those of runs in time, named by their model (`IN_TIME`).

    The statistical intervals of their powers and gains are wider by the errors of linear theory, whose ratio to runs
    they correct: coefficients, quadrature and shell modes left out are the same in both.

    Parameters
    ----------
    ds : Dataset
        See `gathered`.
    runs : sequence of Dataset
        See `vsb.results.verification`, in the order of the members; none of a campaign that verifies nothing. Where
        all failed, linear theory stands alone.
    """
    failures = sorted({one.attrs.get("failure", "") for one in runs} - {""})
    ds = ds.assign_attrs(failed_runs="\n".join(failures)) if failures else ds
    if all(one.attrs.get("failure") for one in runs):
        return ds
    model, tuning = runs[0].attrs["model"], leading_tuning(spec.tuning)
    names = {name: in_time(model, name) for name in (*POWER, *GAIN) if name in runs[0]}
    found = ds.assign({new: _of_members(ds, [one[name] for one in runs]) for name, new in names.items()})
    for end, own in zip(GAIN[1:], GAIN_IN_TIME[1:], strict=True):
        if end in names and own in ds:
            beyond = (ds[own] - ds.gain_percent).sel(tuning=tuning, drop=True)
            found[names[end]] = (found[names[end]] + beyond).transpose(*found[names[end]].dims)
    for end, own in zip(POWER[1:], POWER_ENDS, strict=True):
        if own not in ds:
            continue
        beyond = (ds[own] - ds.annual_mean_power).sel(tuning=tuning, drop=True)
        found[names[end]] = (found[names[end]] + beyond).transpose(*found[names[end]].dims)
    return found.assign_attrs(
        {
            **ds.attrs,
            "verification": f"tuning {tuning}: {runs[0].attrs['runs']}",
            "verified_tuning": tuning,
            "verified_model": model,
        }
    )


def in_time(model: str, name: str) -> str:
    """Return the name in a campaign of a result of runs in time, one of `POWER` and `GAIN`, by their model."""
    return name.replace("corrected", IN_TIME[model])


def _of_members(ds: xr.Dataset, values: Sequence[xr.DataArray]) -> tuple[tuple[str, ...], FloatArray]:
    """Values of members over the dimensions of what is varied."""
    stacked = np.stack([one.values for one in values])
    dims = (*map(str, ds.margin.dims), *map(str, values[0].dims))
    return dims, stacked.reshape((*ds.margin.shape, *stacked.shape[1:]))


def as_csv(spec: CampaignSpec, ds: xr.Dataset) -> str:
    """Return a row for each point, design and tuning; an empty cell is a result that does not exist (not viable)."""
    points = [str(dim) for dim in ds.margin.dims]
    verified = ds.tuning == ds.attrs.get("verified_tuning")
    damping = {"damper_matrix": _matrices(ds)} if "damper_matrix" in ds else {"damping": damper(ds)}
    columns = {name: ds[name] for name in TABLE if name in ds} | {**damping, "reason": ds.reason}
    if "verified_model" in ds.attrs:
        said = [in_time(ds.attrs["verified_model"], name) for name in (*POWER, *GAIN)]
        columns |= {name: ds[name].where(verified) for name in said if name in ds}
    columns |= {name: ds[name].where(ds.tuning == CONSTRAINED) for name in OF_OPTIMA if name in ds}
    columns |= {name: ds[name] for name in POWER_ENDS if name in ds}
    by = xr.zeros_like(ds.annual_mean_power, dtype=bool)
    cells = [each.broadcast_like(by).transpose(*points, *BY).values.ravel().tolist() for each in columns.values()]
    names = itertools.product(ds.design.values, ds.tuning.values)
    labels = ([*point.values(), *name] for point, name in itertools.product(spec.vary.points, list(names)))
    rows = zip(labels, zip(*cells, strict=True), strict=True)
    return csv_text([*spec.vary.values, *BY, *columns], (map(_cell, (*label, *row)) for label, row in rows))


def damper(ds: xr.Dataset) -> xr.DataArray:
    """Return the damper of every tuning that has one for all seas [N s/m]; NaN of the others."""
    occupied = ds["damping"].where((ds["count"] > 0) & ~ds.tuning.isin([*AT_FORCE, CONSTRAINED]))
    lowest, highest = occupied.min(("hs", "te")), occupied.max(("hs", "te"))
    return highest.where(highest - lowest <= 1e-9 * highest)


def _matrices(ds: xr.Dataset) -> xr.DataArray:
    """Damper matrices as text by point, design and tuning."""
    stacked = ds.damper_matrix.transpose(..., "port", "port_")
    flat = stacked.values.reshape(-1, *stacked.shape[-2:])
    texts = np.array([matrix_text(one, 12) for one in flat], dtype=object).reshape(stacked.shape[:-2])
    return xr.DataArray(texts, {name: ds[name] for name in BY}, stacked.dims[:-2])


def _cell(value: object) -> object:
    """A value as it stands in a table: whole digits, nothing for what is missing."""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.12g}"
    return value


# a member: the designs of one study over a site's year under every tuning, gains and their intervals ----------------

# A rigid design does not depend on material and thickness: members share its year, computed once.

Labels = dict[str, list[str]]
YearsWithin = Callable[[Study, Floating, Climate, LeftOut | None], xr.Dataset]
"""Study of viable designs, what floats in it, climate, shell modes left out -> their years within limits."""

BINS = ("hs", "te")
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
    limits, compared = limits_of(study.radius), study.reference_design is not None
    names = (*(named_ports(study.pto) or ("shell",)),) if study.pto.several else ()
    blank = _blank(tuple(study.designs), tuple(tunings), climate, limits, compared, names)
    found = {name: (dims, values.copy()) for name, (dims, values) in _variables(blank).items()}
    at: Labels = {"design": list(study.designs), "tuning": list(tunings)}
    if rest.designs:
        some = with_designs(study, rest.designs)
        system = floating()
        omega = frequencies(climate, *system.band)
        dampers = [one for one in tunings if one not in (*AT_FORCE, CONSTRAINED)]
        damped = DampedYears(climate, dampers, {} if known is None else known)
        here: Labels = {"design": list(some.designs), "tuning": [*damped.tunings]}
        left_out = left_out_of_year(some, system, climate)
        own = damped(some, system.at(omega).in_waves(), system.errors(omega), left_out)
        _fill(found, at, own, here)
        if at_force := [str(one) for one in tunings if one in AT_FORCE]:
            _fill(found, at, causal_years(some, system, climate, at_force, left_out), here | {"tuning": at_force})
        if optima:
            within = optima(some, system, climate, left_out)
            _fill(found, at, _variables(within), here | {"tuning": [CONSTRAINED]})
    words = {**rest.doubts, **rest.reasons}
    filled = {name: values for name, (_, values) in found.items()} | {
        "viable": np.array([design not in rest.reasons for design in study.designs]),
        "reason": np.array([words.get(design, "") for design in study.designs], dtype=object),
        "margin": np.array(rest.margin),
    }
    flux = bins_of(climate).mean(climate.flux(study.water))
    return blank.copy(data=filled).assign(flux_matrix=(BINS, flux))


def _variables(ds: xr.Dataset) -> Values:
    """Dimensions and values of the variables of a dataset."""
    return {str(name): (tuple(map(str, ds.variables[name].dims)), ds.variables[name].values) for name in ds.data_vars}


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


def ports_year(study: Study, ports: Mapping[str, Port | Ports], climate: Climate, tunings: Sequence[Tuning]) -> Year:
    """Return the year of the designs of a study from their ports, beside the take-off's spring."""
    given = {design: given_damper(study.pto, design, port.velocity.shape[1:]) for design, port in ports.items()}
    kind, reference = matrix_kind(study.pto), study.reference_design
    pto = study.pto
    return year(ports, climate, study.water, tunings, given, reference, pto.efficiency, kind, pto.stiffness)


@dataclass(frozen=True)
class DampedYears:
    """Years of designs under dampers, and their mean power over a damper that stays the same all year."""

    climate: Climate
    tunings: Sequence[Tuning]
    known: dict[bytes, Values] = field(default_factory=dict)  # of rigid designs of earlier members

    def __call__(
        self,
        study: Study,
        waves: Mapping[str, InWaves[Any]],
        errors: Sequence[CoefficientError] = (),
        left_out: LeftOut | None = None,
    ) -> Values:
        """Return the results of some designs of a study in waves, each shape (design, ...), and their gains.

        What of them is not known yet is computed together. Of damper matrices `damper_matrix(design, tuning, port,
        port_)` is the mean over the year; of a damper spread over the shell it is its one damper.

        Parameters
        ----------
        errors : sequence of CoefficientError, optional
            Of the coefficients in these waves, `Floating.errors`.
        left_out : LeftOut, optional
            Errors by shell modes left out.
        """
        keys = {name: self._key(study, name, waves[name]) for name in waves if not study.designs[name].flexible}
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

    def _key(self, study: Study, design: str, waves: InWaves[Any]) -> bytes:
        """All that the year of a rigid design depends on in one climate."""
        parts = (waves.port.velocity, waves.port.admittance, *waves.motion.heave, *waves.motion.shell)
        pto, water = study.pto, study.water  # which the energy flux and breaking depend on, the port does not
        given = given_damper(pto, design, waves.port.velocity.shape[1:])
        numbers = (pto.stiffness, pto.efficiency, study.radius or 0.0, water.density, water.depth, water.gravity)
        damper = np.asarray(0.0 if given is None else given)
        return b"".join(part.tobytes() for part in (*parts, damper, np.array(numbers))) + matrix_kind(pto).encode()

    def _computed(self, study: Study, waves: Mapping[str, InWaves[Any]]) -> Values:
        """Results of designs that are not known yet."""
        ports = {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}
        if not self.tunings:
            return {} if study.pto.several else self._curves(ports, None, study.pto)
        of = ports_year(study, ports, self.climate, self.tunings)

        def motions(design: str, tuning: str) -> dict[str, FloatArray]:
            dampers, chosen, _ = of.absorbed[design, tuning]
            return motion_rms(waves[design], self.climate, dampers, chosen, study.pto.stiffness)

        found = {**of.values, **beyond_validity(of, motions, study.radius)}
        if not study.pto.several:
            return {**found, **self._curves(ports, of, study.pto)}
        means = [[of.absorbed[one, t].mean_damper(self.climate.hours) for t in self.tunings] for one in of.designs]
        found[MATRIX] = (*BY, "port", "port_"), np.array(means)
        return found

    def _curves(self, ports: Mapping[str, Port], of: Year | None, pto: Pto) -> Values:
        """Mean power of the year and rms force of dampers that stay the same, each shape (design, damper)."""
        years = [DesignYear(port, self.climate, pto.efficiency) for port in ports.values()]
        if of and "one" in self.tunings:
            best = np.array([of.absorbed[design, "one"].dampers[0] for design in ports])
        else:
            best = DesignYear.best_for_year(years)
        tried = np.outer(best, TRIED)
        power = np.array([one.annual(dampers) for one, dampers in zip(years, tried, strict=True)])
        square = tried * power / pto.efficiency
        if pto.stiffness:
            pairs = zip(years, tried, strict=True)
            square += [spring_squares(one.port, dampers, pto.stiffness) @ one.squares for one, dampers in pairs]
        found = (tried, power, np.sqrt(square))
        return {name: (("design", "damper"), values) for name, values in zip(CURVES, found, strict=True)}

    def _intervals(
        self,
        study: Study,
        waves: Mapping[str, InWaves[Any]],
        found: Mapping[str, tuple[tuple[str, ...], AnyArray]],
        errors: Sequence[CoefficientError],
        left_out: LeftOut | None,
    ) -> Values:
        """Intervals of powers by all known errors, gains over the reference under the same tuning, and theirs.

        What errors of the coefficients do to powers and their ratio is taken at the given damper, else at the best one
        for the year, near which the best ones of most of its energy lie; of damper matrices at their mean.
        """
        reference = None if study.reference_design is None else list(waves).index(study.reference_design)
        power, error = (np.asarray(found[name][1], dtype=float) for name in ("annual_mean_power", "quadrature_error"))
        slopes = []
        for j, tuning in enumerate(self.tunings):
            own = []
            for i, (design, one) in enumerate(waves.items()):
                if study.pto.several:
                    damper = found[MATRIX][1][i, j]
                elif tuning == "fixed":
                    damper = study.pto.damper(design) or 0.0
                else:
                    damper = found[CURVES[0]][1][i, len(TRIED) // 2]
                squares = DesignYear(one.port, self.climate).squares
                own.append(sensitivity(one.moved, one.port, one.port.load(damper, study.pto.stiffness), squares))
            slopes.append(own)
        intervals = within_errors(power, error, [slopes], errors, reference, left_out)
        if study.pto.several and matrix_kind(study.pto) == "uniform":  # its one damper
            intervals[MATRIX] = found[MATRIX][0], found[MATRIX][1][..., :1, :1]
        return intervals
