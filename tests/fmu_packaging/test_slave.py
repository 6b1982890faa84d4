"""The slave through the binary, each test in a fresh process."""

import json
from collections.abc import Callable

from tests.fmu_packaging.apart import apart

Fmu = Callable[..., str]


def test_values_of_every_type_pass(tiny_fmu, plain_path):
    found = apart(
        """
fmu = opened(*sys.argv[1:])
r = fmu.refs
fmu.enterInitializationMode()
fmu.setInteger([r["count"]], [7]); fmu.setBoolean([r["flag"]], [True])
fmu.setString([r["word"]], ["héllo"]); fmu.setReal([r["u"], r["gain"]], [3.0, 2.0])
at_start = [fmu.getInteger([r["count_out"]]), fmu.getBoolean([r["flag_out"]])]
fmu.exitInitializationMode()
fmu.setReal([r["u"]], [4.0]); fmu.setInteger([r["count"]], [8])
fmu.doStep(0.0, 0.5); fmu.doStep(0.5, 0.25)
show([at_start, fmu.getReal([r["total"], r["u"], r["gain"]]), fmu.getInteger([r["count_out"]]),
      [s.decode() for s in fmu.getString([r["word_out"], r["word"], r["mode"]])], messages])
""",
        tiny_fmu(10.0),
        plain_path / "a folder with spaces",
    )
    assert found == [[[7], [True]], [60.0, 4.0, 2.0], [8], ["héllo 2", "héllo", ""], []]


def test_unknown_references_are_refused_and_the_host_lives(tiny_fmu):
    """Many refusals: a reference lost by the binary each time would end the process."""
    found = apart(
        """
fmu = started(opened(sys.argv[1]), u=2.0)
r = fmu.refs
calls = [(fmu.getReal, [99]), (fmu.getReal, [r["count_out"]]), (fmu.getInteger, [r["total"]]),
         (fmu.getString, [4294967295]), (fmu.setReal, [99], [1.0]),
         (fmu.setReal, [r["u"], r["total"]], [5.0, 1.0]), (fmu.setReal, [r["gain"]], [1.0]),
         (fmu.setInteger, [r["u"]], [1]), (fmu.setString, [r["mode"]], ["x"])]
statuses = {status_of(*call) for _ in range(200) for call in calls}
said = [m[1].splitlines()[-1] for m in messages[:len(calls)]]
fmu.setReal([r["u"]], [2.0])
fmu.doStep(0.0, 1.0)
total = fmu.getReal([r["total"]])
fmu.freeInstance()
import gc; gc.collect()
show([sorted(statuses), total, said])
""",
        tiny_fmu(),
    )
    assert found[:2] == [[4], [2.0]]
    assert found[2] == [
        "value reference 99 cannot be read: it is no real variable",
        "value reference 5 cannot be read: it is no real variable",
        "value reference 4 cannot be read: it is no integer variable",
        "value reference -1 cannot be read: it is no string variable",
        "value reference 99 cannot be set: it is no real variable",
        "total cannot be set: it is an output",
        "gain cannot be set after the start",
        "value reference 0 cannot be set: it is no integer variable",
        "mode cannot be set after the start",
    ]


def test_a_failed_step_is_logged_with_its_traceback(tiny_fmu):
    found = apart(
        """
fmu = opened(sys.argv[1])
fmu.setReal([fmu.refs["fail_after"]], [1.0])
started(fmu, u=1.0)
statuses = [status_of(fmu.doStep, t, 1.0) for t in (0.0, 1.0, 2.0)]
statuses.append(status_of(fmu.doStep, 0.0, 0.0))
show([statuses, messages])
""",
        tiny_fmu(),
    )
    assert found[0] == [0, 2, 2, 2]
    status, text = found[1][0]
    assert status == 3
    assert "Traceback" in text
    assert "tiny_slave.py" in text
    assert text.endswith("RuntimeError: broke at 100% of 1")
    assert found[1][-1] == [
        3,
        "the step at 0 s failed: a step of 0 s: it must be above 0 and finite",
    ]


def test_bad_parameters_stop_the_initialisation(tiny_fmu):
    wrong = {
        ("refuse", 1.0): "mode: 'refuse' is not allowed: 100% of tries fail",
        ("crash", 1.0): "ZeroDivisionError: a mistake in the code",
        ("", 5.5): "gain: 5.5 is not allowed: it must be 0 to 5",
        ("", float("nan")): "gain: nan is not allowed: it must be 0 to 5",
    }
    found = apart(
        """
fmu = opened(sys.argv[1])
def set_up(mode, gain):
    fmu.setString([fmu.refs["mode"]], [mode])
    fmu.setReal([fmu.refs["gain"]], [gain])
    fmu.enterInitializationMode()
    return status_of(fmu.exitInitializationMode)
shown = []
for mode, gain in json.loads(sys.argv[2]):
    first, said = set_up(mode, gain), messages[-1][1]
    after = status_of(fmu.doStep, 0.0, 1.0)
    fmu.reset()
    shown.append([first, said, after, set_up("", 1.0)])
    fmu.reset()
show(shown)
""",
        tiny_fmu(),
        json.dumps(list(wrong)),
    )
    for (first, said, *rest), cause in zip(found, wrong.values(), strict=True):
        assert first > 2
        assert said.splitlines()[-1] == cause
        assert rest == [2, 0]


