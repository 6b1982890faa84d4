"""Error models beside the core's own: those of the three studies, and others tried against them.

A plug-in like any other, installed with the product: ``fit`` has what is fitted, ``runtime`` what
runs in an FMU, with the standard library only, each beside its twin in C.
"""
