"""Generates the C data of a bus node from the DBC file and the variables of its FMU.

All frames, signals, codes and times come from the same source as the gateway's; none is hand-coded
in C.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isinf

from fmu_packaging.bus_terminal import SignalTerminal
from fmu_packaging.variables import Variable
from gateway.busload import frame_bits
from gateway.database import (
    COMPENSATOR,
    ERROR,
    MACHINE,
    NOT_AVAILABLE,
    OFFSETS,
    OTHER,
    Database,
    Frame,
    Signal,
)
from gateway.mapcheck import LAST, NEEDED
from gateway.mapped_signals import named
from gateway.node import GatewaySettings
from gateway.probes import TAKEN
from gateway.proof import CHALLENGE, ECHO, FRESHNESS, LARGEST_ECHO, NOT_PROVEN, PROOF, PROVEN
from gateway.protection import COUNTERS
from gateway.timebase import WORD_HOLDS_S
from measurement.errors import BadInput
from measurement.rig import AXES
from scenarios.wiring import PROBED

ROLES = (*NEEDED[COMPENSATOR], LAST[COMPENSATOR], CHALLENGE, FRESHNESS, TAKEN)
"""Signals that the node itself fills, by name; those of each axis follow."""
HEARD = (*NEEDED[MACHINE], "tool_length", ECHO, PROOF)
"""Signals that it takes from the machine in addition to the compensator's inputs."""
NONE = "NONE"
FRAME_BYTES = 8
"""Length of every frame: given by ``frames.h``."""
HEAD = "/* Made by spindle-drift from a DBC file; not to be edited. */\n"


def node_data(
    database: Database, variables: Sequence[Variable], terminal: SignalTerminal | None = None
) -> dict[str, str]:
    """Return ``node_data.h`` and ``node_data.c``.

    Parameters
    ----------
    database : Database
        The frames.
    variables : sequence of Variable
        The FMU's variables, in the order of their value references.
    terminal : SignalTerminal, optional
        The terminal, if the signals are variables.

    Raises
    ------
    BadInput
        If the C code does not support a frame, or no frame carries an input of the compensator.
    """
    refs = {variable.name: ref for ref, variable in enumerate(variables)}
    heard = [signal.name for _, signal in database.signals(MACHINE)]
    for variable in variables:
        wanted = variable.causality == "input" and not variable.name.startswith(PROBED)
        if wanted and not variable.clock and variable.name not in heard:
            problem = f"carries no signal {variable.name}, an input of the compensator"
            raise BadInput(database.path, MACHINE, problem)
    for frame in database.frames:
        if frame.extended or frame.size != FRAME_BYTES:
            problem = f"must have {FRAME_BYTES} bytes and an identifier of 11 bits"
            raise BadInput(database.path, frame.name, problem)
        for signal in frame.message.signals:
            if signal.byte_order != "little_endian" or signal.is_signed or signal.is_float:
                problem = "must be unsigned, with its least significant byte first"
                raise BadInput(database.path, f"{frame.name}.{signal.name}", problem)
    return {
        "node_data.h": _header(database, heard, terminal),
        "node_data.c": _tables(database, refs, terminal),
    }


