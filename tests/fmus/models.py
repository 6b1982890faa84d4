"""Compensator files made by hand for these tests, and a run of their FMUs."""

import inspect
import math
from typing import Any

from fmu_compensator.runtime.modelfile import model_text
from tests.fmu_compensator.gaussians import knows_nothing

TARGETS = ("elongation", "yaw", "pitch", "near_x", "near_y")


def five_point_table(sensors: int = 11, gain: float = 1.0) -> dict[str, Any]:
    """Return a compensator file of T1.. with a five-point rig: T1 and T4 are chosen.

    Elongation is 2 *gain* um per kelvin of T1 and 1 *gain* of T4, and so on, see the coefficients.
    """
    weights = [[2.0, 1.0], [1.5, -0.5], [0.5, 0.25], [0.4, 0.1], [-0.3, 0.2]]
    return {
        "format": 4,
        "kind": "spindle-drift compensator",
        "name": f"by_hand_{gain:g}".replace(".", "_"),
        "title": "Numbers made by hand",
        "created": None,
        "sensors": [
            {
                "name": f"T{number}",
                "unit": "degC",
                "low": -20.0,
                "high": 120.0,
                "rate_per_s": 2.0,
                "noise": 0.5,
                "stale_after_s": None,
                "trained_low": -2.0,
                "trained_high": 20.0,
            }
            for number in range(1, sensors + 1)
        ],
        "chosen": ["T1", "T4"],
        "input_form": "rise",
        "error_model": {
            "kind": "mlr",
            "targets": list(TARGETS),
            "intercept": [0.0] * len(TARGETS),
            "coefficients": [[gain * weight for weight in row] for row in weights],
        },
        "geometry": {
            "kind": "five_point",
            "form": "rigid",
            "near_to_gauge_mm": 30.0,
            "spacing_mm": 100.0,
        },
        "limits": {
            "offset_um": 200.0,
            "slew_um_per_s": 1.0,
            "hold_s": 30.0,
            "recover_s": 5.0,
            "tool_length_mm": [0.0, 400.0],
        },
        "gaussian": knows_nothing(len(TARGETS)) | {"walk_per_h": 0.25},
        "spare": None,
        "provenance": {"runs": [], "options": {}, "figures": {}, "notes": []},
    }


def five_point_text(sensors: int = 11, gain: float = 1.0) -> str:
    """Return the file's text."""
    return model_text(five_point_table(sensors, gain))


def inputs(k: int) -> list[float]:
    """Return what all sensors, the speed and the tool length are in a step, some of it wrong."""
    values = [20.0 + (n + 1) * 0.01 * k for n in range(11)]
    if 40 <= k < 80:
        values[3] = math.nan
    if k == 100:
        values[0] = math.inf
    return [*values, 3000.0, 120.0 if k < 140 else 1e300]


RUN = f"""
import math
{inspect.getsource(inputs)}

def row(fmu):
    (text,) = fmu.getString([fmu.refs["status_text"]])
    return [*fmu.get(fmu.outs), *fmu.whole([fmu.refs["status"], fmu.refs["status_sensor"]]),
            *fmu.getBoolean([fmu.refs["valid"]]), text.decode() if fmu.two else text]

def steps(fmu, first, count):
    rows = []
    for k in range(first, first + count):
        fmu.put(fmu.ins, inputs(k))
        fmu.doStep(float(k), 1.0)
        rows.append(row(fmu))
    return rows
"""
"""For `apart`."""
