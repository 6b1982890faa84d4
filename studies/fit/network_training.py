"""Training of feed-forward networks: Levenberg-Marquardt with an exact Jacobian."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.training import Array

FIRST_MU, MU_DOWN, MU_UP, LARGEST_MU = 1e-3, 0.1, 10.0, 1e10
"""Parameters of the damping: given by the widely used ``trainlm``."""


@dataclass(frozen=True)
class Shape:
    """Nodes per layer, inputs first and outputs last."""

    nodes: tuple[int, ...]

    @property
    def size(self) -> int:
        """Number of weights and thresholds of the network."""
        return sum(a * b + b for a, b in zip(self.nodes, self.nodes[1:], strict=False))

    def layers(self, theta: Array) -> list[tuple[Array, Array]]:
        """Return weights (nodes, nodes before) and thresholds of every layer.

        *theta* may have leading dimensions, such as a population.

        Parameters
        ----------
        theta : array, shape (..., size)
            All weights and thresholds.

        Returns
        -------
        list of (array, array)
            Of shape (..., nodes, nodes before) and (..., nodes), from the first hidden layer
            on.
        """
        layers, at = [], 0
        for before, here in zip(self.nodes, self.nodes[1:], strict=False):
            weights = theta[..., at : at + before * here]
            at += before * here
            thresholds = theta[..., at : at + here]
            at += here
            layers.append((weights.reshape(*theta.shape[:-1], here, before), thresholds))
        return layers

    def outputs(self, theta: Array, x: Array) -> Array:
        """Return the outputs for inputs x (n, inputs): (..., n, outputs).

        Parameters
        ----------
        theta : array, shape (..., size)
        x : array, shape (n, inputs)
            Scaled to -1 to 1.
        """
        values = x
        layers = self.layers(theta)
        for number, (weights, thresholds) in enumerate(layers):
            values = values @ np.swapaxes(weights, -1, -2) + thresholds[..., None, :]
            if number < len(layers) - 1:
                values = np.tanh(values)
        return np.asarray(values)

    def jacobian(self, theta: Array, x: Array) -> tuple[Array, Array]:
        """Return outputs (n, o) and their derivatives (n, o, size).

        Parameters
        ----------
        theta : array, shape (size,)
        x : array, shape (n, inputs)
            Scaled to -1 to 1.

        Returns
        -------
        outputs : array, shape (n, outputs)
        derivatives : array, shape (n, outputs, size)
            With respect to every weight and threshold, in the order of *theta*.
        """
        layers = self.layers(theta)
        values = [x]
        for number, (weights, thresholds) in enumerate(layers):
            total = values[-1] @ weights.T + thresholds
            values.append(total if number == len(layers) - 1 else np.tanh(total))
        outputs = self.nodes[-1]
        slope = np.broadcast_to(np.eye(outputs), (len(x), outputs, outputs))
        parts: list[Array] = []
        for number in range(len(layers) - 1, -1, -1):
            weights, _ = layers[number]
            before = values[number]
            by_weight = slope[:, :, :, None] * before[:, None, None, :]
            parts[:0] = [by_weight.reshape(len(x), outputs, -1), slope]
            if number:
                slope = (slope @ weights) * (1.0 - before**2)[:, None, :]
        return values[-1], np.concatenate(parts, axis=2)


@dataclass(frozen=True)
class Training:
    """A trained network.

    Attributes
    ----------
    theta : array (size,)
        Weights and thresholds, layer by layer.
    curve : list of float
        Mean squared error at the start and after each iteration [1].
    reached : int or None
        The iteration at which the goal was reached.
    """

    theta: Array
    curve: list[float]
    reached: int | None


def nguyen_widrow(shape: Shape, random: np.random.Generator) -> Array:
    """Return a start whose hidden nodes divide the inputs' range between them (inputs -1 to 1).

    After Nguyen and Widrow (1990), doi:10.1109/IJCNN.1990.137819.

    Parameters
    ----------
    shape : Shape
    random : Generator
        Source of random numbers.

    Returns
    -------
    array, shape (size,)
        Start for `levenberg_marquardt`.
    """
    parts = []
    last = len(shape.nodes) - 2
    for number, (before, here) in enumerate(zip(shape.nodes, shape.nodes[1:], strict=False)):
        weights = random.uniform(-1.0, 1.0, (here, before))
        thresholds = random.uniform(-1.0, 1.0, here)
        if number < last:
            size = 0.7 * here ** (1.0 / before)
            weights *= size / np.linalg.norm(weights, axis=1, keepdims=True)
            thresholds *= size
        else:
            weights, thresholds = 0.5 * weights, 0.5 * thresholds
        parts += [weights.ravel(), thresholds]
    return np.concatenate(parts)


def levenberg_marquardt(
    shape: Shape,
    theta: Array,
    x: Array,
    y: Array,
    weights: Array,
    *,
    iterations: int,
    goal: float,
    decay: float,
) -> Training:
    """Train a network from a start.

    Parameters
    ----------
    shape : Shape
        Of the network.
    theta : array (size,)
        Start.
    x, y : arrays (n, inputs), (n, outputs)
        Samples, scaled to -1 to 1.
    weights : array (n,)
        Weights of the samples, with sum 1.
    iterations : int
        Maximum number of iterations.
    goal : float
        The iteration at which the mean squared error falls below this is noted; training continues.
    decay : float
        Factor of the mean squared weight, which keeps the network smooth [1].

    Returns
    -------
    Training
        The weights found, and the error during training.
    """
    # The cost is mean squared error plus decay times the sum of squared weights over their number.
    root = np.sqrt(weights / y.shape[1])
    pull = decay / shape.size

    def errors(at: Array) -> tuple[float, float]:
        squared = float(np.sum((root[:, None] * (shape.outputs(at, x) - y)) ** 2))
        return squared, squared + pull * float(at @ at)

    mse, cost = errors(theta)
    curve, mu = [mse], FIRST_MU
    reached = 0 if mse <= goal else None
    for iteration in range(1, iterations + 1):
        outputs, slopes = shape.jacobian(theta, x)
        j = (root[:, None, None] * slopes).reshape(-1, shape.size)
        e = (root[:, None] * (outputs - y)).ravel()
        hessian = j.T @ j + pull * np.eye(shape.size)
        gradient = j.T @ e + pull * theta
        while mu <= LARGEST_MU:
            step = np.linalg.solve(hessian + mu * np.eye(shape.size), gradient)
            new_mse, new_cost = errors(theta - step)
            if new_cost < cost:
                break
            mu *= MU_UP
        else:
            break
        gained = cost - new_cost
        theta, mse, cost = theta - step, new_mse, new_cost
        mu = max(mu * MU_DOWN, 1e-15)
        curve.append(mse)
        if reached is None and mse <= goal:
            reached = iteration
        if gained < 1e-9 * cost:
            break
    return Training(theta, curve, reached)


def scaling(columns: Sequence[Array]) -> tuple[Array, Array]:
    """Return middle and half range of every column over all runs.

    Parameters
    ----------
    columns : sequence of array, each (rows, columns)
        One per run.

    Returns
    -------
    middle, half : array, shape (columns,)
        In the columns' units; half is 0 for a constant column.
    """
    values = np.concatenate(list(columns))
    low, high = values.min(axis=0), values.max(axis=0)
    return (low + high) / 2.0, (high - low) / 2.0
