"""Grey degrees of incidence."""

import numpy as np
import pytest

from fmu_compensator.fit.incidence import (
    NoImageError,
    absolute_degree,
    comprehensive_degree,
    groups,
    initial_value_image,
    interval_image,
    mean_image,
    relational_degree,
    relative_degree,
)

# Worked by hand: x = 1 3 4 7 starts at 0 2 3 6, so s = 2 + 3 + 3 = 8; y = 2 2 4 4 at 0 0 2 2,
# so s = 0 + 2 + 1 = 3; z falls: 0 -1 -2 -3, so s = -1 - 2 - 1.5 = -4.5.
SERIES = np.array([[1.0, 2.0, 5.0], [3.0, 2.0, 4.0], [4.0, 4.0, 3.0], [7.0, 4.0, 2.0]])


def test_absolute_degree_by_hand():
    degree = absolute_degree(SERIES)
    assert degree[0, 1] == pytest.approx((1 + 8 + 3) / (1 + 8 + 3 + 5))
    assert degree[0, 2] == pytest.approx((1 + 8 + 4.5) / (1 + 8 + 4.5 + 12.5))
    assert degree[1, 2] == pytest.approx((1 + 3 + 4.5) / (1 + 3 + 4.5 + 7.5))
    assert np.array_equal(degree, degree.T)
    assert np.array_equal(np.diag(degree), np.ones(3))


def test_images_by_hand():
    assert initial_value_image(SERIES)[:, 1] == pytest.approx([1, 1, 2, 2])
    assert mean_image(SERIES)[:, 1] == pytest.approx([2 / 3, 2 / 3, 4 / 3, 4 / 3])
    assert interval_image(SERIES)[:, 0] == pytest.approx([0, 1 / 3, 0.5, 1])
    assert interval_image(np.full((3, 1), 4.0)).tolist() == [[0.0]] * 3


def test_relative_degree_by_hand():
    # Images 1 3 4 7 (s = 8) and 1 1 2 2 (s = 0 + 1 + 0.5 = 1.5).
    assert relative_degree(SERIES)[0, 1] == pytest.approx(10.5 / (10.5 + 6.5))
    # Mean images: x / 3.75 (s = 8 / 3.75), y / 3 (s = 1).
    x, y = 8 / 3.75, 1.0
    assert relative_degree(SERIES, "mean")[0, 1] == pytest.approx((1 + x + y) / (1 + 2 * x))


def test_comprehensive_degree_mixes_both():
    mixed = comprehensive_degree(SERIES, theta=0.25)
    assert mixed == pytest.approx(0.25 * absolute_degree(SERIES) + 0.75 * relative_degree(SERIES))
    with pytest.raises(ValueError, match="theta"):
        comprehensive_degree(SERIES, theta=1.5)


def test_the_absolute_degree_of_initial_value_images_is_the_relative_one():
    degree = comprehensive_degree(SERIES, theta=1.0, absolute_image="initial")
    assert degree == pytest.approx(relative_degree(SERIES))
    # Where the absolute degree counts for nothing its image need not exist, and the other way.
    rises = SERIES - SERIES[0]
    assert comprehensive_degree(rises, 1.0, "initial") == pytest.approx(absolute_degree(rises))
    relative = comprehensive_degree(rises, 0.0, "interval", "initial")
    assert relative == pytest.approx(relative_degree(rises, "interval"))
    with pytest.raises(NoImageError, match="column 0 starts at 0"):
        comprehensive_degree(rises, 0.5, "interval", "initial")


def test_relational_degree_by_hand():
    # Interval images: error 0 0.5 1; first column the same, second 1 0.5 0: distances 1 0 1.
    error = np.array([0.0, 2.0, 4.0])
    series = np.array([[10.0, 9.0], [11.0, 7.0], [12.0, 5.0]])
    wanted = [1.0, (0.5 / 1.5 + 1.0 + 0.5 / 1.5) / 3]
    assert relational_degree(error, series) == pytest.approx(wanted)
    assert relational_degree(error, series[:, :1]) == pytest.approx([1.0])


def test_groups_are_closed_under_likeness():
    degree = np.array(
        [[1, 0.5, 0.95, 0.1], [0.5, 1, 0.2, 0.1], [0.95, 0.2, 1, 0.9], [0.1, 0.1, 0.9, 1]]
    )
    assert groups(degree, 0.9) == [[0, 2, 3], [1]]
    assert groups(degree, 0.91) == [[0, 2], [1], [3]]
    assert groups(degree, 0.5) == [[0, 1, 2, 3]]


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: absolute_degree(np.ones((1, 2))), "2 samples"),
        (lambda: absolute_degree(np.ones(4)), "in columns"),
        (lambda: initial_value_image(np.array([[1.0, 0.0], [2.0, 2.0]])), "column 1 starts at 0"),
        (lambda: mean_image(np.array([[-1.0], [1.0]])), "column 0 has mean 0"),
    ],
)
def test_what_does_not_exist_is_refused(call, told):
    with pytest.raises(ValueError, match=told):
        call()
