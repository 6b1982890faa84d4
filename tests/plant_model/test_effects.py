"""The contract of every effect that the folder holds."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plant_model.effects import catalogue, item_kinds
from plant_model.effects.air_gap import gap_nusselt
from plant_model.effects.bearing_friction import friction_heat, viscous_torque
from plant_model.machine import Machine
from plant_model.machine_file import machine_from_table
from plant_model.parameters import Parameter
from plant_model.simulate import simulate
from tests.plant_model.catalogue_machines import bare_table
from tests.plant_model.conftest import inputs_over, key_of, with_effects

NAMES = sorted(catalogue())


def machine_with(machine: Machine, name: str, value: float) -> Machine:
    """Return the machine with one effect in force at an amplitude."""
    effect = catalogue()[name]
    key = key_of(name)
    with_it = with_effects(machine, name) if key not in machine.effects else machine
    return with_it.with_values({f"effects.{key}.{effect.amplitude}": value})


@pytest.mark.parametrize("name", NAMES)
def test_declares_what_a_report_needs(name):
    effect = catalogue()[name]
    assert effect.title
    assert effect.explanation.endswith(".")
    assert effect.__doc__
    amplitude = effect.parameters[effect.amplitude]
    assert amplitude.low <= effect.off <= amplitude.high, "calibration must be able to reach off"
    for parameter in effect.parameters.values():
        assert parameter.low <= parameter.value <= parameter.high
        assert parameter.source


@pytest.mark.parametrize("name", NAMES)
def test_off_is_the_model_without_it_to_the_last_bit(name, jig_borer_lumps):
    inputs = inputs_over(1.0)
    off = simulate(machine_with(jig_borer_lumps, name, catalogue()[name].off), inputs)
    left = {key: value for key, value in jig_borer_lumps.effects.items() if key != key_of(name)}
    without = simulate(replace(jig_borer_lumps, effects=left), inputs)
    pd.testing.assert_frame_equal(off.run_frame(), without.run_frame(), check_exact=True)


@pytest.mark.parametrize("name", NAMES)
def test_does_something_and_stays_finite_over_its_whole_range(name, jig_borer_lumps):
    effect = catalogue()[name]
    inputs = inputs_over(0.5, every_s=60.0)
    machine = machine_with(jig_borer_lumps, name, effect.parameters[effect.amplitude].value)
    if any(key in item_kinds() for key in effect.handles) and not any(
        (item.family, item.kind) in effect.handles for item in machine.items
    ):
        pytest.skip(f"the jig borer has nothing that {name} acts on")
    # Nominal, off, and each parameter at both of its ends.
    sets = [{}, {effect.amplitude: effect.off}]
    sets += [{key: end} for key, p in effect.parameters.items() for end in (p.low, p.high)]
    moved = {
        f"effects.{key_of(name)}.{key}": [one.get(key, p.value) for one in sets]
        for key, p in effect.parameters.items()
    }
    shown = np.array(list(simulate(machine, inputs, moved).readings.values()))
    assert np.isfinite(shown).all()
    assert np.abs(shown[:, 0] - shown[:, 1]).max() > 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_parameters_go_through_a_machine_file(name):
    effect = catalogue()[name]
    moved = {
        key: Parameter(p.high, p.unit, p.low, p.high, "moved", calibrate=True)
        for key, p in effect.parameters.items()
    }
    effects = {needed: {} for needed in effect.needs}
    effects[key_of(name)] = {key: p.to_dict() for key, p in moved.items()}
    table = bare_table() | {"effects": effects}
    assert machine_from_table(table, "small.toml").effects[key_of(name)] == moved


def test_palmgren_torque_against_a_hand_calculation():
    # nu n = 12 * 12000 = 144000, ^(2/3) = 2747.3; 1e-7 * 1 * 2747.3 * 70^3 = 94.23 N mm.
    torque = viscous_torque(*(np.array([v]) for v in (1.0, 12.0, 12000.0, 70.0)))
    assert torque[0] == pytest.approx(94.23, rel=1e-3)
    assert friction_heat(np.array([12000.0]), torque)[0] == pytest.approx(118.4, rel=1e-3)


def test_gap_nusselt_against_becker_and_kaye():
    taylor = np.array([0.0, 1699.0, 5000.0, 1e6])
    expected = [2.0, 2.0, 0.128 * 5000**0.367, 0.409 * 1e6**0.241]
    np.testing.assert_allclose(gap_nusselt(taylor), expected, rtol=1e-12)
    rising = gap_nusselt(np.linspace(0.0, 1e7, 5000))
    assert np.all(np.diff(rising) >= -0.02), "the exchange grows with speed"
