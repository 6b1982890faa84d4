"""What keys of effects stand for: a name, and a sensor or a driver behind a colon."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from plant_model.effect_names import effect_key, name_of
from plant_model.effects import Effect, catalogue
from plant_model.machine import Machine


def effect_of(key: str) -> type[Effect] | None:
    """Return the effect that a key names; None for a change of the description."""
    return catalogue().get(name_of(key))


def law_of(key: str) -> str:
    """Return a key without its driver: what the same law is called, whatever drives it."""
    effect = effect_of(key)
    return key if effect is None or effect.on_channel else effect.name


def laws_of(keys: Iterable[str]) -> tuple[str, ...]:
    """Return the laws that keys stand for, each once, in their order."""
    return tuple(dict.fromkeys(law_of(key) for key in keys))


def driver_of(machine: Machine, key: str) -> tuple[str, str]:
    """Return a key's driver and the words for it; both empty where the law has but one.

    Parameters
    ----------
    machine : Machine
    key : str
        As a machine file has it: name, or name, colon and channel or driver.

    Returns
    -------
    driver, words : str
    """
    effect = effect_of(key)
    drivers = {} if effect is None or effect.on_channel else effect.drivers(machine)
    if not drivers:
        return "", ""
    driver = key.partition(":")[2] or next(iter(drivers))
    return driver, drivers.get(driver, f"the {driver}")


def driver_keys(machine: Machine, effect: type[Effect]) -> list[str]:
    """Return an effect's keys, one for each driver that it has on a machine, the usual first."""
    others = list(effect.drivers(machine))[1:]
    return [effect.name, *(effect_key(effect.name, driver) for driver in others)]


def has_its_drivers(machine: Machine) -> bool:
    """Tell whether every effect in force is driven by something that may drive it there."""
    for key in machine.effects:
        effect, driver = effect_of(key), key.partition(":")[2]
        if effect is None or effect.on_channel or not driver:
            continue
        if driver not in effect.drivers(machine):
            return False
    return True


def is_switched(machine: Machine, key: str) -> bool:
    """Tell whether a part switches the effect that a key names."""
    effect = effect_of(key)
    if effect is None or not effect.switched:
        return False
    return effect.switched[0] not in effect.unused(driver_of(machine, key)[0])


def unused_with(machine: Machine, key: str) -> tuple[str, ...]:
    """Return the parameters that nobody fits with a key's driver: idle ones, and given ones."""
    effect = effect_of(key)
    if effect is None:
        return ()
    return (*effect.unused(driver_of(machine, key)[0]), *effect.given)


def key_of(name: str, place: Sequence[str]) -> str:
    """Return what a change of the description is called among what is tried.

    Parameters
    ----------
    name : str
        The kind of change.
    place : sequence of str
        The parts, inputs, sensors or axes.
    """
    return f"{name}:{'+'.join(place)}"


def place_of(key: str) -> list[str]:
    """Return the place that the key of a change names.

    Parameters
    ----------
    key : str
        As `key_of` gives it.
    """
    return key.partition(":")[2].split("+")
