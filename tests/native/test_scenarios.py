"""Every shipped scenario in full length, with the C compensator and with the Python one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import build_fmu
from scenarios.cosimulation import simulate
from scenarios.scenario import library, read_scenario

STEP_S = 10.0
SIMULATED = [path.stem for path in library() if read_scenario(path).cases]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both FMUs of the shipped compensator file, and the plant's."""
    folder = tmp_path_factory.mktemp("dist")
    for arguments in ([], ["--native"]):
        assert build_fmu.main([*arguments, "--out", str(folder)]) == 0
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("name", SIMULATED)
def test_a_scenario_goes_the_same_with_either(name: str, folder: Path) -> None:
    for case in read_scenario(name, [("step_s", STEP_S)]).cases:
        python, native = (
            simulate(case, folder / "plant.fmu", folder / file, quiet=True)
            for file in ("compensator.fmu", "compensator_native.fmu")
        )
        assert list(native.frame) == list(python.frame)
        assert native.events == python.events
        if case.settings.compensator.enabled:
            assert native.frame["dZ_um"].abs().max() > 1.0
        np.testing.assert_allclose(native.frame, python.frame, rtol=1e-12, atol=1e-12)
