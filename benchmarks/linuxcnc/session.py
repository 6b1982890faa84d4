"""Operates LinuxCNC in its sandbox: switches it on, homes it, runs programs, causes faults."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.linuxcnc.folder import renamed
from gateway.linuxcnc.modules import linuxcnc_module

HALCMD = "/usr/bin/halcmd"
PATIENCE_S, END_S = 300.0, 30.0
"""How long LinuxCNC may take for one action, and to end, on a busy computer [s]: set on no data."""
STATUS_EVERY_S = 0.02
"""Period of reading its status [s]: set on no data."""


class ControlError(Exception):
    """The control did not do what was requested; the text says what."""


class Session:
    """A running control and its gateway.

    Parameters
    ----------
    folder : Path
        The folder with its INI file.
    gateway : sequence of str
        The command that starts the gateway; empty for none.
    """

    def __init__(self, folder: Path, gateway: Sequence[str] = ()) -> None:
        self.folder, self._gateway_command = folder, list(gateway)
        self.component = "thermal"
        self._gateway: subprocess.Popen[bytes] | None = None
        self._linuxcnc: subprocess.Popen[bytes] | None = None
        self._module: Any = None
        self._output = (folder / "output.txt").open("ab")

    @property
    def has_gateway(self) -> bool:
        """Whether the control has a gateway."""
        return bool(self._gateway_command)

    # Starting and ending

    def start(self) -> None:
        """Start the gateway and LinuxCNC."""
        self.start_gateway()
        environment = {
            "HOME": str(self.folder),
            "PATH": "/usr/bin:/bin:/usr/sbin:/sbin",
            **{name: os.environ[name] for name in ("DISPLAY",) if name in os.environ},
        }
        self._linuxcnc = subprocess.Popen(
            ["/usr/bin/linuxcnc", str(self.folder / "machine.ini")],
            **self._quiet(env=environment),
        )
        self._module = linuxcnc_module("linuxcnc")
        # The control keeps its tools in a file in its home, which its status looks for.
        os.environ["HOME"] = str(self.folder)
        os.environ["INI_FILE_NAME"] = str(self.folder / "machine.ini")
        self.wait(self._ready, "LinuxCNC did not start")
        self.command = self._module.command()

    def _ready(self) -> bool:
        assert self._linuxcnc is not None
        if self._linuxcnc.poll() is not None:
            raise ControlError(f"LinuxCNC ended: see {self.folder}")
        if not (self.folder / "display.pid").exists():
            return False
        with contextlib.suppress(self._module.error):
            self.status = self._module.stat()
            self.status.poll()
            return True
        return False

    def start_gateway(self) -> None:
        """Start the gateway, or start it again."""
        if self._gateway_command:
            self._gateway = subprocess.Popen(self._gateway_command, **self._quiet())

    def _quiet(self, **more: Any) -> dict[str, Any]:
        return {
            "stdin": subprocess.DEVNULL,
            "stdout": self._output,
            "stderr": self._output,
            "cwd": self.folder,
            **more,
        }

    def kill_gateway(self) -> None:
        """End the gateway as a power cut would."""
        assert self._gateway is not None
        self._gateway.kill()
        self._gateway.wait()

    def close(self) -> None:
        """End LinuxCNC and the gateway."""
        with contextlib.suppress(OSError, ValueError):
            os.kill(int((self.folder / "display.pid").read_text()), signal.SIGTERM)
        if self._linuxcnc is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._linuxcnc.wait(END_S)
        if self._gateway is not None:
            self._gateway.terminate()
            self._gateway.wait(END_S)
        self._output.close()

    def wait(self, done: Any, text: str, patience_s: float = PATIENCE_S) -> None:
        """Wait until a condition holds.

        Raises
        ------
        ControlError
            With *text*, if it does not come to hold in time.
        """
        until = time.monotonic() + patience_s
        while not done():
            if time.monotonic() > until:
                raise ControlError(text)
            time.sleep(STATUS_EVERY_S)

    def sleep(self, seconds: float) -> None:
        """Wait for *seconds* of the control's own time [s]."""
        until = self.now() + seconds
        while (left := until - self.now()) > 0.0:
            time.sleep(max(left, STATUS_EVERY_S))

    def now(self) -> float:
        """Return the control's own time, from the thread that moves the axes [s]."""
        return self.pin("spindle-plant.servo_s")

    # HAL

    def hal(self, *words: str) -> str:
        """Run a HAL command; return its output."""
        run = subprocess.run([HALCMD, *words], capture_output=True, text=True, cwd=self.folder)
        if run.returncode:
            raise ControlError(f"halcmd {' '.join(words)}: {run.stderr.strip()}")
        return run.stdout.strip()

    def pin(self, name: str) -> float:
        """Return the value of a pin."""
        return _number(self.hal("getp", name))

    def offset_um(self, axis: str) -> float:
        """Return an axis' distance from its commanded position; at a standstill [um]."""
        return 1e3 * (self.signal(f"motor-{axis}") - self.pin(f"axis.{axis}.pos-cmd"))

    def signal(self, name: str) -> float:
        """Return the value of a signal."""
        return _number(self.hal("gets", name))

    # The control

    def poll(self) -> Any:
        """Return the control's status now."""
        self.status.poll()
        return self.status

    def _tell(self, order: Callable[..., None], *words: object) -> None:
        """Give a command, and wait until the control has received it."""
        order(*words)
        number = self.command.serial
        self.wait(lambda: self.poll().echo_serial_number >= number, "takes no order")

    def switch_on(self) -> None:
        """Release the emergency stop and switch on."""
        m = self._module
        self._tell(self.command.state, m.STATE_ESTOP_RESET)
        self.wait(lambda: self.poll().task_state != m.STATE_ESTOP, "E-stop is not released")
        self._tell(self.command.state, m.STATE_ON)
        self.wait(lambda: self.poll().task_state == m.STATE_ON, "is not switched on")

    def stop(self) -> None:
        """Press the emergency stop."""
        self._tell(self.command.state, self._module.STATE_ESTOP)
        self.wait(lambda: self.poll().task_state == self._module.STATE_ESTOP, "did not stop")

    def _mode(self, mode: int) -> None:
        self._tell(self.command.mode, mode)
        self.wait(lambda: self.poll().task_mode == mode, "did not change its mode")

    def home(self) -> None:
        """Home all axes."""
        self._mode(self._module.MODE_MANUAL)
        self._tell(self.command.teleop_enable, 0)
        self.wait(
            lambda: self.poll().motion_mode == self._module.TRAJ_MODE_FREE, "joints do not move"
        )
        # An earlier homing must not be taken for the new one.
        self._tell(self.command.unhome, -1)
        self.wait(lambda: not any(self.poll().homed[:3]), "stays homed")
        self._tell(self.command.home, -1)
        self.wait(lambda: self.poll().homed[:3] == (1, 1, 1), "is not homed")

    def mdi(self, line: str) -> None:
        """Run one line."""
        self._mode(self._module.MODE_MDI)
        self._tell(self.command.mdi, line)
        self.until_idle(line)

    def begin(self, program: Path) -> None:
        """Begin a program."""
        self._mode(self._module.MODE_AUTO)
        self._tell(self.command.program_open, str(program))
        self._tell(self.command.auto, self._module.AUTO_RUN, 0)

    def abort(self) -> None:
        """Abort the running program."""
        self._tell(self.command.abort)
        self.until_idle("abort")

    def until_idle(self, what: str, patience_s: float = PATIENCE_S) -> None:
        """Wait until the control is idle."""

        def idle() -> bool:
            status = self.poll()
            done = status.state in (self._module.RCS_DONE, self._module.RCS_ERROR)
            return bool(done and status.interp_state == self._module.INTERP_IDLE and status.inpos)

        self.wait(idle, f"{what} did not end", patience_s)

    # The component

    def kill_component(self) -> None:
        """End the component as a crash would."""
        os.kill(self._component_pid(), signal.SIGKILL)

    def _component_pid(self) -> int:
        lines = self.hal("-s", "show", "comp", self.component).split()
        return int(lines[3] if len(lines) > 3 else lines[-1])

    def start_component(self) -> None:
        """Start a new component in place of the killed one."""
        for line in self.hal("-s", "show", "pin", f"{self.component}.").splitlines():
            words = line.split()
            if "==>" in words or "<==" in words:
                self.hal("unlinkp", words[4])
        self.component += "x"
        # It keeps inherited files open, so nothing may wait for the end of a pipe.
        file = str(renamed(self.folder, self.component))
        if subprocess.run([HALCMD, "-f", file], **self._quiet(), check=False).returncode:
            raise ControlError(f"{self.component} does not start: see {self.folder}")


def _number(text: str) -> float:
    return float({"TRUE": "1", "FALSE": "0"}.get(text, text))


@contextlib.contextmanager
def running(folder: Path, gateway: Sequence[str] = ()) -> Iterator[Session]:
    """Run LinuxCNC from a folder, and end it in any case."""
    session = Session(folder, gateway)
    try:
        session.start()
        yield session
    finally:
        session.close()
