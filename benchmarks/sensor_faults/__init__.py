"""How good the detector of broken sensors is: planted faults found, false alarms on healthy runs.

``python -m benchmarks.sensor_faults.run --help`` says how to run it. Thresholds were set on the
part ``setting`` (simulated jig borers, every second run of a measured lathe), figures are of the
part ``report`` (the other lathe runs, a measured electric spindle, runs of the independent
simulator in ``benchmarks.gap.truth``).
"""
