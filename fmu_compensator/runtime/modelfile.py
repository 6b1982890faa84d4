"""The compensator file: the only definition of its content.

Reading checks every field. Writing goes through the same checks (`model_text`), so a file written
by this module can always be read.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from fmu_compensator.runtime.checks import Sensor
from fmu_compensator.runtime.error_models import error_models, shipped_error_models
from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import LARGEST, Fields, ModelFileError
from fmu_compensator.runtime.gaussian import Gaussian
from fmu_compensator.runtime.geometry import Geometry, geometry_from_fields
from fmu_compensator.runtime.limits import Limits
from fmu_compensator.runtime.spare import Spare

__all__ = [
    "Model",
    "ModelFileError",
    "load_model",
    "model_text",
    "parse_model",
]

FORMAT = 4
"""Given by the form of the file: 1 and 2 held an error model and layers around it, 3 one Gaussian,
4 also how the errors of its targets are correlated."""
KIND = "spindle-drift compensator"
INPUT_FORMS = ("rise", "absolute", "level")


@dataclass(frozen=True)
class Model:
    """A compensator file, checked.

    Attributes
    ----------
    name, title : str
        A short name, and the name in reports.
    created : str or None
        Date given by the file's author (YYYY-MM-DD).
    sensors : tuple of Sensor
        All temperature inputs, in the order of the compensator's variables.
    chosen : tuple of int
        Indices of the sensors that the error model uses.
    input_form : {"rise", "absolute", "level"}
        ``rise``: the error model's inputs are temperatures minus their first valid reading [K].
        ``absolute``: the readings themselves [degC]. ``level``: also the readings, for an error
        model whose drift counts from the start.
    targets : tuple of str
        What the error model predicts, in the geometry's order.
    geometry : Geometry
        Converts targets to the drift of the tool tip.
    limits : Limits
        Limits of the offsets.
    provenance : dict
        Runs, options and figures of merit of the fit.
    table : dict
        The file's content as read.
    source : str
        Where the file was read from.
    """

    name: str
    title: str
    created: str | None
    sensors: tuple[Sensor, ...]
    chosen: tuple[int, ...]
    input_form: str
    targets: tuple[str, ...]
    geometry: Geometry
    limits: Limits
    provenance: dict[str, Any]
    table: dict[str, Any]
    source: str

    @property
    def uses_speed(self) -> bool:
        """Whether the spindle speed is an input of the Gaussian."""
        return "speed_rpm" in self.table["gaussian"]

    def new_error_model(self) -> ErrorModel:
        """Return a new error model; it may have states, so each compensator needs its own."""
        fields = Fields(self.table["error_model"], self.source, "error_model")
        models = shipped_error_models()
        if fields.raw("kind") not in [*models]:  # search for plug-ins only if needed
            models = error_models()
        kind = fields.choice("kind", tuple(models))
        if tuple(fields.names("targets")) != self.targets:
            raise fields.refusal("targets", f"must be {', '.join(self.targets)} for this geometry")
        model = models[kind].from_fields(fields, len(self.chosen), len(self.targets))
        fields.done()
        return model

    def new_gaussian(self) -> Gaussian:
        """Return a new Gaussian to correct the error model."""
        fields = Fields(self.table["gaussian"], self.source, "gaussian")
        return Gaussian.from_fields(fields, len(self.chosen), len(self.targets))

    def new_spare(self) -> Spare | None:
        """Return a new estimator for broken sensors; None if the file has none."""
        if self.table["spare"] is None:
            return None
        fields = Fields(self.table["spare"], self.source, "spare")
        return Spare.from_fields(fields, len(self.chosen), len(self.targets))


def load_model(path: str | Path) -> Model:
    """Read a compensator file.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    Model
        Its ``source`` is the path.

    Raises
    ------
    ModelFileError
        One line: file, place, value and what is allowed.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise ModelFileError(str(path), "", f"cannot be read: {error.strerror}") from None
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ModelFileError(str(path), f"byte {error.start}", "is not UTF-8 text") from None
    return parse_model(text, str(path))


