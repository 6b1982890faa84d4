"""The gateway's answer: the compensator's outputs, and what is sent with them."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan

from gateway.codec import Value
from measurement.rig import AXES


def by_tool_length(outputs: Mapping[str, float], tool_length_mm: float) -> dict[str, Value]:
    """Return per axis the offset [um], its change with the tool length [um/m], and that [mm].

    Over the tool length the offset of an axis changes by the tilt, with the opposite sign;
    1 urad is 1 um/m. Z does not depend on it, to second order.

    Parameters
    ----------
    outputs : mapping of str to float
        Those of the compensator [um, urad].
    tool_length_mm : float
        At which they hold [mm].
    """
    slopes = {"X": -outputs.get("yaw", nan), "Y": -outputs.get("pitch", nan), "Z": 0.0}
    values: dict[str, Value] = {}
    for axis in AXES:
        values[f"d{axis}_at_tool_length"] = outputs.get(f"d{axis}", nan)
        values[f"d{axis}_per_tool_length"] = slopes[axis]
        values[f"d{axis}_tool_length"] = tool_length_mm
    return values


def half_widths(outputs: Mapping[str, float], *, known: bool) -> dict[str, Value]:
    """Return the uncertainty of each axis [um]; NaN where nothing bounds it.

    Parameters
    ----------
    outputs : mapping of str to float
        Those of the compensator; it gives -1 for what it does not know [um].
    known : bool
        Whether it is known what the drift is counted from.
    """
    names = [f"d{axis}_uncertainty" for axis in AXES]
    widths = {name: outputs.get(name, nan) if known else nan for name in names}
    return {name: width if width >= 0.0 else nan for name, width in widths.items()}
