"""Applies a map to a control's DBC file: frames and signals under the gateway's own names.

It lists every problem, not only the first, so that whoever writes a map can fix them all at once.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from typing import Any

from cantools.database.can import Database as CanDatabase
from cantools.database.can import Message

from gateway.database import (
    COMPENSATOR,
    CYCLE,
    MACHINE,
    Database,
    Frame,
    Signal,
    Substitute,
)
from gateway.dbc import DBC, attribute, load_dbc
from gateway.mapcheck import NEEDED, check_frames
from gateway.mapfile import (
    HOLD,
    MISSING,
    FrameMap,
    InputMap,
    MapFile,
    OutputMap,
    read_form,
)
from gateway.mapped_signals import mapped_signal, plain_signal, protection_of
from gateway.probes import PROBE_TIME
from gateway.protection import PROFILE_1
from measurement.errors import BadInput, checked
from scenarios.wiring import PROBED

CLASSIC = 8
"""Largest number of bytes in a frame without CAN FD: given by ISO 11898-1."""
LENGTHS = (*range(1, CLASSIC + 1), 12, 16, 20, 24, 32, 48, 64)
PROTECTION = ("crc", "counter", CYCLE)
"""The protecting signals of a frame of the gateway's own form."""


@dataclass
class Mapping:
    """A map applied to its DBC file.

    Attributes
    ----------
    path : Path
        The map.
    form : MapFile
        Its content.
    database : Database
        The frames and signals without problems.
    problems : list of BadInput
        One for each reason why the rest does not fit; empty if the map can be used.
    """

    path: Path
    form: MapFile
    database: Database
    problems: list[BadInput] = field(default_factory=list)

    def say(self, place: str, problem: str) -> None:
        """Note a problem; the same problem at several places is noted once.

        Parameters
        ----------
        place : str
            The key of the map.
        problem : str
            What is wrong with it.
        """
        if self.is_own_form:  # there is no map, so do not name its sections
            place = place.partition(".")[2] or place
        for number, other in enumerate(self.problems):
            if other.problem == problem:
                self.problems[number] = BadInput(self.path, f"{other.place}, {place}", problem)
                return
        self.problems.append(BadInput(self.path, place, problem))

    @property
    def is_own_form(self) -> bool:
        """Whether this is a DBC file of the gateway's own form, without a map."""
        return self.path == self.database.path

    def unprotected(self) -> list[str]:
        """Return a line for each frame of the machine whose faults cannot all be detected."""
        lacks = {
            "none": "has no protection: stuck, repeated and replaced frames are not detected",
            "partly": "has a check value or a counter, not both: not all faults are detected",
        }
        return [
            f"{frame.name} {lacks[frame.protection.trust]}"
            for frame in self.database.of(MACHINE)
            if frame.protection.trust in lacks
        ]


def read_mapping(path: Path) -> Mapping:
    """Read a map and the DBC file that it names, from the map's folder.

    Parameters
    ----------
    path : Path
        The map.

    Returns
    -------
    Mapping
        The result; what does not fit is in its ``problems``.

    Raises
    ------
    BadInput
        If either file cannot be read.
    """
    form = read_form(MapFile, path)
    dbc = path.parent / form.dbc
    return mapping_of(path, form, load_dbc(dbc), dbc)


def read_own_form(path: Path = DBC) -> Mapping:
    """Read a DBC file of the gateway's own form, like a map that keeps every signal's name.

    Every frame is sent by MACHINE or COMPENSATOR and protected by E2E profile 1, and each node's
    frames form complete cycles.

    Parameters
    ----------
    path : Path, optional
        By default the file that ships.

    Returns
    -------
    Mapping
        Without problems.

    Raises
    ------
    BadInput
        If it cannot be read, or lacks something that the gateway needs (only the first is named).
    """
    dbc = load_dbc(path)
    ways = {MACHINE: "inputs", COMPENSATOR: "outputs"}
    table: dict[str, Any] = {"format": 1, "dbc": path.name, "cycle": {"frames": "together"}}
    table |= {"frames": {}, "inputs": {}, "outputs": {}}
    for message in dbc.messages:
        senders = [name for name in message.senders if name in ways]
        if len(senders) != 1:
            raise BadInput(path, message.name, f"must be sent by {MACHINE} or by {COMPENSATOR}")
        table["frames"][message.name] = {"protection": PROFILE_1}
        places = table[ways[senders[0]]]
        for signal in message.signals:
            if signal.name not in PROTECTION:
                places.setdefault(signal.name, []).append(f"{message.name}.{signal.name}")
    for sender, way in ways.items():
        if not table[way]:
            raise BadInput(path, "", f"holds no signal that {sender} sends: is the file whole?")
    mapping = mapping_of(path, checked(MapFile, table, path), dbc, path)
    for problem in mapping.problems:
        raise problem
    return mapping


