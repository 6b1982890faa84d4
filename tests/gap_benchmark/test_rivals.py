"""Other methods on the same questions: each finds what it can find, and is asked alike."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.gap import rivals, run
from benchmarks.gap.contest import FINDER, contest
from benchmarks.gap.plan import plan
from benchmarks.gap.records import read_records
from benchmarks.gap.rivals import forward_bic, gaussian_process, sindy
from benchmarks.gap.table import read_rivals
from gap_finder.observations import observe
from gap_finder.regimes import gap_of, residuals
from plant_model.effects import catalogue
from plant_model.machine_file import read_machine
from tests.gap_benchmark.made_up import Folder, added, answer, hidden
from tests.gap_finder.conftest import runs_of

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def question() -> Any:
    """Three runs and a fourth of a machine whose motor heats more than its model's."""
    machine = read_machine("jig_borer_lumps")
    loss = "sources.motor.loss"
    runs = runs_of(machine.with_values({loss: machine.parameters[loss].high}))
    observed = observe(machine, runs)
    left = [residuals(machine, one) for one in observed[3:]]
    return SimpleNamespace(
        machine=machine, observed=observed[:3], unseen=observed[3:], left=left, without=()
    )


def regression(
    columns: Array, residual: Array, keys: Sequence[str], samples: int | None = None
) -> forward_bic.Problem:
    return forward_bic.Problem(
        columns.T @ columns,
        columns.T @ residual,
        float(residual @ residual),
        samples or len(residual),
        list(keys),
    )


def test_bic_adds_what_is_there_in_order_and_stops() -> None:
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((400, 6))
    # A signature is what the model would change, so the residual is its opposite.
    residual = -(2.0 * columns[:, 3] + 0.8 * columns[:, 1]) + 0.1 * rng.standard_normal(400)
    found, falls = forward_bic.selected(regression(columns, residual, "abcdef"), np.ones(6))
    assert found == [3, 1]
    assert min(falls) > 0.0


def test_bic_minds_the_sign_and_takes_an_effect_once() -> None:
    rng = np.random.default_rng(2)
    columns = rng.standard_normal((400, 3))
    residual = -2.0 * columns[:, 0] - columns[:, 1] + columns[:, 2]
    residual += 0.1 * rng.standard_normal(400)
    two_sizes = regression(columns, residual, ["windage", "windage", "radiation"])
    assert forward_bic.selected(two_sizes, np.ones(3))[0] == [0]
    three = regression(columns, residual, ["windage", "copper_loss", "radiation"])
    assert forward_bic.selected(three, np.ones(3))[0] == [0, 1]


def test_bic_is_silent_on_noise_and_pays_for_numbers() -> None:
    rng = np.random.default_rng(3)
    columns = rng.standard_normal((400, 3))
    noise = rng.standard_normal(400)
    assert forward_bic.selected(regression(columns, noise, "abc"), np.ones(3))[0] == []
    faint = noise - 0.25 * columns[:, 0]
    assert forward_bic.selected(regression(columns, faint, "abc"), np.ones(3))[0] == [0]
    assert forward_bic.selected(regression(columns, faint, "abc"), np.full(3, 9.0))[0] == []


def test_sindy_identifies_an_equation_and_its_terms() -> None:
    rng = np.random.default_rng(4)
    drives = [np.repeat(rng.standard_normal((12, 3)), 30, axis=0) for _ in range(3)]
    true = np.array([[-2.0, 0.0, 1.5, 0.0], [-0.7, 0.0, 0.0, -1.0]])
    states = [sindy.simulated(true, drive) for drive in drives]
    found = sindy.identified(states, drives, sindy.Choice(0.3, 1e-6), bags=10)
    assert np.array_equal(found != 0.0, true != 0.0)
    np.testing.assert_allclose(found, true, rtol=0.1, atol=0.0)


def test_sindy_simulates_a_step_exactly_and_holds_what_runs_away() -> None:
    drive = np.ones((121, 1))
    stepped = sindy.simulated(np.array([[-1.0, 2.0]]), drive)[:, 0]
    hours = np.arange(121) * sindy.BIN_S / 3600.0
    np.testing.assert_allclose(stepped, 2.0 * (1.0 - np.exp(-hours)), atol=1e-9)
    ramp = sindy.simulated(np.array([[0.0, 2.0]]), drive)[:, 0]
    np.testing.assert_allclose(ramp, 2.0 * hours, atol=1e-9)
    assert np.abs(sindy.simulated(np.array([[50.0, 2.0]]), drive)).max() == 100.0


