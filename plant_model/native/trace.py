"""Arrays of expressions: numpy code that runs on them yields its formulas.

The hooks of effects are numpy code without branches on values. Run on :class:`Traced` arrays
instead of numbers, they compute expressions, which can be written in any language. Code that
branches on a value (an ``if`` on a temperature) cannot be traced and is refused.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

TESTS = {"greater", "greater_equal", "less", "less_equal", "equal", "not_equal"}
LOGIC = {"bitwise_and": "logical_and", "bitwise_or": "logical_or", "invert": "logical_not"}
INFIX = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}
INFIX |= {"greater": ">", "greater_equal": ">=", "less": "<", "less_equal": "<="}
INFIX |= {"equal": "==", "not_equal": "!=", "logical_and": "&&", "logical_or": "||"}
PREFIX = {"negative": "-", "logical_not": "!"}
CALLS = {"absolute": "fabs", "sqrt": "sqrt", "exp": "exp", "expm1": "expm1", "log": "log"}
CALLS |= {"sin": "sin", "cos": "cos", "tan": "tan", "arctan": "atan", "tanh": "tanh"}
CALLS |= {"floor": "floor", "power": "pow", "sign": "sign_of", "remainder": "modulo"}
CALLS |= {"maximum": "larger", "minimum": "smaller", "radians": "radians"}
"""C functions by numpy's names; only these can be traced."""


class UntraceableError(TypeError):
    """Code without a formula; the message is one line that states what the code does."""


class Expr:
    """One number of a formula: an operation on numbers and other expressions, or a symbol.

    Attributes
    ----------
    op : str
        Name of the operation; ``symbol`` for a given number.
    args : tuple
        Its arguments; for a symbol, its row and its place there.
    rows : frozenset of str
        The rows of symbols that it depends on.
    """

    __slots__ = ("args", "graph", "op", "rows")

    def __init__(self, graph: Graph, op: str, args: tuple[Any, ...], rows: frozenset[str]) -> None:
        self.graph, self.op, self.args, self.rows = graph, op, args, rows

    def __bool__(self) -> bool:
        """Refuse to be a condition."""
        raise UntraceableError("its course depends on a value")

    def __float__(self) -> float:
        """Refuse to be a number."""
        raise UntraceableError("it takes a value out of an array")

    # numpy multiplies matrices of objects with these two.
    def __add__(self, other: Any) -> Any:
        """Return the sum."""
        return self.graph.apply("add", self, other)

    def __mul__(self, other: Any) -> Any:
        """Return the product."""
        return self.graph.apply("multiply", self, other)

    __radd__, __rmul__ = __add__, __mul__


class Graph:
    """Expressions, each of which exists once."""

    def __init__(self) -> None:
        self._known: dict[tuple[Any, ...], Expr] = {}

    def symbol(self, row: str, place: int) -> Expr:
        """Return a given number: number *place* of a *row*."""
        return self._kept("symbol", (row, place), frozenset({row}))

    def symbols(self, row: str, shape: Sequence[int]) -> Traced:
        """Return an array of symbols, the first at place 0."""
        cells = np.empty(shape, dtype=object)
        for place in range(cells.size):
            cells.flat[place] = self.symbol(row, place)
        return Traced(self, cells)

    def constant(self, value: Any) -> Traced:
        """Return an array of numbers that can hold expressions."""
        return Traced(self, np.asarray(value).astype(object))

    def _kept(self, op: str, args: tuple[Any, ...], rows: frozenset[str]) -> Expr:
        # Repr tells 0.0 from -0.0 and 1 from True, which compare equal.
        key = (op, *(id(arg) if isinstance(arg, Expr) else repr(arg) for arg in args))
        if key not in self._known:
            self._known[key] = Expr(self, op, args, rows)
        return self._known[key]

    def apply(self, op: str, *args: Any) -> Any:
        """Return an operation's result, simplified if that changes no finite number."""
        if not any(isinstance(arg, Expr) for arg in args):
            return _number(op, args)
        simple = _simplified(self, op, args)
        if simple is not None:
            return simple
        plain = tuple(arg if isinstance(arg, Expr) else float(arg) for arg in args)
        rows = frozenset[str]().union(*(arg.rows for arg in args if isinstance(arg, Expr)))
        return self._kept(op, plain, rows)


