"""ecospy: the co-simulation library Ecos from Python."""

import pytest

from tests.masters.conftest import STEP_S, STOP_S, agree, example, needs


@pytest.fixture(autouse=True)
def installed() -> None:
    """Skip, or fail, where it is missing."""
    needs("ecospy", "tbb")


def test_the_coupled_fmus(plant, compensator, signals, reference, tmp_path):
    agree(example("in_ecospy.py", plant, compensator, signals, folder=tmp_path), reference)


@pytest.mark.long
def test_the_same_in_fmi_3(shipped_in_fmi3, compensator, signals, reference, tmp_path):
    if "native" not in compensator.name:
        pytest.skip("only FMUs in C have FMI 3.0")
    in_fmi3 = [shipped_in_fmi3 / f"{kind}_native_fmi3.fmu" for kind in ("plant", "compensator")]
    agree(example("in_ecospy.py", *in_fmi3, signals, folder=tmp_path), reference)


def test_the_ssp(ssp, reference, tmp_path):
    agree(example("ssp_in_ecospy.py", ssp, STEP_S, STOP_S, folder=tmp_path), reference)
