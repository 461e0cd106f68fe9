"""Whether the pause of a body-exact run, refined near that of the linear scene, was looked for far enough."""

from vsb.hydro.database import Check, check_at_most
from vsb.results.run_checks import Attributes

NEAR_THE_END = 0.8
"""Of how far pauses were tried: beyond, one further off may take more."""


def pause_checks(runs: Attributes) -> list[Check]:
    """Return how far the best pause of each body-exact run is from that of its linear scene, over how far was tried."""
    checks = []
    for (design, wave), attrs in runs.items():
        if "linear_pause" not in attrs or not attrs["pause"]:
            continue
        pause, linear, tried = (attrs[key] for key in ("pause", "linear_pause", "pause_tried"))
        text = f"takes most with a pause of {pause:.3g} s on the wet shell, {linear:.3g} s in the linear scene, tried "
        text += f"{tried:.2g} s either side: one further off may take more"
        share = abs(pause - linear) / tried
        checks.append(check_at_most("pause", share, NEAR_THE_END, "-", text, doubt=True, design=design, wave=wave))
    return checks
