import csv
import io

from vsb.results import comparison as compare
from vsb.results.comparison import as_csv

CONTRACT = "design,wave,displacement_pp,velocity_pp,power_peak,power_mean,energy,capture_width,energy_gain_percent,energy_residual"


def test_table_has_the_promised_columns_and_no_nan():
    row = dict.fromkeys(compare.COLUMNS, 1.0) | {"design": "A", "wave": "w", "capture_width": None}
    text = as_csv([row])
    assert text.splitlines()[0] == CONTRACT
    (back,) = csv.DictReader(io.StringIO(text))
    assert back["capture_width"] == ""
    assert back["energy"] == "1"
