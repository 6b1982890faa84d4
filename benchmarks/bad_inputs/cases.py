"""The bad inputs, by what is wrong."""

from __future__ import annotations

from benchmarks.bad_inputs.case import BadInputCase, Change, cell, replaced, without_column

FIT = "fit a.csv b.csv c.csv --model mlr --machine jig_borer -o new.json"
SUMMARY = "summary a.csv"


def _run(title: str, wanted: str, change: Change, command: str = SUMMARY) -> BadInputCase:
    return BadInputCase(title, command, wanted, changes={"a.csv": change})


def _option(title: str, command: str, wanted: str) -> BadInputCase:
    return BadInputCase(title, command, wanted)


def _machine(title: str, wanted: str, old: str, new: str) -> BadInputCase:
    command = "simulate stop_and_go --machine lumps.toml -o new.csv"
    return BadInputCase(title, command, wanted, changes={"lumps.toml": replaced(old, new)})


def _page(title: str, wanted: str, old: str, new: str) -> BadInputCase:
    return BadInputCase(
        title,
        "show-machine page.toml -o new.html",
        wanted,
        changes={"page.toml": replaced(old, new)},
    )


def _compensator(title: str, wanted: str, old: str, new: str) -> BadInputCase:
    command = "monitor c.json a.csv"
    return BadInputCase(title, command, wanted, changes={"c.json": replaced(old, new)})


def _scenario(title: str, wanted: str, old: str, new: str) -> BadInputCase:
    command = "simulate s.toml -o new.csv"
    return BadInputCase(title, command, wanted, changes={"s.toml": replaced(old, new)})


RUN_FILES = [
    BadInputCase("no such run file", "summary nowhere.csv", "nowhere.csv: no such file"),
    BadInputCase("a folder in place of a run", "summary .", "."),
    BadInputCase("an empty run file", SUMMARY, "a.csv", {"a.csv": ""}),
    BadInputCase("a header and no rows", SUMMARY, "a.csv", {"a.csv": "time_s,T1_degC\n"}),
    BadInputCase(
        "a workbook called csv", SUMMARY, "a.csv", {"a.csv": b"PK\x03\x04\x14\x00\x06\x00"}
    ),
    BadInputCase("not UTF-8", SUMMARY, "a.csv", {"a.csv": b"time_s,T\xfc_degC\n0,20\n"}),
    BadInputCase(
        "semicolons and decimal commas",
        SUMMARY,
        "a.csv",
        {"a.csv": "time_s;T1_degC\n0;20,5\n60;20,6\n"},
    ),
    BadInputCase(
        "time is not first", SUMMARY, "time_s", {"a.csv": "T1_degC,time_s\n20,0\n21,60\n"}
    ),
    BadInputCase("a column without a unit", SUMMARY, "T1", {"a.csv": "time_s,T1\n0,20\n60,21\n"}),
    BadInputCase("an unknown unit", SUMMARY, "degF", {"a.csv": "time_s,T1_degF\n0,70\n60,71\n"}),
    BadInputCase(
        "a column twice", SUMMARY, "T1_degC", {"a.csv": "time_s,T1_degC,T1_degC\n0,1,2\n"}
    ),
    _run("time runs backwards", "row 4", cell(4, "time_s", "5")),
    _run("time stands still", "row 4", cell(4, "time_s", "120")),
    _run("a word among numbers", "row 5", cell(5, "T1_degC", "warm")),
    _run("an infinite temperature", "row 5", cell(5, "T1_degC", "inf")),
    _run("a temperature of 1,000 degC", "row 5", cell(5, "T1_degC", "1000")),
    _run("a temperature in kelvin", "row 3", cell(3, "T1_degC", "-293")),
    _run("a negative time", "row 2", cell(2, "time_s", "nan")),
    _run("a row too short", "row 3", lambda text: text.replace("\n120", "\n120,1\n130", 1)),
]

