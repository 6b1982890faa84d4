"""What a function of the API does not take is refused in one line that names the parameter."""

import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest

import spindle_drift as sd
from fmu_compensator.fit.fitting import fit_compensator
from fmu_compensator.fit.survey import survey
from spindle_drift._inputs import RunLike
from spindle_drift._refusals import _is, parameter_types


def callables() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Yield every function and public method of the package, and the making of a machine."""
    for name in sd.__all__:
        thing = getattr(sd, name)
        if not thing.__module__.startswith("spindle_drift"):
            continue
        if inspect.isfunction(thing):
            yield name, thing
        for member, function in inspect.getmembers(thing, inspect.isroutine):
            if member in vars(thing) and not member.startswith("_"):
                yield f"{name}.{member}", function
    yield "Machine", sd.Machine.__init__


@pytest.mark.parametrize(
    ("name", "function"), [pytest.param(*one, id=one[0]) for one in callables()]
)
def test_every_parameter_refuses_what_it_does_not_take(name, function):
    for parameter, kind in parameter_types(inspect.unwrap(function)).items():
        if kind is Any:
            continue
        line = rf"{re.escape(name)}: {parameter}: <object .*> is not allowed: .* is needed"
        with pytest.raises(sd.BadInput, match=f"^{line}$"):
            function(**{parameter: object()})


def options_passed_on() -> Iterator[tuple[str, str, Callable[..., Any]]]:
    """Yield each option that `fit` and `points` pass on, and the call that gives it."""
    run = pd.DataFrame({"time_s": [0.0, 60.0]})
    for name in options_of(fit_compensator):
        yield "fit", name, lambda value, name=name: sd.fit(run, "mlr", **{name: value})
    for name in options_of(survey):
        yield "points", name, lambda value, name=name: sd.points(run, **{name: value})
        yield "fit, grey", name, lambda value, name=name: sd.fit(run, grey={name: value})


def options_of(function: Callable[..., Any]) -> list[str]:
    parameters = inspect.signature(function).parameters.values()
    return [entry.name for entry in parameters if entry.kind is entry.KEYWORD_ONLY]


@pytest.mark.parametrize(
    ("name", "option", "call"),
    [pytest.param(*one, id=f"{one[0]}-{one[1]}") for one in options_passed_on()],
)
def test_every_option_that_is_passed_on_refuses_what_it_does_not_take(name, option, call):
    with pytest.raises(sd.BadInput, match=f"^{name}: {option}: <object .*> is not allowed: .*"):
        call(object())


def test_options_that_nothing_has_are_refused_with_those_that_there_are():
    run = pd.DataFrame({"time_s": [0.0, 60.0]})
    with pytest.raises(sd.BadInput, match=r"^fit, grey: foo: is not a known option: threshold, "):
        sd.fit(run, grey={"foo": 1})
    with pytest.raises(sd.BadInput, match=r"^compare, grey: foo: is not a known option: "):
        sd.compare([run], grey={"foo": 1})


def test_a_method_that_lacks_an_argument_is_told_so_by_its_name():
    with pytest.raises(TypeError, match=r"fit\(\) missing 1 required"):
        sd.fit()


@pytest.mark.parametrize(
    ("value", "kind", "is_taken"),
    [
        (np.int64(3), int, True),
        (np.float32(3.0), float, True),
        (3, float, True),
        (True, float, False),
        (3.0, int, False),
        (Path("x"), str | Path, True),
        ("ab", Sequence[str], False),
        (("a", "b"), Sequence[str], True),
        (["a", 3], Sequence[str], False),
        (iter(["a"]), Sequence[str], True),
        ({"a": 1}, Mapping[str, int], True),
        ([pd.DataFrame(), "run.csv"], Sequence[RunLike], True),
        (3, Literal[2, 3], True),
        (None, int | None, True),
        (None, int, False),
    ],
)
def test_what_is_taken_for_a_type(value, kind, is_taken):
    assert _is(value, kind) == is_taken
