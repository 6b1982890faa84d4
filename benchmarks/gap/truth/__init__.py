"""A machine to test the gap finder on: many cells, laws of its own, effects that can be hidden.

It plays the measured machine. So it shares nothing with ``plant_model``: neither code, nor
discretisation, nor film and gap correlations, nor parameter values.
"""

from benchmarks.gap.truth.case import CaseRun, TruthCase, simulate_case
from benchmarks.gap.truth.effects import OUTSIDE, catalogue, make_effect
from benchmarks.gap.truth.parameters import draw, nominal
from benchmarks.gap.truth.spindle import Spindle

__all__ = [
    "OUTSIDE",
    "CaseRun",
    "Spindle",
    "TruthCase",
    "catalogue",
    "draw",
    "make_effect",
    "nominal",
    "simulate_case",
]
