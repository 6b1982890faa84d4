"""The figure of a sweep."""

import pandas as pd

from scenarios.sweep.figure import _figure
from scenarios.sweep.tables import FIGURES, PERCENTILES


def test_each_panel_says_its_axis_and_unit():
    table = pd.DataFrame({"axis": ["X", "Z"], "case": 0} | dict.fromkeys(FIGURES, 1.0))
    columns = [f"{w}_{a}_p{p}_um" for w in ("drift", "error") for a in "XZ" for p in PERCENTILES]
    bands = pd.DataFrame({"time_s": [0.0, 1.0]} | dict.fromkeys(columns, 0.0))
    labels = [axes.get_ylabel() for axes in _figure("", table, bands, "").axes]
    assert labels == ["X [µm]", "X [µm]", "Z [µm]", "Z [µm]"]
