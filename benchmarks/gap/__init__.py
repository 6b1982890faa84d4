"""The gap finder's benchmark: cases from an independent simulator, answers, tables."""

import os

# Before numpy is there: one case keeps one core busy, and more threads would get in its way.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
