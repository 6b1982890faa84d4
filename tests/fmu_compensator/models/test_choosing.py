"""Clustering, correlation, all subsets, and the survey that puts them together."""

import numpy as np
import pytest

from fmu_compensator.fit.clustering import centroid_linkage, fuzzy_c_means, hierarchical
from fmu_compensator.fit.correlation import all_subsets, pearson
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.points import choose_points
from fmu_compensator.fit.survey import survey
from measurement.errors import BadInput
from tests.fmu_compensator.conftest import RIG, make_run

RUNS = [make_run(name, seed, hours=2.0) for seed, name in enumerate("abc")]


def two_families(noise: float = 0.05):
    random = np.random.default_rng(0)
    t = np.linspace(0, 1, 60)
    fast, slow = 1 - np.exp(-10 * t), t
    columns = [fast, slow, 1.02 * fast, 0.98 * slow, 1.05 * slow]
    return np.column_stack([c + noise * random.standard_normal(60) for c in columns])


def test_hierarchical_clustering_groups_what_is_close():
    assert hierarchical(two_families(), 2) == [[0, 2], [1, 3, 4]]
    assert hierarchical(two_families(), 1) == [[0, 1, 2, 3, 4]]
    assert hierarchical(two_families()[:, :1], 3) == [[0]]


def test_an_inverted_tree_is_still_cut():
    # Three corners of a nearly equilateral triangle: the last merge lies below the first.
    points = np.array([[0.0, 1.0, 0.5], [0.0, 0.0, 0.9]])
    tree = centroid_linkage(points)
    assert tree[1, 2] < tree[0, 2]
    assert len(hierarchical(points, 2)) <= 2


def test_fuzzy_memberships_sum_to_one_and_find_the_families():
    found = fuzzy_c_means(two_families(), 2)
    assert found.membership.sum(axis=1) == pytest.approx(np.ones(5))
    assert found.groups == [[0, 2], [1, 3, 4]]
    assert found.membership.max(axis=1).min() > 0.8


def test_fuzzy_centres_solve_their_own_equation():
    series = two_families()
    found = fuzzy_c_means(series, 2)
    weights = found.membership**2
    means = weights.T @ series.T / weights.sum(axis=0)[:, None]
    assert found.centres == pytest.approx(means, abs=1e-5)


def test_fuzzy_partition_is_the_best_of_its_solutions():
    series = np.array([[7.0, 9.0, 4.0, 3.0, 8.0, 2.0, 0.0]])
    assert fuzzy_c_means(series, 3).groups == [[0, 1, 4], [2, 3, 5], [6]]


@pytest.mark.parametrize("clusters", [0, 6])
def test_impossible_partitions_are_refused(clusters):
    with pytest.raises(ValueError, match="not allowed"):
        fuzzy_c_means(two_families(), clusters)


def test_pearson_is_numpys_and_undefined_for_a_constant():
    random = np.random.default_rng(1)
    x, y = random.standard_normal((50, 2)), random.standard_normal(50)
    x[:, 1] = 4.0
    r = pearson(x, y)
    assert r[0] == pytest.approx(np.corrcoef(x[:, 0], y)[0, 1])
    assert np.isnan(r[1])


def test_all_subsets_against_plain_regressions():
    random = np.random.default_rng(2)
    runs = []
    for _ in range(3):
        x = random.standard_normal((40, 4))
        runs.append((x, x @ [1.0, 0.5, 0.0, 0.0] + 0.3 * random.standard_normal(40)))
    found = all_subsets(runs)
    assert len(found) == 2**4 - 1
    assert len({one.columns for one in found}) == 15
    x, y = (np.concatenate([run[part] for run in runs]) for part in (0, 1))
    for one in (found[0], found[7], found[14]):
        a = np.column_stack([x[:, one.columns], np.ones(120)])
        residual = y - a @ np.linalg.lstsq(a, y, rcond=None)[0]
        r2 = 1 - residual @ residual / np.sum((y - y.mean()) ** 2)
        assert one.multiple_r == pytest.approx(np.sqrt(r2))
        k = len(one.columns)
        assert one.r2_adjusted == pytest.approx(1 - (1 - r2) * 119 / (120 - k - 1))
        missed = []
        for out in range(3):
            rest = [run for number, run in enumerate(runs) if number != out]
            ax = np.concatenate(
                [np.column_stack([r[0][:, one.columns], np.ones(40)]) for r in rest]
            )
            b = np.linalg.lstsq(ax, np.concatenate([r[1] for r in rest]), rcond=None)[0]
            here = np.column_stack([runs[out][0][:, one.columns], np.ones(40)])
            missed.append(runs[out][1] - here @ b)
        assert one.held_out_rmse == pytest.approx(np.sqrt(np.mean(np.concatenate(missed) ** 2)))
    assert np.isnan(all_subsets(runs[:1])[0].held_out_rmse)  # one run: nothing can be left out


@pytest.mark.parametrize("grouping", ["hierarchical", "fuzzy"])
def test_the_other_clusterings_choose_points_too(grouping):
    prepared = prepare(RUNS, RIG)
    choice = choose_points(prepared.runs, prepared.candidates, grouping=grouping, clusters=2)
    assert choice.groups == [[0, 1], [3]]
    assert 3 in choice.chosen
    with pytest.raises(BadInput, match="clusters: 9 is not allowed: 1 to 3"):
        choose_points(prepared.runs, prepared.candidates, grouping=grouping, clusters=9)


def test_a_survey_holds_every_way_to_choose():
    found = survey(RUNS, RIG, clusters=2)
    assert found.sensors == ["T1", "T2", "T4"]  # T3 shows noise only
    assert list(found.groupings.values()) == [[[0, 1], [2]]] * 3
    assert np.diag(found.degree) == pytest.approx(np.ones(3))
    assert found.degree[0, 1] > 0.9 > found.degree[0, 2]
    assert found.target == "elongation"
    assert len(found.subsets) == 2 ** len(found.points) - 1
    assert found.subsets[0].columns == (0, 1)
    assert found.subsets[0].held_out_rmse < 0.5
    assert found.to_dict()["points"][-1] == "T4"
    assert survey(RUNS, RIG, clusters=2, target="yaw").pearson[2] > 0.99


def test_plain_r_never_falls_and_adjusted_r2_does():
    random = np.random.default_rng(3)
    x = random.standard_normal((60, 3))
    found = {one.columns: one for one in all_subsets([(x, x[:, 0] + random.standard_normal(60))])}
    assert found[(0, 1, 2)].multiple_r >= found[(0, 1)].multiple_r >= found[(0,)].multiple_r
    assert max(found.values(), key=lambda one: one.r2_adjusted).columns != (0, 1, 2)
    assert np.isnan(found[(0,)].held_out_rmse)  # one run: nothing can be left out
