"""A site's mean power and the limits of a buoy with their derivatives by keys of its study."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from vsb.design.evaluation import DAMPER, DesignModel, Quantity
from vsb.engine.motion.take_off import port_kind
from vsb.engine.waves.climate import Climate
from vsb.errors import ConfigError
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import with_degree
from vsb.study.design import QUANTITIES, unit_of
from vsb.study.study import Study
from vsb.study.vary import unit

POWER, GAIN = "annual_mean_power", "gain_percent"


def gradient(
    study: Study,
    climate: Climate,
    variables: Sequence[str],
    uncertain: Mapping[str, float] | None = None,
    degree: int | None = None,
) -> xr.Dataset:
    """Return a site's mean power and what limits a buoy, of all designs, with exact derivatives by keys of the study.

    Parameters
    ----------
    study : Study
        A buoy that heaves; its waves are not used, nor its damper unless it is a variable.
    climate : Climate
        See `read_seas`.
    variables : sequence of str
        Keys, such as `device.radius`; `vsb.study.design.VARIABLES`, or `designs.NAME.clamp`.
    uncertain : mapping key -> float, optional
        Relative standard deviations of some of the variables; the others are known.
    degree : int, optional
        Highest Legendre degree of the shell's displacements; that of the study if not given, which may follow from its
        `modes.tolerance`.

    Returns
    -------
    xarray.Dataset
        For every quantity, such as `annual_mean_power(design)`, its derivatives
        `annual_mean_power_gradient(design, variable)` per unit of each variable and, with `uncertain`, its standard
        deviation `annual_mean_power_deviation(design)`; `gain_percent` if there is a rigid design. Coordinates
        `value(variable)` and `unit(variable)`. See `vsb.design.evaluation.DesignModel.at`.

    Raises
    ------
    ConfigError
        If the study has no such keys, or its year depends on more than axisymmetric motion.
    ConvergenceError
        If the shell buckles before it carries its load.
    StabilityError
        If a design is not stable at rest.
    """
    given = dict(uncertain or {})
    if unknown := [key for key in given if key not in variables]:
        raise ConfigError(f"uncertain: received {unknown[0]}; needs some of the variables, {', '.join(variables)}")
    if DAMPER in variables and not (isinstance(study.pto.damping, float) and study.pto.damping > 0):
        raise ConfigError(f"pto.damping: received {study.pto.damping}; needs one above 0, or not to be a variable")
    if study.flexible and degree is None and study.modes.degree is None:
        degree = with_degree(StudyPlan(study)).study.modes.max_degree
    model = DesignModel.of(study, next(iter(study.designs)), climate, variables, degree)
    models = {name: replace(model, design=name) for name in study.designs}
    found = {name: dict(model.at(model.point).quantities) for name, model in models.items()}
    if (reference := study.reference_design) is not None:
        power = found[reference][POWER]
        for quantities in found.values():
            quantities[GAIN] = quantities[POWER].gain(power)
    point = np.array(model.point)
    deviations = np.abs(point) * [given.get(key, 0.0) for key in variables]
    kind, names = port_kind(study.pto.port), list(next(iter(found.values())))
    data: dict[str, xr.Variable] = {}
    for name in names:
        each: list[Quantity] = [quantities[name] for quantities in found.values()]
        meaning, of = QUANTITIES[name].meaning, unit_of(name, kind)
        data[name] = xr.Variable("design", [one.value for one in each], {"units": of, "long_name": meaning})
        data[f"{name}_gradient"] = xr.Variable(
            ("design", "variable"),
            [one.gradient for one in each],
            {"units": f"{of} per unit of the variable", "long_name": f"derivatives of the {meaning}"},
        )
        if given:
            data[f"{name}_deviation"] = xr.Variable(
                "design",
                [one.deviation(deviations) for one in each],
                {"units": of, "long_name": f"standard deviation of the {meaning}, to first order"},
            )
    coords = {
        "design": list(found),
        "variable": list(variables),
        "value": ("variable", point),
        "unit": ("variable", [unit(key, kind) for key in variables]),
    }
    return xr.Dataset(data, coords)