FITTING = [
    BadInputCase("a run given twice", FIT.replace("c.csv", "a.csv"), "same run"),
    BadInputCase("no displacement", FIT, "S1_um", changes={"a.csv": without_column("S1_um")}),
    _option("an unknown error model", FIT.replace("mlr", "magic"), "'magic' is not allowed"),
    _option("an unknown thermometer", f"{FIT} --points T1,T99", "'T99' is not allowed"),
    _option("an empty choice of points", f"{FIT} --points ,", "is not allowed"),
    _option("an unknown input form", f"{FIT} --input-form rises", "'rises' is not allowed"),
    _option("an option that the model lacks", f"{FIT} --option depth=3", "depth"),
    _option("an option without a value", f"{FIT} --option depth", "is not of the form NAME=VALUE"),
    _option("a tool that ends before it begins", f"{FIT} --tool-length 200 100", "200 100"),
    _option("a tool of a kilometre", f"{FIT} --tool-length 0 1000000", "is not allowed"),
    _option("a date that is none", f"{FIT} --created 2026-13-40", "2026-13-40"),
    _option("a name that is none", f"{FIT} --name 9lives", "9lives"),
    _option("no processes", f"{FIT} --jobs 0", "0 is not allowed"),
    _option("more than all of the drift", f"{FIT} --share 1.5", "1.5 is not allowed"),
    _option("a threshold of 2", f"{FIT} --lambda 2 --points grey", "2"),
    _option("an unknown score", f"{FIT} --points grey --score best", "best"),
    _option("an unknown geometry", f"{FIT} --form bent", "bent"),
    _option("an unknown machine", FIT.replace("jig_borer", "mill"), "mill"),
    _option("the output is an input", FIT.replace("new.json", "b.csv"), "is an input"),
    _option("the output is a measurement", FIT.replace("new.json", "d.csv"), "exists"),
    _option("the output's folder is missing", FIT.replace("new.json", "no/x.json"), "no"),
    _option("the output is a folder", FIT.replace("new.json", "."), "."),
    BadInputCase(
        "no thermometer in common",
        FIT.replace(" --machine jig_borer", ""),
        "is in all runs",
        changes={"a.csv": lambda text: text.replace("T", "U")},
    ),
]

COMPARING = [
    _option("nothing to judge on", "compare --train a.csv b.csv", "validate"),
    _option("nothing at all", "compare", "--"),
    _option(
        "an unknown model to compare",
        "compare --train a.csv b.csv --validate c.csv --models mlr,magic",
        "magic",
    ),
    _option("theta of 7", "points a.csv b.csv --theta 7", "7"),
    _option("an unknown target", "points a.csv b.csv --target stretch", "stretch"),
    _option("an unknown image", "points a.csv b.csv --image mirror", "mirror"),
    _option("minus one cluster", "points a.csv b.csv --clusters -1", "-1"),
]

COMPENSATORS = [
    BadInputCase("no such compensator", "monitor nowhere.json a.csv", "nowhere.json"),
    BadInputCase("a run in place of a compensator", "monitor a.csv b.csv", "a.csv"),
    BadInputCase(
        "half a compensator file", "monitor c.json a.csv", "c.json", {"c.json": '{"format": 3,'}
    ),
    _compensator("a newer format", "newer version", '"format": 3', '"format": 99'),
    _compensator("an older format", "older version", '"format": 3', '"format": 2'),
    _compensator("another kind of file", "kind", "spindle-drift compensator", "recipe"),
    _compensator("a number that is a word", "", '"offset_um": ', '"offset_um": "much", "x": '),
    _compensator("an unknown field", "colour", '"kind"', '"colour": "red", "kind"'),
    _compensator("a field twice", "twice", '"input_form"', '"input_form": "rise", "input_form"'),
    _compensator("NaN in a field", "NaN", '"slew_um_per_s": 1.0', '"slew_um_per_s": NaN'),
    _compensator("a sensor twice", "another sensor", '"name": "T2"', '"name": "T1"'),
    _compensator("a negative half width", "deviations", '"deviations": ', '"deviations": -'),
    BadInputCase(
        "a log without a thermometer",
        "monitor c.json a.csv",
        "T1_degC",
        changes={"a.csv": without_column("T1_degC")},
    ),
    BadInputCase("an update with an old run", "update c.json b.csv -o new.json", "already"),
    BadInputCase("an update over itself", "update c.json d.csv -o c.json", "is an input"),
    _option("a probe limit without a unit", "replay c.json d.csv --probe-when 3", "'3'"),
    _option("a probe limit in inches", "replay c.json d.csv --probe-when 3in", "'3in'"),
    _option("a probe without noise", "replay c.json d.csv --probe-noise 1um", "--probe-when"),
    _option("probes every minus one hour", "replay c.json d.csv --probe-every -1h", ""),
    _option("a seed of minus one", "replay c.json d.csv --probe-every 60min --seed -1", "-1"),
    _option("a tool length that is no number", "replay c.json d.csv --tool-length nan", "nan"),
]

MACHINES = [
    _option("an unknown shipped machine", "show-machine mill -o new.html", "mill"),
    BadInputCase(
        "a machine file that is no TOML",
        "show-machine x.toml -o n.html",
        "x.toml",
        {"x.toml": "a ="},
    ),
    _machine(
        "a negative heat capacity", "capacity", "capacity = { value = ", "capacity = { value = -"
    ),
    _machine("an unknown effect", "wobble", "[effects]", "[effects.wobble]\n[effects]"),
    _machine("a missing unit", "unit", 'unit = "', 'unity = "'),
    _machine("an unknown format", "format", "format = 1", "format = 77"),
    _page("a stretch that overlaps", "stretches", "{ from = 0, to = 230", "{ from = -50, to = 230"),
    _page("an unknown designation", "7999999", '"7014"', '"7999999"'),
    _page("an unknown material", "cheese", "[housing]", '[housing]\nmaterial = "cheese"'),
    _page("a bearing outside the shaft", "at", "at = 295  #", "at = 2950  #"),
    _page("a thermometer in the air", "at", "at = 115", "at = 9115"),
    _option(
        "a bearing of no series", "new-machine -o new.toml --bearing x --speed 9000 --power 1", "x"
    ),
    _option("a speed of zero", "new-machine -o n.toml --bearing 7014 --speed 0 --power 9", "speed"),
    _option(
        "a motor of minus 5 kW",
        "new-machine -o n.toml --bearing 7014 --speed 9000 --power -5",
        "power",
    ),
    _option("calibrating on nothing", "calibrate jig_borer nowhere.csv -o new.toml", "nowhere.csv"),
    _option("no starting point", "calibrate jig_borer a.csv -o new.toml --starts 0", "0"),
    _option("a gap from one run", "find-gap jig_borer --runs a.csv --out gap", "runs"),
    _option(
        "an unknown effect to leave out",
        "find-gap jig_borer --runs a.csv b.csv c.csv --out gap --without wobble",
        "wobble",
    ),
]

