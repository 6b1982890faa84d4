"""What the FMUs in C ask of a controller: `python -m benchmarks.controller`."""
