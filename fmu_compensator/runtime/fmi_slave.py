"""The compensator as an FMU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

from fmu_compensator.runtime.compensator import HOLDING, STATUS_TEXTS, WAITING, RunningCompensator
from fmu_compensator.runtime.modelfile import Model, ModelFileError, load_model, parse_model
from fmu_compensator.runtime.prediction import NOT_KNOWN
from fmu_packaging.slave import DriftSlave, FmuError
from fmu_packaging.variables import LONGEST_TOOL_MM, START_DEGC, USUAL_TOOL_MM, Kind, Variable

MODEL_FILE = "compensator.json"
"""Name of the bundled compensator file in the FMU's resources."""

MEASURED = "measured"
"""Input that tells whether to use the measured targets."""

HALF_WIDTHS = ("dX_uncertainty", "dY_uncertainty", "dZ_uncertainty")
REALS = ("dX", "dY", "dZ", "elongation", "yaw", "pitch", *HALF_WIDTHS)
"""Real outputs in the order of the compensator's `Output`."""
CAUSES = ("missing", "outside its plausible range", "changing too fast", "stale")
"""Meanings of the last digit of a status above ten, from 1 on."""


def status_meanings() -> dict[int, str]:
    """Return the meaning of each status."""
    meanings = {}
    for status, text in STATUS_TEXTS.items():
        if status < HOLDING:
            meanings[status] = text
        else:
            for cause, words in enumerate(CAUSES, start=1):
                meanings[status + cause] = f"{text}: a used input is {words}"
    return meanings


class CompensatorSlave(DriftSlave):
    """Temperatures, speed and tool length in; axis offsets, pose and status out."""

    # A gap in the clock is time without samples, which the checks and limits handle.
    clock_may_jump: ClassVar[bool] = True
    enumerations: ClassVar[dict[str, dict[int, str]]] = {"Status": status_meanings()}

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._reals = [self.refs[name] for name in REALS]
        self._valid, self._text = self.refs["valid"], self.refs["status_text"]
        self._codes = [self.refs["status"], self.refs["status_sensor"]]
        self._probed = self.refs[MEASURED]

    def declare(self) -> Sequence[Variable]:
        """Return the variables for the bundled file."""
        self._bundled = parse_model(self.resource(MODEL_FILE), MODEL_FILE)
        return variables(self._bundled)

    def prepare(self) -> None:
        """Use the bundled file, or the one that the parameter names.

        Raises
        ------
        FmuError
            If that file cannot be used.
        """
        path = str(self.parameters["model_file"])
        model = _other_model(path, self._bundled) if path else self._bundled
        names = [sensor.name for sensor in self._bundled.sensors]
        self._count = len(names)
        places = [names.index(sensor.name) for sensor in model.sensors]
        self._places = None if places == list(range(len(names))) else places
        # status_sensor counts this FMU's inputs, whichever file is in use.
        self._numbers = [0, *(place + 1 for place in places)]
        self._compensator = RunningCompensator(model)
        # Another file may predict other targets than this FMU has inputs for.
        self._takes_measured = model.targets == self._bundled.targets

    def begin(self) -> None:
        """Set the outputs before the first sample."""
        self.outputs.update(dict.fromkeys(self._reals, 0.0))
        for name in HALF_WIDTHS:
            self.put(name, NOT_KNOWN)
        self.put("valid", False)
        self.put("status", WAITING)
        self.put("status_sensor", 0)
        self.put("status_text", STATUS_TEXTS[WAITING])

    def advance(self, time_s: float, step_s: float) -> None:
        """Process the sample at *time_s*; the outputs are those at the end of the step."""
        count = self._count
        values = list(self.inputs.values())
        temperatures, speed, tool_length = values[:count], values[count], values[count + 1]
        if self._places is not None:
            temperatures = [temperatures[place] for place in self._places]
        measured = None
        if self._takes_measured and self.settable["boolean"][self._probed]:
            measured = values[count + 2 :]
        output = self._compensator.step(time_s, step_s, temperatures, speed, tool_length, measured)
        *reals, valid, status, blamed, text = output
        self.outputs.update(zip(self._reals, reals, strict=True))
        results, (status_ref, blamed_ref) = self.results, self._codes
        results["integer"][status_ref] = status
        results["integer"][blamed_ref] = self._numbers[blamed]
        results["boolean"][self._valid] = valid
        results["string"][self._text] = text

    def hidden(self) -> dict[str, Any]:
        """Return the compensator's memory."""
        return self._compensator.state()

    def restore(self, state: dict[str, Any]) -> None:
        """Restore the compensator's memory."""
        self._compensator.restore(state)


