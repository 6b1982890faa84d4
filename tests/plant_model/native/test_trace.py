"""What can be traced, and what is refused under its effect's name."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import build_fmu
from plant_model.effects import catalogue
from plant_model.effects.base import Effect, Inputs
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from plant_model.native.equations import NoFormulaError, equations_of
from plant_model.native.trace import Graph, UntraceableError
from plant_model.parameters import FloatArray, Parameter


class Deciding(Effect):
    """An effect whose course depends on a temperature."""

    name = "deciding"
    title = explanation = "It decides."
    parameters = {"power": Parameter(1.0, "W", 0.0, 2.0, "test", True)}  # noqa: RUF012
    temperature_dependent = True

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        if temperatures[0, 0, 0] > 30.0:
            out[..., 0] += self.own("power")


@pytest.fixture
def deciding(monkeypatch: pytest.MonkeyPatch) -> None:
    """The catalogue with an effect in Python alone."""
    found = {**catalogue(), "deciding": Deciding}
    for name, module in list(sys.modules.items()):
        if name.startswith("plant_model") and hasattr(module, "catalogue"):
            monkeypatch.setattr(module, "catalogue", lambda: found)


def test_an_effect_without_a_form_in_c_is_named_in_one_line(deciding, tmp_path, capsys):
    machine = read_machine("jig_borer_lumps")
    # Machines without it are as they were.
    assert equations_of(machine, []).force
    with_it = replace(machine, effects=machine.effects | {"deciding": dict(Deciding.parameters)})
    said = "effect deciding: no form in C: its course depends on a value"
    with pytest.raises(NoFormulaError, match=said):
        equations_of(with_it, [])
    path = tmp_path / "deciding.toml"
    write_machine(with_it, "jig_borer_lumps", path)
    arguments = ["--native", "--only", "plant", "--machine", str(path), "--out", str(tmp_path)]
    assert build_fmu.main(arguments) == 2
    assert capsys.readouterr().err == f"--native: {said}\n"
    assert [entry.name for entry in tmp_path.iterdir()] == ["deciding.toml"]


def test_numpy_is_itself_again_after_tracing():
    equations_of(read_machine("lathe"), [])
    for effect in catalogue().values():
        module = __import__(effect.__module__, fromlist=["np"])
        assert getattr(module, "np", np) is np


@pytest.mark.parametrize(
    "call",
    [
        lambda a: bool(a[0] > 1.0),
        lambda a: float(a[0]),
        lambda a: np.linalg.norm(a),
        lambda a: np.sort(a),
        lambda a: np.add.reduce(a),
    ],
)
def test_what_has_no_formula_is_refused(call):
    with pytest.raises(UntraceableError):
        call(Graph().symbols("T", (3,)))
