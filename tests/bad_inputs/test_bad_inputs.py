"""Bad input gets one clear line and exit code 2, and nothing of the user's is lost."""

import pytest

from benchmarks.bad_inputs.case import GROUPS, Answer, BadInputCase
from benchmarks.bad_inputs.run import answers, good_files, tables


@pytest.fixture(scope="module")
def good() -> dict[str, bytes]:
    return good_files()


def test_there_are_a_hundred():
    cases = [case for group in GROUPS.values() for case in group]
    assert len(cases) >= 100
    assert len({case.title for case in cases}) == len(cases)


@pytest.mark.long
@pytest.mark.parametrize("name", GROUPS)
def test_each_gets_one_line_and_loses_nothing(name, good, shipped):
    found = answers(GROUPS[name], good, shipped)
    assert [answer.problem for answer in found if answer.problem] == []


def test_a_broken_promise_would_be_seen():
    case = BadInputCase("x", "summary a.csv", "a.csv")
    assert Answer(case, 2, "error: a.csv: bad\n", [], []).problem == ""
    for answer in (
        Answer(case, 0, "error: a.csv: bad\n", [], []),
        Answer(case, 2, "error: bad\n", [], []),
        Answer(case, 2, "Traceback\nerror: a.csv: bad\n", [], []),
        Answer(case, 2, "error: a.csv: bad\n", ["b.csv"], []),
        Answer(case, 2, "error: a.csv: bad\n", [], ["half.json"]),
    ):
        assert answer.problem
        assert "not kept" in tables({"group": [answer]})
