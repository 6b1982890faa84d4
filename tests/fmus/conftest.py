"""Both FMUs, built once for all tests of this folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

import build_fmu
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
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The two FMUs with their reference results, as build_fmu.py makes them."""
    folder = tmp_path_factory.mktemp("dist")
    model = tmp_path_factory.mktemp("models") / "by_hand.json"
    model.write_text(five_point_text())
    assert build_fmu.main(["--model", str(model), "--out", str(folder)]) == 0
    return Built(folder, model)
