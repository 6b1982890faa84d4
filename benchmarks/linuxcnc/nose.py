"""The motion of the spindle nose, from the spindle's drift and the axes' true positions."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.linuxcnc.day import GRID_MM, KNOWN_PLACE, STOPS

AXES = ("x", "y", "z")
NEAR_UM = 300.0
"""An axis further than this from every place of the program is moving [um]: set on the day's own
run."""
LOOKS = 2
"""Number of the component's steps until its pins respond to inputs: set on the day's own run."""


@dataclass(frozen=True)
class Nose:
    """The motion of the nose in a day.

    Attributes
    ----------
    table : DataFrame
        ``servo_s``, the control's own time; ``time_s``, the plant's; ``event``, the number of
        events so far; and for each axis ``drift_X``, ``error_x``, the nose's distance from the
        programmed place (NaN while moving), and ``jump_x``, its motion since the last row although
        the program stood still [um]. ``held``: the nose should be in place, because the feed is
        allowed, offsets are valid and not cleared by the operator, and no soft limit stops the
        axis. ``blind``: offsets are held without a gateway.
    events : list of dict
        The events, each with its ``name``.
    """

    table: pd.DataFrame
    events: list[dict[str, float | str]]

    @property
    def summary(self) -> dict[str, float]:
        """Largest drift, error while held, jump at any time, and offset left after a clear [um]."""
        table = self.table
        held = table[table.held]
        cleared = [
            abs(float(event[axis])) for event in self.events for axis in AXES if axis in event
        ]
        figures = {
            "drift_um": max(float(table[f"drift_{axis.upper()}"].abs().max()) for axis in AXES),
            "error_um": max(float(held[f"error_{axis}"].abs().max()) for axis in AXES),
            "jump_um": max(float(table[f"jump_{axis}"].max()) for axis in AXES),
            "left_after_clear_um": max(cleared, default=float("nan")),
            "hours": float(table.time_s.iloc[-1]) / 3600.0,
            "rest_rows": float(held[f"error_{AXES[-1]}"].notna().sum()),
        }
        blind = table[table.blind][[f"error_{axis}" for axis in AXES]].abs().max().max()
        if blind == blind:
            figures["blind_error_um"] = float(blind)
        return figures


def read_nose(folder: Path, hold_s: float) -> Nose:
    """Read the results of a day from its folder.

    Parameters
    ----------
    folder : Path
        The day's folder.
    hold_s : float
        How long offsets were held without a gateway, in real time [s].
    """
    table = pd.read_csv(folder / "run.csv")
    # The last line may be cut off.
    table = table.dropna(subset=[table.columns[-1]])
    events = json.loads((folder / "events.json").read_text())
    # The velocity is the planner's, and the axes are some cycles behind it.
    rest = (table.velocity == 0.0).rolling(3, center=True).min().eq(1.0) & (table.homed == 1)
    places = {KNOWN_PLACE: 1.0} | dict.fromkeys(STOPS, 0.0)
    marks = pd.Series([1.0, *(places.get(str(event["name"])) for event in events)], dtype=float)
    known = marks.ffill()[table.event.astype(int)].eq(1.0).to_numpy()
    for axis in AXES:
        motor = table[f"motor_{axis}"]
        place = (motor / GRID_MM).round() * GRID_MM
        moved = 1e3 * (motor - place)
        stands = rest & known & (moved.abs() < NEAR_UM)
        same = rest & rest.shift(fill_value=False)
        table[f"error_{axis}"] = (table[f"drift_{axis.upper()}"] + moved).where(stands)
        # A commanded motion is not a jump, nor is an offset absorbed at a standstill.
        step, commanded = motor.diff(), table[f"command_{axis}"].diff(2).fillna(0.0)
        jump = 1e3 * (step - step.clip(commanded.clip(upper=0.0), commanded.clip(lower=0.0))).abs()
        table[f"jump_{axis}"] = jump.where(same)
    recently = table.servo_s.where(table.valid == 1).ffill() >= table.servo_s - hold_s
    looks = table.heartbeat.diff().ne(0.0).cumsum().astype(float)
    away = looks.where(table[["wait", "clear", "limited"]].max(axis=1) == 1)
    near = (looks - away.ffill() <= LOOKS) | (away.bfill() - looks <= LOOKS)
    table["held"] = (table.valid == 1) & ~near
    table["blind"] = recently & (table.valid == 0) & ~near
    return Nose(table, events)
