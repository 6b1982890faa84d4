"""Keys of effects: a name, and a sensor or a driver after a colon."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plant_model.effect_names import effect_key, name_of
from plant_model.effects import Effect, catalogue
from plant_model.machine import Machine


def effect_of(key: str) -> type[Effect] | None:
    """Return the effect that a key names; None for a change of the description."""
    return catalogue().get(name_of(key))


def law_of(key: str) -> str:
    """Return a key without its driver: the same for a law whatever drives it."""
    effect = effect_of(key)
    return key if effect is None or effect.on_channel else effect.name


def driver_of(machine: Machine, key: str) -> tuple[str, str]:
    """Return a key's driver and its description; both empty if the law has no choice of drivers.

    Parameters
    ----------
    machine : Machine
    key : str
        As in a machine file: name, or name, colon and channel or driver.

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
    """Return an effect's keys, one for each driver available on a machine, the usual first."""
    others = list(effect.drivers(machine))[1:]
    return [effect.name, *(effect_key(effect.name, driver) for driver in others)]


def has_its_drivers(machine: Machine) -> bool:
    """Whether every effect in force has a driver that exists on the machine."""
    for key in machine.effects:
        effect, driver = effect_of(key), key.partition(":")[2]
        if effect is None or effect.on_channel or not driver:
            continue
        if driver not in effect.drivers(machine):
            return False
    return True


def unused_with(machine: Machine, key: str) -> tuple[str, ...]:
    """Return the parameters that are not fitted with a key's driver: idle and given ones."""
    effect = effect_of(key)
    if effect is None:
        return ()
    return (*effect.unused(driver_of(machine, key)[0]), *effect.given)


def key_of(name: str, place: Sequence[str]) -> str:
    """Return the key of a change of the description.

    Parameters
    ----------
    name : str
        The kind of change.
    place : sequence of str
        The parts, inputs, sensors or axes.
    """
    return f"{name}:{'+'.join(place)}"


def bodies_of(key: str, body: Mapping[str, str]) -> tuple[str, ...]:
    """Return a key's name, and the bodies of the parts after its colon in alphabetical order.

    Parameters
    ----------
    key : str
    body : mapping of str to str
        The body of each part that is a cell of one; any other part is a body itself.
    """
    name, _, place = key.partition(":")
    return name, *sorted(body.get(part, part) for part in place.split("+"))


def place_of(key: str) -> list[str]:
    """Return the place in the key of a change.

    Parameters
    ----------
    key : str
        As `key_of` returns it.
    """
    return key.partition(":")[2].split("+")
