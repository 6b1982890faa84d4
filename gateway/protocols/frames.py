"""Plain frames, from a DBC file of the own form or a control's map (``--dbc``, ``--map``)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gateway.protocols.base import Adapter
from measurement.errors import BadInput

if TYPE_CHECKING:
    from gateway.mapping import Mapping


def frames_of(name: str | None, dbc: Path | None) -> Mapping:
    """Return the frames for a command line: a map's, or those of a DBC file of the own form.

    Parameters
    ----------
    name : str or None
        A map's file, or the name of one that ships.
    dbc : Path or None
        The DBC file given; if there is no map either, the one that ships is used.

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
    """The gateway's own frames, or a control's frames of any form."""

    def check(self) -> None:
        """Read the frames."""
        self._mapping = frames_of(self.args.map, self.args.dbc)

    def mapping(self, fmu: Path) -> Mapping | None:
        """Return the frames."""
        return self._mapping
