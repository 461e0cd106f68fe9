"""A member of a campaign: the year of its ports, its designs in their places, missing values where nothing rests."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from results.test_year import climate
from scenes.test_ports import water

from vsb.results.bins import bins_of
from vsb.results.damped_years import BY, CURVES, TRIED
from vsb.results.member import BINS, MATRICES, OF_DESIGNS, OF_LIMITS, TOLD, _blank, member
from vsb.results.validity import LIMITS
from vsb.results.year import year
from vsb.scenes.ports import ShapeWater, design_ports
from vsb.scenes.rest import reference_shell
from vsb.scenes.viability import with_designs
from vsb.study.study import Study
from vsb.study.year_options import CONSTRAINED
from vsb.waves.climate import Climate

TUNINGS = ("fixed", "one", "each")
BETWEEN = -0.95
"""Of the waterplane's stiffness: a spring against which a rigid and a held shell rest, free ones do not."""


@pytest.fixture(scope="module")
def study(seed) -> Study:
    return varied(seed, modes={"degree": 2}, pto={"damping": 8e3})


@pytest.fixture(scope="module")
def shared(study) -> ShapeWater:
    """Coefficients of the shape over all frequencies of the year."""
    return water(study, omega=np.arange(0.1, 3.0, 0.01))


@pytest.fixture(scope="module")
def seas() -> Climate:
    return climate(seas=12)


@pytest.fixture(scope="module")
def found(study, shared, seas):
    return member(study, lambda basis: shared, seas, TUNINGS)


def unstable(study) -> Study:
    """The study with a spring that takes its softest designs, second and third, out of balance."""
    waterplane = study.water.density * study.water.gravity * np.pi * study.device.radius**2
    return varied(study, pto={"stiffness": BETWEEN * waterplane})


def test_a_member_is_the_year_of_its_ports(study, shared, seas, found):
    ports = design_ports(study, reference_shell(study), shared)
    apart = year(ports, seas, study.water, TUNINGS, dict.fromkeys(ports, 8e3), "FSB").dataset()
    for name in ("annual_mean_power", "force_rms", "gain_percent", "power_matrix", "damping"):
        np.testing.assert_array_equal(found[name].values, apart[name].values, err_msg=name)
    assert found.viable.values.all()
    assert [text.partition(":")[0] for text in found.reason.values] == ["", *["doubtful"] * 3]  # 8 % strain at rest
    assert found["count"].sum() == 12


def test_every_design_stands_in_its_place(study, shared, seas, found):
    """In another order, and one alone, a design takes what it took."""
    turned = member(with_designs(study, list(study.designs)[::-1]), lambda basis: shared, seas, TUNINGS)
    assert turned.design.values.tolist() == found.design.values.tolist()[::-1]
    for name in (*OF_DESIGNS, *CURVES, *MATRICES):
        np.testing.assert_allclose(turned[name].sel(design=found.design), found[name], rtol=1e-12, err_msg=name)


def test_power_over_the_damper_is_flat_at_the_best_one(found):
    """Its curve passes through the year's best, falls to either side, and c times the mean of V^2 is its power."""
    one = found.sel(tuning="one")
    best = TRIED.size // 2
    np.testing.assert_allclose(found.power_of_damping[:, best], one.annual_mean_power, rtol=1e-12)
    np.testing.assert_allclose(found.force_of_damping[:, best], one.force_rms, rtol=1e-9)
    assert bool((found.power_of_damping.argmax("damper") == best).all())
    ratio = found.tried_damping.values / found.tried_damping.values[:, [best]]
    np.testing.assert_allclose(ratio, np.tile(TRIED, (4, 1)), rtol=1e-12)


def test_the_interval_of_a_gain_holds_both_designs_errors(study, found):
    """Those of quadrature at least; the reference gains nothing over itself, for sure."""
    error = found.quadrature_error / found.annual_mean_power
    for design in study.designs:
        one, reference = found.sel(design=design), found.sel(design="FSB")
        least = (error.sel(design=design) + error.sel(design="FSB")) * (100 + one.gain_percent)
        width = one.gain_high - one.gain_percent
        assert bool((width == 0.0).all() if design == "FSB" else (width > least).all())
        assert bool((one.gain_percent - one.gain_low >= least).all() or design == "FSB")
        ratio = one.annual_mean_power / reference.annual_mean_power
        np.testing.assert_allclose(one.gain_percent, 100 * (ratio - 1), atol=1e-10)


