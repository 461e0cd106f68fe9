"""Rule modes: the shell modes of a study."""

import numpy as np
import xarray as xr

from vsb.scenes.rest import check_stable, reference_shell
from vsb.stages.stage import stamp
from vsb.study.specs import ModesSpec
from vsb.tools.files import save

COLATITUDES = np.linspace(0.0, np.pi, 181)


def run(spec: ModesSpec, out: str) -> None:
    """Write the shell modes of a study, after checking that every design has motions left."""
    reference = reference_shell(spec)
    check_stable(spec, reference)
    basis = reference.basis
    radial, meridional = basis.displacement(COLATITUDES)
    modes = xr.Dataset(
        {
            "radial": (("mode", "colatitude"), radial[1:]),
            "meridional": (("mode", "colatitude"), meridional[1:]),
            "degree": ("mode", list(basis.degrees[1:])),
            "dry_frequency": ("mode", basis.dry_frequencies),
            "static_amplitude": ("mode", reference.modal_amplitude[1:]),
        },
        coords={"mode": list(basis.labels[1:]), "colatitude": COLATITUDES},
        attrs={
            "radius": spec.device.radius,
            "centre_height": spec.centre_height + reference.modal_amplitude[0],
            "basis": spec.modes.basis,
            **stamp(spec),
        },
    )
    save(modes, out)
