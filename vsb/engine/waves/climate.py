"""A site's climate: the spectra of all seas of a year and the share of the year of each.

Spectra are means over bands of frequency, as measured by buoys. Moments and energy flux are the sums over bands of
IEC TS 62600-101 and 62600-100.
"""

import re
from calendar import month_name, monthrange
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Self

import numpy as np

from vsb.engine.waves.records import impossible
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import Water, group_velocity
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray
from vsb.tools.words import LONGEST

YEAR_HOURS = 8766.0
"""Hours of a mean year, as in IEC TS 62600-100 [h]."""
OUTSIDE = 0.01
"""Part of a year's variance that may lie at frequencies without coefficients of a device."""
FAULTY = 0.01
"""Part of the records that may be physically impossible; with more the units are wrong."""
AGREEMENT = 0.02
"""Relative difference allowed between Hs and that of the spectrum: tables round, bands cut tails."""
PARTIAL, CUT, FEW = "stand for a year", "too much to be left out", "more than half of the records are not used"
"""Words of the notes on records of a part of the year only, on bands that end too early, and on faulty files."""
OVERSTATED = "if they are calm, the year holds less energy"
"""Words of the note on records without waves, where they are more than `FAULTY`."""
UNEVEN = 2 / 3
"""Records of a month over its days, relative to the month with most, below which seasons count unequally."""
UNSTATED = "which the file does not state"
"""Words of the notes on what a file was taken for."""
LOWEST_DENSITY, HIGHEST_DENSITY = 1e-30, 1e6
"""Range of densities in which numbers are spectra [m^2 s]: below it a record is still water."""
TINY = 1e-6
"""Period that is as good as none [s]."""
LARGEST_TAIL = 0.05
"""Share of the variance beyond the bands from which on a year is doubted."""


