"""The compensator: each step takes readings and returns axis offsets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from operator import sub
from statistics import median
from typing import Any, NamedTuple

from fmu_compensator.runtime.checks import IMPLAUSIBLE, MISSING, Fault, SensorCheck
from fmu_compensator.runtime.fields import LARGEST
from fmu_compensator.runtime.gaussian import NAMED
from fmu_compensator.runtime.modelfile import FORMAT, Model
from fmu_compensator.runtime.prediction import Prediction, three
from fmu_compensator.runtime.spare import Spare, Starts

OK, WAITING, UNTRAINED, RECOVERING, SPARED = 0, 1, 2, 3, 4
HOLDING, RAMPING, AT_ZERO = 10, 20, 30
"""Status codes; the cause is added to the last three: given by the FMU's interface."""
REMEMBERED = ("last_time", "started", "recovering", "fault_age", "good_for")
"""Attributes that a state holds unchanged."""
STATUS_TEXTS = {
    OK: "offsets follow the model",
    WAITING: "waiting for the first valid sample",
    UNTRAINED: "outside the conditions seen in training",
    RECOVERING: "moving to the wanted offsets",
    SPARED: "going on without a sensor",
    HOLDING: "holding the last good offsets",
    RAMPING: "ramping the offsets to zero",
    AT_ZERO: "offsets are zero",
}


class Output(NamedTuple):
    """Result of a step.

    Attributes
    ----------
    dX, dY, dZ : float
        Offsets to send [um]: the tool tip's drift with the opposite sign, within the limits.
    elongation, yaw, pitch : float
        The predicted pose [um, urad, urad]; the last good one while the inputs are bad.
    dX_uncertainty, dY_uncertainty, dZ_uncertainty : float
        Half width of the interval about the compensated drift, at this tool length, that contains
        most unseen drift [um]: wider for newer inputs, narrower after a measurement. The last good
        one while the inputs are bad. -1: unknown, because the axis was not measured in training or
        nothing has been predicted yet.
    valid : bool
        Whether the offsets follow the model. False while waiting, recovering or in a fault.
    status : int
        0 ok; 1 waiting for the first valid sample; 2 ok, but in conditions not seen in training;
        3 recovering; 4 continuing without broken sensors, whose readings are estimated from the
        others, or with the last known speed (takes precedence over 2, because they need repair);
        1x holding, 2x ramping to zero, 3x at zero, where x is the cause: 1 missing, 2 outside the
        plausible range, 3 changing too fast, 4 stale.
    status_sensor : int
        1-based index of the sensor to blame, 0 for none. Outside training: the sensor that
        contributes most, 0 if it is the speed; the text names up to three.
    status_text : str
        One line for people. While the offsets are valid it names those at their limit.
    """

    dX: float  # noqa: N815 - the signals' names
    dY: float  # noqa: N815
    dZ: float  # noqa: N815
    elongation: float
    yaw: float
    pitch: float
    dX_uncertainty: float  # noqa: N815
    dY_uncertainty: float  # noqa: N815
    dZ_uncertainty: float  # noqa: N815
    valid: bool
    status: int
    status_sensor: int
    status_text: str


