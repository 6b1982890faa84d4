"""The studies' own experiment: learn on a spectrum of speeds, predict, compensate."""

import os

# Before numpy is there: every worker keeps one core busy, and more threads would get in its way.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