def read_database(path: Path = DBC) -> Database:
    """Return the frames of a DBC file of the gateway's own form; see `read_own_form`."""
    return read_own_form(path).database


def mapping_of(path: Path, form: MapFile, dbc: CanDatabase, dbc_path: Path) -> Mapping:
    """Apply a map to a DBC file, both read already; see `read_mapping`."""
    return _Reader(path, form, dbc, dbc_path).read()


class _Reader:
    def __init__(self, path: Path, form: MapFile, dbc: CanDatabase, dbc_path: Path) -> None:
        self.form, self.dbc = form, dbc
        self.messages = {message.name: message for message in dbc.messages}
        self.every_s = form.cycle.every_ms and form.cycle.every_ms / 1e3
        rate = form.bit_rate or int(attribute(dbc.dbc, "Baudrate", 500_000))
        self.found = Mapping(path, form, Database(dbc_path, (), rate, self.every_s))
        self.say = self.found.say
        self._used: dict[str, str] = {}
        self._signals: dict[str, tuple[str, dict[str, Signal]]] = {}

    def read(self) -> Mapping:
        substitutes: dict[str, Substitute] = {}
        for name, spec in self.form.inputs.items():
            place = f"inputs.{name}"
            if substitute := self._substitute(place, name, spec):
                substitutes[name] = substitute
            if len(wanted := spec.places) > 1:
                self.say(place, f"has two signals: {wanted[0]} and {wanted[1]}")
            self._take(place, MACHINE, name, spec)
        for name, output in self.form.outputs.items():
            self._take(f"outputs.{name}", COMPENSATOR, name, output)
        frames: list[Frame] = []
        for name, (node, signals) in self._signals.items():
            with self._telling(f"frames.{name}"):
                if name not in self.form.frames:
                    raise _refused('is missing: state the protection, "none" if there is none')
                if signals:
                    frames.append(self._frame(name, node, signals))
        for name in self.form.frames:
            if name not in self._signals:
                self.say(f"frames.{name}", "is not needed: the map uses no signal of it")
        self.found.database = replace(
            self.found.database,
            frames=tuple(sorted(frames, key=lambda frame: frame.key)),
            substitutes=substitutes,
            when_invalid=self._when_invalid(),
        )
        check_frames(self.found)
        return self.found

    @contextlib.contextmanager
    def _telling(self, place: str) -> Iterator[None]:
        """Note a `BadInput` as a problem at a place, and go on."""
        try:
            yield
        except BadInput as error:
            self.say(place, str(error))

    # Signals

    def _take(self, place: str, node: str, name: str, spec: InputMap | OutputMap) -> None:
        for wanted in spec.places:
            with self._telling(place):
                self._take_one(place, node, name, spec, wanted)

    def _take_one(
        self, place: str, node: str, name: str, spec: InputMap | OutputMap, wanted: str
    ) -> None:
        frame, _, signal_name = wanted.partition(".")
        if frame not in self.messages:
            raise _refused(f"{self.form.dbc} has no frame {frame}")
        in_frame = {signal.name: signal for signal in self.messages[frame].signals}
        if signal_name not in in_frame:
            raise _refused(f"{frame} has no signal {signal_name} in {self.form.dbc}")
        if wanted in self._used:
            raise _refused(f"{wanted} is {self._used[wanted]} already")
        self._used[wanted] = place
        owner, signals = self._signals.setdefault(frame, (node, {}))
        if owner != node:
            raise _refused(f"{frame} holds inputs and outputs: a frame has one sender")
        if name in signals:
            raise _refused(f"has two signals in {frame}")
        signals[name] = mapped_signal(name, spec, in_frame[signal_name])

    def _substitute(self, place: str, name: str, spec: InputMap) -> Substitute | None:
        substitute = None
        if isinstance(spec.constant, str):
            if (name, spec.constant) != ("machine_state", "running"):
                self.say(place, f"constant {spec.constant!r} is not allowed: a number")
        elif spec.constant is not None:
            substitute = Substitute(spec.constant)
        elif spec.when_missing == HOLD:
            substitute = Substitute(None, spec.hold_s or 0.0)
        elif not isinstance(spec.when_missing, str):
            substitute = Substitute(float(spec.when_missing))
        if substitute and name in NEEDED[MACHINE]:
            self.say(place, "cannot be replaced by a number: it says what the machine does")
        return substitute

    def _when_invalid(self) -> dict[str, float]:
        values = {}
        for name, spec in self.form.outputs.items():
            if spec.when_invalid == MISSING:
                values[name] = float("nan")
                if spec.missing_raw is None:
                    self.say(f"outputs.{name}", 'when_invalid = "missing" needs missing_raw')
            elif not isinstance(spec.when_invalid, str | None):
                values[name] = float(spec.when_invalid)
        return values

    # Frames

    def _frame(self, name: str, node: str, signals: dict[str, Signal]) -> Frame:
        message, form = self.messages[name], self.form.frames[name]
        fd = self.form.data_bit_rate is not None
        if not fd and (message.is_fd or message.length > CLASSIC):
            raise _refused(f"{message.length} bytes: a frame of CAN FD needs data_bit_rate")
        if message.length not in LENGTHS:
            raise _refused(f"{message.length} bytes: is not a length that frames can have")
        together = self.every_s is None
        if together and message.is_multiplexed():
            raise _refused('multiplexed: needs frames = "sampled"')
        protection = protection_of(message, form)
        places = {signal.name: signal for signal in message.signals}
        cycle = (form.cycle or CYCLE) if together else ""
        if cycle and cycle not in places:
            raise _refused(f"cycle: there is no signal {cycle}: all frames share a count")
        mapped = [signal.key for signal in signals.values()]
        reserved = {*protection.signals, *([cycle] if cycle else [])}
        for clash in filter(reserved.__contains__, mapped):
            raise _refused(f"{clash}: belongs to the protection and cannot be mapped, too")
        event = all(name == PROBE_TIME or name.startswith(PROBED) for name in signals)
        fixed, late_s = _fixed(message, form, {*mapped, *reserved}), self._late(message, form, node)
        if event and not together:
            raise _refused('probes: cannot be sent with frames = "sampled"')
        cycle_s = (message.cycle_time or 0) / 1e3
        if node == COMPENSATOR and self.every_s is not None:
            cycle_s = self.every_s
        return Frame(
            message.name,
            node,
            message.comment or "",
            message.frame_id,
            cycle_s=inf if event else cycle_s or inf,
            timeout_s=late_s,
            signals=signals,
            cycles=1 << (places[cycle].length if cycle else 0),
            message=message,
            protection=protection,
            cycle=cycle,
            extended=bool(message.is_extended_frame),
            fixed=fixed,
            multiplexer=_multiplexer(message),
            event=event,
            fd=fd,
        )

    def _late(self, message: Message, form: FrameMap, node: str) -> float:
        if isinstance(form.late_after_ms, str):
            return inf
        late_ms = form.late_after_ms or attribute(message.dbc, "E2ETimeout", 0.0)
        if late_ms <= 0.0 and node == COMPENSATOR and self.every_s is not None:
            late_ms = 5e3 * self.every_s
        if late_ms <= 0.0:
            raise _refused("late_after_ms: is missing: silence after which the frame is late")
        return late_ms / 1e3


