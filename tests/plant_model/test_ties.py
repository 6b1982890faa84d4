"""Named numbers that several parameters follow."""

import copy
import tomllib
from typing import Any

import numpy as np
import pytest
import tomlkit

from gap_finder.priors import Priors
from plant_model.machine import Machine
from plant_model.machine_file import SHIPPED, machine_from_table, read_machine
from plant_model.machine_writer import write_machine
from plant_model.parameters import ParameterError
from plant_model.simulate import simulate
from tests.plant_model.conftest import inputs_over
from tests.refusing import refusal

PLAIN = tomllib.loads((SHIPPED / "jig_borer_lumps.toml").read_text(encoding="utf-8"))
FRONT = [f"links.front_outer-housing_front_{side}.conductance" for side in ("xp", "xm", "yp", "ym")]


def tied_table() -> dict[str, Any]:
    """Return the jig borer with one number for the front bearing's joint and one for all films."""
    table = copy.deepcopy(PLAIN)
    ours = {"unit": "W/(m2 K)", "source": "ours", "calibrate": True}
    table["numbers"] = {
        "front_joint": {**ours, "value": 3000.0, "low": 1500.0, "high": 4500.0},
        "film": {**ours, "value": 9.0, "low": 5.0, "high": 14.0},
    }
    for link in table["links"]:
        if link["between"][0] == "front_outer":
            link["conductance"] = {"number": "front_joint", "factor": 0.015, "unit": "W/K"}
        if link["kind"] == "convection" and link["coefficient"]["value"] == 9:
            link["coefficient"] = {"number": "film"}
    return table


@pytest.fixture(scope="module")
def tied() -> Machine:
    return machine_from_table(tied_table(), "tied.toml")


def test_a_number_does_what_its_followers_would_do_one_by_one(tied, jig_borer_lumps):
    inputs = inputs_over(1.0)
    both = simulate(tied, inputs, {"numbers.front_joint": [3000.0, 4000.0]}).temperatures
    for which, each in enumerate((45.0, 60.0)):
        alone = simulate(jig_borer_lumps, inputs, dict.fromkeys(FRONT, each)).temperatures
        np.testing.assert_allclose(both[which], alone[0], atol=1e-10)
    assert np.abs(both[0] - both[1]).max() > 0.1


def test_a_number_is_moved_as_a_whole(tied):
    moved = tied.with_values({"numbers.film": 12.0})
    assert moved.parameters["links.column-ambient.coefficient"].value == 12.0
    assert moved.parameters["numbers.film"].value == 12.0
    assert moved.parameters[FRONT[0]] == tied.parameters[FRONT[0]]
    for refused in (
        lambda: tied.with_values({FRONT[0]: 50.0}),
        lambda: simulate(tied, inputs_over(0.1), {FRONT[0]: 50.0}),
    ):
        with pytest.raises(ParameterError, match=r"follows numbers\.front_joint, so move that"):
            refused()


def test_calibration_has_the_number_and_not_its_followers(tied):
    free = Priors.of(tied, calibrated=True).names
    assert {"numbers.front_joint", "numbers.film"} <= set(free)
    assert not set(free) & set(FRONT)
    assert not set(Priors.of(tied, calibrated=False).names) & set(FRONT)


def test_the_writer_moves_numbers_and_leaves_ties(tied, tmp_path):
    like = tmp_path / "tied.toml"
    like.write_text(tomlkit.dumps(tied_table()), encoding="utf-8")
    moved = tied.with_values({"numbers.film": 12.0})
    written = write_machine(moved, like, tmp_path / "moved.toml")
    assert read_machine(written) == moved
    texts = [path.read_text(encoding="utf-8") for path in (like, written)]
    assert texts[0].replace("value = 9.0", "value = 12.0") == texts[1]


@pytest.mark.parametrize(
    ("tie", "problem"),
    [
        ({"number": "flim"}, ".number: 'flim' is not one of front_joint, film;"),
        ({"number": "film"}, ".factor: is missing: film is in W/(m2 K), this"),
        ({"number": "film", "factor": 0.1, "unit": "W"}, ".unit: 'W' is not"),
        ({"number": "film", "factor": -0.1}, ": film makes it -1.4..-0.5, out"),
        ({"number": "film", "value": 3.0}, ".value: is not a known field"),
    ],
)
def test_refusals(tie, problem):
    table = tied_table()
    table["links"][0]["conductance"] = tie
    said = f"tied.toml: links.shaft_front-shaft_middle.conductance{problem}"
    assert refusal(machine_from_table, table, "tied.toml").startswith(said)
