"""What is said of a study of a body before anything is solved."""

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import told
from stages.test_coefficients import SWELL, as_body

from vsb.cli import main
from vsb.errors import ConfigError
from vsb.stages.body_preview import check_wave
from vsb.study.body import BodyStudy
from vsb.study.reading import validated


def checked(finished, capsys, **changes):
    """The one line in which a study is refused."""
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished, **changes)))
    return told(["check", "a.yaml"], capsys)


def test_a_summary_tells_what_moves_and_where_numbers_come_from(finished, workplace, capsys):
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished)))
    assert main(["check", "a.yaml"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("body         4 degrees of freedom: Heave, Membrane0,")
    assert lines[1].endswith("FSB moves in 1, VSWEC moves in 4")
    assert "frequencies from" in lines[2]
    assert "read from" in lines[2]
    assert any("steepness" in line for line in lines)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waves": [{**SWELL, "direction": 30.0}]}, "waves.0.direction: received 30 degrees, needs one of 0"),
        ({"waves": [{**SWELL, "period": 500.0}]}, "waves.0 regular_A0.1_T500: received a frequency of 0.01257 rad/s"),
        ({"designs": {"a": {"dofs": ["Roof"]}}}, "designs: received dofs Roof; needs some of Heave, Membrane0"),
        ({"pto": {"damping": 1.0, "port": {"dof": "Roof"}}}, "pto.port: received Roof; needs some of Heave"),
        ({"pto": {"damping": 1.0, "stiffness": -1e6}}, "designs.FSB: the body does not rest: received a negative"),
        ({"water": {"density": 1000.0}}, "water.density: received 1000, needs 1025, as the body's files have"),
        ({"body": {"database": "gone.nc"}}, "body.database: gone.nc cannot be read"),
        ({"waves": [{"kind": "still"}], "pto": {}}, "waves.0 still: no damper is best where nothing comes in"),
    ],
)
def test_what_would_fail_later_is_refused_in_one_line(finished, workplace, capsys, changes, message):
    if "designs" in changes:
        changes = {"pto": {"damping": 1.0}, **changes}
    assert message in checked(finished, capsys, **changes)
    assert {path.name for path in Path().iterdir()} == {"file", "a.yaml"}


KNOWN = xr.Dataset(coords={"omega": [0.5, 1.0, 2.0], "wave_direction": [0.0, np.pi / 2]})


@pytest.mark.parametrize(
    ("wave", "refused"),
    [
        ({"kind": "still"}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": 4 * np.pi}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": np.pi, "direction": 90}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": np.pi * (1 - 1e-6)}, "needs 0.5 to 2 rad/s, the band"),
        (
            {"kind": "regular", "amplitude": 0.1, "period": 4 * np.pi * (1 + 1e-6)},
            "a frequency of 0.5 rad/s, needs 0.5",
        ),
        (
            {"kind": "regular", "amplitude": 0.1, "period": 5.0, "direction": 45},
            "received 45 degrees, needs one of 0, 90",
        ),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.4, 1.9]}, None),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.6, 2.1]}, "a frequency of 2.1 rad/s"),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.3, 0.51]}, None),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.3, 0.49]}, "a frequency of 0.49 rad/s, needs 0.5 to 2 rad/s"),
    ],
)
def test_seas_lie_in_the_band_and_the_directions_of_a_bodys_database(wave, refused):
    """Ends of the band are of it; of an irregular sea what lies below is cut, unless it is all of it."""
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [wave], "pto": {"damping": 1.0}}
    (sea,) = validated(BodyStudy, made, "a.yaml").waves
    with pytest.raises(ConfigError, match=f"waves.7.*{refused}") if refused else nullcontext():
        check_wave(7, sea, SimpleNamespace(database=KNOWN))
