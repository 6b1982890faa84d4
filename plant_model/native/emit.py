"""Expressions written as C functions; common subexpressions are computed once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from plant_model.native.product import LANES
from plant_model.native.trace import CALLS, INFIX, PREFIX, Expr, literal

POWERS = {2.0: "square", 3.0: "cube", 4.0: "fourth"}


class Stage:
    """Numbers that are computed before others and kept in a row.

    Parameters
    ----------
    row : str
        Name of the row in C.
    needs : iterable of str
        Rows that are known when it is computed.
    """

    def __init__(self, row: str, needs: Iterable[str]) -> None:
        self.row, self.needs = row, frozenset(needs)
        self.kept: dict[Expr, int] = {}

    def takes(self, cell: Any) -> bool:
        """Return whether a cell can be computed in this stage."""
        return isinstance(cell, Expr) and cell.rows <= self.needs

    def place(self, cell: Expr) -> str:
        """Return the place in C where the stage keeps a number."""
        return f"{self.row}[{self.kept.setdefault(cell, len(self.kept))}]"


def function(
    head: str, results: Mapping[str, Any] | Sequence[tuple[str, Any]], stages: Sequence[Stage]
) -> str:
    """Return a C function.

    Parameters
    ----------
    head : str
        Its declaration; parameters have the rows' names.
    results : mapping of str to number or expression
        The results, by the place in C to store them.
    stages : sequence of Stage
        Stages computed before; the first that can compute an expression takes it.
    """
    pairs = list(results.items() if isinstance(results, Mapping) else results)
    writer = _Writer(stages, [cell for _, cell in pairs])
    puts = [f"    {place} = {writer.value(cell)};" for place, cell in pairs]
    body = "\n".join([*writer.lines, *puts])
    unused = ", ".join(f"(void){name}" for name in _parameters(head))
    return f"{head}\n{{\n    {unused};\n{body}\n}}\n"


def stage_function(head: str, stage: Stage, before: Sequence[Stage]) -> str:
    """Return the C function of a stage; call it after writing all functions that need the stage."""
    results = [(f"{stage.row}[{place}]", cell) for cell, place in stage.kept.items()]
    return function(head, results, before)


def _parameters(head: str) -> list[str]:
    inside = head[head.index("(") + 1 : head.rindex(")")]
    return [part.split("*")[-1].split()[-1] for part in inside.split(",")]


class _Writer:
    def __init__(self, stages: Sequence[Stage], cells: Iterable[Any]) -> None:
        self.stages = stages
        self.lines: list[str] = []
        self._names: dict[Expr, str] = {}
        self._uses = Counter[Expr]()
        waiting = list(cells)
        while waiting:
            now = waiting.pop()
            if isinstance(now, Expr):
                self._uses[now] += 1
                waiting += now.args if self._uses[now] == 1 else ()

    def value(self, cell: Any) -> str:
        """Return a cell's name in C, after writing what it needs."""
        if not isinstance(cell, Expr):
            return literal(float(cell))
        # No recursion: a sum over all nodes is nested as deep as it is long.
        waiting = [cell]
        while waiting:
            now = waiting[-1]
            if now in self._names:
                waiting.pop()
                continue
            known = self._known(now)
            missing = [] if known else [a for a in self._needs(now) if self._is_new(a)]
            if missing:
                waiting += missing
                continue
            waiting.pop()
            self._names[now] = known or self._written(now)
        return self._names[cell]

    def _is_new(self, arg: Any) -> bool:
        return isinstance(arg, Expr) and arg not in self._names

    def _known(self, cell: Expr) -> str:
        for stage in self.stages:
            if stage.takes(cell):
                return stage.place(cell)
        return f"{cell.args[0]}[{cell.args[1]}]" if cell.op == "symbol" else ""

    def _alone(self, arg: Any) -> bool:
        """Return whether an argument is an expression that is used only once."""
        return isinstance(arg, Expr) and self._uses[arg] == 1 and not self._known(arg)

    def _args(self, cell: Expr, inside: bool) -> Iterator[tuple[Any, bool]]:
        """Yield an operation's arguments (a sum's terms), and whether each is written in place.

        This is so for an argument that only one branch of a choice needs: it is computed only if
        that branch is chosen.
        """
        waiting = [*reversed(cell.args)]
        while waiting:
            arg = waiting.pop()
            alone = self._alone(arg)
            if alone and cell.op == arg.op == "add":
                waiting += reversed(arg.args)
            else:
                yield arg, alone and (inside or (cell.op == "where" and arg is not cell.args[0]))

    def _needs(self, cell: Expr, inside: bool = False) -> Iterator[Any]:
        """Yield what must have a name before an operation is written."""
        for arg, in_place in self._args(cell, inside):
            yield from self._needs(arg, True) if in_place else (arg,)

    def _formula(self, cell: Expr, inside: bool = False) -> str:
        return _operation(
            cell,
            [
                f"({self._formula(arg, True)})"
                if in_place
                else self._names[arg]
                if isinstance(arg, Expr)
                else literal(arg)
                for arg, in_place in self._args(cell, inside)
            ],
        )

    def _written(self, cell: Expr) -> str:
        name = f"v{len(self.lines)}"
        self.lines.append(f"    const double {name} = {self._formula(cell)};")
        return name


def _operation(cell: Expr, args: Sequence[str]) -> str:
    if len(args) > LANES:
        sums = [" + ".join(args[k : k + LANES]) for k in range(0, len(args), LANES)]
        return " + ".join(f"({part})" for part in sums)
    if cell.op == "add":
        return " + ".join(args)
    if cell.op in INFIX:
        return f"{args[0]} {INFIX[cell.op]} {args[1]}"
    if cell.op in PREFIX:
        return f"{PREFIX[cell.op]}{args[0]}"
    if cell.op == "where":
        return f"{args[0]} != 0.0 ? {args[1]} : {args[2]}"
    if cell.op == "power" and cell.args[1] in POWERS:
        return f"{POWERS[cell.args[1]]}({args[0]})"
    return f"{CALLS[cell.op]}({', '.join(args)})"
