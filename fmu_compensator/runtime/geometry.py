"""From predicted quantities to the drift of the tool tip.

Only for the compensator. A plant has its own geometry: sharing it would hide shared mistakes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import sqrt, tan

from fmu_compensator.runtime.fields import Fields

UM_PER_MM = 1e3
RAD_PER_URAD = 1e-6
"""Given by the prefixes of units."""
FIVE_POINT_TARGETS = ("elongation", "yaw", "pitch", "near_x", "near_y")
FORMS = ("rigid", "pure_rotation")
AXES = ("X", "Y", "Z")


class Geometry(ABC):
    """Turns the targets of an error model into the drift of the tool tip."""

    targets: tuple[str, ...]
    needs_tool_length: bool

    @abstractmethod
    def drift(self, targets: Sequence[float], tool_length_mm: float) -> tuple[float, float, float]:
        """Return the tool tip's drift along +X, +Y and +Z [um].

        Parameters
        ----------
        targets : sequence of float
            In the order of the geometry's ``targets`` [um, urad].
        tool_length_mm : float
            From the gauge line to the tool tip [mm]; ignored if ``needs_tool_length`` is false.

        Returns
        -------
        x, y, z : float
            [um]
        """

    @abstractmethod
    def weights(self, tool_length_mm: float) -> list[list[float]]:
        """Return the derivatives of the drift at zero: rows X, Y, Z [um/um, um/urad].

        Parameters
        ----------
        tool_length_mm : float
            From the gauge line to the tool tip [mm].
        """

    @abstractmethod
    def pose(self, targets: Sequence[float]) -> tuple[float, float, float]:
        """Return elongation [um], yaw and pitch [urad]; 0 if the rig does not measure them.

        Parameters
        ----------
        targets : sequence of float
            In the order of the geometry's ``targets`` [um, urad].

        Returns
        -------
        elongation, yaw, pitch : float
            [um], [urad], [urad]
        """


class FivePoint(Geometry):
    r"""A rig with two radial sensors per direction and one axial sensor.

    Parameters
    ----------
    form : {"rigid", "pure_rotation"}
        ``rigid``: the tool continues the line through the near and distal sensors,
        ``dX = near_x + (L - l1) tan(yaw)``. ``pure_rotation``: the spindle turns about the gauge
        line and has no radial drift there, ``dX = L tan(yaw)``.
    near_to_gauge_mm : float
        Distance l1 from the gauge line to the near sensors [mm].
    spacing_mm : float
        Distance from the near to the distal sensors along the axis [mm].

    Notes
    -----
    With the elongated tool of length L + E along an axis tilted by theta,
    ``dZ = L - (L + E) cos(theta)``, ``1/cos^2(theta) = 1 + tan^2(yaw) + tan^2(pitch)``. To second
    order this is ``-E`` for every L. The source studies stop there; the exact term costs nothing.

    The drift is linear in L only while the bar stays straight: within the sensors' span (tool
    lengths up to l1 + spacing) and a little beyond. The file's ``tool_length_mm`` gives the limits.
    """

    targets = FIVE_POINT_TARGETS
    needs_tool_length = True

    def __init__(self, form: str, near_to_gauge_mm: float, spacing_mm: float) -> None:
        self.form, self.near_to_gauge_mm, self.spacing_mm = form, near_to_gauge_mm, spacing_mm

    @classmethod
    def from_fields(cls, fields: Fields) -> FivePoint:
        """Return the geometry of a file's table.

        Parameters
        ----------
        fields : Fields
            The table ``geometry``; ``kind`` has already been read.

        Raises
        ------
        ModelFileError
            For a number that is missing or outside its range, and for a spacing of 0.
        """
        geometry = cls(
            fields.choice("form", FORMS),
            fields.number("near_to_gauge_mm", -10_000, 10_000),
            fields.number("spacing_mm", -10_000, 10_000),
        )
        if geometry.spacing_mm == 0:
            raise fields.refusal("spacing_mm", "0 is not allowed: must be a distance")
        return geometry

    def drift(self, targets: Sequence[float], tool_length_mm: float) -> tuple[float, float, float]:
        """Return the tool tip's drift along +X, +Y and +Z [um]."""
        elongation, yaw, pitch, near_x, near_y = targets
        slope_x, slope_y = tan(yaw * RAD_PER_URAD), tan(pitch * RAD_PER_URAD)
        length = tool_length_mm * UM_PER_MM
        squares = slope_x * slope_x + slope_y * slope_y
        cosine = 1.0 / sqrt(1.0 + squares)
        # 1 - cosine, without the small difference of two long lengths.
        z = length * (squares * cosine * cosine / (1.0 + cosine)) - elongation * cosine
        if self.form == "pure_rotation":
            return length * slope_x, length * slope_y, z
        beyond = length - self.near_to_gauge_mm * UM_PER_MM
        return near_x + beyond * slope_x, near_y + beyond * slope_y, z

    def weights(self, tool_length_mm: float) -> list[list[float]]:
        """Return the derivatives of the drift at zero: rows X, Y, Z [um/um, um/urad]."""
        turning = self.form == "pure_rotation"
        near = 0.0 if turning else 1.0
        arm = tool_length_mm - (0.0 if turning else self.near_to_gauge_mm)
        slope = arm * UM_PER_MM * RAD_PER_URAD
        return [
            [0.0, slope, 0.0, near, 0.0],
            [0.0, 0.0, slope, 0.0, near],
            [-1.0, 0.0, 0.0, 0.0, 0.0],
        ]

    def pose(self, targets: Sequence[float]) -> tuple[float, float, float]:
        """Return elongation [um], yaw and pitch [urad]."""
        return targets[0], targets[1], targets[2]


