"""The regression as pythonfmu has it: a script for its own builder, and so for pythonfmu3's."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

INPUTS, OUTPUTS = 11, 3


class Regression(Fmi2Slave):
    """y_k = sum of (0.1 (k + 1) + 0.01 i) T_i."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for i in range(INPUTS):
            setattr(self, f"T{i}", 0.0)
            self.register_variable(Real(f"T{i}", causality=Fmi2Causality.input, start=0.0))
        for k in range(OUTPUTS):
            setattr(self, f"y{k}", 0.0)
            self.register_variable(Real(f"y{k}", causality=Fmi2Causality.output))
        self.weights = [[0.1 * (k + 1) + 0.01 * i for i in range(INPUTS)] for k in range(OUTPUTS)]

    def do_step(self, current_time, step_size):
        read = [getattr(self, f"T{i}") for i in range(INPUTS)]
        for k, row in enumerate(self.weights):
            setattr(self, f"y{k}", sum(w * t for w, t in zip(row, read, strict=True)))
        return True
