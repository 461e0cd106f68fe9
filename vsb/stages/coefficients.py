"""Rules green, bem and spectral: hydrodynamic coefficients of one block of frequencies."""

import time as clock
from typing import Any

from vsb.hydro.dofs import displacements
from vsb.hydro.spectral import solver as spectral
from vsb.hydro.spectral import sweep as spectralsweep
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import rigid_sphere
from vsb.stages.meshes import mean_mesh
from vsb.stages.stage import partial_study
from vsb.study.study import canonical, content_id
from vsb.tools.files import load, save, write_text

Spec = dict[str, Any]


def green(folder: str, out: str) -> None:
    """Compute and store the Green-function table, once for all jobs."""
    from vsb.hydro.panels import rings as bem

    begun = clock.perf_counter()
    bem.stored_green_function(folder)
    write_text(out, f"{clock.perf_counter() - begun:.1f} s\n")


def bem_block(spec: Spec, mesh_path: str, green_folder: str, out: str) -> None:
    """Solve one block of frequencies, on the mesh and on a coarser one for the error."""
    from vsb.hydro.panels import sweep as panelsweep

    begun = clock.perf_counter()
    meshes = load(mesh_path), mean_mesh(spec["mesh"], coarser=2)
    solved = panelsweep.solve_block(spec, *meshes, green_folder)
    attrs = {"spec": canonical(spec), "spec_id": content_id(spec), "seconds": clock.perf_counter() - begun}
    save(solved.assign_attrs(solved.attrs | attrs), out)


def spectral_block(spec: Spec, out: str) -> None:
    """Solve one block of frequencies without panels, as finely as the tolerance needs."""
    begun = clock.perf_counter()
    problem = spectral_problem(spec)
    if "interpolation" in spec:
        solved = spectralsweep.converged_on_grid(problem, spec["omega"], spec["tolerance"], spec["interpolation"])
    else:
        solved = spectralsweep.converged(problem, spec["omega"], spec["tolerance"])
    attrs = {"spec": canonical(spec), "spec_id": content_id(spec), "seconds": clock.perf_counter() - begun}
    save(solved.assign_attrs(attrs), out)


def spectral_problem(spec: Spec) -> spectral.SpectralProblem:
    """Return the problem of a block: the shape at rest and its displacements."""
    shape, water = spec["shape"], spec["water"]
    if shape.get("reference_shape") == "equilibrium":
        shell = reference_shell(partial_study(shape)).shape
    else:
        shell = rigid_sphere(shape["radius"], shape["centre_height"])
    return spectral.SpectralProblem(
        shell,
        displacements(spec["displacements"]),
        water["density"],
        water["gravity"],
        spectralsweep.FEWEST_NODES,
        depth=float(water["depth"]),
    )