def _number(op: str, args: tuple[Any, ...]) -> Any:
    if op == "where":
        return args[1] if args[0] else args[2]
    with np.errstate(all="ignore"):
        value = getattr(np, op)(*args)
    return bool(value) if op in TESTS or op.startswith("logical") else float(value)


def _simplified(graph: Graph, op: str, args: tuple[Any, ...]) -> Any:
    """Return the result if it needs no operation, else None."""
    if op == "where":
        return None if isinstance(args[0], Expr) else args[1] if args[0] else args[2]
    if op in {"logical_and", "logical_or"}:
        return _simplified_logic(op, args)
    first, last = args[0], args[-1]
    numbers = tuple(None if isinstance(arg, Expr) else float(arg) for arg in args)
    match op, *numbers:
        case ("add", 0.0, None) | ("multiply", 1.0, None):
            return last
        case (
            ("add", None, 0.0)
            | ("subtract", None, 0.0)
            | ("multiply", None, 1.0)
            | ("divide", None, 1.0)
            | ("power", None, 1.0)
        ):
            return first
        case ("multiply", 0.0, None) | ("multiply", None, 0.0) | ("divide", 0.0, None):
            return 0.0
        case ("subtract", 0.0, None):
            return graph.apply("negative", last)
        case ("power", None, 0.0):
            return 1.0
    return None


def _simplified_logic(op: str, args: tuple[Any, ...]) -> Any:
    for known, other in (args, args[::-1]):
        if not isinstance(known, Expr):
            return other if bool(known) == (op == "logical_and") else bool(known)
    return None


