"""Both C FMUs in a host without Python give what a run of the scenario gives."""

from __future__ import annotations

import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pandas as pd

from fmu_packaging.native.build import HEADERS
from fmu_packaging.native.compilers import STRICT, run_compiler
from plant_model.parameters import FloatArray
from scenarios.cosimulation import simulate
from scenarios.fmu_file import read_description
from scenarios.scenario import read_scenario

HOST = Path(__file__).resolve().parent / "loop_host.c"
STEPS, STEP_S = 720, 10.0


def test_the_loop_in_a_c_host_is_that_of_a_run(
    compiler: tuple[str, ...], shipped_in_c: Path, tmp_path: Path
) -> None:
    settings = [("duration_s", STEPS * STEP_S), ("step_s", STEP_S), ("record_s", STEP_S)]
    settings.append(("plant.noise", False))
    case = next(c for c in read_scenario("step_speed", settings).cases if "long" in c.name)
    compensator = shipped_in_c / "compensator_native.fmu"
    # Its plant is the one in Python: two programs and two masters, and the same numbers.
    expected = simulate(case, shipped_in_c / "plant.fmu", compensator, quiet=True).frame
    found, names = in_c(shipped_in_c, tmp_path, compiler, expected)
    assert expected["dZ_um"].abs().max() > 5.0
    for place, column in enumerate(names):
        one, other = found[:, place], expected[column].to_numpy()
        assert np.max(np.abs(one - other)) < 1e-8, column


def in_c(
    fmus: Path, folder: Path, compiler: tuple[str, ...], frame: pd.DataFrame
) -> tuple[FloatArray, list[str]]:
    """Return the outputs at every point, (points, outputs), and the columns that they stand in."""
    run_compiler(
        [*compiler, *STRICT, "-O1", f"-I{HEADERS}", "-o", "loop_host", str(HOST), "-ldl"], folder
    )
    parts, columns, command = {}, {}, [str(folder / "loop_host")]
    for kind in ("plant", "compensator"):
        path = fmus / f"{kind}_native.fmu"
        described = read_description(path)
        unpacked = Path(fmpy.extract(str(path), unzipdir=str(folder / kind)))
        library = f"{kind}_native{fmpy.sharedLibraryExtension}"
        command += [str(unpacked / "binaries" / fmpy.platform / library), described.guid]
        reals = [v for v in described.modelVariables if v.type == "Real"]
        for causality in ("input", "output"):
            parts[kind, causality] = {
                v.name: v.valueReference for v in reals if v.causality == causality
            }
        columns |= {(kind, v.name): f"{v.name}_{v.unit}" for v in reals}
    plant_in, plant_out = parts["plant", "input"], parts["plant", "output"]
    told, sent = parts["compensator", "input"], parts["compensator", "output"]
    shared = [name for name in told if name in plant_out]
    offsets = [name for name in sent if name in plant_in]
    driven = [name for name in plant_in if columns["plant", name] in frame and name not in offsets]
    free = [name for name in told if name in driven]
    rows = [
        [plant_in[name] for name in driven],
        [told[name] for name in free],
        [plant_out[name] for name in shared],
        [told[name] for name in shared],
        [sent[name] for name in offsets],
        [plant_in[name] for name in offsets],
        list(plant_out.values()),
        list(sent.values()),
    ]
    counts = [len(rows[place]) for place in (0, 1, 2, 4, 6, 7)]
    values = frame[[columns["plant", n] for n in (*driven, *free)]].to_numpy()
    lines = [counts, *rows, *values.tolist()]
    done = subprocess.run(
        [*command, str(STEPS), str(STEP_S)],
        input="\n".join(" ".join(map(repr, line)) for line in lines),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = [[*map(float.fromhex, line.split())] for line in done.stdout.splitlines()]
    names = [columns["plant", n] for n in plant_out] + [columns["compensator", n] for n in sent]
    return np.array(found), names
