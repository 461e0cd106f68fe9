"""Rule display: viewable meshes."""

from vsb.hydro.panels.mesh import display_shapes, write_wet_shell
from vsb.scenes.rest import reference_shell
from vsb.study.specs import DisplaySpec
from vsb.study.study import content_id
from vsb.tools.stamps import record


def run(spec: DisplaySpec, out: str, manifest: str) -> None:
    """Write the mean wetted shell, and one deformed shell per mode and sign, into a folder."""
    shapes = display_shapes(reference_shell(spec).shape)
    for name, shape in shapes.items():
        write_wet_shell(shape, f"{out}/{name}.vtu")
    record(manifest, content_id(spec), [f"{out}/{name}.vtu" for name in shapes])
