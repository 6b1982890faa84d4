"""Converts one signal, or one frame's protection, of a control's DBC file as a map describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

from cantools.database.can import Message
from cantools.database.can import Signal as CanSignal

from gateway.database import ERROR, NOT_AVAILABLE, OTHER, TRUST, Signal
from gateway.dbc import DBC, attribute, load_dbc
from gateway.mapfile import FrameMap, InputMap, OutputMap
from gateway.protection import CHECKS, PROFILE_1, Protection, profile_1
from measurement.errors import BadInput
from measurement.importing.quantities import conversion_of

ENDLESS = ("status", "bus_fault")
"""Enumerations to which later versions may add values."""
Spec = InputMap | OutputMap


@cache
def own_signals() -> dict[str, Signal]:
    """Return the gateway's own signals from the shipped DBC file."""
    every = [signal for message in load_dbc(DBC).messages for signal in message.signals]
    return {signal.name: plain_signal(signal.name, signal) for signal in every}


def named(name: str) -> dict[str, int]:
    """Return the names of a signal's values; empty for a numeric signal."""
    if name == "trust":
        return {word: number for number, word in enumerate(TRUST)}
    own = own_signals().get(name)
    return own.named if own is not None and own.is_enumeration and name != "bus_fault_frame" else {}


def mapped_signal(name: str, spec: Spec, signal: CanSignal) -> Signal:
    """Return a control's signal as the gateway's own signal of a name.

    Raises
    ------
    BadInput
        If its unit, values or codes do not fit; the error does not name the place in the map.
    """
    codes = {str(word): int(raw) for raw, word in (signal.choices or {}).items()}
    special = {word: codes[word] for word in (ERROR, NOT_AVAILABLE) if word in codes}
    for word, raw in ((NOT_AVAILABLE, spec.missing_raw), (ERROR, spec.error_raw)):
        special |= {} if raw is None else {word: raw}
    own = own_signals().get(name)
    plain = plain_signal(name, signal)
    plain = replace(
        plain,
        comment=(own.comment if own else "") or plain.comment,
        codes=special,
        holds=NOT_AVAILABLE not in special,
        page=_page(signal),
    )
    if any(not plain.low <= raw <= plain.high for raw in special.values()):
        span = f"{plain.low:.0f} to {plain.high:.0f}"
        raise BadInput("missing_raw or error_raw", "", f"is outside the raw values, {span}")
    if named(name):
        return _enumeration(name, spec, codes, plain)
    if spec.values is not None:
        raise BadInput("values", "", f"{name} is a number, not one of several words")
    return _number(name, spec, signal, plain)


def plain_signal(name: str, signal: CanSignal) -> Signal:
    """Return a signal under a name, with its raw values unchanged."""
    low, high = raw_ends(signal)
    return Signal(
        name,
        unit=signal.unit or "",
        comment=signal.comment or "",
        scale=1.0,
        offset=0.0,
        low=low,
        high=high,
        bits=signal.length,
        holds_raw=(low, high),
        codes={str(word): int(raw) for raw, word in (signal.choices or {}).items()},
        start=signal.raw_initial or 0,
        wire_name=signal.name,
        is_float=bool(signal.is_float),
    )


def _number(name: str, spec: Spec, signal: CanSignal, plain: Signal) -> Signal:
    unit = spec.unit or signal.unit or ""
    own = own_signals().get(name)
    wanted = own.unit if own is not None else _usual(unit)
    factor, shift = conversion(unit, wanted) if unit or wanted else (1.0, 0.0)
    turned = spec.factor if isinstance(spec, InputMap) else 1.0 / spec.factor
    scale = turned * factor * float(signal.scale)
    offset = turned * (factor * float(signal.offset) + shift)
    scale, offset = float(f"{scale:.12g}"), float(f"{offset:.12g}")
    low, high = sorted(end * scale + offset for end in (plain.low, plain.high))
    ends = [float(end or 0.0) for end in (signal.minimum, signal.maximum)]
    if ends != [0.0, 0.0]:  # no more than the bits hold, whatever the DBC file says
        least, most = sorted(turned * (factor * end + shift) for end in ends)
        low, high = max(low, least), min(high, most)
    return replace(plain, unit=wanted, scale=scale, offset=offset, low=low, high=high)


def conversion(unit: str, wanted: str) -> tuple[float, float]:
    """Return factor and offset of value in *wanted* = factor * value in *unit* + offset.

    Raises
    ------
    BadInput
        If a unit is unknown, or they are of different quantities.
    """
    if unit.strip() == wanted:
        return 1.0, 0.0
    given, asked = conversion_of(unit), conversion_of(wanted)
    if given is None or asked is None or given.suffix != asked.suffix:
        raise BadInput(unit or "no unit", "", f"cannot be converted to {wanted}")
    factor, offset = given.factor / asked.factor, (given.offset - asked.offset) / asked.factor
    # Rounded, so that a whole number of steps stays one.
    return float(f"{factor:.12g}"), float(f"{offset:.12g}")


