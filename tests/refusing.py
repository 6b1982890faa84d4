"""Bad input is refused in one line."""

from collections.abc import Callable
from typing import Any

import pytest

from fmu_compensator.runtime.fields import ModelFileError
from measurement.errors import BadInput


def refusal(call: Callable[..., object], *given: Any, **options: Any) -> str:
    """Return the line with which a call is refused."""
    with pytest.raises((BadInput, ModelFileError)) as caught:
        call(*given, **options)
    said = str(caught.value)
    assert "\n" not in said
    return said
