"""A database of heave and two modes, for all formats."""

import numpy as np
import pytest
from hydro.formats.test_exchange import PAIR, random_database, with_structure


@pytest.fixture
def elastic():
    """Heave and two modes with their structure, damping of a passive body."""
    ds = random_database(modes=2, frequencies=6, headings=2)
    factor = np.random.default_rng(3).normal(size=(6, 3, 3))
    return with_structure(
        ds.assign(radiation_damping=(("omega", *PAIR), factor @ factor.transpose(0, 2, 1))), 0.5, 1e-3
    )
