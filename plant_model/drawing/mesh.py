"""The spindle divided into cells: rings along the shaft, rings or sectors along the housing."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, log, pi, radians

from plant_model.drawing.cells import Cell, overlap, slices
from plant_model.drawing.form import PageForm, PatchForm, StretchForm, ThermometerForm, degrees
from plant_model.drawing.layout import Drawing
from plant_model.drawing.materials import Material

NAMED = {0.0: "xp", 90.0: "yp", 180.0: "xm", 270.0: "ym"}


SECTORS = (4, 8, 12, 16)
"""Numbers of sectors of the housing, given by the four axis directions, each the middle of a
sector; the largest is set on no data."""


def fewest_sectors(form: PageForm) -> int:
    """Return the lowest number of sectors with each housing thermometer in the middle of one.

    With four sectors, a tilt is within 3 % of that with sixteen, and a simulation three times as
    fast as with eight.

    Parameters
    ----------
    form : PageForm

    Returns
    -------
    int
        If no number fits, 8; the page is refused later.
    """
    sides = [
        degrees(entry.side)
        for entry in form.thermometers
        if entry.part == "housing" and entry.side is not None
    ]
    for count in SECTORS:
        turns = [side * count / 360.0 for side in sides]
        if all(abs(turn - round(turn)) < 1e-9 for turn in turns):
            return count
    return SECTORS[1]


@dataclass(frozen=True)
class Sector:
    """A sector of a housing cell, or the whole ring.

    Attributes
    ----------
    node : str
        Name of its node.
    angle : float or None
        Its middle, from X+ towards Y+ [deg]; None for a ring.
    share : float
        Share of the circumference [1].
    """

    node: str
    angle: float | None
    share: float

    def towards(self, angle: float) -> float:
        """Return the cosine of the angle between its middle and a direction [deg]; 0 for a ring."""
        return 0.0 if self.angle is None else cos(radians(self.angle - angle))

    def under(self, patch: PatchForm) -> float:
        """Return the share of the circumference that is in it and under a patch [1].

        Parameters
        ----------
        patch : PatchForm
        """
        if patch.side is None or self.angle is None:
            return self.share * patch.around
        apart = patch.apart(self.angle)
        half, wide = 180.0 * self.share, patch.width / 2.0
        # Wide arcs overlap on both sides of the circle.
        both = (_common(half, wide, apart), _common(half, wide, 360.0 - apart))
        return sum(both) / 360.0


def _common(half: float, wide: float, apart: float) -> float:
    """Return the overlap of two arcs, given their half widths and the angle between them [deg]."""
    return max(0.0, min(half, apart + wide) - max(-half, apart - wide))


class Mesh:
    """Cells of shaft and housing.

    Parameters
    ----------
    drawing : Drawing
    finer : float
        Factor by which cells are shorter than in the page.
    sectors : int, optional
        Number of sectors, instead of the page's.

    Attributes
    ----------
    shaft, housing : list of Cell
        From the rear to the nose.
    sectors : int
        Number around the axis, in stretches that are not even.
    """

    def __init__(self, drawing: Drawing, finer: float = 1.0, sectors: int | None = None) -> None:
        self.drawing = drawing
        form = drawing.form
        longest = form.cells.longest / finer
        self.sectors = sectors or form.cells.sectors or fewest_sectors(form)
        for part in ("shaft", "housing"):
            stretches = [(s.start, s.end) for s in getattr(form, part).stretches]
            read_at = [t.at for t in form.thermometers if t.part == part and t.at is not None]
            # Heat enters at the seats: a cell across an edge would spread it beyond the seat.
            edges = [edge for seat in drawing.seats for span in seat.spans for edge in span]
            setattr(self, part, slices(part, stretches, read_at, edges, longest))

    shaft: list[Cell]
    housing: list[Cell]

    def stretch(self, cell: Cell) -> StretchForm:
        """Return the stretch that a cell is cut from."""
        stretches: list[StretchForm] = getattr(self.drawing.form, cell.part).stretches
        return stretches[cell.stretch]

    def material(self, cell: Cell) -> Material:
        """Return the material of a cell."""
        return self.drawing.material(self.stretch(cell), cell.part)

    def section(self, cell: Cell) -> float:
        """Return the cross-section of a cell [m2]."""
        stretch = self.stretch(cell)
        return pi / 4.0 * (stretch.outer**2 - stretch.inner**2) * 1e-6

    def sectors_of(self, cell: Cell) -> list[Sector]:
        """Return the sectors of a cell.

        One for the whole ring if the page has one sector, or if the stretch is even or the shaft's.
        """
        count = self.sectors
        if count == 1 or cell.part == "shaft" or self.stretch(cell).even:
            return [Sector(cell.name, None, 1.0)]
        angles = [360.0 * k / count for k in range(count)]
        return [
            Sector(f"{cell.name}_{NAMED.get(a, f'a{a:g}'.replace('.', '_'))}", a, 1.0 / count)
            for a in angles
        ]

    def under(self, patch: PatchForm) -> list[tuple[Sector, float]]:
        """Return the sectors under a patch of the housing.

        Parameters
        ----------
        patch : PatchForm
            Along the axis and, if it is on one side, around it.

        Returns
        -------
        list of (Sector, float)
            Each with its share of the patch [1]; the sum is 1 if all of it is on the housing.
        """
        whole = (patch.end - patch.start) * patch.around
        return [
            (sector, length * share / whole)
            for cell, length in self.covered("housing", patch.start, patch.end)
            for sector in self.sectors_of(cell)
            if (share := sector.under(patch)) > 1e-9
        ]

    def into_wall(self, cell: Cell, seat: float) -> float:
        """Return ln(r / r_0) from a seat's diameter [mm] to a wall's mean temperature [1].

        Divided by 2 pi k L this is the resistance from the seat to the cell. A wall that is heated
        on one face and conducts the heat along itself has its mean temperature a third of its
        thickness away from that face.

        Parameters
        ----------
        cell : Cell
            The seat is on the outside of the shaft, or on the inside of the housing.
        seat : float
            Its diameter [mm].
        """
        stretch = self.stretch(cell)
        face, other = stretch.inner, stretch.outer
        if cell.part == "shaft":
            face, other = other, face
        return abs(log((face + (other - face) / 3.0) / seat))

    def covered(self, part: str, start: float, end: float) -> list[tuple[Cell, float]]:
        """Return the cells in a span, each with its length inside the span [mm].

        Parameters
        ----------
        part : {"shaft", "housing"}
        start, end : float
            Along the axis [mm].
        """
        cells: list[Cell] = getattr(self, part)
        shares = [(cell, overlap(cell, start, end)) for cell in cells]
        return [(cell, length) for cell, length in shares if length > 1e-9]

    def cell_of(self, part: str, at: float) -> Cell:
        """Return the cell of shaft or housing at a place.

        Parameters
        ----------
        part : {"shaft", "housing"}
        at : float
            Along the axis [mm]; beyond the nose it is in the last cell.
        """
        cells: list[Cell] = getattr(self, part)
        return next((cell for cell in cells if at <= cell.end), cells[-1])

    def read_by(self, place: str, thermometer: ThermometerForm) -> str:
        """Return the node of the shaft or the housing that a thermometer reads.

        Parameters
        ----------
        place : str
            Place of the thermometer in the page, for refusals.
        thermometer : ThermometerForm

        Raises
        ------
        BadInput
            If its place or side is missing, it is in the air, or its side is not the middle of a
            sector.
        """
        drawing, part = self.drawing, thermometer.part
        if thermometer.at is None:
            raise drawing.refuse(f"{place}.at", f"is missing: where on the {part} [mm]")
        low, high = drawing.span_of(part)
        if not low <= thermometer.at <= high:
            raise drawing.refuse(
                f"{place}.at",
                f"{thermometer.at:g} mm is in the air: the {part} is from {low:g} to {high:g} mm",
            )
        cell = self.cell_of(part, thermometer.at)
        sectors = self.sectors_of(cell)
        if sectors[0].angle is None:
            return sectors[0].node
        if thermometer.side is None:
            raise drawing.refuse(f"{place}.side", "is missing: X+, X-, Y+, Y- or degrees from X+")
        wanted = degrees(thermometer.side)
        for sector in sectors:
            if abs(sector.towards(wanted) - 1.0) < 1e-9:
                return sector.node
        allowed = ", ".join(f"{sector.angle:g}" for sector in sectors)
        raise drawing.refuse(
            f"{place}.side",
            f"{wanted:g} degrees is not the middle of a sector ({allowed}): move it, or set"
            f" cells.sectors to one of {', '.join(map(str, SECTORS))}",
        )
