"""Pieces of Python in processes that know fmpy and nothing of this project.

A server has imported fmpy and forks for each piece, so that a piece does not wait for the import.
"""

import atexit
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from tests.patience import PATIENCE_S

PRELUDE = """
import json, os, sys
import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (FMU2Model, FMU2Slave, fmi2CallbackAllocateMemoryTYPE,
                       fmi2CallbackFreeMemoryTYPE, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE)
from fmpy.fmi3 import FMU3Model, FMU3Slave
"""

SERVER = """
import signal
for line in sys.stdin:
    task = json.loads(line)
    if not (child := os.fork()):
        signal.alarm(task["patience_s"])
        for number, place in enumerate((os.devnull, task["said"], task["warned"])):
            os.dup2(os.open(place, os.O_RDWR), number)
        os.chdir(task["folder"])
        os.environ.clear()
        os.environ.update(task["environment"])
        sys.argv[1:] = task["arguments"]
        exec(task["code"])
        break
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@cache
def server() -> subprocess.Popen[str]:
    """Start the server, which ends with this process."""
    command = [sys.executable, "-P", "-E", "-c", PRELUDE + SERVER]
    started = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(started.communicate)
    return started


def forked(
    code: str, arguments: Sequence[object], folder: object = ".", environment: Any = os.environ
) -> subprocess.CompletedProcess[str]:
    """Run a piece of Python as a script with arguments, in a folder and an environment."""
    with tempfile.TemporaryDirectory() as name:
        said, warned = Path(name) / "said", Path(name) / "warned"
        said.touch(), warned.touch()
        task = {
            "code": code,
            "arguments": [str(one) for one in arguments],
            "folder": str(Path(str(folder)).resolve()),
            "environment": dict(environment),
            "said": str(said),
            "warned": str(warned),
            "patience_s": int(PATIENCE_S),
        }
        pipes = server()
        assert pipes.stdin
        assert pipes.stdout
        print(json.dumps(task), file=pipes.stdin, flush=True)
        ended = int(pipes.stdout.readline())
        return subprocess.CompletedProcess(code, ended, said.read_text(), warned.read_text())
