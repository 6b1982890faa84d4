"""How large the project is, and how much of it three common operations run.

Code lines exclude blanks, comments and docstrings, which pygments recognises. A walk counts the
files and functions of this project that run, not those that are only imported.
``python -m benchmarks.house``
"""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import FrameType

from pygments.lexers import CLexer, PythonLexer
from pygments.token import Comment, String, Whitespace

import spindle_drift as sd
from benchmarks.results_page import as_table, parser_of, tell
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import load_model
from plant_model.effects import catalogue

ROOT = Path(__file__).resolve().parents[1]
BESIDE = ("benchmarks", "tests", "docs")
"""Folders of Python code that are not in the wheel, listed after the product's rooms."""
MOST_COMPLEX = 15
"""Complexity above which ruff's C901 reports a function."""
GIVEN = "given by"
"""Phrase in the docstring of a number that physics, a standard or a format sets."""
MADE = re.compile(r"<!-- begin (\w+).*?<!-- end \1 -->", re.DOTALL)
"""A part of a page that a command writes."""
BETWEEN = (Whitespace, Comment, String.Doc)
SEPARATE_RUNS = ("training_down", "training_random", "stop_and_go", "training_stops")
EVERY_S = 120.0
"""Length of the walks' runs: as short as possible, because only the code that runs counts [s]."""


@cache
def files(ending: str) -> tuple[Path, ...]:
    """Return the files under version control, relative to the checkout."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", f"*{ending}"],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    return tuple(Path(name) for name in listed.stdout.split("\0") if name)


def room(file: Path) -> str:
    """Return the top folder."""
    return file.parts[0] if len(file.parts) > 1 else "build_fmu.py"


def code_lines(file: Path) -> int:
    """Return the number of lines with anything but white space, comments and docstrings."""
    lexer = PythonLexer() if file.suffix == ".py" else CLexer()
    text = (ROOT / file).read_text(encoding="utf-8")
    lines, line = set(), 1
    for kind, value in lexer.get_tokens(text):
        # pygments counts preprocessor lines as comments; here they are code.
        says = kind in Comment.Preproc or kind in Comment.PreprocFile
        if value.strip() and (says or not any(kind in other for other in BETWEEN)):
            lines.update(line + i for i in range(value.rstrip("\n").count("\n") + 1))
        line += value.count("\n")
    return len(lines)


def too_complex() -> dict[str, int]:
    """Return how many functions of each room are above `MOST_COMPLEX`."""
    limit = f"lint.mccabe.max-complexity={MOST_COMPLEX}"
    command = ["ruff", "check", "--select", "C901", "--config", limit, "--output-format", "json"]
    command = [sys.executable, "-m", *command, "--ignore-noqa", "--exit-zero", "."]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, check=True, text=True).stdout
    names = [room(Path(entry["filename"]).relative_to(ROOT)) for entry in json.loads(said)]
    return {name: names.count(name) for name in names}


def is_number(node: ast.AST | None) -> bool:
    """Return whether an expression consists only of numbers, possibly in a tuple."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp | ast.BinOp | ast.Tuple):
        parts = [part for part in ast.iter_child_nodes(node) if isinstance(part, ast.expr)]
        return bool(parts) and all(map(is_number, parts))
    return False


def numbers(file: Path) -> dict[str, str]:
    """Return the names in a module that are bound to numbers, and their docstrings.

    A docstring belongs to all the names directly above it.
    """
    body = ast.parse((ROOT / file).read_text(encoding="utf-8")).body
    told: dict[str, str] = {}
    said = ""
    for node in reversed(body):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            said = " ".join(str(node.value.value).split())
        elif not isinstance(node, ast.Assign | ast.AnnAssign):
            said = ""
        elif is_number(node.value):
            place = node.targets[0] if isinstance(node, ast.Assign) else node.target
            told[ast.unparse(place)] = said
    return told


def judged(file: Path) -> int:
    """Return how many of a module's numbers are not `GIVEN`, and so set by judgement."""
    return sum(GIVEN not in said.lower() for said in numbers(file).values())


def words() -> int:
    """Return the number of words in README and docs, without the parts that commands write."""
    pages = [page for page in files(".md") if page.parts[0] in ("README.md", "docs")]
    return sum(len(MADE.sub("", (ROOT / page).read_text("utf-8")).split()) for page in pages)


def walked(do: Callable[[], object]) -> tuple[int, int]:
    """Return how many files and functions of this project a call runs."""
    seen: set[tuple[str, int]] = set()

    def note(frame: FrameType, event: str, argument: object) -> None:
        if event == "call" and not frame.f_code.co_name.startswith("<"):
            seen.add((frame.f_code.co_filename, frame.f_code.co_firstlineno))

    sys.setprofile(note)
    try:
        do()
    finally:
        sys.setprofile(None)
    ours = {str(ROOT / file) for file in files(".py")} - {__file__}
    own = [place for place in seen if place[0] in ours]
    return len({file for file, _ in own}), len(own)


def walks() -> Iterator[tuple[str, tuple[int, int]]]:
    """Yield each walk with its numbers of files and functions."""
    runs = [
        sd.simulate("jig_borer_lumps", name, every_s=EVERY_S, noise_seed=seed)
        for seed, name in enumerate(SEPARATE_RUNS)
    ]
    others = [name for name in catalogue() if name != "centrifugal_shift"]
    yield (
        "`find-gap`, one effect and the description asked",
        walked(lambda: sd.find_gap("jig_borer_lumps", runs, without=others, workers=1)),
    )
    yield "`fit`", walked(lambda: sd.fit(runs, machine="jig_borer_lumps"))
    model = load_model(ROOT / "fmu_compensator/library/jig_borer.json")
    running, steps = RunningCompensator(model), iter(range(3))
    values = [20.0] * len(model.sensors)

    def step() -> None:
        running.step(30.0 * next(steps), 30.0, values, 6000.0, 100.0)

    step()  # the first sets the start
    yield "a step of the shipped compensator", walked(step)


def table() -> str:
    """Return the counts as Markdown."""
    complex_ones = too_complex()
    rooms = sorted({room(file) for file in files(".py")}, key=lambda name: (name in BESIDE, name))
    heads = [
        "Room",
        "Python",
        "C",
        f"above complexity {MOST_COMPLEX}",
        "numbers of modules",
        "of these judged",
    ]
    rows = []
    for name in rooms:
        inside = [file for file in files(".py") if room(file) == name]
        in_c = [file for file in (*files(".c"), *files(".h")) if room(file) == name]
        counts = [
            sum(map(code_lines, inside)),
            sum(map(code_lines, in_c)),
            complex_ones.get(name, 0),
            sum(len(numbers(file)) for file in inside),
            sum(map(judged, inside)),
        ]
        rows.append((name, counts))
    product = [counts for name, counts in rows if name not in BESIDE]
    together = ("**product together**", [sum(column) for column in zip(*product, strict=True)])
    rows.insert(len(product), together)
    text = as_table(heads, ([name, *(f"{n:,}" for n in counts)] for name, counts in rows))
    visited = ([name, *map(str, numbers)] for name, numbers in walks())
    ways = as_table(["Walk", "files", "functions"], visited)
    return f"{text}\n\n{ways}\n\nREADME and docs: {words():,} words that no command wrote."


def main() -> None:
    """Print the tables."""
    parser = parser_of(__doc__)
    tell("house", table(), write=parser.parse_args().write)


if __name__ == "__main__":
    main()
