"""The kinds of faults that the checks find, most serious first."""

from __future__ import annotations

from measurement.faults.checks import checks
from measurement.faults.fault import Kind

ABSENT = {"absent": Kind("nothing that needs it is given")}
"""Columns of the rig that a run lacks: reported by `measurement.iso230`, not by a check."""

_KINDS = {**ABSENT, **{name: kind for check in checks() for name, kind in check.kinds.items()}}
_BY_USE = {
    use: tuple(sorted(name for name, kind in _KINDS.items() if kind.use == use))
    for use in ("rises", "none", "all")
}

LEVELS = _BY_USE["rises"]
"""Kinds of a thermometer whose level is wrong while its rises may be right."""
GROSS = _BY_USE["none"]
"""Kinds whose span is unusable: the readings are not what the machine did."""
HANDLING = {name: _KINDS[name].handling for names in _BY_USE.values() for name in names}
"""How each kind is handled, in the order in which they are reported."""
