"""Names of all figures of a study, a campaign and a design problem, and their files. Pure Python.

`vsb.report` draws them: `figures`, `campaign_page` and `design_page` find the function of a name.
"""

from collections.abc import Iterable

from vsb.engine.motion.take_off import port_kind
from vsb.study.resolution import no_witness
from vsb.study.specs import CampaignSpec, DesignSpec
from vsb.study.study import Study
from vsb.tools.variables import MEMBRANE, SEVERAL

FIGURE_KINDS = ("svg", "csv")
"""Files of every figure: for a page, and the data behind it."""
OF_THE_RESPONSE = ("absorbed_power", "reactance", "rao")
"""Figures of the frequency response, which does not depend on amplitude."""
OF_THE_WATER = ("added_mass_damping", "excitation", "radiation_kernel")
"""Figures of the coefficients, of buoys and of bodies."""
OF_A_SEA = ("heave_excitation", "velocity_pto", "power_energy", "energy_audit", "snapshots")
"""Figures of a buoy's runs, one for each sea."""
OF_THE_SHELL = ("extreme_shapes", "shapes_3d", "volume_area")
"""Further ones of flexible buoys."""
OF_A_BODY = ("port_motion", "degrees_of_freedom", "power_energy", "energy_audit")
"""Figures of a body's runs, one for each sea."""


def paths(folder: str, names: Iterable[str]) -> list[str]:
    """Return the paths of all files of some figures of the results in a folder."""
    return [f"{folder}/figures/{name}.{kind}" for name in names for kind in FIGURE_KINDS]


def of_study(study: Study) -> list[str]:
    """Return the names of the figures of a study."""
    if study.KIND == "body":
        spectra = ["spectra"] if study.has_spectra else []
        return [*OF_THE_RESPONSE, *OF_THE_WATER, *spectra, *_of_knowledge(study), *_in_seas(study, OF_A_BODY)]
    names = ["mode_shapes"]
    if study.needs_bem:
        names = [*OF_THE_RESPONSE, *names, *OF_THE_WATER]
    if study.pto.several:  # which have no one impedance
        names = [name for name in names if name != "reactance"]
    if study.has_spectra:
        names.append("spectra")
    if not no_witness(study):
        names.append("witness")
    per_wave: tuple[str, ...] = (*OF_A_SEA, *(OF_THE_SHELL if study.flexible else ()))
    names += _of_knowledge(study)
    if study.motion != "heave":  # in which no meridian stands for all of a shell
        per_wave = ("directions", *(name for name in per_wave if name != "shapes_3d"))
    return [*names, *_in_seas(study, per_wave)]


def _of_knowledge(study: Study) -> list[str]:
    """Names of figures of causal control, of each irregular sea; with one port, and without drag."""
    if not study.needs_bem or study.pto.several or study.plates:
        return []
    return [f"forecast-{wave.label}" for wave in study.drawn_waves if wave.irregular]


def _in_seas(study: Study, names: Iterable[str]) -> list[str]:
    """Names of figures that there are of each sea."""
    kinds = tuple(names)
    return [f"{name}-{wave.label}" for wave in study.drawn_waves for name in kinds]


def of_campaign(spec: CampaignSpec) -> list[str]:
    """Return the names of the figures of a campaign: one over what is varied, if anything is; over dampers, if free.

    A damper matrix is no axis.
    """
    varied = any(len(values) > 1 for values in spec.vary.values.values())
    switching = {"law", "force_limit", "stroke_limit"}
    names = [*(["sweep"] if varied else []), "spectra", "power_matrices"]
    if port_kind(spec.base["pto"].get("port")) in (SEVERAL, MEMBRANE):
        return names
    free = not switching & {*spec.base["pto"], *(key.removeprefix("pto.") for key in spec.vary.keys)}
    return [*names, *(["tuned_power"] if free else []), "pareto"]


def of_design(spec: DesignSpec) -> list[str]:
    """Return the names of the figures of a design problem."""
    return ["best_shapes", "starts", *(f"pareto_{limit}" for limit in spec.pareto), "sensitivity", "budget"]
