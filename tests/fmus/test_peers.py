"""The FMU that other tools' FMUs are measured against does what they do."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.peers.__main__ import BASELINE, Peer, by_hand, check, loaded
from fmu_packaging.native.compilers import compilers


@pytest.mark.skipif(not compilers(), reason="no C compiler")
def test_the_regression_by_hand_is_right(tmp_path: Path) -> None:
    step, outputs = loaded(Peer(BASELINE, by_hand(tmp_path)), tmp_path / "unpacked")
    for k in range(3):
        step(k)
    check(outputs(), 3)
    with pytest.raises(ValueError, match="y0"):
        check(outputs(), 1000)
