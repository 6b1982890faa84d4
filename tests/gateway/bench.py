"""A gateway on the bench: its frames in the tests' hands, and its time too."""

from collections.abc import Callable, Iterable, Mapping

import can
from cantools.database.can import Message

from gateway.codec import Sender, Value
from gateway.database import COMPENSATOR, MACHINE, Database, Frame
from gateway.node import GatewayNode, GatewaySettings
from gateway.proof import ECHO_BITS, proof_of
from gateway.state import Saved
from gateway.unit import CompensatorUnit

WARM = {"T1": 24.0, "T4": 26.0}
"""What moves the offsets of the bench's compensator, which uses T1 and T4."""


def told_by_machine(state: str, time_s: float, step_s: float) -> dict[str, Value]:
    """Return what a machine at 20 degC tells in a cycle."""
    told: dict[str, Value] = {f"T{n}": 20.0 for n in range(1, 12)}
    told |= {"speed": 3000.0, "tool_length": 150.0, "offset_use": "following"}
    told |= {"thermal_state": "cold", "machine_state": state}
    return told | {"machine_time": time_s, "machine_step": step_s}


class Bench:
    """A gateway node with a real compensator FMU, a made-up clock and no bus.

    Attributes
    ----------
    answers : list of dict
        What the gateway has sent, a dict of values and names per answer, decoded by cantools.
    """

    def __init__(
        self,
        database: Database,
        unit: CompensatorUnit,
        settings: GatewaySettings | None = None,
        warm: Saved | None = None,
    ) -> None:
        self.database, self.unit, self.now = database, unit, 1000.0
        self.wall_ahead_s = 1e9
        self.answers: list[dict[str, float | str]] = []
        self.said: list[str] = []
        self.sender = Sender(database, MACHINE)
        self.time_s = 0.0
        self.step_s = 0.1
        self.challenge: int | None = None
        unit.start(warm)
        self.settings = settings or GatewaySettings()
        self.node = GatewayNode(
            *(database, unit, self._take, self.settings, self.now, warm, self.said.append),
            lambda: self.now,
            lambda: self.now + self.wall_ahead_s,
        )
        self.began: float | None = None

    def _take(self, messages: Iterable[can.Message]) -> None:
        found: dict[str, float | str] = {}
        frames = {frame.frame_id: frame for frame in self.database.of(COMPENSATOR)}
        for message in messages:
            found |= decoded(frames[message.arbitration_id].message, message)
        self.answers.append(found)
        if isinstance(heard := found.get("challenge"), int):
            self.challenge = heard

    @property
    def last(self) -> dict[str, float | str]:
        """The newest answer."""
        return self.answers[-1]

    @property
    def offsets(self) -> tuple[float, float, float]:
        """The offsets of the newest answer [um]."""
        return tuple(self.last[f"d{axis}"] for axis in "XYZ")

    def frames(
        self, values: Mapping[str, Value] | None = None, state: str = "running"
    ) -> list[can.Message]:
        """Return the machine's messages of the next cycle."""
        step_s = self.step_s if state == "running" else 0.0
        if state == "running" and not self.settings.machine_clock:
            self._keep_time()
        told = {**told_by_machine(state, self.time_s, step_s), **(values or {})}
        self.time_s = round(self.time_s + step_s, 3)
        return self.sender.messages(told, self.challenge)

    def _keep_time(self) -> None:
        """The machine's clock goes on while it is not heard: leave cycles out to catch up."""
        step_s = self.step_s = 0.1 * self.settings.speed_up
        if self.began is None:
            self.began = self.now - self.time_s / self.settings.speed_up
        behind_s = (self.now - self.began) * self.settings.speed_up - self.time_s
        self.time_s = round(self.time_s + max(int(behind_s / step_s + 1e-6), 0) * step_s, 3)

    def give(self, messages: Iterable[can.Message], after_s: float = 0.1) -> None:
        """Let *after_s* go by, ticks included, then hand over messages."""
        self.wait(after_s)
        for message in messages:
            self.node.handle(message, self.now)

    def wait(self, seconds: float) -> None:
        """Let time go by; the node gets its ticks."""
        until = self.now + seconds
        while self.node.deadline() <= until:
            self.now = max(self.now, self.node.deadline())
            self.node.tick(self.now)
        self.now = until

    def cycle(
        self,
        values: Mapping[str, Value] | None = None,
        change: Callable[[list[can.Message]], list[can.Message]] | None = None,
    ) -> dict[str, float | str]:
        """Run one cycle, changed on its way if asked for, and return the answer."""
        messages = self.frames(values)
        if change is not None:
            messages = change(messages)
            if getattr(change, "by_sender", False):
                messages = proven(self.database, messages, self.challenge)
        self.give(messages)
        return self.last

    def cycles(
        self,
        count: int,
        values: Mapping[str, Value] | None = None,
        change: Callable[[list[can.Message]], list[can.Message]] | None = None,
    ) -> list[dict[str, float | str]]:
        """Run so many cycles and return all answers of that time."""
        first = len(self.answers)
        for _ in range(count):
            self.cycle(values, change)
        return self.answers[first:]

    def begin(self, values: Mapping[str, Value] | None = None, count: int = 3) -> None:
        """Let the machine say a few times that it is starting."""
        for _ in range(count):
            self.give(self.frames(values, state="starting"))

    def answering(self, **outputs: float) -> None:
        """Let the compensator answer something else from now on."""
        step = self.unit.step

        def stepped(values: Mapping[str, float], step_s: float) -> dict[str, float]:
            step(values, step_s)
            self.unit.outputs |= outputs
            return self.unit.outputs

        self.unit.step = stepped

    def settle(self, values: Mapping[str, Value] | None = None, seconds: float = 5.0) -> None:
        """Start, and run until the offsets follow the model."""
        self.begin()
        self.cycle()
        self.cycles(round(seconds / 0.1), values)
        assert self.last["status"] == "ok"
        assert self.last["valid"] == "valid"


def decoded(frame: Message, message: can.Message) -> dict[str, float | str]:
    """Return what a message holds by cantools alone, words by their names."""
    content = frame.decode(bytes(message.data))
    return {name: getattr(value, "name", value) for name, value in content.items()}


def validity(answers: Iterable[Mapping[str, float | str]]) -> set[float | str]:
    """Return what answers say of their offsets."""
    return {answer["valid"] for answer in answers}


def with_bytes(message: can.Message, data: bytes) -> can.Message:
    """Return a message with other data."""
    return can.Message(arbitration_id=message.arbitration_id, data=data, is_extended_id=False)


def proven(
    database: Database, messages: list[can.Message], challenge: int | None
) -> list[can.Message]:
    """Return the messages of a cycle with the proof that their sender would have given."""
    frame = database.proof
    if frame is None or challenge is None:
        return messages
    others = [bytes(m.data) for m in messages if m.arbitration_id != frame.frame_id]
    proof = (challenge & ECHO_BITS) | proof_of(challenge, others) << 16
    return [
        sealed(m, bytes(m.data[:2]) + proof.to_bytes(6, "little"), frame)
        if m.arbitration_id == frame.frame_id
        else m
        for m in messages
    ]


def sealed(message: can.Message, data: bytes, frame: Frame) -> can.Message:
    """Return a message with other data and the CRC that fits."""
    return with_bytes(message, frame.protection.sealed(data))
