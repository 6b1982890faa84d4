"""Two FMUs small enough to compute by hand, built with pythonfmu alone."""

import warnings
from pathlib import Path

COMMON = """
import ctypes

# As in fmu_packaging.package: without it, the globals are freed while they are in use.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, String
from pythonfmu import Real as PlainReal

IN, OUT = Fmi2Causality.input, Fmi2Causality.output
PARAMETER = dict(causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)


class Real(PlainReal):
    def __init__(self, name, unit, **kwargs):
        super().__init__(name, **kwargs)
        self.unit = unit

    def to_xml(self):
        element = super().to_xml()
        for child in element:
            if child.tag == "Real":
                child.set("unit", self.unit)
                if self.name == "speed":
                    child.set("max", "1e5")
        return element

"""

PLANT = (
    COMMON
    + '''
class CLASS(Fmi2Slave):
    """T1 grows by gain * speed * h; drift_X = 10 (T1 - 20), drift_Z = -T1 + 20, drift_Y = 0."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.speed = 0.0
        self.tool_length = 70.0
        self.dX = self.dY = self.dZ = 0.0
        self.gain = 1e-3
        self.noise_seed = 0
        self.T1 = 20.0
        for name, unit in INPUTS:
            self.register_variable(Real(name, unit, causality=IN, start=START.get(name, 0.0)))
        self.register_variable(Real("gain", "1", start=1e-3, **PARAMETER))
        self.register_variable(Integer("noise_seed", start=0, **PARAMETER))
        for name, unit in OUTPUTS:
            self.register_variable(Real(name, unit, causality=OUT))
        self.refresh()

    def refresh(self):
        drift = {"X": 10.0 * (self.T1 - 20.0), "Y": 0.0, "Z": 20.0 - self.T1}
        self.S1, self.S2, self.S5 = drift["X"], drift["Y"], drift["Z"]
        self.S3, self.S4 = 1.1 * self.S1, 0.5 * self.S1
        for axis in "XYZ":
            offset = getattr(self, "d" + axis)
            setattr(self, "drift_" + axis, drift[axis])
            setattr(self, "offset_" + axis, offset)
            setattr(self, "error_" + axis, drift[axis] + offset)

    def do_step(self, current_time, step_size):
        if self.speed > 9000.0:
            self.log("this plant bursts at 9000 r/min", Fmi2Status.error)
            return False
        self.T1 += self.gain * self.speed * step_size
        self.refresh()
        return True


from pythonfmu.enums import Fmi2Status
AXES = ["X", "Y", "Z"]
START = {"tool_length": 70.0}
INPUTS = [("speed", "rpm"), ("tool_length", "mm"), *(("d" + a, "um") for a in AXES)]
OUTPUTS = [("T1", "degC"), *(("S%d" % i, "um") for i in range(1, 6))]
OUTPUTS += [(what + "_" + a, "um") for what in ("drift", "offset", "error") for a in AXES]
'''
)

COMPENSATOR = (
    COMMON
    + '''
class CLASS(Fmi2Slave):
    """dX = -10 (T1 - 20); the status is 11 while T1 is missing, and the offset holds."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.T1 = 20.0
        self.speed = self.tool_length = 0.0
        self.dX = self.dY = self.dZ = self.yaw = self.pitch = self.elongation = 0.0
        self.valid = True
        self.status = self.status_sensor = 0
        self.status_text = "ok"
        for name, unit in [("T1", "degC"), ("speed", "rpm"), ("tool_length", "mm")]:
            self.register_variable(Real(name, unit, causality=IN, start=0.0))
        for name, unit in OUTPUTS:
            self.register_variable(Real(name, unit, causality=OUT))
        self.register_variable(Boolean("valid", causality=OUT))
        for name in ("status", "status_sensor"):
            self.register_variable(Integer(name, causality=OUT))
        self.register_variable(String("status_text", causality=OUT))

    def do_step(self, current_time, step_size):
        missing = self.T1 != self.T1
        if not missing:
            self.dX = -10.0 * (self.T1 - 20.0)
            self.yaw = -self.dX / 10.0
        self.valid, self.status, self.status_sensor = not missing, 11 * missing, int(missing)
        self.status_text = "holding: T1 is missing" if missing else "ok"
        return True


OUTPUTS = [("d" + axis, "um") for axis in "XYZ"]
OUTPUTS += [("elongation", "um"), ("yaw", "urad"), ("pitch", "urad")]
'''
)


def build_tiny(source: str, name: str, folder: Path) -> Path:
    """Build an FMU whose class and script are called *name*, and return its path."""
    from pythonfmu.builder import FmuBuilder

    folder.mkdir(parents=True, exist_ok=True)
    script = folder / f"{name.lower()}_script.py"
    script.write_text(source.replace("CLASS", name), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return Path(FmuBuilder.build_FMU(script, dest=folder))
