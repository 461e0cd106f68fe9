"""Shell modes of a study, and meshes to look at."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vsb.engine.hydro.panels.mesh import display_shapes, write_wet_shell
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.meridian import ClosedMeridian, curve
from vsb.engine.shell.modes import Mode
from vsb.engine.shell.orders import OrderBasis
from vsb.keys.quantities import content_id
from vsb.models.rest import check_stable, order_bases, reference_shell
from vsb.stages.stage import stamp
from vsb.study.specs import DisplaySpec, ModesSpec
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import save
from vsb.tools.stamps import record

COLATITUDES = np.linspace(0.0, np.pi, 181)
REST = ("rest_radial", "rest_meridional")
"""Variables that lead from the sphere to another shape at rest, where there is one."""
ORDER = "order"
"""Azimuthal order of a mode; a study of heave alone has none but 0, and does not say so."""


def run_modes(spec: ModesSpec, out: str) -> None:
    """Write the shell modes of a study, after checking that every design has motions left."""
    reference = reference_shell(spec)
    check_stable(spec, reference)
    save(shell_modes(spec, reference).assign_attrs(basis=spec.modes.basis, **stamp(spec)), out)


def shell_modes(study: Study | ModesSpec, reference: ReferenceShell) -> xr.Dataset:
    """Return shapes, degrees, dry frequencies and amplitudes at rest of the shell modes, in the plane of the waves."""
    orders = [basis for basis in order_bases(study, reference.basis) if not basis.odd]  # the odd ones are these, turned
    parts = [_axisymmetric(reference), *map(_of_order, orders)]
    modes = xr.concat(parts, "mode") if orders else parts[0].drop_vars(ORDER)
    if (rest := reference.basis.shell.rest) is not None:
        modes = modes.assign(dict(zip(REST, _beyond_sphere(rest, study.device.radius), strict=True)))
    height = study.centre_height + reference.modal_amplitude[0]
    return modes.assign_attrs(radius=study.device.radius, centre_height=height)


def _beyond_sphere(rest: ClosedMeridian, radius: float) -> tuple[tuple[str, FloatArray], tuple[str, FloatArray]]:
    """What leads from the sphere to another meridian at rest, along e_r and e_phi [m]."""
    at, sin, cos = curve(rest, COLATITUDES), np.sin(COLATITUDES), np.cos(COLATITUDES)
    return ("colatitude", at.x * sin + at.z * cos - radius), ("colatitude", at.x * cos - at.z * sin)


def _axisymmetric(reference: ReferenceShell) -> xr.Dataset:
    """Shell modes of order 0."""
    basis = reference.basis
    radial, meridional = basis.displacement(COLATITUDES)
    return _shapes(basis.modes, 0, radial[1:], meridional[1:], basis.dry_frequencies, reference.modal_amplitude[1:])


def _of_order(basis: OrderBasis) -> xr.Dataset:
    """Shell modes of an order m >= 1, in the plane of the waves."""
    radial, meridional, _ = (part[basis.rigid :] for part in basis.field(COLATITUDES))
    return _shapes(basis.modes, basis.order, radial, meridional, basis.dry_frequencies, np.zeros(len(basis.modes)))


def _shapes(
    modes: Sequence[Mode], order: int, radial: FloatArray, meridional: FloatArray, dry: FloatArray, static: FloatArray
) -> xr.Dataset:
    """Shapes of the modes of an order along the meridian theta = 0."""
    return xr.Dataset(
        {
            "radial": (("mode", "colatitude"), radial),
            "meridional": (("mode", "colatitude"), meridional),
            "degree": ("mode", [mode.degree for mode in modes]),
            ORDER: ("mode", np.full(len(modes), order)),
            "dry_frequency": ("mode", dry),
            "static_amplitude": ("mode", static),
        },
        coords={"mode": np.array([mode.label for mode in modes], dtype=str), "colatitude": COLATITUDES},
    )


def run_display(spec: DisplaySpec, out: str, manifest: str) -> None:
    """Write the mean wetted shell, and one deformed shell per mode and sign, into a folder."""
    shapes = display_shapes(reference_shell(spec).shape)
    for name, shape in shapes.items():
        write_wet_shell(shape, f"{out}/{name}.vtu")
    record(manifest, content_id(spec), [f"{out}/{name}.vtu" for name in shapes])
