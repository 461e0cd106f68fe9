"""Command shape-dependence: shape database, figure, and one line."""

import itertools
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import xarray as xr

from vsb import __version__
from vsb.errors import DatabaseError
from vsb.keys.quantities import content_id
from vsb.models.rest import reference_shell
from vsb.models.shape_dependence import answer, shape_dataset, shapes_of_study, study_family
from vsb.report.canvas import svg_text
from vsb.report.hydro_figures import shape_figure
from vsb.study.study import Study
from vsb.tools.files import load, save, write_text


def counter(total: int) -> Callable[[], None]:
    """Return what to call after each of `total` shapes: it counts them on a terminal, and nowhere else."""
    done = itertools.count(1)

    def show() -> None:
        if sys.stderr.isatty():
            n = next(done)
            print(f"\rshape {n} of {total}", end="\n" if n == total else "", file=sys.stderr, flush=True)

    return show


def shape_dependence(study: Study, out_nc: str, out_figure: str) -> str:
    """Write the shape dependence of a study as netCDF and its figure as SVG; return `answer`.

    Shapes solved wait in a folder beside the netCDF file until it is complete: a run interrupted goes on from there.
    """
    identity = content_id([study, __version__])
    try:  # of an earlier run of the same study
        ds = load(out_nc)
    except DatabaseError:
        ds = xr.Dataset()
    if ds.attrs.get("spec_id") != identity:
        store = Path(out_nc).with_suffix(".shapes")
        family = replace(study_family(study, reference_shell(study)), store=store)
        ds = shape_dataset(study, replace(family, after_each=counter(shapes_of_study(study, family))))
        save(ds.assign_attrs(spec_id=identity, reference=study.reference_design or ""), out_nc)
        shutil.rmtree(store)
    write_text(out_figure, svg_text(shape_figure(ds)))
    return answer(ds, study.study)