def test_designs_that_do_not_rest_have_no_values(study, shared, seas, found):
    """Also after a member of the same names whose designs all rest."""
    assert found.viable.all()
    lost = unstable(study)
    ds = member(lost, lambda basis: shared, seas, TUNINGS)
    assert ds.viable.values.tolist() == [True, False, False, True]
    assert [text.startswith("unstable: least stiffness -") for text in ds.reason.values] == [False, True, True, False]
    stable = ["FSB", "VSWEC90"]
    alone = member(with_designs(lost, stable), lambda basis: shared, seas, TUNINGS)
    for name in (*OF_DESIGNS, *CURVES, *MATRICES):
        assert np.isnan(ds[name].sel(design=["VSWEC", "VSWEC0"])).all(), name
        np.testing.assert_array_equal(ds[name].sel(design=stable), alone[name], err_msg=name)


def test_years_within_limits_stand_in_their_places_beside_known_dampers(study, shared, seas):
    """Of the designs that rest, here the first and the last, whether the first is known already or not."""
    lost, stable, asked, known = unstable(study), ["FSB", "VSWEC90"], [], {}
    alone = member(with_designs(lost, stable), lambda basis: shared, seas, ("one",))
    here = {"design": stable, "tuning": [CONSTRAINED]}
    share = xr.Dataset({"optimum_share": ("design", [0.7, 0.9])}, coords={"design": stable})
    within = (3 * alone[["annual_mean_power", "power_matrix"]]).assign_coords(here).merge(share)

    def optima(*given):
        asked.append(given)
        return within

    for _ in range(2):
        ds = member(lost, lambda basis: shared, seas, (CONSTRAINED, "one"), optima, known)
        for name in within.data_vars:
            np.testing.assert_array_equal(
                ds[name].sel({dim: here[dim] for dim in here if dim in ds[name].dims}), within[name]
            )
        np.testing.assert_array_equal(ds.annual_mean_power.sel(design=stable, tuning=["one"]), alone.annual_mean_power)
        assert np.isnan(ds.optimum_share.sel(design=["VSWEC", "VSWEC0"])).all()
    assert len(known) == 1
    for some, _, of, least, left_out in asked:
        assert (list(some.designs), of, least) == (stable, seas, shared.omega[0])
        assert (left_out[1, 1] > 0, left_out[0].any()) == (True, False)
    assert len(asked) == 2


def test_where_no_design_rests_the_water_is_not_asked(study, seas):
    """Neither where a shell has no equilibrium nor where all it has is unstable; the seas are counted all the same."""
    asked = []
    soft = varied(study, reference_shape="equilibrium")
    shells = with_designs(unstable(study), ["VSWEC", "VSWEC0"])
    for lost in (soft, shells):
        ds = member(lost, asked.append, seas, TUNINGS)
        assert not ds.viable.values.any()
        assert np.isnan(ds.annual_mean_power).all()
        assert ds["count"].sum() == 12
        assert ds.margin < 0
    assert asked == []


def test_without_a_rigid_design_there_is_no_gain(study, shared, seas):
    ds = member(with_designs(study, ["VSWEC"]), lambda basis: shared, seas, ("one",))
    assert not [name for name in ds.data_vars if name.startswith("gain")]
    assert float(ds.annual_mean_power.sel(design="VSWEC", tuning="one")) > 0


@pytest.mark.parametrize("compared", [True, False])
@pytest.mark.parametrize("tunings", [("one",), ("fixed", "one", "each"), (CONSTRAINED,), ("one", CONSTRAINED)])
def test_what_a_member_may_tell_goes_by_its_tunings_and_by_whether_there_is_a_reference(tunings, compared, seas):
    """Optima where a tuning has them, gains over a reference; each over its own dimensions and without a value."""
    ds, bins = _blank(("A", "B"), tunings, seas, compared), bins_of(seas)
    of_designs = {name for name in OF_DESIGNS if compared or name not in ("gain_percent", "gain_low", "gain_high")}
    limits = set(OF_LIMITS) if CONSTRAINED in tunings else set()
    dims = dict.fromkeys(of_designs, BY) | dict.fromkeys(MATRICES, (*BY, *BINS))
    dims |= dict.fromkeys(CURVES, ("design", "damper")) | dict.fromkeys(limits, ("design",))
    dims |= {"energy_beyond": (*BY, "limit")}
    assert {name: ds[name].dims for name in ds.data_vars} == {**dims, **TOLD, "count": BINS}
    assert all(ds[name].isnull().all() for name in dims)
    sizes = {"design": 2, "tuning": len(tunings), "limit": len(LIMITS), "damper": len(TRIED)}
    assert dict(ds.sizes) == sizes | dict(zip(BINS, bins.shape, strict=True))
    assert (ds.tuning.values.tolist(), ds.limit.values.tolist()) == (list(tunings), list(LIMITS))
    np.testing.assert_array_equal(ds["count"], bins.count)
    np.testing.assert_array_equal(ds.hs, bins.hs_centres)
    np.testing.assert_array_equal(ds.te, bins.te_centres)
