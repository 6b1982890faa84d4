"""Plug-ins: an example distribution, installed apart with its entry points, and broken ones."""

import json
import os
import shutil
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import scenarios.plugged
from fmu_compensator import plugins as error_model_plugins
from fmu_compensator.fit import error_models as fit_error_models
from fmu_compensator.fit.error_models import fitted_models
from fmu_compensator.plugins import plugged_error_models
from fmu_compensator.runtime import error_models as run_error_models
from fmu_compensator.runtime.modelfile import ModelFileError, load_model
from measurement import plugins
from measurement.errors import BadInput
from measurement.importing import plugged
from measurement.importing.plugged import importers
from measurement.importing.sheets import read_sheets
from plant_model.effects import catalogue, shipped_effects
from plant_model.machine_file import read_machine
from plant_model.plugins import plugged_effects
from scenarios.plugged import effect_files
from tests.conftest import ROOT
from tests.running import python

EXAMPLE = Path(__file__).parent / "example"


def lay_down(folder: Path, name: str, version: str, groups: dict[str, dict[str, str]]) -> None:
    """Write a distribution's metadata as an installer does."""
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    lines = [
        line
        for group, points in groups.items()
        for line in (f"[{group}]", *(f"{key} = {value}" for key, value in points.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the example as it is when installed."""
    folder = tmp_path_factory.mktemp("plugins")
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]
    lay_down(folder, project["name"], project["version"], project["entry-points"])
    shutil.copytree(EXAMPLE / "drag_kit", folder / "drag_kit")
    return folder


def broken(folder: Path, group: str, entry: str, code: str = "") -> Path:
    """Lay down a distribution with one entry point; return the folder that holds it."""
    name, _, value = entry.partition(" = ")
    lay_down(folder, "odd-kit", "0.3", {f"spindle_drift.{group}": {name: value}})
    (folder / "odd_kit.py").write_text(code)
    return folder


def good(site: Path, folder: Path, *argv: str) -> str:
    return python(*argv, folder=folder, path=os.pathsep.join([str(site), str(ROOT)]))


@pytest.fixture(scope="module")
def machine(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The jig borer with the plug-in's effect in force."""
    path = tmp_path_factory.mktemp("machine") / "dragging.toml"
    text = (ROOT / "plant_model" / "machines" / "jig_borer_lumps.toml").read_text()
    power = '{ value = 200.0, unit = "W", low = 0.0, high = 300.0, source = "made up" }'
    path.write_text(f"{text}\n[effects.brake_drag]\npower = {power}\n")
    return path


PLANT = """
import sys
import pandas as pd
import spindle_drift as sd
from measurement.importing.sheets import read_sheets
from gap_finder.candidates import missing_effects
from plant_model.native.generate import machine_sources
assert "200.0 * " in machine_sources(sd.Machine(sys.argv[1]).model)["equations.c"]
lumps = sd.Machine("jig_borer_lumps").model
assert "brake_drag" in {effect.name for effect in missing_effects(lumps)}
inputs = pd.DataFrame({"time_s": [0.0, 1800.0, 3600.0], "speed_rpm": 6000.0,
                       "T9_degC": 21.0, "T5_degC": 21.0})
with_it, without = (sd.simulate(m, inputs).frame for m in (sys.argv[1], "jig_borer_lumps"))
print(float((with_it - without).filter(like="_degC").to_numpy().max()))
log = sd.import_log("log.jlog")
print(list(log.runs[0].frame), log.runs[0].frame.iloc[0].tolist())
"""


@pytest.mark.long
def test_an_effect_is_simulated_and_offered_to_the_gap_finder_and_a_log_is_read(
    site, machine, tmp_path
):
    rows = [{"t [s]": k, "Spindle [K]": 293.15 + 0.1 * k} for k in range(4)]
    (tmp_path / "log.jlog").write_text("\n".join(json.dumps(row) for row in rows))
    warmer, run = good(site, tmp_path, "-c", PLANT, str(machine)).splitlines()
    assert 0.2 < float(warmer) < 20.0
    assert run == "['time_s', 'Spindle_degC'] [0.0, 20.0]"


SHOWN = """
import fmpy
found = fmpy.simulate_fmu("fmus/dragging.fmu", stop_time=1800.0, output_interval=60.0,
                          output=["T2"], start_values={"speed": 6000.0})
print(repr(float(found["T2"][-1])))
"""
FMU = f"""
import sys
import spindle_drift as sd
sd.build_fmu(sys.argv[1], "fmus", name="dragging")
{SHOWN}
"""


@pytest.mark.long
def test_a_plant_fmu_carries_the_effect_to_where_the_plug_in_is_not(site, machine, tmp_path):
    here = good(site, tmp_path, "-c", FMU, str(machine))
    with zipfile.ZipFile(tmp_path / "fmus" / "dragging.fmu") as archive:
        names = archive.namelist()
    assert any(name.endswith("/plant_model/effects/brake_drag.py") for name in names)
    assert not any(name.endswith("/plugins.py") for name in names)
    (apart := tmp_path / "apart").mkdir()
    assert good(apart, tmp_path, "-c", SHOWN) == here
    assert float(here) > 20.1


COMPENSATOR = """
import spindle_drift as sd
names = ["training_down", "training_random"]
runs = [sd.simulate("jig_borer_lumps", name, every_s=120.0, noise_seed=n)
        for n, name in enumerate(names)]
found = sd.fit(runs, model="mean_rise", machine="jig_borer_lumps")
print(found.save("mean.json"))
print(sd.build_fmu("mean.json", "fmus", name="mean"))
print(sd.build_fmu("mean.json", "fmus", name="native", native=True))
"""
BOTH = """
import fmpy, numpy as np
variables = fmpy.read_model_description("fmus/mean.fmu").modelVariables
names = [one.name for one in variables if one.causality == "input" and one.name[:1] == "T"]
warming = np.zeros(60, dtype=[("time", float), *((name, float) for name in names)])
warming["time"] = 60.0 * np.arange(60)
for place, name in enumerate(names):
    warming[name] = 20.0 + 0.02 * place * np.arange(60)
python, native = (
    fmpy.simulate_fmu(f"fmus/{name}.fmu", stop_time=3000.0, output_interval=60.0, input=warming)
    for name in ("mean", "native")
)
for name in python.dtype.names:
    np.testing.assert_allclose(native[name], python[name], rtol=1e-12, atol=1e-12)
print(len(python), len(set(python["dZ"])))
"""


@pytest.mark.long
def test_an_error_model_in_one_file_is_fitted_and_goes_into_fmus(site, compiler, tmp_path):
    good(site, tmp_path, "-c", COMPENSATOR)
    table = json.loads((tmp_path / "mean.json").read_text())
    assert table["error_model"]["kind"] == "mean_rise"
    with pytest.raises(ModelFileError, match="mean_rise"):
        load_model(tmp_path / "mean.json")
    with zipfile.ZipFile(tmp_path / "fmus" / "mean.fmu") as archive:
        (name,) = [name for name in archive.namelist() if name.endswith("/mean_rise.py")]
        carried = archive.read(name).decode()
    assert "class MeanRise" in carried
    assert "import numpy" not in carried
    (apart := tmp_path / "apart").mkdir()
    rows, levels = map(int, good(apart, tmp_path, "-c", BOTH).splitlines()[-1].split())
    assert rows > 10
    assert levels > 1


def effect(name: str = "odd", also: str = "math", amplitude: str = "power") -> str:
    """Return the code of an effect."""
    return f"""
from typing import ClassVar
import {also}
from plant_model.effects.base import Effect
from plant_model.parameters import Parameter
class Odd(Effect):
    name: ClassVar[str] = "{name}"
    title: ClassVar[str] = "Odd"
    explanation: ClassVar[str] = "Odd."
    parameters: ClassVar[dict] = {{"power": Parameter(1.0, "W", 0.0, 2.0, "made up")}}
    amplitude: ClassVar[str] = "{amplitude}"
    needs: ClassVar[object] = {also}
"""


@pytest.fixture
def seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder whose distributions this process sees."""
    # Asked now, so that nothing of the folder is remembered by what other tests use.
    catalogue(), fitted_models(), importers()
    folder = tmp_path / "site"
    monkeypatch.syspath_prepend(str(folder))
    plugins._points.cache_clear()
    yield folder
    plugins._points.cache_clear()
    sys.modules.pop("odd_kit", None)


FITTED = """
from fmu_compensator.fit.error_models.mlr import MultipleLinearRegression
class Odd(MultipleLinearRegression):
    pass
"""
RUNS = """
from fmu_compensator.runtime.error_models.mlr import MultipleLinearRegression
class Runs(MultipleLinearRegression):
    other_fits = ("{other}",)
"""
NAMED_TWICE = "windage is a name that the project itself uses"
READERS = {
    "effects": lambda: plugged_effects.__wrapped__(frozenset(shipped_effects())),
    "error_models": fitted_models.__wrapped__,
    "importers": importers.__wrapped__,
}
"""What reads the plug-ins of a group anew."""


@pytest.mark.parametrize(
    ("group", "entry", "code", "said"),
    [
        ("effects", "odd = odd_kit:Odd", "raise RuntimeError('no')", "RuntimeError: no"),
        ("effects", "odd = odd_kit:Odd", "def (", "SyntaxError"),
        ("effects", "odd = odd_kit:Odd", "raise SystemExit(3)", "SystemExit"),
        ("effects", "odd = not_there:Odd", "", "No module named 'not_there'"),
        ("effects", "odd = odd_kit:Odd", "", "has no attribute 'Odd'"),
        ("effects", "odd = odd_kit:Odd", "Odd = 3", "is no subclass of plant_model.effects.base.E"),
        ("effects", "odd = odd_kit:Odd", effect("even"), "is called even"),
        ("effects", "odd = odd_kit:Odd", effect(amplitude="size"), "size is none of its param"),
        ("effects", "windage = odd_kit:Odd", effect("windage"), NAMED_TWICE),
        ("error_models", "zoo = odd_kit", FITTED, "odd_kit has no predicting twin"),
        ("error_models", "zoo = odd_kit:Odd", FITTED, "is no module or package: name the file"),
        ("error_models", "zoo = odd_kit", f"{FITTED}class Even(Odd): pass", "defines 2 variants"),
        ("error_models", "zoo = odd_kit", FITTED + RUNS.format(other="mlr"), "the project itself"),
        ("error_models", "zoo = odd_kit", FITTED + RUNS.format(other="ridge"), "plug-in studies"),
        ("importers", "csv = odd_kit:read", "read = print", "csv is a name that"),
    ],
)
def test_a_broken_plug_in_is_one_line_that_names_it(group, entry, code, said, seen, monkeypatch):
    broken(seen, group, entry, code)
    for module in (fit_error_models, run_error_models):
        monkeypatch.setattr(module, "error_models", run_error_models.error_models.__wrapped__)
    monkeypatch.setattr(
        error_model_plugins, "plugged_error_models", plugged_error_models.__wrapped__
    )
    with pytest.raises(BadInput) as refused:
        READERS[group]()
    text, name = str(refused.value), entry.split()[0]
    assert text.startswith(f"plug-in {name} of odd-kit 0.3: spindle_drift.{group}: ")
    assert said in text
    assert "\n" not in text


def test_two_plug_ins_of_one_name_are_refused(seen):
    broken(seen, "effects", "odd = odd_kit:Odd", effect())
    lay_down(seen, "other-kit", "1.0", {"spindle_drift.effects": {"odd": "odd_kit:Odd"}})
    named = r"other-kit 1\.0.*odd is a name that plug-in odd of odd-kit"
    with pytest.raises(BadInput, match=named):
        READERS["effects"]()


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("def read(path): raise KeyError('no')", "cannot be read by plug-in jlog of odd-kit 0.3"),
        ("def read(path): return [1]", "must return a mapping of title to pandas frame"),
    ],
)
def test_a_reader_that_fails_is_one_line(code, said, seen, tmp_path, monkeypatch):
    broken(seen, "importers", "jlog = odd_kit:read", code)
    monkeypatch.setattr(plugged, "importers", importers.__wrapped__)
    (tmp_path / "log.jlog").write_text("x")
    with pytest.raises(BadInput, match=said):
        read_sheets(tmp_path / "log.jlog")


def test_what_cannot_go_into_an_fmu_is_said_in_one_line(seen, monkeypatch):
    broken(seen, "effects", "odd = odd_kit:Odd", effect(also="scipy"))
    machine = read_machine("jig_borer_lumps")
    grown = replace(machine, effects={**machine.effects, "odd": {}})
    monkeypatch.setattr(scenarios.plugged, "plugged_effects", plugged_effects.__wrapped__)
    carried = "odd_kit.py line 3 imports scipy; it carries the standard library, numpy, plant_model"
    with pytest.raises(BadInput, match=f"^plug-in odd of odd-kit 0.3: .*{carried}"):
        effect_files(grown, ("plant_model", "fmu_packaging"), {"numpy": ">=2.0"})
