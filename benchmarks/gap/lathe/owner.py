"""The file in lumps that the lathe's owner writes, and the mistakes that are in it on purpose.

The owner weighs parts on the drawing, guesses surfaces, takes joints, films and losses from
handbooks with their ranges, and knows nothing of what is hidden.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.gap.case import Mistake
from benchmarks.gap.enclosed import BoltedMass, StirredNut
from benchmarks.gap.hidden import variant
from benchmarks.gap.lathe.machine import RING_J_PER_K
from benchmarks.gap.lathe.numbers import CLASS, COUNTS, TABLES, Drawing
from benchmarks.gap.laws import PartSource
from benchmarks.gap.owner import guesser, told

Table = dict[str, Any]

JOINT, FILM, LOSS = 2.5, 2.0, 2.5
"""Handbook values are good to these factors [1]."""

LUMPS = TABLES["lumps"]
"""By name: bar, from where to where of it [1], and the thermometer at which it starts."""

VALUES = CLASS.nominal()
"""What handbooks say."""


def _number(value: float, unit: str, factor: float, source: str, *, free: bool = False) -> Table:
    ends = {"low": value / factor, "high": value * factor}
    table: Table = {"value": value, "unit": unit, **ends, "source": source}
    return table | ({"calibrate": True} if free else {})


def _exact(value: float, unit: str) -> Table:
    return {"value": value, "unit": unit, "low": value, "high": value, "source": "drawing"}


def file_of(drawing: Drawing, careless: np.random.Generator | None = None) -> Table:
    """Return the file of a lathe, its guesses exact or drawn by *careless*."""
    writer, alike = _Writer(drawing, careless), told(__file__)
    return {
        **alike["head"],
        "numbers": {
            name: _number(VALUES[name], "W/(m2 K)", FILM, "air and radiation", free=True)
            for name in ("hall", "inside")
        },
        "nodes": writer.nodes(),
        "links": writer.links(),
        "sources": writer.sources(),
        "structure": writer.structure(),
        "sensors": [
            {"name": name, "of": node, "noise": 0.05, "resolution": 0.01}
            for name, (*_, node) in TABLES["thermometers"].items()
        ],
        **alike["tail"],
    }


class _Writer:
    """Writes the tables of one lathe."""

    def __init__(self, drawing: Drawing, careless: np.random.Generator | None) -> None:
        self.drawing, self._about = drawing, guesser(careless)
        self._guess = cache(self._guessed)  # Asked twice, the same.

    def _guessed(self, part: str, what: str) -> float:
        """Return a part's mass or surface as the owner takes it."""
        return self._about(float(getattr(self.drawing.parts[part], what)))

    def nodes(self) -> list[Table]:
        """Return the lumps, the rings and the air."""
        found = []
        for name, (part, low, high, start) in LUMPS.items():
            heat = VALUES[f"heat_{self.drawing.parts[part].metal}"]
            capacity = (high - low) * self._guess(part, "mass") * heat
            table = _number(capacity, "J/K", 1.15, "weight on the drawing")
            found.append({"name": name, "capacity": table, "start": start})
        for which, heat in zip(("front", "rear"), RING_J_PER_K, strict=True):
            for ring in ("inner", "outer"):
                capacity = _number(0.5 * heat + 45.0, "J/K", 1.2, "catalogue of bearings")
                found.append({"name": f"{which}_{ring}", "capacity": capacity, "start": which})
        air = _number(VALUES["air_heat"], "J/K", 1.6, "air and sheet metal")
        return [*found, {"name": "inside", "capacity": air, "start": "inside"}]

    def links(self) -> list[Table]:
        """Return joints, paths along bars, and films."""
        found: list[Table] = []

        def join(one: str, other: str, value: float, source: str = "joint") -> None:
            factor, free = (1.25, False) if source == "section" else (JOINT, True)
            table = _number(value, "W/K", factor, source, free=free)
            found.append({"kind": "contact", "between": [one, other], "conductance": table})

        for bar, lumps in (
            ("spindle", ("spindle_front", "spindle_middle", "spindle_rear")),
            ("headstock", ("headstock_front", "headstock_rear")),
            ("bed", ("bed_left", "bed_middle", "bed_right")),
        ):
            for one, other in pairwise(lumps):
                middles = [sum(LUMPS[name][1:3]) / 2.0 for name in (one, other)]
                along = VALUES[f"along_{bar}"] / (middles[1] - middles[0])
                join(one, other, along, "section")
        for i, which in enumerate(("front", "rear")):
            join(f"{which}_inner", f"{which}_outer", COUNTS[i] * VALUES["balls"])
            join(f"{which}_inner", f"spindle_{which}", COUNTS[i] * VALUES["seat_shaft"])
            join(f"{which}_outer", f"headstock_{which}", COUNTS[i] * VALUES["seat"])
            join(f"headstock_{which}", "bed_left", 0.5 * VALUES["foot"])
        for name, (one, other, share) in TABLES["joints"].items():
            join(one, other, VALUES[name] * share)
        return found + self._films()

    def _films(self) -> list[Table]:
        found: list[Table] = []
        for name, (part, low, high, _) in LUMPS.items():
            area = (high - low) * self._guess(part, "surface")
            if not area:
                continue
            if self.drawing.parts[part].air == "hall":
                film = {"number": "hall", "factor": 1.0, "unit": "W/(m2 K)"}
                found.append(_to_hall(name, _number(area, "m2", 1.15, "drawing"), film))
            else:
                film = {"number": "inside", "factor": area, "unit": "W/K"}
                found.append({"kind": "contact", "between": [name, "inside"], "conductance": film})
        walls = _number(VALUES["walls"], "W/(m2 K)", JOINT, "openings and walls", free=True)
        return [*found, _to_hall("inside", _exact(1.0, "m2"), walls)]

    def sources(self) -> list[Table]:
        """Return bearings, motor and feed axes."""
        found = [
            {key: _number(**one) if "factor" in one else one for key, one in source.items()}
            for source in told(__file__)["sources"]
        ]
        for name in ("z_nut", "z_screw", "z_motor", "x_nut", "x_screw", "x_motor"):
            loss = _number(VALUES[f"{name}_loss"], "W/(m/min)", LOSS, "class", free=True)
            feed = {"kind": "feed_axis", "name": name, "node": name, "driven_by": "feed"}
            found.append(feed | {"loss": loss})
        return found

    def structure(self) -> list[Table]:
        """Return what moves tool against work."""
        found = []
        for name, one in sorted(self.drawing.members.items(), key=lambda entry: entry[1].axis):
            metal = self.drawing.parts[one.part].metal
            found.append(
                {
                    "kind": "member",
                    "name": name,
                    "nodes": one.lumps,
                    "length": _number(one.length, "mm", 1.1, "drawing"),
                    "expansion": _number(VALUES[f"alpha_{metal}"], "1e-6/K", 1.2, metal, free=True),
                    one.axis: _exact(one.sign, "1"),
                }
            )
        return found


