"""Programs in processes of their own."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

import pytest

from tests.patience import PATIENCE_S


def cannot_run(problem: str) -> NoReturn:
    """Skip a test for what is missing here; under CI nothing may be missing."""
    pytest.fail(problem) if os.environ.get("CI") else pytest.skip(problem)


def need_ziglang() -> None:
    """Skip a test that needs the compiler of the package ziglang, where it is not installed."""
    if find_spec("ziglang") is None:
        cannot_run("ziglang is not installed")


def run(
    *command: object, folder: Path | None = None, given: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a program in a folder, with more in its environment; *given* is its standard input."""
    return subprocess.run(
        [str(part) for part in command],
        cwd=folder,
        env=os.environ | environment,
        input=given,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )


def output_of(
    *command: object, folder: Path | None = None, given: str = "", **environment: str
) -> str:
    """Return what a program prints, which must end well."""
    done = run(*command, folder=folder, given=given, **environment)
    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stderr}\n{done.stdout}"
    return done.stdout


def python(*argv: object, folder: Path, path: str) -> str:
    """Return what Python prints, where *path* comes before all else that can be imported."""
    return output_of(sys.executable, "-W", "error", *argv, folder=folder, PYTHONPATH=path)
