"""Runs a piece of Python in a fresh process that knows nothing of this project."""

import json
import sys
from pathlib import Path
from typing import Any

import fmpy

from tests.forked import PRELUDE, forked
from tests.running import output_of

OPENING = """
messages = []

def _log(component, instance, status, category, message):
    messages.append([status, message.decode()])

callbacks = fmi2CallbackFunctions()
callbacks.logger = fmi2CallbackLoggerTYPE(_log)
callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
from fmpy.logging import addLoggerProxy
from ctypes import byref
addLoggerProxy(byref(callbacks))

def opened(path, folder=None, exchange=False, start=0.0):
    description = fmpy.read_model_description(path)
    # Unpacking over a binary that is loaded would end the process.
    if folder is None or not os.path.isdir(folder):
        folder = fmpy.extract(path, unzipdir=folder)
    two = description.fmiVersion == "2.0"
    kinds = (FMU2Slave, FMU2Model) if two else (FMU3Slave, FMU3Model)
    kind = exchange and description.modelExchange or description.coSimulation
    fmu = kinds[exchange](guid=description.guid, unzipDirectory=folder,
                          modelIdentifier=kind.modelIdentifier, instanceName="one")
    fmu.two, fmu.start_s = two, start
    fmu.get, fmu.put = (fmu.getReal, fmu.setReal) if two else (fmu.getFloat64, fmu.setFloat64)
    fmu.whole = fmu.getInteger if two else fmu.getInt32
    reals = [v for v in description.modelVariables if v.type in ("Real", "Float64")]
    fmu.refs = {v.name: v.valueReference for v in description.modelVariables}
    fmu.outs = [v.valueReference for v in reals if v.causality == "output"]
    inputs = [v for v in reals if v.causality == "input"]
    fmu.ins = [v.valueReference for v in inputs if "measured" not in v.name]
    fmu.probed = [v.valueReference for v in inputs if "measured" in v.name]
    if two:
        fmu.instantiate(callbacks=callbacks, loggingOn=True)
        fmu.setupExperiment(startTime=start)
    else:
        fmu.instantiate(loggingOn=True, logMessage=lambda _, status, category, message:
                        messages.append([status, message.decode()]))
    return fmu

def started(fmu, **reals):
    fmu.enterInitializationMode(**({} if fmu.two else dict(startTime=fmu.start_s)))
    fmu.put([fmu.refs[name] for name in reals], list(reals.values()))
    fmu.exitInitializationMode()
    return fmu

def status_of(call, *args):
    try:
        call(*args)
    except FMICallException as error:
        return error.status
    return 0

def show(value):
    print("RESULT" + json.dumps(value))
"""


def apart(code: str, *arguments: object, before: str = "", path: Path | None = None) -> Any:
    """Return what *code* shows, run after the prelude; *before* runs first, *path* is importable.

    The process must end well: a crash in the binary is a failure of the test.
    """
    where = f"import sys; sys.path.insert(0, {str(path)!r})\n" if path else ""
    if path or before:  # as that may change what is imported
        code = where + before + PRELUDE + OPENING + code
        shown = output_of(sys.executable, "-P", "-E", "-c", code, *arguments)
    else:
        done = forked(OPENING + code, arguments)
        assert done.returncode == 0, f"exit code {done.returncode}\n{done.stderr}\n{done.stdout}"
        shown = done.stdout
    lines = [line for line in shown.splitlines() if line.startswith("RESULT")]
    assert lines, shown
    return json.loads(lines[-1].removeprefix("RESULT"))


def variables_of(fmu: Path) -> list[dict[str, Any]]:
    """Return what an FMU's description says of each variable."""
    names = ("name", "type", "valueReference", "causality", "variability", "initial", "unit")
    names += ("displayUnit", "min", "max", "nominal", "start", "description")
    listed = fmpy.read_model_description(str(fmu)).modelVariables
    return [{name: getattr(variable, name) for name in names} for variable in listed]
