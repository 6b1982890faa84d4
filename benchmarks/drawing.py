"""How accurate a machine from a drawing page is: ``python -m benchmarks.drawing [--write]``.

The machines come from the independent fine simulator of ``benchmarks.gap.truth``, drawn at random
around the sections of the page `jig_borer` (masses and sections within 15 %, joints and films
within a factor of 1.5), with no effect missing. The page, with thermometers in the simulator's
places, is calibrated on four runs; its remaining error on the fifth, in units of sensor noise, is
compared with that of the uncalibrated page, a model that never moves, the machine in lumps
(`jig_borer_lumps`) calibrated on the same runs, and the simulator itself, given only the inputs in
the run file.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.gap.agree import never_moves
from benchmarks.gap.around_page import PAGE, SHOP, page_table
from benchmarks.gap.case import CaseRun, TruthCase
from benchmarks.gap.truth.told import as_told
from benchmarks.results_page import as_table, parser_of, tell
from gap_finder.calibrate import calibrate
from gap_finder.observations import Observations, observe
from gap_finder.regimes import RunResiduals, gap_of, residuals
from measurement.runs import Run
from plant_model.drawing.expand import expanded
from plant_model.machine import Machine
from plant_model.machine_file import machine_from_table, machine_path, read_machine
from plant_model.parameters import FloatArray

HEAD = ("Machine", "Never moves", "Page as it stands", "Calibrated page", "Lumps, calibrated")
TOLD = "The simulator itself, told as much"


def simulator_as_told(machine: Machine, case: TruthCase, run: CaseRun) -> float:
    """Return the simulator's own remaining error on a run, given only the run file's inputs.

    In noise units.
    """
    frames = (run.frame, as_told(SHOP, case, run))
    seen, done = (observe(machine, [Run(run.name, frame)])[0] for frame in frames)
    return gap_of([RunResiduals(seen, _from_zero(done) - _from_zero(seen))])


def _from_zero(observed: Observations) -> FloatArray:
    """Return an observation's values, with displacements relative to the first."""
    values = observed.values.copy()
    values[:, observed.lengths] -= values[0, observed.lengths]
    return values


def _calibrated(machine: Machine, runs: Sequence[Run]) -> tuple[float, float, float]:
    """Return the last run's error: never moving, uncalibrated, calibrated on the other runs."""
    *known, unseen = observe(machine, runs)
    found = calibrate(machine, known, starts=1).machine
    before, after = (gap_of([residuals(one, unseen)]) for one in (machine, found))
    return never_moves(machine, [unseen]), before, after


def left_of(page: Machine, seed: int) -> list[float]:
    """Return a machine's row of the table, in noise units."""
    case = TruthCase(seed)
    simulated = SHOP.simulate(case)[0]
    runs = [Run(run.name, run.frame) for run in simulated]
    lumps = _calibrated(read_machine("jig_borer_lumps"), runs)[-1]
    return [*_calibrated(page, runs), lumps, simulator_as_told(page, case, simulated[-1])]


def main() -> int:
    """Print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--machines", type=int, default=5, metavar="N", help="how many (5)")
    args = parser.parse_args()
    path = machine_path(PAGE)
    page = machine_from_table(expanded(page_table(), path), path)
    left = [left_of(page, seed) for seed in tqdm(range(1, args.machines + 1), disable=None)]
    rows = {**dict(enumerate(left, 1)), "Mean": np.mean(left, axis=0)}
    cells = [[str(name), *(f"{value:.1f}" for value in row)] for name, row in rows.items()]
    tell("drawing", as_table([*HEAD, TOLD], cells), write=args.write)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
