"""Scenario files: what is read, and that anything wrong is one line."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.errors import BadInput
from scenarios.scenario import Scenario, read_scenario, scenario_from_text
from tests.mangling import JUNK, mangled, places

TEXT = """
format = 1
name = "small"
title = "A small one"
duration_s = 20
record_s = 2

[plant]
fmu = "p.fmu"
parameters = { "links.front.conductance" = 3.0 }

[compensator]
tool_length_mm = 0.0

[signals]
ambient = 20.0
speed = { kind = "steps", times_s = [0, 10], values = [0, 1000] }

[[faults]]
sensor = "T1"
kind = "missing"
start_s = 5

[[variants]]
name = "one"
title = "One"

[[variants]]
name = "two"
set = { "compensator.enabled" = false, "signals.speed" = 500, "plant.parameters.a.b" = 1 }
"""
PATH = Path("small.toml")


def read(text: str = TEXT, *overrides: tuple[str, Any]) -> Scenario:
    return scenario_from_text(text, PATH, overrides)


def test_variants_change_only_what_they_name():
    one, two = read().cases
    assert (one.name, one.title) == ("one", "One")
    assert (two.name, two.title) == ("two", "two")
    assert one.settings.compensator.enabled
    assert not two.settings.compensator.enabled
    assert two.settings.compensator.tool_length_mm == 0.0
    assert one.signals["speed"].kind == "steps"
    assert two.signals["speed"].kind == "constant"
    assert two.settings.plant.parameters == {"links.front.conductance": 3.0, "a.b": 1.0}
    assert one.settings.plant.parameters == {"links.front.conductance": 3.0}


def test_overrides_reach_every_variant_unless_it_says_otherwise():
    one, two = read(TEXT, ("duration_s", 40), ("compensator.enabled", True)).cases
    assert (one.settings.steps, two.settings.steps) == (40, 40)
    assert one.settings.compensator.enabled
    assert not two.settings.compensator.enabled


def test_an_override_that_every_variant_sets_again_is_refused():
    both = TEXT + '\n[[variants]]\nname = "three"\nset = { "signals.speed" = 700 }\n'
    only = both.replace('name = "one"', 'name = "one"\nset = { "signals.speed" = 600 }')
    read(both, ("signals.speed", 900))
    with pytest.raises(BadInput, match=r"signals\.speed' has no effect: every variant sets it"):
        read(only, ("signals.speed", 900))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("format = 1", "format = 2", "small.toml: format: 2 is not allowed"),
        ('name = "small"', "", "small.toml: name: is missing"),
        ("duration_s = 20", "duration_s = 20.5", "small.toml: duration_s, 20.5, must be"),
        ("duration_s = 20", "duration_s = -1", "duration_s: -1"),
        ("duration_s = 20", "duration_s = true", "duration_s: True"),
        ("duration_s = 20", "duration_s = 1e8", "more than 1000000 steps"),
        ("record_s = 2", "record_s = 1.5", "record_s, 1.5, must be a multiple"),
        ("record_s = 2", "recordings = 2", "recordings: is not a known field"),
        ('kind = "missing"', 'kind = "lost"', "faults, item 1, kind: 'lost'"),
        ("ambient = 20.0", "ambient = nan", "signals.ambient.value: nan"),
        ('name = "two"', 'name = "one"', "two variants have the same name"),
        ('"compensator.enabled" = false', '"compensator.enable" = false', r"two\): compensator"),
        ('"signals.speed" = 500', '"signals.speed" = "fast"', r"two\): signals.speed: 'fast'"),
        ('"signals.speed" = 500', '"name" = "x"', "cannot differ between variants"),
        ('"signals.speed" = 500', '"duration_s.x" = 1', "does not name a key"),
        ("[plant]", "[plant", "is not TOML"),
        ("[[faults]]", "[replay]\n[[faults]]", "faults: has no meaning beside"),
    ],
)
def test_a_mistake_is_one_line_that_names_the_place(old, new, message):
    assert old in TEXT
    text = TEXT.replace(old, new, 1)
    if "replay" in new:
        text = text[: text.index("[plant]")] + text[text.index("[replay]") :]
        text = text[: text.index("[[variants]]")]
    with pytest.raises(BadInput, match=message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


def test_a_folder_or_a_binary_file_is_refused(tmp_path):
    with pytest.raises(BadInput, match="neither a file nor"):
        read_scenario(tmp_path)
    (tmp_path / "b.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(BadInput, match="cannot be read"):
        read_scenario(tmp_path / "b.toml")


TABLE = tomllib.loads(TEXT)


def as_toml(value: object) -> str:
    """Write a table as TOML: inline, so that any shape can be written."""
    if isinstance(value, dict):
        inner = ", ".join(f"{as_toml(str(key))} = {as_toml(entry)}" for key, entry in value.items())
        return "{" + inner + "}"
    if isinstance(value, list):
        return "[" + ", ".join(as_toml(entry) for entry in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + "".join(f"\\U{ord(char):08x}" for char in value) + '"'
    return "[]" if value is None else repr(value)


def refusal_of(text: str, *overrides: tuple[str, Any]) -> str | None:
    """Return the one line of a refusal, or None for a scenario that can be read."""
    try:
        read(text, *overrides)
    except BadInput as error:
        lines = str(error).splitlines()
        return lines[0] if len(lines) == 1 else ""
    return None


@given(place=st.sampled_from(list(places(TABLE))), odd=JUNK)
def test_any_mangled_field_is_read_or_refused_in_one_line(place, odd):
    table = mangled(TABLE, place, odd)
    text = "\n".join(f"{as_toml(key)} = {as_toml(value)}" for key, value in table.items())
    refusal = refusal_of(text)
    assert refusal is None or refusal.startswith("small.toml")


@given(st.text(max_size=200))
def test_any_text_is_refused_in_one_line(text):
    with pytest.raises(BadInput) as caught:
        read(text)
    assert "\n" not in str(caught.value)


@given(key=st.text(max_size=20), value=JUNK)
def test_any_override_is_taken_or_refused_in_one_line(key, value):
    refusal = refusal_of(TEXT, (key, value))
    assert refusal is None or refusal.startswith("small.toml")
