"""The run by which a machine is looked at: full speed from cold, then a stop."""

from __future__ import annotations

import pandas as pd

from plant_model.anatomy import input_in
from plant_model.machine import Input, Machine
from plant_model.parameters import ROOM_DEGC
from plant_model.rest import at_rest

RUNNING_H, STOPPED_H = 6.0, 2.0
"""How long it runs and stands [h]: set on no data."""
AVERAGE_FEED = 0.25
"""Share of an axis' highest feed, as it moves on average at most [1]: set on no data."""


def held_at(entry: Input) -> float:
    """Return where an input stays: temperatures at 20 degC, the rest at rest."""
    return min(max(ROOM_DEGC, entry.low), entry.high) if entry.is_boundary else at_rest(entry)


def warm_up(machine: Machine, every_s: float = 60.0) -> pd.DataFrame:
    """Return inputs: 6 h at the highest speed, then 2 h at rest; air and coolant stay.

    Feed axes move at a quarter of their highest feed meanwhile, as they do on average at most.

    Parameters
    ----------
    machine : Machine
    every_s : float
        Between rows [s].
    """
    rows = int((RUNNING_H + STOPPED_H) * 3600.0 / every_s) + 1
    frame = pd.DataFrame({"time_s": [every_s * k for k in range(rows)]})
    running = frame["time_s"] < RUNNING_H * 3600.0
    speed = input_in(machine, "rpm")
    feeds = {entry.refs["driven_by"][0] for entry in machine.of_kind("sources", "feed_axis")}
    shares = dict.fromkeys(feeds, AVERAGE_FEED) | ({speed.name: 1.0} if speed else {})
    for entry in machine.inputs:
        still = held_at(entry)
        top = still
        if entry.name in shares:
            top = shares[entry.name] * entry.most
        frame[entry.name] = running.map({True: top, False: still})
    return frame