@dataclass(frozen=True, eq=False)  # compared by identity, so that results can be cached by climate
class Climate:
    """All seas of a site's year.

    Raises `ConfigError` if shapes, signs or shares are wrong, or heights and spectra contradict each other.
    """

    omega: FloatArray  # centres of the bands, ascending (omega,) [rad/s]
    density: FloatArray  # mean spectral density over each band (sea, omega) [m^2 s]
    hours: FloatArray  # share of the year each sea stands for (sea,), sums to 1 [-]
    hs: FloatArray  # significant wave height (sea,) [m]
    te: FloatArray  # energy period (sea,) [s]
    name: str
    notes: tuple[str, ...] = ()  # records left out, and limits of the data

    def __post_init__(self) -> None:
        """Check shapes, signs, shares, and that heights are those of the spectra."""
        seas = len(self.density)
        if self.density.shape != (seas, len(self.omega)) or len(self.omega) < 2 or not seas:
            raise ConfigError(
                f"climate {self.name}: received spectra of shape {self.density.shape} over {len(self.omega)} "
                "frequencies; needs at least one sea and two frequencies"
            )
        self._check("omega", self.omega, bool(np.all(np.diff(self.omega) > 0) and self.omega[0] > 0), "ascending, > 0")
        self._check("density", self.density, bool(np.all(self.density >= 0)), "no number below 0")
        self._check("hours", self.hours, bool(np.all(self.hours >= 0)), "no share below 0")
        self._check("hs", self.hs, bool(np.all(self.hs > 0)), "heights above 0")
        self._check("te", self.te, bool(np.all(self.te > 0)), "periods above 0")
        if len(self.hs) != seas or len(self.te) != seas or len(self.hours) != seas:
            raise ConfigError(f"climate {self.name}: received {seas} spectra, needs as many hours, hs and te")
        if abs(float(self.hours.sum()) - 1) > 1e-9:
            raise ConfigError(f"climate {self.name}: received shares that sum to {self.hours.sum():.6g}, needs 1")
        off = np.abs(4 * np.sqrt(self.variance) / self.hs - 1)
        if off.max() > AGREEMENT:
            at = int(off.argmax())
            raise ConfigError(
                f"climate {self.name}: received Hs {self.hs[at]:.4g} m of sea {at}, its spectrum holds "
                f"{4 * np.sqrt(self.variance[at]):.4g} m; needs both within {AGREEMENT:.0%}: more bands, or other units"
            )

    def _check(self, field: str, values: FloatArray, right: bool, needed: str) -> None:
        """Raise unless numbers are finite and right."""
        if not (right and np.all(np.isfinite(values))):
            worst = values[~np.isfinite(values)]
            received = float(worst[0]) if worst.size else float(values.min())
            raise ConfigError(f"climate {self.name}: received {field} with {received:.6g}, needs {needed}, all finite")

    @classmethod
    def of_spectra(
        cls, omega: FloatArray, density: FloatArray, hours: FloatArray, name: str, notes: Sequence[str] = ()
    ) -> Self:
        """Return the climate of spectra, with heights and periods from their moments."""
        hs, te = height_and_period(omega, density)
        return cls(omega, density, hours, hs, te, name, tuple(notes))

    @property
    def edges(self) -> FloatArray:
        """Edges of the bands, shape (omega + 1,) [rad/s]."""
        return band_edges(self.omega)

    @cached_property
    def variance(self) -> FloatArray:
        """m0 of each sea, shape (sea,) [m^2]."""
        return np.asarray(self.density @ np.diff(self.edges))

    def flux(self, water: Water) -> FloatArray:
        """Return the energy flux J = rho g sum v_g S dw of each sea per metre of crest, shape (sea,) [W/m]."""
        speed = np.array([group_velocity(w, water.depth, water.gravity) for w in self.omega])
        return np.asarray(water.density * water.gravity * (self.density @ (speed * np.diff(self.edges))))

    def means(self, water: Water) -> str:
        """Return mean height, mean energy period and mean energy flux of the year in words."""
        hs, te, flux = (float(self.hours @ one) for one in (self.hs, self.te, self.flux(water)))
        return f"mean Hs {hs:.3g} m, mean Te {te:.3g} s, {flux / 1000:.3g} kW/m"

    @cached_property
    def mean_density(self) -> FloatArray:
        """The mean spectrum of the year, shape (omega,) [m^2 s]."""
        return np.asarray(self.hours @ self.density)

    def variance_outside(self, lowest: float, highest: float) -> float:
        """Return the part of the year's variance below and above two frequencies [-], [rad/s]."""
        inside = np.diff(np.clip(self.edges, lowest, highest))
        return max(0.0, 1 - float(self.mean_density @ inside) / float(self.mean_density @ np.diff(self.edges)))

    def quantile(self, share: float) -> FloatArray:
        """Return the density that is not exceeded for a share of the year, by frequency, shape (omega,) [m^2 s]."""
        return np.asarray(np.quantile(self.density, share, axis=0, weights=self.hours, method="inverted_cdf"))


def realised(
    climate: Climate, sea: int, duration: float, seed: int, lowest: float = 0.0, highest: float = np.inf
) -> Sea:
    """Return a realisation of one sea that does not repeat within a run; see `vsb.engine.waves.seas.SpectralSea`.

    Parameters
    ----------
    duration : float [s]
    seed : int
        Of the phases; amplitudes are those of the spectrum.
    lowest, highest : float [rad/s]
        No component lies beyond them.
    """
    edges = climate.edges
    low, high = max(float(edges[0]), lowest), min(float(edges[-1]), highest)
    cuts = np.linspace(low, high, int(np.ceil((high - low) * 1.1 * duration / (2 * np.pi))) + 1)
    below = np.concatenate([[0.0], np.cumsum(climate.density[sea] * np.diff(edges))])
    amplitude = np.sqrt(2 * np.diff(np.interp(cuts, edges, below)))
    phase = np.random.default_rng(seed).uniform(0.0, 2 * np.pi, len(amplitude))
    kept = amplitude > 1e-12 * amplitude.max()
    return Sea(((cuts[1:] + cuts[:-1]) / 2)[kept], (amplitude * np.exp(1j * phase))[kept])


def band_edges(omega: FloatArray) -> FloatArray:
    """Return the edges of bands halfway between their centres, the outermost as wide inwards as outwards."""
    middle = (omega[1:] + omega[:-1]) / 2
    first, last = 2 * omega[0] - middle[0], 2 * omega[-1] - middle[-1]
    return np.concatenate([[max(first, 0.0)], middle, [last]])