def variables(model: Model) -> list[Variable]:
    """Return the FMU's variables for a compensator file.

    Parameters
    ----------
    model : Model
        Its sensors become the temperature inputs, in its order.
    """
    used = {model.sensors[index].name for index in model.chosen}
    low, high = model.limits.tool_length_mm

    def said(name: str) -> str:
        use = "used by the error model" if name in used else "not used by the bundled file"
        return f"Temperature {name}, {use}; NaN: missing"

    allowed = f"the bundled file allows {low:g} to {high:g} mm"
    if not model.geometry.needs_tool_length:
        allowed = "the bundled file's drift is that of the tool that was measured, and ignores it"
    tool = f"From the gauge line to the tool tip; {allowed}"
    limit = f"the bundled file stays within {model.limits.offset_um:g} um"
    sent = f"axis: the drift of the tool tip with the opposite sign; {limit}"
    start = model.limits.judged_tool()
    needed = ", used by the bundled file" if model.uses_speed else ""
    units = {target: "urad" if target in ("yaw", "pitch") else "um" for target in model.targets}
    shown = f"drift since the start; counts while {MEASURED} is true"
    return [
        *(
            _input(sensor.name, said(sensor.name), "degC", -60.0, 400.0, 20.0, START_DEGC)
            for sensor in model.sensors
        ),
        _input("speed", f"Spindle speed{needed}; NaN: not known", "rpm", -1e6, 1e6, 1e4),
        _input("tool_length", tool, "mm", -LONGEST_TOOL_MM, LONGEST_TOOL_MM, USUAL_TOOL_MM, start),
        *(
            _input(f"{MEASURED}_{target}", f"Measured {target}, {shown}", unit, -1e6, 1e6, 10.0)
            for target, unit in units.items()
        ),
        Variable(
            MEASURED,
            "boolean",
            "input",
            "True with a sample whose measured targets are to be used; false: the model continues "
            "without them",
        ),
        *(_output(f"d{axis}", f"Offset to send to the {axis} {sent}", "um") for axis in "XYZ"),
        _output(
            "elongation", "Predicted growth of the spindle, its nose towards -Z positive", "um"
        ),
        _output("yaw", "Predicted tilt in the XZ plane", "urad"),
        _output("pitch", "Predicted tilt in the YZ plane", "urad"),
        *_half_widths(model),
        _told("boolean", "valid", "True while the offsets follow the model"),
        _told(
            "integer",
            "status",
            "0 ok, 1 waiting, 2 outside training, 3 recovering, 4 going on without a sensor, "
            "11 to 14 holding, 21 to 24 ramping to zero, 31 to 34 at zero; units: 1 missing, "
            "2 implausible, 3 too fast, 4 stale",
            0,
            34,
        ),
        _told(
            "integer",
            "status_sensor",
            "Number of the temperature input to blame, from 1; 0: none",
            0,
            len(model.sensors),
        ),
        _told(
            "string",
            "status_text",
            "The status in words, with its cause, and which offsets are at their limit",
        ),
        Variable(
            "model_file",
            "string",
            "parameter",
            "Path of another compensator file to use; empty: the bundled one. Its sensors must be "
            "among this FMU's temperature inputs",
        ),
    ]


def taken_name(model: Model) -> str | None:
    """Return the first sensor with the name of another variable of the FMU; None if none has."""
    count = len(model.sensors)
    own = {"time", *(variable.name for variable in variables(model)[count:])}
    return next((sensor.name for sensor in model.sensors if sensor.name in own), None)


def _input(
    name: str,
    description: str,
    unit: str,
    low: float,
    high: float,
    nominal: float,
    start: float = 0.0,
) -> Variable:
    return Variable(
        name,
        "real",
        "input",
        description,
        unit=unit,
        low=low,
        high=high,
        nominal=nominal,
        start=start,
    )


def share_promised(model: Model) -> str:
    """Return how much of unseen drift the intervals contain, for people to read.

    Parameters
    ----------
    model : Model
    """
    return f"{100 * model.new_gaussian().coverage:g} %"


def _half_widths(model: Model) -> list[Variable]:
    """Return the outputs for the uncertainty of the prediction."""
    share = share_promised(model)
    return [
        _output(
            f"d{axis}_uncertainty",
            f"Half the width of the interval around the compensated {axis} drift that contains "
            f"{share} of unseen drift; -1: not known",
            "um",
            low=NOT_KNOWN,
        )
        for axis in "XYZ"
    ]


def _output(name: str, description: str, unit: str, low: float = -1e5) -> Variable:
    variable = _told("real", name, description, low, 1e5)
    return replace(variable, unit=unit, nominal=10.0)


def _told(
    kind: Kind, name: str, description: str, low: float | None = None, high: float | None = None
) -> Variable:
    return Variable(name, kind, "output", description, low=low, high=high, depends_at_start=())


def _other_model(path: str, bundled: Model) -> Model:
    """Read the file named by the user.

    Raises
    ------
    FmuError
        If it cannot be read, or requires a temperature that this FMU has no input for.
    """
    try:
        model = load_model(path)
    except ModelFileError as error:
        raise FmuError(f"model_file: {error}") from None
    names = [sensor.name for sensor in bundled.sensors]
    for number, sensor in enumerate(model.sensors):
        if sensor.name not in names:
            raise FmuError(
                f"model_file: {path}: sensors.{number}.name: {sensor.name!r} is not allowed: this"
                f" FMU's temperature inputs are {', '.join(names)}"
            )
    return model
