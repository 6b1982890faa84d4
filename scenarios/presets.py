"""The methods of the three studies as presets: ``--as GA``, ``--as TS``, ``--as VAC``.

A preset sets what the study prints; any option given as well overrides it. Comments say where a
study is silent or its number is lost from its text.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fmu_compensator.fit.points import GROWTH
from measurement.errors import BadInput, refuse_other
from measurement.runs import Run


@dataclass(frozen=True)
class Preset:
    """The method of a study.

    Attributes
    ----------
    points : str
        How it chooses temperatures, or the temperatures it takes, by their names on the jig borer.
    places : str
        Places of the temperatures that it takes.
    grey : mapping
        Options of the choice, by the names of `choose_points`.
    model : str
        Error model that it installs.
    models : mapping of str to mapping
        Error models that it compares and installs, with the options of each.
    geometry_form : str
        How it converts a tilt to an offset.
    """

    points: str
    grey: Mapping[str, Any]
    model: str
    models: Mapping[str, Mapping[str, Any]]
    places: str = ""
    geometry_form: str = "pure_rotation"


TRAINED: Mapping[str, Any] = {"decay": 0.0, "iterations": 1000}
"""Both network studies: Levenberg-Marquardt without weight decay, up to 1000 iterations."""
EQUATION_8: Mapping[str, Any] = {
    "mass_kg": 15.5,
    "specific_heat": 463.0,
    "film": 104.0,
    "surface_m2": 0.125,
}
"""tau = m c / (alpha S) [kg, J/(kg K), W/(m2 K), m2]: 552 s. The study's own four numbers, its
Table 1, are lost. These are the turning parts (shaft, nose, rotor) of the finite-element spindle
``jig_borer``, whose film follows the study's equation (12) at 56 mm and 8,000 r/min."""
HYBRID = {
    "mlr": {"subset": False},
    "ne": {"steady": "fem", **EQUATION_8},
    "fem": {"identify": False},
}
"""The hybrid's parts as that study has them: all three temperatures in the regression, the steady
growth from finite elements, tau by equation (8), finite elements that are not fitted."""

PRESETS: Mapping[str, Preset] = {
    "GA": Preset(
        points="grey",
        grey={
            "threshold": 0.9,
            "theta": 0.5,
            "absolute_image": "initial",
            "image": "mean",
            "score": "relational",
            "target": GROWTH,
        },
        model="ga_bp",
        models={"bp": {**TRAINED, "hidden": (10,)}, "ga_bp": {**TRAINED, "hidden": 10}},
    ),
    # Five variables from four groups: the study does not say how. The air (T5) stays in.
    "TS": Preset(
        points="hierarchical",
        grey={
            "clusters": 4,
            "variables": 5,
            "keep_quiet": True,
            "score": "correlation",
            "target": GROWTH,
        },
        model="arma",
        models={"mlr": {}, "bp": {**TRAINED, "hidden": (5, 5)}, "arma": {}},
    ),
    "VAC": Preset(
        points="T6,T1,T5",
        places="front bearing, rear bearing and air",
        grey={"keep_quiet": True},
        model="vac",
        models={**HYBRID, "vac": {"models": ("mlr", "ne", "fem"), "parts": HYBRID}},
        geometry_form="rigid",
    ),
}


def preset(name: str, runs: Sequence[Run] = (), points: Any = None) -> Preset:
    """Return a preset by the study's name.

    Parameters
    ----------
    name : str
        One of `PRESETS`.
    runs : sequence of Run, optional
        Must have the temperatures that the study takes by name.
    points : str or sequence of str, optional
        Replaces those temperatures.

    Raises
    ------
    BadInput
        If the name is unknown, or the runs lack the temperatures.
    """
    refuse_other("study", "", name, PRESETS)
    given = PRESETS[name]
    if given.places and points in (None, "", given.points):
        wanted = [f"{sensor}_degC" for sensor in given.points.split(",")]
        for run, column in ((run, column) for run in runs for column in wanted):
            if column not in run.temperatures:
                problem = f"is missing; {name} takes {given.places}: name yours (points)"
                raise BadInput(run.path or run.name, f"column {column}", problem)
    return given


class _As(argparse.Action):
    """Sets the preset's options, except those given before it; options after it override it."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        given = preset(str(values))
        setattr(namespace, self.dest, values)
        settings = {"points": given.points, "model": given.model, **given.grey}
        settings["geometry_form"] = given.geometry_form
        for name, value in settings.items():
            if hasattr(namespace, name) and getattr(namespace, name) == parser.get_default(name):
                setattr(namespace, name, value)


def add_as(parser: argparse.ArgumentParser) -> None:
    """Declare ``--as``; the command's other arguments must be declared before."""
    parser.add_argument(
        "--as",
        dest="study",
        metavar="|".join(PRESETS),
        choices=tuple(PRESETS),
        type=str.upper,
        action=_As,
        help="do as that study does: points, groups, scores, models, networks, geometry "
        "(docs/studies.md); options after it override it",
    )