def height_and_period(omega: FloatArray, density: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Hs = 4 sqrt(m0) [m] and Te = 2 pi m_-1/m_0 [s] of spectra, each shape (sea,).

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    density : ndarray, shape (sea, omega) [m^2 s]
        Each with some energy.
    """
    width = np.diff(band_edges(omega))
    m0, before = density @ width, density @ (width / omega)
    return 4 * np.sqrt(m0), 2 * np.pi * before / m0


def seasons(times: Sequence[datetime]) -> list[str]:
    """Return a note where records with waves at some instants, of equal shares, are no year; none where they are."""
    days, count = (max(times) - min(times)).total_seconds() / 86400, Counter(time.month for time in times)
    if days < 360 or len(count) < 12:
        covered = f"{days:.0f} days" if days < 360 else f"{len(count)} months"
        return [f"{covered} {PARTIAL}: seasons are missing"]
    dense = {month: number / monthrange(2001, month)[1] for month, number in count.items()}
    least, most = min(dense, key=dense.__getitem__), max(dense, key=dense.__getitem__)
    if dense[least] >= UNEVEN * dense[most]:
        return []
    share = f"{dense[least] / dense[most]:.0%} of the records a day of {month_name[most]}"
    return [f"{month_name[least]} has {share}, and they {PARTIAL}: seasons count unequally"]


def calm_note(what: str, calm: int, of: int) -> list[str]:
    """Return a note on records without waves, what they are, if there are any."""
    if not calm:
        return []
    words = f"{calm} {what} left out: calm or faulty, the file cannot tell"
    return [f"{words}; {OVERSTATED}" if calm > FAULTY * of else words]


def of_records(
    omega: FloatArray, density: FloatArray, source: str, notes: Sequence[str] = (), times: Sequence[datetime] = ()
) -> Climate:
    """Return the climate of measured records of equal shares; unusable ones are left out and counted.

    Raises `ConfigError` if no record is left, or more than `FAULTY` are physically impossible.

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    density : ndarray, shape (record, omega) [m^2 s]
        NaN for missing values; bands at the ends without any value are left out.
    source : str
        File name.
    times : sequence of datetime, optional
        Of the records: what is left of them must be of all seasons alike.
    """
    (measured,) = np.nonzero(~np.isnan(density).all(axis=0))
    first, last = (measured[0], measured[-1] + 1) if len(measured) > 1 else (0, len(omega))
    if last - first < len(omega):
        ends = [f"{w / 2 / np.pi:.4g}" for w in [*omega[:first], *omega[last:]]]
        notes = [*notes, f"bands at the ends without a value in any record left out: {', '.join(ends)} Hz"]
        omega, density = omega[first:last], density[:, first:last]
    if not (np.nan_to_num(density, nan=0.0) < HIGHEST_DENSITY).all():
        raise ConfigError(
            f"{source}: received a density of {np.nanmax(density):.4g} m^2 s, needs less than {HIGHEST_DENSITY:g}"
        )
    missing = np.isnan(density).any(axis=1)
    flat = ~missing & (np.ptp(density, axis=1) < LOWEST_DENSITY)
    kept = ~missing & ~flat
    if not kept.any():
        raise ConfigError(f"{source}: received {len(density)} records, none with a spectrum; needs at least one")
    found = [*notes, f"{len(density)} records, {int(missing.sum())} with missing values left out"]
    found += calm_note("records of one value throughout", int(flat.sum()), len(density))
    found += seasons([time for time, usable in zip(times, kept, strict=True) if usable]) if times else []
    spectra = density[kept]
    if (low := float(spectra.min())) < 0:
        raise ConfigError(f"{source}: received a spectral density of {low:.4g} m^2 s, needs 0 or more")
    hs, te = height_and_period(omega, spectra)
    wrong = impossible(hs, te)
    if wrong.mean() > FAULTY:
        at = int((hs / np.maximum(te, TINY) ** 2).argmax())
        raise ConfigError(
            f"{source}: received {wrong.mean():.1%} of records that are physically impossible, as Hs {hs[at]:.4g} m "
            f"with Te {te[at]:.4g} s; needs frequencies in Hz and densities in m^2/Hz"
        )
    if wrong.any():
        found.append(f"{int(wrong.sum())} physically impossible records left out")
    spectra, count = spectra[~wrong], int((~wrong).sum())
    begin, end = band_edges(omega)[[0, -1]]
    beyond = spectra[:, -1] * (omega[-1] / end) ** 5 * end / 4  # of a tail S ~ w^-5
    share = float(beyond.sum() / (spectra @ np.diff(band_edges(omega))).sum())
    tail = (
        f"bands from {begin / 2 / np.pi:.4g} to {end / 2 / np.pi:.4g} Hz: a tail falling with the fifth power of "
        f"frequency would add {share:.2%} to the variance, which is not counted"
    )
    found += [f"{count} spectra used", f"{tail}: {CUT}" if share > LARGEST_TAIL else tail]
    found += [f"{count} of {len(density)}: {FEW}"] if count < len(density) / 2 else []
    return Climate.of_spectra(omega, spectra, np.full(count, 1 / count), source, found)


def is_doubt(note: str) -> bool:
    """Return whether a note on a climate puts its year in doubt."""
    return any(words in note for words in (PARTIAL, CUT, FEW, UNSTATED, OVERSTATED))


def climate_line(note: str) -> str:
    """Return the line `vsb check` prints of a note on a climate."""
    return f"{'doubt        climate: ' if is_doubt(note) else 'climate      '}{note}"


HEIGHT = {
    "hs", "hm0", "hsig", "h13", "h1/3", "significantwaveheight", "significantheight", "waveheight", "swh", "vhm0",
    "wvht", "wavehs", "seasurfacewavesignificantheight",
}  # fmt: skip


PERIODS = {
    "te": {
        "te", "tm10", "tm-10", "tm-1,0", "tm-1.0", "t-10", "t-1,0", "energyperiod", "meanenergyperiod",
        "waveenergyperiod", "mwp", "vtm10", "t0m1",
        "seasurfacewavemeanperiodfromvariancespectraldensityinversefrequencymoment",
    },
    "t01": {
        "t01", "tm01", "t0,1", "tm0,1", "mp1", "vtm01",
        "seasurfacewavemeanperiodfromvariancespectraldensityfirstfrequencymoment",
    },
    "tz": {
        "tz", "t02", "tm02", "t0,2", "tm0,2", "zerocrossingperiod", "zeroupcrossingperiod", "meanzerocrossingperiod",
        "zeroupcrossingwaveperiod", "mp2", "vtm02", "apd", "wavetz", "seasurfacewavezeroupcrossingperiod",
        "seasurfacewavemeanperiodfromvariancespectraldensitysecondfrequencymoment",
    },
    "tp": {
        "tp", "peakperiod", "wavepeakperiod", "tpeak", "peakwaveperiod", "pp1d", "vtpk", "dpd", "wavetp",
        "seasurfacewaveperiodatvariancespectraldensitymaximum",
    },
}  # fmt: skip
"""Names of the energy period, of m_0/m_1, of the zero-crossing and the peak period; the first is the most certain.

Those of NDBC, CDIP, ERA5, Copernicus and the CF conventions among them.
"""


OCCURRENCE = {
    "occurrence", "occurrences", "percent", "percentage", "%", "hours", "h", "count", "counts", "frequency", "share",
    "probability", "n", "number", "hits", "occ", "freq",
}  # fmt: skip


def kind_of(name: str) -> str | None:
    """Return which quantity a name of a column is: hs, te, tp, tz, t01 or None."""
    plain = bare_name(name)
    return next((kind for kind, spelled in {"hs": HEIGHT, **PERIODS}.items() if plain in spelled), None)


def is_series(names: Iterable[str]) -> bool:
    """Return whether names of columns or variables are those of a series: a height and a period, no occurrence."""
    names = list(names)
    kinds = {kind_of(name) for name in names}
    counted = any(bare_name(name) in OCCURRENCE or name.strip(" ()[]").lower() in OCCURRENCE for name in names)
    return "hs" in kinds and bool(kinds & {*PERIODS}) and not counted


def bare_name(name: str) -> str:
    """A name without unit, case, blanks, underscores and arrows; long text as it is."""
    if len(name) > LONGEST:
        return name
    return re.sub(r"[\s_{}$:\u2190-\u2193]|[\[(].*?[\])]", "", name).lower()
