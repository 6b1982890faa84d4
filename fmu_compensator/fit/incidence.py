r"""Grey degrees of incidence: how similar two series are in shape and in rate of change.

Equations from the grey system theory of Deng and Liu, as used in the thermal-error studies.
Series are the columns of an array, rows are evenly spaced samples.

A degree of incidence is not a correlation coefficient: it depends on the scale and the sampling of
the series. The absolute degree sums samples, so twice as many samples of the same curve, or the
same curve in another unit, give another degree (the constant 1 in it weighs less). The relational
degree depends on the other series through the smallest and largest distance. Only compare degrees
within one data set.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from fmu_compensator.fit.clustering import grouped

Array = NDArray[np.float64]


class NoImageError(ValueError):
    """An image of a series does not exist.

    Attributes
    ----------
    column : int
        The series.
    why : str
        The reason.
    """

    def __init__(self, column: int, why: str) -> None:
        super().__init__(f"column {column} {why}")
        self.column, self.why = column, why


def initial_value_image(series: Array) -> Array:
    """Return each column divided by its first value [1]; does not exist if that is zero."""
    return _divided(series, series[0], "starts at 0: it has no initial-value image")


def mean_image(series: Array) -> Array:
    """Return each column divided by its mean [1]; does not exist if that is zero."""
    return _divided(series, series.mean(axis=0), "has mean 0: it has no mean image")


def _divided(series: Array, by: Array, why_not: str) -> Array:
    for column in np.flatnonzero(by == 0):
        raise NoImageError(int(column), why_not)
    return np.asarray(series / by)


def interval_image(series: Array) -> Array:
    """Return each column mapped onto 0 to 1 [1]; a constant column becomes 0."""
    low = series.min(axis=0)
    span = series.max(axis=0) - low
    return np.asarray((series - low) / np.where(span > 0, span, 1.0))


IMAGES: dict[str, Callable[[Array], Array]] = {
    "initial": initial_value_image,
    "mean": mean_image,
    "interval": interval_image,
}
AS_READ = "as_read"
"""Use the series itself instead of an image."""


def absolute_degree(series: Array) -> Array:
    r"""Return the grey absolute degree of incidence between all pairs of columns.

    .. math::
        x^0(k) = x(k) - x(1), \quad s = \sum_{k=2}^{n-1} x^0(k) + x^0(n)/2, \quad
        \varepsilon_{ij} = \frac{1 + |s_i| + |s_j|}{1 + |s_i| + |s_j| + |s_i - s_j|}

    Parameters
    ----------
    series : array (n, m)
        At least two samples of m series, evenly spaced.

    Returns
    -------
    array (m, m)
        Symmetric, 1 on the diagonal, above 0 [1].
    """
    if series.ndim != 2 or len(series) < 2:
        raise ValueError(f"at least 2 samples in columns are needed, not shape {series.shape}")
    started = series - series[0]
    s = started[1:-1].sum(axis=0) + started[-1] / 2
    size = 1 + (np.abs(s)[:, None] + np.abs(s)[None, :])
    return np.asarray(size / (size + np.abs(s[:, None] - s[None, :])))


def relative_degree(series: Array, image: str = "initial") -> Array:
    """Return the grey relative degree: the absolute degree of dimensionless images.

    Parameters
    ----------
    series : array (n, m)
        As for `absolute_degree`.
    image : {"initial", "mean", "interval"}
        ``initial`` is Liu's definition, ``mean`` the one the jig-borer study pairs it with.

    Returns
    -------
    array (m, m)
        It reflects only the rate of change relative to the start, whatever the scale [1].
    """
    return absolute_degree(IMAGES[image](series))


def comprehensive_degree(
    series: Array, theta: float = 0.5, image: str = "initial", absolute_image: str = AS_READ
) -> Array:
    """Return theta times the absolute plus (1 - theta) times the relative degree, all pairs.

    Parameters
    ----------
    series : array (n, m)
        As for `absolute_degree`.
    theta : float
        Weight of the absolute degree, 0 to 1 [1].
    image : {"initial", "mean", "interval"}
        Of the relative degree.
    absolute_image : {"as_read", "initial", "mean", "interval"}
        Of the absolute degree. Liu uses the series itself. The jig-borer study uses initial-value
        images, whose absolute degree does not depend on the scale: it is Liu's relative degree.

    Returns
    -------
    array (m, m)
        Symmetric, 1 on the diagonal [1].
    """
    if not 0 <= theta <= 1:
        raise ValueError(f"theta {theta:g} is not in 0 to 1")
    # An image with zero weight need not exist.
    parts = np.zeros((series.shape[1], series.shape[1]))
    if theta > 0:
        taken = series if absolute_image == AS_READ else IMAGES[absolute_image](series)
        parts = parts + theta * absolute_degree(taken)
    if theta < 1:
        parts = parts + (1 - theta) * relative_degree(series, image)
    return parts


def groups(degree: Array, threshold: float = 0.9) -> list[list[int]]:
    """Return the columns in groups, joining those whose degree is at least *threshold*.

    Joining is transitive: if i joins j and j joins k, all three are one group.
    Groups are in the order of their first column.
    """
    _, label = connected_components(degree >= threshold, directed=False)
    return grouped(label)


def relational_degree(reference: Array, series: Array) -> Array:
    r"""Return Deng's grey relational degree of each column to a reference, such as the error.

    .. math::
        \xi_i(k) = \frac{\Delta_{min} + 0.5 \Delta_{max}}{\Delta_i(k) + 0.5 \Delta_{max}}, \quad
        \Delta_i(k) = |x_0(k) - x_i(k)|

    The degree is the mean of the coefficient xi over k; the minimum and maximum are over all
    columns and samples. Both are interval images, because an error starts at 0, where its
    initial-value image does not exist.

    Parameters
    ----------
    reference : array (n,)
        The error.
    series : array (n, m)
        The temperatures.

    Returns
    -------
    array (m,)
        Above 0 to 1 [1].
    """
    images = interval_image(np.column_stack([reference, series]))
    distance = np.abs(images[:, 1:] - images[:, :1])
    largest = distance.max()
    if largest == 0:
        return np.ones(series.shape[1])
    coefficient = (distance.min() + 0.5 * largest) / (distance + 0.5 * largest)
    return np.asarray(coefficient.mean(axis=0))
