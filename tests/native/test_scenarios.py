"""Every shipped scenario in full length, with the C compensator and with the Python one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scenarios.cosimulation import simulate
from scenarios.scenario import library, read_scenario

STEP_S = 10.0
SIMULATED = [path.stem for path in library() if read_scenario(path).cases]


@pytest.mark.long
@pytest.mark.parametrize("name", SIMULATED)
def test_a_scenario_goes_the_same_with_either(name: str, shipped_in_c: Path) -> None:
    for case in read_scenario(name, [("step_s", STEP_S)]).cases:
        python, native = (
            simulate(case, shipped_in_c / "plant.fmu", shipped_in_c / file, quiet=True)
            for file in ("compensator.fmu", "compensator_native.fmu")
        )
        assert list(native.frame) == list(python.frame)
        assert native.events == python.events
        if case.settings.compensator.enabled:
            assert native.frame["dZ_um"].abs().max() > 1.0
        np.testing.assert_allclose(native.frame, python.frame, rtol=1e-12, atol=1e-12)
