"""Units as FMI 2.0 defines them: a factor, an offset and powers of the SI base units.

A unit is written as in a machine file: ``W/K``, ``W/(m2 K)``, ``1e-6/K``, ``W/(1000 r/min)``.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class BaseUnit:
    """SI value = factor * value + offset, in the base units to the given powers."""

    factor: float = 1.0
    offset: float = 0.0
    powers: dict[str, int] = field(default_factory=dict)


_WATT = {"kg": 1, "m": 2, "s": -3}
_JOULE = {"kg": 1, "m": 2, "s": -2}
SYMBOLS: dict[str, BaseUnit] = {
    "1": BaseUnit(),
    "degC": BaseUnit(1.0, 273.15, {"K": 1}),
    "rpm": BaseUnit(math.pi / 30, 0.0, {"rad": 1, "s": -1}),
    "r": BaseUnit(2 * math.pi, 0.0, {"rad": 1}),
    "rev": BaseUnit(2 * math.pi, 0.0, {"rad": 1}),
    "lpm": BaseUnit(1e-3 / 60, 0.0, {"m": 3, "s": -1}),
    "%": BaseUnit(0.01),
    "min": BaseUnit(60.0, 0.0, {"s": 1}),
    "h": BaseUnit(3600.0, 0.0, {"s": 1}),
    "cSt": BaseUnit(1e-6, 0.0, {"m": 2, "s": -1}),
    "bar": BaseUnit(1e5, 0.0, {"kg": 1, "m": -1, "s": -2}),
    "deg": BaseUnit(math.pi / 180, 0.0, {"rad": 1}),
    "arcsec": BaseUnit(math.pi / 648000, 0.0, {"rad": 1}),
}
"""Units that take no prefix."""

PREFIXED: dict[str, BaseUnit] = {
    "m": BaseUnit(powers={"m": 1}),
    "g": BaseUnit(1e-3, 0.0, {"kg": 1}),
    "s": BaseUnit(powers={"s": 1}),
    "K": BaseUnit(powers={"K": 1}),
    "A": BaseUnit(powers={"A": 1}),
    "rad": BaseUnit(powers={"rad": 1}),
    "N": BaseUnit(powers={"kg": 1, "m": 1, "s": -2}),
    "J": BaseUnit(powers=_JOULE),
    "W": BaseUnit(powers=_WATT),
    "Pa": BaseUnit(powers={"kg": 1, "m": -1, "s": -2}),
    "Hz": BaseUnit(powers={"s": -1}),
    "V": BaseUnit(powers={**_WATT, "A": -1}),
    "l": BaseUnit(1e-3, 0.0, {"m": 3}),
}
PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}

ALIASES = {"Nm": "N m", "mm_min": "mm/min", "Nmm": "N mm"}
IN_MODELICA = {
    "1e-6/K": "um/(m.K)",
    "W/(1000 r/min)": "mW.min/rev",
    "W/(m/min)": "W.min/m",
}
"""Exceptions to the rules: Modelica's units have no numbers and at most one slash."""

DISPLAY: dict[str, dict[str, tuple[float, float]]] = {
    "degC": {"K": (1.0, 273.15), "degF": (1.8, 32.0)},
    "um": {"mm": (1e-3, 0.0)},
    "urad": {"arcsec": (1e-6 * 648000 / math.pi, 0.0), "mrad": (1e-3, 0.0)},
    "J/K": {"kJ/K": (1e-3, 0.0)},
    "s": {"min": (1 / 60, 0.0), "h": (1 / 3600, 0.0)},
}
"""Alternative display units: displayed value = factor * value + offset."""


QUANTITIES = {
    "1": "",
    "degC": "ThermodynamicTemperature",
    "K": "TemperatureDifference",
    "m": "Length",
    "m2": "Area",
    "s": "Time",
    "rad": "Angle",
    "rpm": "AngularVelocity",
    "m/s": "Velocity",
    "N": "Force",
    "Nm": "Torque",
    "W": "Power",
    "W/K": "ThermalConductance",
    "J/K": "HeatCapacity",
    "W/(m2 K)": "CoefficientOfHeatTransfer",
    "W/(m K)": "ThermalConductivity",
    "1/K": "LinearExpansionCoefficient",
    "lpm": "VolumeFlowRate",
    "mm2/s": "KinematicViscosity",
    "Pa": "Pressure",
}
"""The quantities of units with these dimensions, as named in the Modelica Standard Library."""


