"""fmuloader: a second set of bindings for model exchange, in FMI 2.0 and 3.0."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

from tests.masters.conftest import example, needs

pytestmark = needs("fmuloader")

WITHIN = 1e-6  # [um, degC] Both solve what is linear; SciPy's method is told 1e-8.


@pytest.mark.parametrize("version", [2, pytest.param(3, marks=pytest.mark.long)])
def test_a_solver_outside_gives_the_co_simulation(version, request, tmp_path):
    if version == 2:
        fmu: Path = request.getfixturevalue("shipped_in_c") / "plant_native.fmu"
    else:
        fmu = request.getfixturevalue("shipped_in_fmi3") / "plant_native_fmi3.fmu"
    found: pd.DataFrame = example("exchange_in_fmuloader.py", fmu, folder=tmp_path)
    wanted = simulate_fmu(
        str(fmu),
        fmi_type="CoSimulation",
        stop_time=3600.0,
        output_interval=60.0,
        start_values={"speed": 6000.0, "ambient": 24.0},
        output=[name for name in found if name != "time"],
    )
    assert abs(wanted["drift_Z"][-1]) > 5.0
    for name in found:
        assert np.abs(found[name] - wanted[name]).max() < WITHIN, name