class RunningCompensator:
    """Input checks, error model and Gaussian, offset geometry, limits.

    Parameters
    ----------
    model : Model
        A compensator file, read.

    Notes
    -----
    After a fault the last good offsets are held for ``hold_s``, then ramped to zero. When the
    inputs have been good for ``recover_s``, the offsets move back to what the model wants and
    are valid again once they are there. All of this obeys the slew limit, so offsets never step.
    A fault does not reset the reference of the rise form.

    `Prediction` computes the wanted offsets and their uncertainty. If the file has a `Spare`,
    broken sensors are not a fault as long as one of the others is good.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self._spare = model.new_spare()
        self._prediction = Prediction(model, self._spare)
        self._checks = [SensorCheck(model.sensors[i], i + 1) for i in model.chosen]
        self._rise = model.input_form == "rise"
        gaussian = self._prediction.gaussian
        self._fixed = gaussian.usual if gaussian.fixed else None
        self.reset()

    def reset(self) -> None:
        """Start over: no reference, no offsets."""
        self._prediction.reset()
        if self._spare is not None:
            self._spare.reset()
        for check in self._checks:
            check.reset()
        self._last_time: float | None = None
        self._reference: list[float | None] = [None] * len(self._checks)
        self._started = False  # after the first complete valid sample
        self._recovering = False
        self._fault: Fault | None = None  # the newest fault, kept until recovered from
        self._spared: Fault | None = None  # the newest fault of a sensor that is replaced
        self._unheard: Fault | None = None  # of the speed, whose last known value holds
        self._fault_age = 0.0  # [s]
        self._good_for = 0.0  # since the last bad sample [s]
        self._offset = (0.0, 0.0, 0.0)

    def step(
        self,
        time_s: float,
        step_s: float,
        temperatures: Sequence[float],
        speed: float = nan,
        tool_length: float = nan,
        measured: Sequence[float] | None = None,
    ) -> Output:
        """Process one sample and return the offsets at the end of the step.

        Parameters
        ----------
        time_s, step_s : float
            Time of the sample, and length of the step that starts with it [s]. The offsets move
            for ``step_s``. The age of readings follows from ``time_s``; if that is not a number or
            runs backwards, ``step_s`` is used instead.
        temperatures : sequence of float
            One reading per sensor of the file, in its order [degC]; NaN: missing.
        speed : float
            Spindle speed [rpm]; NaN: unknown.
        tool_length : float
            From the gauge line to the tool tip [mm]; ignored by a direct geometry.
        measured : sequence of float, optional
            The targets measured with this sample by a displacement sensor or a probe, relative to
            the start unless the file's form is absolute [um, urad]. They take effect from the next
            sample on. If any is not finite, all are ignored.

        Returns
        -------
        Output
            Offsets [um], status and uncertainty, ``step_s`` after the sample.

        Raises
        ------
        ValueError
            If the number of temperatures or of measured targets is not that of the file.
        """
        if len(temperatures) != len(self.model.sensors):
            count = len(self.model.sensors)
            raise ValueError(f"{len(temperatures)} temperatures were given, the file has {count}")
        if measured is not None and len(measured) != len(self.model.targets):
            count = len(self.model.targets)
            raise ValueError(f"{len(measured)} measured targets were given, the file has {count}")
        if not (isfinite(step_s) and step_s > 0.0):
            step_s = 0.0
        step_s = min(step_s, LARGEST)
        elapsed = self._elapsed(time_s, step_s)
        readings = [temperatures[index] for index in self.model.chosen]
        fault = self._look(readings, elapsed, tool_length)
        known = self._prediction.gaussian.knows(speed)
        self._unheard = None if known else Fault(MISSING, 0, "speed is missing")
        if fault is None and not self._started:
            fault = self._unheard
        # Lags and walk begin with the first complete sample, as in training.
        if self._started:
            self._prediction.wait(elapsed)
        if fault is None:
            rises = self._rises(readings)
            inputs = rises if self._rise else readings
            self._prediction.step(inputs, rises, speed, tool_length)
            if not self._started:
                self._started = self._recovering = True
            # A measurement taken while the inputs are bad has no prediction to compare with.
            if measured is not None:
                self._prediction.take(measured)
        if not self._started:
            return self._output(False, WAITING, fault)
        self._follow(fault, elapsed)
        return self._move(step_s)

    def _elapsed(self, time_s: float, step_s: float) -> float:
        """Return the time since the previous sample [s]; the step's length if that is unknown."""
        last, self._last_time = self._last_time, time_s if isfinite(time_s) else None
        if last is None or not isfinite(time_s) or time_s < last:
            return step_s
        return min(time_s - last, LARGEST)

    def _look(self, readings: list[float], elapsed_s: float, tool_length: float) -> Fault | None:
        """Return the first fault; every sensor is checked, so that none loses track of time.

        Readings of broken sensors are replaced by estimates if the file has a spare.
        """
        pairs = zip(self._checks, readings, strict=True)
        faults = [check.look(value, elapsed_s) for check, value in pairs]
        first = next(filter(None, faults), None)
        if None in self._reference:
            seen = zip(self._reference, readings, faults, strict=True)
            self._reference = [
                value if start is None and fault is None else start for start, value, fault in seen
            ]
        if self._spare is not None:
            first = self._replaced(self._spare, readings, faults, elapsed_s, tool_length)
        if first is None and self.model.geometry.needs_tool_length:
            low, high = self.model.limits.tool_length_mm
            if not isfinite(tool_length):
                return Fault(MISSING, 0, "tool_length is missing")
            if not low <= tool_length <= high:
                text = f"tool_length {tool_length:g} mm is not in {low:g} to {high:g} mm"
                return Fault(IMPLAUSIBLE, 0, text)
        return first

    def _replaced(
        self,
        spare: Spare,
        readings: list[float],
        faults: Sequence[Fault | None],
        elapsed_s: float,
        tool_length: float,
    ) -> Fault | None:
        """Replace the readings of broken sensors; return the fault if that is not possible."""
        limits, stands = self.model.limits, self._checks[spare.turn].stands
        if spare.quiet and not any(faults):
            spare.go_on(readings, stands, elapsed_s)
            return None
        bad = [place for place, fault in enumerate(faults) if fault is not None]
        fault = faults[bad[0]] if bad else None
        axes = self._prediction.axes(limits.nearest_tool(tool_length))
        starts = None if self._started or not bad else self._starts(readings, bad)
        used = spare.step(readings, bad, stands, elapsed_s, limits.recover_s, axes, starts)
        if fault is not None:
            self._spared = fault
        if used is None:
            return fault
        if starts is not None:
            self._reference = list(starts.first)
        readings[:] = used
        if not spare.broken:
            self._spared = None
        return None

    def _starts(self, readings: Sequence[float], bad: Sequence[int]) -> Starts | None:
        """Return the references of rises if some sensors are missing; None if levels matter."""
        good = [place for place in range(len(readings)) if place not in bad]
        usual = None if self._spare is None else self._spare.usual_start
        if usual is None or not good:
            return None
        middle = median([readings[place] for place in good])
        first, unread = [], []
        for place, reading in enumerate(self._reference):
            likely = middle + usual[place] if reading is None else reading
            if reading is None:
                unread.append(place)
            first.append(likely)
        return Starts(first, unread)

    def _rises(self, readings: Sequence[float]) -> list[float]:
        """Return the rises of good readings above their references [K]."""
        return list(map(sub, readings, self._fixed or self._reference))

    def _follow(self, fault: Fault | None, elapsed_s: float) -> None:
        """Track how long the inputs have been bad, or good again."""
        if fault is not None:
            # A new fault starts a new hold; one during recovery continues the old hold.
            self._fault_age = 0.0 if self._fault is None else self._fault_age + elapsed_s
            self._fault, self._good_for, self._recovering = fault, 0.0, False
        elif self._fault is not None:
            self._fault_age += elapsed_s
            self._good_for += elapsed_s
            if self._good_for >= self.model.limits.recover_s:
                self._fault, self._recovering = None, True

    def _move(self, step_s: float) -> Output:
        """Move the offsets for one step and return the output."""
        if self._fault is None:
            wanted = self._prediction.wanted
            self._slew(wanted, step_s)
            if self._recovering and self._offset != wanted:
                return self._output(False, RECOVERING, None)
            self._recovering = False
            return self._valid_output()
        if self._fault_age < self.model.limits.hold_s:
            return self._output(False, HOLDING + self._fault.cause, self._fault)
        self._slew((0.0, 0.0, 0.0), step_s)
        phase = RAMPING if any(self._offset) else AT_ZERO
        return self._output(False, phase + self._fault.cause, self._fault)

    def _slew(self, wanted: tuple[float, float, float], step_s: float) -> None:
        slewed = self.model.limits.slewed
        x, y, z = self._offset
        self._offset = (
            slewed(x, wanted[0], step_s),
            slewed(y, wanted[1], step_s),
            slewed(z, wanted[2], step_s),
        )

    def _valid_output(self) -> Output:
        """Return a valid output with its status: ok, without a sensor, or outside training."""
        if self._spared is not None:
            return self._output(True, SPARED, self._without(self._spared))
        if self._unheard is not None:
            return self._output(True, SPARED, self._unheard)
        if self._prediction.gaussian.is_new:
            return self._output(True, UNTRAINED, self._new())
        return self._output(True, OK, None)

    def _without(self, fault: Fault) -> Fault:
        """Return the newest fault, with the names of other broken sensors."""
        assert self._spare is not None
        broken = [self.model.chosen[place] for place in self._spare.broken]
        others = [index for index in broken if index + 1 != fault.sensor][:NAMED]
        if not others:
            return fault
        names = ", ".join(self.model.sensors[index].name for index in others)
        return Fault(fault.cause, fault.sensor, f"{fault.text}; and without {names}")

    def _new(self) -> Fault:
        """Return the inputs that contribute most to the uncertainty from new conditions."""
        gaussian = self._prediction.gaussian
        sensors = [(index + 1, self.model.sensors[index].name) for index in self.model.chosen]
        numbered = [*sensors, (0, "speed")]
        culprits = [numbered[place] for place in gaussian.culprits()]
        names = ", ".join(name for _, name in culprits)
        part = 100.0 * gaussian.novelty / (gaussian.novelty + gaussian.usual_variance)
        text = f"conditions outside training make {part:.0f} % of the uncertainty: {names}"
        return Fault(0, culprits[0][0], text)

    def _output(self, valid: bool, status: int, reason: Fault | None) -> Output:
        text = STATUS_TEXTS[status if status < HOLDING else status - status % 10]
        sensor = 0
        if reason is not None:
            sensor = reason.sensor
            text = reason.text if status == UNTRAINED else f"{text}: {reason.text}"
        if valid:
            limit = self.model.limits.offset_um
            for axis, sent in zip("XYZ", self._offset, strict=True):
                if abs(sent) == limit:
                    text += f"; d{axis} is at its limit of {limit:g} um"
        drift = self._prediction
        return Output(*self._offset, *drift.pose, *drift.half_width, valid, status, sensor, text)

    def state(self) -> dict[str, Any]:
        """Return the whole memory, as values that JSON stores without loss."""
        fault, spared = self._fault, self._spared
        return {
            "format": FORMAT,
            **{name: getattr(self, f"_{name}") for name in REMEMBERED},
            "reference": list(self._reference),
            "fault": None if fault is None else [fault.cause, fault.sensor, fault.text],
            "spared": None if spared is None else [spared.cause, spared.sensor, spared.text],
            "offset": list(self._offset),
            **self._prediction.state(),
            "spare": [] if self._spare is None else self._spare.state(),
            "checks": [check.state() for check in self._checks],
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Restore what `state` returned, from this compensator or another of the same file.

        Parameters
        ----------
        state : mapping
            Plain numbers, texts and lists; no reference to it is kept.

        Raises
        ------
        ValueError
            If the state does not belong to a compensator of this file.
        """
        known = self.state()
        if set(state) != set(known) or state["format"] != FORMAT:
            raise ValueError("this is not a state of this version's compensator")
        for name in ("reference", "checks"):
            if len(state[name]) != len(known[name]):
                count = f"{len(state[name])} chosen sensors, the file {len(known[name])}"
                raise ValueError(f"the state holds {count}")
        self._prediction.restore(state)
        if self._spare is not None:
            self._spare.restore(state["spare"])
        elif len(state["spare"]):
            raise ValueError("the state holds a spare, the file has none")
        for check, remembered in zip(self._checks, state["checks"], strict=True):
            check.restore(remembered)
        for name in REMEMBERED:
            setattr(self, f"_{name}", state[name])
        self._reference = list(state["reference"])
        self._fault = None if state["fault"] is None else Fault(*state["fault"])
        self._spared = None if state["spared"] is None else Fault(*state["spared"])
        self._offset = three(state["offset"])
