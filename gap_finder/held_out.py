"""What runs never used say of an answer: it is given only if it does not make them worse."""

from __future__ import annotations

from collections.abc import Sequence

from gap_finder.calibrate import Progress, quiet
from gap_finder.data_faults import DataFault, taken_out
from gap_finder.description import NamedChange
from gap_finder.find import GapResult, find_gap
from gap_finder.keys import law_of
from gap_finder.observations import Observations, observe
from gap_finder.report import GapComparison
from gap_finder.search import USUAL, Search
from gap_finder.standing import standing_still
from measurement.runs import Run
from plant_model.machine import Machine

MOST_ASKED = 2
"""Times that the gap finder is asked at most: again where a sensor was wrong in one run alone."""


def answer(
    machine: Machine,
    runs: Sequence[Run],
    unseen: Sequence[Run],
    search: Search = USUAL,
    *,
    progress: Progress = quiet,
) -> tuple[GapResult, GapComparison, list[DataFault]]:
    """Find what is missing in a machine's model, and hold it against runs never used.

    Parameters
    ----------
    machine : Machine
    runs, unseen : sequence of Run
        Without what is broken by the data alone.
    search, progress
        As in `find_gap`.

    Returns
    -------
    found : GapResult
    comparison : GapComparison
        On the runs never used.
    faults : list of DataFault
        What was left out besides. An error of a sensor that began in the last run used, and that no
        other run bears out, is a fault of that run, and no property of the machine.
    """
    lone: list[DataFault] = []
    for _ in range(MOST_ASKED):
        sound = [taken_out(machine, run, lone) for run in runs]
        found = find_gap(machine, sound, search, progress=progress)
        progress("judging by what was kept back")
        channels = found.observed[0].channels
        later = observe(machine, unseen, channels=channels)
        names = {run.name for run in unseen}
        still = [
            fault
            for fault in standing_still(found.before.machine, [*found.observed, *later])
            if fault.run in names
        ]
        if still:
            sound = [taken_out(machine, run, still) for run in unseen]
            later = observe(machine, sound, channels=channels)
        found, comparison = confirmed(found, later)
        new = [fault for fault in _lone(found) if fault not in lone]
        if not new:
            break
        lone += new
    return found, comparison, [*found.faults, *lone, *still]


def _lone(found: GapResult) -> list[DataFault]:
    """Return errors of sensors that were found in one run alone and not borne out."""
    faults = []
    for one in found.withdrawn:
        channel = one.key.partition(":")[2]
        if law_of(one.key) != one.key or not channel or len(one.runs) != 1:
            continue
        (run,) = (seen.run for seen in found.observed if seen.run.name == one.runs[0])
        start, end = float(run.time_s[0]), float(run.time_s[-1])
        text = f"{channel} in {run.name}: wrong in this run alone, and not so in runs never used"
        faults.append(DataFault(run.name, channel, "one_run", start, end, text))
    return faults


def confirmed(found: GapResult, unseen: Sequence[Observations]) -> tuple[GapResult, GapComparison]:
    """Take back what makes runs never used worse, the effect added last first.

    Parameters
    ----------
    found : GapResult
    unseen : sequence of Observations
        Of runs that took no part in finding it.

    Returns
    -------
    found : GapResult
        With what is left, and in ``withdrawn`` what was taken back.
    comparison : GapComparison
        On these runs, before and after what is left.
    """
    before = found.before.machine
    for count in range(len(found.after.added), 0, -1):
        fewer = found.with_only(count)
        comparison = GapComparison(before, fewer.after.machine, unseen)
        if comparison.gap()["after"] <= comparison.gap()["before"]:
            return fewer, comparison
    found = found.with_only(0).only_described()
    while found.changes:
        comparison = GapComparison(before, found.after.machine, unseen)
        worse = _made_worse(found, comparison)
        if worse is None:
            return found, comparison
        found = found.without_change(worse)
    return found, GapComparison(before, before, unseen)


def _made_worse(found: GapResult, comparison: GapComparison) -> NamedChange | None:
    """Return a change that makes the channel worse that it is for; the last one if all is worse."""
    channels = comparison.channels()
    for one in reversed(found.changes):
        told = channels.get(one.channel)
        if told is not None and told["after"] > told["before"]:
            return one
    gap = comparison.gap()
    # Of hundreds of changes one may do good by doing harm elsewhere. An effect has a law: where it
    # is not quite the machine's, displacements get worse though it is the one that is missing.
    worse = gap["after"] > gap["before"] or comparison.made_worse()
    return found.changes[-1] if worse else None
