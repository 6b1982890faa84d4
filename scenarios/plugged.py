"""The sources of plug-ins that FMUs carry: each plug-in's file, if it works alone there."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fmu_compensator.plugins import plugged_error_models
from fmu_compensator.runtime.error_models import shipped_error_models
from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.modelfile import Model
from fmu_packaging.bundle import needed_by, problem_alone
from measurement.plugins import PlugIn
from plant_model.effect_names import name_of
from plant_model.effects import Effect, shipped_effects
from plant_model.machine import Machine
from plant_model.plugins import plugged_effects


def effect_files(
    machine: Machine, roots: tuple[str, ...], third_party: Mapping[str, str]
) -> dict[str, str]:
    """Return the sources of the plug-ins' effects in force, by dotted name in the plant FMU.

    Raises
    ------
    BadInput
        For a plug-in that cannot go into an FMU.
    """
    plugins = plugged_effects(frozenset(shipped_effects()))
    names = {name_of(key) for key in machine.effects}
    return {
        f"plant_model.effects.{name}": _source(plugins[name], Effect, roots, third_party)
        for name in sorted(names & plugins.keys())
    }


def error_model_files(model: Model, roots: tuple[str, ...]) -> dict[str, str]:
    """Return the sources of plug-ins' error models in use, by dotted name in the compensator FMU.

    Raises
    ------
    BadInput
        For a plug-in that cannot go into an FMU.
    """
    plugins = plugged_error_models(frozenset(shipped_error_models()))
    package = "fmu_compensator.runtime.error_models"
    return {
        f"{package}.{kind}": _source(plugins[kind], ErrorModel, roots, {})
        for kind in sorted(set(_kinds(model.table["error_model"])) & plugins.keys())
    }


def _kinds(table: Mapping[str, Any]) -> Iterator[str]:
    """Return the kind of an error model and those of its constituents."""
    yield str(table["kind"])
    for inner in table.get("models", []):
        yield from _kinds(inner)


def _source(
    plugin: PlugIn[type[Any]],
    base: type[Any],
    roots: tuple[str, ...],
    third_party: Mapping[str, str],
) -> str:
    """Return what the plug-in's class needs of its file; the rest may need other packages."""
    kind = plugin.thing
    path = Path(inspect.getfile(kind))
    source = needed_by(path.read_text(encoding="utf-8"), kind.__name__)
    # As the walk in the FMU will see the file.
    alike = [
        name
        for name, thing in vars(inspect.getmodule(kind)).items()
        if isinstance(thing, type) and issubclass(thing, base) and thing is not base
        if re.search(rf"\b{name}\b", source)
    ]
    carried = ", ".join(("the standard library", *third_party, *roots))
    if len(alike) != 1:
        problem = f"{path.name} holds {', '.join(alike)}, an FMU carries one class of the kind"
        raise plugin.refuse(f"cannot go into an FMU: {problem}")
    problem = problem_alone(path.name, source, roots, third_party)
    if problem:
        raise plugin.refuse(f"cannot go into an FMU: {problem}; it carries {carried} only")
    return source
