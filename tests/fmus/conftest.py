"""Both FMUs, built once for all tests of this folder."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.conftest import built as build
from tests.conftest import once
from tests.fmus.models import five_point_text


@dataclass(frozen=True)
class Built:
    """Where things are."""

    folder: Path
    model: Path

    @property
    def compensator(self) -> Path:
        """The compensator FMU."""
        return self.folder / "compensator.fmu"

    @property
    def plant(self) -> Path:
        """The plant FMU."""
        return self.folder / "plant.fmu"


@pytest.fixture(scope="session")
def built(shared: Path) -> Built:
    """The two FMUs with their reference results, as build_fmu.py makes them."""
    model = once(shared / "fmus.json", lambda new: new.write_text(five_point_text()))
    return Built(once(shared / "fmus", lambda new: build(new, "--model", str(model))), model)
