"""``new-machine`` and ``show-machine``: what they write is used at once."""

import json
import re
import tomllib
from pathlib import Path

import pandas as pd
import pytest

from gap_finder.observations import compared_channels, observe
from measurement.runs import Run, read_run
from plant_model.checks import bearing_temperatures
from plant_model.drawing.columns import columns_of
from plant_model.machine_file import read_machine, shipped_machines
from plant_model.simulate import simulate
from plant_model.warm_up import warm_up
from scenarios.cli import main
from scenarios.pages.machine_page import show_machine

ANSWERS = ("--bearing", "7014", "--speed", "12000", "--power", "15")


@pytest.mark.parametrize(
    "options",
    [
        ("--bearing", "100", "--lubrication", "oil-air", "--rig", "direct"),
        ("--bearing", "7006", "--speed", "30000", "--power", "2", "--coolant", "oil 10"),
        ("--drive", "belt", "--coolant", "none", "--speed", "6000"),
        ("--bearing", "B71926-E", "--speed", "5000", "--power", "60", "--coolant", "glycol 30 %"),
        ("--bearing", "NN3020", "--title", "Grüße & <Maße>"),
    ],
)
def test_a_new_page_simulates_at_once(options, tmp_path, prints):
    path = tmp_path / "mine.toml"
    told = prints(["new-machine", "-o", str(path), *ANSWERS, *options])
    assert f"wrote {path}" in told
    assert "drift of the nose: X" in told
    assert path.read_text(encoding="utf-8").count("CHECK") > 5
    machine = read_machine(path)
    found = simulate(machine, warm_up(machine))
    assert 0.5 < abs(found.drift(0.0)[0, 240, 2]) < 600.0
    assert len(machine.sensors) >= 3
    assert not [
        line for line in show_machine(str(path), tmp_path / "x.html").wrong if "bore" in line
    ]


def run_of(folder: Path, columns: str, speed: str = "speed_rpm") -> Path:
    """Write a short run with these columns besides time and speed."""
    names = columns.split()
    rows = [",".join(["time_s", speed, *names])]
    rows += [",".join([str(60 * k), "900", *["20"] * len(names)]) for k in range(9)]
    run = folder / "run.csv"
    run.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return run


def test_a_new_page_takes_sensors_and_inputs_from_a_run(tmp_path, capsys):
    columns = "hall_degC supply_degC nose_degC stator_2_degC T7_degC dz_um"
    run = run_of(tmp_path, columns, speed="drive_rpm")
    path = tmp_path / "mine.toml"
    assert main(["new-machine", "-o", str(path), *ANSWERS, "--from-run", str(run)]) == 0
    machine = read_machine(path)
    assert [s.name for s in machine.sensors] == ["nose", "stator_2"]
    columns = {entry.name: entry.column for entry in machine.inputs}
    assert columns == {"speed": "drive_rpm", "ambient": "hall_degC", "coolant_inlet": "supply_degC"}
    assert machine.rig["axes"] == {"dz": {"axis": "Z", "sign": 1}}
    # Its name says nothing: it waits as a remark, and the command names it.
    text = path.read_text(encoding="utf-8")
    (row,) = [line for line in text.splitlines() if "T7" in line]
    assert row.startswith("  # {")
    assert row.endswith("# CHECK: place it, then uncomment it")
    told = capsys.readouterr().out
    assert "not placed, remarks in the page until you do: T7\n" in told
    path.write_text(text.replace("  # { name", "  { name"), encoding="utf-8")
    machine = read_machine(path)
    # The run compares with the machine as it stands.
    (observed,) = observe(machine, [read_run(run)])
    assert compared_channels(machine, [read_run(run)]) == ("nose", "stator_2", "T7", "dz")
    assert observed.values.shape[1] == 4


def test_the_motor_of_a_feed_does_not_turn_the_spindle():
    names = ("T_motor_degC", "T_motor_X_degC", "Z2_axis_motor_degC", "servo_motor_degC")
    frame = pd.DataFrame({"time_s": [0.0, 60.0], "hall_degC": 20.0} | dict.fromkeys(names, 21.0))
    found = columns_of(Run("run", frame)).thermometers
    assert [name for name, place in found.items() if place] == ["T_motor"]


