"""What the page's numbers come from: bearings, lubricants, coolants, films."""

import numpy as np
import pytest

from plant_model.drawing.bearing_table import by_designation
from plant_model.drawing.class_values import CLASS_VALUES, f0_of, f1_of
from plant_model.drawing.coolants import GLYCOL, coolant
from plant_model.drawing.films import channel_film, still_air, turning
from plant_model.drawing.known import CLASS
from plant_model.drawing.lubricant import viscosity
from plant_model.drawing.materials import MATERIALS


@pytest.mark.parametrize(
    ("designation", "bore", "outside", "width"),
    [
        # Sizes as makers' catalogues print them.
        ("7014", 70.0, 110.0, 20.0),
        ("B7014-C-T-P4S", 70.0, 110.0, 20.0),
        ("7014 CD/P4A", 70.0, 110.0, 20.0),
        ("7003", 17.0, 35.0, 10.0),
        ("7210", 50.0, 90.0, 20.0),
        ("NN 3014 KTN/SP", 70.0, 110.0, 30.0),
        ("N1011", 55.0, 90.0, 18.0),
        ("6205", 25.0, 52.0, 15.0),
    ],
)
def test_designations(designation, bore, outside, width):
    bearing = by_designation(designation)
    assert (bearing.bore, bearing.outside, bearing.width) == (bore, outside, width)
    assert bearing.mean_diameter == (bore + outside) / 2.0
    assert bearing.kind == ("roller" if designation.startswith("N") else "ball")


@pytest.mark.parametrize("designation", ["7099", "719/500", "70144", "spindle"])
def test_designations_that_are_not_known(designation):
    assert by_designation(designation) is None


@pytest.mark.parametrize(
    ("designation", "kilograms"), [("7014", 0.60), ("71914", 0.34), ("7020", 1.3), ("NN3014", 1.05)]
)
def test_masses_are_those_of_catalogues(designation, kilograms):
    bearing = by_designation(designation)
    assert bearing.mass == pytest.approx(kilograms, rel=0.12)


def test_viscosities_of_charts():
    # VG 32 with an index of 95 has 5.2 to 5.4 mm2/s at 100 degC and is 12 mm2/s near 68 degC;
    # VG 68 has 8.5 to 8.8 (data sheets of mineral spindle and hydraulic oils).
    assert viscosity(32, 100.0) == pytest.approx(5.3, abs=0.15)
    assert viscosity(32, 68.0) == pytest.approx(12.0, rel=0.05)
    assert viscosity(68, 100.0) == pytest.approx(8.65, abs=0.2)
    assert viscosity(32, 100.0, 140.0) > viscosity(32, 100.0, 95.0)


@pytest.mark.long
@pytest.mark.parametrize("percent", [0, 25, 30, 60])
def test_coolants_are_those_of_coolprop(percent):
    from CoolProp.CoolProp import PropsSI  # takes seconds, which no other process has to wait

    fluid = "Water" if percent == 0 else f"INCOMP::MEG-{percent}%"
    ours = coolant("water" if percent == 0 else f"glycol {percent} %")
    theirs = [PropsSI(key, "T", 295.15, "P", 3e5, fluid) for key in ("D", "C", "L", "V")]
    found = [ours.density, ours.specific_heat, ours.conductivity, ours.viscosity]
    np.testing.assert_allclose(found, theirs, rtol=2e-4 if percent in GLYCOL else 0.01)


def test_coolants_that_are_not_known():
    assert coolant("glycol 80 %") is None
    assert coolant("oil 11") is None
    assert coolant("beer") is None
    oil = coolant("oil 10")
    assert oil.viscosity == pytest.approx(860e-6 * viscosity(10, 22.0))


def test_films_are_of_the_handbooks_size():
    # Free convection and radiation near 5 to 12, a fast turning nose 50 to 200 W/(m2 K), turbulent
    # water in a jacket 1 to 10 kW/(m2 K): VDI Heat Atlas, 2nd ed., parts F and G.
    assert 5.0 < still_air(190.0, 0.8) < 12.0
    assert still_air(190.0, 0.3) < still_air(190.0, 0.9)
    assert 50.0 < turning(80.0, 5000.0) < 200.0
    assert turning(80.0, 0.0) == 0.0
    water = coolant("water")
    assert 1000.0 < channel_film(water, 4.0, 15.0, 6.0, 150.0) < 10000.0


def test_a_channel_has_the_film_of_a_coil():
    oil, mix = coolant("oil 32"), coolant("glycol 33 %")
    d = 2 * 15 * 6 / 21e3  # hydraulic diameter [m]
    # Hardly flowing: 3.66 k / d as in a straight pipe.
    slow = channel_film(oil, 1e-6, 15.0, 6.0, 150.0)
    assert slow == pytest.approx(3.66 * oil.conductivity / d, rel=0.01)
    # Laminar at Re = 2245, Pr = 17.8, d/D = 0.0429: Nu = 3.66 + 0.0838 * 2245^0.6575 * 17.8^(1/3).
    assert channel_film(mix, 3.0, 15.0, 6.0, 200.0) * d / mix.conductivity == pytest.approx(
        38.6, rel=0.01
    )
    # Turbulent at Re = 37,417: f = 0.3164 Re^-0.25 + 0.03 (d/D)^0.5 = 0.0290.
    nusselt = channel_film(mix, 50.0, 15.0, 6.0, 200.0) * d / mix.conductivity
    drag = 0.0290 / 8
    by_hand = drag * 37417 * 17.8 / (1 + 12.7 * drag**0.5 * (17.8 ** (2 / 3) - 1))
    assert nusselt == pytest.approx(by_hand, rel=0.01)


@pytest.mark.parametrize("fluid", ["water", "glycol 33 %", "oil 10"])
def test_a_channels_film_grows_with_its_flow_without_a_jump(fluid):
    liquid = coolant(fluid)
    films = [channel_film(liquid, flow, 15.0, 6.0, 150.0) for flow in np.geomspace(0.1, 200, 2000)]
    steps = np.array(films[1:]) / films[:-1]
    assert steps.min() > 1.0
    assert steps.max() < 1.01


def test_class_values_lie_in_their_ranges_and_say_what_they_are():
    kinds = [(kind, way) for kind in ("ball", "roller") for way in ("oil-air", "grease", "oil")]
    usual = [*CLASS_VALUES.values(), *(f0_of(*kind) for kind in kinds), f1_of("ball")]
    for known in usual:
        assert known.low < known.value < known.high
        assert known.source.startswith(CLASS)
        assert len(known.source) > len(CLASS) + 5
    for material in MATERIALS.values():
        for known in (material.heat, material.conductivity, material.expansion):
            assert known.low < known.value < known.high
