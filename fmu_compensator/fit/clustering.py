r"""Grouping of similar temperatures: hierarchical clustering and fuzzy c-means.

A time-series study of a jig borer groups its temperatures by "fuzzy clustering" and describes
hierarchical clustering with the Euclidean distance. Both are here: `hierarchical` is the described
method, `fuzzy_c_means` the named one.

Series are the columns of an array, rows are samples. Distances depend on the size of the series: a
sensor that moves twice as much is far from one with the same shape. Scale the columns first if
only the shape matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage

Array = NDArray[np.float64]


def centroid_linkage(series: Array) -> Array:
    """Return scipy's linkage matrix: Euclidean distance between the centroids of clusters.

    Parameters
    ----------
    series : array (n, m)
        m series of n samples.

    Returns
    -------
    array (m - 1, 4)
        The two clusters of each merge, their distance, and the number of series together.
    """
    if series.ndim != 2 or series.shape[1] < 2:
        raise ValueError(f"at least 2 series in columns are needed, not shape {series.shape}")
    return np.asarray(linkage(series.T, method="centroid", metric="euclidean"))


def hierarchical(series: Array, clusters: int) -> list[list[int]]:
    """Return the columns in at most *clusters* groups, in the order of their first column."""
    if clusters < 1:
        raise ValueError(f"{clusters} clusters are not allowed: at least 1")
    if series.shape[1] == 1:
        return [[0]]
    label = fcluster(_monotonic(centroid_linkage(series)), clusters, criterion="maxclust")
    return grouped(label)


def _monotonic(tree: Array) -> Array:
    """Raise merges below an earlier one: centroid linkage may be non-monotonic, a cut must not."""
    lifted = tree.copy()
    lifted[:, 2] = np.maximum.accumulate(tree[:, 2])
    return lifted


@dataclass(frozen=True)
class FuzzyClusters:
    """Result of fuzzy c-means.

    Attributes
    ----------
    membership : array (m, clusters)
        Degree to which each series belongs to each cluster; rows sum to 1 [1].
    centres : array (clusters, n)
        The clusters' centres.
    """

    membership: Array
    centres: Array

    @property
    def groups(self) -> list[list[int]]:
        """The columns grouped by their largest membership, without empty clusters."""
        return grouped(self.membership.argmax(axis=1))


def fuzzy_c_means(series: Array, clusters: int) -> FuzzyClusters:
    r"""Return the fuzzy partition of the columns with the smallest sum of u^2 d^2.

    .. math::
        u_{ic} = \Big( \sum_k (d_{ic} / d_{ik})^2 \Big)^{-1}, \quad
        v_c = \frac{\sum_i u_{ic}^2 x_i}{\sum_i u_{ic}^2}

    After Bezdek (1981), doi:10.1007/978-1-4757-0450-1, with the usual exponent 2. These equations
    have several solutions; the result is the best of those reached with each series as the first
    centre.

    Parameters
    ----------
    series : array (n, m)
        m series of n samples.
    clusters : int
        From 1 to the number of series.
    """
    if not 1 <= clusters <= series.shape[1]:
        raise ValueError(f"{clusters} clusters are not allowed: 1 to {series.shape[1]}")
    # Rotating them into as many coordinates as there are series keeps all distances.
    points = np.asarray(np.linalg.qr(series, mode="r")).T
    solutions = [
        _solution(points, _far_apart(points, first, clusters)) for first in range(len(points))
    ]
    _, membership = min(solutions, key=lambda solution: solution[0])
    return FuzzyClusters(membership, _centres(series.T, membership**2))


def _far_apart(points: Array, first: int, clusters: int) -> Array:
    """Return one point per cluster, each the furthest from all previous ones."""
    chosen = [first]
    while len(chosen) < clusters:
        away = np.min([np.linalg.norm(points - points[c], axis=1) for c in chosen], axis=0)
        chosen.append(int(np.argmax(away)))
    return points[chosen]


def _solution(points: Array, centres: Array) -> tuple[float, Array]:
    """Return the sum of u^2 d^2, and u, after iterating from some centres."""
    membership = np.zeros((len(points), len(centres)))
    for _ in range(300):
        distance = np.linalg.norm(points[:, None, :] - centres[None, :, :], axis=2)
        # A point on a centre belongs only to it; the floor keeps the quotients finite.
        closeness = np.maximum(distance, 1e-12) ** -2.0
        updated = closeness / closeness.sum(axis=1, keepdims=True)
        weights = updated**2
        centres = _centres(points, weights)
        settled, membership = np.allclose(updated, membership), updated
        if settled:
            break
    return float(np.sum(weights * distance**2)), membership


def _centres(points: Array, weights: Array) -> Array:
    return np.asarray(weights.T @ points / weights.sum(axis=0)[:, None])


def grouped(label: NDArray[np.integer]) -> list[list[int]]:
    """Return the columns of each label, in the order of their first column.

    Parameters
    ----------
    label : array of int, shape (m,)
        One per column.
    """
    groups: dict[int, list[int]] = {}
    for column, group in enumerate(label.tolist()):
        groups.setdefault(group, []).append(column)
    return sorted(groups.values())