def test_a_place_on_the_housing_says_more_than_the_housing():
    names = ("housing_front_degC", "Gehaeuse_hinten_degC", "motor_housing_degC", "housing_degC")
    frame = pd.DataFrame({"time_s": [0.0, 60.0], "hall_degC": 20.0} | dict.fromkeys(names, 21.0))
    found = columns_of(Run("run", frame)).thermometers
    assert list(found.values()) == ["front", "rear", "motor", "housing"]


BELT = ("--drive", "belt", "--bearing", "7014", "--speed", "6000", "--coolant", "none")


def test_a_new_page_has_the_parts_that_thermometers_name(tmp_path, prints):
    columns = "inside_air_degC hall_degC hall_2_degC front_degC front_below_degC rear_degC"
    columns += " headstock_degC column_top_degC column_degC nut_degC coolant_return_degC"
    run = run_of(tmp_path, columns + " feed_x_mm_min feed_z_mm_min disp_y_um disp_z_um")
    path = tmp_path / "mine.toml"
    told = prints(["new-machine", "-o", str(path), *BELT, "--from-run", str(run)])
    assert "remarks in the page until you do: hall_2, coolant_return\n" in told
    assert "looks wrong" not in told
    page = tomllib.loads(path.read_text(encoding="utf-8"))
    front, below = page["thermometers"][1:3]
    assert (front["name"], front["side"]) == ("front", "Y+")
    assert (below["name"], below["side"], below["at"]) == ("front_below", "Y-", front["at"])
    parts = {entry["name"]: entry["part"] for entry in page["thermometers"]}
    assert parts["inside_air"] == page["housing"]["air"] == "enclosure"
    assert (parts["column_top"], parts["column"]) == ("column_top", "column")
    on = {entry["name"]: entry.get("on") for entry in page["carriers"]}
    assert on == {
        "headstock": "column_top",
        "column_top": "column",
        "column": None,
        parts["nut"]: "headstock",
    }
    assert page["inputs"]["feed"]["column"] == "feed_z_mm_min"
    assert page["inputs"]["ambient"]["column"] == "hall_degC"
    nut = page["carriers"][-1]
    assert (nut["name"], nut["feed"]) == ("z_nut", {"input": "feed"})


def test_a_column_that_a_page_cannot_name_is_told(tmp_path, prints):
    run = run_of(tmp_path, "hall_degC front_degC Gehäuse_vorn_degC 3.Lager_degC")
    path = tmp_path / "mine.toml"
    told = prints(["new-machine", "-o", str(path), *BELT, "--from-run", str(run)])
    assert "left out: Gehäuse_vorn_degC, 3.Lager_degC: a thermometer's name has letters" in told


def test_a_new_page_knows_german_names_and_names_the_option_that_is_wrong(tmp_path, refused):
    names = ["Umgebung", "Kuehlmittel_Vorlauf", "Lager_vorn", "Lager_hinten", "Spindelkasten"]
    run = run_of(tmp_path, " ".join(f"{name}_degC" for name in names))
    path = tmp_path / "mine.toml"
    arguments = ["new-machine", "-o", str(path), *ANSWERS, "--from-run", str(run)]
    assert "--inlet: Vorlauf_degC is not one of" in refused([*arguments, "--inlet", "Vorlauf_degC"])
    assert main(arguments) == 0
    columns = {entry.name: entry.column for entry in read_machine(path).inputs}
    assert columns["ambient"] == "Umgebung_degC"
    assert columns["coolant_inlet"] == "Kuehlmittel_Vorlauf_degC"
    text = path.read_text(encoding="utf-8")
    assert "place it, then uncomment it" not in text
    places = dict(re.findall(r'name = "(Lager_\w+)", part = "housing", at = (-?\d+)', text))
    assert int(places["Lager_hinten"]) < int(places["Lager_vorn"])