def _enumeration(name: str, spec: Spec, codes: dict[str, int], plain: Signal) -> Signal:
    words = named(name)
    own_words = {word: raw for word, raw in codes.items() if word in words or word == OTHER}
    needed = {"machine_state": "running", "thermal_state": "cold"}.get(name)
    given = spec.values or own_words or ({} if needed else words)
    strange = [word for word in given if word not in words and word != OTHER]
    if strange:
        raise BadInput("values", "", f"{strange[0]} is none of {', '.join(words)}, {OTHER}")
    wrong = [word for word, raw in given.items() if not plain.low <= raw <= plain.high]
    if wrong:
        text = f"{wrong[0]} is {given[wrong[0]]}, the signal holds {plain.low:.0f} to "
        raise BadInput("values", "", f"{text}{plain.high:.0f}")
    if isinstance(spec, OutputMap):
        if len(given) > 1 and len(set(given.values())) == 1:
            raise BadInput("values", "", f"{' and '.join(given)} are all {min(given.values())}")
        same = given == words
        lost = [word for word in words if word not in given]
        if OTHER not in given and (lost or (name in ENDLESS and not same)):
            what = f"lacks {lost[0]}, or" if lost else "lacks"
            raise BadInput("values", "", f"{what} a value named {OTHER} for all others")
        numbers = {} if same else {number: word for word, number in words.items()}
        top = float(max(given.values()))
        if name in ENDLESS and same:
            top = min([plain.high, *(raw - 1 for raw in plain.codes.values())])
        return replace(
            plain,
            codes=plain.codes | given,
            numbers=numbers,
            low=float(min(given.values())),
            high=float(top),
        )
    if needed and needed not in given:
        raise BadInput("values", "", f"has no {needed}")
    ends = given.values()
    return replace(plain, codes=plain.codes | given, low=float(min(ends)), high=float(max(ends)))


def protection_of(message: Message, form: FrameMap) -> Protection:
    """Return a frame's protection, as described in a map.

    Raises
    ------
    BadInput
        If the frame lacks the signals, or they are in the wrong place.
    """
    places = {signal.name: signal for signal in message.signals}
    name, counter, data_id = form.protection, form.counter or "", form.data_id
    if name == PROFILE_1:
        counter = counter or "counter"
    check = form.check if name in CHECKS else ""
    _need_two(places, check, counter)
    if name == PROFILE_1:
        if [(places[n].start, places[n].length) for n in (check, counter)] != [(0, 8), (8, 4)]:
            raise BadInput(PROFILE_1, "", "needs its CRC in byte 0 and counter in bits 8 to 11")
        if data_id is None:
            data_id = int(attribute(message.dbc, "E2EDataId", 0))
        assert isinstance(data_id, int)
        return profile_1(data_id, counter, check)
    counters = form.counter_values or 1
    if counter and counters > raw_ends(places[counter])[1] + 1.0:
        raise BadInput("counter_values", "", f"{counters} do not fit into {counter}")
    if not check:
        return Protection(name, counter, counters)
    size, big = CHECKS[name][1], places[check].byte_order == "big_endian"
    if places[check].length != 8 * size or places[check].start % 8 != (7 if big else 0):
        raise BadInput("check", "", f"{check} must fill {size} whole bytes")
    assert not isinstance(data_id, int)
    at = places[check].start // 8
    return Protection(name, counter, counters, check, at, big, bytes(data_id or ()))


def _need_two(places: Mapping[str, CanSignal], check: str, counter: str) -> None:
    """Refuse names of check value and counter, if given, that are not those of two signals."""
    for what, signal in (("check", check), ("counter", counter)):
        if signal and signal not in places:
            raise BadInput(what, "", f"there is no signal {signal}")
    if counter and counter == check:
        raise BadInput("counter", "", f"{counter} is already the check value")


def _page(signal: CanSignal) -> int | None:
    if not signal.multiplexer_ids:
        return None
    if len(signal.multiplexer_ids) > 1 or signal.is_multiplexer:
        raise BadInput(signal.name, "", "is multiplexed more than once, which is not supported")
    return int(signal.multiplexer_ids[0])


def raw_ends(signal: CanSignal) -> tuple[float, float]:
    """Return the smallest and the largest raw value that a signal can hold."""
    if signal.is_float:
        return -1e30, 1e30
    if signal.is_signed:
        return -(1 << signal.length - 1), (1 << signal.length - 1) - 1
    return 0, (1 << signal.length) - 1


def _usual(unit: str) -> str:
    """Return the gateway's unit for a quantity that it does not know."""
    conversion = conversion_of(unit)
    return conversion.suffix if conversion and conversion.suffix in ("degC", "rpm") else unit
