"""The table of calibrated parameters."""

import numpy as np

from gap_finder.calibrate import intervals
from gap_finder.priors import Priors
from plant_model.machine_file import read_machine
from scenarios.pages.parameter_rows import parameter_rows


def test_a_number_that_left_its_range_stands_beside_the_range_of_the_file():
    machine = read_machine("jig_borer_lumps")
    priors = Priors.of(machine, calibrated=True)
    at = np.full(len(priors.names), 2.5)
    for row in parameter_rows(intervals(machine, priors, at, 0.1 * at)):
        given = machine.parameters[row["name"]]
        assert row["range"] == (given.low, given.high)
        assert row["value"] != given.value
