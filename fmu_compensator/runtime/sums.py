"""Weighted sums of many inputs, as fast as Python alone makes them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isqrt

Sums = Callable[[Sequence[float]], list[float]]


def written_out(constants: Sequence[float], rows: Sequence[Sequence[float]]) -> Sums:
    """Return constants plus weighted sums as a function without loops, which takes two thirds.

    The terms are added in the order of the inputs, as the twin in C does. Numbers are written as
    `repr` does, which reads back as the same number.

    Parameters
    ----------
    constants : sequence of float
    rows : sequence of sequence of float
        The weights of all inputs, a row for each constant.
    """
    names = [f"x{place}" for place in range(len(rows[0]) if rows else 0)]
    lines = ["def sums(inputs):", *([f"    [{', '.join(names)}] = inputs"] if rows else [])]
    # A statement of thousands of terms is too deep for Python: as many statements as terms in each.
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
