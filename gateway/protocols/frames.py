"""Plain frames: those of a DBC file, or of a control by its map (``--dbc``, ``--map``)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gateway.protocols.base import Adapter
from measurement.errors import BadInput

if TYPE_CHECKING:
    from gateway.mapping import Mapping


def mapping_named(name: str | None, dbc: Path | None) -> Mapping | None:
    """Return the map of a command line; None without one.

    Parameters
    ----------
    name : str or None
        A file, or the name of one that ships.
    dbc : Path or None
        A DBC file that was given, too.

    Raises
    ------
    BadInput
        If it cannot be read.
    """
    if name is None:
        return None
    if dbc is not None:
        raise BadInput("--dbc", "", "has no meaning with --map, which names its DBC file")
    from gateway.mapfile import map_path
    from gateway.mapping import read_mapping
    from scenarios.outputs import also_reads

    mapping = read_mapping(map_path(name))
    also_reads([mapping.path, mapping.database.path])
    return mapping


class Frames(Adapter):
    """Frames of any form, as a control has them."""

    def check(self) -> None:
        """Read the map."""
        self._mapping = mapping_named(self.args.map, self.args.dbc)

    def mapping(self, fmu: Path) -> Mapping | None:
        """Return the map."""
        return self._mapping
