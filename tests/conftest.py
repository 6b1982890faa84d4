"""What several rooms' tests share."""

import fcntl
import gc
import os
import re
import shutil
import signal
import tempfile
import tomllib
from collections.abc import Callable, Generator, Iterator, Sequence
from functools import cache, partial, wraps
from hashlib import sha256
from importlib.metadata import entry_points
from pathlib import Path
from subprocess import CompletedProcess
from types import SimpleNamespace
from typing import IO, Any

import lark
import pytest
from hypothesis import HealthCheck, settings
from matplotlib.figure import Figure

import build_fmu
from fmu_packaging import reference
from fmu_packaging.native import compilers as native_compilers
from fmu_packaging.native.compilers import Compiler, NativeError, compilers
from scenarios.pages import figures
from tests.forked import forked
from tests.running import cannot_run

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
ROOMS: list[str] = PYPROJECT["tool"]["importlinter"]["root_packages"]
"""The packages of the product."""
LONG = ("gap_benchmark", "gap_truth", "masters", "sensor_faults_benchmark", "trust_benchmark")
"""Folders of tests that take longer than a change should wait: a matter of ``make long``."""

SHARED_DATA = ROOT.parent / "shared" / "data"
OTHERS = {name: getattr(native_compilers, name) for name in ("FOR_WINDOWS", "FOR_AARCH64")}
"""The compilers for other platforms, by the constants that name them."""
AS_SHIPPED = native_compilers.COMPILED
QUICKLY = tuple("-O0" if flag.startswith("-O") else flag for flag in AS_SHIPPED)
"""How a library is compiled: no number depends on it, and it takes a third of the time."""
SETTLE, SAVE = figures.settle, Figure.savefig
NO_MATTER = {"-shared", "-s", "-O0", "-I."}
"""Flags that compile nothing: for the linker, as without, or as it is anyway."""


