"""The simulators that judge the gap finder, by name: one folder each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from benchmarks.gap.around_page import owners_page, simulate_around_page
from benchmarks.gap.belt.case import SHOP as BELTS
from benchmarks.gap.belt.effects import BEYOND as BELTS_BEYOND
from benchmarks.gap.case import CaseRun, Shop, TruthCase
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.lathe.case import SHOP as LATHES
from benchmarks.gap.lathe.effects import BEYOND as LATHES_BEYOND
from benchmarks.gap.truth.case import SHOP as JIG_BORERS

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
    shop : Shop
    simulate : callable
        From a case to its runs and what is hidden in them.
    page : callable, optional
        From a case to its owner's file; without one the shipped machine is asked about.
    beyond : mapping of str to float
        Amplitudes that are larger than usual, of some of the catalogue.
    """

    title: str
    first: int
    shop: Shop
    simulate: Callable[[TruthCase], tuple[list[CaseRun], list[Hidden]]]
    page: Callable[[TruthCase], str] | None = None
    beyond: Mapping[str, float] = field(default_factory=dict)

    @property
    def catalogue(self) -> dict[str, type[Hidden]]:
        """What it can hide of the product's catalogue, by name."""
        return {n: e for n, e in self.shop.effects().items() if e.catalogued}

    @property
    def outside(self) -> tuple[str, ...]:
        """Names of what it can hide and no catalogue holds."""
        effects = self.shop.effects().items()
        return tuple(name for name, e in effects if not e.catalogued)


TRUTHS = {
    USUAL: Truth("Jig borer in 266 cells", 0, JIG_BORERS, JIG_BORERS.simulate),
    "belt": Truth(
        "Belt-driven spindle in finite elements, with its owner's page",
        10_000_000,
        BELTS,
        BELTS.simulate,
        BELTS.owners_file,
        BELTS_BEYOND,
    ),
    "lathe": Truth(
        "Whole lathe in fine stretches, with its owner's file in lumps",
        20_000_000,
        LATHES,
        LATHES.simulate,
        LATHES.owners_file,
        LATHES_BEYOND,
    ),
    "page": Truth(
        "Jig borer in 266 cells, drawn around its page",
        30_000_000,
        JIG_BORERS,
        simulate_around_page,
        owners_page,
    ),
}
"""By name."""