STATE = """
def steps(fmu, first, count):
    rows = []
    for k in range(first, first + count):
        fmu.setReal([fmu.refs["u"]], [0.1 * k + 1 / 3])
        fmu.doStep(float(k), 1.0)
        rows.append([fmu.getReal(fmu.outs), fmu.getString([fmu.refs["word_out"]])[0].decode()])
    return rows
"""


def test_a_state_continues_bit_for_bit_and_a_reset_starts_over(tiny_fmu, plain_path):
    found = apart(
        STATE
        + """
import shutil
folder = sys.argv[2]
fmu = started(opened(sys.argv[1], folder), gain=1.7)
first = steps(fmu, 0, 5)
state = fmu.getFMUstate()
data = fmu.serializeFMUstate(state)
truth = steps(fmu, 5, 20)
fmu.setFMUstate(state)
kept = steps(fmu, 5, 20)
other = opened(sys.argv[1])
other.setFMUstate(other.deSerializeFMUstate(data))
elsewhere = steps(other, 5, 20)
shutil.rmtree(folder)  # a reset reads no files
fmu.reset()
started(fmu, gain=1.7)
anew = steps(fmu, 0, 5)
fmu.setFMUstate(fmu.deSerializeFMUstate(data))
after_reset = steps(fmu, 5, 20)
fmu.freeFMUstate(state)
show([kept == truth, elsewhere == truth, after_reset == truth, len(truth), truth[-1] != truth[0],
      data == other.serializeFMUstate(other.deSerializeFMUstate(data)), anew == first, messages])
""",
        tiny_fmu(),
        plain_path / "unpacked",
    )
    assert found == [True, True, True, 20, True, True, True, []]


def test_a_damaged_or_foreign_state_is_refused(tiny_fmu):
    found = apart(
        STATE
        + """
fmu = started(opened(sys.argv[1]))
before = steps(fmu, 0, 3)
data = bytearray(fmu.serializeFMUstate(fmu.getFMUstate()))
other = started(opened(sys.argv[2]))
foreign = other.serializeFMUstate(other.getFMUstate())
data[len(data) // 2] ^= 1
statuses = []
for bad in (bytes(data), foreign, b"", b"{}"):
    statuses.append(status_of(fmu.setFMUstate, fmu.deSerializeFMUstate(bad)))
said = [m[1].splitlines()[-1] for m in messages]
after = fmu.getReal(fmu.outs)
fmu.freeInstance()
show([statuses, said, after == before[-1][0]])
""",
        tiny_fmu(1.0),
        tiny_fmu(2.0),
    )
    assert all(status > 2 for status in found[0])
    assert "damaged" in found[1][0]
    assert "it belongs to drift_tiny_" in found[1][1]
    assert found[2]


def test_two_builds_in_one_process_keep_apart(tiny_fmu):
    found = apart(
        """
fmus = [started(opened(path), u=2.0) for path in sys.argv[1:]]
for fmu in fmus: fmu.doStep(0.0, 1.0)
show([fmu.getReal(fmu.outs)[0] for fmu in fmus])
""",
        tiny_fmu(1.0),
        tiny_fmu(5.0),
    )
    assert found == [2.0, 10.0]


def test_many_instances_in_one_process(tiny_fmu):
    """The binary loses a reference to the script's globals with every instance."""
    found = apart(
        """
import gc
folder = fmpy.extract(sys.argv[1])
totals = set()
kept = []
for k in range(200):
    fmu = started(opened(sys.argv[1], folder), u=2.0)
    fmu.doStep(0.0, 1.0)
    totals.add(fmu.getReal(fmu.outs)[0])
    if k % 2:
        fmu.freeInstance()
    else:
        kept.append(fmu)
    gc.collect() if k % 20 == 0 else None
show([sorted(totals), messages])
""",
        tiny_fmu(),
    )
    assert found == [[2.0], []]


def test_the_host_keeps_its_own_pythonfmu(tiny_fmu):
    """An FMU's folder comes first on the host's path; what the host imports later is its own."""
    found = apart(
        """
started(opened(sys.argv[1]))
import pythonfmu
from pythonfmu.builder import FmuBuilder
show([FmuBuilder.has_binary(), "site-packages" in pythonfmu.__file__])
""",
        tiny_fmu(),
    )
    assert found == [True, True]


LIFE = """
from math import inf, nan
import ctypes
fmu = opened(sys.argv[1])
single = ctypes.c_float
reals = [r for r in fmu.ins if r != fmu.outs[0]][:1]
said = {"exit before enter": status_of(fmu.exitInitializationMode),
        "terminate before the start": status_of(fmu.terminate)}
started(fmu)
said["a second initialisation"] = status_of(fmu.enterInitializationMode)
said["another experiment"] = status_of(fmu.setupExperiment, None, 5.0)
for time in (nan, inf, -inf):
    said[f"a clock of {time}"] = status_of(fmu.doStep, time, 1.0)
before = fmu.getReal(reals)
said["an input and an output"] = status_of(fmu.setReal, [*reals, fmu.outs[0]], [7.0, 1.0])
kept = fmu.getReal(reals) == before
step = single(0.1).value
said["single precision"] = max(status_of(fmu.doStep, single(0.1 * k).value, step)
                               for k in range(5000))
fmu.terminate()
said["an input after the end"] = status_of(fmu.setReal, reals, [1.0])
show([sorted(what for what, status in said.items() if status == 0), kept])
"""


def test_a_host_that_keeps_no_order_is_refused(tiny_fmu):
    assert apart(LIFE, tiny_fmu()) == [["single precision"], True]