# How long an example takes says more about the machine than about what is tested. Every run draws
# other examples; ``make long`` draws many.
settings.register_profile(
    "a few",
    deadline=None,
    max_examples=40,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.register_profile("many", settings.get_profile("a few"), max_examples=500)
settings.load_profile("a few")

# A shell that starts the tests in the background, as many a CI does, leaves SIGINT ignored, and
# what they start would inherit that: Ctrl-C could not be tested, and a test waited for it for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure() -> None:
    """Without the plug-ins that pyproject.toml names, half of the error models would be missing."""
    for group, named in PYPROJECT["project"]["entry-points"].items():
        installed = {point.name for point in entry_points(group=group)}
        if not installed >= set(named):
            pytest.exit(f"{group}: pyproject.toml is newer: make build", returncode=4)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Nothing that is imported goes away again, and little else is garbage: look for it rarely."""
    gc.disable()
    collected = yield
    gc.freeze()
    gc.set_threshold(100_000)
    gc.enable()
    return collected


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """What they import takes a second in each process."""
    first = collection_path.relative_to(ROOT).parts[1:2]
    passed_over = "not long" in config.option.markexpr and first and first[0] in LONG
    return True if passed_over else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is in these folders."""
    for item in items:
        if item.path.relative_to(HERE).parts[0].startswith(LONG):
            item.add_marker(pytest.mark.long)


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of what is made once for all processes of this run of the tests."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base) / "shared"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture
def plain_path() -> Iterator[Path]:
    """A folder with a plain ASCII path, as FMUs in Python need it; tmp_path has the user's name."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def once(path: Path, make: Callable[[Path], object]) -> Path:
    """Return a path where *make* has written something, in this process or in another."""
    with path.with_name(f"{path.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():
            with tempfile.TemporaryDirectory(dir=path.parent) as work:
                make(Path(work) / "made")
                (Path(work) / "made").rename(path)
    return path


INCLUDED = re.compile(r'^\s*#\s*include "(.+)"', re.MULTILINE)
IDLE = re.compile(r"/\*.*?\*/|^#ifdef FMI\d_FUNCTION_PREFIX$.*?^#endif$", re.MULTILINE | re.DOTALL)
"""Comments, and the names of a program, which say nothing where they get no prefix."""


def with_included(folder: Path, name: str) -> dict[str, str]:
    """Return the text of a C source and of all that it includes, by name."""
    texts: dict[str, str] = {}
    left = [name]
    while left:
        name = left.pop()
        path = folder / name
        if name not in texts and path.is_file():
            texts[name] = IDLE.sub("", path.read_text("utf-8"))
            left += INCLUDED.findall(texts[name])
    return texts


@pytest.fixture(scope="session", autouse=True)
def compiled_once(shared: Path) -> Iterator[None]:
    """A source that several programs share is compiled once, quickly, for this machine only.

    That the same sources give the same library is seen between processes that share nothing
    (``tests/native/test_fmu.py``); `every_compiler` is for tests of other platforms and of what is
    compiled as it ships.
    """
    run_compiler = native_compilers.run_compiler

    def compiled(flags: Sequence[str], name: str, folder: Path) -> Path:
        texts = with_included(folder, name)
        whole = "".join(texts.values())
        flags = [flag for flag in flags if flag[:2] != "-D" or flag[2:].partition("=")[0] in whole]
        key = sha256(repr((flags, sorted(texts.items()))).encode()).hexdigest()
        command = [*flags, "-c", name, "-o"]
        return once(shared / f"{key}.o", lambda new: run_compiler([*command, str(new)], folder))

    @wraps(run_compiler)
    def known(command: Sequence[str], folder: Path) -> None:
        if "-o" not in command or "-target" in command:
            run_compiler(command, folder)
            return
        at = command.index("-o")
        head, rest = command[:at], command[at:]
        flags = [flag for flag in head if flag not in NO_MATTER]
        if "-c" in head:
            *flags, _, source = flags
            shutil.copyfile(compiled(flags, source, folder), folder / rest[1])
            return
        if "-shared" not in head:  # as a library has it
            flags += ["-fPIC", "-fvisibility=hidden"]
        parts = [
            str(compiled(flags, part, folder)) if part.endswith(".c") else part for part in rest
        ]
        run_compiler([*head, *parts], folder)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(native_compilers, "run_compiler", known)
        patched.setattr(native_compilers, "COMPILED", QUICKLY)
        for name in OTHERS:
            patched.setattr(native_compilers, name, "")
        yield


@pytest.fixture(scope="module")
def every_compiler() -> Iterator[None]:
    """The compilers for other platforms, too, and all as for what ships."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(native_compilers, "COMPILED", AS_SHIPPED)
        for name, command in OTHERS.items():
            patched.setattr(native_compilers, name, command)
        yield


@pytest.fixture(scope="session", autouse=True)
def names_read_quickly() -> Iterator[None]:
    """Variables' names are read by fmpy's grammar in linear time: else that is half of a build."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(lark, "Lark", cache(partial(lark.Lark, parser="lalr")))
        yield


@pytest.fixture(scope="session", autouse=True)
def reference_runs_forked() -> Iterator[None]:
    """A reference run is made in a process that has imported fmpy already.

    The wheel's tests and those of builds in processes of their own have it as it ships.
    """

    def run(command: Sequence[str], **settings: Any) -> CompletedProcess[str]:
        script = Path(command[3]).read_text("utf-8")
        return forked(script, command[4:], settings["cwd"], settings["env"])

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(reference, "subprocess", SimpleNamespace(run=run))
        yield


def unsaved(_: Figure, where: IO[bytes] | Path, **__: object) -> None:
    """Save no picture, into a stream or a file."""
    if isinstance(where, Path):
        where.write_bytes(b"no picture")
    else:
        where.write(b"no picture")


@pytest.fixture(scope="session", autouse=True)
def undrawn() -> Iterator[None]:
    """A figure is made but not drawn, which takes half of the time of a command that has one."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(figures, "settle", lambda figure: None)
        patched.setattr(Figure, "savefig", unsaved)
        yield


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of what a picture shows: it is drawn, and a warning on the way is an error."""
    monkeypatch.setattr(figures, "settle", SETTLE)
    monkeypatch.setattr(Figure, "savefig", SAVE)


@pytest.fixture(scope="session")
def shipped(shared: Path) -> Path:
    """The shipped plant and compensator as build_fmu.py makes them; tests copy what they change."""
    return once(shared / "dist", built)


@pytest.fixture(scope="session")
def c_compiler() -> Compiler:
    """This machine's C compiler; without one the tests that ask for it skip, in CI they fail."""
    try:
        return compilers()[0]
    except NativeError as error:
        cannot_run(str(error))


@pytest.fixture(scope="session")
def compiler(c_compiler: Compiler) -> tuple[str, ...]:
    """Its command."""
    return c_compiler.command


@pytest.fixture(scope="session")
def shipped_in_c(shared: Path, shipped: Path, c_compiler: Compiler) -> Path:
    """The same, beside their twins in C."""

    def make(new: Path) -> None:
        shutil.copytree(shipped, new)
        built(new, "--native")

    return once(shared / "dist_in_c", make)


@pytest.fixture(scope="session")
def shipped_in_fmi3(shared: Path, shipped_in_c: Path) -> Path:
    """The twins in C for FMI 3.0."""
    return once(shared / "dist_in_fmi3", lambda new: built(new, "--native", "--fmi", "3"))


def built(folder: Path, *arguments: str) -> None:
    """Run build_fmu.py into a folder."""
    assert build_fmu.main([*arguments, "--out", str(folder)]) == 0


@pytest.fixture(scope="session")
def lathe_runs() -> list[Path]:
    """The measured lathe runs, in order of date."""
    runs = sorted(path for path in (SHARED_DATA / "lathe").glob("2*.csv"))
    if not runs:
        pytest.skip("the measured lathe runs are not beside this checkout")
    return runs


@pytest.fixture(scope="session")
def electric_spindle_run() -> Path:
    """The measured record of an electric spindle."""
    path = SHARED_DATA / "electric_spindle" / "first_3000_min.csv"
    if not path.is_file():
        pytest.skip("the measured electric spindle record is not beside this checkout")
    return path