def test_what_is_missing_or_there_already_is_said(tmp_path, refused, monkeypatch):
    path = tmp_path / "mine.toml"
    motor = ["new-machine", "-o", str(path), "--bearing", "7010", "--speed", "9000"]
    assert "--power: is missing: Motor power" in refused(motor)
    assert "--bearing: is missing: Front bearing" in refused(
        ["new-machine", "-o", str(path), "--speed", "9000", "--power", "5"]
    )
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr(
        "builtins.input", lambda asked: {"F": "7010", "H": "9000", "M": "5"}[asked[0]]
    )
    assert main(["new-machine", "-o", str(path)]) == 0
    before = path.read_bytes()
    assert "exists and is no machine file that this program made" in refused(
        ["new-machine", "-o", str(path), *ANSWERS]
    )
    assert path.read_bytes() == before
    other = tmp_path / "other.toml"
    run = run_of(tmp_path, "")
    assert "has no temperature column (_degC): the hall's air is needed" in refused(
        ["new-machine", "-o", str(other), *ANSWERS, "--from-run", str(run)]
    )
    run = run_of(tmp_path, "T1_degC")
    assert "which column is the hall's air? Say --ambient" in refused(
        ["new-machine", "-o", str(other), *ANSWERS, "--from-run", str(run)]
    )


@pytest.mark.parametrize("name", shipped_machines())
def test_every_shipped_machine_is_shown(name, tmp_path, prints):
    path = tmp_path / "page.html"
    assert f"wrote {path}" in prints(["show-machine", name, "-o", str(path)])
    text = path.read_text(encoding="utf-8")
    machine = read_machine(name)
    assert machine.title in text
    assert text.count("<svg") == 2
    assert not re.search(r'(src|href)="(?!data:)', text)
    network = text[text.index('id="network"') : text.index('id="speed"')]
    for entry in machine.inputs:
        if entry.is_boundary:
            assert f">{entry.name}</text>" in network
    for number in machine.numbers:
        if machine.numbers[number].calibrate:
            assert f"<td>numbers.{number}</td>" in text


def test_a_page_is_drawn_with_what_it_names(tmp_path):
    path = tmp_path / "page.html"
    show_machine("jig_borer", path)
    text = path.read_text(encoding="utf-8")
    section = text[text.index('id="section"') : text.index('id="network"')]
    for needed in ("T1", "T6", "jacket motor", "held by pedestal", "rotor: ", "front: ", "100 mm"):
        assert needed in section, needed
    # The bearings of two sets, above and below the axis, each a ring and a ball.
    assert len(re.findall(r"<title>(?:front|rear): [\d.]+ degC inside", section)) == 16


def test_cells_and_json(tmp_path, prints):
    path = tmp_path / "page.html"
    table = json.loads(
        prints(["show-machine", "belt_spindle", "--cells", "--json", "-o", str(path)])
    )
    assert [row["longest_mm"] for row in table["cells"]][:3] == [80.0, 40.0, 20.0]
    assert table["drift_um"][2] < -10.0
    assert 'id="cells"' in path.read_text(encoding="utf-8")


def test_a_first_page_says_how_warm_its_bearings_run(tmp_path, capsys):
    path = tmp_path / "fast.toml"
    fast = ["--bearing", "7014", "--speed", "20000", "--power", "20"]
    assert main(["new-machine", "-o", str(path), *fast]) == 0
    said = tomllib.loads(path.read_text(encoding="utf-8"))["bearings"]
    warm = bearing_temperatures(read_machine(path))
    for bearing in said:
        assert warm[bearing["name"]] == pytest.approx(bearing["running_temperature"], abs=2.0)
    assert "oil-air makes less friction than grease" in capsys.readouterr().out


def test_a_belts_power_is_not_asked_but_heeded_and_it_has_no_jackets_unless_told(tmp_path, capsys):
    path = tmp_path / "belt.toml"
    belt = ["new-machine", "--bearing", "7014", "--speed", "8000", "--drive", "belt"]
    losses = []
    for power in ("10", "20"):
        assert main([*belt, "--power", power, "-o", str(path)]) == 0
        page = tomllib.loads(path.read_text(encoding="utf-8"))
        assert "jackets" not in page
        losses.append(page["motor"]["loss"]["value"])
        path.unlink()
    assert losses[1] == pytest.approx(2.0 * losses[0])
    assert main([*belt, "--coolant", "water", "-o", str(path)]) == 0
    page = tomllib.loads(path.read_text(encoding="utf-8"))
    assert page["jackets"]
    assert "loss" not in page["motor"]
    capsys.readouterr()
