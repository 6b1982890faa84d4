"""Temperatures are found from modes, and modes are moved by heat, at the nodes that act."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from plant_model.effects.base import Effect
from plant_model.effects.radiation import Radiation
from plant_model.integrate import ExponentialRungeKutta, IntegrationError, Modes
from plant_model.side_by_side import _Forcing, _Watched
from plant_model.simulate import simulate
from tests.plant_model.conftest import with_effects

GENERATOR = np.random.default_rng(1)
SETS, RUNS, NODES = 3, 2, 5


def some(*shape: int) -> Any:
    return GENERATOR.normal(size=shape)


@pytest.mark.parametrize(
    ("read", "nodes"),
    [
        (lambda t: t[..., 2], [2]),
        (lambda t: t[..., [0, 3, 3]], [0, 3]),
        (lambda t: t[..., 1:4], [1, 2, 3]),
        (lambda t: t[:, 0, None], [0, 1, 2, 3, 4]),
        (lambda t: 2.0 * t - t**2, [0, 1, 2, 3, 4]),
        (lambda t: t @ np.arange(10.0).reshape(5, 2), [0, 1, 2, 3, 4]),
        (lambda t: np.mean(t, axis=-1), [0, 1, 2, 3, 4]),
        (lambda t: np.zeros((len(t), *t.shape)), []),
    ],
)
def test_whatever_reads_temperatures_is_noticed_and_gets_them(read, nodes):
    whole = some(SETS, RUNS, NODES)
    watched = _Watched(whole)
    np.testing.assert_array_equal(read(watched), read(whole))
    assert np.flatnonzero(watched.read).tolist() == nodes


def test_an_effect_that_reads_other_nodes_later_is_refused_by_name(jig_borer_lumps, monkeypatch):
    def heat(self: Effect, inputs: Any, temperatures: Any, states: Any, out: Any) -> None:
        if inputs["speed"].any():
            out[..., 0] -= 0.01 * temperatures[..., 3]

    monkeypatch.setattr(Radiation, "heat", heat)
    monkeypatch.setattr(Radiation, "conductance", Effect.conductance)
    machine = with_effects(jig_borer_lumps, "radiation")
    inputs = {"time_s": [0.0, 60.0, 120.0], "T5_degC": 21.0, "T9_degC": 21.0}
    inputs["speed_rpm"] = [0.0, 3000.0, 3000.0]
    name = machine.nodes[3].name
    with pytest.raises(IntegrationError, match=f"reads the temperature of {name}, which"):
        simulate(machine, pd.DataFrame(inputs))


@pytest.mark.parametrize("heated", [[], [3], [0, 1, 4], [0, 1, 2, 3, 4]])
def test_few_nodes_act_on_modes_as_all_would(heated):
    """Also after a run has entered other modes and another has ended."""
    read = np.array([1, 3])
    modes = [Modes(some(1, NODES), some(1, NODES, NODES), some(1, NODES, NODES)) for _ in range(3)]

    def dependent(inputs: Any, outside: Any, temperatures: Any, own: Any) -> Any:
        heat = np.zeros(temperatures.shape)
        heat[..., heated] = temperatures[..., read].sum(axis=-1, keepdims=True)
        return heat, np.zeros_like(own)

    network = SimpleNamespace(
        node_count=NODES,
        machine=SimpleNamespace(boundary_index={}),
        state_decay=lambda: np.zeros((SETS, 0)),
        dependent=dependent,
    )
    scheme = ExponentialRungeKutta(modes[:RUNS])
    forcing = _Forcing(network, scheme, read)

    def check(runs: int) -> None:
        outside, state = np.zeros((runs, 0)), some(SETS, runs, NODES)
        first, last = some(2, SETS, runs, NODES)
        forcing.step({}, (outside, outside), (first, last))
        to_nodes = scheme.to_state
        whole = np.einsum(
            "srnm,srm->srn", np.broadcast_to(to_nodes, (SETS, *to_nodes.shape[1:])), state
        )
        heat = dependent({}, outside, whole, np.zeros((SETS, runs, 0)))[0]
        expected = 0.5 * (first + last) + np.einsum("srn,xrnm->srm", heat, to_nodes)
        np.testing.assert_allclose(forcing(np.full(runs, 0.5), state), expected, atol=1e-12)

    check(RUNS)
    scheme.enter(0, modes[2])
    forcing.enter(0)
    check(RUNS)
    scheme.keep(1)
    forcing.keep(1)
    check(1)
