"""Both FMUs nested into one by fmu-manipulation-toolbox."""

import fmpy
import pytest
from fmpy.validation import validate_fmu

from scenarios.wiring import PROBED
from tests.masters.conftest import INPUTS, agree, example, needs


@pytest.fixture(autouse=True)
def installed() -> None:
    """Skip, or fail, where it is missing."""
    needs("fmu-manipulation-toolbox")


def test_the_nested_fmus(plant, compensator, signals, reference, tmp_path):
    agree(example("in_one_fmu.py", plant, compensator, signals, folder=tmp_path), reference)
    machine = str(tmp_path / "machine.fmu")
    assert validate_fmu(machine) == []
    variables = fmpy.read_model_description(machine).modelVariables
    inputs = {variable.name for variable in variables if variable.causality == "input"}
    # What a probe measures, now and then, stays open as well.
    assert {name for name in inputs if not name.startswith(PROBED)} == {*INPUTS, "torque"}
