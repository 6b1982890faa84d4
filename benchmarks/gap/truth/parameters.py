"""The numbers of one particular machine, drawn around those of its class."""

from __future__ import annotations

import numpy as np

Parameters = dict[str, float]

SPREAD = {
    "mass": (0.07, 0.15),
    "section": (0.08, 0.18),
    "joint": (0.2, 0.405),
    "film": (0.18, 0.405),
    "flow": (0.08, 0.2),
    "friction": (0.12, 0.25),
    "length": (0.005, 0.01),
    "expansion": (0.02, 0.05),
    "share": (0.06, 0.12),
}
"""Standard deviation of the logarithm and the largest deviation allowed, by kind of number.

Masses and sections are known from drawings to 10 or 20 %; films and joints to a factor of 1.5."""

TABLE: dict[str, tuple[float, str]] = {
    # Heat capacities [J/K]; those of bearings are of one bearing of four.
    "c_shaft_rear": (2400.0, "mass"),
    "c_shaft_middle": (2800.0, "mass"),
    "c_shaft_front": (2800.0, "mass"),
    "c_rotor": (3600.0, "mass"),
    "c_stator": (6300.0, "mass"),
    "c_inner": (215.0, "mass"),
    "c_balls": (35.0, "mass"),
    "c_outer": (290.0, "mass"),
    "c_housing_rear": (8300.0, "mass"),
    "c_housing_motor": (18400.0, "mass"),
    "c_housing_front": (14800.0, "mass"),
    "c_jacket_rear": (1100.0, "mass"),
    "c_jacket_motor": (3000.0, "mass"),
    "c_jacket_front": (1500.0, "mass"),
    "c_pedestal": (240e3, "mass"),
    "c_column": (450e3, "mass"),
    "c_bed": (900e3, "mass"),
    "c_bar": (1400.0, "mass"),
    # Conductivity times section [W m/K]; around the circumference [W rad/(m K)].
    "ka_shaft": (0.15, "section"),
    "ka_bar": (0.06, "section"),
    "ka_housing": (0.9, "section"),
    "kt_housing": (8.8, "section"),
    "g_pedestal": (90.0, "section"),
    "g_column": (30.0, "section"),
    # Joints [W/K].
    "j_inner": (40.0, "joint"),
    "j_outer_front": (90.0, "joint"),
    "j_outer_rear": (60.0, "joint"),
    "j_race_front": (12.0, "joint"),
    "j_race_rear": (9.0, "joint"),
    "j_rotor": (60.0, "joint"),
    "j_stator": (240.0, "joint"),
    "j_flange": (0.5, "joint"),
    "j_pedestal": (40.0, "joint"),
    "j_column": (8.0, "joint"),
    "j_bed": (1.5, "joint"),
    "j_bar": (0.8, "joint"),
    # Jackets: wall conductance [W/K], difference around the circumference [1], flow [l/min].
    "ua_front": (152.0, "film"),
    "ua_motor": (176.0, "film"),
    "ua_rear": (110.0, "film"),
    "uneven_front_x": (0.55, "film"),
    "uneven_front_y": (0.28, "film"),
    "uneven_motor_x": (0.55, "film"),
    "uneven_motor_y": (0.28, "film"),
    "flow_front": (3.0, "flow"),
    "flow_motor": (5.0, "flow"),
    "flow_rear": (3.0, "flow"),
    "coolant": (3700.0, "share"),
    # Outer films [W/(m2 K)] and surfaces [m2]; a bare number multiplies the gap correlation.
    "h_housing": (9.0, "film"),
    "h_pedestal": (9.0, "film"),
    "h_column": (9.0, "film"),
    "h_bed": (5.0, "film"),
    "h_nose": (25.0, "film"),
    "h_bar": (60.0, "film"),
    "a_housing_front": (0.1, "section"),
    "a_housing_rear": (0.06, "section"),
    "a_pedestal": (0.9, "section"),
    "a_column": (3.2, "section"),
    "a_bed": (2.0, "section"),
    "a_nose": (0.012, "section"),
    "a_bar": (0.03, "section"),
    "gap_film": (1.0, "film"),
    "a_gap_rotor": (0.057, "section"),
    "a_gap_front": (0.032, "section"),
    "a_gap_rear": (0.025, "section"),
    # Heat: friction factor of each bearing set, preload [N], oil [mm2/s], motor [W/(1000 r/min)].
    "f0_front": (0.85, "friction"),
    "f0_rear": (0.85, "friction"),
    "f1": (0.001, "friction"),
    "preload_front": (250.0, "friction"),
    "preload_rear": (600.0, "friction"),
    "viscosity": (12.0, "friction"),
    "motor": (24.0, "friction"),
    "pair_balance": (1.0, "share"),
    "inner_share": (0.45, "share"),
    "ball_share": (0.1, "share"),
    "rotor_share": (0.3, "share"),
    # Growth [1e-6/K] and levers [mm].
    "alpha_steel": (11.5, "expansion"),
    "alpha_iron": (10.6, "expansion"),
    "located": (300.0, "length"),
    "width": (180.0, "length"),
    "pedestal_length": (350.0, "length"),
    "headstock_height": (110.0, "share"),
    "headstock_bend": (260.0 / 420.0, "share"),
    "headstock_yaw": (0.5, "share"),
    "headstock_lever": (430.0, "length"),
}


def nominal() -> Parameters:
    """Return the middle of the class."""
    return {name: value for name, (value, _) in TABLE.items()}


def draw(rng: np.random.Generator, middle: Parameters | None = None) -> Parameters:
    """Return the numbers of a machine around the class's middle, or around another one."""
    found = {}
    for name, value in (middle or nominal()).items():
        deviation, most = SPREAD[TABLE[name][1]]
        found[name] = value * float(np.exp(np.clip(deviation * rng.standard_normal(), -most, most)))
    return found
