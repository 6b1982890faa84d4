"""The simulators that test the gap finder, by name; each has its own folder."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.gap.around_page import SHOP as PAGES
from benchmarks.gap.belt.case import SHOP as BELTS
from benchmarks.gap.case import Shop
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.lathe.case import SHOP as LATHES
from benchmarks.gap.truth.case import SHOP as JIG_BORERS

USUAL = "jig_borer"
"""The default simulator."""


@dataclass(frozen=True)
class Truth:
    """One simulator.

    Attributes
    ----------
    first : int
        Offset of its seeds from those of the default simulator.
    shop : Shop
        If it has no owner's file, the gap finder is given the shipped machine.
    """

    first: int
    shop: Shop

    @property
    def catalogue(self) -> dict[str, type[Hidden]]:
        """Effects of the product's catalogue that it can hide, by name."""
        return {n: e for n, e in sorted(self.shop.effects.items()) if e.catalogued}

    @property
    def outside(self) -> tuple[str, ...]:
        """Names of the effects that it can hide but that are in no catalogue."""
        return tuple(n for n, e in sorted(self.shop.effects.items()) if not e.catalogued)

    @property
    def beyond(self) -> dict[str, float]:
        """Larger than usual amplitudes of some effects of the catalogue."""
        return {n: e.beyond for n, e in self.shop.effects.items() if e.beyond}


TRUTHS = {
    USUAL: Truth(0, JIG_BORERS),
    "belt": Truth(10_000_000, BELTS),
    "lathe": Truth(20_000_000, LATHES),
    "page": Truth(30_000_000, PAGES),
}
"""By name."""
