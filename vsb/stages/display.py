"""Rule display: viewable meshes."""

from vsb.hydro.panels.mesh import display_shapes, write_wet_shell
from vsb.scenes.rest import reference_shell
from vsb.stages.stage import partial_study
from vsb.study.specs import DisplaySpec


def run(spec: DisplaySpec, out: str) -> None:
    """Write the mean wetted shell, and one deformed shell per mode and sign, into a folder."""
    for name, shape in display_shapes(reference_shell(partial_study(spec)).shape).items():
        write_wet_shell(shape, f"{out}/{name}.vtu")
