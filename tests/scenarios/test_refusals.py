"""What commands refuse: exit code 2, one line that says what is wrong, and nothing is written."""

import shlex
from pathlib import Path

import pytest

from scenarios.building import DEFAULT_MODEL
from tests.scenarios.test_import import LOCAL

IMPORT = "import log.csv -o runs"
MODEL = shlex.quote(str(DEFAULT_MODEL))
NEW = "new-machine -o mine.toml --bearing 7014 --speed 12000 --power 15"
REPLAY = "replay model.json run.csv --out out"
RUN = "run tiny.toml --fmu-dir fmus --out out"
SIMULATE = "simulate step_speed -o run.csv"
FIND_GAP = "find-gap jig_borer_lumps --runs a.csv --out out --quiet"
SWEEP = "sweep tiny.toml --fmu-dir fmus --out out"
SSP = "ssp tiny.toml --fmu-dir fmus -o a.ssp"
FAULT = '{sensor="T1", kind="missing", start_s=5}'
REFUSED = [
    ("rum", "invalid choice: 'rum'"),
    ("run", "required: SCENARIO"),
    ("list --jsno", "unrecognized arguments: --jsno (see 'spindle-drift list --help')"),
    ("run step_sped", "did you mean step_speed?"),
    ("run step_speed --set duration_s", "is not of the form KEY=VALUE"),
    ("run step_speed --set duration=5", "duration: is not a known field"),
    ("run step_speed --plant no.fmu", "no.fmu: there is no such file"),
    (f"{RUN} --plant fmus/plant.fmu --compensator fmus/plant.fmu", "is no compensator: it has no"),
    (f"{RUN} --plant fmus/compensator.fmu", "is no plant: it has no input dX, dY or dZ"),
    (f"{RUN} --compensator lathe", "lathe: is a machine file, not a compensator"),
    (f"{SWEEP} --set plant.fmu={MODEL}", "jig_borer.json: is a compensator file, not a plant"),
    ("run replay", "replay.runs: names no run"),
    ("replay no.json no.csv", "no.csv: no such file"),
    ("replay no.json no.csv --tool-length=nan", "--tool-length: "),
    ("replay no.json no.csv --tool-length=-1e9", "--tool-length: "),
    (f"{REPLAY} --probe-when 3", "--probe-when: '3' is not allowed: a number with its unit"),
    (f"{REPLAY} --probe-every 0min", "--probe-every: '0min' is not allowed: a number with its"),
    (f"{REPLAY} --probe-noise 1um", "--probe-noise: needs --probe-when or --probe-every"),
    (f"{REPLAY} --seed -1", "--seed: -1 is not allowed: 0 to "),
    (f"{SIMULATE} --every nan", "--every: "),
    (f"{SIMULATE} --every 1e-9", "--every: "),
    (f"{SIMULATE} --every 1e9", "--every: "),
    (f"{IMPORT} --unit Druck", "--unit: 'Druck' is not of the form HEADER=UNIT"),
    (f"{IMPORT} --unit Druck*=bar", "--unit: 'bar' is not a known unit: s, min, h"),
    (f"{IMPORT} --timezone Mars/Olympus", "'Mars/Olympus' is no time zone"),
    (f"{IMPORT} --pause 0", "pause_s: 0 is not allowed"),
    (f"{IMPORT} --every nan", "every_s: nan is not allowed"),
    (f"{IMPORT} --mapping log.csv", "log.csv: is not TOML"),
    (f"{IMPORT} --day-first --month-first", "not allowed with argument --day-first"),
    (f"{NEW} --bearing 7099", "'7099' is not known; known are NN3005 to NN3032"),
    (f"{NEW} --speed nan", "--speed: nan is not in 100..100000 r/min"),
    (f"{NEW} --power 15000", "--power: 15000.0 is not in 0.1..200 kW"),
    (f"{NEW} --coolant beer", "--coolant: 'beer' is not one of none, water, glycol N %"),
    (f"{NEW} --title 'a \"b\"'", "--title: must be one line without quotes"),
    (f"{FIND_GAP} --most 0", "--most: 0 is outside 1..20"),
    (f"{FIND_GAP} --workers 0", "--workers: 0 is outside 1..256"),
    (f"{SWEEP} --workers 0", "--workers: 0 is not allowed: 1 to 1024"),
    (f"{SWEEP} --workers 2 --cluster tcp://x:1", "not allowed with argument"),
    (f"{SWEEP} --repeat many", "invalid int value"),
    ("compare --out out", "--train and --validate are needed"),
    ("compare --runs a.csv b.csv --train a.csv --out out", "cannot stand beside"),
    ("compare --train a.csv --validate b.csv --out out", "no such file"),
    ("sweep replay --out out", "replay: cannot be swept"),
    (f"{SSP} --set 'faults=[{FAULT}]'", "faults: cannot be put into an .ssp"),
    (f"{SSP} --set compensator.probe.every_s=60", "compensator.probe: cannot be put into"),
    (f"{SSP} --variant nope", "--variant: 'nope' is not one of main"),
    (f"{SSP} --set signals.speeed=1", "correct it, or remove it from a copy"),
    (f"{SSP} --plant compensator.fmu", "is no plant"),
    (f"{SSP} -o /", "cannot be written"),
    ("ssp replay", "replay: has no plant to put into an .ssp"),
    (f"web lathe {MODEL} -o page.html", "neither an output of the plant nor a signal"),
    (f"web mill {MODEL} -o page.html", "mill"),
]


@pytest.mark.parametrize(("line", "said"), REFUSED, ids=[said for _, said in REFUSED])
def test_a_wrong_command_line_is_refused_in_one_line_and_writes_nothing(
    line, said, tiny_scenario, tiny_folder, tmp_path, monkeypatch, refused
):
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text(LOCAL, encoding="cp1252")
    before = sorted(tmp_path.rglob("*"))
    told = refused(shlex.split(line))
    assert told.startswith("spindle-drift: error: ")
    assert said in told
    assert sorted(tmp_path.rglob("*")) == before
