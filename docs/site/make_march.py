"""Make march.xlsx, the log that the first notebook starts from: python docs/site/make_march.py.

Five days of a simulated jig borer as a German workbook holds them: local dates, units in the second
header line, commas for points where the reader sees them, temperatures in kelvin, millimetres. The
days are the shipped training scenarios with other noise, and one that they do not hold.
"""

from pathlib import Path

import pandas as pd

import spindle_drift as sd

DAYS = {
    "2026-03-02 06:02": "training_down",
    "2026-03-03 06:11": "training_random",
    "2026-03-04 05:58": "training_stops",
    "2026-03-05 06:20": "training_warm_hall",
    "2026-03-06 06:05": "stop_and_go",
}
NAMES = {
    "speed_rpm": ("Spindeldrehzahl", "1/min"),
    "T1_degC": ("Lager vorn", "K"),
    "T4_degC": ("Kühlmantel", "K"),
    "T5_degC": ("Halle", "K"),
    "T6_degC": ("Gehäuse", "K"),
    "T9_degC": ("Kühlmittel Zulauf", "K"),
    "T10_degC": ("Motor", "K"),
    "disp_z_um": ("Spindelnase Z", "mm"),
    "disp_y_um": ("Spindelnase Y", "mm"),
}


def day(start: str, scenario: str, seed: int) -> pd.DataFrame:
    """Return a day's table."""
    frame = sd.simulate("jig_borer", scenario, every_s=60.0, noise_seed=seed).frame
    # Drift at the nose, as one probe against a test bar shows it.
    frame["disp_z_um"], frame["disp_y_um"] = frame["S5_um"], frame["S2_um"]
    times = pd.Timestamp(start) + pd.to_timedelta(frame["time_s"], unit="s")
    columns: dict[object, object] = {("Zeit", ""): times.dt.strftime("%d.%m.%Y %H:%M:%S")}
    for column, named in NAMES.items():
        values = frame[column]
        if named[1] == "K":
            values = (values + 273.15).round(2)
        if named[1] == "mm":
            values = (values / 1000.0).round(5)
        columns[named] = values
    return pd.DataFrame(columns)


def main() -> None:
    """Write the workbook."""
    days = [day(start, name, 40 + at) for at, (start, name) in enumerate(DAYS.items())]
    whole = pd.concat(days, ignore_index=True)
    rows = [[name for name, _ in whole.columns], [unit for _, unit in whole.columns]]
    rows += whole.to_numpy().tolist()
    path = Path(__file__).parents[1] / "notebooks" / "march.xlsx"
    pd.DataFrame(rows).to_excel(path, sheet_name="Messung", header=False, index=False)


if __name__ == "__main__":
    main()
