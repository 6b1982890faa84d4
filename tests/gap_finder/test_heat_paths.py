"""A heat path that the machine file forgot."""

from dataclasses import replace

import pytest

from gap_finder.find import answer
from gap_finder.search import Search
from plant_model.effects import catalogue
from tests.gap_finder.conftest import runs_of

FORGOTTEN = "front_inner-front_outer"


@pytest.mark.long
def test_a_forgotten_path_is_named_with_where_it_leads_from(jig_borer_lumps):
    without = [name for name in catalogue() if name != "centrifugal_shift"]
    items = tuple(item for item in jig_borer_lumps.items if item.name != FORGOTTEN)
    told = replace(jig_borer_lumps, items=items)
    runs = runs_of(jig_borer_lumps, every_s=60.0)
    judged, _ = answer(told, runs[:3], runs[3:], Search(without, workers=1))
    (key,), (others,) = judged.result.keys, judged.result.search.rivals
    # From the inner ring, or the shaft in it, to what is cooled outside: soft ranges of the other
    # numbers take up so much of it that the runs no longer tell where it ends.
    for name in (key, *(other.keys[0] for other in others)):
        assert name.startswith(("heat_path:front_inner+", "heat_path:shaft_front+"))
    gap = judged.unseen.gap()
    assert gap["after"] < 0.75 * gap["before"]
