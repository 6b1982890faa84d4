"""Reads, simulates and calibrates machines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from gap_finder import calibrate as calibration
from gap_finder.advice import Advice, advice
from gap_finder.calibrate import Progress, quiet
from gap_finder.data_faults import DataFault
from gap_finder.observations import Observations
from gap_finder.priors import Priors
from gap_finder.regimes import by_channel, residuals
from gap_finder.standing import calibrated
from measurement.errors import BadInput
from measurement.runs import Run
from plant_model import simulate as plant
from plant_model.drive import DriveError, check_ranges
from plant_model.machine import Machine as Model
from plant_model.machine_file import machine_path, read_machine
from plant_model.machine_writer import write_machine
from plant_model.parameters import ParameterError
from scenarios.machine_inputs import inputs_of
from scenarios.outputs import MACHINE_FILE, check_output, guarding, marked
from scenarios.scenario import Case, read_scenario
from scenarios.scenario import Scenario as ReadScenario
from spindle_drift._inputs import MachineLike, RunLike, as_runs
from spindle_drift._plots import plot_bars
from spindle_drift._refusals import refusing, refusing_methods

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@refusing_methods
@dataclass(frozen=True)
class Machine:
    """A lumped thermal model of a spindle, as a machine file describes it.

    Parameters
    ----------
    source : path or str
        A machine file, or the name of a shipped machine.

    Attributes
    ----------
    source : path or str
    model : plant_model.machine.Machine
        The model itself.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> machine = sd.Machine("jig_borer")
    >>> machine.sensors[:3], machine.inputs
    (['T1', 'T2', 'T3'], ['speed_rpm', 'T5_degC', 'T9_degC', 'torque_Nm'])
    >>> machine.parameters.loc["numbers.balls", "unit"]
    'W/K'
    """

    source: str | Path
    model: Model = field(default=None, repr=False)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Read the file, unless the model is given."""
        if self.model is None:
            object.__setattr__(self, "model", read_machine(self.source))

    @property
    def name(self) -> str:
        """The machine's name."""
        return self.model.name

    @property
    def inputs(self) -> list[str]:
        """The columns that drive it."""
        return [entry.column for entry in self.model.inputs]

    @property
    def sensors(self) -> list[str]:
        """Its thermometers."""
        return [sensor.name for sensor in self.model.sensors]

    @property
    def parameters(self) -> pd.DataFrame:
        """Value, unit, range and source of each parameter, by its full name."""
        table = {name: entry.to_dict() for name, entry in self.model.parameters.items()}
        return pd.DataFrame.from_dict(table, orient="index")

    def with_values(self, values: Mapping[str, float]) -> Machine:
        """Return the machine with other values of some parameters.

        Parameters
        ----------
        values : mapping of str to float
            By full name, in the units of the table `parameters`.

        Raises
        ------
        BadInput
            If a name is unknown or a value is outside its range.
        """
        try:
            return replace(self, model=self.model.with_values(dict(values)))
        except (ParameterError, KeyError) as error:
            raise BadInput(self.name, "", str(error)) from None

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the machine file, keeping the comments and order of the file it came from.

        Parameters
        ----------
        path : str or path
        force : bool
            Whether whatever is in the way may be replaced.

        Returns
        -------
        Path
            The path given.

        Raises
        ------
        BadInput
            If another file is in the way and *force* is not given.
        """
        with guarding("calibrate", [machine_path(self.source)], force):
            check_output(Path(path), MACHINE_FILE)
            return write_machine(self.model, self.source, path, finish=marked)


def as_machine(given: MachineLike) -> Machine:
    """Return a machine from any accepted form."""
    return given if isinstance(given, Machine) else Machine(given)


@refusing
def simulate(
    machine: MachineLike,
    inputs: pd.DataFrame | RunLike,
    *,
    parameters: Mapping[str, float] | None = None,
    every_s: float = 10.0,
    noise_seed: int | None = None,
) -> Run:
    """Simulate the readings of a machine's sensors.

    Parameters
    ----------
    machine : Machine, path or name
    inputs : DataFrame, Run or str
        ``time_s`` and the machine's inputs, or a scenario's name or file, whose first variant is
        simulated with the plant parameters that it sets.
    parameters : mapping of str to float, optional
        Values that override the machine's and the scenario's, by full name.
    every_s : float
        Time between rows if a scenario is simulated; its signals are read at the rows only [s].
    noise_seed : int, optional
        Seed of the sensor noise; without it the readings have neither noise nor resolution.

    Returns
    -------
    Run

    Raises
    ------
    BadInput
        If the inputs cannot drive the machine or leave its ranges, or a parameter is not allowed.

    Examples
    --------
    >>> import pandas as pd
    >>> import spindle_drift as sd
    >>> inputs = pd.DataFrame({"time_s": [0.0, 1800.0, 3600.0], "speed_rpm": 6000.0,
    ...                        "T9_degC": 21.0, "T5_degC": 21.0})
    >>> run = sd.simulate("jig_borer", inputs)
    >>> bool(run.frame["T2_degC"].is_monotonic_increasing)
    True
    """
    model = as_machine(machine).model
    values, name, source = dict(parameters or {}), "simulated", "simulate"
    if noise_seed is not None and noise_seed < 0:
        raise BadInput("--seed", "", f"{noise_seed} is not allowed: 0 or more")
    if isinstance(inputs, (str, Path)):
        scenario = read_scenario(str(inputs))
        case, name, source = case_to_simulate(scenario), scenario.settings.name, str(scenario.path)
        frame = inputs_of(case, model, every_s)
        # The FMU quotes names with a hyphen, as structured naming requires; both forms work here.
        given = case.settings.plant.parameters.items()
        values = {key.replace("'", ""): value for key, value in given} | values
    else:
        frame = inputs if isinstance(inputs, pd.DataFrame) else inputs.frame
    try:
        check_ranges(model, frame)
        simulated = plant.simulate(model, frame, values, noise_seed=noise_seed)
    except (DriveError, ParameterError) as error:
        raise BadInput(source, "", str(error)) from None
    return Run(name, simulated.run_frame())


def case_to_simulate(scenario: ReadScenario) -> Case:
    """Return the first variant of a scenario."""
    if not scenario.cases:
        raise BadInput(scenario.path, "replay", "nothing is simulated in a replay")
    return scenario.cases[0]


@refusing_methods
@dataclass(frozen=True)
class Calibration:
    """A calibrated machine, and how well the runs determine its parameters.

    Attributes
    ----------
    machine : Machine
    parameters : DataFrame
        Value before and after, 95 % interval, and prior contraction (0: the runs say nothing,
        1: they determine the parameter).
    residuals : DataFrame
        RMS of model minus measurement of each channel before and after [K, um].
    left_out : list of str
        Faulty data, missing sensors, inputs outside their ranges, and runs that began warm.
    faults : list of DataFault
        The faulty data among these.
    advice : list of Advice
        What may be missing in the machine file.
    found : gap_finder.calibrate.Calibration
    observed : list of Observations
        The runs as they were compared.
    """

    machine: Machine
    parameters: pd.DataFrame
    residuals: pd.DataFrame
    left_out: list[str]
    faults: list[DataFault] = field(repr=False)
    advice: list[Advice] = field(repr=False)
    found: calibration.Calibration = field(repr=False)
    observed: list[Observations] = field(repr=False)

    def plot(self) -> Figure:
        """Return a figure of each channel's residuals before and after."""
        return plot_bars(self.residuals, "Model minus measurement", "RMS [K, µm]")


