"""Turns modules of this project into FMUs: a fast slave, a bundle of modules, a complete package.

`variables` and `slave` are part of the FMUs and import only the standard library and pythonfmu;
the other modules run at build time.
"""
