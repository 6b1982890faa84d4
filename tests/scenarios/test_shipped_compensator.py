"""The compensator that ships is the one that its recipe makes."""

import re
from pathlib import Path

import pytest

from scenarios.cli import main

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ROOT / "fmu_compensator" / "library" / "jig_borer.json"


@pytest.mark.long
def test_make_compensator_gives_the_shipped_file(tmp_path):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    training = re.search(r"^TRAINING := (.+)$", makefile, re.MULTILINE)
    options = re.search(r"spindle-drift fit .*?\\\n\s+(.+?)-o ", makefile, re.DOTALL)
    assert training
    assert options
    runs = []
    for name in training[1].split():
        runs.append(str(tmp_path / f"{name}.csv"))
        assert main(["simulate", name, "-o", runs[-1]]) == 0
    out = tmp_path / "compensator.json"
    usual = ["--machine", "jig_borer"]
    assert all(option in makefile for option in usual)
    assert main(["fit", *runs, *usual, "--name", "jig_borer", "-o", str(out)]) == 0
    new, shipped = (
        re.sub(r'"sha256": "\w+"', "", path.read_text(encoding="utf-8")) for path in (out, SHIPPED)
    )
    numbers = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
    # Processors differ in a last digit, of which the likeliest scales keep the root; the text
    # around the numbers must be the same.
    assert numbers.sub("#", new) == numbers.sub("#", shipped)
    for a, b in zip(numbers.findall(new), numbers.findall(shipped), strict=True):
        assert abs(float(a) - float(b)) <= 1e-5 * max(1.0, abs(float(b)))
