"""The form of a mapping file (TOML), which gives the meaning of a control's DBC signals.

``docs/gateway_maps.md`` shows the descriptions of the keys from here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from gateway.protection import COUNTER_ONLY, NAMES, NONE, PROFILE_1
from measurement.errors import BadInput, checked, matching
from measurement.files import read_toml

MAPS, CONTROLS = (Path(__file__).with_name(name) for name in ("maps", "controls"))
"""Folders of the maps and the controls' registers that ship."""
MISSING: Final = "missing"
HOLD: Final = "hold"

Name = Annotated[str, Field(min_length=1, max_length=200)]
Place = Annotated[
    str, Field(max_length=200), matching(r"[^.\s]+\.[^.\s]+", "FRAME.SIGNAL, without blanks")
]
Places = Annotated[list[Place], Field(min_length=1, max_length=64)]
Number = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Raw = Annotated[int, Field(ge=-(2**63), le=2**64 - 1)]
Byte = Annotated[int, Field(ge=0, le=255)]


class Form(BaseModel):
    """A file, or a table of one."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


F = TypeVar("F", bound=Form)


class FrameMap(Form):
    """What a frame's description needs beyond the DBC file."""

    protection: str
    """See [below](#protections)."""
    check: Name = "crc"
    """The signal that holds the check value."""
    counter: Name | None = None
    """The counter signal; with ``e2e_profile_1`` ``counter`` if left out."""
    counter_values: Annotated[int, Field(ge=2, le=65536)] | None = None
    """How many values the counter has, from 0; always 15 with ``e2e_profile_1``."""
    data_id: Annotated[int, Field(ge=0, le=65535)] | list[Byte] | None = None
    """Included in the check value: with ``e2e_profile_1`` a number (``E2EDataId`` of the DBC file
    if left out), otherwise bytes that precede the frame's own."""
    cycle: Name | None = None
    """With ``together``: the signal that holds the cycle count; ``cycle`` if left out."""
    late_after_ms: Annotated[float, Field(gt=0, le=1e9)] | Literal["never"] | None = None
    """The frame, or one page of it, is late after this silence; ``never`` for a frame that is only
    sent on change. ``E2ETimeout`` of the DBC file if left out."""
    fill: dict[Name, Number] = Field(default_factory=dict, max_length=64)
    """In sent frames: raw values of signals that the map does not use; by default their start
    values."""

    @model_validator(mode="after")
    def _fits(self) -> FrameMap:
        if self.protection not in NAMES:
            raise ValueError(f"protection must be one of {', '.join(NAMES)}")
        if self.protection == COUNTER_ONLY and self.counter is None:
            raise ValueError("protection counter needs counter: the signal that counts")
        if self.protection in (NONE, PROFILE_1) and self.counter_values is not None:
            raise ValueError(f"counter_values does not belong to protection {self.protection}")
        if self.protection == NONE and self.counter is not None:
            raise ValueError("with a counter, protection is counter, not none")
        if (
            self.counter is not None
            and self.counter_values is None
            and self.protection != (PROFILE_1)
        ):
            raise ValueError("counter needs counter_values: how many values it has")
        if self.protection != PROFILE_1 and isinstance(self.data_id, int):
            raise ValueError("data_id must be a list of bytes for this protection")
        if self.protection == PROFILE_1 and isinstance(self.data_id, list):
            raise ValueError("data_id must be a number for this protection")
        return self


class _Mapped(Form):
    signal: Any = None
    """``FRAME.SIGNAL``; an output may have several."""
    unit: Name | None = None
    """If the DBC file gives none or a wrong one; may begin with a number: ``0.1 um``."""
    factor: Number = 1.0
    """Sign or size: input = factor x value on the bus, value on the bus = factor x output."""
    values: dict[Name, Raw] | None = Field(default=None, max_length=256)
    """Raw values of named states: ``{ off = 0, running = 2 }``; in an output ``other`` stands for
    all states not named. By default the DBC file's value table, if it uses the gateway's names."""
    missing_raw: Raw | None = None
    """Raw value that means *missing*; an output without one repeats its last value."""
    error_raw: Raw | None = None
    """Raw value that means *error*."""

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        return {"signal": value} if isinstance(value, str | list) else value

    @model_validator(mode="after")
    def _scales(self) -> _Mapped:
        if self.factor == 0.0:
            raise ValueError("factor must not be 0")
        return self

    @property
    def places(self) -> list[str]:
        """The signals as ``FRAME.SIGNAL``; none for a constant."""
        signals = [self.signal] if isinstance(self.signal, str) else self.signal
        return list(signals or ())


