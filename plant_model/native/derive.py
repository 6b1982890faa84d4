"""Derivatives of expressions, forward and backward: the chain rule over traced expressions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from plant_model.native.trace import Expr

Do = Callable[..., Any]
SEED = "d"
"""Row of the factors of derivatives: directions or weights."""

Knowns = Mapping[tuple[str, int], int]
"""Places among the seeds or results, by row and place of a symbol."""


def forward(cells: Sequence[Any], knowns: Knowns) -> list[Any]:
    """Return the derivatives of cells in a direction, whose components are the symbols of `SEED`.

    Parameters
    ----------
    cells : sequence of number or expression
    knowns : mapping of (str, int) to int
        Symbols that vary, with the place of each in the direction.
    """
    slopes: dict[Expr, Any] = {}
    for cell in _ordered(cells, knowns):
        if cell.op == "symbol":
            moves = cell.args in knowns
            slopes[cell] = cell.graph.symbol(SEED, knowns[cell.args]) if moves else 0.0
            continue
        total: Any = 0.0
        for place, arg in enumerate(cell.args):
            if arg in slopes:
                total = cell.graph.apply("add", total, _through(cell, place, slopes[arg]))
        slopes[cell] = total
    return [slopes.get(cell, 0.0) if isinstance(cell, Expr) else 0.0 for cell in cells]


def backward(cells: Sequence[Any], knowns: Knowns) -> list[Any]:
    """Return the derivatives of a sum of cells, each weighted by its symbol of `SEED`.

    Parameters
    ----------
    cells : sequence of number or expression
    knowns : mapping of (str, int) to int
        Symbols to differentiate by, with the place of each derivative among the results.
    """
    ordered = _ordered(cells, knowns)
    slopes: dict[Expr, Any] = dict.fromkeys(ordered, 0.0)
    for place, cell in enumerate(cells):
        if cell in slopes:
            slopes[cell] = cell.graph.apply("add", slopes[cell], cell.graph.symbol(SEED, place))
    for cell in reversed(ordered):
        for place, arg in enumerate(() if cell.op == "symbol" else cell.args):
            if arg in slopes:
                more = _through(cell, place, slopes[cell])
                slopes[arg] = cell.graph.apply("add", slopes[arg], more)
    by_symbol = {cell.args: slope for cell, slope in slopes.items() if cell.op == "symbol"}
    results: list[Any] = [0.0] * (1 + max(knowns.values()))
    for symbol, place in knowns.items():
        results[place] = by_symbol.get(symbol, 0.0)
    return results


def _ordered(cells: Iterable[Any], knowns: Knowns) -> list[Expr]:
    """Return the expressions that depend on knowns, each after its arguments."""
    rows = {row for row, _ in knowns}

    def moves(cell: Any) -> bool:
        return isinstance(cell, Expr) and not rows.isdisjoint(cell.rows)

    ordered: dict[Expr, None] = {}
    waiting = [cell for cell in cells if moves(cell)]
    while waiting:
        now = waiting[-1]
        missing = [arg for arg in now.args if moves(arg) and arg not in ordered]
        if missing and now not in ordered:
            waiting += missing
        else:
            ordered[waiting.pop()] = None
    return list(ordered)


def _through(cell: Expr, place: int, slope: Any) -> Any:
    """Return a slope times the derivative of an expression by one of its arguments.

    If a derivative jumps, that of one side is taken. The infinite derivative of a root at zero is
    taken as zero: a constant argument would give infinity times zero. Floors, signs and conditions
    count as constant.
    """
    do, args = cell.graph.apply, cell.args
    if cell.op in CHOICES:
        condition, first = CHOICES[cell.op]
        chosen = do(condition, *args) if condition else args[0]
        if place < first:
            return 0.0
        return do("where", chosen, *((slope, 0.0) if place == first else (0.0, slope)))
    if cell.op not in FACTORS:
        return 0.0
    return do("multiply", FACTORS[cell.op](cell, do)[place], slope)


def _of_power(cell: Expr, do: Do) -> tuple[Any, Any]:
    """Return the derivatives of a power by its base and by its exponent."""
    base, exponent = cell.args
    by_base = do("multiply", exponent, do("power", base, do("subtract", exponent, 1.0)))
    if isinstance(exponent, Expr) or exponent < 1.0:
        by_base = do("where", do("not_equal", base, 0.0), by_base, 0.0)
    if not isinstance(exponent, Expr):
        return by_base, 0.0
    logarithm = do("multiply", cell, do("log", base))
    return by_base, do("where", do("greater", base, 0.0), logarithm, 0.0)


def _of_root(cell: Expr, do: Do) -> tuple[Any]:
    return (do("where", do("not_equal", cell, 0.0), do("divide", 0.5, cell), 0.0),)


def _of_quotient(cell: Expr, do: Do) -> tuple[Any, Any]:
    by = do("divide", 1.0, cell.args[1])
    return by, do("negative", do("multiply", cell, by))


def _of_remainder(cell: Expr, do: Do) -> tuple[Any, Any]:
    return 1.0, do("negative", do("floor", do("divide", *cell.args)))


CHOICES = {"where": ("", 1), "maximum": ("greater", 0), "minimum": ("less", 0)}
"""Condition of a choice (empty: its first argument), and the argument chosen if it holds."""

FACTORS: dict[str, Callable[[Expr, Do], Sequence[Any]]] = {
    "add": lambda cell, do: (1.0, 1.0),
    "subtract": lambda cell, do: (1.0, -1.0),
    "multiply": lambda cell, do: cell.args[::-1],
    "divide": _of_quotient,
    "power": _of_power,
    "remainder": _of_remainder,
    "negative": lambda cell, do: (-1.0,),
    "radians": lambda cell, do: (math.pi / 180.0,),
    "absolute": lambda cell, do: (do("sign", cell.args[0]),),
    "sqrt": _of_root,
    "exp": lambda cell, do: (cell,),
    "expm1": lambda cell, do: (do("add", cell, 1.0),),
    "log": lambda cell, do: (do("divide", 1.0, cell.args[0]),),
    "sin": lambda cell, do: (do("cos", cell.args[0]),),
    "cos": lambda cell, do: (do("negative", do("sin", cell.args[0])),),
    "tan": lambda cell, do: (do("add", 1.0, do("multiply", cell, cell)),),
    "arctan": lambda cell, do: (
        do("divide", 1.0, do("add", 1.0, do("multiply", cell.args[0], cell.args[0]))),
    ),
    "tanh": lambda cell, do: (do("subtract", 1.0, do("multiply", cell, cell)),),
}
"""Derivatives of an operation by each of its arguments."""
