"""An .ssp of spindle-drift in ecospy: python ssp_in_ecospy.py FILE.ssp STEP_S STOP_S OUT.csv."""

import ctypes
import sys
from importlib import metadata

import pandas as pd

# ecospy's library needs the one in the package tbb, but does not look for it there.
(library,) = (file for file in metadata.files("tbb") if file.name == "libtbb.so.12")
ctypes.CDLL(str(library.locate().resolve()), mode=ctypes.RTLD_GLOBAL)

from ecospy import EcosSimulation  # noqa: E402

WANTED = {
    "plant": ["error_X", "error_Y", "error_Z", "drift_Z", "T1"],
    "compensator": ["dX", "dY", "dZ"],
}

step, stop = float(sys.argv[2]), float(sys.argv[3])
rows = []
with EcosSimulation(step, ssp_path=sys.argv[1]) as simulation:
    # ecos applies the parameter set of the .ssp (the noise seed) only when it is named.
    simulation.init(0.0, "scenario")
    while simulation.get_time() < stop - step / 2:
        found = {"time": simulation.step()}
        for part, names in WANTED.items():
            found |= {name: simulation.get_real(f"{part}::{name}") for name in names}
        rows.append(found)
    simulation.terminate()
pd.DataFrame(rows).to_csv(sys.argv[4], index=False)
