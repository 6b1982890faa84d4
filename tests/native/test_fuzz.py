"""The compensator's FMU under the sanitizers, called in random order with random arguments."""

import pytest

from fmu_compensator.native.generate import constants, data_sources, program
from fmu_compensator.runtime.fmi_slave import variables
from fmu_packaging.native.build import front
from tests.native.made import made_model
from tests.plant_model.native.test_fuzz import fuzz


@pytest.mark.long
@pytest.mark.parametrize("calls", [6_000, pytest.param(60_000, marks=pytest.mark.long)])
@pytest.mark.parametrize(("kind", "seed"), [("vac", 0), ("thermal_states", 6)])
def test_fuzzed_calls_are_clean(kind, seed, calls, compiler, tmp_path):
    model = made_model(kind, seed)
    sources = {**front(2), **program(), "constants.h": constants()}
    sources["model_data.c"] = data_sources(model, variables(model), "fuzz", "{0}")
    fuzz(sources, calls, compiler, tmp_path)
