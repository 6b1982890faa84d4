"""Copies of the modules that a slave needs, under a root package unique to the FMU.

Two FMUs in one process share `sys.modules`, also with the program that loads them. So every bundled
module is under a root package whose name contains a hash of the content, and absolute imports of
bundled packages are rewritten to that root. Imports are located with `ast`; nothing else in a
module changes.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import re
import sys
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

VENDORED = "pythonfmu"
"""Also bundled under the root, without its own ``__init__``, which would import its builder."""


class BundleError(ValueError):
    """A module that cannot be bundled; the text names file, line and import."""


@dataclass(frozen=True)
class _Import:
    """One absolute import: the position of the module's name, and the modules that it may mean."""

    line: int
    column: int
    module: str
    candidates: tuple[str, ...]
    binds_top: bool = False


@dataclass(frozen=True)
class Bundle:
    """Modules by their original dotted names, with their unchanged sources.

    Attributes
    ----------
    sources : dict of str to str
        Source by dotted name, including packages.
    packages : frozenset of str
        Names that are packages.
    third_party : frozenset of str
        Top-level names of other packages that they import.
    """

    sources: dict[str, str]
    packages: frozenset[str]
    third_party: frozenset[str] = frozenset()
    roots: frozenset[str] = field(default=frozenset())

    def digest(self) -> str:
        """Return a hash of all names and sources."""
        state = hashlib.sha256()
        for name in sorted(self.sources):
            state.update(f"{name}\0{self.sources[name]}\0".encode())
        return state.hexdigest()

    def files(self, root: str) -> dict[str, str]:
        """Return the files of the bundle under the root package *root*, by path."""
        sources = {f"{root}/__init__.py": ""}
        for name, source in self.sources.items():
            path = name.replace(".", "/") + ("/__init__.py" if name in self.packages else ".py")
            sources[f"{root}/{path}"] = rewritten(source, root, self.roots, name)
        return sources


def collect(
    entry: str,
    roots: Iterable[str],
    whole: Iterable[str] = (),
    allowed: Iterable[str] = (),
    *,
    added: Mapping[str, str] | None = None,
    left_out: Collection[str] = (),
) -> Bundle:
    """Return the modules that *entry* needs, found by following its imports.

    Parameters
    ----------
    entry : str
        Dotted name of the slave's module.
    roots : iterable of str
        Top-level packages to bundle. Imports from other packages are refused, except the standard
        library and *allowed*.
    whole : iterable of str
        Packages of which every module is needed, because they are found by walking a folder.
    allowed : iterable of str
        Top-level packages that the host's Python must have.
    added : dict of str to str, optional
        Sources from elsewhere, by their dotted name in the bundle.
    left_out : collection of str
        Modules that are imported but not bundled; the importer can do without them.

    Raises
    ------
    BundleError
        For an import that the bundle could not satisfy.
    """
    more = added or {}
    ours = frozenset(roots) | {VENDORED}
    sources: dict[str, str] = {}
    packages: set[str] = set()
    outside: set[str] = set()
    waiting = [entry, *whole, *(name for package in whole for name in _modules_in(package)), *more]
    while waiting:
        name = waiting.pop()
        if name in sources:
            continue
        path = Path(name) if name in more else _path_of(name)
        if path.name == "__init__.py" and name not in more:
            packages.add(name)
        empty = name == VENDORED
        text = more[name] if name in more else path.read_text(encoding="utf-8")
        sources[name] = "" if empty else text
        if "." in name:
            waiting.append(name.rpartition(".")[0])
        for needed in _imports(sources[name], name, name in packages):
            top = needed.module.partition(".")[0]
            if top in ours:
                wanted = [module for module in needed.candidates if module not in left_out]
                waiting += [module for module in wanted if _exists(module)]
            elif top in set(allowed):
                outside.add(top)
            elif top not in sys.stdlib_module_names:
                raise BundleError(
                    f"{path}:{needed.line}: imports {needed.module}, which an FMU does not carry"
                )
    return Bundle(sources, frozenset(packages), frozenset(outside), ours)


def needed_by(source: str, name: str) -> str:
    """Return the lines of a module that a class needs; all other lines are blank.

    So a file may contain code that an FMU cannot, and lines keep their numbers.

    Parameters
    ----------
    source : str
        Source of the module.
    name : str
        Name of the top-level class.
    """
    tree = ast.parse(source)
    binding: dict[str, list[ast.stmt]] = {}
    for statement in tree.body:
        for bound in _bound(statement):
            binding.setdefault(bound, []).append(statement)
    waiting, kept = [name], set(tree.body[:1]) if ast.get_docstring(tree) else set()
    kept |= {part for part in tree.body if getattr(part, "module", "") == "__future__"}
    while waiting:
        for statement in binding.get(waiting.pop(), []):
            if statement not in kept:
                kept.add(statement)
                waiting += [part.id for part in ast.walk(statement) if isinstance(part, ast.Name)]
    lines = source.splitlines()
    wanted: set[int] = set()
    for statement in kept:
        marks = getattr(statement, "decorator_list", [])
        first = min(statement.lineno, *(mark.lineno for mark in marks), statement.lineno)
        wanted |= set(range(first, (statement.end_lineno or first) + 1))
    shown = (line if number in wanted else "" for number, line in enumerate(lines, 1))
    return "\n".join(shown) + "\n"


