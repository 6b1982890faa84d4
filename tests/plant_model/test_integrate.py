"""Exact where the network is linear, error-controlled where it is not."""

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from plant_model.integrate import ExponentialRungeKutta, IntegrationError, Modes, phi
from plant_model.level import LevelStepper
from plant_model.machine import Machine
from plant_model.machine_file import read_machine, shipped_machines
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.side_by_side import Track, side_by_side
from plant_model.simulate import simulate
from tests.plant_model.conftest import in_series, inputs_over, with_effects


def reference(machine: Machine, inputs: pd.DataFrame, rtol: float = 1e-11) -> FloatArray:
    """Return temperatures at the last row from scipy's implicit solver, step by step."""
    values = Values(machine.parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    state = np.full(network.node_count, inputs["T5_degC"].iloc[0])
    columns = {entry.name: inputs[entry.column].to_numpy(float) for entry in machine.inputs}
    time = inputs["time_s"].to_numpy(float)
    jumps = np.flatnonzero(np.diff(columns["speed"])) + 1
    bounds = [0, *jumps.tolist(), len(time) - 1]
    for a, b in pairwise(bounds):
        held = {name: np.array([column[a]]) for name, column in columns.items()}
        matrix, boundary = (part[0] for part in network.conductances(held))
        heat = network.heat(held)[0, 0]

        def slope(
            t: float,
            y: FloatArray,
            held: dict[str, FloatArray] = held,
            matrix: FloatArray = matrix,
            boundary: FloatArray = boundary,
            heat: FloatArray = heat,
        ) -> FloatArray:
            outside = np.array([np.interp(t, time, columns[n]) for n in machine.boundary_index])
            now = held | {n: outside[i : i + 1] for i, n in enumerate(machine.boundary_index)}
            extra, _ = network.dependent(now, outside[None], y[None, None], np.zeros((1, 1, 0)))
            flow = heat + boundary @ outside - matrix @ y + extra[0, 0]
            return flow / network.capacity[0]

        solution = solve_ivp(
            slope, (time[a], time[b]), state, method="Radau", rtol=rtol, atol=1e-10, max_step=600.0
        )
        state = solution.y[:, -1]
    return state


@pytest.mark.parametrize("name", shipped_machines())
def test_parts_keep_the_heat_that_they_exchange(name):
    """With the independent solver's temperatures, this is a closed account of energy."""
    machine = read_machine(name)
    values = Values(machine.parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    inputs = {entry.name: np.array([0.5 * entry.high]) for entry in machine.inputs}
    matrix, boundary = (part[0] for part in network.conductances(inputs))
    # What a part gives, another gets; at the temperature of the surroundings all is in balance.
    np.testing.assert_array_equal(matrix, matrix.T)
    within = 1e-12 * np.abs(matrix).max()
    np.testing.assert_allclose(matrix.sum(axis=1), boundary.sum(axis=1), atol=within)


def test_linear_network_equals_an_independent_solver(jig_borer_lumps):
    inputs = inputs_over(1.2, every_s=600.0)
    inputs[["T5_degC", "T9_degC"]] = inputs["T5_degC"].iloc[0]
    ours = simulate(jig_borer_lumps, inputs, step_s=600.0).temperatures[0, -1]
    np.testing.assert_allclose(ours, reference(jig_borer_lumps, inputs), atol=2e-8)


def test_linear_network_does_not_depend_on_the_step(jig_borer_lumps):
    inputs = inputs_over(2.0, every_s=600.0)
    coarse = simulate(jig_borer_lumps, inputs, step_s=300.0)
    fine = simulate(jig_borer_lumps, inputs, step_s=6.0)
    np.testing.assert_allclose(coarse.temperatures, fine.temperatures, atol=1e-10)


@pytest.mark.parametrize(
    ("hours", "step_s", "tolerance", "of_solver", "off"),
    [
        pytest.param(1.2, 10.0, 1e-7, 1e-9, 1e-5, marks=pytest.mark.long),
        (0.8, 600.0, 5e-4, 1e-7, 1e-3),
    ],
)
def test_dependent_network_equals_an_independent_solver(
    hours, step_s, tolerance, of_solver, off, jig_borer_lumps
):
    machine = with_effects(
        in_series(jig_borer_lumps, "jacket_front"), "radiation", "viscosity_temperature"
    )
    inputs = inputs_over(hours, every_s=600.0)
    ours = simulate(machine, inputs, step_s=step_s, tolerance=tolerance).temperatures[0, -1]
    np.testing.assert_allclose(ours, reference(machine, inputs, of_solver), atol=off)


@pytest.mark.parametrize(("fed", "off"), [(False, 1e-3), (True, 5e-3)])
def test_error_control_keeps_what_it_promises(fed, off, jig_borer_lumps):
    machine = in_series(jig_borer_lumps, "jacket_front") if fed else jig_borer_lumps
    machine = with_effects(machine, "radiation", "viscosity_temperature")
    inputs = inputs_over(0.4, every_s=60.0)
    default = simulate(machine, inputs, step_s=60.0).temperatures
    close = simulate(machine, inputs, step_s=20.0, tolerance=1e-7).temperatures
    assert np.abs(default - close).max() < off


def through(
    network: Network,
    matrices: tuple[FloatArray, FloatArray],
    now: dict[str, FloatArray],
    lengths: FloatArray,
    start: FloatArray,
    tolerance: float,
) -> FloatArray:
    """Return the states, (K, size), at the end of steps through which all inputs stay."""
    steps = len(lengths)
    held = {name: np.tile(value, steps) for name, value in now.items()}
    heat = np.tile(network.heat(now), (1, steps, 1))
    outside = np.array([[now[name][0] for name in network.machine.boundary_index]] * steps)
    level = LevelStepper(network, *matrices)
    force = level.forced((heat, heat), (outside, outside))
    track = Track(start, lengths, [level] * steps, held, force, (outside, outside))
    return side_by_side(network, [track], tolerance)[0][0]


@pytest.mark.long
def test_convergence_order_is_three(jig_borer_lumps):
    machine = with_effects(jig_borer_lumps, "viscosity_temperature")
    values = Values(machine.parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    held = {"speed": np.array([12000.0]), "torque": np.array([0.0])}
    outside = np.array([21.0, 21.0])
    now = held | {"ambient": outside[:1], "coolant_inlet": outside[1:]}
    matrices = network.conductances(now)

    def end(count: int) -> FloatArray:
        start = np.full((1, network.node_count), 21.0)
        lengths = np.full(count, 1200.0 / count)
        return through(network, matrices, now, lengths, start, np.inf)[-1]

    exact = end(4096)
    errors = np.array([np.abs(end(steps) - exact).max() for steps in (256, 512, 1024)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert errors[-1] < 1e-4
    assert np.all(orders > 2.6), orders
    assert np.all(orders < 3.6), orders


def test_a_model_that_blows_up_is_refused():
    modes = Modes.of(np.array([[[1.0]]]), np.array([[100.0]]))
    with pytest.raises(IntegrationError):
        ExponentialRungeKutta([modes]).interval(
            np.ones((1, 1, 1)), np.array([1000.0]), lambda at, state: np.exp(state**2)
        )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_phi_has_no_seam_and_the_right_limits(order):
    x = -np.geomspace(1e-12, 1e3, 4000)
    value = phi(order, x)
    # phi_k(x) = 1/(k-1)! int_0^1 exp((1-s) x) s^(k-1) ds, here by Gauss-Legendre on 300 nodes.
    nodes, weights = np.polynomial.legendre.leggauss(300)
    s, w = (nodes + 1.0) / 2.0, weights / 2.0
    factorial = [1.0, 1.0, 2.0][order - 1]
    integral = (np.exp((1.0 - s) * x[:, None]) * s ** (order - 1) * w).sum(axis=1) / factorial
    np.testing.assert_allclose(value, integral, rtol=5e-12)


def test_a_long_step_goes_down_to_what_a_short_one_does():
    """Heat that dies away in 5 ms, in a step of a day: a 2^-14th of that would be 5 s."""
    day, fades_s, heat = 86400.0, 0.005, 1.0
    modes = Modes(np.zeros((1, 1)), np.eye(1)[None], np.eye(1)[None])
    scheme = ExponentialRungeKutta([modes])

    def forcing(at: FloatArray, state: FloatArray) -> FloatArray:
        return np.full_like(state, heat * np.exp(-at[0] * day / fades_s) / fades_s)

    end = scheme.interval(np.zeros((1, 1, 1)), np.array([day]), forcing)
    assert end[0, 0, 0] == pytest.approx(heat, abs=1e-3)
