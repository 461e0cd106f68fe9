"""Whether a pause found in a linear scene suits the run it is used in."""

from collections.abc import Sequence

from vsb.hydro.database import Check, check_at_most
from vsb.results.agreement import Attributes
from vsb.results.comparison import Row
from vsb.tools.words import plain


def pause_checks(runs: Attributes, rows: Sequence[Row]) -> list[Check]:
    """Return how far a body-exact run is from what its pause takes in the linear scene that the pause was found in."""
    checks = []
    for row in rows:
        attrs, where = runs[row["design"], row["wave"]], {"design": row["design"], "wave": row["wave"]}
        if attrs.get("model") != "body_exact" or not attrs.get("pause_power"):
            continue
        mean, linear = row["power_mean"], attrs["pause_power"]
        text = f"mean power is {plain(mean)} W body-exact, {plain(linear)} W in the linear scene its pause of "
        text += f"{attrs['pause']:.3g} s was found in: another may suit the wet shell better"
        checks.append(check_at_most("pause", abs(mean / linear - 1), 0.05, "-", text, doubt=True, **where))
    return checks