class InputMap(_Mapped):
    """Where an input comes from, and what replaces it when it is missing."""

    signal: Place | Places | None = None
    constant: Number | Name | None = None
    """The value of an input that no frame carries; ``machine_state`` may be ``running``."""
    when_missing: Literal["missing", "hold"] | Number = MISSING
    """``missing``: the compensator's file decides. ``hold``: the last value for ``hold_s``. A
    number replaces the value."""
    hold_s: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Needed with ``hold`` [s]."""

    @model_validator(mode="after")
    def _fits(self) -> InputMap:
        if (self.signal is None) == (self.constant is None):
            raise ValueError("needs signal or constant, one of them")
        if (self.when_missing == HOLD) != (self.hold_s is not None):
            raise ValueError('when_missing = "hold" and hold_s need each other')
        raws = list((self.values or {}).values())
        twice = [raw for number, raw in enumerate(raws) if raw in raws[:number]]
        if twice:
            words = [word for word, raw in (self.values or {}).items() if raw == twice[0]]
            raise ValueError(f"values: {' and '.join(words)} are both {twice[0]}")
        return self


class OutputMap(_Mapped):
    """Where an output goes, and what is sent while it is invalid."""

    signal: Place | Places
    when_invalid: Literal["follow", "missing"] | Number | None = None
    """``follow``, the usual choice: the compensator's value, which holds or moves slowly. A number
    makes the offset jump. Needed for offsets if ``valid`` is not sent."""


class CycleMap(Form):
    """How frames belong together."""

    frames: Literal["together", "sampled"]
    """``together``: each frame comes once a cycle, all with the same counts, and the last one
    closes it; needs ``machine_time``, ``machine_step``, ``machine_state``, ``thermal_state`` and
    ``answered_time``. ``sampled``: each frame has its own period."""
    every_ms: Annotated[float, Field(ge=1, le=60000)] | None = None
    """With ``sampled``: how often the gateway reads the newest values and answers."""

    @model_validator(mode="after")
    def _fits(self) -> CycleMap:
        if (self.frames == "sampled") != (self.every_ms is not None):
            raise ValueError('frames = "sampled" and every_ms need each other')
        return self


class MapFile(Form):
    """A whole mapping file."""

    format: Literal[1]
    dbc: Name
    """The DBC file, relative to the map's folder."""
    title: str = Field(default="", max_length=400)
    """For printouts."""
    bit_rate: Annotated[int, Field(ge=5000, le=1000000)] | None = None
    """For the bus load only [bit/s]; ``Baudrate`` of the DBC file, or 500000."""
    data_bit_rate: Annotated[int, Field(ge=5000, le=20_000_000)] | None = None
    """CAN FD with this data rate [bit/s]: a cycle fits into one frame of 64 bytes (a
    [proof](gateway.md#freshness) needs its own). Bit timings: ``--option``."""
    axes: list[Literal["X", "Y", "Z"]] | None = Field(default=None, min_length=1, max_length=3)
    """The machine's axes; all if left out. Each one's offset must be sent."""
    cycle: CycleMap
    frames: dict[Name, FrameMap] = Field(min_length=1, max_length=256)
    inputs: dict[Name, InputMap] = Field(min_length=1, max_length=256)
    outputs: dict[Name, OutputMap] = Field(min_length=1, max_length=256)


def named_file(option: str, name: str, folder: Path) -> Path:
    """Return the file that an option names, by its path or the name of one that ships in a folder.

    Raises
    ------
    BadInput
        If there is no such file.
    """
    path = Path(name).expanduser()
    if path.is_file():
        return path
    shipped = {file.stem: file for file in sorted(folder.glob("*.toml"))}
    if name in shipped:
        return shipped[name]
    problem = f"{name!r} is neither a file nor one of those that ship: {', '.join(shipped)}"
    raise BadInput(option, "", problem)


def read_form(kind: type[F], path: Path) -> F:
    """Read a TOML file of a form; a mapping file's DBC file is not read.

    Raises
    ------
    BadInput
        If it is not TOML, or does not match the form.
    """
    return checked(kind, read_toml(path), path)