class Direct(Geometry):
    """Displacement columns that each measure one axis, regardless of the tool.

    Parameters
    ----------
    axes : dict
        By target name: the axis, and +1 if the column grows as the tool tip drifts in the positive
        direction, -1 if it grows the other way.

    Attributes
    ----------
    axes : tuple of str
        The measured axes, one per target.
    """

    needs_tool_length = False

    def __init__(self, axes: dict[str, tuple[str, int]]) -> None:
        self.targets = tuple(axes)
        self._places = [(AXES.index(axis), sign) for axis, sign in axes.values()]
        self.axes = tuple(axis for axis, _ in axes.values())

    @classmethod
    def from_fields(cls, fields: Fields) -> Direct:
        """Return the geometry of a file's table.

        Parameters
        ----------
        fields : Fields
            The table ``geometry``; ``kind`` has already been read.

        Raises
        ------
        ModelFileError
            If no column is given, a sign is neither 1 nor -1, or two columns measure the same
            axis.
        """
        table = fields.table("axes")
        axes: dict[str, tuple[str, int]] = {}
        for name in table.keys():  # noqa: SIM118 - a method that also marks the keys as known
            entry = table.table(name)
            axis, sign = entry.choice("axis", AXES), entry.integer("sign", -1, 1)
            entry.done()
            if sign == 0:
                raise entry.refusal("sign", "0 is not allowed: must be 1 or -1")
            if axis in [other for other, _ in axes.values()]:
                raise entry.refusal("axis", f"'{axis}' is not allowed: another column has it")
            axes[name] = (axis, sign)
        if not axes:
            raise fields.refusal("axes", "is empty: at least one column is needed")
        return cls(axes)

    def drift(self, targets: Sequence[float], tool_length_mm: float) -> tuple[float, float, float]:
        """Return the tool tip's drift along +X, +Y and +Z [um]; 0 for an unmeasured axis."""
        drift = [0.0, 0.0, 0.0]
        for (place, sign), value in zip(self._places, targets, strict=True):
            drift[place] = sign * value
        return drift[0], drift[1], drift[2]

    def weights(self, tool_length_mm: float) -> list[list[float]]:
        """Return the derivatives of the drift by the targets: rows X, Y, Z [1]."""
        rows = [[0.0] * len(self._places) for _ in AXES]
        for target, (place, sign) in enumerate(self._places):
            rows[place][target] = float(sign)
        return rows

    def pose(self, targets: Sequence[float]) -> tuple[float, float, float]:
        """Return the elongation [um]: growth towards -Z if Z is measured; tilts are 0 [urad]."""
        return (-self.drift(targets, 0.0)[2] if "Z" in self.axes else 0.0), 0.0, 0.0


def geometry_from_fields(fields: Fields) -> FivePoint | Direct:
    """Return the geometry that a file's table describes.

    Parameters
    ----------
    fields : Fields
        The table ``geometry``, not read yet.

    Raises
    ------
    ModelFileError
        For the first field that is missing, unknown or not allowed.
    """
    kind = fields.choice("kind", ("five_point", "direct"))
    geometry = FivePoint.from_fields(fields) if kind == "five_point" else Direct.from_fields(fields)
    fields.done()
    return geometry