def _to_hall(name: str, area: Table, film: Table) -> Table:
    return {"kind": "convection", "between": [name, "ambient"], "area": area, "coefficient": film}


def _no_link(one: str, other: str) -> Callable[[Table], None]:
    def edit(table: Table) -> None:
        table["links"] = [link for link in table["links"] if link["between"] != [one, other]]

    return edit


def _no_entry(family: str, name: str) -> Callable[[Table], None]:
    def edit(table: Table) -> None:
        table[family] = [entry for entry in table[family] if entry["name"] != name]

    return edit


def _one_headstock(table: Table) -> None:
    """Write the headstock as one lump, with both of its thermometers on it."""
    halves = ("headstock_front", "headstock_rear")
    first, second = (next(n for n in table["nodes"] if n["name"] == half) for half in halves)
    for key in ("value", "low", "high"):
        first["capacity"][key] += second["capacity"][key]
    table["nodes"].remove(second)
    first["name"] = "headstock"
    _no_link(*halves)(table)
    for entry in table["links"]:
        entry["between"] = ["headstock" if n in halves else n for n in entry["between"]]
    joined: dict[tuple[str, ...], Table] = {}
    for entry in table["links"]:
        same = joined.setdefault((entry["kind"], *entry["between"]), entry)
        for number in ("conductance", "area"):
            if same is not entry and number in entry:
                for key in ("value", "low", "high"):
                    same[number][key] += entry[number][key]
    table["links"] = list(joined.values())
    for entry in table["structure"]:
        entry["nodes"] = list(
            dict.fromkeys("headstock" if n in halves else n for n in entry["nodes"])
        )
    for entry in table["sensors"]:
        entry["of"] = "headstock" if entry["of"] in halves else entry["of"]


TANK = variant(PartSource, "tank", sizes=(80.0, 200.0, 400.0), part="bed", cells=(8,))
"""The tank of the chuck's hydraulics stands in the left of the bed and warms it."""

TOOL_DISK = variant(BoltedMass, "tool_disk", part="slide", conductance=15.0)
"""The disk of the turret hangs on the slide."""

MISTAKES = {
    "no_foot": Mistake("heat_path", ("z_motor", "bed_right"), _no_link("z_motor", "bed_right")),
    "no_guide": Mistake(
        "heat_path", ("carriage", "bed_middle"), _no_link("carriage", "bed_middle")
    ),
    "no_air": Mistake("heat_path", ("z_motor", "ambient"), _no_link("z_motor", "ambient")),
    "no_feed": Mistake("heat_source", ("x_motor", "feed"), _no_entry("sources", "x_motor")),
    "no_screw_heat": Mistake("heat_source", ("z_nut", "feed"), _no_entry("sources", "z_nut")),
    "tank": Mistake("heat_source", ("bed_left",), unsaid=TANK),
    "one_headstock": Mistake("coarse_part", ("headstock",), _one_headstock),
    "tool_disk": Mistake("hidden_mass", ("slide",), unsaid=TOOL_DISK),
    "fanned_nut": Mistake(
        "conductance_with_motion", ("z_nut", "inside", "feed"), unsaid=StirredNut
    ),
    "bad_contact": Mistake("sensor_place", ("slide", "inside"), reads=("slide", "air", 0.4)),
    "no_growth_z": Mistake("moves_axis", ("z_screw", "Z"), _no_entry("structure", "z_screw")),
    "no_growth_x": Mistake("moves_axis", ("slide", "X"), _no_entry("structure", "slide")),
}
"""By name."""