@refusing
def calibrate(
    machine: MachineLike,
    runs: RunLike | Sequence[RunLike],
    *,
    starts: int = 2,
    seed: int = 0,
    progress: Progress = quiet,
) -> Calibration:
    """Calibrate a machine's free parameters to measured runs.

    Parameters
    ----------
    machine : Machine, path or name
        Page, machine file or shipped name.
    runs : Run, DataFrame or path, or several
    starts : int
        Number of starting points; the first is the machine as given.
    seed : int
        Seed of the other starting points.
    progress : callable
        Called with what is being done.

    Returns
    -------
    Calibration

    Raises
    ------
    BadInput
        If the runs cannot be used.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> machine = sd.Machine("jig_borer_lumps")
    >>> other = machine.with_values({"links.front_inner-shaft_front.conductance": 100.0})
    >>> run = sd.simulate(other, "stop_and_go", every_s=60.0, noise_seed=1)
    >>> found = sd.calibrate(machine, run, starts=1)
    >>> bool((found.residuals["after"] <= found.residuals["before"] + 0.05).all())
    True
    """
    if not 1 <= starts <= 50:
        raise BadInput("--starts", "", f"{starts} is outside 1..50")
    from scenarios.gap_runner import remarks, usable_runs

    given, recorded = as_machine(machine), as_runs(runs)
    if not Priors.of(given.model, calibrated=True).names:
        raise BadInput(given.name, "", "nothing to calibrate: no number has calibrate = true")
    used, _, faults = usable_runs(given.model, recorded)
    fitted, observed, stood = calibrated(
        given.model, used, starts=starts, seed=seed, progress=progress
    )
    faults += stood
    before, after = (
        [residuals(model, run) for run in observed] for model in (given.model, fitted.machine)
    )
    channels = {
        "before": by_channel(before),
        "after": by_channel(after),
    }
    table = pd.DataFrame([asdict(entry) for entry in fitted.parameters])
    return Calibration(
        replace(given, model=fitted.machine),
        table.set_index("name"),
        pd.DataFrame(channels),
        [fault.text for fault in faults] + remarks(given.model, recorded),
        faults,
        advice(fitted.machine, after, fitted.parameters),
        fitted,
        observed,
    )
