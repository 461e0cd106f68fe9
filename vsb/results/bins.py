"""Matrices of IEC TS 62600-100: what many seas have in common, by bins of 0.5 m of Hs and 1 s of Te."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from vsb.tools.arrays import FloatArray, IntArray
from vsb.waves.climate import Climate

HEIGHT = 0.5
"""Width of bins of significant wave height [m]."""
PERIOD = 1.0
"""Width of bins of energy period [s]."""


@dataclass(frozen=True)
class Bins:
    """Half-open bins of seas: [0.5 i, 0.5 (i + 1)) m of Hs, [j, j + 1) s of Te, from 0 to the highest occupied."""

    hs: FloatArray  # (sea,) [m]
    te: FloatArray  # (sea,) [s]
    hours: FloatArray  # share of the year of each sea (sea,) [-]

    @cached_property
    def _at(self) -> tuple[IntArray, IntArray]:
        """Row and column of each sea."""
        return np.floor(self.hs / HEIGHT).astype(np.intp), np.floor(self.te / PERIOD).astype(np.intp)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Number of bins of height and of period."""
        return int(self._at[0].max()) + 1, int(self._at[1].max()) + 1

    @cached_property
    def index(self) -> IntArray:
        """Bin of each sea, rows one after the other, shape (sea,)."""
        return np.asarray(self._at[0] * self.shape[1] + self._at[1])

    @property
    def hs_centres(self) -> FloatArray:
        """Centres of the bins of height, shape (hs,) [m]."""
        return np.asarray(HEIGHT * (np.arange(self.shape[0]) + 0.5))

    @property
    def te_centres(self) -> FloatArray:
        """Centres of the bins of period, shape (te,) [s]."""
        return np.asarray(PERIOD * (np.arange(self.shape[1]) + 0.5))

    @cached_property
    def count(self) -> IntArray:
        """Number of seas, shape (hs, te)."""
        return np.asarray(np.bincount(self.index, minlength=self.shape[0] * self.shape[1]).reshape(self.shape))

    @cached_property
    def share(self) -> FloatArray:
        """Share of the year, shape (hs, te) [-]."""
        return self.total(self.hours)

    @cached_property
    def occupied(self) -> IntArray:
        """Bins that hold seas, as `index`, ascending, shape (bin,)."""
        return np.asarray(np.flatnonzero(self.count))

    @property
    def centres(self) -> tuple[FloatArray, FloatArray]:
        """Hs and Te at the centres of the occupied bins, each shape (bin,)."""
        row, column = np.unravel_index(self.occupied, self.shape)
        return self.hs_centres[row], self.te_centres[column]

    def total(self, values: FloatArray) -> FloatArray:
        """Return sums over the seas of each bin, shape (hs, te), of values, shape (sea,)."""
        size = self.shape[0] * self.shape[1]
        return np.asarray(np.bincount(self.index, values, minlength=size).reshape(self.shape))

    def mean(self, values: FloatArray) -> FloatArray:
        """Return means over the seas of each bin, weighted by their hours, shape (hs, te); 0 where there are none."""
        return np.divide(self.total(self.hours * values), self.share, out=np.zeros(self.shape), where=self.share > 0)

    def deviation(self, values: FloatArray) -> FloatArray:
        """Return standard deviations within each bin, weighted by hours, shape (hs, te); 0 where there are none.

        Notes
        -----
        Of the bin's own seas, N below the line: Formula D.5 of Edition 2.
        """
        return np.sqrt(self.mean((values - self.mean(values).ravel()[self.index]) ** 2))


@lru_cache(maxsize=4)
def bins_of(climate: Climate) -> Bins:
    """Return the bins of the seas of a climate: all designs and members over it share them."""
    return Bins(climate.hs, climate.te, climate.hours)
