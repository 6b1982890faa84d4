"""A cycle on the bus and its answer, as messages and as candump prints them."""

from __future__ import annotations

import can

from gateway.codec import Sender, Value
from gateway.database import COMPENSATOR, MACHINE, Database

READINGS = (22.98, 21.12, 21.85, 21.77, 21.0, 22.09, 21.97, 21.9, 21.6, 21.72, 22.05)


def session_lines(database: Database, channel: str = "vcan0") -> list[str]:
    """Return the lines that candump prints for a cycle and its answer."""
    return [
        f"  {channel}  {message.arbitration_id:03X}   [{len(message.data)}]  "
        + " ".join(f"{byte:02X}" for byte in message.data)
        for message in session_messages(database)
    ]


def session_messages(database: Database) -> list[can.Message]:
    """Return the messages of a cycle and its answer."""
    readings: dict[str, Value] = {f"T{n}": value for n, value in enumerate(READINGS, 1)}
    readings |= {"speed": 4000.0, "tool_length": 100.0, "offset_use": "following"}
    readings["thermal_state"] = "warm"
    readings |= {"machine_state": "running", "machine_time": 1200.0, "machine_step": 0.1}
    answer: dict[str, Value] = {"dX": -1.7, "dY": -2.26, "dZ": 6.42, "valid": "valid"}
    answer |= {"elongation": 6.42, "yaw": 14.32, "pitch": 10.84, "status": "ok"}
    for axis, slope in (("X", -14.32), ("Y", -10.84), ("Z", 0.0)):
        answer[f"d{axis}_at_tool_length"] = answer[f"d{axis}"]
        answer |= {f"d{axis}_per_tool_length": slope, f"d{axis}_tool_length": 100.0}
    answer |= {"challenge": 0x4F1C2A73, "freshness": "proven"}
    answer |= {"gateway_state": "running", "status_sensor": 0.0, "bus_fault": "none"}
    # The answer names the time that it answers by the low 16 bits of its milliseconds.
    answer |= {"bus_fault_frame": 0.0, "answered_time": (1_200_000 % 65536) / 1e3}
    return [
        *Sender(database, MACHINE).messages(readings, 0x5D03917B),
        *Sender(database, COMPENSATOR).messages(answer),
    ]
