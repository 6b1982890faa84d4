"""A reference run of an FMU, in the form required by the FMI cross-check rules.

Run as a separate program, so that the FMU is in a process without this project's modules:
``python reference.py FMU INPUT.csv RESULT.csv STOP STEP``.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

Value = float | tuple[float, ...]
Profile = Callable[[float], Value]

DECIMALS = 6
"""Decimals of a result. Beyond is rounding error, which differs between processors. Set on no
data."""


class RunError(RuntimeError):
    """The FMU failed in its reference run; the text is its output."""


def input_csv(profiles: Mapping[str, Profile], stop_s: float, every_s: float) -> str:
    """Return ``<name>_in.csv``: inputs over time.

    Parameters
    ----------
    profiles : dict of str to callable
        The value of each input at a time [s].
    stop_s, every_s : float
        Length and spacing [s].
    """
    count = round(stop_s / every_s)
    times = [index * every_s for index in range(count + 1)]
    rows: list[list[Value]] = [
        [time, *(profile(time) for profile in profiles.values())] for time in times
    ]
    return csv_text(["time", *profiles], rows)


def csv_text(names: list[str], rows: list[list[Value]]) -> str:
    """Return a table in the cross-check form: quoted names, numbers with all digits.

    The numbers of an array are in one cell, separated by spaces.
    """
    head = ",".join(f'"{name}"' for name in names)
    return "\n".join([head, *(",".join(map(_cell, row)) for row in rows)]) + "\n"


def _cell(value: Value) -> str:
    return " ".join(map(repr, value)) if isinstance(value, tuple) else repr(value)


def _rounded(value: Any) -> Value:
    """Return a rounded real result; adding zero turns -0.0 into 0.0."""
    if getattr(value, "shape", ()):
        return tuple(round(float(element), DECIMALS) + 0.0 for element in value)
    return round(float(value), DECIMALS) + 0.0


def options_text(stop_s: float, step_s: float) -> str:
    """Return ``<name>_ref.opt``."""
    return f"StartTime, 0.0\nStopTime, {stop_s!r}\nStepSize, {step_s!r}\nRelTol, 1e-06\n"


def run_apart(fmu: Path, inputs: str, stop_s: float, step_s: float) -> str:
    """Run an FMU in a fresh process and return ``<name>_ref.csv``.

    Raises
    ------
    RunError
        If it fails or an output is not finite.
    """
    with tempfile.TemporaryDirectory(prefix="fmu_reference_") as folder:
        given, result = Path(folder) / "in.csv", Path(folder) / "ref.csv"
        given.write_text(inputs, encoding="utf-8")
        arguments = [str(fmu.resolve()), str(given), str(result), repr(stop_s), repr(step_s)]
        # -P keeps this folder off the path, -E ignores the user's settings. Unpacked files are
        # removed with the folder, however the process ends.
        done = subprocess.run(
            [sys.executable, "-P", "-E", __file__, *arguments],
            capture_output=True,
            text=True,
            cwd=folder,
            env={**os.environ, "TMPDIR": folder},
            check=False,
        )
        if done.returncode or not result.is_file():
            ended = f"the process ended with code {done.returncode}"
            if done.returncode < 0:
                ended = f"the process crashed: {signal.strsignal(-done.returncode)}"
            raise RunError((done.stderr + done.stdout).strip() or ended)
        return result.read_text(encoding="utf-8")


def _run(fmu: str, given: str, result: str, stop_s: float, step_s: float) -> None:
    import fmpy
    from fmpy.util import read_csv

    description = fmpy.read_model_description(fmu)
    outputs = [
        variable
        for variable in description.modelVariables
        if variable.causality == "output"
        and variable.type not in {"String", "Clock"}
        and not variable.clocks
    ]
    table = read_csv(given)
    arrays = [v for v in description.modelVariables if v.shape and v.causality == "input"]

    def drive(time_s: float, recorder: Any) -> bool:
        # The input of fmpy 0.3.32 does not support arrays together with numbers.
        row = table[(abs(table["time"] - time_s)).argmin()]
        for variable in arrays:
            recorder.fmu.setFloat64([variable.valueReference], row[variable.name].tolist())
        return True

    simulated = fmpy.simulate_fmu(
        fmu,
        stop_time=stop_s,
        output_interval=step_s,
        start_values={variable.name: table[0][variable.name].tolist() for variable in arrays},
        input=table[[n for n in table.dtype.names if n not in {v.name for v in arrays}]],
        output=[variable.name for variable in outputs],
        step_finished=drive,
        debug_logging=True,
    )
    names = list(simulated.dtype.names)
    kinds = {"Real", "Float64"}
    reals = {"time"} | {variable.name for variable in outputs if variable.type in kinds}
    rows = [
        [_rounded(row[name]) if name in reals else int(row[name]) for name in names]
        for row in simulated
    ]
    if len(rows) != round(stop_s / step_s) + 1:
        raise SystemExit(f"the run has {len(rows)} rows")
    bad = [
        name
        for row in rows
        for name, value in zip(names, row, strict=True)
        if not all(map(math.isfinite, value if isinstance(value, tuple) else [value]))
    ]
    if bad:
        raise SystemExit(f"{bad[0]} is not finite")
    Path(result).write_text(csv_text(names, rows), encoding="utf-8")


if __name__ == "__main__":
    _, FMU, GIVEN, RESULT, STOP, STEP = sys.argv
    _run(FMU, GIVEN, RESULT, float(STOP), float(STEP))