def _bound(statement: ast.stmt) -> set[str]:
    """Return the names bound by a top-level statement."""
    if isinstance(statement, ast.ClassDef | ast.FunctionDef):
        return {statement.name}
    names: set[str] = set()
    for node in ast.walk(statement):
        if isinstance(node, ast.alias):
            names.add((node.asname or node.name).partition(".")[0])
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
    return names


def problem_alone(file: str, source: str, roots: Iterable[str], allowed: Iterable[str]) -> str:
    """Return why a source from elsewhere cannot be bundled on its own; empty if it can.

    Parameters
    ----------
    file : str
        Its name in messages.
    source : str
    roots, allowed : iterable of str
        As for `collect`.
    """
    carried = {*roots, *allowed, *sys.stdlib_module_names}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level:
            return f"{file} line {node.lineno} imports from its own package"
    for needed in _imports(source, "<alone>", is_package=False):
        if needed.module.partition(".")[0] not in carried:
            return f"{file} line {needed.line} imports {needed.module}"
    return ""


def rewritten(source: str, root: str, ours: Iterable[str], name: str = "<module>") -> str:
    """Return *source* with absolute imports of the packages *ours* moved under *root*.

    Raises
    ------
    BundleError
        For ``import a.b`` without ``as``, which binds the top-level name.
    """
    lines = source.encode().splitlines(keepends=True)  # ast counts columns in bytes
    tops = frozenset(ours)
    absolute = [
        entry
        for entry in _imports(source, name, is_package=False, relative=False, typing_too=True)
        if entry.module.partition(".")[0] in tops
    ]
    for entry in sorted(absolute, key=lambda item: (item.line, item.column), reverse=True):
        if entry.binds_top:
            raise BundleError(f"{name}:{entry.line}: write `from ... import` for {entry.module}")
        line = lines[entry.line - 1]
        before, after = line[: entry.column], line[entry.column :]
        lines[entry.line - 1] = before + f"{root}.".encode() + after
    return b"".join(lines).decode()


@cache
def _imports(
    source: str,
    name: str,
    is_package: bool,
    relative: bool = True,
    typing_too: bool = False,
) -> tuple[_Import, ...]:
    """Return the imports of a module, with those for type checkers only if *typing_too*."""
    tree = ast.parse(source)
    skipped = set() if typing_too else _typing_only(tree)
    imports: list[_Import] = []
    for node in ast.walk(tree):
        if node in skipped:
            continue
        if isinstance(node, ast.Import):
            imports += [
                _Import(
                    alias.lineno,
                    alias.col_offset,
                    alias.name,
                    (alias.name,),
                    binds_top=alias.asname is None,
                )
                for alias in node.names
            ]
        elif isinstance(node, ast.ImportFrom) and (relative or node.level == 0):
            module = _resolved(node, name, is_package)
            candidates = (module, *(f"{module}.{alias.name}" for alias in node.names))
            line, column = _module_position(source, node)
            imports.append(_Import(line, column, module, candidates))
    return tuple(imports)


def _resolved(node: ast.ImportFrom, name: str, is_package: bool) -> str:
    if not node.level:
        return node.module or ""
    dots = "." * node.level + (node.module or "")
    return importlib.util.resolve_name(dots, name if is_package else name.rpartition(".")[0])


def _module_position(source: str, node: ast.ImportFrom) -> tuple[int, int]:
    """Return line and byte column of the module's name in a ``from`` import."""
    line = source.encode().splitlines()[node.lineno - 1]
    match = re.compile(rb"from\s+").match(line, node.col_offset)
    return node.lineno, match.end() if match else node.col_offset


def _typing_only(tree: ast.Module) -> set[ast.AST]:
    """Return the nodes under ``if TYPE_CHECKING``."""
    return {
        inner
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
        for statement in node.body
        for inner in ast.walk(statement)
    }


def _spec_origin(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec and spec.origin else None


def _exists(name: str) -> bool:
    return _spec_origin(name) is not None


def _path_of(name: str) -> Path:
    path = _spec_origin(name)
    if path is None:
        raise BundleError(f"there is no module {name}")
    return path


def _modules_in(package: str) -> list[str]:
    folder = _path_of(package).parent
    return [f"{package}.{path.stem}" for path in sorted(folder.glob("*.py")) if path.stem[0] != "_"]
