"""Materials by name: heat capacity, conductivity and expansion with ranges.

The ranges of heat capacity and conductivity also cover what a drawing leaves open in a section:
holes, threads and keyways, some 5 %.
"""

from __future__ import annotations

from dataclasses import dataclass

from plant_model.drawing.known import Known

HANDBOOK = "handbook value at 20 degC"


@dataclass(frozen=True)
class Material:
    """A solid material.

    Attributes
    ----------
    name : str
    heat : Known
        Density times specific heat [J/(m3 K)].
    conductivity : Known
        [W/(m K)].
    expansion : Known
        [1e-6/K].
    density : float
        [kg/m3].
    """

    name: str
    heat: Known
    conductivity: Known
    expansion: Known
    density: float


def material(
    name: str,
    density: float,
    specific_heat: float,
    conductivity: tuple[float, float, float],
    expansion: tuple[float, float, float],
) -> Material:
    """Return a material from its density [kg/m3], specific heat [J/(kg K)] and other properties.

    Conductivity and expansion are value, low and high [W/(m K), 1e-6/K].
    """
    heat = density * specific_heat
    said = f"{name}, {HANDBOOK}"
    return Material(
        name,
        Known(heat, 0.92 * heat, 1.08 * heat, "J/(m3 K)", f"density and specific heat of {said}"),
        Known(*conductivity, "W/(m K)", f"conductivity of {said}"),
        Known(*expansion, "1e-6/K", f"expansion of {said}"),
        density,
    )


MATERIALS = {
    entry.name: entry
    for entry in (
        material("steel", 7850.0, 470.0, (45.0, 36.0, 54.0), (11.5, 10.8, 12.2)),
        material("cast_iron", 7200.0, 500.0, (50.0, 40.0, 58.0), (10.5, 9.5, 11.5)),
        material("lamination", 7400.0, 450.0, (25.0, 18.0, 32.0), (11.5, 10.5, 12.5)),
        material("aluminium", 2700.0, 900.0, (160.0, 120.0, 200.0), (23.0, 22.0, 24.0)),
        material("mineral_casting", 2350.0, 900.0, (2.0, 1.3, 3.0), (14.0, 11.0, 18.0)),
        material("invar", 8100.0, 500.0, (12.0, 10.0, 14.0), (1.5, 0.8, 2.5)),
        material("carbide", 14500.0, 210.0, (80.0, 60.0, 100.0), (5.5, 4.8, 6.5)),
        material("granite", 2700.0, 800.0, (2.8, 2.0, 3.6), (7.0, 5.0, 9.0)),
    )
}
"""By name in a page."""