def parse_model(text: str, source: str) -> Model:
    """Return the model of a compensator file's content.

    Parameters
    ----------
    text : str
        The content.
    source : str
        The file, named in error messages.

    Raises
    ------
    ModelFileError
        One line: source, place, value and what is allowed.
    """
    try:
        table = json.loads(text, object_pairs_hook=_table, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise ModelFileError(source, place, f"is not JSON: {error.msg}") from None
    except RecursionError:
        raise ModelFileError(source, "", "is not allowed: nested too deeply") from None
    except ValueError as error:  # a duplicate field, NaN, a number with thousands of digits
        raise ModelFileError(source, "", f"is not allowed: {error}") from None
    return _model(table, source)


def model_text(table: dict[str, Any], source: str = "compensator file") -> str:
    """Return the file's text for *table* after checking it.

    Parameters
    ----------
    table : dict
        The content: numbers, texts, lists and tables only; NaN is not allowed.
    source : str
        Named in error messages.

    Raises
    ------
    ModelFileError
        If the table could not be read back.
    """
    try:
        text = json.dumps(table, indent=1, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        if isinstance(error, ValueError):
            _model(table, source)  # names the place of a number that is not finite
        raise ModelFileError(source, "", f"cannot be written: {error}") from None
    parse_model(text, source)
    return text


def _model(table: object, source: str) -> Model:
    fields = Fields(table, source)
    fields.choice("kind", (KIND,))
    number = fields.integer("format", 1, int(LARGEST))
    if number > FORMAT:
        raise fields.refusal(
            "format", f"the file was written by a newer version; this one reads format {FORMAT}"
        )
    if number < FORMAT:
        again = "fit it again from its runs: spindle-drift fit RUN... -o FILE"
        raise fields.refusal("format", f"{number} is of an older version; {again}")
    created = fields.raw("created")
    if created is not None:
        _check_date(fields, fields.text("created"))
    sensors = _sensors(fields)
    chosen = _chosen(fields, sensors)
    geometry = geometry_from_fields(fields.table("geometry"))
    limits = Limits.from_fields(fields.table("limits"))
    model = Model(
        name=fields.name("name"),
        title=fields.text("title"),
        created=created,
        sensors=sensors,
        chosen=chosen,
        input_form=fields.choice("input_form", INPUT_FORMS),
        targets=geometry.targets,
        geometry=geometry,
        limits=limits,
        provenance=_provenance(fields.table("provenance")),
        table=fields.as_table(),
        source=source,
    )
    for key in ("error_model", "gaussian", "spare"):
        fields.raw(key)
    model.new_error_model()
    model.new_gaussian()
    model.new_spare()
    fields.done()
    return model


def _sensors(fields: Fields) -> tuple[Sensor, ...]:
    sensors: dict[str, Sensor] = {}
    for table in fields.tables("sensors", "sensors", 1):
        sensor = Sensor.from_fields(table)
        if sensor.name in sensors:
            raise table.refusal("name", f"'{sensor.name}' is not allowed: another sensor has it")
        sensors[sensor.name] = sensor
    return tuple(sensors.values())


def _chosen(fields: Fields, sensors: tuple[Sensor, ...]) -> tuple[int, ...]:
    names = [sensor.name for sensor in sensors]
    chosen = fields.names("chosen")
    for index, name in enumerate(chosen):
        if name not in names:
            place = f"chosen.{index}"
            raise fields.refusal(place, f"'{name}' is not allowed: must be one of the sensors")
    return tuple(names.index(name) for name in chosen)


def _provenance(fields: Fields) -> dict[str, Any]:
    for run in fields.tables("runs", "runs"):
        run.text("name")
        digest = run.text("sha256")
        if len(digest) != 64 or not set(digest) <= set("0123456789abcdef"):
            raise run.refusal("sha256", f"'{digest[:20]}' is not allowed: must be 64 hex digits")
        run.integer("rows", 0, int(LARGEST))
        run.done()
    for index, note in enumerate(fields.items("notes", "texts")):
        if not isinstance(note, str):
            raise fields.refusal(f"notes.{index}", "must be a text")
    fields.table("options").keys()
    if fields.has("rig"):
        fields.table("rig").keys()
    _check_figures(fields.table("figures"))
    fields.done()
    return fields.as_table()


def _check_figures(fields: Fields) -> None:
    """Refuse figures of merit that `monitor` and `update` need; any may be missing."""
    fields.keys()
    given = {key: value for key, value in fields.as_table().items() if value is not None}
    unseen = Fields(given.get("unseen", {}), fields.source, f"{fields.place}.unseen")
    sizes, shares = ("model", "no_model"), ("expected", "inside")
    for table, key, names in (
        (fields, "training", sizes),
        (unseen, "promised", sizes),
        (unseen, "like", sizes + shares),
        (unseen, "unlike", sizes + shares),
    ):
        axes = table.table(key) if table.has(key) else Fields({}, fields.source)
        for row in map(axes.table, axes.keys()):
            for name in names:
                row.number(name, 0.0, LARGEST)
        if names != sizes and table.has(key):
            table.number(f"{key}_behind", 0.0, LARGEST)
    for run in unseen.tables("by_run", "runs") if unseen.has("by_run") else ():
        misses = [0.0 if miss is None else miss for miss in run.items("miss", "numbers", 3, 3)]
        Fields({"miss": misses}, run.source, run.place).numbers("miss", 3, low=0.0)
    # As many as `fmu_compensator.fit.run_conditions` names, which a runtime does not have.
    ranges = fields.items("conditions", "ranges", 4, 4) if "conditions" in given else ()
    known_ranges = {str(place): limits for place, limits in enumerate(ranges) if limits is not None}
    for place in known_ranges:
        Fields(known_ranges, fields.source, f"{fields.place}.conditions").numbers(place, 2)


def _check_date(fields: Fields, text: str) -> None:
    try:
        date.fromisoformat(text)
    except ValueError:
        raise fields.refusal(
            "created", f"'{text[:40]}' is not allowed: must be a date such as 2026-01-31 or null"
        ) from None


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) != len(pairs):
        names = [name for name, _ in pairs]
        double = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the field {double[:60]!r} stands twice in one table")
    return table


def _refuse_constant(text: str) -> float:
    raise ValueError(f"{text} is not a number")
