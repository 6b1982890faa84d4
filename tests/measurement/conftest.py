"""What the tests of this room share."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from measurement.importing.log import Imported, import_files


@pytest.fixture
def log(tmp_path: Path) -> Callable[..., Imported]:
    """Imports a log of a text, with the options of `import_files`."""

    def imported(text: str | bytes, name: str = "log.csv", **options: Any) -> Imported:
        content = text if isinstance(text, bytes) else text.encode()
        (tmp_path / name).write_bytes(content)
        return import_files([tmp_path / name], **options)

    return imported
