"""The kinds of faults that the checks find, the gravest first."""

from __future__ import annotations

from measurement.faults.checks import checks
from measurement.faults.fault import Kind

ABSENT = {"absent": Kind("nothing that needs it is given")}
"""What a run lacks of its rig: no check of runs, `measurement.iso230` says it."""

_KINDS = {**ABSENT, **{name: kind for check in checks() for name, kind in check.kinds.items()}}
_BY_USE = {
    use: tuple(sorted(name for name, kind in _KINDS.items() if kind.use == use))
    for use in ("rises", "none", "all")
}

LEVELS = _BY_USE["rises"]
"""Kinds of a thermometer whose level is wrong while its rises may be right."""
GROSS = _BY_USE["none"]
"""Kinds whose time is not to be used: what was read then is not what the machine did."""
HANDLING = {name: _KINDS[name].handling for names in _BY_USE.values() for name in names}
"""What is done about each kind, in the order in which they are told."""