SCENARIOS = [
    _option("no such scenario", "run nowhere --fmu-dir {dist}", "nowhere"),
    _option("no such scenario to simulate", "simulate nowhere -o new.csv", "nowhere"),
    _scenario("an unknown kind of signal", "zigzag", '"first_order"', '"zigzag"'),
    _scenario(
        "a duration of minus an hour", "duration_s", "duration_s = 28800", "duration_s = -3600"
    ),
    _scenario(
        "an unknown field in a scenario", "colour", "format = 1", 'format = 1\ncolour = "red"'
    ),
    _scenario("a newer scenario", "format", "format = 1", "format = 99"),
    _scenario("a hall of 500 degC", "", "start = 20.5", "start = 500.0"),
    _option("samples every 0 s", "simulate stop_and_go -o new.csv --every 0", "--every"),
    _option("a setting that is none", "run stop_and_go --fmu-dir {dist} --set speed", "speed"),
    _option("an unknown setting", "run stop_and_go --fmu-dir {dist} --set colour=red", "colour"),
    _option(
        "a sweep of nothing", "sweep stop_and_go --fmu-dir {dist} --vary nothing=1,2", "nothing"
    ),
    _option("a sweep of no runs", "sweep stop_and_go --fmu-dir {dist} --repeat 0", "0"),
    _option(
        "no workers", "sweep stop_and_go --fmu-dir {dist} --vary tool_length=100 --workers 0", "0"
    ),
    _option("results over a measurement", "summary a.csv --out b.csv", "b.csv"),
]

BUS = [
    _option("an unknown bus", "gateway --fmu-dir {dist} --interface telepathy", "telepathy"),
    _option(
        "no such DBC file", "gateway --fmu-dir {dist} --frames --dbc nowhere.dbc", "nowhere.dbc"
    ),
    BadInputCase(
        "a DBC file that is none",
        "gateway --fmu-dir {dist} --frames --dbc x.dbc",
        "x.dbc",
        {"x.dbc": "hello"},
    ),
    _option(
        "a negative timeout",
        "gateway --fmu-dir {dist} --duration 1 --interface virtual --timeout -5",
        "-5",
    ),
    _option(
        "a speed-up of zero",
        "gateway --fmu-dir {dist} --duration 1 --interface virtual --speed-up 0",
        "0",
    ),
    _option(
        "an unknown log ending",
        "gateway --fmu-dir {dist} --duration 1 --interface virtual --log x.doc",
        "x.doc",
    ),
]

COMMAND_LINE = [
    _option("no such command", "compensate", "compensate"),
    _option("no such option", "summary a.csv --fast", "--fast"),
    _option("a value that is missing", "fit a.csv -o", "-o"),
    _option("a word for a number", "simulate stop_and_go -o new.csv --seed many", "many"),
]

IMPORTS = [
    BadInputCase("nothing to import", "import nowhere.xlsx -o runs", "nowhere.xlsx"),
    BadInputCase("a picture", "import x.png -o runs", "x.png", {"x.png": b"\x89PNG\r\n\x1a\n\x00"}),
    BadInputCase("a log of words", "import x.csv -o runs", "x.csv", {"x.csv": "a,b\nc,d\ne,f\n"}),
    BadInputCase(
        "a date that two countries read apart",
        "import x.csv -o runs",
        "--day-first",
        {"x.csv": "Date,T [degC]\n03/04/2026 10:00,20\n03/04/2026 10:01,21\n"},
    ),
    BadInputCase(
        "a unit for a column that is not there",
        "import x.csv -o runs --unit Q=degC",
        "Q",
        {"x.csv": "time [s],T [degC]\n0,20\n60,21\n"},
    ),
]

GROUPS = {
    "Run files": RUN_FILES,
    "Fitting": FITTING,
    "Comparing, choosing points": COMPARING,
    "Compensators": COMPENSATORS,
    "Machines and gaps": MACHINES,
    "Scenarios": SCENARIOS,
    "The bus": BUS,
    "Importing": IMPORTS,
    "The command line": COMMAND_LINE,
}
