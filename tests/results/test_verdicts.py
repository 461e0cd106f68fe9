"""Designs invalidated by failed checks."""

from conftest import varied

from vsb.hydro.database import INVALIDATING, Check
from vsb.report.doubts import ADVICE, REASONS
from vsb.results.verdicts import Invalid, flexible_designs, invalid_designs

REGULAR = {"kind": "regular", "amplitude": 0.5, "period": 5.0}
NOISE = {"kind": "jonswap", "hs": 1.0, "tp": 5.0, "realisations": 2}


def study_of(seed):
    return varied(seed, designs={"FSB": {"flexible": False}, "A": {}, "B": {}}, waves=[REGULAR, NOISE])


def check(name, verdict="fail", design="", wave="", value=2.0):
    return Check(name, value, 1.0, "-", verdict, "why", design, wave)


def test_every_invalidating_check_has_a_reason_and_advice():
    assert set(REASONS) == set(INVALIDATING) <= set(ADVICE)


def test_failed_shell_check_invalidates_flexible_designs_only(seed):
    study = study_of(seed)
    seas = {wave.label if i == 0 else wave.family for i, wave in enumerate(study.waves)}
    assert flexible_designs(study) == ["A", "B"]
    found = invalid_designs(study, [check("buckling")])
    assert {(line.design, line.sea) for line in found} == {(design, sea) for design in "AB" for sea in seas}
    found = invalid_designs(study, [check("hydro panels", "accepted")])
    assert {line.design for line in found} == {"FSB", "A", "B"}
    assert {line.name for line in found} == {"panels"}


def test_failed_check_invalidates_its_own_sea_only(seed):
    study = study_of(seed)
    swell, first, second = (wave.label for wave in study.waves)
    strained = [check("strain", design="A", wave=first, value=3.0), check("strain", design="A", wave=second, value=5.0)]
    assert invalid_designs(study, strained) == [Invalid("A", study.waves[1].family, "strain", 5.0, 1.0)]
    unbalanced = check("energy_residual", design="FSB", wave=swell)
    assert invalid_designs(study, [unbalanced]) == [Invalid("FSB", swell, "energy_residual", 2.0, 1.0)]


def test_doubts_leave_results_valid(seed):
    checks = [check("buckling", "doubt"), check("strain", "ok", "A"), check("steepness"), check("fair_damping")]
    assert invalid_designs(study_of(seed), checks) == []
    assert [one.invalidates for one in (check("buckling"), check("panels"), *checks)] == [
        "flexible",
        "all",
        *[None] * 4,
    ]
