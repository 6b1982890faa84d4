"""The simulators that judge the gap finder, by name: one folder each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from benchmarks.gap.belt.case import SHOP as BELTS
from benchmarks.gap.belt.effects import BEYOND as BELTS_BEYOND
from benchmarks.gap.case import Shop
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
    first : int
        Its seeds begin this far from those of the first one.
    shop : Shop
        Where no owner writes a file, the shipped machine is asked about.
    beyond : mapping of str to float
        Amplitudes that are larger than usual, of some of the catalogue.
    """

    first: int
    shop: Shop
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
    USUAL: Truth(0, JIG_BORERS),
    "belt": Truth(10_000_000, BELTS, BELTS_BEYOND),
    "lathe": Truth(20_000_000, LATHES, LATHES_BEYOND),
}
"""By name."""
