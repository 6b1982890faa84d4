"""Weighted sums of many inputs, as fast as pure Python allows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from math import isqrt
from operator import add

Sums = Callable[[Sequence[float]], list[float]]


def written_out(constants: Sequence[float], rows: Sequence[Sequence[float]]) -> Sums:
    """Return a function without loops for constants plus weighted sums; takes two thirds as long.

    Terms are added in the order of the inputs, as in the C twin. Numbers are written with `repr`,
    which reads back as the same number.

    Parameters
    ----------
    constants : sequence of float
    rows : sequence of sequence of float
        Weights of all inputs, one row per constant.
    """
    names = [f"x{place}" for place in range(len(rows[0]) if rows else 0)]
    lines = ["def sums(inputs):", *([f"    [{', '.join(names)}] = inputs"] if rows else [])]
    # Python cannot parse a statement of thousands of terms: split each sum into sqrt(n) parts.
    part = isqrt(len(names)) + 1
    for target, (constant, weights) in enumerate(zip(constants, rows, strict=True)):
        sums = [f"{float(constant)!r}"]
        for at, (weight, name) in enumerate(zip(weights, names, strict=True), start=1):
            sums[-1] += f" + {float(weight)!r} * {name}"
            sums += [f"y{target}"] if at % part == 0 else []
        lines += [f"    y{target} = {words}" for words in sums]
    lines.append(f"    return [{', '.join(f'y{target}' for target in range(len(rows)))}]")
    made: dict[str, Sums] = {}
    exec("\n".join(lines), made)
    return made["sums"]


def summed(terms: Iterable[float]) -> float:
    """Return a sum, rounded after each term as in the C twin: `sum` is not, from Python 3.12 on."""
    return reduce(add, terms, 0.0)
