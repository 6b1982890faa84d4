"""fmpy, in twenty lines of its own interface instead of this project's loop."""

from scenarios.cli import main
from tests.masters.conftest import SCENARIO, SETTINGS, STEP_S, STOP_S, VARIANT, agree, example


def test_the_coupled_fmus(plant, compensator, signals, reference, tmp_path):
    agree(example("in_fmpy.py", plant, compensator, signals, folder=tmp_path), reference)


def test_an_ssp_of_version_2(shipped_in_fmi3, reference, tmp_path):
    out = tmp_path / "two.ssp"
    fmus = [
        f"--{role}={shipped_in_fmi3}/{role}_native_fmi3.fmu" for role in ("plant", "compensator")
    ]
    settings = [f"--set={key}={value}" for key, value in SETTINGS.items()]
    arguments = ["ssp", SCENARIO, "--ssp", "2", "--variant", VARIANT, "-o", str(out)]
    assert main([*arguments, *fmus, *settings]) == 0
    agree(example("ssp_in_fmpy.py", out, STEP_S, STOP_S, folder=tmp_path), reference)