def _refused(problem: str) -> BadInput:
    """Return a problem whose place is named by the code that catches it."""
    return BadInput("", "", problem)


def _fixed(message: Message, form: FrameMap, taken: set[str]) -> dict[str, float]:
    others = {s.name: s for s in message.signals if s.name not in taken}
    for name in form.fill:
        if name not in others:
            raise _refused(f"fill.{name}: is not an unused signal of this frame")
    numbered = sorted({page for signal in message.signals for page in signal.multiplexer_ids or ()})
    raw_values = {}
    for name, signal in others.items():
        pages = numbered if signal.is_multiplexer else []
        start = signal.raw_initial or 0
        raw = form.fill.get(name, pages[0] if pages and start not in pages else start)
        plain = plain_signal(name, signal)
        held = plain.held(raw)
        if held is None or (pages and held not in pages):
            allowed = ", ".join(map(str, pages)) or f"{plain.low:.0f} to {plain.high:.0f}"
            raise _refused(f"fill.{name}: {raw:g} is not allowed: {allowed}")
        raw_values[name] = held
    return raw_values


def _multiplexer(message: Message) -> str:
    names = [signal.name for signal in message.signals if signal.is_multiplexer]
    if len(names) > 1:
        raise _refused(f"{names[1]}: is a second multiplexer, which is not supported")
    return names[0] if names else ""
