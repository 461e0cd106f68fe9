"""Results of a study, each read when it is asked for and checked against its id."""

import numpy as np
import pytest
from conftest import varied

from vsb.api.results import Results
from vsb.errors import ConfigError, DatabaseError


@pytest.fixture
def results(small):
    return Results(small.study)


def test_tables_have_a_row_for_every_design_and_sea(results):
    assert [row["design"] for row in results.comparison.to_dict("records")] == ["FSB", "VSWEC"]
    assert results.statistics.to_dict("records") == []
    verdicts = [check["verdict"] for check in results.checks.to_dict("records")]
    assert verdicts == sorted(verdicts, key=("fail", "accepted", "doubt", "ok").index)


def test_port_is_that_of_the_response(results):
    omega = results.response.omega.values[5:20]
    for design in results.study.designs:
        stored = results.response.sel(design=design, omega=omega)
        port = results.port(design, omega)
        np.testing.assert_allclose(port.impedance, stored.port_impedance.values, rtol=1e-12)
        np.testing.assert_allclose(port.matched_power, stored.matched_power.values, rtol=1e-12)


def test_unknown_design_wave_or_result_is_refused(results):
    with pytest.raises(ConfigError, match=r"design: received 'none', needs one of FSB, VSWEC"):
        results.trajectory("none")
    with pytest.raises(ConfigError, match=r"wave: received 'none', needs one of regular_A0.179_T2.5"):
        results.trajectory("FSB", "none")
    dry = Results(varied(results.study, hydro={"model": "assumed_pressure", "pressure": 1800.0}))
    for name, words in (("response", "frequency response"), ("ladder", "control levels"), ("database", "hydro data")):
        with pytest.raises(ConfigError, match=f"hydro.model: received 'assumed_pressure', which has no {words}"):
            getattr(dry, name)


def test_results_of_another_study_in_the_folder_are_refused(results):
    other = Results(varied(results.study, pto={"damping": 5000.0}))
    for name in ("comparison", "ladder", "response"):
        with pytest.raises(DatabaseError, match=r"small/\w+.\w+: "):
            getattr(other, name)
    with pytest.raises(DatabaseError, match=r"small/trajectories/FSB-regular_A0.179_T2.5.nc: holds .*, needs "):
        other.trajectory("FSB")
