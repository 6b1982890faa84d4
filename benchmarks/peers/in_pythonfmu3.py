"""The regression as pythonfmu3 has it, FMI 3.0: a script for its own builder."""

from pythonfmu3 import Float64, Fmi3Causality, Fmi3Slave

INPUTS, OUTPUTS = 11, 3


class Regression(Fmi3Slave):
    """y_k = sum of (0.1 (k + 1) + 0.01 i) T_i."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time = 0.0
        self.register_variable(Float64("time", causality=Fmi3Causality.independent))
        for i in range(INPUTS):
            setattr(self, f"T{i}", 0.0)
            self.register_variable(Float64(f"T{i}", causality=Fmi3Causality.input, start=0.0))
        for k in range(OUTPUTS):
            setattr(self, f"y{k}", 0.0)
            self.register_variable(Float64(f"y{k}", causality=Fmi3Causality.output))
        self.weights = [[0.1 * (k + 1) + 0.01 * i for i in range(INPUTS)] for k in range(OUTPUTS)]

    def do_step(self, current_time, step_size):
        read = [getattr(self, f"T{i}") for i in range(INPUTS)]
        for k, row in enumerate(self.weights):
            setattr(self, f"y{k}", sum(w * t for w, t in zip(row, read, strict=True)))
        return True
