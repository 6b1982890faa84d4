"""The master on two small FMUs, against the same loop written out by hand."""

import re
import signal
import threading
from zipfile import ZipFile

import pytest

from measurement.errors import BadInput
from scenarios.fmu import FmuError
from scenarios.fmu_file import read_description
from tests.scenarios.conftest import MISSING
from tests.scenarios.tiny_fmus import COMPENSATOR, PLANT, build_tiny

FMI3 = """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">
<CoSimulation modelIdentifier="m"/><ModelVariables/><ModelStructure/></fmiModelDescription>"""


def by_hand(steps: int, h: float, speed: list[float]) -> dict[str, list[float]]:
    """The documented step order: both step from t to t + h with what was there at t."""
    temperature, sent, in_force = 20.0, 0.0, 0.0
    table: dict[str, list[float]] = {"T1_degC": [], "dX_um": [], "offset_X_um": []}
    for k in range(steps + 1):
        table["T1_degC"].append(temperature)
        table["dX_um"].append(sent)
        table["offset_X_um"].append(in_force)
        seen, given = temperature, sent
        sent = -10.0 * (seen - 20.0)
        temperature += 1e-3 * speed[k] * h
        in_force = given
    return table


@pytest.mark.parametrize("h", [1.0, 0.5])
def test_the_loop_equals_the_one_by_hand(simulated, h):
    found = simulated(("step_s", h)).frame
    steps = round(20 / h)
    speed = [1000.0 if k * h < 10 else 2000.0 for k in range(steps + 1)]
    assert found["time_s"].tolist() == [k * h for k in range(steps + 1)]
    assert found["speed_rpm"].tolist() == speed
    for name, values in by_hand(steps, h, speed).items():
        assert found[name].to_numpy() == pytest.approx(values), name


def test_without_a_compensator_the_offsets_stay_zero(simulated):
    for recording in (simulated(compensator=None), simulated(("compensator.enabled", False))):
        assert not recording.frame["offset_X_um"].any()
        assert [fmu.label for fmu in recording.fmus] == ["plant"]
        assert recording.frame["error_X_um"].iloc[-1] == pytest.approx(300.0)


def test_a_missing_reading_reaches_the_compensator_and_its_status_is_kept(simulated):
    recording = simulated(more=MISSING)
    seen = recording.frame["T1_seen_degC"]
    assert seen.index[seen.isna()].tolist() == [5, 6, 7]
    assert recording.frame["T1_degC"].notna().all()
    held = recording.frame["dX_um"].iloc[5:9]
    assert held.tolist() == [held.iloc[0]] * 4
    assert [(event.time_s, event.code, event.text) for event in recording.events] == [
        (0.0, 0, "ok"),
        (6.0, 11, "holding: T1 is missing"),
        (9.0, 0, "ok"),
    ]


def test_parameters_reach_the_plant(simulated):
    frame = simulated(("plant.parameters.gain", 0.0)).frame
    assert set(frame["T1_degC"]) == {20.0}


@pytest.mark.parametrize("told", [30.0, 0.0])
def test_a_length_blind_compensator_is_told_another_length(told, simulated):
    frame = simulated(("compensator.tool_length_mm", told)).frame
    assert set(frame["tool_length_seen_mm"]) == {told}
    assert set(frame["tool_length_mm"]) == {100.0}


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (("signals.speeed", 1.0), "signals.speeed: is not an input of the plant FMU: speed"),
        (("signals.speed", 2e5), "signals.speed: 200000 at 0 s is not allowed: the plant FMU"),
        (("signals.dX", 1.0), "signals.dX: is what the compensator sends"),
        (("plant.parameters.gian", 1.0), "no such parameter; did you mean gain?"),
        (("plant.parameters.speed", 1.0), "no such parameter"),
        (("plant.parameters.noise_seed", 1.5), "not a whole number"),
    ],
)
def test_a_scenario_that_does_not_fit_the_fmus_is_refused(simulated, override, message):
    with pytest.raises(BadInput, match=re.escape(message)):
        simulated(override)


def test_a_fault_of_a_sensor_that_is_not_there_is_refused(simulated):
    with pytest.raises(BadInput, match=r"faults, item 1, sensor: 'T7' is not one of T1"):
        simulated(more=MISSING.replace("T1", "T7"))
    with pytest.raises(BadInput, match=r"faults, item 1, sensor: 'T7' is not one of T1"):
        simulated(compensator=None)


def test_an_input_of_both_without_a_signal_has_the_plants_start_value(simulated, tiny_scenario):
    tiny_scenario.write_text(tiny_scenario.read_text().replace("tool_length = 100.0", ""))
    frame = simulated().frame
    assert set(frame["tool_length_mm"]) == {70.0}


def test_a_plants_speed_is_the_compensators_whatever_its_name(simulated, tiny_scenario, tmp_path):
    plant = build_tiny(PLANT.replace("speed", "drehzahl"), "TurningPlant", tmp_path)
    source = COMPENSATOR.replace("self.dX = -10.0 * (self.T1 - 20.0)", "self.dX = self.speed")
    compensator = build_tiny(source, "TurnedCompensator", tmp_path)
    with pytest.raises(BadInput, match=r"signals\.speed: is not an input of .* drehzahl"):
        simulated(plant=plant, compensator=compensator)
    tiny_scenario.write_text(tiny_scenario.read_text().replace("speed =", "drehzahl ="))
    frame = simulated(plant=plant, compensator=compensator).frame
    assert frame["dX_um"].tolist()[1:] == frame["drehzahl_rpm"].tolist()[:-1]
    assert "speed_rpm" not in frame


def test_what_is_no_fmu_is_refused_in_one_line(tmp_path):
    path = tmp_path / "a.fmu"
    with pytest.raises(BadInput, match="no such file"):
        read_description(path)
    path.write_bytes(b"PK nonsense")
    with pytest.raises(BadInput, match="is not an FMU") as caught:
        read_description(path)
    assert "\n" not in str(caught.value)
    with ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", FMI3)
    with pytest.raises(BadInput, match=r"FMI 2.0; use what .* or build it without --fmi 3$"):
        read_description(path)


def test_ctrl_c_is_an_interruption_and_not_a_failure_of_an_fmu(simulated):
    usual = signal.getsignal(signal.SIGINT)
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        simulated(("duration_s", 900_000), ("signals.speed", 0.0))
    timer.join()
    assert signal.getsignal(signal.SIGINT) is usual


def test_a_late_failure_names_its_time(simulated, tmp_path):
    first = "        missing = self.T1"
    late = "        if current_time >= 7.0:\n            return False\n"
    source = COMPENSATOR.replace(first, late + first)
    assert source != COMPENSATOR
    broken = build_tiny(source, "LateCompensator", tmp_path)
    with pytest.raises(FmuError, match="compensator FMU at 7 s: the step failed"):
        simulated(compensator=broken)
