"""Short-crested seas: directions of equal energy, what they do to a port, the long-crested limit, refusals."""

import numpy as np
import pytest
from conftest import SEED
from scipy.special import betaincinv

from vsb.engine.hydro.orders import Directions, heading_shares
from vsb.engine.waves.kinds import Jonswap
from vsb.engine.waves.seas import Spreading
from vsb.errors import ConfigError
from vsb.keys.reading import validated
from vsb.models.floating_system import heading_in
from vsb.study.body import BodyStudy
from vsb.study.study import load, parse

PLANAR = {"motion": "planar", "mooring": [2e4, 0, 0, 0, 0, 0], "modes": {"basis": "membrane", "degree": 2}}


def spread(s, directions=9, **keys):
    return Jonswap(kind="jonswap", hs=1.0, tp=5.0, spreading={"s": s, "directions": directions}, **keys)


@pytest.mark.parametrize(("s", "count"), [(1.0, 9), (10.0, 9), (75.5, 4), (1e4, 15)])
def test_directions_have_equal_energy(s, count):
    """sin^2 of a quarter turn and half the angle is Beta(s + 1/2, s + 1/2)-distributed for cos^2s(angle/2)."""
    shares = (np.arange(count) + 0.5) / count
    exact = 2 * np.degrees(np.arcsin(2 * betaincinv(s + 0.5, s + 0.5, shares) - 1))
    assert np.array(Spreading(s=s, directions=count).angles) == pytest.approx(exact, abs=2e-4 * abs(exact).max())


def test_energy_is_that_of_the_long_crested_sea_and_shared_by_the_directions():
    """Amplitudes and phases do not change; each direction has a ninth of the energy of any part of the spectrum."""
    long, short = (wave.realisation(6.0, 1200.0) for wave in (Jonswap(kind="jonswap", hs=1.0, tp=5.0), spread(10.0)))
    assert long.heading is None
    assert np.array_equal(long.amplitude, short.amplitude)
    squares = np.abs(short.amplitude) ** 2
    for low, high, within in ((0.0, 6.0, 0.01), (1.1, 1.4, 0.03)):
        inside = (short.omega >= low) & (short.omega < high)
        shares = [squares[inside & (short.heading == one)].sum() for one in np.unique(short.heading)]
        assert len(shares) == 9
        assert np.array(shares) / sum(shares) == pytest.approx(np.full(9, 1 / 9), abs=within)
    again, other = spread(10.0).realisation(6.0, 1200.0), spread(10.0, seed=2).realisation(6.0, 1200.0)
    assert np.array_equal(short.heading, again.heading)
    assert not np.array_equal(short.heading, other.heading)


def test_mean_direction_and_order_are_those_of_cos_2s():
    """int cos(angle) D = s/(s + 1), int cos(2 angle) D = s (s - 1)/((s + 1)(s + 2)); many directions."""
    s, angles = 6.0, np.radians(Spreading(s=6.0, directions=36).angles)
    assert np.mean(np.cos(angles)) == pytest.approx(s / (s + 1), rel=5e-3)
    assert np.mean(np.cos(2 * angles)) == pytest.approx(s * (s - 1) / ((s + 1) * (s + 2)), rel=2e-2)
    assert np.mean(np.sin(angles)) == pytest.approx(0.0, abs=1e-12)


def test_excitation_of_every_component_is_that_of_its_direction():
    sea = spread(4.0, direction=20.0).realisation(6.0, 300.0)
    going = heading_in(spread(4.0, direction=20.0), sea)
    orders = np.array([0, 1, -1, 2])
    found = going.shares(orders, sea.omega)
    assert isinstance(going, Directions)
    for k in (0, 17, len(sea.omega) - 1):
        assert found[k] == pytest.approx(heading_shares(orders, np.radians(sea.heading[k])))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motion": "heave", "mooring": None}, "spreading: a buoy of revolution that heaves answers"),
        ({"drag": {"surge": {"coefficient": 1.0, "area": 1.0}}}, "spreading: drag is past the flow of waves of one"),
    ],
)
def test_spreading_is_refused_where_it_says_nothing_or_is_not_known(changes, message):
    raw = load(SEED).model_dump() | PLANAR | {"waves": [spread(10.0).model_dump()]} | changes
    raw["device"] |= {"centre_of_mass": -0.6, "ballast_inertia": 9e3}
    raw["hydro"] |= {"omega_max": 6.0, "witness": "none"}
    with pytest.raises(ConfigError, match=message):
        parse(raw)


def test_a_sea_without_spreading_is_written_as_before():
    wave = Jonswap(kind="jonswap", hs=1.0, tp=5.0)
    assert "spreading" not in wave.model_dump()
    assert (wave.label, spread(10.0).label) == ("jonswap_Hs1_Tp5_g3.3_s1", "jonswap_Hs1_Tp5_g3.3_s10x9_s1")


def test_bodies_know_the_directions_of_their_database_alone():
    raw = {"study": "b", "body": {"database": "b.nc"}, "designs": {"one": {}}, "waves": [spread(10.0).model_dump()]}
    with pytest.raises(ConfigError, match=r"waves\.0\.spreading: the database of a body holds the directions"):
        validated(BodyStudy, raw, "b.yaml")
