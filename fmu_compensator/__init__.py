"""The compensator: temperatures and tool length in, axis offsets out.

`fit` learns a compensator file from measured runs. `runtime` reads that file and computes the
offsets; it imports the standard library only, so that it runs inside any FMI host.
"""
