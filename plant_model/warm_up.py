"""The run that machines are checked with: ISO 230-3, full speed from cold, then a stop."""

from __future__ import annotations

import numpy as np
import pandas as pd

from measurement.iso230 import RUNNING_S, STOPPED_S
from plant_model.anatomy import input_in
from plant_model.machine import Input, Machine
from plant_model.parameters import ROOM_DEGC
from plant_model.rest import at_rest

AVERAGE_FEED = 0.25
"""Highest average feed of an axis, as a share of its highest feed [1]: set on no data."""


def held_at(entry: Input) -> float:
    """Return an input's constant value: 20 degC for temperatures, others as at rest."""
    return min(max(ROOM_DEGC, entry.low), entry.high) if entry.is_boundary else at_rest(entry)


def warm_up(machine: Machine) -> pd.DataFrame:
    """Return inputs every minute: 4 h at the highest speed, then 1 h at rest.

    Temperatures are constant. While the spindle runs, feed axes move at a quarter of their highest
    feed.

    Parameters
    ----------
    machine : Machine
    """
    frame = pd.DataFrame({"time_s": np.arange(0.0, RUNNING_S + STOPPED_S + 1.0, 60.0)})
    # At 4 h the speed is still on: what is shown of that instant is at speed.
    running = frame["time_s"] <= RUNNING_S
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
