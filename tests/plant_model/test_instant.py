"""One instant shows what the arrays of a simulation show, whatever effects are in force."""

from dataclasses import replace

import numpy as np
import pytest

from plant_model.effects import catalogue
from plant_model.instant import Instant, drift_of
from plant_model.network import Network, effects_in_force
from plant_model.parameters import Values
from plant_model.sensors import readings
from plant_model.structure import drift_at, pose
from tests.plant_model.catalogue_machines import lathe
from tests.plant_model.conftest import key_of, with_effects

EXACT = {"rel": 1e-12, "abs": 1e-12}


@pytest.mark.parametrize("kind", ["jig_borer_lumps", "lathe"])
def test_an_instant_equals_the_arrays(jig_borer_lumps, kind):
    machine = jig_borer_lumps if kind == "jig_borer_lumps" else lathe()
    machine = with_effects(machine, *(n for n in catalogue() if key_of(n) not in machine.effects))
    if kind == "jig_borer_lumps":  # a sensor that reads an input, and an effect on that reading too
        first = machine.sensors[0]
        ambient = replace(first, of=next(iter(machine.boundary_index)))
        turned = {f"{role}_sign": -1 for role in ("near_x", "distal_y")}
        sensors = (ambient, *machine.sensors[1:])
        machine = replace(machine, sensors=sensors, rig=machine.rig | turned)
    values = Values(machine.parameters)
    effects = effects_in_force(machine, values)
    slices = Network(machine, values, effects).state_slices()
    generator = np.random.default_rng(5)
    nodes = len(machine.nodes)
    own = max((part.stop for part in slices.values()), default=0)
    instant = Instant(machine, effects, slices)
    for _ in range(3):
        start = generator.uniform(15.0, 25.0, nodes)
        state = np.concatenate([generator.uniform(15.0, 60.0, nodes), generator.normal(size=own)])
        inputs = {e.name: float(generator.uniform(e.low, e.high)) for e in machine.inputs}
        time = float(generator.uniform(0.0, 30000.0))
        found_pose, found = instant.at(state, start, inputs, time)

        arrays = {key: np.array([value]) for key, value in inputs.items()}
        temperatures, states = state[None, None, :nodes], state[None, None, nodes:]
        whole = pose(effects, slices, arrays, temperatures - start, states)
        shown = readings(
            machine, effects, slices, arrays, np.array([time]), temperatures, states, whole
        )
        assert found_pose == pytest.approx(whole[0, 0], **EXACT)
        assert instant.names == list(shown)
        for key, value in zip(instant.names, found, strict=True):
            assert value == pytest.approx(shown[key][0, 0], **EXACT), key
        assert drift_of(found_pose, 150.0) == pytest.approx(drift_at(whole, 150.0)[0, 0], **EXACT)
