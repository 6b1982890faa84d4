"""Measuring rigs: convert displacement readings to the pose of the spindle nose.

Coordinates: Z along the spindle axis, X and Y across it. Elongation is positive when the nose
grows towards -Z; yaw is the tilt in the XZ plane and pitch the tilt in the YZ plane. Distances
along the axis are counted from the gauge line outwards, towards the tool's tip.

Source of the five-point equations: methods of the spindle studies, after ISO 230-3.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from measurement.errors import BadInput, checked, shown
from measurement.runs import FloatArray, Run
from measurement.units import RAD_PER_URAD, UM_PER_MM, column, split_column

Sign = Literal[1, -1]
AxisName = Literal["X", "Y", "Z"]
AXES: tuple[AxisName, ...] = ("X", "Y", "Z")

POSE = ("elongation_um", "yaw_urad", "pitch_urad", "near_x_um", "near_y_um")
"""Columns of a pose, in order."""

PLACES = ("near_x", "near_y", "distal_x", "distal_y", "axial")
"""Places of the sensors of a five-point rig."""

_AXIAL_WORDS = {"growth", "elongation", "axial"}
_NOT_DRIFT = {"offset", "error"}  # the plant's other signals per axis

Distance = Annotated[float, Field(ge=-10_000.0, le=10_000.0, allow_inf_nan=False)]


Fineness = Annotated[float, Field(ge=0.0, le=1_000.0, allow_inf_nan=False)]


class _Rig(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SimulatedRig(_Rig):
    """Noise and resolution of the sensors of any rig, for simulated runs."""

    noise_um: Fineness = 0.0
    """Standard deviation of every displacement sensor's noise."""
    resolution_um: Fineness = 0.0
    """Resolution of every displacement sensor."""

    @property
    def columns(self) -> list[str]:
        """The rig's run-file columns, in order."""
        raise NotImplementedError

    def fits(self, run: Run) -> bool:
        """Return whether the run has all the columns.

        Parameters
        ----------
        run : Run
        """
        return set(self.columns) <= set(run.frame.columns)