def test_sindys_terms_are_effects_of_the_catalogue(question: Any) -> None:
    terms = sindy.heat_terms(question.machine, question.observed[0])
    assert set(terms) <= set(catalogue())
    for name, term in terms.items():
        assert term.shape == question.observed[0].time_s.shape, name
        assert np.isfinite(term).all(), name
    # No torque was measured in these runs.
    assert not terms["copper_loss"].any()
    assert terms["windage"].max() == pytest.approx((12.0 / 20.0) ** 3)


def test_a_gaussian_process_shrinks_the_gap_and_names_nothing(question: Any) -> None:
    told = gaussian_process.answer(question)
    assert told.named == []
    before = gap_of(question.machine, question.left)
    assert gap_of(question.machine, told.left or []) < 0.7 * before


def test_what_a_rival_says_has_the_gap_finders_form(
    question: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rivals, "Question", lambda folder, without: question)
    told = rivals.ask_rivals(Path(), names=["no_action", "sindy"])
    idle = told["no_action"]["answer"]
    assert idle["verdict"] == "none_missing"
    assert idle["gap"]["holdout"]["before"] == idle["gap"]["holdout"]["after"] > 1.0
    assert told["sindy"]["seconds"]["cpu"] > 0.0
    assert {"forward_bic", "gaussian_process", "no_action", "sindy"} <= set(rivals.rivals())
    assert all(one.TITLE and one.answer for one in rivals.rivals().values())


def test_rivals_are_asked_once_and_stand_beside_the_gap_finder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def ask_rivals(folder: Path, without: Sequence[str], names: Sequence[str]) -> dict[str, Any]:
        asked.append((folder.name, list(names)))
        told = {"method": "Other", "seconds": {"cpu": 1.0}, "answer": answer(added("windage"))}
        return dict.fromkeys(names, told)

    seconds = {"cpu": 2.0, "wall": 2.0}
    monkeypatch.setattr(rivals, "ask_rivals", ask_rivals)
    monkeypatch.setattr(run, "ask", lambda *_: {"seconds": seconds, "answer": answer()})
    arguments = ["--split", "development", "--cases", "1", "--kind", "none", "--workers", "1"]
    arguments += ["--out", str(tmp_path), "--rivals"]
    assert run.main(arguments) == 0
    (none,) = plan("development", 1, kind="none")
    (tmp_path / "rivals" / "sindy" / f"{none.name}.json").unlink()
    assert run.main(arguments) == 0
    assert asked == [(none.files, list(rivals.rivals())), (none.files, ["sindy"])]
    record = json.loads((tmp_path / "rivals" / "sindy" / f"{none.name}.json").read_text())
    assert record["kind"] == "none"
    table = contest({FINDER: read_records(tmp_path / "records")} | read_rivals(tmp_path))
    rows = {row.split(" | ")[0]: row for row in table.splitlines()}
    assert "| 0 of 1 (0 %) |" in rows["| Gap finder"]
    assert "| 1 of 1 (100 %) |" in rows["| Other"]


def test_methods_are_compared_where_all_were_asked(tmp_path: Path) -> None:
    ours, theirs = Folder(tmp_path / "records"), Folder(tmp_path / "rivals" / "other")
    truth = [hidden("windage")]
    windage, radiation = added("windage"), added("radiation")
    ours.put("effect", truth, answer(windage, one_of=("windage",), gap=(8.0, 3.0)), empty=2.0)
    ours.put("effect", truth, answer(gap=(8.0, 8.0)), empty=2.0)
    theirs.put("effect", truth, answer(radiation, windage, gap=(8.0, 5.0)))
    found = {FINDER: read_records(tmp_path / "records")} | read_rivals(tmp_path)
    head, *_, finder, other = contest(found).splitlines()
    assert head.startswith("1 questions")
    cells = [cell.strip() for cell in finder.strip("| ").split("|")]
    assert cells[3:6] == ["1 of 1 (100 %)", "0 of 1 (0 %)", "1 of 1 (100 %)"]
    assert cells[6:10] == ["1.0", "8.00", "3.00", "83 %"]
    cells = [cell.strip() for cell in other.strip("| ").split("|")]
    assert cells[3:6] == ["0 of 1 (0 %)", "1 of 1 (100 %)", "0 of 1 (0 %)"]
    assert cells[6:10] == ["2.0", "8.00", "5.00", "50 %"]
    assert contest({FINDER: found[FINDER]}) == "No other method was asked."
