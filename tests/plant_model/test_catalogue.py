"""The catalogue of missing effects: on any machine, in the stepper, and how often each is asked."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from gap_finder.candidates import with_effect
from gap_finder.keys import driver_keys
from plant_model.effects import catalogue
from plant_model.effects.base import possible
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from tests.plant_model.catalogue_machines import bare, lathe
from tests.plant_model.conftest import inputs_over, key_of, with_effects

JIG_BORER = read_machine("jig_borer_lumps")

NAMES = [name for name, effect in catalogue().items() if not effect.handles]
"""Every effect that a model may lack: those that are no law of a machine's own parts."""
DRIVEN = [key for name in NAMES for key in driver_keys(JIG_BORER, catalogue()[name])[1:]]
"""The same on the drivers that they have besides the usual one, on the jig borer."""
NEEDS_MORE = {  # torque, coolant or two probes on an axis
    "copper_loss",
    "cutting_heat",
    "coolant_degradation",
    "coolant_supply_offset",
    "coolant_thermostat",
    "probe_warming",
}
NEEDS_NO_PART = {  # the hall, a thermometer and the speed are enough for these
    "centrifugal_shift",
    "column_bending",
    "fixture_warming",
    "sensor_drift",
    "sensor_offset",
    "slow_structure",
}


def hall_run(hours: float = 1.0) -> pd.DataFrame:
    time_s = np.arange(0.0, hours * 3600.0 + 1.0, 30.0)
    return pd.DataFrame(
        {
            "time_s": time_s,
            "speed_rpm": np.where(time_s < 1800.0, 3000.0, 1000.0),
            "hall_degC": 21.0 + np.sin(time_s / 1500.0),
        }
    )


def shown(machine: Machine, inputs: pd.DataFrame) -> pd.DataFrame:
    return simulate(machine, inputs).run_frame()


@cache
def shown_without(which: Callable[[], Machine], hours: float) -> pd.DataFrame:
    return shown(which(), hall_run(hours))


@pytest.mark.parametrize("name", NAMES)
def test_acts_on_a_machine_of_other_names_or_does_nothing(name):
    without, with_it = shown_without(lathe, 1.0), shown(with_effects(lathe(), name), hall_run())
    change = np.abs((with_it - without).to_numpy()).max()
    assert np.isfinite(with_it.to_numpy()).all()
    assert change < 1e-3 if name in NEEDS_MORE else change > 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_does_nothing_where_there_is_nothing_to_act_on(name):
    without, with_it = shown_without(bare, 0.3), shown(with_effects(bare(), name), hall_run(0.3))
    change = np.abs((with_it - without).to_numpy()).max()
    assert change > 1e-3 if name in NEEDS_NO_PART else change < 1e-9


def test_a_set_in_which_all_are_off_is_as_without_them(jig_borer_lumps):
    machine, inputs = (
        with_effects(jig_borer_lumps, *NAMES, *DRIVEN),
        inputs_over(0.25, every_s=60.0),
    )
    moved = {}
    for key in machine.effects.keys() - jig_borer_lumps.effects.keys():
        effect = catalogue()[key.partition(":")[0]]
        nominal = effect.parameters[effect.amplitude].value
        moved[f"effects.{key}.{effect.amplitude}"] = [effect.off, nominal]
    both, without = simulate(machine, inputs, moved), simulate(jig_borer_lumps, inputs)
    alone = simulate(machine, inputs)
    for key, series in without.readings.items():
        np.testing.assert_allclose(both.readings[key][0], series[0], atol=1e-8, err_msg=key)
        np.testing.assert_allclose(both.readings[key][1], alone.readings[key][0], atol=5e-2)
    np.testing.assert_allclose(both.pose[0], without.pose[0], atol=1e-8)


@pytest.mark.parametrize("name", ["sensor_lag", "sensor_offset", "sensor_drift"])
def test_a_thermometer_s_error_leaves_displacement_sensors_alone(name, jig_borer_lumps):
    key = f"{name}:S1"
    effects = jig_borer_lumps.effects | {key: dict(catalogue()[name].parameters)}
    inputs = inputs_over(0.2)
    with_it = shown(replace(jig_borer_lumps, effects=effects), inputs)
    np.testing.assert_allclose(with_it, shown(jig_borer_lumps, inputs), atol=1e-12)


def test_a_lag_is_the_same_whether_or_not_it_stands_beside_something_nonlinear(jig_borer_lumps):
    inputs = inputs_over(2.0)
    lags = ["column_bending", "slow_structure", "sensor_lag", "uneven_bearing_heating"]
    apart = simulate(with_effects(jig_borer_lumps, *lags), inputs)
    beside = with_effects(jig_borer_lumps, *lags, "radiation").with_values(
        {"effects.radiation.emissivity": 1e-12}
    )
    together = simulate(beside, inputs, tolerance=1e-5)
    for key, series in apart.readings.items():
        # Beside a linear network a temperature counts as linear within a step of 10 s.
        np.testing.assert_allclose(together.readings[key], series, atol=6e-3, err_msg=key)


def test_a_lag_s_error_comes_before_an_offset_in_whatever_order(jig_borer_lumps):
    inputs = inputs_over(0.5)
    one = shown(with_effects(jig_borer_lumps, "sensor_lag", "sensor_offset"), inputs)
    other = shown(with_effects(jig_borer_lumps, "sensor_offset", "sensor_lag"), inputs)
    np.testing.assert_allclose(one["T1_degC"], other["T1_degC"], atol=1e-12)
    only_lag = shown(with_effects(jig_borer_lumps, "sensor_lag"), inputs)
    np.testing.assert_allclose(one["T1_degC"] - only_lag["T1_degC"], 1.0, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_possible_holds_what_is_usual_and_can_be_simulated(name, jig_borer_lumps):
    effect = catalogue()[name]
    usual = effect.parameters[effect.amplitude]
    low, high = possible(effect, effect.amplitude)
    assert low <= usual.low < usual.high <= high
    assert low <= effect.off <= high
    # The sign is physics: what only heats never cools.
    assert (low < effect.off) == (usual.low < effect.off)
    for other in effect.parameters.keys() - {effect.amplitude}:
        parameter, (least, most) = effect.parameters[other], possible(effect, other)
        assert least <= parameter.low <= parameter.high <= most
        # Hours may be unusual, and never negative; a direction or a share is all there is.
        wider = other in effect.law and parameter.low > 0.0
        assert (least > 0.0) if wider else (least, most) == (parameter.low, parameter.high)
    inputs = inputs_over(0.5)
    for size in {low, high} - {effect.off}:
        grown = with_effect(jig_borer_lumps, key_of(name), {effect.amplitude: size})
        frame = simulate(grown, inputs).run_frame()
        assert np.isfinite(frame.to_numpy()).all()
