"""The simulators that judge the gap finder, by name: one folder each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.gap import truth
from benchmarks.gap.around_page import owners_page, simulate_around_page
from benchmarks.gap.belt import case as belt_case
from benchmarks.gap.belt import effects as belt_effects
from benchmarks.gap.belt.owner import MISTAKES
from benchmarks.gap.lathe import case as lathe_case
from benchmarks.gap.lathe import effects as lathe_effects
from benchmarks.gap.lathe import owner as lathe_owner
from benchmarks.gap.truth import effects as jig_borer_effects
from benchmarks.gap.truth.case import CaseRun, TruthCase, simulate_case, simulate_further
from benchmarks.gap.truth.drive import Held

USUAL = "jig_borer"
"""The truth that is asked unless another is named."""


@dataclass(frozen=True)
class Truth:
    """One simulator.

    Attributes
    ----------
    title : str
    first : int
        Its seeds begin this far from those of the first one.
    simulate : callable
        From a case to its runs and what is hidden in them.
    catalogue : mapping of str to type
        What it can hide of the product's catalogue.
    outside : sequence of str
        What it can hide besides.
    beyond : mapping of str to float
        Amplitudes that are larger than usual, of some of the catalogue.
    mistakes : mapping of str to (kind, place)
        What can be wrong in its owner's file.
    page : callable, optional
        From a case to its owner's file; without one the shipped machine is asked about.
    further : callable, optional
        From a case and the values of inputs from instants on to one more run; with none given, one
        at random.
    """

    title: str
    first: int
    simulate: Callable[[TruthCase], tuple[list[CaseRun], Sequence[Any]]]
    catalogue: Mapping[str, type[Any]]
    outside: Sequence[str]
    beyond: Mapping[str, float] = field(default_factory=dict)
    mistakes: Mapping[str, tuple[str, tuple[str, ...]]] = field(default_factory=dict)
    page: Callable[[TruthCase], str] | None = None
    further: Callable[[TruthCase, Held], CaseRun] | None = None


TRUTHS = {
    USUAL: Truth(
        "Jig borer in 266 cells",
        0,
        simulate_case,
        jig_borer_effects.catalogue(),
        truth.OUTSIDE,
        further=simulate_further,
    ),
    "belt": Truth(
        "Belt-driven spindle in finite elements, with its owner's page",
        10_000_000,
        belt_case.simulate_case,
        belt_effects.catalogue(),
        belt_effects.OUTSIDE,
        belt_effects.BEYOND,
        {name: (one.kind, one.place) for name, one in MISTAKES.items()},
        belt_case.owners_page,
        belt_case.simulate_further,
    ),
    "lathe": Truth(
        "Whole lathe in fine stretches, with its owner's file in lumps",
        20_000_000,
        lathe_case.simulate_case,
        lathe_effects.catalogue(),
        lathe_effects.OUTSIDE,
        lathe_effects.BEYOND,
        {name: (one.kind, one.place) for name, one in lathe_owner.MISTAKES.items()},
        lathe_case.owners_file,
        lathe_case.simulate_further,
    ),
    "page": Truth(
        "Jig borer in 266 cells, drawn around its page",
        30_000_000,
        simulate_around_page,
        jig_borer_effects.catalogue(),
        truth.OUTSIDE,
        page=owners_page,
    ),
}
"""By name."""
