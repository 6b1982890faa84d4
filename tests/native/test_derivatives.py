"""The compensator's derivatives beside differences of its steps, in every kind of step."""

import re
import zipfile
from pathlib import Path

import pytest

import build_fmu
from fmu_compensator.runtime.modelfile import model_text
from tests.fmu_packaging.apart import apart
from tests.native.made import made_model

OPENED = """
import math
import numpy as np
description = fmpy.read_model_description(sys.argv[1])
fmu = started(opened(sys.argv[1]))
two, refs, outs, knowns = fmu.two, fmu.refs, fmu.outs, fmu.ins
get, put = lambda refs: np.array(fmu.get(refs)), fmu.put
keep, back = ((fmu.getFMUstate, fmu.setFMUstate) if two else (fmu.getFMUState, fmu.setFMUState))
forward = lambda: np.array([fmu.getDirectionalDerivative(outs, [k], [1.0]) for k in knowns]).T
code = lambda: fmu.whole([refs["status"]])[0]
"""

HELD = """
STEP, LAST = 10.0, 150
sensors = [v for v in knowns if v not in (refs["speed"], refs["tool_length"])]
rng = np.random.default_rng(2)
pace = rng.uniform(0.2, 1.0, len(sensors))
def inputs(k):
    values = 20.0 + 9.0 * pace * (1.0 - np.exp(-k * STEP / 900.0)) + 1e-3 * np.sin(k + pace)
    values[1] = math.nan if 60 <= k < 75 else values[1]
    return [*values, 3000.0, 120.0 if k < 110 else 1e5 if k < 120 else 90.0]
def stepped(values, time):
    put(knowns, list(map(float, values)))
    fmu.doStep(time, STEP)
    return get(outs)
seen, count, adjoint, declared = {}, 0, 0.0, True
told = {u.variable.valueReference: [k.valueReference for k in u.dependencies]
        for u in description.outputs}
told = np.array([[k in told[u] for k in knowns] for u in outs])
for k in range(LAST):  # through a broken sensor, a tool that is too long, and measurements
    values, time = np.array(inputs(k)), k * STEP
    if measured := k % 40 == 20:
        probed = [n for n in refs if n.startswith("measured_")]
        put([refs[n] for n in probed], [1.0 + 0.1 * i for i in range(len(probed))])
    fmu.setBoolean([refs["measured"]], [measured])
    put(knowns, list(map(float, values)))
    if k > 1:
        found, state = forward(), keep()
        declared &= bool((told | (found == 0.0)).all())
        if not two:
            weights = rng.normal(size=len(outs))
            other = np.array(fmu.getAdjointDerivative(outs, knowns, weights.tolist(), len(knowns)))
            size = 1e-12 + np.abs(weights) @ np.abs(found)
            adjoint = max(adjoint, float((np.abs(other - weights @ found) / size).max()))
        columns = []
        for place, value in enumerate(values):
            h = 1e-3 if place < len(sensors) else 1e-2
            rows = []
            for by in (-2 * h, -h, h, 2 * h):
                back(state)
                moved = values.copy()
                moved[place] = value + by
                rows.append(stepped(moved, time))
            columns.append((8 * (rows[2] - rows[1]) - (rows[3] - rows[0])) / (12 * h))
        back(state)
        before = stepped(values, time)
        by_differences = np.nan_to_num(np.array(columns).T)
        off = np.abs(found - by_differences) / (1e-3 + np.abs(by_differences))
        if code() == 4:
            # The uncertainties' share of broken sensors counts as constant.
            off[6:, knowns.index(refs["tool_length"])] = 0.0
        # Where what is kept back of a drift is a share of nothing, its size has a kink.
        off[6:9][np.abs(before[:3]) < 0.01] = 0.0
        seen[code()] = max(seen.get(code(), 0.0), float(off.max()))
        count += int((found != 0.0).sum())
    else:
        stepped(values, time)
show([seen, count, adjoint, declared])
"""


def flags_of(path: Path) -> list[str]:
    """Return what an FMU says of its derivatives."""
    with zipfile.ZipFile(path) as archive:
        text = archive.read("modelDescription.xml").decode()
    return re.findall(r'provides(?:Directional|Adjoint)Derivatives?="(\w+)"', text)


@pytest.mark.parametrize(
    ("folder", "fmu", "comes_through"),
    [
        ("shipped_in_c", "compensator_native.fmu", {"0", "2", "4", "12"}),
        ("by_hand", "compensator_native_fmi3.fmu", {"0"}),
    ],
)
def test_derivatives_are_those_of_differences(folder, fmu, comes_through, request):
    path = request.getfixturevalue(folder) / fmu
    assert flags_of(path) == ["true"] * (2 if "fmi3" in fmu else 1)
    seen, count, adjoint, declared = apart(OPENED + HELD, path)
    assert comes_through <= set(seen)
    assert max(seen.values()) < 1e-5
    assert count > 1000
    assert adjoint < 1e-12
    assert declared


@pytest.mark.long
def test_an_error_model_that_is_not_linear_gives_none(tmp_path):
    model = tmp_path / "made.json"
    model.write_text(model_text(made_model("vac", 0).table))
    arguments = ["--native", "--fmi", "3", "--only", "compensator", "--model", str(model)]
    assert build_fmu.main([*arguments, "--out", str(tmp_path)]) == 0
    path = next(tmp_path.glob("*.fmu"))
    assert flags_of(path) == ["false"] * 2
    refused = "show([status_of(fmu.getDirectionalDerivative, outs[:1], knowns[:1], [1.0])])"
    assert apart(OPENED + refused, path) == [3]
