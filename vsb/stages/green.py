"""Rule green: the Green-function table of panels, once for all jobs."""

import time as clock

from vsb.hydro.panels.rings import stored_green_function
from vsb.tools.files import write_text


def run(folder: str, out: str) -> None:
    """Compute and store the Green-function table, and say how long it took."""
    begun = clock.perf_counter()
    stored_green_function(folder)
    write_text(out, f"{clock.perf_counter() - begun:.1f} s\n")