class UnitError(ValueError):
    """An unknown unit."""


TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d+)?(?:e[+-]?\d+)?)|(?P<symbol>[A-Za-z%]+)(?P<power>-?\d)?"
    r"|(?P<mark>[()/*.]))"
)


def base_unit(unit: str) -> BaseUnit:
    """Return *unit* in SI base units.

    Parameters
    ----------
    unit : str
        Numbers and symbols with optional powers; a space, ``*`` or ``.`` multiplies, ``/`` divides
        by only the next symbol or bracket.

    Raises
    ------
    UnitError
        For an unknown unit.
    """
    text = ALIASES.get(unit.strip(), unit.strip())
    if text in SYMBOLS:
        return SYMBOLS[text]
    tokens = _tokens(text)
    if not tokens:
        raise UnitError("a unit that is empty")
    product = _product(tokens)
    if tokens:
        raise UnitError(f"{unit}: a bracket too many")
    powers = {base: power for base, power in product.powers.items() if power}
    return BaseUnit(product.factor, 0.0, powers)


def fmi_name(unit: str) -> str:
    """Return a unit as written in Modelica, and so in other FMI tools: ``N.m``, ``W/(m2.K)``.

    Parameters
    ----------
    unit : str
        As for `base_unit`.
    """
    text = ALIASES.get(unit, unit)
    return IN_MODELICA.get(text) or re.sub(r"\s*\*\s*|\s+", ".", text)


def own_name(unit: str) -> str:
    """Return a unit from another tool as written in this project, ``Nm`` for ``N.m``.

    Parameters
    ----------
    unit : str
    """
    return {fmi_name(own): own for own in ALIASES}.get(unit, unit)


def quantity(unit: str) -> str:
    """Return the quantity that a unit measures; empty if it has no known name.

    Parameters
    ----------
    unit : str
        As for `base_unit`.
    """
    wanted = base_unit(unit)
    for name, measured in QUANTITIES.items():
        base = base_unit(name)
        if base.powers == wanted.powers and bool(base.offset) == bool(wanted.offset):
            return measured
    return ""


def _tokens(text: str) -> list[str | BaseUnit]:
    """Return operators and the meanings of symbols and numbers, in order."""
    tokens: list[str | BaseUnit] = []
    position = 0
    while position < len(text):
        match = TOKEN.match(text, position)
        if match is None:
            raise UnitError(f"{text}: {text[position:]!r} in it is not understood")
        position = match.end()
        if match["mark"]:
            tokens.append(match["mark"])
        elif match["number"]:
            tokens.append(BaseUnit(float(match["number"])))
        else:
            tokens.append(_raised(_symbol(match["symbol"], text), int(match["power"] or 1)))
    return tokens


def _product(tokens: list[str | BaseUnit]) -> BaseUnit:
    """Consume a product up to its end or closing bracket."""
    product, sign = BaseUnit(), 1
    while tokens and tokens[0] != ")":
        token = tokens.pop(0)
        if token in ("*", "."):
            continue
        if token == "/":
            sign = -1
            continue
        if token == "(":
            token = _product(tokens)
            if not tokens:
                raise UnitError("a unit with an open bracket")
            tokens.pop(0)
        assert isinstance(token, BaseUnit)
        raised = _raised(token, sign)
        powers = {
            base: product.powers.get(base, 0) + raised.powers.get(base, 0)
            for base in {**product.powers, **raised.powers}
        }
        product, sign = BaseUnit(product.factor * raised.factor, 0.0, powers), 1
    return product


def _raised(unit: BaseUnit, power: int) -> BaseUnit:
    powers = {base: power * exponent for base, exponent in unit.powers.items()}
    return BaseUnit(unit.factor**power, 0.0, powers)


def _symbol(name: str, unit: str) -> BaseUnit:
    """Return a symbol's meaning, without an offset."""
    if name in SYMBOLS:
        return SYMBOLS[name]
    for length in (0, 1):
        prefix, rest = name[:length], name[length:]
        if prefix in PREFIXES and rest in PREFIXED:
            prefixed = PREFIXED[rest]
            return BaseUnit(PREFIXES[prefix] * prefixed.factor, 0.0, prefixed.powers)
    raise UnitError(f"{unit}: the unit {name!r} in it is unknown")
