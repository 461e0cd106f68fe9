"""First-order uncertainty: what inputs that are known to within a standard deviation leave open in a result."""

from collections.abc import Sequence

import numpy as np

from vsb.design.evaluation import Quantity


def relative_gain(quantity: Quantity, reference: Quantity) -> Quantity:
    """Return the gain of a quantity over that of a reference by the same variables [%]."""
    ratio = quantity.value / reference.value
    return Quantity(100 * (ratio - 1), 100 * (quantity.gradient - ratio * reference.gradient) / reference.value)


def standard_deviation(quantity: Quantity, deviations: Sequence[float]) -> float:
    """Return the standard deviation of a quantity by those of its variables, which are independent of each other.

    sqrt(sum (dq/dx s)^2): right as long as the quantity is nearly linear within the deviations.
    """
    return float(np.linalg.norm(quantity.gradient * np.asarray(deviations, dtype=float)))
