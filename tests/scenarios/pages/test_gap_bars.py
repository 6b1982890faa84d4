"""The bars at the top of the gap finder's page."""

import re

from scenarios.pages.gap_page import bars
from scenarios.pages.report import page_text

CHANNELS = {
    "T1": {"before": 0.4, "after": 0.1, "reference": 0.2, "noise": 0.05},
    "a<b": {"before": 2.0, "after": 4.0, "reference": 1.0, "noise": 1.0},
}


def test_bars_are_as_long_as_the_gap_in_units_of_noise():
    text = page_text("gap_bars.html", **bars(CHANNELS))
    assert re.findall(r'<div class="(\w+)".*?width: ([\d.]+)%', text) == [
        *(("before", "100.00"), ("after", "25.00")),
        *(("before", "25.00"), ("after", "50.00")),
    ]
    assert re.findall(r"left: ([\d.]+)%", text) == ["50.00", "12.50"], "the reference"
    assert all(shown in text for shown in ("8.0 → 2.0", "2.0 → 4.0", "a&lt;b"))


def test_where_nothing_was_added_there_is_one_bar():
    same = {name: row | {"after": row["before"]} for name, row in CHANNELS.items()}
    text = page_text("gap_bars.html", **bars(same))
    assert (text.count("<div"), "→" in text, "what was added" in text) == (2, False, False)