def _header(database: Database, heard: Sequence[str], terminal: SignalTerminal | None) -> str:
    proof, closing = database.proof, database.closing(MACHINE)
    frames = database.of(MACHINE)
    machine_time = database.signal("machine_time")
    answered = database.signal("answered_time")
    clocks = [frame.received for frame in terminal.frames] if terminal else [True, False]
    numbers: dict[str, float] = {
        "SIGNALS": int(terminal is not None),
        "RX_CLOCKS": clocks.count(True),
        "TX_CLOCKS": clocks.count(False),
        "MACHINE_FRAMES": len(frames),
        "COMPENSATOR_FRAMES": len(database.of(COMPENSATOR)),
        "HEARD": len(heard),
        "PROOF_FRAME": frames.index(proof) if proof else -1,
        "AXES": len(AXES),
        "COUNTERS": COUNTERS,
        "COUNTER_BITS": COUNTERS.bit_length(),
        "LARGEST_ECHO": LARGEST_ECHO,
        "BIT_RATE": database.bit_rate,
        # Signals need no transmission time.
        "FRAME_S": 0.0 if terminal else frame_bits(closing.size) / database.bit_rate,
        "CYCLE_S": closing.cycle_s,
        "TIMEOUT_S": closing.timeout_s,
        "STARTUP_S": GatewaySettings().startup_s,
        "COLD_FOR_S": WORD_HOLDS_S,
        "TIME_SCALE": machine_time.scale,
        "TIME_COUNT": float(machine_time.allowed_raw[1] + 1),
        "ANSWERED_COUNT": float(1 << answered.bits),
        "MACHINE_RUNNING": _code(database, "machine_state", "running"),
        "THERMAL_COLD": _code(database, "thermal_state", "cold"),
        "VALID_VALID": _code(database, "valid", "valid"),
        "VALID_INVALID": _code(database, "valid", "invalid"),
        "STATUS_REFERENCE_UNKNOWN": _code(database, "status", "reference_unknown"),
        "FRESHNESS_PROVEN": _code(database, FRESHNESS, PROVEN),
        "FRESHNESS_NOT_PROVEN": _code(database, FRESHNESS, NOT_PROVEN),
    }
    places = {name: heard.index(name) if name in heard else 0 for name in HEARD}
    numbers |= {f"HEARD_{name.upper()}": place for name, place in places.items()}
    names = [f"ROLE_{role.upper()}" for role in ROLES]
    roles = [*names, "ROLE_UNCERTAINTY", f"ROLE_SLOPE = ROLE_UNCERTAINTY + {len(AXES)}"]
    roles += [f"ROLE_TOOL_LENGTH = ROLE_SLOPE + {len(AXES)}", "ROLES"]
    lines = [
        HEAD,
        '#ifndef NODE_DATA_H\n#define NODE_DATA_H\n\n#include "frames.h"\n',
        *(f"#define {name} {_number(value)}" for name, value in numbers.items()),
        f"enum role {{ {', '.join(roles)} }};",
        f"enum fault {{ {', '.join(f'FAULT_{fault.upper()}' for fault in named('bus_fault'))} }};",
        f"enum state {{ {', '.join(f'STATE_{s.upper()}' for s in named('gateway_state'))} }};",
        "struct axis { size_t offset, uncertainty, tilt; };",
        "extern const struct frame machine_frames[], compensator_frames[];",
        "extern const struct signal machine_signals[], offset_signals[];",
        "extern const size_t valid_ref, status_ref, offset_count;",
        "extern const double fault_codes[], state_codes[], status_codes[];",
        "extern const struct axis axes[];",
        "\n#endif",
    ]
    return "\n".join(lines) + "\n"


def _tables(database: Database, refs: Mapping[str, int], terminal: SignalTerminal | None) -> str:
    offsets = [signal for _, signal in database.signals(COMPENSATOR) if signal.name in OFFSETS]
    tilts = {"X": "yaw", "Y": "pitch"}
    axes = [
        [refs.get(name) for name in (f"d{axis}", f"d{axis}_uncertainty", tilts.get(axis, ""))]
        for axis in AXES
    ]
    lines = [
        HEAD,
        '#include "node_data.h"\n\n#include "model.h"\n',
        *_frames("machine", database.of(MACHINE), refs, terminal),
        *_frames("compensator", database.of(COMPENSATOR), refs, terminal),
        "const struct signal offset_signals[] = {",
        # The limits are values here, but raw values in a frame's signals.
        *(
            f"    {{.low = {s.low!r}, .high = {s.high!r}, .ref = {_ref(refs, s)}}},"
            for s in offsets
        ),
        "};",
        f"const size_t offset_count = {len(offsets)};",
        f"const size_t valid_ref = {refs.get('valid', NONE)};",
        f"const size_t status_ref = {refs.get('status', NONE)};",
        f"const double fault_codes[] = {{{_codes(database, 'bus_fault')}}};",
        f"const double state_codes[] = {{{_codes(database, 'gateway_state')}}};",
        f"const double status_codes[] = {{{_status_codes(database)}}};",
        "const struct axis axes[] = {",
        *(f"    {{{', '.join(_or_none(ref) for ref in axis)}}}," for axis in axes),
        "};",
    ]
    return "\n".join(lines) + "\n"