class FivePointRig(SimulatedRig):
    """Five displacement sensors at a test bar: two across near, two across distal, one axial.

    Attributes
    ----------
    near_x, near_y, distal_x, distal_y, axial : str
        The signals' names; each is the run-file column ``<name>_um``.
    spacing_mm : float
        Distance of the distal pair beyond the near pair, counted outwards from the nose; negative
        if the distal pair is nearer the nose [mm].
    near_to_gauge_mm : float
        Distance of the near pair outside the gauge line [mm].
    axial_sign : +1 or -1
        Elongation is this times the axial reading; -1 if the reading is drift along +Z.
    near_x_sign, near_y_sign, distal_x_sign, distal_y_sign : +1 or -1
        Drift along the axis is this times the reading: -1 for a sensor that looks the other way.
    test_bar_mm : float
        Distance of the axial sensor's target outside the gauge line; a tilted bar appears shorter
        by about test_bar_mm (1 - cos), which is corrected [mm].
    noise_um, resolution_um : float
        Every sensor's noise (standard deviation) and resolution, for simulated rigs [um].
    """

    kind: Literal["five_point"] = "five_point"
    near_x: str = Field("S1", min_length=1)
    near_y: str = Field("S2", min_length=1)
    distal_x: str = Field("S3", min_length=1)
    distal_y: str = Field("S4", min_length=1)
    axial: str = Field("S5", min_length=1)
    spacing_mm: Distance
    near_to_gauge_mm: Distance
    axial_sign: Sign = -1
    near_x_sign: Sign = 1
    near_y_sign: Sign = 1
    distal_x_sign: Sign = 1
    distal_y_sign: Sign = 1
    test_bar_mm: Distance = 0.0

    @field_validator("spacing_mm")
    @classmethod
    def _apart(cls, spacing_mm: float) -> float:
        if abs(spacing_mm) < 1.0:
            raise ValueError("must be at least 1 mm in either direction to measure tilt")
        return spacing_mm

    @model_validator(mode="after")
    def _consistent(self) -> FivePointRig:
        names = list(self.sensors)
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"sensor {twice!r} has two places; each place needs its own sensor")
        return self

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the five signals, in the order of `PLACES`."""
        return tuple(getattr(self, place) for place in PLACES)

    @property
    def columns(self) -> list[str]:
        """The five run-file columns, in the same order."""
        return [column(name, "um") for name in self.sensors]

    def pose(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Return the pose of the spindle from the five readings.

        yaw = atan((x_distal - x_near) / D), pitch = atan((y_distal - y_near) / D).

        Parameters
        ----------
        frame : DataFrame
            Has the five columns [um].

        Returns
        -------
        DataFrame
            ``elongation_um``, ``yaw_urad``, ``pitch_urad``, ``near_x_um``, ``near_y_um``; the
            frame's index. NaN wherever a reading that it needs is missing.

        Raises
        ------
        BadInput
            If a column is missing.
        """
        self._need(frame)
        near_x, near_y, distal_x, distal_y, axial = (
            frame[name].to_numpy(dtype=np.float64) for name in self.columns
        )
        x, y = self.near_x_sign * near_x, self.near_y_sign * near_y
        spacing = self.spacing_mm * UM_PER_MM
        slope_x = (self.distal_x_sign * distal_x - x) / spacing
        slope_y = (self.distal_y_sign * distal_y - y) / spacing
        elongation = self.axial_sign * axial
        if self.test_bar_mm:  # else an axial reading would be lost with a missing radial one
            bar = self.test_bar_mm * UM_PER_MM
            # (reading + bar) / cos - bar, written so that no digits cancel.
            elongation = elongation + (elongation + bar) * _less_one(slope_x, slope_y)
        tilt = np.arctan([slope_x, slope_y]) / RAD_PER_URAD
        values = (elongation, *tilt, x, y)
        return pd.DataFrame(dict(zip(POSE, values, strict=True)), index=frame.index)

    def targets(self, run: Run) -> pd.DataFrame:
        """Return the targets of an error model in a run: the measured pose.

        Parameters
        ----------
        run : Run
            Has the five columns [um].

        Returns
        -------
        DataFrame
            Elongation, yaw, pitch and the radial drift, as `pose` returns them [um, urad].

        Raises
        ------
        BadInput
            If a column is missing.
        """
        self._need(run.frame, run.path or run.name)
        return self.pose(run.frame)

    def _need(self, frame: pd.DataFrame, source: str | Path = "rig") -> None:
        for place, name in zip(PLACES, self.columns, strict=True):
            if name not in frame.columns:
                raise BadInput(source, place, f"the run has no column {name}{_has(frame)}")


def _less_one(slope_x: FloatArray, slope_y: FloatArray) -> FloatArray:
    """Return 1/cos(tilt) - 1, accurate even for tilts of a few microradians."""
    q = slope_x**2 + slope_y**2
    return q / (1.0 + np.sqrt(1.0 + q))


class AxisOfColumn(_Rig):
    """The axis that a displacement column measures, and its sign.

    Attributes
    ----------
    axis : X, Y or Z
        The machine axis.
    sign : +1 or -1
        Drift along the axis is this times the reading.
    """

    axis: AxisName
    sign: Sign = 1


