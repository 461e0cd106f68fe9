"""The shipped year with the seed's rigid buoy, enlarged."""

from pathlib import Path

import numpy as np
import pytest

from vsb.motion.port import Port
from vsb.results.year import frequencies, year
from vsb.scenes.rest import design_motions, study_basis
from vsb.study.study import Water
from vsb.waves.ndbc import read_ndbc

SPECTRA = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
SEAS = read_ndbc(SPECTRA)


@pytest.fixture(scope="module")
def rigid(seed, spectral_seed):
    """Function scale -> port of the seed's rigid buoy by Froude scaling."""
    motions = design_motions(seed, study_basis(seed), "FSB")
    heave = np.eye(len(motions))[0]

    def of(scale):
        root = np.sqrt(scale)
        first, last = spectral_seed.database.omega.values[[0, -1]]
        omega = frequencies(SEAS, first / root, last / root)
        port = spectral_seed.port(omega * root, motions, heave)
        return Port(omega, port.admittance / scale**2.5, port.velocity / root, port.compliance / scale**2)

    return of


@pytest.fixture(scope="module")
def found(rigid):
    """The year of a buoy three times as large at its optimal damping."""
    return year({"FSB": rigid(3)}, SEAS, Water(), ("one",))


def test_usual_practice_overestimates_the_year(found):
    """Spectra of standard shape at the centres of bins exceed the measured year by 10 to 15 % at this site."""
    assert 10 < 100 * (found.practice / found.annual_mean_power - 1)[0, 0] < 15


def test_product_of_matrices_is_the_hourly_sum(found):
    """The product of capture width and energy flux over the bins (IEC TS 62600-100), within 0.06 %."""
    flux = found.bins.mean(found.flux) * found.bins.share
    product = float(np.sum(found.bins.mean(found.power[0, 0] / found.flux) * flux))
    assert product == pytest.approx(found.annual_mean_power[0, 0], rel=6e-4)
