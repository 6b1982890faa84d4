"""BP, GA-BP, their training, and the genetic algorithm."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import least_squares

from measurement.errors import BadInput
from studies.fit.bp import BackPropagation, Samples
from studies.fit.ga_bp import GeneticBackPropagation
from studies.fit.genetic import GeneticSettings, evolve
from studies.fit.network_training import Shape, levenberg_marquardt, nguyen_widrow
from tests.fmu_compensator.models.made import run_of, task_of
from tests.refusing import refusal


def bent_task(seed: int = 0, rows: int = 240):
    """Four temperatures, three errors that bend: no linear map can follow them."""
    random = np.random.default_rng(seed)
    x = np.cumsum(random.standard_normal((rows, 4)), axis=0) / 5.0
    y = np.column_stack([x[:, 0] * x[:, 1], np.tanh(x[:, 2]), x[:, 3] ** 2 + x[:, 0]])
    return task_of([run_of(x, y)])


@pytest.mark.parametrize("nodes", [(4, 10, 3), (2, 3, 4, 1), (1, 2, 2)])
def test_the_jacobian_equals_finite_differences(nodes):
    shape, random = Shape(nodes), np.random.default_rng(1)
    theta, x = random.standard_normal(shape.size), random.standard_normal((5, nodes[0]))
    outputs, slopes = shape.jacobian(theta, x)
    assert outputs == pytest.approx(shape.outputs(theta, x))
    for k in range(shape.size):
        step = np.zeros(shape.size)
        step[k] = 1e-6
        numeric = (shape.outputs(theta + step, x) - shape.outputs(theta - step, x)) / 2e-6
        assert slopes[:, :, k] == pytest.approx(numeric, abs=1e-7)


@pytest.mark.parametrize(("decay", "seed"), [(0.0, 0), (0.0, 1), (1e-3, 0), (1e-3, 1)])
def test_from_where_the_training_ends_scipy_gains_nothing(decay, seed):
    shape = Shape((1, 4, 1))
    x = np.linspace(-1.0, 1.0, 80)[:, None]
    y = np.sin(4.0 * x) + 0.3 * x
    root = np.sqrt(1.0 / 80.0)
    start = nguyen_widrow(shape, np.random.default_rng(seed))
    ours = levenberg_marquardt(
        shape, start, x, y, np.full(80, 1.0 / 80.0), iterations=2000, goal=0.0, decay=decay
    )

    def residuals(theta: np.ndarray) -> np.ndarray:
        missed = root * (shape.outputs(theta, x) - y).ravel()
        return np.concatenate([missed, np.sqrt(decay / shape.size) * theta])

    begun, ended = (float(np.sum(residuals(at) ** 2)) for at in (start, ours.theta))
    further = 2.0 * least_squares(residuals, ours.theta, method="lm").cost
    assert ended < 0.5 * begun
    assert further == pytest.approx(ended, rel=1e-3)


def test_bp_bends_where_a_line_cannot():
    task = bent_task()
    fitted = BackPropagation.fit(task, decay=1e-4, rows=0)  # no row is thinned out
    missed = task.runs[0].targets - fitted.predict(task.runs[0])
    spread = task.runs[0].targets.std(axis=0)
    assert (missed.std(axis=0) < 0.1 * spread).all()
    assert fitted.report()["nodes"] == [4, 10, 3]


def test_ga_bp_4_10_3_trains_from_a_better_start():
    task = bent_task(rows=1000)
    genetic = GeneticBackPropagation.fit(task, hidden=10, iterations=60)
    plain = BackPropagation.fit(task, iterations=60)
    report = genetic.report()
    assert report["nodes"] == [4, 10, 3]
    best = report["fitness_by_generation"]
    assert len(best) == 101
    assert all(b >= a for a, b in pairwise(best))
    assert genetic.training.curve[0] < plain.training.curve[0]


def test_the_genetic_algorithm_chooses_the_number_of_nodes():
    fitted = GeneticBackPropagation.fit(
        bent_task(), population=10, generations=3, iterations=3, seed=4
    )
    tried = {int(n): f for n, f in fitted.report()["hidden_nodes_tried"].items()}
    assert min(tried) >= 3
    assert max(tried) <= 15
    assert fitted.report()["nodes"][1] == max(tried, key=lambda n: tried[n])


def test_rows_are_thinned_as_asked():
    task = bent_task(rows=1000)
    assert [len(Samples.of(task, rows).x) for rows in (0, 100, 800)] == [1000, 100, 500]


def test_data_left_out_choose_fewer_nodes_than_the_error_in_training():
    # A straight line with noise: more nodes fit it better and predict it worse.
    random = np.random.default_rng(3)
    x = np.cumsum(random.standard_normal((160, 2)), axis=0)
    y = (x @ np.array([1.0, -2.0]))[:, None] + 3.0 * random.standard_normal((160, 1))
    task = task_of([run_of(x, y)])
    quick = {"population": 10, "generations": 3, "iterations": 3, "decay": 0.0}
    sizes = {
        judge: [
            GeneticBackPropagation.fit(task, nodes_by=judge, seed=seed, **quick).shape.nodes[1]
            for seed in range(3)
        ]
        for judge in ("left_out", "training")
    }
    assert max(sizes["left_out"]) < min(sizes["training"])
    with pytest.raises(BadInput, match="nodes_by: 'luck' is not allowed: left_out, training"):
        GeneticBackPropagation.fit(task, nodes_by="luck")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"hidden": ()}, "0 hidden layers are not allowed"),
        ({"hidden": (0,)}, "hidden: 0 is not allowed: 1 to 50"),
        ({"hidden": 1.5}, "hidden: 1.5 is not allowed: must be a whole number"),
        ({"iterations": 0}, "iterations: 0 is not allowed"),
        ({"decay": -1.0}, "decay: -1 is not allowed"),
        ({"rows": 7}, "rows: 7 is not allowed: 30 to"),
        ({"goal": "low"}, "goal: 'low' is not allowed"),
    ],
)
def test_wrong_options_are_refused(options, told):
    assert told in refusal(BackPropagation.fit, bent_task(), **options)
    if "hidden" not in options:
        assert told in refusal(GeneticBackPropagation.fit, bent_task(), hidden=4, **options)


def test_constant_columns_are_refused():
    x = np.random.default_rng(0).standard_normal((80, 2))
    x[:, 1] = 3.0
    assert "T2: is constant" in refusal(BackPropagation.fit, task_of([run_of(x, x[:, :1])]))
    with pytest.raises(BadInput, match="y0: never changes"):
        BackPropagation.fit(task_of([run_of(x[:, :1], np.ones((80, 1)))]))


def test_training_only_goes_down_and_notes_the_goal():
    shape, x = Shape((1, 6, 1)), np.linspace(-1, 1, 60)[:, None]
    start, y, each = (
        nguyen_widrow(shape, np.random.default_rng(3)),
        np.sin(3 * x),
        np.full(60, 1 / 60),
    )
    found = levenberg_marquardt(shape, start, x, y, each, iterations=200, goal=1e-4, decay=0.0)
    assert all(b <= a for a, b in pairwise(found.curve))
    assert found.curve[-1] < 1e-4
    assert found.curve[found.reached] <= 1e-4 < found.curve[found.reached - 1]
    assert np.mean((shape.outputs(found.theta, x) - y) ** 2) == pytest.approx(found.curve[-1])


def test_two_hidden_layers_as_in_the_time_series_study():
    fitted = BackPropagation.fit(bent_task(), hidden=(5, 5), iterations=3)
    assert fitted.report()["nodes"] == [4, 5, 5, 3]
    assert fitted.report()["weights_and_thresholds"] == 4 * 5 + 5 + 5 * 5 + 5 + 5 * 3 + 3


def test_evolution_finds_a_peak_and_keeps_the_best():
    random = np.random.default_rng(0)
    target = np.array([0.5, -0.25, 0.75])

    def fitness(people):
        return 1.0 / (1e-6 + np.sum((people - target) ** 2, axis=1))

    first = random.uniform(-1, 1, (40, 3))
    best, history = evolve(first, fitness, -1.0, 1.0, GeneticSettings(40, 150), random)
    assert best == pytest.approx(target, abs=0.1)
    assert all(b >= a for a, b in pairwise(history))
    assert history[-1] > 5 * history[0]


def test_a_4_10_3_network_has_83_genes():
    # 4 x 10 + 10 x 3 weights and 10 + 3 thresholds; the study's own sum says 110.
    assert Shape((4, 10, 3)).size == 70 + 13
