"""Further error models: those of the three studies, and others compared with them.

A plug-in like any other, installed with the product: ``fit`` has the fitting code, ``runtime`` the
code that runs in an FMU (standard library only), each model next to its C twin.
"""
