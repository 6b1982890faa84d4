"""The FMUs of this folder, built once: a compensator made by hand, and the shipped plant."""

from pathlib import Path

import pytest

from tests.conftest import built, once
from tests.fmus.models import five_point_text


@pytest.fixture(scope="session")
def compensator(shared: Path) -> Path:
    """A compensator FMU with its reference results, as build_fmu.py makes it."""
    model = once(shared / "fmus.json", lambda new: new.write_text(five_point_text()))
    options = ("--only", "compensator", "--model", str(model))
    return once(shared / "fmus", lambda new: built(new, *options)) / "compensator.fmu"


@pytest.fixture(scope="session")
def plant(shipped: Path) -> Path:
    """The plant FMU."""
    return shipped / "plant.fmu"