class Traced(NDArrayOperatorsMixin):
    """An array of numbers and expressions.

    Attributes
    ----------
    cells : array of object
        Its elements.
    """

    def __init__(self, graph: Graph, cells: np.ndarray[Any, Any]) -> None:
        self.graph, self.cells = graph, cells

    @property
    def shape(self) -> tuple[int, ...]:
        """Length along each axis."""
        return tuple(self.cells.shape)

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.cells.ndim

    @property
    def size(self) -> int:
        """Number of elements."""
        return self.cells.size

    @property
    def T(self) -> Traced:  # noqa: N802 - numpy's name
        """The transpose."""
        return Traced(self.graph, self.cells.T)

    def __len__(self) -> int:
        """Return the length along the first axis."""
        return len(self.cells)

    def __iter__(self) -> Iterator[Traced]:
        """Iterate along the first axis."""
        return (self[place] for place in range(len(self.cells)))

    def _alone(self) -> Any:
        if self.size != 1:
            raise UntraceableError("it takes an array for one value")
        return self.cells.flat[0]

    def __bool__(self) -> bool:
        """Return a known condition."""
        return bool(self._alone())

    def __float__(self) -> float:
        """Return a known number."""
        return float(self._alone())

    def __getitem__(self, key: Any) -> Traced:
        """Return a part; as with numpy, a view if the key consists of slices."""
        cell = self.cells[key]
        if not isinstance(cell, np.ndarray):
            cell = _cell(cell)
        return Traced(self.graph, cell)

    def __setitem__(self, key: Any, value: Any) -> None:
        """Store numbers or expressions."""
        self.cells[key] = _cells(value)

    def copy(self) -> Traced:
        """Return a copy."""
        return Traced(self.graph, self.cells.copy())

    def sum(self, axis: int | None = None) -> Traced:
        """Return the sum along an axis."""
        return self._made(np.sum(self.cells, axis=axis))

    def reshape(self, *shape: Any) -> Traced:
        """Return the same elements in another shape."""
        return Traced(self.graph, self.cells.reshape(*shape))

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Apply a ufunc element by element."""
        name = LOGIC.get(ufunc.__name__, ufunc.__name__)
        out = options.pop("out", None)
        if method != "__call__" or options:
            raise UntraceableError(f"it calls {ufunc.__name__} in a form that has no formula")
        cells = [_cells(entry) for entry in inputs]
        if ufunc is np.matmul:
            result = self._made(np.matmul(*cells))
        elif ufunc is np.square:
            result = self._each("multiply", cells[0], cells[0])
        elif name in INFIX | PREFIX | CALLS:
            result = self._each(name, *cells)
        else:
            raise UntraceableError(f"it calls {ufunc.__name__}, which has no form in C here")
        if out is None:
            return result
        out[0][...] = result
        return out[0]

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        """Apply a numpy function, if it is one of those that effects use."""
        name = function.__name__
        if name in _SHAPING:
            bare, settings = _bare(args), {key: _bare(value) for key, value in kwargs.items()}
            return self._wrapped(function(*bare, **settings))
        if name == "where" and len(args) == 3:
            return self._each("where", *(_cells(entry) for entry in args))
        if name == "clip" and not kwargs:
            return np.minimum(np.maximum(args[0], args[1]), args[2])
        raise UntraceableError(f"it calls numpy.{name}, which has no formula here")

    def _wrapped(self, result: Any) -> Any:
        if isinstance(result, np.ndarray):
            # A view of broadcast cells must not be written through.
            return Traced(self.graph, result.astype(object))
        if isinstance(result, list | tuple) and any(isinstance(e, np.ndarray) for e in result):
            return [self._wrapped(entry) for entry in result]
        return result

    def _each(self, op: str, *cells: np.ndarray[Any, Any]) -> Traced:
        return self._made(np.frompyfunc(lambda *a: self.graph.apply(op, *a), len(cells), 1)(*cells))

    def _made(self, result: Any) -> Traced:
        return Traced(self.graph, result if isinstance(result, np.ndarray) else _cell(result))


_SHAPING = {"stack", "concatenate", "broadcast_to", "broadcast_arrays", "zeros_like", "ones_like"}
_SHAPING |= {"full_like", "empty_like", "shape", "ndim", "size", "swapaxes", "moveaxis", "sum"}
_SHAPING |= {"atleast_1d", "atleast_2d", "expand_dims", "squeeze", "ravel", "reshape", "tile"}
_SHAPING |= {"repeat", "copy", "transpose", "result_type"}


def _cell(value: Any) -> np.ndarray[Any, Any]:
    alone = np.empty((), dtype=object)
    alone[()] = value
    return alone


def _cells(value: Any) -> np.ndarray[Any, Any]:
    if isinstance(value, Traced):
        return value.cells
    if isinstance(value, Expr):
        return _cell(value)
    if isinstance(value, list | tuple) and any(isinstance(entry, Traced) for entry in value):
        return np.stack([_cells(entry) for entry in value])
    return np.asarray(value).astype(object)


def _bare(value: Any) -> Any:
    if isinstance(value, Traced):
        return value.cells
    if isinstance(value, list | tuple):
        return type(value)(_bare(entry) for entry in value)
    return value


class _Numpy:
    """numpy, except that newly created arrays can hold expressions."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)

    def zeros(self, shape: Any, *_: Any, **__: Any) -> Traced:
        return self._graph.constant(np.zeros(shape))

    def ones(self, shape: Any, *_: Any, **__: Any) -> Traced:
        return self._graph.constant(np.ones(shape))

    empty = zeros

    def full(self, shape: Any, value: Any, *_: Any, **__: Any) -> Traced:
        made = self.zeros(shape)
        made[...] = value
        return made

    def array(self, value: Any, *_: Any, **__: Any) -> Traced:
        return Traced(self._graph, _cells(value).copy())

    def asarray(self, value: Any, *_: Any, **__: Any) -> Any:
        return value if isinstance(value, Traced) else self._graph.constant(value)


@contextmanager
def tracing(
    graph: Graph, package: str, keep: Callable[[str], bool], more: Collection[str] = ()
) -> Iterator[None]:
    """Let the modules of a package create arrays that can hold expressions, temporarily.

    Parameters
    ----------
    graph : Graph
    package : str
        All its modules that are imported and have numpy as ``np``.
    keep : callable
        Takes a module's name; returns whether the module stays unchanged.
    more : collection of str
        Further modules: those of plug-ins.
    """
    stand_in = _Numpy(graph)
    modules = [
        module
        for name, module in list(sys.modules.items())
        if (name in more or (name.startswith(f"{package}.") and not keep(name)))
        and getattr(module, "np", None) is np
    ]
    for module in modules:
        module.np = stand_in  # type: ignore[attr-defined]
    try:
        yield
    finally:
        for module in modules:
            module.np = np  # type: ignore[attr-defined]


def literal(value: float) -> str:
    """Return a number in C, with all digits."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "(-INFINITY)"
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text
