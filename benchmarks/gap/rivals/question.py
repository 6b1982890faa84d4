"""What every rival is given, and what it gives back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from benchmarks.gap.ask import MACHINE, runs_of
from gap_finder.calibrate import calibrate
from gap_finder.candidates import Candidate, candidates, missing_effects
from gap_finder.design import all_sensitivities
from gap_finder.observations import observe
from gap_finder.regimes import RunResiduals, residuals
from gap_finder.score import scored
from plant_model.machine_file import read_machine


@dataclass
class Told:
    """What a rival says.

    Attributes
    ----------
    named : list of str
        Keys of effects, first found first.
    left : list of RunResiduals, optional
        What it leaves on the held-out run; without it nothing changes there.
    more : dict
        Numbers worth keeping.
    """

    named: list[str] = field(default_factory=list)
    left: list[RunResiduals] | None = None
    more: dict[str, Any] = field(default_factory=dict)


class Question:
    """A case, and the machine calibrated on its runs exactly as the gap finder does it.

    Attributes
    ----------
    base : Machine
        As the user gave it.
    machine : Machine
        Calibrated.
    observed, unseen : list of Observations
        To calibrate on, and held out.
    sensitivities : list of RunSensitivities
        What may be wrong anyway, for each run.
    before : Fit
        The calibrated machine with its residuals and derivatives.
    left : list of RunResiduals
        What the calibrated machine leaves on the held-out run.
    without : tuple of str
        Effects that nobody is to consider.
    """

    def __init__(self, folder: Path, without: Sequence[str] = (), seed: int = 0) -> None:
        self.base = read_machine(MACHINE)
        runs, unseen = runs_of(folder)
        self.without = tuple(without)
        self.observed, self.unseen = observe(self.base, runs), observe(self.base, unseen)
        calibration = calibrate(self.base, self.observed, seed=seed)
        self.sensitivities = all_sensitivities(calibration.machine, self.observed)
        self.before = scored(self.base, self.observed, calibration, self.sensitivities)
        self.machine = self.before.machine
        self.left = [residuals(self.machine, one) for one in self.unseen]

    @cached_property
    def candidates(self) -> list[Candidate]:
        """Every effect that is not in force, at many sizes and shapes, and what each changes."""
        return [
            one
            for effect in missing_effects(self.machine, self.without)
            for one in candidates(self.machine, self.observed, effect)
        ]
