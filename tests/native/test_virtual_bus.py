"""A bus with a machine and two compensators: each hears the machine and leaves the other alone."""

import re

import pytest

import build_fmu
from gateway.codec import decode
from gateway.database import COMPENSATOR, MACHINE
from gateway.dbc import DBC
from gateway.mapping import read_database
from tests.native.can_bus import TRANSMIT, BusNode, Machine, frame_of, operations, transmitted

SHIFT = 16  # between the identifiers of the two compensators


@pytest.mark.long
def test_two_compensators_share_a_bus(tmp_path):
    text, database = DBC.read_text("utf-8"), read_database(DBC)
    frames = {frame.frame_id: frame for frame in database.of(COMPENSATOR)}
    for frame_id in frames:
        text = re.sub(rf"\b{frame_id}\b", str(frame_id + SHIFT), text)
    (tmp_path / "second.dbc").write_text(text)
    for more in ([], ["--dbc", str(tmp_path / "second.dbc"), "--name", "second"]):
        assert build_fmu.main(["--can", "--out", str(tmp_path), *more]) == 0
    nodes = [
        BusNode(next(tmp_path.glob(f"{name}*.fmu")), tmp_path / name)
        for name in ("compensator", "second")
    ]
    machine = Machine(database, database.closing(MACHINE).cycle_s)
    sent: list[list[dict[str, float]]] = [[], []]
    for cycle in range(1, 600):
        time_s = cycle * machine.cycle_s
        while (node := min(nodes, key=lambda node: node.due_s)).due_s < time_s:
            number, at_s = nodes.index(node), node.due_s
            for frame_id, data in (
                frame_of(content) for code, content in operations(node.send()) if code == TRANSMIT
            ):
                nodes[1 - number].receive(at_s, transmitted(frame_id, data))
                values = decode(frames[frame_id - SHIFT * number], data).values
                sent[number].append({n: value for n, value in values.items() if value == value})
                if number == 0 and "challenge" in sent[0][-1]:
                    machine.heard = int(values["challenge"])
        messages = machine.cycle(time_s, {})
        for node in nodes:
            node.receive(
                time_s, b"".join(transmitted(m.arbitration_id, bytes(m.data)) for m in messages)
            )
    count = min(map(len, sent))
    assert sent[0][:count] == sent[1][:count]
    assert count > 7 * 590
    assert abs(nodes[0].value("dZ")) > 0.1
