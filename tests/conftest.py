"""What several rooms' tests share."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path

import pytest

from fmu_packaging.native.compilers import Compiler
from measurement.files import write_atomically

ROOT = Path(__file__).resolve().parent.parent
SHARED_DATA = ROOT.parent / "shared" / "data"


# A shell that starts the tests in the background, as many a CI does, leaves SIGINT ignored, and
# what they start would inherit that: Ctrl-C could not be tested, and a test waited for it for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The same sources give the same library: it is compiled once for all tests.

    That they do is seen between processes, which share nothing (``tests/native/test_fmu.py``).
    """
    base = tmp_path_factory.getbasetemp()
    shared = (base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base) / "compiled"
    shared.mkdir(exist_ok=True)
    compiled = Compiler.library

    def library(self: Compiler, sources: Mapping[str, str]) -> bytes:
        known = sha256(repr((self, sorted(sources.items()))).encode()).hexdigest()
        path = shared / known
        if not path.is_file():
            write_atomically(path, compiled(self, sources))
        return path.read_bytes()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Compiler, "library", library)
        yield


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
