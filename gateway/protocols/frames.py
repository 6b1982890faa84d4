"""Plain frames: those of a DBC file, or of a control by its map (``--dbc``, ``--map``)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gateway.protocols.base import Adapter
from measurement.errors import BadInput

if TYPE_CHECKING:
    from gateway.mapping import Mapping


def frames_of(name: str | None, dbc: Path | None) -> Mapping:
    """Return the frames of a command line: those of a map, or of a DBC file of the own form.

    Parameters
    ----------
    name : str or None
        A file, or the name of one that ships.
    dbc : Path or None
        A DBC file that was given; None without a map: the one that ships.

    Raises
    ------
    BadInput
        If it cannot be read.
    """
    from gateway.dbc import DBC
    from gateway.mapfile import MAPS, named_file
    from gateway.mapping import read_mapping, read_own_form
    from scenarios.outputs import also_reads

    if name is None:
        return read_own_form(dbc or DBC)
    if dbc is not None:
        raise BadInput("--dbc", "", "has no meaning with --map, which names its DBC file")
    mapping = read_mapping(named_file("--map", name, MAPS))
    also_reads([mapping.path, mapping.database.path])
    return mapping


class Frames(Adapter):
    """The gateway's own frames, or those of any form that a control has."""

    def check(self) -> None:
        """Read them."""
        self._mapping = frames_of(self.args.map, self.args.dbc)

    def mapping(self, fmu: Path) -> Mapping | None:
        """Return them."""
        return self._mapping