class DirectRig(SimulatedRig):
    """Displacement columns that each measure the drift along one axis, without tilt.

    Attributes
    ----------
    axes : dict of str to AxisOfColumn
        By signal name, for example ``{"disp_x": {"axis": "X", "sign": 1}}``.
    noise_um, resolution_um : float
        Standard deviation of the noise, and resolution, of every sensor: for simulated rigs [um].
    """

    kind: Literal["direct"] = "direct"
    axes: dict[str, AxisOfColumn] = Field(min_length=1)

    @model_validator(mode="after")
    def _one_each(self) -> DirectRig:
        names = [entry.axis for entry in self.axes.values()]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"axis {twice} has two columns; each axis may have one")
        return self

    @property
    def columns(self) -> list[str]:
        """The run-file columns, in the order given."""
        return [column(name, "um") for name in self.axes]

    def targets(self, run: Run) -> pd.DataFrame:
        """Return the targets of an error model in a run: the measured displacement columns.

        Parameters
        ----------
        run : Run
            Has the rig's columns.

        Returns
        -------
        DataFrame
            Displacements [um], one column per axis under its own name, rows as in the run.

        Raises
        ------
        BadInput
            If a column is missing.
        """
        self._need(run.frame, run.path or run.name)
        return run.frame[self.columns].copy()

    def drift(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Return the drift ``drift_X_um`` ... in +axis direction, for the axes that the rig has.

        Parameters
        ----------
        frame : DataFrame
            Has the rig's columns [um].

        Raises
        ------
        BadInput
            If a column is missing.
        """
        self._need(frame)
        sources = {entry.axis: (name, entry.sign) for name, entry in self.axes.items()}
        return pd.DataFrame(
            {
                f"drift_{axis}_um": sources[axis][1] * frame[column(sources[axis][0], "um")]
                for axis in AXES
                if axis in sources
            }
        )

    def _need(self, frame: pd.DataFrame, source: str | Path = "rig") -> None:
        for name in self.columns:
            if name not in frame.columns:
                raise BadInput(source, "axes", f"the run has no column {name}{_has(frame)}")


Rig = FivePointRig | DirectRig


def rig_from_table(table: dict[str, Any], source: str | Path) -> Rig:
    """Return the rig that a table of a machine file or a compensator file describes.

    Parameters
    ----------
    table : dict
        ``kind`` is ``five_point`` (the default) or ``direct``.
    source : str or path
        The file, for refusals.

    Raises
    ------
    BadInput
        For a field that is missing, unknown, or outside its range.
    """
    kind = table.get("kind", "five_point")
    if kind == "five_point":
        return checked(FivePointRig, table, source)
    if kind == "direct":
        return checked(DirectRig, table, source)
    raise BadInput(source, "kind", f"{shown(kind)} is not allowed: five_point or direct")


def default_rig(run: Run, machine_rig: dict[str, Any] | Rig | None = None) -> Rig:
    """Return the rig of a run: the machine's if the run has its columns, else one from their names.

    A name with a part ``x``, ``y`` or ``z`` (``disp_x_um``) is drift in +axis direction; one with
    ``growth``, ``elongation`` or ``axial`` is growth of the nose, which is drift towards -Z.

    Parameters
    ----------
    run : Run
    machine_rig : dict or rig, optional
        From a machine file; without it the column names decide.

    Raises
    ------
    BadInput
        If neither defines a rig, or two columns measure the same axis.
    """
    if machine_rig is not None:
        given = machine_rig
        rig = rig_from_table(given, "rig") if isinstance(given, dict) else given
        if rig.fits(run):
            return rig
    axes: dict[str, dict[str, Any]] = {}
    owner: dict[str, str] = {}
    for name in run.displacements:
        signal = split_column(name)[0]
        axis_and_sign = axis_of(signal)
        if axis_and_sign is None or _NOT_DRIFT & _words(signal):
            continue
        axis, sign = axis_and_sign
        if axis in owner:
            problem = f"columns {owner[axis]} and {name} both stand for axis {axis}"
            raise BadInput(run.path or run.name, "", f"{problem}; {_HELP}")
        owner[axis] = name
        axes[signal] = {"axis": axis, "sign": sign}
    if not axes:
        problem = "no displacement column names its axis" + _has(run.frame)
        raise BadInput(run.path or run.name, "", f"{problem}; {_HELP}")
    return DirectRig.model_validate({"axes": axes})


_HELP = (
    "give it when importing (--axis 'NAME=X'), end the name in _x, _y or _z, or give a machine "
    "file whose [rig] says which column is which"
)


def axis_of(signal: str) -> tuple[AxisName, Sign] | None:
    """Return axis and sign of a displacement from its name, or None if the name has no axis."""
    words = _words(signal)
    named = [axis for axis in AXES if axis.lower() in words]
    if len(named) == 1:
        return named[0], 1
    return ("Z", -1) if not named and words & _AXIAL_WORDS else None


def _words(signal: str) -> set[str]:
    return set(re.split(r"[^a-z0-9]+", signal.lower()))


def _has(frame: pd.DataFrame) -> str:
    names = [str(name) for name in frame.columns if str(name).endswith("_um")]
    listed = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
    if names:
        return f" (its displacement columns: {listed})"
    lengths = [str(name) for name in frame.columns if str(name).endswith("_mm")]
    drifts = [name for name in lengths if axis_of(name.removesuffix("_mm"))]
    wrong_unit = f"; {not_in_mm(drifts)}" if drifts else ""
    return f" (it has no displacement column{wrong_unit})"


def not_in_mm(drifts: Sequence[str]) -> str:
    """Return what to say of columns that hold drifts in mm."""
    told = "a drift must be in um, not mm (spindle-drift import converts drifts)"
    return f"{told}: {', '.join(drifts)}"
