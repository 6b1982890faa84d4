"""``spindle-drift compare`` and ``spindle-drift points``."""

import json

import numpy as np
import pytest

from fmu_compensator.fit.error_models.gaussian import NoMean
from measurement.runs import Run
from scenarios.cli import main
from tests.fmu_compensator.conftest import make_run
from tests.scenarios.conftest import written


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    made = [make_run(name, seed, hours=1.5) for seed, name in enumerate("abcd")]
    return written(tmp_path_factory.mktemp("runs"), *made)


@pytest.mark.usefixtures("drawn")
def test_compare_prints_a_ranking_and_writes_page_and_figures(runs, tmp_path, capsys):
    out = tmp_path / "compared"
    code = main(
        ["compare", "--train", *runs[:3], "--validate", runs[3], "--models", "mlr,bp,arx",
         "--option", "bp.iterations=5", "--out", str(out)]
    )  # fmt: skip
    assert code == 0
    text = capsys.readouterr().out
    assert "What is wrong with the data" in text
    given = text[text.index("What the models were given") :].splitlines()
    assert given[1] == "  all rows of every run; no column was left out"
    ranked = [line.split()[0] for line in text.splitlines() if line[:2].strip().isdigit()]
    assert ranked == ["1", "2", "3"]
    assert "Persistence (last measured), one step ahead" in text
    assert f"`fit` installs {NoMean.title}, wherever it ranks, unless --model" in text
    names = {path.name for path in out.iterdir()}
    assert names == {
        "comparison.json", "report.html", "ranking.png", "unseen_1.png", "convergence.png",
        "table.json",
    }  # fmt: skip
    page = (out / "report.html").read_text()
    assert "Multiple linear regression" in page
    assert 'id="chart-unseen_1"' in page
    assert 'id="chart-convergence"' in page
    assert "http://" not in page.split("</script>")[-1]
    table = json.loads((out / "comparison.json").read_text())
    assert table["models"][0]["score"] < 0.1


def test_runs_can_be_left_out_in_turn(runs, prints):
    table = json.loads(prints(["compare", "--runs", *runs, "--models", "mlr", "--json"]))
    row = next(row for row in table["models"] if row["name"] == "mlr")
    assert [one["run"] for one in row["validate"]["per_run"]] == list("abcd")
    assert row["interval"]["coverage_wanted"] == 0.9


def test_a_run_too_short_to_learn_from_is_left_out_and_told(runs, tmp_path, prints):
    brief = written(tmp_path, Run("brief", make_run("brief", 9).frame.head(2)))
    asked = ["--validate", runs[3], "--models", "mlr", "--train", *runs[:2]]
    shown = prints(["compare", *asked, *brief])
    assert "left out, since they are shorter than 900 s, the model's shortest lag: brief" in shown
    assert prints(["compare", *asked]).splitlines()[0] in shown


@pytest.mark.parametrize("by", ["--runs {} {} {} {}", "--train {} {} {} --validate {}"])
def test_one_run_without_speed_keeps_every_model_from_using_it(runs, tmp_path, prints, by):
    still = make_run("still", 9, hours=1.5).frame.drop(columns="speed_rpm")
    given = by.format(*runs[:3], *written(tmp_path, Run("still", still))).split()
    text = prints(["compare", *given, "--models", "gaussian,thermal_states,ne"])
    assert text.count("the spindle speed is not used: none in still") == 1
    assert "speed_rpm: is not known in every run: ne needs it" in text
    blind = [Run(name, make_run(name, seed, hours=1.5).frame.drop(columns="speed_rpm"))
             for seed, name in enumerate("abc")]  # fmt: skip
    again = by.format(*written(tmp_path, *blind), tmp_path / "still.csv").split()
    ranked = prints(["compare", *again, "--models", "gaussian,thermal_states,ne"])
    assert ranked[ranked.index("rank") :] == text[text.index("rank") :]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--train", "A", "--validate", "A"], "is the same run as a in --train"),
        (["--train", "A", "--validate", "B", "--seed", "-1"], "seed: -1 is not allowed"),
        (
            ["--train", "A", "--validate", "C"],
            "judged runs: blind: S1_um is broken or missing in almost every row",
        ),
    ],
)
def test_a_refusal_is_one_line_and_writes_nothing(runs, tmp_path, capsys, arguments, told):
    blind = make_run("blind", 9, hours=1.5)
    (blind,) = written(tmp_path, Run("blind", blind.frame.assign(S1_um=np.nan)))
    files = {"A": runs[0], "B": runs[1], "C": blind}
    out = tmp_path / "out"
    code = main(["compare", *(files.get(word, word) for word in arguments), "--out", str(out)])
    assert code == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert len(captured.err.strip().splitlines()) == 1
    assert captured.out == ""
    assert not out.exists()


@pytest.mark.usefixtures("drawn")
def test_points_prints_degrees_and_groups_and_draws(runs, tmp_path, prints):
    out = tmp_path / "points"
    text = prints(["points", *runs, "--clusters", "2", "--out", str(out)])
    assert "grey comprehensive degree, lambda 0.9: 2 groups\n  T1 T2; T4" in text
    assert "fuzzy c-means: 2 groups" in text
    assert {path.name for path in out.iterdir()} == {
        "points.json", "dendrogram.png", "heat_map.png", "loops.png", "table.json"
    }  # fmt: skip
    assert (out / "heat_map.png").read_bytes().startswith(b"\x89PNG")
    table = json.loads((out / "points.json").read_text())
    assert table["degree"][0][0] == 1.0
    assert len(table["subsets"]) == 3


def test_fit_takes_options_of_the_model(runs, tmp_path, refused):
    out = tmp_path / "c.json"
    arguments = ["fit", *runs[:2], "--model", "bp", "-o", str(out)]
    assert main([*arguments, "--option", "hidden=[3]", "--option", "iterations=4"]) == 0
    layers = json.loads(out.read_text())["error_model"]["layers"]
    assert len(layers[0]["biases"]) == 3
    for wrong, told in (
        ("hidden", "is not of the form NAME=VALUE"),
        ("rig=1", "must be NAME=VALUE"),
    ):
        assert told in refused([*arguments, "--option", wrong])