def _frames(
    node: str,
    frames: Sequence[Frame],
    refs: Mapping[str, int],
    terminal: SignalTerminal | None,
) -> Iterator[str]:
    """Yield a table of a node's signals, then its frames, each with its part of the table."""
    yield f"const struct signal {node}_signals[] = {{"
    for frame in frames:
        places = {signal.name: int(signal.start) for signal in frame.message.signals}
        for signal in frame.signals.values():
            yield f"    {_signal(signal, places[signal.name], refs)},"
    yield "};"
    yield f"const struct frame {node}_frames[] = {{"
    first = 0
    for frame in frames:
        cycle = next(s for s in frame.message.signals if s.name == frame.cycle)
        parts = (frame.frame_id, frame.data_id, int(cycle.start), cycle.length)
        listed = f"{node}_signals + {first}, {len(frame.signals)}"
        first_signal = terminal and terminal.signal(
            frame.name, next(iter((*frame.signals, frame.protection.check)))
        )
        variable = _or_none(refs.get(first_signal or ""))
        yield f"    {{{', '.join(map(str, parts))}, {listed}, {variable}}},"
        first += len(frame.signals)
    yield "};"


def _signal(signal: Signal, start: int, refs: Mapping[str, int]) -> str:
    missing = float(signal.codes.get(NOT_AVAILABLE, -1))
    error = float(signal.codes.get(ERROR, missing))
    words = sum(1 << raw for raw in signal.codes.values()) if signal.is_enumeration else 0
    parts = {
        "start": start,
        "bits": signal.bits,
        "scale": signal.scale,
        "offset": signal.offset,
        "low": float(signal.allowed_raw[0]),
        "high": float(signal.allowed_raw[1]),
        "missing": missing,
        "error": error,
        "fallback": signal.start,
        # Only the machine's signals are read, and they have few values.
        "named": f"UINT64_C({words})" if words < 1 << 64 else 0,
        "role": _role(signal.name),
        "ref": _ref(refs, signal),
    }
    return f"{{{', '.join(f'.{name} = {value}' for name, value in parts.items())}}}"


def _role(name: str) -> str:
    for axis, letter in enumerate(AXES):
        if name == f"d{letter}_uncertainty":
            return f"ROLE_UNCERTAINTY + {axis}"
        if name == f"d{letter}_per_tool_length":
            return f"ROLE_SLOPE + {axis}"
        if name == f"d{letter}_tool_length":
            return "ROLE_TOOL_LENGTH"
    return f"ROLE_{name.upper()}" if name in ROLES else "-1"


def _ref(refs: Mapping[str, int], signal: Signal) -> str:
    return _or_none(refs.get(signal.name.removesuffix("_at_tool_length")))


def _or_none(ref: int | None) -> str:
    return NONE if ref is None else str(ref)


def _codes(database: Database, name: str) -> str:
    return ", ".join(_number(_code(database, name, word)) for word in named(name))


def _status_codes(database: Database) -> str:
    """Return the code of each status of the compensator, by its number."""
    words = {number: word for word, number in named("status").items()}
    renamed = database.has("status") and database.signal("status").numbers
    return ", ".join(
        _number(_code(database, "status", words.get(number, OTHER)) if renamed else float(number))
        for number in range(max(words) + 1)
    )


def _code(database: Database, name: str, word: str) -> float:
    """Return a named value's code; if the DBC lacks the signal, the code is never used."""
    if not database.has(name):
        return 0.0
    signal = database.signal(name)
    word = word if word in signal.codes else OTHER
    if word not in signal.codes:
        raise BadInput(database.path, name, f"has no value named {word}")
    return signal.codes[word] * signal.scale + signal.offset


def _number(value: float) -> str:
    if isinf(value):
        return "INFINITY"
    return f"({value!r})" if value < 0 else repr(value)
