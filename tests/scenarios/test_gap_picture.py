"""The picture at the top of the gap finder's page."""

from xml.etree import ElementTree

import pytest

from scenarios.gap_picture import BARS, NAME, REFERENCE, gap_picture


def test_bars_are_as_long_as_the_gap_in_units_of_noise():
    channels = {
        "T1": {"before": 0.4, "after": 0.1, "reference": 0.2, "noise": 0.05},
        "a<b": {"before": 2.0, "after": 4.0, "reference": 1.0, "noise": 1.0},
    }
    root = ElementTree.fromstring(gap_picture(channels))
    texts = [one.text for one in root.iter("text")]
    assert texts[-4:] == ["T1", "8.0 → 2.0", "a<b", "2.0 → 4.0"]
    colours = [colour for _, _, colour in BARS]
    bars = [one for one in root.iter("rect") if one.find("title") is not None]
    assert [one.get("fill") for one in bars] == colours * 2
    wide = [float(one.get("width", 0)) for one in bars]
    assert [one / wide[0] for one in wide] == pytest.approx([1.0, 0.25, 0.25, 0.5], rel=1e-3)
    marks = [one for one in root.iter("line") if one.get("stroke") == REFERENCE]
    first, second = (float(one.get("x1", 0)) - NAME for one in marks)
    assert first / wide[0] == pytest.approx(0.5, rel=1e-3)
    assert second / wide[0] == pytest.approx(0.125, rel=1e-2)
